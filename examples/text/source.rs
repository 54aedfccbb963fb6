//! Reading of any input as pieces of bytes, each with its side.

use std::io::{self, BufRead, BufReader, Cursor, ErrorKind, Read};
use std::mem;

use clap::ValueEnum;

use super::encoding::{Decoder, Encoding, LEAST, Whole, read_head};
use super::error::At;
use super::lines::{Lines, Text};
use super::{Side, SourceError, TextProblem};

/// Number of bytes at the beginning of the input that decide whether it is text.
const HEAD: usize = 4096;

/// Number of bytes of raw input that are read at once.
const BUFFER: usize = 64 * 1024;

/// Format of the input.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq, ValueEnum)]
pub enum Format {
    /// Text if its first 4096 bytes are UTF-8 or UTF-16 without control characters, raw otherwise
    ///
    /// None of the three protocols sends so many printable bytes one after the other. A text that
    /// breaks the grammar is an error and is not shown as noise, because the error says more. An input
    /// without a known end, such as a serial line, is raw as soon as one byte is not text, and text
    /// after 4096 bytes of text.
    #[default]
    Auto,
    /// Raw bytes
    Raw,
    /// Text: hex digits without offsets
    Hex,
    /// Text: dumps of `xxd`, `hexdump -C`, `od -A x -t x1`, `tcpdump -x`
    Xxd,
}

/// Senders of the bytes of the input.
#[derive(Clone, Copy, Debug, Eq, PartialEq, ValueEnum)]
pub enum Senders {
    /// The side that controls
    Host,
    /// The side that moves
    Device,
    /// Both, in text whose lines are marked `>` (host) and `<` (device)
    Both,
}

/// Some bytes that one side sent.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub struct Piece<'a> {
    /// Side that sent the bytes.
    pub side: Side,
    /// Whether the bytes begin a record. A record is a line of hex digits, a whole dump, or a whole
    /// raw input. So a text can have one record for each datagram.
    pub first: bool,
    /// The bytes, at least one.
    pub bytes: &'a [u8],
}

/// Input that is read in constant memory.
///
/// ```
/// use examples::text::{Format, Side, Source};
///
/// let text = "> 04 00 06 00 0b 01  // Get MotorInfo\n< 0400 0700 0b02 00\n";
/// let mut source = Source::new(text.as_bytes(), Format::Auto, None)?;
/// while let Some(piece) = source.next_piece()? {
///     let arrow = if piece.side == Side::Host { '>' } else { '<' };
///     println!("{arrow} {:02x?}", piece.bytes);
/// }
/// # Ok::<(), examples::text::SourceError>(())
/// ```
pub struct Source<R> {
    input: Input<R>,
    senders: Option<Senders>,
    /// Whether it was guessed from the first bytes that the input is text.
    guessed: bool,
    /// Whether no bytes have come yet.
    silent: bool,
    /// Whether an end or an error has come.
    done: bool,
}

/// The input as raw bytes or UTF-8.
type Bytes<R> = BufReader<Decoder<Counted<Whole<R>>>>;

enum Input<R> {
    Raw(Raw<Bytes<R>>),
    Text(Box<Text<Bytes<R>>>),
}

impl<R: Read> Source<R> {
    /// Begins to read `input`, and finds its format.
    ///
    /// Marked text needs no `senders`, any other input does. A mark that contradicts `senders` is an
    /// error, because a filter would hide that half of the traffic is missing.
    ///
    /// # Errors
    ///
    /// [`SourceError::Io`]; [`SourceError::Unsaid`] for raw input if `senders` is not one side.
    pub fn new(mut input: R, format: Format, senders: Option<Senders>) -> Result<Self, SourceError> {
        let head = match format {
            Format::Auto => read_head(&mut input, HEAD)?,
            Format::Raw => Vec::new(),
            Format::Hex | Format::Xxd => read_head(&mut input, LEAST)?,
        };
        let encoding = match Encoding::of(&head) {
            Some(Encoding::Utf16(_)) if head.len() < LEAST => None,
            encoding => encoding,
        };
        let lines = match format {
            Format::Auto if encoding.is_some() => Some(Lines::Any),
            Format::Auto | Format::Raw => None,
            Format::Hex => Some(Lines::Hex),
            Format::Xxd => Some(Lines::Dump),
        };
        let input = Counted { input: Cursor::new(head).chain(input), count: 0 };
        let input = BufReader::with_capacity(BUFFER, Decoder::new(input, encoding));
        let input = match (lines, senders) {
            (Some(lines), _) => Input::Text(Box::new(Text::new(input, lines))),
            (None, Some(Senders::Host)) => Input::Raw(Raw::new(input, Side::Host)),
            (None, Some(Senders::Device)) => Input::Raw(Raw::new(input, Side::Device)),
            (None, Some(Senders::Both) | None) => return Err(SourceError::Unsaid),
        };
        let guessed = format == Format::Auto;
        Ok(Self { input, senders, guessed, silent: true, done: false })
    }

    /// The next bytes. `None` at the end and after an error.
    ///
    /// # Errors
    ///
    /// [`SourceError::Io`]; for text [`SourceError::Text`] or, if the format was guessed,
    /// [`SourceError::Guessed`]; [`SourceError::Unsaid`] at the end of a text that has no bytes, if no
    /// senders are given.
    pub fn next_piece(&mut self) -> Result<Option<Piece<'_>>, SourceError> {
        if mem::replace(&mut self.done, true) {
            return Ok(None);
        }
        let piece = match &mut self.input {
            Input::Raw(raw) => raw.next_piece()?,
            Input::Text(text) => match text_piece(text, self.senders) {
                Err(SourceError::Text(error)) if self.guessed => {
                    return Err(SourceError::Guessed(error));
                }
                piece => piece?,
            },
        };
        if piece.is_none() && self.silent && self.senders.is_none() {
            return Err(SourceError::Unsaid);
        }
        self.done = piece.is_none();
        self.silent = false;
        Ok(piece)
    }

    /// Number of bytes of the input that have been read so far, for a progress bar.
    #[must_use]
    pub fn bytes_read(&self) -> u64 {
        let input = match &self.input {
            Input::Raw(raw) => &raw.input,
            Input::Text(text) => text.input(),
        };
        input.get_ref().input.count
    }
}

/// Raw input of one side.
struct Raw<R> {
    input: R,
    side: Side,
    /// Number of bytes of the buffer that were lent last.
    lent: usize,
    first: bool,
}

impl<R: BufRead> Raw<R> {
    fn new(input: R, side: Side) -> Self {
        Self { input, side, lent: 0, first: true }
    }

    fn next_piece(&mut self) -> io::Result<Option<Piece<'_>>> {
        self.input.consume(mem::take(&mut self.lent));
        while let Err(error) = self.input.fill_buf() {
            if error.kind() != ErrorKind::Interrupted {
                return Err(error);
            }
        }
        let bytes = self.input.fill_buf()?;
        self.lent = bytes.len();
        let first = mem::replace(&mut self.first, false);
        Ok((!bytes.is_empty()).then_some(Piece { side: self.side, first, bytes }))
    }
}

/// The next bytes of a text, with the sender that its mark and the option give.
fn text_piece<R: BufRead>(text: &mut Text<R>, senders: Option<Senders>) -> Result<Option<Piece<'_>>, SourceError> {
    let Some(chunk) = text.next_chunk()? else {
        return Ok(None);
    };
    let line = At { line: chunk.line, column: 1 };
    let side = match (chunk.side, senders) {
        (Some(side), None | Some(Senders::Both)) => side,
        (None | Some(Side::Host), Some(Senders::Host)) => Side::Host,
        (None | Some(Side::Device), Some(Senders::Device)) => Side::Device,
        (None, None | Some(Senders::Both)) => return Err(line.error(TextProblem::Unmarked).into()),
        (Some(_), Some(_)) => return Err(line.error(TextProblem::OtherSide).into()),
    };
    Ok(Some(Piece { side, first: chunk.first, bytes: chunk.bytes }))
}

/// Reader that counts the bytes it reads.
struct Counted<R> {
    input: R,
    count: u64,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.input.read(buffer)?;
        self.count += count as u64;
        Ok(count)
    }
}
