//! Law 13: an independent decoder, written with nom from the specification alone, reads the same.

mod decoder;

use decoder::{agree_on_reply, agree_on_request, rows};
use hoot_proto::HostMessage;
use motion_core::wire::Messages;
use proptest::prelude::*;
use serde_json::Value;

#[test]
fn vectors() {
    let vectors: Vec<Value> = serde_json::from_str(include_str!("../../vectors/hoot.json")).unwrap();
    let (mut known, mut answered) = (0, 0);
    for vector in &vectors {
        let hex = vector["hex"].as_str().unwrap();
        let bytes: Vec<u8> =
            (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect();
        let is_request = vector["direction"] == "request";
        known += usize::from(agree_on_request(&bytes) && is_request);
        answered += agree_on_reply(&bytes);
    }
    assert_eq!(known, 151);
    assert!(answered > 1000, "{answered}");
}

#[test]
fn the_tables_have_the_same_size() {
    // A run is a move without steps.
    assert_eq!(rows() + 1, HostMessage::ALL.len());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn any_packet(
        address in prop_oneof![1 => Just(0_u8), 1 => Just(1), 4 => Just(3), 1 => any::<u8>()],
        sub in prop_oneof![4 => 0_u8..5, 1 => any::<u8>()],
        command in prop_oneof![4 => 0_u8..28, 2 => 100_u8..122, 1 => any::<u8>()],
        data in proptest::collection::vec(prop_oneof![Just(0_u8), 0_u8..8, any::<u8>()], 0..12),
        spoilt in 0..10_u8,
        at in any::<prop::sample::Index>(),
        byte in any::<u8>(),
    ) {
        let len = u8::try_from(data.len()).unwrap();
        let mut bytes = [&[0, 0, 0, 0, 0, 0xFF, address, sub, command, len], &data[..]].concat();
        match spoilt {
            0 => *at.get_mut(&mut bytes) = byte,
            1 => bytes.truncate(at.index(bytes.len())),
            2 => bytes.push(byte),
            _ => {}
        }
        agree_on_request(&bytes);
    }

    #[test]
    fn any_reply(
        code in prop_oneof![Just(1_u8), any::<u8>()],
        value_type in 0_u8..8,
        value in proptest::collection::vec(any::<u8>(), 0..12),
    ) {
        let len = u8::try_from(value.len() + 1).unwrap();
        agree_on_reply(&[&[0, 0, 0, 0, 0, 0xFF, 0, 0, code, len, value_type], &value[..]].concat());
    }
}
