//! Parser with nom: its combinators, and lists as vectors.

use benches::decode::Use;
use benches::traffic::Side;
use nom::bytes::complete::{tag, take};
use nom::combinator::{fail, map, verify};
use nom::multi::{count, fill, length_data};
use nom::number::complete::{be_f32, be_u8, be_u16, be_u32};
use nom::sequence::preceded;
use nom::{IResult, Parser};

use super::message::{Block, Body, Message, Motor, Place};
use super::{MOTOR_INFO, MOTOR_POSITION, NOTIFICATION, PLAYBACK_STATUS, RESPONSE, TRAJECTORY_DATA, VERSION};

fn floats<const N: usize>(input: &[u8]) -> IResult<&[u8], [f32; N]> {
    let mut numbers = [0.0; N];
    let (rest, ()) = fill(be_f32, &mut numbers).parse(input)?;
    Ok((rest, numbers))
}

fn bytes<const N: usize>(input: &[u8]) -> IResult<&[u8], [u8; N]> {
    map(take(N), |bytes: &[u8]| *bytes.first_chunk().expect("N bytes were taken")).parse(input)
}

fn place(input: &[u8]) -> IResult<&[u8], Place> {
    map((be_u8, be_f32), |(address, position)| Place { address, position }).parse(input)
}

fn motor(input: &[u8]) -> IResult<&[u8], Motor> {
    map((be_u8, floats), |(address, [position, begin, end, setup_speed, move_speed, acceleration])| Motor {
        address,
        position,
        begin,
        end,
        setup_speed,
        move_speed,
        acceleration,
    })
    .parse(input)
}

fn segment(input: &[u8]) -> IResult<&[u8], Body> {
    map((be_u8, be_u8, floats), |(address, segment, points)| Body::Segment { address, segment, points }).parse(input)
}

fn time_lapse(input: &[u8]) -> IResult<&[u8], Body> {
    let fields = (be_f32, be_f32, be_u32, be_u8, be_u32, be_u32);
    map(fields, |(delay, exposure, photos, not_used, before, behind)| Body::TimeLapse {
        delay,
        exposure,
        photos,
        not_used,
        before,
        behind,
    })
    .parse(input)
}

fn playback(input: &[u8]) -> IResult<&[u8], Body> {
    let fields = (be_u8, floats, bytes, be_u8, be_u32, be_u8, floats, bytes, be_f32, be_u8, be_u8, be_f32);
    map(
        fields,
        |(
            mode,
            durations,
            loops,
            delay_mode,
            delay,
            camera_roll,
            roll_delays,
            flash_mark,
            flash_delay,
            trigger,
            lanc,
            home,
        )| Body::Playback {
            mode,
            durations,
            loops,
            delay_mode,
            delay,
            camera_roll,
            roll_delays,
            flash_mark,
            flash_delay,
            trigger,
            lanc,
            home,
        },
    )
    .parse(input)
}

fn block(input: &[u8]) -> IResult<&[u8], Block> {
    let (rest, (number, data)) = (be_u8, length_data(be_u16)).parse(input)?;
    let len = u16::try_from(data.len()).unwrap_or(u16::MAX);
    let (_, body) = match (number, len) {
        (6, 34) => segment(data)?,
        (5, 2) => map((be_u8, be_u8), |(address, segments)| Body::Axis { address, segments }).parse(data)?,
        (2, 21) => time_lapse(data)?,
        (1, 37) => playback(data)?,
        _ => fail().parse(data)?,
    };
    Ok((rest, Block { number, len, body }))
}

fn status(input: &[u8]) -> IResult<&[u8], Message> {
    let (rest, (state, elapsed, photos, number)) = (be_u8, be_f32, be_f32, be_u8).parse(input)?;
    let fields = |places| Message::Status { state, elapsed, photos, count: number, places };
    map(count(place, number.into()), fields).parse(rest)
}

fn message(id: u16, data: &[u8]) -> IResult<&[u8], Message> {
    let (rest, number) = be_u8(data)?;
    match (id, number) {
        (NOTIFICATION, MOTOR_POSITION) => map(place, Message::Position).parse(rest),
        (NOTIFICATION, PLAYBACK_STATUS) => status(rest),
        (MOTOR_INFO, _) => {
            map(count(motor, number.into()), |motors| Message::Infos { count: number, motors }).parse(rest)
        }
        (TRAJECTORY_DATA, _) => {
            map(count(block, number.into()), |blocks| Message::Trajectory { count: number, blocks }).parse(rest)
        }
        _ => fail().parse(rest),
    }
}

fn frame(stream: &[u8]) -> IResult<&[u8], Message> {
    let fields = (verify(be_u16, |len| *len >= 6), be_u16);
    let header = preceded(tag(&[VERSION][..]), fields);
    let (rest, ((len, id), _)) = (header, tag(&[RESPONSE][..])).parse(stream)?;
    let (rest, data) = take(len - 6).parse(rest)?;
    let (_, message) = message(id, data)?;
    Ok((rest, message))
}

#[inline]
pub(crate) fn read<U: Use>(stream: &[u8], _: Side) -> Option<(u32, &[u8])> {
    let (rest, message) = frame(stream).ok()?;
    Some((U::kept(message).sum(), rest))
}
