//! Commands for single motors: jog, move, calibrate.

use std::time::Duration;

use kos_proto::host::{self, Get, Go, Outcome, Refusal};
use kos_proto::message::{ActionId, Motor, MotorAddress, Rotations, RotationsPerSecond, RotationsPerSecondSquared};
use motion_rigs::kos_host::Event;
use tokio::time::Instant;

use super::{Drive, SPARE, Shown, ended, is_done};
use crate::drive::Trouble;
use crate::drive::output::{About, At};

/// Time between two signs of life in a jog. Our client stops the jog if it gets none for a second.
const ALIVE: Duration = Duration::from_millis(250);
/// Greatest distance of a motor at rest from its target, in rotations.
const NEAR: f64 = 0.01;
/// Greatest distance at which a motor that runs is stopped at its place, in rotations.
const CLOSE: f64 = 1e-3;
/// Time between two looks at a motor that runs to its place.
const TENTH: Duration = Duration::from_millis(100);
/// Time between two questions where a motor is.
const SECOND: Duration = Duration::from_secs(1);
/// Longest time to wait for a move, even if it is slow.
const LONG: Duration = Duration::from_hours(24);

/// Speed and acceleration of a motor.
#[derive(Clone, Copy)]
struct Pace {
    speed: RotationsPerSecond,
    acceleration: RotationsPerSecondSquared,
}

/// Pace with the given speed, or a quarter of the greatest speed, and with half of the greatest acceleration.
#[expect(clippy::cast_possible_truncation, reason = "the protocol has 32-bit numbers")]
fn pace(motor: &Motor, speed: Option<f64>) -> Result<Pace, Trouble> {
    let most = motor.max_max_setup_speed.0;
    let speed = speed.map_or(most / 4.0, |speed| speed as f32);
    if !(speed > 0.0 && speed <= most) {
        let number = motor.motor_address;
        let line = format!("motor {number}: the speed is {speed} rev/s: give more than 0, and at most {most}");
        return Err(Trouble::Refused(line));
    }
    let acceleration = RotationsPerSecondSquared(motor.max_max_acceleration.0 / 2.0);
    Ok(Pace { speed: RotationsPerSecond(speed), acceleration })
}

impl Drive<'_> {
    pub(super) async fn jog(&mut self, motor: u8, speed: f64, seconds: f64) -> Result<(), Trouble> {
        let known = self.motor(motor)?;
        let Pace { speed: RotationsPerSecond(fast), acceleration } = pace(&known, Some(speed.abs()))?;
        super::time(seconds, 0.01)?;
        let speed = RotationsPerSecond(if speed < 0.0 { -fast } else { fast });
        let motor = MotorAddress(motor);
        self.command(host::Command::Jog { motor, speed, acceleration });
        let until = Instant::now() + Duration::from_secs_f64(seconds);
        while let Some(left) = until.checked_duration_since(Instant::now()).filter(|left| !left.is_zero()) {
            self.command(host::Command::Alive);
            self.pass(left.min(ALIVE)).await?;
            let left = left.as_secs_f64();
            let part = Some(1.0 - left / seconds);
            self.progress(part, Vec::new(), format_args!("motor {motor} runs for {left:.1} s more"))?;
        }
        let at = self.rest(motor).await?;
        self.line(About::position(motor.number(), at.0), format_args!("motor {motor} rests at {}", Shown(at)))
    }

    pub(super) async fn go(&mut self, motor: u8, position: f64, speed: Option<f64>) -> Result<(), Trouble> {
        let known = self.motor(motor)?;
        let pace = pace(&known, speed)?;
        let (Some(here), Some(range)) = (known.relative_position(), known.range()) else {
            let line = format!(
                "motor {motor} is not calibrated: calibrate it first (moco drive kos ADDRESS calibrate {motor} BEGIN END)"
            );
            return Err(Trouble::Refused(line));
        };
        let (low, high) = (range.0.min(0.0), range.0.max(0.0));
        if !(f64::from(low)..=f64::from(high)).contains(&position) {
            let line = format!(
                "motor {motor}: {position} is outside its range: give a position from {low} to {high} rotations"
            );
            return Err(Trouble::Refused(line));
        }
        let way = position - f64::from(here.0);
        let at = self.travel(MotorAddress(motor), Some(position), way, pace).await?;
        // The rig reports positions in its own count. The given position is counted from the beginning of the range.
        let begin = f64::from(known.position.0) - f64::from(here.0);
        let rests = f64::from(at.0) - begin;
        if (rests - position).abs() > NEAR {
            let line = format!("motor {motor} rests at {rests:.3}, not at {position}: check what blocks it");
            return Err(Trouble::Failed(line));
        }
        let at = Rotations(at.0 - known.position.0 + here.0);
        self.line(About::position(motor, at.0), format_args!("motor {motor} rests at {}", Shown(at)))
    }

    pub(super) async fn calibrate(&mut self, motor: u8, begin: f64, end: f64) -> Result<(), Trouble> {
        let known = self.motor(motor)?;
        let pace = pace(&known, None)?;
        let far = |position: f64| !position.is_finite() || position.abs() > 25_000.0;
        if far(begin) || far(end) || (end - begin).abs() < NEAR {
            let line = "give two different positions, in rotations as info shows them";
            return Err(Trouble::Refused(line.to_owned()));
        }
        let here = f64::from(known.relative_position().unwrap_or(known.position).0);
        let motor = MotorAddress(motor);
        // The old range would limit the motion.
        self.command(host::Command::ResetAxis(motor));
        self.wait("the ranges of its motors", self.options.patience, |event| {
            (*event == Event::Machine(host::Event::Motors)).then_some(())
        })
        .await?;
        self.bump(motor, begin - here, pace).await?;
        self.command(host::Command::MarkBegin(motor));
        self.print(format_args!("motor {motor} is where its range begins"))?;
        self.bump(motor, end - begin, pace).await?;
        let token = self.command(host::Command::MarkEnd(motor));
        self.done(token, "that the range is set", self.options.patience).await?;
        let range = self.motor(motor.0)?.range().unwrap_or_default();
        if (f64::from(range.0) - (end - begin)).abs() > NEAR {
            let line = format!("motor {motor} has a range of {}: something blocked it", Shown(range));
            return Err(Trouble::Failed(line));
        }
        self.print(format_args!("motor {motor} is calibrated: from 0 to {} rotations", Shown(range)))
    }

    async fn bump(&mut self, motor: MotorAddress, by: f64, pace: Pace) -> Result<(), Trouble> {
        if by.abs() < 1e-6 {
            return Ok(());
        }
        let from = self.motor(motor.0)?.position;
        let at = self.travel(motor, None, by, pace).await?;
        let gone = f64::from(at.0) - f64::from(from.0);
        if (gone - by).abs() > NEAR {
            let line = format!("motor {motor} moved {gone:.3} rotations, not {by:.3}: check what blocks it");
            return Err(Trouble::Failed(line));
        }
        Ok(())
    }

    /// Prints where a motor is that has done a part of its way.
    fn moves(&mut self, motor: MotorAddress, at: Rotations, part: f64) -> Result<(), Trouble> {
        let positions = vec![At { motor: motor.number(), position: at.0.into() }];
        self.progress(Some(part), positions, format_args!("motor {motor} moves, at {}", Shown(at)))
    }

    /// Moves a motor without a range by a distance, as the specification describes the marking of a range: the motor runs, and
    /// is stopped at its place. It runs the slower, the nearer it is.
    #[expect(clippy::cast_possible_truncation, reason = "the protocol has 32-bit numbers")]
    async fn creep(&mut self, motor: MotorAddress, by: f64, pace: Pace) -> Result<Rotations, Trouble> {
        let Pace { speed, acceleration } = pace;
        let to = f64::from(self.motor(motor.0)?.position.0) + by;
        let takes = 2.0 * by.abs() / f64::from(speed.0);
        let until = Instant::now() + SPARE + SPARE + Duration::try_from_secs_f64(takes).unwrap_or(LONG).min(LONG);
        loop {
            self.ask(Get::MotorInfo).await?;
            let at = self.motor(motor.0)?.position;
            let left = to - f64::from(at.0);
            if left.abs() < CLOSE || Instant::now() > until {
                break;
            }
            let fast = f64::from(speed.0);
            let part = 1.0 - left / by;
            let speed = RotationsPerSecond(left.clamp(-fast, fast) as f32);
            self.command(host::Command::Jog { motor, speed, acceleration });
            self.moves(motor, at, part)?;
            self.pass(TENTH).await?;
        }
        self.rest(motor).await
    }

    /// Moves a motor to a position, or by a distance, and waits until it rests. Prints its position meanwhile. If the rig does
    /// not know bumps, the motor creeps.
    #[expect(clippy::cast_possible_truncation, reason = "the protocol has 32-bit numbers")]
    async fn travel(
        &mut self,
        motor: MotorAddress,
        to: Option<f64>,
        way: f64,
        pace: Pace,
    ) -> Result<Rotations, Trouble> {
        let Pace { speed, acceleration } = pace;
        let position = Rotations(to.unwrap_or(way) as f32);
        let go = Go { motor, position, speed, acceleration };
        let token = self.command(if to.is_some() { host::Command::MoveTo(go) } else { host::Command::Bump(go) });
        let takes = way.abs() / f64::from(speed.0) + f64::from(speed.0) / f64::from(acceleration.0);
        let takes = Duration::try_from_secs_f64(2.0 * takes).unwrap_or(LONG).min(LONG);
        let until = Instant::now() + SPARE + takes;
        let from = self.motor(motor.0)?.position;
        let what = "that the motor rests";
        loop {
            let left = until.saturating_duration_since(Instant::now());
            match self.wait(what, left.min(SECOND), |event| ended(event, token)).await {
                Ok(Outcome::Refused(Refusal::Unsupported {
                    action: Some(ActionId::BUMP_POSITION_SPEED_ACCELERATION),
                    ..
                })) => return self.creep(motor, way, pace).await,
                Ok(outcome) => {
                    is_done(outcome, what)?;
                    return Ok(self.motor(motor.0)?.position);
                }
                Err(Trouble::Failed(_)) if self.error.is_none() && left > SECOND => {}
                Err(trouble) => return Err(trouble),
            }
            // The answer comes with the next events, and the position is known then.
            self.command(host::Command::Get(Get::MotorInfo));
            let at = self.motor(motor.0)?.position;
            self.moves(motor, at, f64::from(at.0 - from.0) / way)?;
        }
    }
}
