//! Parser with zerocopy: structs over the bytes, and borrowed lists.

use benches::decode::Use;
use benches::traffic::Side;
use zerocopy::big_endian::{F32, U16, U32};
use zerocopy::{FromBytes, Immutable, KnownLayout, Unaligned};

use super::message::total;
use super::{MOTOR_INFO, MOTOR_POSITION, NOTIFICATION, PLAYBACK_STATUS, RESPONSE, TRAJECTORY_DATA, VERSION};

#[derive(FromBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct Header {
    version: u8,
    len: U16,
    id: U16,
    kind: u8,
}

#[derive(FromBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct Place {
    address: u8,
    position: F32,
}

#[derive(FromBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct Status {
    state: u8,
    elapsed: F32,
    photos: F32,
    count: u8,
}

#[derive(FromBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct Motor {
    address: u8,
    places: [F32; 3],
    speeds: [F32; 2],
    acceleration: F32,
}

#[derive(FromBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct BlockHeader {
    number: u8,
    len: U16,
}

#[derive(FromBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct Segment {
    address: u8,
    number: u8,
    points: [F32; 8],
}

#[derive(FromBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct Axis {
    address: u8,
    segments: u8,
}

#[derive(FromBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct TimeLapse {
    times: [F32; 2],
    photos: U32,
    not_used: u8,
    around: [U32; 2],
}

#[derive(FromBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
struct Playback {
    mode: u8,
    durations: [F32; 2],
    loops: [u8; 2],
    delay_mode: u8,
    delay: U32,
    camera_roll: u8,
    roll_delays: [F32; 2],
    flash_mark: [u8; 2],
    flash_delay: F32,
    trigger: u8,
    lanc: u8,
    home: F32,
}

enum Message<'a> {
    Position(&'a Place),
    Status(&'a Status, &'a [Place]),
    Infos(u8, &'a [Motor]),
    /// Blocks with their number, which are parsed when they are iterated.
    Trajectory(u8, &'a [u8]),
}

enum Block<'a> {
    Segment(&'a Segment),
    Axis(&'a Axis),
    TimeLapse(&'a TimeLapse),
    Playback(&'a Playback),
}

fn bits(number: F32) -> u32 {
    number.get().to_bits()
}

fn floats(numbers: &[F32]) -> u32 {
    total(numbers.iter().copied().map(bits))
}

fn bytes(bytes: &[u8]) -> u32 {
    total(bytes.iter().copied().map(u32::from))
}

impl Place {
    fn sum(&self) -> u32 {
        bits(self.position).wrapping_add(self.address.into())
    }
}

impl Motor {
    fn sum(&self) -> u32 {
        total([self.address.into(), floats(&self.places), floats(&self.speeds), bits(self.acceleration)])
    }
}

impl Message<'_> {
    fn sum(&self) -> u32 {
        match *self {
            Self::Position(place) => place.sum(),
            Self::Status(status, places) => {
                let fields = [status.state.into(), bits(status.elapsed), bits(status.photos), status.count.into()];
                total(fields).wrapping_add(total(places.iter().map(Place::sum)))
            }
            Self::Infos(count, motors) => total(motors.iter().map(Motor::sum)).wrapping_add(count.into()),
            Self::Trajectory(count, mut blocks) => {
                let mut sum = u32::from(count);
                for _ in 0..count {
                    let Some((number, block, rest)) = block(blocks) else { return 0 };
                    sum = total([sum, number.into(), block.sum()]);
                    blocks = rest;
                }
                sum
            }
        }
    }
}

impl Block<'_> {
    fn sum(&self) -> u32 {
        match self {
            Self::Segment(it) => bytes(&[it.address, it.number]).wrapping_add(floats(&it.points)),
            Self::Axis(it) => bytes(&[it.address, it.segments]),
            Self::TimeLapse(it) => {
                let around = it.around.iter().map(|number| number.get());
                total([floats(&it.times), it.photos.get(), it.not_used.into(), total(around)])
            }
            Self::Playback(it) => {
                let flags = [it.mode, it.delay_mode, it.camera_roll, it.trigger, it.lanc];
                let delays =
                    total([floats(&it.durations), floats(&it.roll_delays), bits(it.flash_delay), bits(it.home)]);
                total([bytes(&flags), bytes(&it.loops), bytes(&it.flash_mark), it.delay.get(), delays])
            }
        }
    }
}

/// Splits a block from the start. Returns its number, the block and the bytes after it.
fn block(blocks: &[u8]) -> Option<(u8, Block<'_>, &[u8])> {
    let (header, rest) = BlockHeader::ref_from_prefix(blocks).ok()?;
    let (data, rest) = rest.split_at_checked(header.len.get().into())?;
    let block = match header.number {
        6 => Block::Segment(Segment::ref_from_bytes(data).ok()?),
        5 => Block::Axis(Axis::ref_from_bytes(data).ok()?),
        2 => Block::TimeLapse(TimeLapse::ref_from_bytes(data).ok()?),
        1 => Block::Playback(Playback::ref_from_bytes(data).ok()?),
        _ => return None,
    };
    Some((header.number, block, rest))
}

#[inline]
pub(crate) fn read<U: Use>(stream: &[u8], _: Side) -> Option<(u32, &[u8])> {
    let (header, _) = Header::ref_from_prefix(stream).ok()?;
    let (frame, rest) = stream.split_at_checked(header.len.get().into())?;
    let (&number, data) = frame.get(6..)?.split_first()?;
    let message = match (header.version, header.id.get(), header.kind, number) {
        (VERSION, NOTIFICATION, RESPONSE, MOTOR_POSITION) => Message::Position(Place::ref_from_prefix(data).ok()?.0),
        (VERSION, NOTIFICATION, RESPONSE, PLAYBACK_STATUS) => {
            let (status, places) = Status::ref_from_prefix(data).ok()?;
            Message::Status(status, <[Place]>::ref_from_prefix_with_elems(places, status.count.into()).ok()?.0)
        }
        (VERSION, MOTOR_INFO, RESPONSE, count) => {
            Message::Infos(count, <[Motor]>::ref_from_prefix_with_elems(data, count.into()).ok()?.0)
        }
        (VERSION, TRAJECTORY_DATA, RESPONSE, count) => Message::Trajectory(count, data),
        _ => return None,
    };
    Some((U::kept(message).sum(), rest))
}
