//! Values of the fields of blocks.

use core::fmt;

use motion_core::bezier::{self, OutOfRange};
use motion_core::wire::{Field, List, Reader, Value, Writer, print};
use motion_core::{__newtype, open_enum};
use zerocopy::ByteOrder;

use crate::message::{Normalized, Seconds};

open_enum! {
    /// Condition for the start of a move. Source: kOS, `TrajectoryData`.
    pub struct DelayMode(u8) {
        /// No delay.
        NONE = 0,
        /// Time to wait, in seconds.
        INTERVAL = 1,
        /// Moment to wait for (safety decision 5).
        UNTIL = 2,
    }
}

/// Number of times that a move is played again: 0 to 254, or 255 for ever (decision K-J4).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(transparent)]
pub struct LoopCount(pub u8);

impl LoopCount {
    /// No loop: the move is played once.
    pub const NONE: Self = Self(0);
    /// Loops until the move is stopped.
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

/// Time or moment that a move waits for: four bytes whose meaning depends on [`DelayMode`].
///
/// In the specification the field is an IEEE number, but a moment does not fit into one: as a float, Unix time has
/// steps of 128 seconds. So a moment is sent as an integer. That is also the safe mistake, because a device that reads
/// a float never starts. The bits of a received value show how it is written (decision K-J3, safety decision 5).
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
#[repr(transparent)]
pub struct DelayInterval(pub u32);

impl DelayInterval {
    /// Makes a time, for [`DelayMode::INTERVAL`].
    #[must_use]
    pub const fn from_seconds(seconds: Seconds) -> Self {
        Self(seconds.0.to_bits())
    }

    /// Makes a moment from seconds since 1970, for [`DelayMode::UNTIL`].
    #[must_use]
    pub const fn from_unix_time(seconds: u32) -> Self {
        Self(seconds)
    }

    /// Makes a moment from seconds since 1970 as an IEEE number, rounded to 128 seconds, for [`DelayMode::UNTIL`].
    ///
    /// Use it only for a device that is known to read an IEEE number, because a device that reads an integer starts at
    /// once (safety decision 5).
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "the rounding to 128 seconds is documented")]
    pub const fn from_unix_time_as_float(seconds: u32) -> Self {
        Self((seconds as f32).to_bits())
    }

    /// Time in seconds, for [`DelayMode::INTERVAL`].
    #[must_use]
    pub const fn seconds(self) -> Seconds {
        Seconds(f32::from_bits(self.0))
    }

    /// Whether a moment is written as an IEEE number. Such bits are a moment from 2004 to 2038 as a float. As an
    /// integer they would be a moment before the protocol was made.
    #[must_use]
    pub const fn is_float_time(self) -> bool {
        matches!(self.0, 0x4E80_0000..=0x4EFF_FFFF)
    }

    /// Moment in seconds since 1970, for [`DelayMode::UNTIL`], in either form.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a float time is a whole number of at most 31 bits"
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

/// Point of a curve: a time and a position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Point {
    /// Time: 0 is the start of the move, 1 its end.
    pub time: Normalized,
    /// Position: 0 is the begin of the motor's range, 1 its end.
    pub position: Normalized,
}

impl Point {
    /// Makes a point.
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

/// The four points of a curve: start, two handles, end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[repr(transparent)]
pub struct Points(pub [Point; 4]);

impl Points {
    /// Curve through the points, in parts of the move and of the motor's range.
    ///
    /// # Errors
    ///
    /// [`OutOfRange`] if a number is NaN or infinite.
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
    fn the_bits_of_a_moment_show_how_it_is_written() {
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
