//! Parser with binrw: its derive macros, lists as vectors, and no list of errors, which would take longer.

use std::io::Cursor;

use benches::decode::Use;
use benches::traffic::Side;
use binrw::BinRead;

use super::{Message, frame_len, sound};

#[derive(BinRead)]
#[expect(dead_code, reason = "read to reach the body")]
#[br(little, magic = b"DF")]
struct Frame {
    id: u32,
    kind: u16,
    len: u16,
    #[br(args(kind, len))]
    body: Body,
}

#[derive(BinRead)]
#[br(little, return_unexpected_error, import(kind: u16, len: u16))]
enum Body {
    #[br(pre_assert(kind == 0x0034))]
    Positions {
        move_time: i32,
        #[br(count = len.saturating_sub(4) / 4)]
        positions: Vec<i32>,
    },
    #[br(pre_assert(kind >= 0x8000))]
    Ack { code: u16 },
    #[br(pre_assert(kind == 0x0036))]
    Jog { motor: u8, speed: u16, destination: i32 },
    #[br(pre_assert(kind == 0x0101))]
    Upload {
        motor: u8,
        start_index: u32,
        #[br(count = len.saturating_sub(5) / 4)]
        positions: Vec<i32>,
    },
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
    let frame = Frame::read(&mut Cursor::new(bytes)).ok()?;
    Some((U::kept(Message::from(frame.body)).sum().wrapping_add(frame.id), rest))
}
