//! Steps with the most effects that are known. `laws::machine::step` checks that no effect is lost.

use kos_proto::HostMessage;
use kos_proto::Transport;
use kos_proto::device::{self, SessionId};
use kos_proto::host::{Command, Endpoint, Event, Failure, Get, Options, Outcome, Transmit};
use kos_proto::message::*;

use super::bench::*;
use super::client::*;

fn ten() -> device::Options {
    device::Options::default().with_motors(MotorSet::of((1..=10).map(MotorAddress)))
}

/// Ten motors are reported while a move ends and the device announces itself.
#[test]
fn a_step_has_room_for_ten_motors_while_a_move_ends() {
    let mut bench = Bench::off(ten());
    bench.rig(device::Report::Started);
    bench.open(ZERO, Transport::Usb);
    for motor in 1..=10 {
        bench.calibrate(motor);
    }
    bench.receive(HostMessage::from(live_move(live())));
    bench.receive(start());
    bench.home();
    // The move takes ten seconds, and an announcement is due every five seconds.
    bench.pass(9_000);
    bench.clear();
    bench.now += 2_000;
    bench.receive(GetMotorInfo::default());
    assert_eq!(bench.messages().len(), 10 + 1 + 2);
}

/// Ten motors stop because four clients are lost at the same time.
#[test]
fn a_step_has_room_for_four_clients_that_are_gone_at_once() {
    let mut bench = Bench::off(ten());
    bench.rig(device::Report::Started);
    for session in SessionId::ALL {
        bench.open(session, Transport::Tcp);
    }
    for motor in 1..=10 {
        bench.from(SessionId(motor % 4), set_psa(motor, 25_000.0, 5.0));
    }
    bench.clear();
    bench.now += 30_000;
    bench.step(device::Input::Wake);
    assert_eq!(bench.events().len(), 4 + 10);
}

/// Ten motors, seven queries, a move and a range are all late while motors come and go.
#[test]
fn a_step_has_room_for_everything_that_is_late_at_once() {
    let mut client = Client::connected(Options::default(), Endpoint::Usb);
    client.receive(device_info(PlaybackState::NO_MOVE));
    for motor in 1..=10 {
        client.motor(motor, 0.0, 0.0, motor < 10);
    }
    client.receive(guid(&GUID));
    client.receive(software(4));
    assert_eq!(client.state(), "Ready");

    client.command(Command::MarkBegin(MotorAddress(10)));
    for get in Get::ALL {
        client.command(Command::Get(get));
    }
    client.command(Command::MarkEnd(MotorAddress(10)));
    for motor in 1..=10 {
        client.command(jog(MotorAddress(motor), 5.0));
    }
    client.pass(999);
    client.command(Command::Stop);
    client.clear();
    client.now += 5_000;
    let (speed, acceleration) = (RotationsPerSecond(1.0), RotationsPerSecondSquared(1.0));
    let presence =
        |motor| MotorPresence::new(MotorAddress(motor), true.into(), MotorType::AXIS, speed, speed, acceleration);
    client.receive(presences(&(1..=10).map(presence).collect::<Vec<_>>()));
    let told = client.events();
    let late = told.iter().filter(|event| matches!(event, Event::StopNotConfirmed(_))).count();
    let ended = client.ended();
    let failed = ended.iter().filter(|outcome| **outcome == Outcome::Failed(Failure::NoAnswer)).count();
    let online = told.iter().filter(|event| matches!(event, Event::MotorOnline(..))).count();
    assert_eq!((late, failed, online), (11, 7, 10));
    assert!(ended.contains(&Outcome::NotConfirmed), "the range");
    let sent = client.sent();
    assert_eq!((sent[0], sent.len()), (Transmit::StopPlayback, 1 + 10 + 1 + 1));
}
