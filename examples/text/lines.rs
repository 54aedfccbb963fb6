//! Reading of text line by line: sides, long lines, dumps and their offsets.

use std::io::{self, BufRead, Read};
use std::mem;

use nom::Offset;

use super::dump::Dumps;
use super::error::At;
use super::grammar::{self, After, Label, Parsed};
use super::{MAX_LINE, Side, SourceError, TextError, TextProblem};

/// Kinds of lines that a text may have.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(super) enum Lines {
    /// Hex digits and dumps, by the rules of the parent module.
    Any,
    /// Hex digits only.
    Hex,
    /// Dumps only.
    Dump,
}

/// Bytes of a line, or of a part of it.
pub(super) struct Chunk<'a> {
    pub(super) line: u64,
    pub(super) side: Option<Side>,
    pub(super) first: bool,
    pub(super) bytes: &'a [u8],
}

/// Place in a line at which its unread part begins.
#[derive(Clone, Copy)]
enum Place {
    Start,
    Hex { open: bool },
    Comment,
}

/// Reader of text, line by line.
pub(super) struct Text<R> {
    input: R,
    lines: Lines,
    /// Part of the line that is not parsed yet.
    part: Vec<u8>,
    place: Place,
    line: u64,
    /// Column of the first byte of the part, from 0.
    column: u64,
    side: Option<Side>,
    /// Whether the next bytes begin a record.
    first: bool,
    dumps: Dumps,
    bytes: Vec<u8>,
}

impl<R: BufRead> Text<R> {
    pub(super) fn new(input: R, lines: Lines) -> Self {
        Self {
            input,
            lines,
            part: Vec::new(),
            place: Place::Start,
            line: 0,
            column: 0,
            side: None,
            first: true,
            dumps: Dumps::default(),
            bytes: Vec::new(),
        }
    }

    pub(super) fn input(&self) -> &R {
        &self.input
    }

    /// Bytes of the next line that has any. `None` at the end.
    pub(super) fn next_chunk(&mut self) -> Result<Option<Chunk<'_>>, SourceError> {
        self.bytes.clear();
        while self.bytes.is_empty() {
            if !self.read()? {
                self.dumps.end()?;
                return Ok(None);
            }
            self.parse()?;
        }
        let first = mem::replace(&mut self.first, false);
        Ok(Some(Chunk { line: self.line, side: self.side, first, bytes: &self.bytes }))
    }

    /// Reads to the end of the line, or until the part is full. Returns false at the end of the input.
    fn read(&mut self) -> io::Result<bool> {
        let room = MAX_LINE.saturating_sub(self.part.len());
        let mut input = self.input.by_ref().take(room as u64);
        let count = input.read_until(b'\n', &mut self.part)?;
        if let Place::Start = self.place {
            self.line += 1;
            self.column = 0;
            return Ok(count > 0);
        }
        Ok(true)
    }

    /// Parses the part. If the line continues, its last bytes may be left for later.
    fn parse(&mut self) -> Result<(), TextError> {
        let mut part = mem::take(&mut self.part);
        let ended = part.ends_with(b"\n") || part.len() < MAX_LINE;
        let text = if ended { part.trim_ascii_end() } else { &part };
        let left = match self.place {
            Place::Start => self.start(text, ended)?,
            Place::Hex { open } => self.hex(text, text, open, ended)?,
            Place::Comment => 0,
        };
        let read = text.len() - left;
        if ended {
            self.place = Place::Start;
            part.clear();
        } else {
            self.column += read as u64;
            part.drain(..read);
        }
        self.part = part;
        Ok(())
    }

    /// Parses a line from its beginning. Returns how many bytes are left.
    fn start(&mut self, text: &[u8], ended: bool) -> Result<usize, TextError> {
        self.first = true;
        let byte_order_mark = if self.line == 1 { "\u{feff}" } else { "" };
        let body = text.strip_prefix(byte_order_mark.as_bytes()).unwrap_or(text);
        let (body, side) = self.parsed(text, grammar::side(body))?;
        self.side = side;
        if body.is_empty() && ended {
            self.dumps.end()?;
            return Ok(0);
        }
        if self.lines == Lines::Hex || grammar::comment(body) {
            return self.hex(text, body, false, ended);
        }
        if body == b"*" {
            self.dumps.star(side, self.at(text, body))?;
            return Ok(0);
        }
        if let Ok((rest, label)) = grammar::label(body)
            && self.dump(text, self.at(text, body), label, rest, ended)?
        {
            return Ok(0);
        }
        if self.lines == Lines::Dump {
            return Err(self.at(text, body).error(TextProblem::NoOffset));
        }
        self.dumps.end_of(side)?;
        self.hex(text, body, false, ended)
    }

    /// Parses hex digits. Returns how many bytes are left.
    fn hex(&mut self, text: &[u8], body: &[u8], open: bool, ended: bool) -> Result<usize, TextError> {
        let parsed = grammar::hex(body, open, &mut self.bytes);
        let (left, open) = self.parsed(text, parsed)?;
        if grammar::comment(left) {
            self.place = Place::Comment;
            return Ok(0);
        }
        // If the line continues, the rest of a digit pair, a `0x` or a `//` may follow.
        if left.is_empty() || (!ended && left.len() < 4) {
            self.place = Place::Hex { open };
            return Ok(left.len());
        }
        Err(self.at(text, left).error(grammar::diagnose(left)))
    }

    /// Parses the rest of a line after a label. Returns whether the label is an offset.
    fn dump(&mut self, text: &[u8], here: At, label: Label, body: &[u8], ended: bool) -> Result<bool, TextError> {
        let inside = self.dumps.has_columns(self.side);
        let row = match label.after {
            After::End if inside => {
                self.first = self.dumps.line(self.side, here, label, &mut self.bytes)?;
                self.dumps.end_of(self.side)?;
                return Ok(true);
            }
            After::End => return Ok(false),
            After::Blanks(_) if label.digits == 7 => return Err(here.error(TextProblem::Words)),
            After::Blanks(_) => grammar::columns(body, &mut self.bytes),
            After::Colon => grammar::xxd(body, &mut self.bytes),
        };
        let (left, row) = self.parsed(text, row)?;
        let dump = inside || self.lines == Lines::Dump || label.after == After::Colon || row.text.is_some();
        let pairs_alone = !self.bytes.is_empty() && (left.is_empty() || !ended);
        let may_be_dump = label.offset == 0 && pairs_alone;
        match label.after {
            _ if dump => (),
            After::Blanks(2..) if may_be_dump => (),
            _ if may_be_dump && label.digits == 6 => return Err(here.error(TextProblem::Ambiguous)),
            _ => {
                self.bytes.clear();
                return Ok(false);
            }
        }
        if !ended {
            return Err(here.error(TextProblem::LongLine));
        }
        if !left.is_empty() {
            let left = left.trim_ascii_start();
            return Err(self.at(text, left).error(grammar::diagnose(left)));
        }
        if let Some(column) = row.text {
            grammar::compare(column, &self.bytes, row.group).map_err(|what| self.at(text, column).error(what))?;
        }
        self.first = self.dumps.line(self.side, here, label, &mut self.bytes)?;
        Ok(true)
    }

    /// Place at which `inner`, a part of `text`, begins.
    fn at(&self, text: &[u8], inner: &[u8]) -> At {
        At { line: self.line, column: self.column + text.offset(inner) as u64 + 1 }
    }

    /// Result of a parser, or the error at the place where it could not begin.
    fn parsed<'a, T>(&self, text: &[u8], parsed: Parsed<'a, T>) -> Result<(&'a [u8], T), TextError> {
        parsed.map_err(|error| match error {
            nom::Err::Error(error) | nom::Err::Failure(error) => {
                self.at(text, error.input).error(grammar::diagnose(error.input))
            }
            nom::Err::Incomplete(_) => self.at(text, text).error(grammar::diagnose(text)),
        })
    }
}
