//! The photos of a time lapse: before, in and behind the move (kOS 7.5).

use motion_core::time::Millis;

use super::motor::Drives;
use super::playback::{Playback, State};
use super::{Event, Turn};
use crate::message::{ErrorCode, PlaybackState};
use crate::summary::{Direction, Kind, MotorSet, MoveSummary, Shots};

/// How far a time lapse is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Lapse {
    /// Photos before the move; so many are taken.
    Before { shot: Shot, taken: u32 },
    /// Photos while the motors move.
    Continuous(Shot),
    /// A photo while the motors rest.
    Frame(Shot),
    /// The motors go to the next place.
    Moving { waiting: MotorSet, limit: Option<Millis> },
    /// Photos behind the move; so many are taken.
    After { shot: Shot, taken: u32 },
}

/// A photo: first it waits, then the shutter is open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Shot {
    exposing: bool,
    until: Millis,
    /// When it should be over: a wake that is late shortens no photo, and does not change the rhythm.
    planned: Millis,
}

impl Shot {
    fn wait(from: Millis, shots: Shots, now: Millis) -> Self {
        let planned = from.after(shots.delay);
        Self { exposing: false, until: planned.max(now.after(1)), planned }
    }

    /// Opens the shutter; `None` if it was open long enough.
    fn open(self, turn: &mut Turn<'_>, shots: Shots) -> Option<Self> {
        if self.exposing {
            return None;
        }
        turn.output.event(Event::OpenShutter { millis: shots.exposure });
        let until = turn.now.after(shots.exposure.max(1));
        Some(Self { exposing: true, until, planned: self.planned.after(shots.exposure) })
    }
}

impl Lapse {
    pub(super) const fn state(self) -> State {
        match self {
            Self::Before { .. } => State::Pre,
            Self::Continuous(_) => State::ForwardC,
            Self::Frame(Shot { exposing: false, .. }) => State::FrameDelay,
            Self::Frame(Shot { exposing: true, .. }) => State::Exposing,
            Self::Moving { .. } => State::Moving,
            Self::After { .. } => State::Post,
        }
    }

    /// The photo that is being taken; none, while the motors move to the next place.
    fn shot_mut(&mut self) -> Option<&mut Shot> {
        match self {
            Self::Before { shot, .. } | Self::Continuous(shot) | Self::Frame(shot) | Self::After { shot, .. } => {
                Some(shot)
            }
            Self::Moving { .. } => None,
        }
    }

    pub(super) const fn deadline(self) -> Option<Millis> {
        match self {
            Self::Before { shot, .. } | Self::Continuous(shot) | Self::Frame(shot) | Self::After { shot, .. } => {
                Some(shot.until)
            }
            Self::Moving { limit, .. } => limit,
        }
    }
}

/// The time lapse begins: photos before the move, or the move.
pub(super) fn begin(playback: &mut Playback, turn: &mut Turn<'_>, drives: &Drives, plan: &MoveSummary) {
    let Some(shots) = plan.shots() else { return };
    if shots.before == 0 {
        return go(playback, turn, drives, shots);
    }
    playback.lapse(Lapse::Before { shot: Shot::wait(turn.now, shots, turn.now), taken: 0 });
    playback.say(turn, drives, PlaybackState::PRE_MOVE_PHOTOS_STARTED);
}

/// The move begins.
fn go(playback: &mut Playback, turn: &mut Turn<'_>, drives: &Drives, shots: Shots) {
    let shot = Shot::wait(turn.now, shots, turn.now);
    if let Some(Kind::Continuous(_)) = playback.plan().map(|plan| plan.kind) {
        let millis = shots.interval().saturating_mul(shots.moving.into());
        playback.lapse(Lapse::Continuous(shot));
        turn.output.event(Event::Play { way: Direction::Forward, millis });
        playback.say(turn, drives, PlaybackState::START_FORWARD);
    } else {
        playback.lapse(Lapse::Frame(shot));
        playback.say(turn, drives, PlaybackState::START_FORWARD);
        playback.say(turn, drives, PlaybackState::START_FRAME);
    }
}

/// All motors are at the next place.
pub(super) fn arrived(playback: &mut Playback, turn: &mut Turn<'_>, drives: &Drives, waiting: MotorSet) {
    let Some(shots) = playback.plan().and_then(MoveSummary::shots).filter(|_| waiting.is_empty()) else { return };
    playback.say(turn, drives, PlaybackState::SMS_MOTORS_STOPPED);
    playback.lapse(Lapse::Frame(Shot::wait(turn.now, shots, turn.now)));
    playback.say(turn, drives, PlaybackState::START_FRAME);
}

/// Deals with a deadline that has come.
pub(super) fn wake(
    playback: &mut Playback,
    turn: &mut Turn<'_>,
    drives: &Drives,
    mut lapse: Lapse,
) -> Result<(), ErrorCode> {
    let Some(shots) = playback.plan().and_then(MoveSummary::shots) else { return Ok(()) };
    let Some(shot) = lapse.shot_mut() else { return Err(ErrorCode::CANNOT_EXECUTE_MOVE) };
    if let Some(open) = shot.open(turn, shots) {
        *shot = open;
        playback.lapse(lapse);
    } else {
        let next = Shot::wait(shot.planned, shots, turn.now);
        taken(playback, turn, drives, shots, lapse, next);
    }
    Ok(())
}

/// A photo is taken: the next one, the next place, or the next part of the time lapse follows.
fn taken(playback: &mut Playback, turn: &mut Turn<'_>, drives: &Drives, shots: Shots, lapse: Lapse, next: Shot) {
    match lapse {
        Lapse::Before { taken, .. } => match taken.saturating_add(1) {
            taken if taken < shots.before => playback.lapse(Lapse::Before { shot: next, taken }),
            _ => go(playback, turn, drives, shots),
        },
        Lapse::After { taken, .. } => match taken.saturating_add(1) {
            taken if taken < shots.after => playback.lapse(Lapse::After { shot: next, taken }),
            _ => {
                playback.say(turn, drives, PlaybackState::POST_MOVE_PHOTOS_COMPLETED);
                playback.done(turn, drives);
            }
        },
        Lapse::Continuous(_) | Lapse::Frame(_) | Lapse::Moving { .. } => {
            playback.photos = playback.photos.saturating_add(1);
            if playback.photos >= shots.moving {
                end(playback, turn, drives, shots);
            } else if let Lapse::Continuous(_) = lapse {
                playback.lapse(Lapse::Continuous(next));
                playback.say(turn, drives, PlaybackState::START_FORWARD);
            } else {
                let waiting = playback.plan().map_or(MotorSet::NONE, |plan| plan.motors);
                playback.lapse(Lapse::Moving { waiting, limit: turn.travel_limit() });
                let (frame, last) = (playback.photos, shots.moving.saturating_sub(1));
                turn.output.event(Event::MoveToFrame { frame, last });
            }
        }
    }
}

/// The move is at its end: photos behind it, or all is over.
fn end(playback: &mut Playback, turn: &mut Turn<'_>, drives: &Drives, shots: Shots) {
    playback.say(turn, drives, PlaybackState::END_OF_MOVE);
    if shots.after == 0 {
        return playback.done(turn, drives);
    }
    playback.lapse(Lapse::After { shot: Shot::wait(turn.now, shots, turn.now), taken: 0 });
}
