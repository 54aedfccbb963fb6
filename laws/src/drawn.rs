//! Messages that are drawn for fuzzers: each kind has its share, its lists and texts are laid out, and all laws hold.

use std::collections::HashMap;

use motion_core::arbitrary::{Arbitrary, Unstructured};
use motion_core::owned::Owned;
use motion_core::wire::{FieldView, Fields, Kind, Messages, PartKind, Row, Side, Value, draw_borrowed};

use crate::message::any_body;

/// Bytes of the input of one message.
const INPUT: usize = 512;
/// Part of an even share that each kind has at least.
const SHARE: usize = 5;

/// Draws `draws` messages for each kind of the table, and counts the kinds.
///
/// # Panics
///
/// If law 15 is broken: a kind has less than a fifth of an even share, or its lists and texts are empty in more than four
/// fifths of its messages. Also if a law for any body is broken.
pub fn shares<S: Side>(draws: usize) {
    let all = S::Message::ALL;
    let mut random = 0x9E37_79B9_7F4A_7C15_u64;
    let mut counts: HashMap<&str, (usize, usize)> = HashMap::new();
    let mut borrowed: HashMap<&str, usize> = HashMap::new();
    for _ in 0..draws * (all.len() + 1) {
        let input: Vec<u8> = (0..INPUT).map(|_| next(&mut random)).collect();
        let owned = Owned::<S>::arbitrary(&mut Unstructured::new(&input)).expect("the input is long enough");
        any_body::<S>(owned.number(), owned.body()).expect("what is drawn can be decoded");
        let message = owned.message();
        let (count, filled) = counts.entry(message.name()).or_default();
        *count += 1;
        *filled += usize::from(is_filled(&message));
        let name = borrowed_name::<S>(&input);
        *borrowed.entry(name).or_default() += 1;
    }
    for Kind { name, layout, .. } in all {
        let (count, filled) = counts.get(name).copied().unwrap_or_default();
        assert!(count * SHARE >= draws, "{name} is drawn {count} times, an even share is {draws}");
        let is_variable = layout.iter().any(|row: &Row| !matches!(row.part, PartKind::Fixed | PartKind::Optional));
        assert!(!is_variable || filled * SHARE >= count, "{name} has a list or a text in {filled} of {count} draws");
        let count = borrowed.get(name).copied().unwrap_or_default();
        assert!(count * SHARE >= draws, "{name} is borrowed {count} times, an even share is {draws}");
    }
}

/// Name of the message that borrows from an input.
fn borrowed_name<S: Side>(input: &[u8]) -> &'static str {
    let message: S::Message<'_> = draw_borrowed(&mut Unstructured::new(input)).expect("the input is long enough");
    message.name()
}

/// Whether a message has a list, a text or bytes that are not empty.
fn is_filled(message: &impl Fields) -> bool {
    let mut filled = false;
    message.fields(&mut |field: &FieldView<'_>| match field.value {
        Value::Text(bytes) | Value::Secret(bytes) | Value::Bytes(bytes) if field.name != "tail" => {
            filled |= !bytes.is_empty();
        }
        Value::List(list) => list.each(&mut |_| filled = true),
        _ => {}
    });
    filled
}

/// Next byte of a random sequence.
fn next(random: &mut u64) -> u8 {
    *random ^= *random << 13;
    *random ^= *random >> 7;
    *random ^= *random << 17;
    random.to_le_bytes()[3]
}
