//! Trouble: ends of the rig, motors that get stuck or are not plugged in, power and cables.

use hoot_proto::device::{ProgramState, Session};
use hoot_proto::host::{Command, Event, StopTarget};
use hoot_proto::message::{self, Milliseconds, Motor, ProgramMode, Steps};
use motion_core::trajectory::Range;
use motion_core::wire::Bool;
use motion_rigs::Rig;
use motion_rigs::hoot_node::Setup;

use crate::world::{NODE, ONE, START, STOP, dead_man, millis, mode, move_by, planned, run, smooth, stage};

/// The motor that reaches the end of the rig stops at once. The program pauses, so the other motor stops too.
#[test]
fn an_end_of_the_rig_pauses_a_program() {
    let mut stage = stage(Setup::default().with_travel(Range::new(-4000.0, 4000.0)));
    stage.ok(mode(ProgramMode::VIDEO));
    let plan = hoot_proto::program::Plan { stop: Steps(2000), ..smooth() };
    for (motor, plan) in [(ONE, smooth()), (Motor::Two, plan)] {
        stage.enable(motor, 1000.0);
        for message in planned(motor, 0, plan) {
            stage.ok(message);
        }
    }
    stage.ok(START);
    stage.until(3000, |stage| stage.program() == ProgramState::Paused);
    assert!(stage.is_at_rest());
    assert_eq!((stage.position(ONE), stage.place(0).to_bits()), (4000, 4000.0_f64.to_bits()));
    assert!(stage.position(Motor::Two) < 2000);
    assert!(!stage.is_running(ONE) && !stage.is_running(Motor::Two));
}

#[test]
fn an_end_limit_stops_a_motor_before_the_end_of_the_rig() {
    let mut stage = stage(Setup::default());
    stage.enable(ONE, 1000.0);
    stage.ok(move_by(ONE, 500));
    stage.pass(2000);
    stage.ok(message::MotorSetEndHere { motor: ONE });
    stage.ok(message::MotorSendHome { motor: ONE });
    stage.pass(2000);
    stage.ok(run(ONE));
    stage.until(3000, |stage| stage.is_at_rest());
    let place = stage.position(ONE);
    assert!(
        (500..=501).contains(&place),
        "{place}: positions are compared each millisecond, so it is at most a step too far"
    );
}

#[test]
fn a_motor_that_gets_stuck_is_reported_at_rest() {
    let mut stage = stage(Setup::default());
    stage.enable(ONE, 1000.0);
    stage.ok(run(ONE));
    stage.pass(300);
    stage.scene.rig.stall(millis(stage.now()));
    assert!(stage.is_at_rest() && !stage.is_running(ONE));
}

#[test]
fn a_motor_that_is_not_plugged_in_is_reported_at_rest_where_it_was() {
    let mut stage = stage(Setup::with_motors(1));
    assert_eq!(stage.scene.rig.motors().len(), 1);
    stage.enable(Motor::Two, 1000.0);
    stage.ok(move_by(Motor::Two, 500));
    stage.pass(100);
    assert!(!stage.is_running(Motor::Two));
    assert_eq!(stage.position(Motor::Two), 0);
}

/// The node tells, once, that the power was off.
#[test]
fn after_a_power_failure_everything_rests_and_settings_remain() {
    let mut stage = stage(Setup::default());
    stage.ok(mode(ProgramMode::VIDEO));
    stage.enable(ONE, 1000.0);
    for message in planned(ONE, 0, smooth()) {
        stage.ok(message);
    }
    let power = message::PowerCycled {};
    assert_eq!(stage.read(power), Bool::TRUE);
    assert_eq!(stage.read(power), Bool::FALSE);
    stage.ok(START);
    stage.pass(1000);
    let place = stage.place(0);
    stage.scene.reset();
    assert!(stage.is_at_rest() && stage.program() == ProgramState::Stopped);
    assert!(stage.may_move(), "the master does not know that the motors rest");
    stage.pass(20);
    assert_eq!(stage.read(power), Bool::TRUE);
    assert!((f64::from(stage.position(ONE)) - place).abs() < 5.0);
    assert_eq!(stage.scene.rig.machine().motor(ONE).settings().plan, smooth());
    stage.ok(crate::world::STATUS);
    assert!(!stage.is_running(ONE) && stage.may_move(), "a program may move three motors");
    stage.ok(STOP);
    assert!(!stage.may_move());
}

/// Commands that wait end, and the dead-man stops the motor.
#[test]
fn an_emergency_stop_without_a_line_is_made_when_the_line_is_back() {
    let mut stage = stage(Setup::default());
    stage.enable(ONE, 1000.0);
    stage.ok(dead_man(true));
    stage.ok(run(ONE));
    let token = stage.send_to(NODE, crate::world::STATUS);
    stage.scene.unplug();
    stage.command(Command::EmergencyStop);
    stage.tick();
    let ended = stage.ended.iter().find(|ended| ended.token == token).unwrap();
    assert!(!ended.is_done(), "{ended}");
    assert!(stage.has_event(Event::StopNotConfirmed(StopTarget::All)), "{:?}", stage.events);
    assert!(stage.may_move());
    // For 3 s after the line came up the node may be deaf, and is sent one stop.
    stage.until(5000, |stage| stage.has_event(Event::Stopped(StopTarget::All)));
    assert!(stage.is_at_rest() && !stage.may_move());
}

/// Time lapses need no master while they run, and a master that connects again can stop them.
#[test]
fn without_a_dead_man_a_program_goes_on_without_a_line() {
    let mut stage = stage(Setup::default());
    stage.ok(mode(ProgramMode::VIDEO));
    stage.enable(ONE, 1000.0);
    for message in planned(ONE, 0, smooth()) {
        stage.ok(message);
    }
    stage.ok(START);
    stage.scene.unplug();
    stage.pass(1000);
    assert!(!stage.is_at_rest());
    stage.ok(STOP);
    assert!(stage.is_at_rest());
}

#[test]
fn the_greatest_run_time_ends_a_program_and_the_button_pauses_one() {
    let mut stage = stage(Setup::default());
    stage.ok(mode(ProgramMode::VIDEO));
    stage.enable(ONE, 1000.0);
    for message in planned(ONE, 0, smooth()) {
        stage.ok(message);
    }
    stage.ok(message::SetMaxRunTime { max_run_time: Milliseconds(1000) });
    stage.ok(START);
    stage.until(1200, |stage| stage.program() == ProgramState::Stopped);
    assert!(stage.is_at_rest() && stage.place(0) < 6000.0);
    stage.ok(START);
    let now = millis(stage.now());
    stage.scene.rig.touch(now, Session::stop);
    assert!(stage.is_at_rest() && stage.program() == ProgramState::Paused);
}

/// Firmware loses bytes that come together with a packet or after a wrong byte.
#[test]
fn a_node_reads_one_packet_at_a_time_as_firmware_does() {
    let mut stage = stage(Setup::default());
    let ask = [0, 0, 0, 0, 0, 0xFF, 3, 0, 101, 0];
    let answers = |stage: &mut crate::world::Stage<_>, bytes: &[u8]| {
        let before = stage.scene.host.strays();
        stage.scene.inject(motion_rigs::Side::Host, bytes);
        stage.pass(300);
        stage.scene.host.strays() - before
    };
    assert_eq!(answers(&mut stage, &ask), 1);
    assert_eq!(answers(&mut stage, &[ask, ask].concat()), 1);
    assert_eq!(answers(&mut stage, &[&[0][..], &ask].concat()), 0);
    assert_eq!(answers(&mut stage, &ask), 1, "after 100 ms of silence the node reads packets again");
}
