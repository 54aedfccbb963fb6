//! Owned messages and their JSON.

use hoot_proto::{Device, DeviceMessage, Host, HostMessage};
use motion_core::wire::Messages;
use proptest::prelude::*;

/// Its data has a type of its own.
const IRREGULAR: &[&str] = &["Reply"];

#[test]
fn every_message_of_both_tables() {
    laws::owned::table::<Host>(IRREGULAR);
    laws::owned::table::<Device>(IRREGULAR);
}

proptest! {
    #[test]
    fn any_body_of_any_command(
        kind in any::<prop::sample::Index>(),
        body in proptest::collection::vec(any::<u8>(), 0..40),
    ) {
        laws::owned::any_body::<Host>(kind.get(HostMessage::ALL).number, &body, IRREGULAR);
        laws::owned::any_body::<Device>(kind.get(DeviceMessage::ALL).number, &body, IRREGULAR);
    }
}
