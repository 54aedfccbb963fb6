//! Frame rates, exact, and the times of frames.

use core::fmt;
use core::str::FromStr;

use crate::bezier::print::{debug_numbers, shown_as_it_is};
use crate::fixed::{FixedError, Milli};

/// Frames a second, as a fraction: 24, 23.976 or 24000/1001, each of them exactly.
///
/// ```
/// use motion_core::fixed::Milli;
/// use motion_core::trajectory::FrameRate;
///
/// let rate: FrameRate = "24000/1001".parse()?;
/// assert_eq!(rate.seconds(24_000), 1_001.0);
/// // What DMC carries is a rate of its own: an hour later it is 3 milliseconds apart.
/// assert_eq!(rate.to_milli()?, Milli::from_raw(23_976));
/// assert_ne!(FrameRate::try_from(Milli::from_raw(23_976))?, rate);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FrameRate {
    /// This many frames, in lowest terms,
    frames: u32,
    /// in this many seconds.
    seconds: u32,
}

/// Why something is no frame rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum FrameRateError {
    /// No frames, or in no time.
    #[error("frame rate: 0, or a division by 0")]
    Zero,
    /// The text is neither a decimal number nor a fraction of two.
    #[error("frame rate: not a number such as 24, 23.976 or 24000/1001")]
    NotANumber,
    /// A decimal number is beyond what thousandths in 32 bits hold, or finer.
    #[error("frame rate: {0}")]
    Number(#[from] FixedError),
}

impl FrameRate {
    /// So many frames in so many seconds.
    ///
    /// # Errors
    ///
    /// [`FrameRateError::Zero`] if one of them is 0.
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

    /// Numerator and denominator in lowest terms: so many frames in so many seconds.
    #[must_use]
    pub const fn fraction(self) -> (u32, u32) {
        (self.frames, self.seconds)
    }

    /// Frames a second, to the nearest `f64`.
    #[must_use]
    pub fn to_f64(self) -> f64 {
        f64::from(self.frames) / f64::from(self.seconds)
    }

    /// The nearest thousandth, as DMC carries it.
    ///
    /// # Errors
    ///
    /// [`FixedError::OutOfRange`] from 4294967.296 frames a second on.
    pub fn to_milli(self) -> Result<Milli<u32>, FixedError> {
        Milli::from_f64(self.to_f64())
    }

    /// When a frame is, in seconds after frame 0; right to the last digit as long as the frame number times
    /// [`fraction`](Self::fraction)'s seconds is below 2^53.
    #[must_use]
    pub fn seconds(self, frame: u32) -> f64 {
        f64::from(frame) * f64::from(self.seconds) / f64::from(self.frames)
    }
}

impl TryFrom<Milli<u32>> for FrameRate {
    type Error = FrameRateError;

    /// Takes thousandths of a frame a second, as DMC carries them.
    fn try_from(rate: Milli<u32>) -> Result<Self, FrameRateError> {
        Self::new(rate.raw(), 1_000)
    }
}

/// Reads `24`, `23.976` or `24000/1001`.
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

/// Prints the fraction, or a whole number: what is read again as the same rate.
impl fmt::Display for FrameRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.seconds {
            1 => write!(f, "{}", self.frames),
            seconds => write!(f, "{}/{seconds}", self.frames),
        }
    }
}

/// The times of the frames of a move, the same for all its axes.
#[derive(Clone, Copy, PartialEq)]
pub struct FrameTimes {
    /// When frame 0 is, in seconds.
    pub start: f64,
    /// How many frames there are in a second.
    pub rate: FrameRate,
    /// How many frames there are, the first and the last included.
    pub count: u32,
}

shown_as_it_is! { FrameRate }
debug_numbers! { FrameTimes { start, rate, count } }

impl FrameTimes {
    /// The frames from `start`, itself one, to the last that is not later than `end`.
    ///
    /// `None` if `end` is before `start`, or more than 2^32 - 2 frames later, or one of them is not a number.
    #[must_use]
    pub fn within(start: f64, end: f64, rate: FrameRate) -> Option<Self> {
        let frames = Self { start, rate, count: 0 };
        // Rounding may have made it one too many, or too few.
        let near = frames.near(end)?;
        let last = [near.checked_add(1), Some(near), near.checked_sub(1)]
            .into_iter()
            .flatten()
            .find(|&frame| frames.time(frame) <= end)?;
        Some(Self { count: last.checked_add(1)?, ..frames })
    }

    /// The frames from `start`, itself one, to the first that is not earlier than `end`: what a move needs that must
    /// reach its end.
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

    /// The last frame before a time, or one beside it.
    fn near(&self, time: f64) -> Option<u32> {
        let frame = (time - self.start) * self.rate.to_f64();
        // Written so that what is not a number is outside.
        if !(time >= self.start && frame <= f64::from(u32::MAX)) {
            return None;
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to the greatest u32")]
        Some(frame as u32)
    }

    /// When a frame is, in seconds; one beyond the last too.
    #[must_use]
    pub fn time(&self, frame: u32) -> f64 {
        self.start + self.rate.seconds(frame)
    }

    /// The times of all frames, in order.
    #[must_use]
    pub fn times(&self) -> impl ExactSizeIterator<Item = f64> + DoubleEndedIterator + Clone + use<> {
        let frames = *self;
        (0..frames.count).map(move |frame| frames.time(frame))
    }

    /// Writes the times of the frames from `first` on, as many as there are and as the slice holds; says how many.
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
    fn thousandths_come_back() {
        for raw in [1, 23_976, 24_000, 59_940, u32::MAX] {
            assert_eq!(FrameRate::try_from(Milli::from_raw(raw)).unwrap().to_milli(), Ok(Milli::from_raw(raw)));
        }
        assert!(FrameRate::new(u32::MAX, 1).unwrap().to_milli().is_err());
    }

    #[test]
    fn first_and_last_are_counted() {
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
