//! Owned messages and their JSON.

mod recorded;

use dmc_proto::{Device, DeviceMessage, Frame, Host, HostMessage};
use motion_core::owned::Owned;
use motion_core::wire::Messages;
use proptest::prelude::*;

/// Fields that only the layout of the kind of rig tells.
const IRREGULAR: &[&str] = &["VirtConfig"];

#[test]
fn every_message_of_both_tables() {
    laws::owned::table::<Host>(IRREGULAR);
    laws::owned::table::<Device>(IRREGULAR);
}

#[test]
fn every_vector() {
    for (_, wire) in recorded::vectors() {
        let Ok(frame) = Frame::decode(&wire) else { continue };
        laws::owned::any_body::<Host>(frame.kind().0.into(), frame.payload(), IRREGULAR);
        laws::owned::any_body::<Device>(frame.kind().0.into(), frame.payload(), IRREGULAR);
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

#[test]
fn the_number_of_an_acknowledgement_tells_its_request() {
    let json = r#"{"message":"Ack","number":32818,"fields":{"response_code":16}}"#;
    let owned: Owned<Device> = serde_json::from_str(json).unwrap();
    assert!(matches!(owned.message(), DeviceMessage::Ack(ack) if ack.of.0 == 0x32 && ack.is_ok()));
    assert_eq!(serde_json::to_string(&owned).unwrap(), json);
}

#[test]
fn fields_without_a_layout_are_bytes() {
    let rig = r#"{"message":"VirtConfig","number":512,"fields":{"type":2,"swing_motor":1}}"#;
    let error = serde_json::from_str::<Owned<Host>>(rig).unwrap_err().to_string();
    assert!(error.starts_with("VirtConfig.rig: missing"), "{error}");
    let bytes = r#"{"message":"Other","number":512,"fields":{"data":"00"}}"#;
    let none: Owned<Host> = serde_json::from_str(bytes).unwrap();
    assert!(matches!(none.message(), HostMessage::VirtConfig(_)));
}
