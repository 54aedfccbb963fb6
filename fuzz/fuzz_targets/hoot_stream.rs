//! hoot: a stream of packets, cut packets, packets with a wrong length, and noise, in pieces, with gaps, for masters
//! and nodes of several limits. It checks the laws of streams, and of each packet that is found.
//!
//! The input is a list of operations, each one byte and its values: see `build`. The target `stream` takes the bytes as
//! they are. Here the lengths are right, so most inputs stay in step.

#![no_main]

use fuzz::rescan;
use hoot_proto::frame::{self, BREAK, Hoot, MAX_DATA, MAX_FRAME, Requests, Strict};
use hoot_proto::{Address, DeviceMessage, Frame, HostMessage, beyond};
use laws::stream::{Owned, check};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| {
    let (stream, gaps, pieces) = build(input);
    let mut pieces = pieces.into_iter().chain([1]).cycle();
    let mut cut = || pieces.next().unwrap_or(1);
    let tolerant = check::<Hoot, { 2 * MAX_FRAME }>(&stream, &gaps, &mut cut, |rest| rescan::hoot(rest, MAX_DATA));
    let strict =
        check::<Strict, { 2 * MAX_FRAME }>(&stream, &gaps, &mut cut, |rest| rescan::hoot_strict(rest, MAX_DATA));
    for item in tolerant.iter().chain(&strict) {
        if let Owned::Frame(bytes) = item {
            let packet = Frame::decode(bytes).expect("the stream found it");
            let _ =
                (HostMessage::decode(&packet), beyond::HostMessage::decode(&packet), DeviceMessage::decode(&packet));
        }
    }
    check::<Requests, { 2 * MAX_FRAME }>(&stream, &gaps, &mut cut, |rest| match rest.get(6..10) {
        Some(&[0, 0, 0, 0]) => Err(1),
        _ => rescan::hoot(rest, MAX_DATA),
    });
    check::<Hoot<4>, 28>(&stream, &gaps, &mut cut, |rest| rescan::hoot(rest, 4));
    check::<Strict<0>, 20>(&stream, &gaps, cut, |rest| rescan::hoot_strict(rest, 0));
});

/// Builds the stream, the places of its gaps, and the lengths of its pieces.
fn build(input: &[u8]) -> (Vec<u8>, Vec<usize>, Vec<usize>) {
    let (mut stream, mut gaps, mut pieces) = (Vec::new(), Vec::new(), Vec::new());
    let mut input = input.iter().copied();
    while let (Some(what), Some(amount)) = (input.next(), input.next()) {
        match what % 8 {
            // A packet, complete, without its end, or with one byte changed.
            0..=3 => {
                let [address, sub_address, command] = [(); 3].map(|()| input.next().unwrap_or(0));
                let data: Vec<u8> = input.by_ref().take(usize::from(amount) % (MAX_DATA + 1)).collect();
                let mut packet = [0; MAX_FRAME];
                let written = frame::encode(Address(address), sub_address, command, &data, &mut packet);
                let packet = &mut packet[..written.expect("no more than a node has room for")];
                let at = usize::from(input.next().unwrap_or(0)) % packet.len();
                match what % 8 {
                    2 => stream.extend_from_slice(&packet[..at]),
                    3 => {
                        packet[at] ^= 1;
                        stream.extend_from_slice(packet);
                    }
                    _ => stream.extend_from_slice(packet),
                }
            }
            // A header with a wrong length, or with one that later bytes fill.
            4 => stream.extend(BREAK.into_iter().chain([3, 0, 7, amount])),
            5 => stream.extend(input.by_ref().take(amount.into())),
            6 => gaps.push(stream.len()),
            _ => pieces.push(usize::from(amount).max(1)),
        }
    }
    (stream, gaps, pieces)
}
