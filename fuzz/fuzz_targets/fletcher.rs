//! Fletcher-16 of bytes cut anywhere, compared with a reference that adds byte by byte.
//!
//! Input: two bytes with the place of the cut, then the bytes to be summed.

#![no_main]

use fuzz::rescan::fletcher16;
use libfuzzer_sys::fuzz_target;
use motion_core::fletcher::{Sum, verify};

fuzz_target!(|input: &[u8]| {
    let Some((cut, bytes)) = input.split_first_chunk() else { return };
    let cut = usize::from(u16::from_le_bytes(*cut)).min(bytes.len());
    let (front, back) = bytes.split_at(cut);

    let whole = Sum::of(bytes);
    assert_eq!(whole.value(), fletcher16(bytes), "in one call");
    assert_eq!(Sum::of(front).update(back), whole, "in two calls");
    assert_eq!(Sum::of(front).then(Sum::of(back), back.len()), whole, "joined");
    assert_eq!(whole.after(Sum::of(front), back.len()), Sum::of(back), "split");
    assert_eq!(verify(bytes), fletcher16(bytes) == 0, "verified");

    let check = whole.check_bytes();
    assert!(!check.contains(&0), "check bytes are 1 to 255: {check:?}");
    assert!(verify(&[bytes, &check].concat()), "a frame with its check bytes is sound");
});
