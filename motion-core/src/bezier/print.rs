//! Printing of numbers and errors without core's own printing, which cannot be proven free of panics.

use core::fmt;

/// A number that prints as the shortest text that reads back to the same number.
pub(crate) struct Number(pub(crate) f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(zmij::Buffer::new().format(self.0))
    }
}

impl fmt::Debug for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// The debug form of the value of a field.
pub(crate) trait Shown {
    fn shown(&self) -> impl fmt::Debug;
}

impl Shown for f64 {
    fn shown(&self) -> impl fmt::Debug {
        Number(*self)
    }
}

impl Shown for Option<f64> {
    fn shown(&self) -> impl fmt::Debug {
        self.map(Number)
    }
}

/// Implements [`Shown`] for types whose own `Debug` cannot panic.
macro_rules! shown_as_it_is {
    ($($name:ty)*) => {$(
        impl $crate::bezier::print::Shown for $name {
            fn shown(&self) -> impl core::fmt::Debug {
                *self
            }
        }
    )*};
}

shown_as_it_is! { u32 usize }

/// Implements `Debug` like `derive`, for structures of numbers.
macro_rules! debug_numbers {
    ($($name:ident { $($field:ident),+ })+) => {$(
        impl core::fmt::Debug for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                use $crate::bezier::print::Shown;
                f.debug_struct(stringify!($name))$(.field(stringify!($field), &self.$field.shown()))+.finish()
            }
        }
    )+};
}

/// Implements `Debug` as the name of the type around its `Display` text.
macro_rules! debug_as_text {
    ($($name:ident)+) => {$(
        impl core::fmt::Debug for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                write!(f, concat!(stringify!($name), "({})"), self)
            }
        }
    )+};
}

pub(crate) use {debug_as_text, debug_numbers, shown_as_it_is};

#[cfg(test)]
mod tests {
    use std::format;

    use crate::bezier::{Ease, Key, Motion, Point};

    #[test]
    fn debug_prints_like_a_derived_one() {
        let motion = Motion { position: 1.5, velocity: Some(-0.25), acceleration: None };
        assert_eq!(format!("{motion:?}"), "Motion { position: 1.5, velocity: Some(-0.25), acceleration: None }");
        let key = Key { time: 1.0, position: 0.1, arrive: Ease::Flat(0.5), leave: Ease::Handle(Point::ZERO) };
        assert_eq!(
            format!("{key:?}"),
            "Key { time: 1.0, position: 0.1, arrive: Flat(0.5), leave: Handle(Point { time: 0.0, position: 0.0 }) }"
        );
    }
}
