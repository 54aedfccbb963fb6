//! What goes wrong: ends of the rig, motors that get stuck or are not there, power and cables.

use hoot_proto::HostMessage;
use hoot_proto::device::{Input, ProgramState};
use hoot_proto::host::{Command, Event as Told};
use hoot_proto::message::{self, Milliseconds, Motor, ProgramMode, Steps};
use motion_core::trajectory::Range;
use motion_core::wire::Bool;
use rigs::Rig;
use rigs::hoot_node::Setup;

use crate::world::{NODE, ONE, START, STOP, dead_man, millis, mode, move_by, planned, run, smooth, stage};

/// At the end of the rig the motor stops dead, and the program pauses: the other motor stops as well.
#[test]
fn an_end_of_the_rig_stops_a_program() {
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

/// A limit that was set stops a motor before the end of the rig.
#[test]
fn an_end_limit_stops_a_motor() {
    let mut stage = stage(Setup::default());
    stage.enable(ONE, 1000.0);
    stage.ok(move_by(ONE, 500));
    stage.pass(2000);
    stage.ok(HostMessage::MotorSetEndHere(message::MotorSetEndHere { motor: ONE }));
    stage.ok(HostMessage::MotorSendHome(message::MotorSendHome { motor: ONE }));
    stage.pass(2000);
    stage.ok(run(ONE));
    stage.until(3000, |stage| stage.is_at_rest());
    let place = stage.position(ONE);
    assert!((500..=501).contains(&place), "{place}: looked at every millisecond, a step too far at the most");
}

#[test]
fn a_motor_gets_stuck() {
    let mut stage = stage(Setup::default());
    stage.enable(ONE, 1000.0);
    stage.ok(run(ONE));
    stage.pass(300);
    stage.scene.rig.stall(millis(stage.now()));
    assert!(stage.is_at_rest() && !stage.is_running(ONE));
}

/// Who moves a motor that is not plugged in finds it at rest, where it was.
#[test]
fn a_motor_is_not_there() {
    let mut stage = stage(Setup::with_motors(1));
    assert_eq!(stage.scene.rig.motors().len(), 1);
    stage.enable(Motor::Two, 1000.0);
    stage.ok(move_by(Motor::Two, 500));
    stage.pass(100);
    assert!(!stage.is_running(Motor::Two));
    assert_eq!(stage.position(Motor::Two), 0);
}

/// The power fails in the middle: everything rests, what is stored stays, and the node says that the power was off.
#[test]
fn a_reset_in_the_middle() {
    let mut stage = stage(Setup::default());
    stage.ok(mode(ProgramMode::VIDEO));
    stage.enable(ONE, 1000.0);
    for message in planned(ONE, 0, smooth()) {
        stage.ok(message);
    }
    let power = message::PowerCycled {};
    assert_eq!(stage.ok(HostMessage::PowerCycled(power)).read(&power), Some(Bool::TRUE));
    assert_eq!(stage.ok(HostMessage::PowerCycled(power)).read(&power), Some(Bool::FALSE));
    stage.ok(START);
    stage.pass(1000);
    let place = stage.place(0);
    stage.scene.reset();
    assert!(stage.is_at_rest() && stage.program() == ProgramState::Stopped);
    assert!(stage.scene.host.may_move(), "nobody knows");
    stage.pass(20);
    assert_eq!(stage.ok(HostMessage::PowerCycled(power)).read(&power), Some(Bool::TRUE));
    assert!((f64::from(stage.position(ONE)) - place).abs() < 5.0);
    assert_eq!(stage.scene.rig.machine().motor(ONE).settings().plan, smooth());
    stage.ok(crate::world::STATUS);
    assert!(!stage.is_running(ONE) && stage.scene.host.may_move(), "three motors were set off");
    stage.ok(STOP);
    assert!(!stage.scene.host.may_move());
}

/// Somebody pulls the cable: what waits ends, the dead-man stops the motor, and an emergency stop that was asked for
/// without a line is carried out when there is one.
#[test]
fn the_cable_is_pulled_in_the_middle() {
    let mut stage = stage(Setup::default());
    stage.enable(ONE, 1000.0);
    stage.ok(dead_man(Bool::TRUE));
    stage.ok(run(ONE));
    let token = stage.send_to(NODE, crate::world::STATUS);
    stage.scene.unplug();
    stage.scene.command(Command::EmergencyStop);
    stage.tick();
    let ended = stage.ended.iter().find(|ended| ended.token == token).unwrap();
    assert!(!ended.is_done(), "{ended}");
    assert!(stage.told.iter().any(|(_, told)| *told == Told::StopNotConfirmed { node: None }), "{:?}", stage.told);
    stage.until(3000, |stage| stage.told.iter().any(|(_, told)| *told == Told::StopConfirmed));
    assert!(stage.is_at_rest() && !stage.scene.host.may_move());
}

/// Without a dead-man a program outlives its master, as time lapses do; the next one can stop it.
#[test]
fn a_program_outlives_its_line() {
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

/// The greatest run time ends a program, and the button at the node pauses one.
#[test]
fn other_ends_of_a_program() {
    let mut stage = stage(Setup::default());
    stage.ok(mode(ProgramMode::VIDEO));
    stage.enable(ONE, 1000.0);
    for message in planned(ONE, 0, smooth()) {
        stage.ok(message);
    }
    stage.ok(HostMessage::SetMaxRunTime(message::SetMaxRunTime { max_run_time: Milliseconds(1000) }));
    stage.ok(START);
    stage.until(1200, |stage| stage.program() == ProgramState::Stopped);
    assert!(stage.is_at_rest() && stage.place(0) < 6000.0);
    stage.ok(START);
    let now = millis(stage.now());
    stage.scene.rig.touch(now, Input::Command(hoot_proto::device::Command::EmergencyStop));
    assert!(stage.is_at_rest() && stage.program() == ProgramState::Paused);
}

/// Firmware reads packet by packet: what comes together with one, or behind a wrong byte, is lost.
#[test]
fn a_node_reads_like_firmware() {
    let mut stage = stage(Setup::default());
    let ask = [0, 0, 0, 0, 0, 0xFF, 3, 0, 101, 0];
    let answers = |stage: &mut crate::world::Stage<_>, bytes: &[u8]| {
        let before = stage.scene.host.strays();
        stage.scene.inject(rigs::Side::Host, bytes);
        stage.pass(300);
        stage.scene.host.strays() - before
    };
    assert_eq!(answers(&mut stage, &ask), 1);
    assert_eq!(answers(&mut stage, &[ask, ask].concat()), 1);
    assert_eq!(answers(&mut stage, &[&[0][..], &ask].concat()), 0);
    assert_eq!(answers(&mut stage, &ask), 1, "100 ms of silence, and it is in step again");
}
