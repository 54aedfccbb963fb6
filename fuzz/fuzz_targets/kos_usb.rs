//! kOS: any sequence of USB reports, compared with a model of plain vectors.
//!
//! The input is a list of operations, as `reports::hostile` reads them.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "../../kos-proto/tests/reports/mod.rs"]
mod reports;

fuzz_target!(|input: &[u8]| {
    reports::hostile::<0>(input);
    reports::hostile::<200>(input);
    reports::hostile::<1024>(input);
});
