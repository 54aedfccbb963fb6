//! The conformance vectors.

use serde_json::Value;

/// All of them.
pub(crate) fn vectors() -> Vec<Value> {
    serde_json::from_str(include_str!("../../../vectors/kos.json")).unwrap()
}

/// The bytes of one.
pub(crate) fn bytes(vector: &Value) -> Vec<u8> {
    let hex = vector["hex"].as_str().unwrap();
    (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect()
}
