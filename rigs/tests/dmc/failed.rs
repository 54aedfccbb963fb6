//! Runs and shots that a device refuses or ends by itself, and what all motors do after them.

use dmc_proto::device::{Quirks, State};
use dmc_proto::host::{Outcome, Refusal};
use dmc_proto::message::{
    AckCode, FrameNumber, FramesPerSecond, HardwareLimitSet, Motor, MotorConfigure, MotorFlags, MotorSetLimits,
    RtJogAll, RtPositionFrame, RunFlags, Scaled,
};
use motion_rigs::dmc_host::{Answer, Command, Shot};

use super::motors::limits;
use super::stage::{Stage, devices, move_to, run, sample};

const fn to_frame(frame: i32) -> RtPositionFrame<'static> {
    RtPositionFrame { frame: FrameNumber(frame), tail: &[] }
}

const fn jog_all(frame: i32) -> RtJogAll<'static> {
    RtJogAll { fps_x1000: FramesPerSecond(Scaled(24_000)), destination: FrameNumber(frame), tail: &[] }
}

/// D-97: a device goes to the start of a run that it refused, past the limit, with the next jog of all motors.
#[test]
fn after_a_run_that_was_refused_a_jog_of_all_motors_stays_within_the_limits() {
    for (setup, quirks) in devices() {
        let (_, table) = sample("slide");
        let mut stage = Stage::up(setup);
        let place = |frame: i32| table.steps(Motor(1), FrameNumber(frame)).unwrap();
        stage.upload(table.clone()).unwrap();
        let (first, last) = (place(97), place(110));
        let limits = limits(1, first.min(last) - 10, first.max(last) + 5000);
        stage.ask(MotorSetLimits { hw_set: HardwareLimitSet(0), ..limits }).unwrap();
        let token = stage.begin(run(24_000, 97, 110, 1000, RunFlags::empty()));
        let refused = Outcome::Refused(Refusal::Device(AckCode::ERR_PREROLL));
        assert_eq!(stage.end(token, 60_000), Err(refused), "{quirks:?}");
        let mut token = stage.begin(jog_all(110));
        for _ in 0..5000 {
            if stage.end(token, 60_000) != Err(Outcome::Refused(Refusal::Stopping)) {
                break;
            }
            stage.tick();
            token = stage.begin(jog_all(110));
        }
        for _ in 0..10_000 {
            stage.tick();
            let here = stage.at(1);
            let within = f64::from(first.min(last)) - 10.0..=f64::from(first.max(last)) + 10.0;
            assert!(within.contains(&here), "{}: {here}", stage.rig().name());
        }
        assert_eq!(stage.end(token, 0), Ok(Answer::Done));
        assert_eq!(stage.steps(1), Some(last), "{}", stage.rig().name());
        assert!(stage.rests());
    }
}

/// D-98: a device ends a run without a word if a motor that is driven by hand moves to a position.
#[test]
fn a_run_that_a_move_of_a_motor_ended_is_not_done() {
    for (setup, quirks) in devices() {
        for is_shot in [false, true] {
            let (_, table) = sample("slide");
            let mut stage = Stage::up(setup.clone());
            stage.upload(table.clone()).unwrap();
            let flags = MotorFlags::ENABLED | MotorFlags::LIVE;
            stage.ask(MotorConfigure { motor: Motor(2), flags, tail: &[] }).unwrap();
            let token = if is_shot {
                let token = stage.token();
                stage.scene.command(Command::Shoot(token, Shot::of(FrameNumber(97), 3000)));
                token
            } else {
                stage.begin(run(24_000, 97, 145, 200, RunFlags::empty()))
            };
            stage.start(token);
            stage.pass(1000);
            assert_eq!(stage.rig().machine().state(), State::Running, "this is the scene");
            stage.ask(move_to(2, 3000)).unwrap();
            let ends = quirks.contains(Quirks::MOVE_ENDS_RUN);
            // Without news of its end, the host cannot know whether a shot went on.
            let unknown = ends || (is_shot && quirks.contains(Quirks::NO_END_OF_SHOT));
            let wanted = if unknown { Err(Outcome::NotConfirmed) } else { Ok(Answer::Done) };
            assert_eq!(stage.end(token, 30_000), wanted, "{}", stage.rig().name());
            assert_eq!(stage.steps(2), Some(3000));
            let done = table.steps(Motor(1), FrameNumber(145));
            assert!(is_shot || !ends || stage.steps(1) != done, "the run was ended");
            stage.pass(1000);
            assert!(stage.rests(), "{}", stage.rig().name());
            let token = stage.begin(to_frame(90));
            assert_eq!(stage.end(token, 60_000), Ok(Answer::Done));
        }
    }
}

/// A stop ends a jog of all motors also when it has hardly begun, and it stops a motor that is driven by hand too.
#[test]
fn a_stop_ends_a_jog_of_all_motors_at_any_moment() {
    for (setup, _) in devices() {
        for after in [0, 1, 2, 40, 500] {
            let (_, table) = sample("slide");
            let mut stage = Stage::up(setup.clone());
            stage.upload(table).unwrap();
            let token = stage.begin(to_frame(97));
            assert_eq!(stage.end(token, 60_000), Ok(Answer::Done));
            let flags = MotorFlags::ENABLED | MotorFlags::LIVE;
            stage.ask(MotorConfigure { motor: Motor(2), flags, tail: &[] }).unwrap();
            stage.begin(jog_all(145));
            stage.ask(move_to(2, 100_000)).unwrap();
            stage.pass(after);
            assert!(stage.stop(), "{} after {after} ms", stage.rig().name());
            stage.pass(4000);
            assert!(stage.all_rest(), "{} after {after} ms: {}, {}", stage.rig().name(), stage.at(1), stage.at(2));
        }
    }
}
