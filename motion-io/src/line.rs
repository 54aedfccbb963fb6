//! Part that the drivers on an operating system share: a session with its line, which is opened, lost, and opened again.

use std::boxed::Box;
use std::convert::Infallible;
use std::string::{String, ToString};
use std::time::Duration;
use std::vec::Vec;
use std::{format, io, vec};

use motion_core::session::Session;
use motion_core::time::Millis;

use crate::LAST;
use crate::error::Error;
use crate::flow::{Flow, Next};
use crate::reconnect::Attempts;

/// Function that sends bytes to receivers that are not at the end of the line.
pub(crate) type Others<D> = Box<dyn FnMut(D, &[u8]) + Send>;

/// Way to open a line again. `F` is an attempt.
pub(crate) struct Reopen<S, F> {
    attempts: Attempts<S>,
    open: Box<dyn FnMut() -> F + Send>,
}

impl<S, F> Reopen<S, F> {
    pub(crate) fn new(attempts: Attempts<S>, open: impl FnMut() -> F + Send + 'static) -> Self {
        Self { attempts, open: Box::new(open) }
    }
}

/// Session with its line, which is a stream of type `T`. Drivers read, write, wait, and end the attempts `F` to open it.
pub(crate) struct Line<S: Session, T, F> {
    /// Boxed, because the sessions of kOS are long, and drivers move.
    pub(crate) flow: Box<Flow<S, Vec<u8>>>,
    pub(crate) stream: Option<T>,
    /// Room for the bytes of one read.
    pub(crate) piece: Vec<u8>,
    /// Bytes that arrived and are not given to the session.
    pub(crate) arrived: Vec<u8>,
    /// Time at which the line is lost, and the reason. Until then it is only read.
    end: Option<(Millis, String)>,
    pub(crate) reopen: Option<Reopen<S, F>>,
    /// Attempt to open the line.
    pub(crate) opening: Option<F>,
    pub(crate) others: Option<Others<S::Destination>>,
    /// Name of the line in errors.
    pub(crate) name: String,
    /// Whether bytes ever arrived.
    has_answered: bool,
    pub(crate) trouble: Option<Error>,
}

impl<S: Session, T, F> Line<S, T, F> {
    pub(crate) fn new(session: S, line: S::Line, stream: Option<T>) -> Self {
        Self {
            flow: Box::new(Flow::new(session, line, Vec::new())),
            stream,
            piece: vec![0; S::PIECE],
            arrived: Vec::new(),
            end: None,
            reopen: None,
            opening: None,
            others: None,
            name: "the line".into(),
            has_answered: false,
            trouble: None,
        }
    }

    /// Closes the line that the session does not want any more, tells the session of the line that it wants, or begins to open
    /// it.
    pub(crate) fn care(&mut self, now: Millis) {
        if self.flow.is_over() {
            self.hang_up(now);
        }
        if !self.flow.wants_line() || self.opening.is_some() {
            return;
        }
        if self.stream.is_some() {
            self.flow.up();
        } else if let Some(reopen) = self.reopen.as_mut().filter(|reopen| S::ASKS || reopen.attempts.at <= now) {
            self.opening = Some((reopen.open)());
        }
    }

    /// Handles the end of an attempt to open the line.
    pub(crate) fn opened(&mut self, now: Millis, opened: Result<T, Error>) {
        self.opening = None;
        let Some(reopen) = &mut self.reopen else { return };
        match opened {
            Ok(stream) => {
                reopen.attempts.opened(&mut self.flow.session);
                self.stream = Some(stream);
            }
            Err(why) => {
                self.trouble = Some(why);
                if S::ASKS {
                    self.flow.down();
                }
                if !reopen.attempts.failed(now) {
                    self.reopen = None;
                }
            }
        }
    }

    /// Gives up the attempt to open the line that is in progress, so that the next one begins afresh.
    #[cfg(feature = "tokio")]
    pub(crate) fn give_up_opening(&mut self) {
        if self.opening.take().is_some() && S::ASKS {
            self.flow.down();
        }
    }

    /// Next thing to do. Bytes for other receivers are sent. A line that ends is lost after all that arrived is handled.
    pub(crate) fn next(&mut self, now: Millis, source: &S::Source<'_>) -> Result<Next<Infallible, S::Held>, Error> {
        loop {
            if !self.flow.unsent().is_empty() {
                if self.end.is_none() {
                    return Ok(Next::Write);
                }
                self.flow.drop_unsent();
            }
            // What arrived goes before what is due. Otherwise a busy computer could miss an answer in time.
            self.give(now);
            match self.flow.next(now, source).map_err(Error::Message)? {
                Next::Event(held) => return Ok(Next::Event(held)),
                Next::Write => {}
                Next::Other(to, len) => {
                    if let Some(send) = &mut self.others {
                        send(to, self.flow.front(len));
                    }
                }
                Next::Wait(_) if self.give(now) > 0 => {}
                Next::Wait(until) => match &self.end {
                    Some((end, why)) if *end <= now => {
                        self.trouble = Some(self.gone(why));
                        self.flow.down();
                        self.hang_up(now);
                    }
                    _ if self.stream.is_none() && self.reopen.is_none() => {
                        return Err(self.trouble.clone().unwrap_or_else(|| self.closed()));
                    }
                    end => {
                        let is_opening = self.opening.is_some() || !self.flow.wants_line();
                        let attempt = self.reopen.as_ref().filter(|_| !is_opening).map(|reopen| reopen.attempts.at);
                        let end = end.as_ref().map(|(end, _)| *end);
                        return Ok(Next::Wait([until, attempt, end].into_iter().flatten().min()));
                    }
                },
            }
        }
    }

    /// Gives bytes that arrived to the session, and returns how many it took.
    fn give(&mut self, now: Millis) -> usize {
        let taken = self.flow.receive(now, &self.arrived);
        self.arrived.drain(..taken);
        taken
    }

    fn hang_up(&mut self, now: Millis) {
        // The oldest supported Rust knows no `let` chains.
        let session = &self.flow.session;
        if self.reopen.as_mut().is_some_and(|reopen| !reopen.attempts.lost(now, session)) {
            self.reopen = None;
        }
        (self.stream, self.opening, self.end) = (None, None, None);
        self.arrived.clear();
    }

    /// Handles the end of a read.
    pub(crate) fn has_read(&mut self, now: Millis, read: io::Result<usize>) {
        match read {
            Ok(0) => self.ends(now, "the other end closed it"),
            Ok(len) => {
                self.arrived.extend_from_slice(self.piece.get(..len).unwrap_or_default());
                self.has_answered = true;
                if let Some(reopen) = &mut self.reopen {
                    reopen.attempts.works();
                }
            }
            Err(error) => self.ends(now, &broken(&error)),
        }
    }

    /// Handles the end of a write.
    pub(crate) fn has_written(&mut self, now: Millis, written: io::Result<usize>) {
        match written {
            Ok(0) => self.cannot_write(now, "it takes no more bytes"),
            Ok(len) => self.flow.written(len),
            Err(error) => self.cannot_write(now, &broken(&error)),
        }
    }

    /// Notes that the line takes no bytes.
    pub(crate) fn cannot_write(&mut self, now: Millis, why: &str) {
        self.ends(now.after(LAST), why);
    }

    /// Notes that the line is lost at this time at the latest. The first reason is told.
    fn ends(&mut self, at: Millis, why: &str) {
        let (end, _) = self.end.get_or_insert_with(|| (at, why.into()));
        *end = at.min(*end);
    }

    /// Loss of the line.
    fn gone(&self, why: &str) -> Error {
        let advice = if self.has_answered { ": check" } else { " before it answered: check its protocol," };
        Error::Lost { what: self.name.clone(), why: format!("{why}{advice} its cable and its power") }
    }

    /// End of the line that no error caused.
    fn closed(&self) -> Error {
        Error::not_opened(&self.name, "it is closed, and the driver cannot open it again")
    }
}

/// Reason why a line is lost, by an error of its stream.
fn broken(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::BrokenPipe | io::ErrorKind::ConnectionReset => "the other end closed it".into(),
        _ => error.to_string(),
    }
}

/// Time since a start, as a session is told.
pub(crate) fn millis(since: Duration) -> Millis {
    Millis(u64::try_from(since.as_millis()).unwrap_or(u64::MAX))
}

/// Makes the methods that the drivers on an operating system have in common.
macro_rules! driver_methods {
    ($($field:ident: $value:expr)?) => {
        impl<S: Session<Line = ()>, T> Driver<S, T> {
            /// Makes a driver of this session on an open stream, which must not hold bytes back: it is never flushed.
            #[must_use]
            pub fn new(session: S, stream: T) -> Self {
                Self::on_line(session, (), stream)
            }

            /// Makes a driver of this session without a stream. [`reconnecting`](Self::reconnecting) or
            /// [`reopening`](Self::reopening) says how it is opened: at once, or when the session asks for its line.
            #[must_use]
            pub fn unopened(session: S) -> Self {
                Self::with_stream(session, (), None)
            }
        }

        impl<S: Session, T> Driver<S, T> {
            /// Makes a driver of one line of this session, on an open stream, as [`new`](Self::new).
            #[must_use]
            pub fn on_line(session: S, line: S::Line, stream: T) -> Self {
                Self::with_stream(session, line, Some(stream))
            }

            fn with_stream(session: S, line: S::Line, stream: Option<T>) -> Self {
                Self { line: Line::new(session, line, stream), start: Instant::now() $(, $field: $value)? }
            }

            /// Sets the name of the line in errors, such as the name of the rig. Without it, that is "the line".
            #[must_use]
            pub fn named(mut self, name: impl Into<String>) -> Self {
                self.line.name = name.into();
                self
            }

            /// Gives bytes for receivers that are not at the end of the line to this function, such as datagrams. Without it they
            /// are dropped.
            #[must_use]
            pub fn with_others(mut self, send: impl FnMut(S::Destination, &[u8]) + Send + 'static) -> Self {
                self.line.others = Some(Box::new(send));
                self
            }

            /// Session, for reading its state.
            #[must_use]
            pub fn session(&self) -> &S {
                &self.line.flow.session
            }

            /// Session, for commands. They are obeyed in [`next`](Self::next).
            ///
            /// Only the driver tells the session about its line and its bytes.
            pub fn session_mut(&mut self) -> &mut S {
                &mut self.line.flow.session
            }

            /// Whether there is an open line.
            #[must_use]
            pub const fn is_open(&self) -> bool {
                self.line.stream.is_some()
            }

            /// Number of bytes that the session sent and that are not written yet.
            #[must_use]
            pub fn unsent(&self) -> usize {
                self.line.flow.unsent().len()
            }

            /// Reason why there is no line at present, or why there was none the last time.
            #[must_use]
            pub const fn trouble(&self) -> Option<&Error> {
                self.line.trouble.as_ref()
            }

            /// Time since the driver was made, as the session is told.
            #[must_use]
            pub fn now(&self) -> Millis {
                $crate::line::millis(self.start.elapsed())
            }
        }

        impl<S: Session + fmt::Debug, T> fmt::Debug for Driver<S, T> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                let (session, is_open) = (self.session(), self.is_open());
                f.debug_struct("Driver").field("session", session).field("is_open", &is_open).finish_non_exhaustive()
            }
        }
    };
}
pub(crate) use driver_methods;
