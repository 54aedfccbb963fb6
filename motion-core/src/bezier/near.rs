//! The surroundings of one curve parameter, where a few terms of a series solve the time polynomial.

use super::local::{Local, Middle};

/// Two numbers that take the same operations, as the lanes of a vector register.
pub(super) type Pair = [f64; 2];

/// Number of pairs that are solved together.
pub(super) const PAIRS: usize = 8;

/// Both coordinates, measured from the point at one curve parameter.
///
/// All times of a batch take the same operations without a branch, in short loops over pairs, which the compiler turns
/// into two lanes. One check after the loops says for all times whether the results are good.
#[derive(Clone, Copy)]
pub(super) struct Near {
    /// Step from the middle to the point.
    at: f64,
    pub(super) local: Local,
    /// The first four derivatives of the parameter with respect to time, divided by 1, 2, 6 and 24.
    series: [f64; 4],
}

impl Near {
    #[inline]
    pub(super) fn new(middle: &Middle, at: f64) -> Self {
        let local = middle.local.moved(at);
        let time = local.time;
        let inverse = 1.0 / time.c;
        let square = inverse * inverse;
        let (bends, both) = (time.b * time.b, time.a * time.c);
        let second = -time.b * square * inverse;
        let third = (2.0 * bends - both) * (square * square) * inverse;
        let fourth = 5.0 * second * ((bends - both) * (square * square));
        Self { at, local, series: [inverse, second, third, fourth] }
    }

    /// An estimate of the step from the middle at a time after the start.
    ///
    /// A linear estimate is enough, because both coordinates are measured from the estimated parameter.
    #[inline]
    pub(super) fn guess(&self, after: f64) -> f64 {
        let [rate, ..] = self.series;
        (self.at + rate * (after - self.local.passed)).clamp(-0.5, 0.5)
    }

    /// Writes the parameters at some times, as steps from the parameter here; of a last odd time, twice.
    ///
    /// The series predicts them, and Newton's method improves them, mostly in one step. `begin` is the start time of
    /// the segment. `None` if a time is NaN, outside the segment or too far away, or if time runs slowly near it.
    #[inline]
    pub(super) fn solve(&self, times: &[f64], begin: f64, middle: &Middle, steps: &mut [Pair; PAIRS]) -> Option<()> {
        /// Number of steps that may follow the first one.
        const MORE: usize = 2;
        let (mut all, mut far) = ([[0.0; 2]; PAIRS], [0.0; 2]);
        let mut predict = |(ahead, step): (&mut Pair, &mut Pair), times: Pair| {
            *ahead = times.map(|time| (time - begin) - self.local.passed);
            *step = ahead.map(|ahead| series(self.series, ahead));
            far = zip(far, ahead.map(f64::abs), greater);
        };
        let (pairs, mut slots) = (times.chunks_exact(2), all.iter_mut().zip(&mut *steps));
        let odd = pairs.remainder();
        for (pair, slot) in pairs.zip(&mut slots) {
            if let &[one, other] = pair {
                predict(slot, [one, other]);
            }
        }
        if let (&[odd], Some(slot)) = (odd, slots.next()) {
            predict(slot, [odd; 2]);
        }
        let steps = steps.get_mut(..times.len().div_ceil(2))?;
        let mut squares = self.newton(steps, &all);
        let [even, odd] = far;
        let around = self.around(greater(even, odd), middle)?;
        for _ in 0..MORE {
            if !around.holds(squares) {
                return None;
            }
            if around.exact(squares) {
                return Some(());
            }
            squares = self.newton(steps, &all);
        }
        around.exact(squares).then_some(())
    }

    /// Takes one step of Newton's method for each time, and returns the sum of the squared residuals before it.
    ///
    /// Unlike the greatest residual, the sum is NaN if any residual is NaN.
    #[inline]
    fn newton(&self, steps: &mut [Pair], ahead: &[Pair]) -> f64 {
        let mut squares = [0.0; 2];
        for (step, &ahead) in steps.iter_mut().zip(ahead) {
            let [[value0, slope0, _], [value1, slope1, _]] = step.map(|step| self.local.time.derivatives(step));
            let off = zip([value0, value1], ahead, |value, ahead| value - ahead);
            squares = zip(squares, off, |sum, off| sum + off * off);
            *step = zip(*step, zip(off, [slope0, slope1], |off, slope| off / slope), |step, more| step - more);
        }
        let [even, odd] = squares;
        even + odd
    }

    /// Bounds of the slope of time as far as the times reach; `None` if they reach the ends, or time runs slowly.
    #[inline]
    fn around(&self, far: f64, middle: &Middle) -> Option<Around> {
        let Local { passed, time, .. } = self.local;
        let reach = series(self.series.map(f64::abs), far);
        let bend = time.b.abs() + 6.0 * time.a.abs() * reach;
        let slope = time.c - 4.0 * reach * bend;
        let inside = passed > far && passed + far < middle.whole;
        (inside && slope >= middle.least).then_some(Around { reach, bend, slope })
    }
}

/// Bounds of the slope of time, up to twice the reach of the series with its terms taken without signs.
///
/// While residuals are at most half of `reach * slope`, three steps of Newton's method stay within these bounds. Then
/// the root is within `residual / slope`, and the error after the step is at most `bend (residual / slope)² / slope`.
struct Around {
    /// Greatest distance that the series reaches.
    reach: f64,
    /// Greatest half of the second derivative.
    bend: f64,
    /// Least slope.
    slope: f64,
}

impl Around {
    /// Whether the next steps stay within the bounds, from the sum of the squared residuals.
    #[inline]
    fn holds(&self, squares: f64) -> bool {
        let off = 0.5 * self.reach * self.slope;
        squares <= off * off
    }

    /// Whether the last step was exact enough, from the sum of the squared residuals before it.
    #[inline]
    fn exact(&self, squares: f64) -> bool {
        /// Allowed error of the parameter.
        const LEFT: f64 = 1e-14;
        squares * self.bend <= LEFT * self.slope * self.slope * self.slope
    }
}

/// The greater number. It is faster than `max`, which has rules for NaN.
#[inline]
fn greater(one: f64, other: f64) -> f64 {
    if other > one { other } else { one }
}

/// A function of two numbers, applied to both lanes of two pairs.
#[inline]
fn zip([a0, a1]: Pair, [b0, b1]: Pair, join: impl Fn(f64, f64) -> f64) -> Pair {
    [join(a0, b0), join(a1, b1)]
}

#[inline]
fn series([first, second, third, fourth]: [f64; 4], ahead: f64) -> f64 {
    ahead * (first + ahead * (second + ahead * (third + ahead * fourth)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::{Point, Segment};

    /// The time x = u + u² - u³, which is less than a third away from a straight line.
    fn middle() -> Middle {
        let at = Point::new;
        let segment = [Point::ZERO, at(1.0 / 3.0, 0.0), at(1.0, 1.0), at(1.0, 1.0)];
        Middle::new(&Segment::new(segment).unwrap())
    }

    fn solve(near: &Near, times: &[f64], begin: f64) -> Option<[Pair; PAIRS]> {
        let mut steps = [[0.0; 2]; PAIRS];
        near.solve(times, begin, &middle(), &mut steps).map(|()| steps)
    }

    #[test]
    fn the_series_is_the_inverse_to_the_fourth_order() {
        let near = Near::new(&middle(), -0.25);
        let off = |step: f64| (series(near.series, near.local.time.value(step)) - step).abs();
        // Half the step has one thirty-second of the error.
        let ratio = off(0.02) / off(0.01);
        assert!((25.0..40.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn times_near_the_parameter_are_solved() {
        let near = Near::new(&middle(), -0.25);
        let right: [f64; 5] = [-0.01, -0.003, 0.0, 0.004, 0.01];
        let time = |u: f64| u + u * u - u * u * u;
        let steps = solve(&near, &right.map(|step| 10.0 + time(0.25 + step)), 10.0).unwrap();
        for (step, right) in steps.as_flattened().iter().zip(right) {
            assert!((step - right).abs() < 1e-14, "{step} {right}");
        }
        let [first, second] = steps[2];
        assert_eq!(first.to_bits(), second.to_bits());
    }

    #[test]
    fn times_that_are_far_or_not_finite_are_refused() {
        let near = Near::new(&middle(), -0.25);
        for bad in [f64::NAN, f64::INFINITY, -0.01, 0.9, 1.1] {
            assert_eq!(solve(&near, &[0.26, bad, 0.26], 0.0), None, "{bad}");
            assert_eq!(solve(&near, &[0.26, 0.26, bad], 0.0), None, "{bad}");
        }
        // Time slows down towards the end.
        let late = Near::new(&middle(), 0.49);
        assert_eq!(solve(&late, &[late.local.passed], 0.0), None);
    }
}
