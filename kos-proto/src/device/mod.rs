//! The device: a rig, and up to four clients that are connected to it.
//!
//! [`DeviceMachine`] knows what to answer, which client may do what, where the motors may go, and how a move is made
//! ready, played and stopped. It moves no motor: events tell the rig what to do, and [`Report`]s tell the machine what
//! happened. Long data stay with the caller: the stored move, the password, the limits of the motors. A [`Source`] lends
//! them when a message is made.
//!
//! # Calling it
//!
//! | something happened | input |
//! |---|---|
//! | the device runs | [`Report::Started`] |
//! | a client connects, or is gone | [`Input::LinkUp`], [`Input::LinkDown`] |
//! | a frame came, or a fatal item | [`Input::received`], [`Input::Fatal`] |
//! | a datagram came | [`Input::Datagram`] |
//! | a person wants everything to stop | [`Input::Stop`] |
//! | the rig has something to report | [`Input::Rig`] |
//! | the time of the last wake has come | [`Input::Wake`] |
//!
//! After each call of [`advance`](DeviceMachine::advance), carry out the effects in their order, then wait, at most until
//! the wake.
//!
//! ```
//! use kos_proto::device::{DeviceMachine, Event, Input, Options, Report, Scratch, SessionId, Source};
//! use kos_proto::message::{MotorAddress, Password, RotationsPerSecond, RotationsPerSecondSquared};
//! use kos_proto::message::SetPositionSpeedAcceleration;
//! use kos_proto::{Effect, Frame, HostMessage, Millis, Transport};
//!
//! let (session, password) = (SessionId(0), Password(b""));
//! let (speed, acceleration) = (RotationsPerSecond(20.0), RotationsPerSecondSquared(50.0));
//! let jog: HostMessage = SetPositionSpeedAcceleration::jog(MotorAddress(1), speed, acceleration).into();
//! let mut bytes = [0; 20];
//! jog.encode_into(&mut bytes)?;
//! let inputs = [
//!     Input::Rig(Report::Started),
//!     Input::LinkUp { session, transport: Transport::Tcp, password },
//!     Input::received(session, &Frame::decode(&bytes)?, password),
//! ];
//!
//! let mut device = DeviceMachine::new(Options::default());
//! let mut told = Vec::new();
//! for (now, input) in (0..).map(Millis).zip(inputs) {
//!     let output = device.advance(now, input);
//!     let _ = output.wake; // wait until then, or until something happens
//!     for effect in output {
//!         match effect {
//!             Effect::Event(event) => told.push(event), // the rig does it
//!             Effect::Transmit(transmit) => {
//!                 println!("to {:?}: {}", transmit.destination, transmit.message(&Source::default(), &mut Scratch::default()));
//!             }
//!         }
//!     }
//! }
//! assert!(matches!(told[..], [Event::Move { motor: MotorAddress(1), .. }]));
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```
//!
//! # Safety of people
//!
//! A stop is obeyed in every state, in the call in which it comes, whoever sends it, locked or not. While a move runs,
//! nothing else that a client sends moves a motor, and the stop of any one motor stops the move (safety decisions 1 and
//! 2). When a client is gone, what it moved by hand is stopped; a move goes on, unless the options say otherwise.

pub mod clients;
mod effects;
mod event;
mod input;
mod lapse;
mod machine;
mod manual;
pub mod motor;
mod options;
pub mod playback;
mod session;
mod stage;
mod transmit;

pub use clients::{DisconnectReason, SESSIONS, SessionId, Sessions};
pub use event::{Event, Ignored};
pub use input::{Input, Report, Sender};
pub use machine::{DeviceMachine, Link};
pub use motion_core::session::NotTaken;
pub use options::{Actions, Options, Quirks};
pub use session::{CommandSession, Next, Session};
pub use transmit::{Activity, Contents, Destination, MotorReport, MotorSpecs, Positions, Scratch, Source, Transmit};

/// Greatest number of effects of one call.
///
/// - 15 for four clients that are silent for too long: ten motors are stopped, the move with them, four connections are
///   closed.
/// - 12 for a stop, or an answer about ten motors: the stop, the end of the move, and ten motors at rest.
/// - 6 for two steps of a move.
/// - 3: the address over TCP, an announcement, an input that is ignored.
pub const EFFECTS: usize = 36;

/// All that follows from an input of a device.
pub type Output<'a> = motion_core::machine::Output<Transmit<'a>, Event<'a>, EFFECTS>;
/// One thing that follows from an input of a device.
pub type Effect<'a> = motion_core::machine::Effect<Transmit<'a>, Event<'a>>;

/// Codec of a device for a `Framed` of `tokio_util`: it takes messages of the device, and yields those of the client
/// and all bytes that are no message. Its buffer has `N` bytes, at least twice [`MAX_FRAME`](crate::frame::MAX_FRAME).
///
/// The [codec of a client](crate::host::Codec) has an example of both.
#[cfg(feature = "tokio")]
pub type Codec<const N: usize = { 2 * crate::frame::MAX_FRAME }> =
    motion_core::codec::Codec<crate::Device, crate::Host, crate::Kos, N>;
/// Item that the [`Codec`] of a device yields.
#[cfg(feature = "tokio")]
pub type CodecItem = motion_core::codec::Item<crate::Host, crate::Header>;
