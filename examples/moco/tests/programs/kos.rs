//! Scenarios of kOS, over TCP, and over UDP for discovery.

use std::net::UdpSocket;
use std::thread::sleep;
use std::time::Duration;

use motion_move::Move;

use examples::program::Status;

use crate::cable::Cable;
use crate::process::{Program, Rig, Scenario, done_or_at_rest, file, within};
use crate::record::{Planned, Row, last};

/// Move of two and a half seconds, with a rest at its end.
const MOVE: &str = r#"{
    "move": 1, "name": "Short", "rate": 24, "duration": 2.5,
    "axes": [
        { "name": "Slide", "unit": "mm", "limits": { "velocity": 800, "acceleration": 4000 },
          "keys": [ { "time": 0.25, "position": 0 }, { "time": 1.25, "position": 250 }, { "time": 2.25, "position": 400 } ],
          "kos": { "motor": 1, "rotations_per_unit": 0.05, "range": [0, 30] } },
        { "name": "Pan", "unit": "degrees", "limits": { "velocity": 90, "acceleration": 500 },
          "keys": [ { "time": 0, "position": 45 }, { "time": 2, "position": -45, "ease": 0.3 } ],
          "kos": { "motor": 2, "rotations_per_unit": 0.1, "range": [-5, 5] } }
    ]
}"#;

/// Arguments for the greatest speed to the start of a move.
const QUICK: [&str; 2] = ["--home-speed", "1"];

/// Starts a rig and calibrates its motors.
fn calibrated(test: &str, args: &[&str]) -> Rig {
    let rig = Rig::start(test, "kos", args);
    rig.drive(&["calibrate", "1", "0", "30"]).done();
    rig.drive(&["calibrate", "2", "-5", "5"]).done();
    rig
}

/// Checks that each motor followed the curve of the move file, within a thousandth of a rotation, because a device
/// computes with 32 bits.
#[track_caller]
fn check(rows: &[Row]) {
    let planned = Move::parse("move", MOVE).unwrap();
    for axis in planned.axes() {
        let (kos, curve) = (axis.kos().unwrap(), axis.curve());
        let position = |time| kos.rotations.at(curve.position(time));
        let motor = kos.motor;
        Planned { motor, moments: (0.0, planned.duration()), rate: 1.0, position, tolerance: 1e-3 }.check(rows);
    }
}

pub(crate) const SCENARIOS: &[Scenario] = &[
    ("kos_a_calibration_and_a_live_move", a_calibration_and_a_live_move),
    ("kos_a_move_from_its_end_to_its_start", a_move_from_its_end_to_its_start),
    ("kos_a_time_lapse", a_time_lapse),
    ("kos_the_host_of_the_examples_moves_a_motor_or_stops_it", the_host_of_the_examples),
    ("kos_a_rig_that_announces_itself_is_found", a_rig_that_announces_itself_is_found),
    ("kos_ctrl_c_stops_the_motors_first", ctrl_c_stops_the_motors_first),
    ("kos_without_its_client_a_move_goes_on", without_its_client_a_move_goes_on),
    ("kos_a_rig_that_is_killed_is_reported", a_rig_that_is_killed_is_reported),
    ("kos_a_rig_that_is_killed_in_a_time_lapse_is_reported", a_rig_that_is_killed_in_a_time_lapse),
    ("kos_a_rig_that_is_killed_in_a_calibration_is_reported", a_rig_that_is_killed_in_a_calibration),
    ("kos_without_its_client_a_time_lapse_goes_on", without_its_client_a_time_lapse_goes_on),
    ("kos_without_its_client_a_calibration_stops", without_its_client_a_calibration_stops),
    ("kos_a_broken_connection_is_made_again", a_broken_connection_is_made_again),
    ("kos_with_all_faults_1", |test| with_all_faults(test, "1")),
    ("kos_with_all_faults_2", |test| with_all_faults(test, "2")),
    ("kos_with_all_faults_3", |test| with_all_faults(test, "3")),
];

fn a_calibration_and_a_live_move(test: &str) {
    let path = file(test, MOVE);
    let run = ["run", path.to_str().unwrap(), QUICK[0], QUICK[1]];
    let rig = Rig::start(test, "kos", &[]);
    // A move is refused if the range of its motor is not the planned one.
    rig.drive(&run).failed("calibrate 1 0 30");
    let said = rig.drive(&["calibrate", "1", "0", "30"]).done();
    assert!(said.contains("motor 1 is calibrated: from 0 to 30 rotations"), "{said}");
    rig.drive(&["calibrate", "2", "-5", "5"]).done();
    let said = rig.drive(&["info"]).done();
    assert!(said.contains("motor 2") && !said.lines().any(|line| line.contains("motor 1: at 0")), "{said}");
    let said = rig.drive(&run).done();
    assert!(said.contains(" %: motor 1 at ") && said.ends_with("the move is over\n"), "{said}");
    let rows = rig.end();
    check(&rows);
    assert!((last(&rows, 1) - 20.0).abs() < 1e-3 && (last(&rows, 2) + 4.5).abs() < 1e-3);
}

fn a_move_from_its_end_to_its_start(test: &str) {
    let path = file(test, MOVE);
    let rig = calibrated(test, &[]);
    rig.drive(&["run", path.to_str().unwrap(), "--reverse", QUICK[0], QUICK[1]]).done();
    let rows = rig.end();
    assert!(last(&rows, 1).abs() < 1e-3 && (last(&rows, 2) - 4.5).abs() < 1e-3, "{:?}", rows.last());
}

/// Arguments for four photos along a move.
fn lapse(path: &str) -> [&str; 10] {
    ["program", path, "--shots", "4", "--interval", "0.6", "--exposure", "0.1", QUICK[0], QUICK[1]]
}

/// Checks that each motor rests at the end of its curve.
#[track_caller]
fn is_over(rows: &[Row]) {
    assert!((last(rows, 1) - 20.0).abs() < 1e-3 && (last(rows, 2) + 4.5).abs() < 1e-3, "{:?}", rows.last());
}

fn a_time_lapse(test: &str) {
    let path = file(test, MOVE);
    let rig = calibrated(test, &[]);
    let said = rig.drive(&lapse(path.to_str().unwrap())).done();
    assert!(said.ends_with("4 photos are taken\n"), "{said}");
    assert_eq!(rig.log().matches("photo ").count(), 4);
    is_over(&rig.end());
}

fn without_its_client_a_time_lapse_goes_on(test: &str) {
    let path = file(test, MOVE);
    let rig = calibrated(test, &[]);
    let mut drive = rig.begin(&lapse(path.to_str().unwrap()));
    drive.line(" photos: ");
    drive.kill();
    assert!(rig.drive(&["info"]).done().contains("motor 1"));
    rig.rests();
    is_over(&rig.end());
}

fn a_rig_that_is_killed_in_a_time_lapse(test: &str) {
    let path = file(test, MOVE);
    let rig = calibrated(test, &[]);
    let mut drive = rig.begin(&lapse(path.to_str().unwrap()));
    drive.line(" photos: ");
    rig.kill();
    drive.end().ended(Status::MayMove, "NOT confirmed: press the emergency stop");
}

/// Arguments for a calibration that takes minutes, at five rotations per second.
const LONG_WAY: [&str; 4] = ["calibrate", "1", "0", "900"];

/// Without its client, a motor in a calibration stops, and its range is not set.
fn without_its_client_a_calibration_stops(test: &str) {
    let rig = Rig::start(test, "kos", &[]);
    let drive = rig.begin(&LONG_WAY);
    rig.moves(1);
    drive.kill();
    rig.rests();
    assert!(rig.drive(&["info"]).done().contains("motor 1: at "));
    let rows = rig.end();
    assert!(last(&rows, 1) > 0.0 && last(&rows, 1) < 450.0, "{}", last(&rows, 1));
}

fn a_rig_that_is_killed_in_a_calibration(test: &str) {
    let rig = Rig::start(test, "kos", &[]);
    let drive = rig.begin(&LONG_WAY);
    rig.moves(1);
    rig.kill();
    drive.end().ended(Status::MayMove, "NOT confirmed: press the emergency stop");
}

fn the_host_of_the_examples(test: &str) {
    let rig = Rig::start(test, "kos", &[]);
    let said = Program::example("kos_host", &[&rig.address]).end().done();
    assert!(said.contains("motor 1 rests at 2"), "{said}");
    let before = rig.rows();
    let host = Program::example("kos_host", &[&rig.address]);
    within("motion", || (rig.rows() > before + 100).then_some(()));
    host.interrupt();
    assert!(host.end().done().ends_with("the stop is confirmed\n"));
    rig.rests();
    rig.end();
}

fn a_rig_that_announces_itself_is_found(test: &str) {
    let ours = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let rig = Rig::start(test, "kos", &["--announce", &ours]);
    let port = rig.address.rsplit(':').next().unwrap();
    let found = ["kos", &format!("udp://{ours}"), "info", "--port", port];
    assert!(Program::start("drive", &found).end().done().contains("motor 3"));
    rig.end();
}

fn ctrl_c_stops_the_motors_first(test: &str) {
    let path = file(test, MOVE);
    let rig = calibrated(test, &[]);
    let drive = rig.begin(&["run", path.to_str().unwrap(), QUICK[0], QUICK[1]]);
    rig.plays();
    sleep(Duration::from_millis(500));
    drive.interrupt();
    drive.end().ended(Status::Interrupted, "moco: interrupted: the rig confirmed the stop");
    rig.rests();
    let drive = rig.begin(&["jog", "3", "2", "--for", "30"]);
    rig.moves(3);
    drive.interrupt();
    drive.end().ended(Status::Interrupted, "moco: interrupted: the rig confirmed the stop");
    rig.rests();
    let rows = rig.end();
    assert!(last(&rows, 1) > 0.0 && last(&rows, 1) < 19.0, "{}", last(&rows, 1));
    assert!(last(&rows, 3) > 0.1 && last(&rows, 3) < 20.0, "{}", last(&rows, 3));
}

fn without_its_client_a_move_goes_on(test: &str) {
    let path = file(test, MOVE);
    let rig = calibrated(test, &[]);
    let mut drive = rig.begin(&["run", path.to_str().unwrap(), QUICK[0], QUICK[1]]);
    drive.line(" %: motor 1 at ");
    drive.kill();
    assert!(rig.drive(&["info"]).done().contains("motor 1"));
    rig.rests();
    check(&rig.end());
}

/// The rig plays the move without its client, and the client connects again.
fn a_broken_connection_is_made_again(test: &str) {
    let path = file(test, MOVE);
    let rig = calibrated(test, &[]);
    let cable = Cable::new(&rig.address);
    let drive = rig.begin_over(&cable.address, &["run", path.to_str().unwrap(), QUICK[0], QUICK[1]]);
    rig.plays();
    cable.cut();
    assert!(drive.end().done().ends_with("the move is over\n"));
    check(&rig.end());
}

fn a_rig_that_is_killed_is_reported(test: &str) {
    let path = file(test, MOVE);
    let rig = calibrated(test, &[]);
    let mut drive = rig.begin(&["run", path.to_str().unwrap(), QUICK[0], QUICK[1]]);
    drive.line(" %: motor 1 at ");
    rig.kill();
    drive.end().ended(Status::MayMove, "NOT confirmed: press the emergency stop");
}

fn with_all_faults(test: &str, seed: &str) {
    let path = file(test, MOVE);
    let path = path.to_str().unwrap();
    let ours = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let rig = Rig::start(test, "kos", &["--faults", "all", "--seed", seed, "--announce", &ours]);
    let (udp, port) = (format!("udp://{ours}"), rig.address.rsplit(':').next().unwrap());
    // An announcement may be lost or damaged. Then the rig announces itself again.
    let found = rig.begin_over(&udp, &["info", "--port", port, "--wait", "40"]).end();
    assert!(found.done().contains("motor 3"));
    let calibrations = [["calibrate", "1", "0", "30"], ["calibrate", "2", "-5", "5"]];
    let calibrated = calibrations.into_iter().all(|args| done_or_at_rest(&rig, rig.drive(&args)));
    done_or_at_rest(&rig, rig.drive(&lapse(path)));
    let before = rig.rows();
    let ran = done_or_at_rest(&rig, rig.drive(&["run", path, QUICK[0], QUICK[1]]));
    let rows = rig.end();
    if calibrated && ran {
        check(&rows[before..]);
        assert!((last(&rows, 1) - 20.0).abs() < 1e-3, "{}", last(&rows, 1));
    }
}
