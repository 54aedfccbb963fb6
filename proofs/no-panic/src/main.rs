//! Links only if nothing in the libraries can panic.
//!
//! The program reads bytes and does everything that the libraries can do with unchecked bytes: it finds frames,
//! decodes, lints, prints and encodes them. The panic handler calls a function that does not exist. So code that the
//! optimiser cannot prove free of panics fails to link, with the name of that function. This is the only unsafe code of
//! the project, and no library contains it.

#![no_std]
#![no_main]

mod exercise;
mod host;
mod machines;
mod sessions;

use core::fmt::Write;

use host::Output;

/// Greatest number of input bytes that are read.
const INPUT: usize = 16 * 1024;

#[unsafe(no_mangle)]
extern "C" fn main() -> i32 {
    let mut buffer = [0; INPUT];
    let input = host::read(&mut buffer);
    let mut out = Output;
    // Check of the proof: an index that is not checked.
    #[cfg(feature = "control")]
    if input[7] == 7 {
        return 7;
    }
    match exercise::everything(input, &mut out).and_then(|()| out.write_str("\n")) {
        Ok(()) => 0,
        Err(_) => 1,
    }
}
