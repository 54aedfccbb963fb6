//! Commands to the controller, a motor and the camera. Source: hoot, sections 2.1, 2.3 and 2.4.

use motion_core::time::Millis;
use motion_core::wire::Bool;

use super::firmware::taken_acceleration;
use super::link::Outcome;
use super::request::Request;
use super::{DeviceMachine, Effects, Event, Motion, Part, Quirks, command};
use crate::message::{
    CommonLine, Direction, Easing, Edge, Level, MAX_ARRIVING, Motor, ProgramMode, Span, StartDelay, StepRate, Steps,
    StepsPerSecond,
};
use crate::query::Profile;

/// The step rates that firmware takes. Source: hoot, section 2.1, command 11.
const STEP_RATES: [u16; 5] = [1000, 2000, 4000, 5000, 10_000];

impl<const QUIRKS: bool> DeviceMachine<QUIRKS> {
    /// The part of a number of 32 bits that arrives, if the number is not refused (safety decision 3).
    fn arriving(&self, number: u32) -> Option<u32> {
        if self.has_quirk(Quirks::DROPS_TOP_BYTE) {
            Some(number & MAX_ARRIVING)
        } else {
            Some(number).filter(|&number| number <= MAX_ARRIVING)
        }
    }

    /// Carries out a command to the controller, 2 to 24.
    pub(super) fn set_controller(&mut self, now: Millis, output: &mut Effects, request: &Request) -> Outcome {
        let profile = self.options.profile();
        match request.selector.command {
            command::Start => self.start(now, output),
            command::Pause => self.pause(now, output),
            command::Stop => self.stop(now, output),
            command::ReturnHome => self.return_home(now, output),
            command::ToggleDebugLed => output.event(Event::DebugLed),
            command::SetAddress => return Outcome::ok_if(self.move_to(output, request.get())),
            command::SetCommonLine if request.get::<CommonLine>() > CommonLine::SECOND => {
                return Outcome::RefusedThenOk;
            }
            command::SetOutLevel if request.get::<Level>() > Level::HIGH => return Outcome::ERROR,
            command::SetJoystickMode | command::SetPingPong if profile.has_joystick_mode() == Some(false) => {
                return Outcome::Unknown;
            }
            command::SetMaxStepRate if profile.has_max_step_rate() == Some(false) => return Outcome::Unknown,
            _ => return self.keep(output, request),
        }
        Outcome::OK
    }

    /// Keeps a setting of the controller.
    fn keep(&mut self, output: &mut Effects, request: &Request) -> Outcome {
        let number = self.arriving(request.get());
        let takes = if self.has_firmware_settings() { Some(self.options.profile()) } else { None };
        let is = |fact: fn(Profile) -> Option<bool>, holds| takes.and_then(fact) == Some(holds);
        let byte: u8 = request.get();
        let controller = &mut self.controller;
        match request.selector.command {
            command::SetMaxRunTime => match number {
                Some(number) => controller.max_run_time.0 = number,
                None => return Outcome::ERROR,
            },
            command::SetStartDelay => match number {
                Some(number) => self.controller.start_delay = self.taken_delay(StartDelay(number)),
                None => return Outcome::ERROR,
            },
            command::SetProgramMode if is(Profile::has_video_mode, false) => {
                controller.program_mode = ProgramMode(byte.min(1));
            }
            command::SetPingPong if byte > 1 && is(Profile::ignores_wrong_ping_pong, true) => {}
            command::SetTimingMaster => controller.timing_master = byte != 0,
            command::SetName => self.name = request.name(),
            command::SetCommonLine => controller.common_line = request.get(),
            // Other step rates and edges are acknowledged and ignored, as by firmware.
            command::SetMaxStepRate => {
                if STEP_RATES.contains(&request.get()) {
                    controller.max_step_rate = request.get();
                }
            }
            command::SetInputEdge => {
                if request.get::<Edge>().name().is_some() {
                    controller.edge = request.get();
                }
            }
            command::SetAltModes => (controller.alt_modes.ring, controller.alt_modes.tip) = request.pair(),
            command::SetManualMove => controller.manual_move = byte != 0,
            command::SetOutBeforeDelay => controller.out_before.delay = request.get(),
            command::SetOutAfterDelay => controller.out_after.delay = request.get(),
            command::SetOutBeforeTime => controller.out_before.time = request.get(),
            command::SetOutAfterTime => controller.out_after.time = request.get(),
            command::SetOutLevel => controller.out_level = request.get(),
            command::SetProgramMode => controller.program_mode = request.get(),
            command::SetJoystickMode => {
                controller.joystick_mode = byte != 0;
                self.joystick_changed(output, byte != 0);
            }
            command::SetPingPong => controller.ping_pong = byte != 0,
            _ => return Outcome::Unknown,
        }
        output.event(Event::Set(Part::Controller));
        Outcome::OK
    }

    /// Sends all motors home. A program would move them too, so it pauses first (decision H-3).
    fn return_home(&mut self, now: Millis, output: &mut Effects) {
        self.pause(now, output);
        for motor in &mut self.motors {
            motor.go(output, Motion::To(Steps(0)));
        }
    }

    /// Carries out a command to a motor, 2 to 27.
    pub(super) fn set_motor(&mut self, now: Millis, output: &mut Effects, request: &Request) -> Outcome {
        let Some(motor) = Motor::new(request.selector.sub_address) else { return Outcome::ERROR };
        let command = request.selector.command;
        let profile = self.options.profile();
        let is_sent = matches!(
            command,
            command::MotorSendHome | command::MotorSendToEnd | command::MotorSendToStart | command::MotorSendToStop
        );
        if is_sent && !self.before_send(output, motor, command) {
            return Outcome::OK;
        }
        match command {
            command::MotorSetLeadIn
            | command::MotorSetTravel
            | command::MotorSetProgramAcceleration
            | command::MotorSetProgramDeceleration => return self.set_span(output, motor, request),
            command::MotorMove => return self.move_or_run(output, motor, request),
            command::MotorSetContinuousSpeed => return self.set_speed(output, motor, request.get()),
            _ => {}
        }
        let unit = self.motor_mut(motor);
        match command {
            command::MotorStop => {
                unit.stop(output);
                // The program would move it again (decision H-30).
                if self.program.is_going() {
                    self.pause(now, output);
                }
            }
            command::MotorSendHome => unit.go(output, Motion::To(Steps(0))),
            command::MotorSendToEnd if unit.settings.end_limit.0 == 0 => {}
            command::MotorSendToEnd => unit.go(output, Motion::To(unit.settings.end_limit)),
            command::MotorSendToStart => unit.go(output, Motion::To(unit.settings.plan.start)),
            command::MotorSendToStop => unit.go(output, Motion::To(unit.settings.plan.stop)),
            // Later firmware sets the lead-out to the missing number, which is 0.
            command::MotorStepForward if profile.has_steps() == Some(false) => {}
            command::MotorStepBack if profile.has_steps() == Some(false) => return Outcome::Unknown,
            command::MotorStepForward => return Outcome::ok_if(unit.single_step(output, true)),
            command::MotorStepBack => return Outcome::ok_if(unit.single_step(output, false)),
            command::MotorSetEasing if request.get::<Easing>().name().is_none() => return Outcome::RefusedThenOk,
            _ => {
                if !self.keep_of_motor(output, motor, request) {
                    return Outcome::Unknown;
                }
                output.event(Event::Set(Part::Motor(motor)));
            }
        }
        Outcome::OK
    }

    /// Moves a motor by a number of steps, or runs it if the number is 0.
    fn move_or_run(&mut self, output: &mut Effects, motor: Motor, request: &Request) -> Outcome {
        let is_whole = request.has(5) || self.has_quirk(Quirks::SHORT_MOVES);
        let needs_speed = self.has_quirk(Quirks::FIRMWARE_DIRECTIONS);
        let (direction, steps) = request.pair();
        let Some(steps) = self.arriving(steps).filter(|_| is_whole) else { return Outcome::ERROR };
        let unit = self.motor_mut(motor);
        if steps > 0 {
            unit.go(output, Motion::By { direction, steps: steps.into() });
        } else if !needs_speed || unit.settings.speed.0 != 0.0 {
            unit.run(output, direction);
        }
        Outcome::OK
    }

    /// Sets the speed of runs.
    fn set_speed(&mut self, output: &mut Effects, motor: Motor, set: StepsPerSecond) -> Outcome {
        let speed = if self.has_firmware_settings() {
            self.taken_speed(set)
        } else {
            Some(set).filter(|set| set.0.abs() <= f32::from(self.controller.max_step_rate.0))
        };
        let starts = self.speeds_start_motors();
        let is_silent = self.is_silent_at_speed();
        let unit = self.motor_mut(motor);
        let before = unit.settings.speed.0;
        if let Some(speed) = speed {
            unit.set_speed(output, speed);
            if starts && before.abs() < 1.0 && speed.0.abs() > 1.0 {
                unit.run(output, Direction((speed.0 > 0.0).into()));
            }
        }
        if is_silent { Outcome::Silent } else { Outcome::OK }
    }

    /// Keeps a setting of a motor, and returns whether the message is one.
    fn keep_of_motor(&mut self, output: &mut Effects, motor: Motor, request: &Request) -> bool {
        let max = self.controller.max_step_rate;
        let is_firmware = self.has_firmware_settings();
        let has_bools = is_firmware && self.options.profile().has_true_bytes() == Some(false);
        let unit = self.motor_mut(motor);
        let settings = &mut unit.settings;
        match request.selector.command {
            command::MotorSetSleep => unit.set_sleep(output, request.get::<Bool>().get()),
            command::MotorSetEnable => unit.set_enable(output, request.get()),
            command::MotorSetBacklash => settings.backlash = request.get(),
            command::MotorSetMicrostep => unit.set_microstep(output, request.get()),
            command::MotorSetMaxStepSpeed => {
                let speed: StepRate = request.get();
                if speed.0 != 0 && speed <= max {
                    settings.max_step_speed = speed;
                }
            }
            command::MotorSetDirection => {
                let Direction(direction) = request.get();
                settings.direction = Direction(if has_bools { direction.min(1) } else { direction });
            }
            command::MotorSetHomeHere => unit.set_home(output),
            command::MotorSetEndHere => settings.end_limit = unit.position,
            command::MotorResetLimits => unit.reset_limits(output),
            command::MotorSetContinuousAcceleration => {
                let set = request.get();
                if is_firmware {
                    settings.acceleration = taken_acceleration(set, settings.acceleration);
                } else if set.0.is_finite() {
                    settings.acceleration = set;
                }
            }
            command::MotorSetProgramStart => settings.plan.start = request.get(),
            command::MotorSetProgramStop => settings.plan.stop = request.get(),
            command::MotorSetEasing => settings.plan.easing = request.get(),
            _ => return false,
        }
        true
    }

    fn set_span(&mut self, output: &mut Effects, motor: Motor, request: &Request) -> Outcome {
        let command = request.selector.command;
        let is_lead_in = command == command::MotorSetLeadIn;
        // The lead-in has two lengths, and each firmware reads one of them.
        let is_short = is_lead_in && !self.reads_long_lead_in();
        let span = if is_short { request.get::<u16>().into() } else { request.get() };
        let Some(span) = self.arriving(span) else { return Outcome::ERROR };
        let cuts = is_lead_in && self.has_firmware_settings() && self.options.profile().cuts_lead_in() == Some(true);
        let settings = &mut self.motor_mut(motor).settings;
        *match command {
            command::MotorSetTravel => &mut settings.plan.travel,
            command::MotorSetProgramAcceleration => &mut settings.plan.acceleration,
            command::MotorSetProgramDeceleration => &mut settings.plan.deceleration,
            _ => &mut settings.lead_in,
        } = Span(if cuts { span & 0xFFFF } else { span });
        output.event(Event::Set(Part::Motor(motor)));
        Outcome::OK
    }

    /// Carries out a command to the camera, 2 to 10.
    pub(super) fn set_camera(&mut self, now: Millis, output: &mut Effects, request: &Request) -> Outcome {
        let number = self.arriving(request.get());
        let byte: u8 = request.get();
        let settings = &mut self.camera.settings;
        match request.selector.command {
            command::CameraExpose => {
                if !self.has_quirk(Quirks::EXPOSES_ALWAYS) {
                    self.camera.expose(now, output, false);
                } else if self.options.profile().exposes_on_command() != Some(false) {
                    self.camera.expose_bare(now, output);
                }
                return Outcome::OK;
            }
            command::CameraSetEnable => {
                settings.enable = byte != 0;
                if byte == 0 {
                    self.camera.stop(output);
                }
            }
            command::CameraSetExposureTime | command::CameraSetInterval => {
                let Some(number) = number else { return Outcome::ERROR };
                let is_interval = request.selector.command == command::CameraSetInterval;
                (if is_interval { &mut settings.interval } else { &mut settings.exposure_time }).0 = number;
            }
            command::CameraSetFocusTime => settings.focus_time = request.get(),
            command::CameraSetMaxShots => settings.max_shots = request.get(),
            command::CameraSetExposureDelay => settings.exposure_delay = request.get(),
            command::CameraSetFocusWithShutter => settings.focus_with_shutter = byte != 0,
            command::CameraSetMirrorUp => settings.mirror_up = byte != 0,
            _ => return Outcome::Unknown,
        }
        output.event(Event::Set(Part::Camera));
        Outcome::OK
    }
}
