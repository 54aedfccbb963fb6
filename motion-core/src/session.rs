//! Parts that the sessions of all protocol crates share: a session is a machine with the stream buffer of its link.
//!
//! A session takes bytes that arrived and wishes of its caller, and gives one thing after the other: bytes to send, an event,
//! or the time until which to wait. It does no I/O, reads no clock and allocates nothing. Sessions are `host::Session` and
//! `device::Session` of each protocol crate.
//!
//! # The contract of all sessions
//!
//! 1. Tell the session what happened: the link came up or went down, bytes arrived, the application wants something.
//! 2. Call `poll` again and again, and do each thing before the next call, until it says to wait.
//! 3. Wait until something happens, at most until the time that it said. Then begin again.
//!
//! A stop of everything goes before all other wishes that wait in the session.

use arrayvec::ArrayVec;

use crate::machine::{Effect, Output, Token};
use crate::stream::{Framing, Item, Patience, TimedFrames};
use crate::time::Millis;
use crate::wire::EncodeError;

/// Number of wishes that a session can hold until the next poll.
pub const WISHES: usize = 8;

/// Reason why a session did not take a command. Nothing was changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum NotTaken {
    /// As many commands wait for a poll as the session can hold.
    #[error("{WISHES} commands wait in the session: poll it first")]
    Full,
    /// A command with this token has not ended.
    #[error("the command with token {0} has not ended: choose another token")]
    TokenInUse(Token),
    /// The message cannot be written, or is longer than the room that is free for messages of commands.
    #[error("the message cannot be kept: {0}")]
    Message(EncodeError),
}

/// Session of any protocol, on either side, as a driver moves it. `host::Session` and `device::Session` of each protocol crate
/// have the same as methods of their own, which do not need this trait.
///
/// An async function cannot lend an event from a loop. Therefore a driver takes a turn, and asks for the event after its loop.
pub trait Session {
    /// Data that only the caller has, lent to each turn: a move, passwords, knowledge of the rig; `()` if there is none.
    type Source<'s>: ?Sized;
    /// Line of the session: `()` if there is only one.
    type Line: Copy;
    /// Receiver of bytes: `()` if there is only one.
    type Destination: Copy;
    /// Event for the application.
    type Event<'e>
    where
        Self: 'e;
    /// Event that was not lent yet.
    type Held;

    /// Number of bytes that [`receive`](Self::receive) always takes after a turn said to wait.
    const PIECE: usize;

    /// Whether the session [asks](Self::request) for its line. Otherwise it is told that a line is up as soon as it is.
    const ASKS: bool = false;

    /// Whether bytes for this receiver go over this line.
    #[must_use]
    fn reaches(to: Self::Destination, line: Self::Line) -> bool;

    /// Request about this line that an event makes. Most events make none.
    #[must_use]
    fn request(held: &Self::Held, line: Self::Line) -> Option<LineRequest> {
        let _ = (held, line);
        None
    }

    /// Tells that a line is up. Bytes of an earlier one are dropped.
    ///
    /// # Errors
    ///
    /// [`NotTaken::Full`] if too much waits for a turn.
    fn link_up(&mut self, line: Self::Line) -> Result<(), NotTaken>;

    /// Tells that a line is down.
    ///
    /// # Errors
    ///
    /// [`NotTaken::Full`] if too much waits for a turn.
    fn link_down(&mut self, line: Self::Line) -> Result<(), NotTaken>;

    /// Takes bytes that arrived at a moment, and returns how many. Give the others again after the next wait.
    #[must_use = "bytes that were not taken have to be given again"]
    fn receive(&mut self, now: Millis, line: Self::Line, bytes: &[u8]) -> usize;

    /// Next thing to do. Messages are written to the front of `out`.
    ///
    /// # Errors
    ///
    /// [`EncodeError`] if a message cannot be written. If `out` is too small, call again with as many bytes as the error
    /// needs; the message is not lost.
    fn turn(&mut self, now: Millis, source: &Self::Source<'_>, out: &mut [u8]) -> Result<TurnOf<Self>, EncodeError>;

    /// Event of the last turn. It lends what arrived last: ask for it before anything else is told or given to
    /// the session. An event that is asked for later may lend another message, or be one that tells of no message at all, such as
    /// noise: what it told is lost.
    fn event(&self, held: Self::Held) -> Self::Event<'_>;
}

/// Session of a host, as a driver moves it.
pub trait HostSession: Session {
    /// Whether anything may still move because of this host. While a command or an event waits for a turn, the answer is yes.
    fn may_move(&self) -> bool;

    /// Stops everything, before all commands that wait.
    ///
    /// # Errors
    ///
    /// [`NotTaken::Full`] if too many stops wait for a turn.
    fn stop(&mut self, token: Token) -> Result<(), NotTaken>;
}

/// Session of a device, as a driver moves it.
pub trait DeviceSession: Session {
    /// Whether anything may move because of what this device was told. While a report, bytes that arrived or an event wait for a
    /// turn, the answer is yes.
    ///
    /// A DMC device that is locked after a stop counts as at rest as soon as all its motors rest.
    fn may_move(&self) -> bool;

    /// Stops everything, as a person at the device wants it. What arrived before the stop sets nothing in motion after it.
    ///
    /// The stop latches only for DMC, as an emergency stop does: the device refuses what moves until its own method
    /// `emergency_stop` tells that the stop is released. Devices of kOS and hoot obey messages that arrive after the stop. A rig
    /// that has to stay at rest there needs a switch that takes the power from its motors.
    ///
    /// # Errors
    ///
    /// [`NotTaken::Full`] if too many stops wait for a turn.
    fn stop(&mut self) -> Result<(), NotTaken>;
}

/// Request of a session about a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LineRequest {
    /// Open the line, and tell that it is up, or down if it cannot be opened.
    Open,
    /// Close the line. The session knows that it is down.
    Close,
}

/// Next thing to do for a session of type `S`.
pub type TurnOf<S> = Turn<<S as Session>::Destination, <S as Session>::Held>;

/// Next thing to do for a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turn<D, H> {
    /// Send as many bytes from the front of the buffer to this receiver.
    Transmit(D, usize),
    /// Act on the event that [`Session::event`] makes of this.
    Event(H),
    /// Wait until something happens, at most until this time; without a time, as long as it takes.
    Wait(Option<Millis>),
}

/// State of a session between two polls: what its caller wants, and what its machine wants.
#[doc(hidden)]
#[derive(Debug, Clone)]
pub struct Agenda<I, E, const N: usize, const W: usize = { 2 * WISHES }> {
    /// Stops of everything, first to come first.
    urgent: ArrayVec<I, WISHES>,
    /// Other wishes, first to come first, with room for as many stops as for all other wishes.
    wishes: ArrayVec<I, W>,
    /// Whether the link went down, and whether it came up after that.
    link: (bool, bool),
    /// Effects of the last input, last one first.
    effects: ArrayVec<E, N>,
    wake: Option<Millis>,
}

/// Thing that the machine is to be told next.
#[doc(hidden)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum News<I> {
    /// The link is down.
    LinkDown,
    /// The link is up.
    LinkUp,
    /// The caller wants something.
    Wish(I),
}

/// Stream of a link. It lends the frame that came last until bytes are added.
#[doc(hidden)]
#[derive(Debug)]
pub struct Link<F: Framing, const N: usize> {
    frames: TimedFrames<F, N>,
    /// Length of the frame that came last.
    last: usize,
    /// Whether the bytes that are held do not count any more.
    is_stale: bool,
}

impl<F: Framing, const N: usize> Link<F, N> {
    /// Number of bytes that are always taken when nothing more can be had from those that are held.
    pub const PIECE: usize = TimedFrames::<F, N>::PIECE;

    /// Link without bytes.
    #[must_use]
    pub const fn new(patience: Patience) -> Self {
        Self { frames: TimedFrames::new(patience), last: 0, is_stale: false }
    }

    /// Number of bytes that are not dealt with.
    #[must_use]
    pub const fn held(&self) -> usize {
        self.frames.held()
    }

    /// Whether bytes arrived at which [`next`](Self::next) did not look yet.
    #[must_use]
    pub const fn has_unseen(&self) -> bool {
        self.frames.has_unseen()
    }

    /// Bytes of the frame that came last.
    #[must_use]
    pub fn last(&self) -> &[u8] {
        self.frames.taken(self.last)
    }

    /// Time at which the incomplete frame is given up.
    #[must_use]
    pub fn deadline(&self) -> Option<Millis> {
        self.frames.deadline()
    }

    /// Drops what is held.
    fn reset(&mut self) {
        self.frames.reset();
        self.is_stale = false;
    }

    /// Drops what is held before anything more is looked for. The frame that came last is lent until then.
    pub const fn drop_later(&mut self) {
        self.is_stale = true;
    }

    /// Takes bytes, and returns how many.
    pub fn receive(&mut self, now: Millis, bytes: &[u8]) -> usize {
        if self.is_stale {
            self.reset();
        }
        self.frames.push(now, bytes)
    }

    /// Next item of the stream.
    #[expect(clippy::should_implement_trait, reason = "an iterator cannot lend from itself")]
    pub fn next(&mut self) -> Option<Item<'_, F::Frame<'_>, F::Header>> {
        if self.is_stale {
            self.reset();
        }
        let item = self.frames.next()?;
        if let Item::Frame(frame) = &item {
            self.last = frame.as_ref().len();
        }
        Some(item)
    }

    /// Gives up the incomplete frame if its time is over, after there was no next item. Returns whether it did: then there
    /// may be another item.
    pub fn give_up(&mut self, now: Millis) -> bool {
        let is_overdue = self.frames.deadline().is_some_and(|deadline| deadline <= now);
        self.frames.give_up(now);
        is_overdue
    }
}

impl<I, E, const N: usize, const W: usize> Agenda<I, E, N, W> {
    /// Agenda without entries.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            urgent: ArrayVec::new_const(),
            wishes: ArrayVec::new_const(),
            link: (false, false),
            effects: ArrayVec::new_const(),
            // A machine may have something to do from the beginning on.
            wake: Some(Millis(0)),
        }
    }

    /// Notes that the link is up.
    pub fn link_up(&mut self) {
        self.link.1 = true;
    }

    /// Notes that the link is down. Nothing can be sent over it any more.
    pub fn link_down(&mut self, is_event: impl Fn(&E) -> bool) {
        self.link = (true, false);
        self.effects.retain(|effect| is_event(effect));
    }

    /// Notes a stop of everything, which goes before all other wishes. After it, the machine refuses what may move.
    ///
    /// # Errors
    ///
    /// [`NotTaken::Full`].
    pub fn stop_all(&mut self, stop: I) -> Result<(), NotTaken> {
        self.urgent.try_push(stop).map_err(|_| NotTaken::Full)
    }

    /// Notes a stop of one thing, or the report of a rig. It keeps its place after the wishes that came before, because these
    /// may move the same thing. It has room of its own.
    ///
    /// # Errors
    ///
    /// [`NotTaken::Full`].
    pub fn stop_one(&mut self, stop: I) -> Result<(), NotTaken> {
        self.wishes.try_push(stop).map_err(|_| NotTaken::Full)
    }

    /// Notes a wish.
    ///
    /// # Errors
    ///
    /// [`NotTaken::Full`].
    pub fn want(&mut self, wish: I) -> Result<(), NotTaken> {
        if self.wishes.len() < WISHES { self.stop_one(wish) } else { Err(NotTaken::Full) }
    }

    /// Next thing to tell the machine, apart from what arrives on the link and the time.
    pub fn news(&mut self) -> Option<News<I>> {
        if core::mem::take(&mut self.link.0) {
            return Some(News::LinkDown);
        }
        if core::mem::take(&mut self.link.1) {
            return Some(News::LinkUp);
        }
        self.urgent.pop_at(0).or_else(|| self.wishes.pop_at(0)).map(News::Wish)
    }

    /// Whether there is a next thing to tell the machine, apart from what arrives on the link and the time.
    fn has_news(&self) -> bool {
        self.link.0 || self.link.1 || !self.urgent.is_empty() || !self.wishes.is_empty()
    }

    /// Whether the machine has to be woken.
    #[must_use]
    pub fn is_due(&self, now: Millis) -> bool {
        self.wake.is_some_and(|wake| wake <= now)
    }

    /// Time at which the machine has to be woken.
    #[must_use]
    pub const fn wake(&self) -> Option<Millis> {
        self.wake
    }

    /// Takes what follows from an input. All that followed from the last one is done.
    pub fn fill<T, V>(&mut self, output: Output<T, V, N>, hold: impl Fn(Effect<T, V>) -> E) {
        self.wake = output.wake;
        self.effects.clear();
        for effect in output.into_iter().rev() {
            let _ = self.effects.try_push(hold(effect));
        }
    }

    /// Next effect.
    pub fn pop(&mut self) -> Option<E> {
        self.effects.pop()
    }

    /// Takes an effect back that could not be done.
    pub fn put_back(&mut self, effect: E) {
        let _ = self.effects.try_push(effect);
    }

    /// Whether no effect waits.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.effects.is_empty()
    }

    /// Whether neither news nor an effect waits, so that the state of the machine tells everything.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        self.is_idle() && !self.has_news()
    }
}

impl<I, E, const N: usize, const W: usize> Default for Agenda<I, E, N, W> {
    fn default() -> Self {
        Self::new()
    }
}

/// Makes the methods of a session with one link, which has the fields `machine`, `link` and `agenda`, on the side of the `host` or
/// of the `device`.
#[doc(hidden)]
#[macro_export]
macro_rules! session_link {
    ($side:ident impl<$(const $n:ident: $size:ty),*> $session:ty: $machine:ident, $link:ty) => {
        impl<$(const $n: $size),*> $session {
            /// Number of bytes that [`receive`](Self::receive) always takes after [`poll`](Self::poll) said to wait.
            pub const PIECE: usize = <$link>::PIECE;

            /// Machine of the session, for reading its state.
            #[must_use]
            pub const fn machine(&self) -> &$machine {
                &self.machine
            }

            /// Number of bytes that arrived and are not dealt with.
            #[must_use]
            pub const fn held(&self) -> usize {
                self.link.held()
            }

            /// Tells that the link is up. Bytes of an earlier one are dropped.
            pub fn link_up(&mut self) {
                // An event that waits may still lend the message that came last.
                self.link.drop_later();
                self.agenda.link_up();
            }

            /// Tells that the link is down. What was to be sent over it is dropped.
            pub fn link_down(&mut self) {
                self.agenda.link_down(Held::is_event);
            }

            /// Takes bytes that arrived at a moment, and returns how many: at least [`PIECE`](Self::PIECE) if there are so
            /// many, and [`poll`](Self::poll) said to wait before. Give the others again after the next wait.
            #[must_use = "bytes that were not taken have to be given again"]
            pub fn receive(&mut self, now: $crate::time::Millis, bytes: &[u8]) -> usize {
                if self.agenda.is_idle() { self.link.receive(now, bytes) } else { 0 }
            }

            /// Time until which to wait.
            fn until(&self) -> Option<$crate::time::Millis> {
                [self.agenda.wake(), self.link.deadline()].into_iter().flatten().min()
            }
        }

        $crate::session_link! { $side [impl<$(const $n: $size),*>] $session }
    };
    (host [$($impl:tt)*] $session:ty) => {
        $($impl)* $session {
            /// Whether anything may still move because of this host: see [`HostMachine::may_move`]. While a command or an event
            /// waits for a poll, this is not known, and the answer is yes.
            #[must_use]
            pub fn may_move(&self) -> bool {
                self.machine.may_move() || !self.agenda.is_settled()
            }
        }

        $($impl)* $crate::session::HostSession for $session {
            fn may_move(&self) -> bool {
                self.may_move()
            }

            fn stop(&mut self, token: $crate::machine::Token) -> Result<(), $crate::session::NotTaken> {
                self.stop(token)
            }
        }
    };
    (device [$($impl:tt)*] $session:ty) => {
        $($impl)* $session {
            /// Whether bytes arrived that are not dealt with.
            const fn has_unseen(&self) -> bool {
                self.link.has_unseen()
            }
        }

        $crate::session_device! { [$($impl)*] $session }
    };
}

/// Makes `may_move` of the session of a device, which has the fields `machine` and `agenda`, and the method `has_unseen`.
#[doc(hidden)]
#[macro_export]
macro_rules! session_device {
    ([$($impl:tt)*] $session:ty) => {
        $($impl)* $session {
            /// Whether anything may move because of what this device was told: see [`DeviceMachine::may_move`]. While a report,
            /// bytes that arrived or an event wait for a poll, this is not known, and the answer is yes.
            #[must_use]
            pub fn may_move(&self) -> bool {
                self.machine.may_move() || !self.agenda.is_settled() || self.has_unseen()
            }
        }

        $($impl)* $crate::session::DeviceSession for $session {
            fn may_move(&self) -> bool {
                self.may_move()
            }

            fn stop(&mut self) -> Result<(), $crate::session::NotTaken> {
                self.stop()
            }
        }
    };
}

/// Makes what sessions with one line have in common in their implementation of [`Session`]. With `to all`, everything is sent
/// over that line.
#[doc(hidden)]
#[macro_export]
macro_rules! session_line {
    () => {
        type Line = ();
        type Event<'e> = Event<'e>;
        type Held = Held;

        const PIECE: usize = Self::PIECE;

        fn link_up(&mut self, (): ()) -> Result<(), $crate::session::NotTaken> {
            self.link_up();
            Ok(())
        }

        fn link_down(&mut self, (): ()) -> Result<(), $crate::session::NotTaken> {
            self.link_down();
            Ok(())
        }

        fn receive(&mut self, now: $crate::time::Millis, (): (), bytes: &[u8]) -> usize {
            self.receive(now, bytes)
        }
    };
    (to all) => {
        type Destination = ();

        fn reaches((): (), (): ()) -> bool {
            true
        }

        $crate::session_line! {}
    };
}

/// Makes the `Debug` of a session, and its methods that tell its machine something: a variant, and the method with its arguments and those of
/// the variant. Commands have a token, and name the enum that tells their ends; reports have neither.
#[doc(hidden)]
#[macro_export]
macro_rules! session_methods {
    (
        impl<$(const $n:ident: $size:ty),*> $session:ty as $input:ident, see $see:ident $(, with $token:ident)?;
        $($lane:ident {
            $(
                $(#[$meta:meta])*
                $variant:ident $method:ident($($arg:ident: $type:ty),*) $(=> ($($tuple:tt)*))? $(=> {$($fields:tt)*})?;
            )*
        })*
    ) => {
        $crate::session_methods! { each
            [impl<$(const $n: $size),*> $session] [$input $see] [$($token)?]
            $($($lane $(#[$meta])* $variant $method [$($arg: $type),*] [$(($($tuple)*))? $({$($fields)*})?];)*)*
        }
    };
    (each
        [impl<$(const $n:ident: $size:ty),*> $session:ty] [$input:ident $see:ident] $token:tt
        $($lane:ident $(#[$meta:meta])* $variant:ident $method:ident $args:tt $value:tt;)*
    ) => {
        impl<$(const $n: $size),*> core::fmt::Debug for $session {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                let (machine, held) = (&self.machine, self.held());
                f.debug_struct("Session").field("machine", machine).field("held", &held).finish_non_exhaustive()
            }
        }

        impl<$(const $n: $size),*> $session {
            $($crate::session_methods! {
                one $lane $(#[$meta])* [$input $see $variant] $method $args $value $token
            })*
        }
    };
    (one $lane:ident $(#[$meta:meta])* [$input:ident $see:ident $variant:ident] $method:ident
        [$($arg:ident: $type:ty),*] [$($value:tt)*] [$token:ident]
    ) => {
        $(#[$meta])*
        #[doc = concat!("\n\nIts end is that of [`", stringify!($see), "::", stringify!($variant), "`].")]
        ///
        /// # Errors
        ///
        /// [`NotTaken::Full`] if too many commands wait for a poll.
        pub fn $method(&mut self, $token: $crate::machine::Token $(, $arg: $type)*) -> Result<(), NotTaken> {
            self.agenda.$lane(($token, $input::$variant $($value)*))
        }
    };
    (one $lane:ident $(#[$meta:meta])* [$input:ident $see:ident $variant:ident] $method:ident
        [$($arg:ident: $type:ty),*] [$($value:tt)*] []
    ) => {
        $(#[$meta])*
        #[doc = concat!("\n\nMore is told at [`", stringify!($see), "::", stringify!($variant), "`].")]
        ///
        /// # Errors
        ///
        /// [`NotTaken::Full`] if too many reports wait for a poll.
        pub fn $method(&mut self $(, $arg: $type)*) -> Result<(), NotTaken> {
            self.agenda.$lane($input::$variant $($value)*)
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled() -> Agenda<u8, u8, 2> {
        let mut agenda = Agenda::new();
        for number in 0..8 {
            assert_eq!(agenda.want(number), Ok(()));
        }
        agenda
    }

    #[test]
    fn a_stop_of_everything_goes_before_all_that_waits_and_has_room_of_its_own() {
        let mut agenda = filled();
        assert_eq!(agenda.want(8), Err(NotTaken::Full));
        assert_eq!((agenda.stop_one(10), agenda.stop_all(20), agenda.stop_all(21)), (Ok(()), Ok(()), Ok(())));
        for number in [20, 21, 0, 1, 2, 3, 4, 5, 6, 7, 10] {
            assert_eq!(agenda.news(), Some(News::Wish(number)));
        }
        assert_eq!(agenda.news(), None);
    }

    #[test]
    fn the_link_goes_before_all_wishes_and_only_its_last_state_counts() {
        let mut agenda = Agenda::<u8, u8, 2>::new();
        assert!(agenda.is_settled());
        agenda.link_up();
        assert!(!agenda.is_settled());
        let mut agenda = filled();
        assert!(!agenda.is_settled());
        agenda.link_up();
        agenda.link_down(|_| true);
        agenda.link_down(|_| true);
        agenda.link_up();
        assert_eq!(agenda.news(), Some(News::LinkDown));
        assert_eq!(agenda.news(), Some(News::LinkUp));
        assert_eq!(agenda.news(), Some(News::Wish(0)));
    }

    #[test]
    fn nothing_is_sent_over_a_link_that_went_down() {
        let mut agenda = filled();
        let mut output = Output::<u8, u8, 2>::default();
        output.transmit(1);
        output.event(2);
        agenda.fill(output, |effect| match effect {
            Effect::Transmit(number) => 10 + number,
            Effect::Event(number) => number,
        });
        agenda.link_down(|held| *held < 10);
        assert_eq!((agenda.is_idle(), agenda.pop(), agenda.pop()), (false, Some(2), None));
        agenda.put_back(2);
        assert_eq!((agenda.is_idle(), agenda.pop(), agenda.is_idle()), (false, Some(2), true));
    }
}
