//! Speeds of a joystick, and keep-alives: hoot, sections 4.3, 5 and 6.8.

use super::world::*;
use hoot_proto::Address;
use hoot_proto::EncodeError;
use hoot_proto::host::{
    Command, Event, Failure, Input, MAX_KEPT, MAX_SPEEDS, Options, Outcome, Output, Refusal, Token,
};
use hoot_proto::message::{self, HostMessage, Motor, ResponseCode, StepsPerSecond};

const STATUS: HostMessage<'static> = HostMessage::RunStatus(message::RunStatus {});
const ALIVE: HostMessage<'static> = HostMessage::JoystickMode(message::JoystickMode {});
const ONE: Motor = Motor::One;

fn stream(master: &mut Master, motor: Motor, speed: f32) -> Output<'static> {
    let speed = StepsPerSecond(speed);
    master.order(Command::Speed { to: NODE, motor, speed })
}

/// Gives a speed with a token that is tested.
fn named(master: &mut Master, token: u32, motor: Motor, speed: f32) -> Output<'static> {
    let speed = StepsPerSecond(speed);
    master.command(Token(token), Command::Speed { to: NODE, motor, speed })
}

fn keep(master: &mut Master, to: Address, on: bool) -> Output<'static> {
    master.order(Command::KeepAlive { to, on })
}

/// End of a command whose end is not tested otherwise.
const fn end(outcome: Outcome<'_>) -> Event<'_> {
    Event::Ended { token: UNNAMED, outcome }
}

// 5-30
#[test]
fn the_last_of_the_speeds_that_wait_is_sent() {
    let mut master = Master::new(Options::default());
    assert_eq!(named(&mut master, 1, ONE, 1.0).packets()[0].message, speed(ONE, 1.0));
    let superseded = Outcome::Failed(Failure::Superseded);
    for next in 2..50_u8 {
        master.now += 1;
        let output = named(&mut master, next.into(), ONE, next.into());
        let before = (next > 2).then(|| (u32::from(next) - 1, superseded));
        assert_eq!((ended(&output), output.packets().len()), (Vec::from_iter(before), 0));
        let output = named(&mut master, 100 + u32::from(next), Motor::Two, -f32::from(next));
        let before = (next > 2).then(|| (99 + u32::from(next), superseded));
        assert_eq!((ended(&output), output.packets().len()), (Vec::from_iter(before), 0));
    }
    assert!(matches!(ended(&master.reply(1, &[]))[..], [(1, Outcome::Done(_))]));
    let outputs = master.pass(60);
    assert_eq!(sent(&outputs), [(40, speed(ONE, 49.0))]);
    assert_eq!(ended(&master.reply(0, &[])), [(49, Outcome::Refused(Refusal::Device(ResponseCode::ERROR)))]);
    assert_eq!(sent(&master.pass(60)), [(40, speed(Motor::Two, -49.0))]);
    // Silence is usual: most firmware does not answer, and the next speed comes soon.
    assert_eq!(all_ended(&master.pass(9000)), [(130, 149, Outcome::NotConfirmed)]);
}

// 5-31
#[test]
fn a_speed_of_0_without_an_answer_becomes_a_stop() {
    let mut master = Master::new(Options::default());
    let _ = stream(&mut master, ONE, 0.0);
    let mut lost = master.clone();
    let stops = [150, 650, 1150, 2550].map(|at| (at, motor_stop(ONE)));
    assert_eq!(sent(&lost.pass(2550)), stops, "a lost stop is repeated, and again when the line is clear");
    assert_eq!(sent(&master.pass(150)), [(150, motor_stop(ONE))]);
    let _ = master.reply(1, &[]);
    let outputs = master.pass(1400);
    assert_eq!(sent(&outputs), [(1400, motor_stop(ONE))], "the answer may be that to the speed");
    assert!(all_ended(&outputs).is_empty());
    // The same happens if a stop overtakes the speed, or the node refuses it.
    let mut master = Master::new(Options::default());
    let _ = stream(&mut master, ONE, -0.0);
    master.now += 60;
    let _ = master.request(1, motor_stop(Motor::Two));
    assert_eq!(sent(&master.pass(60)), [(60, motor_stop(ONE))]);
    let mut master = Master::new(Options::default());
    let _ = stream(&mut master, ONE, 0.0);
    let output = master.reply(0, &[]);
    assert_eq!(others(&output), []);
    assert_eq!(sent(&master.pass(60)), [(60, motor_stop(ONE))]);
    // There is no stop if the node answers, or if the motor has a new speed by then.
    let mut master = Master::new(Options::default());
    let _ = stream(&mut master, ONE, 0.0);
    let _ = master.reply(1, &[]);
    assert_eq!(master.pass(9000), []);
    let _ = stream(&mut master, ONE, 0.0);
    let _ = stream(&mut master, ONE, 5.0);
    let messages: Vec<_> = sent(&master.pass(9000)).into_iter().map(|(_, message)| message).collect();
    assert_eq!(messages, [speed(ONE, 5.0)]);
}

// 5-67
#[test]
fn a_stop_after_a_speed_waits_only_for_the_gap() {
    let mut master = Master::new(Options::default());
    let _ = stream(&mut master, ONE, 0.0);
    assert_eq!(sent(&master.pass(150)), [(150, motor_stop(ONE))], "the machine stops the motor by itself");
    let _ = master.reply(1, &[]);
    let _ = stream(&mut master, ONE, 5.0);
    assert_eq!(sent(&master.pass(120)), [(60, speed(ONE, 5.0))], "the motor runs again");
    assert_eq!(
        master.request(1, motor_stop(ONE)).packets()[0].message,
        motor_stop(ONE),
        "the motor is stopped at once"
    );
}

// 5-32
#[test]
fn speeds_without_a_finite_value_are_refused() {
    let mut master = Master::new(Options::default());
    for bad in [f32::NAN, f32::INFINITY] {
        let output = named(&mut master, 1, ONE, bad);
        assert!(output.packets().is_empty());
        let [(1, Outcome::Refused(Refusal::Invalid(EncodeError::Refused(_))))] = ended(&output)[..] else {
            panic!("{output:?}")
        };
    }
    let _ = master.request(1, STATUS);
    for place in 0..=MAX_SPEEDS {
        let to = Address(10 + u8::try_from(place).unwrap());
        let output = master.command(Token(9), Command::Speed { to, motor: ONE, speed: StepsPerSecond(1.0) });
        let full = (place == MAX_SPEEDS).then_some((9, Outcome::Refused(Refusal::Busy)));
        assert_eq!(ended(&output), Vec::from_iter(full));
    }
    // A stop removes the speed that waits.
    let mut master = Master::new(Options::default());
    let _ = master.request(1, STATUS);
    let _ = named(&mut master, 7, ONE, 7.0);
    let output = master.request(2, motor_stop(ONE));
    assert_eq!(ended(&output), [(7, Outcome::Failed(Failure::Stopped))]);
    let messages: Vec<_> = sent(&master.pass(9000)).into_iter().map(|(_, message)| message).collect();
    assert!(messages.iter().all(|message| *message == motor_stop(ONE)), "{messages:?}");
}

// 5-33
#[test]
fn a_node_that_is_kept_alive_hears_something_in_time() {
    let mut master = Master::new(Options::default());
    assert_eq!(keep(&mut master, NODE, true).packets()[0].message, ALIVE);
    let _ = master.reply(1, &[0, 1]);
    assert_eq!(sent(&master.pass(400)), [(400, ALIVE)]);
    let _ = master.reply(1, &[0, 1]);
    master.pass(300);
    assert_eq!(stream(&mut master, ONE, 3.0).packets().len(), 1);
    let _ = master.reply(1, &[]);
    assert_eq!(sent(&master.pass(400)), [(400, ALIVE)], "a speed keeps the node alive too");
    // A silence is told, and keep-alives go on.
    let outputs = master.pass(400);
    assert_eq!(outputs[0].1.event_list(), [Event::KeepAliveLost { to: NODE }]);
    assert_eq!((outputs[0].0, sent(&outputs)), (150, vec![(400, ALIVE)]));
    let _ = master.reply(1, &[0, 1]);
    assert_eq!(keep(&mut master, NODE, false).event_list(), [end(Outcome::Applied)]);
    assert_eq!(master.pass(9000), []);
}

// 5-34
#[test]
fn at_most_four_nodes_are_kept_alive() {
    let mut master = Master::new(Options::default());
    for place in 0..MAX_KEPT {
        let _ = keep(&mut master, Address(10 + u8::try_from(place).unwrap()), true);
    }
    assert_eq!(keep(&mut master, NODE, true).event_list(), [end(Outcome::Refused(Refusal::Busy))]);
    assert_eq!(keep(&mut master, Address(10), true).event_list(), [end(Outcome::Applied)], "the node is in the list");
    assert_eq!(keep(&mut master, Address::MASTER, true).event_list(), [end(Outcome::Refused(Refusal::Address))]);
    let outputs = master.pass(3000);
    for place in 0..MAX_KEPT {
        let to = Address(10 + u8::try_from(place).unwrap());
        let heard = outputs.iter().filter(|(_, output)| output.packets().iter().any(|send| send.to == to)).count();
        assert!(heard >= 2, "nobody answers, and {to} hears {heard}");
    }
    assert_eq!(master.step(Input::LinkDown).event_list(), [Event::LinkDown]);
    let _ = master.step(Input::LinkUp);
    assert_eq!(master.pass(3000), [], "a line that goes down ends keep-alives");
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
fn requests_have_their_turn_beside_silent_nodes() {
    let mut master = Master::new(Options::default());
    for to in 10..14 {
        let _ = keep(&mut master, Address(to), true);
    }
    for token in 0..4 {
        let _ = master.request(token, STATUS);
    }
    let outputs = master.pass(20_000);
    assert_eq!(all_ended(&outputs).len(), 4, "no node answers, and all commands end");
    assert!(all_ended(&outputs).iter().all(|(at, ..)| *at < 4 * 4500), "{outputs:?}");
}
