//! Queries, which read the replies to them.
//!
//! A reply contains a response code and perhaps a value with its type, but not what it answers. The query that was
//! asked reads it: [`Query::decode_reply`] reads a reply, and [`Query::reply`] makes one, for nodes. [`AnyQuery`] and
//! [`AnyReply`] do the same for programs that handle all queries.
//!
//! ```
//! use hoot_proto::message::{Motor, MotorPosition, Reply, ResponseCode, Steps, ValueType};
//! use hoot_proto::query::{Profile, Query};
//!
//! let query = MotorPosition { motor: Motor::Two };
//! let reply = Reply { code: ResponseCode::OK, data: &[3, 0xFF, 0xFF, 0xCF, 0xC7] };
//! let answer = query.decode_reply(reply)?;
//! assert_eq!((answer.value, answer.value_type()), (Steps(-12_345), ValueType::LONG));
//!
//! let mut data = [0; 32];
//! assert_eq!(query.reply(query.answer(Steps(-12_345), Profile::default()), &mut data), Ok(reply));
//! # Ok::<(), hoot_proto::ReplyError>(())
//! ```
//!
//! Firmware of different ages writes different types in front of a value; see [`Profile`]. Every type that some
//! firmware, or the sheet, has for the query is accepted, and [`Answer::value_type`] tells which one was found. Any
//! other type is an error, because it is probably the late answer to another query.
//!
//! Some requests are answered by two packets ([`Profile::packets`]), and later firmware does not answer unknown
//! commands. So stop waiting for a reply after some time, and drop replies that come late.
//!
//! Source: hoot, sections 1.2 and 2; safety decision 7.

mod form;
mod profile;
mod table;
mod value;

use core::fmt;

use motion_core::wire::{EncodeError, FieldView, Fields, Value as Shown, Visitor};

use crate::message::{Reply, ResponseCode, Value, ValueType};
pub(crate) use form::Form;
pub use profile::{DelayUnit, Profile, ProfileError};
pub(crate) use table::is_same;
pub use table::{AnyQuery, AnyReply};
pub use value::ReplyValue;

/// Request that asks for a value.
pub trait Query: Copy {
    /// Value that the query asks for.
    type Reply<'a>: IntoReply<'a>;

    /// Reads the reply to the query.
    ///
    /// # Errors
    ///
    /// [`ReplyError`], if the node refused, or if the value cannot be the answer to this query.
    fn decode_reply<'a>(&self, reply: Reply<'a>) -> Result<Self::Reply<'a>, ReplyError>;

    /// Makes the reply to the query, with its data in `out`.
    ///
    /// # Errors
    ///
    /// [`EncodeError::BufferTooSmall`]; [`MAX_DATA`](crate::frame::MAX_DATA) bytes are enough, except for long texts.
    fn reply<'o>(&self, answer: Self::Reply<'_>, out: &'o mut [u8]) -> Result<Reply<'o>, EncodeError> {
        let value = answer.value();
        // Text is the only type that does not tell the length of its values.
        let size = if let Value::String(text) = value { text.0.len() } else { value.value_type().size().unwrap_or(0) };
        let small = EncodeError::BufferTooSmall { needed: size.saturating_add(1), have: out.len() };
        let len = value.write(out).ok_or(small)?;
        Ok(Reply { code: ResponseCode::OK, data: out.get(..len).ok_or(small)? })
    }
}

/// Value of a reply.
pub trait IntoReply<'a> {
    /// The value, with the type with which it is sent.
    fn value(&self) -> Value<'a>;
}

/// Value, and the type in front of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Answer<T> {
    /// The value.
    pub value: T,
    value_type: ValueType,
}

impl<'a, T: ReplyValue<'a>> Answer<T> {
    /// Makes an answer of this type, or of the usual type of the value if the value does not fit into this type.
    pub(super) fn new(value: T, value_type: ValueType) -> Self {
        Self { value, value_type: value.to_value(value_type).value_type() }
    }
}

impl<T> Answer<T> {
    /// Type in front of the value.
    #[must_use]
    pub const fn value_type(&self) -> ValueType {
        self.value_type
    }

    /// Whether the value from firmware of this profile is reliable.
    ///
    /// A `FLOAT` is not reliable unless the profile is [`Profile::LIBRARY_2014_09_25`]: builds from 2014-10-07 to v0.32
    /// send garbage under that type, which looks like a value (safety decision 7).
    #[must_use]
    pub fn is_reliable(&self, profile: Profile) -> bool {
        self.value_type != ValueType::FLOAT || profile.float_is_true() == Some(true)
    }
}

impl<T: fmt::Display> fmt::Display for Answer<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.value.fmt(f)
    }
}

/// Type and value, as the [`Reply`] shows them.
impl<'a, T: ReplyValue<'a> + fmt::Display> Fields for Answer<T> {
    fn fields(&self, visitor: &mut dyn Visitor) {
        let value = self.value();
        let mut show =
            |name, unit, value, text: &dyn fmt::Display| visitor.visit(&FieldView { name, unit, value, text });
        show("value_type", "", Shown::Unsigned(self.value_type.0.into()), &self.value_type);
        show("value", self.value.unit(), value.shown(), &self.value);
    }
}

/// A map of the type and the raw value.
#[cfg(feature = "serde")]
impl<'a, T: ReplyValue<'a> + fmt::Display> motion_core::serde::Serialize for Answer<T> {
    fn serialize<S: motion_core::serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        motion_core::serialize::fields(self, serializer)
    }
}

impl<'a, T: ReplyValue<'a>> IntoReply<'a> for Answer<T> {
    fn value(&self) -> Value<'a> {
        self.value.to_value(self.value_type)
    }
}

/// Error of a reply that does not answer a query.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum ReplyError {
    /// The node refused. Nodes never tell the reason.
    #[error("the node refused with response code {code}")]
    Node {
        /// Response code.
        code: ResponseCode,
    },
    /// The data ends before the value does.
    #[error("reply: need {need} bytes, have {have}")]
    Short {
        /// Number of bytes that the value needs, with its type.
        need: usize,
        /// Number of bytes of data.
        have: usize,
    },
    /// Data follows after the value.
    #[error("reply: {extra} bytes too many")]
    Trailing {
        /// Number of bytes after the value.
        extra: usize,
    },
    /// The value has another meaning or another size than that of the query.
    #[error("reply: a value of type {found}, expected {expected}")]
    ValueType {
        /// Type in front of the value.
        found: ValueType,
        /// Type that the value should have.
        expected: ValueType,
    },
}

#[inline]
fn decode<'a, T: ReplyValue<'a>>(form: Form, reply: Reply<'a>) -> Result<Answer<T>, ReplyError> {
    let value = if reply.is_ok() { reply.value() } else { None };
    value
        .filter(|value| form.is_taken(value.value_type()))
        .and_then(|value| Some(Answer { value: T::from_value(value)?, value_type: value.value_type() }))
        .ok_or_else(|| refusal(form, reply))
}

/// Error of a reply that does not answer a query of this form. It is not inlined, because most replies do answer.
#[cold]
fn refusal(form: Form, reply: Reply<'_>) -> ReplyError {
    if !reply.is_ok() {
        return ReplyError::Node { code: reply.code };
    }
    let expected = form.of(Profile::default());
    let found = reply.value_type().unwrap_or(expected);
    let (need, have) = (found.size().unwrap_or(0).saturating_add(1), reply.data.len());
    if have < need {
        ReplyError::Short { need, have }
    } else if have > need && found.size().is_some() {
        ReplyError::Trailing { extra: have.saturating_sub(need) }
    } else {
        ReplyError::ValueType { found, expected }
    }
}
