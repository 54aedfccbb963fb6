//! Values from text that people type: units, numbers of motors, addresses.
//!
//! Each text that a value prints is read back as the same value, except NaN and infinite numbers, which nobody means.

use core::str::FromStr;

use crate::fixed::{FixedError, Scaled};

/// Error of a text that is no value of a type.
#[derive(Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[error("{what}: {why}")]
pub struct ParseError {
    /// Name of the type.
    pub what: &'static str,
    /// Reason.
    pub why: ParseProblem,
}

/// Reason why a text is no value of a type.
#[derive(Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum ParseProblem {
    /// The text is no number, or a number that the type does not have.
    #[error(transparent)]
    Number(#[from] FixedError),
    /// The text does not have the form of the type.
    #[error("byte {at} does not fit: write {form}")]
    Form {
        /// Position of the first byte that does not fit, from 0.
        at: usize,
        /// The form, with an example.
        form: &'static str,
    },
}

crate::bezier::print::debug_as_text! { ParseError ParseProblem }

/// Number that people type.
#[doc(hidden)]
pub trait Number: Sized {
    /// Reads the number.
    ///
    /// # Errors
    ///
    /// [`FixedError`].
    fn parse(text: &str) -> Result<Self, FixedError>;
}

macro_rules! integers {
    ($($integer:ty)*) => {$(
        impl Number for $integer {
            fn parse(text: &str) -> Result<Self, FixedError> {
                text.parse().map(Scaled::<Self, 1>::raw)
            }
        }
    )*};
}
integers! { u8 i16 u16 i32 u32 }

impl<T, const SCALE: u32> Number for Scaled<T, SCALE>
where
    Self: FromStr<Err = FixedError>,
{
    fn parse(text: &str) -> Result<Self, FixedError> {
        text.parse()
    }
}

impl Number for f32 {
    /// Reads a decimal number such as `-0.5`, `2` or `1e-3`. The parser of core cannot be proven free of panics.
    #[expect(clippy::cast_possible_truncation, reason = "the nearest f32 is wanted; an infinite one is refused")]
    fn parse(text: &str) -> Result<Self, FixedError> {
        let (number, exponent) = match text.split_once(['e', 'E']) {
            Some((number, exponent)) => {
                let at = number.len().saturating_add(1);
                let exponent = i16::parse(exponent).map_err(|error| match error {
                    FixedError::NotANumber { at: byte } => FixedError::NotANumber { at: at.saturating_add(byte) },
                    FixedError::Empty => FixedError::NotANumber { at },
                    error => error,
                })?;
                (number, i32::from(exponent))
            }
            None => (text, 0),
        };
        let (mut digits, mut exponent, mut value, mut point) = (0_usize, exponent, 0_u64, false);
        if text.is_empty() {
            return Err(FixedError::Empty);
        }
        for (at, byte) in number.bytes().enumerate() {
            match byte {
                b'+' | b'-' if at == 0 => {}
                b'.' if !point => point = true,
                b'0'..=b'9' => {
                    digits = digits.saturating_add(1);
                    // More digits than these do not change an f32.
                    let is_kept = value < 1_000_000_000_000_000_000;
                    if is_kept {
                        value = value.saturating_mul(10).saturating_add((byte & 0x0F).into());
                    }
                    exponent = exponent.saturating_add(match (is_kept, point) {
                        (true, true) => -1,
                        (false, false) => 1,
                        _ => 0,
                    });
                }
                _ => return Err(FixedError::NotANumber { at }),
            }
        }
        if digits == 0 {
            return Err(FixedError::NotANumber { at: number.len() });
        }
        #[expect(clippy::cast_precision_loss, reason = "an f32 has fewer digits")]
        let value = scaled(value as f64, exponent) as Self;
        let value = if text.starts_with('-') { -value } else { value };
        if value.is_finite() { Ok(value) } else { Err(FixedError::NotFinite) }
    }
}

/// A number times a power of ten.
fn scaled(value: f64, exponent: i32) -> f64 {
    let (mut power, mut square, mut left) = (1.0, 10.0, exponent.unsigned_abs());
    while left > 0 {
        if left & 1 == 1 {
            power *= square;
        }
        square *= square;
        left >>= 1;
    }
    match value {
        0.0 => 0.0,
        _ if exponent < 0 => value / power,
        _ => value * power,
    }
}

/// Reads `N` bytes, written in a base between separators.
///
/// # Errors
///
/// Position of the first byte that does not fit.
#[doc(hidden)]
pub fn bytes<const N: usize>(text: &str, separator: u8, base: u8) -> Result<[u8; N], usize> {
    let (mut values, mut is_first) = ([0_u8; N], true);
    // The counter of `enumerate` could overflow, as far as core knows.
    let mut rest = (0..text.len()).zip(text.bytes()).peekable();
    for value in &mut values {
        if !core::mem::take(&mut is_first) {
            match rest.next() {
                Some((_, byte)) if byte == separator => {}
                Some((at, _)) => return Err(at),
                None => return Err(text.len()),
            }
        }
        let mut is_empty = true;
        while let Some((at, byte)) = rest.next_if(|&(_, byte)| byte != separator) {
            // `to_digit` of core panics at some bases.
            let digit = match byte {
                b'0'..=b'9' => byte.wrapping_sub(b'0'),
                b'a'..=b'f' => byte.wrapping_sub(b'a' - 10),
                b'A'..=b'F' => byte.wrapping_sub(b'A' - 10),
                _ => u8::MAX,
            };
            let next = value.checked_mul(base).filter(|_| digit < base).and_then(|value| value.checked_add(digit));
            *value = next.ok_or(at)?;
            is_empty = false;
        }
        if is_empty {
            return Err(rest.peek().map_or(text.len(), |&(at, _)| at));
        }
    }
    rest.next().map_or(Ok(values), |(at, _)| Err(at))
}

#[cfg(test)]
mod tests {
    use std::format;
    use std::string::ToString;

    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_text_that_is_no_number_tells_where() {
        let at = |at| Err(FixedError::NotANumber { at });
        for (text, expected) in [
            ("-0.5", Ok(-0.5)),
            (".5", Ok(0.5)),
            ("1e-3", Ok(0.001)),
            ("16777217", Ok(16_777_216.0)),
            ("340282350000000000000000000000000000000", Ok(f32::MAX)),
            ("0e999", Ok(0.0)),
            ("1e39", Err(FixedError::NotFinite)),
            ("1e9999", Err(FixedError::NotFinite)),
            ("", Err(FixedError::Empty)),
            ("NaN", at(0)),
            ("inf", at(0)),
            ("-", at(1)),
            ("1.2.3", at(3)),
            ("3 m", at(1)),
            ("1e", at(2)),
            ("1ex", at(2)),
            ("1e2.5", Err(FixedError::TooFine { decimals: 0 })),
        ] {
            assert_eq!(f32::parse(text), expected, "{text}");
        }
        assert_eq!(u8::parse("256"), Err(FixedError::OutOfRange { least: 0, most: 255, scale: 1 }));
        assert_eq!(u8::parse("-1").unwrap_err().to_string(), "not from 0 to 255");
    }

    #[test]
    fn bytes_between_separators_are_read_in_their_base() {
        assert_eq!(bytes::<4>("192.168.50.1", b'.', 10), Ok([192, 168, 50, 1]));
        assert_eq!(bytes::<2>("0a:FF", b':', 16), Ok([10, 255]));
        for (text, at) in [("", 0), ("1", 1), ("1.", 2), ("1.256", 4), ("1.2.3", 3), ("1.x", 2), ("1 .2", 1)] {
            assert_eq!(bytes::<2>(text, b'.', 10), Err(at), "{text}");
        }
    }

    proptest! {
        #[test]
        fn each_finite_number_is_read_back(bits: u32) {
            let number = f32::from_bits(bits);
            prop_assume!(number.is_finite());
            let mut printed = std::string::String::new();
            crate::wire::print::float(&mut printed, number).unwrap();
            prop_assert_eq!(f32::parse(&printed).map(f32::to_bits), Ok(bits), "{}", printed);
        }

        #[test]
        fn typed_numbers_are_read_as_core_reads_them(whole: u32, decimals in 0_u64..1_000_000_000) {
            let text = format!("{whole}.{decimals:09}");
            let (read, core): (f32, f32) = (f32::parse(&text).unwrap(), text.parse().unwrap());
            prop_assert!(read.to_bits().abs_diff(core.to_bits()) <= 1, "{text}: {read}, {core}");
        }
    }
}
