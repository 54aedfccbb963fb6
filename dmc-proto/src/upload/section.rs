//! Division of a move into sections.

use core::ops::Range;

use zerocopy::little_endian::I32;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

use super::source::tracks;
use super::{MAX_FRAMES, MoveSource, Track};
use crate::frame::MAX_DATA;
use crate::message::{
    HostMessage, RtUploadMoveAxis, RtUploadMoveDmx, RtUploadMoveTriggers, StartIndex, TriggerPair, Triggers,
};

/// Bytes of the values in the longest section that is ever sent: 256 positions, 1024 levels or 128 pairs of triggers.
pub const SCRATCH: usize = 1024;

/// Greatest number of values in a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SectionSize {
    max_data: usize,
}

impl SectionSize {
    /// Section size for a device that takes `max_data` bytes of data in a frame. A device should take 1036 (decision
    /// D-10); more are not used. A section has at least one value, however small `max_data` is.
    #[must_use]
    pub const fn of(max_data: usize) -> Self {
        Self { max_data }
    }

    /// Number of positions in a section, at most 256.
    #[must_use]
    pub fn positions(self) -> usize {
        self.values::<I32>(5)
    }

    /// Number of levels in a section, at most 1024.
    #[must_use]
    pub fn levels(self) -> usize {
        self.values::<u8>(6)
    }

    /// Number of pairs of triggers in a section, at most 128.
    #[must_use]
    pub fn pairs(self) -> usize {
        self.values::<TriggerPair>(4)
    }

    /// Number of values of a type that fit after `fixed` bytes.
    fn values<T>(self, fixed: usize) -> usize {
        let bytes = self.max_data.saturating_sub(fixed).min(SCRATCH);
        bytes.checked_div(size_of::<T>()).unwrap_or(0).max(1)
    }
}

impl Default for SectionSize {
    /// Section size for a device that takes the data length of the specification.
    fn default() -> Self {
        Self::of(MAX_DATA)
    }
}

/// Section of a move: some frames of one track.
///
/// It holds no values, so it can be kept, compared and sent again. [`message`](Self::message) reads the values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
pub struct Section {
    track: Track,
    start: StartIndex,
    count: u32,
}

impl Section {
    /// First section of a move; `None` if the move has no track or no frame.
    #[must_use]
    pub fn first<S: MoveSource + ?Sized>(source: &S, size: SectionSize) -> Option<Self> {
        Self::cut(tracks(source).next()?, 0, source, size)
    }

    /// Section after this one; `None` after the last section of the last track.
    ///
    /// The values of the section are read from the source, and those of the frames after it until one differs from the
    /// last value that fits. If none differs, nothing more has to be sent.
    #[must_use]
    pub fn next<S: MoveSource + ?Sized>(self, source: &S, size: SectionSize) -> Option<Self> {
        if self.is_last() {
            let track = tracks(source).find(|&track| track > self.track)?;
            Self::cut(track, 0, source, size)
        } else {
            Self::cut(self.track, self.end(), source, size)
        }
    }

    /// Section of a track without values.
    pub(super) const fn empty(track: Track) -> Self {
        Self { track, start: StartIndex::LAST, count: 0 }
    }

    /// Track that the section belongs to.
    #[must_use]
    pub const fn track(&self) -> Track {
        self.track
    }

    /// Index of its first frame.
    #[must_use]
    pub const fn from(&self) -> u32 {
        self.start.index()
    }

    /// Number of frames that it covers.
    #[must_use]
    pub const fn count(&self) -> u32 {
        self.count
    }

    /// Whether this is the last section of its track, so that its last value holds to the end of the move.
    #[must_use]
    pub const fn is_last(&self) -> bool {
        self.start.is_last()
    }

    /// Index after its last frame.
    const fn end(&self) -> u32 {
        self.from().saturating_add(self.count)
    }

    /// Message of the section with the values of the source, which are stored in `scratch`.
    #[must_use]
    pub fn message<'s, S: MoveSource + ?Sized>(&self, source: &S, scratch: &'s mut [u8; SCRATCH]) -> HostMessage<'s> {
        let (frames, start_index) = (self.from()..self.end(), self.start);
        match self.track {
            Track::Axis(motor) => {
                let positions = put(scratch, frames.map(|index| I32::new(source.position(motor, index).0)));
                RtUploadMoveAxis { motor, start_index, positions, tail: &[] }.into()
            }
            Track::Channel(channel) => {
                let levels = put(scratch, frames.map(|index| source.level(channel, index)));
                RtUploadMoveDmx { channel, start_index, levels, tail: &[] }.into()
            }
            Track::Triggers => {
                let pairs = put(scratch, frames.filter_map(|index| Some(TriggerPair::new(index, on(source, index)?))));
                RtUploadMoveTriggers { mask: source.mask(), pairs, tail: &[] }.into()
            }
        }
    }

    /// Longest section of a track that starts with frame `from`.
    fn cut<S: MoveSource + ?Sized>(track: Track, from: u32, source: &S, size: SectionSize) -> Option<Self> {
        let frames = source.frame_count().min(MAX_FRAMES);
        if from >= frames {
            return None;
        }
        let (range, last) = match track {
            Track::Axis(motor) => values(from, frames, size.positions(), |index| source.position(motor, index)),
            Track::Channel(channel) => values(from, frames, size.levels(), |index| source.level(channel, index)),
            Track::Triggers => pairs(from, frames, size.pairs(), |index| on(source, index).is_some()),
        };
        let start = StartIndex::new(range.start, last)?;
        Some(Self { track, start, count: range.end.saturating_sub(range.start) })
    }
}

/// All sections of a move, in the order of sending.
pub fn sections<S: MoveSource + ?Sized>(source: &S, size: SectionSize) -> impl Iterator<Item = Section> {
    core::iter::successors(Section::first(source, size), move |section| section.next(source, size))
}

/// Outputs of the move that are on at a frame, if any.
fn on<S: MoveSource + ?Sized>(source: &S, index: u32) -> Option<Triggers> {
    let values = Triggers(source.triggers(index).0 & source.mask().0);
    (values != Triggers::NONE).then_some(values)
}

/// As many frames from `from` on as fit, and whether the last value among them holds to the end of the move.
///
/// Values that repeat to the end are left out. So a section is the last one if nothing changes after its `max` frames.
fn values<T: PartialEq>(from: u32, frames: u32, max: usize, value: impl Fn(u32) -> T) -> (Range<u32>, bool) {
    let limit = from.saturating_add(u32::try_from(max).unwrap_or(u32::MAX));
    let (mut latest, mut held) = (from, value(from));
    for index in from..frames {
        let value = value(index);
        if value != held {
            if index >= limit {
                return (from..limit, false);
            }
            (latest, held) = (index, value);
        }
    }
    (from..latest.saturating_add(1), true)
}

/// Frames from the first one at `from` or later with a trigger on, up to the last one that fits, and whether no such
/// frame comes after them. If no trigger is ever on, the range is empty and the section only carries the mask.
fn pairs(from: u32, frames: u32, max: usize, is_on: impl Fn(u32) -> bool) -> (Range<u32>, bool) {
    let mut on = (from..frames).filter(|&index| is_on(index));
    let Some(first) = on.next() else { return (from..from, true) };
    let latest = on.by_ref().take(max.saturating_sub(1)).last().unwrap_or(first);
    (first..latest.saturating_add(1), on.next().is_none())
}

/// Stores values in memory, as many as fit.
fn put<T>(scratch: &mut [u8; SCRATCH], values: impl Iterator<Item = T>) -> &[T]
where
    T: FromBytes + IntoBytes + KnownLayout + Immutable,
{
    let places = <[T]>::mut_from_bytes(scratch).unwrap_or_default();
    let mut used = 0_usize;
    for (place, value) in places.iter_mut().zip(values) {
        *place = value;
        used = used.saturating_add(1);
    }
    places.get(..used).unwrap_or_default()
}
