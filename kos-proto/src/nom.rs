//! Frames and their messages as nom 8 parsers, over the same decoders as everything else. Feature `nom`; it adds the
//! dependencies `nom` and `memchr`.
//!
//! What they answer where no frame stands, or less than one, is told in [`motion_core::nom`]. A message whose body is
//! too short for its kind is an error of the kind `MapRes`, made from the [`DecodeError`](crate::DecodeError).
//!
//! ```
//! use kos_proto::HostMessage;
//! use kos_proto::nom::{complete, streaming};
//! use nom::error::Error;
//! use nom::{Err, Needed};
//!
//! let bytes = [4, 0, 6, 0, 0x0F, 1, 4, 0, 6];
//! let (rest, message) = complete::host_message::<Error<_>>(&bytes).unwrap();
//! assert!(matches!(message, HostMessage::GetDeviceInfo(_)));
//!
//! let next = streaming::host_message::<Error<_>>(rest);
//! assert_eq!(next, Err(Err::Incomplete(Needed::new(3))));
//! ```

macro_rules! parsers {
    ($($(#[$meta:meta])* $mode:ident)*) => {$(
        $(#[$meta])*
        pub mod $mode {
            use motion_core::nom::$mode;
            use nom::error::{FromExternalError, ParseError};
            use nom::{IResult, Parser};

            use crate::{DecodeError, DeviceMessage, Frame, HostMessage, Kos};

            /// Parses one frame.
            ///
            /// # Errors
            ///
            /// Those of [`motion_core::nom`].
            pub fn frame<'a, E: ParseError<&'a [u8]>>(input: &'a [u8]) -> IResult<&'a [u8], Frame<'a>, E> {
                $mode::frame::<Kos, E>(input)
            }

            /// Parses one message from the host.
            ///
            /// # Errors
            ///
            /// Those of [`frame`], and [`DecodeError`].
            pub fn host_message<'a, E>(input: &'a [u8]) -> IResult<&'a [u8], HostMessage<'a>, E>
            where
                E: ParseError<&'a [u8]> + FromExternalError<&'a [u8], DecodeError>,
            {
                frame.map_res(|frame| HostMessage::decode(&frame)).parse(input)
            }

            /// Parses one message from the device.
            ///
            /// # Errors
            ///
            /// Those of [`frame`], and [`DecodeError`].
            pub fn device_message<'a, E>(input: &'a [u8]) -> IResult<&'a [u8], DeviceMessage<'a>, E>
            where
                E: ParseError<&'a [u8]> + FromExternalError<&'a [u8], DecodeError>,
            {
                frame.map_res(|frame| DeviceMessage::decode(&frame)).parse(input)
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
