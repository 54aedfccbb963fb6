//! Bytes from files: raw bytes, or text that people or dump programs wrote.
//!
//! [`Source`] reads any [`Read`](std::io::Read) in constant memory and lends [`Piece`]s: some
//! bytes and the side that sent them.
//!
//! # The text
//!
//! The text is UTF-8 or UTF-16. UTF-16 needs a byte order mark, except if it is ASCII with the low byte first.
//!
//! Each line may begin with a mark, `>` (the host sent it) or `<` (the device sent it). A mark
//! is valid for its line only. After the mark, if there is one, the line has one of these forms:
//!
//! | line | example |
//! |---|---|
//! | hex digits, in pairs, either case | `44 46 01 00`, `44460100`, `0x44, 0x46`, `44:46-01_00` |
//! | `xxd` | `00000000: 4446 0100 0000 3000  DF....0.` |
//! | `hexdump -C` | `00000000  44 46 01 00 00 00 30 00  \|DF....0.\|` |
//! | `od -A x -t x1z` | `000000 44 46 01 00 00 00 30 00  >DF....0.<` |
//! | `tcpdump -x`, `-X` | `0x0000:  4446 0100 0000 3000  DF....0.`; the bytes of a packet begin with its headers |
//! | `*`, in a dump | repeats the line before it up to the next offset |
//! | a comment, also after hex digits | `// the hello`, `# the hello` |
//! | an empty line | ends a dump |
//!
//! **Hex digits.** Blank, tab and `, : ; _ -` separate groups. A group is a whole number of
//! bytes in the order in which they are written, and may begin with `0x`. So `0x0102` is the
//! byte 1 and then the byte 2, and `0x1` is an error. A line may have any length.
//!
//! **Offsets.** 6 to 16 hex digits without a separator, or `0x` and 4 to 16 digits, at the beginning of
//! a line, are an offset or data. With `0x` they are an offset by the first rule only:
//!
//! 1. digits before a colon and then a blank or the end of the line are an offset (`xxd`, `tcpdump`);
//! 2. digits before single pairs of digits and a closed text column, `|...|` or `>...<`, are an
//!    offset (`hexdump -C`, `od`);
//! 3. digits before two blanks and then single pairs without a text column are an offset if it is 0;
//! 4. inside a dump of the kinds 2 and 3, digits are always an offset, and an offset alone ends
//!    the dump;
//! 5. six zeros, one blank and then single pairs may be `od -A x -t x1` or data: this is an error;
//! 6. seven digits are an offset of `hexdump` or `od` without options: this is an error, because
//!    words and octal offsets are not supported. `hexdump -C` prints a form that is.
//!
//! Anything else is data. [`Format::Hex`] takes no digits for an offset, and [`Format::Xxd`]
//! requires an offset in each line. With these two nothing is guessed.
//!
//! A line of a dump cannot have a comment, because its text column may look like one.
//!
//! The offsets of a dump must follow each other. A dump may begin at any offset, and offset 0
//! always begins a new dump. Lines of the host, lines of the device and lines without a mark have
//! separate offsets.
//!
//! The text column is never data, and it may differ from the bytes beside it, because somebody may
//! have edited them. Two differences are errors: a column of another length (as of `xxd -b`), and
//! a column that shows the bytes of each word in reverse (as of `xxd -e`).

mod dump;
mod encoding;
mod error;
mod grammar;
mod lines;
mod source;

pub use error::{SourceError, TextError, TextProblem};
pub use source::{Format, Piece, Senders, Source};

/// Side that sent some bytes.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub enum Side {
    /// Side that controls, with the mark `>`.
    Host,
    /// Side that moves, with the mark `<`.
    Device,
}

/// Length of the longest part of a line that is kept, in bytes. A longer line is read in such parts.
pub const MAX_LINE: usize = 64 * 1024;

/// Greatest number of bytes that one `*` may stand for, so that a short file cannot expand without limit.
pub const MAX_REPEAT: u64 = 1024 * 1024;
