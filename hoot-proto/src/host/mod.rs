//! The master of a bus: the application's commands and what arrives go in; packets, and the end of each command, come out.
//!
//! Only one request is under way on a bus, because nothing in a reply says what it answers. The machine keeps a short queue,
//! waits for answers, and repeats the messages whose [conduct](HostMessage::conduct) allows it. Stops overtake everything.
//!
//! # Calling the machine
//!
//! 1. Call [`advance`](HostMachine::advance) with the time and an [`Input`] when the line came up or went down, when a packet
//!    arrived, when the application wants something, and when the time of `output.wake` has come.
//! 2. Carry out the effects in their order. Before a packet is written, call `reset` on the stream and drop what the line
//!    holds: it cannot be an answer to this packet.
//! 3. When the line falls silent inside a packet for 100 ms, call `gap` on the stream.
//!
//! Each command ends once, in an [`Event::Ended`] with its [`Token`].
//!
//! # Late answers, and nodes that hear nothing
//!
//! An answer that may be that to another packet is told as [`Event::Unsolicited`], never as the end of a command. So after a
//! silence, and after the line came up, requests wait until late answers would have come ([`Options::drain`]). Stops wait
//! for nothing but the gap. For 3 s after the line came up, an answer without a value may be that to a start of another
//! master. So settings wait, and stops are repeated, until each listed node has answered a query or the time is over.
//! Ask a query first: the machine asks none by itself, because a stop would have to wait for the answer.
//!
//! Real firmware hangs if two packets wait at a node that hears nothing. A node may hear nothing for 3 s after a start, a new
//! address or a command without a type, and after the line came up, because of another master. Until it answers or the time
//! is over, such a node gets one packet: a stop, or after the line came up a query.
//!
//! ```
//! use hoot_proto::host::{Command, Effect, Event, HostMachine, Input, Options, Outcome, Request};
//! use hoot_proto::message::{Motor, MotorPosition, Steps};
//! use hoot_proto::{Address, Frame, Millis, Query, Token};
//!
//! let query = MotorPosition { motor: Motor::One };
//! let request = Command::Request(Request { to: Address::DEFAULT, message: query.into() });
//! // The line and the clock belong to the caller; here the answer comes after 9 ms. For 900 ms after the line came up, an
//! // answer might be that to a packet from before.
//! let answer = Frame::decode(b"\0\0\0\0\0\xFF\0\0\x01\x05\x03\xFF\xFF\xFF\xFB")?;
//! let command = Input::Command(Token(7), request);
//! let inputs = [(0, Input::LinkUp), (1, command), (900, Input::Wake), (909, Input::received(&answer))];
//!
//! let mut master = HostMachine::new(Options::new());
//! for (now, input) in inputs {
//!     for effect in master.advance(Millis(now), input) {
//!         match effect {
//!             Effect::Transmit(transmit) => {
//!                 let mut packet = [0; 42];
//!                 let len = transmit.encode_into(&mut packet)?;
//!                 assert_eq!(packet[..len], *b"\0\0\0\0\0\xFF\x03\x01\x6A\0");
//!             }
//!             Effect::Event(Event::Ended { token: Token(7), outcome: Outcome::Done(reply) }) => {
//!                 assert_eq!(query.decode_reply(reply)?.value, Steps(-5));
//!             }
//!             Effect::Event(event) => assert_eq!(event, Event::Ready { reconnected: false }),
//!         }
//!     }
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Rows, states and decisions: `docs/machines-hoot.md` and `docs/decisions-hoot.md` in the repository.

mod commands;
mod deaf;
mod doubt;
mod emergency;
mod event;
mod input;
mod jobs;
mod joystick;
mod line;
mod machine;
mod motion;
mod options;
mod session;
mod stops;
mod transmit;

pub use emergency::StopState;
pub use event::{Event, Failure, Outcome, Refusal, StopTarget};
pub use input::{Command, Input, Request};
pub use line::State;
pub use machine::HostMachine;
pub use motion_core::machine::Token;
pub use options::{MAX_NODES, Nodes, Options};
pub use session::{Next, NotTaken, Session};
pub use transmit::Transmit;

#[cfg(doc)]
use crate::message::HostMessage;

/// Number of requests that can wait for the line, beside the request that waits for its answer.
pub const MAX_QUEUE: usize = 8;
/// Number of stops that can wait for their answers.
pub const MAX_STOPS: usize = 8;
/// Number of motors whose next speed can wait for the line.
pub const MAX_SPEEDS: usize = 12;
/// Number of nodes that can be kept alive.
pub const MAX_KEPT: usize = 4;

/// Greatest number of effects of one call. It is reached when the line goes down:
///
/// - 1: the line is down,
/// - 1: the command that waits for its answer ends,
/// - 18: 9 stops end and are not confirmed, one of them added for a speed of 0,
/// - 8: the requests in the queue end,
/// - 12: the speeds that wait end,
/// - 1: an emergency stop is not confirmed.
pub const EFFECTS: usize = 41;

/// Output of a master: a packet, if there is one, and then the events.
pub type Output<'a> = motion_core::machine::Output<Transmit, Event<'a>, EFFECTS>;
/// Effect of a master.
pub type Effect<'a> = motion_core::machine::Effect<Transmit, Event<'a>>;

/// Codec of a master for a `Framed` of `tokio_util`: it takes pairs of an address and a message of the master, and yields those of the node
/// and all bytes that are no message. Its buffer has `N` bytes, at least twice [`MAX_FRAME`](crate::frame::MAX_FRAME).
///
/// ```
/// use futures_util::{SinkExt, StreamExt};
/// use hoot_proto::message::{Motor, MotorPosition, Reply};
/// use hoot_proto::{Address, DeviceMessage, HostMessage, device, host};
/// use tokio_util::codec::Framed;
///
/// # #[tokio::main(flavor = "current_thread")]
/// # async fn main() -> std::io::Result<()> {
/// // Any asynchronous stream does, such as a serial port.
/// let (here, there) = tokio::io::duplex(64);
/// let mut host: Framed<_, host::Codec> = Framed::new(here, host::Codec::default());
/// let mut device: Framed<_, device::Codec> = Framed::new(there, device::Codec::default());
///
/// let question = MotorPosition { motor: Motor::One };
/// host.send((Address::DEFAULT, HostMessage::from(question))).await?;
/// let Some(device::CodecItem::Message { label, message, .. }) = device.next().await.transpose()? else {
///     panic!("no message")
/// };
/// assert_eq!((label, message.message()), (Address::DEFAULT, question.into()));
///
/// // A node that refuses. Without an error it answers with the position.
/// device.send(DeviceMessage::from(Reply::ERROR)).await?;
/// match host.next().await.transpose()? {
///     Some(host::CodecItem::Message { message, .. }) => println!("{message}"),
///     Some(other) => println!("no message: {other:?}"),
///     None => println!("the node is gone"),
/// }
/// # Ok(())
/// # }
/// ```
#[cfg(feature = "tokio")]
pub type Codec<const N: usize = { 2 * crate::frame::MAX_FRAME }> =
    motion_core::codec::Codec<crate::Host, crate::Device, crate::Hoot, N>;
/// Item that the [`Codec`] of a master yields.
#[cfg(feature = "tokio")]
pub type CodecItem = motion_core::codec::Item<crate::Device, crate::Header>;
