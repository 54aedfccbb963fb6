//! Options of a device machine, given once at its start.

use motion_core::{flags, options};

use crate::discovery::ANNOUNCE_EVERY;
use crate::message::{ActionId, MotorAddress, MotorSet};
use crate::times::some_time;

flags! {
    /// Deviations from what the specification says, which some devices have.
    pub struct Quirks(u8) {
        /// The count of positions stays when a range is marked, as on firmware 1.0.1.5 (decision K-M8).
        BEGIN_NONZERO = 0x01,
        /// A session is locked until the password comes, although it is empty (decision K-P4).
        REQUIRE_EMPTY_PASSWORD = 0x02,
        /// A locked session ignores stops, too: everything except the password and the two questions that come before it
        /// (decision K-S23).
        LOCKED_IGNORES_STOPS = 0x04,
        /// A move is played forward, whatever the direction of the message says (decision K-J7).
        IGNORES_DIRECTION = 0x08,
        /// A motor is sent where the message says, also beyond the end of its range (decision K-M9).
        NOT_CLAMPED = 0x10,
        /// The device does not know `SoftwareID`, which came after the older dialect (decision K-S24).
        NO_SOFTWARE_ID = 0x20,
    }
}

/// Set of actions, by their numbers 0 to 63.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Actions(u64);

impl Actions {
    /// Set without actions.
    pub const NONE: Self = Self(0);

    /// The same set with an action; unchanged if no action has such a number.
    #[must_use]
    pub const fn with(self, action: ActionId) -> Self {
        Self(self.0 | Self::bit(action))
    }

    /// Whether an action is in the set.
    #[must_use]
    pub const fn contains(self, action: ActionId) -> bool {
        self.0 & Self::bit(action) != 0
    }

    const fn bit(action: ActionId) -> u64 {
        if action.0 < 64 { 1_u64.wrapping_shl(action.0 as u32) } else { 0 }
    }
}

/// Motors of a Second Shooter: 1 to 3.
const THREE: MotorSet = {
    let mut motors = MotorSet::NONE;
    motors.insert(MotorAddress(1));
    motors.insert(MotorAddress(2));
    motors.insert(MotorAddress(3));
    motors
};

options! {
    /// Options of a device: its behaviour where the specification leaves it open. Times are in milliseconds.
    pub struct Options {
        /// Motors that are there at the start.
        motors with_motors: MotorSet = THREE;
        /// Silence after which a client over TCP is gone, as specified.
        tcp_silence with_tcp_silence: u64 = 30_000, in 1..=u64::MAX;
        /// Silence after which a client over USB is gone: two keep-alives and some (decision K-U6).
        usb_silence with_usb_silence: u64 = 10_000, in 1..=u64::MAX;
        /// Time between announcements while no client is connected, as specified.
        announce_every with_announce_every: u64 = ANNOUNCE_EVERY, in 1..=u64::MAX;
        /// Time between addresses told unasked over TCP, which clients need not know (decision K-D3).
        push_every with_push_every: Option<u64> = None, by some_time;
        /// Time between reports of a live move that runs.
        progress_every with_progress_every: Option<u64> = Some(1000), by some_time;
        /// Time after which a motor that is not home, or not at the next place, has failed. It may go slowly.
        travel_limit with_travel_limit: Option<u64> = Some(600_000), by some_time;
        /// Milliseconds since 1970 at `Millis(0)`; `None` without a clock. Then no move waits for a moment (safety
        /// decision 5).
        unix_millis_at_zero with_unix_millis_at_zero: Option<u64> = None;
        /// Whether a move is stopped when the last client is gone. A time lapse takes hours.
        stop_when_alone with_stop_when_alone: bool = false;
        /// Platform that calibrated the motors.
        platform with_platform: u8 = 0;
        /// Deviations of the device.
        quirks with_quirks: Quirks = Quirks::empty();
        /// Actions that the device does not know, stops included. It answers them with `UnsupportedMessage`.
        unsupported with_unsupported: Actions = Actions::NONE;
    }
}

impl Options {
    /// Whether the device has a deviation.
    pub(super) const fn has(&self, quirk: Quirks) -> bool {
        self.quirks().contains(quirk)
    }
}
