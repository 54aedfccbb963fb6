//! Sets of the numbers 1 to 32, with one bit for each: bit 0 is number 1.

use core::fmt;

/// Whether `number` is in the set.
pub(super) fn contains(bits: u32, number: u8) -> bool {
    bit(number).is_some_and(|bit| bits & bit != 0)
}

/// Numbers in the set, in ascending order.
pub(super) fn numbers(bits: u32) -> impl Iterator<Item = u8> {
    (1..=32).filter(move |&number| contains(bits, number))
}

/// Set of these numbers, without those that have no bit.
pub(super) fn of(numbers: impl Iterator<Item = u8>) -> u32 {
    numbers.filter_map(bit).fold(0, |bits, bit| bits | bit)
}

/// Prints a set, such as `1+3`, or `none`.
pub(super) fn print(f: &mut fmt::Formatter<'_>, bits: u32) -> fmt::Result {
    let mut separator = "";
    for number in numbers(bits) {
        write!(f, "{separator}{number}")?;
        separator = "+";
    }
    if separator.is_empty() { f.write_str("none") } else { Ok(()) }
}

/// Bit of a number; `None` outside 1 to 32.
fn bit(number: u8) -> Option<u32> {
    1_u32.checked_shl(u32::from(number).checked_sub(1)?)
}
