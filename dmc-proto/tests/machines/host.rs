//! Host: connection and requests. DMC D5.

use dmc_proto::host::{Command, Contents, Event, Failure, Input, Options, Outcome, Refusal, State, StopTarget};
use dmc_proto::message::{
    Ack, AckCode, CameraFlags, Capabilities, Dmx, DmxChannel, GioCam, GioIn, GioInRequest, HardStop, Hi, HiRequest,
    HostMessage, Motor, MotorConfigure, MotorFlags, MotorGetPosition, MotorMoving, MotorPair, MotorPositions,
    MotorResetPosition, MotorStatusRequest, Motors, RtEnd, RtGo, RtShootFrame, RtUploadMoveEnd, RunFlags, Steps,
    StopReason, Triggers,
};
use dmc_proto::upload::{Section, SectionSize};
use dmc_proto::{DeviceMessage, HostMessage as Message, MessageId, MessageType, Millis, Token};
use motion_core::wire::Messages;

use super::app::Tens;
use super::bench::{
    COMMAND, Desk, ack, answered, axis, begin, done, ended, failed, frame, hi, jog, jog_all, move_to, named,
    not_confirmed, position_frame, refused, run, shot, status, stop, stop_all, virtuals,
};
use super::world::device_message;

fn ask_status() -> HostMessage<'static> {
    MotorStatusRequest::default().into()
}

fn reset() -> HostMessage<'static> {
    HostMessage::from(MotorResetPosition { motor: Motor(1), position: Steps(7), tail: &[] })
}

fn positions() -> DeviceMessage<'static> {
    DeviceMessage::from(MotorPositions {
        move_time: dmc_proto::message::MoveTime::default(),
        positions: &[],
        tail: &[],
    })
}

/// D5-1, D-48
#[test]
fn a_host_greets_when_the_link_is_open() {
    let mut desk = Desk::new();
    assert_eq!((desk.machine.state(), desk.wake), (State::Offline, None));
    assert_eq!(desk.request(1, ask_status()), (vec![], vec![refused(1, Refusal::NotConnected)]));
    assert_eq!(desk.step(Input::LinkUp), (vec![(1, Contents::Greeting)], vec![]));
    assert_eq!((desk.machine.state(), desk.wake), (State::Greeting, Some(Millis(2000))));
}

/// D5-2
#[test]
fn a_greeting_of_the_device_is_reported() {
    for id in [0, 1] {
        let mut desk = Desk::new();
        desk.step(Input::LinkUp);
        let malformed = (MessageId(1), MessageType(1));
        let told = (vec![], vec![Event::Malformed(malformed.0, malformed.1)]);
        assert_eq!(desk.step(Input::Malformed(malformed.0, malformed.1)), told);
        assert_eq!(desk.receives(id, hi().into()), (vec![], vec![Event::Greeted(hi())]));
        assert_eq!((desk.machine.state(), desk.wake), (State::Configuring, None));
        assert_eq!(desk.machine.device(), Some(hi()));
        assert_eq!(desk.machine.is_loaded(), (id == 0).then_some(false), "a device at boot has no move");
    }
}

/// D5-3, D-71
#[test]
fn a_silent_device_is_greeted_five_times() {
    let mut desk = Desk::new();
    desk.step(Input::LinkUp);
    let greetings: Vec<_> = (2..=5).map(|id| (id, Contents::Greeting)).collect();
    assert_eq!(desk.pass(999), (vec![], vec![]));
    assert_eq!(desk.padding, 0);
    assert_eq!(desk.pass(4000), (greetings, vec![]));
    assert_eq!(desk.padding, 4 * 2048, "before each further greeting");
    assert_eq!(desk.pass(1), (vec![], vec![Event::Silent]));
    assert_eq!((desk.machine.state(), desk.wake), (State::Silent, None));
    let mut other = desk.clone();
    assert_eq!(desk.command(Command::Greet), (vec![(6, Contents::Greeting)], vec![]));
    assert_eq!(desk.padding, 5 * 2048);
    assert_eq!(desk.machine.state(), State::Greeting);
    assert_eq!(
        desk.command(Command::Greet),
        (vec![], vec![refused(COMMAND.0, Refusal::Unexpected)]),
        "it is on its way"
    );
    assert_eq!(other.receives(0, hi().into()), (vec![], vec![Event::Greeted(hi())]), "the device has booted");
    // A stop waits for the zero bytes that are on their way: on a slow line there are few.
    for (timeout, len) in [(1000, 240), (100, 96)] {
        let options = Options::default().with_line_speed(9600).with_greeting_timeout(timeout);
        let mut desk = Desk::of(options);
        desk.step(Input::LinkUp);
        desk.pass(timeout.into());
        assert_eq!(desk.padding, len, "as many as the line carries in 250 ms, and until the next greeting");
    }
}

/// D5-4
#[test]
fn nothing_that_moves_is_sent_before_the_configuration() {
    let mut desk = Desk::new();
    desk.step(Input::LinkUp);
    desk.receives(1, hi().into());
    for message in [move_to(1, 2), jog(1)] {
        assert_eq!(desk.request(1, message), (vec![], vec![refused(1, Refusal::NotReady)]));
    }
    assert_eq!(desk.sequence(1, begin(1, 2)), (vec![], vec![refused(1, Refusal::NotReady)]));
    assert_eq!(desk.request(2, reset()), (vec![(2, named(2))], vec![]));
    assert_eq!(desk.command(Command::Configured), (vec![], vec![]));
    assert_eq!(desk.machine.state(), State::Configuring);
    let told = vec![done(2), Event::Ready { reconnected: false }];
    assert_eq!(desk.acked(2, 0x0035, AckCode::OK), (vec![], told));
    assert_eq!(desk.machine.state(), State::Ready);
    assert_eq!(desk.command(Command::Configured), (vec![], vec![refused(COMMAND.0, Refusal::Unexpected)]));
}

/// D5-5
#[test]
fn an_acknowledgement_ends_its_request() {
    for (code, event) in [
        (AckCode::OK, done(7)),
        (AckCode::ERR_RANGE, refused(7, Refusal::Device(AckCode::ERR_RANGE))),
        (AckCode(99), refused(7, Refusal::Device(AckCode(99)))),
    ] {
        let mut desk = Desk::up();
        assert_eq!(desk.request(7, jog(1)), (vec![(2, named(7))], vec![]));
        let other = desk.acked(2, 0x0037, code);
        assert_eq!(
            other,
            (vec![], vec![Event::Unsolicited(MessageId(2), ack(0x0037, code))]),
            "an acknowledgement of another type"
        );
        assert_eq!(desk.acked(2, 0x0036, code), (vec![], vec![event]));
        assert_eq!(desk.wake, None);
    }
    let mut desk = Desk::up();
    desk.request(7, jog(1));
    let empty = DeviceMessage::from(Ack { response_code: None, ..Ack::new(MessageType(0x0036), AckCode::OK) });
    assert_eq!(desk.receives(2, empty), (vec![], vec![not_confirmed(7)]));
}

/// D5-6, D-17, D-18
#[test]
fn an_answer_ends_its_request() {
    let moving = DeviceMessage::from(MotorMoving { moving: true.into(), tail: &[] });
    let inputs = DeviceMessage::from(GioIn { triggers: Triggers(1), tail: &[] });
    for (message, answer) in [
        (move_to(1, 2), moving),
        (HostMessage::from(GioInRequest::default()), inputs),
        (HostMessage::from(MotorGetPosition::default()), positions()),
        (HostMessage::from(HiRequest::default()), hi().into()),
    ] {
        let mut desk = Desk::up();
        desk.request(7, message);
        assert_eq!(desk.receives(2, answer), (vec![], vec![answered(7, answer)]));
    }
    let mut desk = Desk::up();
    desk.request(7, ask_status());
    assert_eq!(desk.status(2, 5), (vec![], vec![answered(7, status(5))]));
    desk.request(8, HostMessage::from(MotorGetPosition::default()));
    assert_eq!(desk.receives(0, positions()), (vec![], vec![Event::Unsolicited(MessageId(0), positions())]));
    assert_eq!(desk.acked(3, 0x0034, AckCode::OK), (vec![], vec![done(8)]));
}

/// D5-7, D-14
#[test]
fn an_unsolicited_message_is_reported_and_never_answered() {
    let mut desk = Desk::up();
    let inputs = DeviceMessage::from(GioIn { triggers: Triggers(1), tail: &[] });
    for message in [inputs, positions(), DeviceMessage::from(RtGo::default()), DeviceMessage::from(RtEnd::default())] {
        for id in [0, 99] {
            assert_eq!(desk.receives(id, message), (vec![], vec![Event::Unsolicited(MessageId(id), message)]));
        }
    }
    let unknown = DeviceMessage::other(0x0300, &[1]);
    assert_eq!(desk.receives(0, unknown), (vec![], vec![Event::Unsolicited(MessageId(0), unknown)]));
    assert_eq!(desk.step(Input::Corrupt), (vec![], vec![Event::Corrupt]));
}

/// D5-8
#[test]
fn a_late_answer_is_unsolicited() {
    let mut desk = Desk::up();
    desk.request(7, move_to(1, 2));
    desk.acked(2, 0x0031, AckCode::OK);
    desk.request(8, move_to(1, 3));
    for late in [ack(0x0031, AckCode::OK), ack(0x0031, AckCode::ERR_CHECKSUM), status(0)] {
        assert_eq!(desk.receives(2, late), (vec![], vec![Event::Unsolicited(MessageId(2), late)]));
    }
    assert_eq!(desk.acked(3, 0x0031, AckCode::OK), (vec![], vec![done(8)]));
}

/// D-74
#[test]
fn an_answer_to_an_earlier_try_ends_a_request() {
    for (late, end) in [
        (ack(0x0031, AckCode::OK), done(7)),
        (ack(0x0031, AckCode::ERR_RANGE), refused(7, Refusal::Device(AckCode::ERR_RANGE))),
    ] {
        for id in [2, 3, 4] {
            let mut desk = Desk::up();
            desk.request(7, move_to(1, 2));
            assert_eq!(desk.pass(1000), (vec![(3, named(7)), (4, named(7))], vec![]));
            let other = vec![Event::Unsolicited(MessageId(id), ack(0x0036, AckCode::OK))];
            assert_eq!(desk.acked(id, 0x0036, AckCode::OK), (vec![], other), "of another type");
            assert_eq!(desk.receives(id, late), (vec![], vec![end]), "try {id}");
            assert_eq!(desk.pass(60_000), (vec![], vec![]), "it is not sent again");
        }
    }
    // An earlier try that arrived damaged: the last one is still under way.
    let mut desk = Desk::up();
    desk.request(7, ask_status());
    desk.pass(500);
    assert_eq!(desk.acked(2, 0x0030, AckCode::ERR_CHECKSUM), (vec![], vec![]));
    assert_eq!(desk.pass(499), (vec![], vec![]));
    assert_eq!(desk.status(3, 0), (vec![], vec![answered(7, status(0))]));
}

/// D5-9, D-46
#[test]
fn a_device_that_was_reset_is_greeted_again() {
    let mut desk = Desk::up();
    desk.request(7, move_to(1, 2));
    desk.request(8, ask_status());
    let gone = |token| failed(token, Failure::DeviceReset);
    let (sent, events) = desk.receives(0, hi().into());
    assert_eq!(sent, [(3, Contents::Greeting)]);
    assert_eq!(events, [Event::DeviceReset, gone(7), gone(8)]);
    assert_eq!((desk.machine.state(), desk.machine.device()), (State::Greeting, None));
    assert_eq!(desk.machine.is_loaded(), Some(false));
    assert_eq!(desk.receives(3, hi().into()), (vec![], vec![Event::Greeted(hi())]));
    let again = vec![Event::Ready { reconnected: true }];
    assert_eq!(desk.command(Command::Configured), (vec![], again));
    desk.sequence(9, begin(1, 2));
    let (_, events) = desk.receives(0, hi().into());
    assert_eq!(events, [Event::DeviceReset, gone(9)], "an upload ends too");
}

/// D5-10
#[test]
fn a_hard_stop_ends_everything_that_moves() {
    let mut desk = Desk::up();
    desk.request(6, ask_status());
    desk.request(7, move_to(1, 2));
    desk.request(8, jog(1));
    desk.request(9, ask_status());
    let stop = HardStop { reason: StopReason::UPPER_LIMIT, motor: Some(Motor(2)), tail: &[] };
    let (sent, events) = desk.receives(0, stop.into());
    let gone = |token| failed(token, Failure::HardStop);
    assert_eq!(sent, []);
    assert_eq!(events, [Event::HardStop(StopReason::UPPER_LIMIT, Some(Motor(2))), gone(7), gone(8)]);
    assert_eq!(desk.machine.state(), State::Ready);
    assert_eq!(desk.status(2, 0).0, [(3, named(9))], "a question is still sent");
}

/// D5-11
#[test]
fn a_repeatable_request_is_sent_three_times_with_new_ids() {
    let lights = Dmx { ramp: true.into(), start_channel: DmxChannel(1), values: &[1], tail: &[] };
    for (message, end) in [
        (move_to(1, 2), not_confirmed(7)),
        (lights.into(), not_confirmed(7)),
        (ask_status(), failed(7, Failure::NoAnswer)),
    ] {
        let mut desk = Desk::up();
        desk.request(7, message);
        assert_eq!(desk.pass(1499), (vec![(3, named(7)), (4, named(7))], vec![]));
        assert_eq!(desk.pass(1), (vec![], vec![end]));
        assert_eq!(desk.wake, None);
    }
}

/// D5-12, S-2
#[test]
fn a_request_that_is_not_repeatable_is_sent_once_and_a_question_follows() {
    for message in [jog(1), reset()] {
        let mut desk = Desk::up();
        desk.request(7, message);
        assert_eq!(desk.pass(499), (vec![], vec![]));
        let unclear = vec![not_confirmed(7)];
        assert_eq!(desk.pass(1), (vec![(3, Contents::Status)], unclear), "{message}");
        assert_eq!(desk.status(3, 4), (vec![], vec![Event::Moving(Motors(4))]));
        assert_eq!(desk.pass(60_000), (vec![], vec![]));
    }
}

/// D5-12
#[test]
fn one_question_at_a_time_is_asked() {
    let mut desk = Desk::up_with(Options::default().with_window(4), hi());
    desk.request(1, reset());
    desk.request(2, jog(1));
    assert_eq!(desk.pass(500), (vec![(4, Contents::Status)], vec![not_confirmed(1), not_confirmed(2)]));
}

#[test]
fn times_are_options_and_never_zero() {
    let options = Options::new().with_greeting_timeout(70).with_request_timeout(0).with_stop_timeout(30);
    let mut desk = Desk::up_with(options, hi());
    desk.request(1, jog(1));
    assert_eq!(desk.pass(1).1, [not_confirmed(1)]);
    desk.pass(60);
    desk.stop(StopTarget::All);
    assert_eq!(desk.wake, Some(desk.now.after(30)));
    let mut desk = Desk::of(options);
    desk.step(Input::LinkUp);
    assert_eq!(desk.wake, Some(desk.now.after(70)));
    let mut desk = Desk::up_with(Options::new().with_travel_timeout(150), hi());
    desk.sequence(2, position_frame(1));
    desk.acked(2, 0x0110, AckCode::OK);
    assert_eq!(desk.pass(150).1, [not_confirmed(2)]);
}

/// D5-13, S-3, D-8
#[test]
fn a_request_that_arrived_damaged_is_sent_again_after_a_pause() {
    let mut desk = Desk::up();
    desk.request(7, ask_status());
    for id in [2, 3] {
        assert_eq!(desk.acked(id, 0x1234, AckCode::ERR_CHECKSUM), (vec![], vec![]), "the type may be damaged");
        assert_eq!(desk.pass(99), (vec![], vec![]));
        assert_eq!(desk.pass(1), (vec![(id + 1, named(7))], vec![]));
    }
    let damaged = |token| vec![refused(token, Refusal::Device(AckCode::ERR_CHECKSUM))];
    assert_eq!(desk.acked(4, 0x0030, AckCode::ERR_CHECKSUM), (vec![], damaged(7)));
    desk.request(8, jog(1));
    assert_eq!(desk.acked(5, 0x0036, AckCode::ERR_CHECKSUM), (vec![], damaged(8)), "a jog is never repeated");
    assert_eq!(desk.pass(60_000), (vec![], vec![]));
}

/// D5-13
#[test]
fn a_request_that_arrived_once_damaged_and_once_undamaged_is_done() {
    let mut desk = Desk::up();
    desk.request(7, ask_status());
    desk.acked(2, 0x0030, AckCode::ERR_CHECKSUM);
    let again = vec![Event::Unsolicited(MessageId(2), ack(0x0030, AckCode::ERR_CHECKSUM))];
    assert_eq!(
        desk.acked(2, 0x0030, AckCode::ERR_CHECKSUM),
        (vec![], again),
        "an acknowledgement of a request that waits for its next try"
    );
    assert_eq!(desk.status(2, 0), (vec![], vec![answered(7, status(0))]));
    assert_eq!(desk.pass(60_000), (vec![], vec![]));
}

/// D5-21
#[test]
fn a_request_that_the_device_would_refuse_is_not_sent() {
    let simple = Hi { capabilities: Capabilities(0), motor_count: 2, ..hi() };
    let refused_by = |code| vec![refused(7, Refusal::WouldBeRefused(code))];
    let mut desk = Desk::up_with(Options::default(), simple);
    assert_eq!(desk.request(7, jog(3)), (vec![], refused_by(AckCode::ERR_RANGE)));
    assert_eq!(desk.request(7, virtuals(&[0])), (vec![], refused_by(AckCode::ERR_UNSUPPORTED)));
    for message in [begin(1, 2), position_frame(1), run(1, 2, 0.into()), jog_all(2), shot(1)] {
        assert_eq!(desk.sequence(7, message), (vec![], refused_by(AckCode::ERR_UNSUPPORTED)));
        assert_eq!(desk.machine.progress(), None);
    }
    assert_eq!(desk.request(7, Message::other(0x0300, &[])), (vec![], refused_by(AckCode::ERR_UNSUPPORTED)));
    let mut desk = Desk::up_with(Options::new().with_gates(false), simple);
    assert_eq!(desk.request(7, jog(3)), (vec![(2, named(7))], vec![]));
    let ack = Message::other(0x8036, &[]);
    assert_eq!(desk.request(8, ack), (vec![], vec![refused(8, Refusal::Misplaced)]));
}

/// D-63
#[test]
fn a_message_of_a_sequence_is_not_sent_alone() {
    let mut desk = Desk::up();
    let (end, go) = (RtUploadMoveEnd::default().into(), RtGo::default().into());
    for message in [begin(1, 2), axis(1), end, position_frame(1), run(1, 2, 0.into()), jog_all(2), shot(1), go] {
        assert_eq!(desk.request(7, message), (vec![], vec![refused(7, Refusal::Misplaced)]));
    }
    for message in [jog(1), axis(1), ask_status()] {
        assert_eq!(desk.sequence(7, message), (vec![], vec![refused(7, Refusal::Misplaced)]));
    }
    assert_eq!(desk.command(Command::Go), (vec![], vec![refused(COMMAND.0, Refusal::Unexpected)]));
    assert_eq!(desk.step(Input::Section(None)), (vec![], vec![Event::SectionNotWanted]));
}

/// D-64
#[test]
fn requests_wait_in_order_and_only_one_may_move() {
    let mut desk = Desk::up();
    assert_eq!(desk.request(0, ask_status()).0.len(), 1);
    for token in 1..=8 {
        assert_eq!(desk.request(token, ask_status()), (vec![], vec![]));
    }
    assert_eq!(desk.request(9, ask_status()), (vec![], vec![refused(9, Refusal::Busy)]));
    for id in 2..=9 {
        let told = vec![answered(id - 2, status(0))];
        assert_eq!(desk.status(id, 0), (vec![(id + 1, named(id - 1))], told), "requests are sent in order");
    }
    let mut desk = Desk::up_with(Options::default().with_window(9), hi());
    assert_eq!(desk.request(1, move_to(1, 1)).0.len(), 1);
    assert_eq!(desk.request(2, ask_status()).0.len(), 1, "four requests may be under way");
    assert_eq!(desk.request(3, move_to(2, 1)), (vec![], vec![]), "one request that may move is under way at a time");
    assert_eq!(desk.request(4, ask_status()), (vec![], vec![]), "no request overtakes another one");
    assert_eq!(desk.acked(2, 0x0031, AckCode::OK).0, [(4, named(3)), (5, named(4))]);
}

#[test]
fn ids_begin_again_after_the_last_one() {
    let mut desk = Desk::new();
    desk.machine = desk.machine.with_last_id(3);
    desk.becomes_ready(1, hi());
    let mut ids = vec![];
    for _ in 0..130 {
        let (sent, _) = desk.request(1, ask_status());
        desk.status(sent[0].0, 0);
        ids.push(sent[0].0);
    }
    assert_eq!((ids[0], ids[62], ids[63], ids.iter().max(), ids.iter().min()), (2, 64, 1, Some(&64), Some(&1)));
}

#[test]
fn without_a_link_every_command_fails() {
    let mut desk = Desk::up();
    desk.request(7, move_to(1, 2));
    desk.request(8, ask_status());
    desk.sequence(9, begin(1, 2));
    let gone = |token| failed(token, Failure::LinkDown);
    assert_eq!(desk.step(Input::LinkDown), (vec![], vec![Event::LinkDown, gone(7), gone(8), gone(9)]));
    assert_eq!((desk.machine.state(), desk.wake), (State::Offline, None));
    assert_eq!(desk.step(Input::LinkDown), (vec![], vec![]));
    let late = vec![Event::Unsolicited(MessageId(2), status(0))];
    assert_eq!(desk.status(2, 0), (vec![], late));
    desk.step(Input::LinkUp);
    assert_eq!(desk.step(Input::LinkUp).1, [Event::LinkDown], "the link before counts as gone");
}

#[test]
fn a_stop_by_request_is_a_stop() {
    let mut desk = Desk::up();
    desk.request(1, ask_status());
    for (token, message, what) in [(2, stop(3), StopTarget::Motor(Motor(3))), (3, stop_all(), StopTarget::All)] {
        let (sent, events) = desk.request(token, message);
        assert_eq!(sent.iter().map(|&(_, what)| what).collect::<Vec<_>>(), [Contents::Stop(what)]);
        assert_eq!(events, [ended(token, Outcome::Sent)]);
        let (sent, events) = desk.sequence(token, message);
        assert_eq!(
            (sent[0].1, &events[..]),
            (Contents::Stop(what), &[ended(token, Outcome::Sent)][..]),
            "a stop in a sequence is a stop too"
        );
    }
}

/// Each command ends exactly once, in every state of the machine.
#[test]
fn a_command_that_does_not_fit_is_refused() {
    let outcomes = |desk: &Desk| {
        [Command::Greet, Command::Configured, Command::Go, Command::EndStops].map(|command| {
            let (_, events) = desk.clone().step(Input::Command(Token(5), command));
            let ends: Vec<_> = events.into_iter().filter(|event| matches!(event, Event::Ended { .. })).collect();
            let [Event::Ended { token: Token(5), outcome }] = ends[..] else { panic!("{ends:?}") };
            outcome
        })
    };
    let refused = Outcome::Refused;
    let mut desk = Desk::new();
    let not_connected = refused(Refusal::NotConnected);
    assert_eq!(outcomes(&desk), [not_connected, not_connected, not_connected, Outcome::Done(None)]);
    desk.step(Input::LinkUp);
    let (not_ready, unexpected) = (refused(Refusal::NotReady), refused(Refusal::Unexpected));
    assert_eq!(outcomes(&desk), [unexpected, not_ready, not_ready, Outcome::Done(None)]);
    let mut silent = desk.clone();
    silent.pass(5000);
    assert_eq!(outcomes(&silent), [Outcome::Sent, not_ready, not_ready, Outcome::Done(None)]);
    desk.receives(1, hi().into());
    assert_eq!(outcomes(&desk), [unexpected, Outcome::Done(None), not_ready, Outcome::Done(None)]);
    let desk = Desk::up();
    assert_eq!(outcomes(&desk), [unexpected, unexpected, unexpected, Outcome::Done(None)]);
}

#[test]
fn a_shutter_that_a_request_opened_counts_as_open_until_it_is_closed() {
    let camera = |flags| HostMessage::from(GioCam { flags, tail: &[] });
    let mut desk = Desk::up();
    desk.request(1, camera(CameraFlags::METER));
    desk.acked(2, 0x0023, AckCode::OK);
    assert!(!desk.machine.may_have_shutter_open());
    desk.request(2, camera(CameraFlags::SHUTTER));
    assert!(desk.machine.may_have_shutter_open() && !desk.machine.may_move());
    desk.pass(1500);
    assert!(desk.machine.may_have_shutter_open(), "no answer came");
    desk.request(3, camera(CameraFlags::empty()));
    assert!(desk.machine.may_have_shutter_open(), "the request to close it is not answered");
    desk.acked(6, 0x0023, AckCode::OK);
    assert!(!desk.machine.may_have_shutter_open());
    desk.request(4, camera(CameraFlags::SHUTTER));
    desk.acked(7, 0x0023, AckCode::ERR_UNSUPPORTED);
    assert!(!desk.machine.may_have_shutter_open(), "the device refused to open it");
}

/// D-86
#[test]
fn a_shot_that_was_broken_off_may_leave_the_shutter_open() {
    let close = HostMessage::from(GioCam { flags: CameraFlags::empty(), tail: &[] });
    let stop = |desk: &mut Desk| drop(desk.stop(StopTarget::All));
    let hard = |desk: &mut Desk| {
        let stop = HardStop { reason: StopReason::EMERGENCY_STOP, motor: None, tail: &[] };
        desk.receives(0, stop.into());
    };
    for breaks_off in [stop as fn(&mut Desk), hard] {
        let mut desk = Desk::up();
        desk.sequence(1, shot(3));
        desk.acked(2, 0x0115, AckCode::OK);
        assert!(!desk.machine.may_have_shutter_open());
        breaks_off(&mut desk);
        assert!(desk.machine.may_have_shutter_open());
        let id = desk.request(3, close).0[0].0;
        assert!(desk.machine.may_have_shutter_open(), "nobody knows yet");
        desk.acked(id, 0x0023, AckCode::OK);
        assert!(!desk.machine.may_have_shutter_open());
    }
    // A device that refuses the shot takes no photo, and one that is on its way to the frame takes none yet.
    let mut desk = Desk::up();
    desk.sequence(1, shot(3));
    desk.acked(2, 0x0115, AckCode::ERR_GENERAL);
    assert!(!desk.machine.may_have_shutter_open());
    // A device that refuses the signal to start may have started already.
    let mut desk = Desk::up();
    desk.sequence(1, shot(3));
    desk.acked(2, 0x0115, AckCode::OK);
    for id in [3, 4] {
        assert_eq!(desk.pass(100).0, [(id, Contents::Status)]);
        desk.status(id, 0);
    }
    assert_eq!(desk.command(Command::Go).0, [(5, Contents::Go)]);
    for id in 5..8 {
        assert_eq!(desk.acked(id, 0x0113, AckCode::ERR_NOT_IN_POSITION), (vec![], vec![]));
        assert_eq!(desk.pass(100).0, [(id + 1, Contents::Go)]);
    }
    let end = Refusal::Device(AckCode::ERR_NOT_IN_POSITION);
    assert_eq!(desk.acked(8, 0x0113, AckCode::ERR_NOT_IN_POSITION).1, [refused(1, end), refused(COMMAND.0, end)]);
    assert!(desk.machine.may_have_shutter_open() && desk.machine.is_armed());
}

#[test]
fn an_event_can_be_kept_unless_it_lends_a_message() {
    let mut desk = Desk::up();
    desk.request(1, ask_status());
    let bytes = [0_u8; 6];
    let message = device_message(0x0030, &bytes).unwrap();
    let (_, events) = desk.receives(2, message);
    assert_eq!(events, [answered(1, message)]);
    assert_eq!(events[0].to_static(), None);
    let late = desk.receives(2, message).1;
    assert_eq!((late[0], late[0].to_static()), (Event::Unsolicited(MessageId(2), message), None));
    for event in [done(1), failed(1, Failure::NoAnswer), Event::Greeted(hi()), Event::Stopped(StopTarget::All)] {
        assert_eq!(event.to_static(), Some(event));
    }
}

/// D-76
#[test]
fn a_motor_that_was_not_enabled_is_not_moved() {
    let configure = |motor, flags| HostMessage::from(MotorConfigure { motor: Motor(motor), flags, tail: &[] });
    let lacks = |token, motor, flags| vec![refused(token, Refusal::NotConfigured(Motor(motor), flags))];
    let enabled = MotorFlags::ENABLED;
    let mut desk = Desk::of(Options::default());
    desk.becomes_ready(1, hi());
    for message in [move_to(2, 5), jog(2)] {
        assert_eq!(desk.request(7, message), (vec![], lacks(7, 2, enabled)));
    }
    assert_eq!(desk.request(1, configure(2, enabled)).0, [(2, named(1))]);
    assert_eq!(desk.request(7, jog(2)), (vec![], lacks(7, 2, enabled)), "nobody knows yet");
    desk.acked(2, 0x0037, AckCode::OK);
    assert_eq!(desk.request(7, jog(1)), (vec![], lacks(7, 1, enabled)), "another motor");
    assert_eq!(desk.request(2, jog(2)).0, [(3, named(2))]);
    desk.acked(3, 0x0036, AckCode::OK);
    // The device refuses: the motor is not enabled. A device without such a message uses all motors.
    desk.request(1, configure(2, enabled));
    desk.acked(4, 0x0037, AckCode::ERR_HARD_LOW);
    assert_eq!(desk.request(7, jog(2)), (vec![], lacks(7, 2, enabled)));
    desk.request(1, configure(2, enabled));
    desk.acked(5, 0x0037, AckCode::ERR_UNSUPPORTED);
    assert_eq!(desk.request(2, jog(2)).0, [(6, named(2))]);
    desk.acked(6, 0x0036, AckCode::OK);
    desk.request(1, configure(2, MotorFlags::LIVE));
    desk.acked(7, 0x0037, AckCode::OK);
    assert_eq!(desk.request(7, jog(2)), (vec![], lacks(7, 2, enabled)), "it is disabled again");
    // The device was reset.
    desk.request(1, configure(2, enabled));
    desk.acked(8, 0x0037, AckCode::OK);
    desk.receives(0, hi().into());
    desk.receives(9, hi().into());
    desk.command(Command::Configured);
    assert_eq!(desk.request(7, jog(2)), (vec![], lacks(7, 2, enabled)));
}

/// D-76
#[test]
fn of_two_configurations_of_a_motor_the_last_one_counts() {
    let configure = |flags| HostMessage::from(MotorConfigure { motor: Motor(2), flags, tail: &[] });
    let unknown = vec![refused(7, Refusal::NotConfigured(Motor(2), MotorFlags::ENABLED))];
    for window in [1, 4] {
        let mut desk = Desk::of(Options::default().with_window(window));
        desk.becomes_ready(1, hi());
        desk.request(1, configure(MotorFlags::ENABLED));
        let last = configure(MotorFlags::empty());
        assert_eq!(desk.request(2, last), (vec![], vec![]), "a copy of the first one could come after it");
        assert_eq!(desk.acked(2, 0x0037, AckCode::OK), (vec![(3, named(2))], vec![done(1)]));
        assert_eq!(desk.request(7, jog(2)), (vec![], unknown.clone()));
        desk.acked(3, 0x0037, AckCode::OK);
        assert_eq!(desk.request(7, jog(2)), (vec![], unknown.clone()), "it is disabled");
    }
}

/// D-84
#[test]
fn the_motors_of_a_run_stay_the_same_until_it_is_over() {
    let configure = |motor, flags| HostMessage::from(MotorConfigure { motor: Motor(motor), flags, tail: &[] });
    let (disabled, enabled) = (MotorFlags::empty(), MotorFlags::ENABLED);
    let mut desk = Desk::of(Options::default());
    desk.becomes_ready(1, Hi { motor_count: 3, ..hi() });
    desk.sequence(1, begin(1, 10));
    desk.acked(2, 0x0100, AckCode::OK);
    desk.step(Input::Section(Section::first(&Tens, SectionSize::default())));
    desk.acked(3, 0x0101, AckCode::OK);
    desk.step(Input::Section(None));
    desk.acked(4, 0x0103, AckCode::OK);
    for (id, motor, flags) in [(5, 1, enabled), (6, 2, disabled), (7, 3, enabled | MotorFlags::LIVE)] {
        desk.request(2, configure(motor, flags));
        desk.acked(id, 0x0037, AckCode::OK);
    }
    assert_eq!(desk.sequence(3, run(1, 10, RunFlags(0))).0, [(8, Contents::ToFrame(frame(1)))]);
    let busy = (vec![], vec![refused(7, Refusal::Busy)]);
    for (motor, flags) in [(1, disabled), (1, enabled | MotorFlags::BLUR), (2, enabled), (3, enabled)] {
        assert_eq!(desk.request(7, configure(motor, flags)), busy, "motor {motor}");
    }
    desk.acked(8, 0x0110, AckCode::OK);
    let (sent, _) = desk.pass(100);
    assert_eq!(desk.status(sent[0].0, 0).0, [(10, named(3))]);
    desk.acked(10, 0x0111, AckCode::OK);
    assert_eq!(desk.request(2, configure(2, disabled)).0, [(11, named(2))]);
    desk.acked(11, 0x0037, AckCode::OK);
    assert_eq!(desk.request(2, configure(2, enabled | MotorFlags::LIVE)).0, [(12, named(2))], "driven by hand");
    desk.acked(12, 0x0037, AckCode::OK);
    desk.receives(0, HardStop { reason: StopReason::EMERGENCY_STOP, motor: None, tail: &[] }.into());
    assert_eq!(desk.request(7, configure(2, enabled)), busy, "the run may still begin");
    desk.stop(StopTarget::All);
    desk.acked(13, 0x0033, AckCode::OK);
    assert_eq!(desk.request(2, configure(2, enabled)).0, [(14, named(2))]);
}

/// D-84
#[test]
fn a_move_without_motors_needs_all_motors_disabled() {
    let mut desk = Desk::of(Options::default());
    desk.becomes_ready(1, Hi { motor_count: 1, ..hi() });
    desk.sequence(1, begin(1, 10));
    desk.acked(2, 0x0100, AckCode::OK);
    desk.step(Input::Section(None));
    assert_eq!(desk.acked(3, 0x0103, AckCode::OK).1, [done(1)]);
    for message in [position_frame(1), run(1, 10, RunFlags(0)), jog_all(5), RtShootFrame::default().into()] {
        assert_eq!(desk.sequence(7, message), (vec![], vec![refused(7, Refusal::NotInMove(Motor(1)))]));
    }
    desk.request(2, MotorConfigure { motor: Motor(1), flags: MotorFlags::empty(), tail: &[] }.into());
    desk.acked(4, 0x0037, AckCode::OK);
    assert_eq!(desk.sequence(3, position_frame(1)).0, [(5, named(3))]);
}

/// D-90
#[test]
fn after_an_upload_that_failed_nothing_follows_a_move_until_an_upload_is_complete() {
    let all = [position_frame(1), run(1, 10, RunFlags(0)), jog_all(5), shot(1)];
    let mut desk = Desk::of(Options::default());
    desk.becomes_ready(1, Hi { motor_count: 0, ..hi() });
    assert_eq!(desk.clone().sequence(7, position_frame(1)).0, [(2, named(7))], "nobody knows the move");
    desk.sequence(1, begin(1, 10));
    assert_eq!(desk.acked(2, 0x0100, AckCode::ERR_MOVING).1, [refused(1, Refusal::Device(AckCode::ERR_MOVING))]);
    for message in all {
        assert_eq!(desk.sequence(7, message), (vec![], vec![refused(7, Refusal::MoveUnknown)]));
    }
    desk.step(Input::LinkDown);
    desk.becomes_ready(3, Hi { motor_count: 0, ..hi() });
    assert_eq!(desk.sequence(7, position_frame(1)), (vec![], vec![refused(7, Refusal::MoveUnknown)]), "a new link");
    let mut other = desk.clone();
    desk.sequence(1, begin(1, 10));
    desk.acked(4, 0x0100, AckCode::OK);
    desk.step(Input::Section(None));
    assert_eq!(desk.pass(1500).1, [not_confirmed(1)]);
    assert_eq!(desk.sequence(7, position_frame(1)), (vec![], vec![refused(7, Refusal::MoveUnknown)]), "no answer");
    desk.sequence(1, begin(1, 10));
    desk.acked(8, 0x0100, AckCode::OK);
    desk.step(Input::Section(None));
    assert_eq!(desk.acked(9, 0x0103, AckCode::OK).1, [done(1)]);
    assert_eq!(desk.sequence(7, position_frame(1)).0, [(10, named(7))]);
    // A device that was switched on has no move, and says so.
    other.receives(0, hi().into());
    other.receives(4, Hi { motor_count: 0, ..hi() }.into());
    other.command(Command::Configured);
    assert_eq!(other.sequence(7, position_frame(1)).0, [(5, named(7))]);
}

/// D-76, D-84
#[test]
fn a_move_needs_all_its_motors_enabled_and_a_shot_its_own_to_blur() {
    let configure = |motor, flags| HostMessage::from(MotorConfigure { motor: Motor(motor), flags, tail: &[] });
    let lacks = |motor, flags| vec![refused(7, Refusal::NotConfigured(Motor(motor), flags))];
    let mut desk = Desk::of(Options::default());
    desk.becomes_ready(1, hi());
    desk.sequence(1, begin(1, 10));
    desk.acked(2, 0x0100, AckCode::OK);
    let size = SectionSize::default();
    let first = Section::first(&Tens, size).unwrap();
    desk.step(Input::Section(Some(first)));
    desk.acked(3, 0x0101, AckCode::OK);
    desk.step(Input::Section(first.next(&Tens, size)));
    desk.acked(4, 0x0101, AckCode::OK);
    desk.step(Input::Section(None));
    assert_eq!(desk.acked(5, 0x0103, AckCode::OK).1, [done(1)]);
    desk.request(2, configure(1, MotorFlags::ENABLED));
    desk.acked(6, 0x0037, AckCode::OK);
    for message in [position_frame(1), run(1, 10, RunFlags(0)), jog_all(5)] {
        assert_eq!(desk.sequence(7, message), (vec![], lacks(2, MotorFlags::ENABLED)), "motor 2 is part of the move");
    }
    desk.request(2, configure(2, MotorFlags::ENABLED));
    desk.acked(7, 0x0037, AckCode::OK);
    // The device may give all other motors a path of zeros: D-84.
    let outside = |motor| vec![refused(7, Refusal::NotInMove(Motor(motor)))];
    let mut id = 8;
    for motor in 3..=hi().motor_count {
        for message in [position_frame(1), run(1, 10, RunFlags(0)), jog_all(5), RtShootFrame::default().into()] {
            assert_eq!(desk.sequence(7, message), (vec![], outside(motor)), "motor {motor} may be enabled");
        }
        desk.request(2, configure(motor, MotorFlags::empty()));
        assert_eq!(desk.sequence(7, position_frame(1)), (vec![], outside(motor)), "nobody knows yet");
        desk.acked(id, 0x0037, AckCode::OK);
        id += 1;
    }
    let pairs = [MotorPair::new(Motor(1), Steps(0), Steps(9)), MotorPair::new(Motor(3), Steps(4), Steps(4))];
    let shot = RtShootFrame { motors: &pairs, ..RtShootFrame::default() };
    assert_eq!(desk.sequence(7, shot.into()), (vec![], lacks(1, MotorFlags::BLUR)));
    desk.request(2, configure(1, MotorFlags::ENABLED | MotorFlags::BLUR));
    desk.acked(id, 0x0037, AckCode::OK);
    let to_frame = Contents::ToFrame(shot.frame);
    assert_eq!(desk.sequence(3, shot.into()).0, [(id + 1, to_frame)], "motor 3 does not move in the shot");
    desk.stop(StopTarget::All);
    desk.acked(id + 2, 0x0033, AckCode::OK);
    assert_eq!(desk.sequence(4, position_frame(1)).0, [(id + 3, named(4))]);
}
