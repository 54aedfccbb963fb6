//! motion-core

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
#[cfg(feature = "nom")]
pub mod nom;
#[cfg(feature = "alloc")]
pub mod owned;
#[cfg(feature = "serde")]
pub mod serialize;
pub mod stream;
pub mod time;
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
