//! Uploads compared with a model of plain vectors, for the laws and for a fuzzer.

use dmc_proto::HostMessage;
use dmc_proto::message::{
    AckCode, DmxChannel, FrameNumber, Motor, RtUploadMoveAxis, RtUploadMoveBegin, RtUploadMoveDmx, RtUploadMoveEnd,
    RtUploadMoveTriggers, StartIndex, Steps, TriggerPair, Triggers,
};
use dmc_proto::upload::{Memory, Room, Track, UploadBuffer};
use motion_core::zerocopy::little_endian::I32;

/// Memory for an upload, followed by guard values that must not change.
#[derive(Debug)]
pub(crate) struct Memories {
    room: Room,
    positions: Vec<i32>,
    levels: Vec<u8>,
    triggers: Vec<Triggers>,
    written: Vec<u32>,
}

const GUARD: usize = 40;

impl Memories {
    /// Memory filled with values other than zero.
    pub(crate) fn new(room: Room) -> Self {
        Self {
            room,
            positions: vec![-77; room.positions() + GUARD],
            levels: vec![0x77; room.levels() + GUARD],
            triggers: vec![Triggers(0x7777_7777); room.triggers() + GUARD],
            written: vec![0x7777_7777; room.written() + GUARD],
        }
    }

    /// Buffer over this memory.
    pub(crate) fn buffer(&mut self) -> UploadBuffer<'_> {
        let memory = Memory {
            positions: &mut self.positions,
            levels: &mut self.levels,
            triggers: &mut self.triggers,
            written: &mut self.written,
        };
        UploadBuffer::new(self.room, memory).unwrap()
    }

    /// Whether the guard values after the memory are unchanged.
    fn is_intact(&self) -> bool {
        self.positions[self.room.positions()..].iter().all(|&value| value == -77)
            && self.levels[self.room.levels()..].iter().all(|&value| value == 0x77)
            && self.triggers[self.room.triggers()..].iter().all(|&value| value.0 == 0x7777_7777)
            && self.written[self.room.written()..].iter().all(|&value| value == 0x7777_7777)
    }
}

/// Message that starts an upload.
pub(crate) fn begin(start: i32, end: i32) -> HostMessage<'static> {
    let (start_frame, end_frame) = (FrameNumber(start), FrameNumber(end));
    HostMessage::from(RtUploadMoveBegin { start_frame, end_frame, tail: &[] })
}

/// Gives a section of positions to a buffer.
pub(crate) fn axis(buffer: &mut UploadBuffer<'_>, motor: u8, start: u32, values: &[i32]) -> AckCode {
    let positions: Vec<I32> = values.iter().map(|&steps| I32::new(steps)).collect();
    let (motor, start_index) = (Motor(motor), StartIndex(start));
    let section = RtUploadMoveAxis { motor, start_index, positions: &positions, tail: &[] };
    buffer.receive(&HostMessage::RtUploadMoveAxis(section)).unwrap()
}

/// Gives a section of levels to a buffer.
pub(crate) fn dmx(buffer: &mut UploadBuffer<'_>, channel: u16, start: u32, levels: &[u8]) -> AckCode {
    let (channel, start_index) = (DmxChannel(channel), StartIndex(start));
    let section = RtUploadMoveDmx { channel, start_index, levels, tail: &[] };
    buffer.receive(&HostMessage::RtUploadMoveDmx(section)).unwrap()
}

/// Gives a section of triggers to a buffer.
pub(crate) fn triggers(buffer: &mut UploadBuffer<'_>, mask: u32, pairs: &[(u32, u32)]) -> AckCode {
    let pairs: Vec<_> = pairs.iter().map(|&(frame, values)| TriggerPair::new(frame, Triggers(values))).collect();
    let section = RtUploadMoveTriggers { mask: Triggers(mask), pairs: &pairs, tail: &[] };
    buffer.receive(&HostMessage::RtUploadMoveTriggers(section)).unwrap()
}

/// Expected content of a buffer, in vectors. `None` is a value that did not arrive.
#[derive(Default)]
struct Model {
    state: &'static str,
    axes: Vec<Vec<Option<i32>>>,
    channels: Vec<Vec<Option<u8>>>,
    mask: u32,
    triggers: Vec<u32>,
}

impl Model {
    fn begin(&mut self, room: Room, start: i32, end: i32) -> AckCode {
        let count = i64::from(end) - i64::from(start) + 1;
        if count < 1 || count > i64::from(room.frames) {
            return AckCode::ERR_RANGE;
        }
        let count = usize::try_from(count).unwrap();
        *self = Self {
            state: "loading",
            axes: vec![vec![None; count]; room.motors.into()],
            channels: vec![vec![None; count]; room.channels.into()],
            mask: 0,
            triggers: vec![0; count],
        };
        AckCode::OK
    }

    fn switch(&mut self, mask: u32, pairs: &[(u32, u32)]) -> AckCode {
        if self.state != "loading" {
            return AckCode::ERR_GENERAL;
        }
        if pairs.iter().any(|&(frame, _)| frame as usize >= self.triggers.len()) {
            return AckCode::ERR_RANGE;
        }
        self.mask = mask;
        for &(frame, values) in pairs {
            self.triggers[frame as usize] = values;
        }
        AckCode::OK
    }

    fn end(&mut self) {
        if self.state == "loading" {
            self.state = "loaded";
        }
    }
}

/// Stores a section in its track.
fn store<T: Copy>(state: &str, tracks: &mut [Vec<Option<T>>], number: u16, start: u32, values: &[T]) -> AckCode {
    if state != "loading" {
        return AckCode::ERR_GENERAL;
    }
    let Some(track) = usize::from(number).checked_sub(1).and_then(|row| tracks.get_mut(row)) else {
        return AckCode::ERR_RANGE;
    };
    let from = (start & 0x7fff_ffff) as usize;
    let end = from + values.len();
    if end > track.len() {
        return AckCode::ERR_RANGE;
    }
    for (place, &value) in track[from..].iter_mut().zip(values) {
        *place = Some(value);
    }
    if start >= 0x8000_0000 {
        let held = track[..end].iter().rev().find_map(|value| *value);
        if held.is_some() {
            track[end..].fill(held);
        }
    }
    AckCode::OK
}

/// Value of a frame: its own, or the one before it, or the first one.
fn held<T: Copy>(track: &[Option<T>], index: usize) -> Option<T> {
    let at = track.get(index).map(|_| &track[..=index])?;
    at.iter().rev().chain(track).find_map(|value| *value)
}

fn agree(buffer: &UploadBuffer<'_>, model: &Model) {
    let count = model.triggers.len();
    assert_eq!((buffer.frame_count() as usize, buffer.is_loaded()), (count, model.state == "loaded"));
    assert_eq!(buffer.mask().0, model.mask);
    for (axis, number) in model.axes.iter().zip(1..) {
        let track = Track::Axis(Motor(number));
        assert_eq!(buffer.contains(track), axis.iter().any(Option::is_some));
        let gaps: Vec<_> = buffer.gaps(track).flatten().collect();
        let wanted: Vec<_> = (0_u32..).zip(axis).filter(|(_, value)| value.is_none()).map(|(index, _)| index).collect();
        assert_eq!(gaps, wanted, "gaps of motor {number}");
    }
    for index in 0..count + 2 {
        let at = u32::try_from(index).unwrap();
        let loaded = buffer.is_loaded();
        for (axis, number) in model.axes.iter().zip(1..) {
            let wanted = held(axis, index).filter(|_| loaded).map(Steps);
            assert_eq!(buffer.position(Motor(number), at), wanted, "motor {number} at {index}");
        }
        for (channel, number) in model.channels.iter().zip(1..) {
            let wanted = held(channel, index).filter(|_| loaded);
            assert_eq!(buffer.level(DmxChannel(number), at), wanted, "channel {number} at {index}");
        }
        let wanted = model.triggers.get(index).filter(|_| loaded).map_or(0, |values| values & model.mask);
        assert_eq!(buffer.triggers(at).0, wanted, "triggers at {index}");
    }
}

/// Reads bytes as a sequence of messages, gives them to a buffer and to the model, and compares the two.
///
/// # Panics
///
/// If they differ, or if something was written outside the memory.
pub(crate) fn hostile(input: &[u8]) {
    let room = Room { motors: 3, channels: 2, frames: 40 };
    let mut memories = Memories::new(room);
    let mut buffer = memories.buffer();
    let mut model = Model::default();
    let mut bytes = input.iter().copied();
    let mut next = || bytes.next();
    while let Some(kind) = next() {
        let mut byte = || next().unwrap_or(0);
        // Indices near the start, near the end of the room, or anywhere.
        let start = match byte() {
            near @ 0..=100 => u32::from(near % 50),
            near @ 101..=200 => 0x8000_0000 | u32::from(near % 50),
            _ => u32::from_le_bytes([byte(), byte(), byte(), byte()]),
        };
        match kind % 16 {
            0 => {
                let (from, to) = (i32::from(byte() % 8), i32::from(byte() % 64));
                let (from, to) = if byte() < 250 { (from, to) } else { (from + i32::MIN, to + (i32::MAX - 63)) };
                assert_eq!(buffer.receive(&begin(from, to)), Some(model.begin(room, from, to)), "{from} to {to}");
            }
            1 => {
                assert_eq!(buffer.receive(&RtUploadMoveEnd::default().into()), Some(AckCode::OK));
                model.end();
            }
            2..=8 => {
                let motor = byte() % 6;
                let values: Vec<i32> = (0..byte() % 12).map(|_| byte().into()).collect();
                let code = store(model.state, &mut model.axes, motor.into(), start, &values);
                assert_eq!(axis(&mut buffer, motor, start, &values), code, "motor {motor} from {start:x}: {values:?}");
            }
            9..=12 => {
                let channel = u16::from(byte() % 5);
                let values: Vec<u8> = (0..byte() % 12).map(|_| byte()).collect();
                let code = store(model.state, &mut model.channels, channel, start, &values);
                assert_eq!(dmx(&mut buffer, channel, start, &values), code, "channel {channel}: {values:?}");
            }
            _ => {
                let mask = byte().into();
                let mut pairs: Vec<(u32, u32)> =
                    (0..byte() % 5).map(|_| ((byte() % 44).into(), byte().into())).collect();
                if byte() > 240 {
                    pairs.push((start, 1));
                }
                assert_eq!(triggers(&mut buffer, mask, &pairs), model.switch(mask, &pairs), "{pairs:?}");
            }
        }
        agree(&buffer, &model);
    }
    buffer.receive(&RtUploadMoveEnd::default().into());
    model.end();
    agree(&buffer, &model);
    assert!(memories.is_intact(), "written outside the memory");
}
