//! A master as a pure function: what the application wants and what arrives go in; packets, and what became of each
//! request, come out.
//!
//! There is one request at a time on a bus, since nothing in a reply says what it answers. The machine keeps a short
//! queue, waits, repeats what may be repeated and nothing else, and has stops overtake everything.
//!
//! # When do I call what
//!
//! - The line is there, or has gone: step with [`Input::LinkUp`] or [`Input::LinkDown`].
//! - A packet arrived: step with [`Input::Received`]. When the line falls silent inside a packet for 100 ms, call `gap`
//!   on the stream.
//! - The application wants something: step with [`Input::Command`]. Each request ends in one [`Event::Ended`] with its
//!   [`Token`].
//! - The moment of `output.wake` has come: step with [`Input::Wake`].
//! - Before each packet that is to be sent, call `reset` on the stream, and drop what the line holds.
//!
//! ```
//! use hoot_proto::host::{Command, Event, HostMachine, Input, Options, Outcome, Request, Token};
//! use hoot_proto::message::{Motor, MotorPosition, Steps};
//! use hoot_proto::{Address, DeviceMessage, Frame, HostMessage, Query};
//! use motion_core::machine::Machine;
//! use motion_core::time::Millis;
//!
//! let query = MotorPosition { motor: Motor::One };
//! let message = HostMessage::MotorPosition(query);
//! let request = Request { token: Token(7), to: Address::DEFAULT, message };
//! let mut master = HostMachine::new(Options::default());
//! let mut packet = [0; 42];
//! // The line and the clock are the caller's; here the answer comes after 9 ms.
//! let answer = Frame::decode(b"\0\0\0\0\0\xFF\0\0\x01\x05\x03\xFF\xFF\xFF\xFB")?;
//! let answer = Input::Received(DeviceMessage::decode(&answer));
//! for (now, input) in [(0, Input::LinkUp), (1, Input::Command(Command::Request(request))), (10, answer)] {
//!     let (next, output) = master.step(Millis(now), input);
//!     master = next;
//!     for send in output.send {
//!         let len = send.encode_into(&mut packet)?;
//!         assert_eq!(packet[..len], *b"\0\0\0\0\0\xFF\x03\x01\x6A\0");
//!     }
//!     for event in output.events {
//!         let Event::Ended { token: Token(7), outcome: Outcome::Done(reply) } = event else { panic!("{event:?}") };
//!         assert_eq!(query.decode_reply(reply.reply())?.value, Steps(-5));
//!     }
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Rows, states and decisions: `docs/machines-hoot.md` and `docs/decisions-hoot.md` in the repository.

mod emergency;
mod event;
mod kind;
mod line;
mod master;
mod options;
mod stops;
mod stream;
mod submit;

use motion_core::machine;

pub use emergency::StopState;
pub use event::{Dropped, Event, Failure, NotTaken, Outcome, Received, Send};
pub use line::State;
pub use master::HostMachine;
pub use options::{MAX_NODES, Nodes, Options};

use crate::frame::Address;
use crate::message::{DeviceMessage, HostMessage, Motor, StepsPerSecond};

/// Requests that wait for the line, beside the one that waits for its answer.
pub const MAX_QUEUE: usize = 8;
/// Stops that are not answered yet.
pub const MAX_STOPS: usize = 8;
/// Motors whose next speed waits for the line.
pub const MAX_SPEEDS: usize = 12;
/// Nodes that are kept alive.
pub const MAX_KEPT: usize = 4;

/// What a step of the machine gives.
///
/// One packet is sent at a time. Of events there are at most 24: an emergency stop ends 8 requests that wait, 8 stops
/// and the one request that is out, and says so; nothing else tells as much.
pub type Output = machine::Output<Send, Event, 1, 24>;

/// The application's number of a request, which comes back with its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Token(pub u32);

/// What the application wants from a node, or from all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Request {
    /// How it is called when it ends.
    pub token: Token,
    /// Whom it is for; [`Address::BROADCAST`] for broadcasts.
    pub to: Address,
    /// What it says.
    pub message: HostMessage<'static>,
}

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Input<'a> {
    /// The line is there.
    LinkUp,
    /// The line has gone.
    LinkDown,
    /// A packet arrived.
    Received(DeviceMessage<'a>),
    /// Bytes arrived that are no packet.
    Noise,
    /// The application wants something.
    Command(Command),
    /// Nothing but time.
    Wake,
}

/// What the application wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Command {
    /// Send a request. A stop overtakes everything, and takes out of the queue what would move what it stops.
    Request(Request),
    /// Send a broadcast through a bridge, although it reaches only the attached node (safety decision 4).
    Insist(Request),
    /// Set the speed of a motor that runs, as a joystick does, many times a second: of those that wait, the last counts.
    ///
    /// It has no token, for most firmware does not answer it. A speed of 0 that is not answered is followed by a stop
    /// (decision H-24).
    Speed {
        /// The node.
        to: Address,
        /// The motor.
        motor: Motor,
        /// How fast.
        speed: StepsPerSecond,
    },
    /// Ask a node for something harmless as long as nothing else is sent to it, so that its dead-man does not stop its
    /// motors; or let it be.
    KeepAlive {
        /// The node.
        to: Address,
        /// Whether to keep it alive.
        on: bool,
    },
    /// These nodes are there from now on: those that an emergency stop addresses.
    Nodes(Nodes),
    /// Stop each motor of each node, until each says that it rests. Nothing goes before it.
    EmergencyStop,
    /// Give up an emergency stop that is not confirmed.
    EndEmergency,
}
