//! Packets and their messages as nom 8 parsers, over the same decoders as everything else. Feature `nom`; it adds the
//! dependencies `nom` and `memchr`.
//!
//! What they answer where no packet stands, or less than one, is told in [`motion_core::nom`]. What a sound
//! packet holds is always a message.
//!
//! ```
//! use hoot_proto::nom::{complete, streaming};
//! use hoot_proto::{Address, HostMessage};
//! use nom::error::Error;
//! use nom::{Err, Needed};
//!
//! let bytes = b"\0\0\0\0\0\xFF\x03\0\x04\0\0\0";
//! let (rest, (to, message)) = complete::host_message::<Error<_>>(bytes).unwrap();
//! assert_eq!(to, Address::DEFAULT);
//! assert!(matches!(message, HostMessage::Stop(_)));
//!
//! let next = streaming::host_message::<Error<_>>(rest);
//! assert_eq!(next, Err(Err::Incomplete(Needed::new(8))), "the rest of the header");
//! ```

macro_rules! parsers {
    ($($(#[$meta:meta])* $mode:ident)*) => {$(
        $(#[$meta])*
        pub mod $mode {
            use motion_core::nom::$mode;
            use nom::error::ParseError;
            use nom::{IResult, Parser};

            use crate::{Address, DeviceMessage, Frame, Hoot, HostMessage};

            /// Parses one packet.
            ///
            /// # Errors
            ///
            /// Those of [`motion_core::nom`].
            pub fn frame<'a, E: ParseError<&'a [u8]>>(input: &'a [u8]) -> IResult<&'a [u8], Frame<'a>, E> {
                $mode::frame::<Hoot, E>(input)
            }

            /// Parses one packet and its command from the master, with the address that it goes to.
            ///
            /// # Errors
            ///
            /// Those of [`frame`].
            pub fn host_message<'a, E: ParseError<&'a [u8]>>(
                input: &'a [u8],
            ) -> IResult<&'a [u8], (Address, HostMessage<'a>), E> {
                frame.map(|frame| (frame.address(), HostMessage::decode(&frame))).parse(input)
            }

            /// Parses one packet and its message from a node.
            ///
            /// # Errors
            ///
            /// Those of [`frame`].
            pub fn device_message<'a, E: ParseError<&'a [u8]>>(
                input: &'a [u8],
            ) -> IResult<&'a [u8], DeviceMessage<'a>, E> {
                frame.map(|frame| DeviceMessage::decode(&frame)).parse(input)
            }
        }
    )*};
}
parsers! {
    /// Parsers for input that holds all there is.
    complete
    /// Parsers for input that may go on.
    streaming
}
