//! A node as a pure function: what arrives and what the rig reports go in; replies, and what motors, camera and outputs
//! shall do, come out.
//!
//! The machine is the node: it keeps every parameter that a master sets or asks for. It moves nothing itself. The rig
//! behind it does what [`Event`]s say, and reports where its motors are.
//!
//! # When do I call what
//!
//! - A packet arrived: read it with the framing [`Strict`](crate::Strict), which loses what firmware loses, call
//!   `reset` on the stream behind each packet, and step with [`Input::Received`].
//! - A motor moved, came to its place, or failed; a contact or a measurement changed: step with the [`Input`] of that.
//! - The moment of `output.wake` has come: step with [`Input::Wake`].
//! - After each step do all events in their order, and send what is to be sent.
//!
//! ```
//! use hoot_proto::device::{DeviceMachine, Event, Input, Motion, Options, Port};
//! use hoot_proto::message::Motor;
//! use hoot_proto::{Frame, HostMessage};
//! use motion_core::machine::Machine;
//! use motion_core::time::Millis;
//!
//! let mut node = DeviceMachine::new(Options::default());
//! let mut reply = [0; 42];
//! // Where motor 1 is. The line, the clock and the rig are the caller's.
//! for (now, packet) in [(Millis(0), b"\0\0\0\0\0\xFF\x03\x01\x6A\0")] {
//!     let (next, _) = node.step(now, Input::Position { motor: Motor::One, position: (-5).into() });
//!     let frame = Frame::decode(packet)?;
//!     let message = HostMessage::decode(&frame);
//!     let (next, output) = next.step(now, Input::Received { port: Port::Usb, to: frame.address(), message });
//!     node = next;
//!     for event in output.events {
//!         match event {
//!             Event::Motor { motor, motion: Motion::Stop } => println!("stop motor {motor} at once"),
//!             event => println!("{event:?}"),
//!         }
//!     }
//!     for send in output.send {
//!         let len = send.answer.encode_into(&mut reply)?;
//!         assert_eq!((send.port, &reply[9..len]), (Port::Usb, &[5, 3, 0xFF, 0xFF, 0xFF, 0xFB][..]));
//!     }
//!     assert_eq!(output.wake, None, "nothing is to be done later");
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Rows, states and decisions: `docs/machines-hoot.md` and `docs/decisions-hoot.md` in the repository.

mod answer;
mod camera;
mod controller;
mod cycle;
mod link;
mod motor;
mod node;
mod options;
mod queries;
mod requests;

use motion_core::machine;

pub use answer::{Answer, Forward, Send};
pub use camera::{CameraSettings, CameraState, CameraUnit};
pub use controller::{AltOut, Controller};
pub use cycle::{Phase, Program, ProgramState};
pub use motor::{MotorSettings, MotorState, MotorUnit};
pub use node::DeviceMachine;
pub use options::{Options, Quirks, StoredName};

use crate::frame::Address;
use crate::message::{
    Amperes, Direction, HostMessage, Level, Microstep, Motor, RingTip, StepCount, Steps, StepsPerSecond, Volts,
};
use crate::program::Plan;

/// What a step of the machine gives.
///
/// Two replies answer one request at most. Of events there are at most 48: a step can set off each of three motors twice,
/// for what arrived and for what was due, and stop it once more often than that, each with its current; and there is
/// less than a dozen of program, camera, output and packet.
pub type Output = machine::Output<Send, Event, 2, 48>;

/// Where packets come from and go to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Port {
    /// The bus, RS-485.
    Bus,
    /// USB, where a master may be.
    Usb,
    /// Bluetooth, where a master may be.
    Bluetooth,
}

impl Port {
    /// Where a packet is passed on to that came from here: from a master to the bus, from the bus to both masters.
    ///
    /// Source: hoot, section 1.1.
    #[must_use]
    pub const fn beyond(self) -> &'static [Self] {
        match self {
            Self::Bus => &[Self::Usb, Self::Bluetooth],
            Self::Usb | Self::Bluetooth => &[Self::Bus],
        }
    }
}

/// A contact of the auxiliary connector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Contact {
    /// The ring.
    Ring,
    /// The tip.
    Tip,
}

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Input<'a> {
    /// A packet arrived, whoever it is for: read by [`HostMessage::decode`], replies of other nodes too.
    Received {
        /// Where.
        port: Port,
        /// Whom it is for.
        to: Address,
        /// What it says.
        message: HostMessage<'a>,
    },
    /// Bytes arrived that are no packet. Firmware is silent at them.
    Noise,
    /// The master of a port has gone. Programs and moves go on; the dead-man alone stops (hoot, section 4.3).
    LinkDown(Port),
    /// A master has come to a port.
    LinkUp(Port),
    /// Somebody at the node wants something.
    Command(Command),
    /// A motor is here, in steps of its present microstep setting.
    Position {
        /// Which motor.
        motor: Motor,
        /// Where.
        position: Steps,
    },
    /// A motor has come to where it was sent, or its way has ended.
    Arrived(Motor),
    /// A motor cannot go on. It is stopped, and a program pauses (decision H-5).
    Fault(Motor),
    /// The edge that counts came at a contact of the auxiliary connector.
    Alt(Contact),
    /// The common line asks for the next picture.
    CommonLine,
    /// The levels of the limit switches, as they are asked for.
    Limits(RingTip<Level>),
    /// The supply, as it is asked for.
    Supply {
        /// Its voltage.
        volts: Volts,
        /// Its current.
        amperes: Amperes,
    },
    /// Nothing but time.
    Wake,
}

/// What somebody at the node wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Command {
    /// Start the planned move, or go on with it.
    Start,
    /// Stop the planned move for a while.
    Pause,
    /// Stop everything, and forget how far the planned move was.
    Stop,
    /// The button for emergencies: all that moves stops, and a program pauses (hoot, section 4.2).
    EmergencyStop,
    /// The power has been off: what a node forgets then is forgotten.
    PowerUp,
}

/// What the rig shall do, or is told. The order counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Event {
    /// A motor shall do something.
    Motor {
        /// Which motor.
        motor: Motor,
        /// What.
        motion: Motion,
    },
    /// The lines of the camera shall be so.
    Camera {
        /// Whether the focus is held.
        focus: bool,
        /// Whether the shutter is held.
        shutter: bool,
    },
    /// The auxiliary output shall be on or off. Which level is on, [`Controller::out_level`] says.
    AltOut {
        /// Whether it is on.
        on: bool,
    },
    /// Tell the other nodes by the common line that the next picture comes.
    CommonLine,
    /// Switch the lamp for debugging: on, or off if it is on.
    DebugLed,
    /// The planned move became this.
    Program(ProgramState),
    /// Something was set; it may be worth keeping over the next power-up.
    Set(Part),
    /// The node has this address from now on; its USB port keeps the old one until power-up (hoot, section 2.5).
    Address(Address),
    /// Pass the packet that has just arrived on, as it is.
    Forward(Forward),
    /// The packet that has just arrived was not answered.
    Ignored(Ignored),
}

/// What a motor shall do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Motion {
    /// Stop at once. From now on the node says that it rests.
    Stop,
    /// Move by so many steps, at the speed of [`MotorSettings::speed`].
    By {
        /// Which way.
        direction: Direction,
        /// How far.
        steps: StepCount,
    },
    /// Move to a place; from wherever it goes to now, if it moves.
    To(Steps),
    /// Run until told otherwise.
    Run {
        /// Which way, as the command said.
        direction: Direction,
        /// How fast; a negative speed turns the way round.
        speed: StepsPerSecond,
    },
    /// Go on running at another speed, with the acceleration that was set; another sign turns the way round.
    Speed(StepsPerSecond),
    /// Follow a plan in milliseconds, at whose moment `elapsed` it is now.
    Along {
        /// The plan, whose [`Plan::at`] says where to be.
        plan: Plan,
        /// How many milliseconds of it are over.
        elapsed: u32,
    },
    /// Count positions from here on in other microsteps; the motor rests.
    Microstep(Microstep),
    /// Take this from all positions of the motor, so that what it goes to stays where it is on the rig.
    Rebase {
        /// How many steps.
        by: Steps,
    },
    /// Give the motor current, or take it away while it rests.
    Power(bool),
}

/// A part of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Part {
    /// The controller itself.
    Controller,
    /// A motor.
    Motor(Motor),
    /// The camera.
    Camera,
}

/// Why a packet, or what was no packet, was not answered. Source: hoot, sections 1.1 and 4.1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Ignored {
    /// It was no packet.
    Noise,
    /// It was command 0, to whomever. Replies that refuse look like it, so a bridge loses them.
    Noop,
    /// It was a broadcast that does not exist, or gives an address that no node can have.
    Broadcast,
    /// The node has no such command, and its firmware is silent then.
    Unknown,
    /// The firmware does it without a word: the speed of runs in joystick mode.
    Silent,
    /// The node hears nothing, for its address has just changed.
    Deaf,
}
