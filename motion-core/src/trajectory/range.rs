//! Ranges of time and position, and maps between them: normalized curves become physical ones, and back.

use crate::bezier::print::{debug_numbers, shown_as_it_is};
use crate::bezier::{OutOfRange, Point, Segment};

/// From one value to another, of time or of position; `to` may be less.
#[derive(Clone, Copy, PartialEq)]
pub struct Range {
    /// Where it begins.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
}

shown_as_it_is! { Range }
debug_numbers! { Range { from, to } }

impl Range {
    /// From 0 to 1: what normalized curves run through, as those of kOS.
    pub const UNIT: Self = Self { from: 0.0, to: 1.0 };

    /// A range from its two ends.
    #[must_use]
    pub const fn new(from: f64, to: f64) -> Self {
        Self { from, to }
    }

    /// The way from one end to the other; negative if `to` is less.
    #[must_use]
    pub fn width(&self) -> f64 {
        self.to - self.from
    }
}

/// Why there is no map between two ranges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// An end of a range, or the way between both, is infinite or not a number.
    #[error("map: a range is not finite")]
    NotFinite,
    /// Both ends of the first range are the same, or too close for the quotient of the widths.
    #[error("map: the first range has no width")]
    NoWidth,
}

/// The affine map that takes the ends of one range to those of another: `to.from + (value - from.from) * scale`.
///
/// Both ends are exact. A kOS position from 0 to 1 becomes one in rotations by the map from [`Range::UNIT`] to the
/// motor's range, and so a time in seconds by that to the move's duration.
///
/// ```
/// use motion_core::bezier::Segment;
/// use motion_core::trajectory::{Map, Range};
///
/// // The whole move takes 8 seconds, and the motor has 30 rotations, of which it starts at the 3rd.
/// let segment = Segment::from_f32([[0.0, 0.0], [0.125, 0.0], [0.25, 0.5], [0.5, 0.5]])?;
/// let time = Map::new(Range::UNIT, Range::new(0.0, 8.0))?;
/// let position = Map::new(Range::UNIT, Range::new(3.0, 33.0))?;
/// let physical = segment.mapped(&time, &position)?;
/// assert_eq!((physical.end(), physical.position(4.0)), (4.0, 18.0));
/// assert_eq!(physical.mapped(&time.inverse()?, &position.inverse()?)?, segment);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, PartialEq)]
pub struct Map {
    from: Range,
    to: Range,
    scale: f64,
}

debug_numbers! { Map { from, to } }

impl Map {
    /// The map from one range to another; the other one may have no width.
    ///
    /// # Errors
    ///
    /// [`MapError`] if a range is not finite, or the first has no width.
    pub fn new(from: Range, to: Range) -> Result<Self, MapError> {
        let (width, other) = (from.width(), to.width());
        // An end that is not finite makes the width so.
        if !(width.is_finite() && other.is_finite()) {
            return Err(MapError::NotFinite);
        }
        let scale = other / width;
        if scale.is_finite() { Ok(Self { from, to, scale }) } else { Err(MapError::NoWidth) }
    }

    /// The map back.
    ///
    /// # Errors
    ///
    /// [`MapError::NoWidth`] if the second range has none: then all values have become one.
    pub fn inverse(&self) -> Result<Self, MapError> {
        Self::new(self.to, self.from)
    }

    /// How much a unit of the first range is in the second; negative if the map turns the order round.
    #[must_use]
    pub const fn scale(&self) -> f64 {
        self.scale
    }

    /// Maps a value, inside the range or outside.
    #[must_use]
    pub fn apply(&self, value: f64) -> f64 {
        let (gone, left) = (value - self.from.from, self.from.to - value);
        // From the nearer end, so that both are exact.
        if gone.abs() <= left.abs() { self.to.from + gone * self.scale } else { self.to.to - left * self.scale }
    }
}

impl Segment {
    /// The same curve over other ranges of time and position; its end points are mapped exactly as [`Map::apply`] does.
    ///
    /// A map that turns time round turns the order of the control points round too: the way back.
    ///
    /// # Errors
    ///
    /// [`OutOfRange`] if a coordinate becomes larger than a segment can have.
    pub fn mapped(&self, time: &Map, position: &Map) -> Result<Self, OutOfRange> {
        let mut points = self.points().map(|p| Point::new(time.apply(p.time), position.apply(p.position)));
        if time.scale() < 0.0 {
            points.reverse();
        }
        Self::new(points)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_width_is_refused() {
        let map = |from, to| Map::new(Range::new(from, to), Range::UNIT).map(|map| map.scale());
        assert_eq!(map(2.0, 2.0), Err(MapError::NoWidth));
        assert_eq!(map(0.0, 1e-310), Err(MapError::NoWidth));
        for end in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(map(end, 1.0), Err(MapError::NotFinite));
            assert_eq!(map(1.0, end), Err(MapError::NotFinite));
            assert_eq!(Map::new(Range::UNIT, Range::new(end, end)), Err(MapError::NotFinite));
        }
        let flat = Map::new(Range::UNIT, Range::new(5.0, 5.0)).unwrap();
        assert_eq!((flat.apply(0.3), flat.inverse()), (5.0, Err(MapError::NoWidth)));
    }

    #[test]
    fn time_turned_round_is_the_way_back() {
        let points =
            [(0.0, 0.0), (0.25, 0.5), (0.5, 1.0), (1.0, 1.0)].map(|(time, position)| Point::new(time, position));
        let there = Segment::new(points).unwrap();
        let (time, position) = (Map::new(Range::UNIT, Range::new(8.0, 0.0)), Map::new(Range::UNIT, Range::UNIT));
        let back = there.mapped(&time.unwrap(), &position.unwrap()).unwrap();
        assert_eq!((back.start(), back.end()), (0.0, 8.0));
        assert_eq!((back.position(0.0), back.position(8.0)), (1.0, 0.0));
        assert!((back.position(2.0) - there.position(0.75)).abs() < 1e-15);
    }
}
