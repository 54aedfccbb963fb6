//! Device: connection, single motors, stops, virtual motors and quirks. DMC D2 and D4.

use dmc_proto::device::{Contents, Event, Input, Options, Quirks, Report, State, StopKind};
use dmc_proto::message::{
    AckCode, Capabilities, Dmx, DmxChannel, GioInRequest, GioOut, Hi, HiRequest, HostMessage, JogSpeed, LineAxis,
    LineSpeed, Motor, MotorConfigure, MotorFlags, MotorGetPosition, MotorResetPosition, MotorSetLimits, MotorSetSpeed,
    MotorStatusRequest, MotorStopAll, Motors, RtGo, RunFlags, Scaled, Speed, Steps, StopFlags, StopReason, Triggers,
    VirtAimPoint, VirtGetPosition, VirtJogOnLine, VirtMove, VirtStop, VirtualMotor,
};
use dmc_proto::{DeviceMessage, MessageId, MessageType, Millis};
use motion_core::wire::Messages;

use super::bench::{
    Bench, SWING_PAN, Said, UNASKED, begin, frame, hi, jog, jog_all, move_to, position_frame, run, shot, stop,
    stop_all, virtual_position, virtuals,
};

fn get_position() -> HostMessage<'static> {
    MotorGetPosition::default().into()
}

fn status() -> HostMessage<'static> {
    MotorStatusRequest::default().into()
}

fn reset(motor: u8) -> HostMessage<'static> {
    HostMessage::from(MotorResetPosition { motor: Motor(motor), position: Steps(7), tail: &[] })
}

fn configure(motor: u8, flags: MotorFlags) -> HostMessage<'static> {
    HostMessage::from(MotorConfigure { motor: Motor(motor), flags, tail: &[] })
}

/// D2-1
#[test]
fn a_device_greets_unasked_at_boot() {
    let mut bench = Bench::new();
    let greeting = Said::Other(UNASKED, Contents::Greeting(hi()));
    assert_eq!(bench.step(Input::LinkUp), (vec![greeting], vec![]));
    assert_eq!((bench.state(), bench.wake), (State::Idle, None));
}

/// D2-2
#[test]
fn a_device_answers_a_greeting_in_every_state() {
    for mut bench in Bench::everywhere() {
        let (state, (said, _)) = (bench.state(), bench.asked(HiRequest::default().into()));
        assert_eq!(said, [Said::Other(bench.id(), Contents::Greeting(hi()))]);
        assert_eq!(bench.state(), state);
    }
}

/// D2-3
#[test]
fn a_wrong_checksum_is_acknowledged_with_the_id_and_type_of_the_header() {
    for mut bench in Bench::everywhere() {
        let (said, events) = bench.step(Input::Corrupt(MessageId(77), MessageType(0x0036)));
        assert_eq!((said, events), (vec![Said::Ack(77, 0x0036, AckCode::ERR_CHECKSUM)], vec![]));
    }
}

/// D2-4
#[test]
fn an_acknowledgement_is_never_answered() {
    for mut bench in Bench::everywhere() {
        let (id, kind) = (MessageId(77), MessageType(0x8036));
        let other = <HostMessage<'_> as Messages>::other(0x8036, &[0x10, 0]);
        let arrived = Input::Received { id, message: other, rig: AckCode::OK };
        for input in [Input::Corrupt(id, kind), Input::Malformed(id, kind), arrived] {
            assert_eq!(bench.step(input), (vec![], vec![Event::Acknowledgement(id, kind)]));
        }
    }
}

/// D2-5
#[test]
fn a_request_that_the_device_cannot_do_is_unsupported() {
    for mut bench in Bench::everywhere() {
        bench.refuses(HostMessage::other(0x0300, &[1]), AckCode::ERR_UNSUPPORTED);
        bench.refuses(HostMessage::other(0, &[]), AckCode::ERR_UNSUPPORTED);
    }
    let mut bench = Bench::of(Options::of(Hi { capabilities: Capabilities(0), gio_in_count: 0, ..hi() }));
    for message in [begin(1, 2), position_frame(1), shot(1), GioInRequest::default().into(), virtuals(&SWING_PAN)] {
        bench.refuses(message, AckCode::ERR_UNSUPPORTED);
    }
    assert_eq!(DeviceMessage::ALL.len(), 11, "a hard stop is not a request");
    bench.refuses(HostMessage::other(0x003A, &[0]), AckCode::ERR_UNSUPPORTED);
}

/// D2-6
#[test]
fn data_that_end_too_early_are_a_general_error() {
    for mut bench in Bench::everywhere() {
        let state = bench.state();
        let (said, events) = bench.step(Input::Malformed(MessageId(5), MessageType(0x0031)));
        assert_eq!((said, events), (vec![Said::Ack(5, 0x0031, AckCode::ERR_GENERAL)], vec![]));
        assert_eq!(bench.state(), state);
    }
}

/// D2-7
#[test]
fn a_motor_that_does_not_exist_is_out_of_range() {
    for mut bench in Bench::everywhere() {
        for motor in [0, 9, 33, 255] {
            let messages = [move_to(motor, 1), jog(motor), stop(motor), reset(motor), configure(motor, MotorFlags(1))];
            for message in messages {
                bench.refuses(message, AckCode::ERR_RANGE);
            }
        }
    }
}

/// D2-8, D-52
#[test]
fn after_a_hard_stop_only_stops_and_questions_are_accepted() {
    let limit = |upper| Input::Rig(Report::Limit { motor: Motor(2), upper });
    for (input, code) in [
        (limit(true), AckCode::ERR_HARD_UP),
        (limit(false), AckCode::ERR_HARD_LOW),
        (Input::Rig(Report::EmergencyStop(true)), AckCode::ERR_GENERAL),
        (Input::Rig(Report::Fault(None)), AckCode::ERR_GENERAL),
    ] {
        let mut bench = Bench::on_frame();
        bench.step(input);
        for message in [move_to(1, 5), jog(1), reset(1), begin(1, 5), position_frame(1), RtGo::default().into()] {
            bench.refuses(message, code);
        }
        let (said, _) = bench.asked(get_position());
        assert_eq!(said, [Said::Positions(bench.id(), 0)]);
        let (said, _) = bench.asked(status());
        assert_eq!(said, [Said::Other(bench.id(), Contents::Status(Motors::NONE))]);
        bench.takes(stop(1), Event::Stop(StopKind::Motor(Motor(1))));
        bench.takes(stop_all(), Event::Stop(StopKind::All { silent: false }));
        assert_eq!(bench.state(), State::Locked);
    }
}

/// D2-9
#[test]
fn positions_are_reported_while_a_motor_moves() {
    let mut bench = Bench::on_frame();
    let (said, events) = bench.asked(move_to(3, -40));
    assert_eq!(said, [Said::Other(bench.id(), Contents::Moving)]);
    assert_eq!(events, [Event::Move(Motor(3), Steps(-40))]);
    assert_eq!((bench.state(), bench.machine.on_frame()), (State::Moving, None));
    bench.takes(jog(4), Event::Jog(Motor(4), JogSpeed::FULL, Steps(i32::MAX)));
    let (said, _) = bench.asked(status());
    assert_eq!(
        said,
        [Said::Other(bench.id(), Contents::Status(Motors(0b1100)))],
        "the status tells them as soon as the rig reports them"
    );
    let (said, _) = bench.pass(1000);
    assert_eq!(said, vec![Said::Positions(UNASKED, 0); 10], "every 100 ms");
    bench.step(Input::Rig(Report::Moving(Motors(0b1000))));
    let (said, _) = bench.asked(status());
    assert_eq!(said, [Said::Other(bench.id(), Contents::Status(Motors(0b1000)))]);
}

/// D2-10
#[test]
fn in_a_coordinated_move_only_live_motors_can_be_moved() {
    let states = [State::JogAll, State::ToFrame, State::PreRoll, State::Ready, State::Running, State::PostRoll];
    for mut bench in Bench::everywhere().into_iter().filter(|bench| states.contains(&bench.state())) {
        let state = bench.state();
        bench.refuses(move_to(3, 1), AckCode::ERR_MOVING);
        bench.refuses(jog(3), AckCode::ERR_MOVING);
        bench.takes_as(configure(3, MotorFlags::LIVE), Event::Apply);
        bench.takes(jog(3), Event::Jog(Motor(3), JogSpeed::FULL, Steps(i32::MAX)));
        bench.takes(stop(3), Event::Stop(StopKind::Motor(Motor(3))));
        assert_eq!(bench.state(), state, "the coordinated move goes on");
        bench.takes_as(configure(3, MotorFlags::ENABLED), Event::Apply);
        bench.refuses(jog(3), AckCode::ERR_MOVING);
    }
    let mut bench = Bench::on_frame();
    bench.asked(configure(3, MotorFlags::LIVE));
    bench.asked(shot(1));
    bench.rests();
    bench.asked(jog(3));
    assert_eq!((bench.state(), bench.machine.moving()), (State::Ready, Motors(0b100)));
    assert_eq!(bench.rests(), (vec![], vec![]));
    assert_eq!((bench.state(), bench.machine.moving()), (State::Ready, Motors::NONE));
    let mut bench = Bench::on_frame();
    bench.asked(configure(3, MotorFlags::LIVE));
    bench.asked(jog(3));
    bench.rests();
    assert_eq!(bench.machine.on_frame(), Some(frame(1)), "a live motor is not part of the frame");
}

/// D2-11
#[test]
fn at_rest_the_last_positions_are_reported() {
    let mut bench = Bench::new();
    bench.asked(jog(3));
    assert_eq!(bench.rests(), (vec![Said::Positions(UNASKED, 0)], vec![]));
    assert_eq!((bench.state(), bench.wake), (State::Idle, None));
    assert_eq!(bench.machine.moving(), Motors::NONE);
}

/// D2-12, S-8
#[test]
fn a_limit_that_was_set_ends_a_jog_and_refuses_a_move() {
    let mut bench = Bench::loaded();
    bench.asked(jog(3));
    assert_eq!(bench.rests(), (vec![Said::Positions(UNASKED, 0)], vec![]), "no hard stop");
    assert_eq!(bench.state(), State::Idle, "the device is not locked");
    for code in [AckCode::ERR_SOFT_UP, AckCode::ERR_SOFT_LOW] {
        for message in [move_to(3, 9), position_frame(2)] {
            let (said, events) = bench.asked_with(message, code);
            assert_eq!((said, events), (vec![bench.ack(&message, code)], vec![]));
        }
        let mut bench = Bench::on_frame();
        for message in [jog_all(4), run(1, 10, RunFlags(0)), shot(2)] {
            let (said, events) = bench.asked_with(message, code);
            assert_eq!((said, events), (vec![bench.ack(&message, code)], vec![]));
            assert_eq!((bench.state(), bench.machine.on_frame()), (State::Idle, Some(frame(1))));
        }
    }
}

/// D2-13
#[test]
fn a_limit_switch_stops_everything_hard() {
    for mut bench in Bench::everywhere() {
        let has_job = matches!(bench.state(), State::PreRoll | State::Ready | State::Running | State::PostRoll);
        for (upper, reason) in [(true, StopReason::UPPER_LIMIT), (false, StopReason::LOWER_LIMIT)] {
            let (said, events) = bench.step(Input::Rig(Report::Limit { motor: Motor(2), upper }));
            assert_eq!(said, [Said::Other(UNASKED, Contents::HardStop(reason, Some(Motor(2))))]);
            let mut expected = vec![Event::Stop(StopKind::Hard)];
            if has_job && upper {
                expected.push(Event::TriggersOff);
            }
            assert_eq!(events, expected);
            assert_eq!((bench.state(), bench.machine.on_frame()), (State::Locked, None));
        }
    }
    let mut bench = Bench::new();
    let (said, _) = bench.step(Input::Rig(Report::Fault(Some(Motor(3)))));
    let fault = Contents::HardStop(StopReason::ENGINE_EXCEPTION, Some(Motor(3)));
    assert_eq!(said, [Said::Other(UNASKED, fault)]);
}

/// D2-14
#[test]
fn the_emergency_stop_stops_everything_hard() {
    for mut bench in Bench::everywhere() {
        let (said, events) = bench.step(Input::Rig(Report::EmergencyStop(true)));
        assert_eq!(said, [Said::Other(UNASKED, Contents::HardStop(StopReason::EMERGENCY_STOP, None))]);
        assert_eq!(events[0], Event::Stop(StopKind::Hard));
        assert_eq!(bench.state(), State::Locked);
    }
}

/// D2-15, D-54
#[test]
fn a_lock_ends_some_time_after_rest_with_the_emergency_stop_released() {
    let mut bench = Bench::new();
    bench.asked(jog(2));
    bench.step(Input::Rig(Report::Limit { motor: Motor(2), upper: true }));
    let (said, events) = bench.pass(10_000);
    assert_eq!((said.len(), events), (100, vec![]), "positions are reported while motors move");
    assert_eq!(bench.rests().0, [Said::Positions(UNASKED, 0)]);
    assert_eq!(bench.pass(1999), (vec![], vec![]));
    assert_eq!(bench.state(), State::Locked);
    assert_eq!(bench.pass(1), (vec![], vec![Event::Unlocked]), "the lock ends, although the switch is still pressed");
    assert_eq!((bench.state(), bench.wake), (State::Idle, None));

    bench.step(Input::Rig(Report::EmergencyStop(true)));
    bench.rests();
    assert_eq!(bench.pass(60_000), (vec![], vec![]), "the lock lasts as long as the emergency stop is pressed");
    bench.step(Input::Rig(Report::Limit { motor: Motor(2), upper: true }));
    bench.rests();
    assert_eq!(bench.pass(60_000), (vec![], vec![]), "a limit during the lock changes nothing");
    assert_eq!(bench.step(Input::Rig(Report::EmergencyStop(false))), (vec![], vec![Event::Unlocked]));
    assert_eq!(bench.state(), State::Idle);

    bench.step(Input::Rig(Report::EmergencyStop(true)));
    assert_eq!(bench.step(Input::Rig(Report::EmergencyStop(false))), (vec![], vec![]), "motors still move");
    bench.rests();
    assert_eq!(bench.pass(2000), (vec![], vec![Event::Unlocked]));
}

/// D2-16, S-1
#[test]
fn a_stop_of_one_motor_of_a_coordinated_move_stops_the_whole_move() {
    for mut bench in Bench::everywhere() {
        let state = bench.state();
        let (said, events) = bench.asked(stop(2));
        assert_eq!(said, [bench.ack(&stop(2), AckCode::OK)], "{state:?}");
        assert_eq!(bench.machine.on_frame(), None);
        let all = Event::Stop(StopKind::All { silent: false });
        let (event, next) = match state {
            State::Idle | State::Moving | State::Stopping | State::Locked => {
                (Event::Stop(StopKind::Motor(Motor(2))), state)
            }
            _ => (all, State::Stopping),
        };
        assert_eq!((events[0], bench.state()), (event, next), "{state:?}");
        let has_job = matches!(state, State::PreRoll | State::Ready | State::Running | State::PostRoll);
        assert_eq!(events.contains(&Event::TriggersOff), has_job);
        bench.rests();
        assert_eq!(bench.state() == State::Idle, state != State::Locked);
    }
}

/// D2-17, S-4
#[test]
fn a_stop_of_everything_at_rest_is_acknowledged() {
    for flags in [None, Some(StopFlags(0)), Some(StopFlags::SILENT), Some(StopFlags(0x8000_0000))] {
        let mut bench = Bench::on_frame();
        let message = HostMessage::from(MotorStopAll { flags, tail: &[1, 2] });
        bench.takes(message, Event::Stop(StopKind::All { silent: flags == Some(StopFlags::SILENT) }));
        assert_eq!((bench.state(), bench.machine.on_frame()), (State::Idle, Some(frame(1))));
    }
}

/// D2-18, D-56
#[test]
fn a_stop_of_everything_decelerates_and_ends_every_move() {
    for flags in [None, Some(StopFlags::SILENT)] {
        let moving = |bench: &Bench| !matches!(bench.state(), State::Idle | State::Stopping | State::Locked);
        for mut bench in Bench::everywhere().into_iter().filter(moving) {
            let state = bench.state();
            let message = HostMessage::from(MotorStopAll { flags, tail: &[] });
            let (said, events) = bench.asked(message);
            assert_eq!(said, [bench.ack(&message, AckCode::OK)]);
            assert_eq!(events[0], Event::Stop(StopKind::All { silent: flags.is_some() }));
            assert_eq!(bench.state(), State::Stopping, "{state:?}");
            bench.refuses(jog(3), AckCode::ERR_MOVING);
            bench.refuses(position_frame(2), AckCode::ERR_MOVING);
            bench.rests();
            assert_eq!((bench.state(), bench.machine.on_frame()), (State::Idle, None));
        }
    }
}

/// D2-19
#[test]
fn a_second_stop_within_a_second_is_harder() {
    let mut bench = Bench::new();
    bench.asked(jog(3));
    bench.takes(stop_all(), Event::Stop(StopKind::All { silent: false }));
    bench.pass(999);
    bench.takes(stop_all(), Event::Stop(StopKind::Harder));
    bench.pass(999);
    bench.takes(stop_all(), Event::Stop(StopKind::Harder));
    bench.pass(1000);
    bench.takes(stop_all(), Event::Stop(StopKind::All { silent: false }));
    assert_eq!(bench.state(), State::Stopping);
    bench.rests();
    assert_eq!(bench.state(), State::Idle);
}

/// D2-20
#[test]
fn a_new_position_is_refused_while_motors_move() {
    for mut bench in Bench::everywhere() {
        match bench.state() {
            State::Idle => {}
            State::Locked => bench.refuses(reset(1), AckCode::ERR_HARD_UP),
            _ => bench.refuses(reset(1), AckCode::ERR_MOVING),
        }
    }
}

/// D2-21, D-57
#[test]
fn a_new_position_is_acknowledged_and_then_reported() {
    let mut bench = Bench::on_frame();
    let (said, events) = bench.asked(reset(1));
    assert_eq!(said, [bench.ack(&reset(1), AckCode::OK), Said::Positions(UNASKED, 0)]);
    assert_eq!(events, [Event::Apply(reset(1))]);
    assert_eq!((bench.machine.on_frame(), bench.wake), (None, None));
}

/// D2-22
#[test]
fn a_change_of_inputs_is_reported() {
    for mut bench in Bench::everywhere() {
        let told = |id| Said::Other(id, Contents::Inputs(Triggers(0b101)));
        assert_eq!(bench.step(Input::Rig(Report::Inputs(Triggers(0b101)))), (vec![told(UNASKED)], vec![]));
        let (said, _) = bench.asked(GioInRequest::default().into());
        assert_eq!(said, [told(bench.id())]);
    }
}

/// D2-23
#[test]
fn settings_are_accepted_in_every_state() {
    let limits = |lower_enable: bool, lower| {
        HostMessage::from(MotorSetLimits {
            motor: Motor(3),
            lower_enable: lower_enable.into(),
            lower: Steps(lower),
            upper_enable: true.into(),
            upper: Steps(5),
            hw_set: 1.into(),
            tail: &[],
        })
    };
    let speed = MotorSetSpeed { motor: Motor(1), max_velocity: Speed(1), max_accel: 1.into(), tail: &[] };
    for mut bench in Bench::everywhere() {
        let state = bench.state();
        let lights = Dmx { ramp: true.into(), start_channel: DmxChannel(1), values: &[1], tail: &[] };
        bench.takes_as(lights.into(), Event::Apply);
        bench.takes_as(GioOut { triggers: Triggers(1), tail: &[] }.into(), Event::Apply);
        if state == State::Locked {
            continue;
        }
        for message in [configure(1, MotorFlags::ENABLED), speed.into(), limits(true, 5), limits(false, 6)] {
            bench.takes_as(message, Event::Apply);
        }
        bench.refuses(limits(true, 6), AckCode::ERR_RANGE);
        let (said, events) = bench.asked_with(limits(true, 1), AckCode::ERR_RANGE);
        assert_eq!((said.len(), events), (1, vec![]), "the rig refuses the setting");
        assert_eq!(bench.state(), state);
    }
}

fn virtual_messages() -> [HostMessage<'static>; 3] {
    let (virtual_motor, position_x1e5) = (VirtualMotor::PAN, virtual_position(5));
    let line = VirtJogOnLine { axis: LineAxis::X, speed: LineSpeed(Scaled(-50)), tail: &[] };
    let jog = dmc_proto::message::VirtJog { virtual_motor, speed: JogSpeed::FULL, destination: Steps(1), tail: &[] };
    [VirtMove { virtual_motor, position_x1e5, tail: &[] }.into(), jog.into(), line.into()]
}

fn aim() -> HostMessage<'static> {
    let [aim_x, aim_y, aim_z] = [1, 2, 3].map(|at| dmc_proto::message::Coordinate(Scaled(at)));
    HostMessage::from(VirtAimPoint { enable: true.into(), aim_x, aim_y, aim_z, tail: &[] })
}

fn virtual_stop() -> HostMessage<'static> {
    HostMessage::from(VirtStop { virtual_motor: VirtualMotor::PAN, tail: &[] })
}

/// D4-1, D-69
#[test]
fn virtual_motors_move_after_their_configuration() {
    for message in virtual_messages() {
        let mut bench = Bench::on_frame();
        bench.takes_as(virtuals(&SWING_PAN), Event::Apply);
        assert!(bench.machine.has_virtuals());
        bench.takes_as(message, Event::MoveVirtual);
        assert_eq!((bench.state(), bench.machine.on_frame()), (State::Moving, None));
        assert_eq!(bench.machine.moving(), Motors(0xff), "any motor may belong to the rig");
        bench.takes_as(message, Event::MoveVirtual);
        bench.asked(stop_all());
        bench.refuses(message, AckCode::ERR_MOVING);
    }
}

/// D4-2
#[test]
fn a_configuration_can_remove_the_virtual_motors() {
    let mut bench = Bench::new();
    bench.takes_as(virtuals(&SWING_PAN), Event::Apply);
    bench.takes_as(virtuals(&[0]), Event::Apply);
    assert!(!bench.machine.has_virtuals());
    bench.refuses(aim(), AckCode::ERR_GENERAL);
}

/// D4-3
#[test]
fn a_configuration_that_is_refused_changes_nothing() {
    let mut bench = Bench::new();
    bench.takes_as(virtuals(&SWING_PAN), Event::Apply);
    bench.refuses(virtuals(&[9, 1, 2]), AckCode::ERR_UNSUPPORTED);
    for body in [&SWING_PAN[..], &[3, 1, 2], &[0]] {
        let (said, events) = bench.asked_with(virtuals(body), AckCode::ERR_UNSUPPORTED);
        assert_eq!((said, events), (vec![bench.ack(&virtuals(body), AckCode::ERR_UNSUPPORTED)], vec![]));
        assert!(bench.machine.has_virtuals());
    }
}

/// D4-4
#[test]
fn without_a_configuration_no_virtual_motor_moves() {
    let mut bench = Bench::new();
    for message in virtual_messages() {
        bench.refuses(message, AckCode::ERR_GENERAL);
    }
}

/// D4-5, S-7, D-55
#[test]
fn a_stop_of_a_virtual_motor_is_always_obeyed() {
    for mut bench in Bench::everywhere() {
        let state = bench.state();
        let (said, events) = bench.asked(virtual_stop());
        assert_eq!(said, [bench.ack(&virtual_stop(), AckCode::OK)]);
        let is_coordinated = !matches!(state, State::Idle | State::Moving | State::Stopping | State::Locked);
        let one = StopKind::Virtual(VirtualMotor::PAN);
        let stop = if is_coordinated { StopKind::All { silent: false } } else { one };
        assert_eq!(events[0], Event::Stop(stop), "{state:?}");
    }
    let mut bench = Bench::of(Options::of(Hi { capabilities: Capabilities(0), ..hi() }));
    bench.takes(virtual_stop(), Event::Stop(StopKind::Virtual(VirtualMotor::PAN)));
}

/// D4-6
#[test]
fn an_aim_is_confirmed_or_refused() {
    let mut bench = Bench::new();
    bench.refuses(aim(), AckCode::ERR_GENERAL);
    bench.asked(virtuals(&SWING_PAN));
    let (said, events) = bench.asked(aim());
    assert_eq!((said, events), (vec![Said::Other(bench.id(), Contents::Aim)], vec![Event::MoveVirtual(aim())]));
    assert_eq!(bench.state(), State::Moving, "motors follow the aim");
    let (said, events) = bench.asked_with(aim(), AckCode::ERR_RANGE);
    assert_eq!((said, events), (vec![bench.ack(&aim(), AckCode::ERR_RANGE)], vec![]));
    assert_eq!(bench.step(Input::Rig(Report::Aimed)), (vec![Said::Other(UNASKED, Contents::Aim)], vec![]));
    let (said, _) = bench.asked(VirtGetPosition::default().into());
    assert_eq!(said, [Said::Other(bench.id(), Contents::VirtualPositions)]);
    bench.rests();
    bench.load();
    bench.asked(position_frame(1));
    bench.refuses(aim(), AckCode::ERR_MOVING);
}

/// D4-7
#[test]
fn a_target_out_of_reach_is_out_of_range() {
    let mut bench = Bench::new();
    bench.asked(virtuals(&SWING_PAN));
    for message in virtual_messages() {
        let (said, events) = bench.asked_with(message, AckCode::ERR_RANGE);
        assert_eq!((said, events), (vec![bench.ack(&message, AckCode::ERR_RANGE)], vec![]));
        assert_eq!(bench.state(), State::Idle);
    }
}

/// D-53
#[test]
fn without_a_link_everything_stops() {
    for mut bench in Bench::everywhere() {
        let state = bench.state();
        let (said, events) = bench.step(Input::LinkDown);
        assert_eq!(said, []);
        if matches!(state, State::Idle | State::Stopping | State::Locked) {
            assert_eq!((events, bench.state()), (vec![], state));
        } else {
            assert_eq!(events[0], Event::Stop(StopKind::All { silent: false }));
            assert_eq!(bench.state(), State::Stopping);
        }
    }
}

/// D-6, D-17, D-18, D-19, D-45, D-52
#[test]
fn quirks_are_differences_of_real_devices() {
    let mut bench = Bench::of(Options::of(hi()).with_quirks(Quirks::VENDOR));
    let (said, _) = bench.asked(HiRequest::default().into());
    assert_eq!(said, [Said::Other(bench.id(), Contents::Greeting(Hi { protocol_version: None, ..hi() }))]);
    let (said, _) = bench.asked(get_position());
    assert_eq!(said, [Said::Positions(UNASKED, 0), bench.ack(&get_position(), AckCode::OK)]);
    let (said, _) = bench.asked(reset(1));
    assert_eq!(said, [Said::Positions(UNASKED, 0), bench.ack(&reset(1), AckCode::OK)]);
    let (said, _) = bench.asked(move_to(1, 5));
    assert_eq!(said, [bench.ack(&move_to(1, 5), AckCode::OK)]);
    bench.step(Input::Rig(Report::Limit { motor: Motor(1), upper: true }));
    bench.refuses(move_to(1, 5), AckCode::ERR_HARD_LOW);

    let machine = bench.machine.clone();
    let input = Input::Corrupt(MessageId(1), MessageType(0x0031));
    let (_, output) = laws::machine::step(machine, bench.now, input);
    let mut scratch = dmc_proto::device::Scratch::default();
    let mut bytes = [0; 64];
    let message = output.transmits().next().unwrap().message(&super::app::Tens, &mut scratch);
    let len = message.encode_into(MessageId(1), &mut bytes).unwrap();
    assert_eq!(bytes[10..len - 2], [0x11, 0, 0, 0], "the code has four bytes");
}

#[test]
fn times_of_a_device_are_options() {
    let options = Options::of(hi()).with_report_every(0).with_harder_within(10).with_hold(20);
    let mut bench = Bench::of(options);
    bench.asked(jog(1));
    assert_eq!(bench.pass(5).0.len(), 5, "positions are reported once in a millisecond");
    bench.asked(stop_all());
    bench.pass(10);
    bench.takes(stop_all(), Event::Stop(StopKind::All { silent: false }));
    bench.step(Input::Rig(Report::EmergencyStop(true)));
    bench.step(Input::Rig(Report::EmergencyStop(false)));
    bench.rests();
    assert_eq!(bench.pass(19), (vec![], vec![]));
    assert_eq!(bench.pass(1), (vec![], vec![Event::Unlocked]));
}

#[test]
fn a_report_that_does_not_fit_is_unexpected() {
    let mut bench = Bench::new();
    for input in [
        Input::Rig(Report::Moving(Motors(1))),
        Input::Rig(Report::AtFrame(frame(1))),
        Input::Rig(Report::PassEnd),
        Input::Rig(Report::OperatorGo),
        Input::Rig(Report::EmergencyStop(false)),
    ] {
        assert_eq!(bench.step(input), (vec![], vec![Event::UnexpectedReport]));
    }
    assert_eq!(bench.rests(), (vec![], vec![]), "the motors rested before");
}

#[test]
fn a_wake_too_early_changes_nothing_and_a_late_one_reports_once() {
    let mut bench = Bench::new();
    assert_eq!(bench.step(Input::Wake), (vec![], vec![]));
    bench.asked(jog(1));
    let before = bench.machine.clone();
    bench.now = bench.now.after(99);
    assert_eq!(bench.step(Input::Wake), (vec![], vec![]));
    assert_eq!(bench.machine, before);
    bench.now = bench.now.after(100_000);
    assert_eq!(bench.step(Input::Wake).0, [Said::Positions(UNASKED, 0)], "one report, not all reports that were due");
    bench.now = Millis(u64::MAX);
    bench.step(Input::Wake);
    assert_eq!(bench.wake, None, "no wake is later than the last moment");
}

/// D-78
#[test]
fn a_device_may_lock_after_a_stop_of_everything() {
    let mut bench = Bench::quirky(Quirks::STOP_LOCKS);
    bench.takes(stop_all(), Event::Stop(StopKind::All { silent: false }));
    assert_eq!(bench.state(), State::Idle, "nothing moved");
    bench.asked(jog(3));
    bench.takes(stop_all(), Event::Stop(StopKind::All { silent: false }));
    assert_eq!(bench.state(), State::Locked);
    for message in [stop_all(), stop(3), jog(3), configure(3, MotorFlags::ENABLED)] {
        bench.refuses(message, AckCode::ERR_HARD_LOW);
    }
    assert_eq!(bench.asked(status()).0, [Said::Other(bench.id(), Contents::Status(Motors(4)))]);
    bench.rests();
    bench.pass(1999);
    bench.refuses(stop_all(), AckCode::ERR_HARD_LOW);
    assert_eq!(bench.pass(1).1, [Event::Unlocked]);
    bench.takes(stop_all(), Event::Stop(StopKind::All { silent: false }));
    // A silent stop does not lock.
    bench.asked(jog(3));
    let silent = HostMessage::from(MotorStopAll { flags: Some(StopFlags::SILENT), tail: &[] });
    bench.takes(silent, Event::Stop(StopKind::All { silent: true }));
    assert_eq!(bench.state(), State::Stopping);
    // Nor does a stop with any other flag.
    bench.rests();
    bench.asked(jog(3));
    bench.takes(
        MotorStopAll { flags: Some(StopFlags(2)), tail: &[] }.into(),
        Event::Stop(StopKind::All { silent: true }),
    );
    assert_eq!(bench.state(), State::Stopping);
}

/// D-52
#[test]
fn a_device_with_one_lock_code_looks_at_nothing_else() {
    for (quirks, code) in [(Quirks(0), AckCode::ERR_RANGE), (Quirks::ONE_LOCK_CODE, AckCode::ERR_HARD_LOW)] {
        let mut bench = Bench::quirky(quirks);
        bench.asked(jog(3));
        bench.step(Input::Rig(Report::Limit { motor: Motor(3), upper: true }));
        bench.refuses(jog(33), code);
        let malformed = bench.step(Input::Malformed(MessageId(9), MessageType(0x0031))).0;
        let code = if code == AckCode::ERR_RANGE { AckCode::ERR_GENERAL } else { code };
        assert_eq!(malformed, [Said::Ack(9, 0x0031, code)]);
    }
}

/// D-79
#[test]
fn a_device_may_ignore_a_stop_of_one_motor_in_a_run() {
    let mut bench = Bench::quirky(Quirks::STOP_OF_ONE_IGNORED);
    bench.asked(run(1, 10, RunFlags(0)));
    let (said, events) = bench.asked(stop(1));
    assert_eq!((said, events), (vec![bench.ack(&stop(1), AckCode::OK)], vec![]));
    assert_eq!(bench.state(), State::PreRoll);
    bench.asked(stop_all());
    bench.rests();
    bench.asked(jog(1));
    bench.takes(stop(1), Event::Stop(StopKind::Motor(Motor(1))));
    bench.rests();
    // On the way to a frame the other motors go on.
    bench.asked(position_frame(5));
    bench.takes(stop(1), Event::Stop(StopKind::Motor(Motor(1))));
    assert_eq!(bench.state(), State::Moving);
    bench.rests();
    assert_eq!(bench.machine.on_frame(), None);
}

/// D-83
#[test]
fn a_device_may_send_positions_after_an_acknowledgement() {
    let mut bench = Bench::quirky(Quirks::POSITIONS_AFTER_ACK);
    for message in [stop_all(), stop(1), position_frame(1), reset(1)] {
        bench.rests();
        let (said, _) = bench.asked(message);
        let Said::Positions(id, _) = said[1] else { panic!("{said:?}") };
        assert_eq!((&said[0], id, said.len()), (&bench.ack(&message, AckCode::OK), bench.id(), 2), "{message}");
    }
}
