//! What a reply answers: queries type their replies.
//!
//! A reply says whether a request was done, and perhaps a value with its type, but not what it answers. The query that
//! was asked knows: [`Query::decode_reply`] reads the reply in its light, [`Query::reply`] makes it, for nodes.
//! [`AnyQuery`] and [`AnyReply`] do the same for programs that see all of them.
//!
//! ```
//! use hoot_proto::message::{Motor, MotorPosition, Reply, ResponseCode, Steps, ValueType};
//! use hoot_proto::query::{Answer, Profile, Query};
//!
//! let query = MotorPosition { motor: Motor::Two };
//! let reply = Reply { code: ResponseCode::OK, data: &[3, 0xFF, 0xFF, 0xCF, 0xC7] };
//! let answer = query.decode_reply(reply)?;
//! assert_eq!((answer.value, answer.value_type()), (Steps(-12_345), ValueType::LONG));
//!
//! let mut data = [0; 32];
//! assert_eq!(query.reply(Answer::new(Steps(-12_345), Profile::default()), &mut data), Ok(reply));
//! # Ok::<(), hoot_proto::ReplyError>(())
//! ```
//!
//! Firmware differs in the type that it writes in front of a value. A value under another type than the sheet says is
//! taken if it has the same size and meaning; [`Answer::value_type`] shows what was found. Any other type is an error:
//! it is likely the late answer to another question.
//!
//! Source: hoot, sections 1.2 and 2; safety decision 7.

use core::fmt;

use motion_core::fixed::Scaled;
use motion_core::wire::{Bool, EncodeError};

use crate::message::{
    HostMessage, MotorPosition, MotorRunning, NameQuery, Reply, ResponseCode, RunState, RunStatus, Steps, Text, Value,
    ValueType, Voltage, Volts,
};

/// A request that asks for a value.
pub trait Query: Copy {
    /// What it asks for.
    type Reply<'a>: IntoReply<'a>;

    /// Reads the reply to it.
    ///
    /// # Errors
    ///
    /// [`ReplyError`], if the node refused, or the value cannot be what was asked for.
    fn decode_reply<'a>(&self, reply: Reply<'a>) -> Result<Self::Reply<'a>, ReplyError>;

    /// Makes the reply to it, with its data in `out`.
    ///
    /// # Errors
    ///
    /// [`EncodeError::BufferTooSmall`]; [`MAX_DATA`](crate::frame::MAX_DATA) bytes are enough for all but long texts.
    fn reply<'o>(&self, answer: Self::Reply<'_>, out: &'o mut [u8]) -> Result<Reply<'o>, EncodeError> {
        let value = answer.value();
        // A text is the only value whose length its type does not say.
        let size = if let Value::String(text) = value { text.0.len() } else { value.value_type().size().unwrap_or(0) };
        let small = EncodeError::BufferTooSmall { needed: size.saturating_add(1), have: out.len() };
        let len = value.write(out).ok_or(small)?;
        Ok(Reply { code: ResponseCode::OK, data: out.get(..len).ok_or(small)? })
    }
}

/// What a reply can say.
pub trait IntoReply<'a> {
    /// The value, under the type that it is to be sent with.
    fn value(&self) -> Value<'a>;
}

/// What a node's firmware is, as far as replies differ by it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Profile {
    /// Not known. What is written for it is written as by v0.33.
    #[default]
    Unknown,
    /// With the library of 2014-09-25, which the published sheet describes: hundredths come as `FLOAT`.
    Library20140925,
    /// v0.33, of 2015-04-07, or later: hundredths come as `ULONG`.
    V033,
}

/// A value, and the type that stood in front of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Answer<T> {
    /// The value.
    pub value: T,
    value_type: ValueType,
}

impl<'a, T: ReplyValue<'a>> Answer<T> {
    /// A value, under the type that the firmware of a profile gives it.
    #[must_use]
    pub fn new(value: T, profile: Profile) -> Self {
        Self { value, value_type: T::value_type(profile) }
    }
}

impl<T> Answer<T> {
    /// The type that stood in front of it.
    #[must_use]
    pub const fn value_type(&self) -> ValueType {
        self.value_type
    }

    /// Whether the value can be relied on, coming from firmware of this profile.
    ///
    /// It cannot if it is a `FLOAT` and the profile is not [`Profile::Library20140925`]: builds from 2014-10-07 to v0.32
    /// send garbage under that type, which cannot be told from a value (safety decision 7).
    #[must_use]
    pub fn is_reliable(&self, profile: Profile) -> bool {
        self.value_type != ValueType::FLOAT || profile == Profile::Library20140925
    }
}

impl<T: fmt::Display> fmt::Display for Answer<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.value.fmt(f)
    }
}

impl<'a, T: ReplyValue<'a>> IntoReply<'a> for Answer<T> {
    fn value(&self) -> Value<'a> {
        self.value.to_value(self.value_type)
    }
}

/// A type that queries ask for.
pub trait ReplyValue<'a>: Copy {
    /// The type that the firmware of a profile gives it.
    fn value_type(profile: Profile) -> ValueType;

    /// Takes it out of a value, if that has the right size and meaning.
    fn from_value(value: Value<'a>) -> Option<Self>;

    /// It as a value: of this type, if that has the right size and meaning, or else of its usual one.
    fn to_value(self, value_type: ValueType) -> Value<'a>;
}

impl<'a> ReplyValue<'a> for RunState {
    fn value_type(_: Profile) -> ValueType {
        ValueType::BYTE
    }

    fn from_value(value: Value<'a>) -> Option<Self> {
        if let Value::Byte(state) = value { Some(Self(state)) } else { None }
    }

    fn to_value(self, _: ValueType) -> Value<'a> {
        Value::Byte(self.0)
    }
}

/// A yes or no may come as `INT` too, from builds in which it was promoted (hoot, section 2.3, query 107).
impl<'a> ReplyValue<'a> for Bool {
    fn value_type(_: Profile) -> ValueType {
        ValueType::BYTE
    }

    fn from_value(value: Value<'a>) -> Option<Self> {
        match value {
            Value::Byte(byte) => Some(Self(byte)),
            // What has no room in a byte is not 0, and so a yes.
            Value::Int(number) => Some(u8::try_from(number).map_or(Self::TRUE, Self)),
            _ => None,
        }
    }

    fn to_value(self, value_type: ValueType) -> Value<'a> {
        if value_type == ValueType::INT { Value::Int(self.0.into()) } else { Value::Byte(self.0) }
    }
}

impl<'a> ReplyValue<'a> for Text<'a> {
    fn value_type(_: Profile) -> ValueType {
        ValueType::STRING
    }

    fn from_value(value: Value<'a>) -> Option<Self> {
        if let Value::String(text) = value { Some(text) } else { None }
    }

    fn to_value(self, _: ValueType) -> Value<'a> {
        Value::String(self)
    }
}

impl<'a> ReplyValue<'a> for Steps {
    fn value_type(_: Profile) -> ValueType {
        ValueType::LONG
    }

    fn from_value(value: Value<'a>) -> Option<Self> {
        match value {
            Value::Long(steps) => Some(Self(steps)),
            Value::ULong(bits) => Some(Self(signed(bits))),
            _ => None,
        }
    }

    fn to_value(self, value_type: ValueType) -> Value<'a> {
        if value_type == ValueType::ULONG { Value::ULong(unsigned(self.0)) } else { Value::Long(self.0) }
    }
}

impl<'a> ReplyValue<'a> for Volts {
    fn value_type(profile: Profile) -> ValueType {
        match profile {
            Profile::Library20140925 => ValueType::FLOAT,
            Profile::Unknown | Profile::V033 => ValueType::ULONG,
        }
    }

    fn from_value(value: Value<'a>) -> Option<Self> {
        match value {
            Value::Float(volts) => Some(Self(volts)),
            Value::ULong(bits) => Some(Self(Scaled(signed(bits)))),
            _ => None,
        }
    }

    fn to_value(self, value_type: ValueType) -> Value<'a> {
        if value_type == ValueType::FLOAT { Value::Float(self.0) } else { Value::ULong(unsigned(self.0.0)) }
    }
}

/// The same bits, with sign.
const fn signed(bits: u32) -> i32 {
    i32::from_ne_bytes(bits.to_ne_bytes())
}

/// The same bits, without sign.
const fn unsigned(number: i32) -> u32 {
    u32::from_ne_bytes(number.to_ne_bytes())
}

/// Why a reply does not answer a query.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum ReplyError {
    /// The node refused. It never says why.
    #[error("the node refused with response code {code}")]
    Node {
        /// What it said instead of OK.
        code: ResponseCode,
    },
    /// The data ends before the value does.
    #[error("reply: need {need} bytes, have {have}")]
    Short {
        /// Bytes of data that the value takes, its type included.
        need: usize,
        /// Bytes of data there are.
        have: usize,
    },
    /// The data goes on behind the value.
    #[error("reply: {extra} bytes too many")]
    Trailing {
        /// Bytes behind it.
        extra: usize,
    },
    /// The value has another meaning than what was asked for, or another size.
    #[error("reply: a value of type {found}, expected {expected}")]
    ValueType {
        /// The type that stands in front of the value.
        found: ValueType,
        /// The type that it should have.
        expected: ValueType,
    },
}

fn decode<'a, T: ReplyValue<'a>>(reply: Reply<'a>) -> Result<Answer<T>, ReplyError> {
    if !reply.is_ok() {
        return Err(ReplyError::Node { code: reply.code });
    }
    let expected = T::value_type(Profile::default());
    let found = reply.value_type().unwrap_or(expected);
    let (need, have) = (found.size().unwrap_or(0).saturating_add(1), reply.data.len());
    if have < need {
        return Err(ReplyError::Short { need, have });
    }
    match reply.value() {
        Some(value) => T::from_value(value)
            .map(|value| Answer { value, value_type: found })
            .ok_or(ReplyError::ValueType { found, expected }),
        None if found.size().is_some() => Err(ReplyError::Trailing { extra: have.saturating_sub(need) }),
        None => Err(ReplyError::ValueType { found, expected }),
    }
}

/// Makes the queries of one table: what each asks for, and the enums over all of them.
macro_rules! queries {
    ($($variant:ident($query:ty) => $answer:ty;)*) => {
        $(impl Query for $query {
            type Reply<'a> = Answer<$answer>;

            fn decode_reply<'a>(&self, reply: Reply<'a>) -> Result<Self::Reply<'a>, ReplyError> {
                decode(reply)
            }
        })*

        /// One of the queries.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum AnyQuery {
            $(#[doc = concat!("[`HostMessage::", stringify!($variant), "`].")]
            $variant($query),)*
        }

        /// The answer to one of the queries.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum AnyReply<'a> {
            $(#[doc = concat!("To [`HostMessage::", stringify!($variant), "`].")]
            $variant(Answer<$answer>),)*
        }

        impl AnyReply<'_> {
            /// The type that stood in front of the value.
            #[must_use]
            pub const fn value_type(&self) -> ValueType {
                match self {
                    $(Self::$variant(answer) => answer.value_type(),)*
                }
            }
        }

        impl fmt::Display for AnyReply<'_> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                match self {
                    $(Self::$variant(answer) => answer.fmt(f),)*
                }
            }
        }

        impl<'a> IntoReply<'a> for AnyReply<'a> {
            fn value(&self) -> Value<'a> {
                match self {
                    $(Self::$variant(answer) => answer.value(),)*
                }
            }
        }

        impl Query for AnyQuery {
            type Reply<'a> = AnyReply<'a>;

            fn decode_reply<'a>(&self, reply: Reply<'a>) -> Result<AnyReply<'a>, ReplyError> {
                match self {
                    $(Self::$variant(query) => query.decode_reply(reply).map(AnyReply::$variant),)*
                }
            }
        }

        impl HostMessage<'_> {
            /// The query that it is, if it is one.
            #[must_use]
            pub const fn query(&self) -> Option<AnyQuery> {
                match self {
                    $(Self::$variant(query) => Some(AnyQuery::$variant(*query)),)*
                    _ => None,
                }
            }
        }
    };
}
queries! {
    RunStatus(RunStatus) => RunState;
    Name(NameQuery) => Text<'a>;
    Voltage(Voltage) => Volts;
    MotorPosition(MotorPosition) => Steps;
    MotorRunning(MotorRunning) => Bool;
}
