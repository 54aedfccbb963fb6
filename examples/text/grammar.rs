//! The grammar of one line.
//!
//! Each parser reads as far as it can and leaves the rest. If the rest is an error, it begins at
//! the column of the error, and [`diagnose`] finds the kind.

use nom::branch::alt;
use nom::bytes::complete::{tag, tag_no_case, take, take_while, take_while_m_n, take_while1};
use nom::combinator::{eof, iterator, map, map_opt, opt, peek, rest, value};
use nom::sequence::{preceded, terminated};
use nom::{IResult, Parser};

use super::{Side, TextProblem};

/// Result of a parser, with the rest of its input.
pub(super) type Parsed<'a, T> = IResult<&'a [u8], T>;

/// Separator between an offset and the next column.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(super) enum After {
    /// A colon, then a blank or the end of the line.
    Colon,
    /// One or more blanks, with their number.
    Blanks(usize),
    /// The end of the line.
    End,
}

/// Offset at the beginning of a line.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(super) struct Label {
    pub(super) offset: u64,
    pub(super) digits: usize,
    pub(super) after: After,
}

/// Whether a byte is a blank as dumps have it between their columns.
fn blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t')
}

/// Whether a byte may stand between groups of hex digits. `\r` may, because a line may end with `\r\n`.
fn separator(byte: u8) -> bool {
    blank(byte) || matches!(byte, b',' | b':' | b';' | b'_' | b'-' | b'\r')
}

/// Value of a hex digit.
fn nibble(digit: u8) -> Option<u8> {
    match digit {
        b'0'..=b'9' => Some(digit - b'0'),
        b'a'..=b'f' => Some(digit - b'a' + 10),
        b'A'..=b'F' => Some(digit - b'A' + 10),
        _ => None,
    }
}

/// Parses two hex digits, which are one byte.
fn pair(input: &[u8]) -> Parsed<'_, u8> {
    map_opt(take(2_usize), |digits: &[u8]| match digits {
        [high, low] => Some(nibble(*high)? << 4 | nibble(*low)?),
        _ => None,
    })
    .parse(input)
}

/// Parses the mark of a side and the blanks around it.
pub(super) fn side(input: &[u8]) -> Parsed<'_, Option<Side>> {
    preceded(
        take_while(blank),
        opt(terminated(alt((value(Side::Host, tag(">")), value(Side::Device, tag("<")))), take_while(blank))),
    )
    .parse(input)
}

/// Parses an offset up to the beginning of the next column.
pub(super) fn label(input: &[u8]) -> Parsed<'_, Label> {
    let digits = |least| take_while_m_n(least, 16, |byte: u8| byte.is_ascii_hexdigit());
    let blank_or_end = || alt((take_while_m_n(1, 1, blank), eof));
    let colon = || value(After::Colon, terminated(tag(":"), peek(blank_or_end())));
    let blanks = map(take_while1(blank), |blanks: &[u8]| After::Blanks(blanks.len()));
    let prefixed = preceded(tag("0x"), (digits(4), colon()));
    let plain = (digits(6), alt((colon(), blanks, value(After::End, eof))));
    let (input, (digits, after)) = alt((prefixed, plain)).parse(input)?;
    let offset = digits.iter().filter_map(|digit| nibble(*digit));
    let offset = offset.fold(0, |offset, digit| offset << 4 | u64::from(digit));
    Ok((input, Label { offset, digits: digits.len(), after }))
}

/// Parts of a line of a dump, except its bytes.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(super) struct Row<'a> {
    /// Length of the first group, in bytes.
    pub(super) group: usize,
    /// The text column.
    pub(super) text: Option<&'a [u8]>,
}

/// Parses the rest of a line of `xxd` after the colon: pairs with at most one blank between them,
/// two blanks, and the text.
pub(super) fn xxd<'a>(input: &'a [u8], bytes: &mut Vec<u8>) -> Parsed<'a, Row<'a>> {
    let (input, _) = take_while(blank)(input)?;
    let mut group = None;
    let one_blank = terminated(take_while_m_n(1, 1, blank), peek(pair));
    let mut items = iterator(input, (pair, opt(one_blank)));
    for (byte, gap) in items.by_ref() {
        bytes.push(byte);
        group = group.or(gap.map(|_| bytes.len()));
    }
    let (input, ()) = items.finish()?;
    let group = group.unwrap_or(bytes.len());
    let (input, text) = opt(preceded(tag("  "), rest)).parse(input)?;
    Ok((input, Row { group, text }))
}

/// Parses the rest of a line of `hexdump -C` or `od` after the offset: single pairs with blanks
/// between them, and the text between bars.
pub(super) fn columns<'a>(input: &'a [u8], bytes: &mut Vec<u8>) -> Parsed<'a, Row<'a>> {
    let apart = || peek(alt((take_while1(blank), eof)));
    let gap = terminated(take_while1(blank), peek((pair, apart())));
    let mut items = iterator(input, terminated(terminated(pair, apart()), opt(gap)));
    bytes.extend(items.by_ref());
    let (input, ()) = items.finish()?;
    let column = map_opt(rest, |text: &[u8]| {
        let bars = text.strip_prefix(b"|").and_then(|text| text.strip_suffix(b"|"));
        bars.or_else(|| text.strip_prefix(b">")?.strip_suffix(b"<"))
    });
    let (input, text) = opt(preceded(take_while1(blank), column)).parse(input)?;
    Ok((input, Row { group: 1, text }))
}

/// Whether a comment begins here.
pub(super) fn comment(input: &[u8]) -> bool {
    input.starts_with(b"#") || input.starts_with(b"//")
}

/// Parses hex digits in groups, up to the first byte that is neither digit nor separator.
///
/// `open` is whether the input continues a group. Returns whether the rest would continue one.
pub(super) fn hex<'a>(input: &'a [u8], open: bool, bytes: &mut Vec<u8>) -> Parsed<'a, bool> {
    let prefix = || opt(tag_no_case("0x"));
    let (start, _) = if open {
        (input, None)
    } else {
        let lead = (take_while(separator), prefix());
        opt(terminated(lead, peek(pair))).parse(input)?
    };
    let next_group = (take_while1(separator), prefix());
    let mut items = iterator(start, preceded(opt(next_group), pair));
    bytes.extend(items.by_ref());
    let (end, ()) = items.finish()?;
    let (left, gap) = take_while(separator)(end)?;
    Ok((left, gap.is_empty()))
}

/// Kind of the error at the beginning of an input that no parser can read.
pub(super) fn diagnose(input: &[u8]) -> TextProblem {
    match input {
        [b'0', b'x' | b'X', ..] => TextProblem::Prefix,
        [digit, ..] if digit.is_ascii_hexdigit() => TextProblem::LoneDigit(char::from(*digit)),
        _ => TextProblem::NoHexDigit(first_char(input)),
    }
}

/// First character of an input, or its first byte if that is not a character, escaped for printing.
fn first_char(input: &[u8]) -> String {
    let head = input.get(..4).unwrap_or(input);
    let text = head.utf8_chunks().next().map_or("", |chunk| chunk.valid());
    match (text.chars().next(), head) {
        (Some(char), _) => char.escape_debug().to_string(),
        (None, [byte, ..]) => format!("\\x{byte:02x}"),
        (None, []) => String::new(),
    }
}

/// Compares the text column of a dump with its bytes, in groups of `group` bytes.
///
/// # Errors
///
/// [`TextProblem::Reversed`] if the column shows each group in reverse; [`TextProblem::Column`] if it is longer or
/// shorter than the bytes. Blanks at the ends do not count, because they may be padding or be cut off.
pub(super) fn compare(text: &[u8], bytes: &[u8], group: usize) -> Result<(), TextProblem> {
    let text = trim(text);
    let shows = |bytes: &[u8]| {
        let bytes = trim(bytes);
        let same = |(char, byte): (&u8, &u8)| *char == b'.' || char == byte;
        text.len() == bytes.len() && text.iter().zip(bytes).all(same)
    };
    let reversed = bytes.chunks(group.max(1)).flat_map(|group| group.iter().rev().copied());
    if shows(bytes) {
        Ok(())
    } else if shows(&reversed.collect::<Vec<_>>()) {
        Err(TextProblem::Reversed)
    } else if text.len() == trim(bytes).len() || text.len() == bytes.len() {
        // Some programs show a blank as a dot.
        Ok(())
    } else {
        Err(TextProblem::Column { shown: text.len(), bytes: trim(bytes).len() })
    }
}

/// Cuts blanks off both ends. A text column shows no other white space.
fn trim(mut text: &[u8]) -> &[u8] {
    while let [b' ', inner @ ..] | [inner @ .., b' '] = text {
        text = inner;
    }
    text
}
