//! The move of a device: stored, made ready, played, stopped (kOS 7.4). Its photos are in the next file.

use motion_core::time::Millis;

use super::lapse::{self, Lapse};
use super::motor::{Drives, State as Calibration};
use super::{Event, Turn};
use crate::message::{ErrorCode, MotorAddress, Normalized, PlaybackMode, PlaybackState, Seconds};
use crate::summary::{Direction, Kind, Loops, MotorSet, MoveSummary, SummaryError, Wait, part, seconds};
use crate::trajectory::LoopCount;

/// How far the device is with its move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum State {
    /// There is no move.
    Empty,
    /// A move is stored.
    Loaded,
    /// It can be played; the motors are where it begins, or not.
    Ready,
    /// The motors go to where it begins, to be ready.
    HomingSetup,
    /// The motors go to where it begins, to play it at once.
    HomingStart,
    /// The motors go to where it begins, and that is all.
    HomingRapid,
    /// It waits for its time.
    Delay,
    /// It is played from begin to end.
    Forward,
    /// It is played from end to begin.
    Reverse,
    /// A time lapse takes the photos before the move.
    Pre,
    /// A time lapse takes photos while the motors move.
    ForwardC,
    /// Shoot, move, shoot: the motors rest, and the photo waits.
    FrameDelay,
    /// Shoot, move, shoot: the shutter is open.
    Exposing,
    /// Shoot, move, shoot: the motors go to the next place.
    Moving,
    /// A time lapse takes the photos behind the move.
    Post,
}

impl State {
    /// All of them.
    pub const ALL: [Self; 15] = [
        Self::Empty,
        Self::Loaded,
        Self::Ready,
        Self::HomingSetup,
        Self::HomingStart,
        Self::HomingRapid,
        Self::Delay,
        Self::Forward,
        Self::Reverse,
        Self::Pre,
        Self::ForwardC,
        Self::FrameDelay,
        Self::Exposing,
        Self::Moving,
        Self::Post,
    ];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Empty => "Empty",
            Self::Loaded => "Loaded",
            Self::Ready => "Ready",
            Self::HomingSetup => "HomingSetup",
            Self::HomingStart => "HomingStart",
            Self::HomingRapid => "HomingRapid",
            Self::Delay => "Delay",
            Self::Forward => "Forward",
            Self::Reverse => "Reverse",
            Self::Pre => "Pre",
            Self::ForwardC => "ForwardC",
            Self::FrameDelay => "FrameDelay",
            Self::Exposing => "Exposing",
            Self::Moving => "Moving",
            Self::Post => "Post",
        }
    }

    /// Whether a move runs, so that nothing but a stop is taken (safety decision 1).
    #[must_use]
    pub const fn runs(self) -> bool {
        !matches!(self, Self::Empty | Self::Loaded | Self::Ready)
    }
}

/// What follows when all motors are home.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Next {
    /// Ready; then perhaps the move at once.
    Setup { start: bool },
    /// The move.
    Start,
    /// Nothing: it is loaded, or ready, as before.
    Rapid { ready: bool },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Stage {
    Empty,
    Loaded,
    /// `home`: for which way the motors are where the move begins.
    Ready {
        home: Option<Direction>,
    },
    Homing {
        next: Next,
        way: Direction,
        waiting: MotorSet,
        limit: Option<Millis>,
    },
    Delay {
        until: Millis,
        way: Direction,
    },
    Leg(Leg),
    Lapse(Lapse),
}

/// One way through a live move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Leg {
    way: Direction,
    /// Whether it goes back to where the move began.
    back: bool,
    from: Millis,
    until: Millis,
    progress: Option<Millis>,
}

/// A move, and how far the device is with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Playback {
    stage: Stage,
    plan: Option<MoveSummary>,
    /// What was last said of it.
    status: PlaybackState,
    /// Loops that are done; 0 where they are not counted.
    loops: u8,
    /// Photos taken in it.
    pub(super) photos: u32,
}

impl Default for Playback {
    fn default() -> Self {
        Self { stage: Stage::Empty, plan: None, status: PlaybackState::NO_MOVE, loops: 0, photos: 0 }
    }
}

impl Playback {
    pub(super) const fn state(&self) -> State {
        match self.stage {
            Stage::Empty => State::Empty,
            Stage::Loaded => State::Loaded,
            Stage::Ready { .. } => State::Ready,
            Stage::Homing { next: Next::Setup { .. }, .. } => State::HomingSetup,
            Stage::Homing { next: Next::Start, .. } => State::HomingStart,
            Stage::Homing { next: Next::Rapid { .. }, .. } => State::HomingRapid,
            Stage::Delay { .. } => State::Delay,
            Stage::Leg(Leg { way: Direction::Forward, .. }) => State::Forward,
            Stage::Leg(Leg { way: Direction::Reverse, .. }) => State::Reverse,
            Stage::Lapse(lapse) => lapse.state(),
        }
    }

    pub(super) const fn plan(&self) -> Option<&MoveSummary> {
        self.plan.as_ref()
    }

    pub(super) const fn status(&self) -> PlaybackState {
        self.status
    }

    pub(super) fn mode(&self) -> PlaybackMode {
        self.plan.as_ref().map_or(PlaybackMode::LIVE_MOTION, MoveSummary::mode)
    }

    /// Time until the move begins.
    pub(super) fn remaining(&self, now: Millis) -> Seconds {
        match self.stage {
            Stage::Delay { until, .. } => seconds(until.since(now)),
            _ => Seconds(0.0),
        }
    }

    /// How much of the move is over; on the way back it becomes less.
    pub(super) fn elapsed(&self, now: Millis) -> Normalized {
        match self.stage {
            Stage::Leg(Leg { way, from, until, .. }) => match way {
                Direction::Forward => part(now.since(from), until.since(from)),
                Direction::Reverse => part(until.since(now), until.since(from)),
            },
            Stage::Lapse(_) => {
                let shots = self.plan.as_ref().and_then(MoveSummary::shots);
                shots.map_or(Normalized(0.0), |shots| part(self.photos.into(), shots.moving.into()))
            }
            _ => Normalized(0.0),
        }
    }

    /// The next moment that something follows from.
    pub(super) fn deadline(&self) -> Option<Millis> {
        match self.stage {
            Stage::Empty | Stage::Loaded | Stage::Ready { .. } => None,
            Stage::Homing { limit, .. } => limit,
            Stage::Delay { until, .. } => Some(until),
            Stage::Leg(Leg { until, progress, .. }) => Some(progress.map_or(until, |progress| progress.min(until))),
            Stage::Lapse(lapse) => lapse.deadline(),
        }
    }

    /// Says how far it is.
    pub(super) fn say(&mut self, turn: &mut Turn<'_>, drives: &Drives, state: PlaybackState) {
        self.status = state;
        turn.status(state, self.elapsed(turn.now), self.photos, drives);
    }

    /// A move is to be stored: what cannot be played takes the place of nothing (decision K-J14).
    pub(super) fn store(&mut self, turn: &mut Turn<'_>, plan: Result<MoveSummary, SummaryError>) {
        if self.state().runs() {
            return turn.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
        }
        *self = Self::default();
        match plan {
            Ok(plan) => {
                (self.stage, self.plan) = (Stage::Loaded, Some(plan));
                turn.output.event(Event::StoreTrajectory);
            }
            Err(error) => {
                turn.refuse(error.code());
                turn.output.event(Event::BadTrajectory(error));
            }
        }
    }

    /// A move came that ends in the middle of a block.
    pub(super) fn forget(&mut self, turn: &mut Turn<'_>) {
        if self.state().runs() {
            return turn.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
        }
        *self = Self::default();
        turn.refuse(ErrorCode::TRAJECTORY);
    }

    /// The move, if there is one and all its motors can play it.
    fn playable(&self, turn: &mut Turn<'_>, drives: &Drives) -> Option<MoveSummary> {
        if self.state().runs() {
            turn.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
            return None;
        }
        let checked = self.plan.ok_or((ErrorCode::CANNOT_EXECUTE_MOVE, MotorAddress::ALL));
        let checked = checked.and_then(|plan| able(&plan, drives).map(|()| plan));
        checked.map_err(|(code, motor)| turn.answer_error(code, motor)).ok()
    }

    /// Makes the move ready.
    pub(super) fn setup(&mut self, turn: &mut Turn<'_>, drives: &Drives, way: Direction, delay_return: bool) {
        let Some(plan) = self.playable(turn, drives) else { return };
        if way == Direction::Reverse && plan.shots().is_some() {
            turn.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
        } else if delay_return {
            self.stage = Stage::Ready { home: None };
            self.say(turn, drives, PlaybackState::SETUP_COMPLETED);
        } else {
            self.go_home(turn, drives, &plan, Next::Setup { start: false }, way);
        }
    }

    /// Goes to where the move begins, and that is all.
    pub(super) fn rapid(&mut self, turn: &mut Turn<'_>, drives: &Drives) {
        let ready = self.state() == State::Ready;
        if let Some(plan) = self.playable(turn, drives) {
            self.go_home(turn, drives, &plan, Next::Rapid { ready }, Direction::Forward);
        }
    }

    /// Plays the move.
    pub(super) fn start(&mut self, turn: &mut Turn<'_>, drives: &Drives, way: Direction) {
        // Once, while it is made ready for the same way, it is remembered.
        if let Stage::Homing { next: Next::Setup { start }, way: setup, .. } = &mut self.stage {
            let late = self.plan.is_none_or(|plan| begins(&plan, turn).is_err());
            if *start || *setup != way {
                turn.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
            } else if late {
                turn.refuse(ErrorCode::INVALID_MOVE_TIME);
            } else {
                *start = true;
            }
            return;
        }
        let Some(plan) = self.playable(turn, drives) else { return };
        if way == Direction::Reverse && plan.shots().is_some() {
            turn.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
        } else if begins(&plan, turn).is_err() {
            turn.refuse(ErrorCode::INVALID_MOVE_TIME);
        } else if self.stage == (Stage::Ready { home: Some(way) }) {
            self.gate(turn, drives, &plan, way);
        } else {
            self.go_home(turn, drives, &plan, Next::Start, way);
        }
    }

    fn go_home(&mut self, turn: &mut Turn<'_>, drives: &Drives, plan: &MoveSummary, next: Next, way: Direction) {
        let limit = turn.travel_limit();
        self.stage = Stage::Homing { next, way, waiting: plan.motors, limit };
        turn.output.event(Event::Home { way, speed: plan.return_to_home_percent, motors: plan.motors });
        self.is_home(turn, drives);
    }

    /// What follows when the last motor is home.
    fn is_home(&mut self, turn: &mut Turn<'_>, drives: &Drives) {
        let Stage::Homing { next, way, waiting: MotorSet::NONE, .. } = self.stage else { return };
        let Some(plan) = self.plan else { return };
        self.say(turn, drives, PlaybackState::MOTORS_HOME);
        self.stage = match next {
            Next::Rapid { ready: false } => Stage::Loaded,
            Next::Rapid { ready: true } | Next::Setup { .. } | Next::Start => Stage::Ready { home: Some(way) },
        };
        if let Next::Setup { .. } = next {
            self.say(turn, drives, PlaybackState::SETUP_COMPLETED);
        }
        if let Next::Start | Next::Setup { start: true } = next {
            self.gate(turn, drives, &plan, way);
        }
    }

    /// All is ready: the move begins, or its time is waited for.
    fn gate(&mut self, turn: &mut Turn<'_>, drives: &Drives, plan: &MoveSummary, way: Direction) {
        match begins(plan, turn) {
            Err(()) => {
                turn.tell_error(ErrorCode::INVALID_MOVE_TIME, MotorAddress::ALL);
                turn.output.event(Event::StopAll);
                self.full_stop(turn, drives);
            }
            Ok(Some(until)) => {
                self.stage = Stage::Delay { until, way };
                self.say(turn, drives, PlaybackState::DELAY_TIMER_STARTED);
            }
            Ok(None) => self.begin(turn, drives, plan, way),
        }
    }

    fn begin(&mut self, turn: &mut Turn<'_>, drives: &Drives, plan: &MoveSummary, way: Direction) {
        match plan.kind {
            Kind::Live { duration, .. } => self.leg(turn, drives, way, false, duration),
            Kind::Continuous(_) | Kind::ShootMoveShoot(_) => lapse::begin(self, turn, drives, plan),
        }
    }

    fn leg(&mut self, turn: &mut Turn<'_>, drives: &Drives, way: Direction, back: bool, duration: u64) {
        let (from, until) = (turn.now, turn.now.after(duration));
        let progress = turn.options.progress_every.map(|every| from.after(every));
        self.stage = Stage::Leg(Leg { way, back, from, until, progress });
        turn.output.event(Event::Play { way, millis: duration });
        self.say(turn, drives, running(way));
    }

    /// The end of a way: it goes back, or again, or all is over.
    fn leg_over(&mut self, turn: &mut Turn<'_>, drives: &Drives, leg: Leg) {
        self.say(turn, drives, PlaybackState::END_OF_MOVE);
        let Some(Kind::Live { duration, loops }) = self.plan.map(|plan| plan.kind) else { return };
        if leg.back {
            let endless = loops.is_some_and(|loops| loops.count == LoopCount::FOREVER);
            self.loops = if endless { 0 } else { self.loops.saturating_add(1) };
            return self.leg(turn, drives, leg.way.back(), false, duration);
        }
        match loops {
            Some(Loops { duration, count }) if self.loops < count.0 => {
                self.leg(turn, drives, leg.way.back(), true, duration);
            }
            _ => self.done(turn, drives),
        }
    }

    pub(super) fn lapse(&mut self, lapse: Lapse) {
        self.stage = Stage::Lapse(lapse);
    }

    /// The move is over.
    pub(super) fn done(&mut self, turn: &mut Turn<'_>, drives: &Drives) {
        turn.output.event(Event::MoveOver);
        self.full_stop(turn, drives);
    }

    /// Says that all is over, and forgets the move (decision K-J14).
    pub(super) fn full_stop(&mut self, turn: &mut Turn<'_>, drives: &Drives) {
        self.say(turn, drives, PlaybackState::FULL_STOP);
        *self = Self { status: PlaybackState::FULL_STOP, ..Self::default() };
    }

    /// A motor is where it was sent.
    pub(super) fn arrived(&mut self, turn: &mut Turn<'_>, drives: &Drives, motor: MotorAddress) {
        match &mut self.stage {
            Stage::Homing { waiting, .. } => {
                waiting.remove(motor);
                self.is_home(turn, drives);
            }
            Stage::Lapse(Lapse::Moving { waiting, .. }) => {
                waiting.remove(motor);
                let waiting = *waiting;
                lapse::arrived(self, turn, drives, waiting);
            }
            _ => {}
        }
    }

    /// Those that move in the move, and have to come to rest when it is stopped.
    pub(super) fn travelling(&self) -> MotorSet {
        match self.stage {
            Stage::Homing { waiting, .. } | Stage::Lapse(Lapse::Moving { waiting, .. }) => waiting,
            Stage::Leg(_) | Stage::Lapse(Lapse::Continuous(_)) => self.plan.map_or(MotorSet::NONE, |plan| plan.motors),
            _ => MotorSet::NONE,
        }
    }

    pub(super) const fn is_homing(&self) -> bool {
        matches!(self.stage, Stage::Homing { .. })
    }

    /// A motor was moved by hand, or its range changed: it may not be where the move begins any more.
    pub(super) fn disturb(&mut self) {
        if let Stage::Ready { home } = &mut self.stage {
            *home = None;
        }
    }

    /// Deals with a deadline that has come. `Err` with what went wrong, if motors did not get where they should.
    pub(super) fn wake(&mut self, turn: &mut Turn<'_>, drives: &Drives) -> Result<(), ErrorCode> {
        if self.deadline().is_none_or(|deadline| deadline > turn.now) {
            return Ok(());
        }
        match self.stage {
            Stage::Empty | Stage::Loaded | Stage::Ready { .. } => {}
            Stage::Homing { .. } => return Err(ErrorCode::RETURN_TO_FIRST_KEYFRAME),
            Stage::Delay { way, .. } => {
                if let Some(plan) = self.plan {
                    self.begin(turn, drives, &plan, way);
                }
            }
            Stage::Leg(leg) if leg.until <= turn.now => self.leg_over(turn, drives, leg),
            Stage::Leg(leg) => {
                let progress = turn.options.progress_every.map(|every| turn.now.after(every));
                self.stage = Stage::Leg(Leg { progress, ..leg });
                self.say(turn, drives, running(leg.way));
            }
            Stage::Lapse(lapse) => return lapse::wake(self, turn, drives, lapse),
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

/// When a move begins that is started now: `None` is at once. An error, if that is over, or there is no clock (safety
/// decision 5).
fn begins(plan: &MoveSummary, turn: &Turn<'_>) -> Result<Option<Millis>, ()> {
    match plan.wait {
        Wait::None => Ok(None),
        Wait::For(millis) => Ok(Some(turn.now.after(millis.max(1)))),
        Wait::Until(unix) => {
            let epoch = turn.options.unix_millis_at_zero.ok_or(())?;
            let moment = Millis(u64::from(unix).saturating_mul(1000).saturating_sub(epoch));
            if moment > turn.now { Ok(Some(moment)) } else { Err(()) }
        }
    }
}

/// Whether all motors of a move are there, know their ranges, and rest (decision K-J14).
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
