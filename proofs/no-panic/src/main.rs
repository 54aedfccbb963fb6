//! Links only if nothing in the libraries can panic.
//!
//! It reads bytes and does with them everything that the libraries can do with bytes that nobody has checked: find
//! frames, decode, lint, print and encode them. The panic handler calls a function that does not exist, so whatever the
//! optimiser could not prove free of panics fails to link, with that function's name. This is the only unsafe code of
//! the project, and no library contains it.

#![no_std]
#![no_main]

mod exercise;
mod host;
mod machines;

use core::fmt::Write;

use host::Output;

/// Bytes of input that are looked at.
const INPUT: usize = 16 * 1024;

#[unsafe(no_mangle)]
extern "C" fn main() -> i32 {
    let mut buffer = [0; INPUT];
    let input = host::read(&mut buffer);
    let mut out = Output;
    // The proof of the proof: an index that nobody has checked.
    #[cfg(feature = "control")]
    if input[7] == 7 {
        return 7;
    }
    match exercise::everything(input, &mut out).and_then(|()| out.write_str("\n")) {
        Ok(()) => 0,
        Err(_) => 1,
    }
}
