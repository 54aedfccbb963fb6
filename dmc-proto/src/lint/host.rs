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
        let mut rules = Rules::<Lints>::new(context);
        rules.data(self.body_len());
        rules.values(self);
        rules.tail(self);
        rules.found
    }

    /// Code with which the device of `context` refuses this message because of its contents; `None` if it does not refuse
    /// it.
    ///
    /// Whether the device can do the request now depends on its state, which is not checked here. A message that cannot be
    /// decoded is answered by `ERR_GENERAL` (decision D-51). An acknowledgement is never answered (decision D-5).
    #[must_use]
    pub fn refusal(&self, context: &Context<'_>) -> Option<AckCode> {
        let is_long = !matches!(self, Self::Other(_)) && self.body_len() > context.max_data;
        if is_long { Some(AckCode::ERR_RANGE) } else { self.refusal_of_values(context) }
    }

    /// Code with which a device refuses this message because of its values. The number of bytes is not checked.
    pub(crate) fn refusal_of_values(&self, context: &Context<'_>) -> Option<AckCode> {
        if let Self::Other(_) = self {
            return (!self.kind().is_ack()).then_some(AckCode::ERR_UNSUPPORTED);
        }
        let mut rules = Rules::<Refusal>::new(context);
        rules.values(self);
        rules.found.0
    }
}

impl<F: Findings> Rules<'_, F> {
    /// Checks the capabilities that a message needs, and its values.
    ///
    /// Bytes after the known fields are not looked for, because that needs the code that prints all fields. A device that only
    /// refuses messages does not link it.
    fn values(&mut self, message: &HostMessage<'_>) {
        self.gate(&gate(message));
        match message {
            HostMessage::Hi(_)
            | HostMessage::GioIn(_)
            | HostMessage::MotorStatus(_)
            | HostMessage::MotorGetPosition(_)
            | HostMessage::RtUploadMoveEnd(_)
            | HostMessage::RtPositionFrame(_)
            | HostMessage::RtGo(_)
            | HostMessage::RtStopLoop(_)
            | HostMessage::VirtGetPosition(_) => {}
            HostMessage::Dmx(it) => self.dmx(it),
            HostMessage::GioOut(it) => self.outputs("triggers", it.triggers),
            HostMessage::GioCam(it) => self.bits("flags", it.flags),
            HostMessage::MotorMove(it) => self.motor(it.motor),
            HostMessage::MotorStop(it) => self.motor(it.motor),
            HostMessage::MotorStopAll(it) => self.bits("flags", it.flags.unwrap_or_default()),
            HostMessage::MotorResetPosition(it) => self.motor(it.motor),
            HostMessage::MotorJog(it) => self.motor_jog(it),
            HostMessage::MotorConfigure(it) => self.motor_configure(it),
            HostMessage::MotorSetSpeed(it) => self.motor_set_speed(it),
            HostMessage::MotorSetLimits(it) => self.motor_set_limits(it),
            HostMessage::RtUploadMoveBegin(it) => self.upload_begin(it),
            HostMessage::RtUploadMoveAxis(it) => self.upload_axis(it),
            HostMessage::RtUploadMoveDmx(it) => self.upload_dmx(it),
            HostMessage::RtUploadMoveTriggers(it) => self.upload_triggers(it),
            HostMessage::RtRunMove(it) => self.run_move(it),
            HostMessage::RtShootFrame(it) => self.shoot_frame(it),
            HostMessage::RtShootFrame2(it) => self.shoot_frame2(it),
            HostMessage::RtJogAll(it) => self.frames_per_second(it.fps_x1000),
            HostMessage::VirtConfig(it) => self.virt_config(it),
            HostMessage::VirtMove(it) => self.virtual_motor(it.virtual_motor),
            HostMessage::VirtStop(it) => self.virtual_motor(it.virtual_motor),
            HostMessage::VirtJog(it) => self.virt_jog(it),
            HostMessage::VirtJogOnLine(it) => self.virt_jog_on_line(it),
            HostMessage::VirtAimPoint(it) => {
                self.version_2();
                self.yes_or_no("enable", it.enable);
            }
            HostMessage::Other(_) if message.kind().is_ack() => {
                self.error("type", "only devices send acknowledgements, and no device answers them");
            }
            HostMessage::Other(_) => self.unknown(message.kind()),
        }
    }

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

/// Code that tells a host of the first error. It keeps no texts, so that a device links none.
#[derive(Default)]
struct Refusal(Option<AckCode>);

impl Findings for Refusal {
    const KEEPS_WARNINGS: bool = false;

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
