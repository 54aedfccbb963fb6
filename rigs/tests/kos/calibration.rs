//! Ranges, and motion by hand.

use kos_proto::device::motor::State;
use kos_proto::host::{self, Get};
use kos_proto::message::{Motor, Rotations, RotationsPerSecond, RotationsPerSecondSquared};
use rigs::kos_device::Setup;
use rigs::kos_host::{Answer, Command, Event};

use crate::bench::{Bench, M1, M2, RANGES, TOLERANCE, go};

fn jog(speed: f32) -> host::Command {
    host::Command::Jog { motor: M1, speed: RotationsPerSecond(speed), acceleration: RotationsPerSecondSquared(100.0) }
}

#[test]
fn a_range_is_marked_by_jogs_and_bumps() {
    let mut bench = Bench::ready(Setup::with_motors(2));
    bench.send(host::Command::ResetAxis(M1));
    bench.told(|event| *event == host::Event::Motors);
    bench.send(jog(-20.0));
    for _ in 0..5 {
        bench.pass(400);
        bench.send(host::Command::Alive);
    }
    bench.send(host::Command::StopMotor(M1));
    bench.told(|event| matches!(event, host::Event::MotorRests(M1, _)));
    let begin = bench.at(M1);
    // Two seconds, less the way to speed up, and as much to slow down.
    assert!((-41.0..-38.0).contains(&begin), "{begin}");
    bench.send(host::Command::MarkBegin(M1));
    bench.bump(M1, 30.0);
    bench.bump(M1, 10.0);
    bench.send(host::Command::MarkEnd(M1));
    bench.told(|event| *event == host::Event::Calibrated(M1));
    let range = bench.scene.host.motor(M1).and_then(Motor::range).unwrap();
    assert!((f64::from(range.0) - 40.0).abs() < TOLERANCE, "{range}");
    // Commands count from the begin, and stay within.
    for (to, expected) in [(10.0, 10.0), (55.0, 40.0), (-3.0, 0.0)] {
        bench.send(host::Command::MoveTo(go(M1, to)));
        bench.told(|event| matches!(event, host::Event::MotorRests(M1, _)));
        assert!((bench.at(M1) - begin - expected).abs() < TOLERANCE, "{to}");
    }
}

#[test]
fn what_is_asked_is_answered_with_what_is() {
    let mut bench = Bench::calibrated();
    let mut answers = Vec::new();
    for get in Get::ALL {
        bench.scene.command(Command::Ask(get));
        answers.push(bench.wait(|event| if let Event::Answer(answer) = event { Some(answer.clone()) } else { None }));
    }
    let [Answer::Network(_), Answer::Lamps(..), Answer::Motors(motors), Answer::Device(device), rest @ ..] =
        &answers[..]
    else {
        panic!("{answers:#?}");
    };
    assert_eq!(rest.len(), 3);
    assert!(matches!(rest, [Answer::Move(None), Answer::Guid(guid), Answer::Platform(0)] if guid.len() == 16));
    assert_eq!(device.firmware.to_string(), "1.0.1.16");
    for (motor, range) in motors.iter().zip(RANGES) {
        assert!((f64::from(motor.range().unwrap().0) - range).abs() < TOLERANCE, "{motor:?}");
        assert!((f64::from(motor.position.0) - range).abs() < TOLERANCE, "{motor:?}");
    }
}

#[test]
fn an_old_device_and_one_that_keeps_its_count_are_understood() {
    for quirk in ["older-dialect", "begin-nonzero", "empty-password,push-address,no-progress"] {
        let setup = Setup::with_motors(2).with_quirks(quirk).unwrap();
        let mut bench = Bench::ready(setup);
        bench.bump(M1, 5.0);
        bench.calibrate(M1, 30.0);
        let motor = bench.scene.host.motor(M1).unwrap();
        assert!((f64::from(motor.range().unwrap().0) - 30.0).abs() < TOLERANCE, "{quirk}: {motor:?}");
        bench.send(host::Command::MoveTo(go(M1, 10.0)));
        bench.told(|event| matches!(event, host::Event::MotorRests(M1, _)));
        assert!((bench.at(M1) - 15.0).abs() < TOLERANCE, "{quirk}");
    }
}

#[test]
fn what_is_set_is_stored() {
    let mut bench = Bench::ready(Setup::with_motors(2));
    bench.send(host::Command::SetPlatform(7));
    bench.scene.command(Command::ChangePassword(b"gaffer".to_vec()));
    bench.pass(50);
    assert_eq!((bench.scene.rig.platform(), bench.scene.rig.password()), (7, &b"gaffer"[..]));
    // It outlives a reset; ranges do not.
    bench.calibrate(M2, -12.0);
    bench.scene.reset();
    bench.told(|event| matches!(event, host::Event::Ready { .. }));
    assert_eq!((bench.scene.rig.platform(), bench.scene.rig.password()), (7, &b"gaffer"[..]));
    assert_eq!(bench.scene.rig.machine().calibration(M2), Some(State::Uncalibrated));
    assert_eq!(bench.scene.host.machine().platform(), Some(7));
}

#[test]
fn who_jogs_and_falls_silent_stops_the_motor() {
    let mut bench = Bench::ready(Setup::with_motors(2));
    bench.send(jog(20.0));
    let begun = bench.now();
    bench.pass(900);
    assert!(!bench.rests());
    bench.told(|event| *event == host::Event::DeadMan);
    assert_eq!(bench.now() - begun, 1000);
    bench.told(|event| matches!(event, host::Event::MotorRests(M1, _)));
    let there = bench.at(M1);
    bench.pass(5000);
    assert_eq!((bench.at(M1).to_bits(), bench.rests()), (there.to_bits(), true));
    assert!((18.0..22.0).contains(&there), "{there}");
}

#[test]
fn where_a_motor_rests_is_told_where_it_is() {
    let mut bench = Bench::ready(Setup::with_motors(2));
    bench.bump(M2, -3.25);
    let told = bench.scene.host.motor(M2).unwrap().position;
    assert_eq!((told, bench.at(M2)), (Rotations(-3.25), -3.25));
}
