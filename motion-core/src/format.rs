//! Values in `defmt` logs. The target holds no text: names are interned, and only numbers and bytes are sent.

#![doc(hidden)]

use core::marker::PhantomData;

use defmt::{Format, Formatter};

use crate::fixed::Scaled;
use crate::wire::{Bool, Bytes, DecodeError, EncodeError, Field, Part, Value};

/// Field or part of a message.
pub struct Logged<'x, 'a, P>(&'x P, PhantomData<&'a ()>);

impl<'x, P> Logged<'x, '_, P> {
    /// Makes it of a part.
    pub const fn new(part: &'x P) -> Self {
        Self(part, PhantomData)
    }
}

impl<'a, P: Part<'a>> Format for Logged<'_, 'a, P> {
    fn format(&self, f: Formatter<'_>) {
        self.0.log_part(f);
    }
}

/// Logs a raw value. Lists and groups are logged by their parts.
#[expect(clippy::match_same_arms, reason = "the lint does not see the interned texts")]
pub fn value(f: Formatter<'_>, value: Value<'_>) {
    match value {
        Value::Unsigned(number) => defmt::write!(f, "{=u64}", number),
        Value::Signed(number) => defmt::write!(f, "{=i64}", number),
        Value::Float(number) => defmt::write!(f, "{=f32}", number),
        Value::Text(text) => {
            if let Ok(text) = core::str::from_utf8(text) {
                defmt::write!(f, "{=str}", text);
            } else {
                bytes(f, text);
            }
        }
        Value::Secret(_) => defmt::write!(f, "(redacted)"),
        Value::Bytes(text) => bytes(f, text),
        Value::List(_) | Value::Group(_) => defmt::write!(f, ".."),
    }
}

/// Logs an optional field.
pub fn optional<T: Field>(f: Formatter<'_>, field: Option<T>) {
    if let Some(field) = field {
        field.log(f);
    } else {
        defmt::write!(f, "none");
    }
}

/// Logs the bytes of a list.
pub fn bytes(f: Formatter<'_>, bytes: &[u8]) {
    defmt::write!(f, "{=[u8]}", bytes);
}

impl Format for Bool {
    fn format(&self, f: Formatter<'_>) {
        defmt::write!(f, "{=u8}", self.0);
    }
}

impl<const N: usize> Format for Bytes<N> {
    fn format(&self, f: Formatter<'_>) {
        bytes(f, &self.0);
    }
}

/// The number of steps.
impl<T: Format, const SCALE: u32> Format for Scaled<T, SCALE> {
    fn format(&self, f: Formatter<'_>) {
        self.0.format(f);
    }
}

/// Its numbers, without the name of the field.
impl Format for DecodeError {
    fn format(&self, f: Formatter<'_>) {
        match *self {
            Self::Truncated { needed, have, .. } => {
                defmt::write!(f, "Truncated {{ needed: {=usize}, have: {=usize} }}", needed, have);
            }
            Self::Trailing { extra, .. } => defmt::write!(f, "Trailing {{ extra: {=usize} }}", extra),
            Self::OutOfRange { value, .. } => defmt::write!(f, "OutOfRange {{ value: {=i64} }}", value),
        }
    }
}

/// Its numbers, without the name of the field.
impl Format for EncodeError {
    #[expect(clippy::match_same_arms, reason = "the lint does not see the interned texts")]
    fn format(&self, f: Formatter<'_>) {
        match *self {
            Self::BufferTooSmall { needed, have } => {
                defmt::write!(f, "BufferTooSmall {{ needed: {=usize}, have: {=usize} }}", needed, have);
            }
            Self::Hole { .. } => defmt::write!(f, "Hole"),
            Self::Tail { len, .. } => defmt::write!(f, "Tail {{ len: {=usize} }}", len),
            Self::TooLong { len, max, .. } => {
                defmt::write!(f, "TooLong {{ len: {=usize}, max: {=usize} }}", len, max);
            }
            Self::OutOfRange { value, .. } => defmt::write!(f, "OutOfRange {{ value: {=i64} }}", value),
            Self::Typed { .. } => defmt::write!(f, "Typed"),
            Self::Refused(_) => defmt::write!(f, "Refused"),
        }
    }
}
