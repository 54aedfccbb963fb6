//! What a device is, and how it differs from the book.

use motion_core::flags;

use crate::message::{Capabilities, Hi, Name};

/// What a device says of itself, and the times it keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Options {
    /// What it says of itself. It is all that decides which requests it takes: motors, channels, capabilities.
    ///
    /// Without [`of`](Self::of): a nameless device that has and can do nothing.
    pub hi: Hi<'static>,
    /// How it differs from the specification; not at all, unless told.
    pub quirks: Quirks,
    /// Milliseconds between two reports of positions while motors move.
    pub(super) report_every: u32,
    /// Milliseconds within which a second stop of everything is a harder one.
    pub(super) harder_within: u32,
    /// Milliseconds that a device stays locked after a hard stop, once all motors stand.
    pub(super) hold: u32,
}

impl Options {
    /// Those of a device that says this of itself.
    #[must_use]
    pub const fn of(hi: Hi<'static>) -> Self {
        Self { hi, quirks: Quirks(0), report_every: 100, harder_within: 1000, hold: 2000 }
    }

    /// The same, with these quirks.
    #[must_use]
    pub const fn with_quirks(mut self, quirks: Quirks) -> Self {
        self.quirks = quirks;
        self
    }

    /// The same, with reports of positions this many milliseconds apart while motors move: 100 unless told otherwise, as
    /// the specification says. 0 counts as 1.
    #[must_use]
    pub const fn with_report_every(mut self, millis: u32) -> Self {
        self.report_every = if millis == 0 { 1 } else { millis };
        self
    }

    /// The same, taking a second stop of everything within this many milliseconds for an emergency: 1000 unless told
    /// otherwise, as the vendor's firmware has it (DMC D2, decision D-22).
    #[must_use]
    pub const fn with_harder_within(mut self, millis: u32) -> Self {
        self.harder_within = millis;
        self
    }

    /// The same, locked after a hard stop for this many milliseconds from when all motors stand: 2000 unless told otherwise,
    /// as the vendor's firmware has it (DMC D2).
    #[must_use]
    pub const fn with_hold(mut self, millis: u32) -> Self {
        self.hold = millis;
        self
    }
}

impl Default for Options {
    fn default() -> Self {
        Self::of(Hi {
            name: Name::default(),
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
        })
    }
}

flags! {
    /// What devices in the field do otherwise than the specification says: for simulators that stand for one of them.
    ///
    /// None of them touches a stop.
    pub struct Quirks(u16) {
        /// Acknowledgements have four bytes, the upper two zero (decision D-6).
        WIDE_ACK = 0x0001,
        /// The greeting has 49 bytes, without the version of the protocol (decision D-45).
        SHORT_GREETING = 0x0002,
        /// A request for positions is answered by an acknowledgement, and the positions come before it with id 0 (decision
        /// D-18).
        POSITIONS_APART = 0x0004,
        /// A move is acknowledged, instead of answered by a status (decision D-17).
        ACK_FOR_MOVE = 0x0008,
        /// New positions are told before the request that set them is acknowledged (decision D-19).
        RESET_TOLD_FIRST = 0x0010,
        /// The end is told after each pass of a loop (DMC D3).
        END_PER_PASS = 0x0020,
        /// The end of a shot is not told (DMC D3).
        NO_END_OF_SHOT = 0x0040,
        /// Whatever locked the device, it answers `ERR_HARD_LOW` (decision D-52).
        ONE_LOCK_CODE = 0x0080,
    }
}

impl Quirks {
    /// Those of the vendor's own firmware, dmc-lite.
    pub const VENDOR: Self = Self(0x00FF);
}
