//! Motion of single motors and of virtual ones: DMC D2 and D4.

use motion_core::time::Millis;

use super::event::Event;
use super::machine::{Answer, DeviceMachine, Request, allowed};
use super::motion::Motion;
use super::options::Quirks;
use super::transmit::{Output, Transmit};
use crate::message::{AckCode, HostMessage, Motors, RigKind, VirtConfig};

impl DeviceMachine {
    /// Moves or jogs one motor.
    pub(super) fn move_motor(&mut self, output: &mut Output<'_>, request: &Request<'_>) -> Answer {
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
            Motion::ToFrame(_) | Motion::Ready(_) if self.has(Quirks::CUTS_IN) => {}
            _ => return Err(AckCode::ERR_MOVING),
        }
        allowed(request.rig)?;
        let is_move = matches!(request.message, HostMessage::MotorMove(_));
        let ends_run = is_move && matches!(self.motion, Motion::Running(_)) && self.has(Quirks::MOVE_ENDS_RUN);
        if ends_run {
            output.event(Event::TriggersOff);
        }
        if !is_live || ends_run {
            self.on_frame = None;
        }
        if self.motion == Motion::Idle || !is_live || ends_run {
            self.motion = Motion::Moving;
        }
        self.moving.0 |= Motors::from_iter([motor]).0;
        output.event(event);
        Ok(())
    }

    /// Gives the place where a motor stands another number. Then the motor is on no frame any more (decision D-57).
    pub(super) fn reset<'a>(&mut self, now: Millis, output: &mut Output<'a>, request: &Request<'a>) -> Answer {
        self.at_rest()?;
        allowed(request.rig)?;
        self.on_frame = None;
        output.event(Event::Apply(request.message));
        if self.has(Quirks::POSITIONS_AFTER_ACK) {
            self.ack(output, request.id, request.kind, AckCode::OK);
            output.transmit(Transmit { id: request.id, contents: self.positions() });
            return Ok(());
        }
        let told_first = self.has(Quirks::RESET_TOLD_FIRST);
        if told_first {
            self.report(now, output);
        }
        self.ack(output, request.id, request.kind, AckCode::OK);
        if !told_first {
            self.report(now, output);
        }
        Ok(())
    }

    /// Configures virtual motors, or none. If the rig refuses, those before stay.
    pub(super) fn configure_virtuals<'a>(
        &mut self,
        output: &mut Output<'a>,
        rig: AckCode,
        config: VirtConfig<'a>,
    ) -> Answer {
        self.at_rest()?;
        allowed(rig)?;
        self.has_virtuals = config.kind() != RigKind::NONE;
        output.event(Event::Apply(config.into()));
        Ok(())
    }

    /// Moves or jogs virtual motors, or aims with them. Only the rig knows which motors follow: until it tells, all of them count as moving.
    pub(super) fn move_virtuals<'a>(&mut self, output: &mut Output<'a>, request: &Request<'a>) -> Answer {
        self.virtuals()?;
        allowed(request.rig)?;
        self.on_frame = None;
        self.motion = Motion::Moving;
        self.moving = self.all_motors();
        output.event(Event::MoveVirtual(request.message));
        Ok(())
    }

    /// Checks that virtual motors are configured and free.
    fn virtuals(&self) -> Answer {
        if !self.has_virtuals {
            return Err(AckCode::ERR_GENERAL);
        }
        match self.motion {
            Motion::Idle | Motion::Moving => Ok(()),
            _ => Err(AckCode::ERR_MOVING),
        }
    }

    /// All motors rest, as the rig says.
    pub(super) fn arrived(&mut self, now: Millis, output: &mut Output<'_>) {
        let frame = match self.motion {
            Motion::Idle | Motion::Ready(_) => return self.moving = Motors::NONE,
            Motion::Running(_) => return output.event(Event::UnexpectedReport),
            Motion::Moving => self.on_frame,
            Motion::Stopping(_) | Motion::Locked(_) | Motion::PreRoll(_) => None,
            Motion::ToFrame(frame) | Motion::JogAll(_, frame) => Some(frame),
            Motion::PostRoll(job) => self.end_of(job),
        };
        self.moving = Motors::NONE;
        self.on_frame = frame;
        match &mut self.motion {
            Motion::PreRoll(job) => self.motion = Motion::Ready(*job),
            Motion::Locked(lock) if lock.is_at_rest => {}
            Motion::Locked(lock) => {
                lock.is_at_rest = true;
                if !lock.is_stop {
                    lock.until = Some(now.after(self.options.hold().into()));
                }
                self.report(now, output);
            }
            _ => {
                self.motion = Motion::Idle;
                self.report(now, output);
            }
        }
    }
}
