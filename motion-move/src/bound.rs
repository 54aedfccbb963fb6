//! Bounds of the distance between curves.

#![cfg_attr(
    not(all(feature = "kos", feature = "dmc", feature = "hoot")),
    allow(dead_code, reason = "each conversion uses some of it")
)]

use motion_core::bezier::{OutOfRange, Point, Segment};

use crate::axis::MoveAxis;

/// Error of a computed position, as a part of the largest number.
pub(crate) const NOISE: f64 = 1e-12;

/// A difference, and its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Far {
    pub(crate) amount: f64,
    pub(crate) time: f64,
}

impl Far {
    pub(crate) const NONE: Self = Self { amount: 0.0, time: 0.0 };

    pub(crate) fn or(self, other: Self) -> Self {
        if other.amount > self.amount { other } else { self }
    }
}

/// The segments of an axis from 0 to the duration of the move, with those in which it rests before and after its key frames.
pub(crate) fn whole(axis: &MoveAxis, duration: f64) -> Result<Vec<Segment>, OutOfRange> {
    let curve = axis.curve();
    let rest = |from: f64, to: f64, position: f64| {
        let at = |part: f64| Point::new(from + part * (to - from), position);
        (from < to).then(|| Segment::new([at(0.0), at(1.0 / 3.0), at(2.0 / 3.0), at(1.0)]))
    };
    let before = rest(0.0, curve.start(), curve.position(curve.start())).transpose()?;
    let after = rest(curve.end(), duration, curve.position(curve.end())).transpose()?;
    Ok(before.into_iter().chain(curve.segments().iter().copied()).chain(after).collect())
}

/// A cubic from its four Bezier values, over the curve parameter from 0 to 1.
#[derive(Clone, Copy)]
pub(crate) struct Cubic(pub(crate) [f64; 4]);

impl Cubic {
    pub(crate) fn at(&self, u: f64) -> f64 {
        let [d0, d1, d2, d3] = self.0;
        let v = 1.0 - u;
        v * v * v * d0 + 3.0 * v * u * (v * d1 + u * d2) + u * u * u * d3
    }

    /// The greatest absolute value between two parameters, and its parameter. The candidates are both ends and the roots of
    /// a quadratic.
    pub(crate) fn farthest(&self, from: f64, to: f64) -> (f64, f64) {
        let [d0, d1, d2, d3] = self.0;
        let (q0, q1, q2) = (d1 - d0, d2 - d1, d3 - d2);
        let (a, b, c) = (q0 - 2.0 * q1 + q2, 2.0 * (q1 - q0), q0);
        let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
        let half = -0.5 * (b + root.copysign(b));
        [half / a, c / half]
            .into_iter()
            .filter(|u| from < *u && *u < to)
            .chain([to])
            .map(|u| (self.at(u).abs(), u))
            .fold((self.at(from).abs(), from), |most, this| if this.0 > most.0 { this } else { most })
    }
}

/// The greatest change of position within a time, and whether it is more than velocity times that time, as at a vertical
/// tangent. No change is greater; it may be smaller.
pub(crate) fn change(curve: &Segment, within: f64) -> (f64, bool) {
    let (least, most) = curve.range();
    let (width, most_by_speed) = (most - least, curve.peak_velocity().map(|speed| speed * within));
    match most_by_speed {
        Some(change) => (change.min(width), false),
        None => (change_in(curve, curve.start(), curve.end(), within).min(width), true),
    }
}

/// The greatest change within a time that begins between two times. Where velocity has no limit, the time is halved until it is
/// as short as the change may take; the range of that part is a bound.
fn change_in(curve: &Segment, from: f64, to: f64, within: f64) -> f64 {
    let part = between(curve, from - within, to + within);
    let (least, most) = part.range();
    if let Some(speed) = part.peak_velocity() {
        return (speed * within).min(most - least);
    }
    let middle = from + 0.5 * (to - from);
    if to - from <= within || middle <= from || middle >= to {
        return most - least;
    }
    change_in(curve, from, middle, within).max(change_in(curve, middle, to, within))
}

/// The part of a segment between two times.
pub(crate) fn between(curve: &Segment, from: f64, to: f64) -> Segment {
    let until = curve.split(to).map_or(*curve, |(before, _)| before);
    until.split(from).map_or(until, |(_, after)| after)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn nothing_is_farther_than_the_farthest(values in prop::array::uniform4(-9.0..9.0), ends in prop::array::uniform2(0.0..1.0), at in 0.0..1.0) {
            let [from, to] = [f64::min(ends[0], ends[1]), f64::max(ends[0], ends[1])];
            let cubic = Cubic(values);
            let (most, u) = cubic.farthest(from, to);
            prop_assert!((cubic.at(u).abs() - most).abs() < 1e-12 && from <= u && u <= to);
            prop_assert!(cubic.at(from + at * (to - from)).abs() <= most + 1e-12);
        }

        #[test]
        fn no_position_changes_more_than_the_bound(
            handles in prop_oneof![Just([0.0, 1.0]), Just([1.0, 0.0]), [0.0..1.0, 0.0..1.0]],
            positions in prop::array::uniform4(-9.0..9.0),
            within in prop_oneof![Just(1e-9), 1e-6..0.3],
            at in 0.0..1.0,
            near_start in any::<bool>(),
        ) {
            let times = [0.0, handles[0], handles[1], 1.0];
            let points: Vec<_> = times.into_iter().zip(positions).map(|(time, at)| Point::new(time, at)).collect();
            let curve = Segment::new(points.try_into().unwrap()).unwrap();
            let (most, _) = change(&curve, within);
            let at = if near_start { at * within } else { at };
            let moved = (curve.position(at) - curve.position(at + within)).abs();
            prop_assert!(moved <= most * (1.0 + 1e-6) + 1e-9, "{} at {}, bound {}", moved, at, most);
        }
    }
}
