//! MoCoBus, the protocol of Dynamic Perception's NMX motion controllers ("hoot"), without I/O.
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
pub mod query;

pub use frame::{Address, Frame, FrameError, Frames, Header, Hoot, Selector, Strict};
pub use message::{DeviceMessage, HostMessage};
pub use motion_core::stream::Item;
pub use motion_core::wire::{DecodeError, EncodeError};
pub use query::{AnyQuery, AnyReply, Query, ReplyError};

#[doc = include_str!("../README.md")]
#[cfg(doctest)]
struct ReadmeDoctests;
