use zerocopy::ByteOrder;

use super::{Field, Reader, Writer};

/// Makes a number with named values and room for unnamed ones: an open enum.
///
/// Every number of the representation is a value, so decoding loses nothing, and a number can get a name in a later
/// version without breaking code. `Display` and `Debug` print the name, or the number if it has no name.
#[doc(hidden)]
#[macro_export]
macro_rules! open_enum {
    ($(
        $(#[$meta:meta])*
        $vis:vis struct $name:ident($repr:ident) { $($(#[$value_meta:meta])* $value:ident = $number:literal,)* }
    )*) => {$(
        $(#[$meta])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
        #[repr(transparent)]
        $vis struct $name(pub $repr);

        impl $name {
            $($(#[$value_meta])* pub const $value: Self = Self($number);)*

            /// Name of the value, if it has one.
            #[must_use]
            pub const fn name(self) -> Option<&'static str> {
                match self.0 {
                    $($number => Some(stringify!($value)),)*
                    _ => None,
                }
            }
        }

        impl core::fmt::Display for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                match self.name() {
                    Some(name) => f.write_str(name),
                    None => write!(f, "{}", self.0),
                }
            }
        }

        $crate::__newtype! { @field $name($repr) "" }
        $crate::__defmt! { open_enum $name($repr) { $($value = $number,)* } }
    )*};
}

/// Makes a type for a number with a meaning and, mostly, a unit, so that different quantities cannot be mixed up. Its text is
/// the number alone, in both directions.
///
/// IEEE numbers compare and hash by their bits, so that NaN survives a round trip like any other value.
#[doc(hidden)]
#[macro_export]
macro_rules! unit {
    () => {};
    ($(#[$meta:meta])* $vis:vis struct $name:ident(f32) $unit:literal; $($more:tt)*) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Default)]
        #[repr(transparent)]
        $vis struct $name(pub f32);

        impl $name {
            /// The number without its type.
            #[must_use]
            pub const fn get(self) -> f32 {
                self.0
            }
        }

        impl PartialEq for $name {
            fn eq(&self, other: &Self) -> bool {
                self.0.to_bits() == other.0.to_bits()
            }
        }

        impl Eq for $name {}

        impl core::hash::Hash for $name {
            fn hash<H: core::hash::Hasher>(&self, state: &mut H) {
                self.0.to_bits().hash(state);
            }
        }

        impl core::fmt::Display for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                $crate::wire::print::float(f, self.0)
            }
        }

        impl core::fmt::Debug for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                write!(f, concat!(stringify!($name), "({})"), self)
            }
        }

        impl core::str::FromStr for $name {
            type Err = $crate::parse::ParseError;

            /// Reads the number without its unit.
            fn from_str(text: &str) -> Result<Self, Self::Err> {
                $crate::parse::Number::parse(text)
                    .map(Self)
                    .map_err(|why| $crate::parse::ParseError { what: stringify!($name), why: why.into() })
            }
        }

        impl From<f32> for $name {
            fn from(number: f32) -> Self {
                Self(number)
            }
        }

        $crate::__serde_value! { $name(f32) }

        impl $crate::wire::Field for $name {
            const SIZE: usize = 4;
            const WIRE: &'static str = "f32";
            const UNIT: &'static str = $unit;

            #[inline]
            fn read<O: $crate::zerocopy::ByteOrder>(reader: &mut $crate::wire::Reader<'_, O>) -> Option<Self> {
                <u32 as $crate::wire::Field>::read(reader).map(|bits| Self(f32::from_bits(bits)))
            }

            #[inline]
            fn write<O: $crate::zerocopy::ByteOrder>(&self, writer: &mut $crate::wire::Writer<'_, O>) -> Option<()> {
                $crate::wire::Field::write(&self.0.to_bits(), writer)
            }

            fn value(&self) -> $crate::wire::Value<'_> {
                $crate::wire::Value::Float(self.0)
            }

            $crate::__defmt! { log }
        }

        $crate::__defmt! { newtype $name(f32) }

        $crate::unit! { $($more)* }
    };
    ($(#[$meta:meta])* $vis:vis struct $name:ident($repr:ty) $unit:literal; $($more:tt)*) => {
        $(#[$meta])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
        #[repr(transparent)]
        $vis struct $name(pub $repr);

        impl $name {
            /// The number without its type.
            #[must_use]
            pub const fn get(self) -> $repr {
                self.0
            }
        }

        impl core::fmt::Display for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                core::fmt::Display::fmt(&self.0, f)
            }
        }

        impl core::str::FromStr for $name {
            type Err = $crate::parse::ParseError;

            /// Reads the number without its unit.
            fn from_str(text: &str) -> Result<Self, Self::Err> {
                $crate::parse::Number::parse(text)
                    .map(Self)
                    .map_err(|why| $crate::parse::ParseError { what: stringify!($name), why: why.into() })
            }
        }

        $crate::__newtype! { $name($repr) $unit }
        $crate::unit! { $($more)* }
    };
}

/// Makes a set of flags whose unknown bits are kept.
#[doc(hidden)]
#[macro_export]
macro_rules! flags {
    ($(
        $(#[$meta:meta])*
        $vis:vis struct $name:ident($repr:ident) { $($(#[$($flag_meta:tt)*])* $flag:ident = $bits:literal,)* }
    )*) => {$(
        $(#[$meta])*
        #[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
        #[repr(transparent)]
        $vis struct $name(pub $repr);

        $crate::wire::bitflags::bitflags! {
            impl $name: $repr {
                $($(#[$($flag_meta)*])* const $flag = $bits;)*
                const _ = !0;
            }
        }

        impl core::fmt::Display for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                if self.is_empty() {
                    return f.write_str("none");
                }
                let mut separator = "";
                let mut names = self.iter_names();
                for (name, _) in &mut names {
                    f.write_str(separator)?;
                    f.write_str(name)?;
                    separator = " | ";
                }
                let unknown = names.remaining().bits();
                if unknown == 0 { Ok(()) } else { write!(f, "{separator}{unknown:#x}") }
            }
        }

        $crate::__newtype! { $name($repr) "" }
    )*};
}

/// Makes the implementations that every newtype over a field has: `Debug`, `From` and `Field`.
#[doc(hidden)]
#[macro_export]
macro_rules! __newtype {
    ($name:ident($repr:ty) $unit:literal) => {
        $crate::__newtype! { @field $name($repr) $unit }
        $crate::__defmt! { newtype $name($repr) }
    };
    (@field $name:ident($repr:ty) $unit:literal) => {
        $crate::__serde_value! { $name($repr) }

        impl core::fmt::Debug for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                write!(f, concat!(stringify!($name), "({})"), self)
            }
        }

        impl From<$repr> for $name {
            fn from(number: $repr) -> Self {
                Self(number)
            }
        }

        impl $crate::wire::Field for $name {
            const SIZE: usize = <$repr as $crate::wire::Field>::SIZE;
            const WIRE: &'static str = <$repr as $crate::wire::Field>::WIRE;
            const UNIT: &'static str = $unit;

            #[inline]
            fn read<O: $crate::zerocopy::ByteOrder>(reader: &mut $crate::wire::Reader<'_, O>) -> Option<Self> {
                <$repr as $crate::wire::Field>::read(reader).map(Self)
            }

            #[inline]
            fn write<O: $crate::zerocopy::ByteOrder>(&self, writer: &mut $crate::wire::Writer<'_, O>) -> Option<()> {
                $crate::wire::Field::write(&self.0, writer)
            }

            fn value(&self) -> $crate::wire::Value<'_> {
                $crate::wire::Field::value(&self.0)
            }

            $crate::__defmt! { log }
        }
    };
}

/// Bytes of a field; `N` is its size.
#[doc(hidden)]
#[must_use]
#[inline]
pub fn to_array<O: ByteOrder, T: Field, const N: usize>(field: T) -> [u8; N] {
    let mut bytes = [0; N];
    let written = field.write(&mut Writer::<O>::new(&mut bytes));
    debug_assert_eq!((written, N), (Some(()), T::SIZE), "an element stores each field in its own size");
    bytes
}

/// Field that these bytes hold; `N` is its size.
#[doc(hidden)]
#[must_use]
#[inline]
pub fn from_array<O: ByteOrder, T: Field, const N: usize>(bytes: &[u8; N]) -> T {
    T::read(&mut Reader::<O>::new(bytes)).unwrap_or_default()
}

/// Makes a group of fixed fields that can be the element of a list. It has alignment one, so that a list of groups is a
/// slice of the received bytes.
#[doc(hidden)]
#[macro_export]
macro_rules! element {
    ($(
        $(#[$meta:meta])*
        $vis:vis struct $name:ident in $order:ident, $count:literal {
            $($(#[$field_meta:meta])* $field:ident: $type:ty $([$unit:literal])?,)*
        }
    )*) => {$(
        $(#[$meta])*
        #[derive(
            Clone, Copy, PartialEq, Eq, Hash,
            $crate::zerocopy::FromBytes,
            $crate::zerocopy::IntoBytes,
            $crate::zerocopy::Immutable,
            $crate::zerocopy::KnownLayout,
            $crate::zerocopy::Unaligned,
        )]
        #[repr(C)]
        $vis struct $name {
            $($field: [u8; <$type as $crate::wire::Field>::SIZE],)*
        }

        impl $name {
            /// Makes a group from its fields.
            #[must_use]
            #[inline]
            pub fn new($($field: $type),*) -> Self {
                Self {
                    $($field: $crate::wire::to_array::<$crate::zerocopy::$order, $type, { <$type as $crate::wire::Field>::SIZE }>($field),)*
                }
            }

            $($(#[$field_meta])*
            #[must_use]
            #[inline]
            pub fn $field(&self) -> $type {
                $crate::wire::from_array::<$crate::zerocopy::$order, $type, { <$type as $crate::wire::Field>::SIZE }>(&self.$field)
            })*
        }

        impl $crate::wire::Element for $name {
            const WIRE: &'static str = stringify!($name);
            const ROWS: &'static [$crate::wire::Row] = &$crate::wire::place([
                $($crate::wire::Row {
                    name: stringify!($field),
                    wire: <$type as $crate::wire::Field>::WIRE,
                    offset: None,
                    size: <$type as $crate::wire::Field>::SIZE,
                    part: $crate::wire::PartKind::Fixed,
                    unit: $crate::wire::unit(<$type as $crate::wire::Field>::UNIT, concat!($($unit)?)),
                    element: &[],
                },)*
            ]);
            const COUNT: &'static str = $count;

            fn value(&self) -> $crate::wire::Value<'_> {
                $crate::wire::Value::Group(self)
            }
        }

        impl $crate::wire::Fields for $name {
            fn fields(&self, visitor: &mut dyn $crate::wire::Visitor) {
                $(
                    let field = self.$field();
                    visitor.visit(&$crate::wire::FieldView {
                        name: stringify!($field),
                        unit: $crate::wire::unit(<$type as $crate::wire::Field>::UNIT, concat!($($unit)?)),
                        value: $crate::wire::Field::value(&field),
                        text: &field,
                    });
                )*
            }
        }

        $crate::__serde! { 'a [$name] }
        $crate::__defmt! { element $name { $($field: $type,)* } }

        impl core::fmt::Debug for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.debug_struct(stringify!($name))$(.field(stringify!($field), &self.$field()))*.finish()
            }
        }
    )*};
}
