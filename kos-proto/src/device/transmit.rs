//! Messages that a device machine sends, by name. What is long comes from a [`Source`].

use core::slice;

use arrayvec::ArrayVec;
use motion_core::wire::{Block16, Counted, Newer, Password, Rest};

use super::clients::Sessions;
use super::input::Sender;
use crate::DeviceMessage;
use crate::message::{
    AuxInputStatus, AuxInputs, DeviceGUID, DeviceInfo, DeviceType, ErrorCode, ErrorStatus, FirmwareVersion, LEDStatus,
    LedMode, MOTORS, MotorAddress, MotorCalibrated, MotorEntry, MotorInfo, MotorInfos, MotorPlace, MotorPosition,
    MotorPresence, MotorStatus, MotorType, NetworkInfo, Normalized, OldMotorEntry, Photos, PlaybackMode, PlaybackState,
    PlaybackStatus, Rotations, RotationsPerSecond, RotationsPerSecondSquared, Seconds, SoftwareID, UnsupportedMessage,
};
use crate::trajectory::TrajectoryData;

/// Positions of the motors.
pub type Positions = ArrayVec<MotorPlace, MOTORS>;

/// Receivers of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Destination {
    /// These clients, each over its connection.
    Sessions(Sessions),
    /// Everybody in the network: a datagram to 255.255.255.255.
    Broadcast,
    /// The sender of a datagram: another datagram.
    Datagram(Sender),
}

/// Message to send.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Transmit<'a> {
    /// Receivers of the message.
    pub destination: Destination,
    /// Contents of the message.
    pub contents: Contents<'a>,
}

/// Contents of a message. What is long, and what never changes, comes from a [`Source`].
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Contents<'a> {
    /// Address of the device in the network.
    NetworkInfo,
    /// State of the lamps.
    LedStatus {
        /// Mode of the lamp of the device.
        master: LedMode,
        /// Mode of the lamp of its slave.
        slave: LedMode,
    },
    /// One motor of a series, or that there is none.
    MotorInfo {
        /// Report on the motor.
        motor: Option<MotorReport>,
        /// Whether another one follows.
        more: bool,
    },
    /// What the device is and does.
    DeviceInfo(Activity),
    /// Move that is stored, or that none is.
    TrajectoryData {
        /// Whether a move is stored.
        stored: bool,
    },
    /// Number that no other device has.
    DeviceGuid,
    /// Platform that calibrated the motors.
    SoftwareId {
        /// Number of the platform.
        platform: u8,
    },
    /// A motor came or went.
    MotorStatus {
        /// Number of the motor.
        motor: MotorAddress,
        /// Whether the motor is there.
        online: bool,
    },
    /// Progress of the move.
    PlaybackStatus {
        /// State of the move.
        state: PlaybackState,
        /// Part of the move that is over.
        elapsed: Normalized,
        /// Number of photos taken in the move.
        photos: u32,
        /// Positions of the motors of the move.
        positions: Positions,
    },
    /// An error.
    ErrorStatus {
        /// Code of the error.
        code: ErrorCode,
        /// Number of the motor, or 0.
        motor: MotorAddress,
    },
    /// A motor rests.
    MotorPosition {
        /// Number of the motor.
        motor: MotorAddress,
        /// Position of the motor.
        position: Rotations,
    },
    /// The range of a motor changed.
    MotorCalibrated {
        /// Number of the motor.
        motor: MotorAddress,
        /// Begin of the range.
        begin: Rotations,
        /// End of the range; 0 if there is none.
        end: Rotations,
    },
    /// Inputs, after one changed.
    AuxInputStatus(AuxInputs),
    /// These bytes are a message that the device does not know.
    UnsupportedMessage(&'a [u8]),
}

/// Position and range of a motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct MotorReport {
    /// Number of the motor.
    pub motor: MotorAddress,
    /// Position of the motor.
    pub position: Rotations,
    /// Begin of the range.
    pub begin: Rotations,
    /// End of the range; 0 if there is none.
    pub end: Rotations,
}

/// What a device does at present.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Activity {
    /// Kind of move that the device plays.
    pub mode: PlaybackMode,
    /// State of the move.
    pub state: PlaybackState,
    /// Inputs of the device.
    pub inputs: AuxInputs,
    /// Time until the move begins, and part of it that is over.
    pub times: (Seconds, Normalized),
    /// Number of photos taken in the move.
    pub photos: u32,
}

/// Type and limits of a motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct MotorSpecs {
    /// Type of the motor: focus, iris or zoom, or another axis.
    pub motor_type: MotorType,
    /// Greatest speed when the motor is moved by hand.
    pub max_max_setup_speed: RotationsPerSecond,
    /// Greatest speed in a move.
    pub max_max_move_speed: RotationsPerSecond,
    /// Greatest acceleration.
    pub max_max_acceleration: RotationsPerSecondSquared,
}

impl MotorSpecs {
    /// Address as a device reports it, with the mark of focus, iris and zoom (decision K-M2).
    fn address(&self, motor: MotorAddress) -> MotorAddress {
        if self.motor_type == MotorType::FIZ { MotorAddress(motor.number() | 0x80) } else { motor }
    }
}

/// Data that only the caller stores, borrowed to make messages.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    /// Whether the device speaks the older dialect, `CineDrive` (safety decision 7).
    pub older_dialect: bool,
    /// Type of the device.
    pub device_type: DeviceType,
    /// Firmware of the device.
    pub firmware_version: FirmwareVersion,
    /// Address of the device in the network.
    pub network: NetworkInfo<'a>,
    /// Number that no other device has.
    pub guid: &'a [u8],
    /// Password that is stored.
    pub password: Password<'a>,
    /// Types and limits of the motors, motor 1 first. Motors that are left out have limits of 0.
    pub motors: &'a [MotorSpecs],
    /// Move that is stored.
    pub trajectory: TrajectoryData<'a>,
}

impl Default for Source<'_> {
    /// Source of a device without number, address, password, limits and move.
    fn default() -> Self {
        Self {
            older_dialect: false,
            device_type: DeviceType::UNKNOWN,
            firmware_version: FirmwareVersion::default(),
            network: NetworkInfo::default(),
            guid: &[],
            password: Password(&[]),
            motors: &[],
            trajectory: TrajectoryData::default(),
        }
    }
}

impl Source<'_> {
    fn motor(&self, motor: MotorAddress) -> MotorSpecs {
        let index = usize::from(motor.number()).checked_sub(1);
        index.and_then(|index| self.motors.get(index)).copied().unwrap_or_default()
    }
}

/// Room for a list that a message lends.
#[derive(Debug, Default)]
pub struct Scratch {
    entry: Option<MotorEntry>,
    old: Option<OldMotorEntry>,
    presence: Option<MotorPresence>,
}

impl Transmit<'_> {
    /// Returns the same if it can be kept; `None` if it lends a message of a client.
    #[must_use]
    pub fn to_static(&self) -> Option<Transmit<'static>> {
        let contents = match self.contents {
            Contents::UnsupportedMessage(_) => return None,
            Contents::NetworkInfo => Contents::NetworkInfo,
            Contents::LedStatus { master, slave } => Contents::LedStatus { master, slave },
            Contents::MotorInfo { motor, more } => Contents::MotorInfo { motor, more },
            Contents::DeviceInfo(activity) => Contents::DeviceInfo(activity),
            Contents::TrajectoryData { stored } => Contents::TrajectoryData { stored },
            Contents::DeviceGuid => Contents::DeviceGuid,
            Contents::SoftwareId { platform } => Contents::SoftwareId { platform },
            Contents::MotorStatus { motor, online } => Contents::MotorStatus { motor, online },
            Contents::PlaybackStatus { state, elapsed, photos, ref positions } => {
                // A clone cannot be proven free of panics.
                let mut copied = Positions::new();
                for place in positions {
                    let _ = copied.try_push(*place);
                }
                Contents::PlaybackStatus { state, elapsed, photos, positions: copied }
            }
            Contents::ErrorStatus { code, motor } => Contents::ErrorStatus { code, motor },
            Contents::MotorPosition { motor, position } => Contents::MotorPosition { motor, position },
            Contents::MotorCalibrated { motor, begin, end } => Contents::MotorCalibrated { motor, begin, end },
            Contents::AuxInputStatus(inputs) => Contents::AuxInputStatus(inputs),
        };
        Some(Transmit { destination: self.destination, contents })
    }

    /// Message to encode; see [`Contents::message`].
    #[must_use]
    pub fn message<'s>(&'s self, source: &Source<'s>, scratch: &'s mut Scratch) -> DeviceMessage<'s> {
        self.contents.message(source, scratch)
    }
}

impl Contents<'_> {
    /// Message to encode, with what `source` has for it. A list that it lends is put into `scratch`.
    #[must_use]
    pub fn message<'s>(&'s self, source: &Source<'s>, scratch: &'s mut Scratch) -> DeviceMessage<'s> {
        let (older, tail) = (source.older_dialect, &[][..]);
        match *self {
            Self::NetworkInfo => source.network.into(),
            Self::LedStatus { master, slave } => LEDStatus { master_status: master, slave_status: slave, tail }.into(),
            Self::MotorInfo { motor, more } => {
                MotorInfo { more, motors: motor_info(motor.as_ref(), source, scratch), tail }.into()
            }
            Self::DeviceInfo(activity) => device_info(&activity, source).into(),
            Self::TrajectoryData { stored: true } => source.trajectory.into(),
            Self::TrajectoryData { stored: false } => TrajectoryData::default().into(),
            Self::DeviceGuid => DeviceGUID { guid: Block16(source.guid), tail }.into(),
            Self::SoftwareId { platform } => SoftwareID { platform, tail }.into(),
            Self::MotorStatus { motor, online } => {
                let MotorSpecs { motor_type, max_max_setup_speed, max_max_move_speed, max_max_acceleration } =
                    source.motor(motor);
                let presence = MotorPresence::new(
                    motor,
                    online.into(),
                    motor_type,
                    max_max_setup_speed,
                    max_max_move_speed,
                    max_max_acceleration,
                );
                let motors = Counted(slice::from_ref(&*scratch.presence.insert(presence)));
                MotorStatus { motors, tail }.into()
            }
            Self::PlaybackStatus { state, elapsed, photos, ref positions } => {
                let photo_count = (!older).then(|| photos_of(photos));
                let (playback_status, elapsed_time) = (state, elapsed);
                PlaybackStatus { playback_status, elapsed_time, photo_count, motors: positions, tail }.into()
            }
            Self::ErrorStatus { code, motor } => ErrorStatus { error_code: code, motor_address: motor, tail }.into(),
            Self::MotorPosition { motor, position } => MotorPosition { motor_address: motor, position, tail }.into(),
            Self::MotorCalibrated { motor, begin, end } => {
                let (motor_address, begin_position) = (motor, (!older).then_some(begin));
                MotorCalibrated { motor_address, begin_position, end_position: end, tail }.into()
            }
            Self::AuxInputStatus(status) => AuxInputStatus { status, tail }.into(),
            Self::UnsupportedMessage(bytes) => UnsupportedMessage { message: Rest(bytes), tail }.into(),
        }
    }
}

fn motor_info<'s>(motor: Option<&MotorReport>, source: &Source<'_>, scratch: &'s mut Scratch) -> MotorInfos<'s> {
    let Some(&MotorReport { motor, position, begin, end }) = motor else { return MotorInfos::New(&[]) };
    let able = source.motor(motor);
    let (setup, moving, acceleration) = (able.max_max_setup_speed, able.max_max_move_speed, able.max_max_acceleration);
    let motor = able.address(motor);
    if source.older_dialect {
        let entry = OldMotorEntry::new(motor, position, end, setup, moving, acceleration);
        MotorInfos::Old(slice::from_ref(&*scratch.old.insert(entry)))
    } else {
        let entry = MotorEntry::new(motor, position, begin, end, setup, moving, acceleration);
        MotorInfos::New(slice::from_ref(&*scratch.entry.insert(entry)))
    }
}

fn device_info<'s>(activity: &Activity, source: &Source<'s>) -> DeviceInfo<'s> {
    let (delay_time_remaining, elapsed_time) = activity.times;
    DeviceInfo {
        device_type: source.device_type,
        device_addr: 0,
        playback_mode: activity.mode,
        playback_status: activity.state,
        firmware_version: source.firmware_version,
        network_id: 0,
        hardware_id: 0,
        device_password: source.password,
        aux_input_status: activity.inputs,
        delay_time_remaining,
        elapsed_time,
        photo_count: Newer((!source.older_dialect).then_some(activity.photos)),
        tail: &[],
    }
}

/// Number of photos as the message has it: exact up to 16 777 216 (decision K-N2).
#[expect(clippy::cast_precision_loss, reason = "the message has no other number")]
fn photos_of(photos: u32) -> Photos {
    Photos(photos as f32)
}
