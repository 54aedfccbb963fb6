//! Messages, one file for each chapter of the specification.
//!
//! Nothing in a frame says who sent it, and the same type has different data in each direction. So there are two enums, one
//! for each side: [`HostMessage`] is what Dragonframe sends, [`DeviceMessage`] is what a controller sends (decision D-4).

mod connection;
mod motor;
mod outputs;
mod real_time;
mod set;
mod upload;
mod virt_config;
mod virtuals;

pub use connection::{Ack, AckCode, Capabilities, Hi, HiRequest, Name};
pub use motion_core::fixed::{Centi, Deci, Milli, Scaled};
pub use motion_core::wire::{Bool, ListTooLong, Other, fill, values};
pub use motor::{
    Acceleration, HardStop, HardwareLimitSet, JogSpeed, Motor, MotorConfigure, MotorFlags, MotorGetPosition, MotorJog,
    MotorMove, MotorMoving, MotorPositions, MotorResetPosition, MotorSetLimits, MotorSetSpeed, MotorStatus,
    MotorStatusRequest, MotorStop, MotorStopAll, Motors, MoveTime, Speed, Steps, StopFlags, StopReason,
};
pub use outputs::{CameraFlags, Dmx, GioCam, GioIn, GioInRequest, GioOut, Triggers};
pub use real_time::{
    BloopOutputs, BlurPercent, Degrees, Direction, DmxChannel, FrameNumber, FramesPerSecond, Milliseconds, MotorPair,
    RtEnd, RtGo, RtJogAll, RtPositionFrame, RtRunMove, RtShootFrame, RtShootFrame2, RtStopLoop, RunFlags,
    ShortMilliseconds,
};
pub use upload::{
    RtUploadMoveAxis, RtUploadMoveBegin, RtUploadMoveDmx, RtUploadMoveEnd, RtUploadMoveTriggers, StartIndex,
    TriggerPair,
};
pub use virt_config::{
    BoomRig, BoomSwingTrack, BoomTable, Length, OpaqueRig, RigKind, RigMotor, StepsPerUnit, SwingPan, VirtConfig,
};
pub use virtuals::{
    Coordinate, LineAxis, LineSpeed, VirtAimPoint, VirtGetPosition, VirtJog, VirtJogOnLine, VirtMove, VirtPositions,
    VirtStop, VirtualMotor, VirtualPosition,
};
/// Number of 32 bits as it stands in a frame: the element of lists of positions.
pub use zerocopy::little_endian::I32;

use motion_core::messages;
use motion_core::wire::Messages;

use crate::frame::MessageType;

messages! {
    /// Messages of Dragonframe, the host.
    pub enum HostMessage<'a> from host {
        /// Asks the device who it is. The first message of a connection.
        0x0001 => Hi(HiRequest<'a>) [asks],
        /// Sets the levels of lights.
        0x0020 => Dmx(Dmx<'a>) [sets],
        /// Switches outputs.
        0x0021 => GioOut(GioOut<'a>) [sets],
        /// Asks which inputs are on.
        0x0022 => GioIn(GioInRequest<'a>) [asks],
        /// Switches the outputs of the camera, to try them.
        0x0023 => GioCam(GioCam<'a>) [sets],
        /// Asks which motors move.
        0x0030 => MotorStatus(MotorStatusRequest<'a>) [asks],
        /// Sends a motor to a position.
        0x0031 => MotorMove(MotorMove<'a>) [moves],
        /// Stops one motor.
        0x0032 => MotorStop(MotorStop<'a>) [stops],
        /// Stops everything.
        0x0033 => MotorStopAll(MotorStopAll<'a>) [stops],
        /// Asks where the motors are.
        0x0034 => MotorGetPosition(MotorGetPosition<'a>) [asks],
        /// Gives the place where a motor stands another number.
        0x0035 => MotorResetPosition(MotorResetPosition<'a>) [sets once],
        /// Runs a motor towards a position until another request.
        0x0036 => MotorJog(MotorJog<'a>) [moves once],
        /// Sets the uses of a motor.
        0x0037 => MotorConfigure(MotorConfigure<'a>) [sets],
        /// Sets the greatest speed and acceleration of a motor.
        0x0038 => MotorSetSpeed(MotorSetSpeed<'a>) [sets],
        /// Sets the limits of a motor.
        0x0039 => MotorSetLimits(MotorSetLimits<'a>) [sets],
        /// Begins the upload of a move.
        0x0100 => RtUploadMoveBegin(RtUploadMoveBegin<'a>) [sets, in sequence],
        /// Section of the positions of one motor in a move.
        0x0101 => RtUploadMoveAxis(RtUploadMoveAxis<'a>) [sets, in sequence],
        /// Section of the levels of one DMX channel in a move.
        0x0102 => RtUploadMoveDmx(RtUploadMoveDmx<'a>) [sets, in sequence],
        /// Ends the upload of a move.
        0x0103 => RtUploadMoveEnd(RtUploadMoveEnd<'a>) [sets, in sequence],
        /// Section of the outputs that are on in a move.
        0x0104 => RtUploadMoveTriggers(RtUploadMoveTriggers<'a>) [sets, in sequence],
        /// Sends all motors to a frame of the move.
        0x0110 => RtPositionFrame(RtPositionFrame<'a>) [moves, in sequence],
        /// Prepares a run of the uploaded move.
        0x0111 => RtRunMove(RtRunMove<'a>) [arms once, in sequence],
        /// Prepares a motion through one frame while the shutter is open.
        0x0112 => RtShootFrame(RtShootFrame<'a>) [arms once, in sequence],
        /// Starts what the device prepared.
        0x0113 => RtGo(RtGo<'a>) [moves once, in sequence],
        /// Prepares a motion through one frame, with a shutter that is described by its angles.
        0x0115 => RtShootFrame2(RtShootFrame2<'a>) [arms once, in sequence],
        /// Ends a loop at its next end point.
        0x0116 => RtStopLoop(RtStopLoop<'a>) [sets],
        /// Runs all motors towards a frame of the move.
        0x0120 => RtJogAll(RtJogAll<'a>) [moves once, in sequence],
        /// Describes the rig that the virtual motors belong to.
        0x0200 => VirtConfig(VirtConfig<'a>) [sets],
        /// Sends a virtual motor to a position.
        0x0201 => VirtMove(VirtMove<'a>) [moves],
        /// Stops a virtual motor.
        0x0202 => VirtStop(VirtStop<'a>) [stops],
        /// Runs a virtual motor until another request.
        0x0203 => VirtJog(VirtJog<'a>) [moves once],
        /// Asks where the virtual motors are.
        0x0205 => VirtGetPosition(VirtGetPosition<'a>) [asks],
        /// Runs the camera along a line until another request.
        0x0206 => VirtJogOnLine(VirtJogOnLine<'a>) [moves once],
        /// Keeps the camera aimed at a point, or ends that.
        0x0207 => VirtAimPoint(VirtAimPoint<'a>) [moves],
    }
}

messages! {
    /// Messages of a controller, the device.
    pub enum DeviceMessage<'a> {
        /// Tells who the device is, as an answer or at boot.
        0x0001 => Hi(Hi<'a>),
        /// Tells which inputs are on, as an answer or because they changed.
        0x0022 => GioIn(GioIn<'a>),
        /// Tells which motors move.
        0x0030 => MotorStatus(MotorStatus<'a>),
        /// Tells whether the motor moves now.
        0x0031 => MotorMove(MotorMoving<'a>),
        /// Tells where the motors are, as an answer or while they move.
        0x0034 => MotorGetPosition(MotorPositions<'a>),
        /// Tells that a motor ran into a limit, or that everything was stopped. It is sent unasked.
        0x003A => MotorHardStop(HardStop<'a>),
        /// Tells that the operator started what the device had prepared. The vendor's firmware sends it unasked.
        0x0113 => RtGo(RtGo<'a>),
        /// Tells that the move, or the frame, is done. It is sent unasked.
        0x0114 => RtEnd(RtEnd<'a>),
        /// Tells where the virtual motors are.
        0x0205 => VirtGetPosition(VirtPositions<'a>),
        /// Tells what the camera is aimed at.
        0x0207 => VirtAimPoint(VirtAimPoint<'a>),
        /// Tells that a request was done, or why it was not done.
        0x8000..=0xFFFF => Ack(Ack<'a>),
    }
}

macro_rules! kinds {
    ($($side:ident)*) => {$(
        impl $side<'_> {
            /// Type under which the message is sent.
            #[must_use]
            #[inline]
            pub fn kind(&self) -> MessageType {
                MessageType::of(self.number())
            }
        }
    )*};
}
kinds! { HostMessage DeviceMessage }

impl HostMessage<'_> {
    /// Whether the message lets a device open the shutter of the camera: by hand, in a shot, or in a run with photos. Source:
    /// DMC, `MSG_GIO_CAM`, `MSG_RT_RUN_MOVE` and `MSG_RT_SHOOT_FRAME`.
    #[must_use]
    pub fn opens_shutter(&self) -> bool {
        match self {
            Self::GioCam(message) => message.flags.contains(CameraFlags::SHUTTER),
            Self::RtRunMove(run) => run.flags.unwrap_or_default().contains(RunFlags::CAMERA_EVERY_FRAME),
            Self::RtShootFrame(_) | Self::RtShootFrame2(_) => true,
            _ => false,
        }
    }
}
