//! Law 14 and the findings of lint: each rule of the decisions, and no finding in legal messages.

use kos_proto::lint::Context;
use kos_proto::message::*;
use kos_proto::trajectory::{
    Axis, Block, Blocks, DelayInterval, DelayMode, LoopCount, Playback, Point, Points, Segment, TimeLapse,
    TrajectoryData,
};
use kos_proto::{DeviceMessage, EncodeError, Frame, HostMessage};
use motion_core::lint::Severity::{Error, Warning};
use motion_core::lint::{Lints, Severity};
use motion_core::wire::Messages;
use proptest::prelude::*;

const MOTOR: MotorAddress = MotorAddress(2);
const ACCELERATION: RotationsPerSecondSquared = RotationsPerSecondSquared(50.0);
const SPEED: RotationsPerSecond = RotationsPerSecond(20.0);

fn found(lints: Lints) -> Vec<(Severity, &'static str)> {
    lints.into_iter().map(|lint| (lint.severity, lint.what)).collect()
}

fn host(message: HostMessage<'_>) -> Vec<(Severity, &'static str)> {
    found(message.lint(&Context::default()))
}

fn device(message: DeviceMessage<'_>) -> Vec<(Severity, &'static str)> {
    found(message.lint(&Context::default()))
}

/// A motor with a range from 2 to 12, at position 5.
fn motor() -> Motor {
    Motor::from(&entry(MOTOR.0))
}

/// The same motor without a range: both its ends are 0 (decision K-M5).
fn uncalibrated() -> Motor {
    Motor { begin_position: Some(Rotations(0.0)), end_position: Rotations(0.0), ..motor() }
}

fn entry(address: u8) -> MotorEntry {
    let (position, begin, end) = (Rotations(5.0), Rotations(2.0), Rotations(12.0));
    let (setup, play) = (RotationsPerSecond(166.7), RotationsPerSecond(100.0));
    MotorEntry::new(MotorAddress(address), position, begin, end, setup, play, ACCELERATION)
}

fn go(position: f32, speed: f32, acceleration: f32) -> HostMessage<'static> {
    let (speed, acceleration) = (RotationsPerSecond(speed), RotationsPerSecondSquared(acceleration));
    let message = SetPositionSpeedAcceleration::move_to(MOTOR, Rotations(position), speed, acceleration);
    HostMessage::from(message)
}

fn bump(delta: f32, speed: f32, acceleration: f32) -> HostMessage<'static> {
    HostMessage::from(BumpPositionSpeedAcceleration {
        motor_address: MOTOR,
        delta: Rotations(delta),
        speed: RotationsPerSecond(speed),
        acceleration: RotationsPerSecondSquared(acceleration),
        tail: &[],
    })
}

fn user(text: &[u8]) -> UserPassword<'_> {
    UserPassword { password: Password(text), tail: &[] }
}

fn stored(text: &[u8]) -> DevicePassword<'_> {
    DevicePassword { password: Password(text), tail: &[] }
}

fn playback() -> Playback<'static> {
    Playback {
        playback_mode: PlaybackMode::LIVE_MOTION,
        duration: Seconds(10.0),
        rapid_reverse_duration: Seconds(10.0),
        loop_after_rapid_reverse: LoopCount::NONE,
        loop_after_reverse: LoopCount::FOREVER,
        delay_mode: DelayMode::UNTIL,
        delay_interval_bits: DelayInterval::from_unix_time(1_700_000_000),
        camera_roll_enabled: Bool::FALSE,
        camera_roll_pre_delay: Seconds(0.0),
        camera_roll_post_delay: Seconds(0.0),
        flash_mark_enabled: Bool::FALSE,
        flash_mark_type: 0,
        flash_mark_post_delay: Seconds(0.0),
        use_external_trigger: Bool::FALSE,
        using_lanc: Bool::FALSE,
        return_to_home_percent: Normalized(1.0),
        tail: &[],
    }
}

fn time_lapse() -> TimeLapse<'static> {
    TimeLapse {
        delay: Seconds(0.0),
        exposure: Seconds(0.0),
        move_photos: 0,
        not_used: 0,
        pre_move_photos: 0,
        post_move_photos: 0,
        tail: &[],
    }
}

fn axis(segment_count: u8) -> Block<'static> {
    Block::Axis(Axis { motor_address: MOTOR, segment_count, tail: &[] })
}

fn segment(segment_number: u8, points: [(f32, f32); 4]) -> Block<'static> {
    let points = Points(points.map(|(time, position)| Point::new(time, position)));
    Block::Segment(Segment { motor_address: MOTOR, segment_number, points, tail: &[] })
}

const FIRST: [(f32, f32); 4] = [(0.0, 0.0), (0.1, 0.0), (0.4, 0.5), (0.5, 0.5)];
const SECOND: [(f32, f32); 4] = [(0.5, 0.5), (0.6, 0.5), (0.9, 1.0), (1.0, 1.0)];

/// Findings in a move of these blocks.
fn blocks(blocks: &[Block<'_>]) -> Vec<(Severity, &'static str)> {
    let mut out = [0; 1024];
    let blocks = Blocks::encode(blocks, &mut out).unwrap();
    host(HostMessage::from(TrajectoryData { blocks, tail: &[] }))
}

/// Findings in a sound move that is played with these settings.
fn played(playback: Playback<'_>) -> Vec<(Severity, &'static str)> {
    let (playback, time_lapse) = (Block::Playback(playback), Block::TimeLapse(time_lapse()));
    blocks(&[playback, time_lapse, axis(2), segment(0, FIRST), segment(1, SECOND)])
}

/// Findings in a sound move with these segments instead of its own.
fn segments(count: u8, segments: &[Block<'_>]) -> Vec<(Severity, &'static str)> {
    let first = [Block::Playback(playback()), Block::TimeLapse(time_lapse()), axis(count)];
    blocks(&[&first, segments].concat())
}

#[test]
fn lint_is_silent_on_legal_messages_of_a_client() {
    let reset = ResetAxis { motor_address: MotorAddress::ALL, tail: &[] };
    let start = StartPlayback { direction: PlaybackDirection::FORWARD, start_time: Seconds(0.0), tail: &[] };
    let StartPlayback { direction, start_time, tail } = start;
    let setup = SetupPlayback { direction, start_time, delay_return: Bool::TRUE, tail };
    let lamps = LEDStatus { master_status: LedMode::ON, slave_status: LedMode::FAST_BLINK, tail: &[] };
    let mut out = [0; 256];
    let sound =
        [Block::Playback(playback()), Block::TimeLapse(time_lapse()), axis(2), segment(0, FIRST), segment(1, SECOND)];
    let move_data = TrajectoryData { blocks: Blocks::encode(&sound, &mut out).unwrap(), tail: &[] };
    let messages = [
        HostMessage::from(KeepAlive::default()),
        HostMessage::from(GetNetworkInfo::new(true)),
        HostMessage::from(GetLEDStatus::default()),
        HostMessage::from(lamps),
        HostMessage::from(GetMotorInfo::default()),
        HostMessage::from(GetDeviceInfo::default()),
        HostMessage::from(user(b"")),
        HostMessage::from(stored(b"thirty-two bytes are not a flaw.")),
        HostMessage::from(GetTrajectoryData::default()),
        HostMessage::from(move_data),
        HostMessage::from(GetDeviceGUID::default()),
        HostMessage::from(GetSoftwareID::default()),
        HostMessage::from(SoftwareID { platform: 200, tail: &[] }),
        HostMessage::from(ResetDevice::default()),
        HostMessage::from(reset),
        HostMessage::from(MarkBeginPosition { motor_address: MotorAddress(1), tail: &[] }),
        HostMessage::from(MarkEndPosition { motor_address: MotorAddress(10), tail: &[] }),
        HostMessage::from(start),
        HostMessage::from(StopPlayback::default()),
        HostMessage::from(RapidToFirstKeyFrame::default()),
        HostMessage::from(TakePicture { motor_address: MotorAddress::ALL, exposure: Seconds(0.5), tail: &[] }),
        HostMessage::from(setup),
        go(10.0, 20.0, 50.0),
        bump(-3.0, 20.0, 50.0),
    ];
    let motors = [1, 2, 10].map(|address| Motor::from(&entry(address)));
    for message in messages {
        assert_eq!(host(message), [], "{message}");
        assert_eq!(found(message.lint(&Context::default().with_motors(&motors))), [], "{message}");
    }
    let names = messages.map(|message| message.name());
    assert!(HostMessage::ALL.iter().map(|kind| kind.name).eq(names), "all messages, in the order of the table");
}

#[test]
fn lint_is_silent_on_legal_messages_of_a_device() {
    let (new, old) =
        ([entry(0x83)], [OldMotorEntry::new(MOTOR, Rotations(1.0), Rotations(2.0), SPEED, SPEED, ACCELERATION)]);
    let info = |more, motors| DeviceMessage::MotorInfo(MotorInfo { more, motors, tail: &[] });
    let status = |photo_count, motors| {
        let (playback_status, elapsed_time) = (PlaybackState::START_FRAME, Normalized(0.25));
        DeviceMessage::from(PlaybackStatus { playback_status, elapsed_time, photo_count, motors, tail: &[] })
    };
    let calibrated = |begin_position| {
        let (motor_address, end_position) = (MOTOR, Rotations(-3.0));
        DeviceMessage::from(MotorCalibrated { motor_address, begin_position, end_position, tail: &[] })
    };
    let failed = |error_code, address| {
        DeviceMessage::from(ErrorStatus { error_code, motor_address: MotorAddress(address), tail: &[] })
    };
    let presence = [MotorPresence::new(MOTOR, Bool::TRUE, MotorType::FIZ, SPEED, SPEED, ACCELERATION)];
    let places = [MotorPlace::new(MOTOR, Rotations(1.0))];
    let messages = [
        DeviceMessage::from(network_info()),
        DeviceMessage::from(LEDStatus { master_status: LedMode::OFF, slave_status: LedMode::SLOW_BLINK, tail: &[] }),
        info(true, MotorInfos::New(&new)),
        info(false, MotorInfos::New(&[])),
        info(false, MotorInfos::Old(&old)),
        DeviceMessage::from(device_info()),
        DeviceMessage::from(TrajectoryData::default()),
        DeviceMessage::from(DeviceGUID { guid: Block16(&[7; 16]), tail: &[] }),
        DeviceMessage::from(SoftwareID { platform: 1, tail: &[] }),
        DeviceMessage::from(MotorStatus { motors: Counted(&presence), tail: &[] }),
        status(Some(Photos(10.0)), &places),
        status(None, &[]),
        failed(ErrorCode::RUNAWAY, 3),
        failed(ErrorCode::BAD_MOTOR_ADDRESS, 77),
        failed(ErrorCode::LOCKED_OUT, 0),
        DeviceMessage::from(MotorPosition { motor_address: MOTOR, position: Rotations(1.0), tail: &[] }),
        calibrated(Some(Rotations(0.0))),
        calibrated(None),
        DeviceMessage::from(AuxInputStatus { status: AuxInputs::SLAVE_PRESENT, tail: &[] }),
        DeviceMessage::from(UnsupportedMessage { message: Rest(&[4, 0, 6, 0, 0x77, 1]), tail: &[] }),
    ];
    for message in messages {
        assert_eq!(device(message), [], "{message}");
    }
    let mut names = messages.map(|message| message.name()).to_vec();
    names.dedup();
    assert!(DeviceMessage::ALL.iter().map(|kind| kind.name).eq(names), "all messages, in the order of the table");
}

fn network_info() -> NetworkInfo<'static> {
    NetworkInfo {
        dhcp: Bool::TRUE,
        mac_address: MacAddress::from([0, 0x11, 0x22, 0x33, 0x44, 0x55]),
        ip_address: Ipv4(0xc0a8_3201),
        subnet_mask: Ipv4(0xffff_ff00),
        gateway: Ipv4(0xc0a8_3201),
        device_type: DeviceType::SECOND_SHOOTER_PRO,
        device_addr: 0,
        tail: &[],
    }
}

fn device_info() -> DeviceInfo<'static> {
    DeviceInfo {
        device_type: DeviceType::CINE_SHOOTER,
        device_addr: 0,
        playback_mode: PlaybackMode::TIME_LAPSE_SMS,
        playback_status: PlaybackState::SMS_MOTORS_STOPPED,
        firmware_version: FirmwareVersion([1, 0, 1, 16]),
        network_id: 0,
        hardware_id: 0,
        device_password: Password(b"kos"),
        aux_input_status: AuxInputs::MASTER_TIP,
        delay_time_remaining: Seconds(0.0),
        elapsed_time: Normalized(1.0),
        photo_count: Newer(Some(42)),
        tail: &[],
    }
}

/// Safety decision 3, decision K-N1.
#[test]
fn a_stop_is_refused_only_for_its_address() {
    let mut out = [0; 20];
    let known = [motor()];
    for context in [Context::default(), Context::default().with_motors(&known)] {
        for (position, acceleration) in
            [(1e9, 50.0), (f32::NAN, 50.0), (0.0, 0.0), (0.0, -1.0), (f32::INFINITY, f32::NAN)]
        {
            for message in
                [go(position, 0.0, acceleration), go(position, -0.0, acceleration), bump(position, 0.0, acceleration)]
            {
                assert_eq!(message.encode_checked(&context, &mut out), Ok(20), "{message}");
            }
        }
    }
    assert_eq!(host(go(1e9, 0.0, 50.0)), [], "positions do not matter in a stop");
    assert_eq!(host(go(0.0, 0.0, 0.0)), [(Warning, "acceleration")]);
    assert_eq!(host(bump(0.0, 0.0, -1.0)), [(Warning, "acceleration")]);
    assert_eq!(
        host(go(f32::NAN, 0.0, f32::NAN)),
        [(Warning, "acceleration"), (Warning, "position"), (Warning, "acceleration")]
    );

    for address in [0, 11, 0x7f] {
        let stop = SetPositionSpeedAcceleration::stop(MotorAddress(address), None, ACCELERATION);
        let stop = HostMessage::from(stop);
        assert_eq!(host(stop), [(Error, "motor_address")]);
        let refused = stop.encode_checked(&Context::default(), &mut out);
        assert!(matches!(refused, Err(EncodeError::Refused(lint)) if lint.what == "motor_address"));
    }
    let marked = SetPositionSpeedAcceleration::stop(MotorAddress(0x82), None, ACCELERATION);
    assert_eq!(host(HostMessage::from(marked)), [(Warning, "motor_address")]);
}

/// Decisions K-M6, K-M7, K-M9 and K-N1.
#[test]
fn moves_are_compared_with_the_limits_of_the_motor() {
    assert_eq!(host(go(1.0, -1.0, 50.0)), [(Error, "speed")]);
    assert_eq!(host(go(1.0, 1.0, -50.0)), [(Error, "acceleration")]);
    assert_eq!(host(go(1.0, 1.0, 0.0)), [(Warning, "acceleration")]);
    assert_eq!(host(bump(f32::INFINITY, 1.0, 50.0)), [(Error, "delta")]);
    assert_eq!(
        host(go(f32::NAN, f32::NAN, f32::NAN)),
        [(Error, "position"), (Error, "speed"), (Error, "acceleration")]
    );

    let known = [motor()];
    let measured = |message: HostMessage<'_>| found(message.lint(&Context::default().with_motors(&known)));
    assert_eq!(measured(go(10.1, 20.0, 50.0)), [(Warning, "position")]);
    assert_eq!(measured(go(-0.1, 20.0, 50.0)), [(Warning, "position")]);
    assert_eq!(measured(bump(7.1, 20.0, 50.0)), [(Warning, "position")], "it stands at 3 of 10");
    assert_eq!(measured(bump(7.0, 20.0, 50.0)), []);
    // By hand, the greatest speed of the setup counts, which is 166.7 here, and not that of a move.
    assert_eq!(measured(go(10.0, 166.7, 50.0)), []);
    assert_eq!(measured(go(10.0, 166.8, 50.1)), [(Warning, "speed"), (Warning, "acceleration")]);
    let other = MarkEndPosition { motor_address: MotorAddress(1), tail: &[] };
    assert_eq!(measured(HostMessage::from(other)), [(Error, "motor_address")]);

    let uncalibrated = [uncalibrated()];
    let measured = |message: HostMessage<'_>| found(message.lint(&Context::default().with_motors(&uncalibrated)));
    assert_eq!(measured(go(3.0, 20.0, 50.0)), [(Warning, "position")]);
    for speed in [20.0, -20.0] {
        let jog = SetPositionSpeedAcceleration::jog(MOTOR, RotationsPerSecond(speed), ACCELERATION);
        assert_eq!(measured(HostMessage::from(jog)), []);
    }
    let backward = [Motor { end_position: Rotations(-8.0), position: Rotations(-1.0), ..motor() }];
    let measured = |message: HostMessage<'_>| found(message.lint(&Context::default().with_motors(&backward)));
    assert_eq!((measured(go(-10.0, 20.0, 50.0)), measured(go(1.0, 20.0, 50.0))), (vec![], vec![(Warning, "position")]));
}

/// Decision K-M6.
#[test]
fn moves_are_compared_with_the_limits_of_the_kind_of_axis() {
    let mut known = [motor()];
    known[0].max_max_setup_speed = RotationsPerSecond(170.0);
    known[0].max_max_acceleration = RotationsPerSecondSquared(80.0);
    // Limits of the specification. Of the motor's own limits only the acceleration of pan is lower.
    for (kind, speed, acceleration, measured_speed, measured_acceleration) in [
        (AxisKind::Slider, 165.0, 100.0, 165.0, 80.0),
        (AxisKind::Pan, 165.0, 100.0, 165.0, 80.0),
        (AxisKind::Tilt, 65.0, 50.0, 65.0, 50.0),
        (AxisKind::Focus, 200.0, 50.0, 170.0, 50.0),
        (AxisKind::Zoom, 200.0, 50.0, 170.0, 50.0),
    ] {
        let kinds = [(MotorAddress(1), AxisKind::Tilt), (MotorAddress(MOTOR.0 | 0x80), kind)];
        let context = Context::default().with_kinds(&kinds);
        for (context, speed, acceleration) in
            [(context, speed, acceleration), (context.with_motors(&known), measured_speed, measured_acceleration)]
        {
            let both = |message: HostMessage<'_>| found(message.lint(&context));
            for message in [go, bump] {
                assert_eq!(both(message(1.0, speed, acceleration)), [], "{kind:?}");
                let more = (Warning, "speed");
                assert_eq!(both(message(1.0, speed + 0.1, acceleration)), [more], "{kind:?}");
                let more = (Warning, "acceleration");
                assert_eq!(both(message(1.0, speed, acceleration + 0.1)), [more], "{kind:?}");
            }
        }
    }
    let iris = [(MOTOR, AxisKind::Iris)];
    assert_eq!(found(go(1.0, 1e6, 1e6).lint(&Context::default().with_kinds(&iris))), [], "no limits are specified");
    // An impossible motor can still be compared.
    known[0].max_max_move_speed = RotationsPerSecond(f32::NAN);
    let tilt = [(MOTOR, AxisKind::Tilt)];
    let context = Context::default().with_kinds(&tilt).with_motors(&known);
    assert_eq!(found(go(1.0, 65.1, 50.0).lint(&context)), [(Warning, "speed")]);
}

/// Decision K-M5: reported positions lie between the ends of the range, commanded positions count from 0.
#[test]
fn a_range_need_not_begin_at_0() {
    for (begin, end) in [(2.0, 12.0), (-40.0, -30.0), (12.0, 2.0)] {
        let range: f32 = end - begin;
        let known = [Motor {
            position: Rotations(begin + range * 0.5),
            begin_position: Some(Rotations(begin)),
            end_position: Rotations(end),
            ..motor()
        }];
        let context = Context::default().with_motors(&known);
        let commanded = |part: f32| found(go(range * part, 20.0, 50.0).lint(&context));
        let bumped = |part: f32| found(bump(range * part, 20.0, 50.0).lint(&context));
        let reported = |part: f32| {
            let position = Rotations(begin + range * part);
            let message = MotorPosition { motor_address: MOTOR, position, tail: &[] };
            found(DeviceMessage::from(message).lint(&context))
        };
        let outside = [(Warning, "position")];
        for part in [0.0, 0.5, 1.0] {
            assert_eq!((commanded(part), reported(part)), (vec![], vec![]), "{begin} to {end}, {part}");
            assert_eq!(bumped(part - 0.5), [], "from the middle of {begin} to {end}");
        }
        for part in [-0.1, 1.1] {
            assert_eq!((commanded(part), reported(part)), (outside.into(), outside.into()), "{begin} to {end}, {part}");
            assert_eq!(bumped(part - 0.5), outside, "from the middle of {begin} to {end}");
        }
        assert_eq!(reported(1.0005), [], "a motor may rest a little past its end");
    }
    let stranger = MotorPosition { motor_address: MOTOR, position: Rotations(99.0), tail: &[] };
    assert_eq!(device(DeviceMessage::from(stranger)), [], "the motor is not known");
    let uncalibrated = [uncalibrated()];
    let context = Context::default().with_motors(&uncalibrated);
    assert_eq!(found(DeviceMessage::from(stranger).lint(&context)), []);
}

/// Decision K-P12.
#[test]
fn errors_that_are_about_no_motor_have_address_0() {
    let failed = |code, address| {
        let (error_code, motor_address) = (ErrorCode(code), MotorAddress(address));
        device(DeviceMessage::from(ErrorStatus { error_code, motor_address, tail: &[] }))
    };
    for code in [0, 1, 2, 3, 6, 7, 19, 20] {
        assert_eq!((failed(code, 0), failed(code, 1)), (vec![], vec![(Warning, "motor_address")]), "{code}");
    }
    assert_eq!(failed(2, 11), [(Error, "motor_address"), (Warning, "motor_address")]);
    assert_eq!((failed(15, 3), failed(17, 3)), (vec![], vec![]), "the motor means nothing");
}

fn any_float() -> impl Strategy<Value = f32> {
    prop_oneof![any::<u32>().prop_map(f32::from_bits), -300.0_f32..300.0, Just(0.0), Just(-0.0)]
}

fn any_motor() -> impl Strategy<Value = Motor> {
    let positions = (any_float(), proptest::option::of(any_float()), any_float());
    (1..=10_u8, any::<bool>(), positions, (any_float(), any_float(), any_float())).prop_map(
        |(address, fiz, (position, begin, end), (setup, play, acceleration))| Motor {
            motor_address: MotorAddress(address | if fiz { 0x80 } else { 0 }),
            position: Rotations(position),
            begin_position: begin.map(Rotations),
            end_position: Rotations(end),
            max_max_setup_speed: RotationsPerSecond(setup),
            max_max_move_speed: RotationsPerSecond(play),
            max_max_acceleration: RotationsPerSecondSquared(acceleration),
        },
    )
}

fn any_kind() -> impl Strategy<Value = AxisKind> {
    use AxisKind::{Focus, Iris, Pan, Slider, Tilt, Zoom};
    proptest::sample::select(vec![Slider, Pan, Tilt, Focus, Iris, Zoom])
}

proptest! {
    /// Safety decision 3: every motor of the device may be stopped, whatever is known of the device.
    #[test]
    fn a_motor_of_the_device_may_always_be_stopped(
        motors in proptest::collection::vec(any_motor(), 0..4),
        kinds in proptest::collection::vec((1..=10_u8, any_kind()), 0..4),
        counts_bytes: bool,
        address in 1..=10_u8,
        other in any_float(),
        acceleration in any_float(),
        minus: bool,
    ) {
        let kinds: Vec<_> = kinds.into_iter().map(|(address, kind)| (MotorAddress(address), kind)).collect();
        let mut context = Context::default().with_motors(&motors).with_kinds(&kinds);
        if counts_bytes {
            context = context.with_byte_counts();
        }
        let address = motors.first().map_or(address, |motor| motor.motor_address.number());
        let (motor_address, speed) = (MotorAddress(address), RotationsPerSecond(if minus { -0.0 } else { 0.0 }));
        let (position, acceleration) = (Rotations(other), RotationsPerSecondSquared(acceleration));
        let stop = SetPositionSpeedAcceleration { motor_address, position, speed, acceleration, tail: &[] };
        let halt = BumpPositionSpeedAcceleration { motor_address, delta: position, speed, acceleration, tail: &[] };
        let known = SetPositionSpeedAcceleration::stop(motor_address, Some(position), acceleration);
        for message in [
            HostMessage::from(stop),
            HostMessage::from(halt),
            HostMessage::from(known),
            HostMessage::from(StopPlayback::default()),
        ] {
            let mut out = [0; 20];
            prop_assert_eq!(message.encode_checked(&context, &mut out), Ok(message.encoded_len()));
            prop_assert_eq!(HostMessage::decode(&Frame::decode(&out[..message.encoded_len()]).unwrap()), Ok(message));
        }
        prop_assert_eq!(found(HostMessage::from(known).lint(&context)), []);
    }
}

/// Decision K-M1.
#[test]
fn only_a_reset_is_for_all_motors() {
    let (motor_address, tail) = (MotorAddress::ALL, &[][..]);
    assert_eq!(host(HostMessage::from(MarkBeginPosition { motor_address, tail })), [(Error, "motor_address")]);
    assert_eq!(host(HostMessage::from(MarkEndPosition { motor_address, tail })), [(Error, "motor_address")]);
    let picture = |address, exposure| {
        let (motor_address, exposure) = (MotorAddress(address), Seconds(exposure));
        host(HostMessage::from(TakePicture { motor_address, exposure, tail }))
    };
    assert_eq!(picture(2, -0.5), [(Warning, "motor_address"), (Error, "exposure")]);
    assert_eq!(picture(11, 0.5), [(Error, "motor_address"), (Warning, "motor_address")]);
}

/// Decisions K-T1, K-T2, K-T4 and K-F4.
#[test]
fn passwords_are_ascii_short_and_without_nuls() {
    let accented = HostMessage::from(user("pé".as_bytes()));
    assert_eq!(host(accented), [(Error, "password")]);
    assert_eq!(found(accented.lint(&Context::default().with_byte_counts())), [(Warning, "password")]);
    assert_eq!(host(HostMessage::from(stored(b"kos\0"))), [(Warning, "password")]);
    assert_eq!(host(HostMessage::from(stored(&[b'x'; 33]))), [(Warning, "password")]);
    let tail = UserPassword { password: Password(b"kos"), tail: &[0] };
    assert_eq!(host(HostMessage::from(tail)), [(Warning, "tail")]);
    for message in [accented, HostMessage::from(user(b"hush"))] {
        let shown = format!("{message} {message:?} {:?}", message.lint(&Context::default()));
        assert!(!shown.contains("hush") && !shown.contains('é'), "{shown}");
    }
}

/// Decisions K-Q1, K-J7 and K-F6.
#[test]
fn unknown_values_are_warnings() {
    let limited = GetNetworkInfo { limited_response: Some(Bool(2)), tail: &[] };
    assert_eq!(host(HostMessage::from(limited)), [(Warning, "limited_response")]);
    let lamps = LEDStatus { master_status: LedMode(4), slave_status: LedMode(9), tail: &[] };
    assert_eq!(host(HostMessage::from(lamps)), [(Warning, "master_status"), (Warning, "slave_status")]);
    assert_eq!(device(DeviceMessage::from(lamps)), [(Warning, "master_status"), (Warning, "slave_status")]);
    let (direction, start_time, tail) = (PlaybackDirection::REVERSE, Seconds(1.0), &[1][..]);
    let start = HostMessage::from(StartPlayback { direction, start_time, tail });
    assert_eq!(host(start), [(Warning, "direction"), (Warning, "start_time"), (Warning, "tail")]);
    let setup = SetupPlayback { direction, start_time: Seconds(-1.0), delay_return: Bool(3), tail: &[] };
    let wanted = [(Warning, "direction"), (Error, "start_time"), (Warning, "delay_return")];
    assert_eq!(host(HostMessage::from(setup)), wanted);
    assert_eq!(host(HostMessage::other(0x0080_0063, &[])), [(Warning, "message")]);
    assert_eq!(device(DeviceMessage::other(0x0025_0200, &[])), [(Warning, "message")]);
}

/// Safety decision 9, decisions K-B1, K-M1, K-M3, K-P7, K-P10 and K-Q1.
#[test]
fn messages_of_devices_are_checked_too() {
    let strange = NetworkInfo { dhcp: Bool(7), device_type: DeviceType(200), device_addr: 1, ..network_info() };
    let wanted = [(Warning, "dhcp"), (Warning, "device_type"), (Warning, "device_addr")];
    assert_eq!(device(DeviceMessage::from(strange)), wanted);

    let strange = DeviceInfo {
        device_type: DeviceType(1),
        device_addr: 1,
        playback_mode: PlaybackMode(3),
        playback_status: PlaybackState(14),
        network_id: 1,
        hardware_id: 1,
        device_password: Password(b"\xff"),
        aux_input_status: AuxInputs(0x20),
        delay_time_remaining: Seconds(-1.0),
        elapsed_time: Normalized(50.0),
        ..device_info()
    };
    let wanted = [
        (Warning, "device_type"),
        (Warning, "device_addr"),
        (Warning, "playback_mode"),
        (Warning, "playback_status"),
        (Warning, "network_id"),
        (Warning, "hardware_id"),
        (Warning, "device_password"),
        (Warning, "aux_input_status"),
        (Error, "delay_time_remaining"),
        (Warning, "elapsed_time"),
    ];
    assert_eq!(device(DeviceMessage::from(strange)), wanted);

    let entries = [
        entry(0),
        MotorEntry::new(
            MOTOR,
            Rotations(f32::NAN),
            Rotations(0.0),
            Rotations(0.0),
            SPEED,
            RotationsPerSecond(-1.0),
            ACCELERATION,
        ),
    ];
    let info = MotorInfo { more: false, motors: MotorInfos::New(&entries), tail: &[] };
    let wanted =
        [(Warning, "motor_count"), (Error, "motor_address"), (Error, "max_max_move_speed"), (Error, "position")];
    assert_eq!(device(DeviceMessage::from(info)), wanted);

    let presence = [MotorPresence::new(
        MotorAddress(11),
        Bool(2),
        MotorType(2),
        RotationsPerSecond(-1.0),
        SPEED,
        RotationsPerSecondSquared(-1.0),
    )];
    let status = MotorStatus { motors: Counted(&presence), tail: &[] };
    let wanted = [
        (Error, "motor_address"),
        (Warning, "online_status"),
        (Warning, "motor_type"),
        (Error, "max_max_setup_speed"),
        (Error, "max_max_acceleration"),
    ];
    assert_eq!(device(DeviceMessage::from(status)), wanted);

    let status = PlaybackStatus {
        playback_status: PlaybackState(99),
        elapsed_time: Normalized(-0.1),
        photo_count: Some(Photos(-1.0)),
        motors: &[MotorPlace::new(MotorAddress(0), Rotations(f32::NEG_INFINITY))],
        tail: &[],
    };
    let wanted = [
        (Warning, "playback_status"),
        (Warning, "elapsed_time"),
        (Error, "photo_count"),
        (Error, "motor_address"),
        (Error, "position"),
    ];
    assert_eq!(device(DeviceMessage::from(status)), wanted);

    let failed = |code, address| {
        let (error_code, motor_address) = (ErrorCode(code), MotorAddress(address));
        device(DeviceMessage::from(ErrorStatus { error_code, motor_address, tail: &[] }))
    };
    assert_eq!(failed(5, 0), [(Warning, "error_code")]);
    assert_eq!(failed(16, 0), [(Error, "motor_address")], "a fault belongs to a motor");

    let (motor_address, tail) = (MotorAddress(0), &[][..]);
    let position = MotorPosition { motor_address, position: Rotations(1.0), tail };
    assert_eq!(device(DeviceMessage::from(position)), [(Error, "motor_address")]);
    let calibrated = MotorCalibrated { motor_address, begin_position: None, end_position: Rotations(f32::NAN), tail };
    let wanted = [(Error, "motor_address"), (Error, "end_position")];
    assert_eq!(device(DeviceMessage::from(calibrated)), wanted);
    let guid = DeviceGUID { guid: Block16(&[1; 15]), tail };
    assert_eq!(device(DeviceMessage::from(guid)), [(Warning, "guid")]);
    assert_eq!(guid.to_bytes(), None);
    let echo = UnsupportedMessage { message: Rest(&[3]), tail };
    assert_eq!(device(DeviceMessage::from(echo)), [(Warning, "message")]);
    let inputs = AuxInputStatus { status: AuxInputs(0xe0), tail };
    assert_eq!(device(DeviceMessage::from(inputs)), [(Warning, "status")]);
}

/// Decisions K-J3 to K-J6, K-J10 and K-J11, safety decision 5.
#[test]
fn the_settings_of_a_move_are_checked() {
    assert_eq!(played(playback()), []);
    let both = Playback { loop_after_rapid_reverse: LoopCount(1), ..playback() };
    assert_eq!(played(both), [(Error, "loop_after_reverse")]);
    let looped = Playback { playback_mode: PlaybackMode::TIME_LAPSE_SMS, ..playback() };
    assert_eq!(played(looped), [(Error, "loop_after_reverse")]);
    let none = Playback { duration: Seconds(0.0), rapid_reverse_duration: Seconds(0.0), ..playback() };
    assert_eq!(played(none), [(Error, "duration")]);
    let negative = Playback { duration: Seconds(-1.0), rapid_reverse_duration: Seconds(-1.0), ..playback() };
    assert_eq!(played(negative), [(Error, "duration"), (Error, "rapid_reverse_duration")]);
    let rapid = Playback { rapid_reverse_duration: Seconds(5.0), ..playback() };
    assert_eq!(played(rapid), [(Warning, "rapid_reverse_duration")]);
    let unnamed = Playback { playback_mode: PlaybackMode(3), loop_after_reverse: LoopCount::NONE, ..playback() };
    assert_eq!(played(unnamed), [(Warning, "playback_mode")]);

    let delayed =
        |delay_mode, bits| played(Playback { delay_mode, delay_interval_bits: DelayInterval(bits), ..playback() });
    assert_eq!(delayed(DelayMode::UNTIL, 0x4ECA_A7E2), [(Warning, "delay_interval_bits")]);
    assert_eq!(delayed(DelayMode::INTERVAL, 0x4ECA_A7E2), []);
    assert_eq!(delayed(DelayMode::INTERVAL, 0x7fc0_0000), [(Error, "delay_interval_bits")]);
    assert_eq!(delayed(DelayMode::INTERVAL, (-1.0_f32).to_bits()), [(Error, "delay_interval_bits")]);
    assert_eq!(delayed(DelayMode(3), 0), [(Warning, "delay_mode")]);

    let home = |part| played(Playback { return_to_home_percent: Normalized(part), ..playback() });
    assert_eq!(
        (home(0.0), home(50.0)),
        (vec![(Warning, "return_to_home_percent")], vec![(Warning, "return_to_home_percent")])
    );
    assert_eq!(home(-0.5), [(Error, "return_to_home_percent"), (Warning, "return_to_home_percent")]);
    assert_eq!(home(f32::NAN), [(Error, "return_to_home_percent")]);

    let unsupported = Playback {
        camera_roll_enabled: Bool::TRUE,
        camera_roll_pre_delay: Seconds(1.0),
        camera_roll_post_delay: Seconds(1.0),
        flash_mark_enabled: Bool::TRUE,
        flash_mark_type: 1,
        flash_mark_post_delay: Seconds(1.0),
        use_external_trigger: Bool::TRUE,
        using_lanc: Bool::TRUE,
        ..playback()
    };
    let wanted = [
        "camera_roll_enabled",
        "flash_mark_enabled",
        "use_external_trigger",
        "using_lanc",
        "flash_mark_type",
        "camera_roll_pre_delay",
        "camera_roll_post_delay",
        "flash_mark_post_delay",
    ];
    assert_eq!(played(unsupported), wanted.map(|what| (Warning, what)));
}

/// Decisions K-J1, K-J8 and K-J9.
#[test]
fn blocks_that_do_not_make_a_move_are_errors() {
    let wanted = [(Error, "playback"), (Error, "time_lapse"), (Error, "axis")];
    assert_eq!(blocks(&[]), wanted);
    let (play, photos) = (Block::Playback(playback()), Block::TimeLapse(time_lapse()));
    let wanted = [(Error, "playback"), (Error, "time_lapse"), (Error, "axis")];
    assert_eq!(blocks(&[play, play, photos, photos, axis(0), axis(0)]), wanted);
    assert_eq!(segments(0, &[Block::other(3, &[])]), [(Warning, "block_id")]);

    let (first, second) = (segment(0, FIRST), segment(1, SECOND));
    assert_eq!(segments(2, &[second, first]), [], "in any order");
    assert_eq!(segments(1, &[first, second]), [(Error, "segment_count"), (Warning, "points")]);
    assert_eq!(segments(2, &[first, first]), [(Error, "segment_number"), (Warning, "points")]);
    assert_eq!(segments(1, &[first]), [(Warning, "points")], "the way ends before the move");
    assert_eq!(segments(1, &[segment(0, SECOND)]), [(Warning, "points")], "the way starts after the move");
    let alone = blocks(&[play, photos, first]);
    assert_eq!(alone, [(Error, "axis"), (Error, "segment")]);
    let nobody = Axis { motor_address: MotorAddress(0), segment_count: 0, tail: &[] };
    assert_eq!(blocks(&[play, photos, Block::Axis(nobody)]), [(Error, "motor_address")]);
    let shutter = TimeLapse { exposure: Seconds(-1.0), delay: Seconds(-1.0), not_used: 1, ..time_lapse() };
    let lapse = Playback {
        playback_mode: PlaybackMode::TIME_LAPSE_CONTINUOUS,
        loop_after_reverse: LoopCount::NONE,
        ..playback()
    };
    let wanted = [(Error, "delay"), (Error, "exposure"), (Warning, "not_used")];
    assert_eq!(blocks(&[Block::Playback(lapse), Block::TimeLapse(shutter), axis(0)]), wanted);
}

/// Decision K-J8.
#[test]
fn curves_advance_in_time_and_join() {
    let one = |points| segments(1, &[segment(0, points)]);
    assert_eq!(one([(0.0, 0.0), (0.3, 0.3), (0.6, 0.6), (1.0, 1.0)]), []);
    assert_eq!(one([(0.0, 0.0), (0.6, 0.3), (0.3, 0.6), (1.0, 1.0)]), [(Error, "points")], "time runs backward");
    assert_eq!(one([(0.0, 0.0), (0.0, 0.3), (0.0, 0.6), (0.0, 1.0)]), [(Error, "points"), (Warning, "points")]);
    assert_eq!(one([(0.0, 0.0), (0.3, -0.3), (0.6, 1.6), (1.0, 1.0)]), [(Warning, "points")]);
    assert_eq!(one([(0.0, -0.1), (0.3, 0.3), (0.6, 0.6), (1.0, 1.0)]), [(Error, "points")]);
    assert_eq!(one([(0.0, 0.0), (0.3, 0.3), (0.6, 0.6), (1.5, 1.0)]), [(Error, "points"), (Warning, "points")]);
    let nan = one([(0.0, 0.0), (0.3, 0.3), (0.6, 0.6), (1.0, f32::NAN)]);
    assert_eq!(nan, [(Error, "points"), (Error, "points")]);

    let apart = |at| {
        let mut second = SECOND;
        second[0] = at;
        segments(2, &[segment(0, FIRST), segment(1, second)])
    };
    assert_eq!(apart((0.500_05, 0.499_95)), []);
    assert_eq!(apart((0.5, 0.502)), [(Error, "points")]);
    assert_eq!(apart((0.502, 0.5)), [(Error, "points")]);
}
