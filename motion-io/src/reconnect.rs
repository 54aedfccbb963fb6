//! Opening of a lost line.

use core::time::Duration;

use motion_core::machine::Token;
use motion_core::session::{DeviceSession, HostSession};
use motion_core::time::Millis;

/// Rules by which a driver opens a lost line again.
///
/// The time between two attempts doubles from the first to the longest. A session that asks for its line, as a client of kOS does,
/// decides itself when it asks again. After the line is open again, the driver of a host tells
/// the session to stop everything before all other commands, if anything could move when the line was lost or since then. Nobody
/// watched the rig in that time, so that a stop is the safe beginning; a rig that rests is not affected by it. The stop is
/// a command with the token [`STOP`](Self::STOP), and ends with an event as any other.
///
/// # Devices
///
/// The driver of a device does not stop anything. The machine of the device is told of the loss at once, and decides what its rig
/// does until a host is there again; the driver gives its events meanwhile:
///
/// - A DMC device stops everything, because no stop could come any more.
/// - A kOS device stops what the client moved by hand. A move that it plays goes on, unless the options of its machine say that
///   it stops when no client is left.
/// - A hoot node goes on with its program and its moves. Only its dead-man stops motors that run.
///
/// An application that has to do more for its rig does without these rules: then the driver ends with an error when the line is
/// lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reconnect {
    first: Duration,
    longest: Duration,
    attempts: Option<u32>,
    stop: Option<Token>,
}

impl Reconnect {
    /// Token of the stop after a line was lost, unless another is chosen.
    pub const STOP: Token = Token(u32::MAX);

    /// Rules with attempts after 100 ms, 200 ms and so on up to 5 s, without an end, and with a stop.
    #[must_use]
    pub const fn new() -> Self {
        let (first, longest) = (Duration::from_millis(100), Duration::from_secs(5));
        Self { first, longest, attempts: None, stop: Some(Self::STOP) }
    }

    /// Sets the time before the first attempt, at least 1 ms, and the longest time between two attempts.
    #[must_use]
    pub const fn with_times(mut self, first: Duration, longest: Duration) -> Self {
        (self.first, self.longest) = (first, longest);
        self
    }

    /// Sets the number of attempts that may fail in a row, at least one. A line that is lost before a byte arrived counts as an
    /// attempt that failed. After them, the driver gives the error of the last one.
    #[must_use]
    pub const fn with_attempts(mut self, attempts: u32) -> Self {
        self.attempts = Some(attempts);
        self
    }

    /// Sets the token of the stop.
    #[must_use]
    pub const fn with_stop_token(mut self, token: Token) -> Self {
        self.stop = Some(token);
        self
    }

    /// Leaves the stop out. Whatever the rig does then is the responsibility of the application: motors may still run that
    /// were started before the line was lost.
    #[must_use]
    pub const fn without_stop(mut self) -> Self {
        self.stop = None;
        self
    }
}

impl Default for Reconnect {
    fn default() -> Self {
        Self::new()
    }
}

/// Attempts to open a line again.
pub(crate) struct Attempts<S> {
    rules: Reconnect,
    may_move: fn(&S) -> bool,
    stop: fn(&mut S, Token),
    /// Whether anything could move when the line was lost.
    moved: bool,
    /// Whether no byte has arrived since the line was opened.
    is_mute: bool,
    failed: u32,
    /// Time of the next attempt.
    pub(crate) at: Millis,
}

impl<S> Attempts<S> {
    pub(crate) fn new(rules: Reconnect) -> Self
    where
        S: HostSession,
    {
        // There is only no room for a stop if other stops wait before all commands.
        let stop = |session: &mut S, token| _ = session.stop(token);
        Self { rules, may_move: S::may_move, stop, moved: false, is_mute: false, failed: 0, at: Millis(0) }
    }

    /// Attempts for a device, whose machine is told of the loss at once and decides what stops.
    pub(crate) fn of_device(rules: Reconnect) -> Self
    where
        S: DeviceSession,
    {
        Self { rules, may_move: |_| false, stop: |_, _| {}, moved: false, is_mute: false, failed: 0, at: Millis(0) }
    }

    /// Notes that the line is lost. A line that gave no byte counts as one that could not be opened. Returns false if that was
    /// the last attempt.
    pub(crate) fn lost(&mut self, now: Millis, session: &S) -> bool {
        self.moved |= (self.may_move)(session);
        if core::mem::take(&mut self.is_mute) {
            return self.failed(now);
        }
        self.wait(now);
        true
    }

    /// Notes that the line cannot be opened. Returns false if that was the last attempt.
    pub(crate) fn failed(&mut self, now: Millis) -> bool {
        self.failed = self.failed.saturating_add(1);
        self.wait(now);
        self.rules.attempts.is_none_or(|attempts| self.failed < attempts)
    }

    fn wait(&mut self, now: Millis) {
        let doubled = self.rules.first.saturating_mul(1_u32.checked_shl(self.failed).unwrap_or(u32::MAX));
        let millis = doubled.min(self.rules.longest).as_millis().max(1);
        self.at = now.after(u64::try_from(millis).unwrap_or(u64::MAX));
    }

    /// Stops everything first, after the line is open again, if anything can move.
    pub(crate) fn opened(&mut self, session: &mut S) {
        self.is_mute = true;
        let may_move = core::mem::take(&mut self.moved) || (self.may_move)(session);
        if let Some(token) = self.rules.stop.filter(|_| may_move) {
            (self.stop)(session, token);
        }
    }

    /// Notes that bytes arrived, so that the line is a good one.
    pub(crate) fn works(&mut self) {
        (self.is_mute, self.failed) = (false, 0);
    }
}
