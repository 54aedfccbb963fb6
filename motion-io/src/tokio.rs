//! Driver of asynchronous streams on tokio.

use std::boxed::Box;
use std::fmt;
use std::future::{pending, poll_fn};
use std::io;
use std::pin::{Pin, pin};
use std::string::{String, ToString};
use std::task::{Context, Poll};
use std::time::Duration;

use ::tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use ::tokio::net::{TcpStream, ToSocketAddrs};
use ::tokio::task::{consume_budget, yield_now};
use ::tokio::time::{Instant, sleep_until, timeout};
use motion_core::session::{DeviceSession, HostSession, Session};
use motion_core::time::Millis;

use crate::error::Error;
use crate::flow::Next;
use crate::line::{Line, Reopen, driver_methods};
use crate::reconnect::{Attempts, Reconnect};
use crate::{CONNECT, STALLED};

/// Greatest delay of the end of a time, on a line that is never silent.
const LATE: Duration = Duration::from_millis(100);

/// Attempt to open a line.
type Opening<T> = Pin<Box<dyn Future<Output = Result<T, Error>> + Send>>;

/// Session on a stream.
///
/// [`next`](Self::next) does everything. It can be dropped at any time, and called again: no byte is lost in either
/// direction.
pub struct Driver<S: Session, T> {
    line: Line<S, T, Opening<T>>,
    start: Instant,
    /// Time since which the stream takes no bytes.
    stalled: Option<Millis>,
}

impl<S: Session, T: AsyncRead + AsyncWrite + Unpin> Driver<S, T> {
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
        self.line.reopen = Some(Reopen::new(attempts, move || -> Opening<T> { Box::pin(open()) }));
        self
    }

    /// Gives up an attempt to open the line that is in progress. A session that asked for its line is told that it is down.
    ///
    /// The next attempt begins afresh. An attempt that had no answer for some time waits longer before it asks again, and a
    /// stop must not wait for that.
    pub fn give_up_opening(&mut self) {
        self.line.give_up_opening();
    }

    /// Next event of the session, with what `source` has for its messages. Reads, writes and waits until there is one.
    ///
    /// The future can be dropped at any time. Nothing is lost, and the next call goes on where it ended.
    ///
    /// # Errors
    ///
    /// [`Error::Lost`] if the line is lost and is not opened again, after all events are told; [`Error::NotOpened`] if the last
    /// attempt to open it failed;
    /// [`Error::Message`] if a message cannot be written.
    pub async fn next(&mut self, source: &S::Source<'_>) -> Result<S::Event<'_>, Error> {
        let held = loop {
            if let Some(held) = self.run(source, None).await? {
                break held;
            }
        };
        Ok(self.line.flow.session.event(held))
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
        Ok(held.map(|held| self.line.flow.session.event(held)))
    }

    /// Drives the session until there is an event, or this moment has come.
    async fn run(&mut self, source: &S::Source<'_>, end: Option<Instant>) -> Result<Option<S::Held>, Error> {
        let mut is_at_end = false;
        loop {
            let now = self.now();
            self.line.care(now);
            let until = match self.line.next(now, source)? {
                Next::Event(held) => return Ok(Some(held)),
                Next::Write => Some(self.stalled.get_or_insert(now).after(STALLED)),
                Next::Wait(until) => {
                    self.stalled = None;
                    until
                }
            };
            if is_at_end {
                return Ok(None);
            }
            let is_due = self.wait(until, end).await;
            let now = self.now();
            if is_due && self.stalled.is_some_and(|stalled| stalled.after(STALLED) <= now) {
                self.line.cannot_write(now, "it takes no bytes");
            }
            let late = end.and_then(|end| Instant::now().checked_duration_since(end));
            is_at_end = late.is_some_and(|late| is_due || late >= LATE);
        }
    }

    /// Waits until something happens, at most until this time and this end. Returns whether one of them came.
    async fn wait(&mut self, until: Option<Millis>, end: Option<Instant>) -> bool {
        // A line that always has bytes keeps nothing else waiting.
        consume_budget().await;
        let until = until.and_then(|until| self.start.checked_add(Duration::from_millis(until.0)));
        let mut end = pin!(moment([until, end].into_iter().flatten().min()));
        poll_fn(|cx| if self.poll(cx) { Poll::Ready(false) } else { end.as_mut().poll(cx).map(|()| true) }).await
    }

    /// Opens, writes and reads what can be at once. Returns whether something happened.
    fn poll(&mut self, cx: &mut Context<'_>) -> bool {
        let now = self.now();
        if let Some(Poll::Ready(opened)) = self.line.opening.as_mut().map(|opening| opening.as_mut().poll(cx)) {
            self.line.opened(now, opened);
            return true;
        }
        let line = &mut self.line;
        let Some(stream) = line.stream.as_mut().filter(|_| line.flow.is_up()) else { return false };
        let mut stream = Pin::new(stream);
        let unsent = line.flow.unsent();
        if let Some(Poll::Ready(written)) = (!unsent.is_empty()).then(|| stream.as_mut().poll_write(cx, unsent)) {
            line.has_written(now, written);
            self.stalled = None;
            return true;
        }
        // Reading goes on while writing waits. Otherwise two drivers could wait for each other.
        if line.arrived.len() >= S::PIECE {
            return false;
        }
        let mut piece = ReadBuf::new(&mut line.piece);
        let Poll::Ready(read) = stream.poll_read(cx, &mut piece) else { return false };
        let read = read.map(|()| piece.filled().len());
        line.has_read(now, read);
        true
    }
}

driver_methods! { stalled: None }

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
/// [`Error::NotOpened`].
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
/// [`Error::NotOpened`].
#[cfg(feature = "tokio-serial")]
pub fn serial(path: &str, baud: u32) -> Result<tokio_serial::SerialStream, Error> {
    use tokio_serial::{ClearBuffer, SerialPort, SerialPortBuilderExt};
    let port = tokio_serial::new(path, baud).open_native_async().map_err(|error| Error::serial(path, &error))?;
    // A port that cannot drop them gives bytes that answer nothing, which sessions can bear.
    let _ = port.clear(ClearBuffer::Input);
    Ok(port)
}
