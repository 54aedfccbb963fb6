//! The laws over every message of both sides, and over the stream.

use dmc_proto::{DeviceMessage, HostMessage};
use laws::message::Side;
use motion_core::lint::Lints;
use motion_core::wire::Messages;
use proptest::prelude::*;

struct Host;

impl Side for Host {
    type Message<'a> = HostMessage<'a>;
    const BIG_ENDIAN: bool = false;

    fn lint(_: &HostMessage<'_>) -> Lints {
        Lints::new()
    }
}

struct Device;

impl Side for Device {
    type Message<'a> = DeviceMessage<'a>;
    const BIG_ENDIAN: bool = false;

    fn lint(_: &DeviceMessage<'_>) -> Lints {
        Lints::new()
    }
}

#[test]
fn every_message_of_both_tables() {
    laws::message::table::<Host>();
    laws::message::table::<Device>();
}

proptest! {
    #[test]
    fn any_body_of_any_type(number in 0_u32..=0xffff, body in proptest::collection::vec(any::<u8>(), 0..200)) {
        let _ = laws::message::any_body::<Host>(number, &body);
        let _ = laws::message::any_body::<Device>(number, &body);
    }

    #[test]
    fn prefixes_and_tails(kind in any::<prop::sample::Index>(), body in proptest::collection::vec(any::<u8>(), 0..60)) {
        laws::message::prefixes::<Host>(kind.get(HostMessage::ALL).number, &body);
        laws::message::prefixes::<Device>(kind.get(DeviceMessage::ALL).number, &body);
    }
}
