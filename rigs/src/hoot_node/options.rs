//! What a simulated node is.

use hoot_proto::device;
use motion_core::profile::Limits;
use motion_core::trajectory::Range;

/// What a simulated node is, from the start on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Its address, name, firmware and habits.
    pub device: device::Options,
    /// How many motors are plugged in, from motor 1 on: at most 3. A node knows three; one that is not there fails as
    /// soon as it is to move.
    pub motors: u8,
    /// What each motor can do, in microsteps a second, at quarter steps, which a new node has.
    pub limits: Limits,
    /// Where the rig ends, in microsteps from where the motors are at first, at quarter steps. A motor that gets there
    /// stops dead, and fails.
    pub travel: Range,
}

impl Default for Options {
    /// A new node with three motors on rigs of 50,000 steps each way.
    fn default() -> Self {
        Self {
            device: device::Options::default(),
            motors: 3,
            limits: Limits { velocity: 5000.0, acceleration: 20_000.0, jerk: None },
            travel: Range::new(-200_000.0, 200_000.0),
        }
    }
}

impl Options {
    /// The same with other options of the device machine.
    #[must_use]
    pub const fn with_device(self, device: device::Options) -> Self {
        Self { device, ..self }
    }

    /// The same with so many motors, at most 3.
    #[must_use]
    pub const fn with_motors(self, motors: u8) -> Self {
        Self { motors: if motors > 3 { 3 } else { motors }, ..self }
    }

    /// The same with other ends.
    #[must_use]
    pub const fn with_travel(self, travel: Range) -> Self {
        Self { travel, ..self }
    }
}
