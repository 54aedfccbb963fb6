//! What the optional features add to every message. The macros stand here in two forms each, so that the tables need
//! not know which features are on.

/// Names of one message.
#[doc(hidden)]
#[macro_export]
macro_rules! __message_features {
    ($lt:lifetime [$self:ty] $name:ident) => {
        $crate::__serde! { $lt [$self] }
        $crate::__defmt! { $lt [$self] $name }
    };
}

/// Names of the enum of one side.
#[doc(hidden)]
#[macro_export]
macro_rules! __messages_features {
    ($lt:lifetime $name:ident) => {
        $crate::__serde! { $lt [$name<$lt>] }
        $crate::__defmt! { $lt [$name<$lt>] }
        $crate::__arbitrary! { $lt $name }
    };
}

#[doc(hidden)]
#[macro_export]
#[cfg(feature = "serde")]
macro_rules! __serde {
    ($lt:lifetime [$self:ty]) => {
        /// A map of the fields, by their names in the layout, with the raw values of the wire.
        impl<$lt> $crate::serde::Serialize for $self {
            fn serialize<S: $crate::serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                $crate::serialize::fields(self, serializer)
            }
        }
    };
}

#[doc(hidden)]
#[macro_export]
#[cfg(not(feature = "serde"))]
macro_rules! __serde {
    ($($table:tt)*) => {};
}

#[doc(hidden)]
#[macro_export]
#[cfg(feature = "defmt")]
macro_rules! __defmt {
    ($lt:lifetime [$self:ty] $name:ident) => {
        impl<$lt> $crate::defmt::Format for $self {
            fn format(&self, f: $crate::defmt::Formatter<'_>) {
                $crate::format::message(f, stringify!($name), self);
            }
        }
    };
    ($lt:lifetime [$self:ty]) => {
        impl<$lt> $crate::defmt::Format for $self {
            fn format(&self, f: $crate::defmt::Formatter<'_>) {
                $crate::format::message(f, $crate::wire::Messages::name(self), self);
            }
        }
    };
}

#[doc(hidden)]
#[macro_export]
#[cfg(not(feature = "defmt"))]
macro_rules! __defmt {
    ($($table:tt)*) => {};
}

#[doc(hidden)]
#[macro_export]
#[cfg(feature = "arbitrary")]
macro_rules! __arbitrary {
    ($lt:lifetime $name:ident) => {
        /// Mostly a message of the table, decoded from arbitrary bytes; sometimes an unknown one.
        impl<$lt> $crate::arbitrary::Arbitrary<$lt> for $name<$lt> {
            fn arbitrary(u: &mut $crate::arbitrary::Unstructured<$lt>) -> $crate::arbitrary::Result<Self> {
                $crate::wire::arbitrary_message(u)
            }
        }
    };
}

#[doc(hidden)]
#[macro_export]
#[cfg(not(feature = "arbitrary"))]
macro_rules! __arbitrary {
    ($($table:tt)*) => {};
}

/// A message of arbitrary bytes: mostly one of the table, with a body long enough for its fixed fields.
#[doc(hidden)]
#[cfg(feature = "arbitrary")]
pub fn arbitrary_message<'a, M: super::Messages<'a>>(u: &mut arbitrary::Unstructured<'a>) -> arbitrary::Result<M> {
    use super::{Kind, PartKind, Row};

    let unknown = Kind { number: u.int_in_range(0..=0xffff)?, name: "Other", layout: &[], conduct: None };
    let kind = if u.ratio(1, 16)? { &unknown } else { u.choose(M::ALL)? };
    let fixed = |row: &Row| if row.part == PartKind::Fixed { row.size } else { 0 };
    let least: usize = kind.layout.iter().map(fixed).fold(0, usize::saturating_add);
    let len = least.saturating_add(u.int_in_range(0..=64)?).min(u.len());
    let body = u.bytes(len)?;
    M::decode_body(kind.number, body).map_err(|_| arbitrary::Error::IncorrectFormat)
}
