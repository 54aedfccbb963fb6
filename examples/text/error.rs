//! What can be wrong with an input, and where.

use std::io;

/// What is wrong with a text, and where.
#[derive(Clone, Debug, Eq, PartialEq, thiserror::Error)]
#[error("line {line}, column {column}: {what}")]
pub struct TextError {
    /// The line, from 1.
    pub line: u64,
    /// The byte of the line, from 1.
    pub column: u64,
    /// What is wrong there.
    pub what: What,
}

/// A place in a text, lines and bytes counted from 1.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(super) struct At {
    pub(super) line: u64,
    pub(super) column: u64,
}

impl At {
    /// The error that `what` is wrong here.
    pub(super) fn error(self, what: What) -> TextError {
        TextError { line: self.line, column: self.column, what }
    }
}

/// What is wrong with a text.
#[derive(Clone, Debug, Eq, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum What {
    /// Something stands where only hex digits, separators and comments may.
    #[error("\"{0}\" is no hex digit")]
    NoHexDigit(
        /// The character, or the byte that is none, escaped.
        String,
    ),
    /// A group has an odd number of digits.
    #[error("\"{0}\" has no partner: a byte is two hex digits")]
    LoneDigit(
        /// The last digit of the group.
        char,
    ),
    /// A `0x` stands inside a group, or without two digits.
    #[error("\"0x\" begins a group of hex digits, two for each byte")]
    Prefix,
    /// An offset of seven digits: `hexdump` or `od` without options.
    #[error(
        "seven hex digits are no whole number of bytes; \
         a dump can be read as \"hexdump -C\" or \"xxd\" prints it"
    )]
    Words,
    /// Six zeros that may be an offset or data.
    #[error("\"000000\" may be an offset or three bytes: --format xxd or --format hex tells")]
    Ambiguous,
    /// A line without an offset, where dumps alone are read.
    #[error("the line does not begin with an offset, as --format xxd wants it")]
    NoOffset,
    /// A line of a dump does not fit into [`MAX_LINE`](super::MAX_LINE) bytes.
    #[error("a line of a dump has at most {limit} bytes", limit = super::MAX_LINE)]
    LongLine,
    /// A dump's offset is not the one that its lines so far lead to.
    #[error("offset {found:#x} does not follow: {expected:#x} does; a blank line ends a dump")]
    Jump {
        /// The offset that follows the line before.
        expected: u64,
        /// The offset that the line has.
        found: u64,
    },
    /// The text column is longer or shorter than the bytes beside it.
    #[error("the text column shows {shown} characters, the hex digits beside it {bytes} bytes")]
    Column {
        /// Characters, without blanks at the ends.
        shown: usize,
        /// Bytes, without blanks at the ends.
        bytes: usize,
    },
    /// The text column shows the bytes of each word in reverse.
    #[error("the text column shows the words reversed, as with \"xxd -e\": print without -e")]
    Reversed,
    /// A `*` without a dump line before it.
    #[error("\"*\" repeats a line of a dump, and there is none before it")]
    NothingToRepeat,
    /// A `*` that no offset ends.
    #[error("no offset follows this \"*\" to say how often the line repeats")]
    OpenRepeat,
    /// A `*` that does not stand for whole lines.
    #[error("\"*\" stands for {bytes} bytes, which is no whole number of lines")]
    UnevenRepeat {
        /// The bytes between the offsets.
        bytes: u64,
    },
    /// A `*` that stands for more than [`MAX_REPEAT`](super::MAX_REPEAT) bytes.
    #[error("\"*\" stands for {bytes} bytes, more than {limit}", limit = super::MAX_REPEAT)]
    LongRepeat {
        /// The bytes between the offsets.
        bytes: u64,
    },
    /// A line without a mark, and nothing else says who sent it.
    #[error("no mark \">\" or \"<\": mark each line, or give --from host or --from device")]
    Unmarked,
    /// A mark that contradicts the option `--from`.
    #[error("the mark says that the other side than --from's sent this line")]
    OtherSide,
}

/// Why a [`Source`](super::Source) ends early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    /// The input cannot be read.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The text is wrong.
    #[error("{0}")]
    Text(#[from] TextError),
    /// The text is wrong, and that it is text was a guess.
    #[error("{0} (the input looks like text; --format raw takes it as it is)")]
    Guessed(#[source] TextError),
    /// Raw bytes, or nothing at all, without a word on who sent them.
    #[error("the input does not say who sent its bytes: give --from host or --from device")]
    Unsaid,
}
