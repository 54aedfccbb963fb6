//! Ranges of motors: kOS 7.3.

use kos_proto::HostMessage;
use kos_proto::device::motor::State;
use kos_proto::device::{Event, Ignored, Options, Quirks, Report};
use kos_proto::message::*;

use super::bench::*;

const MOTOR: MotorAddress = MotorAddress(1);

fn moved(motor: u8, to: f32) -> Event<'static> {
    let (speed, acceleration) = (RotationsPerSecond(10.0), RotationsPerSecondSquared(50.0));
    Event::Move { motor: MotorAddress(motor), to: Rotations(to), speed, acceleration }
}

fn bench() -> Bench {
    Bench::new(Options::default())
}

fn calibration(bench: &Bench) -> (State, f32, f32) {
    let drive = bench.machine.motor(MOTOR).unwrap();
    (drive.state(), drive.position().0, drive.range().1.0)
}

/// 7.3-1.
#[test]
fn a_jog_without_a_range_runs_until_it_is_stopped() {
    for far in [25_000.0, -25_000.0] {
        let mut bench = bench();
        bench.receive(set_psa(1, far, 10.0));
        assert_eq!((bench.events(), bench.messages().len()), (vec![moved(1, far)], 0));
        assert_eq!(bench.machine.motor(MOTOR).unwrap().motion().name(), "Moving");
    }
}

/// 7.3-2: speed 0 stops a motor for any position, and each attempt stops each motor once (decision K-M10).
#[test]
fn speed_0_stops_a_motor_whatever_the_position_is() {
    for (position, acceleration) in [(0.0, 20.0), (f32::NAN, 0.0), (1e30, f32::NAN)] {
        for is_bump in [false, true] {
            let mut bench = bench();
            bench.receive(set_psa(1, 25_000.0, 10.0));
            bench.clear();
            let acceleration = RotationsPerSecondSquared(acceleration);
            let stop = match (set_psa(1, position, 0.0), bump(1, position, -0.0)) {
                (HostMessage::SetPositionSpeedAcceleration(set), _) if !is_bump => {
                    HostMessage::from(SetPositionSpeedAcceleration { acceleration, ..set })
                }
                (_, bump) => bump,
            };
            bench.receive(stop);
            let told = bench.events();
            let [Event::StopMotor { motor: MOTOR, acceleration: given }] = told[..] else { panic!("{told:?}") };
            assert_eq!(given.is_some(), is_bump || acceleration.0 > 0.0, "0 is never handed on");
            assert_eq!(bench.messages().len(), 0);
            bench.arrive(1, 6.5);
            assert_eq!(bench.messages(), ["0: 1 rests at 6.5"]);
            // A motor that is stopped at rest reports where it rests.
            bench.receive(set_psa(1, 0.0, 0.0));
            assert_eq!((bench.events().len(), bench.messages()), (0, vec!["0: 1 rests at 6.5".into()]));
        }
    }
}

/// 7.3-3: a motor that moves is marked where it is, and goes on (decision K-S6).
#[test]
fn the_range_begins_where_the_motor_is() {
    let mut bench = bench();
    bench.receive(set_psa(1, 25_000.0, 10.0));
    bench.rig(Report::At(MOTOR, Rotations(3.0)));
    bench.clear();
    bench.receive(mark_begin(1));
    assert_eq!((bench.messages().len(), bench.events().len()), (0, 0));
    assert_eq!(calibration(&bench), (State::BeginMarked, 3.0, 0.0));
    bench.arrive(1, 5.0);
    bench.clear();
    bench.receive(mark_begin(1));
    assert_eq!((bench.messages().len(), calibration(&bench)), (0, (State::BeginMarked, 5.0, 0.0)));

    // The earlier range is void.
    bench.calibrate(1);
    bench.receive(mark_begin(1));
    assert_eq!(calibration(&bench), (State::BeginMarked, RANGE, 0.0));
}

/// 7.3-4.
#[test]
fn a_motor_moves_freely_between_the_marks() {
    let mut bench = bench();
    bench.arrive(1, 5.0);
    bench.receive(mark_begin(1));
    bench.clear();
    bench.receive(bump(1, 3.0, 10.0));
    bench.arrive(1, 8.0);
    bench.receive(set_psa(1, 25_000.0, 10.0));
    bench.arrive(1, 9.0);
    assert_eq!(bench.events(), [moved(1, 8.0), moved(1, 25_000.0)]);
    assert_eq!(bench.messages(), ["0: 1 rests at 8.0", "0: 1 rests at 9.0"]);
    assert_eq!(calibration(&bench).0, State::BeginMarked);
}

/// 7.3-5: a motor that moves is stopped at the end of its range. Positions count from the begin of the range, or, on firmware 1.0.1.5, as before (decision K-M8).
#[test]
fn the_range_ends_where_the_motor_is() {
    for (quirk, said, position, five) in [
        (Quirks::empty(), "0: 1 goes 0.0 to -8.0", -8.0, 0.0),
        (Quirks::BEGIN_NONZERO, "0: 1 goes 5.0 to -3.0", -3.0, 5.0),
    ] {
        let mut bench = Bench::new(Options::default().with_quirks(quirk));
        bench.arrive(1, 5.0);
        bench.receive(mark_begin(1));
        bench.receive(set_psa(1, -25_000.0, 10.0));
        bench.rig(Report::At(MOTOR, Rotations(-3.0)));
        bench.clear();
        bench.receive(mark_end(1));
        let stops = Event::StopMotor { motor: MOTOR, acceleration: None };
        assert_eq!((bench.messages(), bench.events()), (vec![said.into()], vec![stops]), "it does not go on");
        bench.arrive(1, -3.0);
        assert_eq!(bench.messages(), [format!("0: 1 rests at {position:?}")]);
        assert_eq!((calibration(&bench).0, calibration(&bench).1), (State::Calibrated, position));
        // In both cases the positions of commands count from the begin of the range.
        bench.receive(set_psa(1, -2.0, 10.0));
        assert_eq!(bench.events(), [moved(1, 3.0)]);
        bench.arrive(1, 3.0);
        assert_eq!(bench.messages(), [format!("0: 1 rests at {:?}", five - 2.0)]);
        bench.receive(bump(1, -1.0, 10.0));
        assert_eq!(bench.events(), [moved(1, 2.0)]);
    }
}

/// 7.3-6, 7.3-7.
#[test]
fn a_range_without_a_begin_or_a_length_is_an_error() {
    let mut bench = bench();
    bench.arrive(1, 5.0);
    bench.receive(mark_end(1));
    assert_eq!((bench.messages(), calibration(&bench).0), (vec!["0: error 14 1".into()], State::Uncalibrated));
    bench.receive(mark_begin(1));
    bench.receive(mark_end(1));
    assert_eq!(
        (bench.messages(), calibration(&bench)),
        (vec!["0: error 14 1".into()], (State::Uncalibrated, 0.0, 0.0))
    );
}

/// 7.3-8, 7.3-9: the same is true of a bump.
#[test]
fn a_motor_goes_where_it_is_sent_but_not_beyond_its_range() {
    let mut bench = bench();
    bench.calibrate(1);
    bench.clear();
    for (position, to) in [(2.5, 2.5), (0.0, 0.0), (RANGE, RANGE), (9.0, RANGE), (-0.5, 0.0), (25_000.0, RANGE)] {
        bench.receive(set_psa(1, position, 10.0));
        assert_eq!(bench.events(), [moved(1, to)]);
        bench.arrive(1, to);
        assert_eq!(bench.messages(), [format!("0: 1 rests at {to:?}")]);
    }
    bench.receive(bump(1, -3.0, 10.0));
    bench.receive(bump(1, 3.0, 10.0));
    assert_eq!(bench.events(), [moved(1, 5.0), moved(1, RANGE)]);
    bench.arrive(1, RANGE);
    assert_eq!(bench.messages(), [format!("0: 1 rests at {RANGE:?}")], "once, because the second replaced the first");

    // A device with the quirk goes on.
    let mut bench = Bench::new(Options::default().with_quirks(Quirks::NOT_CLAMPED));
    bench.calibrate(1);
    bench.clear();
    bench.receive(set_psa(1, 25_000.0, 10.0));
    bench.receive(bump(1, 9.0, 10.0));
    assert_eq!(bench.events(), [moved(1, 25_000.0), moved(1, RANGE + 9.0)]);
}

/// A command with a NaN, infinite, negative or much too large value moves nothing (decision K-N1).
#[test]
fn invalid_numbers_move_nothing() {
    let mut bench = bench();
    for (position, speed) in [(f32::NAN, 1.0), (f32::INFINITY, 1.0), (1.0, f32::NAN), (1.0, -1.0), (1.0, f32::INFINITY)]
    {
        for message in [set_psa(1, position, speed), bump(1, position, speed)] {
            bench.receive(message);
            let told = vec!["0: error 2 0".into(), "0: 1 rests at 0.0".to_owned()];
            assert_eq!((bench.messages(), bench.events().len()), (told, 0), "{message}");
        }
    }
    bench.arrive(1, 3e38);
    bench.receive(bump(1, 3e38, 1.0));
    assert_eq!((bench.messages().len(), bench.events().len()), (2, 0));
    // A motor that moves reports when it rests, because of the motion that it was sent on before.
    bench.receive(bump(1, -1e38, 1.0));
    bench.clear();
    bench.receive(bump(1, f32::NAN, 1.0));
    assert_eq!((bench.messages(), bench.events().len()), (vec!["0: error 2 0".into()], 0));
    bench.rig(Report::At(MOTOR, Rotations(f32::NAN)));
    bench.rig(Report::Arrived(MotorAddress(9), Rotations(1.0)));
    assert_eq!(bench.events(), [Event::Ignored(Ignored::Report); 2]);
}

/// 7.3-10: a motor that moves is stopped, because its target has lost its meaning.
#[test]
fn a_reset_of_a_motor_forgets_its_range() {
    let mut bench = bench();
    bench.calibrate(1);
    bench.clear();
    bench.receive(reset_axis(0x81));
    assert_eq!(
        (bench.messages(), calibration(&bench)),
        (vec!["0: 1 goes 0.0 to 0.0".into()], (State::Uncalibrated, 0.0, 0.0))
    );
    bench.receive(set_psa(1, 25_000.0, 10.0));
    bench.clear();
    bench.receive(reset_axis(1));
    assert_eq!(bench.events(), [Event::StopMotor { motor: MOTOR, acceleration: None }]);
}

/// 7.3-11.
#[test]
fn a_reset_of_all_motors_is_not_answered() {
    let mut bench = bench();
    bench.calibrate(1);
    bench.calibrate(2);
    bench.clear();
    bench.receive(reset_axis(0));
    assert_eq!((bench.messages().len(), bench.events().len()), (0, 0));
    let states = [1, 2, 3].map(|motor| bench.machine.calibration(MotorAddress(motor)));
    assert_eq!(states, [Some(State::Uncalibrated); 3]);
}

/// 7.3-12: the motor stops. Other faults leave the range.
#[test]
fn faults_void_the_range_if_their_code_says_so() {
    for (code, left) in [(10, false), (16, false), (14, false), (11, true), (12, true), (13, true)] {
        let mut bench = bench();
        bench.calibrate(1);
        bench.receive(set_psa(1, 1.0, 10.0));
        bench.clear();
        bench.rig(Report::Fault(MOTOR, ErrorCode(code)));
        assert_eq!(bench.messages(), [format!("0: error {code} 1")]);
        assert_eq!(bench.events(), [Event::StopMotor { motor: MOTOR, acceleration: None }]);
        assert_eq!(calibration(&bench).0 == State::Calibrated, left, "{code}");
    }
}

/// 7.3-13: a stop of a motor that does not exist is refused too.
#[test]
fn an_unknown_motor_is_an_error() {
    let mut bench = bench();
    for motor in [0, 4, 11, 127] {
        let mark = [mark_begin(motor), mark_end(motor)];
        let go = [set_psa(motor, 1.0, 1.0), bump(motor, 1.0, 1.0), set_psa(motor, 1.0, 0.0), bump(motor, 1.0, 0.0)];
        for message in mark.into_iter().chain(go) {
            bench.receive(message);
            assert_eq!((bench.messages(), bench.events().len()), (vec![format!("0: error 4 {motor}")], 0), "{message}");
        }
    }
    bench.receive(reset_axis(4));
    assert_eq!(bench.messages(), ["0: error 4 4"]);
}
