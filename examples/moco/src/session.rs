//! Session of a host on a real line, in real time.

use std::io;
use std::net::SocketAddr;
use std::time::Duration;

use motion_core::time::Millis;
use motion_rigs::{LineId, Outgoing};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::sync::mpsc::UnboundedReceiver;
use tokio::task::yield_now;
use tokio::time::{Instant, sleep, sleep_until, timeout, timeout_at};
use tokio_serial::{ClearBuffer, SerialPort, SerialPortBuilderExt};
use tracing::{debug, trace};

use crate::drive::foreign::ENOUGH;
use crate::drive::{Driven, Stopped, Trouble};
use crate::serve::Stream;

/// Time within which a connection must be made.
const CONNECT: Duration = Duration::from_secs(5);
/// Time without a written byte after which a line counts as gone.
const WRITE: Duration = Duration::from_secs(2);
/// Time within which a stop must be confirmed. After it, somebody has to press the emergency stop.
const STOP: Duration = Duration::from_secs(10);
/// Time within which all motors must rest after a stop that is confirmed.
const REST: Duration = Duration::from_secs(5);
/// Time within which a lost line must be open again for a stop.
const REACH: Duration = Duration::from_secs(2);
/// Time in which another Ctrl-C does not cancel a stop, because a person may press it several times in an emergency.
const FRIGHT: Duration = Duration::from_secs(1);
/// Greatest delay of the end of waiting, on a line that is never silent.
const LATE: Duration = Duration::from_millis(100);
/// Time between two attempts to open a line.
const AGAIN: Duration = Duration::from_millis(100);

const LINE: LineId = LineId(0);

/// Place at which a rig can be reached.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Target {
    /// Address in a network.
    Tcp(SocketAddr),
    /// Path of a serial line, and its speed in bits per second.
    Serial(String, u32),
}

/// Host with its line and the clock of the computer.
pub struct Session<H> {
    host: H,
    /// Target at which the line is opened. `None` if an open line was given.
    target: Option<Target>,
    start: Instant,
    line: Option<Box<dyn Stream>>,
    interrupts: UnboundedReceiver<()>,
    /// End of the time in which a Ctrl-C is ignored.
    deaf: Instant,
    /// Reason why there is no line, for hosts that open it themselves.
    why: Option<String>,
    /// First bytes of the rig.
    heard: Vec<u8>,
    /// Number of bytes that were sent to the rig.
    written: u64,
}

impl<H: Driven> Session<H> {
    /// Starts a session. Opens the line, unless the host requests it itself. Each message of `interrupts` is a Ctrl-C.
    ///
    /// # Errors
    ///
    /// [`Trouble::Line`] if the line cannot be opened, [`Trouble::Interrupted`] after Ctrl-C.
    pub async fn connect(host: H, target: Target, interrupts: UnboundedReceiver<()>) -> Result<Self, Trouble> {
        let (target, start) = (Some(target), Instant::now());
        let mut session =
            Self { host, target, start, line: None, interrupts, deaf: start, why: None, heard: Vec::new(), written: 0 };
        if !H::OPENS {
            session.open().await?;
        }
        Ok(session)
    }

    /// Starts a session on a line that is already open. The line is not opened again when it is lost.
    pub fn over<S>(host: H, line: S, interrupts: UnboundedReceiver<()>) -> Self
    where
        S: AsyncRead + AsyncWrite + Send + Unpin + 'static,
    {
        let (line, start): (Box<dyn Stream>, _) = (Box::new(line), Instant::now());
        let mut session = Self {
            host,
            target: None,
            start,
            line: Some(line),
            interrupts,
            deaf: start,
            why: None,
            heard: Vec::new(),
            written: 0,
        };
        if !H::OPENS {
            session.host.open(Millis(0), LINE);
        }
        session
    }

    /// The host, for reading its state.
    pub const fn host(&self) -> &H {
        &self.host
    }

    /// Reason why the line was lost, or could not be opened, the last time.
    pub fn why(&self) -> Option<&str> {
        self.why.as_deref()
    }

    /// First bytes that the rig sent, at most [`ENOUGH`].
    pub fn heard(&self) -> &[u8] {
        &self.heard
    }

    /// Number of bytes that were sent to the rig.
    pub const fn written(&self) -> u64 {
        self.written
    }

    /// Time since the session began, in milliseconds.
    pub fn now(&self) -> Millis {
        Millis(u64::try_from(self.start.elapsed().as_millis()).unwrap_or(u64::MAX))
    }

    /// Gives a command to the host. It is executed in [`next`](Self::next).
    pub fn command(&mut self, command: H::Command) {
        let now = self.now();
        self.host.command(now, command);
    }

    /// Next event of the host, without a time limit.
    ///
    /// # Errors
    ///
    /// [`Trouble::Interrupted`] after Ctrl-C; [`Trouble::Line`] if the line is gone and the host does not reopen it.
    pub async fn next(&mut self) -> Result<H::Event, Trouble> {
        loop {
            if let Some(event) = self.next_within(Duration::from_hours(1)).await? {
                return Ok(event);
            }
        }
    }

    /// Next event of the host, if there is one within this time.
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
                    Ok(0) => self.lost("the other end closed it")?,
                    Ok(len) => {
                        let now = self.now();
                        trace!(len, "read");
                        self.heard.extend(buffer[..len].iter().take(ENOUGH - self.heard.len()));
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

    /// Stops everything, and waits until the rig confirms the stop, for at most 10 s, and then for at most 5 s until nothing
    /// may move. Another Ctrl-C ends the wait if it comes more than a second later.
    ///
    /// A lost line is opened again for the stop, if that is possible within 2 s. Otherwise the wait ends at once, so
    /// that the user learns that the stop cannot be sent.
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

    /// Waits until the rig confirms a stop. If the host opens the line itself, waits only a short time for the line. Does not
    /// wait longer for a rig that may ignore stops.
    async fn confirmed(&mut self, until: Instant) -> Result<Stopped, Trouble> {
        let mut reached = Instant::now();
        while Instant::now() < until && reached.elapsed() < REACH {
            if let Some(event) = self.next_within(AGAIN).await?
                && H::stopped(&event) == Some(Stopped::Confirmed)
            {
                return Ok(if self.rests().await { Stopped::Confirmed } else { Stopped::Obeyed });
            }
            if self.line.is_some() && !self.host.is_deaf() {
                reached = Instant::now();
            }
        }
        Ok(Stopped::NotConfirmed)
    }

    /// Waits after a confirmed stop until nothing may move any more, for at most 5 s. Returns whether that came.
    pub async fn rests(&mut self) -> bool {
        let until = Instant::now() + REST;
        while self.host.may_move() && Instant::now() < until {
            // The stop is confirmed, whatever becomes of the line.
            if self.next_within(AGAIN).await.is_err() {
                break;
            }
        }
        !self.host.may_move()
    }

    /// Opens a lost line again. Returns whether that succeeded in time.
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

    /// Executes the output of the host.
    async fn settle(&mut self) -> Result<(), Trouble> {
        while let Some(outgoing) = self.host.poll() {
            match outgoing {
                Outgoing::Bytes(LINE, bytes) => {
                    let Some(line) = &mut self.line else { continue };
                    // There is no flush, because nothing is held back here. The flush of a serial line would block the
                    // thread until the device takes the bytes, and stops and Ctrl-C would have to wait.
                    let written = timeout(WRITE, line.write_all(&bytes)).await;
                    trace!(len = bytes.len(), "written");
                    match written {
                        Ok(Ok(())) => self.written += u64::try_from(bytes.len()).unwrap_or(0),
                        Ok(Err(error)) => self.lost(&error.to_string())?,
                        Err(_) => self.lost("it no longer takes any bytes")?,
                    }
                }
                Outgoing::Open(LINE) => {
                    if let Err(trouble) = self.open().await {
                        // This is also needed after an interrupt, because a stop needs another attempt.
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
                // A host has one line and no datagrams.
                _ => {}
            }
        }
        Ok(())
    }

    async fn open(&mut self) -> Result<(), Trouble> {
        let Some(target) = &self.target else {
            if H::OPENS && self.line.is_some() {
                let now = self.now();
                self.host.open(now, LINE);
                return Ok(());
            }
            return Err(Trouble::Line("the line is gone and cannot be opened again".to_owned()));
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

    /// Handles the loss of the line.
    fn lost(&mut self, why: &str) -> Result<(), Trouble> {
        self.line = None;
        let now = self.now();
        self.host.close(now, LINE);
        if H::OPENS {
            debug!("line lost: {why}");
            self.why = Some(format!("the rig is gone: {why}"));
            return Ok(());
        }
        let what = if self.heard.is_empty() { " before it answered: check its protocol," } else { ": check" };
        Err(Trouble::Line(format!("the rig is gone: {why}{what} its cable and its power")))
    }
}

/// Waits until a moment, and until everything that has arrived by then is handled. Otherwise a busy computer could
/// miss an answer that arrived in time.
pub(crate) async fn due(moment: Instant) {
    sleep_until(moment).await;
    yield_now().await;
}

/// Waits for a Ctrl-C that is not ignored.
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
                // A stop must not wait until more bytes are sent with it.
                let quick = line.set_nodelay(true);
                quick.map_err(|error| Trouble::Line(format!("{address}: {error}")))?;
                Ok(Box::new(line))
            }
            Ok(Err(error)) if error.kind() == io::ErrorKind::ConnectionRefused => {
                Err(Trouble::Line(format!("{address}: nothing listens there: is the rig on, and is this its port?")))
            }
            Ok(Err(error)) => Err(Trouble::Line(format!("{address}: {error}"))),
            Err(_) => Err(Trouble::Line(format!("{address}: no answer in 5 s: is the rig on and in this network?"))),
        },
        Target::Serial(path, baud) => match tokio_serial::new(path, *baud).open_native_async() {
            Ok(line) => {
                // Bytes that wait since an earlier session answer nothing of this one. If they cannot be dropped, the
                // random ids of this session tell them apart.
                if let Err(error) = line.clear(ClearBuffer::Input) {
                    debug!("{path}: {error}: old bytes may wait");
                }
                Ok(Box::new(line))
            }
            Err(error) => {
                Err(Trouble::Line(format!("{path}: {error}: is the rig plugged in, and the line not in use?")))
            }
        },
    }
}
