//! Messages of both sides, with one file for each chapter of the specification.
//!
//! [`HostMessage`] is a message of the master: a command or a query. [`DeviceMessage`] is a message of a node, which is
//! always a [`Reply`]. Nothing in a reply says what it answers; the [`Query`](crate::Query) that was asked reads it.

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
    Acceleration, AltMode, Amperes, Backlash, CommonLine, CoreVersion, Direction, Easing, EasingFound, Edge, EdgeFound,
    Level, MAX_ARRIVING, Microstep, Milliseconds, ProgramMode, RunState, ShortMilliseconds, ShortShots, ShortSpan,
    Shots, Span, Speed, StartDelay, StepCount, StepRate, Steps, StepsPerSecond, StepsPerSecondSquared, Version, Volts,
};
pub use value::{RingTip, SpeedOrSleep, Text, Value, ValueType};

use motion_core::messages;
use motion_core::wire::Messages;

use crate::frame::Selector;

messages! {
    /// Message of the master.
    ///
    /// The numbers of this table are those of [`Selector::number`](crate::Selector::number): first 1 for a broadcast or
    /// 2 for the core protocol, then the command, then the sub-address. A command has exactly the data that the table
    /// says. A command with data of another length is `Other`. Firmware accepts it: it reads missing bytes as zero, and
    /// ignores surplus bytes. Commands of later firmware are in the module `beyond`, with the feature of that name.
    pub enum HostMessage<'a> from host {
        /// Does nothing: command 0 of any part, which no node answers.
        [0, 0, 0..=255] => Noop(Noop) [asks],

        /// Starts or resumes the planned move: command 2 of the controller.
        [0, 2, 0] => Start(Start) [moves once, blocks 3000],
        /// Pauses the planned move: command 3 of the controller.
        [0, 3, 0] => Pause(Pause) [stops],
        /// Stops everything: command 4 of the controller.
        [0, 4, 0] => Stop(Stop) [stops],
        /// Switches the lamp for debugging: command 5 of the controller.
        [0, 5, 0] => ToggleDebugLed(ToggleDebugLed) [sets once],
        /// Gives the time to other nodes: command 6 of the controller.
        [0, 6, 0] => SetTimingMaster(SetTimingMaster) [sets once],
        /// Gives the node a name: command 7 of the controller.
        [0, 7, 0] => SetName(SetName) [sets once],
        /// Gives the node another address: command 8 of the controller.
        [0, 8, 0] => SetAddress(SetAddress) [resets once, blocks 3000],
        /// Sets the line on which nodes step in common: command 9 of the controller.
        [0, 9, 0] => SetCommonLine(SetCommonLine) [sets once],
        /// Sends all motors home: command 10 of the controller.
        [0, 10, 0] => ReturnHome(ReturnHome) [moves once],
        /// Sets the greatest step rate: command 11 of the controller.
        [0, 11, 0] => SetMaxStepRate(SetMaxStepRate) [sets once],
        /// Sets which edge of the auxiliary input counts: command 12 of the controller.
        [0, 12, 0] => SetInputEdge(SetInputEdge) [sets once],
        /// Sets the purposes of the auxiliary contacts: command 13 of the controller.
        [0, 13, 0] => SetAltModes(SetAltModes) [by main::alt_modes],
        /// Sets the dead-man of manual moves: command 14 of the controller.
        [0, 14, 0] => SetManualMove(SetManualMove) [sets once],
        /// Sets the delay of the auxiliary output before a picture: command 15 of the controller.
        [0, 15, 0] => SetOutBeforeDelay(SetOutBeforeDelay) [sets once],
        /// Sets the delay of the auxiliary output after a picture: command 16 of the controller.
        [0, 16, 0] => SetOutAfterDelay(SetOutAfterDelay) [sets once],
        /// Sets the time of the auxiliary output before a picture: command 17 of the controller.
        [0, 17, 0] => SetOutBeforeTime(SetOutBeforeTime) [sets once],
        /// Sets the time of the auxiliary output after a picture: command 18 of the controller.
        [0, 18, 0] => SetOutAfterTime(SetOutAfterTime) [sets once],
        /// Sets the level of the auxiliary output: command 19 of the controller.
        [0, 19, 0] => SetOutLevel(SetOutLevel) [sets once],
        /// Sets the time after which the planned move is stopped: command 20 of the controller.
        [0, 20, 0] => SetMaxRunTime(SetMaxRunTime) [sets once],
        /// Sets the delay before the planned move starts: command 21 of the controller.
        [0, 21, 0] => SetStartDelay(SetStartDelay) [sets once],
        /// Sets the mode of the planned move: command 22 of the controller.
        [0, 22, 0] => SetProgramMode(SetProgramMode) [sets once],
        /// Sets joystick mode: command 23 of the controller.
        [0, 23, 0] => SetJoystickMode(SetJoystickMode) [sets once],
        /// Sets whether the planned move goes to and fro: command 24 of the controller.
        [0, 24, 0] => SetPingPong(SetPingPong) [sets once],
        /// Asks for the version of the firmware: query 100 of the controller.
        [0, 100, 0] => FirmwareVersion(FirmwareVersion) [asks],
        /// Asks whether the planned move runs: query 101 of the controller.
        [0, 101, 0] => RunStatus(RunStatus) [asks],
        /// Asks how long the planned move has run: query 102 of the controller.
        [0, 102, 0] => RunTime(RunTime) [asks],
        /// Asks whether a picture is being taken: query 103 of the controller.
        [0, 103, 0] => Exposing(Exposing) [asks],
        /// Asks whether the node is the timing master: query 104 of the controller.
        [0, 104, 0] => TimingMaster(TimingMaster) [asks],
        /// Asks for the name of the node: query 105 of the controller.
        [0, 105, 0] => Name(NameQuery) [asks],
        /// Asks for the greatest step rate: query 106 of the controller.
        [0, 106, 0] => MaxStepRate(MaxStepRate) [asks],
        /// Asks for the supply voltage: query 107 of the controller.
        [0, 107, 0] => Voltage(Voltage) [asks],
        /// Asks for the supply current: query 108 of the controller.
        [0, 108, 0] => Current(Current) [asks],
        /// Asks which edge of the auxiliary input counts: query 109 of the controller.
        [0, 109, 0] => InputEdge(InputEdge) [asks],
        /// Asks for the purposes of the auxiliary contacts: query 110 of the controller.
        [0, 110, 0] => AltModes(AltModes) [asks],
        /// Asks for the levels of the limit switches: query 111 of the controller.
        [0, 111, 0] => LimitSwitches(LimitSwitches) [asks],
        /// Asks for the delay of the auxiliary output before a picture: query 112 of the controller.
        [0, 112, 0] => OutBeforeDelay(OutBeforeDelay) [asks],
        /// Asks for the delay of the auxiliary output after a picture: query 113 of the controller.
        [0, 113, 0] => OutAfterDelay(OutAfterDelay) [asks],
        /// Asks how long the auxiliary output is on before a picture: query 114 of the controller.
        [0, 114, 0] => OutBeforeTime(OutBeforeTime) [asks],
        /// Asks how long the auxiliary output is on after a picture: query 115 of the controller.
        [0, 115, 0] => OutAfterTime(OutAfterTime) [asks],
        /// Asks for the level at which the auxiliary output is on: query 116 of the controller.
        [0, 116, 0] => OutLevel(OutLevel) [asks],
        /// Asks for the delay before the planned move starts: query 117 of the controller.
        [0, 117, 0] => StartDelay(StartDelayQuery) [asks],
        /// Asks for the mode of the planned move: query 118 of the controller.
        [0, 118, 0] => ProgramMode(ProgramModeQuery) [asks],
        /// Asks whether the power was off since the last such query: query 119 of the controller.
        [0, 119, 0] => PowerCycled(PowerCycled) [sets once],
        /// Asks whether joystick mode is on: query 120 of the controller.
        [0, 120, 0] => JoystickMode(JoystickMode) [asks],
        /// Asks whether the planned move goes to and fro: query 121 of the controller.
        [0, 121, 0] => PingPong(PingPong) [asks],

        /// Sets whether a resting motor has no current: command 2 of a motor.
        [0, 2, 1..=3] => MotorSetSleep(MotorSetSleep) [sets once],
        /// Enables the motor, or disables it: command 3 of a motor.
        [0, 3, 1..=3] => MotorSetEnable(MotorSetEnable) [sets once],
        /// Stops one motor: command 4 of a motor.
        [0, 4, 1..=3] => MotorStop(MotorStop) [stops],
        /// Sets the number of steps that are added when the motor reverses: command 5 of a motor.
        [0, 5, 1..=3] => MotorSetBacklash(MotorSetBacklash) [sets once],
        /// Sets into how many microsteps a step is divided: command 6 of a motor.
        [0, 6, 1..=3] => MotorSetMicrostep(MotorSetMicrostep) [sets once],
        /// Sets the greatest speed of the motor: command 7 of a motor.
        [0, 7, 1..=3] => MotorSetMaxStepSpeed(MotorSetMaxStepSpeed) [sets once],
        /// Sets which direction is forward: command 8 of a motor.
        [0, 8, 1..=3] => MotorSetDirection(MotorSetDirection) [sets once],
        /// Makes the present position the home: command 9 of a motor.
        [0, 9, 1..=3] => MotorSetHomeHere(MotorSetHomeHere) [sets once],
        /// Makes the present position the end limit: command 10 of a motor.
        [0, 10, 1..=3] => MotorSetEndHere(MotorSetEndHere) [sets once],
        /// Sends the motor home: command 11 of a motor.
        [0, 11, 1..=3] => MotorSendHome(MotorSendHome) [moves once],
        /// Sends the motor to the end limit: command 12 of a motor.
        [0, 12, 1..=3] => MotorSendToEnd(MotorSendToEnd) [moves once],
        /// Sets the speed of continuous runs: command 13 of a motor.
        [0, 13, 1..=3] => MotorSetContinuousSpeed(MotorSetContinuousSpeed) [by motor::continuous_speed],
        /// Sets the acceleration of continuous runs: command 14 of a motor.
        [0, 14, 1..=3] => MotorSetContinuousAcceleration(MotorSetContinuousAcceleration) [moves once],
        /// Moves the motor by a number of steps: command 15 of a motor.
        [0, 15, 1..=3] => MotorMove(MotorMove) [moves once]
            or
            /// Runs the motor until it is stopped: command 15 of a motor, with no steps.
            MotorRun(MotorRun) [moves once],
        /// Sets the position at which the planned move begins: command 16 of a motor.
        [0, 16, 1..=3] => MotorSetProgramStart(MotorSetProgramStart) [sets once],
        /// Sets the position at which the planned move ends: command 17 of a motor.
        [0, 17, 1..=3] => MotorSetProgramStop(MotorSetProgramStop) [sets once],
        /// Sets the easing of the planned move: command 18 of a motor.
        [0, 18, 1..=3] => MotorSetEasing(MotorSetEasing) [sets once],
        /// Sets the lead-in, in 16 bits: command 19 of a motor.
        [0, 19, 1..=3] => MotorSetLeadIn(MotorSetLeadIn) [sets once]
            or
            /// Sets the lead-in, in 32 bits, for v0.35 and later: command 19 of a motor.
            MotorSetLeadInLong(MotorSetLeadInLong) [sets once],
        /// Sets the duration of the planned move: command 20 of a motor.
        [0, 20, 1..=3] => MotorSetTravel(MotorSetTravel) [sets once],
        /// Sets how long the planned move gains speed: command 21 of a motor.
        [0, 21, 1..=3] => MotorSetProgramAcceleration(MotorSetProgramAcceleration) [sets once],
        /// Sets how long the planned move loses speed: command 22 of a motor.
        [0, 22, 1..=3] => MotorSetProgramDeceleration(MotorSetProgramDeceleration) [sets once],
        /// Sends the motor to the start of the planned move: command 23 of a motor.
        [0, 23, 1..=3] => MotorSendToStart(MotorSendToStart) [moves once],
        /// Sends the motor to the end of the planned move: command 24 of a motor.
        [0, 24, 1..=3] => MotorSendToStop(MotorSendToStop) [moves once],
        /// Moves the motor on by one step of the planned move: command 25 of a motor.
        [0, 25, 1..=3] => MotorStepForward(MotorStepForward) [moves once],
        /// Moves the motor back by one step of the planned move: command 26 of a motor.
        [0, 26, 1..=3] => MotorStepBack(MotorStepBack) [moves once],
        /// Forgets the limits: command 27 of a motor.
        [0, 27, 1..=3] => MotorResetLimits(MotorResetLimits) [sets once],
        /// Asks whether the motor is enabled: query 100 of a motor.
        [0, 100, 1..=3] => MotorEnable(MotorEnable) [asks],
        /// Asks how many steps are added when the motor reverses: query 101 of a motor.
        [0, 101, 1..=3] => MotorBacklash(MotorBacklash) [asks],
        /// Asks into how many microsteps a step is divided: query 102 of a motor.
        [0, 102, 1..=3] => MotorMicrostep(MotorMicrostep) [asks],
        /// Asks which direction is forward: query 103 of a motor.
        [0, 103, 1..=3] => MotorDirection(MotorDirection) [asks],
        /// Asks for the greatest speed of the motor: query 104 of a motor.
        [0, 104, 1..=3] => MotorMaxStepSpeed(MotorMaxStepSpeed) [asks],
        /// Asks for the position of the end limit: query 105 of a motor.
        [0, 105, 1..=3] => MotorEndLimit(MotorEndLimit) [asks],
        /// Asks for the position of the motor: query 106 of a motor.
        [0, 106, 1..=3] => MotorPosition(MotorPosition) [asks],
        /// Asks whether the motor moves: query 107 of a motor.
        [0, 107, 1..=3] => MotorRunning(MotorRunning) [asks],
        /// Asks for the speed of continuous runs: query 108 of a motor.
        [0, 108, 1..=3] => MotorContinuousSpeed(MotorContinuousSpeed) [asks],
        /// Asks for the acceleration of continuous runs: query 109 of a motor.
        [0, 109, 1..=3] => MotorContinuousAcceleration(MotorContinuousAcceleration) [asks],
        /// Asks for the easing of the planned move: query 110 of a motor.
        [0, 110, 1..=3] => MotorEasing(MotorEasing) [asks],
        /// Asks for the position at which the planned move begins: query 111 of a motor.
        [0, 111, 1..=3] => MotorProgramStart(MotorProgramStart) [asks],
        /// Asks for the position at which the planned move ends: query 112 of a motor.
        [0, 112, 1..=3] => MotorProgramStop(MotorProgramStop) [asks],
        /// Asks for the duration of the planned move: query 113 of a motor.
        [0, 113, 1..=3] => MotorTravel(MotorTravel) [asks],
        /// Asks for the lead-in: query 114 of a motor.
        [0, 114, 1..=3] => MotorLeadIn(MotorLeadIn) [asks],
        /// Asks how long the planned move gains speed: query 115 of a motor.
        [0, 115, 1..=3] => MotorProgramAcceleration(MotorProgramAcceleration) [asks],
        /// Asks how long the planned move loses speed: query 116 of a motor.
        [0, 116, 1..=3] => MotorProgramDeceleration(MotorProgramDeceleration) [asks],
        /// Asks for the greatest speed of the planned move: query 117 of a motor.
        [0, 117, 1..=3] => MotorMaxProgramSpeed(MotorMaxProgramSpeed) [asks],

        /// Sets whether there is a camera: command 2 of the camera.
        [0, 2, 4] => CameraSetEnable(CameraSetEnable) [sets once],
        /// Takes a picture: command 3 of the camera.
        [0, 3, 4] => CameraExpose(CameraExpose) [sets once],
        /// Sets how long the shutter is held: command 4 of the camera.
        [0, 4, 4] => CameraSetExposureTime(CameraSetExposureTime) [sets once],
        /// Sets how long the focus is held: command 5 of the camera.
        [0, 5, 4] => CameraSetFocusTime(CameraSetFocusTime) [sets once],
        /// Sets after how many pictures the program ends: command 6 of the camera.
        [0, 6, 4] => CameraSetMaxShots(CameraSetMaxShots) [sets once],
        /// Sets how long to wait after a picture: command 7 of the camera.
        [0, 7, 4] => CameraSetExposureDelay(CameraSetExposureDelay) [sets once],
        /// Sets whether the focus is held together with the shutter: command 8 of the camera.
        [0, 8, 4] => CameraSetFocusWithShutter(CameraSetFocusWithShutter) [sets once],
        /// Sets whether the mirror goes up first: command 9 of the camera.
        [0, 9, 4] => CameraSetMirrorUp(CameraSetMirrorUp) [sets once],
        /// Sets the time from one picture to the next: command 10 of the camera.
        [0, 10, 4] => CameraSetInterval(CameraSetInterval) [sets once],
        /// Asks whether there is a camera: query 100 of the camera.
        [0, 100, 4] => CameraEnable(CameraEnable) [asks],
        /// Asks whether the camera is busy: query 101 of the camera.
        [0, 101, 4] => CameraExposing(CameraExposing) [asks],
        /// Asks how long the shutter is held: query 102 of the camera.
        [0, 102, 4] => CameraExposureTime(CameraExposureTime) [asks],
        /// Asks how long the focus is held: query 103 of the camera.
        [0, 103, 4] => CameraFocusTime(CameraFocusTime) [asks],
        /// Asks after how many pictures the program ends: query 104 of the camera.
        [0, 104, 4] => CameraMaxShots(CameraMaxShots) [asks],
        /// Asks how long to wait after a picture: query 105 of the camera.
        [0, 105, 4] => CameraExposureDelay(CameraExposureDelay) [asks],
        /// Asks whether the focus is held together with the shutter: query 106 of the camera.
        [0, 106, 4] => CameraFocusWithShutter(CameraFocusWithShutter) [asks],
        /// Asks whether the mirror goes up first: query 107 of the camera.
        [0, 107, 4] => CameraMirrorUp(CameraMirrorUp) [asks],
        /// Asks for the time from one picture to the next: query 108 of the camera.
        [0, 108, 4] => CameraInterval(CameraInterval) [asks],

        /// Starts or resumes the planned moves of all nodes: broadcast 1.
        [1, 1, 0..=255] => BroadcastStart(BroadcastStart) [moves once, blocks 3000],
        /// Stops everything in all nodes: broadcast 2.
        [1, 2, 0..=255] => BroadcastStop(BroadcastStop) [stops],
        /// Pauses the planned moves of all nodes: broadcast 3.
        [1, 3, 0..=255] => BroadcastPause(BroadcastPause) [stops],
        /// Gives all nodes the same address: broadcast 4.
        [1, 4, 0..=255] => BroadcastAssignAddress(BroadcastAssignAddress) [resets once, blocks 3000],

        /// Asks for the version of the core protocol: core query 1.
        [2, 1, 0..=255] => CoreProtocolVersion(CoreProtocolVersion) [asks],
        /// Asks for the kind of the device: core query 2.
        [2, 2, 0..=255] => CoreDeviceId(CoreDeviceId) [asks],
        /// Asks for the version of the device: core query 3.
        [2, 3, 0..=255] => CoreDeviceVersion(CoreDeviceVersion) [asks],
        /// Gives the node another address: core command 4.
        [2, 4, 0..=255] => CoreAssignAddress(CoreAssignAddress) [resets once, blocks 3000],
    }
}

messages! {
    /// Message of a node.
    ///
    /// The numbers of this table are `address << 16 | sub_address << 8 | response code`. A packet that is not addressed
    /// to the master is `Other`: an echo, or traffic of others.
    pub enum DeviceMessage<'a> {
        /// Answer to a request.
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
