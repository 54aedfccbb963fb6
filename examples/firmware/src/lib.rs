//! Devices for an emulated Cortex-M4 (the board mps2-an386), with embassy: a DMC device, a hoot node and a kOS device.
//!
//! Each device is an async function over any line that has the traits of `embedded-io-async`. Its motors are counters. The
//! programs in `src/bin` run the devices on the serial port of the board. The program `loopback` runs the three
//! over lines in memory against hosts, and prints OK:
//!
//! ```console
//! rustup target add thumbv7em-none-eabihf
//! cd examples/firmware
//! cargo run --release
//! ```
//!
//! Each device calls its session itself. The driver `motion_io::embedded` has the same loop.

#![no_std]

pub mod board;
pub mod dmc;
pub mod hoot;
pub mod kos;
pub mod line;
