//! Constructors of requests whose numbers must be small enough to arrive.

/// Gives each message a `new` that refuses numbers above [`MAX_ARRIVING`](super::units::MAX_ARRIVING), which do not
/// arrive.
macro_rules! bounded {
    ($($name:ident $({ $sub:ident: $sub_type:ty })? ($field:ident: $type:ty);)*) => {$(
        impl $name {
            /// Makes the message; `None` if the number is above 16,777,215, because it would not arrive as it is.
            #[must_use]
            pub const fn new($($sub: $sub_type,)? $field: $type) -> Option<Self> {
                if $field.0 > $crate::message::MAX_ARRIVING { None } else { Some(Self { $($sub,)? $field }) }
            }
        }
    )*};
}
pub(crate) use bounded;
