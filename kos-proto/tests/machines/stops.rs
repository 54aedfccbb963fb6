//! Laws of stops and repetitions, for every command in every state of a client.

use std::collections::BTreeSet;

use kos_proto::host::*;
use kos_proto::message::*;
use kos_proto::{DeviceMessage, HostMessage, MessageId, MessageType, Millis};
use motion_core::wire::Messages;

use super::client::*;

/// All commands: those that stop, and those that do not.
fn commands() -> Vec<Command> {
    let mut commands = vec![
        Command::Connect(AT),
        Command::Disconnect,
        Command::Unlock,
        Command::ChangePassword,
        Command::SetLeds { master: LedMode::ON, slave: LedMode::OFF },
        Command::SetPlatform(4),
        Command::ResetDevice,
        Command::ResetAxis(ONE),
        Command::ResetAxis(MotorAddress::ALL),
        Command::MarkBegin(TWO),
        Command::MarkEnd(TWO),
        Command::MoveTo(go(ONE, 5.0)),
        Command::MoveTo(go(TWO, 5.0)),
        jog(TWO, 5.0),
        Command::Bump(go(ONE, 1.0)),
        Command::Alive,
        Command::TakePicture(Seconds(1.0)),
        load(),
        Command::Load { summary: summary(), delay_return: true },
        Command::Play,
        Command::PlayDirect { summary: summary() },
        Command::RapidToFirstKeyFrame,
        Command::StopMotor(ONE),
    ];
    commands.extend(Get::ALL.map(Command::Get));
    commands
}

/// A client in each state of its connection, of its move, and of its motors.
fn states() -> Vec<Client> {
    let with = |mut client: Client, commands: &[Command]| {
        for &command in commands {
            client.command(command);
        }
        client
    };
    let says = |mut client: Client, states: &[PlaybackState]| {
        for &state in states {
            client.status(state);
        }
        client
    };
    let closed = |mut client: Client| {
        client.step(Input::LinkDown);
        client
    };
    let mut connecting = Client::new(Options::default());
    connecting.command(Command::Connect(AT));
    let asked = Client::connected(Options::default(), AT);
    let mut informed = asked.clone();
    informed.receive(device_info(PlaybackState::NO_MOVE));
    let mut listed = informed.clone();
    listed.motors();
    let mut numbered = listed.clone();
    numbered.receive(guid(&GUID));
    let mut locked = Client::ready();
    locked.error(15, 0);
    let marked = with(Client::ready(), &[Command::MarkBegin(TWO)]);
    let states = vec![
        Client::new(Options::default()),
        connecting,
        asked,
        informed,
        listed,
        numbered,
        locked,
        Client::ready(),
        Client::ready_at(Options::default(), Endpoint::Usb),
        closed(Client::ready()),
        Client::setting_up(),
        Client::armed(),
        with(Client::armed(), &[Command::RapidToFirstKeyFrame]),
        Client::starting(),
        says(Client::starting(), &[PlaybackState::DELAY_TIMER_STARTED]),
        says(Client::starting(), &[PlaybackState::PRE_MOVE_PHOTOS_STARTED]),
        Client::running(),
        says(Client::running(), &[PlaybackState::END_OF_MOVE]),
        with(Client::running(), &[Command::Stop]),
        closed(Client::running()),
        with(Client::ready(), &[Command::MoveTo(go(ONE, 5.0))]),
        with(Client::ready(), &[Command::MoveTo(go(ONE, 5.0)), Command::MoveTo(go(ONE, 6.0))]),
        with(Client::ready(), &[jog(TWO, 5.0), jog(TWO, -6.0)]),
        with(Client::ready(), &[Command::Bump(go(TWO, 1.0)), Command::StopMotor(TWO)]),
        with(marked.clone(), &[Command::MarkEnd(TWO)]),
        marked,
    ];
    let found: BTreeSet<_> = states.iter().map(|client| client.machine.state().name()).collect();
    assert_eq!(found.len(), State::ALL.len());
    let found: BTreeSet<_> = states.iter().map(Client::move_state).collect();
    assert_eq!(found.len(), MoveState::ALL.len());
    states
}

/// Way to end a command or to forget a motor.
type End = fn(&mut Client);

/// All possible answers of a device that obeys a message or refuses it.
fn answers(client: &mut Client) {
    client.status(PlaybackState::MOTORS_HOME);
    client.status(PlaybackState::SETUP_COMPLETED);
    client.status(PlaybackState::START_FORWARD);
    client.rests(1, 5.0);
    client.status(PlaybackState::END_OF_MOVE);
    client.status(PlaybackState::FULL_STOP);
    client.rests(1, 5.0);
    client.rests(2, 5.0);
    client.receive(calibrated(TWO, 6.0));
    client.introduce(PlaybackState::FULL_STOP);
    client.error(2, 0);
}

fn may_move(sent: &[Transmit<'_>]) -> bool {
    sent.iter().any(|transmit| transmit.conduct().may_move())
}

#[test]
fn after_a_stop_nothing_leaves_that_may_move() {
    for state in states() {
        for command in commands() {
            let mut client = state.clone();
            client.command(command);
            client.clear();
            client.command(Command::Stop);
            assert!(!may_move(&client.sent()), "{command:?} with a stop: {}", state.state());
            for is_silent in [true, false] {
                let mut client = client.clone();
                for _ in 0..6 {
                    if !is_silent {
                        answers(&mut client);
                    }
                    client.pass(5_000);
                    // The requested connection is opened.
                    client.step(Input::LinkUp);
                }
                let sent = client.sent();
                assert!(!may_move(&sent), "{command:?} after a stop: {}, {sent:?}", state.state());
            }
        }
    }
}

#[test]
fn a_message_that_is_not_repeatable_is_sent_at_most_once_in_silence() {
    for state in states() {
        for command in commands() {
            let mut client = state.clone();
            client.pass(50);
            client.clear();
            client.command(command);
            for _ in 0..8 {
                client.pass(5_000);
                client.step(Input::LinkUp);
            }
            let sent = client.sent();
            for (index, transmit) in sent.iter().enumerate().filter(|(_, transmit)| !transmit.conduct().repeatable) {
                assert!(!sent[..index].contains(transmit), "{command:?} in {}: {transmit:?} twice", state.state());
            }
        }
    }
}

#[test]
fn the_commands_here_send_every_message_of_the_table() {
    let mut sent: BTreeSet<&str> = BTreeSet::new();
    let mut see = |mut client: Client| {
        let source = Source::default();
        sent.extend(client.sent().iter().map(|transmit| transmit.message(&source).name()));
    };
    for state in states() {
        see(state.clone());
        for command in commands().into_iter().chain([Command::Stop]) {
            let mut client = state.clone();
            client.command(command);
            see(client);
        }
    }
    let mut quiet = Client::ready_at(Options::default(), Endpoint::Usb);
    quiet.pass(4_000);
    see(quiet);
    assert_eq!(sent, HostMessage::ALL.iter().map(|kind| kind.name).collect());
}

/// A stop meets other effects in the same call. The bench of clients checks after every call that stops are the first
/// effects.
#[test]
fn a_stop_goes_out_before_anybody_is_told_of_it() {
    let mut client = Client::starting();
    let refusal = DeviceMessage::from(ErrorStatus {
        error_code: ErrorCode::CANNOT_EXECUTE_MOVE,
        motor_address: MotorAddress::ALL,
        tail: &[],
    });
    let mut late = Client::ready();
    late.command(jog(TWO, 5.0));
    for (machine, input, now) in [
        (&mut client.machine, Input::Received(refusal), client.now),
        (&mut late.machine, Input::Wake, late.now + 1_000),
    ] {
        let output = machine.advance(Millis(now), input);
        assert!(matches!(&output.effects[0], Effect::Transmit(stop) if stop.conduct().is_stop()), "{output:?}");
        assert!(output.events().next().is_some());
    }
}

/// Each command ends once, with its outcome.
#[test]
fn each_command_ends_once_with_its_outcome() {
    let sent = [Outcome::Sent];
    let mut client = Client::ready();
    for command in [Command::SetPlatform(1), Command::ResetDevice, Command::TakePicture(Seconds(1.0)), jog(TWO, 5.0)] {
        client.command(command);
        assert_eq!(client.ended(), sent, "{command:?}");
    }
    // A motion ends when the motor rests, or when something else ends it.
    let ends: [(End, Outcome<'_>); 6] = [
        (|client| client.rests(1, 5.0), Outcome::Done(None)),
        (|client| client.command(Command::StopMotor(ONE)), Outcome::Failed(Failure::Stopped)),
        (|client| client.command(Command::Stop), Outcome::Failed(Failure::Stopped)),
        (|client| client.step(Input::LinkDown), Outcome::Failed(Failure::LinkDown)),
        (|client| client.error(16, 1), Outcome::Failed(Failure::Device(ErrorCode::FAULT))),
        (|client| client.error(4, 1), Outcome::Refused(Refusal::Device(ErrorCode::BAD_MOTOR_ADDRESS))),
    ];
    for (end, outcome) in ends {
        for command in [Command::MoveTo(go(ONE, 5.0)), Command::Bump(go(ONE, 5.0))] {
            let mut client = Client::ready();
            client.command(command);
            assert_eq!(client.ended(), []);
            end(&mut client);
            assert_eq!(client.ended()[0], outcome);
        }
    }
    let mut client = Client::ready();
    client.command(Command::MoveTo(go(ONE, 5.0)));
    client.pass(50);
    client.command(Command::MoveTo(go(ONE, 6.0)));
    assert_eq!(client.ended(), [Outcome::Failed(Failure::Superseded)]);
    client.rests(1, 5.0);
    assert_eq!(client.ended(), [Outcome::NotConfirmed], "nothing tells which of the two");
    assert!(client.machine.may_move(), "it may still be on its way to the second");

    // A move is loaded, played to its end, and over.
    let mut client = Client::ready();
    client.command(load());
    client.status(PlaybackState::MOTORS_HOME);
    assert_eq!(client.ended(), []);
    client.status(PlaybackState::SETUP_COMPLETED);
    assert_eq!(client.ended(), [Outcome::Done(None)]);
    client.command(Command::Play);
    client.status(PlaybackState::START_FORWARD);
    client.status(PlaybackState::END_OF_MOVE);
    assert_eq!(client.ended(), []);
    client.status(PlaybackState::FULL_STOP);
    assert_eq!(client.ended(), [Outcome::Done(None)]);
    let ends: [(End, Outcome<'_>); 4] = [
        (|client| client.status(PlaybackState::FULL_STOP), Outcome::Failed(Failure::Stopped)),
        (|client| client.error(3, 0), Outcome::Failed(Failure::Device(ErrorCode::TRAJECTORY))),
        (|client| client.step(Input::LinkDown), Outcome::Failed(Failure::LinkDown)),
        (|client| client.receive(device_info(PlaybackState::NO_MOVE)), Outcome::NotConfirmed),
    ];
    for (end, outcome) in ends {
        let mut client = Client::ready();
        client.command(Command::PlayDirect { summary: summary() });
        client.status(PlaybackState::START_FORWARD);
        end(&mut client);
        assert_eq!(client.ended(), [outcome]);
    }
    let mut client = Client::ready();
    client.command(load());
    client.error(17, 0);
    assert_eq!(client.ended(), [Outcome::Refused(Refusal::Device(ErrorCode::INVALID_MOVE_TIME))]);
}

/// A stop of everything is confirmed when the device has obeyed and then reported rest for all motors.
#[test]
fn a_stop_is_told_when_everything_rests() {
    let mut client = Client::running();
    client.command(Command::Stop);
    client.rests(1, 3.0);
    client.status(PlaybackState::FULL_STOP);
    client.receive(device_info(PlaybackState::FULL_STOP));
    client.rests(1, 3.0);
    assert!(!client.events().contains(&Event::Stopped(StopTarget::All)) && client.machine.may_move());
    client.rests(2, 3.0);
    assert!(client.events().contains(&Event::Stopped(StopTarget::All)) && !client.machine.may_move());

    // If a report of rest does not come in time, that is reported once.
    let mut client = Client::running();
    client.command(Command::Stop);
    client.status(PlaybackState::FULL_STOP);
    client.receive(device_info(PlaybackState::FULL_STOP));
    client.clear();
    client.pass(9_000);
    assert_eq!(client.events(), [Event::StopNotConfirmed(StopTarget::All)]);
    client.rests(1, 3.0);
    client.rests(2, 3.0);
    assert!(client.events().contains(&Event::Stopped(StopTarget::All)));

    let mut client = Client::ready();
    client.command(jog(TWO, 5.0));
    client.command(Command::StopMotor(TWO));
    client.settle(PlaybackState::NO_MOVE);
    client.clear();
    client.rests(2, 3.0);
    assert_eq!(client.events()[1..], [Event::Stopped(StopTarget::Motor(TWO))]);
    assert!(!client.machine.may_move());
}

/// 7.6-21: the next connection begins with the stops that were not confirmed on the last one.
#[test]
fn a_stop_that_is_not_confirmed_is_sent_first_on_the_next_connection() {
    type Act = fn(&mut Client);
    let lost: [(Act, StopTarget); 4] = [
        (
            |client| {
                client.command(jog(TWO, 5.0));
                client.command(Command::StopMotor(TWO));
                client.step(Input::LinkDown);
            },
            StopTarget::Motor(TWO),
        ),
        (
            |client| {
                client.command(jog(TWO, 5.0));
                client.step(Input::LinkDown);
                assert_eq!(client.refused(Command::StopMotor(TWO)), Some(Refusal::NotConnected));
            },
            StopTarget::Motor(TWO),
        ),
        (
            |client| {
                client.command(Command::Stop);
                client.step(Input::LinkDown);
            },
            StopTarget::All,
        ),
        // The device obeyed, but did not report that the motors rest.
        (
            |client| {
                client.command(Command::Stop);
                client.status(PlaybackState::FULL_STOP);
                client.receive(device_info(PlaybackState::FULL_STOP));
                client.step(Input::LinkDown);
            },
            StopTarget::All,
        ),
    ];
    for (lose, target) in lost {
        let mut client = Client::ready();
        lose(&mut client);
        assert!(client.events().contains(&Event::StopNotConfirmed(target)), "{target:?}");
        client.clear();
        client.pass(1_000);
        client.step(Input::LinkUp);
        let first = if target == StopTarget::All { Transmit::StopPlayback } else { stop(TWO) };
        assert_eq!(client.sent(), [first, QUESTION]);
        client.introduce(PlaybackState::FULL_STOP);
        if target == StopTarget::All {
            client.status(PlaybackState::FULL_STOP);
            client.settle(PlaybackState::FULL_STOP);
        }
        client.settle(PlaybackState::FULL_STOP);
        assert!(!client.events().contains(&Event::Stopped(target)));
        client.rests(1, 3.0);
        client.rests(2, 3.0);
        assert!(client.events().contains(&Event::Stopped(target)) && !client.machine.may_move(), "{target:?}");
    }

    // Another device may be at the end of a connection that the application asks for.
    let mut client = Client::ready();
    client.command(jog(TWO, 5.0));
    client.command(Command::StopMotor(TWO));
    client.command(Command::Disconnect);
    client.command(Command::Connect(Endpoint::Usb));
    client.clear();
    client.step(Input::LinkUp);
    assert_eq!(client.sent(), [Transmit::Get(Get::DeviceInfo)]);
}

/// A motor that is not known to rest may still move, also if it goes off line and comes back.
#[test]
fn a_motor_that_is_forgotten_while_it_moves_may_still_move() {
    let (speed, acceleration) = (RotationsPerSecond(1.0), RotationsPerSecondSquared(1.0));
    let presence = |online: bool| MotorPresence::new(TWO, online.into(), MotorType::AXIS, speed, speed, acceleration);
    let forgets: [fn(&mut Client, [MotorPresence; 2]); 3] = [
        |client, [off, on]| {
            client.receive(presences(&[off]));
            client.receive(presences(&[on]));
            client.motors();
        },
        // One series ends after its first part, and another begins there.
        |client, _| {
            client.command(Command::Get(Get::MotorInfo));
            client.motor(1, 3.0, 8.0, false);
            client.motors();
        },
        |client, _| client.step(Input::LinkDown),
    ];
    for forget in forgets {
        let mut client = Client::ready();
        client.command(jog(TWO, 5.0));
        forget(&mut client, [presence(false), presence(true)]);
        assert!(client.machine.may_move());
        client.rests(2, 1.0);
        assert!(client.machine.may_move(), "the report may be of before the jog");
        if client.state() == "Disconnected" {
            client.pass(1_000);
            client.step(Input::LinkUp);
            client.introduce(PlaybackState::NO_MOVE);
            client.settle(PlaybackState::NO_MOVE);
            assert!(client.machine.may_move(), "after a reconnect, too");
        }
        client.command(Command::Stop);
        client.status(PlaybackState::FULL_STOP);
        client.receive(device_info(PlaybackState::FULL_STOP));
        client.rests(1, 1.0);
        assert!(client.machine.may_move());
        client.rests(2, 1.0);
        assert!(!client.machine.may_move());
    }
}

/// A motor that is sent on before it reported rest after a stop: its report may be about the stop, or about the new motion.
/// So motors wait for each other in the time that a stop has.
#[test]
fn a_motor_that_is_sent_on_after_a_stop_may_still_move() {
    for command in [Command::MoveTo(go(TWO, 5.0)), Command::Bump(go(TWO, 5.0)), jog(TWO, 5.0), load()] {
        let mut client = Client::running();
        client.command(Command::Stop);
        client.status(PlaybackState::FULL_STOP);
        client.settle(PlaybackState::FULL_STOP);
        client.rests(1, 1.0);
        assert_eq!(client.refused(command), Some(Refusal::Stopping));
        client.pass(2_000);
        assert_eq!(client.events(), [Event::StopNotConfirmed(StopTarget::All)]);
        client.command(command);
        client.rests(2, 1.0);
        assert!(!client.ended().contains(&Outcome::Done(None)), "{command:?}");
        client.command(Command::StopMotor(TWO));
        client.rests(2, 5.0);
        client.settle(PlaybackState::FULL_STOP);
        assert!(!client.events().iter().any(|event| matches!(event, Event::Stopped(StopTarget::All))), "{command:?}");
        assert!(client.machine.may_move(), "{command:?}");
    }
}

/// 7.6-24: a locked device may ignore a stop. So it goes out first, and again directly after the password, whatever was
/// answered before. Only what is answered after it counts (decision K-S23).
#[test]
fn a_stop_goes_out_again_directly_after_the_password() {
    let password = Transmit::UserPassword(PasswordOf::Device(Password(b"open")));
    for is_obeyed_while_locked in [false, true] {
        let mut client = Client::running();
        client.command(jog(TWO, 5.0));
        client.command(Command::Stop);
        client.step(Input::LinkDown);
        client.clear();
        client.pass(1_000);
        client.step(Input::LinkUp);
        assert_eq!(client.sent(), [Transmit::StopPlayback, QUESTION]);
        if is_obeyed_while_locked {
            client.status(PlaybackState::FULL_STOP);
            client.rests(1, 3.0);
            client.rests(2, 3.0);
        }
        client.clear();
        client.receive(device_info(PlaybackState::START_FORWARD));
        let sent = [password, Transmit::StopPlayback, QUESTION, Transmit::Get(Get::MotorInfo)];
        assert_eq!((client.sent(), client.events()), (sent.to_vec(), vec![]));
        assert_eq!((client.move_state(), client.machine.may_move()), ("Stopping", true));
        client.status(PlaybackState::FULL_STOP);
        client.motors();
        client.status(PlaybackState::FULL_STOP);
        client.settle(PlaybackState::FULL_STOP);
        client.settle(PlaybackState::FULL_STOP);
        assert!(!client.events().contains(&Event::Stopped(StopTarget::All)), "the motors do not rest yet");
        client.rests(1, 3.0);
        client.rests(2, 3.0);
        assert!(client.events().contains(&Event::Stopped(StopTarget::All)) && !client.machine.may_move());
    }
    // The same is true of the stop of a motor, and of a password that the application gives later.
    let mut client = Client::ready();
    client.command(jog(TWO, 5.0));
    client.error(15, 0);
    client.command(Command::StopMotor(TWO));
    client.settle(PlaybackState::NO_MOVE);
    client.clear();
    client.command(Command::Unlock);
    let sent = [Transmit::UserPassword(PasswordOf::User), stop(TWO), QUESTION, Transmit::Get(Get::MotorInfo)];
    assert_eq!(client.sent(), sent);
    client.pass(1_999);
    assert!(!client.sent().contains(&stop(TWO)), "not before its time is over again");
    // A motor that the client does not know is stopped first, after the password, and again when its report says that it
    // is there; only then can its stop be confirmed.
    let mut client = Client::new(Options::default());
    client.command(Command::StopMotor(TWO));
    let unconfirmed = Event::StopNotConfirmed(StopTarget::Motor(TWO));
    assert_eq!((client.sent(), client.events()), (vec![], vec![unconfirmed]));
    client.command(Command::Connect(AT));
    client.step(Input::LinkUp);
    assert_eq!(client.sent(), [unknown(TWO), QUESTION]);
    let mut running = client.clone();
    for (client, state) in [(&mut running, PlaybackState::START_FORWARD), (&mut client, PlaybackState::NO_MOVE)] {
        client.receive(device_info(state));
        assert_eq!(client.sent(), [password, unknown(TWO), QUESTION, Transmit::Get(Get::MotorInfo)]);
    }
    client.clear();
    client.motors();
    assert_eq!(client.sent(), [stop(TWO), Transmit::Get(Get::DeviceGuid)]);
    client.settle(PlaybackState::NO_MOVE);
    client.settle(PlaybackState::NO_MOVE);
    client.clear();
    client.rests(2, 1.0);
    assert!(client.events().contains(&Event::Stopped(StopTarget::Motor(TWO))));
    // The same is true of a motor that comes to a device that is ready. No other series repeats the stop.
    let three = MotorAddress(3);
    let mut client = Client::ready();
    client.command(Command::StopMotor(three));
    assert_eq!((client.sent(), client.events().len()), (vec![unknown(three)], 1));
    client.command(Command::Get(Get::MotorInfo));
    client.clear();
    client.motors();
    assert_eq!(client.sent(), []);
    client.command(Command::Get(Get::MotorInfo));
    client.clear();
    client.motor(3, 0.0, 0.0, false);
    let Some(Transmit::MoveTo(Go { motor, speed, .. })) = client.sent().first().copied() else { panic!("no stop") };
    assert_eq!((motor, speed.0), (three, 0.0));
    // Over USB there is no lock and no password.
    let mut client = Client::connected(Options::default(), Endpoint::Usb);
    client.command(Command::Stop);
    client.clear();
    client.receive(device_info(PlaybackState::NO_MOVE));
    assert_eq!(client.sent(), [QUESTION, Transmit::Get(Get::MotorInfo)]);
}

/// 7.6-25: nobody knows which motors have to rest before the device reported them on this connection. Then the stop is sent
/// again, and is over when they all rest.
#[test]
fn a_stop_is_not_confirmed_before_the_device_reported_its_motors() {
    for endpoint in [AT, Endpoint::Usb] {
        let mut client = Client::new(Options::default());
        client.command(Command::Stop);
        client.command(Command::Connect(endpoint));
        client.step(Input::LinkUp);
        client.receive(device_info(PlaybackState::NO_MOVE));
        client.status(PlaybackState::FULL_STOP);
        client.rests(1, 3.0);
        client.rests(2, 0.0);
        for _ in 0..2 {
            client.receive(device_info(PlaybackState::FULL_STOP));
        }
        assert_eq!(client.state(), "AwaitMotorInfo");
        let stopped = Event::Stopped(StopTarget::All);
        assert!(!client.events().contains(&stopped) && client.machine.may_move());
        // A device that is locked does not report its motors.
        let mut locked = client.clone();
        locked.clear();
        locked.error(15, 0);
        assert!(locked.events().contains(&Event::StopNotConfirmed(StopTarget::All)));
        locked.pass(9_000);
        assert!(!locked.events().contains(&stopped) && locked.machine.may_move());

        client.clear();
        client.motors();
        let sent = [Transmit::StopPlayback, stop(ONE), stop(TWO), QUESTION, Transmit::Get(Get::DeviceGuid)];
        assert_eq!(client.sent(), sent);
        client.status(PlaybackState::FULL_STOP);
        client.settle(PlaybackState::FULL_STOP);
        client.rests(1, 3.0);
        assert!(!client.events().contains(&stopped) && client.machine.may_move());
        client.rests(2, 0.0);
        assert!(client.events().contains(&stopped) && !client.machine.may_move());
    }
}

/// 7.6-24: with a wrong password a stop is told at once as not confirmed. It stays wanted, and is sent again in its rhythm.
#[test]
fn a_stop_with_a_wrong_password_is_told_at_once() {
    let mut client = Client::connected(Options::default(), AT);
    client.command(Command::Stop);
    client.receive(device_info(PlaybackState::START_FORWARD));
    client.pass(10);
    client.clear();
    client.error(15, 0);
    let unconfirmed = Event::StopNotConfirmed(StopTarget::All);
    let locked_out = Event::Error(ErrorCode::LOCKED_OUT, MotorAddress::ALL);
    assert_eq!(client.events(), [locked_out, Event::Locked { wrong_password: true }, unconfirmed]);
    assert_eq!((client.sent(), client.machine.may_move()), (vec![], true));
    client.receive(device_info(PlaybackState::START_FORWARD));
    client.receive(device_info(PlaybackState::START_FORWARD));
    client.clear();
    client.pass(1_989);
    assert_eq!(client.sent(), []);
    client.pass(1);
    assert_eq!((client.sent(), client.events()), (vec![Transmit::StopPlayback, QUESTION], vec![unconfirmed]));

    let mut client = Client::ready();
    client.command(jog(TWO, 5.0));
    client.command(Command::StopMotor(TWO));
    client.clear();
    client.error(15, 0);
    assert_eq!(client.events()[2..], [Event::StopNotConfirmed(StopTarget::Motor(TWO))]);
}

/// Whatever the device answers, a stop is not sent again before its time is over.
#[test]
fn no_answer_repeats_a_stop() {
    type Act = fn(&mut Client);
    let stops: [Act; 2] = [|client| client.command(Command::Stop), |client| client.command(Command::StopMotor(TWO))];
    let answers: [Act; 9] = [
        |client| client.rests(2, 1.0),
        |client| client.status(PlaybackState::START_FORWARD),
        |client| client.status(PlaybackState::START_REVERSE),
        |client| client.status(PlaybackState::END_OF_MOVE),
        |client| client.receive(device_info(PlaybackState::START_FORWARD)),
        |client| client.error(2, 0),
        |client| client.error(15, 0),
        |client| client.receive(unsupported(&[4, 0, 7, 0, 0x80, 0, 6])),
        |client| client.receive(unsupported(&[4, 0, 20, 0, 0x80, 0, 0x1c, 2])),
    ];
    for stop in stops {
        for first in answers {
            for second in answers {
                let mut client = Client::ready();
                for position in [1.0, 2.0] {
                    client.command(Command::MoveTo(go(TWO, position)));
                    client.pass(50);
                }
                stop(&mut client);
                client.clear();
                for _ in 0..3 {
                    first(&mut client);
                    second(&mut client);
                }
                assert!(!client.sent().iter().any(|transmit| transmit.conduct().is_stop()));
            }
        }
    }
}

/// 7.3-14: a motor that jogs is stopped when the application falls silent, also if the device reported meanwhile that the
/// motor is gone, or left it out of a series (decision K-S25).
#[test]
fn a_motor_that_jogs_is_never_dropped() {
    type Report = fn(&mut Client, [MotorPresence; 2]);
    let (speed, acceleration) = (RotationsPerSecond(1.0), RotationsPerSecondSquared(1.0));
    let presence = |online: bool| MotorPresence::new(TWO, online.into(), MotorType::AXIS, speed, speed, acceleration);
    let reports: [(&str, Report); 4] = [
        ("off line, and on line again", |client, [off, on]| {
            client.receive(presences(&[off]));
            client.pass(200);
            client.receive(presences(&[on]));
            client.motors();
        }),
        ("off line", |client, [off, _]| client.receive(presences(&[off]))),
        ("the end of an earlier series ends the next one", |client, _| {
            client.command(Command::Get(Get::MotorInfo));
            client.motor(2, 3.0, 0.0, true);
            for _ in 0..30 {
                client.pass(100);
                client.command(Command::Alive);
            }
            client.command(Command::Get(Get::MotorInfo));
            client.motor(1, 3.0, 8.0, false);
        }),
        ("one report is pushed before the answer", |client, _| {
            client.command(Command::Get(Get::MotorInfo));
            client.motor(1, 3.0, 8.0, false);
            client.motor(1, 3.0, 8.0, true);
            client.motor(2, 3.0, 0.0, false);
        }),
    ];
    for (what, report) in reports {
        let mut client = Client::ready();
        client.command(jog(TWO, 5.0));
        report(&mut client, [presence(false), presence(true)]);
        assert!(client.machine.may_move(), "{what}");
        client.clear();
        client.pass(1_000);
        assert!(client.events().contains(&Event::DeadMan), "{what}");
        assert!(
            client
                .sent()
                .iter()
                .any(|transmit| matches!(transmit, Transmit::MoveTo(stop) if stop.motor == TWO && stop.speed.0 == 0.0)),
            "{what}"
        );
        assert!(client.machine.may_move(), "{what}");
        client.rests(2, 5.0);
        client.settle(PlaybackState::NO_MOVE);
        assert!(client.events().contains(&Event::Stopped(StopTarget::Motor(TWO))), "{what}");
        assert!(!client.machine.may_move(), "{what}");
        // A motor that is off line is dropped when it is known to rest.
        let motors = client.machine.motors().count();
        assert_eq!(motors, if what == "off line" { 1 } else { 2 }, "{what}");
    }
    // A jog cannot be stopped without a connection, so the next one begins with its stop.
    let mut client = Client::ready();
    client.command(jog(TWO, 5.0));
    client.step(Input::LinkDown);
    client.clear();
    client.pass(1_000);
    client.step(Input::LinkUp);
    assert_eq!(client.sent(), [stop(TWO), QUESTION]);
}

/// 7.2-21: what waits for an action ends at once when the device does not know it (decision K-S24).
#[test]
fn a_command_ends_at_once_if_the_device_does_not_know_its_message() {
    let refused =
        |action: ActionId| Outcome::Refused(Refusal::Unsupported { id: MessageId::ACTION, action: Some(action) });
    let echo = |action: ActionId| unsupported([4, 0, 20, 0, 0x80, 0, action.0, 2].to_vec().leak());
    for (command, action) in [
        (Command::Bump(go(TWO, 1.0)), ActionId::BUMP_POSITION_SPEED_ACCELERATION),
        (Command::MoveTo(go(TWO, 1.0)), ActionId::SET_POSITION_SPEED_ACCELERATION),
        (Command::MarkEnd(TWO), ActionId::MARK_END_POSITION),
        (load(), ActionId::SETUP_PLAYBACK),
        (Command::PlayDirect { summary: summary() }, ActionId::START_PLAYBACK),
    ] {
        for other in [ActionId::RESET_AXIS, ActionId::TAKE_PICTURE, action] {
            let mut client = Client::ready();
            client.command(Command::MarkBegin(TWO));
            client.clear();
            client.command(command);
            client.clear();
            client.receive(echo(other));
            let ended = if other == action { vec![refused(action)] } else { vec![] };
            assert_eq!(client.ended(), ended, "{command:?}, {other}");
            let is_move = matches!(action, ActionId::SETUP_PLAYBACK | ActionId::START_PLAYBACK);
            let stops = client.sent().contains(&Transmit::StopPlayback);
            assert_eq!(stops, is_move && other == action, "{command:?}, {other}");
            assert_eq!(
                client.machine.may_move(),
                is_move || (other != action && action != ActionId::MARK_END_POSITION)
            );
        }
    }
    // A move that cannot be stored is no move. A stop that is not known is told at once.
    for (command, echo) in
        [(load(), [4, 0, 99, 0, 0x12, 0]), (Command::PlayDirect { summary: summary() }, [4, 0, 99, 0, 0x12, 0])]
    {
        let mut client = Client::ready();
        client.command(command);
        client.receive(unsupported(&echo));
        let refusal = Refusal::Unsupported { id: MessageId::TRAJECTORY_DATA, action: None };
        assert_eq!(client.ended(), [Outcome::Refused(refusal)]);
    }
    let mut client = Client::ready();
    client.command(jog(TWO, 5.0));
    client.command(Command::Stop);
    client.clear();
    client.receive(unsupported(&[4, 0, 7, 0, 0x80, 0, 6]));
    client.receive(unsupported(&[4, 0, 20, 0, 0x80, 0, 0x1c, 2]));
    let told = client.events();
    for target in [StopTarget::All, StopTarget::Motor(TWO)] {
        assert!(told.contains(&Event::StopNotConfirmed(target)), "{told:?}");
    }
    // A stop is another message than the bump that it stops.
    for (action, told) in
        [(ActionId::BUMP_POSITION_SPEED_ACCELERATION, false), (ActionId::SET_POSITION_SPEED_ACCELERATION, true)]
    {
        let mut client = Client::ready();
        client.command(Command::Bump(go(TWO, 1.0)));
        client.command(Command::StopMotor(TWO));
        client.clear();
        client.receive(echo(action));
        assert_eq!(client.events().contains(&Event::StopNotConfirmed(StopTarget::Motor(TWO))), told, "{action}");
        client.rests(2, 0.0);
        client.settle(PlaybackState::NO_MOVE);
        assert!(client.events().contains(&Event::Stopped(StopTarget::Motor(TWO))) && !client.machine.may_move());
    }
    // So is a motion that waits. It is sent when its time has come.
    let mut client = Client::ready();
    client.command(Command::MoveTo(go(TWO, 1.0)));
    client.rests(2, 1.0);
    client.command(Command::Bump(go(TWO, 1.0)));
    client.command(Command::MoveTo(go(TWO, 5.0)));
    client.clear();
    client.receive(echo(ActionId::BUMP_POSITION_SPEED_ACCELERATION));
    assert_eq!((client.sent(), client.ended()), (vec![], vec![]));
    client.pass(50);
    assert_eq!(client.sent(), [Transmit::MoveTo(go(TWO, 5.0))]);
    client.rests(2, 5.0);
    assert_eq!((client.ended(), client.machine.may_move()), (vec![Outcome::Done(None)], false));
    // A begin that the device does not know is not marked.
    let mut client = Client::ready();
    client.command(Command::MarkBegin(TWO));
    client.receive(unsupported(&[4, 0, 8, 0, 0x80, 0, 3, 2]));
    assert_eq!(client.refused(Command::MarkEnd(TWO)), Some(Refusal::NotMarked));
}

/// A motor of a move that goes off line may still move, so no stop is confirmed without it.
#[test]
fn a_stop_waits_for_a_motor_that_left_the_move() {
    let (speed, acceleration) = (RotationsPerSecond(1.0), RotationsPerSecondSquared(1.0));
    for running in [true, false] {
        let mut client = if running { Client::running() } else { Client::ready() };
        client.command(Command::Stop);
        client.receive(presences(&[MotorPresence::new(ONE, Bool::FALSE, MotorType::AXIS, speed, speed, acceleration)]));
        client.status(PlaybackState::FULL_STOP);
        client.receive(device_info(PlaybackState::FULL_STOP));
        client.rests(2, 1.0);
        let stopped = client.events().contains(&Event::Stopped(StopTarget::All));
        assert_eq!((stopped, client.machine.may_move()), (!running, running));
    }
}

/// An unknown action is reported with its number, because the device sends the first bytes of the message back.
#[test]
fn an_unknown_action_is_told_by_its_number() {
    let mut client = Client::ready();
    client.receive(unsupported(&[4, 0, 20, 0, 0x80, 0, 0x28, 1]));
    let action = Some(ActionId::BUMP_POSITION_SPEED_ACCELERATION);
    let (id, kind) = (Some(MessageId::ACTION), Some(MessageType::SET));
    assert_eq!(client.events(), [Event::Unsupported { id, kind, action }]);
}
