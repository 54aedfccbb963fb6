//! Kessler kOS.

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

#[cfg(any(test, feature = "std"))]
extern crate std;

pub mod frame;
pub mod lint;
pub mod message;
pub mod trajectory;

pub use frame::{Frame, FrameError, Frames, Header, Kos, MessageId, MessageType};
pub use message::{DeviceMessage, HostMessage};
pub use motion_core::stream::Item;
pub use motion_core::wire::{DecodeError, EncodeError};
