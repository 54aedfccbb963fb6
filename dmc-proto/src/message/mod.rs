//! The messages, a file a chapter of the specification.
//!
//! Nothing in a frame says who sent it, and one type has different data in each direction. So there are two enums, by
//! who sends: [`HostMessage`] is what Dragonframe sends, [`DeviceMessage`] what a controller sends (decision D-4).

mod conduct;
mod connection;
mod motor;
mod outputs;
mod real_time;
mod set;
mod upload;
mod virt_config;
mod virtuals;

pub use connection::{Ack, AckCode, Capabilities, Hi, Name};
pub use motion_core::wire::{Empty, Other};
pub use motor::{
    Acceleration, HardStop, HardwareLimitSet, JogSpeed, Motor, MotorConfigure, MotorFlags, MotorJog, MotorMove,
    MotorMoving, MotorPositions, MotorResetPosition, MotorSetLimits, MotorSetSpeed, MotorStatus, MotorStop,
    MotorStopAll, Motors, MoveTime, Speed, Steps, StopFlags, StopReason,
};
pub use outputs::{CameraFlags, Dmx, GioCam, GioIn, GioOut, Triggers};
pub use real_time::{
    BloopOutputs, BlurPercent, Degrees, Direction, DmxChannel, FrameNumber, FramesPerSecond, Milliseconds, MotorPair,
    RtJogAll, RtPositionFrame, RtRunMove, RtShootFrame, RtShootFrame2, RunFlags, ShortMilliseconds,
};
pub use upload::{RtUploadMoveAxis, RtUploadMoveBegin, RtUploadMoveDmx, RtUploadMoveTriggers, StartIndex, TriggerPair};
pub use virt_config::{
    BoomRig, BoomSwingTrack, BoomTable, Length, OpaqueRig, RigKind, RigMotor, StepsPerUnit, SwingPan, VirtConfig,
};
pub use virtuals::{
    Coordinate, LineAxis, LineSpeed, VirtAimPoint, VirtJog, VirtJogOnLine, VirtMove, VirtPositions, VirtStop,
    VirtualMotor, VirtualPosition,
};

use motion_core::messages;
use motion_core::wire::{DecodeError, EncodeError, Messages};

use crate::frame::{self, Frame, MessageId, MessageType};

messages! {
    /// What Dragonframe, the host, sends.
    pub enum HostMessage<'a> {
        /// Who are you? The first message of a connection.
        0x0001 => Hi(Empty<'a>),
        /// Set lights.
        0x0020 => Dmx(Dmx<'a>),
        /// Switch outputs.
        0x0021 => GioOut(GioOut<'a>),
        /// Which inputs are on?
        0x0022 => GioIn(Empty<'a>),
        /// Try the outputs of the camera.
        0x0023 => GioCam(GioCam<'a>),
        /// Which motors move?
        0x0030 => MotorStatus(Empty<'a>),
        /// Go to a position.
        0x0031 => MotorMove(MotorMove<'a>),
        /// Stop one motor.
        0x0032 => MotorStop(MotorStop<'a>),
        /// Stop everything.
        0x0033 => MotorStopAll(MotorStopAll<'a>),
        /// Where are the motors?
        0x0034 => MotorGetPosition(Empty<'a>),
        /// Call the place where a motor stands by another number.
        0x0035 => MotorResetPosition(MotorResetPosition<'a>),
        /// Run towards a position until told otherwise.
        0x0036 => MotorJog(MotorJog<'a>),
        /// What a motor is used for.
        0x0037 => MotorConfigure(MotorConfigure<'a>),
        /// How fast a motor may be.
        0x0038 => MotorSetSpeed(MotorSetSpeed<'a>),
        /// How far a motor may go.
        0x0039 => MotorSetLimits(MotorSetLimits<'a>),
        /// Begin the upload of a move.
        0x0100 => RtUploadMoveBegin(RtUploadMoveBegin<'a>),
        /// One section of one motor's positions of a move.
        0x0101 => RtUploadMoveAxis(RtUploadMoveAxis<'a>),
        /// One section of one DMX channel's levels of a move.
        0x0102 => RtUploadMoveDmx(RtUploadMoveDmx<'a>),
        /// The upload is complete.
        0x0103 => RtUploadMoveEnd(Empty<'a>),
        /// Which outputs are on at which frames of a move.
        0x0104 => RtUploadMoveTriggers(RtUploadMoveTriggers<'a>),
        /// Send all motors to a frame of the move.
        0x0110 => RtPositionFrame(RtPositionFrame<'a>),
        /// Get ready to run the uploaded move.
        0x0111 => RtRunMove(RtRunMove<'a>),
        /// Get ready to move through one frame while the shutter is open.
        0x0112 => RtShootFrame(RtShootFrame<'a>),
        /// Start what the device got ready for.
        0x0113 => RtGo(Empty<'a>),
        /// Get ready to move through one frame, with a shutter that is described by its angles.
        0x0115 => RtShootFrame2(RtShootFrame2<'a>),
        /// End the loop at its next end point.
        0x0116 => RtStopLoop(Empty<'a>),
        /// Run all motors towards a frame of the move.
        0x0120 => RtJogAll(RtJogAll<'a>),
        /// What the virtual motors are made of.
        0x0200 => VirtConfig(VirtConfig<'a>),
        /// Send a virtual motor to a position.
        0x0201 => VirtMove(VirtMove<'a>),
        /// Stop a virtual motor.
        0x0202 => VirtStop(VirtStop<'a>),
        /// Run a virtual motor until told otherwise.
        0x0203 => VirtJog(VirtJog<'a>),
        /// Where are the virtual motors?
        0x0205 => VirtGetPosition(Empty<'a>),
        /// Run the camera along a line until told otherwise.
        0x0206 => VirtJogOnLine(VirtJogOnLine<'a>),
        /// Keep the camera aimed at a point, or not.
        0x0207 => VirtAimPoint(VirtAimPoint<'a>),
    }
}

messages! {
    /// What a controller, the device, sends.
    pub enum DeviceMessage<'a> {
        /// Who I am, asked or at boot.
        0x0001 => Hi(Hi<'a>),
        /// Which inputs are on, asked or because they changed.
        0x0022 => GioIn(GioIn<'a>),
        /// Which motors move.
        0x0030 => MotorStatus(MotorStatus<'a>),
        /// Whether the motor moves now.
        0x0031 => MotorMove(MotorMoving<'a>),
        /// Where the motors are, asked or while they move.
        0x0034 => MotorGetPosition(MotorPositions<'a>),
        /// A motor ran into a limit, or everything was stopped: sent unasked.
        0x003A => MotorHardStop(HardStop<'a>),
        /// The operator started what the device had got ready for: sent unasked, by the vendor's firmware.
        0x0113 => RtGo(Empty<'a>),
        /// The move, or the frame, is done: sent unasked.
        0x0114 => RtEnd(Empty<'a>),
        /// Where the virtual motors are.
        0x0205 => VirtGetPosition(VirtPositions<'a>),
        /// What the camera is aimed at.
        0x0207 => VirtAimPoint(VirtAimPoint<'a>),
        /// Done, or why not.
        0x8000..=0xFFFF => Ack(Ack<'a>),
    }
}

macro_rules! sides {
    ($($side:ident)*) => {$(
        impl<'a> $side<'a> {
            /// Decodes the data of a frame from this side.
            ///
            /// A type that is not known from this side gives `Other`, never an error.
            ///
            /// # Errors
            ///
            /// [`DecodeError`], if the data ends before the fields of its type do. The frame itself is sound.
            #[inline]
            pub fn decode(frame: &Frame<'a>) -> Result<Self, DecodeError> {
                Self::decode_body(frame.kind().0.into(), frame.payload())
            }

            /// The type it is sent under.
            #[must_use]
            #[inline]
            pub fn kind(&self) -> MessageType {
                MessageType(u16::try_from(self.number()).unwrap_or(u16::MAX))
            }

            /// Bytes of its whole frame.
            #[must_use]
            #[inline]
            pub fn encoded_len(&self) -> usize {
                frame::frame_len(self.body_len())
            }

            /// Writes its whole frame to the front of `out`, and says how many bytes it took.
            ///
            /// # Errors
            ///
            /// [`EncodeError`], if the frame does not fit, or a reader would take it for something else.
            #[inline]
            pub fn encode_into(&self, id: MessageId, out: &mut [u8]) -> Result<usize, EncodeError> {
                frame::encode_message(self, id, out)
            }
        }
    )*};
}
sides! { HostMessage DeviceMessage }
