//! Checks of the messages that a device sends.

use motion_core::lint::{Findings as _, Lints, Severity};
use motion_core::wire::{Block16, Rest};

use super::{Context, address, common, not_negative, part_of_one, password, unknown, yes_or_no, zero};
use crate::DeviceMessage;
use crate::frame::VERSION;
use crate::message::{
    AuxInputs, DeviceInfo, ErrorCode, ErrorStatus, MotorAddress, MotorInfo, MotorPosition, MotorStatus, PlaybackStatus,
    Rotations,
};

/// Length of a GUID in bytes (decision K-B1).
const GUID_LEN: usize = 16;
/// Distance beyond an end at which a motor may rest, as a part of its range.
const OVERSHOOT: f32 = 1e-3;

impl DeviceMessage<'_> {
    /// Findings about the message: what a strict client would refuse, or a careful device would not send.
    #[must_use]
    pub fn lint(&self, context: &Context<'_>) -> Lints {
        let mut lints = Lints::new();
        match self {
            Self::NetworkInfo(message) => {
                yes_or_no(&mut lints, "dhcp", message.dhcp);
                lints.named("device_type", message.device_type.0, message.device_type.name());
                zero(&mut lints, "device_addr", message.device_addr);
            }
            Self::LEDStatus(message) => {
                lints.named("master_status", message.master_status.0, message.master_status.name());
                lints.named("slave_status", message.slave_status.0, message.slave_status.name());
            }
            Self::MotorInfo(message) => motor_info(&mut lints, message),
            Self::DeviceInfo(message) => device_info(&mut lints, message),
            Self::DeviceGUID(message) => guid(&mut lints, message.guid),
            Self::MotorStatus(message) => motor_status(&mut lints, message),
            Self::PlaybackStatus(message) => playback_status(&mut lints, message),
            Self::ErrorStatus(message) => error_status(&mut lints, *message),
            Self::MotorPosition(message) => motor_position(&mut lints, context, message),
            Self::MotorCalibrated(message) => address(&mut lints, message.motor_address, 1),
            Self::AuxInputStatus(message) => inputs(&mut lints, "status", message.status),
            Self::UnsupportedMessage(message) => echo(&mut lints, message.message),
            Self::Other(other) => unknown(&mut lints, other),
            // The stored move was checked when it was set.
            Self::TrajectoryData(_) | Self::SoftwareID(_) => {}
        }
        common(&mut lints, self, Severity::Error);
        lints
    }
}

/// Checks the unused bytes, names and numbers of a `DeviceInfo` (safety decision 9).
fn device_info(lints: &mut Lints, message: &DeviceInfo<'_>) {
    lints.named("device_type", message.device_type.0, message.device_type.name());
    zero(lints, "device_addr", message.device_addr);
    lints.named("playback_mode", message.playback_mode.0, message.playback_mode.name());
    lints.named("playback_status", message.playback_status.0, message.playback_status.name());
    zero(lints, "network_id", message.network_id);
    zero(lints, "hardware_id", message.hardware_id);
    password(lints, "device_password", message.device_password, Severity::Warning);
    inputs(lints, "aux_input_status", message.aux_input_status);
    not_negative(lints, "delay_time_remaining", message.delay_time_remaining.0);
    part_of_one(lints, "elapsed_time", message.elapsed_time.0);
}

/// Checks the motors of a `MotorInfo`. Clients expect one motor in a message (decision K-M3).
fn motor_info(lints: &mut Lints, message: &MotorInfo<'_>) {
    if message.motors.len() > 1 {
        lints.note(Severity::Warning, "motor_count", "is more than 1");
    }
    for motor in message.motors.iter() {
        address(lints, motor.motor_address, 1);
        not_negative(lints, "max_max_setup_speed", motor.max_max_setup_speed.0);
        not_negative(lints, "max_max_move_speed", motor.max_max_move_speed.0);
        not_negative(lints, "max_max_acceleration", motor.max_max_acceleration.0);
    }
}

fn motor_status(lints: &mut Lints, message: &MotorStatus<'_>) {
    for motor in message.motors.0 {
        address(lints, motor.motor_address(), 1);
        yes_or_no(lints, "online_status", motor.online_status());
        lints.named("motor_type", motor.motor_type().0, motor.motor_type().name());
        not_negative(lints, "max_max_setup_speed", motor.max_max_setup_speed().0);
        not_negative(lints, "max_max_move_speed", motor.max_max_move_speed().0);
        not_negative(lints, "max_max_acceleration", motor.max_max_acceleration().0);
    }
}

fn playback_status(lints: &mut Lints, message: &PlaybackStatus<'_>) {
    lints.named("playback_status", message.playback_status.0, message.playback_status.name());
    part_of_one(lints, "elapsed_time", message.elapsed_time.0);
    if let Some(photos) = message.photo_count {
        not_negative(lints, "photo_count", photos.0);
    }
    for motor in message.motors {
        address(lints, motor.motor_address(), 1);
    }
}

/// Checks a reported position, which lies between the ends of the range. Commanded positions begin at 0, but the range
/// of reported positions need not (decision K-M5).
fn motor_position(lints: &mut Lints, context: &Context<'_>, message: &MotorPosition<'_>) {
    address(lints, message.motor_address, 1);
    let Some(motor) = context.motor(message.motor_address).filter(|motor| motor.is_calibrated()) else { return };
    let begin = motor.begin_position.map_or(0.0, Rotations::get);
    let (low, high) = (begin.min(motor.end_position.0), begin.max(motor.end_position.0));
    let slack = (high - low) * OVERSHOOT;
    if message.position.0 < low - slack || message.position.0 > high + slack {
        lints.note(Severity::Warning, "position", "is outside the range of the motor");
    }
}

/// Checks an error. Its address is 0 if it is about no motor, and can be any number if no such motor exists.
fn error_status(lints: &mut Lints, ErrorStatus { error_code, motor_address, .. }: ErrorStatus<'_>) {
    lints.named("error_code", error_code.0, error_code.name());
    if error_code != ErrorCode::BAD_MOTOR_ADDRESS {
        let least = u8::from(error_code.names_motor());
        lints.range("motor_address", motor_address.number(), least, MotorAddress::LAST.0);
    }
    if error_code.is_about_no_motor() && motor_address != MotorAddress::ALL {
        lints.note(Severity::Warning, "motor_address", "should be 0");
    }
}

fn guid(lints: &mut Lints, Block16(bytes): Block16<'_>) {
    if bytes.len() != GUID_LEN {
        lints.note(Severity::Warning, "guid", "does not have 16 bytes");
    }
}

/// Checks that an echoed message begins with the protocol version (decision K-P10).
fn echo(lints: &mut Lints, Rest(bytes): Rest<'_>) {
    if bytes.first() != Some(&VERSION) {
        lints.note(Severity::Warning, "message", "does not begin with the protocol version");
    }
}

fn inputs(lints: &mut Lints, what: &'static str, inputs: AuxInputs) {
    let named = AuxInputs::MASTER_TIP
        | AuxInputs::MASTER_RING
        | AuxInputs::SLAVE_TIP
        | AuxInputs::SLAVE_RING
        | AuxInputs::SLAVE_PRESENT;
    lints.reserved(what, inputs.bits(), !named.bits());
}
