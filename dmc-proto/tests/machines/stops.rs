//! Host: stops. Safety decision 1.

use dmc_proto::host::{
    Command, Contents, Event, Failure, Input, Options, Outcome, Progress, Refusal, State, StopTarget,
};
use dmc_proto::message::{
    AckCode, HardStop, Hi, HostMessage, Motor, MotorConfigure, MotorFlags, MotorStatusRequest, RtGo, RunFlags,
    StopReason, VirtualMotor,
};
use dmc_proto::{DeviceMessage, MessageId, MessageType};

use super::bench::{
    COMMAND, Desk, ack, answered, begin, ended, failed, hi, jog, move_to, named, position_frame, refused, run, shot,
    status,
};

fn ask_status() -> HostMessage<'static> {
    MotorStatusRequest::default().into()
}

const ALL: Contents = Contents::Stop(StopTarget::All);
const TWO: StopTarget = StopTarget::Motor(Motor(2));

/// D5-14, S-1
#[test]
fn a_stop_is_sent_at_once_and_calls_off_everything_that_moves() {
    for (what, of) in [
        (StopTarget::All, 0x0033),
        (StopTarget::AllSilent, 0x0033),
        (TWO, 0x0032),
        (StopTarget::Virtual(VirtualMotor::PAN), 0x0202),
    ] {
        let mut desk = Desk::up();
        desk.request(1, move_to(1, 2));
        desk.request(2, ask_status());
        desk.request(3, jog(1));
        let gone = |token| failed(token, Failure::Stopped);
        let (sent, events) = desk.stop(what);
        assert_eq!(
            sent,
            [(3, Contents::Stop(what)), (4, named(2))],
            "a stop is sent before everything else, and needs no place in the window"
        );
        assert_eq!(events, [gone(1), gone(3)]);
        let late = vec![Event::Unsolicited(MessageId(2), ack(0x0031, AckCode::OK))];
        assert_eq!(desk.acked(2, 0x0031, AckCode::OK), (vec![], late));
        assert_eq!(desk.acked(3, of, AckCode::OK), (vec![], vec![Event::Stopped(what)]));
        assert_eq!(desk.machine.unconfirmed_stops().count(), 0);
        assert_eq!(desk.status(4, 0).1, [answered(2, status(0))]);
        assert_eq!(desk.wake, None);
    }
}

/// S-1
#[test]
fn a_stop_without_an_answer_is_sent_again_without_end() {
    let mut desk = Desk::up();
    assert_eq!(desk.stop(StopTarget::All).0, [(2, ALL)]);
    assert_eq!(desk.pass(250), (vec![(3, Contents::Status)], vec![]));
    assert_eq!(desk.pass(250), (vec![(4, ALL)], vec![]), "no answer comes");
    assert_eq!(desk.pass(250), (vec![(5, Contents::Status)], vec![]));
    assert_eq!(desk.status(5, 1), (vec![], vec![]), "motors move, and the stop waits for its time");
    assert_eq!(desk.pass(250), (vec![(6, ALL)], vec![]));
    assert_eq!(desk.pass(250), (vec![(7, Contents::Status)], vec![]));
    assert_eq!(
        desk.pass(250),
        (vec![(8, ALL)], vec![Event::StopNotConfirmed(StopTarget::All)]),
        "after three tries the stop is reported as not confirmed"
    );
    let (sent, events) = desk.pass(5000);
    assert_eq!((sent.len(), events), (20, vec![]), "the tries go on, and the report comes once");
    assert_eq!(sent.iter().filter(|(_, what)| *what == ALL).count(), 10);
    let mut other = desk.clone();
    let late = sent.iter().rev().find(|(_, what)| *what == ALL).unwrap().0;
    assert_eq!(desk.acked(late, 0x0033, AckCode::OK), (vec![], vec![Event::Stopped(StopTarget::All)]));
    assert_eq!(desk.pass(5000), (vec![], vec![]));
    assert_eq!(other.command(Command::EndStops), (vec![], vec![]));
    assert_eq!(other.pass(5000), (vec![], vec![]), "the application ended the stop");
}

/// S-1
#[test]
fn motors_at_rest_confirm_a_stop() {
    let mut desk = Desk::up();
    desk.stop(TWO);
    desk.pass(250);
    assert_eq!(desk.status(3, 0b01), (vec![], vec![Event::Stopped(TWO)]), "another motor may move");
    desk.stop(StopTarget::All);
    desk.pass(250);
    assert_eq!(desk.status(5, 0b01).0, []);
    assert_eq!(desk.pass(250).0, [(6, ALL)]);
    desk.pass(250);
    assert_eq!(desk.status(7, 0), (vec![], vec![Event::Stopped(StopTarget::All)]));
    assert_eq!(desk.wake, None);
}

/// S-1
#[test]
fn a_stop_that_is_refused_is_not_confirmed() {
    for code in [AckCode::ERR_HARD_LOW, AckCode::ERR_GENERAL, AckCode(77)] {
        let mut desk = Desk::up();
        desk.stop(StopTarget::All);
        assert_eq!(desk.acked(2, 0x0033, code), (vec![], vec![]));
        assert_eq!(desk.pass(249), (vec![], vec![]), "the question comes in its time");
        assert_eq!(desk.pass(1), (vec![(3, Contents::Status)], vec![]));
        assert_eq!(desk.status(3, 0), (vec![], vec![Event::Stopped(StopTarget::All)]));
        assert_eq!((desk.wake, desk.padding), (None, 0), "a device that answers needs no padding");
    }
    let mut desk = Desk::up();
    desk.stop(StopTarget::All);
    let garbled = AckCode::ERR_CHECKSUM;
    assert_eq!(desk.acked(2, 0x0033, garbled), (vec![(3, ALL)], vec![]), "the stop is sent again at once");
    assert_eq!(desk.acked(3, 0x0033, garbled), (vec![(4, ALL)], vec![]));
    assert_eq!(desk.acked(4, 0x0033, garbled), (vec![], vec![]));
    assert_eq!(desk.pass(250), (vec![(5, Contents::Status)], vec![]), "after three tries the device is asked in time");
}

/// D-73: whatever the device answers, and however fast, a stop and its question are a timeout apart.
#[test]
fn a_stop_is_repeated_a_timeout_apart_whatever_the_device_answers() {
    for code in [None, Some(AckCode::ERR_HARD_LOW), Some(AckCode::ERR_MOVING), Some(AckCode::ERR_CHECKSUM)] {
        for motors in [None, Some(0b10), Some(0b11)] {
            let mut desk = Desk::up();
            let mut waits: Vec<_> = desk.stop(TWO).0;
            let (mut stops, mut questions, mut told) = (vec![desk.now], vec![], vec![]);
            // The device answers each message after a millisecond.
            for _ in 0..20_000 {
                let (mut sent, mut events) = desk.pass(1);
                for (id, what) in std::mem::take(&mut waits) {
                    let answer = match what {
                        Contents::Stop(_) => code.map(|code| ack(0x0032, code)),
                        _ => motors.map(status),
                    };
                    let (more, news) = answer.map(|answer| desk.receives(id, answer)).unwrap_or_default();
                    sent.extend(more);
                    events.extend(news);
                }
                for (_, what) in &sent {
                    if matches!(what, Contents::Stop(_)) { &mut stops } else { &mut questions }.push(desk.now);
                }
                told.extend(events);
                waits = sent;
            }
            assert_eq!(told, [Event::StopNotConfirmed(TWO)], "{code:?}: told once");
            assert!(desk.machine.unconfirmed_stops().eq([TWO]), "{code:?}: still wanted");
            // A stop that arrived damaged did not arrive. It is sent again at once, twice at most.
            let again = if code == Some(AckCode::ERR_CHECKSUM) { 2 } else { 0 };
            for times in [&stops[again..], &questions] {
                assert!(times.windows(2).all(|pair| pair[1].since(pair[0]) >= 500), "{code:?}: {times:?}");
            }
            assert!((39..=41 + again).contains(&stops.len()), "{code:?}: {}", stops.len());
            // The line stays usable.
            let (sent, _) = desk.request(1, ask_status());
            assert!(sent.iter().any(|(_, what)| *what == named(1)), "{sent:?}");
        }
    }
}

/// D-73
#[test]
fn a_late_answer_to_an_earlier_question_confirms_a_stop() {
    let mut desk = Desk::up();
    desk.stop(TWO);
    assert_eq!(desk.pass(250).0, [(3, Contents::Status)]);
    assert_eq!(desk.pass(500).0, [(4, Contents::Stop(TWO)), (5, Contents::Status)]);
    assert_eq!(desk.status(3, 0b01), (vec![], vec![Event::Stopped(TWO)]));
    assert_eq!(desk.wake, None);
    // An answer to a question from before a stop tells nothing of it.
    desk.stop(StopTarget::All);
    assert_eq!(desk.pass(250).0, [(7, Contents::Status)]);
    assert_eq!(desk.stop(TWO).0, [(8, Contents::Stop(TWO))]);
    assert_eq!(desk.status(7, 0).1, [Event::Stopped(StopTarget::All)]);
    assert!(desk.machine.unconfirmed_stops().eq([TWO]));
}

/// D-71
#[test]
fn zero_bytes_follow_a_stop_without_an_answer() {
    let mut desk = Desk::up();
    desk.stop(StopTarget::All);
    desk.pass(249);
    assert_eq!(desk.padding, 0);
    desk.pass(1);
    assert_eq!(desk.padding, 2048, "as many as complete any frame");
    desk.pass(10_000);
    assert_eq!(desk.padding, 3 * 2048, "three times at most");
    desk.stop(StopTarget::All);
    desk.pass(250);
    assert_eq!(desk.padding, 4 * 2048, "another command");
    let mut desk = Desk::up_with(Options::default().with_line_speed(9600), hi());
    desk.stop(StopTarget::All);
    desk.pass(250);
    assert_eq!(desk.padding, 240, "no more than the line carries until the next try");
    let mut desk = Desk::up();
    desk.stop(StopTarget::All);
    desk.acked(2, 0x0033, AckCode::ERR_HARD_LOW);
    desk.pass(250);
    assert_eq!(desk.padding, 0, "a device that answers is not deaf");
}

/// D-72
#[test]
fn an_answer_from_before_the_link_confirms_no_stop() {
    let options = Options::default().with_first_id(0x1234_5678);
    let mut desk = Desk::of(options);
    desk.stop(StopTarget::All);
    assert_eq!(desk.step(Input::LinkUp).0, [(0x1234_5678, ALL), (0x1234_5679, Contents::Greeting)]);
    for id in [1, 2, 3] {
        let stale = vec![Event::Unsolicited(MessageId(id), ack(0x0033, AckCode::OK))];
        assert_eq!(desk.acked(id, 0x0033, AckCode::OK), (vec![], stale));
    }
    // The link is opened again: what was sent on the link before confirms nothing.
    assert_eq!(desk.step(Input::LinkUp).0, [(0x1234_567A, ALL), (0x1234_567B, Contents::Greeting)]);
    let stale = vec![Event::Unsolicited(MessageId(0x1234_5678), ack(0x0033, AckCode::OK))];
    assert_eq!(desk.acked(0x1234_5678, 0x0033, AckCode::OK), (vec![], stale));
    assert_eq!(desk.acked(0x1234_567A, 0x0033, AckCode::OK).1, [Event::Stopped(StopTarget::All)]);
    // Ids go on after the greatest one, without 0.
    let mut desk = Desk::of(Options::default().with_first_id(u32::MAX));
    assert_eq!(desk.step(Input::LinkUp).0, [(u32::MAX, Contents::Greeting)]);
    assert_eq!(desk.stop(StopTarget::All).0, [(1, ALL)]);
}

/// S-1
#[test]
fn an_answer_to_an_earlier_try_confirms_a_stop() {
    let mut desk = Desk::up();
    desk.stop(StopTarget::All);
    desk.pass(700);
    let other = vec![Event::Unsolicited(MessageId(2), ack(0x0032, AckCode::OK))];
    assert_eq!(
        desk.acked(2, 0x0032, AckCode::OK),
        (vec![], other),
        "an acknowledgement of another type confirms nothing"
    );
    assert_eq!(desk.acked(2, 0x0033, AckCode::OK), (vec![], vec![Event::Stopped(StopTarget::All)]));
}

/// D-70
#[test]
fn until_a_stop_is_confirmed_its_motors_are_not_moved() {
    let forbidden = vec![refused(1, Refusal::Stopping)];
    let mut desk = Desk::up();
    desk.stop(TWO);
    for message in [jog(2), move_to(2, 1)] {
        assert_eq!(desk.request(1, message), (vec![], forbidden.clone()));
    }
    assert_eq!(desk.sequence(1, position_frame(1)), (vec![], forbidden.clone()), "the motor may be part of the move");
    assert_eq!(desk.request(2, jog(1)).0, [(3, named(2))], "another motor");
    desk.acked(3, 0x0036, AckCode::OK);
    desk.stop(StopTarget::All);
    assert_eq!(desk.request(1, jog(1)), (vec![], forbidden));
    assert_eq!(desk.request(3, ask_status()).0, [(5, named(3))]);
    desk.acked(4, 0x0033, AckCode::OK);
    desk.status(5, 0);
    assert_eq!(desk.request(1, jog(1)).0, [(6, named(1))]);
    desk.stop(StopTarget::All);
    desk.command(Command::EndStops);
    desk.request(4, jog(1));
    assert!(desk.machine.pending().any(|(_, kind)| kind == MessageType(0x0036)), "the stop was given up");
}

/// D-61
#[test]
fn four_stops_are_followed_and_more_become_a_stop_of_everything() {
    let mut desk = Desk::up();
    let motor = |number| StopTarget::Motor(Motor(number));
    for number in 1..=4 {
        assert_eq!(desk.stop(motor(number)).0.len(), 1);
    }
    assert_eq!(desk.acked(3, 0x0032, AckCode::OK).1, [Event::Stopped(motor(2))]);
    desk.stop(motor(5));
    assert_eq!(desk.stop(motor(5)).0.len(), 1, "the same stop again");
    assert_eq!(desk.machine.unconfirmed_stops().count(), 4);
    let (sent, _) = desk.stop(motor(6));
    assert_eq!(sent.iter().map(|&(_, what)| what).collect::<Vec<_>>(), [ALL]);
    assert!(desk.machine.unconfirmed_stops().eq([StopTarget::All]));
}

/// D-60
#[test]
fn motors_at_rest_do_not_confirm_a_stop_of_a_run_that_may_still_begin() {
    let mut desk = Desk::up();
    desk.sequence(1, run(1, 10, RunFlags(0)));
    desk.acked(2, 0x0110, AckCode::OK);
    assert_eq!(desk.pass(100).0, [(3, Contents::Status)]);
    assert_eq!(desk.status(3, 0).0, [(4, named(1))]);
    assert!(desk.machine.is_armed());
    let (sent, events) = desk.stop(TWO);
    assert_eq!(sent, [(5, ALL)], "a stop of one motor of a run stops the run");
    assert_eq!(events, [failed(1, Failure::Stopped)]);
    assert_eq!(desk.pass(250).0, [(6, Contents::Status)]);
    assert_eq!(desk.status(6, 0), (vec![], vec![]), "the run may wait for the operator");
    assert_eq!(desk.pass(250), (vec![(7, ALL)], vec![]));
    assert_eq!(desk.acked(7, 0x0033, AckCode::OK), (vec![], vec![Event::Stopped(StopTarget::All)]));
    assert!(!desk.machine.is_armed());
}

/// D-60
#[test]
fn late_news_does_not_hide_a_shot_that_may_still_begin() {
    let reason = StopReason::EMERGENCY_STOP;
    let hard_stop = DeviceMessage::from(HardStop { reason, motor: None, tail: &[] });
    for (news, next) in [(hard_stop, 4), (hi().into(), 5)] {
        let mut desk = Desk::up();
        desk.sequence(1, shot(1));
        desk.receives(0, news);
        assert!(desk.machine.is_armed(), "the shot may arrive after the lock or the boot");
        desk.receives(0, news);
        assert!(desk.machine.is_armed(), "the same news again changes nothing");
        desk.stop(StopTarget::All);
        let (sent, _) = desk.pass(250);
        assert_eq!(sent, [(next, Contents::Status)]);
        assert_eq!(desk.status(next, 0), (vec![], vec![]));
        assert_eq!(desk.pass(250), (vec![(next + 1, ALL)], vec![]));
    }
}

/// D-62
#[test]
fn a_motor_that_is_driven_by_hand_stops_alone() {
    let mut desk = Desk::up();
    let flags = MotorFlags::LIVE;
    let configure = HostMessage::from(MotorConfigure { motor: Motor(2), flags, tail: &[] });
    desk.request(1, configure);
    desk.acked(2, 0x0037, AckCode::OK);
    desk.sequence(2, position_frame(1));
    let mut early = desk.clone();
    assert_eq!(early.stop(TWO).0, [(4, ALL)], "a retry could come after the stop");
    desk.acked(3, 0x0110, AckCode::OK);
    let mut other = desk.clone();
    let (sent, events) = desk.stop(TWO);
    assert_eq!((sent, events), (vec![(4, Contents::Stop(TWO))], vec![]), "the move goes on");
    assert!(desk.machine.progress().is_some());
    let (sent, events) = other.stop(StopTarget::Motor(Motor(3)));
    assert_eq!((sent, events), (vec![(4, ALL)], vec![failed(2, Failure::Stopped)]));
}

/// D-62
#[test]
fn a_motor_that_stops_alone_leaves_the_run_as_it_is() {
    let mut desk = Desk::up();
    let flags = MotorFlags::LIVE;
    let configure = HostMessage::from(MotorConfigure { motor: Motor(2), flags, tail: &[] });
    desk.request(1, configure);
    desk.acked(2, 0x0037, AckCode::OK);
    desk.sequence(2, shot(1));
    desk.acked(3, 0x0115, AckCode::OK);
    desk.receives(0, RtGo::default().into());
    assert_eq!(desk.machine.progress(), Some(Progress::Runs));
    assert_eq!(desk.stop(TWO).0, [(4, Contents::Stop(TWO))]);
    assert_eq!(desk.acked(4, 0x0032, AckCode::OK), (vec![], vec![Event::Stopped(TWO)]));
    assert_eq!((desk.machine.progress(), desk.machine.is_armed()), (Some(Progress::Runs), true));
}

/// D-62
#[test]
fn a_motor_stops_alone_only_if_it_is_known_to_be_driven_by_hand() {
    let flags = MotorFlags::LIVE;
    let configure = HostMessage::from(MotorConfigure { motor: Motor(2), flags, tail: &[] });
    let ends = |mut desk: Desk, id| {
        assert_eq!(desk.sequence(2, position_frame(1)).0, [(id, named(2))]);
        desk.acked(id, 0x0110, AckCode::OK);
        assert_eq!(desk.stop(TWO).0, [(id + 1, ALL)]);
    };
    let mut desk = Desk::up();
    desk.request(1, configure);
    desk.acked(2, 0x0037, AckCode::ERR_GENERAL);
    ends(desk, 3);
    let mut desk = Desk::up();
    desk.request(1, configure);
    desk.acked(2, 0x0037, AckCode::OK);
    desk.receives(0, hi().into());
    desk.receives(3, hi().into());
    desk.command(Command::Configured);
    ends(desk, 4);
}

/// S-1
#[test]
fn requests_of_a_sequence_are_called_off_with_it() {
    let mut desk = Desk::up();
    desk.sequence(1, position_frame(1));
    desk.acked(2, 0x0110, AckCode::OK);
    assert_eq!(desk.pass(100).0, [(3, Contents::Status)]);
    desk.stop(StopTarget::All);
    assert_eq!(desk.machine.pending().count(), 0);
    desk.acked(4, 0x0033, AckCode::OK);
    assert_eq!(desk.sequence(2, position_frame(2)).0, [(5, named(2))]);
    let late = vec![Event::Unsolicited(MessageId(3), status(0))];
    assert_eq!(desk.status(3, 0), (vec![], late), "an answer to an old question");
}

/// D-59
#[test]
fn a_stop_without_a_link_is_reported_and_waits_for_one() {
    let mut desk = Desk::new();
    let waits = ended(COMMAND.0, Outcome::NotConfirmed);
    assert_eq!(desk.stop(StopTarget::All), (vec![], vec![Event::StopNotConfirmed(StopTarget::All), waits]));
    assert_eq!(desk.wake, None);
    assert_eq!(desk.step(Input::LinkUp), (vec![(1, ALL), (2, Contents::Greeting)], vec![]), "the stop is sent first");
    assert_eq!(desk.machine.state(), State::Greeting);
    assert_eq!(desk.acked(1, 0x0033, AckCode::OK), (vec![], vec![Event::Stopped(StopTarget::All)]));
    assert_eq!(desk.stop(TWO).0, [(3, Contents::Stop(TWO))], "a stop is sent during the greeting too");
    let events = desk.step(Input::LinkDown).1;
    assert_eq!(events, [Event::LinkDown, Event::StopNotConfirmed(TWO)]);
}

/// S-2
#[test]
fn after_a_stop_nothing_that_moves_is_sent_again() {
    let mut desk = Desk::up_with(Options::default().with_window(4), hi());
    desk.request(1, move_to(1, 2));
    desk.pass(500);
    desk.stop(StopTarget::All);
    desk.acked(4, 0x0033, AckCode::OK);
    assert_eq!(desk.pass(60_000), (vec![], vec![]));
    desk.request(2, move_to(1, 2));
    assert_eq!(desk.acked(5, 0x0031, AckCode::ERR_CHECKSUM), (vec![], vec![]), "the request waits for its next try");
    desk.receives(0, DeviceMessage::from(Hi { motor_count: 3, ..hi() }));
    let (sent, _) = desk.pass(60_000);
    assert!(sent.iter().all(|&(_, what)| what == Contents::Greeting), "it is not sent after a reset");
}

/// Everything happens at once. No output is greater, and each step of these tests checks that no effect is lost.
#[test]
fn the_greatest_outputs_have_room() {
    let mut desk = Desk::up_with(Options::default().with_window(4), hi());
    for number in 1..=4 {
        desk.stop(StopTarget::Motor(Motor(number)));
    }
    for token in 1..=12 {
        desk.request(token, ask_status());
    }
    assert_eq!(desk.request(13, ask_status()).1, [refused(13, Refusal::Busy)]);
    desk.sequence(14, begin(1, 2));
    desk.pass(499);
    let sent = desk.pass(1).0;
    assert_eq!(sent.len(), 8, "four stops and four requests again");
    let (_, events) = desk.step(Input::LinkDown);
    assert_eq!(events.len(), 1 + 4 + 12 + 1, "events of the link, of stops, of requests and of a sequence");
    assert_eq!(desk.step(Input::LinkUp).0.len(), 5, "four stops and a greeting are sent");
}
