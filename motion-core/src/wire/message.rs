use super::{DecodeError, EncodeError, FieldView, Fields, Rest, Row, Value, Visitor};

/// Body of one kind of message.
///
/// [`message!`](crate::message) implements the trait from a list of fields. Irregular bodies implement it by hand and obey
/// the same laws.
pub trait Message<'a>: Copy + Fields {
    /// Layout of the body: its fields, in wire order.
    const LAYOUT: &'static [Row];

    /// Decodes all of `body`.
    ///
    /// # Errors
    ///
    /// [`DecodeError`], if the body ends before its fields do, or if bytes follow and the message keeps no tail.
    fn decode(body: &'a [u8]) -> Result<Self, DecodeError>;

    /// Decodes a body that came under `number`, for messages with several numbers.
    ///
    /// # Errors
    ///
    /// The errors of [`decode`](Self::decode).
    #[inline]
    fn decode_as(number: u32, body: &'a [u8]) -> Result<Self, DecodeError> {
        let _ = number;
        Self::decode(body)
    }

    /// Number under which the message is sent; `declared` is the one in its table.
    #[inline]
    fn number(&self, declared: u32) -> u32 {
        declared
    }

    /// Number of bytes that [`encode_into`](Self::encode_into) writes.
    fn encoded_len(&self) -> usize;

    /// Writes the body to the front of `out` and returns its length in bytes.
    ///
    /// # Errors
    ///
    /// [`EncodeError`], if the buffer is too small, or if a reader would read another message. Then nothing is
    /// written.
    fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError>;
}

/// Sets the offset of each row to the sum of the sizes before it, up to the first part of variable length.
#[doc(hidden)]
#[must_use]
pub const fn place<const N: usize>(mut rows: [Row; N]) -> [Row; N] {
    use super::PartKind::{Fixed, Optional};
    let mut next = Some(0usize);
    let mut rest: &mut [Row] = &mut rows;
    while let Some((row, behind)) = rest.split_first_mut() {
        row.offset = next;
        next = match (next, row.part) {
            (Some(at), Fixed | Optional) => at.checked_add(row.size),
            _ => None,
        };
        rest = behind;
    }
    rows
}

/// Turns one list of fields, in wire order, into a message: its struct, decoder, encoder, length and layout.
///
/// Fields before the `;` are always present and of fixed size ([`Field`](crate::wire::Field)); each entry after it is a
/// [`Part`](crate::wire::Part). A literal after a type is a unit that the type does not name. A message with a lifetime
/// keeps bytes after the last field in `tail`. For one without, such bytes are an error, and it has fixed fields only.
#[doc(hidden)]
#[macro_export]
macro_rules! message {
    ($(
        $(#[$meta:meta])*
        $vis:vis struct $name:ident $(<$lt:lifetime>)? in $order:ident {
            $($(#[$field_meta:meta])* $field:ident: $field_type:ty $([$field_unit:literal])?,)*
            $(; $($(#[$part_meta:meta])* $part:ident: $part_type:ty $([$part_unit:literal])?,)*)?
        }
    )*) => {$(
        $crate::message! { @shape [$($lt)?]
            [$(#[$meta])* $vis struct $name]
            [$($(#[$field_meta])* pub $field: $field_type,)* $($($(#[$part_meta])* pub $part: $part_type,)*)?]
            $name $order
            { $($field: $field_type, [$($field_unit)?];)* }
            { $($($part: $part_type, [$($part_unit)?];)*)? }
        }
    )*};

    (@shape [] [$($head:tt)*] [$($fields:tt)*] $name:ident $order:ident $fixed:tt $parts:tt) => {
        #[derive(Clone, Copy, PartialEq, Eq, Hash)]
        $($head)* { $($fields)* }

        // `this` and `reader` are passed on, so that both expansions mean the same variables.
        $crate::message! { @code 'm [$name] $name $order $fixed $parts this reader
            tail [{ let _ = this; &[] }]
            keep []
            end [if !reader.rest().is_empty() {
                return Err($crate::wire::DecodeError::Trailing { what: stringify!($name), extra: reader.rest().len() });
            }]
        }
    };
    (@shape [$lt:lifetime] [$($head:tt)*] [$($fields:tt)*] $name:ident $order:ident $fixed:tt $parts:tt) => {
        #[derive(Clone, Copy, PartialEq, Eq, Hash)]
        $($head)*<$lt> {
            $($fields)*
            /// Bytes after the known fields, unchanged.
            pub tail: &$lt [u8],
        }

        $crate::message! { @code $lt [$name<$lt>] $name $order $fixed $parts this reader
            tail [this.tail]
            keep [tail: reader.rest(),]
            end []
        }
    };

    (@code $lt:lifetime [$self:ty] $name:ident $order:ident
        { $($field:ident: $field_type:ty, [$($field_unit:literal)?];)* }
        { $($part:ident: $part_type:ty, [$($part_unit:literal)?];)* }
        $this:ident $reader:ident
        tail [$($tail:tt)*]
        keep [$($keep:tt)*]
        end [$($end:tt)*]
    ) => {
        const _: () = {
            #[allow(unused_imports, reason = "a table may have no field, or no part")]
            use $crate::wire::{self, Field, FieldView, Fields, Message, Part, PartKind, Reader, Row, Visitor, Writer};

            const FIXED: usize = 0 $(+ <$field_type as Field>::SIZE)*;

            #[allow(unused_variables, unused_mut, clippy::unused_self, reason = "a table may have no field, or no part")]
            impl<$lt> Message<$lt> for $self {
                const LAYOUT: &'static [Row] = &wire::place([
                    $(Row {
                        name: stringify!($field),
                        wire: <$field_type as Field>::WIRE,
                        offset: None,
                        size: <$field_type as Field>::SIZE,
                        part: PartKind::Fixed,
                        unit: wire::unit(<$field_type as Field>::UNIT, concat!($($field_unit)?)),
                        element: &[],
                    },)*
                    $(Row {
                        name: stringify!($part),
                        wire: <$part_type as Part<$lt>>::WIRE,
                        offset: None,
                        size: <$part_type as Part<$lt>>::SIZE,
                        part: <$part_type as Part<$lt>>::KIND,
                        unit: wire::unit(<$part_type as Part<$lt>>::UNIT, concat!($($part_unit)?)),
                        element: <$part_type as Part<$lt>>::ELEMENT,
                    },)*
                ]);

                #[inline]
                fn decode(body: &$lt [u8]) -> Result<Self, wire::DecodeError> {
                    let short = wire::DecodeError::Truncated { what: stringify!($name), needed: FIXED, have: body.len() };
                    let Some((fixed, rest)) = body.split_first_chunk::<FIXED>() else { return Err(short) };
                    let mut fixed = Reader::<$crate::zerocopy::$order>::new(fixed);
                    $(let $field = <$field_type as Field>::read(&mut fixed).ok_or(short)?;)*
                    let mut $reader = Reader::<$crate::zerocopy::$order>::new(rest);
                    $(
                        let before = body.len().wrapping_sub($reader.rest().len());
                        let $part = <$part_type as Part<$lt>>::take(&mut $reader).map_err(|needed| wire::DecodeError::Truncated {
                            what: concat!(stringify!($name), ".", stringify!($part)),
                            needed: before.saturating_add(needed),
                            have: body.len(),
                        })?;
                    )*
                    $($end)*
                    Ok(Self { $($field,)* $($part,)* $($keep)* })
                }

                #[inline]
                fn encoded_len(&self) -> usize {
                    let $this = self;
                    let tail: &[u8] = $($tail)*;
                    let len = FIXED.saturating_add(tail.len());
                    $(let len = len.saturating_add(Part::encoded_len(&self.$part));)*
                    len
                }

                #[inline]
                fn encode_into(&self, out: &mut [u8]) -> Result<usize, wire::EncodeError> {
                    let $this = self;
                    let tail: &[u8] = $($tail)*;
                    let mut check = wire::Check::new(tail.len());
                    $(Part::check(&self.$part, concat!(stringify!($name), ".", stringify!($part)), &mut check)?;)*
                    let needed = self.encoded_len();
                    let small = wire::EncodeError::BufferTooSmall { needed, have: out.len() };
                    let out = out.get_mut(..needed).ok_or(small)?;
                    let (fixed, rest) = out.split_first_chunk_mut::<FIXED>().ok_or(small)?;
                    let mut writer = Writer::<$crate::zerocopy::$order>::new(fixed);
                    $(Field::write(&self.$field, &mut writer).ok_or(small)?;)*
                    let mut writer = Writer::<$crate::zerocopy::$order>::new(rest);
                    $(Part::put(&self.$part, &mut writer).ok_or(small)?;)*
                    writer.bytes(tail).ok_or(small)?;
                    Ok(needed)
                }
            }

            #[allow(unused_variables, clippy::unused_self, reason = "a table may have no field, or no part")]
            impl<$lt> Fields for $self {
                fn fields(&self, visitor: &mut dyn Visitor) {
                    $(visitor.visit(&FieldView {
                        name: stringify!($field),
                        unit: wire::unit(<$field_type as Field>::UNIT, concat!($($field_unit)?)),
                        value: Field::value(&self.$field),
                        text: &self.$field,
                    });)*
                    $(Part::visit(
                        &self.$part,
                        stringify!($part),
                        wire::unit(<$part_type as Part<$lt>>::UNIT, concat!($($part_unit)?)),
                        visitor,
                    );)*
                    let $this = self;
                    wire::visit_tail($($tail)*, visitor);
                }
            }

            // The text is bounded like that of `Display`. A derived `Debug` could panic.
            impl<$lt> core::fmt::Debug for $self {
                fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                    wire::print::message(f, stringify!($name), self)
                }
            }

            $crate::__message_features! { $lt [$self] $name }
            $crate::__defmt! {
                message $lt [$self] $name { $($field: $field_type,)* $($part: $part_type,)* } $this [$($tail)*]
            }
        };
    };
}

/// Unit that a table states, or the unit of the type if the table states none.
#[doc(hidden)]
#[must_use]
pub const fn unit(of_type: &'static str, of_table: &'static str) -> &'static str {
    if of_table.is_empty() { of_type } else { of_table }
}

/// Shows the tail to a visitor, unless it is empty.
#[doc(hidden)]
pub fn visit_tail(tail: &[u8], visitor: &mut dyn Visitor) {
    if !tail.is_empty() {
        visitor.visit(&FieldView { name: "tail", unit: "", value: Value::Bytes(tail), text: &Rest(tail) });
    }
}

message! {
    /// A message without fields.
    pub struct Empty<'a> in BE {}
}
