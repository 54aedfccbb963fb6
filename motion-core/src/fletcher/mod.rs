//! Fletcher-16 as Dragonframe DMC uses it: two running sums, both modulo 255.
//!
//! The first sum, `f0`, adds the bytes. The second, `f1`, adds the first sum after each byte, so it
//! also notices bytes that changed places. A sender appends two check bytes that bring both sums to
//! zero. A receiver sums the whole frame, check bytes included, and accepts it when both sums are
//! zero.
//!
//! ```
//! use motion_core::fletcher::{Sum, verify};
//!
//! let mut frame = *b"DF: any bytes at all..";
//! let [body @ .., c0, c1] = &mut frame;
//! [*c0, *c1] = Sum::of(body).check_bytes();
//! assert!(verify(&frame));
//!
//! frame[5] ^= 1;
//! assert!(!verify(&frame));
//! ```
//!
//! Modulo 255 a byte of 0 and a byte of 255 weigh the same. Check bytes are therefore never compared:
//! a peer may write 0 where [`Sum::check_bytes`] gives 255. Only [`verify`] tells a sound frame from
//! a corrupt one. For the same reason a 0 that turned into a 255 stays undetected: that is a weakness
//! of the checksum itself.
//!
//! Source: DMC, Computing and Validating the Checksum.

mod kernels;
mod prefix;

use kernels::Raw;
pub use prefix::PrefixSums;

/// The two sums of some bytes, each reduced to 0..=254.
///
/// Sums of neighbouring pieces are joined in constant time by [`then`](Self::then) and taken apart
/// again by [`after`](Self::after).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Sum {
    f0: u8,
    f1: u8,
}

impl Sum {
    /// The sum of no bytes, and of every sound frame.
    pub const ZERO: Self = Self { f0: 0, f1: 0 };

    /// Sums `bytes`, however many they are.
    #[inline]
    #[must_use]
    pub fn of(bytes: &[u8]) -> Self {
        Self::modulo_255(kernels::sum(bytes))
    }

    /// Sums what `self` has summed, followed by `bytes`.
    ///
    /// Any cutting of a message into pieces gives the sum of the whole.
    #[inline]
    #[must_use]
    pub fn update(self, bytes: &[u8]) -> Self {
        self.then(Self::of(bytes), bytes.len())
    }

    /// Joins neighbours: what `self` has summed, followed by the `next_len` bytes that `next` has
    /// summed.
    #[inline]
    #[must_use]
    pub const fn then(self, next: Self, next_len: usize) -> Self {
        Self::modulo_255(self.raw().then(next.raw(), next_len))
    }

    /// Takes a prefix off: the sum of the last `len` bytes of what `self` has summed, where `prefix`
    /// is the sum of everything before them.
    ///
    /// It undoes a join: `x.then(y, len).after(x, len) == y`. With the sums of all prefixes of a
    /// buffer at hand, any range of it is summed in constant time.
    #[inline]
    #[must_use]
    pub const fn after(self, prefix: Self, len: usize) -> Self {
        // The prefix with its sign turned, modulo 255.
        let Raw { f0, f1 } = prefix.raw();
        let negated = Raw { f0: 255_u32.wrapping_sub(f0), f1: 255_u32.wrapping_sub(f1) };
        Self::modulo_255(negated.then(self.raw(), len))
    }

    /// Whether both sums are zero, as they are over a whole sound frame.
    #[inline]
    #[must_use]
    pub const fn is_zero(self) -> bool {
        self.f0 == 0 && self.f1 == 0
    }

    /// The checksum as the specification packs it: the second sum in the high byte, the first in the
    /// low byte.
    #[inline]
    #[must_use]
    pub const fn value(self) -> u16 {
        u16::from_le_bytes([self.f0, self.f1])
    }

    /// The two bytes, in wire order, that bring the sum to zero when they follow.
    ///
    /// Each is in 1..=255: where a 0 would do, the specification's formula gives 255.
    #[inline]
    #[must_use]
    pub const fn check_bytes(self) -> [u8; 2] {
        // The specification's c1 = 255 - (f0 + c0) mod 255 comes down to f1, with 255 for 0.
        let c1 = if self.f1 == 0 { 255 } else { self.f1 };
        let Raw { f0, f1 } = self.raw();
        [255_u8.wrapping_sub((f0.wrapping_add(f1) % 255) as u8), c1]
    }

    const fn raw(self) -> Raw {
        Raw { f0: self.f0 as u32, f1: self.f1 as u32 }
    }

    const fn modulo_255(raw: Raw) -> Self {
        Self { f0: (raw.f0 % 255) as u8, f1: (raw.f1 % 255) as u8 }
    }
}

/// Whether a whole frame, check bytes included, sums to zero.
#[inline]
#[must_use]
pub fn verify(frame: &[u8]) -> bool {
    Sum::of(frame).is_zero()
}

/// [`verify`] for a frame whose length is known when the program is compiled: straight-line code.
#[inline]
#[must_use]
pub fn verify_array<const N: usize>(frame: &[u8; N]) -> bool {
    verify(frame)
}
