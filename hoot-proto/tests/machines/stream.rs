//! The master's joystick stream: hoot, sections 4.3, 5 and 6.8.

use super::world::*;
use hoot_proto::Address;
use hoot_proto::host::{Command, Event, Failure, Input, MAX_KEPT, MAX_SPEEDS, NotTaken, Options, Outcome, Output};
use hoot_proto::message::{self, HostMessage, Motor, ResponseCode, StepsPerSecond};

const STATUS: HostMessage<'static> = HostMessage::RunStatus(message::RunStatus {});
const ALIVE: HostMessage<'static> = HostMessage::JoystickMode(message::JoystickMode {});
const ONE: Motor = Motor::One;

fn stream(master: &mut Master, motor: Motor, speed: f32) -> Output {
    let speed = StepsPerSecond(speed);
    master.command(Command::Speed { to: NODE, motor, speed })
}

fn keep(master: &mut Master, to: Address, on: bool) -> Output {
    master.command(Command::KeepAlive { to, on })
}

// 5-30
#[test]
fn of_speeds_that_wait_the_last_counts() {
    let mut master = Master::new(Options::default());
    assert_eq!(stream(&mut master, ONE, 1.0).send[0].message, speed(ONE, 1.0));
    for next in 2..50_u8 {
        master.now += 1;
        assert!(stream(&mut master, ONE, next.into()).is_quiet());
        assert!(stream(&mut master, Motor::Two, -f32::from(next)).is_quiet());
    }
    let _ = master.reply(1, &[]);
    let outputs = master.pass(60);
    assert_eq!(sent(&outputs), [(40, speed(ONE, 49.0))]);
    let _ = master.reply(1, &[]);
    assert_eq!(sent(&master.pass(60)), [(40, speed(Motor::Two, -49.0))]);
    // Silence is no news: most firmware says nothing, and the next speed comes soon.
    assert_eq!(master.pass(9000), []);
}

// 5-31
#[test]
fn a_speed_of_0_without_an_answer_becomes_a_stop() {
    let mut master = Master::new(Options::default());
    let _ = stream(&mut master, ONE, 0.0);
    let outputs = master.pass(350);
    assert_eq!(sent(&outputs), [(150, motor_stop(ONE)), (350, motor_stop(ONE))], "and again when the line is clear");
    assert!(all_ended(&outputs).is_empty());
    // Also when something overtakes it, or the node refuses it.
    let mut master = Master::new(Options::default());
    let _ = stream(&mut master, ONE, -0.0);
    master.now += 60;
    let _ = master.request(1, motor_stop(Motor::Two));
    assert_eq!(sent(&master.pass(60)), [(60, motor_stop(ONE))]);
    let mut master = Master::new(Options::default());
    let _ = stream(&mut master, ONE, 0.0);
    let output = master.reply(0, &[]);
    let why = Failure::Refused(ResponseCode::ERROR);
    assert_eq!(output.events[..], [Event::SpeedFailed { to: NODE, motor: ONE, why }]);
    assert_eq!(sent(&master.pass(60)), [(60, motor_stop(ONE))]);
    // Not if it is answered, nor if the motor is to move again by then.
    let mut master = Master::new(Options::default());
    let _ = stream(&mut master, ONE, 0.0);
    let _ = master.reply(1, &[]);
    assert_eq!(master.pass(9000), []);
    let _ = stream(&mut master, ONE, 0.0);
    let _ = stream(&mut master, ONE, 5.0);
    let messages: Vec<_> = sent(&master.pass(9000)).into_iter().map(|(_, message)| message).collect();
    assert_eq!(messages, [speed(ONE, 5.0)]);
}

// 5-32
#[test]
fn speeds_that_make_no_sense_are_not_sent() {
    let mut master = Master::new(Options::default());
    for bad in [f32::NAN, f32::INFINITY] {
        let output = stream(&mut master, ONE, bad);
        assert!(output.send.is_empty());
        let [Event::SpeedFailed { why: Failure::NotTaken(NotTaken::Lint(_)), .. }] = output.events[..] else {
            panic!("{output:?}")
        };
    }
    let _ = master.request(1, STATUS);
    for place in 0..=MAX_SPEEDS {
        let to = Address(10 + u8::try_from(place).unwrap());
        let output = master.command(Command::Speed { to, motor: ONE, speed: StepsPerSecond(1.0) });
        let full = Event::SpeedFailed { to, motor: ONE, why: Failure::NotTaken(NotTaken::Full) };
        assert_eq!(output.events.first(), (place == MAX_SPEEDS).then_some(&full));
    }
    // A stop takes back the speed that waits.
    let mut master = Master::new(Options::default());
    let _ = master.request(1, STATUS);
    let _ = stream(&mut master, ONE, 7.0);
    let _ = master.request(2, motor_stop(ONE));
    let messages: Vec<_> = sent(&master.pass(9000)).into_iter().map(|(_, message)| message).collect();
    assert!(messages.iter().all(|message| *message == motor_stop(ONE)), "{messages:?}");
}

// 5-33
#[test]
fn a_node_that_is_kept_alive_hears_something_in_time() {
    let mut master = Master::new(Options::default());
    assert_eq!(keep(&mut master, NODE, true).send[0].message, ALIVE);
    let _ = master.reply(1, &[0, 1]);
    assert_eq!(sent(&master.pass(400)), [(400, ALIVE)]);
    let _ = master.reply(1, &[0, 1]);
    master.pass(300);
    assert_eq!(stream(&mut master, ONE, 3.0).send.len(), 1);
    let _ = master.reply(1, &[]);
    assert_eq!(sent(&master.pass(400)), [(400, ALIVE)], "a speed keeps it alive as well");
    // Silence is told, and it goes on.
    let outputs = master.pass(400);
    assert_eq!(outputs[0].1.events[..], [Event::KeepAliveLost { to: NODE }]);
    assert_eq!((outputs[0].0, sent(&outputs)), (150, vec![(400, ALIVE)]));
    let _ = master.reply(1, &[0, 1]);
    assert!(keep(&mut master, NODE, false).is_quiet());
    assert_eq!(master.pass(9000), []);
}

// 5-34
#[test]
fn only_so_many_nodes_are_kept_alive() {
    let mut master = Master::new(Options::default());
    for place in 0..MAX_KEPT {
        let _ = keep(&mut master, Address(10 + u8::try_from(place).unwrap()), true);
    }
    assert_eq!(keep(&mut master, NODE, true).events[..], [Event::NotTaken(NotTaken::Full)]);
    assert!(keep(&mut master, Address(10), true).events.is_empty(), "it is among them");
    assert_eq!(keep(&mut master, Address::MASTER, true).events[..], [Event::NotTaken(NotTaken::Address)]);
    let outputs = master.pass(3000);
    for place in 0..MAX_KEPT {
        let to = Address(10 + u8::try_from(place).unwrap());
        let heard = outputs.iter().filter(|(_, output)| output.send.iter().any(|send| send.to == to)).count();
        assert!(heard >= 2, "nobody answers, and {to} hears {heard}");
    }
    assert_eq!(master.step(Input::LinkDown).events.len(), 0);
    let _ = master.step(Input::LinkUp);
    assert_eq!(master.pass(3000), [], "a line that goes ends it");
}

// 5-35
#[test]
fn requests_and_speeds_take_turns() {
    let mut master = Master::new(Options::default());
    let _ = master.request(1, STATUS);
    let mut found = Vec::new();
    for round in 0..6_u8 {
        let _ = stream(&mut master, ONE, f32::from(round) + 1.0);
        let _ = master.request(u32::from(round) + 2, STATUS);
        while master.machine.state().name() != "Waiting" {
            found.extend(sent(&[(0, master.wait(100))]));
        }
        let is_query = found.last().is_none_or(|(_, message)| *message == STATUS);
        let output = if is_query { master.reply(1, &[0, 0]) } else { master.reply(1, &[]) };
        assert!(matches!(ended(&output)[..], [(_, Outcome::Done(_))] | []));
        while master.machine.state().name() == "Settling" {
            found.extend(sent(&[(0, master.wait(100))]));
        }
    }
    let queries: Vec<bool> = found.iter().map(|(_, message)| *message == STATUS).collect();
    assert!(queries.windows(2).all(|pair| pair[0] != pair[1]), "{queries:?}");
    assert!(queries.len() >= 5);
}

// 5-46
#[test]
fn nodes_that_are_gone_do_not_keep_requests_waiting() {
    let mut master = Master::new(Options::default());
    for to in 10..14 {
        let _ = keep(&mut master, Address(to), true);
    }
    for token in 0..4 {
        let _ = master.request(token, STATUS);
    }
    let outputs = master.pass(20_000);
    assert_eq!(all_ended(&outputs).len(), 4, "nobody answers, and all come to their end");
    assert!(all_ended(&outputs).iter().all(|(at, ..)| *at < 4 * 2500), "{outputs:?}");
}
