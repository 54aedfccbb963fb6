//! hoot: any bytes as a packet, read as a request and as the answer to every query, compared with a second decoder that
//! was written with nom.
//!
//! Input: a packet; or a packet without its break and its length. The input also draws a message of each side.

#![no_main]

use fuzz::drawn::{self, address};
use hoot_proto::{Device, Host, Messages};
use libfuzzer_sys::fuzz_target;

#[allow(dead_code, reason = "the tests use more of it")]
#[path = "../../hoot-proto/tests/decoder/mod.rs"]
mod decoder;

fuzz_target!(|input: &[u8]| {
    decoder::agree_on_request(input);
    decoder::agree_on_reply(input);
    drawn::frame::<Host>(
        input,
        |message| address(message.number()),
        |packet| {
            decoder::agree_on_request(packet);
        },
    );
    drawn::frame::<Device>(
        input,
        |_| (),
        |packet| {
            decoder::agree_on_reply(packet);
        },
    );
    let Some((&[address, sub_address, command], data)) = input.split_first_chunk() else { return };
    let Ok(len) = u8::try_from(data.len()) else { return };
    let packet = [&[0, 0, 0, 0, 0, 0xFF, address, sub_address, command, len], data].concat();
    decoder::agree_on_request(&packet);
    decoder::agree_on_reply(&packet);
});
