use core::fmt;

use super::{DecodeError, EncodeError, FieldView, Fields, Rest, Row, Value, Visitor};

/// One row of a table of messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kind {
    /// Its number; of a message with several, the first.
    pub number: u32,
    /// Its name, which is that of the variant.
    pub name: &'static str,
    /// The layout of its body.
    pub layout: &'static [Row],
}

/// All messages that one side of a protocol sends: an enum, made by [`messages!`](crate::messages) from one table.
pub trait Messages<'a>: Copy + PartialEq + fmt::Debug + fmt::Display + Fields {
    /// The table: number, name and layout of every message that is known.
    const ALL: &'static [Kind];

    /// Decodes the body of message `number`; an unknown number gives the variant `Other`, never an error.
    ///
    /// # Errors
    ///
    /// [`DecodeError`], if the number is known and the body is too short for it.
    fn decode_body(number: u32, body: &'a [u8]) -> Result<Self, DecodeError>;

    /// A message that is kept as it came, whatever its number; one with a type of its own can only be encoded as that.
    fn other(number: u32, body: &'a [u8]) -> Self;

    /// The number it is sent under.
    fn number(&self) -> u32;

    /// Its name in the specification, or `Other`.
    fn name(&self) -> &'static str;

    /// Bytes of its body.
    fn body_len(&self) -> usize;

    /// Writes its body to the front of `out`, and says how many bytes it took.
    ///
    /// # Errors
    ///
    /// [`EncodeError`]; then nothing is written.
    fn encode_body(&self, out: &mut [u8]) -> Result<usize, EncodeError>;
}

/// The bytes of a number, the highest first.
///
/// As `u32::to_be_bytes`, by way of the order that most processors have: no byte is swapped where the number was put
/// together from bytes by shifts.
#[doc(hidden)]
#[must_use]
#[inline]
pub const fn big_endian(number: u32) -> [u8; 4] {
    let [a, b, c, d] = number.to_le_bytes();
    [d, c, b, a]
}

/// A message without a type of its own, kept as it came.
///
/// Its parts are private, so that a number which gets a name later breaks nobody.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
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

    /// Its number, as the protocol's tables count.
    #[must_use]
    pub const fn id(&self) -> u32 {
        self.number
    }

    /// Its body.
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
/// `FIRST..=LAST` and `FIRST | ANOTHER` are numbers that one message shares; it decides by
/// [`decode_as`](crate::wire::Message::decode_as) and [`number`](crate::wire::Message::number). `A(A) or B(B)` are two
/// messages under one number, told apart by their data: what `A` refuses is read as `B`.
///
/// Where each byte of a number says something, a table may say them one by one: `[2, 4, 0..=255]` are the numbers
/// `0x02_04_00` to `0x02_04_FF`. They are then looked up byte by byte, which is a jump where bytes are dense and whole
/// numbers are not.
#[doc(hidden)]
#[macro_export]
macro_rules! messages {
    (
        $(#[$meta:meta])*
        $vis:vis enum $name:ident<$lt:lifetime> {
            $($(#[$variant_meta:meta])* $first:literal $(..= $last:literal)? $(| $another:literal)* => $variant:ident($body:ty)
                $(or $(#[$or_meta:meta])* $or_variant:ident($or_body:ty))?,)*
        }
    ) => {
        $crate::messages! { @by core::convert::identity,
            $(#[$meta])*
            $vis enum $name<$lt> {
                $($(#[$variant_meta])* { $first } $first $(..= $last)? $(| $another)* => $variant($body)
                    $(or $(#[$or_meta])* $or_variant($or_body))?,)*
            }
        }
    };
    (
        $(#[$meta:meta])*
        $vis:vis enum $name:ident<$lt:lifetime> {
            $($(#[$variant_meta:meta])* [$high:literal, $middle:literal, $low:literal $(..= $last:literal)?] => $variant:ident($body:ty)
                $(or $(#[$or_meta:meta])* $or_variant:ident($or_body:ty))?,)*
        }
    ) => {
        $crate::messages! { @by $crate::wire::big_endian,
            $(#[$meta])*
            $vis enum $name<$lt> {
                $($(#[$variant_meta])* { u32::from_be_bytes([0, $high, $middle, $low]) }
                    [0, $high, $middle, $low $(..= $last)?] => $variant($body)
                    $(or $(#[$or_meta])* $or_variant($or_body))?,)*
            }
        }
    };

    // `$key` makes of a number what the patterns match.
    (@by $key:path,
        $(#[$meta:meta])*
        $vis:vis enum $name:ident<$lt:lifetime> {
            $($(#[$variant_meta:meta])* { $first:expr } $numbers:pat => $variant:ident($body:ty)
                $(or $(#[$or_meta:meta])* $or_variant:ident($or_body:ty))?,)*
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        $vis enum $name<$lt> {
            $($(#[$variant_meta])* $variant($body), $($(#[$or_meta])* $or_variant($or_body),)?)*
            /// A message without a type of its own, kept as it came.
            Other($crate::wire::Other<$lt>),
        }

        const _: () = {
            use $crate::wire::{DecodeError, EncodeError, Fields, Kind, Message, Messages, Other, Visitor, print};

            impl<$lt> Messages<$lt> for $name<$lt> {
                const ALL: &'static [Kind] = &[
                    $(Kind { number: $first, name: stringify!($variant), layout: <$body as Message<$lt>>::LAYOUT },
                    $(Kind { number: $first, name: stringify!($or_variant), layout: <$or_body as Message<$lt>>::LAYOUT },)?)*
                ];

                #[allow(clippy::inline_always, reason = "a program that knows what it gets reads only that")]
                #[inline(always)]
                fn decode_body(number: u32, body: &$lt [u8]) -> Result<Self, DecodeError> {
                    match $key(number) {
                        $($numbers => {
                            <$body as Message<$lt>>::decode_as(number, body).map(Self::$variant)
                                $(.or_else(|_| <$or_body as Message<$lt>>::decode_as(number, body).map(Self::$or_variant)))?
                        })*
                        _ => Ok(Self::other(number, body)),
                    }
                }

                #[inline]
                fn other(number: u32, body: &$lt [u8]) -> Self {
                    Self::Other(Other::new(number, body))
                }

                #[inline]
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

                #[inline]
                fn body_len(&self) -> usize {
                    match self {
                        $(Self::$variant(message) => Message::encoded_len(message),
                        $(Self::$or_variant(message) => Message::encoded_len(message),)?)*
                        Self::Other(other) => other.payload().len(),
                    }
                }

                #[inline]
                fn encode_body(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
                    match self {
                        $(Self::$variant(message) => Message::encode_into(message, out),
                        $(Self::$or_variant(message) => Message::encode_into(message, out),)?)*
                        Self::Other(other) => encode_other(other, out),
                    }
                }
            }

            /// Writes what is kept as it came, unless it would come as something else: a stop must not travel as a
            /// message of which nobody knows that it stops.
            #[cold]
            #[inline(never)]
            fn encode_other(other: &Other<'_>, out: &mut [u8]) -> Result<usize, EncodeError> {
                match $name::decode_body(other.id(), other.payload()) {
                    Ok($name::Other(_)) | Err(_) => other.encode_into(out),
                    Ok(known) => Err(EncodeError::Known { what: known.name() }),
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

            $crate::__messages_features! { $lt $name }
        };
    };
}
