//! What decodes, but a strict peer would refuse, or a wise sender would not send.
//!
//! Decoding takes everything; these rules say what is wrong with it. They know ranges and reserved bits from the
//! specification, and the motors, channels and capabilities of a device from its greeting, if there was one.
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

use motion_core::lint::{Lints, Severity};
use motion_core::wire::bitflags::Flags;
use motion_core::wire::{Bool, FieldView, Fields, Value};

use crate::frame::{self, MessageType};
use crate::message::{Hi, Motor};

/// Motors that the specification allows: a status has a bit for each (decision D-44).
const MAX_MOTORS: u8 = 32;
/// Channels of a DMX universe.
const MAX_CHANNELS: u16 = 512;
/// Outputs, inputs or sets of limit switches that the specification allows.
const MAX_PINS: u8 = 32;
/// The version of the protocol that this is.
const PROTOCOL_VERSION: u16 = 2;
/// The greatest type that the vendor's own firmware takes for a header (decision D-11).
const MAX_TYPE: u16 = 0x03FF;

/// What the sender of a message knows of its receiver: nothing, unless told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Context<'a> {
    /// What the device said of itself. Without it, only those findings come up that hold for every device.
    pub device: Option<Hi<'a>>,
    /// Bytes of data that the receiver takes, 1036 unless told otherwise (decision D-10).
    pub max_data: usize,
}

impl<'a> Context<'a> {
    /// For messages to a device that said this of itself, or from it.
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

/// The findings of one message, while its fields are looked at, and what they are measured by.
struct Rules<'c> {
    found: Lints,
    context: &'c Context<'c>,
}

impl<'c> Rules<'c> {
    /// Begins with what holds for all messages: how long they are.
    fn new(context: &'c Context<'_>, len: usize) -> Self {
        let mut found = Lints::new();
        found.range("data", number(len), 0, number(context.max_data));
        Self { found, context }
    }

    fn error(&mut self, what: &'static str, note: &'static str) {
        self.found.note(Severity::Error, what, note);
    }

    fn warning(&mut self, what: &'static str, note: &'static str) {
        self.found.note(Severity::Warning, what, note);
    }

    /// Motors that there are, as far as is known.
    fn motor_count(&self) -> u8 {
        self.context.device.map_or(MAX_MOTORS, |device| device.motor_count.min(MAX_MOTORS))
    }

    /// DMX channels that there are, as far as is known.
    fn channel_count(&self) -> u16 {
        self.context.device.map_or(MAX_CHANNELS, |device| device.dmx_count.min(MAX_CHANNELS))
    }

    /// General purpose outputs that there are, as far as is known.
    fn output_count(&self) -> u8 {
        self.context.device.map_or(MAX_PINS, |device| device.gio_out_count.min(MAX_PINS))
    }

    /// General purpose inputs that there are, as far as is known.
    fn input_count(&self) -> u8 {
        self.context.device.map_or(MAX_PINS, |device| device.gio_in_count.min(MAX_PINS))
    }

    fn motor(&mut self, motor: Motor) {
        self.found.range("motor", motor.0, 1, self.motor_count());
    }

    /// One byte that should be 0 or 1.
    fn yes_or_no(&mut self, what: &'static str, answer: Bool) {
        if answer.0 > 1 {
            self.warning(what, "neither 0 nor 1; it counts as a yes");
        }
    }

    /// Bits without a name.
    fn bits<F: Flags<Bits: Into<u32>> + Copy>(&mut self, what: &'static str, flags: F) {
        let mut names = flags.iter_names();
        names.by_ref().for_each(drop);
        self.found.reserved(what, names.remaining().bits(), u32::MAX);
    }

    /// Bytes behind the known fields (decision D-51).
    fn tail(&mut self, message: &dyn Fields) {
        message.fields(&mut |field: &FieldView<'_>| {
            if let ("tail", Value::Bytes(tail)) = (field.name, field.value) {
                self.found.tail(tail);
            }
        });
    }

    /// A type of nobody's: whether the receiver sees it at all.
    fn unknown(&mut self, kind: MessageType) {
        if kind.request().0 > MAX_TYPE {
            self.error("type", "the vendor's firmware drops frames of types above 0x03ff unseen");
        } else {
            self.found.named("type", kind.0, None);
        }
    }
}

/// A count, as findings have it.
fn number(count: usize) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}
