//! Key frames, from which people describe a curve.

use core::fmt;

use super::print::{Shown, debug_numbers, shown_as_it_is};
use super::{OutOfRange, Point, Segment};

/// Ease of an axis at a key frame: how the axis leaves it, or arrives at it.
#[derive(Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Ease {
    /// Straight towards the other key frame: the handle is at one third of the line between them.
    Linear,
    /// From rest or to rest: the handle is flat, and its length is this part of the time between the key frames. With 0
    /// the handle is at the key frame itself; above 1 time can fold.
    Flat(f64),
    /// Any handle, as its distance in time and position from the key frame; the time is negative for arriving.
    Handle(Point),
}

impl Ease {
    /// The handle of `key` towards `other`.
    fn handle(self, key: Point, other: Point) -> Point {
        match self {
            Self::Linear => key.toward(other, 1.0 / 3.0),
            Self::Flat(part) => Point { time: key.time + part * (other.time - key.time), ..key },
            Self::Handle(Point { time, position }) => Point::new(key.time + time, key.position + position),
        }
    }
}

impl fmt::Debug for Ease {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Linear => f.write_str("Linear"),
            Self::Flat(part) => f.debug_tuple("Flat").field(&part.shown()).finish(),
            Self::Handle(apart) => f.debug_tuple("Handle").field(apart).finish(),
        }
    }
}

shown_as_it_is! { Ease }

/// A key frame: the position of an axis at a time, and how the axis arrives and leaves.
#[derive(Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Key {
    /// Time, in the caller's unit.
    pub time: f64,
    /// Position, in the caller's unit.
    pub position: f64,
    /// Ease of the segment that ends at the key frame, if there is one.
    pub arrive: Ease,
    /// Ease of the segment that starts at the key frame, if there is one.
    pub leave: Ease,
}

debug_numbers! { Key { time, position, arrive, leave } }

impl Key {
    fn point(&self) -> Point {
        Point::new(self.time, self.position)
    }
}

impl Segment {
    /// A segment from one key frame to the next.
    ///
    /// # Errors
    ///
    /// [`OutOfRange`] as for [`Segment::new`].
    pub fn between(from: &Key, to: &Key) -> Result<Self, OutOfRange> {
        let (first, last) = (from.point(), to.point());
        Self::new([first, from.leave.handle(first, last), to.arrive.handle(last, first), last])
    }

    /// The key frames at both ends, with the handles of the segment. On the outer sides their ease is [`Ease::Linear`].
    ///
    /// [`Segment::between`] these key frames is this segment; its handles differ at most by the rounding of one
    /// subtraction and one addition.
    #[must_use]
    pub fn keys(&self) -> (Key, Key) {
        let [first, leave, arrive, last] = self.points();
        let key = |Point { time, position }| Key { time, position, arrive: Ease::Linear, leave: Ease::Linear };
        let apart = |handle: Point, key: Point| {
            Ease::Handle(Point::new(handle.time - key.time, handle.position - key.position))
        };
        (Key { leave: apart(leave, first), ..key(first) }, Key { arrive: apart(arrive, last), ..key(last) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_ease_has_its_handle() {
        let (here, there) = (Point::new(2.0, 1.0), Point::new(5.0, 7.0));
        assert!(Ease::Linear.handle(here, there).within(1e-15, Point::new(3.0, 3.0)));
        assert_eq!(Ease::Flat(0.5).handle(here, there), Point::new(3.5, 1.0));
        // For arriving, the other key frame is the earlier one.
        assert_eq!(Ease::Flat(0.5).handle(there, here), Point::new(3.5, 7.0));
        assert_eq!(Ease::Handle(Point::new(-1.0, 0.5)).handle(there, here), Point::new(4.0, 7.5));
    }

    #[test]
    fn keys_are_linear_on_the_outer_sides() {
        let handle = |time| Ease::Handle(Point::new(time, 0.0));
        let from = Key { time: 0.0, position: 0.0, arrive: Ease::Flat(0.1), leave: handle(0.25) };
        let to = Key { time: 1.0, position: 1.0, arrive: handle(-0.5), leave: Ease::Flat(0.1) };
        let (first, last) = Segment::between(&from, &to).unwrap().keys();
        assert_eq!((first, last), (Key { arrive: Ease::Linear, ..from }, Key { leave: Ease::Linear, ..to }));
    }
}
