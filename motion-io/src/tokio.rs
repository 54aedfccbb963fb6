//! Driver of asynchronous streams on tokio.

use std::boxed::Box;
use std::fmt;
use std::future::{pending, poll_fn};
use std::pin::{Pin, pin};
use std::string::ToString;
use std::task::{Context, Poll, ready};
use std::time::Duration;
use std::vec::Vec;
use std::{io, vec};

use ::tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use ::tokio::net::{TcpStream, ToSocketAddrs};
use ::tokio::task::yield_now;
use ::tokio::time::{Instant, sleep_until, timeout};
use motion_core::session::{DeviceSession, HostSession, Session};
use motion_core::time::Millis;

use crate::error::Error;
use crate::flow::{Flow, Next};
use crate::reconnect::{Attempts, Reconnect};
use crate::{CONNECT, STALLED};

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
    trouble: Option<Error>,
}

/// Thing that ends the wait of a driver.
enum Happened<T> {
    /// Bytes arrived, or were written.
    Progress,
    Opened(Result<T, Error>),
    Lost(Error),
    Time,
}

impl<S: Session<Line = ()>, T: AsyncRead + AsyncWrite + Unpin> Driver<S, T> {
    /// Makes a driver of this session on an open stream, which must not hold bytes back: it is never flushed.
    #[must_use]
    pub fn new(session: S, stream: T) -> Self {
        Self::on_line(session, (), stream)
    }
}

impl<S: Session, T: AsyncRead + AsyncWrite + Unpin> Driver<S, T> {
    /// Makes a driver of one line of this session, on an open stream, as [`new`](Self::new).
    #[must_use]
    pub fn on_line(session: S, line: S::Line, stream: T) -> Self {
        let (start, arrived, piece) = (Instant::now(), Vec::new(), vec![0; S::PIECE]);
        let (stalled, reopen, others, trouble) = (None, None, None, None);
        let flow = Box::new(Flow::new(session, line, Vec::new()));
        Self { flow, stream: Some(stream), arrived, piece, start, stalled, reopen, others, trouble }
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
    /// The driver does not stop anything. The machine of the device is told of the loss at once, and decides what its rig does
    /// until a host is there again; the driver gives its events meanwhile:
    ///
    /// - A DMC device stops everything, because no stop could come any more.
    /// - A kOS device stops what the client moved by hand. A move that it plays goes on, unless the options of its machine say
    ///   that it stops when no client is left.
    /// - A hoot node goes on with its program and its moves. Only its dead-man stops motors that run.
    ///
    /// An application that has to do more for its rig leaves this out: then [`next`](Self::next) ends with an error when the line
    /// is lost.
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

    /// Gives bytes for receivers that are not at the end of the line to this function, such as datagrams. Without it they
    /// are dropped.
    #[must_use]
    pub fn with_others(mut self, send: impl FnMut(S::Destination, &[u8]) + Send + 'static) -> Self {
        self.others = Some(Box::new(send));
        self
    }

    /// Session, for reading its state.
    #[must_use]
    pub fn session(&self) -> &S {
        &self.flow.session
    }

    /// Session, for commands. They are obeyed in [`next`](Self::next).
    ///
    /// Only the driver tells the session about its line and its bytes.
    pub fn session_mut(&mut self) -> &mut S {
        &mut self.flow.session
    }

    /// Reason why there is no line at present, or why there was none the last time.
    #[must_use]
    pub const fn trouble(&self) -> Option<&Error> {
        self.trouble.as_ref()
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
            self.care_for_line();
            if !self.flow.unsent().is_empty() {
                let since = *self.stalled.get_or_insert(self.now());
                if self.wait(Some(since.after(STALLED))).await {
                    self.lose(Error::lost("it takes no bytes"));
                }
                continue;
            }
            let now = self.now();
            match self.flow.next(now, source).map_err(Error::Message)? {
                Next::Event(held) => break held,
                Next::Write => self.stalled = None,
                Next::Other(to, len) => {
                    if let Some(send) = &mut self.others {
                        send(to, self.flow.front(len));
                    }
                }
                Next::Wait(until) => {
                    let taken = self.flow.receive(now, &self.arrived);
                    self.arrived.drain(..taken);
                    if taken > 0 {
                        continue;
                    }
                    if self.stream.is_none() && self.reopen.is_none() {
                        return Err(self.trouble.clone().unwrap_or_else(Error::closed));
                    }
                    self.wait(until).await;
                }
            }
        };
        Ok(self.flow.session.event(held))
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
    fn lose(&mut self, why: Error) {
        self.trouble = Some(why);
        self.flow.down();
        self.hang_up();
    }

    fn hang_up(&mut self) {
        let now = self.now();
        if let Some(reopen) = &mut self.reopen {
            reopen.attempts.lost(now, &self.flow.session);
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

    /// Waits until something happens, at most until this time. Returns whether the time came.
    async fn wait(&mut self, until: Option<Millis>) -> bool {
        let attempt = self.reopen.as_ref().filter(|reopen| reopen.opening.is_none() && self.flow.wants_line());
        let until = [until, attempt.map(|reopen| reopen.attempts.at)].into_iter().flatten().min();
        let mut end = pin!(moment(self.start, until));
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
            Happened::Lost(why) => self.lose(why),
            Happened::Progress => {}
            Happened::Time => return true,
        }
        false
    }

    /// Writes and reads what can be at once.
    fn poll_line(&mut self, cx: &mut Context<'_>) -> Poll<Result<(), Error>> {
        let Some(stream) = self.stream.as_mut().filter(|_| self.flow.is_up()) else { return Poll::Pending };
        let mut stream = Pin::new(stream);
        let unsent = self.flow.unsent();
        if let Some(Poll::Ready(written)) = (!unsent.is_empty()).then(|| stream.as_mut().poll_write(cx, unsent)) {
            return Poll::Ready(match written {
                Ok(0) => Err(Error::lost("it takes no more bytes")),
                Ok(len) => {
                    self.flow.written(len);
                    self.stalled = None;
                    Ok(())
                }
                Err(error) => Err(Error::broken(&error)),
            });
        }
        // Reading goes on while writing waits. Otherwise two drivers could wait for each other.
        if self.arrived.len() >= S::PIECE {
            return Poll::Pending;
        }
        let mut piece = ReadBuf::new(&mut self.piece);
        let read = ready!(stream.poll_read(cx, &mut piece));
        Poll::Ready(match read {
            Ok(()) if piece.filled().is_empty() => Err(Error::lost("the other end closed it")),
            Ok(()) => {
                self.arrived.extend_from_slice(piece.filled());
                if let Some(reopen) = &mut self.reopen {
                    reopen.attempts.works();
                }
                Ok(())
            }
            Err(error) => Err(Error::broken(&error)),
        })
    }
}

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

/// Waits until this time after the start has come.
pub(crate) async fn moment(start: Instant, until: Option<Millis>) {
    match until.and_then(|until| start.checked_add(Duration::from_millis(until.0))) {
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
