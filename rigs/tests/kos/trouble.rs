//! What goes wrong: passwords, ends of the travel, power, cables, stuck motors.

use kos_proto::device::motor::State;
use kos_proto::host::{self, Move, Refusal};
use kos_proto::message::{
    ErrorCode, MotorAddress, MotorPosition, Rotations, RotationsPerSecond, RotationsPerSecondSquared,
    SetPositionSpeedAcceleration,
};
use kos_proto::summary::Direction;
use kos_proto::trajectory::Loop;
use kos_proto::{DeviceMessage, HostMessage};
use motion_core::trajectory::Range;
use rigs::faults::Faults;
use rigs::kos_device::{MotorSetup, Setup};
use rigs::kos_host::{Command, Event, KosHost};
use rigs::{Rig as _, Side};

use crate::bench::{Bench, M1, M2, go, live, play};

#[test]
fn a_wrong_password_moves_nothing_but_stops() {
    let setup = Setup { password: b"gaffer".to_vec(), ..Setup::with_motors(2) };
    let mut bench = Bench::with(setup, host::Options::default(), Some(b"best boy"), Faults::NONE, 1);
    bench.scene.command(Command::Connect);
    bench.told(|event| *event == host::Event::Locked);
    bench.send(host::Command::Bump(go(M1, 5.0)));
    bench.told(|event| *event == host::Event::Refused(Refusal::NotReady));
    bench.stop();
    bench.scene.command(Command::Unlock(b"gaffer".to_vec()));
    bench.told(|event| matches!(event, host::Event::Ready { .. }));
    bench.bump(M1, 5.0);
    assert_eq!((bench.at(M1).to_bits(), bench.at(M2).to_bits()), (5.0_f64.to_bits(), 0));
}

/// Nobody stops a motor so gently that it does not stop.
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
    let stop = HostMessage::SetPositionSpeedAcceleration(stop);
    let mut bytes = vec![0; stop.encoded_len()];
    stop.encode_into(&mut bytes).unwrap();
    bench.scene.inject(Side::Host, &bytes);
    bench.pass(1100);
    assert!(bench.rests());
}

/// The range of the second motor, whose travel ends within it now.
fn short() -> Setup {
    let mut setup = Setup::with_motors(2);
    setup.motors[1] = MotorSetup { travel: Some(Range::new(-9.0, 1.0)), ..setup.motors[1] };
    setup
}

#[test]
fn an_end_of_the_travel_stops_a_motor_and_voids_its_range() {
    let mut bench = Bench::ready(short());
    bench.send(host::Command::Bump(go(M2, 4.0)));
    bench.told(|event| *event == host::Event::Error(ErrorCode::FAULT, M2));
    bench.told(|event| matches!(event, host::Event::MotorRests(M2, _)));
    assert_eq!((bench.at(M2).to_bits(), bench.rests()), (1.0_f64.to_bits(), true));
    assert_eq!(bench.scene.rig.machine().calibration(M2), Some(State::Uncalibrated));
    // Back it goes.
    bench.bump(M2, -4.0);
    assert_eq!(bench.at(M2).to_bits(), (-3.0_f64).to_bits());
}

#[test]
fn a_stuck_motor_and_a_lost_one_end_the_move_for_all() {
    let mut bench = Bench::calibrated();
    play(&mut bench, live(Loop::Once), Direction::Forward);
    bench.pass(1500);
    let now = bench.scene.now();
    bench.scene.rig.stall(now);
    bench.told(|event| *event == host::Event::Error(ErrorCode::RUNAWAY, M1));
    bench.told_move(Move::Finished { requested: false });
    // The other one is slowing down.
    assert!(!bench.rests() && bench.scene.host.may_move());
    bench.pass(1000);
    assert!(bench.rests());
    let calibration = |motor: MotorAddress| bench.scene.rig.machine().calibration(motor);
    assert_eq!([M1, M2].map(calibration), [Some(State::Uncalibrated), Some(State::Calibrated)]);
}

#[test]
fn a_motor_that_does_not_get_home_ends_the_move() {
    let mut setup = Setup::with_motors(2);
    setup.motors[1].profile.max_max_setup_speed.0 = 0.0;
    let mut bench = Bench::ready(setup).with_ranges();
    bench.scene.command(Command::PlayDirect { stored: live(Loop::Once), way: Direction::Forward });
    bench.told_move(Move::Failed(ErrorCode::RETURN_TO_FIRST_KEYFRAME));
    bench.told_move(Move::Finished { requested: true });
    assert!(bench.scene.host.may_move());
    bench.stop();
}

#[test]
fn a_curve_that_a_motor_cannot_follow_is_a_fault() {
    let mut setup = Setup::with_motors(2);
    setup.motors[0].profile.max_max_move_speed.0 = 9.0;
    setup.motors[0].profile.max_max_setup_speed.0 = 9.0;
    let mut bench = Bench::ready(setup).with_ranges();
    play(&mut bench, live(Loop::Once), Direction::Forward);
    bench.told(|event| *event == host::Event::Error(ErrorCode::PVT_INTEGRITY, M1));
    bench.told_move(Move::Finished { requested: false });
    bench.pass(1000);
    assert!(bench.rests());
}

#[test]
fn a_reset_in_the_middle_stops_everything_dead() {
    let mut bench = Bench::calibrated();
    play(&mut bench, live(Loop::Once), Direction::Forward);
    bench.pass(1500);
    let there = bench.at(M1);
    bench.scene.reset();
    assert!(bench.rests() && bench.scene.host.may_move());
    bench.told_move(Move::Lost);
    bench.told(|event| matches!(event, host::Event::Ready { .. }));
    // Nobody said that it rests, so a stop has to be asked for.
    assert!(bench.scene.host.may_move());
    bench.stop();
    assert_eq!(bench.at(M1).to_bits(), there.to_bits());
    assert!(bench.scene.rig.stored_move().is_none());
}

#[test]
fn a_cable_that_is_pulled_while_a_motor_is_jogged_stops_it() {
    let mut bench = Bench::ready(Setup::with_motors(2));
    bench.send(host::Command::Bump(go(M1, 1000.0)));
    bench.pass(700);
    assert!(!bench.rests());
    bench.scene.unplug();
    bench.pass(500);
    assert!(bench.rests() && bench.scene.host.may_move());
    bench.stop();
}

#[test]
fn a_move_of_somebody_else_is_stopped_only_if_it_is_meant() {
    let mut bench = Bench::calibrated();
    play(&mut bench, live(Loop::Once), Direction::Forward);
    bench.pass(500);
    bench.scene.unplug();
    bench.scene.host = KosHost::new(host::Options::default(), None);
    bench.connect();
    assert!(!bench.rests() && !bench.scene.host.may_move() && bench.scene.host.machine().moves());
    bench.scene.command(Command::Load { stored: live(Loop::Once), way: Direction::Forward, delay_return: false });
    bench.told(|event| *event == host::Event::Refused(Refusal::MoveRuns));
    assert!(!bench.rests() && !bench.scene.host.may_move());
    // A stop means everything, and is not over before everything rests.
    bench.stop();
}

#[test]
fn a_stop_without_a_line_is_the_first_thing_on_the_next_one() {
    let mut bench = Bench::calibrated();
    play(&mut bench, live(Loop::Once), Direction::Forward);
    bench.pass(500);
    bench.scene.unplug();
    bench.pass(100);
    bench.send(host::Command::Stop);
    bench.told(|event| *event == host::Event::StopNotConfirmed(None));
    assert!(!bench.rests());
    bench.wait(|event| (*event == Event::Stopped).then_some(()));
    assert!(bench.rests() && !bench.scene.host.may_move());
}

#[test]
fn a_stop_whose_line_breaks_behind_its_confirmation_is_sent_again() {
    let mut bench = Bench::calibrated();
    play(&mut bench, live(Loop::Once), Direction::Forward);
    bench.pass(1500);
    bench.send(host::Command::Stop);
    bench.told_move(Move::Finished { requested: true });
    assert!(!bench.rests());
    bench.scene.unplug();
    bench.wait(|event| (*event == Event::Stopped).then_some(()));
    assert!(bench.rests() && !bench.scene.host.may_move());
}

#[test]
fn what_rested_before_a_stop_does_not_count() {
    let mut bench = Bench::calibrated();
    play(&mut bench, live(Loop::Once), Direction::Forward);
    bench.pass(1500);
    // What the device said of both, before it heard of the stop.
    let mut late = Vec::new();
    for motor_address in [M1, M2] {
        let message =
            DeviceMessage::MotorPosition(MotorPosition { motor_address, position: Rotations(1.0), tail: &[] });
        let mut bytes = [0; 16];
        let len = message.encode_into(&mut bytes).unwrap();
        late.extend_from_slice(&bytes[..len]);
    }
    bench.scene.inject(Side::Rig, &late);
    bench.stop();
}

#[test]
fn the_device_starts_anew_when_it_is_told_to() {
    let mut bench = Bench::calibrated();
    bench.send(host::Command::ResetDevice);
    bench.told(|event| matches!(event, host::Event::Closed(_)));
    bench.told(|event| matches!(event, host::Event::Ready { .. }));
    assert_eq!(bench.scene.rig.machine().calibration(M1), Some(State::Uncalibrated));
}

#[test]
fn it_announces_itself_and_answers_questions() {
    use kos_proto::discovery::Datagram;
    use motion_core::time::Millis;
    use rigs::{LineId, Outgoing, Party as _};

    let address = [192, 168, 50, 9].into();
    let mut rig = rigs::kos_device::KosDevice::new(Setup { address, ..Setup::default() });
    let mut said = |now: u64, question: Option<bool>, open: bool| {
        match question {
            Some(limited) => {
                let mut bytes = [0; 7];
                Datagram::question(limited).encode_into(&mut bytes).unwrap();
                rig.datagram(Millis(now), &bytes);
            }
            None if open => rig.open(Millis(now), LineId(2)),
            None => rig.advance(Millis(now)),
        }
        let mut said = Vec::new();
        while let Some(outgoing) = rig.poll() {
            let (bytes, all) = match &outgoing {
                Outgoing::Announce(bytes) => (bytes, true),
                Outgoing::Answer(bytes) => (bytes, false),
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
    assert_eq!(said(60_000, None, false), [true; 4], "the client was silent for 30 s, and is gone");
}

/// What a device does next: the lines that it sends on, and those that it hangs up.
fn outgoing(rig: &mut rigs::kos_device::KosDevice) -> (Vec<u8>, Vec<u8>) {
    use rigs::{Outgoing, Party as _};
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
fn four_clients_are_told_and_a_fifth_is_turned_away() {
    use motion_core::time::Millis;
    use rigs::{LineId, Party as _};

    let mut rig = rigs::kos_device::KosDevice::new(Setup::default());
    for line in 0..5 {
        rig.open(Millis(1), LineId(line));
    }
    assert_eq!(outgoing(&mut rig), (vec![], vec![4]));
    // A stop, in two pieces: all are told that all is over.
    let stop = b"\x04\0\x07\0\x80\0\x06";
    rig.receive(Millis(2), LineId(1), &stop[..3]);
    assert_eq!(outgoing(&mut rig), (vec![], vec![]));
    rig.receive(Millis(2), LineId(1), &stop[3..]);
    let (told, gone) = outgoing(&mut rig);
    assert_eq!((&told[..4], gone), (&[0, 1, 2, 3][..], vec![]));
    // What is no stream of messages ends its own line only, and what comes behind it counts for nothing.
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
    // While it starts, nobody is let in.
    rig.open(Millis(7), LineId(0));
    assert_eq!(outgoing(&mut rig), (vec![], vec![0]));
    rig.open(Millis(600), LineId(0));
    assert_eq!(outgoing(&mut rig).1, [0; 0]);
}
