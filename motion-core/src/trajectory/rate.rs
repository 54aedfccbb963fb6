//! Exact frame rates, and the times of frames.

use core::fmt;
use core::str::FromStr;

use crate::bezier::print::{debug_numbers, shown_as_it_is};
use crate::fixed::{FixedError, Milli};

/// Frame rate as an exact fraction, in frames per second: 24, 23.976 or 24000/1001.
///
/// ```
/// use motion_core::fixed::Milli;
/// use motion_core::trajectory::FrameRate;
///
/// let rate: FrameRate = "24000/1001".parse()?;
/// assert_eq!(rate.seconds(24_000), 1_001.0);
/// // The rate that DMC sends is another rate: after an hour, the difference is 3 milliseconds.
/// assert_eq!(rate.to_milli()?, Milli::from_raw(23_976));
/// assert_ne!(FrameRate::try_from(Milli::from_raw(23_976))?, rate);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FrameRate {
    /// Number of frames in this number of seconds, in lowest terms.
    frames: u32,
    /// Number of seconds, in lowest terms.
    seconds: u32,
}

/// Why a frame rate is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum FrameRateError {
    /// The number of frames or of seconds is 0.
    #[error("frame rate: 0, or a division by 0")]
    Zero,
    /// The text is neither a decimal number nor a fraction of two.
    #[error("frame rate: not a number such as 24, 23.976 or 24000/1001")]
    NotANumber,
    /// A decimal number is too large for thousandths in 32 bits, or has more than three decimals.
    #[error("frame rate: {0}")]
    Number(#[from] FixedError),
}

impl FrameRate {
    /// A rate from a number of frames and the number of seconds that they take.
    ///
    /// # Errors
    ///
    /// [`FrameRateError::Zero`] if one of the numbers is 0.
    pub fn new(frames: u32, seconds: u32) -> Result<Self, FrameRateError> {
        let (mut divisor, mut rest) = (frames, seconds);
        while let Some(next) = divisor.checked_rem(rest) {
            (divisor, rest) = (rest, next);
        }
        match (frames.checked_div(divisor), seconds.checked_div(divisor)) {
            (Some(frames @ 1..), Some(seconds @ 1..)) => Ok(Self { frames, seconds }),
            _ => Err(FrameRateError::Zero),
        }
    }

    /// Numerator and denominator in lowest terms: the number of frames, and the number of seconds that they take.
    #[must_use]
    pub const fn fraction(self) -> (u32, u32) {
        (self.frames, self.seconds)
    }

    /// Frames per second, as the nearest `f64`.
    #[must_use]
    pub fn to_f64(self) -> f64 {
        f64::from(self.frames) / f64::from(self.seconds)
    }

    /// The nearest thousandth of a frame per second, as DMC sends it.
    ///
    /// # Errors
    ///
    /// [`FixedError::OutOfRange`] above 4294967.295 frames per second.
    pub fn to_milli(self) -> Result<Milli<u32>, FixedError> {
        Milli::from_f64(self.to_f64())
    }

    /// Time of a frame, in seconds after frame 0. It is exact to the last digit if the product of the frame number and
    /// the seconds of [`fraction`](Self::fraction) is below 2^53.
    #[must_use]
    pub fn seconds(self, frame: u32) -> f64 {
        f64::from(frame) * f64::from(self.seconds) / f64::from(self.frames)
    }
}

impl TryFrom<Milli<u32>> for FrameRate {
    type Error = FrameRateError;

    /// The rate from thousandths of a frame per second, as DMC sends them.
    fn try_from(rate: Milli<u32>) -> Result<Self, FrameRateError> {
        Self::new(rate.raw(), 1_000)
    }
}

/// Reads a rate from text such as `24`, `23.976` or `24000/1001`.
impl FromStr for FrameRate {
    type Err = FrameRateError;

    fn from_str(text: &str) -> Result<Self, FrameRateError> {
        let whole = |text: &str| text.parse().map_err(|_| FrameRateError::NotANumber);
        match text.split_once('/') {
            Some((frames, seconds)) => Self::new(whole(frames)?, whole(seconds)?),
            None => match text.parse::<Milli<u32>>() {
                Ok(rate) => rate.try_into(),
                Err(FixedError::Empty | FixedError::NotANumber { .. }) => Err(FrameRateError::NotANumber),
                Err(error) => Err(error.into()),
            },
        }
    }
}

/// Prints the fraction, or a whole number; the text is read back as the same rate.
impl fmt::Display for FrameRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.seconds {
            1 => write!(f, "{}", self.frames),
            seconds => write!(f, "{}/{seconds}", self.frames),
        }
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for FrameRate {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        crate::raw::write_text(self, serializer)
    }
}

#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for FrameRate {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        crate::raw::read_text(deserializer)
    }
}

/// Times of the frames of a move, the same for all its axes.
#[derive(Clone, Copy, PartialEq)]
pub struct FrameTimes {
    /// Time of frame 0, in seconds.
    pub start: f64,
    /// Frame rate.
    pub rate: FrameRate,
    /// Number of frames, including the first and the last.
    pub count: u32,
}

shown_as_it_is! { FrameRate }
debug_numbers! { FrameTimes { start, rate, count } }

impl FrameTimes {
    /// The frames from `start`, which is a frame, to the last one that is not later than `end`.
    ///
    /// `None` if `end` is before `start`, or more than 2^32 - 2 frames later, or if one of them is NaN.
    #[must_use]
    pub fn within(start: f64, end: f64, rate: FrameRate) -> Option<Self> {
        let frames = Self { start, rate, count: 0 };
        // Because of rounding, it may be one frame too many or too few.
        let near = frames.near(end)?;
        let last = [near.checked_add(1), Some(near), near.checked_sub(1)]
            .into_iter()
            .flatten()
            .find(|&frame| frames.time(frame) <= end)?;
        Some(Self { count: last.checked_add(1)?, ..frames })
    }

    /// The frames from `start`, which is a frame, to the first one that is not earlier than `end`. A move that must
    /// reach its end needs these frames.
    ///
    /// `None` as for [`within`](Self::within).
    #[must_use]
    pub fn covering(start: f64, end: f64, rate: FrameRate) -> Option<Self> {
        let frames = Self::within(start, end, rate)?;
        let last = frames.count.saturating_sub(1);
        if frames.time(last) < end {
            Some(Self { count: frames.count.checked_add(1)?, ..frames })
        } else {
            Some(frames)
        }
    }

    /// The last frame before a time, or the one before or after that.
    fn near(&self, time: f64) -> Option<u32> {
        let frame = (time - self.start) * self.rate.to_f64();
        // With these comparisons, NaN is outside.
        if !(time >= self.start && frame <= f64::from(u32::MAX)) {
            return None;
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to the greatest u32")]
        Some(frame as u32)
    }

    /// Time of a frame, in seconds; also of a frame after the last one.
    #[must_use]
    pub fn time(&self, frame: u32) -> f64 {
        self.start + self.rate.seconds(frame)
    }

    /// Times of all frames in order, in seconds.
    #[must_use]
    pub fn times(&self) -> impl ExactSizeIterator<Item = f64> + DoubleEndedIterator + Clone + use<> {
        let frames = *self;
        (0..frames.count).map(move |frame| frames.time(frame))
    }

    /// Writes the times of the frames from `first` on, up to the length of the slice, and returns their number.
    pub fn fill(&self, first: u32, out: &mut [f64]) -> usize {
        let left = self.count.saturating_sub(first);
        (first..first.saturating_add(left)).zip(out).map(|(frame, slot)| *slot = self.time(frame)).count()
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn text_is_read_exactly_and_printed_again() {
        for (text, fraction) in [
            ("24", (24, 1)),
            ("23.976", (2997, 125)),
            ("24000/1001", (24_000, 1_001)),
            ("0.5", (1, 2)),
            ("50/2", (25, 1)),
        ] {
            let rate: FrameRate = text.parse().unwrap();
            assert_eq!(rate.fraction(), fraction, "{text}");
            assert_eq!(rate.to_string().parse(), Ok(rate));
        }
        for (text, error) in [
            ("0", FrameRateError::Zero),
            ("24/0", FrameRateError::Zero),
            ("0/0", FrameRateError::Zero),
            ("", FrameRateError::NotANumber),
            ("24 fps", FrameRateError::NotANumber),
            ("24/1.5", FrameRateError::NotANumber),
            ("23.9761", FrameRateError::Number(FixedError::TooFine { decimals: 3 })),
        ] {
            assert_eq!(text.parse::<FrameRate>(), Err(error), "{text}");
        }
        assert!(matches!("-1".parse::<FrameRate>(), Err(FrameRateError::Number(FixedError::OutOfRange { .. }))));
    }

    #[test]
    fn thousandths_are_converted_exactly() {
        for raw in [1, 23_976, 24_000, 59_940, u32::MAX] {
            assert_eq!(FrameRate::try_from(Milli::from_raw(raw)).unwrap().to_milli(), Ok(Milli::from_raw(raw)));
        }
        assert!(FrameRate::new(u32::MAX, 1).unwrap().to_milli().is_err());
    }

    #[test]
    fn the_first_and_the_last_frame_are_counted() {
        let rate = FrameRate::new(24, 1).unwrap();
        let count = |end| FrameTimes::within(1.0, end, rate).map(|frames| frames.count);
        let covering = |end| FrameTimes::covering(1.0, end, rate).map(|frames| frames.count);
        assert_eq!([1.0, 1.04, 2.0, 2.01, 5.0].map(count), [1, 1, 25, 25, 97].map(Some));
        assert_eq!([1.0, 1.04, 2.0, 2.01, 5.0].map(covering), [1, 2, 25, 26, 97].map(Some));
        for end in [0.99, f64::NAN, f64::INFINITY, 1e12] {
            assert_eq!((count(end), covering(end)), (None, None), "{end}");
        }
        assert_eq!(FrameTimes::within(f64::NAN, 1.0, rate), None);
    }
}
