//! Numbers into the elements of a list, and back.

use zerocopy::{ByteOrder, I16, I32, NativeEndian, U16, U32};

use super::{Element, Field, Reader, Writer};

/// A list element that is one integer: `u8`, or [`U16`], [`I16`], [`U32`] or [`I32`] in either byte order.
pub trait IntegerElement: Element {
    /// The order of its bytes.
    type Order: ByteOrder;
}

/// Any order serves a single byte.
impl IntegerElement for u8 {
    type Order = NativeEndian;
}

macro_rules! integer_elements {
    ($($element:ident)*) => {$(
        impl<O: ByteOrder + Eq> IntegerElement for $element<O> {
            type Order = O;
        }
    )*};
}
integer_elements! { U16 I16 U32 I32 }

/// A list has more values than the scratch slice has elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[error("list: more than the {room} values that there is room for")]
pub struct ListTooLong {
    /// Number of elements of the scratch slice.
    pub room: usize,
}

/// Fills the front of `scratch` with `values`, and lends the filled part: the value of a list field.
///
/// The values are numbers, or units, open enums and flags around them, of the same type on the wire as the elements:
/// `i32` or `Steps` for [`I32`]. A pair of different types does not compile. Nothing is allocated.
///
/// # Errors
///
/// [`ListTooLong`] if there are more values than elements; then `scratch` holds the first of them.
///
/// ```
/// # use motion_core::{message, unit};
/// # unit! {
/// #     /// A motor.
/// #     pub struct Motor(u8) "";
/// #     /// Positions of a motor.
/// #     pub struct Steps(i32) "steps";
/// # }
/// # message! {
/// #     /// One section of one motor's positions.
/// #     pub struct UploadAxis<'a> in LE {
/// #         /// Number of the motor.
/// #         motor: Motor,
/// #         ;
/// #         /// One position a frame.
/// #         positions: &'a [I32] ["steps"],
/// #     }
/// # }
/// use motion_core::wire::{self, ListTooLong, Message};
/// use motion_core::zerocopy::little_endian::I32;
///
/// // `UploadAxis` is a message with the fields `motor: Motor` and `positions: &[I32]`; `Steps` is a unit over `i32`.
/// let planned = [Steps(0), Steps(80), Steps(-1)];
/// let mut scratch = [I32::ZERO; 256];
/// let positions = wire::fill(&mut scratch, planned.iter().copied())?;
/// let message = UploadAxis { motor: Motor(1), positions, tail: &[] };
///
/// let mut body = [0; 13];
/// assert_eq!(message.encode_into(&mut body), Ok(13));
/// assert_eq!(body, *b"\x01\0\0\0\0\x50\0\0\0\xff\xff\xff\xff");
///
/// // The other way: a list as units, or as plain numbers.
/// let received = UploadAxis::decode(&body)?;
/// let steps: Vec<Steps> = wire::values(received.positions).collect();
/// assert_eq!(steps, planned);
/// assert_eq!(wire::values::<i32, _>(received.positions).max(), Some(80));
///
/// assert_eq!(wire::fill(&mut [I32::ZERO; 2], 0..3), Err(ListTooLong { room: 2 }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// ```compile_fail,E0080
/// use motion_core::wire;
/// use motion_core::zerocopy::little_endian::I32;
///
/// // These are 16 bits on the wire, and the elements have 32.
/// let _ = wire::fill(&mut [I32::ZERO; 2], [1_u16, 2]);
/// ```
pub fn fill<T: IntegerElement, V: Field>(
    scratch: &mut [T],
    values: impl IntoIterator<Item = V>,
) -> Result<&[T], ListTooLong> {
    const { assert!(fits::<V, T>(), "values and elements of a list are the same type on the wire") }
    let room = scratch.len();
    let mut filled = 0_usize;
    for value in values {
        let element = scratch.get_mut(filled).ok_or(ListTooLong { room })?;
        // It fits, because both are the same type.
        let _ = value.write(&mut Writer::<T::Order>::new(element.as_mut_bytes()));
        filled = filled.saturating_add(1);
    }
    Ok(scratch.get(..filled).unwrap_or_default())
}

/// The values of a list field in order, as numbers or as units, open enums and flags around them.
///
/// The type of the values is the same on the wire as that of the elements; any other does not compile. See [`fill`] for
/// an example.
pub fn values<V: Field, T: IntegerElement>(
    list: &[T],
) -> impl ExactSizeIterator<Item = V> + DoubleEndedIterator + Clone {
    const { assert!(fits::<V, T>(), "values and elements of a list are the same type on the wire") }
    // There is always a value, because both are the same type.
    list.iter().map(|element| V::read(&mut Reader::<T::Order>::new(element.as_bytes())).unwrap_or_default())
}

/// Whether values and elements are the same type on the wire.
const fn fits<V: Field, T: Element>() -> bool {
    V::SIZE == size_of::<T>() && same(V::WIRE, T::WIRE)
}

/// Whether two texts are equal.
const fn same(one: &str, other: &str) -> bool {
    let (mut one, mut other) = (one.as_bytes(), other.as_bytes());
    while let ([first, rest @ ..], [other_first, other_rest @ ..]) = (one, other) {
        if *first != *other_first {
            return false;
        }
        (one, other) = (rest, other_rest);
    }
    one.is_empty() && other.is_empty()
}

#[cfg(test)]
mod tests {
    use std::string::ToString;
    use std::vec::Vec;

    use zerocopy::{BE, IntoBytes, LE};

    use super::*;
    use crate::fixed::Centi;
    use crate::wire::Bool;

    /// Fills a list with values, compares its bytes, and reads the values back.
    fn there_and_back<T: IntegerElement, V: Field>(zero: T, given: &[V], bytes: &[u8]) {
        let mut scratch = [zero; 4];
        let list = fill(&mut scratch, given.iter().copied()).unwrap();
        assert_eq!(list.as_bytes(), bytes);
        let back = values::<V, T>(list);
        assert_eq!(back.len(), given.len());
        assert_eq!(back.collect::<Vec<_>>(), given);
    }

    #[test]
    fn every_integer_is_written_and_read_in_both_orders() {
        there_and_back(U16::<LE>::ZERO, &[1_u16, u16::MAX], &[1, 0, 255, 255]);
        there_and_back(U16::<BE>::ZERO, &[1_u16, u16::MAX], &[0, 1, 255, 255]);
        there_and_back(I16::<LE>::ZERO, &[-2_i16, i16::MAX], &[254, 255, 255, 127]);
        there_and_back(I16::<BE>::ZERO, &[-2_i16, i16::MAX], &[255, 254, 127, 255]);
        there_and_back(U32::<LE>::ZERO, &[1_u32, u32::MAX], &[1, 0, 0, 0, 255, 255, 255, 255]);
        there_and_back(U32::<BE>::ZERO, &[1_u32, u32::MAX], &[0, 0, 0, 1, 255, 255, 255, 255]);
        there_and_back(I32::<LE>::ZERO, &[-2_i32, i32::MIN], &[254, 255, 255, 255, 0, 0, 0, 128]);
        there_and_back(I32::<BE>::ZERO, &[-2_i32, i32::MIN], &[255, 255, 255, 254, 128, 0, 0, 0]);
        there_and_back(0_u8, &[7_u8, 255], &[7, 255]);
    }

    #[test]
    fn types_around_an_integer_are_written_as_that_integer() {
        there_and_back(0_u8, &[Bool(1), Bool(0), Bool(9)], &[1, 0, 9]);
        there_and_back(I32::<BE>::ZERO, &[Centi::<i32>::from_raw(-1)], &[255; 4]);
    }

    #[test]
    fn a_list_is_empty_or_full_or_too_long() {
        let mut scratch = [U16::<LE>::ZERO; 3];
        assert_eq!(fill(&mut scratch, [0_u16; 0]), Ok(&[][..]));
        assert_eq!(fill(&mut scratch, 1..=3_u16).map(<[_]>::len), Ok(3));
        let error = fill(&mut scratch, 4_u16..).unwrap_err();
        assert_eq!(error, ListTooLong { room: 3 });
        assert_eq!(error.to_string(), "list: more than the 3 values that there is room for");
        assert!(values::<u16, _>(&scratch).eq(4..7), "the first values are written");
        assert_eq!(fill::<U16<LE>, u16>(&mut [], [1]), Err(ListTooLong { room: 0 }));
    }

    #[test]
    fn values_come_from_both_ends() {
        let list = [1.into(), 2.into(), 3.into()] as [I32<LE>; 3];
        assert!(values::<i32, _>(&list).rev().eq([3, 2, 1]));
    }
}
