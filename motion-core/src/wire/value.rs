use core::fmt;

/// One row of a layout: a field, where it stands, and what it means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row {
    /// Its name, the same in code, documents and JSON.
    pub name: &'static str,
    /// Its type on the wire: `u16`, `i32`, `f32`, `[u8; 6]`.
    pub wire: &'static str,
    /// Bytes from the start of the body; `None` behind a part of variable length.
    pub offset: Option<usize>,
    /// Bytes it takes; of a list, the bytes of one element; of a text or block, those of its length field.
    pub size: usize,
    /// What kind of part it is.
    pub part: PartKind,
    /// Its unit, or nothing: `steps`, `ms`, `rev/s`.
    pub unit: &'static str,
    /// Of a list of groups, the layout of one element.
    pub element: &'static [Row],
}

/// The kinds of parts that bodies are made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PartKind {
    /// Always there, of fixed size.
    Fixed,
    /// Left out, with all that follows it, by older peers.
    Optional,
    /// As many elements as the body holds.
    List,
    /// A `u8` that counts the elements, and these.
    Counted,
    /// A `u16` that counts bytes, and these, a text.
    Text16,
    /// A `u16` that counts bytes, and these.
    Block16,
    /// All the rest of the body.
    Rest,
}

/// The raw value of a field, as it stands on the wire.
#[derive(Clone, Copy)]
pub enum Value<'a> {
    /// A number without sign, a flag word, an open enum.
    Unsigned(u64),
    /// A number with sign.
    Signed(i64),
    /// An IEEE-754 binary32, every bit kept.
    Float(f32),
    /// A text, mostly UTF-8.
    Text(&'a [u8]),
    /// A text that is not to be shown unless asked for.
    Secret(&'a [u8]),
    /// Bytes without further structure.
    Bytes(&'a [u8]),
    /// Several values of one kind.
    List(&'a dyn List),
    /// Several named values.
    Group(&'a dyn Fields),
}

/// A field of a message, as a [`Visitor`] sees it.
#[derive(Clone, Copy)]
pub struct FieldView<'a> {
    /// Its name, the same as in [`Row`].
    pub name: &'static str,
    /// Its unit, or nothing.
    pub unit: &'static str,
    /// What stands on the wire.
    pub value: Value<'a>,
    /// What a person reads, without the unit: names of open enums and flags, decimals of scaled numbers.
    pub text: &'a dyn fmt::Display,
}

/// Sees the fields of a message one by one, in wire order.
pub trait Visitor {
    /// Sees a field. Optional fields that are absent are not seen.
    fn visit(&mut self, field: &FieldView<'_>);
}

impl<F: FnMut(&FieldView<'_>)> Visitor for F {
    fn visit(&mut self, field: &FieldView<'_>) {
        self(field);
    }
}

/// What has named fields: every message, and every group in a list.
///
/// Printing, JSON and the laws are written once against this.
pub trait Fields {
    /// Shows all fields to `visitor`, in wire order; an unknown tail, if there is one, last, under the name `tail`.
    fn fields(&self, visitor: &mut dyn Visitor);
}

/// What holds several values of one kind.
pub trait List {
    /// Shows them in order.
    fn each(&self, item: &mut dyn FnMut(Value<'_>));
}
