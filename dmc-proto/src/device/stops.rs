//! Stops, those that are asked for and hard ones: safety decisions 1, 4 and 6, DMC D2. A stop stands before all else.

use motion_core::time::Millis;

use super::event::{Event, StopKind};
use super::machine::{Answer, DeviceMachine};
use super::motion::{Lock, Motion};
use super::options::Quirks;
use super::transmit::{Contents, Output};
use crate::message::{AckCode, HostMessage, Motor, Motors, StopFlags, StopReason};

impl DeviceMachine {
    /// Obeys a stop in any state. Only a motor that is not there cannot be stopped.
    pub(super) fn stop(&mut self, now: Millis, output: &mut Output<'_>, message: &HostMessage<'_>) -> Answer {
        if self.has(Quirks::STOP_LOCKS) && matches!(self.motion, Motion::Locked(_)) {
            return Err(AckCode::ERR_HARD_LOW);
        }
        match message {
            HostMessage::MotorStop(message) => {
                if !self.all_motors().contains(message.motor) {
                    return Err(AckCode::ERR_RANGE);
                }
                // A motor outside the uploaded move can only be one that is driven by hand.
                let axes = self.motion.coordinated(self.upload.axes()).unwrap_or_default();
                let is_part = axes.contains(message.motor);
                let is_run = self.motion.job().is_some() || matches!(self.motion, Motion::JogAll(..));
                if is_part && self.has(Quirks::STOP_OF_ONE_IGNORED) {
                    if !is_run && self.moving.contains(message.motor) {
                        // The other motors go on.
                        self.motion = Motion::Moving;
                        self.stop_one(now, output, StopKind::Motor(message.motor), false);
                    }
                    return Ok(());
                }
                self.stop_one(now, output, StopKind::Motor(message.motor), is_part);
            }
            HostMessage::VirtStop(message) => {
                let is_part = self.motion.coordinated(Motors::NONE).is_some();
                self.stop_one(now, output, StopKind::Virtual(message.virtual_motor), is_part);
            }
            HostMessage::MotorStopAll(message) => {
                let flags = message.flags.unwrap_or_default();
                let silent = flags.contains(StopFlags::SILENT) || (!flags.is_empty() && self.has(Quirks::STOP_LOCKS));
                self.stop_all(now, output, silent);
            }
            _ => {}
        }
        Ok(())
    }

    /// Stops one motor. As part of a coordinated move, it stops all of that.
    fn stop_one(&mut self, now: Millis, output: &mut Output<'_>, stop: StopKind, is_part: bool) {
        self.on_frame = None;
        if is_part {
            self.stop_all(now, output, false);
        } else {
            output.event(Event::Stop(stop));
        }
    }

    pub(super) fn stop_all(&mut self, now: Millis, output: &mut Output<'_>, silent: bool) {
        let harder_until = Some(now.after(self.options.harder_within().into()));
        let stop = match self.motion {
            Motion::Stopping(Some(until)) if until > now => StopKind::Harder,
            _ => StopKind::All { silent },
        };
        output.event(Event::Stop(stop));
        self.is_shutter_open = false;
        if self.motion.job().is_some() {
            output.event(Event::TriggersOff);
        }
        let locks = self.has(Quirks::STOP_LOCKS) && !silent;
        self.motion = match self.motion {
            Motion::Idle | Motion::Locked(_) => return,
            Motion::Ready(_) | Motion::Stopping(_) => Motion::Stopping(harder_until),
            _ if locks => Motion::Locked(Lock {
                code: AckCode::ERR_HARD_LOW,
                is_pressed: false,
                is_at_rest: false,
                until: Some(now.after(self.options.hold().into())),
                is_stop: true,
            }),
            _ => Motion::Stopping(harder_until),
        };
        self.on_frame = None;
    }

    /// Stops everything, because no stop could come any more (decision D-53).
    pub(super) fn link_down(&mut self, now: Millis, output: &mut Output<'_>) {
        let moves = !matches!(self.motion, Motion::Idle | Motion::Stopping(_) | Motion::Locked(_));
        if moves || self.is_shutter_open {
            self.stop_all(now, output, false);
        }
    }

    pub(super) fn limit(&mut self, output: &mut Output<'_>, motor: Motor, upper: bool) {
        let (reason, code) = if upper {
            (StopReason::UPPER_LIMIT, AckCode::ERR_HARD_UP)
        } else {
            (StopReason::LOWER_LIMIT, AckCode::ERR_HARD_LOW)
        };
        self.hard_stop(output, reason, Some(motor), code, false);
    }

    pub(super) fn fault(&mut self, output: &mut Output<'_>, motor: Option<Motor>) {
        self.hard_stop(output, StopReason::ENGINE_EXCEPTION, motor, AckCode::ERR_GENERAL, false);
    }

    pub(super) fn emergency_stop(&mut self, output: &mut Output<'_>, pressed: bool) {
        if pressed {
            self.hard_stop(output, StopReason::EMERGENCY_STOP, None, AckCode::ERR_GENERAL, true);
        } else if let Motion::Locked(lock) = &mut self.motion {
            lock.is_pressed = false;
        } else {
            output.event(Event::UnexpectedReport);
        }
    }

    fn hard_stop(
        &mut self,
        output: &mut Output<'_>,
        reason: StopReason,
        motor: Option<Motor>,
        code: AckCode,
        pressed: bool,
    ) {
        output.event(Event::Stop(StopKind::Hard));
        self.is_shutter_open = false;
        if self.motion.job().is_some() {
            output.event(Event::TriggersOff);
        }
        let is_pressed = pressed || matches!(self.motion, Motion::Locked(Lock { is_pressed: true, .. }));
        self.motion = Motion::Locked(Lock { code, is_pressed, is_at_rest: false, until: None, is_stop: false });
        self.on_frame = None;
        Self::tell(output, Contents::HardStop(reason, motor));
    }

    /// Ends a lock that is over.
    pub(super) fn unlock(&mut self, output: &mut Output<'_>) {
        if matches!(self.motion, Motion::Locked(lock) if lock.is_over()) {
            self.motion = Motion::Idle;
            output.event(Event::Unlocked);
        }
    }
}
