//! What a device sends: named, and made a message with what only the caller stores.

use core::slice;

use motion_core::wire::{Block16, Bool, Counted, Newer, Password, Rest};

use super::{Positions, Sessions};
use crate::DeviceMessage;
use crate::message::{
    AuxInputStatus, AuxInputs, DeviceGUID, DeviceInfo, DeviceType, ErrorCode, ErrorStatus, FirmwareVersion, Ipv4,
    LEDStatus, LedMode, MacAddress, MotorAddress, MotorCalibrated, MotorEntry, MotorInfo, MotorInfos, MotorPosition,
    MotorPresence, MotorStatus, MotorType, NetworkInfo, Normalized, OldMotorEntry, Photos, PlaybackMode, PlaybackState,
    PlaybackStatus, Rotations, RotationsPerSecond, RotationsPerSecondSquared, Seconds, SoftwareID, UnsupportedMessage,
};
use crate::trajectory::TrajectoryData;

/// Whom to send it to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum To {
    /// These clients, each over its connection.
    Sessions(Sessions),
    /// Everybody in the network: a datagram to 255.255.255.255.
    Broadcast,
    /// The one whose datagram was just given in.
    Asker,
}

/// What to send, and to whom.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Send {
    /// To whom.
    pub to: To,
    /// What.
    pub what: What,
}

/// What a device sends. What is long, and what never changes, comes from a [`Profile`].
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum What {
    /// Where the device is in the network.
    NetworkInfo,
    /// What the lamps do.
    LedStatus {
        /// Of the device.
        master: LedMode,
        /// Of its slave.
        slave: LedMode,
    },
    /// A motor, or that there is none; mostly others follow.
    MotorInfo {
        /// The motor.
        motor: Option<MotorReport>,
        /// Whether another one follows.
        more: bool,
    },
    /// What the device is and does.
    DeviceInfo(Doing),
    /// The move that is stored, or that none is.
    TrajectoryData {
        /// Whether there is one.
        stored: bool,
    },
    /// The number that no other device has.
    DeviceGuid,
    /// The platform that calibrated the motors.
    SoftwareId {
        /// Its number.
        platform: u8,
    },
    /// A motor came or went.
    MotorStatus {
        /// Which.
        motor: MotorAddress,
        /// Whether it is there.
        online: bool,
    },
    /// How far the device is with its move.
    PlaybackStatus {
        /// How far.
        state: PlaybackState,
        /// How much of it is over.
        elapsed: Normalized,
        /// Photos taken in it.
        photos: u32,
        /// Where the motors are.
        positions: Positions,
    },
    /// Something failed.
    ErrorStatus {
        /// What.
        code: ErrorCode,
        /// Which motor, or 0.
        motor: MotorAddress,
    },
    /// A motor rests.
    MotorPosition {
        /// Which.
        motor: MotorAddress,
        /// Where.
        position: Rotations,
    },
    /// The range of a motor changed.
    MotorCalibrated {
        /// Which.
        motor: MotorAddress,
        /// Where it begins.
        begin: Rotations,
        /// Where it ends; 0 where it has none.
        end: Rotations,
    },
    /// An input changed.
    AuxInputStatus(AuxInputs),
    /// The message that was just given in is not known.
    UnsupportedMessage,
}

/// Where a motor is, and how far it goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct MotorReport {
    /// Which.
    pub motor: MotorAddress,
    /// Where it is.
    pub position: Rotations,
    /// Where its range begins.
    pub begin: Rotations,
    /// Where its range ends; 0 where it has none.
    pub end: Rotations,
}

/// What the device does just now.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Doing {
    /// Which kind of move it plays.
    pub mode: PlaybackMode,
    /// How far it is with it.
    pub state: PlaybackState,
    /// Its inputs.
    pub inputs: AuxInputs,
    /// Time until the move begins, and how much of it is over.
    pub times: (Seconds, Normalized),
    /// Photos taken in it.
    pub photos: u32,
}

/// What a motor is and can do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct MotorProfile {
    /// Whether it is one of focus, iris and zoom.
    pub motor_type: MotorType,
    /// The greatest speed on the way to where a move begins.
    pub max_max_setup_speed: RotationsPerSecond,
    /// The greatest speed in a move.
    pub max_max_move_speed: RotationsPerSecond,
    /// The greatest acceleration.
    pub max_max_acceleration: RotationsPerSecondSquared,
}

impl MotorProfile {
    /// The address as a device tells it, with the mark of focus, iris and zoom (decision K-M2).
    fn address(&self, motor: MotorAddress) -> MotorAddress {
        if self.motor_type == MotorType::FIZ { MotorAddress(motor.number() | 0x80) } else { motor }
    }
}

/// What a device is and stores, beyond its state: the caller's, borrowed where a message is made.
#[derive(Clone, Copy)]
pub struct Profile<'a> {
    /// Whether it speaks the older dialect, `CineDrive` (safety decision 7).
    pub older_dialect: bool,
    /// What it is.
    pub device_type: DeviceType,
    /// Its firmware.
    pub firmware_version: FirmwareVersion,
    /// Where it is in the network.
    pub network: NetworkInfo<'a>,
    /// Its number.
    pub guid: &'a [u8],
    /// The stored password.
    pub password: Password<'a>,
    /// What its motors can do, motor 1 first; those that are left out can do nothing.
    pub motors: &'a [MotorProfile],
    /// The stored move.
    pub trajectory: TrajectoryData<'a>,
    /// The message that was just given in, from its version byte on, for `UnsupportedMessage`.
    pub received: &'a [u8],
}

impl Default for Profile<'_> {
    /// A device without name, address, password, abilities and move.
    fn default() -> Self {
        let network = NetworkInfo {
            dhcp: Bool::FALSE,
            mac_address: MacAddress::default(),
            ip_address: Ipv4::default(),
            subnet_mask: Ipv4::default(),
            gateway: Ipv4::default(),
            device_type: DeviceType::UNKNOWN,
            device_addr: 0,
            tail: &[],
        };
        Self {
            older_dialect: false,
            device_type: DeviceType::UNKNOWN,
            firmware_version: FirmwareVersion::default(),
            network,
            guid: &[],
            password: Password(&[]),
            motors: &[],
            trajectory: TrajectoryData::default(),
            received: &[],
        }
    }
}

impl Profile<'_> {
    fn motor(&self, motor: MotorAddress) -> MotorProfile {
        let index = usize::from(motor.number()).checked_sub(1);
        index.and_then(|index| self.motors.get(index)).copied().unwrap_or_default()
    }
}

/// Room for the list that a message lends.
#[derive(Debug, Default)]
pub struct Scratch {
    entry: Option<MotorEntry>,
    old: Option<OldMotorEntry>,
    presence: Option<MotorPresence>,
}

impl Send {
    /// Its message; see [`What::message`].
    #[must_use]
    pub fn message<'s>(&'s self, profile: &Profile<'s>, scratch: &'s mut Scratch) -> DeviceMessage<'s> {
        self.what.message(profile, scratch)
    }
}

impl What {
    /// The message, with what `profile` has for it. A list that it lends is put into `scratch`.
    #[must_use]
    pub fn message<'s>(&'s self, profile: &Profile<'s>, scratch: &'s mut Scratch) -> DeviceMessage<'s> {
        let (older, tail) = (profile.older_dialect, &[][..]);
        match *self {
            Self::NetworkInfo => DeviceMessage::NetworkInfo(profile.network),
            Self::LedStatus { master, slave } => {
                DeviceMessage::LEDStatus(LEDStatus { master_status: master, slave_status: slave, tail })
            }
            Self::MotorInfo { motor, more } => {
                let motors = motor_info(motor.as_ref(), profile, scratch);
                DeviceMessage::MotorInfo(MotorInfo { more, motors, tail })
            }
            Self::DeviceInfo(doing) => DeviceMessage::DeviceInfo(device_info(&doing, profile)),
            Self::TrajectoryData { stored } => {
                DeviceMessage::TrajectoryData(if stored { profile.trajectory } else { TrajectoryData::default() })
            }
            Self::DeviceGuid => DeviceMessage::DeviceGUID(DeviceGUID { guid: Block16(profile.guid), tail }),
            Self::SoftwareId { platform } => DeviceMessage::SoftwareID(SoftwareID { platform, tail }),
            Self::MotorStatus { motor, online } => {
                let MotorProfile { motor_type, max_max_setup_speed, max_max_move_speed, max_max_acceleration } =
                    profile.motor(motor);
                let presence = MotorPresence::new(
                    motor,
                    online.into(),
                    motor_type,
                    max_max_setup_speed,
                    max_max_move_speed,
                    max_max_acceleration,
                );
                let motors = Counted(slice::from_ref(&*scratch.presence.insert(presence)));
                DeviceMessage::MotorStatus(MotorStatus { motors, tail })
            }
            Self::PlaybackStatus { state, elapsed, photos, ref positions } => {
                DeviceMessage::PlaybackStatus(PlaybackStatus {
                    playback_status: state,
                    elapsed_time: elapsed,
                    photo_count: (!older).then(|| photos_of(photos)),
                    motors: positions,
                    tail,
                })
            }
            Self::ErrorStatus { code, motor } => {
                DeviceMessage::ErrorStatus(ErrorStatus { error_code: code, motor_address: motor, tail })
            }
            Self::MotorPosition { motor, position } => {
                DeviceMessage::MotorPosition(MotorPosition { motor_address: motor, position, tail })
            }
            Self::MotorCalibrated { motor, begin, end } => DeviceMessage::MotorCalibrated(MotorCalibrated {
                motor_address: motor,
                begin_position: (!older).then_some(begin),
                end_position: end,
                tail,
            }),
            Self::AuxInputStatus(status) => DeviceMessage::AuxInputStatus(AuxInputStatus { status, tail }),
            Self::UnsupportedMessage => {
                DeviceMessage::UnsupportedMessage(UnsupportedMessage { message: Rest(profile.received), tail })
            }
        }
    }
}

fn motor_info<'s>(motor: Option<&MotorReport>, profile: &Profile<'_>, scratch: &'s mut Scratch) -> MotorInfos<'s> {
    let Some(&MotorReport { motor, position, begin, end }) = motor else { return MotorInfos::New(&[]) };
    let able = profile.motor(motor);
    let (setup, moving, acceleration) = (able.max_max_setup_speed, able.max_max_move_speed, able.max_max_acceleration);
    let motor = able.address(motor);
    if profile.older_dialect {
        let entry = OldMotorEntry::new(motor, position, end, setup, moving, acceleration);
        MotorInfos::Old(slice::from_ref(&*scratch.old.insert(entry)))
    } else {
        let entry = MotorEntry::new(motor, position, begin, end, setup, moving, acceleration);
        MotorInfos::New(slice::from_ref(&*scratch.entry.insert(entry)))
    }
}

fn device_info<'s>(doing: &Doing, profile: &Profile<'s>) -> DeviceInfo<'s> {
    let (delay_time_remaining, elapsed_time) = doing.times;
    DeviceInfo {
        device_type: profile.device_type,
        device_addr: 0,
        playback_mode: doing.mode,
        playback_status: doing.state,
        firmware_version: profile.firmware_version,
        network_id: 0,
        hardware_id: 0,
        device_password: profile.password,
        aux_input_status: doing.inputs,
        delay_time_remaining,
        elapsed_time,
        photo_count: Newer((!profile.older_dialect).then_some(doing.photos)),
        tail: &[],
    }
}

/// Exact up to 16 777 216 (decision K-N2).
#[expect(clippy::cast_precision_loss, reason = "the message has no other number")]
fn photos_of(photos: u32) -> Photos {
    Photos(photos as f32)
}
