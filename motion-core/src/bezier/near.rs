//! The surroundings of one curve parameter, where a few terms of a series solve the time polynomial.

use super::Motion;
use super::cubic::{Cubic, STEEP};
use super::view::View;

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
    /// Curve parameter at which the surroundings are.
    u: f64,
    /// Time at the parameter, after the start of the segment.
    passed: f64,
    /// Position at the parameter.
    origin: f64,
    time: Cubic,
    position: Cubic,
    /// The first four derivatives of the parameter with respect to time, divided by 1, 2, 6 and 24.
    series: [f64; 4],
}

impl Near {
    #[inline]
    pub(super) fn new(start: &View, u: f64) -> Self {
        let (clock, height) = (&start.clock.cubic, &start.position);
        let (time, position) = (clock.moved(u), height.moved(u));
        let inverse = 1.0 / time.c;
        let square = inverse * inverse;
        let (bends, both) = (time.b * time.b, time.a * time.c);
        let second = -time.b * square * inverse;
        let third = (2.0 * bends - both) * (square * square) * inverse;
        let fourth = 5.0 * second * ((bends - both) * (square * square));
        let series = [inverse, second, third, fourth];
        Self { u, passed: clock.value(u), origin: start.position(u), time, position, series }
    }

    /// An estimate of the parameter at a time after the start, within 0 to 1.
    ///
    /// A linear estimate is enough, because both coordinates are measured from the estimated parameter.
    #[inline]
    pub(super) fn guess(&self, after: f64) -> f64 {
        let [rate, ..] = self.series;
        (self.u + rate * (after - self.passed)).clamp(0.0, 1.0)
    }

    /// The parameters at some times, as distances from the parameter here; a last odd time comes twice.
    ///
    /// The series predicts them, and Newton's method improves them, mostly in one step. `begin` is the start time of
    /// the segment, and `whole` its duration. `None` if a time is NaN, outside the segment or too far away, or if time
    /// runs slowly near it.
    #[inline]
    pub(super) fn solve(&self, times: &[f64], begin: f64, whole: f64) -> Option<[Pair; PAIRS]> {
        /// Number of steps that may follow the first one.
        const MORE: usize = 2;
        let ahead = |time: f64| (time - begin) - self.passed;
        let (mut all, mut steps, mut far) = ([[0.0; 2]; PAIRS], [[0.0; 2]; PAIRS], [0.0; 2]);
        let pairs = times.chunks_exact(2);
        if let ([time], Some(odd)) = (pairs.remainder(), all.get_mut(times.len() / 2)) {
            *odd = [ahead(*time); 2];
        }
        for (slot, pair) in all.iter_mut().zip(pairs) {
            let Some(pair) = pair.first_chunk::<2>() else { break };
            *slot = pair.map(ahead);
        }
        let all = all.get(..times.len().div_ceil(2))?;
        for (step, ahead) in steps.iter_mut().zip(all) {
            *step = ahead.map(|ahead| series(self.series, ahead));
            far = zip(far, ahead.map(f64::abs), greater);
        }
        let mut squares = self.newton(&mut steps, all);
        let [even, odd] = far;
        let around = self.around(greater(even, odd), whole)?;
        for _ in 0..MORE {
            if !around.holds(squares) {
                return None;
            }
            if around.exact(squares) {
                return Some(steps);
            }
            squares = self.newton(&mut steps, all);
        }
        around.exact(squares).then_some(steps)
    }

    /// Takes one step of Newton's method for each time, and returns the sum of the squared residuals before it.
    ///
    /// Unlike the greatest residual, the sum is NaN if any residual is NaN.
    #[inline]
    fn newton(&self, steps: &mut [Pair], ahead: &[Pair]) -> f64 {
        let mut squares = [0.0; 2];
        for (step, &ahead) in steps.iter_mut().zip(ahead) {
            let [[value0, slope0, _], [value1, slope1, _]] = step.map(|step| self.time.derivatives(step));
            let off = zip([value0, value1], ahead, |value, ahead| value - ahead);
            squares = zip(squares, off, |sum, off| sum + off * off);
            *step = zip(*step, zip(off, [slope0, slope1], |off, slope| off / slope), |step, more| step - more);
        }
        let [even, odd] = squares;
        even + odd
    }

    /// Bounds of the slope of time as far as the times reach; `None` if they reach the ends, or time runs slowly.
    #[inline]
    fn around(&self, far: f64, whole: f64) -> Option<Around> {
        let reach = series(self.series.map(f64::abs), far);
        let bend = self.time.b.abs() + 6.0 * self.time.a.abs() * reach;
        let slope = self.time.c - 4.0 * reach * bend;
        let inside = self.passed > far && self.passed + far < whole;
        (inside && slope >= STEEP * whole).then_some(Around { reach, bend, slope })
    }

    #[inline]
    pub(super) fn position(&self, step: f64) -> f64 {
        self.origin + self.position.value(step)
    }

    /// Like [`View::motion`], but only where time does not run slowly, so that all rates are finite.
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
    fn view() -> View {
        let at = Point::new;
        let segment = [Point::ZERO, at(1.0 / 3.0, 0.0), at(1.0, 1.0), at(1.0, 1.0)];
        View::from_start(&Segment::new(segment).unwrap())
    }

    #[test]
    fn the_series_is_the_inverse_to_the_fourth_order() {
        let near = Near::new(&view(), 0.25);
        let off = |step: f64| (series(near.series, near.time.value(step)) - step).abs();
        // Half the step has one thirty-second of the error.
        let ratio = off(0.02) / off(0.01);
        assert!((25.0..40.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn times_near_the_parameter_are_solved() {
        let view = view();
        let near = Near::new(&view, 0.25);
        let right: [f64; 5] = [-0.01, -0.003, 0.0, 0.004, 0.01];
        let times = right.map(|step| 10.0 + view.clock.cubic.value(0.25 + step));
        let steps = near.solve(&times, 10.0, 1.0).unwrap();
        for (step, right) in steps.as_flattened().iter().zip(right) {
            assert!((step - right).abs() < 1e-14, "{step} {right}");
        }
    }

    #[test]
    fn times_that_are_far_or_not_finite_are_refused() {
        let near = Near::new(&view(), 0.25);
        for bad in [f64::NAN, f64::INFINITY, -0.01, 0.9, 1.1] {
            assert_eq!(near.solve(&[0.26, bad, 0.26], 0.0, 1.0), None, "{bad}");
            assert_eq!(near.solve(&[0.26, 0.26, bad], 0.0, 1.0), None, "{bad}");
        }
        // Time slows down towards the end.
        let late = Near::new(&view(), 0.99);
        assert_eq!(late.solve(&[late.passed], 0.0, 1.0), None);
    }
}
