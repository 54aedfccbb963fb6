//! Packets and their messages as nom 8 parsers, which use the decoders of this crate. Feature `nom`, which adds the
//! dependencies `nom` and `memchr`.
//!
//! [`motion_core::nom`] lists the errors for bytes that are no packet, or only a part of one. Every valid packet
//! contains a message. The address of a request is that of its frame: parse the [`frame`](complete::frame) to see it.
//!
//! ```
//! use hoot_proto::HostMessage;
//! use hoot_proto::nom::{complete, streaming};
//! use nom::error::Error;
//! use nom::{Err, Needed};
//!
//! let bytes = b"\0\0\0\0\0\xFF\x03\0\x04\0\0\0";
//! let (rest, message) = complete::host_message::<Error<_>>(bytes).unwrap();
//! assert!(matches!(message, HostMessage::Stop(_)));
//!
//! let next = streaming::host_message::<Error<_>>(rest);
//! assert_eq!(next, Err(Err::Incomplete(Needed::new(8))), "the rest of the header");
//! ```

motion_core::parsers! { crate::Hoot, crate::Host, crate::Device }
