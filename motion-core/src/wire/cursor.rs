use core::marker::PhantomData;

use zerocopy::{ByteOrder, FromBytes};

use super::Element;

/// Reader of fields from the front of a body, in the byte order `O`.
///
/// The reader has no index and cannot panic: bytes that are missing give `None`.
#[derive(Debug, Clone)]
pub struct Reader<'a, O> {
    rest: &'a [u8],
    closed: bool,
    order: PhantomData<O>,
}

impl<'a, O: ByteOrder> Reader<'a, O> {
    /// A reader at the start of `bytes`.
    #[must_use]
    #[inline]
    pub const fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes, closed: false, order: PhantomData }
    }

    /// Takes the next `N` bytes. If there are fewer, takes nothing and gives `None`.
    #[inline]
    pub fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (head, rest) = self.rest.split_first_chunk()?;
        self.rest = rest;
        Some(*head)
    }

    /// Lends the next `len` bytes. If there are fewer, takes nothing and gives `None`.
    #[inline]
    pub fn take(&mut self, len: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.rest.split_at_checked(len)?;
        self.rest = rest;
        Some(head)
    }

    /// Lends the next `count` elements. If there are fewer, takes nothing and gives `None`.
    ///
    /// Bytes that are cut off first and then read as elements would be divided by the size of an element.
    #[inline]
    pub(super) fn elements<T: Element>(&mut self, count: usize) -> Option<&'a [T]> {
        let (elements, rest) = <[T]>::ref_from_prefix_with_elems(self.rest, count).ok()?;
        self.rest = rest;
        Some(elements)
    }

    /// Bytes that are not read yet. They stay unread.
    #[must_use]
    #[inline]
    pub const fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// Notes that an optional field was absent: all bytes after it belong to the tail.
    #[inline]
    pub const fn close(&mut self) {
        self.closed = true;
    }

    /// Whether an optional field was absent.
    #[must_use]
    #[inline]
    pub const fn is_closed(&self) -> bool {
        self.closed
    }
}

/// Writer of fields to the front of a buffer, in the byte order `O`.
#[derive(Debug)]
pub struct Writer<'o, O> {
    rest: &'o mut [u8],
    order: PhantomData<O>,
}

impl<'o, O: ByteOrder> Writer<'o, O> {
    /// A writer at the start of `out`.
    #[must_use]
    #[inline]
    pub const fn new(out: &'o mut [u8]) -> Self {
        Self { rest: out, order: PhantomData }
    }

    /// Writes `N` bytes. If they do not fit, writes nothing and gives `None`.
    #[inline]
    pub fn array<const N: usize>(&mut self, bytes: [u8; N]) -> Option<()> {
        let (head, rest) = core::mem::take(&mut self.rest).split_first_chunk_mut()?;
        *head = bytes;
        self.rest = rest;
        Some(())
    }

    /// Writes `bytes`. If they do not fit, writes nothing and gives `None`.
    #[inline]
    pub fn bytes(&mut self, bytes: &[u8]) -> Option<()> {
        // Most messages have no tail, and a copy of no bytes takes 17 instructions.
        if bytes.is_empty() {
            return Some(());
        }
        let (head, rest) = core::mem::take(&mut self.rest).split_at_mut_checked(bytes.len())?;
        head.copy_from_slice(bytes);
        self.rest = rest;
        Some(())
    }
}
