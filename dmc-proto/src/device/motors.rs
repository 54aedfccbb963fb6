//! Motors each for themselves, and virtual ones: DMC D2 and D4.

use motion_core::time::Millis;

use super::io::{Event, Output};
use super::machine::{Answer, DeviceMachine, Request, allowed};
use super::motion::Motion;
use super::options::Quirks;
use crate::message::{AckCode, HostMessage, Motors, RigKind, VirtConfig};

impl DeviceMachine {
    /// A move or a jog of one motor.
    pub(super) fn move_motor(&mut self, request: &Request<'_>, output: &mut Output) -> Answer {
        let (motor, event) = match request.message {
            HostMessage::MotorMove(message) => (message.motor, Event::Move(message.motor, message.position)),
            HostMessage::MotorJog(message) => {
                (message.motor, Event::Jog(message.motor, message.speed, message.destination))
            }
            _ => return Err(AckCode::ERR_UNSUPPORTED),
        };
        let is_live = self.live.contains(motor);
        match self.motion {
            Motion::Idle | Motion::Moving => {}
            Motion::Stopping(_) | Motion::Locked(_) => return Err(AckCode::ERR_MOVING),
            _ if is_live => {}
            _ => return Err(AckCode::ERR_MOVING),
        }
        allowed(request.rig)?;
        if !is_live {
            self.on_frame = None;
        }
        if self.motion == Motion::Idle {
            self.motion = Motion::Moving;
        }
        self.moving.0 |= Motors::from_iter([motor]).0;
        output.event(event);
        Ok(())
    }

    /// Another number for where a motor stands: then it is on no frame any more (decision D-57).
    pub(super) fn reset(&mut self, now: Millis, request: &Request<'_>, output: &mut Output) -> Answer {
        self.at_rest()?;
        allowed(request.rig)?;
        self.on_frame = None;
        output.event(Event::Apply);
        let told_first = self.has(Quirks::RESET_TOLD_FIRST);
        if told_first {
            self.report(now, output);
        }
        self.ack(request.id, request.message.kind(), AckCode::OK, output);
        if !told_first {
            self.report(now, output);
        }
        Ok(())
    }

    /// Virtual motors, or none any more. What the rig refuses, leaves those that there were.
    pub(super) fn configure_virtuals(&mut self, config: &VirtConfig<'_>, rig: AckCode, output: &mut Output) -> Answer {
        self.at_rest()?;
        allowed(rig)?;
        self.has_virtuals = config.kind() != RigKind::NONE;
        output.event(Event::Apply);
        Ok(())
    }

    /// A move or jog of virtual motors. Which motors follow, only the rig knows: until it tells, all of them count as
    /// moving.
    pub(super) fn move_virtuals(&mut self, rig: AckCode, output: &mut Output) -> Answer {
        self.virtuals()?;
        allowed(rig)?;
        self.on_frame = None;
        self.motion = Motion::Moving;
        self.moving = self.all_motors();
        output.event(Event::MoveVirtual);
        Ok(())
    }

    /// Another point to aim at.
    pub(super) fn aim(&mut self, rig: AckCode, output: &mut Output) -> Answer {
        self.virtuals()?;
        allowed(rig)?;
        output.event(Event::Apply);
        Ok(())
    }

    /// Whether virtual motors are there, and free.
    fn virtuals(&self) -> Answer {
        if !self.has_virtuals {
            return Err(AckCode::ERR_GENERAL);
        }
        match self.motion {
            Motion::Idle | Motion::Moving => Ok(()),
            _ => Err(AckCode::ERR_MOVING),
        }
    }

    /// All motors stand, as the rig says.
    pub(super) fn arrived(&mut self, now: Millis, output: &mut Output) {
        let frame = match self.motion {
            Motion::Idle | Motion::Ready(_) => return self.moving = Motors::NONE,
            Motion::Running(_) => return output.event(Event::Stray),
            Motion::Moving => self.on_frame,
            Motion::Stopping(_) | Motion::Locked(_) | Motion::PreRoll(_) => None,
            Motion::ToFrame(frame) | Motion::JogAll(_, frame) => Some(frame),
            Motion::PostRoll(job) => Some(job.to),
        };
        self.moving = Motors::NONE;
        self.on_frame = frame;
        match &mut self.motion {
            Motion::PreRoll(job) => self.motion = Motion::Ready(*job),
            Motion::Locked(lock) if lock.is_at_rest => {}
            Motion::Locked(lock) => {
                lock.is_at_rest = true;
                lock.until = Some(now.after(self.options.hold.into()));
                self.report(now, output);
            }
            _ => {
                self.motion = Motion::Idle;
                self.report(now, output);
            }
        }
    }
}
