//! No request makes the page panic, and every answer is JSON.

use page::Page;
use proptest::prelude::*;
use serde_json::Value;

const CAPTURES: [&str; 3] = [
    include_str!("../../examples/captures/kos.txt"),
    include_str!("../../examples/captures/dmc.txt"),
    include_str!("../../examples/captures/hoot.txt"),
];
const MOVE: &str = include_str!("../../examples/moves/slide.json");

/// Requests of every kind, with members of any kind.
fn head() -> impl Strategy<Value = String> {
    let word = prop_oneof![
        Just("null".to_owned()),
        prop::sample::select(vec!["kos", "dmc", "hoot", "host", "device", "stream", "datagram", "usb", "mild", ""])
            .prop_map(|word| format!("{word:?}")),
        any::<i64>().prop_map(|number| number.to_string()),
    ];
    let held = prop_oneof![
        Just("null".to_owned()),
        (any::<u8>(), any::<bool>())
            .prop_map(|(motor, forward)| format!("{{\"motor\":{motor},\"forward\":{forward}}}")),
    ];
    prop_oneof![
        (word.clone(), word.clone(), word.clone()).prop_map(|(protocol, from, transport)| {
            format!("{{\"call\":\"inspect\",\"protocol\":{protocol},\"from\":{from},\"transport\":{transport}}}")
        }),
        any::<String>().prop_map(|name| serde_json::json!({ "call": "curves", "name": name }).to_string()),
        (word.clone(), word).prop_map(|(protocol, device)| {
            format!("{{\"call\":\"start\",\"protocol\":{protocol},\"device\":{device}}}")
        }),
        any::<u8>().prop_map(|motor| format!("{{\"call\":\"go\",\"motor\":{motor}}}")),
        (any::<u32>(), held)
            .prop_map(|(millis, held)| { format!("{{\"call\":\"advance\",\"millis\":{millis},\"held\":{held}}}") }),
        prop::sample::select(vec!["connect", "stop", "devices", "nothing"])
            .prop_map(|call| format!("{{\"call\":{call:?}}}")),
        prop::sample::select(vec!["kos", "dmc", "hoot"])
            .prop_map(|protocol| format!("{{\"call\":\"start\",\"protocol\":{protocol:?},\"device\":\"mild\"}}")),
        any::<String>(),
    ]
}

/// Bytes, texts, and real files with some bytes changed.
fn body() -> impl Strategy<Value = Vec<u8>> {
    let real = prop::sample::select(vec![CAPTURES[0], CAPTURES[1], CAPTURES[2], MOVE]);
    let changed =
        (real, prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..8)).prop_map(|(file, changes)| {
            let mut bytes = file.as_bytes().to_vec();
            for (at, byte) in changes {
                let at = at.index(bytes.len());
                bytes[at] = byte;
            }
            bytes
        });
    prop_oneof![prop::collection::vec(any::<u8>(), 0..300), any::<String>().prop_map(String::into_bytes), changed]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_request_panics_and_every_answer_is_json(calls in prop::collection::vec((head(), body()), 1..20)) {
        let mut page = Page::default();
        for (head, body) in calls {
            let answer = page.call(&[head.as_bytes(), b"\n", &body].concat());
            let read: Value = serde_json::from_str(&answer).unwrap();
            if let Some(error) = read.get("error") {
                let line = error.as_str().unwrap();
                prop_assert!(!line.is_empty() && !line.contains('\n'), "{:?}", line);
            }
        }
    }

    #[test]
    fn any_bytes_are_no_reason_to_panic(request in prop::collection::vec(any::<u8>(), 0..200)) {
        serde_json::from_str::<Value>(&Page::default().call(&request)).unwrap();
    }
}
