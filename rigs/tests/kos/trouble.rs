//! Trouble: passwords, ends of the travel, power cuts, pulled cables, stuck motors.

use kos_proto::device::motor::State;
use kos_proto::host::{self, Failure, Move, Outcome, Refusal, StopTarget};
use kos_proto::message::{
    ErrorCode, MotorPosition, Rotations, RotationsPerSecond, RotationsPerSecondSquared, SetPositionSpeedAcceleration,
};
use kos_proto::trajectory::Loop;
use kos_proto::{DeviceMessage, HostMessage};
use motion_core::trajectory::Range;
use motion_rigs::faults::Faults;
use motion_rigs::kos_device::{MotorSetup, Setup};
use motion_rigs::kos_host::{Command, KosHost};
use motion_rigs::{Rig as _, Side};

use crate::bench::{Bench, M1, M2, go, live, play};

#[test]
fn a_device_with_a_password_moves_nothing_before_it_but_can_be_stopped() {
    let setup = Setup { password: b"gaffer".to_vec(), ..Setup::with_motors(2) };
    let mut bench = Bench::with(setup, host::Options::default(), Some(b"best boy"), Faults::NONE, 1);
    bench.command(Command::Connect);
    bench.expect_event(|event| *event == host::Event::Locked { wrong_password: true });
    let bump = bench.send(host::Command::Bump(go(M1, 5.0)));
    assert_eq!(bench.end(bump), Outcome::Refused(Refusal::NotReady));
    bench.send(host::Command::Stop);
    bench.expect_move(Move::Finished { requested: true });
    bench.command(Command::Unlock(b"gaffer".to_vec()));
    bench.expect_event(|event| *event == host::Event::Stopped(StopTarget::All));
    bench.expect_event(|event| matches!(event, host::Event::Ready { .. }));
    bench.bump(M1, 5.0);
    assert_eq!((bench.at(M1).to_bits(), bench.at(M2).to_bits()), (5.0_f64.to_bits(), 0));
}

/// A motor stops within a second, however small the acceleration of the stop is.
#[test]
fn a_gentle_stop_is_a_stop() {
    let mut bench = Bench::ready(Setup::with_motors(2));
    bench.send(host::Command::Bump(go(M1, 1000.0)));
    bench.pass(2000);
    assert!(!bench.rests());
    let stop = SetPositionSpeedAcceleration {
        motor_address: M1,
        position: Rotations(0.0),
        speed: RotationsPerSecond(0.0),
        acceleration: RotationsPerSecondSquared(1e-6),
        tail: &[],
    };
    let stop = HostMessage::from(stop);
    let mut bytes = vec![0; stop.encoded_len()];
    stop.encode_into(&mut bytes).unwrap();
    bench.scene.inject(Side::Host, &bytes);
    bench.pass(1100);
    assert!(bench.rests());
}

/// Two motors, of which the second one has a travel that ends within its range.
fn short() -> Setup {
    let mut setup = Setup::with_motors(2);
    setup.motors[1] = MotorSetup { travel: Some(Range::new(-9.0, 1.0)), ..setup.motors[1] };
    setup
}

#[test]
fn an_end_of_the_travel_stops_a_motor_and_voids_its_range() {
    let mut bench = Bench::ready(short());
    let bump = bench.send(host::Command::Bump(go(M2, 4.0)));
    bench.expect_event(|event| *event == host::Event::Error(ErrorCode::FAULT, M2));
    assert_eq!(bench.end(bump), Outcome::Failed(Failure::Device(ErrorCode::FAULT)));
    bench.expect_event(|event| matches!(event, host::Event::MotorRests(M2, _)));
    assert_eq!((bench.at(M2).to_bits(), bench.rests()), (1.0_f64.to_bits(), true));
    assert_eq!(bench.calibration(M2), Some(State::Uncalibrated));
    // The way back is free.
    bench.bump(M2, -4.0);
    assert_eq!(bench.at(M2).to_bits(), (-3.0_f64).to_bits());
}

#[test]
fn a_stuck_motor_ends_the_move_of_all_motors() {
    let mut bench = Bench::calibrated();
    play(&mut bench, live(Loop::Once));
    bench.pass(1500);
    let now = bench.scene.now();
    bench.scene.rig.stall(now);
    bench.expect_event(|event| *event == host::Event::Error(ErrorCode::RUNAWAY, M1));
    bench.expect_move(Move::Finished { requested: false });
    // The other motor is slowing down.
    assert!(!bench.rests() && bench.may_move());
    bench.pass(1000);
    assert!(bench.rests());
    assert_eq!([M1, M2].map(|motor| bench.calibration(motor)), [Some(State::Uncalibrated), Some(State::Calibrated)]);
}

#[test]
fn a_motor_that_does_not_get_to_where_the_move_begins_ends_the_move() {
    let mut setup = Setup::with_motors(2);
    setup.motors[1].specs.max_max_setup_speed.0 = 0.0;
    let mut bench = Bench::ready(setup).with_ranges();
    let play = bench.command(Command::PlayDirect { stored: live(Loop::Once) });
    bench.expect_move(Move::Failed(ErrorCode::RETURN_TO_FIRST_KEYFRAME));
    assert_eq!(bench.end(play), Outcome::Refused(Refusal::Device(ErrorCode::RETURN_TO_FIRST_KEYFRAME)));
    bench.expect_move(Move::Finished { requested: true });
    assert!(bench.may_move());
    bench.stop();
}

#[test]
fn a_curve_that_a_motor_cannot_follow_is_a_fault() {
    let mut setup = Setup::with_motors(2);
    setup.motors[0].specs.max_max_move_speed.0 = 9.0;
    setup.motors[0].specs.max_max_setup_speed.0 = 9.0;
    let mut bench = Bench::ready(setup).with_ranges();
    play(&mut bench, live(Loop::Once));
    bench.expect_event(|event| *event == host::Event::Error(ErrorCode::PVT_INTEGRITY, M1));
    bench.expect_move(Move::Finished { requested: false });
    bench.pass(1000);
    assert!(bench.rests());
}

#[test]
fn a_power_cut_in_a_move_stops_everything_at_once() {
    let mut bench = Bench::calibrated();
    play(&mut bench, live(Loop::Once));
    bench.pass(1500);
    let there = bench.at(M1);
    bench.scene.reset();
    assert!(bench.rests() && bench.may_move());
    bench.expect_move(Move::Lost);
    bench.expect_event(|event| matches!(event, host::Event::Ready { .. }));
    // The device did not report that the motors rest: only a confirmed stop shows it.
    assert!(bench.may_move());
    bench.stop();
    assert_eq!(bench.at(M1).to_bits(), there.to_bits());
    assert!(bench.scene.rig.stored_move().is_none());
}

#[test]
fn a_motor_that_is_moved_by_hand_stops_when_the_cable_is_pulled() {
    let mut bench = Bench::ready(Setup::with_motors(2));
    bench.send(host::Command::Bump(go(M1, 1000.0)));
    bench.pass(700);
    assert!(!bench.rests());
    bench.scene.unplug();
    bench.pass(500);
    assert!(bench.rests() && bench.may_move());
    bench.stop();
}

#[test]
fn a_move_of_another_client_is_stopped_only_by_a_stop() {
    let mut bench = Bench::calibrated();
    play(&mut bench, live(Loop::Once));
    bench.pass(500);
    bench.scene.unplug();
    bench.scene.host = KosHost::new(host::Options::default(), None);
    bench.connect();
    assert!(!bench.rests() && !bench.may_move() && bench.scene.host.machine().move_state().moves());
    let load = bench.command(Command::Load { stored: live(Loop::Once), delay_return: false });
    assert_eq!(bench.end(load), Outcome::Refused(Refusal::MoveRuns));
    assert!(!bench.rests() && !bench.may_move());
    // A stop is about everything, and it is confirmed when everything rests.
    bench.stop();
}

#[test]
fn a_stop_without_a_connection_is_sent_first_on_the_next_one() {
    let mut bench = Bench::calibrated();
    play(&mut bench, live(Loop::Once));
    bench.pass(500);
    bench.scene.unplug();
    bench.pass(100);
    bench.send(host::Command::Stop);
    bench.expect_event(|event| *event == host::Event::StopNotConfirmed(StopTarget::All));
    assert!(!bench.rests());
    bench.expect_event(|event| *event == host::Event::Stopped(StopTarget::All));
    assert!(bench.rests() && !bench.may_move());
}

#[test]
fn a_stop_is_sent_again_if_the_connection_is_lost_before_all_motors_rest() {
    let mut bench = Bench::calibrated();
    play(&mut bench, live(Loop::Once));
    bench.pass(1500);
    bench.send(host::Command::Stop);
    bench.expect_move(Move::Finished { requested: true });
    assert!(!bench.rests());
    bench.scene.unplug();
    bench.expect_event(|event| *event == host::Event::Stopped(StopTarget::All));
    assert!(bench.rests() && !bench.may_move());
}

#[test]
fn a_report_of_rest_from_before_a_stop_does_not_confirm_it() {
    let mut bench = Bench::calibrated();
    play(&mut bench, live(Loop::Once));
    bench.pass(1500);
    // Reports of both motors that the device sent before the stop arrived.
    let mut late = Vec::new();
    for motor_address in [M1, M2] {
        let message = DeviceMessage::from(MotorPosition { motor_address, position: Rotations(1.0), tail: &[] });
        let mut bytes = [0; 16];
        let len = message.encode_into(&mut bytes).unwrap();
        late.extend_from_slice(&bytes[..len]);
    }
    bench.scene.inject(Side::Rig, &late);
    bench.stop();
}

#[test]
fn a_device_can_be_reset() {
    let mut bench = Bench::calibrated();
    bench.send(host::Command::ResetDevice);
    bench.expect_event(|event| matches!(event, host::Event::LinkDown(_)));
    bench.expect_event(|event| matches!(event, host::Event::Ready { .. }));
    assert_eq!(bench.calibration(M1), Some(State::Uncalibrated));
}

#[test]
fn a_device_announces_itself_and_answers_questions() {
    use kos_proto::discovery::Datagram;
    use motion_core::time::Millis;
    use motion_rigs::{LineId, Outgoing, Party as _};

    let address = [192, 168, 50, 9].into();
    let asker = "192.168.50.7:4000".parse().unwrap();
    let mut rig = motion_rigs::kos_device::KosDevice::new(Setup { address, ..Setup::default() });
    let mut said = |now: u64, question: Option<bool>, open: bool| {
        match question {
            Some(limited) => {
                let mut bytes = [0; 7];
                Datagram::question(limited).encode_into(&mut bytes).unwrap();
                rig.datagram(Millis(now), asker, &bytes);
            }
            None if open => rig.open(Millis(now), LineId(2)),
            None => rig.advance(Millis(now)),
        }
        let mut said = Vec::new();
        while let Some(outgoing) = rig.poll() {
            let (bytes, all) = match &outgoing {
                Outgoing::Announce(bytes) => (bytes, true),
                Outgoing::Datagram(to, bytes) if *to == asker => (bytes, false),
                Outgoing::HangUp(LineId(2)) => continue,
                outgoing => panic!("{outgoing:?}"),
            };
            let Ok(Datagram::Announcement(info)) = Datagram::decode(bytes) else { panic!("{bytes:?}") };
            assert_eq!(info.ip_address, address.into());
            said.push(all);
        }
        said
    };
    assert_eq!(said(0, None, false), [true]);
    assert_eq!(said(4999, None, false), [true; 0]);
    assert_eq!(said(5000, None, false), [true]);
    assert_eq!((said(5001, Some(true), false), said(5001, Some(false), false)), (vec![true], vec![false]));
    assert_eq!(said(5002, None, true), [true; 0]);
    assert_eq!(said(60_000, None, false), [true; 4], "the client was silent for 30 s, and its connection is closed");
}

/// Lines on which a device sends next, and lines that it closes.
fn outgoing(rig: &mut motion_rigs::kos_device::KosDevice) -> (Vec<u8>, Vec<u8>) {
    use motion_rigs::{Outgoing, Party as _};
    let (mut told, mut gone) = (Vec::new(), Vec::new());
    while let Some(outgoing) = rig.poll() {
        match outgoing {
            Outgoing::Bytes(line, _) => told.push(line.0),
            Outgoing::HangUp(line) => gone.push(line.0),
            _ => {}
        }
    }
    told.dedup();
    (told, gone)
}

#[test]
fn four_clients_can_connect_and_each_is_told_of_a_stop() {
    use motion_core::time::Millis;
    use motion_rigs::{LineId, Party as _};

    let mut rig = motion_rigs::kos_device::KosDevice::new(Setup::default());
    for line in 0..5 {
        rig.open(Millis(1), LineId(line));
    }
    assert_eq!(outgoing(&mut rig), (vec![], vec![4]));
    // A stop in two pieces: all clients are told that the move is over.
    let stop = b"\x04\0\x07\0\x80\0\x06";
    rig.receive(Millis(2), LineId(1), &stop[..3]);
    assert_eq!(outgoing(&mut rig), (vec![], vec![]));
    rig.receive(Millis(2), LineId(1), &stop[3..]);
    let (told, gone) = outgoing(&mut rig);
    assert_eq!((&told[..4], gone), (&[0, 1, 2, 3][..], vec![]));
    // Bytes that are no stream of messages end their own connection only, and the bytes after them are ignored.
    rig.receive(Millis(3), LineId(2), b"GET / HTTP/1.1\r\n\x04\0\x07\0\x80\0\x06");
    assert_eq!(outgoing(&mut rig), (vec![], vec![2]));
    rig.receive(Millis(3), LineId(2), stop);
    rig.receive(Millis(3), LineId(9), stop);
    assert_eq!(outgoing(&mut rig), (vec![], vec![]));
    rig.receive(Millis(4), LineId(0), stop);
    assert_eq!(outgoing(&mut rig).0[..3], [0, 1, 3]);
    rig.open(Millis(5), LineId(2));
    rig.reset(Millis(6));
    assert_eq!(outgoing(&mut rig), (vec![], vec![0, 1, 2, 3]));
    assert_eq!(rig.held(), 0);
    // No client can connect while the device starts.
    rig.open(Millis(7), LineId(0));
    assert_eq!(outgoing(&mut rig), (vec![], vec![0]));
    rig.open(Millis(600), LineId(0));
    assert_eq!(outgoing(&mut rig).1, [0; 0]);
}
