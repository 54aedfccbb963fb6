//! Positions in whole steps of a motor.

use super::{Axis, FrameTimes};
use crate::bezier::print::{Number, debug_as_text, debug_numbers};

/// Scale from positions to steps: `position * per_unit + offset`, rounded to the nearest whole step. Halves are rounded
/// away from zero.
#[derive(Clone, Copy, PartialEq)]
pub struct StepScale {
    per_unit: f64,
    offset: f64,
}

debug_numbers! { StepScale { per_unit, offset } }

/// Error: the steps per unit are NaN, infinite or 0, or the offset is NaN or infinite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[error("steps: steps per unit and offset must be finite, and steps per unit not 0")]
pub struct ScaleError;

/// Error: a position in steps is NaN or does not fit 32 bits.
#[derive(Clone, Copy, PartialEq, thiserror::Error)]
#[error("steps: {} do not fit 32 bits", Number(*.steps))]
pub struct StepsOutOfRange {
    /// Number of steps, not rounded.
    pub steps: f64,
}

/// Error: the position at a frame, in steps, does not fit 32 bits.
#[derive(Clone, Copy, PartialEq, thiserror::Error)]
#[error("steps: {} at {} s, frame {frame}, do not fit 32 bits", Number(*.steps), Number(*.time))]
pub struct StepsError {
    /// Number of the frame, from 0.
    pub frame: u32,
    /// Time of the frame, in seconds.
    pub time: f64,
    /// Number of steps, not rounded.
    pub steps: f64,
}

debug_as_text! { StepsOutOfRange StepsError }

impl StepScale {
    /// A scale from the number of steps per unit, and the number of steps at position 0.
    ///
    /// The steps per unit are negative for a motor that runs against its axis.
    ///
    /// # Errors
    ///
    /// [`ScaleError`] if a number is not finite, or the steps per unit are 0.
    pub fn new(per_unit: f64, offset: f64) -> Result<Self, ScaleError> {
        if per_unit.is_finite() && per_unit != 0.0 && offset.is_finite() {
            Ok(Self { per_unit, offset })
        } else {
            Err(ScaleError)
        }
    }

    /// Steps per unit; negative if the motor runs against the axis.
    #[must_use]
    pub const fn per_unit(&self) -> f64 {
        self.per_unit
    }

    /// Steps at position 0.
    #[must_use]
    pub const fn offset(&self) -> f64 {
        self.offset
    }

    /// The steps at a position, rounded to the nearest whole step; halves are rounded away from zero.
    ///
    /// # Errors
    ///
    /// [`StepsOutOfRange`] if the steps do not fit 32 bits; they are never limited to fit.
    pub fn steps(&self, position: f64) -> Result<i32, StepsOutOfRange> {
        let steps = position * self.per_unit + self.offset;
        let whole = libm::round(steps);
        if f64::from(i32::MIN) <= whole && whole <= f64::from(i32::MAX) {
            #[expect(clippy::cast_possible_truncation, reason = "whole, and in range")]
            Ok(whole as i32)
        } else {
            Err(StepsOutOfRange { steps })
        }
    }

    /// The position at a number of steps.
    #[must_use]
    pub fn position(&self, steps: i32) -> f64 {
        (f64::from(steps) - self.offset) / self.per_unit
    }
}

/// Number of frames that are computed together.
const BLOCK: usize = 64;

impl<'a> Axis<'a> {
    /// Positions at all frames, in order.
    #[must_use]
    pub fn positions(&self, frames: FrameTimes) -> impl ExactSizeIterator<Item = f64> + use<'a> {
        let axis = *self;
        frames.times().map(move |time| axis.position(time))
    }

    /// Writes the positions at the frames from `first` on, up to the length of the slice, and returns their number.
    ///
    /// It is faster than [`positions`](Self::positions), and differs from it by at most what
    /// [`AxisCursor`](super::AxisCursor) documents.
    pub fn sample_frames(&self, frames: FrameTimes, first: u32, out: &mut [f64]) -> usize {
        let mut cursor = self.cursor();
        let mut written = 0_usize;
        for (room, block) in out.chunks_mut(BLOCK).zip((first..frames.count).step_by(BLOCK)) {
            let mut times = [0.0; BLOCK];
            let count = frames.fill(block, &mut times).min(room.len());
            cursor.sample(times.get(..count).unwrap_or_default(), room);
            written = written.saturating_add(count);
        }
        written
    }

    /// Steps at a frame.
    ///
    /// They depend on nothing else, so repeated calls, in any order, return the same steps.
    ///
    /// # Errors
    ///
    /// [`StepsError`] if the steps do not fit 32 bits.
    pub fn steps_at(&self, frames: FrameTimes, frame: u32, scale: StepScale) -> Result<i32, StepsError> {
        let time = frames.time(frame);
        scale.steps(self.position(time)).map_err(|StepsOutOfRange { steps }| StepsError { frame, time, steps })
    }

    /// Steps at all frames, in order.
    #[must_use]
    pub fn steps(
        &self,
        frames: FrameTimes,
        scale: StepScale,
    ) -> impl ExactSizeIterator<Item = Result<i32, StepsError>> + use<'a> {
        let axis = *self;
        (0..frames.count).map(move |frame| axis.steps_at(frames, frame, scale))
    }

    /// Writes the steps at the frames from `first` on, up to the length of the slice, and returns their number.
    ///
    /// # Errors
    ///
    /// [`StepsError`] for the first frame whose steps do not fit; the steps of the frames before it are written.
    pub fn sample_steps(
        &self,
        frames: FrameTimes,
        first: u32,
        scale: StepScale,
        out: &mut [i32],
    ) -> Result<usize, StepsError> {
        let mut written = 0_usize;
        for (slot, frame) in out.iter_mut().zip(first..frames.count) {
            *slot = self.steps_at(frames, frame, scale)?;
            written = written.saturating_add(1);
        }
        Ok(written)
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "what is exact is compared exactly")]
mod tests {
    use std::string::ToString;

    use super::*;
    use crate::bezier::{Ease, Key, Segment};
    use crate::trajectory::FrameRate;

    #[test]
    fn positions_are_rounded_to_the_nearest_step_and_halves_away_from_zero() {
        let scale = StepScale::new(-10.0, 2.0).unwrap();
        let positions = [0.0, 0.04, 0.05, -0.05, 0.25, 0.35];
        // 2, 1.6, 1.5, 2.5, -0.5 and -1.5 steps.
        assert_eq!(positions.map(|position| scale.steps(position)), [2, 2, 2, 3, -1, -2].map(Ok));
        assert_eq!(scale.position(-8), 1.0);
    }

    #[test]
    fn steps_are_never_limited_to_fit() {
        let scale = StepScale::new(1.0, 0.0).unwrap();
        let (least, most) = (f64::from(i32::MIN), f64::from(i32::MAX));
        assert_eq!((scale.steps(least - 0.25), scale.steps(most + 0.25)), (Ok(i32::MIN), Ok(i32::MAX)));
        for steps in [least - 0.5, most + 0.5, 1e300] {
            assert_eq!(scale.steps(steps), Err(StepsOutOfRange { steps }));
        }
        assert!(scale.steps(f64::NAN).is_err());
        for (per_unit, offset) in [(0.0, 0.0), (f64::NAN, 0.0), (f64::INFINITY, 0.0), (1.0, f64::NAN)] {
            assert_eq!(StepScale::new(per_unit, offset), Err(ScaleError));
        }
    }

    #[test]
    fn the_error_names_the_first_frame_that_does_not_fit() {
        let key = |time, position| Key { time, position, arrive: Ease::Linear, leave: Ease::Linear };
        let segments = [Segment::between(&key(0.0, 0.0), &key(100.0, 4e9)).unwrap()];
        let axis = Axis::new(&segments, "mm").unwrap();
        let frames = FrameTimes::within(0.0, 100.0, FrameRate::new(1, 1).unwrap()).unwrap();
        let (scale, mut out) = (StepScale::new(1.0, 0.0).unwrap(), [-1; 101]);
        let error = axis.sample_steps(frames, 0, scale, &mut out).unwrap_err();
        assert_eq!((error.frame, error.time), (54, 54.0));
        assert!((error.steps - 2.16e9).abs() < 1e-3, "{error}");
        assert_eq!(
            StepsError { steps: 2.16e9, ..error }.to_string(),
            "steps: 2160000000.0 at 54.0 s, frame 54, do not fit 32 bits"
        );
        assert_eq!(out[53..55], [2_120_000_000, -1]);
        assert_eq!(axis.steps(frames, scale).find_map(Result::err), Some(error));
    }
}
