//! `MoCoBus`, the protocol of Dynamic Perception's NMX motion controllers ("hoot"): typed messages of both sides,
//! without I/O, allocation or panics.
//!
//! A bus has one master and up to 254 nodes, each with three motors and a camera. The master sends a request and waits; the
//! node that is addressed answers with a response code and perhaps a value. Nothing in a reply says what it answers: the
//! query that was asked reads it. Bytes from a line, in pieces of any size, become frames, and frames become messages:
//!
//! ```
//! use hoot_proto::message::{Motor, MotorPosition, Steps};
//! use hoot_proto::{DeviceMessage, Frames, Item, Query};
//!
//! let query = MotorPosition { motor: Motor::One };
//! let mut frames = Frames::<84>::new();
//! let mut position = None;
//! for mut piece in [&b"\0\0\0\0\0\0\xFF\0\0\x01"[..], b"\x05\x03\xFF\xFF\xCF\xC7"] {
//!     while let Some(item) = frames.next_from(&mut piece) {
//!         match item {
//!             Item::Frame(frame) => match DeviceMessage::decode(&frame) {
//!                 DeviceMessage::Reply(reply) => position = Some(query.decode_reply(reply)?.value),
//!                 other => println!("not for the master: {other}"),
//!             },
//!             other => println!("{} bytes of noise", other.bytes().len()),
//!         }
//!     }
//! }
//! assert_eq!(position, Some(Steps(-12_345)));
//! # Ok::<(), hoot_proto::ReplyError>(())
//! ```
//!
//! A message is written at once, here after a check whether the node would accept it:
//!
//! ```
//! use hoot_proto::lint::Context;
//! use hoot_proto::message::{Direction, Motor, MotorMove, StepCount};
//! use hoot_proto::{Address, HostMessage};
//!
//! let motion = MotorMove::new(Motor::Two, Direction(1), StepCount(1000)).expect("1 to 16,777,215 steps");
//! let mut out = [0; 42];
//! let len = HostMessage::from(motion).encode_checked(Address::DEFAULT, &Context::default(), &mut out)?;
//! assert_eq!(out[..len], *b"\0\0\0\0\0\xFF\x03\x02\x0F\x05\x01\0\0\x03\xE8");
//! # Ok::<(), hoot_proto::EncodeError>(())
//! ```
//!
//! Most programs and firmware need a session: [`host::Session`] or [`device::Session`]. Bytes go in, and one `poll` gives what
//! to send, what happened, and how long to wait. Inside is a state machine.
//!
//! Two state machines decide when to send which message, what a silence means, and what must never be sent twice. Line,
//! clock and rig belong to the caller, who gives the inputs to the machine and carries out the effects in their order.
//! A master needs only this:
//!
//! ```
//! use hoot_proto::host::{Command, Effect, HostMachine, Input, Options};
//! use hoot_proto::{EncodeError, Frames, Item, Millis, Token};
//!
//! let (mut master, mut frames, mut line) = (HostMachine::new(Options::new()), Frames::<84>::new(), vec![]);
//! let mut advance = |now, input: Input<'_>| {
//!     let output = master.advance(Millis(now), input);
//!     let wake = output.wake;
//!     for effect in output {
//!         match effect {
//!             Effect::Event(event) => println!("{event:?}"),
//!             Effect::Transmit(transmit) => {
//!                 let mut packet = [0; 42];
//!                 let len = transmit.encode_into(&mut packet)?;
//!                 line.extend_from_slice(&packet[..len]);
//!             }
//!         }
//!     }
//!     Ok::<_, EncodeError>(wake)
//! };
//! advance(0, Input::LinkUp)?;
//! // Later nothing can come any more that answers something from before the line came up.
//! advance(5000, Input::Command(Token(1), Command::EmergencyStop))?;
//! let mut received = &b"\0\0\0\0\0\xFF\0\0\x01\0"[..];
//! while let Some(item) = frames.next_from(&mut received) {
//!     match item {
//!         Item::Frame(frame) => advance(5009, Input::received(&frame))?,
//!         _ => advance(5009, Input::Noise)?,
//!     };
//! }
//! let wake = advance(5049, Input::Wake)?;
//! assert_eq!(wake, Some(Millis(5060)), "60 ms after the first stop");
//! advance(5060, Input::Wake)?;
//! assert_eq!(line, b"\0\0\0\0\0\xFF\x03\x01\x04\0\0\0\0\0\0\xFF\x03\x02\x04\0", "motors 1 and 2 are told to stop");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! - [`host`]: the master, with a queue, repetitions of repeatable messages, stops that overtake everything, and the
//!   emergency stop. [`device`]: the node, with its link, settings, motors, camera and program. [`program`]: the
//!   positions of a planned move at each time.
//! - [`frame`]: the envelope, and three framings: [`Hoot`] finds packets in any noise, [`Requests`] finds those of a master,
//!   and [`Strict`] loses what firmware loses.
//! - [`message`]: [`HostMessage`], [`DeviceMessage`] and their fields. [`query`]: the meaning of replies, and the
//!   differences between firmware of different ages. [`lint`]: findings about messages that a node would refuse,
//!   misread or ignore.
//! - `beyond`, with the feature of that name: commands that the published sheet does not have.
//!
//! # Units
//!
//! | what | type | on the wire |
//! |---|---|---|
//! | position | [`Steps`](message::Steps) | steps of the present microstep setting, 32 bits with sign |
//! | length of a move | [`StepCount`](message::StepCount) | the same steps, 1 to 16,777,215; 0 would be a run without end |
//! | speed, acceleration, in commands | [`StepsPerSecond`](message::StepsPerSecond), [`StepsPerSecondSquared`](message::StepsPerSecondSquared) | IEEE binary32; the sign of a speed is its direction |
//! | speed, acceleration, in answers | [`Speed`](message::Speed), [`Acceleration`](message::Acceleration) | hundredths, 32 bits with sign |
//! | greatest speed | [`StepRate`](message::StepRate) | steps per second, 16 bits |
//! | voltage, current | [`Volts`](message::Volts), [`Amperes`](message::Amperes) | hundredths, 32 bits with sign |
//! | time | [`Milliseconds`](message::Milliseconds), [`ShortMilliseconds`](message::ShortMilliseconds) | 32 bits, of which 24 arrive; 16 bits |
//! | part of a program | [`Span`](message::Span), [`ShortSpan`](message::ShortSpan) | shots, or milliseconds in video mode |
//! | delay before the start | [`StartDelay`](message::StartDelay) | seconds, or milliseconds since 2015-07-20 |
//!
//! # Safety
//!
//! These messages move machines. There is no checksum, no answer tells which request it answers, and firmware
//! acknowledges many messages that it ignores. So ask for the state instead of trusting an OK. Never repeat a message
//! by yourself unless its [`conduct`](HostMessage::conduct) is repeatable; messages that start a motion are not.
//! Firmware drops the top byte of numbers of 32 bits, so constructors and `encode_checked` refuse numbers that would
//! not arrive. A bridge does not forward a broadcast stop, and a node in joystick mode refuses [`Stop`](message::Stop).
//! So to stop for certain, send [`MotorStop`](message::MotorStop) to each motor of each node. Keep an emergency stop in
//! hardware.
//!
//! # Features
//!
//! All features only add. None is on by default.
//!
//! | feature | what it brings |
//! |---|---|
//! | `beyond` | commands of later firmware, which the published sheet does not have |
//! | `alloc` | owned messages |
//! | `std` | `alloc`; nothing else needs the standard library, except some of the adapters |
//! | `bytes` | encoding into any `BufMut` |
//! | `serde` | `Serialize` for every message; with `alloc`, `Deserialize` for owned messages |
//! | `defmt` | `Format` for messages, units, codes, states and events, without text on the target |
//! | `arbitrary` | `Arbitrary` for every message, borrowed or owned; implies `std` |
//! | `tokio` | typed messages as a `tokio_util` codec; implies `std` |
//! | `embedded-io` | frames from an `embedded_io` reader |
//! | `nom` | frames and messages as nom parsers |

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

pub use frame::{Address, Frame, FrameError, Frames, Header, Hoot, NodeFrames, Requests, Selector, Strict, Table};
pub use message::{DeviceMessage, HostMessage};
pub use motion_core::machine::{Effect, Machine, Token};
#[cfg(feature = "alloc")]
pub use motion_core::owned::Owned;
pub use motion_core::parse::{ParseError, ParseProblem};
pub use motion_core::stream::Item;
pub use motion_core::time::Millis;
pub use motion_core::wire::{Conduct, DecodeError, EncodeError, Fields, Messages, Purpose};
pub use query::{AnyQuery, AnyReply, Query, ReplyError};
pub use side::{Device, Host};

#[doc = include_str!("../README.md")]
#[cfg(doctest)]
struct ReadmeDoctests;
