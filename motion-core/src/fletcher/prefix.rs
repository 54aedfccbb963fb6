//! Prefix sums: any range of a buffer checked in constant time.

use super::{Sum, verify};
use crate::stream::Memo;

/// Work that failed checks may cost for each byte of the stream that became an item.
const CREDIT: usize = 4;
/// Work that failed checks may cost from the start: a fault or two in short frames.
const FIRST_BUDGET: usize = 256;

/// What DMC verification remembers of a buffer of `N` bytes: the sum of all bytes before each byte.
///
/// A wrong length makes a receiver check again at the next marker, and a hostile stream is all
/// markers and long lengths: checked one by one, each byte would be summed thousands of times. So a
/// frame is summed directly only while checks that failed have cost no more than four bytes for each
/// byte of the stream. After that, prefix sums decide in constant time, and each byte enters them once.
///
/// Without failures it costs nothing but memory: two bytes for each byte of the buffer.
#[derive(Clone, Debug)]
pub struct PrefixSums<const N: usize> {
    /// Sums of the bytes before each one in `from..to`, counted from an arbitrary earlier byte.
    before: [[u8; 2]; N],
    /// Sums of the bytes before `to`.
    last: [u8; 2],
    from: usize,
    to: usize,
    budget: usize,
    work: usize,
}

impl<const N: usize> PrefixSums<N> {
    /// Sum of the bytes before `at`, which is in `from..=to`.
    #[inline]
    fn before(&self, at: usize) -> Sum {
        let sums = if at == self.to { self.last } else { self.before.get(at).copied().unwrap_or_default() };
        let [f0, f1] = sums.map(|sum| if sum == 255 { 0 } else { sum });
        Sum { f0, f1 }
    }

    /// Extends the sums to all bytes from `at` up to `end`.
    fn cover(&mut self, filled: &[u8], at: usize, end: usize) {
        if at < self.from || at > self.to {
            (self.from, self.to, self.last) = (at, at, [0; 2]);
        }
        let new = filled.get(self.to..end).unwrap_or_default();
        let slots = self.before.get_mut(self.to..end).unwrap_or_default();
        for (slot, &byte) in slots.iter_mut().zip(new) {
            *slot = self.last;
            let f0 = add(self.last[0], byte);
            self.last = [f0, add(self.last[1], f0)];
        }
        self.work = self.work.wrapping_add(new.len());
        self.to = self.to.max(end);
    }
}

/// Adds modulo 255 with the carry brought around, the quickest way there is. 255 stands for 0 as well.
fn add(a: u8, b: u8) -> u8 {
    let (sum, carry) = a.overflowing_add(b);
    sum.wrapping_add(u8::from(carry))
}

impl<const N: usize> Memo for PrefixSums<N> {
    const NEW: Self =
        Self { before: [[0; 2]; N], last: [0; 2], from: 0, to: 0, budget: FIRST_BUDGET, work: 0 };

    #[inline]
    fn verify(&mut self, filled: &[u8], at: usize, len: usize) -> bool {
        let end = at.saturating_add(len);
        let Some(frame) = filled.get(at..end) else { return false };
        if end > self.to && len <= self.budget {
            self.work = self.work.wrapping_add(len);
            let sound = verify(frame);
            if !sound {
                self.budget = self.budget.saturating_sub(len);
            }
            return sound;
        }
        self.cover(filled, at, end);
        self.before(end).after(self.before(at), len).is_zero()
    }

    #[inline]
    fn credit(&mut self, n: usize) {
        let cap = N.saturating_mul(CREDIT);
        self.budget = self.budget.saturating_add(n.saturating_mul(CREDIT)).min(cap);
    }

    fn shift(&mut self, n: usize) {
        let kept = self.to.saturating_sub(n);
        if kept == 0 {
            (self.from, self.to, self.last) = (0, 0, [0; 2]);
            return;
        }
        if let Some(sums) = self.before.get_mut(..self.to) {
            sums.copy_within(n.., 0);
        }
        self.work = self.work.wrapping_add(kept.wrapping_mul(2));
        self.from = self.from.saturating_sub(n);
        self.to = kept;
    }

    fn work(&self) -> usize {
        self.work
    }
}
