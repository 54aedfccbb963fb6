//! Properties of a simulated device.

use dmc_proto::Patience;
use dmc_proto::device::{Options, Quirks};
use dmc_proto::message::{Acceleration, Capabilities, Hi, MotorFlags, Name, Speed, Steps};
use motion_core::profile::Limits;
use motion_core::trajectory::Range;

use crate::motor::Motor;

/// Properties of a simulated device.
#[derive(Debug, Clone)]
pub struct Setup {
    /// Greeting, quirks and times. The number of motors in the greeting is replaced by that of [`motors`](Self::motors).
    pub options: Options,
    /// Motors with their limits and their limit switches, 32 at most.
    pub motors: Vec<Motor>,
    /// Time that the device waits for the end of a frame.
    pub patience: Patience,
    /// Differences of the device from the specification that its machine does not know.
    pub facts: Facts,
}

/// Differences of a device from the specification: those of its motors and of its reader. The others are
/// [`Quirks`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "each one is a fact of its own")]
pub struct Facts {
    /// Greatest speed and acceleration of each motor after a reset; `None` for the speed of the motor itself, and half of its
    /// acceleration.
    pub tuned: Option<(Speed, Acceleration)>,
    /// Uses of each motor after a reset. A motor without [`MotorFlags::ENABLED`] gets no pulses, except as
    /// [`moves_disabled`](Self::moves_disabled) says: the device counts its ways, and the motor does not move. A motor without [`MotorFlags::BLUR`] rests in a shot.
    pub uses: MotorFlags,
    /// Whether a motor that is not enabled moves by a move or a jog of its own, and rests only when all motors move together.
    pub moves_disabled: bool,
    /// Whether the begin of an upload gives each motor a path of zeros, so that all enabled motors are part of the move.
    pub fills_with_zeros: bool,
    /// Whether a motor that blurs follows the uploaded move in a shot without ways.
    pub blurs_along_move: bool,
    /// Time after which a jog slows down by itself, in milliseconds. A jog to the other side only stops the motor.
    pub jog_lasts: Option<u64>,
    /// Whether the status tells which motors move at this moment, instead of all that take part.
    pub tells_each_motor: bool,
    /// Whether the time that is sent with positions is that of the last run, shot or jog of all motors, and not the frame on
    /// which the motors are.
    pub keeps_time: bool,
    /// Whether only motors with blur move in a shot, even to its start. They need a second to reach their speed; in a shot with
    /// angles an eighth of the time between its positions, and they rest at these.
    pub vendor_shots: bool,
    /// Whether a jog of all motors changes its speed by four frames per second in a second, and a stop of it ends on a frame.
    pub vendor_jog_all: bool,
    /// Whether a run begins with a jog of all motors to its first frame.
    ///
    /// When a jog of all motors ends, also by a stop, the motors then go to the start of the last run or shot. This holds if
    /// that run or shot was refused because of a limit, or if it was prepared and is neither done nor stopped.
    pub jogs_to_run: bool,
    /// Whether data that is missing at the end of a request counts as zeros. Only a move and a new position have to have their
    /// length. Requests of types that the vendor does not use are not answered, and acknowledgements are refused.
    pub vendor_parser: bool,
    /// Types of requests that the device does not know, although the document has them.
    pub unknown: &'static [u16],
    /// Whether a stop in a shot leaves the shutter open.
    pub leaves_shutter_open: bool,
    /// Whether everything except the start and the end of a run passes limits that were set.
    pub ignores_limits: bool,
    /// Whether a position is sent a step too near to 0, because its fraction is cut off. Such a device counts in
    /// single-precision numbers.
    pub truncates: bool,
    /// Whether a frame is damaged if its check bytes are not the ones that the device would write.
    pub compares_check: bool,
    /// Whether a damaged frame is dropped with everything in it.
    pub drops_damaged: bool,
    /// Whether the device greets at the first byte that arrives, and not before.
    pub is_silent_at_boot: bool,
}

impl Facts {
    /// Facts of a device as the document describes it, whose motors are all enabled.
    pub const MILD: Self = Self {
        tuned: None,
        uses: MotorFlags::ENABLED.union(MotorFlags::BLUR),
        moves_disabled: false,
        fills_with_zeros: false,
        blurs_along_move: false,
        jog_lasts: None,
        tells_each_motor: false,
        keeps_time: false,
        vendor_shots: false,
        vendor_jog_all: false,
        jogs_to_run: false,
        vendor_parser: false,
        unknown: &[],
        leaves_shutter_open: false,
        ignores_limits: false,
        truncates: false,
        compares_check: false,
        drops_damaged: false,
        is_silent_at_boot: false,
    };
}

/// Settings of a motor. A reset makes them new.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tuning {
    /// Uses of the motor.
    pub flags: MotorFlags,
    /// Greatest speed.
    pub speed: Speed,
    /// Greatest acceleration.
    pub acceleration: Acceleration,
    /// Lower limit, if one was set.
    pub lower: Option<Steps>,
    /// Upper limit, if one was set.
    pub upper: Option<Steps>,
}

impl Setup {
    /// Limits of each motor: 50,000 steps per second, reached after half a second.
    pub const LIMITS: Limits = Limits { velocity: 50_000.0, acceleration: 100_000.0, jerk: None };
    /// Positions of the limit switches of each motor, in steps.
    pub const TRAVEL: Range = Range::new(-200_000.0, 200_000.0);
    /// Number of frames that can be uploaded, as in the vendor's firmware.
    pub const FRAMES: u32 = 10_000;

    /// Device with this number of equal motors, 32 at most. It has every capability except virtual motors.
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
            ..Options::default().hi()
        };
        let motor = Motor::new(Self::LIMITS).within(Self::TRAVEL);
        let patience = Patience::new().with_margin(250);
        Self { options: Options::of(hi), motors: vec![motor; motors.min(32).into()], patience, facts: Facts::MILD }
    }

    /// Returns the setup with these quirks of the machine.
    #[must_use]
    pub fn with_machine_quirks(mut self, quirks: Quirks) -> Self {
        self.options = self.options.with_quirks(quirks);
        self
    }

    /// Returns the setup with room for this number of frames of a move.
    #[must_use]
    pub fn with_frames(self, frames: u32) -> Self {
        self.with_hi(|hi| hi.upload_frame_count = frames)
    }

    /// Returns the setup with these capabilities.
    #[must_use]
    pub fn with_capabilities(self, capabilities: Capabilities) -> Self {
        self.with_hi(|hi| hi.capabilities = capabilities)
    }

    pub(super) fn with_hi(mut self, change: impl FnOnce(&mut Hi<'static>)) -> Self {
        let mut hi = self.options.hi();
        change(&mut hi);
        self.options = self.options.with_hi(hi);
        self
    }
}

impl Default for Setup {
    /// Device with four motors.
    fn default() -> Self {
        Self::with_motors(4)
    }
}

impl Tuning {
    /// Settings of a new motor: its whole speed, and half of its acceleration. The other half is left for harder stops.
    pub(super) fn of(motor: &Motor, facts: &Facts) -> Self {
        let (limits, flags) = (motor.limits(), facts.uses);
        if let Some((speed, acceleration)) = facts.tuned {
            return Self { flags, speed, acceleration, lower: None, upper: None };
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the value is clamped")]
        let whole = |value: f64| value.round().clamp(1.0, f64::from(u32::MAX)) as u32;
        Self {
            flags,
            speed: Speed(whole(limits.velocity)),
            acceleration: Acceleration(whole(limits.acceleration / 2.0)),
            lower: None,
            upper: None,
        }
    }
}
