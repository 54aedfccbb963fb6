//! Firmware for an emulated Cortex-M4: one message of each protocol is found in a stream, decoded, checked and encoded.
//!
//! It prints OK, or the protocol that failed, and ends the emulator with the exit status 0 or 1.

#![no_std]
#![no_main]

mod board;
mod messages;

use core::panic::PanicInfo;

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    board::print(c"panic");
    board::exit(false)
}

/// Entry of the processor.
extern "C" fn reset() -> ! {
    let mut passed = true;
    for (failed, check) in messages::CHECKS {
        if check().is_none() {
            board::print(failed);
            passed = false;
        }
    }
    if passed {
        board::print(c"OK");
    }
    board::exit(passed)
}
