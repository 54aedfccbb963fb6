//! Board: its clock, its serial port, and the ways to print and to end the emulator.

use core::cell::RefCell;
use core::convert::Infallible;
use core::ffi::CStr;
use core::panic::PanicInfo;
use core::task::Waker;

use cortex_m::interrupt::InterruptNumber;
use cortex_m::peripheral::{NVIC, Peripherals, syst::SystClkSource};
use cortex_m_rt::exception;
use embassy_futures::yield_now;
use embassy_sync::blocking_mutex::{Mutex, raw::CriticalSectionRawMutex};
use embassy_sync::pipe::Pipe;
use embassy_time_driver::{Driver, time_driver_impl};
use embassy_time_queue_utils::Queue;
use embedded_io_async::{ErrorType, Read, Write};

/// Number of ticks of the processor in a millisecond.
const TICKS: u32 = 25_000;

/// Clock: milliseconds since the start, counted by the timer of the processor.
struct Clock(Mutex<CriticalSectionRawMutex, RefCell<(u64, Queue)>>);

time_driver_impl!(static CLOCK: Clock = Clock(Mutex::new(RefCell::new((0, Queue::new())))));

impl Driver for Clock {
    fn now(&self) -> u64 {
        self.0.lock(|clock| clock.borrow().0)
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        self.0.lock(|clock| clock.borrow_mut().1.schedule_wake(at, waker));
    }
}

#[exception]
fn SysTick() {
    CLOCK.0.lock(|clock| {
        let (now, queue) = &mut *clock.borrow_mut();
        *now += 1;
        queue.next_expiration(*now);
    });
}

/// Starts the clock, and returns the serial port. Call it once.
#[must_use]
pub fn start() -> Serial {
    if let Some(mut board) = Peripherals::take() {
        board.SYST.set_clock_source(SystClkSource::Core);
        board.SYST.set_reload(TICKS - 1);
        board.SYST.clear_current();
        board.SYST.enable_counter();
        board.SYST.enable_interrupt();
    }
    write(DIVIDER, TICKS * 1000 / 115_200);
    // It sends, receives, and interrupts when a byte has arrived.
    write(CONTROL, 0b1011);
    // SAFETY: no code relies on the interrupt being masked.
    unsafe { NVIC::unmask(Arrival) };
    Serial(())
}

/// Serial port of the board. What arrives while the device sends waits in [`RECEIVED`], so that no stop is lost.
pub struct Serial(());

/// Bytes that arrived and are not read. At 115,200 baud, 512 bytes take 44 milliseconds, and the longest message of a DMC device
/// takes 13. Without room a byte is dropped. Then the check bytes of its message are wrong, and the host sends the message again.
static RECEIVED: Pipe<CriticalSectionRawMutex, 512> = Pipe::new();

/// Interrupt of a byte that has arrived.
#[derive(Clone, Copy)]
struct Arrival;

// SAFETY: the board has this interrupt, and only this type stands for it.
unsafe impl InterruptNumber for Arrival {
    fn number(self) -> u16 {
        0
    }
}

/// Handler of all interrupts that have none of their own.
#[exception]
unsafe fn DefaultHandler(number: i16) {
    assert_eq!(number, Arrival.number().cast_signed(), "no other interrupt is switched on");
    // A byte that arrives after this line interrupts again.
    write(INTERRUPT, ARRIVAL);
    while read(STATE) & ARRIVED != 0 {
        let _ = RECEIVED.try_write(&[read(DATA) as u8]);
    }
}

/// Registers of the serial port: the byte, the state, what is switched on, what has interrupted, and the divider of the speed.
const DATA: *mut u32 = 0x4000_4000 as *mut u32;
const STATE: *mut u32 = 0x4000_4004 as *mut u32;
const CONTROL: *mut u32 = 0x4000_4008 as *mut u32;
const INTERRUPT: *mut u32 = 0x4000_400C as *mut u32;
const DIVIDER: *mut u32 = 0x4000_4010 as *mut u32;

/// Bit of the interrupt that a byte which arrived has made.
const ARRIVAL: u32 = 0b10;

/// Bits of the state: no byte can be written now, and a byte can be read.
const FULL: u32 = 0b01;
const ARRIVED: u32 = 0b10;

fn read(register: *mut u32) -> u32 {
    // SAFETY: only the registers above are read. They are always there.
    unsafe { register.read_volatile() }
}

fn write(register: *mut u32, value: u32) {
    // SAFETY: only the registers above are written. They are always there.
    unsafe { register.write_volatile(value) }
}

impl ErrorType for Serial {
    type Error = Infallible;
}

impl Read for Serial {
    async fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Infallible> {
        Ok(RECEIVED.read(bytes).await)
    }
}

impl Write for Serial {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        let [first, ..] = bytes else { return Ok(0) };
        while read(STATE) & FULL != 0 {
            yield_now().await;
        }
        write(DATA, (*first).into());
        Ok(1)
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// Operations of the emulator (Arm semihosting): write a text that ends with a NUL, and end.
const WRITE: u32 = 0x04;
const EXIT: u32 = 0x18;
/// Reasons to end. With the first the emulator has the exit status 0, with the other 1.
const DONE: u32 = 0x20026;
const FAILED: u32 = 0x20024;

/// Prints a text by the emulator.
pub fn print(text: &CStr) {
    // SAFETY: the emulator reads the text up to its end.
    unsafe { cortex_m::asm::semihosting_syscall(WRITE, text.as_ptr().addr() as u32) };
}

/// Ends the emulator.
pub fn exit(passed: bool) -> ! {
    loop {
        // SAFETY: the reason is a number.
        unsafe { cortex_m::asm::semihosting_syscall(EXIT, if passed { DONE } else { FAILED }) };
    }
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    print(c"panic");
    exit(false)
}
