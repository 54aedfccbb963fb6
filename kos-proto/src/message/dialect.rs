//! Two layouts of one message, told apart by length.
//!
//! Devices of the older dialect, `CineDrive`, leave fields out in the middle. Each such message has two tables, one in
//! [`newer`] and one in [`older`], and a hand-written choice between them (safety decision 7).

use motion_core::wire::{Check, EncodeError, Field, Message, Part, PartKind, Reader, Visitor, Writer};
use zerocopy::ByteOrder;

/// Body of a message, in one of its two layouts.
pub(super) enum Dialect<N, O> {
    Newer(N),
    Older(O),
}

impl<'a, N: Message<'a>, O: Message<'a>> Dialect<N, O> {
    pub(super) fn encoded_len(&self) -> usize {
        match self {
            Self::Newer(body) => body.encoded_len(),
            Self::Older(body) => body.encoded_len(),
        }
    }

    pub(super) fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        match self {
            Self::Newer(body) => body.encode_into(out),
            Self::Older(body) => body.encode_into(out),
        }
    }

    pub(super) fn fields(&self, visitor: &mut dyn Visitor) {
        match self {
            Self::Newer(body) => body.fields(visitor),
            Self::Older(body) => body.fields(visitor),
        }
    }
}

/// Checks that a message of the older dialect has no tail, because a reader would take it for one of the newer dialect.
pub(super) fn exact(what: &'static str, tail: &[u8]) -> Result<(), EncodeError> {
    if tail.is_empty() { Ok(()) } else { Err(EncodeError::Tail { what, len: tail.len() }) }
}

/// Field of the newer dialect that the older dialect lacks, or has at another place. Messages of the newer dialect
/// always have it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(transparent)]
pub(super) struct InNewer<T>(pub(super) T);

impl<'a, T: Field> Part<'a> for InNewer<T> {
    const KIND: PartKind = PartKind::Optional;
    const WIRE: &'static str = T::WIRE;
    const SIZE: usize = <T as Field>::SIZE;
    const UNIT: &'static str = <T as Field>::UNIT;

    #[inline]
    fn take<O: ByteOrder>(reader: &mut Reader<'a, O>) -> Result<Self, usize> {
        Part::take(reader).map(Self)
    }

    #[inline]
    fn check(&self, what: &'static str, check: &mut Check) -> Result<(), EncodeError> {
        self.0.check(what, check)
    }

    #[inline]
    fn encoded_len(&self) -> usize {
        self.0.encoded_len()
    }

    #[inline]
    fn put<O: ByteOrder>(&self, writer: &mut Writer<'_, O>) -> Option<()> {
        self.0.put(writer)
    }

    fn visit(&self, name: &'static str, unit: &'static str, visitor: &mut dyn Visitor) {
        self.0.visit(name, unit, visitor);
    }
}
