//! Motion by hand from a client: commands, stops, ranges (kOS 7.3 and 8.5, safety decisions 1 to 3).

use kos_proto::DeviceMessage;
use kos_proto::host::*;
use kos_proto::message::*;

use super::client::*;

/// Way in which the marking of a range fails.
type Fail = fn(&mut Client);

fn move_to(motor: MotorAddress, position: f32) -> Transmit<'static> {
    Transmit::MoveTo(go(motor, position))
}

/// 7.3-8: a motor gets at most twenty commands a second, and the last command is always sent.
#[test]
fn the_last_of_many_positions_counts() {
    let mut client = Client::ready();
    for position in [1.0, 2.0, 3.0, 4.0] {
        client.command(Command::MoveTo(go(ONE, position)));
    }
    client.command(Command::MoveTo(go(TWO, 9.0)));
    assert_eq!(client.sent(), [move_to(ONE, 1.0), move_to(TWO, 9.0)], "each motor has its own time");
    client.pass(49);
    assert_eq!(client.sent(), []);
    client.pass(1);
    assert_eq!(client.sent(), [move_to(ONE, 4.0)]);
    client.pass(1_000);
    assert_eq!(client.sent(), []);
    client.command(Command::MoveTo(go(ONE, 5.0)));
    assert_eq!(client.sent(), [move_to(ONE, 5.0)]);

    // A command that comes at the moment at which the earlier one is due replaces it.
    client.command(Command::MoveTo(go(ONE, 6.0)));
    client.now += 50;
    client.command(Command::MoveTo(go(ONE, 7.0)));
    client.pass(1_000);
    assert_eq!(client.sent(), [move_to(ONE, 7.0)]);

    let mut stream = Client::ready();
    for step in 0..1_000_u16 {
        stream.command(Command::MoveTo(go(TWO, step.into())));
        stream.pass(1);
    }
    let sent = stream.sent();
    assert_eq!((sent.len(), sent[20]), (21, move_to(TWO, 999.0)), "the last one as well");
}

/// 7.3-8: a motor that arrives at its first target does not count as resting while another command waits for it.
#[test]
fn a_motor_does_not_rest_while_another_position_waits() {
    let mut client = Client::ready();
    client.command(Command::MoveTo(go(ONE, 1.0)));
    client.command(Command::MoveTo(go(ONE, 2.0)));
    client.rests(1, 1.0);
    assert!(client.machine.may_move());
    assert_eq!(client.refused(Command::Bump(go(ONE, 1.0))), Some(Refusal::Moves));
    client.clear();
    client.pass(50);
    assert_eq!((client.sent(), client.machine.may_move()), (vec![move_to(ONE, 2.0)], true));
    client.rests(1, 2.0);
    assert!(!client.machine.may_move());
}

/// 7.3-2: a stop overtakes all waiting commands, and is sent again until the motor rests.
#[test]
fn a_stop_is_sent_before_positions_that_wait() {
    let mut client = Client::ready();
    client.command(Command::MoveTo(go(ONE, 1.0)));
    client.command(Command::MoveTo(go(ONE, 2.0)));
    client.clear();
    client.command(Command::StopMotor(MotorAddress(0x81)));
    assert_eq!(client.sent(), [stop(ONE), QUESTION]);
    assert_eq!(client.refused(Command::MoveTo(go(ONE, 3.0))), Some(Refusal::Stopping));
    client.settle(PlaybackState::NO_MOVE);
    client.pass(1_999);
    assert_eq!((client.sent(), client.events()), (vec![], vec![]));
    for _ in 0..5 {
        client.pass(1);
        assert_eq!(
            (client.sent(), client.events()),
            (vec![stop(ONE), QUESTION], vec![Event::StopNotConfirmed(StopTarget::Motor(ONE))])
        );
        client.pass(1_999);
        client.settle(PlaybackState::NO_MOVE);
        client.events();
        client.sent();
    }
    client.rests(1, 3.0);
    assert_eq!(client.events()[1..], [Event::Stopped(StopTarget::Motor(ONE))]);
    client.clear();
    client.pass(5_000);
    assert!(!client.sent().contains(&stop(ONE)));
    assert_eq!((client.events(), client.refused(Command::MoveTo(go(ONE, 3.0)))), (vec![], None));
}

/// 7.3-2: a stop is confirmed by a report that no earlier motion can be meant with. All reports of earlier motions have
/// come when the question after the stop is answered.
#[test]
fn a_stop_is_confirmed_by_a_report_that_is_about_it() {
    let stopped = Event::Stopped(StopTarget::Motor(TWO));
    // Of one motion, the motor rests whether it arrived or stopped.
    let mut client = Client::ready();
    client.command(Command::MoveTo(go(TWO, 1.0)));
    client.command(Command::StopMotor(TWO));
    client.rests(2, 0.5);
    assert!(!client.events().contains(&stopped) && client.machine.may_move());
    assert_eq!(client.refused(Command::Bump(go(TWO, 1.0))), Some(Refusal::Stopping));
    client.settle(PlaybackState::NO_MOVE);
    assert!(client.events().contains(&stopped) && !client.machine.may_move());

    // Of two motions, the report may be about the first one.
    let mut client = Client::ready();
    client.command(Command::MoveTo(go(TWO, 1.0)));
    client.pass(50);
    client.command(Command::MoveTo(go(TWO, 2.0)));
    client.command(Command::StopMotor(TWO));
    client.rests(2, 1.0);
    client.clear();
    client.settle(PlaybackState::NO_MOVE);
    assert!(!client.events().contains(&stopped) && client.machine.may_move());
    assert_eq!(client.sent(), [], "no answer repeats a stop");
    // The next report counts, or the answer to the stop when it is sent again.
    let mut again = client.clone();
    client.rests(2, 1.5);
    assert!(client.events().contains(&stopped) && !client.machine.may_move());
    again.pass(1_999);
    assert_eq!(again.sent(), []);
    again.pass(1);
    assert_eq!(again.sent(), [stop(TWO), QUESTION]);
    again.rests(2, 1.5);
    again.settle(PlaybackState::NO_MOVE);
    assert!(again.events().contains(&stopped) && !again.machine.may_move());
}

/// 7.3-2: what says by its speed that it stops is a stop, also of a motor that nobody knows (safety decision 3).
#[test]
fn speed_0_is_a_stop() {
    let still = RotationsPerSecond(0.0);
    for command in [
        Command::MoveTo(Go { speed: still, ..go(TWO, 0.0) }),
        Command::Bump(Go { speed: still, ..go(TWO, 0.0) }),
        jog(TWO, -0.0),
        Command::StopMotor(TWO),
    ] {
        for mut client in [Client::ready(), Client::running()] {
            client.command(command);
            assert_eq!(client.sent(), [stop(TWO), QUESTION], "{command:?}");
        }
    }
    let mut client = Client::connected(Options::default(), AT);
    client.clear();
    client.command(Command::StopMotor(ONE));
    let acceleration = RotationsPerSecondSquared(50.0);
    assert_eq!(
        client.sent(),
        [Transmit::MoveTo(Go { speed: still, acceleration, position: JOG_DISTANCE, ..go(ONE, 0.0) })]
    );
    assert_eq!(client.refused(Command::StopMotor(MotorAddress(0))), Some(Refusal::NoMotor));
    let mut nobody = Client::new(Options::default());
    nobody.command(Command::StopMotor(ONE));
    assert_eq!(nobody.events(), [Event::StopNotConfirmed(StopTarget::Motor(ONE))]);
}

/// 7.3-1: a jog goes on as long as the application gives signs of life.
#[test]
fn a_jog_is_stopped_if_the_application_is_silent() {
    let mut client = Client::ready();
    client.command(jog(TWO, -5.0));
    let speed = RotationsPerSecond(5.0);
    assert_eq!(client.sent(), [Transmit::MoveTo(Go { speed, ..go(TWO, -JOG_DISTANCE.0) })]);
    for _ in 0..20 {
        client.pass(999);
        client.command(Command::Alive);
        // The report of rest is older than the jog, because no stop was sent.
        client.rests(2, 0.0);
    }
    client.pass(999);
    assert!(!client.sent().contains(&stop(TWO)));
    client.clear();
    client.pass(1);
    assert_eq!((client.sent(), client.events()), (vec![stop(TWO), QUESTION], vec![Event::DeadMan]));
    client.settle(PlaybackState::NO_MOVE);
    client.clear();
    client.pass(2_000);
    assert_eq!(
        (client.sent(), client.events()),
        (vec![stop(TWO), QUESTION], vec![Event::StopNotConfirmed(StopTarget::Motor(TWO))])
    );
    client.rests(2, 7.0);
    client.settle(PlaybackState::NO_MOVE);
    client.clear();
    client.pass(5_000);
    assert!(!client.sent().contains(&stop(TWO)));
    // A motor that goes to a position comes to rest by itself.
    client.command(Command::MoveTo(go(ONE, 5.0)));
    client.clear();
    client.pass(5_000);
    assert!(!client.sent().contains(&stop(ONE)));
}

/// 7.3-1: another speed replaces the earlier one, and no other command does.
#[test]
fn a_jog_can_change_its_speed() {
    let mut client = Client::ready();
    client.command(jog(TWO, 5.0));
    client.command(jog(TWO, -7.0));
    client.clear();
    client.pass(50);
    let speed = RotationsPerSecond(7.0);
    assert_eq!(client.sent(), [Transmit::MoveTo(Go { speed, ..go(TWO, -JOG_DISTANCE.0) })]);
    assert_eq!(client.refused(Command::MoveTo(go(TWO, 1.0))), Some(Refusal::Moves));
    assert_eq!(client.refused(Command::Bump(go(TWO, 1.0))), Some(Refusal::Moves));
    client.command(Command::MoveTo(go(ONE, 1.0)));
    assert_eq!(client.refused(jog(ONE, 1.0)), Some(Refusal::Moves));
}

/// 7.3-9: a jog of a motor with a range aims at its end or at 0, and a position outside the range is not sent, nor a
/// distance that leads there.
#[test]
fn a_motor_with_a_range_is_never_sent_out_of_it() {
    for (begin, end, up, down) in [(0.0, 8.0, 8.0, 0.0), (-40.0, 0.0, 40.0, 0.0), (0.0, -12.0, 0.0, -12.0)] {
        let motor = |begin, end| {
            let (speed, acceleration) = (RotationsPerSecond(100.0), RotationsPerSecondSquared(80.0));
            let motors =
                [MotorEntry::new(ONE, Rotations(begin), Rotations(begin), Rotations(end), speed, speed, acceleration)];
            DeviceMessage::from(MotorInfo { more: false, motors: MotorInfos::New(motors.to_vec().leak()), tail: &[] })
        };
        for (speed, to) in [(5.0, up), (-5.0, down)] {
            let mut client = Client::ready();
            client.receive(motor(begin, end));
            client.clear();
            client.command(jog(ONE, speed));
            let speed = RotationsPerSecond(5.0);
            assert_eq!(client.sent(), [Transmit::MoveTo(Go { speed, ..go(ONE, to) })], "{begin} to {end}");
        }
        let mut client = Client::ready();
        client.receive(motor(begin, end));
        for position in [up + 0.1, down - 0.1, 25_000.0] {
            assert_eq!(client.refused(Command::MoveTo(go(ONE, position))), Some(Refusal::Outside), "{position}");
        }
        // Beyond an end, a motor goes only back.
        for (at, back, to, on) in [(up + 1.0, -5.0, down, 5.0), (down - 1.0, 5.0, up, -5.0)] {
            let mut client = client.clone();
            client.rests(1, begin + at);
            assert_eq!(client.refused(jog(ONE, on)), Some(Refusal::Outside), "{at}");
            client.command(jog(ONE, back));
            let speed = RotationsPerSecond(5.0);
            assert_eq!(client.sent(), [Transmit::MoveTo(Go { speed, ..go(ONE, to) })], "{at}");
        }
        // The motor rests at 0, the begin of the range.
        for distance in [up + 0.1, down - 0.1, 500.0] {
            assert_eq!(client.refused(Command::Bump(go(ONE, distance))), Some(Refusal::Outside), "{distance}");
        }
        client.clear();
        let half = f32::midpoint(up, down);
        client.command(Command::Bump(go(ONE, half)));
        assert_eq!(client.sent(), [Transmit::Bump(go(ONE, half))]);
        client.rests(1, begin + half);
        assert_eq!(client.refused(Command::Bump(go(ONE, up - down))), Some(Refusal::Outside), "from where it is now");
        assert_eq!(client.refused(Command::MoveTo(go(ONE, up))), None);
    }
}

/// 7.3-4: a distance counts from where a motor rests, so it is sent once, and only to a motor that rests.
#[test]
fn a_bump_is_sent_once() {
    let mut client = Client::ready();
    client.command(Command::Bump(go(TWO, -2.0)));
    assert_eq!(client.sent(), [Transmit::Bump(go(TWO, -2.0))]);
    assert_eq!(client.refused(Command::Bump(go(TWO, -2.0))), Some(Refusal::Moves));
    client.pass(9_000);
    assert_eq!(client.sent(), []);
    client.rests(2, -2.0);
    assert_eq!(client.refused(Command::Bump(go(TWO, -2.0))), None);
}

/// 7.3-8: a motor that was not known to rest may report the end of an earlier motion.
#[test]
fn a_report_that_may_be_about_an_earlier_motion_confirms_nothing() {
    let mut client = Client::ready();
    for position in [1.0, 2.0, 3.0] {
        client.command(Command::MoveTo(go(TWO, position)));
        client.pass(50);
    }
    client.rests(2, 1.0);
    assert!(client.ended().ends_with(&[Outcome::NotConfirmed]) && client.machine.may_move());
    client.command(Command::Bump(go(TWO, 1.0)));
    client.rests(2, 3.0);
    assert_eq!((client.ended(), client.machine.may_move()), (vec![Outcome::NotConfirmed], true));
    // A stop of the motor alone tells it, too, when no earlier report can come any more.
    let mut alone = client.clone();
    alone.command(Command::StopMotor(TWO));
    for _ in 0..2 {
        assert!(alone.machine.may_move());
        alone.rests(2, 3.5);
        alone.settle(PlaybackState::NO_MOVE);
        alone.pass(2_000);
    }
    assert!(alone.events().contains(&Event::Stopped(StopTarget::Motor(TWO))) && !alone.machine.may_move());
    client.command(Command::Stop);
    client.status(PlaybackState::FULL_STOP);
    client.rests(1, 3.0);
    client.rests(2, 3.5);
    client.settle(PlaybackState::FULL_STOP);
    assert!(!client.machine.may_move());
    client.clear();
    client.command(Command::Bump(go(TWO, 1.0)));
    client.rests(2, 4.5);
    assert_eq!((client.ended(), client.machine.may_move()), (vec![Outcome::Done(None)], false));
}

/// 7.3-8: that a motor does not say that it rests is told once; until it is stopped it is taken to move.
#[test]
fn a_motor_that_does_not_rest_in_time_is_told() {
    for command in [Command::MoveTo(go(TWO, 5.0)), Command::Bump(go(TWO, 5.0))] {
        let mut client = Client::ready_at(Options::default(), Endpoint::Usb);
        client.command(command);
        client.pass(119_999);
        assert_eq!(client.events(), []);
        client.pass(1);
        assert_eq!(client.events(), [Event::MotorSlow(TWO)]);
        client.pass(600_000);
        assert_eq!((client.events(), client.refused(Command::Bump(go(TWO, 5.0)))), (vec![], Some(Refusal::Moves)));
        client.command(Command::StopMotor(TWO));
        client.rests(2, 5.0);
        client.settle(PlaybackState::NO_MOVE);
        assert_eq!(client.refused(Command::Bump(go(TWO, 5.0))), None);
    }
}

/// A refusal names no motor. It ends the command that waits; of several that wait, none is confirmed by the next report.
#[test]
fn a_refused_motion_is_not_done() {
    let refused = Outcome::Refused(Refusal::Device(ErrorCode::CANNOT_EXECUTE_MOVE));
    for command in [Command::MoveTo(go(TWO, 5.0)), Command::Bump(go(TWO, 5.0))] {
        let mut client = Client::ready();
        client.command(command);
        client.error(2, 0);
        assert_eq!((client.ended(), client.machine.may_move()), (vec![refused], true));
        client.rests(2, 0.0);
        assert_eq!((client.ended(), client.machine.may_move()), (vec![], false));

        let mut client = Client::ready();
        client.command(command);
        client.command(Command::MoveTo(go(ONE, 5.0)));
        client.error(2, 0);
        client.rests(2, 0.0);
        client.rests(1, 5.0);
        assert_eq!((client.ended(), client.machine.may_move()), (vec![Outcome::NotConfirmed; 2], true));

        // The refusal may be about a jog.
        let mut client = Client::ready();
        client.command(command);
        client.command(jog(ONE, 5.0));
        client.clear();
        client.error(2, 0);
        assert_eq!(client.ended(), []);
        client.rests(2, 5.0);
        assert_eq!((client.ended(), client.machine.may_move()), (vec![Outcome::NotConfirmed], true));
    }
}

/// Commands without a meaning are not sent (decision K-N1).
#[test]
fn invalid_numbers_are_not_sent() {
    let mut client = Client::ready();
    let accelerations = [0.0, -1.0, f32::NAN, f32::INFINITY].map(RotationsPerSecondSquared);
    for acceleration in accelerations {
        let wrong = Go { acceleration, ..go(ONE, 1.0) };
        assert_eq!(client.refused(Command::MoveTo(wrong)), Some(Refusal::Number));
        assert_eq!(client.refused(Command::Bump(wrong)), Some(Refusal::Number));
        let speed = RotationsPerSecond(1.0);
        assert_eq!(client.refused(Command::Jog { motor: ONE, speed, acceleration }), Some(Refusal::Number));
    }
    for wrong in [f32::NAN, f32::INFINITY] {
        assert_eq!(client.refused(Command::MoveTo(go(ONE, wrong))), Some(Refusal::Number));
        assert_eq!(client.refused(jog(ONE, wrong)), Some(Refusal::Number));
    }
    assert_eq!(client.refused(Command::Bump(go(ONE, 0.0))), Some(Refusal::Number), "nowhere");
    assert_eq!(
        client.refused(Command::MoveTo(Go { speed: RotationsPerSecond(-1.0), ..go(ONE, 1.0) })),
        Some(Refusal::Number)
    );
    assert_eq!(client.refused(Command::MoveTo(go(MotorAddress(3), 1.0))), Some(Refusal::NoMotor));
    assert_eq!(client.refused(Command::MarkBegin(MotorAddress(3))), Some(Refusal::NoMotor));
}

/// 7.3-3, 7.3-5: both ends are marked by hand. After that the report of the device counts (decision K-M8).
#[test]
fn a_range_is_marked() {
    let mut client = Client::ready();
    assert_eq!(client.refused(Command::MarkEnd(TWO)), Some(Refusal::NotMarked));
    client.command(Command::MarkBegin(TWO));
    client.command(jog(TWO, 5.0));
    assert_eq!(client.refused(Command::MarkEnd(TWO)), Some(Refusal::Moves));
    client.command(Command::StopMotor(TWO));
    client.rests(2, 6.0);
    client.settle(PlaybackState::NO_MOVE);
    client.clear();
    client.command(Command::MarkEnd(TWO));
    assert_eq!((client.sent(), client.machine.calibration().name()), (vec![Transmit::MarkEnd(TWO)], "AwaitCalibrated"));
    assert_eq!(client.refused(Command::MarkEnd(TWO)), Some(Refusal::Busy));
    client.receive(calibrated(TWO, 6.0));
    assert_eq!((client.sent(), client.events()), (vec![Transmit::Get(Get::MotorInfo)], vec![Event::MotorChanged(TWO)]));
    assert_eq!(client.machine.calibration().name(), "AwaitRange");
    client.motor(1, 3.0, 8.0, true);
    client.motor(2, 6.0, 6.0, false);
    assert_eq!((client.events(), client.ended()), (vec![Event::Motors], vec![Outcome::Done(None)]));
    assert_eq!(client.machine.calibration().name(), "Idle");
    assert_eq!(client.refused(Command::MarkEnd(TWO)), Some(Refusal::NotMarked), "once");
}

/// 7.3-6: an error, no answer, no range or no connection is always reported, and `MarkEnd` is never sent twice.
#[test]
fn a_range_that_cannot_be_marked_ends_its_command() {
    let refused = |code| Outcome::Refused(Refusal::Device(code));
    let fails: [(Fail, Outcome<'_>); 6] = [
        (|client| client.error(14, 2), refused(ErrorCode::CALIBRATION)),
        (|client| client.error(2, 0), refused(ErrorCode::CANNOT_EXECUTE_MOVE)),
        (|client| client.pass(3_000), Outcome::NotConfirmed),
        (
            |client| {
                client.receive(calibrated(TWO, 6.0));
                client.motors();
            },
            Outcome::Failed(Failure::NoRange),
        ),
        (
            |client| {
                client.receive(calibrated(TWO, 6.0));
                client.pass(3_000);
            },
            Outcome::NotConfirmed,
        ),
        (|client| client.step(Input::LinkDown), Outcome::Failed(Failure::LinkDown)),
    ];
    for (fail, outcome) in fails {
        let mut client = Client::ready();
        client.command(Command::MarkBegin(TWO));
        client.command(Command::MarkEnd(TWO));
        client.clear();
        fail(&mut client);
        assert_eq!(client.ended(), [outcome]);
        assert!(client.sent().iter().all(|transmit| transmit.conduct().repeatable));
        assert_eq!(client.machine.calibration().name(), "Idle");
    }
}

/// 7.3-10, 7.3-11: a reset of all is not answered, so the client asks for the motors.
#[test]
fn a_reset_of_all_ranges_is_followed_by_a_question() {
    let mut client = Client::ready();
    client.command(Command::ResetAxis(ONE));
    assert_eq!(client.sent(), [Transmit::ResetAxis(ONE)]);
    client.command(Command::ResetAxis(MotorAddress::ALL));
    assert_eq!(client.sent(), [Transmit::ResetAxis(MotorAddress::ALL), Transmit::Get(Get::MotorInfo)]);
}

/// While a move runs, no motor is moved by hand, because the device would refuse or stop the move (safety decision 1).
#[test]
fn while_a_move_runs_nothing_is_moved_by_hand() {
    for client in [Client::setting_up(), Client::starting(), Client::running()] {
        for command in [
            Command::MoveTo(go(ONE, 1.0)),
            Command::Bump(go(ONE, 1.0)),
            jog(ONE, 1.0),
            Command::MarkBegin(ONE),
            Command::MarkEnd(ONE),
            Command::ResetAxis(ONE),
            Command::TakePicture(Seconds(1.0)),
            Command::RapidToFirstKeyFrame,
            Command::Play,
            load(),
        ] {
            assert_eq!(client.clone().refused(command), Some(Refusal::MoveRuns), "{command:?}");
        }
    }
}

/// A lost connection voids all reports of motion, and open stops are reported as not confirmed.
#[test]
fn a_lost_connection_leaves_stops_unconfirmed() {
    let mut client = Client::ready();
    client.command(jog(TWO, 5.0));
    client.command(Command::MoveTo(go(ONE, 5.0)));
    client.command(Command::StopMotor(ONE));
    client.clear();
    client.step(Input::LinkDown);
    assert_eq!(
        client.events(),
        [Event::StopNotConfirmed(StopTarget::Motor(ONE)), Event::LinkDown(LinkDownReason::Ended)]
    );
    client.pass(900);
    assert_eq!((client.sent(), client.events()), (vec![], vec![]), "nobody is there to be stopped");
}
