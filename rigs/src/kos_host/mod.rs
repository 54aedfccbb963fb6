//! Client of a kOS device: a [`host::Session`] with a line.
//!
//! [`KosHost`] lends passwords and moves to the session, and keeps the answers of the device.
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

mod party;
mod stored;

use std::collections::VecDeque;

use kos_proto::frame::MAX_FRAME;
use kos_proto::host::{self, Destination, HostMachine, Options, Outcome, Session, Source, Token};
use kos_proto::message::{Motor, MotorAddress, Password};
use kos_proto::{DecodeError, Device, DeviceMessage, EncodeError, Frame, HostMessage, Kos, Owned};
use motion_core::session::{Session as _, Turn};
use motion_core::time::Millis;
use tracing::{debug, warn};

use crate::{LineId, Outgoing};

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
    /// The device answered the question with this token. If it told its motors, the machine knows them, and this is the last
    /// message of the series.
    Answer(Token, Owned<Device>),
    /// The machine tells something else. Messages that answer nothing are left out.
    Machine(host::Event<'static>),
}

/// Listener on a line of kOS.
pub(crate) type Tap = crate::tap::Tap<Kos, { 2 * MAX_FRAME }>;

/// Client over TCP.
#[derive(Debug)]
pub struct KosHost {
    session: Box<Session>,
    password: Vec<u8>,
    /// Password that the command with this token gives to the device.
    new_password: Option<(Token, Vec<u8>)>,
    /// Move that the command stores.
    stored: Option<StoredMove>,
    /// Listener on the line, if that is open.
    line: Option<Tap>,
    wake: Option<Millis>,
    outgoing: VecDeque<Outgoing>,
    events: VecDeque<Event>,
    /// Room for a message.
    room: Vec<u8>,
}

impl KosHost {
    /// Client without a connection. Without a password of its own, it sends the one that the device tells.
    #[must_use]
    pub fn new(options: Options, password: Option<&[u8]>) -> Self {
        Self {
            session: Box::new(Session::new(options.with_echo_password(password.is_none()))),
            password: password.unwrap_or_default().to_vec(),
            new_password: None,
            stored: None,
            line: None,
            wake: None,
            outgoing: VecDeque::new(),
            events: VecDeque::new(),
            room: Vec::new(),
        }
    }

    /// Machine of the client, for reading its state.
    #[must_use]
    pub const fn machine(&self) -> &HostMachine {
        self.session.machine()
    }

    /// Motor of the device, as the device reported it last.
    #[must_use]
    pub fn motor(&self, motor: MotorAddress) -> Option<&Motor> {
        self.machine().motors().find(|known| known.motor_address.number() == motor.number())
    }

    /// Number of bytes that wait: for the rest of their message, or to be taken.
    #[must_use]
    pub fn held(&self) -> usize {
        self.session.held() + crate::waiting(&self.outgoing)
    }

    /// Does everything that follows now.
    fn work(&mut self, now: Millis) {
        loop {
            let source = Source {
                user_password: Password(&self.password),
                new_password: Password(self.new_password.as_ref().map_or(&[], |(_, password)| password)),
                trajectory: self.stored.as_ref().map(StoredMove::data).unwrap_or_default(),
            };
            match self.session.turn(now, &source, &mut self.room) {
                Ok(Turn::Transmit(Destination::Connection, len)) => {
                    let bytes = self.room.get(..len).unwrap_or_default();
                    debug!("> {}", host_text(bytes));
                    self.outgoing.push_back(Outgoing::Bytes(LINE, bytes.to_vec()));
                }
                // The address of the device is known to the owner of the line.
                Ok(Turn::Transmit(Destination::Broadcast, _)) => {}
                Ok(Turn::Event(held)) => {
                    let event = self.session.event(held);
                    match event {
                        host::Event::Connect(_) => self.outgoing.push_back(Outgoing::Open(LINE)),
                        host::Event::LinkDown(_) if self.line.take().is_some() => {
                            self.outgoing.push_back(Outgoing::HangUp(LINE));
                        }
                        host::Event::Ended { token, outcome: Outcome::Sent } => {
                            if let Some((_, password)) = self.new_password.take_if(|(change, _)| *change == token) {
                                self.password = password;
                            }
                        }
                        _ => {}
                    }
                    self.events.extend(match event {
                        host::Event::Ended { token, outcome: Outcome::Done(Some(message)) } => {
                            Owned::new(&message).ok().map(|answer| Event::Answer(token, answer))
                        }
                        event => event.to_static().map(Event::Machine),
                    });
                }
                Ok(Turn::Wait(until)) => break self.wake = until,
                Err(EncodeError::BufferTooSmall { needed, .. }) => self.room.resize(needed, 0),
                Err(error) => warn!("a message cannot be sent: {error}"),
            }
        }
    }
}

/// Text of a message of a client, for the log.
pub(crate) fn host_text(bytes: &[u8]) -> String {
    text(bytes, |frame| HostMessage::decode(frame).map(|message| message.to_string()))
}

/// Text of a message of a device, for the log.
fn device_text(bytes: &[u8]) -> String {
    text(bytes, |frame| DeviceMessage::decode(frame).map(|message| message.to_string()))
}

fn text(bytes: &[u8], decode: impl Fn(&Frame<'_>) -> Result<String, DecodeError>) -> String {
    match Frame::decode(bytes).map(|frame| decode(&frame)) {
        Ok(Ok(text)) => text,
        Ok(Err(why)) => why.to_string(),
        Err(why) => why.to_string(),
    }
}
