//! Constructors of requests whose numbers have to be small enough to arrive.

/// Gives each message a `new` that refuses what does not arrive: a number above
/// [`MAX_ARRIVING`](super::units::MAX_ARRIVING).
macro_rules! bounded {
    ($($name:ident $({ $sub:ident: $sub_type:ty })? ($field:ident: $type:ty);)*) => {$(
        impl $name {
            /// Puts one together; `None`, if the number is above 16,777,215 and would not arrive as it is.
            #[must_use]
            pub const fn new($($sub: $sub_type,)? $field: $type) -> Option<Self> {
                if $field.0 > $crate::message::MAX_ARRIVING { None } else { Some(Self { $($sub,)? $field }) }
            }
        }
    )*};
}
pub(crate) use bounded;
