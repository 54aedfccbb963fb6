//! Assembly of a move from sections, in memory of the caller.

use core::fmt;

use zerocopy::little_endian::I32;
use zerocopy::{FromBytes as _, IntoBytes as _};

use super::Track;
use super::rows::{Gaps, Rows, words};
use crate::message::{
    AckCode, DmxChannel, FrameNumber, HostMessage, Motor, RtUploadMoveBegin, RtUploadMoveTriggers, StartIndex, Steps,
    Triggers,
};

/// Capacity of a device for a move, as it says in its greeting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Room {
    /// Number of motors, at most 32.
    pub motors: u8,
    /// Number of DMX channels, at most 512.
    pub channels: u16,
    /// Number of frames.
    pub frames: u32,
}

impl Room {
    /// Number of positions to store: one for each frame of each motor.
    #[must_use]
    pub const fn positions(self) -> usize {
        self.frames().saturating_mul(self.motors as usize)
    }

    /// Number of levels to store: one for each frame of each channel.
    #[must_use]
    pub const fn levels(self) -> usize {
        self.frames().saturating_mul(self.channels as usize)
    }

    /// Number of output sets to store: one for each frame.
    #[must_use]
    pub const fn triggers(self) -> usize {
        self.frames()
    }

    /// Number of 32-bit words that record which values arrived. A track has one bit for each frame and one bit more,
    /// rounded up to whole words.
    #[must_use]
    pub const fn written(self) -> usize {
        let tracks = (self.motors as usize).saturating_add(self.channels as usize);
        words(self.frames()).saturating_mul(tracks)
    }

    const fn frames(self) -> usize {
        self.frames as usize
    }
}

/// Memory for a move. Each slice has at least the length that [`Room`] says. Its contents are for the buffer alone.
#[derive(Debug)]
pub struct Memory<'m> {
    /// Positions, in steps; length [`Room::positions`].
    pub positions: &'m mut [i32],
    /// Levels; length [`Room::levels`].
    pub levels: &'m mut [u8],
    /// Output sets; length [`Room::triggers`], or empty for a device that switches no outputs.
    pub triggers: &'m mut [Triggers],
    /// Record of the values that arrived; length [`Room::written`].
    pub written: &'m mut [u32],
}

/// Error about a slice that is too short.
#[derive(Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[error("{what}: need {needed}, have {have}")]
#[non_exhaustive]
pub struct RoomError {
    /// Name of the slice.
    pub what: &'static str,
    /// Length that is needed.
    pub needed: usize,
    /// Length that it has.
    pub have: usize,
}

// A derived `Debug` would print `what` with escapes, which cannot be proven free of panics.
impl fmt::Debug for RoomError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "RoomError({self})")
    }
}

/// Move of a device, while it is uploaded and while it runs.
///
/// The buffer stores only values within the move. It refuses any other motor, channel or index. If a value arrives
/// twice, the later one counts. Until the end of the upload, nothing is read from it.
#[derive(Debug)]
pub struct UploadBuffer<'m> {
    room: Room,
    axes: Rows<'m>,
    channels: Rows<'m>,
    triggers: &'m mut [Triggers],
    mask: Triggers,
    mask_changed: bool,
    state: State,
    start_frame: FrameNumber,
    /// Number of frames of the move.
    count: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Empty,
    Loading,
    Loaded,
}

/// Success, or the code of a refusal.
type Stored = Result<(), AckCode>;

impl<'m> UploadBuffer<'m> {
    /// Makes a buffer over memory with any content.
    ///
    /// # Errors
    ///
    /// [`RoomError`] if a slice is shorter than `room` requires.
    pub fn new(room: Room, memory: Memory<'m>) -> Result<Self, RoomError> {
        let Memory { positions, levels, triggers, written } = memory;
        let positions = enough("positions", room.positions(), positions)?;
        let levels = enough("levels", room.levels(), levels)?;
        let triggers = if triggers.is_empty() { triggers } else { enough("triggers", room.triggers(), triggers)? };
        let written = enough("written", room.written(), written)?;
        let of_axes = words(room.frames()).saturating_mul(room.motors.into());
        let (of_axes, of_channels) = written.split_at_mut_checked(of_axes).unwrap_or_default();
        Ok(Self {
            room,
            axes: Rows::new(positions.as_mut_bytes(), of_axes, size_of::<I32>(), room.frames()),
            channels: Rows::new(levels, of_channels, 1, room.frames()),
            triggers,
            mask: Triggers::NONE,
            mask_changed: false,
            state: State::Empty,
            start_frame: FrameNumber(0),
            count: 0,
        })
    }

    /// Takes a message of an upload and returns the code to answer. For any other message it does nothing and returns
    /// `None`.
    ///
    /// `ERR_RANGE` means a motor, channel, index or frame beyond the capacity. `ERR_GENERAL` means a section outside an
    /// upload. `ERR_UNSUPPORTED` means triggers without memory for them. A message is refused as a whole. Whether the
    /// device may take an upload now depends on its state, which this buffer does not know (safety decision 7).
    pub fn receive(&mut self, message: &HostMessage<'_>) -> Option<AckCode> {
        let stored = match message {
            HostMessage::RtUploadMoveBegin(begin) => self.begin(begin),
            HostMessage::RtUploadMoveAxis(section) => self.loading().and_then(|count| {
                let (start, positions) = (section.start_index, section.positions);
                store(&mut self.axes, count, section.motor.0.into(), start, positions.len(), positions.as_bytes())
            }),
            HostMessage::RtUploadMoveDmx(section) => self.loading().and_then(|count| {
                let (start, levels) = (section.start_index, section.levels);
                store(&mut self.channels, count, section.channel.0, start, levels.len(), levels)
            }),
            HostMessage::RtUploadMoveTriggers(section) => self.loading().and_then(|_| self.switch(section)),
            HostMessage::RtUploadMoveEnd(_) => {
                self.end();
                Ok(())
            }
            _ => return None,
        };
        Some(stored.err().unwrap_or(AckCode::OK))
    }

    /// Starts an upload (decision D-31).
    fn begin(&mut self, begin: &RtUploadMoveBegin<'_>) -> Stored {
        let count = i64::from(begin.end_frame.0).wrapping_sub(begin.start_frame.0.into()).wrapping_add(1);
        if !(1..=self.room.frames.into()).contains(&count) {
            return Err(AckCode::ERR_RANGE);
        }
        self.axes.clear();
        self.channels.clear();
        self.triggers.fill(Triggers::NONE);
        (self.mask, self.mask_changed) = (Triggers::NONE, false);
        self.start_frame = begin.start_frame;
        self.count = usize::try_from(count).map_err(|_| AckCode::ERR_RANGE)?;
        self.state = State::Loading;
        Ok(())
    }

    /// Number of frames of the move that is being uploaded.
    fn loading(&self) -> Result<usize, AckCode> {
        if self.state == State::Loading { Ok(self.count) } else { Err(AckCode::ERR_GENERAL) }
    }

    /// Stores a section of triggers (decision D-33).
    fn switch(&mut self, section: &RtUploadMoveTriggers<'_>) -> Stored {
        if self.triggers.is_empty() {
            return Err(AckCode::ERR_UNSUPPORTED);
        }
        let frames = self.triggers.get_mut(..self.count).ok_or(AckCode::ERR_RANGE)?;
        let place = |frame: u32| usize::try_from(frame).unwrap_or(usize::MAX);
        if section.pairs.iter().any(|pair| place(pair.frame()) >= frames.len()) {
            return Err(AckCode::ERR_RANGE);
        }
        for pair in section.pairs {
            if let Some(frame) = frames.get_mut(place(pair.frame())) {
                *frame = pair.values();
            }
        }
        self.mask_changed |= ![Triggers::NONE, section.mask].contains(&self.mask);
        self.mask = section.mask;
        Ok(())
    }

    /// Gives every frame a value, so that running the move only reads them.
    fn end(&mut self) {
        if self.state == State::Loading {
            self.axes.fill(self.count);
            self.channels.fill(self.count);
            self.state = State::Loaded;
        }
    }

    /// Forgets the move.
    pub fn clear(&mut self) {
        (self.state, self.count) = (State::Empty, 0);
    }

    /// Whether there is a complete move.
    #[must_use]
    pub fn is_loaded(&self) -> bool {
        self.state == State::Loaded
    }

    /// Capacity of the buffer.
    #[must_use]
    pub const fn room(&self) -> Room {
        self.room
    }

    /// Number of frames of the move; 0 if there is no move.
    #[must_use]
    pub fn frame_count(&self) -> u32 {
        u32::try_from(self.count).unwrap_or(u32::MAX)
    }

    /// Index of a frame of the move, from 0; `None` outside the move.
    #[must_use]
    pub fn index(&self, frame: FrameNumber) -> Option<u32> {
        let index = i64::from(frame.0).wrapping_sub(self.start_frame.0.into());
        u32::try_from(index).ok().filter(|&index| index < self.frame_count())
    }

    /// Whether anything arrived for a track. A track without data is not part of the move, and its motor does not move
    /// (safety decision 5).
    #[must_use]
    pub fn contains(&self, track: Track) -> bool {
        self.count > 0
            && match track {
                Track::Axis(motor) => row(motor.0.into()).is_some_and(|row| self.axes.has_any(row)),
                Track::Channel(channel) => row(channel.0).is_some_and(|row| self.channels.has_any(row)),
                Track::Triggers => self.mask != Triggers::NONE,
            }
    }

    /// Position of a motor at a frame, given by its index; `None` if the motor or the frame is not part of the move, or
    /// if the upload is not complete.
    ///
    /// In a gap the motor keeps the position before it. Before its first position it has that position already.
    #[must_use]
    pub fn position(&self, motor: Motor, index: u32) -> Option<Steps> {
        let bytes = self.value(&self.axes, motor.0.into(), index)?;
        Some(Steps(I32::ref_from_bytes(bytes).ok()?.get()))
    }

    /// Position of a motor one frame before the first: as far from the first position as the second one is, in the
    /// opposite direction. It gives the speed at the start of the move.
    #[must_use]
    pub fn before_start(&self, motor: Motor) -> Option<Steps> {
        let first = self.position(motor, 0)?;
        let second = self.position(motor, 1).unwrap_or(first);
        let before = i64::from(first.0).wrapping_mul(2).wrapping_sub(second.0.into());
        let nearest = before.clamp(i32::MIN.into(), i32::MAX.into());
        i32::try_from(nearest).ok().map(Steps)
    }

    /// Level of a DMX channel at a frame, with the same rules as [`position`](Self::position).
    #[must_use]
    pub fn level(&self, channel: DmxChannel, index: u32) -> Option<u8> {
        self.value(&self.channels, channel.0, index)?.first().copied()
    }

    /// Outputs that are on at a frame. Nothing is kept from the frame before (safety decision 6).
    #[must_use]
    pub fn triggers(&self, index: u32) -> Triggers {
        let values = self.place(index).and_then(|index| self.triggers.get(index));
        Triggers(values.map_or(0, |values| values.0 & self.mask.0))
    }

    /// Outputs that the move switches.
    #[must_use]
    pub const fn mask(&self) -> Triggers {
        self.mask
    }

    /// Whether sections of this upload had different [masks](Self::mask). The last one counts (decision D-33).
    #[must_use]
    pub const fn mask_changed(&self) -> bool {
        self.mask_changed
    }

    /// Frames of a track without a value of their own, as ranges of indices: all frames, if the track is not part of
    /// the move. Triggers have no gaps, because frames without a trigger are not sent.
    #[must_use]
    pub fn gaps(&self, track: Track) -> Gaps<'_> {
        let gaps = match track {
            Track::Axis(motor) => row(motor.0.into()).map(|row| self.axes.gaps(row, self.count)),
            Track::Channel(channel) => row(channel.0).map(|row| self.channels.gaps(row, self.count)),
            Track::Triggers => None,
        };
        gaps.unwrap_or(Gaps::NONE)
    }

    fn value<'b>(&self, rows: &'b Rows<'_>, number: u16, index: u32) -> Option<&'b [u8]> {
        let (row, index) = (row(number)?, self.place(index)?);
        if rows.has_any(row) { rows.value(row, index) } else { None }
    }

    /// Place of the values of a frame, if the upload is complete.
    fn place(&self, index: u32) -> Option<usize> {
        usize::try_from(index).ok().filter(|&index| self.is_loaded() && index < self.count)
    }
}

/// Row of a motor or channel, whose numbers start with 1.
fn row(number: u16) -> Option<usize> {
    number.checked_sub(1).map(usize::from)
}

/// Writes a section of `len` values to a track of a move of `count` frames (decision D-32).
fn store(rows: &mut Rows<'_>, count: usize, number: u16, start: StartIndex, len: usize, values: &[u8]) -> Stored {
    let from = usize::try_from(start.index()).unwrap_or(usize::MAX);
    let end = from.saturating_add(len);
    let row = row(number).filter(|_| end <= count).ok_or(AckCode::ERR_RANGE)?;
    rows.write(row, from..end, values).ok_or(AckCode::ERR_RANGE)?;
    if start.is_last() {
        rows.repeat(row, end, count);
    }
    Ok(())
}

/// First `needed` places of a slice.
fn enough<'m, T>(what: &'static str, needed: usize, slice: &'m mut [T]) -> Result<&'m mut [T], RoomError> {
    let have = slice.len();
    slice.get_mut(..needed).ok_or(RoomError { what, needed, have })
}
