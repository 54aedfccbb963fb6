//! Decimal numbers that are sent as integers: hundredths, thousandths and finer.
//!
//! The scale is part of the type, so a position in thousandths cannot be taken for one in hundredths. Nothing is lost:
//! the integer from the wire is kept as it is, text is read and printed digit by digit, and a number that was converted
//! to `f64` converts back to the same integer.
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

/// An integer of at most 32 bits that can hold a [`Scaled`] number.
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
integers! { u8 i16 u16 i32 u32 }

/// A decimal number in steps of 1 / `SCALE`, stored as an integer number of steps.
///
/// `SCALE` is a power of ten. Conversions of any other scale to text and floats do not compile.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(transparent)]
pub struct Scaled<T, const SCALE: u32>(pub T);

/// A number in tenths.
pub type Deci<T = i32> = Scaled<T, 10>;
/// A number in hundredths.
pub type Centi<T = i32> = Scaled<T, 100>;
/// A number in thousandths.
pub type Milli<T = i32> = Scaled<T, 1_000>;
/// A number in hundred-thousandths; one step is ten millionths.
pub type TenMicro<T = i32> = Scaled<T, 100_000>;

/// Why a number cannot be stored as a [`Scaled`] number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum FixedError {
    /// The float is infinite or NaN.
    #[error("not a finite number")]
    NotFinite,
    /// The number of steps does not fit the integer.
    #[error("not from {} to {}", Decimal::of(*.least, *.scale), Decimal::of(*.most, *.scale))]
    OutOfRange {
        /// Least number of steps that fits.
        least: i64,
        /// Greatest number of steps that fits.
        most: i64,
        /// Number of steps in one whole.
        scale: u32,
    },
    /// The text is empty.
    #[error("empty text")]
    Empty,
    /// The text is not an optional sign, then digits with at most one decimal point.
    #[error("no sign, digit or decimal point at byte {at}")]
    NotANumber {
        /// Position of the first wrong byte, from 0.
        at: usize,
    },
    /// The text has more decimals than the type, and they are not zero.
    #[error("more than {decimals} decimals")]
    TooFine {
        /// Number of decimals of the type.
        decimals: u32,
    },
}

impl<T, const SCALE: u32> Scaled<T, SCALE> {
    /// A number from its steps, as they stand on the wire.
    #[inline]
    #[must_use]
    pub const fn from_raw(steps: T) -> Self {
        Self(steps)
    }
}

impl<T: Integer, const SCALE: u32> Scaled<T, SCALE> {
    /// Number of decimals of the type.
    const DECIMALS: u32 = {
        let decimals = SCALE.ilog10();
        assert!(10_u32.pow(decimals) == SCALE, "the scale of a Scaled number is a power of ten");
        decimals
    };

    /// The number of steps, as it stands on the wire.
    #[inline]
    #[must_use]
    pub const fn raw(self) -> T {
        self.0
    }

    /// A number from a whole number.
    ///
    /// # Errors
    ///
    /// [`FixedError::OutOfRange`] if the number of steps does not fit the integer.
    pub fn from_whole(whole: T) -> Result<Self, FixedError> {
        let whole: i64 = whole.into();
        Self::from_steps(whole.saturating_mul(SCALE.into()))
    }

    /// The nearest `f64` to the number.
    #[inline]
    #[must_use]
    pub fn to_f64(self) -> f64 {
        // Both sides are exact, so the quotient is rounded once.
        let steps: f64 = self.0.into();
        steps / f64::from(SCALE)
    }

    /// The nearest step to a float. A float in the middle between two steps is rounded away from zero.
    ///
    /// The result of [`to_f64`](Self::to_f64) converts back to the same number. The product with the scale is computed
    /// in `f64` before it is rounded to a step, with an error of one part in 2^53.
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

    /// The next step towards zero, as in C firmware that casts a product of `float`s.
    ///
    /// The product is computed and rounded in `f32` first: 0.29 becomes 29 hundredths, 1.999 becomes 199.
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

    /// A number from a whole number of steps.
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
/// Width, fill, sign and leading zeros of the format are respected; a precision is ignored.
impl<T: Integer, const SCALE: u32> fmt::Display for Scaled<T, SCALE> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Decimal { steps: self.0.into(), decimals: Self::DECIMALS }.fmt(f)
    }
}

/// Decimal number of at most ten digits.
struct Decimal {
    steps: i64,
    decimals: u32,
}

impl Decimal {
    fn of(steps: i64, scale: u32) -> Self {
        Self { steps, decimals: scale.checked_ilog10().unwrap_or(0) }
    }
}

impl fmt::Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut rest = self.steps.unsigned_abs();
        // Digits are written from the last to the first, until all decimals and one digit more are there: at most ten
        // digits, and a point.
        let mut text = [0; 11];
        let mut start = text.len();
        let mut put = |byte| {
            start = start.saturating_sub(1);
            if let Some(place) = text.get_mut(start) {
                *place = byte;
            }
        };
        let mut digits = 0_u32;
        while rest > 0 || digits <= self.decimals {
            if digits == self.decimals && digits > 0 {
                put(b'.');
            }
            put(b'0' | (rest % 10) as u8);
            rest /= 10;
            digits = digits.saturating_add(1);
        }
        let text = text.get(start..).and_then(|text| core::str::from_utf8(text).ok());
        f.pad_integral(self.steps >= 0, "", text.unwrap_or_default())
    }
}

/// Prints the same text as `Display`.
impl<T: Integer, const SCALE: u32> fmt::Debug for Scaled<T, SCALE> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// Reads the exact number from text such as `-12.34`, `+5`, `.5` or `7.`; text that is not exact is an error.
impl<T: Integer, const SCALE: u32> FromStr for Scaled<T, SCALE> {
    type Err = FixedError;

    fn from_str(text: &str) -> Result<Self, FixedError> {
        if text.is_empty() {
            return Err(FixedError::Empty);
        }
        let mut steps = 0_u64;
        let mut digits = 0_usize;
        // Number of digits after the point, if there is a point.
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

    /// Every form that a number converts to converts back to the same number.
    fn comes_back<T: Integer + PartialEq, const SCALE: u32>(steps: T) {
        let number = Scaled::<T, SCALE>::from_raw(steps);
        assert_eq!(Scaled::from_f64(number.to_f64()), Ok(number), "by f64");
        assert_eq!(number.to_string().parse(), Ok(number), "by text");
        assert_eq!(number.to_string(), reference(number.0.into(), SCALE));
        // Core reads the text as the same float, because the quotient was rounded once.
        let read: f64 = number.to_string().parse().unwrap();
        assert_eq!(number.to_f64().to_bits(), read.to_bits(), "{number} as f64");
    }

    fn comes_back_on_every_scale<T: Integer + PartialEq>(steps: T) {
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
            comes_back_on_every_scale(steps);
        }
        for steps in 0..=u16::MAX {
            comes_back_on_every_scale(steps);
        }
    }

    #[test]
    fn the_least_and_greatest_numbers_come_back() {
        for near in -200_000..=200_000 {
            comes_back::<i32, 1_000>(i32::MIN.wrapping_add(near));
            comes_back::<u32, 100_000>(u32::MIN.wrapping_add_signed(near));
        }
        for steps in [i32::MIN, i32::MIN + 1, -1, 0, 1, i32::MAX - 1, i32::MAX] {
            comes_back_on_every_scale(steps);
        }
        for steps in [0, 1, u32::MAX - 1, u32::MAX] {
            comes_back_on_every_scale(steps);
        }
    }

    proptest! {
        #[test]
        fn any_number_comes_back(signed: i32, unsigned: u32) {
            comes_back_on_every_scale(signed);
            comes_back_on_every_scale(unsigned);
        }

        #[test]
        fn any_text_is_read_or_refused(text in "[-+]{0,2}[0-9]{0,12}[.]{0,2}[0-9]{0,7}[x ]{0,1}") {
            let read = text.parse::<Milli>();
            if let Ok(number) = read {
                let other: f64 = text.parse().unwrap();
                prop_assert!((number.to_f64() - other).abs() == 0.0, "{text} is {other}, not {number}");
            }
            // Core refuses every text that is refused because it is not a number.
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
    fn halves_are_rounded_away_from_zero() {
        for (value, steps) in [(0.5, 1), (1.5, 2), (2.5, 3), (-0.5, -1), (-2.5, -3), (0.499, 0), (-0.499, 0)] {
            assert_eq!(Scaled::<i32, 1>::from_f64(value), Ok(Scaled(steps)), "{value}");
        }
        assert_eq!(Deci::from_f64(0.25), Ok(Deci::from_raw(3)));
    }

    #[test]
    fn floats_are_truncated_as_firmware_truncates_them() {
        let truncated = |value| Centi::<i32>::from_f32_truncated(value).map(Centi::raw);
        for (value, steps) in [(0.29, 29), (1.999, 199), (-1.999, -199), (-0.004, 0), (123.45, 12_345)] {
            assert_eq!(truncated(value), Ok(steps), "{value}");
        }
        assert_eq!(truncated(f32::NAN), Err(FixedError::NotFinite));
        assert_eq!(truncated(f32::MAX), Err(Centi::<i32>::out_of_range()));
    }

    #[test]
    fn numbers_that_do_not_fit_are_refused() {
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
    fn printing_respects_the_format() {
        let number = Centi::<i32>::from_raw(-1_230);
        assert_eq!(format!("{number} {number:?} [{number:>8}] [{number:08}]"), "-12.30 -12.30 [  -12.30] [-0012.30]");
        assert_eq!(format!("{:+}", Milli::<u16>::from_raw(7)), "+0.007");
    }

    #[test]
    fn errors_name_the_problem_and_its_place() {
        let texts =
            [FixedError::NotANumber { at: 3 }, FixedError::TooFine { decimals: 2 }, Centi::<i16>::out_of_range()]
                .map(|error| error.to_string());
        assert_eq!(
            texts,
            ["no sign, digit or decimal point at byte 3", "more than 2 decimals", "not from -327.68 to 327.67",]
        );
    }
}
