//! Tests of text in each form that the dump programs print, and of the errors and their places.

use std::io::{self, Read};

use examples::text::{Format, MAX_REPEAT, Piece, Senders, Side, Source, SourceError, TextError, TextProblem};

/// The 40 bytes of the dumps below. They contain each character that has a meaning in the grammar.
const BYTES: &[u8] = b"DF\x01\0\0\x000\0\x08\0\0\0 hello | world //# >x<\0\xff\x80\n  ";

/// Output of `xxd`.
const XXD: &str = "\
00000000: 4446 0100 0000 3000 0800 0000 2068 656c  DF....0..... hel
00000010: 6c6f 207c 2077 6f72 6c64 202f 2f23 203e  lo | world //# >
00000020: 783c 00ff 800a 2020                      x<....  
";
/// Output of `xxd -u -c 20 -g 4`.
const XXD_WIDE: &str = "\
00000000: 44460100 00003000 08000000 2068656C 6C6F207C  DF....0..... hello |
00000014: 20776F72 6C64202F 2F23203E 783C00FF 800A2020   world //# >x<....  
";
/// Output of `xxd -p`.
const PLAIN: &str = "\
4446010000003000080000002068656c6c6f207c20776f726c64202f2f23
203e783c00ff800a2020
";
/// Output of `hexdump -C`.
const HEXDUMP: &str = "\
00000000  44 46 01 00 00 00 30 00  08 00 00 00 20 68 65 6c  |DF....0..... hel|
00000010  6c 6f 20 7c 20 77 6f 72  6c 64 20 2f 2f 23 20 3e  |lo | world //# >|
00000020  78 3c 00 ff 80 0a 20 20                           |x<....  |
00000028
";
/// Output of `od -A x -t x1z`.
const OD: &str = "\
000000 44 46 01 00 00 00 30 00 08 00 00 00 20 68 65 6c  >DF....0..... hel<
000010 6c 6f 20 7c 20 77 6f 72 6c 64 20 2f 2f 23 20 3e  >lo | world //# ><
000020 78 3c 00 ff 80 0a 20 20                          >x<....  <
000028
";
/// Lines of `tcpdump -X`.
const TCPDUMP: &str = "\
\t0x0000:  4446 0100 0000 3000 0800 0000 2068 656c  DF....0......hel
\t0x0010:  6c6f 207c 2077 6f72 6c64 202f 2f23 203e  lo.|.world.//#.>
\t0x0020:  783c 00ff 800a 2020                      x<......
";
/// Output of `hexdump`.
const WORDS: &str = "\
0000000 4644 0001 0000 0030 0008 0000 6820 6c65
0000010 6f6c 7c20 7720 726f 646c 2f20 232f 3e20
0000020 3c78 ff00 0a80 2020                    
0000028
";
/// Output of `od -t x1`.
const OCTAL: &str = "0000000 44 46 01 00\n0000004\n";
/// Output of `xxd -e`.
const LITTLE: &str = "00000000: 00014644 00300000 00000008 6c656820  DF....0..... hel\n";
/// Output of `xxd -b -c 6`.
const BITS: &str = "00000000: 01000100 01000110 00000001 00000000 00000000 00000000  DF....\n";

/// `AB`, a hundred NULs and `zz` as `hexdump -C`, `xxd -a` and `od -A x -t x1z` print them.
const STARS: [&str; 3] = [
    "\
00000000  41 42 00 00 00 00 00 00  00 00 00 00 00 00 00 00  |AB..............|
00000010  00 00 00 00 00 00 00 00  00 00 00 00 00 00 00 00  |................|
*
00000060  00 00 00 00 00 00 7a 7a                           |......zz|
00000068
",
    "\
00000000: 4142 0000 0000 0000 0000 0000 0000 0000  AB..............
00000010: 0000 0000 0000 0000 0000 0000 0000 0000  ................
*
00000060: 0000 0000 0000 7a7a                      ......zz
",
    "\
000000 41 42 00 00 00 00 00 00 00 00 00 00 00 00 00 00  >AB..............<
000010 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00  >................<
*
000060 00 00 00 00 00 00 7a 7a                          >......zz<
000068
",
];

/// All bytes of an input, by side.
#[derive(Debug, Default, PartialEq)]
struct Sides {
    host: Vec<u8>,
    device: Vec<u8>,
    /// Lengths of the records, in order.
    records: Vec<usize>,
}

fn read_from(input: impl Read, format: Format, senders: Option<Senders>) -> Result<Sides, SourceError> {
    let mut source = Source::new(input, format, senders)?;
    let mut all = Sides::default();
    while let Some(Piece { side, first, bytes }) = source.next_piece()? {
        assert!(!bytes.is_empty());
        if first {
            all.records.push(0);
        }
        *all.records.last_mut().expect("the first piece begins a record") += bytes.len();
        match side {
            Side::Host => all.host.extend(bytes),
            Side::Device => all.device.extend(bytes),
        }
    }
    assert!(source.next_piece()?.is_none(), "no piece follows the end");
    Ok(all)
}

/// The text with a mark before each line.
fn marked(mark: &str, text: &str) -> String {
    text.split_inclusive('\n').flat_map(|line| [mark, " ", line]).collect()
}

/// The host's bytes in a text that has no marks.
fn host(text: impl AsRef<[u8]>) -> Vec<u8> {
    read_from(text.as_ref(), Format::Auto, Some(Senders::Host)).expect("the text is valid").host
}

/// Line, column and kind of the error in a text without marks.
fn wrong(text: impl AsRef<[u8]>, format: Format) -> (u64, u64, TextProblem) {
    match read_from(text.as_ref(), format, Some(Senders::Host)) {
        Err(SourceError::Text(error) | SourceError::Guessed(error)) => (error.line, error.column, error.what),
        other => panic!("{other:?}"),
    }
}

fn no_digit(char: &str) -> TextProblem {
    TextProblem::NoHexDigit(char.to_owned())
}

#[test]
fn dumps_of_all_programs_are_read() {
    let without_text: String = TCPDUMP.lines().flat_map(|line| [line[..line.len().min(50)].trim_end(), "\n"]).collect();
    for dump in [XXD, XXD_WIDE, HEXDUMP, OD, TCPDUMP, &without_text] {
        assert_eq!(host(dump), BYTES, "{dump}");
        let all = read_from(dump.as_bytes(), Format::Xxd, Some(Senders::Host)).expect(dump);
        assert_eq!((all.host.as_slice(), all.records), (BYTES, vec![BYTES.len()]), "{dump}");
        assert_eq!(host(dump.replace('\n', "\r\n")), BYTES, "{dump}");
        assert_eq!(host(dump.trim_end()), BYTES, "{dump}");
        let all = read_from(marked("<", dump).as_bytes(), Format::Auto, None).expect(dump);
        assert_eq!((all.host.as_slice(), all.device.as_slice()), (&b""[..], BYTES));
    }
    assert_eq!(host(PLAIN), BYTES);
    assert_eq!(host(format!("{XXD}{HEXDUMP}{OD}{PLAIN}{XXD}")), BYTES.repeat(5));
}

#[test]
fn each_packet_of_tcpdump_is_a_record() {
    let all = read_from(TCPDUMP.repeat(2).as_bytes(), Format::Auto, Some(Senders::Host)).expect("two packets");
    assert_eq!((all.host, all.records), (BYTES.repeat(2), vec![BYTES.len(); 2]));
    let jump = TextProblem::Jump { expected: 0x10, found: 0x20 };
    assert_eq!(wrong(TCPDUMP.replace("0x0010", "0x0020"), Format::Auto), (2, 2, jump));
    // Without a blank after the colon, or with fewer digits, these are bytes.
    assert_eq!(host("0x4446:0100"), *b"DF\x01\0");
    assert_eq!(host("0x44: 0x46"), *b"DF");
}

#[test]
fn text_in_utf16_is_read() {
    let orders = [u16::to_le_bytes, u16::to_be_bytes];
    for (order, mark) in [(orders[0], "\u{feff}"), (orders[0], ""), (orders[1], "\u{feff}")] {
        let encoded = |text: &str| -> Vec<u8> { text.encode_utf16().flat_map(order).collect() };
        let dump = format!("{mark}{XXD}");
        for format in [Format::Auto, Format::Xxd] {
            let all = read_from(&encoded(&dump)[..], format, Some(Senders::Host)).expect("a dump");
            assert_eq!(all.host, BYTES, "{format:?}, {mark:?}");
        }
        assert_eq!(wrong(encoded(&format!("{mark}44 xx")), Format::Auto), (1, 4 + mark.len() as u64, no_digit("x")));
        let mut cut = encoded(&dump);
        cut.pop();
        let error = read_from(&cut[..], Format::Auto, Some(Senders::Host)).unwrap_err();
        assert_eq!(error.to_string(), "the UTF-16 text ends within a character");
    }
    let comment: Vec<u8> = "\u{feff}44 // \u{1f600}\n46".encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert_eq!(host(&comment), *b"DF");
    // These bytes are no text in any encoding.
    for raw in [&b"\xff"[..], b"\xff\xfe", b"\xff\xfe\x04\0", b"4\0", b"\0D\0F\0", b"D\0F\0\0\0", b"D\0\xff\xff"] {
        assert_eq!(host(raw), raw);
    }
}

#[test]
fn a_star_repeats_the_line_before_it() {
    let mut bytes = b"AB".to_vec();
    bytes.resize(102, 0);
    bytes.extend(b"zz");
    for dump in STARS {
        assert_eq!(host(dump), bytes, "{dump}");
        assert_eq!(read_from(marked(">", dump).as_bytes(), Format::Auto, None).expect(dump).host, bytes);
    }
    assert_eq!(host("00000000  00 00  |..|\n*\n00000008\n"), [0; 8]);
    assert_eq!(wrong("*\n", Format::Auto), (1, 1, TextProblem::NothingToRepeat));
    assert_eq!(wrong("44\n*\n", Format::Auto), (2, 1, TextProblem::NothingToRepeat));
    assert_eq!(wrong("00000000: 44\n *\n44 45", Format::Auto), (2, 2, TextProblem::OpenRepeat));
    assert_eq!(wrong("00000000: 44\n*\n", Format::Auto), (2, 1, TextProblem::OpenRepeat));
    assert_eq!(wrong("00000000: 44\n*\n\n44", Format::Auto), (2, 1, TextProblem::OpenRepeat));
    let back = TextProblem::Jump { expected: 0x11, found: 0 };
    assert_eq!(wrong("00000010: 44\n*\n00000000: 46", Format::Auto), (3, 1, back));
    assert_eq!(wrong("00000000:\n*\n00000001: 44", Format::Auto), (2, 1, TextProblem::NothingToRepeat));
    let uneven = TextProblem::UnevenRepeat { bytes: 3 };
    assert_eq!(wrong("00000000: 4446\n*\n00000005: 44", Format::Auto), (3, 1, uneven));
    let long = TextProblem::LongRepeat { bytes: MAX_REPEAT + 1 };
    assert_eq!(wrong("00000000: 44\n*\n00100002: 44", Format::Auto), (3, 1, long));
    assert_eq!(host("00000000: 44\n*\n00100001: 44").len() as u64, MAX_REPEAT + 2);
    let endless = TextProblem::LongRepeat { bytes: u64::MAX - 1 };
    assert_eq!(wrong("00000000: 44\n*\nffffffffffffffff:", Format::Auto), (3, 1, endless));
}

#[test]
fn hex_is_read_in_every_spelling() {
    for text in [
        "44 46 01 00",
        "44460100",
        "0x44, 0x46, 0x01, 0X00",
        "0x44460100",
        "0x4446 0100",
        "44:46:01:00",
        "44-46_01;00",
        "\t44\t46,,01 - 00 ; ",
        "44 46 // the marker\n01 00 # the rest",
        "# 44 is D\n\n//46\n4446\n\n0100//",
        "\u{feff}44 46 01 00",
        "44 46\r\n01 00\r\n",
    ] {
        assert_eq!(host(text), b"DF\x01\0", "{text}");
        let all = read_from(text.as_bytes(), Format::Hex, Some(Senders::Host)).expect(text);
        assert_eq!(all.host, b"DF\x01\0", "{text}");
    }
    assert_eq!(host("aAbBcCdDeEfF"), [0xaa, 0xbb, 0xcc, 0xdd, 0xee, 0xff]);
}

#[test]
fn offsets_are_distinguished_from_data() {
    let all: [u8; 8] = [0x44, 0x46, 0x01, 0x00, 0x00, 0x00, 0x30, 0x00];
    for text in [
        // Words of data, separated by one blank, by two blanks, by colons.
        "44460100 00003000",
        "44460100  00003000",
        "44460100  00 00 30 00",
        "444601 00 00 00 30 00",
        "44460100:00003000",
        "444601:00:00:00:30:00",
        "4446: 0100: 0000: 3000",
        // More digits than an offset can have.
        "44460100000030",
    ] {
        assert_eq!(host(text), all[..text.bytes().filter(u8::is_ascii_hexdigit).count() / 2]);
    }
    // Zeros are an offset only before two blanks and pairs.
    assert_eq!(host("00000000  44 46"), *b"DF");
    assert_eq!(host("00000000  44 46\n00000002  01 00\n00000004"), *b"DF\x01\0");
    assert_eq!(host("00000000  4446"), *b"\0\0\0\0DF");
    assert_eq!(host("00000000 44 46"), *b"\0\0\0\0DF");
    assert_eq!(host("0000000000ff 03"), *b"\0\0\0\0\0\xff\x03");
    assert_eq!(wrong("000000 44 46", Format::Auto), (1, 1, TextProblem::Ambiguous));
    // The option decides.
    let read = |text: &str, format| read_from(text.as_bytes(), format, Some(Senders::Host));
    assert_eq!(read("000000 44 46\n000002", Format::Xxd).expect("a dump").host, *b"DF");
    assert_eq!(read("000000 44 46", Format::Hex).expect("hex").host, *b"\0\0\0DF");
    assert_eq!(read("00000000: 44 46", Format::Hex).expect("hex").host, *b"\0\0\0\0DF");
    assert_eq!(read("00000000  44 46", Format::Hex).expect("hex").host, *b"\0\0\0\0DF");
    assert_eq!(wrong("# xxd -p\n44460100\n", Format::Xxd), (2, 1, TextProblem::NoOffset));
}

#[test]
fn a_gap_in_the_offsets_of_a_dump_is_an_error() {
    let jump = |expected, found| TextProblem::Jump { expected, found };
    assert_eq!(wrong("00000010: 44\n00000020: 46", Format::Auto), (2, 1, jump(0x11, 0x20)));
    assert_eq!(wrong("00000010: 44\n00000010: 46", Format::Auto), (2, 1, jump(0x11, 0x10)));
    let columns = "00000000  44 46  |DF|\n";
    assert_eq!(wrong(format!("{columns}44460100"), Format::Auto), (2, 1, jump(2, 0x4446_0100)));
    assert_eq!(wrong(format!("{columns}00000004"), Format::Auto), (2, 1, jump(2, 4)));
    // A blank line, hex digits or offset 0 begin a new dump.
    assert_eq!(host(format!("{columns}\n44460100")), *b"DFDF\x01\0");
    assert_eq!(host("00000010: 44\n\n00000020: 46"), *b"DF");
    assert_eq!(host("00000010: 44\n45\n00000020: 46"), *b"DEF");
    assert_eq!(host("00000000: 44\n00000000: 46"), *b"DF");
    // Each side has its own offsets.
    let both = "> 00000000: 44\n< 00000000: 61\n> 00000001: 46\n< 00000001: 62\n";
    let all = read_from(both.as_bytes(), Format::Auto, None).expect("the text is valid");
    assert_eq!(all, Sides { host: b"DF".into(), device: b"ab".into(), records: vec![1, 3] });
}

#[test]
fn dumps_of_other_kinds_are_refused() {
    for format in [Format::Auto, Format::Xxd] {
        assert_eq!(wrong(WORDS, format), (1, 1, TextProblem::Words));
        assert_eq!(wrong(OCTAL, format), (1, 1, TextProblem::Words));
        assert_eq!(wrong(LITTLE, format), (1, 48, TextProblem::Reversed));
        assert_eq!(wrong(BITS, format), (1, 66, TextProblem::Column { shown: 6, bytes: 24 }));
    }
}

#[test]
fn the_text_column_is_never_data() {
    // Blanks at its end may be cut off, and it may be unchanged after an edit of the bytes.
    assert_eq!(host("00000000: 4446 2020  DF"), *b"DF  ");
    assert_eq!(host("00000000: 4446 4848  DFGG"), *b"DFHH");
    assert_eq!(host("00000000: 2020 ffee    ..\n"), *b"  \xff\xee");
    assert_eq!(host("00000000: 61  a"), *b"a");
    assert_eq!(host("00000000:\n"), *b"");
    assert_eq!(host("00000000  7c 7c  ||||"), *b"||");
    let column = |shown, bytes| TextProblem::Column { shown, bytes };
    assert_eq!(wrong("00000000: 4446  DFG", Format::Auto), (1, 17, column(3, 2)));
    assert_eq!(wrong("00000000: 4446  61 62", Format::Auto), (1, 17, column(5, 2)));
    assert_eq!(wrong("00000000  44 46  |DFG|", Format::Auto), (1, 19, column(3, 2)));
}

#[test]
fn errors_name_line_and_column() {
    for (text, line, column, what) in [
        ("44 4g", 1, 4, TextProblem::LoneDigit('4')),
        ("44 g4", 1, 4, no_digit("g")),
        ("44\n\n  444 46", 3, 5, TextProblem::LoneDigit('4')),
        ("4", 1, 1, TextProblem::LoneDigit('4')),
        ("0x1", 1, 1, TextProblem::Prefix),
        ("0x", 1, 1, TextProblem::Prefix),
        ("44 0xg", 1, 4, TextProblem::Prefix),
        ("120x34", 1, 3, TextProblem::Prefix),
        ("44 / 46", 1, 4, no_digit("/")),
        ("{0x44}", 1, 1, no_digit("{")),
        ("44 > 46", 1, 4, no_digit(">")),
        ("# é\n44 é", 2, 4, no_digit("é")),
        ("\u{feff}44\n\u{feff}44", 2, 1, no_digit("\\u{feff}")),
        ("00000000: 44 4g", 1, 14, TextProblem::LoneDigit('4')),
        ("00000000: 4446 0100-3000", 1, 20, no_digit("-")),
        ("00000000: 4446 // D", 1, 16, no_digit("/")),
        ("00000000  44 46  hi", 1, 18, no_digit("h")),
        ("00000000  44 4g  |..|", 1, 14, TextProblem::LoneDigit('4')),
        ("00000000  44 46  |DF", 1, 18, no_digit("|")),
        ("00000000  44  |D|\n00000001  4  |.|", 2, 11, TextProblem::LoneDigit('4')),
        ("00000000  44  |D|\n00000001  4546", 2, 11, TextProblem::LoneDigit('4')),
        ("hello", 1, 1, no_digit("h")),
    ] {
        assert_eq!(wrong(text, Format::Auto), (line, column, what), "{text}");
    }
    assert_eq!(wrong(b"44 \xff", Format::Hex), (1, 4, no_digit("\\xff")));
    assert_eq!(wrong(b"44 \x1b[31m", Format::Hex), (1, 4, no_digit("\\u{1b}")));
    assert_eq!(wrong(b"44 \0", Format::Hex), (1, 4, no_digit("\\0")));
    let error = TextError { line: 3, column: 17, what: no_digit("g") };
    assert_eq!(error.to_string(), "line 3, column 17: \"g\" is not a hex digit");
}

#[test]
fn a_mark_names_the_sender_of_a_line() {
    let marked = "> 44 46\n<0100\n  >  61 // hello\n<\n\n> # nothing\n";
    for senders in [None, Some(Senders::Both)] {
        let all = read_from(marked.as_bytes(), Format::Auto, senders).expect("the text has marks");
        assert_eq!(all, Sides { host: b"DFa".into(), device: vec![1, 0], records: vec![2, 2, 1] });
    }
    let read = |text: &str, senders| match read_from(text.as_bytes(), Format::Auto, senders) {
        Ok(all) => Ok(all.host),
        Err(SourceError::Guessed(error)) => Err((error.line, error.what)),
        Err(error) => panic!("{error}"),
    };
    assert_eq!(read("> 44\n46", None), Err((2, TextProblem::Unmarked)));
    assert_eq!(read("44", Some(Senders::Both)), Err((1, TextProblem::Unmarked)));
    assert_eq!(read("> 44\n46", Some(Senders::Host)), Ok(b"DF".into()));
    assert_eq!(read("> 44\n< 46", Some(Senders::Host)), Err((2, TextProblem::OtherSide)));
    assert_eq!(read("> 44", Some(Senders::Device)), Err((1, TextProblem::OtherSide)));
    assert_eq!(read("< 44", Some(Senders::Device)), Ok(vec![]));
}

#[test]
fn input_without_a_sender_is_refused() {
    for (input, format) in
        [(&b""[..], Format::Auto), (b"# nothing", Format::Auto), (b"DF\0\0", Format::Auto), (b"44", Format::Raw)]
    {
        let result = read_from(input, format, None);
        assert!(matches!(result, Err(SourceError::Unsaid)), "{result:?}");
    }
    assert!(matches!(read_from(&b"44"[..], Format::Raw, Some(Senders::Both)), Err(SourceError::Unsaid)));
    assert!(SourceError::Unsaid.to_string().contains("--from"));
    assert_eq!(host(""), b"");
}

#[test]
fn input_that_is_not_text_is_read_as_raw_bytes() {
    for input in [&b"DF\x01\0"[..], b"44 46\0", b"\xff\xfe4", b"44 \x1b", b"\xc3("] {
        let all = read_from(input, Format::Auto, Some(Senders::Device)).expect("the input is raw");
        assert_eq!((all.device.as_slice(), all.records), (input, vec![input.len()]));
    }
    let all = read_from(&b"44 46"[..], Format::Raw, Some(Senders::Host)).expect("the input is raw");
    assert_eq!(all.host, b"44 46");
    // The first 4096 bytes decide, even if a character is cut off at their end.
    let with = |at: usize, end: &str| [" ".repeat(at).as_bytes(), end.as_bytes()].concat();
    assert_eq!(wrong(with(4095, "é\0"), Format::Auto), (1, 4096, no_digit("é")));
    assert_eq!(wrong(with(4096, "\0"), Format::Auto), (1, 4097, no_digit("\\0")));
    assert_eq!(host(with(4095, "\0")), with(4095, "\0"));
    // One byte that is not text is enough, because a serial line may give no more bytes for a long time.
    let line = [0].as_slice().chain(Silent);
    assert!(Source::new(line, Format::Auto, Some(Senders::Host)).is_ok());
}

/// Line without traffic.
struct Silent;

impl Read for Silent {
    fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
        panic!("a read from this line never ends")
    }
}
