//! Stops of a master: hoot, section 5 and safety decisions 1, 2 and 4.

use super::world::*;
use hoot_proto::Address;
use hoot_proto::host::{Event, Failure, Input, Options, Outcome, Refusal, State, StopState, StopTarget};
use hoot_proto::message::{self, HostMessage, Motor};
use motion_core::wire::Messages;

const STATUS: HostMessage<'static> = HostMessage::RunStatus(message::RunStatus {});
const ONE: Motor = Motor::One;

const STOPPED: Outcome<'static> = Outcome::Failed(Failure::Stopped);

// 5-22
#[test]
fn a_stop_on_a_free_line_is_a_request() {
    for stop in [STOP, PAUSE, motor_stop(ONE)] {
        let mut master = Master::new(Options::default());
        assert_eq!(master.request(1, stop).packets()[0].message, stop);
        assert!(matches!(ended(&master.reply(1, &[]))[..], [(1, Outcome::Done(_))]));
        assert_eq!(master.pass(9000), [], "once");
    }
}

// 5-23
#[test]
fn a_stop_overtakes_and_is_sent_again_when_the_line_is_clear() {
    let enable = HostMessage::from(message::MotorSetEnable { motor: ONE, enable: YES });
    for answers in [1, 2] {
        let mut master = Master::new(Options::default());
        let _ = master.request(1, enable);
        master.now += 100;
        let output = master.request(2, STOP);
        assert_eq!(output.packets()[0].message, STOP, "in the same step");
        assert_eq!(ended(&output), [(1, Outcome::NotConfirmed)], "it may have been done");
        // This may be the answer to the setting, so it does not confirm the stop.
        for _ in 0..answers {
            master.now += 60;
            let output = master.reply(1, &[]);
            assert!(ended(&output).is_empty() && matches!(output.event_list()[..], [Event::Unsolicited(_)]));
        }
        // With two answers nothing is owed, and the stop is sent again after the time to wait for an answer.
        let due = if answers == 2 { 500 } else { 1400 };
        assert_eq!(sent(&master.pass(2000))[0], (due - 60 * answers, STOP));
    }
    // An answer without a value is not that to a query.
    let mut master = Master::new(Options::default());
    let _ = master.request(1, STATUS);
    master.now += 100;
    assert_eq!(master.request(2, STOP).packets()[0].message, STOP);
    assert!(ended(&master.reply(1, &[0, 0])).is_empty());
    assert!(matches!(ended(&master.reply(1, &[]))[..], [(2, Outcome::Done(_))]));

    // Inside the gap, a stop waits only for the end of the gap.
    let mut master = Master::new(Options::default());
    let _ = master.request(1, enable);
    master.now += 20;
    assert!(master.request(2, STOP).packets().is_empty());
    assert_eq!(sent(&master.pass(40)), [(40, STOP)]);

    // A stop does not wait for nodes with a new address, because it may be for other nodes.
    let mut master = Master::new(Options::default());
    let _ = master.request(1, HostMessage::from(message::SetAddress { new_address: Address(9) }));
    let _ = master.reply(1, &[]);
    master.now += 60;
    assert_eq!(master.request(2, STOP).packets()[0].message, STOP);
    assert_eq!(master.machine.state(), State::Quiet);
    assert_eq!(sent(&master.pass(2940)), [(2940, STOP)]);
}

// 5-24
#[test]
fn a_stop_removes_from_the_queue_what_would_move_its_target() {
    let other = Address(9);
    let start_all = HostMessage::from(message::BroadcastStart { sub_address: message::AnySubAddress(0) });
    let stop_all = HostMessage::from(message::BroadcastStop { sub_address: message::AnySubAddress(0) });
    let queued = [
        (NODE, START),
        (NODE, run(ONE)),
        (NODE, move_by(Motor::Two, 5)),
        (NODE, STATUS),
        (NODE, HostMessage::other(0x32_00, &[])),
        (other, START),
        (Address::BROADCAST, start_all),
    ];
    for (to, stop, taken) in [
        (NODE, STOP, vec![1, 2, 3, 5, 7]),
        (NODE, PAUSE, vec![1, 2, 3, 5, 7]),
        (NODE, motor_stop(ONE), vec![1, 2, 5, 7]),
        (NODE, motor_stop(Motor::Three), vec![1, 5, 7]),
        (other, STOP, vec![6, 7]),
        (Address::BROADCAST, stop_all, vec![1, 2, 3, 5, 6, 7]),
    ] {
        let mut master = Master::new(Options::default().with_bridge(false));
        let _ = master.request(0, STATUS);
        for (token, (to, message)) in (1..).zip(queued) {
            let _ = master.request_to(token, to, message);
        }
        let output = master.request_to(9, to, stop);
        let gone: Vec<u32> =
            ended(&output).into_iter().filter(|(_, outcome)| *outcome == STOPPED).map(|(token, _)| token).collect();
        assert_eq!(gone, taken, "{stop:?} to {to}");
    }
}

// 5-25
#[test]
fn a_stop_without_an_answer_is_not_confirmed() {
    for stop in [PAUSE, motor_stop(ONE)] {
        let mut master = Master::new(Options::default());
        let _ = master.request(1, stop);
        let outputs = master.pass(9000);
        assert_eq!(sent(&outputs), [(500, stop), (1000, stop)]);
        let (at, last) = outputs.last().unwrap();
        assert_eq!((*at, ended(last)), (1500, vec![(1, Outcome::NotConfirmed)]));
        let target = if stop == PAUSE { StopTarget::Node(NODE) } else { StopTarget::Motor(NODE, ONE) };
        assert_eq!(others(last), [Event::StopNotConfirmed(target)]);
    }
}

// 5-47
#[test]
fn stops_that_wait_are_not_confirmed_without_a_line() {
    let mut master = Master::new(Options::default());
    let _ = master.request(1, STATUS);
    master.now += 60;
    let _ = master.request(2, STOP);
    let _ = master.request(3, motor_stop(ONE));
    let output = master.step(Input::LinkDown);
    assert_eq!(ended(&output), [(3, Outcome::Failed(Failure::LinkDown)), (2, Outcome::NotConfirmed)]);
    let targets = [StopTarget::Motor(NODE, ONE), StopTarget::Node(NODE)].map(Event::StopNotConfirmed);
    assert_eq!(others(&output), [&[Event::LinkDown], &targets[..]].concat());
}

// 5-26
#[test]
fn after_a_failed_stop_of_the_controller_its_motors_are_stopped() {
    // The node refuses, directly or through a bridge, where a refusal looks like silence.
    for refused in [true, false] {
        let mut master = Master::new(Options::default());
        let mut outputs = vec![(0, master.request(1, STOP))];
        if refused {
            outputs.push((0, master.reply(0, &[])));
        }
        outputs.extend(master.pass(60_000));
        let messages: Vec<_> = sent(&outputs).into_iter().map(|(_, message)| message).collect();
        assert_eq!(messages.iter().filter(|message| **message == STOP).count(), if refused { 1 } else { 3 });
        let motors: Vec<_> = messages.into_iter().filter(|message| *message != STOP).collect();
        assert_eq!(motors[..3], Motor::ALL.map(motor_stop), "first each motor is stopped at once");
        let told: Vec<_> = outputs.iter().flat_map(|(_, output)| others(output)).collect();
        let motors = Motor::ALL.map(|motor| StopTarget::Motor(NODE, motor));
        let targets = [&[StopTarget::Node(NODE)][..], &motors].concat();
        assert_eq!(
            told,
            targets.into_iter().map(Event::StopNotConfirmed).collect::<Vec<_>>(),
            "the stops of the motors are not answered"
        );
        assert_eq!(all_ended(&outputs).len(), 1);
    }
}

// 5-27
#[test]
fn stops_overtake_each_other_and_all_come_to_an_end() {
    let mut master = Master::new(Options::default());
    let _ = master.request(1, motor_stop(ONE));
    master.now += 60;
    assert_eq!(master.request(2, motor_stop(Motor::Two)).packets()[0].message, motor_stop(Motor::Two), "at once");
    // The same stop again takes the place of the first. It is not sent within the time to wait for an answer.
    master.now += 60;
    let output = master.request(3, motor_stop(Motor::Two));
    assert!(output.packets().is_empty());
    assert_eq!(ended(&output), [(2, Outcome::NotConfirmed)], "it was sent");
    let again = sent(&master.clone().pass(450));
    assert_eq!(again, [(380, motor_stop(ONE)), (440, motor_stop(Motor::Two))], "nothing was heard of them");
    let mut found = Vec::new();
    for _ in 0..20 {
        if master.wake.is_some() {
            let output = master.wait(3000);
            found.extend(ended(&output));
            if master.machine.state() == State::Waiting {
                found.extend(ended(&master.reply(1, &[])));
            }
        }
    }
    found.sort_by_key(|(token, _)| *token);
    assert!(matches!(found[..], [(1, Outcome::Done(_)), (3, Outcome::Done(_))]), "{found:?}");
}

// 5-28
#[test]
fn too_many_stops_are_an_emergency() {
    let mut master = Master::new(Options::default());
    let _ = master.request(0, STATUS);
    for node in 0..8 {
        assert_eq!(ended(&master.request_to(u32::from(node), Address(10 + node), STOP)).len(), usize::from(false));
    }
    let output = master.request_to(8, Address(20), STOP);
    assert_eq!(ended(&output)[0], (8, Outcome::Refused(Refusal::Busy)));
    assert!(output.event_list().contains(&Event::Stopping));
    assert_eq!(master.machine.stopping(), StopState::Stopping);
    assert_eq!(ended(&output).len(), 10, "all others end too: {output:?}");
}

// 5-29
#[test]
fn a_broadcast_stop_behind_a_bridge_goes_to_each_node() {
    let sub_address = message::AnySubAddress(0);
    let stop = HostMessage::from(message::BroadcastStop { sub_address });
    let pause = HostMessage::from(message::BroadcastPause { sub_address });
    for (broadcast, single) in [(stop, STOP), (pause, PAUSE)] {
        let mut master = Master::offline(Options::default(), &[NODE, Address(9)]);
        master.line_up();
        let output = master.request_to(1, Address::BROADCAST, broadcast);
        assert_eq!(ended(&output), [(1, Outcome::Refused(Refusal::Bridge))]);
        assert_eq!((output.packets()[0].to, output.packets()[0].message), (NODE, single));
        let outputs = master.pass(60);
        assert_eq!(
            (outputs[0].0, outputs[0].1.packets()[0].to, outputs[0].1.packets()[0].message),
            (60, Address(9), single)
        );
    }
    // Without a list of nodes, an emergency stop begins.
    let mut master = Master::offline(Options::default(), &[]);
    master.line_up();
    let output = master.request_to(1, Address::BROADCAST, stop);
    assert!(output.event_list().contains(&Event::Stopping));
    assert_eq!((output.packets()[0].to, output.packets()[0].message), (Address::BROADCAST, stop));

    let mut master = Master::new(Options::default().with_bridge(false));
    let _ = master.request(1, STATUS);
    master.now += 60;
    let output = master.request_to(2, Address::BROADCAST, stop);
    assert_eq!(output.packets()[0].message, stop, "without a bridge the broadcast is sent");
    assert_eq!(ended(&output), [(1, STOPPED), (2, Outcome::Sent)]);
}
