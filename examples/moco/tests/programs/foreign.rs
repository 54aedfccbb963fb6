//! Tests of hosts at devices of another protocol, at half a frame, and at a line in use: one line that says what to do,
//! within a bounded time, and no motor moves.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

use examples::program::Status;

use crate::process::{Outcome, Program, Rig, Scenario};
use crate::terminal::Terminal;

/// Greatest time that a host waits at a device of another protocol.
const LONGEST: Duration = Duration::from_secs(30);

/// Scenarios.
pub(crate) const SCENARIOS: &[Scenario] = &[
    ("a_device_of_another_protocol_does_not_move", |_| a_device_of_another_protocol_does_not_move()),
    ("a_device_that_talks_on_a_serial_line_is_named", |_| a_device_that_talks_on_a_serial_line_is_named()),
    ("a_device_that_talks_over_tcp_is_named", |_| a_device_that_talks_over_tcp_is_named()),
    ("half_a_frame_is_no_device", |_| half_a_frame_is_no_device()),
    ("a_serial_line_in_use_is_refused", |_| a_serial_line_in_use_is_refused()),
];

/// Drives a device as if it spoke `protocol`.
fn drive(protocol: &str, address: &str, args: &[&str]) -> Outcome {
    let start = Instant::now();
    let outcome = Program::start("drive", &[&[protocol, address], args].concat()).end();
    assert!(start.elapsed() < LONGEST, "{protocol} at {address}: {:?}", start.elapsed());
    outcome
}

fn a_device_of_another_protocol_does_not_move() {
    // Each host, the device that it meets, the carrier, and the line that it prints.
    let pairs = [
        ("kos", "dmc", "--tcp", "what answers there speaks DMC, not kOS: use `moco drive dmc`"),
        ("kos", "hoot", "--tcp", "the device did not answer what it is: is this the address of a kOS rig?"),
        ("dmc", "kos", "--tcp", "the other end closed it before it answered: check its protocol"),
        ("dmc", "hoot", "--pty", "no DMC rig answers"),
        ("hoot", "kos", "--tcp", "the other end closed it before it answered: check its protocol"),
        ("hoot", "dmc", "--pty", "what answers there speaks DMC, not hoot: use `moco drive dmc`"),
    ];
    thread::scope(|scope| {
        for (host, device, carrier, line) in pairs {
            scope.spawn(move || {
                let rig = Rig::start(&format!("{host}_at_{device}"), device, &[carrier]);
                drive(host, &rig.address, &["info"]).failed(line);
                drive(host, &rig.address, &["jog", "1", "1"]).failed(line);
                drive(host, &rig.address, &["stop"]).ended(Status::MayMove, "press the emergency stop");
                let rows = rig.end();
                assert!(rows.iter().all(|row| row.position == 0.0), "{host} at {device}: {rows:?}");
            });
        }
    });
}

/// Bytes of an answer that a device of a protocol sends.
fn bytes_of(protocol: &str) -> &'static [u8] {
    match protocol {
        "dmc" => b"\x44\x46\x00\x00\x00\x00\x34\x00\x08\x00\xd0\x07\x00\x00\xff\xff\xff\xff\x6f\xf1",
        "hoot" => b"\0\0\0\0\0\xFF\0\0\x01\x04\0\0\x03\xE8",
        _ => b"\x04\0\x0C\0\x81\x02\x07\x03\x41\x3F\xB8\0",
    }
}

/// A device on a serial line that talks without being asked, as a DMC rig does that moves, or as the nodes of another
/// master do.
fn a_device_that_talks_on_a_serial_line_is_named() {
    thread::scope(|scope| {
        for (host, device, said) in [("dmc", "hoot", "speaks hoot, not DMC"), ("hoot", "dmc", "speaks DMC, not hoot")] {
            scope.spawn(move || {
                let mut line = Terminal::open();
                let program = Program::start("drive", &[host, &line.path, "info"]);
                for _ in 0..10 {
                    thread::sleep(Duration::from_millis(200));
                    line.write(bytes_of(device));
                }
                program.end().failed(&format!("{said}: use `moco drive {device}`"));
            });
        }
    });
}

/// Listener that answers each connection with the same bytes, and then says nothing more.
fn answering(bytes: &'static [u8]) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    thread::spawn(move || {
        let answer = |mut line: TcpStream| {
            // The client may be gone.
            let _ = line.write_all(bytes);
            let _ = line.read_to_end(&mut Vec::new());
        };
        listener.incoming().flatten().for_each(|line| drop(thread::spawn(move || answer(line))));
    });
    address
}

fn a_device_that_talks_over_tcp_is_named() {
    thread::scope(|scope| {
        for (host, device) in [("kos", "dmc"), ("kos", "hoot"), ("dmc", "kos"), ("hoot", "kos")] {
            scope.spawn(move || {
                let outcome = drive(host, &answering(bytes_of(device)), &["info"]);
                outcome.failed(&format!("use `moco drive {device}`"));
            });
        }
    });
}

fn half_a_frame_is_no_device() {
    thread::scope(|scope| {
        for (host, line) in [
            ("kos", "the device did not answer what it is"),
            ("dmc", "no DMC rig answers"),
            ("hoot", "no answer: is the node on"),
        ] {
            scope.spawn(move || {
                let bytes = bytes_of(host);
                drive(host, &answering(&bytes[..bytes.len() - 2]), &["info"]).failed(line);
            });
        }
    });
}

fn a_serial_line_in_use_is_refused() {
    let rig = Rig::start("a_serial_line_in_use_is_refused", "hoot", &[]);
    let jog = rig.begin(&["jog", "1", "100", "--for", "20"]);
    rig.moves(1);
    rig.drive(&["info"]).failed("the port not in use?");
    jog.interrupt();
    jog.end().ended(Status::Interrupted, "the rig confirmed the stop");
    rig.end();
}
