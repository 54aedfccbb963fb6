//! Command that prints the state of a node.

use hoot_proto::message::{
    Current, FirmwareVersion, Motor, MotorContinuousSpeed, MotorEnable, MotorEndLimit, MotorMicrostep, NameQuery,
    ProgramModeQuery, RunStatus, Steps, Voltage,
};
use hoot_proto::query::AnyReply;

use super::talk::Talk;
use crate::drive::Trouble;
use crate::drive::output::About;

impl Talk<'_> {
    pub(super) async fn info(&mut self) -> Result<(), Trouble> {
        let node = self.node.0;
        if self.is_in_joystick_mode().await? {
            return self.print(&format!("node {node}: it is in joystick mode, so nothing more can be read"));
        }
        let version = self.read(FirmwareVersion {}).await?;
        let name = self.ask(NameQuery {}).await?;
        let name = match name.answer() {
            Some(AnyReply::Name(name)) => name.to_string().trim_matches('"').trim().to_owned(),
            _ => String::new(),
        };
        self.print(&format!("node {node}: {name}, firmware {version}"))?;
        let (volts, amperes) = (self.ask(Voltage {}).await?, self.ask(Current {}).await?);
        let profile = self.profile();
        if let (Some(volts), Some(amperes)) = (volts.answer(), amperes.answer())
            && volts.is_reliable(profile)
            && amperes.is_reliable(profile)
        {
            self.print(&format!("supply: {volts} V, {amperes} A"))?;
        }
        let (status, mode) = (self.read(RunStatus {}).await?, self.read(ProgramModeQuery {}).await?);
        let state = match status.is_running(profile) {
            Some(true) => "runs",
            Some(false) => "does not run",
            None => "runs or is paused",
        };
        self.print(&format!("program: {mode}, {state}"))?;
        for motor in Motor::ALL {
            self.info_of(motor).await?;
        }
        Ok(())
    }

    async fn info_of(&mut self, motor: Motor) -> Result<(), Trouble> {
        let position = self.position(motor).await?;
        let moves = if self.is_running(motor).await? { "moves" } else { "rests" };
        let enabled = if self.read(MotorEnable { motor }).await?.get() { "" } else { ", switched off" };
        let microstep = self.read(MotorMicrostep { motor }).await?.0;
        let end = match self.read(MotorEndLimit { motor }).await? {
            Steps(0) => "no end limit".to_owned(),
            // Later firmware keeps the limit, and does not stop there.
            _ if self.profile().holds_limits() == Some(false) => "no end limit".to_owned(),
            end => format!("end limit {end}"),
        };
        let speed = self.ask(MotorContinuousSpeed { motor }).await?;
        let is_reliable = |speed: &AnyReply<'_>| speed.is_reliable(self.profile());
        let speed = speed.answer().filter(is_reliable).map(|speed| format!(", {speed} steps/s"));
        let speed = speed.unwrap_or_default();
        let about = About::position(motor.get(), position);
        self.line(
            about,
            &format!("motor {motor}: at {position}, {moves}{enabled}; {microstep} microsteps, {end}{speed}"),
        )
    }
}
