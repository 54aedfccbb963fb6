//! Loops that add bytes, and the bounds that keep their sums from overflowing.
//!
//! Words are little-endian. A word is `even + 256 * odd`, where `even` and `odd` hold the bytes at even and at odd
//! places, each in a lane of 16 bits. Sums of words split in the same way. So the loops add whole words and odd bytes,
//! which takes one shift and at most one mask for each word, and the sum of the even bytes is computed at the end.
//!
//! If the length of a message is not a multiple of a word, the short word comes first and is filled with zero bytes in
//! front: zero bytes in front of a message change neither sum.

/// Both sums of some bytes, before the modulo operation.
#[derive(Clone, Copy, Default)]
pub(super) struct Raw {
    pub(super) f0: u32,
    pub(super) f1: u32,
}

impl Raw {
    /// The sums of the bytes of `self`, followed by the `len` bytes of `next`.
    #[inline]
    pub(super) const fn then(self, next: Self, len: usize) -> Self {
        // Each byte of `next` adds the first sum of `self` to the second sum once more.
        #[expect(clippy::cast_possible_truncation, reason = "below 255")]
        let times = (len % 255) as u32;
        Self {
            f0: self.f0.wrapping_add(next.f0),
            f1: self.f1.wrapping_add(next.f1).wrapping_add(self.f0.wrapping_mul(times)),
        }
    }

    /// Adds the second sums before the last row of `row` bytes, in two lanes of 32 bits. Each is a sum of first sums,
    /// which count once more for each byte of a row.
    #[inline]
    const fn and_before(self, before: u64, row: u32) -> Self {
        let before = ((before & 0xFFFF_FFFF) as u32).wrapping_add((before >> 32) as u32);
        Self { f0: self.f0, f1: self.f1.wrapping_add(before.wrapping_mul(row)) }
    }

    /// The same sums modulo 255.
    #[inline]
    pub(super) const fn modulo_255(self) -> Self {
        Self { f0: self.f0 % 255, f1: self.f1 % 255 }
    }
}

/// Length in bytes from which on [`long`] is faster than [`short`].
const LONG: usize = 128;

/// Sums any number of bytes. In firmware the code has to be short, because it has to be stored.
#[inline]
pub(super) fn sum(bytes: &[u8]) -> Raw {
    if cfg!(target_os = "none") {
        one_by_one(bytes)
    } else if bytes.len() < LONG {
        short(bytes)
    } else {
        long(bytes)
    }
}

/// Sums any number of bytes, in blocks of 4096 bytes. Then a first sum is at most 255 * 4096 + 254, and a second sum is at most
/// 255 * 4096 * 4097 / 2 + 254 * 4097, which is less than half of what 32 bits hold.
#[inline(never)]
fn one_by_one(bytes: &[u8]) -> Raw {
    bytes.chunks(4096).fold(Raw::default(), |Raw { mut f0, mut f1 }, block| {
        for &byte in block {
            f0 = f0.wrapping_add(byte.into());
            f1 = f1.wrapping_add(f0);
        }
        Raw { f0, f1 }.modulo_255()
    })
}

/// Sums fewer than [`LONG`] bytes, that is at most 16 words of eight.
#[inline]
fn short(bytes: &[u8]) -> Raw {
    let begin = bytes.len() % 8;
    let first = match bytes.first_chunk() {
        // Two shifts, because one shift by all 64 bits would be no shift.
        Some(word) => u64::from_le_bytes(*word) << 56_usize.wrapping_sub(begin.wrapping_mul(8)) << 8,
        None => bytes.iter().fold(0, |word, &byte| (word >> 8) | (u64::from(byte) << 56)),
    };
    // The first sums, and the second sums, which add up the first sums before each word.
    let (mut whole, mut odd) = (first, odd_bytes(first));
    let (mut wholes, mut odds) = (0_u64, 0_u64);
    for word in bytes.get(begin..).unwrap_or_default().chunks_exact(8) {
        let word = word.first_chunk().map_or(0, |word| u64::from_le_bytes(*word));
        wholes = wholes.wrapping_add(whole);
        odds = odds.wrapping_add(odd);
        whole = whole.wrapping_add(word);
        odd = odd.wrapping_add(odd_bytes(word));
    }
    // With even and odd bytes together, a lane of the second sums is at most 2 * 255 * (0 + .. + 15) = 61,200.
    let before = wholes.wrapping_sub(odds << 8).wrapping_add(odds);
    within(whole.wrapping_sub(odd << 8), odd).and_before(pairs(before), 8)
}

/// Sums [`LONG`] bytes or more, in blocks of 23 rows of 16 bytes.
fn long(bytes: &[u8]) -> Raw {
    let (odd, rows) = bytes.split_at_checked(bytes.len() % 16).unwrap_or_default();
    rows.chunks(16 * 23).fold(short(odd), |sum, block| sum.then(Columns::of(block).sums(), block.len()).modulo_255())
}

/// Eight lanes of 16 bits, as in a vector register.
type Lanes = [u16; 8];

/// The sums of rows of 16 bytes, lane by lane, while rows are added.
#[derive(Default)]
struct Rows {
    /// First sums.
    whole: Lanes,
    odd: Lanes,
    /// Second sums, which add up the first sums before each row.
    wholes: Lanes,
    odds: Lanes,
}

impl Rows {
    #[inline]
    fn with(self, row: &[u8; 16]) -> Self {
        let row = lanes(row);
        Self {
            wholes: zip(self.wholes, self.whole, u16::wrapping_add),
            odds: zip(self.odds, self.odd, u16::wrapping_add),
            whole: zip(self.whole, row, u16::wrapping_add),
            odd: zip(self.odd, row, |odd, word| odd.wrapping_add(word >> 8)),
        }
    }
}

/// The final sums of the even bytes and of the odd bytes.
struct Columns {
    even: Lanes,
    odd: Lanes,
    evens: Lanes,
    odds: Lanes,
}

impl Columns {
    /// Sums at most 23 rows. Then a first sum is at most 255 * 23 = 5,865, and a second sum is at most 255 * (0 + .. +
    /// 22) = 64,515.
    ///
    /// It is not inlined: the compiler holds each result in a vector register only if the results go to memory at the
    /// end. It adds two rows in each turn, because the compiler does not always unroll the loop.
    #[inline(never)]
    fn of(rows: &[u8]) -> Self {
        let mut sums = Rows::default();
        let mut pairs = rows.chunks_exact(32);
        for pair in &mut pairs {
            if let (Some(row), Some(next)) = (pair.first_chunk(), pair.last_chunk()) {
                sums = sums.with(row).with(next);
            }
        }
        if let Some(row) = pairs.remainder().first_chunk() {
            sums = sums.with(row);
        }
        let Rows { whole, odd, wholes, odds } = sums;
        let even = |whole: u16, odd: u16| whole.wrapping_sub(odd << 8);
        Self { even: zip(whole, odd, even), odd, evens: zip(wholes, odds, even), odds }
    }

    /// Both sums of all the bytes.
    #[inline]
    fn sums(&self) -> Raw {
        let ([even0, even1], [odd0, odd1]) = (halves(self.even), halves(self.odd));
        let before = [self.evens, self.odds]
            .into_iter()
            .flat_map(halves)
            .fold(0, |sum: u64, lanes| sum.wrapping_add(pairs(lanes)));
        within(even0, odd0).then(within(even1, odd1), 8).and_before(before, 16)
    }
}

#[inline]
fn lanes(row: &[u8; 16]) -> Lanes {
    let mut lanes = [0; 8];
    for (lane, word) in lanes.iter_mut().zip(row.chunks_exact(2)) {
        *lane = word.first_chunk().map_or(0, |word| u16::from_le_bytes(*word));
    }
    lanes
}

#[inline]
fn zip(mut left: Lanes, right: Lanes, each: impl Fn(u16, u16) -> u16) -> Lanes {
    for (left, right) in left.iter_mut().zip(right) {
        *left = each(*left, right);
    }
    left
}

/// Lanes 0 to 3 and 4 to 7.
#[inline]
fn halves(lanes: Lanes) -> [u64; 2] {
    let [l0, l1, l2, l3, l4, l5, l6, l7] = lanes.map(u64::from);
    [l0 | l1 << 16 | l2 << 32 | l3 << 48, l4 | l5 << 16 | l6 << 32 | l7 << 48]
}

#[inline]
const fn odd_bytes(word: u64) -> u64 {
    (word >> 8) & 0x00FF_00FF_00FF_00FF
}

/// Both sums of eight bytes, or of sums of such bytes. A lane is at most 6,553, so that the weighted lanes, which are
/// up to 10 times as much, fit 16 bits.
#[inline]
const fn within(even: u64, odd: u64) -> Raw {
    // The top lane of a product with these is the sum of all lanes, times 1, or times 4, 3, 2, 1.
    const ONCE: u64 = 0x0001_0001_0001_0001;
    const WEIGHTED: u64 = 0x0004_0003_0002_0001;
    let odds = odd.wrapping_mul(ONCE) >> 48;
    let weighted = (even.wrapping_mul(WEIGHTED) >> 48).wrapping_add(odd.wrapping_mul(WEIGHTED) >> 48);
    // Even bytes count 8, 6, 4 and 2 times, odd ones 7, 5, 3 and 1 times.
    Raw {
        f0: (even.wrapping_mul(ONCE) >> 48).wrapping_add(odds) as u32,
        f1: weighted.wrapping_mul(2).wrapping_sub(odds) as u32,
    }
}

/// The four lanes, with any values, added into two lanes of 32 bits.
#[inline]
const fn pairs(lanes: u64) -> u64 {
    const LOW: u64 = 0x0000_FFFF_0000_FFFF;
    (lanes & LOW).wrapping_add((lanes >> 16) & LOW)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_short_code_and_the_fast_code_sum_alike() {
        let bytes: std::vec::Vec<u8> = (0..10_000_u32).map(|at| (at.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        for len in [0, 1, 7, 8, 127, 128, 129, 4095, 4096, 4097, 9999, 10_000] {
            for bytes in [&bytes[..len], &std::vec![255; len]] {
                let [slow, fast] = [one_by_one(bytes), sum(bytes)].map(Raw::modulo_255);
                assert_eq!((slow.f0, slow.f1), (fast.f0, fast.f1), "{len} bytes");
            }
        }
    }
}
