//! What the benches share.

pub mod ratios;
