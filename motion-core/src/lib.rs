//! Shared parts of the codecs of three motion-control protocols, `kos-proto`, `dmc-proto` and `hoot-proto`. A protocol of
//! your own can be built on them too.
//!
//! - [`wire`]: fields, parts, and the tables that turn one list of fields into a message;
//! - [`stream`]: frames from bytes that arrive in pieces, in linear work and without allocation, whatever was sent;
//! - [`fletcher`]: the checksum of DMC, fast on long frames and on short ones;
//! - [`fixed`]: decimal numbers that travel as integers, exact in both directions;
//! - [`parse`]: values from text that people type;
//! - [`lint`]: findings about messages that decode, but that a strict peer would refuse or a wise sender would not send;
//! - [`machine`]: state machines without I/O, and the contract that all of them keep;
//! - [`session`]: parts of the sessions, which are machines with the stream buffers of their links;
//! - [`time`]: milliseconds that the caller counts;
//! - [`bezier`], [`trajectory`], [`profile`]: curves, axes of several curves, and point-to-point moves.
//!
//! The crate does no I/O and reads no clock. It allocates only if a feature says so, and it never panics.
//!
//! ```
//! use motion_core::fixed::Milli;
//! use motion_core::fletcher;
//!
//! // 23.976 frames a second travel as 23976.
//! let rate: Milli<u32> = "23.976".parse()?;
//! assert_eq!(rate.raw(), 23_976);
//!
//! // A frame of DMC: Dragonframe greets a controller. Marker, id 17, type 1, no data, two check bytes.
//! let frame = b"DF\x11\0\0\0\x01\0\0\0\xb3\xaf";
//! assert!(fletcher::verify(frame));
//! # Ok::<(), motion_core::fixed::FixedError>(())
//! ```
//!
//! ```
//! use motion_core::fletcher::Sum;
//!
//! // Sums of neighbouring pieces join in constant time.
//! let (head, tail) = b"any bytes at all".split_at(7);
//! assert_eq!(Sum::of(head).then(Sum::of(tail), tail.len()), Sum::of(b"any bytes at all"));
//! ```
//!
//! # Features
//!
//! Features only add. `std` and `alloc` cost nothing else; each other feature brings in the crate that it is named after.
//!
//! | feature | brings |
//! |---|---|
//! | `alloc` | owned messages |
//! | `std` | `alloc`, and nothing else yet; for programs that switch it on everywhere |
//! | `bytes` | encoding into any `BufMut` |
//! | `serde` | `Serialize` for every message; with `alloc`, `Deserialize` for owned ones; both for units, open enums, flags and curves |
//! | `defmt` | `Format` for messages, units, codes, states and events, without text on the target |
//! | `arbitrary` | `Arbitrary` for every message, borrowed or owned; implies `std` |
//! | `tokio` | typed messages as a `tokio_util` codec; implies `std` |
//! | `embedded-io` | frames from an `embedded_io` reader |
//! | `nom` | frames and messages as nom parsers |

#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![cfg_attr(
    not(test),
    deny(
        clippy::arithmetic_side_effects,
        clippy::cast_possible_truncation,
        clippy::expect_used,
        clippy::indexing_slicing,
        clippy::panic,
        clippy::unwrap_used
    )
)]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(any(test, feature = "std"))]
extern crate std;

pub mod bezier;
#[cfg(feature = "bytes")]
pub mod buf;
#[cfg(feature = "tokio")]
pub mod codec;
#[cfg(all(feature = "alloc", feature = "serde"))]
mod deserialize;
pub mod fixed;
pub mod fletcher;
#[cfg(feature = "defmt")]
pub mod format;
pub mod lint;
pub mod machine;
#[cfg(feature = "nom")]
pub mod nom;
#[cfg(feature = "alloc")]
pub mod owned;
pub mod parse;
pub mod profile;
#[cfg(feature = "serde")]
pub mod raw;
#[cfg(feature = "serde")]
pub mod serialize;
pub mod session;
pub mod stream;
pub mod time;
pub mod trajectory;
pub mod wire;

#[doc(hidden)]
#[cfg(feature = "arbitrary")]
pub use arbitrary;
#[doc(hidden)]
#[cfg(feature = "bytes")]
pub use bytes;
#[doc(hidden)]
#[cfg(feature = "defmt")]
pub use defmt;
#[doc(hidden)]
#[cfg(feature = "serde")]
pub use serde;
#[doc(hidden)]
pub use zerocopy;

#[doc = include_str!("../README.md")]
#[cfg(doctest)]
struct ReadmeDoctests;
