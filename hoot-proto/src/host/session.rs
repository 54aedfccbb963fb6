//! Session of a master: the machine with the stream buffer of its line.
//!
//! This is a whole master. It asks the node with the usual address where its first motor is. Reading the line has to end
//! after some milliseconds without a byte, as serial ports can do.
//!
//! ```
//! use std::io::{Read, Write};
//!
//! use hoot_proto::host::{Event, Next, Options, Outcome, Session, Token};
//! use hoot_proto::message::{Motor, MotorPosition};
//! use hoot_proto::{Address, Millis, Query};
//!
//! fn ask(line: &mut (impl Read + Write), now: impl Fn() -> Millis) -> Result<(), Box<dyn std::error::Error>> {
//!     let question = MotorPosition { motor: Motor::One };
//!     let (mut session, mut bytes) = (Session::new(Options::default()), [0; 64]);
//!     session.link_up();
//!     loop {
//!         match session.poll(now(), &mut bytes)? {
//!             Next::Transmit(packet) => line.write_all(packet)?,
//!             Next::Event(Event::Ready { .. }) => session.request(Token(1), Address::DEFAULT, question.into())?,
//!             Next::Event(Event::Ended { token: Token(1), outcome: Outcome::Done(reply) }) => {
//!                 return Ok(println!("{}", question.decode_reply(reply)?));
//!             }
//!             Next::Event(event) => println!("{event:?}"),
//!             Next::Wait(_) => {
//!                 let len = line.read(&mut bytes)?;
//!                 assert_eq!(session.receive(now(), &bytes[..len]), len);
//!             }
//!         }
//!     }
//! }
//! ```

use motion_core::session::{self, Agenda, News, Session as _, Turn, TurnOf};
use motion_core::stream::Item;
use motion_core::time::Millis;
use motion_core::wire::EncodeError;
use motion_core::{session_line, session_link, session_methods};

use super::event::{Event, Outcome};
use super::input::{Command, Input, Request};
use super::machine::HostMachine;
use super::options::{Nodes, Options};
use super::transmit::Transmit;
use super::{EFFECTS, Effect, Token};
use crate::frame::{Address, Frame, Hoot, MAX_FRAME, PATIENCE};
use crate::message::{DeviceMessage, HostMessage, Motor, MotorStop, StepsPerSecond, Stop};

pub use motion_core::session::NotTaken;

/// Next thing to do for a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next<'a> {
    /// Write these bytes to the line.
    Transmit(&'a [u8]),
    /// Act on this event.
    Event(Event<'a>),
    /// Wait until something happens, at most until this time; without a time, as long as it takes.
    Wait(Option<Millis>),
}

/// Effect without what it borrows from the packet that came last.
#[derive(Debug, Clone, Copy)]
pub enum Held {
    Transmit(Transmit),
    Event(Event<'static>),
    /// End of the command with this token, with the packet as its answer.
    Answer(Token),
    /// Reply that answers nothing, or packet for another address.
    Other,
}

impl Held {
    const fn is_event(&self) -> bool {
        !matches!(self, Self::Transmit(_))
    }

    fn of(effect: Effect<'_>) -> Self {
        match effect {
            Effect::Transmit(transmit) => Self::Transmit(transmit),
            Effect::Event(event) => match (event.to_static(), event) {
                (Some(event), _) => Self::Event(event),
                (None, Event::Ended { token, .. }) => Self::Answer(token),
                (None, _) => Self::Other,
            },
        }
    }
}

/// Stream of the line, which takes pieces of 64 bytes.
type Link = session::Link<Hoot, { 2 * MAX_FRAME + 63 }>;

/// Master of a bus with its stream buffer.
pub struct Session {
    machine: HostMachine,
    link: Link,
    agenda: Agenda<(Token, Command), Held, EFFECTS>,
}

impl Session {
    /// Makes a session without a line.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self { machine: HostMachine::new(options), link: Link::new(PATIENCE), agenda: Agenda::new() }
    }

    /// Gives a command. There is a method for each of them, too.
    ///
    /// # Errors
    ///
    /// [`NotTaken::Full`] if too many commands wait for a poll.
    pub fn command(&mut self, token: Token, command: Command) -> Result<(), NotTaken> {
        match command {
            Command::EmergencyStop => self.agenda.stop_all((token, command)),
            Command::Request(request) if request.message.conduct().is_stop() => self.agenda.stop_one((token, command)),
            _ => self.agenda.want((token, command)),
        }
    }

    /// Next thing to do. Packets are written to the front of `out`, for which 42 bytes are enough.
    ///
    /// # Errors
    ///
    /// [`EncodeError::BufferTooSmall`]. Call again with as many bytes as the error needs; the packet is not lost.
    pub fn poll<'p>(&'p mut self, now: Millis, out: &'p mut [u8]) -> Result<Next<'p>, EncodeError> {
        Ok(match self.turn(now, &(), out)? {
            Turn::Transmit((), len) => Next::Transmit(out.get(..len).unwrap_or_default()),
            Turn::Event(held) => Next::Event(self.event(held)),
            Turn::Wait(until) => Next::Wait(until),
        })
    }

    /// Tells the machine the next thing that happened. Returns false if nothing did.
    fn advance(&mut self, now: Millis) -> bool {
        let output = match self.agenda.news() {
            Some(News::LinkDown) => self.machine.advance(now, Input::LinkDown),
            Some(News::LinkUp) => self.machine.advance(now, Input::LinkUp),
            Some(News::Wish((token, command))) => self.machine.advance(now, Input::Command(token, command)),
            None => match self.link.next() {
                Some(Item::Frame(frame)) => self.machine.advance(now, Input::received(&frame)),
                Some(_) => self.machine.advance(now, Input::Noise),
                None => {
                    if self.link.give_up(now) {
                        return true;
                    }
                    if !self.agenda.is_due(now) {
                        return false;
                    }
                    self.machine.advance(now, Input::Wake)
                }
            },
        };
        self.agenda.fill(output, Held::of);
        true
    }
}

impl session::Session for Session {
    type Source<'s> = ();

    session_line! { to all }

    fn turn(&mut self, now: Millis, (): &(), out: &mut [u8]) -> Result<TurnOf<Self>, EncodeError> {
        let held = loop {
            if let Some(held) = self.agenda.pop() {
                break held;
            }
            if !self.advance(now) {
                return Ok(Turn::Wait(self.until()));
            }
        };
        let Held::Transmit(transmit) = held else { return Ok(Turn::Event(held)) };
        // What arrived before cannot be the answer to this packet.
        self.link.drop_later();
        let written = transmit.encode_into(out);
        if written.is_err() {
            self.agenda.put_back(held);
        }
        written.map(|len| Turn::Transmit((), len))
    }

    fn event(&self, held: Held) -> Event<'_> {
        let frame = Frame::decode(self.link.last()).ok();
        let message = frame.map(|frame| (frame.address(), DeviceMessage::decode(&frame)));
        match (held, message) {
            (Held::Event(event), _) => event,
            (Held::Answer(token), Some((_, DeviceMessage::Reply(reply)))) => {
                Event::Ended { token, outcome: Outcome::Done(reply) }
            }
            // Nobody knows the answer any more.
            (Held::Answer(token), _) => Event::Ended { token, outcome: Outcome::NotConfirmed },
            (_, Some((_, DeviceMessage::Reply(reply)))) => Event::Unsolicited(reply),
            (_, Some((to, message))) => Event::Overheard { to, message },
            (_, None) => Event::Noise,
        }
    }
}

session_link! { host impl<> Session: HostMachine, Link }

session_methods! {
    impl<> Session as Command, see Command, with token;
    stop_all {
        /// Stops each motor of each listed node, until each motor rests.
        EmergencyStop stop();
    }
    stop_one {
        /// Stops a node, with its motors and its program.
        Request stop_node(to: Address) => (Request { to, message: Stop::default().into() });
        /// Stops a motor of a node.
        Request stop_motor(to: Address, motor: Motor) => (Request { to, message: MotorStop { motor }.into() });
    }
    want {
        /// Sends a message.
        Request request(to: Address, message: HostMessage<'static>) => (Request { to, message });
        /// Sends a broadcast through a bridge, although it reaches only the attached node.
        Insist insist(to: Address, message: HostMessage<'static>) => (Request { to, message });
        /// Sets the speed of a motor, as a joystick does many times a second.
        Speed speed(to: Address, motor: Motor, speed: StepsPerSecond) => { to, motor, speed };
        /// Keeps the dead-man of a node from stopping its motors, or lets it.
        KeepAlive keep_alive(to: Address, on: bool) => { to, on };
        /// Replaces the list of nodes that an emergency stop addresses.
        Nodes nodes(nodes: Nodes) => (nodes);
        /// Gives up an emergency stop that is not confirmed.
        EndEmergency end_emergency();
    }
}
