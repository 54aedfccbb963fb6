//! What a reply answers: queries type their replies.
//!
//! A reply says whether a request was done, and perhaps a value with its type, but not what it answers. The query that
//! was asked knows: [`Query::decode_reply`] reads the reply in its light, [`Query::reply`] makes it, for nodes.
//! [`AnyQuery`] and [`AnyReply`] do the same for programs that see all of them.
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
//! Firmware differs in the type that it writes in front of a value, as [`Profile`] tells. Every type is taken that some
//! firmware, or the sheet, has for the query; [`Answer::value_type`] shows what was found. Any other type is an error: it
//! is likely the late answer to another question.
//!
//! Some requests are answered by two packets ([`Profile::packets`]), and later firmware is silent at what it does not
//! know: who waits for a reply has to give up, and to drop what comes late.
//!
//! Source: hoot, sections 1.2 and 2; safety decision 7.

mod form;
mod profile;
mod table;
mod value;

use core::fmt;

use motion_core::wire::EncodeError;

use crate::message::{Reply, ResponseCode, Value, ValueType};
use form::Form;
pub use profile::{DelayUnit, Facts, Gate, Profile};
pub use table::{AnyQuery, AnyReply};
pub use value::ReplyValue;

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

/// A value, and the type that stood in front of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Answer<T> {
    /// The value.
    pub value: T,
    value_type: ValueType,
}

impl<'a, T: ReplyValue<'a>> Answer<T> {
    /// A value under this type, or under its usual one, if it has no place in this one.
    pub(super) fn new(value: T, value_type: ValueType) -> Self {
        Self { value, value_type: value.to_value(value_type).value_type() }
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
        self.value_type != ValueType::FLOAT || profile.facts().float_is_true
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

#[inline]
fn decode<'a, T: ReplyValue<'a>>(form: Form, reply: Reply<'a>) -> Result<Answer<T>, ReplyError> {
    let value = if reply.is_ok() { reply.value() } else { None };
    value
        .filter(|value| form.is_taken(value.value_type()))
        .and_then(|value| Some(Answer { value: T::from_value(value)?, value_type: value.value_type() }))
        .ok_or_else(|| refusal(form, reply))
}

/// Why a reply does not answer a query of this form. Out of the way of those that do.
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
