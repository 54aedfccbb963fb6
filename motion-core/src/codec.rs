//! Frames as a `tokio_util` codec. Feature `tokio`; it adds the dependencies `bytes` and `tokio-util`, which brings tokio
//! without its runtime, and needs the standard library.
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
//! // The frames of `Pair` are a `!` and one byte. A `Framed` calls `decode` and `encode` like this.
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
//! assert!(codec.encode(b"!cd", &mut to_send).is_err(), "no whole frame");
//! assert_eq!(to_send, "!c");
//! # Ok::<(), std::io::Error>(())
//! ```

use std::boxed::Box;
use std::io;

use bytes::{Bytes, BytesMut};
use tokio_util::codec::{Decoder, Encoder};

use crate::stream::{self, Corrupt, Fatal, Frames, Framing, Head, Noise};

/// Takes the frames of a protocol out of a byte stream, and writes whole frames into one.
///
/// It finds frames by a [`Frames`] of `N` bytes, which is at least twice [`Framing::MAX`], and keeps all promises of
/// that. The bytes of the items are not copied: they are split off the buffer that was read into. So that buffer is the
/// codec's alone, until the stream ends: whoever changes it has to [`reset`](Self::reset) the codec.
///
/// Nothing but a fatal error ends the stream, and that only if nobody heeds it: asked again without a
/// [`resync`](Self::resync) or a [`reset`](Self::reset), the codec gives it as an [`io::Error`]. Where the bytes end, what
/// waited for more is given up, as after a gap.
#[derive(Debug)]
pub struct Codec<F: Framing, const N: usize> {
    frames: Box<Frames<F, N>>,
    /// The last item was a fatal error.
    stuck: bool,
}

/// What a stream is made of, in bytes of its own: [`stream::Item`] that outlives the buffer.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Item<H> {
    /// A whole, verified frame; [`Framing::frame`] reads it without verifying it again.
    Frame(Bytes),
    /// The first frame of an episode that does not verify.
    Corrupt {
        /// What the header says, itself doubtful.
        header: H,
        /// What is wrong.
        why: Corrupt,
        /// What is given up with it, perhaps no more than the marker.
        bytes: Bytes,
    },
    /// Bytes outside any frame.
    Noise {
        /// At least one byte.
        bytes: Bytes,
        /// Why the first of them begins no frame.
        why: Noise,
    },
    /// The stream cannot go on, unless the codec is told to [`resync`](Codec::resync).
    Fatal(Fatal),
}

impl<F: Framing, const N: usize> Codec<F, N> {
    /// A codec at the start of a stream. Allocates its `N` bytes of buffer.
    #[must_use]
    pub fn new() -> Self {
        Self { frames: Box::default(), stuck: false }
    }

    /// Takes note that the line has fallen silent, as [`Frames::gap`] does: what waits for more bytes will not get them.
    ///
    /// Call it when nothing more was to be decoded. A `Framed` asks again when more bytes arrive; what was given up comes
    /// first then.
    pub fn gap(&mut self) {
        self.frames.gap();
    }

    /// Leaves a fatal error behind, as [`Frames::resync`] does.
    pub fn resync(&mut self) {
        self.frames.resync();
        self.stuck = false;
    }

    /// Forgets everything held: a new connection begins, with an empty buffer.
    pub fn reset(&mut self) {
        self.frames.reset();
        self.stuck = false;
    }

    /// The next item of what the frames hold, which is the front of `src`.
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
            // What the frames hold stays in `src` as well, until it is an item.
            match src.get(self.frames.held()..) {
                None | Some([]) => return Ok(None),
                // All of it was an item, or there is room for a byte at least.
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
    /// [`io::ErrorKind::InvalidInput`], if its header says that it is no frame of this length. The checksum is not
    /// looked at.
    fn encode(&mut self, frame: B, dst: &mut BytesMut) -> io::Result<()> {
        let frame = frame.as_ref();
        if frame.is_empty() || F::head(frame) != Head::Total(frame.len()) {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "not one whole frame"));
        }
        dst.extend_from_slice(frame);
        Ok(())
    }
}
