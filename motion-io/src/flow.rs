//! Part that all drivers share: a session, the bytes that it sends, and what it knows about its line.

use core::mem;
use core::ops::Range;

use motion_core::session::{LineRequest, Session, Turn};
use motion_core::time::Millis;
use motion_core::wire::EncodeError;

/// Buffer for messages.
pub(crate) trait Buffer: AsRef<[u8]> + AsMut<[u8]> {
    /// Makes room for as many bytes. Returns false if that cannot be.
    fn grow(&mut self, needed: usize) -> bool;
}

impl<const N: usize> Buffer for [u8; N] {
    fn grow(&mut self, _: usize) -> bool {
        false
    }
}

#[cfg(feature = "std")]
impl Buffer for std::vec::Vec<u8> {
    fn grow(&mut self, needed: usize) -> bool {
        let grows = self.len() < needed;
        self.resize(self.len().max(needed), 0);
        grows
    }
}

/// Next thing to do for a driver.
pub(crate) enum Next<D, H> {
    /// Write the [unsent](Flow::unsent) bytes to the line.
    Write,
    /// Give as many bytes from the front of the buffer to a receiver that is not at the end of the line.
    #[cfg_attr(not(feature = "std"), expect(dead_code, reason = "the driver for firmware drops these bytes"))]
    Other(D, usize),
    /// Lend this event to the application.
    Event(H),
    /// Wait until something happens, at most until this time.
    Wait(Option<Millis>),
}

pub(crate) type NextOf<S> = Next<<S as Session>::Destination, <S as Session>::Held>;

/// Session with the bytes that it sends.
pub(crate) struct Flow<S: Session, B> {
    pub(crate) session: S,
    line: S::Line,
    out: B,
    unsent: Range<usize>,
    /// Whether the session wants its line.
    is_wanted: bool,
    /// Whether the session is told, or will be told, that its line is up.
    is_up: bool,
    /// Whether the session has to be told that its line is down, and after that, that it is up.
    news: (bool, bool),
    /// Whether the session wants its line closed.
    is_over: bool,
}

impl<S: Session, B: Buffer> Flow<S, B> {
    pub(crate) fn new(session: S, line: S::Line, out: B) -> Self {
        let (unsent, is_wanted, is_up, news, is_over) = (0..0, !S::ASKS, false, (false, false), false);
        Self { session, line, out, unsent, is_wanted, is_up, news, is_over }
    }

    /// Whether the session wants a line and has none.
    pub(crate) fn wants_line(&self) -> bool {
        self.is_wanted && !self.is_up
    }

    /// Whether the line is up.
    pub(crate) fn is_up(&self) -> bool {
        self.is_up
    }

    /// Whether the session wants its line closed. Returns true once.
    pub(crate) fn is_over(&mut self) -> bool {
        mem::take(&mut self.is_over)
    }

    /// Bytes that have to be written before anything else is done.
    pub(crate) fn unsent(&self) -> &[u8] {
        self.out.as_ref().get(self.unsent.clone()).unwrap_or_default()
    }

    /// Bytes from the front of the buffer.
    #[cfg(feature = "std")]
    pub(crate) fn front(&self, len: usize) -> &[u8] {
        self.out.as_ref().get(..len).unwrap_or_default()
    }

    /// Notes that so many bytes are written.
    pub(crate) fn written(&mut self, len: usize) {
        self.unsent.start = self.unsent.start.saturating_add(len);
    }

    /// Drops the bytes that are to be written.
    #[cfg(feature = "std")]
    pub(crate) fn drop_unsent(&mut self) {
        self.unsent = 0..0;
    }

    /// Notes that the line is up.
    pub(crate) fn up(&mut self) {
        (self.is_up, self.news.1) = (true, true);
    }

    /// Notes that the line is down, or cannot be opened.
    pub(crate) fn down(&mut self) {
        self.cut();
        self.news = (true, false);
    }

    fn cut(&mut self) {
        (self.is_up, self.is_wanted, self.unsent, self.news.1) = (false, !S::ASKS, 0..0, false);
    }

    /// Gives bytes that arrived to the session, and returns how many it took.
    pub(crate) fn receive(&mut self, now: Millis, bytes: &[u8]) -> usize {
        let piece = bytes.get(..S::PIECE).unwrap_or(bytes);
        self.session.receive(now, self.line, piece)
    }

    /// Next thing to do. Everything that was to be written is written.
    pub(crate) fn next(&mut self, now: Millis, source: &S::Source<'_>) -> Result<NextOf<S>, EncodeError> {
        loop {
            self.tell();
            match self.session.turn(now, source, self.out.as_mut()) {
                Err(EncodeError::BufferTooSmall { needed, .. }) if self.out.grow(needed) => {}
                Err(error) => return Err(error),
                Ok(Turn::Transmit(to, len)) if S::reaches(to, self.line) => {
                    // What is for a line that is gone is dropped.
                    if self.is_up {
                        self.unsent = 0..len;
                        return Ok(Next::Write);
                    }
                }
                Ok(Turn::Transmit(to, len)) => return Ok(Next::Other(to, len)),
                Ok(Turn::Event(held)) => {
                    match S::request(&held, self.line) {
                        Some(LineRequest::Open) => self.is_wanted = true,
                        Some(LineRequest::Close) => {
                            self.cut();
                            self.is_over = true;
                        }
                        None => {}
                    }
                    return Ok(Next::Event(held));
                }
                // The session had no room for the news about its line. It has now.
                Ok(Turn::Wait(_)) if self.news != (false, false) => {}
                Ok(Turn::Wait(until)) => return Ok(Next::Wait(until)),
            }
        }
    }

    /// Tells the session the news about its line.
    fn tell(&mut self) {
        if self.news.0 && self.session.link_down(self.line).is_ok() {
            self.news.0 = false;
        }
        if self.news == (false, true) && self.session.link_up(self.line).is_ok() {
            self.news.1 = false;
        }
    }
}
