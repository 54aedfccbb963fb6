use core::fmt;

use zerocopy::{ByteOrder, FromBytes, I16, I32, Immutable, IntoBytes, KnownLayout, U16, U32, Unaligned};

use super::{EncodeError, Field, FieldView, List, PartKind, Reader, Row, Value, Visitor, Writer, print};

/// Part of a body after the fixed fields: optional, or of variable length.
pub trait Part<'a>: Copy {
    /// Kind of the part.
    const KIND: PartKind;
    /// Type on the wire, as documents name it.
    const WIRE: &'static str;
    /// Size in bytes: of a field, its own; of a list, that of one element; of a text or block, that of its length field.
    const SIZE: usize;
    /// Unit; empty if there is none.
    const UNIT: &'static str = "";
    /// Layout of one element of a list of groups; empty for every other part.
    const ELEMENT: &'static [Row] = &[];

    /// Takes the part off the front of the bytes that are left.
    ///
    /// # Errors
    ///
    /// Number of bytes, counted from the first byte of the part, that would have been needed.
    fn take<O: ByteOrder>(reader: &mut Reader<'a, O>) -> Result<Self, usize>;

    /// Checks that the part can be written, and that a reader would read the same part back.
    ///
    /// # Errors
    ///
    /// [`EncodeError`], naming the part `what`.
    fn check(&self, what: &'static str, check: &mut Check) -> Result<(), EncodeError>;

    /// Length of the part in bytes.
    fn encoded_len(&self) -> usize;

    /// Writes the part; `None` if it does not fit.
    fn put<O: ByteOrder>(&self, writer: &mut Writer<'_, O>) -> Option<()>;

    /// Shows the part to a visitor, unless it is absent.
    fn visit(&self, name: &'static str, unit: &'static str, visitor: &mut dyn Visitor);

    /// Logs the part.
    #[cfg(feature = "defmt")]
    #[doc(hidden)]
    fn log_part(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "..");
    }
}

/// State of an encoder that checks the parts of a message one after another.
#[derive(Debug, Clone, Copy)]
pub struct Check {
    tail: usize,
    absent: bool,
}

impl Check {
    /// State before the first part of a message with `tail` bytes of tail.
    #[must_use]
    pub const fn new(tail: usize) -> Self {
        Self { tail, absent: false }
    }

    /// Notes a field that is present.
    const fn present(&self, what: &'static str) -> Result<(), EncodeError> {
        if self.absent { Err(EncodeError::Hole { what }) } else { Ok(()) }
    }

    /// Notes a part that a reader would find in a tail of `size` bytes or more.
    const fn swallows(&self, what: &'static str, size: usize) -> Result<(), EncodeError> {
        if self.tail < size { Ok(()) } else { Err(EncodeError::Tail { what, len: self.tail }) }
    }

    /// Notes a field that is absent, which a reader would find in a tail of `size` bytes or more.
    const fn absent(&mut self, what: &'static str, size: usize) -> Result<(), EncodeError> {
        if self.absent {
            return Ok(());
        }
        self.absent = true;
        self.swallows(what, size)
    }
}

fn at_most(what: &'static str, len: usize, max: usize) -> Result<(), EncodeError> {
    if len <= max { Ok(()) } else { Err(EncodeError::TooLong { what, len, max }) }
}

/// A fixed field after a part of variable length.
impl<'a, T: Field> Part<'a> for T {
    const KIND: PartKind = PartKind::Fixed;
    const WIRE: &'static str = T::WIRE;
    const SIZE: usize = T::SIZE;
    const UNIT: &'static str = T::UNIT;

    #[inline]
    fn take<O: ByteOrder>(reader: &mut Reader<'a, O>) -> Result<Self, usize> {
        T::read(reader).ok_or(T::SIZE)
    }

    #[inline]
    fn check(&self, what: &'static str, check: &mut Check) -> Result<(), EncodeError> {
        check.present(what)
    }

    #[inline]
    fn encoded_len(&self) -> usize {
        T::SIZE
    }

    #[inline]
    fn put<O: ByteOrder>(&self, writer: &mut Writer<'_, O>) -> Option<()> {
        T::write(self, writer)
    }

    fn visit(&self, name: &'static str, unit: &'static str, visitor: &mut dyn Visitor) {
        visitor.visit(&FieldView { name, unit, value: self.value(), text: self });
    }

    #[cfg(feature = "defmt")]
    fn log_part(&self, f: defmt::Formatter<'_>) {
        self.log(f);
    }
}

/// A field that older peers leave out. If the body ends inside it, the bytes belong to the tail.
impl<'a, T: Field> Part<'a> for Option<T> {
    const KIND: PartKind = PartKind::Optional;
    const WIRE: &'static str = T::WIRE;
    const SIZE: usize = T::SIZE;
    const UNIT: &'static str = T::UNIT;

    #[inline]
    fn take<O: ByteOrder>(reader: &mut Reader<'a, O>) -> Result<Self, usize> {
        if reader.is_closed() {
            return Ok(None);
        }
        let field = T::read(reader);
        if field.is_none() {
            reader.close();
        }
        Ok(field)
    }

    #[inline]
    fn check(&self, what: &'static str, check: &mut Check) -> Result<(), EncodeError> {
        if self.is_some() { check.present(what) } else { check.absent(what, T::SIZE) }
    }

    #[inline]
    fn encoded_len(&self) -> usize {
        if self.is_some() { T::SIZE } else { 0 }
    }

    #[inline]
    fn put<O: ByteOrder>(&self, writer: &mut Writer<'_, O>) -> Option<()> {
        self.as_ref().map_or(Some(()), |field| field.write(writer))
    }

    fn visit(&self, name: &'static str, unit: &'static str, visitor: &mut dyn Visitor) {
        if let Some(field) = self {
            field.visit(name, unit, visitor);
        }
    }

    #[cfg(feature = "defmt")]
    fn log_part(&self, f: defmt::Formatter<'_>) {
        crate::format::optional(f, *self);
    }
}

/// A field that a newer dialect adds at the end: the body either ends before the field or holds all of it.
///
/// Unlike for an [`Option`], a body that ends inside the field is an error, because no dialect ends there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(transparent)]
pub struct Newer<T>(pub Option<T>);

// A derived one would ask for a default of `T`.
impl<T> Default for Newer<T> {
    /// The field is absent.
    fn default() -> Self {
        Self(None)
    }
}

impl<'a, T: Field> Part<'a> for Newer<T> {
    const KIND: PartKind = PartKind::Optional;
    const WIRE: &'static str = T::WIRE;
    const SIZE: usize = T::SIZE;
    const UNIT: &'static str = T::UNIT;

    #[inline]
    fn take<O: ByteOrder>(reader: &mut Reader<'a, O>) -> Result<Self, usize> {
        if reader.rest().is_empty() {
            return Ok(Self(None));
        }
        T::read(reader).map(|field| Self(Some(field))).ok_or(T::SIZE)
    }

    #[inline]
    fn check(&self, what: &'static str, check: &mut Check) -> Result<(), EncodeError> {
        if self.0.is_some() { check.present(what) } else { check.absent(what, 1) }
    }

    #[inline]
    fn encoded_len(&self) -> usize {
        self.0.encoded_len()
    }

    #[inline]
    fn put<O: ByteOrder>(&self, writer: &mut Writer<'_, O>) -> Option<()> {
        self.0.put(writer)
    }

    fn visit(&self, name: &'static str, unit: &'static str, visitor: &mut dyn Visitor) {
        self.0.visit(name, unit, visitor);
    }

    #[cfg(feature = "defmt")]
    fn log_part(&self, f: defmt::Formatter<'_>) {
        crate::format::optional(f, self.0);
    }
}

/// Element of a list: a type of alignment one, so that the same slice type views received bytes and builds messages.
pub trait Element: FromBytes + IntoBytes + Immutable + KnownLayout + Unaligned + Copy + Eq + fmt::Debug {
    /// Type on the wire, as documents name it.
    const WIRE: &'static str;
    /// Layout of the element, if it is a group of fields.
    const ROWS: &'static [Row] = &[];
    /// Name of the number that counts such elements, in a counted list.
    const COUNT: &'static str = "count";

    /// Raw value, as it stands on the wire.
    fn value(&self) -> Value<'_>;
}

impl Element for u8 {
    const WIRE: &'static str = "u8";

    fn value(&self) -> Value<'_> {
        Field::value(self)
    }
}

macro_rules! ordered_elements {
    ($($element:ident, $wire:literal, $value:ident;)*) => {$(
        impl<O: ByteOrder + Eq> Element for $element<O> {
            const WIRE: &'static str = $wire;

            fn value(&self) -> Value<'_> {
                Value::$value(self.get().into())
            }
        }
    )*};
}
ordered_elements! {
    U16, "u16", Unsigned;
    I16, "i16", Signed;
    U32, "u32", Unsigned;
    I32, "i32", Signed;
}

impl<T: Element> List for &[T] {
    fn each(&self, item: &mut dyn FnMut(Value<'_>)) {
        for element in *self {
            item(element.value());
        }
    }
}

impl<T: Element, const N: usize> List for [T; N] {
    fn each(&self, item: &mut dyn FnMut(Value<'_>)) {
        for element in self {
            item(element.value());
        }
    }
}

/// As many whole elements as the body holds. Bytes that are left over belong to the tail.
impl<'a, T: Element> Part<'a> for &'a [T] {
    const KIND: PartKind = PartKind::List;
    const WIRE: &'static str = T::WIRE;
    const SIZE: usize = size_of::<T>();
    const ELEMENT: &'static [Row] = T::ROWS;

    #[inline]
    fn take<O: ByteOrder>(reader: &mut Reader<'a, O>) -> Result<Self, usize> {
        let count = reader.rest().len().checked_div(size_of::<T>()).unwrap_or(0);
        reader.elements(count).ok_or(0)
    }

    #[inline]
    fn check(&self, what: &'static str, check: &mut Check) -> Result<(), EncodeError> {
        check.present(what)?;
        check.swallows(what, size_of::<T>())
    }

    #[inline]
    fn encoded_len(&self) -> usize {
        size_of_val(*self)
    }

    #[inline]
    fn put<O: ByteOrder>(&self, writer: &mut Writer<'_, O>) -> Option<()> {
        writer.bytes(self.as_bytes())
    }

    fn visit(&self, name: &'static str, unit: &'static str, visitor: &mut dyn Visitor) {
        visitor.visit(&FieldView { name, unit, value: Value::List(self), text: &print::ListText(self) });
    }

    #[cfg(feature = "defmt")]
    fn log_part(&self, f: defmt::Formatter<'_>) {
        crate::format::bytes(f, self.as_bytes());
    }
}

/// List whose elements are counted by a `u8` before them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(transparent)]
pub struct Counted<'a, T>(pub &'a [T]);

impl<T> Default for Counted<'_, T> {
    /// The list is empty.
    fn default() -> Self {
        Self(&[])
    }
}

impl<'a, T: Element> Part<'a> for Counted<'a, T> {
    const KIND: PartKind = PartKind::Counted;
    const WIRE: &'static str = T::WIRE;
    const SIZE: usize = size_of::<T>();
    const ELEMENT: &'static [Row] = T::ROWS;

    #[inline]
    fn take<O: ByteOrder>(reader: &mut Reader<'a, O>) -> Result<Self, usize> {
        let count = u8::read(reader).ok_or(1usize)?;
        let count = usize::from(count);
        reader.elements(count).map(Self).ok_or(count.saturating_mul(size_of::<T>()).saturating_add(1))
    }

    #[inline]
    fn check(&self, what: &'static str, check: &mut Check) -> Result<(), EncodeError> {
        check.present(what)?;
        at_most(what, self.0.len(), u8::MAX.into())
    }

    #[inline]
    fn encoded_len(&self) -> usize {
        size_of_val(self.0).saturating_add(1)
    }

    #[inline]
    fn put<O: ByteOrder>(&self, writer: &mut Writer<'_, O>) -> Option<()> {
        u8::try_from(self.0.len()).ok()?.write(writer)?;
        writer.bytes(self.0.as_bytes())
    }

    fn visit(&self, name: &'static str, unit: &'static str, visitor: &mut dyn Visitor) {
        let count = self.0.len();
        let value = Value::Unsigned(u64::try_from(count).unwrap_or(u64::MAX));
        visitor.visit(&FieldView { name: T::COUNT, unit: "", value, text: &count });
        self.0.visit(name, unit, visitor);
    }

    #[cfg(feature = "defmt")]
    fn log_part(&self, f: defmt::Formatter<'_>) {
        crate::format::bytes(f, self.0.as_bytes());
    }
}

/// Takes a `u16` length and as many bytes.
fn prefixed<'a, O: ByteOrder>(reader: &mut Reader<'a, O>) -> Result<&'a [u8], usize> {
    let len = u16::read(reader).ok_or(2usize)?;
    reader.take(len.into()).ok_or(usize::from(len).saturating_add(2))
}

/// Writes a `u16` length and `bytes`.
fn write_prefixed<O: ByteOrder>(bytes: &[u8], writer: &mut Writer<'_, O>) -> Option<()> {
    u16::try_from(bytes.len()).ok()?.write(writer)?;
    writer.bytes(bytes)
}

macro_rules! prefixed_parts {
    ($($(#[$meta:meta])* $name:ident, $kind:ident, $value:ident, |$this:ident| $shown:expr, $text:expr;)*) => {$(
        $(#[$meta])*
        #[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
        #[repr(transparent)]
        pub struct $name<'a>(pub &'a [u8]);

        impl<'a> Part<'a> for $name<'a> {
            const KIND: PartKind = PartKind::$kind;
            const WIRE: &'static str = "u16 + bytes";
            const SIZE: usize = 2;

            #[inline]
            fn take<O: ByteOrder>(reader: &mut Reader<'a, O>) -> Result<Self, usize> {
                prefixed(reader).map(Self)
            }

            #[inline]
            fn check(&self, what: &'static str, check: &mut Check) -> Result<(), EncodeError> {
                check.present(what)?;
                at_most(what, self.0.len(), u16::MAX.into())
            }

            #[inline]
            fn encoded_len(&self) -> usize {
                self.0.len().saturating_add(2)
            }

            #[inline]
            fn put<O: ByteOrder>(&self, writer: &mut Writer<'_, O>) -> Option<()> {
                write_prefixed(self.0, writer)
            }

            fn visit(&self, name: &'static str, unit: &'static str, visitor: &mut dyn Visitor) {
                let $this = self;
                visitor.visit(&FieldView { name, unit, value: Value::$value($shown), text: self });
            }

            #[cfg(feature = "defmt")]
            fn log_part(&self, f: defmt::Formatter<'_>) {
                let $this = self;
                crate::format::value(f, Value::$value($shown));
            }
        }

        #[cfg(feature = "defmt")]
        impl defmt::Format for $name<'_> {
            fn format(&self, f: defmt::Formatter<'_>) {
                self.log_part(f);
            }
        }

        impl fmt::Display for $name<'_> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                let $this = self;
                $text(f, $shown)
            }
        }

        impl fmt::Debug for $name<'_> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, concat!(stringify!($name), "({})"), self)
            }
        }
    )*};
}
prefixed_parts! {
    /// Text after a `u16` that counts its bytes.
    Text16, Text16, Text, |this| this.without_nuls(), print::text;
    /// Password: on the wire a [`Text16`], but printed and shown only on request.
    Password, Text16, Secret, |this| Text16(this.0).without_nuls(), print::secret;
    /// Block of bytes after a `u16` that counts them.
    Block16, Block16, Bytes, |this| this.0, print::hex;
}

impl<'a> Text16<'a> {
    /// Bytes of the text, without the NULs at the end.
    #[must_use]
    pub fn without_nuls(self) -> &'a [u8] {
        trim_nuls(self.0)
    }

    /// The text without the NULs at the end, if it is UTF-8.
    #[must_use]
    pub fn as_str(self) -> Option<&'a str> {
        core::str::from_utf8(self.without_nuls()).ok()
    }
}

impl<'a> Password<'a> {
    /// The text without the NULs at the end, if it is UTF-8.
    #[must_use]
    pub fn as_str(self) -> Option<&'a str> {
        Text16(self.0).as_str()
    }
}

/// Returns `text` without the NULs at its end.
#[must_use]
pub fn trim_nuls(mut text: &[u8]) -> &[u8] {
    while let [rest @ .., 0] = text {
        text = rest;
    }
    text
}

/// All bytes that are left of a body.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
#[repr(transparent)]
pub struct Rest<'a>(pub &'a [u8]);

impl<'a> Part<'a> for Rest<'a> {
    const KIND: PartKind = PartKind::Rest;
    const WIRE: &'static str = "bytes";
    const SIZE: usize = 1;

    #[inline]
    fn take<O: ByteOrder>(reader: &mut Reader<'a, O>) -> Result<Self, usize> {
        reader.take(reader.rest().len()).map(Self).ok_or(0)
    }

    #[inline]
    fn check(&self, what: &'static str, check: &mut Check) -> Result<(), EncodeError> {
        check.present(what)?;
        check.swallows(what, 1)
    }

    #[inline]
    fn encoded_len(&self) -> usize {
        self.0.len()
    }

    #[inline]
    fn put<O: ByteOrder>(&self, writer: &mut Writer<'_, O>) -> Option<()> {
        writer.bytes(self.0)
    }

    fn visit(&self, name: &'static str, unit: &'static str, visitor: &mut dyn Visitor) {
        visitor.visit(&FieldView { name, unit, value: Value::Bytes(self.0), text: self });
    }

    #[cfg(feature = "defmt")]
    fn log_part(&self, f: defmt::Formatter<'_>) {
        crate::format::bytes(f, self.0);
    }
}

impl fmt::Display for Rest<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        print::hex(f, self.0)
    }
}

impl fmt::Debug for Rest<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Rest({self})")
    }
}
