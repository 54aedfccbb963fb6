//! Whole frames from bytes that arrive in pieces.
//!
//! A protocol implements [`Framing`], which says how to read its header. [`Frames`] does the rest, the same for all
//! protocols: it holds the bytes that arrived, finds the frames in them, and returns every byte exactly once, as part
//! of an [`Item`]. It allocates nothing, and items borrow from its buffer.
//!
//! Three guarantees hold for any bytes, in pieces of any size:
//!
//! - The bytes of all items, in order, are the stream. Adjacent noise may be one item or several; nothing else depends
//!   on the pieces.
//! - The frames are the same as in a search from each byte in turn. A frame after noise is always found.
//! - The work for each byte is bounded by a constant, whatever is sent.
//!
//! ```
//! use motion_core::stream::{Frames, Framing, Head, Item, Noise};
//!
//! /// A protocol whose frames are a `!`, the length of a text, and the text.
//! enum Shout {}
//!
//! impl Framing for Shout {
//!     const MAX: usize = 2 + 20;
//!     type Header = ();
//!     type Frame<'a> = &'a [u8];
//!     type Memo<const N: usize> = ();
//!
//!     fn head(bytes: &[u8]) -> Head {
//!         match bytes {
//!             [b'!', len @ 0..=20, ..] => Head::Total(2 + usize::from(*len)),
//!             [b'!'] => Head::More(2),
//!             _ => Head::Skip(1, Noise::NoMarker),
//!         }
//!     }
//!     fn header(_: &[u8]) -> Option<()> {
//!         Some(())
//!     }
//!     fn frame(bytes: &[u8]) -> Option<&[u8]> {
//!         Some(bytes)
//!     }
//! }
//!
//! let mut frames = Frames::<Shout, 64>::new();
//! let mut texts = Vec::new();
//! for mut piece in [&b"..!\x05He"[..], b"llo!", b"\x02yo"] {
//!     while let Some(item) = frames.next_from(&mut piece) {
//!         match item {
//!             Item::Frame(frame) => texts.push(frame[2..].to_vec()),
//!             Item::Noise { bytes, .. } => assert_eq!(bytes, b".."),
//!             Item::Corrupt { .. } | Item::Fatal(_) => unreachable!("it has no checksum and no version"),
//!         }
//!     }
//! }
//! assert_eq!(texts, [&b"Hello"[..], b"yo"]);
//! ```

mod frames;
#[cfg(feature = "embedded-io")]
mod read;
mod timed;

use core::fmt::Debug;

pub use frames::Frames;
pub use timed::{Patience, TimedFrames};

/// Framing of one protocol: how to tell its frames from the bytes around them.
///
/// The functions are pure and read only the header, so their cost does not depend on the length of the frame. A type
/// that implements this trait holds no data; it only names the protocol.
pub trait Framing {
    /// Length in bytes of the longest frame that is accepted, at least the length of a header.
    ///
    /// It limits how many bytes the stream waits for after a header with a wrong length.
    const MAX: usize;

    /// Contents of a header. It is returned with a corrupt frame, because a receiver may have to answer it.
    type Header: Copy + Debug + PartialEq;

    /// A whole frame, header and payload, borrowed from the buffer. Its bytes are exactly those that arrived.
    type Frame<'a>: Copy + AsRef<[u8]>;

    /// Memory of the verification about a buffer of `N` bytes; `()` if frames have no checksum.
    type Memo<const N: usize>: Memo;

    /// Judges what can begin at the first of `bytes`, which are not empty.
    ///
    /// With more bytes, [`Head::More`] may become any other answer; no other answer may change.
    fn head(bytes: &[u8]) -> Head;

    /// Reads the header of a frame whose length [`head`](Self::head) returned.
    fn header(bytes: &[u8]) -> Option<Self::Header>;

    /// Reads a verified frame; `bytes` has the length that [`head`](Self::head) returned.
    ///
    /// If it returns `None`, the bytes become noise.
    fn frame(bytes: &[u8]) -> Option<Self::Frame<'_>>;

    /// Number of bytes to give up if a frame begins at the first of `bytes`, but does not verify or is cut off by a
    /// gap. The search continues after them.
    ///
    /// The default is 1. A whole marker can be given up if no other marker can begin within it. A protocol without a
    /// marker gives up all bytes, because any payload could look like a frame.
    #[must_use]
    fn give_up(bytes: &[u8]) -> usize {
        let _ = bytes;
        1
    }

    /// Number of bytes to skip when [`Frames::resync`] gives up the first of `bytes`.
    ///
    /// The default is up to the next byte at which [`head`](Self::head) is not fatal.
    #[must_use]
    fn resync(bytes: &[u8]) -> usize {
        (1..bytes.len())
            .find(|&at| bytes.get(at..).is_some_and(|rest| !matches!(Self::head(rest), Head::Fatal(_))))
            .unwrap_or(bytes.len())
    }
}

/// Judgement of what can begin at a byte, from the header alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Head {
    /// Perhaps a frame. The judgement needs this many bytes in all, which are more than there are.
    More(usize),
    /// A frame of this length in bytes, which is 1..=[`Framing::MAX`], if it verifies.
    Total(usize),
    /// No frame. This many bytes can be skipped, at least one; some of them may not have arrived yet.
    Skip(usize, Noise),
    /// No frame, and the next frame cannot be found.
    Fatal(Fatal),
}

/// Item of a stream: a frame `F`, a corrupt frame with its header `H`, bytes between frames, or a fatal error.
///
/// Each item borrows exactly the bytes that it takes from the stream. [`Fatal`](Self::Fatal) takes no bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Item<'a, F, H> {
    /// A whole, verified frame.
    Frame(F),
    /// The first frame of an episode that does not verify. Later ones are noise, until a valid frame ends the episode.
    /// So one fault on the line is reported once.
    Corrupt {
        /// The header, which may be damaged as well.
        header: H,
        /// Why the frame is corrupt.
        why: Corrupt,
        /// The bytes that [`Framing::give_up`] gave up, perhaps only the marker. The bytes after them are searched
        /// again, because the fault may be in the length, and valid frames may follow.
        bytes: &'a [u8],
    },
    /// Bytes outside any frame.
    Noise {
        /// The bytes, at least one.
        bytes: &'a [u8],
        /// Why no frame begins at the first of them. The others may have other reasons.
        why: Noise,
    },
    /// An error after which the stream cannot go on. It is returned again until [`Frames::resync`] or
    /// [`Frames::reset`].
    Fatal(Fatal),
}

impl<F: AsRef<[u8]>, H> Item<'_, F, H> {
    /// The bytes that the item takes from the stream.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        match self {
            Self::Frame(frame) => frame.as_ref(),
            Self::Corrupt { bytes, .. } | Self::Noise { bytes, .. } => bytes,
            Self::Fatal(_) => &[],
        }
    }
}

/// Why bytes are noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum Noise {
    /// No frame begins with these bytes.
    #[error("no frame begins here")]
    NoMarker,
    /// The header claims more bytes than [`Framing::MAX`].
    #[error("a frame of {total} bytes is longer than the limit of {max}")]
    TooLong {
        /// Claimed length of the whole frame in bytes.
        total: usize,
        /// Length in bytes of the longest frame that is accepted.
        max: usize,
    },
    /// Another frame does not verify, in an episode that was reported as [`Item::Corrupt`].
    #[error("another frame with a wrong checksum")]
    Checksum,
    /// The line fell silent before the frame was whole.
    #[error("a gap cut off the frame")]
    CutOff,
    /// [`Frames::resync`] skipped these bytes.
    #[error("skipped to find the next frame")]
    Resync,
    /// [`Framing::frame`] refused the whole frame.
    #[error("the whole frame was refused")]
    Refused,
}

/// Why a frame is corrupt.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum Corrupt {
    /// The checksum does not fit the bytes.
    #[error("wrong checksum over {len} bytes")]
    Checksum {
        /// Length of the whole frame in bytes, as its header claims.
        len: usize,
    },
}

/// Why a stream cannot go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum Fatal {
    /// The byte of the protocol version has an unknown value.
    #[error("protocol version is {found}, should be {expected}")]
    BadVersion {
        /// The version byte on the wire.
        found: u8,
        /// The version that is supported.
        expected: u8,
    },
    /// The length of the whole frame is shorter than the header.
    #[error("frame length is {found}, should be at least {least}")]
    BadLength {
        /// Length of the whole frame in bytes, as its header claims.
        found: usize,
        /// Length of the header in bytes.
        least: usize,
    },
}

/// Memory of the verification about the bytes of a buffer, so that no byte is summed many times.
///
/// Positions count from the start of the buffer. [`Frames`] reports each change of the buffer.
pub trait Memo {
    /// An empty memory.
    const NEW: Self;

    /// Whether a whole frame is valid.
    fn is_sound(frame: &[u8]) -> bool;

    /// Whether the `len` bytes from `at` on are a valid frame. `filled` is the buffer up to its last byte. `at` never
    /// decreases, except by the bytes that [`shift`](Self::shift) reports. The work is bounded by the number of bytes
    /// that `at` has passed.
    fn verify(&mut self, filled: &[u8], at: usize, len: usize) -> bool;

    /// Reports that the buffer dropped its first `n` bytes and moved the others to its start.
    fn shift(&mut self, n: usize);

    /// Number of bytes that were read, summed or moved so far, for tests; it wraps around.
    #[doc(hidden)]
    fn work(&self) -> usize {
        0
    }
}

/// No memory, for frames without a checksum.
impl Memo for () {
    const NEW: Self = ();

    #[inline]
    fn is_sound(_: &[u8]) -> bool {
        true
    }

    #[inline]
    fn verify(&mut self, _: &[u8], _: usize, _: usize) -> bool {
        true
    }

    #[inline]
    fn shift(&mut self, _: usize) {}
}
