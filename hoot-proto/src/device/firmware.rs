//! Settings as firmware has them: those of a new node, and how they are read back. Only nodes with
//! [`Quirks::FIRMWARE_SETTINGS`] have them. Source: what firmware with motors answered (decision H-62).

use motion_core::time::Millis;

use super::motor::Limits;
use super::{AltOut, DeviceMachine, Effects, MotorState, MotorUnit, Quirks, command};
use crate::message::{
    Backlash, Easing, Level, Microstep, Milliseconds, Motor, ProgramMode, ShortMilliseconds, StartDelay, StepRate,
    StepsPerSecond, StepsPerSecondSquared,
};
use crate::query::{DelayUnit, Profile};

impl<const QUIRKS: bool> DeviceMachine<QUIRKS> {
    pub(super) const fn has_firmware_settings(&self) -> bool {
        self.has_quirk(Quirks::FIRMWARE_SETTINGS)
    }

    /// Takes the settings of a new node with this firmware.
    pub(super) fn take_first_settings(&mut self) {
        let profile = self.options.profile();
        let out = AltOut { delay: ShortMilliseconds(100), time: ShortMilliseconds(1000) };
        (self.controller.out_before, self.controller.out_after) = (out, out);
        self.controller.out_level = Level::HIGH;
        let camera = &mut self.camera.settings;
        (camera.exposure_time, camera.interval) = (Milliseconds(120), Milliseconds(1));
        camera.focus_with_shutter = profile.first_focus_with_shutter();
        for unit in &mut self.motors {
            let settings = &mut unit.settings;
            settings.sleep = profile.first_sleep();
            settings.backlash = Backlash(profile.first_backlash());
            settings.microstep = profile.first_microstep(unit.motor);
            settings.max_step_speed = StepRate(profile.first_max_speed());
            settings.speed = StepsPerSecond(profile.first_speed());
            settings.acceleration = StepsPerSecondSquared(profile.first_acceleration());
            settings.plan.easing = Easing::QUADRATIC;
            if profile.first_enable() {
                settings.enable = true.into();
                unit.state = MotorState::Idle;
            }
        }
    }

    /// Number of hundredths that the node answers. Firmware multiplies an IEEE number, and truncates the product towards zero
    /// (hoot, section 1.2). The answer is garbage from firmware that sends the lower half of an IEEE number.
    pub(super) fn hundredths(&self, number: f32) -> i32 {
        let profile = self.options.profile();
        let is_garbage = profile.float_is_true() == Some(false) && profile.has_long_hundredths() == Some(false);
        if self.has_firmware_settings() && is_garbage {
            let [_, _, high, low] = number.to_be_bytes();
            let half = i32::from(u16::from_be_bytes([high, low]));
            return if number.is_sign_negative() { half.saturating_sub(0x1_0000) } else { half };
        }
        let product = number * 100.0;
        if self.has_firmware_settings() && product.abs() >= 4_294_967_296.0 {
            return 0;
        }
        #[expect(
            clippy::cast_possible_truncation,
            reason = "it is meant to be truncated, and a number that is too great becomes the greatest one"
        )]
        let cut = product as i32;
        cut
    }

    /// Speed of runs that firmware takes for a speed that a master sets; `None` if it ignores that.
    pub(super) fn taken_speed(&self, StepsPerSecond(speed): StepsPerSecond) -> Option<StepsPerSecond> {
        let profile = self.options.profile();
        let max = f32::from(self.controller.max_step_rate.0);
        let min = if profile.takes_negative_speeds() == Some(false) { 0.0 } else { -max };
        // NaN is below nothing and above nothing, and firmware takes it.
        if speed > max {
            (profile.caps_speeds() == Some(true)).then_some(StepsPerSecond(max))
        } else if speed < min {
            None
        } else {
            Some(StepsPerSecond(speed))
        }
    }

    /// Delay before the start, as firmware keeps it: seconds are multiplied by 1000 in 32 bits, and the rest is lost.
    pub(super) fn taken_delay(&self, StartDelay(delay): StartDelay) -> StartDelay {
        let in_seconds = self.options.profile().start_delay() == Some(DelayUnit::Seconds);
        if self.has_firmware_settings() && in_seconds {
            StartDelay(delay.wrapping_mul(1000) / 1000)
        } else {
            StartDelay(delay)
        }
    }

    /// Run time that the node answers. Later firmware keeps that of the last program.
    pub(super) fn run_time_told(&self, now: Millis) -> u64 {
        let keeps = self.copies(Quirks::FIRMWARE_SETTINGS, Profile::keeps_run_time);
        match self.program.run_time(now) {
            0 if keeps => self.program.last_run_time(),
            run_time => run_time,
        }
    }

    /// Speed that the node answers: that of the moment, or the setting.
    pub(super) fn speed_told(&self, unit: &MotorUnit) -> f32 {
        let is_momentary = self.options.profile().answers_momentary_speed() == Some(true);
        if self.has_firmware_settings() && is_momentary && !unit.is_moving() { 0.0 } else { unit.settings.speed.0 }
    }
}

/// Motion as firmware makes it. Each part needs its quirk. Source: firmware with motors (decision H-65).
impl<const QUIRKS: bool> DeviceMachine<QUIRKS> {
    pub(super) fn copies(&self, quirk: Quirks, fact: fn(Profile) -> Option<bool>) -> bool {
        self.has_quirk(quirk) && fact(self.options.profile()) == Some(true)
    }

    /// Limits that stop motors.
    pub(super) fn limits_held(&self) -> Limits {
        match self.options.profile().holds_limits() {
            _ if !self.has_quirk(Quirks::FIRMWARE_LIMITS) => Limits::End,
            Some(false) => Limits::None,
            _ => Limits::EndAndHome,
        }
    }

    /// Does what firmware does before it sends a motor to a position: it sets speed and microsteps. Returns whether it sends
    /// the motor.
    pub(super) fn before_send(&mut self, output: &mut Effects, motor: Motor, command: u8) -> bool {
        let profile = self.options.profile();
        if command == command::MotorSendHome && self.copies(Quirks::SENDS_FAST, Profile::ignores_home) {
            return false;
        }
        let is_fast = self.copies(Quirks::SENDS_FAST, Profile::sends_at_full_speed);
        let is_coarse = self.copies(Quirks::CHANGES_MICROSTEPS, Profile::sends_in_quarter_steps);
        let unit = self.motor_mut(motor);
        if is_fast {
            let most = if profile.max_speed_limits() == Some(true) { unit.settings.max_step_speed.0 } else { 5000 };
            unit.settings.speed = StepsPerSecond(most.into());
        }
        if is_coarse {
            let before = unit.settings.microstep;
            unit.set_microstep(output, Microstep::QUARTER);
            unit.restores = (profile.restores_microsteps() == Some(true)).then_some(before);
        }
        !(command == command::MotorSendToEnd && matches!(self.limits_held(), Limits::None))
    }

    /// Does what firmware does when joystick mode begins or ends.
    pub(super) fn joystick_changed(&mut self, output: &mut Effects, on: bool) {
        if on && self.copies(Quirks::JOYSTICK_MOVES, Profile::joystick_moves) {
            self.motors.iter_mut().for_each(|motor| motor.set_speed(output, StepsPerSecond(0.0)));
        }
        if !on && self.copies(Quirks::JOYSTICK_MOVES, Profile::joystick_ends_dead_man) {
            self.controller.manual_move = false;
        }
    }

    /// Whether the speed of runs sets motors in motion now.
    pub(super) fn speeds_start_motors(&self) -> bool {
        self.controller.joystick_mode && self.copies(Quirks::JOYSTICK_MOVES, Profile::joystick_moves)
    }

    /// Chooses the microsteps of all motors before a program begins: the finest that the speed of the planned move allows.
    pub(super) fn choose_microsteps(&mut self, output: &mut Effects) {
        if !self.copies(Quirks::CHANGES_MICROSTEPS, Profile::start_sets_microsteps) {
            return;
        }
        let camera = self.camera.settings;
        let busy = [camera.exposure_time.0, camera.focus_time.0.into(), camera.exposure_delay.0.into()];
        let pause = busy.into_iter().fold(camera.interval.0, u32::saturating_sub);
        let is_stepwise = self.controller.program_mode == ProgramMode::SMS;
        let cuts =
            self.controller.program_mode == ProgramMode::VIDEO && self.options.profile().cuts_places() == Some(true);
        for unit in self.motors.iter_mut().filter(|_| cuts) {
            unit.cut_places(output);
        }
        for unit in &mut self.motors {
            let plan = unit.settings.plan;
            // The products fit into 64 bits.
            let distance = u64::from(plan.stop.0.abs_diff(plan.start.0)).wrapping_mul(16_000);
            let ramps = plan.acceleration.0.saturating_add(plan.deceleration.0) / 2;
            let cruise = plan.travel.0.saturating_sub(ramps).max(1);
            let time = if is_stepwise { u64::from(cruise).wrapping_mul(pause.into()) } else { cruise.into() };
            let steps = distance.checked_div(unit.settings.microstep.0.into()).unwrap_or(0);
            let speed = steps.checked_div(time.max(1)).unwrap_or(0);
            match speed {
                0..=4000 => unit.set_microstep(output, Microstep::SIXTEENTH),
                4001..8000 => unit.set_microstep(output, Microstep::EIGHTH),
                8000..16_000 => unit.set_microstep(output, Microstep::QUARTER),
                _ => {}
            }
        }
    }
}

/// Acceleration that firmware takes for one that a master sets. It ignores what is not above 0, and keeps the change of
/// speed in 20 ms, which is rounded.
pub(super) fn taken_acceleration(
    StepsPerSecondSquared(set): StepsPerSecondSquared,
    old: StepsPerSecondSquared,
) -> StepsPerSecondSquared {
    if set <= 0.0 { old } else { StepsPerSecondSquared(set / 50.0 * 50.0) }
}
