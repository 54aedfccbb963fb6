//! Move on the device, as the client follows it: kOS 7.6.

use kos_proto::MoveSummary;
use kos_proto::host::*;
use kos_proto::message::*;
use kos_proto::trajectory::*;

use super::bench::{live, live_move};
use super::client::*;

const STOP: Transmit<'static> = Transmit::StopPlayback;
const ASKS: Transmit<'static> = Transmit::Get(Get::DeviceInfo);

fn said(happened: Move) -> Vec<Event<'static>> {
    vec![Event::Move(happened)]
}

fn progress(state: PlaybackState) -> Vec<Event<'static>> {
    said(Move::Progress { state, elapsed: Normalized(0.5), photos: Some(Photos(0.0)) })
}

/// Checks one row: a status of the device, its events and the next state of the move.
#[track_caller]
fn row(mut client: Client, says: PlaybackState, told: Vec<Event<'static>>, next: &str) -> Client {
    client.status(says);
    assert_eq!((client.events(), client.move_state()), (told, next));
    assert_eq!(client.sent(), []);
    client
}

fn delayed() -> Client {
    let mut client = Client::starting();
    client.status(PlaybackState::DELAY_TIMER_STARTED);
    client.clear();
    client
}

fn pre_shoot() -> Client {
    let mut client = Client::starting();
    client.status(PlaybackState::PRE_MOVE_PHOTOS_STARTED);
    client.clear();
    client
}

fn ended() -> Client {
    let mut client = Client::running();
    client.status(PlaybackState::END_OF_MOVE);
    client.clear();
    client
}

fn stopping() -> Client {
    let mut client = Client::running();
    client.command(Command::Stop);
    client.clear();
    client
}

fn all() -> Vec<Client> {
    let first = [Client::ready(), Client::setting_up(), Client::armed(), Client::starting()];
    let all: Vec<_> =
        first.into_iter().chain([delayed(), pre_shoot(), Client::running(), ended(), stopping()]).collect();
    let states: Vec<_> = all.iter().map(|client| client.machine.move_state()).collect();
    assert_eq!(states, MoveState::ALL);
    all
}

/// 7.6-1: a summary exists only for a move that can be played, so no other move is sent.
#[test]
fn a_move_is_loaded() {
    let mut client = Client::ready();
    client.command(load());
    assert_eq!(client.sent(), [Transmit::Trajectory, Transmit::Setup { delay_return: false }]);
    assert_eq!(client.move_state(), "SettingUp");
    assert_eq!(Client::armed().refused(load()), Some(Refusal::MoveRuns), "stop the one that is ready first");
    let mut client = Client::ready();
    client.command(Command::MoveTo(go(ONE, 1.0)));
    assert_eq!(client.refused(load()), Some(Refusal::Moves));
}

/// 7.6-2.
#[test]
fn a_move_is_played_directly() {
    let mut client = Client::ready();
    client.command(Command::PlayDirect { summary: summary() });
    assert_eq!((client.sent(), client.move_state()), (vec![Transmit::Trajectory, Transmit::Start], "Starting"));
}

/// 7.6-3, 7.6-4, 7.6-7.
#[test]
fn a_move_gets_ready() {
    let client = row(Client::setting_up(), PlaybackState::MOTORS_HOME, said(Move::Home), "SettingUp");
    row(client, PlaybackState::SETUP_COMPLETED, said(Move::Ready), "Armed");
    row(Client::starting(), PlaybackState::MOTORS_HOME, said(Move::Home), "Starting");
    row(Client::starting(), PlaybackState::SETUP_COMPLETED, said(Move::Ready), "Starting");
}

/// 7.6-5: the delay is reported once, and the client keeps waiting. The same is true of a move that does not begin.
#[test]
fn a_long_way_to_where_the_move_begins_is_told() {
    for mut client in [Client::setting_up(), Client::starting()] {
        let state = client.move_state();
        for _ in 0..12 {
            client.pass(9_999);
            client.receive(device_info(PlaybackState::NO_MOVE));
        }
        client.events.retain(|event| !matches!(event, Event::Unsolicited(_)));
        assert_eq!(client.events(), []);
        client.pass(1_000);
        assert_eq!((client.events(), client.move_state()), (said(Move::Slow), state));
        client.pass(9_000);
        assert_eq!(client.events(), []);
    }
}

/// 7.6-6.
#[test]
fn a_move_that_is_ready_is_played_once() {
    let mut client = Client::armed();
    client.command(Command::Play);
    assert_eq!((client.sent(), client.move_state()), (vec![Transmit::Start], "Starting"));
    assert_eq!(client.refused(Command::Play), Some(Refusal::MoveRuns));
    assert_eq!(Client::ready().refused(Command::Play), Some(Refusal::NoMove));
}

/// The motors go home first, because the device would refuse to play the move meanwhile.
#[test]
fn the_motors_of_a_move_that_is_ready_go_back_rapidly() {
    let mut client = Client::armed();
    client.command(Command::RapidToFirstKeyFrame);
    assert_eq!(client.sent(), [Transmit::RapidToFirstKeyFrame]);
    assert_eq!(client.refused(Command::Play), Some(Refusal::Moves));
    let mut client = row(client, PlaybackState::MOTORS_HOME, said(Move::Home), "Armed");
    assert_eq!(client.refused(Command::Play), None);
    assert_eq!(Client::ready().refused(Command::RapidToFirstKeyFrame), Some(Refusal::NoMove));
}

/// 7.6-8, 7.6-9, 7.6-10.
#[test]
fn a_move_begins() {
    row(Client::starting(), PlaybackState::DELAY_TIMER_STARTED, said(Move::Countdown), "Delay");
    for client in [Client::starting(), delayed()] {
        row(client, PlaybackState::PRE_MOVE_PHOTOS_STARTED, said(Move::PreShoot), "PreShoot");
    }
    for client in [Client::starting(), delayed(), pre_shoot()] {
        row(client, PlaybackState::START_FORWARD, said(Move::Running(Direction::Forward)), "Running");
    }
}

/// 7.6-23: a device that plays the move the other way is stopped at once, also if only an answer to a question says so.
#[test]
fn a_move_that_is_played_the_other_way_is_stopped() {
    let says: [fn(&mut Client); 2] = [
        |client| client.status(PlaybackState::START_REVERSE),
        |client| client.receive(device_info(PlaybackState::START_REVERSE)),
    ];
    for says in says {
        for mut client in [Client::starting(), delayed(), pre_shoot(), Client::running(), ended()] {
            let state = client.move_state();
            says(&mut client);
            client.events.retain(|event| !matches!(event, Event::Unsolicited(_)));
            assert_eq!(client.events(), said(Move::OtherWay), "{state}");
            assert_eq!((client.sent(), client.move_state()), (vec![STOP, ASKS], "Stopping"), "{state}");
            assert!(client.ended().contains(&Outcome::Failed(Failure::OtherWay)), "{state}");
            assert!(client.machine.may_move());
        }
    }
    // A move with loops comes back, but it does not begin with that.
    let loops = MoveSummary::of(&live_move(Playback { loop_after_reverse: LoopCount(1), ..live() })).unwrap();
    let mut client = Client::ready();
    client.command(Command::PlayDirect { summary: loops });
    let mut wrong = client.clone();
    wrong.status(PlaybackState::START_REVERSE);
    assert_eq!(wrong.move_state(), "Stopping");
    for state in [PlaybackState::START_FORWARD, PlaybackState::END_OF_MOVE, PlaybackState::START_REVERSE] {
        client.status(state);
    }
    assert_eq!((client.move_state(), client.ended()), ("Running", vec![]));
}

/// 7.6-11: the messages may come in any order (decision K-J12).
#[test]
fn the_progress_of_a_move_is_told() {
    let mut client = Client::running();
    for says in [13, 6, 2, 2, 6, 13].map(PlaybackState) {
        client = row(client, says, progress(says), "Running");
    }
}

/// 7.6-12, 7.6-13, 7.6-14.
#[test]
fn a_move_ends_or_is_played_again() {
    let summary = MoveSummary::of(&live_move(Playback { loop_after_reverse: LoopCount::FOREVER, ..live() })).unwrap();
    let mut looping = Client::ready();
    looping.command(Command::PlayDirect { summary });
    looping.status(PlaybackState::START_FORWARD);
    looping.clear();
    let mut client = row(looping, PlaybackState::END_OF_MOVE, said(Move::EndReached), "Ended");
    for loops in 1..300_u32 {
        let (says, way) = if loops % 2 == 1 {
            (PlaybackState::START_REVERSE, Direction::Reverse)
        } else {
            (PlaybackState::START_FORWARD, Direction::Forward)
        };
        client = row(client, says, said(Move::Running(way)), "Running");
        assert_eq!(u32::from(client.machine.loops()), loops.min(255));
        client = row(client, PlaybackState::END_OF_MOVE, said(Move::EndReached), "Ended");
    }
    row(client, PlaybackState::POST_MOVE_PHOTOS_COMPLETED, said(Move::PostShot), "Ended");
}

/// 7.6-15: `FullStop` ends the move for any cause.
#[test]
fn a_full_stop_ends_the_move() {
    for client in all() {
        let requested = client.move_state() == "Stopping";
        let next = if requested { "Stopping" } else { "NoMove" };
        row(client, PlaybackState::FULL_STOP, said(Move::Finished { requested }), next);
    }
}

/// 7.6-16, 7.6-18: the move is stopped too, because it is unknown which motors still move.
#[test]
fn an_error_of_a_move_stops_it() {
    for client in all() {
        let state = client.move_state();
        for code in 0..=20 {
            let mut client = client.clone();
            client.error(code, 0);
            let setup = matches!(state, "SettingUp" | "Armed" | "Starting");
            let running = matches!(state, "Delay" | "PreShoot" | "Running" | "Ended");
            let fails = match code {
                0 | 3 | 6 | 17 | 19 | 20 => setup || running,
                2 => setup,
                4 => setup && state != "Armed",
                _ => false,
            };
            let code = ErrorCode(code);
            let told = client.events();
            assert_eq!(told[0], Event::Error(code, MotorAddress::ALL));
            assert_eq!(told.contains(&Event::Move(Move::Failed(code))), fails, "{state}, {code}");
            if fails {
                assert_eq!((client.sent(), client.move_state()), (vec![STOP, ASKS], "Stopping"));
            } else {
                assert_eq!((client.sent(), client.move_state()), (vec![], state));
            }
        }
    }
}

/// 7.6-17: a command was refused, and the move goes on (safety decision 1).
#[test]
fn a_refusal_does_not_end_a_move_that_runs() {
    for mut client in [delayed(), pre_shoot(), Client::running(), ended()] {
        let state = client.move_state();
        client.error(2, 0);
        let error = Event::Error(ErrorCode::CANNOT_EXECUTE_MOVE, MotorAddress::ALL);
        assert_eq!(client.events(), [error, Event::Move(Move::Refused)]);
        assert_eq!((client.sent(), client.move_state()), (vec![], state));
    }
}

/// 7.6-19: in every state the stop is sent first, in the same step, and then every two seconds until it is confirmed.
#[test]
fn a_stop_is_sent_until_it_is_confirmed() {
    for mut client in all() {
        client.command(Command::Stop);
        assert_eq!(client.sent()[..3], [STOP, stop(ONE), stop(TWO)]);
        assert_eq!((client.move_state(), client.events()), ("Stopping", vec![]));
        for _ in 0..5 {
            client.pass(1_999);
            client.receive(device_info(PlaybackState::START_FORWARD));
            client.clear();
            client.pass(1);
            assert_eq!(client.sent()[0], STOP);
            assert_eq!(client.events(), [Event::StopNotConfirmed(StopTarget::All)]);
        }
        client.status(PlaybackState::FULL_STOP);
        assert_eq!(client.events(), said(Move::Finished { requested: true }));
        client.pass(9_000);
        assert!(!client.sent().contains(&STOP));
    }
}

/// 7.6-19: the stop is sent before any message of the device too, and while the device is locked (safety decision 2).
#[test]
fn a_stop_is_sent_in_every_state_of_the_connection() {
    let mut client = Client::connected(Options::default(), AT);
    let steps: [fn(&mut Client); 4] = [
        |client| client.receive(device_info(PlaybackState::NO_MOVE)),
        |client| client.motors(),
        |client| client.receive(guid(&GUID)),
        |client| client.error(15, 0),
    ];
    for step in steps {
        let mut stopped = client.clone();
        stopped.clear();
        stopped.command(Command::Stop);
        assert_eq!(stopped.sent()[0], STOP, "{}", stopped.state());
        step(&mut client);
    }
    assert_eq!(client.state(), "Locked");
    client.clear();
    client.command(Command::Stop);
    assert_eq!(client.sent()[0], STOP);
}

/// 7.6-20: late reports are only passed on. When everything that was sent before the stop is answered, another move may
/// be loaded.
#[test]
fn a_stop_is_over_when_all_is_answered() {
    let mut client = stopping();
    assert_eq!(client.machine.state(), State::Ready);
    for says in [PlaybackState::START_FRAME, PlaybackState::END_OF_MOVE] {
        client = row(client, says, progress(says), "Stopping");
    }
    // The first FullStop was in flight before the stop. The second one answers the stop.
    client.status(PlaybackState::FULL_STOP);
    client.rests(1, 4.0);
    assert_eq!((client.move_state(), client.refused(load())), ("Stopping", Some(Refusal::Stopping)));
    client.clear();
    let mut client = row(client, PlaybackState::FULL_STOP, progress(PlaybackState::FULL_STOP), "Stopping");
    client.receive(device_info(PlaybackState::FULL_STOP));
    assert_eq!((client.move_state(), client.refused(load())), ("NoMove", Some(Refusal::Stopping)), "motor 2 moves");
    client.rests(2, 4.0);
    client.command(load());
    assert_eq!(client.move_state(), "SettingUp");
    let position = client.machine.motors().next().map(|motor| motor.position);
    assert_eq!(position, Some(Rotations(4.0)));
}

/// 7.6-20: over USB a lost answer does not hold the stop up, and the answer to an earlier query does not end it.
#[test]
fn a_stop_ends_with_the_question_after_it() {
    let mut client = Client::ready_at(Options::default(), Endpoint::Usb);
    client.command(Command::Stop);
    client.status(PlaybackState::FULL_STOP);
    client.pass(2_999);
    assert_eq!(client.move_state(), "Stopping");
    client.pass(1);
    assert_eq!(client.move_state(), "NoMove");

    let mut client = Client::running();
    client.command(Command::Get(Get::DeviceInfo));
    client.clear();
    client.command(Command::Stop);
    assert!(!client.sent().contains(&ASKS));
    client.status(PlaybackState::FULL_STOP);
    client.receive(device_info(PlaybackState::START_FORWARD));
    assert_eq!((client.sent(), client.move_state()), (vec![ASKS], "Stopping"));
    client.receive(device_info(PlaybackState::FULL_STOP));
    assert_eq!(client.move_state(), "NoMove");
}

/// 7.6-20: over TCP answers are late but not lost, so the client waits for each answer, and the last one counts.
#[test]
fn late_answers_do_not_end_a_stop() {
    let mut client = stopping();
    client.pass(2_000);
    assert!(client.sent().contains(&Transmit::StopPlayback), "it is not confirmed");
    client.pass(1_000);
    assert_eq!(client.sent(), [ASKS], "nor is the question answered that was asked before it was sent again");
    // The late answers arrive: to the first stop, and to its query.
    client.status(PlaybackState::FULL_STOP);
    client.receive(device_info(PlaybackState::FULL_STOP));
    assert_eq!((client.move_state(), client.refused(load())), ("Stopping", Some(Refusal::Stopping)));
    client.status(PlaybackState::FULL_STOP);
    client.receive(device_info(PlaybackState::FULL_STOP));
    assert_eq!(client.move_state(), "NoMove");
}

/// 7.6-20: over TCP three missing answers end the connection, because only then no answer can be late.
#[test]
fn a_stop_without_its_answer_ends_the_connection() {
    let mut client = stopping();
    client.status(PlaybackState::FULL_STOP);
    for _ in 0..2 {
        client.clear();
        client.pass(3_000);
        assert_eq!((client.sent(), client.move_state()), (vec![ASKS], "Stopping"));
    }
    let mut late = client.clone();
    client.pass(3_000);
    assert_eq!((client.events(), client.state()), (vec![], "Ready"), "in the next step");
    let mut paid = client.clone();
    client.pass(1);
    assert_eq!((client.events(), client.move_state()), (vec![Event::LinkDown(LinkDownReason::NoAnswer)], "NoMove"));

    // Answers that arrive before that are in time, but only the last one ends the stop.
    for client in [&mut late, &mut paid] {
        for _ in 0..3 {
            assert_eq!((client.state(), client.move_state()), ("Ready", "Stopping"));
            client.receive(device_info(PlaybackState::FULL_STOP));
        }
        client.pass(1);
        assert_eq!((client.state(), client.move_state()), ("Ready", "NoMove"));
    }
}

/// 7.6-21: a running move is found again from `DeviceInfo`. A ready move is not, because it may be another client's.
#[test]
fn a_lost_connection_loses_the_move_until_it_is_found() {
    for client in all().into_iter().filter(|client| !matches!(client.move_state(), "NoMove" | "Stopping")) {
        for (status, found) in [
            (0, None),
            (1, None),
            (7, None),
            (5, None),
            (8, Some(MoveState::Delay)),
            (11, Some(MoveState::PreShoot)),
            (2, Some(MoveState::Running)),
            (3, Some(MoveState::Running)),
            (6, Some(MoveState::Running)),
            (13, Some(MoveState::Running)),
            (4, Some(MoveState::Ended)),
        ] {
            let mut client = client.clone();
            client.step(Input::LinkDown);
            assert_eq!((client.events()[0], client.move_state()), (Event::Move(Move::Lost), "NoMove"));
            client.pass(1_000);
            client.step(Input::LinkUp);
            client.introduce(PlaybackState(status));
            assert_eq!(client.machine.move_state(), found.unwrap_or(MoveState::NoMove));
            let told = client.events();
            assert_eq!(told.iter().any(|event| matches!(event, Event::Move(Move::Found(_)))), found.is_some());
        }
    }
}

/// 7.6-21: a stop that was not confirmed is the first message of the next connection.
#[test]
fn a_stop_survives_a_lost_connection() {
    for lost_first in [false, true] {
        let mut client = Client::running();
        let unconfirmed = Event::StopNotConfirmed(StopTarget::All);
        if lost_first {
            client.step(Input::LinkDown);
            client.clear();
            client.command(Command::Stop);
            assert_eq!((client.events(), client.sent()), (vec![unconfirmed], vec![]));
        } else {
            client.command(Command::Stop);
            client.clear();
            client.step(Input::LinkDown);
            assert!(client.events().contains(&unconfirmed));
        }
        assert_eq!(client.move_state(), "Stopping");
        client.clear();
        client.pass(1_000);
        client.step(Input::LinkUp);
        assert_eq!((client.sent(), client.move_state()), (vec![STOP, ASKS], "Stopping"));
        client.introduce(PlaybackState::FULL_STOP);
        assert_eq!((client.state(), client.move_state()), ("Ready", "Stopping"));
        client.status(PlaybackState::FULL_STOP);
        client.settle(PlaybackState::FULL_STOP);
        assert_eq!(client.move_state(), "Stopping", "it was sent again after that question");
        client.settle(PlaybackState::FULL_STOP);
        assert_eq!((client.state(), client.move_state()), ("Ready", "NoMove"));
    }
    let mut client = stopping();
    client.step(Input::LinkDown);
    client.clear();
    client.pass(60_000);
    assert_eq!((client.sent(), client.state()), (vec![], "Connecting"), "there is nobody to send it to");
    let mut client = stopping();
    client.command(Command::Disconnect);
    assert_eq!(client.move_state(), "NoMove", "who gives up was told");
    assert!(client.events().contains(&Event::StopNotConfirmed(StopTarget::All)));
}

/// 7.6-22.
#[test]
fn an_unexpected_state_is_told() {
    for client in all() {
        for status in 0..=14 {
            let mut client = client.clone();
            let before = client.move_state();
            client.status(PlaybackState(status));
            let told = client.events();
            if told == said(Move::Unexpected(PlaybackState(status))) {
                assert_eq!((client.move_state(), client.sent()), (before, vec![]));
            }
            assert_eq!(told.len(), 1, "{before}, {status}: nothing is passed over");
        }
    }
    for status in [0, 1, 7, 9, 10, 99].map(PlaybackState) {
        row(Client::running(), status, said(Move::Unexpected(status)), "Running");
    }
    row(Client::ready(), PlaybackState::START_FORWARD, said(Move::Unexpected(PlaybackState::START_FORWARD)), "NoMove");
}

/// If the report of the end was lost, the answer to a query tells the end.
#[test]
fn an_answer_can_tell_the_end_of_a_move() {
    for status in [PlaybackState::FULL_STOP, PlaybackState::NO_MOVE] {
        for mut client in [delayed(), pre_shoot(), Client::running(), ended()] {
            client.command(Command::Get(Get::DeviceInfo));
            client.clear();
            client.receive(device_info(status));
            assert_eq!(client.events(), said(Move::Finished { requested: false }));
            assert_eq!(client.move_state(), "NoMove");
        }
    }
    for mut client in [Client::setting_up(), Client::armed(), Client::starting()] {
        let state = client.move_state();
        client.receive(device_info(PlaybackState::FULL_STOP));
        assert_eq!(client.move_state(), state, "it may be of before");
    }
}

/// Over USB the client asks by itself while a move runs, and not otherwise (decision K-S21).
#[test]
fn a_client_asks_over_usb_whether_a_move_still_runs() {
    let mut client = Client::ready_at(Options::default(), Endpoint::Usb);
    client.pass(4_000);
    assert_eq!(client.sent(), [Transmit::KeepAlive]);
    client.command(Command::PlayDirect { summary: summary() });
    client.status(PlaybackState::START_FORWARD);
    client.clear();
    client.pass(4_000);
    assert_eq!(client.sent(), [Transmit::KeepAlive, ASKS]);
    client.receive(device_info(PlaybackState::FULL_STOP));
    assert_eq!(client.events(), said(Move::Finished { requested: false }));
}

/// The list of the messages that are never sent twice without a command.
#[test]
fn messages_that_may_move_are_never_repeated() {
    let zero = Go { speed: RotationsPerSecond(0.0), ..go(ONE, 1.0) };
    let repeatable = [
        Transmit::Discover,
        Transmit::KeepAlive,
        ASKS,
        Transmit::UserPassword(PasswordOf::User),
        Transmit::Leds { master: LedMode::ON, slave: LedMode::ON },
        Transmit::Platform(1),
        STOP,
        Transmit::MoveTo(zero),
        Transmit::Bump(zero),
    ];
    let never = [
        Transmit::DevicePassword,
        Transmit::Trajectory,
        Transmit::ResetDevice,
        Transmit::ResetAxis(ONE),
        Transmit::MarkBegin(ONE),
        Transmit::MarkEnd(ONE),
        Transmit::Setup { delay_return: false },
        Transmit::Start,
        Transmit::RapidToFirstKeyFrame,
        Transmit::TakePicture(Seconds(1.0)),
        Transmit::MoveTo(go(ONE, 1.0)),
        Transmit::Bump(go(ONE, 1.0)),
    ];
    assert!(repeatable.iter().all(|transmit| transmit.conduct().repeatable));
    assert!(!never.iter().any(|transmit| transmit.conduct().repeatable));
}
