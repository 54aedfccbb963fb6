//! Laws of messages: any bytes as the body of any message of each side of each protocol.
//!
//! Input: the side, the number of the message in the tables (`u32`, little-endian), then its body.

#![no_main]

use laws::message::{any_body, prefixes};
use libfuzzer_sys::fuzz_target;
use motion_core::wire::Side;

/// Length of the longest body whose prefixes are all decoded too.
const SHORT: usize = 64;

fuzz_target!(|input: &[u8]| {
    let Some((&[side, ref number @ ..], body)) = input.split_first_chunk::<5>() else { return };
    let hold = match side % 6 {
        0 => hold::<kos_proto::Host>,
        1 => hold::<kos_proto::Device>,
        2 => hold::<dmc_proto::Host>,
        3 => hold::<dmc_proto::Device>,
        4 => hold::<hoot_proto::Host>,
        _ => hold::<hoot_proto::Device>,
    };
    hold(u32::from_le_bytes(*number), body);
});

fn hold<S: Side>(number: u32, body: &[u8]) {
    let _ = any_body::<S>(number, body);
    if body.len() <= SHORT {
        prefixes::<S>(number, body);
    }
}
