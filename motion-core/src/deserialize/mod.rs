//! Owned messages from serde maps, the reverse of [`serialize`](crate::serialize). [`Owned`] documents the form for
//! users.
//!
//! The layout of the message turns a map into bytes. These are decoded, and every field has to come back as it was
//! given. So a message that its layout does not fully describe is an error, never wrong bytes.

mod node;

use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;

use serde::de::{Deserialize, Deserializer, Error};
use zerocopy::ByteOrder;

use self::node::{Map, Node, prefixed};
use crate::owned::Owned;
use crate::wire::{DecodeError, FieldView, Fields, Kind, Messages, PartKind, Row, Side, Value};

impl<'de, S: Side> Deserialize<'de> for Owned<S> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let node = Node::deserialize(deserializer)?;
        node.map().and_then(read).map_err(D::Error::custom)
    }
}

/// A problem with a value, and the place of the value.
struct Problem {
    place: String,
    why: Why,
}

#[derive(Debug, Clone, Copy, thiserror::Error)]
enum Why {
    #[error("missing")]
    Missing,
    #[error("missing; the layout needs it for this message")]
    Needed,
    #[error("is not read back: there is no such field, or an earlier field is missing")]
    NotRead,
    #[error("there is no such message")]
    UnknownMessage,
    #[error("should be {0}")]
    Kind(&'static str),
    #[error("out of the range of {0}")]
    Range(&'static str),
    #[error("takes {have} bytes, should take {needed}")]
    Size { needed: usize, have: usize },
    #[error("{len} is more than {max}")]
    TooLong { len: usize, max: usize },
    #[error("the layout does not say how {0} is written")]
    Wire(&'static str),
    #[error("is read back as something else; the layout does not fully describe this message")]
    Differs,
    #[error("{0}")]
    Decode(DecodeError),
}

impl Why {
    fn at(self, place: &str) -> Problem {
        Problem { place: place.to_owned(), why: self }
    }
}

impl Problem {
    fn within(self, place: &str) -> Self {
        let separator = if self.place.is_empty() || self.place.starts_with('[') { "" } else { "." };
        Self { place: format!("{place}{separator}{}", self.place), ..self }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.why)
    }
}

/// The message that a map describes.
fn read<S: Side>(map: &Map) -> Result<Owned<S>, Problem> {
    let number = map.get("number").map(|node| node.integer::<u32>().map_err(|why| why.at("number"))).transpose()?;
    let name = map.get("message").map(|node| node.text().map_err(|why| why.at("message"))).transpose()?;
    let none = Map::new();
    let fields = map.get("fields").map_or(Ok(&none), |node| node.map().map_err(|problem| problem.within("fields")))?;

    let all = S::Message::ALL;
    let kind = match (name, number) {
        (Some("Other"), _) => None,
        (Some(name), _) => Some(all.iter().find(|kind| kind.name == name).ok_or(Why::UnknownMessage.at(name))?),
        (None, Some(number)) => all.iter().find(|kind| kind.number == number),
        (None, None) => return Err(Why::Missing.at("message")),
    };
    match kind {
        Some(kind) => known(kind, number.unwrap_or(kind.number), fields).map_err(|problem| problem.within(kind.name)),
        None => unknown(number.ok_or(Why::Missing.at("number"))?, fields).map_err(|problem| problem.within("Other")),
    }
}

/// A message without a type of its own.
fn unknown<S: Side>(number: u32, fields: &Map) -> Result<Owned<S>, Problem> {
    let body = fields.get("data").ok_or(Why::Missing).and_then(Node::hex).map_err(|why| why.at("data"))?;
    all_read(fields, &["data"])?;
    Ok(Owned::from_parts(number, body))
}

/// A message of the table, written by its layout and read back.
///
/// Fields in the middle that an older dialect leaves out may be absent: the message that is read back decides.
fn known<S: Side>(kind: &Kind, number: u32, fields: &Map) -> Result<Owned<S>, Problem> {
    let mut body = Vec::new();
    let made = write::<S::Order>(kind.layout, fields, &mut body).and_then(|()| {
        if let Some(tail) = fields.get("tail") {
            body.extend(tail.hex().map_err(|why| why.at("tail"))?);
        }
        let message = S::Message::decode_body(number, &body).map_err(|error| Why::Decode(error).at("fields"))?;
        if message.number() != number || message.name() != kind.name {
            return Err(Why::Differs.at("number"));
        }
        same(&message, fields)
    });
    match made {
        Ok(()) => Ok(Owned::from_parts(number, body)),
        Err(problem) => Err(missing(kind.layout, fields).unwrap_or(problem)),
    }
}

/// Writes the given fields of a layout, in wire order.
fn write<O: ByteOrder>(rows: &[Row], fields: &Map, out: &mut Vec<u8>) -> Result<(), Problem> {
    rows.iter().try_for_each(|row| Given::find(fields, row.name).map_or(Ok(()), |given| given.write::<O>(row, out)))
}

/// The first field of the layout that is not given.
fn missing(rows: &[Row], fields: &Map) -> Option<Problem> {
    rows.iter().find_map(|row| match Given::find(fields, row.name) {
        None if row.part == PartKind::Optional => None,
        None => Some(Why::Needed.at(row.name)),
        Some(given) => {
            let groups = given.node.list().unwrap_or_default().iter().filter(|_| !row.element.is_empty());
            let within = |(index, group): (usize, &Node)| {
                Some(missing(row.element, group.map().ok()?)?.within(&format!("[{index}]")).within(row.name))
            };
            groups.enumerate().find_map(within)
        }
    })
}

/// Whether a field is a text of fixed size, such as `text[32]`.
fn is_text(row: &Row) -> bool {
    row.wire.starts_with("text[")
}

/// The given value of a field, and whether its name ends with `_bytes`.
struct Given<'a> {
    node: &'a Node,
    raw: bool,
}

impl<'a> Given<'a> {
    fn find(fields: &'a Map, name: &str) -> Option<Self> {
        let text = fields.get(name).map(|node| Self { node, raw: false });
        text.or_else(|| fields.get(&format!("{name}_bytes")).map(|node| Self { node, raw: true }))
    }

    /// The bytes of a text, or other bytes, as the row says.
    fn bytes(&self, row: &Row) -> Result<Vec<u8>, Why> {
        if is_text(row) { self.text() } else { self.node.hex() }
    }

    /// The bytes of a text.
    fn text(&self) -> Result<Vec<u8>, Why> {
        if self.raw { self.node.hex() } else { Ok(self.node.text()?.as_bytes().to_vec()) }
    }

    fn write<O: ByteOrder>(&self, row: &Row, out: &mut Vec<u8>) -> Result<(), Problem> {
        let at = |why: Why| why.at(row.name);
        match row.part {
            PartKind::Fixed | PartKind::Optional => {
                let before = out.len();
                self.write_fixed::<O>(row, out).map_err(at)?;
                if is_text(row) {
                    out.resize(out.len().max(before.saturating_add(row.size)), 0);
                }
                let have = out.len().saturating_sub(before);
                if have == row.size { Ok(()) } else { Err(at(Why::Size { needed: row.size, have })) }
            }
            PartKind::List => self.write_list::<O>(row, out),
            PartKind::Counted => {
                let len = self.node.list().map_err(at)?.len();
                let max = u8::MAX.into();
                out.push(u8::try_from(len).map_err(|_| at(Why::TooLong { len, max }))?);
                self.write_list::<O>(row, out)
            }
            PartKind::Text16 => self.text().and_then(|text| prefixed::<O>(&text, out)).map_err(at),
            PartKind::Block16 => self.node.hex().and_then(|block| prefixed::<O>(&block, out)).map_err(at),
            PartKind::Rest => self.bytes(row).map(|rest| out.extend(rest)).map_err(at),
        }
    }

    /// Writes a field of fixed size: a text, bytes, a number, or several.
    fn write_fixed<O: ByteOrder>(&self, row: &Row, out: &mut Vec<u8>) -> Result<(), Why> {
        if is_text(row) || row.wire == "bytes" {
            out.extend(self.bytes(row)?);
            return Ok(());
        }
        // An array, such as `[u8; 4]`.
        if let Some((wire, _)) = row.wire.strip_prefix('[').and_then(|array| array.split_once(';')) {
            return self.node.list()?.iter().try_for_each(|node| node.write::<O>(wire, row.wire, out));
        }
        self.node.write::<O>(row.wire, row.wire, out)
    }

    fn write_list<O: ByteOrder>(&self, row: &Row, out: &mut Vec<u8>) -> Result<(), Problem> {
        for (index, node) in self.node.list().map_err(|why| why.at(row.name))?.iter().enumerate() {
            let result = if row.element.is_empty() {
                node.write::<O>(row.wire, row.wire, out).map_err(|why| why.at(&format!("[{index}]")))
            } else {
                node.map()
                    .and_then(|map| write::<O>(row.element, map, out))
                    .map_err(|problem| problem.within(&format!("[{index}]")))
            };
            result.map_err(|problem| problem.within(row.name))?;
        }
        Ok(())
    }
}

/// Checks that a message has exactly the given fields, each with its value.
fn same(fields: &dyn Fields, given: &Map) -> Result<(), Problem> {
    let mut names = Vec::new();
    fields.fields(&mut |field: &FieldView<'_>| names.push(field.name));
    all_read(given, &names)?;
    let mut result = Ok(());
    fields.fields(&mut |field: &FieldView<'_>| {
        if result.is_ok() {
            result = match Given::find(given, field.name) {
                Some(given) => given.same(field.value).map_err(|problem| problem.within(field.name)),
                None => Err(Why::Missing.at(field.name)),
            };
        }
    });
    result
}

/// Refuses fields with other names than these.
fn all_read(given: &Map, names: &[&str]) -> Result<(), Problem> {
    let is_read = |key: &str| {
        let raw = key.strip_suffix("_bytes").filter(|name| !given.contains_key(*name));
        names.iter().any(|&name| name == key || Some(name) == raw)
    };
    given.keys().find(|key| !is_read(key)).map_or(Ok(()), |key| Err(Why::NotRead.at(key)))
}

impl Given<'_> {
    fn same(&self, value: Value<'_>) -> Result<(), Problem> {
        let node = self.node;
        let same = match value {
            Value::Unsigned(number) => node.integer().map(|given: u64| given == number),
            Value::Signed(number) => node.integer().map(|given: i64| given == number),
            Value::Float(number) => node.float().map(|given| given.to_bits() == number.to_bits()),
            Value::Text(bytes) | Value::Secret(bytes) => self.text().map(|given| given == bytes),
            Value::Bytes(bytes) => node.hex().map(|given| given == bytes),
            Value::Group(fields) => return node.map().and_then(|given| same(fields, given)),
            Value::List(list) => {
                let mut nodes = node.list().map_err(|why| why.at(""))?.iter();
                let mut result = Ok(());
                list.each(&mut |value| {
                    if result.is_ok() {
                        result = nodes
                            .next()
                            .ok_or(Why::Differs.at(""))
                            .and_then(|node| Given { node, raw: false }.same(value));
                    }
                });
                return result.and_then(|()| nodes.next().map_or(Ok(()), |_| Err(Why::Differs.at(""))));
            }
        };
        match same {
            Ok(true) => Ok(()),
            Ok(false) => Err(Why::Differs.at("")),
            Err(why) => Err(why.at("")),
        }
    }
}
