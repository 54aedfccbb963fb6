//! Clients of a device: which are connected, unlocked, or silent for too long (kOS 7.1).

use core::fmt;

use motion_core::time::Millis;
use motion_core::wire::{Password, Text16};
use motion_core::{display, states};

use super::options::{Options, Quirks};
use crate::transport::Transport;

/// Greatest number of clients that can be connected at once.
pub const SESSIONS: usize = 4;

/// Number of a client's connection, 0 to 3, which the caller chooses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
pub struct SessionId(pub u8);

impl SessionId {
    /// All numbers that there can be.
    pub const ALL: [Self; SESSIONS] = [Self(0), Self(1), Self(2), Self(3)];
}

impl fmt::Display for SessionId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Set of connections.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Sessions(u8);

impl Sessions {
    /// Set without connections.
    pub const NONE: Self = Self(0);

    /// Set of one connection.
    #[must_use]
    pub const fn one(session: SessionId) -> Self {
        match session.0 {
            number @ 0..=3 => Self(1_u8.wrapping_shl(number as u32)),
            _ => Self::NONE,
        }
    }

    /// Whether a connection is in the set.
    #[must_use]
    pub const fn contains(self, session: SessionId) -> bool {
        self.0 & Self::one(session).0 != 0
    }

    /// Whether the set is empty.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Connections of both sets.
    #[must_use]
    pub const fn with(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }

    /// Connections that the other set does not have.
    #[must_use]
    pub const fn without(self, others: Self) -> Self {
        Self(self.0 & !others.0)
    }

    /// Connections of the set, by their numbers.
    pub fn iter(self) -> impl Iterator<Item = SessionId> {
        SessionId::ALL.into_iter().filter(move |&session| self.contains(session))
    }
}

states! {
    /// State of a connection.
    pub enum State {
        /// There is no connection.
        Closed,
        /// The password did not come yet: only questions what and where the device is, and stops, are answered (safety
        /// decision 2).
        Locked,
        /// Everything is answered.
        Unlocked,
    }
}

/// Reason why the device closes a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum DisconnectReason {
    /// The client was silent for too long.
    Silence,
    /// The bytes from the client are no stream of messages (safety decision 6).
    Framing,
    /// The device starts anew.
    Reset,
    /// There is no such number: connections are 0 to 3.
    NoRoom,
}

display! {
    DisconnectReason {
        Silence => "the client was silent for too long";
        Framing => "the bytes from the client are no stream of messages";
        Reset => "the device starts anew";
        NoRoom => "there is no connection with this number";
    }
}

/// Connection of a client.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Session {
    transport: Transport,
    unlocked: bool,
    /// Time at which the client was silent for too long.
    silent: Millis,
    /// Time at which the device tells its address again, if it does so over TCP.
    push: Option<Millis>,
}

/// All connections.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(super) struct Table {
    sessions: [Option<Session>; SESSIONS],
}

/// Passwords are compared by their bytes, without the NULs that may end them (decisions K-T2 and K-T3).
fn same(one: Password<'_>, other: Password<'_>) -> bool {
    Text16(one.0).without_nuls() == Text16(other.0).without_nuls()
}

impl Table {
    fn get_mut(&mut self, id: SessionId) -> Option<&mut Session> {
        self.sessions.get_mut(usize::from(id.0)).and_then(Option::as_mut)
    }

    fn get(&self, id: SessionId) -> Option<&Session> {
        self.sessions.get(usize::from(id.0)).and_then(Option::as_ref)
    }

    fn filter(&self, wanted: impl Fn(&Session) -> bool) -> Sessions {
        let wanted = SessionId::ALL.into_iter().filter(|&id| self.get(id).is_some_and(&wanted));
        wanted.map(Sessions::one).fold(Sessions::NONE, Sessions::with)
    }

    /// Connections that are told what happens.
    // The code of the machine is made in the program, because the machine has a parameter. In firmware it has to be short.
    #[cfg_attr(not(target_os = "none"), inline)]
    pub(super) fn unlocked(&self) -> Sessions {
        self.filter(|session| session.unlocked)
    }

    pub(super) fn all(&self) -> Sessions {
        self.filter(|_| true)
    }

    #[cfg_attr(not(target_os = "none"), inline)]
    pub(super) fn has_tcp(&self) -> bool {
        !self.filter(|session| session.transport == Transport::Tcp).is_empty()
    }

    pub(super) fn state(&self, id: SessionId) -> State {
        match self.get(id) {
            None => State::Closed,
            Some(Session { unlocked: false, .. }) => State::Locked,
            Some(_) => State::Unlocked,
        }
    }

    /// Opens a connection; `false` if there is no such number.
    ///
    /// Without a password the lock is open, unless the device is one that wants the empty one (decision K-P4).
    pub(super) fn open(
        &mut self,
        now: Millis,
        id: SessionId,
        transport: Transport,
        password: Password<'_>,
        options: &Options,
    ) -> bool {
        let free = same(password, Password(&[])) && !options.has(Quirks::REQUIRE_EMPTY_PASSWORD);
        let push = options.push_every().filter(|_| transport == Transport::Tcp).map(|every| now.after(every));
        let silent = now.after(silence(options, transport));
        let unlocked = transport == Transport::Usb || free;
        let place = self.sessions.get_mut(usize::from(id.0));
        place.map(|place| *place = Some(Session { transport, unlocked, silent, push })).is_some()
    }

    pub(super) fn close(&mut self, id: SessionId) {
        if let Some(place) = self.sessions.get_mut(usize::from(id.0)) {
            *place = None;
        }
    }

    /// Notes that a message came, whatever it says.
    pub(super) fn message_received(&mut self, now: Millis, id: SessionId, options: &Options) {
        if let Some(session) = self.get_mut(id) {
            session.silent = now.after(silence(options, session.transport));
        }
    }

    /// Takes the password of a session; `false` if it is wrong. Over USB it does not matter (decision K-U7).
    pub(super) fn user_password(&mut self, id: SessionId, given: Password<'_>, stored: Password<'_>) -> bool {
        let Some(session) = self.get_mut(id) else { return true };
        if session.transport == Transport::Tcp {
            session.unlocked = same(given, stored);
        }
        session.unlocked
    }

    /// Locks all sessions over TCP because another password is stored, unless it is the same.
    pub(super) fn device_password(&mut self, given: Password<'_>, stored: Password<'_>) {
        let kept = same(given, stored);
        for session in self.sessions.iter_mut().flatten() {
            session.unlocked &= kept || session.transport == Transport::Usb;
        }
    }

    /// Connections whose clients were silent for too long.
    pub(super) fn silent(&self, now: Millis) -> Sessions {
        self.filter(|session| now >= session.silent)
    }

    /// Connections that are told the address now, and notes when they are told it next.
    pub(super) fn push(&mut self, now: Millis, options: &Options) -> Sessions {
        let due = self.filter(|session| session.push.is_some_and(|push| now >= push));
        for id in due.iter() {
            if let Some(session) = self.get_mut(id) {
                session.push = options.push_every().map(|every| now.after(every));
            }
        }
        due
    }

    /// Next time at which something follows.
    pub(super) fn deadline(&self) -> Option<Millis> {
        self.sessions
            .iter()
            .flatten()
            .map(|session| session.push.map_or(session.silent, |push| push.min(session.silent)))
            .min()
    }
}

const fn silence(options: &Options, transport: Transport) -> u64 {
    match transport {
        Transport::Tcp => options.tcp_silence(),
        Transport::Usb => options.usb_silence(),
    }
}
