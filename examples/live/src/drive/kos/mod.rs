//! Commands as kOS has them.
//!
//! Over TCP a device plays its move alone, and finds its client again: a connection that is lost while a move runs is
//! made anew, and the move is followed to its end.

mod discover;
mod hand;
mod moves;
pub mod plan;
#[cfg(test)]
mod tests;

use std::fmt;
use std::io::Write;
use std::time::Duration;

use kos_proto::host::{self, CloseReason, Get, MoveState, Refusal};
use kos_proto::message::{ErrorCode, Motor, MotorAddress, Rotations, Seconds};
use motion_core::time::Millis;
use rigs::Host as _;
use rigs::kos_host::{Answer, Command as Order, Event, KosHost};
use tokio::time::Instant;

use super::{Command, Driven, Stopped, Trouble};
use crate::session::Session;

pub use discover::discover;

impl Driven for KosHost {
    const OPENS: bool = true;

    fn may_move(&self) -> bool {
        Self::may_move(self)
    }

    fn stop_all(&mut self, now: Millis) {
        // A lost connection is tried again ever less often: a stop does not wait for that.
        if matches!(self.machine().state(), host::State::Discovering | host::State::Disconnected) {
            self.command(now, Order::Connect);
        }
        self.command(now, Order::Do(host::Command::Stop));
    }

    fn stopped(event: &Event) -> Option<Stopped> {
        match event {
            Event::Stopped => Some(Stopped::Confirmed),
            Event::Told(host::Event::StopNotConfirmed(_)) => Some(Stopped::NotConfirmed),
            _ => None,
        }
    }
}

/// How a rig is driven.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// How fast motors go to where a move begins, as a part of their greatest speed: only who stands there knows how
    /// fast a camera may sweep through the room.
    pub home_speed: f32,
    /// How long a connection may take to be there, or there again while a move runs.
    pub patience: Duration,
}

impl Default for Options {
    /// A tenth of the greatest speed, and ten seconds.
    fn default() -> Self {
        Self { home_speed: 0.1, patience: Duration::from_secs(10) }
    }
}

/// Does a command, and writes what there is to say to `out`, line by line.
///
/// # Errors
///
/// [`Trouble`] says in one line why not, and what to do.
pub async fn drive(
    session: &mut Session<KosHost>,
    command: &Command,
    options: &Options,
    out: &mut (dyn Write + Send),
) -> Result<(), Trouble> {
    let mut drive = Drive { session, options: *options, out, said: None, error: None };
    if *command == Command::Stop {
        return drive.stop().await;
    }
    drive.connect().await?;
    match command {
        Command::Info => drive.info().await,
        Command::Jog { motor, speed, seconds } => drive.jog(*motor, *speed, *seconds).await,
        Command::Move { motor, position, speed } => drive.go(*motor, *position, *speed).await,
        Command::Calibrate { motor, begin, end } => drive.calibrate(*motor, *begin, *end).await,
        Command::Upload { file } => drive.upload(file).await,
        Command::Run { file, reverse } => drive.run(file, *reverse).await,
        Command::Program { file, shots } => drive.program(file, shots).await,
        Command::Expose { seconds } => drive.expose(*seconds).await,
        Command::Stop => Ok(()),
    }
}

/// A command that is being done.
struct Drive<'s> {
    session: &'s mut Session<KosHost>,
    options: Options,
    out: &'s mut (dyn Write + Send),
    /// When it was said last how far it is.
    said: Option<Instant>,
    /// What the rig said last that failed.
    error: Option<(ErrorCode, MotorAddress)>,
}

impl Drive<'_> {
    fn say(&mut self, line: fmt::Arguments<'_>) -> Result<(), Trouble> {
        let written = writeln!(self.out, "{line}").and_then(|()| self.out.flush());
        written.map_err(|error| Trouble::Failed(format!("nobody reads what is said here: {error}")))
    }

    /// Says how far it is, at most once a second.
    fn progress(&mut self, line: fmt::Arguments<'_>) -> Result<(), Trouble> {
        if self.said.is_some_and(|said| said.elapsed() < Duration::from_secs(1)) {
            return Ok(());
        }
        self.said = Some(Instant::now());
        self.say(line)
    }

    fn order(&mut self, command: host::Command) {
        self.session.command(Order::Do(command));
    }

    /// The next event within a time, if it is no trouble; what fails is kept in mind.
    ///
    /// A connection that is lost is trouble, unless a move goes on without it.
    async fn next(&mut self, time: Duration) -> Result<Option<Event>, Trouble> {
        let event = self.session.next_within(time).await?;
        match event {
            Some(Event::Told(host::Event::Error(ErrorCode::LOCKED_OUT, _))) => {
                return Err(Trouble::Refused("wrong password: give the one of the rig with --password".to_owned()));
            }
            Some(Event::Told(host::Event::Error(code, motor))) => self.error = Some((code, motor)),
            // A question of the kind is not answered yet: its answer will do.
            Some(Event::Told(host::Event::Refused(Refusal::Busy))) => {}
            Some(Event::Told(host::Event::Refused(why))) => return Err(refused(why)),
            Some(Event::Told(host::Event::Locked)) => {
                return Err(Trouble::Refused("the rig is locked: give its password with --password".to_owned()));
            }
            _ => {}
        }
        Ok(event)
    }

    /// Waits for something that the rig says; what fails meanwhile is trouble, and so is a lost connection.
    async fn wait<T>(
        &mut self,
        what: &str,
        time: Duration,
        mut look: impl FnMut(&Event) -> Option<T>,
    ) -> Result<T, Trouble> {
        let until = Instant::now() + time;
        self.error = None;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            match self.next(left).await? {
                Some(event) => {
                    if let Some(found) = look(&event) {
                        return Ok(found);
                    }
                    if let Event::Told(host::Event::Closed(why)) = event {
                        return Err(self.closed(why));
                    }
                    if let Some((code, motor)) = self.error {
                        return Err(failed(code, motor));
                    }
                }
                None if left.is_zero() => {
                    return Err(Trouble::Failed(format!("the rig does not say {what}: look what it does")));
                }
                None => {}
            }
        }
    }

    /// What is said of a lost connection.
    fn closed(&self, why: CloseReason) -> Trouble {
        let line = match why {
            CloseReason::Ended => self.session.why().unwrap_or("the rig hung up: is it on?"),
            CloseReason::Framing => "what it sends is not kOS: is this the address of a kOS rig?",
            CloseReason::NoAnswer => "it does not say what it is: is this the address of a kOS rig?",
            CloseReason::Silence => "the rig fell silent: look at its power, and at the network",
            _ => "the rig hung up: try again when it runs",
        };
        Trouble::Line(line.to_owned())
    }

    /// Until the rig can be used.
    async fn connect(&mut self) -> Result<(), Trouble> {
        self.session.command(Order::Connect);
        let ready = |event: &Event| matches!(event, Event::Told(host::Event::Ready { .. })).then_some(());
        self.wait("that it is ready", self.options.patience, ready).await
    }

    /// A motor of the rig.
    fn motor(&self, motor: u8) -> Result<Motor, Trouble> {
        let known = self.session.host().motor(MotorAddress(motor)).copied();
        known.filter(|_| motor > 0).ok_or_else(|| plan::no_motor(motor, &self.motors()))
    }

    fn motors(&self) -> Vec<Motor> {
        self.session.host().motors().copied().collect()
    }

    async fn ask(&mut self, get: Get) -> Result<Option<Answer>, Trouble> {
        self.session.command(Order::Ask(get));
        self.wait("what it was asked", self.options.patience, |event| match event {
            Event::Answer(answer) => Some(Some(answer.clone())),
            Event::Unanswered(..) => Some(None),
            _ => None,
        })
        .await
    }

    async fn info(&mut self) -> Result<(), Trouble> {
        if let Some(Answer::Device(device)) = self.ask(Get::DeviceInfo).await? {
            let (kind, firmware) = (device.device_type, device.firmware);
            self.say(format_args!("{kind}, firmware {firmware}; its move: {}", device.state))?;
        }
        if let Some(Answer::Network(network)) = self.ask(Get::NetworkInfo).await? {
            self.say(format_args!("network: {}, {}", network.ip_address, network.mac_address))?;
        }
        if let Some(Answer::Guid(guid)) = self.ask(Get::DeviceGuid).await? {
            let digits: Vec<String> = guid.iter().map(|byte| format!("{byte:02x}")).collect();
            self.say(format_args!("number: {}", digits.concat()))?;
        }
        for motor in self.motors() {
            let (number, position) = (motor.motor_address, motor.position);
            let (speed, acceleration) = (motor.max_max_move_speed.0, motor.max_max_acceleration.0);
            match (motor.relative_position(), motor.range()) {
                (Some(at), Some(range)) => self.say(format_args!(
                    "motor {number}: at {} of {} rotations, at most {speed} rev/s, {acceleration} rev/s²",
                    at.0, range.0
                ))?,
                _ => self.say(format_args!(
                    "motor {number}: at {} rotations, not calibrated, at most {speed} rev/s, {acceleration} rev/s²",
                    position.0
                ))?,
            }
        }
        Ok(())
    }

    async fn expose(&mut self, seconds: f64) -> Result<(), Trouble> {
        let exposure = time(seconds, 0.0)?;
        self.order(host::Command::TakePicture(exposure));
        // Photos are not answered; a question behind one is, and tells that nothing failed.
        self.ask(Get::DeviceInfo).await?;
        let until = Instant::now() + Duration::from_secs_f64(seconds);
        while let Some(left) = until.checked_duration_since(Instant::now()).filter(|left| !left.is_zero()) {
            if let Some(Event::Told(host::Event::Closed(why))) = self.next(left).await? {
                return Err(self.closed(why));
            }
        }
        self.say(format_args!(
            "the shutter was open for {seconds} s, if a camera is there: kOS does not confirm photos"
        ))
    }

    /// Stops everything, first of all; then again, when it is known which motors there are.
    async fn stop(&mut self) -> Result<(), Trouble> {
        self.session.command(Order::Connect);
        self.order(host::Command::Stop);
        let unconfirmed = || Trouble::Failed("the rig did not confirm the stop: press its emergency stop".to_owned());
        let until = Instant::now() + self.options.patience;
        let (mut stopped, mut ready) = (false, false);
        while !(stopped && ready) {
            let left = until.saturating_duration_since(Instant::now());
            match self.session.next_within(left).await? {
                Some(Event::Stopped) => stopped = true,
                // Who is locked may stop all the same.
                Some(Event::Told(host::Event::Ready { .. } | host::Event::Locked)) => ready = true,
                Some(Event::Told(host::Event::Closed(why))) => return Err(self.closed(why)),
                None if left.is_zero() => return Err(unconfirmed()),
                Some(_) | None => {}
            }
        }
        self.order(host::Command::Stop);
        let is = |event: &Event| (*event == Event::Stopped).then_some(());
        self.wait("that all rests", self.options.patience, is).await.map_err(|trouble| match trouble {
            Trouble::Failed(_) => unconfirmed(),
            trouble => trouble,
        })?;
        self.say(format_args!("everything rests: the rig confirmed the stop"))
    }

    fn move_state(&self) -> MoveState {
        self.session.host().machine().move_state()
    }
}

/// A time that makes sense.
#[expect(clippy::cast_possible_truncation, reason = "the protocol has no other number")]
fn time(seconds: f64, least: f64) -> Result<Seconds, Trouble> {
    if seconds.is_finite() && seconds >= least && seconds <= 86_400.0 {
        return Ok(Seconds(seconds as f32));
    }
    Err(Trouble::Refused(format!("{seconds} s: give a time from {least} to 86400 seconds")))
}

/// Why a command was not even sent.
fn refused(why: Refusal) -> Trouble {
    Trouble::Refused(
        match why {
            Refusal::MoveRuns => "a move runs on the rig: stop it first (drive kos ADDRESS stop)",
            Refusal::Moves => "something moves on the rig: stop it first (drive kos ADDRESS stop)",
            Refusal::NoMotor => "the rig has no such motor: see drive kos ADDRESS info",
            Refusal::Number => "a number is none, or not positive where it should be",
            Refusal::NotConnected | Refusal::NotReady => "there is no connection to the rig: try again",
            _ => "the rig cannot do that now: try again",
        }
        .to_owned(),
    )
}

/// What the rig says that failed.
fn failed(code: ErrorCode, motor: MotorAddress) -> Trouble {
    let what = match code {
        ErrorCode::CANNOT_EXECUTE_MOVE => {
            "the rig cannot do that now: something moves, or a motor of the move is not calibrated".to_owned()
        }
        ErrorCode::BAD_MOTOR_ADDRESS => format!("the rig has no motor {motor}: see drive kos ADDRESS info"),
        ErrorCode::NO_MOTORS => "the rig has no motors: look at its cables".to_owned(),
        ErrorCode::TRAJECTORY => "the rig does not understand the move".to_owned(),
        ErrorCode::RETURN_TO_FIRST_KEYFRAME => {
            "a motor did not get to where the move begins: look what is in its way".to_owned()
        }
        ErrorCode::INVALID_MOVE_TIME => "the rig does not take the time of the move".to_owned(),
        ErrorCode::CALIBRATION => format!("motor {motor} has no range: calibrate it again"),
        code if code.resets_axis() => format!(
            "motor {motor} has a fault ({code}), and its range is forgotten: look what is in its way, then calibrate it again"
        ),
        code if code.names_motor() => format!("motor {motor} lost its move ({code}): look what is in its way"),
        code => format!("the rig says that something failed: {code}"),
    };
    Trouble::Failed(what)
}

/// Rotations as people read them.
struct Shown(Rotations);

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(Rotations(number)) = self;
        let digits = format!("{number:.3}");
        let digits = digits.trim_end_matches('0').trim_end_matches('.');
        f.write_str(if digits == "-0" { "0" } else { digits })
    }
}
