//! A host: connection and requests. DMC D5.

use dmc_proto::host::{Command, Event, Failure, Input, Options, Outcome, State, Stop, Times, Token, What};
use dmc_proto::message::{
    Ack, AckCode, Capabilities, Dmx, DmxChannel, GioIn, HardStop, Hi, HostMessage, Motor, MotorMoving, MotorPositions,
    MotorResetPosition, Motors, Steps, StopReason, Triggers,
};
use dmc_proto::{DeviceMessage, HostMessage as Message, MessageId, MessageType};
use motion_core::time::Millis;
use motion_core::wire::Messages;

use super::bench::{
    Desk, EMPTY, axis, begin, hi, jog, jog_all, move_to, named, position_frame, run, shot, stop, stop_all, virtuals,
};

const STATUS: HostMessage<'static> = HostMessage::MotorStatus(EMPTY);

fn reset() -> HostMessage<'static> {
    HostMessage::MotorResetPosition(MotorResetPosition { motor: Motor(1), position: Steps(7), tail: &[] })
}

fn positions() -> DeviceMessage<'static> {
    DeviceMessage::MotorGetPosition(MotorPositions {
        move_time: dmc_proto::message::MoveTime::default(),
        positions: &[],
        tail: &[],
    })
}

/// D5-1, D-48
#[test]
fn an_open_line_is_greeted() {
    let mut desk = Desk::new();
    assert_eq!((desk.machine.state(), desk.wake), (State::Closed, None));
    assert_eq!(desk.request(1, STATUS), (vec![], vec![Event::Failed(Token(1), Failure::NotUp)]));
    assert_eq!(desk.step(Input::LinkUp), (vec![(1, What::Greeting)], vec![]));
    assert_eq!((desk.machine.state(), desk.wake), (State::Greeting, Some(Millis(2000))));
}

/// D5-2
#[test]
fn the_device_says_who_it_is() {
    for id in [0, 1] {
        let mut desk = Desk::new();
        desk.step(Input::LinkUp);
        assert_eq!(desk.step(Input::Malformed(MessageId(1), MessageType(1))), (vec![], vec![Event::Unreadable]));
        assert_eq!(desk.hears(id, DeviceMessage::Hi(hi())), (vec![], vec![Event::Greeted]));
        assert_eq!((desk.machine.state(), desk.wake), (State::Configuring, None));
        assert_eq!(desk.machine.device(), Some(hi()));
        assert_eq!(desk.machine.is_loaded(), (id == 0).then_some(false), "at boot there is no move");
    }
}

/// D5-3
#[test]
fn a_silent_device_is_greeted_five_times() {
    let mut desk = Desk::new();
    desk.step(Input::LinkUp);
    let greetings: Vec<_> = (2..=5).map(|id| (id, What::Greeting)).collect();
    assert_eq!(desk.pass(4999), (greetings, vec![]));
    assert_eq!(desk.pass(1), (vec![], vec![Event::NoAnswer]));
    assert_eq!((desk.machine.state(), desk.wake), (State::Silent, None));
    let mut other = desk.clone();
    assert_eq!(desk.command(Command::Greet), (vec![(6, What::Greeting)], vec![]));
    assert_eq!(desk.machine.state(), State::Greeting);
    assert_eq!(desk.command(Command::Greet), (vec![], vec![Event::Ignored]), "it is on its way");
    assert_eq!(other.hears(0, DeviceMessage::Hi(hi())), (vec![], vec![Event::Greeted]), "it has booted after all");
}

/// D5-4
#[test]
fn a_device_is_configured_before_anything_moves() {
    let mut desk = Desk::new();
    desk.step(Input::LinkUp);
    desk.hears(1, DeviceMessage::Hi(hi()));
    for message in [move_to(1, 2), jog(1)] {
        assert_eq!(desk.request(1, message), (vec![], vec![Event::Failed(Token(1), Failure::NotUp)]));
    }
    assert_eq!(desk.sequence(1, begin(1, 2)), (vec![], vec![Event::Failed(Token(1), Failure::NotUp)]));
    assert_eq!(desk.request(2, reset()), (vec![(2, named(2))], vec![]));
    assert_eq!(desk.command(Command::Configured), (vec![], vec![]));
    assert_eq!(desk.machine.state(), State::Configuring);
    let done = vec![Event::Done(Token(2), Outcome::Acknowledged), Event::Up];
    assert_eq!(desk.acked(2, 0x0035, AckCode::OK), (vec![], done));
    assert_eq!(desk.machine.state(), State::Up);
    assert_eq!(desk.command(Command::Configured), (vec![], vec![Event::Ignored]));
}

/// D5-5
#[test]
fn an_acknowledgement_ends_its_request() {
    for (code, event) in [
        (AckCode::OK, Event::Done(Token(7), Outcome::Acknowledged)),
        (AckCode::ERR_RANGE, Event::Failed(Token(7), Failure::Refused(AckCode::ERR_RANGE))),
        (AckCode(99), Event::Failed(Token(7), Failure::Refused(AckCode(99)))),
    ] {
        let mut desk = Desk::up();
        assert_eq!(desk.request(7, jog(1)), (vec![(2, named(7))], vec![]));
        let other = desk.acked(2, 0x0037, code);
        assert_eq!(other, (vec![], vec![Event::Stray(MessageId(2), MessageType(0x0037))]), "of another type");
        assert_eq!(desk.acked(2, 0x0036, code), (vec![], vec![event]));
        assert_eq!(desk.wake, None);
    }
    let mut desk = Desk::up();
    desk.request(7, jog(1));
    let empty = DeviceMessage::Ack(Ack { response_code: None, ..Ack::new(MessageType(0x0036), AckCode::OK) });
    assert_eq!(desk.hears(2, empty), (vec![], vec![Event::Failed(Token(7), Failure::Unclear)]));
}

/// D5-6, D-17, D-18
#[test]
fn an_answer_ends_its_request() {
    let moving = DeviceMessage::MotorMove(MotorMoving { moving: true.into(), tail: &[] });
    let inputs = DeviceMessage::GioIn(GioIn { triggers: Triggers(1), tail: &[] });
    for (message, answer) in [
        (move_to(1, 2), moving),
        (HostMessage::GioIn(EMPTY), inputs),
        (HostMessage::MotorGetPosition(EMPTY), positions()),
        (HostMessage::Hi(EMPTY), DeviceMessage::Hi(hi())),
    ] {
        let mut desk = Desk::up();
        desk.request(7, message);
        assert_eq!(desk.hears(2, answer), (vec![], vec![Event::Done(Token(7), Outcome::Answered)]));
    }
    let mut desk = Desk::up();
    desk.request(7, STATUS);
    assert_eq!(desk.status(2, 5), (vec![], vec![Event::Done(Token(7), Outcome::Answered)]));
    desk.request(8, HostMessage::MotorGetPosition(EMPTY));
    assert_eq!(desk.hears(0, positions()), (vec![], vec![Event::Unasked(MessageType(0x0034))]));
    assert_eq!(desk.acked(3, 0x0034, AckCode::OK), (vec![], vec![Event::Done(Token(8), Outcome::Acknowledged)]));
}

/// D5-7, D-14
#[test]
fn what_is_told_unasked_is_told_on_and_never_answered() {
    let mut desk = Desk::up();
    let inputs = DeviceMessage::GioIn(GioIn { triggers: Triggers(1), tail: &[] });
    for message in [inputs, positions(), DeviceMessage::RtGo(EMPTY), DeviceMessage::RtEnd(EMPTY)] {
        for id in [0, 99] {
            assert_eq!(desk.hears(id, message), (vec![], vec![Event::Unasked(message.kind())]));
        }
    }
    let unknown = DeviceMessage::other(0x0300, &[1]);
    assert_eq!(desk.hears(0, unknown), (vec![], vec![Event::Stray(MessageId(0), MessageType(0x0300))]));
    assert_eq!(desk.step(Input::Corrupt), (vec![], vec![Event::Unreadable]));
}

/// D5-8
#[test]
fn a_late_answer_is_stray() {
    let mut desk = Desk::up();
    desk.request(7, move_to(1, 2));
    assert_eq!(desk.pass(500), (vec![(3, named(7))], vec![]));
    let stray = |kind| vec![Event::Stray(MessageId(2), MessageType(kind))];
    assert_eq!(desk.acked(2, 0x0031, AckCode::OK), (vec![], stray(0x0031)));
    assert_eq!(desk.acked(2, 0x0031, AckCode::ERR_CHECKSUM), (vec![], stray(0x8031)));
    assert_eq!(desk.status(2, 0), (vec![], stray(0x0030)));
    assert_eq!(desk.acked(3, 0x0031, AckCode::OK), (vec![], vec![Event::Done(Token(7), Outcome::Acknowledged)]));
}

/// D5-9, D-46
#[test]
fn a_device_that_was_reset_is_greeted_again() {
    let mut desk = Desk::up();
    desk.request(7, move_to(1, 2));
    desk.request(8, STATUS);
    let failed = |token| Event::Failed(Token(token), Failure::DeviceReset);
    let (sent, events) = desk.hears(0, DeviceMessage::Hi(hi()));
    assert_eq!(sent, [(3, What::Greeting)]);
    assert_eq!(events, [Event::DeviceReset, failed(7), failed(8)]);
    assert_eq!((desk.machine.state(), desk.machine.device()), (State::Greeting, None));
    assert_eq!(desk.machine.is_loaded(), Some(false));
    assert_eq!(desk.hears(3, DeviceMessage::Hi(hi())), (vec![], vec![Event::Greeted]));
    desk.command(Command::Configured);
    desk.sequence(9, begin(1, 2));
    let (_, events) = desk.hears(0, DeviceMessage::Hi(hi()));
    assert_eq!(events, [Event::DeviceReset, failed(9)], "uploads too");
}

/// D5-10
#[test]
fn a_hard_stop_fails_all_that_moves() {
    let mut desk = Desk::up();
    desk.request(6, STATUS);
    desk.request(7, move_to(1, 2));
    desk.request(8, jog(1));
    desk.request(9, STATUS);
    let stop = HardStop { reason: StopReason::UPPER_LIMIT, motor: Some(Motor(2)), tail: &[] };
    let (sent, events) = desk.hears(0, DeviceMessage::MotorHardStop(stop));
    let failed = |token| Event::Failed(Token(token), Failure::HardStop);
    assert_eq!(sent, []);
    assert_eq!(events, [Event::HardStop(StopReason::UPPER_LIMIT, Some(Motor(2))), failed(7), failed(8)]);
    assert_eq!(desk.machine.state(), State::Up);
    assert_eq!(desk.status(2, 0).0, [(3, named(9))], "questions are still asked");
}

/// D5-11
#[test]
fn what_may_be_repeated_is_sent_three_times_under_new_ids() {
    let lights = Dmx { ramp: true.into(), start_channel: DmxChannel(1), values: &[1], tail: &[] };
    for message in [move_to(1, 2), STATUS, HostMessage::Dmx(lights)] {
        let mut desk = Desk::up();
        desk.request(7, message);
        assert_eq!(desk.pass(1499), (vec![(3, named(7)), (4, named(7))], vec![]));
        assert_eq!(desk.pass(1), (vec![], vec![Event::Failed(Token(7), Failure::Timeout)]));
        assert_eq!(desk.wake, None);
    }
}

/// D5-12, S-2
#[test]
fn what_must_not_be_repeated_fails_and_it_is_asked_what_moves() {
    for message in [jog(1), reset()] {
        let mut desk = Desk::up();
        desk.request(7, message);
        assert_eq!(desk.pass(499), (vec![], vec![]));
        let failed = vec![Event::Failed(Token(7), Failure::Timeout)];
        assert_eq!(desk.pass(1), (vec![(3, What::Status)], failed), "{message}");
        assert_eq!(desk.status(3, 4), (vec![], vec![Event::Moving(Motors(4))]));
        assert_eq!(desk.pass(60_000), (vec![], vec![]));
    }
}

/// D5-12
#[test]
fn one_question_is_enough() {
    let mut desk = Desk::up_with(Options::default().with_window(4), hi());
    desk.request(1, reset());
    desk.request(2, jog(1));
    let failed = |token| Event::Failed(Token(token), Failure::Timeout);
    assert_eq!(desk.pass(500), (vec![(4, What::Status)], vec![failed(1), failed(2)]));
}

#[test]
fn times_are_options_and_never_nothing() {
    let times = Times { greeting: 70, request: 0, stop: 30, pause: 20, travel: 50 };
    let mut desk = Desk::up_with(Options::default().with_times(times), hi());
    desk.request(1, jog(1));
    assert_eq!(desk.pass(1).1, [Event::Failed(Token(1), Failure::Timeout)]);
    desk.pass(60);
    desk.stop(Stop::All);
    assert_eq!(desk.wake, Some(desk.now.after(30)));
    let mut desk = Desk::of(Options::default().with_times(times));
    desk.step(Input::LinkUp);
    assert_eq!(desk.wake, Some(desk.now.after(70)));
    let mut desk = Desk::up_with(Options::default().with_times(Times { travel: 150, ..Times::default() }), hi());
    desk.sequence(2, position_frame(1));
    desk.acked(2, 0x0110, AckCode::OK);
    assert_eq!(desk.pass(150).1, [Event::Failed(Token(2), Failure::Timeout)]);
}

/// S-2
#[test]
fn what_must_not_be_repeated_is_a_short_list() {
    let body = [0; 700];
    let all = HostMessage::ALL.iter().map(|kind| Message::decode_body(kind.number, &body[..]).unwrap());
    let (mut never, mut stops, mut moves) = (vec![], vec![], vec![]);
    for message in all {
        let kind = message.kind().0;
        never.extend((!message.is_repeatable()).then_some(kind));
        stops.extend(message.is_stop().then_some(kind));
        moves.extend(message.starts_motion().then_some(kind));
    }
    assert_eq!(never, [0x0035, 0x0036, 0x0111, 0x0112, 0x0113, 0x0115, 0x0120, 0x0203, 0x0206]);
    assert_eq!(stops, [0x0032, 0x0033, 0x0202]);
    let jogs_and_runs = [0x0036, 0x0110, 0x0111, 0x0112, 0x0113, 0x0115, 0x0120, 0x0201, 0x0203, 0x0206, 0x0207];
    assert_eq!((moves[0], &moves[1..]), (0x0031, &jogs_and_runs[..]));
    let unknown = Message::other(0x0300, &[]);
    assert!(!unknown.is_repeatable() && unknown.starts_motion(), "it may do anything");
}

/// D5-13, S-3, D-8
#[test]
fn what_arrived_wrong_is_sent_again_after_a_pause() {
    let mut desk = Desk::up();
    desk.request(7, STATUS);
    for id in [2, 3] {
        assert_eq!(desk.acked(id, 0x1234, AckCode::ERR_CHECKSUM), (vec![], vec![]), "whatever type it has");
        assert_eq!(desk.pass(99), (vec![], vec![]));
        assert_eq!(desk.pass(1), (vec![(id + 1, named(7))], vec![]));
    }
    let failed = vec![Event::Failed(Token(7), Failure::Refused(AckCode::ERR_CHECKSUM))];
    assert_eq!(desk.acked(4, 0x0030, AckCode::ERR_CHECKSUM), (vec![], failed));
    desk.request(8, jog(1));
    let failed = vec![Event::Failed(Token(8), Failure::Refused(AckCode::ERR_CHECKSUM))];
    assert_eq!(desk.acked(5, 0x0036, AckCode::ERR_CHECKSUM), (vec![], failed), "a jog is never repeated");
    assert_eq!(desk.pass(60_000), (vec![], vec![]));
}

/// D5-13
#[test]
fn what_arrived_twice_and_wrong_once_is_done() {
    let mut desk = Desk::up();
    desk.request(7, STATUS);
    desk.acked(2, 0x0030, AckCode::ERR_CHECKSUM);
    let again = vec![Event::Stray(MessageId(2), MessageType(0x8030))];
    assert_eq!(desk.acked(2, 0x0030, AckCode::ERR_CHECKSUM), (vec![], again), "that is known");
    assert_eq!(desk.status(2, 0), (vec![], vec![Event::Done(Token(7), Outcome::Answered)]));
    assert_eq!(desk.pass(60_000), (vec![], vec![]));
}

/// D5-21
#[test]
fn what_the_device_would_refuse_is_not_sent() {
    let simple = Hi { capabilities: Capabilities(0), motor_count: 2, ..hi() };
    let refused = |code| vec![Event::Failed(Token(7), Failure::WouldBeRefused(code))];
    let mut desk = Desk::up_with(Options::default(), simple);
    assert_eq!(desk.request(7, jog(3)), (vec![], refused(AckCode::ERR_RANGE)));
    assert_eq!(desk.request(7, virtuals(&[0])), (vec![], refused(AckCode::ERR_UNSUPPORTED)));
    for message in [begin(1, 2), position_frame(1), run(1, 2, 0.into()), jog_all(2), shot(1)] {
        assert_eq!(desk.sequence(7, message), (vec![], refused(AckCode::ERR_UNSUPPORTED)));
        assert_eq!(desk.machine.progress(), None);
    }
    assert_eq!(desk.request(7, Message::other(0x0300, &[])), (vec![], refused(AckCode::ERR_UNSUPPORTED)));
    let mut desk = Desk::up_with(Options::default().without_gates(), simple);
    assert_eq!(desk.request(7, jog(3)), (vec![(2, named(7))], vec![]));
    let ack = Message::other(0x8036, &[]);
    assert_eq!(desk.request(8, ack), (vec![], vec![Event::Failed(Token(8), Failure::Sequence)]));
}

/// D-63
#[test]
fn what_belongs_to_a_sequence_is_not_sent_alone() {
    let mut desk = Desk::up();
    let (end, go) = (HostMessage::RtUploadMoveEnd(EMPTY), HostMessage::RtGo(EMPTY));
    for message in [begin(1, 2), axis(1), end, position_frame(1), run(1, 2, 0.into()), jog_all(2), shot(1), go] {
        assert_eq!(desk.request(7, message), (vec![], vec![Event::Failed(Token(7), Failure::Sequence)]));
    }
    for message in [jog(1), axis(1), STATUS] {
        assert_eq!(desk.sequence(7, message), (vec![], vec![Event::Failed(Token(7), Failure::Sequence)]));
    }
    assert_eq!(desk.command(Command::Go), (vec![], vec![Event::Ignored]));
    assert_eq!(desk.step(Input::Section(None)), (vec![], vec![Event::Ignored]));
}

/// D-64
#[test]
fn requests_wait_for_their_turn_and_motion_for_motion() {
    let mut desk = Desk::up();
    assert_eq!(desk.request(0, STATUS).0.len(), 1);
    for token in 1..=8 {
        assert_eq!(desk.request(token, STATUS), (vec![], vec![]));
    }
    assert_eq!(desk.request(9, STATUS), (vec![], vec![Event::Failed(Token(9), Failure::Busy)]));
    for id in 2..=9 {
        let done = vec![Event::Done(Token(id - 2), Outcome::Answered)];
        assert_eq!(desk.status(id, 0), (vec![(id + 1, named(id - 1))], done), "in their order");
    }
    let mut desk = Desk::up_with(Options::default().with_window(9), hi());
    assert_eq!(desk.request(1, move_to(1, 1)).0.len(), 1);
    assert_eq!(desk.request(2, STATUS).0.len(), 1, "a window of four");
    assert_eq!(desk.request(3, move_to(2, 1)), (vec![], vec![]), "one motion at a time");
    assert_eq!(desk.request(4, STATUS), (vec![], vec![]), "nothing overtakes");
    assert_eq!(desk.acked(2, 0x0031, AckCode::OK).0, [(4, named(3)), (5, named(4))]);
}

#[test]
fn ids_come_round() {
    let mut desk = Desk::up_with(Options::default().with_last_id(3), hi());
    let mut ids = vec![];
    for _ in 0..130 {
        let (sent, _) = desk.request(1, STATUS);
        desk.status(sent[0].0, 0);
        ids.push(sent[0].0);
    }
    assert_eq!((ids[0], ids[62], ids[63], ids.iter().max(), ids.iter().min()), (2, 64, 1, Some(&64), Some(&1)));
}

#[test]
fn without_a_line_all_fails() {
    let mut desk = Desk::up();
    desk.request(7, move_to(1, 2));
    desk.request(8, STATUS);
    desk.sequence(9, begin(1, 2));
    let failed = |token| Event::Failed(Token(token), Failure::NotUp);
    assert_eq!(desk.step(Input::LinkDown), (vec![], vec![Event::Closed, failed(7), failed(8), failed(9)]));
    assert_eq!((desk.machine.state(), desk.wake), (State::Closed, None));
    assert_eq!(desk.step(Input::LinkDown), (vec![], vec![]));
    let stray = vec![Event::Stray(MessageId(2), MessageType(0x0030))];
    assert_eq!(desk.status(2, 0), (vec![], stray));
    desk.step(Input::LinkUp);
    assert_eq!(desk.step(Input::LinkUp).1, [Event::Closed], "opened anew");
}

#[test]
fn a_stop_by_request_is_a_stop() {
    let mut desk = Desk::up();
    desk.request(1, STATUS);
    for (token, message, what) in [(2, stop(3), Stop::Motor(Motor(3))), (3, stop_all(), Stop::All)] {
        let (sent, events) = desk.request(token, message);
        assert_eq!(sent.iter().map(|&(_, what)| what).collect::<Vec<_>>(), [What::Stop(what)]);
        assert_eq!(events, [Event::Done(Token(token), Outcome::TakenAsStop)]);
    }
}
