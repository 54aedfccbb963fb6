//! Evaluation of one segment at many times, which is faster if the times are close to each other.

use core::fmt;

use super::local::{Local, Middle};
use super::near::{Near, PAIRS, Pair};
use super::{Motion, Place, Segment};

/// A segment prepared for evaluation at many times. It remembers the place of the last time.
///
/// Times may come in any order. Sorted times close to each other are fast: sixteen of them are solved together if they
/// span at most a few hundredths of the segment. A position differs from [`Segment::position`] by at most 1e-13 of the
/// largest coordinate of a control point, and not at all where time runs slowly along the curve. Rates have the errors
/// of [`Segment::at`].
#[derive(Clone, Copy)]
pub struct Cursor {
    segment: Segment,
    middle: Middle,
    /// The surroundings of the last times.
    near: Near,
}

impl Cursor {
    /// A cursor at the first end point.
    #[must_use]
    pub fn new(segment: Segment) -> Self {
        let middle = Middle::new(&segment);
        Self { segment, middle, near: Near::new(&middle, -0.5) }
    }

    /// The segment that is evaluated.
    #[must_use]
    pub fn segment(&self) -> &Segment {
        &self.segment
    }

    /// Position at a time, as from [`Segment::position`].
    pub fn position(&mut self, time: f64) -> f64 {
        let mut position = [0.0];
        self.sample(&[time], &mut position);
        let [position] = position;
        position
    }

    /// Position, velocity and acceleration at a time, as from [`Segment::at`].
    pub fn at(&mut self, time: f64) -> Motion {
        let mut motion = [Motion::default()];
        self.sample_motion(&[time], &mut motion);
        let [motion] = motion;
        motion
    }

    /// Writes the position at each time, up to the length of the shorter slice.
    pub fn sample(&mut self, times: &[f64], out: &mut [f64]) {
        self.batch(times, out, Local::position, Place::position);
    }

    /// Writes position, velocity and acceleration at each time, up to the length of the shorter slice.
    pub fn sample_motion(&mut self, times: &[f64], out: &mut [Motion]) {
        self.batch(times, out, Local::motion, Place::motion);
    }

    #[inline]
    fn batch<T>(
        &mut self,
        times: &[f64],
        out: &mut [T],
        quick: impl Fn(&Local, f64) -> T,
        exact: impl Fn(&Place) -> T,
    ) {
        let count = times.len().min(out.len());
        let (Some(times), Some(out)) = (times.get(..count), out.get_mut(..count)) else { return };
        for (times, out) in times.chunks(2 * PAIRS).zip(out.chunks_mut(2 * PAIRS)) {
            let mut steps = [[0.0; 2]; PAIRS];
            if let Some(local) = self.together(times, &mut steps) {
                out.iter_mut().zip(steps.as_flattened()).for_each(|(slot, &step)| *slot = quick(&local, step));
            } else {
                self.alone(times, out, &quick, &exact);
            }
        }
    }

    /// All times at once: the new surroundings, and the steps from there.
    ///
    /// `None` if the times are too far from each other, or time runs slowly along the curve.
    #[inline]
    fn together(&mut self, times: &[f64], steps: &mut [Pair; PAIRS]) -> Option<Local> {
        let (Some(first), Some(last), true) = (times.first(), times.last(), self.middle.least.is_finite()) else {
            return None;
        };
        let begin = self.segment.start();
        let near = Near::new(&self.middle, self.near.guess(0.5 * (first + last) - begin));
        self.near = near;
        near.solve(times, begin, &self.middle, steps).map(|()| near.local)
    }

    /// The single times one by one, after which the cursor is at the last one.
    #[cold]
    fn alone<T>(
        &mut self,
        times: &[f64],
        out: &mut [T],
        quick: impl Fn(&Local, f64) -> T,
        exact: impl Fn(&Place) -> T,
    ) {
        let mut at = 0.0;
        for (slot, &time) in out.iter_mut().zip(times) {
            (at, *slot) = self.segment.locate(
                time,
                |middle, step| (step, quick(middle, step)),
                |place| (place.parameter() - 0.5, exact(place)),
            );
        }
        self.near = Near::new(&self.middle, at);
    }
}

impl fmt::Debug for Cursor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Cursor").field("segment", &self.segment).finish_non_exhaustive()
    }
}
