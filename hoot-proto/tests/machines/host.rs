//! Line and requests of a master: hoot, section 5.

use super::world::*;
use hoot_proto::host::{Command, Event, Failure, Input, Options, Outcome, Refusal, Request, State, StopTarget, Token};
use hoot_proto::message::{self, HostMessage, Motor, ResponseCode};
use hoot_proto::{Address, EncodeError, Frame, Frames, Item};
use motion_core::wire::Messages;

const STATUS: HostMessage<'static> = HostMessage::RunStatus(message::RunStatus {});
const POWER: HostMessage<'static> = HostMessage::PowerCycled(message::PowerCycled {});
const NO_ANSWER: Outcome<'static> = Outcome::Failed(Failure::NoAnswer);

fn broadcast_start() -> HostMessage<'static> {
    HostMessage::from(message::BroadcastStart { sub_address: message::AnySubAddress(0) })
}

fn assign(new_address: Address) -> HostMessage<'static> {
    let sub_address = message::AnySubAddress(0);
    HostMessage::from(message::BroadcastAssignAddress { sub_address, new_address })
}

fn done(data: &[u8]) -> impl Fn(&Outcome<'_>) -> bool {
    move |outcome| matches!(outcome, Outcome::Done(reply) if reply.data == data)
}

const fn refused(why: Refusal) -> Outcome<'static> {
    Outcome::Refused(why)
}

// 5-1 5-16
#[test]
fn one_request_is_sent_at_a_time_with_a_gap_between() {
    let mut master = Master::new(Options::default());
    assert_eq!(master.machine.state(), State::Idle);
    let output = master.request(1, START);
    assert_eq!((output.packets()[0].to, output.packets()[0].message), (NODE, START));
    assert!(master.request(2, STATUS).packets().is_empty(), "one request at a time");
    assert_eq!((master.machine.state(), master.machine.pending()), (State::Waiting, 2));
    master.now += 5;
    let output = master.reply(1, &[]);
    assert!(output.packets().is_empty() && done(&[])(&ended(&output)[0].1), "{output:?}");
    let next = master.pass(60);
    assert_eq!(sent(&next), [(55, STATUS)], "60 ms after the first");
}

// 5-2
#[test]
fn broadcasts_are_not_answered() {
    let mut master = Master::new(Options::default().with_bridge(false));
    let sub_address = message::AnySubAddress(0);
    let pause = HostMessage::from(message::BroadcastPause { sub_address });
    let output = master.request_to(1, Address::BROADCAST, pause);
    assert_eq!((output.packets().len(), ended(&output)), (1, vec![(1, Outcome::Sent)]));
    assert_eq!(master.machine.state(), State::Quiet);
    let _ = master.request(2, STATUS);
    assert_eq!(sent(&master.pass(60)), [(60, STATUS)]);
    // A start blocks all nodes.
    let mut master = Master::new(Options::default().with_bridge(false));
    let output = master.request_to(1, Address::BROADCAST, broadcast_start());
    assert_eq!((output.packets().len(), ended(&output)), (1, vec![(1, Outcome::Sent)]));
    let _ = master.request(2, STATUS);
    assert_eq!(sent(&master.pass(3000)), [(3000, STATUS)]);
    // Command 0 is not answered either.
    let mut master = Master::new(Options::default());
    assert_eq!(ended(&master.request(1, HostMessage::from(message::Noop::default()))), [(1, Outcome::Sent)]);
}

// 5-3
#[test]
fn after_a_new_address_nothing_is_sent_for_a_while() {
    let mut master = Master::new(Options::default());
    let output = master.request_to(1, Address::BROADCAST, assign(Address(9)));
    assert_eq!(ended(&output), [(1, Outcome::Sent)], "through a bridge too, because it is for the attached node");
    let _ = master.request_to(2, Address(9), STATUS);
    assert_eq!(sent(&master.pass(3000)), [(3000, STATUS)]);

    let mut master = Master::new(Options::default());
    let _ = master.request(1, HostMessage::from(message::SetAddress { new_address: Address(9) }));
    let _ = master.reply(1, &[]);
    assert_eq!(master.machine.state(), State::Quiet);
    let _ = master.request_to(2, Address(9), STATUS);
    assert_eq!(sent(&master.pass(3000)), [(3000, STATUS)]);
}

// 5-4 5-13
#[test]
fn an_answer_may_come_in_pieces_and_among_noise() {
    let query = message::MotorPosition { motor: Motor::One };
    let mut master = Master::new(Options::default());
    let _ = master.request(1, HostMessage::from(query));
    let mut frames = Frames::<84>::new();
    let mut events = Vec::new();
    for piece in [&[7, 0, 0, 0][..], &[0, 0, 0, 255, 0, 0, 1], &[5, 3, 0, 0], &[1, 0, 9]] {
        master.now += 20;
        assert_eq!(frames.push(piece), piece.len());
        while let Some(item) = frames.next() {
            let output = match item {
                Item::Frame(frame) => master.step(Input::received(&frame)),
                _ => master.step(Input::Noise),
            };
            events.push(format!("{:?}", output.event_list()));
        }
    }
    assert_eq!(events[0], "[Noise]");
    let reply = "Reply { code: ResponseCode(OK), data: [3, 0, 0, 1, 0] }";
    assert_eq!(events[events.len() - 2], format!("[Ended {{ token: Token(1), outcome: Done({reply}) }}]"));
}

// 5-5 5-6
#[test]
fn an_answer_is_told_with_its_code() {
    let mut master = Master::new(Options::default());
    let _ = master.request(1, STATUS);
    assert!(done(&[0, 1])(&ended(&master.reply(1, &[0, 1]))[0].1));
    assert_eq!(master.machine.state(), State::Settling);
    for (code, data) in [(0, &[][..]), (2, &[0, 7]), (255, &[])] {
        let mut master = Master::new(Options::default());
        let _ = master.request(1, START);
        let output = master.reply(code, data);
        assert_eq!(ended(&output), [(1, refused(Refusal::Device(ResponseCode(code))))]);
        assert_eq!(master.pass(9000), [], "the query is not repeated");
    }
}

// 5-7
#[test]
fn packets_for_others_are_told_as_overheard() {
    let mut master = Master::new(Options::default());
    let _ = master.request(1, STATUS);
    let echo = Frame::decode(b"\0\0\0\0\0\xFF\x03\0\x65\0").unwrap();
    let output = master.step(Input::received(&echo));
    let [Event::Overheard { to: NODE, message }] = output.event_list()[..] else { panic!("{output:?}") };
    assert_eq!(message.name(), "Other");
    assert_eq!(master.machine.state(), State::Waiting);
    assert!(done(&[0, 0])(&ended(&master.reply(1, &[0, 0]))[0].1));
}

// 5-8
#[test]
fn queries_are_repeated_and_then_end_without_an_answer() {
    let mut master = Master::new(Options::default());
    let _ = master.request(1, STATUS);
    let outputs = master.pass(2000);
    assert_eq!(sent(&outputs), [(500, STATUS), (1000, STATUS)]);
    assert_eq!(all_ended(&outputs), [(1500, 1, NO_ANSWER)]);
    // The answer to the repetition counts, and the line then settles for longer.
    let mut master = Master::new(Options::default());
    let _ = master.request(1, STATUS);
    master.pass(510);
    let _ = master.reply(1, &[0, 0]);
    let _ = master.request(2, STATUS);
    assert_eq!(sent(&master.pass(900)), [(900, STATUS)]);
}

// 5-10 5-14
#[test]
fn messages_that_are_not_repeatable_are_sent_once() {
    let mut once = 0;
    for kind in HostMessage::ALL {
        for body in [&[][..], &[2], &[0, 1], &[0; 4], &[0; 5], &[0, 0, 0, 0, 1]] {
            let Ok(message) = HostMessage::decode_body(kind.number, body) else { continue };
            let mut master = Master::new(Options::default().with_bridge(false));
            let is_broadcast = kind.number >> 16 == 1;
            let to = if is_broadcast { Address::BROADCAST } else { NODE };
            let first = master.request_to(1, to, message);
            if first.packets().is_empty() {
                assert!(matches!(ended(&first)[..], [(1, Outcome::Refused(_))]), "{message:?}");
                continue;
            }
            let outputs = master.pass(20_000);
            let packets = 1 + sent(&outputs).iter().filter(|(_, again)| *again == message).count();
            let is_answered = ended(&first).is_empty();
            assert_eq!(packets, if message.conduct().repeatable && is_answered { 3 } else { 1 }, "{message:?}");
            assert_eq!(ended(&first).len() + all_ended(&outputs).len(), 1, "{message:?}");
            once += usize::from(packets == 1);
        }
    }
    assert!(once > 50, "{once}");
    let mut master = Master::new(Options::default());
    let _ = master.request(1, POWER);
    assert_eq!(all_ended(&master.pass(600)), [(500, 1, Outcome::NotConfirmed)], "the query clears the flag");
}

// 5-11 5-12
#[test]
fn a_second_answer_is_unsolicited() {
    let mut master = Master::new(Options::default());
    let running = HostMessage::from(message::MotorRunning { motor: Motor::One });
    let _ = master.request(1, running);
    master.now += 10;
    let _ = master.reply(1, &[0, 0]);
    let _ = master.request(2, STATUS);
    master.now += 2;
    let output = master.reply(1, &[5, 0, 0, 0x27, 0x10]);
    assert!(matches!(output.event_list()[..], [Event::Unsolicited(_)]));
    assert_eq!(master.machine.state(), State::Settling);
    assert_eq!(sent(&master.pass(48)), [(48, STATUS)], "after the line has settled and the gap is over");
    assert_eq!(master.machine.state(), State::Waiting);
}

// 5-15
#[test]
fn a_late_answer_is_not_taken_for_another() {
    let mut master = Master::new(Options::default().with_retries(0));
    let _ = master.request(1, STATUS);
    let _ = master.request(2, HostMessage::from(message::MotorPosition { motor: Motor::One }));
    let outputs = master.pass(500);
    assert_eq!(all_ended(&outputs), [(500, 1, NO_ANSWER)]);
    assert_eq!(master.machine.state(), State::Settling);
    master.now += 100;
    assert!(matches!(master.reply(1, &[0, 1]).event_list()[..], [Event::Unsolicited(_)]), "late answers are dropped");
    assert_eq!(sent(&master.pass(800)).len(), 1);
    for stray in [&[0, 1][..], &[], &[3, 0], &[5, 0, 0, 0, 0]] {
        assert!(
            matches!(master.reply(1, stray).event_list()[..], [Event::Unsolicited(_)]),
            "not a position: {stray:?}"
        );
    }
    assert!(done(&[3, 0, 0, 0, 1])(&ended(&master.reply(1, &[3, 0, 0, 0, 1]))[0].1));
    // A value is not the answer to a command either.
    let mut master = Master::new(Options::default());
    let _ = master.request(1, START);
    assert!(matches!(master.reply(1, &[0, 1]).event_list()[..], [Event::Unsolicited(_)]));
    assert!(done(&[])(&ended(&master.reply(1, &[]))[0].1));
    // A message without a type may be answered by anything.
    let mut master = Master::new(Options::default());
    let _ = master.request(1, HostMessage::other(0x7C_00, &[]));
    assert!(done(&[0, 7])(&ended(&master.reply(1, &[0, 7]))[0].1));
}

// 5-17
#[test]
fn a_start_may_take_three_seconds() {
    let mut master = Master::new(Options::default());
    let _ = master.request(1, START);
    master.pass(2999);
    assert!(done(&[])(&ended(&master.reply(1, &[]))[0].1));
    let mut master = Master::new(Options::default());
    let _ = master.request(1, START);
    assert_eq!(all_ended(&master.pass(9000)), [(3000, 1, Outcome::NotConfirmed)]);
}

// 5-18
#[test]
fn broadcasts_through_a_bridge_are_refused() {
    let mut master = Master::new(Options::default());
    let output = master.request_to(1, Address::BROADCAST, broadcast_start());
    assert_eq!((output.packets().len(), ended(&output)), (0, vec![(1, refused(Refusal::Bridge))]));
    let request = Request { to: Address::BROADCAST, message: broadcast_start() };
    let output = master.command(Token(2), Command::Insist(request));
    assert_eq!((output.packets().len(), ended(&output)), (1, vec![(2, Outcome::Sent)]));
}

// 5-19
#[test]
fn messages_with_errors_are_refused() {
    let mut master = Master::new(Options::default());
    for (message, to) in [
        (move_by(Motor::One, 0x0100_0000), NODE),
        (move_by(Motor::One, 0), NODE),
        (HostMessage::from(message::SetAddress { new_address: Address(1) }), NODE),
        (HostMessage::other(0x0F_01, &[1]), NODE),
        (assign(Address(0)), Address::BROADCAST),
    ] {
        let output = master.request_to(1, to, message);
        assert!(output.packets().is_empty(), "{message:?}");
        let [(1, Outcome::Refused(Refusal::Invalid(EncodeError::Refused(_))))] = ended(&output)[..] else {
            panic!("{output:?}")
        };
    }
    for (message, to) in [(START, Address::MASTER), (STOP, Address::BROADCAST), (broadcast_start(), NODE)] {
        assert_eq!(ended(&master.request_to(1, to, message)), [(1, refused(Refusal::Address))]);
    }
    for message in [HostMessage::other(0x2_09_00, &[0; 32]), HostMessage::other(0x32_00, &[0; 33])] {
        let too_long = |why: &EncodeError| {
            matches!(why, EncodeError::Refused(lint) if lint.what == "data")
                || matches!(why, EncodeError::TooLong { .. })
        };
        let output = master.request(1, message);
        assert!(
            matches!(&ended(&output)[..], [(1, Outcome::Refused(Refusal::Invalid(why)))] if too_long(why)),
            "{output:?}"
        );
    }
    // A stop without a type, and a command of the core protocol outside its table.
    for message in [HostMessage::other(0x04_00, &[]), HostMessage::other(0x01_00, &[2])] {
        let output = master.request(1, message);
        let [(1, Outcome::Refused(Refusal::Invalid(EncodeError::Typed { .. })))] = ended(&output)[..] else {
            panic!("{output:?}")
        };
    }
}

// 5-20
#[test]
fn a_full_queue_refuses_requests() {
    let mut master = Master::new(Options::default());
    for token in 0..9 {
        assert!(ended(&master.request(token, STATUS)).is_empty(), "one request is sent, and eight wait");
    }
    assert_eq!(ended(&master.request(9, STATUS)), [(9, refused(Refusal::Busy))]);
    assert!(ended(&master.request(10, motor_stop(Motor::One))).is_empty(), "stops have room of their own");
}

// 5-21
#[test]
fn commands_end_when_the_line_goes_down() {
    let mut master = Master::new(Options::default());
    let _ = master.request(1, START);
    let _ = master.request(2, STATUS);
    let output = master.step(Input::LinkDown);
    assert_eq!(ended(&output), [(1, Outcome::NotConfirmed), (2, Outcome::Failed(Failure::LinkDown))]);
    assert_eq!(output.event_list()[0], Event::LinkDown);
    assert_eq!((master.machine.state(), master.wake), (State::Offline, None));
    assert_eq!(ended(&master.request(3, STATUS)), [(3, refused(Refusal::NotConnected))]);
    let output = master.request(4, STOP);
    assert_eq!(
        output.event_list()[..],
        [
            Event::Ended { token: Token(4), outcome: refused(Refusal::NotConnected) },
            Event::StopNotConfirmed(StopTarget::Node(NODE)),
        ]
    );
    assert!(master.step(Input::LinkDown).is_quiet(), "it is down already");
    assert_eq!(master.step(Input::LinkUp).event_list(), [Event::Ready { reconnected: true }]);
    assert!(master.step(Input::LinkUp).is_quiet(), "it is up already");
    assert!(master.request(5, STATUS).packets().is_empty(), "nothing is believed for a while");
    assert_eq!(sent(&master.pass(3000)), [(3000, STATUS)], "the node may be deaf because of the start");
    assert!(matches!(master.reply(1, &[0, 0]).event_list()[..], [Event::Ended { token: Token(5), .. }]));
}
