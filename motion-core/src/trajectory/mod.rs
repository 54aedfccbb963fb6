//! Axes of a move: Bezier segments in the order of time, in physical units, sampled by time or by frame.
//!
//! ```
//! use motion_core::bezier::{Ease, Key, Segment};
//! use motion_core::trajectory::{Axis, FrameRate, FrameTimes, StepScale, Tolerance};
//!
//! // 90 degrees in 4 seconds, a second of rest, and back in 3.
//! let (flat, straight) = (Ease::Flat(0.4), Ease::Linear);
//! let key = |time, position| Key { time, position, arrive: flat, leave: flat };
//! let segments = [
//!     Segment::between(&key(0.0, 0.0), &key(4.0, 90.0))?,
//!     Segment::between(&key(5.0, 90.0), &Key { arrive: straight, ..key(8.0, 0.0) })?,
//! ];
//! let pan = Axis::new(&segments, "degrees")?;
//! assert_eq!(pan.position(4.5), 90.0);
//!
//! // The greatest speed, and the segment that has it.
//! let fastest = pan.peak_velocity();
//! assert_eq!(fastest.segment, 1);
//! assert!(fastest.value.is_some_and(|value| (40.0..50.0).contains(&value)));
//!
//! // Steps for a rig with 100 steps per degree, at 23.976 frames per second.
//! let rate: FrameRate = "24000/1001".parse()?;
//! let frames = FrameTimes::covering(pan.start(), pan.end(), rate).expect("some thousand frames at most");
//! let scale = StepScale::new(100.0, 0.0)?;
//! let steps: Result<Vec<i32>, _> = pan.steps(frames, scale).collect();
//! assert_eq!(steps?[96..120], [9000; 24]);
//!
//! // Joints are reported for the gap between the segments, and for the end, where it does not come to rest.
//! let joints: Vec<_> = pan.joints(Tolerance::all(1e-4)).collect();
//! assert_eq!((joints[0].index, joints[0].gap), (1, 1.0));
//! assert_eq!((joints[1].index, joints[1].time), (2, 8.0));
//! assert!(joints[1].velocity.is_some_and(|jump| jump > 29.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Guarantees
//!
//! - Positions are those of the segments. Between two segments, the axis rests at the end of the first one. Before all
//!   segments it rests at their start, and after all segments at their end.
//! - At the time where two segments meet, the later one counts.
//! - Frame `n` is at `start + n / rate`, computed from `n` alone: errors do not add up.
//! - A position that does not fit into steps is an error; it is never changed to fit.

mod cursor;
mod distance;
mod joints;
mod range;
mod rate;
mod steps;

use core::fmt;

use crate::bezier::print::{Number, debug_as_text, debug_numbers};
use crate::bezier::{Motion, Segment};

pub use cursor::AxisCursor;
pub use distance::Distance;
pub use joints::{Joint, Tolerance};
pub use range::{Map, MapError, Range};
pub use rate::{FrameRate, FrameRateError, FrameTimes};
pub use steps::{ScaleError, StepScale, StepsError, StepsOutOfRange};

/// Why segments cannot form an axis.
#[derive(Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AxisError {
    /// There are no segments.
    #[error("axis: no segments")]
    Empty,
    /// A segment ends before it starts.
    #[error("axis: segment {segment} ends at {}, before it starts at {}", Number(*.end), Number(*.start))]
    Backwards {
        /// Number of the segment, from 0.
        segment: usize,
        /// Start of the segment, in seconds.
        start: f64,
        /// End of the segment, in seconds.
        end: f64,
    },
    /// A segment starts before the previous one ends.
    #[error("axis: segment {segment} starts at {}, the previous one ends {} later", Number(*.start), Number(*.by))]
    Overlap {
        /// Number of the segment, from 0.
        segment: usize,
        /// Start of the segment, in seconds.
        start: f64,
        /// Time from this start to the end of the previous segment, in seconds.
        by: f64,
    },
}

debug_as_text! { AxisError }

/// Greatest rate of an axis, and the segment that has it.
#[derive(Clone, Copy, PartialEq)]
pub struct Peak {
    /// Number of the segment, from 0; the first one if several have the rate.
    pub segment: usize,
    /// The rate without a sign, in units per second or per second squared; `None` if it has no limit, as at a vertical
    /// tangent.
    pub value: Option<f64>,
}

debug_numbers! { Peak { segment, value } }

/// Axis of a move: segments in the order of time, with the unit of their positions. Times are in seconds.
///
/// It borrows the segments: nothing is copied or allocated.
#[derive(Clone, Copy, PartialEq)]
pub struct Axis<'a> {
    segments: &'a [Segment],
    /// The first and the last segment, which exist because the slice is not empty.
    first: &'a Segment,
    last: &'a Segment,
    unit: &'a str,
}

// The unit is left out, because core would escape its text with code that cannot be proven free of panics.
impl fmt::Debug for Axis<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Axis").field("segments", &self.segments).finish_non_exhaustive()
    }
}

impl<'a> Axis<'a> {
    /// An axis of segments that do not overlap; `unit` is a label.
    ///
    /// # Errors
    ///
    /// [`AxisError`] if there are no segments, or if time goes backwards within or between segments.
    pub fn new(segments: &'a [Segment], unit: &'a str) -> Result<Self, AxisError> {
        Self::overlapping(segments, unit, 0.0)
    }

    /// An axis of segments that may overlap slightly, as after a conversion of number formats.
    ///
    /// A segment may start before the previous one ends, by at most `overlap` seconds; then it cuts off the end of the
    /// previous one.
    ///
    /// # Errors
    ///
    /// [`AxisError`] as for [`new`](Self::new), and also if a segment starts before the previous one starts, or ends
    /// before the previous one ends.
    pub fn overlapping(segments: &'a [Segment], unit: &'a str, overlap: f64) -> Result<Self, AxisError> {
        let (Some(first), Some(last)) = (segments.first(), segments.last()) else {
            return Err(AxisError::Empty);
        };
        let mut before = first;
        for (index, segment) in segments.iter().enumerate() {
            let (start, end) = (segment.start(), segment.end());
            if end < start {
                return Err(AxisError::Backwards { segment: index, start, end });
            }
            let by = before.end() - start;
            let in_order = by <= overlap && before.start() <= start && before.end() <= end;
            if index > 0 && by > 0.0 && !in_order {
                return Err(AxisError::Overlap { segment: index, start, by });
            }
            before = segment;
        }
        Ok(Self { segments, first, last, unit })
    }

    /// The segments of the axis, at least one.
    #[must_use]
    pub const fn segments(&self) -> &'a [Segment] {
        self.segments
    }

    /// The unit of the positions, as given to [`new`](Self::new).
    #[must_use]
    pub const fn unit(&self) -> &'a str {
        self.unit
    }

    /// Start of the first segment, in seconds.
    #[must_use]
    pub const fn start(&self) -> f64 {
        self.first.start()
    }

    /// End of the last segment, in seconds.
    #[must_use]
    pub const fn end(&self) -> f64 {
        self.last.end()
    }

    /// Time from start to end, in seconds.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.end() - self.start()
    }

    /// Position at a time, as from [`Segment::position`]. The segment is found by binary search.
    #[must_use]
    pub fn position(&self, time: f64) -> f64 {
        self.segment_at(time).position(time)
    }

    /// Position, velocity and acceleration at a time, as from [`Segment::at`]; at rest outside the segments.
    #[must_use]
    pub fn at(&self, time: f64) -> Motion {
        self.segment_at(time).at(time)
    }

    /// Number of the segment that counts at a time: the last one that has started, or the first one.
    #[must_use]
    pub fn index(&self, time: f64) -> usize {
        self.segments.partition_point(|segment| segment.start() <= time).saturating_sub(1)
    }

    fn segment_at(&self, time: f64) -> &'a Segment {
        self.segments.get(self.index(time)).unwrap_or(self.first)
    }

    /// A cursor for evaluation at many times, which is faster if the times are close to each other.
    #[must_use]
    pub fn cursor(&self) -> AxisCursor<'a> {
        AxisCursor::new(*self)
    }

    /// Writes the position at each time, up to the length of the shorter slice.
    pub fn sample(&self, times: &[f64], out: &mut [f64]) {
        self.cursor().sample(times, out);
    }

    /// Writes position, velocity and acceleration at each time, up to the length of the shorter slice.
    pub fn sample_motion(&self, times: &[f64], out: &mut [Motion]) {
        self.cursor().sample_motion(times, out);
    }

    /// The range from the least position to the greatest, as from [`Segment::range`].
    #[must_use]
    pub fn range(&self) -> Range {
        let none = Range { from: f64::INFINITY, to: f64::NEG_INFINITY };
        self.segments
            .iter()
            .map(Segment::range)
            .fold(none, |range, (least, greatest)| Range { from: range.from.min(least), to: range.to.max(greatest) })
    }

    /// The greatest speed within segments. [`joints`](Self::joints) finds jumps between segments and at the ends.
    #[must_use]
    pub fn peak_velocity(&self) -> Peak {
        self.peak(Segment::peak_velocity)
    }

    /// The greatest acceleration within segments, in either direction. At the jumps of velocity that
    /// [`joints`](Self::joints) finds, it has no limit.
    #[must_use]
    pub fn peak_acceleration(&self) -> Peak {
        self.peak(Segment::peak_acceleration)
    }

    fn peak(&self, rate: impl Fn(&Segment) -> Option<f64>) -> Peak {
        let mut peak = Peak { segment: 0, value: Some(0.0) };
        for (segment, value) in self.segments.iter().map(rate).enumerate() {
            match (value, peak.value) {
                (None, _) => return Peak { segment, value },
                (Some(rate), Some(most)) if rate > most => peak = Peak { segment, value },
                _ => {}
            }
        }
        peak
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "what is exact is compared exactly")]
mod tests {
    use std::string::ToString;

    use super::*;
    use crate::bezier::Point;

    /// A segment that stays at one position, with handles at its ends.
    fn segment(start: f64, end: f64, position: f64) -> Segment {
        Segment::new([start, start, end, end].map(|time| Point::new(time, position))).unwrap()
    }

    #[test]
    fn time_must_not_go_backwards() {
        assert_eq!(Axis::new(&[], "m"), Err(AxisError::Empty));
        let backwards = [segment(0.0, 1.0, 0.0), segment(2.0, 1.5, 0.0)];
        let error = Axis::new(&backwards, "m").unwrap_err();
        assert_eq!(error, AxisError::Backwards { segment: 1, start: 2.0, end: 1.5 });
        assert_eq!(error.to_string(), "axis: segment 1 ends at 1.5, before it starts at 2.0");
        let overlap = [segment(0.0, 1.0, 0.0), segment(0.75, 2.0, 0.0)];
        let error = Axis::new(&overlap, "m").unwrap_err();
        assert_eq!(error, AxisError::Overlap { segment: 1, start: 0.75, by: 0.25 });
        assert_eq!(error.to_string(), "axis: segment 1 starts at 0.75, the previous one ends 0.25 later");
    }

    #[test]
    fn an_overlap_cuts_the_earlier_segment() {
        let overlap = [segment(0.0, 1.0, 1.0), segment(0.75, 2.0, 2.0)];
        assert!(Axis::overlapping(&overlap, "", 0.24).is_err() && Axis::overlapping(&overlap, "", f64::NAN).is_err());
        let axis = Axis::overlapping(&overlap, "", 0.25).unwrap();
        assert_eq!([0.7, 0.75, 0.9].map(|time| axis.position(time)), [1.0, 2.0, 2.0]);
        // Even then, a segment may not be inside another one, or start before it.
        for (start, end) in [(0.5, 0.9), (-0.1, 1.1)] {
            assert!(Axis::overlapping(&[segment(0.0, 1.0, 1.0), segment(start, end, 2.0)], "", 9.0).is_err());
        }
    }

    #[test]
    fn the_axis_rests_before_between_and_after_segments() {
        let segments = [segment(1.0, 2.0, 1.0), segment(3.0, 3.0, 5.0), segment(4.0, 5.0, 2.0)];
        let axis = Axis::new(&segments, "m").unwrap();
        assert_eq!((axis.start(), axis.end(), axis.duration(), axis.unit()), (1.0, 5.0, 4.0, "m"));
        assert_eq!(axis.range(), Range::new(1.0, 5.0));
        let times = [f64::NAN, f64::NEG_INFINITY, 0.0, 2.5, 3.0, 3.5, 4.0, 6.0, f64::INFINITY];
        let positions = [1.0, 1.0, 1.0, 1.0, 5.0, 5.0, 2.0, 2.0, 2.0];
        let (mut out, mut motions) = ([0.0; 9], [Motion::default(); 9]);
        axis.sample(&times, &mut out);
        axis.sample_motion(&times, &mut motions);
        assert_eq!(out, positions);
        assert_eq!(times.map(|time| axis.position(time)), positions);
        assert_eq!(motions.map(|motion| (motion.position, motion.velocity)), positions.map(|p| (p, Some(0.0))));
    }

    #[test]
    fn peaks_name_their_segment() {
        let line = |from: f64, to: f64| [from, from / 3.0 * 2.0 + to / 3.0, from / 3.0 + to / 3.0 * 2.0, to];
        let run = |start: f64, speed: f64| {
            let (times, positions) = (line(start, start + 3.0), line(0.0, 3.0 * speed));
            let mut points = [Point::ZERO; 4];
            for (point, at) in points.iter_mut().zip(times.into_iter().zip(positions)) {
                *point = Point::new(at.0, at.1);
            }
            Segment::new(points).unwrap()
        };
        let steep = Segment::new([(9.0, 0.0), (9.0, 1.0), (10.0, 1.0), (10.0, 2.0)].map(|(t, p)| Point::new(t, p)));
        let segments = [run(0.0, 1.0), run(3.0, -2.0), run(6.0, 2.0), steep.unwrap()];
        let peak = Axis::new(&segments[..3], "").unwrap().peak_velocity();
        assert!(peak.segment == 1 && (peak.value.unwrap() - 2.0).abs() < 1e-12, "{peak:?}");
        let axis = Axis::new(&segments, "").unwrap();
        assert_eq!(axis.peak_velocity(), Peak { segment: 3, value: None });
        assert_eq!(axis.peak_acceleration(), Peak { segment: 3, value: None });
    }
}
