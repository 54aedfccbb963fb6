//! Tests of `inspect --json` with each conformance vector: the output has at least the fields that the vector lists.

use std::fs;
use std::path::Path;

use examples::cli::{Protocol, Transport};
use examples::record::{Json, Record};
use examples::tap::tap;
use examples::text::{Piece, Side};
use serde_json::Value;

fn vectors(protocol: &str) -> Vec<Value> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../vectors/{protocol}.json"));
    let text = fs::read_to_string(path).expect("the vectors are part of the repository");
    serde_json::from_str(&text).expect("the vectors are JSON")
}

fn text<'a>(vector: &'a Value, key: &str) -> &'a str {
    vector[key].as_str().unwrap_or_default()
}

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).expect("hex")).collect()
}

/// Lines of JSON for the bytes that both sides sent, in order.
fn inspect(protocol: Protocol, transport: Transport, said: &[(Side, Vec<u8>)]) -> Vec<Value> {
    let mut lines = Vec::new();
    let mut see = |record: &Record<'_>| {
        let line = serde_json::to_string(&Json { record, secrets: true }).expect("a record is JSON");
        lines.push(serde_json::from_str(&line).expect("the JSON can be read back"));
        Ok(())
    };
    let mut tap = tap(protocol, transport).expect("the protocol uses the transport");
    for (side, bytes) in said {
        if !bytes.is_empty() {
            tap.push(Piece { side: *side, first: true, bytes }, &mut see).expect("nothing fails");
        }
    }
    tap.end(&mut see).expect("nothing fails");
    let covered: u64 = lines.iter().map(|line: &Value| line["len"].as_u64().unwrap()).sum();
    let sent: usize = said.iter().map(|(_, bytes)| bytes.len()).sum();
    if transport == Transport::Stream {
        assert_eq!(covered, sent as u64, "every byte is shown once");
    }
    lines
}

/// First difference: a value that `wanted` lists, and that is missing or different in `found`.
fn missing(wanted: &Value, found: &Value, except: &[&str]) -> Option<String> {
    match (wanted, found) {
        (Value::Object(wanted), Value::Object(found)) => wanted
            .iter()
            .filter(|(key, _)| !except.contains(&key.as_str()))
            .find_map(|(key, value)| match found.get(key) {
                None => Some(format!("{key} is missing")),
                Some(other) => missing(value, other, except).map(|what| format!("{key}: {what}")),
            }),
        (Value::Array(wanted), Value::Array(found)) if wanted.len() == found.len() => wanted
            .iter()
            .zip(found)
            .enumerate()
            .find_map(|(at, (wanted, found))| missing(wanted, found, except).map(|what| format!("[{at}]: {what}"))),
        (Value::Number(wanted), Value::Number(found)) if wanted.as_f64() == found.as_f64() => None,
        (wanted, found) if wanted == found => None,
        _ => Some(format!("{found} instead of {wanted}")),
    }
}

#[test]
fn each_dmc_vector_is_shown_with_its_fields() {
    let (mut shown, mut typed) = (0, 0);
    for vector in vectors("dmc") {
        let name = text(&vector, "name");
        let side = if text(&vector, "direction") == "request" { Side::Host } else { Side::Device };
        let lines = inspect(Protocol::Dmc, Transport::Stream, &[(side, bytes(text(&vector, "hex")))]);
        if vector.get("invalid").is_some() {
            assert!(lines.iter().all(|line| line.get("fields").is_none()), "{name}: {lines:?}");
            assert!(lines[0]["corrupt"].is_string(), "{name}: {lines:?}");
            continue;
        }
        let [line] = &lines[..] else { panic!("{name}: {lines:?}") };
        for key in ["type", "id"] {
            assert_eq!(missing(&vector[key], &line[key], &[]), None, "{name}: {line}");
        }
        assert_eq!(line["canonical"], vector.get("canonical").is_none(), "{name}: {line}");
        shown += 1;
        if line["message"] == "Other" {
            continue;
        }
        typed += 1;
        if line.get("error").is_none() {
            assert_eq!(missing(&vector["fields"], &line["fields"], &[]), None, "{name}: {line}");
        } else {
            assert_eq!(vector["fields"], serde_json::json!({}), "{name}: {line}");
        }
    }
    assert!(shown > 150 && typed > 60, "{shown} shown, {typed} typed");
}

#[test]
fn each_kos_vector_is_shown_with_its_fields() {
    let mut compared = 0;
    for vector in vectors("kos") {
        let (name, kind) = (text(&vector, "name"), text(&vector, "kind"));
        let side = if text(&vector, "direction") == "host" { Side::Host } else { Side::Device };
        let transport = if matches!(kind, "usb" | "usb-assumed") { Transport::Usb } else { Transport::Stream };
        let mut lines = inspect(Protocol::Kos, transport, &[(side, bytes(text(&vector, "hex")))]);
        match kind {
            "reject" | "reject-or-desync" => {
                let bad = |line: &Value| ["error", "fatal", "corrupt"].iter().any(|key| line.get(key).is_some());
                assert!(lines.iter().any(bad), "{name}: {lines:?}");
                continue;
            }
            // Only a USB sender refuses such a message.
            "usb-too-long" => {
                assert!(lines.iter().all(|line| line["canonical"] == true), "{name}: {lines:?}");
                continue;
            }
            "incomplete" => {
                assert!(lines.iter().any(|line| line.get("incomplete").is_some()), "{name}: {lines:?}");
                continue;
            }
            // The assumption is made only on request.
            "usb-assumed" => {
                assert!(lines.iter().any(|line| line.get("incomplete").is_some()), "{name}: {lines:?}");
                lines = inspect(Protocol::Kos, Transport::UsbFragments, &[(side, bytes(text(&vector, "hex")))]);
            }
            _ => {}
        }
        let wanted = vector["messages"].as_array().expect("the vector lists its messages");
        assert_eq!(lines.len(), wanted.len(), "{name}: {lines:?}");
        for (wanted, line) in wanted.iter().zip(&lines) {
            for key in ["message", "message_id", "message_type", "fields"] {
                assert_eq!(missing(&wanted[key], &line[key], &[]), None, "{name}: {key} of {line}");
            }
            compared += 1;
        }
        if kind.starts_with("ok") {
            assert!(lines.iter().all(|line| line["canonical"] == true), "{name}: {lines:?}");
        }
    }
    assert!(compared > 150, "{compared} messages compared");
}

#[test]
fn each_hoot_vector_is_shown_with_its_fields() {
    let (mut requests, mut answered) = (0, 0);
    for vector in vectors("hoot") {
        let name = text(&vector, "name");
        let packet = bytes(text(&vector, "hex"));
        let except = ["value_type_name", "broadcast", "rule", "encoded_from", "decoded", "malformed", "frames"];
        if text(&vector, "direction") == "request" {
            let lines = inspect(Protocol::Hoot, Transport::Stream, &[(Side::Host, packet)]);
            if vector["fields"].get("malformed").is_some() || vector["fields"].get("frames").is_some() {
                continue;
            }
            let [line] = &lines[..] else { panic!("{name}: {lines:?}") };
            assert_eq!(missing(&vector["fields"], &line["fields"], &except), None, "{name}: {line}");
            assert_eq!(line["canonical"], true, "{name}: {line}");
            requests += 1;
        } else {
            let asked = bytes(text(&vector, "in_reply_to"));
            let lines = inspect(Protocol::Hoot, Transport::Stream, &[(Side::Host, asked), (Side::Device, packet)]);
            let line =
                lines.iter().rfind(|line| line["from"] == "device").unwrap_or_else(|| panic!("{name}: {lines:?}"));
            // Hundredths are shown as such only if the query is known.
            let hundredths = ["raw_i32", "value_fixed_div100"];
            let known = line["fields"].get("raw_i32").is_some();
            let except: Vec<_> = except.iter().chain(hundredths.iter().filter(|_| !known)).copied().collect();
            assert_eq!(missing(&vector["fields"], &line["fields"], &except), None, "{name}: {line}");
            answered += 1;
        }
    }
    assert!(requests > 150 && answered > 190, "{requests} requests, {answered} replies");
}
