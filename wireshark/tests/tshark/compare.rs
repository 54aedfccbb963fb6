//! Comparison of a frame as the crates decode it with a frame as tshark prints it.

use std::path::PathBuf;
use std::{env, fs};

use motion_core::wire::{DecodeError, Messages};
use serde_json::Value;
use wireshark::view::{Leaf, View, views};

use crate::capture::Sender;
use crate::pdml::{Frame, Item};

/// Frame as it should be.
#[derive(Debug)]
pub(crate) struct Expected {
    pub(crate) sender: Sender,
    /// Name of the message; `None` if it is not the business of the vector.
    pub(crate) name: &'static str,
    /// Values of the message; `None` if the body cannot be decoded.
    pub(crate) views: Option<Vec<View>>,
    /// Expert information that must be there.
    pub(crate) experts: Vec<&'static str>,
}

impl Expected {
    /// What a decoder says.
    pub(crate) fn of<'m, M: Messages<'m>>(sender: Sender, decoded: Result<M, DecodeError>) -> Self {
        match decoded {
            Ok(message) => {
                let views = views(&message);
                let has = |name: &str| views.iter().any(|view| view.name == name);
                let mut experts = Vec::new();
                experts.extend(has("tail").then_some("trailing"));
                experts.extend((has("data") || message.name() == "Other").then_some("unknown"));
                Self { sender, name: message.name(), views: Some(views), experts }
            }
            Err(error) => {
                let DecodeError::Truncated { what, .. } = error else { panic!("{error}") };
                let name = what.split('.').next().expect("a text has a first part");
                Self { sender, name, views: None, experts: vec!["short"] }
            }
        }
    }
}

/// Request of hoot: a message of the published sheet, or else of later firmware.
pub(crate) fn hoot_request(frame: &hoot_proto::Frame<'_>) -> Expected {
    match hoot_proto::HostMessage::decode(frame) {
        hoot_proto::HostMessage::Other(_) => {
            Expected::of(Sender::Host, Ok(hoot_proto::beyond::HostMessage::decode(frame)))
        }
        message => Expected::of(Sender::Host, Ok(message)),
    }
}

/// Vectors of a file.
pub(crate) fn vectors(file: &str) -> Vec<Value> {
    let text = fs::read_to_string(wireshark::root().join("vectors").join(file)).expect("the vectors exist");
    serde_json::from_str(&text).expect("the vectors are JSON")
}

/// Text of a key of a vector.
pub(crate) fn text<'v>(vector: &'v Value, key: &str) -> &'v str {
    vector[key].as_str().unwrap_or_default()
}

/// Bytes of a vector.
pub(crate) fn bytes(hex: &str) -> Vec<u8> {
    let digits = |at| u8::from_str_radix(&hex[at..at + 2], 16).expect("hexadecimal digits");
    (0..hex.len()).step_by(2).map(digits).collect()
}

/// Path of a file for a test, which no other test uses.
pub(crate) fn scratch(name: &str) -> PathBuf {
    env::temp_dir().join(format!("dissectors-{}-{name}.pcapng", std::process::id()))
}

/// Compares a frame. `header` is the last item before the body.
///
/// # Panics
///
/// If something differs.
pub(crate) fn compare(what: &str, expected: &Expected, found: &Frame, header: &str) {
    let Expected { sender, name, views, experts } = expected;
    assert_eq!(found.get("sender"), Some(sender.name()), "{what}");
    for expert in experts {
        assert!(found.has_expert(expert), "{what}: no expert information {expert} in {found:#?}");
    }
    let Some(views) = views else { return };
    assert_eq!(found.get("message"), Some(*name), "{what}");
    for fault in ["short", "trailing", "unknown", "checksum"] {
        assert_eq!(found.has_expert(fault), experts.contains(&fault), "{what}: expert information {fault}");
    }
    let begin = found.items.iter().position(|item| item.name == header).expect("a header") + 1;
    let is_value =
        |item: &&Item| !item.name.starts_with("expert.") && !["block_length", "checksum"].contains(&&*item.name);
    let body: Vec<_> = found.items[begin..].iter().filter(is_value).collect();
    let names = |item: &&Item| item.name.clone();
    // The tree has no item without bytes.
    let views: Vec<_> = views.iter().filter(|view| view.leaf != Leaf::Bytes(Vec::new())).collect();
    let expected_names: Vec<_> = views.iter().map(|view| view.name.clone()).collect();
    assert_eq!(body.iter().map(names).collect::<Vec<_>>(), expected_names, "{what}: {name}");
    for (view, item) in views.into_iter().zip(body) {
        assert!(same(view, item), "{what}: {view:?} is printed as {item:?}");
    }
}

fn same(view: &View, item: &Item) -> bool {
    let number =
        || item.show.strip_prefix("0x").map_or_else(|| item.show.parse().ok(), |hex| i64::from_str_radix(hex, 16).ok());
    let is_value = match &view.leaf {
        Leaf::Unsigned(value) if item.show.matches('.').count() == 3 => {
            view.text == item.show || item.bytes == value.to_be_bytes()[4..]
        }
        Leaf::Unsigned(value) => number() == i64::try_from(*value).ok(),
        Leaf::Signed(value) => number() == Some(*value),
        Leaf::Float(bits) => item.bytes == bits.to_be_bytes() || item.bytes == bits.to_le_bytes(),
        Leaf::Text(text) => {
            let end = text.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
            item.bytes == text[..end]
        }
        Leaf::Secret(text) if text.is_empty() => item.show.is_empty(),
        Leaf::Secret(text) => item.show == format!("hidden, {} bytes", text.len()) && item.bytes.is_empty(),
        Leaf::Bytes(bytes) => item.bytes == *bytes,
    };
    // A name, or a number with a decimal point, is shown beside the value.
    let is_decimal = view.text.contains('.') && view.text.parse::<f64>().is_ok();
    let is_shown = is_decimal || view.text.starts_with(char::is_alphabetic);
    // The text of a yes adds its number if it is not 1.
    let word = view.text.split(" (").next().unwrap_or_default();
    let is_number = matches!(view.leaf, Leaf::Unsigned(_) | Leaf::Signed(_));
    is_value && (!(is_number && is_shown) || item.text.contains(word)) && item.text.contains(view.unit)
}
