//! Setup of a device: its parts and its behaviour.

use std::net::Ipv4Addr;

use kos_proto::device::{MotorSpecs, Options, Quirks};
use kos_proto::message::{
    ActionId, AxisKind, FirmwareVersion, MOTORS, MotorType, RotationsPerSecond, RotationsPerSecondSquared,
};
use motion_core::trajectory::Range;

/// Setup of a device: its parts, what it stores at first, and its quirks.
///
/// ```
/// use motion_rigs::device::Named;
/// use motion_rigs::kos_device::Setup;
///
/// let setup = Setup { password: b"gaffer".to_vec(), ..Setup::with_motors(2) }.with_quirks("older-dialect")?;
/// assert!(setup.older_dialect && setup.motors.len() == 2);
/// # Ok::<(), motion_rigs::device::UnknownName>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// Options of the machine. Its motors are those of [`motors`](Self::motors).
    pub options: Options,
    /// Whether the device speaks the older dialect.
    pub older_dialect: bool,
    /// Whether texts end with a NUL.
    pub nul_terminated: bool,
    /// Version of the firmware.
    pub firmware: FirmwareVersion,
    /// Password that is stored; empty for none.
    pub password: Vec<u8>,
    /// Motors, motor 1 first: at most ten.
    pub motors: Vec<MotorSetup>,
    /// Address in the network, as the device tells it; 0.0.0.0 if it does not know its address.
    pub address: Ipv4Addr,
    /// Number that no other device has. The hardware address and the GUID are made from it.
    pub number: u64,
}

/// Motor of a device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotorSetup {
    /// Axis that the motor turns.
    pub kind: AxisKind,
    /// Type and limits of the motor.
    pub specs: MotorSpecs,
    /// Ends of the travel, in rotations from where the motor is at first; `None` if the motor can go anywhere.
    pub travel: Option<Range>,
}

impl MotorSetup {
    /// Motor with the limits that the specification gives for such an axis. It can go anywhere.
    #[must_use]
    pub fn new(kind: AxisKind) -> Self {
        let speed = kind.max_speed().unwrap_or(RotationsPerSecond(200.0));
        let acceleration = kind.max_acceleration().unwrap_or(RotationsPerSecondSquared(50.0));
        let fiz = matches!(kind, AxisKind::Focus | AxisKind::Iris | AxisKind::Zoom);
        let specs = MotorSpecs {
            motor_type: if fiz { MotorType::FIZ } else { MotorType::AXIS },
            max_max_setup_speed: speed,
            max_max_move_speed: speed,
            max_max_acceleration: acceleration,
        };
        Self { kind, specs, travel: None }
    }

    /// The same motor with two ends of its travel.
    #[must_use]
    pub const fn within(self, travel: Range) -> Self {
        Self { travel: Some(travel), ..self }
    }
}

impl Default for Setup {
    /// Device with a slider and a head, without a password.
    fn default() -> Self {
        Self::with_motors(3)
    }
}

impl Setup {
    /// Newest version of the firmware that a public client met.
    pub(super) const FIRMWARE: FirmwareVersion = FirmwareVersion([1, 0, 1, 16]);

    /// Device with a number of motors, at most ten: slider, pan, tilt, focus, zoom, and more sliders.
    #[must_use]
    pub fn with_motors(count: usize) -> Self {
        let head = [AxisKind::Slider, AxisKind::Pan, AxisKind::Tilt, AxisKind::Focus, AxisKind::Zoom];
        let kinds = head.into_iter().chain(std::iter::repeat(AxisKind::Slider));
        Self {
            options: Options::default(),
            older_dialect: false,
            nul_terminated: false,
            firmware: Self::FIRMWARE,
            password: Vec::new(),
            motors: kinds.map(MotorSetup::new).take(count.min(MOTORS)).collect(),
            address: Ipv4Addr::UNSPECIFIED,
            number: 1,
        }
    }

    /// Takes an action away from those that the device knows.
    pub(super) fn forget(&mut self, action: ActionId) {
        self.options = self.options.with_unsupported(self.options.unsupported().with(action));
    }

    pub(super) fn add(&mut self, quirk: Quirks) {
        self.options = self.options.with_quirks(self.options.quirks() | quirk);
    }
}
