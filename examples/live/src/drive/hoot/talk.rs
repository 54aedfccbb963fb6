//! Requests and their results, and the decisions of the application when a node does not answer.

use std::io::Write;
use std::time::Duration;

use hoot_proto::host::{Command, Event as Told, Failure, NotTaken, Outcome, Request, Token};
use hoot_proto::message::{self, Motor, MotorPosition, MotorRunning, ResponseCode, StepsPerSecond};
use hoot_proto::query::{AnyReply, Facts};
use hoot_proto::{Address, HostMessage};
use motion_core::wire::Bool;
use rigs::hoot_master::{Ended, Event, HootMaster};
use tokio::time::Instant;

use crate::drive::Trouble;
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
    pub(super) out: &'a mut dyn Write,
    token: u32,
    /// Time at which progress was printed last.
    told: Option<Instant>,
}

impl<'a> Talk<'a> {
    pub(super) fn new(
        session: &'a mut Session<HootMaster>,
        node: Address,
        home_speed: f32,
        out: &'a mut dyn Write,
    ) -> Self {
        Self { session, node, home_speed, out, token: 0, told: None }
    }

    /// Prints a line.
    pub(super) fn say(&mut self, line: &str) -> Result<(), Trouble> {
        let said = writeln!(self.out, "{line}").and_then(|()| self.out.flush());
        said.map_err(|error| Trouble::Failed(format!("the output cannot be written: {error}")))
    }

    /// Prints a line, unless one was printed less than a second ago.
    pub(super) fn progress(&mut self, line: impl FnOnce() -> String) -> Result<(), Trouble> {
        if self.told.is_none_or(|told| told.elapsed() >= TELL) {
            self.told = Some(Instant::now());
            self.say(&line())?;
        }
        Ok(())
    }

    /// Properties of the firmware.
    pub(super) fn facts(&self) -> &'static Facts {
        self.session.host().profile(self.node).facts()
    }

    /// Sends a request once, and waits for its result.
    pub(super) async fn send(&mut self, message: HostMessage<'static>) -> Result<Ended, Trouble> {
        self.token = self.token.wrapping_add(1);
        let token = Token(self.token);
        self.session.command(Command::Request(Request { token, to: self.node, message }));
        loop {
            match self.session.next().await? {
                Event::Ended(ended) if ended.token == token => return Ok(ended),
                event => self.overhear(&event)?,
            }
        }
    }

    /// Handles an event that does not belong to the request.
    pub(super) fn overhear(&mut self, event: &Event) -> Result<(), Trouble> {
        if let Event::Told(Told::KeepAliveLost { to }) = event {
            self.say(&format!("node {} did not answer in time: its dead-man switch may have stopped it", to.0))?;
        }
        Ok(())
    }

    /// Trouble that explains why a request was not done.
    fn trouble(&self, ended: &Ended) -> Trouble {
        let (node, message) = (self.node.0, &ended.message);
        match &ended.outcome {
            Outcome::Refused(received) if received.reply().code == ResponseCode::ERROR => Trouble::Refused(format!(
                "node {node} refuses {message}: is it in joystick mode, or does its firmware not support this?"
            )),
            Outcome::Failed(Failure::Silence) => Trouble::Failed(format!(
                "node {node} does not answer {message}: is it on, is its address right, does its firmware support this?"
            )),
            Outcome::Failed(Failure::NotTaken(NotTaken::Lint(lint))) => Trouble::Refused(format!("{message}: {lint}")),
            _ => Trouble::Failed(ended.to_string()),
        }
    }

    /// Sends a query, and repeats it if it is not answered.
    pub(super) async fn ask(&mut self, query: HostMessage<'static>) -> Result<Ended, Trouble> {
        for _ in 1..TRIES {
            let ended = self.send(query).await?;
            if !ended.is_silence() {
                return self.answered(ended);
            }
        }
        let ended = self.send(query).await?;
        self.answered(ended)
    }

    fn answered(&self, ended: Ended) -> Result<Ended, Trouble> {
        if ended.answer().is_some() { Ok(ended) } else { Err(self.trouble(&ended)) }
    }

    /// Sends a setting while nothing moves. A setting without an answer is repeated, because repeating has the same
    /// effect as sending once. Other messages are sent once: those that may start motion, toggles, photos, addresses.
    pub(super) async fn set(&mut self, message: HostMessage<'static>) -> Result<(), Trouble> {
        let once =
            message.may_start_motion() || matches!(message, HostMessage::SetPingPong(_) | HostMessage::CameraExpose(_));
        let mut ended = self.send(message).await?;
        for _ in 1..TRIES {
            if once || !ended.is_silence() {
                break;
            }
            ended = self.send(message).await?;
        }
        if ended.is_done() { Ok(()) } else { Err(self.trouble(&ended)) }
    }

    /// Sets a value and reads it back, because firmware may answer OK without setting it.
    pub(super) async fn set_and_see(
        &mut self,
        message: HostMessage<'static>,
        query: HostMessage<'static>,
        is_so: impl Fn(AnyReply<'_>) -> bool,
    ) -> Result<(), Trouble> {
        self.set(message).await?;
        let ended = self.ask(query).await?;
        match ended.answer() {
            Some(answer) if is_so(answer) => Ok(()),
            answer => {
                let found = answer.map(|answer| answer.to_string()).unwrap_or_default();
                let node = self.node.0;
                Err(Trouble::Failed(format!("node {node} answered OK to {message}, but has {found}: try again")))
            }
        }
    }

    /// Starts motion. The message is sent only once. Returns `false` if it was not answered: the motor may move or not.
    pub(super) async fn set_off(&mut self, message: HostMessage<'static>) -> Result<bool, Trouble> {
        let ended = self.send(message).await?;
        match ended.is_done() {
            true => Ok(true),
            false if ended.is_silence() => Ok(false),
            false => Err(self.trouble(&ended)),
        }
    }

    /// Position of a motor, in steps.
    pub(super) async fn position(&mut self, motor: Motor) -> Result<i32, Trouble> {
        let query = MotorPosition { motor };
        let ended = self.ask(HostMessage::MotorPosition(query)).await?;
        ended.read(&query).map(|steps| steps.0).ok_or_else(|| self.trouble(&ended))
    }

    /// Whether a motor moves.
    pub(super) async fn is_running(&mut self, motor: Motor) -> Result<bool, Trouble> {
        let query = MotorRunning { motor };
        let ended = self.ask(HostMessage::MotorRunning(query)).await?;
        ended.read(&query).map(Bool::get).ok_or_else(|| self.trouble(&ended))
    }

    /// Sets the speed of a motor. Firmware answers OK to speeds that it does not accept, and cannot always report its
    /// speed.
    pub(super) async fn set_speed(&mut self, motor: Motor, speed: f32) -> Result<(), Trouble> {
        let speed = StepsPerSecond(speed);
        let message = HostMessage::MotorSetContinuousSpeed(message::MotorSetContinuousSpeed { motor, speed });
        for _ in 1..TRIES {
            let ended = self.send(message).await?;
            if ended.is_done() {
                return Ok(());
            }
            // A repeated speed has the same effect only while the motor rests.
            if !ended.is_silence() || self.is_running(motor).await? {
                return Err(self.trouble(&ended));
            }
        }
        self.set(message).await
    }
}
