//! Modules that the benches share.

pub mod decode;
pub mod ratios;
pub mod report;
mod targets;
pub mod traffic;
