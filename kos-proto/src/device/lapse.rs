//! Photos of a time lapse: before, in and after the move (kOS 7.5).

use motion_core::time::Millis;

use super::effects::Effects;
use super::event::Event;
use super::playback::{Playback, Rig};
use super::stage::{Lapse, Shot};
use crate::message::{Direction, ErrorCode, MotorSet, PlaybackState};
use crate::move_summary::{Kind, MoveSummary, Shots};

impl<const MOVES: bool> Playback<MOVES> {
    /// The time lapse begins: with photos before the move, or with the move.
    pub(super) fn begin_lapse(&mut self, now: Millis, output: &mut Effects<'_, '_>, rig: Rig<'_>, plan: &MoveSummary) {
        let Some(shots) = plan.shots() else { return };
        if shots.before == 0 {
            return self.begin_shots(now, output, rig, shots);
        }
        self.set_lapse(Lapse::Before { shot: Shot::wait(now, now, shots), taken: 0 });
        self.set_status(now, output, rig, PlaybackState::PRE_MOVE_PHOTOS_STARTED);
    }

    /// The move begins.
    fn begin_shots(&mut self, now: Millis, output: &mut Effects<'_, '_>, rig: Rig<'_>, shots: Shots) {
        let shot = Shot::wait(now, now, shots);
        if let Some(Kind::Continuous(_)) = self.plan().map(|plan| plan.kind) {
            let millis = shots.interval().saturating_mul(shots.moving.into());
            self.set_lapse(Lapse::Continuous(shot));
            output.event(Event::Play { way: Direction::Forward, millis });
            self.set_status(now, output, rig, PlaybackState::START_FORWARD);
        } else {
            self.set_lapse(Lapse::Frame(shot));
            self.set_status(now, output, rig, PlaybackState::START_FORWARD);
            self.set_status(now, output, rig, PlaybackState::START_FRAME);
        }
    }

    /// All motors are at the next place, if none is waited for.
    pub(super) fn frame_reached(&mut self, now: Millis, output: &mut Effects<'_, '_>, rig: Rig<'_>, waiting: MotorSet) {
        let Some(shots) = self.plan().and_then(MoveSummary::shots).filter(|_| waiting.is_empty()) else { return };
        self.set_status(now, output, rig, PlaybackState::SMS_MOTORS_STOPPED);
        self.set_lapse(Lapse::Frame(Shot::wait(now, now, shots)));
        self.set_status(now, output, rig, PlaybackState::START_FRAME);
    }

    /// Deals with a deadline that has come.
    pub(super) fn wake_lapse(
        &mut self,
        now: Millis,
        output: &mut Effects<'_, '_>,
        rig: Rig<'_>,
        mut lapse: Lapse,
    ) -> Result<(), ErrorCode> {
        let Some(shots) = self.plan().and_then(MoveSummary::shots) else { return Ok(()) };
        let Some(shot) = lapse.shot_mut() else { return Err(ErrorCode::CANNOT_EXECUTE_MOVE) };
        if let Some(open) = shot.open(now, output, shots) {
            *shot = open;
            self.set_lapse(lapse);
        } else {
            let next = Shot::wait(now, shot.planned, shots);
            self.taken(now, output, rig, shots, (lapse, next));
        }
        Ok(())
    }

    /// A photo is taken: the next one, the next place, or the next part of the time lapse follows.
    fn taken(
        &mut self,
        now: Millis,
        output: &mut Effects<'_, '_>,
        rig: Rig<'_>,
        shots: Shots,
        (lapse, next): (Lapse, Shot),
    ) {
        match lapse {
            Lapse::Before { taken, .. } => match taken.saturating_add(1) {
                taken if taken < shots.before => self.set_lapse(Lapse::Before { shot: next, taken }),
                _ => self.begin_shots(now, output, rig, shots),
            },
            Lapse::After { taken, .. } => match taken.saturating_add(1) {
                taken if taken < shots.after => self.set_lapse(Lapse::After { shot: next, taken }),
                _ => {
                    self.set_status(now, output, rig, PlaybackState::POST_MOVE_PHOTOS_COMPLETED);
                    self.done(now, output, rig);
                }
            },
            Lapse::Continuous(_) | Lapse::Frame(_) | Lapse::Moving { .. } => {
                self.photos = self.photos.saturating_add(1);
                if self.photos >= shots.moving {
                    self.end_shots(now, output, rig, shots);
                } else if let Lapse::Continuous(_) = lapse {
                    self.set_lapse(Lapse::Continuous(next));
                    self.set_status(now, output, rig, PlaybackState::START_FORWARD);
                } else {
                    let waiting = self.plan().map_or(MotorSet::NONE, |plan| plan.motors);
                    self.set_lapse(Lapse::Moving { waiting, limit: rig.travel_limit(now) });
                    let (frame, last) = (self.photos, shots.moving.saturating_sub(1));
                    output.event(Event::MoveToFrame { frame, last });
                }
            }
        }
    }

    /// The move is at its end: photos after it follow, or all is over.
    fn end_shots(&mut self, now: Millis, output: &mut Effects<'_, '_>, rig: Rig<'_>, shots: Shots) {
        self.set_status(now, output, rig, PlaybackState::END_OF_MOVE);
        if shots.after == 0 {
            return self.done(now, output, rig);
        }
        self.set_lapse(Lapse::After { shot: Shot::wait(now, now, shots), taken: 0 });
    }
}
