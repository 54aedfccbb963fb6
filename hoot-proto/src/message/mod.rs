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
        [0, 0, 0..=255] => Noop(Noop),

        /// Start or resume the planned move: command 2 of the controller.
        [0, 2, 0] => Start(Start),
        /// Pause the planned move: command 3 of the controller.
        [0, 3, 0] => Pause(Pause),
        /// Stop everything: command 4 of the controller.
        [0, 4, 0] => Stop(Stop),
        /// Switch the lamp for debugging: command 5 of the controller.
        [0, 5, 0] => ToggleDebugLed(ToggleDebugLed),
        /// Give the time to other nodes: command 6 of the controller.
        [0, 6, 0] => SetTimingMaster(SetTimingMaster),
        /// Give the node a name: command 7 of the controller.
        [0, 7, 0] => SetName(SetName),
        /// Take another address: command 8 of the controller.
        [0, 8, 0] => SetAddress(SetAddress),
        /// Step in common with other nodes: command 9 of the controller.
        [0, 9, 0] => SetCommonLine(SetCommonLine),
        /// Send all motors home: command 10 of the controller.
        [0, 10, 0] => ReturnHome(ReturnHome),
        /// Set the greatest step rate: command 11 of the controller.
        [0, 11, 0] => SetMaxStepRate(SetMaxStepRate),
        /// Set which edge of the auxiliary input counts: command 12 of the controller.
        [0, 12, 0] => SetInputEdge(SetInputEdge),
        /// Set what the auxiliary contacts are for: command 13 of the controller.
        [0, 13, 0] => SetAltModes(SetAltModes),
        /// Set the dead-man of manual moves: command 14 of the controller.
        [0, 14, 0] => SetManualMove(SetManualMove),
        /// Set the delay of the auxiliary output before a picture: command 15 of the controller.
        [0, 15, 0] => SetOutBeforeDelay(SetOutBeforeDelay),
        /// Set the delay of the auxiliary output after a picture: command 16 of the controller.
        [0, 16, 0] => SetOutAfterDelay(SetOutAfterDelay),
        /// Set the time of the auxiliary output before a picture: command 17 of the controller.
        [0, 17, 0] => SetOutBeforeTime(SetOutBeforeTime),
        /// Set the time of the auxiliary output after a picture: command 18 of the controller.
        [0, 18, 0] => SetOutAfterTime(SetOutAfterTime),
        /// Set the level of the auxiliary output: command 19 of the controller.
        [0, 19, 0] => SetOutLevel(SetOutLevel),
        /// Set after how long the planned move is stopped: command 20 of the controller.
        [0, 20, 0] => SetMaxRunTime(SetMaxRunTime),
        /// Set how long the planned move waits: command 21 of the controller.
        [0, 21, 0] => SetStartDelay(SetStartDelay),
        /// Set what kind of program the planned move is: command 22 of the controller.
        [0, 22, 0] => SetProgramMode(SetProgramMode),
        /// Set joystick mode: command 23 of the controller.
        [0, 23, 0] => SetJoystickMode(SetJoystickMode),
        /// Set whether the planned move goes to and fro: command 24 of the controller.
        [0, 24, 0] => SetPingPong(SetPingPong),
        /// Which firmware do you have? Query 100 of the controller.
        [0, 100, 0] => FirmwareVersion(FirmwareVersion),
        /// Does the planned move run? Query 101 of the controller.
        [0, 101, 0] => RunStatus(RunStatus),
        /// How long has the planned move run? Query 102 of the controller.
        [0, 102, 0] => RunTime(RunTime),
        /// Is a picture being taken? Query 103 of the controller.
        [0, 103, 0] => Exposing(Exposing),
        /// Are you the timing master? Query 104 of the controller.
        [0, 104, 0] => TimingMaster(TimingMaster),
        /// What is the node called? Query 105 of the controller.
        [0, 105, 0] => Name(NameQuery),
        /// What is the greatest step rate? Query 106 of the controller.
        [0, 106, 0] => MaxStepRate(MaxStepRate),
        /// What is the supply voltage? Query 107 of the controller.
        [0, 107, 0] => Voltage(Voltage),
        /// What is the supply current? Query 108 of the controller.
        [0, 108, 0] => Current(Current),
        /// Which edge of the auxiliary input counts? Query 109 of the controller.
        [0, 109, 0] => InputEdge(InputEdge),
        /// What are the auxiliary contacts for? Query 110 of the controller.
        [0, 110, 0] => AltModes(AltModes),
        /// Which levels have the limit switches? Query 111 of the controller.
        [0, 111, 0] => LimitSwitches(LimitSwitches),
        /// What is the delay of the auxiliary output before a picture? Query 112 of the controller.
        [0, 112, 0] => OutBeforeDelay(OutBeforeDelay),
        /// What is the delay of the auxiliary output after a picture? Query 113 of the controller.
        [0, 113, 0] => OutAfterDelay(OutAfterDelay),
        /// What is the time of the auxiliary output before a picture? Query 114 of the controller.
        [0, 114, 0] => OutBeforeTime(OutBeforeTime),
        /// What is the time of the auxiliary output after a picture? Query 115 of the controller.
        [0, 115, 0] => OutAfterTime(OutAfterTime),
        /// What is the level of the auxiliary output? Query 116 of the controller.
        [0, 116, 0] => OutLevel(OutLevel),
        /// How long does the planned move wait? Query 117 of the controller.
        [0, 117, 0] => StartDelay(StartDelayQuery),
        /// What kind of program is the planned move? Query 118 of the controller.
        [0, 118, 0] => ProgramMode(ProgramModeQuery),
        /// Has the power been off? Query 119 of the controller.
        [0, 119, 0] => PowerCycled(PowerCycled),
        /// Is joystick mode on? Query 120 of the controller.
        [0, 120, 0] => JoystickMode(JoystickMode),
        /// Does the planned move go to and fro? Query 121 of the controller.
        [0, 121, 0] => PingPong(PingPong),

        /// Set whether a resting motor has no current: command 2 of a motor.
        [0, 2, 1..=3] => MotorSetSleep(MotorSetSleep),
        /// Set whether the motor moves at all: command 3 of a motor.
        [0, 3, 1..=3] => MotorSetEnable(MotorSetEnable),
        /// Stop one motor: command 4 of a motor.
        [0, 4, 1..=3] => MotorStop(MotorStop),
        /// Set the steps that are added when the motor turns the other way: command 5 of a motor.
        [0, 5, 1..=3] => MotorSetBacklash(MotorSetBacklash),
        /// Set into how many microsteps a step is divided: command 6 of a motor.
        [0, 6, 1..=3] => MotorSetMicrostep(MotorSetMicrostep),
        /// Set the greatest speed of the motor: command 7 of a motor.
        [0, 7, 1..=3] => MotorSetMaxStepSpeed(MotorSetMaxStepSpeed),
        /// Set which way is forward: command 8 of a motor.
        [0, 8, 1..=3] => MotorSetDirection(MotorSetDirection),
        /// Here is home: command 9 of a motor.
        [0, 9, 1..=3] => MotorSetHomeHere(MotorSetHomeHere),
        /// Here is the end limit: command 10 of a motor.
        [0, 10, 1..=3] => MotorSetEndHere(MotorSetEndHere),
        /// Go home: command 11 of a motor.
        [0, 11, 1..=3] => MotorSendHome(MotorSendHome),
        /// Go to the end limit: command 12 of a motor.
        [0, 12, 1..=3] => MotorSendToEnd(MotorSendToEnd),
        /// Set the speed of continuous runs: command 13 of a motor.
        [0, 13, 1..=3] => MotorSetContinuousSpeed(MotorSetContinuousSpeed),
        /// Set how quickly continuous runs gain speed: command 14 of a motor.
        [0, 14, 1..=3] => MotorSetContinuousAcceleration(MotorSetContinuousAcceleration),
        /// Move by a number of steps: command 15 of a motor.
        [0, 15, 1..=3] => MotorMove(MotorMove)
            or
            /// Run until told otherwise: command 15 of a motor, with no steps.
            MotorRun(MotorRun),
        /// Set where the planned move begins: command 16 of a motor.
        [0, 16, 1..=3] => MotorSetProgramStart(MotorSetProgramStart),
        /// Set where the planned move ends: command 17 of a motor.
        [0, 17, 1..=3] => MotorSetProgramStop(MotorSetProgramStop),
        /// Set how the planned move gains and loses speed: command 18 of a motor.
        [0, 18, 1..=3] => MotorSetEasing(MotorSetEasing),
        /// Set how long the motor waits before its planned move: command 19 of a motor.
        [0, 19, 1..=3] => MotorSetLeadIn(MotorSetLeadIn)
            or
            /// The same in 32 bits, for v0.35 and later: command 19 of a motor.
            MotorSetLeadInLong(MotorSetLeadInLong),
        /// Set how long the planned move takes: command 20 of a motor.
        [0, 20, 1..=3] => MotorSetTravel(MotorSetTravel),
        /// Set how long the planned move gains speed: command 21 of a motor.
        [0, 21, 1..=3] => MotorSetProgramAcceleration(MotorSetProgramAcceleration),
        /// Set how long the planned move loses speed: command 22 of a motor.
        [0, 22, 1..=3] => MotorSetProgramDeceleration(MotorSetProgramDeceleration),
        /// Go to where the planned move begins: command 23 of a motor.
        [0, 23, 1..=3] => MotorSendToStart(MotorSendToStart),
        /// Go to where the planned move ends: command 24 of a motor.
        [0, 24, 1..=3] => MotorSendToStop(MotorSendToStop),
        /// Go on by one step of the planned move: command 25 of a motor.
        [0, 25, 1..=3] => MotorStepForward(MotorStepForward),
        /// Go back by one step of the planned move: command 26 of a motor.
        [0, 26, 1..=3] => MotorStepBack(MotorStepBack),
        /// Forget the limits: command 27 of a motor.
        [0, 27, 1..=3] => MotorResetLimits(MotorResetLimits),
        /// Does the motor move at all? Query 100 of a motor.
        [0, 100, 1..=3] => MotorEnable(MotorEnable),
        /// How many steps are added when the motor turns the other way? Query 101 of a motor.
        [0, 101, 1..=3] => MotorBacklash(MotorBacklash),
        /// Into how many microsteps is a step divided? Query 102 of a motor.
        [0, 102, 1..=3] => MotorMicrostep(MotorMicrostep),
        /// Which way is forward? Query 103 of a motor.
        [0, 103, 1..=3] => MotorDirection(MotorDirection),
        /// What is the greatest speed of the motor? Query 104 of a motor.
        [0, 104, 1..=3] => MotorMaxStepSpeed(MotorMaxStepSpeed),
        /// Where is the end limit? Query 105 of a motor.
        [0, 105, 1..=3] => MotorEndLimit(MotorEndLimit),
        /// Where is the motor? Query 106 of a motor.
        [0, 106, 1..=3] => MotorPosition(MotorPosition),
        /// Does the motor move? Query 107 of a motor.
        [0, 107, 1..=3] => MotorRunning(MotorRunning),
        /// What is the speed of continuous runs? Query 108 of a motor.
        [0, 108, 1..=3] => MotorContinuousSpeed(MotorContinuousSpeed),
        /// How quickly do continuous runs gain speed? Query 109 of a motor.
        [0, 109, 1..=3] => MotorContinuousAcceleration(MotorContinuousAcceleration),
        /// How does the planned move gain and lose speed? Query 110 of a motor.
        [0, 110, 1..=3] => MotorEasing(MotorEasing),
        /// Where does the planned move begin? Query 111 of a motor.
        [0, 111, 1..=3] => MotorProgramStart(MotorProgramStart),
        /// Where does the planned move end? Query 112 of a motor.
        [0, 112, 1..=3] => MotorProgramStop(MotorProgramStop),
        /// How long does the planned move take? Query 113 of a motor.
        [0, 113, 1..=3] => MotorTravel(MotorTravel),
        /// How long does the motor wait before its planned move? Query 114 of a motor.
        [0, 114, 1..=3] => MotorLeadIn(MotorLeadIn),
        /// How long does the planned move gain speed? Query 115 of a motor.
        [0, 115, 1..=3] => MotorProgramAcceleration(MotorProgramAcceleration),
        /// How long does the planned move lose speed? Query 116 of a motor.
        [0, 116, 1..=3] => MotorProgramDeceleration(MotorProgramDeceleration),
        /// What is the greatest speed of the planned move? Query 117 of a motor.
        [0, 117, 1..=3] => MotorMaxProgramSpeed(MotorMaxProgramSpeed),

        /// Set whether there is a camera: command 2 of the camera.
        [0, 2, 4] => CameraSetEnable(CameraSetEnable),
        /// Take a picture: command 3 of the camera.
        [0, 3, 4] => CameraExpose(CameraExpose),
        /// Set how long the shutter is held: command 4 of the camera.
        [0, 4, 4] => CameraSetExposureTime(CameraSetExposureTime),
        /// Set how long the focus is held: command 5 of the camera.
        [0, 5, 4] => CameraSetFocusTime(CameraSetFocusTime),
        /// Set after how many pictures the program ends: command 6 of the camera.
        [0, 6, 4] => CameraSetMaxShots(CameraSetMaxShots),
        /// Set how long to wait after a picture: command 7 of the camera.
        [0, 7, 4] => CameraSetExposureDelay(CameraSetExposureDelay),
        /// Set whether the focus is held together with the shutter: command 8 of the camera.
        [0, 8, 4] => CameraSetFocusWithShutter(CameraSetFocusWithShutter),
        /// Set whether the mirror goes up first: command 9 of the camera.
        [0, 9, 4] => CameraSetMirrorUp(CameraSetMirrorUp),
        /// Set the time from one picture to the next: command 10 of the camera.
        [0, 10, 4] => CameraSetInterval(CameraSetInterval),
        /// Is there a camera? Query 100 of the camera.
        [0, 100, 4] => CameraEnable(CameraEnable),
        /// Is the camera busy? Query 101 of the camera.
        [0, 101, 4] => CameraExposing(CameraExposing),
        /// How long is the shutter held? Query 102 of the camera.
        [0, 102, 4] => CameraExposureTime(CameraExposureTime),
        /// How long is the focus held? Query 103 of the camera.
        [0, 103, 4] => CameraFocusTime(CameraFocusTime),
        /// After how many pictures does the program end? Query 104 of the camera.
        [0, 104, 4] => CameraMaxShots(CameraMaxShots),
        /// How long is the wait after a picture? Query 105 of the camera.
        [0, 105, 4] => CameraExposureDelay(CameraExposureDelay),
        /// Is the focus held together with the shutter? Query 106 of the camera.
        [0, 106, 4] => CameraFocusWithShutter(CameraFocusWithShutter),
        /// Does the mirror go up first? Query 107 of the camera.
        [0, 107, 4] => CameraMirrorUp(CameraMirrorUp),
        /// What is the time from one picture to the next? Query 108 of the camera.
        [0, 108, 4] => CameraInterval(CameraInterval),

        /// All nodes: start or resume the planned moves. Broadcast 1.
        [1, 1, 0..=255] => BroadcastStart(BroadcastStart),
        /// All nodes: stop everything. Broadcast 2.
        [1, 2, 0..=255] => BroadcastStop(BroadcastStop),
        /// All nodes: pause the planned moves. Broadcast 3.
        [1, 3, 0..=255] => BroadcastPause(BroadcastPause),
        /// All nodes: take this address. Broadcast 4.
        [1, 4, 0..=255] => BroadcastAssignAddress(BroadcastAssignAddress),

        /// Which version of the core protocol do you speak? Core query 1.
        [2, 1, 0..=255] => CoreProtocolVersion(CoreProtocolVersion),
        /// What are you? Core query 2.
        [2, 2, 0..=255] => CoreDeviceId(CoreDeviceId),
        /// Which version are you of? Core query 3.
        [2, 3, 0..=255] => CoreDeviceVersion(CoreDeviceVersion),
        /// Take this address: core command 4.
        [2, 4, 0..=255] => CoreAssignAddress(CoreAssignAddress),
    }
}

messages! {
    /// What a node sends.
    ///
    /// The numbers of this table are `address << 16 | sub_address << 8 | response code`. A packet that is not addressed
    /// to the master is `Other`: an echo, or traffic between others.
    pub enum DeviceMessage<'a> {
        /// The answer to a request.
        [0, 0, 0..=255] => Reply(Reply<'a>),
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
        let number = u32::from_le_bytes([frame.command(), frame.sub_address(), frame.address().0, 0]);
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
