//! Devices for an emulated Cortex-M4 (the board mps2-an386), with embassy: a DMC device, a hoot node and a kOS device.
//!
//! Each device is an async function over any line that has the traits of `embedded-io-async`. Its motors are counters. The
//! programs in `src/bin` run the devices on the serial port of the board, or over a line in memory against a host.

#![no_std]

pub mod board;
pub mod dmc;
pub mod hoot;
pub mod kos;
pub mod line;
