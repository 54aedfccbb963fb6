//! Prefix sums, which verify any range of a buffer in constant time.

use super::{Sum, verify};
use crate::stream::Memo;

/// Bytes of failed checks that are allowed for each byte of the stream.
const CREDIT: usize = 2;
/// How many times slower it is to enter a byte into the sums than to check it directly.
const SLOWER: usize = 8;
/// Number of bytes that enter the sums before they are needed, because a few bytes at a time are slow.
const AHEAD: usize = 64;
/// Bytes of failed checks that are allowed from the start: one or two faults in short frames.
const FIRST_BUDGET: usize = 256;

/// Sums of all bytes before each byte of a buffer of `N` bytes, which the verification of DMC frames remembers.
///
/// After a wrong length, a receiver checks again at the next marker. A hostile stream consists of markers and long
/// lengths: if each frame were summed on its own, each byte would be summed thousands of times. So a frame is summed
/// directly only while failed checks have cost at most two bytes for each byte of the stream. After that, prefix sums
/// decide in constant time, and each byte enters the sums once.
///
/// Without failures it costs only memory: two bytes for each byte of the buffer.
#[derive(Clone, Debug)]
pub struct PrefixSums<const N: usize> {
    /// Sums of the bytes before each byte in `..to`, counted from an arbitrary earlier byte.
    before: [[u8; 2]; N],
    /// Sums of the bytes before `to`.
    last: [u8; 2],
    /// Position of the first byte that has not entered the sums.
    to: usize,
    /// Bytes of checks that may still fail before the sums are used.
    budget: usize,
    /// Whether the first budget was given. An empty memory is all zero.
    has_begun: bool,
    /// Position before which all bytes have added to the budget.
    paid: usize,
    work: usize,
}

impl<const N: usize> PrefixSums<N> {
    /// The sums of the bytes before `at`, which is in `..=to`.
    #[inline]
    fn before(&self, at: usize) -> [u8; 2] {
        if at == self.to { self.last } else { self.before.get(at).copied().unwrap_or_default() }
    }

    /// Whether the bytes from `at` to `end`, both in `..=to`, sum to zero.
    #[inline]
    fn sound(&self, at: usize, end: usize) -> bool {
        let (before, after) = (self.before(at), self.before(end));
        // The first sums differ in all cases except one in 255.
        before[0] % 255 == after[0] % 255 && sum(after).after(sum(before), end.saturating_sub(at)).is_zero()
    }

    /// Whether the budget allows that a check of `len` bytes at `at` fails.
    #[inline]
    fn affords(&mut self, at: usize, len: usize) -> bool {
        if len > self.budget {
            self.earn(at);
        }
        len <= self.budget
    }

    /// Adds to the budget for the bytes before `at`.
    fn earn(&mut self, at: usize) {
        let first = if core::mem::replace(&mut self.has_begun, true) { 0 } else { FIRST_BUDGET };
        let earned = at.saturating_sub(self.paid).saturating_mul(CREDIT).saturating_add(first);
        self.budget = self.budget.saturating_add(earned).min(N.saturating_mul(CREDIT));
        self.paid = self.paid.max(at);
    }

    /// Enters all bytes up to `end` into the sums. It is not inlined, because valid frames do not need it.
    #[inline(never)]
    fn cover(&mut self, filled: &[u8], end: usize) {
        let new = filled.get(self.to..end).unwrap_or_default();
        let slots = self.before.get_mut(self.to..end).unwrap_or_default();
        let [mut f0, mut f1] = self.last;
        for (slot, &byte) in slots.iter_mut().zip(new) {
            *slot = [f0, f1];
            f0 = add(f0, byte);
            f1 = add(f1, f0);
        }
        self.last = [f0, f1];
        self.work = self.work.wrapping_add(new.len());
        self.to = self.to.max(end);
    }
}

/// A sum from two bytes in which 255 may mean 0.
fn sum(sums: [u8; 2]) -> Sum {
    let [f0, f1] = sums.map(|sum| sum % 255);
    Sum { f0, f1 }
}

/// Adds modulo 255 with an end-around carry, which is the fastest way. The result may be 255 for 0.
fn add(a: u8, b: u8) -> u8 {
    let (sum, carry) = a.overflowing_add(b);
    sum.wrapping_add(u8::from(carry))
}

impl<const N: usize> Memo for PrefixSums<N> {
    const NEW: Self = Self { before: [[0; 2]; N], last: [0; 2], to: 0, budget: 0, has_begun: false, paid: 0, work: 0 };

    #[inline]
    fn is_sound(frame: &[u8]) -> bool {
        verify(frame)
    }

    #[inline]
    fn verify(&mut self, filled: &[u8], at: usize, len: usize) -> bool {
        let end = at.saturating_add(len);
        if end <= self.to {
            return self.sound(at, end);
        }
        let Some(frame) = filled.get(at..end) else { return false };
        // If the sums reach nearly to the end, it is faster to continue them than to check directly.
        let near = at <= self.to && end.saturating_sub(self.to).saturating_mul(SLOWER) <= len;
        if near || !self.affords(at, len) {
            self.cover(filled, end.saturating_add(AHEAD).min(filled.len()));
            return self.sound(at, end);
        }
        self.work = self.work.wrapping_add(len);
        let sound = verify(frame);
        if !sound {
            self.budget = self.budget.saturating_sub(len);
        }
        sound
    }

    fn shift(&mut self, n: usize) {
        self.earn(n);
        self.paid = self.paid.saturating_sub(n);
        let kept = self.to.saturating_sub(n);
        if kept == 0 {
            (self.to, self.last) = (0, [0; 2]);
            return;
        }
        if let Some(sums) = self.before.get_mut(..self.to) {
            sums.copy_within(n.., 0);
        }
        self.work = self.work.wrapping_add(kept.wrapping_mul(2));
        self.to = kept;
    }

    fn work(&self) -> usize {
        self.work
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    /// Bytes with valid ranges at many places: those between equal sums.
    fn bytes(len: usize) -> Vec<u8> {
        let mut state = 7_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let [_, low, high, choice] = state.to_le_bytes();
            if choice < 64 { high } else { 255 * (low & 1) }
        };
        (0..len).map(|_| next()).collect()
    }

    #[test]
    fn prefix_sums_agree_with_a_direct_check() {
        const N: usize = 300;
        let stream = bytes(1000);
        let mut sound = 0;
        for budget in [0, 40, usize::MAX] {
            let mut memo = PrefixSums::<N> { budget, has_begun: true, ..PrefixSums::NEW };
            let mut dropped = 0;
            for (step, start) in (0..stream.len() - N).step_by(3).enumerate() {
                let len = 1 + step * 7 % 70;
                let at = start - dropped;
                let filled = &stream[dropped..dropped + N.min(at + len + step % 90)];
                assert_eq!(memo.verify(filled, at, len), verify(&filled[at..at + len]), "{len} bytes from {start}");
                sound += usize::from(verify(&filled[at..at + len]));
                if at + 3 + 70 + 90 > N {
                    memo.shift(at);
                    dropped += at;
                }
            }
        }
        assert!(sound > 30, "only {sound} valid ranges were tried");
    }

    #[test]
    fn failed_checks_cost_at_most_three_bytes_for_each_byte_received() {
        let mut memo = PrefixSums::<4096>::NEW;
        let flood = [1; 4096];
        for at in 0..3000 {
            assert!(!memo.verify(&flood, at, 1000));
        }
        let (paid, summed) = (FIRST_BUDGET + 3000 * CREDIT, 4096);
        assert!(memo.work() <= paid + summed, "{} bytes", memo.work());
    }

    #[test]
    fn bytes_enter_the_sums_only_after_too_many_failed_checks() {
        let flood = [1; 4096];
        let mut memo = PrefixSums::<4096>::NEW;
        let cost = |memo: &mut PrefixSums<4096>, at, len| {
            let before = memo.work();
            assert!(!memo.verify(&flood, at, len));
            memo.work() - before
        };
        assert_eq!(cost(&mut memo, 0, FIRST_BUDGET), FIRST_BUDGET);
        assert_eq!(cost(&mut memo, 100, 100 * CREDIT), 100 * CREDIT, "directly, within the budget");
        assert_eq!(cost(&mut memo, 120, 1000), 1120 + AHEAD, "all bytes from the first one");
        assert_eq!(cost(&mut memo, 130, 1000), 0, "the sums are known");
        memo.budget = 4096;
        assert_eq!(
            cost(&mut memo, 190, 1000),
            6 + AHEAD,
            "a few bytes more, although the budget allows a direct check"
        );
        assert_eq!(cost(&mut memo, 1000, 1000), 1000, "directly again, far after the end of the sums");
    }

    #[test]
    fn bytes_that_left_the_buffer_count_once_for_the_budget() {
        let mut memo = PrefixSums::<4096>::NEW;
        let flood = [1; 4096];
        memo.shift(400);
        memo.shift(100);
        assert!(!memo.verify(&flood, 10, 1000));
        assert_eq!(memo.work(), 1000, "directly, within the budget");
        assert!(!memo.verify(&flood, 20, 1000));
        assert_eq!(memo.work(), 1000 + 1020 + AHEAD, "the budget is used up");
        let budget = memo.budget;
        memo.shift(20);
        assert_eq!(memo.budget, budget, "these bytes were counted before");
    }

    #[test]
    fn a_range_outside_the_buffer_is_not_valid() {
        let mut memo = PrefixSums::<8>::NEW;
        assert!(memo.verify(&[0; 8], 4, 4));
        assert!(!memo.verify(&[0; 8], 4, 5));
        assert!(!memo.verify(&[0; 8], usize::MAX, 2));
    }
}
