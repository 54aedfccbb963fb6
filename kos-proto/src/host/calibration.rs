//! Range that a client marks: both its ends by hand, then what the device makes of it (kOS 7.3, decision K-M8).

use motion_core::states;
use motion_core::time::Millis;

use super::event::{Event, Failure, Outcome, Refusal};
use super::transmit::Transmit;
use super::{Options, Output, Token};
use crate::frame::MessageId;
use crate::message::{ActionId, ErrorCode, MotorAddress, MotorSet};

states! {
    /// State of the range whose end was marked last.
    #[derive(Default)]
    pub enum CalibrationState {
        /// No end was marked.
        #[default]
        Idle,
        /// The device has to say whether there is a range.
        AwaitCalibrated,
        /// The device says that there is a range; its report on the motors decides.
        AwaitRange,
    }
}

/// Ranges that are being marked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(super) struct Calibration {
    state: CalibrationState,
    /// Motors whose ranges begin somewhere.
    marked: MotorSet,
    /// Motor whose end was marked, and the command.
    motor: MotorAddress,
    token: Token,
    /// Time at which the device should have said something.
    until: Option<Millis>,
}

impl Calibration {
    pub(super) const fn state(&self) -> CalibrationState {
        self.state
    }

    pub(super) fn mark_begin(&mut self, output: &mut Output<'_>, motor: MotorAddress) {
        self.marked.insert(motor);
        output.transmit(Transmit::MarkBegin(MotorAddress(motor.number())));
    }

    pub(super) fn mark_end(
        &mut self,
        now: Millis,
        output: &mut Output<'_>,
        options: &Options,
        motor: MotorAddress,
        token: Token,
    ) -> Result<(), Refusal> {
        if self.state != CalibrationState::Idle {
            return Err(Refusal::Busy);
        }
        if !self.marked.contains(motor) {
            return Err(Refusal::NotMarked);
        }
        let motor = MotorAddress(motor.number());
        self.marked.remove(motor);
        (self.state, self.motor, self.token) = (CalibrationState::AwaitCalibrated, motor, token);
        self.until = Some(now.after(options.request_timeout()));
        output.transmit(Transmit::MarkEnd(motor));
        Ok(())
    }

    /// Notes that a motor has a range, or none: the report on the motors will say which.
    pub(super) fn calibrated(&mut self, motor: MotorAddress) {
        if self.state == CalibrationState::AwaitCalibrated && self.motor.number() == motor.number() {
            self.state = CalibrationState::AwaitRange;
        }
    }

    /// Ends the calibration if it waits for the report on the motors.
    pub(super) fn known(&mut self, output: &mut Output<'_>, has_range: impl Fn(MotorAddress) -> bool) {
        if self.state == CalibrationState::AwaitRange {
            let has_range = has_range(self.motor);
            self.end(output, if has_range { Outcome::Done(None) } else { Outcome::Failed(Failure::NoRange) });
        }
    }

    /// Takes an error that the device reported.
    pub(super) fn error(&mut self, output: &mut Output<'_>, code: ErrorCode, motor: MotorAddress) {
        if code.resets_axis() {
            self.marked.remove(motor);
        }
        let refused = matches!(code, ErrorCode::CANNOT_EXECUTE_MOVE | ErrorCode::BAD_MOTOR_ADDRESS);
        let is_own = code.resets_axis() && motor.number() == self.motor.number();
        if self.state != CalibrationState::Idle
            && (is_own || (refused && self.state == CalibrationState::AwaitCalibrated))
        {
            self.end(output, Outcome::Refused(Refusal::Device(code)));
        }
    }

    /// Takes the report that the device does not know an action.
    pub(super) fn unsupported(&mut self, output: &mut Output<'_>, action: ActionId, motor: MotorAddress) {
        match action {
            ActionId::MARK_BEGIN_POSITION => self.marked.remove(motor),
            ActionId::MARK_END_POSITION if self.motor.number() == motor.number() => {
                let refusal = Refusal::Unsupported { id: MessageId::ACTION, action: Some(action) };
                self.end(output, Outcome::Refused(refusal));
            }
            _ => {}
        }
    }

    /// Notes that the connection went down.
    pub(super) fn lost(&mut self, output: &mut Output<'_>) {
        self.end(output, Outcome::Failed(Failure::LinkDown));
        *self = Self::default();
    }

    pub(super) fn wake(&mut self, now: Millis, output: &mut Output<'_>) {
        if self.until.is_some_and(|until| until <= now) {
            self.end(output, Outcome::NotConfirmed);
        }
    }

    pub(super) const fn deadline(&self) -> Option<Millis> {
        self.until
    }

    fn end(&mut self, output: &mut Output<'_>, outcome: Outcome<'static>) {
        if self.state != CalibrationState::Idle {
            output.event(Event::ended(self.token, outcome));
        }
        *self = Self { marked: self.marked, ..Self::default() };
    }
}
