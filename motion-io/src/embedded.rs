//! Driver of `embedded_io_async` streams, for firmware and for runtimes other than tokio.
//!
//! The driver does not read while it writes, because these streams cannot do both. Two such drivers could wait for each other if
//! neither has room for a message of the other. A serial port always takes bytes, and the driver on tokio reads while it writes.
//!
//! The main loop of a DMC device, except its motors:
//!
//! ```
//! use dmc_proto::device::{DeviceMachine, Event, Options, Rig, Session};
//! use dmc_proto::message::Hi;
//! use dmc_proto::Patience;
//! use embassy_futures::select::{Either, select};
//! use embedded_io_async::{Read, Write};
//! use motion_io::embedded::{Clock, Driver, Error};
//!
//! trait Board: Rig + Sync {
//!     /// Begins what the event says, and returns at once.
//!     fn obey(&self, event: &Event<'_>);
//!     /// Waits until all motors have come to rest since the last call.
//!     async fn come_to_rest(&self);
//! }
//!
//! async fn run<T: Read + Write>(board: &impl Board, line: T, clock: impl Clock) {
//!     let machine = DeviceMachine::new(Options::of(Hi { motor_count: 4, ..Options::default().hi() }));
//!     let mut driver: Driver<_, _, _, 256> = Driver::new(<Session>::new(machine, Patience::default()), line, clock);
//!     loop {
//!         match select(driver.next(board), board.come_to_rest()).await {
//!             Either::First(Ok(event)) => board.obey(&event),
//!             // The session has stopped everything, because its host is gone.
//!             Either::First(Err(Error::Closed)) => return,
//!             // A bit error, for example. Stops must still be heard.
//!             Either::First(Err(_)) => {}
//!             Either::Second(()) => _ = driver.session_mut().at_rest(),
//!         }
//!     }
//! }
//! ```

use core::fmt;
use core::future::poll_fn;
use core::pin::pin;
use core::task::Poll;

use embedded_io_async::{Read, Write};
use motion_core::session::Session;
use motion_core::time::Millis;
use motion_core::wire::EncodeError;

use crate::flow::{Flow, Next};

/// Number of bytes that are read at once at most.
const PIECE: usize = 64;

/// Clock of a driver.
///
/// With `embassy-time` it is:
///
/// ```
/// # struct Instant;
/// # impl Instant {
/// #     fn now() -> Self { Self }
/// #     fn as_millis(&self) -> u64 { 0 }
/// #     fn from_millis(_: u64) -> Self { Self }
/// # }
/// # struct Timer;
/// # impl Timer { async fn at(_: Instant) {} }
/// use motion_core::time::Millis;
/// use motion_io::embedded::Clock;
///
/// struct Time;
///
/// impl Clock for Time {
///     fn now(&self) -> Millis {
///         Millis(Instant::now().as_millis())
///     }
///
///     async fn until(&self, moment: Millis) {
///         Timer::at(Instant::from_millis(moment.0)).await;
///     }
/// }
/// ```
pub trait Clock {
    /// Time at present.
    fn now(&self) -> Millis;

    /// Waits until this time has come. The future can be dropped at any time.
    fn until(&self, moment: Millis) -> impl Future<Output = ()>;
}

impl<C: Clock> Clock for &C {
    fn now(&self) -> Millis {
        C::now(self)
    }

    fn until(&self, moment: Millis) -> impl Future<Output = ()> {
        C::until(self, moment)
    }
}

/// Error of a driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error<E> {
    /// Reading or writing failed, as a serial port does after a bit error. The line stays up: call again to go on, or
    /// [`replace`](Driver::replace) the stream.
    #[error("the stream failed: {0:?}")]
    Stream(E),
    /// The other end closed the stream, or it takes no more bytes, or the session does not want it any more. The session was
    /// told, and all events were. [`Replace`](Driver::replace) the stream to go on.
    #[error("the stream is closed")]
    Closed,
    /// A message cannot be written. It is lost, and the session goes on. If it is longer than the buffer of the driver, it is
    /// not lost, and the driver needs a longer one.
    #[error("a message cannot be written: {0}")]
    Message(EncodeError),
}

/// Session on a stream, with a buffer of `N` bytes for messages.
///
/// [`next`](Self::next) does everything. It can be dropped at any time, and called again, if reading and writing of the
/// stream can be dropped, as those of buffered serial ports and of TCP sockets. Then no byte is lost in either direction.
pub struct Driver<S: Session, T, C, const N: usize = 1048> {
    flow: Flow<S, [u8; N]>,
    stream: T,
    clock: C,
    is_open: bool,
    /// Whether the stream is another one than that of which the session knows.
    is_fresh: bool,
    /// Whether bytes were written since the last flush.
    is_written: bool,
}

impl<S: Session<Line = ()>, T: Read + Write, C: Clock, const N: usize> Driver<S, T, C, N> {
    /// Makes a driver of this session on an open stream.
    #[must_use]
    pub fn new(session: S, stream: T, clock: C) -> Self {
        Self::on_line(session, (), stream, clock)
    }
}

impl<S: Session, T: Read + Write, C: Clock, const N: usize> Driver<S, T, C, N> {
    /// Makes a driver of one line of this session, on an open stream.
    #[must_use]
    pub fn on_line(session: S, line: S::Line, stream: T, clock: C) -> Self {
        let (is_open, is_fresh, is_written) = (true, true, false);
        Self { flow: Flow::new(session, line, [0; N]), stream, clock, is_open, is_fresh, is_written }
    }

    /// Session, for reading its state.
    #[must_use]
    pub const fn session(&self) -> &S {
        &self.flow.session
    }

    /// Session, for commands. They are obeyed in [`next`](Self::next).
    ///
    /// Only the driver tells the session about its line and its bytes.
    pub const fn session_mut(&mut self) -> &mut S {
        &mut self.flow.session
    }

    /// Time at present, as the session is told.
    #[must_use]
    pub fn now(&self) -> Millis {
        self.clock.now()
    }

    /// Goes on with another stream. The session is told that the line was lost.
    pub fn replace(&mut self, stream: T) {
        if self.flow.is_up() {
            self.flow.down();
        }
        (self.stream, self.is_open, self.is_fresh, self.is_written) = (stream, true, true, false);
    }

    /// Next event of the session, with what `source` has for its messages. Reads, writes and waits until there is one.
    ///
    /// Bytes for receivers that are not at the end of the line are dropped.
    ///
    /// # Errors
    ///
    /// [`Error`].
    pub async fn next(&mut self, source: &S::Source<'_>) -> Result<S::Event<'_>, Error<T::Error>> {
        let held = loop {
            if self.flow.is_over() {
                self.is_open &= self.is_fresh;
            }
            if self.is_open && self.flow.wants_line() {
                self.flow.up();
                self.is_fresh = false;
            }
            if !self.flow.unsent().is_empty() {
                self.is_written = true;
                match self.stream.write(self.flow.unsent()).await.map_err(Error::Stream)? {
                    0 => self.lose(),
                    len => self.flow.written(len),
                }
                continue;
            }
            match self.flow.next(self.clock.now(), source).map_err(Error::Message)? {
                Next::Event(held) => break held,
                Next::Write | Next::Other(..) => {}
                Next::Wait(_) if !self.is_open => return Err(Error::Closed),
                Next::Wait(_) if self.is_written => {
                    self.stream.flush().await.map_err(Error::Stream)?;
                    self.is_written = false;
                }
                Next::Wait(until) => self.wait(until).await?,
            }
        };
        Ok(self.flow.session.event(held))
    }

    fn lose(&mut self) {
        self.flow.down();
        self.is_open = false;
    }

    /// Waits until bytes arrive, at most until this time.
    async fn wait(&mut self, until: Option<Millis>) -> Result<(), Error<T::Error>> {
        let mut piece = [0; PIECE];
        let read = {
            let (stream, clock, is_up) = (&mut self.stream, &self.clock, self.flow.is_up());
            let mut read = pin!(async {
                if !is_up {
                    core::future::pending::<()>().await;
                }
                stream.read(&mut piece).await
            });
            let mut end = pin!(async {
                match until {
                    Some(until) => clock.until(until).await,
                    None => core::future::pending().await,
                }
            });
            poll_fn(|cx| match read.as_mut().poll(cx) {
                Poll::Ready(read) => Poll::Ready(Some(read)),
                Poll::Pending => end.as_mut().poll(cx).map(|()| None),
            })
            .await
        };
        match read.transpose().map_err(Error::Stream)? {
            None => {}
            Some(0) => self.lose(),
            // A session takes a piece after it said to wait.
            Some(len) => _ = self.flow.receive(self.clock.now(), piece.get(..len).unwrap_or_default()),
        }
        Ok(())
    }
}

impl<S: Session + fmt::Debug, T, C, const N: usize> fmt::Debug for Driver<S, T, C, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (session, is_open) = (&self.flow.session, self.is_open);
        f.debug_struct("Driver").field("session", session).field("is_open", &is_open).finish_non_exhaustive()
    }
}
