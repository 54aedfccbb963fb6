//! Findings about messages of a host.

use motion_core::lint::{Findings, Lints, Problem, Severity};
use motion_core::wire::Messages;

use super::{Context, Rules};
use crate::message::{AckCode, Capabilities, HostMessage};

/// Error of a message for a capability that the device does not have. The device answers `ERR_UNSUPPORTED`.
pub(super) const ABSENT: &str = "the device has none";

/// Error of a message that is newer than the device. The device answers `ERR_UNSUPPORTED`.
pub(super) const OLD: &str = "the device has an older version of the protocol";

/// Property that a device needs for a message.
enum Gate {
    /// None, because every device accepts the message.
    Open,
    /// At least one motor.
    Motors,
    /// At least one DMX channel.
    Channels,
    /// At least one general purpose output.
    Outputs,
    /// At least one general purpose input.
    Inputs,
    /// At least one of these capabilities.
    AnyOf(Capabilities),
}

/// Property that a device needs for a message (decision D-2). Every device accepts stops (safety decision 1).
fn gate(message: &HostMessage<'_>) -> Gate {
    match message {
        HostMessage::Hi(_)
        | HostMessage::GioCam(_)
        | HostMessage::MotorStop(_)
        | HostMessage::MotorStopAll(_)
        | HostMessage::VirtStop(_)
        | HostMessage::Other(_) => Gate::Open,
        HostMessage::Dmx(_) => Gate::Channels,
        HostMessage::GioOut(_) => Gate::Outputs,
        HostMessage::GioIn(_) => Gate::Inputs,
        HostMessage::MotorStatus(_)
        | HostMessage::MotorMove(_)
        | HostMessage::MotorGetPosition(_)
        | HostMessage::MotorResetPosition(_)
        | HostMessage::MotorJog(_)
        | HostMessage::MotorConfigure(_)
        | HostMessage::MotorSetSpeed(_)
        | HostMessage::MotorSetLimits(_) => Gate::Motors,
        HostMessage::RtUploadMoveBegin(_)
        | HostMessage::RtUploadMoveAxis(_)
        | HostMessage::RtUploadMoveDmx(_)
        | HostMessage::RtUploadMoveTriggers(_)
        | HostMessage::RtUploadMoveEnd(_)
        | HostMessage::RtPositionFrame(_)
        | HostMessage::RtRunMove(_)
        | HostMessage::RtJogAll(_) => Gate::AnyOf(Capabilities::REAL_TIME),
        HostMessage::RtShootFrame(_) => Gate::AnyOf(Capabilities::SHOOT_FRAME),
        HostMessage::RtShootFrame2(_) => Gate::AnyOf(Capabilities::SHOOT_FRAME2),
        HostMessage::RtGo(_) => {
            Gate::AnyOf(Capabilities::REAL_TIME.union(Capabilities::SHOOT_FRAME).union(Capabilities::SHOOT_FRAME2))
        }
        HostMessage::RtStopLoop(_) => Gate::AnyOf(Capabilities::LOOP),
        HostMessage::VirtConfig(_)
        | HostMessage::VirtMove(_)
        | HostMessage::VirtJog(_)
        | HostMessage::VirtGetPosition(_)
        | HostMessage::VirtJogOnLine(_) => Gate::AnyOf(Capabilities::VIRTUALS),
        HostMessage::VirtAimPoint(_) => Gate::AnyOf(Capabilities::AIM),
    }
}

impl HostMessage<'_> {
    /// Finds errors, which a strict device would refuse, and warnings, which a careful host would not send.
    ///
    /// Messages with legal values that the device is able to do have no findings.
    #[must_use]
    pub fn lint(&self, context: &Context<'_>) -> Lints {
        let mut rules: Rules<'_> = self.rules(context);
        rules.tail(self);
        rules.found
    }

    /// Finds everything except bytes after the known fields, which are a warning.
    ///
    /// The search for these bytes needs the code that prints all fields. A device that only refuses messages does not link it.
    fn rules<'c, F: Findings + Default>(&self, context: &'c Context<'_>) -> Rules<'c, F> {
        let mut rules = Rules::new(context, self.body_len());
        rules.gate(&gate(self));
        match self {
            Self::Hi(_)
            | Self::GioIn(_)
            | Self::MotorStatus(_)
            | Self::MotorGetPosition(_)
            | Self::RtUploadMoveEnd(_)
            | Self::RtPositionFrame(_)
            | Self::RtGo(_)
            | Self::RtStopLoop(_)
            | Self::VirtGetPosition(_) => {}
            Self::Dmx(message) => rules.dmx(message),
            Self::GioOut(message) => rules.outputs("triggers", message.triggers),
            Self::GioCam(message) => rules.bits("flags", message.flags),
            Self::MotorMove(message) => rules.motor(message.motor),
            Self::MotorStop(message) => rules.motor(message.motor),
            Self::MotorStopAll(message) => rules.bits("flags", message.flags.unwrap_or_default()),
            Self::MotorResetPosition(message) => rules.motor(message.motor),
            Self::MotorJog(message) => rules.motor_jog(message),
            Self::MotorConfigure(message) => rules.motor_configure(message),
            Self::MotorSetSpeed(message) => rules.motor_set_speed(message),
            Self::MotorSetLimits(message) => rules.motor_set_limits(message),
            Self::RtUploadMoveBegin(message) => rules.upload_begin(message),
            Self::RtUploadMoveAxis(message) => rules.upload_axis(message),
            Self::RtUploadMoveDmx(message) => rules.upload_dmx(message),
            Self::RtUploadMoveTriggers(message) => rules.upload_triggers(message),
            Self::RtRunMove(message) => rules.run_move(message),
            Self::RtShootFrame(message) => rules.shoot_frame(message),
            Self::RtShootFrame2(message) => rules.shoot_frame2(message),
            Self::RtJogAll(message) => rules.frames_per_second(message.fps_x1000),
            Self::VirtConfig(message) => rules.virt_config(message),
            Self::VirtMove(message) => rules.virtual_motor(message.virtual_motor),
            Self::VirtStop(message) => rules.virtual_motor(message.virtual_motor),
            Self::VirtJog(message) => rules.virt_jog(message),
            Self::VirtJogOnLine(message) => rules.virt_jog_on_line(message),
            Self::VirtAimPoint(message) => {
                rules.version_2();
                rules.yes_or_no("enable", message.enable);
            }
            Self::Other(_) if self.kind().is_ack() => {
                rules.error("type", "only devices send acknowledgements, and no device answers them");
            }
            Self::Other(_) => rules.unknown(self.kind()),
        }
        rules
    }

    /// Code with which the device of `context` refuses this message because of its contents; `None` if it does not refuse
    /// it.
    ///
    /// Whether the device can do the request now depends on its state, which is not checked here. A message that cannot be
    /// decoded is answered by `ERR_GENERAL` (decision D-51). An acknowledgement is never answered (decision D-5).
    #[must_use]
    pub fn refusal(&self, context: &Context<'_>) -> Option<AckCode> {
        match self {
            Self::Other(_) if self.kind().is_ack() => None,
            Self::Other(_) => Some(AckCode::ERR_UNSUPPORTED),
            _ => self.rules::<Refusal>(context).found.0,
        }
    }
}

/// Code that tells a host of the first error. It keeps no texts, so that a device links none.
#[derive(Default)]
struct Refusal(Option<AckCode>);

impl Findings for Refusal {
    #[inline]
    fn push(&mut self, severity: Severity, _: &'static str, problem: Problem) {
        if severity == Severity::Error {
            self.0.get_or_insert(match problem {
                Problem::Range { .. } => AckCode::ERR_RANGE,
                Problem::Note(ABSENT | OLD) => AckCode::ERR_UNSUPPORTED,
                _ => AckCode::ERR_GENERAL,
            });
        }
    }
}

impl<F: Findings> Rules<'_, F> {
    /// Requires the property that the message needs.
    fn gate(&mut self, gate: &Gate) {
        match gate {
            Gate::Open => {}
            Gate::Motors => self.some("motor_count", self.motor_count()),
            Gate::Channels => self.some("dmx_count", self.channel_count()),
            Gate::Outputs => self.some("gio_out_count", self.output_count()),
            Gate::Inputs => self.some("gio_in_count", self.input_count()),
            Gate::AnyOf(capabilities) => self.any_of("capabilities", *capabilities),
        }
    }

    /// Requires that a count is not 0.
    pub(super) fn some(&mut self, what: &'static str, count: impl Into<u32>) {
        if count.into() == 0 {
            self.error(what, ABSENT);
        }
    }

    /// Requires one of these capabilities.
    pub(super) fn any_of(&mut self, what: &'static str, wanted: Capabilities) {
        if !self.may(wanted) {
            self.error(what, ABSENT);
        }
    }

    /// Whether the device has one of these capabilities, as far as is known.
    pub(super) fn may(&self, wanted: Capabilities) -> bool {
        self.context.device.is_none_or(|device| device.capabilities.intersects(wanted))
    }
}
