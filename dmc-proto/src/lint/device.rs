//! Findings about messages of a device.

use motion_core::lint::{Findings, Lints};
use motion_core::wire::Messages;

use super::{Context, MAX_CHANNELS, MAX_MOTORS, MAX_PINS, PROTOCOL_VERSION, Rules, number};
use crate::message::{
    Ack, AckCode, Capabilities, DeviceMessage, HardStop, Hi, Motor, MotorPositions, MotorStatus, Motors, StopReason,
    Triggers,
};

impl DeviceMessage<'_> {
    /// Finds errors, which a strict host would refuse, and warnings, which a careful device would not send.
    ///
    /// Messages with legal values that fit the greeting of the device have no findings.
    #[must_use]
    pub fn lint(&self, context: &Context<'_>) -> Lints {
        let mut rules = Rules::<Lints>::new(context);
        rules.data(self.body_len());
        match self {
            Self::Hi(message) => rules.hi(message),
            Self::GioIn(message) => {
                let known: Triggers = (1..=rules.input_count()).collect();
                rules.found.reserved("triggers", message.triggers.0, !known.0);
            }
            Self::MotorStatus(message) => rules.motor_status(message),
            Self::MotorMove(message) => rules.yes_or_no("moving", message.moving),
            Self::MotorGetPosition(message) => rules.motor_positions(message),
            Self::MotorHardStop(message) => rules.hard_stop(message),
            Self::RtGo(_) | Self::RtEnd(_) => {}
            Self::VirtGetPosition(message) => {
                rules.yes_or_no("aim_enabled", message.aim_enabled.unwrap_or_default());
                if message.aim_enabled.is_some() && !rules.may(Capabilities::AIM) {
                    rules.warning("aim_enabled", "the device does not claim that it can aim");
                }
            }
            Self::VirtAimPoint(message) => {
                rules.yes_or_no("enable", message.enable);
                if !rules.may(Capabilities::AIM) {
                    rules.warning("enable", "the device does not claim that it can aim");
                }
            }
            Self::Ack(message) => rules.ack(message),
            Self::Other(_) => rules.unknown(self.kind()),
        }
        if !matches!(self, Self::Ack(_)) {
            rules.tail(self);
        }
        rules.found
    }
}

impl<F: Findings> Rules<'_, F> {
    /// Decisions D-43 to D-47.
    fn hi(&mut self, message: &Hi<'_>) {
        if message.name.as_str().is_none() {
            self.warning("name", "is not UTF-8");
        }
        self.found.range("motor_count", message.motor_count, 0, MAX_MOTORS);
        self.found.range("dmx_count", message.dmx_count, 0, MAX_CHANNELS);
        self.found.range("gio_out_count", message.gio_out_count, 0, MAX_PINS);
        self.found.range("gio_in_count", message.gio_in_count, 0, MAX_PINS);
        self.found.range("hw_limit_count", message.hw_limit_count, 0, MAX_PINS);
        if message.capabilities.intersects(Capabilities::VIRTUALS)
            && !message.capabilities.contains(Capabilities::VIRTUALS)
        {
            self.warning(
                "capabilities",
                "Dragonframe was seen to use virtual motors only if the device claims all four kinds",
            );
        }
        self.bits("capabilities", message.capabilities);
        if let Some(version) = message.protocol_version.filter(|&version| version != PROTOCOL_VERSION) {
            self.found.named("protocol_version", version, None);
        }
    }

    fn motor_status(&mut self, message: &MotorStatus<'_>) {
        let known: Motors = (1..=self.motor_count()).map(Motor).collect();
        self.found.reserved("motor_status", message.motor_status.0, !known.0);
        self.yes_or_no("dmx_status", message.dmx_status);
    }

    fn motor_positions(&mut self, message: &MotorPositions<'_>) {
        let least = if self.context.device.is_some() { self.motor_count() } else { 0 };
        self.found.range("positions", number(message.positions.len()), least, self.motor_count());
    }

    /// Decision D-20.
    fn hard_stop(&mut self, message: &HardStop<'_>) {
        self.found.named("reason", message.reason.0, message.reason.name());
        match (message.reason, message.motor) {
            (StopReason::UPPER_LIMIT | StopReason::LOWER_LIMIT, None) => {
                self.error("motor", "absent, although a limit belongs to a motor");
            }
            (StopReason::EMERGENCY_STOP, Some(_)) => {
                self.warning("motor", "present, although an emergency stop concerns all motors");
            }
            (_, Some(motor)) => self.motor(motor),
            (_, None) => {}
        }
    }

    /// Safety decision 10, decisions D-6 and D-7.
    fn ack(&mut self, message: &Ack<'_>) {
        match message.response_code {
            None => self.error("response_code", "absent"),
            Some(AckCode::ERR_AIM_COD) => self.error("response_code", "not in the specification; send ERR_RANGE"),
            Some(code) => self.found.named("response_code", code.0, code.name()),
        }
        // The vendor's firmware sends a code of four bytes, whose upper two bytes are zero, and hosts accept it.
        if !matches!(message.tail, [0, 0]) {
            self.found.tail(message.tail);
        }
    }
}
