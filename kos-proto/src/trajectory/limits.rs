//! Limits of motors, and the speeds and accelerations that a move needs.

use core::fmt;

use super::error::{Amount, Place};
use crate::message::{AxisKind, Motor, MotorAddress, RotationsPerSecond, RotationsPerSecondSquared};

/// Greatest speed and acceleration of a segment, in the units of its track. `None` if it is unbounded, at a vertical
/// tangent or where time runs backward.
#[derive(Clone, Copy, PartialEq)]
pub struct Peaks {
    /// Number of the segment, from 0.
    pub segment: u8,
    /// Greatest speed in either direction.
    pub speed: Option<f64>,
    /// Greatest acceleration in either direction.
    pub acceleration: Option<f64>,
}

// The printing of `f64` in core cannot be proven free of panics.
impl fmt::Debug for Peaks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Peaks")
            .field("segment", &self.segment)
            .field("speed", &self.speed.map(Amount::shown))
            .field("acceleration", &self.acceleration.map(Amount::shown))
            .finish()
    }
}

/// Limits of a motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Limits {
    /// Greatest speed, in rotations per second.
    pub speed: RotationsPerSecond,
    /// Greatest acceleration, in rotations per second².
    pub acceleration: RotationsPerSecondSquared,
}

impl Limits {
    /// Smaller of two limits, for speed and acceleration each: those of a motor and of the axis that it drives
    /// (decision K-M6).
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self {
            speed: RotationsPerSecond(lesser(self.speed.0, other.speed.0)),
            acceleration: RotationsPerSecondSquared(lesser(self.acceleration.0, other.acceleration.0)),
        }
    }

    /// Speed and acceleration of a segment that exceed the limits. A limit that is NaN allows nothing.
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

/// Limits of the specification for a kind of axis; infinite if it names none.
impl From<AxisKind> for Limits {
    fn from(kind: AxisKind) -> Self {
        Self {
            speed: kind.max_speed().unwrap_or(RotationsPerSecond(f32::INFINITY)),
            acceleration: kind.max_acceleration().unwrap_or(RotationsPerSecondSquared(f32::INFINITY)),
        }
    }
}

/// Smaller of two numbers. `min` would prefer any number to NaN, but a limit that is NaN has to allow nothing.
const fn lesser(one: f32, other: f32) -> f32 {
    if one < other || one.is_nan() { one } else { other }
}

/// The peak if it exceeds the limit; infinite if the peak is unbounded.
fn beyond(peak: Option<f64>, limit: f32) -> Option<f32> {
    let peak = peak.unwrap_or(f64::INFINITY);
    let allowed = peak <= f64::from(limit);
    (!allowed).then_some(Amount::shown(peak).0)
}

/// Part of a move that a motor cannot do: its place and its size.
#[derive(Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum Excess {
    /// A motor that the device does not have.
    #[error("motor {motor}: the device has no such motor")]
    Absent {
        /// Motor address.
        motor: MotorAddress,
    },
    /// A motor whose range is not known, so that no position can be a part of it (decision K-J9).
    #[error("motor {motor}: not calibrated")]
    Uncalibrated {
        /// Motor address.
        motor: MotorAddress,
    },
    /// A speed above the limit.
    #[error("{place}: {speed} rev/s, at most {limit}")]
    Speed {
        /// Place in the move.
        place: Place,
        /// Greatest speed there, in rotations per second; may be infinite.
        speed: RotationsPerSecond,
        /// Greatest speed allowed.
        limit: RotationsPerSecond,
    },
    /// An acceleration above the limit.
    #[error("{place}: {acceleration} rev/s², at most {limit}")]
    Acceleration {
        /// Place in the move.
        place: Place,
        /// Greatest acceleration there, in rotations per second²; may be infinite.
        acceleration: RotationsPerSecondSquared,
        /// Greatest acceleration allowed.
        limit: RotationsPerSecondSquared,
    },
}

// A derived `Debug` cannot be proven free of panics.
impl fmt::Debug for Excess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Excess({self})")
    }
}
