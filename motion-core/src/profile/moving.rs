//! Moves from motion, and moves that end in motion.
//!
//! Every such move has the same form: the axis first speeds towards the greatest velocity in one direction, by a
//! [`Ramp`], and holds it. At some time it gives that up, and a second ramp takes it to its last velocity. The later it
//! gives up, the farther away the second ramp ends. So the time is found by halving an interval, and the result is the
//! fastest move, because the axis always does the most that the limits allow.

use super::{Limits, MotionProfileError, MotionState};

/// Number of halvings: more bits than a number has.
const HALVINGS: u32 = 80;

/// Stretch of constant jerk.
#[derive(Clone, Copy, Default, PartialEq)]
pub(super) struct Part {
    seconds: f64,
    jerk: f64,
    /// Acceleration at the start.
    acceleration: f64,
}

impl Part {
    /// State at a time after the start of the part.
    fn after(&self, start: MotionState, time: f64) -> MotionState {
        let Self { jerk, acceleration, .. } = *self;
        let gained = time * (acceleration + 0.5 * jerk * time);
        let gone = time * (start.velocity + time * (0.5 * acceleration + jerk * time / 6.0));
        MotionState {
            position: start.position + gone,
            velocity: start.velocity + gained,
            acceleration: acceleration + jerk * time,
        }
    }

    /// Greatest speed within the part, where acceleration is 0.
    fn peak(&self, start: MotionState) -> f64 {
        let crossing = -self.acceleration / self.jerk;
        let inside = crossing > 0.0 && crossing < self.seconds;
        let ends = start.velocity.abs().max(self.after(start, self.seconds).velocity.abs());
        if inside { ends.max(self.after(start, crossing).velocity.abs()) } else { ends }
    }
}

/// Fastest change from a velocity and an acceleration to another velocity and no acceleration.
type Ramp = [Part; 3];

fn ramp(from: MotionState, velocity: f64, limits: &Limits) -> Ramp {
    let gain = velocity - from.velocity;
    let most = limits.acceleration;
    let Some(jerk) = limits.jerk else {
        let acceleration = most.copysign(gain);
        return [Part { seconds: gain.abs() / most, jerk: 0.0, acceleration }, Part::default(), Part::default()];
    };
    let start = from.acceleration;
    // Acceleration goes to its peak, stays there, and goes to 0. If it went to 0 at once, it would gain `coasting`.
    let coasting = 0.5 * start * start.abs() / jerk;
    let sign = if gain < coasting { -1.0 } else { 1.0 };
    let peak = libm::sqrt((jerk * gain * sign + 0.5 * start * start).max(0.0));
    let held = peak.min(most);
    let (first, last) = ((sign * held - start).abs() / jerk, held / jerk);
    let gained = 0.5 * first * (sign * held + start) * sign + 0.5 * last * held;
    let holding = if peak > most { ((gain * sign - gained) / held).max(0.0) } else { 0.0 };
    let (held, falls) = (sign * held, -sign * jerk);
    [
        Part { seconds: first, jerk: jerk.copysign(held - start), acceleration: start },
        Part { seconds: holding, jerk: 0.0, acceleration: held },
        Part { seconds: last, jerk: falls, acceleration: held },
    ]
}

fn seconds(parts: &[Part]) -> f64 {
    parts.iter().fold(0.0, |sum, part| sum + part.seconds)
}

/// State at a time after the start of the parts, or at their end.
fn follow(parts: &[Part], start: MotionState, mut time: f64) -> MotionState {
    let mut state = start;
    for part in parts {
        if time < part.seconds {
            return part.after(state, time);
        }
        state = MotionState { acceleration: 0.0, ..part.after(state, part.seconds) };
        time -= part.seconds;
    }
    state
}

/// The first `time` seconds of a ramp.
fn cut(ramp: Ramp, mut time: f64) -> Ramp {
    ramp.map(|part| {
        let seconds = part.seconds.min(time);
        time -= seconds;
        Part { seconds, ..part }
    })
}

/// Parts of a move: a ramp that may be cut off, a stretch of constant velocity, and a ramp.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Course {
    pub(super) start: MotionState,
    parts: [Part; 7],
    /// Velocity at the end.
    pub(super) velocity: f64,
    pub(super) seconds: f64,
    /// Distance that rounding leaves at the end.
    rest: f64,
}

impl Course {
    fn new(start: MotionState, first: Ramp, holding: f64, velocity: f64, limits: &Limits) -> Self {
        let [rise, keep, fall] = first;
        let reached = follow(&first, start, f64::INFINITY);
        let hold = Part { seconds: holding, ..Part::default() };
        // A ramp that was cut off ends with an acceleration.
        let acceleration = first.iter().rev().find(|part| part.seconds > 0.0);
        let acceleration = acceleration.map_or(start.acceleration, |part| part.acceleration + part.jerk * part.seconds);
        let acceleration = if holding > 0.0 { 0.0 } else { acceleration };
        let [back, brake, ease] = ramp(MotionState { acceleration, ..reached }, velocity, limits);
        let parts = [rise, keep, fall, hold, back, brake, ease];
        Self { start, parts, velocity, seconds: seconds(&parts), rest: 0.0 }
    }

    /// Comes to a velocity at once.
    pub(super) fn at_once(start: MotionState, velocity: f64, limits: &Limits) -> Self {
        Self::new(start, [Part { acceleration: start.acceleration, ..Part::default() }; 3], 0.0, velocity, limits)
    }

    /// Comes to a velocity at a position, as soon as possible.
    pub(super) fn to(
        start: MotionState,
        target: f64,
        velocity: f64,
        limits: &Limits,
    ) -> Result<Self, MotionProfileError> {
        let way = target - start.position;
        let reaching = |course: Self| Self { rest: way - course.distance(), ..course };
        let soonest = reaching(Self::at_once(start, velocity, limits));
        if soonest.is_exact() {
            return Ok(soonest);
        }
        let forwards = if soonest.rest < 0.0 { -1.0 } else { 1.0 };
        // The axis is beyond the target before it has the velocity.
        if velocity * forwards < 0.0 {
            return Err(MotionProfileError::GoesBack);
        }
        let first = ramp(start, forwards * limits.velocity, limits);
        let left = (way - Self::new(start, first, 0.0, velocity, limits).distance()) * forwards;
        if left >= 0.0 {
            return Ok(reaching(Self::new(start, first, left / limits.velocity, velocity, limits)));
        }
        let (mut early, mut late) = (0.0, seconds(&first));
        for _ in 0..HALVINGS {
            let middle = 0.5 * (early + late);
            if (way - Self::new(start, cut(first, middle), 0.0, velocity, limits).distance()) * forwards > 0.0 {
                early = middle;
            } else {
                late = middle;
            }
        }
        Ok(reaching(Self::new(start, cut(first, early), 0.0, velocity, limits)))
    }

    /// Distance from the start to the end; negative towards smaller positions.
    pub(super) fn distance(&self) -> f64 {
        follow(&self.parts, MotionState { position: 0.0, ..self.start }, f64::INFINITY).position
    }

    pub(super) fn duration(&self) -> f64 {
        self.seconds
    }

    pub(super) fn start(&self) -> f64 {
        self.start.position
    }

    /// Whether all distances are finite, and what rounding leaves is small beside the whole way.
    pub(super) fn is_exact(&self) -> bool {
        let longest = self.distance().abs() + self.peak() * self.seconds;
        longest.is_finite() && self.rest.abs() <= 1e-9 * longest
    }

    /// Greatest speed.
    pub(super) fn peak(&self) -> f64 {
        let mut state = self.start;
        self.parts.iter().fold(state.velocity.abs().max(self.velocity.abs()), |most, part| {
            let peak = part.peak(state);
            state = part.after(state, part.seconds);
            most.max(peak)
        })
    }

    /// State at a time, of a move that ends at `target`.
    pub(super) fn at(&self, target: f64, time: f64) -> MotionState {
        if time.is_nan() || time < 0.0 {
            return self.start;
        }
        if time >= self.seconds {
            let gone = if self.velocity == 0.0 { 0.0 } else { self.velocity * (time - self.seconds) };
            return MotionState { position: target + gone, velocity: self.velocity, acceleration: 0.0 };
        }
        let MotionState { position, velocity, acceleration } =
            follow(&self.parts, MotionState { position: 0.0, ..self.start }, time);
        let position = self.start.position + (position + self.rest * (time / self.seconds));
        MotionState { position, velocity, acceleration }
    }
}
