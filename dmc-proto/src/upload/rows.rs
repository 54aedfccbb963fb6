//! Values in rows, and a record of the values that arrived.

use core::ops::Range;

/// Rows of values, one for each track, in memory of the caller, with a bit for each value that was written.
///
/// Any row and index is allowed: nothing is read or written outside the row.
#[derive(Debug)]
pub(super) struct Rows<'m, T> {
    values: &'m mut [T],
    written: &'m mut [u32],
    /// Number of values in a row.
    len: usize,
}

/// Number of words for the bits of a row with `len` values. The first bit says whether there is any value. Then there
/// is one bit for each value.
pub(super) const fn words(len: usize) -> usize {
    (len / WORD).saturating_add(1)
}

const WORD: usize = 32;

impl<'m, T: Copy> Rows<'m, T> {
    /// Rows of `len` values, as many as the memory holds.
    pub(super) fn new(values: &'m mut [T], written: &'m mut [u32], len: usize) -> Self {
        Self { values, written, len }
    }

    /// Forgets all values.
    pub(super) fn clear(&mut self) {
        self.written.fill(0);
    }

    /// Values of a row.
    pub(super) fn values(&self, row: usize) -> Option<&[T]> {
        self.values.get(place(row, self.len)?)
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

    /// Values and bits of a row.
    fn row(&mut self, row: usize) -> Option<(&mut [T], &mut [u32])> {
        let (values, bits) = (place(row, self.len)?, place(row, words(self.len))?);
        Some((self.values.get_mut(values)?, self.written.get_mut(bits)?))
    }

    /// Writes values from index `at` on. If they reach beyond the row, it writes nothing and returns `None`.
    pub(super) fn write(&mut self, row: usize, at: usize, new: impl ExactSizeIterator<Item = T>) -> Option<()> {
        let (values, bits) = self.row(row)?;
        let places = at..at.checked_add(new.len())?;
        for (place, value) in values.get_mut(places.clone())?.iter_mut().zip(new) {
            *place = value;
        }
        mark(bits, places);
        Some(())
    }

    /// Repeats the value before index `at` up to the end of the first `len` values. Without such a value it does
    /// nothing.
    pub(super) fn repeat(&mut self, row: usize, at: usize, len: usize) -> Option<()> {
        let (values, bits) = self.row(row)?;
        let before = (0..at).rev().find(|&index| bit(bits, index.saturating_add(1)));
        if let Some(value) = before.and_then(|before| values.get(before).copied()) {
            values.get_mut(at..len)?.fill(value);
            mark(bits, at..len);
        }
        Some(())
    }

    /// Fills the gaps in the first `len` values of all rows: each gap with the value before it, and a gap at the start
    /// with the value after it. The gaps stay recorded.
    pub(super) fn fill(&mut self, len: usize) {
        let words = words(self.len).max(1);
        let rows = self.values.chunks_exact_mut(self.len.max(1)).zip(self.written.chunks_exact(words));
        for (values, bits) in rows.filter(|(_, bits)| bit(bits, 0)) {
            let written = |index: usize| bit(bits, index.saturating_add(1));
            let values = values.get_mut(..len).unwrap_or_default();
            let first = (0..len).find(|&index| written(index));
            let Some(mut held) = first.and_then(|first| values.get(first).copied()) else { continue };
            for (index, value) in values.iter_mut().enumerate() {
                if written(index) {
                    held = *value;
                } else {
                    *value = held;
                }
            }
        }
    }
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
}

impl Iterator for Gaps<'_> {
    type Item = Range<u32>;

    fn next(&mut self) -> Option<Range<u32>> {
        let written = |index: &usize| bit(self.bits, index.saturating_add(1));
        let start = self.rest.clone().find(|index| !written(index))?;
        let end = (start..self.rest.end).find(written).unwrap_or(self.rest.end);
        self.rest.start = end;
        Some(u32::try_from(start).ok()?..u32::try_from(end).ok()?)
    }
}
