//! What the device says, and what a client makes of it (kOS 7.2 and 7.6).

use motion_core::time::Millis;
use motion_core::wire::{Bool, DecodeError};

use super::Output;
use super::io::Event;
use super::machine::{HostMachine, State};
use super::requests::{Asker, Failure, Get, echoed};
use super::send::PasswordOf;
use crate::DeviceMessage;
use crate::frame::{MessageId, MessageType};
use crate::message::{
    ErrorCode, ErrorStatus, Motor, MotorAddress, MotorCalibrated, MotorInfo, MotorPosition, MotorStatus, PlaybackStatus,
};
use crate::summary::MotorSet;

impl HostMachine {
    pub(super) fn received(&mut self, now: Millis, output: &mut Output, message: &DeviceMessage<'_>) {
        self.heard(now);
        match message {
            DeviceMessage::DeviceInfo(info) => {
                let status = info.playback_status;
                if !self.answered(now, output, Get::DeviceInfo) {
                    self.tracker.said(output, status);
                } else if self.state == State::AwaitDeviceInfo {
                    self.tracker.found(output, status);
                    let echo = self.options.echo_password;
                    self.unlock(now, output, if echo { PasswordOf::Device } else { PasswordOf::User });
                } else {
                    self.tracker.said(output, status);
                }
            }
            DeviceMessage::MotorInfo(info) => self.motor_info(now, output, info),
            DeviceMessage::DeviceGUID(guid) => {
                let guid = guid.to_bytes();
                if self.answered(now, output, Get::DeviceGuid) && self.state == State::AwaitGuid {
                    self.has_guid(now, output, guid);
                }
            }
            DeviceMessage::SoftwareID(software) => {
                if self.answered(now, output, Get::SoftwareId) && self.state == State::AwaitSoftware {
                    self.has_platform(output, Some(software.platform));
                }
            }
            DeviceMessage::NetworkInfo(_) => {
                self.answered(now, output, Get::NetworkInfo);
            }
            DeviceMessage::LEDStatus(_) => {
                self.answered(now, output, Get::LedStatus);
            }
            DeviceMessage::TrajectoryData(_) => {
                self.answered(now, output, Get::TrajectoryData);
            }
            DeviceMessage::MotorStatus(status) => self.motor_status(now, output, status),
            DeviceMessage::PlaybackStatus(status) => self.playback_status(output, status),
            DeviceMessage::ErrorStatus(error) => self.error(now, output, error),
            DeviceMessage::MotorPosition(MotorPosition { motor_address, position, .. }) => {
                self.motors.rests(*motor_address, *position);
                output.event(Event::MotorRests(*motor_address, *position));
            }
            DeviceMessage::MotorCalibrated(message) => self.calibrated(now, output, message),
            DeviceMessage::AuxInputStatus(inputs) => output.event(Event::Inputs(inputs.status)),
            DeviceMessage::UnsupportedMessage(message) => {
                let echo = echoed(message.message.0);
                output.event(Event::Unsupported(echo.map(|(id, _)| id)));
                let question = echo.filter(|&(_, kind)| kind == MessageType::GET).and_then(|(id, _)| Get::of(id));
                if let Some(get) = question {
                    self.failed(now, output, get, Failure::Unsupported);
                }
            }
            DeviceMessage::Other(_) => output.event(Event::Told(message.id())),
        }
    }

    pub(super) fn malformed(
        &mut self,
        now: Millis,
        output: &mut Output,
        (id, kind): (MessageId, MessageType),
        error: DecodeError,
    ) {
        self.heard(now);
        output.event(Event::Malformed(id, error));
        let answer = matches!(kind, MessageType::RESPONSE | MessageType::RESPONSE_MORE);
        if let Some(get) = Get::of(id).filter(|_| answer) {
            self.failed(now, output, get, Failure::Malformed);
        }
    }

    fn motor_info(&mut self, now: Millis, output: &mut Output, info: &MotorInfo<'_>) {
        let mut all = true;
        for motor in info.motors.iter() {
            all &= self.motors.learn(motor);
        }
        if !all {
            output.event(Event::Ignored);
        }
        if info.more {
            return self.more(now, Get::MotorInfo);
        }
        if self.answered(now, output, Get::MotorInfo) {
            self.motors.end_series();
            if self.state == State::AwaitMotorInfo {
                self.has_motors(now, output);
            }
        }
        output.event(Event::Motors);
        let motors = &self.motors;
        self.calibration.known(output, |motor| motors.get(motor).is_some_and(Motor::is_calibrated));
    }

    fn motor_status(&mut self, now: Millis, output: &mut Output, status: &MotorStatus<'_>) {
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
                self.motors.forget(motor);
            } else if self.motors.get(motor).is_none() {
                self.ask(now, output, Get::MotorInfo, Asker::Machine);
            }
        }
    }

    fn playback_status(&mut self, output: &mut Output, status: &PlaybackStatus<'_>) {
        for &place in status.motors {
            self.motors.is_at(place);
        }
        self.tracker.status(output, status);
    }

    /// What is said of the range is not all: the motors are asked for, and that counts (decision K-M8).
    fn calibrated(&mut self, now: Millis, output: &mut Output, message: &MotorCalibrated<'_>) {
        self.motors.calibrated(message);
        self.calibration.calibrated(message.motor_address);
        output.event(Event::MotorChanged(message.motor_address));
        self.ask(now, output, Get::MotorInfo, Asker::Machine);
    }

    fn error(&mut self, now: Millis, output: &mut Output, error: &ErrorStatus<'_>) {
        let (code, motor) = (error.error_code, error.motor_address);
        output.event(Event::Error(code, motor));
        if code == ErrorCode::LOCKED_OUT {
            if matches!(self.state, State::AwaitMotorInfo | State::AwaitGuid | State::AwaitSoftware | State::Ready) {
                self.lock(output);
            }
            return;
        }
        if code.resets_axis() {
            self.motors.lost_range(motor);
            output.event(Event::MotorChanged(motor));
        }
        self.calibration.error(output, code, motor);
        if self.tracker.error(output, code) {
            self.stop_move(now, output);
            self.raise_fence(now, output);
        }
    }
}
