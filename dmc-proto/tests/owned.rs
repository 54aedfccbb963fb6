//! Owned messages and their JSON.

use dmc_proto::{Device, DeviceMessage, Host};
use motion_core::owned::Owned;
use proptest::prelude::*;

/// What no layout describes: its fields depend on its first byte.
const IRREGULAR: &[&str] = &["VirtConfig"];

#[test]
fn every_message_of_both_tables() {
    laws::owned::table::<Host>(IRREGULAR);
    laws::owned::table::<Device>(&[]);
}

proptest! {
    #[test]
    fn any_body_of_any_type(number in 0_u32..=0xffff, body in proptest::collection::vec(any::<u8>(), 0..200)) {
        laws::owned::any_body::<Host>(number, &body, IRREGULAR);
        laws::owned::any_body::<Device>(number, &body, &[]);
    }
}

#[test]
fn an_acknowledgement_says_by_its_number_what_it_answers() {
    let json = r#"{"message":"Ack","number":32818,"fields":{"response_code":16}}"#;
    let owned: Owned<Device> = serde_json::from_str(json).unwrap();
    assert!(matches!(owned.message(), DeviceMessage::Ack(ack) if ack.of.0 == 0x32 && ack.is_ok()));
    assert_eq!(serde_json::to_string(&owned).unwrap(), json);
}
