//! Commands for single motors (jog, move, calibrate), and for one photo.

use std::ops::RangeInclusive;
use std::time::Duration;

use hoot_proto::host::Command as MasterCommand;
use hoot_proto::message::{
    self, Bool, CameraExposing, Direction, FirmwareVersion, JoystickMode, MaxStepRate, Microstep, Milliseconds, Motor,
    MotorBacklash, MotorEnable, MotorEndLimit, MotorMaxProgramSpeed, MotorMaxStepSpeed, MotorMicrostep, MotorMove,
    RunStatus, StepCount, Steps,
};
use tokio::time::Instant;

use super::talk::Talk;
use crate::drive::Trouble;
use crate::drive::output::{About, At};

/// Motor with a number from the command line.
pub(super) fn motor(number: u8) -> Result<Motor, Trouble> {
    Motor::new(number).ok_or_else(|| Trouble::Refused(format!("motor {number}: hoot has motors 1 to 3")))
}

/// Position in whole steps.
#[expect(clippy::cast_possible_truncation, reason = "the range is checked")]
fn whole(position: f64) -> Result<i32, Trouble> {
    let steps = position.round();
    if (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&steps) {
        return Ok(steps as i32);
    }
    Err(Trouble::Refused(format!("position {position}: hoot has steps from {} to {}", i32::MIN, i32::MAX)))
}

impl Talk<'_> {
    /// Makes sure that the node can move its motors: it answers, is not in joystick mode, and runs no program.
    pub(super) async fn prepare(&mut self) -> Result<(), Trouble> {
        // In joystick mode, older firmware answers only this query. The first firmware has no joystick mode.
        if self.is_in_joystick_mode().await? {
            self.set(message::SetJoystickMode { joystick_mode: Bool::FALSE }).await?;
        }
        self.ask(FirmwareVersion {}).await?;
        if self.profile().one_is_paused().is_none() {
            // The version does not tell what the run status means. It is told by whether this query is answered.
            self.ask_or_refused(MotorMaxProgramSpeed { motor: Motor::One }).await?;
        }
        let status = self.read(RunStatus {}).await?;
        if status.is_running(self.profile()) == Some(true) {
            return Err(Trouble::Refused(format!("node {} runs a program: stop it first", self.node.0)));
        }
        Ok(())
    }

    /// Whether the node is in joystick mode.
    pub(super) async fn is_in_joystick_mode(&mut self) -> Result<bool, Trouble> {
        let ended = self.ask_or_refused(JoystickMode {}).await?;
        Ok(ended.read(&JoystickMode {}).is_some_and(Bool::get))
    }

    /// Switches a motor on. A node answers OK for a motor that is off, but the motor does not move.
    pub(super) async fn enable(&mut self, motor: Motor) -> Result<(), Trouble> {
        let enable = Bool::TRUE;
        self.set_and_see(message::MotorSetEnable { motor, enable }, MotorEnable { motor }, enable).await
    }

    /// Greatest speed that the setting of a motor names, in steps per second.
    async fn setting_of_speed(&mut self, motor: Motor) -> Result<u16, Trouble> {
        Ok(self.read(MotorMaxStepSpeed { motor }).await?.0)
    }

    /// Greatest speed of a motor, in steps per second.
    ///
    /// Before v0.70 the greatest speed of a motor limits nothing, and has a first value that says nothing about the rig. It
    /// counts if somebody has changed it (decision H-50).
    pub(super) async fn greatest_speed(&mut self, motor: Motor) -> Result<f64, Trouble> {
        const FIRST: u16 = 1000;
        let own = self.setting_of_speed(motor).await?;
        if self.profile().has_max_step_rate() == Some(false) {
            return Ok(own.into());
        }
        let of_all = self.read(MaxStepRate {}).await?.0;
        let is_first = own == FIRST && self.profile().max_speed_limits() == Some(false);
        Ok(if is_first { of_all } else { own.min(of_all) }.into())
    }

    pub(super) async fn dead_man(&mut self, on: bool) -> Result<(), Trouble> {
        self.set(message::SetManualMove { manual_move: on.into() }).await
    }

    /// Makes sure that the positions of a motor are counted in the microsteps of a new node, if a start may have left others.
    ///
    /// A start chooses the microsteps and nobody sets them back if the program is interrupted. The node keeps them when it is
    /// switched off, so nothing tells which others were there before (decision H-81).
    pub(super) async fn count_steps(&mut self, motor: Motor) -> Result<(), Trouble> {
        let microstep = self.profile().first_microstep(motor);
        if self.profile().start_sets_microsteps() == Some(false) {
            return Ok(());
        }
        let found = self.read(MotorMicrostep { motor }).await?;
        if found == microstep {
            return Ok(());
        }
        self.is_at_rest(motor).await?;
        self.print(&format!(
            "motor {motor}: {} microsteps in a step, which a program may have left: set to {}, as at a new node",
            found.0, microstep.0
        ))?;
        self.set_microstep(motor, microstep).await
    }

    pub(super) async fn set_microstep(&mut self, motor: Motor, microstep: Microstep) -> Result<(), Trouble> {
        let set = message::MotorSetMicrostep { motor, microstep };
        self.set_and_see(set, MotorMicrostep { motor }, microstep).await
    }

    /// Refuses a command if a motor moves.
    async fn is_at_rest(&mut self, motor: Motor) -> Result<(), Trouble> {
        if self.is_running(motor).await? {
            return Err(Trouble::Refused(format!("motor {motor} moves: stop it first")));
        }
        Ok(())
    }

    /// Makes a motor ready to move, with the dead-man switch on.
    async fn ready(&mut self, motor: Motor, speed: Option<f64>) -> Result<(), Trouble> {
        self.prepare().await?;
        self.count_steps(motor).await?;
        let most = self.greatest_speed(motor).await?;
        // As with kOS: the greatest speed is not safe if somebody stands beside the camera.
        let speed = match speed {
            Some(speed) => speed,
            None => f64::from(self.setting_of_speed(motor).await?).min(most) / 4.0,
        };
        if !speed.is_finite() || speed <= 0.0 {
            return Err(Trouble::Refused(format!("speed {speed}: give a number of steps/s, more than 0")));
        }
        if speed > most {
            return Err(Trouble::Refused(format!(
                "speed {speed}: motor {motor} of node {} allows at most {most} steps/s",
                self.node.0
            )));
        }
        self.enable(motor).await?;
        #[expect(clippy::cast_possible_truncation, reason = "no more than 65,535")]
        self.set_speed(motor, speed as f32).await?;
        self.dead_man(true).await
    }

    pub(super) async fn jog(&mut self, number: u8, speed: f64, seconds: f64) -> Result<(), Trouble> {
        let motor = motor(number)?;
        let time = Duration::try_from_secs_f64(seconds).ok().filter(|time| *time <= Duration::from_hours(1));
        let time = time.ok_or_else(|| Trouble::Refused(format!("{seconds} seconds: give a number from 0 to 3600")))?;
        self.ready(motor, Some(speed.abs())).await?;
        let from = self.position(motor).await?;
        self.command(MasterCommand::KeepAlive { to: self.node, on: true });
        let direction = Direction((speed > 0.0).into());
        let until = Instant::now() + time;
        // A run needs no joystick mode, which conducts itself in another way with each firmware (decision H-46).
        let answered = self.set_off(message::MotorRun { motor, direction }).await?;
        while let Some(left) = until.checked_duration_since(Instant::now()).filter(|left| !left.is_zero()) {
            if let Some(event) = self.session.next_within(left).await? {
                self.overhear(&event)?;
            }
        }
        self.set(message::MotorStop { motor }).await?;
        self.command(MasterCommand::KeepAlive { to: self.node, on: false });
        let to = self.until_rest(motor).await?;
        self.dead_man(false).await?;
        if to == from {
            let why = if answered { "is it unplugged, or at its end?" } else { "no answer: try again" };
            return Err(Trouble::Failed(format!("motor {motor} did not move from {from}: {why}")));
        }
        self.line(About::position(motor.get(), to), &format!("motor {motor} went from {from} to {to}"))
    }

    pub(super) async fn go(&mut self, number: u8, position: f64, speed: Option<f64>) -> Result<(), Trouble> {
        let (motor, to) = (motor(number)?, whole(position)?);
        self.ready(motor, speed).await?;
        self.go_to(motor, to).await?;
        self.dead_man(false).await?;
        self.line(About::position(motor.get(), to), &format!("motor {motor} is at {to}"))
    }

    /// Moves a motor to a position by the number of steps from where it rests, and checks that it arrives. The move keeps the
    /// speed that was set, which commands that send a motor to a position ignore since 2014-11-03 (decision H-42).
    ///
    /// A number of steps is no place. If the node inverts the direction of the motor, or receives the move twice, the motor goes
    /// away from its target. So the move fails as soon as a position is not on the way, and then the program stops everything.
    pub(super) async fn go_to(&mut self, motor: Motor, to: i32) -> Result<(), Trouble> {
        self.is_at_rest(motor).await?;
        let from = self.position(motor).await?;
        let steps = StepCount(from.abs_diff(to));
        if steps.0 == 0 {
            return Ok(());
        }
        let motion = MotorMove::new(motor, Direction((to > from).into()), steps).ok_or_else(|| {
            let most = StepCount::MAX;
            Trouble::Refused(format!("motor {motor}: from {from} to {to} are {steps} steps, a move has at most {most}"))
        })?;
        // Older firmware takes up the backlash first (decision H-85).
        let backlash = i32::from(self.read(MotorBacklash { motor }).await?.0);
        let way = from.min(to).saturating_sub(backlash)..=from.max(to).saturating_add(backlash);
        let answered = self.set_off(motion).await?;
        let at = self.until_rest_on(motor, way, Some((from, to))).await?;
        has_arrived(motor, at, to, 0, answered)
    }

    /// Waits until a motor rests, and checks that it is at its target, or off by so many steps at most.
    pub(super) async fn arrive(&mut self, motor: Motor, to: i32, off: u32, answered: bool) -> Result<(), Trouble> {
        has_arrived(motor, self.until_rest(motor).await?, to, off, answered)
    }

    /// Waits until a motor rests, and prints its positions meanwhile. Returns the last position, in steps.
    pub(super) async fn until_rest(&mut self, motor: Motor) -> Result<i32, Trouble> {
        self.until_rest_on(motor, i32::MIN..=i32::MAX, None).await
    }

    /// Waits until a motor rests, as long as its positions are on its way. Returns the last position, in steps. `ends` are
    /// the begin and the end of the way, if they are known.
    async fn until_rest_on(
        &mut self,
        motor: Motor,
        way: RangeInclusive<i32>,
        ends: Option<(i32, i32)>,
    ) -> Result<i32, Trouble> {
        loop {
            let is_running = self.is_running(motor).await?;
            let at = self.position(motor).await?;
            if !way.contains(&at) {
                let (from, to) = way.into_inner();
                return Err(Trouble::Failed(format!(
                    "motor {motor} is at {at}, not from {from} to {to}: does the node invert its direction, or did it \
                     receive the move twice?"
                )));
            }
            if !is_running {
                return Ok(at);
            }
            let part = ends.map(|(from, to)| f64::from(at.abs_diff(from)) / f64::from(to.abs_diff(from)));
            let positions = vec![At { motor: motor.get(), position: at.into() }];
            self.progress(part, positions, &format!("motor {motor}: at {at}"))?;
        }
    }

    pub(super) async fn calibrate(&mut self, number: u8, begin: f64, end: f64) -> Result<(), Trouble> {
        let (motor, begin, end) = (motor(number)?, whole(begin)?, whole(end)?);
        let width = end.checked_sub(begin).filter(|width| *width != 0);
        let width = width.ok_or_else(|| {
            Trouble::Refused(format!(
                "from {begin} to {end} is not a range: give two different positions, not too far apart"
            ))
        })?;
        self.ready(motor, None).await?;
        self.go_to(motor, begin).await?;
        self.set(message::MotorSetHomeHere { motor }).await?;
        self.go_to(motor, width).await?;
        let holds = self.profile().holds_limits();
        if holds != Some(false) {
            self.set_and_see(message::MotorSetEndHere { motor }, MotorEndLimit { motor }, Steps(width)).await?;
        }
        self.dead_man(false).await?;
        let end = match holds {
            Some(true) => format!("the end limit is {width} steps from home"),
            Some(false) => format!(
                "the end is {width} steps from home, but nothing stops the motor there: this firmware has no limits"
            ),
            None => format!(
                "the end limit is {width} steps from home, but this firmware may not stop there: try it at a low speed"
            ),
        };
        self.print(&format!("motor {motor}: home is at the old position {begin}, {end}"))
    }

    /// Switches the camera on and sets its exposure.
    pub(super) async fn camera(&mut self, exposure: u32) -> Result<(), Trouble> {
        self.set(message::CameraSetEnable { enable: Bool::TRUE }).await?;
        self.set_exposure(Milliseconds(exposure)).await
    }

    pub(super) async fn set_exposure(&mut self, exposure_time: Milliseconds) -> Result<(), Trouble> {
        let set = message::CameraSetExposureTime { exposure_time };
        self.set_and_see(set, message::CameraExposureTime {}, exposure_time).await
    }

    pub(super) async fn expose(&mut self, seconds: f64) -> Result<(), Trouble> {
        let exposure = milliseconds("an exposure", seconds)?;
        self.prepare().await?;
        if self.profile().exposes_on_command() != Some(true) {
            return Err(Trouble::Refused(format!(
                "node {} answers OK to a photo on command, but its firmware may be too old to take one: use program",
                self.node.0
            )));
        }
        self.camera(exposure).await?;
        let answered = self.set_off(message::CameraExpose {}).await?;
        let mut was_busy = false;
        while self.read(CameraExposing {}).await?.get() {
            was_busy = true;
            self.progress(None, Vec::new(), "the shutter is open")?;
        }
        if !answered && !was_busy {
            let node = self.node.0;
            return Err(Trouble::Failed(format!("node {node} did not answer: check whether the photo was taken")));
        }
        self.print(&format!("one photo of {seconds} s"))
    }
}

/// Checks that a motor rests at its target, or is off by so many steps at most.
fn has_arrived(motor: Motor, at: i32, to: i32, off: u32, answered: bool) -> Result<(), Trouble> {
    if at.abs_diff(to) <= off {
        return Ok(());
    }
    let why = if answered {
        "is it unplugged, at its end, or stuck, or did the node receive nothing for a second?"
    } else {
        "the node did not answer the command to move: try again"
    };
    Err(Trouble::Failed(format!("motor {motor} rests at {at} instead of {to}: {why}")))
}

/// Time in milliseconds, if it is in the range that hoot can carry.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the range is checked")]
pub(super) fn milliseconds(what: &str, seconds: f64) -> Result<u32, Trouble> {
    let millis = (seconds * 1000.0).round();
    if (1.0..=f64::from(message::MAX_ARRIVING)).contains(&millis) {
        return Ok(millis as u32);
    }
    Err(Trouble::Refused(format!("{what} of {seconds} s: give 0.001 to 16777.215 s")))
}
