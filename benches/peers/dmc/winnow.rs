//! Parser with winnow: its combinators, and lists as vectors.

use benches::decode::Use;
use benches::traffic::Side;
use motion_core::fletcher::verify;
use winnow::binary::{le_i32, le_u8, le_u16, le_u32, length_take};
use winnow::combinator::{fail, preceded, repeat, seq};
use winnow::token::take;
use winnow::{ModalResult, Parser};

use super::Message;

fn message(side: Side, kind: u16, data: &mut &[u8]) -> ModalResult<Message> {
    // The length of a list is known, so that its vector is allocated once.
    let count = |before: usize| data.len().saturating_sub(before) / 4;
    let (after_five, after_four) = (count(5), count(4));
    match (side, kind) {
        (Side::Host, 0x0036) => {
            seq! { Message::Jog { motor: le_u8, speed: le_u16, destination: le_i32 } }.parse_next(data)
        }
        (Side::Host, 0x0101) => {
            seq! { Message::Upload { motor: le_u8, start_index: le_u32, positions: repeat(after_five, le_i32) } }
                .parse_next(data)
        }
        (Side::Device, 0x0034) => {
            seq! { Message::Positions { move_time: le_i32, positions: repeat(after_four, le_i32) } }.parse_next(data)
        }
        (Side::Device, 0x8000..) => seq! { Message::Ack { code: le_u16 } }.parse_next(data),
        _ => fail.parse_next(data),
    }
}

fn frame(stream: &mut &[u8], side: Side) -> ModalResult<(u32, Message)> {
    let fields = (le_u32, le_u16, length_take(le_u16), take(2_usize));
    let ((id, kind, mut data, _), bytes) = preceded(b"DF", fields).with_taken().parse_next(stream)?;
    if !verify(bytes) {
        return fail.parse_next(stream);
    }
    Ok((id, message(side, kind, &mut data)?))
}

#[inline]
pub(crate) fn read<U: Use>(mut stream: &[u8], side: Side) -> Option<(u32, &[u8])> {
    let (id, message) = frame(&mut stream, side).ok()?;
    Some((U::kept(message).sum().wrapping_add(id), stream))
}
