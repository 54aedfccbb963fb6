//! The motors: sub-addresses 1 to 3.

use core::fmt;

use motion_core::unit;
use motion_core::wire::{DecodeError, EncodeError, FieldView, Fields, Message, Row, Value, Visitor};

use super::sub::{Sub, sub_messages};

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
        let [.., sub_address] = number.to_be_bytes();
        Self::new(sub_address).unwrap_or_default()
    }

    fn byte(self) -> u8 {
        self.get()
    }

    fn show(self, visitor: &mut dyn Visitor) {
        visitor.visit(&FieldView { name: "motor", unit: "", value: Value::Unsigned(self.get().into()), text: &self });
    }
}

unit! {
    /// A position, in steps of the present microstep setting.
    pub struct Steps(i32) "steps";
    /// How far to move, in steps of the present microstep setting.
    pub struct StepCount(u32) "steps";
    /// A speed; its sign is the direction.
    pub struct StepsPerSecond(f32) "steps/s";
    /// Which way a motor turns, 0 or 1. What that is on the rig depends on the wiring and on the motor's own setting.
    pub struct Direction(u8) "";
}

impl StepCount {
    /// The most that arrives: firmware drops the top byte of what it is sent (hoot, section 1.2).
    pub const MAX: Self = Self(0x00FF_FFFF);
}

sub_messages! {
    /// Stop one motor, at once.
    ///
    /// It works in joystick mode too, and may be sent again by itself. Source: hoot, section 2.3; safety decisions 1
    /// and 2.
    pub struct MotorStop for /** Which motor. */ motor: Motor {}

    /// Set the speed of continuous runs; it changes the speed of a run under way.
    ///
    /// An IEEE number, although replies say speeds in hundredths. A move of a number of steps needs a speed other than
    /// 0 as well, though the sheet says that it does not apply. Source: hoot, sections 1.2 and 2.3; safety decision 8.
    pub struct MotorSetContinuousSpeed for /** Which motor. */ motor: Motor {
        /// How fast, and which way. The node acknowledges and ignores what is beyond its greatest step rate.
        speed: StepsPerSecond,
    }

    /// Where is the motor? Asks for [`Steps`]. Source: hoot, section 2.3.
    pub struct MotorPosition for /** Which motor. */ motor: Motor {}

    /// Does the motor move? Asks for a [`Bool`](motion_core::wire::Bool).
    ///
    /// What an emergency stop has to ask until it is no. The sheet's firmware sends a second packet behind the reply, and
    /// some builds say `INT` instead of `BYTE`. Source: hoot, section 2.3; safety decision 2.
    pub struct MotorRunning for /** Which motor. */ motor: Motor {}

    /// The data of command 15: a move, or, without steps, a run.
    struct MotorMoveOrRun for /** Which motor. */ motor: Motor {
        /// Which way.
        direction: Direction,
        /// How far; 0 is for ever.
        steps: StepCount,
    }
}

/// Move by a number of steps. Not to be sent again by itself: it would move again.
///
/// It needs neither a start nor a stop. Without steps it is another message, [`MotorRun`]: such data reads as a move
/// that lacks its steps, and is refused when it is to be written. Source: hoot, section 2.3; safety decisions 1 and 3.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct MotorMove {
    /// Which motor.
    pub motor: Motor,
    /// Which way.
    pub direction: Direction,
    /// How far, 1 to 16,777,215. With more, lint finds an error: of 16,777,216 the firmware sees 0, and runs for ever.
    pub steps: StepCount,
}

impl MotorMove {
    /// Move by a number of steps; `None` unless they are 1 to 16,777,215.
    #[must_use]
    pub fn new(motor: Motor, direction: Direction, steps: StepCount) -> Option<Self> {
        if steps.0 == 0 || steps > StepCount::MAX { None } else { Some(Self { motor, direction, steps }) }
    }

    const fn data(self) -> MotorMoveOrRun {
        MotorMoveOrRun { motor: self.motor, direction: self.direction, steps: self.steps }
    }
}

impl<'a> Message<'a> for MotorMove {
    const LAYOUT: &'static [Row] = MotorMoveOrRun::LAYOUT;

    fn decode(body: &'a [u8]) -> Result<Self, DecodeError> {
        Self::decode_as(MotorMoveOrRun::default().number(0), body)
    }

    #[inline]
    fn decode_as(number: u32, body: &'a [u8]) -> Result<Self, DecodeError> {
        let MotorMoveOrRun { motor, direction, steps } = MotorMoveOrRun::decode_as(number, body)?;
        if steps.0 == 0 {
            return Err(DecodeError::Truncated { what: "MotorMove.steps", needed: 5, have: 1 });
        }
        Ok(Self { motor, direction, steps })
    }

    #[inline]
    fn number(&self, declared: u32) -> u32 {
        self.data().number(declared)
    }

    #[inline]
    fn encoded_len(&self) -> usize {
        self.data().encoded_len()
    }

    #[inline]
    fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        if self.steps.0 == 0 {
            let max = u32::MAX.into();
            return Err(EncodeError::OutOfRange { what: "MotorMove.steps", value: 0, min: 1, max });
        }
        self.data().encode_into(out)
    }
}

impl Fields for MotorMove {
    fn fields(&self, visitor: &mut dyn Visitor) {
        self.data().fields(visitor);
    }
}

motion_core::__message_features! { 'a [MotorMove] MotorMove }

/// Run until told otherwise, at the speed of [`MotorSetContinuousSpeed`]. Nothing moves at speed 0.
///
/// On the wire it is a move of 0 steps. Source: hoot, section 2.3; safety decision 3.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct MotorRun {
    /// Which motor.
    pub motor: Motor,
    /// Which way.
    pub direction: Direction,
}

impl MotorRun {
    const fn data(self) -> MotorMoveOrRun {
        MotorMoveOrRun { motor: self.motor, direction: self.direction, steps: StepCount(0) }
    }
}

impl<'a> Message<'a> for MotorRun {
    const LAYOUT: &'static [Row] = MotorMoveOrRun::LAYOUT;

    fn decode(body: &'a [u8]) -> Result<Self, DecodeError> {
        Self::decode_as(MotorMoveOrRun::default().number(0), body)
    }

    #[inline]
    fn decode_as(number: u32, body: &'a [u8]) -> Result<Self, DecodeError> {
        let MotorMoveOrRun { motor, direction, steps } = MotorMoveOrRun::decode_as(number, body)?;
        if steps.0 != 0 {
            return Err(DecodeError::Trailing { what: "MotorRun", extra: size_of_val(&steps) });
        }
        Ok(Self { motor, direction })
    }

    #[inline]
    fn number(&self, declared: u32) -> u32 {
        self.data().number(declared)
    }

    #[inline]
    fn encoded_len(&self) -> usize {
        self.data().encoded_len()
    }

    #[inline]
    fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        self.data().encode_into(out)
    }
}

impl Fields for MotorRun {
    fn fields(&self, visitor: &mut dyn Visitor) {
        self.data().fields(visitor);
    }
}

motion_core::__message_features! { 'a [MotorRun] MotorRun }
