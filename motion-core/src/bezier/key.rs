//! Key frames: how people give a curve.

use super::{OutOfRange, Point, Segment};

/// How an axis leaves a key frame, or arrives at it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ease {
    /// Straight for the other key frame: the handle lies a third of the way there.
    Linear,
    /// From rest or to rest: the handle is flat, and as long as this part of the time between the
    /// key frames. 0 draws the handle back into the key frame; time folds beyond 1.
    Flat(f64),
    /// Any handle, as its distance from the key frame: time and position; backwards for arriving.
    Handle(Point),
}

impl Ease {
    /// The handle at `key` on the way to `other`.
    fn handle(self, key: Point, other: Point) -> Point {
        match self {
            Self::Linear => key.toward(other, 1.0 / 3.0),
            Self::Flat(part) => Point { time: key.time + part * (other.time - key.time), ..key },
            Self::Handle(Point { time, position }) => Point::new(key.time + time, key.position + position),
        }
    }
}

/// A key frame: where the axis is at a time, and how it gets there and on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// The time.
    pub time: f64,
    /// The position.
    pub position: f64,
    /// How the axis arrives, if a segment ends here.
    pub arrive: Ease,
    /// How the axis leaves, if a segment starts here.
    pub leave: Ease,
}

impl Key {
    fn point(&self) -> Point {
        Point::new(self.time, self.position)
    }
}

impl Segment {
    /// The segment from one key frame to the next.
    ///
    /// # Errors
    ///
    /// [`OutOfRange`] as for [`Segment::new`].
    pub fn between(from: &Key, to: &Key) -> Result<Self, OutOfRange> {
        let (first, last) = (from.point(), to.point());
        Self::new([first, from.leave.handle(first, last), to.arrive.handle(last, first), last])
    }

    /// The key frames at both ends, with the handles as they are; beyond them it goes on straight.
    ///
    /// [`Segment::between`] them is this segment, its handles within the rounding of one subtraction
    /// and one addition.
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
