use core::fmt;

/// One row of a layout: a field, its place and its meaning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row {
    /// Name of the field, the same in code, documents and JSON.
    pub name: &'static str,
    /// Type on the wire: `u16`, `i32`, `f32`, `[u8; 6]`.
    pub wire: &'static str,
    /// Offset from the start of the body in bytes; `None` after a part of variable length.
    pub offset: Option<usize>,
    /// Size in bytes: of a list, that of one element; of a text or block, that of its length field.
    pub size: usize,
    /// Kind of the part.
    pub part: PartKind,
    /// Unit, such as `steps`, `ms`, `rev/s`; empty if there is none.
    pub unit: &'static str,
    /// Layout of one element of a list of groups; empty for every other row.
    pub element: &'static [Row],
}

/// Kind of a part of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PartKind {
    /// Field of fixed size that is always present.
    Fixed,
    /// Field that older peers leave out, with all fields after it.
    Optional,
    /// List of as many elements as the body holds.
    List,
    /// List after a `u8` that counts its elements.
    Counted,
    /// Text after a `u16` that counts its bytes.
    Text16,
    /// Block of bytes after a `u16` that counts them.
    Block16,
    /// All bytes that are left of the body.
    Rest,
}

/// Raw value of a field, as it stands on the wire.
#[derive(Clone, Copy)]
pub enum Value<'a> {
    /// Unsigned number, word of flags, or open enum.
    Unsigned(u64),
    /// Signed number.
    Signed(i64),
    /// IEEE-754 binary32, with every bit.
    Float(f32),
    /// Text, mostly UTF-8.
    Text(&'a [u8]),
    /// Text that is shown only on request.
    Secret(&'a [u8]),
    /// Bytes without further structure.
    Bytes(&'a [u8]),
    /// List of values of one kind.
    List(&'a dyn List),
    /// Group of named values.
    Group(&'a dyn Fields),
}

/// Field of a message, as a [`Visitor`] sees it.
#[derive(Clone, Copy)]
pub struct FieldView<'a> {
    /// Name of the field, the same as in [`Row`].
    pub name: &'static str,
    /// Unit; empty if there is none.
    pub unit: &'static str,
    /// Value as it stands on the wire.
    pub value: Value<'a>,
    /// Value as a person reads it, without the unit: names of open enums and flags, decimals of scaled numbers.
    pub text: &'a dyn fmt::Display,
}

/// Visitor that sees the fields of a message one by one, in wire order.
pub trait Visitor {
    /// Sees a field. Optional fields that are absent are not seen.
    fn visit(&mut self, field: &FieldView<'_>);
}

impl<F: FnMut(&FieldView<'_>)> Visitor for F {
    fn visit(&mut self, field: &FieldView<'_>) {
        self(field);
    }
}

/// Type with named fields: every message, and every group in a list.
///
/// Printing, JSON and the laws are written once, against this trait.
pub trait Fields {
    /// Shows all fields to `visitor`, in wire order. A tail that is not empty comes last, under the name `tail`.
    fn fields(&self, visitor: &mut dyn Visitor);
}

/// Type that holds several values of one kind.
pub trait List {
    /// Shows the values in order.
    fn each(&self, item: &mut dyn FnMut(Value<'_>));
}
