//! Typed messages as a `tokio_util` codec. The feature `tokio` adds the dependencies `bytes` and `tokio-util`; the latter
//! brings tokio without its runtime and needs the standard library.
//!
//! The protocol crates name a [`Codec`] for each side, `host::Codec` and `device::Codec`, and show how a `Framed` uses it.

use std::boxed::Box;
use std::io;
use std::marker::PhantomData;

use bytes::{Bytes, BytesMut};
use tokio_util::codec::{Decoder, Encoder};

use crate::owned::Owned;
use crate::stream::{self, Corrupt, Fatal, Frames, Framing, Noise};
use crate::wire::{DecodeError, EncodeError, Framed};

/// Codec of the side `O`: it writes the messages of that side, and reads those of its peer `P` with the framing `F`, which is one of
/// the protocol of `P`.
///
/// It finds frames with a [`Frames`] of `N` bytes, which is at least twice [`Framing::MAX`], and keeps all promises of
/// `Frames`. The bytes of the items are not copied: they are split off the receive buffer. So only the codec may change
/// that buffer until the stream ends. If anything else changes it, [`reset`](Self::reset) the codec.
///
/// Only a fatal error ends the stream, and only if the caller ignores it: when the codec is called again without a
/// [`resync`](Self::resync) or a [`reset`](Self::reset), it returns that error as an [`io::Error`]. At the end of the
/// stream, an incomplete frame is given up, as after a gap.
#[derive(Debug)]
pub struct Codec<O, P: Framed, F: Framing<Header = HeaderOf<P>>, const N: usize> {
    frames: Box<Frames<F, N>>,
    /// Whether the last item was a fatal error.
    is_stuck: bool,
    sides: PhantomData<fn(O) -> P>,
}

/// Header of the frames that carry messages of a side.
type HeaderOf<S> = <<S as Framed>::Framing as Framing>::Header;

/// Item of a stream with messages of the side `S`, in frames with headers `H`. It owns its bytes.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Item<S: Framed, H> {
    /// A message.
    Message {
        /// What the frame says beside the message: nothing, the id of the message, or the address of the receiver.
        label: S::Label,
        /// The message.
        message: Owned<S, Bytes>,
        /// Bytes of the whole frame.
        frame: Bytes,
    },
    /// A sound frame whose body ends before the fields of its message do.
    Undecodable {
        /// What the frame says beside the message.
        label: S::Label,
        /// Why the message cannot be decoded.
        why: DecodeError,
        /// Bytes of the whole frame.
        frame: Bytes,
    },
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

impl<S: Framed, H> Item<S, H> {
    /// Item of a whole frame.
    fn of(frame: Bytes) -> Self {
        let Some(read) = S::Framing::frame(&frame) else {
            return Self::Noise { bytes: frame, why: Noise::Refused };
        };
        let label = S::label(&read);
        match S::decode(&read).and_then(|_| S::open(&read)) {
            Ok((number, body)) => {
                let message = Owned::from_parts(number, frame.slice_ref(body));
                Self::Message { label, message, frame }
            }
            Err(why) => Self::Undecodable { label, why, frame },
        }
    }

    /// Bytes that the item takes from the stream.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        match self {
            Self::Message { frame, .. } | Self::Undecodable { frame, .. } => frame,
            Self::Corrupt { bytes, .. } | Self::Noise { bytes, .. } => bytes,
            Self::Fatal(_) => &[],
        }
    }
}

/// Message of the side `S`, together with the label of its frame if the protocol has labels.
///
/// It is a message alone, or a pair of a label and a message.
pub trait Outgoing<S: Framed> {
    /// Puts the whole frame at the end of `dst`.
    ///
    /// # Errors
    ///
    /// [`EncodeError`]; then nothing is put.
    fn put(&self, dst: &mut BytesMut) -> Result<usize, EncodeError>;
}

impl<O, P: Framed, F: Framing<Header = HeaderOf<P>>, const N: usize> Codec<O, P, F, N> {
    /// A codec at the start of a stream. It allocates its buffer of `N` bytes.
    #[must_use]
    pub fn new() -> Self {
        Self { frames: Box::default(), is_stuck: false, sides: PhantomData }
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
        self.is_stuck = false;
    }

    /// Drops all bytes that are held, for a new connection whose receive buffer is empty.
    pub fn reset(&mut self) {
        self.frames.reset();
        self.is_stuck = false;
    }

    /// The next item. The bytes that the frames hold are the front of `src`, and stay there until they are part of an item.
    fn next(&mut self, src: &mut BytesMut) -> Option<Item<P, F::Header>> {
        let mut fresh = src.get(self.frames.held()..).unwrap_or_default();
        let item = self.frames.next_from(&mut fresh)?;
        let len = item.bytes().len();
        Some(match item {
            stream::Item::Frame(_) => Item::of(src.split_to(len).freeze()),
            stream::Item::Corrupt { header, why, .. } => {
                Item::Corrupt { header, why, bytes: src.split_to(len).freeze() }
            }
            stream::Item::Noise { why, .. } => Item::Noise { bytes: src.split_to(len).freeze(), why },
            stream::Item::Fatal(why) => Item::Fatal(why),
        })
    }
}

impl<O, P: Framed, F: Framing<Header = HeaderOf<P>>, const N: usize> Default for Codec<O, P, F, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<O, P: Framed, F: Framing<Header = HeaderOf<P>>, const N: usize> Decoder for Codec<O, P, F, N> {
    type Item = Item<P, F::Header>;
    type Error = io::Error;

    fn decode(&mut self, src: &mut BytesMut) -> io::Result<Option<Self::Item>> {
        match (self.next(src), self.is_stuck) {
            (Some(Item::Fatal(why)), true) => Err(io::Error::new(io::ErrorKind::InvalidData, why)),
            (Some(item), _) => {
                self.is_stuck = matches!(item, Item::Fatal(_));
                Ok(Some(item))
            }
            (None, _) => Ok(None),
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

impl<O: Framed, P: Framed, F: Framing<Header = HeaderOf<P>>, M: Outgoing<O>, const N: usize> Encoder<M>
    for Codec<O, P, F, N>
{
    type Error = io::Error;

    /// Writes a message.
    ///
    /// # Errors
    ///
    /// [`io::ErrorKind::InvalidInput`] around an [`EncodeError`]; then nothing is written, and the stream can go on.
    fn encode(&mut self, message: M, dst: &mut BytesMut) -> io::Result<()> {
        message.put(dst).map(drop).map_err(|error| io::Error::new(io::ErrorKind::InvalidInput, error))
    }
}
