//! What the decoder of a message says about its fields, found out by decoding.
//!
//! The [layout](Row) of a message has the names, types and units of its fields. The names of numbers and flags, the scale of
//! a number, and the lengths at which an optional field is absent are known to the decoder alone. They are read off what it
//! makes of made-up bodies, so that no second table can contradict the first one.

use motion_core::wire::{Conduct, Kind, Messages, PartKind, Row, Side};
use motion_core::zerocopy::{IntoBytes, U16};

use crate::protocol::IRREGULAR;
use crate::view::{Leaf, View, views};

/// Message of one side.
#[derive(Debug, Clone)]
pub struct Message {
    /// First number of the message.
    pub number: u32,
    /// Last number of the message, if it has several in a row.
    pub last: u32,
    /// Another number of the message.
    pub also: Option<u32>,
    /// Name of the message.
    pub name: &'static str,
    /// How a message from a host may be treated; `None` if its values decide, and for messages that no host sends.
    pub conduct: Option<Conduct>,
    /// Name under which a part of the number is shown as a field.
    pub sub: Option<String>,
    /// Fields of the body in wire order.
    pub fields: Vec<Field>,
    /// Whether bytes may follow the fields.
    pub tail: bool,
}

/// Field of a body.
#[derive(Debug, Clone)]
pub struct Field {
    /// Name of the field.
    pub name: &'static str,
    /// Offset in bytes from the start of the body; `None` after a part of variable length.
    pub offset: Option<usize>,
    /// Type of a value on the wire.
    pub wire: Wire,
    /// How values follow each other.
    pub shape: Shape,
    /// Unit; empty if there is none.
    pub unit: &'static str,
    /// How a person reads the value.
    pub meaning: Meaning,
    /// When the field may be absent.
    pub presence: Presence,
}

/// Type of one value on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wire {
    /// Unsigned number of so many bytes.
    Unsigned(usize),
    /// Signed number of so many bytes.
    Signed(usize),
    /// IEEE-754 binary32.
    Float,
    /// Text of so many bytes, or of any number of bytes.
    Text(Option<usize>),
    /// Text that is shown only on request.
    Secret,
    /// So many bytes, or any number of bytes.
    Bytes(Option<usize>),
}

impl Wire {
    /// Number of bytes of a value; `None` if it varies.
    #[must_use]
    pub const fn size(self) -> Option<usize> {
        match self {
            Self::Unsigned(size) | Self::Signed(size) => Some(size),
            Self::Float => Some(4),
            Self::Text(size) | Self::Bytes(size) => size,
            Self::Secret => None,
        }
    }
}

/// How the values of a field follow each other.
#[derive(Debug, Clone)]
pub enum Shape {
    /// One value.
    One,
    /// So many values.
    Times(usize),
    /// Values to the end of the body.
    List,
    /// Groups of fields to the end of the body.
    Groups(Vec<Field>),
    /// Number of groups in one byte under this name, and the groups.
    Counted(String, Vec<Field>),
    /// Number of bytes in two bytes, and the bytes.
    Prefixed,
    /// All bytes to the end of the body.
    Rest,
}

/// How a person reads a value.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Meaning {
    /// The value itself.
    Plain,
    /// Number with so many decimals.
    Scaled(usize),
    /// Names of numbers.
    Names(Vec<(u64, String)>),
    /// Names of bits.
    Flags(Vec<(u64, String)>),
    /// Names of the numbers in the upper byte, which is the ring of a plug, and in the lower byte, which is the tip.
    RingTip(Vec<(u64, String)>),
    /// Address in an IP network.
    Ipv4,
    /// Address in an Ethernet network.
    Mac,
}

/// When a field may be absent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Presence {
    /// The field is always present.
    Always,
    /// The field is absent if fewer than this number of bytes is left. They are then the tail.
    If(usize),
    /// The field is absent if no byte is left. Fewer bytes than the field needs are an error.
    Newer,
}

/// Messages of a side. Those that are dissected by hand have no fields here.
#[must_use]
pub fn messages<S: Side>() -> Vec<Message> {
    let decode = |number, body: &[u8]| {
        S::Message::decode_body(number, body).ok().map(|message| (message.name(), views(&message)))
    };
    let is_little = U16::<S::Order>::new(1).as_bytes() == [1, 0];
    S::Message::ALL.iter().map(|kind| message(kind, is_little, &decode)).collect()
}

/// Decoder of a side: it gives the name of the message and its values.
type Decode<'d> = dyn Fn(u32, &[u8]) -> Option<(&'static str, Vec<View>)> + 'd;

/// Message of one row of a table. `decode` gives the name of the message and its values.
fn message(kind: &Kind, is_little: bool, decode: &Decode<'_>) -> Message {
    let Kind { number, name, layout, conduct } = *kind;
    let irregular = IRREGULAR.iter().any(|(irregular, _)| *irregular == name);
    let under = |number, body: &[u8]| decode(number, body).filter(|(found, _)| *found == name).map(|(_, views)| views);
    let here = |body: &[u8]| under(number, body);
    // A body of zeros is another message for some numbers, and too short for a text that must not be empty.
    let probe = [(0, 0), (1, 0), (b'x', 1)]
        .map(|(fill, rest)| Probe { decode: &here, is_little, fill, rest })
        .into_iter()
        .find(|probe| here(&probe.body(layout)).is_some())
        .unwrap_or_else(|| panic!("{name}: no body was found that can be decoded"));
    let body = probe.body(layout);
    let is_number = |number| under(number, &body).is_some();
    let last = (number..=0xff_ffff).take_while(|&number| is_number(number)).last().unwrap_or(number);
    let also = Some(number | 0x8000).filter(|&also| also > last && is_number(also));
    let shown = here(&body).expect("the body was chosen so that it can be decoded");
    let is_field = |name: &str| layout.iter().any(|row| row.name == name);
    let sub = shown.first().map(|view| view.name.clone()).filter(|name| !irregular && !is_field(name));
    let sub = sub.filter(|_| layout.first().is_none_or(|row| row.part != PartKind::Counted));
    let fields = if irregular { Vec::new() } else { probe.fields(layout) };
    let tail = here(&[&body[..], &[probe.fill]].concat()).is_some();
    Message { number, last, also, name, conduct, sub, fields, tail }
}

/// Fields of a layout whose bodies are read by `decode`.
#[must_use]
pub fn fields(layout: &[Row], is_little: bool, decode: &dyn Fn(&[u8]) -> Option<Vec<View>>) -> Vec<Field> {
    Probe { decode, is_little, fill: 0, rest: 0 }.fields(layout)
}

/// Decoder of one message, and the bytes of which its bodies are made.
struct Probe<'d> {
    decode: &'d dyn Fn(&[u8]) -> Option<Vec<View>>,
    /// Whether the lowest byte of a number comes first.
    is_little: bool,
    /// Value of each byte.
    fill: u8,
    /// Number of bytes in a part that takes all bytes to the end.
    rest: usize,
}

impl Probe<'_> {
    /// Body with all fields, and with empty lists, texts and blocks.
    fn body(&self, layout: &[Row]) -> Vec<u8> {
        let mut body = Vec::new();
        for row in layout {
            match row.part {
                PartKind::Fixed | PartKind::Optional => body.resize(body.len() + row.size, self.fill),
                PartKind::Counted => body.push(0),
                PartKind::Text16 | PartKind::Block16 => body.extend([0; 2]),
                PartKind::Rest => body.resize(body.len() + self.rest, self.fill),
                _ => {}
            }
        }
        body
    }

    /// Values of the field under this name in a body.
    fn read(&self, body: &[u8], name: &str) -> Vec<View> {
        let mut all = (self.decode)(body).unwrap_or_default();
        all.retain(|view| view.name == name);
        all
    }

    fn fields(&self, layout: &[Row]) -> Vec<Field> {
        (0..layout.len()).map(|index| self.field(layout, index)).collect()
    }

    fn field(&self, layout: &[Row], index: usize) -> Field {
        let row = &layout[index];
        let Row { name, offset, size, unit, .. } = *row;
        let before = self.body(&layout[..index]);
        let after = self.body(&layout[index + 1..]);
        let with = |bytes: &[u8]| [&before[..], bytes, &after[..]].concat();
        let plain = |wire, shape| (wire, shape, Meaning::Plain);
        let (wire, shape, meaning) = match row.part {
            PartKind::Fixed | PartKind::Optional => {
                let read = |bytes: &[u8]| self.read(&with(bytes), name);
                // One of both is a value that the message may have.
                let values = [1, 0].map(|byte| read(&vec![byte; size])).into_iter().find(|values| !values.is_empty());
                let values = values.unwrap_or_else(|| panic!("{name} is shown in no body"));
                let times = values.len().max(1);
                let wire = wire_of(&values[0].leaf, size / times);
                let shape = if times > 1 { Shape::Times(times) } else { Shape::One };
                (wire, shape, self.meaning(wire, times, &read))
            }
            PartKind::List if row.element.is_empty() => {
                let value = self.read(&with(&vec![1; size]), name).remove(0);
                plain(wire_of(&value.leaf, size), Shape::List)
            }
            PartKind::List => plain(Wire::Bytes(Some(size)), Shape::Groups(self.group(row, &with, None))),
            PartKind::Counted => {
                let count = (self.decode)(&with(&[0])).expect("a list may be empty");
                let index = layout[..index].iter().map(|row| self.read(&before, row.name).len().max(1)).sum::<usize>();
                let count = count[index].name.clone();
                plain(Wire::Bytes(Some(size)), Shape::Counted(count, self.group(row, &with, Some(1))))
            }
            PartKind::Text16 | PartKind::Block16 => {
                let wire = wire_of(&self.read(&with(&[0; 2]), name)[0].leaf, 0);
                plain(if let Wire::Bytes(_) = wire { Wire::Bytes(None) } else { wire }, Shape::Prefixed)
            }
            _ => {
                let wire = wire_of(&self.read(&with(b"x"), name)[0].leaf, 0);
                plain(if let Wire::Text(_) = wire { Wire::Text(None) } else { Wire::Bytes(None) }, Shape::Rest)
            }
        };
        Field { name, offset, wire, shape, unit, meaning, presence: self.presence(row, &before) }
    }

    /// Fields of the groups in a list, which is read with one group after `count`.
    fn group(&self, row: &Row, with: &dyn Fn(&[u8]) -> Vec<u8>, count: Option<u8>) -> Vec<Field> {
        let decode = |element: &[u8]| {
            let mut bytes: Vec<u8> = count.into_iter().collect();
            bytes.extend(element);
            bytes.resize(row.size + usize::from(count.is_some()), self.fill);
            (self.decode)(&with(&bytes))
        };
        let mut fields = fields(row.element, self.is_little, &decode);
        for field in &mut fields {
            field.presence = Presence::Always;
        }
        fields
    }

    /// When the field of a row is absent, after the bytes `before`.
    fn presence(&self, row: &Row, before: &[u8]) -> Presence {
        // A field that is shown without its bytes belongs to another layout of the same message.
        let without = (self.decode)(before).filter(|views| views.iter().all(|view| view.name != row.name));
        if row.part != PartKind::Optional || without.is_none() {
            return Presence::Always;
        }
        let of_len = |len| (self.decode)(&[before, &vec![self.fill; len]].concat());
        if of_len(1).is_none() {
            return Presence::Newer;
        }
        let is_shown = |len| of_len(len).is_some_and(|views| views.iter().any(|view| view.name == row.name));
        let needed = (1..64).find(|&len| is_shown(len));
        Presence::If(needed.unwrap_or_else(|| panic!("{}: never present", row.name)))
    }

    /// How a person reads a value, from the texts of some values.
    fn meaning(&self, wire: Wire, times: usize, read: &dyn Fn(&[u8]) -> Vec<View>) -> Meaning {
        let Some(size) = wire.size().filter(|&size| times == 1 && size <= 8) else { return Meaning::Plain };
        let text = |value: u64| {
            let mut bytes = value.to_le_bytes()[..size].to_vec();
            if !self.is_little {
                bytes.reverse();
            }
            read(&bytes).first().map(|view| view.text.clone())
        };
        if matches!(wire, Wire::Bytes(Some(6))) && text(1).is_some_and(|text| text.contains(':')) {
            return Meaning::Mac;
        }
        if !matches!(wire, Wire::Unsigned(_) | Wire::Signed(_)) {
            return Meaning::Plain;
        }
        meaning_of(size, &text)
    }
}

/// How a person reads a number of so many bytes, from the texts of some numbers.
pub fn meaning_of(size: usize, text: &dyn Fn(u64) -> Option<String>) -> Meaning {
    let (zero, one) = (text(0), text(1).unwrap_or_default());
    if one == "0.0.0.1" {
        return Meaning::Ipv4;
    }
    if let Some((_, decimals)) = one.split_once('.') {
        return Meaning::Scaled(decimals.len());
    }
    if zero.as_deref() == Some("no") {
        return Meaning::Names(vec![(0, "no".to_owned()), (1, "yes".to_owned())]);
    }
    let text_of = |value| {
        Some((value, text(value).filter(|text| text.starts_with(char::is_alphanumeric) && !text.starts_with("0x"))?))
    };
    // Bits have names of their own, so that the names of two bits are those of each.
    if zero.as_deref() == Some("none") && text(3).is_some_and(|text| text.contains(['|', '+'])) {
        return Meaning::Flags((0..size * 8).filter_map(|bit| text_of(1 << bit)).collect());
    }
    // No table names greater numbers.
    let values = 0..if size == 1 { 256 } else { 1024 };
    let is_name =
        |(value, text): &(u64, String)| text.starts_with(char::is_alphabetic) && !text.ends_with(&format!("({value})"));
    let names = values.filter_map(text_of).filter(is_name);
    let tips =
        |(value, text): (u64, String)| Some((value, text.strip_prefix("ring ")?.split_once(", tip ")?.1.to_owned()));
    let names: Vec<_> = names.collect();
    let bytes = names.iter().filter(|(value, _)| *value < 256).cloned();
    let tips: Vec<_> = bytes.filter_map(tips).filter(|(_, tip)| tip.starts_with(char::is_alphabetic)).collect();
    if !tips.is_empty() {
        return Meaning::RingTip(tips);
    }
    if names.is_empty() { Meaning::Plain } else { Meaning::Names(names) }
}

/// Type of a value, from a value and its size.
fn wire_of(leaf: &Leaf, size: usize) -> Wire {
    match leaf {
        Leaf::Unsigned(_) => Wire::Unsigned(size),
        Leaf::Signed(_) => Wire::Signed(size),
        Leaf::Float(_) => Wire::Float,
        Leaf::Text(_) => Wire::Text(Some(size).filter(|&size| size > 0)),
        Leaf::Secret(_) => Wire::Secret,
        Leaf::Bytes(_) => Wire::Bytes(Some(size)),
    }
}
