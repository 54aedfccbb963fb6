//! Findings about messages that decode, but that a strict peer would refuse, or a careful sender would not send.
//!
//! Decoding accepts every message; these rules find what is wrong with it. They come from the behaviour of firmware,
//! which drops the top byte of numbers, reads missing bytes as zero, and acknowledges many messages that it ignores.
//!
//! ```
//! use hoot_proto::lint::Context;
//! use hoot_proto::message::{Direction, Motor, MotorMove, StepCount};
//! use hoot_proto::{Address, HostMessage};
//!
//! // Firmware would read 0 steps, which is a run without end.
//! let motion = MotorMove { motor: Motor::One, direction: Direction(0), steps: StepCount(16_777_216) };
//! let message = HostMessage::from(motion);
//! let context = Context::default();
//! assert_eq!(message.lint(&context).as_slice()[0].to_string(), "steps: 16777216 is not in 1 to 16777215");
//!
//! let mut out = [0; 64];
//! assert!(message.encode_checked(Address::DEFAULT, &context, &mut out).is_err());
//! ```

#[cfg(feature = "beyond")]
mod beyond;
mod device;
mod host;
mod rules;

use motion_core::lint::{Findings as _, Lints, Severity};

use crate::frame::MAX_DATA;
use crate::message::{Motor, StepsPerSecond};
use crate::query::Profile;

/// Knowledge of the caller about the bus and its nodes. By default nothing is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Context {
    /// Whether the bus is behind a bridge, which is the USB or Bluetooth port of a node.
    pub bridge: bool,
    /// Continuous speeds that the motors of the node were given, from motor 1 on, if they are known.
    pub speeds: [Option<StepsPerSecond>; 3],
    /// Whether the node is in joystick mode.
    pub joystick: bool,
    /// Whether the planned move runs.
    pub running: bool,
    /// Firmware of the node.
    pub profile: Profile,
}

impl Context {
    /// A bus behind a bridge.
    #[must_use]
    pub fn through_bridge() -> Self {
        Self { bridge: true, ..Self::default() }
    }

    /// Whether a motor is known to have the speed 0.
    fn is_still(&self, motor: Motor) -> bool {
        Motor::ALL
            .iter()
            .zip(self.speeds)
            .any(|(one, speed)| *one == motor && speed.is_some_and(|speed| speed.0 == 0.0))
    }
}

/// Findings about one message while its fields are checked, and the context.
struct Rules<'c> {
    found: Lints,
    context: &'c Context,
}

impl<'c> Rules<'c> {
    fn new(context: &'c Context) -> Self {
        Self { found: Lints::new(), context }
    }

    fn error(&mut self, what: &'static str, note: &'static str) {
        self.found.note(Severity::Error, what, note);
    }

    fn warning(&mut self, what: &'static str, note: &'static str) {
        self.found.note(Severity::Warning, what, note);
    }

    /// Section 1: firmware has no room for more data, and does not check.
    fn length(&mut self, data: &[u8]) {
        let number = |count| i64::try_from(count).unwrap_or(i64::MAX);
        self.found.range("data", number(data.len()), 0, number(MAX_DATA));
    }
}
