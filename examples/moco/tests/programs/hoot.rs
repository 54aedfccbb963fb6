//! Scenarios of hoot, over TCP and a pseudo-terminal.

use motion_move::Move;

use crate::process::{Program, Rig, Scenario, cut, done_or_at_rest, file, interrupted, missed, within};
use crate::record::{Planned, Row, is_at, last};

/// Move of two seconds between two key frames, which a node can plan.
const MOVE: &str = r#"{
    "move": 1, "name": "Short", "rate": 24, "duration": 2.5,
    "axes": [
        { "name": "Pan", "unit": "degrees", "limits": { "velocity": 80, "acceleration": 200 },
          "keys": [ { "time": 0.25, "position": 0 }, { "time": 2.25, "position": 45 } ],
          "hoot": { "motor": 2, "steps_per_unit": 80 } }
    ]
}"#;

/// Checks that the motor followed the curve of the move file. The tolerance is the greatest deviation of its plan,
/// which is one step, one step for rounding, and half a millisecond at 2700 steps per second.
#[track_caller]
fn check(rows: &[Row]) {
    let planned = Move::parse("move", MOVE).unwrap();
    let axis = &planned.axes()[0];
    let (scale, curve) = (axis.hoot().unwrap().scale, axis.curve());
    let position = |millis: f64| f64::from(scale.steps(curve.position(millis / 1000.0)).unwrap());
    Planned { motor: 2, moments: (0.0, 2250.0), rate: 1000.0, position, tolerance: 3.5 }.check(rows);
}

pub(crate) const SCENARIOS: &[Scenario] = &[
    ("hoot_a_program_over_a_terminal", |test| video(test, "--pty")),
    ("hoot_a_program_over_tcp", |test| video(test, "--tcp")),
    ("hoot_photos_over_a_terminal", |test| photos(test, "--pty")),
    ("hoot_photos_over_tcp", |test| photos(test, "--tcp")),
    ("hoot_ctrl_c_stops_the_motors_first", ctrl_c_stops_the_motors_first),
    ("hoot_without_its_master_a_jog_ends", without_its_master_a_jog_ends),
    ("hoot_without_its_master_a_program_goes_on", without_its_master_a_program_goes_on),
    ("hoot_without_its_master_a_program_pauses_after_a_second", without_its_master_a_program_pauses),
    ("hoot_a_rig_that_is_killed_between_photos_is_reported", a_rig_that_is_killed_between_photos),
    ("hoot_a_rig_that_is_killed_is_reported", |test| a_rig_that_is_killed_is_reported(test, "--pty")),
    ("hoot_a_rig_that_is_killed_is_reported_over_tcp", |test| a_rig_that_is_killed_is_reported(test, "--tcp")),
    ("hoot_a_broken_connection_is_made_again_for_a_stop", a_broken_connection_is_made_again_for_a_stop),
    ("hoot_with_all_faults_1", |test| with_all_faults(test, "--pty", "1")),
    ("hoot_with_all_faults_2", |test| with_all_faults(test, "--pty", "2")),
    ("hoot_with_all_faults_3", |test| with_all_faults(test, "--tcp", "3")),
];

fn video(test: &str, line: &str) {
    let path = file(test, MOVE);
    let rig = Rig::start(test, "hoot", &[line]);
    assert!(rig.drive(&["info"]).done().contains("motor 3"));
    rig.drive(&["run", path.to_str().unwrap()]).done();
    let rows = rig.end();
    check(&rows);
    assert!(is_at(last(&rows, 2), 3600.0));
}

/// Arguments for four photos along a move.
fn shots(path: &str) -> [&str; 8] {
    ["program", path, "--shots", "4", "--interval", "1", "--exposure", "0.1"]
}

fn photos(test: &str, line: &str) {
    let path = file(test, MOVE);
    let rig = Rig::start(test, "hoot", &[line]);
    let said = rig.drive(&shots(path.to_str().unwrap())).done();
    assert!(said.ends_with("4 photos are taken, and all motors rest\n"), "{said}");
    assert_eq!(rig.log().matches("photo ").count(), 4);
    assert!(is_at(last(&rig.end(), 2), 3600.0));
}

fn ctrl_c_stops_the_motors_first(test: &str) {
    let path = file(test, MOVE);
    let rig = Rig::start(test, "hoot", &[]);
    // A program whose motors move must not be suspended.
    let rows =
        interrupted(rig, &["run", path.to_str().unwrap()], &["jog", "1", "500", "--for", "30"], Program::suspend);
    assert!(last(&rows, 2) > 0.0 && last(&rows, 2) < 3600.0, "{}", last(&rows, 2));
    assert!(last(&rows, 1) > 20.0 && last(&rows, 1) < 5000.0, "{}", last(&rows, 1));
}

/// The dead-man switch stops a jog without its master.
fn without_its_master_a_jog_ends(test: &str) {
    let rig = Rig::start(test, "hoot", &[]);
    let drive = rig.begin(&["jog", "1", "500", "--for", "30"]);
    rig.moves(1);
    drive.kill();
    rig.rests();
    rig.drive(&["stop"]).done();
    assert!(rig.drive(&["info"]).done().contains("motor 1"));
    let rows = rig.end();
    assert!(last(&rows, 1) > 20.0 && last(&rows, 1) < 5000.0, "{}", last(&rows, 1));
}

fn without_its_master_a_program_goes_on(test: &str) {
    let path = file(test, MOVE);
    let rig = Rig::start(test, "hoot", &[]);
    let drive = rig.begin(&["run", path.to_str().unwrap()]);
    rig.plays();
    drive.kill();
    assert!(rig.drive(&["info"]).done().contains("motor 1"));
    rig.rests();
    check(&rig.end());
}

fn without_its_master_a_program_pauses(test: &str) {
    let path = file(test, MOVE);
    let rig = Rig::start(test, "hoot", &[]);
    let drive = rig.begin(&shots(path.to_str().unwrap()));
    rig.plays();
    drive.kill();
    within("the dead-man switch", || rig.log().contains("program: Paused").then_some(()));
    rig.rests();
    assert!(rig.drive(&["info"]).done().contains("motor 1"));
    assert!(last(&rig.end(), 2) < 3600.0);
}

fn a_rig_that_is_killed_between_photos(test: &str) {
    let path = file(test, MOVE);
    let rig = Rig::start(test, "hoot", &[]);
    let drive = rig.begin(&shots(path.to_str().unwrap()));
    missed(rig, drive);
}

fn a_broken_connection_is_made_again_for_a_stop(test: &str) {
    let path = file(test, MOVE);
    let rows = cut(Rig::start(test, "hoot", &["--tcp"]), &["run", path.to_str().unwrap()]);
    assert!(last(&rows, 2) < 3600.0, "{}", last(&rows, 2));
}

fn a_rig_that_is_killed_is_reported(test: &str, line: &str) {
    let path = file(test, MOVE);
    let rig = Rig::start(test, "hoot", &[line]);
    let drive = rig.begin(&["run", path.to_str().unwrap()]);
    missed(rig, drive);
}

fn with_all_faults(test: &str, line: &str, seed: &str) {
    let path = file(test, MOVE);
    let path = path.to_str().unwrap();
    let rig = Rig::start(test, "hoot", &["--faults", "all", "--seed", seed, line]);
    done_or_at_rest(&rig, rig.drive(&shots(path)));
    let before = rig.rows();
    let is_done = done_or_at_rest(&rig, rig.drive(&["run", path]));
    let rows = rig.end();
    if is_done {
        check(&rows[before..]);
        assert!(is_at(last(&rows, 2), 3600.0), "{}", last(&rows, 2));
    }
}
