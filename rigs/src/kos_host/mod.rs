//! Client of a kOS device: a [`HostMachine`] with a line.
//!
//! [`KosHost`] keeps the passwords and moves that the machine only names, and turns the answers of the device into values.
//! Each command has a [`Token`]. Its end is an [`Event::Answer`], or `Ended` in an [`Event::Machine`].
//!
//! ```
//! use kos_proto::host::{self, Outcome, Token};
//! use kos_proto::message::{MotorAddress, Rotations, RotationsPerSecond, RotationsPerSecondSquared};
//! use motion_core::time::Millis;
//! use motion_rigs::Scene;
//! use motion_rigs::faults::{Carrier, Faults};
//! use motion_rigs::kos_device::{KosDevice, Setup};
//! use motion_rigs::kos_host::{Command, Event, KosHost};
//!
//! let (host, rig) = (KosHost::new(host::Options::default(), None), KosDevice::new(Setup::default()));
//! let mut scene = Scene::new(host, rig, Carrier::Stream, Faults::NONE, 1);
//! scene.command((Token(1), Command::Connect));
//! let is_ready = |event| matches!(event, Event::Machine(host::Event::Ready { .. }));
//! scene.run(Millis(1000), |_, event| is_ready(event).then_some(())).expect("a device that answers");
//! assert_eq!(scene.host.machine().motors().count(), 3);
//!
//! let go = host::Go {
//!     motor: MotorAddress(1),
//!     position: Rotations(5.0),
//!     speed: RotationsPerSecond(20.0),
//!     acceleration: RotationsPerSecondSquared(50.0),
//! };
//! scene.command((Token(2), Command::Machine(host::Command::Bump(go))));
//! let outcome = scene.run(Millis(5000), |_, event| match event {
//!     Event::Machine(host::Event::Ended { token: Token(2), outcome }) => Some(outcome),
//!     _ => None,
//! });
//! assert_eq!(outcome, Some(Outcome::Done(None)));
//! assert_eq!(scene.host.motor(MotorAddress(1)).map(|motor| motor.position), Some(Rotations(5.0)));
//! ```

mod answer;
mod party;
mod stored;

use std::collections::VecDeque;

use kos_proto::host::{self, HostMachine, Input, Options, Outcome, PasswordOf, Source, Token, Transmit};
use kos_proto::message::{Motor, MotorAddress, Password};
use kos_proto::{Effect, Frames, HostMessage};
use motion_core::time::Millis;
use tracing::{debug, warn};

use crate::{LineId, Outgoing};

pub use answer::{Answer, Device};
pub use stored::StoredMove;

/// Line of the client.
const LINE: LineId = LineId(0);

/// Command to a client.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Command {
    /// Connects to the device of the line, and keeps connected.
    Connect,
    /// Uses this password from now on, and tells it to a device that is locked.
    Unlock(Vec<u8>),
    /// Gives the device a new password.
    ChangePassword(Vec<u8>),
    /// Stores a move and makes it ready.
    Load {
        /// Move to store.
        stored: StoredMove,
        /// Whether the motors stay where they are until the move is played.
        delay_return: bool,
    },
    /// Stores a move and plays it.
    PlayDirect {
        /// Move to store.
        stored: StoredMove,
    },
    /// Command of the machine without data that the machine does not keep, such as a stop or a question.
    Machine(host::Command),
}

/// Event of a client.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// The device answered the question with this token.
    Answer(Token, Answer),
    /// The machine tells something else. Messages that answer nothing are left out.
    Machine(host::Event<'static>),
}

/// Client over TCP.
#[derive(Debug)]
pub struct KosHost {
    machine: HostMachine,
    password: Vec<u8>,
    /// Frames that arrive; `None` while they are read.
    frames: Option<Box<Frames>>,
    is_open: bool,
    wake: Option<Millis>,
    outgoing: VecDeque<Outgoing>,
    events: VecDeque<Event>,
}

/// Data of a command that the machine does not keep.
#[derive(Default)]
struct Content<'a> {
    stored: Option<&'a StoredMove>,
    new_password: &'a [u8],
}

impl KosHost {
    /// Client without a connection. Without a password of its own, it sends the one that the device tells.
    #[must_use]
    pub fn new(options: Options, password: Option<&[u8]>) -> Self {
        Self {
            machine: HostMachine::new(options.with_echo_password(password.is_none())),
            password: password.unwrap_or_default().to_vec(),
            frames: Some(Box::new(Frames::new())),
            is_open: false,
            wake: None,
            outgoing: VecDeque::new(),
            events: VecDeque::new(),
        }
    }

    /// Machine of the client, for reading its state.
    #[must_use]
    pub const fn machine(&self) -> &HostMachine {
        &self.machine
    }

    /// Motor of the device, as the device reported it last.
    #[must_use]
    pub fn motor(&self, motor: MotorAddress) -> Option<&Motor> {
        self.machine.motors().find(|known| known.motor_address.number() == motor.number())
    }

    /// Number of bytes that wait: for the rest of their message, or to be taken.
    #[must_use]
    pub fn held(&self) -> usize {
        self.frames.as_ref().map_or(0, |frames| frames.held()) + crate::waiting(&self.outgoing)
    }

    /// Gives an input to the machine, and carries out the effects.
    fn step(&mut self, now: Millis, input: Input<'_>, content: &Content<'_>) {
        let output = self.machine.advance(now, input);
        self.wake = output.wake;
        for effect in output {
            match effect {
                // The address of the device is known to the owner of the line.
                Effect::Transmit(Transmit::Discover) => {}
                Effect::Transmit(transmit) => self.transmit(&transmit, content),
                Effect::Event(event) => self.event(&event),
            }
        }
    }

    fn transmit(&mut self, transmit: &Transmit<'_>, content: &Content<'_>) {
        if *transmit == Transmit::UserPassword(PasswordOf::New) {
            self.password = content.new_password.to_vec();
        }
        let source = Source {
            user_password: Password(&self.password),
            new_password: Password(content.new_password),
            trajectory: content.stored.map(StoredMove::data).unwrap_or_default(),
        };
        let message = transmit.message(&source);
        debug!("> {message}");
        let bytes = encoded(&message);
        self.outgoing.extend(bytes.map(|bytes| Outgoing::Bytes(LINE, bytes)));
    }

    fn event(&mut self, event: &host::Event<'_>) {
        match *event {
            host::Event::Connect(_) => self.outgoing.push_back(Outgoing::Open(LINE)),
            host::Event::LinkDown(_) if std::mem::take(&mut self.is_open) => {
                self.outgoing.push_back(Outgoing::HangUp(LINE));
            }
            _ => {}
        }
        self.events.extend(match *event {
            host::Event::Ended { token, outcome: Outcome::Done(Some(message)) } => {
                self.answer(&message).map(|answer| Event::Answer(token, answer))
            }
            event => event.to_static().map(Event::Machine),
        });
    }
}

fn encoded(message: &HostMessage<'_>) -> Option<Vec<u8>> {
    let mut bytes = vec![0; message.encoded_len()];
    match message.encode_into(&mut bytes) {
        Ok(_) => Some(bytes),
        Err(error) => {
            warn!("cannot send {message}: {error}");
            None
        }
    }
}
