//! Usual work: questions, moves, a joystick, stops, photos.

use hoot_proto::device::{MotorState, Options, ProgramState, Quirks};
use hoot_proto::frame::MAX_FRAME;
use hoot_proto::host::{Command, Event, Outcome, Refusal, StopTarget};
use hoot_proto::message::{
    self, CameraExposing, CoreDeviceId, Easing, FirmwareVersion, Microstep, Milliseconds, Motor, NameQuery,
    ProgramMode, Span, StepsPerSecond,
};
use hoot_proto::program::Plan;
use hoot_proto::query::{AnyReply, Profile};
use hoot_proto::{Address, HostMessage};
use motion_core::profile::{self, Limits};
use motion_core::time::Millis;
use motion_rigs::hoot_node::{HootNode, Setup};
use motion_rigs::{LineId, Party as _};

use crate::world::{
    NODE, ONE, START, STATUS, STOP, dead_man, joystick, mode, motor_stop, move_by, photos, planned, ready, run,
    set_speed, smooth, stage,
};

#[test]
fn a_node_says_what_it_is() {
    let mut stage = stage(Setup::default());
    assert_eq!(stage.read(FirmwareVersion {}), message::Version(6));
    assert_eq!(stage.scene.host.profile(NODE), Profile::VERSION_6, "many builds have this version");
    let name = stage.ok(NameQuery {});
    let Some(AnyReply::Name(name)) = name.answer() else { panic!("{name}") };
    assert_eq!(name.value.0, b"DEFAULT   ");
    let id = stage.ok(CoreDeviceId::default());
    assert!(matches!(id.answer(), Some(AnyReply::CoreDeviceId(id)) if id.value.0 == b"OMAXISVX"), "{id}");
    assert_eq!(stage.position(Motor::Three), 0);
    assert!(stage.ok(STATUS).answer().is_some());
}

/// At each tick the motor is at its place on the trapezoid of its speed and acceleration. The node answers the nearest step.
#[test]
fn a_move_follows_its_trapezoid() {
    let mut stage = stage(Setup::default());
    stage.enable(ONE, 2000.0);
    stage.send_to(NODE, move_by(ONE, 4000));
    stage.until(500, |stage| !stage.is_at_rest());
    let began = stage.now();
    let limits = Limits { velocity: 2000.0, acceleration: 5000.0, jerk: None };
    let planned = profile::MotionProfile::new(0.0, 4000.0, limits).unwrap();
    let mut ticks = 0_u32;
    while !stage.is_at_rest() {
        let moment = f64::from(u32::try_from(stage.now() - began).unwrap()) / 1000.0;
        let place = stage.place(0);
        assert!((place - planned.at(moment).position).abs() < 1e-6, "{place} after {moment} s");
        let known = stage.scene.rig.machine().motor(ONE).position().0;
        assert!((f64::from(known) - place).abs() <= 0.5, "{known} for {place}");
        assert!(stage.may_move());
        stage.tick();
        ticks += 1;
    }
    assert!((f64::from(ticks) / 1000.0 - planned.duration()).abs() < 0.002, "{ticks} ms");
    assert_eq!(stage.position(ONE), 4000);
    assert!(stage.may_move(), "nobody has asked whether the motor moves");
    assert!(!stage.is_running(ONE));
    assert!(!stage.may_move());
}

#[test]
fn positions_count_in_the_direction_and_the_microsteps_of_the_motor() {
    let mut stage = stage(Setup::default());
    stage.enable(ONE, 4000.0);
    let turn = message::MotorSetDirection { motor: ONE, direction: message::Direction(1) };
    for (message, to) in
        [(HostMessage::from(move_by(ONE, 100)), 100), (move_by(ONE, -300).into(), -200), (turn.into(), -200)]
    {
        stage.ok(message);
        stage.pass(1000);
        assert_eq!(stage.position(ONE), to);
    }
    stage.ok(move_by(ONE, 100));
    stage.pass(1000);
    assert_eq!(stage.position(ONE), -300);

    let microstep = |microstep| message::MotorSetMicrostep { motor: ONE, microstep };
    stage.ok(microstep(Microstep::SIXTEENTH));
    assert_eq!(stage.position(ONE), -1200);
    let motor = &stage.scene.rig;
    let travel = motion_rigs::Rig::motors(motor)[0].travel().unwrap();
    assert!((travel.to - 800_000.0).abs() < 1e-6, "the rig is as long as before");
    stage.ok(message::MotorSetHomeHere { motor: ONE });
    assert_eq!(stage.position(ONE), 0);
    let travel = motion_rigs::Rig::motors(&stage.scene.rig)[0].travel().unwrap();
    assert!((travel.to - 801_200.0).abs() < 1e-6, "the end of the rig is where it was");
}

/// A joystick sends many speeds, keeps the node alive, and stops the motor with the speed 0.
#[test]
fn a_joystick_runs_a_motor() {
    let mut stage = stage(Setup::default());
    stage.enable(ONE, 0.0);
    stage.ok(dead_man(true));
    stage.ok(joystick(true));
    stage.command(Command::KeepAlive { to: NODE, on: true });
    stage.ok(run(ONE));
    for speed in [500.0, 1000.0, 2000.0, -2000.0] {
        stage.command(Command::Speed { to: NODE, motor: ONE, speed: StepsPerSecond(speed) });
        stage.pass(1500);
        let velocity = motion_rigs::Rig::motors(&stage.scene.rig)[0].at(stage.scene.now()).velocity;
        assert!((velocity - f64::from(speed)).abs() < 1.0, "{velocity} instead of {speed}");
        assert!(stage.may_move());
    }
    stage.command(Command::Speed { to: NODE, motor: ONE, speed: StepsPerSecond(0.0) });
    stage.pass(1500);
    assert!(stage.is_at_rest());
    assert_eq!(stage.scene.rig.machine().motor(ONE).state(), MotorState::Continuous, "the motor runs at speed 0");
    stage.ok(motor_stop(ONE));
    assert!(!stage.may_move());
    let events: Vec<_> = stage.events.iter().map(|(_, event)| *event).collect();
    let stopped = Event::Stopped(StopTarget::Motor(NODE, ONE));
    assert_eq!(events, [Event::Ready { reconnected: false }, stopped], "no keep-alive was lost");
}

#[test]
fn in_joystick_mode_a_node_refuses_questions_and_accepts_stops() {
    let mut stage = stage(Setup::default());
    stage.enable(ONE, 1000.0);
    stage.ok(joystick(true));
    let refused = stage.ask(STATUS);
    assert!(matches!(refused.outcome(), Outcome::Refused(Refusal::Device(_))), "{refused}");
    stage.ok(run(ONE));
    stage.pass(300);
    assert!(!stage.is_at_rest());
    stage.ok(STOP);
    assert!(stage.is_at_rest() && !stage.may_move());
    stage.ok(joystick(false));
    stage.ok(STATUS);
}

#[test]
fn the_dead_man_stops_motors_after_a_second_without_a_master() {
    let mut stage = stage(Setup::default());
    stage.enable(ONE, 1000.0);
    stage.ok(dead_man(true));
    let before = stage.now();
    stage.ok(run(ONE));
    stage.until(2000, |stage| stage.is_at_rest());
    let took = stage.now() - before;
    assert!((1000..=1300).contains(&took), "{took} ms");
    assert!(!stage.is_running(ONE));
}

#[test]
fn a_stop_stops_a_motor_at_once() {
    let mut stage = stage(Setup::default());
    for stop in [HostMessage::from(STOP), motor_stop(ONE).into()] {
        stage.enable(ONE, 4000.0);
        stage.ok(run(ONE));
        stage.pass(500);
        assert!(!stage.is_at_rest());
        let before = stage.now();
        stage.ok(stop);
        assert!(stage.is_at_rest() && stage.now() - before < 200);
    }
}

#[test]
fn an_emergency_stop_is_confirmed_when_all_motors_rest_also_in_joystick_mode() {
    let firmware = Options::new().with_quirks(Quirks::FIRMWARE);
    for device in [Options::new(), firmware] {
        for stick in [false, true] {
            let mut stage = stage(Setup::default().with_options(device));
            for motor in Motor::ALL {
                stage.enable(motor, 3000.0);
            }
            stage.ok(joystick(stick));
            for motor in Motor::ALL {
                stage.ok(run(motor));
            }
            stage.pass(200);
            let before = stage.now();
            stage.emergency_stop();
            assert!(stage.is_at_rest() && !stage.may_move());
            assert!(stage.now() - before < 3000, "{} ms", stage.now() - before);
        }
    }
}

#[test]
fn a_photo_takes_its_exposure_and_a_second_one_is_not_taken_meanwhile() {
    let mut stage = stage(Setup::default());
    for message in photos(0, 250, 1000) {
        stage.ok(message);
    }
    stage.ok(message::CameraExpose {});
    assert!(stage.scene.rig.camera().is_open());
    assert!(stage.read(CameraExposing {}).get());
    stage.ok(message::CameraExpose {});
    stage.pass(500);
    assert!(!stage.read(CameraExposing {}).get());
    let photos: Vec<_> = stage.scene.rig.camera().photos().map(|photo| photo.closed.since(photo.opened)).collect();
    assert_eq!((stage.scene.rig.camera().taken(), photos), (1, vec![250]));
}

/// The node answers OK, so only the question shows that it has another speed.
#[test]
fn a_speed_beyond_the_greatest_is_ignored() {
    let mut stage = stage(Setup::default());
    stage.enable(ONE, 1000.0);
    stage.ok(set_speed(ONE, 9000.0));
    let speed = stage.read(message::MotorContinuousSpeed { motor: ONE });
    assert!((speed.0.to_f64() - 1000.0).abs() < 0.01, "{speed}");
    assert_eq!(stage.read(message::CameraInterval {}), Milliseconds(0));
}

/// Events that are due happen one after the other, however late the node is called.
#[test]
fn a_node_that_is_called_seldom_does_the_same() {
    let plan =
        Plan { travel: Span(9), acceleration: Span(3), deceleration: Span(3), easing: Easing::LINEAR, ..smooth() };
    let node = |every: u64| {
        let mut node = HootNode::new(Setup::default());
        node.open(Millis(0), LineId(0));
        let program = planned(ONE, 0, plan).into_iter().chain(photos(10, 100, 500));
        for message in
            ready(ONE, 1000.0).into_iter().chain(program).chain([mode(ProgramMode::SMS).into(), START.into()])
        {
            let mut packet = [0; MAX_FRAME];
            let len = message.encode_into(NODE, &mut packet).unwrap();
            node.receive(Millis(0), LineId(0), &packet[..len]);
        }
        (1..=20_000 / every).for_each(|count| node.advance(Millis(count * every)));
        let at = motion_rigs::Rig::motors(&node)[0].at(Millis(20_000));
        (node.camera().photos().copied().collect::<Vec<_>>(), node.machine().program().state(), at)
    };
    assert_eq!((node(1).0.len(), node(1).1), (10, ProgramState::Stopped));
    assert_eq!(node(1), node(250));
    assert_eq!(node(1), node(20_000));
}

#[test]
fn a_new_address_is_used_on_the_usb_port_after_power_up() {
    let mut stage = stage(Setup::default());
    let other = Address(7);
    stage.ok(message::SetAddress { new_address: other });
    stage.ok(STATUS);
    stage.scene.reset();
    stage.pass(20);
    assert!(stage.ask(STATUS).is_unanswered());
    assert!(stage.ask_to(other, STATUS).is_done());
}
