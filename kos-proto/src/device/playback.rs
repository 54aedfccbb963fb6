//! Move of a device: stored, made ready, played, stopped (kOS 7.4). The photos are in `lapse.rs`.

use motion_core::time::Millis;

use super::effects::Effects;
use super::event::Event;
use super::motor::{Drives, State as Calibration};
use super::options::Options;
pub use super::stage::State;
use super::stage::{Lapse, Leg, Next, Stage};
use crate::message::{Direction, ErrorCode, MotorAddress, MotorSet, Normalized, PlaybackMode, PlaybackState, Seconds};
use crate::move_summary::{Kind, Loops, MoveSummary, Wait};
use crate::times::{part, seconds};
use crate::trajectory::{LoopCount, TrajectoryData, rules};

/// Motors and options that a move depends on.
#[derive(Clone, Copy)]
pub(super) struct Rig<'r> {
    drives: &'r Drives,
    options: &'r Options,
}

impl<'r> Rig<'r> {
    pub(super) const fn of(drives: &'r Drives, options: &'r Options) -> Self {
        Self { drives, options }
    }

    pub(super) fn travel_limit(self, now: Millis) -> Option<Millis> {
        self.options.travel_limit().map(|limit| now.after(limit))
    }

    fn progress(self, now: Millis) -> Option<Millis> {
        self.options.progress_every().map(|every| now.after(every))
    }
}

/// Move of a device, and its stage. Without `MOVES`, the stage is always `Empty`, and the linker leaves out the code of all others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Playback<const MOVES: bool> {
    stage: Stage,
    plan: Option<MoveSummary>,
    /// State that was told last.
    status: PlaybackState,
    /// Number of loops that are done; 0 if they are not counted.
    loops: u8,
    /// Number of photos taken in the move.
    pub(super) photos: u32,
}

impl<const MOVES: bool> Default for Playback<MOVES> {
    fn default() -> Self {
        Self { stage: Stage::Empty, plan: None, status: PlaybackState::NO_MOVE, loops: 0, photos: 0 }
    }
}

impl<const MOVES: bool> Playback<MOVES> {
    const fn stage(&self) -> &Stage {
        if MOVES { &self.stage } else { &Stage::Empty }
    }

    pub(super) const fn state(&self) -> State {
        self.stage().state()
    }

    pub(super) const fn plan(&self) -> Option<&MoveSummary> {
        if MOVES { self.plan.as_ref() } else { None }
    }

    pub(super) const fn status(&self) -> PlaybackState {
        self.status
    }

    pub(super) fn mode(&self) -> PlaybackMode {
        self.plan().map_or(PlaybackMode::LIVE_MOTION, MoveSummary::mode)
    }

    /// Time until the move begins.
    pub(super) fn remaining(&self, now: Millis) -> Seconds {
        match *self.stage() {
            Stage::Delay { until, .. } => seconds(until.since(now)),
            _ => Seconds(0.0),
        }
    }

    /// Part of the move that is over; on the way back it becomes less.
    pub(super) fn elapsed(&self, now: Millis) -> Normalized {
        match *self.stage() {
            Stage::Leg(Leg { way, from, until, .. }) => match way {
                Direction::Forward => part(now.since(from), until.since(from)),
                Direction::Reverse => part(until.since(now), until.since(from)),
            },
            Stage::Lapse(_) => {
                let shots = self.plan().and_then(MoveSummary::shots);
                shots.map_or(Normalized(0.0), |shots| part(self.photos.into(), shots.moving.into()))
            }
            _ => Normalized(0.0),
        }
    }

    pub(super) fn deadline(&self) -> Option<Millis> {
        self.stage().deadline()
    }

    /// Tells the state of the move.
    pub(super) fn set_status(&mut self, now: Millis, output: &mut Effects<'_, '_>, rig: Rig<'_>, state: PlaybackState) {
        self.status = state;
        let motors = self.plan().map_or(MotorSet::NONE, |plan| plan.motors);
        output.status(state, self.elapsed(now), self.photos, rig.drives.positions(motors));
    }

    /// Stores a move. A move that cannot be played, or leaves the range of a motor, clears the one that is stored (decisions
    /// K-J8 and K-J14).
    pub(super) fn store<'a>(&mut self, output: &mut Effects<'_, 'a>, data: TrajectoryData<'a>) {
        if self.state().runs() {
            return output.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
        }
        *self = Self::default();
        let outside = rules::outside_range(&data.blocks).map_or(Ok(()), |error| Err(error.into()));
        match MoveSummary::of(&data).and_then(|plan| outside.map(|()| plan)) {
            Ok(plan) => {
                (self.stage, self.plan) = (Stage::Loaded, Some(plan));
                output.event(Event::StoreTrajectory(data));
            }
            Err(error) => {
                output.event(Event::BadTrajectory(error));
                output.refuse(error.code());
            }
        }
    }

    /// Clears the move that is stored, because one came that ends in the middle of a block.
    pub(super) fn forget(&mut self, output: &mut Effects<'_, '_>) {
        if self.state().runs() {
            return output.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
        }
        *self = Self::default();
        output.refuse(ErrorCode::TRAJECTORY);
    }

    /// Move that is stored, if all its motors can play it. Otherwise the client is told why not.
    fn playable(&self, output: &mut Effects<'_, '_>, rig: Rig<'_>) -> Option<MoveSummary> {
        if self.state().runs() {
            output.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
            return None;
        }
        let checked = self.plan().copied().ok_or((ErrorCode::CANNOT_EXECUTE_MOVE, MotorAddress::ALL));
        let checked = checked.and_then(|plan| able(&plan, rig.drives).map(|()| plan));
        checked.map_err(|(code, motor)| output.answer_error(code, motor)).ok()
    }

    /// Makes the move ready.
    pub(super) fn setup(
        &mut self,
        now: Millis,
        output: &mut Effects<'_, '_>,
        rig: Rig<'_>,
        way: Direction,
        delay_return: bool,
    ) {
        let Some(plan) = self.playable(output, rig) else { return };
        if way == Direction::Reverse && plan.shots().is_some() {
            output.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
        } else if delay_return {
            self.stage = Stage::Ready { home: None };
            self.set_status(now, output, rig, PlaybackState::SETUP_COMPLETED);
        } else {
            self.go_home(now, output, rig, &plan, Next::Setup { start: false }, way);
        }
    }

    /// Sends the motors to where the move begins.
    pub(super) fn rapid(&mut self, now: Millis, output: &mut Effects<'_, '_>, rig: Rig<'_>) {
        let ready = self.state() == State::Ready;
        if let Some(plan) = self.playable(output, rig) {
            self.go_home(now, output, rig, &plan, Next::Rapid { ready }, Direction::Forward);
        }
    }

    /// Plays the move.
    pub(super) fn start(&mut self, now: Millis, output: &mut Effects<'_, '_>, rig: Rig<'_>, way: Direction) {
        // While the move is made ready for the same direction, one start is remembered.
        if let Stage::Homing { next: Next::Setup { start }, way: setup, .. } = &mut self.stage {
            let late = self.plan.is_none_or(|plan| begins(now, &plan, rig.options).is_err());
            if *start || *setup != way {
                output.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
            } else if late {
                output.refuse(ErrorCode::INVALID_MOVE_TIME);
            } else {
                *start = true;
            }
            return;
        }
        let Some(plan) = self.playable(output, rig) else { return };
        if way == Direction::Reverse && plan.shots().is_some() {
            output.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
        } else if begins(now, &plan, rig.options).is_err() {
            output.refuse(ErrorCode::INVALID_MOVE_TIME);
        } else if *self.stage() == (Stage::Ready { home: Some(way) }) {
            self.gate(now, output, rig, &plan, way);
        } else {
            self.go_home(now, output, rig, &plan, Next::Start, way);
        }
    }

    fn go_home(
        &mut self,
        now: Millis,
        output: &mut Effects<'_, '_>,
        rig: Rig<'_>,
        plan: &MoveSummary,
        next: Next,
        way: Direction,
    ) {
        let limit = rig.travel_limit(now);
        self.stage = Stage::Homing { next, way, waiting: plan.motors, limit };
        output.event(Event::Home { way, speed: plan.return_to_home_percent, motors: plan.motors });
        self.is_home(now, output, rig);
    }

    /// Goes on when the last motor is home.
    fn is_home(&mut self, now: Millis, output: &mut Effects<'_, '_>, rig: Rig<'_>) {
        let Stage::Homing { next, way, waiting: MotorSet::NONE, .. } = self.stage else { return };
        let Some(plan) = self.plan else { return };
        self.set_status(now, output, rig, PlaybackState::MOTORS_HOME);
        self.stage = match next {
            Next::Rapid { ready: false } => Stage::Loaded,
            Next::Rapid { ready: true } | Next::Setup { .. } | Next::Start => Stage::Ready { home: Some(way) },
        };
        if let Next::Setup { .. } = next {
            self.set_status(now, output, rig, PlaybackState::SETUP_COMPLETED);
        }
        if let Next::Start | Next::Setup { start: true } = next {
            self.gate(now, output, rig, &plan, way);
        }
    }

    /// Begins the move that is ready, or waits for its time.
    fn gate(&mut self, now: Millis, output: &mut Effects<'_, '_>, rig: Rig<'_>, plan: &MoveSummary, way: Direction) {
        match begins(now, plan, rig.options) {
            Err(()) => {
                output.event(Event::StopAll);
                output.tell_error(ErrorCode::INVALID_MOVE_TIME, MotorAddress::ALL);
                self.full_stop(now, output, rig);
            }
            Ok(Some(until)) => {
                self.stage = Stage::Delay { until, way };
                self.set_status(now, output, rig, PlaybackState::DELAY_TIMER_STARTED);
            }
            Ok(None) => self.begin(now, output, rig, plan, way),
        }
    }

    fn begin(&mut self, now: Millis, output: &mut Effects<'_, '_>, rig: Rig<'_>, plan: &MoveSummary, way: Direction) {
        match plan.kind {
            Kind::Live { duration, .. } => self.leg(now, output, rig, way, false, duration),
            Kind::Continuous(_) | Kind::ShootMoveShoot(_) => self.begin_lapse(now, output, rig, plan),
        }
    }

    fn leg(
        &mut self,
        now: Millis,
        output: &mut Effects<'_, '_>,
        rig: Rig<'_>,
        way: Direction,
        back: bool,
        duration: u64,
    ) {
        let (from, until) = (now, now.after(duration));
        let progress = rig.progress(now);
        self.stage = Stage::Leg(Leg { way, back, from, until, progress });
        output.event(Event::Play { way, millis: duration });
        self.set_status(now, output, rig, running(way));
    }

    /// Ends a pass: the move goes back, is played again, or is over.
    fn leg_over(&mut self, now: Millis, output: &mut Effects<'_, '_>, rig: Rig<'_>, leg: Leg) {
        self.set_status(now, output, rig, PlaybackState::END_OF_MOVE);
        let Some(Kind::Live { duration, loops }) = self.plan.map(|plan| plan.kind) else { return };
        if leg.back {
            let endless = loops.is_some_and(|loops| loops.count == LoopCount::FOREVER);
            self.loops = if endless { 0 } else { self.loops.saturating_add(1) };
            return self.leg(now, output, rig, leg.way.back(), false, duration);
        }
        match loops {
            Some(Loops { duration, count }) if self.loops < count.0 => {
                self.leg(now, output, rig, leg.way.back(), true, duration);
            }
            _ => self.done(now, output, rig),
        }
    }

    pub(super) fn set_lapse(&mut self, lapse: Lapse) {
        self.stage = Stage::Lapse(lapse);
    }

    /// Ends the move.
    pub(super) fn done(&mut self, now: Millis, output: &mut Effects<'_, '_>, rig: Rig<'_>) {
        output.event(Event::MoveOver);
        self.full_stop(now, output, rig);
    }

    /// Tells that all is over, and forgets the move (decision K-J14).
    pub(super) fn full_stop(&mut self, now: Millis, output: &mut Effects<'_, '_>, rig: Rig<'_>) {
        self.set_status(now, output, rig, PlaybackState::FULL_STOP);
        *self = Self { status: PlaybackState::FULL_STOP, ..Self::default() };
    }

    /// Notes that a motor is where it was sent.
    pub(super) fn arrived(&mut self, now: Millis, output: &mut Effects<'_, '_>, rig: Rig<'_>, motor: MotorAddress) {
        match &mut self.stage {
            _ if !MOVES => {}
            Stage::Homing { waiting, .. } => {
                waiting.remove(motor);
                self.is_home(now, output, rig);
            }
            Stage::Lapse(Lapse::Moving { waiting, .. }) => {
                waiting.remove(motor);
                let waiting = *waiting;
                self.frame_reached(now, output, rig, waiting);
            }
            _ => {}
        }
    }

    /// Motors that the move moves, and that have to come to rest when it is stopped.
    pub(super) fn travelling(&self) -> MotorSet {
        match *self.stage() {
            Stage::Homing { waiting, .. } | Stage::Lapse(Lapse::Moving { waiting, .. }) => waiting,
            Stage::Leg(_) | Stage::Lapse(Lapse::Continuous(_)) => {
                self.plan().map_or(MotorSet::NONE, |plan| plan.motors)
            }
            _ => MotorSet::NONE,
        }
    }

    pub(super) const fn is_homing(&self) -> bool {
        matches!(self.stage(), Stage::Homing { .. })
    }

    /// Notes that a motor was moved by hand, or its range changed: it may not be where the move begins any more.
    pub(super) fn disturb(&mut self) {
        if let Stage::Ready { home } = &mut self.stage {
            *home = None;
        }
    }

    /// Deals with a deadline that has come.
    ///
    /// # Errors
    ///
    /// The error to tell, if motors did not get to where they should be in time.
    pub(super) fn wake(&mut self, now: Millis, output: &mut Effects<'_, '_>, rig: Rig<'_>) -> Result<(), ErrorCode> {
        if self.deadline().is_none_or(|deadline| deadline > now) {
            return Ok(());
        }
        match *self.stage() {
            Stage::Empty | Stage::Loaded | Stage::Ready { .. } => {}
            Stage::Homing { .. } => return Err(ErrorCode::RETURN_TO_FIRST_KEYFRAME),
            Stage::Delay { way, .. } => {
                if let Some(plan) = self.plan {
                    self.begin(now, output, rig, &plan, way);
                }
            }
            Stage::Leg(leg) if leg.until <= now => self.leg_over(now, output, rig, leg),
            Stage::Leg(leg) => {
                let progress = rig.progress(now);
                self.stage = Stage::Leg(Leg { progress, ..leg });
                self.set_status(now, output, rig, running(leg.way));
            }
            Stage::Lapse(lapse) => return self.wake_lapse(now, output, rig, lapse),
        }
        Ok(())
    }
}

const fn running(way: Direction) -> PlaybackState {
    match way {
        Direction::Forward => PlaybackState::START_FORWARD,
        Direction::Reverse => PlaybackState::START_REVERSE,
    }
}

/// Time at which a move begins that is started now; `None` for at once. An error if the time is over, or there is no
/// clock (safety decision 5).
fn begins(now: Millis, plan: &MoveSummary, options: &Options) -> Result<Option<Millis>, ()> {
    match plan.wait {
        Wait::None => Ok(None),
        Wait::For(millis) => Ok(Some(now.after(millis.max(1)))),
        Wait::Until(unix) => {
            let epoch = options.unix_millis_at_zero().ok_or(())?;
            let moment = Millis(u64::from(unix).saturating_mul(1000).saturating_sub(epoch));
            if moment > now { Ok(Some(moment)) } else { Err(()) }
        }
    }
}

/// Checks that all motors of a move are there, have ranges, and rest (decision K-J14).
fn able(plan: &MoveSummary, drives: &Drives) -> Result<(), (ErrorCode, MotorAddress)> {
    if drives.online().is_empty() {
        return Err((ErrorCode::NO_MOTORS, MotorAddress::ALL));
    }
    if let Some(missing) = plan.motors.iter().find(|&motor| drives.get(motor).is_none()) {
        return Err((ErrorCode::BAD_MOTOR_ADDRESS, missing));
    }
    let calibrated = |motor| drives.get(motor).is_some_and(|drive| drive.state() == Calibration::Calibrated);
    if plan.motors.iter().all(calibrated) && drives.moving().is_empty() {
        Ok(())
    } else {
        Err((ErrorCode::CANNOT_EXECUTE_MOVE, MotorAddress::ALL))
    }
}
