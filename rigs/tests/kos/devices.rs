//! Each device by name, from the first connection to a stop in a move: what a client can do with all of them.

use kos_proto::device::motor::State;
use kos_proto::host::{self, Outcome, Refusal, StopTarget};
use kos_proto::message::{ActionId, AxisKind, Motor, Rotations, RotationsPerSecond, RotationsPerSecondSquared};
use kos_proto::trajectory::{Limits, Loop};
use kos_proto::{HostMessage, MessageId};
use motion_rigs::device::Named;
use motion_rigs::faults::Faults;
use motion_rigs::kos_device::Setup;
use motion_rigs::kos_host::Event;

use crate::bench::{Bench, M1, M2, RANGES, go, live, play};

/// Devices that do not know a bump.
const WITHOUT_BUMP: [&str; 1] = ["cinedrive"];
/// Devices that ignore a locked client.
const DEAF_WHILE_LOCKED: [&str; 1] = ["printed"];

fn each(test: impl Fn(&str, Setup)) {
    for device in Setup::DEVICES {
        test(device.name, Setup::with_motors(2).with_device(device.name).unwrap());
    }
    let names: Vec<_> = Setup::DEVICES.iter().map(|device| device.name).collect();
    assert!(WITHOUT_BUMP.iter().chain(&DEAF_WHILE_LOCKED).all(|name| names.contains(name)));
}

/// Marks the ranges of both motors by jogs, as the document describes it.
fn mark_by_jogs(bench: &mut Bench) {
    for (index, motor) in [M1, M2].into_iter().enumerate() {
        bench.send(host::Command::ResetAxis(motor));
        bench.expect_event(|event| *event == host::Event::Motors);
        bench.send(host::Command::MarkBegin(motor));
        let speed = if RANGES[index] < 0.0 { -20.0 } else { 20.0 };
        bench.send(host::Command::Jog {
            motor,
            speed: RotationsPerSecond(speed),
            acceleration: RotationsPerSecondSquared(100.0),
        });
        bench.pass(900);
        bench.send(host::Command::StopMotor(motor));
        bench.expect_event(|event| *event == host::Event::Stopped(StopTarget::Motor(motor)));
        bench.done(host::Command::MarkEnd(motor));
        assert_eq!(bench.calibration(motor), Some(State::Calibrated));
    }
}

#[test]
fn each_device_is_driven_from_a_range_to_a_stop() {
    each(|name, setup| {
        let mut bench = Bench::ready(setup);
        let token = bench.send(host::Command::Bump(go(M1, 5.0)));
        let refusal =
            Refusal::Unsupported { id: MessageId::ACTION, action: Some(ActionId::BUMP_POSITION_SPEED_ACCELERATION) };
        let expected = if WITHOUT_BUMP.contains(&name) { Outcome::Refused(refusal) } else { Outcome::Done(None) };
        assert_eq!(bench.end(token), expected, "{name}");
        assert!(bench.rests() && !bench.may_move(), "{name}");
        mark_by_jogs(&mut bench);
        let motor = *bench.scene.host.motor(M1).unwrap();
        let range = motor.range().unwrap();
        assert!((15.0..20.0).contains(&range.0), "{name}: {motor:?}");
        bench.done(host::Command::MoveTo(go(M1, 2.0)));
        let at = bench.scene.host.motor(M1).and_then(Motor::relative_position);
        assert_eq!(at.map(|at| (at.0 - 2.0).abs() < 1e-4), Some(true), "{name}: {at:?}");
        play(&mut bench, live(Loop::Once));
        bench.pass(1500);
        assert!(!bench.rests());
        bench.stop();
        play(&mut bench, live(Loop::Once).reversed().unwrap());
        bench.expect_event(|event| *event == host::Event::Move(host::Move::Finished { requested: false }));
        assert!(bench.rests() && !bench.may_move(), "{name}");
        let at = bench.scene.host.motor(M1).and_then(Motor::relative_position).unwrap_or(Rotations(f32::NAN));
        assert!((at.0 / range.0 - 2.0 / 40.0).abs() < 1e-3, "{name}: {at}");
    });
}

/// A move that goes on without its client is stopped directly after the handshake on the next connection.
#[test]
fn each_device_is_stopped_as_soon_as_it_can_be() {
    each(|name, setup| {
        let setup = Setup { password: b"gaffer".to_vec(), ..setup };
        let mut bench = Bench::with(setup, host::Options::default(), Some(b"gaffer"), Faults::NONE, 1);
        bench.connect();
        mark_by_jogs(&mut bench);
        play(&mut bench, live(Loop::Once));
        bench.pass(500);
        bench.scene.unplug();
        bench.send(host::Command::Stop);
        let (begun, mut connected) = (bench.now(), None);
        while bench.plays() {
            if bench.scene.host.machine().state().is_connected() {
                connected.get_or_insert(bench.now());
            }
            bench.tick();
        }
        let (stopped, connected) = (bench.now(), connected.unwrap_or(bench.now()));
        assert!(stopped - connected <= 10, "{name}: {} ms", stopped - connected);
        assert!(stopped - begun < 3_000, "{name}: the move is not at its end");
        bench.expect_event(|event| *event == host::Event::Stopped(StopTarget::All));
        assert!(bench.rests() && !bench.may_move(), "{name}");
    });
}

/// With a wrong password, a device obeys the stop or ignores it. It does not report its motors, so the stop is not confirmed
/// either way, and the client tells that at once.
#[test]
fn each_device_with_a_wrong_password_obeys_a_stop_or_is_told_to_ignore_it() {
    each(|name, setup| {
        let setup = Setup { password: b"gaffer".to_vec(), ..setup };
        let mut bench = Bench::with(setup, host::Options::default(), Some(b"best boy"), Faults::NONE, 1);
        bench.send(host::Command::Stop);
        bench.command(motion_rigs::kos_host::Command::Connect);
        bench.expect_event(|event| *event == host::Event::Locked { wrong_password: true });
        let begun = bench.now();
        bench.expect_event(|event| *event == host::Event::StopNotConfirmed(StopTarget::All));
        assert!(bench.now() - begun < 10, "{name}");
        bench.pass(5_000);
        let obeyed = Event::Machine(host::Event::Move(host::Move::Finished { requested: true }));
        let events: Vec<_> = std::iter::from_fn(|| bench.event()).collect();
        assert_eq!(events.contains(&obeyed), !DEAF_WHILE_LOCKED.contains(&name), "{name}");
        assert!(!events.contains(&Event::Machine(host::Event::Stopped(StopTarget::All))) && bench.may_move(), "{name}");
    });
}

/// Limits as the document prints them do not get into stops and jogs: nothing exceeds the limits of the axis that a motor
/// turns, although no message says which that is.
#[test]
fn no_device_gets_more_than_the_document_allows() {
    let kinds = AxisKind::ALL;
    for device in Setup::DEVICES {
        let mut bench = Bench::ready(Setup::with_motors(kinds.len()).with_device(device.name).unwrap());
        let motors: Vec<_> = bench.scene.host.machine().motors().copied().collect();
        assert_eq!(motors.len(), kinds.len());
        for (motor, kind) in motors.iter().zip(kinds) {
            let most = Limits::from(kind);
            let (stop, jog) = (motor.stop(), motor.jog(RotationsPerSecond(1e3), RotationsPerSecondSquared(1e3)));
            for message in [stop, jog] {
                let keeps = message.speed.0 <= most.speed.0 && message.acceleration.0 <= most.acceleration.0;
                assert!(keeps, "{}: {kind:?} {message:?}", device.name);
                assert!(HostMessage::from(message).encoded_len() == 20);
            }
        }
        bench.stop();
    }
}
