//! Many times on one segment, the nearer to each other the faster.

use super::cubic::STEEP;
use super::view::View;
use super::{Motion, Segment};

/// How many times are solved together.
const LANES: usize = 16;

/// A segment made ready for many times, which remembers where the last one was.
///
/// Any order of times is right; times in order, close to each other, are fast. A position differs
/// from [`Segment::position`] by at most 1e-13 of the largest coordinate of a control point, where
/// time runs well, and not at all elsewhere.
#[derive(Clone, Copy, Debug)]
pub struct Cursor {
    segment: Segment,
    start: View,
    /// Whether predictions are of use: time has a length and does not fold.
    smooth: bool,
    /// The curve parameter of the last time.
    u: f64,
}

impl Cursor {
    /// Starts at the first end point.
    #[must_use]
    pub fn new(segment: Segment) -> Self {
        let start = View::from_start(&segment);
        Self { segment, start, smooth: segment.duration() > 0.0 && start.clock.ordered(), u: 0.0 }
    }

    /// The segment.
    #[must_use]
    pub fn segment(&self) -> &Segment {
        &self.segment
    }

    /// The position at a time, as [`Segment::position`] has it.
    pub fn position(&mut self, time: f64) -> f64 {
        let mut position = [0.0];
        self.sample(&[time], &mut position);
        let [position] = position;
        position
    }

    /// Position, velocity and acceleration at a time, as [`Segment::at`] has them.
    pub fn at(&mut self, time: f64) -> Motion {
        match self.lanes(&[time]) {
            Some([u]) => self.start.motion(u),
            None => self.alone(time, Segment::at),
        }
    }

    /// Writes the position at each time, as many as the shorter slice holds.
    pub fn sample(&mut self, times: &[f64], out: &mut [f64]) {
        self.batch(times, out, |view, u| view.origin + view.position.value(u), Segment::position);
    }

    /// Writes position, velocity and acceleration at each time, as many as the shorter slice holds.
    pub fn sample_motion(&mut self, times: &[f64], out: &mut [Motion]) {
        self.batch(times, out, View::motion, Segment::at);
    }

    #[inline]
    fn batch<T>(
        &mut self,
        times: &[f64],
        out: &mut [T],
        quick: impl Fn(&View, f64) -> T,
        exact: impl Fn(&Segment, f64) -> T,
    ) {
        let count = times.len().min(out.len());
        let (Some(mut times), Some(out)) = (times.get(..count), out.get_mut(..count)) else { return };
        let mut chunks = out.chunks_exact_mut(LANES);
        for room in &mut chunks {
            let Some((lanes, rest)) = times.split_first_chunk::<LANES>() else { break };
            match self.lanes(lanes) {
                Some(us) => room.iter_mut().zip(us).for_each(|(slot, u)| *slot = quick(&self.start, u)),
                None => room.iter_mut().zip(lanes).for_each(|(slot, &time)| *slot = self.alone(time, &exact)),
            }
            times = rest;
        }
        for (slot, time) in chunks.into_remainder().iter_mut().zip(times) {
            *slot = match self.lanes(&[*time]) {
                Some([u]) => quick(&self.start, u),
                None => self.alone(*time, &exact),
            };
        }
    }

    /// The exact way; the cursor then stands at that time.
    #[cold]
    fn alone<T>(&mut self, time: f64, exact: impl Fn(&Segment, f64) -> T) -> T {
        self.u = self.segment.parameter(time);
        exact(&self.segment, time)
    }

    /// The parameters of the times: predicted from the last one, then two Newton steps each.
    ///
    /// `None` if any is too far away, outside, or where time runs slowly.
    #[inline]
    fn lanes<const N: usize>(&mut self, times: &[f64; N]) -> Option<[f64; N]> {
        /// What the last Newton step may leave as error of the parameter.
        const LEFT: f64 = 1e-16;
        if !self.smooth {
            return None;
        }
        let (clock, u) = (&self.start.clock.cubic, self.u);
        let (whole, begin) = (self.start.clock.whole(), self.segment.start());
        let [passed, inverse, bend] = [clock.value(u), 1.0 / clock.slope(u), clock.bend(u)];
        // The inverse function's derivatives, divided by 1, 2 and 6.
        let second = -bend * inverse * inverse * inverse;
        let third = (2.0 * bend * bend * inverse - clock.a) * inverse * inverse * inverse * inverse;
        let bound = clock.b.abs().max(clock.bend(1.0).abs());

        let mut us = [0.0; N];
        let mut good = true;
        for (slot, &time) in us.iter_mut().zip(times) {
            let after = time - begin;
            let ahead = after - passed;
            let predicted = u + ahead * (inverse + ahead * (second + ahead * third));
            let guess = predicted - (clock.value(predicted) - after) / clock.slope(predicted);
            let slope = clock.slope(guess);
            let step = (clock.value(guess) - after) / slope;
            *slot = guess - step;
            // All of them, without a branch, so that lanes stay side by side.
            let checks = [
                after > 0.0,
                after < whole,
                slope >= STEEP * whole,
                step * step * bound <= LEFT * slope,
                *slot >= 0.0,
                *slot <= 1.0,
            ];
            good = checks.into_iter().fold(good, core::ops::BitAnd::bitand);
        }
        if !good {
            return None;
        }
        if let Some(&last) = us.last() {
            self.u = last;
        }
        Some(us)
    }
}
