//! Questions of a client that are not answered yet: one of a kind, because nothing in an answer tells which question it
//! belongs to.

use motion_core::time::Millis;

use super::Token;
use super::input::Get;

/// Party that asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Asker {
    /// The machine itself.
    Machine,
    /// The application, by the command with this token.
    Application(Token),
}

/// Question that is asked after a stop: when it is answered, so is all that was sent before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Fence {
    /// No question is needed.
    Down,
    /// The question was sent; the number counts how often.
    Up(u8),
    /// A question is under way that was asked before the last stop; it will be asked again.
    Late,
    /// The question was not answered over TCP. Late answers can be ruled out only by another connection, which is made at
    /// this time: the call that finds it out has much to tell already.
    Stale(Millis),
}

/// Question that is not answered yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Pending {
    asker: Asker,
    until: Millis,
}

/// All questions that are not answered yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(super) struct Requests([Option<Pending>; Get::ALL.len()]);

impl Requests {
    fn place(&mut self, get: Get) -> Option<&mut Option<Pending>> {
        self.0.iter_mut().zip(Get::ALL).find_map(|(place, this)| (this == get).then_some(place))
    }

    /// Notes a question; `false` if it is asked already.
    pub(super) fn ask(&mut self, get: Get, asker: Asker, until: Millis) -> bool {
        match self.place(get) {
            Some(place @ None) => {
                *place = Some(Pending { asker, until });
                true
            }
            _ => false,
        }
    }

    /// Ends a question, and returns who asked it, if anybody did.
    pub(super) fn end(&mut self, get: Get) -> Option<Asker> {
        self.place(get)?.take().map(|pending| pending.asker)
    }

    /// Gives a question more time, because a part of its answer came.
    pub(super) fn go_on(&mut self, get: Get, until: Millis) {
        if let Some(pending) = self.place(get).and_then(Option::as_mut) {
            pending.until = until;
        }
    }

    /// Returns a question whose time is over.
    pub(super) fn expired(&self, now: Millis) -> Option<Get> {
        let late = |place: &Option<Pending>| place.is_some_and(|pending| pending.until <= now);
        self.0.iter().zip(Get::ALL).find_map(|(place, get)| late(place).then_some(get))
    }

    pub(super) fn deadline(&self) -> Option<Millis> {
        self.0.iter().flatten().map(|pending| pending.until).min()
    }
}
