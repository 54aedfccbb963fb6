//! kOS device: a [`DeviceMachine`] with motors in rotations, a camera, and up to four clients over TCP.
//!
//! The machine knows what the device answers and allows. The rig has the motors, the camera, what is stored, and the
//! connections. It cannot be reached over USB.
//!
//! The position of a motor stays at a reset, as with an encoder that keeps its count. The range of the motor is forgotten
//! then.

mod camera;
mod devices;
mod events;
mod motion;
mod playing;
mod rig;
mod setup;

use std::collections::VecDeque;
use std::sync::Arc;

use kos_proto::device::{
    Contents, Destination, DeviceMachine, Input, MotorSpecs, Report, SESSIONS, Scratch, Source, Transmit,
};
use kos_proto::message::{Bool, DeviceType, LedMode, MOTORS, MotorAddress, MotorSet, NetworkInfo, Password, Rotations};
use kos_proto::{Effect, Frames};
use motion_core::profile::Limits;
use motion_core::time::Millis;
use tracing::{debug, info, warn};

use self::camera::Camera;
use self::playing::Playing;
use crate::kos_host::StoredMove;
use crate::motor::Motor;
use crate::{LineId, Outgoing};

pub use camera::Photo;
pub use setup::{MotorSetup, Setup};

/// Simulated kOS device.
#[derive(Debug)]
pub struct KosDevice {
    setup: Setup,
    specs: Vec<MotorSpecs>,
    machine: DeviceMachine,
    lines: [Line; SESSIONS],
    motors: Vec<Motor>,
    drives: Vec<Drive>,
    playing: Option<Playing>,
    camera: Camera,
    store: Store,
    now: Millis,
    /// Time of the last step of the machine.
    stepped: Millis,
    /// Time at which the machine wants to be woken.
    wake: Option<Millis>,
    /// Time at which the device will run; `None` if it runs.
    starts: Option<Millis>,
    outgoing: VecDeque<Outgoing>,
}

/// Connection of a client.
#[derive(Debug, Default)]
struct Line {
    is_open: bool,
    frames: Option<Box<Frames>>,
}

/// State of a motor between the rig and the machine.
#[derive(Debug, Clone, Copy, Default)]
struct Drive {
    /// Position that the machine was told last.
    told: f32,
    /// Position to which a move sent the motor.
    goal: Option<f64>,
}

/// Data that the device stores. The move and the lamps are lost at a reset, and the rest stays.
#[derive(Debug, Clone)]
struct Store {
    password: Arc<[u8]>,
    platform: u8,
    trajectory: Option<StoredMove>,
    leds: (LedMode, LedMode),
}

impl KosDevice {
    /// Device that is switched on at time 0.
    #[must_use]
    pub fn new(setup: Setup) -> Self {
        let mut setup = setup;
        setup.motors.truncate(MOTORS);
        setup.options = setup.options.with_motors(MotorSet::of((1_u8..).map(MotorAddress).take(setup.motors.len())));
        let motors = setup.motors.iter().map(|motor| {
            let specs = motor.specs;
            let limits = Limits {
                velocity: f64::from(specs.max_max_move_speed.0.max(specs.max_max_setup_speed.0)),
                acceleration: f64::from(specs.max_max_acceleration.0),
                jerk: None,
            };
            motor.travel.map_or(Motor::new(limits), |travel| Motor::new(limits).within(travel))
        });
        Self {
            specs: setup.motors.iter().map(|motor| motor.specs).collect(),
            machine: DeviceMachine::new(setup.options),
            lines: Default::default(),
            motors: motors.collect(),
            drives: vec![Drive::default(); setup.motors.len()],
            playing: None,
            camera: Camera::default(),
            store: Store {
                password: setup.password.clone().into(),
                platform: setup.options.platform(),
                trajectory: None,
                leds: (LedMode::OFF, LedMode::OFF),
            },
            now: Millis(0),
            stepped: Millis(0),
            wake: None,
            starts: Some(Millis(0)),
            outgoing: VecDeque::new(),
            setup,
        }
    }

    /// Machine of the device, for reading its state.
    #[must_use]
    pub const fn machine(&self) -> &DeviceMachine {
        &self.machine
    }

    /// Number of photos that the camera took.
    #[must_use]
    pub const fn photo_count(&self) -> u64 {
        self.camera.count()
    }

    /// Last photos that the camera took, 4096 at most.
    pub fn photos(&self) -> impl Iterator<Item = &Photo> {
        self.camera.photos()
    }

    /// Password that is stored.
    #[must_use]
    pub fn password(&self) -> &[u8] {
        &self.store.password
    }

    /// Platform that is stored.
    #[must_use]
    pub const fn platform(&self) -> u8 {
        self.store.platform
    }

    /// Move that is stored.
    #[must_use]
    pub const fn stored_move(&self) -> Option<&StoredMove> {
        self.store.trajectory.as_ref()
    }

    /// Modes of the lamp of the device, and of the lamp of its slave.
    #[must_use]
    pub const fn leds(&self) -> (LedMode, LedMode) {
        self.store.leds
    }

    /// Number of bytes that wait: for the rest of their message, or to be taken.
    #[must_use]
    pub fn held(&self) -> usize {
        let frames = self.lines.iter().filter_map(|line| line.frames.as_ref()).map(|frames| frames.held());
        frames.sum::<usize>() + crate::waiting(&self.outgoing)
    }

    /// Whether the device runs.
    const fn runs(&self) -> bool {
        self.starts.is_none()
    }

    fn motor(&mut self, motor: MotorAddress) -> Option<(&mut Motor, &mut Drive)> {
        let index = usize::from(motor.number()).checked_sub(1)?;
        self.motors.get_mut(index).zip(self.drives.get_mut(index))
    }

    /// Addresses of the motors.
    fn addresses(&self) -> impl Iterator<Item = MotorAddress> + use<> {
        (1_u8..).map(MotorAddress).take(self.motors.len())
    }

    /// Reports to the machine what happened.
    fn report(&mut self, now: Millis, report: Report) {
        if self.runs() {
            self.sync();
            self.step(now, Input::Rig(report));
        }
    }

    /// Tells the machine the positions of the motors, at the time of its last step, so that no deadline comes by it.
    fn sync(&mut self) {
        for address in self.addresses() {
            let now = self.now;
            let Some((motor, drive)) = self.motor(address) else { continue };
            let position = rotations(motor.at(now).position);
            if position.0.to_bits() != drive.told.to_bits() {
                drive.told = position.0;
                let stepped = self.stepped;
                self.step(stepped, Input::Rig(Report::At(address, position)));
            }
        }
    }

    /// Gives an input to the machine, and carries out the effects.
    fn step(&mut self, now: Millis, input: Input<'_>) {
        let output = self.machine.advance(now, input);
        (self.wake, self.stepped) = (output.wake, now);
        for effect in output {
            match effect {
                Effect::Event(event) => self.event(now, &event),
                Effect::Transmit(transmit) => self.transmit(&transmit),
            }
        }
    }

    fn transmit(&mut self, transmit: &Transmit<'_>) {
        match transmit.contents {
            Contents::ErrorStatus { code, motor: MotorAddress::ALL } => info!("error: {code}"),
            Contents::ErrorStatus { code, motor } => info!("error of motor {motor}: {code}"),
            Contents::MotorCalibrated { motor, begin, end } if end.0 != 0.0 => {
                info!("motor {motor} has a range from {} to {}", begin.0, end.0);
            }
            Contents::MotorCalibrated { motor, .. } => info!("motor {motor} has no range"),
            _ => {}
        }
        let bytes = self.encoded(transmit);
        match transmit.destination {
            Destination::Broadcast => self.outgoing.push_back(Outgoing::Announce(bytes)),
            Destination::Datagram(to) => self.outgoing.push_back(Outgoing::Datagram(to.into(), bytes)),
            Destination::Sessions(sessions) => {
                for session in sessions.iter() {
                    if self.lines.get(usize::from(session.0)).is_some_and(|line| line.is_open) {
                        self.outgoing.push_back(Outgoing::Bytes(LineId(session.0), bytes.clone()));
                    }
                }
            }
        }
    }

    fn encoded(&self, transmit: &Transmit<'_>) -> Vec<u8> {
        let number = self.setup.number.to_be_bytes();
        let [.., n3, n4, n5, n6, n7] = number;
        let guid = [*b"kOSrig\x40\x00", number].concat();
        let network = NetworkInfo {
            dhcp: Bool::TRUE,
            // The first byte says that the address is administered locally.
            mac_address: [2, n3, n4, n5, n6, n7].into(),
            ip_address: self.setup.address.into(),
            device_type: DeviceType::SECOND_SHOOTER_PRO,
            ..NetworkInfo::default()
        };
        let end = if self.setup.nul_terminated { &b"\0"[..] } else { &[] };
        let password = [&self.store.password, end].concat();
        let mut source = Source {
            older_dialect: self.setup.older_dialect,
            device_type: DeviceType::SECOND_SHOOTER_PRO,
            firmware_version: self.setup.firmware,
            network,
            guid: &guid,
            password: Password(&password),
            motors: &self.specs,
            ..Source::default()
        };
        if let (Contents::TrajectoryData { .. }, Some(stored)) = (&transmit.contents, &self.store.trajectory) {
            source.trajectory = stored.data();
        }
        let mut scratch = Scratch::default();
        let message = transmit.message(&source, &mut scratch);
        debug!("> {message}");
        let mut bytes = vec![0; message.encoded_len()];
        match message.encode_into(&mut bytes) {
            Ok(len) => bytes.truncate(len),
            Err(error) => {
                warn!("cannot send {message}: {error}");
                bytes.clear();
            }
        }
        bytes
    }
}

#[expect(clippy::cast_possible_truncation, reason = "rounds to the nearest; the protocol has no other number")]
fn rotations(position: f64) -> Rotations {
    Rotations(position as f32)
}
