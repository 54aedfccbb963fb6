//! Times for which firmware does nothing else. Source: firmware with motors (decision H-63); hoot, section 2.5.

use super::{DeviceMachine, Port, ProgramState, Quirks};
use crate::frame::Address;
use crate::message::HostMessage;

/// Time before a start, in milliseconds.
const START: u64 = 1500;
/// Time after a node has taken another address, in milliseconds.
const ADDRESS: u64 = 1000;
/// Time after a node has taken another address by a broadcast, in milliseconds.
const BROADCAST_ADDRESS: u64 = 2500;

/// Times for which a node does nothing else because of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Blocking {
    /// Time before the node carries out the message, in milliseconds.
    pub before: u64,
    /// Time after the node has carried out and answered the message, in milliseconds.
    pub after: u64,
}

impl<const QUIRKS: bool> DeviceMachine<QUIRKS> {
    /// Times for which firmware does nothing else because of a message; none unless the node copies that
    /// ([`Quirks::BLOCKS`]).
    ///
    /// Packets that arrive meanwhile wait in the buffer of their port. Firmware reads the first of them then, and hangs for
    /// ever if more bytes wait after it. A rig that copies firmware gives the message to
    /// [`advance`](Self::advance) when the time before it is over, and does the rest of that itself.
    #[must_use]
    pub fn blocking(&self, port: Port, to: Address, message: &HostMessage<'_>) -> Blocking {
        let is_read = to == self.address(port) && !self.gate_refuses(message.selector());
        let (before, after) = match message {
            _ if !self.has_quirk(Quirks::BLOCKS) => (0, 0),
            HostMessage::BroadcastAssignAddress(assign) if assign.new_address.is_node() => (0, BROADCAST_ADDRESS),
            HostMessage::SetAddress(set) if is_read && set.new_address.is_node() => (0, ADDRESS),
            HostMessage::CoreAssignAddress(set) if is_read && set.new_address.is_node() => (0, ADDRESS),
            // The time is spent before the start of a new program, not before one that goes on.
            HostMessage::Start(_) if is_read && self.starts_anew() => (START, 0),
            _ => (0, 0),
        };
        Blocking { before, after }
    }

    fn starts_anew(&self) -> bool {
        let is_stopped = self.program.state() == ProgramState::Stopped;
        is_stopped && self.options.profile().start_blocks() == Some(true)
    }
}
