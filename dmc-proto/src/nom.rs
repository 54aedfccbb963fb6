//! Frames and their messages as nom 8 parsers, over the same decoders as everything else. Feature `nom`; it adds the
//! dependencies `nom` and `memchr`.
//!
//! What they answer where no frame stands, or less than one, is told in [`motion_core::nom`]. A frame whose data is too
//! short for its type is an error of the kind `MapRes`, made from the [`DecodeError`](crate::DecodeError).
//!
//! ```
//! use dmc_proto::nom::{complete, streaming};
//! use dmc_proto::{HostMessage, MessageId};
//! use nom::error::Error;
//! use nom::{Err, Needed};
//!
//! let bytes = b"DF\x01\0\0\0\x01\0\0\0\x44\x2fDF\x02";
//! let (rest, (id, message)) = complete::host_message::<Error<_>>(bytes).unwrap();
//! assert!(matches!(message, HostMessage::Hi(_)));
//! assert_eq!(id, MessageId(1));
//!
//! let next = streaming::host_message::<Error<_>>(rest);
//! assert_eq!(next, Err(Err::Incomplete(Needed::new(7))), "the rest of the header");
//! ```

macro_rules! parsers {
    ($($(#[$meta:meta])* $mode:ident)*) => {$(
        $(#[$meta])*
        pub mod $mode {
            use motion_core::nom::$mode;
            use nom::error::{FromExternalError, ParseError};
            use nom::{IResult, Parser};

            use crate::{DecodeError, DeviceMessage, Dmc, Frame, HostMessage, MessageId};

            /// Parses one frame.
            ///
            /// # Errors
            ///
            /// Those of [`motion_core::nom`].
            pub fn frame<'a, E: ParseError<&'a [u8]>>(input: &'a [u8]) -> IResult<&'a [u8], Frame<'a>, E> {
                $mode::frame::<Dmc, E>(input)
            }

            /// Parses one frame and its message from the host.
            ///
            /// # Errors
            ///
            /// Those of [`frame`], and [`DecodeError`].
            pub fn host_message<'a, E>(input: &'a [u8]) -> IResult<&'a [u8], (MessageId, HostMessage<'a>), E>
            where
                E: ParseError<&'a [u8]> + FromExternalError<&'a [u8], DecodeError>,
            {
                frame.map_res(|frame| Ok((frame.id(), HostMessage::decode(&frame)?))).parse(input)
            }

            /// Parses one frame and its message from the device.
            ///
            /// # Errors
            ///
            /// Those of [`frame`], and [`DecodeError`].
            pub fn device_message<'a, E>(input: &'a [u8]) -> IResult<&'a [u8], (MessageId, DeviceMessage<'a>), E>
            where
                E: ParseError<&'a [u8]> + FromExternalError<&'a [u8], DecodeError>,
            {
                frame.map_res(|frame| Ok((frame.id(), DeviceMessage::decode(&frame)?))).parse(input)
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
