//! Parsers of hoot with other libraries: the four messages of the mix, each parser as its documentation recommends.
//!
//! All parsers check the break, the length and the address of a packet. In a position they check the type of the value.

use benches::decode::{LIMIT, Read, Use, frame, read, touch};
use benches::traffic::{Side, through_query};
use hoot_proto::Hoot;

const BREAK: [u8; 6] = [0, 0, 0, 0, 0, 0xFF];
/// Type of a value that is a signed number of 32 bits.
const LONG: u8 = 3;

/// Contenders for frames in one slice.
pub(crate) fn readers<U: Use>() -> [(&'static str, Read); 5] {
    [
        ("hoot-proto", |mix| read(mix, |stream, side| frame::<Hoot>(stream, |frame| through_query::<U>(side, frame)))),
        (LIMIT, |mix| read(mix, limit)),
        ("zerocopy", |mix| read(mix, zerocopy::read::<U>)),
        ("nom", |mix| read(mix, nom::read::<U>)),
        ("binrw", |mix| read(mix, binrw::read::<U>)),
    ]
}

#[inline]
fn limit(stream: &[u8], _: Side) -> Option<(u32, &[u8])> {
    touch(stream, usize::from(*stream.get(9)?) + 10)
}

/// Message of the mix, with copied values.
enum Message {
    Move { motor: u8, direction: u8, steps: u32 },
    Query { motor: u8 },
    Position { code: u8, steps: i32 },
    Ack { code: u8 },
}

impl Message {
    /// Sum of all fields and of the type of the value.
    fn sum(&self) -> u32 {
        match *self {
            Self::Move { motor, direction, steps } => total([motor.into(), direction.into(), steps]),
            Self::Query { motor } => motor.into(),
            Self::Position { code, steps } => total([code.into(), LONG.into(), steps.cast_unsigned()]),
            Self::Ack { code } => code.into(),
        }
    }
}

fn total(numbers: [u32; 3]) -> u32 {
    numbers.into_iter().fold(0, u32::wrapping_add)
}

/// Parser with zerocopy: structs over the bytes.
pub(crate) mod zerocopy {
    use benches::decode::Use;
    use benches::traffic::Side;
    use zerocopy::big_endian::{I32, U32};
    use zerocopy::{FromBytes, Immutable, KnownLayout, Unaligned};

    use super::{BREAK, LONG, Message};

    #[derive(FromBytes, Immutable, KnownLayout, Unaligned)]
    #[repr(C)]
    struct Header {
        marker: [u8; 6],
        address: u8,
        sub_address: u8,
        command: u8,
        len: u8,
    }

    #[derive(FromBytes, Immutable, KnownLayout, Unaligned)]
    #[repr(C)]
    struct Move {
        direction: u8,
        steps: U32,
    }

    #[derive(FromBytes, Immutable, KnownLayout, Unaligned)]
    #[repr(C)]
    struct Position {
        value_type: u8,
        steps: I32,
    }

    #[inline]
    pub(crate) fn read<U: Use>(stream: &[u8], side: Side) -> Option<(u32, &[u8])> {
        let (header, rest) = Header::ref_from_prefix(stream).ok().filter(|(header, _)| header.marker == BREAK)?;
        let (data, rest) = rest.split_at_checked(header.len.into())?;
        let message = match (side, header.address, header.sub_address, header.command) {
            (Side::Host, 2.., motor @ 1..=3, 15) => {
                let Move { direction, steps } = Move::ref_from_bytes(data).ok()?;
                Message::Move { motor, direction: *direction, steps: steps.get() }
            }
            (Side::Host, 2.., motor @ 1..=3, 106) if data.is_empty() => Message::Query { motor },
            (Side::Device, 0, 0, code) if data.is_empty() => Message::Ack { code },
            (Side::Device, 0, 0, code) => {
                let position = Position::ref_from_bytes(data).ok().filter(|position| position.value_type == LONG)?;
                Message::Position { code, steps: position.steps.get() }
            }
            _ => return None,
        };
        Some((U::kept(message).sum(), rest))
    }
}

/// Parser with nom: its combinators.
pub(crate) mod nom {
    use benches::decode::Use;
    use benches::traffic::Side;
    use nom::bytes::complete::tag;
    use nom::combinator::{all_consuming, eof, map};
    use nom::error::{Error, ErrorKind};
    use nom::multi::length_data;
    use nom::number::complete::{be_i32, be_u8, be_u32};
    use nom::sequence::preceded;
    use nom::{Err, IResult, Parser};

    use super::{BREAK, LONG, Message};

    fn message(side: Side, [address, sub_address, command]: [u8; 3], data: &[u8]) -> IResult<&[u8], Message> {
        match (side, address, sub_address, command) {
            (Side::Host, 2.., motor @ 1..=3, 15) => {
                let fields = map((be_u8, be_u32), |(direction, steps)| Message::Move { motor, direction, steps });
                all_consuming(fields).parse(data)
            }
            (Side::Host, 2.., motor @ 1..=3, 106) => map(eof, |_| Message::Query { motor }).parse(data),
            (Side::Device, 0, 0, code) if data.is_empty() => Ok((data, Message::Ack { code })),
            (Side::Device, 0, 0, code) => {
                let steps = map(be_i32, |steps| Message::Position { code, steps });
                all_consuming(preceded(tag(&[LONG][..]), steps)).parse(data)
            }
            _ => Err(Err::Error(Error::new(data, ErrorKind::Switch))),
        }
    }

    fn frame(stream: &[u8], side: Side) -> IResult<&[u8], Message> {
        let fields = (be_u8, be_u8, be_u8, length_data(be_u8));
        let (rest, (address, sub_address, command, data)) = preceded(tag(&BREAK[..]), fields).parse(stream)?;
        let (_, message) = message(side, [address, sub_address, command], data)?;
        Ok((rest, message))
    }

    #[inline]
    pub(crate) fn read<U: Use>(stream: &[u8], side: Side) -> Option<(u32, &[u8])> {
        let (rest, message) = frame(stream, side).ok()?;
        Some((U::kept(message).sum(), rest))
    }
}

/// Parser with binrw: its derive macros, and no list of errors, which would take 1.5 times as long.
pub(crate) mod binrw {
    use std::io::Cursor;

    use benches::decode::Use;
    use benches::traffic::Side;
    use binrw::BinRead;

    use super::Message;

    #[derive(BinRead)]
    #[expect(dead_code, reason = "read to reach the body")]
    #[br(big, magic = b"\0\0\0\0\0\xFF", import(side: Side))]
    struct Frame {
        address: u8,
        sub_address: u8,
        command: u8,
        len: u8,
        #[br(args((side, address, sub_address, command, len)))]
        body: Body,
    }

    #[derive(BinRead)]
    #[br(big, return_unexpected_error, import(kind: (Side, u8, u8, u8, u8)))]
    enum Body {
        #[br(pre_assert(matches!(kind, (Side::Device, 0, 0, _, 0))))]
        Ack,
        #[br(pre_assert(matches!(kind, (Side::Device, 0, 0, _, 5))), magic = 3_u8)]
        Position { steps: i32 },
        #[br(pre_assert(matches!(kind, (Side::Host, 2.., 1..=3, 106, 0))))]
        Query,
        #[br(pre_assert(matches!(kind, (Side::Host, 2.., 1..=3, 15, 5))))]
        Move { direction: u8, steps: u32 },
    }

    impl From<Frame> for Message {
        fn from(Frame { sub_address: motor, command: code, body, .. }: Frame) -> Self {
            match body {
                Body::Move { direction, steps } => Self::Move { motor, direction, steps },
                Body::Query => Self::Query { motor },
                Body::Position { steps } => Self::Position { code, steps },
                Body::Ack => Self::Ack { code },
            }
        }
    }

    #[inline]
    pub(crate) fn read<U: Use>(stream: &[u8], side: Side) -> Option<(u32, &[u8])> {
        let mut cursor = Cursor::new(stream);
        let message = Message::from(Frame::read_args(&mut cursor, (side,)).ok()?);
        Some((U::kept(message).sum(), stream.get(usize::try_from(cursor.position()).ok()?..)?))
    }
}
