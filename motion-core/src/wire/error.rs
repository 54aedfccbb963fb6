use core::fmt;

/// Error of a body that is not the message that its number says.
///
/// The frame that carried the body is sound, and the caller still has it: nothing is lost.
#[derive(Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum DecodeError {
    /// The body ends before its fields do.
    #[error("{what}: need {needed} bytes, have {have}")]
    Truncated {
        /// Message, or its field that is cut off.
        what: &'static str,
        /// Length in bytes that the body would have to have up to the end of it.
        needed: usize,
        /// Length of the body in bytes.
        have: usize,
    },
    /// Bytes follow the fields of a message that keeps no tail.
    #[error("{what}: {extra} bytes too many")]
    Trailing {
        /// Message.
        what: &'static str,
        /// Number of bytes after the last field.
        extra: usize,
    },
    /// A value says that the body is another message, or no message.
    #[error("{what}: {value} is not one of {min} to {max}")]
    OutOfRange {
        /// Field.
        what: &'static str,
        /// Value of the field.
        value: i64,
        /// Least value that is allowed.
        min: i64,
        /// Greatest value that is allowed.
        max: i64,
    },
}

/// Error of a message that cannot be written.
///
/// An encoder never shortens a message to make it fit, and never writes bytes that a reader would read as another message.
#[derive(Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum EncodeError {
    /// The buffer is too small. Nothing was written.
    #[error("need {needed} bytes of buffer, have {have}")]
    BufferTooSmall {
        /// Length of the message in bytes.
        needed: usize,
        /// Length of the buffer in bytes.
        have: usize,
    },
    /// An optional field is set although one before it is not: a reader would read it as the field before.
    #[error("{what}: set, but an optional field before it is not")]
    Hole {
        /// Field that is set.
        what: &'static str,
    },
    /// The tail is so long that a reader would take its start for a field.
    #[error("{what}: absent, but a reader would find it in the {len} bytes of tail")]
    Tail {
        /// Field that a reader would find in the tail.
        what: &'static str,
        /// Length of the tail in bytes.
        len: usize,
    },
    /// A list, text or block is longer than its length field or the protocol allows.
    #[error("{what}: {len} is more than {max}")]
    TooLong {
        /// Field.
        what: &'static str,
        /// Number of its elements or bytes.
        len: usize,
        /// Number of elements or bytes that is allowed.
        max: usize,
    },
    /// A value cannot be written, or a reader would read another command.
    #[error("{what}: {value} is not one of {min} to {max}")]
    OutOfRange {
        /// Field.
        what: &'static str,
        /// Value of the field.
        value: i64,
        /// Least value that is allowed.
        min: i64,
        /// Greatest value that is allowed.
        max: i64,
    },
    /// A message without a type has the number and the bytes of a message with a type: the receiver would read that one.
    /// No decoder makes such a message.
    #[error("{what}: given as a message without a type, but its receiver would read this message")]
    Typed {
        /// Message that the receiver would read.
        what: &'static str,
    },
    /// The method `encode_checked` found something that a strict peer refuses.
    #[error("{0}")]
    Refused(crate::lint::Lint),
}

// A derived `Debug` would print `what` with escapes, which cannot be proven free of panics.
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
