//! Moves from motion and to motion: the laws of `motion_core::profile`.

#![expect(clippy::float_cmp, reason = "what is exact by law is compared exactly")]

use motion_core::profile::{Limits, MotionProfile, MotionProfileError, MotionState};
use proptest::prelude::*;

const PLAIN: Limits = Limits { velocity: 2.0, acceleration: 1.0, jerk: None };
const SOFT: Limits = Limits { jerk: Some(2.0), ..PLAIN };

fn state(position: f64, velocity: f64, acceleration: f64) -> MotionState {
    MotionState { position, velocity, acceleration }
}

#[track_caller]
fn near(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-9, "{a} and not {b}");
}

#[test]
fn an_axis_in_motion_goes_on_turns_round_or_slows_down() {
    // 1 s from 1 to 2, 2 units at full speed, 2 s to rest.
    let on = MotionProfile::from_motion(state(0.0, 1.0, 0.0), 5.5, PLAIN).unwrap();
    near(on.duration(), 4.0);
    // To rest in 2 s and 2 units, and 1 unit back in 2 s.
    let back = MotionProfile::from_motion(state(0.0, 2.0, 0.0), 1.0, PLAIN).unwrap();
    near(back.duration(), 4.0);
    near(back.at(2.0).position, 2.0);
    // 1 s from 3 to 2, 1 unit at full speed, 2 s to rest.
    let fast = MotionProfile::from_motion(state(0.0, 3.0, 0.0), 5.5, PLAIN).unwrap();
    near(fast.duration(), 3.5);
    assert_eq!((fast.peak_velocity(), back.peak_velocity(), on.peak_velocity()), (3.0, 2.0, 2.0));
}

#[test]
fn a_stop_says_where_the_axis_rests() {
    let stop = MotionProfile::stop(state(1.0, -2.0, 0.0), PLAIN).unwrap();
    assert_eq!((stop.duration(), stop.target()), (2.0, -1.0));
    // Deceleration rises for 0.5 s, is constant for 1.5 s, and falls for 0.5 s.
    let soft = MotionProfile::stop(state(1.0, -2.0, 0.0), SOFT).unwrap();
    near(soft.duration(), 2.5);
    near(soft.target(), -1.5);
    // The axis first accelerates less and less: 0.5 s at a mean of 0.5, and so reaches 2.
    let pushed = MotionProfile::stop(state(0.0, 1.75, 1.0), SOFT).unwrap();
    near(pushed.at(0.5).velocity, 2.0);
    near(pushed.duration(), 3.0);
    assert_eq!(MotionProfile::stop(state(3.0, 0.0, 0.0), SOFT).unwrap().duration(), 0.0);
}

#[test]
fn a_target_is_passed_at_a_velocity_if_the_axis_need_not_go_back() {
    for limits in [PLAIN, SOFT] {
        let pass = |from, to, velocity| MotionProfile::passing(from, to, velocity, limits);
        let rest = state(0.0, 0.0, 0.0);
        let there = pass(rest, 10.0, 1.0).unwrap();
        assert_eq!(there.at(there.duration()), state(10.0, 1.0, 0.0));
        assert_eq!(there.at(there.duration() + 2.0), state(12.0, 1.0, 0.0));
        // From rest, 0.5 units are needed at least, or with the limit of jerk, 0.75.
        assert_eq!(pass(rest, 0.25, 1.0), Err(MotionProfileError::GoesBack));
        assert_eq!(pass(rest, -5.0, 1.0), Err(MotionProfileError::GoesBack));
        assert_eq!(pass(rest, 10.0, 2.5), Err(MotionProfileError::TooFast));
    }
    // 2 units at full speed before, and none to gain.
    let full = MotionProfile::passing(state(0.0, 2.0, 0.0), 3.0, 2.0, PLAIN).unwrap();
    near(full.duration(), 1.5);
    // From 1 to full speed in 1 s and 1.5 units, 1 unit at full speed, and back to 1 in 1.5 units.
    let there_and_back = MotionProfile::passing(state(0.0, 1.0, 0.0), 4.0, 1.0, PLAIN).unwrap();
    near(there_and_back.duration(), 2.5);
}

#[test]
fn numbers_out_of_range_are_refused() {
    for bad in [f64::NAN, f64::INFINITY] {
        for from in [state(bad, 0.0, 0.0), state(0.0, bad, 0.0), state(0.0, 0.0, bad)] {
            assert_eq!(MotionProfile::from_motion(from, 1.0, SOFT), Err(MotionProfileError::NotFinite));
            assert_eq!(MotionProfile::stop(from, SOFT), Err(MotionProfileError::NotFinite));
        }
        assert_eq!(MotionProfile::passing(state(0.0, 0.0, 0.0), 1.0, bad, SOFT), Err(MotionProfileError::NotFinite));
    }
    let fast = state(0.0, f64::MAX, 0.0);
    assert_eq!(MotionProfile::stop(fast, PLAIN), Err(MotionProfileError::OutOfRange));
    let still = Limits { velocity: 0.0, ..PLAIN };
    assert_eq!(MotionProfile::from_motion(state(0.0, 1.0, 0.0), 1.0, still), Err(MotionProfileError::Limit));
}

/// Numbers of usual sizes.
fn size() -> impl Strategy<Value = f64> {
    (-2.0..2.0).prop_map(|exponent: f64| 10_f64.powf(exponent))
}

prop_compose! {
    fn limits()(velocity in size(), acceleration in size(), jerk in prop::option::of(size())) -> Limits {
        Limits { velocity, acceleration, jerk }
    }
}

prop_compose! {
    /// An axis in motion, within its limits or beyond them, and its target.
    fn moves()(limits in limits(), speed in -2.0..2.0, push in -1.5..1.5, way in -1.0..1.0, long in size(), at in -1e3..1e3)
        -> (MotionState, f64, Limits) {
        (state(at, speed * limits.velocity, push * limits.acceleration), at + way * long, limits)
    }
}

/// Checks that a profile obeys its limits and is continuous, from its start to its end at a velocity.
fn sound(profile: &MotionProfile, from: MotionState, velocity: f64, share: f64) -> Result<(), TestCaseError> {
    let (limits, lasts) = (profile.limits(), profile.duration());
    prop_assert_eq!(profile.at(0.0).velocity, from.velocity);
    prop_assert_eq!(profile.at(0.0).position, from.position);
    prop_assert_eq!(profile.at(lasts), state(profile.target(), velocity, 0.0));
    let jerk = limits.jerk.unwrap_or(f64::INFINITY);
    let push = limits.acceleration.max(if limits.jerk.is_some() { from.acceleration.abs() } else { 0.0 });
    // A velocity that the start makes inevitable may exceed the limit.
    let inevitable =
        from.velocity.abs() + if limits.jerk.is_some() { from.acceleration.powi(2) / (2.0 * jerk) } else { 0.0 };
    let speed = limits.velocity.max(inevitable);
    let noise = 1e-7;
    let span = 1e-4 * lasts;
    let begin = share * (lasts - span);
    let [a, b, c] = [begin, begin + 0.5 * span, begin + span].map(|time| profile.at(time));
    for state in [a, b, c] {
        prop_assert!(state.velocity.abs() <= speed * (1.0 + noise), "{state:?} {profile:?}");
        prop_assert!(state.velocity.abs() <= profile.peak_velocity() * (1.0 + noise));
        prop_assert!(state.acceleration.abs() <= push * (1.0 + noise), "{state:?} {profile:?}");
    }
    let rounding = 1e-12 * (1.0 + from.position.abs() + profile.target().abs() + speed * lasts);
    prop_assert!((c.position - a.position - span * b.velocity).abs() <= span * span * push + rounding);
    prop_assert!((c.velocity - a.velocity).abs() <= span * push * (1.0 + noise) + noise * speed);
    if limits.jerk.is_some() {
        prop_assert!(
            (c.acceleration - a.acceleration).abs() <= span * jerk * (1.0 + noise) + noise * push,
            "{a:?} {c:?}"
        );
        prop_assert!((c.velocity - a.velocity - span * b.acceleration).abs() <= span * span * jerk + noise * speed);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn moves_from_motion_obey_limits_and_are_never_longer_than_a_stop_and_a_move((from, to, limits) in moves(), share in 0.0..1.0) {
        let profile = MotionProfile::from_motion(from, to, limits).unwrap();
        sound(&profile, from, 0.0, share)?;
        let stop = MotionProfile::stop(from, limits).unwrap();
        sound(&stop, from, 0.0, share)?;
        let then = MotionProfile::new(stop.target(), to, limits).unwrap();
        let longest = stop.duration() + then.duration();
        prop_assert!(profile.duration() <= longest * (1.0 + 1e-6), "{} and not {longest}: {profile:?}", profile.duration());
        prop_assert!(stop.duration() <= profile.duration() * (1.0 + 1e-6));
    }

    #[test]
    fn an_axis_at_rest_makes_the_usual_move((from, to, limits) in moves()) {
        let rest = state(from.position, 0.0, 0.0);
        prop_assert_eq!(MotionProfile::from_motion(rest, to, limits), MotionProfile::new(from.position, to, limits));
        // Near rest, the move is nearly the same.
        let nearly = MotionProfile::from_motion(state(from.position, 1e-9 * limits.velocity, 0.0), to, limits).unwrap();
        let usual = MotionProfile::new(from.position, to, limits).unwrap();
        let bound = 1e-3 * (usual.duration() + limits.velocity / limits.acceleration);
        prop_assert!((nearly.duration() - usual.duration()).abs() <= bound, "{nearly:?} {usual:?}");
    }

    /// A target is passed if and only if the axis has the velocity before it is there. Then it does not turn round on the way.
    #[test]
    fn targets_are_passed_without_going_back(
        (from, to, limits) in moves(), part in -1.0..=1.0, pushed: bool, share in 0.0..1.0,
    ) {
        let from = if pushed { from } else { MotionState { acceleration: 0.0, ..from } };
        let velocity: f64 = part * limits.velocity;
        // Distance of the change of velocity at once, without acceleration before it.
        let change = (velocity - from.velocity).abs();
        let lasts = match limits.jerk {
            None => change / limits.acceleration,
            Some(jerk) if change < limits.acceleration.powi(2) / jerk => 2.0 * (change / jerk).sqrt(),
            Some(jerk) => change / limits.acceleration + limits.acceleration / jerk,
        };
        let gone = 0.5 * (from.velocity + velocity) * lasts;
        let room = (to - from.position - gone) * velocity.signum();
        let noise = 1e-6 * (gone.abs() + (to - from.position).abs() + limits.velocity * lasts);
        let is_known = (!pushed || limits.jerk.is_none()) && room.abs() > noise;
        match MotionProfile::passing(from, to, velocity, limits) {
            Ok(profile) => {
                prop_assert!(!is_known || room > 0.0, "{room}: {profile:?}");
                sound(&profile, from, velocity, share)?;
                let goes = from.velocity * velocity > 0.0 && (limits.jerk.is_none() || !pushed);
                prop_assert!(!goes || profile.at(share * profile.duration()).velocity * velocity >= -1e-9 * limits.velocity.powi(2));
            }
            Err(error) => {
                prop_assert_eq!(error, MotionProfileError::GoesBack);
                prop_assert!(!is_known || room < 0.0, "{room}: {from:?} {to} {velocity} {limits:?}");
            }
        }
    }

    /// Without a limit of jerk, no move is faster: among all moves that speed up or slow down to a velocity, hold it, and
    /// come to rest, the best of a fine grid is never shorter.
    #[test]
    fn trapezoids_are_as_fast_as_the_best_of_many((from, to, limits) in moves()) {
        let limits = Limits { jerk: None, ..limits };
        let profile = MotionProfile::from_motion(from, to, limits).unwrap();
        let (most, way) = (limits.acceleration, to - from.position);
        let mut best = f64::INFINITY;
        for step in -2_000..=2_000 {
            let peak = limits.velocity * f64::from(step) / 2_000.0;
            let changes = [(from.velocity, peak), (peak, 0.0)];
            let times = changes.map(|(a, b)| (b - a).abs() / most);
            let gone: f64 = changes.iter().zip(times).map(|((a, b), time)| 0.5 * (a + b) * time).sum();
            let holding = (way - gone) / peak;
            if holding >= 0.0 {
                best = best.min(times[0] + times[1] + holding);
            }
        }
        prop_assert!(profile.duration() <= best * (1.0 + 1e-9), "{} and not {best}: {profile:?}", profile.duration());
    }

    #[test]
    fn results_are_never_nan(at: f64, v: f64, a: f64, to: f64, end: f64, velocity: f64, acceleration: f64, jerk: Option<f64>, time: f64) {
        let limits = Limits { velocity, acceleration, jerk };
        let all = [MotionProfile::stop(state(at, v, a), limits), MotionProfile::passing(state(at, v, a), to, end, limits)];
        for profile in all.into_iter().flatten() {
            for time in [time.clamp(-1.0, profile.duration()), 0.3 * profile.duration(), profile.duration()] {
                let MotionState { position, velocity, acceleration } = profile.at(time);
                prop_assert!(position.is_finite() && velocity.is_finite() && acceleration.is_finite(), "{profile:?}");
            }
        }
    }
}
