//! Cubic Bezier segments of an axis, in time and position, which give position, velocity and acceleration at a time.
//!
//! A segment has four control points, as in kOS trajectories (kOS, `TrajectoryData`, block 6): the two ends, through
//! which the curve passes, and two handles. It leaves the first end towards the first handle, and arrives at the last
//! end from the direction of the second handle. Each point of the curve belongs to a curve parameter from 0 to 1. A rig
//! needs the point at a time, so the time polynomial is solved first. All numbers are `f64`, in the caller's units.
//!
//! ```
//! use motion_core::bezier::{Cursor, Ease, Key, Segment};
//!
//! // From rest to rest, 90 degrees in 4 seconds.
//! let from = Key { time: 0.0, position: 0.0, arrive: Ease::Linear, leave: Ease::Flat(0.4) };
//! let to = Key { time: 4.0, position: 90.0, arrive: Ease::Flat(0.4), leave: Ease::Linear };
//! let pan = Segment::between(&from, &to)?;
//!
//! let middle = pan.at(2.0);
//! assert!((middle.position - 45.0).abs() < 1e-12);
//! assert_eq!(pan.at(0.0).velocity, Some(0.0));
//! let fastest = pan.peak_velocity().expect("no vertical tangent");
//! assert!((fastest - middle.velocity.unwrap()).abs() < 1e-12);
//!
//! // Positions at many times: 24 frames per second.
//! let times: [f64; 97] = std::array::from_fn(|frame| frame as f64 / 24.0);
//! let mut positions = [0.0; 97];
//! Cursor::new(pan).sample(&times, &mut positions);
//! assert_eq!(positions[96], 90.0);
//! # Ok::<(), motion_core::bezier::OutOfRange>(())
//! ```
//!
//! [`Segment`] needs no preparation, a [`Cursor`] is made for times in order, and a [`Table`] for times in any order.
//!
//! # Guarantees
//!
//! - No result is ever NaN or infinite: where a rate would be infinite, [`Motion`] has `None`.
//! - The end points are exact. Before the start the axis rests at the first one, and after the end at the last one. A
//!   segment of duration 0 has the position of its last point, and velocity 0.
//! - The computed curve parameter belongs to a time within 1e-15 of the given time, relative to the largest time of a
//!   control point, for any tangent. Where time runs slowly along the curve, it is computed with twice the digits of
//!   `f64`. So the error of a position is at most 1e-13 of the largest position of a control point, also at vertical
//!   tangents. At a fold, where the position jumps, a time that is as close as 1e-15 to the jump may give the position
//!   on the other side.
//! - If a handle is outside the time of the segment, time can run backwards (fold), and a time can have three
//!   positions. The position with the largest curve parameter counts, and the position jumps at the fold.

mod cubic;
mod cursor;
mod double;
mod key;
mod local;
mod near;
mod peaks;
pub(crate) mod print;
mod table;
mod view;

use double::Double;
use local::{Local, Middle};
use view::View;

pub use cursor::Cursor;
pub use key::{Ease, Key};
pub use table::Table;

/// A control point of a segment.
#[derive(Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Point {
    /// Time, in the caller's unit.
    pub time: f64,
    /// Position, in the caller's unit.
    pub position: f64,
}

impl Point {
    /// The point at time 0 and position 0.
    pub const ZERO: Self = Self { time: 0.0, position: 0.0 };

    /// A point from its time and its position.
    #[must_use]
    pub const fn new(time: f64, position: f64) -> Self {
        Self { time, position }
    }

    /// The point at `share` of the distance to another one; exact at 0.
    fn toward(self, other: Self, share: f64) -> Self {
        let step = |from: f64, to: f64| from + (to - from) * share;
        Self { time: step(self.time, other.time), position: step(self.position, other.position) }
    }

    fn within(self, tolerance: f64, of: Self) -> bool {
        (self.time - of.time).abs() <= tolerance && (self.position - of.position).abs() <= tolerance
    }
}

/// Position, velocity and acceleration of an axis at a time. All numbers are finite.
#[derive(Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Motion {
    /// Position, in the caller's units.
    pub position: f64,
    /// Velocity, in units of position per unit of time; `None` at a vertical tangent, where it is infinite.
    pub velocity: Option<f64>,
    /// Acceleration, in units of velocity per unit of time; `None` where it is infinite: at vertical tangents, and at
    /// an end whose handle is at the end itself, except if the curve is straight there.
    pub acceleration: Option<f64>,
}

impl Motion {
    /// The motion of an axis at rest.
    const fn resting(position: f64) -> Self {
        Self { position, velocity: Some(0.0), acceleration: Some(0.0) }
    }
}

print::debug_numbers! {
    Point { time, position }
    Motion { position, velocity, acceleration }
}

/// Error: a coordinate of a control point is NaN, or its absolute value is above 1e75.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[error("curve: a coordinate is NaN, or beyond 1e75")]
pub struct OutOfRange;

/// A cubic Bezier curve in time and position.
///
/// Laws: `s.reversed().reversed() == s`; `s.position(s.end()) == s.points()[3].position`; the two parts from
/// [`split`](Self::split) have the positions of the whole, and [`join`](Self::join) makes the whole of them again.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "[Point; 4]", into = "[Point; 4]"))]
pub struct Segment {
    points: [Point; 4],
}

impl TryFrom<[Point; 4]> for Segment {
    type Error = OutOfRange;

    fn try_from(points: [Point; 4]) -> Result<Self, OutOfRange> {
        Self::new(points)
    }
}

impl From<Segment> for [Point; 4] {
    fn from(segment: Segment) -> Self {
        segment.points
    }
}

impl Segment {
    /// Largest coordinate: the range of `f32`, and room for products.
    const LARGEST: f64 = 1e75;
    /// Shortest duration that is not 0: less than the smallest `f32`.
    const SHORTEST: f64 = 1e-75;

    /// A segment from its control points: the first end, its handle, the handle of the last end, the last end.
    ///
    /// # Errors
    ///
    /// [`OutOfRange`] if a coordinate is NaN, infinite, or beyond 1e75.
    pub fn new(points: [Point; 4]) -> Result<Self, OutOfRange> {
        let sound = |coordinate: f64| coordinate.abs() <= Self::LARGEST;
        if points.iter().all(|point| sound(point.time) && sound(point.position)) {
            Ok(Self { points })
        } else {
            Err(OutOfRange)
        }
    }

    /// A segment from pairs of time and position, as in a segment block of kOS.
    ///
    /// # Errors
    ///
    /// [`OutOfRange`] if a coordinate is NaN or infinite.
    pub fn from_f32(points: [[f32; 2]; 4]) -> Result<Self, OutOfRange> {
        Self::new(points.map(|[time, position]| Point::new(time.into(), position.into())))
    }

    /// Pairs of time and position, each as the nearest `f32`; a segment from `f32` gives the same numbers back.
    ///
    /// # Errors
    ///
    /// [`OutOfRange`] if a coordinate is beyond the range of `f32`.
    pub fn to_f32(&self) -> Result<[[f32; 2]; 4], OutOfRange> {
        #[expect(clippy::cast_possible_truncation, reason = "rounds to the nearest, and is checked below")]
        let points = self.points.map(|point| [point.time as f32, point.position as f32]);
        if points.as_flattened().iter().all(|coordinate| coordinate.is_finite()) { Ok(points) } else { Err(OutOfRange) }
    }

    /// The control points: the first end, its handle, the handle of the last end, the last end.
    #[must_use]
    pub const fn points(&self) -> [Point; 4] {
        self.points
    }

    /// Time of the first end point.
    #[must_use]
    pub const fn start(&self) -> f64 {
        let [first, ..] = self.points;
        first.time
    }

    /// Time of the last end point.
    #[must_use]
    pub const fn end(&self) -> f64 {
        let [.., last] = self.points;
        last.time
    }

    /// Time from start to end; 0 if the end is less than 1e-75 later, or not later.
    #[must_use]
    pub fn duration(&self) -> f64 {
        let length = self.end() - self.start();
        if length >= Self::SHORTEST { length } else { 0.0 }
    }

    /// Position at a time; before the start that of the first end, after the end that of the last end.
    ///
    /// NaN counts as a time before the start.
    #[must_use]
    pub fn position(&self, time: f64) -> f64 {
        self.locate(time, Local::position, Place::position)
    }

    /// Position, velocity and acceleration at a time; outside the segment the axis is at rest.
    ///
    /// At the ends, velocity and acceleration are those inside the segment. They lose digits where time runs slowly
    /// along the curve: with both coordinates from 0 to 1 and time `n` times slower than on average, the error of
    /// velocity is at most 1e-14 times `n³`, and that of acceleration at most 1e-13 times `n⁵`.
    #[must_use]
    pub fn at(&self, time: f64) -> Motion {
        self.locate(time, Local::motion, Place::motion)
    }

    /// Curve parameter that belongs to a time: 0 at the start and before, 1 at the end and after.
    ///
    /// Where time folds back, it is the largest parameter that belongs to the time.
    #[must_use]
    pub fn parameter(&self, time: f64) -> f64 {
        self.locate(time, Local::parameter, Place::parameter)
    }

    /// Whether time runs backwards anywhere on the curve, so that some times have three positions.
    #[must_use]
    pub fn folds(&self) -> bool {
        let clock = View::from_start(self).clock;
        let lowest = if clock.cubic.a > 0.0 { (-clock.cubic.b / (3.0 * clock.cubic.a)).clamp(0.0, 1.0) } else { 0.0 };
        let noise = 4.0 * f64::EPSILON * clock.cubic.slope_size(1.0);
        !self.ordered() && [0.0, lowest, 1.0].iter().any(|&u| clock.cubic.slope(u) < -noise)
    }

    /// The reverse move in the same duration: the position at `start() + t` moves to `end() - t`.
    ///
    /// Times are negated, so the reversed segment runs from `-end()` to `-start()`. Reversed twice, a segment is the
    /// same, bit for bit.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let mut points = self.points.map(|point| Point::new(-point.time, point.position));
        points.reverse();
        Self { points }
    }

    /// The two parts before and after a time; `None` if the time is not inside the segment.
    ///
    /// Both parts have the positions of the whole within 1e-13, except where time runs slowly along the curve.
    #[must_use]
    pub fn split(&self, time: f64) -> Option<(Self, Self)> {
        if !(self.start() < time && time < self.end()) || self.duration() == 0.0 {
            return None;
        }
        let (mut left, mut right) = self.divide(self.parameter(time));
        let middle = Point::new(time, self.position(time));
        let ([.., end], [start, ..]) = (&mut left.points, &mut right.points);
        (*end, *start) = (middle, middle);
        Some((left, right))
    }

    /// The segment whose two parts are this segment and the next one; `None` if no segment has parts with the same
    /// control points, each coordinate within `tolerance`.
    #[must_use]
    pub fn join(&self, next: &Self, tolerance: f64) -> Option<Self> {
        let ([p0, p1, before, middle], [_, after, p2, p3]) = (self.points, next.points);
        // The joint divides the line between the inner handles in the same ratio as it divides the whole.
        let (width, rise) = (after.time - before.time, after.position - before.position);
        let share = if width.abs() >= rise.abs() {
            (middle.time - before.time) / width
        } else {
            (middle.position - before.position) / rise
        };
        if !(0.0 < share && share < 1.0) {
            return None;
        }
        let whole = Self::new([p0, p0.toward(p1, 1.0 / share), p3.toward(p2, 1.0 / (1.0 - share)), p3]).ok()?;
        let (left, right) = whole.divide(share);
        let parts = left.points.into_iter().chain(right.points);
        let given = self.points.into_iter().chain(next.points);
        parts.zip(given).all(|(part, given)| part.within(tolerance, given)).then_some(whole)
    }

    /// Both parts at a curve parameter, by de Casteljau's algorithm.
    fn divide(&self, u: f64) -> (Self, Self) {
        let [p0, p1, p2, p3] = self.points;
        let (leave, between, arrive) = (p0.toward(p1, u), p1.toward(p2, u), p2.toward(p3, u));
        let (before, after) = (leave.toward(between, u), between.toward(arrive, u));
        let middle = before.toward(after, u);
        (Self { points: [p0, leave, before, middle] }, Self { points: [middle, after, arrive, p3] })
    }

    /// Whether both handles are within the time of the segment, so that time cannot fold.
    fn ordered(&self) -> bool {
        let [first, leave, arrive, last] = self.points.map(|point| point.time);
        first <= leave && leave <= last && first <= arrive && arrive <= last
    }

    /// Evaluates the step from the middle that belongs to a time, or its exact place if it cannot be solved from there.
    #[inline]
    fn locate<T>(&self, time: f64, quick: impl Fn(&Local, f64) -> T, exact: impl Fn(&Place) -> T) -> T {
        let middle = Middle::new(self);
        match middle.solve(time - self.start()) {
            Some(step) => quick(&middle.local, step),
            None => exact(&self.exact(time)),
        }
    }

    /// The place of any time, with twice the digits on the curve.
    #[cold]
    fn exact(&self, time: f64) -> Place {
        let [first, _, _, last] = self.points;
        if self.duration() == 0.0 || time > last.time {
            return Place::After(last);
        }
        if time < first.time || time.is_nan() {
            return Place::Before(first);
        }
        let (passed, left) = (time - first.time, last.time - time);
        if passed <= left {
            let view = View::from_start(self);
            let u = if passed == 0.0 { 0.0 } else { view.clock.solve(Double::difference(time, first.time)) };
            Place::On(view, u)
        } else {
            let view = View::from_end(self);
            let u = if left == 0.0 { 0.0 } else { view.clock.solve(Double::difference(last.time, time)) };
            Place::On(view, u)
        }
    }
}

/// Place of a time on or beside the curve.
enum Place {
    /// Before the curve: at its first end point.
    Before(Point),
    /// On the curve, at a parameter counted from the nearer end.
    On(View, f64),
    /// After the curve: at its last end point.
    After(Point),
}

impl Place {
    fn position(&self) -> f64 {
        match self {
            Self::On(view, u) => view.position(*u),
            Self::Before(end) | Self::After(end) => end.position,
        }
    }

    fn motion(&self) -> Motion {
        match self {
            Self::On(view, u) => view.motion(*u),
            Self::Before(end) | Self::After(end) => Motion::resting(end.position),
        }
    }

    fn parameter(&self) -> f64 {
        match self {
            Self::Before(_) => 0.0,
            Self::On(view, u) => view.forwards(*u),
            Self::After(_) => 1.0,
        }
    }
}

impl TryFrom<[[f32; 2]; 4]> for Segment {
    type Error = OutOfRange;

    fn try_from(points: [[f32; 2]; 4]) -> Result<Self, OutOfRange> {
        Self::from_f32(points)
    }
}
