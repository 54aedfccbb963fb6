//! The device: a rig, and up to four clients that are connected to it.
//!
//! [`DeviceMachine`] knows what to answer, who may say what, where the motors may go, and how a move is made ready,
//! played and stopped. It moves no motor: it tells the rig what to do, by events, and is told what happened, by
//! [`Report`]s. What is long stays with the caller: the stored move, the password, what the motors can do; they are put
//! in where a message is made, from a [`Profile`].
//!
//! # When do I call what
//!
//! | what happened | input |
//! |---|---|
//! | the device runs | [`Report::Started`] |
//! | a client connects, or is gone | [`Input::Opened`], [`Input::Closed`] |
//! | a message came, or one cut short, or a fatal item | [`Input::Received`], [`Input::Malformed`], [`Input::Fatal`] |
//! | a datagram came | [`Input::Datagram`] |
//! | the rig has something to say | [`Input::Rig`] |
//! | the time of [`Output::wake`](motion_core::machine::Output::wake) has come | [`Input::Wake`] |
//!
//! After each, do the events in their order, then send what is to be sent, then wait.
//!
//! ```
//! use kos_proto::device::{DeviceMachine, Event, Input, Options, Profile, Report, Scratch, SessionId, To};
//! use kos_proto::message::{MotorAddress, RotationsPerSecond, RotationsPerSecondSquared, SetPositionSpeedAcceleration};
//! use kos_proto::summary::Transport;
//! use kos_proto::{DeviceMessage, HostMessage};
//! use motion_core::machine::Machine;
//! use motion_core::time::Millis;
//! use motion_core::wire::Password;
//!
//! let (session, password) = (SessionId(0), Password(b""));
//! let (speed, acceleration) = (RotationsPerSecond(20.0), RotationsPerSecondSquared(50.0));
//! let jog = SetPositionSpeedAcceleration::jog(MotorAddress(1), speed, acceleration);
//! let inputs = [
//!     Input::Rig(Report::Started),
//!     Input::Opened { session, transport: Transport::Tcp, password },
//!     Input::Received { session, message: HostMessage::SetPositionSpeedAcceleration(jog), password },
//! ];
//!
//! let mut device = DeviceMachine::new(Options::default());
//! let mut told = Vec::new();
//! for (now, input) in (0..).map(Millis).zip(inputs) {
//!     let (next, output) = device.step(now, input);
//!     device = next;
//!     told.extend(output.events); // do them
//!     for send in &output.send {
//!         let mut scratch = Scratch::default();
//!         match send.message(&Profile::default(), &mut scratch) {
//!             DeviceMessage::NetworkInfo(_) => assert_eq!(send.to, To::Broadcast),
//!             message => panic!("{message}"),
//!         }
//!     }
//!     assert!(output.wake > Some(now)); // wait for it, or for something to happen
//! }
//! assert!(matches!(told[..], [Event::Move { motor: MotorAddress(1), .. }]));
//! ```
//!
//! # Safety of people
//!
//! A stop is obeyed in every state, in the step in which it comes, whoever sends it, locked or not. While a move runs,
//! nothing else that a client says moves a motor, and the stop of any one motor stops the move (safety decisions 1 and
//! 2). A client that is gone takes along what it moved by hand; a move goes on, unless the options say otherwise.

mod hand;
mod io;
mod lapse;
mod machine;
pub mod motor;
mod options;
pub mod playback;
mod send;
pub mod session;

use arrayvec::ArrayVec;

pub use io::{Event, Ignored, Input, Report};
pub use machine::{DeviceMachine, Link};
pub use options::Options;
pub use send::{Doing, MotorProfile, MotorReport, Profile, Scratch, Send, To, What};
pub use session::{CloseReason, SESSIONS, SessionId, Sessions};

use self::machine::Turn;
use crate::message::MotorPlace;
use crate::summary::MOTORS;

/// Where the motors are.
pub type Positions = ArrayVec<MotorPlace, MOTORS>;

/// Messages of one step, at most: ten motors are told of, or a stop says that all is over and where ten motors rest;
/// with that may come an announcement, addresses over TCP, and two steps of a move.
pub const SENDS: usize = 16;
/// Events of one step, at most: four connections are closed, ten motors are stopped for it, and the move with them; with
/// that may come two steps of a move, and what was ignored.
pub const EVENTS: usize = 20;

/// What follows from a step of a device.
pub type Output = motion_core::machine::Output<Send, Event, SENDS, EVENTS>;
