//! DMC: any bytes as a frame, and as the data of any message, compared with a second decoder that was written with nom.
//!
//! Input: the type of the message (`u16`, little-endian), then its data; or a frame.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "../../dmc-proto/tests/decoder/mod.rs"]
mod decoder;

fuzz_target!(|input: &[u8]| {
    decoder::frames_agree(input);
    if let Some((_, kind, data)) = decoder::frame(input) {
        decoder::agree(kind, data);
    } else if let Some((kind, data)) = input.split_first_chunk() {
        decoder::agree(u16::from_le_bytes(*kind), data);
    }
});
