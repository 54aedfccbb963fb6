//! Checks of messages that can be decoded, but that a strict peer would refuse, or that a careful sender would not
//! send.
//!
//! An error marks a message that a device refuses, ignores or answers with an error, or that may be dangerous. A
//! warning marks a value that is reserved, unknown, or probably not meant. Each rule names its decision.

mod device;
mod host;
mod trajectory;

use motion_core::lint::{Findings as _, Lints, Problem, Severity};
use motion_core::wire::{Bool, FieldView, Fields, Other, Password, Value};

use crate::message::{AxisKind, Motor, MotorAddress};

/// Knowledge of the peer that the checks use. The default knows nothing.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Context<'a> {
    /// Motors of the device, as it reported them last; empty if they are not known.
    pub motors: &'a [Motor],
    /// Kinds of axis that the motors turn, as far as they are known. The specification has limits for each kind of axis
    /// (decision K-M6).
    pub kinds: &'a [(MotorAddress, AxisKind)],
    /// Whether the device is known to count the bytes of a text and not its characters. Passwords then need not be
    /// ASCII (decision K-T1).
    pub counts_bytes: bool,
}

impl<'a> Context<'a> {
    /// Context with these motors of the device.
    #[must_use]
    pub const fn with_motors(self, motors: &'a [Motor]) -> Self {
        Self { motors, ..self }
    }

    /// Context with the kinds of axis that the motors turn.
    #[must_use]
    pub const fn with_kinds(self, kinds: &'a [(MotorAddress, AxisKind)]) -> Self {
        Self { kinds, ..self }
    }

    /// Context of a device that counts the bytes of a text.
    #[must_use]
    pub const fn with_byte_counts(self) -> Self {
        Self { counts_bytes: true, ..self }
    }

    /// Motor as the device reported it last; `None` if it is not known.
    pub(crate) fn motor(&self, address: MotorAddress) -> Option<&'a Motor> {
        self.motors.iter().find(|known| known.motor_address.number() == address.number())
    }

    /// Kind of axis that a motor turns; `None` if it is not known.
    pub(crate) fn kind(&self, address: MotorAddress) -> Option<AxisKind> {
        let known = self.kinds.iter().find(|(known, _)| known.number() == address.number());
        known.map(|(_, kind)| *kind)
    }
}

/// Length of the longest password with which `DeviceInfo` fits into one USB report, in bytes (decision K-T4).
const LONG_PASSWORD: usize = 32;

/// Checks all fields for tails (decision K-F4), and for numbers that are NaN or infinite (decision K-N1).
fn common(lints: &mut Lints, fields: &dyn Fields, non_finite: Severity) {
    fields.fields(&mut |field: &FieldView<'_>| match field.value {
        Value::Bytes(tail) if field.name == "tail" => lints.tail(tail),
        value => finite(lints, field.name, value, non_finite),
    });
}

fn finite(lints: &mut Lints, what: &'static str, value: Value<'_>, severity: Severity) {
    match value {
        Value::Float(number) if !number.is_finite() => lints.push(severity, what, Problem::NonFinite(number.to_bits())),
        Value::List(list) => list.each(&mut |value| finite(lints, what, value, severity)),
        Value::Group(fields) => common(lints, fields, severity),
        _ => {}
    }
}

/// Checks a number that cannot be negative (decision K-N1).
fn not_negative(lints: &mut Lints, what: &'static str, number: f32) {
    if number < 0.0 {
        lints.note(Severity::Error, what, "is negative");
    }
}

/// Checks a part of a whole, which is 0 to 1 (decision K-P7).
fn part_of_one(lints: &mut Lints, what: &'static str, number: f32) {
    if number.is_finite() && !(0.0..=1.0).contains(&number) {
        lints.note(Severity::Warning, what, "is not in 0 to 1");
    }
}

/// Checks the byte of a `Bool`, which is 0 or 1 (decision K-Q1).
fn yes_or_no(lints: &mut Lints, what: &'static str, value: Bool) {
    lints.reserved(what, value.0, !1_u8);
}

/// Checks a byte that the specification sets to 0.
fn zero(lints: &mut Lints, what: &'static str, byte: u8) {
    lints.reserved(what, byte, u8::MAX);
}

/// Checks the address of a motor, which is `least` to 10 (decision K-M1).
fn address(lints: &mut Lints, motor: MotorAddress, least: u8) {
    lints.range("motor_address", motor.number(), least, MotorAddress::LAST.0);
}

/// Checks a password. A peer may count its length in characters, or end it at the first NUL (decisions K-T1, K-T2,
/// K-T4).
fn password(lints: &mut Lints, what: &'static str, password: Password<'_>, ascii: Severity) {
    let Password(bytes) = password;
    if !bytes.is_ascii() {
        lints.note(ascii, what, "is not ASCII: the device may count characters instead of bytes");
    }
    if bytes.contains(&0) {
        lints.note(Severity::Warning, what, "contains a NUL, which may end it");
    }
    if bytes.len() > LONG_PASSWORD {
        lints.note(Severity::Warning, what, "is longer than 32 bytes: DeviceInfo does not fit into one USB report");
    }
}

/// Warns of a message that the specification does not name (decision K-F6).
fn unknown(lints: &mut Lints, other: &Other<'_>) {
    lints.push(Severity::Warning, "message", Problem::Unnamed(other.id()));
}
