//! A host on a real line, in real time.

use std::io;
use std::net::SocketAddr;
use std::time::Duration;

use motion_core::time::Millis;
use rigs::{LineId, Outgoing};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::sync::mpsc::UnboundedReceiver;
use tokio::task::yield_now;
use tokio::time::{Instant, sleep, sleep_until, timeout, timeout_at};
use tokio_serial::SerialPortBuilderExt;
use tracing::{debug, trace};

use crate::drive::{Driven, Stopped, Trouble};
use crate::serve::Stream;

/// How long a connection may take to be there.
const CONNECT: Duration = Duration::from_secs(5);
/// How long a line may take no bytes, before it counts as gone.
const WRITE: Duration = Duration::from_secs(2);
/// How long a stop may take to be confirmed, before somebody has to press the emergency stop.
const STOP: Duration = Duration::from_secs(10);
/// How long a lost line may take to be there again for a stop.
const REACH: Duration = Duration::from_secs(2);
/// For how long another Ctrl-C does not give up a stop: who is frightened presses it more than once.
const FRIGHT: Duration = Duration::from_secs(1);
/// How much later than agreed waiting may end on a line that is never silent.
const LATE: Duration = Duration::from_millis(100);
/// From one try to open it to the next.
const AGAIN: Duration = Duration::from_millis(100);

const LINE: LineId = LineId(0);

/// Where a rig is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Target {
    /// In a network.
    Tcp(SocketAddr),
    /// At a serial line, at so many bits a second.
    Serial(String, u32),
}

/// A host, its line, and the clock of the computer.
pub struct Session<H> {
    host: H,
    /// Where the line is opened; none where it was given.
    target: Option<Target>,
    start: Instant,
    line: Option<Box<dyn Stream>>,
    interrupts: UnboundedReceiver<()>,
    /// Until when a Ctrl-C changes nothing.
    deaf: Instant,
    /// Why there is no line, for hosts that open it by themselves.
    why: Option<String>,
}

impl<H: Driven> Session<H> {
    /// Opens the line, if the host does not ask for it by itself. Each message of `interrupts` is a Ctrl-C.
    ///
    /// # Errors
    ///
    /// [`Trouble::Line`] if it cannot be opened, [`Trouble::Interrupted`].
    pub async fn connect(host: H, target: Target, interrupts: UnboundedReceiver<()>) -> Result<Self, Trouble> {
        let (target, start) = (Some(target), Instant::now());
        let mut session = Self { host, target, start, line: None, interrupts, deaf: start, why: None };
        if !H::OPENS {
            session.open().await?;
        }
        Ok(session)
    }

    /// A session on a line that is open: whatever carries bytes. It is not opened again when it is lost.
    pub fn over<S>(host: H, line: S, interrupts: UnboundedReceiver<()>) -> Self
    where
        S: AsyncRead + AsyncWrite + Send + Unpin + 'static,
    {
        let (line, start): (Box<dyn Stream>, _) = (Box::new(line), Instant::now());
        let mut session = Self { host, target: None, start, line: Some(line), interrupts, deaf: start, why: None };
        session.host.open(Millis(0), LINE);
        session
    }

    /// The host, to look at.
    pub const fn host(&self) -> &H {
        &self.host
    }

    /// Why the line could not be opened, or was lost, the last time.
    pub fn why(&self) -> Option<&str> {
        self.why.as_deref()
    }

    /// Milliseconds since the session began.
    pub fn now(&self) -> Millis {
        Millis(u64::try_from(self.start.elapsed().as_millis()).unwrap_or(u64::MAX))
    }

    /// Tells the host what to do. What follows is done in [`next`](Self::next).
    pub fn command(&mut self, command: H::Command) {
        let now = self.now();
        self.host.command(now, command);
    }

    /// What the host tells next, however long it takes.
    ///
    /// # Errors
    ///
    /// [`Trouble::Interrupted`]; [`Trouble::Line`] if the line is gone and the host does not open it again.
    pub async fn next(&mut self) -> Result<H::Event, Trouble> {
        loop {
            if let Some(event) = self.next_within(Duration::from_hours(1)).await? {
                return Ok(event);
            }
        }
    }

    /// What the host tells next, if it does so in this time.
    ///
    /// # Errors
    ///
    /// As [`next`](Self::next).
    pub async fn next_within(&mut self, time: Duration) -> Result<Option<H::Event>, Trouble> {
        let until = Instant::now() + time;
        let mut buffer = [0; 4096];
        loop {
            self.settle().await?;
            if let Some(event) = self.host.next_event() {
                return Ok(Some(event));
            }
            if Instant::now() >= until + LATE {
                return Ok(None);
            }
            let wake = self.host.wake().map(|wake| self.start + Duration::from_millis(wake.0));
            let read = async {
                match &mut self.line {
                    Some(line) => line.read(&mut buffer).await,
                    None => std::future::pending().await,
                }
            };
            tokio::select! {
                biased;
                () = interrupted(&mut self.interrupts, self.deaf) => return Err(Trouble::Interrupted),
                read = read => match read {
                    Ok(0) => self.lost("the other end hung up")?,
                    Ok(len) => {
                        let now = self.now();
                        trace!(len, "read");
                        self.host.receive(now, LINE, &buffer[..len]);
                    }
                    Err(error) => self.lost(&error.to_string())?,
                },
                () = due(wake.unwrap_or(until).min(until)) => {
                    let now = self.now();
                    self.host.advance(now);
                    if Instant::now() >= until {
                        self.settle().await?;
                        return Ok(self.host.next_event());
                    }
                }
            }
        }
    }

    /// Stops everything, and waits for the rig to confirm it; not for ever, and only until another Ctrl-C that comes more
    /// than a second later: until then nobody has decided that waiting is of no use.
    ///
    /// A line that is lost is opened again for it, if that can be done soon; otherwise somebody has to know at once that
    /// the stop cannot be sent.
    pub async fn stop(&mut self) -> Stopped {
        let until = Instant::now() + STOP;
        self.deaf = Instant::now() + FRIGHT;
        while Instant::now() < until {
            if !H::OPENS && self.line.is_none() && !self.reach().await {
                break;
            }
            let now = self.now();
            self.host.stop_all(now);
            match self.confirmed(until).await {
                Ok(stopped) => return stopped,
                Err(Trouble::Line(why)) => debug!("line lost in a stop: {why}"),
                Err(_) => break,
            }
        }
        Stopped::NotConfirmed
    }

    /// Waits for the rig to confirm a stop; not long for a line that the host opens by itself.
    async fn confirmed(&mut self, until: Instant) -> Result<Stopped, Trouble> {
        let mut reached = Instant::now();
        while Instant::now() < until && reached.elapsed() < REACH {
            if let Some(event) = self.next_within(AGAIN).await?
                && H::stopped(&event) == Some(Stopped::Confirmed)
            {
                return Ok(Stopped::Confirmed);
            }
            if self.line.is_some() {
                reached = Instant::now();
            }
        }
        Ok(Stopped::NotConfirmed)
    }

    /// Opens a lost line again, and says whether that could be done soon.
    async fn reach(&mut self) -> bool {
        let until = Instant::now() + REACH;
        while self.target.is_some() {
            match timeout_at(until, self.open()).await {
                Ok(Ok(())) => return true,
                Ok(Err(Trouble::Line(_))) if Instant::now() + AGAIN < until => sleep(AGAIN).await,
                _ => return false,
            }
        }
        false
    }

    /// Does what the host wants done.
    async fn settle(&mut self) -> Result<(), Trouble> {
        while let Some(outgoing) = self.host.poll() {
            match outgoing {
                Outgoing::Bytes(LINE, bytes) => {
                    let Some(line) = &mut self.line else { continue };
                    // No flush: nothing is held back here, and that of a serial line keeps the whole thread waiting until a
                    // device takes the bytes, stops and Ctrl-C too.
                    let written = timeout(WRITE, line.write_all(&bytes)).await;
                    trace!(len = bytes.len(), "written");
                    match written {
                        Ok(Ok(())) => {}
                        Ok(Err(error)) => self.lost(&error.to_string())?,
                        Err(_) => self.lost("it takes nothing any more")?,
                    }
                }
                Outgoing::Open(LINE) => {
                    if let Err(trouble) = self.open().await {
                        // Also if it was interrupted: a stop needs another try.
                        let now = self.now();
                        self.host.close(now, LINE);
                        if matches!(trouble, Trouble::Interrupted) {
                            return Err(trouble);
                        }
                        debug!("{trouble}");
                        self.why = Some(trouble.to_string());
                    }
                }
                Outgoing::HangUp(LINE) => {
                    self.line = None;
                    let now = self.now();
                    self.host.close(now, LINE);
                }
                // A host has one line, and no datagrams.
                _ => {}
            }
        }
        Ok(())
    }

    async fn open(&mut self) -> Result<(), Trouble> {
        let Some(target) = &self.target else {
            return Err(Trouble::Line("the line is gone, and there is no way to open it again".to_owned()));
        };
        self.line = Some(tokio::select! {
            biased;
            () = interrupted(&mut self.interrupts, self.deaf) => return Err(Trouble::Interrupted),
            line = open(target) => line?,
        });
        let now = self.now();
        self.host.open(now, LINE);
        Ok(())
    }

    /// The line is gone.
    fn lost(&mut self, why: &str) -> Result<(), Trouble> {
        self.line = None;
        let now = self.now();
        self.host.close(now, LINE);
        if H::OPENS {
            debug!("line lost: {why}");
            self.why = Some(format!("the rig is gone: {why}"));
            return Ok(());
        }
        Err(Trouble::Line(format!("the rig is gone: {why}: look at its cable and its power")))
    }
}

/// A moment, once all that has arrived until then was looked at: a computer that is busy must not take an answer that is
/// there for none.
pub(crate) async fn due(moment: Instant) {
    sleep_until(moment).await;
    yield_now().await;
}

/// A Ctrl-C that counts.
async fn interrupted(interrupts: &mut UnboundedReceiver<()>, deaf: Instant) {
    while interrupts.recv().await.is_some() {
        if Instant::now() >= deaf {
            return;
        }
    }
    std::future::pending::<()>().await;
}

async fn open(target: &Target) -> Result<Box<dyn Stream>, Trouble> {
    match target {
        Target::Tcp(address) => match timeout(CONNECT, TcpStream::connect(address)).await {
            Ok(Ok(line)) => {
                // A stop must not wait for more bytes to go with.
                let quick = line.set_nodelay(true);
                quick.map_err(|error| Trouble::Line(format!("{address}: {error}")))?;
                Ok(Box::new(line))
            }
            Ok(Err(error)) if error.kind() == io::ErrorKind::ConnectionRefused => {
                Err(Trouble::Line(format!("{address}: nobody listens there: is the rig on, and is this its port?")))
            }
            Ok(Err(error)) => Err(Trouble::Line(format!("{address}: {error}"))),
            Err(_) => Err(Trouble::Line(format!("{address}: no answer in 5 s: is the rig on, and in this network?"))),
        },
        Target::Serial(path, baud) => match tokio_serial::new(path, *baud).open_native_async() {
            Ok(line) => Ok(Box::new(line)),
            Err(error) => {
                Err(Trouble::Line(format!("{path}: {error}: is the rig plugged in, and used by nobody else?")))
            }
        },
    }
}
