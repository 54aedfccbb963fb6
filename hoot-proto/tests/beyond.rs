//! Commands of later firmware: the laws, and their difference from the commands of the sheet.

use hoot_proto::beyond::{Host, HostMessage};
use hoot_proto::lint::Context;
use hoot_proto::query::Profile;
use hoot_proto::{Address, EncodeError, Frame, frame};
use motion_core::lint::Severity;
use motion_core::wire::{Messages, Row};
use proptest::prelude::*;

#[test]
fn every_message_is_drawn_at_a_fair_share() {
    laws::drawn::shares::<Host>(200);
}

#[test]
fn every_message_of_the_table() {
    laws::message::table::<Host>();
}

proptest! {
    #[test]
    fn any_body_of_any_command(
        kind in any::<prop::sample::Index>(),
        body in proptest::collection::vec(any::<u8>(), 0..12),
    ) {
        laws::message::prefixes::<Host>(kind.get(HostMessage::ALL).number, &body);
    }
}

/// Bytes of a body that has no variable part.
fn len(layout: &[Row]) -> usize {
    layout.iter().map(|row| row.size).sum()
}

#[test]
fn none_is_a_command_of_the_sheet() {
    for kind in HostMessage::ALL {
        let body = vec![0; len(kind.layout)];
        let of_the_sheet = hoot_proto::HostMessage::decode_body(kind.number, &body);
        assert!(!matches!(of_the_sheet, Ok(message) if message.name() != "Other"), "{}", kind.name);
    }
}

#[test]
fn packets() {
    let of = |address, sub_address, command, data: &[u8]| {
        let mut out = [0; 42];
        let len = frame::encode(Address(address), sub_address, command, data, &mut out).unwrap();
        let message = HostMessage::decode(&Frame::decode(&out[..len]).unwrap());
        let mut again = [0; 42];
        assert_eq!(message.encode_into(Address(address), &mut again), Ok(len));
        assert_eq!((again, message.encoded_len()), (out, len), "{message}");
        message.to_string()
    };
    assert_eq!(of(3, 1, 25, &[0, 0, 0, 9]), "MotorSetLeadOut { motor: 1, lead_out: 9 }");
    assert_eq!(of(3, 1, 25, &[]), "Other { data:  }", "the step of the sheet");
    assert_eq!(of(3, 0, 28, &[1]), "SetFrameRate { frame_rate: TWENTY_FOUR }");
    assert_eq!(of(3, 2, 31, &[0xFF, 0xFF, 0xFF, 0xFE]), "MotorSendTo { motor: 2, position: -2 steps }");
    assert_eq!(of(3, 2, 32, &[0, 0, 0, 9]), "MotorSetPosition { motor: 2, position: 9 steps }");
    assert_eq!(of(3, 5, 10, &[0, 2]), "KeySetAxis { axis: 2 }");
    assert_eq!(of(3, 5, 12, &[0x42, 0xC8, 0, 0]), "KeySetTime { time: 100.0 }");
    assert_eq!(of(1, 0, 10, &[]), "BroadcastGetAddress");
    assert_eq!(of(3, 0, 10, &[]), "Other { data:  }", "home, in the sheet");
}

#[test]
fn lint_is_silent_except_about_what_does_not_arrive() {
    let (later, bridge) = (Context::default(), Context::through_bridge());
    let mut sheet = Context::default();
    sheet.profile = Profile::SHEET;
    for kind in HostMessage::ALL {
        let size = len(kind.layout);
        let of = |body: &[u8], context: &Context| HostMessage::decode_body(kind.number, body).unwrap().lint(context);
        assert_eq!(of(&vec![0; size], &later).as_slice(), [], "{}", kind.name);
        let found = of(&vec![0; size], &sheet);
        assert_eq!(found.as_slice()[0].severity, Severity::Warning, "{}", kind.name);
        let refused = of(&vec![0; size], &bridge).first_error().is_some();
        assert_eq!(refused, kind.name.starts_with("Broadcast"), "{}", kind.name);
        let is = |wire| kind.layout.iter().any(|row| row.wire == wire);
        let found = of(&vec![0xFF; size], &later);
        assert_eq!(found.first_error().is_some(), is("u32") || is("f32"), "{}", kind.name);
    }
    let lead_out = HostMessage::decode_body(0x19_01, &[1, 0, 0, 0]).unwrap();
    let refused = lead_out.encode_checked(Address(3), &later, &mut [0; 42]);
    assert!(matches!(refused, Err(EncodeError::Refused(lint)) if lint.what == "lead_out"));
}
