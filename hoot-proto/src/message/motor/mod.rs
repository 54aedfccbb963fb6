//! Commands to a motor: sub-addresses 1 to 3.
//!
//! Firmware acknowledges every command to a motor that is not enabled, and ignores it.

mod motion;
mod queries;

use core::fmt;
use core::str::FromStr;

use motion_core::parse::{ParseError, ParseProblem};
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

motion_core::__logged! {
    /// Motor of a node, which is also a sub-address.
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
}

impl Motor {
    /// All motors, in order.
    pub const ALL: [Self; 3] = [Self::One, Self::Two, Self::Three];

    /// Motor with this number, 1 to 3.
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        match number {
            1 => Some(Self::One),
            2 => Some(Self::Two),
            3 => Some(Self::Three),
            _ => None,
        }
    }

    /// Number of the motor, 1 to 3.
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

impl FromStr for Motor {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let at = match text.as_bytes() {
            b"1" => return Ok(Self::One),
            b"2" => return Ok(Self::Two),
            b"3" => return Ok(Self::Three),
            [b'1'..=b'3', ..] => 1,
            _ => 0,
        };
        Err(ParseError { what: "Motor", why: ParseProblem::Form { at, form: "1, 2 or 3" } })
    }
}

impl Sub for Motor {
    /// The tables contain only these three sub-addresses.
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
    /// Sets whether the motor has no current while it rests. In a new node it has none; from v0.23 on it has.
    ///
    /// Source: hoot, section 2.3.
    pub struct MotorSetSleep for /** The motor. */ motor: Motor {
        /// Whether the motor has no current.
        sleep: Bool,
    }

    /// Enables the motor, or disables it. Source: hoot, section 2.3.
    pub struct MotorSetEnable for /** The motor. */ motor: Motor {
        /// Whether the motor is enabled.
        enable: Bool,
    }

    /// Stops one motor, at once.
    ///
    /// The stop works in joystick mode too, and may be repeated. Source: hoot, section 2.3; safety decisions 1 and 2.
    pub struct MotorStop for /** The motor. */ motor: Motor {}

    /// Sets how many steps are added when the motor reverses. Source: hoot, section 2.3; safety decision 9.
    pub struct MotorSetBacklash for /** The motor. */ motor: Motor {
        /// Number of steps. The sheet has a stray byte after it.
        backlash: Backlash,
    }

    /// Sets into how many microsteps a step is divided. All stored positions are scaled by this setting.
    ///
    /// Source: hoot, section 2.3.
    pub struct MotorSetMicrostep for /** The motor. */ motor: Motor {
        /// Number of microsteps: 1, 2, 4, 8 or 16. The node acknowledges and ignores other numbers.
        microstep: Microstep,
    }

    /// Sets the greatest speed of the motor. Source: hoot, section 2.3.
    pub struct MotorSetMaxStepSpeed for /** The motor. */ motor: Motor {
        /// Speed. The node acknowledges and ignores 0, and speeds above its greatest step rate. The setting limits sends from
        /// v0.70 on, and nothing before (decision H-65).
        max_step_speed: StepRate,
    }

    /// Sets which direction is forward. The sheet says that it flips the direction, whatever the program does. Firmware keeps
    /// the setting and flips nothing (decision H-65). Source: hoot, section 2.3.
    pub struct MotorSetDirection for /** The motor. */ motor: Motor {
        /// Direction, 0 or 1.
        direction: Direction,
    }

    /// Makes the present position the home: it becomes 0, and all stored positions are shifted by its old value.
    ///
    /// Source: hoot, section 2.3.
    pub struct MotorSetHomeHere for /** The motor. */ motor: Motor {}

    /// Makes the present position the end limit.
    ///
    /// From v0.49 on, firmware keeps the limit and does not stop there
    /// ([`Profile::holds_limits`](crate::query::Profile::holds_limits)). Earlier, the home becomes a limit too. Source: hoot,
    /// section 2.3; decision H-44.
    pub struct MotorSetEndHere for /** The motor. */ motor: Motor {}

    /// Sends the motor home. Never repeat it by yourself.
    ///
    /// Firmware since 2014-11-03 goes at up to 5000 steps per second, whatever speed was set, and forgets that speed
    /// ([`Profile::sends_at_full_speed`](crate::query::Profile::sends_at_full_speed)). A [`MotorMove`] keeps the speed.
    /// Source: hoot, section 2.3; safety decision 1; decision H-42.
    pub struct MotorSendHome for /** The motor. */ motor: Motor {}

    /// Sends the motor to the end limit. Without an end limit, the node acknowledges the command and ignores it.
    ///
    /// Never repeat it by yourself. Its speed is that of [`MotorSendHome`]. Source: hoot, section 2.3; safety decision 1;
    /// decision H-42.
    pub struct MotorSendToEnd for /** The motor. */ motor: Motor {}

    /// Sets the speed of continuous runs, also of a run that is under way.
    ///
    /// The speed is an IEEE number, although replies contain speeds in hundredths. Moves by a number of steps need a
    /// speed other than 0 too, although the sheet says that it does not apply to them. Commands that send the motor to a
    /// position ignore it since 2014-11-03. In joystick mode it sets the motor in motion. Never repeat it by yourself.
    /// Source: hoot, sections 1.2 and 2.3; safety decisions 1 and 8; decision H-42.
    pub struct MotorSetContinuousSpeed for /** The motor. */ motor: Motor {
        /// Speed; its sign is the direction. The node acknowledges and ignores speeds above its greatest step rate.
        speed: StepsPerSecond,
    }

    /// Sets the acceleration of continuous runs, also an IEEE number.
    ///
    /// Source: hoot, sections 1.2 and 2.3; safety decision 8.
    pub struct MotorSetContinuousAcceleration for /** The motor. */ motor: Motor {
        /// Acceleration.
        acceleration: StepsPerSecondSquared,
    }

    /// Sets the position at which the planned move begins. Source: hoot, section 2.3.
    pub struct MotorSetProgramStart for /** The motor. */ motor: Motor {
        /// Position.
        position: Steps,
    }

    /// Sets the position at which the planned move ends. Source: hoot, section 2.3.
    pub struct MotorSetProgramStop for /** The motor. */ motor: Motor {
        /// Position.
        position: Steps,
    }

    /// Sets the easing of the planned move. An unknown easing is answered twice: an error, then OK. Source: hoot,
    /// section 2.3.
    pub struct MotorSetEasing for /** The motor. */ motor: Motor {
        /// Easing.
        easing: Easing,
    }

    /// Sets how long the motor waits before its planned move, in 16 bits, for firmware before v0.35.
    ///
    /// Later firmware reads 32 bits ([`MotorSetLeadInLong`]), and reads the missing bits as zeros. Source: hoot,
    /// sections 2.3 and 7.
    pub struct MotorSetLeadIn for /** The motor. */ motor: Motor {
        /// Time.
        lead_in: ShortSpan,
    }

    /// Sets how long the motor waits before its planned move, in 32 bits, for v0.35 and later.
    ///
    /// Earlier firmware reads only the first 16 bits. Source: hoot, section 7; safety decision 3.
    pub struct MotorSetLeadInLong for /** The motor. */ motor: Motor {
        /// Time; at most 16,777,215 arrives.
        lead_in: Span,
    }

    /// Sets the duration of the planned move. Source: hoot, section 2.3; safety decision 3.
    pub struct MotorSetTravel for /** The motor. */ motor: Motor {
        /// Time; at most 16,777,215 arrives.
        travel: Span,
    }

    /// Sets how long the planned move gains speed. Source: hoot, section 2.3; safety decision 3.
    pub struct MotorSetProgramAcceleration for /** The motor. */ motor: Motor {
        /// Time; at most 16,777,215 arrives.
        acceleration: Span,
    }

    /// Sets how long the planned move loses speed. Source: hoot, section 2.3; safety decision 3.
    pub struct MotorSetProgramDeceleration for /** The motor. */ motor: Motor {
        /// Time; at most 16,777,215 arrives.
        deceleration: Span,
    }

    /// Sends the motor to the start of the planned move. Never repeat it by yourself.
    ///
    /// Its speed is that of [`MotorSendHome`]: later firmware ignores the speed that was set. Source: hoot, section 2.3;
    /// safety decision 1; decision H-42.
    pub struct MotorSendToStart for /** The motor. */ motor: Motor {}

    /// Sends the motor to the end of the planned move. Never repeat it by yourself.
    ///
    /// Its speed is that of [`MotorSendHome`]: later firmware ignores the speed that was set. Source: hoot, section 2.3;
    /// safety decision 1; decision H-42.
    pub struct MotorSendToStop for /** The motor. */ motor: Motor {}

    /// Moves the motor on by one step of the planned move, from one picture to the next.
    ///
    /// The sheet says that it is not implemented, but firmware of its date has it, and refuses it without a plan. Since
    /// 2015-02 the number means another command, with data. Never repeat it by yourself. Source: hoot, sections 2.3 and
    /// 7; safety decision 1.
    pub struct MotorStepForward for /** The motor. */ motor: Motor {}

    /// Moves the motor back by one step of the planned move, from one picture to the next.
    ///
    /// The counterpart of [`MotorStepForward`]. Later firmware does not have this command. Never repeat it by yourself.
    /// Source: hoot, sections 2.3 and 7; safety decision 1.
    pub struct MotorStepBack for /** The motor. */ motor: Motor {}

    /// Forgets the limits: the present position becomes the home, and the start and end of the planned move.
    ///
    /// Lint warns of it, because from then on nothing stops the motor at the end of the rail. Source: hoot, section
    /// 2.3; safety decision 9.
    pub struct MotorResetLimits for /** The motor. */ motor: Motor {}
}

/// Conduct by the speed: every speed except 0 may set the motor in motion.
///
/// In joystick mode this command starts a motor, and the message does not tell the mode. A speed of 0 moves nothing,
/// but it is not a stop, because some firmware does not answer it.
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
