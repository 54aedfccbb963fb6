//! Requests and their results, and the decisions of the application when a node does not answer.

use std::fmt::Display;
use std::time::Duration;

use hoot_proto::host::{Command, Event as MachineEvent, Outcome, Refusal, Request, Token};
use hoot_proto::message::{Motor, MotorPosition, MotorRunning, MotorSetContinuousSpeed, StepsPerSecond};
use hoot_proto::query::{Answer, Profile};
use hoot_proto::{Address, HostMessage, Query};
use motion_rigs::hoot_master::{Ended, Event, HootMaster};
use tokio::time::Instant;

use crate::drive::Trouble;
use crate::drive::output::{About, At, Output};
use crate::session::Session;

/// Number of attempts for a query or a setting, if it is not answered.
const TRIES: usize = 4;
/// Least time between two lines of progress.
const TELL: Duration = Duration::from_secs(1);

/// Session with one node.
pub(super) struct Talk<'a> {
    pub(super) session: &'a mut Session<HootMaster>,
    pub(super) node: Address,
    pub(super) home_speed: f32,
    pub(super) out: &'a mut dyn Output,
    token: u32,
    /// Time at which progress was printed last.
    told: Option<Instant>,
}

impl<'a> Talk<'a> {
    pub(super) fn new(
        session: &'a mut Session<HootMaster>,
        node: Address,
        home_speed: f32,
        out: &'a mut dyn Output,
    ) -> Self {
        Self { session, node, home_speed, out, token: 0, told: None }
    }

    /// Prints a line.
    pub(super) fn print(&mut self, line: &str) -> Result<(), Trouble> {
        self.line(About::Note, line)
    }

    /// Prints a line with its meaning.
    pub(super) fn line(&mut self, about: About, line: &str) -> Result<(), Trouble> {
        let written = self.out.line(about, format_args!("{line}"));
        written.map_err(|error| Trouble::Failed(format!("the output cannot be written: {error}")))
    }

    /// Prints a line of progress, unless one was printed less than a second ago. `part` is the part of the command that is
    /// done.
    pub(super) fn progress(&mut self, part: Option<f64>, positions: Vec<At>, line: &str) -> Result<(), Trouble> {
        if self.told.is_none_or(|told| told.elapsed() >= TELL) {
            self.told = Some(Instant::now());
            self.line(About::Progress { part, positions }, line)?;
        }
        Ok(())
    }

    /// Age of the firmware.
    pub(super) fn profile(&self) -> Profile {
        self.session.host().profile(self.node)
    }

    /// Gives a command to the master.
    pub(super) fn command(&mut self, command: Command) -> Token {
        self.token = self.token.wrapping_add(1);
        self.session.command((Token(self.token), command));
        Token(self.token)
    }

    /// Sends a message once, and waits for its result.
    pub(super) async fn send(&mut self, message: HostMessage<'static>) -> Result<Ended, Trouble> {
        let token = self.command(Command::Request(Request { to: self.node, message }));
        loop {
            match self.session.next().await? {
                Event::Ended(ended) if ended.token == token => return Ok(ended),
                event => self.overhear(&event)?,
            }
        }
    }

    /// Handles an event that does not belong to the request.
    pub(super) fn overhear(&mut self, event: &Event) -> Result<(), Trouble> {
        if let Event::Machine(MachineEvent::KeepAliveLost { to }) = event {
            self.print(&format!("node {} did not answer in time: its dead-man switch may have stopped it", to.0))?;
        }
        Ok(())
    }

    /// Sends a query, and repeats it if it is not answered.
    pub(super) async fn ask(&mut self, query: impl Into<HostMessage<'static>>) -> Result<Ended, Trouble> {
        let query = query.into();
        let ended = self.repeated(query).await?;
        if ended.answer().is_some() { Ok(ended) } else { Err(trouble(&ended)) }
    }

    /// Sends a query that some firmware refuses, and repeats it if it is not answered.
    pub(super) async fn ask_or_refused(&mut self, query: impl Into<HostMessage<'static>>) -> Result<Ended, Trouble> {
        let query = query.into();
        let ended = self.repeated(query).await?;
        let is_refused = matches!(ended.outcome(), Outcome::Refused(Refusal::Device(_)));
        if is_refused || ended.answer().is_some() { Ok(ended) } else { Err(trouble(&ended)) }
    }

    /// Value that the node answers to a query.
    pub(super) async fn read<Q, T>(&mut self, query: Q) -> Result<T, Trouble>
    where
        Q: Into<HostMessage<'static>>,
        for<'r> Q: Query<Reply<'r> = Answer<T>>,
    {
        let ended = self.ask(query).await?;
        ended.read(&query).ok_or_else(|| trouble(&ended))
    }

    /// Sends a setting while nothing moves. A setting without an answer is repeated, because repeating has the same
    /// effect as sending once. Other messages are sent once: those that may start motion, toggles, photos.
    pub(super) async fn set(&mut self, message: impl Into<HostMessage<'static>>) -> Result<(), Trouble> {
        let message = message.into();
        let is_once = message.conduct().may_move() || matches!(message, HostMessage::CameraExpose(_));
        let ended = if is_once { self.send(message).await? } else { self.repeated(message).await? };
        if ended.is_done() { Ok(()) } else { Err(trouble(&ended)) }
    }

    /// Sends a setting that firmware without it refuses, because it has the value that is asked for in any case.
    pub(super) async fn set_or_refused(&mut self, message: impl Into<HostMessage<'static>>) -> Result<(), Trouble> {
        match self.set(message).await {
            Err(Trouble::Refused(_)) => Ok(()),
            result => result,
        }
    }

    /// Sends a message, and repeats it if it is not answered.
    async fn repeated(&mut self, message: HostMessage<'static>) -> Result<Ended, Trouble> {
        for _ in 1..TRIES {
            let ended = self.send(message).await?;
            if !ended.is_unanswered() {
                return Ok(ended);
            }
        }
        self.send(message).await
    }

    /// Sets a value and reads it back, because firmware may answer OK without setting it.
    pub(super) async fn set_and_see<Q, T>(
        &mut self,
        message: impl Into<HostMessage<'static>>,
        query: Q,
        wanted: T,
    ) -> Result<(), Trouble>
    where
        Q: Into<HostMessage<'static>>,
        for<'r> Q: Query<Reply<'r> = Answer<T>>,
        T: PartialEq + Display,
    {
        let message = message.into();
        self.set(message).await?;
        let found = self.read(query).await?;
        if found == wanted {
            return Ok(());
        }
        let node = self.node.0;
        Err(Trouble::Failed(format!("node {node} answered OK to {message}, but has {found}: try again")))
    }

    /// Starts motion. The message is sent only once. Returns `false` if it was not answered: the motor may move or not.
    pub(super) async fn set_off(&mut self, message: impl Into<HostMessage<'static>>) -> Result<bool, Trouble> {
        let message = message.into();
        let ended = self.send(message).await?;
        if ended.is_done() || ended.is_unanswered() { Ok(ended.is_done()) } else { Err(trouble(&ended)) }
    }

    /// Position of a motor, in steps.
    pub(super) async fn position(&mut self, motor: Motor) -> Result<i32, Trouble> {
        Ok(self.read(MotorPosition { motor }).await?.0)
    }

    /// Whether a motor moves.
    pub(super) async fn is_running(&mut self, motor: Motor) -> Result<bool, Trouble> {
        Ok(self.read(MotorRunning { motor }).await?.get())
    }

    /// Sets the speed of a motor. Firmware answers OK to speeds that it does not accept, and cannot always report its
    /// speed.
    pub(super) async fn set_speed(&mut self, motor: Motor, speed: f32) -> Result<(), Trouble> {
        let message = MotorSetContinuousSpeed { motor, speed: StepsPerSecond(speed) };
        for _ in 1..TRIES {
            let ended = self.send(message.into()).await?;
            if ended.is_done() {
                return Ok(());
            }
            // A repeated speed has the same effect only while the motor rests.
            if !ended.is_unanswered() || self.is_running(motor).await? {
                return Err(trouble(&ended));
            }
        }
        self.set(message).await
    }
}

/// Trouble that tells how a message ended, and what may be the reason.
fn trouble(ended: &Ended) -> Trouble {
    match ended.outcome() {
        Outcome::Refused(Refusal::Device(_)) => {
            Trouble::Refused(format!("{ended}: is the node in joystick mode, or does its firmware not support this?"))
        }
        Outcome::Refused(Refusal::Invalid(_)) => Trouble::Refused(ended.to_string()),
        _ if ended.is_unanswered() => {
            Trouble::Failed(format!("{ended}: is the node on, is its address right, does its firmware support this?"))
        }
        _ => Trouble::Failed(ended.to_string()),
    }
}
