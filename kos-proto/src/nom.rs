//! Parsers for nom 8 that read frames and their messages, with the same decoders as the rest of the crate.
//!
//! The feature `nom` adds them, and the dependencies `nom` and `memchr`.
//!
//! [`motion_core::nom`] says what the parsers return if the input begins with no frame, or with a part of one. A
//! message whose body is too short gives an error of the kind `MapRes`, made from the
//! [`DecodeError`](crate::DecodeError).
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

motion_core::parsers! { crate::Kos, crate::Host, crate::Device }
