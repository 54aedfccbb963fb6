//! Scenarios of DMC, over TCP and a pseudo-terminal.

use std::thread::sleep;
use std::time::Duration;

use dmc_proto::message::{Ack, AckCode, Hi};
use dmc_proto::{DeviceMessage, MessageId, MessageType};
use examples::program::Status;
use motion_move::Move;

use crate::process::{Program, Rig, Scenario, cut, done_or_at_rest, file, interrupted, missed};
use crate::record::{Planned, Row, is_at, last};
use crate::terminal::Terminal;

/// Move of two seconds at 24 frames per second: frames 1 to 49.
const MOVE: &str = r#"{
    "move": 1, "name": "Short", "rate": 24, "duration": 2,
    "axes": [
        { "name": "Slide", "unit": "mm", "limits": { "velocity": 200, "acceleration": 800 },
          "keys": [ { "time": 0.2, "position": 0 }, { "time": 1, "position": 60 }, { "time": 1.8, "position": 100 } ],
          "dmc": { "motor": 2, "steps_per_unit": 80 } }
    ]
}"#;

/// Checks that the motor followed the curve of the move file. Between two frames the motor moves in a straight line and
/// the curve does not: 64,000 steps/s² over half of 1/24 s are 14 steps at most, and one step is for rounding.
#[track_caller]
fn check(rows: &[Row]) {
    let planned = Move::parse("move", MOVE).unwrap();
    let axis = &planned.axes()[0];
    let (scale, curve) = (axis.dmc().unwrap().scale, axis.curve());
    let position = |frame: f64| f64::from(scale.steps(curve.position((frame - 1.0) / 24.0)).unwrap());
    Planned { motor: 2, moments: (1.0, 49.0), rate: 24.0, position, tolerance: 15.0 }.check(rows);
    let whole = rows.iter().filter(|row| row.motor == 2);
    for (row, frame) in whole.filter_map(|row| Some((row, row.moment?))).filter(|(_, frame)| is_at(frame.fract(), 0.0))
    {
        assert!((row.position - position(frame)).abs() < 0.5, "{row:?}");
    }
}

pub(crate) const SCENARIOS: &[Scenario] = &[
    ("dmc_an_upload_and_a_run_over_a_terminal", |test| upload_and_run(test, &["--pty"])),
    ("dmc_an_upload_and_a_run_over_tcp", |test| upload_and_run(test, &["--tcp"])),
    ("dmc_an_upload_and_a_run_with_the_quirks_of_the_vendor", |test| upload_and_run(test, &["--quirks", "vendor"])),
    ("dmc_a_shoot_over_a_terminal", |test| shoot(test, &["--pty"])),
    ("dmc_a_shoot_over_tcp", |test| shoot(test, &["--tcp"])),
    ("dmc_ctrl_c_stops_the_motors_first", ctrl_c_stops_the_motors_first),
    ("dmc_without_its_host_a_run_stops", without_its_host_a_run_stops),
    ("dmc_without_its_host_a_shoot_stops", without_its_host_a_shoot_stops),
    ("dmc_a_rig_that_is_killed_in_a_shoot_is_reported", a_rig_that_is_killed_in_a_shoot),
    ("dmc_a_rig_that_is_killed_is_reported", |test| a_rig_that_is_killed_is_reported(test, "--pty")),
    ("dmc_a_rig_that_is_killed_is_reported_over_tcp", |test| a_rig_that_is_killed_is_reported(test, "--tcp")),
    ("dmc_a_broken_connection_is_made_again_for_a_stop", a_broken_connection_is_made_again_for_a_stop),
    ("dmc_an_old_acknowledgement_confirms_no_stop", |_| an_old_acknowledgement_confirms_no_stop()),
    ("dmc_an_old_greeting_is_no_rig", |_| an_old_greeting_is_no_rig()),
    ("dmc_with_all_faults_1", |test| with_all_faults(test, "--pty", "1")),
    ("dmc_with_all_faults_2", |test| with_all_faults(test, "--pty", "2")),
    ("dmc_with_all_faults_3", |test| with_all_faults(test, "--tcp", "3")),
];

fn frame(id: u32, message: impl Into<DeviceMessage<'static>>) -> Vec<u8> {
    let mut bytes = vec![0; 128];
    let len = message.into().encode_into(MessageId(id), &mut bytes).unwrap();
    bytes.truncate(len);
    bytes
}

/// Acknowledgements of earlier sessions wait on the line, and go on coming. The rig is silent.
fn an_old_acknowledgement_confirms_no_stop() {
    let mut line = Terminal::open();
    let old: Vec<u8> = (1..60).flat_map(|id| frame(id, Ack::new(MessageType(0x0033), AckCode::OK))).collect();
    line.write(&old);
    let drive = Program::start("drive", &["dmc", &line.path, "stop"]);
    for _ in 0..40 {
        sleep(Duration::from_millis(100));
        line.write(&old);
    }
    let expected = "the rig did not confirm a stop in 10 s: the stop is NOT confirmed: press the emergency stop";
    drive.end().ended(Status::MayMove, expected);
    let sent = line.sent.lock().unwrap();
    let is_padded = sent.windows(2048).any(|bytes| bytes.iter().all(|byte| *byte == 0));
    assert!(is_padded, "zero bytes complete a frame that was cut off");
}

/// A greeting of an earlier session waits on the line. The rig is off.
fn an_old_greeting_is_no_rig() {
    let mut line = Terminal::open();
    line.write(&frame(0, Hi::default()));
    let outcome = Program::start("drive", &["dmc", &line.path, "info"]).end();
    outcome.failed("no DMC rig answers");
}

fn upload_and_run(test: &str, args: &[&str]) {
    let path = file(test, MOVE);
    let path = path.to_str().unwrap();
    let rig = Rig::start(test, "dmc", args);
    let said = rig.drive(&["upload", path]).done();
    assert!(said.contains("uploaded: 49 frames of motor"), "{said}");
    let said = rig.drive(&["run", path]).done();
    assert!(said.contains("frame ") && said.ends_with("the move is done\n"), "{said}");
    let rows = rig.end();
    check(&rows);
    assert!(is_at(last(&rows, 2), 8000.0));
}

/// Arguments for five photos along a move.
fn shots(path: &str) -> [&str; 8] {
    ["program", path, "--shots", "5", "--interval", "0.3", "--exposure", "0.05"]
}

fn shoot(test: &str, args: &[&str]) {
    let path = file(test, MOVE);
    let rig = Rig::start(test, "dmc", args);
    let said = rig.drive(&shots(path.to_str().unwrap())).done();
    assert!(said.contains("shot 1 of 5") && said.contains("shot 5 of 5"), "{said}");
    assert_eq!(rig.log().matches("photo number=").count(), 5);
    let rows = rig.end();
    assert!(is_at(last(&rows, 2), 8000.0));
}

fn ctrl_c_stops_the_motors_first(test: &str) {
    let path = file(test, MOVE);
    let rig = Rig::start(test, "dmc", &[]);
    let rows =
        interrupted(rig, &["run", path.to_str().unwrap()], &["jog", "1", "10", "--for", "30"], Program::interrupt);
    assert!(last(&rows, 2) > 0.0 && last(&rows, 2) < 8000.0, "{}", last(&rows, 2));
    assert!(last(&rows, 1) > 100.0 && last(&rows, 1) < 50_000.0, "{}", last(&rows, 1));
}

/// Without its host a rig could not receive a stop, so everything stops.
fn without_its_host_a_run_stops(test: &str) {
    let path = file(test, MOVE);
    let rig = Rig::start(test, "dmc", &[]);
    let drive = rig.begin(&["run", path.to_str().unwrap()]);
    rig.moves(2);
    drive.kill();
    rig.rests();
    assert!(rig.drive(&["info"]).done().contains("motor 2 rests"));
    rig.drive(&["stop"]).done();
    let rows = rig.end();
    assert!(last(&rows, 2) > 0.0 && last(&rows, 2) < 8000.0, "{}", last(&rows, 2));
}

fn without_its_host_a_shoot_stops(test: &str) {
    let path = file(test, MOVE);
    let rig = Rig::start(test, "dmc", &[]);
    let mut drive = rig.begin(&shots(path.to_str().unwrap()));
    drive.line("shot 2 of 5");
    drive.kill();
    rig.rests();
    assert!(rig.drive(&["info"]).done().contains("motor 2 rests"));
    assert!(last(&rig.end(), 2) < 8000.0);
}

fn a_rig_that_is_killed_in_a_shoot(test: &str) {
    let path = file(test, MOVE);
    let rig = Rig::start(test, "dmc", &[]);
    let mut drive = rig.begin(&shots(path.to_str().unwrap()));
    drive.line("shot 2 of 5");
    rig.kill();
    // Between two shots no motor moves, so a stop is not always needed.
    let line = drive.end().failed_somehow();
    assert!(line.starts_with("moco: the rig is gone: "), "{line}");
    assert!(line.contains("check its cable") || line.contains("NOT confirmed"), "{line}");
}

fn a_broken_connection_is_made_again_for_a_stop(test: &str) {
    let path = file(test, MOVE);
    let rows = cut(Rig::start(test, "dmc", &["--tcp"]), &["run", path.to_str().unwrap()]);
    assert!(last(&rows, 2) < 8000.0, "{}", last(&rows, 2));
}

fn a_rig_that_is_killed_is_reported(test: &str, line: &str) {
    let path = file(test, MOVE);
    let rig = Rig::start(test, "dmc", &[line]);
    let drive = rig.begin(&["run", path.to_str().unwrap()]);
    missed(rig, drive);
}

fn with_all_faults(test: &str, line: &str, seed: &str) {
    let path = file(test, MOVE);
    let path = path.to_str().unwrap();
    let rig = Rig::start(test, "dmc", &["--faults", "all", "--seed", seed, line]);
    done_or_at_rest(&rig, rig.drive(&shots(path)));
    let before = rig.rows();
    let is_done = done_or_at_rest(&rig, rig.drive(&["run", path]));
    let rows = rig.end();
    if is_done {
        check(&rows[before..]);
        assert!(is_at(last(&rows, 2), 8000.0), "{}", last(&rows, 2));
    }
}
