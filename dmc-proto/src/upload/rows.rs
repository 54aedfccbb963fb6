//! Values in rows, and a record of the values that arrived.

use core::ops::Range;

/// Rows of values, one for each track, in memory of the caller, with a bit for each value that was written.
///
/// The values stay as bytes, so that there is only one code for positions and for levels. Any row and index is allowed:
/// nothing is read or written outside the row.
#[derive(Debug)]
pub(super) struct Rows<'m> {
    values: &'m mut [u8],
    written: &'m mut [u32],
    /// Number of bytes of a value.
    width: usize,
    /// Number of values in a row.
    len: usize,
}

/// Number of words for the bits of a row with `len` values. The first bit says whether there is any value. Then there
/// is one bit for each value.
pub(super) const fn words(len: usize) -> usize {
    (len / WORD).saturating_add(1)
}

const WORD: usize = 32;

impl<'m> Rows<'m> {
    /// Rows of `len` values of `width` bytes, as many as the memory holds.
    pub(super) fn new(values: &'m mut [u8], written: &'m mut [u32], width: usize, len: usize) -> Self {
        Self { values, written, width, len }
    }

    /// Forgets all values.
    pub(super) fn clear(&mut self) {
        self.written.fill(0);
    }

    /// Bytes of a value.
    pub(super) fn value(&self, row: usize, index: usize) -> Option<&[u8]> {
        let value = place(row, self.len)?.nth(index)?;
        self.values.get(place(value, self.width)?)
    }

    /// Whether a row has any value.
    pub(super) fn has_any(&self, row: usize) -> bool {
        self.bits(row).is_some_and(|bits| bit(bits, 0))
    }

    /// Gaps in the first `len` values of a row.
    pub(super) fn gaps(&self, row: usize, len: usize) -> Gaps<'_> {
        Gaps { bits: self.bits(row).unwrap_or_default(), rest: 0..len.min(self.len) }
    }

    fn bits(&self, row: usize) -> Option<&[u32]> {
        self.written.get(place(row, words(self.len))?)
    }

    /// Bytes and bits of a row.
    fn row(&mut self, row: usize) -> Option<(&mut [u8], &mut [u32])> {
        let (values, bits) = (place(row, self.len.checked_mul(self.width)?)?, place(row, words(self.len))?);
        Some((self.values.get_mut(values)?, self.written.get_mut(bits)?))
    }

    /// Writes the bytes of values to these places. If the places reach beyond the row, it writes nothing and returns `None`.
    pub(super) fn write(&mut self, row: usize, places: Range<usize>, new: &[u8]) -> Option<()> {
        let width = self.width;
        let (values, bits) = self.row(row)?;
        values.get_mut(bytes(&places, width))?.iter_mut().zip(new).for_each(|(byte, new)| *byte = *new);
        mark(bits, places);
        Some(())
    }

    /// Repeats the value before index `at` up to the end of the first `len` values. Without such a value it does
    /// nothing.
    pub(super) fn repeat(&mut self, row: usize, at: usize, len: usize) -> Option<()> {
        let width = self.width;
        let (values, bits) = self.row(row)?;
        let before = (0..at).rev().find(|&index| bit(bits, index.saturating_add(1)))?;
        hold(values, width, before.saturating_add(1)..len);
        mark(bits, at..len);
        Some(())
    }

    /// Fills the gaps in the first `len` values of all rows: each gap with the value before it, and a gap at the start
    /// with the value after it. The gaps stay recorded.
    pub(super) fn fill(&mut self, len: usize) {
        let width = self.width;
        for row in 0.. {
            let Some((values, bits)) = self.row(row) else { return };
            let mut gaps = Gaps { bits, rest: 0..len };
            while let Some(gap) = gaps.next_gap() {
                hold(values, width, gap);
            }
        }
    }
}

/// Gives each of these places the value before it, and at the start of a row the value after it.
fn hold(values: &mut [u8], width: usize, places: Range<usize>) {
    let is_start = places.start == 0;
    let places = bytes(&places, width);
    let mut copy = |from: usize, to: usize| {
        if let (Some(byte), Some(place)) = (values.get(from).copied(), values.get_mut(to)) {
            *place = byte;
        }
    };
    if is_start {
        places.rev().for_each(|at| copy(at.saturating_add(width), at));
    } else {
        places.for_each(|at| copy(at.saturating_sub(width), at));
    }
}

/// Places of the bytes of values.
fn bytes(places: &Range<usize>, width: usize) -> Range<usize> {
    places.start.saturating_mul(width)..places.end.saturating_mul(width)
}

/// Place of a row of length `len`.
fn place(row: usize, len: usize) -> Option<Range<usize>> {
    let start = row.checked_mul(len)?;
    Some(start..start.checked_add(len)?)
}

fn bit(bits: &[u32], at: usize) -> bool {
    bits.get(at / WORD).is_some_and(|word| word & mask(at) != 0)
}

/// Sets the bits of values, and the bit that says that there are any.
fn mark(bits: &mut [u32], values: Range<usize>) {
    if values.is_empty() {
        return;
    }
    let bits_of_values = values.map(|index| index.saturating_add(1));
    for at in core::iter::once(0).chain(bits_of_values) {
        if let Some(word) = bits.get_mut(at / WORD) {
            *word |= mask(at);
        }
    }
}

fn mask(at: usize) -> u32 {
    1_u32.rotate_left(u32::try_from(at % WORD).unwrap_or(0))
}

/// Gaps of a track: frames without a value of their own, as ranges of indices, in ascending order.
#[derive(Clone, Debug)]
pub struct Gaps<'a> {
    bits: &'a [u32],
    rest: Range<usize>,
}

impl Gaps<'_> {
    /// No gap.
    pub(super) const NONE: Self = Self { bits: &[], rest: 0..0 };

    fn next_gap(&mut self) -> Option<Range<usize>> {
        let written = |index: &usize| bit(self.bits, index.saturating_add(1));
        let start = self.rest.clone().find(|index| !written(index))?;
        let end = (start..self.rest.end).find(written).unwrap_or(self.rest.end);
        self.rest.start = end;
        Some(start..end)
    }
}

impl Iterator for Gaps<'_> {
    type Item = Range<u32>;

    fn next(&mut self) -> Option<Range<u32>> {
        let Range { start, end } = self.next_gap()?;
        Some(u32::try_from(start).ok()?..u32::try_from(end).ok()?)
    }
}
