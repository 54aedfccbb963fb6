//! Checks of the messages that a client sends.

use motion_core::lint::{Findings as _, Lints, Severity};

use super::{Context, address, common, not_negative, password, trajectory, unknown, yes_or_no, zero};
use crate::HostMessage;
use crate::message::{
    AxisKind, BumpPositionSpeedAcceleration, DevicePassword, JOG_DISTANCE, Motor, MotorAddress, PlaybackDirection,
    Rotations, RotationsPerSecond, RotationsPerSecondSquared, Seconds, SetPositionSpeedAcceleration, TakePicture,
    UserPassword,
};

impl HostMessage<'_> {
    /// Findings about the message: what a strict device would refuse, or a careful client would not send.
    ///
    /// A stop has an error only if its address is wrong. The other fields of a stop give warnings at most, because they
    /// must not be a reason to let the motor run on (safety decision 3).
    #[must_use]
    pub fn lint(&self, context: &Context<'_>) -> Lints {
        let mut lints = Lints::new();
        let mut non_finite = Severity::Error;
        match self {
            Self::GetNetworkInfo(message) => {
                if let Some(limited) = message.limited_response {
                    yes_or_no(&mut lints, "limited_response", limited);
                }
            }
            Self::SetLEDStatus(message) => {
                lints.named("master_status", message.master_status.0, message.master_status.name());
                lints.named("slave_status", message.slave_status.0, message.slave_status.name());
            }
            Self::SetUserPassword(UserPassword { password: given, .. })
            | Self::SetDevicePassword(DevicePassword { password: given, .. }) => {
                let ascii = if context.counts_bytes { Severity::Warning } else { Severity::Error };
                password(&mut lints, "password", *given, ascii);
            }
            Self::SetTrajectoryData(message) => trajectory::check(&mut lints, context, message),
            Self::ResetAxis(message) => {
                motor(&mut lints, context, message.motor_address, MotorAddress::ALL.0);
            }
            Self::MarkBeginPosition(message) => {
                motor(&mut lints, context, message.motor_address, 1);
            }
            Self::MarkEndPosition(message) => {
                motor(&mut lints, context, message.motor_address, 1);
            }
            Self::StartPlayback(message) => playback(&mut lints, message.direction, message.start_time),
            Self::SetupPlayback(message) => {
                playback(&mut lints, message.direction, message.start_time);
                yes_or_no(&mut lints, "delay_return", message.delay_return);
            }
            Self::TakePicture(message) => take_picture(&mut lints, message),
            Self::SetPositionSpeedAcceleration(message) if message.is_stop() => {
                non_finite = Severity::Warning;
                stop(&mut lints, context, message.motor_address, message.acceleration);
            }
            Self::SetPositionSpeedAcceleration(message) => go_to(&mut lints, context, message),
            Self::BumpPositionSpeedAcceleration(message) if message.is_stop() => {
                non_finite = Severity::Warning;
                stop(&mut lints, context, message.motor_address, message.acceleration);
            }
            Self::BumpPositionSpeedAcceleration(message) => bump(&mut lints, context, message),
            Self::Other(other) => unknown(&mut lints, other),
            Self::KeepAlive(_)
            | Self::GetLEDStatus(_)
            | Self::GetMotorInfo(_)
            | Self::GetDeviceInfo(_)
            | Self::GetTrajectoryData(_)
            | Self::GetDeviceGUID(_)
            | Self::GetSoftwareID(_)
            | Self::SetSoftwareID(_)
            | Self::ResetDevice(_)
            | Self::StopPlayback(_)
            | Self::RapidToFirstKeyFrame(_) => {}
        }
        common(&mut lints, self, non_finite);
        lints
    }
}

/// Checks the address of the motor of a command (decisions K-M1 and K-M2), and returns the motor if it is known.
fn motor<'a>(lints: &mut Lints, context: &Context<'a>, motor: MotorAddress, least: u8) -> Option<&'a Motor> {
    address(lints, motor, least);
    lints.reserved("motor_address", motor.0, !MotorAddress(u8::MAX).number());
    let known = context.motor(motor);
    if known.is_none() && !context.motors.is_empty() && motor.number() != MotorAddress::ALL.0 {
        lints.note(Severity::Error, "motor_address", "is not the address of a motor of the device");
    }
    known
}

/// Checks the fields of a playback that should be 0, because their other values are not specified (decision K-J7).
fn playback(lints: &mut Lints, direction: PlaybackDirection, start_time: Seconds) {
    zero(lints, "direction", direction.0);
    not_negative(lints, "start_time", start_time.0);
    if start_time.0 > 0.0 {
        lints.note(Severity::Warning, "start_time", "should be 0");
    }
}

fn take_picture(lints: &mut Lints, message: &TakePicture<'_>) {
    address(lints, message.motor_address, MotorAddress::ALL.0);
    if message.motor_address != MotorAddress::ALL {
        lints.note(Severity::Warning, "motor_address", "should be 0");
    }
    not_negative(lints, "exposure", message.exposure.0);
}

/// Checks a stop, in which the position does not matter (safety decision 3).
fn stop(lints: &mut Lints, context: &Context<'_>, address: MotorAddress, acceleration: RotationsPerSecondSquared) {
    motor(lints, context, address, 1);
    if acceleration.0.is_nan() || acceleration.0 <= 0.0 {
        lints.note(Severity::Warning, "acceleration", "is not positive: the motor might never come to rest");
    }
}

fn go_to(lints: &mut Lints, context: &Context<'_>, message: &SetPositionSpeedAcceleration<'_>) {
    let known = motor(lints, context, message.motor_address, 1);
    if let Some(known) = known {
        position(lints, known, message.position);
    }
    pace(lints, known, context.kind(message.motor_address), message.speed, message.acceleration);
}

fn bump(lints: &mut Lints, context: &Context<'_>, message: &BumpPositionSpeedAcceleration<'_>) {
    let known = motor(lints, context, message.motor_address, 1);
    if let Some((known, from)) = known.and_then(|known| known.relative_position().map(|from| (known, from))) {
        position(lints, known, Rotations(from.0 + message.delta.0));
    }
    pace(lints, known, context.kind(message.motor_address), message.speed, message.acceleration);
}

/// Checks a position. A device keeps a calibrated motor in its range. If a motor is not calibrated, a device only
/// accepts a jog (7.3, decision K-M9).
fn position(lints: &mut Lints, motor: &Motor, position: Rotations) {
    match motor.range() {
        Some(range) => {
            let (low, high) = (range.0.min(0.0), range.0.max(0.0));
            if position.0 < low || position.0 > high {
                lints.note(Severity::Warning, "position", "is outside the range of the motor");
            }
        }
        None if position != JOG_DISTANCE && position.0 != -JOG_DISTANCE.0 => {
            lints.note(Severity::Warning, "position", "has no meaning: the motor is not calibrated");
        }
        None => {}
    }
}

/// Checks speed and acceleration of a motion by hand (decision K-N1). The lower limit of the motor and of its kind of axis counts (decision
/// K-M6).
fn pace(
    lints: &mut Lints,
    motor: Option<&Motor>,
    kind: Option<AxisKind>,
    RotationsPerSecond(speed): RotationsPerSecond,
    RotationsPerSecondSquared(acceleration): RotationsPerSecondSquared,
) {
    not_negative(lints, "speed", speed);
    not_negative(lints, "acceleration", acceleration);
    if acceleration == 0.0 {
        lints.note(
            Severity::Warning,
            "acceleration",
            "is 0: the motor never reaches its speed, or never comes to rest",
        );
    }
    let of_motor = motor.map(|motor| (motor.max_max_setup_speed.0, motor.max_max_acceleration.0)).unzip();
    let of_kind = (
        kind.and_then(AxisKind::max_speed).map(RotationsPerSecond::get),
        kind.and_then(AxisKind::max_acceleration).map(RotationsPerSecondSquared::get),
    );
    at_most(lints, "speed", speed, of_motor.0, of_kind.0);
    at_most(lints, "acceleration", acceleration, of_motor.1, of_kind.1);
}

fn at_most(lints: &mut Lints, what: &'static str, number: f32, of_motor: Option<f32>, of_kind: Option<f32>) {
    if of_motor.is_some_and(|greatest| number > greatest) {
        lints.note(Severity::Warning, what, "is more than the limit of the motor");
    } else if of_kind.is_some_and(|greatest| number > greatest) {
        lints.note(Severity::Warning, what, "is more than the limit of the specification for the kind of axis");
    }
}
