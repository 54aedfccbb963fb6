//! Bytes in pieces become whole frames.
//!
//! A protocol says in a [`Framing`] how its header reads. [`Frames`] does the rest, the same for all
//! protocols: it holds the bytes that wait, finds the frames in them, and hands out every byte exactly
//! once, as part of an [`Item`]. It allocates nothing, and it lends what it finds.
//!
//! Three promises hold for any bytes whatever, however they are cut into pieces:
//!
//! - The items, put end to end, are the stream. Noise that lies side by side may come as one item or
//!   as several; nothing else depends on the cutting.
//! - The frames are those that a search from each byte in turn would find. Noise never costs the frame
//!   behind it.
//! - The work grows with the number of bytes and with nothing else. Nobody can send a stream that is
//!   dear to read.
//!
//! ```
//! use motion_core::stream::{Frames, Framing, Head, Item, Noise};
//!
//! /// A `!`, the length of the text, the text.
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
//!     while !piece.is_empty() {
//!         let taken = frames.push(piece);
//!         piece = &piece[taken..];
//!         while let Some(item) = frames.next() {
//!             match item {
//!                 Item::Frame(frame) => texts.push(frame[2..].to_vec()),
//!                 Item::Noise { bytes, .. } => assert_eq!(bytes, b".."),
//!                 Item::Corrupt { .. } | Item::Fatal(_) => unreachable!("no checksum, no version"),
//!             }
//!         }
//!     }
//! }
//! assert_eq!(texts, [&b"Hello"[..], b"yo"]);
//! ```

mod frames;
#[cfg(feature = "embedded-io")]
mod read;

use core::fmt::Debug;

pub use frames::Frames;

/// How the frames of one protocol are told from the bytes around them.
///
/// The functions are pure and read no more than the header, so their cost does not depend on the
/// frame. A type that implements this holds nothing: it only names the protocol.
pub trait Framing {
    /// Length in bytes of the longest frame that is taken for one, at least that of a header.
    ///
    /// It bounds how long a lying header can make the stream wait.
    const MAX: usize;

    /// What a header says. It is handed out with a corrupt frame, which may have to be answered.
    type Header: Copy + Debug + PartialEq;

    /// A whole frame, lent: header and payload. As bytes it is exactly what arrived.
    type Frame<'a>: Copy + AsRef<[u8]>;

    /// What verification remembers about a buffer of `N` bytes: `()` where frames have no checksum.
    type Memo<const N: usize>: Memo;

    /// Says what can begin at the first of `bytes`, of which there is at least one.
    ///
    /// More bytes may turn [`Head::More`] into any other answer, and change no other one.
    fn head(bytes: &[u8]) -> Head;

    /// Reads the header of a frame whose length [`head`](Self::head) gave.
    fn header(bytes: &[u8]) -> Option<Self::Header>;

    /// Reads a frame: `bytes` is as long as [`head`](Self::head) said, and verified.
    ///
    /// Refused bytes (`None`) become noise.
    fn frame(bytes: &[u8]) -> Option<Self::Frame<'_>>;

    /// How many of `bytes` are given up with a frame that began with the first of them, but does not
    /// verify or was cut off by a gap. The search goes on behind them.
    ///
    /// One, unless said otherwise. A marker can be given up whole where no other one can begin within
    /// it. A protocol without a marker gives up all bytes, since any payload could look like a frame.
    #[must_use]
    fn give_up(bytes: &[u8]) -> usize {
        let _ = bytes;
        1
    }

    /// How many of `bytes` to leave behind when [`Frames::resync`] gives up the first of them.
    ///
    /// Up to the next byte that is not fatal, unless said otherwise.
    #[must_use]
    fn resync(bytes: &[u8]) -> usize {
        (1..bytes.len())
            .find(|&at| bytes.get(at..).is_some_and(|rest| !matches!(Self::head(rest), Head::Fatal(_))))
            .unwrap_or(bytes.len())
    }
}

/// What can begin at a byte, judged from the header alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Head {
    /// Perhaps a frame: this many bytes in all, more than there are, will tell more.
    More(usize),
    /// A frame of this length, which is 1..=[`Framing::MAX`], if it verifies.
    Total(usize),
    /// No frame: this many bytes can be left behind, at least one. They need not all be there yet.
    Skip(usize, Noise),
    /// No frame, and no way to find the next one.
    Fatal(Fatal),
}

/// What a stream is made of: frames `F` with headers `H`, and what lies between them.
///
/// Each item lends exactly the bytes that it takes from the stream. [`Fatal`](Self::Fatal) takes none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Item<'a, F, H> {
    /// A whole, verified frame.
    Frame(F),
    /// The first frame of an episode that does not verify. Later ones are noise, until a good frame
    /// ends the episode: one fault on the line is reported once.
    Corrupt {
        /// What the header says, itself doubtful.
        header: H,
        /// What is wrong.
        why: Corrupt,
        /// What [`Framing::give_up`] gave up, perhaps no more than the marker. The bytes behind it are
        /// searched anew, since the fault may lie in the length, and good frames behind it.
        bytes: &'a [u8],
    },
    /// Bytes outside any frame.
    Noise {
        /// At least one byte.
        bytes: &'a [u8],
        /// Why the first of them begins no frame. The others may have other reasons.
        why: Noise,
    },
    /// The stream cannot go on. Comes again and again, until [`Frames::resync`] or [`Frames::reset`].
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
    /// One more frame does not verify, in an episode that was reported as [`Item::Corrupt`].
    #[error("another frame with a wrong checksum")]
    Checksum,
    /// The line fell silent before the frame was whole.
    #[error("a gap cut the frame off")]
    CutOff,
    /// [`Frames::resync`] left these bytes behind.
    #[error("left behind to find the next frame")]
    Resync,
    /// [`Framing::frame`] refused the whole frame.
    #[error("the whole frame was refused")]
    Refused,
}

/// What is wrong with a corrupt frame.
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
    /// The byte that says the protocol version says another one.
    #[error("protocol version is {found}, should be {expected}")]
    BadVersion {
        /// The byte on the wire.
        found: u8,
        /// The version that is understood.
        expected: u8,
    },
    /// The length of the whole frame does not even cover the header.
    #[error("frame length is {found}, should be at least {least}")]
    BadLength {
        /// Length on the wire in bytes.
        found: usize,
        /// Length of the header in bytes.
        least: usize,
    },
}

/// What verification remembers about the bytes of a buffer, so that no byte is summed again and again.
///
/// Positions count from the start of the buffer. [`Frames`] reports what happens to it.
pub trait Memo {
    /// Nothing remembered.
    const NEW: Self;

    /// Whether `frame`, which is all of one, is sound.
    fn is_sound(frame: &[u8]) -> bool;

    /// Whether the `len` bytes from `at` on are a sound frame. `filled` is the buffer up to its last
    /// byte; `at` never falls, but by what [`shift`](Self::shift) says. The bytes that it passes pay for the work.
    fn verify(&mut self, filled: &[u8], at: usize, len: usize) -> bool;

    /// Takes note that the buffer dropped its first `n` bytes, and moved the others down.
    fn shift(&mut self, n: usize);

    /// How many bytes were read, summed or moved so far.
    fn work(&self) -> usize;
}

/// Nothing to verify, nothing to remember.
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

    #[inline]
    fn work(&self) -> usize {
        0
    }
}
