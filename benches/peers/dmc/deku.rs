//! Parser with deku: its derive macros, and lists as vectors.

use benches::decode::Use;
use benches::traffic::Side;
use deku::prelude::*;

use super::{Message, frame_len, sound};

#[derive(DekuRead)]
#[expect(dead_code, reason = "read to reach the body")]
#[deku(endian = "little", magic = b"DF")]
struct Frame {
    id: u32,
    kind: u16,
    len: u16,
    #[deku(ctx = "*kind, *len")]
    body: Body,
}

#[derive(DekuRead)]
#[deku(endian = "endian", ctx = "endian: deku::ctx::Endian, kind: u16, len: u16", id = "kind")]
enum Body {
    #[deku(id = "0x0036")]
    Jog { motor: u8, speed: u16, destination: i32 },
    #[deku(id = "0x0101")]
    Upload {
        motor: u8,
        start_index: u32,
        #[deku(count = "len.saturating_sub(5) / 4")]
        positions: Vec<i32>,
    },
    #[deku(id = "0x0034")]
    Positions {
        move_time: i32,
        #[deku(count = "len.saturating_sub(4) / 4")]
        positions: Vec<i32>,
    },
    #[deku(id_pat = "0x8000..=0xffff")]
    Ack { code: u16 },
}

impl From<Body> for Message {
    fn from(body: Body) -> Self {
        match body {
            Body::Jog { motor, speed, destination } => Self::Jog { motor, speed, destination },
            Body::Upload { motor, start_index, positions } => Self::Upload { motor, start_index, positions },
            Body::Positions { move_time, positions } => Self::Positions { move_time, positions },
            Body::Ack { code } => Self::Ack { code },
        }
    }
}

/// Reads one message. Each type of the mixes has one direction, so the side is not needed.
#[inline]
pub(crate) fn read<U: Use>(stream: &[u8], _: Side) -> Option<(u32, &[u8])> {
    let (bytes, rest) = sound(stream, frame_len(stream)?)?;
    let (_, frame) = Frame::from_bytes((bytes, 0)).ok()?;
    Some((U::kept(Message::from(frame.body)).sum().wrapping_add(frame.id), rest))
}
