//! Answers of a device as values.

use kos_proto::DeviceMessage;
use kos_proto::message::{
    AuxInputs, DeviceType, FirmwareVersion, LedMode, Motor, NetworkInfo, Normalized, PlaybackMode, PlaybackState,
    Seconds,
};

use super::{KosHost, StoredMove};

/// Answer of a device.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Answer {
    /// What the device is and does.
    Device(Device),
    /// Address in the network.
    Network(NetworkInfo<'static>),
    /// Motors of the device.
    Motors(Vec<Motor>),
    /// Modes of the lamp of the device, and of the lamp of its slave.
    Leds(LedMode, LedMode),
    /// Move that the device stored, if it has one that can be played.
    Move(Option<StoredMove>),
    /// Number that no other device has, of 16 bytes as specified.
    Guid(Vec<u8>),
    /// Platform that calibrated the motors.
    Platform(u8),
}

/// What a device is and does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Device {
    /// Type of the device.
    pub device_type: DeviceType,
    /// Firmware of the device.
    pub firmware: FirmwareVersion,
    /// Kind of move that the device plays.
    pub mode: PlaybackMode,
    /// State of the move.
    pub state: PlaybackState,
    /// Inputs of the device.
    pub inputs: AuxInputs,
    /// Time until the move begins.
    pub remaining: Seconds,
    /// Part of the move that is over.
    pub elapsed: Normalized,
}

impl KosHost {
    /// Answer in a message. The answer about motors is the end of a series, so that the motors come from the machine.
    pub(super) fn answer(&self, message: &DeviceMessage<'_>) -> Option<Answer> {
        Some(match message {
            DeviceMessage::MotorInfo(_) => Answer::Motors(self.machine().motors().copied().collect()),
            DeviceMessage::DeviceInfo(info) => Answer::Device(Device {
                device_type: info.device_type,
                firmware: info.firmware_version,
                mode: info.playback_mode,
                state: info.playback_status,
                inputs: info.aux_input_status,
                remaining: info.delay_time_remaining,
                elapsed: info.elapsed_time,
            }),
            DeviceMessage::NetworkInfo(info) => Answer::Network(without_tail(info)),
            DeviceMessage::LEDStatus(leds) => Answer::Leds(leds.master_status, leds.slave_status),
            DeviceMessage::TrajectoryData(data) => Answer::Move(StoredMove::new(data).ok()),
            DeviceMessage::DeviceGUID(guid) => Answer::Guid(guid.guid.0.to_vec()),
            DeviceMessage::SoftwareID(software) => Answer::Platform(software.platform),
            _ => return None,
        })
    }
}

const fn without_tail(info: &NetworkInfo<'_>) -> NetworkInfo<'static> {
    let NetworkInfo { dhcp, mac_address, ip_address, subnet_mask, gateway, device_type, device_addr, tail: _ } = *info;
    NetworkInfo { dhcp, mac_address, ip_address, subnet_mask, gateway, device_type, device_addr, tail: &[] }
}
