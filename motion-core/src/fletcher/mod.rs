//! Fletcher-16 as Dragonframe DMC uses it: two running sums, both modulo 255.
//!
//! The first sum, `f0`, adds the bytes. The second, `f1`, adds the first sum after each byte, so it also detects bytes
//! in a wrong order. A sender appends two check bytes that make both sums zero. A receiver sums the whole frame,
//! including the check bytes, and accepts it if both sums are zero.
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
//! Modulo 255, a byte of 0 and a byte of 255 are equal. So check bytes are never compared: a peer may write 0 where
//! [`Sum::check_bytes`] returns 255. Only [`verify`] tells a valid frame from a corrupt one. For the same reason, a 0
//! that was changed to 255 is not detected: this is a weakness of the checksum itself.
//!
//! Source: DMC, Computing and Validating the Checksum.

mod kernels;
mod prefix;

pub use prefix::PrefixSums;

/// The two Fletcher-16 sums of some bytes, each in 0..=254.
///
/// Sums of adjacent pieces are joined by [`then`](Self::then) and separated again by [`after`](Self::after), in
/// constant time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Sum {
    f0: u8,
    f1: u8,
}

impl Sum {
    /// The sum of no bytes, and of every valid frame.
    pub const ZERO: Self = Self { f0: 0, f1: 0 };

    /// The sum of any number of bytes.
    #[inline]
    #[must_use]
    pub fn of(bytes: &[u8]) -> Self {
        kernels::sum(bytes)
    }

    /// The sum of the bytes of `self`, followed by `bytes`.
    ///
    /// The sum of a message does not depend on how it is cut into pieces.
    #[inline]
    #[must_use]
    pub fn update(self, bytes: &[u8]) -> Self {
        self.then(Self::of(bytes), bytes.len())
    }

    /// The sum of two adjacent pieces: the bytes of `self`, followed by the `next_len` bytes of `next`.
    #[inline]
    #[must_use]
    pub const fn then(self, next: Self, next_len: usize) -> Self {
        let (f0, f1) = (self.f0 as u32, self.f1 as u32);
        // Each byte of `next` adds the first sum of `self` to the second sum once more.
        #[expect(clippy::cast_possible_truncation, reason = "below 255")]
        let again = f0.wrapping_mul((next_len % 255) as u32);
        Self::modulo_255(f0.wrapping_add(next.f0 as u32), f1.wrapping_add(next.f1 as u32).wrapping_add(again))
    }

    /// The sum without a prefix: of the last `len` bytes of `self`, if `prefix` is the sum of all bytes before them.
    ///
    /// It reverses a join: `x.then(y, len).after(x, len) == y`. With the sums of all prefixes of a buffer, any range of
    /// the buffer is summed in constant time.
    #[inline]
    #[must_use]
    pub const fn after(self, prefix: Self, len: usize) -> Self {
        // The prefix with its sign changed, modulo 255.
        Self { f0: 255_u8.wrapping_sub(prefix.f0), f1: 255_u8.wrapping_sub(prefix.f1) }.then(self, len)
    }

    /// Whether both sums are zero, as for every valid frame with its check bytes.
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

    /// The two check bytes, in wire order, that make the sum zero if they follow.
    ///
    /// Each is in 1..=255: the specification's formula gives 255 instead of 0.
    #[inline]
    #[must_use]
    pub const fn check_bytes(self) -> [u8; 2] {
        // The specification's c1 = 255 - (f0 + c0) mod 255 equals f1, with 255 for 0.
        let c1 = if self.f1 == 0 { 255 } else { self.f1 };
        [255_u8.wrapping_sub(((self.f0 as u32).wrapping_add(self.f1 as u32) % 255) as u8), c1]
    }

    const fn modulo_255(f0: u32, f1: u32) -> Self {
        Self { f0: (f0 % 255) as u8, f1: (f1 % 255) as u8 }
    }
}

/// Whether a whole frame, including its check bytes, sums to zero.
///
/// If the length of the frame is known at compile time, the code has no loops.
#[inline]
#[must_use]
pub fn verify(frame: &[u8]) -> bool {
    kernels::is_zero(frame)
}

/// Check bytes of a frame whose first bytes are known before they are written.
///
/// `head` are these bytes, with zero bytes in front to fill 16 bytes, and `body` are the bytes that follow. The result is
/// that of [`Sum::check_bytes`]. A processor waits when it reads bytes that it has just written with several
/// instructions, so it is faster not to read the head.
#[inline]
#[must_use]
pub fn check_bytes(head: [[u8; 8]; 2], body: &[u8]) -> [u8; 2] {
    kernels::check_bytes(head, body)
}
