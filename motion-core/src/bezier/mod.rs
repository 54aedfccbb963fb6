//! A cubic Bezier segment of an axis, in time and position: where it is at a time, and how fast.
//!
//! The curve is given by four control points, as kOS trajectories have it (kOS, `TrajectoryData`,
//! block 6): the ends, which it meets, and two handles, which it starts towards and arrives from.
//! Its points belong to a curve parameter from 0 to 1. A rig needs them at a time, so the time
//! polynomial is solved first. Everything is computed in `f64`; units are the caller's.
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
//! // Many times: 24 frames a second.
//! let times: [f64; 97] = std::array::from_fn(|frame| frame as f64 / 24.0);
//! let mut positions = [0.0; 97];
//! Cursor::new(pan).sample(&times, &mut positions);
//! assert_eq!(positions[96], 90.0);
//! # Ok::<(), motion_core::bezier::OutOfRange>(())
//! ```
//!
//! # What holds
//!
//! - No result is ever infinite or not a number: [`Motion`] has no rate where there is none.
//! - The end points are exact. Before the start the axis is at the first one, after the end at the
//!   last one, both at rest. A segment without length gives its last point and velocity 0.
//! - The curve parameter found belongs to a time within 1e-15 of the one asked for, relative to the
//!   largest time of a control point, whatever the tangent; where time runs slowly it is found with
//!   twice the digits of `f64`. So a position is right within 1e-13 of the largest position of a
//!   control point, at vertical tangents too. At a fold, where the position jumps, a time that close
//!   to the jump can fall on the other side.
//! - Where a handle leaves the segment's time, time can fold back, and a time have three positions.
//!   The one with the largest curve parameter counts, and the position jumps at the fold.

mod cubic;
mod cursor;
mod double;
mod key;
mod near;
mod peaks;
pub(crate) mod print;
mod view;

use double::Double;
use view::View;

pub use cursor::Cursor;
pub use key::{Ease, Key};

/// A control point.
#[derive(Clone, Copy, Default, PartialEq)]
pub struct Point {
    /// The time, in the caller's unit.
    pub time: f64,
    /// The position, in the caller's unit.
    pub position: f64,
}

impl Point {
    /// The origin, at time 0.
    pub const ZERO: Self = Self { time: 0.0, position: 0.0 };

    /// A point from its time and its position.
    #[must_use]
    pub const fn new(time: f64, position: f64) -> Self {
        Self { time, position }
    }

    /// The point at `share` of the way to another one; exact at 0.
    fn toward(self, other: Self, share: f64) -> Self {
        let step = |from: f64, to: f64| from + (to - from) * share;
        Self { time: step(self.time, other.time), position: step(self.position, other.position) }
    }

    fn within(self, tolerance: f64, of: Self) -> bool {
        (self.time - of.time).abs() <= tolerance && (self.position - of.position).abs() <= tolerance
    }
}

/// Where an axis is at a time, and how fast. All numbers are finite.
#[derive(Clone, Copy, Default, PartialEq)]
pub struct Motion {
    /// The position.
    pub position: f64,
    /// The change of position a unit of time; `None` at a vertical tangent, where it is infinite.
    pub velocity: Option<f64>,
    /// The change of velocity a unit of time; `None` where it is infinite: at vertical tangents, and
    /// at an end whose handle was drawn back into it, unless the curve is straight there.
    pub acceleration: Option<f64>,
}

impl Motion {
    /// At rest.
    const fn resting(position: f64) -> Self {
        Self { position, velocity: Some(0.0), acceleration: Some(0.0) }
    }
}

print::debug_numbers! {
    Point { time, position }
    Motion { position, velocity, acceleration }
}

/// A coordinate of a control point is not a number, or larger than 1e75 either way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[error("curve: a coordinate is not a number, or beyond 1e75")]
pub struct OutOfRange;

/// A cubic Bezier curve in time and position.
///
/// Laws: `s.reversed().reversed() == s`; `s.position(s.end()) == s.points()[3].position`; the halves
/// of [`split`](Self::split) have the positions of the whole, and [`join`](Self::join) gives it back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    points: [Point; 4],
}

impl Segment {
    /// The largest coordinate: all that `f32` has, and room for products.
    const LARGEST: f64 = 1e75;
    /// What is shorter has no length: less than `f32` can tell from 0.
    const SHORTEST: f64 = 1e-75;

    /// A segment from its end points, first and last, and the handles between them.
    ///
    /// # Errors
    ///
    /// [`OutOfRange`] if a coordinate is infinite, not a number, or beyond 1e75.
    pub fn new(points: [Point; 4]) -> Result<Self, OutOfRange> {
        let sound = |coordinate: f64| coordinate.abs() <= Self::LARGEST;
        if points.iter().all(|point| sound(point.time) && sound(point.position)) {
            Ok(Self { points })
        } else {
            Err(OutOfRange)
        }
    }

    /// A segment from times and positions in turn, as a kOS segment block holds them.
    ///
    /// # Errors
    ///
    /// [`OutOfRange`] if a coordinate is infinite or not a number.
    pub fn from_f32(points: [[f32; 2]; 4]) -> Result<Self, OutOfRange> {
        Self::new(points.map(|[time, position]| Point::new(time.into(), position.into())))
    }

    /// Times and positions in turn, each as the nearest `f32`; what came from `f32` comes back.
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

    /// The time of the first end point.
    #[must_use]
    pub const fn start(&self) -> f64 {
        let [first, ..] = self.points;
        first.time
    }

    /// The time of the last end point.
    #[must_use]
    pub const fn end(&self) -> f64 {
        let [.., last] = self.points;
        last.time
    }

    /// The time from start to end; 0 if the end is not later, or by less than 1e-75.
    #[must_use]
    pub fn duration(&self) -> f64 {
        let length = self.end() - self.start();
        if length >= Self::SHORTEST { length } else { 0.0 }
    }

    /// The position at a time; before the start the first one, after the end the last one.
    ///
    /// A time that is not a number is taken as one before the start.
    #[must_use]
    pub fn position(&self, time: f64) -> f64 {
        self.locate(time).position()
    }

    /// Position, velocity and acceleration at a time; outside the segment the axis rests.
    ///
    /// At the ends, velocity and acceleration are those of the segment's side. They lose digits where
    /// time runs slowly on the curve: with both coordinates from 0 to 1 and time `n` times slower than
    /// on average, velocity is right within 1e-14 times `n³`, and acceleration within 1e-13 times `n⁵`.
    #[must_use]
    pub fn at(&self, time: f64) -> Motion {
        self.locate(time).motion()
    }

    /// The curve parameter that belongs to a time: 0 at the start and before, 1 at the end and after.
    ///
    /// Where time folds back it is the largest of the parameters that do.
    #[must_use]
    pub fn parameter(&self, time: f64) -> f64 {
        self.locate(time).parameter()
    }

    /// Whether time runs backwards anywhere, so that some times have three positions.
    #[must_use]
    pub fn folds(&self) -> bool {
        let clock = View::from_start(self).clock;
        let lowest = if clock.cubic.a > 0.0 { (-clock.cubic.b / (3.0 * clock.cubic.a)).clamp(0.0, 1.0) } else { 0.0 };
        let noise = 4.0 * f64::EPSILON * clock.cubic.slope_size(1.0);
        !clock.ordered() && [0.0, lowest, 1.0].iter().any(|&u| clock.cubic.slope(u) < -noise)
    }

    /// The same way back in the same time: what was at `start() + t` is at `end() - t`.
    ///
    /// Twice reversed is as before, bit for bit: times are mirrored by exchanging start and end and
    /// negating both, so the reversed segment runs from `-end()` to `-start()`.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let mut points = self.points.map(|point| Point::new(-point.time, point.position));
        points.reverse();
        Self { points }
    }

    /// The parts before and after a time, which meet in it; `None` unless it lies inside.
    ///
    /// Both have the positions of the whole within 1e-13, where time runs well.
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

    /// The one segment that this and the next one are the parts of; `None` if there is none whose
    /// parts have the same control points, each coordinate within `tolerance`.
    #[must_use]
    pub fn join(&self, next: &Self, tolerance: f64) -> Option<Self> {
        let ([p0, p1, before, middle], [_, after, p2, p3]) = (self.points, next.points);
        // The inner handles lie on either side of the joint as the joint lies in the whole.
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

    /// Both parts at a curve parameter, by de Casteljau's construction.
    fn divide(&self, u: f64) -> (Self, Self) {
        let [p0, p1, p2, p3] = self.points;
        let (leave, between, arrive) = (p0.toward(p1, u), p1.toward(p2, u), p2.toward(p3, u));
        let (before, after) = (leave.toward(between, u), between.toward(arrive, u));
        let middle = before.toward(after, u);
        (Self { points: [p0, leave, before, middle] }, Self { points: [middle, after, arrive, p3] })
    }

    fn locate(&self, time: f64) -> Place {
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

/// Where a time is.
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
