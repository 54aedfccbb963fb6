//! The client, or host: what controls a device.
//!
//! [`HostMachine`] makes the acquaintance of a device, keeps the line alive, asks one question of a kind at a time, keeps
//! what is known of the motors, and follows the move on the device by what the device says. It stops whatever moves, as
//! often as it takes. What is long stays with the application: the blocks of a move, and passwords; they are put in
//! where a message is made, from a [`Source`].
//!
//! # When do I call what
//!
//! | what happened | input |
//! |---|---|
//! | the user wants something | [`Input::Command`] |
//! | the connection of [`Event::Open`] is there, or none is (any more) | [`Input::Opened`], [`Input::Closed`] |
//! | a message came, or one cut short, or a fatal item | [`Input::Received`], [`Input::Malformed`], [`Input::Fatal`] |
//! | the time of [`Output::wake`](motion_core::machine::Output::wake) has come | [`Input::Wake`] |
//!
//! After each, send what is to be sent, in its order, then look at the events, then wait. Who is out there is for
//! [`discovery::Devices`](crate::discovery::Devices) to say; the machine only asks, if it is told to
//! ([`Options::ask_every`]).
//!
//! ```
//! use kos_proto::HostMessage;
//! use kos_proto::host::{Command, Endpoint, Event, HostMachine, Input, Options, Source};
//! use motion_core::machine::Machine;
//! use motion_core::time::Millis;
//!
//! let inputs = [Input::Command(Command::Connect(Endpoint::Usb)), Input::Opened, Input::Command(Command::Stop)];
//!
//! let mut host = HostMachine::new(Options::default());
//! let (mut wire, mut told) = (Vec::new(), Vec::new());
//! for (now, input) in (0..).map(Millis).zip(inputs) {
//!     let (next, output) = host.step(now, input);
//!     host = next;
//!     for send in &output.send {
//!         let mut message = [0; 64];
//!         let len = send.message(&Source::default()).encode_into(&mut message)?;
//!         wire.push(message[..len].to_vec());
//!     }
//!     told.extend(output.events); // show them
//!     let _ = output.wake; // wait for it, or for something to happen
//! }
//! assert_eq!(told, [Event::Open(Endpoint::Usb)]);
//! assert_eq!(wire, [&b"\x04\0\x06\0\x0f\x01"[..], b"\x04\0\x07\0\x80\0\x06"], "who are you, and stop");
//! # Ok::<(), kos_proto::EncodeError>(())
//! ```
//!
//! # Safety of people
//!
//! [`Command::Stop`] is sent in the step in which it comes, before anything else, whatever the machine waits for; it is
//! sent again every two seconds until the device confirms it, and first of all when a lost connection is there again.
//! Each time it is not confirmed the application is told. Commands that could move something twice are never repeated
//! ([`Send::is_repeatable`]).

mod calibration;
mod command;
mod io;
mod machine;
mod motors;
mod options;
mod received;
mod requests;
mod send;
mod tracker;

pub use calibration::State as CalibrationState;
pub use io::{CloseReason, Command, Endpoint, Event, Go, Input, Move, Refusal};
pub use machine::{HostMachine, State};
pub use options::{Identity, Options};
pub use requests::{Failure, Get, Token};
pub use send::{PasswordOf, Send, Source};
pub use tracker::State as MoveState;

/// Messages of one step, at most: a stop of everything, one of each of ten motors, a question behind it, a keep-alive,
/// and two questions that are asked again or next.
pub const SENDS: usize = 16;
/// Events of one step, at most: ten motors come or go, seven questions fail, ten stops are not confirmed, nor that of
/// everything; nobody is alive, a range fails, a move is slow. With a lost connection it is fewer.
pub const EVENTS: usize = 32;

/// What follows from a step of a client.
pub type Output = motion_core::machine::Output<Send, Event, SENDS, EVENTS>;
