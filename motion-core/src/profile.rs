//! Moves from rest to rest, as fast as limits allow: trapezoids of velocity, and S-curves.
//!
//! With a limit of velocity and acceleration alone, velocity over time is a trapezoid, or a triangle
//! where the way is too short for full speed. A limit of jerk rounds its corners to an S-curve of up to
//! seven parts. Position, velocity and acceleration at a time are closed formulas; nothing is stepped.
//!
//! ```
//! use motion_core::profile::{Limits, MotionProfile};
//!
//! let limits = Limits { velocity: 20.0, acceleration: 10.0, jerk: None };
//! let pan = MotionProfile::new(0.0, 90.0, limits)?;
//! // 2 s to full speed, 2.5 s at it, 2 s to rest.
//! assert_eq!(pan.duration(), 6.5);
//! assert_eq!(pan.at(2.0).velocity, 20.0);
//! assert_eq!(pan.at(6.5).position, 90.0);
//!
//! let soft = MotionProfile::new(0.0, 90.0, Limits { jerk: Some(20.0), ..limits })?;
//! assert_eq!(soft.duration(), 7.0);
//! # Ok::<(), motion_core::profile::MotionProfileError>(())
//! ```
//!
//! # What holds
//!
//! - A move starts and ends exactly where it shall, and runs the same backwards:
//!   what is left at `duration() - t` is what was gone at `t`.
//! - No velocity and no acceleration exceeds its limit.
//! - No move within the limits takes less time.

use crate::bezier::print::{Shown, debug_numbers};

/// How fast an axis may be, how fast that may change, and how fast that may change in turn.
#[derive(Clone, Copy, PartialEq)]
pub struct Limits {
    /// The greatest velocity, in units a second (of the caller's units); more than 0.
    pub velocity: f64,
    /// The greatest acceleration, in units a second squared; more than 0.
    pub acceleration: f64,
    /// The greatest jerk, in units a second cubed, more than 0; `None` for no limit, a trapezoid.
    pub jerk: Option<f64>,
}

/// Why there is no profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum MotionProfileError {
    /// A position is infinite or not a number.
    #[error("move: a position is not finite")]
    NotFinite,
    /// A limit is infinite, not a number, 0 or less.
    #[error("move: a limit is not finite and more than 0")]
    Limit,
    /// The way or a time of the move is beyond what `f64` holds, or too small for it.
    #[error("move: way or time out of range")]
    OutOfRange,
}

/// Where an axis is on its move, and how fast. All numbers are finite.
#[derive(Clone, Copy, Default, PartialEq)]
pub struct State {
    /// The position.
    pub position: f64,
    /// The velocity; negative on the way to a smaller position.
    pub velocity: f64,
    /// The acceleration; negative where a velocity that is positive falls.
    pub acceleration: f64,
}

/// A move from one position to another, at rest before and after.
#[derive(Clone, Copy, PartialEq)]
pub struct MotionProfile {
    from: f64,
    to: f64,
    limits: Limits,
    /// The acceleration that is reached, and the velocity.
    acceleration: f64,
    velocity: f64,
    /// How long acceleration grows, and as long shrinks: 0 without a limit of jerk.
    growing: f64,
    /// How long acceleration holds.
    holding: f64,
    /// How long velocity holds.
    cruising: f64,
}

debug_numbers! {
    Limits { velocity, acceleration, jerk }
    State { position, velocity, acceleration }
    MotionProfile { from, to, limits, acceleration, velocity, growing, holding, cruising }
}

impl Shown for Limits {
    fn shown(&self) -> impl core::fmt::Debug {
        *self
    }
}

impl MotionProfile {
    /// The fastest move within the limits.
    ///
    /// # Errors
    ///
    /// [`MotionProfileError`] says what is not finite, not positive or out of range.
    pub fn new(from: f64, to: f64, limits: Limits) -> Result<Self, MotionProfileError> {
        if !(from.is_finite() && to.is_finite()) {
            return Err(MotionProfileError::NotFinite);
        }
        let sound = |limit: f64| limit.is_finite() && limit > 0.0;
        if !(sound(limits.velocity) && sound(limits.acceleration) && limits.jerk.is_none_or(sound)) {
            return Err(MotionProfileError::Limit);
        }
        let way = (to - from).abs();
        let [growing, holding, cruising] = if way == 0.0 { [0.0; 3] } else { times(way, &limits) };
        let acceleration = match limits.jerk {
            Some(jerk) => (jerk * growing).min(limits.acceleration),
            None => limits.acceleration,
        };
        let velocity = (acceleration * (growing + holding)).min(limits.velocity);
        let profile = Self { from, to, limits, acceleration, velocity, growing, holding, cruising };
        let moves = way == 0.0 || (velocity > 0.0 && acceleration > 0.0 && profile.duration() > 0.0);
        if moves && way.is_finite() && velocity.is_finite() && profile.duration().is_finite() {
            Ok(profile)
        } else {
            Err(MotionProfileError::OutOfRange)
        }
    }

    /// The time of the whole move.
    #[must_use]
    pub fn duration(&self) -> f64 {
        2.0 * self.speeding() + self.cruising
    }

    /// The position at the start.
    #[must_use]
    pub const fn start(&self) -> f64 {
        self.from
    }

    /// The position at the end.
    #[must_use]
    pub const fn target(&self) -> f64 {
        self.to
    }

    /// The limits it was made for.
    #[must_use]
    pub const fn limits(&self) -> Limits {
        self.limits
    }

    /// The greatest velocity of the move, without a sign.
    #[must_use]
    pub const fn peak_velocity(&self) -> f64 {
        self.velocity
    }

    /// Position, velocity and acceleration at a time after the start; at rest before and after.
    ///
    /// A time that is not a number is taken as one before the start. In a trapezoid, acceleration jumps;
    /// at a jump it is that of the part nearer to the middle of the move.
    #[must_use]
    pub fn at(&self, time: f64) -> State {
        let (left, sign) = (self.duration() - time, if self.to < self.from { -1.0 } else { 1.0 });
        if time.is_nan() || time < 0.0 || self.duration() == 0.0 {
            return State { position: self.from, ..State::default() };
        }
        if left < 0.0 {
            return State { position: self.to, ..State::default() };
        }
        // The second half is the first one backwards.
        let (begin, side, time) = if time <= left { (self.from, sign, time) } else { (self.to, -sign, left) };
        let (gone, velocity, acceleration) = self.first_half(time);
        // Rounding must not lead beyond the ends of a short way between large numbers.
        let (least, most) = (self.from.min(self.to), self.from.max(self.to));
        State {
            // Not `clamp`, which panics where the ends are no numbers.
            position: (begin + side * gone).max(least).min(most),
            velocity: sign * velocity.min(self.velocity),
            acceleration: side * acceleration.min(self.acceleration),
        }
    }

    /// How long it takes to full speed.
    fn speeding(&self) -> f64 {
        2.0 * self.growing + self.holding
    }

    /// Way, velocity and acceleration, without signs, at a time up to half the duration.
    fn first_half(&self, time: f64) -> (f64, f64, f64) {
        let (speeding, top) = (self.speeding(), self.velocity);
        if time < self.growing {
            let acceleration = self.acceleration * (time / self.growing);
            let velocity = 0.5 * acceleration * time;
            (velocity * time / 3.0, velocity, acceleration)
        } else if time < self.growing + self.holding {
            // As if acceleration had begun in full after half of its growing.
            let since = time - 0.5 * self.growing;
            let velocity = self.acceleration * since;
            let lag = self.acceleration * self.growing * self.growing / 24.0;
            (0.5 * velocity * since + lag, velocity, self.acceleration)
        } else if time < speeding {
            // From full speed backwards: the way that full speed would have gone, less what is missing.
            let left = speeding - time;
            let acceleration = self.acceleration * (left / self.growing);
            let missing = 0.5 * acceleration * left;
            let gone = top * (time - 0.5 * speeding) + missing * left / 3.0;
            (gone, top - missing, acceleration)
        } else {
            (top * (time - 0.5 * speeding), top, 0.0)
        }
    }
}

/// How long acceleration grows, how long it holds, and how long velocity holds.
///
/// Speeding up and slowing down take the same way, half the top velocity times the time each. So with
/// the top velocity `a (g + h)` both together take `a (g + h) (2 g + h)`.
fn times(way: f64, limits: &Limits) -> [f64; 3] {
    let (velocity, acceleration) = (limits.velocity, limits.acceleration);
    let full = velocity / acceleration;
    // How long acceleration grows to its limit; where jerk has no limit, no time.
    let growing = limits.jerk.map_or(0.0, |jerk| acceleration / jerk);
    let (growing, holding) = match limits.jerk {
        // Full speed comes before full acceleration.
        Some(jerk) if growing >= full => (libm::sqrt(velocity / jerk), 0.0),
        _ => (growing, full - growing),
    };
    let cruising = way / velocity - (2.0 * growing + holding);
    if cruising >= 0.0 {
        return [growing, holding, cruising];
    }
    // Full speed is not reached. If acceleration holds, its time solves the quadratic above.
    let square = way / acceleration;
    let holding =
        2.0 * (square - 2.0 * growing * growing) / (3.0 * growing + libm::sqrt(growing * growing + 4.0 * square));
    match limits.jerk {
        Some(jerk) if holding < 0.0 => [libm::cbrt(0.5 * way / jerk), 0.0, 0.0],
        _ => [growing, holding, 0.0],
    }
}
