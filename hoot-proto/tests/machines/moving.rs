//! Whether anything may still move because of the master.

use super::world::*;
use hoot_proto::host::{Command, Input, Nodes, Options, StopState};
use hoot_proto::message::{self, HostMessage, Motor};
use hoot_proto::query::Profile;
use hoot_proto::{Address, Messages};

const STATUS: HostMessage<'static> = HostMessage::RunStatus(message::RunStatus {});
const ONE: Motor = Motor::One;

fn running(motor: Motor) -> HostMessage<'static> {
    message::MotorRunning { motor }.into()
}

/// Sends a request, which the node answers with this data.
fn done(master: &mut Master, message: HostMessage<'static>, data: &'static [u8]) {
    assert_eq!(master.request(1, message).packets()[0].message, message);
    master.now += 5;
    let _ = master.reply(1, data);
    master.pass(300);
}

/// A master after a message that may move something, which the node has answered.
fn after(message: HostMessage<'static>) -> Master {
    let mut master = Master::new(Options::new());
    assert!(!master.machine.may_move());
    done(&mut master, message, &[]);
    assert!(master.machine.may_move(), "{message:?}");
    master
}

// 5-48
#[test]
fn a_motor_may_move_until_it_rests() {
    for (message, data) in [(motor_stop(ONE), &[][..]), (STOP, &[]), (PAUSE, &[]), (running(ONE), &[0, 0])] {
        let mut master = after(run(ONE));
        done(&mut master, running(ONE), &[0, 1]);
        done(&mut master, running(Motor::Two), &[0, 0]);
        done(&mut master, motor_stop(Motor::Two), &[]);
        assert!(master.machine.may_move(), "none of these answers is about the motor");
        done(&mut master, message, data);
        assert!(!master.machine.may_move(), "{message:?}");
    }
}

// 5-49
#[test]
fn a_program_moves_motors_again_that_rest() {
    let mut master = after(START);
    for motor in Motor::ALL {
        done(&mut master, running(motor), &[0, 0]);
        done(&mut master, motor_stop(motor), &[]);
    }
    assert!(master.machine.may_move(), "the program may run");
    done(&mut master, STATUS, &[0, 2]);
    done(&mut master, STATUS, &[0, 0]);
    assert!(master.machine.may_move(), "a motor may have moved since it was asked");
    for motor in Motor::ALL {
        assert!(master.machine.may_move());
        done(&mut master, running(motor), &[0, 0]);
    }
    assert!(!master.machine.may_move());
    // The number 1 has two meanings.
    for (profile, rests) in [(Profile::UNKNOWN, false), (Profile::SHEET, false), (Profile::V033, true)] {
        let mut master = Master::new(Options::new().with_profile(profile));
        done(&mut master, START, &[]);
        done(&mut master, STATUS, &[0, 1]);
        for motor in Motor::ALL {
            done(&mut master, running(motor), &[0, 0]);
        }
        assert_eq!(!master.machine.may_move(), rests, "{profile:?}");
    }
}

// 5-50
#[test]
fn a_command_that_waits_may_move_until_it_is_removed() {
    let mut master = Master::new(Options::new());
    let _ = master.request(1, STATUS);
    let _ = master.request(2, run(ONE));
    assert!(master.machine.may_move(), "it will be sent");
    let _ = master.request(3, motor_stop(ONE));
    assert!(master.machine.may_move(), "the stop is not confirmed");
    master.pass(300);
    let _ = master.reply(1, &[]);
    assert!(!master.machine.may_move(), "it was never sent");

    let mut master = Master::new(Options::new());
    let _ = master.request(1, STATUS);
    let speed = message::StepsPerSecond(5.0);
    let _ = master.order(Command::Speed { to: NODE, motor: ONE, speed });
    assert!(master.machine.may_move());
    let _ = master.step(Input::LinkDown);
    assert!(!master.machine.may_move(), "it was never sent");
}

// 5-51
#[test]
fn a_refusal_or_a_silence_does_not_change_what_may_move() {
    let mut master = Master::new(Options::new());
    let _ = master.request(1, run(ONE));
    let _ = master.reply(0, &[]);
    assert!(master.machine.may_move(), "the refusal may be that of something else");
    let mut master = Master::new(Options::new());
    let _ = master.request(1, run(ONE));
    master.pass(9000);
    assert!(master.machine.may_move());
}

// 5-52
#[test]
fn settings_move_nothing() {
    let mut master = Master::new(Options::new());
    let acceleration = message::StepsPerSecondSquared(5.0);
    done(&mut master, message::MotorSetContinuousAcceleration { motor: ONE, acceleration }.into(), &[]);
    done(&mut master, speed(ONE, 0.0), &[]);
    done(&mut master, message::MotorSetEnable { motor: ONE, enable: YES }.into(), &[]);
    done(&mut master, joystick(YES), &[]);
    assert!(!master.machine.may_move());
    done(&mut master, speed(ONE, 1.0), &[]);
    assert!(master.machine.may_move(), "in joystick mode it starts the motor");
    let master = after(HostMessage::other(0x32_00, &[]));
    assert!(master.machine.may_move(), "a message without a type may move anything");
}

// 5-53
#[test]
fn after_a_stop_that_is_not_confirmed_its_target_may_move() {
    let mut master = Master::new(Options::new());
    let _ = master.request(1, motor_stop(ONE));
    master.pass(9000);
    assert!(master.machine.may_move());
    done(&mut master, running(ONE), &[0, 0]);
    assert!(!master.machine.may_move());
    // The same without a line.
    let mut master = Master::offline(Options::new(), &[NODE]);
    let _ = master.request(1, STOP);
    assert!(master.machine.may_move());
}

// 5-54
#[test]
fn a_line_that_goes_down_does_not_change_what_may_move() {
    let mut master = after(run(ONE));
    let _ = master.step(Input::LinkDown);
    assert!(master.machine.may_move());
    let _ = master.step(Input::LinkUp);
    master.pass(3000);
    assert!(master.machine.may_move());
    done(&mut master, motor_stop(ONE), &[]);
    assert!(!master.machine.may_move());
}

// 5-55
#[test]
fn a_broadcast_moves_every_listed_node() {
    let start = HostMessage::from(message::BroadcastStart::default());
    let nodes = Nodes::NONE.with(Address(4)).and_then(|nodes| nodes.with(Address(5))).unwrap();
    let options = Options::new().with_bridge(false);
    let mut master = Master::new(options);
    let _ = master.order(Command::Nodes(nodes));
    let _ = master.request_to(1, Address::BROADCAST, start);
    master.pass(100);
    for to in [4, 5] {
        assert!(master.machine.may_move());
        let _ = master.request_to(1, Address(to), STOP);
        let _ = master.reply(1, &[]);
        master.pass(300);
    }
    assert!(!master.machine.may_move());
    // Without a list of nodes, it is not known which nodes move.
    let mut master = Master::offline(options, &[]);
    master.line_up();
    let _ = master.request_to(1, Address::BROADCAST, start);
    master.pass(100);
    let _ = master.request(1, STOP);
    let _ = master.reply(1, &[]);
    master.pass(300);
    assert!(master.machine.may_move());
}

/// Makes an emergency stop; `ok` says to which packets the node answers OK. Returns the packets, and whether the stop was
/// confirmed within 100 packets. While it is not confirmed, something may move.
fn emergency(master: &mut Master, ok: impl Fn(&HostMessage<'_>) -> bool) -> (Vec<HostMessage<'static>>, bool) {
    let mut output = master.order(Command::EmergencyStop);
    let mut packets = Vec::new();
    while packets.len() < 100 {
        let is_confirmed = master.machine.stopping() == StopState::Calm;
        assert_ne!(master.machine.may_move(), is_confirmed);
        let packet = output.packets().first().copied();
        packets.extend(packet.map(|packet| packet.message));
        output = match packet {
            Some(packet) if ok(&packet.message) => master.answer(&packet, true),
            _ if is_confirmed => return (packets, true),
            _ => master.wait(3000),
        };
    }
    (packets, false)
}

// 5-56
#[test]
fn after_a_confirmed_emergency_stop_nothing_may_move() {
    for message in [run(ONE), START] {
        let mut master = after(message);
        let (packets, is_confirmed) = emergency(&mut master, |_| true);
        assert_eq!((packets.len(), is_confirmed), (7, true), "{message:?}");
    }
    // An emergency stop that is given up is not confirmed.
    let mut master = Master::new(Options::new());
    let _ = master.order(Command::EmergencyStop);
    let _ = master.order(Command::EndEmergency);
    assert!(master.machine.may_move());
}

// 5-57
#[test]
fn an_emergency_stop_goes_on_while_a_program_may_run() {
    // All motors rest, but the stop of the controller may have been lost. A program moves motors again that rest.
    let mut master = after(START);
    let (packets, is_confirmed) = emergency(&mut master, |message| *message != STOP);
    assert!(!is_confirmed && packets.iter().filter(|message| **message == STOP).count() > 3);
    // Without a program, motors that rest go on resting.
    let mut master = after(run(ONE));
    assert!(emergency(&mut master, |message| *message != STOP).1);
    // The answer to something else may have been taken for the answer to a stop, so a second round confirms the stop.
    for at_line in [0, 60] {
        let mut master = Master::new(Options::new());
        let _ = master.request(1, START);
        master.now += at_line;
        let (packets, is_confirmed) = emergency(&mut master, |_| true);
        assert_eq!(
            (packets.len(), is_confirmed),
            (16, true),
            "the stop of a deaf node, two rounds, the end of joystick mode"
        );
    }
}
