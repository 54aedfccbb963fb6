//! DMC: any sequence of upload messages, compared with a model of plain vectors.
//!
//! The input is a list of operations, as `uploads::hostile` reads them.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "../../dmc-proto/tests/uploads/mod.rs"]
mod uploads;

fuzz_target!(|input: &[u8]| uploads::hostile(input));
