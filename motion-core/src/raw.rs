//! Single values in serde formats: the raw values of the wire, as in the maps that [`serialize`](crate::serialize)
//! describes. No value is read that could not be written.

#![doc(hidden)]

use core::fmt;
use core::marker::PhantomData;
use core::str::FromStr;

use serde::de::{Deserialize, Deserializer, Error, Unexpected, Visitor};
use serde::ser::{Serialize, Serializer};

use crate::fixed::{Integer, Scaled};
use crate::parse;
use crate::wire::{Bool, Bytes, Field};

/// Type of a raw value.
pub trait Raw: Sized {
    /// Reads the value.
    ///
    /// # Errors
    ///
    /// The errors of the deserializer, and an error of a value that the type does not have.
    fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error>;
}

macro_rules! integers {
    ($($integer:ty)*) => {$(
        impl Raw for $integer {
            fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                Self::deserialize(deserializer)
            }
        }
    )*};
}
integers! { u8 i16 u16 i32 u32 }

impl<T: Raw, const SCALE: u32> Raw for Scaled<T, SCALE> {
    fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        T::read(deserializer).map(Self)
    }
}

impl<const N: usize> Raw for Bytes<N> {
    fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Hex<const N: usize>;

        impl<const N: usize> Visitor<'_> for Hex<N> {
            type Value = Bytes<N>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{N} bytes in hex")
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Bytes<N>, E> {
                let mut bytes = [0; N];
                let read = hex(text, &mut bytes);
                read.map(|()| Bytes(bytes)).ok_or_else(|| E::invalid_value(Unexpected::Str(text), &self))
            }
        }

        deserializer.deserialize_str(Hex)
    }
}

impl Raw for f32 {
    fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Float;

        impl Visitor<'_> for Float {
            type Value = f32;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(FLOAT)
            }

            fn visit_f64<E: Error>(self, number: f64) -> Result<f32, E> {
                nearest(number).ok_or_else(|| E::invalid_value(Unexpected::Float(number), &self))
            }

            #[expect(clippy::cast_precision_loss, reason = "the nearest f32 is wanted")]
            fn visit_u64<E: Error>(self, number: u64) -> Result<f32, E> {
                Ok(number as f32)
            }

            #[expect(clippy::cast_precision_loss, reason = "the nearest f32 is wanted")]
            fn visit_i64<E: Error>(self, number: i64) -> Result<f32, E> {
                Ok(number as f32)
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<f32, E> {
                not_finite(text).ok_or_else(|| E::invalid_value(Unexpected::Str(text), &self))
            }
        }

        deserializer.deserialize_any(Float)
    }
}

/// Form in which an IEEE number of 32 bits is read.
pub(crate) const FLOAT: &str = "a number, or the 32 bits of one that is not finite, as \"0x7fc00000\"";

/// Finite number of 32 bits that is nearest to this number; `None` if there is none.
#[expect(clippy::cast_possible_truncation, reason = "the nearest f32 is wanted; an infinite one is refused")]
pub(crate) fn nearest(number: f64) -> Option<f32> {
    Some(number as f32).filter(|near| near.is_finite())
}

/// Number that is NaN or infinite, from the text of its bits. Numbers that are finite are written in another way.
pub(crate) fn not_finite(text: &str) -> Option<f32> {
    let mut bytes = [0; 4];
    hex(text.strip_prefix("0x")?, &mut bytes)?;
    Some(f32::from_bits(u32::from_be_bytes(bytes))).filter(|number| !number.is_finite())
}

/// Fills `bytes` from a text of hex digits. Returns `None` unless there are exactly two digits for each byte.
pub(crate) fn hex(text: &str, bytes: &mut [u8]) -> Option<()> {
    let mut pairs = text.as_bytes().chunks(2);
    for byte in bytes {
        let pair = core::str::from_utf8(pairs.next()?).ok().filter(|pair| pair.len() == 2)?;
        [*byte] = parse::bytes(pair, b' ', 16).ok()?;
    }
    if pairs.next().is_none() { Some(()) } else { None }
}

/// Writes the text of a value.
///
/// # Errors
///
/// The errors of the serializer.
pub fn write_text<S: Serializer>(value: &impl fmt::Display, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(value)
}

/// Reads the text of a value.
///
/// # Errors
///
/// The errors of the deserializer, and the error of the text.
pub fn read_text<'de, T: FromStr<Err: fmt::Display>, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
    struct Text<T>(PhantomData<T>);

    impl<T: FromStr<Err: fmt::Display>> Visitor<'_> for Text<T> {
        type Value = T;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a text")
        }

        fn visit_str<E: Error>(self, text: &str) -> Result<T, E> {
            text.parse().map_err(E::custom)
        }
    }

    deserializer.deserialize_str(Text(PhantomData))
}

impl<T: Integer + Field, const SCALE: u32> Serialize for Scaled<T, SCALE> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        crate::serialize::value(Field::value(self), serializer)
    }
}

impl<'de, T: Raw, const SCALE: u32> Deserialize<'de> for Scaled<T, SCALE> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Raw::read(deserializer)
    }
}

impl<const N: usize> Serialize for Bytes<N> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        crate::serialize::value(Field::value(self), serializer)
    }
}

impl<'de, const N: usize> Deserialize<'de> for Bytes<N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Raw::read(deserializer)
    }
}

crate::__serde_value! { Bool(u8) }
