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
pub use motion_core::fixed::{Centi, Scaled};
pub use motion_core::wire::{Bool, Other};
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
use motion_core::wire::Messages;

use crate::frame::Selector;

messages! {
    /// What the master sends.
    ///
    /// The numbers of this table are those of [`Selector::number`](crate::Selector::number): in front 1 for a broadcast and 2 for the core
    /// protocol, then the command, then the sub-address. A command has exactly the data that the table says; with data of
    /// another length it is `Other`, because the firmware takes that as well: it reads missing bytes as zero and leaves
    /// out surplus ones. What later firmware added stands apart, in [`beyond`](crate::beyond).
    pub enum HostMessage<'a> from host {
        /// Nothing: command 0 of any part, which no node answers.
        [0, 0, 0..=255] => Noop(Noop) [asks],

        /// Start or resume the planned move: command 2 of the controller.
        [0, 2, 0] => Start(Start) [moves once],
        /// Pause the planned move: command 3 of the controller.
        [0, 3, 0] => Pause(Pause) [stops],
        /// Stop everything: command 4 of the controller.
        [0, 4, 0] => Stop(Stop) [stops],
        /// Switch the lamp for debugging: command 5 of the controller.
        [0, 5, 0] => ToggleDebugLed(ToggleDebugLed) [sets once],
        /// Give the time to other nodes: command 6 of the controller.
        [0, 6, 0] => SetTimingMaster(SetTimingMaster) [sets once],
        /// Give the node a name: command 7 of the controller.
        [0, 7, 0] => SetName(SetName) [sets once],
        /// Take another address: command 8 of the controller.
        [0, 8, 0] => SetAddress(SetAddress) [resets once],
        /// Step in common with other nodes: command 9 of the controller.
        [0, 9, 0] => SetCommonLine(SetCommonLine) [sets once],
        /// Send all motors home: command 10 of the controller.
        [0, 10, 0] => ReturnHome(ReturnHome) [moves once],
        /// Set the greatest step rate: command 11 of the controller.
        [0, 11, 0] => SetMaxStepRate(SetMaxStepRate) [sets once],
        /// Set which edge of the auxiliary input counts: command 12 of the controller.
        [0, 12, 0] => SetInputEdge(SetInputEdge) [sets once],
        /// Set what the auxiliary contacts are for: command 13 of the controller.
        [0, 13, 0] => SetAltModes(SetAltModes) [by main::alt_modes],
        /// Set the dead-man of manual moves: command 14 of the controller.
        [0, 14, 0] => SetManualMove(SetManualMove) [sets once],
        /// Set the delay of the auxiliary output before a picture: command 15 of the controller.
        [0, 15, 0] => SetOutBeforeDelay(SetOutBeforeDelay) [sets once],
        /// Set the delay of the auxiliary output after a picture: command 16 of the controller.
        [0, 16, 0] => SetOutAfterDelay(SetOutAfterDelay) [sets once],
        /// Set the time of the auxiliary output before a picture: command 17 of the controller.
        [0, 17, 0] => SetOutBeforeTime(SetOutBeforeTime) [sets once],
        /// Set the time of the auxiliary output after a picture: command 18 of the controller.
        [0, 18, 0] => SetOutAfterTime(SetOutAfterTime) [sets once],
        /// Set the level of the auxiliary output: command 19 of the controller.
        [0, 19, 0] => SetOutLevel(SetOutLevel) [sets once],
        /// Set after how long the planned move is stopped: command 20 of the controller.
        [0, 20, 0] => SetMaxRunTime(SetMaxRunTime) [sets once],
        /// Set how long the planned move waits: command 21 of the controller.
        [0, 21, 0] => SetStartDelay(SetStartDelay) [sets once],
        /// Set what kind of program the planned move is: command 22 of the controller.
        [0, 22, 0] => SetProgramMode(SetProgramMode) [sets once],
        /// Set joystick mode: command 23 of the controller.
        [0, 23, 0] => SetJoystickMode(SetJoystickMode) [sets once],
        /// Set whether the planned move goes to and fro: command 24 of the controller.
        [0, 24, 0] => SetPingPong(SetPingPong) [sets once],
        /// Which firmware do you have? Query 100 of the controller.
        [0, 100, 0] => FirmwareVersion(FirmwareVersion) [asks],
        /// Does the planned move run? Query 101 of the controller.
        [0, 101, 0] => RunStatus(RunStatus) [asks],
        /// How long has the planned move run? Query 102 of the controller.
        [0, 102, 0] => RunTime(RunTime) [asks],
        /// Is a picture being taken? Query 103 of the controller.
        [0, 103, 0] => Exposing(Exposing) [asks],
        /// Are you the timing master? Query 104 of the controller.
        [0, 104, 0] => TimingMaster(TimingMaster) [asks],
        /// What is the node called? Query 105 of the controller.
        [0, 105, 0] => Name(NameQuery) [asks],
        /// What is the greatest step rate? Query 106 of the controller.
        [0, 106, 0] => MaxStepRate(MaxStepRate) [asks],
        /// What is the supply voltage? Query 107 of the controller.
        [0, 107, 0] => Voltage(Voltage) [asks],
        /// What is the supply current? Query 108 of the controller.
        [0, 108, 0] => Current(Current) [asks],
        /// Which edge of the auxiliary input counts? Query 109 of the controller.
        [0, 109, 0] => InputEdge(InputEdge) [asks],
        /// What are the auxiliary contacts for? Query 110 of the controller.
        [0, 110, 0] => AltModes(AltModes) [asks],
        /// Which levels have the limit switches? Query 111 of the controller.
        [0, 111, 0] => LimitSwitches(LimitSwitches) [asks],
        /// What is the delay of the auxiliary output before a picture? Query 112 of the controller.
        [0, 112, 0] => OutBeforeDelay(OutBeforeDelay) [asks],
        /// What is the delay of the auxiliary output after a picture? Query 113 of the controller.
        [0, 113, 0] => OutAfterDelay(OutAfterDelay) [asks],
        /// What is the time of the auxiliary output before a picture? Query 114 of the controller.
        [0, 114, 0] => OutBeforeTime(OutBeforeTime) [asks],
        /// What is the time of the auxiliary output after a picture? Query 115 of the controller.
        [0, 115, 0] => OutAfterTime(OutAfterTime) [asks],
        /// What is the level of the auxiliary output? Query 116 of the controller.
        [0, 116, 0] => OutLevel(OutLevel) [asks],
        /// How long does the planned move wait? Query 117 of the controller.
        [0, 117, 0] => StartDelay(StartDelayQuery) [asks],
        /// What kind of program is the planned move? Query 118 of the controller.
        [0, 118, 0] => ProgramMode(ProgramModeQuery) [asks],
        /// Has the power been off? Query 119 of the controller.
        [0, 119, 0] => PowerCycled(PowerCycled) [sets once],
        /// Is joystick mode on? Query 120 of the controller.
        [0, 120, 0] => JoystickMode(JoystickMode) [asks],
        /// Does the planned move go to and fro? Query 121 of the controller.
        [0, 121, 0] => PingPong(PingPong) [asks],

        /// Set whether a resting motor has no current: command 2 of a motor.
        [0, 2, 1..=3] => MotorSetSleep(MotorSetSleep) [sets once],
        /// Set whether the motor moves at all: command 3 of a motor.
        [0, 3, 1..=3] => MotorSetEnable(MotorSetEnable) [sets once],
        /// Stop one motor: command 4 of a motor.
        [0, 4, 1..=3] => MotorStop(MotorStop) [stops],
        /// Set the steps that are added when the motor turns the other way: command 5 of a motor.
        [0, 5, 1..=3] => MotorSetBacklash(MotorSetBacklash) [sets once],
        /// Set into how many microsteps a step is divided: command 6 of a motor.
        [0, 6, 1..=3] => MotorSetMicrostep(MotorSetMicrostep) [sets once],
        /// Set the greatest speed of the motor: command 7 of a motor.
        [0, 7, 1..=3] => MotorSetMaxStepSpeed(MotorSetMaxStepSpeed) [sets once],
        /// Set which way is forward: command 8 of a motor.
        [0, 8, 1..=3] => MotorSetDirection(MotorSetDirection) [sets once],
        /// Here is home: command 9 of a motor.
        [0, 9, 1..=3] => MotorSetHomeHere(MotorSetHomeHere) [sets once],
        /// Here is the end limit: command 10 of a motor.
        [0, 10, 1..=3] => MotorSetEndHere(MotorSetEndHere) [sets once],
        /// Go home: command 11 of a motor.
        [0, 11, 1..=3] => MotorSendHome(MotorSendHome) [moves once],
        /// Go to the end limit: command 12 of a motor.
        [0, 12, 1..=3] => MotorSendToEnd(MotorSendToEnd) [moves once],
        /// Set the speed of continuous runs: command 13 of a motor.
        [0, 13, 1..=3] => MotorSetContinuousSpeed(MotorSetContinuousSpeed) [by motor::continuous_speed],
        /// Set how quickly continuous runs gain speed: command 14 of a motor.
        [0, 14, 1..=3] => MotorSetContinuousAcceleration(MotorSetContinuousAcceleration) [moves once],
        /// Move by a number of steps: command 15 of a motor.
        [0, 15, 1..=3] => MotorMove(MotorMove) [moves once]
            or
            /// Run until told otherwise: command 15 of a motor, with no steps.
            MotorRun(MotorRun) [moves once],
        /// Set where the planned move begins: command 16 of a motor.
        [0, 16, 1..=3] => MotorSetProgramStart(MotorSetProgramStart) [sets once],
        /// Set where the planned move ends: command 17 of a motor.
        [0, 17, 1..=3] => MotorSetProgramStop(MotorSetProgramStop) [sets once],
        /// Set how the planned move gains and loses speed: command 18 of a motor.
        [0, 18, 1..=3] => MotorSetEasing(MotorSetEasing) [sets once],
        /// Set how long the motor waits before its planned move: command 19 of a motor.
        [0, 19, 1..=3] => MotorSetLeadIn(MotorSetLeadIn) [sets once]
            or
            /// The same in 32 bits, for v0.35 and later: command 19 of a motor.
            MotorSetLeadInLong(MotorSetLeadInLong) [sets once],
        /// Set how long the planned move takes: command 20 of a motor.
        [0, 20, 1..=3] => MotorSetTravel(MotorSetTravel) [sets once],
        /// Set how long the planned move gains speed: command 21 of a motor.
        [0, 21, 1..=3] => MotorSetProgramAcceleration(MotorSetProgramAcceleration) [sets once],
        /// Set how long the planned move loses speed: command 22 of a motor.
        [0, 22, 1..=3] => MotorSetProgramDeceleration(MotorSetProgramDeceleration) [sets once],
        /// Go to where the planned move begins: command 23 of a motor.
        [0, 23, 1..=3] => MotorSendToStart(MotorSendToStart) [moves once],
        /// Go to where the planned move ends: command 24 of a motor.
        [0, 24, 1..=3] => MotorSendToStop(MotorSendToStop) [moves once],
        /// Go on by one step of the planned move: command 25 of a motor.
        [0, 25, 1..=3] => MotorStepForward(MotorStepForward) [moves once],
        /// Go back by one step of the planned move: command 26 of a motor.
        [0, 26, 1..=3] => MotorStepBack(MotorStepBack) [moves once],
        /// Forget the limits: command 27 of a motor.
        [0, 27, 1..=3] => MotorResetLimits(MotorResetLimits) [sets once],
        /// Does the motor move at all? Query 100 of a motor.
        [0, 100, 1..=3] => MotorEnable(MotorEnable) [asks],
        /// How many steps are added when the motor turns the other way? Query 101 of a motor.
        [0, 101, 1..=3] => MotorBacklash(MotorBacklash) [asks],
        /// Into how many microsteps is a step divided? Query 102 of a motor.
        [0, 102, 1..=3] => MotorMicrostep(MotorMicrostep) [asks],
        /// Which way is forward? Query 103 of a motor.
        [0, 103, 1..=3] => MotorDirection(MotorDirection) [asks],
        /// What is the greatest speed of the motor? Query 104 of a motor.
        [0, 104, 1..=3] => MotorMaxStepSpeed(MotorMaxStepSpeed) [asks],
        /// Where is the end limit? Query 105 of a motor.
        [0, 105, 1..=3] => MotorEndLimit(MotorEndLimit) [asks],
        /// Where is the motor? Query 106 of a motor.
        [0, 106, 1..=3] => MotorPosition(MotorPosition) [asks],
        /// Does the motor move? Query 107 of a motor.
        [0, 107, 1..=3] => MotorRunning(MotorRunning) [asks],
        /// What is the speed of continuous runs? Query 108 of a motor.
        [0, 108, 1..=3] => MotorContinuousSpeed(MotorContinuousSpeed) [asks],
        /// How quickly do continuous runs gain speed? Query 109 of a motor.
        [0, 109, 1..=3] => MotorContinuousAcceleration(MotorContinuousAcceleration) [asks],
        /// How does the planned move gain and lose speed? Query 110 of a motor.
        [0, 110, 1..=3] => MotorEasing(MotorEasing) [asks],
        /// Where does the planned move begin? Query 111 of a motor.
        [0, 111, 1..=3] => MotorProgramStart(MotorProgramStart) [asks],
        /// Where does the planned move end? Query 112 of a motor.
        [0, 112, 1..=3] => MotorProgramStop(MotorProgramStop) [asks],
        /// How long does the planned move take? Query 113 of a motor.
        [0, 113, 1..=3] => MotorTravel(MotorTravel) [asks],
        /// How long does the motor wait before its planned move? Query 114 of a motor.
        [0, 114, 1..=3] => MotorLeadIn(MotorLeadIn) [asks],
        /// How long does the planned move gain speed? Query 115 of a motor.
        [0, 115, 1..=3] => MotorProgramAcceleration(MotorProgramAcceleration) [asks],
        /// How long does the planned move lose speed? Query 116 of a motor.
        [0, 116, 1..=3] => MotorProgramDeceleration(MotorProgramDeceleration) [asks],
        /// What is the greatest speed of the planned move? Query 117 of a motor.
        [0, 117, 1..=3] => MotorMaxProgramSpeed(MotorMaxProgramSpeed) [asks],

        /// Set whether there is a camera: command 2 of the camera.
        [0, 2, 4] => CameraSetEnable(CameraSetEnable) [sets once],
        /// Take a picture: command 3 of the camera.
        [0, 3, 4] => CameraExpose(CameraExpose) [sets once],
        /// Set how long the shutter is held: command 4 of the camera.
        [0, 4, 4] => CameraSetExposureTime(CameraSetExposureTime) [sets once],
        /// Set how long the focus is held: command 5 of the camera.
        [0, 5, 4] => CameraSetFocusTime(CameraSetFocusTime) [sets once],
        /// Set after how many pictures the program ends: command 6 of the camera.
        [0, 6, 4] => CameraSetMaxShots(CameraSetMaxShots) [sets once],
        /// Set how long to wait after a picture: command 7 of the camera.
        [0, 7, 4] => CameraSetExposureDelay(CameraSetExposureDelay) [sets once],
        /// Set whether the focus is held together with the shutter: command 8 of the camera.
        [0, 8, 4] => CameraSetFocusWithShutter(CameraSetFocusWithShutter) [sets once],
        /// Set whether the mirror goes up first: command 9 of the camera.
        [0, 9, 4] => CameraSetMirrorUp(CameraSetMirrorUp) [sets once],
        /// Set the time from one picture to the next: command 10 of the camera.
        [0, 10, 4] => CameraSetInterval(CameraSetInterval) [sets once],
        /// Is there a camera? Query 100 of the camera.
        [0, 100, 4] => CameraEnable(CameraEnable) [asks],
        /// Is the camera busy? Query 101 of the camera.
        [0, 101, 4] => CameraExposing(CameraExposing) [asks],
        /// How long is the shutter held? Query 102 of the camera.
        [0, 102, 4] => CameraExposureTime(CameraExposureTime) [asks],
        /// How long is the focus held? Query 103 of the camera.
        [0, 103, 4] => CameraFocusTime(CameraFocusTime) [asks],
        /// After how many pictures does the program end? Query 104 of the camera.
        [0, 104, 4] => CameraMaxShots(CameraMaxShots) [asks],
        /// How long is the wait after a picture? Query 105 of the camera.
        [0, 105, 4] => CameraExposureDelay(CameraExposureDelay) [asks],
        /// Is the focus held together with the shutter? Query 106 of the camera.
        [0, 106, 4] => CameraFocusWithShutter(CameraFocusWithShutter) [asks],
        /// Does the mirror go up first? Query 107 of the camera.
        [0, 107, 4] => CameraMirrorUp(CameraMirrorUp) [asks],
        /// What is the time from one picture to the next? Query 108 of the camera.
        [0, 108, 4] => CameraInterval(CameraInterval) [asks],

        /// All nodes: start or resume the planned moves. Broadcast 1.
        [1, 1, 0..=255] => BroadcastStart(BroadcastStart) [moves once],
        /// All nodes: stop everything. Broadcast 2.
        [1, 2, 0..=255] => BroadcastStop(BroadcastStop) [stops],
        /// All nodes: pause the planned moves. Broadcast 3.
        [1, 3, 0..=255] => BroadcastPause(BroadcastPause) [stops],
        /// All nodes: take this address. Broadcast 4.
        [1, 4, 0..=255] => BroadcastAssignAddress(BroadcastAssignAddress) [resets once],

        /// Which version of the core protocol do you speak? Core query 1.
        [2, 1, 0..=255] => CoreProtocolVersion(CoreProtocolVersion) [asks],
        /// What are you? Core query 2.
        [2, 2, 0..=255] => CoreDeviceId(CoreDeviceId) [asks],
        /// Which version are you of? Core query 3.
        [2, 3, 0..=255] => CoreDeviceVersion(CoreDeviceVersion) [asks],
        /// Take this address: core command 4.
        [2, 4, 0..=255] => CoreAssignAddress(CoreAssignAddress) [resets once],
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

impl HostMessage<'_> {
    /// Selector of the command: its table, its number and the part of the node that it is for.
    #[must_use]
    #[inline]
    pub fn selector(&self) -> Selector {
        Selector::from_number(self.number())
    }
}
