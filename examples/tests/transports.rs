//! Tests of captures of kOS in datagrams and in USB reports, and of hoot, as `inspect --json` shows them.

use examples::cli::{Protocol, Transport};
use examples::record::{Json, Record};
use examples::tap::tap;
use examples::text::{Format, Source};
use serde_json::{Value, json};

/// Lines of JSON for a capture of kOS.
fn inspect(transport: Transport, capture: &str) -> Vec<Value> {
    inspect_as(Protocol::Kos, transport, capture)
}

/// Lines of JSON for a capture.
fn inspect_as(protocol: Protocol, transport: Transport, capture: &str) -> Vec<Value> {
    let mut lines = Vec::new();
    let mut see = |record: &Record<'_>| {
        let line = serde_json::to_string(&Json { record, secrets: false }).expect("a record is JSON");
        lines.push(serde_json::from_str(&line).expect("the JSON can be read back"));
        Ok(())
    };
    let mut tap = tap(protocol, transport).expect("the protocol uses the transport");
    let mut source = Source::new(capture.as_bytes(), Format::Auto, None).expect("the text has marks");
    while let Some(piece) = source.next_piece().expect("the text is valid") {
        tap.push(piece, &mut see).expect("nothing fails");
    }
    tap.end(&mut see).expect("nothing fails");
    lines
}

/// Sender, offset, length and name of each record. A record that is not a message has the reason as its name.
fn heads(lines: &[Value]) -> Vec<Value> {
    let what = |line: &Value| {
        let keys = ["message", "corrupt", "incomplete", "noise"];
        keys.iter().find_map(|key| line.get(key)).cloned().unwrap_or_default()
    };
    lines.iter().map(|line| json!([line["from"], line["offset"], line["len"], what(line)])).collect()
}

/// One line of a capture: a report of 64 bytes, with its id.
fn report(mark: char, message: &[u8]) -> String {
    let mut report = vec![1];
    report.extend(message);
    report.resize(64, 0);
    let hex: Vec<_> = report.iter().map(|byte| format!("{byte:02x}")).collect();
    format!("{mark} {}\n", hex.join(" "))
}

/// `PlaybackStatus` of 10 motors: 67 bytes, of which 63 are in the first report and 4 in the second.
fn status() -> Vec<u8> {
    let mut status = vec![4, 0, 67, 0, 0x81, 2, 2, 2, 0x3f, 0, 0, 0, 0, 0, 0, 0, 10];
    status.extend((1..=10).flat_map(|address| [address, 0x41, 0x20, 0, 0]));
    status
}

const KEEP_ALIVE: &[u8] = &[4, 0, 6, 0, 0, 0];
const STOP: &[u8] = &[4, 0, 7, 0, 0x80, 0, 6];

#[test]
fn discovery_shows_one_line_for_each_datagram() {
    let capture = "\
// Questions of the host. The first one has bytes after its message, the last one has no parameter.
> 04 00 06 00 02 01 04 00
> 04 00 07 00 02 01 01
> 04 00 06 00 02 01
< 04 00 1b 00 02 02 01 00 11 22 33 44 55 c0 a8 32 01 ff ff ff 00 c0 a8 32 01 0a 00
// A datagram that was cut off. The next datagram is not affected.
< 04 00 1b 00 02 02 01 00 11
< 04 00 1b 00 02 02 00 00 11 22 33 44 56 0a 00 00 07 ff 00 00 00 00 00 00 00 0b 00
";
    let lines = inspect(Transport::Datagram, capture);
    let wanted = [
        json!(["host", 0, 8, "frame: 2 bytes too many"]),
        json!(["host", 8, 7, "NetworkInfo"]),
        json!(["host", 15, 6, "NetworkInfo"]),
        json!(["device", 0, 27, "NetworkInfo"]),
        json!(["device", 27, 9, "frame: need 27 bytes, have 9"]),
        json!(["device", 36, 27, "NetworkInfo"]),
    ];
    assert_eq!(heads(&lines), wanted);
    assert_eq!(lines[1]["fields"], json!({ "limited_response": 1 }));
    assert_eq!(lines[2]["fields"], json!({}));
    assert_eq!(lines[5]["fields"]["device_type"], 11);
}

#[test]
fn a_message_in_two_reports_is_shown_only_with_the_assumption() {
    let status = status();
    let capture = [
        report('>', KEEP_ALIVE),
        report('<', &status[..63]),
        report('>', STOP),
        report('<', &status[63..]),
        report('<', b"\x04\0\x0c\0\x81\x02\x07\x03\x41\x3f\xb8\0"),
    ]
    .concat();

    let lines = inspect(Transport::UsbFragments, &capture);
    let wanted = [
        json!(["host", 0, 6, "KeepAlive"]),
        json!(["host", 64, 7, "StopPlayback"]),
        json!(["device", 0, 67, "PlaybackStatus"]),
        json!(["device", 128, 12, "MotorPosition"]),
    ];
    assert_eq!(heads(&lines), wanted);
    assert_eq!(lines[2]["fields"]["motor_count"], 10);
    assert_eq!(lines[2]["fields"]["motors"][9], json!({ "motor_address": 10, "position": 10.0 }));
    assert_eq!(lines[2]["canonical"], true);

    let lines = inspect(Transport::Usb, &capture);
    let wanted = [
        json!(["host", 0, 6, "KeepAlive"]),
        json!(["device", 0, 64, "frame: need 67 bytes, have 63"]),
        json!(["host", 64, 7, "StopPlayback"]),
        json!(["device", 64, 64, "frame: protocol version is 65, should be 4"]),
        json!(["device", 128, 12, "MotorPosition"]),
    ];
    assert_eq!(heads(&lines), wanted);
}

/// Safety decision 4.
#[test]
fn a_lost_report_does_not_hide_a_stop() {
    let long = [&[4, 0, 150, 0x12, 0x34, 0][..], &[0xff; 144]].concat();
    let capture = [
        report('>', &long[..63]),
        report('>', &long[63..126]),
        report('>', STOP),
        report('>', &long[..63]),
        "> 07 00\n".to_owned(),
        report('>', &long[63..126]),
    ]
    .concat();
    let lines = inspect(Transport::UsbFragments, &capture);
    let wanted = [
        json!(["host", 0, 128, "USB message: have 126 of 150 bytes, the next report was another message"]),
        json!(["host", 128, 7, "StopPlayback"]),
        json!(["host", 256, 2, "USB report: id is 7, should be 1"]),
        json!(["host", 192, 128, "the input ends inside a message"]),
    ];
    assert_eq!(heads(&lines), wanted);
}

#[test]
fn a_short_report_ends_its_message() {
    let status = status();
    let capture = [report('<', &status[..63]), "< 01 00\n".to_owned(), report('<', KEEP_ALIVE)].concat();
    let lines = inspect(Transport::UsbFragments, &capture);
    let wanted = [json!(["device", 0, 66, "frame: need 67 bytes, have 64"]), json!(["device", 66, 6, "Other"])];
    assert_eq!(heads(&lines), wanted);
}

#[test]
fn a_request_after_a_break_that_was_sent_twice_is_shown() {
    let capture = "> 00 00 00 00 00 ff 00 00 00 00 00 ff 03 00 04 00\n< 00 00 00 00 00 ff 00 00 00 00\n";
    let heads = heads(&inspect_as(Protocol::Hoot, Transport::Stream, capture));
    let expected = [
        json!(["host", 0, 6, "no frame begins here"]),
        json!(["host", 6, 10, "Stop"]),
        json!(["device", 0, 10, "Reply"]),
    ];
    assert_eq!(heads, expected);
}
