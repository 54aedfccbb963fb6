//! Replies, which are a response code and perhaps a value.

use core::fmt;

use motion_core::open_enum;
use motion_core::wire::{
    DecodeError, EncodeError, FieldView, Fields, Message, PartKind, Row, Value as Shown, Visitor, place, print,
};

use super::value::{Value, ValueType};

open_enum! {
    /// Response code, which says how a request ended. Every code except [`OK`](Self::OK) is an error. Source: hoot,
    /// section 1.
    pub struct ResponseCode(u8) {
        /// The node refused, without a reason.
        ERROR = 0,
        /// The node did it.
        OK = 1,
        /// The node refused, with data; only in a library of 2014-12 and later.
        ERROR_WITH_DATA = 2,
    }
}

motion_core::__logged! {
    /// Answer to a request. Nothing in it says which request it answers. Only one request is under way on a bus, and its
    /// [`Query`](crate::Query) reads the reply.
    ///
    /// Source: hoot, section 1.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub struct Reply<'a> {
        /// Response code.
        pub code: ResponseCode,
        /// Data: nothing, or the type of a value and the value.
        pub data: &'a [u8],
    }
}

impl<'a> Reply<'a> {
    /// Reply of a node that did the request, without a value.
    pub const OK: Self = Self { code: ResponseCode::OK, data: &[] };
    /// Reply of a node that refused.
    pub const ERROR: Self = Self { code: ResponseCode::ERROR, data: &[] };

    /// Whether the node did the request.
    #[must_use]
    #[inline]
    pub fn is_ok(&self) -> bool {
        self.code == ResponseCode::OK
    }

    /// Type of the value, if the reply has data.
    #[must_use]
    #[inline]
    pub fn value_type(&self) -> Option<ValueType> {
        self.data.first().copied().map(ValueType)
    }

    /// Value of the reply, read by the type in front of it; `None` if there is no value, the type is unknown, or the
    /// data is longer or shorter than the type says.
    #[must_use]
    #[inline]
    pub fn value(&self) -> Option<Value<'a>> {
        self.data.split_first().and_then(|(&value_type, bytes)| Value::new(ValueType(value_type), bytes))
    }
}

impl<'a> Message<'a> for Reply<'a> {
    const LAYOUT: &'static [Row] = &place([
        Row { name: "value_type", wire: "u8", offset: None, size: 1, part: PartKind::Optional, unit: "", element: &[] },
        Row { name: "value", wire: "bytes", offset: None, size: 1, part: PartKind::Rest, unit: "", element: &[] },
    ]);

    /// Reply to a request that was done, if the response code is not known.
    fn decode(body: &'a [u8]) -> Result<Self, DecodeError> {
        Self::decode_as(ResponseCode::OK.0.into(), body)
    }

    #[inline]
    fn decode_as(number: u32, body: &'a [u8]) -> Result<Self, DecodeError> {
        let [code, ..] = number.to_le_bytes();
        Ok(Self { code: ResponseCode(code), data: body })
    }

    #[inline]
    fn number(&self, _: u32) -> u32 {
        self.code.0.into()
    }

    #[inline]
    fn encoded_len(&self) -> usize {
        self.data.len()
    }

    #[inline]
    fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let needed = self.data.len();
        let small = EncodeError::BufferTooSmall { needed, have: out.len() };
        out.get_mut(..needed).ok_or(small)?.copy_from_slice(self.data);
        Ok(needed)
    }
}

impl Fields for Reply<'_> {
    /// Type and value if they can be read, otherwise all the data.
    fn fields(&self, visitor: &mut dyn Visitor) {
        let mut show = |name, value, text: &dyn fmt::Display| visitor.visit(&FieldView { name, unit: "", value, text });
        show("response_code", Shown::Unsigned(self.code.0.into()), &self.code);
        if let Some(value) = self.value() {
            let value_type = value.value_type();
            show("value_type", Shown::Unsigned(value_type.0.into()), &value_type);
            show("value", value.shown(), &value);
        } else if !self.data.is_empty() {
            show("data", Shown::Bytes(self.data), &Hex(self.data));
        }
    }
}

motion_core::__message_features! { 'a [Reply<'a>] Reply }

struct Hex<'a>(&'a [u8]);

impl fmt::Display for Hex<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        print::hex(f, self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn a_reply_shows_its_value_or_else_its_data() {
        let show = |code, data| crate::DeviceMessage::Reply(Reply { code: ResponseCode(code), data }).to_string();
        assert_eq!(show(1, &[]), "Reply { response_code: OK }");
        assert_eq!(
            show(0, &[3, 0xFF, 0xFF, 0xCF, 0xC7]),
            "Reply { response_code: ERROR, value_type: LONG, value: -12345 }"
        );
        assert_eq!(show(1, b"\x06NMX\0\0"), "Reply { response_code: OK, value_type: STRING, value: \"NMX\" }");
        assert_eq!(show(9, &[3, 0xFF]), "Reply { response_code: 9, data: 03ff }");
    }
}
