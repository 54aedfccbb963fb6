//! tshark prints of each vector what the crates decode.
//!
//! The tests need tshark, so that `cargo test` does not run them. `.ci/dissectors` does.

mod capture;
mod compare;
mod kos;
mod pairs;
mod pdml;
mod random;
mod serial;
