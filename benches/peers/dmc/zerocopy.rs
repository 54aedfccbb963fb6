//! Parser with zerocopy: structs over the bytes, and borrowed lists.

use benches::decode::Use;
use benches::traffic::Side;
use zerocopy::little_endian::{I32, U16, U32};
use zerocopy::{FromBytes, Immutable, KnownLayout, Unaligned};

use super::{sound, total};

#[derive(FromBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct Header {
    marker: [u8; 2],
    id: U32,
    kind: U16,
    len: U16,
}

#[derive(FromBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct Jog {
    motor: u8,
    speed: U16,
    destination: I32,
}

#[derive(FromBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct Upload {
    motor: u8,
    start_index: U32,
    positions: [I32],
}

#[derive(FromBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct Positions {
    move_time: I32,
    positions: [I32],
}

#[derive(FromBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct Ack {
    code: U16,
}

enum Message<'a> {
    Jog(&'a Jog),
    Upload(&'a Upload),
    Positions(&'a Positions),
    Ack(&'a Ack),
}

impl Message<'_> {
    fn sum(&self) -> u32 {
        let steps = |positions: &[I32]| total(positions.iter().map(|steps| steps.get().cast_unsigned()));
        match self {
            Self::Jog(it) => total([it.motor.into(), it.speed.get().into(), it.destination.get().cast_unsigned()]),
            Self::Upload(it) => total([it.motor.into(), it.start_index.get(), steps(&it.positions)]),
            Self::Positions(it) => it.move_time.get().cast_unsigned().wrapping_add(steps(&it.positions)),
            Self::Ack(it) => it.code.get().into(),
        }
    }
}

#[inline]
pub(crate) fn read<U: Use>(stream: &[u8], side: Side) -> Option<(u32, &[u8])> {
    let (header, _) = Header::ref_from_prefix(stream).ok().filter(|(header, _)| header.marker == *b"DF")?;
    let len = usize::from(header.len.get());
    let (bytes, rest) = sound(stream, len + 12)?;
    let data = bytes.get(10..len + 10)?;
    let message = match (side, header.kind.get()) {
        (Side::Host, 0x0036) => Message::Jog(Jog::ref_from_prefix(data).ok()?.0),
        (Side::Host, 0x0101) => Message::Upload(Upload::ref_from_bytes(data).ok()?),
        (Side::Device, 0x0034) => Message::Positions(Positions::ref_from_bytes(data).ok()?),
        (Side::Device, 0x8000..) => Message::Ack(Ack::ref_from_prefix(data).ok()?.0),
        _ => return None,
    };
    Some((U::kept(message).sum().wrapping_add(header.id.get()), rest))
}
