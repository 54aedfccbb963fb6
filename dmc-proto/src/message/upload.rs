//! Uploading a move: positions, DMX levels and triggers, frame by frame.

use core::fmt;

use motion_core::{__newtype, element, message};
use zerocopy::little_endian::I32;

use super::{DmxChannel, FrameNumber, Motor, Triggers};

message! {
    /// Begin the upload of a move. What was uploaded before is forgotten.
    ///
    /// Source: DMC, MSG_RT_UPLOAD_MOVE_BEGIN; decision D-31.
    #[derive(Default)]
    pub struct RtUploadMoveBegin<'a> in LE {
        /// The first frame of the move; its index is 0.
        start_frame: FrameNumber,
        /// The last frame of the move.
        end_frame: FrameNumber,
    }

    /// One section of one motor's positions of a move. Source: DMC, MSG_RT_UPLOAD_MOVE_AXIS; decision D-32.
    #[derive(Default)]
    pub struct RtUploadMoveAxis<'a> in LE {
        /// Which motor.
        motor: Motor,
        /// Which frame of the move the first position is for, from 0, and whether this is the last section.
        start_index: StartIndex,
        ;
        /// One position a frame.
        positions: &'a [I32] ["steps"],
    }

    /// One section of one DMX channel's levels of a move. Source: DMC, MSG_RT_UPLOAD_MOVE_DMX; decision D-32.
    #[derive(Default)]
    pub struct RtUploadMoveDmx<'a> in LE {
        /// Which channel.
        channel: DmxChannel,
        /// Which frame of the move the first level is for, from 0, and whether this is the last section.
        start_index: StartIndex,
        ;
        /// One level a frame.
        levels: &'a [u8],
    }

    /// End of the upload of a move. Source: DMC, MSG_RT_UPLOAD_MOVE_END.
    #[derive(Default)]
    pub struct RtUploadMoveEnd<'a> in LE {}

    /// Which outputs are on at which frames of a move; a frame that is not named has them all off.
    ///
    /// Source: DMC, MSG_RT_UPLOAD_MOVE_TRIGGERS; safety decision 6, decision D-33.
    #[derive(Default)]
    pub struct RtUploadMoveTriggers<'a> in LE {
        /// The outputs that the move switches at all, the same in each section.
        mask: Triggers,
        ;
        /// The frames where one of them is on.
        pairs: &'a [TriggerPair],
    }
}

element! {
    /// The outputs that are on at one frame.
    pub struct TriggerPair in LE, "pair_count" {
        /// The frame of the move, from 0.
        frame: u32,
        /// The outputs that are on.
        values: Triggers,
    }
}

/// Where a section of an upload begins, and whether it is the last one of its motor.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(transparent)]
pub struct StartIndex(pub u32);

impl StartIndex {
    const LAST_BIT: u32 = 0x8000_0000;

    /// The last section, if it begins at 0.
    pub(crate) const LAST: Self = Self(Self::LAST_BIT);

    /// The section that begins at `index`, at most 2^31 - 1; `None` beyond.
    #[must_use]
    pub const fn new(index: u32, last: bool) -> Option<Self> {
        match (index & Self::LAST_BIT, last) {
            (0, false) => Some(Self(index)),
            (0, true) => Some(Self(index | Self::LAST_BIT)),
            _ => None,
        }
    }

    /// The frame of the move, from 0, that the section begins with.
    #[must_use]
    pub const fn index(self) -> u32 {
        self.0 & !Self::LAST_BIT
    }

    /// Whether the last value holds to the end of the move.
    #[must_use]
    pub const fn is_last(self) -> bool {
        self.0 & Self::LAST_BIT != 0
    }
}

impl fmt::Display for StartIndex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.index(), if self.is_last() { ", last section" } else { "" })
    }
}

__newtype! { StartIndex(u32) "" }

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bit_31_marks_the_last_section() {
        let last = StartIndex::new(5, true).unwrap();
        assert_eq!((last.0, last.index(), last.is_last()), (0x8000_0005, 5, true));
        assert_eq!(StartIndex::new(0x7fff_ffff, false), Some(StartIndex(0x7fff_ffff)));
        assert_eq!(StartIndex::new(0x8000_0000, false), None, "the bit is taken");
        assert_eq!(std::format!("{last}; {}", StartIndex(5)), "5, last section; 5");
    }
}
