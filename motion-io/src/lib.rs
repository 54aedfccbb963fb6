#![cfg_attr(feature = "tokio", doc = include_str!("../README.md"))]
#![cfg_attr(not(feature = "tokio"), doc = "Drivers of motion-control sessions. The features bring them.")]
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

#[cfg(feature = "std")]
extern crate std;

#[cfg(feature = "std")]
pub mod blocking;
#[cfg(feature = "embedded-io-async")]
pub mod embedded;
#[cfg(feature = "std")]
mod error;
#[cfg(any(feature = "std", feature = "embedded-io-async"))]
mod flow;
#[cfg(feature = "kos")]
pub mod kos;
#[cfg(feature = "std")]
mod line;
#[cfg(feature = "std")]
mod reconnect;
#[cfg(feature = "tokio")]
pub mod tokio;

#[cfg(feature = "std")]
pub use error::Error;
#[cfg(feature = "std")]
pub use reconnect::Reconnect;

/// Time within which a connection must be made.
#[cfg(feature = "std")]
const CONNECT: core::time::Duration = core::time::Duration::from_secs(5);
/// Time without a written byte after which a line counts as lost, in milliseconds.
#[cfg(feature = "std")]
const STALLED: u64 = 2_000;
/// Time for which a line that takes no bytes is still read, in milliseconds. The last message of the other end counts, for example
/// its answer to a stop.
#[cfg(feature = "std")]
const LAST: u64 = 50;
