//! Lights, outputs and inputs.

use core::fmt;

use motion_core::wire::Bool;
use motion_core::{__newtype, flags, message};

use super::{DmxChannel, set};

message! {
    /// Set the levels of neighbouring DMX channels. Source: DMC, MSG_DMX; decision D-50.
    #[derive(Default)]
    pub struct Dmx<'a> in LE {
        /// Whether the levels are reached by a ramp, and not at once.
        ramp: Bool,
        /// The channel of the first level.
        start_channel: DmxChannel,
        ;
        /// One level a channel.
        values: &'a [u8],
    }

    /// Switch the general purpose outputs. Source: DMC, MSG_GIO_OUT.
    #[derive(Default)]
    pub struct GioOut<'a> in LE {
        /// The outputs that are on.
        triggers: Triggers,
    }

    /// Question which general purpose inputs are on. Source: DMC, MSG_GIO_IN.
    #[derive(Default)]
    pub struct GioInRequest<'a> in LE {}

    /// Which general purpose inputs are on: the answer, and sent unasked whenever it changes.
    ///
    /// Source: DMC, MSG_GIO_IN; decision D-15.
    #[derive(Default)]
    pub struct GioIn<'a> in LE {
        /// The inputs that are on.
        triggers: Triggers,
    }

    /// Try the outputs of the camera. Source: DMC, MSG_GIO_CAM.
    #[derive(Default)]
    pub struct GioCam<'a> in LE {
        /// The outputs that are on.
        flags: CameraFlags,
    }
}

flags! {
    /// The outputs of the camera. Unknown bits are kept.
    pub struct CameraFlags(u32) {
        /// The shutter.
        SHUTTER = 0x0000_0001,
        /// The meter.
        METER = 0x0000_0002,
    }
}

/// A set of outputs, or of inputs, one bit each: bit 0 is number 1.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(transparent)]
pub struct Triggers(pub u32);

impl Triggers {
    /// None of them.
    pub const NONE: Self = Self(0);

    /// Whether a number, from 1, is in it.
    #[must_use]
    pub fn contains(self, number: u8) -> bool {
        set::contains(self.0, number)
    }

    /// The numbers in it, one by one.
    pub fn iter(self) -> impl Iterator<Item = u8> {
        set::numbers(self.0)
    }
}

impl FromIterator<u8> for Triggers {
    /// Numbers that are not 1 to 32 have no bit, and are left out.
    fn from_iter<I: IntoIterator<Item = u8>>(numbers: I) -> Self {
        Self(set::of(numbers.into_iter()))
    }
}

impl fmt::Display for Triggers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        set::print(f, self.0)
    }
}

__newtype! { Triggers(u32) "" }

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bit_0_is_output_1() {
        let triggers: Triggers = [1, 3, 0, 33].into_iter().collect();
        assert_eq!((triggers, triggers.contains(3), triggers.contains(2)), (Triggers(5), true, false));
        assert!(triggers.iter().eq([1, 3]));
        assert_eq!(std::format!("{triggers}"), "1+3");
    }
}
