//! Frames as a `tokio_util` codec. The feature `tokio` adds the dependencies `bytes` and `tokio-util`; the latter
//! brings tokio without its runtime and needs the standard library.
//!
//! ```
//! # use motion_core::stream::{Framing, Head, Noise};
//! # enum Pair {}
//! # impl Framing for Pair {
//! #     const MAX: usize = 2;
//! #     type Header = ();
//! #     type Frame<'a> = &'a [u8];
//! #     type Memo<const N: usize> = ();
//! #     fn head(bytes: &[u8]) -> Head {
//! #         if bytes[0] == b'!' { Head::Total(2) } else { Head::Skip(1, Noise::NoMarker) }
//! #     }
//! #     fn header(_: &[u8]) -> Option<()> { Some(()) }
//! #     fn frame(bytes: &[u8]) -> Option<&[u8]> { Some(bytes) }
//! # }
//! use bytes::BytesMut;
//! use motion_core::codec::{Codec, Item};
//! use tokio_util::codec::{Decoder, Encoder};
//!
//! // A frame of `Pair` is a `!` and one byte. A `Framed` calls `decode` and `encode` like this.
//! let mut codec = Codec::<Pair, 4>::new();
//! let mut received = BytesMut::from("!a..!");
//! assert_eq!(codec.decode(&mut received)?, Some(Item::Frame("!a".into())));
//! assert!(matches!(codec.decode(&mut received)?, Some(Item::Noise { bytes, .. }) if bytes == ".."));
//! assert_eq!(codec.decode(&mut received)?, None);
//! received.extend_from_slice(b"b");
//! assert_eq!(codec.decode(&mut received)?, Some(Item::Frame("!b".into())));
//!
//! let mut to_send = BytesMut::new();
//! codec.encode(b"!c", &mut to_send)?;
//! assert!(codec.encode(b"!cd", &mut to_send).is_err(), "more than one frame");
//! assert_eq!(to_send, "!c");
//! # Ok::<(), std::io::Error>(())
//! ```

use std::boxed::Box;
use std::io;

use bytes::{Bytes, BytesMut};
use tokio_util::codec::{Decoder, Encoder};

use crate::stream::{self, Corrupt, Fatal, Frames, Framing, Head, Noise};

/// Codec that finds the frames of a protocol in a byte stream, and writes whole frames into one.
///
/// It finds frames with a [`Frames`] of `N` bytes, which is at least twice [`Framing::MAX`], and keeps all promises of
/// `Frames`. The bytes of the items are not copied: they are split off the receive buffer. So only the codec may change
/// that buffer until the stream ends. If anything else changes it, [`reset`](Self::reset) the codec.
///
/// Only a fatal error ends the stream, and only if the caller ignores it: when the codec is called again without a
/// [`resync`](Self::resync) or a [`reset`](Self::reset), it returns that error as an [`io::Error`]. At the end of the
/// stream, an incomplete frame is given up, as after a gap.
#[derive(Debug)]
pub struct Codec<F: Framing, const N: usize> {
    frames: Box<Frames<F, N>>,
    /// Whether the last item was a fatal error.
    stuck: bool,
}

/// Item of a stream that owns its bytes: a [`stream::Item`] that outlives the buffer.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Item<H> {
    /// A whole, verified frame; [`Framing::frame`] reads it without verifying it again.
    Frame(Bytes),
    /// The first frame of an episode whose checksum is wrong.
    Corrupt {
        /// The header, which may be damaged as well.
        header: H,
        /// Why the frame is corrupt.
        why: Corrupt,
        /// The bytes that are given up with it, perhaps only the marker.
        bytes: Bytes,
    },
    /// Bytes outside any frame.
    Noise {
        /// The bytes, at least one.
        bytes: Bytes,
        /// Why no frame begins at the first of them.
        why: Noise,
    },
    /// An error after which the stream cannot go on, except after a [`resync`](Codec::resync).
    Fatal(Fatal),
}

impl<F: Framing, const N: usize> Codec<F, N> {
    /// A codec at the start of a stream. It allocates its buffer of `N` bytes.
    #[must_use]
    pub fn new() -> Self {
        Self { frames: Box::default(), stuck: false }
    }

    /// Reports that the line fell silent, as [`Frames::gap`] does: an incomplete frame stays incomplete.
    ///
    /// Call it when `decode` has returned `None`. A `Framed` decodes again when more bytes arrive; the bytes that were
    /// given up come first then.
    pub fn gap(&mut self) {
        self.frames.gap();
    }

    /// Skips what caused a fatal error, as [`Frames::resync`] does.
    pub fn resync(&mut self) {
        self.frames.resync();
        self.stuck = false;
    }

    /// Drops all bytes that are held, for a new connection whose receive buffer is empty.
    pub fn reset(&mut self) {
        self.frames.reset();
        self.stuck = false;
    }

    /// The next item from the bytes that the frames hold, which are the front of `src`.
    fn next(&mut self, src: &mut BytesMut) -> Option<Item<F::Header>> {
        let item = self.frames.next()?;
        let len = item.bytes().len().min(src.len());
        let mut split = || src.split_to(len).freeze();
        Some(match item {
            stream::Item::Frame(_) => Item::Frame(split()),
            stream::Item::Corrupt { header, why, .. } => Item::Corrupt { header, why, bytes: split() },
            stream::Item::Noise { why, .. } => Item::Noise { bytes: split(), why },
            stream::Item::Fatal(why) => Item::Fatal(why),
        })
    }
}

impl<F: Framing, const N: usize> Default for Codec<F, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<F: Framing, const N: usize> Decoder for Codec<F, N> {
    type Item = Item<F::Header>;
    type Error = io::Error;

    fn decode(&mut self, src: &mut BytesMut) -> io::Result<Option<Self::Item>> {
        loop {
            match (self.next(src), self.stuck) {
                (Some(Item::Fatal(why)), true) => return Err(io::Error::new(io::ErrorKind::InvalidData, why)),
                (Some(item), _) => {
                    self.stuck = matches!(item, Item::Fatal(_));
                    return Ok(Some(item));
                }
                (None, _) => {}
            }
            // Bytes that the frames hold stay in `src` as well until they are part of an item.
            match src.get(self.frames.held()..) {
                None | Some([]) => return Ok(None),
                // There is room for at least one byte, because the frames have no more items.
                Some(fresh) => _ = self.frames.push(fresh),
            }
        }
    }

    fn decode_eof(&mut self, src: &mut BytesMut) -> io::Result<Option<Self::Item>> {
        match self.decode(src)? {
            None => {
                self.frames.gap();
                self.decode(src)
            }
            item => Ok(item),
        }
    }
}

impl<F: Framing, const N: usize, B: AsRef<[u8]>> Encoder<B> for Codec<F, N> {
    type Error = io::Error;

    /// Writes a whole frame.
    ///
    /// # Errors
    ///
    /// [`io::ErrorKind::InvalidInput`] if the bytes are not exactly one frame by their header. The checksum is not
    /// verified.
    fn encode(&mut self, frame: B, dst: &mut BytesMut) -> io::Result<()> {
        let frame = frame.as_ref();
        if frame.is_empty() || F::head(frame) != Head::Total(frame.len()) {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "not one whole frame"));
        }
        dst.extend_from_slice(frame);
        Ok(())
    }
}
