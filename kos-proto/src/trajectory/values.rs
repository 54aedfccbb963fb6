//! The values that blocks are made of.

use core::fmt;

use motion_core::bezier::{self, OutOfRange};
use motion_core::wire::{Field, List, Reader, Value, Writer, print};
use motion_core::{__newtype, open_enum};
use zerocopy::ByteOrder;

use crate::message::{Normalized, Seconds};

open_enum! {
    /// What a move waits for before it begins. Source: kOS, `TrajectoryData`.
    pub struct DelayMode(u8) {
        /// Nothing.
        NONE = 0,
        /// A time in seconds.
        INTERVAL = 1,
        /// A time of day (safety decision 5).
        UNTIL = 2,
    }
}

/// How often a move is played again: 0 to 254 times, or 255 for ever (decision K-J4).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(transparent)]
pub struct LoopCount(pub u8);

impl LoopCount {
    /// Once, without a loop.
    pub const NONE: Self = Self(0);
    /// Until it is stopped.
    pub const FOREVER: Self = Self(255);
}

impl fmt::Display for LoopCount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::FOREVER => f.write_str("for ever"),
            Self(count) => write!(f, "{count}"),
        }
    }
}

__newtype! { LoopCount(u8) "" }

/// How long or until when a move waits: four bytes whose meaning [`DelayMode`] says.
///
/// The field is an IEEE number, yet a moment does not fit into one: as a float, Unix time has steps of 128 seconds.
/// So a moment is sent as an integer, which is also the safe mistake: a device that reads a float never starts. What is
/// received is told apart by its bits (decision K-J3, safety decision 5).
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
#[repr(transparent)]
pub struct DelayInterval(pub u32);

impl DelayInterval {
    /// A time, for [`DelayMode::INTERVAL`].
    #[must_use]
    pub const fn from_seconds(seconds: Seconds) -> Self {
        Self(seconds.0.to_bits())
    }

    /// Seconds since 1970, for [`DelayMode::UNTIL`].
    #[must_use]
    pub const fn from_unix_time(seconds: u32) -> Self {
        Self(seconds)
    }

    /// Seconds since 1970 as IEEE number, rounded to 128 seconds, for [`DelayMode::UNTIL`].
    ///
    /// Only for a device that is known to read it so: one that reads an integer starts at once (safety decision 5).
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "that is what this form of it costs")]
    pub const fn from_unix_time_as_float(seconds: u32) -> Self {
        Self((seconds as f32).to_bits())
    }

    /// The time, under [`DelayMode::INTERVAL`].
    #[must_use]
    pub const fn seconds(self) -> Seconds {
        Seconds(f32::from_bits(self.0))
    }

    /// Whether a moment is written as an IEEE number: bits that are one of 2004 to 2038, and as an integer would be a
    /// moment before the protocol was made.
    #[must_use]
    pub const fn is_float_time(self) -> bool {
        matches!(self.0, 0x4E80_0000..=0x4EFF_FFFF)
    }

    /// Seconds since 1970, under [`DelayMode::UNTIL`], whichever way it is written.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the bits of a float time are those of a whole number of 31 bits"
    )]
    pub const fn unix_time(self) -> u32 {
        if self.is_float_time() { f32::from_bits(self.0) as u32 } else { self.0 }
    }
}

impl fmt::Display for DelayInterval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#010x}", self.0)
    }
}

__newtype! { DelayInterval(u32) "" }

/// A point of a curve: when, and where.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Point {
    /// When: 0 is the begin of the move, 1 its end.
    pub time: Normalized,
    /// Where: 0 is the begin of the motor's range, 1 its end.
    pub position: Normalized,
}

impl Point {
    /// A point.
    #[must_use]
    pub const fn new(time: f32, position: f32) -> Self {
        Self { time: Normalized(time), position: Normalized(position) }
    }
}

impl fmt::Display for Point {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        print::ListText(self).fmt(f)
    }
}

impl List for Point {
    fn each(&self, item: &mut dyn FnMut(Value<'_>)) {
        item(self.time.value());
        item(self.position.value());
    }
}

/// The four points of a curve: begin, two handles, end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[repr(transparent)]
pub struct Points(pub [Point; 4]);

impl Points {
    /// The curve through them, in parts of the move and of the motor's range.
    ///
    /// # Errors
    ///
    /// [`OutOfRange`], if a number is infinite or none at all.
    pub fn curve(&self) -> Result<bezier::Segment, OutOfRange> {
        bezier::Segment::from_f32(self.0.map(|point| [point.time.0, point.position.0]))
    }
}

impl List for Points {
    fn each(&self, item: &mut dyn FnMut(Value<'_>)) {
        for point in &self.0 {
            item(Value::List(point));
        }
    }
}

impl fmt::Display for Points {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        print::ListText(self).fmt(f)
    }
}

impl Field for Points {
    const SIZE: usize = 32;
    const WIRE: &'static str = "[[f32; 2]; 4]";

    #[inline]
    fn read<O: ByteOrder>(reader: &mut Reader<'_, O>) -> Option<Self> {
        let mut points = Self::default();
        for point in &mut points.0 {
            *point = Point { time: Field::read(reader)?, position: Field::read(reader)? };
        }
        Some(points)
    }

    #[inline]
    fn write<O: ByteOrder>(&self, writer: &mut Writer<'_, O>) -> Option<()> {
        self.0.iter().try_for_each(|point| {
            Field::write(&point.time, writer)?;
            Field::write(&point.position, writer)
        })
    }

    fn value(&self) -> Value<'_> {
        Value::List(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Decision K-J3.
    #[test]
    fn a_moment_is_told_apart_by_its_bits() {
        let moment = 1_700_000_000_u32;
        assert_eq!(DelayInterval::from_unix_time(moment).unix_time(), moment);
        assert!(!DelayInterval::from_unix_time(moment).is_float_time());
        let float = DelayInterval(0x4ECA_A7E2);
        assert!(float.is_float_time());
        assert_eq!(float.unix_time(), moment);
        assert_eq!([0x4E80_0000, 0x4EFF_FFFF].map(|bits| DelayInterval(bits).unix_time()), [1 << 30, 2_147_483_520]);
        assert_eq!([0x4E7F_FFFF, 0x4F00_0000].map(|bits| DelayInterval(bits).is_float_time()), [false; 2]);
        assert_eq!(DelayInterval::from_seconds(Seconds(30.0)).seconds(), Seconds(30.0));
    }
}
