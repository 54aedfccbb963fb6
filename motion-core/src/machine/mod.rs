//! State machines without I/O: an input goes in, and all that follows from it comes out.
//!
//! A machine knows one side of a protocol: when to send which message, what a silence means, and what must never be sent
//! twice. It has no socket, no clock and no callback. It is a value that can be stored, compared, replayed and explored.
//!
//! # The contract of all machines
//!
//! 1. Call [`advance`](Machine::advance) with the time and an input whenever something happened: a link came up, a message
//!    arrived, the application wants something, or the time of the last wake has come.
//! 2. Carry out the [effects](Output::effects) in the order in which they stand: send what is to be
//!    [transmitted](Effect::Transmit), and act on each [event](Effect::Event). A stop stands before anybody is told of it.
//! 3. Wait until something happens, at most until [`wake`](Output::wake).
//!
//! Each effect is complete: it carries what it is about, or borrows it from the input. Nothing refers to an earlier call.
//!
//! ```
//! use motion_core::machine::{Effect, Machine, Output};
//! use motion_core::time::Millis;
//!
//! /// Sends a ping every second until it hears something.
//! #[derive(Clone, PartialEq, Eq, Hash, Default)]
//! struct Pinger {
//!     next: Option<Millis>,
//! }
//!
//! enum Input<'a> {
//!     LinkUp,
//!     Received(&'a str),
//!     Wake,
//! }
//!
//! impl Machine for Pinger {
//!     type Input<'a> = Input<'a>;
//!     type Output<'a> = Output<&'static str, &'a str, 2>;
//!
//!     fn advance<'a>(&mut self, now: Millis, input: Self::Input<'a>) -> Self::Output<'a> {
//!         let mut output = Output::default();
//!         match input {
//!             Input::LinkUp => self.next = Some(now),
//!             Input::Received(text) => {
//!                 self.next = None;
//!                 output.event(text);
//!             }
//!             Input::Wake => {}
//!         }
//!         if self.next.is_some_and(|next| now >= next) {
//!             output.transmit("ping");
//!             self.next = Some(now.after(1000));
//!         }
//!         output.wake = self.next;
//!         output
//!     }
//! }
//!
//! let mut pinger = Pinger::default();
//! let output = pinger.advance(Millis(5), Input::LinkUp);
//! assert_eq!((&output.effects[..], output.wake), (&[Effect::Transmit("ping")][..], Some(Millis(1005))));
//!
//! // The same as a pure function: the old machine stays as it was.
//! let (_, output) = pinger.clone().step(Millis(1005), Input::Wake);
//! assert_eq!(output.effects[..], [Effect::Transmit("ping")]);
//!
//! let heard = String::from("pong");
//! let output = pinger.advance(Millis(1000), Input::Received(&heard));
//! assert_eq!((&output.effects[..], output.wake), (&[Effect::Event("pong")][..], None));
//! ```
//!
//! # Laws of all machines
//!
//! - The same machine, time and input give the same machine and output.
//! - A wake is later than the time of the call. Waking a machine too early or too often changes nothing except the time
//!   that it knows. Waking it late makes it late, no more.
//! - Time may stand still between two calls. If it runs backwards, deadlines come later, and nothing else happens.
//! - All that follows from an input is in its output. Nothing follows later without an input.

mod macros;

use core::fmt;

use arrayvec::ArrayVec;

use crate::time::Millis;

/// Name that the application gives to something it asks of a machine.
///
/// The machine hands the token back with the end of what was asked, exactly once. The application chooses the number; two
/// requests under way with the same token cannot be told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Token(pub u32);

impl fmt::Display for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// State machine of one side of a protocol, or of a part of it.
pub trait Machine: Sized {
    /// Something that happened. It may borrow: nothing of it stays in the machine.
    type Input<'a>;
    /// All that follows from an input. It may borrow from the input.
    type Output<'a>;

    /// Takes an input at a moment and returns all that follows from it, in order.
    fn advance<'a>(&mut self, now: Millis, input: Self::Input<'a>) -> Self::Output<'a>;

    /// Returns the next machine and all that follows from an input: [`advance`](Self::advance) as a pure function.
    #[must_use]
    fn step(mut self, now: Millis, input: Self::Input<'_>) -> (Self, Self::Output<'_>) {
        let output = self.advance(now, input);
        (self, output)
    }
}

/// One thing that follows from an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Effect<Transmit, Event> {
    /// Something to send.
    Transmit(Transmit),
    /// Something to tell: on the side of a host to the application, on the side of a device to the rig.
    Event(Event),
}

/// All that follows from an input: at most `N` effects, and when to wake the machine.
///
/// `N` is the greatest number of effects that one call of the machine can need. If a machine ever needed more, that would
/// be an error of this library, which its tests, model checks and fuzz targets look for.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[must_use]
pub struct Output<Transmit, Event, const N: usize> {
    /// Effects, in the order in which they are to be carried out.
    pub effects: ArrayVec<Effect<Transmit, Event>, N>,
    /// Time at which to wake the machine if nothing happens before; `None` for never.
    pub wake: Option<Millis>,
    lost: u16,
}

impl<Transmit, Event, const N: usize> Output<Transmit, Event, N> {
    /// Adds something to send.
    pub fn transmit(&mut self, transmit: Transmit) {
        self.push(Effect::Transmit(transmit));
    }

    /// Adds something to tell.
    pub fn event(&mut self, event: Event) {
        self.push(Effect::Event(event));
    }

    // In firmware the code has to be short, because it has to be stored.
    #[cfg_attr(target_os = "none", inline(never))]
    fn push(&mut self, effect: Effect<Transmit, Event>) {
        if self.effects.try_push(effect).is_err() {
            self.lost = self.lost.saturating_add(1);
        }
    }

    /// Moves the wake to a moment, unless it is earlier already.
    pub fn wake_by(&mut self, moment: Millis) {
        self.wake = Some(self.wake.map_or(moment, |wake| wake.min(moment)));
    }

    /// Things to send, in order, without the events between them.
    pub fn transmits(&self) -> impl DoubleEndedIterator<Item = &Transmit> {
        self.effects.iter().filter_map(|effect| match effect {
            Effect::Transmit(transmit) => Some(transmit),
            Effect::Event(_) => None,
        })
    }

    /// Events, in order, without the things to send between them.
    pub fn events(&self) -> impl DoubleEndedIterator<Item = &Event> {
        self.effects.iter().filter_map(|effect| match effect {
            Effect::Transmit(_) => None,
            Effect::Event(event) => Some(event),
        })
    }

    /// Takes over another output, of whose effects it makes others.
    #[doc(hidden)]
    pub fn take_over<T, E>(
        &mut self,
        other: &Output<T, E, N>,
        mut of: impl FnMut(&Effect<T, E>) -> Effect<Transmit, Event>,
    ) {
        (self.wake, self.lost) = (other.wake, other.lost);
        for effect in &other.effects {
            self.push(of(effect));
        }
    }

    /// Number of effects that had no room, which is 0.
    #[doc(hidden)]
    #[must_use]
    pub const fn lost(&self) -> u16 {
        self.lost
    }
}

impl<Transmit, Event, const N: usize> Default for Output<Transmit, Event, N> {
    fn default() -> Self {
        Self { effects: ArrayVec::new(), wake: None, lost: 0 }
    }
}

impl<Transmit, Event, const N: usize> IntoIterator for Output<Transmit, Event, N> {
    type Item = Effect<Transmit, Event>;
    type IntoIter = arrayvec::IntoIter<Self::Item, N>;

    /// Iterates over the effects, in order. Read [`wake`](Self::wake) before.
    fn into_iter(self) -> Self::IntoIter {
        self.effects.into_iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn effects_keep_their_order_and_those_without_room_are_counted() {
        let mut output = Output::<u8, u8, 3>::default();
        for number in 0..2 {
            output.event(number);
            output.transmit(number);
        }
        assert_eq!(output.effects[..], [Effect::Event(0), Effect::Transmit(0), Effect::Event(1)]);
        assert_eq!(output.lost(), 1);
        assert_eq!(
            (output.transmits().collect::<Vec<_>>(), output.events().collect::<Vec<_>>()),
            (std::vec![&0], std::vec![&0, &1])
        );
        assert_eq!(output.into_iter().count(), 3);
    }

    #[test]
    fn the_earliest_wake_counts() {
        let mut output = Output::<u8, u8, 1>::default();
        output.wake_by(Millis(5));
        output.wake_by(Millis(7));
        assert_eq!(output.wake, Some(Millis(5)));
        output.wake_by(Millis(3));
        assert_eq!(output.wake, Some(Millis(3)));
    }
}
