//! What a device machine can be told once, at its begin.

use crate::discovery::ANNOUNCE_EVERY;
use crate::message::MotorAddress;
use crate::summary::{MotorSet, debug_fields, with};

/// How a device behaves where the specification leaves it open, and what is known of it. Times are in milliseconds.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Options {
    /// The motors that are there at the begin: 1 to 3, as on a Second Shooter.
    pub motors: MotorSet,
    /// Silence after which a client over TCP is gone: 30 000, as specified.
    pub tcp_silence: u64,
    /// Silence after which a client over USB is gone: 10 000, two keep-alives and some (decision K-U6).
    pub usb_silence: u64,
    /// Time between announcements while no client is connected: 5000, as specified.
    pub announce_every: u64,
    /// Time between addresses told unasked over TCP; `None`, for clients need not know them (decision K-D3).
    pub push_every: Option<u64>,
    /// Time between reports of a live move that runs: 1000.
    pub progress_every: Option<u64>,
    /// Time after which a motor that is not home, or at the next place, has failed: ten minutes, for it may go slowly.
    pub travel_limit: Option<u64>,
    /// Milliseconds since 1970 at `Millis(0)`; `None` without a clock: then no move waits for a moment (safety
    /// decision 5).
    pub unix_millis_at_zero: Option<u64>,
    /// Whether a session is locked until the password comes, although it is empty; no (decision K-P4).
    pub require_empty_password: bool,
    /// Whether the count of positions stays when a range is marked, as on firmware 1.0.1.5; no (decision K-M8).
    pub quirk_begin_nonzero: bool,
    /// Whether a move is stopped when the last client is gone; no, for a time lapse takes hours.
    pub stop_when_alone: bool,
    /// The platform that calibrated the motors: 0.
    pub platform: u8,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            motors: MotorSet::of([MotorAddress(1), MotorAddress(2), MotorAddress(3)]),
            tcp_silence: 30_000,
            usb_silence: 10_000,
            announce_every: ANNOUNCE_EVERY,
            push_every: None,
            progress_every: Some(1000),
            travel_limit: Some(600_000),
            unix_millis_at_zero: None,
            require_empty_password: false,
            quirk_begin_nonzero: false,
            stop_when_alone: false,
            platform: 0,
        }
    }
}

impl Options {
    with! {
        /// With these motors.
        with_motors motors: MotorSet;
        /// With this silence over TCP.
        with_tcp_silence tcp_silence: u64;
        /// With this silence over USB.
        with_usb_silence usb_silence: u64;
        /// With this time between announcements.
        with_announce_every announce_every: u64;
        /// With addresses told unasked over TCP, so often.
        with_push_every push_every: Option<u64>;
        /// With this time between reports of a move.
        with_progress_every progress_every: Option<u64>;
        /// With this time for motors to get home.
        with_travel_limit travel_limit: Option<u64>;
        /// With a clock.
        with_unix_millis_at_zero unix_millis_at_zero: Option<u64>;
        /// With a lock that wants the empty password, too.
        with_require_empty_password require_empty_password: bool;
        /// With a count of positions that stays.
        with_quirk_begin_nonzero quirk_begin_nonzero: bool;
        /// With moves that stop when the last client is gone.
        with_stop_when_alone stop_when_alone: bool;
        /// With this platform.
        with_platform platform: u8;
    }
}

debug_fields! {
    Options {
        motors,
        tcp_silence,
        usb_silence,
        announce_every,
        push_every,
        progress_every,
        travel_limit,
        unix_millis_at_zero,
        require_empty_password,
        quirk_begin_nonzero,
        stop_when_alone,
        platform,
    }
}
