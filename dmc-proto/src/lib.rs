//! Dragonframe DMC v2: the language between Dragonframe and a motion-control rig, for both sides.
//!
//! Dragonframe, the [host](HostMessage), asks; a controller, the [device](DeviceMessage), answers, and sends some
//! things unasked. Bytes become frames, frames become messages, and back. Nothing here does I/O, allocates, or panics.
//!
//! Reading: a stream brings bytes in pieces, [`Frames`] finds the frames in them, and each side decodes what the other
//! sent.
//!
//! ```
//! use dmc_proto::message::{Motor, StopReason};
//! use dmc_proto::{DeviceMessage, Frames, Item};
//!
//! // A lost byte, then a frame as a controller sends it when motor 2 runs into its upper limit.
//! let line = b"\x07DF\0\0\0\0\x3a\0\x02\0\x01\x02\x94\xa1";
//!
//! let mut frames: Frames = Frames::new();
//! assert_eq!(frames.push(line), line.len());
//! while let Some(item) = frames.next() {
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
//! Writing: a message writes its whole frame, length and check bytes included; [`lint`] says before what a device would
//! refuse.
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
//! A whole move is sent and stored with [`upload`].
//!
//! Two state machines know when to send what, and what a silence means: [`host::HostMachine`] controls,
//! [`device::DeviceMachine`] moves. An input goes in; messages to send, events to tell and the next wake come out. Both
//! modules begin with a table of what to call when, and a loop that drives the machine.
//!
//! ```
//! use dmc_proto::Millis;
//! use dmc_proto::host::{Command, Contents, Effect, HostMachine, Input, Options, State, StopTarget, Token, Transmit};
//!
//! let mut host = HostMachine::new(Options::default());
//! let output = host.advance(Millis(0), Input::LinkUp);
//! assert!(matches!(output.effects[..], [Effect::Transmit(Transmit { contents: Contents::Greeting, .. })]));
//! assert_eq!(host.state(), State::Greeting);
//! assert_eq!(output.wake, Some(Millis(1000)), "if the device has not said who it is by then, it is asked again");
//!
//! // A stop waits for nothing, not even for that.
//! let output = host.advance(Millis(5), Input::Command(Token(1), Command::Stop(StopTarget::All)));
//! let first = &output.effects[0];
//! assert!(matches!(first, Effect::Transmit(Transmit { contents: Contents::Stop(StopTarget::All), .. })));
//! ```
//!
//! # Units
//!
//! | type | on the wire | means |
//! |---|---|---|
//! | [`Motor`](message::Motor) | u8, from 1 | a motor |
//! | [`Steps`](message::Steps) | i32 | steps of a motor |
//! | [`Speed`](message::Speed), [`Acceleration`](message::Acceleration) | u32 | steps/s, steps/s² |
//! | [`JogSpeed`](message::JogSpeed) | u16, x100 | 0.01 to 100.00 % of a motor's speed |
//! | [`FrameNumber`](message::FrameNumber) | i32 | a frame of the shot |
//! | [`MoveTime`](message::MoveTime) | i32, x1000 | frames, in thousandths |
//! | [`FramesPerSecond`](message::FramesPerSecond) | u32, x1000 | frames a second |
//! | [`Milliseconds`](message::Milliseconds) | u32 | ms |
//! | [`Degrees`](message::Degrees) | u16 | degrees of a shutter |
//! | [`DmxChannel`](message::DmxChannel) | u16, from 1 | a DMX channel |
//! | [`VirtualPosition`](message::VirtualPosition) | i32, x100 000 | units of the rig, or degrees |
//! | [`Coordinate`](message::Coordinate), [`Length`](message::Length) | i32, u32, x1000 | units of the rig |
//!
//! # Safety of people
//!
//! The checksum does not tell a byte of 00 from one of FF: a position can arrive wrong and look right. Every rig needs
//! an emergency stop that no computer is part of.
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

pub use frame::{Dmc, Frame, FrameError, Frames, Header, MessageId, MessageType};
pub use message::{DeviceMessage, HostMessage};
pub use motion_core::machine::{Effect, Machine, Token};
#[cfg(feature = "alloc")]
pub use motion_core::owned::Owned;
pub use motion_core::stream::Item;
pub use motion_core::time::Millis;
pub use motion_core::wire::{Conduct, DecodeError, EncodeError, Fields, Messages, Purpose};
#[cfg(feature = "tokio")]
pub use side::{Codec, CodecItem};
pub use side::{Device, Host};

#[doc = include_str!("../README.md")]
#[cfg(doctest)]
struct ReadmeDoctests;
