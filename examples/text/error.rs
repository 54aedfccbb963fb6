//! Errors of an input, with their places.

use std::io;

/// Error in a text, with its place.
#[derive(Clone, Debug, Eq, PartialEq, thiserror::Error)]
#[error("line {line}, column {column}: {what}")]
pub struct TextError {
    /// Number of the line, from 1.
    pub line: u64,
    /// Number of the byte in the line, from 1.
    pub column: u64,
    /// Kind of the error.
    pub what: TextProblem,
}

/// Place in a text. Lines and bytes are counted from 1.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(super) struct At {
    pub(super) line: u64,
    pub(super) column: u64,
}

impl At {
    /// Error of the kind `what` at this place.
    pub(super) fn error(self, what: TextProblem) -> TextError {
        TextError { line: self.line, column: self.column, what }
    }
}

/// Kind of an error in a text.
#[derive(Clone, Debug, Eq, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TextProblem {
    /// A character that is not part of hex digits, separators or comments.
    #[error("\"{0}\" is not a hex digit")]
    NoHexDigit(
        /// The character, or the byte that is not part of a character, escaped.
        String,
    ),
    /// A group has an odd number of digits.
    #[error("\"{0}\" is a single hex digit: a byte has two")]
    LoneDigit(
        /// The last digit of the group.
        char,
    ),
    /// A `0x` inside a group, or without two digits after it.
    #[error("\"0x\" must begin a group of hex digits, with two digits for each byte")]
    Prefix,
    /// An offset of seven digits, as `hexdump` and `od` without options print it.
    #[error(
        "seven hex digits are not a whole number of bytes; \
        if this is a dump, print it with \"hexdump -C\" or \"xxd\""
    )]
    Words,
    /// Six zeros that may be an offset or data.
    #[error("\"000000\" may be an offset or three bytes: give --format xxd or --format hex")]
    Ambiguous,
    /// A line without an offset in an input that may only have dumps.
    #[error("the line does not begin with an offset, which --format xxd requires")]
    NoOffset,
    /// A line of a dump that is longer than [`MAX_LINE`](super::MAX_LINE) bytes.
    #[error("the line of a dump is longer than {limit} bytes", limit = super::MAX_LINE)]
    LongLine,
    /// An offset that is not the end of the line before it.
    #[error("the offset is {found:#x}, should be {expected:#x}; a blank line would end the dump")]
    Jump {
        /// Offset at the end of the line before.
        expected: u64,
        /// Offset in the line.
        found: u64,
    },
    /// A text column that is longer or shorter than the bytes beside it.
    #[error("the text column has {shown} characters, but the hex digits beside it are {bytes} bytes")]
    Column {
        /// Number of characters, without blanks at the ends.
        shown: usize,
        /// Number of bytes, without blanks at the ends.
        bytes: usize,
    },
    /// A text column that shows the bytes of each word in reverse.
    #[error("the text column shows the bytes of each word in reverse, as with \"xxd -e\": print the dump without -e")]
    Reversed,
    /// A `*` without a dump line before it.
    #[error("\"*\" repeats a line of a dump, but there is no such line before it")]
    NothingToRepeat,
    /// A `*` without an offset after it.
    #[error("no offset follows this \"*\", so it is unknown how often the line repeats")]
    OpenRepeat,
    /// A `*` that does not stand for whole lines.
    #[error("\"*\" stands for {bytes} bytes, which is not a whole number of lines")]
    UnevenRepeat {
        /// Number of bytes between the offsets.
        bytes: u64,
    },
    /// A `*` that stands for more than [`MAX_REPEAT`](super::MAX_REPEAT) bytes.
    #[error("\"*\" stands for {bytes} bytes, more than the limit of {limit}", limit = super::MAX_REPEAT)]
    LongRepeat {
        /// Number of bytes between the offsets.
        bytes: u64,
    },
    /// A line without a mark, in an input whose sender is not given.
    #[error("the line has no mark \">\" or \"<\": mark each line, or give --from host or --from device")]
    Unmarked,
    /// A mark that contradicts the option `--from`.
    #[error("the mark of the line contradicts --from")]
    OtherSide,
}

/// Error that ends a [`Source`](super::Source) early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    /// The input cannot be read.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The text has an error.
    #[error("{0}")]
    Text(#[from] TextError),
    /// The text has an error, and it was only guessed that the input is text.
    #[error("{0} (the input looks like text; --format raw reads it as raw bytes)")]
    Guessed(#[source] TextError),
    /// Raw bytes, or an input without bytes, whose sender is not given.
    #[error("the input does not say who sent its bytes: give --from host or --from device")]
    Unsaid,
}
