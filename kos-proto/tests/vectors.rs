//! The conformance vectors: every kind, every message, every field.

mod recorded;

use std::collections::BTreeMap;

use kos_proto::lint::Context;
use kos_proto::message::{Numbered, PlaybackState};
use kos_proto::{DecodeError, DeviceMessage, Frame, FrameError, Frames, HostMessage, Item};
use motion_core::lint::{Lints, Severity};
use motion_core::serialize::Map;
use serde_json::{Value, json};

/// What became of a frame.
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

/// Fields that the vectors leave out where they are 0.
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

/// Whether `found` is `wanted`, but for an unknown tail, and for fields that nobody uses.
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

/// Reads a vector as a stream that ends.
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
    assert!(rest.is_empty() && frames.held() == 0, "{name}: all of it");
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
            "accept-invalid" => assert!(error.is_some(), "{name}: the move is refused"),
            "accept-unknown" => assert!(!known && error.is_none(), "{name}"),
            "accept" | "accept-legacy" => assert!(known, "{name}"),
            other => panic!("{name}: {other}"),
        }
    }
}

/// The stream ends at it, or the message is an error.
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

/// The stream waits, and a datagram is too short.
fn incomplete(vector: &Value, bytes: &[u8]) {
    let mut frames: Box<Frames> = Box::default();
    assert_eq!(frames.push(bytes), bytes.len());
    assert!(frames.next().is_none(), "{}", vector["name"]);
    assert_eq!(frames.held(), bytes.len());
    assert!(matches!(Frame::decode(bytes), Err(FrameError::Truncated { .. })));
}

#[test]
fn all_vectors() {
    let mut kinds = BTreeMap::<String, usize>::new();
    for vector in recorded::vectors() {
        let (kind, bytes) = (vector["kind"].as_str().unwrap(), recorded::bytes(&vector));
        match kind {
            "reject" | "reject-or-desync" => refused(&vector, &bytes),
            "incomplete" => incomplete(&vector, &bytes),
            // Reports of a USB device are taken apart elsewhere.
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
    assert_eq!(kinds, wanted, "none is left out: 179 are held, 6 are reports");
}

/// The names of some vectors say which status they carry.
#[test]
fn a_status_has_the_name_that_the_vectors_give_it() {
    let mut named = 0;
    for vector in recorded::vectors() {
        let name = vector["name"].as_str().unwrap();
        let Some((number, name)) = name.strip_prefix("note/PlaybackStatus/").and_then(|name| name.split_once('-'))
        else {
            continue;
        };
        // Others say how many motors there are.
        if let (Ok(number), true) = (number.parse(), name != "motors") {
            let known = PlaybackState(number).name().unwrap();
            assert!(known.replace('_', "").eq_ignore_ascii_case(name), "{number} is {known}, not {name}");
            named += 1;
        }
    }
    assert_eq!(named, 8);
}

#[test]
fn lint_warns_of_what_the_vectors_say_is_unwise() {
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
