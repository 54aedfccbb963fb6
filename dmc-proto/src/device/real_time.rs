//! All motors along the uploaded move: to a frame, jogs, runs, shots. DMC D3.

use motion_core::time::Millis;

use super::io::{Event, Output, What};
use super::machine::{Answer, DeviceMachine, allowed};
use super::motion::{Job, JobKind, Motion};
use super::options::Quirks;
use crate::message::{AckCode, FrameNumber, MotorPair, Motors, RtJogAll, RtRunMove, RunFlags};

impl DeviceMachine {
    /// To a frame, instead of whatever moves; but not out of a run, nor out of a stop.
    pub(super) fn go_to_frame(&mut self, frame: FrameNumber, rig: AckCode, output: &mut Output) -> Answer {
        if matches!(self.motion, Motion::Running(_) | Motion::Stopping(_)) {
            return Err(AckCode::ERR_MOVING);
        }
        self.upload.reach(frame)?;
        allowed(rig)?;
        if self.motion.job().is_some() {
            output.event(Event::TriggersOff);
        }
        output.event(Event::ToFrame(frame));
        self.on_frame = None;
        self.motion = Motion::ToFrame(frame);
        self.moving.0 |= self.upload.axes().0;
        Ok(())
    }

    pub(super) fn jog_all(&mut self, message: &RtJogAll<'_>, rig: AckCode, output: &mut Output) -> Answer {
        let at = match self.motion {
            Motion::Idle => self.on_frame.ok_or(AckCode::ERR_NOT_IN_POSITION)?,
            Motion::JogAll(at, _) => at,
            _ => return Err(AckCode::ERR_MOVING),
        };
        self.upload.reach(message.destination)?;
        allowed(rig)?;
        output.event(Event::JogAll(message.fps_x1000, message.destination));
        self.on_frame = None;
        self.motion = Motion::JogAll(at, message.destination);
        self.moving.0 |= self.upload.axes().0;
        Ok(())
    }

    pub(super) fn run(&mut self, message: &RtRunMove<'_>, rig: AckCode, output: &mut Output) -> Answer {
        self.at_rest()?;
        self.on_frame.ok_or(AckCode::ERR_NOT_IN_POSITION)?;
        self.upload.reach(message.start_frame)?;
        self.upload.reach(message.end_frame)?;
        allowed(rig)?;
        let flags = message.flags.unwrap_or_default();
        let kind = if flags.contains(RunFlags::PING_PONG) {
            JobKind::PingPong
        } else if flags.contains(RunFlags::LOOP) {
            JobKind::Loop
        } else {
            JobKind::Once
        };
        self.prepare(kind, message.start_frame, message.end_frame, self.upload.axes(), output);
        Ok(())
    }

    /// A shot. Without an uploaded move it can be made with motors of its own only (decision D-58).
    pub(super) fn shoot(
        &mut self,
        frame: FrameNumber,
        motors: &[MotorPair],
        rig: AckCode,
        output: &mut Output,
    ) -> Answer {
        self.at_rest()?;
        if self.upload.loaded().is_some() || motors.is_empty() {
            self.upload.reach(frame)?;
        }
        allowed(rig)?;
        let own: Motors = motors.iter().map(MotorPair::motor).collect();
        let axes = Motors(own.0 | self.upload.axes().0);
        self.prepare(JobKind::Shot, frame, frame, axes, output);
        Ok(())
    }

    fn prepare(&mut self, kind: JobKind, from: FrameNumber, to: FrameNumber, axes: Motors, output: &mut Output) {
        output.event(Event::Prepare);
        self.on_frame = None;
        self.motion = Motion::PreRoll(Job { kind, from, to, at: from, axes });
        self.moving.0 |= axes.0;
    }

    /// The signal to start, from whoever gives it.
    pub(super) fn go(&mut self, output: &mut Output) -> Answer {
        let Motion::Ready(job) = self.motion else { return Err(AckCode::ERR_NOT_IN_POSITION) };
        output.event(Event::Go);
        self.motion = Motion::Running(job);
        self.moving.0 |= job.axes.0;
        Ok(())
    }

    /// The pass that runs, or will run, is the last one.
    pub(super) fn stop_loop(&mut self, output: &mut Output) {
        let (Motion::PreRoll(job) | Motion::Ready(job) | Motion::Running(job)) = &mut self.motion else { return };
        if job.next().is_some() {
            *job = job.last();
            output.event(Event::LastPass);
        }
    }

    /// The rig has come to a frame.
    pub(super) fn passed(&mut self, now: Millis, frame: FrameNumber, output: &mut Output) {
        match &mut self.motion {
            Motion::Running(job) => job.at = frame,
            Motion::JogAll(at, _) => *at = frame,
            _ => return output.event(Event::Stray),
        }
        self.report(now, output);
    }

    /// The rig has come to the end of a pass, or has made a shot.
    pub(super) fn pass_end(&mut self, output: &mut Output) {
        let Motion::Running(job) = self.motion else { return output.event(Event::Stray) };
        if let Some(next) = job.next() {
            if self.has(Quirks::END_PER_PASS) {
                Self::tell(What::End, output);
            }
            output.event(Event::NextPass(next.from, next.to));
            self.motion = Motion::Running(next);
            return;
        }
        let job = Job { at: job.to, ..job };
        output.event(Event::TriggersOff);
        output.event(Event::PostRoll);
        self.motion = Motion::PostRoll(job);
        Self::tell(self.positions(), output);
        if job.kind != JobKind::Shot || !self.has(Quirks::NO_END_OF_SHOT) {
            Self::tell(What::End, output);
        }
    }
}
