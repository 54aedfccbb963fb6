//! Queries of the controller of a node: sub-address 0, commands 100 to 121.
//!
//! The decimal numbers of the sheet are right. Its hexadecimal numbers of 109 to 111 are wrong.

use motion_core::message;

message! {
    /// Asks for the version of the firmware. The answer is a [`Version`](crate::message::Version).
    ///
    /// The answer is a byte, or 32 bits since 2015-01-08. [`Profile::of_version`](crate::query::Profile::of_version)
    /// uses both. Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct FirmwareVersion in BE {}

    /// Asks whether the planned move runs. The answer is a [`RunState`](crate::message::RunState). Source: hoot,
    /// section 2.2.
    #[derive(Default)]
    pub struct RunStatus in BE {}

    /// Asks how long the planned move has run. The answer is in [`Milliseconds`](crate::message::Milliseconds).
    ///
    /// Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct RunTime in BE {}

    /// Asks whether a picture is being taken. The answer is a [`Bool`](motion_core::wire::Bool). Source: hoot, section
    /// 2.2.
    #[derive(Default)]
    pub struct Exposing in BE {}

    /// Asks whether the node is the timing master. The answer is a [`Bool`](motion_core::wire::Bool). Source: hoot,
    /// section 2.2.
    #[derive(Default)]
    pub struct TimingMaster in BE {}

    /// Asks for the name of the node. The answer is a [`Text`](crate::message::Text), usually of ten bytes.
    ///
    /// Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct NameQuery in BE {}

    /// Asks for the greatest step rate. The answer is a [`StepRate`](crate::message::StepRate). v0.70 does not answer
    /// it.
    ///
    /// Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct MaxStepRate in BE {}

    /// Asks for the supply voltage. The answer is in [`Volts`](crate::message::Volts). Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct Voltage in BE {}

    /// Asks for the supply current. The answer is in [`Amperes`](crate::message::Amperes). Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct Current in BE {}

    /// Asks which edge of the auxiliary input counts. The answer is an [`EdgeFound`](crate::message::EdgeFound).
    ///
    /// Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct InputEdge in BE {}

    /// Asks for the purposes of the contacts of the auxiliary connector. The answer is a
    /// [`RingTip`](crate::message::RingTip).
    ///
    /// Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct AltModes in BE {}

    /// Asks for the levels of the limit switches. The answer is a [`RingTip`](crate::message::RingTip). Source: hoot,
    /// section 2.2.
    #[derive(Default)]
    pub struct LimitSwitches in BE {}

    /// Asks for the setting of [`SetOutBeforeDelay`](crate::message::SetOutBeforeDelay). Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct OutBeforeDelay in BE {}

    /// Asks for the setting of [`SetOutAfterDelay`](crate::message::SetOutAfterDelay). Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct OutAfterDelay in BE {}

    /// Asks for the setting of [`SetOutBeforeTime`](crate::message::SetOutBeforeTime). Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct OutBeforeTime in BE {}

    /// Asks for the setting of [`SetOutAfterTime`](crate::message::SetOutAfterTime). Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct OutAfterTime in BE {}

    /// Asks for the level at which the auxiliary output is on. The answer is a [`Level`](crate::message::Level).
    ///
    /// Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct OutLevel in BE {}

    /// Asks for the delay before the planned move starts. The answer is a [`StartDelay`](crate::message::StartDelay).
    ///
    /// Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct StartDelayQuery in BE {}

    /// Asks for the mode of the planned move. The answer is a [`ProgramMode`](crate::message::ProgramMode).
    ///
    /// Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct ProgramModeQuery in BE {}

    /// Asks whether the power was off since the last such query. The answer is a [`Bool`](motion_core::wire::Bool).
    ///
    /// The answer clears the flag, so this is the only query that must never be repeated by yourself. Source: hoot,
    /// section 2.2; safety decision 1.
    #[derive(Default)]
    pub struct PowerCycled in BE {}

    /// Asks whether joystick mode is on. The answer is a [`Bool`](motion_core::wire::Bool). Source: hoot, section 2.2.
    #[derive(Default)]
    pub struct JoystickMode in BE {}

    /// Asks whether the planned move goes to and fro. The answer is a [`Bool`](motion_core::wire::Bool).
    ///
    /// The sheet has this query, but firmware of its date refuses it. Firmware since 2014-11-03 answers it. Source:
    /// hoot, section 2.2.
    #[derive(Default)]
    pub struct PingPong in BE {}
}
