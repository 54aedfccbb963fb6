//! The units of the fields, and the addresses of motors.

use core::fmt;

use motion_core::{__newtype, unit};

unit! {
    /// A position or a distance, in rotations of the motor.
    pub struct Rotations(f32) "rev";
    /// A speed.
    pub struct RotationsPerSecond(f32) "rev/s";
    /// An acceleration.
    pub struct RotationsPerSecondSquared(f32) "rev/s²";
    /// A time.
    pub struct Seconds(f32) "s";
    /// A part of a whole: 0 to 1.
    pub struct Normalized(f32) "";
}

/// A motor, 1 to 10; 0 where a message is for all of them. Bit 7 marks focus, iris and zoom in what devices send.
///
/// The number without the bit is the key in every message (decisions K-M1 and K-M2).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(transparent)]
pub struct MotorAddress(pub u8);

impl MotorAddress {
    /// All motors in `ResetAxis`, none in `ErrorStatus` and `TakePicture`.
    pub const ALL: Self = Self(0);
    /// The last motor that a device can have (decision K-M1).
    pub const LAST: Self = Self(10);

    const FIZ: u8 = 0x80;

    /// The address without the mark.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.0 & !Self::FIZ
    }

    /// Whether the motor is one of focus, iris and zoom.
    #[must_use]
    pub const fn is_fiz(self) -> bool {
        self.0 & Self::FIZ != 0
    }
}

impl fmt::Display for MotorAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.number(), if self.is_fiz() { " FIZ" } else { "" })
    }
}

__newtype! { MotorAddress(u8) "" }
