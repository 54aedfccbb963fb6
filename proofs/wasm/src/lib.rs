//! WebAssembly module: one message of each protocol is found in a stream, decoded, checked and encoded.

#![no_std]

mod messages;

use core::panic::PanicInfo;

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    core::arch::wasm32::unreachable()
}

/// Number of protocols that passed.
#[unsafe(no_mangle)]
pub extern "C" fn passed() -> usize {
    messages::CHECKS.iter().filter(|(_, check)| check().is_some()).count()
}
