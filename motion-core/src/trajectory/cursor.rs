//! Evaluation of one axis at many times.

use core::fmt;

use super::Axis;
use crate::bezier::{Cursor, Motion, Segment};

/// An axis prepared for evaluation at many times. It remembers the place of the last time.
///
/// Times may come in any order. With sorted times, the search for segments costs one step for each segment, for any
/// number of times; a step backwards costs a binary search. A position differs from [`Axis::position`] by at most what
/// [`Cursor`] documents.
#[derive(Clone, Copy)]
pub struct AxisCursor<'a> {
    segments: &'a [Segment],
    index: usize,
    /// Start of the times that belong to the segment.
    from: f64,
    /// End of the times that belong to the segment, exclusive.
    until: f64,
    cursor: Cursor,
}

impl fmt::Debug for AxisCursor<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AxisCursor").field("index", &self.index).field("cursor", &self.cursor).finish_non_exhaustive()
    }
}

impl<'a> AxisCursor<'a> {
    pub(super) fn new(axis: Axis<'a>) -> Self {
        let mut new =
            Self { segments: axis.segments, index: 0, from: 0.0, until: 0.0, cursor: Cursor::new(*axis.first) };
        new.enter(0);
        new
    }

    /// Number of the segment that the last time belonged to.
    #[must_use]
    pub const fn index(&self) -> usize {
        self.index
    }

    /// Position at a time, as from [`Axis::position`].
    pub fn position(&mut self, time: f64) -> f64 {
        self.seek(time);
        self.cursor.position(time)
    }

    /// Position, velocity and acceleration at a time, as from [`Axis::at`].
    pub fn at(&mut self, time: f64) -> Motion {
        self.seek(time);
        self.cursor.at(time)
    }

    /// Writes the position at each time, up to the length of the shorter slice.
    pub fn sample(&mut self, times: &[f64], out: &mut [f64]) {
        self.batch(times, out, Cursor::sample);
    }

    /// Writes position, velocity and acceleration at each time, up to the length of the shorter slice.
    pub fn sample_motion(&mut self, times: &[f64], out: &mut [Motion]) {
        self.batch(times, out, Cursor::sample_motion);
    }

    /// Evaluates each run of times on the same segment at once.
    fn batch<T>(&mut self, times: &[f64], mut out: &mut [T], sample: impl Fn(&mut Cursor, &[f64], &mut [T])) {
        let mut times = times.get(..out.len()).unwrap_or(times);
        while let Some(&first) = times.first() {
            self.seek(first);
            let run = times.iter().take_while(|&&time| self.holds(time)).count().max(1);
            let Some((now, later)) = times.split_at_checked(run) else { break };
            let Some((room, rest)) = core::mem::take(&mut out).split_at_mut_checked(run) else { break };
            sample(&mut self.cursor, now, room);
            (times, out) = (later, rest);
        }
    }

    fn holds(&self, time: f64) -> bool {
        self.from <= time && time < self.until
    }

    fn seek(&mut self, time: f64) {
        if self.holds(time) {
            return;
        }
        let started = |segment: &Segment| segment.start() <= time;
        let index = if time >= self.until {
            // The width doubles each time, so that the cost grows with the logarithm of the distance.
            let ahead = self.segments.get(self.index..).unwrap_or_default();
            let mut width = 2_usize;
            while ahead.get(width).is_some_and(started) {
                width = width.saturating_mul(2);
            }
            let near = ahead.get(..width).unwrap_or(ahead);
            self.index.saturating_add(near.partition_point(started).saturating_sub(1))
        } else {
            self.segments.partition_point(started).saturating_sub(1)
        };
        if index != self.index {
            self.enter(index);
        }
    }

    fn enter(&mut self, index: usize) {
        let Some(segment) = self.segments.get(index) else { return };
        self.index = index;
        self.from = if index == 0 { f64::NEG_INFINITY } else { segment.start() };
        self.until = self.segments.get(index.saturating_add(1)).map_or(f64::INFINITY, Segment::start);
        self.cursor = Cursor::new(*segment);
    }
}
