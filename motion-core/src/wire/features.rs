//! What the optional features add to every message. The macros stand here in two forms, so that the tables need not
//! know which features are on.

/// What a single message gets.
#[doc(hidden)]
#[macro_export]
#[cfg(feature = "serde")]
macro_rules! __message_features {
    ($lt:lifetime [$self:ty] $name:ident) => {
        impl<$lt> $crate::serde::Serialize for $self {
            fn serialize<S: $crate::serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                $crate::serialize::fields(self, serializer)
            }
        }
    };
}

/// What a single message gets.
#[doc(hidden)]
#[macro_export]
#[cfg(not(feature = "serde"))]
macro_rules! __message_features {
    ($($table:tt)*) => {};
}

/// What the enum of a side gets.
#[doc(hidden)]
#[macro_export]
macro_rules! __messages_features {
    ($lt:lifetime $name:ident) => {};
}
