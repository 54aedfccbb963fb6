//! Parsers of DMC with other libraries: the four messages of the mixes, each parser as its documentation recommends.
//!
//! All parsers verify the checksum with our function, before they read the data.

pub(crate) mod binrw;
pub(crate) mod deku;
pub(crate) mod nom;
pub(crate) mod winnow;
pub(crate) mod zerocopy;

use benches::decode::{LIMIT, Read, Use, ours, read, touch};
use benches::traffic::Side;
use dmc_proto::Dmc;
use motion_core::fletcher::verify;

benches::readers!("dmc-proto", Dmc);

#[inline]
fn limit(stream: &[u8], _: Side) -> Option<(u32, &[u8])> {
    touch(stream, usize::from(u16::from_le_bytes([*stream.get(8)?, *stream.get(9)?])) + 12)
}

/// Message of the mixes that owns its lists.
pub(crate) enum Message {
    Jog { motor: u8, speed: u16, destination: i32 },
    Upload { motor: u8, start_index: u32, positions: Vec<i32> },
    Positions { move_time: i32, positions: Vec<i32> },
    Ack { code: u16 },
}

impl Message {
    /// Sum of all fields.
    pub(crate) fn sum(&self) -> u32 {
        match self {
            Self::Jog { motor, speed, destination } => {
                total([(*motor).into(), (*speed).into(), destination.cast_unsigned()])
            }
            Self::Upload { motor, start_index, positions } => total([(*motor).into(), *start_index, steps(positions)]),
            Self::Positions { move_time, positions } => move_time.cast_unsigned().wrapping_add(steps(positions)),
            Self::Ack { code } => (*code).into(),
        }
    }
}

fn total(numbers: impl IntoIterator<Item = u32>) -> u32 {
    numbers.into_iter().fold(0, u32::wrapping_add)
}

fn steps(positions: &[i32]) -> u32 {
    total(positions.iter().map(|steps| steps.cast_unsigned()))
}

/// Splits a valid frame of `len` bytes from the start. Returns the frame and the bytes after it.
fn sound(stream: &[u8], len: usize) -> Option<(&[u8], &[u8])> {
    stream.split_at_checked(len).filter(|(frame, _)| verify(frame))
}

/// Length of the frame at the start, for parsers that do not find it themselves before the checksum is verified.
fn frame_len(stream: &[u8]) -> Option<usize> {
    let [b'D', b'F', _, _, _, _, _, _, low, high, ..] = stream else { return None };
    Some(usize::from(u16::from_le_bytes([*low, *high])) + 12)
}
