//! Packets that a master sends.

use motion_core::wire::EncodeError;

use crate::frame::Address;
use crate::message::HostMessage;

/// A packet to send.
///
/// Before it is written, drop what has arrived and is not read yet, with `reset` of the stream: it cannot be an answer to
/// this packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Transmit {
    /// Address of the receiver.
    pub to: Address,
    /// The message.
    pub message: HostMessage<'static>,
}

impl Transmit {
    /// Writes the whole packet to the front of `out` and returns its length in bytes, at most 42.
    ///
    /// # Errors
    ///
    /// [`EncodeError::BufferTooSmall`]; the machine has checked everything else.
    pub fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        self.message.encode_into(self.to, out)
    }
}
