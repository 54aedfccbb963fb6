//! The loops that add bytes, and the bounds that keep their accumulators from overflowing.
//!
//! All defer the modulo, and all take an odd remainder from the front: zero bytes before a message
//! change neither sum, so there the remainder can be padded.

/// Both sums of some bytes, before the modulo.
#[derive(Clone, Copy, Default)]
pub(super) struct Raw {
    pub(super) f0: u32,
    pub(super) f1: u32,
}

impl Raw {
    /// The sums of `self`'s bytes followed by `next`'s, which are `len` in number.
    #[inline]
    pub(super) const fn then(self, next: Self, len: u32) -> Self {
        Self {
            f0: self.f0.wrapping_add(next.f0),
            f1: self.f1.wrapping_add(next.f1).wrapping_add(self.f0.wrapping_mul(len)),
        }
    }

    /// The same sums, modulo 255.
    #[inline]
    pub(super) const fn reduce(self) -> Self {
        Self { f0: self.f0 % 255, f1: self.f1 % 255 }
    }
}

/// Up to this many bytes words win, above it lanes.
const SHORT: usize = 16 * size_of::<u64>();

/// Sums any number of bytes.
#[inline]
pub(super) fn sum(bytes: &[u8]) -> Raw {
    if bytes.len() <= SHORT { words(bytes) } else { blocks(bytes) }
}

/// Sums at most [`SHORT`] bytes, eight at a time.
#[inline]
fn words(bytes: &[u8]) -> Raw {
    const LOW: u64 = 0x00FF_00FF_00FF_00FF;
    const SUM: u64 = 0x0001_0001_0001_0001;
    const WEIGHTED: u64 = 0x0004_0003_0002_0001;

    let (mut a0, mut a1, mut b) = (0_u64, 0_u64, 0_u64);
    let head = bytes.len() % 8;
    let first = padded(bytes, head);
    a0 = first & LOW;
    a1 = (first >> 8) & LOW;
    for word in bytes.get(head..).unwrap_or_default().chunks_exact(8) {
        let word = word.first_chunk().map_or(0, |w| u64::from_le_bytes(*w));
        b = b.wrapping_add(a0).wrapping_add(a1);
        a0 = a0.wrapping_add(word & LOW);
        a1 = a1.wrapping_add((word >> 8) & LOW);
    }
    let total = |lanes: u64| lanes.wrapping_mul(SUM) >> 48;
    let weighted = |lanes: u64| lanes.wrapping_mul(WEIGHTED) >> 48;
    let bs = (b & 0x0000_FFFF_0000_FFFF) + ((b >> 16) & 0x0000_FFFF_0000_FFFF);
    let bs = (bs + (bs >> 32)) & 0xFFFF_FFFF;
    let (s0, s1) = (total(a0), total(a1));
    Raw { f0: (s0 + s1) as u32, f1: (8 * bs + 2 * (weighted(a0) + weighted(a1)) - s1) as u32 }
}

#[inline]
fn padded(bytes: &[u8], len: usize) -> u64 {
    if let Some(first) = bytes.first_chunk::<8>() {
        (u64::from_le_bytes(*first) << (56 - 8 * len)) << 8
    } else {
        bytes.iter().fold(0, |word, &byte| (word >> 8) | (u64::from(byte) << 56))
    }
}

const LANES: usize = 64;
const ROUNDS: usize = 23;

fn blocks(bytes: &[u8]) -> Raw {
    let (head, rest) = bytes.split_at_checked(bytes.len() % LANES).unwrap_or_default();
    let mut sum = words(head);
    for block in rest.chunks(LANES * ROUNDS) {
        sum = sum.then(lanes(block), block.len() as u32).reduce();
    }
    sum
}

fn lanes(block: &[u8]) -> Raw {
    let mut a = [0_u16; LANES];
    let mut b = [0_u16; LANES];
    for chunk in block.chunks_exact(LANES) {
        for ((a, b), &byte) in a.iter_mut().zip(&mut b).zip(chunk) {
            *b = b.wrapping_add(*a);
            *a = a.wrapping_add(u16::from(byte));
        }
    }
    let mut raw = Raw::default();
    for (weight, (&a, &b)) in (1..).zip(a.iter().zip(&b).rev()) {
        raw.f0 = raw.f0.wrapping_add(u32::from(a));
        raw.f1 += u32::from(b) * LANES as u32 + weight * u32::from(a);
    }
    raw
}
