//! The messages, a file a chapter of the specification.
//!
//! A message is known by its id and its type together, an action or a notification by its own number as well. In the
//! tables the three stand in one number, `0x0080_00_1C`: id, type, and the number of the action or notification,
//! otherwise 0. [`HostMessage`] is what a client sends, [`DeviceMessage`] what a device sends.

#![expect(clippy::unusual_byte_groupings, reason = "the groups are id, type, and number of the action or notification")]

mod action;
mod device;
mod dialect;
mod motor;
mod notification;
mod units;

pub use action::{
    BumpPositionSpeedAcceleration, JOG_DISTANCE, MarkBeginPosition, MarkEndPosition, PlaybackDirection, ResetAxis,
    SetPositionSpeedAcceleration, SetupPlayback, StartPlayback, TakePicture,
};
pub use device::{
    AuxInputs, DeviceGUID, DeviceInfo, DeviceType, FirmwareVersion, GetNetworkInfo, Ipv4, LEDStatus, LedMode,
    MacAddress, NetworkInfo, PlaybackMode, SetPassword, SoftwareID,
};
pub use motion_core::wire::{Empty, Other};
pub use motor::{AxisKind, Motor, MotorEntry, MotorInfo, MotorInfos, OldMotorEntry};
pub use notification::{
    AuxInputStatus, ErrorCode, ErrorStatus, MotorCalibrated, MotorPlace, MotorPosition, MotorPresence, MotorStatus,
    MotorType, Photos, PlaybackState, PlaybackStatus, UnsupportedMessage,
};
pub use units::{MotorAddress, Normalized, Rotations, RotationsPerSecond, RotationsPerSecondSquared, Seconds};

use motion_core::messages;
use motion_core::wire::{DecodeError, EncodeError, FieldView, Fields, Messages, Value, Visitor};

use crate::frame::{self, Frame, MessageId, MessageType};
use crate::lint::Context;
use crate::trajectory::TrajectoryData;

messages! {
    /// What a client, the host, sends.
    pub enum HostMessage<'a> {
        /// The line is in use: every four seconds over USB.
        0x0000_00_00 => KeepAlive(Empty<'a>),
        /// Where are you in the network?
        0x0002_01_00 => GetNetworkInfo(GetNetworkInfo<'a>),
        /// What do the lamps do?
        0x0007_01_00 => GetLEDStatus(Empty<'a>),
        /// Switch the lamps.
        0x0007_00_00 => SetLEDStatus(LEDStatus<'a>),
        /// Where are the motors, and how far do they go?
        0x000B_01_00 => GetMotorInfo(Empty<'a>),
        /// What are you, and what do you do just now? The first message of a connection.
        0x000F_01_00 => GetDeviceInfo(Empty<'a>),
        /// The password of this session.
        0x0010_00_00 => SetUserPassword(SetPassword<'a>),
        /// Store another password; it locks this session until the new one is sent.
        0x0011_00_00 => SetDevicePassword(SetPassword<'a>),
        /// Which move have you stored?
        0x0012_01_00 => GetTrajectoryData(Empty<'a>),
        /// Store this move.
        0x0012_00_00 => SetTrajectoryData(TrajectoryData<'a>),
        /// Which of all devices are you?
        0x001F_01_00 => GetDeviceGUID(Empty<'a>),
        /// Which platform calibrated the motors?
        0x0026_01_00 => GetSoftwareID(Empty<'a>),
        /// This platform calibrates the motors.
        0x0026_00_00 => SetSoftwareID(SoftwareID<'a>),
        /// Start anew: the connection is lost.
        0x0080_00_01 => ResetDevice(Empty<'a>),
        /// Forget the range of a motor, or of all.
        0x0080_00_02 => ResetAxis(ResetAxis<'a>),
        /// The range of a motor begins here.
        0x0080_00_03 => MarkBeginPosition(MarkBeginPosition<'a>),
        /// The range of a motor ends here.
        0x0080_00_04 => MarkEndPosition(MarkEndPosition<'a>),
        /// Play the move.
        0x0080_00_05 => StartPlayback(StartPlayback<'a>),
        /// Stop everything, also while locked (safety decisions 2 and 8).
        0x0080_00_06 => StopPlayback(Empty<'a>),
        /// Go to where the move begins.
        0x0080_00_07 => RapidToFirstKeyFrame(Empty<'a>),
        /// Take one photo.
        0x0080_00_09 => TakePicture(TakePicture<'a>),
        /// Get ready to play the move.
        0x0080_00_0F => SetupPlayback(SetupPlayback<'a>),
        /// Go to a position, or stop.
        0x0080_00_1C => SetPositionSpeedAcceleration(SetPositionSpeedAcceleration<'a>),
        /// Go a distance, or stop.
        0x0080_00_28 => BumpPositionSpeedAcceleration(BumpPositionSpeedAcceleration<'a>),
    }
}

messages! {
    /// What a device sends.
    pub enum DeviceMessage<'a> {
        /// Where I am in the network, asked or not.
        0x0002_02_00 => NetworkInfo(NetworkInfo<'a>),
        /// What the lamps do.
        0x0007_02_00 => LEDStatus(LEDStatus<'a>),
        /// Where motors are and how far they go; under the type 0x82 until the last.
        0x000B_02_00 | 0x000B_82_00 => MotorInfo(MotorInfo<'a>),
        /// What I am, and what I do just now.
        0x000F_02_00 => DeviceInfo(DeviceInfo<'a>),
        /// The move that is stored; without blocks, none is.
        0x0012_02_00 => TrajectoryData(TrajectoryData<'a>),
        /// Which of all devices I am.
        0x001F_02_00 => DeviceGUID(DeviceGUID<'a>),
        /// Which platform calibrated the motors.
        0x0026_02_00 => SoftwareID(SoftwareID<'a>),
        /// Motors came or went.
        0x0081_02_01 => MotorStatus(MotorStatus<'a>),
        /// How far I am with the move.
        0x0081_02_02 => PlaybackStatus(PlaybackStatus<'a>),
        /// Something failed.
        0x0081_02_03 => ErrorStatus(ErrorStatus<'a>),
        /// A motor rests.
        0x0081_02_07 => MotorPosition(MotorPosition<'a>),
        /// The range of a motor is known, or known no more.
        0x0081_02_11 => MotorCalibrated(MotorCalibrated<'a>),
        /// An input changed.
        0x0081_02_15 => AuxInputStatus(AuxInputStatus<'a>),
        /// I do not know that message.
        0x0081_02_FF => UnsupportedMessage(UnsupportedMessage<'a>),
    }
}

/// The fields of a message with the number of the action or notification before them, as the conformance vectors show
/// it: `action_id` or `note_id`.
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

macro_rules! sides {
    ($($side:ident)*) => {$(
        impl<'a> $side<'a> {
            /// Decodes a message from this side.
            ///
            /// An id, type, action or notification that is not known from this side gives `Other`, never an error.
            ///
            /// # Errors
            ///
            /// [`DecodeError`], if the body ends before the fields of its kind do. The frame itself is sound.
            // Who matches on the message at once, as all do, then never builds it.
            #[inline(always)]
            pub fn decode(frame: &Frame<'a>) -> Result<Self, DecodeError> {
                let (number, body) = frame.number_and_body()?;
                Self::decode_body(number, body)
            }

            /// What it is about.
            #[must_use]
            #[inline]
            pub fn id(&self) -> MessageId {
                frame::parts(self.number()).0
            }

            /// Whether it sets, asks or answers.
            #[must_use]
            #[inline]
            pub fn kind(&self) -> MessageType {
                frame::parts(self.number()).1
            }

            /// What the specification calls it, without saying whether it sets or asks: `LEDStatus`, `StartPlayback`;
            /// `Action` or `Notification` where only its number is known, otherwise `Other`.
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

            /// Bytes of the whole message, header included.
            #[must_use]
            #[inline]
            pub fn encoded_len(&self) -> usize {
                frame::message_len(self)
            }

            /// Writes the whole message to the front of `out`, and says how many bytes it took.
            ///
            /// # Errors
            ///
            /// [`EncodeError`], if it does not fit, or a reader would take it for something else.
            #[inline]
            pub fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
                frame::encode_message(self, out)
            }

            /// Writes it like [`encode_into`](Self::encode_into), unless [`lint`](Self::lint) finds an error.
            ///
            /// # Errors
            ///
            /// [`EncodeError::Refused`] with the first error that was found, and those of `encode_into`.
            pub fn encode_checked(&self, context: &Context<'_>, out: &mut [u8]) -> Result<usize, EncodeError> {
                match self.lint(context).first_error() {
                    Some(error) => Err(EncodeError::Refused(error)),
                    None => self.encode_into(out),
                }
            }
        }
    )*};
}
sides! { HostMessage DeviceMessage }
