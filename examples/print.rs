//! Printing of records for human readers.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{self, Write};

use anstyle::{AnsiColor, Style};
use motion_core::lint::Severity;
use motion_core::wire::{FieldView, Fields, List, Value};

use crate::record::{Body, Find, Kind, Record, Shown, hex, side_name};
use crate::text::Side;

const BOLD: Style = Style::new().bold();
const DIM: Style = Style::new().dimmed();
const HOST: Style = AnsiColor::Cyan.on_default();
const DEVICE: Style = AnsiColor::Magenta.on_default();
const BAD: Style = AnsiColor::Red.on_default().bold();
const DOUBTFUL: Style = AnsiColor::Yellow.on_default();
const GOOD: Style = AnsiColor::Green.on_default();

/// Width of a line of fields, in columns.
const WIDTH: usize = 100;
/// Column in which fields begin.
const INDENT: usize = 12;
/// Number of the first group of a list that is not shown.
const SHOWN_GROUPS: u64 = 33;
/// Number of characters that are shown of the value of one field.
const MAX_VALUE: usize = 400;

/// Printer of records and of a summary at their end.
pub struct Printer<W> {
    out: W,
    secrets: bool,
    sums: BTreeMap<&'static str, Sum>,
    messages: BTreeMap<(&'static str, String), u64>,
}

/// Counts of the bytes and frames that one side sent.
#[derive(Default)]
struct Sum {
    frames: u64,
    frame_bytes: u64,
    noise_bytes: u64,
    corrupt: u64,
    undecoded: u64,
    errors: u64,
    warnings: u64,
}

impl<W: Write> Printer<W> {
    /// A printer without records. Passwords are shown if `secrets` is true.
    pub const fn new(out: W, secrets: bool) -> Self {
        Self { out, secrets, sums: BTreeMap::new(), messages: BTreeMap::new() }
    }

    /// Whether no record was printed since the last summary.
    #[must_use]
    pub fn is_silent(&self) -> bool {
        self.sums.is_empty()
    }

    /// Prints the name of the source of the following records.
    ///
    /// # Errors
    ///
    /// Errors of the output.
    pub fn title(&mut self, title: &str) -> io::Result<()> {
        writeln!(self.out, "{BOLD}{title}{BOLD:#}")
    }

    /// Prints a record.
    ///
    /// # Errors
    ///
    /// Errors of the output.
    pub fn record(&mut self, record: &Record<'_>) -> io::Result<()> {
        self.count(record);
        let (mark, style) = match record.from {
            Side::Host => ('>', HOST),
            Side::Device => ('<', DEVICE),
        };
        write!(self.out, "{DIM}{:08x}{DIM:#}  {style}{mark}{style:#} ", record.offset)?;
        match &record.find {
            Find::Frame(shown) => self.frame(shown, record.len),
            Find::Other { kind, why, start } => self.other(*kind, why, start, record.len),
        }
    }

    fn frame(&mut self, shown: &Shown<'_>, len: u64) -> io::Result<()> {
        write!(self.out, "{BOLD}{}{BOLD:#}  ", shown.title)?;
        if !shown.subtitle.is_empty() {
            write!(self.out, "{}  ", shown.subtitle)?;
        }
        write!(self.out, "{DIM}{}{DIM:#}", plural(len, "byte"))?;
        if shown.checked {
            write!(self.out, "  {GOOD}checksum ok{GOOD:#}")?;
        }
        if !shown.canonical && matches!(shown.body, Body::Fields(_)) {
            write!(self.out, "  {DOUBTFUL}not canonical{DOUBTFUL:#}")?;
        }
        writeln!(self.out)?;
        match &shown.body {
            Body::Fields(fields) => {
                let mut column = 0;
                let mut result = Ok(());
                fields.fields(&mut |field: &FieldView<'_>| {
                    if result.is_ok() {
                        result = self.field(field, &mut column);
                    }
                });
                result?;
                if column > 0 {
                    writeln!(self.out)?;
                }
            }
            Body::Error(why, data) => {
                writeln!(self.out, "{:INDENT$}{BAD}{why}{BAD:#}  {DIM}{}{DIM:#}", "", ellipsis(&hex(data)))?;
            }
        }
        for lint in &shown.lints {
            let style = if lint.severity == Severity::Error { BAD } else { DOUBTFUL };
            writeln!(self.out, "{:INDENT$}{style}{}{style:#}: {lint}", "", lint.severity)?;
        }
        Ok(())
    }

    /// Prints `name value unit`, in the next line if this one is full.
    fn field(&mut self, field: &FieldView<'_>, column: &mut usize) -> io::Result<()> {
        if let Value::List(list) = field.value
            && self.groups(field.name, list, column)?
        {
            return Ok(());
        }
        let mut text = ellipsis(&match field.value {
            Value::Secret(bytes) if self.secrets => format!("\"{}\"", bytes.escape_ascii()),
            _ => field.text.to_string(),
        });
        if !field.unit.is_empty() {
            let _ = write!(text, " {}", field.unit);
        }
        let width = field.name.chars().count() + 1 + text.chars().count();
        if *column > 0 && *column + 3 + width > WIDTH {
            writeln!(self.out)?;
            *column = 0;
        }
        if *column == 0 {
            write!(self.out, "{:INDENT$}", "")?;
            *column = INDENT;
        } else {
            write!(self.out, "{DIM} · {DIM:#}")?;
            *column += 3;
        }
        *column += width;
        write!(self.out, "{DIM}{}{DIM:#} {text}", field.name)
    }

    /// Prints a list of groups, each in lines of its own. Returns whether the list has a group.
    fn groups(&mut self, name: &str, list: &dyn List, column: &mut usize) -> io::Result<bool> {
        let (mut result, mut number) = (Ok(()), 0);
        list.each(&mut |value| {
            if let (Value::Group(fields), Ok(())) = (value, &result) {
                number += 1;
                result = self.group(name, number, fields, column);
            }
        });
        result.map(|()| number > 0)
    }

    fn group(&mut self, name: &str, number: u64, fields: &dyn Fields, column: &mut usize) -> io::Result<()> {
        match number {
            SHOWN_GROUPS.. => {
                if number == SHOWN_GROUPS {
                    write!(self.out, "\n{:INDENT$}{DIM}{name}[{number}] ..{DIM:#}", "")?;
                }
                return Ok(());
            }
            _ if *column > 0 => writeln!(self.out)?,
            _ => {}
        }
        let label = format!("{name}[{number}]");
        write!(self.out, "{:INDENT$}{DIM}{label}{DIM:#}", "")?;
        *column = INDENT + label.len();
        let mut result = Ok(());
        fields.fields(&mut |field: &FieldView<'_>| {
            if result.is_ok() {
                result = self.field(field, column);
            }
        });
        result
    }

    fn other(&mut self, kind: Kind, why: &str, start: &[u8], len: u64) -> io::Result<()> {
        let style = if kind == Kind::Noise { DOUBTFUL } else { BAD };
        write!(self.out, "{style}{}{style:#}", kind.key())?;
        if len > 0 {
            let more = if len > start.len() as u64 { " .." } else { "" };
            let bytes: Vec<String> = start.iter().map(|byte| format!("{byte:02x}")).collect();
            write!(self.out, "  {DIM}{}: {}{more}{DIM:#}", plural(len, "byte"), bytes.join(" "))?;
        }
        writeln!(self.out, "\n{:INDENT$}{why}", "")
    }

    fn count(&mut self, record: &Record<'_>) {
        let sum = self.sums.entry(side_name(record.from)).or_default();
        match &record.find {
            Find::Frame(shown) => {
                sum.frames += 1;
                sum.frame_bytes += record.len;
                sum.undecoded += u64::from(matches!(shown.body, Body::Error(..)));
                for lint in &shown.lints {
                    let lints = if lint.severity == Severity::Error { &mut sum.errors } else { &mut sum.warnings };
                    *lints += 1;
                }
                let name = (side_name(record.from), shown.title.clone());
                *self.messages.entry(name).or_default() += 1;
            }
            Find::Other { kind: Kind::Corrupt, .. } => {
                sum.corrupt += 1;
                sum.noise_bytes += record.len;
            }
            Find::Other { .. } => sum.noise_bytes += record.len,
        }
    }

    /// Prints the summary of the records and resets the counts.
    ///
    /// # Errors
    ///
    /// Errors of the output.
    pub fn summary(&mut self) -> io::Result<()> {
        let Self { out, sums, messages, .. } = self;
        if sums.is_empty() {
            writeln!(out, "{DIM}no bytes{DIM:#}")?;
        }
        for (side, sum) in std::mem::take(sums) {
            write!(out, "{BOLD}{side}{BOLD:#}: {} in {} bytes", plural(sum.frames, "frame"), sum.frame_bytes)?;
            if sum.noise_bytes > 0 {
                write!(out, ", {DOUBTFUL}{} of noise{DOUBTFUL:#}", plural(sum.noise_bytes, "byte"))?;
            }
            for (count, style, what) in [
                (sum.corrupt, BAD, "corrupt frame"),
                (sum.undecoded, BAD, "undecoded frame"),
                (sum.errors, BAD, "error"),
                (sum.warnings, DOUBTFUL, "warning"),
            ] {
                if count > 0 {
                    write!(out, ", {style}{}{style:#}", plural(count, what))?;
                }
            }
            let of_side = messages.iter().filter(|((from, _), _)| *from == side);
            let names: Vec<String> = of_side.map(|((_, name), count)| format!("{name} {count}")).collect();
            writeln!(out)?;
            if !names.is_empty() {
                writeln!(out, "{DIM}  {}{DIM:#}", names.join(", "))?;
            }
        }
        messages.clear();
        writeln!(out)
    }
}

fn plural(count: u64, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}

/// Cuts a text to [`MAX_VALUE`] characters and adds the number of missing characters.
fn ellipsis(text: &str) -> String {
    match text.char_indices().nth(MAX_VALUE) {
        None => text.to_owned(),
        Some((at, _)) => {
            let (shown, rest) = text.split_at(at);
            format!("{shown}… ({} more)", rest.chars().count())
        }
    }
}
