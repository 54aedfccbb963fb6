//! What a motor can be asked: commands 100 to 117.

use super::Motor;
use crate::message::sub::sub_messages;

sub_messages! {
    /// Does the motor move at all? Asks for a [`Bool`](motion_core::wire::Bool). Source: hoot, section 2.3.
    pub struct MotorEnable for /** Which motor. */ motor: Motor {}

    /// How many steps are added when it turns the other way? Asks for [`Backlash`](crate::message::Backlash).
    ///
    /// Source: hoot, section 2.3.
    pub struct MotorBacklash for /** Which motor. */ motor: Motor {}

    /// Into how many microsteps is a step divided? Asks for a [`Microstep`](crate::message::Microstep).
    ///
    /// Source: hoot, section 2.3.
    pub struct MotorMicrostep for /** Which motor. */ motor: Motor {}

    /// Which way is forward? Asks for a [`Direction`](crate::message::Direction). Source: hoot, section 2.3.
    pub struct MotorDirection for /** Which motor. */ motor: Motor {}

    /// What is the greatest speed of the motor? Asks for a [`StepRate`](crate::message::StepRate).
    ///
    /// The sheet calls it an Int; it has no sign. Source: hoot, sections 2.3 and 3.
    pub struct MotorMaxStepSpeed for /** Which motor. */ motor: Motor {}

    /// Where is the end limit? Asks for [`Steps`](crate::message::Steps); 0 is none. Source: hoot, sections 2.3 and 4.3.
    pub struct MotorEndLimit for /** Which motor. */ motor: Motor {}

    /// Where is the motor? Asks for [`Steps`](crate::message::Steps). Source: hoot, section 2.3.
    pub struct MotorPosition for /** Which motor. */ motor: Motor {}

    /// Does the motor move? Asks for a [`Bool`](motion_core::wire::Bool).
    ///
    /// What an emergency stop has to ask until it is no. The sheet's firmware sends a second packet behind the reply, and
    /// some builds say `INT` instead of `BYTE`. Source: hoot, section 2.3; safety decision 2.
    pub struct MotorRunning for /** Which motor. */ motor: Motor {}

    /// What is the speed of continuous runs? Asks for a [`Speed`](crate::message::Speed), in hundredths.
    ///
    /// Source: hoot, sections 1.2 and 2.3.
    pub struct MotorContinuousSpeed for /** Which motor. */ motor: Motor {}

    /// How quickly do continuous runs gain speed? Asks for an [`Acceleration`](crate::message::Acceleration), in hundredths.
    ///
    /// Source: hoot, sections 1.2 and 2.3.
    pub struct MotorContinuousAcceleration for /** Which motor. */ motor: Motor {}

    /// How does the planned move gain and lose speed? Asks for an [`Easing`](crate::message::Easing).
    ///
    /// Source: hoot, section 2.3.
    pub struct MotorEasing for /** Which motor. */ motor: Motor {}

    /// Where does the planned move begin? Asks for [`Steps`](crate::message::Steps). Source: hoot, section 2.3.
    pub struct MotorProgramStart for /** Which motor. */ motor: Motor {}

    /// Where does the planned move end? Asks for [`Steps`](crate::message::Steps). Source: hoot, section 2.3.
    pub struct MotorProgramStop for /** Which motor. */ motor: Motor {}

    /// How long does the planned move take? Asks for a [`Span`](crate::message::Span). Source: hoot, section 2.3.
    pub struct MotorTravel for /** Which motor. */ motor: Motor {}

    /// How long does the motor wait before its planned move? Asks for a [`Span`](crate::message::Span).
    ///
    /// In 16 bits, which the sheet calls an Int, and since v0.35 in 32. Source: hoot, sections 2.3, 3 and 7.
    pub struct MotorLeadIn for /** Which motor. */ motor: Motor {}

    /// How long does the planned move gain speed? Asks for a [`Span`](crate::message::Span). Source: hoot, section 2.3.
    pub struct MotorProgramAcceleration for /** Which motor. */ motor: Motor {}

    /// How long does the planned move lose speed? Asks for a [`Span`](crate::message::Span). Source: hoot, section 2.3.
    pub struct MotorProgramDeceleration for /** Which motor. */ motor: Motor {}

    /// What is the greatest speed of the planned move? Asks for a [`SpeedOrSleep`](crate::message::SpeedOrSleep).
    ///
    /// The sheet has it, its firmware has not, and refuses; firmware since 2014-12-03 tells by this number whether the
    /// motor sleeps. Source: hoot, sections 2.3 and 3.
    pub struct MotorMaxProgramSpeed for /** Which motor. */ motor: Motor {}
}
