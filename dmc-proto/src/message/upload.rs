//! Upload of a move: positions, DMX levels and triggers, frame by frame.

use core::fmt;

use motion_core::{__newtype, element, message};
use zerocopy::little_endian::I32;

use super::{DmxChannel, FrameNumber, Motor, Triggers};

message! {
    /// Begin of the upload of a move. The device forgets the move before.
    ///
    /// Some devices give each motor a path of zeros. A motor that is enabled and has no section then runs to position 0 in
    /// `RtPositionFrame`, `RtRunMove` and `RtShootFrame`: disable it before.
    ///
    /// Source: DMC, MSG_RT_UPLOAD_MOVE_BEGIN; decisions D-31 and D-84.
    #[derive(Default)]
    pub struct RtUploadMoveBegin<'a> in LE {
        /// First frame of the move. Its index is 0. dmc-lite runs only moves right that start at frame 1.
        start_frame: FrameNumber,
        /// Last frame of the move.
        end_frame: FrameNumber,
    }

    /// Section of the positions of one motor in a move. Source: DMC, MSG_RT_UPLOAD_MOVE_AXIS; decision D-32.
    #[derive(Default)]
    pub struct RtUploadMoveAxis<'a> in LE {
        /// Number of the motor.
        motor: Motor,
        /// Index of the frame of the first position, from 0, and whether this is the last section.
        start_index: StartIndex,
        ;
        /// Positions, one for each frame.
        positions: &'a [I32] ["steps"],
    }

    /// Section of the levels of one DMX channel in a move. Source: DMC, MSG_RT_UPLOAD_MOVE_DMX; decision D-32.
    #[derive(Default)]
    pub struct RtUploadMoveDmx<'a> in LE {
        /// Number of the channel.
        channel: DmxChannel,
        /// Index of the frame of the first level, from 0, and whether this is the last section.
        start_index: StartIndex,
        ;
        /// Levels, one for each frame.
        levels: &'a [u8],
    }

    /// End of the upload of a move. Source: DMC, MSG_RT_UPLOAD_MOVE_END.
    #[derive(Default)]
    pub struct RtUploadMoveEnd<'a> in LE {}

    /// Outputs that are on at frames of a move. At a frame that is not named, all outputs are off.
    ///
    /// Source: DMC, MSG_RT_UPLOAD_MOVE_TRIGGERS; safety decision 6, decision D-33.
    #[derive(Default)]
    pub struct RtUploadMoveTriggers<'a> in LE {
        /// Outputs that the move switches, the same in each section.
        mask: Triggers,
        ;
        /// Frames at which an output is on.
        pairs: &'a [TriggerPair],
    }
}

element! {
    /// Outputs that are on at one frame.
    pub struct TriggerPair in LE, "pair_count" {
        /// Index of the frame of the move, from 0.
        frame: u32,
        /// Outputs that are on.
        values: Triggers,
    }
}

/// Index of the frame with which a section of an upload begins, and whether the section is the last one of its track.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(transparent)]
pub struct StartIndex(pub u32);

impl StartIndex {
    const LAST_BIT: u32 = 0x8000_0000;

    /// Last section, with the index 0.
    pub(crate) const LAST: Self = Self(Self::LAST_BIT);

    /// Start of a section at `index`, which is at most 2^31 - 1; `None` for a greater index.
    #[must_use]
    pub const fn new(index: u32, last: bool) -> Option<Self> {
        match (index & Self::LAST_BIT, last) {
            (0, false) => Some(Self(index)),
            (0, true) => Some(Self(index | Self::LAST_BIT)),
            _ => None,
        }
    }

    /// Index of the frame of the move, from 0, with which the section begins.
    #[must_use]
    pub const fn index(self) -> u32 {
        self.0 & !Self::LAST_BIT
    }

    /// Whether this is the last section, so that its last value holds to the end of the move.
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
        assert_eq!(StartIndex::new(0x8000_0000, false), None, "the bit has another meaning");
        assert_eq!(std::format!("{last}; {}", StartIndex(5)), "5, last section; 5");
    }
}
