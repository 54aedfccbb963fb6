//! Whole messages of kOS and their encoding, compared with other crates.
//!
//! E1: one message is encoded to its frame. The limit is to copy a finished frame.

use std::hint::black_box;

use benches::decode::{self, Whole};
use benches::ratios::{Contender, contender};
use benches::report::Report;
use benches::traffic::{self, Mix};
use bytes::{BufMut, BytesMut};
use kos_proto::trajectory::{Block, Blocks, TrajectoryData};
use kos_proto::{DeviceMessage, EncodeError, Kos};
use motion_core::stream::{Framing, Head};

use crate::peers::kos::readers;

pub(crate) fn chapter(report: &mut Report) {
    let mixes = [("mix", traffic::kos(true)), ("small mix", traffic::kos(false))];
    decode::rows(&mut report.table("kOS decode, whole messages"), &mixes, &readers::<Whole>());

    let mut table = report.table("kOS encode");
    for len in [12, 32, 42, 3796] {
        match message(&mixes[0].1, len).expect("the mix has a message of this length") {
            DeviceMessage::MotorPosition(it) => {
                table.row("12 B", encoders(move |out| DeviceMessage::MotorPosition(black_box(it)).encode_into(out)));
            }
            DeviceMessage::MotorInfo(it) => {
                table.row("32 B", encoders(move |out| DeviceMessage::MotorInfo(black_box(it)).encode_into(out)));
            }
            DeviceMessage::PlaybackStatus(it) => {
                table.row("42 B", encoders(move |out| DeviceMessage::PlaybackStatus(black_box(it)).encode_into(out)));
            }
            DeviceMessage::TrajectoryData(it) => {
                let blocks: Vec<_> = it.blocks.iter().collect();
                table.row("3796 B", encoders(move |out| move_of(black_box(&blocks), out)));
            }
            _ => {}
        }
    }
}

/// First message of the mix whose frame has this length.
fn message(mix: &Mix, wanted: usize) -> Option<DeviceMessage<'_>> {
    let mut stream = &mix.bytes[..];
    while let Head::Total(len) = Kos::<4096>::head(stream) {
        let (frame, rest) = stream.split_at(len);
        if len == wanted {
            return DeviceMessage::decode(&Kos::<4096>::frame(frame)?).ok();
        }
        stream = rest;
    }
    None
}

/// Encodes a move. Its blocks are encoded first.
fn move_of(blocks: &[Block<'_>], out: &mut [u8]) -> Result<usize, EncodeError> {
    let mut room = [0; 4096];
    let blocks = Blocks::encode(blocks, &mut room)?;
    DeviceMessage::TrajectoryData(TrajectoryData { blocks, tail: &[] }).encode_into(out)
}

/// Three contenders that write the same frame.
fn encoders<'a>(encode: impl Fn(&mut [u8]) -> Result<usize, EncodeError> + 'a) -> Vec<Contender<'a>> {
    let mut ours = [0; 4096];
    let len = encode(&mut ours).expect("the message can be encoded");
    let frame: Vec<u8> = ours[..len].into();

    let (header, body) = frame.split_first_chunk().expect("a header");
    let (header, body): ([u8; 6], Vec<u8>) = (*header, body.into());
    let mut buf = BytesMut::with_capacity(4096);
    put(&mut buf, header, &body);
    assert_eq!(buf, frame);

    let mut copy = [0; 4096];
    vec![
        contender("kos-proto", move || encode(black_box(&mut ours)).is_ok()),
        contender("memcpy", move || {
            let frame = black_box(&frame[..]);
            black_box(&mut copy)[..frame.len()].copy_from_slice(frame);
        }),
        contender("bytes, BytesMut", move || {
            buf.clear();
            put(black_box(&mut buf), black_box(header), black_box(&body));
        }),
    ]
}

/// Encoder as users of `bytes` write it: number by number.
fn put(buf: &mut BytesMut, [version, l0, l1, i0, i1, kind]: [u8; 6], body: &[u8]) {
    buf.put_u8(version);
    buf.put_u16(u16::from_be_bytes([l0, l1]));
    buf.put_u16(u16::from_be_bytes([i0, i1]));
    buf.put_u8(kind);
    let (bytes, numbers) = body.split_at(body.len() % 4);
    for &byte in bytes {
        buf.put_u8(byte);
    }
    for number in numbers.chunks_exact(4) {
        buf.put_f32(f32::from_be_bytes(*number.first_chunk().expect("four bytes")));
    }
}
