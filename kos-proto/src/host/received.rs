//! Messages from the device, and what a client makes of them (kOS 7.2 and 7.6).

use motion_core::time::Millis;
use motion_core::wire::{Bool, DecodeError};

use super::Output;
use super::calibration::CalibrationState;
use super::event::{Event, Failure, MoveState};
use super::input::Get;
use super::machine::{HostMachine, State};
use super::requests::Asker;
use super::transmit::PasswordOf;
use crate::DeviceMessage;
use crate::frame::{MessageId, MessageType};
use crate::message::{
    ActionId, ErrorCode, ErrorStatus, Motor, MotorAddress, MotorCalibrated, MotorInfo, MotorPosition, MotorSet,
    MotorStatus,
};

impl HostMachine {
    pub(super) fn received<'a>(&mut self, now: Millis, output: &mut Output<'a>, message: DeviceMessage<'a>) {
        self.message_received(now);
        match message {
            DeviceMessage::DeviceInfo(info) => {
                let status = info.playback_status;
                if self.answered(now, output, Get::DeviceInfo, message) && self.state == State::AwaitDeviceInfo {
                    self.playback.found(output, status);
                    let device = PasswordOf::Device(info.device_password);
                    self.unlock(now, output, if self.options.echo_password() { device } else { PasswordOf::User });
                } else if self.playback.goes_other_way(output, status) {
                    self.stop_move(now, output);
                } else {
                    self.playback.said(output, &mut self.stops, status);
                }
            }
            DeviceMessage::MotorInfo(info) => self.motor_info(now, output, &info),
            DeviceMessage::DeviceGUID(guid) => {
                if self.answered(now, output, Get::DeviceGuid, message) && self.state == State::AwaitGuid {
                    self.has_guid(now, output, guid.to_bytes());
                }
            }
            DeviceMessage::SoftwareID(software) => {
                if self.answered(now, output, Get::SoftwareId, message) && self.state == State::AwaitSoftware {
                    self.has_platform(output, Some(software.platform));
                }
            }
            DeviceMessage::NetworkInfo(_) => {
                self.answered(now, output, Get::NetworkInfo, message);
            }
            DeviceMessage::LEDStatus(_) => {
                self.answered(now, output, Get::LedStatus, message);
            }
            DeviceMessage::TrajectoryData(_) => {
                self.answered(now, output, Get::TrajectoryData, message);
            }
            DeviceMessage::MotorStatus(status) => self.motor_status(now, output, &status),
            DeviceMessage::PlaybackStatus(status) => {
                status.motors.iter().for_each(|&place| self.motors.is_at(place));
                if self.playback.goes_other_way(output, status.playback_status) {
                    self.stop_move(now, output);
                } else {
                    self.playback.status(now, output, &self.options, &mut self.stops, &status);
                }
            }
            DeviceMessage::ErrorStatus(error) => self.error(now, output, &error),
            DeviceMessage::MotorPosition(MotorPosition { motor_address, position, .. }) => {
                output.event(Event::MotorRests(motor_address, position));
                self.motors.rests(output, &mut self.stops, motor_address, position);
            }
            DeviceMessage::MotorCalibrated(message) => self.calibrated(now, output, &message),
            DeviceMessage::AuxInputStatus(inputs) => output.event(Event::Inputs(inputs.status)),
            DeviceMessage::UnsupportedMessage(message) => self.unsupported(now, output, message.message.0),
            DeviceMessage::Other(_) => output.event(Event::Unsolicited(message)),
        }
    }

    pub(super) fn malformed(
        &mut self,
        now: Millis,
        output: &mut Output<'_>,
        (id, kind): (MessageId, MessageType),
        error: DecodeError,
    ) {
        self.message_received(now);
        output.event(Event::Malformed(id, error));
        let answer = matches!(kind, MessageType::RESPONSE | MessageType::RESPONSE_MORE);
        if let Some(get) = Get::of(id).filter(|_| answer) {
            self.failed(now, output, get, Failure::Malformed);
        }
    }

    /// The device does not know a message. It sends back as much of it as fits, from the version byte on. What waits for the
    /// message ends now (decision K-S24).
    fn unsupported(&mut self, now: Millis, output: &mut Output<'_>, echo: &[u8]) {
        let (id, kind) = match *echo {
            [_, _, _, i0, i1, kind, ..] => (Some(MessageId(u16::from_be_bytes([i0, i1]))), Some(MessageType(kind))),
            _ => (None, None),
        };
        let action = echo.get(6).copied().map(ActionId).filter(|_| id == Some(MessageId::ACTION));
        output.event(Event::Unsupported { id, kind, action });
        if let Some(get) = id.filter(|_| kind == Some(MessageType::GET)).and_then(Get::of) {
            self.failed(now, output, get, Failure::Unsupported);
        }
        let Some(id) = id.filter(|_| kind == Some(MessageType::SET)) else { return };
        if let Some((action, motor)) = action.zip(echo.get(7).copied().map(MotorAddress)) {
            self.motors.unsupported(output, &mut self.stops, action, motor);
            self.calibration.unsupported(output, action, motor);
        }
        if self.playback.unsupported(output, id, action) {
            self.stop_move(now, output);
        }
    }

    fn motor_info<'a>(&mut self, now: Millis, output: &mut Output<'a>, info: &MotorInfo<'a>) {
        let mut all = true;
        for motor in info.motors.iter() {
            all &= self.motors.learn(motor);
        }
        if !all {
            output.event(Event::Ignored);
        }
        // The stop of a motor that was not known is sent again, now that it can be followed.
        let deferred = self.stops.deferred();
        if self.stop_deferred(now, output, deferred.without(deferred.without(self.motors.all()))) {
            self.raise_fence(now, output);
        }
        if info.more {
            return self.more(now, Get::MotorInfo);
        }
        if self.answered(now, output, Get::MotorInfo, (*info).into()) {
            // A series may be the end of an earlier one, or pushed. So it drops no motor that is not known to rest.
            let known = self.motors.resting().without(self.stops.astray()).without(self.playback.moving());
            let missing = self.motors.end_series().without(self.motors.all().without(known));
            missing.iter().for_each(|motor| self.forget(output, motor));
            if self.stops.reported() {
                self.stop_all(now, output);
            }
            if self.state == State::AwaitMotorInfo {
                self.has_motors(now, output);
            }
        }
        output.event(Event::Motors);
        let motors = &self.motors;
        self.calibration.known(output, |motor| motors.get(motor).is_some_and(Motor::is_calibrated));
    }

    fn motor_status(&mut self, now: Millis, output: &mut Output<'_>, status: &MotorStatus<'_>) {
        let mut told = MotorSet::NONE;
        for presence in status.motors.0 {
            let motor = MotorAddress(presence.motor_address().number());
            if told.contains(motor) || MotorSet::of([motor]).is_empty() {
                continue;
            }
            told.insert(motor);
            let online = presence.online_status() != Bool::FALSE;
            output.event(Event::MotorOnline(motor, online));
            if !online {
                self.forget(output, motor);
            } else if self.motors.comes_back(motor) {
                self.ask(now, output, Get::MotorInfo, Asker::Machine);
            }
        }
    }

    /// A motor is not there any more. If it is not known to rest, it is still followed, because it may come back and still
    /// move (decision K-S25).
    fn forget(&mut self, output: &mut Output<'_>, motor: MotorAddress) {
        if self.playback.moving().contains(motor) {
            self.stops.lose(MotorSet::of([motor]));
        }
        self.motors.forget(output, &mut self.stops, motor);
    }

    /// The message does not say all of the range: the motors are asked for, and that counts (decision K-M8).
    fn calibrated(&mut self, now: Millis, output: &mut Output<'_>, message: &MotorCalibrated<'_>) {
        self.motors.calibrated(message);
        self.calibration.calibrated(message.motor_address);
        output.event(Event::MotorChanged(message.motor_address));
        self.ask(now, output, Get::MotorInfo, Asker::Machine);
    }

    fn error(&mut self, now: Millis, output: &mut Output<'_>, error: &ErrorStatus<'_>) {
        let (code, motor) = (error.error_code, error.motor_address);
        output.event(Event::Error(code, motor));
        if code == ErrorCode::LOCKED_OUT {
            if matches!(self.state, State::AwaitMotorInfo | State::AwaitGuid | State::AwaitSoftware | State::Ready) {
                self.lock(output, true);
            }
            return;
        }
        self.motors.error(output, code, motor);
        let is_by_hand = self.playback.state == MoveState::NoMove && self.calibration.state() == CalibrationState::Idle;
        if code == ErrorCode::CANNOT_EXECUTE_MOVE && is_by_hand {
            self.motors.refused(output, code);
        }
        if code.resets_axis() {
            output.event(Event::MotorChanged(motor));
        }
        self.calibration.error(output, code, motor);
        if self.playback.error(output, code) {
            self.stop_move(now, output);
        }
    }

    /// Stops a move that fails, and all that moves with it.
    fn stop_move(&mut self, now: Millis, output: &mut Output<'_>) {
        self.await_rest();
        self.stop_playback(now, output);
        self.raise_fence(now, output);
    }
}
