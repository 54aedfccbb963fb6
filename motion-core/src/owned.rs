//! Messages that outlive their receive buffer. The feature `alloc` adds no dependency.
//!
//! An owned message is a number and a copy of the body, which is decoded again on each access. So each message needs
//! one type, not a borrowed and an owned one, and no conversion can lose anything.
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
//! #         /// Number of the motor.
//! #         motor: Motor,
//! #     }
//! # }
//! # messages! {
//! #     /// The messages of a host.
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
//! With the feature `serde` an owned message can be written and
//! read in any self-describing format, such as JSON or CBOR. It is a map of three entries,
//! `{ "message": "Go", "number": 7, "fields": { "motor": 3, "tail": "7461696c" } }`; the module `serialize` describes
//! the form of the fields. When a map is read, the layout of the message turns it into bytes, and these have to decode
//! to the same fields. So a message that its layout does not fully describe is an error, never wrong bytes. Errors name
//! the field.
//!
//! - `number` may be left out if only one message has the name; a message that shares its name with others, such as an
//!   acknowledgement, needs it. `message` may be left out if the number is known. A message without a type of its own
//!   has the name `Other`, a number, and its body as `data`.
//! - `null` means an absent field; `false` and `true` mean 0 and 1. A number for an IEEE field is rounded to the
//!   nearest `f32`.
//! - Entries other than these three are ignored; fields that the message does not have are an error.
//!
//! The bytes come back unchanged, with one exception: a text loses the NULs at its end, and a text of fixed size loses
//! all bytes after its first NUL.

#[doc(hidden)]
pub use alloc::vec::Vec;
use core::fmt;
use core::marker::PhantomData;

use crate::wire::{EncodeError, Messages, Side};

/// A message of the side `S` that owns its bytes.
///
/// The bytes are a vector by default; with `bytes::Bytes` for `B`, clones are cheap. Two messages are equal if their
/// numbers and bytes are equal. Each access decodes the bytes again, without a copy.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct Owned<S: Side, B = Vec<u8>> {
    number: u32,
    body: B,
    side: PhantomData<S>,
}

impl<S: Side> Owned<S> {
    /// An owned copy of a message.
    ///
    /// # Errors
    ///
    /// [`EncodeError`] if the message cannot be written, or would be read back as something else.
    pub fn new(message: &S::Message<'_>) -> Result<Self, EncodeError> {
        let body = to_vec(message.body_len(), |out| message.encode_body(out))?;
        Ok(Self::from_parts(message.number(), body))
    }
}

impl<S: Side, B: AsRef<[u8]>> Owned<S, B> {
    /// A message from its number, as in the tables of the protocol, and its body.
    #[must_use]
    pub const fn from_parts(number: u32, body: B) -> Self {
        Self { number, body, side: PhantomData }
    }

    /// The decoded message; `Other` if the body is too short for the message with this number.
    #[must_use]
    pub fn message(&self) -> S::Message<'_> {
        let body = self.body();
        S::Message::decode_or_other(self.number, body)
    }

    /// The number of the message, as in the tables of the protocol.
    #[must_use]
    pub const fn number(&self) -> u32 {
        self.number
    }

    /// The bytes of the body, without the envelope.
    #[must_use]
    pub fn body(&self) -> &[u8] {
        self.body.as_ref()
    }

    /// The bytes of the body, moved out of the message.
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

/// A vector with the bytes that `write` writes into a buffer of `len` bytes.
///
/// # Errors
///
/// The errors of `write`.
#[doc(hidden)]
pub fn to_vec(len: usize, write: impl FnOnce(&mut [u8]) -> Result<usize, EncodeError>) -> Result<Vec<u8>, EncodeError> {
    let mut bytes = alloc::vec![0; len];
    let written = write(&mut bytes)?;
    bytes.truncate(written);
    Ok(bytes)
}
