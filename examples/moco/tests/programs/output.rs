//! Tests of the output of `moco drive` and `moco simulate` for programs, and of the progress bar.

use serde_json::{Value, json};

use crate::process::{Program, Rig, file, within};
use crate::terminal::Terminal;

/// Move of two seconds, for motors of DMC and hoot.
const MOVE: &str = r#"{
    "move": 1, "name": "Short", "rate": 24, "duration": 2.5,
    "axes": [
        { "name": "Pan", "unit": "degrees", "limits": { "velocity": 80, "acceleration": 200 },
          "keys": [ { "time": 0.25, "position": 0 }, { "time": 2.25, "position": 45 } ],
          "dmc": { "motor": 1, "steps_per_unit": 80 },
          "hoot": { "motor": 1, "steps_per_unit": 80 } }
    ]
}"#;

/// Lines of an output, each of which is an object.
fn objects(out: &str) -> Vec<Value> {
    out.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|error| panic!("{line}: {error}"))).collect()
}

#[test]
fn each_line_for_programs_is_an_object() {
    for protocol in ["kos", "dmc", "hoot"] {
        let test = format!("each_line_for_programs_is_an_object_{protocol}");
        let rig = Rig::start(&test, protocol, &[]);
        let events = objects(&rig.drive(&["info", "--json"]).done());
        assert_eq!(events.last(), Some(&json!({ "event": "done" })), "{protocol}");
        let motors: Vec<_> = events.iter().filter(|event| event["event"] == "position").collect();
        assert!(motors.len() >= 3, "{events:?}");
        for (number, motor) in (1..).zip(motors) {
            assert_eq!((&motor["motor"], &motor["position"]), (&json!(number), &json!(0.0)), "{motor}");
            assert!(motor["text"].as_str().unwrap().starts_with(&format!("motor {number}")), "{motor}");
        }
        let failed = rig.drive(&["move", "99", "5", "--json"]);
        assert_eq!(failed.status.code(), Some(1), "{failed:?}");
        assert!(objects(&failed.out).iter().all(|event| event["event"] != "done"), "{failed:?}");
        let failures = objects(&failed.err);
        assert!(failures.len() == 1 && failures[0]["status"] == 1, "{failures:?}");
        assert!(failures[0]["error"].as_str().unwrap().contains("99"), "{failures:?}");
        rig.end();
    }
}

#[test]
fn the_progress_of_a_move_grows_for_programs() {
    for protocol in ["dmc", "hoot"] {
        let test = format!("the_progress_of_a_move_grows_for_programs_{protocol}");
        let path = file(&test, MOVE);
        let rig = Rig::start(&test, protocol, &[]);
        let said = rig.drive(&["run", path.to_str().unwrap(), "--json"]).done();
        let parts = parts(&said, " of ");
        assert!(parts.len() >= 2 && parts.is_sorted(), "{said}");
        assert!(parts.iter().all(|part| (0.0..=1.0).contains(part)), "{parts:?}");
        rig.end();
    }
}

/// Parts of a command that its progress told, in lines with this word.
fn parts(out: &str, word: &str) -> Vec<f64> {
    let events = objects(out);
    let told = events.iter().filter(|event| event["event"] == "progress");
    told.filter(|event| event["text"].as_str().unwrap().contains(word))
        .filter_map(|event| event["part"].as_f64())
        .collect()
}

#[test]
fn the_progress_of_an_upload_grows() {
    let test = "the_progress_of_an_upload_grows";
    let long = MOVE.replace(r#""duration": 2.5"#, r#""duration": 200"#).replace("2.25", "199");
    let path = file(test, &long);
    let rig = Rig::start(test, "dmc", &["--faults", "delay=200"]);
    let said = rig.drive(&["upload", path.to_str().unwrap(), "--json"]).done();
    let parts = parts(&said, "uploaded");
    assert!(parts.len() >= 2 && parts.is_sorted(), "{said}");
    assert!(parts[0] < 0.9 && parts.last().is_some_and(|last| *last > 0.1), "{said}");
    rig.end();
}

#[test]
fn a_rig_tells_programs_its_address_and_its_log() {
    let mut rig = Program::start("simulate", &["dmc", "--tcp", "--port", "0", "--json"]);
    let ready = objects(&rig.line("address")).remove(0);
    assert_eq!(ready["protocol"], "dmc");
    let address = ready["address"].as_str().unwrap();
    Program::start("drive", &["dmc", address, "info"]).end().done();
    within("the end of the client", || rig.said().contains("the client closed the line").then_some(()));
    rig.interrupt();
    let outcome = rig.end();
    assert!(outcome.status.success(), "{outcome:?}");
    let log = objects(&outcome.err);
    let is_connected = |line: &Value| line["message"].as_str().unwrap().ends_with("is connected");
    assert!(log.iter().any(is_connected) && log.iter().all(|line| line["level"] == "INFO"), "{log:?}");
    let seconds: Vec<f64> = log.iter().map(|line| line["timestamp"].as_str().unwrap().parse().unwrap()).collect();
    assert!(seconds.is_sorted(), "{seconds:?}");
}

#[test]
fn programs_and_shells_get_the_names_of_devices_and_quirks() {
    for (protocol, device) in [("kos", "printed"), ("dmc", "dmc-lite"), ("hoot", "v0.70")] {
        let names = objects(&Program::start("simulate", &[protocol, "--list", "--json"]).end().done());
        let usual: Vec<_> = names.iter().filter(|name| name["default"] == true).collect();
        assert!(usual.len() == 1 && usual[0]["name"] == device && usual[0]["kind"] == "device", "{usual:?}");
        assert!(names.iter().any(|name| name["kind"] == "quirk"), "{names:?}");
        let script = Program::start("completions", &["bash"]).end().done();
        for name in
            names.iter().map(|name| name["name"].as_str().unwrap()).filter(|name| !name.contains(char::is_uppercase))
        {
            assert!(script.contains(name), "{protocol}: {name}");
        }
    }
}

#[test]
fn a_terminal_gets_a_progress_bar() {
    let test = "a_terminal_gets_a_progress_bar";
    let path = file(test, MOVE);
    let rig = Rig::start(test, "dmc", &[]);
    let terminal = Terminal::open();
    let drive = Program::start_at(&terminal.path, "drive", &["dmc", &rig.address, "run", path.to_str().unwrap()]);
    let said = drive.end().done();
    // Standard output is no terminal here, so it has all lines.
    assert!(said.contains("frame ") && said.ends_with("the move is done\n"), "{said}");
    let drawn = String::from_utf8(terminal.sent.lock().unwrap().clone()).unwrap();
    assert!(drawn.contains('█') && drawn.contains('░') && drawn.contains("frame "), "{drawn:?}");
    rig.end();
}
