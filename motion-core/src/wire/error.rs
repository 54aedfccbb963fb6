use core::fmt;

/// Why a body is not the message that its number says.
///
/// The frame it came in is sound and stays in the caller's hand, so nothing is lost.
#[derive(Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum DecodeError {
    /// The body ends before its fields do.
    #[error("{what}: need {needed} bytes, have {have}")]
    Truncated {
        /// The message, or the field that is cut off.
        what: &'static str,
        /// Bytes of body that reach to the end of it.
        needed: usize,
        /// Bytes of body there are.
        have: usize,
    },
    /// The body goes on behind the fields of a message that keeps no tail.
    #[error("{what}: {extra} bytes too many")]
    Trailing {
        /// The message.
        what: &'static str,
        /// Bytes behind its last field.
        extra: usize,
    },
    /// A value makes it another message, or none.
    #[error("{what}: {value} is not one of {min} to {max}")]
    OutOfRange {
        /// The field.
        what: &'static str,
        /// Its value.
        value: i64,
        /// The least value.
        min: i64,
        /// The greatest value.
        max: i64,
    },
}

/// Why a message cannot be written.
///
/// Nothing is ever shortened to make it fit, and nothing is written that would be read back as something else.
#[derive(Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum EncodeError {
    /// The buffer is too small; nothing was written.
    #[error("need {needed} bytes of buffer, have {have}")]
    BufferTooSmall {
        /// Bytes the message takes.
        needed: usize,
        /// Bytes the buffer has.
        have: usize,
    },
    /// An optional field is set although one before it is not: a reader would take it for that one.
    #[error("{what}: set, but an optional field before it is not")]
    Hole {
        /// The field that is set.
        what: &'static str,
    },
    /// The tail is so long that a reader would take its start for a field.
    #[error("{what}: absent, but a reader would find it in the {len} bytes of tail")]
    Tail {
        /// The field it would be taken for.
        what: &'static str,
        /// Bytes of tail.
        len: usize,
    },
    /// A list, text or block is longer than its length field, or the protocol, allows.
    #[error("{what}: {len} is more than {max}")]
    TooLong {
        /// The field.
        what: &'static str,
        /// Elements or bytes it has.
        len: usize,
        /// Elements or bytes that are allowed.
        max: usize,
    },
    /// A value has no place on the wire, or a reader would take it for another command.
    #[error("{what}: {value} is not one of {min} to {max}")]
    OutOfRange {
        /// The field.
        what: &'static str,
        /// Its value.
        value: i64,
        /// The least value.
        min: i64,
        /// The greatest value.
        max: i64,
    },
    /// A message without a type has the number and the bytes of a message with a type: the receiver would read that one.
    /// No decoder makes such a message.
    #[error("{what}: given as a message without a type, but its receiver would read this message")]
    Typed {
        /// The message that the receiver would read.
        what: &'static str,
    },
    /// [`encode_checked`](crate::lint) found something that a strict peer refuses.
    #[error("{0}")]
    Refused(crate::lint::Lint),
}

// Derived ones would print `what` with escapes, which cannot be proven free of panics.
impl fmt::Debug for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "DecodeError({self})")
    }
}

impl fmt::Debug for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "EncodeError({self})")
    }
}
