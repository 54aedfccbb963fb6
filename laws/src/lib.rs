//! The laws that every message and every stream obeys, written once, over any table and any framing.
//!
//! The tests of each crate and the fuzz targets call them; a broken law is a panic that names its number in
//! `docs/architecture.md`.

pub mod machine;
pub mod message;
pub mod owned;

pub mod stream;
