//! What clients do to motors by hand, how all is stopped, and what goes wrong (kOS 7.3, safety decisions 1 to 3 and 8).

use super::machine::{DeviceMachine, Turn};
use super::motor::{Drive, Motion, State};
use super::session::{self, SessionId, Sessions};
use super::{Event, Ignored, What};
use crate::message::{ErrorCode, MotorAddress, Rotations, RotationsPerSecond, RotationsPerSecondSquared, Seconds};
use crate::summary::{MotorSet, millis};

impl DeviceMachine {
    /// Those that asked, and are not told anyway.
    fn waiting(&self, turn: &Turn<'_>) -> Sessions {
        let locked = |&session: &SessionId| self.sessions.state(session) == session::State::Locked;
        turn.asker.iter().filter(locked).map(Sessions::one).fold(Sessions::NONE, Sessions::with)
    }

    /// Stops everything, in whatever state: says that all is over, and where the motors rest (safety decision 8).
    pub(super) fn stop_all(&mut self, turn: &mut Turn<'_>) {
        turn.output.event(Event::StopAll);
        let (travelling, waiting) = (self.playback.travelling(), self.waiting(turn));
        self.playback.full_stop(turn, &self.drives);
        for (motor, drive) in self.drives.iter_mut() {
            match drive.motion() {
                Motion::Stopping(others) => drive.set_motion(Motion::Stopping(others.with(waiting))),
                Motion::Resting if !travelling.contains(motor) => rests(turn, waiting, motor, drive),
                Motion::Resting | Motion::Moving(_) => drive.set_motion(Motion::Stopping(waiting)),
            }
        }
    }

    /// Stops a motor, and, while a move runs, the move (safety decision 1).
    pub(super) fn stop_motor(
        &mut self,
        turn: &mut Turn<'_>,
        motor: MotorAddress,
        acceleration: RotationsPerSecondSquared,
    ) {
        if self.playback.state().runs() {
            return self.stop_all(turn);
        }
        let waiting = self.waiting(turn);
        let Some(drive) = self.drives.get_mut(motor) else {
            return turn.answer_error(ErrorCode::BAD_MOTOR_ADDRESS, motor);
        };
        let others = match drive.motion() {
            Motion::Resting => return rests(turn, waiting, motor, drive),
            Motion::Moving(_) => Sessions::NONE,
            Motion::Stopping(others) => others,
        };
        let usable = acceleration.0.is_finite() && acceleration.0 > 0.0;
        turn.output.event(Event::StopMotor { motor, acceleration: usable.then_some(acceleration) });
        drive.set_motion(Motion::Stopping(others.with(waiting)));
    }

    /// A motor, if it is there and no move runs; otherwise the client is told why not.
    fn drive(&mut self, turn: &mut Turn<'_>, motor: MotorAddress) -> Option<&mut Drive> {
        if self.playback.state().runs() {
            turn.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
            return None;
        }
        let drive = self.drives.get_mut(motor);
        if drive.is_none() {
            turn.answer_error(ErrorCode::BAD_MOTOR_ADDRESS, motor);
        }
        drive
    }

    /// Sends a motor somewhere.
    pub(super) fn go(
        &mut self,
        turn: &mut Turn<'_>,
        session: SessionId,
        motor: MotorAddress,
        target: impl Fn(&Drive) -> Rotations,
        (speed, acceleration): (RotationsPerSecond, RotationsPerSecondSquared),
    ) {
        let Some(drive) = self.drive(turn, motor) else { return };
        let to = target(drive);
        let positive = |number: f32| number.is_finite() && number > 0.0;
        if !(to.0.is_finite() && positive(speed.0) && positive(acceleration.0)) {
            return turn.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
        }
        drive.set_motion(Motion::Moving(session));
        let motor = MotorAddress(motor.number());
        turn.output.event(Event::Move { motor, to, speed, acceleration });
        self.playback.disturb();
    }

    /// The range of a motor begins here; the motor has to rest.
    pub(super) fn mark_begin(&mut self, turn: &mut Turn<'_>, motor: MotorAddress) {
        let Some(drive) = self.drive(turn, motor) else { return };
        if drive.motion() != Motion::Resting {
            return turn.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
        }
        drive.mark_begin();
        self.playback.disturb();
    }

    /// The range of a motor ends here; the motor has to rest.
    pub(super) fn mark_end(&mut self, turn: &mut Turn<'_>, motor: MotorAddress) {
        let keep_count = self.options.quirk_begin_nonzero;
        let Some(drive) = self.drive(turn, motor) else { return };
        if drive.motion() != Motion::Resting {
            return turn.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
        }
        let motor = MotorAddress(motor.number());
        if drive.mark_end(keep_count) {
            let (begin, end) = drive.range();
            turn.tell(Sessions::NONE, What::MotorCalibrated { motor, begin, end });
        } else {
            turn.tell_error(ErrorCode::CALIBRATION, motor);
        }
        self.playback.disturb();
    }

    /// Forgets the range of a motor, or, silently, of all. A motor that moves is stopped: where to, nobody knows now.
    pub(super) fn reset_axis(&mut self, turn: &mut Turn<'_>, motor: MotorAddress) {
        let all = motor.number() == MotorAddress::ALL.0;
        if self.playback.state().runs() {
            return turn.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
        }
        if !all && self.drives.get(motor).is_none() {
            return turn.answer_error(ErrorCode::BAD_MOTOR_ADDRESS, motor);
        }
        for (number, drive) in self.drives.iter_mut().filter(|&(number, _)| all || number.0 == motor.number()) {
            halt(turn, number, drive);
            drive.reset();
            if !all {
                let (begin, end) = drive.range();
                turn.tell(Sessions::NONE, What::MotorCalibrated { motor: number, begin, end });
            }
        }
        self.playback.disturb();
    }

    /// Takes one photo; in a move, the move takes them.
    pub(super) fn take_picture(&mut self, turn: &mut Turn<'_>, exposure: Seconds) {
        if self.playback.state().runs() || !exposure.0.is_finite() || exposure.0 < 0.0 {
            return turn.refuse(ErrorCode::CANNOT_EXECUTE_MOVE);
        }
        turn.output.event(Event::OpenShutter { millis: millis(exposure) });
    }

    /// A motor rests.
    pub(super) fn arrived(&mut self, turn: &mut Turn<'_>, motor: MotorAddress) {
        if let Some(drive) = self.drives.get_mut(motor) {
            let motor = MotorAddress(motor.number());
            match drive.motion() {
                Motion::Resting => {}
                Motion::Moving(_) => rests(turn, Sessions::NONE, motor, drive),
                Motion::Stopping(waiting) => rests(turn, waiting, motor, drive),
            }
            drive.set_motion(Motion::Resting);
        }
        self.playback.arrived(turn, &self.drives, motor);
    }

    /// The move fails: everything stops.
    pub(super) fn fail(&mut self, turn: &mut Turn<'_>, code: ErrorCode, motor: MotorAddress) {
        turn.tell_error(code, motor);
        turn.output.event(Event::StopAll);
        let travelling = self.playback.travelling();
        for (_, drive) in self.drives.iter_mut().filter(|&(motor, _)| travelling.contains(motor)) {
            drive.set_motion(Motion::Stopping(Sessions::NONE));
        }
        self.playback.full_stop(turn, &self.drives);
    }

    /// A motor has a fault: its range is forgotten where the code says so, it stops, and a move stops with it.
    pub(super) fn fault(&mut self, turn: &mut Turn<'_>, motor: MotorAddress, code: ErrorCode) {
        let Some(drive) = self.drives.get_mut(motor) else { return turn.ignore(Ignored::Report) };
        let motor = MotorAddress(motor.number());
        if code.resets_axis() {
            drive.reset();
        }
        if self.playback.state().runs() {
            return self.fail(turn, code, motor);
        }
        turn.tell_error(code, motor);
        halt(turn, motor, drive);
        self.playback.disturb();
    }

    /// A motor came or went. One that goes fails the move that it is part of.
    pub(super) fn online(&mut self, turn: &mut Turn<'_>, motor: MotorAddress, online: bool) {
        if MotorSet::of([motor]).is_empty() || self.drives.get(motor).is_some() == online {
            return turn.ignore(Ignored::Report);
        }
        let motor = MotorAddress(motor.number());
        let part = self.playback.plan().is_some_and(|plan| plan.motors.contains(motor));
        if part && self.playback.state().runs() {
            self.fail(turn, ErrorCode::BAD_MOTOR_ADDRESS, motor);
        }
        self.drives.set_online(motor, online);
        self.playback.disturb();
        turn.tell(Sessions::NONE, What::MotorStatus { motor, online });
    }

    /// How much is known of the range of a motor, if it is there.
    #[must_use]
    pub fn calibration(&self, motor: MotorAddress) -> Option<State> {
        self.drives.get(motor).map(Drive::state)
    }
}

/// Says where a motor rests.
fn rests(turn: &mut Turn<'_>, waiting: Sessions, motor: MotorAddress, drive: &Drive) {
    turn.tell(waiting, What::MotorPosition { motor, position: drive.position() });
}

/// Stops a motor that moves by hand.
fn halt(turn: &mut Turn<'_>, motor: MotorAddress, drive: &mut Drive) {
    if let Motion::Moving(_) = drive.motion() {
        turn.output.event(Event::StopMotor { motor, acceleration: None });
        drive.set_motion(Motion::Stopping(Sessions::NONE));
    }
}
