//! Lights, outputs and inputs.

use core::fmt;

use motion_core::wire::Bool;
use motion_core::{__newtype, flags, message};

use super::{DmxChannel, set};

message! {
    /// Levels of neighbouring DMX channels. Source: DMC, MSG_DMX; decision D-50.
    #[derive(Default)]
    pub struct Dmx<'a> in LE {
        /// Whether the levels are reached by a ramp instead of at once.
        ramp: Bool,
        /// Channel of the first level.
        start_channel: DmxChannel,
        ;
        /// Levels, one for each channel.
        values: &'a [u8],
    }

    /// States of the general purpose outputs. Source: DMC, MSG_GIO_OUT.
    #[derive(Default)]
    pub struct GioOut<'a> in LE {
        /// Outputs that are on.
        triggers: Triggers,
    }

    /// Question which general purpose inputs are on. Source: DMC, MSG_GIO_IN.
    #[derive(Default)]
    pub struct GioInRequest<'a> in LE {}

    /// States of the general purpose inputs: an answer, or sent unasked when an input changes.
    ///
    /// Source: DMC, MSG_GIO_IN; decision D-15.
    #[derive(Default)]
    pub struct GioIn<'a> in LE {
        /// Inputs that are on.
        triggers: Triggers,
    }

    /// States of the outputs for the camera, to try them. Source: DMC, MSG_GIO_CAM.
    #[derive(Default)]
    pub struct GioCam<'a> in LE {
        /// Outputs that are on.
        flags: CameraFlags,
    }
}

flags! {
    /// Outputs for the camera. Unknown bits are kept.
    pub struct CameraFlags(u32) {
        /// Shutter of the camera.
        SHUTTER = 0x0000_0001,
        /// Light meter of the camera.
        METER = 0x0000_0002,
    }
}

/// Set of outputs or inputs, with one bit for each: bit 0 is number 1.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(transparent)]
pub struct Triggers(pub u32);

impl Triggers {
    /// Empty set.
    pub const NONE: Self = Self(0);

    /// Whether the output or input with a number, from 1, is in the set.
    #[must_use]
    pub fn contains(self, number: u8) -> bool {
        set::contains(self.0, number)
    }

    /// Numbers of the set, in their order.
    pub fn iter(self) -> impl Iterator<Item = u8> {
        set::numbers(self.0)
    }
}

impl FromIterator<u8> for Triggers {
    /// Makes the set of these numbers. Numbers outside 1 to 32 have no bit, and are left out.
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
