use core::fmt;

use super::{Conduct, DecodeError, EncodeError, FieldView, Fields, Rest, Row, Value, Visitor};

/// One row of a table of messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kind {
    /// Number of the message; the first one of a message with several numbers.
    pub number: u32,
    /// Name of the message, which is the name of the variant.
    pub name: &'static str,
    /// Layout of the body.
    pub layout: &'static [Row],
    /// Conduct of every message of this kind. `None` if the values of the message decide, which
    /// [`Messages::conduct`] tells then, and for messages that no host sends.
    pub conduct: Option<Conduct>,
}

/// All messages that one side of a protocol sends: an enum, made by [`messages!`](crate::messages) from one table.
pub trait Messages<'a>: Copy + PartialEq + fmt::Debug + fmt::Display + Fields {
    /// The table: number, name, layout and conduct of every message that is known.
    const ALL: &'static [Kind];

    /// Decodes the body of message `number`; an unknown number gives the variant `Other`, never an error.
    ///
    /// # Errors
    ///
    /// [`DecodeError`], if the number is known and the body is too short for it.
    #[allow(clippy::inline_always, reason = "a program that knows what it gets reads only that")]
    #[inline(always)]
    fn decode_body(number: u32, body: &'a [u8]) -> Result<Self, DecodeError> {
        Self::decode_with(number, body, Ok, Err)
    }

    /// Decodes the body of message `number`; an unknown number, and a body that is too short, give the variant `Other`.
    #[allow(clippy::inline_always, reason = "a program that knows what it gets reads only that")]
    #[inline(always)]
    #[must_use]
    fn decode_or_other(number: u32, body: &'a [u8]) -> Self {
        Self::decode_with(number, body, |message| message, |_| Self::other(number, body))
    }

    /// Decodes the body of message `number`, and makes the result of the message or of the error. An unknown number gives the
    /// variant `Other`.
    ///
    /// The result is made where the message is decoded. If it were made afterwards, each message would be put together
    /// twice.
    fn decode_with<R>(
        number: u32,
        body: &'a [u8],
        decoded: impl Fn(Self) -> R,
        refused: impl Fn(DecodeError) -> R,
    ) -> R;

    /// Makes the variant `Other` from a number and a body, whatever the number is. If the number and the body are those of
    /// a message with a type of its own, it cannot be encoded.
    fn other(number: u32, body: &'a [u8]) -> Self;

    /// Number under which the message is sent.
    fn number(&self) -> u32;

    /// Name of the message in the specification, or `Other`.
    fn name(&self) -> &'static str;

    /// How the message may be treated; `None` for messages that no host sends. The conduct of `Other` is
    /// [`Conduct::UNKNOWN`].
    fn conduct(&self) -> Option<Conduct>;

    /// Length of the body in bytes.
    fn body_len(&self) -> usize;

    /// Writes the body to the front of `out` and returns its length in bytes.
    ///
    /// # Errors
    ///
    /// [`EncodeError`]; then nothing is written.
    fn encode_body(&self, out: &mut [u8]) -> Result<usize, EncodeError>;
}

/// Bytes of a number, the highest first.
///
/// The result is that of `u32::to_be_bytes`. It is made from the little-endian bytes, so that most processors swap no
/// bytes when the number was put together from bytes by shifts.
#[doc(hidden)]
#[must_use]
#[inline]
pub const fn big_endian(number: u32) -> [u8; 4] {
    let [a, b, c, d] = number.to_le_bytes();
    [d, c, b, a]
}

/// A message without a type of its own: its number and its bytes.
///
/// The fields are private, so that a number can get a type in a later version without breaking code.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Other<'a> {
    number: u32,
    payload: &'a [u8],
}

impl<'a> Other<'a> {
    #[doc(hidden)]
    #[must_use]
    pub const fn new(number: u32, payload: &'a [u8]) -> Self {
        Self { number, payload }
    }

    /// Number of the message, as the tables of the protocol count.
    #[must_use]
    pub const fn id(&self) -> u32 {
        self.number
    }

    /// Body of the message.
    #[must_use]
    pub const fn payload(&self) -> &'a [u8] {
        self.payload
    }

    #[doc(hidden)]
    pub fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let needed = self.payload.len();
        let small = EncodeError::BufferTooSmall { needed, have: out.len() };
        out.get_mut(..needed).ok_or(small)?.copy_from_slice(self.payload);
        Ok(needed)
    }
}

impl Fields for Other<'_> {
    fn fields(&self, visitor: &mut dyn Visitor) {
        visitor.visit(&FieldView {
            name: "data",
            unit: "",
            value: Value::Bytes(self.payload),
            text: &Rest(self.payload),
        });
    }
}

/// Turns one table of numbers and variants into the enum of one side, its decoder, its encoder and `ALL`.
///
/// A table `from host` states after each body, in brackets, how the message may be treated: see
/// [`Conduct`](crate::wire::Conduct). A row without it does not compile. Each body of a table belongs to one row, and
/// converts into the enum by `From`.
///
/// `FIRST..=LAST` and `FIRST | ANOTHER` are numbers that one message shares; it decides by
/// [`decode_as`](crate::wire::Message::decode_as) and [`number`](crate::wire::Message::number). `A(A) or B(B)` are two
/// messages under one number, told apart by their data: what `A` refuses is read as `B`.
///
/// A table may give a number as bytes: `[2, 4, 0..=255]` are the numbers `0x02_04_00` to `0x02_04_FF`. They are looked up
/// byte by byte, which is a jump if the bytes are dense; a lookup of the whole numbers would be a search.
#[doc(hidden)]
#[macro_export]
macro_rules! messages {
    (
        $(#[$meta:meta])*
        $vis:vis enum $name:ident<$lt:lifetime> from host {
            $($(#[$variant_meta:meta])* $first:literal $(..= $last:literal)? $(| $another:literal)*
                => $variant:ident($body:ty) [$($conduct:tt)+]
                $(or $(#[$or_meta:meta])* $or_variant:ident($or_body:ty) [$($or_conduct:tt)+])?,)*
        }
    ) => {
        $crate::messages! { @by core::convert::identity, other [moves once],
            $(#[$meta])*
            $vis enum $name<$lt> {
                $($(#[$variant_meta])* { $first } $first $(..= $last)? $(| $another)* => $variant($body) [$($conduct)+]
                    $(or $(#[$or_meta])* $or_variant($or_body) [$($or_conduct)+])?,)*
            }
        }
        $crate::messages! { @conduct $name }
    };
    (
        $(#[$meta:meta])*
        $vis:vis enum $name:ident<$lt:lifetime> from host {
            $($(#[$variant_meta:meta])* [$high:literal, $middle:literal, $low:literal $(..= $last:literal)?]
                => $variant:ident($body:ty) [$($conduct:tt)+]
                $(or $(#[$or_meta:meta])* $or_variant:ident($or_body:ty) [$($or_conduct:tt)+])?,)*
        }
    ) => {
        $crate::messages! { @by $crate::wire::big_endian, other [moves once],
            $(#[$meta])*
            $vis enum $name<$lt> {
                $($(#[$variant_meta])* { u32::from_be_bytes([0, $high, $middle, $low]) }
                    [0, $high, $middle, $low $(..= $last)?] => $variant($body) [$($conduct)+]
                    $(or $(#[$or_meta])* $or_variant($or_body) [$($or_conduct)+])?,)*
            }
        }
        $crate::messages! { @conduct $name }
    };
    (
        $(#[$meta:meta])*
        $vis:vis enum $name:ident<$lt:lifetime> {
            $($(#[$variant_meta:meta])* $first:literal $(..= $last:literal)? $(| $another:literal)*
                => $variant:ident($body:ty) $(or $(#[$or_meta:meta])* $or_variant:ident($or_body:ty))?,)*
        }
    ) => {
        $crate::messages! { @by core::convert::identity, other [],
            $(#[$meta])*
            $vis enum $name<$lt> {
                $($(#[$variant_meta])* { $first } $first $(..= $last)? $(| $another)* => $variant($body) []
                    $(or $(#[$or_meta])* $or_variant($or_body) [])?,)*
            }
        }
    };
    (
        $(#[$meta:meta])*
        $vis:vis enum $name:ident<$lt:lifetime> {
            $($(#[$variant_meta:meta])* [$high:literal, $middle:literal, $low:literal $(..= $last:literal)?]
                => $variant:ident($body:ty) $(or $(#[$or_meta:meta])* $or_variant:ident($or_body:ty))?,)*
        }
    ) => {
        $crate::messages! { @by $crate::wire::big_endian, other [],
            $(#[$meta])*
            $vis enum $name<$lt> {
                $($(#[$variant_meta])* { u32::from_be_bytes([0, $high, $middle, $low]) }
                    [0, $high, $middle, $low $(..= $last)?] => $variant($body) []
                    $(or $(#[$or_meta])* $or_variant($or_body) [])?,)*
            }
        }
    };

    (@conduct $name:ident) => {
        impl $name<'_> {
            /// How the message may be treated: what it does, and whether it may be sent again.
            #[must_use]
            pub fn conduct(&self) -> $crate::wire::Conduct {
                $crate::wire::Messages::conduct(self).unwrap_or($crate::wire::Conduct::UNKNOWN)
            }
        }
    };

    // `$key` makes of a number what the patterns match.
    (@by $key:path, other [$($other:tt)*],
        $(#[$meta:meta])*
        $vis:vis enum $name:ident<$lt:lifetime> {
            $($(#[$variant_meta:meta])* { $first:expr } $numbers:pat => $variant:ident($body:ty) [$($conduct:tt)*]
                $(or $(#[$or_meta:meta])* $or_variant:ident($or_body:ty) [$($or_conduct:tt)*])?,)*
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        $vis enum $name<$lt> {
            $($(#[$variant_meta])* $variant($body), $($(#[$or_meta])* $or_variant($or_body),)?)*
            /// A message without a type of its own: its number and its bytes.
            Other($crate::wire::Other<$lt>),
        }

        $(
            impl<$lt> From<$body> for $name<$lt> {
                #[inline]
                fn from(message: $body) -> Self {
                    Self::$variant(message)
                }
            }

            $(
                impl<$lt> From<$or_body> for $name<$lt> {
                    #[inline]
                    fn from(message: $or_body) -> Self {
                        Self::$or_variant(message)
                    }
                }
            )?
        )*

        const _: () = {
            use $crate::wire::{Conduct, DecodeError, EncodeError, Fields, Kind, Message, Messages, Other, Visitor, print};

            impl<$lt> Messages<$lt> for $name<$lt> {
                const ALL: &'static [Kind] = &[
                    $(
                        Kind {
                            number: $first,
                            name: stringify!($variant),
                            layout: <$body as Message<$lt>>::LAYOUT,
                            conduct: $crate::__conduct!(row [$($conduct)*]),
                        },
                        $(Kind {
                            number: $first,
                            name: stringify!($or_variant),
                            layout: <$or_body as Message<$lt>>::LAYOUT,
                            conduct: $crate::__conduct!(row [$($or_conduct)*]),
                        },)?
                    )*
                ];

                #[allow(clippy::inline_always, reason = "a program that knows what it gets reads only that")]
                #[inline(always)]
                fn decode_with<R>(
                    number: u32,
                    body: &$lt [u8],
                    decoded: impl Fn(Self) -> R,
                    refused: impl Fn(DecodeError) -> R,
                ) -> R {
                    match $key(number) {
                        $($numbers => match <$body as Message<$lt>>::decode_as(number, body) {
                            Ok(body) => decoded(Self::$variant(body)),
                            $(Err(_) => match <$or_body as Message<$lt>>::decode_as(number, body) {
                                Ok(body) => decoded(Self::$or_variant(body)),
                                Err(error) => refused(error),
                            },)?
                            #[allow(unreachable_patterns, reason = "a row with two messages has no other error")]
                            Err(error) => refused(error),
                        })*
                        _ => decoded(Self::other(number, body)),
                    }
                }

                #[inline]
                fn other(number: u32, body: &$lt [u8]) -> Self {
                    Self::Other(Other::new(number, body))
                }

                #[allow(clippy::inline_always, reason = "a program that knows what it sends writes only that")]
                #[inline(always)]
                fn number(&self) -> u32 {
                    match self {
                        $(Self::$variant(message) => Message::number(message, $first),
                        $(Self::$or_variant(message) => Message::number(message, $first),)?)*
                        Self::Other(other) => other.id(),
                    }
                }

                fn name(&self) -> &'static str {
                    match self {
                        $(Self::$variant(_) => stringify!($variant), $(Self::$or_variant(_) => stringify!($or_variant),)?)*
                        Self::Other(_) => "Other",
                    }
                }

                fn conduct(&self) -> Option<Conduct> {
                    match self {
                        $(Self::$variant(message) => $crate::__conduct!(of message [$($conduct)*]),
                        $(Self::$or_variant(message) => $crate::__conduct!(of message [$($or_conduct)*]),)?)*
                        Self::Other(other) => $crate::__conduct!(of other [$($other)*]),
                    }
                }

                #[allow(clippy::inline_always, reason = "a program that knows what it sends writes only that")]
                #[inline(always)]
                fn body_len(&self) -> usize {
                    match self {
                        $(Self::$variant(message) => Message::encoded_len(message),
                        $(Self::$or_variant(message) => Message::encoded_len(message),)?)*
                        Self::Other(other) => other.payload().len(),
                    }
                }

                #[allow(clippy::inline_always, reason = "a program that knows what it sends writes only that")]
                #[inline(always)]
                fn encode_body(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
                    match self {
                        $(Self::$variant(message) => Message::encode_into(message, out),
                        $(Self::$or_variant(message) => Message::encode_into(message, out),)?)*
                        Self::Other(other) => encode_other(other, out),
                    }
                }
            }

            /// Writes a message that has no type, unless its receiver would read a typed message: a stop must not travel
            /// as a message of which no machine knows that it stops.
            #[cold]
            #[inline(never)]
            fn encode_other(other: &Other<'_>, out: &mut [u8]) -> Result<usize, EncodeError> {
                match $name::decode_body(other.id(), other.payload()) {
                    Ok($name::Other(_)) | Err(_) => other.encode_into(out),
                    Ok(known) => Err(EncodeError::Typed { what: known.name() }),
                }
            }

            impl Fields for $name<'_> {
                fn fields(&self, visitor: &mut dyn Visitor) {
                    match self {
                        $(Self::$variant(message) => message.fields(visitor),
                        $(Self::$or_variant(message) => message.fields(visitor),)?)*
                        Self::Other(other) => other.fields(visitor),
                    }
                }
            }

            impl core::fmt::Display for $name<'_> {
                fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                    print::message(f, Messages::name(self), self)
                }
            }

            $crate::__messages_features! { $lt $name { $($variant $($or_variant)?)* } }
        };
    };
}
