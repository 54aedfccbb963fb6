//! Types that queries ask for, and their conversion from and to the values of replies.

use motion_core::fixed::{Centi, Scaled};
use motion_core::wire::{Bool, Field};

use crate::message::{
    Acceleration, AltMode, Amperes, Backlash, CoreVersion, Direction, EasingFound, EdgeFound, Level, Microstep,
    Milliseconds, ProgramMode, RingTip, RunState, ShortMilliseconds, Shots, Span, Speed, SpeedOrSleep, StartDelay,
    StepRate, Steps, Text, Value, ValueType, Version, Volts,
};

/// Type that queries ask for.
pub trait ReplyValue<'a>: Copy {
    /// Reads it from a value, if the value has the right meaning and size.
    fn from_value(value: Value<'a>) -> Option<Self>;

    /// Makes a value of this type if it fits, otherwise of the usual type.
    fn to_value(self, value_type: ValueType) -> Value<'a>;

    /// Unit of the value; empty if there is none.
    fn unit(&self) -> &'static str {
        ""
    }
}

/// Converts a number from and to the values that can contain it.
trait Number: Copy {
    fn from_value(value: &Value<'_>) -> Option<Self>;
    fn to_value<'a>(self, value_type: ValueType) -> Value<'a>;
}

impl Number for u8 {
    #[inline]
    fn from_value(value: &Value<'_>) -> Option<Self> {
        if let Value::Byte(number) = value { Some(*number) } else { None }
    }

    fn to_value<'a>(self, _: ValueType) -> Value<'a> {
        Value::Byte(self)
    }
}

/// A `UINT`, or an `INT` with the same bits.
impl Number for u16 {
    #[inline]
    fn from_value(value: &Value<'_>) -> Option<Self> {
        match value {
            Value::UInt(number) => Some(*number),
            Value::Int(number) => Some(Self::from_ne_bytes(number.to_ne_bytes())),
            _ => None,
        }
    }

    fn to_value<'a>(self, value_type: ValueType) -> Value<'a> {
        if value_type == ValueType::INT { int(self) } else { Value::UInt(self) }
    }
}

/// A `ULONG`, or a shorter type.
impl Number for u32 {
    #[inline]
    fn from_value(value: &Value<'_>) -> Option<Self> {
        match value {
            Value::Byte(number) => Some((*number).into()),
            Value::ULong(number) => Some(*number),
            _ => u16::from_value(value).map(Self::from),
        }
    }

    fn to_value<'a>(self, value_type: ValueType) -> Value<'a> {
        let short = u16::try_from(self).ok();
        match value_type {
            ValueType::BYTE => u8::try_from(self).ok().map(Value::Byte),
            ValueType::UINT => short.map(Value::UInt),
            ValueType::INT => short.map(int),
            _ => None,
        }
        .unwrap_or(Value::ULong(self))
    }
}

/// A `LONG`, or a `ULONG` with the same bits.
impl Number for i32 {
    #[inline]
    fn from_value(value: &Value<'_>) -> Option<Self> {
        match value {
            Value::Long(number) => Some(*number),
            Value::ULong(number) => Some(signed(*number)),
            _ => None,
        }
    }

    fn to_value<'a>(self, value_type: ValueType) -> Value<'a> {
        if value_type == ValueType::ULONG { Value::ULong(unsigned(self)) } else { Value::Long(self) }
    }
}

/// A `FLOAT`, or a `ULONG` or `LONG` with the same bits. The sheet describes a `LONG`.
impl Number for Centi<i32> {
    #[inline]
    fn from_value(value: &Value<'_>) -> Option<Self> {
        match value {
            Value::Float(number) => Some(*number),
            Value::Long(number) => Some(Scaled(*number)),
            Value::ULong(number) => Some(Scaled(signed(*number))),
            _ => None,
        }
    }

    fn to_value<'a>(self, value_type: ValueType) -> Value<'a> {
        match value_type {
            ValueType::FLOAT => Value::Float(self),
            ValueType::LONG => Value::Long(self.0),
            _ => Value::ULong(unsigned(self.0)),
        }
    }
}

macro_rules! numbers {
    ($($name:ident)*) => {$(
        impl<'a> ReplyValue<'a> for $name {
            #[inline]
            fn from_value(value: Value<'a>) -> Option<Self> {
                Number::from_value(&value).map(Self)
            }

            fn to_value(self, value_type: ValueType) -> Value<'a> {
                Number::to_value(self.0, value_type)
            }

            fn unit(&self) -> &'static str {
                <Self as Field>::UNIT
            }
        }
    )*};
}
numbers! {
    Acceleration Amperes Backlash CoreVersion Direction EasingFound EdgeFound Level Microstep Milliseconds ProgramMode
    RunState ShortMilliseconds Shots Span Speed StartDelay StepRate Steps Version Volts
}

/// Yes or no may come as an `INT` too, from some builds (hoot, section 2.3, query 107).
impl<'a> ReplyValue<'a> for Bool {
    #[inline]
    fn from_value(value: Value<'a>) -> Option<Self> {
        match value {
            Value::Byte(byte) => Some(Self(byte)),
            // A number that does not fit into a byte is not 0, so it means yes.
            Value::Int(number) => Some(u8::try_from(number).map_or(Self::TRUE, Self)),
            _ => None,
        }
    }

    fn to_value(self, value_type: ValueType) -> Value<'a> {
        if value_type == ValueType::INT { Value::Int(self.0.into()) } else { Value::Byte(self.0) }
    }
}

impl<'a> ReplyValue<'a> for Text<'a> {
    #[inline]
    fn from_value(value: Value<'a>) -> Option<Self> {
        if let Value::String(text) = value { Some(text) } else { None }
    }

    fn to_value(self, _: ValueType) -> Value<'a> {
        Value::String(self)
    }
}

macro_rules! pairs {
    ($($name:ident)*) => {$(
        impl<'a> ReplyValue<'a> for RingTip<$name> {
            #[inline]
            fn from_value(value: Value<'a>) -> Option<Self> {
                let [ring, tip] = u16::from_value(&value)?.to_be_bytes();
                Some(Self { ring: $name(ring), tip: $name(tip) })
            }

            fn to_value(self, _: ValueType) -> Value<'a> {
                int(u16::from_be_bytes([self.ring.0, self.tip.0]))
            }
        }
    )*};
}
pairs! { AltMode Level }

impl<'a> ReplyValue<'a> for SpeedOrSleep {
    #[inline]
    fn from_value(value: Value<'a>) -> Option<Self> {
        match value {
            Value::Byte(_) => Bool::from_value(value).map(Self::Sleep),
            _ => Speed::from_value(value).map(Self::Speed),
        }
    }

    fn to_value(self, value_type: ValueType) -> Value<'a> {
        match self {
            Self::Speed(speed) => ReplyValue::to_value(speed, value_type),
            Self::Sleep(sleep) => ReplyValue::to_value(sleep, ValueType::BYTE),
        }
    }

    fn unit(&self) -> &'static str {
        match self {
            Self::Speed(speed) => speed.unit(),
            Self::Sleep(sleep) => sleep.unit(),
        }
    }
}

/// The same bits, as an `INT`.
const fn int<'a>(bits: u16) -> Value<'a> {
    Value::Int(i16::from_ne_bytes(bits.to_ne_bytes()))
}

/// The same bits, with sign.
const fn signed(bits: u32) -> i32 {
    i32::from_ne_bytes(bits.to_ne_bytes())
}

/// The same bits, without sign.
const fn unsigned(number: i32) -> u32 {
    u32::from_ne_bytes(number.to_ne_bytes())
}
