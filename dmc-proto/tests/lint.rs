//! Law 14 and the findings of lint: each rule of the decisions, and no finding in legal messages.

mod recorded;

use dmc_proto::lint::Context;
use dmc_proto::message::{
    Acceleration, Ack, AckCode, BloopOutputs, BlurPercent, CameraFlags, Capabilities, Coordinate, Degrees, Direction,
    Dmx, DmxChannel, FrameNumber, FramesPerSecond, GioCam, GioIn, GioInRequest, GioOut, HardStop, HardwareLimitSet, Hi,
    HiRequest, JogSpeed, LineAxis, LineSpeed, Milliseconds, Motor, MotorConfigure, MotorFlags, MotorGetPosition,
    MotorJog, MotorMove, MotorMoving, MotorPair, MotorPositions, MotorResetPosition, MotorSetLimits, MotorSetSpeed,
    MotorStatus, MotorStatusRequest, MotorStop, MotorStopAll, Motors, MoveTime, Name, RigMotor, RtEnd, RtGo, RtJogAll,
    RtPositionFrame, RtRunMove, RtShootFrame, RtShootFrame2, RtStopLoop, RtUploadMoveAxis, RtUploadMoveBegin,
    RtUploadMoveDmx, RtUploadMoveEnd, RtUploadMoveTriggers, RunFlags, Scaled, ShortMilliseconds, Speed, StartIndex,
    Steps, StepsPerUnit, StopFlags, StopReason, SwingPan, TriggerPair, Triggers, VirtAimPoint, VirtConfig,
    VirtGetPosition, VirtJog, VirtJogOnLine, VirtMove, VirtPositions, VirtStop, VirtualMotor, VirtualPosition,
};
use dmc_proto::{DeviceMessage, EncodeError, Frame, HostMessage, MessageId, MessageType};
use motion_core::lint::{Lint, Lints, Severity};
use motion_core::wire::{Bool, Message, Messages};
use zerocopy::little_endian::I32;

/// Greeting of a rig with every capability and eight motors.
fn hi() -> Hi<'static> {
    Hi {
        name: Name::new("test rig").unwrap(),
        fw_major: 1,
        fw_minor: 2,
        fw_rev: 3,
        motor_count: 8,
        dmx_count: 100,
        gio_out_count: 4,
        gio_in_count: 4,
        hw_limit_count: 2,
        upload_frame_count: 1000,
        capabilities: Capabilities(0x07ff),
        protocol_version: Some(2),
        tail: &[],
    }
}

fn run_move() -> RtRunMove<'static> {
    RtRunMove {
        fps_x1000: FramesPerSecond(Scaled(23_976)),
        start_frame: FrameNumber(1),
        end_frame: FrameNumber(100),
        pre_roll_ms: Milliseconds(2000),
        post_roll_ms: Milliseconds(1000),
        sync_dmx: Bool::TRUE,
        bloop_location: BloopOutputs::LOGIC_OUT,
        bloop_dmx_channel: DmxChannel(100),
        bloop_ms: ShortMilliseconds(100),
        flags: Some(RunFlags::LOOP | RunFlags::CAMERA_EVERY_FRAME),
        open_angle: Some(Degrees(90)),
        close_angle: Some(Degrees(270)),
        tail: &[],
    }
}

fn limits() -> MotorSetLimits<'static> {
    MotorSetLimits {
        motor: Motor(5),
        lower_enable: Bool::TRUE,
        lower: Steps(-100),
        upper_enable: Bool::TRUE,
        upper: Steps(100),
        hw_set: HardwareLimitSet(0x82),
        tail: &[],
    }
}

const POSITIONS: [I32; 8] = [I32::ZERO; 8];

/// Every message of the host, with legal values.
fn host_messages<'a>(motors: &'a [MotorPair], pairs: &'a [TriggerPair]) -> Vec<HostMessage<'a>> {
    vec![
        HiRequest::default().into(),
        HostMessage::from(Dmx { ramp: Bool::TRUE, start_channel: DmxChannel(98), values: &[0, 127, 255], tail: &[] }),
        HostMessage::from(GioOut { triggers: Triggers(0xf), tail: &[] }),
        GioInRequest::default().into(),
        HostMessage::from(GioCam { flags: CameraFlags::SHUTTER | CameraFlags::METER, tail: &[] }),
        MotorStatusRequest::default().into(),
        HostMessage::from(MotorMove { motor: Motor(1), position: Steps(i32::MIN), tail: &[] }),
        HostMessage::from(MotorStop { motor: Motor(8), tail: &[] }),
        HostMessage::from(MotorStopAll { flags: Some(StopFlags::SILENT), tail: &[] }),
        MotorGetPosition::default().into(),
        HostMessage::from(MotorResetPosition { motor: Motor(1), position: Steps(0), tail: &[] }),
        HostMessage::from(MotorJog {
            motor: Motor(1),
            speed: JogSpeed::SLOWEST,
            destination: Steps(i32::MAX),
            tail: &[],
        }),
        HostMessage::from(MotorConfigure {
            motor: Motor(1),
            flags: MotorFlags::ENABLED | MotorFlags::COUPLE,
            tail: &[],
        }),
        HostMessage::from(MotorSetSpeed {
            motor: Motor(1),
            max_velocity: Speed(5000),
            max_accel: Acceleration(20_000),
            tail: &[],
        }),
        HostMessage::from(limits()),
        HostMessage::from(upload(-10, 989)),
        HostMessage::from(RtUploadMoveAxis {
            motor: Motor(1),
            start_index: StartIndex::new(992, true).unwrap(),
            positions: &POSITIONS,
            tail: &[],
        }),
        HostMessage::from(RtUploadMoveDmx {
            channel: DmxChannel(100),
            start_index: StartIndex(0),
            levels: &[1, 2, 3],
            tail: &[],
        }),
        RtUploadMoveEnd::default().into(),
        HostMessage::from(RtUploadMoveTriggers { mask: Triggers(0xf), pairs, tail: &[] }),
        HostMessage::from(RtPositionFrame { frame: FrameNumber(-10), tail: &[] }),
        HostMessage::from(run_move()),
        HostMessage::from(RtShootFrame {
            frame: FrameNumber(5),
            direction: Direction::FORWARD,
            exposure_ms: Milliseconds(500),
            blur_x10: BlurPercent(Scaled(500)),
            motors,
            tail: &[],
        }),
        RtGo::default().into(),
        HostMessage::from(shoot_frame2(motors)),
        RtStopLoop::default().into(),
        HostMessage::from(RtJogAll { fps_x1000: FramesPerSecond(Scaled(1)), destination: FrameNumber(1), tail: &[] }),
        HostMessage::VirtConfig(VirtConfig::SwingPan(swing_pan(8))),
        HostMessage::from(VirtMove {
            virtual_motor: VirtualMotor::TRACK,
            position_x1e5: VirtualPosition(Scaled(i32::MIN)),
            tail: &[],
        }),
        HostMessage::from(VirtStop { virtual_motor: VirtualMotor::ROLL, tail: &[] }),
        HostMessage::from(virt_jog(JogSpeed::FULL)),
        VirtGetPosition::default().into(),
        HostMessage::from(line(-10_000)),
        HostMessage::VirtAimPoint(AIM),
    ]
}

const AIM: VirtAimPoint<'_> = VirtAimPoint {
    enable: Bool::TRUE,
    aim_x: Coordinate(Scaled(-1234)),
    aim_y: Coordinate(Scaled(0)),
    aim_z: Coordinate(Scaled(i32::MAX)),
    tail: &[],
};

fn swing_pan(motor: u32) -> SwingPan<'static> {
    let (swing_motor, pan_motor) = (RigMotor(0), RigMotor(motor));
    SwingPan { swing_motor, swing_spu: StepsPerUnit(0), pan_motor, pan_spu: StepsPerUnit(1000), tail: &[] }
}

fn virt_jog(speed: JogSpeed) -> VirtJog<'static> {
    VirtJog { virtual_motor: VirtualMotor::PAN, speed, destination: Steps(i32::MAX), tail: &[] }
}

fn line(speed: i16) -> VirtJogOnLine<'static> {
    VirtJogOnLine { axis: LineAxis::Z, speed: LineSpeed(Scaled(speed)), tail: &[] }
}

fn upload(start: i32, end: i32) -> RtUploadMoveBegin<'static> {
    RtUploadMoveBegin { start_frame: FrameNumber(start), end_frame: FrameNumber(end), tail: &[] }
}

fn shoot_frame2(motors: &[MotorPair]) -> RtShootFrame2<'_> {
    RtShootFrame2 {
        frame: FrameNumber(5),
        exposure_ms: Milliseconds(500),
        open_angle: Degrees(0),
        close_angle: Degrees(360),
        motors,
        tail: &[],
    }
}

/// Every message of the device, with legal values.
fn device_messages() -> Vec<DeviceMessage<'static>> {
    vec![
        DeviceMessage::from(hi()),
        DeviceMessage::from(GioIn { triggers: Triggers(0xf), tail: &[] }),
        DeviceMessage::from(MotorStatus { motor_status: Motors(0x81), dmx_status: Bool::FALSE, tail: &[] }),
        DeviceMessage::from(MotorMoving { moving: Bool::TRUE, tail: &[] }),
        DeviceMessage::from(MotorPositions { move_time: MoveTime(Scaled(-500)), positions: &POSITIONS, tail: &[] }),
        DeviceMessage::from(HardStop { reason: StopReason::UPPER_LIMIT, motor: Some(Motor(8)), tail: &[] }),
        RtGo::default().into(),
        RtEnd::default().into(),
        DeviceMessage::from(VirtPositions {
            track: VirtualPosition(Scaled(1)),
            ew: VirtualPosition(Scaled(-1)),
            ns: VirtualPosition(Scaled(0)),
            pan: VirtualPosition(Scaled(i32::MAX)),
            tilt: VirtualPosition(Scaled(0)),
            roll: VirtualPosition(Scaled(0)),
            aim_enabled: Some(Bool::TRUE),
            aim: Some([Coordinate(Scaled(5)); 3]),
            tail: &[],
        }),
        DeviceMessage::VirtAimPoint(AIM),
        DeviceMessage::Ack(Ack::new(MessageType(0x0031), AckCode::OK)),
    ]
}

/// Law 14.
#[test]
fn lint_is_silent_on_legal_messages() {
    let motors = [MotorPair::new(Motor(1), Steps(0), Steps(9)), MotorPair::new(Motor(8), Steps(-1), Steps(9))];
    let pairs = [TriggerPair::new(0, Triggers(1)), TriggerPair::new(999, Triggers(8))];
    let mut out = [0; 2048];
    for context in [Context::default(), Context::of(hi())] {
        let host = host_messages(&motors, &pairs);
        assert_eq!(host.iter().map(Messages::name).collect::<Vec<_>>(), names(HostMessage::ALL));
        for message in host {
            assert_eq!(message.lint(&context), Lints::new(), "{message}");
            assert_eq!(message.refusal(&context), None, "{message}");
            let len = message.encoded_len();
            assert_eq!(message.encode_checked(MessageId(1), &context, &mut out), Ok(len), "{message}");
        }
        let device = device_messages();
        assert_eq!(device.iter().map(Messages::name).collect::<Vec<_>>(), names(DeviceMessage::ALL));
        for message in device {
            assert_eq!(message.lint(&context), Lints::new(), "{message}");
            let len = message.encoded_len();
            assert_eq!(message.encode_checked(MessageId::UNSOLICITED, &context, &mut out), Ok(len), "{message}");
        }
    }
}

fn names(all: &[motion_core::wire::Kind]) -> Vec<&'static str> {
    all.iter().map(|kind| kind.name).collect()
}

/// Findings in the vectors without knowledge of the peer. Only the vectors that are wrong on purpose have any.
#[test]
fn lint_finds_only_the_vectors_that_are_wrong_on_purpose() {
    let mut found = Vec::new();
    for (vector, wire) in recorded::vectors() {
        let Ok(frame) = Frame::decode(&wire) else { continue };
        let lints = if vector["direction"] == "request" {
            match HostMessage::decode(&frame).unwrap() {
                // Types without a meaning; `a_message_that_no_device_takes_is_not_sent` covers them.
                HostMessage::Other(_) => continue,
                message => message.lint(&Context::default()),
            }
        } else {
            DeviceMessage::decode(&frame).unwrap().lint(&Context::default())
        };
        found.extend(
            lints.into_iter().map(|lint| format!("{}: {}: {lint}", vector["name"].as_str().unwrap(), lint.severity)),
        );
    }
    assert_eq!(found, WRONG_ON_PURPOSE);
}

const WRONG_ON_PURPOSE: &[&str] = &[
    "ack_err_aim_cod_undocumented_on_motor_jog: error: response_code: not in the specification; send ERR_RANGE",
    "ack_unknown_on_motor_jog: warning: response_code: 30583 has no meaning in the specification",
    "hi_response_max_counts: warning: capabilities: reserved bits 0xfffff800 are set",
    "hi_response_max_counts: warning: protocol_version: 65535 has no meaning in the specification",
    "dmx_no_values_degenerate: warning: values: empty; nothing happens",
    "hard_stop_unknown_reason: warning: reason: 3 has no meaning in the specification",
    "rt_run_move_31_stills_no_angles: warning: open_angle: \
     the shutter does not open before it closes; the device uses its own angles",
    "virt_config_type3_opaque: warning: type: its layout is not published",
    "virt_aim_point_err_aim_cod: error: response_code: not in the specification; send ERR_RANGE",
    "marker_inside_payload: error: motor: 68 is not in 1 to 32",
];

/// First finding and its severity.
fn first(lints: Lints) -> (Severity, String) {
    let lint: Lint = lints.into_iter().next().expect("something is found");
    (lint.severity, lint.to_string())
}

fn host(message: HostMessage<'_>, hi: Hi<'_>) -> (Severity, String, Option<AckCode>) {
    let context = Context::of(hi);
    let (severity, text) = first(message.lint(&context));
    (severity, text, message.refusal(&context))
}

fn device(message: DeviceMessage<'_>) -> (Severity, String) {
    first(message.lint(&Context::of(hi())))
}

fn error(text: &str, code: AckCode) -> (Severity, String, Option<AckCode>) {
    (Severity::Error, text.into(), Some(code))
}

fn warning(text: &str) -> (Severity, String, Option<AckCode>) {
    (Severity::Warning, text.into(), None)
}

#[test]
fn a_motor_that_the_device_lacks_is_refused() {
    for motor in [0, 9, 255] {
        let text = format!("motor: {motor} is not in 1 to 8");
        let stop = HostMessage::from(MotorStop { motor: Motor(motor), tail: &[] });
        assert_eq!(host(stop, hi()), error(&text, AckCode::ERR_RANGE));
        // Unpatched firmware of the vendor writes beyond its memory here (decision D-25).
        let motors = [MotorPair::new(Motor(motor), Steps(0), Steps(0))];
        assert_eq!(host(shoot(&motors, &[]), hi()), error(&text, AckCode::ERR_RANGE));
    }
    let many = [MotorPair::new(Motor(1), Steps(0), Steps(0)); 33];
    assert_eq!(host(shoot(&many, &[]), hi()), error("motors: 33 is not in 0 to 32", AckCode::ERR_RANGE));
    let cut_off = error("motors: the last entry is cut off", AckCode::ERR_GENERAL);
    assert_eq!(host(shoot(&many[..1], &[1, 2]), hi()), cut_off);
}

/// Decision D-89.
#[test]
fn a_section_whose_last_entry_is_cut_off_is_refused() {
    let positions = &[I32::ZERO];
    let axis = RtUploadMoveAxis { motor: Motor(1), positions, tail: &[1, 2], ..RtUploadMoveAxis::default() };
    let cut_off = error("positions: the last entry is cut off", AckCode::ERR_GENERAL);
    assert_eq!(host(axis.into(), hi()), cut_off);
    let triggers = RtUploadMoveTriggers { tail: &[1, 2, 3], ..RtUploadMoveTriggers::default() };
    assert_eq!(host(triggers.into(), hi()), error("pairs: the last entry is cut off", AckCode::ERR_GENERAL));
}

/// Decision D-28.
#[test]
fn angles_of_a_run_count_only_if_the_camera_is_triggered_at_every_frame() {
    let wide = |flags| RtRunMove { flags: Some(flags), open_angle: Some(Degrees(361)), ..run_move() };
    let used = error("open_angle: 361 is not in 0 to 360", AckCode::ERR_RANGE);
    assert_eq!(host(wide(RunFlags::CAMERA_EVERY_FRAME).into(), hi()), used);
    let unused = warning("open_angle: an angle of more than 360 degrees, which is not used");
    assert_eq!(host(wide(RunFlags(0)).into(), hi()), unused);
}

fn shoot<'a>(motors: &'a [MotorPair], tail: &'a [u8]) -> HostMessage<'a> {
    HostMessage::from(RtShootFrame {
        frame: FrameNumber(5),
        direction: Direction::BACKWARD,
        exposure_ms: Milliseconds(500),
        blur_x10: BlurPercent(Scaled(500)),
        motors,
        tail,
    })
}

/// Decision D-2: the capability that a message needs, and the answer of a device without it. Stops are never refused.
#[test]
fn a_device_without_the_capability_says_unsupported() {
    let motors = [MotorPair::new(Motor(1), Steps(0), Steps(9))];
    let counts = Hi { motor_count: 0, dmx_count: 0, gio_out_count: 0, gio_in_count: 0, ..hi() };
    let bare = Hi { capabilities: Capabilities(0), ..counts };
    for message in host_messages(&motors, &[]) {
        let context = Context::of(bare);
        let found = message.lint(&context).first_error().map(|lint| lint.to_string());
        match message {
            HostMessage::Hi(_) | HostMessage::GioCam(_) | HostMessage::MotorStopAll(_) | HostMessage::VirtStop(_) => {
                assert_eq!(found, None, "{message}");
            }
            HostMessage::MotorStop(_) => assert_eq!(message.refusal(&context), Some(AckCode::ERR_RANGE)),
            _ => {
                assert!(found.unwrap().ends_with(": the device has none"), "{message}");
                assert_eq!(message.refusal(&context), Some(AckCode::ERR_UNSUPPORTED), "{message}");
            }
        }
    }
    let one = |capabilities| Hi { capabilities, ..hi() };
    let run = HostMessage::from(run_move());
    let unsupported = error("flags: the device has none", AckCode::ERR_UNSUPPORTED);
    assert_eq!(host(run, one(Capabilities::REAL_TIME | Capabilities::LOOP)), unsupported);
    assert_eq!(host(run, one(Capabilities::REAL_TIME | Capabilities::CAMERA_TRIGGER)), unsupported);
    let couple = MotorConfigure { motor: Motor(1), flags: MotorFlags::COUPLE_REVERSE, tail: &[] };
    assert_eq!(host(HostMessage::MotorConfigure(couple), one(Capabilities::REAL_TIME)), unsupported);
    let swing = HostMessage::VirtConfig(VirtConfig::SwingPan(swing_pan(1)));
    let other_rig = error("type: the device has none", AckCode::ERR_UNSUPPORTED);
    assert_eq!(host(swing, one(Capabilities::BOOM_SWING_TRACK)), other_rig);
    assert_eq!(swing.lint(&Context::of(one(Capabilities::SWING_PAN))), Lints::new());
    let triggers = HostMessage::from(RtUploadMoveTriggers { mask: Triggers(1), pairs: &[], tail: &[] });
    let old = error("protocol_version: the device has an older version of the protocol", AckCode::ERR_UNSUPPORTED);
    assert_eq!(host(triggers, Hi { protocol_version: None, ..hi() }), old);
    assert_eq!(host(HostMessage::VirtAimPoint(AIM), Hi { protocol_version: Some(1), ..hi() }), old);
    let go = HostMessage::from(RtGo::default());
    for capability in [Capabilities::REAL_TIME, Capabilities::SHOOT_FRAME, Capabilities::SHOOT_FRAME2] {
        assert_eq!(go.lint(&Context::of(one(capability))), Lints::new(), "one capability is enough");
    }
}

#[test]
fn a_value_out_of_range_is_refused_with_the_range() {
    let range = |message, text: &str| assert_eq!(host(message, hi()), error(text, AckCode::ERR_RANGE));
    let jog = |speed| MotorJog { motor: Motor(1), speed: JogSpeed(Scaled(speed)), destination: Steps(0), tail: &[] };
    range(HostMessage::from(jog(0)), "speed: 0 is not in 1 to 10000");
    range(HostMessage::from(jog(10_001)), "speed: 10001 is not in 1 to 10000");
    let switches = MotorSetLimits { hw_set: HardwareLimitSet(3), ..limits() };
    range(HostMessage::MotorSetLimits(switches), "hw_set: 3 is not in 0 to 2");
    let angle = RtRunMove { close_angle: Some(Degrees(361)), ..run_move() };
    range(HostMessage::RtRunMove(angle), "close_angle: 361 is not in 0 to 360");
    let bloop = RtRunMove { bloop_dmx_channel: DmxChannel(101), ..run_move() };
    range(HostMessage::RtRunMove(bloop), "bloop_dmx_channel: 101 is not in 0 to 100");
    let frozen = RtRunMove { fps_x1000: FramesPerSecond(Scaled(0)), ..run_move() };
    range(HostMessage::RtRunMove(frozen), "fps_x1000: 0 is not in 1 to 4294967295");
    let beyond = RtUploadMoveAxis { motor: Motor(1), start_index: StartIndex(993), positions: &POSITIONS, tail: &[] };
    range(HostMessage::RtUploadMoveAxis(beyond), "start_index: 993 is not in 0 to 992");
    range(HostMessage::from(upload(5, 4)), "end_frame: 4 is not in 5 to 1004");
    range(HostMessage::from(upload(-10, 990)), "end_frame: 990 is not in -10 to 989");
    let level =
        |channel| RtUploadMoveDmx { channel: DmxChannel(channel), start_index: StartIndex(0), levels: &[1], tail: &[] };
    range(HostMessage::from(level(0)), "channel: 0 is not in 1 to 100");
    range(HostMessage::from(level(101)), "channel: 101 is not in 1 to 100");
    let late = [TriggerPair::new(1000, Triggers(1))];
    let late = RtUploadMoveTriggers { mask: Triggers(1), pairs: &late, tail: &[] };
    range(HostMessage::RtUploadMoveTriggers(late), "frame: 1000 is not in 0 to 999");
    let lights = |channel, values| Dmx { ramp: Bool::FALSE, start_channel: DmxChannel(channel), values, tail: &[] };
    range(HostMessage::from(lights(0, &[1])), "start_channel: 0 is not in 1 to 100");
    range(HostMessage::from(lights(99, &[1, 2, 3])), "values: 3 is not in 0 to 2");
    let wide = RtShootFrame2 { open_angle: Degrees(361), ..shoot_frame2(&[]) };
    range(HostMessage::RtShootFrame2(wide), "open_angle: 361 is not in 0 to 360");
    range(HostMessage::VirtConfig(VirtConfig::SwingPan(swing_pan(9))), "pan_motor: 9 is not in 0 to 8");
    let Ok(VirtConfig::BoomSwingTrack(boom)) = VirtConfig::decode(&[1; 93]) else { panic!("type 1") };
    let boom = HostMessage::VirtConfig(VirtConfig::BoomSwingTrack(boom));
    range(boom, "boom_motor: 16843009 is not in 0 to 8");
    assert_eq!(boom.lint(&Context::of(hi())).as_slice().len(), 6, "each motor is checked");
    range(HostMessage::VirtJog(virt_jog(JogSpeed(Scaled(0)))), "speed: 0 is not in 1 to 10000");
    range(HostMessage::from(line(-10_001)), "speed: -10001 is not in -10000 to 10000");
    range(HostMessage::from(line(i16::MIN)), "speed: -32768 is not in -10000 to 10000");
    let still = error("speed: 0 is no speed; stop with VirtStop", AckCode::ERR_GENERAL);
    assert_eq!(host(HostMessage::from(line(0)), hi()), still);
    let jog = RtJogAll { fps_x1000: FramesPerSecond(Scaled(0)), destination: FrameNumber(1), tail: &[] };
    range(HostMessage::RtJogAll(jog), "fps_x1000: 0 is not in 1 to 4294967295");
}

/// Safety decision 8.
#[test]
fn limits_are_compared_only_if_both_are_enabled() {
    let crossed = MotorSetLimits { lower: Steps(101), ..limits() };
    let refused = error("lower: 101 is not in -2147483648 to 100", AckCode::ERR_RANGE);
    assert_eq!(host(HostMessage::MotorSetLimits(crossed), hi()), refused);
    for half in [
        MotorSetLimits { lower_enable: Bool::FALSE, ..crossed },
        MotorSetLimits { upper_enable: Bool::FALSE, ..crossed },
        MotorSetLimits { lower: Steps(100), ..crossed },
    ] {
        assert_eq!(HostMessage::MotorSetLimits(half).lint(&Context::of(hi())), Lints::new());
    }
}

#[test]
fn an_unwise_message_is_a_warning_and_is_not_refused() {
    let unwise = |message, text: &str| assert_eq!(host(message, hi()), warning(text));
    let speed = |velocity, accel| {
        let (max_velocity, max_accel) = (Speed(velocity), Acceleration(accel));
        HostMessage::from(MotorSetSpeed { motor: Motor(1), max_velocity, max_accel, tail: &[] })
    };
    unwise(speed(0, 1), "max_velocity: 0 is no speed; the vendor's firmware takes 10 steps/s");
    unwise(speed(1, 0), "max_accel: 0 is no acceleration; the vendor's firmware takes half the speed");
    let twice = RtRunMove { flags: Some(RunFlags::PING_PONG | RunFlags::LOOP), ..run_move() };
    unwise(HostMessage::RtRunMove(twice), "flags: ping-pong and loop at once; ping-pong wins");
    let nothing = RtUploadMoveAxis { motor: Motor(1), start_index: StartIndex(5), positions: &[], tail: &[] };
    unwise(
        HostMessage::RtUploadMoveAxis(nothing),
        "start_index: neither a value nor the last section: nothing happens",
    );
    let three = RtRunMove { sync_dmx: Bool(3), ..run_move() };
    unwise(HostMessage::RtRunMove(three), "sync_dmx: neither 0 nor 1; it counts as 1");
    let bits = MotorStopAll { flags: Some(StopFlags(6)), tail: &[] };
    unwise(HostMessage::MotorStopAll(bits), "flags: reserved bits 0x6 are set");
    let tail = MotorStopAll { flags: Some(StopFlags(1)), tail: &[0] };
    unwise(HostMessage::MotorStopAll(tail), "tail: 1 bytes after the known fields");

    let outputs = GioOut { triggers: Triggers(0x1f), tail: &[] };
    unwise(HostMessage::GioOut(outputs), "triggers: reserved bits 0x10 are set");
    let dark = Dmx { ramp: Bool::FALSE, start_channel: DmxChannel(1), values: &[], tail: &[] };
    unwise(HostMessage::Dmx(dark), "values: empty; nothing happens");
    let blink = RtShootFrame2 { exposure_ms: Milliseconds(0), ..shoot_frame2(&[]) };
    unwise(HostMessage::RtShootFrame2(blink), "exposure_ms: 0 is no exposure; the vendor's firmware takes 1000 ms");
    let dark = RtShootFrame { exposure_ms: Milliseconds(0), ..RtShootFrame::default() };
    let dark = RtShootFrame { direction: Direction::BACKWARD, ..dark };
    unwise(HostMessage::RtShootFrame(dark), "exposure_ms: 0 is no exposure; the vendor's firmware takes 1000 ms");
    let blur = RtShootFrame { exposure_ms: Milliseconds(1), blur_x10: BlurPercent(Scaled(1001)), ..dark };
    unwise(HostMessage::RtShootFrame(blur), "blur_x10: more than 100 %");
    let jump = RtRunMove { pre_roll_ms: Milliseconds(0), ..run_move() };
    let text = "pre_roll_ms: 0 leaves no time to reach the speed; the vendor's firmware divides by it";
    unwise(HostMessage::RtRunMove(jump), text);
    let triggers = |values| [TriggerPair::new(5, Triggers(values))];
    let off = RtUploadMoveTriggers { mask: Triggers(3), pairs: &triggers(0), tail: &[] };
    unwise(HostMessage::RtUploadMoveTriggers(off), "values: no output is on, as at frames that are not named");
    let masked = RtUploadMoveTriggers { mask: Triggers(3), pairs: &triggers(5), tail: &[] };
    unwise(HostMessage::RtUploadMoveTriggers(masked), "values: reserved bits 0x4 are set");

    let marks = |location| {
        let (bloop_location, bloop_dmx_channel) = (BloopOutputs(location), DmxChannel(0));
        HostMessage::from(RtRunMove { bloop_location, bloop_dmx_channel, ..run_move() })
    };
    let bare = Hi { gio_out_count: 1, ..hi() };
    assert_eq!(host(marks(2), bare), warning("bloop_location: an output that the device does not have"));
    assert_eq!(marks(1).lint(&Context::of(bare)), Lints::new());
    let dark = Hi { dmx_count: 0, ..hi() };
    assert_eq!(host(marks(4), dark), warning("bloop_location: a DMX channel, and the device has none"));
    let uses = |motor, flags| HostMessage::from(MotorConfigure { motor: Motor(motor), flags, tail: &[] });
    unwise(uses(8, MotorFlags::COUPLE), "flags: coupled with the next motor, and there is none");
    let both = "flags: coupled in both directions at once; the vendor's firmware takes the opposite one";
    unwise(uses(1, MotorFlags::COUPLE | MotorFlags::COUPLE_REVERSE), both);
    let real = Hi { capabilities: Capabilities::REAL_TIME, ..hi() };
    let alone = warning("flags: part of a virtual motor, and the device has none");
    assert_eq!(host(uses(1, MotorFlags::VIRTUAL), real), alone);

    let half = HostMessage::VirtJog(virt_jog(JogSpeed(Scaled(5000))));
    unwise(half, "speed: neither 1 nor 10000, the only speeds that are sent today");
    let levels = RtUploadMoveDmx { channel: DmxChannel(1), ..RtUploadMoveDmx::default() };
    let no_lights = error("dmx_count: the device has none", AckCode::ERR_UNSUPPORTED);
    assert_eq!(host(levels.into(), Hi { dmx_count: 0, ..hi() }), no_lights);
    let stop = VirtStop { virtual_motor: VirtualMotor(7), tail: &[] };
    unwise(HostMessage::VirtStop(stop), "virtual_motor: 7 has no meaning in the specification");
    let opaque = |kind| HostMessage::VirtConfig(VirtConfig::decode(kind).unwrap());
    unwise(opaque(&[4, 1]), "type: its layout is not published");

    // Decision D-23: older devices expect shorter messages.
    let plain = Hi { capabilities: Capabilities::REAL_TIME, ..hi() };
    let quiet = RtRunMove { flags: Some(RunFlags(0)), open_angle: None, close_angle: None, ..run_move() };
    let shorter = warning("flags: the device expects a shorter message, without flags");
    assert_eq!(host(HostMessage::RtRunMove(quiet), plain), shorter);
    let loops = Hi { capabilities: Capabilities::REAL_TIME | Capabilities::LOOP, ..hi() };
    let angled = RtRunMove { flags: Some(RunFlags::LOOP), ..run_move() };
    let shorter = warning("open_angle: the device expects a shorter message, without angles");
    assert_eq!(host(HostMessage::RtRunMove(angled), loops), shorter);
}

/// Decisions D-5, D-10, D-11 and D-13.
#[test]
fn a_message_that_no_device_takes_is_not_sent() {
    let context = Context::default();
    let stop = HostMessage::from(MotorStop { motor: Motor(1), tail: &[] });
    let mut out = [0; 64];
    let refused = stop.encode_checked(MessageId(0), &context, &mut out).map_err(|error| error.to_string());
    assert_eq!(refused, Err("id: 0 is not in 1 to 4294967295".into()));
    let ack = HostMessage::other(0x8032, &[0x10, 0]);
    assert_eq!(first(ack.lint(&context)).0, Severity::Error);
    assert_eq!(ack.refusal(&context), None, "two peers that answer each other would never end");
    let vendor = HostMessage::other(0x0300, &[]);
    assert_eq!(
        first(vendor.lint(&context)),
        (Severity::Warning, "type: 768 has no meaning in the specification".into())
    );
    assert_eq!(vendor.refusal(&context), Some(AckCode::ERR_UNSUPPORTED));
    assert_eq!(first(HostMessage::other(0x0400, &[]).lint(&context)).0, Severity::Error);

    let positions = [I32::ZERO; 258];
    let section = |count: usize| {
        let positions = &positions[..count];
        HostMessage::from(RtUploadMoveAxis { motor: Motor(1), start_index: StartIndex(0), positions, tail: &[] })
    };
    assert_eq!(section(257).lint(&context), Lints::new());
    let long = section(258);
    assert_eq!(first(long.lint(&context)).1, "data: 1037 is not in 0 to 1036");
    let Err(EncodeError::Refused(lint)) = long.encode_checked(MessageId(1), &context, &mut [0; 2048]) else {
        panic!("sent in spite of the error")
    };
    assert_eq!(lint.what, "data");
    let mut roomy = Context::default();
    roomy.max_data = 2036;
    assert_eq!(long.lint(&roomy), Lints::new());
}

#[test]
fn messages_of_a_device_match_its_greeting() {
    let wrong = |message, text: &str| assert_eq!(device(message), (Severity::Error, text.into()));
    let odd = |message, text: &str| assert_eq!(device(message), (Severity::Warning, text.into()));
    wrong(DeviceMessage::from(Hi { motor_count: 33, ..hi() }), "motor_count: 33 is not in 0 to 32");
    wrong(DeviceMessage::from(Hi { dmx_count: 513, ..hi() }), "dmx_count: 513 is not in 0 to 512");
    odd(
        DeviceMessage::from(Hi { protocol_version: Some(3), ..hi() }),
        "protocol_version: 3 has no meaning in the specification",
    );
    odd(DeviceMessage::from(Hi { name: Name([0xff; 32]), ..hi() }), "name: is not UTF-8");
    let some = Hi { capabilities: Capabilities::BOOM_SWING_TRACK, ..hi() };
    let text = "capabilities: Dragonframe was seen to use virtual motors only if the device claims all four kinds";
    odd(DeviceMessage::Hi(some), text);

    let status = MotorStatus { motor_status: Motors(0x181), dmx_status: Bool::FALSE, tail: &[] };
    odd(DeviceMessage::MotorStatus(status), "motor_status: reserved bits 0x100 are set");
    let few = MotorPositions { move_time: MoveTime(Scaled(0)), positions: &POSITIONS[..7], tail: &[] };
    wrong(DeviceMessage::MotorGetPosition(few), "positions: 7 is not in 8 to 8");

    let inputs = GioIn { triggers: Triggers(0x10), tail: &[] };
    odd(DeviceMessage::GioIn(inputs), "triggers: reserved bits 0x10 are set");

    let blind = Context::of(Hi { capabilities: Capabilities::REAL_TIME, ..hi() });
    let aims = VirtPositions { aim_enabled: Some(Bool::TRUE), ..VirtPositions::default() };
    for message in [aims.into(), DeviceMessage::from(AIM)] {
        let (severity, text) = first(message.lint(&blind));
        assert_eq!(severity, Severity::Warning, "{message}");
        assert!(text.ends_with("the device does not claim that it can aim"), "{text}");
        assert_eq!(message.lint(&Context::of(hi())), Lints::new());
    }

    let stop = |reason, motor| DeviceMessage::from(HardStop { reason, motor, tail: &[] });
    wrong(stop(StopReason::UPPER_LIMIT, None), "motor: absent, although a limit belongs to a motor");
    wrong(stop(StopReason::LOWER_LIMIT, Some(Motor(9))), "motor: 9 is not in 1 to 8");
    odd(
        stop(StopReason::EMERGENCY_STOP, Some(Motor(1))),
        "motor: present, although an emergency stop concerns all motors",
    );
    assert_eq!(stop(StopReason::ENGINE_EXCEPTION, Some(Motor(1))).lint(&Context::of(hi())), Lints::new());

    let ack = |response_code, tail| DeviceMessage::from(Ack { of: MessageType(0x31), response_code, tail });
    wrong(ack(None, &[0x10]), "response_code: absent");
    wrong(ack(Some(AckCode::ERR_AIM_COD), &[]), "response_code: not in the specification; send ERR_RANGE");
    odd(ack(Some(AckCode::OK), &[0]), "tail: 1 bytes after the known fields");
    assert_eq!(
        ack(Some(AckCode::OK), &[0, 0]).lint(&Context::of(hi())),
        Lints::new(),
        "four bytes, as many devices send"
    );
    let Err(EncodeError::Refused(_)) = ack(None, &[]).encode_checked(MessageId(1), &Context::default(), &mut [0; 64])
    else {
        panic!("sent in spite of the error")
    };
}
