//! Errors of blocks that are not a move, and of plans that cannot become one.

use core::fmt;

use motion_core::unit;
use motion_core::wire::EncodeError;

use super::values::Point;
use crate::message::{MotorAddress, Rotations};

unit! {
    /// Number that an error reports, in the unit of its field.
    pub struct Amount(f32) "";
}

impl Amount {
    /// Nearest amount to a number of a computation; infinite if that number is too great.
    #[expect(clippy::cast_possible_truncation, reason = "only shown")]
    pub(super) const fn shown(number: f64) -> Self {
        Self(number as f32)
    }
}

/// Place of an error in a move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Place {
    /// The move as a whole.
    Move,
    /// One motor.
    Motor(MotorAddress),
    /// One segment of a motor, counted from 0. A key frame with this number starts it.
    Segment(MotorAddress, u8),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Move => f.write_str("move"),
            Self::Motor(motor) => write!(f, "motor {motor}"),
            Self::Segment(motor, number) => write!(f, "motor {motor}, segment {number}"),
        }
    }
}

/// Error in a move: the fault, its place and its size. Decisions K-J1 to K-J10.
#[derive(Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum MoveError {
    /// A number that is not allowed in a move.
    #[error("{place}: {what}: {value} {note}")]
    Number {
        /// Place of the error.
        place: Place,
        /// Name of the field.
        what: &'static str,
        /// Value of the field.
        value: Amount,
        /// Text that says what is wrong with the value.
        note: &'static str,
    },
    /// A number that is NaN or infinite (decision K-N1).
    #[error("{place}: {what}: {bits:#010x} is no finite number")]
    NotFinite {
        /// Place of the error.
        place: Place,
        /// Name of the field.
        what: &'static str,
        /// Bits of the number.
        bits: u32,
    },
    /// A block or field that contradicts the rest of the move: missing, present twice, or without use.
    #[error("{place}: {what} {note}")]
    Contradiction {
        /// Place of the error.
        place: Place,
        /// Name of the block or field.
        what: &'static str,
        /// Text that says what is wrong with it.
        note: &'static str,
    },
    /// No motor takes part, and the plan did not ask for that (decision K-J1).
    #[error("move: no motor takes part")]
    NoMotors,
    /// An address that no device has, or the address of all motors (decision K-M1).
    #[error("motor {motor}: not one of 1 to 10")]
    Address {
        /// Motor address.
        motor: MotorAddress,
    },
    /// A motor whose range is not known, so that no position can be a part of it (decision K-J9).
    #[error("motor {motor}: not calibrated")]
    Uncalibrated {
        /// Motor address.
        motor: MotorAddress,
    },
    /// A motor whose number of segments differs from the number in its axis block (decision K-J9).
    #[error("motor {motor}: {have} segments, not {said}")]
    SegmentCount {
        /// Motor address.
        motor: MotorAddress,
        /// Number of segments in the axis block.
        said: u8,
        /// Number of segment blocks.
        have: u8,
    },
    /// A key frame outside the motor's range.
    #[error("{place}: {position} rev is not in 0 to {range}")]
    Outside {
        /// Place of the error.
        place: Place,
        /// Position of the key frame.
        position: Rotations,
        /// End of the range.
        range: Rotations,
    },
    /// A segment that does not start where the segment before it ends (decision K-J8).
    #[error("{place}: starts at {begin}, the segment before ends at {end}")]
    Apart {
        /// Place of the error.
        place: Place,
        /// End of the segment before.
        end: Point,
        /// Start of this segment.
        begin: Point,
    },
    /// A rapid way back that takes another time than the move. The specification advises against it (decision K-J5).
    #[error("move: rapid_reverse_duration: {value} s is not the duration of the move")]
    OtherRapidReverse {
        /// Time of the way back, in seconds.
        value: Amount,
    },
    /// A moment written as an IEEE number. A device that reads an integer takes it for a moment long past (safety
    /// decision 5).
    #[error("move: a moment written as an IEEE number may start the move at once")]
    FloatMoment,
    /// A moment that would be read as another moment (decision K-J3).
    #[error("move: the moment {seconds} {note}")]
    Moment {
        /// Moment in seconds since 1970.
        seconds: u32,
        /// Text that says what is wrong with it.
        note: &'static str,
    },
    /// A number to which the specification gives no meaning.
    #[error("move: {what}: {value} has no meaning in the specification")]
    Unnamed {
        /// Name of the field.
        what: &'static str,
        /// Value of the field.
        value: u8,
    },
    /// More blocks than the count field can hold (decision K-J2).
    #[error("move: {needed} blocks, at most 255 can be counted")]
    TooManyBlocks {
        /// Number of blocks that the move needs.
        needed: usize,
    },
    /// An error while the blocks are written.
    #[error("{0}")]
    Encode(#[from] EncodeError),
}

impl MoveError {
    /// Makes an error about a number that is not allowed in a move.
    pub(super) const fn number(place: Place, what: &'static str, value: f32, note: &'static str) -> Self {
        Self::Number { place, what, value: Amount(value), note }
    }
}

// A derived `Debug` would print texts with escapes, which cannot be proven free of panics.
impl fmt::Debug for MoveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "MoveError({self})")
    }
}
