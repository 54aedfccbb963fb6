//! Exports for JavaScript. Bytes are exchanged through one buffer of this module: the page asks for room, writes its request
//! there, calls, and reads the answer from there.

use std::cell::RefCell;

use crate::Page;

thread_local! {
    static PAGE: RefCell<Page> = RefCell::default();
    static BUFFER: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

/// Makes room for a request of this length. Returns the address at which the page writes the request.
#[unsafe(no_mangle)]
pub extern "C" fn room(len: usize) -> *const u8 {
    BUFFER.with_borrow_mut(|buffer| {
        buffer.clear();
        buffer.resize(len, 0);
        buffer.as_mut_ptr().cast_const()
    })
}

/// Answers the request in the buffer. Returns the length of the answer.
#[unsafe(no_mangle)]
pub extern "C" fn call() -> usize {
    let request = BUFFER.take();
    let answer = PAGE.with_borrow_mut(|page| page.call(&request)).into_bytes();
    let len = answer.len();
    BUFFER.set(answer);
    len
}

/// Address of the answer.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> *const u8 {
    BUFFER.with_borrow(|buffer| buffer.as_ptr())
}
