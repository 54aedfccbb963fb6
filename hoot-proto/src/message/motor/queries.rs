//! Queries of a motor: commands 100 to 117.

use super::Motor;
use crate::message::sub::sub_messages;

sub_messages! {
    /// Asks whether the motor is enabled. The answer is a [`Bool`](motion_core::wire::Bool). Source: hoot, section 2.3.
    pub struct MotorEnable for /** The motor. */ motor: Motor {}

    /// Asks how many steps are added when the motor reverses. The answer is in [`Backlash`](crate::message::Backlash).
    ///
    /// Source: hoot, section 2.3.
    pub struct MotorBacklash for /** The motor. */ motor: Motor {}

    /// Asks into how many microsteps a step is divided. The answer is a [`Microstep`](crate::message::Microstep).
    ///
    /// Source: hoot, section 2.3.
    pub struct MotorMicrostep for /** The motor. */ motor: Motor {}

    /// Asks which direction is forward. The answer is a [`Direction`](crate::message::Direction). Source: hoot, section
    /// 2.3.
    pub struct MotorDirection for /** The motor. */ motor: Motor {}

    /// Asks for the greatest speed of the motor. The answer is a [`StepRate`](crate::message::StepRate).
    ///
    /// The sheet calls it an Int, but it has no sign. Source: hoot, sections 2.3 and 3.
    pub struct MotorMaxStepSpeed for /** The motor. */ motor: Motor {}

    /// Asks for the position of the end limit. The answer is in [`Steps`](crate::message::Steps); 0 means no limit.
    /// Source: hoot, sections 2.3 and 4.3.
    pub struct MotorEndLimit for /** The motor. */ motor: Motor {}

    /// Asks for the position of the motor. The answer is in [`Steps`](crate::message::Steps). Source: hoot, section
    /// 2.3.
    pub struct MotorPosition for /** The motor. */ motor: Motor {}

    /// Asks whether the motor moves. The answer is a [`Bool`](motion_core::wire::Bool).
    ///
    /// An emergency stop repeats this query until the answer is no. The sheet's firmware sends a second packet after
    /// the reply, and some builds answer an `INT` instead of a `BYTE`. Source: hoot, section 2.3; safety decision 2.
    pub struct MotorRunning for /** The motor. */ motor: Motor {}

    /// Asks for the speed of continuous runs. The answer is a [`Speed`](crate::message::Speed), in hundredths.
    ///
    /// Source: hoot, sections 1.2 and 2.3.
    pub struct MotorContinuousSpeed for /** The motor. */ motor: Motor {}

    /// Asks for the acceleration of continuous runs. The answer is an [`Acceleration`](crate::message::Acceleration),
    /// in hundredths.
    ///
    /// Source: hoot, sections 1.2 and 2.3.
    pub struct MotorContinuousAcceleration for /** The motor. */ motor: Motor {}

    /// Asks for the easing of the planned move. The answer is an [`EasingFound`](crate::message::EasingFound).
    ///
    /// Source: hoot, section 2.3.
    pub struct MotorEasing for /** The motor. */ motor: Motor {}

    /// Asks for the position at which the planned move begins. The answer is in [`Steps`](crate::message::Steps).
    /// Source: hoot, section 2.3.
    pub struct MotorProgramStart for /** The motor. */ motor: Motor {}

    /// Asks for the position at which the planned move ends. The answer is in [`Steps`](crate::message::Steps). Source:
    /// hoot, section 2.3.
    pub struct MotorProgramStop for /** The motor. */ motor: Motor {}

    /// Asks for the duration of the planned move. The answer is a [`Span`](crate::message::Span). Source: hoot, section
    /// 2.3.
    pub struct MotorTravel for /** The motor. */ motor: Motor {}

    /// Asks for the lead-in: how long the motor waits before its planned move. The answer is a
    /// [`Span`](crate::message::Span).
    ///
    /// The answer has 16 bits, which the sheet calls an Int, and 32 bits since v0.35. Source: hoot, sections 2.3, 3 and
    /// 7.
    pub struct MotorLeadIn for /** The motor. */ motor: Motor {}

    /// Asks how long the planned move gains speed. The answer is a [`Span`](crate::message::Span). Source: hoot,
    /// section 2.3.
    pub struct MotorProgramAcceleration for /** The motor. */ motor: Motor {}

    /// Asks how long the planned move loses speed. The answer is a [`Span`](crate::message::Span). Source: hoot,
    /// section 2.3.
    pub struct MotorProgramDeceleration for /** The motor. */ motor: Motor {}

    /// Asks for the greatest speed of the planned move. The answer is a [`SpeedOrSleep`](crate::message::SpeedOrSleep).
    ///
    /// The sheet has this query, but firmware of its date refuses it. Firmware since 2014-12-03 answers whether the
    /// motor has no current while it rests. Source: hoot, sections 2.3 and 3.
    pub struct MotorMaxProgramSpeed for /** The motor. */ motor: Motor {}
}
