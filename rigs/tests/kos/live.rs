//! Moves in real time: each motor is at its planned position at every tick.

use kos_proto::device::playback::State;
use kos_proto::host::{self, Move};
use kos_proto::message::{Direction, MotorAddress, Normalized, Seconds};
use kos_proto::trajectory::{Loop, Times};
use motion_rigs::Rig as _;
use motion_rigs::device::Named as _;
use motion_rigs::kos_device::Setup;
use motion_rigs::kos_host::{Command, StoredMove};

use crate::bench::{Bench, M1, M2, RANGES, TOLERANCE, live, number, planned, play};

/// Follows a move to its end, and compares each tick of each pass with the plan. Returns the states of the passes.
///
/// `rapid` is the duration of a pass back, in milliseconds.
fn follow(bench: &mut Bench, rapid: u64) -> Vec<State> {
    let begins = [M1, M2].map(|motor| bench.at(motor) - position(bench, motor));
    let (mut legs, mut start) = (Vec::new(), 0);
    for _ in 0..60_000 {
        let state = bench.scene.rig.machine().playback();
        if legs.last() != Some(&state) && bench.plays() {
            legs.push(state);
            start = bench.now();
        }
        if bench.plays() {
            let takes = if state == legs[0] { 5000 } else { rapid };
            let part = number(bench.now() - start) / number(takes);
            let seconds = 5.0 * if state == State::Forward { part } else { 1.0 - part };
            let moment = bench.scene.rig.moment().unwrap();
            assert!((moment - seconds).abs() < 1e-9, "{moment} is not {seconds}");
            for (motor, begin) in [M1, M2].into_iter().zip(begins) {
                let (is, should) = (bench.at(motor), planned(motor, begin, seconds));
                assert!((is - should).abs() < TOLERANCE, "motor {motor} at {seconds} s: {is}, should be {should}");
            }
        } else if !legs.is_empty() {
            break;
        }
        bench.tick();
    }
    assert!(bench.rests());
    legs
}

/// Position of a motor in its range.
fn position(bench: &Bench, motor: MotorAddress) -> f64 {
    bench.scene.rig.machine().motor(motor).unwrap().position().0.into()
}

fn started(stored: StoredMove) -> Bench {
    let mut bench = Bench::calibrated();
    bench.command(Command::Load { stored, delay_return: false });
    bench.pass(100);
    // No move is played while the motors go to where it begins.
    assert!(!bench.rests() && bench.scene.rig.moment().is_none());
    bench.expect_move(Move::Ready);
    bench.send(host::Command::Play);
    // The command arrives at this time.
    bench.pass(0);
    bench
}

#[test]
fn a_move_is_played_as_planned() {
    let mut bench = started(live(Loop::Once));
    assert_eq!(follow(&mut bench, 5000), [State::Forward]);
    bench.expect_move(Move::EndReached);
    bench.expect_move(Move::Finished { requested: false });
    assert!((bench.at(M1) - 10.5).abs() < TOLERANCE && !bench.may_move());
    assert_eq!(bench.scene.rig.moment(), None);
}

#[test]
fn a_move_is_played_in_reverse() {
    for quirks in ["", "ignores-direction"] {
        let setup = Setup::with_motors(2).with_quirks(quirks).unwrap();
        let mut bench = Bench::ready(setup).with_ranges();
        let begins = [M1, M2].map(|motor| bench.at(motor) - position(&bench, motor));
        play(&mut bench, live(Loop::Once).reversed().unwrap());
        let mut ticks = 0;
        while bench.plays() {
            let seconds = 5.0 - bench.scene.rig.moment().unwrap();
            for (motor, begin) in [M1, M2].into_iter().zip(begins) {
                let (is, should) = (bench.at(motor), planned(motor, begin, seconds));
                assert!((is - should).abs() < TOLERANCE, "motor {motor} at {seconds} s: {is}, should be {should}");
            }
            ticks += 1;
            bench.tick();
        }
        assert!(ticks >= 4999, "{ticks}");
        bench.expect_move(Move::Finished { requested: false });
        assert!((bench.at(M1) - 2.0).abs() < TOLERANCE && !bench.may_move());
    }
}

#[test]
fn loops_play_the_move_back_and_again() {
    let mut bench = started(live(Loop::Reverse(Times::new(2).unwrap())));
    let (there, back) = (State::Forward, State::Reverse);
    assert_eq!(follow(&mut bench, 5000), [there, back, there, back, there]);
    let rapid = Loop::RapidReverse { times: Times::new(1).unwrap(), duration: Some(Seconds(2.5)) };
    let mut bench = started(live(rapid));
    assert_eq!(follow(&mut bench, 2500), [there, back, there]);
}

#[test]
fn a_move_waits_for_its_time() {
    use kos_proto::trajectory::{Delay, LiveMotion, Play};
    let live = LiveMotion {
        duration: Seconds(5.0),
        repeat: Loop::Once,
        delay: Delay::Until(1_800_000_020),
        home_speed: Normalized(0.2),
    };
    let mut setup = Setup::with_motors(2);
    setup.options = setup.options.with_unix_millis_at_zero(Some(1_800_000_000_000));
    let mut bench = Bench::ready(setup).with_ranges();
    let stored = crate::bench::stored(Play::Live(live));
    bench.command(Command::PlayDirect { stored });
    bench.expect_move(Move::Running(Direction::Forward));
    assert_eq!(bench.now(), 20_000);
    bench.expect_move(Move::EndReached);
    assert_eq!(bench.now(), 25_000);
}

#[test]
fn a_move_is_stopped_in_its_middle() {
    let mut bench = Bench::calibrated();
    play(&mut bench, live(Loop::Once));
    bench.pass(1500);
    let from = bench.at(M1);
    assert!(!bench.rests());
    let now = bench.now();
    bench.stop();
    // The motor is fast at this time, and stops with 100 rev/s².
    assert!(bench.now() - now < 300 && (bench.at(M1) - from).abs() < 3.0);
    let there = bench.at(M1);
    bench.pass(10_000);
    assert_eq!(bench.at(M1).to_bits(), there.to_bits());
    // The device forgot the move, and the move can be stored and played again.
    assert!(bench.scene.rig.machine().stored_move().is_none());
    play(&mut bench, live(Loop::Once));
    bench.expect_move(Move::Finished { requested: false });
}

#[test]
fn a_client_finds_its_move_again_after_a_lost_connection() {
    let mut bench = Bench::calibrated();
    play(&mut bench, live(Loop::Reverse(Times::new(1).unwrap())));
    bench.pass(1000);
    bench.scene.unplug();
    bench.expect_move(Move::Lost);
    assert!(bench.may_move() && !bench.rests());
    bench.expect_move(Move::Found(host::MoveState::Running));
    bench.expect_event(|event| matches!(event, host::Event::Ready { .. }));
    bench.expect_move(Move::Finished { requested: false });
    assert!(bench.rests() && !bench.may_move());
    assert!((position(&bench, M1) - 10.5).abs() < TOLERANCE);
    assert!(position(&bench, M2) - RANGES[1] > 0.9);
}
