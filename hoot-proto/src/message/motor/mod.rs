//! The motors: sub-addresses 1 to 3.
//!
//! Firmware acknowledges every command to a motor that is not enabled, and does nothing.

mod motion;
mod queries;

use core::fmt;

use motion_core::wire::{Bool, Conduct, FieldView, Purpose, Value, Visitor};

pub use motion::{MotorMove, MotorRun};
pub use queries::{
    MotorBacklash, MotorContinuousAcceleration, MotorContinuousSpeed, MotorDirection, MotorEasing, MotorEnable,
    MotorEndLimit, MotorLeadIn, MotorMaxProgramSpeed, MotorMaxStepSpeed, MotorMicrostep, MotorPosition,
    MotorProgramAcceleration, MotorProgramDeceleration, MotorProgramStart, MotorProgramStop, MotorRunning, MotorTravel,
};

use super::bounded::bounded;
use super::sub::{Sub, sub_messages};
use super::units::{
    Backlash, Direction, Easing, Microstep, ShortSpan, Span, StepCount, StepRate, Steps, StepsPerSecond,
    StepsPerSecondSquared,
};

/// One of the three motors of a node, which is also a sub-address.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Motor {
    /// Motor 1.
    #[default]
    One = 1,
    /// Motor 2.
    Two = 2,
    /// Motor 3.
    Three = 3,
}

impl Motor {
    /// All of them, in order.
    pub const ALL: [Self; 3] = [Self::One, Self::Two, Self::Three];

    /// The motor of this number, 1 to 3.
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        match number {
            1 => Some(Self::One),
            2 => Some(Self::Two),
            3 => Some(Self::Three),
            _ => None,
        }
    }

    /// Its number, 1 to 3.
    #[must_use]
    pub const fn get(self) -> u8 {
        self as u8
    }
}

impl fmt::Display for Motor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.get().fmt(f)
    }
}

impl Sub for Motor {
    /// The tables hold no other sub-address than these three.
    fn of(number: u32) -> Self {
        let [sub_address, ..] = number.to_le_bytes();
        Self::new(sub_address).unwrap_or_default()
    }

    fn byte(self) -> u8 {
        self.get()
    }

    fn show(self, visitor: &mut dyn Visitor) {
        visitor.visit(&FieldView { name: "motor", unit: "", value: Value::Unsigned(self.get().into()), text: &self });
    }
}

sub_messages! {
    /// Set whether the motor has no current while it rests.
    ///
    /// Source: hoot, section 2.3.
    pub struct MotorSetSleep for /** Which motor. */ motor: Motor {
        /// Whether it has none.
        sleep: Bool,
    }

    /// Set whether the motor moves at all. Source: hoot, section 2.3.
    pub struct MotorSetEnable for /** Which motor. */ motor: Motor {
        /// Whether it does.
        enable: Bool,
    }

    /// Stop one motor, at once.
    ///
    /// It works in joystick mode too, and may be sent again by itself. Source: hoot, section 2.3; safety decisions 1
    /// and 2.
    pub struct MotorStop for /** Which motor. */ motor: Motor {}

    /// Set how many steps are added when the motor turns the other way. Source: hoot, section 2.3; safety decision 9.
    pub struct MotorSetBacklash for /** Which motor. */ motor: Motor {
        /// How many. The sheet has a stray byte behind them.
        backlash: Backlash,
    }

    /// Set into how many microsteps a step is divided. All stored positions are scaled by it.
    ///
    /// Source: hoot, section 2.3.
    pub struct MotorSetMicrostep for /** Which motor. */ motor: Motor {
        /// How many: 1, 2, 4, 8 or 16. The node acknowledges and ignores others.
        microstep: Microstep,
    }

    /// Set the greatest speed of the motor. Source: hoot, section 2.3.
    pub struct MotorSetMaxStepSpeed for /** Which motor. */ motor: Motor {
        /// How fast. The node acknowledges and ignores 0, and what is beyond its greatest step rate.
        max_step_speed: StepRate,
    }

    /// Set which way is forward. Source: hoot, section 2.3.
    pub struct MotorSetDirection for /** Which motor. */ motor: Motor {
        /// Which way, 0 or 1.
        direction: Direction,
    }

    /// Here is home: the position becomes 0, and all stored positions are moved by what it was.
    ///
    /// Source: hoot, section 2.3.
    pub struct MotorSetHomeHere for /** Which motor. */ motor: Motor {}

    /// Here is the end limit. Source: hoot, section 2.3.
    pub struct MotorSetEndHere for /** Which motor. */ motor: Motor {}

    /// Go home. Not to be sent again by itself. Source: hoot, section 2.3; safety decision 1.
    pub struct MotorSendHome for /** Which motor. */ motor: Motor {}

    /// Go to the end limit. The node acknowledges it and stays, if there is none.
    ///
    /// Not to be sent again by itself. Source: hoot, section 2.3; safety decision 1.
    pub struct MotorSendToEnd for /** Which motor. */ motor: Motor {}

    /// Set the speed of continuous runs; it changes the speed of a run under way.
    ///
    /// An IEEE number, although replies say speeds in hundredths. A move of a number of steps needs a speed other than
    /// 0 as well, though the sheet says that it does not apply. Not to be sent again by itself. Source: hoot, sections
    /// 1.2 and 2.3; safety decisions 1 and 8.
    pub struct MotorSetContinuousSpeed for /** Which motor. */ motor: Motor {
        /// How fast, and which way. The node acknowledges and ignores what is beyond its greatest step rate.
        speed: StepsPerSecond,
    }

    /// Set how quickly continuous runs gain and lose speed. An IEEE number as well.
    ///
    /// Source: hoot, sections 1.2 and 2.3; safety decision 8.
    pub struct MotorSetContinuousAcceleration for /** Which motor. */ motor: Motor {
        /// How quickly.
        acceleration: StepsPerSecondSquared,
    }

    /// Set where the planned move begins. Source: hoot, section 2.3.
    pub struct MotorSetProgramStart for /** Which motor. */ motor: Motor {
        /// Where.
        position: Steps,
    }

    /// Set where the planned move ends. Source: hoot, section 2.3.
    pub struct MotorSetProgramStop for /** Which motor. */ motor: Motor {
        /// Where.
        position: Steps,
    }

    /// Set how the planned move gains and loses speed. Of what is none, the node says an error and then OK, in two
    /// packets. Source: hoot, section 2.3.
    pub struct MotorSetEasing for /** Which motor. */ motor: Motor {
        /// How.
        easing: Easing,
    }

    /// Set how long the motor waits before its planned move, in 16 bits, as firmware before v0.35 takes it.
    ///
    /// Later firmware reads 32 bits, [`MotorSetLeadInLong`], and takes the missing ones for zeros. Source: hoot, sections
    /// 2.3 and 7.
    pub struct MotorSetLeadIn for /** Which motor. */ motor: Motor {
        /// How long.
        lead_in: ShortSpan,
    }

    /// Set how long the motor waits before its planned move, in 32 bits, as v0.35 and later takes it.
    ///
    /// Firmware before reads the first 16 bits of it. Source: hoot, section 7; safety decision 3.
    pub struct MotorSetLeadInLong for /** Which motor. */ motor: Motor {
        /// How long; no more than 16,777,215 arrives.
        lead_in: Span,
    }

    /// Set how long the planned move takes. Source: hoot, section 2.3; safety decision 3.
    pub struct MotorSetTravel for /** Which motor. */ motor: Motor {
        /// How long; no more than 16,777,215 arrives.
        travel: Span,
    }

    /// Set how long the planned move gains speed. Source: hoot, section 2.3; safety decision 3.
    pub struct MotorSetProgramAcceleration for /** Which motor. */ motor: Motor {
        /// How long; no more than 16,777,215 arrives.
        acceleration: Span,
    }

    /// Set how long the planned move loses speed. Source: hoot, section 2.3; safety decision 3.
    pub struct MotorSetProgramDeceleration for /** Which motor. */ motor: Motor {
        /// How long; no more than 16,777,215 arrives.
        deceleration: Span,
    }

    /// Go to where the planned move begins. Not to be sent again by itself. Source: hoot, section 2.3; safety
    /// decision 1.
    pub struct MotorSendToStart for /** Which motor. */ motor: Motor {}

    /// Go to where the planned move ends. Not to be sent again by itself. Source: hoot, section 2.3; safety decision
    /// 1.
    pub struct MotorSendToStop for /** Which motor. */ motor: Motor {}

    /// Go on by what the planned move goes from one picture to the next.
    ///
    /// The sheet says that it is not implemented; its firmware has it, and refuses it without a plan. Since 2015-02 the
    /// number means another command, with data. Not to be sent again by itself. Source: hoot, sections 2.3 and 7; safety
    /// decision 1.
    pub struct MotorStepForward for /** Which motor. */ motor: Motor {}

    /// Go back by what the planned move goes from one picture to the next.
    ///
    /// As [`MotorStepForward`]; later firmware has no such command. Not to be sent again by itself. Source: hoot,
    /// sections 2.3 and 7; safety decision 1.
    pub struct MotorStepBack for /** Which motor. */ motor: Motor {}

    /// Forget the limits: here is home, and the planned move begins and ends here.
    ///
    /// Lint warns of it: from then on nothing stops the motor at the end of the rail. Source: hoot, section 2.3; safety
    /// decision 9.
    pub struct MotorResetLimits for /** Which motor. */ motor: Motor {}
}

/// Conduct by the speed: every speed except 0 may set the motor in motion.
///
/// In joystick mode this command starts a motor; the message does not tell the mode. A speed of 0 moves nothing, but it is
/// no stop either: some firmware does not answer it.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "tables call it with a reference")]
pub(super) const fn continuous_speed(set: &MotorSetContinuousSpeed) -> Conduct {
    Conduct::new(if set.speed.0 == 0.0 { Purpose::Sets } else { Purpose::Moves }).once()
}

bounded! {
    MotorSetLeadInLong { motor: Motor } (lead_in: Span);
    MotorSetTravel { motor: Motor } (travel: Span);
    MotorSetProgramAcceleration { motor: Motor } (acceleration: Span);
    MotorSetProgramDeceleration { motor: Motor } (deceleration: Span);
}
