//! Setup of a device: its parts and its behaviour.

use std::net::Ipv4Addr;

use kos_proto::device::{MotorSpecs, Options, Quirks};
use kos_proto::message::{AxisKind, MOTORS, MotorType, RotationsPerSecond, RotationsPerSecondSquared};
use motion_core::trajectory::Range;

/// Setup of a device: its parts, what it stores at first, and its quirks.
///
/// ```
/// use rigs::kos_device::Setup;
///
/// let setup = Setup { password: b"gaffer".to_vec(), ..Setup::with_motors(2) }.with_quirks("older-dialect")?;
/// assert!(setup.older_dialect && setup.motors.len() == 2);
/// # Ok::<(), rigs::kos_device::QuirkError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// Options of the machine. Its motors are those of [`motors`](Self::motors).
    pub options: Options,
    /// Whether the device speaks the older dialect.
    pub older_dialect: bool,
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
        Self { specs, travel: None }
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

/// Name that is not the name of a quirk.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("a kOS device has no quirk {0:?}: it has {QUIRKS}", QUIRKS = names())]
pub struct QuirkError(String);

type Quirk = fn(&mut Setup);

const QUIRKS: [(&str, Quirk); 6] = [
    ("older-dialect", |setup| setup.older_dialect = true),
    ("begin-nonzero", |setup| setup.add(Quirks::BEGIN_NONZERO)),
    ("empty-password", |setup| setup.add(Quirks::REQUIRE_EMPTY_PASSWORD)),
    ("stop-when-alone", |setup| setup.options = setup.options.with_stop_when_alone(true)),
    ("push-address", |setup| setup.options = setup.options.with_push_every(Some(5000))),
    ("no-progress", |setup| setup.options = setup.options.with_progress_every(None)),
];

fn names() -> String {
    QUIRKS.map(|(name, _)| name).join(", ")
}

impl Setup {
    /// Device with a number of motors, at most ten: slider, pan, tilt, focus, zoom, and more sliders.
    #[must_use]
    pub fn with_motors(count: usize) -> Self {
        let head = [AxisKind::Slider, AxisKind::Pan, AxisKind::Tilt, AxisKind::Focus, AxisKind::Zoom];
        let kinds = head.into_iter().chain(std::iter::repeat(AxisKind::Slider));
        Self {
            options: Options::default(),
            older_dialect: false,
            password: Vec::new(),
            motors: kinds.map(MotorSetup::new).take(count.min(MOTORS)).collect(),
            address: Ipv4Addr::UNSPECIFIED,
            number: 1,
        }
    }

    /// The same device with the quirks of a list such as `older-dialect,no-progress`.
    ///
    /// - `older-dialect`: the device speaks the older dialect.
    /// - `begin-nonzero`: the count of positions stays when a range is marked.
    /// - `empty-password`: the password has to be told, although it is empty.
    /// - `stop-when-alone`: a move is stopped when the last client is gone.
    /// - `push-address`: the address is told over TCP every five seconds.
    /// - `no-progress`: the progress of a live move is not reported.
    ///
    /// # Errors
    ///
    /// [`QuirkError`], which names all quirks.
    pub fn with_quirks(mut self, text: &str) -> Result<Self, QuirkError> {
        for name in text.split(',').map(str::trim) {
            let (_, quirk) =
                QUIRKS.iter().find(|(known, _)| *known == name).ok_or_else(|| QuirkError(name.to_owned()))?;
            quirk(&mut self);
        }
        Ok(self)
    }

    fn add(&mut self, quirk: Quirks) {
        self.options = self.options.with_quirks(self.options.quirks() | quirk);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_quirk_has_a_name() {
        let all = Setup::default().with_quirks(&names()).unwrap();
        assert!(all.older_dialect && all.options.stop_when_alone());
        assert_eq!(all.options.quirks(), Quirks::BEGIN_NONZERO | Quirks::REQUIRE_EMPTY_PASSWORD);
        assert_eq!((all.options.push_every(), all.options.progress_every()), (Some(5000), None));
        let error = Setup::default().with_quirks("loud").unwrap_err().to_string();
        assert!(error.starts_with("a kOS device has no quirk \"loud\": it has older-dialect, "), "{error}");
        assert_eq!(Setup::with_motors(99).motors.len(), 10);
    }
}
