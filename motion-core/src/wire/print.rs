//! Bounded printing: every message prints within a bound, whatever its bytes are, and escapes control characters.

use core::fmt::{self, Write};

use super::{FieldView, Fields, List, Value};

/// Greatest length of a printed message in bytes, before an ellipsis and the number of bytes left out.
pub const MAX_PRINTED: usize = 4096;

/// Prints `name { field: value unit, .. }`, at most [`MAX_PRINTED`] bytes and an ellipsis.
///
/// # Errors
///
/// The errors of `out` only.
pub fn message(out: &mut dyn Write, name: &str, fields: &dyn Fields) -> fmt::Result {
    let mut bounded = Bounded { out, left: MAX_PRINTED, dropped: 0 };
    bounded.write_str(name)?;
    group(&mut bounded, " { ", fields)?;
    bounded.finish()
}

/// Prints `{ field: value unit, .. }`, or nothing if there is no field.
fn group(out: &mut dyn Write, open: &str, fields: &dyn Fields) -> fmt::Result {
    let mut result = Ok(());
    let mut separator = open;
    fields.fields(&mut |field: &FieldView<'_>| {
        if result.is_ok() {
            result = out.write_str(separator).and_then(|()| self::field(out, field));
            separator = ", ";
        }
    });
    result?;
    if separator == ", " { out.write_str(" }") } else { Ok(()) }
}

fn field(out: &mut dyn Write, field: &FieldView<'_>) -> fmt::Result {
    write!(out, "{}: {}", field.name, field.text)?;
    if field.unit.is_empty() { Ok(()) } else { write!(out, " {}", field.unit) }
}

/// Prints a list as a person reads it.
pub struct ListText<'a>(pub &'a dyn List);

impl fmt::Display for ListText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut result = Ok(());
        let mut separator = "[";
        self.0.each(&mut |value| {
            if result.is_ok() {
                result = f.write_str(separator).and_then(|()| self::value(f, value));
                separator = ", ";
            }
        });
        result?;
        f.write_str(if separator == "[" { "[]" } else { "]" })
    }
}

fn value(out: &mut dyn Write, value: Value<'_>) -> fmt::Result {
    match value {
        Value::Unsigned(number) => write!(out, "{number}"),
        Value::Signed(number) => write!(out, "{number}"),
        Value::Float(number) => out.write_str(zmij::Buffer::new().format(number)),
        Value::Text(bytes) => text(out, bytes),
        Value::Secret(bytes) => secret(out, bytes),
        Value::Bytes(bytes) => hex(out, bytes),
        Value::List(list) => write!(out, "{}", ListText(list)),
        Value::Group(fields) => group(out, "{ ", fields),
    }
}

/// Prints an IEEE number as the shortest text that reads back to the same value.
///
/// Float printing of `core` is not used because it cannot be proven free of panics.
///
/// # Errors
///
/// The errors of `out` only.
pub fn float(out: &mut dyn Write, number: f32) -> fmt::Result {
    out.write_str(zmij::Buffer::new().format(number))
}

/// Prints bytes as lower-case hex without spaces.
///
/// # Errors
///
/// The errors of `out` only.
pub fn hex(out: &mut dyn Write, bytes: &[u8]) -> fmt::Result {
    bytes.iter().try_for_each(|byte| write!(out, "{byte:02x}"))
}

/// Prints a text in quotes. Control and direction characters are escaped; bytes that are not UTF-8 print as `\xNN`.
///
/// # Errors
///
/// The errors of `out` only.
pub fn text(out: &mut dyn Write, bytes: &[u8]) -> fmt::Result {
    out.write_char('"')?;
    for chunk in bytes.utf8_chunks() {
        for character in chunk.valid().chars() {
            match character {
                '"' => out.write_str("\\\"")?,
                '\\' => out.write_str("\\\\")?,
                hidden if is_hidden(hidden) => write!(out, "\\u{{{:x}}}", u32::from(hidden))?,
                shown => out.write_char(shown)?,
            }
        }
        for byte in chunk.invalid() {
            write!(out, "\\x{byte:02x}")?;
        }
    }
    out.write_char('"')
}

/// Whether a character moves the cursor, turns the reading direction, or cannot be seen. Programs escape it before they
/// show text that a device or a file gave.
#[must_use]
pub fn is_hidden(character: char) -> bool {
    character.is_control()
        || matches!(character, '\u{ad}' | '\u{61c}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
}

/// Prints the length of a secret, not the secret.
///
/// # Errors
///
/// The errors of `out` only.
pub fn secret(out: &mut dyn Write, bytes: &[u8]) -> fmt::Result {
    if bytes.is_empty() { out.write_str("none") } else { write!(out, "redacted, {} bytes", bytes.len()) }
}

/// Writer that passes `left` bytes of text on and counts the rest.
struct Bounded<'o> {
    out: &'o mut dyn Write,
    left: usize,
    dropped: usize,
}

impl Bounded<'_> {
    fn finish(&mut self) -> fmt::Result {
        match self.dropped {
            0 => Ok(()),
            dropped => write!(self.out, "… ({dropped} bytes more)"),
        }
    }
}

impl Write for Bounded<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        // After something was left out, nothing follows.
        let room = if self.dropped > 0 { 0 } else { self.left.min(text.len()) };
        // A character has at most four bytes, so one of these four places is between two characters.
        let cut = (0..4).filter_map(|back| room.checked_sub(back)).find_map(|at| text.split_at_checked(at));
        let (shown, hidden) = cut.unwrap_or(("", text));
        self.left = self.left.saturating_sub(shown.len());
        self.dropped = self.dropped.saturating_add(hidden.len());
        if shown.is_empty() { Ok(()) } else { self.out.write_str(shown) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::String;

    #[test]
    fn text_hides_what_would_play_with_a_terminal() {
        let mut out = String::new();
        text(&mut out, "a\u{1b}[31m\"\u{202e}é".as_bytes()).unwrap();
        assert_eq!(out, "\"a\\u{1b}[31m\\\"\\u{202e}é\"");
        out.clear();
        text(&mut out, b"\xff\xc3").unwrap();
        assert_eq!(out, "\"\\xff\\xc3\"");
    }

    #[test]
    fn a_bounded_text_ends_between_characters_and_counts_the_rest() {
        let mut out = String::new();
        let mut bounded = Bounded { out: &mut out, left: 4, dropped: 0 };
        bounded.write_str("abc").unwrap();
        bounded.write_str("éx").unwrap();
        bounded.write_str("y").unwrap();
        bounded.finish().unwrap();
        assert_eq!(out, "abc… (4 bytes more)");
    }
}
