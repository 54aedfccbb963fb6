//! Motion of all motors along the uploaded move: to a frame, jogs, runs, shots. DMC D3.

use motion_core::time::Millis;

use super::event::Event;
use super::machine::{Answer, DeviceMachine, allowed};
use super::motion::{Job, JobKind, Motion};
use super::options::Quirks;
use super::transmit::{Contents, Output};
use crate::message::{AckCode, FrameNumber, HostMessage, MotorPair, Motors, RtJogAll, RtRunMove, RunFlags};

impl DeviceMachine {
    /// Goes to a frame, instead of what moves now, except out of a run or a stop.
    pub(super) fn go_to_frame(&mut self, output: &mut Output<'_>, rig: AckCode, frame: FrameNumber) -> Answer {
        let is_after = matches!(self.motion, Motion::PostRoll(_)) && self.has(Quirks::BUSY_AFTER_RUN);
        if is_after || matches!(self.motion, Motion::Running(_) | Motion::Stopping(_)) {
            return Err(AckCode::ERR_MOVING);
        }
        let frame = if self.has(Quirks::CLAMPS_FRAMES) { self.upload.nearest(frame) } else { frame };
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

    /// Frame on which the motors rest after a run or shot.
    pub(super) fn end_of(&self, job: Job) -> Option<FrameNumber> {
        match job.kind {
            JobKind::Shot if self.has(Quirks::STAYS_AFTER_SHOT) => None,
            JobKind::Shot => Some(job.to),
            _ if self.has(Quirks::RESTS_BEYOND) => Some(self.upload.nearest(FrameNumber(job.to.0.saturating_add(1)))),
            _ => Some(job.to),
        }
    }

    pub(super) fn jog_all(&mut self, output: &mut Output<'_>, rig: AckCode, message: &RtJogAll<'_>) -> Answer {
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

    pub(super) fn run_move<'a>(&mut self, output: &mut Output<'a>, rig: AckCode, message: RtRunMove<'a>) -> Answer {
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
        let (from, to, message) = (message.start_frame, message.end_frame, HostMessage::from(message));
        self.prepare(output, message, kind, (from, to), self.upload.axes());
        Ok(())
    }

    /// Prepares a shot of a frame with motors of its own. Without these it needs an uploaded move (decision D-58).
    pub(super) fn shoot<'a>(
        &mut self,
        output: &mut Output<'a>,
        rig: AckCode,
        message: HostMessage<'a>,
        frame: FrameNumber,
        motors: &[MotorPair],
    ) -> Answer {
        if self.has(Quirks::FEW_CHECKS) {
            self.upload.reach(frame).map_err(|_| AckCode::ERR_RANGE)?;
        }
        self.at_rest()?;
        if self.upload.loaded().is_some() || motors.is_empty() {
            self.upload.reach(frame)?;
        }
        allowed(rig)?;
        let own: Motors = motors.iter().map(MotorPair::motor).collect();
        let axes = Motors(own.0 | self.upload.axes().0);
        self.prepare(output, message, JobKind::Shot, (frame, frame), axes);
        Ok(())
    }

    fn prepare<'a>(
        &mut self,
        output: &mut Output<'a>,
        message: HostMessage<'a>,
        kind: JobKind,
        (from, to): (FrameNumber, FrameNumber),
        axes: Motors,
    ) {
        output.event(Event::Prepare(message));
        self.on_frame = None;
        self.motion = Motion::PreRoll(Job { kind, from, to, at: from, axes, opens_shutter: message.opens_shutter() });
        self.moving.0 |= axes.0;
    }

    /// Starts, because the host or the operator gives the signal.
    pub(super) fn go(&mut self, output: &mut Output<'_>) -> Answer {
        let Motion::Ready(job) = self.motion else { return Err(AckCode::ERR_NOT_IN_POSITION) };
        output.event(Event::Go);
        self.motion = Motion::Running(job);
        self.moving.0 |= job.axes.0;
        self.is_shutter_open |= job.opens_shutter;
        Ok(())
    }

    /// Makes the pass that runs, or will run, the last one.
    pub(super) fn stop_loop(&mut self, output: &mut Output<'_>) {
        let (Motion::PreRoll(job) | Motion::Ready(job) | Motion::Running(job)) = &mut self.motion else { return };
        if job.next().is_some() {
            *job = job.last();
            output.event(Event::LastPass);
        }
    }

    /// The rig has come to a frame.
    pub(super) fn at_frame(&mut self, now: Millis, output: &mut Output<'_>, frame: FrameNumber) {
        match &mut self.motion {
            Motion::Running(job) => job.at = frame,
            Motion::JogAll(at, _) => *at = frame,
            _ => return output.event(Event::UnexpectedReport),
        }
        self.report(now, output);
    }

    /// The rig has come to the end of a pass, or has made a shot.
    pub(super) fn pass_end(&mut self, output: &mut Output<'_>) {
        let Motion::Running(job) = self.motion else { return output.event(Event::UnexpectedReport) };
        if let Some(next) = job.next() {
            output.event(Event::NextPass(next.from, next.to));
            if self.has(Quirks::END_PER_PASS) {
                Self::tell(output, Contents::End);
            }
            self.motion = Motion::Running(next);
            return;
        }
        let job = Job { at: job.to, ..job };
        output.event(Event::TriggersOff);
        output.event(Event::PostRoll);
        self.motion = Motion::PostRoll(job);
        self.is_shutter_open &= !job.opens_shutter;
        Self::tell(output, self.positions());
        if job.kind != JobKind::Shot || !self.has(Quirks::NO_END_OF_SHOT) {
            Self::tell(output, Contents::End);
        }
    }
}
