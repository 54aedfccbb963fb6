//! Stops, resets, pulled cables and limit switches in the middle of a run or an upload.

use dmc_proto::Token;
use dmc_proto::device::State;
use dmc_proto::host::{self, Failure, Outcome, Refusal, StopTarget};
use dmc_proto::message::{FrameNumber, Motor, RtPositionFrame, RunFlags, StopReason};
use motion_rigs::Rig as _;
use motion_rigs::device::Named as _;
use motion_rigs::dmc_device::Setup;
use motion_rigs::dmc_host::{Answer, Command, Event};
use motion_rigs::faults::Faults;

use super::stage::{STOPPED, Stage, is_ready, jog, run, sample};

/// Stage with a crane in the middle of its run.
fn running() -> (Stage, Token) {
    let (_, table) = sample("crane");
    let mut stage = Stage::up(Setup::default());
    stage.upload(table.clone()).unwrap();
    let token = stage.begin(run(23_976, 1, table.last_frame().0, 500, RunFlags::empty()));
    stage.start(token);
    stage.pass(8000);
    assert_eq!(stage.rig().machine().state(), State::Running);
    assert!(!stage.all_rest());
    (stage, token)
}

#[test]
fn a_stop_ends_a_run() {
    let (mut stage, token) = running();
    assert!(stage.stop());
    assert_eq!(stage.rig().moment(), None);
    stage.pass(2000);
    assert!(stage.all_rest());
    assert_eq!((stage.rig().machine().state(), stage.rig().machine().on_frame()), (State::Idle, None));
    assert_eq!(stage.end(token, 0), Err(Outcome::Failed(Failure::Stopped)));
    assert!(!stage.scene.host.may_move());
}

#[test]
fn a_reset_ends_a_run_and_forgets_the_move() {
    let (mut stage, token) = running();
    stage.scene.reset();
    assert!(stage.all_rest(), "no motor moves without power");
    assert_eq!(stage.end(token, 1000), Err(Outcome::Failed(Failure::LinkDown)));
    assert!(stage.scene.host.may_move(), "the host does not know that nothing moves");
    stage.wait(5000, |event| is_ready(event).then_some(())).unwrap();
    assert!(!stage.rig().machine().is_loaded());
    assert_eq!(stage.scene.host.machine().is_loaded(), Some(false));
    let to_frame = RtPositionFrame { frame: FrameNumber(1), tail: &[] };
    let token = stage.begin(to_frame);
    assert_eq!(stage.end(token, 1000), Err(Outcome::Refused(Refusal::Stopping)), "a stop has to end the run");
    assert!(stage.stop() && stage.rests());
    let token = stage.begin(to_frame);
    assert!(matches!(stage.end(token, 1000), Err(Outcome::Refused(Refusal::Device(_)))));
    assert!(stage.stop() && stage.rests());
}

#[test]
fn a_cable_that_is_pulled_stops_the_rig() {
    let (mut stage, token) = running();
    stage.scene.unplug();
    assert_eq!(stage.end(token, 1000), Err(Outcome::Failed(Failure::LinkDown)));
    assert!(stage.scene.host.may_move());
    stage.pass(3000);
    assert!(stage.all_rest(), "the rig stops by itself");
    assert_eq!(stage.rig().machine().state(), State::Idle);
    assert!(stage.rig().machine().is_loaded(), "the rig has not lost its power");
    assert!(stage.stop() && stage.rests());
}

#[test]
fn a_stop_without_a_line_waits_for_one() {
    let mut stage = Stage::up(Setup::default());
    stage.ask(jog(1, 100, i32::MAX)).unwrap();
    stage.pass(500);
    stage.scene.unplug();
    stage.scene.command(Command::Stop(StopTarget::All));
    assert!(stage.wait(2000, |event| (*event == STOPPED).then_some(())).is_some());
}

#[test]
fn a_reset_in_the_middle_of_an_upload_leaves_no_move() {
    let (_, table) = sample("crane");
    let mut stage = Stage::up(Setup::default());
    assert_eq!(stage.upload(table.clone()), Ok(Answer::Done));
    assert!(stage.rig().machine().is_loaded());
    // Without a delay an upload takes no time at all.
    let slow = Faults { delay: 50, ..Faults::NONE };
    let mut stage = Stage::new(Setup::default(), slow, 3);
    stage.wait(5000, |event| is_ready(event).then_some(())).unwrap();
    let token = stage.token();
    stage.scene.command(Command::Upload(token, table.clone()));
    stage.pass(200);
    assert!(!stage.rig().machine().is_loaded(), "the upload is not complete");
    stage.scene.reset();
    assert_eq!(stage.end(token, 2000), Err(Outcome::Failed(Failure::LinkDown)));
    stage.wait(5000, |event| is_ready(event).then_some(())).unwrap();
    assert!(!stage.rig().machine().is_loaded());
    assert_eq!(stage.upload(table), Ok(Answer::Done), "the next upload succeeds");
    assert!(stage.rig().machine().is_loaded());
}

#[test]
fn a_limit_switch_ends_a_run() {
    let (_, table) = sample("slide");
    let mut setup = Setup::default();
    // The limit switch is in the middle of the move.
    setup.motors[0] = setup.motors[0].clone().within(motion_core::trajectory::Range::new(-1000.0, 20_000.0));
    let mut stage = Stage::up(setup);
    stage.upload(table).unwrap();
    let token = stage.begin(run(24_000, 1, 193, 500, RunFlags::empty()));
    stage.start(token);
    let hard = |event: &Event| {
        (*event == Event::Machine(host::Event::HardStop(StopReason::UPPER_LIMIT, Some(Motor(1))))).then_some(())
    };
    assert!(stage.wait(10_000, hard).is_some());
    assert_eq!(stage.end(token, 0), Err(Outcome::Failed(Failure::HardStop)));
    stage.pass(100);
    assert!(stage.all_rest());
    assert_eq!(stage.steps(1), Some(20_000));
    assert_eq!(stage.rig().machine().state(), State::Locked);
    stage.pass(3000);
    assert_eq!(stage.rig().machine().state(), State::Idle);
}

#[test]
fn a_run_that_ended_early_is_not_reported_as_done() {
    use motion_rigs::Party as _;

    let (mut stage, token) = running();
    let now = stage.now();
    stage.rig().stall(now);
    // The news of it is lost, and the host does not ask before the run should be over.
    while stage.rig().poll().is_some() {}
    assert_eq!(stage.end(token, 60_000), Err(Outcome::NotConfirmed));
    assert!(!stage.told.iter().any(|(_, event)| matches!(event, Event::Machine(host::Event::HardStop(..)))));
}

#[test]
fn a_run_that_is_too_fast_for_a_motor_ends_by_a_hard_stop() {
    let (_, table) = sample("slide");
    let mut stage = Stage::up(Setup::default());
    stage.upload(table).unwrap();
    // The run is ten times as fast as the move was made for.
    let token = stage.begin(run(240_000, 1, 193, 500, RunFlags::empty()));
    stage.start(token);
    let stuck = |event: &Event| {
        (*event == Event::Machine(host::Event::HardStop(StopReason::ENGINE_EXCEPTION, Some(Motor(1))))).then_some(())
    };
    assert!(stage.wait(10_000, stuck).is_some());
    stage.pass(100);
    assert!(stage.all_rest());
    assert_eq!(stage.end(token, 0), Err(Outcome::Failed(Failure::HardStop)));
}

#[test]
fn a_rig_without_motors_rests_after_a_stop() {
    for device in Setup::DEVICES {
        let mut stage = Stage::up(Setup::with_motors(0).with_device(device.name).unwrap());
        assert!(stage.stop() && stage.rests(), "{}", device.name);
        // The stop is the first message on this line.
        let mut stage = Stage::new(Setup::with_motors(0).with_device(device.name).unwrap(), Faults::NONE, 1);
        assert!(stage.stop() && stage.rests(), "{}", device.name);
    }
}
