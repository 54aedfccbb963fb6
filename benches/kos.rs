//! Decoding and encoding of kOS, compared with other crates.
//!
//! D2: frames in one slice are decoded to typed messages, whose fields are all added up. Each contender knows the four
//! messages of the mixes, and must find the values that were encoded. The limit is to walk from length to length and to
//! add up all bytes.
//!
//! D4: streams are decoded to typed messages, compared with complete parsers of other protocols. Each parser reads its
//! own protocol, so times are compared for each message. There are 2000 messages, of 23 bytes on average for kOS, 56
//! for DMC, 31 for mavlink and 32 for ublox.
//!
//! E1: one message is encoded to its frame. The limit is to copy a finished frame.
//!
//! `kos count CONTENDER MIX TIMES` reads a mix that many times with one contender of D2, and does nothing else. The
//! difference of two runs under `valgrind --tool=callgrind` is the number of instructions.

#[path = "peers/field.rs"]
mod field;
#[path = "peers/kos/mod.rs"]
mod peers;

use std::hint::black_box;

use benches::decode::{self, LIMIT, Read, read, touch};
use benches::ratios::{Contender, Table, contender};
use benches::traffic::{self, Mix, Protocol, Side};
use bytes::{BufMut, BytesMut};
use dmc_proto::Dmc;
use kos_proto::trajectory::{Block, Blocks, TrajectoryData};
use kos_proto::{DeviceMessage, EncodeError, Frame, Kos};
use motion_core::stream::{Frames, Framing, Head, Item, Memo};

const READERS: [(&str, Read); 7] = [
    ("kos-proto", |mix| read(mix, ours)),
    (LIMIT, |mix| read(mix, limit)),
    ("zerocopy", |mix| read(mix, peers::zerocopy::read)),
    ("nom", |mix| read(mix, peers::nom::read)),
    ("winnow", |mix| read(mix, peers::winnow::read)),
    ("deku", |mix| read(mix, peers::deku::read)),
    ("binrw", |mix| read(mix, peers::binrw::read)),
];

fn main() {
    let mixes = [("mix", traffic::kos(true)), ("small mix", traffic::kos(false))];
    if decode::counts(&READERS, &mixes) {
        return;
    }
    decode::table("D2, frames in one slice to typed messages, 2000 of them", &READERS, &mixes);
    whole_parsers(&mixes[1].1);
    let mut table = Table::new("E1, a message to its frame");
    for len in [12, 32, 42, 3796] {
        let message =
            frames(&mixes[0].1).find(|frame| frame.bytes().len() == len).map(|frame| DeviceMessage::decode(&frame));
        match message.expect("the mix has the message").expect("the message is valid") {
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

/// Compares complete parsers, which find, verify and decode the frames of their own protocol, message by message.
fn whole_parsers(kos: &Mix) {
    let mut table = Table::new("D4, complete parsers, each with 2000 messages of its own protocol");
    let (dmc, mavlink, ublox) = (&traffic::dmc(false), field::mavlink(), field::ublox());
    assert_eq!(field::read_mavlink(&mavlink.bytes), mavlink.tally);
    let mut parser = ublox::Parser::default_proto();
    assert_eq!(field::read_ublox(&mut parser, &ublox.bytes), ublox.tally);
    let mut row = |name: &'static str, ours: [Contender<'_>; 2]| {
        let mavlink = contender("mavlink", || field::read_mavlink(black_box(&mavlink.bytes)));
        let ublox = contender("ublox", || field::read_ublox(&mut parser, black_box(&ublox.bytes)));
        table.row(name, ours.into_iter().chain([mavlink, ublox]).collect());
    };
    row("kOS small mix", [stream::<Kos, 32_768>(kos), slice::<Kos>(kos)]);
    row("DMC small mix", [stream::<Dmc, 4096>(dmc), slice::<Dmc>(dmc)]);
}

/// Contender that reads frames in one slice.
fn slice<F: Protocol>(mix: &Mix) -> Contender<'_> {
    let read = |mix: &Mix| {
        let (mut reader, mut rest) = (mix.reader(), &mix.bytes[..]);
        while let Head::Total(len) = F::head(rest) {
            let (frame, behind) = rest.split_at(len);
            if let Some(frame) = F::frame(frame).filter(|_| F::Memo::<0>::is_sound(frame)) {
                reader.frame::<F>(&frame);
            }
            rest = behind;
        }
        reader.tally
    };
    assert_eq!(read(mix), mix.tally);
    contender("one slice", move || read(black_box(mix)))
}

/// Contender that reads a stream in one piece.
fn stream<F: Protocol, const N: usize>(mix: &Mix) -> Contender<'_> {
    let mut frames = Box::new(Frames::<F, N>::new());
    let mut read = move |mix: &Mix| {
        let (mut reader, mut rest) = (mix.reader(), &mix.bytes[..]);
        while !rest.is_empty() {
            rest = &rest[frames.push(rest)..];
            while let Some(Item::Frame(frame)) = frames.next() {
                reader.frame::<F>(&frame);
            }
        }
        reader.tally
    };
    assert_eq!(read(mix), mix.tally);
    contender("stream", move || read(black_box(mix)))
}

#[inline]
fn split(stream: &[u8]) -> Option<(Frame<'_>, &[u8])> {
    let Head::Total(len) = Kos::<4096>::head(stream) else { return None };
    let (bytes, rest) = stream.split_at_checked(len)?;
    Some((Kos::<4096>::frame(bytes)?, rest))
}

#[inline]
fn ours(stream: &[u8], side: Side) -> Option<(u32, &[u8])> {
    let (frame, rest) = split(stream)?;
    Some((<Kos as Protocol>::sum(side, &frame), rest))
}

#[inline]
fn limit(stream: &[u8], _: Side) -> Option<(u32, &[u8])> {
    touch(stream, usize::from(u16::from_be_bytes([*stream.get(1)?, *stream.get(2)?])))
}

fn frames(mix: &Mix) -> impl Iterator<Item = Frame<'_>> {
    let mut stream = &mix.bytes[..];
    std::iter::from_fn(move || {
        let (frame, rest) = split(stream)?;
        stream = rest;
        Some(frame)
    })
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
        contender("BytesMut", move || {
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
