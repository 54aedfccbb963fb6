//! What the controller itself can be asked: sub-address 0, commands 100 to 121.
//!
//! The decimal numbers of the sheet are right; its hexadecimal ones of 109 to 111 are not.

use motion_core::message;

message! {
    /// Which firmware do you have? Asks for a [`Version`](crate::message::Version).
    ///
    /// A byte, and since 2015-01-08 32 bits: [`Profile::of_version`](crate::query::Profile::of_version) makes use of
    /// both. Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct FirmwareVersion in BE {}

    /// Does the planned move run? Asks for a [`RunState`](crate::message::RunState). Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct RunStatus in BE {}

    /// How long has the planned move run? Asks for [`Milliseconds`](crate::message::Milliseconds).
    ///
    /// Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct RunTime in BE {}

    /// Is a picture being taken? Asks for a [`Bool`](motion_core::wire::Bool). Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct Exposing in BE {}

    /// Are you the timing master? Asks for a [`Bool`](motion_core::wire::Bool). Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct TimingMaster in BE {}

    /// What is the node called? Asks for a [`Text`](crate::message::Text), mostly of ten bytes.
    ///
    /// Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct NameQuery in BE {}

    /// What is the greatest step rate? Asks for a [`StepRate`](crate::message::StepRate). v0.70 is silent.
    ///
    /// Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct MaxStepRate in BE {}

    /// What is the supply voltage? Asks for [`Volts`](crate::message::Volts). Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct Voltage in BE {}

    /// What is the supply current? Asks for [`Amperes`](crate::message::Amperes). Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct Current in BE {}

    /// Which edge of the auxiliary input counts? Asks for an [`EdgeFound`](crate::message::EdgeFound).
    ///
    /// Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct InputEdge in BE {}

    /// What are the contacts of the auxiliary connector for? Asks for [`RingTip`](crate::message::RingTip).
    ///
    /// Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct AltModes in BE {}

    /// Which levels have the limit switches? Asks for [`RingTip`](crate::message::RingTip). Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct LimitSwitches in BE {}

    /// Asks for what [`SetOutBeforeDelay`](crate::message::SetOutBeforeDelay) sets. Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct OutBeforeDelay in BE {}

    /// Asks for what [`SetOutAfterDelay`](crate::message::SetOutAfterDelay) sets. Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct OutAfterDelay in BE {}

    /// Asks for what [`SetOutBeforeTime`](crate::message::SetOutBeforeTime) sets. Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct OutBeforeTime in BE {}

    /// Asks for what [`SetOutAfterTime`](crate::message::SetOutAfterTime) sets. Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct OutAfterTime in BE {}

    /// At which level is the auxiliary output on? Asks for a [`Level`](crate::message::Level).
    ///
    /// Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct OutLevel in BE {}

    /// How long does the planned move wait? Asks for a [`StartDelay`](crate::message::StartDelay).
    ///
    /// Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct StartDelayQuery in BE {}

    /// What kind of program is the planned move? Asks for a [`ProgramMode`](crate::message::ProgramMode).
    ///
    /// Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct ProgramModeQuery in BE {}

    /// Has the power been off since this was asked last? Asks for a [`Bool`](motion_core::wire::Bool).
    ///
    /// The answer clears it, so it is the one query that is not to be sent again by itself. Source: hoot, section 2.2;
    /// safety decision 1.
    #[derive(Default)]
    pub struct PowerCycled in BE {}

    /// Is joystick mode on? Asks for a [`Bool`](motion_core::wire::Bool). Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct JoystickMode in BE {}

    /// Does the planned move go to and fro? Asks for a [`Bool`](motion_core::wire::Bool).
    ///
    /// The sheet has it, its firmware has not, and refuses; firmware since 2014-11-03 answers. Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct PingPong in BE {}
}
