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
//! let len = HostMessage::SetPositionSpeedAcceleration(jog).encode_checked(&Context::default(), &mut out)?;
//! assert_eq!(&out[..len], b"\x04\0\x14\0\x80\0\x1c\x03\x46\xc3\x50\0\x42\xc8\0\0\x42\xc8\0\0");
//! # Ok::<(), kos_proto::EncodeError>(())
//! ```
//!
//! A move of several motors is planned in seconds and rotations, checked, and looked at before it is played:
//! [`trajectory`].
//!
//! What to say when, and what a silence means, know two machines: [`host::HostMachine`] for a client and
//! [`device::DeviceMachine`] for a device. They are values: a step takes what happened at a moment, and gives what to
//! send, what to tell, and when to wake. Sockets, clock and motors are the caller's.
//!
//! | you have | call |
//! |---|---|
//! | bytes of a connection | [`Frames`], then [`HostMessage::decode`] or [`DeviceMessage::decode`] |
//! | reports over USB | [`usb`], then the same |
//! | a datagram | [`discovery`] |
//! | a message, a command, a report of the rig, or a deadline | `step` of a machine |
//! | what it wants to send | its `message`, then `encode_into` |
//! | a move | [`summary::MoveSummary::of`]: what it is to the machines, or why no device plays it |
//!
//! ```
//! use kos_proto::host::{Command, Endpoint, Event, HostMachine, Input, Options, Source};
//! use kos_proto::{DeviceMessage, Frame, HostMessage};
//! use motion_core::machine::Machine;
//! use motion_core::time::Millis;
//!
//! // What a device says of itself when it is asked, with the password "x".
//! let says = b"\x04\0\x20\0\x0f\x02\x0a\0\0\0\x01\0\x01\x05\0\0\0\x01x\0\0\0\0\0\0\0\0\0\0\0\0\0";
//! let message = DeviceMessage::decode(&Frame::decode(says)?)?;
//! let DeviceMessage::DeviceInfo(info) = message else { panic!("{message}") };
//! let source = Source { device_password: info.device_password, ..Source::default() };
//!
//! let inputs = [Input::Command(Command::Connect(Endpoint::Usb)), Input::Opened, Input::Received(message)];
//! let (mut host, mut wire) = (HostMachine::new(Options::default()), [0; 64]);
//! for (now, input) in (0..).map(Millis).zip(inputs) {
//!     let (next, output) = host.step(now, input);
//!     host = next;
//!     for send in &output.send {
//!         let len = send.message(&source).encode_into(&mut wire)?;
//!         println!("to the device: {:02x?}", &wire[..len]);
//!     }
//!     for event in &output.events {
//!         println!("to the user: {event:?}");
//!     }
//!     println!("until {:?}, or until something happens", output.wake);
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
//! silent connection after 30 seconds, and what a move does then nobody says. The machines obey a stop in every state,
//! in the step in which it comes, and say when it is not confirmed. Every rig needs an emergency stop that no
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
#[cfg(feature = "nom")]
pub mod nom;
mod side;
pub mod summary;
pub mod trajectory;
pub mod usb;

pub use frame::{Frame, FrameError, Frames, Header, Kos, MessageId, MessageType};
pub use message::{DeviceMessage, HostMessage};
#[cfg(feature = "alloc")]
pub use motion_core::owned::Owned;
pub use motion_core::stream::Item;
pub use motion_core::wire::{DecodeError, EncodeError};
#[cfg(feature = "tokio")]
pub use side::Codec;
pub use side::{Device, Host};

#[doc = include_str!("../README.md")]
#[cfg(doctest)]
struct ReadmeDoctests;
