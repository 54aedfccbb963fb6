//! Rules for the messages of a host, one by one.

use motion_core::lint::{Findings, Problem, Severity};

use super::host::OLD;
use super::{MAX_MOTORS, PROTOCOL_VERSION, Rules, number};
use crate::message::{
    BloopOutputs, BoomSwingTrack, Capabilities, Degrees, Dmx, FramesPerSecond, JogSpeed, Milliseconds, MotorConfigure,
    MotorFlags, MotorJog, MotorPair, MotorSetLimits, MotorSetSpeed, RigKind, RigMotor, RtRunMove, RtShootFrame,
    RtShootFrame2, RtUploadMoveAxis, RtUploadMoveBegin, RtUploadMoveDmx, RtUploadMoveTriggers, RunFlags, StartIndex,
    Triggers, VirtConfig, VirtJog, VirtJogOnLine, VirtualMotor,
};

impl<F: Findings> Rules<'_, F> {
    /// Decision D-50.
    pub(super) fn dmx(&mut self, message: &Dmx<'_>) {
        let channels = self.channel_count();
        self.yes_or_no("ramp", message.ramp);
        self.found.range("start_channel", message.start_channel.0, 1, channels);
        let room = channels.saturating_sub(message.start_channel.0.saturating_sub(1));
        self.found.range("values", number(message.values.len()), 0, room);
        if message.values.is_empty() {
            self.warning("values", "empty; nothing happens");
        }
    }

    /// Checks that the device has these outputs.
    pub(super) fn outputs(&mut self, what: &'static str, triggers: Triggers) {
        let known: Triggers = (1..=self.output_count()).collect();
        self.found.reserved(what, triggers.0, !known.0);
    }

    /// Requires version 2 of the protocol.
    pub(super) fn version_2(&mut self) {
        if self.context.device.is_some_and(|device| device.protocol_version.unwrap_or(1) < PROTOCOL_VERSION) {
            self.error("protocol_version", OLD);
        }
    }

    /// Decision D-30.
    pub(super) fn motor_jog(&mut self, message: &MotorJog<'_>) {
        self.motor(message.motor);
        self.found.range("speed", message.speed.0.0, JogSpeed::SLOWEST.0.0, JogSpeed::FULL.0.0);
    }

    pub(super) fn motor_configure(&mut self, message: &MotorConfigure<'_>) {
        self.motor(message.motor);
        if message.flags.intersects(MotorFlags::COUPLE | MotorFlags::COUPLE_REVERSE) {
            self.any_of("flags", Capabilities::COUPLE);
            if self.context.device.is_some() && message.motor.0 == self.motor_count() {
                self.warning("flags", "coupled with the next motor, and there is none");
            }
        }
        if message.flags.contains(MotorFlags::COUPLE | MotorFlags::COUPLE_REVERSE) {
            self.warning("flags", "coupled in both directions at once; the vendor's firmware takes the opposite one");
        }
        if message.flags.contains(MotorFlags::VIRTUAL) && !self.may(Capabilities::VIRTUALS) {
            self.warning("flags", "part of a virtual motor, and the device has none");
        }
        self.bits("flags", message.flags);
    }

    pub(super) fn motor_set_speed(&mut self, message: &MotorSetSpeed<'_>) {
        self.motor(message.motor);
        if message.max_velocity.0 == 0 {
            self.warning("max_velocity", "0 is no speed; the vendor's firmware takes 10 steps/s");
        }
        if message.max_accel.0 == 0 {
            self.warning("max_accel", "0 is no acceleration; the vendor's firmware takes half the speed");
        }
    }

    /// Safety decision 8: the limits are compared only if both are enabled.
    pub(super) fn motor_set_limits(&mut self, message: &MotorSetLimits<'_>) {
        self.motor(message.motor);
        self.yes_or_no("lower_enable", message.lower_enable);
        if message.lower_enable.get() && message.upper_enable.get() {
            self.found.range("lower", message.lower.0, i32::MIN, message.upper.0);
        }
        self.yes_or_no("upper_enable", message.upper_enable);
        let sets = self.context.device.map_or(0x7F, |device| device.hw_limit_count);
        self.found.range("hw_set", message.hw_set.number(), 0, sets);
    }

    /// Decision D-31.
    pub(super) fn upload_begin(&mut self, message: &RtUploadMoveBegin<'_>) {
        let (start, end) = (message.start_frame.0, message.end_frame.0);
        let room = self.context.device.map_or(u32::MAX, |device| device.upload_frame_count);
        let last = i64::from(start).saturating_add(room.into()).saturating_sub(1);
        self.found.range("end_frame", end, start, last.min(i32::MAX.into()));
    }

    pub(super) fn upload_axis(&mut self, message: &RtUploadMoveAxis<'_>) {
        self.motor(message.motor);
        self.section(message.start_index, message.positions.len());
        self.whole("positions", message.tail);
    }

    pub(super) fn upload_dmx(&mut self, message: &RtUploadMoveDmx<'_>) {
        let channels = self.channel_count();
        self.some("dmx_count", channels);
        if channels > 0 {
            self.found.range("channel", message.channel.0, 1, channels);
        }
        self.section(message.start_index, message.levels.len());
    }

    /// Safety decision 6, decision D-33.
    pub(super) fn upload_triggers(&mut self, message: &RtUploadMoveTriggers<'_>) {
        self.version_2();
        self.outputs("mask", message.mask);
        self.whole("pairs", message.tail);
        for pair in message.pairs {
            if let Some(device) = self.context.device {
                self.found.range("frame", pair.frame(), 0, i64::from(device.upload_frame_count).saturating_sub(1));
            }
            self.found.reserved("values", pair.values().0, !message.mask.0);
            if pair.values() == Triggers::NONE {
                self.warning("values", "no output is on, as at frames that are not named");
            }
        }
    }

    /// Checks a section of `len` values: decisions D-31 and D-32.
    fn section(&mut self, start: StartIndex, len: usize) {
        if let Some(device) = self.context.device {
            let max = i64::from(device.upload_frame_count).saturating_sub(number(len));
            self.found.range("start_index", start.index(), 0, max);
        }
        if len == 0 && !start.is_last() {
            self.warning("start_index", "neither a value nor the last section: nothing happens");
        }
    }

    /// Safety decision 9, decisions D-23, D-24 and D-28.
    pub(super) fn run_move(&mut self, message: &RtRunMove<'_>) {
        let flags = message.flags.unwrap_or_default();
        self.frames_per_second(message.fps_x1000);
        self.yes_or_no("sync_dmx", message.sync_dmx);
        self.found.range("bloop_dmx_channel", message.bloop_dmx_channel.0, 0, self.channel_count());
        self.bloop(message.bloop_location);
        if flags.intersects(RunFlags::PING_PONG | RunFlags::LOOP) {
            self.any_of("flags", Capabilities::LOOP);
        }
        if flags.intersects(RunFlags::CAMERA_START_STOP | RunFlags::CAMERA_EVERY_FRAME) {
            self.any_of("flags", Capabilities::CAMERA_TRIGGER);
        }
        if flags.contains(RunFlags::PING_PONG | RunFlags::LOOP) {
            self.warning("flags", "ping-pong and loop at once; ping-pong wins");
        }
        self.bits("flags", flags);
        if message.flags.is_some() && !self.may(Capabilities::LOOP | Capabilities::CAMERA_TRIGGER) {
            self.warning("flags", "the device expects a shorter message, without flags");
        }
        if message.open_angle.is_some() && !self.may(Capabilities::CAMERA_TRIGGER) {
            self.warning("open_angle", "the device expects a shorter message, without angles");
        }
        let (open, close) = (message.open_angle.unwrap_or_default(), message.close_angle.unwrap_or_default());
        // Without the flag, the device does not use the angles.
        if flags.contains(RunFlags::CAMERA_EVERY_FRAME) {
            self.angles(open, close);
        } else if open.0.max(close.0) > 360 {
            self.warning("open_angle", "an angle of more than 360 degrees, which is not used");
        }
        if message.pre_roll_ms.0 == 0 {
            self.warning("pre_roll_ms", "0 leaves no time to reach the speed; the vendor's firmware divides by it");
        }
        if flags.contains(RunFlags::CAMERA_EVERY_FRAME) && open >= close {
            self.warning("open_angle", "the shutter does not open before it closes; the device uses its own angles");
        }
    }

    /// Checks that the device has what marks the first frame. A device ignores what it does not have.
    fn bloop(&mut self, outputs: BloopOutputs) {
        for (output, count) in [(BloopOutputs::LOGIC_OUT, 1), (BloopOutputs::RELAY_OUT, 2)] {
            if outputs.contains(output) && self.output_count() < count {
                self.warning("bloop_location", "an output that the device does not have");
            }
        }
        if outputs.contains(BloopOutputs::DMX) && self.channel_count() == 0 {
            self.warning("bloop_location", "a DMX channel, and the device has none");
        }
    }

    /// Checks the speed, because at 0 no frame would ever come.
    pub(super) fn frames_per_second(&mut self, rate: FramesPerSecond) {
        self.found.range("fps_x1000", rate.0.0, 1, u32::MAX);
    }

    /// Decision D-28.
    fn angles(&mut self, open: Degrees, close: Degrees) {
        self.found.range("open_angle", open.0, 0, 360);
        self.found.range("close_angle", close.0, 0, 360);
    }

    pub(super) fn shoot_frame(&mut self, message: &RtShootFrame<'_>) {
        self.found.named("direction", message.direction.0, message.direction.name());
        self.exposure(message.exposure_ms);
        if message.blur_x10.0.0 > 1000 {
            self.warning("blur_x10", "more than 100 %");
        }
        self.motor_pairs(message.motors, message.tail);
    }

    /// Decisions D-27 and D-28.
    pub(super) fn shoot_frame2(&mut self, message: &RtShootFrame2<'_>) {
        self.exposure(message.exposure_ms);
        self.angles(message.open_angle, message.close_angle);
        self.motor_pairs(message.motors, message.tail);
    }

    fn exposure(&mut self, exposure: Milliseconds) {
        if exposure.0 == 0 {
            self.warning("exposure_ms", "0 is no exposure; the vendor's firmware takes 1000 ms");
        }
    }

    /// Decision D-25: the vendor's firmware writes beyond its memory for a motor that does not exist, and a device answers
    /// an incomplete pair with `ERR_GENERAL`.
    fn motor_pairs(&mut self, motors: &[MotorPair], tail: &[u8]) {
        self.found.range("motors", number(motors.len()), 0, MAX_MOTORS);
        for pair in motors {
            self.motor(pair.motor());
        }
        self.whole("motors", tail);
    }

    /// Requires that the last entry of a list is whole (decision D-89). A device answers `ERR_GENERAL`.
    fn whole(&mut self, what: &'static str, tail: &[u8]) {
        if !tail.is_empty() {
            self.found.push(Severity::Error, what, Problem::Note("the last entry is cut off"));
        }
    }

    /// Safety decision 10, decision D-34.
    pub(super) fn virt_config(&mut self, message: &VirtConfig<'_>) {
        let wanted = match message.kind() {
            RigKind::NONE => Capabilities::VIRTUALS,
            RigKind::BOOM_SWING_TRACK => Capabilities::BOOM_SWING_TRACK,
            RigKind::SWING_PAN => Capabilities::SWING_PAN,
            RigKind::Y_SWING_TRACK => Capabilities::Y_SWING_TRACK,
            RigKind::X_Y_Z => Capabilities::X_Y_Z,
            _ => Capabilities::empty(),
        };
        self.any_of("type", wanted);
        match message {
            VirtConfig::BoomSwingTrack(BoomSwingTrack { rig, .. }) => {
                self.rig_motor("boom_motor", rig.boom_motor);
                self.rig_motor("swing_motor", rig.swing_motor);
                self.rig_motor("track_motor", rig.track_motor);
                self.rig_motor("pan_motor", rig.pan_motor);
                self.rig_motor("tilt_motor", rig.tilt_motor);
                self.rig_motor("roll_motor", rig.roll_motor);
            }
            VirtConfig::SwingPan(rig) => {
                self.rig_motor("swing_motor", rig.swing_motor);
                self.rig_motor("pan_motor", rig.pan_motor);
            }
            VirtConfig::Opaque(rig) if rig.kind().name().is_some() => {
                self.warning("type", "its layout is not published");
            }
            VirtConfig::Opaque(rig) => self.found.named("type", rig.kind().0, None),
            VirtConfig::None(_) => {}
        }
    }

    /// Checks the number of a motor, or 0 for none.
    fn rig_motor(&mut self, what: &'static str, motor: RigMotor) {
        self.found.range(what, motor.0, 0, self.motor_count());
    }

    /// Decision D-38.
    pub(super) fn virtual_motor(&mut self, motor: VirtualMotor) {
        self.found.named("virtual_motor", motor.0, motor.name());
    }

    /// Safety decision 10, decision D-39.
    pub(super) fn virt_jog(&mut self, message: &VirtJog<'_>) {
        self.virtual_motor(message.virtual_motor);
        self.found.range("speed", message.speed.0.0, JogSpeed::SLOWEST.0.0, JogSpeed::FULL.0.0);
        if ![JogSpeed::SLOWEST, JogSpeed::FULL].contains(&message.speed) {
            self.warning("speed", "neither 1 nor 10000, the only speeds that are sent today");
        }
    }

    /// Decision D-40.
    pub(super) fn virt_jog_on_line(&mut self, message: &VirtJogOnLine<'_>) {
        self.found.named("axis", message.axis.0, message.axis.name());
        let full = i64::from(JogSpeed::FULL.0.0);
        self.found.range("speed", message.speed.0.0, full.wrapping_neg(), full);
        if message.speed.0.0 == 0 {
            self.error("speed", "0 is no speed; stop with VirtStop");
        }
    }
}
