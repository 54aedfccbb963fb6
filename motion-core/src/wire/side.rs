use core::fmt;
use core::hash::Hash;

use zerocopy::ByteOrder;

use super::Messages;

/// One side of a protocol: a type without values, which names what that side sends.
///
/// What is the same for all sides is written against it, once.
pub trait Side: Copy + Eq + Hash + fmt::Debug + 'static {
    /// All messages that it sends.
    type Message<'a>: Messages<'a>;

    /// The byte order of its numbers.
    type Order: ByteOrder;
}

/// Makes the type of a side, and what the features `alloc` and `bytes` add to its messages. In brackets stands what
/// `encode_into` wants to know before the buffer.
#[doc(hidden)]
#[macro_export]
macro_rules! side {
    ($(
        $(#[$meta:meta])*
        $vis:vis enum $name:ident in $order:ident: $message:ident($($know:ident: $type:ty)?);
    )*) => {$(
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        $vis enum $name {}

        impl $crate::wire::Side for $name {
            type Message<'a> = $message<'a>;
            type Order = $crate::zerocopy::$order;
        }

        $crate::__to_vec! { $message($($know: $type)?) }
        $crate::__encode! { $message($($know: $type)?) }
    )*};
}

#[doc(hidden)]
#[macro_export]
#[cfg(feature = "alloc")]
macro_rules! __to_vec {
    ($message:ident($($know:ident: $type:ty)?)) => {
        impl $message<'_> {
            /// Its whole frame, as a vector. Feature `alloc`.
            ///
            /// # Errors
            ///
            /// Those of `encode_into`, without that of a small buffer.
            #[allow(clippy::wrong_self_convention, reason = "taken by reference, as all other ways to write it")]
            pub fn to_vec(&self $(, $know: $type)?) -> Result<$crate::owned::Vec<u8>, $crate::wire::EncodeError> {
                $crate::owned::to_vec(self.encoded_len(), |out| self.encode_into($($know,)? out))
            }
        }
    };
}

#[doc(hidden)]
#[macro_export]
#[cfg(not(feature = "alloc"))]
macro_rules! __to_vec {
    ($($side:tt)*) => {};
}

#[doc(hidden)]
#[macro_export]
#[cfg(feature = "bytes")]
macro_rules! __encode {
    ($message:ident($($know:ident: $type:ty)?)) => {
        impl $message<'_> {
            /// Puts its whole frame at the end of `buf`, and says how many bytes it took. Feature `bytes`.
            ///
            /// It costs a copy; a frame of more than 128 bytes also costs an allocation.
            ///
            /// # Errors
            ///
            /// Those of `encode_into`. Then nothing is put.
            pub fn encode(
                &self,
                $($know: $type,)?
                buf: &mut impl $crate::bytes::BufMut,
            ) -> Result<usize, $crate::wire::EncodeError> {
                $crate::buf::put(buf, self.encoded_len(), |out| self.encode_into($($know,)? out))
            }
        }
    };
}

#[doc(hidden)]
#[macro_export]
#[cfg(not(feature = "bytes"))]
macro_rules! __encode {
    ($($side:tt)*) => {};
}
