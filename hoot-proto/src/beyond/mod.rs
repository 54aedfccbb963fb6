//! Commands of later firmware, beyond the published sheet.
//!
//! They are kept apart: the sheet's firmware has none of them, no vector was recorded of them, and they come from reading
//! the public sources only. [`crate::HostMessage`] gives them as `Other`; [`HostMessage`] reads them. What answers them
//! is said at each; read it by the type that it comes with, [`Reply::value`](crate::message::Reply::value).
//!
//! Of more commands only the numbers are known here, and they stay `Other`: 30 to 33, 131 to 133, 252 and 253 of the
//! controller, 32, 40 to 42 and 120 to 124 of a motor, 113 of the camera. Source: hoot, section 7.
//!
//! ```
//! use hoot_proto::beyond::{HostMessage, MotorSendTo};
//! use hoot_proto::message::{Motor, Steps};
//! use hoot_proto::{Address, Frame};
//!
//! let message = HostMessage::MotorSendTo(MotorSendTo { motor: Motor::Two, position: Steps(-2) });
//! let mut out = [0; 42];
//! let len = message.encode_into(Address::DEFAULT, &mut out)?;
//! assert_eq!(out[..len], *b"\0\0\0\0\0\xFF\x03\x02\x1F\x04\xFF\xFF\xFF\xFE");
//!
//! let frame = Frame::decode(&out[..len]).unwrap();
//! assert_eq!(HostMessage::decode(&frame), message);
//! assert!(matches!(hoot_proto::HostMessage::decode(&frame), hoot_proto::HostMessage::Other(_)));
//! # Ok::<(), hoot_proto::EncodeError>(())
//! ```

mod key_frames;
mod node;

pub use key_frames::*;
pub use node::*;

use motion_core::messages;
use motion_core::wire::Messages;

use crate::message::commands;

messages! {
    /// What the master sends to later firmware, beyond [`crate::HostMessage`]. The numbers count as there.
    pub enum HostMessage<'a> {
        /// Command 25 of the controller.
        0x19_00 => SendAllToStart(SendAllToStart),
        /// Command 26 of the controller.
        0x1A_00 => SetStartHere(SetStartHere),
        /// Command 27 of the controller.
        0x1B_00 => SetStopHere(SetStopHere),
        /// Command 28 of the controller.
        0x1C_00 => SetFrameRate(SetFrameRate),
        /// Command 29 of the controller.
        0x1D_00 => SwapStartAndStop(SwapStartAndStop),
        /// Command 50 of the controller.
        0x32_00 => SetGraffikMode(SetGraffikMode),
        /// Command 51 of the controller.
        0x33_00 => SetAppMode(SetAppMode),
        /// Query 122 of the controller.
        0x7A_00 => ManualMove(ManualMove),
        /// Query 123 of the controller.
        0x7B_00 => PercentDone(PercentDone),
        /// Query 124 of the controller.
        0x7C_00 => MotorsAttached(MotorsAttached),
        /// Query 125 of the controller.
        0x7D_00 => TotalTime(TotalTime),
        /// Query 126 of the controller.
        0x7E_00 => IsComplete(IsComplete),
        /// Query 127 of the controller.
        0x7F_00 => FrameRateQuery(FrameRateQuery),
        /// Query 128 of the controller.
        0x80_00 => AnyRunning(AnyRunning),
        /// Query 129 of the controller.
        0x81_00 => IsValid(IsValid),
        /// Query 130 of the controller.
        0x82_00 => MotorsAsleep(MotorsAsleep),
        /// Query 134 of the controller.
        0x86_00 => ControllerCount(ControllerCount),
        /// Query 140 of the controller.
        0x8C_00 => Status(StatusQuery),
        /// Query 150 of the controller.
        0x96_00 => GraffikMode(GraffikMode),
        /// Query 200 of the controller.
        0xC8_00 => FreeMemory(FreeMemory),
        /// Command 254 of the controller.
        0xFE_00 => SetDebugOutput(SetDebugOutput),
        /// Command 255 of the controller.
        0xFF_00 => TestYourself(TestYourself),

        /// Command 25 of a motor.
        0x19_01..=0x19_03 => MotorSetLeadOut(MotorSetLeadOut),
        /// Command 28 of a motor.
        0x1C_01..=0x1C_03 => MotorFindMicrostep(MotorFindMicrostep),
        /// Command 29 of a motor.
        0x1D_01..=0x1D_03 => MotorSetStartHere(MotorSetStartHere),
        /// Command 30 of a motor.
        0x1E_01..=0x1E_03 => MotorSetStopHere(MotorSetStopHere),
        /// Command 31 of a motor.
        0x1F_01..=0x1F_03 => MotorSendTo(MotorSendTo),
        /// Command 33 of a motor.
        0x21_01..=0x21_03 => MotorSetEnd(MotorSetEnd),
        /// Command 50 of a motor.
        0x32_01..=0x32_03 => MotorSetStopMotion(MotorSetStopMotion),
        /// Command 51 of a motor.
        0x33_01..=0x33_03 => MotorStepForward(MotorStepForward),
        /// Command 52 of a motor.
        0x34_01..=0x34_03 => MotorStepBack(MotorStepBack),
        /// Query 118 of a motor.
        0x76_01..=0x76_03 => MotorIsValid(MotorIsValid),
        /// Query 119 of a motor.
        0x77_01..=0x77_03 => MotorLeadOut(MotorLeadOut),

        /// Command 11 of the camera.
        0x0B_04 => CameraSetTestMode(CameraSetTestMode),
        /// Command 12 of the camera.
        0x0C_04 => CameraSetKeepAlive(CameraSetKeepAlive),
        /// Command 13 of the camera.
        0x0D_04 => CameraSetIntervalometer(CameraSetIntervalometer),
        /// Query 109 of the camera.
        0x6D_04 => CameraShots(CameraShots),
        /// Query 110 of the camera.
        0x6E_04 => CameraTestMode(CameraTestMode),
        /// Query 111 of the camera.
        0x6F_04 => CameraKeepAlive(CameraKeepAlive),
        /// Query 112 of the camera.
        0x70_04 => CameraIntervalometer(CameraIntervalometer),

        /// Command 10 of the key frames.
        0x0A_05 => KeySetAxis(KeySetAxis),
        /// Command 11 of the key frames.
        0x0B_05 => KeySetCount(KeySetCount),
        /// Command 12 of the key frames.
        0x0C_05 => KeySetTime(KeySetTime),
        /// Command 13 of the key frames.
        0x0D_05 => KeySetPosition(KeySetPosition),
        /// Command 14 of the key frames.
        0x0E_05 => KeySetVelocity(KeySetVelocity),
        /// Command 15 of the key frames.
        0x0F_05 => KeySetUpdateRate(KeySetUpdateRate),
        /// Command 16 of the key frames.
        0x10_05 => KeyEnd(KeyEnd),
        /// Command 17 of the key frames.
        0x11_05 => KeySetVideoTime(KeySetVideoTime),
        /// Command 20 of the key frames.
        0x14_05 => KeyStart(KeyStart),
        /// Command 21 of the key frames.
        0x15_05 => KeyPause(KeyPause),
        /// Command 22 of the key frames.
        0x16_05 => KeyStop(KeyStop),
        /// Command 23 of the key frames.
        0x17_05 => KeyTakeUpBacklash(KeyTakeUpBacklash),
        /// Query 99 of the key frames.
        0x63_05 => KeyPrint(KeyPrint),
        /// Query 100 of the key frames.
        0x64_05 => KeyCount(KeyCount),
        /// Query 101 of the key frames.
        0x65_05 => KeyUpdateRate(KeyUpdateRate),
        /// Query 102 of the key frames.
        0x66_05 => KeyPositionAt(KeyPositionAt),
        /// Query 103 of the key frames.
        0x67_05 => KeyVelocityAt(KeyVelocityAt),
        /// Query 104 of the key frames.
        0x68_05 => KeyAccelerationAt(KeyAccelerationAt),
        /// Query 105 of the key frames.
        0x69_05 => KeyVelocityIsValid(KeyVelocityIsValid),
        /// Query 106 of the key frames.
        0x6A_05 => KeyAccelerationIsValid(KeyAccelerationIsValid),
        /// Query 107 of the key frames.
        0x6B_05 => KeyVideoTime(KeyVideoTime),
        /// Query 120 of the key frames.
        0x78_05 => KeyRunState(KeyRunStateQuery),
        /// Query 121 of the key frames.
        0x79_05 => KeyRunTime(KeyRunTime),
        /// Query 122 of the key frames.
        0x7A_05 => KeyMaxTime(KeyMaxTime),
        /// Query 123 of the key frames.
        0x7B_05 => KeyPercentDone(KeyPercentDone),
        /// Query 130 of the key frames.
        0x82_05 => KeyTimeOf(KeyTimeOf),
        /// Query 131 of the key frames.
        0x83_05 => KeyPositionOf(KeyPositionOf),
        /// Query 132 of the key frames.
        0x84_05 => KeyVelocityOf(KeyVelocityOf),

        /// Broadcast 5.
        0x1_05_00..=0x1_05_FF => BroadcastGraffikUsb(BroadcastGraffikUsb),
        /// Broadcast 6.
        0x1_06_00..=0x1_06_FF => BroadcastGraffikBluetooth(BroadcastGraffikBluetooth),
        /// Broadcast 7.
        0x1_07_00..=0x1_07_FF => BroadcastKeyStart(BroadcastKeyStart),
        /// Broadcast 8.
        0x1_08_00..=0x1_08_FF => BroadcastKeyStop(BroadcastKeyStop),
        /// Broadcast 9.
        0x1_09_00..=0x1_09_FF => BroadcastKeyPause(BroadcastKeyPause),
        /// Broadcast 10.
        0x1_0A_00..=0x1_0A_FF => BroadcastGetAddress(BroadcastGetAddress),
    }
}

commands! { HostMessage }
