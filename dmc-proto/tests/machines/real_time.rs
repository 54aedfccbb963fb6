//! Device: uploads, runs and shots. DMC D3.

use dmc_proto::device::{Contents, Event, Input, Options, Quirks, Report, State, StopKind};
use dmc_proto::message::{
    AckCode, BlurPercent, Direction, FramesPerSecond, HostMessage, JogSpeed, Milliseconds, Motor, MotorConfigure,
    MotorFlags, MotorJog, MotorPair, MotorStatusRequest, Motors, RtGo, RtShootFrame, RtStopLoop, RtUploadMoveEnd,
    RtUploadMoveTriggers, RunFlags, Scaled, Steps, Triggers,
};

use motion_core::wire::Messages as _;

use super::bench::{
    Bench, SWING_PAN, Said, UNASKED, axis, begin, frame, hi, jog, jog_all, move_to, position_frame, run, shot,
    stop_all, virtuals,
};

fn end() -> HostMessage<'static> {
    RtUploadMoveEnd::default().into()
}

fn go() -> HostMessage<'static> {
    RtGo::default().into()
}

fn stop_loop() -> HostMessage<'static> {
    RtStopLoop::default().into()
}

fn status() -> HostMessage<'static> {
    MotorStatusRequest::default().into()
}

const ONCE: RunFlags = RunFlags(0);

/// Device in a run of these frames.
fn running(from: i32, to: i32, flags: RunFlags) -> Bench {
    let mut bench = Bench::on_frame();
    bench.takes_as(run(from, to, flags), Event::Prepare);
    bench.rests();
    bench.takes(go(), Event::Go);
    bench
}

/// D3-1
#[test]
fn a_begin_of_an_upload_forgets_the_move() {
    let mut bench = Bench::on_frame();
    for (first, last) in [(5, 4), (1, 1001), (i32::MIN, i32::MAX)] {
        bench.refuses(begin(first, last), AckCode::ERR_RANGE);
        assert!(bench.machine.is_loaded(), "a request that is refused changes nothing");
    }
    assert_eq!(bench.store(begin(3, 1002)), bench.ack(&begin(3, 1002), AckCode::OK));
    assert_eq!((bench.machine.is_loaded(), bench.machine.on_frame()), (false, None));
    bench.refuses(position_frame(3), AckCode::ERR_GENERAL);
}

/// D3-2, D-67
#[test]
fn the_buffer_decides_about_a_section() {
    let mut bench = Bench::new();
    bench.store(begin(1, 10));
    let triggers = RtUploadMoveTriggers { mask: Triggers(1), pairs: &[], tail: &[] };
    for message in [axis(3), triggers.into()] {
        assert_eq!(bench.store(message), bench.ack(&message, AckCode::OK));
        let (said, events) = bench.asked(message);
        let [Event::Store { store, .. }] = events[..] else { panic!("{events:?}") };
        assert_eq!(said, [], "the answer comes after the buffer has stored the section");
        let (said, _) = bench.step(Input::Rig(Report::Stored(store, AckCode::ERR_RANGE)));
        assert_eq!(said, [bench.ack(&message, AckCode::ERR_RANGE)]);
    }
    bench.refuses(axis(9), AckCode::ERR_RANGE);
    bench.store(end());
    bench.asked(position_frame(1));
    assert_eq!(bench.machine.moving(), Motors(0b100), "only motors with stored sections are part of the move");
}

/// D3-3
#[test]
fn a_section_outside_an_upload_is_refused() {
    Bench::new().refuses(axis(1), AckCode::ERR_GENERAL);
    Bench::loaded().refuses(axis(1), AckCode::ERR_GENERAL);
}

/// D3-4
#[test]
fn the_end_makes_a_move_that_can_be_run() {
    let mut bench = Bench::new();
    bench.store(begin(1, 10));
    assert!(!bench.machine.is_loaded());
    assert_eq!(bench.store(end()), bench.ack(&end(), AckCode::OK));
    assert!(bench.machine.is_loaded());
}

/// D3-5
#[test]
fn an_end_outside_an_upload_changes_nothing() {
    for mut bench in [Bench::new(), Bench::loaded()] {
        let before = bench.machine.clone();
        bench.refuses(end(), AckCode::OK);
        assert_eq!(bench.machine, before);
    }
}

/// A later answer of the buffer does not change this.
#[test]
fn a_begin_that_is_not_stored_leaves_no_move() {
    let mut bench = Bench::loaded();
    let (_, events) = bench.asked(begin(1, 5));
    let [Event::Store { store, .. }] = events[..] else { panic!("{events:?}") };
    bench.refuses(position_frame(1), AckCode::ERR_GENERAL);
    bench.step(Input::Rig(Report::Stored(store, AckCode::ERR_RANGE)));
    bench.refuses(position_frame(1), AckCode::ERR_GENERAL);
}

/// D3-6
#[test]
fn a_way_to_a_frame_replaces_other_motions() {
    Bench::new().refuses(position_frame(1), AckCode::ERR_GENERAL);
    for number in [0, 11] {
        Bench::loaded().refuses(position_frame(number), AckCode::ERR_RANGE);
    }
    for mut bench in Bench::everywhere() {
        match bench.state() {
            State::Running | State::Stopping | State::Locked => continue,
            _ => {}
        }
        let has_job = matches!(bench.state(), State::PreRoll | State::Ready | State::PostRoll);
        let (said, events) = bench.asked(position_frame(7));
        assert_eq!(said, [bench.ack(&position_frame(7), AckCode::OK)]);
        assert_eq!(events.last(), Some(&Event::ToFrame(frame(7))));
        assert_eq!(events.contains(&Event::TriggersOff), has_job);
        assert_eq!((bench.state(), bench.machine.on_frame()), (State::ToFrame, None));
        bench.refuses(go(), AckCode::ERR_NOT_IN_POSITION);
        bench.rests();
        assert_eq!((bench.state(), bench.machine.on_frame()), (State::Idle, Some(frame(7))));
    }
}

/// D3-7
#[test]
fn a_way_to_a_frame_is_refused_during_a_run() {
    running(1, 10, ONCE).refuses(position_frame(1), AckCode::ERR_MOVING);
}

/// D3-8
#[test]
fn at_the_frame_positions_are_reported() {
    let mut bench = Bench::loaded();
    bench.asked(position_frame(4));
    assert_eq!(bench.machine.moving(), Motors(0b11), "motors outside the move do not move");
    let (said, _) = bench.pass(100);
    assert_eq!(said, [Said::Positions(UNASKED, 0)]);
    assert_eq!(bench.rests(), (vec![Said::Positions(UNASKED, 4)], vec![]));
    assert_eq!((bench.state(), bench.machine.on_frame()), (State::Idle, Some(frame(4))));
}

/// D3-9
#[test]
fn all_motors_jog_from_a_frame() {
    Bench::loaded().refuses(jog_all(5), AckCode::ERR_NOT_IN_POSITION);
    let mut bench = Bench::on_frame();
    bench.refuses(jog_all(11), AckCode::ERR_RANGE);
    bench.takes(jog_all(5), Event::JogAll(FramesPerSecond(Scaled(24_000)), frame(5)));
    assert_eq!((bench.state(), bench.machine.on_frame()), (State::JogAll, None));
}

/// D3-10
#[test]
fn a_jog_of_all_can_get_another_destination() {
    let mut bench = Bench::on_frame();
    bench.asked(jog_all(5));
    bench.step(Input::Rig(Report::AtFrame(frame(3))));
    bench.refuses(jog_all(11), AckCode::ERR_RANGE);
    bench.takes(jog_all(2), Event::JogAll(FramesPerSecond(Scaled(24_000)), frame(2)));
    bench.rests();
    assert_eq!(bench.machine.on_frame(), Some(frame(2)));
}

/// D3-11
#[test]
fn each_frame_of_a_jog_of_all_is_reported() {
    let mut bench = Bench::on_frame();
    bench.asked(jog_all(5));
    for number in 2..=5 {
        bench.pass(42);
        assert_eq!(
            bench.step(Input::Rig(Report::AtFrame(frame(number)))),
            (vec![Said::Positions(UNASKED, number)], vec![])
        );
    }
}

/// D3-12
#[test]
fn a_jog_of_all_ends_on_its_frame() {
    let mut bench = Bench::on_frame();
    bench.asked(jog_all(5));
    assert_eq!(bench.rests(), (vec![Said::Positions(UNASKED, 5)], vec![]));
    assert_eq!((bench.state(), bench.machine.on_frame()), (State::Idle, Some(frame(5))));
}

/// D3-13
#[test]
fn a_jog_of_all_is_refused_during_other_motions() {
    for mut bench in Bench::everywhere() {
        match bench.state() {
            State::Idle | State::JogAll => {}
            State::Locked => bench.refuses(jog_all(5), AckCode::ERR_HARD_UP),
            _ => bench.refuses(jog_all(5), AckCode::ERR_MOVING),
        }
    }
}

/// D3-14, S-7
#[test]
fn uploads_runs_shots_and_configurations_of_rigs_begin_only_at_rest() {
    for mut bench in Bench::everywhere() {
        let code = match bench.state() {
            State::Idle => continue,
            State::Locked => AckCode::ERR_HARD_UP,
            _ => AckCode::ERR_MOVING,
        };
        for message in [begin(1, 10), run(1, 10, ONCE), shot(1), virtuals(&SWING_PAN)] {
            bench.refuses(message, code);
            assert!(bench.machine.is_loaded());
        }
    }
}

/// D3-15
#[test]
fn a_run_begins_on_a_frame_of_the_move_if_the_rig_allows_it() {
    Bench::loaded().refuses(run(1, 10, ONCE), AckCode::ERR_NOT_IN_POSITION);
    let mut bench = Bench::on_frame();
    for (from, to) in [(0, 10), (1, 11)] {
        bench.refuses(run(from, to, ONCE), AckCode::ERR_RANGE);
    }
    for code in [AckCode::ERR_PREROLL, AckCode::ERR_POSTROLL] {
        let (said, events) = bench.asked_with(run(1, 10, ONCE), code);
        assert_eq!((said, events), (vec![bench.ack(&run(1, 10, ONCE), code)], vec![]));
    }
    bench.takes_as(run(1, 10, ONCE), Event::Prepare);
    assert_eq!((bench.state(), bench.machine.on_frame()), (State::PreRoll, None));
    let (said, _) = bench.asked(status());
    assert_eq!(said, [Said::Other(bench.id(), Contents::Status(Motors(0b11)))]);
}

/// D3-16, D-58
#[test]
fn a_shot_needs_a_frame_of_the_move_or_motors_of_its_own() {
    let mut bench = Bench::loaded();
    for number in [0, 11] {
        bench.refuses(shot(number), AckCode::ERR_RANGE);
    }
    bench.takes_as(shot(10), Event::Prepare);
    assert_eq!(bench.state(), State::PreRoll);
    Bench::new().refuses(shot(1), AckCode::ERR_GENERAL);
    let motors = [MotorPair::new(Motor(5), Steps(0), Steps(9))];
    let own = HostMessage::from(RtShootFrame {
        frame: frame(50),
        direction: Direction::FORWARD,
        exposure_ms: Milliseconds(500),
        blur_x10: BlurPercent(Scaled(1000)),
        motors: &motors,
        tail: &[],
    });
    let mut bench = Bench::new();
    bench.takes_as(own, Event::Prepare);
    assert_eq!(bench.machine.moving(), Motors(0b1_0000));
    let (_, events) = bench.asked(super::bench::stop(5));
    assert_eq!(events[0], Event::Stop(StopKind::All { silent: false }), "its own motors are part of the shot");
    Bench::loaded().refuses(own, AckCode::ERR_RANGE);
}

/// D3-17
#[test]
fn after_the_pre_roll_the_device_is_ready_and_reports_nothing() {
    let mut bench = Bench::on_frame();
    bench.asked(run(1, 10, ONCE));
    assert_eq!(bench.rests(), (vec![], vec![]));
    assert_eq!((bench.state(), bench.wake), (State::Ready, None));
    let (said, _) = bench.asked(status());
    assert_eq!(said, [Said::Other(bench.id(), Contents::Status(Motors::NONE))]);
}

/// D3-18
#[test]
fn a_device_that_is_not_ready_starts_nothing() {
    for mut bench in Bench::everywhere() {
        match bench.state() {
            State::Ready => {}
            State::Locked => bench.refuses(go(), AckCode::ERR_HARD_UP),
            _ => bench.refuses(go(), AckCode::ERR_NOT_IN_POSITION),
        }
    }
}

/// D3-19
#[test]
fn the_host_starts_a_run() {
    let mut bench = Bench::on_frame();
    bench.asked(run(1, 10, ONCE));
    bench.rests();
    bench.takes(go(), Event::Go);
    assert_eq!(bench.state(), State::Running);
    assert_eq!(bench.machine.moving(), Motors(0b11));
    bench.refuses(go(), AckCode::ERR_NOT_IN_POSITION);
}

/// D3-20
#[test]
fn the_operator_starts_a_run() {
    let mut bench = Bench::on_frame();
    bench.asked(run(1, 10, ONCE));
    bench.rests();
    assert_eq!(bench.step(Input::Rig(Report::OperatorGo)), (vec![Said::Other(UNASKED, Contents::Go)], vec![Event::Go]));
    assert_eq!(bench.state(), State::Running);
    assert_eq!(bench.step(Input::Rig(Report::OperatorGo)), (vec![], vec![Event::UnexpectedReport]));
}

/// D3-21
#[test]
fn each_frame_of_a_run_is_reported() {
    let mut bench = running(1, 10, ONCE);
    for number in 1..=10 {
        bench.pass(50);
        assert_eq!(
            bench.step(Input::Rig(Report::AtFrame(frame(number)))),
            (vec![Said::Positions(UNASKED, number)], vec![])
        );
    }
    let (said, _) = bench.pass(100);
    assert_eq!(said, [Said::Positions(UNASKED, 10)], "without new frames, positions are reported regularly");
}

/// D3-22, S-6
#[test]
fn the_end_of_a_run_is_reported_before_its_post_roll() {
    let mut bench = running(1, 10, ONCE);
    let ended = vec![Said::Positions(UNASKED, 10), Said::Other(UNASKED, Contents::End)];
    assert_eq!(bench.step(Input::Rig(Report::PassEnd)), (ended, vec![Event::TriggersOff, Event::PostRoll]));
    assert_eq!(bench.state(), State::PostRoll);

    let shoot = |options| {
        let mut bench = Bench::of(options);
        bench.load();
        bench.asked(shot(3));
        bench.rests();
        bench.asked(go());
        bench.step(Input::Rig(Report::PassEnd)).0
    };
    let options = Options::of(hi());
    assert_eq!(shoot(options), [Said::Positions(UNASKED, 3), Said::Other(UNASKED, Contents::End)]);
    assert_eq!(shoot(options.with_quirks(Quirks::NO_END_OF_SHOT)), [Said::Positions(UNASKED, 3)]);
}

/// D3-23
#[test]
fn a_loop_begins_again_and_a_ping_pong_turns_round() {
    let mut bench = running(1, 10, RunFlags::LOOP);
    for _ in 0..3 {
        assert_eq!(bench.step(Input::Rig(Report::PassEnd)), (vec![], vec![Event::NextPass(frame(1), frame(10))]));
        assert_eq!(bench.state(), State::Running);
    }
    for flags in [RunFlags::PING_PONG, RunFlags::PING_PONG | RunFlags::LOOP] {
        let mut bench = running(1, 10, flags);
        assert_eq!(bench.step(Input::Rig(Report::PassEnd)), (vec![], vec![Event::NextPass(frame(10), frame(1))]));
        assert_eq!(bench.step(Input::Rig(Report::PassEnd)), (vec![], vec![Event::NextPass(frame(1), frame(10))]));
    }
    let mut bench = Bench::of(Options::of(hi()).with_quirks(Quirks::END_PER_PASS));
    bench.load();
    bench.asked(position_frame(1));
    bench.rests();
    bench.asked(run(1, 10, RunFlags::LOOP));
    bench.rests();
    bench.asked(go());
    assert_eq!(bench.step(Input::Rig(Report::PassEnd)).0, [Said::Other(UNASKED, Contents::End)]);
    assert_eq!(bench.state(), State::Running);
}

/// D3-24
#[test]
fn a_loop_ends_at_its_next_end_point() {
    for (flags, end) in [(RunFlags::LOOP, 10), (RunFlags::PING_PONG, 1)] {
        let mut bench = running(1, 10, flags);
        bench.step(Input::Rig(Report::PassEnd));
        bench.takes(stop_loop(), Event::LastPass);
        assert_eq!(bench.state(), State::Running);
        let (said, _) = bench.step(Input::Rig(Report::PassEnd));
        assert_eq!(said, [Said::Positions(UNASKED, end), Said::Other(UNASKED, Contents::End)]);
        bench.rests();
        assert_eq!(bench.machine.on_frame(), Some(frame(end)));
    }
}

/// D3-25, D-66
#[test]
fn a_request_to_end_a_loop_is_acknowledged_without_a_loop() {
    let mut bench = running(1, 10, ONCE);
    let before = bench.machine.clone();
    bench.refuses(stop_loop(), AckCode::OK);
    assert_eq!(bench.machine, before);
    let mut bench = Bench::on_frame();
    bench.refuses(stop_loop(), AckCode::OK);
    bench.asked(run(1, 10, RunFlags::LOOP));
    bench.takes(stop_loop(), Event::LastPass);
    bench.refuses(stop_loop(), AckCode::OK);
}

/// D3-26
#[test]
fn after_the_post_roll_the_device_is_on_the_last_frame() {
    let mut bench = running(1, 10, ONCE);
    bench.step(Input::Rig(Report::PassEnd));
    assert_eq!(bench.rests(), (vec![Said::Positions(UNASKED, 10)], vec![]));
    assert_eq!((bench.state(), bench.machine.on_frame()), (State::Idle, Some(frame(10))));
    bench.takes_as(run(10, 1, ONCE), Event::Prepare);
}

/// D3-27, S-6
#[test]
fn a_run_that_is_stopped_reports_no_end_and_is_on_no_frame() {
    let states = [State::PreRoll, State::Ready, State::Running, State::PostRoll];
    for mut bench in Bench::everywhere().into_iter().filter(|bench| states.contains(&bench.state())) {
        let (said, events) = bench.asked(stop_all());
        assert_eq!(said, [bench.ack(&stop_all(), AckCode::OK)], "no end is reported");
        assert_eq!(events, [Event::Stop(StopKind::All { silent: false }), Event::TriggersOff]);
        bench.rests();
        assert_eq!((bench.state(), bench.machine.on_frame()), (State::Idle, None));
        assert!(bench.machine.is_loaded(), "the move is still loaded");
        bench.refuses(run(1, 10, ONCE), AckCode::ERR_NOT_IN_POSITION);
        bench.asked(jog(1));
    }
}

/// D-80
#[test]
fn a_device_may_rest_one_frame_beyond_a_run() {
    for (from, to, rests) in [(1, 5, 6), (5, 1, 2), (1, 10, 10)] {
        let mut bench = Bench::quirky(Quirks::RESTS_BEYOND);
        bench.asked(run(from, to, RunFlags(0)));
        bench.rests();
        bench.asked(go());
        bench.step(Input::Rig(Report::PassEnd));
        bench.rests();
        assert_eq!(bench.machine.on_frame(), Some(frame(rests)));
    }
}

/// D-81
#[test]
fn a_device_may_go_to_the_nearest_frame() {
    for (asked, goes) in [(5, 5), (0, 1), (11, 10), (i32::MAX, 10)] {
        let mut bench = Bench::quirky(Quirks::CLAMPS_FRAMES);
        bench.takes(position_frame(asked), Event::ToFrame(frame(goes)));
        bench.rests();
        assert_eq!(bench.machine.on_frame(), Some(frame(goes)));
    }
    let mut bench = Bench::of(Options::of(hi()).with_quirks(Quirks::CLAMPS_FRAMES));
    bench.refuses(position_frame(1), AckCode::ERR_GENERAL);
}

/// D-82
#[test]
fn a_device_may_stay_after_a_shot() {
    let mut bench = Bench::quirky(Quirks::STAYS_AFTER_SHOT);
    bench.asked(shot(3));
    bench.rests();
    bench.asked(go());
    bench.step(Input::Rig(Report::PassEnd));
    bench.rests();
    assert_eq!((bench.state(), bench.machine.on_frame()), (State::Idle, None));
}

/// D-92
#[test]
fn a_device_may_let_one_motor_cut_in() {
    for ready in [false, true] {
        let mut bench = Bench::quirky(Quirks::CUTS_IN);
        if ready {
            bench.asked(run(1, 5, RunFlags(0)));
            bench.rests();
            assert_eq!(bench.state(), State::Ready);
        } else {
            bench.asked(position_frame(3));
        }
        bench.takes(jog(3), Event::Jog(Motor(3), JogSpeed::FULL, Steps(i32::MAX)));
        assert_eq!(bench.state(), State::Moving);
        bench.refuses(go(), AckCode::ERR_NOT_IN_POSITION);
        bench.rests();
        assert_eq!((bench.state(), bench.machine.on_frame()), (State::Idle, None));
    }
    let mut bench = Bench::quirky(Quirks::CUTS_IN);
    bench.asked(run(1, 5, RunFlags(0)));
    bench.refuses(jog(3), AckCode::ERR_MOVING);
}

/// D-93
#[test]
fn a_device_may_check_few_numbers() {
    let (speed, destination) = (JogSpeed(Scaled(20_000)), Steps(9));
    let fast = |motor| HostMessage::from(MotorJog { motor: Motor(motor), speed, destination, tail: &[] });
    let mut bench = Bench::quirky(Quirks::FEW_CHECKS);
    bench.takes(fast(1), Event::Jog(Motor(1), speed, destination));
    bench.rests();
    bench.refuses(fast(0), AckCode::ERR_RANGE);
    bench.refuses(fast(33), AckCode::ERR_RANGE);
    bench.refuses(HostMessage::other(0x0300, &[]), AckCode::ERR_UNSUPPORTED);
    bench.asked(jog(3));
    bench.refuses(shot(11), AckCode::ERR_RANGE);
    bench.refuses(shot(1), AckCode::ERR_MOVING);
    let mut bench = Bench::of(Options::of(hi()).with_quirks(Quirks::FEW_CHECKS));
    bench.refuses(shot(1), AckCode::ERR_RANGE);
}

/// D-98
#[test]
fn a_device_may_end_a_run_because_a_motor_moves() {
    for quirks in [Quirks(0), Quirks::MOVE_ENDS_RUN] {
        let mut bench = Bench::quirky(quirks);
        bench.asked(MotorConfigure { motor: Motor(3), flags: MotorFlags::LIVE, tail: &[] }.into());
        bench.asked(run(1, 5, RunFlags(0)));
        bench.rests();
        bench.asked(move_to(3, 1));
        assert_eq!(bench.state(), State::Ready);
        bench.asked(go());
        bench.takes(jog(3), Event::Jog(Motor(3), JogSpeed::FULL, Steps(i32::MAX)));
        assert_eq!(bench.state(), State::Running);
        let (said, events) = bench.asked(move_to(3, 2));
        assert_eq!(said.len(), 1, "no end is told: {said:?}");
        let moves = Event::Move(Motor(3), Steps(2));
        if quirks == Quirks(0) {
            assert_eq!((bench.state(), events), (State::Running, vec![moves]));
        } else {
            assert_eq!((bench.state(), events), (State::Moving, vec![Event::TriggersOff, moves]));
            bench.rests();
            assert_eq!((bench.state(), bench.machine.on_frame()), (State::Idle, None));
        }
    }
}

/// D-94
#[test]
fn a_device_may_be_busy_after_a_run() {
    let mut bench = Bench::quirky(Quirks::BUSY_AFTER_RUN);
    bench.asked(run(1, 5, RunFlags(0)));
    bench.rests();
    bench.asked(go());
    bench.step(Input::Rig(Report::PassEnd));
    assert_eq!(bench.state(), State::PostRoll);
    bench.refuses(position_frame(1), AckCode::ERR_MOVING);
    bench.rests();
    bench.takes(position_frame(1), Event::ToFrame(frame(1)));
}
