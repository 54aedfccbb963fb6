//! Lint of messages of the master: the rules for each message.

use motion_core::lint::{Findings as _, Lints};
use motion_core::wire::Messages;

use super::{Context, Rules};
use crate::frame::Selector;
use crate::message::HostMessage;
use crate::query::DelayUnit;

impl HostMessage<'_> {
    /// Findings about this message: what a node would refuse or misread, and what a careful master would not send.
    ///
    /// There are no findings about messages of the constructors, if the context allows them, except two warnings: of
    /// every [`Noop`](crate::message::Noop), and of every [`MotorResetLimits`](crate::message::MotorResetLimits).
    #[must_use]
    pub fn lint(&self, context: &Context) -> Lints {
        if let Self::Other(other) = self {
            // A message without a type may have the bytes of a known command.
            let (selector, parameters) = Selector::from_number(other.id()).split(other.payload());
            let known = Self::decode_body(selector.number(), parameters);
            if let Some(known) = known.ok().filter(|known| !matches!(known, Self::Other(_))) {
                return known.lint(context);
            }
        }
        let mut rules = Rules::new(context);
        rules.joystick(self.selector());
        rules.running(self.selector());
        rules.main(self);
        rules.motor(self);
        rules.camera(self);
        rules.all(self);
        rules.found
    }
}

impl Rules<'_> {
    /// Sections 2.1 and 2.2.
    fn main(&mut self, message: &HostMessage<'_>) {
        let profile = self.context.profile;
        match message {
            HostMessage::SetTimingMaster(message) => self.yes_or_no("timing_master", message.timing_master),
            HostMessage::SetName(message) => self.name(&message.name),
            HostMessage::SetAddress(message) => self.new_address(message.new_address),
            HostMessage::SetCommonLine(message) => self.found.range("common_line", message.common_line.0, 0, 2),
            HostMessage::SetMaxStepRate(message) => {
                self.max_step_rate(message.max_step_rate);
                self.has(profile.has_max_step_rate());
            }
            HostMessage::MaxStepRate(_) => self.has(profile.has_max_step_rate()),
            HostMessage::SetInputEdge(message) => self.ignored("edge", message.edge.name()),
            HostMessage::SetAltModes(message) => {
                self.found.named("ring", message.ring.0, message.ring.name());
                self.found.named("tip", message.tip.0, message.tip.name());
            }
            HostMessage::SetManualMove(message) => self.yes_or_no("manual_move", message.manual_move),
            HostMessage::SetOutLevel(message) => self.found.range("level", message.level.0, 0, 1),
            HostMessage::SetMaxRunTime(message) => self.arrives("max_run_time", message.max_run_time.0),
            HostMessage::SetStartDelay(message) => {
                self.arrives("start_delay", message.start_delay.0);
                if profile.start_delay() != Some(DelayUnit::Milliseconds) {
                    self.delay_in_seconds(message.start_delay);
                }
            }
            HostMessage::SetProgramMode(message) => {
                self.found.named("program_mode", message.program_mode.0, message.program_mode.name());
            }
            HostMessage::SetJoystickMode(message) => self.yes_or_no("joystick_mode", message.joystick_mode),
            HostMessage::SetPingPong(message) => self.yes_or_no("ping_pong", message.ping_pong),
            HostMessage::PingPong(_) => self.has(profile.has_ping_pong_query()),
            _ => {}
        }
    }

    /// Section 2.3.
    fn motor(&mut self, message: &HostMessage<'_>) {
        let profile = self.context.profile;
        match message {
            HostMessage::MotorSetSleep(message) => self.yes_or_no("sleep", message.sleep),
            HostMessage::MotorSetEnable(message) => self.yes_or_no("enable", message.enable),
            HostMessage::MotorSetMicrostep(message) => self.ignored("microstep", message.microstep.name()),
            HostMessage::MotorSetMaxStepSpeed(message) => self.max_step_speed(message.max_step_speed),
            HostMessage::MotorSetDirection(message) => self.direction(message.direction),
            HostMessage::MotorSetContinuousSpeed(message) => self.speed(message.speed),
            HostMessage::MotorSetContinuousAcceleration(message) => {
                self.found.finite("acceleration", message.acceleration.0);
            }
            HostMessage::MotorMove(message) => self.motion(*message),
            HostMessage::MotorRun(message) => {
                self.direction(message.direction);
                self.still(message.motor);
            }
            HostMessage::MotorSetEasing(message) => self.found.range("easing", message.easing.0, 1, 3),
            HostMessage::MotorSetLeadIn(_) => self.width(profile.reads_long_lead_in().map(|is_long| !is_long)),
            HostMessage::MotorSetLeadInLong(message) => {
                self.arrives("lead_in", message.lead_in.0);
                self.width(profile.reads_long_lead_in());
            }
            HostMessage::MotorSetTravel(message) => self.arrives("travel", message.travel.0),
            HostMessage::MotorSetProgramAcceleration(message) => self.arrives("acceleration", message.acceleration.0),
            HostMessage::MotorSetProgramDeceleration(message) => self.arrives("deceleration", message.deceleration.0),
            HostMessage::MotorStepForward(_) | HostMessage::MotorStepBack(_) => self.step(profile.has_steps()),
            HostMessage::MotorSendHome(_) | HostMessage::MotorSendToStart(_) | HostMessage::MotorSendToStop(_) => {
                self.sends(profile.sends_at_full_speed());
            }
            HostMessage::MotorSendToEnd(_) => {
                self.sends(profile.sends_at_full_speed());
                self.limits(profile.holds_limits());
            }
            HostMessage::MotorSetEndHere(_) => self.limits(profile.holds_limits()),
            HostMessage::MotorResetLimits(_) => self.warning("motor", "the motor has no limits from then on"),
            HostMessage::MotorMaxProgramSpeed(_) => self.has(profile.has_sleep_query()),
            _ => {}
        }
    }

    /// Section 2.4.
    fn camera(&mut self, message: &HostMessage<'_>) {
        match message {
            HostMessage::CameraSetEnable(message) => self.yes_or_no("enable", message.enable),
            HostMessage::CameraSetExposureTime(message) => self.arrives("exposure_time", message.exposure_time.0),
            HostMessage::CameraSetFocusWithShutter(message) => {
                self.yes_or_no("focus_with_shutter", message.focus_with_shutter);
            }
            HostMessage::CameraSetMirrorUp(message) => self.yes_or_no("mirror_up", message.mirror_up),
            HostMessage::CameraSetInterval(message) => self.arrives("interval", message.interval.0),
            _ => {}
        }
    }

    /// Broadcasts, the core protocol, and messages without a type. Sections 1 and 2.5.
    fn all(&mut self, message: &HostMessage<'_>) {
        match message {
            HostMessage::Noop(_) => self.noop(),
            HostMessage::BroadcastStart(message) => self.broadcast(message.sub_address),
            HostMessage::BroadcastStop(message) => self.broadcast(message.sub_address),
            HostMessage::BroadcastPause(message) => self.broadcast(message.sub_address),
            HostMessage::BroadcastAssignAddress(message) => {
                self.broadcast(message.sub_address);
                self.new_address(message.new_address);
            }
            HostMessage::CoreAssignAddress(message) => self.new_address(message.new_address),
            HostMessage::Other(other) => self.other(other),
            _ => {}
        }
    }
}
