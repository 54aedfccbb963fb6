//! A kOS client: what a program needs to control a device, without touching a machine.
//!
//! [`KosHost`] keeps passwords and moves where [`HostMachine`] only names them, and gives the answers of the device as
//! values. What else the machine tells is told as it is, by [`Event::Told`].
//!
//! ```
//! use kos_proto::host;
//! use kos_proto::message::{MotorAddress, Rotations, RotationsPerSecond, RotationsPerSecondSquared};
//! use motion_core::time::Millis;
//! use rigs::Scene;
//! use rigs::faults::{Carrier, Faults};
//! use rigs::kos_device::{KosDevice, Setup};
//! use rigs::kos_host::{Command, Event, KosHost};
//!
//! let (host, rig) = (KosHost::new(host::Options::default(), None), KosDevice::new(Setup::default()));
//! let mut scene = Scene::new(host, rig, Carrier::Stream, Faults::NONE, 1);
//! scene.command(Command::Connect);
//! let ready = scene.run(Millis(1000), |_, event| matches!(event, Event::Told(host::Event::Ready { .. })).then_some(()));
//! assert!(ready.is_some() && scene.host.motors().count() == 3);
//!
//! let go = host::Go {
//!     motor: MotorAddress(1),
//!     position: Rotations(5.0),
//!     speed: RotationsPerSecond(20.0),
//!     acceleration: RotationsPerSecondSquared(50.0),
//! };
//! scene.command(Command::Do(host::Command::Bump(go)));
//! let rests = scene.run(Millis(5000), |_, event| match event {
//!     Event::Told(host::Event::MotorRests(MotorAddress(1), at)) => Some(at),
//!     _ => None,
//! });
//! assert_eq!(rests, Some(Rotations(5.0)));
//! ```

mod party;
mod stored;

use std::collections::VecDeque;

use kos_proto::host::{self, Failure, Get, HostMachine, Input, MoveState, Options, Source};
use kos_proto::message::{
    AuxInputs, DeviceType, FirmwareVersion, LedMode, Motor, MotorAddress, NetworkInfo, Normalized, PlaybackMode,
    PlaybackState, Seconds,
};
use kos_proto::summary::{Direction, MotorSet};
use kos_proto::{DeviceMessage, Frames};
use motion_core::machine::Machine as _;
use motion_core::time::Millis;
use motion_core::wire::Password;
use tracing::debug;

use self::party::answer;
use crate::{LineId, Outgoing};

pub use stored::StoredMove;

const LINE: LineId = LineId(0);

/// What a client can be told to do.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Command {
    /// Be connected, and stay so.
    Connect,
    /// Say this password from now on, and now to a device that is locked.
    Unlock(Vec<u8>),
    /// Give the device another password.
    ChangePassword(Vec<u8>),
    /// Ask the device something: [`Event::Answer`] or [`Event::Unanswered`] follows.
    Ask(Get),
    /// Store a move, and make it ready.
    Load {
        /// The move.
        stored: StoredMove,
        /// Which way it will be played.
        way: Direction,
        /// Whether the motors stay where they are until it is played.
        delay_return: bool,
    },
    /// Store a move, and play it.
    PlayDirect {
        /// The move.
        stored: StoredMove,
        /// Which way.
        way: Direction,
    },
    /// What has no content of its own, such as a stop.
    Do(host::Command),
}

/// What a client tells.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// A question is answered.
    Answer(Answer),
    /// A question is not answered.
    Unanswered(Get, Failure),
    /// All that was to stop rests, and the device said so: of each motor that was or may have been moved from here, and
    /// of all that are known, if none was.
    Stopped,
    /// What the machine says.
    Told(host::Event),
}

/// What a device answers.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Answer {
    /// What it is, and what it does.
    Device(Device),
    /// Where it is.
    Network(NetworkInfo<'static>),
    /// Its motors.
    Motors(Vec<Motor>),
    /// Its lamps: its own, and that of its slave.
    Lamps(LedMode, LedMode),
    /// The move that it stored, if it has one that can be played.
    Move(Option<StoredMove>),
    /// Which of all devices it is; 16 bytes, or what else it has.
    Guid(Vec<u8>),
    /// The platform that calibrated its motors.
    Platform(u8),
}

/// What a device is, and what it does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Device {
    /// What it is.
    pub device_type: DeviceType,
    /// Its firmware.
    pub firmware: FirmwareVersion,
    /// Which kind of move it plays.
    pub mode: PlaybackMode,
    /// How far it is with it.
    pub state: PlaybackState,
    /// Its inputs.
    pub inputs: AuxInputs,
    /// Time until its move begins.
    pub remaining: Seconds,
    /// How much of its move is over.
    pub elapsed: Normalized,
}

/// A client over TCP.
#[derive(Debug)]
pub struct KosHost {
    machine: HostMachine,
    password: Vec<u8>,
    /// `None` while they are read.
    frames: Option<Box<Frames>>,
    is_open: bool,
    wake: Option<Millis>,
    token: u16,
    /// The motors that were set in motion from here since all was known to rest.
    moved: MotorSet,
    /// Whether the connection was lost while something moved, or a move ended before its end, or motors were sent home:
    /// then only a stop, or the end of the move, tells that all rest.
    unsure: bool,
    stopping: Option<Stopping>,
    outgoing: VecDeque<Outgoing>,
    events: VecDeque<Event>,
}

/// A stop of everything that is not over.
#[derive(Debug, Clone, Copy)]
struct Stopping {
    /// Whether the device said that it obeys. Motors that said before that they rest, may have meant something else.
    is_heard: bool,
    /// The motors that have not said yet that they rest.
    motors: MotorSet,
}

/// What a step of the machine needs beyond its input.
#[derive(Default)]
struct Content<'a> {
    message: Option<&'a DeviceMessage<'a>>,
    stored: Option<&'a StoredMove>,
    new_password: &'a [u8],
}

impl KosHost {
    /// A client without a connection. Without a password of its own it says the one that the device tells.
    #[must_use]
    pub fn new(options: Options, password: Option<&[u8]>) -> Self {
        Self {
            machine: HostMachine::new(options.with_echo_password(password.is_none())),
            password: password.unwrap_or_default().to_vec(),
            frames: Some(Box::new(Frames::new())),
            is_open: false,
            wake: None,
            token: 0,
            moved: MotorSet::NONE,
            unsure: false,
            stopping: None,
            outgoing: VecDeque::new(),
            events: VecDeque::new(),
        }
    }

    /// The machine, to look at.
    #[must_use]
    pub const fn machine(&self) -> &HostMachine {
        &self.machine
    }

    /// The motors of the device, as it said last.
    pub fn motors(&self) -> impl Iterator<Item = &Motor> {
        self.machine.motors()
    }

    /// A motor of the device, as it said last.
    #[must_use]
    pub fn motor(&self, motor: MotorAddress) -> Option<&Motor> {
        self.motors().find(|known| known.motor_address.number() == motor.number())
    }

    /// Whether something that was set in motion from here, or was to stop, is not known to rest. What others set in motion
    /// is theirs: see [`HostMachine::moves`].
    #[must_use]
    pub fn may_move(&self) -> bool {
        let moves = self.machine.moves() || self.unsure;
        self.stopping.is_some() || (moves && !self.moved.is_empty())
    }

    /// Bytes that it holds: of messages that are not whole, and of messages that nobody took yet.
    #[must_use]
    pub fn held(&self) -> usize {
        self.frames.as_ref().map_or(0, |frames| frames.held()) + crate::waiting(&self.outgoing)
    }

    /// The motors that a command sets in motion, if it is followed.
    fn sets_in_motion(&self, command: host::Command) -> MotorSet {
        match command {
            host::Command::MoveTo(go) | host::Command::Bump(go) => MotorSet::of([go.motor]),
            host::Command::Jog { motor, .. } => MotorSet::of([motor]),
            host::Command::Load { summary, delay_return: false, .. } | host::Command::PlayDirect { summary, .. } => {
                summary.motors
            }
            host::Command::Play | host::Command::RapidToFirstKeyFrame => self.all_motors(),
            _ => MotorSet::NONE,
        }
    }

    fn all_motors(&self) -> MotorSet {
        MotorSet::of(self.motors().map(|motor| MotorAddress(motor.motor_address.number())))
    }

    fn order(&mut self, now: Millis, command: host::Command, content: &Content<'_>) {
        if command == host::Command::Stop {
            let found = self.machine.move_state() != MoveState::NoMove;
            // Who moved nothing from here means everything.
            let all = self.unsure || found || self.moved.is_empty();
            let motors = if all { self.all_motors() } else { self.moved };
            self.stopping = Some(Stopping { is_heard: false, motors });
        }
        let moved = self.sets_in_motion(command);
        let refused = self.step(now, Input::Command(command), content);
        if !refused {
            moved.iter().for_each(|motor| self.moved.insert(motor));
            // Where it rests then is told, but not kept by the machine.
            self.unsure |= command == host::Command::RapidToFirstKeyFrame;
        }
    }

    /// Gives something to the machine, and does all that follows; whether it refused.
    fn step(&mut self, now: Millis, input: Input<'_>, content: &Content<'_>) -> bool {
        let before = (self.machine.moves(), self.machine.move_state());
        let (machine, output) = self.machine.clone().step(now, input);
        (self.machine, self.wake) = (machine, output.wake);
        let device_password = match content.message {
            Some(DeviceMessage::DeviceInfo(info)) => info.device_password,
            _ => Password(&[]),
        };
        let source = Source {
            device_password,
            user_password: Password(&self.password),
            new_password: Password(content.new_password),
            trajectory: content.stored.map(StoredMove::data).unwrap_or_default(),
        };
        for send in output.send.iter().filter(|send| **send != host::Send::Question) {
            let message = send.message(&source);
            debug!("says {message}");
            let mut bytes = vec![0; message.encoded_len()];
            match message.encode_into(&mut bytes) {
                Ok(_) => self.outgoing.push_back(Outgoing::Bytes(LINE, bytes)),
                Err(error) => tracing::warn!("cannot say {message}: {error}"),
            }
        }
        let mut refused = false;
        let mut again = false;
        for &event in &output.events {
            refused |= matches!(event, host::Event::Refused(_));
            again |= self.look(event, before);
            self.tell(event, content.message);
        }
        if again {
            self.order(now, host::Command::Stop, &Content::default());
        }
        self.settle();
        refused
    }

    /// Keeps in mind what may move; whether a stop has to be sent again.
    fn look(&mut self, event: host::Event, (moved, played): (bool, MoveState)) -> bool {
        match event {
            host::Event::Open(_) => self.outgoing.push_back(Outgoing::Open(LINE)),
            host::Event::Closed(_) => {
                self.unsure |= moved;
                if std::mem::take(&mut self.is_open) {
                    self.outgoing.push_back(Outgoing::HangUp(LINE));
                }
            }
            host::Event::MotorRests(motor, _) | host::Event::MotorOnline(motor, false) => {
                if let Some(stopping) = self.stopping.as_mut().filter(|stopping| stopping.is_heard) {
                    stopping.motors.remove(motor);
                }
            }
            host::Event::Move(host::Move::Finished { requested }) => {
                if let Some(stopping) = self.stopping.as_mut().filter(|_| requested) {
                    stopping.is_heard = true;
                } else if played.moves() {
                    // At its end all rest; elsewhere they are slowing down at best.
                    self.unsure = played != MoveState::Ended;
                }
            }
            host::Event::Move(host::Move::Home) => self.unsure = false,
            // The connection was lost behind the confirmation of a stop, before all motors said that they rest.
            host::Event::Ready { .. } => {
                return self.stopping.is_some() && self.machine.move_state() == MoveState::NoMove;
            }
            _ => {}
        }
        false
    }

    /// All rests, if it does.
    fn settle(&mut self) {
        // The machine knows whether the stop was heard.
        if self.stopping.is_some_and(|stopping| stopping.motors.is_empty()) && !self.machine.moves() {
            (self.stopping, self.moved, self.unsure) = (None, MotorSet::NONE, false);
            self.events.push_back(Event::Stopped);
        }
        if !self.may_move() {
            self.moved = MotorSet::NONE;
        }
    }

    /// Tells the application, with what the device said.
    fn tell(&mut self, event: host::Event, message: Option<&DeviceMessage<'_>>) {
        self.events.push_back(match event {
            host::Event::Failed(get, _, failure) => Event::Unanswered(get, failure),
            host::Event::Answered(Get::MotorInfo, _) => Event::Answer(Answer::Motors(self.motors().copied().collect())),
            event @ host::Event::Answered(..) => match message.and_then(answer) {
                Some(answer) => Event::Answer(answer),
                None => Event::Told(event),
            },
            event => Event::Told(event),
        });
    }
}
