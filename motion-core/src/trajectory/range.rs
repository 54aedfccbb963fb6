//! Ranges of time and position, and maps between them, which convert normalized curves to physical ones and back.

use crate::bezier::print::{debug_numbers, shown_as_it_is};
use crate::bezier::{OutOfRange, Point, Segment};

/// A range of time or position from one value to another; `to` may be less than `from`.
#[derive(Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Range {
    /// Start of the range.
    pub from: f64,
    /// End of the range.
    pub to: f64,
}

shown_as_it_is! { Range }
debug_numbers! { Range { from, to } }

impl Range {
    /// The range from 0 to 1 of normalized curves, such as those of kOS.
    pub const UNIT: Self = Self { from: 0.0, to: 1.0 };

    /// A range from its two ends.
    #[must_use]
    pub const fn new(from: f64, to: f64) -> Self {
        Self { from, to }
    }

    /// Difference between both ends; negative if `to` is less than `from`.
    #[must_use]
    pub fn width(&self) -> f64 {
        self.to - self.from
    }
}

/// Why there is no map between two ranges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// An end of a range, or its width, is NaN or infinite.
    #[error("map: a range is not finite")]
    NotFinite,
    /// Both ends of the first range are equal, or so close that the scale of the map is infinite.
    #[error("map: the first range has no width")]
    NoWidth,
}

/// The affine map that takes the ends of one range to those of another: `to.from + (value - from.from) * scale`.
///
/// Both ends are exact. The map from [`Range::UNIT`] to the range of a motor converts a kOS position from 0 to 1 to
/// rotations. In the same way, the map to the duration of the move converts a kOS time to seconds.
///
/// ```
/// use motion_core::bezier::Segment;
/// use motion_core::trajectory::{Map, Range};
///
/// // The whole move takes 8 seconds. The range of the motor is 30 rotations, from 3 to 33.
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
    /// The map from one range to another. The width of the second range may be 0.
    ///
    /// # Errors
    ///
    /// [`MapError`] if a range is not finite, or the width of the first range is 0.
    pub fn new(from: Range, to: Range) -> Result<Self, MapError> {
        let (width, other) = (from.width(), to.width());
        // If an end is not finite, the width is not finite.
        if !(width.is_finite() && other.is_finite()) {
            return Err(MapError::NotFinite);
        }
        let scale = other / width;
        if scale.is_finite() { Ok(Self { from, to, scale }) } else { Err(MapError::NoWidth) }
    }

    /// The inverse map.
    ///
    /// # Errors
    ///
    /// [`MapError::NoWidth`] if the width of the second range is 0, because all values were mapped to one.
    pub fn inverse(&self) -> Result<Self, MapError> {
        Self::new(self.to, self.from)
    }

    /// Ratio of the widths of the second and the first range; negative if the map reverses the order.
    #[must_use]
    pub const fn scale(&self) -> f64 {
        self.scale
    }

    /// Maps a value, which may be outside the range.
    #[must_use]
    pub fn apply(&self, value: f64) -> f64 {
        let (gone, left) = (value - self.from.from, self.from.to - value);
        // Measured from the nearer end, so that both ends are exact.
        if gone.abs() <= left.abs() { self.to.from + gone * self.scale } else { self.to.to - left * self.scale }
    }
}

impl Segment {
    /// The same curve over other ranges of time and position. Its end points are exactly those from [`Map::apply`].
    ///
    /// A map that reverses time also reverses the order of the control points: the result is the reverse move.
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
    fn ranges_without_a_width_are_refused() {
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
    fn reversed_time_is_the_reverse_move() {
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
