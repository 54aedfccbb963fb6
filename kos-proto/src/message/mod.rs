//! Messages of kOS, in one file for each chapter of the specification.
//!
//! The id and the type together identify a message; an action or a notification has a number of its own as well. The
//! tables write the three as one number, for example `0x0080_00_1C`: id, type, and the number of the action or
//! notification, which is 0 in all other messages. A client sends a [`HostMessage`], and a device sends a
//! [`DeviceMessage`].

#![expect(clippy::unusual_byte_groupings, reason = "the groups are id, type, and number of the action or notification")]

mod action;
mod device;
mod dialect;
mod motor;
mod motor_set;
mod notification;
mod units;

pub use action::{
    ActionId, BumpPositionSpeedAcceleration, Direction, JOG_DISTANCE, MarkBeginPosition, MarkEndPosition,
    PlaybackDirection, RapidToFirstKeyFrame, ResetAxis, ResetDevice, SetPositionSpeedAcceleration, SetupPlayback,
    StartPlayback, StopPlayback, TakePicture,
};
pub use device::{
    AuxInputs, DeviceGUID, DeviceInfo, DevicePassword, DeviceType, FirmwareVersion, GetDeviceGUID, GetDeviceInfo,
    GetLEDStatus, GetNetworkInfo, GetSoftwareID, GetTrajectoryData, Ipv4, KeepAlive, LEDStatus, LedMode, MacAddress,
    NetworkInfo, PlaybackMode, SoftwareID, UserPassword,
};
pub use motion_core::wire::{Block16, Bool, Bytes, Counted, Newer, Other, Password, Rest};
pub use motor::{AxisKind, GetMotorInfo, Motor, MotorEntry, MotorInfo, MotorInfos, OldMotorEntry};
pub use motor_set::{MOTORS, MotorSet};
pub use notification::{
    AuxInputStatus, ErrorCode, ErrorStatus, MotorCalibrated, MotorPlace, MotorPosition, MotorPresence, MotorStatus,
    MotorType, Photos, PlaybackState, PlaybackStatus, UnsupportedMessage,
};
pub use units::{MotorAddress, Normalized, Rotations, RotationsPerSecond, RotationsPerSecondSquared, Seconds};

use motion_core::messages;
use motion_core::wire::{FieldView, Fields, Messages, Value, Visitor};

use crate::frame::{self, MessageId, MessageType};
use crate::trajectory::TrajectoryData;

messages! {
    /// Message from the client, or host. Each row states how the message may be treated: see
    /// [`Conduct`](crate::Conduct).
    pub enum HostMessage<'a> from host {
        /// Shows that the line is in use. Sent every four seconds over USB.
        0x0000_00_00 => KeepAlive(KeepAlive<'a>) [sets],
        /// Asks for the address of the device in the network.
        0x0002_01_00 => GetNetworkInfo(GetNetworkInfo<'a>) [asks],
        /// Asks for the state of the lamps.
        0x0007_01_00 => GetLEDStatus(GetLEDStatus<'a>) [asks],
        /// Switches the lamps.
        0x0007_00_00 => SetLEDStatus(LEDStatus<'a>) [sets],
        /// Asks for the positions, ranges and limits of the motors.
        0x000B_01_00 => GetMotorInfo(GetMotorInfo<'a>) [asks],
        /// Asks for the type and the state of the device. The first message of a connection.
        0x000F_01_00 => GetDeviceInfo(GetDeviceInfo<'a>) [asks],
        /// Tells the password of this session.
        0x0010_00_00 => SetUserPassword(UserPassword<'a>) [sets],
        /// Stores another password in the device, which locks this session until the new password is sent.
        0x0011_00_00 => SetDevicePassword(DevicePassword<'a>) [sets once],
        /// Asks for the stored move.
        0x0012_01_00 => GetTrajectoryData(GetTrajectoryData<'a>) [asks],
        /// Stores a move.
        0x0012_00_00 => SetTrajectoryData(TrajectoryData<'a>) [arms once],
        /// Asks for the number that no other device has.
        0x001F_01_00 => GetDeviceGUID(GetDeviceGUID<'a>) [asks],
        /// Asks which platform calibrated the motors.
        0x0026_01_00 => GetSoftwareID(GetSoftwareID<'a>) [asks],
        /// Stores which platform calibrates the motors.
        0x0026_00_00 => SetSoftwareID(SoftwareID<'a>) [sets],
        /// Restarts the device. The connection is lost.
        0x0080_00_01 => ResetDevice(ResetDevice<'a>) [resets once],
        /// Forgets the range of a motor, or of all motors.
        0x0080_00_02 => ResetAxis(ResetAxis<'a>) [sets once],
        /// Sets the begin of the range of a motor to its present position.
        0x0080_00_03 => MarkBeginPosition(MarkBeginPosition<'a>) [sets once],
        /// Sets the end of the range of a motor to its present position.
        0x0080_00_04 => MarkEndPosition(MarkEndPosition<'a>) [sets once],
        /// Starts the stored move.
        0x0080_00_05 => StartPlayback(StartPlayback<'a>) [moves once],
        /// Stops everything, also while locked (safety decisions 2 and 8).
        0x0080_00_06 => StopPlayback(StopPlayback<'a>) [stops],
        /// Sends the motors to the position where the move begins.
        0x0080_00_07 => RapidToFirstKeyFrame(RapidToFirstKeyFrame<'a>) [moves once],
        /// Takes one photo.
        0x0080_00_09 => TakePicture(TakePicture<'a>) [sets once],
        /// Prepares the stored move to be played.
        0x0080_00_0F => SetupPlayback(SetupPlayback<'a>) [arms once],
        /// Sends a motor to a position, or stops it.
        0x0080_00_1C => SetPositionSpeedAcceleration(SetPositionSpeedAcceleration<'a>)
            [by SetPositionSpeedAcceleration::conduct],
        /// Sends a motor by a distance, or stops it.
        0x0080_00_28 => BumpPositionSpeedAcceleration(BumpPositionSpeedAcceleration<'a>)
            [by BumpPositionSpeedAcceleration::conduct],
    }
}

messages! {
    /// Message from the device.
    // A tag of its own. If the tag hides in a field of a body, code that decodes and matches cannot jump from one to the other:
    // 117 instead of 92 instructions for a message of the small mix.
    #[repr(u8)]
    pub enum DeviceMessage<'a> {
        /// Address of the device in the network, sent as an answer or unasked.
        0x0002_02_00 => NetworkInfo(NetworkInfo<'a>),
        /// State of the lamps.
        0x0007_02_00 => LEDStatus(LEDStatus<'a>),
        /// Positions, ranges and limits of motors. The type is 0x82 in all messages of an answer except the last.
        0x000B_02_00 | 0x000B_82_00 => MotorInfo(MotorInfo<'a>),
        /// Type and present state of the device.
        0x000F_02_00 => DeviceInfo(DeviceInfo<'a>),
        /// Stored move. A message without blocks says that no move is stored.
        0x0012_02_00 => TrajectoryData(TrajectoryData<'a>),
        /// Number of the device, which no other device has.
        0x001F_02_00 => DeviceGUID(DeviceGUID<'a>),
        /// Platform that calibrated the motors.
        0x0026_02_00 => SoftwareID(SoftwareID<'a>),
        /// Motors that were connected or disconnected.
        0x0081_02_01 => MotorStatus(MotorStatus<'a>),
        /// Progress of the device in its move.
        0x0081_02_02 => PlaybackStatus(PlaybackStatus<'a>),
        /// Error that the device reports.
        0x0081_02_03 => ErrorStatus(ErrorStatus<'a>),
        /// Position of a motor that came to rest.
        0x0081_02_07 => MotorPosition(MotorPosition<'a>),
        /// Range of a motor that was calibrated or reset.
        0x0081_02_11 => MotorCalibrated(MotorCalibrated<'a>),
        /// Inputs for cameras and triggers, sent when one of them changed.
        0x0081_02_15 => AuxInputStatus(AuxInputStatus<'a>),
        /// Message that the device does not know.
        0x0081_02_FF => UnsupportedMessage(UnsupportedMessage<'a>),
    }
}

/// Fields of a message after the number of its action or notification, `action_id` or `note_id`, as the conformance
/// vectors show them.
#[doc(hidden)]
#[derive(Debug, Clone, Copy)]
pub struct Numbered<'m, M>(pub &'m M);

impl<'a, M: Messages<'a>> Fields for Numbered<'_, M> {
    fn fields(&self, visitor: &mut dyn Visitor) {
        if let (_, kind, Some((_, sub))) = frame::parts(self.0.number()) {
            let name = if kind == MessageType::SET { "action_id" } else { "note_id" };
            visitor.visit(&FieldView { name, unit: "", value: Value::Unsigned(sub.into()), text: &sub });
        }
        self.0.fields(visitor);
    }
}

macro_rules! specified {
    ($($side:ident)*) => {$(
        impl $side<'_> {
            /// Id of the message, which says its subject.
            #[must_use]
            #[inline]
            pub fn id(&self) -> MessageId {
                frame::parts(self.number()).0
            }

            /// Type of the message: whether it sets, asks or answers.
            #[must_use]
            #[inline]
            pub fn kind(&self) -> MessageType {
                frame::parts(self.number()).1
            }

            /// Name of the message in the specification, which does not say whether it sets or asks: `LEDStatus`,
            /// `StartPlayback`. `Action` or `Notification` if only its number is known, otherwise `Other`.
            #[must_use]
            pub fn specification_name(&self) -> &'static str {
                let name = self.name();
                match frame::parts(self.number()) {
                    (_, _, Some((what, _))) => if name == "Other" { what } else { name },
                    (_, MessageType::GET, None) => name.strip_prefix("Get").unwrap_or(name),
                    (_, MessageType::SET, None) => name.strip_prefix("Set").unwrap_or(name),
                    _ => name,
                }
            }
        }
    )*};
}
specified! { HostMessage DeviceMessage }
