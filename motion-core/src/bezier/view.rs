//! A segment measured from one of its ends, where numbers are small and so keep their digits.

use super::cubic::{Clock, Cubic};
use super::double::Double;
use super::{Motion, Segment};

/// Both coordinates, measured from one end point. From the last end point, time runs backwards.
#[derive(Clone, Copy)]
pub(super) struct View {
    pub(super) clock: Clock,
    pub(super) position: Cubic,
    /// Position of the end point.
    pub(super) origin: f64,
    backwards: bool,
}

impl View {
    pub(super) fn from_start(segment: &Segment) -> Self {
        let [p0, p1, p2, p3] = segment.points();
        let ahead = [p1, p2, p3];
        Self {
            clock: Clock::new(ahead.map(|p| Double::difference(p.time, p0.time)), true),
            position: Cubic::new(ahead.map(|p| p.position - p0.position)),
            origin: p0.position,
            backwards: false,
        }
    }

    pub(super) fn from_end(segment: &Segment) -> Self {
        let [p0, p1, p2, p3] = segment.points();
        let behind = [p2, p1, p0];
        Self {
            clock: Clock::new(behind.map(|p| Double::difference(p3.time, p.time)), false),
            position: Cubic::new(behind.map(|p| p.position - p3.position)),
            origin: p3.position,
            backwards: true,
        }
    }

    pub(super) fn position(&self, u: f64) -> f64 {
        self.origin + self.position.value(u)
    }

    /// The curve parameter counted from the first control point.
    pub(super) fn forwards(&self, u: f64) -> f64 {
        if self.backwards { 1.0 - u } else { u }
    }

    /// Position, velocity and acceleration at a curve parameter.
    #[inline]
    pub(super) fn motion(&self, u: f64) -> Motion {
        let (velocity, acceleration) = self.rates(u);
        let velocity = if self.backwards { velocity.map(|v| -v) } else { velocity };
        let finite = |rate: &f64| rate.is_finite();
        Motion {
            position: self.position(u),
            velocity: velocity.filter(finite),
            acceleration: acceleration.filter(finite),
        }
    }

    #[inline]
    fn rates(&self, u: f64) -> (Option<f64>, Option<f64>) {
        let (time, position) = (&self.clock.cubic, &self.position);
        let slope = time.slope(u);
        if slope > 2.0 * f64::EPSILON * time.slope_size(u) {
            let velocity = position.slope(u) / slope;
            let acceleration = 2.0 * (position.bend(u) - velocity * time.bend(u)) / slope / slope;
            return (Some(velocity), Some(acceleration));
        }
        self.rates_at_rest(u)
    }

    /// Rates where the slope of time is 0: their limits, if the slope of position is 0 as well.
    #[cold]
    fn rates_at_rest(&self, u: f64) -> (Option<f64>, Option<f64>) {
        let (time, position) = (&self.clock.cubic, &self.position);
        let (bend, rise) = (time.bend(u), position.bend(u));
        if position.slope(u).abs() > 2.0 * f64::EPSILON * position.slope_size(u) {
            (None, None)
        } else if bend > 0.0 {
            // Velocity changes while time stands still, so acceleration is infinite, except on a straight line.
            let straight = position.a * bend - rise * time.a;
            (Some(rise / bend), (straight == 0.0).then_some(0.0))
        } else if rise == 0.0 && time.a > 0.0 {
            (Some(position.a / time.a), Some(0.0))
        } else {
            (None, None)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::Point;

    #[test]
    fn both_ends_give_the_same_motion() {
        let at = Point::new;
        let segment = Segment::new([at(1.0, 5.0), at(1.5, 5.0), at(2.0, 8.0), at(3.0, 9.0)]).unwrap();
        let (start, end) = (View::from_start(&segment), View::from_end(&segment));
        for u in [0.0, 0.25, 0.5, 1.0] {
            let (one, other) = (start.motion(u), end.motion(1.0 - u));
            let near = |one: f64, other: f64| (one - other).abs() < 1e-13;
            assert!(near(one.position, other.position), "{one:?} {other:?}");
            assert!(near(one.velocity.unwrap(), other.velocity.unwrap()), "{one:?} {other:?}");
            assert!(near(one.acceleration.unwrap(), other.acceleration.unwrap()), "{one:?} {other:?}");
            assert_eq!((start.forwards(u), end.forwards(1.0 - u)), (u, u));
        }
        assert_eq!((start.position(0.0), end.position(0.0)), (5.0, 9.0));
    }
}
