//! The values of a message, one after the other.

use motion_core::wire::{FieldView, Fields, Value};

/// Value of a field, of an element of a list, or of a field of a group in a list.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Name of the field.
    pub name: String,
    /// Unit of the field; empty if there is none.
    pub unit: &'static str,
    /// Value on the wire.
    pub leaf: Leaf,
    /// Text of the whole field, without the unit. All elements of a list of numbers share the text of the list.
    pub text: String,
}

/// Value on the wire.
#[derive(Debug, Clone, PartialEq)]
pub enum Leaf {
    /// Unsigned number.
    Unsigned(u64),
    /// Signed number.
    Signed(i64),
    /// Bits of an IEEE-754 binary32.
    Float(u32),
    /// Text.
    Text(Vec<u8>),
    /// Text that is shown only on request.
    Secret(Vec<u8>),
    /// Bytes.
    Bytes(Vec<u8>),
}

/// Values of a message in wire order. Lists and groups are resolved into their values.
#[must_use]
pub fn views(fields: &dyn Fields) -> Vec<View> {
    let mut all = Vec::new();
    fields.fields(&mut |field: &FieldView<'_>| resolve(&mut all, field, field.value));
    all
}

fn resolve(all: &mut Vec<View>, field: &FieldView<'_>, value: Value<'_>) {
    let leaf = match value {
        Value::Unsigned(number) => Leaf::Unsigned(number),
        Value::Signed(number) => Leaf::Signed(number),
        Value::Float(number) => Leaf::Float(number.to_bits()),
        Value::Text(bytes) => Leaf::Text(bytes.to_vec()),
        Value::Secret(bytes) => Leaf::Secret(bytes.to_vec()),
        Value::Bytes(bytes) => Leaf::Bytes(bytes.to_vec()),
        Value::List(list) => return list.each(&mut |item| resolve(all, field, item)),
        Value::Group(group) => return all.extend(views(group)),
    };
    all.push(View { name: field.name.to_owned(), unit: field.unit, leaf, text: field.text.to_string() });
}
