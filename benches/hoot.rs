//! D3: decoding of hoot, compared with other crates.
//!
//! Packets of 10 to 15 bytes in one slice, of both directions, are decoded to typed messages, whose fields are all
//! added up. Each contender knows the four messages of the mix and their directions, and must find the values that were
//! encoded. The limit is to walk from length to length and to add up all bytes.
//!
//! Nothing in a reply says what it answers. The mix has one kind of query, so our contender reads each value through
//! that query. A listener reads a value by the type before it, and the bench of streams does that with the same mix in
//! one slice. Here it would be a second place that decodes commands, and then the optimiser would not decode them in
//! the loop, as it does for all peers.
//!
//! `hoot count CONTENDER mix TIMES` reads the mix that many times with one contender, and does nothing else. The
//! difference of two runs under `valgrind --tool=callgrind` is the number of instructions.

#[path = "peers/hoot.rs"]
mod peers;

use benches::decode::{self, LIMIT, Read, read, touch};
use benches::traffic::{self, Protocol, Side};
use hoot_proto::message::{Motor, MotorPosition};
use hoot_proto::{DeviceMessage, Frame, Hoot, Query};
use motion_core::stream::{Framing, Head};

const READERS: [(&str, Read); 5] = [
    ("hoot-proto", |mix| read(mix, |stream, side| ours(stream, side, through_query))),
    (LIMIT, |mix| read(mix, limit)),
    ("zerocopy", |mix| read(mix, peers::zerocopy::read)),
    ("nom", |mix| read(mix, peers::nom::read)),
    ("binrw", |mix| read(mix, peers::binrw::read)),
];

fn main() {
    let mixes = [("mix", traffic::hoot())];
    if !decode::counts(&READERS, &mixes) {
        decode::table("D3, packets in one slice to typed messages, 2000 of them", &READERS, &mixes);
    }
}

#[inline]
fn ours<'a>(stream: &'a [u8], side: Side, sum: impl Fn(Side, &Frame<'a>) -> u32) -> Option<(u32, &'a [u8])> {
    let Head::Total(len) = Hoot::<32>::head(stream) else { return None };
    let (bytes, rest) = stream.split_at_checked(len)?;
    Some((sum(side, &Hoot::<32>::frame(bytes)?), rest))
}

/// Sum of a packet: requests as the mix reads them, and replies with a value through the query that they answer. The
/// motor of the query changes nothing.
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

#[inline]
fn limit(stream: &[u8], _: Side) -> Option<(u32, &[u8])> {
    touch(stream, usize::from(*stream.get(9)?) + 10)
}
