//! What a node answers.

use super::{Port, StoredName};
use crate::frame::{self, Address};
use crate::message::{DeviceMessage, Reply, ResponseCode, Text, Value};
use crate::query::{AnyReply, IntoReply};
use motion_core::wire::EncodeError;

/// A reply, and the port that it goes to: the one on which the request came.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Send {
    /// Where to send it.
    pub port: Port,
    /// What it says.
    pub answer: Answer,
}

/// What a reply says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Answer {
    /// Done.
    Ok,
    /// Refused. A bridge drops this one, so that it looks like silence (hoot, section 1.1).
    Error,
    /// Done, with a value.
    Value(AnyReply<'static>),
    /// Done, with the node's name.
    Name(StoredName),
}

impl Answer {
    /// The value in it, if there is one.
    fn value(&self) -> Option<Value<'_>> {
        match self {
            Self::Ok | Self::Error => None,
            Self::Value(reply) => Some(reply.value()),
            Self::Name(StoredName(name)) => Some(Value::String(Text(name))),
        }
    }

    /// It as a message, with its data in `scratch`, of which [`MAX_DATA`](crate::frame::MAX_DATA) bytes are enough.
    ///
    /// # Errors
    ///
    /// [`EncodeError::BufferTooSmall`].
    pub fn message<'o>(&self, scratch: &'o mut [u8]) -> Result<DeviceMessage<'o>, EncodeError> {
        let Some(value) = self.value() else {
            return Ok(DeviceMessage::Reply(if *self == Self::Error { Reply::ERROR } else { Reply::OK }));
        };
        let have = scratch.len();
        let needed = value.value_type().size().unwrap_or(StoredName::DEFAULT.0.len()).saturating_add(1);
        let small = EncodeError::BufferTooSmall { needed, have };
        let len = value.write(scratch).ok_or(small)?;
        Ok(DeviceMessage::Reply(Reply { code: ResponseCode::OK, data: scratch.get(..len).ok_or(small)? }))
    }

    /// Writes its whole packet to the front of `out`, and says how many bytes it took: at most 42.
    ///
    /// # Errors
    ///
    /// [`EncodeError::BufferTooSmall`]. Then nothing is written.
    pub fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let mut scratch = [0; frame::MAX_DATA];
        self.message(&mut scratch)?.encode_into(out)
    }
}

/// Whom a packet is for that the node passes on, verbatim.
///
/// A packet from the bus goes to the ports of a master, one from a master's port to the bus. Source: hoot, section 1.1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Forward {
    /// Where it came from; it goes to [`Port::beyond`] of that.
    pub from: Port,
    /// Whom it is for: another node, or the master, whose replies pass a bridge the other way.
    pub to: Address,
}
