use core::marker::PhantomData;

use zerocopy::ByteOrder;

/// Reads fields off the front of a body, in the byte order `O`.
///
/// It has no index and no panic: what is not there is `None`.
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

    /// The next `N` bytes, or `None` (and nothing is taken) if there are fewer.
    #[inline]
    pub fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (head, rest) = self.rest.split_first_chunk()?;
        self.rest = rest;
        Some(*head)
    }

    /// The next `len` bytes, borrowed, or `None` (and nothing is taken) if there are fewer.
    #[inline]
    pub fn take(&mut self, len: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.rest.split_at_checked(len)?;
        self.rest = rest;
        Some(head)
    }

    /// All bytes not read yet; they stay.
    #[must_use]
    #[inline]
    pub const fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// Notes that an optional field was not there: what follows belongs to the tail.
    #[inline]
    pub const fn close(&mut self) {
        self.closed = true;
    }

    /// Whether an optional field was not there.
    #[must_use]
    #[inline]
    pub const fn is_closed(&self) -> bool {
        self.closed
    }
}

/// Writes fields to the front of a buffer, in the byte order `O`.
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

    /// Writes `N` bytes, or nothing and `None` if they do not fit.
    #[inline]
    pub fn array<const N: usize>(&mut self, bytes: [u8; N]) -> Option<()> {
        let (head, rest) = core::mem::take(&mut self.rest).split_first_chunk_mut()?;
        *head = bytes;
        self.rest = rest;
        Some(())
    }

    /// Writes `bytes`, or nothing and `None` if they do not fit.
    #[inline]
    pub fn bytes(&mut self, bytes: &[u8]) -> Option<()> {
        let (head, rest) = core::mem::take(&mut self.rest).split_at_mut_checked(bytes.len())?;
        head.copy_from_slice(bytes);
        self.rest = rest;
        Some(())
    }
}
