//! DMC: a stream of frames, cut or damaged frames, markers and noise, in pieces, with gaps, for receivers of several
//! limits. It checks the laws of streams, and of each message that is found.
//!
//! The input is a list of operations, each one byte and its values: see `build`. The target `stream` takes the bytes as
//! they are. Here the checksums are right, so most inputs get past them.

#![no_main]

use dmc_proto::frame::{self, Dmc, Frame, MAX_FRAME, MessageId, MessageType};
use dmc_proto::{DeviceMessage, HostMessage};
use fuzz::rescan;
use laws::stream::{Owned, check};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| {
    let (stream, gaps, pieces) = build(input);
    let mut pieces = pieces.into_iter().chain([1]).cycle();
    let mut cut = || pieces.next().unwrap_or(1);
    let items = check::<Dmc, { 2 * MAX_FRAME }>(&stream, &gaps, &mut cut, |rest| rescan::dmc(rest, MAX_FRAME));
    for item in &items {
        if let Owned::Frame(bytes) = item {
            let frame = Frame::decode(bytes).expect("the stream found it");
            let _ = (HostMessage::decode(&frame), DeviceMessage::decode(&frame));
        }
    }
    check::<Dmc<1048>, 2096>(&stream, &gaps, &mut cut, |rest| rescan::dmc(rest, 1048));
    check::<Dmc<32>, 64>(&stream, &gaps, cut, |rest| rescan::dmc(rest, 32));
});

/// Builds the stream, the places of its gaps, and the lengths of its pieces.
fn build(input: &[u8]) -> (Vec<u8>, Vec<usize>, Vec<usize>) {
    let (mut stream, mut gaps, mut pieces) = (Vec::new(), Vec::new(), Vec::new());
    let mut input = input.iter().copied();
    while let (Some(what), Some(amount)) = (input.next(), input.next()) {
        let amount = usize::from(amount);
        match what % 8 {
            // A frame, complete, without its end, or with one byte changed.
            0..=3 => {
                let mut data = |len| input.by_ref().take(len).collect::<Vec<u8>>();
                let kind = data(2).first_chunk().map_or(0, |kind| u16::from_le_bytes(*kind));
                let data = data(amount);
                let mut wire = vec![0; data.len() + frame::OVERHEAD];
                let written = frame::encode(MessageId(7), MessageType(kind), &data, &mut wire);
                assert_eq!(written, Ok(wire.len()));
                let at = usize::from(input.next().unwrap_or(0)) % wire.len();
                match what % 8 {
                    2 => wire.truncate(at),
                    3 => wire[at] ^= 1,
                    _ => {}
                }
                stream.extend(wire);
            }
            // A marker with a wrong length, or with one that later bytes fill.
            4 => stream.extend([b"DF\0\0\0\0\x36\0".as_slice(), &(amount as u16 * 16).to_le_bytes()].concat()),
            5 => stream.extend(input.by_ref().take(amount)),
            6 => gaps.push(stream.len()),
            _ => pieces.push(amount.max(1)),
        }
    }
    (stream, gaps, pieces)
}
