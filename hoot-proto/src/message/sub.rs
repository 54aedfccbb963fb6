//! Messages of which the sub-address is a part.

use motion_core::unit;
use motion_core::wire::Visitor;

/// Type of the sub-address of a command.
pub(crate) trait Sub: Copy {
    /// Reads the sub-address from the number of a table.
    fn of(number: u32) -> Self;

    /// The sub-address.
    fn byte(self) -> u8;

    /// Shows the sub-address like a field of the data.
    fn show(self, visitor: &mut dyn Visitor);

    /// Number of a command; a table gives the number of its first sub-address.
    fn number(self, declared: u32) -> u32 {
        declared & !0xFF | u32::from(self.byte())
    }
}

unit! {
    /// Sub-address that nodes ignore: of a broadcast, or in the core protocol. It is kept as it came. Send 0.
    pub struct AnySubAddress(u8) "";
}

impl Sub for AnySubAddress {
    fn of(number: u32) -> Self {
        let [sub_address, ..] = number.to_le_bytes();
        Self(sub_address)
    }

    fn byte(self) -> u8 {
        self.0
    }

    /// Nodes ignore it, so it is not shown.
    fn show(self, _: &mut dyn Visitor) {}
}

/// Makes a message of the sub-address and the fields, as `message!` makes one of the fields.
///
/// The sub-address is in the number of the table, not in the data, so these messages are decoded by `decode_as`. Their
/// `decode` assumes the first sub-address.
macro_rules! sub_messages {
    ($(
        $(#[$meta:meta])*
        $vis:vis struct $name:ident for $(#[$sub_meta:meta])* $sub:ident: $sub_type:ty {
            $($(#[$field_meta:meta])* $field:ident: $field_type:ty,)*
        }
    )*) => {$(
        motion_core::__logged! {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
        $vis struct $name {
            $(#[$sub_meta])*
            pub $sub: $sub_type,
            $($(#[$field_meta])* pub $field: $field_type,)*
        }
        }

        const _: () = {
            use motion_core::wire::{DecodeError, EncodeError, Fields, Message, Row, Visitor};
            use $crate::message::sub::Sub;

            // This type is the data alone. In this block it has the name of the message, so that errors contain that
            // name; the message itself is `self::name`.
            motion_core::message! { struct $name in BE { $($field: $field_type,)* } }

            impl self::$name {
                const fn data(&self) -> $name {
                    $name { $($field: self.$field,)* }
                }
            }

            impl<'m> Message<'m> for self::$name {
                const LAYOUT: &'static [Row] = $name::LAYOUT;

                #[inline]
                fn decode(body: &'m [u8]) -> Result<Self, DecodeError> {
                    Self::decode_as(<$sub_type>::default().number(0), body)
                }

                #[inline]
                fn decode_as(number: u32, body: &'m [u8]) -> Result<Self, DecodeError> {
                    let $name { $($field,)* } = $name::decode(body)?;
                    Ok(Self { $sub: <$sub_type>::of(number), $($field,)* })
                }

                #[inline]
                fn number(&self, declared: u32) -> u32 {
                    self.$sub.number(declared)
                }

                #[inline]
                fn encoded_len(&self) -> usize {
                    self.data().encoded_len()
                }

                #[inline]
                fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
                    self.data().encode_into(out)
                }
            }

            impl Fields for self::$name {
                fn fields(&self, visitor: &mut dyn Visitor) {
                    self.$sub.show(visitor);
                    self.data().fields(visitor);
                }
            }

            motion_core::__message_features! { 'm [self::$name] $name }
        };
    )*};
}
pub(crate) use sub_messages;
