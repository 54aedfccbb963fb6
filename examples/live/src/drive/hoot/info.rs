//! Command that prints the state of a node.

use hoot_proto::HostMessage;
use hoot_proto::message::{
    self, Current, FirmwareVersion, JoystickMode, Motor, MotorContinuousSpeed, MotorEnable, MotorEndLimit,
    MotorMicrostep, NameQuery, ProgramModeQuery, RunStatus, Steps, Voltage,
};
use hoot_proto::query::AnyReply;
use motion_core::wire::Bool;

use super::talk::Talk;
use crate::drive::Trouble;

impl Talk<'_> {
    pub(super) async fn info(&mut self) -> Result<(), Trouble> {
        let node = self.node.0;
        let joystick = JoystickMode {};
        if self.ask(HostMessage::JoystickMode(joystick)).await?.read(&joystick).is_some_and(Bool::get) {
            return self.say(&format!("node {node}: it is in joystick mode, so nothing more can be read"));
        }
        let version = self.ask(HostMessage::FirmwareVersion(FirmwareVersion {})).await?;
        let name = self.ask(HostMessage::Name(NameQuery {})).await?;
        let name = match name.answer() {
            Some(AnyReply::Name(name)) => name.to_string().trim_matches('"').trim().to_owned(),
            _ => String::new(),
        };
        let version = version.read(&FirmwareVersion {}).unwrap_or_default();
        self.say(&format!("node {node}: {name}, firmware {version}"))?;
        let [volts, amperes] = [HostMessage::Voltage(Voltage {}), HostMessage::Current(Current {})];
        let (volts, amperes) = (self.ask(volts).await?, self.ask(amperes).await?);
        let profile = self.session.host().profile(self.node);
        if let (Some(volts), Some(amperes)) = (volts.answer(), amperes.answer())
            && volts.is_reliable(profile)
            && amperes.is_reliable(profile)
        {
            self.say(&format!("supply: {volts} V, {amperes} A"))?;
        }
        let (status, mode) = (RunStatus {}, ProgramModeQuery {});
        let status = self.ask(HostMessage::RunStatus(status)).await?.read(&status);
        let mode = self.ask(HostMessage::ProgramMode(mode)).await?.read(&mode);
        let state = match status.and_then(|status| status.is_running(profile)) {
            Some(true) => "runs",
            Some(false) => "does not run",
            None => "runs or is paused",
        };
        let mode = mode.map(|mode| mode.to_string()).unwrap_or_default();
        self.say(&format!("program: {mode}, {state}"))?;
        for motor in Motor::ALL {
            self.info_of(motor).await?;
        }
        Ok(())
    }

    async fn info_of(&mut self, motor: Motor) -> Result<(), Trouble> {
        let position = self.position(motor).await?;
        let moves = if self.is_running(motor).await? { "moves" } else { "rests" };
        let (enable, microstep, end) = (MotorEnable { motor }, MotorMicrostep { motor }, MotorEndLimit { motor });
        let enable = self.ask(HostMessage::MotorEnable(enable)).await?.read(&enable);
        let microstep = self.ask(HostMessage::MotorMicrostep(microstep)).await?.read(&microstep);
        let end = self.ask(HostMessage::MotorEndLimit(end)).await?.read(&end);
        let enabled = if enable.is_some_and(Bool::get) { "" } else { ", switched off" };
        let end = match end {
            Some(Steps(0)) | None => "no end limit".to_owned(),
            Some(end) => format!("end limit {end}"),
        };
        let microstep = microstep.unwrap_or(message::Microstep(0)).0;
        let speed = MotorContinuousSpeed { motor };
        let speed = self.ask(HostMessage::MotorContinuousSpeed(speed)).await?;
        let is_reliable = |speed: &AnyReply<'_>| speed.is_reliable(self.session.host().profile(self.node));
        let speed = speed.answer().filter(is_reliable).map(|speed| format!(", {speed} steps/s"));
        let speed = speed.unwrap_or_default();
        self.say(&format!("motor {motor}: at {position}, {moves}{enabled}; {microstep} microsteps, {end}{speed}"))
    }
}
