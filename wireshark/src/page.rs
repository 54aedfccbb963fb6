//! Page of all messages.

use std::fmt::Write as _;

use crate::names::{Names, numbered};
use crate::probe::{Field, Meaning, Message, Presence, Shape, Wire};
use crate::protocol::{IRREGULAR, Protocol};

const HEAD: &str = "\
# Messages

`cargo run -p wireshark` makes this page from the tables of messages, and a test compares it with them. The tables of the
crates, the dissectors for [Wireshark](../wireshark/README.md) and this page therefore say the same.

The column `data` lists the fields of the data in the order of the wire: the offset in bytes from the start of the data, the
name, the type, and the unit. The types are those of Rust. `1/100 %` is a number that counts hundredths of a percent. `of
name` refers to the names of numbers and bits at the end of each chapter. A field in brackets may be missing, with all
fields after it. `n ×` repeats a field or a group to the end of the data, or as often as the field before it says. `length`
is the number of bytes of the data, and `+` says that there may be more. Messages of kOS and DMC may go on after their last
field; the bytes are kept.

## Conduct

The conduct of a message says what the message does to motors, and whether it may be sent again after a silence. Machines,
rigs and lint read the same tables.

| conduct | meaning |
|---|---|
| asks | changes nothing |
| sets | changes a setting or an output, or takes a photo; moves no motor |
| moves | a motor may start to move, or change how it moves |
| arms | prepares a motion that a later message or an operator starts |
| stops | stops motors; goes out before everything else, and again until it is confirmed |
| resets | the device starts anew or takes another address |
| by its values | the values of the message decide between two of these |

`once` means that the message is never sent twice by itself. `in sequence` means that the message belongs to an exchange of
several messages. `blocks` means that the device may hear nothing for this number of milliseconds.
";

/// Text of the page.
#[must_use]
pub fn page(protocols: &[Protocol]) -> String {
    let mut page = HEAD.to_owned();
    for protocol in protocols {
        chapter(&mut page, protocol);
    }
    page
}

fn chapter(page: &mut String, protocol: &Protocol) {
    let names = &Names::of(protocol);
    let Protocol { name, digits, host, later, device, groups, answers, note, .. } = protocol;
    let _ = write!(page, "\n## {name}\n\n{note}\n");
    for (messages, which) in [(host, "messages of the host"), (later, "messages of the host to later firmware")] {
        if messages.is_empty() {
            continue;
        }
        let _ = write!(
            page,
            "\n### {name}: {which}\n\n| number | message | conduct | length | data |\n|---|---|---|---|---|\n"
        );
        for message in messages {
            let conduct = message.conduct.map_or_else(|| "by its values".to_owned(), |conduct| conduct.to_string());
            row(page, names, message, *digits, Some(&conduct));
        }
    }
    let _ = write!(page, "\n### {name}: messages of the device\n\n");
    page.push_str("| number | message | length | data |\n|---|---|---|---|\n");
    for message in device {
        row(page, names, message, *digits, None);
    }
    if let Some((list, groups)) = groups {
        let _ = write!(page, "\n### {name}: {list}\n\n| number | name | length | data |\n|---|---|---|---|\n");
        for message in groups {
            row(page, names, message, 1, None);
        }
    }
    if !answers.is_empty() {
        let _ = write!(page, "\n### {name}: answers to queries\n\n| query | types of the value |\n|---|---|\n");
        for answer in answers {
            let types = answer.types.iter().map(|(value_type, meaning, unit)| {
                let meaning = meaning_text(names, meaning, unit);
                format!("{}{meaning}", hoot_proto::message::ValueType(*value_type))
            });
            let _ = writeln!(page, "| {} | {} |", answer.query, types.collect::<Vec<_>>().join(", "));
        }
    }
    let _ = write!(page, "\n### {name}: names of numbers and bits\n\n| name | values |\n|---|---|\n");
    for (name, meaning) in names.sorted() {
        let (values, hex) = match meaning {
            Meaning::Flags(values) => (values, true),
            Meaning::Names(values) | Meaning::RingTip(values) => (values, false),
            _ => continue,
        };
        let entry =
            |(value, name): &(u64, String)| if hex { format!("{value:#x} {name}") } else { format!("{value} {name}") };
        let mut values = values.iter().map(entry).collect::<Vec<_>>().join(", ");
        if matches!(meaning, Meaning::RingTip(_)) {
            values += "; the upper byte is the ring of the plug, the lower byte the tip";
        }
        let _ = writeln!(page, "| `{name}` | {values} |");
    }
}

fn row(page: &mut String, names: &Names, message: &Message, digits: usize, conduct: Option<&str>) {
    let Message { number, last, also, name, sub, fields, .. } = message;
    let _ = write!(page, "| `{number:#0width$x}`", width = digits + 2);
    if last > number {
        let _ = write!(page, " to `{last:#0width$x}`", width = digits + 2);
    }
    if let Some(also) = also {
        let _ = write!(page, ", `{also:#0width$x}`", width = digits + 2);
    }
    let _ = write!(page, " | {name} |");
    if let Some(conduct) = conduct {
        let _ = write!(page, " {conduct} |");
    }
    if let Some((_, data)) = IRREGULAR.iter().find(|(irregular, _)| irregular == name) {
        let _ = writeln!(page, " | {data} |");
        return;
    }
    let shortest =
        fields.iter().map(|field| if field.presence == Presence::Always { least(field) } else { 0 }).sum::<usize>();
    let is_fixed =
        |field: &Field| field.presence == Presence::Always && matches!(field.shape, Shape::One | Shape::Times(_));
    let more = if fields.iter().all(is_fixed) { "" } else { "+" };
    let mut texts: Vec<_> = fields.iter().map(|field| text(names, field)).collect();
    if let Some(sub) = sub {
        texts.insert(0, format!("{sub}: the sub-address"));
    }
    let _ = writeln!(page, " {shortest}{more} |{}{} |", if texts.is_empty() { "" } else { " " }, texts.join("; "));
}

/// Least number of bytes of a field that is present.
fn least(field: &Field) -> usize {
    match field.shape {
        Shape::One => field.wire.size().unwrap_or(0),
        Shape::Times(times) => times * field.wire.size().unwrap_or(0),
        Shape::List | Shape::Groups(_) | Shape::Rest => 0,
        Shape::Counted(..) => 1,
        Shape::Prefixed => 2,
    }
}

fn text(names: &Names, field: &Field) -> String {
    let Field { name, offset, wire, shape, unit, meaning, presence } = field;
    let kind = match (wire, meaning) {
        (_, Meaning::Ipv4) => "IPv4 address".to_owned(),
        (_, Meaning::Mac) => "MAC address".to_owned(),
        (Wire::Unsigned(size), _) => format!("u{}", size * 8),
        (Wire::Signed(size), _) => format!("i{}", size * 8),
        (Wire::Float, _) => "f32".to_owned(),
        (Wire::Text(Some(size)), _) => format!("text of {size} bytes"),
        (Wire::Text(None), _) => "text".to_owned(),
        (Wire::Secret, _) => "password".to_owned(),
        (Wire::Bytes(_), _) => "bytes".to_owned(),
    };
    let group = |fields: &[Field]| {
        let inner = |field: &Field| text(names, &Field { offset: None, ..field.clone() });
        format!("({})", fields.iter().map(inner).collect::<Vec<_>>().join(", "))
    };
    let kind = match shape {
        Shape::One | Shape::Rest => format!("{name} {kind}"),
        Shape::Times(times) => format!("{name} {times} × {kind}"),
        Shape::List => format!("{name} n × {kind}"),
        Shape::Groups(fields) => format!("{name} n × {}", group(fields)),
        Shape::Counted(count, fields) => format!("{count} u8; {name} n × {}", group(fields)),
        Shape::Prefixed => format!("{name} length u16 and {kind}"),
    };
    let offset = offset.map_or_else(String::new, |offset| format!("{offset} "));
    let whole = format!("{offset}{kind}{}", meaning_text(names, meaning, unit));
    if *presence == Presence::Always { whole } else { format!("[{whole}]") }
}

/// Unit and names of a value, with a space before them.
fn meaning_text(names: &Names, meaning: &Meaning, unit: &str) -> String {
    let space = if unit.is_empty() { "" } else { " " };
    if let Some(bits) = numbered(meaning) {
        return format!(", bits numbered 1 to {bits}");
    }
    match meaning {
        Meaning::Scaled(decimals) => {
            format!(" in 1/{}{space}{unit}", 10_u64.pow(u32::try_from(*decimals).unwrap_or(0)))
        }
        _ => match names.get(meaning) {
            Some("yes_or_no") => ", yes or no".to_owned(),
            Some(name) => format!(" of `{name}`"),
            None if unit.is_empty() => String::new(),
            None => format!(" in {unit}"),
        },
    }
}
