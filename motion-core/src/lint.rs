//! Findings about messages that decode, although a strict peer would refuse them or a careful sender would not send
//! them.
//!
//! Decoders accept everything and lose nothing. Whether a message is sensible is a separate question, and each protocol
//! crate answers it with a `lint` for each of its messages. The types of the answers are in this module.

use core::fmt;

use arrayvec::ArrayVec;

use crate::bezier::print::debug_as_text;

/// Severity of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// The message is legal, but rarely intended.
    Warning,
    /// A strict peer refuses the message, or does something else than the message says.
    Error,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Warning => "warning",
            Self::Error => "error",
        })
    }
}

/// One finding about a message.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Lint {
    /// Severity of the finding.
    pub severity: Severity,
    /// Name of the field in the layout, or of the message.
    pub what: &'static str,
    /// Problem that was found.
    pub problem: Problem,
}

/// Problem of a field or of a message.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Problem {
    /// The number is outside its range.
    Range {
        /// The number of the field.
        value: i64,
        /// Least number that is allowed.
        min: i64,
        /// Greatest number that is allowed.
        max: i64,
    },
    /// Bits are set that the specification reserves or does not name.
    ReservedBits(u32),
    /// The specification does not name the number.
    Unnamed(u32),
    /// The IEEE number with these bits is NaN or infinite.
    NonFinite(u32),
    /// This number of bytes follows the known fields.
    Tail(usize),
    /// Another problem, in one sentence.
    Note(&'static str),
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range { value, min, max } => write!(f, "{value} is not in {min} to {max}"),
            Self::ReservedBits(bits) => write!(f, "reserved bits {bits:#x} are set"),
            Self::Unnamed(number) => write!(f, "{number} has no meaning in the specification"),
            Self::NonFinite(bits) => write!(f, "{bits:#010x} is no finite number"),
            Self::Tail(bytes) => write!(f, "{bytes} bytes after the known fields"),
            Self::Note(note) => f.write_str(note),
        }
    }
}

impl fmt::Display for Lint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.what, self.problem)
    }
}

debug_as_text! { Problem }

// A derived `Debug` would print texts with escapes, which cannot be proven free of panics.
impl fmt::Debug for Lint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Lint({}: {self})", self.severity)
    }
}

/// Collector of findings: [`Lints`] keep them, and a receiver may keep less.
///
/// Rules that are written for any collector cost a receiver only what it keeps.
pub trait Findings {
    /// Whether warnings are kept. Rules need not look for what is not kept.
    const KEEPS_WARNINGS: bool = true;

    /// Adds a finding.
    fn push(&mut self, severity: Severity, what: &'static str, problem: Problem);

    /// Adds an error if `value` is not in `min` to `max`.
    fn range(&mut self, what: &'static str, value: impl Into<i64>, min: impl Into<i64>, max: impl Into<i64>) {
        let (value, min, max) = (value.into(), min.into(), max.into());
        if value < min || value > max {
            self.push(Severity::Error, what, Problem::Range { value, min, max });
        }
    }

    /// Adds a warning if any of the `reserved` bits is set.
    fn reserved(&mut self, what: &'static str, bits: impl Into<u32>, reserved: impl Into<u32>) {
        let set = bits.into() & reserved.into();
        if set != 0 {
            self.push(Severity::Warning, what, Problem::ReservedBits(set));
        }
    }

    /// Adds an error if `number` is NaN or infinite.
    fn finite(&mut self, what: &'static str, number: f32) {
        if !number.is_finite() {
            self.push(Severity::Error, what, Problem::NonFinite(number.to_bits()));
        }
    }

    /// Adds a warning if the number of an open enum has no name.
    fn named(&mut self, what: &'static str, number: impl Into<u32>, name: Option<&'static str>) {
        if name.is_none() {
            self.push(Severity::Warning, what, Problem::Unnamed(number.into()));
        }
    }

    /// Adds a warning if there are bytes after the known fields.
    fn tail(&mut self, tail: &[u8]) {
        if !tail.is_empty() {
            self.push(Severity::Warning, "tail", Problem::Tail(tail.len()));
        }
    }

    /// Adds a finding in one sentence.
    fn note(&mut self, severity: Severity, what: &'static str, note: &'static str) {
        self.push(severity, what, Problem::Note(note));
    }
}

/// Greatest number of findings that are kept of one message. If there are more, the last one is a note that says so.
pub const MAX_LINTS: usize = 16;

/// The findings of one message, in the order of its fields.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Lints {
    found: ArrayVec<Lint, MAX_LINTS>,
}

impl Lints {
    /// An empty collection of findings.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The findings as a slice.
    #[must_use]
    pub fn as_slice(&self) -> &[Lint] {
        &self.found
    }

    /// The first finding of severity `Error`.
    #[must_use]
    pub fn first_error(&self) -> Option<Lint> {
        self.found.iter().copied().find(|lint| lint.severity == Severity::Error)
    }
}

impl Findings for Lints {
    /// Adds a finding. If there are too many, the last one is replaced by a note with the greatest severity of those
    /// left out.
    fn push(&mut self, severity: Severity, what: &'static str, problem: Problem) {
        if self.found.try_push(Lint { severity, what, problem }).is_err() {
            if let Some(last) = self.found.last_mut() {
                let severity = severity.max(last.severity);
                *last = Lint { severity, what: "message", problem: Problem::Note("and more findings") };
            }
        }
    }
}

impl IntoIterator for Lints {
    type Item = Lint;
    type IntoIter = arrayvec::IntoIter<Lint, MAX_LINTS>;

    fn into_iter(self) -> Self::IntoIter {
        self.found.into_iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;
    use std::vec::Vec;

    #[test]
    fn findings_keep_their_order_and_name_the_problem() {
        let mut lints = Lints::new();
        lints.range("motor", 33, 1, 32);
        lints.range("motor", 32, 1, 32);
        lints.reserved("flags", 0x81_u8, 0x80_u8);
        lints.finite("speed", f32::NAN);
        lints.named("code", 7_u16, None);
        lints.tail(&[1, 2]);
        let texts: Vec<_> = lints.clone().into_iter().map(|lint| format!("{} {lint}", lint.severity)).collect();
        assert_eq!(
            texts,
            [
                "error motor: 33 is not in 1 to 32",
                "warning flags: reserved bits 0x80 are set",
                "error speed: 0x7fc00000 is no finite number",
                "warning code: 7 has no meaning in the specification",
                "warning tail: 2 bytes after the known fields",
            ]
        );
        assert_eq!(lints.first_error().map(|lint| lint.what), Some("motor"));
    }

    #[test]
    fn too_many_findings_end_in_a_note_of_the_greatest_severity() {
        let mut lints = Lints::new();
        for _ in 0..MAX_LINTS {
            lints.note(Severity::Warning, "field", "odd");
        }
        assert!(lints.first_error().is_none());
        lints.note(Severity::Error, "field", "wrong");
        lints.note(Severity::Warning, "field", "odd");
        assert_eq!(lints.as_slice().len(), MAX_LINTS);
        let last = lints.as_slice()[MAX_LINTS - 1];
        assert_eq!((last.severity, last.problem), (Severity::Error, Problem::Note("and more findings")));
    }
}
