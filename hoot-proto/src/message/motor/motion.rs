//! Command 15 of a motor, which is two messages: a move, and a run without end.

use motion_core::wire::{DecodeError, EncodeError, Fields, Message, Row, Visitor};

use super::{Direction, Motor, StepCount};
use crate::message::sub::sub_messages;

const MOVE_STEPS: &str = "MotorMove.steps";

sub_messages! {
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
/// It needs neither a start nor a stop. Without steps it is another message, [`MotorRun`]: a move
/// of 0 steps is refused, read or written. Source: hoot, section 2.3; safety decisions 1 and 3.
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
            return Err(DecodeError::OutOfRange { what: MOVE_STEPS, value: 0, min: 1, max: u32::MAX.into() });
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
            return Err(EncodeError::OutOfRange { what: MOVE_STEPS, value: 0, min: 1, max: u32::MAX.into() });
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

/// Run until told otherwise, at the speed of [`MotorSetContinuousSpeed`](super::MotorSetContinuousSpeed). Nothing moves at speed 0.
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
            return Err(DecodeError::OutOfRange { what: "MotorRun.steps", value: steps.0.into(), min: 0, max: 0 });
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
