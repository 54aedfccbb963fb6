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
    };
}

/// Names of the enum of one side.
#[doc(hidden)]
#[macro_export]
macro_rules! __messages_features {
    ($lt:lifetime $name:ident { $($variant:ident)* }) => {
        $crate::__serde! { $lt [$name<$lt>] }
        $crate::__defmt! { side $lt $name { $($variant)* } }
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

/// Adds a derived `Format` to an item. Names are interned, so that the target holds no text.
#[doc(hidden)]
#[macro_export]
#[cfg(feature = "defmt")]
macro_rules! __logged {
    ($($item:tt)*) => {
        #[derive($crate::defmt::Format)]
        #[defmt(crate = $crate::defmt)]
        $($item)*
    };
}

#[doc(hidden)]
#[macro_export]
#[cfg(not(feature = "defmt"))]
macro_rules! __logged {
    ($($item:tt)*) => { $($item)* };
}

#[doc(hidden)]
#[macro_export]
#[cfg(feature = "defmt")]
macro_rules! __defmt {
    // The enum of a side.
    (side $lt:lifetime $name:ident { $($variant:ident)* }) => {
        impl<$lt> $crate::defmt::Format for $name<$lt> {
            fn format(&self, f: $crate::defmt::Formatter<'_>) {
                match self {
                    $(Self::$variant(message) => $crate::defmt::Format::format(message, f),)*
                    Self::Other(other) => $crate::defmt::Format::format(other, f),
                }
            }
        }
    };
    (message $lt:lifetime [$self:ty] $name:ident { $($field:ident: $type:ty,)* } $this:ident [$($tail:tt)*]) => {
        impl<$lt> $crate::defmt::Format for $self {
            fn format(&self, f: $crate::defmt::Formatter<'_>) {
                use $crate::format::Logged;

                #[allow(clippy::struct_field_names, reason = "the names of the fields")]
                #[derive($crate::defmt::Format)]
                #[defmt(crate = $crate::defmt)]
                struct $name<'x, $lt> {
                    $($field: Logged<'x, $lt, $type>,)*
                    tail: Logged<'x, $lt, $crate::wire::Rest<$lt>>,
                }

                let $this = self;
                let tail = $crate::wire::Rest($($tail)*);
                let logged = $name { $($field: Logged::new(&self.$field),)* tail: Logged::new(&tail) };
                $crate::defmt::Format::format(&logged, f);
            }
        }
    };
    (element $name:ident { $($field:ident: $type:ty,)* }) => {
        impl $crate::defmt::Format for $name {
            fn format(&self, f: $crate::defmt::Formatter<'_>) {
                #[allow(clippy::struct_field_names, reason = "the names of the fields")]
                #[derive($crate::defmt::Format)]
                #[defmt(crate = $crate::defmt)]
                struct $name { $($field: $type,)* }

                $crate::defmt::Format::format(&$name { $($field: self.$field(),)* }, f);
            }
        }
    };
    (newtype $name:ident($repr:ty)) => {
        impl $crate::defmt::Format for $name {
            fn format(&self, f: $crate::defmt::Formatter<'_>) {
                #[allow(clippy::struct_field_names, reason = "the names of the fields")]
                #[derive($crate::defmt::Format)]
                #[defmt(crate = $crate::defmt)]
                struct $name($repr);

                $crate::defmt::Format::format(&$name(self.0), f);
            }
        }
    };
    (open_enum $name:ident($repr:ty) { $($value:ident = $number:literal,)* }) => {
        impl $crate::defmt::Format for $name {
            fn format(&self, f: $crate::defmt::Formatter<'_>) {
                #[allow(non_camel_case_types, clippy::upper_case_acronyms, reason = "the names of the values")]
                #[derive($crate::defmt::Format)]
                #[defmt(crate = $crate::defmt)]
                enum $name { $($value,)* Number($repr) }

                let named = match self.0 {
                    $($number => $name::$value,)*
                    number => $name::Number(number),
                };
                $crate::defmt::Format::format(&named, f);
            }
        }
    };
    // What is logged in place of a value.
    (as $this:ident: $self:ty => $name:ident $(<$x:lifetime>)? { $($field:ident: $type:ty = $value:expr,)* }) => {
        impl $crate::defmt::Format for $self {
            fn format(&self, f: $crate::defmt::Formatter<'_>) {
                #[allow(clippy::struct_field_names, reason = "the names of the fields")]
                #[derive($crate::defmt::Format)]
                #[defmt(crate = $crate::defmt)]
                struct $name $(<$x>)? { $($field: $type,)* }

                let $this = self;
                $crate::defmt::Format::format(&$name { $($field: $value,)* }, f);
            }
        }
    };
    // The method of a field.
    (log) => {
        fn log(&self, f: $crate::defmt::Formatter<'_>) {
            $crate::defmt::Format::format(self, f);
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
