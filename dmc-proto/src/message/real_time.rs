//! Real-time moves: upload, run, shoot.

use core::fmt;

use motion_core::fixed::{Deci, Milli};
use motion_core::wire::Bool;
use motion_core::{__newtype, element, flags, message, open_enum, unit};
use zerocopy::little_endian::I32;

use super::{Motor, Steps};

unit! {
    /// Frames a second, in thousandths: 23.976.
    pub struct FramesPerSecond(Milli<u32>) "frames/s";
    /// A frame of the shot, as the host counts.
    pub struct FrameNumber(i32) "";
    /// A time.
    pub struct Milliseconds(u32) "ms";
    /// A short time.
    pub struct ShortMilliseconds(u16) "ms";
    /// A shutter angle, 0 to 360 (decision D-28).
    pub struct Degrees(u16) "°";
    /// A DMX channel, 1 to 512; 0 where there is none.
    pub struct DmxChannel(u16) "";
    /// How much of a frame's motion is blurred, in tenths of a percent (decision D-27).
    pub struct BlurPercent(Deci<u16>) "%";
}

message! {
    /// One section of one motor's positions of a move. Source: DMC, MSG_RT_UPLOAD_MOVE_AXIS; decision D-32.
    pub struct RtUploadMoveAxis<'a> in LE {
        /// Which motor.
        motor: Motor,
        /// Which frame of the move the first position is for, from 0, and whether this is the last section.
        start_index: StartIndex,
        ;
        /// One position a frame.
        positions: &'a [I32] ["steps"],
    }

    /// Get ready to run the uploaded move: go to the start, then to the pre-roll point, and wait for the start signal.
    ///
    /// Source: DMC, MSG_RT_RUN_MOVE; safety decision 9, decisions D-23 and D-24.
    pub struct RtRunMove<'a> in LE {
        /// How fast.
        fps_x1000: FramesPerSecond,
        /// The first frame.
        start_frame: FrameNumber,
        /// The last frame.
        end_frame: FrameNumber,
        /// Time to get up to speed before the first frame.
        pre_roll_ms: Milliseconds,
        /// Time to come to rest behind the last frame.
        post_roll_ms: Milliseconds,
        /// Whether the uploaded DMX levels and triggers run along.
        sync_dmx: Bool,
        /// The outputs that mark the first frame.
        bloop_location: BloopOutputs,
        /// The DMX channel that marks the first frame, 0 for none.
        bloop_dmx_channel: DmxChannel,
        /// How long the mark is.
        bloop_ms: ShortMilliseconds,
        ;
        /// Loops and camera triggers; for devices that can.
        flags: Option<RunFlags>,
        /// Where the shutter opens, of cameras that are triggered for every frame.
        open_angle: Option<Degrees>,
        /// Where the shutter closes, of cameras that are triggered for every frame.
        close_angle: Option<Degrees>,
    }

    /// Get ready to move through one frame while the shutter is open. Source: DMC, MSG_RT_SHOOT_FRAME; decision D-25.
    pub struct RtShootFrame<'a> in LE {
        /// Which frame.
        frame: FrameNumber,
        /// Which way the motors move through it.
        direction: Direction,
        /// How long the shutter is open.
        exposure_ms: Milliseconds,
        /// How much of the frame's motion is blurred; 0 stands for all.
        blur_x10: BlurPercent,
        ;
        /// Motors that do not follow the uploaded move.
        motors: &'a [MotorPair],
    }
}

element! {
    /// The way of one motor while the shutter is open.
    pub struct MotorPair in LE, "motor_count" {
        /// Which motor.
        motor: Motor,
        /// Where it begins.
        pos_a: Steps,
        /// Where it ends.
        pos_b: Steps,
    }
}

flags! {
    /// How a move runs. Unknown bits are kept. Source: DMC, MSG_RT_RUN_MOVE, FLAGS.
    pub struct RunFlags(u16) {
        /// There and back, until told otherwise; stronger than `LOOP`.
        PING_PONG = 0x0001,
        /// Again and again, until told otherwise.
        LOOP = 0x0002,
        /// The camera is triggered at the start and at the end: video.
        CAMERA_START_STOP = 0x0010,
        /// The camera is triggered for every frame: stills.
        CAMERA_EVERY_FRAME = 0x0020,
    }

    /// The outputs that mark the first frame. Unknown bits are kept. The names are those of the vendor's firmware
    /// (decision D-24).
    pub struct BloopOutputs(u32) {
        /// The logic output.
        LOGIC_OUT = 0x0000_0001,
        /// The relay output.
        RELAY_OUT = 0x0000_0002,
        /// The DMX channel.
        DMX = 0x0000_0004,
    }
}

open_enum! {
    /// Which way motors move through a frame.
    pub struct Direction(u8) {
        /// Back.
        BACKWARD = 0,
        /// On.
        FORWARD = 1,
    }
}

/// Where a section of an upload begins, and whether it is the last one of its motor.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(transparent)]
pub struct StartIndex(pub u32);

impl StartIndex {
    const LAST: u32 = 0x8000_0000;

    /// The section that begins at `index`, at most 2^31 - 1; `None` beyond.
    #[must_use]
    pub const fn new(index: u32, last: bool) -> Option<Self> {
        match (index & Self::LAST, last) {
            (0, false) => Some(Self(index)),
            (0, true) => Some(Self(index | Self::LAST)),
            _ => None,
        }
    }

    /// The frame of the move, from 0, that the section begins with.
    #[must_use]
    pub const fn index(self) -> u32 {
        self.0 & !Self::LAST
    }

    /// Whether the last value holds to the end of the move.
    #[must_use]
    pub const fn is_last(self) -> bool {
        self.0 & Self::LAST != 0
    }
}

impl fmt::Display for StartIndex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.index(), if self.is_last() { ", last section" } else { "" })
    }
}

__newtype! { StartIndex(u32) "" }
