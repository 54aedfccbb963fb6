//! Messages of the mixes as values, which are read by derive macros or made by hand.

use binrw::BinRead;
use deku::prelude::*;

use super::{MOTOR_INFO, MOTOR_POSITION, NOTIFICATION, PLAYBACK_STATUS, RESPONSE, TRAJECTORY_DATA};

/// Message of the mixes that owns its lists, with their counts.
#[derive(BinRead, DekuRead)]
#[br(big, return_unexpected_error, import(id: u16, kind: u8))]
#[deku(
    endian = "endian",
    ctx = "endian: deku::ctx::Endian, id: u16, kind: u8, note: Option<u8>",
    id = "(id, kind, note)"
)]
pub(super) enum Message {
    #[br(pre_assert((id, kind) == (NOTIFICATION, RESPONSE)), magic = 7_u8)]
    #[deku(id_pat = "(NOTIFICATION, RESPONSE, Some(MOTOR_POSITION))")]
    Position(Place),
    #[br(pre_assert((id, kind) == (NOTIFICATION, RESPONSE)), magic = 2_u8)]
    #[deku(id_pat = "(NOTIFICATION, RESPONSE, Some(PLAYBACK_STATUS))")]
    Status {
        state: u8,
        elapsed: f32,
        photos: f32,
        count: u8,
        #[br(count = count)]
        #[deku(count = "count")]
        places: Vec<Place>,
    },
    #[br(pre_assert((id, kind) == (MOTOR_INFO, RESPONSE)))]
    #[deku(id_pat = "(MOTOR_INFO, RESPONSE, None)")]
    Infos {
        count: u8,
        #[br(count = count)]
        #[deku(count = "count")]
        motors: Vec<Motor>,
    },
    #[br(pre_assert((id, kind) == (TRAJECTORY_DATA, RESPONSE)))]
    #[deku(id_pat = "(TRAJECTORY_DATA, RESPONSE, None)")]
    Trajectory {
        count: u8,
        #[br(count = count)]
        #[deku(count = "count")]
        blocks: Vec<Block>,
    },
}

/// Position of a motor.
#[derive(BinRead, DekuRead)]
#[deku(endian = "endian", ctx = "endian: deku::ctx::Endian")]
pub(super) struct Place {
    pub(super) address: u8,
    pub(super) position: f32,
}

/// Position, range and speeds of a motor.
#[derive(BinRead, DekuRead)]
#[deku(endian = "endian", ctx = "endian: deku::ctx::Endian")]
pub(super) struct Motor {
    pub(super) address: u8,
    pub(super) position: f32,
    pub(super) begin: f32,
    pub(super) end: f32,
    pub(super) setup_speed: f32,
    pub(super) move_speed: f32,
    pub(super) acceleration: f32,
}

/// Block of a move.
#[derive(BinRead, DekuRead)]
#[expect(dead_code, reason = "the length is read to reach the body")]
#[deku(endian = "endian", ctx = "endian: deku::ctx::Endian")]
pub(super) struct Block {
    pub(super) number: u8,
    pub(super) len: u16,
    #[br(args(number, len))]
    #[deku(ctx = "*number, *len")]
    pub(super) body: Body,
}

#[derive(BinRead, DekuRead)]
#[br(return_unexpected_error, import(number: u8, len: u16))]
#[deku(endian = "endian", ctx = "endian: deku::ctx::Endian, number: u8, len: u16", id = "(number, len)")]
pub(super) enum Body {
    #[br(pre_assert((number, len) == (6, 34)))]
    #[deku(id_pat = "(6, 34)")]
    Segment { address: u8, segment: u8, points: [f32; 8] },
    #[br(pre_assert((number, len) == (5, 2)))]
    #[deku(id_pat = "(5, 2)")]
    Axis { address: u8, segments: u8 },
    #[br(pre_assert((number, len) == (2, 21)))]
    #[deku(id_pat = "(2, 21)")]
    TimeLapse { delay: f32, exposure: f32, photos: u32, not_used: u8, before: u32, behind: u32 },
    #[br(pre_assert((number, len) == (1, 37)))]
    #[deku(id_pat = "(1, 37)")]
    Playback {
        mode: u8,
        durations: [f32; 2],
        loops: [u8; 2],
        delay_mode: u8,
        delay: u32,
        camera_roll: u8,
        roll_delays: [f32; 2],
        flash_mark: [u8; 2],
        flash_delay: f32,
        trigger: u8,
        lanc: u8,
        home: f32,
    },
}

impl Message {
    /// Sum of all fields.
    pub(super) fn sum(&self) -> u32 {
        match self {
            Self::Position(place) => place.sum(),
            Self::Status { state, elapsed, photos, count, places } => {
                let fields = [(*state).into(), elapsed.to_bits(), photos.to_bits(), (*count).into()];
                total(fields).wrapping_add(total(places.iter().map(Place::sum)))
            }
            Self::Infos { count, motors } => total(motors.iter().map(Motor::sum)).wrapping_add((*count).into()),
            Self::Trajectory { count, blocks } => total(blocks.iter().map(Block::sum)).wrapping_add((*count).into()),
        }
    }
}

impl Place {
    pub(super) fn sum(&self) -> u32 {
        self.position.to_bits().wrapping_add(self.address.into())
    }
}

impl Motor {
    pub(super) fn sum(&self) -> u32 {
        let Self { address, position, begin, end, setup_speed, move_speed, acceleration } = *self;
        floats([position, begin, end, setup_speed, move_speed, acceleration]).wrapping_add(address.into())
    }
}

impl Block {
    pub(super) fn sum(&self) -> u32 {
        let fields = match self.body {
            Body::Segment { address, segment, points } => total([address.into(), segment.into(), floats(points)]),
            Body::Axis { address, segments } => total([address.into(), segments.into()]),
            Body::TimeLapse { delay, exposure, photos, not_used, before, behind } => {
                total([floats([delay, exposure]), photos, not_used.into(), before, behind])
            }
            Body::Playback {
                mode,
                durations: [forth, back],
                loops: [after_rapid, after],
                delay_mode,
                delay,
                camera_roll,
                roll_delays: [pre, post],
                flash_mark: [flash, flash_type],
                flash_delay,
                trigger,
                lanc,
                home,
            } => {
                let bytes = [mode, after_rapid, after, delay_mode, camera_roll, flash, flash_type, trigger, lanc];
                total([total(bytes.map(u32::from)), delay, floats([forth, back, pre, post, flash_delay, home])])
            }
        };
        fields.wrapping_add(self.number.into())
    }
}

fn floats<const N: usize>(numbers: [f32; N]) -> u32 {
    total(numbers.map(f32::to_bits))
}

pub(super) fn total(numbers: impl IntoIterator<Item = u32>) -> u32 {
    numbers.into_iter().fold(0, u32::wrapping_add)
}
