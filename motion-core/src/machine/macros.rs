//! Shapes that the machines of all protocol crates share, written once: the calls, states, options, and how they print.

/// Makes the calls of a machine, inherent and of the trait, from its method
/// `fn run<'a>(&mut self, now: Millis, output: &mut Output<'a>, input: Input<'a>)`.
///
/// A wake that is not later than the call is left out here, for all machines.
#[doc(hidden)]
#[macro_export]
macro_rules! machine {
    ($name:ident) => { $crate::machine! { [impl] $name } };
    ([$($impl:tt)*] $name:ty) => {
        $($impl)* $name {
            /// Takes an input at a moment and returns all that follows from it.
            ///
            /// Carry out the effects in their order, then wait until something happens, at most until the wake.
            pub fn advance<'a>(&mut self, now: $crate::time::Millis, input: Input<'a>) -> Output<'a> {
                let mut output = Output::default();
                self.run(now, &mut output, input);
                output.wake = output.wake.filter(|&wake| wake > now);
                output
            }

            /// Returns the next machine and all that follows from an input: [`advance`](Self::advance) as a pure
            /// function.
            #[must_use]
            pub fn step(mut self, now: $crate::time::Millis, input: Input<'_>) -> (Self, Output<'_>) {
                let output = self.advance(now, input);
                (self, output)
            }
        }

        $($impl)* $crate::machine::Machine for $name {
            type Input<'a> = Input<'a>;
            type Output<'a> = Output<'a>;

            fn advance<'a>(&mut self, now: $crate::time::Millis, input: Self::Input<'a>) -> Self::Output<'a> {
                Self::advance(self, now, input)
            }
        }
    };
}

/// Makes an enum of states, with the list of all states and their names.
#[doc(hidden)]
#[macro_export]
macro_rules! states {
    ($(
        $(#[$meta:meta])*
        $vis:vis enum $name:ident { $($(#[$state_meta:meta])* $state:ident,)* }
    )*) => {$(
        $crate::__logged! {
            $(#[$meta])*
            #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
            $vis enum $name { $($(#[$state_meta])* $state,)* }
        }

        impl $name {
            /// Every value of the type, in the order of its declaration.
            pub const ALL: [Self; [$(stringify!($state)),*].len()] = [$(Self::$state),*];

            /// Name of the value, as the documentation writes it.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$state => stringify!($state),)*
                }
            }
        }

        impl core::fmt::Display for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.write_str(self.name())
            }
        }
    )*};
}

/// Makes the `Debug` of structs with many fields. A derived one of six fields or more cannot be proven free of panics.
#[doc(hidden)]
#[macro_export]
macro_rules! debug {
    ($($name:ident { $($field:ident)* })*) => {$(
        $crate::debug! { [impl] $name { $($field)* } }
    )*};
    ([$($impl:tt)*] $name:ident $(<$($param:ident),*>)? { $($field:ident)* }) => {
        $($impl)* core::fmt::Debug for $name $(<$($param),*>)? {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.debug_struct(stringify!($name))$(.field(stringify!($field), &self.$field))*.finish()
            }
        }
    };
}

/// Makes the `Display` of enums: a plain text for each variant, whose fields can be used in it.
#[doc(hidden)]
#[macro_export]
macro_rules! display {
    ($($name:ident $(<$lt:lifetime>)? {
        $($variant:ident $(($($tuple:tt)*))? $({$($fields:tt)*})? => $text:literal $(, $arg:expr)*;)*
    })*) => {$(
        impl core::fmt::Display for $name $(<$lt>)? {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                match self {
                    $(Self::$variant $(($($tuple)*))? $({$($fields)*})? => write!(f, $text $(, $arg)*),)*
                }
            }
        }
    )*};
}

/// Makes a struct of options: private fields, a default and a getter for each, and builders that keep values in range.
///
/// `field with_field: type = default;` takes any value; `, in least..=most` puts values outside the range to its nearest
/// end; `, by path` calls a `const fn` on the value.
#[doc(hidden)]
#[macro_export]
macro_rules! options {
    ($(
        $(#[$meta:meta])*
        $vis:vis struct $name:ident {
            $(
                $(#[$field_meta:meta])*
                $field:ident $with:ident: $type:ty = $default:expr
                $(, in $least:literal ..= $most:expr)? $(, by $keep:path)?;
            )*
        }
    )*) => {$(
        $(#[$meta])*
        #[derive(Clone, Copy, PartialEq, Eq, Hash)]
        $vis struct $name {
            $($field: $type,)*
        }

        $crate::debug! { $name { $($field)* } }

        impl Default for $name {
            fn default() -> Self {
                Self::new()
            }
        }

        impl $name {
            /// The options with all their defaults.
            #[must_use]
            pub const fn new() -> Self {
                Self { $($field: $default,)* }
            }

            $(
                $(#[$field_meta])*
                #[doc = concat!("\n\nDefault: `", stringify!($default), "`.")]
                #[must_use]
                pub const fn $field(&self) -> $type {
                    self.$field
                }

                #[doc = concat!("Returns the options with another [`", stringify!($field), "`](Self::", stringify!($field), ").")]
                $(#[doc = concat!(
                    "\n\nA value outside ", stringify!($least), " to ", stringify!($most), " counts as the nearest of the two."
                )])?
                #[must_use]
                pub const fn $with(mut self, $field: $type) -> Self {
                    $(
                        let $field = if $field < $least {
                            $least
                        } else if $field > $most {
                            $most
                        } else {
                            $field
                        };
                    )?
                    $(let $field = $keep($field);)?
                    self.$field = $field;
                    self
                }
            )*
        }
    )*};
}

#[cfg(test)]
#[allow(unreachable_pub, reason = "the macros make public items")]
mod tests {
    use std::format;
    use std::string::ToString;

    states! {
        /// How far a connection is.
        #[derive(Default)]
        enum State {
            /// No link.
            #[default]
            Offline,
            /// A link.
            Ready,
        }
    }

    const fn to_even(number: u8) -> u8 {
        number & !1
    }

    options! {
        /// Every kind of option.
        struct Options {
            /// Time to wait for an answer, in milliseconds.
            timeout with_timeout: u32 = 500, in 1..=u32::MAX;
            /// Requests at once.
            window with_window: u8 = 1, in 1..=4;
            /// An even number.
            even with_even: u8 = 2, by to_even;
            /// Any number, or none.
            every with_every: Option<u64> = None;
        }
    }

    enum Event {
        Ready { reconnected: bool },
        Ended(u8, Option<u8>),
    }

    display! {
        Event {
            Ready { reconnected: false } => "ready";
            Ready { reconnected: true } => "ready again";
            Ended(token, None) => "command {token} ended";
            Ended(token, Some(count)) => "command {token} ended after {} tries", count + 1;
        }
    }

    #[test]
    fn each_variant_prints_its_text_with_its_fields() {
        let events = [Event::Ready { reconnected: false }, Event::Ready { reconnected: true }, Event::Ended(3, None)];
        assert_eq!(events.map(|event| event.to_string()), ["ready", "ready again", "command 3 ended"]);
        assert_eq!(Event::Ended(3, Some(1)).to_string(), "command 3 ended after 2 tries");
    }

    #[test]
    fn states_have_a_list_and_names() {
        assert_eq!(State::ALL, [State::Offline, State::Ready]);
        assert_eq!((State::default(), State::Ready.to_string()), (State::Offline, "Ready".to_string()));
    }

    #[test]
    fn no_option_leaves_its_range() {
        let options = Options::default().with_timeout(0).with_window(9).with_even(7).with_every(Some(3));
        assert_eq!((options.timeout(), options.window(), options.even(), options.every()), (1, 4, 6, Some(3)));
        assert_eq!(Options::new().with_window(0).with_timeout(u32::MAX).timeout(), u32::MAX);
        assert_eq!(Options::new(), Options::default());
        assert_eq!(format!("{:?}", Options::new()), "Options { timeout: 500, window: 1, even: 2, every: None }");
    }
}
