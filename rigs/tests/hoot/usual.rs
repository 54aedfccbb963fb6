//! What is done every day: ask, move, jog, stop.

use hoot_proto::device::{MotorState, ProgramState};
use hoot_proto::frame::MAX_FRAME;
use hoot_proto::host::{self, Command};
use hoot_proto::message::{
    self, CoreDeviceId, Easing, FirmwareVersion, Microstep, Milliseconds, Motor, NameQuery, ProgramMode, Span,
    StepsPerSecond,
};
use hoot_proto::program::Plan;
use hoot_proto::query::{AnyReply, Profile};
use hoot_proto::{Address, HostMessage};
use motion_core::profile::{self, Limits};
use motion_core::time::Millis;
use motion_core::wire::Bool;
use rigs::hoot_node::{HootNode, Setup};
use rigs::{LineId, Party as _};

use crate::world::{
    EXPOSING, NODE, ONE, START, STATUS, STOP, dead_man, joystick, mode, motor_stop, move_by, photos, planned, ready,
    run, set_speed, smooth, stage,
};

#[test]
fn a_node_says_what_it_is() {
    let mut stage = stage(Setup::default());
    let version = stage.ok(HostMessage::FirmwareVersion(FirmwareVersion {}));
    assert_eq!(version.read(&FirmwareVersion {}), Some(message::Version(6)));
    assert_eq!(stage.scene.host.profile(NODE), Profile::Sheet);
    let name = stage.ok(HostMessage::Name(NameQuery {}));
    let Some(AnyReply::Name(name)) = name.answer() else { panic!("{name}") };
    assert_eq!(name.value.0, b"DEFAULT   ");
    let id = stage.ok(HostMessage::CoreDeviceId(CoreDeviceId::default()));
    assert!(matches!(id.answer(), Some(AnyReply::CoreDeviceId(id)) if id.value.0 == b"OMAXISVX"), "{id}");
    assert_eq!(stage.position(Motor::Three), 0);
    assert!(stage.ok(STATUS).answer().is_some());
}

/// At every tick the motor is where the trapezoid of its speed and acceleration is; what the master is told is the step
/// nearest to where it was.
#[test]
fn a_move_goes_along_its_profile() {
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
        assert!(stage.scene.host.may_move());
        stage.tick();
        ticks += 1;
    }
    assert!((f64::from(ticks) / 1000.0 - planned.duration()).abs() < 0.002, "{ticks} ms");
    assert_eq!(stage.position(ONE), 4000);
    assert!(stage.scene.host.may_move(), "nobody has asked whether it moves");
    assert!(!stage.is_running(ONE));
    assert!(!stage.scene.host.may_move());
}

/// Directions count up and down, and the other way round when the motor was told so.
#[test]
fn directions_and_microsteps() {
    let mut stage = stage(Setup::default());
    stage.enable(ONE, 4000.0);
    let turn = message::MotorSetDirection { motor: ONE, direction: message::Direction(1) };
    for (message, to) in
        [(move_by(ONE, 100), 100), (move_by(ONE, -300), -200), (HostMessage::MotorSetDirection(turn), -200)]
    {
        stage.ok(message);
        stage.pass(1000);
        assert_eq!(stage.position(ONE), to);
    }
    stage.ok(move_by(ONE, 100));
    stage.pass(1000);
    assert_eq!(stage.position(ONE), -300);

    let microstep = |microstep| HostMessage::MotorSetMicrostep(message::MotorSetMicrostep { motor: ONE, microstep });
    stage.ok(microstep(Microstep::SIXTEENTH));
    assert_eq!(stage.position(ONE), -1200);
    let motor = &stage.scene.rig;
    let travel = rigs::Rig::motors(motor)[0].travel().unwrap();
    assert!((travel.to - 800_000.0).abs() < 1e-6, "the rig is as long as before");
    stage.ok(HostMessage::MotorSetHomeHere(message::MotorSetHomeHere { motor: ONE }));
    assert_eq!(stage.position(ONE), 0);
    let travel = rigs::Rig::motors(&stage.scene.rig)[0].travel().unwrap();
    assert!((travel.to - 801_200.0).abs() < 1e-6, "its end is where it was");
}

/// With a joystick: speeds many times a second, a node that is kept alive, and a stop by speed 0.
#[test]
fn a_joystick_runs_a_motor() {
    let mut stage = stage(Setup::default());
    stage.enable(ONE, 0.0);
    stage.ok(dead_man(Bool::TRUE));
    stage.ok(joystick(Bool::TRUE));
    stage.scene.command(Command::KeepAlive { to: NODE, on: true });
    stage.ok(run(ONE));
    for speed in [500.0, 1000.0, 2000.0, -2000.0] {
        stage.scene.command(Command::Speed { to: NODE, motor: ONE, speed: StepsPerSecond(speed) });
        stage.pass(1500);
        let velocity = rigs::Rig::motors(&stage.scene.rig)[0].at(stage.scene.now()).velocity;
        assert!((velocity - f64::from(speed)).abs() < 1.0, "{velocity} instead of {speed}");
        assert!(stage.scene.host.may_move());
    }
    stage.scene.command(Command::Speed { to: NODE, motor: ONE, speed: StepsPerSecond(0.0) });
    stage.pass(1500);
    assert!(stage.is_at_rest());
    assert_eq!(stage.scene.rig.machine().motor(ONE).state(), MotorState::Continuous, "it runs at speed 0");
    stage.ok(motor_stop(ONE));
    assert!(!stage.scene.host.may_move() && stage.told.is_empty(), "{:?}", stage.told);
}

/// Joystick mode leaves the node little, and always its stops.
#[test]
fn joystick_mode_is_a_gate() {
    let mut stage = stage(Setup::default());
    stage.enable(ONE, 1000.0);
    stage.ok(joystick(Bool::TRUE));
    let refused = stage.ask(STATUS);
    assert!(matches!(refused.outcome, host::Outcome::Refused(_)), "{refused}");
    stage.ok(run(ONE));
    stage.pass(300);
    assert!(!stage.is_at_rest());
    stage.ok(STOP);
    assert!(stage.is_at_rest() && !stage.scene.host.may_move());
    stage.ok(joystick(Bool::FALSE));
    stage.ok(STATUS);
}

/// The master falls silent: the dead-man stops the motors after a second, and not before.
#[test]
fn a_silent_master_stops_what_runs() {
    let mut stage = stage(Setup::default());
    stage.enable(ONE, 1000.0);
    stage.ok(dead_man(Bool::TRUE));
    let before = stage.now();
    stage.ok(run(ONE));
    stage.until(2000, |stage| stage.is_at_rest());
    let took = stage.now() - before;
    assert!((1000..=1300).contains(&took), "{took} ms");
    assert!(!stage.is_running(ONE));
}

#[test]
fn stops_stop_at_once() {
    let mut stage = stage(Setup::default());
    for stop in [STOP, motor_stop(ONE)] {
        stage.enable(ONE, 4000.0);
        stage.ok(run(ONE));
        stage.pass(500);
        assert!(!stage.is_at_rest());
        let before = stage.now();
        stage.ok(stop);
        assert!(stage.is_at_rest() && stage.now() - before < 200);
    }
}

/// An emergency stop stops each motor, and is confirmed when all rest; in joystick mode of firmware too.
#[test]
fn an_emergency_stop_is_confirmed() {
    let firmware = hoot_proto::device::Options::default().with_quirks(hoot_proto::device::Quirks::FIRMWARE);
    for device in [hoot_proto::device::Options::default(), firmware] {
        for stick in [Bool::FALSE, Bool::TRUE] {
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
            assert!(stage.is_at_rest() && !stage.scene.host.may_move());
            assert!(stage.now() - before < 3000, "{} ms", stage.now() - before);
        }
    }
}

/// A photo has the time of its exposure, and one at a time is taken.
#[test]
fn the_camera_takes_a_photo() {
    let mut stage = stage(Setup::default());
    for message in photos(0, 250, 1000) {
        stage.ok(message);
    }
    let expose = HostMessage::CameraExpose(message::CameraExpose {});
    stage.ok(expose);
    assert!(stage.scene.rig.camera().is_open());
    let query = message::CameraExposing {};
    assert_eq!(stage.ok(EXPOSING).read(&query), Some(Bool::TRUE));
    stage.ok(expose);
    stage.pass(500);
    assert_eq!(stage.ok(EXPOSING).read(&query), Some(Bool::FALSE));
    let photos: Vec<_> = stage.scene.rig.camera().photos().map(|photo| photo.closed.since(photo.opened)).collect();
    assert_eq!((stage.scene.rig.camera().taken(), photos), (1, vec![250]));
}

/// What a node acknowledges and ignores: the OK is worth nothing, the question is.
#[test]
fn a_speed_beyond_the_greatest_is_ignored() {
    let mut stage = stage(Setup::default());
    stage.enable(ONE, 1000.0);
    stage.ok(set_speed(ONE, 9000.0));
    let query = message::MotorContinuousSpeed { motor: ONE };
    let speed = stage.ok(HostMessage::MotorContinuousSpeed(query)).read(&query).unwrap();
    assert!((speed.0.to_f64() - 1000.0).abs() < 0.01, "{speed}");
    assert_eq!(stage.ok(HostMessage::CameraInterval(message::CameraInterval {})).answer().map(|it| it.to_string()), {
        Some(Milliseconds(0).to_string())
    });
}

/// A clock that is looked at seldom changes nothing: what was due comes one after the other.
#[test]
fn seldom_or_often_is_the_same() {
    let plan =
        Plan { travel: Span(9), acceleration: Span(3), deceleration: Span(3), easing: Easing::LINEAR, ..smooth() };
    let node = |every: u64| {
        let mut node = HootNode::new(Setup::default());
        node.open(Millis(0), LineId(0));
        let program = planned(ONE, 0, plan).into_iter().chain(photos(10, 100, 500));
        for message in ready(ONE, 1000.0).into_iter().chain(program).chain([mode(ProgramMode::SMS), START]) {
            let mut packet = [0; MAX_FRAME];
            let len = message.encode_into(NODE, &mut packet).unwrap();
            node.receive(Millis(0), LineId(0), &packet[..len]);
        }
        (1..=20_000 / every).for_each(|count| node.advance(Millis(count * every)));
        let at = rigs::Rig::motors(&node)[0].at(Millis(20_000));
        (node.camera().photos().copied().collect::<Vec<_>>(), node.machine().program().state(), at)
    };
    assert_eq!((node(1).0.len(), node(1).1), (10, ProgramState::Stopped));
    assert_eq!(node(1), node(250));
    assert_eq!(node(1), node(20_000));
}

/// A node takes another address at once on the bus, and by USB when the power has been off.
#[test]
fn a_new_address_counts_by_usb_after_power_up() {
    let mut stage = stage(Setup::default());
    let other = Address(7);
    stage.ok(HostMessage::SetAddress(message::SetAddress { new_address: other }));
    stage.ok(STATUS);
    stage.scene.reset();
    stage.pass(20);
    assert!(stage.ask(STATUS).is_silence());
    assert!(stage.ask_to(other, STATUS).is_done());
}
