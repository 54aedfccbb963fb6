//! The client, or host: it controls a device.
//!
//! [`HostMachine`] connects to a device, asks what it is, keeps the line alive, knows the motors, and follows the move on
//! the device. It stops whatever moves, as often as it takes. Long data stay with the application: the blocks of a move,
//! and passwords. A [`Source`] lends them when a message is made.
//!
//! # Calling it
//!
//! | something happened | input |
//! |---|---|
//! | the application wants something | [`Input::Command`], with a [`Token`] |
//! | the connection of [`Event::Connect`] is there, or there is none (any more) | [`Input::LinkUp`], [`Input::LinkDown`] |
//! | a frame came, or a fatal item | [`Input::received`], [`Input::Fatal`] |
//! | the time of the last wake has come | [`Input::Wake`] |
//!
//! After each call of [`advance`](HostMachine::advance), carry out the effects in their order, then wait, at most until
//! the wake. [`discovery::Devices`](crate::discovery::Devices) tells which devices are in the network; the machine only
//! asks for them, if [`Options::ask_every`] says so.
//!
//! ```
//! use kos_proto::host::{Command, Endpoint, Event, HostMachine, Input, Options, Outcome, Source, Token};
//! use kos_proto::{Effect, Millis};
//!
//! let inputs = [
//!     Input::Command(Token(1), Command::Connect(Endpoint::Usb)),
//!     Input::LinkUp,
//!     Input::Command(Token(2), Command::Stop),
//! ];
//!
//! let mut host = HostMachine::new(Options::default());
//! let (mut wire, mut told) = (Vec::new(), Vec::new());
//! for (now, input) in (0..).map(Millis).zip(inputs) {
//!     let output = host.advance(now, input);
//!     let _ = output.wake; // wait until then, or until something happens
//!     for effect in output {
//!         match effect {
//!             Effect::Transmit(transmit) => {
//!                 let mut message = [0; 64];
//!                 let len = transmit.message(&Source::default()).encode_into(&mut message)?;
//!                 wire.push(message[..len].to_vec());
//!             }
//!             Effect::Event(event) => told.push(event),
//!         }
//!     }
//! }
//! assert_eq!(told[0], Event::Connect(Endpoint::Usb));
//! assert_eq!(told.last(), Some(&Event::Ended { token: Token(2), outcome: Outcome::Sent }));
//! assert_eq!(wire, [&b"\x04\0\x06\0\x0f\x01"[..], b"\x04\0\x07\0\x80\0\x06"], "a question, and a stop");
//! assert!(host.may_move(), "until the stop is confirmed");
//! # Ok::<(), kos_proto::EncodeError>(())
//! ```
//!
//! # Safety of people
//!
//! [`Command::Stop`] is sent in the call in which it comes, before everything else, in every state. It is sent again every
//! two seconds until the device obeys it, and first of all when a lost connection is there again. Each time it is not
//! confirmed, [`Event::StopNotConfirmed`] tells it; in the end [`Event::Stopped`] tells that all rests. Messages that are
//! not repeatable are sent once for their command ([`Transmit::conduct`]). [`HostMachine::may_move`] says whether anything
//! may still move because of this client. After a reconnect, nothing should be moved unasked ([`Event::Ready`]).

mod calibration;
mod commands;
mod event;
mod hand;
mod input;
mod machine;
mod motors;
mod options;
mod playback;
mod questions;
mod received;
mod requests;
mod session;
mod stops;
mod transmit;

pub use calibration::CalibrationState;
pub use event::{Event, Failure, LinkDownReason, Move, MoveState, Outcome, Refusal, StopTarget};
pub use input::{Command, Endpoint, Get, Go, Input};
pub use machine::{HostMachine, State};
pub use motion_core::machine::Token;
pub use options::{Identity, Options};
pub use session::{Destination, Next, NotTaken, Session};
pub use transmit::{PasswordOf, Source, Transmit};

/// Greatest number of effects of one call.
///
/// - 30 for ten motors, of each: it came or went, its stop is sent again, and that is told; or its command ends.
/// - 3 for a stop of everything that is sent again, told, and followed by a question.
/// - 9 for seven questions that fail, and two that are asked after them.
/// - 6: a question for the motors, a range that fails, nobody alive, motors that do not rest, a keep-alive with a
///   question.
pub const EFFECTS: usize = 48;

/// All that follows from an input of a client.
pub type Output<'a> = motion_core::machine::Output<Transmit<'a>, Event<'a>, EFFECTS>;
/// One thing that follows from an input of a client.
pub type Effect<'a> = motion_core::machine::Effect<Transmit<'a>, Event<'a>>;

/// Codec of a client for a `Framed` of `tokio_util`: it takes messages of the client, and yields those of the device
/// and all bytes that are no message. Its buffer has `N` bytes, at least twice [`MAX_FRAME`](crate::frame::MAX_FRAME).
///
/// ```
/// use futures_util::{SinkExt, StreamExt};
/// use kos_proto::message::{DeviceInfo, GetDeviceInfo};
/// use kos_proto::{DeviceMessage, HostMessage, device, host};
/// use tokio_util::codec::Framed;
///
/// # #[tokio::main(flavor = "current_thread")]
/// # async fn main() -> std::io::Result<()> {
/// // Any asynchronous stream does, such as a TCP connection.
/// let (here, there) = tokio::io::duplex(64);
/// let mut host: Framed<_, host::Codec> = Framed::new(here, host::Codec::default());
/// let mut device: Framed<_, device::Codec> = Framed::new(there, device::Codec::default());
///
/// host.send(HostMessage::from(GetDeviceInfo::default())).await?;
/// let Some(device::CodecItem::Message { message, .. }) = device.next().await.transpose()? else { panic!("no message") };
/// assert_eq!(message.message(), GetDeviceInfo::default().into());
///
/// device.send(DeviceMessage::from(DeviceInfo::default())).await?;
/// match host.next().await.transpose()? {
///     Some(host::CodecItem::Message { message, .. }) => println!("{message}"),
///     Some(other) => println!("no message: {other:?}"),
///     None => println!("the device is gone"),
/// }
/// # Ok(())
/// # }
/// ```
#[cfg(feature = "tokio")]
pub type Codec<const N: usize = { 2 * crate::frame::MAX_FRAME }> =
    motion_core::codec::Codec<crate::Host, crate::Device, crate::Kos, N>;
/// Item that the [`Codec`] of a client yields.
#[cfg(feature = "tokio")]
pub type CodecItem = motion_core::codec::Item<crate::Device, crate::Header>;
