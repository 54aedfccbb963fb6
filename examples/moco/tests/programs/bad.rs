//! Tests of commands that cannot be done: one line that says what to do, and the exit status.

use std::net::TcpListener;
use std::thread::sleep;
use std::time::Duration;

use examples::program::Status;

use crate::process::{Program, Rig, file};

#[test]
fn a_broken_move_file_is_refused() {
    let rig = Rig::start("a_broken_move_file_is_refused", "dmc", &["--tcp"]);
    let path = file("a_broken_move_file_is_refused", "{\n  \"move\": 1,\n  \"name\": 7\n}");
    let path = path.to_str().unwrap();
    let line = rig.drive(&["run", path]).failed("line 3, column 11");
    assert!(line.starts_with(&format!("moco: {path}")), "{line}");
    rig.drive(&["run", "no/such/file"]).failed("moco: no/such/file: ");
    rig.end();
}

#[test]
fn a_port_that_is_in_use_is_refused() {
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    for protocol in ["kos", "dmc", "hoot"] {
        let outcome = Program::start("simulate", &[protocol, "--tcp", "--port", &port]).end();
        outcome.failed(&format!("moco: 127.0.0.1:{port} is in use: choose another --port"));
    }
}

#[test]
fn an_address_or_a_record_that_cannot_be_used_is_refused() {
    for (args, part) in [
        (["kos", "--listen", "192.0.2.1"], "192.0.2.1:5520 is not an address of this computer"),
        (["dmc", "--record", "/no/such/folder"], "/no/such/folder: "),
    ] {
        Program::start("simulate", &args).end().failed(part);
    }
}

#[test]
fn a_rig_that_does_not_exist_is_reported() {
    let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    for (args, part) in [
        (["kos", &free, "info"], "nothing listens there"),
        (["dmc", &free, "info"], "nothing listens there"),
        (["hoot", &free, "info"], "nothing listens there"),
        (["dmc", "/dev/no-such-line", "info"], "is the rig plugged in"),
        (["hoot", "/dev/no-such-line", "info"], "is the rig plugged in"),
    ] {
        let line = Program::start("drive", &args).end().failed(part);
        assert!(line.starts_with(&format!("moco: {}: ", args[1])), "{line}");
    }
    let args = ["kos", "udp://127.0.0.1:0", "info", "--wait", "1"];
    Program::start("drive", &args).end().failed("no kOS rig announced itself in 1 s");
}

#[test]
fn an_interrupt_before_there_is_a_rig_needs_no_stop() {
    let drive = Program::start("drive", &["kos", "udp://127.0.0.1:0", "info", "--wait", "60"]);
    sleep(Duration::from_secs(1));
    drive.interrupt();
    let line = drive.end().ended(Status::Interrupted, "");
    assert_eq!(line, "moco: interrupted\n");
}

#[test]
fn an_unknown_argument_is_refused() {
    for (program, args, part) in [
        ("simulate", vec!["dfmoco"], "possible values: kos, dmc, hoot"),
        ("simulate", vec!["kos", "--listen", "here"], "invalid value 'here' for '--listen"),
        ("simulate", vec!["kos", "--device", "loud"], "kOS has no device \"loud\": it has mild"),
        ("simulate", vec!["kos", "--quirks", "loud"], "kOS has no quirk \"loud\": it has older-dialect"),
        ("simulate", vec!["dmc", "--quirks", "vendor,loud"], "DMC has no quirk \"loud\": it has vendor,"),
        ("simulate", vec!["hoot", "--quirks", "loud"], "hoot has no quirk \"loud\": it has refuses-stop,"),
        ("simulate", vec!["kos", "--faults", "loss"], "TCP has no fault \"loss\": it has cutting,"),
        ("simulate", vec!["dmc", "--faults", "loss=2"], "loss=\"2\": it needs a number"),
        ("simulate", vec!["dmc", "--motors", "33"], "DMC has 1 to 32 motors, not 33"),
        ("simulate", vec!["dmc", "--password", "x"], "DMC has no passwords: leave out --password"),
        ("simulate", vec!["hoot", "--announce", "127.0.0.1:9"], "hoot has no datagrams: leave out --announce"),
        ("simulate", vec!["kos", "--pty"], "kOS has no serial line: leave out --pty"),
        ("drive", vec!["kos", "127.0.0.1"], "requires a subcommand"),
        ("drive", vec!["kos", "127.0.0.1", "dance"], "'dance'"),
        ("drive", vec!["dmc", "rig", "info"], "\"rig\": give HOST:PORT, or a serial device"),
        ("drive", vec!["hoot", "127.0.0.1:1", "info", "--node", "1"], "1 is not in 2..=255"),
    ] {
        Program::start(program, &args).end().ended(Status::Usage, part);
    }
}

#[test]
fn a_wrong_password_is_refused() {
    let rig = Rig::start("a_wrong_password_is_refused", "kos", &["--password", "gaffer"]);
    rig.drive(&["info", "--password", "grip"])
        .failed("moco: wrong password: give the password of the rig with --password");
    assert!(rig.drive(&["info", "--password", "gaffer"]).done().contains("motor 1"));
    rig.end();
}
