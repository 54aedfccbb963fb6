//! The messages, a file a chapter of the specification.
//!
//! [`HostMessage`] is what the master sends: commands and queries. [`DeviceMessage`] is what a node sends, which is
//! always a [`Reply`]. Nothing in a reply says what it answers; the [`Query`](crate::Query) that was asked does.

mod broadcast;
mod main;
mod motor;
mod name;
mod reply;
mod sub;

pub use broadcast::{AnySubAddress, BroadcastAssignAddress, BroadcastPause, BroadcastStart, BroadcastStop};
pub use main::{NameQuery, Pause, RunState, RunStatus, SetName, Start, Stop, Voltage, Volts};
pub use motion_core::wire::Other;
pub use motor::{
    Direction, Motor, MotorMove, MotorPosition, MotorRun, MotorRunning, MotorSetContinuousSpeed, MotorStop, StepCount,
    Steps, StepsPerSecond,
};
pub use name::Name;
pub use reply::{Reply, ResponseCode, Text, Value, ValueType};

use motion_core::messages;
use motion_core::wire::{EncodeError, Messages};

use crate::frame::{self, Address, Frame, Selector};

messages! {
    /// What the master sends.
    ///
    /// The numbers of this table are those of [`Selector::number`]: 1 in front for a broadcast, then the command, then
    /// the sub-address. A command has exactly the data that the table says; with data of another length it is `Other`,
    /// because the firmware takes that as well: it reads missing bytes as zero and leaves out surplus ones.
    pub enum HostMessage<'a> {
        /// Start or resume the planned move: command 2 of the controller.
        0x02_00 => Start(Start),
        /// Pause the planned move: command 3 of the controller.
        0x03_00 => Pause(Pause),
        /// Stop everything: command 4 of the controller.
        0x04_00 => Stop(Stop),
        /// Give the node a name: command 7 of the controller.
        0x07_00 => SetName(SetName),
        /// Does the planned move run? Query 101 of the controller.
        0x65_00 => RunStatus(RunStatus),
        /// What is the node called? Query 105 of the controller.
        0x69_00 => Name(NameQuery),
        /// What is the supply voltage? Query 107 of the controller.
        0x6B_00 => Voltage(Voltage),

        /// Stop one motor: command 4 of a motor.
        0x04_01..=0x04_03 => MotorStop(MotorStop),
        /// Set the speed of continuous runs: command 13 of a motor.
        0x0D_01..=0x0D_03 => MotorSetContinuousSpeed(MotorSetContinuousSpeed),
        /// Move by a number of steps: command 15 of a motor.
        0x0F_01..=0x0F_03 => MotorMove(MotorMove)
            or
            /// Run until told otherwise: command 15 of a motor, with no steps.
            MotorRun(MotorRun),
        /// Where is the motor? Query 106 of a motor.
        0x6A_01..=0x6A_03 => MotorPosition(MotorPosition),
        /// Does the motor move? Query 107 of a motor.
        0x6B_01..=0x6B_03 => MotorRunning(MotorRunning),

        /// All nodes: start or resume the planned moves. Broadcast 1.
        0x1_01_00..=0x1_01_FF => BroadcastStart(BroadcastStart),
        /// All nodes: stop everything. Broadcast 2.
        0x1_02_00..=0x1_02_FF => BroadcastStop(BroadcastStop),
        /// All nodes: pause the planned moves. Broadcast 3.
        0x1_03_00..=0x1_03_FF => BroadcastPause(BroadcastPause),
        /// All nodes: take this address. Broadcast 4.
        0x1_04_00..=0x1_04_FF => BroadcastAssignAddress(BroadcastAssignAddress),
    }
}

messages! {
    /// What a node sends.
    ///
    /// The numbers of this table are `address << 16 | sub_address << 8 | response code`. A packet that is not addressed
    /// to the master is `Other`: an echo, or traffic between others.
    pub enum DeviceMessage<'a> {
        /// The answer to a request.
        0x00..=0xFF => Reply(Reply<'a>),
    }
}

impl<'a> HostMessage<'a> {
    /// Reads the command in a packet from the master.
    ///
    /// It cannot fail: an unknown command, and a known one with data of another length, is `Other`.
    #[must_use]
    #[inline]
    pub fn decode(frame: &Frame<'a>) -> Self {
        let number = frame.header().selector().number();
        Self::decode_body(number, frame.payload()).unwrap_or_else(|_| Self::other(number, frame.payload()))
    }

    /// What selects the command.
    #[must_use]
    #[inline]
    pub fn selector(&self) -> Selector {
        Selector::from_number(self.number())
    }

    /// Bytes of its whole packet.
    #[must_use]
    #[inline]
    pub fn encoded_len(&self) -> usize {
        frame::frame_len(self.body_len())
    }

    /// Writes its whole packet to the front of `out`, and says how many bytes it took.
    ///
    /// Broadcasts go to [`Address::BROADCAST`], and nothing else does: their numbers mean other commands.
    ///
    /// # Errors
    ///
    /// [`EncodeError`], if the packet does not fit, a reader would take it for another command, or a node has no room
    /// for it. Then nothing is written.
    #[inline]
    pub fn encode_into(&self, to: Address, out: &mut [u8]) -> Result<usize, EncodeError> {
        let Selector { broadcast, command, sub_address } = self.selector();
        if broadcast != (to == Address::BROADCAST) {
            let (min, max) = if broadcast { (1, 1) } else { (2, 255) };
            return Err(EncodeError::OutOfRange { what: "address", value: to.0.into(), min, max });
        }
        frame::envelope([to.0, sub_address, command], self.body_len(), out, |place| self.encode_body(place))
    }
}

impl<'a> DeviceMessage<'a> {
    /// Reads a packet from a node. It cannot fail: what is not addressed to the master is `Other`.
    #[must_use]
    #[inline]
    pub fn decode(frame: &Frame<'a>) -> Self {
        let number = u32::from_be_bytes([0, frame.address().0, frame.sub_address(), frame.command()]);
        Self::decode_body(number, frame.payload()).unwrap_or_else(|_| Self::other(number, frame.payload()))
    }

    /// Bytes of its whole packet.
    #[must_use]
    #[inline]
    pub fn encoded_len(&self) -> usize {
        frame::frame_len(self.body_len())
    }

    /// Writes its whole packet to the front of `out`, and says how many bytes it took.
    ///
    /// # Errors
    ///
    /// [`EncodeError`], if the packet does not fit, or there is more data than a master has room for.
    #[inline]
    pub fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let [_, to @ ..] = self.number().to_be_bytes();
        frame::envelope(to, self.body_len(), out, |place| self.encode_body(place))
    }
}
