//! Units of the fields, and addresses of motors.

use core::fmt;
use core::str::FromStr;

use motion_core::parse::{self, ParseError, ParseProblem};
use motion_core::{__newtype, unit};

unit! {
    /// Position or distance, in rotations of the motor.
    pub struct Rotations(f32) "rev";
    /// Speed, in rotations of the motor per second.
    pub struct RotationsPerSecond(f32) "rev/s";
    /// Acceleration, in rotations of the motor per second squared.
    pub struct RotationsPerSecondSquared(f32) "rev/s²";
    /// Time, in seconds.
    pub struct Seconds(f32) "s";
    /// Part of a whole, 0 to 1.
    pub struct Normalized(f32) "";
}

impl Rotations {
    /// Whether a position lies in a range of this length, which begins at 0.
    pub(crate) fn spans(self, position: Self) -> bool {
        (self.0.min(0.0)..=self.0.max(0.0)).contains(&position.0)
    }
}

/// Address of a motor, 1 to 10; 0 if a message is for all motors.
///
/// Bit 7 marks focus, iris and zoom in messages of devices. The number without the bit is the key in every message
/// (decisions K-M1 and K-M2).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(transparent)]
pub struct MotorAddress(pub u8);

impl MotorAddress {
    /// Address 0: all motors in `ResetAxis`, no motor in `ErrorStatus` and `TakePicture`.
    pub const ALL: Self = Self(0);
    /// Last motor that a device can have (decision K-M1).
    pub const LAST: Self = Self(10);

    const FIZ: u8 = 0x80;

    /// Number of the motor: the address without bit 7.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.0 & !Self::FIZ
    }

    /// Whether the motor turns focus, iris or zoom.
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

/// Reads a number from 0 to 127, and ` FIZ` after it for a motor that turns focus, iris or zoom. Motors have 1 to 10, but a device
/// may report others (decision K-M1), and each address that is printed is read back.
impl FromStr for MotorAddress {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let (number, flag) = text.strip_suffix(" FIZ").map_or((text, 0), |number| (number, Self::FIZ));
        let form = "a number from 0 to 127, such as 2 or 2 FIZ; motors have 1 to 10, and 0 is for all motors";
        let why = |at| ParseError { what: "MotorAddress", why: ParseProblem::Form { at, form } };
        match parse::bytes(number, b' ', 10).map_err(why)? {
            [number @ 0..Self::FIZ] => Ok(Self(number | flag)),
            [_] => Err(why(number.len().saturating_sub(1))),
        }
    }
}

__newtype! { MotorAddress(u8) "" }
