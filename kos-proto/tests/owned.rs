//! Owned messages and their JSON.

use kos_proto::{Device, DeviceMessage, Host, HostMessage};
use motion_core::wire::Messages;
use proptest::prelude::*;

#[test]
fn every_message_of_both_tables() {
    laws::owned::table::<Host>(&[]);
    laws::owned::table::<Device>(&[]);
}

proptest! {
    #[test]
    fn any_body_of_any_kind(kind in any::<prop::sample::Index>(), body in proptest::collection::vec(any::<u8>(), 0..200)) {
        laws::owned::any_body::<Host>(kind.get(HostMessage::ALL).number, &body, &[]);
        laws::owned::any_body::<Device>(kind.get(DeviceMessage::ALL).number, &body, &[]);
    }
}
