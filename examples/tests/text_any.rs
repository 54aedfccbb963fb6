//! Properties of reading: written bytes are read back in each form, and reading of any input ends.

use std::fmt::Write as _;
use std::io::{self, Read};

use examples::text::{Format, MAX_LINE, MAX_REPEAT, Senders, Source, SourceError, TextProblem};
use proptest::prelude::*;

/// Reader that gives one byte at a time and is interrupted before each byte.
struct Slow<'a> {
    input: &'a [u8],
    ready: bool,
}

impl Read for Slow<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.ready = !self.ready;
        if self.ready {
            return Err(io::ErrorKind::Interrupted.into());
        }
        let room = buffer.len().min(1);
        self.input.read(&mut buffer[..room])
    }
}

/// Bytes of the host, and the number of bytes of the input that were read.
fn read(input: impl Read, format: Format) -> Result<(Vec<u8>, u64), SourceError> {
    let mut source = Source::new(input, format, Some(Senders::Host))?;
    let mut bytes = Vec::new();
    while let Some(piece) = source.next_piece()? {
        bytes.extend(piece.bytes);
    }
    Ok((bytes, source.bytes_read()))
}

fn host(text: &[u8]) -> Vec<u8> {
    let (bytes, count) = read(text, Format::Auto).expect("the text is valid");
    assert_eq!(count, text.len() as u64);
    bytes
}

/// Text column of a dump.
fn shown(bytes: &[u8]) -> String {
    let char = |byte: &u8| {
        if matches!(byte, b' '..=b'~') { char::from(*byte) } else { '.' }
    };
    bytes.iter().map(char).collect()
}

/// Dump as `xxd -c COLUMNS -g GROUP` prints it.
fn xxd(bytes: &[u8], columns: usize, group: usize) -> String {
    let mut text = String::new();
    let print = |row: &[u8]| {
        let words = row.chunks(group).map(|word| word.iter().map(|byte| format!("{byte:02x}")));
        words.map(String::from_iter).collect::<Vec<_>>().join(" ")
    };
    let width = print(&vec![0; columns]).len();
    for (index, row) in bytes.chunks(columns).enumerate() {
        let (offset, hex) = (index * columns, print(row));
        writeln!(text, "{offset:08x}: {hex:width$}  {}", shown(row)).expect("writing to a string does not fail");
    }
    text
}

/// Dump as `hexdump -C` prints it, with `*` for repeated lines.
fn hexdump(bytes: &[u8]) -> String {
    let mut text = String::new();
    let (mut last, mut starred) = (None, false);
    for (index, row) in bytes.chunks(16).enumerate() {
        if last == Some(row) {
            text += if starred { "" } else { "*\n" };
            starred = true;
            continue;
        }
        (last, starred) = (Some(row), false);
        let print = |half: &[u8]| half.iter().fold(String::new(), |text, byte| text + &format!(" {byte:02x}"));
        let (left, right) = row.split_at(row.len().min(8));
        let (offset, left, right, shown) = (index * 16, print(left), print(right), shown(row));
        writeln!(text, "{offset:08x} {left:24} {right:24}  |{shown}|").expect("writing to a string does not fail");
    }
    if !bytes.is_empty() {
        writeln!(text, "{:08x}", bytes.len()).expect("writing to a string does not fail");
    }
    text
}

/// Hex digits in groups of `group` bytes, with `columns` bytes in each line.
fn plain(bytes: &[u8], columns: usize, group: usize, upper: bool, lead: &str, gap: &str) -> String {
    let byte = |byte: &u8| {
        if upper { format!("{byte:02X}") } else { format!("{byte:02x}") }
    };
    let word = |word: &[u8]| lead.to_owned() + &word.iter().map(byte).collect::<String>();
    let line = |line: &[u8]| line.chunks(group).map(word).collect::<Vec<_>>().join(gap);
    bytes.chunks(columns).map(line).collect::<Vec<_>>().join("\n")
}

/// Bytes with runs of equal bytes, which a dump shortens.
fn runs() -> impl Strategy<Value = Vec<u8>> {
    let run = prop_oneof![
        proptest::collection::vec(any::<u8>(), 0..40),
        (any::<u8>(), 0_usize..200).prop_map(|(byte, count)| vec![byte; count]),
        "[ -~]{0,40}".prop_map(String::into_bytes),
    ];
    proptest::collection::vec(run, 0..6).prop_map(|runs| runs.concat())
}

/// Text made of pieces of the grammar, so that it reaches many paths of the parsers.
fn texts() -> impl Strategy<Value = String> {
    let piece = prop_oneof![
        "[0-9a-fA-F]{1,9}",
        "[ \t,:;_-]{1,3}",
        "0000000[0-9a-f]",
        "(: |  |\n|\r\n|\\*\n|//|#|0x|> |< |\\||  \\|[.a-f]{1,4}\\|\n)",
        "00000000: 4446  DF\n",
        "00000000  44 46  \\|DF\\|\n",
        "\\PC",
    ];
    proptest::collection::vec(piece, 0..40).prop_map(|pieces| pieces.concat())
}

proptest! {
    #[test]
    fn written_bytes_are_read_back(
        bytes in runs(),
        columns in 1_usize..70,
        group in 1_usize..9,
        upper: bool,
        lead in prop_oneof![Just(""), Just("0x")],
        gap in "[ \t,:;_-]{1,3}",
    ) {
        prop_assert_eq!(&host(xxd(&bytes, columns, group).as_bytes()), &bytes);
        prop_assert_eq!(&host(hexdump(&bytes).as_bytes()), &bytes);
        let (raw, _) = read(&*bytes, Format::Raw).expect("raw bytes have no errors");
        prop_assert_eq!(&raw, &bytes);
        let text = plain(&bytes, columns, group, upper, lead, &gap);
        let (hex, count) = read(text.as_bytes(), Format::Hex).expect("the text is hex digits");
        prop_assert_eq!((&hex, count), (&bytes, text.len() as u64));
        let commented = text.replace('\n', " // 00\n# 00\n");
        let (hex, _) = read(commented.as_bytes(), Format::Hex).expect("the text is hex digits");
        prop_assert_eq!(&hex, &bytes);
    }

    #[test]
    fn reading_of_any_text_ends(text in texts(), cut in 0_usize..400) {
        for format in [Format::Auto, Format::Hex, Format::Xxd] {
            for senders in [None, Some(Senders::Host), Some(Senders::Both)] {
                let mut source = Source::new(text.as_bytes(), format, senders).expect("the input is text");
                let mut total = 0;
                let end = loop {
                    match source.next_piece() {
                        Ok(Some(piece)) => total += piece.bytes.len() as u64,
                        end => break end.map(|_| ()),
                    }
                };
                let stars = text.bytes().filter(|byte| *byte == b'*').count() as u64;
                prop_assert!(total <= text.len() as u64 / 2 + stars * MAX_REPEAT);
                if let Err(SourceError::Text(error) | SourceError::Guessed(error)) = end {
                    let line = text.split('\n').nth(usize::try_from(error.line)? - 1);
                    let line = line.expect("the line exists");
                    prop_assert!((1..=line.len() as u64 + 1).contains(&error.column), "{error}");
                    prop_assert!(!error.to_string().contains(char::is_control));
                }
                prop_assert!(matches!(source.next_piece(), Ok(None)));
            }
        }
        // The result does not depend on the sizes of the reads.
        let slow = Slow { input: text.as_bytes(), ready: false };
        let (whole, slow) = (read(text.as_bytes(), Format::Auto), read(slow, Format::Auto));
        prop_assert_eq!(format!("{whole:?}"), format!("{slow:?}"));
        // A text that is cut off anywhere is read without a panic.
        let cut = text.char_indices().nth(cut).map_or(text.len(), |(at, _)| at);
        let _ = read(&text.as_bytes()[..cut], Format::Auto);
    }

    #[test]
    fn reading_of_any_bytes_ends(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        for format in [Format::Auto, Format::Raw, Format::Hex, Format::Xxd] {
            if let Ok((_, count)) = read(&*bytes, format) {
                prop_assert_eq!(count, bytes.len() as u64);
            }
        }
    }

}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// A long line may be cut into parts anywhere: inside a pair of digits, a `0x` or a comment.
    #[test]
    fn a_long_line_is_one_line(shift in 0_usize..9, group in 1_usize..9, lead in "(0x)?") {
        let bytes: Vec<u8> = (0..MAX_LINE).map(|byte| byte.to_le_bytes()[0]).collect();
        let blanks = " ".repeat(shift);
        let text = blanks.clone() + &plain(&bytes, bytes.len(), group, false, &lead, ", ");
        let comment = "/".repeat(MAX_LINE + shift) + "zz\n";
        prop_assert_eq!(&host((text.clone() + &comment + "07").as_bytes())[..MAX_LINE], &bytes[..]);
        prop_assert_eq!(host((comment.clone() + &text).as_bytes()), bytes);
        let wrong = |text: String, what: TextProblem| {
            let column = text.rfind('\n').map_or(text.len(), |end| text.len() - end - 1) as u64;
            match read(text.as_bytes(), Format::Hex) {
                Err(SourceError::Text(error)) => (error.column, error.what) == (column, what),
                _ => false,
            }
        };
        prop_assert!(wrong(text.clone() + "g", TextProblem::NoHexDigit("g".to_owned())));
        prop_assert!(wrong(text.clone() + "4", TextProblem::LoneDigit('4')));
        prop_assert!(wrong(comment + &text + " /", TextProblem::NoHexDigit("/".to_owned())));
    }
}

#[test]
fn a_group_longer_than_a_part_stays_one_group() {
    for shift in 0..4 {
        let text = " ".repeat(shift) + &"5a".repeat(3 * MAX_LINE);
        assert_eq!(host(text.as_bytes()), vec![0x5a; 3 * MAX_LINE], "{shift}");
        for (end, what) in [("5", TextProblem::LoneDigit('5')), ("0x55", TextProblem::Prefix)] {
            let error = read((text.clone() + end).as_bytes(), Format::Hex).expect_err("the text has an error");
            let SourceError::Text(error) = error else { panic!("{error}") };
            assert_eq!((error.line, error.column), (1, text.len() as u64 + 1));
            assert_eq!(error.what, what);
        }
    }
}

#[test]
fn a_line_of_a_dump_has_a_limit() {
    for label in ["00000000: ", "00000010: ", "00000000  ", "000000 "] {
        let text = label.to_owned() + &"44 ".repeat(MAX_LINE);
        let error = read(text.as_bytes(), Format::Xxd).expect_err("the line is too long");
        assert!(matches!(error, SourceError::Text(error) if error.what == TextProblem::LongLine), "{label}");
        assert!(read(text.as_bytes(), Format::Auto).is_err(), "{label}");
    }
    // Data may begin like an offset.
    let text = "44460100 ".to_owned() + &"44 ".repeat(MAX_LINE);
    assert_eq!(host(text.as_bytes()).len(), MAX_LINE + 4);
}
