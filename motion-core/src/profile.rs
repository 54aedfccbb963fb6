//! Motion profiles: moves to a position, from rest or from motion, as fast as limits allow.
//!
//! With limits of velocity and acceleration only, velocity over time is a trapezoid, or a triangle if the distance is
//! too short for full speed. With a limit of jerk, the profile is an S-curve of up to seven parts. Position, velocity
//! and acceleration at a time are computed by closed formulas, without simulation in steps.
//!
//! ```
//! use motion_core::profile::{Limits, MotionProfile, MotionState};
//!
//! let limits = Limits { velocity: 20.0, acceleration: 10.0, jerk: None };
//! let pan = MotionProfile::new(0.0, 90.0, limits)?;
//! // 2 s to full speed, 2.5 s at full speed, 2 s to rest.
//! assert_eq!(pan.duration(), 6.5);
//! assert_eq!(pan.at(2.0).velocity, 20.0);
//! assert_eq!(pan.at(6.5).position, 90.0);
//!
//! let soft = MotionProfile::new(0.0, 90.0, Limits { jerk: Some(20.0), ..limits })?;
//! assert_eq!(soft.duration(), 7.0);
//!
//! // The axis moves already. It stops within 5 units, or passes its new target by 5 units and comes back.
//! let moving = MotionState { position: 40.0, velocity: 10.0, acceleration: 0.0 };
//! assert_eq!(MotionProfile::stop(moving, limits)?.target(), 45.0);
//! let back = MotionProfile::from_motion(moving, 30.0, limits)?;
//! assert_eq!(back.at(1.0).position, 45.0);
//! assert_eq!(back.at(back.duration()).position, 30.0);
//! # Ok::<(), motion_core::profile::MotionProfileError>(())
//! ```
//!
//! # Guarantees
//!
//! - A move starts and ends exactly at its positions. A move from rest to rest is symmetric: the distance that is left
//!   at `duration() - t` is the distance travelled at `t`.
//! - Velocity and acceleration never exceed their limits. If an axis exceeds them at the start, it comes back within
//!   them first, by accelerations and a jerk within their limits.
//! - No faster move from rest to rest exists within the limits, and without a limit of jerk, no faster move from motion
//!   to rest.

mod moving;

use self::moving::Course;
use crate::bezier::print::{debug_numbers, shown_as_it_is};

/// Limits of an axis: velocity, acceleration and jerk.
#[derive(Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Limits {
    /// Greatest velocity, in the caller's units per second; more than 0.
    pub velocity: f64,
    /// Greatest acceleration, in units per second squared; more than 0.
    pub acceleration: f64,
    /// Greatest jerk, in units per second cubed, more than 0; `None` for no limit, which makes a trapezoid.
    pub jerk: Option<f64>,
}

/// Why a motion profile cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum MotionProfileError {
    /// A position, velocity or acceleration is NaN or infinite.
    #[error("move: a position, velocity or acceleration is not finite")]
    NotFinite,
    /// A limit is NaN, infinite, 0 or less.
    #[error("move: a limit is not finite and more than 0")]
    Limit,
    /// The distance or a time of the move is too large or too small for `f64`.
    #[error("move: distance or time out of range")]
    OutOfRange,
    /// The velocity at the end exceeds its limit.
    #[error("move: the velocity at the end exceeds its limit")]
    TooFast,
    /// The axis is beyond its target before it has the velocity, so it would have to go back first.
    #[error("move: the axis has to go back first to pass its target at this velocity")]
    GoesBack,
}

/// Position, velocity and acceleration of an axis during a move. All numbers are finite.
#[derive(Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MotionState {
    /// Position, in the caller's units.
    pub position: f64,
    /// Velocity, in units per second; negative towards smaller positions.
    pub velocity: f64,
    /// Acceleration, in units per second squared; negative when a positive velocity decreases.
    pub acceleration: f64,
}

/// Motion profile of a move to a position.
#[derive(Clone, Copy, PartialEq)]
pub struct MotionProfile {
    from: f64,
    to: f64,
    limits: Limits,
    /// The greatest velocity that is reached.
    velocity: f64,
    shape: Shape,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    /// From rest to rest.
    Rest(Halves),
    /// From motion, or to motion.
    Motion(Course),
}

/// Move from rest to rest, whose second half is the first half, reversed.
#[derive(Clone, Copy, PartialEq)]
struct Halves {
    from: f64,
    to: f64,
    /// The greatest acceleration and velocity that are reached.
    acceleration: f64,
    velocity: f64,
    /// Time in which acceleration rises, and also falls: 0 without a limit of jerk.
    rising: f64,
    /// Time of constant acceleration.
    holding: f64,
    /// Time of constant velocity.
    cruising: f64,
}

debug_numbers! {
    Limits { velocity, acceleration, jerk }
    MotionState { position, velocity, acceleration }
    MotionProfile { from, to, limits, velocity, shape }
    Halves { from, to, acceleration, velocity, rising, holding, cruising }
    Course { start, velocity, seconds }
}

shown_as_it_is! { Limits MotionState Shape }

impl MotionProfile {
    /// The fastest move between two positions within the limits.
    ///
    /// # Errors
    ///
    /// [`MotionProfileError`] if a position or a limit is not finite, a limit is not positive, or a result is out of
    /// range.
    pub fn new(from: f64, to: f64, limits: Limits) -> Result<Self, MotionProfileError> {
        check(&[from, to], &limits)?;
        let distance = (to - from).abs();
        let [rising, holding, cruising] = if distance == 0.0 { [0.0; 3] } else { times(distance, &limits) };
        let acceleration = match limits.jerk {
            Some(jerk) => (jerk * rising).min(limits.acceleration),
            None => limits.acceleration,
        };
        let velocity = (acceleration * (rising + holding)).min(limits.velocity);
        let halves = Halves { from, to, acceleration, velocity, rising, holding, cruising };
        let profile = Self { from, to, limits, velocity, shape: Shape::Rest(halves) };
        let moves = distance == 0.0 || (velocity > 0.0 && acceleration > 0.0 && profile.duration() > 0.0);
        if moves && distance.is_finite() && velocity.is_finite() && profile.duration().is_finite() {
            Ok(profile)
        } else {
            Err(MotionProfileError::OutOfRange)
        }
    }

    /// The move of an axis in motion to a target, where it comes to rest.
    ///
    /// An axis that cannot stop before the target goes beyond it and comes back. An axis that is faster than its limit
    /// slows down first. Without a limit of jerk, the acceleration of `start` has no effect.
    ///
    /// An axis at rest makes the move of [`new`](Self::new). Otherwise, the time of the move is found by 80 halvings of
    /// an interval.
    ///
    /// # Errors
    ///
    /// Those of [`new`](Self::new).
    pub fn from_motion(start: MotionState, to: f64, limits: Limits) -> Result<Self, MotionProfileError> {
        Self::passing(start, to, 0.0, limits)
    }

    /// The move of an axis, in motion or at rest, that passes a target at a velocity.
    ///
    /// It is the fastest such move that does not go back to make room for the change of velocity. After the move, the axis
    /// goes on at this velocity.
    ///
    /// # Errors
    ///
    /// Those of [`new`](Self::new); [`TooFast`](MotionProfileError::TooFast) if the velocity exceeds its limit;
    /// [`GoesBack`](MotionProfileError::GoesBack) if the axis has to go back first.
    pub fn passing(start: MotionState, to: f64, velocity: f64, limits: Limits) -> Result<Self, MotionProfileError> {
        check(&[start.position, start.velocity, start.acceleration, to, velocity], &limits)?;
        if velocity.abs() > limits.velocity {
            return Err(MotionProfileError::TooFast);
        }
        let rests = start.velocity == 0.0 && (start.acceleration == 0.0 || limits.jerk.is_none());
        if rests && velocity == 0.0 {
            return Self::new(start.position, to, limits);
        }
        Self::of_course(Course::to(start, to, velocity, &limits)?, to, limits)
    }

    /// The fastest way of an axis to rest, with no more deceleration and jerk than the limits allow.
    /// [`target`](Self::target) says where the axis rests.
    ///
    /// With a limit of jerk, an axis that accelerates goes on doing so for some time, and an axis whose deceleration is
    /// too great for its velocity turns round. The limit of velocity has no effect.
    ///
    /// # Errors
    ///
    /// Those of [`new`](Self::new).
    pub fn stop(start: MotionState, limits: Limits) -> Result<Self, MotionProfileError> {
        check(&[start.position, start.velocity, start.acceleration], &limits)?;
        let course = Course::at_once(start, 0.0, &limits);
        Self::of_course(course, start.position + course.distance(), limits)
    }

    fn of_course(course: Course, to: f64, limits: Limits) -> Result<Self, MotionProfileError> {
        let (velocity, seconds) = (course.peak(), course.duration());
        let is_sound = to.is_finite() && velocity.is_finite() && seconds.is_finite() && course.is_exact();
        let profile = Self { from: course.start(), to, limits, velocity, shape: Shape::Motion(course) };
        if is_sound { Ok(profile) } else { Err(MotionProfileError::OutOfRange) }
    }

    /// Duration of the move, in seconds.
    #[must_use]
    pub fn duration(&self) -> f64 {
        match &self.shape {
            Shape::Rest(halves) => halves.duration(),
            Shape::Motion(course) => course.duration(),
        }
    }

    /// Position at the start.
    #[must_use]
    pub const fn start(&self) -> f64 {
        self.from
    }

    /// Position at the end.
    #[must_use]
    pub const fn target(&self) -> f64 {
        self.to
    }

    /// Limits that the move was computed for.
    #[must_use]
    pub const fn limits(&self) -> Limits {
        self.limits
    }

    /// Greatest speed of the move, in units per second.
    #[must_use]
    pub const fn peak_velocity(&self) -> f64 {
        self.velocity
    }

    /// Position, velocity and acceleration at a time in seconds after the start. Before the move, the axis is as at its
    /// start. After the move, it rests, or goes on at the velocity of its end.
    ///
    /// NaN counts as a time before the start. In a trapezoid, acceleration jumps. At a jump, it has the value of the
    /// later part; in a move from rest to rest, that of the part that is nearer to the middle.
    #[must_use]
    pub fn at(&self, time: f64) -> MotionState {
        match &self.shape {
            Shape::Rest(halves) => halves.at(time),
            Shape::Motion(course) => course.at(self.to, time),
        }
    }
}

impl Halves {
    fn duration(&self) -> f64 {
        2.0 * self.speeding() + self.cruising
    }

    fn at(&self, time: f64) -> MotionState {
        let (left, sign) = (self.duration() - time, if self.to < self.from { -1.0 } else { 1.0 });
        if time.is_nan() || time < 0.0 || self.duration() == 0.0 {
            return MotionState { position: self.from, ..MotionState::default() };
        }
        if left < 0.0 {
            return MotionState { position: self.to, ..MotionState::default() };
        }
        // The second half is the first half, reversed.
        let (begin, side, time) = if time <= left { (self.from, sign, time) } else { (self.to, -sign, left) };
        let (distance, velocity, acceleration) = self.first_half(time);
        // Rounding must not lead beyond the ends of a short distance between large numbers.
        let (least, most) = (self.from.min(self.to), self.from.max(self.to));
        MotionState {
            // `clamp` is not used, because it panics if an end is NaN.
            position: (begin + side * distance).max(least).min(most),
            velocity: sign * velocity.min(self.velocity),
            acceleration: side * acceleration.min(self.acceleration),
        }
    }

    /// Time from the start to full speed.
    fn speeding(&self) -> f64 {
        2.0 * self.rising + self.holding
    }

    /// Distance, velocity and acceleration, without signs, at a time up to half the duration.
    fn first_half(&self, time: f64) -> (f64, f64, f64) {
        let (speeding, top) = (self.speeding(), self.velocity);
        if time < self.rising {
            let acceleration = self.acceleration * (time / self.rising);
            let velocity = 0.5 * acceleration * time;
            (velocity * time / 3.0, velocity, acceleration)
        } else if time < self.rising + self.holding {
            // The same as with full acceleration from half of its rise on.
            let since = time - 0.5 * self.rising;
            let velocity = self.acceleration * since;
            let lag = self.acceleration * self.rising * self.rising / 24.0;
            (0.5 * velocity * since + lag, velocity, self.acceleration)
        } else if time < speeding {
            // Computed backwards from full speed: the distance at full speed, less the part that is missing.
            let left = speeding - time;
            let acceleration = self.acceleration * (left / self.rising);
            let missing = 0.5 * acceleration * left;
            let distance = top * (time - 0.5 * speeding) + missing * left / 3.0;
            (distance, top - missing, acceleration)
        } else {
            (top * (time - 0.5 * speeding), top, 0.0)
        }
    }
}

fn check(numbers: &[f64], limits: &Limits) -> Result<(), MotionProfileError> {
    let sound = |limit: f64| limit.is_finite() && limit > 0.0;
    if !numbers.iter().all(|number| number.is_finite()) {
        Err(MotionProfileError::NotFinite)
    } else if !(sound(limits.velocity) && sound(limits.acceleration) && limits.jerk.is_none_or(sound)) {
        Err(MotionProfileError::Limit)
    } else {
        Ok(())
    }
}

/// Times of rising acceleration, of constant acceleration, and of constant velocity.
///
/// Acceleration and deceleration have the same distance, half the top velocity times the time of each. So with the top
/// velocity `a (r + h)` both together have the distance `a (r + h) (2 r + h)`.
fn times(distance: f64, limits: &Limits) -> [f64; 3] {
    let (velocity, acceleration) = (limits.velocity, limits.acceleration);
    let full = velocity / acceleration;
    // The time in which acceleration rises to its limit; 0 if jerk has no limit.
    let rising = limits.jerk.map_or(0.0, |jerk| acceleration / jerk);
    let (rising, holding) = match limits.jerk {
        // Full speed is reached before full acceleration.
        Some(jerk) if rising >= full => (libm::sqrt(velocity / jerk), 0.0),
        _ => (rising, full - rising),
    };
    let cruising = distance / velocity - (2.0 * rising + holding);
    if cruising >= 0.0 {
        return [rising, holding, cruising];
    }
    // Full speed is not reached. The time of constant acceleration, if there is one, solves the quadratic above.
    let square = distance / acceleration;
    let holding = 2.0 * (square - 2.0 * rising * rising) / (3.0 * rising + libm::sqrt(rising * rising + 4.0 * square));
    match limits.jerk {
        Some(jerk) if holding < 0.0 => [libm::cbrt(0.5 * distance / jerk), 0.0, 0.0],
        _ => [rising, holding, 0.0],
    }
}
