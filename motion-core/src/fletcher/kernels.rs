//! Loops that add bytes, and the bounds that keep their sums from overflowing.
//!
//! All numbers here are sums modulo 255, and most of them are not reduced: 256 is 1 modulo 255, and so are 2^16, 2^32 and
//! 2^64. So eight bytes, read as one little-endian number, equal the sum of these bytes, and four lanes of 16 bits in one
//! number equal the sum of the lanes. Nothing is added across lanes, and only the end of a loop needs a modulo operation.
//! [`verify`](super::verify) needs none at all: whether a number is a multiple of 255 is one multiplication.
//!
//! The second sum counts a byte once more for each byte that follows. In a word of eight bytes, the number of bytes that
//! follow is 7 to 0, and each bit of that number is one mask: see [`Words::sums`].
//!
//! If the length of a message is not a multiple of a word, the short word comes first and is filled with zero bytes in
//! front: zero bytes in front of a message change neither sum.

use super::Sum;

/// Both sums of any number of bytes. In firmware the code has to be short, because it has to be stored.
#[inline]
pub(super) fn sum(bytes: &[u8]) -> Sum {
    if cfg!(target_os = "none") { one_by_one(bytes) } else { raw(bytes).sum() }
}

/// Whether both sums are zero.
#[inline]
pub(super) fn is_zero(bytes: &[u8]) -> bool {
    if cfg!(target_os = "none") { one_by_one(bytes).is_zero() } else { raw(bytes).is_zero() }
}

/// Check bytes of a head and the body that follows.
#[inline]
pub(super) fn check_bytes(head: [[u8; 8]; 2], body: &[u8]) -> [u8; 2] {
    // The numbers of a longer body could be too great for 64 bits.
    if cfg!(target_os = "none") || body.len() > MOST {
        return Sum::of(head.as_flattened()).update(body).check_bytes();
    }
    let mut words = Words::default();
    for word in head {
        words.add(u64::from_le_bytes(word));
    }
    after(words.sums(), body).check_bytes()
}

/// Sums any number of bytes, in blocks of 4096 bytes. Then a first sum is at most 255 * 4096 + 254, and a second sum is at
/// most 255 * 4096 * 4097 / 2 + 254 * 4097, which is less than half of what 32 bits hold.
#[inline(never)]
fn one_by_one(bytes: &[u8]) -> Sum {
    bytes.chunks(4096).fold(Sum::ZERO, |sum, block| {
        let (mut f0, mut f1) = (u32::from(sum.f0), u32::from(sum.f1));
        for &byte in block {
            f0 = f0.wrapping_add(byte.into());
            f1 = f1.wrapping_add(f0);
        }
        Sum { f0: (f0 % 255) as u8, f1: (f1 % 255) as u8 }
    })
}

/// Two numbers that equal the two sums modulo 255. Both are less than 255 * 2^56.
#[derive(Clone, Copy)]
struct Raw {
    f0: u64,
    f1: u64,
}

impl Raw {
    #[inline]
    const fn sum(self) -> Sum {
        Sum { f0: (self.f0 % 255) as u8, f1: (self.f1 % 255) as u8 }
    }

    /// [`Sum::check_bytes`], with two divisions instead of three.
    #[inline]
    const fn check_bytes(self) -> [u8; 2] {
        let Self { f0, f1 } = self.folded();
        // All ones are zero modulo 255, so that `!f1` is -f1.
        [255_u8.wrapping_sub((f0.wrapping_add(f1) % 255) as u8), 255_u8.wrapping_sub((!f1 % 255) as u8)]
    }

    /// Whether both are multiples of 255.
    ///
    /// The product with the inverse of 255 is the quotient of a multiple, here less than 2^56. It is a different number
    /// for each factor, so it is more than any quotient for every other number. Two divisions by 255 take twice as many
    /// instructions.
    #[inline]
    const fn is_zero(self) -> bool {
        const INVERSE: u64 = (u64::MAX / 255).wrapping_neg();
        (self.f0.wrapping_mul(INVERSE) | self.f1.wrapping_mul(INVERSE)) >> 56 == 0
    }

    /// The sums of the bytes of `self`, followed by the `len` bytes of `next`, if the numbers are small enough.
    #[inline]
    const fn then(self, next: Self, len: usize) -> Self {
        Self {
            f0: self.f0.wrapping_add(next.f0),
            f1: self.f1.wrapping_add(next.f1).wrapping_add(self.f0.wrapping_mul(len as u64)),
        }
    }

    /// Equal numbers of at most 33 bits.
    #[inline]
    const fn folded(self) -> Self {
        Self { f0: fold(self.f0), f1: fold(self.f1) }
    }
}

/// An equal number of at most 33 bits.
#[inline]
const fn fold(number: u64) -> u64 {
    (number & 0xFFFF_FFFF).wrapping_add(number >> 32)
}

/// Sums words, while the frames that control a motor are straight-line code in their callers: up to 24 bytes. A loop in
/// their place takes 1.3 times as long.
#[inline]
fn raw(bytes: &[u8]) -> Raw {
    if bytes.len().wrapping_sub(9) > FEW - 9 {
        return rest(bytes);
    }
    let (Some(first), Some((front, last))) = (bytes.first_chunk(), bytes.split_last_chunk()) else {
        return rest(bytes);
    };
    let mut words = Words::default();
    // The shift is modulo 64. It fills the first of 1 to 8 bytes up.
    words.add(u64::from_le_bytes(*first) << (bytes.len().wrapping_neg().wrapping_mul(8) % 64));
    if bytes.len() > 16 {
        if bytes.len() <= 24 {
            words.add(front.last_chunk().map_or(0, |word| u64::from_le_bytes(*word)));
        } else {
            let begin = (bytes.len().wrapping_sub(1) % 8).wrapping_add(1);
            for word in front.get(begin..).unwrap_or_default().chunks_exact(8) {
                words.add(little_endian(word));
            }
        }
    }
    words.add(u64::from_le_bytes(*last));
    words.sums()
}

/// Sums what [`raw`] does not.
#[inline(never)]
fn rest(bytes: &[u8]) -> Raw {
    if bytes.len() < 9 {
        tiny(bytes)
    } else if bytes.len() < LONG {
        rows(bytes)
    } else {
        long(bytes)
    }
}

/// The sums of two words, followed by bytes that were just written.
///
/// A processor waits before it reads bytes with one instruction that were written with several: a frame of 19 bytes takes
/// 3 ns less without such reads, with more instructions. So the first bytes, which are fields, are read one by one. The
/// others are whole rows of a list that was copied.
#[inline(never)]
fn after(before: Raw, bytes: &[u8]) -> Raw {
    // With three words more, no lane of the second sum is more than 58,905.
    if bytes.len() < 24 {
        return before.then(tiny(bytes), bytes.len());
    }
    let (odd, rows) = bytes.split_at_checked(bytes.len() % 16).unwrap_or_default();
    let rows_sum = if rows.len() > FEW && rows.len() < LONG { few_rows(rows) } else { raw(rows) };
    before.then(tiny(odd), odd.len()).folded().then(rows_sum, rows.len())
}

/// Sums fewer than 24 bytes, the first ones one by one.
#[inline]
fn tiny(bytes: &[u8]) -> Raw {
    let (odd, rest) = bytes.split_at_checked(bytes.len() % 8).unwrap_or_default();
    let mut words = Words::default();
    words.add(odd.iter().fold(0, |word, &byte| (word >> 8) | (u64::from(byte) << 56)));
    for word in rest.chunks_exact(8) {
        words.add(little_endian(word));
    }
    words.sums()
}

/// Number of bytes up to which words are faster than rows. It is also the most that [`Words`] holds.
const FEW: usize = 40;
/// Number of bytes from which on [`long`] is needed, because a row more than seven would not fit the lanes of [`rows`].
const LONG: usize = 128;
/// Number of bytes that [`long`] sums without a modulo operation.
const MOST: usize = 1 << 16;

const EVEN: u64 = 0x00FF_00FF_00FF_00FF;
/// Lanes 0 and 2 of four lanes of 16 bits.
const LANES_0_2: u64 = 0x0000_FFFF_0000_FFFF;

/// Sums of words of eight bytes, in four lanes of 16 bits.
///
/// They hold five words. Then a lane of `before` is at most 510 * (0 + 1 + 2 + 3 + 4) = 5,100, and no lane of the second sum
/// is more than 59,925, which is less than 255 * 2^8.
#[derive(Clone, Copy, Default)]
struct Words {
    /// Even bytes plus odd bytes.
    all: u64,
    even: u64,
    /// Second sum of `all`, which adds up `all` before each word.
    before: u64,
}

impl Words {
    #[inline]
    fn add(&mut self, word: u64) {
        let even = word & EVEN;
        self.before = self.before.wrapping_add(self.all);
        self.all = self.all.wrapping_add(even).wrapping_add((word >> 8) & EVEN);
        self.even = self.even.wrapping_add(even);
    }

    /// Both sums. A byte counts once for itself, eight times for each word that follows, and once for each byte that
    /// follows in its word: four times in the low half, twice in lanes 0 and 2, once at even places.
    #[inline]
    const fn sums(self) -> Raw {
        let Self { all, even, before } = self;
        let within =
            (all & 0xFFFF_FFFF).wrapping_mul(4).wrapping_add((all & LANES_0_2).wrapping_mul(2)).wrapping_add(even);
        Raw { f0: all, f1: before.wrapping_mul(8).wrapping_add(within).wrapping_add(all) }
    }
}

/// Sums the first `len` bytes, fewer than 16, of a longer message.
#[inline]
fn head(bytes: &[u8], len: usize) -> Raw {
    if len == 0 {
        return Raw { f0: 0, f1: 0 };
    }
    let begin = len % 8;
    let mut words = Words::default();
    // Two shifts, because one shift by all 64 bits would be no shift.
    words.add(little_endian(bytes) << 56_usize.wrapping_sub(begin.wrapping_mul(8)) << 8);
    if len >= 8 {
        words.add(little_endian(bytes.get(begin..).unwrap_or_default()));
    }
    words.sums()
}

/// Sums more than [`FEW`] bytes, and fewer than [`LONG`]: a head of 0 to 15 bytes, and at most seven rows of 16 bytes.
///
/// Then a lane of a second sum is at most 255 * (0 + .. + 6) = 5,355, so that four of them fit one lane.
#[inline(never)]
fn rows(bytes: &[u8]) -> Raw {
    let (odd, rows) = bytes.split_at_checked(bytes.len() % 16).unwrap_or_default();
    let rows_sum = few_rows(rows);
    if odd.is_empty() { rows_sum } else { head(bytes, odd.len()).folded().then(rows_sum, rows.len()) }
}

/// Sums at most seven rows of 16 bytes.
#[inline]
fn few_rows(rows: &[u8]) -> Raw {
    Columns::of(rows).words(|[b0, b1, b2, b3], first| {
        fold(b0.wrapping_add(b1).wrapping_add(b2).wrapping_add(b3).wrapping_mul(2).wrapping_add(first))
    })
}

/// Sums [`LONG`] bytes or more, in blocks of 23 rows of 16 bytes.
#[inline(never)]
fn long(bytes: &[u8]) -> Raw {
    if bytes.len() > MOST {
        let sum = bytes.chunks(MOST).fold(Sum::ZERO, |sum, piece| sum.then(raw(piece).sum(), piece.len()));
        return Raw { f0: sum.f0.into(), f1: sum.f1.into() };
    }
    let (odd, rows) = bytes.split_at_checked(bytes.len() % 16).unwrap_or_default();
    rows.chunks(16 * 23).fold(head(bytes, odd.len()).folded(), |sum, block| {
        let block_sum = Columns::of(block).words(|seconds, first| {
            seconds
                .into_iter()
                .fold(0, |sum: u64, second| sum.wrapping_add(fold(second)))
                .wrapping_mul(2)
                .wrapping_add(fold(first))
        });
        sum.then(block_sum.folded(), block.len())
    })
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

    /// Both sums of all bytes. `before` adds up the second sums, and the sums of the first words of all rows, as often as
    /// words follow: two words for each row, and one in its own row.
    #[inline]
    fn words(&self, before: impl FnOnce([u64; 4], u64) -> u64) -> Raw {
        let ([e0, e1], [o0, o1]) = (halves(self.even), halves(self.odd));
        let first = e0.wrapping_add(o0);
        let all = first.wrapping_add(e1).wrapping_add(o1);
        let ([b0, b1], [b2, b3]) = (halves(self.evens), halves(self.odds));
        Words { all, even: e0.wrapping_add(e1), before: before([b0, b1, b2, b3], first) }.sums()
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

/// Number in the first eight bytes; 0 if there are fewer.
#[inline]
fn little_endian(bytes: &[u8]) -> u64 {
    bytes.first_chunk().map_or(0, |word| u64::from_le_bytes(*word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_short_code_and_the_fast_code_sum_alike() {
        let bytes: std::vec::Vec<u8> = (0..10_000_u32).map(|at| (at.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        for len in [0, 1, 7, 8, 127, 128, 129, 4095, 4096, 4097, 9999, 10_000] {
            for bytes in [&bytes[..len], &std::vec![255; len]] {
                assert_eq!(one_by_one(bytes), raw(bytes).sum(), "{len} bytes");
            }
        }
    }
}
