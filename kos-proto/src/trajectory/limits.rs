//! What motors can do, and what a move asks of them.

use core::fmt;

use super::error::{Amount, Place};
use crate::message::{AxisKind, Motor, MotorAddress, RotationsPerSecond, RotationsPerSecondSquared};

/// The greatest speed and acceleration of a segment, in the units of its track; `None` where there is no limit to it: at
/// a vertical tangent, or where time folds back.
#[derive(Clone, Copy, PartialEq)]
pub struct Peaks {
    /// Which segment, from 0.
    pub segment: u8,
    /// The greatest speed, either way.
    pub speed: Option<f64>,
    /// The greatest acceleration, either way.
    pub acceleration: Option<f64>,
}

// The printing of core for `f64` cannot be proven free of panics.
impl fmt::Debug for Peaks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Peaks")
            .field("segment", &self.segment)
            .field("speed", &self.speed.map(Amount::shown))
            .field("acceleration", &self.acceleration.map(Amount::shown))
            .finish()
    }
}

/// What a motor can do at most.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Limits {
    /// The greatest speed.
    pub speed: RotationsPerSecond,
    /// The greatest acceleration.
    pub acceleration: RotationsPerSecondSquared,
}

impl Limits {
    /// The smaller ones of both: of the motor, and of what it carries (decision K-M6).
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self {
            speed: RotationsPerSecond(lesser(self.speed.0, other.speed.0)),
            acceleration: RotationsPerSecondSquared(lesser(self.acceleration.0, other.acceleration.0)),
        }
    }

    /// What of a segment is beyond them; a limit that is not a number allows nothing.
    pub(super) fn exceeded(self, motor: MotorAddress, peaks: Peaks) -> impl Iterator<Item = Excess> {
        let place = Place::Segment(motor, peaks.segment);
        let speed = beyond(peaks.speed, self.speed.0).map(RotationsPerSecond);
        let acceleration = beyond(peaks.acceleration, self.acceleration.0).map(RotationsPerSecondSquared);
        let speed = speed.map(|speed| Excess::Speed { place, speed, limit: self.speed });
        let acceleration =
            acceleration.map(|acceleration| Excess::Acceleration { place, acceleration, limit: self.acceleration });
        speed.into_iter().chain(acceleration)
    }
}

impl From<&Motor> for Limits {
    fn from(motor: &Motor) -> Self {
        Self { speed: motor.max_max_move_speed, acceleration: motor.max_max_acceleration }
    }
}

/// What the specification allows a kind of axis; infinite where it says nothing.
impl From<AxisKind> for Limits {
    fn from(kind: AxisKind) -> Self {
        Self {
            speed: kind.max_speed().unwrap_or(RotationsPerSecond(f32::INFINITY)),
            acceleration: kind.max_acceleration().unwrap_or(RotationsPerSecondSquared(f32::INFINITY)),
        }
    }
}

/// The smaller one. Not `min`, which prefers any number to what is none: such a limit allows nothing.
const fn lesser(one: f32, other: f32) -> f32 {
    if one < other || one.is_nan() { one } else { other }
}

/// The peak, if it is beyond the limit; infinite, if there is no limit to it.
fn beyond(peak: Option<f64>, limit: f32) -> Option<f32> {
    let peak = peak.unwrap_or(f64::INFINITY);
    let allowed = peak <= f64::from(limit);
    (!allowed).then_some(Amount::shown(peak).0)
}

/// What a motor cannot do of a move, where, and how much.
#[derive(Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum Excess {
    /// The device has no such motor.
    #[error("motor {motor}: none of the device's motors")]
    Absent {
        /// The motor.
        motor: MotorAddress,
    },
    /// The range is not known, so that nothing can be a part of it (decision K-J9).
    #[error("motor {motor}: not calibrated")]
    Uncalibrated {
        /// The motor.
        motor: MotorAddress,
    },
    /// It would have to be too fast.
    #[error("{place}: {speed} rev/s, at most {limit}")]
    Speed {
        /// Where.
        place: Place,
        /// The greatest speed there, which may be infinite.
        speed: RotationsPerSecond,
        /// The greatest that is allowed.
        limit: RotationsPerSecond,
    },
    /// It would have to change its speed too fast.
    #[error("{place}: {acceleration} rev/s², at most {limit}")]
    Acceleration {
        /// Where.
        place: Place,
        /// The greatest acceleration there, which may be infinite.
        acceleration: RotationsPerSecondSquared,
        /// The greatest that is allowed.
        limit: RotationsPerSecondSquared,
    },
}

// A derived one cannot be proven free of panics.
impl fmt::Debug for Excess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Excess({self})")
    }
}
