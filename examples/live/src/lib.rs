//! Simulated rigs on real transports, and hosts for real rigs.

pub mod drive;
pub mod program;
pub mod serve;
pub mod session;
pub mod simulate;
