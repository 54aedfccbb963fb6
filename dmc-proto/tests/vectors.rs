//! Every conformance vector against the types: the same values and the same bytes.

mod recorded;

use dmc_proto::frame::{self, MessageId, MessageType};
use dmc_proto::{DeviceMessage, Frame, FrameError, HostMessage};
use motion_core::wire::Messages;
use recorded::{bytes, vectors};
use serde_json::Value;

/// Result of reading a frame.
struct Seen {
    known: bool,
    fields: Value,
    encoded: Vec<u8>,
}

macro_rules! seen {
    ($side:ident, $frame:expr) => {{
        let message = $side::decode(&$frame).unwrap();
        let mut encoded = vec![0; message.encoded_len()];
        assert_eq!(message.encode_into($frame.id(), &mut encoded), Ok(encoded.len()));
        let known = !matches!(message, $side::Other(_));
        assert_eq!(known, $side::ALL.iter().any(|kind| kind.name == message.name()));
        Seen { known, fields: serde_json::to_value(message).unwrap(), encoded }
    }};
}

fn seen(vector: &Value, frame: Frame<'_>) -> Seen {
    match vector["direction"].as_str().unwrap() {
        "request" => seen!(HostMessage, frame),
        "response" | "unsolicited" => seen!(DeviceMessage, frame),
        direction => panic!("{direction}"),
    }
}

#[test]
fn every_vector_has_its_values_and_its_bytes() {
    let (mut known, mut unknown, mut invalid) = (0, 0, 0);
    for (vector, wire) in vectors() {
        let name = &vector["name"];
        if let Some(why) = vector.get("invalid") {
            assert_eq!(why, "checksum", "{name}");
            assert_eq!(Frame::decode(&wire), Err(FrameError::Checksum { len: wire.len() }), "{name}");
            invalid += 1;
            continue;
        }
        let frame = Frame::decode(&wire).unwrap_or_else(|error| panic!("{name}: {error}"));
        let kind = u16::from_str_radix(vector["type"].as_str().unwrap().trim_start_matches("0x"), 16).unwrap();
        assert_eq!(frame.kind(), MessageType(kind), "{name}");
        assert_eq!(u64::from(frame.id().0), vector["id"], "{name}");
        assert_eq!(frame.payload().len(), vector["data_len"], "{name}");

        let seen = seen(&vector, frame);
        if seen.known {
            // The vectors leave out the upper half of a code of four bytes. The encoding below shows that it is kept.
            let mut fields = seen.fields;
            if let Some(fields) = fields.as_object_mut().filter(|_| vector["fields"].get("tail").is_none()) {
                let tail = fields.remove("tail");
                assert!(tail.is_none() || frame.kind().is_ack() && tail == Some("0000".into()), "{name}");
            }
            assert_eq!(fields, vector["fields"], "{name}");
            known += 1;
        } else {
            assert_eq!(bytes(&seen.fields["data"]), frame.payload(), "{name}");
            unknown += 1;
        }
        let canonical = vector.get("canonical").map_or_else(|| wire.clone(), bytes);
        assert_eq!(seen.encoded, canonical, "{name}");
        let mut raw = vec![0; canonical.len()];
        assert_eq!(frame::encode(frame.id(), frame.kind(), frame.payload(), &mut raw), Ok(raw.len()), "{name}");
        assert_eq!(raw, canonical, "{name}");
    }
    assert_eq!((known, unknown, invalid), (141, 16, 1));
}

#[test]
fn ids_of_the_vectors_include_the_unsolicited_and_the_greatest_id() {
    let ids: Vec<_> = vectors().iter().map(|(vector, _)| vector["id"].as_u64().unwrap()).collect();
    assert!(ids.contains(&MessageId::UNSOLICITED.0.into()) && ids.contains(&u32::MAX.into()));
}
