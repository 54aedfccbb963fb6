//! A motor: where it is at each moment, in the units of its rig.
//!
//! What it is told, it does within its own limits: from rest it goes by a [`MotionProfile`] of `motion-core`, and while
//! it moves it changes its speed evenly. Positions on a curve are told it moment by moment, by [`lead`](Motor::lead).
//! Should it get to an end of its travel, it stops dead there, as motors do that trip a limit switch.

use motion_core::profile::{Limits, MotionProfile};
use motion_core::time::Millis;
use motion_core::trajectory::Range;

use crate::seconds;

/// A motor.
#[derive(Debug, Clone)]
pub struct Motor {
    limits: Limits,
    travel: Option<Range>,
    /// Where it was, and how fast, when it was told last.
    from: Place,
    motion: Motion,
    /// Whether it has yet to say that it rests.
    owes_rest: bool,
    /// Whether it has said that it ran into an end, and has not left it.
    is_tripped: bool,
}

/// Where a motor is, and how fast.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Place {
    /// The position, in the units of the rig.
    pub position: f64,
    /// The velocity, in units a second.
    pub velocity: f64,
}

/// What happened to a motor by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Happening {
    /// It rests: where it was sent, or where it was stopped. Once for all that it was told since it rested last.
    Rests,
    /// It ran into an end of its travel, and stands there. It says so once, and that it rests as well.
    Tripped {
        /// Whether it is the upper end.
        upper: bool,
    },
}

#[derive(Debug, Clone)]
enum Motion {
    Rest,
    /// Its positions are told.
    Led,
    /// Its velocity changes evenly from a moment on, and stays; then comes something else, or nothing.
    Ramp {
        start: f64,
        seconds: f64,
        acceleration: f64,
        then: Then,
    },
    /// From rest to rest.
    Profile {
        start: f64,
        profile: MotionProfile,
    },
}

#[derive(Debug, Clone, Copy)]
enum Then {
    /// It goes on as fast as it is by then.
    Run,
    /// It goes on like that for so many seconds, and stops with this acceleration.
    RunAndStop { seconds: f64, acceleration: f64, at: f64 },
    /// It rests, here if it is known.
    Rest(Option<f64>),
    /// It goes elsewhere.
    Go(f64, Limits),
}

impl Motor {
    /// A motor that rests at 0 and can go anywhere.
    ///
    /// What it is told is cut to the limits. With a jerk in them, moves from rest are S-curves.
    #[must_use]
    pub const fn new(limits: Limits) -> Self {
        let from = Place { position: 0.0, velocity: 0.0 };
        Self { limits, travel: None, from, motion: Motion::Rest, owes_rest: false, is_tripped: false }
    }

    /// The same between two ends.
    #[must_use]
    pub const fn within(self, travel: Range) -> Self {
        Self { travel: Some(travel), ..self }
    }

    /// The limits that it keeps.
    #[must_use]
    pub const fn limits(&self) -> Limits {
        self.limits
    }

    /// Where its travel ends, if it does.
    #[must_use]
    pub const fn travel(&self) -> Option<Range> {
        self.travel
    }

    /// Where it is, at the last moment that it was told of or a later one.
    #[must_use]
    pub fn at(&self, now: Millis) -> Place {
        let now = seconds(now);
        match &self.motion {
            Motion::Rest | Motion::Led => self.from,
            Motion::Profile { start, profile } => {
                let state = profile.at(now - start);
                Place { position: state.position, velocity: state.velocity }
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

    /// Whether it rests.
    #[must_use]
    pub const fn rests(&self) -> bool {
        matches!(self.motion, Motion::Rest)
    }

    /// Whether it rests, and has said so.
    #[must_use]
    pub const fn is_idle(&self) -> bool {
        self.rests() && !self.owes_rest
    }

    /// Goes to a position, and rests there. What lies ahead of it, it does not go beyond if it can help it, however gently
    /// it was told to go; it turns round as soon as it can, if it must.
    ///
    /// What is no number, and speeds of 0, stop it.
    pub fn go_to(&mut self, now: Millis, to: f64, velocity: f64, acceleration: f64) {
        let limits = self.cut(velocity, acceleration);
        let here = self.at(now);
        let start = seconds(now);
        if !to.is_finite() || limits.velocity <= 0.0 || limits.acceleration <= 0.0 {
            return self.stop(now, Some(acceleration));
        }
        self.owes_rest = true;
        if here.velocity == 0.0 {
            self.depart(start, here.position, to, limits);
            return;
        }
        self.from = here;
        let (way, towards) = (to - here.position, (to - here.position).signum());
        let speed = here.velocity * towards;
        let needed = if speed > 0.0 { speed * speed / (2.0 * way.abs()) } else { 0.0 };
        let hard = limits.acceleration.max(needed).min(self.limits.acceleration);
        self.motion = if speed > 0.0 && needed <= hard {
            let peak = (hard * way.abs() + speed * speed / 2.0).sqrt().min(limits.velocity);
            let change = (peak - speed).abs() / hard;
            let left = way.abs() - change * f64::midpoint(speed, peak) - peak * peak / (2.0 * hard);
            let then = Then::RunAndStop { seconds: left.max(0.0) / peak, acceleration: -towards * hard, at: to };
            Motion::Ramp { start, seconds: change, acceleration: towards * hard * (peak - speed).signum(), then }
        } else {
            self.braking(start, hard, Then::Go(to, limits))
        };
    }

    /// Runs with a velocity, until it is told otherwise.
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

    /// Comes to rest with an acceleration; as sharply as it can without one, and never more sharply than that. If it slows
    /// down more sharply already, it goes on so: no stop is made softer by another one.
    pub fn stop(&mut self, now: Millis, acceleration: Option<f64>) {
        let hardest = self.limits.acceleration;
        let hard = acceleration.map_or(hardest, f64::abs);
        let hard = if hard > 0.0 { hard.max(self.slowing(now)).min(hardest) } else { hardest };
        self.from = self.at(now);
        self.owes_rest = true;
        self.motion = self.braking(seconds(now), hard, Then::Rest(None));
    }

    /// Stops dead.
    pub fn halt(&mut self, now: Millis) {
        self.from = Place { velocity: 0.0, ..self.at(now) };
        self.motion = Motion::Rest;
        self.owes_rest = true;
    }

    /// Is at a position, with a velocity, as a curve has it: until it is told otherwise, from tick to tick.
    pub fn lead(&mut self, place: Place) {
        self.from = place;
        self.motion = Motion::Led;
        self.owes_rest = true;
    }

    /// Calls the place where it is another number; the motion goes on.
    pub fn rebase(&mut self, now: Millis, position: f64) {
        let by = position - self.at(now).position;
        self.from.position += by;
        match &mut self.motion {
            Motion::Rest | Motion::Led => {}
            Motion::Profile { profile, .. } => {
                let moved = MotionProfile::new(profile.start() + by, profile.target() + by, profile.limits());
                if let Ok(moved) = moved {
                    *profile = moved;
                }
            }
            Motion::Ramp { then, .. } => match then {
                Then::RunAndStop { at, .. } | Then::Rest(Some(at)) | Then::Go(at, _) => *at += by,
                Then::Run | Then::Rest(None) => {}
            },
        }
        if let Some(travel) = &mut self.travel {
            *travel = Range::new(travel.from + by, travel.to + by);
        }
    }

    /// Does what is due, and says what happened. Call it every [`TICK`](crate::TICK) while the motor is not idle.
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

    /// Goes on to what comes behind what is over.
    fn turn(&mut self, now: f64) {
        loop {
            match self.motion.clone() {
                Motion::Profile { start, profile } if now - start >= profile.duration() => {
                    self.from = Place { position: profile.target(), velocity: 0.0 };
                    self.motion = Motion::Rest;
                }
                Motion::Ramp { start, seconds, acceleration, then } if now - start >= seconds => {
                    let Place { position, velocity } = self.from;
                    let reached = velocity + acceleration * seconds;
                    let over = start + seconds;
                    let place =
                        Place { position: position + seconds * f64::midpoint(velocity, reached), velocity: reached };
                    match then {
                        Then::Run => return,
                        Then::RunAndStop { seconds, acceleration, at } => {
                            if now < over + seconds {
                                return;
                            }
                            let braking = reached.abs() / acceleration.abs();
                            let position = place.position + reached * seconds;
                            self.from = Place { position, velocity: reached };
                            self.motion = Motion::Ramp {
                                start: over + seconds,
                                seconds: braking,
                                acceleration,
                                then: Then::Rest(Some(at)),
                            };
                        }
                        Then::Rest(at) => {
                            self.from = Place { position: at.unwrap_or(place.position), velocity: 0.0 };
                            self.motion = Motion::Rest;
                        }
                        Then::Go(to, limits) => self.depart(over, place.position, to, limits),
                    }
                }
                _ => return,
            }
        }
    }

    /// Goes from rest to rest.
    fn depart(&mut self, start: f64, here: f64, to: f64, limits: Limits) {
        self.from = Place { position: here, velocity: 0.0 };
        self.motion = match MotionProfile::new(here, to, limits) {
            Ok(profile) => Motion::Profile { start, profile },
            // Too far for numbers to tell, or too near: it stays.
            Err(_) => Motion::Rest,
        };
    }

    /// How sharply it slows down just now; 0 if it does not.
    fn slowing(&self, now: Millis) -> f64 {
        let acceleration = match &self.motion {
            Motion::Profile { start, profile } => profile.at(seconds(now) - start).acceleration,
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

    /// Runs until the motor is idle, and says what happened when. Between two ticks no motor jumps.
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
    fn it_goes_where_it_is_sent() {
        let mut motor = Motor::new(LIMITS);
        motor.go_to(Millis(5), 20.0, 10.0, 20.0);
        assert_eq!(run(&mut motor, 5), [(2505, Happening::Rests)]);
        assert_eq!(motor.at(Millis(9999)), Place { position: 20.0, velocity: 0.0 });
        // There already: it says so all the same.
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
    fn what_lies_ahead_is_not_passed_if_that_can_be() {
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
    fn it_turns_round_and_slows_down() {
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
    fn no_stop_makes_another_one_softer() {
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
        // Nor does it make the end of a move softer.
        motor.halt(Millis(0));
        motor.rebase(Millis(0), 0.0);
        motor.go_to(Millis(0), 20.0, 10.0, 20.0);
        motor.advance(Millis(2200));
        motor.stop(Millis(2200), Some(1.0));
        run(&mut motor, 2200);
        assert!((motor.at(Millis(3000)).position - 20.0).abs() < 1e-9);
    }

    #[test]
    fn an_end_of_its_travel_trips_it_once() {
        let mut motor = Motor::new(LIMITS).within(Range::new(-1.0, 5.0));
        motor.run(Millis(0), 10.0, 20.0);
        let told = run(&mut motor, 0);
        assert!(matches!(told[..], [(_, Happening::Tripped { upper: true }), (_, Happening::Rests)]), "{told:?}");
        assert_eq!(motor.at(Millis(3000)), Place { position: 5.0, velocity: 0.0 });
        motor.go_to(Millis(3000), 0.0, 10.0, 20.0);
        assert!(matches!(run(&mut motor, 3000)[..], [(_, Happening::Rests)]));
    }

    #[test]
    fn nonsense_stops_it() {
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
    fn another_number_for_the_place_changes_no_way() {
        let mut motor = Motor::new(LIMITS);
        motor.go_to(Millis(0), 20.0, 10.0, 20.0);
        motor.advance(Millis(700));
        motor.rebase(Millis(700), 100.0);
        assert!((motor.at(Millis(700)).position - 100.0).abs() < 1e-9);
        assert_eq!(run(&mut motor, 700), [(2500, Happening::Rests)]);
    }
}
