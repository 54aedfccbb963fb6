//! Conformance vectors: every kind, every message, every field.

mod recorded;

use std::collections::BTreeMap;

use kos_proto::lint::Context;
use kos_proto::message::{Numbered, PlaybackState};
use kos_proto::{DecodeError, DeviceMessage, Frame, FrameError, Frames, HostMessage, Item};
use motion_core::lint::{Lints, Severity};
use motion_core::serialize::Map;
use serde_json::{Value, json};

/// Result of reading a frame.
struct Seen {
    summary: Value,
    encoded: Vec<u8>,
    lints: Lints,
}

macro_rules! see {
    ($side:ident, $frame:expr) => {{
        let message = $side::decode(&$frame)?;
        let mut encoded = vec![0; message.encoded_len()];
        assert_eq!(message.encode_into(&mut encoded), Ok(encoded.len()));
        let fields = serde_json::to_value(Map { fields: &Numbered(&message), secrets: true }).unwrap();
        let (name, id, kind) = (message.specification_name(), message.id().0, message.kind().0);
        let summary = json!({"message": name, "message_id": id, "message_type": kind, "fields": fields});
        Ok(Seen { summary, encoded, lints: message.lint(&Context::default()) })
    }};
}

fn see(vector: &Value, frame: Frame<'_>) -> Result<Seen, DecodeError> {
    match vector["direction"].as_str().unwrap() {
        "host" => see!(HostMessage, frame),
        "device" => see!(DeviceMessage, frame),
        other => panic!("{other}"),
    }
}

/// Fields that the vectors leave out if they are 0.
const UNSUPPORTED: [&str; 9] = [
    "camera_roll_enabled",
    "camera_roll_pre_delay",
    "camera_roll_post_delay",
    "flash_mark_enabled",
    "flash_mark_type",
    "flash_mark_post_delay",
    "use_external_trigger",
    "using_lanc",
    "not_used",
];

/// Whether `found` equals `wanted`, except for an unknown tail and unused fields.
fn covers(found: &Value, wanted: &Value) -> bool {
    match (found, wanted) {
        (Value::Object(found), Value::Object(wanted)) => {
            let extra = found.iter().filter(|(name, _)| !wanted.contains_key(*name));
            let unused = |(name, value): (&String, &Value)| {
                name == "tail" || UNSUPPORTED.contains(&&name[..]) && value.as_f64() == Some(0.0)
            };
            wanted.iter().all(|(name, wanted)| found.get(name).is_some_and(|found| covers(found, wanted)))
                && extra.into_iter().all(unused)
        }
        (Value::Array(found), Value::Array(wanted)) => {
            found.len() == wanted.len() && found.iter().zip(wanted).all(|(found, wanted)| covers(found, wanted))
        }
        _ => found == wanted,
    }
}

/// Reads a vector as a stream.
fn decoded(vector: &Value, bytes: &[u8]) {
    let (name, kind) = (&vector["name"], vector["kind"].as_str().unwrap());
    let mut frames: Box<Frames> = Box::default();
    assert_eq!(frames.push(bytes), bytes.len());
    let (mut rest, mut found) = (bytes, Vec::new());
    while let Some(item) = frames.next() {
        let Item::Frame(frame) = item else { panic!("{name}: {item:?}") };
        let seen = see(vector, frame).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(seen.encoded, rest[..seen.encoded.len()], "{name}: the same bytes again");
        rest = &rest[seen.encoded.len()..];
        found.push(seen);
    }
    assert!(rest.is_empty() && frames.held() == 0, "{name}: all bytes are read");
    let wanted = vector["messages"].as_array().unwrap();
    assert_eq!(found.len(), wanted.len(), "{name}");
    for (seen, wanted) in found.iter().zip(wanted) {
        assert!(covers(&seen.summary, wanted), "{name}:\n{}\n{wanted}", seen.summary);
        let known = seen.summary["message"] != "Other";
        let error = seen.lints.first_error();
        match kind {
            "ok" | "ok-stream" => {
                assert_eq!(error, None, "{name}");
                assert!(!seen.summary["fields"].as_object().unwrap().contains_key("tail"), "{name}");
            }
            "accept-invalid" => assert!(error.is_some(), "{name}: lint finds an error in the move"),
            "accept-unknown" => assert!(!known && error.is_none(), "{name}"),
            "accept" | "accept-legacy" => assert!(known, "{name}"),
            other => panic!("{name}: {other}"),
        }
    }
}

/// Checks that the stream ends, or that the message is an error.
fn refused(vector: &Value, bytes: &[u8]) {
    let name = &vector["name"];
    let mut frames: Box<Frames> = Box::default();
    assert_eq!(frames.push(bytes), bytes.len());
    match frames.next() {
        Some(Item::Frame(frame)) => assert!(see(vector, frame).is_err(), "{name}"),
        Some(Item::Fatal(_)) => {
            let error = Frame::decode(bytes).unwrap_err();
            assert!(matches!(error, FrameError::BadVersion { .. } | FrameError::BadLength { .. }), "{name}: {error}");
        }
        item => panic!("{name}: {item:?}"),
    }
}

/// Checks that the stream waits, and that a datagram is too short.
fn incomplete(vector: &Value, bytes: &[u8]) {
    let mut frames: Box<Frames> = Box::default();
    assert_eq!(frames.push(bytes), bytes.len());
    assert!(frames.next().is_none(), "{}", vector["name"]);
    assert_eq!(frames.held(), bytes.len());
    assert!(matches!(Frame::decode(bytes), Err(FrameError::Truncated { .. })));
}

#[test]
fn every_vector_is_read_as_its_kind_says() {
    let mut kinds = BTreeMap::<String, usize>::new();
    for vector in recorded::vectors() {
        let (kind, bytes) = (vector["kind"].as_str().unwrap(), recorded::bytes(&vector));
        match kind {
            "reject" | "reject-or-desync" => refused(&vector, &bytes),
            "incomplete" => incomplete(&vector, &bytes),
            // Reports of a USB device have tests of their own.
            "usb" | "usb-too-long" | "usb-assumed" => {}
            _ => decoded(&vector, &bytes),
        }
        *kinds.entry(kind.into()).or_default() += 1;
    }
    let kinds: Vec<_> = kinds.iter().map(|(kind, count)| (&kind[..], *count)).collect();
    let wanted = [
        ("accept", 12),
        ("accept-invalid", 4),
        ("accept-legacy", 3),
        ("accept-unknown", 2),
        ("incomplete", 2),
        ("ok", 146),
        ("ok-stream", 2),
        ("reject", 7),
        ("reject-or-desync", 1),
        ("usb", 4),
        ("usb-assumed", 1),
        ("usb-too-long", 1),
    ];
    assert_eq!(kinds, wanted, "all vectors: 179 messages and streams, 6 USB reports");
}

/// Some vectors have the name of their status in their own name.
#[test]
fn a_status_has_the_name_that_the_vectors_give_it() {
    let mut named = 0;
    for vector in recorded::vectors() {
        let name = vector["name"].as_str().unwrap();
        let Some((number, name)) = name.strip_prefix("note/PlaybackStatus/").and_then(|name| name.split_once('-'))
        else {
            continue;
        };
        // Other vectors have the number of motors in their name.
        if let (Ok(number), true) = (number.parse(), name != "motors") {
            let known = PlaybackState(number).name().unwrap();
            assert!(known.replace('_', "").eq_ignore_ascii_case(name), "{number} is {known}, not {name}");
            named += 1;
        }
    }
    assert_eq!(named, 8);
}

#[test]
fn lint_warns_of_the_unwise_vectors() {
    let warned = |wanted: &str| {
        let vectors = recorded::vectors();
        let vector = vectors.iter().find(|vector| vector["name"] == wanted).unwrap();
        let bytes = recorded::bytes(vector);
        let lints = see(vector, Frame::decode(&bytes).unwrap()).unwrap().lints;
        let found: Vec<_> = lints.into_iter().map(|lint| (lint.severity, lint.what)).collect();
        found
    };
    assert_eq!(warned("traj/delay-until-f32"), [(Severity::Warning, "delay_interval_bits")]);
    assert_eq!(warned("traj/extra-unknown-block"), [(Severity::Warning, "block_id")]);
    assert_eq!(warned("traj/both-loops"), [(Severity::Error, "loop_after_reverse")]);
    assert_eq!(warned("traj/timelapse-with-loop"), [(Severity::Error, "loop_after_reverse")]);
    assert_eq!(warned("traj/gap-between-segments"), [(Severity::Error, "points")]);
    assert_eq!(warned("note/AuxInputStatus/ff"), [(Severity::Warning, "status")]);
    assert_eq!(warned("set/UserPassword/nul-outside-count"), [(Severity::Warning, "tail")]);
    assert_eq!(
        warned("kssp/encode/SetPositionSpeedAcceleration motor=10 position=0 speed=0 acceleration=0"),
        [(Severity::Warning, "acceleration")]
    );
}
