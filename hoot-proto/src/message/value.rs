//! Values in replies, and the byte in front of them that tells their type.

use core::fmt;

use motion_core::fixed::{Centi, Scaled};
use motion_core::open_enum;
use motion_core::wire::{Bool, Value as Shown, print, trim_nuls};

use super::units::Speed;

open_enum! {
    /// Type of a value, from the byte in front of it. Source: hoot, section 1.
    pub struct ValueType(u8) {
        /// 8 bits without sign.
        BYTE = 0,
        /// 16 bits without sign.
        UINT = 1,
        /// 16 bits with sign.
        INT = 2,
        /// 32 bits with sign.
        LONG = 3,
        /// 32 bits without sign. Firmware since v0.33 sends hundredths under this type, with sign.
        ULONG = 4,
        /// Hundredths in 32 bits with sign. In spite of its name, it is not an IEEE number.
        FLOAT = 5,
        /// Text up to the end of the data.
        STRING = 6,
    }
}

impl ValueType {
    /// Number of bytes of a value of this type, if all values have the same number.
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

/// Text of a node, with the NULs and spaces at its end.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Text<'a>(pub &'a [u8]);

impl<'a> Text<'a> {
    /// Text without the NULs at its end, if it is UTF-8. Nodes fill their first name up with spaces, which stay.
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

/// Value, read by the type in front of it.
///
/// Only the query knows its meaning: a voltage comes as `Float` or as `ULong`, both in hundredths and with sign.
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
    /// Reads a value of a type; `None` if the type is unknown, or the number of `bytes` is wrong.
    #[must_use]
    #[inline]
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

    /// The value, if it is not text.
    pub(crate) const fn number(self) -> Option<Value<'static>> {
        Some(match self {
            Self::Byte(number) => Value::Byte(number),
            Self::UInt(number) => Value::UInt(number),
            Self::Int(number) => Value::Int(number),
            Self::Long(number) => Value::Long(number),
            Self::ULong(number) => Value::ULong(number),
            Self::Float(number) => Value::Float(number),
            Self::String(_) => return None,
        })
    }

    /// Type of the value.
    #[must_use]
    #[inline]
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

    /// Writes type and value to the front of `out`, and returns their length in bytes; `None` if they do not fit.
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

    /// Bytes of the value on the wire.
    pub(crate) const fn shown(&self) -> Shown<'a> {
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

/// Values of the two contacts of a connector. On the wire they are one number, an `INT`, whose high byte is the ring.
///
/// Source: hoot, section 2.2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct RingTip<T> {
    /// Value of the ring.
    pub ring: T,
    /// Value of the tip.
    pub tip: T,
}

impl<T: fmt::Display> fmt::Display for RingTip<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ring {}, tip {}", self.ring, self.tip)
    }
}

/// Answer to query 117 of a motor, whose meaning depends on the age of the firmware. Source: hoot, sections 2.3 and 7.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SpeedOrSleep {
    /// Greatest speed of the planned move, according to the sheet. No known firmware answers that.
    Speed(Speed),
    /// Whether the motor has no current while it rests, in firmware since 2014-12-03.
    Sleep(Bool),
}

impl fmt::Display for SpeedOrSleep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Speed(speed) => write!(f, "speed {speed}"),
            Self::Sleep(sleep) => write!(f, "sleep {sleep}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
