//! Answers of a node to queries. Source: hoot, sections 2.2 to 2.4.

use motion_core::fixed::Scaled;
use motion_core::time::Millis;

use super::link::{Outcome, yes};
use super::{Answer, DeviceMachine, ProgramState};
use crate::message::{Acceleration, Milliseconds, RunState, Shots, Speed, SpeedOrSleep, ValueType};
use crate::query::{AnyQuery, AnyReply};

impl DeviceMachine {
    /// Answers a query. One query changes something: that the power was off is answered once.
    pub(super) fn ask(&mut self, now: Millis, query: AnyQuery) -> Outcome {
        let outcome = self.value(now, query);
        if let AnyQuery::PowerCycled(_) = query {
            self.power_cycled = false;
        }
        outcome
    }

    /// Answer to a query, under the type of the profile.
    pub(super) fn value(&self, now: Millis, query: AnyQuery) -> Outcome {
        let profile = self.options.profile();
        match query {
            AnyQuery::Name(_) => return Outcome::Answered(Answer::Name(self.name)),
            AnyQuery::MaxStepRate(_) if profile.has_max_step_rate() == Some(false) => return Outcome::Unknown,
            AnyQuery::JoystickMode(_) if profile.has_joystick_mode() == Some(false) => return Outcome::Unknown,
            AnyQuery::PingPong(_) if profile.has_ping_pong_query() == Some(false) => return Outcome::Unknown,
            // Firmware that does not answer by it whether the motor sleeps refuses it.
            AnyQuery::MotorMaxProgramSpeed(_) if profile.query_117() != ValueType::BYTE => return Outcome::ERROR,
            _ => {}
        }
        let value = self.of_controller(now, query).or_else(|| self.of_motor(query)).or_else(|| self.of_camera(query));
        value.map_or(Outcome::Unknown, |value| Outcome::Answered(Answer::Value(value)))
    }

    fn of_controller(&self, now: Millis, query: AnyQuery) -> Option<AnyReply<'static>> {
        let profile = self.options.profile();
        let controller = &self.controller;
        let run_time = u32::try_from(self.run_time_told(now)).unwrap_or(u32::MAX);
        Some(match query {
            AnyQuery::FirmwareVersion(q) => AnyReply::FirmwareVersion(q.answer(self.options.version(), profile)),
            AnyQuery::RunStatus(q) => AnyReply::RunStatus(q.answer(self.run_state(), profile)),
            AnyQuery::RunTime(q) => AnyReply::RunTime(q.answer(Milliseconds(run_time), profile)),
            AnyQuery::Exposing(q) => AnyReply::Exposing(q.answer(yes(self.camera.is_busy()), profile)),
            AnyQuery::TimingMaster(q) => {
                AnyReply::TimingMaster(q.answer(yes(controller.timing_master || self.has_firmware_settings()), profile))
            }
            AnyQuery::MaxStepRate(q) => AnyReply::MaxStepRate(q.answer(controller.max_step_rate, profile)),
            AnyQuery::Voltage(q) => AnyReply::Voltage(q.answer(self.supply.0, profile)),
            AnyQuery::Current(q) => AnyReply::Current(q.answer(self.supply.1, profile)),
            AnyQuery::InputEdge(q) => AnyReply::InputEdge(q.answer(controller.edge_found(), profile)),
            AnyQuery::AltModes(q) => AnyReply::AltModes(q.answer(controller.alt_modes, profile)),
            AnyQuery::LimitSwitches(q) => AnyReply::LimitSwitches(q.answer(self.limits, profile)),
            AnyQuery::OutBeforeDelay(q) => AnyReply::OutBeforeDelay(q.answer(controller.out_before.delay, profile)),
            AnyQuery::OutAfterDelay(q) => AnyReply::OutAfterDelay(q.answer(controller.out_after.delay, profile)),
            AnyQuery::OutBeforeTime(q) => AnyReply::OutBeforeTime(q.answer(controller.out_before.time, profile)),
            AnyQuery::OutAfterTime(q) => AnyReply::OutAfterTime(q.answer(controller.out_after.time, profile)),
            AnyQuery::OutLevel(q) => AnyReply::OutLevel(q.answer(controller.out_level, profile)),
            AnyQuery::StartDelay(q) => AnyReply::StartDelay(q.answer(controller.start_delay, profile)),
            AnyQuery::ProgramMode(q) => AnyReply::ProgramMode(q.answer(controller.program_mode, profile)),
            AnyQuery::PowerCycled(q) => AnyReply::PowerCycled(q.answer(yes(self.power_cycled), profile)),
            AnyQuery::JoystickMode(q) => AnyReply::JoystickMode(q.answer(yes(controller.joystick_mode), profile)),
            AnyQuery::PingPong(q) => AnyReply::PingPong(q.answer(yes(controller.ping_pong), profile)),
            _ => return None,
        })
    }

    /// Run status in the numbers of the profile. The sheet's firmware answers 0 when the program is paused (hoot, section
    /// 4.2). An unknown firmware counts as a later one (decision H-7).
    fn run_state(&self) -> RunState {
        let is_old = self.options.profile().one_is_paused() == Some(false);
        match self.program.state {
            ProgramState::Stopped => RunState::STOPPED,
            ProgramState::Paused if is_old => RunState::STOPPED,
            ProgramState::Paused => RunState::RUNNING_OR_PAUSED,
            ProgramState::Delay | ProgramState::Running if is_old => RunState::RUNNING_OR_PAUSED,
            ProgramState::Delay => RunState::DELAY,
            ProgramState::Running => RunState::RUNNING,
        }
    }

    fn of_motor(&self, query: AnyQuery) -> Option<AnyReply<'static>> {
        let profile = self.options.profile();
        let of = |motor| self.motor(motor);
        let set = |motor| self.motor(motor).settings();
        Some(match query {
            AnyQuery::MotorEnable(q) => {
                let set = set(q.motor).enable;
                let is_told = self.has_firmware_settings() && profile.has_true_bytes() == Some(true);
                AnyReply::MotorEnable(q.answer(if is_told { set } else { yes(set.get()) }, profile))
            }
            AnyQuery::MotorBacklash(q) => AnyReply::MotorBacklash(q.answer(set(q.motor).backlash, profile)),
            AnyQuery::MotorMicrostep(q) => AnyReply::MotorMicrostep(q.answer(set(q.motor).microstep, profile)),
            AnyQuery::MotorDirection(q) => AnyReply::MotorDirection(q.answer(set(q.motor).direction, profile)),
            AnyQuery::MotorMaxStepSpeed(q) => {
                AnyReply::MotorMaxStepSpeed(q.answer(set(q.motor).max_step_speed, profile))
            }
            AnyQuery::MotorEndLimit(q) => AnyReply::MotorEndLimit(q.answer(set(q.motor).end_limit, profile)),
            AnyQuery::MotorPosition(q) => AnyReply::MotorPosition(q.answer(of(q.motor).position(), profile)),
            AnyQuery::MotorRunning(q) => AnyReply::MotorRunning(q.answer(yes(of(q.motor).is_moving()), profile)),
            AnyQuery::MotorContinuousSpeed(q) => {
                let speed = Speed(Scaled(self.hundredths(self.speed_told(of(q.motor)))));
                AnyReply::MotorContinuousSpeed(q.answer(speed, profile))
            }
            AnyQuery::MotorContinuousAcceleration(q) => {
                let acceleration = Acceleration(Scaled(self.hundredths(set(q.motor).acceleration.0)));
                AnyReply::MotorContinuousAcceleration(q.answer(acceleration, profile))
            }
            AnyQuery::MotorEasing(q) => AnyReply::MotorEasing(q.answer(set(q.motor).plan.easing.into(), profile)),
            AnyQuery::MotorProgramStart(q) => AnyReply::MotorProgramStart(q.answer(set(q.motor).plan.start, profile)),
            AnyQuery::MotorProgramStop(q) => AnyReply::MotorProgramStop(q.answer(set(q.motor).plan.stop, profile)),
            AnyQuery::MotorTravel(q) => AnyReply::MotorTravel(q.answer(set(q.motor).plan.travel, profile)),
            AnyQuery::MotorLeadIn(q) => AnyReply::MotorLeadIn(q.answer(set(q.motor).lead_in, profile)),
            AnyQuery::MotorProgramAcceleration(q) => {
                AnyReply::MotorProgramAcceleration(q.answer(set(q.motor).plan.acceleration, profile))
            }
            AnyQuery::MotorProgramDeceleration(q) => {
                AnyReply::MotorProgramDeceleration(q.answer(set(q.motor).plan.deceleration, profile))
            }
            AnyQuery::MotorMaxProgramSpeed(q) => {
                let sleep = SpeedOrSleep::Sleep(yes(set(q.motor).sleep));
                AnyReply::MotorMaxProgramSpeed(q.answer(sleep, profile))
            }
            _ => return None,
        })
    }

    fn of_camera(&self, query: AnyQuery) -> Option<AnyReply<'static>> {
        let profile = self.options.profile();
        let set = self.camera.settings();
        Some(match query {
            AnyQuery::CameraEnable(q) => AnyReply::CameraEnable(q.answer(yes(set.enable), profile)),
            AnyQuery::CameraExposing(q) => AnyReply::CameraExposing(q.answer(yes(self.camera.is_busy()), profile)),
            AnyQuery::CameraExposureTime(q) => AnyReply::CameraExposureTime(q.answer(set.exposure_time, profile)),
            AnyQuery::CameraFocusTime(q) => AnyReply::CameraFocusTime(q.answer(set.focus_time, profile)),
            AnyQuery::CameraMaxShots(q) => AnyReply::CameraMaxShots(q.answer(Shots(set.max_shots.0.into()), profile)),
            AnyQuery::CameraExposureDelay(q) => AnyReply::CameraExposureDelay(q.answer(set.exposure_delay, profile)),
            AnyQuery::CameraFocusWithShutter(q) => {
                AnyReply::CameraFocusWithShutter(q.answer(yes(set.focus_with_shutter), profile))
            }
            AnyQuery::CameraMirrorUp(q) => AnyReply::CameraMirrorUp(q.answer(yes(set.mirror_up), profile)),
            AnyQuery::CameraInterval(q) => AnyReply::CameraInterval(q.answer(set.interval, profile)),
            _ => return None,
        })
    }
}
