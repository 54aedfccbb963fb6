//! Host: runs and shots that fail. DMC D5.

use dmc_proto::host::{Command, Contents, Event, Progress, Refusal, StopTarget};
use dmc_proto::message::{AckCode, HardStop, MotorMoving, RtEnd, RtGo, RunFlags, StopReason};

use super::bench::{Desk, answered, done, jog_all, move_to, named, not_confirmed, position_frame, refused, run, shot};

const OK: AckCode = AckCode::OK;
const SILENT: Contents = Contents::Stop(StopTarget::AllSilent);
const STOPPED: Event<'static> = Event::Stopped(StopTarget::AllSilent);

/// Time until the host asks whether a run of ten frames is over, in milliseconds.
const LASTS: u64 = 6400;

/// Nothing that moves all motors is sent, and single motors move if no stop is under way.
fn holds_back(desk: &mut Desk, moves_one: bool) {
    let forbidden = vec![refused(7, Refusal::Stopping)];
    for message in [position_frame(1), jog_all(3), run(1, 10, RunFlags(0)), shot(1)] {
        assert_eq!(desk.sequence(7, message), (vec![], forbidden.clone()), "{message}");
    }
    if !moves_one {
        assert_eq!(desk.request(7, move_to(2, 5)), (vec![], forbidden));
    }
}

/// D5-25, D-97: a device keeps a run that it refused, and a jog of all motors would go to its start.
#[test]
fn after_a_run_that_was_refused_a_stop_comes_before_the_next_motion() {
    for code in [AckCode::ERR_PREROLL, AckCode::ERR_POSTROLL, AckCode::ERR_SOFT_UP, AckCode::ERR_GENERAL] {
        let mut desk = Desk::up();
        desk.sequence(1, shot(1));
        let told = vec![refused(1, Refusal::Device(code))];
        assert_eq!(desk.acked(2, 0x0115, code), (vec![(3, SILENT)], told));
        holds_back(&mut desk, false);
        assert_eq!(desk.pass(250).0, [(4, Contents::Status)]);
        assert_eq!(desk.status(4, 0), (vec![], vec![]), "motors rest anyway");
        holds_back(&mut desk, false);
        assert_eq!(desk.pass(250).0, [(5, SILENT)], "the stop was lost");
        assert_eq!(desk.acked(5, 0x0033, OK), (vec![], vec![STOPPED]));
        assert_eq!(desk.sequence(2, jog_all(3)).0, [(6, named(2))]);
    }
}

/// D-97
#[test]
fn a_stop_that_is_given_up_lets_no_motion_of_all_motors_follow_a_run() {
    let mut desk = Desk::up();
    desk.sequence(1, shot(1));
    desk.acked(2, 0x0115, AckCode::ERR_PREROLL);
    desk.command(Command::EndStops);
    holds_back(&mut desk, true);
    assert_eq!(desk.stop(StopTarget::All).0, [(4, Contents::Stop(StopTarget::All))]);
    desk.acked(4, 0x0033, OK);
    assert_eq!(desk.sequence(2, position_frame(1)).0, [(5, named(2))]);
}

/// D-97: a device that stopped hard refuses stops for some time, so that the machine sends none by itself.
#[test]
fn after_a_hard_stop_in_a_run_a_stop_comes_before_the_next_motion() {
    let mut desk = Desk::up();
    desk.sequence(1, shot(1));
    desk.acked(2, 0x0115, OK);
    let stop = HardStop { reason: StopReason::EMERGENCY_STOP, motor: None, tail: &[] };
    assert_eq!(desk.receives(0, stop.into()).0, []);
    holds_back(&mut desk, true);
    desk.stop(StopTarget::All);
    desk.acked(3, 0x0033, OK);
    assert_eq!(desk.sequence(2, position_frame(1)).0, [(4, named(2))]);
}

/// A way to a frame that is refused leaves nothing behind.
#[test]
fn after_a_way_to_a_frame_that_was_refused_no_stop_is_sent() {
    let mut desk = Desk::up();
    for (id, message) in [(2, position_frame(1)), (3, run(1, 10, RunFlags(0)))] {
        desk.sequence(1, message);
        let told = vec![refused(1, Refusal::Device(AckCode::ERR_SOFT_UP))];
        assert_eq!(desk.acked(id, 0x0110, AckCode::ERR_SOFT_UP), (vec![], told));
    }
    assert_eq!(desk.sequence(1, jog_all(1)).0, [(4, named(1))]);
}

/// Host whose device runs, in which a motor that is driven by hand was moved. The next id is 8.
fn moved(flags: RunFlags) -> Desk {
    let mut desk = Desk::up();
    desk.sequence(1, run(1, 10, flags));
    desk.acked(2, 0x0110, OK);
    desk.pass(100);
    desk.status(3, 0);
    desk.acked(4, 0x0111, OK);
    for id in [5, 6] {
        desk.pass(100);
        desk.status(id, 0);
    }
    desk.receives(0, RtGo::default().into());
    assert_eq!(desk.request(2, move_to(3, 5)).0, [(7, named(2))]);
    let answer = MotorMoving { moving: true.into(), tail: &[] };
    assert_eq!(desk.receives(7, answer.into()).1, [answered(2, answer.into())]);
    assert_eq!(desk.machine.progress(), Some(Progress::Runs));
    desk
}

/// D5-20, D-98: a device ends a run without a word if a motor that is driven by hand moves to a position.
#[test]
fn a_run_that_a_move_of_a_motor_may_have_ended_is_not_done_without_its_end() {
    for flags in [RunFlags(0), RunFlags::LOOP] {
        let mut desk = moved(flags);
        assert_eq!(desk.pass(LASTS), (vec![(8, Contents::Status)], vec![]));
        assert_eq!(desk.status(8, 0b100), (vec![], vec![]));
        assert_eq!(desk.pass(100).0, [(9, Contents::Status)]);
        assert_eq!(desk.status(9, 0), (vec![], vec![]));
        assert_eq!(desk.pass(100).0, [(10, Contents::Status)]);
        assert_eq!(desk.status(10, 0), (vec![(11, SILENT)], vec![not_confirmed(1)]));
    }
}

/// D-98
#[test]
fn a_run_whose_end_is_told_is_done_although_a_motor_was_moved() {
    for is_late in [false, true] {
        let mut desk = moved(RunFlags(0));
        let mut id = 8;
        if is_late {
            assert_eq!(desk.pass(LASTS).0, [(id, Contents::Status)]);
            id += 1;
        }
        desk.receives(0, RtEnd::default().into());
        desk.pass(100);
        desk.status(id, 0);
        desk.pass(100);
        assert_eq!(desk.status(id + 1, 0), (vec![], vec![done(1)]));
    }
}
