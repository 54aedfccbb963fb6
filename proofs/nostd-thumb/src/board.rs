//! Board: the entry of the processor, and calls to the emulator (Arm semihosting).

use core::arch::asm;
use core::ffi::CStr;

/// Operation that writes a text, which ends with a NUL.
const SYS_WRITE0: u32 = 0x04;
/// Operation that ends the program with a reason.
const SYS_EXIT: u32 = 0x18;
/// Reason for which the emulator exits with status 0. With any other reason the status is 1.
const APPLICATION_EXIT: usize = 0x20026;
const INTERNAL_ERROR: usize = 0x20024;

/// First two words of memory: the stack pointer and the entry.
#[unsafe(link_section = ".vectors")]
#[used]
static VECTORS: [unsafe extern "C" fn() -> !; 2] = {
    unsafe extern "C" {
        fn _stack_top() -> !;
    }
    [_stack_top, super::reset]
};

/// Prints a text.
pub fn print(text: &CStr) {
    semihost(SYS_WRITE0, text.as_ptr().addr());
}

/// Ends the emulator.
pub fn exit(passed: bool) -> ! {
    semihost(SYS_EXIT, if passed { APPLICATION_EXIT } else { INTERNAL_ERROR });
    loop {}
}

fn semihost(operation: u32, argument: usize) {
    // SAFETY: the breakpoint of the debugger changes only r0, and reads the text, which stays valid.
    unsafe { asm!("bkpt #0xab", inout("r0") operation => _, in("r1") argument, options(nostack)) }
}
