//! kOS: a stream of messages, cut messages, messages with a wrong length or version, and noise, in pieces, with gaps,
//! for receivers of several limits. It checks the laws of streams, and of each message that is found.
//!
//! The input is a list of operations, each one byte and its values: see `build`. The target `stream` takes the bytes as
//! they are. Here the lengths are right, so most inputs stay in step.

#![no_main]

use fuzz::rescan;
use kos_proto::frame::{self, Frame, HEADER_LEN, Kos, MAX_FRAME, MessageId, MessageType};
use kos_proto::{DeviceMessage, HostMessage};
use laws::stream::{Owned, check};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| {
    let (stream, gaps, pieces) = build(input);
    let mut pieces = pieces.into_iter().chain([1]).cycle();
    let mut cut = || pieces.next().unwrap_or(1);
    let items = check::<Kos, { 2 * MAX_FRAME }>(&stream, &gaps, &mut cut, |rest| rescan::kos(rest, MAX_FRAME));
    for item in &items {
        if let Owned::Frame(bytes) = item {
            let frame = Frame::decode(bytes).expect("the stream found it");
            let _ = (HostMessage::decode(&frame), DeviceMessage::decode(&frame));
        }
    }
    check::<Kos<100>, 201>(&stream, &gaps, &mut cut, |rest| rescan::kos(rest, 100));
    check::<Kos<7>, 14>(&stream, &gaps, cut, |rest| rescan::kos(rest, 7));
});

/// Builds the stream, the places of its gaps, and the lengths of its pieces.
fn build(input: &[u8]) -> (Vec<u8>, Vec<usize>, Vec<usize>) {
    let (mut stream, mut gaps, mut pieces) = (Vec::new(), Vec::new(), Vec::new());
    let mut input = input.iter().copied();
    while let (Some(what), Some(amount)) = (input.next(), input.next()) {
        match what % 8 {
            // A message, complete, without its end, or with one byte changed.
            0..=3 => {
                let (id, kind) = (input.next().unwrap_or(0), input.next().unwrap_or(0));
                let payload: Vec<u8> = input.by_ref().take(amount.into()).collect();
                let mut message = vec![0; payload.len() + HEADER_LEN];
                let written = frame::encode(MessageId(id.into()), MessageType(kind), &payload, &mut message);
                assert_eq!(written, Ok(message.len()));
                let at = usize::from(input.next().unwrap_or(0)) % message.len();
                match what % 8 {
                    2 => message.truncate(at),
                    3 => message[at] ^= 1,
                    _ => {}
                }
                stream.extend(message);
            }
            // A header with a wrong length, or with one that later bytes fill.
            4 => stream.extend([4, amount >> 4, amount << 4, 0, 0x0f, 1]),
            5 => stream.extend(input.by_ref().take(amount.into())),
            6 => gaps.push(stream.len()),
            _ => pieces.push(usize::from(amount).max(1)),
        }
    }
    (stream, gaps, pieces)
}
