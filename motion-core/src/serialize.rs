//! Messages as serde maps, from the field names of the layout to the raw values on the wire.
//!
//! The conformance vectors have the same form:
//!
//! - Texts are strings. A text that is not UTF-8 is a string of hex digits, and `_bytes` is added to the name of its
//!   field.
//! - Other bytes are strings of hex digits.
//! - IEEE numbers are numbers, widened exactly. One that is NaN or infinite is a string of its bits, `"0x7fc00000"`.
//! - Optional fields that are absent have no entry.

use core::fmt;

use serde::ser::{SerializeMap, SerializeSeq};
use serde::{Serialize, Serializer};

use crate::wire::{FieldView, Fields, List, Value, print};

/// Serializes the fields of a message as a map, including secrets.
///
/// # Errors
///
/// The errors of the serializer.
#[doc(hidden)]
pub fn fields<S: Serializer>(fields: &dyn Fields, serializer: S) -> Result<S::Ok, S::Error> {
    Map { fields, secrets: true }.serialize(serializer)
}

/// Serializes the raw value of one field.
///
/// # Errors
///
/// The errors of the serializer.
#[doc(hidden)]
pub fn value<S: Serializer>(value: Value<'_>, serializer: S) -> Result<S::Ok, S::Error> {
    Raw { value, secrets: true }.serialize(serializer)
}

/// The fields of a message, as a map.
pub struct Map<'a> {
    /// The message that has the fields.
    pub fields: &'a dyn Fields,
    /// Whether secrets are written; otherwise `"(redacted)"` takes their place.
    pub secrets: bool,
}

impl Serialize for Map<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        self.entries(&mut map)?;
        map.end()
    }
}

impl Map<'_> {
    /// Adds the fields to a map that has other entries as well.
    ///
    /// # Errors
    ///
    /// The errors of the serializer.
    pub fn entries<M: SerializeMap>(&self, map: &mut M) -> Result<(), M::Error> {
        let mut result = Ok(());
        self.fields.fields(&mut |field: &FieldView<'_>| {
            if result.is_ok() {
                result = entry(map, field, self.secrets);
            }
        });
        result
    }
}

fn entry<M: SerializeMap>(map: &mut M, field: &FieldView<'_>, secrets: bool) -> Result<(), M::Error> {
    match field.value {
        Value::Secret(_) if !secrets => map.serialize_entry(field.name, "(redacted)"),
        Value::Text(text) | Value::Secret(text) => match core::str::from_utf8(text) {
            Ok(text) => map.serialize_entry(field.name, text),
            Err(_) => map.serialize_entry(&Shown(format_args!("{}_bytes", field.name)), &Hex(text)),
        },
        value => map.serialize_entry(field.name, &Raw { value, secrets }),
    }
}

/// A value without a name of its own.
struct Raw<'a> {
    value: Value<'a>,
    secrets: bool,
}

impl Serialize for Raw<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.value {
            Value::Unsigned(number) => serializer.serialize_u64(number),
            Value::Signed(number) => serializer.serialize_i64(number),
            Value::Float(number) if number.is_finite() => serializer.serialize_f64(number.into()),
            Value::Float(number) => serializer.collect_str(&format_args!("{:#010x}", number.to_bits())),
            Value::Text(bytes) | Value::Secret(bytes) | Value::Bytes(bytes) => Hex(bytes).serialize(serializer),
            Value::List(list) => Sequence { list, secrets: self.secrets }.serialize(serializer),
            Value::Group(fields) => Map { fields, secrets: self.secrets }.serialize(serializer),
        }
    }
}

struct Sequence<'a> {
    list: &'a dyn List,
    secrets: bool,
}

impl Serialize for Sequence<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut sequence = serializer.serialize_seq(None)?;
        let mut result = Ok(());
        self.list.each(&mut |value| {
            if result.is_ok() {
                result = sequence.serialize_element(&Raw { value, secrets: self.secrets });
            }
        });
        result?;
        sequence.end()
    }
}

struct Hex<'a>(&'a [u8]);

impl Serialize for Hex<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl fmt::Display for Hex<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        print::hex(f, self.0)
    }
}

/// A value that is written as the text it prints.
struct Shown<'a>(fmt::Arguments<'a>);

impl Serialize for Shown<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&self.0)
    }
}

/// An owned message as a map of `message`, `number` and `fields`; feature `alloc`.
#[cfg(feature = "alloc")]
impl<S: crate::wire::Side, B: AsRef<[u8]>> Serialize for crate::owned::Owned<S, B> {
    fn serialize<T: Serializer>(&self, serializer: T) -> Result<T::Ok, T::Error> {
        let message = self.message();
        let mut map = serializer.serialize_map(Some(3))?;
        map.serialize_entry("message", crate::wire::Messages::name(&message))?;
        map.serialize_entry("number", &self.number())?;
        map.serialize_entry("fields", &Map { fields: &message, secrets: true })?;
        map.end()
    }
}
