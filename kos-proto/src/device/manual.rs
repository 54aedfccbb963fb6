//! Motion by hand, stops of everything, and faults (kOS 7.3, safety decisions 1 to 3 and 8).

use motion_core::time::Millis;

use super::clients::{self, SessionId, Sessions};
use super::effects::Effects;
use super::event::{Event, Ignored};
use super::machine::DeviceMachine;
use super::motor::{Drive, Motion, State};
use super::options::Quirks;
use super::playback::Rig;
use super::transmit::Contents;
use crate::message::{
    ErrorCode, MotorAddress, MotorSet, Rotations, RotationsPerSecond, RotationsPerSecondSquared, Seconds,
};
use crate::times::millis;

impl<const MOVES: bool> DeviceMachine<MOVES> {
    /// Clients that asked and are not told anyway.
    fn waiting(&self, output: &Effects<'_, '_>) -> Sessions {
        let locked = |&session: &SessionId| self.sessions.state(session) == clients::State::Locked;
        output.asker.iter().filter(locked).map(Sessions::one).fold(Sessions::NONE, Sessions::with)
    }

    /// Stops everything, in every state: tells that all is over, and where the motors rest (safety decision 8).
    pub(super) fn stop_all(&mut self, now: Millis, output: &mut Effects<'_, '_>) {
        output.event(Event::StopAll);
        self.shutter = None;
        let (travelling, waiting) = (self.playback.travelling(), self.waiting(output));
        self.playback.full_stop(now, output, Rig::of(&self.drives, &self.options));
        for (motor, drive) in self.drives.iter_mut() {
            match drive.motion() {
                Motion::Stopping(others) => drive.set_motion(Motion::Stopping(others.with(waiting))),
                Motion::Resting if !travelling.contains(motor) => rests(output, waiting, motor, drive),
                Motion::Resting | Motion::Moving(_) => drive.set_motion(Motion::Stopping(waiting)),
            }
        }
    }

    /// Stops a motor. While a move runs, stops everything (safety decision 1).
    pub(super) fn stop_motor(
        &mut self,
        now: Millis,
        output: &mut Effects<'_, '_>,
        motor: MotorAddress,
        acceleration: RotationsPerSecondSquared,
    ) {
        if self.playback.state().runs() {
            return self.stop_all(now, output);
        }
        let waiting = self.waiting(output);
        let Some(drive) = self.drives.get_mut(motor) else {
            return output.answer_error(ErrorCode::BAD_MOTOR_ADDRESS, motor);
        };
        let others = match drive.motion() {
            Motion::Resting => return rests(output, waiting, motor, drive),
            Motion::Moving(_) => Sessions::NONE,
            Motion::Stopping(others) => others,
        };
        let usable = acceleration.0.is_finite() && acceleration.0 > 0.0;
        output.event(Event::StopMotor { motor, acceleration: usable.then_some(acceleration) });
        drive.set_motion(Motion::Stopping(others.with(waiting)));
    }

    /// Motor, if it is there and no move runs. Otherwise the client is told why not.
    fn drive(&mut self, output: &mut Effects<'_, '_>, motor: MotorAddress) -> Option<&mut Drive> {
        if self.playback.state().runs() {
            output.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
            return None;
        }
        let drive = self.drives.get_mut(motor);
        if drive.is_none() {
            output.answer_error(ErrorCode::BAD_MOTOR_ADDRESS, motor);
        }
        drive
    }

    /// Sends a motor to a position. A motor that rests and is not sent reports its position all the same (decision K-M10).
    pub(super) fn go(
        &mut self,
        output: &mut Effects<'_, '_>,
        session: SessionId,
        motor: MotorAddress,
        target: impl Fn(&Drive, bool) -> Rotations,
        (speed, acceleration): (RotationsPerSecond, RotationsPerSecondSquared),
    ) {
        let clamps = !self.options.has(Quirks::NOT_CLAMPED);
        let travelling = self.playback.travelling();
        let positive = |number: f32| number.is_finite() && number > 0.0;
        let is_number =
            |drive: &Drive| target(drive, clamps).0.is_finite() && positive(speed.0) && positive(acceleration.0);
        let is_refused = self.playback.state().runs() || self.drives.get(motor).is_some_and(|drive| !is_number(drive));
        if let Some(drive) = self.drives.get(motor).filter(|_| is_refused) {
            output.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
            if drive.motion() == Motion::Resting && !travelling.contains(motor) {
                let motor = MotorAddress(motor.number());
                output.answer(Contents::MotorPosition { motor, position: drive.position() });
            }
            return;
        }
        let Some(drive) = self.drive(output, motor) else { return };
        let to = target(drive, clamps);
        drive.set_motion(Motion::Moving(session));
        let motor = MotorAddress(motor.number());
        output.event(Event::Move { motor, to, speed, acceleration });
        self.playback.disturb();
    }

    /// Marks the begin of the range of a motor where it is.
    pub(super) fn mark_begin(&mut self, output: &mut Effects<'_, '_>, motor: MotorAddress) {
        let Some(drive) = self.drive(output, motor) else { return };
        drive.mark_begin();
        self.playback.disturb();
    }

    /// Marks the end of the range of a motor where it is. A motor that moves is stopped, because it would go on beyond the
    /// range that it reports.
    pub(super) fn mark_end(&mut self, output: &mut Effects<'_, '_>, motor: MotorAddress) {
        let keep_count = self.options.has(Quirks::BEGIN_NONZERO);
        let Some(drive) = self.drive(output, motor) else { return };
        let motor = MotorAddress(motor.number());
        halt(output, motor, drive);
        if drive.mark_end(keep_count) {
            let (begin, end) = drive.range();
            output.tell(Sessions::NONE, Contents::MotorCalibrated { motor, begin, end });
        } else {
            output.tell_error(ErrorCode::CALIBRATION, motor);
        }
        self.playback.disturb();
    }

    /// Forgets the range of a motor, or, without an answer, of all. A motor that moves is stopped, because its target
    /// means nothing any more.
    pub(super) fn reset_axis(&mut self, output: &mut Effects<'_, '_>, motor: MotorAddress) {
        let all = motor.number() == MotorAddress::ALL.0;
        if self.playback.state().runs() {
            return output.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
        }
        if !all && self.drives.get(motor).is_none() {
            return output.answer_error(ErrorCode::BAD_MOTOR_ADDRESS, motor);
        }
        for (number, drive) in self.drives.iter_mut().filter(|&(number, _)| all || number.0 == motor.number()) {
            halt(output, number, drive);
            drive.reset();
            if !all {
                let (begin, end) = drive.range();
                output.tell(Sessions::NONE, Contents::MotorCalibrated { motor: number, begin, end });
            }
        }
        self.playback.disturb();
    }

    /// Takes one photo. It is refused while a move runs, which takes its own.
    pub(super) fn take_picture(&mut self, now: Millis, output: &mut Effects<'_, '_>, exposure: Seconds) {
        if self.playback.state().runs() || !exposure.0.is_finite() || exposure.0 < 0.0 {
            return output.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
        }
        let millis = millis(exposure);
        output.event(Event::OpenShutter { millis });
        self.shutter = self.shutter.max(Some(now.after(millis.max(1))));
    }

    /// Takes the report that a motor rests.
    pub(super) fn arrived(&mut self, now: Millis, output: &mut Effects<'_, '_>, motor: MotorAddress) {
        if let Some(drive) = self.drives.get_mut(motor) {
            let motor = MotorAddress(motor.number());
            match drive.motion() {
                Motion::Resting => {}
                Motion::Moving(_) => rests(output, Sessions::NONE, motor, drive),
                Motion::Stopping(waiting) => rests(output, waiting, motor, drive),
            }
            drive.set_motion(Motion::Resting);
        }
        self.playback.arrived(now, output, Rig::of(&self.drives, &self.options), motor);
    }

    /// Stops everything because the move fails.
    pub(super) fn fail(&mut self, now: Millis, output: &mut Effects<'_, '_>, code: ErrorCode, motor: MotorAddress) {
        output.event(Event::StopAll);
        self.shutter = None;
        output.tell_error(code, motor);
        let travelling = self.playback.travelling();
        for (_, drive) in self.drives.iter_mut().filter(|&(motor, _)| travelling.contains(motor)) {
            drive.set_motion(Motion::Stopping(Sessions::NONE));
        }
        self.playback.full_stop(now, output, Rig::of(&self.drives, &self.options));
    }

    /// Takes the report of a fault: the motor stops, a move stops with it, and some codes void the range.
    pub(super) fn fault(&mut self, now: Millis, output: &mut Effects<'_, '_>, motor: MotorAddress, code: ErrorCode) {
        let Some(drive) = self.drives.get_mut(motor) else { return output.ignore(Ignored::Report) };
        let motor = MotorAddress(motor.number());
        if code.resets_axis() {
            drive.reset();
        }
        if self.playback.state().runs() {
            return self.fail(now, output, code, motor);
        }
        halt(output, motor, drive);
        output.tell_error(code, motor);
        self.playback.disturb();
    }

    /// Takes the report that a motor came or went. A motor that goes fails the move that it is part of. If it did not rest, it
    /// is stopped, and once more when it comes back, because nobody knows whether the first stop arrived.
    pub(super) fn online(&mut self, now: Millis, output: &mut Effects<'_, '_>, motor: MotorAddress, online: bool) {
        if MotorSet::of([motor]).is_empty() || self.drives.get(motor).is_some() == online {
            return output.ignore(Ignored::Report);
        }
        let motor = MotorAddress(motor.number());
        let part = self.playback.plan().is_some_and(|plan| plan.motors.contains(motor));
        if part && self.playback.state().runs() {
            self.fail(now, output, ErrorCode::BAD_MOTOR_ADDRESS, motor);
        }
        if let Some(drive) = self.drives.get_mut(motor).filter(|drive| drive.motion() != Motion::Resting) {
            halt(output, motor, drive);
            self.gone.insert(motor);
        }
        self.drives.set_online(motor, online);
        self.stop_again(output);
        self.playback.disturb();
        output.tell(Sessions::NONE, Contents::MotorStatus { motor, online });
    }

    /// Stops motors that are there again, because nobody knows whether they rest.
    pub(super) fn stop_again(&mut self, output: &mut Effects<'_, '_>) {
        for (motor, drive) in self.drives.iter_mut().filter(|(motor, _)| self.gone.contains(*motor)) {
            output.event(Event::StopMotor { motor, acceleration: None });
            drive.set_motion(Motion::Stopping(Sessions::NONE));
        }
        self.gone = self.gone.without(self.drives.online());
    }

    /// State of the range of a motor, if the motor is there.
    #[must_use]
    pub fn calibration(&self, motor: MotorAddress) -> Option<State> {
        self.drives.get(motor).map(Drive::state)
    }
}

/// Tells where a motor rests.
fn rests(output: &mut Effects<'_, '_>, waiting: Sessions, motor: MotorAddress, drive: &Drive) {
    output.tell(waiting, Contents::MotorPosition { motor, position: drive.position() });
}

/// Stops a motor that moves by hand.
fn halt(output: &mut Effects<'_, '_>, motor: MotorAddress, drive: &mut Drive) {
    if let Motion::Moving(_) = drive.motion() {
        output.event(Event::StopMotor { motor, acceleration: None });
        drive.set_motion(Motion::Stopping(Sessions::NONE));
    }
}
