//! Simulated motor: its position at each moment, in the units of its rig.
//!
//! A motor obeys commands within its own limits. It goes to a position by a [`MotionProfile`] of `motion-core`. While it
//! moves, it changes its speed with constant acceleration. Positions on a curve are set moment by moment with
//! [`lead`](Motor::lead). At an end of its travel a motor stops dead, like a motor that trips a limit switch.

use motion_core::profile::{Limits, MotionProfile, MotionState};
use motion_core::time::Millis;
use motion_core::trajectory::Range;

use crate::seconds;

/// Simulated motor.
#[derive(Debug, Clone)]
pub struct Motor {
    limits: Limits,
    travel: Option<Range>,
    /// Position and velocity at the last command.
    from: Place,
    motion: Motion,
    /// Whether the motor has yet to report that it rests.
    owes_rest: bool,
    /// Whether the motor reported that it ran into an end, and has not left the end since.
    is_tripped: bool,
}

/// Position and velocity of a motor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Place {
    /// Position, in the units of the rig.
    pub position: f64,
    /// Velocity, in units per second.
    pub velocity: f64,
}

/// Event that a motor reports by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Happening {
    /// The motor rests at its target or where it was stopped. This is reported once for all commands since the motor
    /// rested last.
    Rests,
    /// The motor ran into an end of its travel and stands there. This is reported once, and then that the motor rests.
    Tripped {
        /// Whether the end is the upper one.
        upper: bool,
    },
}

#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "a rig has few motors, and a motor is made in constants")]
enum Motion {
    Rest,
    /// The positions are set from outside.
    Led,
    /// The velocity changes with constant acceleration from a moment on. Then the next motion follows, or the velocity
    /// stays.
    Ramp {
        start: f64,
        seconds: f64,
        acceleration: f64,
        then: Then,
    },
    /// Motion to a position. All positions of the profile have got other numbers since, greater by `by`.
    Profile {
        start: f64,
        by: f64,
        profile: MotionProfile,
    },
}

#[derive(Debug, Clone, Copy)]
enum Then {
    /// Goes on with the velocity that it has then.
    Run,
    /// Rests.
    Rest,
    /// Goes to another position.
    Go(f64, Limits),
}

impl Motor {
    /// Motor that rests at 0 and has no ends of its travel.
    ///
    /// Commands are cut to the limits. With a jerk limit, moves from rest are S-curves.
    #[must_use]
    pub const fn new(limits: Limits) -> Self {
        let from = Place { position: 0.0, velocity: 0.0 };
        Self { limits, travel: None, from, motion: Motion::Rest, owes_rest: false, is_tripped: false }
    }

    /// The same motor between two ends.
    #[must_use]
    pub const fn within(self, travel: Range) -> Self {
        Self { travel: Some(travel), ..self }
    }

    /// Limits of the motor.
    #[must_use]
    pub const fn limits(&self) -> Limits {
        self.limits
    }

    /// Ends of the travel, if there are any.
    #[must_use]
    pub const fn travel(&self) -> Option<Range> {
        self.travel
    }

    /// Position and velocity at the moment of the last command, or later.
    #[must_use]
    pub fn at(&self, now: Millis) -> Place {
        let now = seconds(now);
        match &self.motion {
            Motion::Rest | Motion::Led => self.from,
            Motion::Profile { start, by, profile } => {
                let state = profile.at(now - start);
                Place { position: state.position + by, velocity: state.velocity }
            }
            Motion::Ramp { start, seconds, acceleration, .. } => {
                let time = (now - start).clamp(0.0, *seconds);
                let Place { position, velocity } = self.from;
                let reached = velocity + acceleration * time;
                let gone = time * f64::midpoint(velocity, reached);
                Place { position: position + gone + reached * (now - start - time).max(0.0), velocity: reached }
            }
        }
    }

    /// Whether the motor rests.
    #[must_use]
    pub const fn rests(&self) -> bool {
        matches!(self.motion, Motion::Rest)
    }

    /// Whether the motor rests and has reported it.
    #[must_use]
    pub const fn is_idle(&self) -> bool {
        self.rests() && !self.owes_rest
    }

    /// Moves to a position, and rests there.
    ///
    /// The motor does not go beyond a target ahead of it if it can stop in time, however small the commanded
    /// acceleration is. If it cannot, or the target lies behind it, the motor turns round as soon as it can.
    ///
    /// A target or a speed that is NaN or infinite, or a speed of 0, stops the motor.
    pub fn go_to(&mut self, now: Millis, to: f64, velocity: f64, acceleration: f64) {
        let limits = self.cut(velocity, acceleration);
        let here = self.at(now);
        let start = seconds(now);
        if !to.is_finite() || limits.velocity <= 0.0 || limits.acceleration <= 0.0 {
            return self.stop(now, Some(acceleration));
        }
        self.owes_rest = true;
        if here.velocity == 0.0 {
            return self.depart(start, here, to, limits);
        }
        let (way, towards) = (to - here.position, (to - here.position).signum());
        let speed = here.velocity * towards;
        let needed = if speed > 0.0 { speed * speed / (2.0 * way.abs()) } else { 0.0 };
        let hard = limits.acceleration.max(needed).min(self.limits.acceleration);
        if speed > 0.0 && needed <= hard {
            self.depart(start, here, to, Limits { acceleration: hard, jerk: None, ..limits });
        } else {
            self.from = here;
            self.motion = self.braking(start, hard, Then::Go(to, limits));
        }
    }

    /// Runs with a velocity until the next command.
    pub fn run(&mut self, now: Millis, velocity: f64, acceleration: f64) {
        let limits = self.cut(velocity.abs(), acceleration);
        if limits.velocity <= 0.0 || limits.acceleration <= 0.0 || !velocity.is_finite() {
            return self.stop(now, Some(acceleration));
        }
        self.from = self.at(now);
        self.owes_rest = true;
        let change = limits.velocity.copysign(velocity) - self.from.velocity;
        self.motion = Motion::Ramp {
            start: seconds(now),
            seconds: change.abs() / limits.acceleration,
            acceleration: limits.acceleration.copysign(change),
            then: Then::Run,
        };
    }

    /// Comes to rest with an acceleration, or as sharply as possible without one, and never more sharply than possible.
    /// A motor that slows down more sharply already goes on so: a stop never softens an earlier one.
    pub fn stop(&mut self, now: Millis, acceleration: Option<f64>) {
        if self.at(now).velocity == 0.0 {
            return self.halt(now);
        }
        let hardest = self.limits.acceleration;
        let hard = acceleration.map_or(hardest, f64::abs);
        let hard = if hard > 0.0 { hard.max(self.slowing(now)).min(hardest) } else { hardest };
        self.from = self.at(now);
        self.owes_rest = true;
        self.motion = self.braking(seconds(now), hard, Then::Rest);
    }

    /// Stops dead.
    pub fn halt(&mut self, now: Millis) {
        self.from = Place { velocity: 0.0, ..self.at(now) };
        self.motion = Motion::Rest;
        self.owes_rest = true;
    }

    /// Sets position and velocity from a curve. They hold until the next call, or the next command.
    pub fn lead(&mut self, place: Place) {
        self.from = place;
        self.motion = Motion::Led;
        self.owes_rest = true;
    }

    /// Gives the present position another number. The motion goes on.
    pub fn rebase(&mut self, now: Millis, position: f64) {
        let by = position - self.at(now).position;
        self.from.position += by;
        match &mut self.motion {
            Motion::Profile { by: before, .. } => *before += by,
            Motion::Ramp { then: Then::Go(at, _), .. } => *at += by,
            Motion::Rest | Motion::Led | Motion::Ramp { then: Then::Run | Then::Rest, .. } => {}
        }
        if let Some(travel) = &mut self.travel {
            *travel = Range::new(travel.from + by, travel.to + by);
        }
    }

    /// Does everything that is due, and returns the event. Call it every [`TICK`](crate::TICK) while the motor is not
    /// idle.
    pub fn advance(&mut self, now: Millis) -> Option<Happening> {
        self.turn(seconds(now));
        let here = self.at(now);
        if let Some(travel) = self.travel {
            let (low, high) = (travel.from.min(travel.to), travel.from.max(travel.to));
            let upper = here.position > high;
            if upper || here.position < low {
                self.from = Place { position: here.position.clamp(low, high), velocity: 0.0 };
                self.motion = Motion::Rest;
                if !self.is_tripped {
                    self.is_tripped = true;
                    self.owes_rest = true;
                    return Some(Happening::Tripped { upper });
                }
            } else if here.position > low && here.position < high {
                self.is_tripped = false;
            }
        }
        if self.rests() && self.owes_rest {
            self.owes_rest = false;
            return Some(Happening::Rests);
        }
        None
    }

    /// Starts the motion that follows the finished one.
    fn turn(&mut self, now: f64) {
        loop {
            match self.motion.clone() {
                Motion::Profile { start, by, profile } if now - start >= profile.duration() => {
                    self.from = Place { position: profile.target() + by, velocity: 0.0 };
                    self.motion = Motion::Rest;
                }
                Motion::Ramp { start, seconds, acceleration, then } if now - start >= seconds => {
                    let Place { position, velocity } = self.from;
                    let reached = velocity + acceleration * seconds;
                    let over = start + seconds;
                    let position = position + seconds * f64::midpoint(velocity, reached);
                    let here = Place { position, velocity: 0.0 };
                    match then {
                        Then::Run => return,
                        Then::Rest => {
                            self.from = here;
                            self.motion = Motion::Rest;
                        }
                        Then::Go(to, limits) => self.depart(over, here, to, limits),
                    }
                }
                _ => return,
            }
        }
    }

    /// Goes to a position, from rest or from motion.
    fn depart(&mut self, start: f64, here: Place, to: f64, limits: Limits) {
        self.from = here;
        let state = MotionState { position: here.position, velocity: here.velocity, acceleration: 0.0 };
        self.motion = match MotionProfile::from_motion(state, to, limits) {
            Ok(profile) => Motion::Profile { start, by: 0.0, profile },
            // The distance is too great or too small for the numbers, so the motor stops or stays.
            Err(_) => self.braking(start, limits.acceleration, Then::Rest),
        };
    }

    /// Present deceleration; 0 if the motor does not slow down.
    fn slowing(&self, now: Millis) -> f64 {
        let acceleration = match &self.motion {
            Motion::Profile { start, profile, .. } => profile.at(seconds(now) - start).acceleration,
            Motion::Ramp { start, seconds: lasts, acceleration, .. } if seconds(now) - start < *lasts => *acceleration,
            Motion::Rest | Motion::Led | Motion::Ramp { .. } => 0.0,
        };
        if acceleration * self.at(now).velocity < 0.0 { acceleration.abs() } else { 0.0 }
    }

    fn braking(&self, start: f64, hard: f64, then: Then) -> Motion {
        let velocity = self.from.velocity;
        Motion::Ramp { start, seconds: velocity.abs() / hard, acceleration: -hard.copysign(velocity), then }
    }

    /// The limits, and no more than what was asked for; what is no number asks for nothing.
    fn cut(&self, velocity: f64, acceleration: f64) -> Limits {
        let least = |asked: f64, limit: f64| if asked.is_nan() { 0.0 } else { asked.abs().min(limit) };
        Limits {
            velocity: least(velocity, self.limits.velocity),
            acceleration: least(acceleration, self.limits.acceleration),
            jerk: self.limits.jerk,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { velocity: 10.0, acceleration: 20.0, jerk: None };

    /// Runs until the motor is idle, and returns the events with their times. Between two ticks no motor jumps.
    fn run(motor: &mut Motor, from: u64) -> Vec<(u64, Happening)> {
        let mut told = Vec::new();
        let mut before = motor.at(Millis(from)).position;
        for now in from..from + 60_000 {
            if let Some(happening) = motor.advance(Millis(now)) {
                told.push((now, happening));
            }
            let here = motor.at(Millis(now)).position;
            assert!((here - before).abs() <= LIMITS.velocity / 1000.0 + 1e-9, "{before} to {here} at {now}");
            before = here;
            if motor.is_idle() {
                return told;
            }
        }
        told
    }

    #[test]
    fn a_motor_goes_where_it_is_sent() {
        let mut motor = Motor::new(LIMITS);
        motor.go_to(Millis(5), 20.0, 10.0, 20.0);
        assert_eq!(run(&mut motor, 5), [(2505, Happening::Rests)]);
        assert_eq!(motor.at(Millis(9999)), Place { position: 20.0, velocity: 0.0 });
        // The motor is there already, and still reports that it rests.
        motor.go_to(Millis(9999), 20.0, 10.0, 20.0);
        assert_eq!(run(&mut motor, 9999), [(9999, Happening::Rests)]);
    }

    #[test]
    fn a_new_target_on_the_way_is_reached_without_a_stop() {
        let mut motor = Motor::new(LIMITS);
        motor.go_to(Millis(0), 20.0, 10.0, 20.0);
        motor.advance(Millis(1000));
        let before = motor.at(Millis(1000));
        motor.go_to(Millis(1000), 40.0, 10.0, 20.0);
        assert_eq!(motor.at(Millis(1000)), before);
        assert_eq!(run(&mut motor, 1000), [(4500, Happening::Rests)], "one way of 40");
        assert_eq!(motor.at(Millis(5000)).position.to_bits(), 40.0_f64.to_bits());
    }

    #[test]
    fn a_target_ahead_is_not_passed_if_the_motor_can_stop_in_time() {
        for (to, gentle, most) in [(14.0, 0.5, 14.0), (10.0, 20.0, 10.0), (9.0, 0.5, 10.0), (30.0, 0.5, 30.0)] {
            let mut motor = Motor::new(LIMITS);
            motor.run(Millis(0), 10.0, 20.0);
            motor.advance(Millis(1000));
            assert_eq!(motor.at(Millis(1000)).position.to_bits(), 7.5_f64.to_bits());
            motor.go_to(Millis(1000), to, 10.0, gentle);
            let mut farthest = 0.0_f64;
            for now in 1000..9000 {
                motor.advance(Millis(now));
                farthest = farthest.max(motor.at(Millis(now)).position);
            }
            assert!(farthest <= most + 1e-9, "{farthest} on the way to {to}");
            assert_eq!(motor.at(Millis(9000)), Place { position: to, velocity: 0.0 });
        }
    }

    #[test]
    fn a_motor_turns_round_and_slows_down() {
        let mut motor = Motor::new(LIMITS);
        motor.run(Millis(0), 10.0, 20.0);
        motor.advance(Millis(1000));
        assert_eq!(motor.at(Millis(1000)).velocity.to_bits(), 10.0_f64.to_bits());
        motor.go_to(Millis(1000), 0.0, 10.0, 20.0);
        run(&mut motor, 1000);
        assert_eq!(motor.at(Millis(9000)), Place::default());
        motor.run(Millis(9000), -10.0, 20.0);
        motor.advance(Millis(9600));
        motor.run(Millis(9600), 4.0, 20.0);
        motor.advance(Millis(10_700));
        assert_eq!(motor.at(Millis(10_700)).velocity.to_bits(), 4.0_f64.to_bits());
        motor.stop(Millis(10_700), Some(4.0));
        assert_eq!(run(&mut motor, 10_700), [(11_700, Happening::Rests)]);
    }

    #[test]
    fn a_stop_does_not_soften_another_stop() {
        let mut motor = Motor::new(LIMITS);
        for (first, then, rests) in [(None, Some(1.0), 1500), (Some(5.0), Some(1.0), 3000), (Some(5.0), None, 1650)] {
            motor.run(Millis(0), 10.0, 20.0);
            motor.advance(Millis(1000));
            motor.stop(Millis(1000), first);
            motor.advance(Millis(1200));
            motor.stop(Millis(1200), then);
            let told = run(&mut motor, 1200);
            assert!(
                matches!(told[..], [(at, Happening::Rests)] if at.abs_diff(rests) <= 1),
                "{told:?} and not {rests}"
            );
        }
        // A stop does not soften the end of a move either.
        motor.halt(Millis(0));
        motor.rebase(Millis(0), 0.0);
        motor.go_to(Millis(0), 20.0, 10.0, 20.0);
        motor.advance(Millis(2200));
        motor.stop(Millis(2200), Some(1.0));
        run(&mut motor, 2200);
        assert!((motor.at(Millis(3000)).position - 20.0).abs() < 1e-9);
    }

    #[test]
    fn an_end_of_the_travel_trips_a_motor_once() {
        let mut motor = Motor::new(LIMITS).within(Range::new(-1.0, 5.0));
        motor.run(Millis(0), 10.0, 20.0);
        let told = run(&mut motor, 0);
        assert!(matches!(told[..], [(_, Happening::Tripped { upper: true }), (_, Happening::Rests)]), "{told:?}");
        assert_eq!(motor.at(Millis(3000)), Place { position: 5.0, velocity: 0.0 });
        motor.go_to(Millis(3000), 0.0, 10.0, 20.0);
        assert!(matches!(run(&mut motor, 3000)[..], [(_, Happening::Rests)]));
    }

    #[test]
    fn nan_infinity_and_zero_stop_a_motor() {
        for (to, velocity, acceleration) in
            [(f64::NAN, 1.0, 1.0), (f64::INFINITY, 1.0, 1.0), (1.0, f64::NAN, 1.0), (1.0, 0.0, 1.0), (1.0, 1.0, 0.0)]
        {
            let mut motor = Motor::new(LIMITS);
            motor.run(Millis(0), 10.0, 20.0);
            motor.advance(Millis(1000));
            motor.go_to(Millis(1000), to, velocity, acceleration);
            assert!(!run(&mut motor, 1000).is_empty());
            assert_eq!(motor.at(Millis(99_000)).velocity.to_bits(), 0.0_f64.to_bits());
        }
    }

    #[test]
    fn another_number_for_the_position_does_not_change_the_motion() {
        let mut motor = Motor::new(LIMITS);
        motor.go_to(Millis(0), 20.0, 10.0, 20.0);
        motor.advance(Millis(700));
        motor.rebase(Millis(700), 100.0);
        assert!((motor.at(Millis(700)).position - 100.0).abs() < 1e-9);
        assert_eq!(run(&mut motor, 700), [(2500, Happening::Rests)]);
    }
}
