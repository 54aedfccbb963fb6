//! Owned messages, and their JSON.

mod recorded;

use kos_proto::{Device, DeviceMessage, Frames, Host, HostMessage, Item};
use motion_core::owned::Owned;
use motion_core::wire::{Messages, Side};
use proptest::prelude::*;

/// Messages that no layout describes, because they hold blocks of several kinds.
const IRREGULAR: &[&str] = &["SetTrajectoryData", "TrajectoryData"];

#[test]
fn every_message_of_both_tables() {
    laws::owned::table::<Host>(IRREGULAR);
    laws::owned::table::<Device>(IRREGULAR);
}

/// Checks the law for a message that was decoded.
fn holds<S: Side>(message: &S::Message<'_>) {
    let owned = Owned::<S>::new(message).unwrap();
    laws::owned::any_body::<S>(owned.number(), owned.body(), IRREGULAR);
}

#[test]
fn every_vector() {
    for vector in recorded::vectors() {
        let wire = recorded::bytes(&vector);
        let mut frames: Box<Frames> = Box::default();
        assert_eq!(frames.push(&wire), wire.len());
        while let Some(Item::Frame(frame)) = frames.next() {
            let _ = HostMessage::decode(&frame).map(|message| holds::<Host>(&message));
            let _ = DeviceMessage::decode(&frame).map(|message| holds::<Device>(&message));
        }
    }
}

proptest! {
    #[test]
    fn any_body_of_any_kind(
        kind in any::<prop::sample::Index>(),
        body in proptest::collection::vec(prop_oneof![any::<u8>(), 0..4_u8], 0..100),
    ) {
        laws::owned::any_body::<Host>(kind.get(HostMessage::ALL).number, &body, IRREGULAR);
        laws::owned::any_body::<Device>(kind.get(DeviceMessage::ALL).number, &body, IRREGULAR);
    }
}
