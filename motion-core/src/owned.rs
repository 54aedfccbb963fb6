//! Messages that outlive the buffer they came in. Feature `alloc`; it adds no dependency.
//!
//! An owned message is its number and its own bytes, decoded again on access. So there is one type for each message,
//! not a lent and an owned one, and nothing is lost in between.
//!
//! ```
//! # use motion_core::{message, messages, unit, zerocopy};
//! # unit! {
//! #     /// A motor.
//! #     pub struct Motor(u8) "";
//! # }
//! # message! {
//! #     /// Go.
//! #     pub struct Go<'a> in LE {
//! #         /// Which motor.
//! #         motor: Motor,
//! #     }
//! # }
//! # messages! {
//! #     /// What a host sends.
//! #     pub enum HostMessage<'a> {
//! #         /// Go.
//! #         7 => Go(Go<'a>),
//! #     }
//! # }
//! use motion_core::owned::Owned;
//! use motion_core::wire::Side;
//!
//! #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
//! enum Host {}
//!
//! impl Side for Host {
//!     type Message<'a> = HostMessage<'a>;
//!     type Order = zerocopy::LE;
//! }
//!
//! let kept = {
//!     let buffer = *b"unknown tail";
//!     Owned::<Host>::new(&HostMessage::Go(Go { motor: Motor(3), tail: &buffer[8..] }))?
//! };
//! assert!(matches!(kept.message(), HostMessage::Go(go) if go.motor == Motor(3)));
//! assert_eq!(kept.to_string(), "Go { motor: 3, tail: 7461696c }");
//! # #[cfg(feature = "serde")] {
//!
//! // With the feature `serde`:
//! let json = r#"{"message":"Go","number":7,"fields":{"motor":3,"tail":"7461696c"}}"#;
//! assert_eq!(serde_json::to_string(&kept).unwrap(), json);
//! assert_eq!(serde_json::from_str::<Owned<Host>>(json).unwrap(), kept);
//! # }
//! # Ok::<(), motion_core::wire::EncodeError>(())
//! ```

//!
//! # As JSON
//!
//! With the feature `serde` (its dependency is `serde`, without the derive macros) an owned message can be written and
//! read in any format that describes itself, such as JSON or CBOR. It is a map of three entries,
//! `{ "message": "Go", "number": 7, "fields": { "motor": 3, "tail": "7461696c" } }`; the fields have the form that the
//! module `serialize` describes. What is read becomes bytes by the layout of the message, and these have to decode to the
//! same fields. So a message that its layout alone does not make is an error, never wrong bytes; errors name the field.
//!
//! - `number` may be left out where the name says enough; a message that shares its name with others, such as an
//!   acknowledgement, needs it. `message` may be left out of a known number. A message without a type of its own is named
//!   `Other`, and has a number, and its body as `data`.
//! - `null` stands for an absent field, `false` and `true` for 0 and 1. A number for an IEEE field is rounded to it.
//! - Entries beside the three do no harm; fields that the message does not have are an error.
//!
//! The bytes come back as they were, with one exception: a text drops the NULs at its end, and a text of fixed size what
//! follows its first NUL.

#[doc(hidden)]
pub use alloc::vec::Vec;
use core::fmt;
use core::marker::PhantomData;

use crate::wire::{EncodeError, Messages, Side};

/// A message of the side `S` that owns its bytes.
///
/// The bytes are a vector unless said otherwise; `bytes::Bytes` for `B` makes clones cheap. Two are equal if number and
/// bytes are. Decoding costs what it costs the first time: little, and no copy.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct Owned<S: Side, B = Vec<u8>> {
    number: u32,
    body: B,
    side: PhantomData<S>,
}

impl<S: Side> Owned<S> {
    /// Keeps a message.
    ///
    /// # Errors
    ///
    /// [`EncodeError`], if it cannot be written, or would be read back as something else.
    pub fn new(message: &S::Message<'_>) -> Result<Self, EncodeError> {
        let body = to_vec(message.body_len(), |out| message.encode_body(out))?;
        Ok(Self::from_parts(message.number(), body))
    }
}

impl<S: Side, B: AsRef<[u8]>> Owned<S, B> {
    /// A message of this number and body, as the protocol's tables count.
    #[must_use]
    pub const fn from_parts(number: u32, body: B) -> Self {
        Self { number, body, side: PhantomData }
    }

    /// The message. Where the body is too short for what its number says, it is kept as `Other`.
    #[must_use]
    pub fn message(&self) -> S::Message<'_> {
        let body = self.body();
        S::Message::decode_body(self.number, body).unwrap_or_else(|_| S::Message::other(self.number, body))
    }

    /// The number it is sent under, as the protocol's tables count.
    #[must_use]
    pub const fn number(&self) -> u32 {
        self.number
    }

    /// The bytes of its body, without the envelope.
    #[must_use]
    pub fn body(&self) -> &[u8] {
        self.body.as_ref()
    }

    /// Gives the bytes of its body away.
    #[must_use]
    pub fn into_body(self) -> B {
        self.body
    }
}

impl<S: Side, B: AsRef<[u8]>> fmt::Display for Owned<S, B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.message().fmt(f)
    }
}

impl<S: Side, B: AsRef<[u8]>> fmt::Debug for Owned<S, B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Owned").field(&self.message()).finish()
    }
}

/// What `write` writes into a buffer of `len` bytes, as a vector.
///
/// # Errors
///
/// Those of `write`.
pub fn to_vec(len: usize, write: impl FnOnce(&mut [u8]) -> Result<usize, EncodeError>) -> Result<Vec<u8>, EncodeError> {
    let mut bytes = alloc::vec![0; len];
    let written = write(&mut bytes)?;
    bytes.truncate(written);
    Ok(bytes)
}
