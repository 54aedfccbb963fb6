//! Ranges, motion by hand, and questions.

use kos_proto::DeviceMessage;
use kos_proto::device::motor::State;
use kos_proto::host::{self, Get, Outcome, Refusal, StopTarget};
use kos_proto::message::{Motor, Rotations, RotationsPerSecond, RotationsPerSecondSquared, SoftwareID};
use motion_rigs::device::Named;
use motion_rigs::kos_device::Setup;
use motion_rigs::kos_host::{Command, Event, StoredMove};

use crate::bench::{Bench, M1, M2, RANGES, TOLERANCE, go};

fn jog(speed: f32) -> host::Command {
    host::Command::Jog { motor: M1, speed: RotationsPerSecond(speed), acceleration: RotationsPerSecondSquared(100.0) }
}

#[test]
fn a_range_is_marked_by_jogs_and_bumps() {
    let mut bench = Bench::ready(Setup::with_motors(2));
    bench.send(host::Command::ResetAxis(M1));
    bench.expect_event(|event| *event == host::Event::Motors);
    bench.send(jog(-20.0));
    for _ in 0..5 {
        bench.pass(400);
        bench.send(host::Command::Alive);
    }
    bench.send(host::Command::StopMotor(M1));
    bench.expect_event(|event| *event == host::Event::Stopped(StopTarget::Motor(M1)));
    let begin = bench.at(M1);
    // Two seconds at full speed, without the times of acceleration and deceleration.
    assert!((-41.0..-38.0).contains(&begin), "{begin}");
    bench.send(host::Command::MarkBegin(M1));
    bench.bump(M1, 30.0);
    bench.bump(M1, 10.0);
    bench.done(host::Command::MarkEnd(M1));
    let range = bench.scene.host.motor(M1).and_then(Motor::range).unwrap();
    assert!((f64::from(range.0) - 40.0).abs() < TOLERANCE, "{range}");
    // Commands count from the begin of the range, and the motor stays within its range.
    bench.done(host::Command::MoveTo(go(M1, 10.0)));
    assert!((bench.at(M1) - begin - 10.0).abs() < TOLERANCE);
    for to in [55.0, -3.0] {
        let token = bench.send(host::Command::MoveTo(go(M1, to)));
        assert_eq!(bench.end(token), Outcome::Refused(Refusal::Outside), "{to}");
    }
}

/// A jog of a motor with a range ends at the end of the range, also if the device would go on.
#[test]
fn a_jog_of_a_motor_with_a_range_ends_with_the_range() {
    for quirks in ["", "jog-not-clamped", "jog-not-clamped,begin-nonzero", "older-dialect"] {
        let setup = Setup::with_motors(2).with_quirks(quirks).unwrap();
        let mut bench = Bench::ready(setup);
        bench.bump(M1, 5.0);
        bench.calibrate(M1, 30.0);
        for (speed, end) in [(-20.0, 5.0), (20.0, 35.0)] {
            bench.send(jog(speed));
            for _ in 0..8 {
                bench.pass(500);
                bench.send(host::Command::Alive);
            }
            assert!((bench.at(M1) - end).abs() < TOLERANCE, "{quirks}: {speed}, {}", bench.at(M1));
            // The client cannot know whether the motor rests at the end of its range or was blocked, so it stops the motor.
            assert!(bench.may_move());
            bench.send(host::Command::StopMotor(M1));
            bench.expect_event(|event| *event == host::Event::Stopped(StopTarget::Motor(M1)));
            assert!(!bench.may_move());
        }
    }
}

#[test]
fn every_question_is_answered_with_the_state_of_the_device() {
    let mut bench = Bench::calibrated();
    let mut answers = Vec::new();
    for get in Get::ALL {
        let token = bench.send(host::Command::Get(get));
        answers.push(bench.wait(|event| match event {
            Event::Answer(answered, answer) if *answered == token => Some(answer.clone()),
            _ => None,
        }));
    }
    let [network, leds, motors, device, stored, guid, platform] = &answers[..] else { panic!("{answers:#?}") };
    assert!(matches!(network.message(), DeviceMessage::NetworkInfo(_)));
    assert!(matches!(leds.message(), DeviceMessage::LEDStatus(_)));
    assert!(matches!(motors.message(), DeviceMessage::MotorInfo(info) if !info.more));
    assert!(
        matches!(device.message(), DeviceMessage::DeviceInfo(info) if info.firmware_version.to_string() == "1.0.1.16")
    );
    assert!(matches!(stored.message(), DeviceMessage::TrajectoryData(data) if StoredMove::new(&data).is_err()));
    assert!(matches!(guid.message(), DeviceMessage::DeviceGUID(guid) if guid.guid.0.len() == 16));
    assert!(matches!(platform.message(), DeviceMessage::SoftwareID(SoftwareID { platform: 0, .. })));
    for (motor, range) in bench.scene.host.machine().motors().zip(RANGES) {
        assert!((f64::from(motor.range().unwrap().0) - range).abs() < TOLERANCE, "{motor:?}");
        assert!((f64::from(motor.position.0) - range).abs() < TOLERANCE, "{motor:?}");
    }
}

#[test]
fn devices_with_quirks_are_understood() {
    for quirk in ["older-dialect", "begin-nonzero", "empty-password,push-address,no-progress"] {
        let setup = Setup::with_motors(2).with_quirks(quirk).unwrap();
        let mut bench = Bench::ready(setup);
        bench.bump(M1, 5.0);
        bench.calibrate(M1, 30.0);
        let motor = bench.scene.host.motor(M1).unwrap();
        assert!((f64::from(motor.range().unwrap().0) - 30.0).abs() < TOLERANCE, "{quirk}: {motor:?}");
        bench.done(host::Command::MoveTo(go(M1, 10.0)));
        assert!((bench.at(M1) - 15.0).abs() < TOLERANCE, "{quirk}");
    }
}

#[test]
fn platform_and_password_are_stored() {
    let mut bench = Bench::ready(Setup::with_motors(2));
    bench.send(host::Command::SetPlatform(7));
    bench.command(Command::ChangePassword(b"gaffer".to_vec()));
    bench.pass(50);
    assert_eq!((bench.scene.rig.platform(), bench.scene.rig.password()), (7, &b"gaffer"[..]));
    // Both stay after a reset, and ranges do not.
    bench.calibrate(M2, -12.0);
    bench.scene.reset();
    bench.expect_event(|event| matches!(event, host::Event::Ready { .. }));
    assert_eq!((bench.scene.rig.platform(), bench.scene.rig.password()), (7, &b"gaffer"[..]));
    assert_eq!(bench.calibration(M2), Some(State::Uncalibrated));
    assert_eq!(bench.scene.host.machine().platform(), Some(7));
}

#[test]
fn a_jog_stops_if_the_application_gives_no_command_for_a_second() {
    let mut bench = Bench::ready(Setup::with_motors(2));
    bench.send(jog(20.0));
    let begun = bench.now();
    bench.pass(900);
    assert!(!bench.rests());
    bench.expect_event(|event| *event == host::Event::DeadMan);
    assert_eq!(bench.now() - begun, 1000);
    bench.expect_event(|event| *event == host::Event::Stopped(StopTarget::Motor(M1)));
    let there = bench.at(M1);
    bench.pass(5000);
    assert_eq!((bench.at(M1).to_bits(), bench.rests()), (there.to_bits(), true));
    assert!((18.0..22.0).contains(&there), "{there}");
}

#[test]
fn the_position_of_a_motor_at_rest_is_reported() {
    let mut bench = Bench::ready(Setup::with_motors(2));
    bench.bump(M2, -3.25);
    let told = bench.scene.host.motor(M2).unwrap().position;
    assert_eq!((told, bench.at(M2)), (Rotations(-3.25), -3.25));
}
