//! Single motors: questions, moves, jogs, limits, stops.

use dmc_proto::device::{Quirks, State};
use dmc_proto::host::{self, Outcome, Refusal, StopTarget};
use dmc_proto::message::{
    Acceleration, AckCode, Bool, DeviceMessage, FrameNumber, GioInRequest, HardwareLimitSet, I32, Motor,
    MotorConfigure, MotorFlags, MotorGetPosition, MotorResetPosition, MotorSetLimits, MotorSetSpeed,
    MotorStatusRequest, MotorStopAll, Motors, RtPositionFrame, RtUploadMoveAxis, RtUploadMoveBegin, RtUploadMoveEnd,
    RunFlags, Speed, StartIndex, Steps, StopReason, Triggers,
};
use dmc_proto::{Frame, HostMessage, MessageId};
use motion_core::profile::MotionProfile;
use motion_core::time::Millis;
use motion_rigs::device::Named as _;
use motion_rigs::dmc_device::{DmcDevice, Facts, Setup};
use motion_rigs::dmc_host::{Answer, Command, Event};
use motion_rigs::{LineId, Outgoing, Party as _, Rig as _};

use super::stage::{Stage, devices, jog, move_to, run};

fn reset_position(motor: u8, position: i32) -> MotorResetPosition<'static> {
    let (motor, position) = (Motor(motor), Steps(position));
    MotorResetPosition { motor, position, tail: &[] }
}

pub(crate) fn limits(motor: u8, lower: i32, upper: i32) -> MotorSetLimits<'static> {
    MotorSetLimits {
        motor: Motor(motor),
        lower_enable: Bool::TRUE,
        lower: Steps(lower),
        upper_enable: Bool::TRUE,
        upper: Steps(upper),
        hw_set: HardwareLimitSet(motor),
        tail: &[],
    }
}

fn bytes(message: HostMessage<'_>) -> Vec<u8> {
    let mut bytes = vec![0; message.encoded_len()];
    message.encode_into(MessageId(1), &mut bytes).unwrap();
    bytes
}

/// Stage with each device that has a name, and facts of the device.
fn stages() -> impl Iterator<Item = (Stage, Facts)> {
    devices().map(|(setup, _)| {
        let facts = setup.facts;
        (Stage::up(setup), facts)
    })
}

#[test]
fn a_device_tells_its_properties_and_positions() {
    for (mut stage, facts) in stages() {
        let hi = stage.scene.host.machine().device().unwrap();
        assert_eq!((hi.name.to_string(), hi.motor_count), (stage.rig().name(), 4));
        let short = i32::from(facts.truncates);
        assert_eq!(stage.status(), Motors::NONE);
        for motor in 1..=4 {
            stage.ask(reset_position(motor, i32::from(motor) * 1000)).unwrap();
        }
        match stage.ask(MotorGetPosition::default()) {
            Ok(Answer::Positions(positions)) => {
                assert_eq!(positions.positions, [1000, 2000, 3000, 4000].map(|steps| steps - short));
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_motor_moves_to_a_position_along_its_profile() {
    for (mut stage, _) in stages() {
        let speed =
            MotorSetSpeed { motor: Motor(2), max_velocity: Speed(10_000), max_accel: Acceleration(20_000), tail: &[] };
        stage.ask(speed).unwrap();
        let token = stage.token();
        stage.scene.command(Command::Ask(token, move_to(2, 30_000).into()));
        let began = stage.now();
        stage.tick();
        let limits = motion_core::profile::Limits { velocity: 10_000.0, acceleration: 20_000.0, jerk: None };
        let planned = MotionProfile::new(0.0, 30_000.0, limits).unwrap();
        while stage.rig().machine().state() != State::Idle {
            let seconds = f64::from(u32::try_from(stage.now().since(began)).unwrap()) / 1000.0;
            // The motor and the profile calculate in different ways, which makes a difference of less than 0.01 steps.
            assert!((stage.at(2) - planned.at(seconds).position).abs() < 0.01, "after {seconds} s");
            stage.tick();
        }
        assert!((3500..3510).contains(&stage.now().since(began)), "{:?}", stage.now());
        assert_eq!(stage.steps(2), Some(30_000));
        assert_eq!(stage.end(token, 0), Ok(Answer::Done));
        assert!(stage.scene.host.may_move(), "the host does not know yet that the motor rests");
        assert_eq!(stage.status(), Motors::NONE);
        assert!(!stage.scene.host.may_move());
    }
}

#[test]
fn the_status_tells_the_motors_that_move() {
    let mut stage = Stage::up(Setup::default());
    stage.ask(move_to(1, 2000)).unwrap();
    stage.ask(move_to(3, 60_000)).unwrap();
    assert_eq!(stage.status(), Motors(0b101));
    stage.pass(1500);
    assert_eq!(stage.status(), Motors(0b100));
    stage.pass(3000);
    assert_eq!(stage.status(), Motors::NONE);
}

#[test]
fn a_jog_goes_on_until_it_is_stopped() {
    for (mut stage, facts) in stages() {
        stage.ask(jog(1, 50, i32::MIN)).unwrap();
        stage.pass(2000);
        let now = stage.now();
        let velocity = motion_rigs::Rig::motors(stage.rig())[0].at(now).velocity;
        // Some devices end a jog by themselves.
        let wanted = if facts.jog_lasts.is_some() { 0.0 } else { -25_000.0_f64 };
        assert_eq!(velocity.to_bits(), wanted.to_bits());
        let target = StopTarget::Motor(Motor(1));
        stage.scene.command(Command::Stop(target));
        let stopped = Event::Machine(host::Event::Stopped(target));
        assert!(stage.wait(1000, |event| (*event == stopped).then_some(())).is_some());
        stage.pass(1000);
        assert!(stage.all_rest());
        assert_eq!((stage.rig().machine().state(), stage.status()), (State::Idle, Motors::NONE));
    }
}

/// A jog that is repeated goes on on each device, and a repeat after its end starts no other motor.
#[test]
fn a_jog_that_is_repeated_goes_on() {
    for (mut stage, _) in stages() {
        for _ in 0..10 {
            stage.ask(jog(1, 50, i32::MIN)).unwrap();
            stage.pass(200);
        }
        let now = stage.now();
        let half = f64::from(stage.rig().tuning(Motor(1)).unwrap().speed.0) / 2.0;
        let velocity = motion_rigs::Rig::motors(stage.rig())[0].at(now).velocity;
        assert!((velocity + half).abs() < 1e-6, "{velocity}");
        assert!(stage.stop() && stage.rests());
    }
}

/// Some devices pass limits that were set, with a host that does not look at them either.
#[test]
fn a_device_without_limits_passes_them() {
    for (setup, _) in devices() {
        let passes = setup.facts.ignores_limits;
        let mut rig = DmcDevice::new(setup);
        rig.open(Millis(0), LineId(0));
        let configure = MotorConfigure { motor: Motor(1), flags: MotorFlags::ENABLED, tail: &[] };
        let limits = MotorSetLimits { hw_set: HardwareLimitSet(0), ..limits(1, -50, 80) };
        for message in [configure.into(), limits.into(), move_to(1, 81).into()] {
            rig.receive(Millis(0), LineId(0), &bytes(message));
        }
        rig.advance(Millis(3000));
        let here = rig.motors()[0].at(Millis(3000)).position;
        assert!((here - if passes { 81.0 } else { 0.0 }).abs() < 1e-9, "{here}");
    }
}

#[test]
fn limits_that_were_set_refuse_moves_and_end_jogs() {
    for (mut stage, _) in stages() {
        let hw_set = HardwareLimitSet(0);
        let (max_velocity, max_accel) = (Speed(50_000), Acceleration(100_000));
        stage.ask(MotorSetSpeed { motor: Motor(1), max_velocity, max_accel, tail: &[] }).unwrap();
        stage.ask(MotorSetLimits { hw_set, ..limits(1, -5000, 8000) }).unwrap();
        let tuning = stage.rig().tuning(Motor(1)).unwrap();
        assert_eq!((tuning.lower, tuning.upper), (Some(Steps(-5000)), Some(Steps(8000))));
        assert_eq!(stage.ask(move_to(1, 8001)), Err(Outcome::Refused(Refusal::WouldBeRefused(AckCode::ERR_SOFT_UP))));
        assert_eq!(stage.ask(move_to(1, -5001)), Err(Outcome::Refused(Refusal::WouldBeRefused(AckCode::ERR_SOFT_LOW))));
        assert!(stage.all_rest() && stage.steps(1) == Some(0), "nothing moved");
        assert!(!stage.scene.host.may_move());
        for (destination, end) in [(i32::MAX, 8000), (i32::MIN, -5000)] {
            stage.ask(jog(1, 100, destination)).unwrap();
            stage.pass(3000);
            assert!(stage.all_rest());
            assert_eq!(stage.steps(1), Some(end));
            assert_eq!(stage.rig().machine().state(), State::Idle, "not locked");
        }
        // A motor beyond its limit does not turn round to that limit.
        stage.ask(reset_position(1, 10_000)).unwrap();
        let refused = Err(Outcome::Refused(Refusal::WouldBeRefused(AckCode::ERR_SOFT_UP)));
        assert_eq!(stage.ask(jog(1, 100, i32::MAX)), refused);
        stage.pass(500);
        assert!(stage.all_rest() && stage.steps(1) == Some(10_000));
        stage.ask(jog(1, 100, 7000)).unwrap();
        stage.pass(3000);
        assert_eq!(stage.steps(1), Some(7000));
    }
}

/// A slow jog has a low acceleration. It still has to slow a fast motor down before a limit.
#[test]
fn a_slow_jog_after_a_fast_one_stays_within_the_limits() {
    let speed = |max_accel| {
        let (motor, max_velocity) = (Motor(1), Speed(50_000));
        MotorSetSpeed { motor, max_velocity, max_accel: Acceleration(max_accel), tail: &[] }
    };
    for (destination, max_accel) in [(i32::MAX, 50_000), (i32::MIN, 50_000), (i32::MAX, 5000), (i32::MIN, 5000)] {
        let mut stage = Stage::up(Setup::default());
        stage.ask(limits(1, -80_000, 80_000)).unwrap();
        stage.ask(jog(1, 100, i32::MAX)).unwrap();
        stage.pass(1700);
        stage.ask(speed(max_accel)).unwrap();
        stage.ask(jog(1, 1, destination)).unwrap();
        for _ in 0..5000 {
            stage.tick();
            assert!(stage.at(1) < 80_000.01, "{}", stage.at(1));
        }
        if destination == i32::MAX {
            assert_eq!((stage.rig().machine().state(), stage.steps(1)), (State::Idle, Some(80_000)));
        } else {
            assert_eq!(stage.rig().machine().state(), State::Moving, "it moves back slowly");
        }
    }
}

/// A stop of the host does not make the deceleration of an emergency stop lower.
#[test]
fn a_stop_does_not_soften_the_emergency_stop() {
    let way = |stops: bool| {
        let mut stage = Stage::up(Setup::default());
        stage.ask(jog(1, 100, i32::MAX)).unwrap();
        stage.pass(2000);
        let (from, now) = (stage.at(1), stage.now());
        stage.rig().emergency_stop(now, true);
        stage.pass(10);
        assert!(!stops || stage.stop());
        stage.pass(2000);
        assert!(stage.all_rest());
        stage.at(1) - from
    };
    assert!((way(true) - way(false)).abs() < 1.0, "{} {}", way(true), way(false));
}

#[test]
fn a_limit_switch_stops_everything_and_locks_for_a_while() {
    for (mut setup, quirks) in devices() {
        (setup.facts.jog_lasts, setup.facts.tuned) = (None, None);
        let mut stage = Stage::up(setup);
        stage.ask(jog(2, 100, i32::MAX)).unwrap();
        stage.ask(jog(1, 90, i32::MAX)).unwrap();
        let hard = |event: &Event| {
            (*event == Event::Machine(host::Event::HardStop(StopReason::UPPER_LIMIT, Some(Motor(2))))).then_some(())
        };
        assert!(stage.wait(10_000, hard).is_some());
        assert_eq!(stage.rig().machine().state(), State::Locked);
        stage.pass(600);
        assert!(stage.all_rest());
        let is_one = quirks.contains(Quirks::ONE_LOCK_CODE);
        let code = if is_one { AckCode::ERR_HARD_LOW } else { AckCode::ERR_HARD_UP };
        assert_eq!(stage.ask(move_to(3, 5)), Err(Outcome::Refused(Refusal::Device(code))));
        assert!(stage.stop(), "a stop is always obeyed");
        stage.pass(2500);
        assert_eq!(stage.rig().machine().state(), State::Idle);
        assert_eq!(stage.ask(move_to(2, 1000)), Ok(Answer::Done), "the motor may move off the switch");
        stage.pass(20_000);
        assert_eq!(stage.steps(2), Some(1000));
    }
}

#[test]
fn the_emergency_stop_locks_until_it_is_released() {
    let mut stage = Stage::up(Setup::default());
    stage.ask(jog(1, 100, i32::MAX)).unwrap();
    stage.pass(1000);
    let now = stage.now();
    stage.rig().emergency_stop(now, true);
    let hard = |event: &Event| {
        matches!(event, Event::Machine(host::Event::HardStop(StopReason::EMERGENCY_STOP, None))).then_some(())
    };
    assert!(stage.wait(1000, hard).is_some());
    stage.pass(5000);
    assert!(stage.all_rest());
    assert_eq!(stage.ask(move_to(1, 0)), Err(Outcome::Refused(Refusal::Device(AckCode::ERR_GENERAL))));
    let now = stage.now();
    stage.rig().emergency_stop(now, false);
    stage.pass(100);
    assert_eq!(stage.ask(move_to(1, 0)), Ok(Answer::Done));
}

#[test]
fn a_second_stop_is_harder() {
    let way = |stops: u32| {
        let mut stage = Stage::up(Setup::default());
        stage.ask(jog(1, 100, i32::MAX)).unwrap();
        stage.pass(2000);
        let from = stage.at(1);
        for _ in 0..stops {
            assert!(stage.stop());
            stage.pass(50);
        }
        stage.pass(2000);
        assert!(stage.all_rest());
        stage.at(1) - from
    };
    assert!(way(2) < way(1) * 0.8, "{} {}", way(2), way(1));
}

#[test]
fn a_motor_that_gets_stuck_stops_all_motors() {
    let mut stage = Stage::up(Setup::default());
    stage.ask(jog(2, 100, i32::MAX)).unwrap();
    stage.ask(jog(3, 100, i32::MAX)).unwrap();
    stage.pass(500);
    let now = stage.now();
    motion_rigs::Rig::stall(stage.rig(), now);
    let stuck = |event: &Event| {
        matches!(event, Event::Machine(host::Event::HardStop(StopReason::ENGINE_EXCEPTION, _))).then_some(())
    };
    assert!(stage.wait(1000, stuck).is_some());
    stage.pass(1000);
    assert!(stage.all_rest());
}

#[test]
fn a_change_of_inputs_is_reported() {
    let mut stage = Stage::up(Setup::default());
    let now = stage.now();
    stage.rig().set_inputs(now, Triggers(0b10));
    assert!(stage.wait(100, |event| (*event == Event::Inputs(Triggers(0b10))).then_some(())).is_some());
    assert_eq!(stage.ask(GioInRequest::default()), Ok(Answer::Inputs(Triggers(0b10))));
}

/// Some devices give each enabled motor a path of zeros. Such a motor counts as moving, although the upload does not name it.
#[test]
fn a_motor_that_an_upload_does_not_name_counts_as_moving() {
    let mut rig = DmcDevice::new(Setup::default().with_device("dmc-lite").unwrap());
    rig.open(Millis(0), LineId(0));
    let motor = Motor(2);
    let configure = MotorConfigure { motor, flags: MotorFlags::ENABLED, tail: &[] };
    let begin = RtUploadMoveBegin { end_frame: FrameNumber(9), ..RtUploadMoveBegin::default() };
    let reset = reset_position(2, 50_000);
    for message in [reset.into(), configure.into(), begin.into(), RtUploadMoveEnd::default().into()] {
        rig.receive(Millis(0), LineId(0), &bytes(message));
    }
    rig.receive(Millis(0), LineId(0), &bytes(RtPositionFrame::default().into()));
    rig.advance(Millis(200));
    assert!(rig.motors()[1].at(Millis(200)).velocity < 0.0);
    while rig.poll().is_some() {}
    rig.receive(Millis(200), LineId(0), &bytes(MotorStatusRequest::default().into()));
    let Some(Outgoing::Bytes(_, answer)) = rig.poll() else { panic!("no answer") };
    let Ok(DeviceMessage::MotorStatus(status)) = DeviceMessage::decode(&Frame::decode(&answer).unwrap()) else {
        panic!("no status")
    };
    assert_eq!(status.motor_status, Motors::from_iter([motor]));
}

/// A motor that is not enabled seems to go its way, and gets no pulses. Some devices move it all the same.
#[test]
fn a_motor_that_is_not_enabled_does_not_move() {
    for (setup, _) in devices() {
        let moves = setup.facts.moves_disabled || setup.facts.uses.contains(MotorFlags::ENABLED);
        let mut rig = DmcDevice::new(setup);
        rig.open(Millis(0), LineId(0));
        rig.receive(Millis(0), LineId(0), &bytes(move_to(1, 2000).into()));
        rig.advance(Millis(3000));
        let stands = |rig: &DmcDevice, now, place: f64| {
            let here = rig.motors()[0].at(now).position;
            assert!((here - place).abs() < 1e-9, "{here}, not {place}");
        };
        stands(&rig, Millis(3000), if moves { 2000.0 } else { 0.0 });
        let configure = MotorConfigure { motor: Motor(1), flags: MotorFlags::ENABLED, tail: &[] };
        rig.receive(Millis(3000), LineId(0), &bytes(configure.into()));
        rig.receive(Millis(3000), LineId(0), &bytes(move_to(1, 5000).into()));
        rig.advance(Millis(6000));
        stands(&rig, Millis(6000), if moves { 5000.0 } else { 3000.0 });
    }
}

/// D-96: a host sends all motors to the first frame before it prepares a run.
#[test]
fn a_stop_on_the_way_to_a_run_may_not_end_it() {
    let positions: Vec<_> = (0..49).map(|index| I32::new(100 * index)).collect();
    let (start_frame, end_frame) = (FrameNumber(1), FrameNumber(49));
    let upload: [HostMessage<'_>; 5] = [
        MotorConfigure { motor: Motor(1), flags: MotorFlags::ENABLED, tail: &[] }.into(),
        RtUploadMoveBegin { start_frame, end_frame, tail: &[] }.into(),
        RtUploadMoveAxis { motor: Motor(1), start_index: StartIndex(0), positions: &positions, tail: &[] }.into(),
        RtUploadMoveEnd::default().into(),
        RtPositionFrame { frame: FrameNumber(40), tail: &[] }.into(),
    ];
    for (setup, quirks) in devices() {
        let goes_on = setup.facts.jogs_to_run;
        let mut rig = DmcDevice::new(setup);
        rig.open(Millis(0), LineId(0));
        for message in upload {
            rig.receive(Millis(0), LineId(0), &bytes(message));
        }
        rig.receive(Millis(5000), LineId(0), &bytes(run(24_000, 1, 49, 1000, RunFlags::empty()).into()));
        assert_eq!(rig.machine().state(), State::PreRoll);
        rig.receive(Millis(5150), LineId(0), &bytes(MotorStopAll::default().into()));
        rig.advance(Millis(10_000));
        assert_eq!(rig.machine().state(), State::Idle);
        let place = rig.motors()[0].at(Millis(10_000));
        assert_eq!(place.velocity.to_bits(), 0.0_f64.to_bits());
        assert_eq!((place.position + 1200.0).abs() < 1.0, goes_on, "{quirks:?}: {place:?}");
    }
}
