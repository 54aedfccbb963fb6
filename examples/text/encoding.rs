//! Encodings of text: UTF-8, and UTF-16 as some programs of Windows write it.

use std::io::{self, Chain, Cursor, ErrorKind, Read};
use std::str::{self, Utf8Error};

/// Number of bytes from which UTF-16 is recognized.
pub(super) const LEAST: usize = 4;

/// A 16-bit unit from its bytes.
type Unit = fn([u8; 2]) -> u16;

/// Encoding of a text.
#[derive(Clone, Copy)]
pub(super) enum Encoding {
    Utf8,
    Utf16(Unit),
}

impl Encoding {
    /// Encoding of a text that begins with these bytes, which may end within a character. `None` if no text begins so.
    ///
    /// A text has no control characters. UTF-16 needs a byte order mark, except if it is ASCII with the low byte first.
    pub(super) fn of(head: &[u8]) -> Option<Self> {
        let (low_first, high_first): (Unit, Unit) = (u16::from_le_bytes, u16::from_be_bytes);
        match head {
            head if is_utf8(head) => Some(Self::Utf8),
            [0xfe] | [0xfe, 0xff, ..] => is_utf16(head, high_first, |_| true).then_some(Self::Utf16(high_first)),
            [0xff] | [0xff, 0xfe, ..] => is_utf16(head, low_first, |_| true).then_some(Self::Utf16(low_first)),
            [_, _, ..] => is_utf16(head, low_first, |char| char.is_ascii()).then_some(Self::Utf16(low_first)),
            _ => None,
        }
    }
}

fn is_utf8(head: &[u8]) -> bool {
    let cut = |error: Utf8Error| error.error_len().is_none().then_some(error.valid_up_to());
    let length = str::from_utf8(head).map_or_else(cut, |text| Some(text.len()));
    let valid = length.and_then(|length| str::from_utf8(head.get(..length)?).ok());
    valid.is_some_and(|text| text.chars().all(is_text))
}

fn is_utf16(head: &[u8], unit: Unit, may_be: impl Fn(char) -> bool) -> bool {
    let mut units: Vec<u16> = head.as_chunks::<2>().0.iter().map(|pair| unit(*pair)).collect();
    units.pop_if(|unit| is_first_half(*unit));
    char::decode_utf16(units).all(|char| char.is_ok_and(|char| is_text(char) && may_be(char)))
}

/// Whether a unit is the first half of a character.
fn is_first_half(unit: u16) -> bool {
    (0xd800..0xdc00).contains(&unit)
}

fn is_text(char: char) -> bool {
    !char.is_control() || "\t\r\n".contains(char)
}

/// Reader of a text in any encoding as UTF-8, or of raw bytes.
pub(super) struct Decoder<R> {
    pub(super) input: R,
    /// The unit of UTF-16. All other input is read as it is.
    unit: Option<Unit>,
    /// Bytes that are not decoded yet.
    raw: Vec<u8>,
    text: Cursor<Vec<u8>>,
}

impl<R: Read> Decoder<R> {
    pub(super) fn new(input: R, encoding: Option<Encoding>) -> Self {
        let unit = if let Some(Encoding::Utf16(unit)) = encoding { Some(unit) } else { None };
        Self { input, unit, raw: Vec::new(), text: Cursor::default() }
    }
}

impl<R: Read> Read for Decoder<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let Some(unit) = self.unit else { return self.input.read(buffer) };
        loop {
            let count = self.text.read(buffer)?;
            if count > 0 || buffer.is_empty() {
                return Ok(count);
            }
            let mut chunk = [0; 4096];
            match self.input.read(&mut chunk)? {
                0 if self.raw.is_empty() => return Ok(0),
                0 => {
                    self.raw.clear();
                    return Err(io::Error::new(ErrorKind::InvalidData, "the UTF-16 text ends within a character"));
                }
                count => self.raw.extend(chunk.iter().take(count)),
            }
            let mut units: Vec<u16> = self.raw.as_chunks::<2>().0.iter().map(|pair| unit(*pair)).collect();
            // The other half of the last character follows.
            units.pop_if(|unit| is_first_half(*unit));
            self.raw.drain(..2 * units.len());
            self.text = Cursor::new(String::from_utf16_lossy(&units).into_bytes());
        }
    }
}

/// An input, with the bytes before it that were read to find its encoding.
pub(super) type Whole<R> = Chain<Cursor<Vec<u8>>, R>;

/// Reads the first bytes, until there are `enough` or they are not text.
pub(super) fn read_head(input: &mut impl Read, enough: usize) -> io::Result<Vec<u8>> {
    let mut head = Vec::with_capacity(enough);
    let mut chunk = vec![0; enough];
    while let Some(room) = chunk.get_mut(head.len()..).filter(|room| !room.is_empty()) {
        match input.read(room) {
            Ok(0) => break,
            Ok(count) => head.extend(room.iter().take(count)),
            Err(error) if error.kind() == ErrorKind::Interrupted => (),
            Err(error) => return Err(error),
        }
        if Encoding::of(&head).is_none() {
            break;
        }
    }
    Ok(head)
}
