//! kOS: any bytes as a move that is read, evaluated, measured and planned again; and plans of any kind through the
//! builder and back.
//!
//! Input: which of the three, then the body of `TrajectoryData`, or the numbers of a plan, as `moves` reads them.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "../../kos-proto/tests/moves/mod.rs"]
mod moves;

fuzz_target!(|input: &[u8]| match input.split_first() {
    Some((0, body)) => moves::read(body),
    Some((1, numbers)) => moves::plan(numbers),
    Some((_, numbers)) => moves::hostile_plan(numbers),
    None => {}
});
