use core::fmt;
use core::hash::Hash;

use zerocopy::ByteOrder;

use super::{DecodeError, EncodeError, Messages};
use crate::lint::Lints;
use crate::stream::Framing;

/// One side of a protocol: a type without values, which names what that side sends.
///
/// Code that is the same for all sides is written against this trait, once.
pub trait Side: Copy + Eq + Hash + fmt::Debug + 'static {
    /// All messages that the side sends.
    type Message<'a>: Messages<'a>;

    /// Byte order of the numbers in its messages.
    type Order: ByteOrder;

    /// Findings about a message that hold for every receiver. A side without rules finds nothing.
    #[must_use]
    fn lint(message: &Self::Message<'_>) -> Lints {
        let _ = message;
        Lints::new()
    }
}

/// A side whose messages travel in frames, so that generic code can read and write them.
pub trait Framed: Side {
    /// Framing that finds its frames in a stream.
    type Framing: Framing;

    /// What a frame says beside the message that it carries: nothing, an id, or an address.
    type Label: Copy;

    /// Decodes the message of a frame.
    ///
    /// # Errors
    ///
    /// [`DecodeError`], if the body ends before the fields of its message do.
    fn decode<'a>(frame: &<Self::Framing as Framing>::Frame<'a>) -> Result<Self::Message<'a>, DecodeError>;

    /// Takes the label out of a frame.
    fn label(frame: &<Self::Framing as Framing>::Frame<'_>) -> Self::Label;

    /// Takes number and body of a message out of a frame.
    ///
    /// # Errors
    ///
    /// [`DecodeError`], if the frame ends before the number does.
    fn open<'a>(frame: &<Self::Framing as Framing>::Frame<'a>) -> Result<(u32, &'a [u8]), DecodeError>;

    /// Length of the whole frame of a message in bytes.
    fn encoded_len(message: &Self::Message<'_>) -> usize;

    /// Writes the whole frame of a message to the front of `out` and returns its length in bytes.
    ///
    /// # Errors
    ///
    /// [`EncodeError`]; then nothing is written.
    fn encode_into(message: &Self::Message<'_>, label: Self::Label, out: &mut [u8]) -> Result<usize, EncodeError>;
}

/// The envelope that carries the messages of one side: how a body goes into a frame and comes out of it.
pub trait Envelope {
    /// A whole frame.
    type Frame<'a>;

    /// What a frame says beside the message that it carries: nothing, an id, or an address.
    type Label: Copy;

    /// Takes number and body of a message out of a frame.
    ///
    /// # Errors
    ///
    /// [`DecodeError`], if the frame ends before the number does.
    fn open<'a>(frame: &Self::Frame<'a>) -> Result<(u32, &'a [u8]), DecodeError>;

    /// Takes the label out of a frame.
    fn label(frame: &Self::Frame<'_>) -> Self::Label;

    /// Length in bytes of a frame whose message has this number and a body of so many bytes.
    fn frame_len(number: u32, body_len: usize) -> usize;

    /// Writes a frame around what `body` writes to the front of `out`, and returns its length in bytes.
    ///
    /// # Errors
    ///
    /// [`EncodeError`], if the frame cannot be written, and those of `body`. Then nothing is written.
    fn seal(
        label: Self::Label,
        number: u32,
        body_len: usize,
        out: &mut [u8],
        body: impl FnOnce(&mut [u8]) -> Result<usize, EncodeError>,
    ) -> Result<usize, EncodeError>;

    /// Adds to the findings about a message what is wrong with its label. Most labels have no rules.
    fn lint(label: Self::Label, found: &mut Lints) {
        let _ = (label, found);
    }
}

/// Makes the type of a side, and the methods that all its messages have: decoding, encoding, and what the features `alloc`
/// and `bytes` add.
///
/// `Name in ORDER: Message(label: Label) by Envelope over Framing, lint Context` names what the macro needs. The message
/// type has a method `lint(&self, &Context) -> Lints`. After `by Envelope`, `or other` says that decoding cannot fail: a
/// body that is too short gives `Other`.
#[doc(hidden)]
#[macro_export]
macro_rules! side {
    ($(
        $(#[$meta:meta])*
        $vis:vis enum $name:ident in $order:ident: $message:ident($($label:ident: $type:ty)?)
            by $envelope:ty $(, or $other:ident)?, over $framing:ty, lint $context:ty;
    )*) => {$(
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        $vis enum $name {}

        impl $crate::wire::Side for $name {
            type Message<'a> = $message<'a>;
            type Order = $crate::zerocopy::$order;

            fn lint(message: &$message<'_>) -> $crate::lint::Lints {
                message.lint(&<$context>::default())
            }
        }

        impl $crate::wire::Framed for $name {
            type Framing = $framing;
            type Label = <$envelope as $crate::wire::Envelope>::Label;

            #[inline]
            fn decode<'a>(
                frame: &<$framing as $crate::stream::Framing>::Frame<'a>,
            ) -> Result<$message<'a>, $crate::wire::DecodeError> {
                $crate::__decode!(result $message::decode(frame) $(, or $other)?)
            }

            #[inline]
            fn label(frame: &<$framing as $crate::stream::Framing>::Frame<'_>) -> Self::Label {
                <$envelope as $crate::wire::Envelope>::label(frame)
            }

            #[inline]
            fn open<'a>(
                frame: &<$framing as $crate::stream::Framing>::Frame<'a>,
            ) -> Result<(u32, &'a [u8]), $crate::wire::DecodeError> {
                <$envelope as $crate::wire::Envelope>::open(frame)
            }

            #[inline]
            fn encoded_len(message: &$message<'_>) -> usize {
                message.encoded_len()
            }

            #[inline]
            fn encode_into(
                message: &$message<'_>,
                label: Self::Label,
                out: &mut [u8],
            ) -> Result<usize, $crate::wire::EncodeError> {
                $(let $label: $type = label;)?
                let _ = label;
                message.encode_into($($label,)? out)
            }
        }

        $crate::__decode! { method $message $envelope $(, or $other)? }

        impl $message<'_> {
            /// Length of the whole frame in bytes.
            #[must_use]
            #[inline]
            pub fn encoded_len(&self) -> usize {
                use $crate::wire::{Envelope, Messages};
                <$envelope>::frame_len(self.number(), self.body_len())
            }

            /// Writes the whole frame to the front of `out` and returns its length in bytes.
            ///
            /// # Errors
            ///
            /// [`EncodeError`](crate::EncodeError), if the frame does not fit, or if its receiver would read another
            /// message. Then nothing is written.
            #[allow(clippy::inline_always, reason = "a program that knows what it sends writes only that")]
            #[inline(always)]
            pub fn encode_into(
                &self,
                $($label: $type,)?
                out: &mut [u8],
            ) -> Result<usize, $crate::wire::EncodeError> {
                use $crate::wire::{Envelope, Messages};
                <$envelope>::seal(($($label)?), self.number(), self.body_len(), out, |place| self.encode_body(place))
            }

            /// Writes the whole frame like [`encode_into`](Self::encode_into), unless [`lint`](Self::lint) finds an error in
            /// the message, or the label of the frame is wrong.
            ///
            /// # Errors
            ///
            /// [`EncodeError::Refused`](crate::EncodeError::Refused) with the first error that was found, and the errors of
            /// `encode_into`. Then nothing is written.
            pub fn encode_checked(
                &self,
                $($label: $type,)?
                context: &$context,
                out: &mut [u8],
            ) -> Result<usize, $crate::wire::EncodeError> {
                let mut found = self.lint(context);
                <$envelope as $crate::wire::Envelope>::lint(($($label)?), &mut found);
                match found.first_error() {
                    Some(error) => Err($crate::wire::EncodeError::Refused(error)),
                    None => self.encode_into($($label,)? out),
                }
            }
        }

        $crate::__to_vec! { $message($($label: $type)?) }
        $crate::__encode! { $message($($label: $type)?) }
        $crate::__outgoing! { $name: $message($($type)?) }
    )*};
}

/// Decoding that can fail, or that gives `Other` instead.
#[doc(hidden)]
#[macro_export]
macro_rules! __decode {
    (result $decoded:expr) => {
        $decoded
    };
    (result $decoded:expr, or other) => {
        Ok($decoded)
    };
    (method $message:ident $envelope:ty) => {
        impl<'a> $message<'a> {
            /// Decodes the message of a frame from this side.
            ///
            /// A message that has no type gives `Other`, never an error.
            ///
            /// # Errors
            ///
            /// [`DecodeError`](crate::DecodeError), if the body ends before the fields of its message do. The frame itself is
            /// sound.
            // Inlined, so that a caller that matches at once does not build the enum.
            #[allow(clippy::inline_always, reason = "callers match on the message at once")]
            #[inline(always)]
            pub fn decode(
                frame: &<$envelope as $crate::wire::Envelope>::Frame<'a>,
            ) -> Result<Self, $crate::wire::DecodeError> {
                let (number, body) = <$envelope as $crate::wire::Envelope>::open(frame)?;
                <Self as $crate::wire::Messages>::decode_body(number, body)
            }
        }
    };
    (method $message:ident $envelope:ty, or other) => {
        impl<'a> $message<'a> {
            /// Decodes the message of a frame from this side.
            ///
            /// Decoding cannot fail: a message that has no type, and a known one with data of another length, gives
            /// `Other`.
            #[allow(clippy::inline_always, reason = "callers match on the message at once")]
            #[inline(always)]
            #[must_use]
            pub fn decode(frame: &<$envelope as $crate::wire::Envelope>::Frame<'a>) -> Self {
                use $crate::wire::Messages;
                match <$envelope as $crate::wire::Envelope>::open(frame) {
                    Ok((number, body)) => Self::decode_or_other(number, body),
                    Err(_) => Self::other(0, &[]),
                }
            }
        }
    };
}
#[doc(hidden)]
#[macro_export]
#[cfg(feature = "alloc")]
macro_rules! __to_vec {
    ($message:ident($($label:ident: $type:ty)?)) => {
        impl $message<'_> {
            /// Writes the whole frame into a new vector. Feature `alloc`.
            ///
            /// # Errors
            ///
            /// The errors of `encode_into`, except that of a small buffer.
            #[allow(clippy::wrong_self_convention, reason = "taken by reference, as all other ways to write it")]
            pub fn to_vec(&self $(, $label: $type)?) -> Result<$crate::owned::Vec<u8>, $crate::wire::EncodeError> {
                $crate::owned::to_vec(self.encoded_len(), |out| self.encode_into($($label,)? out))
            }
        }
    };
}

#[doc(hidden)]
#[macro_export]
#[cfg(not(feature = "alloc"))]
macro_rules! __to_vec {
    ($($side:tt)*) => {};
}

#[doc(hidden)]
#[macro_export]
#[cfg(feature = "bytes")]
macro_rules! __encode {
    ($message:ident($($label:ident: $type:ty)?)) => {
        impl $message<'_> {
            /// Puts the whole frame at the end of `buf` and returns its length in bytes. Feature `bytes`.
            ///
            /// The frame is copied once; a frame of more than 128 bytes also costs an allocation.
            ///
            /// # Errors
            ///
            /// The errors of `encode_into`. Then nothing is put.
            pub fn encode(
                &self,
                $($label: $type,)?
                buf: &mut impl $crate::bytes::BufMut,
            ) -> Result<usize, $crate::wire::EncodeError> {
                $crate::buf::put(buf, self.encoded_len(), |out| self.encode_into($($label,)? out))
            }
        }
    };
}

#[doc(hidden)]
#[macro_export]
#[cfg(not(feature = "bytes"))]
macro_rules! __encode {
    ($($side:tt)*) => {};
}

#[doc(hidden)]
#[macro_export]
#[cfg(feature = "tokio")]
macro_rules! __outgoing {
    ($name:ident: $message:ident()) => {
        impl $crate::codec::Outgoing<$name> for $message<'_> {
            fn put(&self, dst: &mut $crate::bytes::BytesMut) -> Result<usize, $crate::wire::EncodeError> {
                self.encode(dst)
            }
        }
    };
    ($name:ident: $message:ident($label:ty)) => {
        impl $crate::codec::Outgoing<$name> for ($label, $message<'_>) {
            fn put(&self, dst: &mut $crate::bytes::BytesMut) -> Result<usize, $crate::wire::EncodeError> {
                self.1.encode(self.0, dst)
            }
        }
    };
}

#[doc(hidden)]
#[macro_export]
#[cfg(not(feature = "tokio"))]
macro_rules! __outgoing {
    ($($side:tt)*) => {};
}
