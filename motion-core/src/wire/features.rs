//! Implementations that every message has: how it prints, and what the optional features add. The macros of features stand
//! here in two forms each, so that the tables need not know which features are on.

/// Names of one message.
#[doc(hidden)]
#[macro_export]
macro_rules! __message_features {
    ($lt:lifetime [$self:ty] $name:ident) => {
        /// Prints `name { field: value unit, .. }`.
        impl<$lt> core::fmt::Display for $self {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                $crate::wire::print::message(f, stringify!($name), self)
            }
        }

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
#[cfg(feature = "serde")]
macro_rules! __serde_value {
    ($name:ident($repr:ty)) => {
        /// The raw value of the wire, as in messages.
        impl $crate::serde::Serialize for $name {
            fn serialize<S: $crate::serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                $crate::serialize::value($crate::wire::Field::value(self), serializer)
            }
        }

        impl<'de> $crate::serde::Deserialize<'de> for $name {
            fn deserialize<D: $crate::serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                <$repr as $crate::raw::Raw>::read(deserializer).map(Self)
            }
        }
    };
}

#[doc(hidden)]
#[macro_export]
#[cfg(not(feature = "serde"))]
macro_rules! __serde_value {
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
        /// A message of any kind of the table, or one without a type. It borrows its body from the input, so that a list
        /// or a text after a count is mostly empty. The owned message has all lists and texts.
        impl<$lt> $crate::arbitrary::Arbitrary<$lt> for $name<$lt> {
            fn arbitrary(u: &mut $crate::arbitrary::Unstructured<$lt>) -> $crate::arbitrary::Result<Self> {
                $crate::wire::draw_borrowed(u)
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
