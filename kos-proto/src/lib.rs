//! Kessler kOS, the protocol between a client and a motion-control device such as Second Shooter, for both sides.
//!
//! The client, or [host](HostMessage), sends settings and questions. The [device](DeviceMessage) sends answers and
//! unasked reports. The crate turns bytes into frames and frames into messages, and messages into bytes. It does no
//! I/O, does not allocate, and does not panic.
//!
//! Reading: the bytes of a stream come in pieces. [`Frames`] finds the frames in them, and each side decodes the
//! messages of the other side.
//!
//! ```
//! use kos_proto::message::MotorAddress;
//! use kos_proto::{DeviceMessage, Frames, Item};
//!
//! // A motor as a device of the older dialect reports it, in three pieces.
//! let line = b"\x04\0\x1c\0\x0b\x02\x01\x03\x41\x3f\xb8\0\0\0\0\0\x42\xc8\0\0\x42\x82\0\0\x42\x48\0\0";
//!
//! let mut frames: Frames = Frames::new();
//! for mut piece in line.chunks(10) {
//!     while let Some(item) = frames.next_from(&mut piece) {
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
//! Writing: a message is written with its header. Before that, [`lint`] says what a device would refuse. Over TCP, the
//! bytes are sent as they are. Over USB, they are sent in reports of 64 bytes, which [`usb`] makes and reads. Clients
//! and devices find each other over UDP, where a datagram is one message; [`discovery`] keeps a list of the devices
//! that were heard.
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
//! [`trajectory`] plans a move of several motors in seconds and rotations, checks it, and shows its curves before it is
//! played.
//!
//! Most programs and firmware need a session: [`host::Session`] or [`device::Session`]. Bytes go in, and one `poll` gives what
//! to send, what happened, and how long to wait. Inside is a state machine.
//!
//! Two state machines know when to send which message, and what silence means: [`host::HostMachine`] for a client and
//! [`device::DeviceMachine`] for a device. They are values without sockets, clock and motors, which belong to the
//! caller.
//!
//! | you have | call |
//! |---|---|
//! | bytes of a connection | [`Frames`], then [`HostMessage::decode`] or [`DeviceMessage::decode`] |
//! | reports over USB | [`usb`], then the same |
//! | a datagram | [`discovery`] |
//! | a frame, a command, a report of the rig, or a time at which to wake | `advance` of a machine |
//! | a `Transmit` of a machine | its `message`, then `encode_into` |
//! | a move | [`MoveSummary::of`]: its times, photos and motors, or why no device can play it |
//!
//! Each call of a machine returns effects, which the caller carries out in their order, and a time at which to wake the
//! machine:
//!
//! ```
//! use kos_proto::host::{Command, Endpoint, HostMachine, Input, Options, Source, Token};
//! use kos_proto::{Effect, Frame, Millis};
//!
//! // The `DeviceInfo` of a device with the password "x", as the answer to `GetDeviceInfo`.
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
//! | [`MotorAddress`](message::MotorAddress) | u8, 1 to 10 | address of a motor; bit 7 marks focus, iris and zoom |
//! | [`Rotations`](message::Rotations) | f32 | rotations of a motor |
//! | [`RotationsPerSecond`](message::RotationsPerSecond) | f32 | rev/s |
//! | [`RotationsPerSecondSquared`](message::RotationsPerSecondSquared) | f32 | rev/s² |
//! | [`Seconds`](message::Seconds) | f32 | s |
//! | [`Normalized`](message::Normalized) | f32 | 0 to 1, of a move or of a motor's range |
//! | [`Photos`](message::Photos) | f32 | number of photos |
//!
//! Devices report positions between the ends of the range of a motor, but commands count from 0 at its begin.
//! [`Motor::relative_position`](message::Motor::relative_position) turns a reported position into a commanded one.
//!
//! # Safety of people
//!
//! - A position of 0 is a place to go to, and does not stop a motor. A speed of 0 stops a motor, as in the message that
//!   [`stop`](message::SetPositionSpeedAcceleration::stop) makes. `StopPlayback` stops all motors.
//! - The device drops a silent connection after 30 seconds. The specification does not say what a move does then.
//! - The machines obey a stop in every state, in the call in which it comes. They report a stop that is not confirmed.
//! - Every rig needs an emergency stop that no computer is part of.
//! - The device sends its password in clear to every client that asks, so the password is no protection.
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

pub use frame::{CommandFrames, Frame, FrameError, Frames, Header, Kos, MessageId, MessageType};
pub use message::{DeviceMessage, HostMessage};
pub use motion_core::machine::{Effect, Machine, Token};
#[cfg(feature = "alloc")]
pub use motion_core::owned::Owned;
pub use motion_core::parse::{ParseError, ParseProblem};
pub use motion_core::stream::Item;
pub use motion_core::time::Millis;
pub use motion_core::wire::{Conduct, DecodeError, EncodeError, Fields, Messages, Purpose};
pub use move_summary::MoveSummary;
pub use side::{Device, Host};
pub use transport::Transport;

#[doc = include_str!("../README.md")]
#[cfg(doctest)]
struct ReadmeDoctests;
