//! A kOS device: motors in rotations, a camera, and up to four clients over TCP.
//!
//! What it answers and allows is the business of [`DeviceMachine`]; here are the motors that it moves, the camera, what
//! it stores, and its connections. Over USB it cannot be reached.
//!
//! The count of a motor outlives a reset, as that of an encoder does that keeps it: it stands for the place. The range
//! of a motor is forgotten then.

mod camera;
mod doing;
mod motion;
mod playing;
mod rig;
mod setup;

use std::collections::VecDeque;
use std::sync::Arc;

use kos_proto::device::{DeviceMachine, Input, MotorProfile, Profile, Report, SESSIONS, Scratch, Send, To, What};
use kos_proto::message::{DeviceType, FirmwareVersion, LedMode, MotorAddress, NetworkInfo, Rotations};
use kos_proto::summary::MotorSet;
use kos_proto::{Frame, Frames};
use motion_core::machine::Machine as _;
use motion_core::profile::Limits;
use motion_core::time::Millis;
use motion_core::wire::{Bool, Password};
use tracing::{debug, info, warn};

use self::camera::Camera;
use self::playing::Playing;
use crate::kos_host::StoredMove;
use crate::motor::Motor;
use crate::{LineId, Outgoing};

pub use camera::Photo;
pub use setup::{MotorSetup, QuirkError, Setup};

/// A simulated kOS device.
#[derive(Debug)]
pub struct KosDevice {
    setup: Setup,
    profiles: Vec<MotorProfile>,
    machine: DeviceMachine,
    lines: [Line; SESSIONS],
    motors: Vec<Motor>,
    drives: Vec<Drive>,
    playing: Option<Playing>,
    camera: Camera,
    store: Store,
    /// The last moment that it was told of.
    now: Millis,
    /// The moment of the last step of the machine, and when it wants the next.
    stepped: Millis,
    wake: Option<Millis>,
    /// When it runs, if it does not.
    starts: Option<Millis>,
    outgoing: VecDeque<Outgoing>,
}

#[derive(Debug, Default)]
struct Line {
    is_open: bool,
    frames: Option<Box<Frames>>,
}

/// What the rig knows of a motor for the machine.
#[derive(Debug, Clone, Copy, Default)]
struct Drive {
    /// Where the machine takes it to be.
    told: f32,
    /// Where it was sent by a move, and should be when it rests.
    goal: Option<f64>,
}

/// What outlives a reset; but for the move and the lamps, which do not.
#[derive(Debug, Clone)]
struct Store {
    password: Arc<[u8]>,
    platform: u8,
    trajectory: Option<StoredMove>,
    leds: (LedMode, LedMode),
}

impl KosDevice {
    /// A device that is switched on at moment 0.
    #[must_use]
    pub fn new(setup: Setup) -> Self {
        let mut setup = setup;
        setup.motors.truncate(kos_proto::summary::MOTORS);
        setup.options = setup.options.with_motors(MotorSet::of((1_u8..).map(MotorAddress).take(setup.motors.len())));
        let motors = setup.motors.iter().map(|motor| {
            let profile = motor.profile;
            let limits = Limits {
                velocity: f64::from(profile.max_max_move_speed.0.max(profile.max_max_setup_speed.0)),
                acceleration: f64::from(profile.max_max_acceleration.0),
                jerk: None,
            };
            motor.travel.map_or(Motor::new(limits), |travel| Motor::new(limits).within(travel))
        });
        Self {
            profiles: setup.motors.iter().map(|motor| motor.profile).collect(),
            machine: DeviceMachine::new(setup.options),
            lines: Default::default(),
            motors: motors.collect(),
            drives: vec![Drive::default(); setup.motors.len()],
            playing: None,
            camera: Camera::default(),
            store: Store {
                password: setup.password.clone().into(),
                platform: setup.options.platform,
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

    /// The machine, to look at.
    #[must_use]
    pub const fn machine(&self) -> &DeviceMachine {
        &self.machine
    }

    /// How many photos it took.
    #[must_use]
    pub const fn photo_count(&self) -> u64 {
        self.camera.count()
    }

    /// The last photos that it took, 4096 at most.
    pub fn photos(&self) -> impl Iterator<Item = &Photo> {
        self.camera.photos()
    }

    /// The stored password.
    #[must_use]
    pub fn password(&self) -> &[u8] {
        &self.store.password
    }

    /// The stored platform.
    #[must_use]
    pub const fn platform(&self) -> u8 {
        self.store.platform
    }

    /// The stored move.
    #[must_use]
    pub const fn stored_move(&self) -> Option<&StoredMove> {
        self.store.trajectory.as_ref()
    }

    /// The lamps of the device and of its slave.
    #[must_use]
    pub const fn leds(&self) -> (LedMode, LedMode) {
        self.store.leds
    }

    /// Bytes that it holds: of messages that are not whole, and of messages that nobody took yet.
    #[must_use]
    pub fn held(&self) -> usize {
        let frames = self.lines.iter().filter_map(|line| line.frames.as_ref()).map(|frames| frames.held());
        frames.sum::<usize>() + crate::waiting(&self.outgoing)
    }

    /// Whether it is on.
    const fn runs(&self) -> bool {
        self.starts.is_none()
    }

    fn motor(&mut self, motor: MotorAddress) -> Option<(&mut Motor, &mut Drive)> {
        let index = usize::from(motor.number()).checked_sub(1)?;
        self.motors.get_mut(index).zip(self.drives.get_mut(index))
    }

    /// The motors by their addresses.
    fn addresses(&self) -> impl Iterator<Item = MotorAddress> + use<> {
        (1_u8..).map(MotorAddress).take(self.motors.len())
    }

    /// Tells the machine what happened.
    fn report(&mut self, now: Millis, report: Report) {
        if self.runs() {
            self.sync();
            self.step(now, Input::Rig(report), None);
        }
    }

    /// Tells the machine where the motors are, as of its last step, so that nothing follows from it but that.
    fn sync(&mut self) {
        for motor in self.addresses() {
            let now = self.now;
            let Some((it, drive)) = self.motor(motor) else { continue };
            let position = rotations(it.at(now).position);
            if position.0.to_bits() != drive.told.to_bits() {
                drive.told = position.0;
                let stepped = self.stepped;
                self.step(stepped, Input::Rig(Report::At(motor, position)), None);
            }
        }
    }

    /// Gives something to the machine, and does all that follows; `given` is the message in it.
    fn step(&mut self, now: Millis, input: Input<'_>, given: Option<&Frame<'_>>) {
        let (machine, output) = self.machine.clone().step(now, input);
        (self.machine, self.wake, self.stepped) = (machine, output.wake, now);
        for &event in &output.events {
            self.happens(now, event, given);
        }
        for send in &output.send {
            self.send(send, given);
        }
    }

    fn send(&mut self, send: &Send, given: Option<&Frame<'_>>) {
        match send.what {
            What::ErrorStatus { code, motor: MotorAddress::ALL } => info!("tells an error: {code}"),
            What::ErrorStatus { code, motor } => info!("tells an error of motor {motor}: {code}"),
            What::MotorCalibrated { motor, begin, end } if end.0 != 0.0 => {
                info!("motor {motor} has a range from {} to {}", begin.0, end.0);
            }
            What::MotorCalibrated { motor, .. } => info!("motor {motor} has no range"),
            _ => {}
        }
        let bytes = self.encoded(send, given);
        match send.to {
            To::Broadcast => self.outgoing.push_back(Outgoing::Announce(bytes)),
            To::Asker => self.outgoing.push_back(Outgoing::Answer(bytes)),
            To::Sessions(sessions) => {
                for session in sessions.iter() {
                    if self.lines.get(usize::from(session.0)).is_some_and(|line| line.is_open) {
                        self.outgoing.push_back(Outgoing::Bytes(LineId(session.0), bytes.clone()));
                    }
                }
            }
        }
    }

    fn encoded(&self, send: &Send, given: Option<&Frame<'_>>) -> Vec<u8> {
        let number = self.setup.number.to_be_bytes();
        let [.., n3, n4, n5, n6, n7] = number;
        let guid = [*b"kOSrig\x40\x00", number].concat();
        let network = NetworkInfo {
            dhcp: Bool::TRUE,
            // The second bit says that nobody but its owner gave it.
            mac_address: [2, n3, n4, n5, n6, n7].into(),
            ip_address: self.setup.address.into(),
            device_type: DeviceType::SECOND_SHOOTER_PRO,
            ..Profile::default().network
        };
        let mut profile = Profile {
            older_dialect: self.setup.older_dialect,
            device_type: DeviceType::SECOND_SHOOTER_PRO,
            firmware_version: FirmwareVersion([1, 0, 1, 16]),
            network,
            guid: &guid,
            password: Password(&self.store.password),
            motors: &self.profiles,
            received: given.map_or(&[], |frame| frame.bytes()),
            ..Profile::default()
        };
        if let (What::TrajectoryData { .. }, Some(stored)) = (&send.what, &self.store.trajectory) {
            profile.trajectory = stored.data();
        }
        let mut scratch = Scratch::default();
        let message = send.message(&profile, &mut scratch);
        debug!("says {message}");
        let mut bytes = vec![0; message.encoded_len()];
        match message.encode_into(&mut bytes) {
            Ok(len) => bytes.truncate(len),
            Err(error) => {
                warn!("cannot say {message}: {error}");
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
