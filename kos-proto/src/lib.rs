//! Kessler kOS: the language between a client and a motion-control device such as Second Shooter, for both sides.
//!
//! The client, or [host](HostMessage), sets and asks; the [device](DeviceMessage) answers, and tells unasked what
//! happens. Bytes become frames, frames become messages, and back. Nothing here does I/O, allocates, or panics.
//!
//! Reading: a stream brings bytes in pieces, [`Frames`] finds the frames in them, and each side decodes
//! what the other sent.
//!
//! ```
//! use kos_proto::message::MotorAddress;
//! use kos_proto::{DeviceMessage, Frames, Item};
//!
//! // A motor as a device of the older dialect tells of it, in three pieces.
//! let line = b"\x04\0\x1c\0\x0b\x02\x01\x03\x41\x3f\xb8\0\0\0\0\0\x42\xc8\0\0\x42\x82\0\0\x42\x48\0\0";
//!
//! let mut frames: Frames = Frames::new();
//! for piece in line.chunks(10) {
//!     assert_eq!(frames.push(piece), piece.len());
//!     while let Some(item) = frames.next() {
//!         match item {
//!             Item::Frame(frame) => match DeviceMessage::decode(&frame)? {
//!                 DeviceMessage::MotorInfo(info) => {
//!                     let motor = info.motors.iter().next().expect("one motor a message");
//!                     assert_eq!((motor.motor_address, motor.is_calibrated()), (MotorAddress(3), false));
//!                 }
//!                 message => println!("{message}"),
//!             },
//!             Item::Noise { why, .. } => println!("{why}"),
//!             Item::Fatal(why) => panic!("close the connection: {why}"),
//!             Item::Corrupt { .. } => unreachable!("kOS has no checksum"),
//!         }
//!     }
//! }
//! # Ok::<(), kos_proto::DecodeError>(())
//! ```
//!
//! Writing: a message writes all of itself, header included; [`lint`] says before what a device would refuse. Over TCP
//! it goes as it is; over USB, in reports of 64 bytes, which [`usb`] makes and reads. By UDP clients and devices find
//! each other: a datagram is one message, and [`discovery`] keeps who was heard of.
//!
//! ```
//! use kos_proto::HostMessage;
//! use kos_proto::lint::Context;
//! use kos_proto::message::{MotorAddress, RotationsPerSecond, RotationsPerSecondSquared, SetPositionSpeedAcceleration};
//!
//! let (speed, acceleration) = (RotationsPerSecond(100.0), RotationsPerSecondSquared(100.0));
//! let jog = SetPositionSpeedAcceleration::jog(MotorAddress(3), speed, acceleration);
//! let mut out = [0; 64];
//! let len = HostMessage::from(jog).encode_checked(&Context::default(), &mut out)?;
//! assert_eq!(&out[..len], b"\x04\0\x14\0\x80\0\x1c\x03\x46\xc3\x50\0\x42\xc8\0\0\x42\xc8\0\0");
//! # Ok::<(), kos_proto::EncodeError>(())
//! ```
//!
//! A move of several motors is planned in seconds and rotations, checked, and looked at before it is played:
//! [`trajectory`].
//!
//! Two state machines know when to send what, and what a silence means: [`host::HostMachine`] for a client and
//! [`device::DeviceMachine`] for a device. They are values without sockets, clock and motors, which are the caller's.
//!
//! | you have | call |
//! |---|---|
//! | bytes of a connection | [`Frames`], then [`HostMessage::decode`] or [`DeviceMessage::decode`] |
//! | reports over USB | [`usb`], then the same |
//! | a datagram | [`discovery`] |
//! | a frame, a command, a report of the rig, or the time of a wake | `advance` of a machine |
//! | a `Transmit` of a machine | its `message`, then `encode_into` |
//! | a move | [`MoveSummary::of`]: what the machines know of it, or why no device plays it |
//!
//! Each call of a machine returns effects, to be carried out in their order, and a time at which to wake it:
//!
//! ```
//! use kos_proto::host::{Command, Endpoint, HostMachine, Input, Options, Source, Token};
//! use kos_proto::{Effect, Frame, Millis};
//!
//! // The answer of a device with the password "x" to the question what it is.
//! let answer = b"\x04\0\x20\0\x0f\x02\x0a\0\0\0\x01\0\x01\x05\0\0\0\x01x\0\0\0\0\0\0\0\0\0\0\0\0\0";
//! let inputs = [
//!     Input::Command(Token(1), Command::Connect(Endpoint::Usb)),
//!     Input::LinkUp,
//!     Input::received(&Frame::decode(answer)?),
//! ];
//!
//! let (mut host, mut wire) = (HostMachine::new(Options::default()), [0; 64]);
//! for (now, input) in (0..).map(Millis).zip(inputs) {
//!     let output = host.advance(now, input);
//!     println!("wait until {:?}, or until something happens", output.wake);
//!     for effect in output {
//!         match effect {
//!             Effect::Transmit(transmit) => {
//!                 let len = transmit.message(&Source::default()).encode_into(&mut wire)?;
//!                 println!("to the device: {:02x?}", &wire[..len]);
//!             }
//!             Effect::Event(event) => println!("to the user: {event:?}"),
//!         }
//!     }
//! }
//! assert_eq!(host.state().name(), "AwaitMotorInfo");
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```
//!
//! # Units
//!
//! | type | on the wire | means |
//! |---|---|---|
//! | [`MotorAddress`](message::MotorAddress) | u8, 1 to 10 | a motor; bit 7: focus, iris or zoom |
//! | [`Rotations`](message::Rotations) | f32 | rotations of a motor |
//! | [`RotationsPerSecond`](message::RotationsPerSecond) | f32 | rev/s |
//! | [`RotationsPerSecondSquared`](message::RotationsPerSecondSquared) | f32 | rev/s² |
//! | [`Seconds`](message::Seconds) | f32 | s |
//! | [`Normalized`](message::Normalized) | f32 | 0 to 1, of a move or of a motor's range |
//! | [`Photos`](message::Photos) | f32 | a number of photos |
//!
//! Devices report positions between the ends of a motor's range, but take commands from 0 on:
//! [`Motor::relative_position`](message::Motor::relative_position) turns one into the other.
//!
//! # Safety of people
//!
//! A position of 0 is a place to go to; what stops a motor is a speed of 0, as
//! [`stop`](message::SetPositionSpeedAcceleration::stop) sends it, and `StopPlayback` stops all. The device drops a
//! silent connection after 30 seconds, and nothing says what a move does then. The machines obey a stop in every state,
//! in the call in which it comes, and tell when it is not confirmed. Every rig needs an emergency stop that no
//! computer is part of. The password goes over the line in clear, to anyone who asks: it is no protection.
//!
//! Decisions such as K-F3 are explained, with the evidence, in `docs/decisions.md` of the repository.

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
pub mod discovery;
pub mod frame;
pub mod host;
pub mod lint;
pub mod message;
pub mod move_summary;
#[cfg(feature = "nom")]
pub mod nom;
mod side;
mod times;
pub mod trajectory;
mod transport;
pub mod usb;

pub use frame::{Frame, FrameError, Frames, Header, Kos, MessageId, MessageType};
pub use message::{DeviceMessage, HostMessage};
pub use motion_core::machine::{Effect, Machine, Token};
#[cfg(feature = "alloc")]
pub use motion_core::owned::Owned;
pub use motion_core::stream::Item;
pub use motion_core::time::Millis;
pub use motion_core::wire::{Conduct, DecodeError, EncodeError, Fields, Messages, Purpose};
pub use move_summary::MoveSummary;
#[cfg(feature = "tokio")]
pub use side::{Codec, CodecItem};
pub use side::{Device, Host};
pub use transport::Transport;

#[doc = include_str!("../README.md")]
#[cfg(doctest)]
struct ReadmeDoctests;
