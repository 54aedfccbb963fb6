//! Inspector: the messages of a capture as rows of a table.

use examples::cli::{Protocol, Stop, Transport};
use examples::record::{Body, Find, Kind, Record, hex, side_name};
use examples::tap::{Tap, tap};
use examples::text::{Format, Senders, Source, SourceError, TextProblem};
use motion_core::lint::Severity;
use motion_core::wire::FieldView;
use serde::Deserialize;
use serde_json::{Value, json};

/// Greatest number of rows of a table. A browser draws more only slowly; the other messages are counted.
const ROWS: usize = 2000;
/// Greatest number of characters of a value.
const LONGEST: usize = 400;
/// Number of bytes at the beginning of a capture by which the protocol is found.
const SAMPLE: usize = 64 * 1024;

/// Choices of the user. A choice that is missing is found by the program.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct Options {
    protocol: Option<String>,
    transport: Option<String>,
    from: Option<String>,
}

/// Protocol by the name that the page uses.
pub(crate) fn protocol(name: &str) -> Result<Protocol, String> {
    match name {
        "kos" => Ok(Protocol::Kos),
        "dmc" => Ok(Protocol::Dmc),
        "hoot" => Ok(Protocol::Hoot),
        _ => Err(format!("there is no protocol {name:?}: choose kos, dmc or hoot")),
    }
}

const fn name(protocol: Protocol) -> &'static str {
    match protocol {
        Protocol::Kos => "kos",
        Protocol::Dmc => "dmc",
        Protocol::Hoot => "hoot",
    }
}

/// Messages of a capture. If the capture breaks off, the rows before that are shown, and `error` says where.
pub(crate) fn inspect(options: &Options, capture: &[u8]) -> Result<Value, String> {
    if capture.is_empty() {
        return Err("the capture is empty: paste a text dump, or open a file".to_owned());
    }
    let senders = match options.from.as_deref() {
        None => None,
        Some("host") => Some(Senders::Host),
        Some("device") => Some(Senders::Device),
        Some(other) => return Err(format!("there is no sender {other:?}: choose host or device")),
    };
    let transport = match options.transport.as_deref() {
        None | Some("stream") => Transport::Stream,
        Some("datagram") => Transport::Datagram,
        Some("usb") => Transport::Usb,
        Some(other) => return Err(format!("there is no transport {other:?}: choose stream, datagram or usb")),
    };
    let protocol = match options.protocol.as_deref() {
        Some(name) => protocol(name)?,
        // Only kOS uses datagrams and reports.
        None if transport != Transport::Stream => Protocol::Kos,
        None => detect(capture, senders)?,
    };
    let mut rows = Rows::default();
    let mut line =
        tap(protocol, transport).map_err(|_| format!("{} has no such transport: choose a stream", name(protocol)))?;
    let end = read(capture, senders, &mut *line, &mut |record| rows.add(record));
    let mut answer = json!({
        "protocol": name(protocol),
        "detected": options.protocol.is_none(),
        "rows": rows.shown,
        "count": rows.count,
        "bad": rows.bad,
    });
    if let Err(error) = end {
        if rows.count == 0 {
            return Err(error);
        }
        answer["error"] = error.into();
    }
    Ok(answer)
}

/// Reads a capture to its end, or to its first error.
fn read(
    capture: &[u8],
    senders: Option<Senders>,
    line: &mut dyn Tap,
    see: &mut dyn FnMut(&Record<'_>),
) -> Result<(), String> {
    let mut see = |record: &Record<'_>| {
        see(record);
        Ok(())
    };
    let wrong = |stop: Stop| stop.to_string();
    let mut source = Source::new(capture, Format::Auto, senders).map_err(|error| said(&error))?;
    let result = loop {
        match source.next_piece() {
            Ok(Some(piece)) => line.push(piece, &mut see).map_err(wrong)?,
            Ok(None) => break Ok(()),
            Err(error) => break Err(said(&error)),
        }
    };
    line.end(&mut see).map_err(wrong)?;
    result
}

/// An error of the input as one line, which says what to do in the page.
fn said(error: &SourceError) -> String {
    match error {
        SourceError::Unsaid => {
            "nothing says who sent these bytes: choose host or device as the sender, or mark each line \
                                with > (host) or < (device)"
                .to_owned()
        }
        SourceError::Guessed(error) | SourceError::Text(error) => {
            let (line, column) = (error.line, error.column);
            let what = match &error.what {
                TextProblem::Unmarked => {
                    "the line has no mark > (host) or < (device): mark each line, or choose the sender"
                }
                TextProblem::OtherSide => "the mark of the line contradicts the sender: choose \"as marked\"",
                TextProblem::Ambiguous => "000000 may be an offset or three bytes: end an offset with a colon",
                what => return format!("line {line}, column {column}: {what}"),
            };
            format!("line {line}, column {column}: {what}")
        }
        error => error.to_string(),
    }
}

/// Protocol whose messages fill the most of a capture.
fn detect(capture: &[u8], senders: Option<Senders>) -> Result<Protocol, String> {
    let mut best = (0.0, None);
    let mut error = None;
    for protocol in [Protocol::Dmc, Protocol::Kos, Protocol::Hoot] {
        let (mut good, mut all) = (0, 0);
        let Ok(mut line) = tap(protocol, Transport::Stream) else { continue };
        // The head may end inside a line, and the rows before an error count as well.
        let read = read(&capture[..capture.len().min(SAMPLE)], senders, &mut *line, &mut |record| {
            all += record.len;
            if is_sure(record) {
                good += record.len;
            }
        });
        error = error.or(read.err());
        #[expect(clippy::cast_precision_loss, reason = "a share")]
        let share = good as f64 / all.max(1) as f64;
        if share > best.0 {
            best = (share, Some(protocol));
        }
    }
    best.1.ok_or_else(|| {
        error.unwrap_or_else(|| "no message of kOS, DMC or hoot is in these bytes: choose the protocol".to_owned())
    })
}

/// Whether a record is a known message without faults.
fn is_sure(record: &Record<'_>) -> bool {
    let Find::Frame(shown) = &record.find else { return false };
    let known = shown.message.is_some_and(|name| !matches!(name, "Other" | "Unknown"));
    known && shown.canonical && shown.lints.iter().all(|lint| lint.severity != Severity::Error)
}

/// Rows of a table.
#[derive(Default)]
pub(crate) struct Rows {
    pub(crate) shown: Vec<Value>,
    /// Number of messages, shown or not.
    pub(crate) count: u64,
    /// Number of messages with an error.
    pub(crate) bad: u64,
}

impl Rows {
    pub(crate) fn add(&mut self, record: &Record<'_>) {
        self.count += 1;
        let row = row(record, self.count);
        self.bad += u64::from(row["mark"] == "error");
        if self.shown.len() < ROWS {
            self.shown.push(row);
        }
    }
}

fn row(record: &Record<'_>, number: u64) -> Value {
    let mut row = json!({
        "number": number,
        "from": side_name(record.from),
        "offset": record.offset,
        "len": record.len,
        "mark": "",
        "subtitle": "",
        "fields": [],
        "notes": [],
    });
    let mut notes: Vec<(&str, String)> = Vec::new();
    match &record.find {
        Find::Other { kind, why, start } => {
            row["title"] = kind.key().into();
            notes.push((if *kind == Kind::Noise { "warning" } else { "error" }, format!("{why}: {}", hex(start))));
        }
        Find::Frame(shown) => {
            row["title"] = shown.title.clone().into();
            row["subtitle"] = shown.subtitle.clone().into();
            match &shown.body {
                Body::Error(why, data) => notes.push(("error", format!("{why}: {}", short(hex(data))))),
                Body::Fields(fields) => {
                    let mut all = Vec::new();
                    fields.fields(&mut |field: &FieldView<'_>| {
                        let unit = if field.unit.is_empty() { String::new() } else { format!(" {}", field.unit) };
                        all.push(json!([field.name, short(field.text.to_string()) + &unit]));
                    });
                    row["fields"] = all.into();
                    if !shown.canonical {
                        notes.push(("warning", "not canonical".to_owned()));
                    }
                }
            }
            for lint in &shown.lints {
                let severity = if lint.severity == Severity::Error { "error" } else { "warning" };
                notes.push((severity, lint.to_string()));
            }
        }
    }
    let mark = ["error", "warning"].into_iter().find(|mark| notes.iter().any(|(severity, _)| severity == mark));
    row["mark"] = mark.unwrap_or_default().into();
    row["notes"] = json!(notes);
    row
}

fn short(text: String) -> String {
    match text.char_indices().nth(LONGEST) {
        None => text,
        Some((at, _)) => format!("{}…", &text[..at]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAPTURES: [(&str, &str); 4] = [
        ("kos", include_str!("../../examples/captures/kos.txt")),
        ("dmc", include_str!("../../examples/captures/dmc.txt")),
        ("dmc", include_str!("../../examples/captures/dmc-move.txt")),
        ("hoot", include_str!("../../examples/captures/hoot.txt")),
    ];

    #[test]
    fn the_protocol_of_each_capture_is_found() {
        for (protocol, capture) in CAPTURES {
            let answer = inspect(&Options::default(), capture.as_bytes()).unwrap();
            assert_eq!((&answer["protocol"], &answer["error"]), (&protocol.into(), &Value::Null));
            let rows = answer["rows"].as_array().unwrap();
            assert!(rows.len() > 5 && answer["count"] == rows.len());
            assert!(["host", "device"].iter().all(|side| rows.iter().any(|row| row["from"] == *side)), "{answer}");
        }
    }

    #[test]
    fn a_corrupt_frame_is_an_error_row() {
        let answer = inspect(&Options::default(), CAPTURES[1].1.as_bytes()).unwrap();
        let row = answer["rows"].as_array().unwrap().iter().find(|row| row["title"] == "corrupt").unwrap();
        assert!(row["mark"] == "error" && answer["bad"].as_u64() > Some(0), "{row}");
    }

    #[test]
    fn a_bad_line_keeps_the_rows_before_it() {
        let capture = format!("{}> 0g\n", CAPTURES[0].1);
        let answer = inspect(&Options::default(), capture.as_bytes()).unwrap();
        assert!(answer["count"].as_u64() > Some(5));
        let error = answer["error"].as_str().unwrap();
        assert!(error.contains("is a single hex digit") && !error.contains('\n'), "{error}");
    }

    #[test]
    fn raw_bytes_need_a_sender() {
        let bytes = [0, 0, 0, 0, 0, 0xFF, 3, 1, 4, 0];
        let error = inspect(&Options::default(), &bytes).unwrap_err();
        assert!(error.contains("choose host or device"), "{error}");
        let error = inspect(&Options::default(), b"04 00").unwrap_err();
        assert!(error.contains("choose the sender") && !error.contains("--"), "{error}");
        let options = Options { from: Some("host".to_owned()), ..Options::default() };
        let answer = inspect(&options, &bytes).unwrap();
        assert_eq!((&answer["protocol"], &answer["rows"][0]["title"]), (&"hoot".into(), &"MotorStop".into()));
    }
}
