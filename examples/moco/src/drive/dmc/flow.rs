//! Requests to the rig, waiting for their results, and the events that arrive meanwhile.

use std::fmt;
use std::time::Duration;

use dmc_proto::Token;
use dmc_proto::host::{self, Failure, Outcome, Refusal, State, StopTarget};
use dmc_proto::message::{
    AckCode, FrameNumber, GioCam, Hi, HostMessage, Motor, MotorGetPosition, MotorJog, MotorStatusRequest, Motors,
};
use motion_rigs::dmc_host::{Answer, Command, DmcHost, Event, Positions, Progress, Shot};
use tokio::time::Instant;

use super::plan::Plan;
use super::why;
use crate::drive::Trouble;
use crate::drive::output::{About, At, Output};
use crate::session::{STOP, Session};

/// Time between two questions whether motors still move.
const ASK: Duration = Duration::from_millis(100);
/// Time between two requests of a jog that is held. Some devices end a jog by themselves after 0.6 s.
const REPEAT: Duration = Duration::from_millis(200);
/// Least time between two lines of progress.
const TELL: Duration = Duration::from_secs(1);

/// Command that is in progress.
pub(super) struct Flow<'s> {
    pub(super) session: &'s mut Session<DmcHost>,
    out: &'s mut (dyn Output + Send),
    last: u32,
    told: Instant,
    /// Whether a message arrived whose data end too soon.
    is_malformed: bool,
}

impl<'s> Flow<'s> {
    pub(super) fn new(session: &'s mut Session<DmcHost>, out: &'s mut (dyn Output + Send)) -> Self {
        Self { session, out, last: 0, told: Instant::now(), is_malformed: false }
    }

    /// Prints a line. If the output is closed, the command fails, because its user could not see what moves.
    pub(super) fn print(&mut self, line: fmt::Arguments<'_>) -> Result<(), Trouble> {
        self.line(About::Note, line)
    }

    /// Prints a line with its meaning.
    pub(super) fn line(&mut self, about: About, line: fmt::Arguments<'_>) -> Result<(), Trouble> {
        let written = self.out.line(about, line);
        written.map_err(|error| Trouble::Failed(format!("the output cannot be written: {error}")))
    }

    /// Waits until the device is known.
    pub(super) async fn up(&mut self) -> Result<(), Trouble> {
        if self.session.host().machine().state() == State::Ready {
            return Ok(());
        }
        loop {
            match self.session.next().await? {
                Event::Machine(host::Event::Ready { .. }) => return Ok(()),
                Event::Machine(host::Event::Silent) => {
                    return Err(Trouble::Line(
                        "no DMC rig answers: check that it is on, that this is its line, and the speed of the line"
                            .to_owned(),
                    ));
                }
                _ => {}
            }
        }
    }

    /// Greeting of the device, with its properties.
    pub(super) fn device(&self) -> Result<Hi<'static>, Trouble> {
        let lost = || Trouble::Failed("the rig was reset and has lost all data: start again".to_owned());
        self.session.host().machine().device().ok_or_else(lost)
    }

    /// Whether the rig has limit switches, as far as is known.
    fn has_switches(&self) -> bool {
        self.session.host().machine().device().is_none_or(|hi| hi.hw_limit_count > 0)
    }

    /// Motor with a number from the command line, if the device has it.
    pub(super) fn motor(&self, number: u8) -> Result<Motor, Trouble> {
        let count = self.device()?.motor_count;
        if (1..=count).contains(&number) {
            return Ok(Motor(number));
        }
        let has = if count == 0 { "no motors".to_owned() } else { format!("motors 1 to {count}") };
        Err(Trouble::Refused(format!("there is no motor {number}: this rig has {has}")))
    }

    /// Checks whether the device can take a move.
    pub(super) fn fits(&self, plan: &Plan) -> Result<(), Trouble> {
        let hi = self.device()?;
        if let Some(motor) = plan.motors().iter().find(|motor| motor.0 > hi.motor_count) {
            let count = hi.motor_count;
            return Err(Trouble::Refused(format!(
                "the move needs motor {motor}, but the last motor of this rig is {count}: change the file"
            )));
        }
        let frames = plan.last.0 - plan.first.0 + 1;
        if u32::try_from(frames).unwrap_or(u32::MAX) > hi.upload_frame_count {
            let room = hi.upload_frame_count;
            return Err(Trouble::Refused(format!(
                "the move has {frames} frames, but the rig has room for {room}: make it shorter, or its \"rate\" lower"
            )));
        }
        let fits = self.session.host().fits(&plan.table);
        fits.map(|_| ()).map_err(|error| Trouble::Refused(format!("this rig cannot take the move: {error}")))
    }

    /// Next event of the host within a time, or the trouble that it means.
    async fn event(&mut self, within: Duration) -> Result<Option<Event>, Trouble> {
        let event = self.session.next_within(within).await?;
        match event {
            Some(Event::Machine(host::Event::HardStop(reason, motor))) => {
                Err(why::hard_stop(reason, motor, self.has_switches()))
            }
            Some(Event::Machine(host::Event::DeviceReset)) => {
                Err(why::not_done("the command", Outcome::Failed(Failure::DeviceReset), self.has_switches()))
            }
            event => {
                self.is_malformed |= matches!(event, Some(Event::Machine(host::Event::Malformed(..))));
                Ok(event)
            }
        }
    }

    const fn token(&mut self) -> Token {
        self.last += 1;
        Token(self.last)
    }

    /// Sends a request and waits for the answer.
    pub(super) async fn ask(
        &mut self,
        what: &str,
        message: impl Into<HostMessage<'static>>,
    ) -> Result<Answer, Trouble> {
        let token = self.send(message);
        self.end(what, token).await
    }

    fn send(&mut self, message: impl Into<HostMessage<'static>>) -> Token {
        let token = self.token();
        self.session.command(Command::Ask(token, message.into()));
        token
    }

    async fn end(&mut self, what: &str, token: Token) -> Result<Answer, Trouble> {
        let end = self.ended(token).await?;
        self.done(what, end)
    }

    /// Waits for the end of a command.
    async fn ended(&mut self, token: Token) -> Result<Result<Answer, Outcome<'static>>, Trouble> {
        loop {
            match self.event(STOP).await? {
                Some(Event::Ended(ended, end)) if ended == token => return Ok(end),
                _ => {}
            }
        }
    }

    /// Answer of a command, or the trouble that its end means.
    fn done(&mut self, what: &str, end: Result<Answer, Outcome<'static>>) -> Result<Answer, Trouble> {
        let is_malformed = std::mem::take(&mut self.is_malformed);
        end.map_err(|outcome| match outcome {
            Outcome::Failed(Failure::NoAnswer) if is_malformed => Trouble::Failed(format!(
                "{what} failed: the answers of the rig end too soon: is it a DMC rig, of version 2?"
            )),
            _ => why::not_done(what, outcome, self.has_switches()),
        })
    }

    /// Closes the shutter. A rig that does not know the request has no shutter.
    pub(super) async fn close_shutter(&mut self) -> Result<(), Trouble> {
        let token = self.send(GioCam::default());
        match self.ended(token).await? {
            Err(Outcome::Refused(
                Refusal::Device(AckCode::ERR_UNSUPPORTED) | Refusal::WouldBeRefused(AckCode::ERR_UNSUPPORTED),
            )) => Ok(()),
            end => self.done("the end of the photo", end).map(|_| ()),
        }
    }

    /// Jogs for a time. The request is repeated as long as the jog is held. No request of the jog is under way when this
    /// returns. The motor still jogs: stop it.
    pub(super) async fn hold(&mut self, jog: MotorJog<'static>, time: Duration) -> Result<(), Trouble> {
        let until = Instant::now() + time;
        loop {
            self.ask("the jog", jog).await?;
            let left = until.saturating_duration_since(Instant::now());
            self.pass(left.min(REPEAT)).await?;
            if left <= REPEAT {
                return Ok(());
            }
        }
    }

    pub(super) fn begin(&mut self, message: impl Into<HostMessage<'static>>) -> Token {
        let token = self.token();
        self.session.command(Command::Begin(token, message.into()));
        token
    }

    pub(super) fn shoot(&mut self, shot: Shot) -> Token {
        let token = self.token();
        self.session.command(Command::Shoot(token, shot));
        token
    }

    pub(super) async fn upload(&mut self, plan: &Plan) -> Result<(), Trouble> {
        let token = self.token();
        let before = self.session.written();
        self.session.command(Command::Upload(token, plan.table.clone()));
        let end = loop {
            match self.event(TELL).await? {
                Some(Event::Ended(ended, end)) if ended == token => break end,
                _ => self.uploads(plan, before)?,
            }
        };
        self.done("the upload", end)?;
        let frames = plan.last.0 - plan.first.0 + 1;
        self.print(format_args!("uploaded: {frames} frames of motors {}", plan.motors()))
    }

    /// Prints which part of an upload is sent, by the number of bytes that were sent `before` it. Nearly all of its bytes are
    /// steps, four bytes each.
    fn uploads(&mut self, plan: &Plan, before: u64) -> Result<(), Trouble> {
        let bytes = u32::try_from(self.session.written() - before).unwrap_or(u32::MAX);
        let part = (f64::from(bytes) / (4.0 * f64::from(plan.sent))).min(1.0);
        self.tell(Some(part), Vec::new(), &format!("the move is uploaded: {:.0} %", 100.0 * part))
    }

    /// Starts a run or a shot when it is armed, and waits for its end. For a run, prints how many of its `frames` are
    /// played, from the first to the last.
    pub(super) async fn play(
        &mut self,
        what: &str,
        token: Token,
        frames: Option<(FrameNumber, FrameNumber)>,
    ) -> Result<(), Trouble> {
        loop {
            match self.event(STOP).await? {
                Some(Event::Machine(host::Event::Armed(armed))) if armed == token => self.session.command(Command::Go),
                Some(Event::Ended(ended, end)) if ended == token => {
                    return end.map(|_| ()).map_err(|outcome| why::not_done(what, outcome, self.has_switches()));
                }
                Some(Event::Positions(positions)) => {
                    let runs = self.session.host().machine().progress() == Some(Progress::Runs);
                    let frame = positions.moment.0.0 / 1000;
                    match frames {
                        Some((first, last)) if runs => {
                            let (gone, all) = (frame - first.0, (last.0 - first.0).max(1));
                            let part = Some(f64::from(gone) / f64::from(all));
                            self.tell(part, at(&positions), &format!("frame {frame} of {last}"))?;
                        }
                        _ => self.tell(None, at(&positions), &places(&positions))?,
                    }
                }
                _ => {}
            }
        }
    }

    /// Prints a line of progress, if the last one is long enough ago. `part` is the part of the command that is done.
    fn tell(&mut self, part: Option<f64>, positions: Vec<At>, text: &str) -> Result<(), Trouble> {
        if self.told.elapsed() >= TELL {
            self.told = Instant::now();
            self.line(About::Progress { part, positions }, format_args!("{text}"))?;
        }
        Ok(())
    }

    /// Waits for a time, and prints the progress.
    pub(super) async fn pass(&mut self, time: Duration) -> Result<(), Trouble> {
        let until = Instant::now() + time;
        while let Some(left) = until.checked_duration_since(Instant::now()).filter(|left| !left.is_zero()) {
            if let Some(Event::Positions(positions)) = self.event(left).await? {
                self.tell(None, at(&positions), &places(&positions))?;
            }
        }
        Ok(())
    }

    /// Motors that move now.
    pub(super) async fn status(&mut self) -> Result<Motors, Trouble> {
        let answer = self.ask("the question which motors move", MotorStatusRequest::default()).await?;
        if let Answer::Moving(motors) = answer {
            return Ok(motors);
        }
        Err(Trouble::Failed("the rig does not say which motors move: check the rig".to_owned()))
    }

    /// Waits until all motors rest.
    pub(super) async fn rest(&mut self) -> Result<(), Trouble> {
        while self.status().await? != Motors::NONE {
            self.pass(ASK).await?;
        }
        Ok(())
    }

    /// Positions of all motors, in steps.
    pub(super) async fn positions(&mut self) -> Result<Vec<i32>, Trouble> {
        let answer = self.ask("the question for positions", MotorGetPosition::default()).await?;
        if let Answer::Positions(Positions { positions, .. }) = answer { Ok(positions) } else { Ok(Vec::new()) }
    }

    pub(super) async fn position(&mut self, motor: Motor) -> Result<i32, Trouble> {
        let positions = self.positions().await?;
        let index = usize::from(motor.0).saturating_sub(1);
        positions
            .get(index)
            .copied()
            .ok_or_else(|| Trouble::Failed(format!("the rig does not report the position of motor {motor}")))
    }

    /// Sends a stop, and waits until it is confirmed.
    pub(super) async fn stop(&mut self, target: StopTarget) -> Result<(), Trouble> {
        self.session.command(Command::Stop(target));
        let until = Instant::now() + STOP;
        while let Some(left) = until.checked_duration_since(Instant::now()).filter(|left| !left.is_zero()) {
            // A hard stop also stops the motors, but it does not confirm this stop.
            if let Some(Event::Machine(host::Event::Stopped(stopped))) = self.session.next_within(left).await?
                && (stopped == target || stopped == StopTarget::All)
            {
                return Ok(());
            }
        }
        Err(Trouble::Failed(format!("the rig did not confirm a stop in {} s", STOP.as_secs())))
    }
}

fn at(positions: &Positions) -> Vec<At> {
    (1..).zip(&positions.positions).map(|(motor, &steps)| At { motor, position: steps.into() }).collect()
}

fn places(positions: &Positions) -> String {
    let places: Vec<_> = positions.positions.iter().map(i32::to_string).collect();
    format!("motors at {} steps", places.join(", "))
}
