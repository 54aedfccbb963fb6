//! Frames as nom 8 parsers, over the same decoders as everything else. Feature `nom`; it adds the dependencies `nom` and
//! `memchr`.
//!
//! [`complete`] holds all there is in its input, so a frame that is cut off is an error. In [`streaming`] more may come,
//! and such a frame is [`Err::Incomplete`] with the number of bytes that will tell more. Both
//! parse one frame from the start of the input. They search for none and skip no noise: for a line that may be noisy,
//! use [`Frames`](crate::stream::Frames).
//!
//! | what stands there | answer |
//! |---|---|
//! | a whole frame | the frame |
//! | less than a frame | `Incomplete`, or in [`complete`] [`ErrorKind::Eof`] |
//! | a frame that does not verify | [`ErrorKind::Verify`] |
//! | a frame longer than [`Framing::MAX`] | [`ErrorKind::TooLarge`] |
//! | no frame | [`ErrorKind::Tag`] |
//! | no frame, nor any hope ([`Head::Fatal`]) | a failure, [`ErrorKind::Tag`] |
//!
//! ```
//! # use motion_core::stream::{Framing, Head, Noise};
//! # #[derive(Debug)]
//! # enum Shout {}
//! # impl Framing for Shout {
//! #     const MAX: usize = 2 + 20;
//! #     type Header = ();
//! #     type Frame<'a> = &'a [u8];
//! #     type Memo<const N: usize> = ();
//! #     fn head(bytes: &[u8]) -> Head {
//! #         match bytes {
//! #             [b'!', len @ 0..=20, ..] => Head::Total(2 + usize::from(*len)),
//! #             [b'!'] => Head::More(2),
//! #             _ => Head::Skip(1, Noise::NoMarker),
//! #         }
//! #     }
//! #     fn header(_: &[u8]) -> Option<()> { Some(()) }
//! #     fn frame(bytes: &[u8]) -> Option<&[u8]> { Some(bytes) }
//! # }
//! use motion_core::nom::{complete, streaming};
//! use nom::error::{Error, ErrorKind};
//! use nom::{Err, Needed, Parser};
//!
//! // The frames of `Shout` are a `!`, the length of a text, and the text.
//! let frames = b"!\x05Hello!\x02yo..";
//! let mut two = (complete::frame::<Shout, Error<_>>, complete::frame::<Shout, _>);
//! assert_eq!(two.parse(frames), Ok((&b".."[..], (&b"!\x05Hello"[..], &b"!\x02yo"[..]))));
//!
//! let cut = streaming::frame::<Shout, Error<_>>(b"!\x05Hel");
//! assert_eq!(cut, Err(Err::Incomplete(Needed::new(2))));
//! let cut = complete::frame::<Shout, Error<_>>(b"!\x05Hel");
//! assert!(matches!(cut, Err(Err::Error(error)) if error.code == ErrorKind::Eof));
//! ```

use nom::error::{ErrorKind, FromExternalError, ParseError};
use nom::{Err, IResult, Parser};

use crate::stream::{Framing, Head, Memo, Noise};
use crate::wire::{DecodeError, Framed};

/// Parsers for input that holds all there is.
pub mod complete {
    use nom::IResult;
    use nom::error::{ErrorKind, FromExternalError, ParseError};

    use super::error;
    use crate::stream::Framing;
    use crate::wire::{DecodeError, Framed};

    /// Parses one frame.
    ///
    /// # Errors
    ///
    /// Those in the table of the [module](super).
    pub fn frame<'a, F: Framing, E: ParseError<&'a [u8]>>(input: &'a [u8]) -> IResult<&'a [u8], F::Frame<'a>, E> {
        super::frame::<F, E>(input, |_| error(input, ErrorKind::Eof))
    }

    /// Parses one message of a side.
    ///
    /// # Errors
    ///
    /// The errors of [`frame`], and one of the kind `MapRes`, made from the [`DecodeError`], if
    /// the body of the frame is too short.
    pub fn message<'a, S: Framed, E>(input: &'a [u8]) -> IResult<&'a [u8], S::Message<'a>, E>
    where
        E: ParseError<&'a [u8]> + FromExternalError<&'a [u8], DecodeError>,
    {
        super::decoded::<S, E>(frame::<S::Framing, E>, input)
    }
}

/// Parsers for input that may go on.
pub mod streaming {
    use nom::error::{FromExternalError, ParseError};
    use nom::{Err, IResult, Needed};

    use crate::stream::Framing;
    use crate::wire::{DecodeError, Framed};

    /// Parses one frame.
    ///
    /// # Errors
    ///
    /// Those in the table of the [module](super). [`Err::Incomplete`] never asks for more than is missing of
    /// [`Framing::MAX`] bytes.
    pub fn frame<'a, F: Framing, E: ParseError<&'a [u8]>>(input: &'a [u8]) -> IResult<&'a [u8], F::Frame<'a>, E> {
        super::frame::<F, E>(input, |missing| Err::Incomplete(Needed::new(missing)))
    }

    /// Parses one message of a side.
    ///
    /// # Errors
    ///
    /// The errors of [`frame`], and one of the kind `MapRes`, made from the [`DecodeError`], if
    /// the body of the frame is too short.
    pub fn message<'a, S: Framed, E>(input: &'a [u8]) -> IResult<&'a [u8], S::Message<'a>, E>
    where
        E: ParseError<&'a [u8]> + FromExternalError<&'a [u8], DecodeError>,
    {
        super::decoded::<S, E>(frame::<S::Framing, E>, input)
    }
}

/// Parses one frame; `cut_off` is the error where so many bytes are missing.
fn frame<'a, F: Framing, E: ParseError<&'a [u8]>>(
    input: &'a [u8],
    cut_off: impl FnOnce(usize) -> Err<E>,
) -> IResult<&'a [u8], F::Frame<'a>, E> {
    if input.is_empty() {
        return Err(cut_off(1));
    }
    let kind = match F::head(input) {
        Head::Total(total @ 1..) | Head::More(total) if total > input.len() => {
            if total <= F::MAX {
                return Err(cut_off(total.saturating_sub(input.len())));
            }
            ErrorKind::TooLarge
        }
        Head::Total(len @ 1..) => {
            let found = input.split_at_checked(len).filter(|(frame, _)| F::Memo::<0>::is_sound(frame));
            if let Some((rest, frame)) = found.and_then(|(frame, rest)| Some((rest, F::frame(frame)?))) {
                return Ok((rest, frame));
            }
            ErrorKind::Verify
        }
        Head::Skip(_, Noise::TooLong { .. }) => ErrorKind::TooLarge,
        Head::Total(0) | Head::More(_) | Head::Skip(..) => ErrorKind::Tag,
        Head::Fatal(_) => return Err(Err::Failure(E::from_error_kind(input, ErrorKind::Tag))),
    };
    Err(error(input, kind))
}

/// Parses one frame and decodes its message.
fn decoded<'a, S: Framed, E>(
    frame: impl Fn(&'a [u8]) -> IResult<&'a [u8], <S::Framing as Framing>::Frame<'a>, E>,
    input: &'a [u8],
) -> IResult<&'a [u8], S::Message<'a>, E>
where
    E: ParseError<&'a [u8]> + FromExternalError<&'a [u8], DecodeError>,
{
    frame.map_res(|frame| S::decode(&frame)).parse(input)
}

/// Makes the parsers of one protocol, over its framing and the types of its two sides.
#[doc(hidden)]
#[macro_export]
macro_rules! parsers {
    ($framing:ty, $host:ty, $device:ty) => {
        $crate::parsers! { @mode
            /// Parsers for input that holds all there is.
            complete ($framing, $host, $device)
        }
        $crate::parsers! { @mode
            /// Parsers for input that may go on.
            streaming ($framing, $host, $device)
        }
    };
    (@mode $(#[$meta:meta])* $mode:ident ($framing:ty, $host:ty, $device:ty)) => {
        $(#[$meta])*
        pub mod $mode {
            use $crate::nom::$mode;
            use $crate::stream::Framing;
            use $crate::wire::{DecodeError, Side};
            use nom::IResult;
            use nom::error::{FromExternalError, ParseError};

            /// Parses one frame.
            ///
            /// # Errors
            ///
            /// The errors that [`motion_core::nom`](https://docs.rs/motion-core/latest/motion_core/nom) lists.
            pub fn frame<'a, E: ParseError<&'a [u8]>>(
                input: &'a [u8],
            ) -> IResult<&'a [u8], <$framing as Framing>::Frame<'a>, E> {
                $mode::frame::<$framing, E>(input)
            }

            /// Parses one message from the host.
            ///
            /// # Errors
            ///
            /// The errors of [`frame`], and one made from a [`DecodeError`].
            pub fn host_message<'a, E>(
                input: &'a [u8],
            ) -> IResult<&'a [u8], <$host as Side>::Message<'a>, E>
            where
                E: ParseError<&'a [u8]> + FromExternalError<&'a [u8], DecodeError>,
            {
                $mode::message::<$host, E>(input)
            }

            /// Parses one message from the device.
            ///
            /// # Errors
            ///
            /// The errors of [`frame`], and one made from a [`DecodeError`].
            pub fn device_message<'a, E>(
                input: &'a [u8],
            ) -> IResult<&'a [u8], <$device as Side>::Message<'a>, E>
            where
                E: ParseError<&'a [u8]> + FromExternalError<&'a [u8], DecodeError>,
            {
                $mode::message::<$device, E>(input)
            }
        }
    };
}

fn error<'a, E: ParseError<&'a [u8]>>(input: &'a [u8], kind: ErrorKind) -> Err<E> {
    Err::Error(E::from_error_kind(input, kind))
}
