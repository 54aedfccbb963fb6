//! Setup of a simulated node.

use hoot_proto::device;
use motion_core::profile::Limits;
use motion_core::trajectory::Range;

/// Setup of a simulated node, from the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setup {
    /// Options of the machine: address, name, firmware and quirks.
    pub options: device::Options,
    /// Number of motors that are plugged in, from motor 1 on: at most 3. A node has three motors; one that is not plugged
    /// in fails when it has to move.
    pub motors: u8,
    /// Limits of each motor, in microsteps per second, at quarter steps, which are the setting of a new node.
    pub limits: Limits,
    /// Ends of the rig, in microsteps from the first position of the motors, at quarter steps. A motor that reaches an end
    /// stops at once, and fails.
    pub travel: Range,
}

impl Default for Setup {
    /// A new node with three motors, which can move by 50,000 steps in each direction.
    fn default() -> Self {
        Self {
            options: device::Options::default(),
            motors: 3,
            limits: Limits { velocity: 5000.0, acceleration: 20_000.0, jerk: None },
            travel: Range::new(-200_000.0, 200_000.0),
        }
    }
}

impl Setup {
    /// A node with this number of motors, at most 3.
    #[must_use]
    pub fn with_motors(count: u8) -> Self {
        Self { motors: count.min(3), ..Self::default() }
    }

    /// Returns the setup with other options of the machine.
    #[must_use]
    pub const fn with_options(self, options: device::Options) -> Self {
        Self { options, ..self }
    }

    /// Returns the setup with other ends of the rig.
    #[must_use]
    pub const fn with_travel(self, travel: Range) -> Self {
        Self { travel, ..self }
    }
}
