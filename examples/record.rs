//! Records that `inspect` finds in a stream, before they are printed.

use std::io::{self, Write};

use motion_core::lint::Lint;
use motion_core::serialize::Map;
use motion_core::wire::Fields;
use motion_core::wire::print::is_hidden;
use serde::Serialize;
use serde::ser::SerializeMap;
use serde_json::Serializer;
use serde_json::ser::Formatter;

use crate::text::Side;

/// One find: a frame, or bytes that are not a frame.
pub struct Record<'a> {
    /// Offset of the first byte of the record among all bytes of its side.
    pub offset: u64,
    /// Length of the record, in bytes.
    pub len: u64,
    /// Short name of the protocol.
    pub protocol: &'static str,
    /// Side that sent the record.
    pub from: Side,
    /// Content of the record.
    pub find: Find<'a>,
}

/// Content of a record.
pub enum Find<'a> {
    /// A sound frame.
    Frame(Shown<'a>),
    /// Bytes that are not a frame.
    Other {
        /// Kind of the bytes.
        kind: Kind,
        /// Reason why the bytes are not a frame, in one sentence.
        why: String,
        /// The first of the bytes.
        start: &'a [u8],
    },
}

/// Kind of bytes that are not a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Bytes between frames.
    Noise,
    /// A frame with a wrong checksum.
    Corrupt,
    /// Bytes after which the stream must not continue, by the rules of the protocol.
    Fatal,
    /// A frame that the end of the input cuts off.
    Incomplete,
}

impl Kind {
    /// Key of the kind in JSON.
    #[must_use]
    pub const fn key(self) -> &'static str {
        match self {
            Self::Noise => "noise",
            Self::Corrupt => "corrupt",
            Self::Fatal => "fatal",
            Self::Incomplete => "incomplete",
        }
    }
}

/// Keys and values from the header of a frame.
pub type Keys = Vec<(&'static str, serde_json::Value)>;

/// A frame, ready to be printed.
pub struct Shown<'a> {
    /// Bytes of the whole frame.
    pub frame: &'a [u8],
    /// Name of the message in the specification, if it is known.
    pub message: Option<&'a str>,
    /// Title for human readers: the name of the message.
    pub title: String,
    /// Text after the title, less prominent.
    pub subtitle: String,
    /// Values of the header that JSON shows beside the name.
    pub keys: Keys,
    /// Values of the header that JSON shows among the fields.
    pub header_fields: Keys,
    /// Fields of the message, or why it has none.
    pub body: Body<'a>,
    /// Whether encoding the decoded message gives the same bytes.
    pub canonical: bool,
    /// Findings of lint.
    pub lints: Vec<Lint>,
    /// Whether the frame has a checksum, which is then correct.
    pub checked: bool,
}

/// The body of a frame.
pub enum Body<'a> {
    /// Fields of the message.
    Fields(&'a dyn Fields),
    /// Reason why the message could not be decoded, and the bytes of its body.
    Error(String, &'a [u8]),
}

/// Record as one line of JSON, as `vectors/README.md` describes it.
pub struct Json<'a> {
    /// The record.
    pub record: &'a Record<'a>,
    /// Whether passwords are shown.
    pub secrets: bool,
}

impl Json<'_> {
    /// Writes the record and a line end. Characters that are hidden or change the text around them are escaped.
    ///
    /// # Errors
    ///
    /// The errors of `out`.
    pub fn write_line(&self, out: &mut impl Write) -> io::Result<()> {
        self.serialize(&mut Serializer::with_formatter(&mut *out, Visible))?;
        out.write_all(b"\n")
    }
}

/// Format of JSON in one line without hidden characters.
struct Visible;

impl Formatter for Visible {
    fn write_string_fragment<W: Write + ?Sized>(&mut self, out: &mut W, fragment: &str) -> io::Result<()> {
        for part in fragment.split_inclusive(is_hidden) {
            let hidden = part.chars().next_back().filter(|&last| is_hidden(last));
            out.write_all(part.trim_end_matches(is_hidden).as_bytes())?;
            for unit in hidden.iter().flat_map(|hidden| hidden.encode_utf16(&mut [0; 2]).to_vec()) {
                write!(out, "\\u{unit:04x}")?;
            }
        }
        Ok(())
    }
}

impl Serialize for Json<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let record = self.record;
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("offset", &record.offset)?;
        map.serialize_entry("len", &record.len)?;
        map.serialize_entry("protocol", record.protocol)?;
        map.serialize_entry("from", side_name(record.from))?;
        match &record.find {
            Find::Other { kind, why, .. } => map.serialize_entry(kind.key(), why)?,
            Find::Frame(shown) => {
                if let Some(message) = shown.message {
                    map.serialize_entry("message", message)?;
                }
                for (key, value) in &shown.keys {
                    map.serialize_entry(key, value)?;
                }
                match &shown.body {
                    Body::Error(why, data) => {
                        map.serialize_entry("error", why)?;
                        map.serialize_entry("data", &hex(data))?;
                    }
                    Body::Fields(fields) => {
                        let fields = AllFields { header: &shown.header_fields, fields: *fields, secrets: self.secrets };
                        map.serialize_entry("fields", &fields)?;
                        map.serialize_entry("canonical", &shown.canonical)?;
                    }
                }
                let lints: Vec<_> = shown.lints.iter().map(LintJson).collect();
                map.serialize_entry("lint", &lints)?;
            }
        }
        map.end()
    }
}

struct AllFields<'a> {
    header: &'a Keys,
    fields: &'a dyn Fields,
    secrets: bool,
}

impl Serialize for AllFields<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (key, value) in self.header {
            map.serialize_entry(key, value)?;
        }
        Map { fields: self.fields, secrets: self.secrets }.entries(&mut map)?;
        map.end()
    }
}

struct LintJson<'a>(&'a Lint);

impl Serialize for LintJson<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(2))?;
        map.serialize_entry("severity", &self.0.severity.to_string())?;
        map.serialize_entry("text", &self.0.to_string())?;
        map.end()
    }
}

/// Name of a side in JSON.
#[must_use]
pub const fn side_name(side: Side) -> &'static str {
    match side {
        Side::Host => "host",
        Side::Device => "device",
    }
}

/// Bytes as hex digits, without spaces.
#[must_use]
pub fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write;
    bytes.iter().fold(String::with_capacity(2 * bytes.len()), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_json_has_no_hidden_characters() {
        let why = "a\u{9b}2Jb\u{202e}\u{feff}\n\"é\u{7f}\u{1f600}".to_owned();
        let find = Find::Other { kind: Kind::Noise, why: why.clone(), start: &[] };
        let record = Record { offset: 0, len: 1, protocol: "kos", from: Side::Host, find };
        let mut line = Vec::new();
        Json { record: &record, secrets: false }.write_line(&mut line).unwrap();
        let line = String::from_utf8(line).unwrap();
        assert!(line.ends_with("}\n") && !line.trim_end().contains(is_hidden), "{line:?}");
        assert!(line.contains(r#""noise":"a\u009b2Jb\u202e\ufeff\n\"é\u007f😀""#), "{line}");
        assert_eq!(serde_json::from_str::<serde_json::Value>(&line).unwrap()["noise"], why);
    }
}
