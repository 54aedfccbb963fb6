//! Messages for fuzzers, drawn from their tables: each kind as often as any other, with a body that its layout describes.

use core::marker::PhantomData;

use arbitrary::{Arbitrary, Error, Result, Unstructured};
use zerocopy::{ByteOrder, U16, U32};

use super::{Kind, Messages, PartKind, Row, Side};
use crate::owned::Owned;

/// Room for a body that is drawn, in bytes: the longest layout without lists has some 600.
const ROOM: usize = 1024;
/// Number of bodies that are drawn until one is of the kind that was chosen.
const TRIES: usize = 16;
/// Bytes of a body of zeros, in which every list and text is empty.
const ZEROS: &[u8] = &[0; 128];

/// Draws a message of a side: its number, and the length of its body, which is written to the front of `room`.
///
/// Each kind of the table is as likely as any other, and so is a message without a type. The layout of the kind says where
/// numbers, lists and texts are, and how long these are. Small numbers are more likely than others, because they are
/// motors, names of values, and flags. Nothing is allocated.
///
/// # Errors
///
/// [`Error`] if `room` is too small for the kind. After the end of the input, zeros are drawn.
fn draw<S: Side>(u: &mut Unstructured<'_>, room: &mut [u8]) -> Result<(u32, usize)> {
    let Some(kind) = choose::<S::Message<'_>>(u)? else {
        let mut sheet = Sheet::<S::Order>::new(u, room);
        sheet.bytes(32)?;
        let len = sheet.len;
        return Ok((u.int_in_range(0..=0xff_ffff)?, len));
    };
    for _ in 0..TRIES {
        let mut sheet = Sheet::<S::Order>::new(u, room);
        let whole = sheet.message(kind.layout);
        let len = sheet.len;
        if whole.is_ok() {
            let body = room.get(..len).unwrap_or_default();
            for number in [neighbour(u, kind.number)?, kind.number] {
                if decode::<S::Message<'_>>(kind, number, body).is_some() {
                    return Ok((number, len));
                }
            }
        }
    }
    room.fill(0);
    let is_body =
        |len: &usize| decode::<S::Message<'_>>(kind, kind.number, room.get(..*len).unwrap_or_default()).is_some();
    (0..=room.len()).find(is_body).map(|len| (kind.number, len)).ok_or(Error::NotEnoughData)
}

/// A message that borrows its body from the input of the fuzzer: as that of [`Owned`], except that a list or a text after a
/// count is as the input has it, or empty. This is the implementation of [`Arbitrary`] of the messages.
///
/// # Errors
///
/// [`Error`] if a body of zeros is not of the kind. After the end of the input, zeros are drawn.
#[doc(hidden)]
pub fn draw_borrowed<'a, M: Messages<'a>>(u: &mut Unstructured<'a>) -> Result<M> {
    let Some(kind) = choose::<M>(u)? else {
        let number = u.int_in_range(0..=0xff_ffff)?;
        return Ok(M::other(number, some(u, 32)?));
    };
    let least = kind.layout.iter().filter(|row| row.part == PartKind::Fixed).map(|row| row.size);
    let least = least.fold(0, usize::saturating_add);
    for most in [0, 2, 16, 64] {
        let number = neighbour(u, kind.number)?;
        let len = least.saturating_add(u.int_in_range(0..=most)?).min(u.len());
        let body = u.peek_bytes(len).unwrap_or_default();
        for number in [number, kind.number] {
            if let Some(message) = decode::<M>(kind, number, body) {
                u.bytes(len)?;
                return Ok(message);
            }
        }
    }
    let zeros = |len| decode::<M>(kind, kind.number, ZEROS.get(..len)?);
    (least..=ZEROS.len()).find_map(zeros).ok_or(Error::NotEnoughData)
}

/// Chooses a kind of the table; `None` for a message without a type.
fn choose<'a, M: Messages<'a>>(u: &mut Unstructured<'_>) -> Result<Option<&'static Kind>> {
    Ok(M::ALL.get(u.int_in_range(0..=M::ALL.len())?))
}

/// The message, if it is of a kind.
fn decode<'a, M: Messages<'a>>(kind: &Kind, number: u32, body: &'a [u8]) -> Option<M> {
    M::decode_body(number, body).ok().filter(|message| message.name() == kind.name)
}

/// The number, or one near it, which another message of the same kind may have.
fn neighbour(u: &mut Unstructured<'_>, number: u32) -> Result<u32> {
    Ok(match u.int_in_range(0..=7_u8)? {
        0 => number.wrapping_add(1),
        1 => number.wrapping_add(2),
        2 => number ^ 0x8000,
        3 => number ^ u32::from(u.arbitrary::<u8>()?),
        4 => number ^ u32::from(u.arbitrary::<u16>()?),
        _ => number,
    })
}

/// At most so many bytes of the input.
fn some<'a>(u: &mut Unstructured<'a>, most: usize) -> Result<&'a [u8]> {
    let len = u.int_in_range(0..=most.min(u.len()))?;
    u.bytes(len)
}

/// A body that is being laid out.
struct Sheet<'d, 'u, O> {
    u: &'d mut Unstructured<'u>,
    room: &'d mut [u8],
    len: usize,
    order: PhantomData<O>,
}

impl<'d, 'u, O: ByteOrder> Sheet<'d, 'u, O> {
    const fn new(u: &'d mut Unstructured<'u>, room: &'d mut [u8]) -> Self {
        Self { u, room, len: 0, order: PhantomData }
    }

    /// Lays out a body: its rows, and sometimes a tail.
    fn message(&mut self, rows: &[Row]) -> Result<()> {
        self.rows(rows)?;
        if self.u.ratio(1, 16)? { self.bytes(8) } else { Ok(()) }
    }

    fn rows(&mut self, rows: &[Row]) -> Result<()> {
        for row in rows {
            match row.part {
                // All rows after it are absent too.
                PartKind::Optional if self.u.ratio(1, 4)? => return Ok(()),
                PartKind::Fixed | PartKind::Optional => self.element(row)?,
                PartKind::List => {
                    let count = self.count(row.size)?;
                    self.elements(row, count)?;
                }
                PartKind::Counted => {
                    let count = self.count(row.size)?;
                    self.put(&[count])?;
                    self.elements(row, count)?;
                }
                PartKind::Text16 | PartKind::Block16 => {
                    let len = self.count(1)?;
                    self.put(&U16::<O>::new(len.into()).to_bytes())?;
                    let from = self.len;
                    self.fill(len.into())?;
                    if row.part == PartKind::Text16 && !self.u.ratio(1, 8)? {
                        self.letters(from);
                    }
                }
                // Some kinds of rigs have more than half a kilobyte.
                PartKind::Rest => {
                    let most = *self.u.choose(&[8, 16, 32, 128, 600])?;
                    self.bytes(most)?;
                }
            }
        }
        Ok(())
    }

    /// Draws a number of elements, mostly a small one, for which there is room.
    fn count(&mut self, size: usize) -> Result<u8> {
        let most = if self.u.ratio(1, 16)? { u8::MAX } else { 6 };
        let count = self.u.int_in_range(0..=most)?;
        let free = self.room.len().saturating_sub(self.len).saturating_sub(2).checked_div(size).unwrap_or(0);
        Ok(u8::try_from(free).map_or(count, |free| free.min(count)))
    }

    fn elements(&mut self, row: &Row, count: u8) -> Result<()> {
        (0..count).try_for_each(|_| self.element(row))
    }

    /// Lays out a field, or an element of a list.
    fn element(&mut self, row: &Row) -> Result<()> {
        if !row.element.is_empty() {
            return self.rows(row.element);
        }
        match (row.wire, row.size) {
            ("f32", _) => {
                let number = self.float()?;
                self.put(&U32::<O>::new(number.to_bits()).to_bytes())
            }
            ("u8", _) => {
                let [byte, ..] = self.number()?.to_le_bytes();
                self.put(&[byte])
            }
            ("u16" | "i16", _) => {
                let [low, high, ..] = self.number()?.to_le_bytes();
                self.put(&U16::<O>::new(u16::from_le_bytes([low, high])).to_bytes())
            }
            ("u32" | "i32", _) => {
                let number = self.number()?;
                self.put(&U32::<O>::new(number).to_bytes())
            }
            (_, size) => self.fill(size),
        }
    }

    fn number(&mut self) -> Result<u32> {
        match self.u.int_in_range(0..=7_u8)? {
            0..4 => self.u.int_in_range(0..=8),
            4 => Ok(1_u32.wrapping_shl(self.u.int_in_range(0..=31)?)),
            5 => Ok(u32::MAX),
            _ => self.u.arbitrary(),
        }
    }

    fn float(&mut self) -> Result<f32> {
        Ok(match self.u.int_in_range(0..=3_u8)? {
            0 => f32::from(self.u.int_in_range(0..=16_u8)?) / 16.0,
            1 | 2 => f32::from(self.u.arbitrary::<i16>()?) / 64.0,
            _ => f32::from_bits(self.u.arbitrary()?),
        })
    }

    /// Lays out at most so many bytes.
    fn bytes(&mut self, most: usize) -> Result<()> {
        let len = self.u.int_in_range(0..=most)?;
        self.fill(len)
    }

    /// Lays out bytes of the input, and zeros after its end.
    fn fill(&mut self, len: usize) -> Result<()> {
        let end = self.len.saturating_add(len);
        let place = self.room.get_mut(self.len..end).ok_or(Error::NotEnoughData)?;
        self.u.fill_buffer(place)?;
        self.len = end;
        Ok(())
    }

    /// Makes letters of the bytes from a place on.
    fn letters(&mut self, from: usize) {
        for byte in self.room.get_mut(from..self.len).unwrap_or_default() {
            *byte = byte.checked_rem(95).unwrap_or(0).saturating_add(b' ');
        }
    }

    fn put(&mut self, bytes: &[u8]) -> Result<()> {
        let end = self.len.saturating_add(bytes.len());
        self.room.get_mut(self.len..end).ok_or(Error::NotEnoughData)?.copy_from_slice(bytes);
        self.len = end;
        Ok(())
    }
}

/// Message of a kind at random, laid out as its table says. After the end of the input, zeros are drawn.
impl<'u, S: Side> Arbitrary<'u> for Owned<S> {
    fn arbitrary(u: &mut Unstructured<'u>) -> Result<Self> {
        let mut body = std::vec![0; ROOM];
        let (number, len) = draw::<S>(u, &mut body)?;
        body.truncate(len);
        Ok(Self::from_parts(number, body))
    }
}
