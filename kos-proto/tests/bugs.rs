//! A test for each bug of the one public client, kssp, and of its history, and for each mistake that the published
//! document invites. The behaviour of kssp was seen by running it.
//!
//! Some bugs are those of a program and not of its codec. Tests of the machines (`tests/machines`) cover them:
//!
//! - One flag that says "ready" for all answers, so that one `Get` takes the answer to another:
//!   `a_message_without_a_question_is_told`, `late_answers_do_not_end_a_stop`.
//! - Keep-alives by the clock of the processor, which stands while the program waits:
//!   `a_question_keeps_the_connection_over_tcp`.
//! - A `Get` that waits for ever: `every_question_ends`.
//! - A destructor that waits for a read: no machine waits.
//! - No state for a closed connection, so that the same error is thrown again and again:
//!   `a_lost_connection_is_made_again`.

use kos_proto::message::{
    BumpPositionSpeedAcceleration, JOG_DISTANCE, Motor, MotorAddress, MotorCalibrated, MotorInfo, MotorInfos,
    MotorPosition, Photos, PlaybackState, PlaybackStatus, Rotations, RotationsPerSecond, RotationsPerSecondSquared,
    SetPositionSpeedAcceleration, UnsupportedMessage,
};
use kos_proto::trajectory::{Block, LoopCount, TrajectoryData};
use kos_proto::{DecodeError, DeviceMessage, Frame, Frames, HostMessage, Item, MessageId, MessageType, frame};
use motion_core::stream::Fatal;
use motion_core::wire::{Password, Rest};

/// Motor 3 rests at 11.982422.
const POSITION: &[u8] = b"\x04\0\x0c\0\x81\x02\x07\x03\x41\x3f\xb8\0";

fn position() -> DeviceMessage<'static> {
    let (motor_address, position) = (MotorAddress(3), Rotations(11.982_422));
    DeviceMessage::from(MotorPosition { motor_address, position, tail: &[] })
}

fn frame(bytes: &[u8]) -> Frame<'_> {
    Frame::decode(bytes).expect("one message")
}

fn device(bytes: &[u8]) -> DeviceMessage<'_> {
    DeviceMessage::decode(&frame(bytes)).expect("a sound message")
}

/// Reads the bytes of a device in pieces of `cut` bytes and gives each message to `see`. The stream stays in step.
fn read(stream: &[u8], cut: usize, mut see: impl FnMut(Result<DeviceMessage<'_>, DecodeError>)) {
    let mut frames: Box<Frames> = Box::default();
    for piece in stream.chunks(cut) {
        assert_eq!(frames.push(piece), piece.len());
        while let Some(item) = frames.next() {
            match item {
                Item::Frame(frame) => see(DeviceMessage::decode(&frame)),
                item => panic!("{item:?}"),
            }
        }
    }
    assert_eq!(frames.held(), 0, "nothing is left over");
}

/// Reads `bytes` followed by a motor position, in one piece. The position must be found, which shows that the message
/// before it took exactly its own length.
fn before_a_position(bytes: &[u8], mut see: impl FnMut(Result<DeviceMessage<'_>, DecodeError>)) {
    let mut seen = 0;
    read(&[bytes, POSITION].concat(), usize::MAX, |message| {
        match seen {
            0 => see(message),
            _ => assert_eq!(message, Ok(position())),
        }
        seen += 1;
    });
    assert_eq!(seen, 2);
}

/// kssp reads field by field and ignores the length. Unknown fields at the end of a message shift everything after it.
#[test]
fn a_longer_message_does_not_shift_what_follows() {
    before_a_position(b"\x04\0\x0e\0\x81\x02\x07\x03\x41\x3f\xb8\0\x04\x04", |message| match message {
        Ok(DeviceMessage::MotorPosition(MotorPosition { position, tail, .. })) => {
            assert_eq!((position, tail), (Rotations(11.982_422), &[4, 4][..]));
        }
        message => panic!("{message:?}"),
    });
}

/// kssp takes the missing fields of a shorter message from the next message.
#[test]
fn a_shorter_message_takes_nothing_from_what_follows() {
    before_a_position(b"\x04\0\x0b\0\x81\x02\x07\x03\x41\x3f\xb8", |message| {
        assert_eq!(message, Err(DecodeError::Truncated { what: "MotorPosition", needed: 5, have: 4 }));
    });
}

/// kssp takes what one read returns: 11.9375 instead of 11.982422 if a float comes in two segments.
#[test]
fn a_float_may_come_in_two_segments() {
    for cut in 1..=POSITION.len() {
        let mut seen = 0;
        read(&POSITION.repeat(3), cut, |message| {
            assert_eq!(message, Ok(position()), "in pieces of {cut}");
            seen += 1;
        });
        assert_eq!(seen, 3);
    }
}

/// kssp reads one byte too many of an `UnsupportedMessage`, and loses the message after it.
#[test]
fn an_echo_ends_with_its_message() {
    let unknown = [4, 0, 6, 0, 0x77, 1];
    for len in 0..=unknown.len() {
        let mut echo = vec![4, 0, 7 + u8::try_from(len).unwrap(), 0, 0x81, 2, 0xff];
        echo.extend(&unknown[..len]);
        before_a_position(&echo, |message| match message {
            Ok(DeviceMessage::UnsupportedMessage(UnsupportedMessage { message: Rest(message), .. })) => {
                assert_eq!(message, &unknown[..len]);
            }
            message => panic!("{message:?}"),
        });
    }
    // An echo of an echo is bytes, and is not read any deeper.
    let twice = [&[4, 0, 14, 0, 0x81, 2, 0xff, 4, 0, 13, 0, 0x81, 2][..], &[0xff]].concat();
    assert!(matches!(device(&twice), DeviceMessage::UnsupportedMessage(echo) if echo.message == Rest(&twice[7..])));
}

/// kssp reads one motor from every `PlaybackStatus`. Without motors it reads motor 0 at 9.9e-32 from the next header.
#[test]
fn a_playback_status_may_have_no_motor() {
    for count in [0_u8, 1, 2, 10] {
        let mut status = vec![4, 0, 17 + 5 * count, 0, 0x81, 2, 2, 5, 0, 0, 0, 0, 0x42, 0x28, 0, 0, count];
        status.extend((1..=count).flat_map(|address| [address, 0x3f, 0x80, 0, 0]));
        before_a_position(&status, |message| match message {
            Ok(DeviceMessage::PlaybackStatus(PlaybackStatus {
                playback_status, photo_count, motors, tail, ..
            })) => {
                assert_eq!((playback_status, photo_count), (PlaybackState::FULL_STOP, Some(Photos(42.0))));
                let motors: Vec<_> = motors.iter().map(|place| (place.motor_address().0, place.position())).collect();
                assert_eq!(motors, (1..=count).map(|address| (address, Rotations(1.0))).collect::<Vec<_>>());
                assert!(tail.is_empty());
            }
            message => panic!("{message:?}"),
        });
    }
}

/// kssp does not know `TrajectoryData` and `SoftwareID`. It searches their content for the next byte 4, and takes that
/// for a header.
#[test]
fn an_unknown_response_is_skipped_by_its_length() {
    for (id, kind) in [(0x25, 2), (0x99, 2), (0x0f, 0x83), (0x81, 0x82), (0x12, 0)] {
        // The payload looks like a message: "motor 9 rests".
        let trap = [4, 0, 12, 0, 0x81, 2, 7, 9, 0, 0, 0, 0];
        let mut bytes = [0; 64];
        let len = frame::encode(MessageId(id), MessageType(kind), &trap, &mut bytes).unwrap();
        before_a_position(&bytes[..len], |message| match message {
            Ok(DeviceMessage::Other(other)) => {
                assert_eq!(other.payload(), trap);
                let mut again = [0; 64];
                let whole = DeviceMessage::Other(other).encode_into(&mut again).unwrap();
                assert_eq!(again[..whole], bytes[..len], "it can be passed on");
            }
            message => panic!("{message:?}"),
        });
    }
}

/// A byte 4 does not mark a header. Once the stream is out of step, it stays so until the caller resynchronises it.
#[test]
fn no_byte_4_is_taken_for_a_header() {
    let mut frames: Box<Frames> = Box::default();
    let stream = [&[0x43][..], POSITION, POSITION].concat();
    assert_eq!(frames.push(&stream), stream.len());
    for _ in 0..3 {
        let Some(Item::Fatal(Fatal::BadVersion { found: 0x43, expected: 4 })) = frames.next() else {
            panic!("the stream went on")
        };
    }
    frames.resync();
    let mut found = Vec::new();
    while let Some(item) = frames.next() {
        match item {
            Item::Frame(frame) => found.push(frame.id()),
            Item::Noise { .. } => {}
            item => panic!("{item:?}"),
        }
    }
    assert_eq!(found, [MessageId::NOTIFICATION; 2], "resync searches for a header");
}

/// A length below that of the header does not advance. A reader that adds it up never gets on.
#[test]
fn a_length_below_the_header_ends_the_stream() {
    for found in 0..6 {
        let mut frames: Box<Frames> = Box::default();
        assert_eq!(frames.push(&[4, 0, u8::try_from(found).unwrap(), 0, 0x81, 2]), 6);
        match frames.next() {
            Some(Item::Fatal(fatal)) => assert_eq!(fatal, Fatal::BadLength { found, least: 6 }),
            item => panic!("{item:?}"),
        }
    }
}

/// kssp copies as many bytes as the device says into a buffer of 16 bytes.
#[test]
fn a_guid_is_as_long_as_its_length_says() {
    for len in [0, 1, 15, 16, 17, 255, 4000_u16] {
        let body = [&len.to_be_bytes()[..], &vec![7; len.into()]].concat();
        let mut bytes = vec![0; body.len() + 6];
        frame::encode(MessageId::DEVICE_GUID, MessageType::RESPONSE, &body, &mut bytes).unwrap();
        before_a_position(&bytes, |message| match message {
            Ok(DeviceMessage::DeviceGUID(guid)) => {
                assert_eq!(guid.guid.0.len(), usize::from(len));
                assert_eq!(guid.to_bytes(), (len == 16).then_some([7; 16]));
            }
            message => panic!("{message:?}"),
        });
    }
    // A GUID with a length beyond its message takes nothing from the next message.
    before_a_position(b"\x04\0\x0a\0\x1f\x02\0\x10\x07\x07", |message| {
        assert_eq!(message, Err(DecodeError::Truncated { what: "DeviceGUID.guid", needed: 18, have: 4 }));
    });
}

/// kssp stores a password without a NUL after it, and then reads on to the next NUL in memory.
#[test]
fn a_password_ends_where_its_length_says() {
    for (text, shown) in [(&b"kos"[..], "kos"), (b"", ""), (b"kos\0", "kos"), (b"a\0b", "a\0b")] {
        let mut body = vec![11, 0, 0, 0, 1, 0, 1, 16, 0, 0];
        body.extend([0, u8::try_from(text.len()).unwrap()]);
        body.extend(text);
        body.extend([1, 0x3f, 0x80, 0, 0, 0x3f, 0, 0, 0, 0, 0, 0, 42]);
        let mut bytes = vec![0; body.len() + 6];
        frame::encode(MessageId::DEVICE_INFO, MessageType::RESPONSE, &body, &mut bytes).unwrap();
        before_a_position(&bytes, |message| match message {
            Ok(DeviceMessage::DeviceInfo(info)) => {
                assert_eq!(info.device_password, Password(text));
                assert_eq!(info.device_password.as_str(), Some(shown));
                assert_eq!((info.aux_input_status.bits(), info.photo_count.0), (1, Some(42)));
            }
            message => panic!("{message:?}"),
        });
    }
}

/// kssp took reported positions for commanded positions, on a device whose ranges do not begin at 0.
#[test]
fn positions_count_from_the_begin_of_the_range() {
    // Motor 1 stands at 5, between 2 and 12.
    let bytes =
        b"\x04\0\x20\0\x0b\x02\x01\x01\x40\xa0\0\0\x40\0\0\0\x41\x40\0\0\x43\x26\xb3\x33\x43\x26\xb3\x33\x43\x48\0\0";
    let DeviceMessage::MotorInfo(MotorInfo { motors, .. }) = device(bytes) else { panic!() };
    let motor: Motor = motors.iter().next().expect("one motor");
    assert_eq!((motor.relative_position(), motor.range()), (Some(Rotations(3.0)), Some(Rotations(10.0))));
    // To keep the motor where it is, the command has to say 3. At 5, the motor would move.
    let stop =
        SetPositionSpeedAcceleration::stop(motor.motor_address, motor.relative_position(), motor.max_max_acceleration);
    assert_eq!(stop.position, Rotations(3.0));
}

/// kssp once stopped a motor on key release with position 0 instead of speed 0. The motor drove to 0.
#[test]
fn a_stop_is_a_speed_of_0() {
    let sharp = RotationsPerSecondSquared(100.0);
    for at in [None, Some(Rotations(0.0)), Some(Rotations(3.0)), Some(Rotations(-7.5))] {
        let stop = SetPositionSpeedAcceleration::stop(MotorAddress(2), at, sharp);
        let mut out = [0; 20];
        HostMessage::from(stop).encode_into(&mut out).unwrap();
        assert_eq!(out[12..16], [0; 4], "the speed on the wire");
        assert_eq!(stop.position, at.unwrap_or(JOG_DISTANCE));
    }
    let (motor_address, speed) = (MotorAddress(2), RotationsPerSecond(20.0));
    let home = SetPositionSpeedAcceleration::move_to(motor_address, Rotations(0.0), speed, sharp);
    assert!(!home.is_stop(), "position 0 is a place to go to");
    let nowhere =
        BumpPositionSpeedAcceleration { motor_address, delta: Rotations(0.0), speed, acceleration: sharp, tail: &[] };
    assert!(!nowhere.is_stop());
}

/// The document prints a `MotorInfo` of 32 bytes with the length of the older dialect, 28. The length counts.
#[test]
fn a_stale_length_is_not_repaired() {
    let printed = b"\x04\x00\x1c\x00\x0b\x82\x01\x01\xc2\x41\x70\x00\x00\x00\x00\x00\xc3\x54\x20\x40\x43\x26\xb3\x33\x43\x26\xb3\x33\x43\x48\x00\x00";
    let mut frames: Box<Frames> = Box::default();
    assert_eq!(frames.push(printed), printed.len());
    assert!(matches!(frames.next(), Some(Item::Frame(frame)) if frame.bytes() == &printed[..28]));
    assert!(matches!(frames.next(), Some(Item::Fatal(Fatal::BadVersion { found: 0x43, .. }))));
}

/// kssp started with the older dialect, and lost step on a device with the newer one, whose `MotorInfo` and
/// `MotorCalibrated` are 4 bytes longer. Here the length of the message tells the dialects apart.
#[test]
fn either_dialect_is_read_by_its_length() {
    let (begin, end) = (b"\x40\0\0\0", b"\x41\x40\0\0");
    for (bytes, wanted) in [
        ([&b"\x04\0\x0c\0\x81\x02\x11\x01"[..], end].concat(), None),
        ([&b"\x04\0\x10\0\x81\x02\x11\x01"[..], begin, end].concat(), Some(Rotations(2.0))),
    ] {
        before_a_position(&bytes, |message| match message {
            Ok(DeviceMessage::MotorCalibrated(MotorCalibrated { begin_position, end_position, tail, .. })) => {
                assert_eq!((begin_position, end_position, tail), (wanted, Rotations(12.0), &[][..]));
            }
            message => panic!("{message:?}"),
        });
    }
    let speeds = [0x43, 0x26, 0xb3, 0x33].repeat(3);
    for (bytes, old) in [
        ([&b"\x04\0\x1c\0\x0b\x02\x01\x01\x40\xa0\0\0"[..], end, &speeds].concat(), true),
        ([&b"\x04\0\x20\0\x0b\x02\x01\x01\x40\xa0\0\0"[..], begin, end, &speeds].concat(), false),
    ] {
        before_a_position(&bytes, |message| match message {
            Ok(DeviceMessage::MotorInfo(MotorInfo { motors, .. })) => {
                assert_eq!(matches!(motors, MotorInfos::Old(_)), old);
                let ends: Vec<_> = motors.iter().map(|motor| motor.end_position).collect();
                assert_eq!(ends, [Rotations(12.0)]);
            }
            message => panic!("{message:?}"),
        });
    }
}

/// The document counts photos as a float in `PlaybackStatus`, and as an integer in `DeviceInfo`. 42 photos read as the
/// other type would be 0, or a thousand million.
#[test]
fn photos_are_a_float_in_one_message_only() {
    let status = b"\x04\0\x11\0\x81\x02\x02\x06\0\0\0\0\x42\x28\0\0\0";
    let DeviceMessage::PlaybackStatus(status) = device(status) else { panic!() };
    assert_eq!(status.photo_count.and_then(Photos::count), Some(42));
    let info = b"\x04\0\x1f\0\x0f\x02\x0b\0\0\0\x01\0\x01\x10\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x2a";
    let DeviceMessage::DeviceInfo(info) = device(info) else { panic!() };
    assert_eq!(info.photo_count.0, Some(42));
}

/// The document describes the two loop counts in one order and sends them in the other.
#[test]
fn loop_counts_are_in_the_order_of_the_wire() {
    let mut bytes = vec![4, 0, 47, 0, 0x12, 2, 1, 1, 0, 37];
    bytes.resize(47, 0);
    bytes[10 + 9] = 3;
    bytes[10 + 10] = 255;
    let DeviceMessage::TrajectoryData(TrajectoryData { blocks, .. }) = device(&bytes) else { panic!() };
    let Some(Block::Playback(playback)) = blocks.iter().next() else { panic!() };
    assert_eq!((playback.loop_after_rapid_reverse, playback.loop_after_reverse), (LoopCount(3), LoopCount::FOREVER));
}
