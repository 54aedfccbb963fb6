//! kOS: any bytes as a message, and as the payload of any message, compared with a second decoder that was written with
//! nom.
//!
//! Input: id (`u16`, big-endian) and type of the message, then its payload; or a message. The input also draws a message of
//! each side.

#![no_main]

use fuzz::drawn;
use kos_proto::{Device, Host};
use libfuzzer_sys::fuzz_target;

#[path = "../../kos-proto/tests/decoder/mod.rs"]
mod decoder;

fuzz_target!(|input: &[u8]| {
    decoder::agree(input);
    drawn::frame::<Host>(input, |_| (), |message| drop(decoder::agree(message)));
    drawn::frame::<Device>(input, |_| (), |message| drop(decoder::agree(message)));
    if let Some((&[i0, i1, kind], payload)) = input.split_first_chunk()
        && payload.len() < 60_000
    {
        decoder::agree(&decoder::message(u16::from_be_bytes([i0, i1]), kind, payload));
    }
});
