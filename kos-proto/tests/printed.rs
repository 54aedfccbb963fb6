//! Examples that the specification prints, as printed and corrected (section 4 of the specification; decision K-F1).

use kos_proto::message::{Motor, MotorAddress, MotorInfos, Rotations, RotationsPerSecond, RotationsPerSecondSquared};
use kos_proto::message::{MotorInfo, SetPositionSpeedAcceleration};
use kos_proto::{DecodeError, DeviceMessage, Frame, Frames, HostMessage, Item};
use motion_core::stream::Fatal;

fn from_host(bytes: &[u8]) -> HostMessage<'_> {
    HostMessage::decode(&Frame::decode(bytes).unwrap()).unwrap()
}

fn from_device(bytes: &[u8]) -> DeviceMessage<'_> {
    DeviceMessage::decode(&Frame::decode(bytes).unwrap()).unwrap()
}

/// Reads a stream with a wrong length: the first message, and then the error.
fn out_of_step(bytes: &[u8], first: impl FnOnce(Frame<'_>)) -> Fatal {
    let mut frames: Box<Frames> = Box::default();
    assert_eq!(frames.push(bytes), bytes.len());
    match frames.next() {
        Some(Item::Frame(frame)) => first(frame),
        item => panic!("{item:?}"),
    }
    match frames.next() {
        Some(Item::Fatal(fatal)) => fatal,
        item => panic!("{item:?}"),
    }
}

#[test]
fn printed_questions_are_decoded() {
    assert!(matches!(from_host(b"\x04\x00\x06\x00\x0f\x01"), HostMessage::GetDeviceInfo(_)));
    assert!(matches!(from_host(b"\x04\x00\x06\x00\x0b\x01"), HostMessage::GetMotorInfo(_)));
    assert!(matches!(from_host(b"\x04\x00\x06\x00\x00\x00"), HostMessage::KeepAlive(_)));
}

/// The length says 28 bytes, but 32 are printed. The message is read as the older dialect, and the stream ends at the
/// rest.
#[test]
fn the_printed_motor_info_ends_the_stream() {
    let printed = b"\x04\x00\x1c\x00\x0b\x82\x01\x01\xc2\x41\x70\x00\x00\x00\x00\x00\xc3\x54\x20\x40\x43\x26\xb3\x33\x43\x26\xb3\x33\x43\x48\x00\x00";
    let fatal = out_of_step(printed, |frame| {
        let DeviceMessage::MotorInfo(MotorInfo { more, motors, .. }) = DeviceMessage::decode(&frame).unwrap() else {
            panic!("{frame:?}")
        };
        assert!(more && matches!(motors, MotorInfos::Old(_)));
        let [motor] = motors.iter().collect::<Vec<_>>()[..] else { panic!("{motors:?}") };
        assert_eq!(motor.position, Rotations(-48.359_375), "the text says 49.35938");
        assert_eq!((motor.end_position.get().to_bits(), motor.is_calibrated()), (0, false));
        assert_eq!(motor.max_max_setup_speed, RotationsPerSecond(-212.125_98));
    });
    assert_eq!(fatal, Fatal::BadVersion { found: 0x43, expected: 4 });
}

#[test]
fn the_corrected_motor_info_is_decoded() {
    let corrected = b"\x04\x00\x20\x00\x0b\x82\x01\x01\xc2\x45\x70\x00\x00\x00\x00\x00\xc3\x54\x20\x40\x43\x26\xb3\x33\x43\x26\xb3\x33\x43\x48\x00\x00";
    let message = from_device(corrected);
    let DeviceMessage::MotorInfo(MotorInfo { more: true, motors, tail: &[] }) = message else { panic!("{message}") };
    let [motor] = motors.iter().collect::<Vec<_>>()[..] else { panic!("{motors:?}") };
    let speed = RotationsPerSecond(166.7);
    let wanted = Motor {
        motor_address: MotorAddress(1),
        position: Rotations(-49.359_375),
        begin_position: Some(Rotations(0.0)),
        end_position: Rotations(-212.125_98),
        max_max_setup_speed: speed,
        max_max_move_speed: speed,
        max_max_acceleration: RotationsPerSecondSquared(200.0),
    };
    assert_eq!(motor, wanted);
    assert_eq!(motor.relative_position(), Some(Rotations(-49.359_375)));
    assert_eq!((speed.get() * 60.0).round().to_bits(), 10_002.0_f32.to_bits(), "the text has rotations per minute");
}

#[test]
fn the_printed_jog_of_an_uncalibrated_motor_is_decoded_and_encoded() {
    let printed = b"\x04\x00\x14\x00\x80\x00\x1c\x03\x46\xc3\x50\x00\x42\xc8\x00\x00\x42\xc8\x00\x00";
    let (speed, acceleration) = (RotationsPerSecond(100.0), RotationsPerSecondSquared(100.0));
    let jog = SetPositionSpeedAcceleration::jog(MotorAddress(3), speed, acceleration);
    assert_eq!(from_host(printed), HostMessage::from(jog));
    let mut out = [0; 20];
    assert_eq!(HostMessage::from(jog).encode_into(&mut out), Ok(20));
    assert_eq!(out, *printed);
}

/// The length says 16 bytes, but 20 are printed. The message is cut off, and the stream ends at the rest.
#[test]
fn the_printed_move_of_a_calibrated_motor_ends_the_stream() {
    let printed = b"\x04\x00\x10\x00\x80\x00\x1c\x01\xc2\x4b\xa4\x14\x42\xc8\x00\x00\x42\xc8\x00\x00";
    let fatal = out_of_step(printed, |frame| {
        let truncated = DecodeError::Truncated { what: "SetPositionSpeedAcceleration", needed: 13, have: 9 };
        assert_eq!(HostMessage::decode(&frame), Err(truncated));
    });
    assert_eq!(fatal, Fatal::BadVersion { found: 0x42, expected: 4 });

    let mut corrected = *printed;
    corrected[2] = 0x14;
    let (speed, acceleration) = (RotationsPerSecond(100.0), RotationsPerSecondSquared(100.0));
    let position = Rotations(-50.910_233);
    let message = SetPositionSpeedAcceleration::move_to(MotorAddress(1), position, speed, acceleration);
    assert_eq!(from_host(&corrected), HostMessage::from(message));
}

#[test]
fn the_printed_motor_position_is_decoded() {
    let message = from_device(b"\x04\x00\x0c\x00\x81\x02\x07\x03\x41\x3f\xb8\x00");
    let DeviceMessage::MotorPosition(position) = message else { panic!("{message}") };
    assert_eq!((position.motor_address, position.position), (MotorAddress(3), Rotations(11.982_422)));
    assert_eq!(message.to_string(), "MotorPosition { motor_address: 3, position: 11.982422 rev }");
}
