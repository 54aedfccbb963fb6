//! Requests and answers as firmware reads and writes them: a number and some bytes, without a type for each message.

use motion_core::wire::{EncodeError, Field, Messages, Reader};
use zerocopy::BE;

use super::input::Port;
use super::{Answer, Ignored, StoredName, command};
use crate::frame::{Address, Selector, Table, encode};
use crate::message::{HostMessage, Reply, ResponseCode, StepsPerSecond, Text, Value, ValueType};
use crate::query::AnyQuery;

/// Greatest number of bytes that a request or a value has: those of a name.
const MOST: usize = StoredName::DEFAULT.0.len();

/// Kind of the device, as firmware answers it.
pub(super) const DEVICE_ID: Text<'static> = Text(b"OMAXISVX");

/// What a node does with a packet that arrived.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reaction {
    /// The packet is answered on a port.
    Answer(Port, Response),
    /// The packet itself goes to another port.
    Forward(Port),
    /// The packet for this receiver, which arrived on this port, is not answered.
    Ignore(Port, Address, Ignored),
}

/// Request as firmware reads it: surplus bytes of its data are left out, and missing bytes are zero. Source: hoot, section 1.1.
#[derive(Clone, Copy)]
pub(super) struct Request {
    pub selector: Selector,
    data: [u8; MOST],
    /// Number of bytes that arrived.
    len: usize,
}

impl Request {
    pub(super) fn new(selector: Selector, data: &[u8]) -> Self {
        let mut places = [0; MOST];
        for (place, byte) in places.iter_mut().zip(data) {
            *place = *byte;
        }
        Self { selector, data: places, len: data.len() }
    }

    /// Request that a message is. The data of a message that cannot be written is missing.
    pub(super) fn of(message: &HostMessage<'_>) -> Self {
        let mut buffer = [0; MOST];
        let data = match message {
            HostMessage::Other(other) => other.payload(),
            message => {
                let len = message.encode_body(&mut buffer).unwrap_or(0);
                buffer.get(..len).unwrap_or_default()
            }
        };
        Self::new(message.selector(), data)
    }

    /// Whether the request has data of this length at least.
    pub(super) const fn has(&self, len: usize) -> bool {
        self.len >= len
    }

    /// Name in the data.
    pub(super) const fn name(&self) -> StoredName {
        StoredName(self.data)
    }

    /// Field at the beginning of the data.
    pub(super) fn get<T: Field>(&self) -> T {
        self.pair::<T, u8>().0
    }

    /// Two fields at the beginning of the data.
    pub(super) fn pair<T: Field, U: Field>(&self) -> (T, U) {
        let mut reader = Reader::<BE>::new(&self.data);
        (T::read(&mut reader).unwrap_or_default(), U::read(&mut reader).unwrap_or_default())
    }

    /// Whether something may move, or the shutter may open, because of the request.
    pub(super) fn sets_in_motion(&self) -> bool {
        let Selector { table, command, sub_address } = self.selector;
        match (table, sub_address) {
            (Table::Node, 1..=3) if command == command::MotorSetContinuousSpeed => {
                self.get::<StepsPerSecond>().0 != 0.0
            }
            (Table::Node, 4) if command == command::CameraExpose => true,
            _ => command::may_move(self.selector),
        }
    }
}

/// Answer to a request: response code and data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Response {
    code: ResponseCode,
    len: u8,
    data: [u8; MOST + 1],
}

impl Response {
    pub(super) const OK: Self = Self { code: ResponseCode::OK, len: 0, data: [0; MOST + 1] };
    pub(super) const ERROR: Self = Self { code: ResponseCode::ERROR, ..Self::OK };

    /// Answer with a text.
    pub(super) fn text(text: &[u8]) -> Self {
        let mut response = Self::OK;
        let places = [ValueType::STRING.0].into_iter().chain(text.iter().copied());
        for (place, byte) in response.data.iter_mut().zip(places) {
            *place = byte;
            response.len = response.len.saturating_add(1);
        }
        response
    }

    /// Answer with a number under a type, or under `ULONG` if the type is too short for it.
    pub(super) const fn number(value_type: ValueType, number: u32) -> Self {
        let (value_type, size): (_, u8) = match value_type.size() {
            Some(1) if number <= 0xFF => (value_type, 1),
            Some(2) if number <= 0xFFFF => (value_type, 2),
            Some(4) => (value_type, 4),
            _ => (ValueType::ULONG, 4),
        };
        let [a, b, c, d] = match size {
            1 => number.wrapping_shl(24),
            2 => number.wrapping_shl(16),
            _ => number,
        }
        .to_be_bytes();
        Self { code: ResponseCode::OK, len: size.saturating_add(1), data: [value_type.0, a, b, c, d, 0, 0, 0, 0, 0, 0] }
    }

    /// Whether the answer contains a value.
    pub(super) const fn has_value(&self) -> bool {
        self.len > 0
    }

    /// Writes the packet of the answer to the front of `out`.
    pub(super) fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let Reply { code, data } = self.reply();
        encode(Address::MASTER, 0, code.0, data, out)
    }

    /// The answer as a reply.
    pub(super) fn reply(&self) -> Reply<'_> {
        Reply { code: self.code, data: self.data.get(..self.len.into()).unwrap_or_default() }
    }

    /// The answer to a query, or to another request if there is no query.
    pub(super) fn answer(&self, query: Option<AnyQuery>) -> Answer {
        let reply = self.reply();
        let value = match (query, reply.value()) {
            _ if !reply.is_ok() => return Answer::Error,
            (Some(AnyQuery::Name(_)), Some(Value::String(Text(name)))) => {
                return Answer::Name(StoredName(name.first_chunk().copied().unwrap_or(StoredName::DEFAULT.0)));
            }
            (_, Some(Value::String(_))) => Some(Value::String(DEVICE_ID)),
            (_, value) => value.and_then(Value::number),
        };
        let reply = query.and_then(|query| query.read(value?));
        reply.map_or(Answer::Ok, Answer::Value)
    }
}
