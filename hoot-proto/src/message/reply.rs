//! Replies: a response code, and perhaps a value with its type.

use core::fmt;

use motion_core::fixed::{Centi, Scaled};
use motion_core::open_enum;
use motion_core::wire::{
    DecodeError, EncodeError, FieldView, Fields, Message, PartKind, Row, Value as Shown, Visitor, place, print,
    trim_nuls,
};

open_enum! {
    /// How a request ended. Everything but [`OK`](Self::OK) is an error. Source: hoot, section 1.
    pub struct ResponseCode(u8) {
        /// Refused, without a reason.
        ERROR = 0,
        /// Done.
        OK = 1,
        /// Refused, with data; only in a library of 2014-12 and later.
        ERROR_WITH_DATA = 2,
    }

    /// The type of a value, as the byte in front of it says. Source: hoot, section 1.
    pub struct ValueType(u8) {
        /// A byte.
        BYTE = 0,
        /// 16 bits without sign.
        UINT = 1,
        /// 16 bits with sign.
        INT = 2,
        /// 32 bits with sign.
        LONG = 3,
        /// 32 bits without sign. Firmware since v0.33 says hundredths under it, with sign.
        ULONG = 4,
        /// Hundredths, 32 bits with sign: no IEEE number, whatever its name.
        FLOAT = 5,
        /// A text to the end of the data.
        STRING = 6,
    }
}

impl ValueType {
    /// Bytes of such a value, where all have the same.
    #[must_use]
    pub const fn size(self) -> Option<usize> {
        match self {
            Self::BYTE => Some(1),
            Self::UINT | Self::INT => Some(2),
            Self::LONG | Self::ULONG | Self::FLOAT => Some(4),
            _ => None,
        }
    }
}

/// A text of a node, NULs and spaces at its end included.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Text<'a>(pub &'a [u8]);

impl<'a> Text<'a> {
    /// Its text without the NULs at the end, if it is UTF-8. Nodes fill their first name up with spaces; these stay.
    #[must_use]
    pub fn as_str(self) -> Option<&'a str> {
        core::str::from_utf8(trim_nuls(self.0)).ok()
    }
}

impl fmt::Display for Text<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        print::text(f, trim_nuls(self.0))
    }
}

impl fmt::Debug for Text<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Text({self})")
    }
}

/// A value, read by the type in front of it.
///
/// What it means, only the query knows: a voltage comes as `Float` or as `ULong`, both in hundredths and with sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Value<'a> {
    /// A [`BYTE`](ValueType::BYTE).
    Byte(u8),
    /// A [`UINT`](ValueType::UINT).
    UInt(u16),
    /// An [`INT`](ValueType::INT).
    Int(i16),
    /// A [`LONG`](ValueType::LONG).
    Long(i32),
    /// A [`ULONG`](ValueType::ULONG).
    ULong(u32),
    /// A [`FLOAT`](ValueType::FLOAT).
    Float(Centi<i32>),
    /// A [`STRING`](ValueType::STRING).
    String(Text<'a>),
}

impl<'a> Value<'a> {
    /// Reads a value of a type; `None` if the type is unknown, or `bytes` are more or fewer than it has.
    #[must_use]
    pub fn new(value_type: ValueType, bytes: &'a [u8]) -> Option<Self> {
        Some(match (value_type, bytes) {
            (ValueType::BYTE, &[byte]) => Self::Byte(byte),
            (ValueType::UINT, &[a, b]) => Self::UInt(u16::from_be_bytes([a, b])),
            (ValueType::INT, &[a, b]) => Self::Int(i16::from_be_bytes([a, b])),
            (ValueType::LONG, &[a, b, c, d]) => Self::Long(i32::from_be_bytes([a, b, c, d])),
            (ValueType::ULONG, &[a, b, c, d]) => Self::ULong(u32::from_be_bytes([a, b, c, d])),
            (ValueType::FLOAT, &[a, b, c, d]) => Self::Float(Scaled(i32::from_be_bytes([a, b, c, d]))),
            (ValueType::STRING, text) => Self::String(Text(text)),
            _ => return None,
        })
    }

    /// Its type.
    #[must_use]
    pub const fn value_type(&self) -> ValueType {
        match self {
            Self::Byte(_) => ValueType::BYTE,
            Self::UInt(_) => ValueType::UINT,
            Self::Int(_) => ValueType::INT,
            Self::Long(_) => ValueType::LONG,
            Self::ULong(_) => ValueType::ULONG,
            Self::Float(_) => ValueType::FLOAT,
            Self::String(_) => ValueType::STRING,
        }
    }

    /// Writes type and value to the front of `out`, and says how many bytes they took; `None` if they do not fit.
    pub(crate) fn write(&self, out: &mut [u8]) -> Option<usize> {
        let (first, rest) = out.split_first_mut()?;
        *first = self.value_type().0;
        let mut put = |bytes: &[u8]| {
            rest.get_mut(..bytes.len())?.copy_from_slice(bytes);
            bytes.len().checked_add(1)
        };
        match self {
            Self::Byte(byte) => put(&[*byte]),
            Self::UInt(number) => put(&number.to_be_bytes()),
            Self::Int(number) => put(&number.to_be_bytes()),
            Self::Long(number) | Self::Float(Scaled(number)) => put(&number.to_be_bytes()),
            Self::ULong(number) => put(&number.to_be_bytes()),
            Self::String(text) => put(text.0),
        }
    }

    /// What stands on the wire.
    const fn shown(&self) -> Shown<'a> {
        match *self {
            Self::Byte(number) => Shown::Unsigned(number as u64),
            Self::UInt(number) => Shown::Unsigned(number as u64),
            Self::ULong(number) => Shown::Unsigned(number as u64),
            Self::Int(number) => Shown::Signed(number as i64),
            Self::Long(number) | Self::Float(Scaled(number)) => Shown::Signed(number as i64),
            Self::String(text) => Shown::Text(text.0),
        }
    }
}

impl fmt::Display for Value<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Byte(number) => number.fmt(f),
            Self::UInt(number) => number.fmt(f),
            Self::Int(number) => number.fmt(f),
            Self::Long(number) => number.fmt(f),
            Self::ULong(number) => number.fmt(f),
            Self::Float(number) => number.fmt(f),
            Self::String(text) => text.fmt(f),
        }
    }
}

/// The answer to a request. Nothing in it says to which: there is one request at a time on a bus, and its
/// [`Query`](crate::Query) reads the reply.
///
/// Source: hoot, section 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Reply<'a> {
    /// How the request ended.
    pub code: ResponseCode,
    /// Nothing, or the type of a value and the value.
    pub data: &'a [u8],
}

impl<'a> Reply<'a> {
    /// Done.
    pub const OK: Self = Self { code: ResponseCode::OK, data: &[] };
    /// Refused.
    pub const ERROR: Self = Self { code: ResponseCode::ERROR, data: &[] };

    /// Whether the request was done.
    #[must_use]
    pub fn is_ok(&self) -> bool {
        self.code == ResponseCode::OK
    }

    /// The type of its value, if it has data.
    #[must_use]
    pub fn value_type(&self) -> Option<ValueType> {
        self.data.first().copied().map(ValueType)
    }

    /// Its value, read by the type in front of it; `None` if there is none, the type is unknown, or the data is longer
    /// or shorter than the type says.
    #[must_use]
    pub fn value(&self) -> Option<Value<'a>> {
        self.data.split_first().and_then(|(&value_type, bytes)| Value::new(ValueType(value_type), bytes))
    }
}

impl<'a> Message<'a> for Reply<'a> {
    const LAYOUT: &'static [Row] = &place([
        Row { name: "value_type", wire: "u8", offset: None, size: 1, part: PartKind::Optional, unit: "", element: &[] },
        Row { name: "value", wire: "bytes", offset: None, size: 1, part: PartKind::Rest, unit: "", element: &[] },
    ]);

    /// The reply to a request that was done, where the response code is not known.
    fn decode(body: &'a [u8]) -> Result<Self, DecodeError> {
        Self::decode_as(ResponseCode::OK.0.into(), body)
    }

    #[inline]
    fn decode_as(number: u32, body: &'a [u8]) -> Result<Self, DecodeError> {
        let [.., code] = number.to_be_bytes();
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
    /// The type and the value where they can be told, or else all the data.
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
    fn a_value_is_as_long_as_its_type_says() {
        for (value_type, size) in (0..=7).map(ValueType).map(|value_type| (value_type, value_type.size())) {
            for len in 0..9 {
                let found = Value::new(value_type, &[0x80; 9][..len]);
                let wanted = value_type == ValueType::STRING || Some(len) == size;
                assert_eq!(found.is_some(), wanted, "{value_type} of {len} bytes");
                let mut out = [0; 9];
                if let Some(value) = found {
                    assert_eq!(value.value_type(), value_type);
                    assert_eq!(value.write(&mut out), (len < 9).then_some(len + 1));
                    assert_eq!((out[0], &out[1..=len]), (value_type.0, &[0x80; 9][..len]));
                    assert_eq!(value.write(&mut out[..len]), None);
                }
            }
        }
    }

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
