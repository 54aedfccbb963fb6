//! Dragonframe DMC v2: the protocol between Dragonframe and a motion-control rig, for both sides.
//!
//! Dragonframe, the [host](HostMessage), sends requests. A controller, the [device](DeviceMessage), answers them, and sends
//! some messages unasked. The crate turns bytes into frames and frames into messages, and back. It does no I/O, does not
//! allocate, and does not panic.
//!
//! To read, give the bytes of a stream in any pieces to [`Frames`], which finds the frames in them. Each side decodes the
//! messages of the other side.
//!
//! ```
//! use dmc_proto::message::{Motor, StopReason};
//! use dmc_proto::{DeviceMessage, Frames, Item};
//!
//! // A lost byte, then a frame as a controller sends it when motor 2 runs into its upper limit.
//! let mut line = &b"\x07DF\0\0\0\0\x3a\0\x02\0\x01\x02\x94\xa1"[..];
//!
//! let mut frames: Frames = Frames::new();
//! while let Some(item) = frames.next_from(&mut line) {
//!     match item {
//!         Item::Frame(frame) => match DeviceMessage::decode(&frame)? {
//!             DeviceMessage::MotorHardStop(stop) => {
//!                 assert_eq!((stop.reason, stop.motor), (StopReason::UPPER_LIMIT, Some(Motor(2))));
//!             }
//!             message => println!("{} {message}", frame.id()),
//!         },
//!         Item::Corrupt { header, why, .. } => println!("{}: {why}", header.kind()),
//!         Item::Noise { bytes, .. } => assert_eq!(bytes, [7]),
//!         Item::Fatal(_) => unreachable!("a DMC stream always goes on"),
//!     }
//! }
//! # Ok::<(), dmc_proto::DecodeError>(())
//! ```
//!
//! A host uses [`HostReader`] instead, and a device [`DeviceReader`]. They also take the time, and give up a frame that is not
//! whole in time: otherwise a damaged length makes a reader wait for bytes that never come.
//!
//! To write, encode a message, which makes its whole frame with length and check bytes. [`lint`] finds before what a device
//! would refuse.
//!
//! ```
//! use dmc_proto::lint::Context;
//! use dmc_proto::message::{JogSpeed, Motor, MotorJog, Steps};
//! use dmc_proto::{HostMessage, MessageId};
//!
//! let jog = MotorJog { motor: Motor(3), speed: JogSpeed::SLOWEST, destination: Steps(-2000), tail: &[] };
//! let mut out = [0; 64];
//! let len = HostMessage::from(jog).encode_checked(MessageId(1), &Context::default(), &mut out)?;
//! assert_eq!(&out[..len], b"DF\x01\0\0\0\x36\0\x07\0\x03\x01\0\x30\xf8\xff\xff\xb3\x56");
//! # Ok::<(), dmc_proto::EncodeError>(())
//! ```
//!
//! The module [`upload`] sends and stores a whole move.
//!
//! Most programs and firmware need a session: [`host::Session`] or [`device::Session`]. Bytes go in, and one `poll` gives what
//! to send, what happened, and how long to wait. Inside is a state machine.
//!
//! Two state machines decide when to send which message, and what to do without an answer: [`host::HostMachine`] controls a
//! rig, [`device::DeviceMachine`] is the controller. Each takes an input and returns messages to send, events, and the time
//! of the next wake. Both modules begin with a table of inputs, and a loop that drives the machine.
//!
//! ```
//! use dmc_proto::Millis;
//! use dmc_proto::host::{Command, Contents, Effect, HostMachine, Input, Options, State, StopTarget, Token, Transmit};
//!
//! let mut host = HostMachine::new(Options::default());
//! let output = host.advance(Millis(0), Input::LinkUp);
//! assert!(matches!(output.effects[..], [Effect::Transmit(Transmit { contents: Contents::Greeting, .. })]));
//! assert_eq!(host.state(), State::Greeting);
//! assert_eq!(output.wake, Some(Millis(1000)), "without an answer, the host greets again then");
//!
//! // A stop does not wait for the answer.
//! let output = host.advance(Millis(5), Input::Command(Token(1), Command::Stop(StopTarget::All)));
//! let first = &output.effects[0];
//! assert!(matches!(first, Effect::Transmit(Transmit { contents: Contents::Stop(StopTarget::All), .. })));
//! ```
//!
//! # Units
//!
//! | type | on the wire | meaning |
//! |---|---|---|
//! | [`Motor`](message::Motor) | u8, from 1 | number of a motor |
//! | [`Steps`](message::Steps) | i32 | steps of a motor |
//! | [`Speed`](message::Speed), [`Acceleration`](message::Acceleration) | u32 | steps/s, steps/s² |
//! | [`JogSpeed`](message::JogSpeed) | u16, x100 | 0.01 to 100.00 % of the speed of a motor |
//! | [`FrameNumber`](message::FrameNumber) | i32 | number of a frame |
//! | [`MoveTime`](message::MoveTime) | i32, x1000 | frames, in thousandths |
//! | [`FramesPerSecond`](message::FramesPerSecond) | u32, x1000 | frames per second |
//! | [`Milliseconds`](message::Milliseconds) | u32 | ms |
//! | [`Degrees`](message::Degrees) | u16 | degrees of a shutter |
//! | [`DmxChannel`](message::DmxChannel) | u16, from 1 | number of a DMX channel |
//! | [`VirtualPosition`](message::VirtualPosition) | i32, x100 000 | units of the rig, or degrees |
//! | [`Coordinate`](message::Coordinate), [`Length`](message::Length) | i32, u32, x1000 | units of the rig |
//!
//! # Safety of people
//!
//! The checksum does not distinguish a byte 00 from a byte FF. A position can therefore arrive wrong and look right. Every
//! rig needs an emergency stop that works without any computer.
//!
//! Decisions such as D-12 are explained, with the evidence, in `docs/decisions.md` of the repository.

#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![cfg_attr(
    not(test),
    deny(
        clippy::arithmetic_side_effects,
        clippy::cast_possible_truncation,
        clippy::expect_used,
        clippy::indexing_slicing,
        clippy::panic,
        clippy::unwrap_used
    )
)]

#[cfg(any(test, feature = "std"))]
extern crate std;

pub mod device;
pub mod frame;
pub mod host;
pub mod lint;
pub mod message;
#[cfg(feature = "nom")]
pub mod nom;
mod side;
pub mod upload;

pub use frame::{
    DeviceReader, Dmc, Frame, FrameError, Frames, Header, HostReader, MessageId, MessageType, SmallFrames,
};
pub use message::{DeviceMessage, HostMessage};
pub use motion_core::machine::{Effect, Machine, Token};
#[cfg(feature = "alloc")]
pub use motion_core::owned::Owned;
pub use motion_core::parse::{ParseError, ParseProblem};
pub use motion_core::stream::{Item, Patience};
pub use motion_core::time::Millis;
pub use motion_core::wire::{Conduct, DecodeError, EncodeError, Fields, Messages, Purpose};
pub use side::{Device, Host};

#[doc = include_str!("../README.md")]
#[cfg(doctest)]
struct ReadmeDoctests;
