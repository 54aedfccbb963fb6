//! Planned moves: stored, played in real time, and with photos.

use std::path::Path;

use hoot_proto::HostMessage;
use hoot_proto::message::{
    self, Bool, CameraExposureTime, Microstep, Milliseconds, Motor, ProgramMode, ProgramModeQuery, RunState, RunStatus,
    RunTime, ShortShots, ShortSpan, Shots, Span, Steps,
};
use motion_move::Move;
use motion_move::hoot::Planned;
use tokio::time::Instant;

use super::motion::milliseconds;
use super::plan::{Count, plans};
use super::talk::Talk;
use crate::drive::Trouble;
use crate::drive::command;
use crate::drive::output::At;

/// Factor of the longest time: a program that is not done after three times its time and three seconds has failed, because
/// some firmware never ends it.
const LONGEST: f64 = 3.0;

impl Talk<'_> {
    pub(super) async fn upload(&mut self, file: &Path) -> Result<(), Trouble> {
        let planned = self.read_video(file, false).await?;
        self.store(&planned, ProgramMode::VIDEO).await?;
        self.dead_man(false).await?;
        self.print("the move is stored and can be started: its motors are at the start")
    }

    pub(super) async fn run(&mut self, file: &Path, reverse: bool) -> Result<(), Trouble> {
        let planned = self.read_video(file, reverse).await?;
        self.store(&planned, ProgramMode::VIDEO).await?;
        // With the camera off, the program ends when the move ends.
        self.set(message::CameraSetEnable { enable: Bool::FALSE }).await?;
        // On later firmware a start and an end open the shutter also with the camera off, except for an exposure of 0
        // (decision H-83).
        let profile = self.profile();
        let shoots = profile.shoots_at_start() != Some(false) || profile.shoots_at_end() != Some(false);
        let exposure = if shoots { Some(self.read(CameraExposureTime {}).await?) } else { None };
        if shoots {
            self.set_exposure(Milliseconds(0)).await?;
        }
        let millis = planned.iter().map(|it| it.lead_in.saturating_add(it.plan.travel.0)).max().unwrap_or(0);
        self.play(&planned, f64::from(millis) / 1000.0, None).await?;
        if let Some(exposure) = exposure {
            self.set_exposure(exposure).await?;
        }
        self.print("the move is done, and all motors rest at its end")
    }

    pub(super) async fn program(&mut self, file: &Path, shots: command::Shots) -> Result<(), Trouble> {
        let command::Shots { shots, interval, exposure, continuous } = shots;
        if !(2..=u32::from(u16::MAX)).contains(&shots) {
            return Err(Trouble::Refused(format!("{shots} photos: give 2 to 65535")));
        }
        let (pause, open) = (milliseconds("an interval", interval)?, milliseconds("an exposure", exposure)?);
        if open >= pause {
            return Err(Trouble::Refused(format!(
                "an exposure of {exposure} s does not fit into an interval of {interval} s: give a longer one"
            )));
        }
        let (mode, count) = if continuous {
            (ProgramMode::CONTINUOUS, Count::Lapse { shots, interval: pause })
        } else {
            (ProgramMode::SMS, Count::Shots(shots))
        };
        let mut planned = self.read_move(file, count, false)?;
        self.prepare().await?;
        if continuous {
            self.last_until_the_last_photo(&mut planned, shots, pause)?;
            self.lead_in_by_time(&mut planned, pause);
        } else {
            self.fits_between_photos(&planned, pause - open).await?;
        }
        self.store(&planned, mode).await?;
        self.camera(open).await?;
        self.set(message::CameraSetInterval { interval: Milliseconds(pause) }).await?;
        self.set(message::CameraSetFocusTime::default()).await?;
        self.set(message::CameraSetExposureDelay::default()).await?;
        self.set(message::CameraSetMirrorUp::default()).await?;
        // Later firmware goes on until one photo more is taken. If that is not known, the program is stopped after the last
        // photo (decision H-84).
        let takes_one_more = self.profile().takes_one_more();
        let asked = if takes_one_more == Some(true) { shots - 1 } else { shots };
        let set = message::CameraSetMaxShots { max_shots: ShortShots(asked.try_into().unwrap_or(u16::MAX)) };
        self.set_and_see(set, message::CameraMaxShots {}, Shots(asked)).await?;
        self.play(
            &planned,
            f64::from(shots - 1) * interval + exposure,
            takes_one_more.is_none().then_some(pause - open),
        )
        .await?;
        self.print(&format!("{shots} photos are taken, and all motors rest"))
    }

    /// Reads a move file, and makes planned moves without stops from it.
    ///
    /// Some firmware never begins a video with a lead-in. The move begins at once there (decision H-88).
    async fn read_video(&mut self, file: &Path, reverse: bool) -> Result<Vec<Planned>, Trouble> {
        let mut planned = self.read_move(file, Count::Video, reverse)?;
        self.prepare().await?;
        if self.profile().leads_in_videos_by_photos().is_none() {
            // Firmware that refuses this query is older.
            self.ask_or_refused(message::PingPong {}).await?;
        }
        if self.profile().leads_in_videos_by_photos() == Some(false) {
            return Ok(planned);
        }
        let first = planned.iter().map(|it| it.lead_in).min().unwrap_or(0);
        for it in &mut planned {
            it.lead_in -= first;
            if it.lead_in > 0 {
                return Err(Trouble::Refused(format!(
                    "motor {} begins {} ms after another one: this firmware cannot do that, let all axes begin together",
                    it.motor, it.lead_in
                )));
            }
        }
        if first > 0 {
            self.print(&format!("the move begins {first} ms earlier: this firmware has no lead-in in a video"))?;
        }
        Ok(planned)
    }

    /// Makes the motors of a time lapse rest after the photo before the last one, because later firmware ends it with them
    /// (decision H-86). A move that would have to last longer by more than the time between two photos is refused.
    fn last_until_the_last_photo(&self, planned: &mut [Planned], shots: u32, pause: u32) -> Result<(), Trouble> {
        if self.profile().ends_with_motors() == Some(false) {
            return Ok(());
        }
        let end = |it: &Planned| u64::from(it.lead_in) * u64::from(pause) + u64::from(it.plan.travel.0);
        let least = u64::from(shots - 2) * u64::from(pause) + u64::from(pause / 4);
        let Some(longest) = planned.iter_mut().max_by_key(|it| end(it)) else { return Ok(()) };
        let more = u32::try_from(least.saturating_sub(end(longest))).unwrap_or(u32::MAX);
        if more > pause {
            return Err(Trouble::Refused(format!(
                "all motors rest {:.1} s before the last photo, and this firmware ends a time lapse then: let the move last \
                 until the end",
                f64::from(more) / 1000.0 + f64::from(pause) * 0.75 / 1000.0
            )));
        }
        longest.stretch(more);
        Ok(())
    }

    /// Gives the motors of a time lapse that begin later than others their lead-in in milliseconds, if firmware counts so
    /// (decision H-92).
    fn lead_in_by_time(&self, planned: &mut [Planned], pause: u32) {
        let least = planned.iter().map(|it| it.lead_in).min().unwrap_or(0);
        let by_time = self.profile().leads_in_lapses_by_time() != Some(false);
        for it in planned.iter_mut().filter(|it| by_time && it.lead_in > least) {
            it.lead_in = it.lead_in.saturating_mul(pause);
        }
    }

    /// Refuses photos that come so fast that the motors do not rest in time, because they come late then (decision H-87).
    async fn fits_between_photos(&mut self, planned: &[Planned], left: u32) -> Result<(), Trouble> {
        // Time to gain and to lose speed, and for the node to notice that the motor rests, in seconds.
        const RAMPS: f64 = 0.15;
        for it in planned {
            let motor = it.motor;
            // A start chooses sixteenths for slow moves, and the speed counts in them.
            self.count_steps(motor).await?;
            let found = self.read(message::MotorMicrostep { motor }).await?;
            let is_finer = self.profile().start_sets_microsteps() != Some(false);
            let finest = if is_finer { Microstep::SIXTEENTH } else { found };
            let backlash = self.read(message::MotorBacklash { motor }).await?.0;
            let counts = f64::from(it.longest().saturating_add(backlash.into()));
            let counts = counts * f64::from(finest.0) / f64::from(found.0.max(1));
            let takes = counts / self.greatest_speed(motor).await?.max(1.0) + RAMPS;
            if takes * 1000.0 > f64::from(left) {
                return Err(Trouble::Refused(format!(
                    "motor {motor} moves for up to {takes:.1} s between two photos, and {:.1} s are left: give a longer \
                     interval",
                    f64::from(left) / 1000.0
                )));
            }
        }
        Ok(())
    }

    /// Reads a move file, and makes planned moves from it.
    fn read_move(&mut self, file: &Path, count: Count, reverse: bool) -> Result<Vec<Planned>, Trouble> {
        let part = self.home_speed;
        if !(part > 0.0 && part <= 1.0) {
            let line = format!("the home speed is {part}: give more than 0, and at most 1");
            return Err(Trouble::Refused(line));
        }
        let file = Move::read(file).map_err(|error| Trouble::Refused(error.to_string()))?;
        let planned = plans(&file, self.node, count, reverse)?;
        for it in &planned {
            let (start, stop) = (it.plan.start, it.plan.stop);
            self.print(&format!("motor {}: from {start} to {stop}, deviation at most {:.0}", it.motor, it.deviation))?;
        }
        Ok(planned)
    }

    /// Stores planned moves, checks that the node has them, and sends the motors to their start. All other motors lose
    /// their planned moves.
    async fn store(&mut self, planned: &[Planned], program_mode: ProgramMode) -> Result<(), Trouble> {
        // A paused program would continue instead of starting again.
        self.set(message::Stop {}).await?;
        for motor in Motor::ALL {
            self.count_steps(motor).await?;
        }
        for it in planned.iter().filter(|_| program_mode != ProgramMode::SMS) {
            let (most, asked) = (self.greatest_speed(it.motor).await?, it.peak() * 1000.0);
            if asked > most {
                return Err(Trouble::Refused(format!(
                    "motor {}: the move needs {asked:.0} steps/s, the node allows {most}: make it slower, or raise the \
                     greatest speed of the motor",
                    it.motor
                )));
            }
        }
        self.dead_man(true).await?;
        self.set(message::SetProgramMode { program_mode }).await?;
        let found = self.read(ProgramModeQuery {}).await?;
        if found != program_mode {
            let node = self.node.0;
            return Err(Trouble::Refused(format!(
                "node {node} has no mode {program_mode}, it stays in {found}: its firmware is too old for this command"
            )));
        }
        self.set(message::SetTimingMaster { timing_master: Bool::TRUE }).await?;
        self.set(message::SetStartDelay::default()).await?;
        self.set(message::SetMaxRunTime::default()).await?;
        self.set_or_refused(message::SetPingPong { ping_pong: Bool::FALSE }).await?;
        // The least lead-in of all enabled motors counts in a time lapse (decision H-92).
        let least = planned.iter().map(|it| it.lead_in).min().unwrap_or(0);
        for motor in Motor::ALL {
            match planned.iter().find(|it| it.motor == motor) {
                Some(it) => self.store_one(it).await?,
                None => self.stay(motor, if program_mode == ProgramMode::CONTINUOUS { least } else { 0 }).await?,
            }
        }
        for it in planned {
            let motor = it.motor;
            self.enable(motor).await?;
            #[expect(clippy::cast_possible_truncation, reason = "at most 65,535")]
            let most = self.greatest_speed(motor).await? as f32;
            self.set_speed(motor, most * self.home_speed).await?;
            self.go_to(motor, it.plan.start.0).await?;
            // Between photos the motor goes at this speed too.
            self.set_speed(motor, most).await?;
            // In joystick mode a speed sets a motor in motion, so the master wants to know that it rests.
            self.until_rest(motor).await?;
        }
        Ok(())
    }

    /// Stores a planned move that leaves a motor where it is. Without a video or time lapse of its own, firmware sends each
    /// enabled motor to the stop of its plan, which is 0 at first, at full speed (decision H-82).
    async fn stay(&mut self, motor: Motor, lead_in: u32) -> Result<(), Trouble> {
        let position = Steps(self.until_rest(motor).await?);
        self.set_ends(motor, position, position).await?;
        self.set_travel(motor, Span(0)).await?;
        self.set_lead_in(motor, lead_in).await
    }

    async fn set_ends(&mut self, motor: Motor, start: Steps, stop: Steps) -> Result<(), Trouble> {
        let set = message::MotorSetProgramStart { motor, position: start };
        self.set_and_see(set, message::MotorProgramStart { motor }, start).await?;
        let set = message::MotorSetProgramStop { motor, position: stop };
        self.set_and_see(set, message::MotorProgramStop { motor }, stop).await
    }

    async fn store_one(&mut self, Planned { motor, plan, lead_in, .. }: &Planned) -> Result<(), Trouble> {
        let (motor, plan) = (*motor, *plan);
        self.set_ends(motor, plan.start, plan.stop).await?;
        self.set_travel(motor, plan.travel).await?;
        let set = message::MotorSetProgramAcceleration { motor, acceleration: plan.acceleration };
        self.set_and_see(set, message::MotorProgramAcceleration { motor }, plan.acceleration).await?;
        let set = message::MotorSetProgramDeceleration { motor, deceleration: plan.deceleration };
        self.set_and_see(set, message::MotorProgramDeceleration { motor }, plan.deceleration).await?;
        let set = message::MotorSetEasing { motor, easing: plan.easing };
        self.set_and_see(set, message::MotorEasing { motor }, message::EasingFound::from(plan.easing)).await?;
        self.set_lead_in(motor, *lead_in).await
    }

    async fn set_travel(&mut self, motor: Motor, travel: Span) -> Result<(), Trouble> {
        self.set_and_see(message::MotorSetTravel { motor, travel }, message::MotorTravel { motor }, travel).await
    }

    /// Sets the lead-in of a motor. It has 16 bits in older firmware.
    async fn set_lead_in(&mut self, motor: Motor, lead_in: u32) -> Result<(), Trouble> {
        let set = if self.profile().reads_long_lead_in() == Some(true) {
            HostMessage::from(message::MotorSetLeadInLong { motor, lead_in: Span(lead_in) })
        } else {
            let short = u16::try_from(lead_in).map(ShortSpan).map_err(|_| {
                Trouble::Refused(format!(
                    "the lead-in of motor {motor} is {lead_in}, but this firmware allows at most 65535: \
                     let the axis start earlier"
                ))
            })?;
            message::MotorSetLeadIn { motor, lead_in: short }.into()
        };
        self.set_and_see(set, message::MotorLeadIn { motor }, Span(lead_in)).await
    }

    /// Starts the stored program, prints its progress, and checks where the motors are at its end. If it may take one
    /// photo more than asked, `rest` is the time from the end of the last exposure to that photo in milliseconds, and the
    /// program is stopped after half of it.
    async fn play(&mut self, planned: &[Planned], seconds: f64, rest: Option<u32>) -> Result<(), Trouble> {
        let before = self.microsteps().await?;
        let began = Instant::now();
        let answered = self.set_off(message::Start {}).await?;
        let now = self.microsteps().await?;
        let profile = self.profile();
        let (mut has_run, mut last_photo) = (false, 0);
        loop {
            let (state, gone) = (self.read(RunStatus {}).await?, self.read(RunTime {}).await?.0);
            if state.is_running(profile) == Some(false) {
                // Later firmware tells a pause by its number. In older firmware a program that has ended or was stopped
                // loses its run time, and a paused one keeps it.
                let is_paused = match profile.one_is_paused() {
                    Some(true) => state == RunState::RUNNING_OR_PAUSED,
                    _ => gone > 0 && profile.keeps_run_time() != Some(true),
                };
                if is_paused {
                    return Err(Trouble::Failed(format!(
                        "node {} paused after {gone} ms: a motor failed, its button was pressed, or it received \
                        nothing for a second",
                        self.node.0
                    )));
                }
                break;
            }
            has_run = true;
            let passed = began.elapsed().as_secs_f64();
            if passed > LONGEST.mul_add(seconds, LONGEST) {
                return Err(Trouble::Failed(format!(
                    "node {} is not done after {passed:.0} s instead of {seconds:.1} s: is a motor stuck or unplugged?",
                    self.node.0
                )));
            }
            let (mut places, mut positions, mut is_there) = (Vec::new(), Vec::new(), true);
            for it in planned {
                let place = usize::from(it.motor.get()) - 1;
                let at = in_microsteps(self.position(it.motor).await?, now[place], before[place]);
                places.push(format!("motor {} at {at}", it.motor));
                #[expect(clippy::cast_precision_loss, reason = "positions are far below 2^52")]
                positions.push(At { motor: it.motor.get(), position: at as f64 });
                is_there &= at == i64::from(it.plan.stop.0);
            }
            if !is_there || f64::from(gone) < 1000.0 * seconds {
                last_photo = gone;
            } else if rest.is_some_and(|rest| gone - last_photo > rest / 2) {
                self.set(message::Stop {}).await?;
            }
            let gone = f64::from(gone) / 1000.0;
            let line = format!("{gone:.1} of {seconds:.1} s: {}", places.join(", "));
            self.progress(Some(gone / seconds), positions, &line)?;
        }
        let took = began.elapsed().as_secs_f64();
        self.restore_microsteps(before).await?;
        for it in planned {
            // A start that chooses the microsteps may cut places to whole steps.
            let microstep = profile.first_microstep(it.motor).0;
            let off = if profile.start_sets_microsteps() == Some(false) { 0 } else { u32::from(microstep) - 1 };
            self.arrive(it.motor, it.plan.stop.0, off, answered || has_run).await?;
        }
        // The clock of a node is never wrong by that much. Motors may reach their end long before the last photo.
        if took < 0.99 * seconds {
            return Err(Trouble::Failed(format!(
                "node {} ended after {took:.1} s instead of {seconds:.1} s: it was stopped, or its power failed",
                self.node.0
            )));
        }
        for motor in Motor::ALL.into_iter().filter(|motor| planned.iter().all(|it| it.motor != *motor)) {
            self.until_rest(motor).await?;
        }
        self.dead_man(false).await
    }

    /// Microsteps of all motors.
    async fn microsteps(&mut self) -> Result<[Microstep; 3], Trouble> {
        let mut all = [Microstep::FULL; 3];
        for (microstep, motor) in all.iter_mut().zip(Motor::ALL) {
            *microstep = self.read(message::MotorMicrostep { motor }).await?;
        }
        Ok(all)
    }

    /// Sets the microsteps of all motors that a start has changed, as some firmware does, because all positions are counted
    /// in them (decision H-47).
    async fn restore_microsteps(&mut self, before: [Microstep; 3]) -> Result<(), Trouble> {
        let now = self.microsteps().await?;
        for ((motor, microstep), now) in Motor::ALL.into_iter().zip(before).zip(now) {
            if microstep != now {
                self.until_rest(motor).await?;
                self.set_microstep(motor, microstep).await?;
            }
        }
        Ok(())
    }
}

/// Position in other microsteps.
fn in_microsteps(at: i32, found: Microstep, wanted: Microstep) -> i64 {
    i64::from(at) * i64::from(wanted.0) / i64::from(found.0.max(1))
}
