//! Errors of moves, in one line that says how to correct them.

use std::io;

use motion_core::trajectory::{AxisError, StepsOutOfRange};

use crate::moves::{MOST_AXES, MOST_FRAMES};
use crate::text::one_line;

/// Why a file cannot be read as a move. The text is one line that begins with the name of the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MoveError {
    /// The file cannot be read.
    #[error("{name}: {error}")]
    Unreadable {
        /// Name of the file.
        name: String,
        /// Error of the operating system.
        #[source]
        error: io::Error,
    },
    /// The file is not JSON, or a part of it is wrong.
    #[error("{name}, line {line}, column {column}: {what}")]
    Wrong {
        /// Name of the file.
        name: String,
        /// Line where the wrong part ends, from 1.
        line: usize,
        /// Byte of the line where the wrong part ends, from 1.
        column: usize,
        /// Problem, and how to correct it.
        what: String,
    },
    /// The parts of the file are valid, but do not fit together.
    #[error("{name}: {problem}")]
    Unfit {
        /// Name of the file.
        name: String,
        /// Problem, and how to correct it.
        #[source]
        problem: MoveProblem,
    },
}

/// Why parts cannot form a move. The text is one line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MoveProblem {
    /// The move has no axis.
    #[error("there is no axis: \"axes\" needs one")]
    NoAxis,
    /// The move has this number of axes, which is too great.
    #[error("{0} axes are too many: at most {MOST_AXES}")]
    ManyAxes(usize),
    /// Two axes have this name.
    #[error("two axes have the name {0:?}: give each its own name")]
    Twice(String),
    /// Two axes have the same motor.
    #[error("axes {one:?} and {other:?} have the same {protocol} motor: give each its own")]
    Shared {
        /// Protocol of the motor.
        protocol: &'static str,
        /// Name of the first axis.
        one: String,
        /// Name of the second axis.
        other: String,
    },
    /// The move ends before a key frame.
    #[error(
        "\"duration\" is {duration} s, but axis {axis:?} has a key frame at {key} s: make it longer, or leave it out"
    )]
    Short {
        /// Duration of the move, in seconds.
        duration: f64,
        /// Name of the axis.
        axis: String,
        /// Time of its last key frame, in seconds.
        key: f64,
    },
    /// The move has more frames than DMC can count.
    #[error("{frames} frames are too many: at most {MOST_FRAMES} can be sent")]
    Long {
        /// Number of frames.
        frames: f64,
    },
    /// The name of the move is not valid.
    #[error(transparent)]
    Label(#[from] LabelError),
    /// An axis is not valid.
    #[error("axis {axis:?}: {problem}")]
    Axis {
        /// Name of the axis.
        axis: String,
        /// Problem of the axis.
        #[source]
        problem: AxisProblem,
    },
}

/// Error: a text cannot be a name or a unit.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{}\" cannot be a name or unit: it needs 1 to {most} visible characters", one_line(text))]
pub struct LabelError {
    /// The text.
    pub text: String,
    /// Greatest length, in characters.
    pub most: usize,
}

/// Why parts cannot form an axis. Key frames are counted from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AxisProblem {
    /// The axis has this number of key frames, which is too small.
    #[error("{0} key frames are too few: an axis needs two")]
    Few(usize),
    /// The key frame is before the start of the move.
    #[error("key frame {key} at {time} s is before the start of the move: times are 0 or more")]
    Early {
        /// Number of the key frame.
        key: usize,
        /// Its time, in seconds.
        time: f64,
    },
    /// The key frame is not later than the key frame before it.
    #[error("key frame {key} at {time} s is not later than the one before it: put them in the order of time")]
    Order {
        /// Number of the key frame.
        key: usize,
        /// Its time, in seconds.
        time: f64,
    },
    /// A handle of the key frame reaches beyond the other key frame, or away from it.
    #[error(
        "key frame {key} at {time} s: a handle reaches beyond the other key frame, or away from it: [seconds, units] is its distance, with negative seconds to arrive"
    )]
    Handle {
        /// Number of the key frame.
        key: usize,
        /// Its time, in seconds.
        time: f64,
    },
    /// An ease of the key frame is not a number from 0 to 1, or a handle of it is not finite.
    #[error("key frame {key} at {time} s: an ease is a number from 0 to 1, or a handle of finite numbers")]
    Ease {
        /// Number of the key frame.
        key: usize,
        /// Its time, in seconds.
        time: f64,
    },
    /// The time or the position of the key frame is not finite, or the curve from it to the next one is out of range.
    #[error("key frame {key}: a time or a position is out of range")]
    Range {
        /// Number of the key frame.
        key: usize,
    },
    /// Segments do not form an axis.
    #[error(transparent)]
    Axis(#[from] AxisError),
    /// Limits are not all more than 0.
    #[error("each of the \"limits\" must be more than 0")]
    Limits,
    /// The name or the unit of the axis is not valid.
    #[error(transparent)]
    Label(#[from] LabelError),
    /// A motor is not valid.
    #[error(transparent)]
    Motor(#[from] MotorProblem),
    /// The curve leaves the range of the kOS motor.
    #[error("\"kos\": {rotations} rotations at position {position} are beyond its \"range\"")]
    Beyond {
        /// Position, in units of the axis.
        position: f64,
        /// Rotations of the motor there.
        rotations: f64,
    },
    /// The curve has a position whose steps do not fit 32 bits.
    #[error("{protocol:?}: at position {position}, {error}: use fewer steps per unit")]
    Steps {
        /// Protocol of the motor.
        protocol: &'static str,
        /// Position, in units of the axis.
        position: f64,
        /// Steps of the motor there.
        #[source]
        error: StepsOutOfRange,
    },
}

/// Why a motor cannot move an axis. The text names the protocol.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MotorProblem {
    /// A number or an address is out of its range.
    #[error("\"{protocol}\" has {what} {number}: it is a number from {least} to {most}")]
    Number {
        /// Protocol of the motor.
        protocol: &'static str,
        /// Name of the member of the file.
        what: &'static str,
        /// Its number.
        number: u8,
        /// Least number.
        least: u8,
        /// Greatest number.
        most: u8,
    },
    /// The scale or the range of a kOS motor is 0, or not finite.
    #[error("\"kos\" needs \"rotations_per_unit\" other than 0, and a \"range\" with different ends")]
    Range,
    /// The scale of a motor is 0, or not finite.
    #[error("\"{protocol}\" needs \"steps_per_unit\" other than 0")]
    Scale {
        /// Protocol of the motor.
        protocol: &'static str,
    },
}
