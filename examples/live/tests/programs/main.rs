//! `simulate` and `drive`, as somebody would start them: over loopback TCP, loopback UDP and pseudo-terminals.
#![cfg(unix)]

mod bad;
mod cable;
mod dmc;
mod hoot;
mod kos;
mod process;
mod record;
mod serving;
