//! `MoCoBus`, the protocol of Dynamic Perception's NMX motion controllers ("hoot"): typed messages of both sides,
//! without I/O, allocation or panics.
//!
//! A bus has one master and up to 254 nodes, each with three motors and a camera. The master sends a request and waits;
//! the node that is addressed answers with a response code and perhaps a value. Nothing in a reply says what it
//! answers: the query that was asked reads it. Bytes from a line, in pieces of any size, become frames, and frames
//! become messages:
//!
//! ```
//! use hoot_proto::message::{Motor, MotorPosition, Steps};
//! use hoot_proto::{DeviceMessage, Frames, Item, Query};
//!
//! let query = MotorPosition { motor: Motor::One };
//! let mut frames = Frames::<84>::new();
//! let mut position = None;
//! for mut piece in [&b"\0\0\0\0\0\0\xFF\0\0\x01"[..], b"\x05\x03\xFF\xFF\xCF\xC7"] {
//!     while !piece.is_empty() {
//!         let taken = frames.push(piece);
//!         piece = &piece[taken..];
//!         while let Some(item) = frames.next() {
//!             match item {
//!                 Item::Frame(frame) => match DeviceMessage::decode(&frame) {
//!                     DeviceMessage::Reply(reply) => position = Some(query.decode_reply(reply)?.value),
//!                     other => println!("not for us: {other}"),
//!                 },
//!                 other => println!("{} bytes of noise", other.bytes().len()),
//!             }
//!         }
//!     }
//! }
//! assert_eq!(position, Some(Steps(-12_345)));
//! # Ok::<(), hoot_proto::ReplyError>(())
//! ```
//!
//! A message is written in one go, here after a look at whether the node would do what it says:
//!
//! ```
//! use hoot_proto::lint::Context;
//! use hoot_proto::message::{Direction, Motor, MotorMove, StepCount};
//! use hoot_proto::{Address, HostMessage};
//!
//! let motion = MotorMove::new(Motor::Two, Direction(1), StepCount(1000)).expect("1 to 16,777,215 steps");
//! let mut out = [0; 42];
//! let len = HostMessage::MotorMove(motion).encode_checked(Address::DEFAULT, &Context::default(), &mut out)?;
//! assert_eq!(out[..len], *b"\0\0\0\0\0\xFF\x03\x02\x0F\x05\x01\0\0\x03\xE8");
//! # Ok::<(), hoot_proto::EncodeError>(())
//! ```
//!
//! Two machines know when to send what, what a silence means, and what may never be sent twice. They are pure functions;
//! line, clock and rig are the caller's. Each input is a step; a step says what to send, what happened, and when to wake
//! the machine. This is all that a master needs:
//!
//! ```
//! use hoot_proto::host::{Command, HostMachine, Input, Options};
//! use hoot_proto::{DeviceMessage, EncodeError, Frames, Item};
//! use motion_core::machine::Machine;
//! use motion_core::time::Millis;
//!
//! let (mut master, mut frames, mut line) = (HostMachine::new(Options::default()), Frames::<84>::new(), vec![]);
//! let mut step = |now, input: Input<'_>| {
//!     let (next, output) = master.clone().step(Millis(now), input);
//!     master = next;
//!     output.events.iter().for_each(|event| println!("{event:?}"));
//!     for send in output.send {
//!         let mut packet = [0; 42];
//!         let len = send.encode_into(&mut packet)?;
//!         line.extend_from_slice(&packet[..len]);
//!     }
//!     Ok::<_, EncodeError>(output.wake)
//! };
//! step(0, Input::LinkUp)?;
//! step(5, Input::Command(Command::EmergencyStop))?;
//! frames.push(b"\0\0\0\0\0\xFF\0\0\x01\0");
//! while let Some(item) = frames.next() {
//!     let wake = match item {
//!         Item::Frame(frame) => step(14, Input::Received(DeviceMessage::decode(&frame)))?,
//!         _ => step(14, Input::Noise)?,
//!     };
//!     assert_eq!(wake, Some(Millis(65)), "60 ms behind the first stop");
//! }
//! step(65, Input::Wake)?;
//! assert_eq!(line, b"\0\0\0\0\0\xFF\x03\x01\x04\0\0\0\0\0\0\xFF\x03\x02\x04\0", "motors 1 and 2 are told to stop");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! - [`host`]: the master: a queue, retries of what may be repeated, stops that overtake all else, the emergency stop.
//!   [`device`]: the node: link, settings, motors, camera, program. [`program`]: where a planned move is, and when.
//! - [`frame`]: the envelope, and two framings: [`Hoot`] finds packets in any noise, [`Strict`] loses what firmware loses.
//! - [`message`]: [`HostMessage`], [`DeviceMessage`] and their fields. [`query`]: what replies mean, and what firmware of
//!   different ages does differently. [`lint`]: what is not wise. [`beyond`]: commands that the published sheet has not.
//!
//! # Units
//!
//! | what | type | on the wire |
//! |---|---|---|
//! | position | [`Steps`](message::Steps) | steps of the present microstep setting, 32 bits with sign |
//! | way to go | [`StepCount`](message::StepCount) | the same steps, 1 to 16,777,215; 0 would be for ever |
//! | speed, acceleration, set | [`StepsPerSecond`](message::StepsPerSecond), [`StepsPerSecondSquared`](message::StepsPerSecondSquared) | IEEE binary32; the sign of a speed is its direction |
//! | speed, acceleration, asked for | [`Speed`](message::Speed), [`Acceleration`](message::Acceleration) | hundredths, 32 bits with sign |
//! | greatest speed | [`StepRate`](message::StepRate) | steps a second, 16 bits |
//! | voltage, current | [`Volts`](message::Volts), [`Amperes`](message::Amperes) | hundredths, 32 bits with sign |
//! | time | [`Milliseconds`](message::Milliseconds), [`ShortMilliseconds`](message::ShortMilliseconds) | 32 bits, of which 24 arrive; 16 bits |
//! | part of a program | [`Span`](message::Span), [`ShortSpan`](message::ShortSpan) | shots, or milliseconds in video mode |
//! | delay before the start | [`StartDelay`](message::StartDelay) | seconds, or milliseconds since 2015-07-20 |
//!
//! # Safety
//!
//! This moves machines. There is no checksum, no answer says which request it is for, and firmware acknowledges much that
//! it does not do: ask for the state instead of trusting an OK. Never repeat by yourself what starts a movement, as
//! [`HostMessage::is_repeatable`] tells. Of numbers of 32 bits firmware drops the top byte: constructors and
//! `encode_checked` refuse what would not arrive. A broadcast stop does not pass a bridge, and the controller's
//! [`Stop`](message::Stop) is refused in joystick mode: to stop for certain, send [`MotorStop`](message::MotorStop) to
//! each motor of each node. An emergency stop belongs into hardware.

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

#[cfg(feature = "beyond")]
pub mod beyond;
pub mod device;
pub mod frame;
pub mod host;
pub mod lint;
pub mod message;
#[cfg(feature = "nom")]
pub mod nom;
pub mod program;
pub mod query;
mod side;

pub use frame::{Address, Frame, FrameError, Frames, Header, Hoot, Selector, Strict, Table};
pub use message::{DeviceMessage, HostMessage};
#[cfg(feature = "tokio")]
pub use motion_core::codec::Item as CodecItem;
pub use motion_core::machine::{Effect, Machine, Token};
#[cfg(feature = "alloc")]
pub use motion_core::owned::Owned;
pub use motion_core::stream::Item;
pub use motion_core::time::Millis;
pub use motion_core::wire::{Conduct, DecodeError, EncodeError, Purpose};
pub use query::{AnyQuery, AnyReply, Query, ReplyError};
#[cfg(feature = "tokio")]
pub use side::Codec;
pub use side::{Device, Host};

#[doc = include_str!("../README.md")]
#[cfg(doctest)]
struct ReadmeDoctests;
