//! What bodies are made of: fields, parts, and the tables that turn a list of them into a message.
//!
//! A message is one list of fields, in wire order, in one place: the `message!` table makes of it the struct with its
//! public fields, its decoder, its encoder, its length and its [layout](Row) as data. A second table a side,
//! `messages!`, says number, variant and [conduct](Conduct) once, and makes the enum of that side. Both macros are for the protocol crates
//! and outside any promise of stability.
//!
//! - [`Field`]: a value of fixed size. Units, open enums and flags are types that implement it.
//! - [`Part`]: what may follow the fixed fields: optional fields, lists, counted lists, texts and blocks.
//! - [`Message`], [`Messages`], [`Side`]: one body; all bodies of one side; the side itself. [`Envelope`] and [`Framed`]: how
//!   bodies travel in frames.
//! - `draw`, with the feature `arbitrary`: messages for fuzzers.
//! - [`fill`], [`values`]: numbers into a list field, and back.
//! - [`Fields`], [`Visitor`]: the values of a message by name, for printing, JSON and the laws.

mod conduct;
mod cursor;
#[cfg(feature = "arbitrary")]
mod draw;
mod error;
#[allow(dead_code, unreachable_pub, reason = "tables expanded for the lints and the tests")]
mod expand;
mod features;
mod field;
mod list;
mod message;
mod messages;
mod newtype;
mod part;
pub mod print;
mod side;
mod value;

#[doc(hidden)]
pub use bitflags;
pub use conduct::{Conduct, Purpose};
pub use cursor::{Reader, Writer};
#[cfg(feature = "arbitrary")]
pub use draw::draw_borrowed;
pub use error::{DecodeError, EncodeError};
pub use field::{Bool, Bytes, Field};
pub use list::{IntegerElement, ListTooLong, fill, values};
pub use message::{Empty, Message};
#[doc(hidden)]
pub use message::{place, unit, visit_tail};
#[doc(hidden)]
pub use messages::big_endian;
pub use messages::{Kind, Messages, Other};
#[doc(hidden)]
pub use newtype::{from_array, to_array};
pub use part::{Block16, Check, Counted, Element, Newer, Part, Password, Rest, Text16, trim_nuls};
pub use side::{Envelope, Framed, Side};
pub use value::{FieldView, Fields, List, PartKind, Row, Value, Visitor};
