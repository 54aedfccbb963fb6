//! What the benches share.

pub mod ratios;
pub mod traffic;
