//! Answers of a node to queries. Source: hoot, sections 2.2 to 2.4.

use motion_core::time::Millis;

use super::link::Outcome;
use super::request::Response;
use super::{DeviceMachine, ProgramState, command};
use crate::frame::Selector;
use crate::message::{EasingFound, Motor, RunState, ValueType};

impl<const QUIRKS: bool> DeviceMachine<QUIRKS> {
    /// Answers a query. One query changes something: that the power was off is answered once.
    pub(super) fn ask(&mut self, now: Millis, query: Selector) -> Outcome {
        let outcome = self.value(now, query);
        if let (0, command::PowerCycled) = (query.sub_address, query.command) {
            self.power_cycled = false;
        }
        outcome
    }

    /// Answer to a query, under the type of the profile.
    pub(super) fn value(&self, now: Millis, query: Selector) -> Outcome {
        let profile = self.options.profile();
        let value = match query.sub_address {
            0 => match query.command {
                command::Name => return Outcome::Answered(Response::text(&self.name.0)),
                command::MaxStepRate if profile.has_max_step_rate() == Some(false) => None,
                command::JoystickMode if profile.has_joystick_mode() == Some(false) => None,
                command::PingPong if profile.has_ping_pong_query() == Some(false) => None,
                command => self.of_controller(now, command),
            },
            4 => self.of_camera(query.command),
            motor => match query.command {
                // Firmware that does not answer by it whether the motor sleeps refuses it.
                command::MotorMaxProgramSpeed if profile.query_117() != ValueType::BYTE => return Outcome::ERROR,
                command => self.of_motor(Motor::new(motor).unwrap_or_default(), command),
            },
        };
        let value_type = command::form_of(query).of(profile);
        value.map_or(Outcome::Unknown, |value| Outcome::Answered(Response::number(value_type, value)))
    }

    fn of_controller(&self, now: Millis, query: u8) -> Option<u32> {
        let controller = &self.controller;
        Some(match query {
            command::FirmwareVersion => self.options.version().0,
            command::RunStatus => self.run_state().0.into(),
            command::RunTime => u32::try_from(self.run_time_told(now)).unwrap_or(u32::MAX),
            command::Exposing => self.camera.is_busy().into(),
            command::TimingMaster => (controller.timing_master || self.has_firmware_settings()).into(),
            command::MaxStepRate => controller.max_step_rate.0.into(),
            command::Voltage => bits(self.supply.0.0.0),
            command::Current => bits(self.supply.1.0.0),
            command::InputEdge => controller.edge_found().0.into(),
            command::AltModes => pair(controller.alt_modes.ring.0, controller.alt_modes.tip.0),
            command::LimitSwitches => pair(self.limits.ring.0, self.limits.tip.0),
            command::OutBeforeDelay => controller.out_before.delay.0.into(),
            command::OutAfterDelay => controller.out_after.delay.0.into(),
            command::OutBeforeTime => controller.out_before.time.0.into(),
            command::OutAfterTime => controller.out_after.time.0.into(),
            command::OutLevel => controller.out_level.0.into(),
            command::StartDelay => controller.start_delay.0,
            command::ProgramMode => controller.program_mode.0.into(),
            command::PowerCycled => self.power_cycled.into(),
            command::JoystickMode => controller.joystick_mode.into(),
            command::PingPong => controller.ping_pong.into(),
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

    fn of_motor(&self, motor: Motor, query: u8) -> Option<u32> {
        let unit = self.motor(motor);
        let set = unit.settings();
        Some(match query {
            command::MotorEnable => {
                let is_told = self.has_firmware_settings() && self.options.profile().has_true_bytes() == Some(true);
                if is_told { set.enable.0.into() } else { set.enable.get().into() }
            }
            command::MotorBacklash => set.backlash.0.into(),
            command::MotorMicrostep => set.microstep.0.into(),
            command::MotorDirection => set.direction.0.into(),
            command::MotorMaxStepSpeed => set.max_step_speed.0.into(),
            command::MotorEndLimit => bits(set.end_limit.0),
            command::MotorPosition => bits(unit.position.0),
            command::MotorRunning => unit.is_moving().into(),
            command::MotorContinuousSpeed => bits(self.hundredths(self.speed_told(unit))),
            command::MotorContinuousAcceleration => bits(self.hundredths(set.acceleration.0)),
            command::MotorEasing => EasingFound::from(set.plan.easing).0.into(),
            command::MotorProgramStart => bits(set.plan.start.0),
            command::MotorProgramStop => bits(set.plan.stop.0),
            command::MotorTravel => set.plan.travel.0,
            command::MotorLeadIn => set.lead_in.0,
            command::MotorProgramAcceleration => set.plan.acceleration.0,
            command::MotorProgramDeceleration => set.plan.deceleration.0,
            command::MotorMaxProgramSpeed => set.sleep.into(),
            _ => return None,
        })
    }

    fn of_camera(&self, query: u8) -> Option<u32> {
        let set = self.camera.settings();
        Some(match query {
            command::CameraEnable => set.enable.into(),
            command::CameraExposing => self.camera.is_busy().into(),
            command::CameraExposureTime => set.exposure_time.0,
            command::CameraFocusTime => set.focus_time.0.into(),
            command::CameraMaxShots => set.max_shots.0.into(),
            command::CameraExposureDelay => set.exposure_delay.0.into(),
            command::CameraFocusWithShutter => set.focus_with_shutter.into(),
            command::CameraMirrorUp => set.mirror_up.into(),
            command::CameraInterval => set.interval.0,
            _ => return None,
        })
    }
}

/// The same bits, without sign.
const fn bits(number: i32) -> u32 {
    u32::from_ne_bytes(number.to_ne_bytes())
}

/// Values of ring and tip as one number.
const fn pair(ring: u8, tip: u8) -> u32 {
    u32::from_be_bytes([0, 0, ring, tip])
}
