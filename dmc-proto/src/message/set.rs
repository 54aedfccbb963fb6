//! Sets of 32 things that are counted from 1: bit 0 is the first.

use core::fmt;

/// Whether `number` is in the set.
pub(super) fn contains(bits: u32, number: u8) -> bool {
    bit(number).is_some_and(|bit| bits & bit != 0)
}

/// The numbers in the set, ascending.
pub(super) fn numbers(bits: u32) -> impl Iterator<Item = u8> {
    (1..=32).filter(move |&number| contains(bits, number))
}

/// The set of these numbers, without those that have no bit.
pub(super) fn of(numbers: impl Iterator<Item = u8>) -> u32 {
    numbers.filter_map(bit).fold(0, |bits, bit| bits | bit)
}

/// Prints `1+3`, or `none`.
pub(super) fn print(f: &mut fmt::Formatter<'_>, bits: u32) -> fmt::Result {
    let mut separator = "";
    for number in numbers(bits) {
        write!(f, "{separator}{number}")?;
        separator = "+";
    }
    if separator.is_empty() { f.write_str("none") } else { Ok(()) }
}

/// The bit of a number; only 1 to 32 have one.
fn bit(number: u8) -> Option<u32> {
    1_u32.checked_shl(u32::from(number).checked_sub(1)?)
}
