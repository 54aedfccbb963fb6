//! Actions: messages with which a client tells a device to do something.

use motion_core::wire::{Bool, Conduct, Purpose};
use motion_core::{message, open_enum};

use super::{MotorAddress, Rotations, RotationsPerSecond, RotationsPerSecondSquared, Seconds};

/// Position to which a motor without a range is sent, so that it runs until it is stopped (decision K-M7).
pub const JOG_DISTANCE: Rotations = Rotations(25_000.0);
/// Acceleration of a stop if no valid one is given: the specification allows it for every kind of motor
/// (decision K-M6).
const FALLBACK: RotationsPerSecondSquared = RotationsPerSecondSquared(50.0);

message! {
    /// Command to start the device anew. It is not answered, and all connections are closed.
    ///
    /// Source: kOS, `ResetDevice`.
    #[derive(Default)]
    pub struct ResetDevice<'a> in BE {}

    /// Command to stop all motors and the move. It is answered by `PlaybackStatus` `FullStop`, and a `MotorPosition` of
    /// each motor when it rests. Source: kOS, `StopPlayback`; safety decisions 2 and 8.
    #[derive(Default)]
    pub struct StopPlayback<'a> in BE {}

    /// Command to send the motors of the stored move to where it begins. Source: kOS, `RapidToFirstKeyFrame`.
    #[derive(Default)]
    pub struct RapidToFirstKeyFrame<'a> in BE {}

    /// Command to forget the range of a motor, or of all motors. For one motor it is answered by `MotorCalibrated`.
    ///
    /// Source: kOS, `ResetAxis`.
    pub struct ResetAxis<'a> in BE {
        /// Address of the motor, or [`MotorAddress::ALL`].
        motor_address: MotorAddress,
    }

    /// Command to begin the range of a motor where it is. It is not answered. Source: kOS, `MarkBeginPosition`.
    pub struct MarkBeginPosition<'a> in BE {
        /// Address of the motor.
        motor_address: MotorAddress,
    }

    /// Command to end the range of a motor where it is, answered by `MotorCalibrated`. Source: kOS, `MarkEndPosition`.
    pub struct MarkEndPosition<'a> in BE {
        /// Address of the motor.
        motor_address: MotorAddress,
    }

    /// Command to play the move. The motors go to where it begins first, if necessary.
    ///
    /// Source: kOS, `StartPlayback`; decision K-J7.
    #[derive(Default)]
    pub struct StartPlayback<'a> in BE {
        /// Direction of the move; the specification asks for 0.
        direction: PlaybackDirection,
        /// Time at which the move begins; the specification asks for 0.
        start_time: Seconds,
    }

    /// Command to take one photo. Source: kOS, `TakePicture`.
    #[derive(Default)]
    pub struct TakePicture<'a> in BE {
        /// Address of a motor; the specification asks for 0.
        motor_address: MotorAddress,
        /// Time for which the shutter is open.
        exposure: Seconds,
    }

    /// Command to make the move ready, answered by `PlaybackStatus`, in the end `SetupCompleted`.
    ///
    /// Source: kOS, `SetupPlayback`; decision K-J7.
    #[derive(Default)]
    pub struct SetupPlayback<'a> in BE {
        /// Direction of the move; the specification asks for 0.
        direction: PlaybackDirection,
        /// Time at which the move begins; the specification asks for 0.
        start_time: Seconds,
        /// Whether the motors stay where they are until the move is played.
        delay_return: Bool,
    }

    /// Command to send a motor to a position, answered by a `MotorPosition` when it rests. Speed 0 stops the motor.
    ///
    /// Positions count from the begin of the range. A motor without a range is sent [`JOG_DISTANCE`] away, and then
    /// stopped. Source: kOS, `SetPositionSpeedAcceleration`; safety decisions 1 to 3, decisions K-M7 and K-M10.
    pub struct SetPositionSpeedAcceleration<'a> in BE {
        /// Address of the motor.
        motor_address: MotorAddress,
        /// Position, counted from the begin of the range.
        position: Rotations,
        /// Speed. Speed 0 stops the motor, whatever the position is.
        speed: RotationsPerSecond,
        /// Acceleration of start and stop.
        acceleration: RotationsPerSecondSquared,
    }

    /// Command to send a motor a distance, answered by a `MotorPosition` when it rests. Speed 0 stops the motor.
    ///
    /// Source: kOS, `BumpPositionSpeedAcceleration`; safety decisions 1 to 3, decision K-M9.
    pub struct BumpPositionSpeedAcceleration<'a> in BE {
        /// Address of the motor.
        motor_address: MotorAddress,
        /// Distance; negative is backward.
        delta: Rotations,
        /// Speed. Speed 0 stops the motor.
        speed: RotationsPerSecond,
        /// Acceleration of start and stop.
        acceleration: RotationsPerSecondSquared,
    }
}

open_enum! {
    /// Direction in which a move is played (decision K-J7).
    pub struct PlaybackDirection(u8) {
        /// From the begin of the move.
        FORWARD = 0,
        /// From the end of the move, probably: the specification has reports of it, but asks for 0.
        REVERSE = 1,
    }
}

/// Direction in which a move is played.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Direction {
    /// From the begin of the move.
    Forward,
    /// From the end of the move.
    Reverse,
}

impl Direction {
    /// Direction of a message; `None` if the number has no known meaning.
    #[must_use]
    pub const fn of(direction: PlaybackDirection) -> Option<Self> {
        match direction {
            PlaybackDirection::FORWARD => Some(Self::Forward),
            PlaybackDirection::REVERSE => Some(Self::Reverse),
            _ => None,
        }
    }

    /// Number of the direction in a message.
    #[must_use]
    pub const fn as_sent(self) -> PlaybackDirection {
        match self {
            Self::Forward => PlaybackDirection::FORWARD,
            Self::Reverse => PlaybackDirection::REVERSE,
        }
    }

    /// The opposite direction.
    #[must_use]
    pub const fn back(self) -> Self {
        match self {
            Self::Forward => Self::Reverse,
            Self::Reverse => Self::Forward,
        }
    }
}

/// Conduct of a message that moves a motor, or stops it by speed 0 (safety decision 3).
const fn by_speed(speed: RotationsPerSecond) -> Conduct {
    if speed.0 == 0.0 { Conduct::new(Purpose::Stops) } else { Conduct::new(Purpose::Moves).once() }
}

impl SetPositionSpeedAcceleration<'_> {
    pub(super) const fn conduct(&self) -> Conduct {
        by_speed(self.speed)
    }

    /// Stops a motor (safety decision 3).
    ///
    /// `last_known` is the position of a calibrated motor as commands count (see `Motor::relative_position`), so that a
    /// device that ignores the speed stays close to it; `None` if the motor has no range, or the position is unknown.
    /// `max_acceleration` is the greatest acceleration of the motor. It is never sent as 0, which might mean that the
    /// motor never stops: every value that is not a positive number becomes 50 rev/s².
    #[must_use]
    pub fn stop(
        motor_address: MotorAddress,
        last_known: Option<Rotations>,
        max_acceleration: RotationsPerSecondSquared,
    ) -> Self {
        let usable = max_acceleration.0.is_finite() && max_acceleration.0 > 0.0;
        Self {
            motor_address,
            position: last_known.filter(|position| position.0.is_finite()).unwrap_or(JOG_DISTANCE),
            speed: RotationsPerSecond(0.0),
            acceleration: if usable { max_acceleration } else { FALLBACK },
            tail: &[],
        }
    }

    /// Runs a motor without a range until it is stopped, backward if `speed` is negative (decision K-M7).
    #[must_use]
    pub fn jog(
        motor_address: MotorAddress,
        speed: RotationsPerSecond,
        acceleration: RotationsPerSecondSquared,
    ) -> Self {
        let (position, speed) = if speed.0 < 0.0 {
            (Rotations(-JOG_DISTANCE.0), RotationsPerSecond(-speed.0))
        } else {
            (JOG_DISTANCE, speed)
        };
        Self { motor_address, position, speed, acceleration, tail: &[] }
    }

    /// Sends a calibrated motor to a position, counted from the begin of its range.
    #[must_use]
    pub const fn move_to(
        motor_address: MotorAddress,
        position: Rotations,
        speed: RotationsPerSecond,
        acceleration: RotationsPerSecondSquared,
    ) -> Self {
        Self { motor_address, position, speed, acceleration, tail: &[] }
    }

    /// Whether the message stops the motor.
    #[must_use]
    pub const fn is_stop(&self) -> bool {
        self.conduct().is_stop()
    }
}

impl BumpPositionSpeedAcceleration<'_> {
    pub(super) const fn conduct(&self) -> Conduct {
        by_speed(self.speed)
    }

    /// Whether the message stops the motor.
    #[must_use]
    pub const fn is_stop(&self) -> bool {
        self.conduct().is_stop()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOTOR: MotorAddress = MotorAddress(2);

    #[test]
    fn a_stop_has_the_last_position_and_an_acceleration_above_0() {
        let stop = SetPositionSpeedAcceleration::stop(MOTOR, Some(Rotations(-3.5)), RotationsPerSecondSquared(100.0));
        assert!(stop.is_stop());
        assert_eq!((stop.position, stop.acceleration.0.to_bits()), (Rotations(-3.5), 100.0_f32.to_bits()));

        for unusable in [0.0, -0.0, -1.0, f32::NAN, f32::INFINITY] {
            let stop = SetPositionSpeedAcceleration::stop(MOTOR, None, RotationsPerSecondSquared(unusable));
            assert!(stop.is_stop());
            assert_eq!((stop.position, stop.acceleration), (JOG_DISTANCE, FALLBACK), "{unusable}");
        }
        let nowhere = Some(Rotations(f32::NAN));
        assert_eq!(SetPositionSpeedAcceleration::stop(MOTOR, nowhere, FALLBACK).position, JOG_DISTANCE);
    }

    #[test]
    fn a_jog_goes_in_the_direction_of_its_speed() {
        let jog = |speed| SetPositionSpeedAcceleration::jog(MOTOR, RotationsPerSecond(speed), FALLBACK);
        assert_eq!((jog(20.0).position, jog(20.0).speed), (JOG_DISTANCE, RotationsPerSecond(20.0)));
        assert_eq!((jog(-20.0).position, jog(-20.0).speed), (Rotations(-25_000.0), RotationsPerSecond(20.0)));
        assert!(jog(0.0).is_stop() && jog(-0.0).is_stop() && !jog(-1.0).is_stop());
    }
}
