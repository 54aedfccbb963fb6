//! What goes wrong in the middle of something: stops, resets, cables, switches.

use dmc_proto::device::State;
use dmc_proto::host::Failure;
use dmc_proto::message::{FrameNumber, HostMessage, Motor, RtPositionFrame, RunFlags, StopReason};
use rigs::Rig as _;
use rigs::dmc_device::Setup;
use rigs::dmc_host::{Answer, Command, Event};

use super::stage::{Stage, jog, run, sample};

/// A crane in the middle of its run.
fn running() -> (Stage, rigs::dmc_host::Token) {
    let (_, table) = sample("crane");
    let mut stage = Stage::up(Setup::default());
    stage.upload(table.clone()).unwrap();
    let token = stage.begin(run(23_976, 1, table.last_frame().0, 500, RunFlags::empty()));
    stage.start(token).unwrap();
    stage.pass(8000);
    assert_eq!(stage.rig().state(), State::Running);
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
    assert_eq!((stage.rig().state(), stage.rig().on_frame()), (State::Idle, None));
    let failed = |event: &(_, Event)| event.1 == Event::Failed(token, Failure::Stopped);
    assert!(stage.told.iter().any(failed));
    assert!(!stage.scene.host.may_move());
}

#[test]
fn a_reset_ends_a_run_and_forgets_the_move() {
    let (mut stage, token) = running();
    stage.scene.reset();
    assert!(stage.all_rest(), "without power nothing moves");
    assert!(matches!(stage.end(token, 1000), Err(Failure::NotUp | Failure::DeviceReset)));
    assert!(stage.scene.host.may_move(), "nobody has said that it rests");
    stage.wait(5000, |event| matches!(event, Event::Up(_)).then_some(())).unwrap();
    assert!(!stage.rig().is_loaded());
    assert_eq!(stage.scene.host.is_loaded(), Some(false));
    let to_frame = RtPositionFrame { frame: FrameNumber(1), tail: &[] };
    let token = stage.begin(HostMessage::RtPositionFrame(to_frame));
    assert!(matches!(stage.end(token, 1000), Err(Failure::Refused(_) | Failure::WouldBeRefused(_))));
    assert!(stage.stop());
    assert!(!stage.scene.host.may_move());
}

#[test]
fn a_cable_that_is_pulled_stops_the_rig() {
    let (mut stage, token) = running();
    stage.scene.unplug();
    assert!(matches!(stage.end(token, 1000), Err(Failure::NotUp)));
    assert!(stage.scene.host.may_move());
    stage.pass(3000);
    assert!(stage.all_rest(), "nobody could stop it any more");
    assert_eq!(stage.rig().state(), State::Idle);
    assert!(stage.rig().is_loaded(), "it has not lost its power");
    assert!(stage.stop());
    assert!(!stage.scene.host.may_move());
}

#[test]
fn a_stop_without_a_line_waits_for_one() {
    let mut stage = Stage::up(Setup::default());
    stage.ask(jog(1, 100, i32::MAX)).unwrap();
    stage.pass(500);
    stage.scene.unplug();
    stage.scene.command(Command::Stop(dmc_proto::host::Stop::All));
    assert!(stage.wait(2000, |event| matches!(event, Event::Stopped(_)).then_some(())).is_some());
}

#[test]
fn a_reset_in_the_middle_of_an_upload_leaves_no_move() {
    let (_, table) = sample("crane");
    let mut stage = Stage::up(Setup::default());
    let token = stage.token();
    stage.scene.command(Command::Upload(token, table.clone()));
    stage.tick();
    // Everything arrives at once on a line without delay: a new upload is cut off by hand.
    stage.end(token, 1000).unwrap();
    assert!(stage.rig().is_loaded());
    let token = stage.token();
    let slow = rigs::faults::Faults { delay: 50, ..rigs::faults::Faults::NONE };
    let mut stage = Stage::new(Setup::default(), slow, 3);
    stage.wait(5000, |event| matches!(event, Event::Up(_)).then_some(())).unwrap();
    stage.scene.command(Command::Upload(token, table.clone()));
    stage.pass(200);
    assert!(!stage.rig().is_loaded(), "in the middle");
    stage.scene.reset();
    assert!(matches!(stage.end(token, 2000), Err(Failure::NotUp | Failure::DeviceReset)));
    stage.wait(5000, |event| matches!(event, Event::Up(_)).then_some(())).unwrap();
    assert!(!stage.rig().is_loaded());
    assert_eq!(stage.upload(table), Ok(Answer::Done), "and once more");
    assert!(stage.rig().is_loaded());
}

#[test]
fn a_limit_switch_ends_a_run() {
    let (_, table) = sample("slide");
    let mut setup = Setup::default();
    // Its switch is in the middle of the way.
    setup.motors[0] = setup.motors[0].clone().within(motion_core::trajectory::Range::new(-1000.0, 20_000.0));
    let mut stage = Stage::up(setup);
    stage.upload(table).unwrap();
    let token = stage.begin(run(24_000, 1, 193, 500, RunFlags::empty()));
    stage.start(token).unwrap();
    let hard = |event: &Event| (*event == Event::HardStop(StopReason::UPPER_LIMIT, Some(Motor(1)))).then_some(());
    assert!(stage.wait(10_000, hard).is_some());
    assert!(stage.told.iter().any(|(_, event)| *event == Event::Failed(token, Failure::HardStop)));
    stage.pass(100);
    assert!(stage.all_rest());
    assert_eq!(stage.steps(1), Some(20_000));
    assert_eq!(stage.rig().state(), State::Locked);
    stage.pass(3000);
    assert_eq!(stage.rig().state(), State::Idle);
}

#[test]
fn a_run_that_broke_off_unseen_is_not_told_as_done() {
    use rigs::Party as _;

    let (mut stage, token) = running();
    let now = stage.now();
    stage.rig().stall(now);
    // All that it says of it is lost, and nobody asks in the time that the run should take.
    while stage.rig().poll().is_some() {}
    assert_eq!(stage.end(token, 60_000), Err(Failure::Unclear));
    assert!(!stage.told.iter().any(|(_, event)| matches!(event, Event::HardStop(..))));
}

#[test]
fn a_run_that_is_too_fast_for_a_motor_ends_by_a_hard_stop() {
    let (_, table) = sample("slide");
    let mut stage = Stage::up(Setup::default());
    stage.upload(table).unwrap();
    // Ten times as fast as it was made for.
    let token = stage.begin(run(240_000, 1, 193, 500, RunFlags::empty()));
    stage.start(token).unwrap();
    let stuck = |event: &Event| (*event == Event::HardStop(StopReason::ENGINE_EXCEPTION, Some(Motor(1)))).then_some(());
    assert!(stage.wait(10_000, stuck).is_some());
    stage.pass(100);
    assert!(stage.all_rest());
    assert_eq!(stage.end(token, 0), Err(Failure::HardStop));
}
