//! Actions: messages by which a client tells a device to do something.

use motion_core::wire::{Bool, Conduct, Purpose};
use motion_core::{display, message, open_enum};

use super::{MotorAddress, Rotations, RotationsPerSecond, RotationsPerSecondSquared, Seconds};

/// Position that a jog sends a motor to that is not calibrated, so far away that the motor runs until it is stopped
/// (decision K-M7).
pub const JOG_DISTANCE: Rotations = Rotations(25_000.0);
/// Acceleration of a stop if no usable acceleration is given. The specification allows it for every kind of axis
/// (decision K-M6).
const FALLBACK: RotationsPerSecondSquared = RotationsPerSecondSquared(50.0);

message! {
    /// Restart of the device, which closes all connections. Not answered. Source: kOS, `ResetDevice`.
    #[derive(Default)]
    pub struct ResetDevice<'a> in BE {}

    /// Stop of all motors and of the move.
    ///
    /// The device answers `PlaybackStatus` `FullStop`, and one `MotorPosition` for each motor at rest. Source: kOS,
    /// `StopPlayback`; safety decisions 2 and 8.
    #[derive(Default)]
    pub struct StopPlayback<'a> in BE {}

    /// Run of the motors of the stored move to the position where the move begins. Source: kOS, `RapidToFirstKeyFrame`.
    #[derive(Default)]
    pub struct RapidToFirstKeyFrame<'a> in BE {}

    /// Reset of the range of a motor, or of all motors, which are then not calibrated.
    ///
    /// The device answers `MotorCalibrated` for one motor, and nothing for all motors. Source: kOS, `ResetAxis`.
    pub struct ResetAxis<'a> in BE {
        /// Motor whose range is reset, or [`MotorAddress::ALL`].
        motor_address: MotorAddress,
    }

    /// Begin of the range of a motor, set to its present position. Not answered. Source: kOS, `MarkBeginPosition`.
    pub struct MarkBeginPosition<'a> in BE {
        /// Motor whose range begins.
        motor_address: MotorAddress,
    }

    /// End of the range of a motor, set to its present position. The device answers `MotorCalibrated`. Source: kOS,
    /// `MarkEndPosition`.
    pub struct MarkEndPosition<'a> in BE {
        /// Motor whose range ends.
        motor_address: MotorAddress,
    }

    /// Start of the stored move. The motors go to its begin first, if they are not there. Source: kOS, `StartPlayback`;
    /// decision K-J7.
    #[derive(Default)]
    pub struct StartPlayback<'a> in BE {
        /// Direction of the move. The specification asks for 0.
        direction: PlaybackDirection,
        /// Time in the move at which it starts. The specification asks for 0.
        start_time: Seconds,
    }

    /// Trigger of one photo. Source: kOS, `TakePicture`.
    #[derive(Default)]
    pub struct TakePicture<'a> in BE {
        /// Unused: 0, which is no motor.
        motor_address: MotorAddress,
        /// Exposure: time for which the shutter is open.
        exposure: Seconds,
    }

    /// Preparation of the stored move. The device answers `PlaybackStatus`, last `SetupCompleted`.
    ///
    /// Source: kOS, `SetupPlayback`; decision K-J7.
    #[derive(Default)]
    pub struct SetupPlayback<'a> in BE {
        /// Direction of the move. The specification asks for 0.
        direction: PlaybackDirection,
        /// Time in the move at which it starts. The specification asks for 0.
        start_time: Seconds,
        /// Whether the motors stay at their positions until the move is played.
        delay_return: Bool,
    }

    /// Run of a motor to a position. Speed 0 stops the motor.
    ///
    /// The device answers one `MotorPosition` when the motor rests. Positions count from the begin of the range. A
    /// motor that is not calibrated is sent to [`JOG_DISTANCE`] or its negative, and then stopped. Source: kOS,
    /// `SetPositionSpeedAcceleration`; safety decisions 1 to 3, decisions K-M7 and K-M10.
    pub struct SetPositionSpeedAcceleration<'a> in BE {
        /// Motor that moves or stops.
        motor_address: MotorAddress,
        /// Position to go to, from the begin of the range.
        position: Rotations,
        /// Speed of the motor. Speed 0 stops it, whatever the position says.
        speed: RotationsPerSecond,
        /// Acceleration with which the motor starts and stops.
        acceleration: RotationsPerSecondSquared,
    }

    /// Run of a motor by a distance from its present position. Speed 0 stops the motor.
    ///
    /// The device answers one `MotorPosition` when the motor rests. Source: kOS, `BumpPositionSpeedAcceleration`;
    /// safety decisions 1 to 3, decision K-M9.
    pub struct BumpPositionSpeedAcceleration<'a> in BE {
        /// Motor that moves or stops.
        motor_address: MotorAddress,
        /// Distance to go. A negative distance goes back.
        delta: Rotations,
        /// Speed of the motor. Speed 0 stops it.
        speed: RotationsPerSecond,
        /// Acceleration with which the motor starts and stops.
        acceleration: RotationsPerSecondSquared,
    }
}

open_enum! {
    /// Direction in which a move is played, as messages number it (decision K-J7).
    pub struct PlaybackDirection(u8) {
        /// Forward, from the begin of the move.
        FORWARD = 0,
        /// Reverse, probably from the end of the move. The specification has messages for it, but asks for 0.
        REVERSE = 1,
    }
}

open_enum! {
    /// Number of an action.
    pub struct ActionId(u8) {
        /// `ResetDevice`.
        RESET_DEVICE = 0x01,
        /// `ResetAxis`.
        RESET_AXIS = 0x02,
        /// `MarkBeginPosition`.
        MARK_BEGIN_POSITION = 0x03,
        /// `MarkEndPosition`.
        MARK_END_POSITION = 0x04,
        /// `StartPlayback`.
        START_PLAYBACK = 0x05,
        /// `StopPlayback`.
        STOP_PLAYBACK = 0x06,
        /// `RapidToFirstKeyFrame`.
        RAPID_TO_FIRST_KEY_FRAME = 0x07,
        /// `TakePicture`.
        TAKE_PICTURE = 0x09,
        /// `SetupPlayback`.
        SETUP_PLAYBACK = 0x0F,
        /// `SetPositionSpeedAcceleration`.
        SET_POSITION_SPEED_ACCELERATION = 0x1C,
        /// `BumpPositionSpeedAcceleration`.
        BUMP_POSITION_SPEED_ACCELERATION = 0x28,
    }
}

/// Direction in which a move is played.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[cfg_attr(feature = "serde", derive(motion_core::serde::Serialize, motion_core::serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(crate = "motion_core::serde", rename_all = "snake_case"))]
pub enum Direction {
    /// Forward, from the begin of the move.
    Forward,
    /// Reverse, from the end of the move.
    Reverse,
}

display! {
    Direction {
        Forward => "forward";
        Reverse => "in reverse";
    }
}

impl Direction {
    /// Direction that a message numbers; `None` if the number has no known meaning.
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

    /// Opposite direction.
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
    /// `last_known` is the position of a calibrated motor, as commands count it (see `Motor::relative_position`): a
    /// device that ignores the speed of 0 then keeps the motor close to that position. `None` says that the motor is
    /// not calibrated, or that its position is not known; the position is then [`JOG_DISTANCE`].
    ///
    /// `max_acceleration` is the greatest acceleration of the motor, in rev/s². An acceleration of 0 is never sent,
    /// because it might mean that the motor never stops. A value that is not a positive finite number becomes
    /// 50 rev/s².
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

    /// Runs a motor that is not calibrated until it is stopped. A negative `speed` runs it back (decision K-M7).
    ///
    /// [`Motor::jog`](super::Motor::jog) also keeps a motor that is calibrated in its range.
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
    use crate::{HostMessage, MessageId};
    use motion_core::wire::Messages as _;

    const MOTOR: MotorAddress = MotorAddress(2);

    #[test]
    fn actions_have_the_numbers_and_names_of_their_messages() {
        let mut actions = 0;
        for number in 0..=u8::MAX {
            let id = u32::from(MessageId::ACTION.0) << 16 | u32::from(number);
            let message = HostMessage::ALL.iter().find(|message| message.number == id).map(|message| message.name);
            let name = ActionId(number).name().map(|name| name.replace('_', ""));
            assert_eq!(name, message.map(str::to_uppercase), "{number:#04x}");
            actions += usize::from(message.is_some());
        }
        let rows = HostMessage::ALL.iter().filter(|message| message.number >> 16 == MessageId::ACTION.0.into());
        assert_eq!(rows.count(), actions);
    }

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
