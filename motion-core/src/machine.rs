//! State machines as pure functions: what happened goes in, what follows comes out.
//!
//! A machine knows one side of a protocol: when to send what, what a silence means, what may never be repeated. It has no
//! socket and no clock, and calls nobody: it is a value, and a step makes the next one of it. So it can be stored,
//! compared, replayed and explored; and one loop drives any of them.
//!
//! ```
//! use motion_core::machine::{self, Machine};
//! use motion_core::time::Millis;
//!
//! /// Says "ping" every second, until it hears something.
//! #[derive(Clone, PartialEq, Eq, Hash, Default)]
//! struct Pinger {
//!     heard: bool,
//!     next: Option<Millis>,
//! }
//!
//! enum Input {
//!     Start,
//!     Heard,
//!     Wake,
//! }
//!
//! type Output = machine::Output<&'static str, &'static str, 1, 1>;
//!
//! impl Machine for Pinger {
//!     type Input<'a> = Input;
//!     type Output = Output;
//!
//!     fn step(mut self, now: Millis, input: Input) -> (Self, Output) {
//!         let mut output = Output::default();
//!         match input {
//!             Input::Heard if !self.heard => {
//!                 self = Self { heard: true, next: None };
//!                 output.event("somebody is there");
//!             }
//!             Input::Heard => {}
//!             Input::Start => self.next = Some(now),
//!             Input::Wake => {}
//!         }
//!         if self.next.is_some_and(|next| now >= next) {
//!             output.send("ping");
//!             self.next = Some(now.after(1000));
//!         }
//!         output.wake = self.next;
//!         (self, output)
//!     }
//! }
//!
//! let (pinger, output) = Pinger::default().step(Millis(5), Input::Start);
//! assert_eq!((&output.send[..], output.wake), (&["ping"][..], Some(Millis(1005))));
//! let (pinger, output) = pinger.step(Millis(1005), Input::Wake);
//! assert_eq!(output.send[..], ["ping"]);
//! let (_, output) = pinger.step(Millis(1200), Input::Heard);
//! assert_eq!((&output.events[..], output.wake), (&["somebody is there"][..], None));
//! ```
//!
//! # What holds of every machine of this family
//!
//! - The same state, moment and input give the same state and output.
//! - A wake is later than the moment of the step. To wake a machine too early, or once more, changes nothing but the
//!   time it knows of; to wake it late is to be late, no more.
//! - Time may stand still between two steps. Should it run backwards, what waits for a moment waits longer, and nothing
//!   else happens.
//! - An output holds all that follows, in the order in which it is to be sent or told. Nothing follows later without an
//!   input.

use arrayvec::ArrayVec;

use crate::time::Millis;

/// One side of a protocol, or a part of it.
pub trait Machine: Sized {
    /// What happened; it may borrow, for nothing of it stays in the machine.
    type Input<'a>;
    /// What follows from it.
    type Output;

    /// Takes what happened at a moment.
    #[must_use]
    fn step(self, now: Millis, input: Self::Input<'_>) -> (Self, Self::Output);
}

/// All that follows from a step: at most `SENDS` things to send, and `EVENTS` to tell the application.
///
/// The capacities are the greatest numbers that one step of the machine can need. Should a machine ever need more, that
/// is an error of this library, which its tests, model checks and fuzz targets look for; [`lost`](Self::lost) counts it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[must_use]
pub struct Output<Send, Event, const SENDS: usize, const EVENTS: usize> {
    /// What to send, in this order.
    pub send: ArrayVec<Send, SENDS>,
    /// What happened, in this order.
    pub events: ArrayVec<Event, EVENTS>,
    /// When to wake the machine, if nothing happens before; `None` for never.
    pub wake: Option<Millis>,
    lost: u16,
}

impl<Send, Event, const SENDS: usize, const EVENTS: usize> Output<Send, Event, SENDS, EVENTS> {
    /// Adds what is to be sent next.
    pub fn send(&mut self, send: Send) {
        if self.send.try_push(send).is_err() {
            self.lost = self.lost.saturating_add(1);
        }
    }

    /// Adds what happened next.
    pub fn event(&mut self, event: Event) {
        if self.events.try_push(event).is_err() {
            self.lost = self.lost.saturating_add(1);
        }
    }

    /// Moves the wake to a moment, unless it is earlier already.
    pub fn wake_by(&mut self, moment: Millis) {
        self.wake = Some(self.wake.map_or(moment, |wake| wake.min(moment)));
    }

    /// Whether nothing is to be sent, and nothing happened.
    #[must_use]
    pub fn is_quiet(&self) -> bool {
        self.send.is_empty() && self.events.is_empty()
    }

    /// How much had no room: 0.
    #[must_use]
    pub const fn lost(&self) -> u16 {
        self.lost
    }
}

impl<Send, Event, const SENDS: usize, const EVENTS: usize> Default for Output<Send, Event, SENDS, EVENTS> {
    fn default() -> Self {
        Self { send: ArrayVec::new(), events: ArrayVec::new(), wake: None, lost: 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_room_is_counted() {
        let mut output = Output::<u8, u8, 1, 2>::default();
        assert!(output.is_quiet());
        for number in 0..3 {
            output.send(number);
            output.event(number);
        }
        assert_eq!((&output.send[..], &output.events[..], output.lost()), (&[0][..], &[0, 1][..], 3));
        assert!(!output.is_quiet());
    }

    #[test]
    fn the_earliest_wake_counts() {
        let mut output = Output::<u8, u8, 1, 1>::default();
        output.wake_by(Millis(5));
        output.wake_by(Millis(7));
        assert_eq!(output.wake, Some(Millis(5)));
        output.wake_by(Millis(3));
        assert_eq!(output.wake, Some(Millis(3)));
    }
}
