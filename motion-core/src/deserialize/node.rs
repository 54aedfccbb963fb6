use alloc::borrow::ToOwned;
use alloc::collections::BTreeMap;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;
use core::fmt;

use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use zerocopy::ByteOrder;

use super::{Problem, Why};
use crate::raw;
use crate::wire::{Field, Writer};

pub(super) type Map = BTreeMap<String, Node>;

/// A value of any kind, before the layout says what it means.
pub(super) enum Node {
    Integer(i128),
    Float(f64),
    Text(String),
    List(Vec<Node>),
    Map(Map),
    Absent,
}

impl Node {
    pub(super) fn map(&self) -> Result<&Map, Problem> {
        if let Self::Map(map) = self { Ok(map) } else { Err(Why::Kind("a map").at("")) }
    }

    pub(super) fn list(&self) -> Result<&[Self], Why> {
        if let Self::List(list) = self { Ok(list) } else { Err(Why::Kind("a list")) }
    }

    pub(super) fn text(&self) -> Result<&str, Why> {
        if let Self::Text(text) = self { Ok(text) } else { Err(Why::Kind("a text")) }
    }

    /// Bytes from a text of hex digits.
    pub(super) fn hex(&self) -> Result<Vec<u8>, Why> {
        let why = Why::Kind("a text of hex digits, two for each byte");
        let Self::Text(text) = self else { return Err(why) };
        let mut bytes = vec![0; text.len() / 2];
        raw::hex(text, &mut bytes).map(|()| bytes).ok_or(why)
    }

    pub(super) fn integer<T: TryFrom<i128>>(&self) -> Result<T, Why> {
        let Self::Integer(number) = self else { return Err(Why::Kind("an integer")) };
        T::try_from(*number).map_err(|_| Why::Range(core::any::type_name::<T>()))
    }

    #[expect(clippy::cast_precision_loss, reason = "rounds to the nearest, as it should")]
    pub(super) fn float(&self) -> Result<f32, Why> {
        match self {
            Self::Float(number) => raw::nearest(*number).ok_or(Why::Range("f32")),
            Self::Integer(number) => Ok(*number as f32),
            Self::Text(text) => raw::not_finite(text).ok_or(Why::Kind(raw::FLOAT)),
            _ => Err(Why::Kind(raw::FLOAT)),
        }
    }

    /// Writes a number in the type that the layout says.
    pub(super) fn write<O: ByteOrder>(&self, wire: &str, row: &'static str, out: &mut Vec<u8>) -> Result<(), Why> {
        match wire {
            "u8" => store::<u8, O>(self.integer()?, out),
            "u16" => store::<u16, O>(self.integer()?, out),
            "i16" => store::<i16, O>(self.integer()?, out),
            "u32" => store::<u32, O>(self.integer()?, out),
            "i32" => store::<i32, O>(self.integer()?, out),
            "f32" => store::<u32, O>(self.float()?.to_bits(), out),
            _ => return Err(Why::Wire(row)),
        }
        Ok(())
    }
}

impl<'de> Deserialize<'de> for Node {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Nodes)
    }
}

struct Nodes;

impl<'de> Visitor<'de> for Nodes {
    type Value = Node;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a message, as a map of `message`, `number` and `fields`")
    }

    fn visit_bool<E>(self, yes: bool) -> Result<Node, E> {
        Ok(Node::Integer(yes.into()))
    }

    fn visit_u64<E>(self, number: u64) -> Result<Node, E> {
        Ok(Node::Integer(number.into()))
    }

    fn visit_i64<E>(self, number: i64) -> Result<Node, E> {
        Ok(Node::Integer(number.into()))
    }

    fn visit_f64<E>(self, number: f64) -> Result<Node, E> {
        Ok(Node::Float(number))
    }

    fn visit_str<E>(self, text: &str) -> Result<Node, E> {
        Ok(Node::Text(text.to_owned()))
    }

    fn visit_unit<E>(self) -> Result<Node, E> {
        Ok(Node::Absent)
    }

    fn visit_none<E>(self) -> Result<Node, E> {
        Ok(Node::Absent)
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Node, D::Error> {
        Node::deserialize(deserializer)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Node, A::Error> {
        let mut list = Vec::new();
        while let Some(node) = seq.next_element()? {
            list.push(node);
        }
        Ok(Node::List(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Node, A::Error> {
        let mut map = Map::new();
        while let Some((name, node)) = entries.next_entry::<String, Node>()? {
            if map.contains_key(&name) {
                return Err(A::Error::custom(format_args!("{name}: given twice")));
            }
            if !matches!(node, Node::Absent) {
                map.insert(name, node);
            }
        }
        Ok(Node::Map(map))
    }
}

/// Writes a number in the byte order `O`.
fn store<T: Field, O: ByteOrder>(number: T, out: &mut Vec<u8>) {
    let mut bytes = [0; 4];
    if let (Some(()), Some(bytes)) = (number.write(&mut Writer::<O>::new(&mut bytes)), bytes.get(..T::SIZE)) {
        out.extend_from_slice(bytes);
    }
}

/// Writes a `u16` length and this number of bytes.
pub(super) fn prefixed<O: ByteOrder>(bytes: &[u8], out: &mut Vec<u8>) -> Result<(), Why> {
    let (len, max) = (bytes.len(), u16::MAX.into());
    store::<u16, O>(u16::try_from(len).map_err(|_| Why::TooLong { len, max })?, out);
    out.extend_from_slice(bytes);
    Ok(())
}
