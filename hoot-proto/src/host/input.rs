//! Inputs of a master: what happened, and what the application wants.

use motion_core::machine::Token;

use super::Nodes;
use crate::frame::{Address, Frame};
use crate::message::{DeviceMessage, HostMessage, Motor, StepsPerSecond};

/// Something that happened to a master.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Input<'a> {
    /// The line came up.
    LinkUp,
    /// The line went down.
    LinkDown,
    /// A packet arrived.
    Received(DeviceMessage<'a>),
    /// Bytes arrived that are no packet.
    Noise,
    /// The application wants something. The command ends once, in an [`Event::Ended`](super::Event::Ended) with the token.
    Command(Token, Command),
    /// The time of the last wake came, or nothing happened.
    Wake,
}

impl<'a> Input<'a> {
    /// Input of a packet that arrived.
    #[must_use]
    pub fn received(frame: &Frame<'a>) -> Self {
        Self::Received(DeviceMessage::decode(frame))
    }
}

/// A message for a node, or for all nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Request {
    /// Address of the node; [`Address::BROADCAST`] for broadcasts.
    pub to: Address,
    /// The message.
    pub message: HostMessage<'static>,
}

/// Something that the application wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Command {
    /// Sends a message. A stop overtakes everything, and removes from the queue the messages that may move what it stops.
    Request(Request),
    /// Sends a broadcast through a bridge, although it reaches only the attached node (safety decision 4).
    Insist(Request),
    /// Sets the speed of a motor, as a joystick does many times a second. A new speed replaces a speed of the same motor
    /// that still waits.
    ///
    /// Some firmware does not answer it, so [`Outcome::NotConfirmed`](super::Outcome::NotConfirmed) is a usual end. A speed
    /// of 0 without an OK is followed by a stop of the motor (decision H-24).
    Speed {
        /// Address of the node.
        to: Address,
        /// The motor.
        motor: Motor,
        /// Speed of the motor.
        speed: StepsPerSecond,
    },
    /// Keeps the dead-man of a node from stopping its motors: the master asks the node something harmless whenever it has
    /// sent it nothing else for a while (decision H-25).
    KeepAlive {
        /// Address of the node.
        to: Address,
        /// Whether to do so from now on.
        on: bool,
    },
    /// Replaces the list of nodes that an emergency stop addresses.
    Nodes(Nodes),
    /// Stops each motor of each listed node, until each motor rests. Nothing is sent before it. The command ends as sent;
    /// [`Event::Stopped`](super::Event::Stopped) or [`Event::StopNotConfirmed`](super::Event::StopNotConfirmed) follows.
    EmergencyStop,
    /// Gives up an emergency stop that is not confirmed. Without an emergency stop it changes nothing.
    EndEmergency,
}
