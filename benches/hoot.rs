//! D3: hoot, decoded beside peers.
//!
//! Packets of 10 to 15 bytes that lie in one slice, to typed messages whose fields are all added up, both directions.
//! Every contender knows the four messages of the mix and their directions, and must find the values that went in. The
//! limit is to walk from length to length and to add all bytes.
//!
//! Nothing in a reply says what it answers. The mix has one kind of query, so ours reads each value through that. By the
//! type in front of it, as somebody does who only listens, the bench of streams reads the same mix in one slice. Here that
//! would be a second place that decodes commands, and keep the optimiser from decoding them in the loop, as all peers do.
//!
//! `hoot count CONTENDER TIMES` reads the mix so many times with one contender, and does nothing else. The difference of
//! two runs under `valgrind --tool=callgrind` is the number of instructions.

#[path = "peers/hoot.rs"]
mod peers;

use std::hint::black_box;

use benches::ratios::{Contender, Table, contender};
use benches::traffic::{self, Mix, Protocol, Side, Tally};
use hoot_proto::message::{Motor, MotorPosition};
use hoot_proto::{DeviceMessage, Frame, Hoot, Query};
use motion_core::stream::{Framing, Head};

/// Reads a stream: each packet, and who sent it, to the sum of its fields.
type Read = fn(&Mix) -> Tally;

const LIMIT: &str = "walk and touch";
const READERS: [(&str, Read); 5] = [
    ("hoot-proto", |mix| read(mix, |stream, side| ours(stream, side, through_query))),
    (LIMIT, |mix| read(mix, touch)),
    ("zerocopy", |mix| read(mix, peers::zerocopy::read)),
    ("nom", |mix| read(mix, peers::nom::read)),
    ("binrw", |mix| read(mix, peers::binrw::read)),
];

fn main() {
    let mix = traffic::hoot();
    let args: Vec<_> = std::env::args().skip_while(|arg| arg != "count").collect();
    if let [_, reader, times] = &args[..] {
        return count(reader, times.parse().expect("a number of times"), &mix);
    }
    let mut table = Table::new("D3, packets in one slice to typed messages, 2000 of them");
    table.row("hoot mix", READERS.map(|(name, read)| reader(name, read, &mix)).into());
}

/// A contender that finds what is in the mix; that of the limit only walks it.
fn reader<'a>(name: &'static str, read: Read, mix: &'a Mix) -> Contender<'a> {
    if name == LIMIT {
        assert_eq!(read(mix).messages, mix.tally.messages);
    } else {
        assert_eq!(read(mix), mix.tally, "{name}");
    }
    contender(name, move || read(black_box(mix)))
}

fn count(reader: &str, times: u32, mix: &Mix) {
    let (_, read) = READERS.into_iter().find(|(name, _)| *name == reader).expect("a contender");
    for _ in 0..times {
        black_box(read(black_box(mix)));
    }
}

/// Goes from packet to packet, as each contender reads one: the sum of its fields, and the bytes behind it.
#[inline]
fn read<'a>(mix: &'a Mix, packet: impl Fn(&'a [u8], Side) -> Option<(u32, &'a [u8])>) -> Tally {
    let (mut tally, mut stream) = (Tally::default(), &mix.bytes[..]);
    for &side in &mix.sides {
        let Some((sum, rest)) = packet(stream, side) else { break };
        tally.messages += 1;
        tally.value = tally.value.rotate_left(1) ^ sum;
        stream = rest;
    }
    tally
}

#[inline]
fn ours<'a>(stream: &'a [u8], side: Side, sum: impl Fn(Side, &Frame<'a>) -> u32) -> Option<(u32, &'a [u8])> {
    let Head::Total(len) = Hoot::<32>::head(stream) else { return None };
    let (bytes, rest) = stream.split_at_checked(len)?;
    Some((sum(side, &Hoot::<32>::frame(bytes)?), rest))
}

/// Requests as the mix reads them, and replies with a value through the query that they answer. For which motor that was
/// changes nothing.
#[inline]
fn through_query(side: Side, frame: &Frame<'_>) -> u32 {
    if side == Side::Host {
        return <Hoot as Protocol>::sum(side, frame);
    }
    let DeviceMessage::Reply(reply) = DeviceMessage::decode(frame) else { return 0 };
    let code = u32::from(reply.code.0);
    if reply.data.is_empty() {
        return code;
    }
    let Ok(position) = (MotorPosition { motor: Motor::One }).decode_reply(reply) else { return 0 };
    code.wrapping_add(position.value_type().0.into()).wrapping_add(position.value.0.cast_unsigned())
}

/// The limit: all bytes, as numbers of 64 bits.
#[inline]
fn touch(stream: &[u8], _: Side) -> Option<(u32, &[u8])> {
    let (bytes, rest) = stream.split_at_checked(usize::from(*stream.get(9)?) + 10)?;
    let words = bytes.chunks_exact(8);
    let last = words.remainder().iter().fold(0, |sum: u64, &byte| sum << 8 | u64::from(byte));
    let sum =
        words.fold(last, |sum, word| sum.wrapping_add(u64::from_le_bytes(*word.first_chunk().expect("eight bytes"))));
    Some(((sum >> 32) as u32 ^ (sum & 0xFFFF_FFFF) as u32, rest))
}
