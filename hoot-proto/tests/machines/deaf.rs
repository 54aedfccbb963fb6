//! Nodes that may be deaf, with masters whose packets nobody answers (decision H-41).

use super::world::*;
use hoot_proto::Address;
use hoot_proto::host::{Command, Event, Input, Options, Outcome, StopState, StopTarget};
use hoot_proto::message::{self, HostMessage, Motor, StepsPerSecond};
use motion_core::wire::Messages;

const STATUS: HostMessage<'static> = HostMessage::RunStatus(message::RunStatus {});
const OTHER: Address = Address(9);

/// A master with two nodes, whose line has just come up.
fn fresh() -> Master {
    let mut master = Master::offline(Options::default().with_bridge(false), &[NODE, OTHER]);
    master.line_comes_up();
    master
}

/// Packets that were sent, with their times and receivers.
fn packets(outputs: &[(u64, hoot_proto::host::Output<'_>)]) -> Vec<(u64, Address, HostMessage<'static>)> {
    outputs.iter().flat_map(|(at, output)| output.transmits().map(|send| (*at, send.to, send.message))).collect()
}

// 5-69
#[test]
fn a_stop_is_sent_again_after_3_s_however_often_the_line_comes_up() {
    for up in (300..6000).step_by(100) {
        let mut master = Master::offline(Options::default(), &[NODE]);
        master.line_comes_up();
        let mut stops: Vec<u64> = Vec::new();
        let mut note = |now: u64, output: &hoot_proto::host::Output<'_>| {
            stops.extend(output.transmits().filter(|send| send.message.conduct().is_stop()).map(|_| now));
        };
        note(master.now, &master.order(Command::EmergencyStop));
        while master.now < 40_000 {
            let began = master.now;
            for (at, output) in master.pass(up) {
                note(began + at, &output);
            }
            let _ = master.step(Input::LinkDown);
            note(master.now, &master.step(Input::LinkUp));
        }
        assert!(stops.windows(2).all(|pair| pair[1] - pair[0] <= 3060), "the line comes up every {up} ms: {stops:?}");
        assert!(stops.len() > 9, "the line comes up every {up} ms: {stops:?}");
    }
}

// 5-70
#[test]
fn after_the_line_came_up_one_packet_goes_to_each_node_until_it_answers() {
    // A stop that is not answered is not repeated.
    for asked in [0, 500, 1000, 1500, 2500] {
        let mut master = fresh();
        assert_eq!(master.pass(asked), []);
        let mut all = vec![(0, master.request(1, STOP))];
        all.extend(master.pass(8000));
        let sent = packets(&all);
        assert_eq!(sent[0], (0, NODE, STOP), "asked {asked} ms after the line came up");
        assert!(sent[1].0 >= 3000 - asked && sent[1].0 < 3500, "asked {asked} ms after the line came up: {sent:?}");
        let told = all
            .iter()
            .flat_map(|(_, output)| others(output))
            .find(|event| *event != Event::Ready { reconnected: false });
        assert_eq!(told, Some(Event::StopNotConfirmed(StopTarget::Node(NODE))));
    }
    // Neither is a question. A stop waits until it is read or answered.
    let mut master = fresh();
    let _ = master.request(1, STATUS);
    assert_eq!(packets(&master.pass(1500)), [(900, NODE, STATUS)]);
    let mut answered = master.clone();
    assert_eq!(master.request(2, STOP).packets(), []);
    assert_eq!(packets(&master.pass(1600))[0], (1500, NODE, STOP));
    assert!(answered.reply(1, &[0, 0]).packets().is_empty());
    assert_eq!(answered.request(2, STOP).packets()[0].message, STOP);
    // Nothing else goes to a node that has not answered, and a motor that is to rest is stopped at once.
    let mut master = fresh();
    let _ = master.order(Command::KeepAlive { to: NODE, on: true });
    let run_at = |speed| Command::Speed { to: NODE, motor: Motor::Two, speed: StepsPerSecond(speed) };
    let _ = master.order(run_at(5.0));
    let _ = master.request(1, START);
    let _ = master.request_to(2, OTHER, STATUS);
    assert_eq!(master.pass(1500), [], "the start is the first request");
    let stop = master.order(run_at(0.0));
    assert_eq!(stop.packets()[0].message, STOP);
    assert_eq!(packets(&master.pass(1490)), []);
    assert_eq!(packets(&master.pass(100)).first().map(|(at, ..)| *at), Some(10));
}

// 5-74
#[test]
fn a_joystick_at_rest_is_no_emergency_after_the_line_came_up() {
    let mut master = fresh();
    let mut told = Vec::new();
    for to in [NODE, OTHER, Address(5)] {
        for motor in Motor::ALL {
            let output = master.order(Command::Speed { to, motor, speed: StepsPerSecond(0.0) });
            told.extend(others(&output));
        }
    }
    for (_, output) in master.pass(3000) {
        told.extend(others(&output));
    }
    assert!(!told.contains(&Event::Stopping), "{told:?}");
    assert_eq!(master.machine.stopping(), StopState::Calm);
}

// 5-72
#[test]
fn a_broadcast_stop_waits_for_a_deaf_node_while_the_listed_nodes_are_stopped() {
    let unknown = HostMessage::other(0, &[1]);
    let stop_all = HostMessage::from(message::BroadcastStop::default());
    let pause_all = HostMessage::from(message::BroadcastPause::default());
    for (all, one) in [(stop_all, STOP), (pause_all, PAUSE)] {
        // A node that is not listed may be deaf, and a stop waits there.
        let mut master = Master::offline(Options::default().with_bridge(false), &[NODE, OTHER]);
        master.line_up();
        let deaf = Address(20);
        assert_eq!(master.request_to(1, deaf, unknown).packets().len(), 1);
        master.now += 60;
        assert_eq!(master.request_to(2, deaf, STOP).packets().len(), 1);
        master.now += 60;
        let output = master.request_to(3, Address::BROADCAST, all);
        assert_eq!(ended(&output), []);
        assert_eq!(packets(&[(0, output)]), [(0, NODE, one)], "at once");
        let outputs = master.pass(2900);
        let sent = packets(&outputs);
        assert_eq!(sent[0], (60, OTHER, one));
        let at = sent.iter().find(|(.., message)| *message == all).map(|(at, ..)| *at);
        assert_eq!(at, Some(2880), "when no node is deaf");
        let end = all_ended(&outputs).into_iter().find(|(_, token, _)| *token == 3);
        assert_eq!(end, Some((2880, 3, Outcome::Sent)));
    }
}

// 5-71
#[test]
fn one_node_that_may_be_deaf_does_not_make_the_master_forget_another() {
    let unknown = HostMessage::other(0, &[1]);
    let mut master = Master::offline(Options::default(), &[NODE, OTHER]);
    master.line_up();
    assert_eq!(master.request_to(1, OTHER, unknown).packets().len(), 1);
    master.now += 100;
    assert_eq!(master.request(2, START).packets().len(), 1);
    master.now += 100;
    assert!(matches!(ended(&master.reply(1, &[]))[..], [(2, _)]));
    let _ = master.request_to(3, OTHER, STATUS);
    let stop = packets(&[(0, master.request_to(4, OTHER, motor_stop(Motor::One)))]);
    let rest = packets(&master.pass(2900));
    let all: Vec<_> = stop.iter().chain(&rest).filter(|(at, ..)| *at < 2700).collect();
    assert_eq!(all.len(), 1, "{all:?}");
    assert_eq!((all[0].1, all[0].2), (OTHER, STOP), "{all:?}");

    // No motor gets a speed, except 0, before a stop is confirmed.
    let mut master = fresh();
    assert_eq!(master.request_to(1, OTHER, STOP).packets().len(), 1);
    let _ = master.request(2, STATUS);
    assert_eq!(packets(&master.pass(900)), [(900, NODE, STATUS)]);
    let _ = master.reply(1, &[0, 0]);
    let mut rests = master.clone();
    let run_at = |speed| Command::Speed { to: NODE, motor: Motor::Two, speed: StepsPerSecond(speed) };
    let _ = master.order(run_at(5.0));
    assert_eq!(packets(&master.pass(3000))[0], (2100, OTHER, STOP));
    let _ = rests.order(run_at(0.0));
    assert_eq!(packets(&rests.pass(3000))[0], (60, NODE, speed(Motor::Two, 0.0)));

    // No node gets another address, or is started, before a stop is confirmed.
    for message in [START, message::SetAddress { new_address: Address(7) }.into(), unknown] {
        let mut master = fresh();
        assert_eq!(master.request_to(1, OTHER, STOP).packets().len(), 1);
        let _ = master.request(2, STATUS);
        assert_eq!(packets(&master.pass(900)), [(900, NODE, STATUS)]);
        let _ = master.reply(1, &[0, 0]);
        let _ = master.request(3, message);
        let sent = packets(&master.pass(3000));
        assert_eq!(sent[0], (2100, OTHER, STOP), "{message}: {sent:?}");
    }
}

// 5-73
#[test]
fn after_the_line_came_up_an_ok_may_be_that_to_a_start_of_somebody_else() {
    // A stop is lost, and the node answers a start from before the line came up.
    for asked in [0, 500, 1000, 1400, 2500] {
        let mut master = fresh();
        assert_eq!(master.pass(asked), []);
        assert_eq!(packets(&[(0, master.request(1, STOP))]), [(0, NODE, STOP)], "asked after {asked} ms");
        master.now += 60;
        let output = master.reply(1, &[]);
        assert!(ended(&output).is_empty(), "asked after {asked} ms");
        assert!(matches!(others(&output)[..], [Event::Unsolicited(_)]));
        assert_eq!(packets(&master.pass(3000 - asked))[..], [(2940 - asked, NODE, STOP)], "asked after {asked} ms");
        assert!(matches!(ended(&master.reply(1, &[]))[..], [(1, Outcome::Done(_))]));
    }
    // A setting is not confirmed by such an answer either: it waits.
    let enable = HostMessage::from(message::MotorSetEnable { motor: Motor::One, enable: YES });
    let mut master = fresh();
    let _ = master.request(1, enable);
    assert_eq!(packets(&master.pass(3000)), [(3000, NODE, enable)]);
    // Neither is a question refused by the answer to a start.
    let mut master = fresh();
    let _ = master.request(1, STATUS);
    assert_eq!(packets(&master.pass(900)), [(900, NODE, STATUS)]);
    assert_eq!(ended(&master.reply(0, &[])), []);
    // Each node that is listed, or that is stopped, may have been started.
    for third in [Address(20), OTHER] {
        let mut master = fresh();
        let first = if third == OTHER { NODE } else { OTHER };
        let stopped = if third == OTHER { NODE } else { third };
        if third != OTHER {
            let _ = master.request_to(1, NODE, STATUS);
            assert_eq!(packets(&master.pass(900)), [(900, NODE, STATUS)]);
            let _ = master.reply(1, &[0, 0]);
        }
        let _ = master.request_to(2, first, STATUS);
        assert_eq!(master.pass(900).len(), 1);
        assert!(matches!(ended(&master.reply(1, &[0, 0]))[..], [(2, Outcome::Done(_))]));
        master.now += 60;
        assert_eq!(packets(&[(0, master.request_to(3, stopped, STOP))]), [(0, stopped, STOP)]);
        master.now += 60;
        assert!(ended(&master.reply(1, &[])).is_empty(), "{third}");
    }
    // When each of them has answered, the answer to a stop is its own.
    let mut master = fresh();
    for node in [NODE, OTHER] {
        let _ = master.request_to(1, node, STATUS);
        assert_eq!(master.pass(900).len(), 1);
        assert!(matches!(ended(&master.reply(1, &[0, 0]))[..], [(1, Outcome::Done(_))]));
    }
    master.now += 60;
    assert_eq!(packets(&[(0, master.request(3, STOP))]), [(0, NODE, STOP)]);
    assert!(matches!(ended(&master.reply(1, &[]))[..], [(3, Outcome::Done(_))]));
}
