//! Live motion: kOS 7.4.

use kos_proto::device::{Contents, Event, Input, Options, Quirks, Report};
use kos_proto::message::*;
use kos_proto::trajectory::*;
use kos_proto::{HostMessage, Millis};

use super::bench::*;

const RAPID: HostMessage<'static> = HostMessage::RapidToFirstKeyFrame(RapidToFirstKeyFrame { tail: &[] });
/// Noon, in Unix seconds. At `Millis(0)` the clock of the device is half an hour before noon.
const NOON: u32 = 1_700_000_000;
const RESTS: [&str; 3] = ["0: 1 rests at 8.0", "0: 2 rests at 8.0", "0: 3 rests at 0.0"];

/// Change that makes a motor unfit for a move.
type Spoil = fn(&mut Bench);

fn set(data: TrajectoryData<'_>) -> HostMessage<'_> {
    HostMessage::from(data)
}

fn loaded() -> Bench {
    Bench::loaded(Options::default().with_progress_every(None), live_move(live()))
}

/// A device that plays this move.
fn played(playback: Playback<'_>) -> Bench {
    let options = Options::default().with_progress_every(None).with_unix_millis_at_zero(Some(clock()));
    let mut bench = Bench::loaded(options, live_move(playback));
    bench.receive(start());
    bench.home();
    bench.clear();
    bench
}

fn clock() -> u64 {
    u64::from(NOON) * 1000 - 1_800_000
}

fn until(seconds: u32) -> Playback<'static> {
    let delay_interval_bits = DelayInterval::from_unix_time(seconds);
    Playback { delay_mode: DelayMode::UNTIL, delay_interval_bits, ..live() }
}

fn waiting(seconds: f32) -> Playback<'static> {
    let delay_interval_bits = DelayInterval::from_seconds(Seconds(seconds));
    Playback { delay_mode: DelayMode::INTERVAL, delay_interval_bits, ..live() }
}

fn home(way: Direction) -> Event<'static> {
    Event::Home { way, speed: Normalized(1.0), motors: MotorSet::of([MotorAddress(1), MotorAddress(2)]) }
}

fn play(way: Direction, millis: u64) -> Event<'static> {
    Event::Play { way, millis }
}

/// A device in each state in which a move runs.
fn running() -> Vec<Bench> {
    let homing = |message| {
        let mut bench = loaded();
        bench.receive(message);
        bench
    };
    let looped = Playback { loop_after_reverse: LoopCount(1), ..live() };
    let mut reverse = played(looped);
    reverse.pass(10_000);
    let mut all = vec![homing(setup(false)), homing(start()), homing(RAPID)];
    all.extend([played(waiting(5.0)), played(live()), reverse]);
    for bench in &mut all {
        assert!(bench.machine.playback().runs());
        bench.clear();
    }
    let states: Vec<_> = all.iter().map(Bench::state).collect();
    assert_eq!(states, ["HomingSetup", "HomingStart", "HomingRapid", "Delay", "Forward", "Reverse"]);
    all
}

/// 7.4-1: the status says again that there is no move (decision K-J16).
#[test]
fn a_move_is_stored() {
    let mut bench = played(live());
    bench.receive(STOP);
    bench.clear();
    bench.receive(GetDeviceInfo::default());
    bench.receive(set(live_move(live())));
    bench.receive(GetDeviceInfo::default());
    assert_eq!(bench.messages(), ["0: DeviceInfo FULL_STOP", "0: DeviceInfo NO_MOVE"]);
    assert_eq!((bench.events(), bench.state()), (vec![Event::StoreTrajectory(live_move(live()))], "Loaded"));
}

/// 7.4-2: the earlier move is forgotten. A move that takes no time has its own code (decision K-J10).
#[test]
fn a_move_that_cannot_be_played_is_refused() {
    let nothing = TrajectoryData { blocks: Blocks::default(), tail: &[] };
    let no_time = live_move(Playback { duration: Seconds(0.0), ..live() });
    let no_mode = live_move(Playback { playback_mode: PlaybackMode(9), ..live() });
    let no_delay = live_move(Playback { delay_mode: DelayMode(3), ..live() });
    let looped = Playback { loop_after_reverse: LoopCount(1), playback_mode: PlaybackMode::TIME_LAPSE_SMS, ..live() };
    let looped = trajectory(looped, photos(1.0, 1.0, 0, 5, 0));
    let both = Playback { loop_after_reverse: LoopCount(1), loop_after_rapid_reverse: LoopCount(1), ..live() };
    for (data, code) in [(nothing, 3), (no_time, 17), (no_mode, 3), (no_delay, 3), (looped, 3), (live_move(both), 3)] {
        let mut bench = loaded();
        bench.receive(set(data));
        assert_eq!((bench.messages(), bench.state()), (vec![format!("0: error {code} 0")], "Empty"));
        assert!(matches!(bench.events()[..], [Event::BadTrajectory(_)]));
    }
    let mut bench = loaded();
    let error = kos_proto::DecodeError::Truncated { what: "Axis", needed: 2, have: 1 };
    let (id, kind) = (kos_proto::MessageId::TRAJECTORY_DATA, kos_proto::MessageType::SET);
    bench.step(Input::Malformed { session: ZERO, id, kind, error, bytes: &[] });
    assert_eq!((bench.messages(), bench.state()), (vec!["0: error 3 0".into()], "Empty"));
}

/// 7.4-2: no motor can follow a curve outside its range (decision K-J8).
#[test]
fn a_move_that_leaves_a_range_is_refused_when_it_is_set() {
    let with = |out: f32, into: f32| {
        let mut blocks: Vec<_> = live_move(live()).blocks.iter().collect();
        for block in &mut blocks {
            if let Block::Segment(segment) = block {
                let Points([begin, first, second, end]) = segment.points;
                let handle = |at: Point, position| Point { position: Normalized(position), ..at };
                segment.points = Points([begin, handle(first, out), handle(second, into), end]);
            }
        }
        TrajectoryData { blocks: Blocks::encode(&blocks, vec![0; 1024].leak()).unwrap(), tail: &[] }
    };
    for (out, into) in [(1e38, 0.5), (0.5, 1e38), (-1e38, 0.5), (0.5, 2.0), (-0.5, 0.5)] {
        let mut bench = loaded();
        bench.receive(set(with(out, into)));
        assert_eq!((bench.messages(), bench.state()), (vec!["0: error 3 0".into()], "Empty"), "{out} {into}");
        assert!(matches!(bench.events()[..], [Event::BadTrajectory(_)]));
    }
    // A handle may lie outside, if the curve does not.
    let mut bench = loaded();
    bench.receive(set(with(1.1, 0.1)));
    assert_eq!(bench.state(), "Loaded");
}

/// 7.4-3.
#[test]
fn nothing_is_played_without_a_move() {
    for message in [setup(false), setup(true), start(), RAPID] {
        let mut bench = Bench::new(Options::default());
        bench.receive(message);
        assert_eq!((bench.messages(), bench.events().len(), bench.state()), (vec!["0: error 2 0".into()], 0, "Empty"));
    }
}

/// 7.4-4, 7.4-8.
#[test]
fn setup_sends_the_motors_to_where_the_move_begins() {
    let mut bench = loaded();
    bench.receive(setup(false));
    assert_eq!(
        (bench.events(), bench.messages().len(), bench.state()),
        (vec![home(Direction::Forward)], 0, "HomingSetup")
    );
    bench.arrive(2, 0.0);
    bench.arrive(2, 0.0);
    assert_eq!(bench.state(), "HomingSetup");
    bench.arrive(1, 0.0);
    assert_eq!(bench.messages(), ["0: MOTORS_HOME", "0: SETUP_COMPLETED"]);
    assert_eq!(bench.state(), "Ready");
}

/// 7.4-4: all motors of a move are present, rest and have ranges (decision K-J14).
#[test]
fn a_move_needs_motors_that_rest_and_know_their_ranges() {
    for message in [setup(false), setup(true), start(), RAPID] {
        let cases: [(Spoil, &str); 5] = [
            (|bench| bench.receive(reset_axis(2)), "0: error 2 0"),
            (|bench| bench.receive(mark_begin(2)), "0: error 2 0"),
            (|bench| bench.receive(set_psa(3, 1.0, 1.0)), "0: error 2 0"),
            (|bench| bench.rig(Report::Online(MotorAddress(2), false)), "0: error 4 2"),
            (|bench| (1..4).for_each(|motor| bench.rig(Report::Online(MotorAddress(motor), false))), "0: error 6 0"),
        ];
        for (spoil, error) in cases {
            let mut bench = loaded();
            spoil(&mut bench);
            bench.clear();
            bench.receive(message);
            assert_eq!((bench.messages(), bench.events().len(), bench.state()), (vec![error.into()], 0, "Loaded"));
        }
    }
}

/// 7.4-5, 7.4-13.
#[test]
fn setup_may_leave_the_motors_where_they_are() {
    let mut bench = loaded();
    bench.receive(setup(true));
    assert_eq!(
        (bench.events().len(), bench.messages(), bench.state()),
        (0, vec!["0: SETUP_COMPLETED".into()], "Ready")
    );
    bench.receive(start());
    assert_eq!((bench.events(), bench.state()), (vec![home(Direction::Forward)], "HomingStart"));
}

/// 7.4-6, 7.4-10, 7.4-14.
#[test]
fn a_start_sends_the_motors_to_where_the_move_begins_and_plays_it() {
    let mut bench = loaded();
    bench.receive(start());
    assert_eq!(
        (bench.events(), bench.messages().len(), bench.state()),
        (vec![home(Direction::Forward)], 0, "HomingStart")
    );
    bench.home();
    assert_eq!(bench.messages(), ["0: MOTORS_HOME", "0: START_FORWARD"]);
    assert_eq!((bench.events(), bench.state()), (vec![play(Direction::Forward, 10_000)], "Forward"));
}

/// 7.4-7: the move is loaded or ready, as before.
#[test]
fn rapid_to_first_key_frame_moves_the_motors_and_plays_nothing() {
    for ready in [false, true] {
        let mut bench = loaded();
        if ready {
            bench.receive(setup(true));
        }
        let before = bench.state();
        bench.clear();
        bench.receive(RAPID);
        assert_eq!((bench.events(), bench.state()), (vec![home(Direction::Forward)], "HomingRapid"));
        bench.home();
        assert_eq!((bench.messages(), bench.state()), (vec!["0: MOTORS_HOME".into()], before));
        // A ready move is played at once, because the motors are home.
        bench.receive(start());
        assert_eq!(bench.state(), if ready { "Forward" } else { "HomingStart" });
    }
}

/// 7.4-9: one start is stored, and only for the same direction.
#[test]
fn a_start_during_the_setup_is_stored_once() {
    let mut bench = loaded();
    bench.receive(setup(false));
    bench.receive(start_to(PlaybackDirection::REVERSE));
    assert_eq!(bench.messages(), ["0: error 2 0"]);
    bench.receive(start());
    assert_eq!((bench.messages().len(), bench.state()), (0, "HomingSetup"));
    bench.receive(start());
    assert_eq!(bench.messages(), ["0: error 2 0"]);
    bench.home();
    assert_eq!(bench.messages(), ["0: MOTORS_HOME", "0: SETUP_COMPLETED", "0: START_FORWARD"]);
    assert_eq!(bench.state(), "Forward");
}

/// 7.4-11: the rig reports that a motor cannot get home, or the time is over.
#[test]
fn a_motor_that_does_not_get_to_where_the_move_begins_ends_the_move() {
    for message in [setup(false), start(), RAPID] {
        for late in [false, true] {
            let mut bench = loaded();
            bench.receive(message);
            bench.arrive(1, 0.0);
            bench.clear();
            if late {
                bench.pass_with_client(600_000);
            } else {
                bench.rig(Report::CannotHome(MotorAddress(2)));
            }
            assert_eq!(bench.messages(), ["0: error 0 0", "0: FULL_STOP"]);
            assert_eq!((bench.events(), bench.state()), (vec![Event::StopAll], "Empty"));
            // No move is played until the motor rests.
            bench.receive(set(live_move(live())));
            bench.receive(start());
            assert_eq!(bench.messages(), ["0: error 2 0"]);
            bench.arrive(2, 4.0);
            bench.receive(start());
            assert_eq!(bench.messages(), ["0: 2 rests at 4.0"]);
        }
    }
}

/// 7.4-12.
#[test]
fn a_move_is_played_at_once_if_the_motors_are_where_it_begins() {
    let mut bench = loaded();
    bench.receive(setup(false));
    bench.home();
    bench.clear();
    bench.receive(start());
    assert_eq!(
        (bench.messages(), bench.events()),
        (vec!["0: START_FORWARD".into()], vec![play(Direction::Forward, 10_000)])
    );
}

/// 7.4-13: a motor that was moved by hand or marked again is no longer at the begin of the move (decision K-S7).
#[test]
fn motors_that_were_moved_by_hand_go_back_before_the_move() {
    let disturb: [fn(&mut Bench); 2] = [
        |bench| {
            bench.receive(set_psa(1, 1.0, 1.0));
            bench.arrive(1, 1.0);
        },
        |bench| bench.calibrate(2),
    ];
    for disturb in disturb {
        let mut bench = loaded();
        bench.receive(setup(false));
        bench.home();
        disturb(&mut bench);
        assert_eq!(bench.state(), "Ready");
        bench.clear();
        bench.receive(start());
        assert_eq!((bench.events(), bench.state()), (vec![home(Direction::Forward)], "HomingStart"));
    }
}

/// 7.4-15: a start time in the past is refused before anything moves, in every state (safety decision 5).
#[test]
fn a_start_time_that_has_passed_moves_nothing() {
    let clocks = [(Some(clock()), NOON - 1800), (None, NOON + 1800)];
    for (clock, moment) in clocks {
        let options = Options::default().with_unix_millis_at_zero(clock);
        let mut bench = Bench::loaded(options, live_move(until(moment)));
        bench.receive(start());
        assert_eq!(
            (bench.messages(), bench.events().len(), bench.state()),
            (vec!["0: error 17 0".into()], 0, "Loaded")
        );
        bench.receive(setup(true));
        bench.clear();
        bench.receive(start());
        assert_eq!((bench.messages(), bench.events().len(), bench.state()), (vec!["0: error 17 0".into()], 0, "Ready"));
        bench.receive(setup(false));
        bench.clear();
        bench.receive(start());
        assert_eq!((bench.messages(), bench.state()), (vec!["0: error 17 0".into()], "HomingSetup"));
    }
}

/// 7.4-16.
#[test]
fn a_start_time_that_passes_on_the_way_ends_the_move() {
    let options = Options::default().with_unix_millis_at_zero(Some(clock()));
    let mut bench = Bench::loaded(options, live_move(until(NOON)));
    bench.receive(start());
    bench.arrive(1, 0.0);
    bench.clear();
    bench.pass_with_client(1_799_000 - 360_000 - 1_000_000);
    bench.arrive(2, 0.0);
    assert_eq!(bench.state(), "Delay", "in time");

    let options = options.with_travel_limit(None);
    let mut bench = Bench::loaded(options, live_move(until(NOON)));
    bench.receive(start());
    bench.arrive(1, 0.0);
    bench.clear();
    bench.pass_with_client(1_799_000);
    bench.arrive(2, 0.0);
    assert_eq!(bench.messages(), ["0: MOTORS_HOME", "0: error 17 0", "0: FULL_STOP"]);
    assert_eq!((bench.events(), bench.state()), (vec![Event::StopAll], "Empty"));
}

/// 7.4-17, 7.4-18: the delay is a duration or a time of day.
#[test]
fn a_move_waits_for_its_time() {
    for (playback, wait) in [(waiting(2.5), 2_500), (until(NOON), 1_799_000)] {
        let mut bench = played(playback);
        assert_eq!(bench.state(), "Delay");
        bench.pass_with_client(wait - 500);
        bench.receive(GetDeviceInfo::default());
        assert_eq!(bench.messages(), ["0: DeviceInfo DELAY_TIMER_STARTED"]);
        bench.pass(499);
        assert_eq!((bench.messages().len(), bench.state()), (0, "Delay"));
        bench.pass(1);
        assert_eq!(
            (bench.messages(), bench.events()),
            (vec!["0: START_FORWARD".into()], vec![play(Direction::Forward, 10_000)])
        );
    }
    let mut bench = loaded();
    bench.receive(set(live_move(waiting(2.5))));
    bench.receive(start());
    bench.clear();
    bench.home();
    assert_eq!(bench.messages(), ["0: MOTORS_HOME", "0: DELAY_TIMER_STARTED"]);
    // DeviceInfo tells the remaining time.
    bench.now += 1_500;
    let (message, password) = (GetDeviceInfo::default().into(), Password(b""));
    let input = Input::Received { session: ZERO, message, bytes: &[], password };
    let output = bench.machine.advance(Millis(bench.now), input);
    let Some(Contents::DeviceInfo(activity)) = output.transmits().next().map(|transmit| &transmit.contents) else {
        panic!("{output:?}")
    };
    assert_eq!(activity.times.0, Seconds(1.0));
}

/// 7.4-19.
#[test]
fn the_progress_of_a_move_is_told_if_the_option_is_set() {
    let mut bench = Bench::loaded(Options::default().with_progress_every(Some(4_000)), live_move(live()));
    bench.receive(start());
    bench.home();
    bench.clear();
    bench.pass(9_999);
    assert_eq!((bench.messages(), bench.events().len()), (vec!["0: START_FORWARD".to_owned(); 2], 0));
}

/// 7.4-20, 7.4-21.
#[test]
fn a_move_is_forgotten_at_its_end() {
    let mut bench = played(live());
    bench.pass(9_999);
    assert_eq!(bench.messages().len(), 0);
    bench.pass(1);
    assert_eq!(bench.messages(), ["0: END_OF_MOVE", "0: FULL_STOP"]);
    assert_eq!((bench.events(), bench.state(), bench.machine.stored_move()), (vec![Event::MoveOver], "Empty", None));
    bench.receive(GetTrajectoryData::default());
    assert_eq!(bench.messages(), ["0: TrajectoryData { stored: false }"], "decision K-J15");
    bench.receive(start());
    assert_eq!(bench.messages(), ["0: error 2 0"], "decision K-J14");
}

/// 7.4-21, 7.4-22, 7.4-24: n loops are n passes back and n + 1 passes forward (decision K-J4).
#[test]
fn a_loop_plays_the_move_back_and_again() {
    let mut bench = played(Playback { loop_after_reverse: LoopCount(2), ..live() });
    for _ in 0..2 {
        bench.pass_with_client(10_000);
        assert_eq!(bench.messages(), ["0: END_OF_MOVE", "0: START_REVERSE"]);
        assert_eq!(bench.events(), [play(Direction::Reverse, 10_000)]);
        bench.pass_with_client(10_000);
        assert_eq!(bench.messages(), ["0: END_OF_MOVE", "0: START_FORWARD"]);
        assert_eq!(bench.events(), [play(Direction::Forward, 10_000)]);
    }
    bench.pass_with_client(10_000);
    assert_eq!(bench.messages(), ["0: END_OF_MOVE", "0: FULL_STOP"]);
}

/// 7.4-23: the way back has its own duration, and an endless loop has no count that grows.
#[test]
fn a_rapid_loop_plays_the_move_back_in_its_own_time() {
    let rapid =
        Playback { loop_after_rapid_reverse: LoopCount::FOREVER, rapid_reverse_duration: Seconds(2.0), ..live() };
    let mut bench = played(rapid);
    for _ in 0..300 {
        bench.receive(KeepAlive::default());
        bench.pass(10_000);
        assert_eq!(bench.events(), [play(Direction::Reverse, 2_000)]);
        bench.pass(2_000);
        assert_eq!(bench.events(), [play(Direction::Forward, 10_000)]);
    }
}

/// 7.4-25: the move is played in reverse (decision K-S8). An unknown direction or a start time moves nothing.
#[test]
fn a_move_is_played_in_reverse() {
    let mut bench = loaded();
    bench.receive(set(live_move(Playback { loop_after_reverse: LoopCount(1), ..live() })));
    bench.clear();
    bench.receive(start_to(PlaybackDirection::REVERSE));
    assert_eq!(bench.events(), [home(Direction::Reverse)]);
    bench.home();
    for way in [Direction::Forward, Direction::Reverse] {
        assert_eq!(bench.events(), [play(way.back(), 10_000)]);
        bench.pass_with_client(10_000);
    }
    bench.clear();
    bench.pass_with_client(10_000);
    assert_eq!((bench.messages(), bench.state()), (vec!["0: END_OF_MOVE".into(), "0: FULL_STOP".to_owned()], "Empty"));

    // A device with the quirk plays the move forward.
    let options = Options::default().with_quirks(Quirks::IGNORES_DIRECTION);
    let mut bench = Bench::loaded(options, live_move(live()));
    bench.receive(start_to(PlaybackDirection::REVERSE));
    assert_eq!(bench.events(), [home(Direction::Forward)]);

    let mut bench = loaded();
    let late = StartPlayback { direction: PlaybackDirection::FORWARD, start_time: Seconds(1.0), tail: &[] };
    bench.receive(HostMessage::from(late));
    bench.receive(start_to(PlaybackDirection(2)));
    assert_eq!((bench.messages(), bench.events().len()), (vec!["0: error 17 0".into(), "0: error 2 0".to_owned()], 0));
}

/// 7.4-26, 7.4-28: the position of each motor is reported, at once or when it rests (safety decisions 1 and 8).
#[test]
fn a_stop_ends_a_move_in_every_state() {
    for stop in [STOP, set_psa(3, 0.0, 0.0), bump(9, 0.0, 0.0)] {
        for mut bench in running() {
            let state = bench.state();
            bench.receive(stop);
            assert_eq!(bench.events(), [Event::StopAll], "{state}");
            assert_eq!(bench.state(), "Empty");
            let messages = bench.messages();
            assert_eq!(messages[0], "0: FULL_STOP", "{state}");
            assert_eq!(messages.last().map(String::as_str), Some("0: 3 rests at 0.0"));
            if state == "Delay" {
                assert_eq!(messages.len(), 4, "nothing moves");
                continue;
            }
            assert_eq!(messages.len(), 2, "{state}: two motors move");
            bench.arrive(1, 2.0);
            bench.arrive(2, 3.0);
            assert_eq!(bench.messages(), ["0: 1 rests at 2.0", "0: 2 rests at 3.0"]);
        }
    }
    // A ready move does not run, but it is forgotten too.
    let mut bench = loaded();
    bench.receive(setup(true));
    bench.clear();
    bench.receive(STOP);
    assert_eq!((bench.state(), bench.messages().len()), ("Empty", 4));
}

/// 7.4-27: a second stop is answered too.
#[test]
fn a_stop_without_a_move_is_answered_too() {
    let mut bench = loaded();
    bench.receive(set_psa(3, 7.0, 1.0));
    bench.clear();
    bench.receive(STOP);
    assert_eq!((bench.events(), bench.state()), (vec![Event::StopAll], "Empty"));
    assert_eq!(bench.messages(), ["0: FULL_STOP", "0: 1 rests at 8.0", "0: 2 rests at 8.0"]);
    bench.arrive(3, 0.0);
    assert_eq!(bench.messages(), ["0: 3 rests at 0.0"]);
    bench.receive(STOP);
    let messages = bench.messages();
    assert_eq!((&messages[..1], &messages[1..]), (&["0: FULL_STOP".to_owned()][..], &RESTS.map(str::to_owned)[..]));
}

/// 7.4-28: while no move runs, the stop concerns one motor only.
#[test]
fn a_stop_of_one_motor_leaves_a_move_that_is_ready() {
    let mut bench = loaded();
    bench.receive(setup(true));
    bench.clear();
    bench.receive(set_psa(1, 0.0, 0.0));
    assert_eq!((bench.messages(), bench.state()), (vec!["0: 1 rests at 8.0".into()], "Ready"));
}

/// 7.4-29: the move goes on, and only the client that asked gets the error (decision K-S3).
#[test]
fn while_a_move_runs_nothing_else_moves() {
    let picture = TakePicture { motor_address: MotorAddress::ALL, exposure: Seconds(1.0), tail: &[] };
    let others = [mark_begin(1), mark_end(1), reset_axis(0), reset_axis(1), HostMessage::from(picture)];
    let moves = [setup(false), setup(true), RAPID, set_psa(1, 1.0, 1.0), bump(3, 1.0, 1.0), start()];
    for message in others.into_iter().chain(moves).chain([set(live_move(live()))]) {
        for mut bench in running() {
            let state = bench.state();
            if state == "HomingSetup" && matches!(message, HostMessage::StartPlayback(_)) {
                continue;
            }
            bench.open(ONE, kos_proto::Transport::Usb);
            let before = bench.machine.clone();
            bench.from(ONE, message);
            let mut told = bench.messages();
            // A motor that rests reports its position after any attempt to move it (decision K-M10).
            let rests = matches!(
                message,
                HostMessage::SetPositionSpeedAcceleration(_) | HostMessage::BumpPositionSpeedAcceleration(_)
            );
            told.retain(|told| !(rests && told.contains(" rests at ")));
            assert_eq!((told, bench.events().len()), (vec!["1: error 2 0".into()], 0), "{state}: {message}");
            assert_eq!(bench.machine, before, "{state}: {message}");
        }
    }
}

/// 7.4-29: after an attempt to move a motor that rests its position is reported, to the client that asked (decision K-M10).
#[test]
fn a_refused_motion_is_followed_by_the_position_of_the_motor() {
    let mut bench = loaded();
    bench.receive(start());
    bench.home();
    bench.clear();
    bench.open(ONE, kos_proto::Transport::Usb);
    bench.from(ONE, set_psa(3, 5.0, 10.0));
    assert_eq!(bench.messages(), ["1: error 2 0", "1: 3 rests at 0.0"]);
    bench.from(ONE, set_psa(1, 5.0, 10.0));
    assert_eq!(bench.messages(), ["1: error 2 0"], "motor 1 moves in the move");
    bench.from(ONE, set_psa(9, 5.0, 10.0));
    assert_eq!(bench.messages(), ["1: error 2 0"], "there is no motor 9");
}

/// The status of a move has the positions of its motors, and of no others.
#[test]
fn the_status_of_a_move_is_about_its_motors() {
    let positions = |bench: &mut Bench, message: HostMessage<'static>| {
        let (machine, output) = laws::machine::step(
            bench.machine.clone(),
            Millis(bench.now),
            Input::Received { session: ZERO, message, bytes: &[], password: Password(b"") },
        );
        bench.machine = machine;
        let of = |contents: &Contents<'_>| match contents {
            Contents::PlaybackStatus { positions, .. } => {
                Some(positions.iter().map(|place| place.motor_address().0).collect::<Vec<_>>())
            }
            _ => None,
        };
        output.transmits().find_map(|transmit| of(&transmit.contents)).expect("a status")
    };
    let mut bench = loaded();
    assert_eq!(positions(&mut bench, setup(true)), [1, 2]);
    assert_eq!(positions(&mut bench, STOP), [1, 2]);
    assert_eq!(positions(&mut bench, STOP), [0_u8; 0], "without a move there are none");
}

/// 7.4-30: a motor of the move that goes off line ends the move too (decision K-S9).
#[test]
fn a_fault_ends_a_move() {
    for code in [10, 11, 12, 13, 16] {
        for mut bench in running() {
            bench.rig(Report::Fault(MotorAddress(1), ErrorCode(code)));
            assert_eq!(bench.messages(), [format!("0: error {code} 1"), "0: FULL_STOP".into()]);
            assert_eq!((bench.events(), bench.state()), (vec![Event::StopAll], "Empty"));
            let calibrated = bench.machine.calibration(MotorAddress(1)).unwrap().name() == "Calibrated";
            assert_eq!(calibrated, !ErrorCode(code).resets_axis());
        }
    }
    for mut bench in running() {
        bench.rig(Report::Online(MotorAddress(3), false));
        assert_eq!(bench.messages(), ["0: 3 online false"]);
        bench.rig(Report::Online(MotorAddress(2), false));
        assert_eq!(bench.messages(), ["0: error 4 2", "0: FULL_STOP", "0: 2 online false"]);
    }
}

/// 7.4-31: a move with camera roll is accepted, and no message is sent about it.
#[test]
fn camera_roll_is_not_told() {
    let mut bench =
        played(Playback { camera_roll_enabled: true.into(), camera_roll_pre_delay: Seconds(3.0), ..live() });
    assert_eq!(bench.state(), "Forward");
    bench.pass(10_000);
    assert_eq!(bench.messages(), ["0: END_OF_MOVE", "0: FULL_STOP"]);
}

/// A late wake only delays the move: each pass has its full duration from its own begin.
#[test]
fn a_late_wake_makes_the_move_late() {
    let mut bench = played(Playback { loop_after_reverse: LoopCount(1), ..live() });
    bench.now += 25_000;
    bench.step(Input::Wake);
    assert_eq!(bench.events(), [play(Direction::Reverse, 10_000)]);
    bench.pass(9_999);
    assert_eq!(bench.state(), "Reverse");
}
