//! Dissectors in Lua: tables that are made from the messages, and code that is written by hand.

use std::fmt::Write as _;

use crate::names::{Names, numbered};
use crate::probe::{Field, Meaning, Message, Presence, Shape, Wire};
use crate::protocol::Protocol;

/// Code that all dissectors share.
const SHARED: &str = include_str!("../lua/shared.lua");

/// Whole text of a dissector. It needs no other file, so that it is installed by copying it.
#[must_use]
pub fn dissector(protocol: &Protocol) -> String {
    let Protocol { key, name, line, host, later, device, groups, answers, by_hand, .. } = protocol;
    let tables = Tables { names: &Names::of(protocol) };
    let mut body = String::new();
    let host: Vec<_> = host.iter().chain(later).collect();
    tables.messages(&mut body, "HOST", "Messages of the host, by number.", &host);
    tables.messages(&mut body, "DEVICE", "Messages of the device, by number.", &device.iter().collect::<Vec<_>>());
    if let Some((list, groups)) = groups {
        tables.messages(
            &mut body,
            &list.to_uppercase(),
            &format!("Layouts of the {list}, by number."),
            &groups.iter().collect::<Vec<_>>(),
        );
    }
    if !answers.is_empty() {
        body.push_str(
            "-- Values that answer a query, by the name of the query and the type of the value.\nlocal ANSWERS = {\n",
        );
        for answer in answers {
            let types = answer.types.iter().map(|(value_type, meaning, unit)| {
                let unit = if unit.is_empty() { String::new() } else { format!("unit = \"{unit}\"") };
                let parts: Vec<_> =
                    [tables.meaning(meaning), unit].into_iter().filter(|part| !part.is_empty()).collect();
                format!("[{value_type}] = {{ {} }}", parts.join(", ")).replace("{  }", "{}")
            });
            let types: Vec<_> = types.collect();
            let _ = writeln!(body, "  {} = {{ {} }},", answer.query, types.join(", "));
        }
        body.push_str("}\n\n");
    }
    let names = tables.names();
    format!(
        "\
-- Dissector of {name} for Wireshark.
--
-- `cargo run -p wireshark` makes this file: the tables from those of the Rust crate `{key}-proto`, the code after them
-- from `wireshark/lua`. Change those, not this file. How to install it: `wireshark/README.md`.
-- SPDX-License-Identifier: MIT OR Apache-2.0

local KEY, NAME = \"{key}\", \"{name}\"
{line}

-- Names of numbers and of bits. A number instead of names says that so many bits have numbers as names, from 1.
local N = {{}}
{names}
{body}{SHARED}
{by_hand}"
    )
}

/// Writer of tables in Lua.
struct Tables<'n> {
    names: &'n Names,
}

impl Tables<'_> {
    /// Table of messages under a name.
    fn messages(&self, out: &mut String, table: &str, what: &str, messages: &[&Message]) {
        let _ = writeln!(out, "-- {what}\nlocal {table} = {{");
        for message in messages {
            let _ = write!(out, "  {{ name = \"{}\", number = {:#x}", message.name, message.number);
            if message.last > message.number {
                let _ = write!(out, ", last = {:#x}", message.last);
            }
            if let Some(also) = message.also {
                let _ = write!(out, ", also = {also:#x}");
            }
            if let Some(sub) = &message.sub {
                let _ = write!(out, ", sub = \"{sub}\"");
            }
            if message.tail {
                out.push_str(", tail = true");
            }
            self.fields(out, &message.fields, "    ");
            out.push_str(if message.fields.is_empty() { " },\n" } else { "  },\n" });
        }
        out.push_str("}\n\n");
    }

    /// Rows of fields, each on a line of its own.
    fn fields(&self, out: &mut String, fields: &[Field], indent: &str) {
        for (index, field) in fields.iter().enumerate() {
            out.push_str(if index == 0 && indent.len() == 4 { ",\n" } else { "" });
            let _ = write!(out, "{indent}{{ \"{}\", ", field.name);
            self.field(out, field, indent);
            out.push_str(" },\n");
        }
    }

    /// Row of a field, after its name.
    fn field(&self, out: &mut String, field: &Field, indent: &str) {
        let kind = match (field.wire, &field.meaning) {
            (_, Meaning::Ipv4) => "ipv4".to_owned(),
            (_, Meaning::Mac) => "mac".to_owned(),
            (Wire::Unsigned(size), _) => format!("u{}", size * 8),
            (Wire::Signed(size), _) => format!("i{}", size * 8),
            (Wire::Float, _) => "f32".to_owned(),
            (Wire::Text(_), _) => "text".to_owned(),
            (Wire::Secret, _) => "secret".to_owned(),
            (Wire::Bytes(_), _) => "bytes".to_owned(),
        };
        let _ = write!(out, "\"{kind}\"");
        if let Wire::Text(Some(size)) = field.wire {
            let _ = write!(out, ", size = {size}");
        }
        let meaning = self.meaning(&field.meaning);
        if !meaning.is_empty() {
            let _ = write!(out, ", {meaning}");
        }
        if !field.unit.is_empty() {
            let _ = write!(out, ", unit = \"{}\"", field.unit);
        }
        match field.presence {
            Presence::Always => {}
            Presence::If(needed) => {
                let _ = write!(out, ", needs = {needed}");
            }
            Presence::Newer => out.push_str(", newer = true"),
        }
        match &field.shape {
            Shape::One => {}
            Shape::Times(times) => {
                let _ = write!(out, ", times = {times}");
            }
            Shape::List => out.push_str(", list = true"),
            Shape::Prefixed => out.push_str(", prefixed = true"),
            Shape::Rest => out.push_str(", rest = true"),
            Shape::Groups(fields) => self.group(out, "list = true", fields, indent),
            Shape::Counted(count, fields) => self.group(out, &format!("count = \"{count}\""), fields, indent),
        }
    }

    /// List of groups.
    fn group(&self, out: &mut String, how: &str, fields: &[Field], indent: &str) {
        let _ = writeln!(out, ", {how}, of = {{");
        self.fields(out, fields, &format!("{indent}  "));
        let _ = write!(out, "{indent}}}");
    }

    /// How a person reads a value; empty if it is the value itself.
    fn meaning(&self, meaning: &Meaning) -> String {
        let how = match meaning {
            Meaning::Scaled(decimals) => return format!("decimals = {decimals}"),
            // A number that is not named is not an unknown one, unless all are names.
            Meaning::Names(names) if names.iter().all(|(_, name)| name.starts_with(char::is_uppercase)) => "names",
            Meaning::Names(_) => "words",
            Meaning::Flags(_) => "flags",
            Meaning::RingTip(_) => "ring_tip",
            Meaning::Plain | Meaning::Ipv4 | Meaning::Mac => return String::new(),
        };
        if let Some(bits) = numbered(meaning) {
            return format!("flags = {bits}");
        }
        let name = self.names.get(meaning).unwrap_or_default();
        format!("{how} = N.{name}")
    }

    /// Tables of names, in the order of the names of the tables.
    fn names(&self) -> String {
        let mut out = String::new();
        for (name, meaning) in self.names.sorted() {
            let (Meaning::Names(names) | Meaning::RingTip(names) | Meaning::Flags(names)) = meaning else { continue };
            let entry = |(value, name): &(u64, String)| match meaning {
                Meaning::Flags(_) => format!("{{ {value:#x}, \"{name}\" }}"),
                _ => format!("[{value}] = \"{name}\""),
            };
            let _ = write!(out, "N.{name} = {{ ");
            let mut line = 0;
            for (index, entry) in names.iter().map(entry).enumerate() {
                let separator = if index == 0 {
                    ""
                } else if line > 80 {
                    ",\n  "
                } else {
                    ", "
                };
                line = if line > 80 { 0 } else { line + entry.len() + 2 };
                let _ = write!(out, "{separator}{entry}");
            }
            out.push_str(" }\n");
        }
        out
    }
}
