//! Motion profiles from rest to rest: the laws of `motion_core::profile`.

#![expect(clippy::float_cmp, reason = "what is exact by law is compared exactly")]

use motion_core::profile::{Limits, MotionProfile, MotionProfileError, MotionState};
use proptest::prelude::*;

const PLAIN: Limits = Limits { velocity: 2.0, acceleration: 1.0, jerk: None };

fn soft(jerk: f64) -> Limits {
    Limits { jerk: Some(jerk), ..PLAIN }
}

fn close(a: f64, b: f64, bound: f64) -> bool {
    (a - b).abs() <= bound
}

#[test]
fn a_long_move_is_a_trapezoid_and_a_short_one_a_triangle() {
    // 2 s and 2 units to full speed, 3 s at full speed.
    let long = MotionProfile::new(1.0, 11.0, PLAIN).unwrap();
    assert_eq!((long.duration(), long.peak_velocity()), (7.0, 2.0));
    let at = |time| long.at(time);
    assert_eq!(at(0.0), MotionState { position: 1.0, velocity: 0.0, acceleration: 1.0 });
    assert_eq!(at(1.0), MotionState { position: 1.5, velocity: 1.0, acceleration: 1.0 });
    assert_eq!(at(3.5), MotionState { position: 6.0, velocity: 2.0, acceleration: 0.0 });
    assert_eq!(at(6.0), MotionState { position: 10.5, velocity: 1.0, acceleration: -1.0 });
    assert_eq!(at(7.5), MotionState { position: 11.0, velocity: 0.0, acceleration: 0.0 });

    let short = MotionProfile::new(0.0, -1.0, PLAIN).unwrap();
    assert_eq!((short.duration(), short.peak_velocity()), (2.0, 1.0));
    assert_eq!(short.at(0.5), MotionState { position: -0.125, velocity: -0.5, acceleration: -1.0 });
}

#[test]
fn s_curves_have_seven_five_or_four_parts() {
    // Acceleration rises for 0.5 s and is constant for 1.5 s; velocity is constant for 2.5 s.
    assert_eq!(MotionProfile::new(0.0, 10.0, soft(2.0)).unwrap().duration(), 7.5);
    // Too short for full speed: a (r + h) (2 r + h) with r = h = 0.5.
    assert_eq!(MotionProfile::new(0.0, 1.5, soft(2.0)).unwrap().duration(), 3.0);
    // Too short for full acceleration: 2 j r³ with r = 0.25.
    assert_eq!(MotionProfile::new(0.0, 0.0625, soft(2.0)).unwrap().duration(), 1.0);
    // Full speed before full acceleration: r² = v / j = 4, and 1 s at full speed.
    let gentle = MotionProfile::new(0.0, 10.0, soft(0.5)).unwrap();
    assert_eq!((gentle.duration(), gentle.at(2.0).acceleration), (9.0, 1.0));
}

#[test]
fn a_move_of_distance_0_has_duration_0() {
    let still = MotionProfile::new(3.0, 3.0, soft(1.0)).unwrap();
    assert_eq!(still.duration(), 0.0);
    for time in [-1.0, 0.0, 1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(still.at(time), MotionState { position: 3.0, ..MotionState::default() });
    }
}

#[test]
fn positions_and_limits_out_of_range_are_refused() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(MotionProfile::new(bad, 0.0, PLAIN), Err(MotionProfileError::NotFinite));
        assert_eq!(MotionProfile::new(0.0, bad, PLAIN), Err(MotionProfileError::NotFinite));
    }
    for bad in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
        let limits = [Limits { velocity: bad, ..PLAIN }, Limits { acceleration: bad, ..PLAIN }, soft(bad)];
        for limits in limits {
            assert_eq!(MotionProfile::new(0.0, 1.0, limits), Err(MotionProfileError::Limit));
        }
    }
    assert_eq!(MotionProfile::new(-f64::MAX, f64::MAX, PLAIN), Err(MotionProfileError::OutOfRange));
    let crawling = Limits { velocity: 1e-300, ..PLAIN };
    assert_eq!(MotionProfile::new(0.0, 1e300, crawling), Err(MotionProfileError::OutOfRange));
    assert_eq!(
        MotionProfile::new(0.0, 1e-300, Limits { acceleration: 1e300, ..PLAIN }),
        Err(MotionProfileError::OutOfRange)
    );
}

#[test]
fn nan_and_infinite_times_are_before_or_after_the_move() {
    let profile = MotionProfile::new(1.0, 2.0, PLAIN).unwrap();
    assert_eq!(profile.at(f64::NAN).position, 1.0);
    assert_eq!(profile.at(f64::NEG_INFINITY).position, 1.0);
    assert_eq!(profile.at(f64::INFINITY).position, 2.0);
}

/// Numbers of any size from 1e-6 to 1e6.
fn size() -> impl Strategy<Value = f64> {
    (-6.0..6.0).prop_map(|exponent: f64| 10_f64.powf(exponent))
}

prop_compose! {
    fn moves()(from in -1e3..1e3, way in size(), back: bool, velocity in size(), acceleration in size(),
        jerk in proptest::option::of(size())) -> MotionProfile {
        let to = if back { from - way } else { from + way };
        MotionProfile::new(from, to, Limits { velocity, acceleration, jerk }).unwrap()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    /// The ends are exact, and neither an end nor a limit is exceeded.
    #[test]
    fn ends_are_exact_and_limits_hold(profile in moves(), share in 0.0..=1.0) {
        let (from, to, limits) = (profile.start(), profile.target(), profile.limits());
        prop_assert_eq!(profile.at(0.0).position, from);
        prop_assert_eq!(profile.at(profile.duration()).position, to);
        prop_assert_eq!(profile.at(profile.duration()).velocity.abs(), 0.0);
        let state = profile.at(share * profile.duration());
        prop_assert!(from.min(to) <= state.position && state.position <= from.max(to));
        prop_assert!(state.velocity.abs() <= limits.velocity);
        prop_assert!(state.acceleration.abs() <= limits.acceleration);
        prop_assert!(state.velocity * (to - from) >= 0.0);
    }

    /// Velocity is the derivative of position, acceleration that of velocity, and jerk is limited: the gain over a span
    /// is its length times the rate in the middle, within a bound from the limits.
    #[test]
    fn rates_are_derivatives(profile in moves(), share in 0.0..1.0, part in 1e-4..1e-2) {
        let (limits, span) = (profile.limits(), part * profile.duration());
        let begin = share * (profile.duration() - span);
        let [a, b, c] = [begin, begin + 0.5 * span, begin + span].map(|time| profile.at(time));
        let noise = 1e-9;
        // The mean velocity differs from that in the middle by at most half the span times acceleration.
        let largest = profile.start().abs().max(profile.target().abs());
        let gone = c.position - a.position;
        let bound = 0.25 * span * span * limits.acceleration * (1.0 + noise) + 8.0 * f64::EPSILON * largest;
        prop_assert!(close(gone, b.velocity * span, bound), "{gone} in {span}");
        let gained = (c.velocity - a.velocity).abs();
        prop_assert!(gained <= span * limits.acceleration * (1.0 + noise) + noise * profile.peak_velocity());
        if let Some(jerk) = limits.jerk {
            let swing = (c.acceleration - a.acceleration).abs();
            prop_assert!(swing <= span * jerk * (1.0 + noise) + noise * limits.acceleration, "{swing} in {span}");
            let bound = 0.25 * span * span * jerk * (1.0 + noise) + noise * profile.peak_velocity();
            prop_assert!(close(c.velocity - a.velocity, b.acceleration * span, bound));
        }
    }

    /// The distance that is left before the end equals the distance travelled after the start.
    #[test]
    fn profiles_are_symmetric(profile in moves(), share in 0.0..=1.0) {
        let time = share * profile.duration();
        let (early, late) = (profile.at(time), profile.at(profile.duration() - time));
        let (gone, left) = (early.position - profile.start(), profile.target() - late.position);
        let largest = profile.start().abs().max(profile.target().abs());
        prop_assert!(close(gone, left, 1e-12 * largest), "{gone} and {left}");
    }

    /// At every time, velocity, acceleration or jerk is at its limit, so no faster move exists.
    #[test]
    fn some_limit_is_reached(profile in moves(), share in 0.01..0.49) {
        let (limits, time, span) = (profile.limits(), share * profile.duration(), 1e-6 * profile.duration());
        // A corner between two parts can be before the time or after it, but not on both sides.
        let [before, now, after] = [time - span, time, time + span].map(|time| profile.at(time));
        let reached = [(before, now), (now, after)].into_iter().any(|(one, other)| {
            let swing = (other.acceleration - one.acceleration).abs() / span;
            one.velocity.abs().min(other.velocity.abs()) >= 0.999_999 * limits.velocity
                || one.acceleration.abs().min(other.acceleration.abs()) >= 0.999_999 * limits.acceleration
                || limits.jerk.is_some_and(|jerk| swing >= 0.999 * jerk)
        });
        prop_assert!(reached, "{before:?} {after:?}");
    }

    /// Any numbers are refused, or give finite results.
    #[test]
    fn results_are_never_nan(from: f64, to: f64, velocity: f64, acceleration: f64, jerk: Option<f64>, time: f64, share in 0.0..1.0) {
        if let Ok(profile) = MotionProfile::new(from, to, Limits { velocity, acceleration, jerk }) {
            for time in [time, share * profile.duration(), profile.duration()] {
                let MotionState { position, velocity, acceleration } = profile.at(time);
                prop_assert!(position.is_finite() && velocity.is_finite() && acceleration.is_finite());
            }
        }
    }
}
