//! Settings as firmware has them: those of a new node, and how they are read back. Only nodes with
//! [`Quirks::FIRMWARE_SETTINGS`] have them. Source: what firmware with motors answered (decision H-62).

use super::{AltOut, DeviceMachine, MotorState, MotorUnit, Quirks};
use crate::message::{
    Backlash, Easing, Level, Microstep, Milliseconds, Motor, ShortMilliseconds, StartDelay, StepRate, StepsPerSecond,
    StepsPerSecondSquared,
};
use crate::query::DelayUnit;

impl DeviceMachine {
    pub(super) const fn has_firmware_settings(&self) -> bool {
        self.options.quirks().contains(Quirks::FIRMWARE_SETTINGS)
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
            if unit.motor != Motor::One {
                settings.microstep = Microstep(profile.first_microstep());
            }
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

    /// Speed that the node answers: that of the moment, or the setting.
    pub(super) fn speed_told(&self, unit: &MotorUnit) -> f32 {
        let is_momentary = self.options.profile().answers_momentary_speed() == Some(true);
        if self.has_firmware_settings() && is_momentary && !unit.is_moving() { 0.0 } else { unit.settings.speed.0 }
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
