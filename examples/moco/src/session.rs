//! Session of a host on a real line, in real time: when it ends, and how it stops everything.

use std::net::SocketAddr;
use std::time::Duration;

use motion_core::machine::Token;
use motion_core::session::HostSession;
use motion_io::tokio::{Driver, serial, tcp};
use motion_io::{Error, Reconnect};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::sync::mpsc::UnboundedReceiver;
use tokio::time::Instant;
use tracing::debug;

use crate::drive::{Driven, Stopped, Trouble};
use crate::hosted::Hosted;
use crate::serve::Stream;

/// Time within which a stop must be confirmed. After it, somebody has to press the emergency stop.
pub(crate) const STOP: Duration = Duration::from_secs(10);
/// Time within which all motors must rest after a stop that is confirmed.
pub(crate) const REST: Duration = Duration::from_secs(5);
/// Time within which a lost line must be open again for a stop.
const REACH: Duration = Duration::from_secs(2);
/// Time in which another Ctrl-C does not cancel a stop, because a person may press it several times in an emergency.
const FRIGHT: Duration = Duration::from_secs(1);
/// Longest time between two attempts to open a line, and between two looks at the time.
const AGAIN: Duration = Duration::from_millis(100);

/// Place at which a rig can be reached.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Target {
    /// Address in a network.
    Tcp(SocketAddr),
    /// Path of a serial line, and its speed in bits per second.
    Serial(String, u32),
}

impl Target {
    async fn open(self) -> Result<Box<dyn Stream>, Error> {
        Ok(match self {
            Self::Tcp(address) => Box::new(tcp(address).await?),
            Self::Serial(path, baud) => Box::new(serial(&path, baud)?),
        })
    }
}

/// Host with its line and the clock of the computer.
pub struct Session<H: Driven> {
    driver: Driver<Hosted<H>, Box<dyn Stream>>,
    interrupts: UnboundedReceiver<()>,
    /// End of the time in which a Ctrl-C is ignored.
    deaf: Instant,
}

impl<H: Driven> Session<H> {
    /// Starts a session. Opens the line, unless the host requests it itself. Each message of `interrupts` is a Ctrl-C.
    ///
    /// # Errors
    ///
    /// [`Trouble::Line`] if the line cannot be opened, [`Trouble::Interrupted`] after Ctrl-C.
    pub async fn connect(host: H, target: Target, mut interrupts: UnboundedReceiver<()>) -> Result<Self, Trouble> {
        let driver = if H::ASKS {
            Driver::unopened(Hosted::new(host))
        } else {
            let line = tokio::select! {
                biased;
                () = interrupted(&mut interrupts, Instant::now()) => return Err(Trouble::Interrupted),
                line = target.clone().open() => line?,
            };
            Driver::new(Hosted::new(host), line)
        };
        // The session decides about stops.
        let rules = Reconnect::new().with_times(Duration::from_millis(1), AGAIN).without_stop();
        Ok(Self::new(driver.reconnecting(rules, move || target.clone().open()), interrupts))
    }

    /// Starts a session on a line that is already open. The line is not opened again when it is lost.
    pub fn over<S>(host: H, line: S, interrupts: UnboundedReceiver<()>) -> Self
    where
        S: AsyncRead + AsyncWrite + Send + Unpin + 'static,
    {
        Self::new(Driver::new(Hosted::new(host), Box::new(line)), interrupts)
    }

    fn new(driver: Driver<Hosted<H>, Box<dyn Stream>>, interrupts: UnboundedReceiver<()>) -> Self {
        Self { driver: driver.named("the rig"), interrupts, deaf: Instant::now() }
    }

    /// The host, for reading its state.
    #[must_use]
    pub fn host(&self) -> &H {
        &self.driver.session().host
    }

    /// Reason why the line was lost, or could not be opened, the last time.
    #[must_use]
    pub fn why(&self) -> Option<String> {
        self.driver.trouble().map(Error::to_string)
    }

    /// First bytes that the rig sent, at most [`ENOUGH`](crate::drive::foreign::ENOUGH).
    #[must_use]
    pub fn heard(&self) -> &[u8] {
        &self.driver.session().heard
    }

    /// Number of bytes that were written to the line.
    #[must_use]
    pub fn written(&self) -> u64 {
        self.driver.session().written - u64::try_from(self.driver.unsent()).unwrap_or(0)
    }

    /// Gives a command to the host. It is executed in [`next`](Self::next).
    pub fn command(&mut self, command: H::Command) {
        self.driver.session_mut().commands.push_back(command);
    }

    /// Next event of the host, without a time limit.
    ///
    /// # Errors
    ///
    /// [`Trouble::Interrupted`] after Ctrl-C; [`Trouble::Lost`] if the line is lost and the host does not ask for it again.
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
        let mut is_over = false;
        loop {
            if !H::ASKS && !self.driver.is_open() {
                let trouble = self.driver.trouble().cloned().map(Trouble::from);
                return Err(trouble.unwrap_or_else(|| Trouble::Line("there is no line to the rig".to_owned())));
            }
            let event = self.driver.session_mut().event.take();
            if event.is_some() || is_over {
                return Ok(event);
            }
            is_over = !self.step(until).await?;
        }
    }

    /// Drives the host until it has an event or its line came or went. Returns whether that was before this moment.
    async fn step(&mut self, until: Instant) -> Result<bool, Trouble> {
        let time = until.saturating_duration_since(Instant::now());
        tokio::select! {
            biased;
            () = interrupted(&mut self.interrupts, self.deaf) => {}
            happened = self.driver.next_within(time, &()) => return Ok(happened?.is_some()),
        }
        Err(Trouble::Interrupted)
    }

    /// Stops everything, and waits until the rig confirms the stop, for at most 10 s, and then for at most 5 s until nothing
    /// may move. Another Ctrl-C ends the wait if it comes more than a second later.
    ///
    /// A lost line is opened again for the stop, if that is possible within 2 s. Otherwise the wait ends at once, so
    /// that the user learns that the stop cannot be sent.
    pub async fn stop(&mut self) -> Stopped {
        let until = Instant::now() + STOP;
        self.deaf = Instant::now() + FRIGHT;
        // An attempt that had no answer for some time waits longer than a stop may.
        self.driver.give_up_opening();
        while Instant::now() < until {
            if !H::ASKS && !self.reach().await {
                break;
            }
            // There is always room for it.
            let _ = self.driver.session_mut().stop(Token::default());
            match self.confirmed(until).await {
                Ok(stopped) => return stopped,
                Err(Trouble::Line(why) | Trouble::Lost(why)) if !H::ASKS => debug!("line lost in a stop: {why}"),
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
            if self.driver.is_open() && !self.host().is_deaf() {
                reached = Instant::now();
            }
        }
        Ok(Stopped::NotConfirmed)
    }

    /// Waits after a confirmed stop until nothing may move any more, for at most 5 s. Returns whether that came. Asks the rig about
    /// motors of an earlier session, of which the host does not know.
    pub async fn rests(&mut self) -> bool {
        let until = Instant::now() + REST;
        let (mut ask, mut rests) = (Some(Instant::now()), false);
        while Instant::now() < until {
            if ask.take_if(|at| *at <= Instant::now()).is_some() {
                match self.host().question() {
                    Some(question) => self.command(question),
                    None => rests = true,
                }
            }
            if rests && !self.host().may_move() {
                return true;
            }
            match self.next_within(AGAIN).await {
                Ok(event) => {
                    if let Some(answer) = event.as_ref().and_then(H::rest) {
                        (rests, ask) = (answer, (!answer).then(|| Instant::now() + AGAIN));
                    }
                }
                // The stop is confirmed, whatever becomes of the line.
                Err(_) => break,
            }
        }
        false
    }

    /// Opens a lost line again. Returns whether that succeeded in time.
    async fn reach(&mut self) -> bool {
        let until = Instant::now() + REACH;
        while !self.driver.is_open() && Instant::now() < until && self.step(until).await.is_ok() {
            // What ended with the line confirms no stop.
            self.driver.session_mut().event = None;
        }
        self.driver.is_open()
    }
}

impl From<Error> for Trouble {
    fn from(error: Error) -> Self {
        let text = error.to_string();
        if matches!(error, Error::Lost { .. }) { Self::Lost(text) } else { Self::Line(text) }
    }
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
