//! What a simulated device is made of.

use dmc_proto::device::{Options, Quirks};
use dmc_proto::message::{Acceleration, Capabilities, Hi, MotorFlags, Name, Speed, Steps};
use motion_core::profile::Limits;
use motion_core::trajectory::Range;

use crate::motor::Motor;

/// What a device is made of.
#[derive(Debug, Clone)]
pub struct Setup {
    /// What it says of itself, its quirks and its times. How many motors it has is for [`motors`](Self::motors) to say.
    pub options: Options,
    /// Its motors, 32 at most, with what they can and where the limit switches are.
    pub motors: Vec<Motor>,
}

/// What was set of a motor: forgotten at a reset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tuning {
    /// What it is used for.
    pub flags: MotorFlags,
    /// Its greatest speed.
    pub speed: Speed,
    /// Its greatest acceleration.
    pub acceleration: Acceleration,
    /// The lower limit that was set.
    pub lower: Option<Steps>,
    /// The upper limit that was set.
    pub upper: Option<Steps>,
}

impl Setup {
    /// What each motor can: 50,000 steps a second, after half a second.
    pub const LIMITS: Limits = Limits { velocity: 50_000.0, acceleration: 100_000.0, jerk: None };
    /// Where the limit switches of each motor are, in steps.
    pub const TRAVEL: Range = Range::new(-200_000.0, 200_000.0);
    /// Frames that can be uploaded: as many as the vendor's firmware says.
    pub const FRAMES: u32 = 10_000;

    /// A device with this many motors, 32 at most, all alike. It can do all but virtual motors.
    #[must_use]
    pub fn with_motors(motors: u8) -> Self {
        let capabilities = Capabilities::REAL_TIME
            | Capabilities::SHOOT_FRAME
            | Capabilities::SHOOT_FRAME2
            | Capabilities::LOOP
            | Capabilities::CAMERA_TRIGGER;
        let hi = Hi {
            name: Name::truncated("Simulated DMC"),
            fw_major: 1,
            dmx_count: 16,
            gio_out_count: 8,
            gio_in_count: 8,
            hw_limit_count: motors.min(32),
            upload_frame_count: Self::FRAMES,
            capabilities,
            ..Options::default().hi
        };
        let motor = Motor::new(Self::LIMITS).within(Self::TRAVEL);
        Self { options: Options::of(hi), motors: vec![motor; motors.min(32).into()] }
    }

    /// The same, with these quirks.
    #[must_use]
    pub fn with_quirks(mut self, quirks: Quirks) -> Self {
        self.options = self.options.with_quirks(quirks);
        self
    }

    /// The same, with room for this many frames of a move.
    #[must_use]
    pub fn with_frames(mut self, frames: u32) -> Self {
        self.options.hi.upload_frame_count = frames;
        self
    }
}

impl Default for Setup {
    /// Four motors.
    fn default() -> Self {
        Self::with_motors(4)
    }
}

impl Tuning {
    /// What holds before anything is set: all that the motor can, but for half of its acceleration, which is left for
    /// stops that have to be harder.
    pub(super) fn of(motor: &Motor) -> Self {
        let limits = motor.limits();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "cut to what fits")]
        let whole = |value: f64| value.round().clamp(1.0, f64::from(u32::MAX)) as u32;
        Self {
            flags: MotorFlags::ENABLED,
            speed: Speed(whole(limits.velocity)),
            acceleration: Acceleration(whole(limits.acceleration / 2.0)),
            lower: None,
            upper: None,
        }
    }
}
