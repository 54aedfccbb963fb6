//! Bytes out of files: raw, or written as text by people and by dump programs.
//!
//! [`Source`] reads any [`Read`](std::io::Read) in constant memory and lends [`Piece`]s: some
//! bytes and the side that sent them.
//!
//! # The text
//!
//! Each line may begin with a mark, `>` (the host sent it) or `<` (the device sent it), which
//! holds for this line alone. Behind the mark, or without one, stands one of these:
//!
//! | line | example |
//! |---|---|
//! | hex digits, in pairs, either case | `44 46 01 00`, `44460100`, `0x44, 0x46`, `44:46-01_00` |
//! | `xxd` | `00000000: 4446 0100 0000 3000  DF....0.` |
//! | `hexdump -C` | `00000000  44 46 01 00 00 00 30 00  \|DF....0.\|` |
//! | `od -A x -t x1z` | `000000 44 46 01 00 00 00 30 00  >DF....0.<` |
//! | `*`, in a dump | the line before it, again and again up to the next offset |
//! | a comment, also behind hex digits | `// the hello`, `# the hello` |
//! | nothing | ends a dump |
//!
//! **Hex digits.** Blank, tab and `, : ; _ -` separate groups; a group is a whole number of
//! bytes in the order in which they are written, and may begin with `0x`. So `0x0102` is the
//! byte 1, then the byte 2, and `0x1` is an error. A line may be of any length.
//!
//! **Offsets.** 6 to 16 hex digits together, where the line begins, are an offset or data:
//!
//! 1. with a colon and then a blank or the end of the line it is an offset (`xxd`);
//! 2. with single pairs of digits behind it, and a closed text column `|...|` or `>...<` at the
//!    end, it is an offset (`hexdump -C`, `od`);
//! 3. with two blanks and then single pairs, but no text column, it is an offset if it is 0;
//! 4. inside a dump of the kinds 2 and 3 it always is an offset, and alone it ends the dump;
//! 5. six zeros, one blank and then single pairs could be `od -A x -t x1` or data: an error;
//! 6. seven digits are an offset of `hexdump` or `od` without options, whose words or octal
//!    offsets are refused: `hexdump -C` prints what can be read.
//!
//! Anything else is data. [`Format::Hex`] looks for no offsets, [`Format::Xxd`] wants one on
//! each line: either settles what the rules would guess.
//!
//! A dump's line bears no comment, since its text column may look like one.
//!
//! The offsets of a dump must follow each other; a dump begins at any offset, and offset 0 always
//! begins a new one. The two sides, and lines without a mark, count their offsets apart.
//!
//! The text column is never data, and somebody may have edited the bytes beside it. But one as
//! long as other bytes betrays `xxd -b`, and one that shows the words turned round `xxd -e`: both
//! are errors.

mod dump;
mod error;
mod grammar;
mod lines;
mod source;

pub use error::{SourceError, TextError, What};
pub use source::{Format, Piece, Senders, Source};

/// Who sent some bytes.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub enum Side {
    /// The side that controls: mark `>`.
    Host,
    /// The side that moves: mark `<`.
    Device,
}

/// The longest part of a line that is kept, in bytes; a longer line is read in such parts.
pub const MAX_LINE: usize = 64 * 1024;

/// The most bytes that one `*` may stand for, so that a short file cannot mean an endless one.
pub const MAX_REPEAT: u64 = 1024 * 1024;
