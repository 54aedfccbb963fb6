//! Parser with winnow: its combinators, and lists as vectors.

use benches::decode::Use;
use benches::traffic::Side;
use winnow::binary::{be_f32, be_u8, be_u16, be_u32, length_take};
use winnow::combinator::{fail, repeat, seq};
use winnow::token::take;
use winnow::{ModalResult, Parser};

use super::message::{Block, Body, Message, Motor, Place};
use super::{MOTOR_INFO, MOTOR_POSITION, NOTIFICATION, PLAYBACK_STATUS, RESPONSE, TRAJECTORY_DATA, VERSION};

fn place(input: &mut &[u8]) -> ModalResult<Place> {
    seq! { Place { address: be_u8, position: be_f32 } }.parse_next(input)
}

fn motor(input: &mut &[u8]) -> ModalResult<Motor> {
    seq! { Motor {
        address: be_u8,
        position: be_f32,
        begin: be_f32,
        end: be_f32,
        setup_speed: be_f32,
        move_speed: be_f32,
        acceleration: be_f32,
    } }
    .parse_next(input)
}

fn points(input: &mut &[u8]) -> ModalResult<[f32; 8]> {
    let mut points = [0.0; 8];
    for number in &mut points {
        *number = be_f32.parse_next(input)?;
    }
    Ok(points)
}

fn floats(input: &mut &[u8]) -> ModalResult<[f32; 2]> {
    (be_f32, be_f32).map(<[f32; 2]>::from).parse_next(input)
}

fn bytes(input: &mut &[u8]) -> ModalResult<[u8; 2]> {
    (be_u8, be_u8).map(<[u8; 2]>::from).parse_next(input)
}

fn playback(input: &mut &[u8]) -> ModalResult<Body> {
    seq! { Body::Playback {
        mode: be_u8,
        durations: floats,
        loops: bytes,
        delay_mode: be_u8,
        delay: be_u32,
        camera_roll: be_u8,
        roll_delays: floats,
        flash_mark: bytes,
        flash_delay: be_f32,
        trigger: be_u8,
        lanc: be_u8,
        home: be_f32,
    } }
    .parse_next(input)
}

fn block(input: &mut &[u8]) -> ModalResult<Block> {
    let (number, mut data) = (be_u8, length_take(be_u16)).parse_next(input)?;
    let len = u16::try_from(data.len()).unwrap_or(u16::MAX);
    let data = &mut data;
    let body = match (number, len) {
        (6, 34) => seq! { Body::Segment { address: be_u8, segment: be_u8, points: points } }.parse_next(data)?,
        (5, 2) => seq! { Body::Axis { address: be_u8, segments: be_u8 } }.parse_next(data)?,
        (2, 21) => seq! { Body::TimeLapse {
            delay: be_f32, exposure: be_f32, photos: be_u32, not_used: be_u8, before: be_u32, behind: be_u32,
        } }
        .parse_next(data)?,
        (1, 37) => playback(data)?,
        _ => fail.parse_next(data)?,
    };
    Ok(Block { number, len, body })
}

fn message(id: u16, data: &mut &[u8]) -> ModalResult<Message> {
    let number = be_u8.parse_next(data)?;
    let times = usize::from(number);
    match (id, number) {
        (NOTIFICATION, MOTOR_POSITION) => place.map(Message::Position).parse_next(data),
        (NOTIFICATION, PLAYBACK_STATUS) => {
            let (state, elapsed, photos, count) = (be_u8, be_f32, be_f32, be_u8).parse_next(data)?;
            repeat(usize::from(count), place)
                .map(|places| Message::Status { state, elapsed, photos, count, places })
                .parse_next(data)
        }
        (MOTOR_INFO, count) => repeat(times, motor).map(|motors| Message::Infos { count, motors }).parse_next(data),
        (TRAJECTORY_DATA, count) => {
            repeat(times, block).map(|blocks| Message::Trajectory { count, blocks }).parse_next(data)
        }
        _ => fail.parse_next(data),
    }
}

fn frame(stream: &mut &[u8]) -> ModalResult<Message> {
    let (_, len, id, _) = (VERSION, be_u16.verify(|len| *len >= 6), be_u16, RESPONSE).parse_next(stream)?;
    let mut data = take(len - 6).parse_next(stream)?;
    message(id, &mut data)
}

#[inline]
pub(crate) fn read<U: Use>(mut stream: &[u8], _: Side) -> Option<(u32, &[u8])> {
    let message = frame(&mut stream).ok()?;
    Some((U::kept(message).sum(), stream))
}
