//! Move that is played from its end to its begin, as a move that is played forward (decision K-J7).

use super::blocks::{Block, Blocks, Segment, TrajectoryData};
use super::error::{MoveError, Place};
use super::values::{Point, Points};
use super::view::Trajectory;
use crate::message::Normalized;

impl TrajectoryData<'_> {
    /// Bytes that [`reversed`](Self::reversed) needs; the message takes seven more.
    #[must_use]
    pub fn reversed_len(&self) -> usize {
        self.blocks.iter().map(|block| block.encoded_len()).fold(0, usize::saturating_add)
    }

    /// Same move from its end to its begin, written to the front of `out`.
    ///
    /// The specification asks for direction 0 in every start, and a device may ignore any other. So a move is not played in
    /// reverse by its direction; its curves are mirrored in time instead, and the move is played forward. Each motor goes
    /// through the same positions in the opposite order. All settings stay: a loop still comes back to where it began.
    ///
    /// Positions are unchanged. A time is a `Float32` part of the move, and so is 1 less this time, rounded to the nearest.
    /// The difference is less than one part in 16 million of the move, and it is the same where two segments meet.
    ///
    /// # Errors
    ///
    /// [`MoveError`] if the blocks are not a move, if the mirrored curves are not one because of that rounding, or if they do
    /// not fit into `out`.
    pub fn reversed<'o>(&self, out: &'o mut [u8]) -> Result<TrajectoryData<'o>, MoveError> {
        Trajectory::new(self)?;
        let blocks = self.blocks.iter().map(|block| match block {
            Block::Segment(segment) => self.mirror_of(segment).map(Block::Segment),
            block => Ok(block),
        });
        let blocks = Blocks::write(self.blocks.len(), self.reversed_len(), blocks, out)?;
        let reversed = TrajectoryData { blocks, tail: &[] };
        Trajectory::new(&reversed)?;
        Ok(reversed)
    }

    /// Segment that takes the place of another: the one that is as far from the end of its motor's way, mirrored.
    fn mirror_of<'s>(&'s self, place: Segment<'s>) -> Result<Segment<'s>, MoveError> {
        let Segment { motor_address, segment_number, .. } = place;
        let of_motor = || self.blocks.segments_of(motor_address);
        let last = of_motor().map(|segment| segment.segment_number).max().unwrap_or(segment_number);
        let number = last.saturating_sub(segment_number);
        let place = Place::Segment(motor_address, number);
        let missing = MoveError::Contradiction { place, what: "segment", note: "is missing" };
        let source = of_motor().find(|segment| segment.segment_number == number).ok_or(missing)?;
        Ok(Segment { points: mirrored(source.points), segment_number, motor_address, tail: source.tail })
    }
}

/// Curve from its end to its begin.
fn mirrored(Points([begin, out, into, end]): Points) -> Points {
    let mirror = |point: Point| Point { time: Normalized(1.0 - point.time.0), position: point.position };
    Points([end, into, out, begin].map(mirror))
}
