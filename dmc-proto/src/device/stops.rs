//! Stops, asked for and hard ones: safety decisions 1, 4 and 6, DMC D2. Nothing stands before a stop.

use motion_core::time::Millis;

use super::io::{Event, Output, Stop, What};
use super::machine::{Answer, DeviceMachine};
use super::motion::{Lock, Motion};
use crate::message::{AckCode, HostMessage, Motor, Motors, StopFlags, StopReason};

impl DeviceMachine {
    /// Obeys a stop, whatever the device is doing. Only a motor that is not there cannot be stopped.
    pub(super) fn stop(&mut self, now: Millis, message: &HostMessage<'_>, output: &mut Output) -> Answer {
        match message {
            HostMessage::MotorStop(message) => {
                if !self.all_motors().contains(message.motor) {
                    return Err(AckCode::ERR_RANGE);
                }
                // A motor outside the uploaded move can only be one that is driven by hand.
                let axes = self.motion.coordinated(self.upload.axes()).unwrap_or_default();
                let is_part = axes.contains(message.motor);
                self.stop_one(now, Stop::Motor(message.motor), is_part, output);
            }
            HostMessage::VirtStop(message) => {
                let is_part = self.motion.coordinated(Motors::NONE).is_some();
                self.stop_one(now, Stop::Virtual(message.virtual_motor), is_part, output);
            }
            HostMessage::MotorStopAll(message) => {
                let silent = message.flags.unwrap_or_default().contains(StopFlags::SILENT);
                self.stop_all(now, silent, output);
            }
            _ => {}
        }
        Ok(())
    }

    /// Of a coordinated move, one motor stops all of it.
    fn stop_one(&mut self, now: Millis, stop: Stop, is_part: bool, output: &mut Output) {
        self.on_frame = None;
        if is_part {
            self.stop_all(now, false, output);
        } else {
            output.event(Event::Stop(stop));
        }
    }

    pub(super) fn stop_all(&mut self, now: Millis, silent: bool, output: &mut Output) {
        let harder_until = Some(now.after(self.options.harder_within.into()));
        let stop = match self.motion {
            Motion::Stopping(Some(until)) if until > now => Stop::Harder,
            _ => Stop::All { silent },
        };
        output.event(Event::Stop(stop));
        if self.motion.job().is_some() {
            output.event(Event::TriggersOff);
        }
        self.motion = match self.motion {
            Motion::Idle | Motion::Locked(_) => return,
            _ => Motion::Stopping(harder_until),
        };
        self.on_frame = None;
    }

    /// Nobody could stop the motors any more (decision D-53).
    pub(super) fn link_down(&mut self, now: Millis, output: &mut Output) {
        if !matches!(self.motion, Motion::Idle | Motion::Stopping(_) | Motion::Locked(_)) {
            self.stop_all(now, false, output);
        }
    }

    pub(super) fn limit(&mut self, motor: Motor, upper: bool, output: &mut Output) {
        let (reason, code) = if upper {
            (StopReason::UPPER_LIMIT, AckCode::ERR_HARD_UP)
        } else {
            (StopReason::LOWER_LIMIT, AckCode::ERR_HARD_LOW)
        };
        self.hard_stop(reason, Some(motor), code, false, output);
    }

    pub(super) fn fault(&mut self, motor: Option<Motor>, output: &mut Output) {
        self.hard_stop(StopReason::ENGINE_EXCEPTION, motor, AckCode::ERR_GENERAL, false, output);
    }

    pub(super) fn emergency_stop(&mut self, pressed: bool, output: &mut Output) {
        if pressed {
            self.hard_stop(StopReason::EMERGENCY_STOP, None, AckCode::ERR_GENERAL, true, output);
        } else if let Motion::Locked(lock) = &mut self.motion {
            lock.is_pressed = false;
        } else {
            output.event(Event::Stray);
        }
    }

    fn hard_stop(
        &mut self,
        reason: StopReason,
        motor: Option<Motor>,
        code: AckCode,
        pressed: bool,
        output: &mut Output,
    ) {
        output.event(Event::Stop(Stop::Hard));
        if self.motion.job().is_some() {
            output.event(Event::TriggersOff);
        }
        let is_pressed = pressed || matches!(self.motion, Motion::Locked(Lock { is_pressed: true, .. }));
        self.motion = Motion::Locked(Lock { code, is_pressed, is_at_rest: false, until: None });
        self.on_frame = None;
        Self::tell(What::HardStop(reason, motor), output);
    }

    /// Ends a lock whose time has come.
    pub(super) fn unlock(&mut self, output: &mut Output) {
        if matches!(self.motion, Motion::Locked(lock) if lock.is_over()) {
            self.motion = Motion::Idle;
            output.event(Event::Unlocked);
        }
    }
}
