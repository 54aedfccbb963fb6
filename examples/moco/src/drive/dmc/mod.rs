//! Commands with DMC. Positions are in steps, speeds in steps per second, and the speed of a jog in percent.

mod flow;
mod plan;
#[cfg(test)]
mod tests;
mod why;

use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher, Hasher};
use std::time::Duration;

use dmc_proto::host::{self, StopTarget};
use dmc_proto::message::{
    Acceleration, Bool, CameraFlags, Capabilities, GioCam, HardwareLimitSet, JogSpeed, Milliseconds, Motor, MotorJog,
    MotorMove, MotorSetLimits, MotorSetSpeed, MotorStatusRequest, Motors, RtRunMove, Scaled, Speed, Steps,
};
use motion_core::time::Millis;
use motion_move::Move;
use motion_rigs::dmc_host::{Answer, Command as Order, DmcHost, Event, TOLERANCE, Token};
use tokio::time::{Instant, timeout};

use super::command::Shots;
use super::output::{About, Output};
use super::{Command, Driven, OBEYED, Stopped, Trouble};
use crate::session::{REST, Session};

use flow::Flow;
use plan::Plan;

/// Token of the question whether motors rest. The tokens of commands begin at 1.
const QUESTION: Token = Token(0);
/// Time for acceleration before a move, and for deceleration after it, in milliseconds.
const ROLL: u32 = 500;

impl Driven for DmcHost {
    fn may_move(&self) -> bool {
        self.may_move()
    }

    fn stop_all(&mut self, now: Millis) {
        self.stop_all(now);
    }

    fn stopped(event: &Event) -> Option<Stopped> {
        match event {
            Event::Machine(host::Event::Stopped(StopTarget::All | StopTarget::AllSilent)) => Some(Stopped::Confirmed),
            Event::Machine(host::Event::StopNotConfirmed(_)) => Some(Stopped::NotConfirmed),
            _ => None,
        }
    }

    fn question(&self) -> Option<Order> {
        let is_known = self.machine().device().is_some_and(|hi| hi.motor_count > 0);
        is_known.then(|| Order::Ask(QUESTION, MotorStatusRequest::default().into()))
    }

    fn rest(event: &Event) -> Option<bool> {
        match event {
            Event::Ended(QUESTION, Ok(Answer::Moving(motors))) => Some(*motors == Motors::NONE),
            Event::Ended(QUESTION, _) => Some(false),
            _ => None,
        }
    }
}

/// Options of a host for a line of a speed, in bits per second, and with a time to wait for answers, in milliseconds. The
/// first id is random, so that no answer to an earlier session fits.
#[must_use]
pub fn options(baud: u32, timeout: Option<u32>) -> host::Options {
    // The keys of a hasher are random.
    let random = RandomState::new().build_hasher().finish() % u64::from(u32::MAX);
    let options = host::Options::new().with_line_speed(baud);
    let options = options.with_first_id(u32::try_from(random).unwrap_or(0).saturating_add(1));
    timeout.map_or(options, |timeout| options.with_request_timeout(timeout))
}

/// Does a command, and writes its results to `out`, line by line.
///
/// # Errors
///
/// [`Trouble`], which says in one line why the command was not done, and what to do.
pub async fn drive(
    session: &mut Session<DmcHost>,
    command: &Command,
    out: &mut (dyn Output + Send),
) -> Result<(), Trouble> {
    let mut flow = Flow::new(session, out);
    // Nothing comes before a stop, not even the greeting.
    if *command == Command::Stop {
        flow.stop(StopTarget::All).await?;
        // Nobody knows what an earlier session did: its motors may still slow down, and some rigs leave the shutter open.
        flow.up().await?;
        let rests = matches!(timeout(REST, flow.rest()).await, Ok(Ok(())));
        if rests {
            flow.print(format_args!("stopped: the rig confirmed it"))?;
        }
        flow.close_shutter().await?;
        return if rests { Ok(()) } else { Err(Trouble::MayMove(OBEYED.to_owned())) };
    }
    flow.up().await?;
    match command {
        Command::Info => info(&mut flow).await,
        Command::Jog { motor, speed, seconds } => jog(&mut flow, *motor, *speed, *seconds).await,
        Command::Move { motor, position, speed } => {
            let motor = flow.motor(*motor)?;
            set_speed(&mut flow, motor, *speed).await?;
            go(&mut flow, motor, *position).await
        }
        Command::Calibrate { motor, begin, end } => calibrate(&mut flow, *motor, *begin, *end).await,
        Command::Upload { file } => {
            let plan = read(&flow, file)?;
            flow.upload(&plan).await
        }
        Command::Run { file, reverse } => run(&mut flow, file, *reverse).await,
        Command::Program { file, shots } => program(&mut flow, file, shots).await,
        Command::Expose { seconds } => expose(&mut flow, *seconds).await,
        Command::Stop => Ok(()),
    }
}

fn read(flow: &Flow<'_>, file: &std::path::Path) -> Result<Plan, Trouble> {
    let read = Move::read(file).map_err(|error| Trouble::Refused(error.to_string()))?;
    let plan = Plan::new(&file.display().to_string(), &read)?;
    flow.fits(&plan)?;
    Ok(plan)
}

async fn info(flow: &mut Flow<'_>) -> Result<(), Trouble> {
    let hi = flow.device()?;
    flow.print(format_args!("{}, firmware {}.{}.{}", hi.name, hi.fw_major, hi.fw_minor, hi.fw_rev))?;
    flow.print(format_args!(
        "{} motors, {} lights, {} outputs, {} inputs",
        hi.motor_count, hi.dmx_count, hi.gio_out_count, hi.gio_in_count
    ))?;
    flow.print(format_args!("room for {} frames; capabilities: {}", hi.upload_frame_count, hi.capabilities))?;
    // A rig without motors does not know questions about them.
    if hi.motor_count == 0 {
        return Ok(());
    }
    let moving = flow.status().await?;
    for (number, steps) in (1..).zip(flow.positions().await?) {
        let how = if moving.contains(Motor(number)) { "moves" } else { "rests" };
        flow.line(About::position(number, steps), format_args!("motor {number} {how} at {steps} steps"))?;
    }
    Ok(())
}

async fn jog(flow: &mut Flow<'_>, motor: u8, percent: f64, seconds: f64) -> Result<(), Trouble> {
    let motor = flow.motor(motor)?;
    let time = duration(seconds)?;
    let hundredths = (percent.abs() * 100.0).round();
    if !(1.0..=10_000.0).contains(&hundredths) {
        return Err(Trouble::Refused(format!(
            "the speed is {percent} %: give one from 0.01 to 100, or from -100 to -0.01"
        )));
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 1 to 10,000")]
    let speed = JogSpeed(Scaled(hundredths as u16));
    let destination = Steps(if percent < 0.0 { i32::MIN } else { i32::MAX });
    let jog = MotorJog { motor, speed, destination, tail: &[] };
    let before = flow.position(motor).await?;
    flow.hold(jog, time).await?;
    flow.stop(StopTarget::Motor(motor)).await?;
    flow.rest().await?;
    let steps = flow.position(motor).await?;
    if steps == before && !time.is_zero() {
        return Err(Trouble::Failed(format!(
            "motor {motor} has not moved: it rests at {steps} steps: is it at a limit, too slow, or without power?"
        )));
    }
    flow.line(About::position(motor.0, steps), format_args!("motor {motor} rests at {steps} steps"))?;
    Ok(())
}

async fn set_speed(flow: &mut Flow<'_>, motor: Motor, speed: Option<f64>) -> Result<(), Trouble> {
    let Some(speed) = speed else { return Ok(()) };
    if !(1.0..=1e9).contains(&speed) {
        return Err(Trouble::Refused(format!("the speed is {speed} steps/s: give one from 1 to 1000000000")));
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 1 to 1e9")]
    let velocity = speed.round() as u32;
    // The motor takes half a second to full speed. DMC has no message that asks for the previous setting.
    let (max_velocity, max_accel) = (Speed(velocity), Acceleration(velocity * 2));
    let message = MotorSetSpeed { motor, max_velocity, max_accel, tail: &[] };
    flow.ask("the speed", message).await.map(|_| ())
}

/// Moves a motor to a position, and waits until the motor is there.
async fn go(flow: &mut Flow<'_>, motor: Motor, position: f64) -> Result<(), Trouble> {
    let position = steps(position)?;
    let before = flow.position(motor).await?;
    let message = MotorMove { motor, position, tail: &[] };
    flow.ask("the move", message).await?;
    flow.rest().await?;
    let here = flow.position(motor).await?;
    // Some devices cut off the fraction of a position.
    if here.abs_diff(position.0) > TOLERANCE {
        return Err(Trouble::Failed(if here == before {
            format!("motor {motor} has not moved: it rests at {here} steps: is it at a limit, or without power?")
        } else {
            format!("motor {motor} rests at {here} steps, not at {position}: something stopped it: check the rig")
        }));
    }
    flow.line(About::position(motor.0, here), format_args!("motor {motor} rests at {here} steps"))?;
    Ok(())
}

/// Sets the range of a motor. The limits are set first, so that the way to both ends is within them.
async fn calibrate(flow: &mut Flow<'_>, motor: u8, begin: f64, end: f64) -> Result<(), Trouble> {
    let motor = flow.motor(motor)?;
    let (one, other) = (steps(begin)?, steps(end)?);
    if one == other {
        return Err(Trouble::Refused("the range is empty: give two different positions".to_owned()));
    }
    let (lower, upper) = (one.min(other), one.max(other));
    // The same message sets which limit switches belong to the motor: those with its own number, if they exist.
    let own = if motor.0 <= flow.device()?.hw_limit_count { motor.0 } else { 0 };
    let hw_set = HardwareLimitSet(own);
    let (lower_enable, upper_enable) = (Bool::TRUE, Bool::TRUE);
    let limits = MotorSetLimits { motor, lower_enable, lower, upper_enable, upper, hw_set, tail: &[] };
    flow.ask("the limits", limits).await?;
    go(flow, motor, begin).await?;
    go(flow, motor, end).await?;
    // The session ends, and DMC has no question for limits, so that later commands depend on the rig alone.
    flow.print(format_args!(
        "limits of motor {motor}: {lower} to {upper} steps, until the rig is switched off; some rigs check only runs against \
         them, and pass them in moves and jogs"
    ))?;
    Ok(())
}

async fn run(flow: &mut Flow<'_>, file: &std::path::Path, reverse: bool) -> Result<(), Trouble> {
    let plan = read(flow, file)?;
    flow.upload(&plan).await?;
    let (start_frame, end_frame) = if reverse { (plan.last, plan.first) } else { (plan.first, plan.last) };
    let run = RtRunMove {
        fps_x1000: plan.rate,
        start_frame,
        end_frame,
        pre_roll_ms: Milliseconds(ROLL),
        post_roll_ms: Milliseconds(ROLL),
        ..RtRunMove::default()
    };
    let run = run.for_device(flow.device()?.capabilities);
    let token = flow.begin(run);
    flow.play("the run", token, Some((start_frame, end_frame))).await?;
    flow.print(format_args!("the move is done"))?;
    Ok(())
}

async fn program(flow: &mut Flow<'_>, file: &std::path::Path, shots: &Shots) -> Result<(), Trouble> {
    let capabilities = flow.device()?.capabilities;
    if !capabilities.intersects(Capabilities::SHOOT_FRAME | Capabilities::SHOOT_FRAME2) {
        return Err(Trouble::Refused("this rig cannot shoot frames: play the move with `run`".to_owned()));
    }
    if shots.shots == 0 {
        return Err(Trouble::Refused("the number of shots is 0: give one or more with --shots".to_owned()));
    }
    let (interval, exposure) = (duration(shots.interval)?, duration(shots.exposure)?);
    let exposure = u32::try_from(exposure.as_millis()).unwrap_or(u32::MAX);
    let plan = read(flow, file)?;
    flow.upload(&plan).await?;
    let mut due = Instant::now();
    for number in 0..shots.shots {
        flow.pass(due.saturating_duration_since(Instant::now())).await?;
        due = Instant::now() + interval;
        let mut shot = plan.shot(number, shots.shots, exposure, shots.continuous);
        shot.is_second_form = !capabilities.contains(Capabilities::SHOOT_FRAME);
        let frame = shot.frame;
        let token = flow.shoot(shot);
        flow.play("the shot", token, None).await?;
        let part = f64::from(number + 1) / f64::from(shots.shots);
        let about = About::Progress { part: Some(part), positions: Vec::new() };
        flow.line(about, format_args!("shot {} of {}, at frame {frame}", number + 1, shots.shots))?;
    }
    Ok(())
}

/// Takes a photo without a move, with the output for the camera. `program` takes photos along a move.
async fn expose(flow: &mut Flow<'_>, seconds: f64) -> Result<(), Trouble> {
    let time = duration(seconds)?;
    let shutter = |flags| GioCam { flags, tail: &[] };
    flow.ask("the photo", shutter(CameraFlags::SHUTTER)).await?;
    flow.pass(time).await?;
    flow.ask("the end of the photo", shutter(CameraFlags::empty())).await?;
    flow.print(format_args!("a photo of {seconds} s"))?;
    Ok(())
}

/// Duration from seconds on the command line.
fn duration(seconds: f64) -> Result<Duration, Trouble> {
    let wrong = || Trouble::Refused(format!("the time is {seconds} s: give seconds from 0 to 86400"));
    if (0.0..=86_400.0).contains(&seconds) { Ok(Duration::from_secs_f64(seconds)) } else { Err(wrong()) }
}

/// Position from the command line.
#[expect(clippy::cast_possible_truncation, reason = "the range is checked")]
fn steps(position: f64) -> Result<Steps, Trouble> {
    let nearest = position.round();
    if (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&nearest) {
        return Ok(Steps(nearest as i32));
    }
    Err(Trouble::Refused(format!("the position is {position}: give whole steps from {} to {}", i32::MIN, i32::MAX)))
}
