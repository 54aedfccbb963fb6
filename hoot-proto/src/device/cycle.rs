//! The planned move, step by step: the table of hoot, section 4.2, and the cycle of pictures and moves.

use motion_core::states;
use motion_core::time::Millis;

use super::{AltOut, DeviceMachine, Effects, Event, Motion, MotorState, MotorUnit, ProgramState, Quirks};
use crate::message::{AltMode, CommonLine, Motor, ProgramMode, Steps};
use crate::program::Plan;
use crate::query::Profile;

states! {
    /// Phase of a running program. Source: hoot, section 4.2.
    #[derive(Default)]
    pub enum Phase {
        /// The program waits for the next picture.
        #[default]
        Clear,
        /// The auxiliary output comes before the picture.
        OutBefore,
        /// The camera takes the picture.
        Shoot,
        /// The auxiliary output comes after the picture.
        OutAfter,
        /// The motors move.
        Move,
    }
}

/// The planned move of a node.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Program {
    pub(super) state: ProgramState,
    phase: Phase,
    /// Run time until `since`, in milliseconds.
    ran: u64,
    since: Option<Millis>,
    /// Run time of the last program that was stopped or is over.
    last_run_time: u64,
    shots: u32,
    /// Number of moves of the motors, which the lead-in counts.
    moves: u32,
    /// Whether all motors were done when the last picture was taken.
    has_arrived: bool,
    /// Time that the phase waits for.
    until: Option<Millis>,
    /// Earliest time of the picture after the one that is being taken.
    next: Option<Millis>,
    /// Whether the auxiliary output is on.
    out_is_on: bool,
}

motion_core::debug! { Program { state phase ran since last_run_time shots moves has_arrived until next out_is_on } }

impl Program {
    /// State of the planned move.
    #[must_use]
    pub const fn state(&self) -> ProgramState {
        self.state
    }

    /// Phase of the planned move, while it runs.
    #[must_use]
    pub const fn phase(&self) -> Phase {
        self.phase
    }

    /// Number of pictures that were taken.
    #[must_use]
    pub const fn shots(&self) -> u32 {
        self.shots
    }

    /// Run time of the last program that was stopped or is over, or 0, in milliseconds.
    #[must_use]
    pub const fn last_run_time(&self) -> u64 {
        self.last_run_time
    }

    /// Run time in milliseconds, with the delay before the start and without pauses.
    #[must_use]
    pub fn run_time(&self, now: Millis) -> u64 {
        self.ran.saturating_add(self.since.map_or(0, |since| now.since(since)))
    }

    /// Sets the clock back; the run time stays.
    pub(super) fn set_back(&mut self, by: Millis) {
        let before = self.since.map_or(0, |since| by.since(since));
        self.ran = self.ran.saturating_add(before);
        for moment in [&mut self.since, &mut self.until, &mut self.next] {
            *moment = moment.map(|moment| Millis(moment.since(by)));
        }
    }

    /// Time at which the program will have run so long; `None` while it does not run.
    fn at(&self, run_time: u64) -> Option<Millis> {
        self.since.map(|since| since.after(run_time.saturating_sub(self.ran)))
    }

    /// Whether the program runs, or will run when its delay is over.
    pub(super) fn is_going(&self) -> bool {
        matches!(self.state, ProgramState::Delay | ProgramState::Running)
    }
}

impl<const QUIRKS: bool> DeviceMachine<QUIRKS> {
    /// Starts or resumes the program. While it runs, nothing changes. Other motion is stopped first (decision H-3).
    pub(super) fn start(&mut self, now: Millis, output: &mut Effects) {
        if self.program.is_going() {
            return;
        }
        self.stop_motors(output);
        let resumed = self.program.state == ProgramState::Paused;
        if !resumed {
            self.choose_microsteps(output);
            self.shoot_in_video(now, output, Profile::shoots_at_start);
            self.send_without_travel(output);
        }
        self.program.since = Some(now);
        let waits = self.program.ran < self.start_delay();
        self.set_program(output, if waits { ProgramState::Delay } else { ProgramState::Running });
        self.program.until = Some(now);
        if resumed && self.program.phase == Phase::Move {
            self.follow_plans(output);
        } else {
            self.program.phase = Phase::Clear;
        }
    }

    /// Opens the shutter in video mode, as firmware does for a video camera.
    fn shoot_in_video(&mut self, now: Millis, output: &mut Effects, fact: fn(Profile) -> Option<bool>) {
        if self.controller.program_mode == ProgramMode::VIDEO && self.copies(Quirks::FIRMWARE_PHOTOS, fact) {
            self.camera.expose_bare(now, output);
        }
    }

    /// Sends the motors whose planned move has no travel to its stop, as firmware does.
    fn send_without_travel(&mut self, output: &mut Effects) {
        let is_sent = self.moves_by_clock() && self.copies(Quirks::MOVES_ALL, Profile::sends_without_travel);
        for motor in self.motors.iter_mut().filter(|motor| is_sent && motor.lacks_travel()) {
            motor.follow(output, Motion::To(motor.settings.plan.stop));
        }
    }

    /// Pauses the program and keeps its place. The motors stop first.
    pub(super) fn pause(&mut self, now: Millis, output: &mut Effects) {
        // By the clock, motors are started again from where they would be (decision H-11).
        let (by_clock, is_stuck) = (self.moves_by_clock(), self.never_resumes());
        for motor in self.motors.iter_mut().filter(|motor| by_clock && motor.is_moving()) {
            (motor.done, motor.is_stuck) = (is_stuck.into(), is_stuck);
        }
        self.stop_motors(output);
        self.camera.stop(output);
        self.drop_out(output);
        if self.program.is_going() {
            self.program.ran = self.program.run_time(now);
            (self.program.since, self.program.until) = (None, None);
            self.set_program(output, ProgramState::Paused);
        }
    }

    /// Stops the program and forgets its place. The motors stop first.
    pub(super) fn stop(&mut self, now: Millis, output: &mut Effects) {
        self.stop_motors(output);
        self.camera.stop(output);
        self.drop_out(output);
        self.set_program(output, ProgramState::Stopped);
        let last_run_time = match self.program.run_time(now) {
            0 => self.program.last_run_time,
            run_time => run_time,
        };
        self.program = Program { last_run_time, ..Program::default() };
        for motor in &mut self.motors {
            (motor.done, motor.began, motor.is_stuck) = (0, None, false);
        }
    }

    fn set_program(&mut self, output: &mut Effects, state: ProgramState) {
        if self.program.state != state {
            self.program.state = state;
            output.event(Event::Program(state));
        }
    }

    pub(super) fn stop_motors(&mut self, output: &mut Effects) {
        for motor in &mut self.motors {
            motor.stop(output);
        }
    }

    /// Stops a program that has run for longer than it may; only a timing master counts.
    pub(super) fn limit_run_time(&mut self, now: Millis, output: &mut Effects) {
        if self.run_time_ends().is_some_and(|end| now >= end) {
            self.stop(now, output);
        }
    }

    /// Time at which the program has run for longer than it may.
    pub(super) fn run_time_ends(&self) -> Option<Millis> {
        let limit = u64::from(self.controller.max_run_time.0);
        if limit == 0 || !self.controller.timing_master { None } else { self.program.at(limit.saturating_add(1)) }
    }

    /// Goes on with what waits for a time, for motors or for the camera. Each picture takes at least a millisecond, so this
    /// comes to an end.
    pub(super) fn go_on(&mut self, now: Millis, output: &mut Effects) {
        let counts = self.camera.wake(now, output) && self.program.phase == Phase::Shoot;
        self.program.shots = self.program.shots.saturating_add(counts.into());
        if self.program.state == ProgramState::Delay && self.program.at(self.start_delay()).is_some_and(|at| now >= at)
        {
            self.set_program(output, ProgramState::Running);
        }
        if self.program.state != ProgramState::Running {
            return;
        }
        self.follow_the_clock(now, output);
        self.await_motors();
        let is_due = self.program.until.is_some_and(|until| now >= until);
        match self.program.phase {
            Phase::Clear if is_due && self.waits_for_time() && !self.is_finished() => self.begin(now, output),
            Phase::OutBefore | Phase::OutAfter if is_due => self.switch_out(now, output),
            Phase::Shoot if !self.camera.is_busy() => self.after_picture(now, output),
            _ => {}
        }
        self.await_motors();
        if self.program.phase == Phase::Clear && self.is_finished() {
            self.finish(now, output);
        }
    }

    fn await_motors(&mut self) {
        if self.program.phase == Phase::Move && !self.motors.iter().any(MotorUnit::is_moving) {
            self.program.phase = Phase::Clear;
        }
    }

    /// Delay before the start, in milliseconds. If the unit is not known, it is taken for milliseconds.
    fn start_delay(&self) -> u64 {
        let delay = self.controller.start_delay;
        delay.milliseconds(self.options.profile()).unwrap_or(delay.0.into())
    }

    /// Whether the next picture comes by the clock: not while the camera is busy, not in a node that waits for the common
    /// line, and not with an external intervalometer. In video mode without a camera there are no pictures.
    fn waits_for_time(&self) -> bool {
        let is_pulsed = !self.controller.timing_master || self.has_contact(AltMode::EXTERNAL_INTERVALOMETER);
        !is_pulsed && self.can_begin()
    }

    fn can_begin(&self) -> bool {
        let has_pictures = self.controller.program_mode != ProgramMode::VIDEO || self.camera.settings.enable;
        has_pictures && !self.camera.is_busy()
    }

    /// Takes the next picture, for which the common line or the external intervalometer asks.
    pub(super) fn pulse(&mut self, now: Millis, output: &mut Effects) {
        let waits = self.program.state == ProgramState::Running && self.program.phase == Phase::Clear;
        if waits && self.can_begin() && !self.is_finished() {
            self.begin(now, output);
        }
    }

    /// Begins the next picture, or, without a camera, the next move.
    fn begin(&mut self, now: Millis, output: &mut Effects) {
        if self.controller.timing_master && self.controller.common_line != CommonLine::OFF {
            output.event(Event::CommonLine);
        }
        // Counted from the time at which it was due, however late the machine was woken. A picture that was missed is not
        // made up for.
        let interval = u64::from(self.camera.settings.interval.0).max(1);
        let next = self.program.until.map(|due| due.after(interval)).filter(|next| *next > now);
        let next = next.unwrap_or(now.after(interval));
        if !self.camera.settings.enable {
            self.program.until = Some(self.without_camera(now, next));
            self.move_on(now, output);
        } else if self.has_contact(AltMode::OUT_BEFORE) {
            self.program.next = Some(next);
            self.enter_out(now, Phase::OutBefore);
        } else {
            self.program.next = Some(next);
            self.shoot(now, output);
        }
    }

    /// Time of the next move without a camera: when the motors rest, or, in continuous mode, after the interval (decision
    /// H-9).
    fn without_camera(&self, now: Millis, next: Millis) -> Millis {
        if self.controller.program_mode == ProgramMode::CONTINUOUS { next } else { now.after(1) }
    }

    fn shoot(&mut self, now: Millis, output: &mut Effects) {
        self.program.phase = Phase::Shoot;
        self.program.until = None;
        self.camera.expose(now, output, self.camera.settings.mirror_up);
    }

    fn after_picture(&mut self, now: Millis, output: &mut Effects) {
        if self.has_contact(AltMode::OUT_AFTER) {
            self.enter_out(now, Phase::OutAfter);
        } else {
            self.program.until = self.program.next.take().map(|next| next.max(now.after(1)));
            self.move_on(now, output);
        }
    }

    fn out_times(&self) -> AltOut {
        if self.program.phase == Phase::OutBefore { self.controller.out_before } else { self.controller.out_after }
    }

    fn enter_out(&mut self, now: Millis, phase: Phase) {
        self.program.phase = phase;
        self.program.until = Some(now.after(u64::from(self.out_times().delay.0).max(1)));
    }

    /// Switches the auxiliary output on after its delay, and off after its time.
    fn switch_out(&mut self, now: Millis, output: &mut Effects) {
        self.program.out_is_on = !self.program.out_is_on;
        output.event(Event::AltOut { on: self.program.out_is_on });
        if self.program.out_is_on {
            self.program.until = Some(now.after(u64::from(self.out_times().time.0).max(1)));
        } else if self.program.phase == Phase::OutBefore {
            self.shoot(now, output);
        } else {
            self.program.until = self.program.next.take().map(|next| next.max(now.after(1)));
            self.move_on(now, output);
        }
    }

    fn drop_out(&mut self, output: &mut Effects) {
        self.program.next = None;
        if core::mem::take(&mut self.program.out_is_on) {
            output.event(Event::AltOut { on: false });
        }
    }

    /// Makes the next step of the planned move of each motor. In the modes without stops, motors follow the clock and are not
    /// waited for.
    fn move_on(&mut self, now: Millis, output: &mut Effects) {
        self.program.moves = self.program.moves.saturating_add(1);
        if self.moves_by_clock() {
            self.program.phase = Phase::Clear;
            self.program.has_arrived = self.motors.iter().all(|motor| self.is_done(motor));
            let run_time = self.program.run_time(now);
            let is_lapse = self.controller.program_mode == ProgramMode::CONTINUOUS;
            let by_time = self.copies(Quirks::FIRMWARE_PHOTOS, Profile::leads_in_lapses_by_time);
            let enabled = self.motors.iter().filter(|motor| motor.state != MotorState::Disabled);
            let least = enabled.map(|motor| motor.settings.lead_in.0).min().unwrap_or(0);
            for motor in self.motors.iter_mut().filter(|motor| is_lapse && motor.has_plan()) {
                let lead_in = motor.settings.lead_in.0;
                let photos = if by_time { least } else { lead_in };
                if self.program.moves > photos && (!by_time || run_time > lead_in.into()) {
                    motor.began.get_or_insert(run_time);
                }
            }
            self.follow_the_clock(now, output);
            return;
        }
        let at = self.places_of_shots();
        for motor in &mut self.motors {
            let plan = motor.settings.plan;
            if motor.has_plan() && self.program.moves > motor.settings.lead_in.0 && motor.done < plan.travel.0 {
                motor.done = motor.done.saturating_add(1);
                let to = at(&plan, motor.done);
                if to != motor.position || motor.is_moving() {
                    motor.follow(output, Motion::To(to));
                }
            }
        }
        self.program.phase = Phase::Move;
    }

    /// Sends motors again to the positions that a pause kept them from (decision H-11).
    fn follow_plans(&mut self, output: &mut Effects) {
        let at = self.places_of_shots();
        for motor in &mut self.motors {
            let to = at(&motor.settings.plan, motor.done);
            if motor.has_plan() && motor.done > 0 && to != motor.position {
                motor.follow(output, Motion::To(to));
            }
        }
    }

    /// Places of a planned move at which motors stop for photos.
    const fn places_of_shots(&self) -> fn(&Plan, u32) -> Steps {
        if self.has_quirk(Quirks::FIRMWARE_PHOTOS) { Plan::at_shot } else { Plan::at }
    }

    /// Whether motors move by the clock: the travel and its ramps are milliseconds (decision H-66).
    const fn moves_by_clock(&self) -> bool {
        matches!(self.controller.program_mode, ProgramMode::CONTINUOUS | ProgramMode::VIDEO)
    }

    fn never_resumes(&self) -> bool {
        self.has_quirk(Quirks::NEVER_RESUMES) && self.options.profile().resumes_moves() == Some(false)
    }

    /// Run time at which a motor begins its planned move by the clock: in video mode after the delay and its lead-in
    /// (decision H-10), in a time lapse after the pictures of its lead-in.
    fn begins(&self, motor: &MotorUnit) -> Option<u64> {
        let [first, ..] = &self.motors;
        let waits = first.state != MotorState::Disabled && first.settings.lead_in.0 > self.program.shots;
        match self.controller.program_mode {
            ProgramMode::VIDEO if waits && self.copies(Quirks::FIRMWARE_PHOTOS, Profile::leads_in_videos_by_photos) => {
                None
            }
            ProgramMode::VIDEO => Some(self.start_delay().saturating_add(motor.settings.lead_in.0.into())),
            ProgramMode::CONTINUOUS => motor.began,
            _ => None,
        }
    }

    /// Time at which a motor begins its planned move by the clock, or goes on with it; `None` if it waits for no time.
    fn clock_begins(&self, motor: &MotorUnit) -> Option<Millis> {
        if motor.has_plan() && motor.done == 0 && self.program.state == ProgramState::Running {
            self.program.at(self.begins(motor)?)
        } else {
            None
        }
    }

    /// Starts the motors that move by the clock and whose time has come, and the motors that a pause has stopped.
    fn follow_the_clock(&mut self, now: Millis, output: &mut Effects) {
        let run_time = self.program.run_time(now);
        for motor in Motor::ALL {
            let unit = self.motor(motor);
            if self.clock_begins(unit).is_none_or(|begin| now < begin) {
                continue;
            }
            let Some(begin) = self.begins(unit) else { continue };
            let unit = self.motor_mut(motor);
            let plan = unit.settings.plan;
            let at = u32::try_from(run_time.saturating_sub(begin)).unwrap_or(u32::MAX);
            unit.done = 1;
            unit.follow(output, Motion::Along { plan, elapsed: at.min(plan.travel.0) });
        }
    }

    /// Whether a motor is at the end of its planned move, or has none. Later firmware waits for ever for a motor that has no
    /// travel to its stop (decision H-82).
    fn is_done(&self, motor: &MotorUnit) -> bool {
        let by_clock = self.moves_by_clock();
        if by_clock
            && motor.lacks_travel()
            && self.has_quirk(Quirks::MOVES_ALL)
            && self.options.profile().sends_without_travel() == Some(false)
        {
            return false;
        }
        let steps = if by_clock { 1 } else { motor.settings.plan.travel.0 };
        !motor.has_plan() || motor.done >= steps && motor.state != MotorState::Moving && !motor.is_stuck
    }

    /// Whether the program is over: all photos are taken, or, without a camera, all motors are done. Without stops, later
    /// firmware goes on until its motors are done.
    fn is_finished(&self) -> bool {
        let settings = &self.camera.settings;
        if !settings.enable {
            return self.motors.iter().all(|motor| self.is_done(motor));
        }
        let copies = |fact: fn(Profile) -> Option<bool>| self.copies(Quirks::FIRMWARE_PHOTOS, fact);
        if self.moves_by_clock() {
            if self.program.has_arrived && copies(Profile::ends_with_motors) {
                return true;
            }
            if copies(Profile::outlasts_photos) {
                return false;
            }
        }
        let (shots, max_shots) = (self.program.shots, u32::from(settings.max_shots.0));
        let is_last = if copies(Profile::takes_one_more) { shots > max_shots } else { shots >= max_shots };
        max_shots > 0 && is_last
    }

    /// Ends the program, or begins the way back. A program that moves nothing has no way back (decision H-12).
    fn finish(&mut self, now: Millis, output: &mut Effects) {
        let goes_back = self.controller.ping_pong && self.motors.iter().any(MotorUnit::has_plan);
        self.stop(now, output);
        if !goes_back {
            self.shoot_in_video(now, output, Profile::shoots_at_end);
        }
        if goes_back {
            for motor in &mut self.motors {
                let plan = &mut motor.settings.plan;
                core::mem::swap(&mut plan.start, &mut plan.stop);
            }
            self.start(now, output);
            self.program.until = Some(now.after(1));
            self.follow_the_clock(now, output);
        }
    }

    /// Adds the times that the program waits for.
    pub(super) fn program_wakes(&self, output: &mut Effects) {
        let running = self.program.state == ProgramState::Running;
        let delay = if self.program.state == ProgramState::Delay { self.program.at(self.start_delay()) } else { None };
        let by_clock = match self.program.phase {
            Phase::Clear => self.waits_for_time(),
            Phase::OutBefore | Phase::OutAfter => true,
            Phase::Shoot | Phase::Move => false,
        };
        let phase = if running && by_clock { self.program.until } else { None };
        let video = self.motors.iter().filter_map(|motor| self.clock_begins(motor));
        for moment in [delay, phase, self.run_time_ends(), self.camera.until()].into_iter().flatten().chain(video) {
            output.wake_by(moment);
        }
    }
}
