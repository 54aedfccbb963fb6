//! The conformance vectors, as the tests share them.

use serde_json::Value;

/// Every vector, and its bytes.
pub(crate) fn vectors() -> Vec<(Value, Vec<u8>)> {
    let text = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../vectors/dmc.json"));
    let vectors: Vec<Value> = serde_json::from_str(text).unwrap();
    let wire: Vec<_> = vectors.iter().map(|vector| bytes(&vector["hex"])).collect();
    vectors.into_iter().zip(wire).collect()
}

/// The bytes of a hex text.
pub(crate) fn bytes(hex: &Value) -> Vec<u8> {
    let hex = hex.as_str().unwrap();
    (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect()
}
