//! Reports of a USB device: the vectors, every kind of buffer, and long messages with lost, doubled and late pieces.

mod recorded;
mod reports;

use kos_proto::message::{KeepAlive, MotorAddress, RotationsPerSecondSquared, SetPositionSpeedAcceleration};
use kos_proto::usb::{
    Ambiguous, CAPACITY, CONTINUE_WITHIN, Dropped, Fragments, REPORT_LEN, Reassembly, Report, ReportError, decode,
};
use kos_proto::{DeviceMessage, EncodeError, Frame, FrameError, HostMessage, frame};
use motion_core::serialize::Map;
use motion_core::time::Millis;
use proptest::collection::vec;
use proptest::prelude::*;
use reports::{STOP, hostile, report};
use serde_json::Value;

/// Vectors of one kind; `count` is their number.
fn of_kind(kind: &str, count: usize) -> Vec<(Value, Vec<u8>)> {
    let vectors = recorded::vectors().into_iter().filter(|vector| vector["kind"] == kind);
    let vectors: Vec<_> = vectors.map(|vector| (vector.clone(), recorded::bytes(&vector))).collect();
    assert_eq!(vectors.len(), count, "{kind}");
    vectors
}

/// Name and fields of a message, and the report with it.
macro_rules! see {
    ($side:ident, $frame:expr) => {{
        let message = $side::decode(&$frame).unwrap();
        let fields = serde_json::to_value(Map { fields: &message, secrets: true }).unwrap();
        (message.specification_name(), fields, Report::encode(&message))
    }};
}

#[test]
fn messages_of_the_vectors_are_found_in_every_buffer() {
    for (vector, bytes) in of_kind("usb", 4) {
        let name = &vector["name"];
        assert_eq!(bytes.len(), REPORT_LEN, "{name}");
        // The report with its id, without it, and with a byte that a library adds.
        for buffer in [&bytes[..], &bytes[1..], &[&bytes[..], &[0xff]].concat(), &[&bytes[1..], &[0xff; 2]].concat()] {
            let frame = decode(buffer).unwrap();
            let (message, fields, encoded) =
                if vector["direction"] == "host" { see!(HostMessage, frame) } else { see!(DeviceMessage, frame) };
            let wanted = &vector["messages"][0];
            assert_eq!(message, wanted["message"], "{name}");
            assert_eq!(frame.id().0, wanted["message_id"], "{name}");
            assert_eq!(fields, wanted["fields"], "{name}");
            let encoded = encoded.unwrap();
            assert_eq!((encoded.as_ref(), Report::new(frame)), (&bytes[..], Ok(encoded)), "{name}: the same report");
        }
    }
}

#[test]
fn a_message_that_does_not_fit_into_a_report_is_refused() {
    for (_, bytes) in of_kind("usb-too-long", 1) {
        let frame = Frame::decode(&bytes).unwrap();
        let refused = Err(EncodeError::TooLong { what: "USB report", len: 64, max: CAPACITY });
        assert_eq!(Report::new(frame), refused);
        assert_eq!(Report::encode(&HostMessage::decode(&frame).unwrap()), refused);
        // In a buffer of 64 bytes the last byte does not belong to a report whose id was removed.
        assert_eq!(decode(&bytes), Err(FrameError::Truncated { needed: 64, have: 63 }.into()));
    }
}

#[test]
fn a_move_in_two_reports_is_joined() {
    for (_, bytes) in of_kind("usb-assumed", 1) {
        let reports: Vec<&[u8]> = bytes.chunks(REPORT_LEN).collect();
        let mut joined: Reassembly<256> = Reassembly::default();
        let first = joined.push(Millis(0), reports[0]);
        assert_eq!((first.message, first.dropped), (Ok(None), None));
        assert_eq!((joined.held(), joined.deadline()), (63, Some(Millis(100))));
        let message = joined.push(Millis(99), reports[1]).message.unwrap().unwrap();
        assert!(matches!(HostMessage::decode(&message), Ok(HostMessage::SetTrajectoryData(_))));
        let again: Vec<Report> = Fragments::assume(message).unwrap().collect();
        assert_eq!(again.iter().map(AsRef::as_ref).collect::<Vec<_>>(), reports);
        assert_eq!((joined.held(), joined.deadline()), (0, None));
    }
}

#[test]
fn a_keep_alive_is_a_report_of_its_own() {
    let keep_alive = HostMessage::from(KeepAlive::default());
    assert_eq!(Report::encode(&keep_alive), Ok(Report::KEEP_ALIVE));
    let frame = decode(Report::KEEP_ALIVE.as_ref()).unwrap();
    assert_eq!((HostMessage::decode(&frame), frame.bytes()), (Ok(keep_alive), &[4, 0, 6, 0, 0, 0][..]));
}

#[test]
fn buffers_of_every_length_are_decoded_or_refused() {
    for numbered in [true, false] {
        let whole = [&report(&STOP, numbered)[..], &[0; 4]].concat();
        let needed = STOP.len() + usize::from(numbered);
        for len in 0..=whole.len() {
            let have = len.saturating_sub(usize::from(numbered));
            let wanted = match len {
                0 | 66.. => Err(ReportError::BadLength { found: len }),
                _ if have < 6 => Err(FrameError::Truncated { needed: 6, have }.into()),
                _ if len < needed => Err(FrameError::Truncated { needed: 7, have }.into()),
                _ => Ok(&STOP[..]),
            };
            assert_eq!(decode(&whole[..len]).map(|frame| frame.bytes()), wanted, "{len}");
            let mut joined: Reassembly<64> = Reassembly::assume();
            let received = joined.push(Millis(0), &whole[..len]);
            assert_eq!(received.message.map(|frame| frame.unwrap().bytes()), wanted, "no piece is so short: {len}");
        }
    }
}

#[test]
fn other_reports_are_refused_and_change_nothing() {
    assert_eq!(decode(&[2, 4, 0, 6, 0, 0, 0]), Err(ReportError::BadId { found: 2 }));
    assert_eq!(decode(&[0; 64]), Err(ReportError::BadId { found: 0 }));
    assert_eq!(decode(&[1, 5, 0, 6, 0, 0, 0]), Err(FrameError::BadVersion { found: 5 }.into()));
    assert_eq!(decode(&[1, 4, 0, 5, 0, 0, 0]), Err(FrameError::BadLength { found: 5 }.into()));
    // Padding need not be zero, and is not searched for a second message.
    let two = [&[1][..], &STOP, &STOP].concat();
    assert_eq!(decode(&two).unwrap().bytes(), STOP);

    let message = long(100);
    let reports = cut(&message);
    let mut joined: Reassembly<128> = Reassembly::assume();
    assert_eq!(joined.push(Millis(0), &reports[0]).message, Ok(None));
    for (other, error) in [
        (&[2; 64][..], ReportError::BadId { found: 2 }),
        (&[4; 64], ReportError::BadId { found: 4 }),
        (&[], ReportError::BadLength { found: 0 }),
        (&[1; 66], ReportError::BadLength { found: 66 }),
    ] {
        let received = joined.push(Millis(1), other);
        assert_eq!((received.message, received.dropped), (Err(error), None));
    }
    assert_eq!(joined.push(Millis(2), &reports[1]).message.unwrap().unwrap().bytes(), message);
}

/// A message of `len` bytes without a piece that looks like another message.
fn long(len: usize) -> Vec<u8> {
    let mut message = vec![0; len];
    let payload = vec![0xee; len - 6];
    assert_eq!(frame::encode(frame::MessageId(0x12), frame::MessageType::SET, &payload, &mut message), Ok(len));
    message
}

fn cut(message: &[u8]) -> Vec<Vec<u8>> {
    let fragments = Fragments::assume(Frame::decode(message).unwrap()).unwrap();
    fragments.map(|report| report.as_ref().to_vec()).collect()
}

/// Safety decision 4: the rest of a move is lost, and a stop is sent.
#[test]
fn a_lost_piece_never_swallows_a_stop() {
    let stop_motor = SetPositionSpeedAcceleration::stop(MotorAddress(1), None, RotationsPerSecondSquared(100.0));
    let mut buffer = [0; 32];
    let len = HostMessage::from(stop_motor).encode_into(&mut buffer).unwrap();
    for (stop, numbered) in [(&STOP[..], true), (&STOP, false), (&buffer[..len], true), (&buffer[..len], false)] {
        for pieces in 1..3 {
            let message = long(180);
            let mut joined: Reassembly<256> = Reassembly::assume();
            for piece in &cut(&message)[..pieces] {
                let piece = if numbered { piece } else { &piece[1..] };
                assert_eq!(joined.push(Millis(10), piece).message, Ok(None));
            }
            let stop_report = report(stop, numbered);
            let received = joined.push(Millis(20), &stop_report);
            assert_eq!(received.message.unwrap().unwrap().bytes(), stop);
            assert_eq!(received.dropped, Some(Dropped::Interrupted { needed: 180, have: 63 * pieces }));
        }
    }
    // Among reports with their id, a report without it is read too.
    let mut joined: Reassembly<256> = Reassembly::assume();
    assert_eq!(joined.push(Millis(0), &cut(&long(180))[0]).message, Ok(None));
    assert_eq!(joined.push(Millis(0), &report(&STOP, false)).message.unwrap().unwrap().bytes(), STOP);
}

#[test]
fn a_message_that_fills_its_report_interrupts_too() {
    let mut joined: Reassembly<256> = Reassembly::assume();
    let (first, full) = (cut(&long(100)), long(63));
    assert_eq!(joined.push(Millis(0), &first[0]).message, Ok(None));
    let report = report(&full, true);
    assert_eq!(joined.push(Millis(0), &report).message.unwrap().unwrap().bytes(), full);
}

#[test]
fn the_next_piece_has_100_milliseconds() {
    assert_eq!(CONTINUE_WITHIN, 100);
    let message = long(180);
    let reports = cut(&message);
    for (late, held) in [(99, 126), (100, 0)] {
        let mut joined: Reassembly<256> = Reassembly::assume();
        assert_eq!(joined.push(Millis(1000), &reports[0]).message, Ok(None));
        let received = joined.push(Millis(1000 + late), &reports[1]);
        // The piece alone is not a message.
        assert_eq!(
            received.message,
            if held == 0 { Err(FrameError::BadVersion { found: 0xee }.into()) } else { Ok(None) }
        );
        assert_eq!(received.dropped, (held == 0).then_some(Dropped::Late { needed: 180, have: 63 }));
        assert_eq!(joined.held(), held);
    }
    let mut joined: Reassembly<256> = Reassembly::assume();
    assert_eq!(joined.expire(Millis(0)), None);
    assert_eq!(joined.push(Millis(1000), &reports[0]).message, Ok(None));
    assert_eq!((joined.expire(Millis(1099)), joined.deadline()), (None, Some(Millis(1100))));
    assert_eq!(joined.expire(Millis(1100)), Some(Dropped::Late { needed: 180, have: 63 }));
    assert_eq!((joined.expire(Millis(1200)), joined.deadline()), (None, None));
}

#[test]
fn a_message_that_is_too_long_is_counted_to_its_end() {
    let message = long(300);
    let reports = cut(&message);
    let mut joined: Reassembly<299> = Reassembly::assume();
    for report in &reports[..4] {
        assert_eq!(joined.push(Millis(0), report).message, Ok(None));
    }
    assert_eq!(joined.push(Millis(0), &reports[4]).message, Err(ReportError::TooLong { total: 300, max: 299 }));
    assert_eq!(joined.push(Millis(0), &report(&STOP, true)).message.unwrap().unwrap().bytes(), STOP, "in step");
}

#[test]
fn a_short_piece_ends_the_message() {
    let reports = cut(&long(180));
    let mut joined: Reassembly<256> = Reassembly::assume();
    assert_eq!(joined.push(Millis(0), &reports[0]).message, Ok(None));
    let short = joined.push(Millis(0), &reports[1][..40]).message;
    assert_eq!(short, Err(FrameError::Truncated { needed: 180, have: 63 + 39 }.into()));
    assert_eq!(joined.held(), 0);
}

#[test]
fn no_piece_may_look_like_a_message() {
    // A reset of the device inside a password, at the start of its second report, with and without the id of the
    // report.
    for (hidden, index) in [(&b"\x04\0\x07\0\x80\0\x01"[..], 1), (b"\x01\x04\0\x07\0\x80\0\x01", 1)] {
        let mut message = long(120);
        message[63..63 + hidden.len()].copy_from_slice(hidden);
        assert_eq!(Fragments::assume(Frame::decode(&message).unwrap()).err(), Some(Ambiguous { index }));
        message[63] = 2;
        assert_eq!(cut(&message).len(), 2);
    }
    // At its start, a message may look like a message.
    assert_eq!(cut(&long(63)).len(), 1);
}

#[test]
fn errors_name_the_fault_and_the_values() {
    let text = |error: &dyn std::error::Error| error.to_string();
    assert_eq!(text(&ReportError::BadLength { found: 66 }), "USB report: 66 bytes, should be 1 to 65");
    assert_eq!(text(&ReportError::BadId { found: 2 }), "USB report: id is 2, should be 1");
    let short = ReportError::from(FrameError::Truncated { needed: 64, have: 63 });
    assert_eq!(text(&short), "frame: need 64 bytes, have 63");
    assert_eq!(text(&ReportError::TooLong { total: 9, max: 8 }), "USB message: 9 bytes, at most 8 fit");
    let late = Dropped::Late { needed: 9, have: 8 };
    assert_eq!(text(&late), "USB message: have 8 of 9 bytes, the next report came too late");
    let interrupted = Dropped::Interrupted { needed: 9, have: 8 };
    assert_eq!(text(&interrupted), "USB message: have 8 of 9 bytes, the next report was another message");
    let ambiguous = Ambiguous { index: 1 };
    assert_eq!(text(&ambiguous), "USB report 1 of the message would be taken for a message of its own");
}

proptest! {
    #[test]
    fn any_sequence_of_reports_is_read_like_the_model(input in vec(prop_oneof![any::<u8>(), 0..8_u8, Just(0)], 0..600)) {
        hostile::<256>(&input);
        hostile::<0>(&input);
        hostile::<1024>(&input);
    }

    #[test]
    fn any_message_arrives(payload in vec(any::<u8>(), 200), waits in vec(0..16_u8, 0..20)) {
        let amounts = waits.iter().map(|wait| wait << 4 | 3);
        let input: Vec<u8> = amounts.flat_map(|what| [&[what, 200, 0, 0][..], &payload[..]].concat()).collect();
        hostile::<1024>(&input);
    }
}
