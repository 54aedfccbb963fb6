//! Parsers of nom 8 for frames and their messages, with the decoders of this crate. The feature `nom` adds the dependencies
//! `nom` and `memchr`.
//!
//! [`motion_core::nom`] lists the errors for bytes that are not a whole frame. A frame whose data is too short for its type
//! is an error of the kind `MapRes`, made from the [`DecodeError`](crate::DecodeError). To get the id of a message, parse
//! the frame and decode it.
//!
//! ```
//! use dmc_proto::nom::{complete, streaming};
//! use dmc_proto::{HostMessage, MessageId};
//! use nom::error::Error;
//! use nom::{Err, Needed};
//!
//! let bytes = b"DF\x01\0\0\0\x01\0\0\0\x44\x2fDF\x02";
//! let (rest, message) = complete::host_message::<Error<_>>(bytes).unwrap();
//! assert!(matches!(message, HostMessage::Hi(_)));
//!
//! let (_, frame) = complete::frame::<Error<_>>(bytes).unwrap();
//! assert_eq!((frame.id(), HostMessage::decode(&frame)), (MessageId(1), Ok(message)));
//!
//! let next = streaming::host_message::<Error<_>>(rest);
//! assert_eq!(next, Err(Err::Incomplete(Needed::new(7))), "the rest of the header");
//! ```

motion_core::parsers! { crate::Dmc, crate::Host, crate::Device }
