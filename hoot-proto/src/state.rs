//! States of machines as data, so that pictures and tests can name all of them, and how machines are printed.

use motion_core::time::Millis;

/// Makes an enum of states with the list of them and their names.
macro_rules! states {
    ($(
        $(#[$meta:meta])*
        pub enum $name:ident { $($(#[$state_meta:meta])* $state:ident,)* }
    )*) => {$(
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
        pub enum $name { $($(#[$state_meta])* $state,)* }

        impl $name {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$state,)*];

            /// Its name, as the pictures have it.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$state => stringify!($state),)*
                }
            }
        }
    )*};
}
pub(crate) use states;

/// Makes the `Debug` of structs with many fields: a derived one of six or more cannot be proven free of panics.
macro_rules! debug {
    ($($name:ident { $($field:ident)* })*) => {$(
        impl core::fmt::Debug for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.debug_struct(stringify!($name))$(.field(stringify!($field), &self.$field))*.finish()
            }
        }
    )*};
}
pub(crate) use debug;

/// A moment, on a clock that was set back.
pub(crate) const fn set_back(moment: Millis, by: u64) -> Millis {
    Millis(moment.0.saturating_sub(by))
}
