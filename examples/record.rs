//! What `inspect` finds in a stream, before anybody prints it.

use motion_core::lint::Lint;
use motion_core::serialize::Map;
use motion_core::wire::Fields;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use crate::text::Side;

/// One find: a frame, or bytes that are none.
pub struct Record<'a> {
    /// Where its first byte stands in what this side sent.
    pub offset: u64,
    /// Bytes it takes.
    pub len: u64,
    /// The protocol's short name.
    pub protocol: &'static str,
    /// Who sent it.
    pub from: Side,
    /// What it is.
    pub find: Find<'a>,
}

/// What was found.
pub enum Find<'a> {
    /// A sound frame.
    Frame(Shown<'a>),
    /// Bytes that are no frame.
    Other {
        /// What they are.
        kind: Kind,
        /// Why, in one sentence.
        why: String,
        /// The first of them.
        start: &'a [u8],
    },
}

/// What bytes are that are no frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Between the frames.
    Noise,
    /// A frame with a wrong checksum.
    Corrupt,
    /// The stream cannot go on by the protocol's rules.
    Fatal,
    /// The input ends inside a frame.
    Incomplete,
}

impl Kind {
    /// Its key in JSON.
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

/// Keys and values that the frame's header gives.
pub type Keys = Vec<(&'static str, serde_json::Value)>;

/// A frame, ready to be printed.
pub struct Shown<'a> {
    /// The name of the message in the specification, where it is known.
    pub message: Option<&'a str>,
    /// What a person reads first: what message it is.
    pub title: String,
    /// What a person reads behind it, less loud.
    pub subtitle: String,
    /// What the header says, beside the name.
    pub keys: Keys,
    /// What the header says, among the fields.
    pub header_fields: Keys,
    /// The fields.
    pub body: Body<'a>,
    /// Whether encoding what was decoded gives the same bytes.
    pub canonical: bool,
    /// What lint says.
    pub lints: Vec<Lint>,
    /// Whether it has a checksum, which then is right.
    pub checked: bool,
}

/// The body of a frame.
pub enum Body<'a> {
    /// Its fields.
    Fields(&'a dyn Fields),
    /// Why it has none, and its bytes.
    Error(String, &'a [u8]),
}

/// A record as the one line of JSON that `vectors/README.md` describes.
pub struct Json<'a> {
    /// The record.
    pub record: &'a Record<'a>,
    /// Whether passwords are shown.
    pub secrets: bool,
}

impl Serialize for Json<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
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
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
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
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(2))?;
        map.serialize_entry("severity", &self.0.severity.to_string())?;
        map.serialize_entry("text", &self.0.to_string())?;
        map.end()
    }
}

/// The side's name in JSON.
#[must_use]
pub const fn side_name(side: Side) -> &'static str {
    match side {
        Side::Host => "host",
        Side::Device => "device",
    }
}

/// Bytes as hex, without spaces.
#[must_use]
pub fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write;
    bytes.iter().fold(String::with_capacity(2 * bytes.len()), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
