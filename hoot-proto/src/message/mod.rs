//! The messages, a file a chapter of the specification.
//!
//! [`HostMessage`] is what the master sends: commands and queries. [`DeviceMessage`] is what a node sends, which is
//! always a [`Reply`]. Nothing in a reply says what it answers; the [`Query`](crate::Query) that was asked does.

mod bounded;
mod broadcast;
mod camera;
mod core_protocol;
mod main;
mod motor;
mod name;
mod reply;
pub(crate) mod sub;
mod units;
mod value;

pub use broadcast::{BroadcastAssignAddress, BroadcastPause, BroadcastStart, BroadcastStop};
pub use camera::{
    CameraEnable, CameraExpose, CameraExposing, CameraExposureDelay, CameraExposureTime, CameraFocusTime,
    CameraFocusWithShutter, CameraInterval, CameraMaxShots, CameraMirrorUp, CameraSetEnable, CameraSetExposureDelay,
    CameraSetExposureTime, CameraSetFocusTime, CameraSetFocusWithShutter, CameraSetInterval, CameraSetMaxShots,
    CameraSetMirrorUp,
};
pub use core_protocol::{CoreAssignAddress, CoreDeviceId, CoreDeviceVersion, CoreProtocolVersion, Noop};
pub use main::{
    AltModes, Current, Exposing, FirmwareVersion, InputEdge, JoystickMode, LimitSwitches, MaxStepRate, NameQuery,
    OutAfterDelay, OutAfterTime, OutBeforeDelay, OutBeforeTime, OutLevel, Pause, PingPong, PowerCycled,
    ProgramModeQuery, ReturnHome, RunStatus, RunTime, SetAddress, SetAltModes, SetCommonLine, SetInputEdge,
    SetJoystickMode, SetManualMove, SetMaxRunTime, SetMaxStepRate, SetOutAfterDelay, SetOutAfterTime,
    SetOutBeforeDelay, SetOutBeforeTime, SetOutLevel, SetPingPong, SetProgramMode, SetStartDelay, SetTimingMaster,
    Start, StartDelayQuery, Stop, TimingMaster, ToggleDebugLed, Voltage,
};
pub use motion_core::wire::Other;
pub use motor::{
    Motor, MotorBacklash, MotorContinuousAcceleration, MotorContinuousSpeed, MotorDirection, MotorEasing, MotorEnable,
    MotorEndLimit, MotorLeadIn, MotorMaxProgramSpeed, MotorMaxStepSpeed, MotorMicrostep, MotorMove, MotorPosition,
    MotorProgramAcceleration, MotorProgramDeceleration, MotorProgramStart, MotorProgramStop, MotorResetLimits,
    MotorRun, MotorRunning, MotorSendHome, MotorSendToEnd, MotorSendToStart, MotorSendToStop, MotorSetBacklash,
    MotorSetContinuousAcceleration, MotorSetContinuousSpeed, MotorSetDirection, MotorSetEasing, MotorSetEnable,
    MotorSetEndHere, MotorSetHomeHere, MotorSetLeadIn, MotorSetLeadInLong, MotorSetMaxStepSpeed, MotorSetMicrostep,
    MotorSetProgramAcceleration, MotorSetProgramDeceleration, MotorSetProgramStart, MotorSetProgramStop, MotorSetSleep,
    MotorSetTravel, MotorStepBack, MotorStepForward, MotorStop, MotorTravel,
};
pub use name::{Name, SetName};
pub use reply::{Reply, ResponseCode};
pub use sub::AnySubAddress;
pub use units::{
    Acceleration, AltMode, Amperes, Backlash, CommonLine, CoreVersion, Direction, Easing, Edge, EdgeFound, Level,
    MAX_ARRIVING, Microstep, Milliseconds, ProgramMode, RunState, ShortMilliseconds, ShortShots, ShortSpan, Shots,
    Span, Speed, StartDelay, StepCount, StepRate, Steps, StepsPerSecond, StepsPerSecondSquared, Version, Volts,
};
pub use value::{RingTip, SpeedOrSleep, Text, Value, ValueType};

use motion_core::messages;
use motion_core::wire::{EncodeError, Messages};

use crate::frame::{self, Frame};

messages! {
    /// What the master sends.
    ///
    /// The numbers of this table are those of [`Selector::number`](crate::Selector::number): in front 1 for a broadcast and 2 for the core
    /// protocol, then the command, then the sub-address. A command has exactly the data that the table says; with data of
    /// another length it is `Other`, because the firmware takes that as well: it reads missing bytes as zero and leaves
    /// out surplus ones. What later firmware added stands apart, in [`beyond`](crate::beyond).
    pub enum HostMessage<'a> {
        /// Nothing: command 0 of any part, which no node answers.
        0x00_00..=0x00_FF => Noop(Noop),

        /// Start or resume the planned move: command 2 of the controller.
        0x02_00 => Start(Start),
        /// Pause the planned move: command 3 of the controller.
        0x03_00 => Pause(Pause),
        /// Stop everything: command 4 of the controller.
        0x04_00 => Stop(Stop),
        /// Switch the lamp for debugging: command 5 of the controller.
        0x05_00 => ToggleDebugLed(ToggleDebugLed),
        /// Give the time to other nodes: command 6 of the controller.
        0x06_00 => SetTimingMaster(SetTimingMaster),
        /// Give the node a name: command 7 of the controller.
        0x07_00 => SetName(SetName),
        /// Take another address: command 8 of the controller.
        0x08_00 => SetAddress(SetAddress),
        /// Step in common with other nodes: command 9 of the controller.
        0x09_00 => SetCommonLine(SetCommonLine),
        /// Send all motors home: command 10 of the controller.
        0x0A_00 => ReturnHome(ReturnHome),
        /// Set the greatest step rate: command 11 of the controller.
        0x0B_00 => SetMaxStepRate(SetMaxStepRate),
        /// Set which edge of the auxiliary input counts: command 12 of the controller.
        0x0C_00 => SetInputEdge(SetInputEdge),
        /// Set what the auxiliary contacts are for: command 13 of the controller.
        0x0D_00 => SetAltModes(SetAltModes),
        /// Set the dead-man of manual moves: command 14 of the controller.
        0x0E_00 => SetManualMove(SetManualMove),
        /// Set the delay of the auxiliary output before a picture: command 15 of the controller.
        0x0F_00 => SetOutBeforeDelay(SetOutBeforeDelay),
        /// Set the delay of the auxiliary output after a picture: command 16 of the controller.
        0x10_00 => SetOutAfterDelay(SetOutAfterDelay),
        /// Set the time of the auxiliary output before a picture: command 17 of the controller.
        0x11_00 => SetOutBeforeTime(SetOutBeforeTime),
        /// Set the time of the auxiliary output after a picture: command 18 of the controller.
        0x12_00 => SetOutAfterTime(SetOutAfterTime),
        /// Set the level of the auxiliary output: command 19 of the controller.
        0x13_00 => SetOutLevel(SetOutLevel),
        /// Set after how long the planned move is stopped: command 20 of the controller.
        0x14_00 => SetMaxRunTime(SetMaxRunTime),
        /// Set how long the planned move waits: command 21 of the controller.
        0x15_00 => SetStartDelay(SetStartDelay),
        /// Set what kind of program the planned move is: command 22 of the controller.
        0x16_00 => SetProgramMode(SetProgramMode),
        /// Set joystick mode: command 23 of the controller.
        0x17_00 => SetJoystickMode(SetJoystickMode),
        /// Set whether the planned move goes to and fro: command 24 of the controller.
        0x18_00 => SetPingPong(SetPingPong),
        /// Which firmware do you have? Query 100 of the controller.
        0x64_00 => FirmwareVersion(FirmwareVersion),
        /// Does the planned move run? Query 101 of the controller.
        0x65_00 => RunStatus(RunStatus),
        /// How long has the planned move run? Query 102 of the controller.
        0x66_00 => RunTime(RunTime),
        /// Is a picture being taken? Query 103 of the controller.
        0x67_00 => Exposing(Exposing),
        /// Are you the timing master? Query 104 of the controller.
        0x68_00 => TimingMaster(TimingMaster),
        /// What is the node called? Query 105 of the controller.
        0x69_00 => Name(NameQuery),
        /// What is the greatest step rate? Query 106 of the controller.
        0x6A_00 => MaxStepRate(MaxStepRate),
        /// What is the supply voltage? Query 107 of the controller.
        0x6B_00 => Voltage(Voltage),
        /// What is the supply current? Query 108 of the controller.
        0x6C_00 => Current(Current),
        /// Which edge of the auxiliary input counts? Query 109 of the controller.
        0x6D_00 => InputEdge(InputEdge),
        /// What are the auxiliary contacts for? Query 110 of the controller.
        0x6E_00 => AltModes(AltModes),
        /// Which levels have the limit switches? Query 111 of the controller.
        0x6F_00 => LimitSwitches(LimitSwitches),
        /// What is the delay of the auxiliary output before a picture? Query 112 of the controller.
        0x70_00 => OutBeforeDelay(OutBeforeDelay),
        /// What is the delay of the auxiliary output after a picture? Query 113 of the controller.
        0x71_00 => OutAfterDelay(OutAfterDelay),
        /// What is the time of the auxiliary output before a picture? Query 114 of the controller.
        0x72_00 => OutBeforeTime(OutBeforeTime),
        /// What is the time of the auxiliary output after a picture? Query 115 of the controller.
        0x73_00 => OutAfterTime(OutAfterTime),
        /// What is the level of the auxiliary output? Query 116 of the controller.
        0x74_00 => OutLevel(OutLevel),
        /// How long does the planned move wait? Query 117 of the controller.
        0x75_00 => StartDelay(StartDelayQuery),
        /// What kind of program is the planned move? Query 118 of the controller.
        0x76_00 => ProgramMode(ProgramModeQuery),
        /// Has the power been off? Query 119 of the controller.
        0x77_00 => PowerCycled(PowerCycled),
        /// Is joystick mode on? Query 120 of the controller.
        0x78_00 => JoystickMode(JoystickMode),
        /// Does the planned move go to and fro? Query 121 of the controller.
        0x79_00 => PingPong(PingPong),

        // Written out, three numbers become a jump; a range would be compared, one after another.
        /// Set whether a resting motor has no current: command 2 of a motor.
        0x02_01 | 0x02_02 | 0x02_03 => MotorSetSleep(MotorSetSleep),
        /// Set whether the motor moves at all: command 3 of a motor.
        0x03_01 | 0x03_02 | 0x03_03 => MotorSetEnable(MotorSetEnable),
        /// Stop one motor: command 4 of a motor.
        0x04_01 | 0x04_02 | 0x04_03 => MotorStop(MotorStop),
        /// Set the steps that are added when the motor turns the other way: command 5 of a motor.
        0x05_01 | 0x05_02 | 0x05_03 => MotorSetBacklash(MotorSetBacklash),
        /// Set into how many microsteps a step is divided: command 6 of a motor.
        0x06_01 | 0x06_02 | 0x06_03 => MotorSetMicrostep(MotorSetMicrostep),
        /// Set the greatest speed of the motor: command 7 of a motor.
        0x07_01 | 0x07_02 | 0x07_03 => MotorSetMaxStepSpeed(MotorSetMaxStepSpeed),
        /// Set which way is forward: command 8 of a motor.
        0x08_01 | 0x08_02 | 0x08_03 => MotorSetDirection(MotorSetDirection),
        /// Here is home: command 9 of a motor.
        0x09_01 | 0x09_02 | 0x09_03 => MotorSetHomeHere(MotorSetHomeHere),
        /// Here is the end limit: command 10 of a motor.
        0x0A_01 | 0x0A_02 | 0x0A_03 => MotorSetEndHere(MotorSetEndHere),
        /// Go home: command 11 of a motor.
        0x0B_01 | 0x0B_02 | 0x0B_03 => MotorSendHome(MotorSendHome),
        /// Go to the end limit: command 12 of a motor.
        0x0C_01 | 0x0C_02 | 0x0C_03 => MotorSendToEnd(MotorSendToEnd),
        /// Set the speed of continuous runs: command 13 of a motor.
        0x0D_01 | 0x0D_02 | 0x0D_03 => MotorSetContinuousSpeed(MotorSetContinuousSpeed),
        /// Set how quickly continuous runs gain speed: command 14 of a motor.
        0x0E_01 | 0x0E_02 | 0x0E_03 => MotorSetContinuousAcceleration(MotorSetContinuousAcceleration),
        /// Move by a number of steps: command 15 of a motor.
        0x0F_01 | 0x0F_02 | 0x0F_03 => MotorMove(MotorMove)
            or
            /// Run until told otherwise: command 15 of a motor, with no steps.
            MotorRun(MotorRun),
        /// Set where the planned move begins: command 16 of a motor.
        0x10_01 | 0x10_02 | 0x10_03 => MotorSetProgramStart(MotorSetProgramStart),
        /// Set where the planned move ends: command 17 of a motor.
        0x11_01 | 0x11_02 | 0x11_03 => MotorSetProgramStop(MotorSetProgramStop),
        /// Set how the planned move gains and loses speed: command 18 of a motor.
        0x12_01 | 0x12_02 | 0x12_03 => MotorSetEasing(MotorSetEasing),
        /// Set how long the motor waits before its planned move: command 19 of a motor.
        0x13_01 | 0x13_02 | 0x13_03 => MotorSetLeadIn(MotorSetLeadIn)
            or
            /// The same in 32 bits, for v0.35 and later: command 19 of a motor.
            MotorSetLeadInLong(MotorSetLeadInLong),
        /// Set how long the planned move takes: command 20 of a motor.
        0x14_01 | 0x14_02 | 0x14_03 => MotorSetTravel(MotorSetTravel),
        /// Set how long the planned move gains speed: command 21 of a motor.
        0x15_01 | 0x15_02 | 0x15_03 => MotorSetProgramAcceleration(MotorSetProgramAcceleration),
        /// Set how long the planned move loses speed: command 22 of a motor.
        0x16_01 | 0x16_02 | 0x16_03 => MotorSetProgramDeceleration(MotorSetProgramDeceleration),
        /// Go to where the planned move begins: command 23 of a motor.
        0x17_01 | 0x17_02 | 0x17_03 => MotorSendToStart(MotorSendToStart),
        /// Go to where the planned move ends: command 24 of a motor.
        0x18_01 | 0x18_02 | 0x18_03 => MotorSendToStop(MotorSendToStop),
        /// Go on by one step of the planned move: command 25 of a motor.
        0x19_01 | 0x19_02 | 0x19_03 => MotorStepForward(MotorStepForward),
        /// Go back by one step of the planned move: command 26 of a motor.
        0x1A_01 | 0x1A_02 | 0x1A_03 => MotorStepBack(MotorStepBack),
        /// Forget the limits: command 27 of a motor.
        0x1B_01 | 0x1B_02 | 0x1B_03 => MotorResetLimits(MotorResetLimits),
        /// Does the motor move at all? Query 100 of a motor.
        0x64_01 | 0x64_02 | 0x64_03 => MotorEnable(MotorEnable),
        /// How many steps are added when the motor turns the other way? Query 101 of a motor.
        0x65_01 | 0x65_02 | 0x65_03 => MotorBacklash(MotorBacklash),
        /// Into how many microsteps is a step divided? Query 102 of a motor.
        0x66_01 | 0x66_02 | 0x66_03 => MotorMicrostep(MotorMicrostep),
        /// Which way is forward? Query 103 of a motor.
        0x67_01 | 0x67_02 | 0x67_03 => MotorDirection(MotorDirection),
        /// What is the greatest speed of the motor? Query 104 of a motor.
        0x68_01 | 0x68_02 | 0x68_03 => MotorMaxStepSpeed(MotorMaxStepSpeed),
        /// Where is the end limit? Query 105 of a motor.
        0x69_01 | 0x69_02 | 0x69_03 => MotorEndLimit(MotorEndLimit),
        /// Where is the motor? Query 106 of a motor.
        0x6A_01 | 0x6A_02 | 0x6A_03 => MotorPosition(MotorPosition),
        /// Does the motor move? Query 107 of a motor.
        0x6B_01 | 0x6B_02 | 0x6B_03 => MotorRunning(MotorRunning),
        /// What is the speed of continuous runs? Query 108 of a motor.
        0x6C_01 | 0x6C_02 | 0x6C_03 => MotorContinuousSpeed(MotorContinuousSpeed),
        /// How quickly do continuous runs gain speed? Query 109 of a motor.
        0x6D_01 | 0x6D_02 | 0x6D_03 => MotorContinuousAcceleration(MotorContinuousAcceleration),
        /// How does the planned move gain and lose speed? Query 110 of a motor.
        0x6E_01 | 0x6E_02 | 0x6E_03 => MotorEasing(MotorEasing),
        /// Where does the planned move begin? Query 111 of a motor.
        0x6F_01 | 0x6F_02 | 0x6F_03 => MotorProgramStart(MotorProgramStart),
        /// Where does the planned move end? Query 112 of a motor.
        0x70_01 | 0x70_02 | 0x70_03 => MotorProgramStop(MotorProgramStop),
        /// How long does the planned move take? Query 113 of a motor.
        0x71_01 | 0x71_02 | 0x71_03 => MotorTravel(MotorTravel),
        /// How long does the motor wait before its planned move? Query 114 of a motor.
        0x72_01 | 0x72_02 | 0x72_03 => MotorLeadIn(MotorLeadIn),
        /// How long does the planned move gain speed? Query 115 of a motor.
        0x73_01 | 0x73_02 | 0x73_03 => MotorProgramAcceleration(MotorProgramAcceleration),
        /// How long does the planned move lose speed? Query 116 of a motor.
        0x74_01 | 0x74_02 | 0x74_03 => MotorProgramDeceleration(MotorProgramDeceleration),
        /// What is the greatest speed of the planned move? Query 117 of a motor.
        0x75_01 | 0x75_02 | 0x75_03 => MotorMaxProgramSpeed(MotorMaxProgramSpeed),

        /// Set whether there is a camera: command 2 of the camera.
        0x02_04 => CameraSetEnable(CameraSetEnable),
        /// Take a picture: command 3 of the camera.
        0x03_04 => CameraExpose(CameraExpose),
        /// Set how long the shutter is held: command 4 of the camera.
        0x04_04 => CameraSetExposureTime(CameraSetExposureTime),
        /// Set how long the focus is held: command 5 of the camera.
        0x05_04 => CameraSetFocusTime(CameraSetFocusTime),
        /// Set after how many pictures the program ends: command 6 of the camera.
        0x06_04 => CameraSetMaxShots(CameraSetMaxShots),
        /// Set how long to wait after a picture: command 7 of the camera.
        0x07_04 => CameraSetExposureDelay(CameraSetExposureDelay),
        /// Set whether the focus is held together with the shutter: command 8 of the camera.
        0x08_04 => CameraSetFocusWithShutter(CameraSetFocusWithShutter),
        /// Set whether the mirror goes up first: command 9 of the camera.
        0x09_04 => CameraSetMirrorUp(CameraSetMirrorUp),
        /// Set the time from one picture to the next: command 10 of the camera.
        0x0A_04 => CameraSetInterval(CameraSetInterval),
        /// Is there a camera? Query 100 of the camera.
        0x64_04 => CameraEnable(CameraEnable),
        /// Is the camera busy? Query 101 of the camera.
        0x65_04 => CameraExposing(CameraExposing),
        /// How long is the shutter held? Query 102 of the camera.
        0x66_04 => CameraExposureTime(CameraExposureTime),
        /// How long is the focus held? Query 103 of the camera.
        0x67_04 => CameraFocusTime(CameraFocusTime),
        /// After how many pictures does the program end? Query 104 of the camera.
        0x68_04 => CameraMaxShots(CameraMaxShots),
        /// How long is the wait after a picture? Query 105 of the camera.
        0x69_04 => CameraExposureDelay(CameraExposureDelay),
        /// Is the focus held together with the shutter? Query 106 of the camera.
        0x6A_04 => CameraFocusWithShutter(CameraFocusWithShutter),
        /// Does the mirror go up first? Query 107 of the camera.
        0x6B_04 => CameraMirrorUp(CameraMirrorUp),
        /// What is the time from one picture to the next? Query 108 of the camera.
        0x6C_04 => CameraInterval(CameraInterval),

        /// All nodes: start or resume the planned moves. Broadcast 1.
        0x1_01_00..=0x1_01_FF => BroadcastStart(BroadcastStart),
        /// All nodes: stop everything. Broadcast 2.
        0x1_02_00..=0x1_02_FF => BroadcastStop(BroadcastStop),
        /// All nodes: pause the planned moves. Broadcast 3.
        0x1_03_00..=0x1_03_FF => BroadcastPause(BroadcastPause),
        /// All nodes: take this address. Broadcast 4.
        0x1_04_00..=0x1_04_FF => BroadcastAssignAddress(BroadcastAssignAddress),

        /// Which version of the core protocol do you speak? Core query 1.
        0x2_01_00..=0x2_01_FF => CoreProtocolVersion(CoreProtocolVersion),
        /// What are you? Core query 2.
        0x2_02_00..=0x2_02_FF => CoreDeviceId(CoreDeviceId),
        /// Which version are you of? Core query 3.
        0x2_03_00..=0x2_03_FF => CoreDeviceVersion(CoreDeviceVersion),
        /// Take this address: core command 4.
        0x2_04_00..=0x2_04_FF => CoreAssignAddress(CoreAssignAddress),
    }
}

messages! {
    /// What a node sends.
    ///
    /// The numbers of this table are `address << 16 | sub_address << 8 | response code`. A packet that is not addressed
    /// to the master is `Other`: an echo, or traffic between others.
    pub enum DeviceMessage<'a> {
        /// The answer to a request.
        0x00..=0xFF => Reply(Reply<'a>),
    }
}

/// Gives a table of commands what every side that sends them has: how they go into packets, and come out of them.
macro_rules! commands {
    ($name:ident) => {
        impl<'a> $name<'a> {
            /// Reads the command in a packet from the master.
            ///
            /// It cannot fail: an unknown command, and a known one with data of another length, is `Other`.
            #[must_use]
            #[inline]
            pub fn decode(frame: &$crate::Frame<'a>) -> Self {
                let (selector, parameters) = frame.request();
                let number = selector.number();
                Self::decode_body(number, parameters).unwrap_or_else(|_| Self::other(number, parameters))
            }

            /// What selects the command.
            #[must_use]
            #[inline]
            pub fn selector(&self) -> $crate::Selector {
                $crate::Selector::from_number(self.number())
            }

            /// Bytes of its whole packet.
            #[must_use]
            #[inline]
            pub fn encoded_len(&self) -> usize {
                $crate::frame::request_len(self.selector().table, self.body_len())
            }

            /// Writes its whole packet to the front of `out`, and says how many bytes it took.
            ///
            /// Broadcasts go to [`Address::BROADCAST`](crate::Address::BROADCAST), and nothing else does: their numbers mean other commands.
            ///
            /// # Errors
            ///
            /// [`EncodeError`](crate::EncodeError), if the packet does not fit, a reader would take it for another command, or a node has no room
            /// for it. Then nothing is written.
            #[inline]
            pub fn encode_into(&self, to: $crate::Address, out: &mut [u8]) -> Result<usize, $crate::EncodeError> {
                $crate::frame::request(self.selector(), to, self.body_len(), out, |place| self.encode_body(place))
            }
        }
    };
}
pub(crate) use commands;
commands! { HostMessage }

impl<'a> DeviceMessage<'a> {
    /// Reads a packet from a node. It cannot fail: what is not addressed to the master is `Other`.
    #[must_use]
    #[inline]
    pub fn decode(frame: &Frame<'a>) -> Self {
        let number = u32::from_be_bytes([0, frame.address().0, frame.sub_address(), frame.command()]);
        Self::decode_body(number, frame.payload()).unwrap_or_else(|_| Self::other(number, frame.payload()))
    }

    /// Bytes of its whole packet.
    #[must_use]
    #[inline]
    pub fn encoded_len(&self) -> usize {
        frame::frame_len(self.body_len())
    }

    /// Writes its whole packet to the front of `out`, and says how many bytes it took.
    ///
    /// # Errors
    ///
    /// [`EncodeError`], if the packet does not fit, or there is more data than a master has room for.
    #[inline]
    pub fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let [_, to @ ..] = self.number().to_be_bytes();
        frame::envelope(to, self.body_len(), out, |place| self.encode_body(place))
    }
}
