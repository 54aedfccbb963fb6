//! A range that a client marks: both its ends by hand, then what the device makes of it (kOS 7.3, decision K-M8).

use motion_core::time::Millis;

use super::io::{Event, Refusal};
use super::send::Send;
use super::{Options, Output};
use crate::message::{ErrorCode, MotorAddress};
use crate::summary::MotorSet;

/// How far the range is whose end was marked last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum State {
    /// No end was marked.
    #[default]
    Idle,
    /// The device has to say whether there is a range.
    AwaitCalibrated,
    /// It says there is; what it says of the motor then counts.
    AwaitRange,
}

impl State {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Idle, Self::AwaitCalibrated, Self::AwaitRange];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Idle => "Idle",
            Self::AwaitCalibrated => "AwaitCalibrated",
            Self::AwaitRange => "AwaitRange",
        }
    }
}

/// The ranges that are being marked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(super) struct Calibration {
    state: State,
    /// The motors whose ranges begin somewhere.
    marked: MotorSet,
    /// The motor whose end was marked, and when the device should have said something.
    motor: MotorAddress,
    until: Option<Millis>,
}

impl Calibration {
    pub(super) const fn state(&self) -> State {
        self.state
    }

    pub(super) fn mark_begin(&mut self, output: &mut Output, motor: MotorAddress) {
        self.marked.insert(motor);
        output.send(Send::MarkBegin(MotorAddress(motor.number())));
    }

    pub(super) fn mark_end(
        &mut self,
        now: Millis,
        output: &mut Output,
        options: &Options,
        motor: MotorAddress,
    ) -> Result<(), Refusal> {
        if self.state != State::Idle {
            return Err(Refusal::Busy);
        }
        if !self.marked.contains(motor) {
            return Err(Refusal::NotMarked);
        }
        let motor = MotorAddress(motor.number());
        self.marked.remove(motor);
        (self.state, self.motor) = (State::AwaitCalibrated, motor);
        self.until = Some(now.after(options.request_timeout));
        output.send(Send::MarkEnd(motor));
        Ok(())
    }

    /// The device says that a motor has a range, or none: its motors will say which.
    pub(super) fn calibrated(&mut self, motor: MotorAddress) {
        if self.state == State::AwaitCalibrated && self.motor.number() == motor.number() {
            self.state = State::AwaitRange;
        }
    }

    /// The motors are known anew; whether this one has a range now.
    pub(super) fn known(&mut self, output: &mut Output, has_range: impl Fn(MotorAddress) -> bool) {
        if self.state == State::AwaitRange {
            let motor = self.motor;
            self.end(output, if has_range(motor) { Event::Calibrated(motor) } else { Event::CalibrationFailed(motor) });
        }
    }

    /// Something failed on the device.
    pub(super) fn error(&mut self, output: &mut Output, code: ErrorCode, motor: MotorAddress) {
        if code.resets_axis() {
            self.marked.remove(motor);
        }
        let refused = matches!(code, ErrorCode::CANNOT_EXECUTE_MOVE | ErrorCode::BAD_MOTOR_ADDRESS);
        let its_own = code.resets_axis() && motor.number() == self.motor.number();
        if self.state != State::Idle && (its_own || (refused && self.state == State::AwaitCalibrated)) {
            self.end(output, Event::CalibrationFailed(self.motor));
        }
    }

    /// The connection is lost.
    pub(super) fn lost(&mut self, output: &mut Output) {
        if self.state != State::Idle {
            output.event(Event::CalibrationFailed(self.motor));
        }
        *self = Self::default();
    }

    pub(super) fn wake(&mut self, now: Millis, output: &mut Output) {
        if self.until.is_some_and(|until| until <= now) {
            self.end(output, Event::CalibrationFailed(self.motor));
        }
    }

    pub(super) const fn deadline(&self) -> Option<Millis> {
        self.until
    }

    fn end(&mut self, output: &mut Output, event: Event) {
        *self = Self { marked: self.marked, ..Self::default() };
        output.event(event);
    }
}
