//! Decimal numbers that travel as integers: hundredths, thousandths and finer.
//!
//! The scale is part of the type, so a position in thousandths cannot be taken for one in hundredths.
//! Nothing is lost on the way: the integer of the wire stays as it is, text is read and printed digit
//! by digit, and a number that went to `f64` comes back as the same integer.
//!
//! ```
//! use motion_core::fixed::{Centi, FixedError, Milli};
//!
//! let rate: Milli<u32> = Milli::from_f64(24_000.0 / 1_001.0)?;
//! assert_eq!(rate.raw(), 23_976);
//! assert_eq!(rate.to_string(), "23.976");
//!
//! let limit: Centi<i16> = "-12.3".parse()?;
//! assert_eq!(limit, Centi::from_raw(-1_230));
//! assert_eq!("1.005".parse::<Centi>(), Err(FixedError::TooFine { decimals: 2 }));
//! # Ok::<(), FixedError>(())
//! ```

use core::fmt;
use core::str::FromStr;

/// An integer of at most 32 bits that a [`Scaled`] number can be kept in.
pub trait Integer: Copy + Into<i64> + Into<f64> + TryFrom<i64> + sealed::Sealed {
    /// The least and the greatest value.
    const RANGE: (Self, Self);
}

mod sealed {
    pub trait Sealed {}
}

macro_rules! integers {
    ($($integer:ty)*) => {$(
        impl sealed::Sealed for $integer {}
        impl Integer for $integer {
            const RANGE: (Self, Self) = (Self::MIN, Self::MAX);
        }
    )*};
}
integers! { i16 u16 i32 u32 }

/// A number in steps of one part in `SCALE`, kept as the integer number of such steps.
///
/// `SCALE` is a power of ten; anything else does not compile where text or floats are concerned.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(transparent)]
pub struct Scaled<T, const SCALE: u32>(pub T);

/// Tenths.
pub type Deci<T = i32> = Scaled<T, 10>;
/// Hundredths.
pub type Centi<T = i32> = Scaled<T, 100>;
/// Thousandths.
pub type Milli<T = i32> = Scaled<T, 1_000>;
/// Hundred-thousandths, which are ten millionths each.
pub type TenMicro<T = i32> = Scaled<T, 100_000>;

/// Why a number is not kept as a [`Scaled`] one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum FixedError {
    /// A float is infinite or not a number.
    #[error("scaled number: not finite")]
    NotFinite,
    /// The number of steps does not fit the integer.
    #[error("scaled number: not in {least}..={most} when multiplied by {scale}")]
    OutOfRange {
        /// The least number of steps that fits.
        least: i64,
        /// The greatest number of steps that fits.
        most: i64,
        /// Steps to the whole.
        scale: u32,
    },
    /// There is no text.
    #[error("scaled number: no text")]
    Empty,
    /// The text is something else than an optional sign, digits, and at most one point among them.
    #[error("scaled number: neither sign, digit nor point at byte {at}")]
    NotANumber {
        /// Where it goes wrong.
        at: usize,
    },
    /// The text has more decimals than there are, and they are not zero.
    #[error("scaled number: more than {decimals} decimals")]
    TooFine {
        /// How many there are.
        decimals: u32,
    },
}

impl<T, const SCALE: u32> Scaled<T, SCALE> {
    /// Takes a number of steps, as the wire has it.
    #[inline]
    #[must_use]
    pub const fn from_raw(steps: T) -> Self {
        Self(steps)
    }
}

impl<T: Integer, const SCALE: u32> Scaled<T, SCALE> {
    /// How many decimals there are.
    const DECIMALS: u32 = {
        let decimals = SCALE.ilog10();
        assert!(10_u32.pow(decimals) == SCALE, "the scale of a Scaled number is a power of ten");
        decimals
    };

    /// The number of steps, as the wire has it.
    #[inline]
    #[must_use]
    pub const fn raw(self) -> T {
        self.0
    }

    /// Takes a whole number.
    ///
    /// # Errors
    ///
    /// [`FixedError::OutOfRange`] if its steps do not fit the integer.
    pub fn from_whole(whole: T) -> Result<Self, FixedError> {
        let whole: i64 = whole.into();
        Self::from_steps(whole.saturating_mul(SCALE.into()))
    }

    /// The number, to the nearest `f64`.
    #[inline]
    #[must_use]
    pub fn to_f64(self) -> f64 {
        // Both sides are exact, so the quotient is rounded once.
        let steps: f64 = self.0.into();
        steps / f64::from(SCALE)
    }

    /// Takes the nearest step, or of two that are equally near the one away from zero.
    ///
    /// What [`to_f64`](Self::to_f64) gave comes back as it was. The product with the scale is computed
    /// in `f64`, whose error of one part in 2^53 comes first.
    ///
    /// # Errors
    ///
    /// [`FixedError::NotFinite`] and [`FixedError::OutOfRange`].
    pub fn from_f64(value: f64) -> Result<Self, FixedError> {
        if !value.is_finite() {
            return Err(FixedError::NotFinite);
        }
        Self::from_float_steps(libm::round(value * f64::from(SCALE)))
    }

    /// Takes the next step towards zero, as C firmware does that casts a product of `float`s.
    ///
    /// The product is computed in `f32`, and rounded there first: 0.29 gives 29 hundredths, 1.999
    /// gives 199.
    ///
    /// # Errors
    ///
    /// [`FixedError::NotFinite`] and [`FixedError::OutOfRange`].
    pub fn from_f32_truncated(value: f32) -> Result<Self, FixedError> {
        if !value.is_finite() {
            return Err(FixedError::NotFinite);
        }
        #[expect(clippy::cast_precision_loss, reason = "powers of ten are exact in f32 up to 10^10")]
        let scale = SCALE as f32;
        Self::from_float_steps(libm::truncf(value * scale).into())
    }

    /// Takes a whole number of steps.
    fn from_float_steps(steps: f64) -> Result<Self, FixedError> {
        let (least, most): (f64, f64) = (T::RANGE.0.into(), T::RANGE.1.into());
        if !(least..=most).contains(&steps) {
            return Err(Self::out_of_range());
        }
        #[expect(clippy::cast_possible_truncation, reason = "whole, and within 33 bits")]
        Self::from_steps(steps as i64)
    }

    fn from_steps(steps: i64) -> Result<Self, FixedError> {
        T::try_from(steps).map(Self).map_err(|_| Self::out_of_range())
    }

    fn out_of_range() -> FixedError {
        let (least, most) = T::RANGE;
        FixedError::OutOfRange { least: least.into(), most: most.into(), scale: SCALE }
    }
}

/// Prints the exact number, always with all its decimals: `12.30` is a number of hundredths.
///
/// Width, fill, sign and leading zeros are honoured; a precision is not.
impl<T: Integer, const SCALE: u32> fmt::Display for Scaled<T, SCALE> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let steps: i64 = self.0.into();
        let mut rest = steps.unsigned_abs();
        // From behind, until all decimals and one more digit are there: at most ten, and a point.
        let mut text = [0; 11];
        let mut start = text.len();
        let mut put = |byte| {
            start = start.saturating_sub(1);
            if let Some(place) = text.get_mut(start) {
                *place = byte;
            }
        };
        let mut digits = 0_u32;
        while rest > 0 || digits <= Self::DECIMALS {
            if digits == Self::DECIMALS && digits > 0 {
                put(b'.');
            }
            put(b'0' | (rest % 10) as u8);
            rest /= 10;
            digits = digits.saturating_add(1);
        }
        let text = text.get(start..).and_then(|text| core::str::from_utf8(text).ok());
        f.pad_integral(steps >= 0, "", text.unwrap_or_default())
    }
}

/// Prints what `Display` prints.
impl<T: Integer, const SCALE: u32> fmt::Debug for Scaled<T, SCALE> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// Reads `-12.34`, `+5`, `.5` or `7.`: the exact number, or nothing.
impl<T: Integer, const SCALE: u32> FromStr for Scaled<T, SCALE> {
    type Err = FixedError;

    fn from_str(text: &str) -> Result<Self, FixedError> {
        if text.is_empty() {
            return Err(FixedError::Empty);
        }
        let mut steps = 0_u64;
        let mut digits = 0_usize;
        // How many digits stand behind the point, if there is one.
        let mut decimals: Option<u32> = None;
        for (at, byte) in text.bytes().enumerate() {
            match byte {
                b'+' | b'-' if at == 0 => {}
                b'.' if decimals.is_none() => decimals = Some(0),
                b'0'..=b'9' => {
                    digits = digits.saturating_add(1);
                    if decimals != Some(Self::DECIMALS) {
                        steps = steps.saturating_mul(10).saturating_add((byte & 0x0F).into());
                        decimals = decimals.map(|decimals| decimals.saturating_add(1));
                    } else if byte != b'0' {
                        return Err(FixedError::TooFine { decimals: Self::DECIMALS });
                    }
                }
                _ => return Err(FixedError::NotANumber { at }),
            }
        }
        if digits == 0 {
            return Err(FixedError::NotANumber { at: text.len() });
        }
        let missing = Self::DECIMALS.saturating_sub(decimals.unwrap_or(0));
        let steps = steps.saturating_mul(10_u64.saturating_pow(missing));
        let steps = i64::try_from(steps).unwrap_or(i64::MAX);
        Self::from_steps(if text.starts_with('-') { steps.saturating_neg() } else { steps })
    }
}

#[cfg(test)]
mod tests {
    use std::format;
    use std::string::{String, ToString};

    use proptest::prelude::*;

    use super::*;

    /// Everything a number can be turned into gives the same number back.
    fn comes_back<T: Integer + PartialEq, const SCALE: u32>(steps: T) {
        let number = Scaled::<T, SCALE>::from_raw(steps);
        assert_eq!(Scaled::from_f64(number.to_f64()), Ok(number), "by f64");
        assert_eq!(number.to_string().parse(), Ok(number), "by text");
        assert_eq!(number.to_string(), reference(number.0.into(), SCALE));
        // The text, read by somebody else, is the same float: the quotient was rounded once.
        let read: f64 = number.to_string().parse().unwrap();
        assert_eq!(number.to_f64().to_bits(), read.to_bits(), "{number} as f64");
    }

    fn on_every_scale<T: Integer + PartialEq>(steps: T) {
        comes_back::<T, 1>(steps);
        comes_back::<T, 10>(steps);
        comes_back::<T, 100>(steps);
        comes_back::<T, 1_000>(steps);
        comes_back::<T, 100_000>(steps);
        comes_back::<T, 1_000_000_000>(steps);
    }

    fn reference(steps: i64, scale: u32) -> String {
        let sign = if steps < 0 { "-" } else { "" };
        let decimals = scale.ilog10() as usize;
        let (whole, part) = (steps.unsigned_abs() / u64::from(scale), steps.unsigned_abs() % u64::from(scale));
        if decimals == 0 { format!("{sign}{whole}") } else { format!("{sign}{whole}.{part:0decimals$}") }
    }

    #[test]
    fn every_16_bit_number_comes_back() {
        for steps in i16::MIN..=i16::MAX {
            on_every_scale(steps);
        }
        for steps in 0..=u16::MAX {
            on_every_scale(steps);
        }
    }

    #[test]
    fn edges_come_back() {
        for near in -200_000..=200_000 {
            comes_back::<i32, 1_000>(i32::MIN.wrapping_add(near));
            comes_back::<u32, 100_000>(u32::MIN.wrapping_add_signed(near));
        }
        for steps in [i32::MIN, i32::MIN + 1, -1, 0, 1, i32::MAX - 1, i32::MAX] {
            on_every_scale(steps);
        }
        for steps in [0, 1, u32::MAX - 1, u32::MAX] {
            on_every_scale(steps);
        }
    }

    proptest! {
        #[test]
        fn any_number_comes_back(signed: i32, unsigned: u32) {
            on_every_scale(signed);
            on_every_scale(unsigned);
        }

        #[test]
        fn any_text_is_read_or_refused(text in "[-+]{0,2}[0-9]{0,12}[.]{0,2}[0-9]{0,7}[x ]{0,1}") {
            let read = text.parse::<Milli>();
            if let Ok(number) = read {
                let other: f64 = text.parse().unwrap();
                prop_assert!((number.to_f64() - other).abs() == 0.0, "{text} is {other}, not {number}");
            }
            // Nobody else reads what is refused as no number at all.
            if matches!(read, Err(FixedError::NotANumber { .. } | FixedError::Empty)) {
                prop_assert!(text.parse::<f64>().is_err());
            }
        }

        #[test]
        fn the_nearest_step_is_taken(value in -2.1e6..2.1e6) {
            let number = Milli::<i32>::from_f64(value).unwrap();
            prop_assert!((number.to_f64() - value).abs() <= 0.000_5 + 1e-9, "{value} became {number}");
        }
    }

    #[test]
    fn halves_go_away_from_zero() {
        for (value, steps) in [(0.5, 1), (1.5, 2), (2.5, 3), (-0.5, -1), (-2.5, -3), (0.499, 0), (-0.499, 0)] {
            assert_eq!(Scaled::<i32, 1>::from_f64(value), Ok(Scaled(steps)), "{value}");
        }
        assert_eq!(Deci::from_f64(0.25), Ok(Deci::from_raw(3)));
    }

    #[test]
    fn floats_are_cut_as_firmware_cuts_them() {
        let cut = |value| Centi::<i32>::from_f32_truncated(value).map(Centi::raw);
        for (value, steps) in [(0.29, 29), (1.999, 199), (-1.999, -199), (-0.004, 0), (123.45, 12_345)] {
            assert_eq!(cut(value), Ok(steps), "{value}");
        }
        assert_eq!(cut(f32::NAN), Err(FixedError::NotFinite));
        assert_eq!(cut(f32::MAX), Err(Centi::<i32>::out_of_range()));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let refused = Err(FixedError::OutOfRange { least: 0, most: 65_535, scale: 100 });
        for value in [-0.01, 655.36, 1e308, -1e308] {
            assert_eq!(Centi::<u16>::from_f64(value), refused, "{value}");
        }
        assert_eq!(Centi::<u16>::from_f64(-0.004), Ok(Scaled(0)));
        assert_eq!(Centi::<u16>::from_f64(655.354), Ok(Scaled(65_535)));
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(Centi::<u16>::from_f64(value), Err(FixedError::NotFinite), "{value}");
        }
        assert_eq!(Centi::<u16>::from_whole(655), Ok(Scaled(65_500)));
        assert_eq!(Centi::<u16>::from_whole(656), refused);
        assert_eq!(Milli::<i32>::from_whole(-2_147_483).map(Milli::raw), Ok(-2_147_483_000));
        for text in ["655.36", "-0.01", "99999999999999999999", "-99999999999999999999.99"] {
            assert_eq!(text.parse::<Centi<u16>>(), refused, "{text}");
        }
    }

    #[test]
    fn text_is_read_exactly() {
        let read = |text: &str| text.parse::<Centi>().map(Centi::raw);
        for (text, steps) in [
            ("-12.34", -1_234),
            ("+5", 500),
            (".5", 50),
            ("7.", 700),
            ("1.2000", 120),
            ("-0", 0),
            ("-21474836.48", i32::MIN),
            ("0000000000000000000000001", 100),
        ] {
            assert_eq!(read(text), Ok(steps), "{text}");
        }
        assert_eq!(read(""), Err(FixedError::Empty));
        assert_eq!(read("0.001"), Err(FixedError::TooFine { decimals: 2 }));
        for (text, at) in [("-", 1), (".", 1), ("1.2.3", 3), ("1e3", 1), (" 1", 0), ("1-", 1), ("--1", 1), ("inf", 0)] {
            assert_eq!(read(text), Err(FixedError::NotANumber { at }), "{text}");
        }
    }

    #[test]
    fn printing_honours_the_format() {
        let number = Centi::<i32>::from_raw(-1_230);
        assert_eq!(format!("{number} {number:?} [{number:>8}] [{number:08}]"), "-12.30 -12.30 [  -12.30] [-0012.30]");
        assert_eq!(format!("{:+}", Milli::<u16>::from_raw(7)), "+0.007");
    }

    #[test]
    fn errors_say_what_and_where() {
        let texts =
            [FixedError::NotANumber { at: 3 }, FixedError::TooFine { decimals: 2 }, Centi::<i16>::out_of_range()]
                .map(|error| error.to_string());
        assert_eq!(
            texts,
            [
                "scaled number: neither sign, digit nor point at byte 3",
                "scaled number: more than 2 decimals",
                "scaled number: not in -32768..=32767 when multiplied by 100",
            ]
        );
    }
}
