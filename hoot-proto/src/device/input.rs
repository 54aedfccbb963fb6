//! Inputs of a node: what arrived, what the rig reports, and what people at the node want.

use motion_core::display;

use crate::frame::{Address, Frame};
use crate::message::{Amperes, HostMessage, Level, Motor, RingTip, Steps, Volts};

/// Port of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
pub enum Port {
    /// The bus, RS-485.
    Bus,
    /// USB, where a master may be.
    Usb,
    /// Bluetooth, where a master may be.
    Bluetooth,
}

impl Port {
    /// Ports to which a packet for another receiver is forwarded: from a master to the bus, from the bus to both masters.
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

/// Contact of the auxiliary connector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Contact {
    /// The ring.
    Ring,
    /// The tip.
    Tip,
}

display! {
    Port {
        Bus => "bus";
        Usb => "USB";
        Bluetooth => "Bluetooth";
    }

    Contact {
        Ring => "ring";
        Tip => "tip";
    }
}

/// Something that happened to a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Input<'a> {
    /// A packet arrived, for this node or for another receiver. Replies of other nodes are decoded as [`HostMessage`] too.
    Received {
        /// Port on which it arrived.
        port: Port,
        /// Address of the receiver.
        to: Address,
        /// The message.
        message: HostMessage<'a>,
    },
    /// Bytes arrived that are no packet. Firmware does not answer them.
    Noise,
    /// A master connected to a port.
    LinkUp(Port),
    /// The master of a port disconnected. Programs and moves go on; only the dead-man stops them (hoot, section 4.3).
    LinkDown(Port),
    /// A person at the node wants something.
    Command(Command),
    /// A motor has a new position.
    Position {
        /// The motor.
        motor: Motor,
        /// Position in steps of the present microstep setting.
        position: Steps,
    },
    /// A motor reached the end of its move.
    Arrived(Motor),
    /// A motor cannot go on. It is stopped, and a program pauses (decision H-5).
    Fault(Motor),
    /// The edge that counts came at a contact of the auxiliary connector.
    Alt(Contact),
    /// The common line asks for the next picture.
    CommonLine,
    /// Levels of the limit switches, for the query about them.
    Limits(RingTip<Level>),
    /// Supply of the node, for the queries about it.
    Supply {
        /// Voltage of the supply.
        volts: Volts,
        /// Current of the supply.
        amperes: Amperes,
    },
    /// The time of the last wake came, or nothing happened.
    Wake,
}

impl<'a> Input<'a> {
    /// Input of a packet that arrived on a port.
    #[must_use]
    pub fn received(port: Port, frame: &Frame<'a>) -> Self {
        Self::Received { port, to: frame.address(), message: HostMessage::decode(frame) }
    }
}

/// Something that a person at the node wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Command {
    /// Starts the planned move, or resumes it.
    Start,
    /// Pauses the planned move.
    Pause,
    /// Stops everything and forgets how far the planned move was.
    Stop,
    /// The emergency button: stops everything that moves and pauses a program (hoot, section 4.2).
    EmergencyStop,
    /// The power was off and is on again: forgets what a node forgets then.
    PowerUp,
}
