//! Motors: status, moves, stops, positions, limits.

use core::fmt;

use motion_core::fixed::{Centi, Milli, Scaled};
use motion_core::wire::Bool;
use motion_core::{__newtype, flags, message, open_enum, unit};
use zerocopy::little_endian::I32;

use super::set;

unit! {
    /// Number of a motor, from 1 to the number of motors of the device, at most 32.
    pub struct Motor(u8) "";
    /// Position, in steps of the motor.
    pub struct Steps(i32) "steps";
    /// Speed of a jog, 0.01 to 100.00 percent of the speed of the motor (decision D-30).
    pub struct JogSpeed(Centi<u16>) "%";
    /// Speed, in steps per second.
    pub struct Speed(u32) "steps/s";
    /// Acceleration, in steps per second squared.
    pub struct Acceleration(u32) "steps/s²";
    /// Time in a move, in thousandths of a frame. It is negative in a pre-roll (decision D-29).
    pub struct MoveTime(Milli<i32>) "frames";
}

impl JogSpeed {
    /// Slowest speed of a jog.
    pub const SLOWEST: Self = Self(Scaled(1));
    /// Full speed of the motor.
    pub const FULL: Self = Self(Scaled(10_000));
}

/// Set of motors, with one bit for each: bit 0 is motor 1 (decision D-16).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(transparent)]
pub struct Motors(pub u32);

impl Motors {
    /// Empty set.
    pub const NONE: Self = Self(0);

    /// Whether a motor is in the set.
    #[must_use]
    pub fn contains(self, motor: Motor) -> bool {
        set::contains(self.0, motor.0)
    }

    /// Motors of the set, in the order of their numbers.
    pub fn iter(self) -> impl Iterator<Item = Motor> {
        set::numbers(self.0).map(Motor)
    }
}

impl FromIterator<Motor> for Motors {
    /// Makes the set of these motors. Numbers outside 1 to 32 have no bit, and are left out.
    fn from_iter<I: IntoIterator<Item = Motor>>(motors: I) -> Self {
        Self(set::of(motors.into_iter().map(|motor| motor.0)))
    }
}

impl fmt::Display for Motors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        set::print(f, self.0)
    }
}

__newtype! { Motors(u32) "" }

message! {
    /// Question which motors move. Source: DMC, MSG_MOTOR_STATUS.
    #[derive(Default)]
    pub struct MotorStatusRequest<'a> in LE {}

    /// Question where the motors are. Source: DMC, MSG_MOTOR_GET_POSITION.
    #[derive(Default)]
    pub struct MotorGetPosition<'a> in LE {}

    /// Status of the motors. Source: DMC, MSG_MOTOR_STATUS; decision D-16.
    #[derive(Default)]
    pub struct MotorStatus<'a> in LE {
        /// Motors that move.
        motor_status: Motors,
        /// Whether DMX channels change.
        dmx_status: Bool,
    }

    /// Request to send a motor to a position. Source: DMC, MSG_MOTOR_MOVE.
    #[derive(Default)]
    pub struct MotorMove<'a> in LE {
        /// Number of the motor.
        motor: Motor,
        /// Position to go to.
        position: Steps,
    }

    /// Answer to [`MotorMove`]. Some devices send an acknowledgement instead (decision D-17).
    #[derive(Default)]
    pub struct MotorMoving<'a> in LE {
        /// Whether the motor moves now.
        moving: Bool,
    }

    /// Stop of one motor. During a real-time move it stops the whole move. Source: DMC, MSG_MOTOR_STOP; safety decision 1.
    #[derive(Default)]
    pub struct MotorStop<'a> in LE {
        /// Number of the motor.
        motor: Motor,
    }

    /// Stop of everything, with any flags. A second one within a second stops harder.
    ///
    /// Source: DMC, MSG_MOTOR_STOP_ALL; safety decisions 1 and 4, decision D-22.
    #[derive(Default)]
    pub struct MotorStopAll<'a> in LE {
        ;
        /// Options of the stop.
        flags: Option<StopFlags>,
    }

    /// Positions of the motors: an answer, or sent unasked about every 100 ms while motors move.
    ///
    /// Source: DMC, MSG_MOTOR_GET_POSITION; decision D-18.
    #[derive(Default)]
    pub struct MotorPositions<'a> in LE {
        /// Time in the move.
        move_time: MoveTime,
        ;
        /// Positions of all motors, starting with motor 1.
        positions: &'a [I32] ["steps"],
    }

    /// Request to give the place where a motor stands another number. Source: DMC, MSG_MOTOR_RESET_POSITION.
    #[derive(Default)]
    pub struct MotorResetPosition<'a> in LE {
        /// Number of the motor.
        motor: Motor,
        /// New position of the place.
        position: Steps,
    }

    /// Request to run a motor towards a position, until another request. Source: DMC, MSG_MOTOR_JOG; decision D-30.
    #[derive(Default)]
    pub struct MotorJog<'a> in LE {
        /// Number of the motor.
        motor: Motor,
        /// Speed of the jog.
        speed: JogSpeed,
        /// Position at which the jog ends at the latest.
        destination: Steps,
    }

    /// Uses of a motor. Source: DMC, MSG_MOTOR_CONFIGURE.
    #[derive(Default)]
    pub struct MotorConfigure<'a> in LE {
        /// Number of the motor.
        motor: Motor,
        /// Uses of the motor.
        flags: MotorFlags,
    }

    /// Greatest speed and acceleration of a motor. Source: DMC, MSG_MOTOR_SET_SPEED.
    #[derive(Default)]
    pub struct MotorSetSpeed<'a> in LE {
        /// Number of the motor.
        motor: Motor,
        /// Greatest speed.
        max_velocity: Speed,
        /// Greatest acceleration.
        max_accel: Acceleration,
    }

    /// Limits of a motor. Source: DMC, MSG_MOTOR_SET_LIMITS; safety decision 8.
    #[derive(Default)]
    pub struct MotorSetLimits<'a> in LE {
        /// Number of the motor.
        motor: Motor,
        /// Whether the lower limit counts.
        lower_enable: Bool,
        /// Lower limit.
        lower: Steps,
        /// Whether the upper limit counts.
        upper_enable: Bool,
        /// Upper limit.
        upper: Steps,
        /// Limit switches of the motor.
        hw_set: HardwareLimitSet,
    }

    /// News that a motor ran into a limit, or that everything was stopped. It is sent unasked, with id 0.
    ///
    /// Source: DMC, MSG_MOTOR_HARD_STOP; decision D-20.
    #[derive(Default)]
    pub struct HardStop<'a> in LE {
        /// Reason for the stop.
        reason: StopReason,
        ;
        /// Motor that caused the stop, if one did.
        motor: Option<Motor>,
    }
}

flags! {
    /// Options of a stop of everything. Unknown bits are kept.
    pub struct StopFlags(u32) {
        /// The device shows no warnings. The motors stop as usual.
        SILENT = 0x0000_0001,
    }

    /// Uses of a motor. The bits from `VIRTUAL` on are in the vendor's firmware only. Unknown bits are kept.
    pub struct MotorFlags(u8) {
        /// The motor is in use.
        ENABLED = 0x01,
        /// The motor moves while the shutter is open.
        BLUR = 0x02,
        /// The motor is part of a virtual motor.
        VIRTUAL = 0x04,
        /// The motor can be driven by hand during a move.
        LIVE = 0x08,
        /// The motor is coupled with the next motor.
        COUPLE = 0x10,
        /// The motor is coupled with the next motor, in the opposite direction.
        COUPLE_REVERSE = 0x20,
    }
}

open_enum! {
    /// Reason why everything stopped.
    pub struct StopReason(u8) {
        /// The emergency stop was pressed.
        EMERGENCY_STOP = 0,
        /// A motor reached its upper limit switch.
        UPPER_LIMIT = 1,
        /// A motor reached its lower limit switch.
        LOWER_LIMIT = 2,
        /// The motion engine failed.
        ENGINE_EXCEPTION = 100,
    }
}

/// Limit switches that belong to a motor.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(transparent)]
pub struct HardwareLimitSet(pub u8);

impl HardwareLimitSet {
    const SWAP: u8 = 0x80;

    /// Number of the pair of switches, from 1; 0 for none.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.0 & !Self::SWAP
    }

    /// Whether the upper and the lower switch change places.
    #[must_use]
    pub const fn is_swapped(self) -> bool {
        self.0 & Self::SWAP != 0
    }
}

impl fmt::Display for HardwareLimitSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.number(), self.is_swapped()) {
            (0, false) => f.write_str("none"),
            (number, false) => write!(f, "{number}"),
            (number, true) => write!(f, "{number} swapped"),
        }
    }
}

__newtype! { HardwareLimitSet(u8) "" }

#[cfg(test)]
mod tests {
    use super::*;
    use motion_core::wire::Message;
    use std::{format, vec::Vec};

    #[test]
    fn bit_0_is_motor_1() {
        let motors = Motors(0x8000_0001);
        assert_eq!(motors.iter().collect::<Vec<_>>(), [Motor(1), Motor(32)]);
        assert!(motors.contains(Motor(1)) && motors.contains(Motor(32)));
        assert!(![0, 2, 31, 33, 255].into_iter().any(|motor| motors.contains(Motor(motor))));
        assert_eq!((1..=32).map(Motor).collect::<Motors>(), Motors(u32::MAX));
        assert_eq!([0, 2, 33, 255].map(Motor).into_iter().collect::<Motors>(), Motors(2), "other numbers have no bit");
        assert_eq!(format!("{motors} {}", Motors::NONE), "1+32 none");
    }

    #[test]
    fn a_hard_stop_may_name_a_motor() {
        let estop = HardStop::decode(&[0]).unwrap();
        assert_eq!((estop.reason, estop.motor), (StopReason::EMERGENCY_STOP, None));
        let upper = HardStop::decode(&[1, 2]).unwrap();
        assert_eq!((upper.reason, upper.motor), (StopReason::UPPER_LIMIT, Some(Motor(2))));
        assert_eq!(HardStop::decode(&[1]).unwrap().motor, None, "read, although the specification demands a motor");
        assert_eq!(HardStop::decode(&[100, 7]).unwrap().motor, Some(Motor(7)), "dmc-lite names the motor that failed");
    }

    #[test]
    fn flags_of_a_stop_that_are_cut_off_are_a_tail() {
        assert_eq!(MotorStopAll::decode(&[]), Ok(MotorStopAll { flags: None, tail: &[] }));
        assert_eq!(MotorStopAll::decode(&[1, 0, 0]), Ok(MotorStopAll { flags: None, tail: &[1, 0, 0] }));
        let unknown = MotorStopAll::decode(&[1, 0, 0, 0x80]).unwrap();
        assert_eq!(unknown.flags, Some(StopFlags(0x8000_0001)), "unknown bits are kept");
    }

    #[test]
    fn limit_switches_are_numbered_and_may_be_swapped() {
        let set = HardwareLimitSet(0x83);
        assert_eq!((set.number(), set.is_swapped()), (3, true));
        assert_eq!(format!("{set}, {}, {}", HardwareLimitSet(3), HardwareLimitSet(0)), "3 swapped, 3, none");
    }
}
