//! Messages of command 15 of a motor: a move, and a run without end.

use motion_core::wire::{DecodeError, EncodeError, Fields, Message, Row, Visitor};

use super::{Direction, Motor, StepCount};
use crate::message::sub::sub_messages;

const MOVE_STEPS: &str = "MotorMove.steps";

sub_messages! {
    /// Data of command 15: a move, or a run if there are no steps.
    struct MotorMoveOrRun for /** The motor. */ motor: Motor {
        /// Direction.
        direction: Direction,
        /// Number of steps; 0 is a run without end.
        steps: StepCount,
    }
}

motion_core::__logged! {
    /// Moves the motor by a number of steps. Never repeat it by yourself, because the motor would move again.
    ///
    /// The move needs neither a start nor a stop. The same command with 0 steps is another message, [`MotorRun`], so a move
    /// of 0 steps can be neither decoded nor encoded. Source: hoot, section 2.3; safety decisions 1 and 3.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub struct MotorMove {
        /// The motor.
        pub motor: Motor,
        /// Direction.
        pub direction: Direction,
        /// Number of steps, 1 to 16,777,215. With more steps, lint finds an error, because firmware reads 16,777,216 as 0,
        /// which is a run without end.
        pub steps: StepCount,
    }
}

impl MotorMove {
    /// Makes the message; `None` unless the number of steps is 1 to 16,777,215.
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

motion_core::__logged! {
    /// Runs the motor until it is stopped, at the speed of [`MotorSetContinuousSpeed`](super::MotorSetContinuousSpeed). At
    /// speed 0 it does not move.
    ///
    /// On the wire it is a move by 0 steps. Source: hoot, section 2.3; safety decision 3.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub struct MotorRun {
        /// The motor.
        pub motor: Motor,
        /// Direction.
        pub direction: Direction,
    }
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
