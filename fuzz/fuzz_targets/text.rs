//! Any text as `inspect` reads it: reading ends, it does not depend on the cuts, and its meaning can be printed and
//! read again.
//!
//! Input: how to read it (bits 0 and 1 the format, bits 2 and 3 the senders), then the text.

#![no_main]

use std::fmt::Write as _;
use std::io::{self, Read};

use examples::text::{Format, Senders, Side, Source};
use libfuzzer_sys::fuzz_target;

/// Number of bytes after which reading ends, because a `*` of a few letters may stand for a mebibyte.
const ENOUGH: usize = 4 * 1024 * 1024;

fuzz_target!(|input: &[u8]| {
    let Some((how, input)) = input.split_first() else { return };
    let format = [Format::Auto, Format::Raw, Format::Hex, Format::Xxd][usize::from(how & 3)];
    let senders = [None, Some(Senders::Host), Some(Senders::Device), Some(Senders::Both)][usize::from(how >> 2 & 3)];

    let (records, error) = read(input, format, senders);
    assert_eq!(read(Trickle(input), format, senders), (records.clone(), error), "read byte by byte");
    if !records.is_empty() {
        assert_eq!(read(print(&records).as_bytes(), Format::Hex, None), (records, None), "read again");
    }
});

/// Sender and bytes.
type Record = (Side, Vec<u8>);

/// Records of an input, and the error that ended it.
fn read(input: impl Read, format: Format, senders: Option<Senders>) -> (Vec<Record>, Option<String>) {
    let mut records: Vec<Record> = Vec::new();
    let mut source = match Source::new(input, format, senders) {
        Ok(source) => source,
        Err(error) => return (records, Some(error.to_string())),
    };
    let mut total = 0;
    while total < ENOUGH {
        match source.next_piece() {
            Ok(Some(piece)) => {
                assert!(!piece.bytes.is_empty(), "a piece without bytes");
                total += piece.bytes.len();
                match records.last_mut() {
                    Some((side, bytes)) if !piece.first && *side == piece.side => bytes.extend(piece.bytes),
                    _ => {
                        assert!(piece.first, "a piece that continues no record");
                        records.push((piece.side, piece.bytes.to_vec()));
                    }
                }
            }
            Ok(None) => return (records, None),
            Err(error) => return (records, Some(error.to_string())),
        }
    }
    (records, None)
}

/// Prints one line for each record.
fn print(records: &[Record]) -> String {
    let mut text = String::new();
    for (side, bytes) in records {
        text.push_str(if *side == Side::Host { "> " } else { "< " });
        for byte in bytes {
            write!(text, "{byte:02x}").expect("a String takes any text");
        }
        text.push('\n');
    }
    text
}

/// Reader that gives one byte at a time.
struct Trickle<'a>(&'a [u8]);

impl Read for Trickle<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let len = into.len().min(1);
        self.0.read(&mut into[..len])
    }
}
