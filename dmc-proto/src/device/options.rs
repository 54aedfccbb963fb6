//! Options of a device, and its differences from the specification.

use motion_core::{flags, options};

use crate::message::{Capabilities, Hi, Name};

options! {
    /// Options of a device: what it says of itself, and its times.
    pub struct Options {
        /// Greeting of the device. It alone decides which requests the device takes: motors, channels, capabilities.
        ///
        /// The default is a device without a name that has nothing and can do nothing.
        hi with_hi: Hi<'static> = NOTHING;
        /// Differences of the device from the specification.
        quirks with_quirks: Quirks = Quirks(0);
        /// Time between two reports of positions while motors move, in milliseconds. The default is that of the
        /// specification.
        report_every with_report_every: u32 = 100, in 1..=u32::MAX;
        /// Time within which a second stop of everything counts as an emergency, in milliseconds. The default is that of
        /// the vendor's firmware (DMC D2, decision D-22).
        harder_within with_harder_within: u32 = 1000, in 1..=u32::MAX;
        /// Time that the device stays locked after a hard stop, from when all motors rest, in milliseconds. The default is
        /// that of the vendor's firmware (DMC D2).
        hold with_hold: u32 = 2000, in 1..=u32::MAX;
    }
}

impl Options {
    /// Options of a device with this greeting.
    #[must_use]
    pub const fn of(hi: Hi<'static>) -> Self {
        Self::new().with_hi(hi)
    }
}

/// Greeting of a device without a name that has nothing and can do nothing.
const NOTHING: Hi<'static> = Hi {
    name: Name([0; 32]),
    fw_major: 0,
    fw_minor: 0,
    fw_rev: 0,
    motor_count: 0,
    dmx_count: 0,
    gio_out_count: 0,
    gio_in_count: 0,
    hw_limit_count: 0,
    upload_frame_count: 0,
    capabilities: Capabilities(0),
    protocol_version: Some(2),
    tail: &[],
};

flags! {
    /// Differences of devices in the field from the specification, for simulators that stand for one of them.
    ///
    /// A stop is refused with [`STOP_LOCKS`](Self::STOP_LOCKS), and ignored with
    /// [`STOP_OF_ONE_IGNORED`](Self::STOP_OF_ONE_IGNORED). They are for simulators alone: hosts have to cope with such devices.
    pub struct Quirks(u32) {
        /// Acknowledgements have four bytes, the upper two zero (decision D-6).
        WIDE_ACK = 0x0001,
        /// The greeting has 49 bytes, without the version of the protocol (decision D-45).
        SHORT_GREETING = 0x0002,
        /// A request for positions is answered by an acknowledgement, and the positions come before it with id 0 (decision
        /// D-18).
        POSITIONS_APART = 0x0004,
        /// A move is acknowledged instead of answered by a status (decision D-17).
        ACK_FOR_MOVE = 0x0008,
        /// New positions are told before the request that set them is acknowledged (decision D-19).
        RESET_TOLD_FIRST = 0x0010,
        /// The end is told after each pass of a loop (DMC D3).
        END_PER_PASS = 0x0020,
        /// The end of a shot is not told (DMC D3).
        NO_END_OF_SHOT = 0x0040,
        /// Whatever locked the device, it answers `ERR_HARD_LOW`, before it looks at the request (decision D-52).
        ONE_LOCK_CODE = 0x0080,
        /// A stop of everything that moves, unless it has a flag, locks the device until all motors rest, and for
        /// [`hold`](Options::hold) at least. Until then it refuses everything except questions, stops too (decision D-78).
        STOP_LOCKS = 0x0100,
        /// A stop of one motor in a run, a shot or a jog of all motors is acknowledged, and does nothing. On the way to a frame
        /// it stops that motor alone (decision D-79).
        STOP_OF_ONE_IGNORED = 0x0200,
        /// After a run, the motors rest on the frame after its last one, if the move has that frame (decision D-80).
        RESTS_BEYOND = 0x0400,
        /// A way to a frame outside the move leads to the nearest frame of the move (decision D-81).
        CLAMPS_FRAMES = 0x0800,
        /// After a shot, the motors stay where its ways ended, on no frame (decision D-82).
        STAYS_AFTER_SHOT = 0x1000,
        /// After the acknowledgement of a stop, a new position or a way to a frame, positions follow under the id of the
        /// request (decision D-83).
        POSITIONS_AFTER_ACK = 0x2000,
        /// A move or a jog of one motor is accepted on the way to a frame, and in the wait for the signal to start. It ends the
        /// run or shot that was prepared (decision D-92).
        CUTS_IN = 0x4000,
        /// Of the numbers in a request only those of motors are checked, and the frame of a shot, which needs an uploaded move
        /// (decision D-93).
        FEW_CHECKS = 0x8000,
        /// A way to a frame is refused until the motors rest after a run or a shot (decision D-94).
        BUSY_AFTER_RUN = 0x1_0000,
        /// A move of a motor that is driven by hand ends the run or shot that runs, and the end is not told (decision D-98).
        MOVE_ENDS_RUN = 0x2_0000,
    }
}

impl Quirks {
    /// Differences of the vendor's own firmware, dmc-lite.
    pub const VENDOR: Self = Self(0x3_DFFF);
}
