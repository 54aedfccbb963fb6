//! Motors that are told anything, at any moment.

use motion_core::profile::Limits;
use motion_core::time::Millis;
use motion_core::trajectory::Range;
use motion_rigs::motor::{Happening, Motor};
use proptest::collection::vec;
use proptest::prelude::*;

const LIMITS: Limits = Limits { velocity: 10.0, acceleration: 20.0, jerk: None };
const TRAVEL: Range = Range::new(-30.0, 30.0);
/// What rounding may add to a way or a speed.
const ROUNDING: f64 = 1e-9;

#[derive(Debug, Clone, Copy)]
enum Asked {
    GoTo(f64, f64, f64),
    Run(f64, f64),
    Stop(Option<f64>),
}

fn asked() -> impl Strategy<Value = Asked> {
    let speed = || prop_oneof![8 => 0.1..15.0, 1 => Just(0.0), 1 => any::<f64>()];
    let hard = || prop_oneof![8 => 1.0..30.0, 1 => Just(0.0), 1 => any::<f64>()];
    prop_oneof![
        4 => (prop_oneof![8 => -25.0..25.0, 1 => any::<f64>()], speed(), hard()).prop_map(|(to, speed, hard)| Asked::GoTo(to, speed, hard)),
        2 => (-15.0..15.0, hard()).prop_map(|(speed, hard)| Asked::Run(speed, hard)),
        1 => prop::option::of(hard()).prop_map(Asked::Stop),
    ]
}

proptest! {
    /// A motor never jumps, is never faster than it can be, never speeds up more sharply, and never leaves its travel but
    /// to stand at its end. What it was told last it does, and says so once.
    #[test]
    fn a_motor_moves_as_motors_do(all in vec((asked(), 0_u64..3000), 1..20)) {
        let mut motor = Motor::new(LIMITS).within(TRAVEL);
        let mut now = 0;
        let mut before = motor.at(Millis(0));
        let mut rests = 0;
        let mut step = |motor: &mut Motor, now: u64| {
            let happening = motor.advance(Millis(now));
            let here = motor.at(Millis(now));
            let way = (here.position - before.position).abs();
            assert!(way <= LIMITS.velocity / 1000.0 + ROUNDING, "{way} at {now}");
            assert!(here.velocity.abs() <= LIMITS.velocity + ROUNDING);
            let tripped = matches!(happening, Some(Happening::Tripped { .. }));
            let at_end = here.position.abs() >= TRAVEL.to;
            let change = (here.velocity - before.velocity).abs();
            assert!(change <= LIMITS.acceleration / 1000.0 + ROUNDING || tripped || at_end, "{change} at {now}");
            assert!(here.position.abs() <= TRAVEL.to);
            before = here;
            rests += u32::from(happening == Some(Happening::Rests));
        };
        for (told, wait) in &all {
            match *told {
                Asked::GoTo(to, speed, hard) => motor.go_to(Millis(now), to, speed, hard),
                Asked::Run(speed, hard) => motor.run(Millis(now), speed, hard),
                Asked::Stop(hard) => motor.stop(Millis(now), hard),
            }
            for _ in 0..*wait {
                step(&mut motor, now);
                now += 1;
            }
        }
        // What runs into an end while it is told something stands there.
        motor.stop(Millis(now), None);
        for _ in 0..1000 {
            step(&mut motor, now);
            now += 1;
        }
        motor.go_to(Millis(now), 7.0, 10.0, 20.0);
        for _ in 0..6000 {
            step(&mut motor, now);
            now += 1;
        }
        assert!(motor.is_idle());
        assert!((2..=all.len() + 2).contains(&usize::try_from(rests).unwrap()), "{rests}");
        prop_assert_eq!(before.position.to_bits(), 7.0_f64.to_bits());
        prop_assert_eq!(before.velocity.to_bits(), 0.0_f64.to_bits());
    }
}
