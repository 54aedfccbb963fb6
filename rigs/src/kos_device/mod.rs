//! kOS device: a [`Session`] with motors in rotations, a camera, and up to four clients over TCP.
//!
//! The session knows what the device answers and allows. The rig has the motors, the camera, what is stored, and the
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
mod store;

use std::collections::VecDeque;

use kos_proto::EncodeError;
use kos_proto::device::{Destination, DeviceMachine, Event, MotorSpecs, Next, Report, SESSIONS, Session, SessionId};
use kos_proto::message::{LedMode, MOTORS, MotorAddress, MotorSet, Rotations};
use motion_core::profile::Limits;
use motion_core::time::Millis;
use tracing::{info, warn};

use self::camera::Camera;
use self::playing::Playing;
use self::store::Store;
use crate::kos_host::{StoredMove, Tap};
use crate::motor::Motor;
use crate::{LineId, Outgoing};

pub use camera::Photo;
pub use setup::{MotorSetup, Setup};

/// Simulated kOS device.
#[derive(Debug)]
pub struct KosDevice {
    setup: Setup,
    specs: Vec<MotorSpecs>,
    session: Box<Session>,
    /// Listeners on the lines that are open.
    lines: [Option<Tap>; SESSIONS],
    motors: Vec<Motor>,
    drives: Vec<Drive>,
    playing: Option<Playing>,
    camera: Camera,
    store: Store,
    now: Millis,
    /// Time up to which the session did everything.
    done: Millis,
    /// Time at which the session wants to be woken.
    wake: Option<Millis>,
    /// Time at which the device will run; `None` if it runs.
    starts: Option<Millis>,
    outgoing: VecDeque<Outgoing>,
    /// Room for a message.
    room: Vec<u8>,
}

/// State of a motor between the rig and the session.
#[derive(Debug, Clone, Copy, Default)]
struct Drive {
    /// Position that the session was told last.
    told: f32,
    /// Position to which a move sent the motor.
    goal: Option<f64>,
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
            session: Box::new(Session::new(DeviceMachine::new(setup.options))),
            lines: Default::default(),
            motors: motors.collect(),
            drives: vec![Drive::default(); setup.motors.len()],
            playing: None,
            camera: Camera::default(),
            store: Store::new(&setup),
            now: Millis(0),
            done: Millis(0),
            wake: None,
            starts: Some(Millis(0)),
            outgoing: VecDeque::new(),
            room: Vec::new(),
            setup,
        }
    }

    /// Machine of the device, for reading its state.
    #[must_use]
    pub const fn machine(&self) -> &DeviceMachine {
        self.session.machine()
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
        self.store.password(&self.setup)
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
        self.session.held() + crate::waiting(&self.outgoing)
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

    /// Tells the session what happened.
    fn report(&mut self, now: Millis, report: Report) {
        if self.runs() {
            self.sync();
            self.told(report);
            self.work(now);
        }
    }

    fn told(&mut self, report: Report) {
        if let Err(why) = self.session.report(report) {
            warn!("{report:?}: {why}");
        }
    }

    /// Tells the session the positions of the motors, at the time of its last step, so that no deadline comes by it.
    fn sync(&mut self) {
        let now = self.now;
        for address in self.addresses() {
            let Some((motor, drive)) = self.motor(address) else { continue };
            let position = rotations(motor.at(now).position);
            if position.0.to_bits() != drive.told.to_bits() {
                drive.told = position.0;
                self.told(Report::At(address, position));
            }
        }
        self.work(self.done);
    }

    /// Does everything that follows now.
    fn work(&mut self, now: Millis) {
        self.done = now;
        loop {
            let source = self.store.source(&self.setup, &self.specs);
            match self.session.poll(now, &source, &mut self.room) {
                Ok(Next::Event(Event::StorePassword(password))) => {
                    info!("another password is stored");
                    self.store.set_password(password.0, &self.setup);
                }
                Ok(Next::Event(Event::StoreTrajectory(data))) => {
                    info!("a move is stored");
                    self.store.trajectory = StoredMove::new(&data).ok();
                }
                Ok(Next::Event(event)) => {
                    if let Some(event) = event.to_static() {
                        self.event(now, &event);
                    }
                }
                Ok(Next::Transmit(to, bytes)) => {
                    events::said(bytes);
                    match to {
                        Destination::Broadcast => self.outgoing.push_back(Outgoing::Announce(bytes.to_vec())),
                        Destination::Datagram(to) => {
                            self.outgoing.push_back(Outgoing::Datagram(to.into(), bytes.to_vec()));
                        }
                        Destination::Sessions(sessions) => {
                            let bytes_to = |session: SessionId| Outgoing::Bytes(LineId(session.0), bytes.to_vec());
                            self.outgoing.extend(sessions.iter().map(bytes_to));
                        }
                    }
                }
                Ok(Next::Wait(until)) => break self.wake = until,
                Err(EncodeError::BufferTooSmall { needed, .. }) => self.room.resize(needed, 0),
                Err(error) => warn!("a message cannot be sent: {error}"),
            }
        }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "rounds to the nearest; the protocol has no other number")]
fn rotations(position: f64) -> Rotations {
    Rotations(position as f32)
}
