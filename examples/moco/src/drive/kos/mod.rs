//! Commands with kOS.
//!
//! Over TCP a device plays its move without the client. If the connection is lost while a move runs, the client
//! connects again and follows the move to its end.

mod discover;
mod motors;
mod moves;
pub mod plan;
#[cfg(test)]
mod tests;

use std::fmt;
use std::time::Duration;

use kos_proto::host::{self, Failure, Get, LinkDownReason, MoveState, Outcome, Refusal, StopTarget, Token};
use kos_proto::message::{ActionId, ErrorCode, Motor, MotorAddress, Rotations, Seconds};
use kos_proto::{Device, DeviceMessage, HostMessage, MessageId, Owned};
use motion_core::time::Millis;
use motion_core::wire::Messages as _;
use motion_rigs::Host as _;
use motion_rigs::kos_host::{Command as Order, Event, KosHost};
use tokio::time::Instant;

use super::output::{About, At, Output};
use super::{Command, Driven, OBEYED, Stopped, Trouble};
use crate::session::{STOP, Session};

pub use discover::discover;

/// Time that a motor may take in addition to the computed time.
const SPARE: Duration = Duration::from_secs(10);
/// Time in which a locked rig shows whether it obeys a stop.
const LOCKED: Duration = Duration::from_millis(500);

impl Driven for KosHost {
    const ASKS: bool = <host::Session as motion_core::session::Session>::ASKS;

    fn is_deaf(&self) -> bool {
        self.machine().state() == host::State::Locked
    }

    fn may_move(&self) -> bool {
        self.machine().may_move()
    }

    fn stop_all(&mut self, now: Millis) {
        // The pauses between attempts to connect again become longer. A stop does not wait for the next attempt.
        if matches!(self.machine().state(), host::State::Discovering | host::State::Disconnected) {
            self.command(now, (Token::default(), Order::Connect));
        }
        self.command(now, (Token::default(), Order::Machine(host::Command::Stop)));
    }

    fn stopped(event: &Event) -> Option<Stopped> {
        match event {
            Event::Machine(host::Event::Stopped(StopTarget::All)) => Some(Stopped::Confirmed),
            Event::Machine(host::Event::StopNotConfirmed(_)) => Some(Stopped::NotConfirmed),
            _ => None,
        }
    }
}

/// Options of the commands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Speed with which motors go to the start of a move, as a part of their greatest speed. Only a person at the rig
    /// knows which speed is safe.
    pub home_speed: f32,
    /// Time within which a connection must be made, or made again while a move runs.
    pub patience: Duration,
}

impl Default for Options {
    /// Home speed of a tenth of the greatest speed, and a patience of ten seconds.
    fn default() -> Self {
        Self { home_speed: 0.1, patience: STOP }
    }
}

/// Does a command, and writes its results to `out`, line by line.
///
/// # Errors
///
/// [`Trouble`], which says in one line why the command was not done, and what to do.
pub async fn drive(
    session: &mut Session<KosHost>,
    command: &Command,
    options: &Options,
    out: &mut (dyn Output + Send),
) -> Result<(), Trouble> {
    let mut drive = Drive { session, options: *options, out, token: Token::default(), said: None, error: None };
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

/// Command that is in progress.
struct Drive<'s> {
    session: &'s mut Session<KosHost>,
    options: Options,
    out: &'s mut (dyn Output + Send),
    /// Token of the last command.
    token: Token,
    /// Time at which progress was printed last.
    said: Option<Instant>,
    /// Last failure that the rig reported.
    error: Option<(ErrorCode, MotorAddress)>,
}

impl Drive<'_> {
    fn print(&mut self, line: fmt::Arguments<'_>) -> Result<(), Trouble> {
        self.line(About::Note, line)
    }

    /// Prints a line with its meaning.
    fn line(&mut self, about: About, line: fmt::Arguments<'_>) -> Result<(), Trouble> {
        let written = self.out.line(about, line);
        written.map_err(|error| Trouble::Failed(format!("the output cannot be written: {error}")))
    }

    /// Prints a line of progress, at most once per second. `part` is the part of the command that is done.
    fn progress(&mut self, part: Option<f64>, positions: Vec<At>, line: fmt::Arguments<'_>) -> Result<(), Trouble> {
        if self.said.is_some_and(|said| said.elapsed() < Duration::from_secs(1)) {
            return Ok(());
        }
        self.said = Some(Instant::now());
        self.line(About::Progress { part, positions }, line)
    }

    /// Gives a command to the client.
    fn order(&mut self, order: Order) -> Token {
        self.token.0 += 1;
        self.session.command((self.token, order));
        self.token
    }

    fn command(&mut self, command: host::Command) -> Token {
        self.order(Order::Machine(command))
    }

    /// Next event within a time, or the trouble that it means. A failure that the rig reports is stored in `error`.
    ///
    /// The caller decides whether a lost connection is trouble, because a move goes on without it.
    async fn next(&mut self, time: Duration) -> Result<Option<Event>, Trouble> {
        let event = self.session.next_within(time).await?;
        match event {
            Some(Event::Machine(host::Event::Error(ErrorCode::LOCKED_OUT, _))) => {
                return Err(Trouble::Refused(
                    "wrong password: give the password of the rig with --password".to_owned(),
                ));
            }
            Some(Event::Machine(host::Event::Error(code, motor))) => self.error = Some((code, motor)),
            // A question of this kind is not answered yet, and its answer is enough. If the rig does not know a message, the
            // command decides whether something else is tried.
            Some(Event::Machine(host::Event::Ended {
                outcome: Outcome::Refused(Refusal::Busy | Refusal::Unsupported { .. }),
                ..
            })) => {}
            Some(Event::Machine(host::Event::Ended { outcome: Outcome::Refused(why), .. })) => {
                return Err(refused(why));
            }
            Some(Event::Machine(host::Event::Locked { .. })) => {
                return Err(Trouble::Refused("the rig is locked: give its password with --password".to_owned()));
            }
            Some(Event::Machine(host::Event::Unsupported { action: Some(action), .. }))
                if !matches!(action, ActionId::BUMP_POSITION_SPEED_ACCELERATION | ActionId::SETUP_PLAYBACK) =>
            {
                return Err(unknown(MessageId::ACTION, Some(action)));
            }
            _ => {}
        }
        Ok(event)
    }

    /// Looks for an event within a time. A failure meanwhile is trouble, and so is a lost connection.
    async fn look<T>(
        &mut self,
        time: Duration,
        mut look: impl FnMut(&Event) -> Option<T>,
    ) -> Result<Option<T>, Trouble> {
        let until = Instant::now() + time;
        self.error = None;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            match self.next(left).await? {
                Some(event) => {
                    if let Some(found) = look(&event) {
                        return Ok(Some(found));
                    }
                    if let Event::Machine(host::Event::LinkDown(why)) = event {
                        return Err(self.lost(why));
                    }
                    if let Some((code, motor)) = self.error {
                        return Err(failed(code, motor));
                    }
                }
                None if left.is_zero() => return Ok(None),
                None => {}
            }
        }
    }

    /// Waits for a message of the rig.
    async fn wait<T>(
        &mut self,
        what: &str,
        time: Duration,
        look: impl FnMut(&Event) -> Option<T>,
    ) -> Result<T, Trouble> {
        self.look(time, look).await?.ok_or_else(|| Trouble::Failed(not_reported(what)))
    }

    /// Lets a time pass.
    async fn pass(&mut self, time: Duration) -> Result<(), Trouble> {
        self.look(time, |_| None::<()>).await.map(|_| ())
    }

    /// Stops a motor, and waits until it rests. Returns its position.
    async fn rest(&mut self, motor: MotorAddress) -> Result<Rotations, Trouble> {
        self.command(host::Command::StopMotor(motor));
        let stopped = Event::Machine(host::Event::Stopped(StopTarget::Motor(motor)));
        self.wait("that the motor rests", SPARE, |event| (*event == stopped).then_some(())).await?;
        Ok(self.motor(motor.0)?.position)
    }

    /// Waits until a command is done.
    async fn done(&mut self, token: Token, what: &str, time: Duration) -> Result<(), Trouble> {
        let outcome = self.wait(what, time, |event| ended(event, token)).await?;
        is_done(outcome, what)
    }

    /// Trouble that a lost connection means.
    fn lost(&self, why: LinkDownReason) -> Trouble {
        let hint = match why {
            LinkDownReason::Ended => {
                let line = self.session.why();
                return Trouble::Line(line.unwrap_or_else(|| "the rig closed the connection: is it on?".to_owned()));
            }
            LinkDownReason::Framing | LinkDownReason::NoAnswer => "is this the address of a kOS rig?",
            LinkDownReason::Silence => "check its power and the network",
            _ => "try again when it runs",
        };
        Trouble::Line(format!("{why}: {hint}"))
    }

    /// Connects, and waits until the rig can be used.
    async fn connect(&mut self) -> Result<(), Trouble> {
        self.order(Order::Connect);
        let ready = |event: &Event| matches!(event, Event::Machine(host::Event::Ready { .. })).then_some(());
        self.wait("that it is ready", self.options.patience, ready).await
    }

    /// Motor of the rig with this number.
    fn motor(&self, motor: u8) -> Result<Motor, Trouble> {
        let known = self.session.host().motor(MotorAddress(motor)).copied();
        known.filter(|_| motor > 0).ok_or_else(|| plan::no_motor(motor, &self.motors()))
    }

    fn motors(&self) -> Vec<Motor> {
        self.session.host().machine().motors().copied().collect()
    }

    /// Answer to a question; `None` if the rig does not answer it.
    async fn ask(&mut self, get: Get) -> Result<Option<Owned<Device>>, Trouble> {
        let token = self.command(host::Command::Get(get));
        self.wait("the answer to a question", self.options.patience, |event| match event {
            Event::Answer(answered, answer) if *answered == token => Some(Some(answer.clone())),
            event => ended(event, token).map(|_| None),
        })
        .await
    }

    async fn info(&mut self) -> Result<(), Trouble> {
        for get in [Get::DeviceInfo, Get::NetworkInfo, Get::DeviceGuid] {
            let Some(answer) = self.ask(get).await? else { continue };
            match answer.message() {
                DeviceMessage::DeviceInfo(info) => {
                    let (kind, firmware, state) = (info.device_type, info.firmware_version, info.playback_status);
                    self.print(format_args!("{kind}, firmware {firmware}; state of its move: {state}"))?;
                }
                DeviceMessage::NetworkInfo(info) => {
                    self.print(format_args!("network: {}, {}", info.ip_address, info.mac_address))?;
                }
                DeviceMessage::DeviceGUID(guid) => self.print(format_args!("GUID: {}", guid.guid))?,
                _ => {}
            }
        }
        for motor in self.motors() {
            let (number, position) = (motor.motor_address, motor.position);
            let (speed, acceleration) = (motor.max_max_move_speed.0, motor.max_max_acceleration.0);
            match (motor.relative_position(), motor.range()) {
                (Some(at), Some(range)) => self.line(
                    About::position(number.number(), at.0),
                    format_args!(
                        "motor {number}: at {} of {} rotations, at most {speed} rev/s, {acceleration} rev/s²",
                        at.0, range.0
                    ),
                )?,
                _ => self.line(
                    About::position(number.number(), position.0),
                    format_args!(
                        "motor {number}: at {} rotations, not calibrated, at most {speed} rev/s, {acceleration} rev/s²",
                        position.0
                    ),
                )?,
            }
        }
        Ok(())
    }

    async fn expose(&mut self, seconds: f64) -> Result<(), Trouble> {
        let exposure = time(seconds, 0.0)?;
        self.command(host::Command::TakePicture(exposure));
        // Photos are not answered. The answer to a question after a photo shows that nothing failed.
        self.ask(Get::DeviceInfo).await?;
        self.pass(Duration::from_secs_f64(seconds)).await?;
        self.print(format_args!(
            "the shutter was open for {seconds} s, if a camera is connected: kOS does not confirm photos"
        ))
    }

    /// Stops everything at once, and waits until the rig confirms that all motors rest.
    async fn stop(&mut self) -> Result<(), Trouble> {
        self.order(Order::Connect);
        self.command(host::Command::Stop);
        let mut until = Instant::now() + self.options.patience;
        let (mut obeyed, mut locked) = (false, false);
        let mut unconfirmed = "the rig did not confirm the stop: press its emergency stop";
        loop {
            let left = until.saturating_duration_since(Instant::now());
            let lost = match self.session.next_within(left).await? {
                Some(event) if KosHost::stopped(&event) == Some(Stopped::Confirmed) => {
                    return self.print(format_args!("all motors rest: the rig confirmed the stop"));
                }
                Some(Event::Machine(host::Event::Move(host::Move::Finished { requested: true }))) => {
                    obeyed = true;
                    continue;
                }
                // A rig may obey a stop without the password, or ignore it. It says so at once.
                Some(Event::Machine(host::Event::Locked { wrong_password })) => {
                    unconfirmed = if wrong_password {
                        "wrong password: the rig may ignore the stop: press its emergency stop, or give its password with \
                         --password"
                    } else {
                        "the rig is locked and may ignore the stop: press its emergency stop, or give its password with \
                         --password"
                    };
                    (locked, until) = (true, until.min(Instant::now() + LOCKED));
                    continue;
                }
                Some(Event::Machine(host::Event::LinkDown(why))) => self.lost(why),
                None if left.is_zero() => Trouble::Failed(unconfirmed.to_owned()),
                Some(_) | None => continue,
            };
            return Err(if locked && obeyed { Trouble::MayMove(OBEYED.to_owned()) } else { lost });
        }
    }

    /// Stops everything, and waits until the rig confirms that all motors rest.
    async fn all_rest(&mut self) -> Result<(), Trouble> {
        self.command(host::Command::Stop);
        let stopped = |event: &Event| (KosHost::stopped(event) == Some(Stopped::Confirmed)).then_some(());
        self.wait("that all motors rest", self.options.patience, stopped).await
    }

    fn move_state(&self) -> MoveState {
        self.session.host().machine().move_state()
    }
}

/// Outcome of the command with this token, if the event tells it.
fn ended(event: &Event, token: Token) -> Option<Outcome<'static>> {
    match event {
        Event::Machine(host::Event::Ended { token: ended, outcome }) if *ended == token => Some(*outcome),
        _ => None,
    }
}

/// Checks whether a command that ended is done.
fn is_done(outcome: Outcome<'_>, what: &str) -> Result<(), Trouble> {
    match outcome {
        Outcome::Done(_) | Outcome::Sent => Ok(()),
        Outcome::Refused(why) => Err(refused(why)),
        Outcome::Failed(Failure::Stopped) => {
            Err(Trouble::Failed("the rig was stopped by something else: check the rig".to_owned()))
        }
        Outcome::Failed(why) => Err(Trouble::Failed(format!("the rig does not report {what}: {why}: check the rig"))),
        _ => Err(Trouble::Failed(not_reported(what))),
    }
}

fn not_reported(what: &str) -> String {
    format!("the rig does not report {what}: check what it does")
}

/// Time from the command line.
#[expect(clippy::cast_possible_truncation, reason = "the protocol has no other number")]
fn time(seconds: f64, least: f64) -> Result<Seconds, Trouble> {
    if seconds.is_finite() && seconds >= least && seconds <= 86_400.0 {
        return Ok(Seconds(seconds as f32));
    }
    Err(Trouble::Refused(format!("{seconds} s: give a time from {least} to 86400 seconds")))
}

/// Trouble that explains why the client did not send a command.
fn refused(why: Refusal) -> Trouble {
    let hint = match why {
        Refusal::Device(code) => return failed(code, MotorAddress::ALL),
        Refusal::Unsupported { id, action } => return unknown(id, action),
        Refusal::MoveRuns | Refusal::Moves => "stop the rig first (moco drive kos ADDRESS stop)",
        Refusal::NoMotor | Refusal::Outside => "see moco drive kos ADDRESS info",
        Refusal::Number => "give another one",
        _ => "try again",
    };
    Trouble::Refused(format!("{why}: {hint}"))
}

/// Trouble that a message means that the rig does not know.
fn unknown(id: MessageId, action: Option<ActionId>) -> Trouble {
    let number = u32::from(id.0) << 16 | action.map_or(0, |action| action.0.into());
    let name = HostMessage::ALL.iter().find(|kind| kind.number == number).map_or("a message", |kind| kind.name);
    let code = action.map_or(String::new(), |action| format!(" ({action:#04x})", action = action.0));
    Trouble::Refused(format!("the rig does not know {name}{code}: its firmware cannot do that, a newer one may"))
}

/// Trouble that an error of the rig means.
fn failed(code: ErrorCode, motor: MotorAddress) -> Trouble {
    let what = match code {
        ErrorCode::CANNOT_EXECUTE_MOVE => {
            "the rig cannot do that now: motors move, or a motor of the move is not calibrated".to_owned()
        }
        ErrorCode::BAD_MOTOR_ADDRESS => format!("the rig has no motor {motor}: see moco drive kos ADDRESS info"),
        ErrorCode::NO_MOTORS => "the rig has no motors: check its cables".to_owned(),
        ErrorCode::TRAJECTORY => "the rig does not understand the move".to_owned(),
        ErrorCode::RETURN_TO_FIRST_KEYFRAME => {
            "a motor did not reach the start of the move: check what blocks it".to_owned()
        }
        ErrorCode::INVALID_MOVE_TIME => "the rig does not accept the duration of the move".to_owned(),
        ErrorCode::CALIBRATION => format!("motor {motor} has no range: calibrate it again"),
        code if code.resets_axis() => format!(
            "motor {motor} has a fault ({code}) and has lost its range: check what blocks it, then calibrate it again"
        ),
        code if code.names_motor() => format!("motor {motor} left its move ({code}): check what blocks it"),
        code => format!("the rig reports an error: {code}"),
    };
    Trouble::Failed(what)
}

/// Rotations with at most three decimals, for human readers.
struct Shown(Rotations);

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(Rotations(number)) = self;
        let digits = format!("{number:.3}");
        let digits = digits.trim_end_matches('0').trim_end_matches('.');
        f.write_str(if digits == "-0" { "0" } else { digits })
    }
}
