//! Commands to the controller, a motor and the camera. Source: hoot, sections 2.1, 2.3 and 2.4.

use motion_core::time::Millis;

use super::firmware::taken_acceleration;
use super::link::Outcome;
use super::{DeviceMachine, Event, Motion, Output, Part, Quirks, StoredName};
use crate::message::{
    CommonLine, Direction, HostMessage, Level, MAX_ARRIVING, Motor, ProgramMode, Span, StartDelay, StepRate, Steps,
};
use crate::query::Profile;

/// The step rates that firmware takes. Source: hoot, section 2.1, command 11.
const STEP_RATES: [u16; 5] = [1000, 2000, 4000, 5000, 10_000];

impl DeviceMachine {
    /// The part of a number of 32 bits that arrives, if the number is not refused (safety decision 3).
    fn arriving(&self, number: u32) -> Option<u32> {
        if self.options.quirks().contains(Quirks::DROPS_TOP_BYTE) {
            Some(number & MAX_ARRIVING)
        } else {
            Some(number).filter(|&number| number <= MAX_ARRIVING)
        }
    }

    /// Carries out a command to the controller, 2 to 24.
    pub(super) fn set_controller(
        &mut self,
        now: Millis,
        output: &mut Output<'_>,
        message: &HostMessage<'_>,
    ) -> Outcome {
        let profile = self.options.profile();
        match message {
            HostMessage::Start(_) => {
                self.start(now, output);
                return Outcome::OK;
            }
            HostMessage::Pause(_) => {
                self.pause(now, output);
                return Outcome::OK;
            }
            HostMessage::Stop(_) => {
                self.stop(now, output);
                return Outcome::OK;
            }
            HostMessage::ReturnHome(_) => {
                self.return_home(now, output);
                return Outcome::OK;
            }
            HostMessage::ToggleDebugLed(_) => {
                output.event(Event::DebugLed);
                return Outcome::OK;
            }
            HostMessage::SetAddress(set) if set.new_address.is_node() => {
                self.move_to(output, set.new_address);
                return Outcome::OK;
            }
            HostMessage::SetAddress(_) => return Outcome::ERROR,
            HostMessage::SetCommonLine(set) if set.common_line > CommonLine::SECOND => return Outcome::RefusedThenOk,
            HostMessage::SetOutLevel(set) if set.level > Level::HIGH => return Outcome::ERROR,
            HostMessage::SetJoystickMode(_) | HostMessage::SetPingPong(_)
                if profile.has_joystick_mode() == Some(false) =>
            {
                return Outcome::Unknown;
            }
            HostMessage::SetMaxStepRate(_) if profile.has_max_step_rate() == Some(false) => return Outcome::Unknown,
            _ => {}
        }
        self.keep(message).map_or(Outcome::Unknown, |taken| {
            if let HostMessage::SetJoystickMode(set) = message {
                self.joystick_changed(output, set.joystick_mode.get());
            }
            if taken {
                output.event(Event::Set(Part::Controller));
            }
            Outcome::ok_if(taken)
        })
    }

    /// Keeps a setting of the controller, and returns whether it could; `None` if the message is no setting.
    fn keep(&mut self, message: &HostMessage<'_>) -> Option<bool> {
        let arriving = |number| self.arriving(number);
        match message {
            HostMessage::SetMaxRunTime(set) => {
                let Some(number) = arriving(set.max_run_time.0) else { return Some(false) };
                self.controller.max_run_time.0 = number;
                return Some(true);
            }
            HostMessage::SetStartDelay(set) => {
                let Some(number) = arriving(set.start_delay.0) else { return Some(false) };
                self.controller.start_delay = self.taken_delay(StartDelay(number));
                return Some(true);
            }
            _ => {}
        }
        let takes = if self.has_firmware_settings() { Some(self.options.profile()) } else { None };
        let is = |fact: fn(Profile) -> Option<bool>, holds| takes.and_then(fact) == Some(holds);
        let controller = &mut self.controller;
        match message {
            HostMessage::SetProgramMode(set) if is(Profile::has_video_mode, false) => {
                controller.program_mode = ProgramMode(set.program_mode.0.min(1));
            }
            HostMessage::SetPingPong(set) if set.ping_pong.0 > 1 && is(Profile::ignores_wrong_ping_pong, true) => {}
            HostMessage::SetTimingMaster(set) => controller.timing_master = set.timing_master.get(),
            HostMessage::SetName(set) => self.name = StoredName::from(&set.name),
            HostMessage::SetCommonLine(set) => controller.common_line = set.common_line,
            HostMessage::SetMaxStepRate(set) if STEP_RATES.contains(&set.max_step_rate.0) => {
                controller.max_step_rate = set.max_step_rate;
            }
            HostMessage::SetInputEdge(set) if set.edge.name().is_some() => controller.edge = set.edge,
            // Acknowledged and ignored, as by firmware.
            HostMessage::SetMaxStepRate(_) | HostMessage::SetInputEdge(_) => {}
            HostMessage::SetAltModes(set) => {
                (controller.alt_modes.ring, controller.alt_modes.tip) = (set.ring, set.tip);
            }
            HostMessage::SetManualMove(set) => controller.manual_move = set.manual_move.get(),
            HostMessage::SetOutBeforeDelay(set) => controller.out_before.delay = set.delay,
            HostMessage::SetOutAfterDelay(set) => controller.out_after.delay = set.delay,
            HostMessage::SetOutBeforeTime(set) => controller.out_before.time = set.time,
            HostMessage::SetOutAfterTime(set) => controller.out_after.time = set.time,
            HostMessage::SetOutLevel(set) => controller.out_level = set.level,
            HostMessage::SetProgramMode(set) => controller.program_mode = set.program_mode,
            HostMessage::SetJoystickMode(set) => controller.joystick_mode = set.joystick_mode.get(),
            HostMessage::SetPingPong(set) => controller.ping_pong = set.ping_pong.get(),
            _ => return None,
        }
        Some(true)
    }

    /// Sends all motors home. A program would move them too, so it pauses first (decision H-3).
    fn return_home(&mut self, now: Millis, output: &mut Output<'_>) {
        self.pause(now, output);
        for motor in &mut self.motors {
            motor.go(output, Motion::To(Steps(0)));
        }
    }

    /// Carries out a command to a motor, 2 to 27.
    pub(super) fn set_motor(&mut self, now: Millis, output: &mut Output<'_>, message: &HostMessage<'_>) -> Outcome {
        let Some(motor) = Motor::new(message.selector().sub_address) else { return Outcome::ERROR };
        let profile = self.options.profile();
        let max_rate = self.controller.max_step_rate;
        let is_silent_at_speed = self.is_silent_at_speed();
        let is_firmware = self.has_firmware_settings();
        let speed = match message {
            HostMessage::MotorSetContinuousSpeed(set) if is_firmware => self.taken_speed(set.speed),
            HostMessage::MotorSetContinuousSpeed(set) if set.speed.0.abs() <= f32::from(max_rate.0) => Some(set.speed),
            _ => None,
        };
        if let Some(span) = span(message) {
            return self.set_span(output, motor, message, span);
        }
        let is_sent = matches!(
            message,
            HostMessage::MotorSendHome(_)
                | HostMessage::MotorSendToEnd(_)
                | HostMessage::MotorSendToStart(_)
                | HostMessage::MotorSendToStop(_)
        );
        if is_sent && !self.before_send(output, motor, message) {
            return Outcome::OK;
        }
        let starts = self.speeds_start_motors();
        let needs_speed = self.options.quirks().contains(Quirks::FIRMWARE_DIRECTIONS);
        let steps = if let HostMessage::MotorMove(go) = message { self.arriving(go.steps.0) } else { None };
        let unit = self.motor_mut(motor);
        match message {
            HostMessage::MotorStop(_) => {
                unit.stop(output);
                // The program would move it again (decision H-30).
                if self.program.is_going() {
                    self.pause(now, output);
                }
            }
            HostMessage::MotorMove(go) => match steps {
                Some(0) if needs_speed && unit.settings.speed.0 == 0.0 => {}
                Some(0) => unit.run(output, go.direction),
                Some(steps) => unit.go(output, Motion::By { direction: go.direction, steps: steps.into() }),
                None => return Outcome::ERROR,
            },
            HostMessage::MotorRun(_) if needs_speed && unit.settings.speed.0 == 0.0 => {}
            HostMessage::MotorRun(run) => unit.run(output, run.direction),
            HostMessage::MotorSendHome(_) => unit.go(output, Motion::To(Steps(0))),
            HostMessage::MotorSendToEnd(_) if unit.settings.end_limit.0 == 0 => {}
            HostMessage::MotorSendToEnd(_) => unit.go(output, Motion::To(unit.settings.end_limit)),
            HostMessage::MotorSendToStart(_) => unit.go(output, Motion::To(unit.settings.plan.start)),
            HostMessage::MotorSendToStop(_) => unit.go(output, Motion::To(unit.settings.plan.stop)),
            // Later firmware sets the lead-out to the missing number, which is 0.
            HostMessage::MotorStepForward(_) if profile.has_steps() == Some(false) => {}
            HostMessage::MotorStepBack(_) if profile.has_steps() == Some(false) => return Outcome::Unknown,
            HostMessage::MotorStepForward(_) => return Outcome::ok_if(unit.single_step(output, true)),
            HostMessage::MotorStepBack(_) => return Outcome::ok_if(unit.single_step(output, false)),
            HostMessage::MotorSetContinuousSpeed(_) => {
                let before = unit.settings.speed.0;
                if let Some(speed) = speed {
                    unit.set_speed(output, speed);
                    if starts && before.abs() < 1.0 && speed.0.abs() > 1.0 {
                        unit.run(output, Direction((speed.0 > 0.0).into()));
                    }
                }
                if is_silent_at_speed {
                    return Outcome::Silent;
                }
            }
            HostMessage::MotorSetEasing(set) if set.easing.name().is_none() => return Outcome::RefusedThenOk,
            _ => {
                if !self.keep_of_motor(output, motor, max_rate, message) {
                    return Outcome::Unknown;
                }
                output.event(Event::Set(Part::Motor(motor)));
            }
        }
        Outcome::OK
    }

    /// Keeps a setting of a motor, and returns whether the message is one.
    fn keep_of_motor(
        &mut self,
        output: &mut Output<'_>,
        motor: Motor,
        max: StepRate,
        message: &HostMessage<'_>,
    ) -> bool {
        let is_firmware = self.has_firmware_settings();
        let has_bools = is_firmware && self.options.profile().has_true_bytes() == Some(false);
        let unit = self.motor_mut(motor);
        match message {
            HostMessage::MotorSetSleep(set) => unit.set_sleep(output, set.sleep.get()),
            HostMessage::MotorSetEnable(set) => unit.set_enable(output, set.enable),
            HostMessage::MotorSetBacklash(set) => unit.settings.backlash = set.backlash,
            HostMessage::MotorSetMicrostep(set) => unit.set_microstep(output, set.microstep),
            HostMessage::MotorSetMaxStepSpeed(set) => {
                if set.max_step_speed.0 != 0 && set.max_step_speed <= max {
                    unit.settings.max_step_speed = set.max_step_speed;
                }
            }
            HostMessage::MotorSetDirection(set) if has_bools => {
                unit.settings.direction = Direction(set.direction.0.min(1));
            }
            HostMessage::MotorSetDirection(set) => unit.settings.direction = set.direction,
            HostMessage::MotorSetHomeHere(_) => unit.set_home(output),
            HostMessage::MotorSetEndHere(_) => unit.settings.end_limit = unit.position,
            HostMessage::MotorResetLimits(_) => unit.reset_limits(output),
            HostMessage::MotorSetContinuousAcceleration(set) if is_firmware => {
                unit.settings.acceleration = taken_acceleration(set.acceleration, unit.settings.acceleration);
            }
            HostMessage::MotorSetContinuousAcceleration(set) => {
                if set.acceleration.0.is_finite() {
                    unit.settings.acceleration = set.acceleration;
                }
            }
            HostMessage::MotorSetProgramStart(set) => unit.settings.plan.start = set.position,
            HostMessage::MotorSetProgramStop(set) => unit.settings.plan.stop = set.position,
            HostMessage::MotorSetEasing(set) => unit.settings.plan.easing = set.easing,
            _ => return false,
        }
        true
    }

    fn set_span(&mut self, output: &mut Output<'_>, motor: Motor, message: &HostMessage<'_>, span: u32) -> Outcome {
        let Some(span) = self.arriving(span) else { return Outcome::ERROR };
        let is_lead_in = matches!(message, HostMessage::MotorSetLeadIn(_) | HostMessage::MotorSetLeadInLong(_));
        let cuts = is_lead_in && self.has_firmware_settings() && self.options.profile().cuts_lead_in() == Some(true);
        let span = Span(if cuts { span & 0xFFFF } else { span });
        let settings = &mut self.motor_mut(motor).settings;
        match message {
            HostMessage::MotorSetTravel(_) => settings.plan.travel = span,
            HostMessage::MotorSetProgramAcceleration(_) => settings.plan.acceleration = span,
            HostMessage::MotorSetProgramDeceleration(_) => settings.plan.deceleration = span,
            _ => settings.lead_in = span,
        }
        output.event(Event::Set(Part::Motor(motor)));
        Outcome::OK
    }

    /// Carries out a command to the camera, 2 to 10.
    pub(super) fn set_camera(&mut self, now: Millis, output: &mut Output<'_>, message: &HostMessage<'_>) -> Outcome {
        let long = match message {
            HostMessage::CameraSetExposureTime(set) => self.arriving(set.exposure_time.0),
            HostMessage::CameraSetInterval(set) => self.arriving(set.interval.0),
            _ => Some(0),
        };
        let Some(long) = long else { return Outcome::ERROR };
        let settings = &mut self.camera.settings;
        match message {
            HostMessage::CameraExpose(_) if self.options.quirks().contains(Quirks::EXPOSES_ALWAYS) => {
                if self.options.profile().exposes_on_command() != Some(false) {
                    self.camera.expose_bare(now, output);
                }
                return Outcome::OK;
            }
            HostMessage::CameraExpose(_) => {
                self.camera.expose(now, output, false);
                return Outcome::OK;
            }
            HostMessage::CameraSetEnable(set) => {
                settings.enable = set.enable.get();
                if !set.enable.get() {
                    self.camera.stop(output);
                }
            }
            HostMessage::CameraSetExposureTime(_) => settings.exposure_time.0 = long,
            HostMessage::CameraSetInterval(_) => settings.interval.0 = long,
            HostMessage::CameraSetFocusTime(set) => settings.focus_time = set.focus_time,
            HostMessage::CameraSetMaxShots(set) => settings.max_shots = set.max_shots,
            HostMessage::CameraSetExposureDelay(set) => settings.exposure_delay = set.exposure_delay,
            HostMessage::CameraSetFocusWithShutter(set) => settings.focus_with_shutter = set.focus_with_shutter.get(),
            HostMessage::CameraSetMirrorUp(set) => settings.mirror_up = set.mirror_up.get(),
            _ => return Outcome::Unknown,
        }
        output.event(Event::Set(Part::Camera));
        Outcome::OK
    }
}

/// Number of a message that sets a part of the planned move.
fn span(message: &HostMessage<'_>) -> Option<u32> {
    Some(match message {
        HostMessage::MotorSetLeadIn(set) => set.lead_in.0.into(),
        HostMessage::MotorSetLeadInLong(set) => set.lead_in.0,
        HostMessage::MotorSetTravel(set) => set.travel.0,
        HostMessage::MotorSetProgramAcceleration(set) => set.acceleration.0,
        HostMessage::MotorSetProgramDeceleration(set) => set.deceleration.0,
        _ => return None,
    })
}
