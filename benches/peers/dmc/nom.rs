//! Parser with nom: its combinators, and lists as vectors.

use benches::decode::Use;
use benches::traffic::Side;
use nom::bytes::complete::{tag, take};
use nom::combinator::{map, verify};
use nom::error::{Error, ErrorKind};
use nom::multi::{count, length_data};
use nom::number::complete::{le_i32, le_u8, le_u16, le_u32};
use nom::sequence::preceded;
use nom::{Err, IResult, Parser};

use super::Message;

fn message(side: Side, kind: u16, data: &[u8]) -> IResult<&[u8], Message> {
    match (side, kind) {
        (Side::Host, 0x0036) => {
            map((le_u8, le_u16, le_i32), |(motor, speed, destination)| Message::Jog { motor, speed, destination })
                .parse(data)
        }
        // The length of a list is known, so that its vector is allocated once.
        (Side::Host, 0x0101) => {
            map((le_u8, le_u32, count(le_i32, data.len().saturating_sub(5) / 4)), |(motor, start_index, positions)| {
                Message::Upload { motor, start_index, positions }
            })
            .parse(data)
        }
        (Side::Device, 0x0034) => {
            map((le_i32, count(le_i32, data.len().saturating_sub(4) / 4)), |(move_time, positions)| {
                Message::Positions { move_time, positions }
            })
            .parse(data)
        }
        (Side::Device, 0x8000..) => map(le_u16, |code| Message::Ack { code }).parse(data),
        _ => Err(Err::Error(Error::new(data, ErrorKind::Switch))),
    }
}

fn frame(stream: &[u8], side: Side) -> IResult<&[u8], (u32, Message)> {
    let fields = (le_u32, le_u16, length_data(le_u16), take(2_usize));
    let (rest, (id, kind, data, _)) = preceded(tag(&b"DF"[..]), fields).parse(stream)?;
    let whole = take(stream.len() - rest.len());
    verify(whole, |bytes: &[u8]| motion_core::fletcher::verify(bytes)).parse(stream)?;
    let (_, message) = message(side, kind, data)?;
    Ok((rest, (id, message)))
}

#[inline]
pub(crate) fn read<U: Use>(stream: &[u8], side: Side) -> Option<(u32, &[u8])> {
    let (rest, (id, message)) = frame(stream, side).ok()?;
    Some((U::kept(message).sum().wrapping_add(id), rest))
}
