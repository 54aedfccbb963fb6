//! Actions: what a client tells a device to do.

use motion_core::wire::{Bool, Conduct, Purpose};
use motion_core::{message, open_enum};

use super::{MotorAddress, Rotations, RotationsPerSecond, RotationsPerSecondSquared, Seconds};

/// Where a motor is sent so that it runs until it is stopped, as long as it is not calibrated (decision K-M7).
pub const JOG_DISTANCE: Rotations = Rotations(25_000.0);
/// The acceleration of a stop where no usable one is given: what the specification allows every kind of motor
/// (decision K-M6).
const FALLBACK: RotationsPerSecondSquared = RotationsPerSecondSquared(50.0);

message! {
    /// Start the device anew. It answers nothing, and closes all connections. Source: kOS, `ResetDevice`.
    #[derive(Default)]
    pub struct ResetDevice<'a> in BE {}

    /// Stop all motors and the move: answered by `PlaybackStatus` `FullStop`, and one `MotorPosition` for each motor at
    /// rest. Source: kOS, `StopPlayback`; safety decisions 2 and 8.
    #[derive(Default)]
    pub struct StopPlayback<'a> in BE {}

    /// Send the motors of the stored move to where it begins. Source: kOS, `RapidToFirstKeyFrame`.
    #[derive(Default)]
    pub struct RapidToFirstKeyFrame<'a> in BE {}

    /// Forget the range of a motor, or of all: answered by `MotorCalibrated`, but for all by nothing.
    ///
    /// Source: kOS, `ResetAxis`.
    pub struct ResetAxis<'a> in BE {
        /// Which motor, or [`MotorAddress::ALL`].
        motor_address: MotorAddress,
    }

    /// The range of a motor begins where it is now. Not answered. Source: kOS, `MarkBeginPosition`.
    pub struct MarkBeginPosition<'a> in BE {
        /// Which motor.
        motor_address: MotorAddress,
    }

    /// The range of a motor ends where it is now: answered by `MotorCalibrated`. Source: kOS, `MarkEndPosition`.
    pub struct MarkEndPosition<'a> in BE {
        /// Which motor.
        motor_address: MotorAddress,
    }

    /// Play the move: go to its begin first, if need be. Source: kOS, `StartPlayback`; decision K-J7.
    #[derive(Default)]
    pub struct StartPlayback<'a> in BE {
        /// Which way; 0.
        direction: PlaybackDirection,
        /// 0.
        start_time: Seconds,
    }

    /// Take one photo. Source: kOS, `TakePicture`.
    #[derive(Default)]
    pub struct TakePicture<'a> in BE {
        /// 0.
        motor_address: MotorAddress,
        /// How long the shutter is open.
        exposure: Seconds,
    }

    /// Get ready to play the move: answered by `PlaybackStatus`, in the end `SetupCompleted`.
    ///
    /// Source: kOS, `SetupPlayback`; decision K-J7.
    #[derive(Default)]
    pub struct SetupPlayback<'a> in BE {
        /// Which way; 0.
        direction: PlaybackDirection,
        /// 0.
        start_time: Seconds,
        /// Whether the motors stay where they are until the move is played.
        delay_return: Bool,
    }

    /// Go to a position: answered by one `MotorPosition` once the motor rests. Speed 0 stops it.
    ///
    /// Positions count from the begin of the range; a motor that is not calibrated is sent [`JOG_DISTANCE`] away, and
    /// stopped. Source: kOS, `SetPositionSpeedAcceleration`; safety decisions 1 to 3, decisions K-M7 and K-M10.
    pub struct SetPositionSpeedAcceleration<'a> in BE {
        /// Which motor.
        motor_address: MotorAddress,
        /// Where to, from the begin of the range.
        position: Rotations,
        /// How fast; 0 stops, wherever the motor is.
        speed: RotationsPerSecond,
        /// How sharply it starts and stops.
        acceleration: RotationsPerSecondSquared,
    }

    /// Go a distance from here: answered by one `MotorPosition` once the motor rests. Speed 0 stops it.
    ///
    /// Source: kOS, `BumpPositionSpeedAcceleration`; safety decisions 1 to 3, decision K-M9.
    pub struct BumpPositionSpeedAcceleration<'a> in BE {
        /// Which motor.
        motor_address: MotorAddress,
        /// How far; negative is back.
        delta: Rotations,
        /// How fast; 0 stops.
        speed: RotationsPerSecond,
        /// How sharply it starts and stops.
        acceleration: RotationsPerSecondSquared,
    }
}

open_enum! {
    /// Which way a move is played (decision K-J7).
    pub struct PlaybackDirection(u8) {
        /// From its begin.
        FORWARD = 0,
        /// From its end, as it seems: the specification has messages for it, but asks for 0.
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
    /// Direction of a message; `None` where the number has no known meaning.
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
    /// `last_known` is where a calibrated motor is, as commands count (see `Motor::relative_position`), so that a
    /// device that overlooks the speed stays close to it; `None` where the motor is not calibrated, or nobody knows.
    /// `max_acceleration` is the greatest one of the motor. It is never sent as 0, which might mean never to stop:
    /// what is not a positive number becomes 50 rev/s².
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

    /// Runs a motor that is not calibrated until it is stopped: backward, if `speed` is negative (decision K-M7).
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
    fn a_stop_stays_where_the_motor_is_and_always_brakes() {
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
    fn a_jog_runs_the_way_that_the_speed_points() {
        let jog = |speed| SetPositionSpeedAcceleration::jog(MOTOR, RotationsPerSecond(speed), FALLBACK);
        assert_eq!((jog(20.0).position, jog(20.0).speed), (JOG_DISTANCE, RotationsPerSecond(20.0)));
        assert_eq!((jog(-20.0).position, jog(-20.0).speed), (Rotations(-25_000.0), RotationsPerSecond(20.0)));
        assert!(jog(0.0).is_stop() && jog(-0.0).is_stop() && !jog(-1.0).is_stop());
    }
}
