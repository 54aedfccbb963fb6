//! DMC: any bytes as a frame, and as the data of any message, compared with a second decoder that was written with nom.
//!
//! Input: the type of the message (`u16`, little-endian), then its data; or a frame. The input also draws a message of
//! each side.

#![no_main]

use dmc_proto::{Device, Host, MessageId};
use fuzz::drawn;
use libfuzzer_sys::fuzz_target;

#[path = "../../dmc-proto/tests/decoder/mod.rs"]
mod decoder;

fuzz_target!(|input: &[u8]| {
    decoder::frames_agree(input);
    let drawn = |frame: &[u8]| {
        decoder::frames_agree(frame);
        if let Some((_, kind, data)) = decoder::frame(frame) {
            decoder::agree(kind, data);
        }
    };
    drawn::frame::<Host>(input, |_| MessageId(1), drawn);
    drawn::frame::<Device>(input, |_| MessageId(1), drawn);
    if let Some((_, kind, data)) = decoder::frame(input) {
        decoder::agree(kind, data);
    } else if let Some((kind, data)) = input.split_first_chunk() {
        decoder::agree(u16::from_le_bytes(*kind), data);
    }
});
