//! What keeps blocks from being a move, or a plan from becoming one.

use core::fmt;

use motion_core::unit;
use motion_core::wire::EncodeError;

use super::values::Point;
use crate::message::{MotorAddress, Rotations};

unit! {
    /// The number that an error is about, in the unit of its field.
    pub struct Amount(f32) "";
}

impl Amount {
    /// The nearest to a number that is computed with, infinite if that is too great.
    #[expect(clippy::cast_possible_truncation, reason = "only shown")]
    pub(super) const fn shown(number: f64) -> Self {
        Self(number as f32)
    }
}

/// Where in a move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Place {
    /// In what is said of the move as a whole.
    Move,
    /// In what is said of a motor.
    Motor(MotorAddress),
    /// In a segment of a motor, counted from 0: the one that a key frame of this number begins.
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

/// What is wrong with a move, where, and how much. Decisions K-J1 to K-J10.
#[derive(Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum MoveError {
    /// A number that no move has.
    #[error("{place}: {what}: {value} {note}")]
    Number {
        /// Where.
        place: Place,
        /// The field.
        what: &'static str,
        /// The number.
        value: Amount,
        /// What is wrong with it.
        note: &'static str,
    },
    /// A number that is infinite, or none at all (decision K-N1).
    #[error("{place}: {what}: {bits:#010x} is no finite number")]
    NotFinite {
        /// Where.
        place: Place,
        /// The field.
        what: &'static str,
        /// Its bits.
        bits: u32,
    },
    /// Something that contradicts the rest of the move: missing, there twice, or of no use.
    #[error("{place}: {what} {note}")]
    Contradiction {
        /// Where.
        place: Place,
        /// The block or the field.
        what: &'static str,
        /// What is wrong with it.
        note: &'static str,
    },
    /// No motor takes part, and nobody said that this is meant (decision K-J1).
    #[error("move: no motor takes part")]
    NoMotors,
    /// A motor that no device has, or all of them at once (decision K-M1).
    #[error("motor {motor}: not one of 1 to 10")]
    Address {
        /// The motor.
        motor: MotorAddress,
    },
    /// A motor whose range is not known, so that nothing can be a part of it (decision K-J9).
    #[error("motor {motor}: not calibrated")]
    Uncalibrated {
        /// The motor.
        motor: MotorAddress,
    },
    /// A motor has not as many segments as its axis says (decision K-J9).
    #[error("motor {motor}: {have} segments, not {said}")]
    SegmentCount {
        /// The motor.
        motor: MotorAddress,
        /// Segments that its axis says it has.
        said: u8,
        /// Segments that it has.
        have: u8,
    },
    /// A key frame outside the motor's range.
    #[error("{place}: {position} rev is not in 0 to {range}")]
    Outside {
        /// Where.
        place: Place,
        /// The position of the key frame.
        position: Rotations,
        /// Where the range ends.
        range: Rotations,
    },
    /// A segment does not begin where the one before it ends (decision K-J8).
    #[error("{place}: begins at {begin}, the segment before ends at {end}")]
    Apart {
        /// Where.
        place: Place,
        /// The end of the segment before.
        end: Point,
        /// The begin of this one.
        begin: Point,
    },
    /// A rapid way back that takes another time than the move, which the specification advises against (decision K-J5).
    #[error("move: rapid_reverse_duration: {value} s, not as long as the move")]
    OtherRapidReverse {
        /// Seconds that it takes.
        value: Amount,
    },
    /// A moment as IEEE number, which a device that reads an integer takes for one long past (safety decision 5).
    #[error("move: a moment as IEEE number may start the move at once")]
    FloatMoment,
    /// A moment that would be read as another one (decision K-J3).
    #[error("move: the moment {seconds} {note}")]
    Moment {
        /// Seconds since 1970.
        seconds: u32,
        /// What is wrong with it.
        note: &'static str,
    },
    /// A number that the specification does not name, so that nobody knows what it does.
    #[error("move: {what}: {value} has no meaning in the specification")]
    Unnamed {
        /// The field.
        what: &'static str,
        /// The number.
        value: u8,
    },
    /// More blocks than can be counted (decision K-J2).
    #[error("move: {needed} blocks, at most 255 can be counted")]
    TooManyBlocks {
        /// Blocks of the move.
        needed: usize,
    },
    /// The blocks could not be written.
    #[error("{0}")]
    Encode(#[from] EncodeError),
}

impl MoveError {
    /// A number that no move has.
    pub(super) const fn number(place: Place, what: &'static str, value: f32, note: &'static str) -> Self {
        Self::Number { place, what, value: Amount(value), note }
    }
}

// A derived one would print texts with escapes, which cannot be proven free of panics.
impl fmt::Debug for MoveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "MoveError({self})")
    }
}
