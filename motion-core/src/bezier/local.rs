//! Both coordinates of a segment, measured from a point of the curve, and the quick solution of the time polynomial.

use super::cubic::{Cubic, STEEP};
use super::{Motion, Segment};

/// Both coordinates, measured from the point at one curve parameter.
#[derive(Clone, Copy)]
pub(super) struct Local {
    /// Curve parameter of the point.
    u: f64,
    /// Time of the point, after the start of the segment.
    pub(super) passed: f64,
    /// Position of the point.
    origin: f64,
    pub(super) time: Cubic,
    position: Cubic,
}

impl Local {
    /// The coordinates from the point in the middle, where the steps to all others are at most one half.
    ///
    /// So the terms of the polynomials are smaller than from an end point, and rounding costs half as much.
    pub(super) fn middle(segment: &Segment) -> Self {
        let [first, ahead @ ..] = segment.points();
        let (time, passed) = Cubic::middle(ahead.map(|point| point.time - first.time));
        let (position, rise) = Cubic::middle(ahead.map(|point| point.position - first.position));
        Self { u: 0.5, passed, origin: first.position + rise, time, position }
    }

    /// The coordinates from another point, a step away.
    #[inline]
    pub(super) fn moved(&self, step: f64) -> Self {
        Self {
            u: self.parameter(step),
            passed: self.passed + self.time.value(step),
            origin: self.position(step),
            time: self.time.moved(step),
            position: self.position.moved(step),
        }
    }

    /// The curve parameter a step away.
    #[inline]
    pub(super) fn parameter(&self, step: f64) -> f64 {
        self.u + step
    }

    #[inline]
    pub(super) fn position(&self, step: f64) -> f64 {
        self.origin + self.position.value(step)
    }

    /// Position, velocity and acceleration, only where time does not run slowly, so that all rates are finite.
    #[inline]
    pub(super) fn motion(&self, step: f64) -> Motion {
        let [_, slope, bend] = self.time.derivatives(step);
        let [height, rise, curl] = self.position.derivatives(step);
        let inverse = 1.0 / slope;
        let velocity = rise * inverse;
        let acceleration = 2.0 * (curl - velocity * bend) * (inverse * inverse);
        Motion { position: self.origin + height, velocity: Some(velocity), acceleration: Some(acceleration) }
    }
}

/// The coordinates from the middle, with what decides whether a time can be solved from there.
#[derive(Clone, Copy)]
pub(super) struct Middle {
    pub(super) local: Local,
    /// Time from start to end.
    pub(super) whole: f64,
    /// Least slope of time from which on `f64` is exact enough; infinite if no time can be solved from the middle,
    /// because the duration is 0 or time may fold.
    pub(super) least: f64,
}

impl Middle {
    pub(super) fn new(segment: &Segment) -> Self {
        let whole = segment.duration();
        let smooth = whole > 0.0 && segment.ordered();
        Self { local: Local::middle(segment), whole, least: if smooth { STEEP * whole } else { f64::INFINITY } }
    }

    /// Solves a time after the start without a first guess. The result is a step from the middle.
    #[inline]
    pub(super) fn solve(&self, after: f64) -> Option<f64> {
        self.refine::<3>(after / self.whole - 0.5, after)
    }

    /// Improves a step from the middle, until it belongs to a time after the start.
    ///
    /// Takes a number of steps of Halley's method, and a few more if the last one was long. A loop that ended at the
    /// first short step would be slower, because processors cannot predict that end. The result counts only if the last
    /// step was short, and time does not run slowly. The error after a step is the cube of the step times the square of
    /// `bend / slope`, which is at most 1e4 here. `None` close to the ends, where results must be exact.
    #[inline]
    pub(super) fn refine<const STEPS: usize>(&self, mut u: f64, after: f64) -> Option<f64> {
        const MORE: usize = 3;
        const SHORT: f64 = 1e-7;
        const INSIDE: f64 = 0.5 - 1e-9;
        let ahead = after - self.local.passed;
        let (mut step, mut slope) = (0.0, 0.0);
        for _ in 0..STEPS {
            (step, slope) = self.local.time.halley(u, ahead);
            u -= step;
        }
        for _ in 0..MORE {
            if step.abs() <= SHORT {
                break;
            }
            (step, slope) = self.local.time.halley(u, ahead);
            u -= step;
        }
        (step.abs() <= SHORT && slope >= self.least && u.abs() <= INSIDE).then_some(u)
    }
}
