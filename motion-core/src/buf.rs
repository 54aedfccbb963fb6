//! Encoding into a [`BufMut`]. The feature `bytes` adds the dependency `bytes`, which has no dependencies of its own.
//! It needs an allocator and a processor with atomic compare-and-swap.

#![doc(hidden)]

use bytes::BufMut;

use crate::owned::to_vec;
use crate::wire::EncodeError;

/// Length in bytes up to which a frame is put together on the stack.
const SHORT: usize = 128;

/// Appends to `buf` the bytes that `write` writes into a buffer of `len` bytes, and returns their number.
///
/// The protocol crates build the `encode` of their messages on it. A `BufMut` lends only uninitialized memory, and safe
/// code cannot write a frame into that. So the frame is put together elsewhere and copied. A frame of up to 128 bytes,
/// as nearly all messages are, is put together on the stack. A longer one costs an allocation.
///
/// # Errors
///
/// [`EncodeError::BufferTooSmall`] if `buf` has room for fewer than `len` bytes, and the errors of `write`. Then
/// nothing is appended.
///
/// ```
/// use motion_core::wire::EncodeError;
///
/// let write = |out: &mut [u8]| {
///     out.copy_from_slice(b"frame");
///     Ok(out.len())
/// };
/// let mut buf = bytes::BytesMut::from("one ");
/// assert_eq!(motion_core::buf::put(&mut buf, 5, write), Ok(5));
/// assert_eq!(buf, "one frame");
///
/// let mut small = [0; 4];
/// let refused = motion_core::buf::put(&mut &mut small[..], 5, write);
/// assert_eq!(refused, Err(EncodeError::BufferTooSmall { needed: 5, have: 4 }));
/// ```
pub fn put(
    buf: &mut impl BufMut,
    len: usize,
    write: impl FnOnce(&mut [u8]) -> Result<usize, EncodeError>,
) -> Result<usize, EncodeError> {
    let have = buf.remaining_mut();
    if have < len {
        return Err(EncodeError::BufferTooSmall { needed: len, have });
    }
    if let Some(place) = [0; SHORT].get_mut(..len) {
        let written = write(place)?;
        buf.put_slice(place.get(..written).unwrap_or_default());
        return Ok(written);
    }
    let frame = to_vec(len, write)?;
    buf.put_slice(&frame);
    Ok(frame.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// The buffer of `room` bytes after a writer of `len` bytes.
    fn put_into(room: usize, len: usize) -> Result<Vec<u8>, EncodeError> {
        let mut place = std::vec![0xa5; room];
        let mut rest = &mut place[..];
        let put = put(&mut rest, len, |out| {
            assert_eq!(out.len(), len);
            out.fill(7);
            Ok(out.len())
        });
        let left = rest.len();
        put.map(|written| {
            assert_eq!(written, room - left);
            place
        })
    }

    #[test]
    fn short_and_long_frames_are_appended_whole() {
        for len in [0, 1, SHORT - 1, SHORT, SHORT + 1, 5000] {
            let expected = [std::vec![7; len], std::vec![0xa5; 3]].concat();
            assert_eq!(put_into(len + 3, len), Ok(expected));
            if len > 0 {
                let refused = Err(EncodeError::BufferTooSmall { needed: len, have: len - 1 });
                assert_eq!(put_into(len - 1, len), refused);
            }
        }
    }

    #[test]
    fn a_failed_write_appends_nothing() {
        let hole = EncodeError::Hole { what: "Run.reason" };
        for len in [4, 5000] {
            let mut buf = Vec::new();
            assert_eq!(put(&mut buf, len, |_| Err(hole)), Err(hole));
            assert!(buf.is_empty());
        }
    }
}
