//! The laws that every message, stream and machine obeys, written once, over any table, framing and machine.
//!
//! The tests of each crate, the fuzz targets and the model checks call them. A broken law is a panic that names its number
//! in `docs/architecture.md`.

pub mod drawn;
pub mod machine;
pub mod message;
pub mod owned;
pub mod stream;
pub mod world;
