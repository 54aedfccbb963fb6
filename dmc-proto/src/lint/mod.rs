//! Findings about messages that decode, but that a strict peer would refuse, or a careful sender would not send.
//!
//! Decoding accepts all values; these rules say what is wrong with them. The rules know ranges and reserved bits from the
//! specification. They know the motors, channels and capabilities of a device from its greeting, if it is given.
//!
//! ```
//! use dmc_proto::lint::Context;
//! use dmc_proto::message::{Motor, MotorMove, Steps};
//! use dmc_proto::{HostMessage, MessageId};
//!
//! let message = HostMessage::from(MotorMove { motor: Motor(0), position: Steps(500), tail: &[] });
//! let context = Context::default();
//! assert_eq!(message.lint(&context).as_slice()[0].to_string(), "motor: 0 is not in 1 to 32");
//!
//! let mut out = [0; 64];
//! assert!(message.encode_checked(MessageId(1), &context, &mut out).is_err());
//! ```

mod device;
mod host;
mod rules;

use motion_core::lint::{Findings, Lints, Severity};
use motion_core::wire::bitflags::Flags;
use motion_core::wire::{Bool, FieldView, Fields, Value};

use crate::frame::{self, MessageType};
use crate::message::{Hi, Motor};

/// Greatest number of motors: a status has one bit for each (decision D-44).
const MAX_MOTORS: u8 = 32;
/// Number of channels of a DMX universe.
const MAX_CHANNELS: u16 = 512;
/// Greatest number of outputs, inputs or sets of limit switches.
const MAX_PINS: u8 = 32;
/// Version of the protocol.
const PROTOCOL_VERSION: u16 = 2;
/// Greatest type of a message that the vendor's firmware accepts (decision D-11).
const MAX_TYPE: u16 = 0x03FF;

/// Knowledge of a sender about its receiver. By default, nothing is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Context<'a> {
    /// Greeting of the device. Without it, only those findings are reported that hold for every device.
    pub device: Option<Hi<'a>>,
    /// Greatest number of bytes of data that the receiver accepts. The default is 1036 (decision D-10).
    pub max_data: usize,
}

impl<'a> Context<'a> {
    /// Context for messages to or from a device with this greeting.
    #[must_use]
    pub const fn of(device: Hi<'a>) -> Self {
        Self { device: Some(device), max_data: frame::MAX_DATA }
    }
}

impl Default for Context<'_> {
    fn default() -> Self {
        Self { device: None, max_data: frame::MAX_DATA }
    }
}

/// Findings of one message while its fields are checked, and the context of the check.
struct Rules<'c, F = Lints> {
    found: F,
    context: &'c Context<'c>,
}

impl<'c, F: Findings + Default> Rules<'c, F> {
    fn new(context: &'c Context<'c>) -> Self {
        Self { found: F::default(), context }
    }
}

impl<F: Findings> Rules<'_, F> {
    /// Checks the number of bytes of data.
    fn data(&mut self, len: usize) {
        self.found.range("data", number(len), 0, number(self.context.max_data));
    }

    fn error(&mut self, what: &'static str, note: &'static str) {
        self.found.note(Severity::Error, what, note);
    }

    fn warning(&mut self, what: &'static str, note: &'static str) {
        self.found.note(Severity::Warning, what, note);
    }

    /// Number of motors, as far as is known.
    fn motor_count(&self) -> u8 {
        self.context.device.map_or(MAX_MOTORS, |device| device.motor_count.min(MAX_MOTORS))
    }

    /// Number of DMX channels, as far as is known.
    fn channel_count(&self) -> u16 {
        self.context.device.map_or(MAX_CHANNELS, |device| device.dmx_count.min(MAX_CHANNELS))
    }

    /// Number of general purpose outputs, as far as is known.
    fn output_count(&self) -> u8 {
        self.context.device.map_or(MAX_PINS, |device| device.gio_out_count.min(MAX_PINS))
    }

    /// Number of general purpose inputs, as far as is known.
    fn input_count(&self) -> u8 {
        self.context.device.map_or(MAX_PINS, |device| device.gio_in_count.min(MAX_PINS))
    }

    fn motor(&mut self, motor: Motor) {
        self.found.range("motor", motor.0, 1, self.motor_count());
    }

    /// Checks a byte that should be 0 or 1.
    fn yes_or_no(&mut self, what: &'static str, answer: Bool) {
        if answer.0 > 1 {
            self.warning(what, "neither 0 nor 1; it counts as 1");
        }
    }

    /// Checks for bits without a name.
    fn bits(&mut self, what: &'static str, flags: impl Flags<Bits: Into<u32>> + Copy) {
        if !F::KEEPS_WARNINGS {
            return;
        }
        let mut names = flags.iter_names();
        names.by_ref().for_each(drop);
        self.found.reserved(what, names.remaining().bits(), u32::MAX);
    }

    /// Checks for bytes after the known fields (decision D-51).
    fn tail(&mut self, message: &dyn Fields) {
        message.fields(&mut |field: &FieldView<'_>| {
            if let ("tail", Value::Bytes(tail)) = (field.name, field.value) {
                self.found.tail(tail);
            }
        });
    }

    /// Checks an unknown type.
    fn unknown(&mut self, kind: MessageType) {
        if kind.request().0 > MAX_TYPE {
            self.error("type", "the vendor's firmware ignores frames of types above 0x03ff");
        } else {
            self.found.named("type", kind.0, None);
        }
    }
}

/// Count as a number of findings.
fn number(count: usize) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}
