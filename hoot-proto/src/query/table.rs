//! Table of all queries, and the values that they ask for.

use core::fmt;

use motion_core::wire::{Bool, Fields, Visitor};

use super::form::Form;
use super::{Answer, IntoReply, Profile, Query, ReplyError, ReplyValue, decode};
use crate::message::{
    Acceleration, AltMode, AltModes, Amperes, Backlash, CameraEnable, CameraExposing, CameraExposureDelay,
    CameraExposureTime, CameraFocusTime, CameraFocusWithShutter, CameraInterval, CameraMaxShots, CameraMirrorUp,
    CoreDeviceId, CoreDeviceVersion, CoreProtocolVersion, CoreVersion, Current, Direction, EasingFound, EdgeFound,
    Exposing, FirmwareVersion, HostMessage, InputEdge, JoystickMode, Level, LimitSwitches, MaxStepRate, Microstep,
    Milliseconds, MotorBacklash, MotorContinuousAcceleration, MotorContinuousSpeed, MotorDirection, MotorEasing,
    MotorEnable, MotorEndLimit, MotorLeadIn, MotorMaxProgramSpeed, MotorMaxStepSpeed, MotorMicrostep, MotorPosition,
    MotorProgramAcceleration, MotorProgramDeceleration, MotorProgramStart, MotorProgramStop, MotorRunning, MotorTravel,
    NameQuery, OutAfterDelay, OutAfterTime, OutBeforeDelay, OutBeforeTime, OutLevel, PingPong, PowerCycled,
    ProgramMode, ProgramModeQuery, Reply, RingTip, RunState, RunStatus, RunTime, ShortMilliseconds, Shots, Span, Speed,
    SpeedOrSleep, StartDelay, StartDelayQuery, StepRate, Steps, Text, TimingMaster, Value, ValueType, Version, Voltage,
    Volts,
};

/// Whether two names are the same.
pub(crate) const fn is_same(one: &str, other: &str) -> bool {
    let (mut one, mut other) = (one.as_bytes(), other.as_bytes());
    loop {
        match (one, other) {
            ([], []) => return true,
            ([a, rest @ ..], [b, others @ ..]) if *a == *b => (one, other) = (rest, others),
            _ => return false,
        }
    }
}

/// Makes the queries of one table: the value of each query, and the enums over all queries.
macro_rules! queries {
    ($($variant:ident($query:ty) => $answer:ty: $form:ident;)*) => {
        $(impl Query for $query {
            type Reply<'a> = Answer<$answer>;

            #[inline]
            fn decode_reply<'a>(&self, reply: Reply<'a>) -> Result<Self::Reply<'a>, ReplyError> {
                decode(Form::$form, reply)
            }
        }

        impl $query {
            /// Makes the answer to the query: a value, with the type that firmware of a profile sends.
            #[must_use]
            #[allow(clippy::extra_unused_lifetimes, reason = "only texts have one")]
            pub fn answer<'a>(&self, value: $answer, profile: Profile) -> Answer<$answer> {
                Answer::new(value, Form::$form.of(profile))
            }
        })*

        /// Any query.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum AnyQuery {
            $(#[doc = concat!("[`HostMessage::", stringify!($variant), "`].")]
            $variant($query),)*
        }

        impl Form {
            /// Form of the answer to a query with this name.
            pub(crate) const fn named(name: &str) -> Self {
                $(if is_same(name, stringify!($variant)) {
                    return Self::$form;
                })*
                Self::Byte
            }
        }

        impl AnyQuery {
            /// Answer to the query with a value, if the value has the right meaning and size.
            pub(crate) fn read(self, value: Value<'_>) -> Option<AnyReply<'_>> {
                let value_type = value.value_type();
                Some(match self {
                    $(Self::$variant(_) => {
                        AnyReply::$variant(Answer { value: ReplyValue::from_value(value)?, value_type })
                    })*
                })
            }

            /// Type of the answer that firmware of a profile usually sends.
            #[must_use]
            pub const fn value_type(&self, profile: Profile) -> ValueType {
                match self {
                    $(Self::$variant(_) => Form::$form.of(profile),)*
                }
            }
        }

        /// Answer to any query.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum AnyReply<'a> {
            $(#[doc = concat!("To [`HostMessage::", stringify!($variant), "`].")]
            $variant(Answer<$answer>),)*
        }

        impl AnyReply<'_> {
            /// Type in front of the value.
            #[must_use]
            pub const fn value_type(&self) -> ValueType {
                match self {
                    $(Self::$variant(answer) => answer.value_type(),)*
                }
            }

            /// Whether the value is reliable; see [`Answer::is_reliable`].
            #[must_use]
            pub fn is_reliable(&self, profile: Profile) -> bool {
                match self {
                    $(Self::$variant(answer) => answer.is_reliable(profile),)*
                }
            }
        }

        impl AnyReply<'_> {
            /// Name of the query that the reply answers.
            #[must_use]
            pub const fn query_name(&self) -> &'static str {
                match self {
                    $(Self::$variant(_) => stringify!($variant),)*
                }
            }
        }

        /// Type and value, as those of the [`Answer`].
        impl Fields for AnyReply<'_> {
            fn fields(&self, visitor: &mut dyn Visitor) {
                match self {
                    $(Self::$variant(answer) => answer.fields(visitor),)*
                }
            }
        }

        impl fmt::Display for AnyReply<'_> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                match self {
                    $(Self::$variant(answer) => answer.fmt(f),)*
                }
            }
        }

        impl<'a> IntoReply<'a> for AnyReply<'a> {
            fn value(&self) -> Value<'a> {
                match self {
                    $(Self::$variant(answer) => answer.value(),)*
                }
            }
        }

        impl Query for AnyQuery {
            type Reply<'a> = AnyReply<'a>;

            fn decode_reply<'a>(&self, reply: Reply<'a>) -> Result<AnyReply<'a>, ReplyError> {
                match self {
                    $(Self::$variant(query) => query.decode_reply(reply).map(AnyReply::$variant),)*
                }
            }
        }

        impl HostMessage<'_> {
            /// The message as a query, if it is one.
            #[must_use]
            pub const fn query(&self) -> Option<AnyQuery> {
                match self {
                    $(Self::$variant(query) => Some(AnyQuery::$variant(*query)),)*
                    _ => None,
                }
            }
        }
    };
}
/// A map of the name of the query, the type and the raw value.
#[cfg(feature = "serde")]
impl motion_core::serde::Serialize for AnyReply<'_> {
    fn serialize<S: motion_core::serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use motion_core::serde::ser::SerializeMap;

        let mut map = serializer.serialize_map(Some(3))?;
        map.serialize_entry("query", self.query_name())?;
        motion_core::serialize::Map { fields: self, secrets: true }.entries(&mut map)?;
        map.end()
    }
}

queries! {
    FirmwareVersion(FirmwareVersion) => Version: Version;
    RunStatus(RunStatus) => RunState: Byte;
    RunTime(RunTime) => Milliseconds: ULong;
    Exposing(Exposing) => Bool: Byte;
    TimingMaster(TimingMaster) => Bool: Byte;
    Name(NameQuery) => Text<'a>: String;
    MaxStepRate(MaxStepRate) => StepRate: UInt;
    Voltage(Voltage) => Volts: Hundredths;
    Current(Current) => Amperes: Hundredths;
    InputEdge(InputEdge) => EdgeFound: Byte;
    AltModes(AltModes) => RingTip<AltMode>: Int;
    LimitSwitches(LimitSwitches) => RingTip<Level>: Int;
    OutBeforeDelay(OutBeforeDelay) => ShortMilliseconds: UInt;
    OutAfterDelay(OutAfterDelay) => ShortMilliseconds: UInt;
    OutBeforeTime(OutBeforeTime) => ShortMilliseconds: UInt;
    OutAfterTime(OutAfterTime) => ShortMilliseconds: UInt;
    OutLevel(OutLevel) => Level: Byte;
    StartDelay(StartDelayQuery) => StartDelay: ULong;
    ProgramMode(ProgramModeQuery) => ProgramMode: Byte;
    PowerCycled(PowerCycled) => Bool: Byte;
    JoystickMode(JoystickMode) => Bool: Byte;
    PingPong(PingPong) => Bool: Byte;

    MotorEnable(MotorEnable) => Bool: Byte;
    MotorBacklash(MotorBacklash) => Backlash: UInt;
    MotorMicrostep(MotorMicrostep) => Microstep: Byte;
    MotorDirection(MotorDirection) => Direction: Byte;
    MotorMaxStepSpeed(MotorMaxStepSpeed) => StepRate: SheetInt;
    MotorEndLimit(MotorEndLimit) => Steps: Long;
    MotorPosition(MotorPosition) => Steps: Long;
    MotorRunning(MotorRunning) => Bool: Promoted;
    MotorContinuousSpeed(MotorContinuousSpeed) => Speed: Hundredths;
    MotorContinuousAcceleration(MotorContinuousAcceleration) => Acceleration: Hundredths;
    MotorEasing(MotorEasing) => EasingFound: Byte;
    MotorProgramStart(MotorProgramStart) => Steps: Long;
    MotorProgramStop(MotorProgramStop) => Steps: Long;
    MotorTravel(MotorTravel) => Span: ULong;
    MotorLeadIn(MotorLeadIn) => Span: LeadIn;
    MotorProgramAcceleration(MotorProgramAcceleration) => Span: ULong;
    MotorProgramDeceleration(MotorProgramDeceleration) => Span: ULong;
    MotorMaxProgramSpeed(MotorMaxProgramSpeed) => SpeedOrSleep: SpeedOrSleep;

    CameraEnable(CameraEnable) => Bool: Byte;
    CameraExposing(CameraExposing) => Bool: Byte;
    CameraExposureTime(CameraExposureTime) => Milliseconds: ULong;
    CameraFocusTime(CameraFocusTime) => ShortMilliseconds: UInt;
    CameraMaxShots(CameraMaxShots) => Shots: MaxShots;
    CameraExposureDelay(CameraExposureDelay) => ShortMilliseconds: UInt;
    CameraFocusWithShutter(CameraFocusWithShutter) => Bool: Byte;
    CameraMirrorUp(CameraMirrorUp) => Bool: Wide;
    CameraInterval(CameraInterval) => Milliseconds: ULong;

    CoreProtocolVersion(CoreProtocolVersion) => CoreVersion: UInt;
    CoreDeviceId(CoreDeviceId) => Text<'a>: String;
    CoreDeviceVersion(CoreDeviceVersion) => CoreVersion: UInt;
}
