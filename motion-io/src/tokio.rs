//! Driver of asynchronous streams on tokio.

use std::boxed::Box;
use std::fmt;
use std::future::{pending, poll_fn};
use std::pin::{Pin, pin};
use std::string::{String, ToString};
use std::task::{Context, Poll, ready};
use std::time::Duration;
use std::vec::Vec;
use std::{io, vec};

use ::tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use ::tokio::net::{TcpStream, ToSocketAddrs};
use ::tokio::task::{consume_budget, yield_now};
use ::tokio::time::{Instant, sleep_until, timeout};
use motion_core::session::{DeviceSession, HostSession, Session};
use motion_core::time::Millis;

use crate::error::{Error, Label, broken};
use crate::flow::{Flow, Next, driver_methods};
use crate::reconnect::{Attempts, Reconnect};
use crate::{CONNECT, STALLED};

/// Greatest delay of the end of a time, on a line that is never silent.
const LATE: Duration = Duration::from_millis(100);

/// Attempt to open a line.
type Opening<T> = Pin<Box<dyn Future<Output = Result<T, Error>> + Send>>;

/// Way to open a line again.
struct Reopen<S, T> {
    attempts: Attempts<S>,
    open: Box<dyn FnMut() -> Opening<T> + Send>,
    opening: Option<Opening<T>>,
}

/// Function that sends bytes to receivers that are not at the end of the line.
type Others<D> = Box<dyn FnMut(D, &[u8]) + Send>;

/// Session on a stream.
///
/// [`next`](Self::next) does everything. It can be dropped at any time, and called again: no byte is lost in either
/// direction.
pub struct Driver<S: Session, T> {
    /// Boxed, because the sessions of kOS are long, and futures move.
    flow: Box<Flow<S, Vec<u8>>>,
    stream: Option<T>,
    /// Bytes that arrived while others were written.
    arrived: Vec<u8>,
    piece: Vec<u8>,
    start: Instant,
    /// Time since which the stream takes no bytes.
    stalled: Option<Millis>,
    reopen: Option<Reopen<S, T>>,
    others: Option<Others<S::Destination>>,
    label: Label,
    trouble: Option<Error>,
}

/// Thing that ends the wait of a driver.
enum Happened<T> {
    /// Bytes arrived, or were written.
    Progress,
    Opened(Result<T, Error>),
    Lost(String),
    Time,
}

impl<S: Session<Line = ()>, T: AsyncRead + AsyncWrite + Unpin> Driver<S, T> {
    /// Makes a driver of this session on an open stream, which must not hold bytes back: it is never flushed.
    #[must_use]
    pub fn new(session: S, stream: T) -> Self {
        Self::on_line(session, (), stream)
    }

    /// Makes a driver of this session without a stream. [`reconnecting`](Self::reconnecting) says how it is opened: at once, or
    /// when the session asks for its line.
    #[must_use]
    pub fn unopened(session: S) -> Self {
        Self::with_stream(session, (), None)
    }
}

impl<S: Session, T: AsyncRead + AsyncWrite + Unpin> Driver<S, T> {
    /// Makes a driver of one line of this session, on an open stream, as [`new`](Self::new).
    #[must_use]
    pub fn on_line(session: S, line: S::Line, stream: T) -> Self {
        Self::with_stream(session, line, Some(stream))
    }

    fn with_stream(session: S, line: S::Line, stream: Option<T>) -> Self {
        let (start, arrived, piece) = (Instant::now(), Vec::new(), vec![0; S::PIECE]);
        let (stalled, reopen, others, label, trouble) = (None, None, None, Label::default(), None);
        let flow = Box::new(Flow::new(session, line, Vec::new()));
        Self { flow, stream, arrived, piece, start, stalled, reopen, others, label, trouble }
    }

    /// Opens the line of a host that was lost again, by these rules.
    #[must_use]
    pub fn reconnecting<F>(self, rules: Reconnect, open: impl FnMut() -> F + Send + 'static) -> Self
    where
        S: HostSession,
        F: Future<Output = Result<T, Error>> + Send + 'static,
    {
        self.with_attempts(Attempts::new(rules), open)
    }

    /// Opens the line of a device that was lost again, by these rules: a serial port, or the next connection of a listener.
    ///
    /// The driver does not stop anything: see [`Reconnect`].
    #[must_use]
    pub fn reopening<F>(self, rules: Reconnect, open: impl FnMut() -> F + Send + 'static) -> Self
    where
        S: DeviceSession,
        F: Future<Output = Result<T, Error>> + Send + 'static,
    {
        self.with_attempts(Attempts::of_device(rules), open)
    }

    fn with_attempts<F>(mut self, attempts: Attempts<S>, mut open: impl FnMut() -> F + Send + 'static) -> Self
    where
        F: Future<Output = Result<T, Error>> + Send + 'static,
    {
        let open: Box<dyn FnMut() -> Opening<T> + Send> = Box::new(move || Box::pin(open()));
        self.reopen = Some(Reopen { attempts, open, opening: None });
        self
    }

    /// Whether there is an open line.
    #[must_use]
    pub const fn is_open(&self) -> bool {
        self.stream.is_some()
    }

    /// Gives up an attempt to open the line that is in progress. A session that asked for its line is told that it is down.
    ///
    /// The next attempt begins afresh. An attempt that had no answer for some time waits longer before it asks again, and a
    /// stop must not wait for that.
    pub fn give_up_opening(&mut self) {
        let given_up = self.reopen.as_mut().and_then(|reopen| reopen.opening.take());
        if given_up.is_some() && S::ASKS {
            self.flow.down();
        }
    }

    /// Time since the driver was made, as the session is told.
    #[must_use]
    pub fn now(&self) -> Millis {
        millis_since(self.start)
    }

    /// Next event of the session, with what `source` has for its messages. Reads, writes and waits until there is one.
    ///
    /// The future can be dropped at any time. Nothing is lost, and the next call goes on where it ended.
    ///
    /// # Errors
    ///
    /// [`Error::Line`] if the line is gone and is not opened again, after all events are told;
    /// [`Error::Message`] if a message cannot be written.
    pub async fn next(&mut self, source: &S::Source<'_>) -> Result<S::Event<'_>, Error> {
        let held = loop {
            if let Some(held) = self.run(source, None).await? {
                break held;
            }
        };
        Ok(self.flow.session.event(held))
    }

    /// Next event of the session, if there is one within this time. What arrived by its end is handled before the end.
    ///
    /// The future can be dropped at any time, as that of [`next`](Self::next).
    ///
    /// # Errors
    ///
    /// The errors of [`next`](Self::next).
    pub async fn next_within(&mut self, time: Duration, source: &S::Source<'_>) -> Result<Option<S::Event<'_>>, Error> {
        let held = self.run(source, Instant::now().checked_add(time)).await?;
        Ok(held.map(|held| self.flow.session.event(held)))
    }

    /// Drives the session until there is an event, or this moment has come.
    async fn run(&mut self, source: &S::Source<'_>, end: Option<Instant>) -> Result<Option<S::Held>, Error> {
        let mut is_at_end = false;
        loop {
            self.care_for_line();
            let now = self.now();
            let is_writing = !self.flow.unsent().is_empty();
            let until = if is_writing {
                Some(self.stalled.get_or_insert(now).after(STALLED))
            } else {
                // What arrived goes before what is due. Otherwise a busy computer could miss an answer in time.
                self.give(now);
                match self.flow.next(now, source).map_err(Error::Message)? {
                    Next::Event(held) => return Ok(Some(held)),
                    Next::Write => {
                        self.stalled = None;
                        continue;
                    }
                    Next::Other(to, len) => {
                        if let Some(send) = &mut self.others {
                            send(to, self.flow.front(len));
                        }
                        continue;
                    }
                    Next::Wait(_) if self.give(now) > 0 => continue,
                    Next::Wait(until) => until,
                }
            };
            if self.stream.is_none() && self.reopen.is_none() {
                return Err(self.trouble.clone().unwrap_or_else(|| self.label.closed()));
            }
            if is_at_end {
                return Ok(None);
            }
            let is_due = self.wait(until, end).await;
            if is_due && is_writing && until.is_some_and(|until| until <= self.now()) {
                self.lose("it takes no bytes");
            }
            let late = end.and_then(|end| Instant::now().checked_duration_since(end));
            is_at_end = late.is_some_and(|late| is_due || late >= LATE);
        }
    }

    /// Gives bytes that arrived to the session, and returns how many it took.
    fn give(&mut self, now: Millis) -> usize {
        let taken = self.flow.receive(now, &self.arrived);
        self.arrived.drain(..taken);
        taken
    }

    /// Closes the line that the session does not want any more, tells the session of the line that it wants, or begins to open
    /// it.
    fn care_for_line(&mut self) {
        let now = self.now();
        if self.flow.is_over() {
            self.hang_up();
        }
        if !self.flow.wants_line() {
            return;
        }
        if self.stream.is_some() {
            self.flow.up();
        } else if let Some(reopen) = self.reopen.as_mut().filter(|reopen| reopen.opening.is_none()) {
            if S::ASKS || reopen.attempts.at <= now {
                reopen.opening = Some((reopen.open)());
            }
        }
    }

    /// Handles the loss of the line.
    fn lose(&mut self, why: &str) {
        self.trouble = Some(self.label.gone(why));
        self.flow.down();
        self.hang_up();
    }

    fn hang_up(&mut self) {
        let now = self.now();
        if let Some(reopen) = &mut self.reopen {
            reopen.opening = None;
            if !reopen.attempts.lost(now, &self.flow.session) {
                self.reopen = None;
            }
        }
        self.stream = None;
        self.arrived.clear();
    }

    /// Handles the end of an attempt to open the line.
    fn opened(&mut self, opened: Result<T, Error>) {
        let now = self.now();
        let Some(reopen) = &mut self.reopen else { return };
        reopen.opening = None;
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

    /// Waits until something happens, at most until this time and this end. Returns whether one of them came.
    async fn wait(&mut self, until: Option<Millis>, end: Option<Instant>) -> bool {
        // A line that always has bytes keeps nothing else waiting.
        consume_budget().await;
        let attempt = self.reopen.as_ref().filter(|reopen| reopen.opening.is_none() && self.flow.wants_line());
        let until = [until, attempt.map(|reopen| reopen.attempts.at)].into_iter().flatten().min();
        let until = until.and_then(|until| self.start.checked_add(Duration::from_millis(until.0)));
        let mut end = pin!(moment([until, end].into_iter().flatten().min()));
        let happened = poll_fn(|cx| {
            let opening = self.reopen.as_mut().and_then(|reopen| reopen.opening.as_mut());
            if let Some(Poll::Ready(opened)) = opening.map(|opening| opening.as_mut().poll(cx)) {
                return Poll::Ready(Happened::Opened(opened));
            }
            match self.poll_line(cx) {
                Poll::Ready(Ok(())) => Poll::Ready(Happened::Progress),
                Poll::Ready(Err(why)) => Poll::Ready(Happened::Lost(why)),
                Poll::Pending => end.as_mut().poll(cx).map(|()| Happened::Time),
            }
        })
        .await;
        match happened {
            Happened::Opened(opened) => self.opened(opened),
            Happened::Lost(why) => self.lose(&why),
            Happened::Progress => {}
            Happened::Time => return true,
        }
        false
    }

    /// Writes and reads what can be at once.
    fn poll_line(&mut self, cx: &mut Context<'_>) -> Poll<Result<(), String>> {
        let Some(stream) = self.stream.as_mut().filter(|_| self.flow.is_up()) else { return Poll::Pending };
        let mut stream = Pin::new(stream);
        let unsent = self.flow.unsent();
        if let Some(Poll::Ready(written)) = (!unsent.is_empty()).then(|| stream.as_mut().poll_write(cx, unsent)) {
            return Poll::Ready(match written {
                Ok(0) => Err("it takes no more bytes".to_string()),
                Ok(len) => {
                    self.flow.written(len);
                    self.stalled = None;
                    Ok(())
                }
                Err(error) => Err(broken(&error)),
            });
        }
        // Reading goes on while writing waits. Otherwise two drivers could wait for each other.
        if self.arrived.len() >= S::PIECE {
            return Poll::Pending;
        }
        let mut piece = ReadBuf::new(&mut self.piece);
        let read = ready!(stream.poll_read(cx, &mut piece));
        Poll::Ready(match read {
            Ok(()) if piece.filled().is_empty() => Err("the other end closed it".to_string()),
            Ok(()) => {
                self.arrived.extend_from_slice(piece.filled());
                self.label.has_answered = true;
                if let Some(reopen) = &mut self.reopen {
                    reopen.attempts.works();
                }
                Ok(())
            }
            Err(error) => Err(broken(&error)),
        })
    }
}

driver_methods! {}

impl<S: Session + fmt::Debug, T> fmt::Debug for Driver<S, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (session, is_open) = (&self.flow.session, self.stream.is_some());
        f.debug_struct("Driver").field("session", session).field("is_open", &is_open).finish_non_exhaustive()
    }
}

/// Time since the start, as a session is told.
pub(crate) fn millis_since(start: Instant) -> Millis {
    Millis(u64::try_from(start.elapsed().as_millis()).unwrap_or(u64::MAX))
}

/// Waits until this moment.
pub(crate) async fn moment(end: Option<Instant>) {
    match end {
        Some(end) => sleep_until(end).await,
        None => pending().await,
    }
    // All that arrived until the end is handled before the end. Otherwise a busy computer could miss an answer in time.
    yield_now().await;
}

/// Opens a TCP connection within 5 s. Messages are sent at once, so that a stop waits for nothing.
///
/// # Errors
///
/// [`Error::Line`].
pub async fn tcp(address: impl ToSocketAddrs + fmt::Display) -> Result<TcpStream, Error> {
    let name = address.to_string();
    let stream = match timeout(CONNECT, TcpStream::connect(address)).await {
        Ok(stream) => stream,
        Err(_) => Err(io::ErrorKind::TimedOut.into()),
    };
    let stream = stream.map_err(|error| Error::tcp(&name, &error))?;
    stream.set_nodelay(true).map_err(|error| Error::tcp(&name, &error))?;
    Ok(stream)
}

/// Opens a serial port at this speed, in bits per second. Bytes that wait since an earlier session are dropped.
///
/// # Errors
///
/// [`Error::Line`].
#[cfg(feature = "tokio-serial")]
pub fn serial(path: &str, baud: u32) -> Result<tokio_serial::SerialStream, Error> {
    use tokio_serial::{ClearBuffer, SerialPort, SerialPortBuilderExt};
    let port = tokio_serial::new(path, baud).open_native_async().map_err(|error| Error::serial(path, &error))?;
    // A port that cannot drop them gives bytes that answer nothing, which sessions can bear.
    let _ = port.clear(ClearBuffer::Input);
    Ok(port)
}
