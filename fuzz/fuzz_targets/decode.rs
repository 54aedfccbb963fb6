//! Laws of messages: any bytes as the body of any message of each side of each protocol.
//!
//! Input: the side, the number of the message in the tables (`u32`, little-endian), then its body.

#![no_main]

use fuzz::sides::{DmcDevice, DmcHost, HootDevice, HootHost, KosDevice, KosHost};
use laws::message::{Side, any_body, prefixes};
use libfuzzer_sys::fuzz_target;

/// Length of the longest body whose prefixes are all decoded too.
const SHORT: usize = 64;

fuzz_target!(|input: &[u8]| {
    let Some((&[side, ref number @ ..], body)) = input.split_first_chunk::<5>() else { return };
    let hold = match side % 6 {
        0 => hold::<KosHost>,
        1 => hold::<KosDevice>,
        2 => hold::<DmcHost>,
        3 => hold::<DmcDevice>,
        4 => hold::<HootHost>,
        _ => hold::<HootDevice>,
    };
    hold(u32::from_le_bytes(*number), body);
});

fn hold<S: Side>(number: u32, body: &[u8]) {
    let _ = any_body::<S>(number, body);
    if body.len() <= SHORT {
        prefixes::<S>(number, body);
    }
}
