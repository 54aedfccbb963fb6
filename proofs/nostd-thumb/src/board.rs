//! The board: where the processor starts, and how it talks to the emulator around it (Arm semihosting).

use core::arch::asm;
use core::ffi::CStr;

/// Writes a text that ends with a NUL.
const SYS_WRITE0: u32 = 0x04;
/// Ends the program, for a reason.
const SYS_EXIT: u32 = 0x18;
/// The reason that makes the emulator's exit status 0; with any other it is 1.
const APPLICATION_EXIT: usize = 0x20026;
const INTERNAL_ERROR: usize = 0x20024;

/// The first two words of memory: the stack, and what runs first.
#[unsafe(link_section = ".vectors")]
#[used]
static VECTORS: [unsafe extern "C" fn() -> !; 2] = {
    unsafe extern "C" {
        fn _stack_top() -> !;
    }
    [_stack_top, super::reset]
};

/// Prints a text.
pub fn say(text: &CStr) {
    semihost(SYS_WRITE0, text.as_ptr().addr());
}

/// Ends the emulator.
pub fn exit(passed: bool) -> ! {
    semihost(SYS_EXIT, if passed { APPLICATION_EXIT } else { INTERNAL_ERROR });
    loop {}
}

fn semihost(operation: u32, argument: usize) {
    // SAFETY: the debugger's breakpoint changes r0 alone, and reads the text, which lives on.
    unsafe { asm!("bkpt #0xab", inout("r0") operation => _, in("r1") argument, options(nostack)) }
}
