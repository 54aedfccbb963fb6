//! The node: what arrives and what the rig reports go in; answers, and what motors, camera and outputs have to do, come out.
//!
//! The machine is the node: it keeps every setting that a master writes or asks for. It moves nothing itself. The rig does
//! what the [`Event`]s say, and reports where its motors are.
//!
//! # Calling the machine
//!
//! 1. Read packets with the framing [`Strict`](crate::Strict), which loses what firmware loses, and call `reset` on the
//!    stream after each packet. Call [`advance`](DeviceMachine::advance) with the time and an [`Input`] when a packet arrived,
//!    when a motor moved, reached its place or failed, when a contact or a measurement changed, and when the time of
//!    `output.wake` has come.
//! 2. Carry out the effects in their order. What the rig has to do stands before the answer that acknowledges it.
//!
//! ```
//! use hoot_proto::device::{DeviceMachine, Effect, Event, Input, Motion, Options, Port};
//! use hoot_proto::message::Motor;
//! use hoot_proto::{Frame, Millis};
//!
//! let mut node = DeviceMachine::new(Options::new());
//! let _ = node.advance(Millis(0), Input::Position { motor: Motor::One, position: (-5).into() });
//!
//! // Where is motor 1? The line, the clock and the rig belong to the caller.
//! let question = Frame::decode(b"\0\0\0\0\0\xFF\x03\x01\x6A\0")?;
//! let output = node.advance(Millis(3), Input::received(Port::Usb, &question));
//! assert_eq!(output.wake, None, "nothing is to be done later");
//! for effect in output {
//!     match effect {
//!         Effect::Event(Event::Motor { motor, motion: Motion::Stop }) => println!("stop motor {motor} at once"),
//!         Effect::Event(event) => println!("{event:?}"),
//!         Effect::Transmit(transmit) => {
//!             let mut packet = [0; 42];
//!             let len = transmit.encode_into(&mut packet)?;
//!             assert_eq!((transmit.port, &packet[9..len]), (Port::Usb, &[5, 3, 0xFF, 0xFF, 0xFF, 0xFB][..]));
//!         }
//!     }
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Firmware
//!
//! Firmware with motors needs no [`Quirks`], and [`DeviceMachine::without_quirks`] leaves their code out. The message of an event
//! [`Event::Ignored`] is decoded when it is asked for, so that firmware that does not ask contains no decoder of messages.
//!
//! ```
//! use hoot_proto::device::{DeviceMachine, Options, Session};
//!
//! let node: Session<false> = Session::new(DeviceMachine::without_quirks(Options::new()));
//! ```
//!
//! Rows, states and decisions: `docs/machines-hoot.md` and `docs/decisions-hoot.md` in the repository.

mod blocking;
mod camera;
mod command;
mod controller;
mod cycle;
mod event;
mod firmware;
mod input;
mod lazy;
mod link;
mod machine;
mod motor;
mod options;
mod queries;
mod request;
mod requests;
mod session;
mod transmit;

pub use blocking::Blocking;
pub use camera::{CameraSettings, CameraState, CameraUnit};
pub use controller::{AltOut, Controller};
pub use cycle::{Phase, Program};
pub use event::{Event, Ignored, Motion, Part, ProgramState};
pub use input::{Command, Contact, Input, Port};
pub use lazy::LazyMessage;
pub use machine::DeviceMachine;
pub use motor::{MotorSettings, MotorState, MotorUnit};
pub use options::{Options, Quirks, StoredName};
pub use session::{Next, NotTaken, Session};
pub use transmit::{Answer, Contents, Transmit};

/// Greatest number of effects of one call:
///
/// - 30: each of three motors is set off twice, for what arrived and for what was due, and stopped three times, each time
///   with its current,
/// - 6: each of three motors has other microsteps when it rests and before a start,
/// - 18: program, camera, outputs, positions that are counted anew, and the packet itself,
/// - 2: two answers to one request, or one packet forwarded to two ports.
pub const EFFECTS: usize = 56;

/// Output of a node: what the rig has to do, in order, and then the packets.
pub type Output<'a> = motion_core::machine::Output<Transmit<'a>, Event<'a>, EFFECTS>;
/// Effects of a node while its machine works, without what the packet lends.
type Effects = motion_core::machine::Output<request::Reaction, Event<'static>, EFFECTS>;
/// Effect of a node.
pub type Effect<'a> = motion_core::machine::Effect<Transmit<'a>, Event<'a>>;

/// Codec of a node for a `Framed` of `tokio_util`: it takes messages of the node, and yields those of the master
/// and all bytes that are no message. Its buffer has `N` bytes, at least twice [`MAX_FRAME`](crate::frame::MAX_FRAME).
///
/// The [codec of a master](crate::host::Codec) has an example of both.
#[cfg(feature = "tokio")]
pub type Codec<const N: usize = { 2 * crate::frame::MAX_FRAME }> =
    motion_core::codec::Codec<crate::Device, crate::Host, crate::Requests, N>;
/// Item that the [`Codec`] of a node yields. Labels are addresses.
#[cfg(feature = "tokio")]
pub type CodecItem = motion_core::codec::Item<crate::Host, crate::Header>;
