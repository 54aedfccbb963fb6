//! Messages that are drawn from an input by their tables: see `motion_core::wire::draw`.

use hoot_proto::{Address, Selector, Table};
use libfuzzer_sys::arbitrary::{Arbitrary, Unstructured};
use motion_core::owned::Owned;
use motion_core::wire::{EncodeError, Framed, Messages};

/// Draws a message of a side, and gives its whole frame. `label` is what the frame says beside the message.
///
/// A message that no frame can hold is left out.
pub fn frame<S: Framed>(input: &[u8], label: impl Fn(&S::Message<'_>) -> S::Label, see: impl FnOnce(&[u8])) {
    let Ok(drawn) = Owned::<S>::arbitrary(&mut Unstructured::new(input)) else { return };
    let message = drawn.message();
    let mut frame = vec![0; S::encoded_len(&message)];
    match S::encode_into(&message, label(&message), &mut frame) {
        Ok(len) => see(&frame[..len]),
        Err(EncodeError::TooLong { .. }) => {}
        // A message without a type may have a number that no frame has.
        Err(error) => assert_eq!(message.name(), "Other", "{error}: {message:?}"),
    }
}

/// Address to which a message of hoot can go, from its number: all nodes for a broadcast.
pub fn address(number: u32) -> Address {
    if Selector::from_number(number).table == Table::Broadcast { Address::BROADCAST } else { Address::DEFAULT }
}
