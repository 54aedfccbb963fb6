//! Extreme values of position, velocity and acceleration on a segment.

use super::cubic::{Cubic, quadratic, search};
use super::view::View;
use super::{Motion, Segment};

impl Segment {
    /// The least and the greatest position, with an error of at most 1e-15 of the largest coordinate.
    ///
    /// Where time folds back, the axis skips a part of the curve; then the true range may be narrower, never wider.
    #[must_use]
    pub fn range(&self) -> (f64, f64) {
        let [first, .., last] = self.points().map(|point| point.position);
        let ends = (first.min(last), first.max(last));
        if self.duration() == 0.0 {
            return (last, last);
        }
        let view = View::from_start(self);
        let turns = view.position.turns().map(|u| if u < 1.0 { view.position(u) } else { last });
        turns.into_iter().fold(ends, |(least, most), position| (least.min(position), most.max(position)))
    }

    /// Greatest speed in either direction; `None` if it has no limit.
    ///
    /// The candidates are the ends and the roots of a quadratic, so no search is needed. The speed at a candidate is
    /// that of [`Segment::at`], with the same error.
    #[must_use]
    pub fn peak_velocity(&self) -> Option<f64> {
        let candidates = quadratic_of_acceleration(&View::from_start(self));
        let [a, b, c] = candidates;
        self.peak(&quadratic(a, b, c), |motion| motion.velocity)
    }

    /// Greatest acceleration in either direction; `None` if it has no limit.
    ///
    /// The candidates are the ends and the roots of a cubic, each found to the last digit. The acceleration at a
    /// candidate is that of [`Segment::at`], with the same error.
    #[must_use]
    pub fn peak_acceleration(&self) -> Option<f64> {
        let view = View::from_start(self);
        let [n2, n1, n0] = quadratic_of_acceleration(&view);
        let time = view.clock.cubic;
        // Acceleration is n / x'³ times a constant, so n' x' - 3 n x'' is 0 where it is greatest.
        let (x2, x1, x0) = (3.0 * time.a, 2.0 * time.b, time.c);
        let free = n1 * x0 - 3.0 * n0 * x1;
        let slopes =
            Cubic { a: -4.0 * n2 * x2, b: -n2 * x1 - 5.0 * n1 * x2, c: 2.0 * n2 * x0 - 2.0 * n1 * x1 - 6.0 * n0 * x2 };
        let [turn1, turn2] = slopes.turns();
        let root = |low: f64, high: f64| {
            let found = if low < high { search(&slopes, |u| slopes.value(u) + free, low, high) } else { None };
            found.unwrap_or(high)
        };
        self.peak(&[root(0.0, turn1), root(turn1, turn2), root(turn2, 1.0), turn1, turn2], |motion| motion.acceleration)
    }

    /// Greatest rate at the ends and at some curve parameters; `None` if time folds or its slope is 0 between the ends.
    fn peak(&self, parameters: &[f64], rate: impl Fn(Motion) -> Option<f64>) -> Option<f64> {
        if self.duration() == 0.0 {
            return Some(0.0);
        }
        let (start, end) = (View::from_start(self), View::from_end(self));
        let time = start.clock.cubic;
        let slowest = if time.a > 0.0 { -time.b / (3.0 * time.a) } else { 0.0 };
        let stands = |u: f64| 0.0 < u && u < 1.0 && time.slope(u) <= 4.0 * f64::EPSILON * time.slope_size(u);
        if self.folds() || stands(slowest) {
            return None;
        }
        let inner = parameters.iter().filter(|&&u| 0.0 < u && u < 1.0).map(|&u| start.motion(u));
        [start.motion(0.0), end.motion(0.0)]
            .into_iter()
            .chain(inner)
            .map(|motion| rate(motion).map(f64::abs))
            .try_fold(0.0, |most: f64, rate| Some(most.max(rate?)))
    }
}

/// Half of `y'' x' - y' x''`, which is 0 where velocity is greatest; the cubic terms cancel.
fn quadratic_of_acceleration(view: &View) -> [f64; 3] {
    let (x, y) = (&view.clock.cubic, &view.position);
    [3.0 * (y.a * x.b - y.b * x.a), 3.0 * (y.a * x.c - y.c * x.a), y.b * x.c - y.c * x.b]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::Point;

    fn unit(x1: f64, y1: f64, x2: f64, y2: f64) -> Segment {
        Segment::new([Point::ZERO, Point::new(x1, y1), Point::new(x2, y2), Point::new(1.0, 1.0)]).unwrap()
    }

    #[test]
    fn the_cubic_terms_of_the_acceleration_cancel() {
        // x = u and y = 3u² - 2u³: y'' x' - y' x'' is 6 - 12u, halved.
        let [a, b, c] = quadratic_of_acceleration(&View::from_start(&unit(1.0 / 3.0, 0.0, 2.0 / 3.0, 1.0)));
        assert!(a.abs() < 1e-14 && (b + 6.0).abs() < 1e-14 && (c - 3.0).abs() < 1e-14, "{a} {b} {c}");
    }

    #[test]
    fn a_rate_without_a_limit_is_none() {
        // Segments with a vertical tangent inside, and with time that folds.
        for segment in [unit(1.0, 0.2, 0.0, 0.8), unit(1.5, 0.2, -0.5, 0.8)] {
            assert_eq!((segment.peak_velocity(), segment.peak_acceleration()), (None, None));
        }
        // With a handle at its end point, velocity has a limit and acceleration has none.
        let drawn = unit(0.0, 0.0, 0.5, 1.0);
        assert!(drawn.peak_velocity().is_some());
        assert_eq!(drawn.peak_acceleration(), None);
    }

    #[test]
    fn the_range_of_a_wave_includes_its_extrema() {
        // Both extrema are within the time, and outside the range of the end positions.
        let (least, most) = unit(0.3, 4.0, 0.7, -3.0).range();
        assert!((-0.3..-0.25).contains(&least) && (1.25..1.3).contains(&most), "{least} {most}");
    }
}
