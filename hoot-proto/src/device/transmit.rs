//! Packets that a node sends: its answers, and what it forwards.

use motion_core::wire::EncodeError;

use super::{Port, StoredName};
use crate::frame::{Address, MAX_DATA};
use crate::message::{DeviceMessage, HostMessage, Reply, ResponseCode, Text, Value};
use crate::query::{AnyReply, IntoReply};

/// A packet to send.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Transmit<'a> {
    /// Port to send it to.
    pub port: Port,
    /// Contents of the packet.
    pub contents: Contents<'a>,
}

impl Transmit<'_> {
    /// Writes the whole packet to the front of `out` and returns its length in bytes, at most 42.
    ///
    /// # Errors
    ///
    /// [`EncodeError::BufferTooSmall`]. Of a forwarded packet that did not come from
    /// [`Input::received`](super::Input::received), all errors of [`HostMessage::encode_into`] are possible. Nothing is
    /// written then.
    pub fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        match self.contents {
            Contents::Answer(answer) => answer.encode_into(out),
            Contents::Forward { to, message } => message.encode_into(to, out),
        }
    }
}

/// Contents of a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Contents<'a> {
    /// The answer to a request.
    Answer(Answer),
    /// A packet for another receiver, byte for byte as it arrived on another port. Source: hoot, section 1.1.
    Forward {
        /// Address of the receiver: another node, or the master.
        to: Address,
        /// The message. Replies of other nodes are decoded as [`HostMessage`] too.
        message: HostMessage<'a>,
    },
}

/// Answer of a node to a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Answer {
    /// The node did it.
    Ok,
    /// The node refused. A bridge drops this answer, so that it looks like silence (hoot, section 1.1).
    Error,
    /// The node did it and answers a value.
    Value(AnyReply<'static>),
    /// The node answers its name.
    Name(StoredName),
}

impl Answer {
    /// Value of the answer, if it has one.
    fn value(&self) -> Option<Value<'_>> {
        match self {
            Self::Ok | Self::Error => None,
            Self::Value(reply) => Some(reply.value()),
            Self::Name(StoredName(name)) => Some(Value::String(Text(name))),
        }
    }

    /// Writes the packet of the answer to the front of `out`.
    fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        self.message(&mut [0; MAX_DATA])?.encode_into(out)
    }

    /// Message of the answer, with its data in `scratch`, of which [`MAX_DATA`] bytes are enough.
    ///
    /// # Errors
    ///
    /// [`EncodeError::BufferTooSmall`].
    pub fn message<'o>(&self, scratch: &'o mut [u8]) -> Result<DeviceMessage<'o>, EncodeError> {
        let Some(value) = self.value() else {
            return Ok(if *self == Self::Error { Reply::ERROR } else { Reply::OK }.into());
        };
        let have = scratch.len();
        let needed = value.value_type().size().unwrap_or(StoredName::DEFAULT.0.len()).saturating_add(1);
        let small = EncodeError::BufferTooSmall { needed, have };
        let len = value.write(scratch).ok_or(small)?;
        Ok(Reply { code: ResponseCode::OK, data: scratch.get(..len).ok_or(small)? }.into())
    }
}
