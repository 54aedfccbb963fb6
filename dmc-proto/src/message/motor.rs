//! Motors: status, moves, stops, positions, limits.

use core::fmt;

use motion_core::fixed::{Centi, Milli, Scaled};
use motion_core::wire::Bool;
use motion_core::{__newtype, flags, message, open_enum, unit};
use zerocopy::little_endian::I32;

use super::set;

unit! {
    /// A motor, from 1 to the device's motor count, 32 at most.
    pub struct Motor(u8) "";
    /// A position, in steps of the motor.
    pub struct Steps(i32) "steps";
    /// How fast a jog is: 0.01 to 100.00 percent of the motor's speed (decision D-30).
    pub struct JogSpeed(Centi<u16>) "%";
    /// A speed.
    pub struct Speed(u32) "steps/s";
    /// An acceleration.
    pub struct Acceleration(u32) "steps/s²";
    /// A time in a move, in thousandths of a frame; negative in a pre-roll (decision D-29).
    pub struct MoveTime(Milli<i32>) "frames";
}

impl JogSpeed {
    /// The slowest: inching.
    pub const SLOWEST: Self = Self(Scaled(1));
    /// The motor's full speed.
    pub const FULL: Self = Self(Scaled(10_000));
}

/// A set of motors, one bit each: bit 0 is motor 1 (decision D-16).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(transparent)]
pub struct Motors(pub u32);

impl Motors {
    /// No motor.
    pub const NONE: Self = Self(0);

    /// Whether a motor is one of them.
    #[must_use]
    pub fn contains(self, motor: Motor) -> bool {
        set::contains(self.0, motor.0)
    }

    /// Them, one by one.
    pub fn iter(self) -> impl Iterator<Item = Motor> {
        set::numbers(self.0).map(Motor)
    }
}

impl FromIterator<Motor> for Motors {
    /// Motors that are not 1 to 32 have no bit, and are left out.
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

    /// Which motors move. Source: DMC, MSG_MOTOR_STATUS; decision D-16.
    #[derive(Default)]
    pub struct MotorStatus<'a> in LE {
        /// The motors that move.
        motor_status: Motors,
        /// Whether DMX channels change.
        dmx_status: Bool,
    }

    /// Go to a position. Source: DMC, MSG_MOTOR_MOVE.
    #[derive(Default)]
    pub struct MotorMove<'a> in LE {
        /// Which motor.
        motor: Motor,
        /// Where to.
        position: Steps,
    }

    /// The answer to [`MotorMove`]; some devices send an acknowledgement instead (decision D-17).
    #[derive(Default)]
    pub struct MotorMoving<'a> in LE {
        /// Whether the motor moves now.
        moving: Bool,
    }

    /// Stop one motor. Of a real-time move, this stops all of it. Source: DMC, MSG_MOTOR_STOP; safety decision 1.
    #[derive(Default)]
    pub struct MotorStop<'a> in LE {
        /// Which motor.
        motor: Motor,
    }

    /// Stop everything, whatever the flags say; again within a second, it stops harder.
    ///
    /// Source: DMC, MSG_MOTOR_STOP_ALL; safety decisions 1 and 4, decision D-22.
    #[derive(Default)]
    pub struct MotorStopAll<'a> in LE {
        ;
        /// How the device takes it.
        flags: Option<StopFlags>,
    }

    /// Where the motors are: the answer, and sent unasked about every 100 ms while they move.
    ///
    /// Source: DMC, MSG_MOTOR_GET_POSITION; decision D-18.
    #[derive(Default)]
    pub struct MotorPositions<'a> in LE {
        /// Where in the move they are.
        move_time: MoveTime,
        ;
        /// The positions of all motors, from motor 1.
        positions: &'a [I32] ["steps"],
    }

    /// Call the place where a motor stands by another number. Source: DMC, MSG_MOTOR_RESET_POSITION.
    #[derive(Default)]
    pub struct MotorResetPosition<'a> in LE {
        /// Which motor.
        motor: Motor,
        /// What its position is from now on.
        position: Steps,
    }

    /// Run towards a position until told otherwise. Source: DMC, MSG_MOTOR_JOG; decision D-30.
    #[derive(Default)]
    pub struct MotorJog<'a> in LE {
        /// Which motor.
        motor: Motor,
        /// How fast.
        speed: JogSpeed,
        /// Where it ends at the latest.
        destination: Steps,
    }

    /// What a motor is used for. Source: DMC, MSG_MOTOR_CONFIGURE.
    #[derive(Default)]
    pub struct MotorConfigure<'a> in LE {
        /// Which motor.
        motor: Motor,
        /// What for.
        flags: MotorFlags,
    }

    /// How fast a motor may be. Source: DMC, MSG_MOTOR_SET_SPEED.
    #[derive(Default)]
    pub struct MotorSetSpeed<'a> in LE {
        /// Which motor.
        motor: Motor,
        /// The greatest speed.
        max_velocity: Speed,
        /// The greatest acceleration.
        max_accel: Acceleration,
    }

    /// How far a motor may go. Source: DMC, MSG_MOTOR_SET_LIMITS; safety decision 8.
    #[derive(Default)]
    pub struct MotorSetLimits<'a> in LE {
        /// Which motor.
        motor: Motor,
        /// Whether the lower limit counts.
        lower_enable: Bool,
        /// The lower limit.
        lower: Steps,
        /// Whether the upper limit counts.
        upper_enable: Bool,
        /// The upper limit.
        upper: Steps,
        /// Which limit switches are this motor's.
        hw_set: HardwareLimitSet,
    }

    /// A motor ran into a limit, or everything was stopped: sent unasked, with id 0.
    ///
    /// Source: DMC, MSG_MOTOR_HARD_STOP; decision D-20.
    #[derive(Default)]
    pub struct HardStop<'a> in LE {
        /// Why.
        reason: StopReason,
        ;
        /// Which motor, where it was one.
        motor: Option<Motor>,
    }
}

flags! {
    /// How a device takes a stop of everything. Unknown bits are kept.
    pub struct StopFlags(u32) {
        /// Without the device's warnings. The motors stop all the same.
        SILENT = 0x0000_0001,
    }

    /// What a motor is used for. The bits from `VIRTUAL` on stand in the vendor's firmware only. Unknown bits are kept.
    pub struct MotorFlags(u8) {
        /// It is used at all.
        ENABLED = 0x01,
        /// It moves while the shutter is open.
        BLUR = 0x02,
        /// It is part of a virtual motor.
        VIRTUAL = 0x04,
        /// It can be driven by hand during a move.
        LIVE = 0x08,
        /// It is coupled with the next motor.
        COUPLE = 0x10,
        /// Coupled, the other way round.
        COUPLE_REVERSE = 0x20,
    }
}

open_enum! {
    /// Why everything stopped.
    pub struct StopReason(u8) {
        /// The emergency stop.
        EMERGENCY_STOP = 0,
        /// An upper limit switch.
        UPPER_LIMIT = 1,
        /// A lower limit switch.
        LOWER_LIMIT = 2,
        /// The motion engine gave up.
        ENGINE_EXCEPTION = 100,
    }
}

/// Which limit switches belong to a motor.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(transparent)]
pub struct HardwareLimitSet(pub u8);

impl HardwareLimitSet {
    const SWAP: u8 = 0x80;

    /// The number of the pair of switches, from 1; 0 for none.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.0 & !Self::SWAP
    }

    /// Whether upper and lower switch change places.
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
        assert_eq!([0, 2, 33, 255].map(Motor).into_iter().collect::<Motors>(), Motors(2), "the others have no bit");
        assert_eq!(format!("{motors} {}", Motors::NONE), "1+32 none");
    }

    #[test]
    fn a_hard_stop_names_a_motor_or_not() {
        let estop = HardStop::decode(&[0]).unwrap();
        assert_eq!((estop.reason, estop.motor), (StopReason::EMERGENCY_STOP, None));
        let upper = HardStop::decode(&[1, 2]).unwrap();
        assert_eq!((upper.reason, upper.motor), (StopReason::UPPER_LIMIT, Some(Motor(2))));
        assert_eq!(HardStop::decode(&[1]).unwrap().motor, None, "accepted, though the specification wants a motor");
        assert_eq!(HardStop::decode(&[100, 7]).unwrap().motor, Some(Motor(7)), "dmc-lite says which motor gave up");
    }

    #[test]
    fn flags_of_a_stop_are_whole_or_a_tail() {
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
