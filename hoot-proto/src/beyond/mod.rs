//! Commands of later firmware, which the published sheet does not have. Feature `beyond`.
//!
//! These commands have a table of their own, because the firmware of the sheet has none of them, no vectors of them
//! were recorded, and only public sources describe them. [`crate::HostMessage`] decodes them as `Other`. The
//! [`HostMessage`] of this module gives them types. Each message tells its answer. Read the answer with
//! [`Reply::value`](crate::message::Reply::value), by the type in front of it.
//!
//! Some more commands are known only by their numbers, and stay `Other`: 30 to 33, 131 to 133, 252 and 253 of the
//! controller, 32, 40 to 42 and 120 to 124 of a motor, 113 of the camera. Source: hoot, section 7.
//!
//! The [conduct](HostMessage::conduct) of these commands is the safe reading: every command that might move a motor
//! counts as a motion that must not be repeated.
//!
//! ```
//! use hoot_proto::beyond::{HostMessage, MotorSendTo};
//! use hoot_proto::message::{Motor, Steps};
//! use hoot_proto::{Address, Frame};
//!
//! let message = HostMessage::from(MotorSendTo { motor: Motor::Two, position: Steps(-2) });
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

use motion_core::wire::Messages;
use motion_core::{messages, side};

use crate::frame::{Address, Hoot, RequestEnvelope, Selector};
use crate::lint::Context;

messages! {
    /// Message of the master to later firmware, which [`crate::HostMessage`] does not have. The numbers have the same
    /// meaning.
    pub enum HostMessage<'a> from host {
        /// Command 25 of the controller.
        [0, 25, 0] => SendAllToStart(SendAllToStart) [moves once],
        /// Command 26 of the controller.
        [0, 26, 0] => SetStartHere(SetStartHere) [sets once],
        /// Command 27 of the controller.
        [0, 27, 0] => SetStopHere(SetStopHere) [sets once],
        /// Command 28 of the controller.
        [0, 28, 0] => SetFrameRate(SetFrameRate) [sets once],
        /// Command 29 of the controller.
        [0, 29, 0] => SwapStartAndStop(SwapStartAndStop) [moves once],
        /// Command 50 of the controller.
        [0, 50, 0] => SetGraffikMode(SetGraffikMode) [sets once],
        /// Command 51 of the controller.
        [0, 51, 0] => SetAppMode(SetAppMode) [sets once],
        /// Query 122 of the controller.
        [0, 122, 0] => ManualMove(ManualMove) [asks],
        /// Query 123 of the controller.
        [0, 123, 0] => PercentDone(PercentDone) [asks],
        /// Query 124 of the controller.
        [0, 124, 0] => MotorsAttached(MotorsAttached) [asks],
        /// Query 125 of the controller.
        [0, 125, 0] => TotalTime(TotalTime) [asks],
        /// Query 126 of the controller.
        [0, 126, 0] => IsComplete(IsComplete) [asks],
        /// Query 127 of the controller.
        [0, 127, 0] => FrameRateQuery(FrameRateQuery) [asks],
        /// Query 128 of the controller.
        [0, 128, 0] => AnyRunning(AnyRunning) [asks],
        /// Query 129 of the controller.
        [0, 129, 0] => IsValid(IsValid) [asks],
        /// Query 130 of the controller.
        [0, 130, 0] => MotorsAsleep(MotorsAsleep) [asks],
        /// Query 134 of the controller.
        [0, 134, 0] => ControllerCount(ControllerCount) [asks],
        /// Query 140 of the controller.
        [0, 140, 0] => Status(StatusQuery) [asks],
        /// Query 150 of the controller.
        [0, 150, 0] => GraffikMode(GraffikMode) [asks],
        /// Query 200 of the controller.
        [0, 200, 0] => FreeMemory(FreeMemory) [asks],
        /// Command 254 of the controller.
        [0, 254, 0] => SetDebugOutput(SetDebugOutput) [sets once],
        /// Command 255 of the controller.
        [0, 255, 0] => TestYourself(TestYourself) [moves once],

        /// Command 25 of a motor.
        [0, 25, 1..=3] => MotorSetLeadOut(MotorSetLeadOut) [sets once],
        /// Command 28 of a motor.
        [0, 28, 1..=3] => MotorFindMicrostep(MotorFindMicrostep) [sets once],
        /// Command 29 of a motor.
        [0, 29, 1..=3] => MotorSetStartHere(MotorSetStartHere) [sets once],
        /// Command 30 of a motor.
        [0, 30, 1..=3] => MotorSetStopHere(MotorSetStopHere) [sets once],
        /// Command 31 of a motor.
        [0, 31, 1..=3] => MotorSendTo(MotorSendTo) [moves once],
        /// Gives the present position another number: command 32 of a motor.
        [0, 32, 1..=3] => MotorSetPosition(MotorSetPosition) [sets once],
        /// Command 33 of a motor.
        [0, 33, 1..=3] => MotorSetEnd(MotorSetEnd) [sets once],
        /// Command 50 of a motor.
        [0, 50, 1..=3] => MotorSetStopMotion(MotorSetStopMotion) [sets once],
        /// Command 51 of a motor.
        [0, 51, 1..=3] => MotorStepForward(MotorStepForward) [moves once],
        /// Command 52 of a motor.
        [0, 52, 1..=3] => MotorStepBack(MotorStepBack) [moves once],
        /// Query 118 of a motor.
        [0, 118, 1..=3] => MotorIsValid(MotorIsValid) [asks],
        /// Query 119 of a motor.
        [0, 119, 1..=3] => MotorLeadOut(MotorLeadOut) [asks],

        /// Command 11 of the camera.
        [0, 11, 4] => CameraSetTestMode(CameraSetTestMode) [sets once],
        /// Command 12 of the camera.
        [0, 12, 4] => CameraSetKeepAlive(CameraSetKeepAlive) [sets once],
        /// Command 13 of the camera.
        [0, 13, 4] => CameraSetIntervalometer(CameraSetIntervalometer) [sets once],
        /// Query 109 of the camera.
        [0, 109, 4] => CameraShots(CameraShots) [asks],
        /// Query 110 of the camera.
        [0, 110, 4] => CameraTestMode(CameraTestMode) [asks],
        /// Query 111 of the camera.
        [0, 111, 4] => CameraKeepAlive(CameraKeepAlive) [asks],
        /// Query 112 of the camera.
        [0, 112, 4] => CameraIntervalometer(CameraIntervalometer) [asks],

        /// Command 10 of the key frames.
        [0, 10, 5] => KeySetAxis(KeySetAxis) [sets once, in sequence],
        /// Command 11 of the key frames.
        [0, 11, 5] => KeySetCount(KeySetCount) [sets once, in sequence],
        /// Command 12 of the key frames.
        [0, 12, 5] => KeySetTime(KeySetTime) [sets once, in sequence],
        /// Command 13 of the key frames.
        [0, 13, 5] => KeySetPosition(KeySetPosition) [sets once, in sequence],
        /// Command 14 of the key frames.
        [0, 14, 5] => KeySetVelocity(KeySetVelocity) [sets once, in sequence],
        /// Command 15 of the key frames.
        [0, 15, 5] => KeySetUpdateRate(KeySetUpdateRate) [sets once],
        /// Command 16 of the key frames.
        [0, 16, 5] => KeyEnd(KeyEnd) [sets once, in sequence],
        /// Command 17 of the key frames.
        [0, 17, 5] => KeySetVideoTime(KeySetVideoTime) [sets once],
        /// Command 20 of the key frames.
        [0, 20, 5] => KeyStart(KeyStart) [moves once],
        /// Command 21 of the key frames.
        [0, 21, 5] => KeyPause(KeyPause) [stops],
        /// Command 22 of the key frames.
        [0, 22, 5] => KeyStop(KeyStop) [stops],
        /// Command 23 of the key frames.
        [0, 23, 5] => KeyTakeUpBacklash(KeyTakeUpBacklash) [moves once],
        /// Query 99 of the key frames.
        [0, 99, 5] => KeyPrint(KeyPrint) [asks],
        /// Query 100 of the key frames.
        [0, 100, 5] => KeyCount(KeyCount) [asks],
        /// Query 101 of the key frames.
        [0, 101, 5] => KeyUpdateRate(KeyUpdateRate) [asks],
        /// Query 102 of the key frames.
        [0, 102, 5] => KeyPositionAt(KeyPositionAt) [asks],
        /// Query 103 of the key frames.
        [0, 103, 5] => KeyVelocityAt(KeyVelocityAt) [asks],
        /// Query 104 of the key frames.
        [0, 104, 5] => KeyAccelerationAt(KeyAccelerationAt) [asks],
        /// Query 105 of the key frames.
        [0, 105, 5] => KeyVelocityIsValid(KeyVelocityIsValid) [asks],
        /// Query 106 of the key frames.
        [0, 106, 5] => KeyAccelerationIsValid(KeyAccelerationIsValid) [asks],
        /// Query 107 of the key frames.
        [0, 107, 5] => KeyVideoTime(KeyVideoTime) [asks],
        /// Query 120 of the key frames.
        [0, 120, 5] => KeyRunState(KeyRunStateQuery) [asks],
        /// Query 121 of the key frames.
        [0, 121, 5] => KeyRunTime(KeyRunTime) [asks],
        /// Query 122 of the key frames.
        [0, 122, 5] => KeyMaxTime(KeyMaxTime) [asks],
        /// Query 123 of the key frames.
        [0, 123, 5] => KeyPercentDone(KeyPercentDone) [asks],
        /// Query 130 of the key frames.
        [0, 130, 5] => KeyTimeOf(KeyTimeOf) [asks],
        /// Query 131 of the key frames.
        [0, 131, 5] => KeyPositionOf(KeyPositionOf) [asks],
        /// Query 132 of the key frames.
        [0, 132, 5] => KeyVelocityOf(KeyVelocityOf) [asks],

        /// Broadcast 5.
        [1, 5, 0..=255] => BroadcastGraffikUsb(BroadcastGraffikUsb) [moves once],
        /// Broadcast 6.
        [1, 6, 0..=255] => BroadcastGraffikBluetooth(BroadcastGraffikBluetooth) [sets once],
        /// Broadcast 7.
        [1, 7, 0..=255] => BroadcastKeyStart(BroadcastKeyStart) [moves once],
        /// Broadcast 8.
        [1, 8, 0..=255] => BroadcastKeyStop(BroadcastKeyStop) [stops],
        /// Broadcast 9.
        [1, 9, 0..=255] => BroadcastKeyPause(BroadcastKeyPause) [stops],
        /// Broadcast 10.
        [1, 10, 0..=255] => BroadcastGetAddress(BroadcastGetAddress) [asks],
    }
}

side! {
    /// Side of a master with later firmware, where a type parameter selects the messages.
    pub enum Host in BE: HostMessage(to: Address) by RequestEnvelope, or other, over Hoot, lint Context;
}

impl HostMessage<'_> {
    /// Selector of the command: its table, its number and the part of the node that it is for.
    #[must_use]
    #[inline]
    pub fn selector(&self) -> Selector {
        Selector::from_number(self.number())
    }
}
