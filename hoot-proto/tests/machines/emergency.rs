//! Emergency stop of a master: hoot, section 5 and safety decision 2.

use super::world::*;
use hoot_proto::Address;
use hoot_proto::host::{
    Command, Event, Failure, Input, Nodes, Options, Outcome, Output, Refusal, StopState, StopTarget, Token,
};
use hoot_proto::message::{self, HostMessage, Motor};

const STATUS: HostMessage<'static> = HostMessage::RunStatus(message::RunStatus {});

/// Events of an emergency stop: it is not confirmed, and it is confirmed.
const NOT_CONFIRMED: Event<'static> = Event::StopNotConfirmed(StopTarget::All);
const STOPPED: Event<'static> = Event::Stopped(StopTarget::All);

fn press(master: &mut Master) -> Output<'static> {
    master.order(Command::EmergencyStop)
}

fn running(motor: Motor) -> HostMessage<'static> {
    HostMessage::from(message::MotorRunning { motor })
}

/// Packets of a round for one node behind a bridge; from the second round on with the end of joystick mode.
fn round(later: bool) -> Vec<HostMessage<'static>> {
    let mut round = Motor::ALL.map(motor_stop).to_vec();
    round.push(STOP);
    round.extend(later.then(|| joystick(NO)));
    round.extend(Motor::ALL.map(running));
    round
}

/// Goes on for a number of packets, answered or not, and returns the messages and the events.
fn go_on(
    master: &mut Master,
    first: Output<'static>,
    packets: usize,
    mut answers: impl FnMut(&HostMessage<'_>) -> Option<bool>,
) -> (Vec<HostMessage<'static>>, Vec<Event<'static>>) {
    let (mut packed, mut events) = (Vec::new(), Vec::new());
    let mut output = first;
    for _ in 0..10_000 {
        events.extend(others(&output));
        let Some(send) = output.packets().first().copied() else {
            if packed.len() >= packets || master.wake.is_none() {
                break;
            }
            output = master.wait(3000);
            continue;
        };
        packed.push(send.message);
        let at_rest = if send.to == Address::BROADCAST { None } else { answers(&send.message) };
        output = match at_rest {
            Some(at_rest) => master.answer(&send, at_rest),
            None if packed.len() >= packets => break,
            None => master.wait(3000),
        };
    }
    (packed, events)
}

// 5-9
#[test]
fn an_emergency_stop_ends_all_commands_and_stops_every_motor() {
    let mut master = Master::new(Options::default());
    let _ = master.request(1, run(Motor::Two));
    for token in 2..6 {
        let _ = master.request(token, run(Motor::One));
    }
    let speed = message::StepsPerSecond(5.0);
    let _ = master.command(Token(6), Command::Speed { to: NODE, motor: Motor::One, speed });
    let _ = master.order(Command::KeepAlive { to: NODE, on: true });
    master.now += 60;
    let output = press(&mut master);
    assert_eq!(output.packets()[0].message, motor_stop(Motor::One), "the first stop is sent in the same step");
    assert_eq!(output.event_list()[0], Event::Stopping);
    assert_eq!(ended(&output)[0], (1, Outcome::NotConfirmed), "it was sent");
    assert_eq!(ended(&output)[1..], [2, 3, 4, 5, 6].map(|token| (token, Outcome::Failed(Failure::Stopped))));
    assert_eq!(output.event_list().last(), Some(&Event::Ended { token: UNNAMED, outcome: Outcome::Sent }));
    assert_eq!(master.machine.stopping(), StopState::Stopping);

    let (packets, events) = go_on(&mut master, output, 1000, |_| Some(true));
    assert_eq!(packets, round(false));
    assert_eq!(events.last(), Some(&STOPPED));
    assert_eq!(master.machine.stopping(), StopState::Calm);
    assert_eq!(master.pass(9000), [], "no old command is sent later");
}

// 5-36
#[test]
fn an_emergency_stop_waits_only_for_the_gap() {
    let mut master = Master::new(Options::default());
    let _ = master.request(1, message::MotorSetEnable { motor: Motor::One, enable: YES }.into());
    master.now += 20;
    assert!(press(&mut master).packets().is_empty());
    assert_eq!(sent(&master.pass(40)), [(40, motor_stop(Motor::One))]);
    // If a node does not answer, the next stop is sent after 150 ms.
    assert_eq!(sent(&master.pass(150)), [(150, motor_stop(Motor::Two))]);
    // If it answers, the next stop is sent after the gap.
    master.now += 5;
    let _ = master.reply(1, &[]);
    assert_eq!(sent(&master.pass(55)), [(55, motor_stop(Motor::Three))]);
}

// 5-37
#[test]
fn an_emergency_stop_goes_on_until_every_motor_rests() {
    // The second motor goes on for a while.
    let mut still = 4;
    let mut master = Master::new(Options::default());
    let output = press(&mut master);
    let (sent, events) = go_on(&mut master, output, 1000, |message| {
        let runs = *message == running(Motor::Two) && still > 0;
        still -= u32::from(runs);
        Some(!runs)
    });
    let upto = |later: bool| round(later).into_iter().take_while(|message| *message != running(Motor::Three));
    let wanted: Vec<_> = upto(false).chain(upto(true)).chain(upto(true)).chain(upto(true)).chain(round(true)).collect();
    assert_eq!(sent, wanted, "each new round begins at once with the stops");
    assert_eq!(events, [Event::Stopping, NOT_CONFIRMED, STOPPED]);
}

// 5-38
#[test]
fn after_three_rounds_an_emergency_stop_is_not_confirmed_and_goes_on() {
    for silent in [true, false] {
        let mut master = Master::new(Options::default());
        let output = press(&mut master);
        let (sent, events) =
            go_on(&mut master, output, 100, |message| if silent { None } else { Some(message.query().is_none()) });
        assert!(sent.len() >= 100);
        assert_eq!(events, [Event::Stopping, NOT_CONFIRMED], "told once");
        let asked = sent.iter().position(|message| *message == joystick(NO)).unwrap();
        assert!(sent[..asked].contains(&running(Motor::One)), "joystick mode is left from the second round on");
        assert!(
            sent.iter()
                .all(|message| message.conduct().is_stop() || message.query().is_some() || *message == joystick(NO))
        );
    }
}

// 5-39
#[test]
fn a_late_answer_confirms_nothing() {
    let mut master = Master::new(Options::default());
    let output = press(&mut master);
    let mut silent_once = true;
    let (sent, events) = go_on(&mut master, output, 1000, |message| {
        let is_late = *message == running(Motor::One) && std::mem::take(&mut silent_once);
        (!is_late).then_some(true)
    });
    let wanted: Vec<_> = round(false).into_iter().take(5).chain(round(true)).collect();
    assert_eq!((sent, events.last()), (wanted, Some(&STOPPED)), "a round with a silence does not count");
    // Values of other types are not taken for the answer.
    let mut master = Master::new(Options::default());
    let output = press(&mut master);
    go_on(&mut master, output, 4, |_| Some(true));
    let stopped = master.now;
    while master.machine.state().name() != "Waiting" {
        let _ = master.wait(300);
    }
    assert_eq!(master.now - stopped, 60, "an answer without a value cannot be taken for that to a question");
    for stray in [&[][..], &[5, 0, 0, 0, 0], &[1, 0, 0]] {
        assert!(matches!(master.reply(1, stray).event_list()[..], [Event::Unsolicited(_)]));
    }
}

// 5-40
#[test]
fn a_second_emergency_stop_reaches_every_node_too() {
    let nodes = [NODE, Address(9)];
    let mut master = Master::offline(Options::default(), &nodes);
    master.line_up();
    let mut output = press(&mut master);
    let mut to = Vec::new();
    for _ in 0..16 {
        assert_eq!(output.event_list().first(), Some(&Event::Stopping));
        to.extend(output.packets().iter().map(|send| send.to));
        master.now += 60;
        to.extend(master.reply(1, &[]).packets().iter().map(|send| send.to));
        output = press(&mut master);
    }
    assert_eq!(to.iter().filter(|to| **to == Address(9)).count(), 4, "pressed every 60 ms: {to:?}");

    let mut master = Master::new(Options::default());
    let output = press(&mut master);
    go_on(&mut master, output, 4, |_| Some(true));
    while master.machine.stopping() != StopState::Asking {
        let _ = master.wait(300);
    }
    master.now += 60;
    let _ = press(&mut master);
    let next = sent(&master.pass(500)).first().map(|(_, message)| *message);
    assert_eq!(next, Some(motor_stop(Motor::One)), "the stops are sent before the questions, but not too soon");
}

// 5-41
#[test]
fn the_application_can_end_an_emergency_stop() {
    let mut master = Master::new(Options::default());
    let output = press(&mut master);
    go_on(&mut master, output, 30, |_| None);
    let output = master.command(Token(1), Command::EndEmergency);
    assert_eq!((ended(&output), others(&output)), (vec![(1, Outcome::Applied)], vec![]), "it was told before");
    assert!(master.machine.may_move());
    assert_eq!(sent(&master.pass(9000)), []);
    assert_eq!(master.request(1, STATUS).packets().len(), 1);
    let output = master.command(Token(2), Command::EndEmergency);
    assert_eq!((ended(&output), others(&output)), (vec![(2, Outcome::Applied)], vec![]), "there is no emergency stop");
    // An emergency stop that is given up at once is not confirmed either.
    let mut master = Master::new(Options::default());
    let _ = press(&mut master);
    assert_eq!(others(&master.order(Command::EndEmergency)), [NOT_CONFIRMED]);
}

// 5-42
#[test]
fn without_a_line_an_emergency_stop_is_not_confirmed_and_begins_with_the_line() {
    let mut master = Master::offline(Options::default(), &[NODE]);
    let told = [Event::Stopping, NOT_CONFIRMED];
    assert_eq!(others(&press(&mut master)), told);
    assert_eq!(master.wake, None);
    let output = master.step(Input::LinkUp);
    assert_eq!(output.packets()[0].message, STOP, "the node may be deaf");
    // After the line was down, nothing is certain.
    let mut master = Master::new(Options::default());
    let output = press(&mut master);
    go_on(&mut master, output, 5, |_| Some(true));
    assert_eq!(master.step(Input::LinkDown).event_list(), [Event::LinkDown, NOT_CONFIRMED]);
    let _ = master.step(Input::LinkUp);
    assert_eq!(sent(&master.pass(500))[0].1, STOP, "the round begins again");
}

// 5-43
#[test]
fn during_an_emergency_stop_only_stops_are_accepted() {
    let mut master = Master::new(Options::default());
    let _ = press(&mut master);
    let refused = Outcome::Refused(Refusal::Stopping);
    assert_eq!(ended(&master.request(1, START)), [(1, refused)]);
    assert_eq!(ended(&master.request(2, STATUS)), [(2, refused)]);
    let speed = message::StepsPerSecond(5.0);
    let speed = Command::Speed { to: NODE, motor: Motor::One, speed };
    for command in [speed, Command::KeepAlive { to: NODE, on: true }, Command::Nodes(Nodes::NONE)] {
        assert_eq!(ended(&master.command(Token(4), command)), [(4, refused)]);
    }
    master.now += 60;
    let output = master.request_to(3, Address(77), STOP);
    assert_eq!(
        (output.packets()[0].to, ended(&output)),
        (Address(77), vec![(3, Outcome::Sent)]),
        "nobody waits for it"
    );
    let (sent, _) = go_on(&mut master, Output::default(), 1000, |_| Some(true));
    assert_eq!(sent, round(false)[1..], "the emergency stop goes on where it was");
}

// 5-44
#[test]
fn without_a_bridge_a_broadcast_is_sent_first() {
    let sub_address = message::AnySubAddress(0);
    let stop = HostMessage::from(message::BroadcastStop { sub_address });
    let mut master = Master::new(Options::default().with_bridge(false));
    let output = press(&mut master);
    let (sent, events) = go_on(&mut master, output, 1000, |_| Some(true));
    assert_eq!(sent, [vec![stop], round(false)].concat());
    assert_eq!(events.last(), Some(&STOPPED));
    // Without a listed node only the broadcast is sent, with a bridge or without, and it is never confirmed.
    let mut master = Master::offline(Options::default(), &[]);
    master.line_up();
    let output = press(&mut master);
    let (sent, events) = go_on(&mut master, output, 20, |_| Some(true));
    assert_eq!(sent, vec![stop; 20]);
    assert_eq!(events, [Event::Stopping, NOT_CONFIRMED]);
}

// 5-45
#[test]
fn the_application_lists_the_nodes() {
    let nodes = Nodes::NONE.with(Address(7)).unwrap();
    assert_eq!(nodes.with(Address(7)), Some(nodes), "adding a node again changes nothing");
    assert_eq!((nodes.with(Address(1)), nodes.with(Address(0))), (None, None));
    let full = (2..10).fold(Nodes::NONE, |nodes, node| nodes.with(Address(node)).unwrap());
    assert_eq!((full.with(Address(10)), full.with(Address(9))), (None, Some(full)));
    assert_eq!(Nodes::default().as_slice(), [NODE]);
    let mut master = Master::new(Options::default());
    assert_eq!(ended(&master.command(Token(1), Command::Nodes(nodes))), [(1, Outcome::Applied)]);
    assert_eq!(master.machine.nodes().as_slice(), [Address(7)]);
    assert_eq!(press(&mut master).packets()[0].to, Address(7));
}
