//! Law 14 and the findings of lint: silence on messages of the constructors, and findings in the others.

use hoot_proto::frame::{MAX_DATA, Selector, Table};
use hoot_proto::lint::Context;
use hoot_proto::message::*;
use hoot_proto::query::{AnyQuery, IntoReply, Profile};
use hoot_proto::{Address, DeviceMessage, EncodeError, Frame, HostMessage, Query};
use motion_core::fixed::Scaled;
use motion_core::lint::Severity;
use motion_core::wire::{Bool, Messages, PartKind};

/// Makes messages from names and fields. Messages in brackets are made by `new`.
macro_rules! messages {
    ($($name:ident $({ $($field:tt)* })? $(($($argument:expr),*))?;)*) => {
        vec![$(HostMessage::$name(messages!(@ $name $({ $($field)* })? $(($($argument),*))?))),*]
    };
    (@ $name:ident { $($field:tt)* }) => { $name { $($field)* } };
    (@ $name:ident ($($argument:expr),*)) => { $name::new($($argument),*).unwrap() };
    (@ $name:ident) => { $name::default() };
}

/// One message of each kind, made by its constructor or with legal values.
fn requests() -> Vec<HostMessage<'static>> {
    let (motor, yes, most) = (Motor::Three, Bool::TRUE, MAX_ARRIVING);
    let (ms, position, span) = (Milliseconds(most), Steps(i32::MIN), Span(most));
    let mut requests = messages! {
        Noop;
        Start {}; Pause {}; Stop {}; ToggleDebugLed {};
        SetTimingMaster { timing_master: yes };
        SetName { name: Name::new("Dolly").unwrap() };
        SetAddress(Address(2));
        SetCommonLine { common_line: CommonLine::SECOND };
        ReturnHome {};
        SetMaxStepRate { max_step_rate: StepRate(5000) };
        SetInputEdge { edge: Edge::CHANGE };
        SetAltModes { ring: AltMode::SET_END, tip: AltMode::OFF };
        SetManualMove { manual_move: yes };
        SetOutBeforeDelay { delay: ShortMilliseconds(u16::MAX) };
        SetOutAfterDelay { delay: ShortMilliseconds(0) };
        SetOutBeforeTime { time: ShortMilliseconds(u16::MAX) };
        SetOutAfterTime { time: ShortMilliseconds(0) };
        SetOutLevel { level: Level::HIGH };
        SetMaxRunTime(ms);
        SetStartDelay(StartDelay(4_294_967));
        SetProgramMode { program_mode: ProgramMode::VIDEO };
        SetJoystickMode { joystick_mode: yes };
        SetPingPong { ping_pong: yes };
        FirmwareVersion {}; RunStatus {}; RunTime {}; Exposing {}; TimingMaster {};
    };
    requests.push(HostMessage::from(NameQuery {}));
    requests.extend(messages! {
        MaxStepRate {}; Voltage {}; Current {}; InputEdge {}; AltModes {}; LimitSwitches {}; OutBeforeDelay {};
        OutAfterDelay {}; OutBeforeTime {}; OutAfterTime {}; OutLevel {};
    });
    requests.push(HostMessage::from(StartDelayQuery {}));
    requests.push(HostMessage::from(ProgramModeQuery {}));
    requests.extend(messages! {
        PowerCycled {}; JoystickMode {}; PingPong {};
        MotorSetSleep { motor, sleep: yes };
        MotorSetEnable { motor, enable: yes };
        MotorStop { motor };
        MotorSetBacklash { motor, backlash: Backlash(u16::MAX) };
        MotorSetMicrostep { motor, microstep: Microstep::SIXTEENTH };
        MotorSetMaxStepSpeed { motor, max_step_speed: StepRate(10_000) };
        MotorSetDirection { motor, direction: Direction(1) };
        MotorSetHomeHere { motor }; MotorSetEndHere { motor }; MotorSendHome { motor }; MotorSendToEnd { motor };
        MotorSetContinuousSpeed { motor, speed: StepsPerSecond(-10_000.0) };
        MotorSetContinuousAcceleration { motor, acceleration: StepsPerSecondSquared(15_000.5) };
        MotorMove(motor, Direction(1), StepCount::MAX);
        MotorRun { motor, direction: Direction(0) };
        MotorSetProgramStart { motor, position };
        MotorSetProgramStop { motor, position };
        MotorSetEasing { motor, easing: Easing::INVERSE_QUADRATIC };
        MotorSetLeadIn { motor, lead_in: ShortSpan(u16::MAX) };
        MotorSetLeadInLong(motor, span);
        MotorSetTravel(motor, span);
        MotorSetProgramAcceleration(motor, span);
        MotorSetProgramDeceleration(motor, span);
        MotorSendToStart { motor }; MotorSendToStop { motor }; MotorStepForward { motor }; MotorStepBack { motor };
        MotorResetLimits { motor };
        MotorEnable; MotorBacklash; MotorMicrostep; MotorDirection; MotorMaxStepSpeed; MotorEndLimit; MotorPosition;
        MotorRunning; MotorContinuousSpeed; MotorContinuousAcceleration; MotorEasing; MotorProgramStart;
        MotorProgramStop; MotorTravel; MotorLeadIn; MotorProgramAcceleration; MotorProgramDeceleration;
        MotorMaxProgramSpeed;
        CameraSetEnable { enable: yes };
        CameraExpose {};
        CameraSetExposureTime(ms);
        CameraSetFocusTime { focus_time: ShortMilliseconds(u16::MAX) };
        CameraSetMaxShots { max_shots: ShortShots(u16::MAX) };
        CameraSetExposureDelay { exposure_delay: ShortMilliseconds(u16::MAX) };
        CameraSetFocusWithShutter { focus_with_shutter: yes };
        CameraSetMirrorUp { mirror_up: yes };
        CameraSetInterval(ms);
        CameraEnable {}; CameraExposing {}; CameraExposureTime {}; CameraFocusTime {}; CameraMaxShots {};
        CameraExposureDelay {}; CameraFocusWithShutter {}; CameraMirrorUp {}; CameraInterval {};
        BroadcastStart; BroadcastStop; BroadcastPause;
        BroadcastAssignAddress(Address(255));
        CoreProtocolVersion; CoreDeviceId; CoreDeviceVersion;
        CoreAssignAddress(Address(255));
    });
    requests
}

/// Requests of which lint always warns.
const ALWAYS: [&str; 2] = ["Noop", "MotorResetLimits"];

fn to(message: &HostMessage<'_>) -> Address {
    if message.selector().table == Table::Broadcast { Address::BROADCAST } else { Address::DEFAULT }
}

fn says(message: HostMessage<'_>, context: &Context) -> Vec<String> {
    message.lint(context).into_iter().map(|lint| format!("{} {lint}", lint.severity)).collect()
}

#[test]
fn sends_and_limits_are_warned_of_by_the_age_of_the_firmware() {
    let motor = Motor::One;
    let sends: [HostMessage<'static>; 4] = [
        MotorSendHome { motor }.into(),
        MotorSendToEnd { motor }.into(),
        MotorSendToStart { motor }.into(),
        MotorSendToStop { motor }.into(),
    ];
    let count = |message: &HostMessage<'_>, profile: Profile| {
        let mut context = Context::default();
        context.profile = profile;
        message.lint(&context).as_slice().len()
    };
    for send in &sends {
        let found = ["2014-10-29", "2014-11-03", "v0.45", "version-6"].map(|name| count(send, name.parse().unwrap()));
        assert_eq!((found, count(send, Profile::UNKNOWN)), ([0, 1, 1, 1], 0), "{send}");
    }
    let end = HostMessage::from(MotorSetEndHere { motor });
    assert_eq!(["v0.45", "v0.49", "v0.70"].map(|name| count(&end, name.parse().unwrap())), [0, 1, 1]);
    assert_eq!(count(&sends[1], Profile::V070), 2, "neither the speed nor the limit holds");
}

#[test]
fn lint_is_silent_on_requests_of_the_constructors() {
    let requests = requests();
    assert_eq!(
        requests.iter().map(Messages::name).collect::<Vec<_>>(),
        HostMessage::ALL.iter().map(|kind| kind.name).collect::<Vec<_>>()
    );
    for message in requests {
        let found = message.lint(&Context::default());
        assert_eq!(found.as_slice().is_empty(), !ALWAYS.contains(&message.name()), "{message}");
        let mut out = [0; 42];
        let len = message.encode_checked(to(&message), &Context::default(), &mut out).unwrap();
        assert_eq!(HostMessage::decode(&Frame::decode(&out[..len]).unwrap()), message);
    }
}

/// Answers to a query: one of each type that its reply may have.
fn answers(query: AnyQuery, profile: Profile) -> impl Iterator<Item = hoot_proto::AnyReply<'static>> {
    const DATA: [&[u8]; 8] = [
        &[0, 1],
        &[1, 0, 1],
        &[2, 0, 1],
        &[3, 0, 0, 0, 1],
        &[4, 0, 0, 0, 1],
        &[5, 0, 0, 0, 1],
        b"\x06NMX\0\0\0\0\0\0\0",
        b"\x06",
    ];
    let wanted = query.value_type(profile);
    DATA.into_iter()
        .filter_map(move |data| query.decode_reply(Reply { code: ResponseCode::OK, data }).ok())
        .filter(move |answer| answer.value_type() == wanted)
}

#[test]
fn lint_is_silent_on_replies_of_the_queries() {
    let mut queries = 0;
    let profiles = || Profile::builds().chain([Profile::UNKNOWN, Profile::VERSION_6, Profile::JANUARY_2015]);
    for profile in profiles() {
        let mut context = Context::default();
        context.profile = profile;
        for query in requests().iter().filter_map(HostMessage::query) {
            queries += 1;
            let mut made = 0;
            for answer in answers(query, profile) {
                made += 1;
                let mut data = [0; MAX_DATA];
                let message = DeviceMessage::Reply(query.reply(answer, &mut data).unwrap());
                // Firmware of that time sends garbage here. A simulated node that copies it causes a warning.
                let is_garbage = answer.value_type() == ValueType::FLOAT && profile.float_is_true() != Some(true);
                assert_eq!(message.lint(&context).as_slice().len(), usize::from(is_garbage), "{message}");
                assert!(message.encode_checked(&context, &mut [0; 42]).is_ok());
            }
            assert!(made > 0, "{query:?} has an answer for {profile:?}");
        }
    }
    assert_eq!(queries, profiles().count() * 52);
    for reply in [Reply::OK, Reply::ERROR] {
        assert_eq!(DeviceMessage::Reply(reply).lint(&Context::default()).as_slice(), []);
    }
}

#[test]
fn an_answer_has_the_type_of_the_firmware() {
    let version = [(Profile::SHEET, ValueType::BYTE), (Profile::V070, ValueType::ULONG)];
    for (profile, value_type) in version {
        assert_eq!(FirmwareVersion {}.answer(Version(70), profile).value_type(), value_type);
    }
    let long = FirmwareVersion {}.answer(Version(300), Profile::SHEET);
    assert_eq!((long.value_type(), long.value()), (ValueType::ULONG, Value::ULong(300)), "300 exceeds a byte");
    let lead_in = |profile| MotorLeadIn::default().answer(Span(40_000), profile).value();
    assert_eq!([Profile::SHEET, Profile::V033].map(lead_in), [Value::UInt(40_000), Value::ULong(40_000)]);
    let running = |profile| MotorRunning::default().answer(Bool::TRUE, profile).value();
    assert_eq!([Profile::SHEET, Profile::V033].map(running), [Value::Int(1), Value::Byte(1)]);
    let speed = SpeedOrSleep::Speed(Speed(Scaled(-150)));
    assert_eq!(
        MotorMaxProgramSpeed::default().answer(speed, Profile::V033).value(),
        Value::ULong(0xFFFF_FF6A),
        "-150 exceeds a byte"
    );
    let modes = RingTip { ring: AltMode(200), tip: AltMode(255) };
    assert_eq!(AltModes {}.answer(modes, Profile::SHEET).value(), Value::Int(-14_081));
}

#[test]
fn numbers_that_would_not_arrive_are_refused() {
    let mut seen = 0;
    for kind in HostMessage::ALL {
        let Some(row) = kind.layout.iter().find(|row| row.part == PartKind::Fixed && row.wire == "u32") else {
            continue;
        };
        seen += 1;
        let at = row.offset.unwrap();
        let mut body = vec![0; at + row.size];
        body[at] = 1;
        let message = HostMessage::decode_body(kind.number, &body).unwrap();
        let first = message.lint(&Context::default()).first_error().unwrap();
        assert_eq!(first.what, row.name, "{message}");
    }
    // The two messages of command 15 have the same rows.
    assert_eq!(seen, 10);
    let too_much = MAX_ARRIVING + 1;
    assert_eq!(SetMaxRunTime::new(Milliseconds(too_much)), None);
    assert_eq!(MotorSetTravel::new(Motor::One, Span(too_much)), None);
}

#[test]
fn values_that_the_firmware_refuses_are_errors_and_ignored_ones_are_warnings() {
    let of = |number, data| says(HostMessage::decode_body(number, data).unwrap(), &Context::default());
    assert_eq!(of(0x08_00, &[1]), ["error new_address: 1 is not in 2 to 255"]);
    assert_eq!(of(0x2_04_00, &[0]), ["error new_address: 0 is not in 2 to 255"]);
    assert_eq!((SetAddress::new(Address(1)), CoreAssignAddress::new(Address(0))), (None, None));
    assert_eq!(of(0x09_00, &[3]), ["error common_line: 3 is not in 0 to 2"]);
    assert_eq!(of(0x13_00, &[7]), ["error level: 7 is not in 0 to 1"]);
    assert_eq!(of(0x12_01, &[4]), ["error easing: 4 is not in 1 to 3"]);
    assert_eq!(of(0x0B_00, &[0x0F, 0xFF]), ["warning max_step_rate: the node acknowledges and ignores it"]);
    assert_eq!(of(0x0C_00, &[7]), ["warning edge: the node acknowledges and ignores it"]);
    assert_eq!(of(0x06_01, &[3]), ["warning microstep: the node acknowledges and ignores it"]);
    for speed in [&[0, 0][..], &[0x9C, 0x40]] {
        assert_eq!(of(0x07_01, speed), ["warning max_step_speed: the node acknowledges and ignores it"]);
    }
    assert_eq!(of(0x16_00, &[9]), ["warning program_mode: 9 has no meaning in the specification"]);
    let modes = of(0x0D_00, &[200, 255]);
    assert_eq!(modes[0], "warning ring: 200 has no meaning in the specification");
    assert_eq!(modes[1], "warning tip: 255 has no meaning in the specification");
    assert_eq!(of(0x06_00, &[2]), ["warning timing_master: neither 0 nor 1"]);
    assert_eq!(of(0x0E_01, &[0x7F, 0x80, 0, 0]), ["error acceleration: 0x7f800000 is no finite number"]);
    assert_eq!(of(0x1B_02, &[]), ["warning motor: the motor has no limits from then on"]);
}

#[test]
fn findings_depend_on_the_firmware() {
    let of = |number, data| {
        [
            Profile::UNKNOWN,
            Profile::LIBRARY_2014_09_25,
            Profile::SHEET,
            Profile::JANUARY_2015,
            Profile::V033,
            Profile::V035,
            Profile::V070,
        ]
        .map(|profile| {
            let mut context = Context::default();
            context.profile = profile;
            let found = HostMessage::decode_body(number, data).unwrap().lint(&context);
            found.into_iter().map(|lint| lint.severity).max()
        })
    };
    let (error, warning) = (Some(Severity::Error), Some(Severity::Warning));
    assert_eq!(of(0x13_01, &[0, 1]), [None, None, None, None, None, error, error], "16 bits of lead-in");
    assert_eq!(of(0x13_01, &[0, 0, 0, 1]), [None, error, error, error, error, None, None], "32 bits");
    assert_eq!(of(0x19_01, &[]), [None, None, None, None, error, error, error], "a step, or the lead-out");
    assert_eq!(of(0x6A_00, &[]), [None, None, None, None, None, None, warning], "the greatest step rate");
    assert_eq!(of(0x0B_00, &[0x13, 0x88]), of(0x6A_00, &[]));
    assert_eq!(of(0x79_00, &[]), [None, warning, warning, None, None, None, None], "ping-pong");
    assert_eq!(of(0x75_01, &[]), of(0x79_00, &[]), "both queries were added later");
    let delay = of(0x15_00, &[0, 0x4C, 0x4B, 0x40]);
    assert_eq!(delay, [warning, error, error, error, error, error, None], "5,000,000 s");
}

#[test]
fn only_stops_and_queries_may_be_sent_again() {
    let stops = ["Pause", "Stop", "MotorStop", "BroadcastStop", "BroadcastPause"];
    let mut repeatable = 0;
    for message in requests() {
        // Command 0 does nothing.
        let asks = matches!(message.selector().command, 0 | 100..=121) || message.name().starts_with("Core");
        let changes = ["PowerCycled", "CoreAssignAddress"].contains(&message.name());
        assert_eq!(message.conduct().repeatable, stops.contains(&message.name()) || asks && !changes, "{message}");
        repeatable += usize::from(message.conduct().repeatable);
    }
    assert_eq!(repeatable, stops.len() + 1 + 52 - 1);
}

#[test]
fn joystick_mode_refuses_other_requests() {
    let of = |profile| {
        let mut context = Context::default();
        (context.joystick, context.profile) = (true, profile);
        let severity = |message: &HostMessage<'_>| message.lint(&context).into_iter().map(|lint| lint.severity).max();
        let count = |wanted| requests().iter().filter(|message| severity(message) == wanted).count();
        let stop = severity(&HostMessage::from(Stop {}));
        assert_eq!(stop, Some(Severity::Warning), "a stop is never refused");
        let motor_stop = severity(&HostMessage::from(MotorStop::default()));
        assert_eq!(motor_stop, None, "a stop of a motor works in joystick mode");
        (count(Some(Severity::Error)), count(None))
    };
    let all = requests().len();
    // The controller has 45 requests: two are allowed, and a stop is only a warning. A motor has 46: six are allowed,
    // because a run and a move are one command. The other warning is that of command 0.
    let (refused, silent) = of(Profile::SHEET);
    assert_eq!((refused, all - refused - silent), (42 + 40, 2));
    let sheet = Selector { table: Table::Node, command: 15, sub_address: 2 };
    let by = |profile: Profile, selector| profile.refuses_in_joystick_mode(selector);
    assert_eq!([Profile::SHEET, Profile::V033].map(|profile| by(profile, sheet)), [Some(false), Some(true)]);
    assert_eq!(by(Profile::UNKNOWN, sheet), None);
    assert!(of(Profile::UNKNOWN).0 < refused, "only requests that every firmware refuses");
    let position = Selector { command: 106, ..sheet };
    assert_eq!([Profile::V033, Profile::V070].map(|profile| by(profile, position)), [Some(true), Some(false)]);
}

#[test]
fn lint_warns_of_commands_while_the_planned_move_runs() {
    let mut context = Context::default();
    context.running = true;
    let warned =
        |message: &HostMessage<'_>| message.lint(&context).as_slice().iter().any(|lint| lint.what == "command");
    for message in requests() {
        let stops = ["Start", "Pause", "Stop", "SetJoystickMode", "MotorStop"].contains(&message.name());
        let asks = message.query().is_some() || message.selector().table != Table::Node;
        assert_eq!(warned(&message), message.name() == "Noop" || !(stops || asks), "{message}");
        assert!(message.lint(&context).first_error().is_none(), "the finding is a warning");
    }
}

#[test]
fn steps_that_would_not_arrive_are_refused() {
    let motor = Motor::One;
    let of = |steps| HostMessage::from(MotorMove { motor, direction: Direction(0), steps: StepCount(steps) });
    for steps in [0, 0x0100_0000, u32::MAX] {
        assert_eq!(says(of(steps), &Context::default()), [format!("error steps: {steps} is not in 1 to 16777215")]);
        assert_eq!(MotorMove::new(motor, Direction(0), StepCount(steps)), None);
    }
    let mut out = [0; 42];
    assert!(of(u32::MAX).encode_into(Address(3), &mut out).is_ok(), "a decoded message can be encoded again");
    assert_eq!(
        of(0).encode_into(Address(3), &mut out),
        Err(EncodeError::OutOfRange { what: "MotorMove.steps", value: 0, min: 1, max: u32::MAX.into() }),
        "a move of 0 steps would be a run"
    );
}

#[test]
fn broadcasts_are_refused_through_a_bridge() {
    let context = Context::through_bridge();
    for message in requests() {
        let refused = message.encode_checked(to(&message), &context, &mut [0; 42]).is_err();
        assert_eq!(refused, message.selector().table == Table::Broadcast, "{message}");
    }
    let sub_address = AnySubAddress(9);
    let message = HostMessage::from(BroadcastStart { sub_address });
    assert_eq!(says(message, &Context::default()), ["warning sub_address: nodes ignore the sub-address of broadcasts"]);
    for address in [0, 1] {
        let message = HostMessage::from(BroadcastAssignAddress { new_address: Address(address), ..Default::default() });
        assert_eq!(says(message, &Context::default()), [format!("error new_address: {address} is not in 2 to 255")]);
        assert_eq!(BroadcastAssignAddress::new(Address(address)), None);
    }
}

#[test]
fn an_address_that_means_another_command_is_refused() {
    let mut out = [0xA5; 42];
    let wrong = |value, min, max| Err(EncodeError::OutOfRange { what: "address", value, min, max });
    // In a broadcast, command 4 gives an address. Sent to a node, it stops the motor or the controller.
    assert_eq!(HostMessage::from(Stop {}).encode_into(Address::BROADCAST, &mut out), wrong(1, 2, 255));
    let all_stop = HostMessage::BroadcastStop(BroadcastStop::default());
    assert_eq!(all_stop.encode_into(Address(3), &mut out), wrong(3, 1, 1));
    assert_eq!(out, [0xA5; 42]);
    assert!(HostMessage::from(Stop {}).encode_into(Address::MASTER, &mut out).is_ok(), "encoded as it was decoded");
    let refused = HostMessage::from(Stop {}).encode_checked(Address::MASTER, &Context::default(), &mut out);
    assert!(matches!(refused, Err(EncodeError::Refused(lint)) if lint.what == "address"));
}

#[test]
fn speeds_that_are_not_finite_are_refused() {
    let of = |speed| {
        let message = MotorSetContinuousSpeed { motor: Motor::One, speed: StepsPerSecond(speed) };
        says(HostMessage::from(message), &Context::default())
    };
    assert_eq!(of(f32::NAN), ["error speed: 0x7fc00000 is no finite number"]);
    assert_eq!(of(f32::NEG_INFINITY), ["error speed: 0xff800000 is no finite number"]);
    assert_eq!(
        of(-10_001.0),
        ["warning speed: above the step rate of any firmware, which acknowledges and ignores it"]
    );
    assert_eq!((of(0.0), of(-5000.0)), (vec![], vec![]));
}

#[test]
fn a_motor_of_speed_0_does_not_move() {
    let mut context = Context::default();
    context.speeds = [None, Some(StepsPerSecond(0.0)), Some(StepsPerSecond(100.0))];
    let found = Motor::ALL.map(|motor| says(HostMessage::from(MotorRun { motor, direction: Direction(0) }), &context));
    assert_eq!(
        found,
        [
            vec![],
            vec!["warning motor: nothing moves, because the continuous speed of the motor is 0".to_string()],
            vec![]
        ]
    );
    let run = HostMessage::from(MotorRun { motor: Motor::One, direction: Direction(2) });
    assert_eq!(says(run, &context), ["warning direction: 2 is not in 0 to 1"]);
}

#[test]
fn names_with_nuls_or_breaks_are_found() {
    let of = |name| says(HostMessage::SetName(SetName { name: Name::from_bytes(name).unwrap() }), &Context::default());
    assert_eq!(of(b"ABC\0\0\0\0\0\0\0"), [""; 0]);
    assert_eq!(of(b"A\0B"), ["warning name: the node keeps NULs inside, and many readers stop there"]);
    let found = of(b"\0\0\0\0\0\xFF\x03\0d\0");
    assert_eq!(found[0], "error name: contains a break, the start of a packet");
}

#[test]
fn raw_packets_are_checked_by_the_tables() {
    let of = |number, data| says(HostMessage::other(number, data), &Context::default());
    assert_eq!(
        of(0x0F_01, &[1, 0, 3]),
        ["error data: too short: the node reads missing bytes as zero"],
        "the motor would run for ever"
    );
    assert_eq!(of(0x02_00, &[1]), ["warning data: longer than the data of the command: the node ignores the rest"]);
    assert_eq!(
        of(0x18_00, &[]),
        ["error data: too short: the node reads missing bytes as zero"],
        "as the sheet prints it"
    );
    assert_eq!(of(0x01_00, &[]), ["error data: the data must begin with a command of the core protocol"]);
    assert_eq!(of(0x01_00, &[4, 1]), ["error new_address: 1 is not in 2 to 255"], "a known command");
    assert_eq!(of(0x01_00, &[9]), [""; 0]);
    assert_eq!(of(0x00_02, &[1])[0], "warning command: nodes do not answer command 0, and bridges do not forward it");
    assert_eq!(of(0x63_00, &[0; 33]), ["error data: 33 is not in 0 to 32"]);
    assert_eq!(of(0x63_00, &[1, 0, 0, 0, 0, 0, 0xFF]), ["error data: contains a break, the start of a packet"]);
    assert_eq!(of(0x0F_01, &[0, 1, 0, 0, 0]), ["error steps: 16777216 is not in 1 to 16777215"], "a known command");
    let refused =
        HostMessage::other(0x1_4D_00, &[]).encode_checked(Address(1), &Context::through_bridge(), &mut [0; 42]);
    assert!(refused.is_err());
}

#[test]
fn unusual_replies_are_found() {
    let of = |code, data| -> Vec<String> {
        let message = DeviceMessage::Reply(Reply { code: ResponseCode(code), data });
        message.lint(&Context::default()).into_iter().map(|lint| format!("{} {lint}", lint.severity)).collect()
    };
    assert_eq!(of(7, &[]), ["warning response_code: 7 has no meaning in the specification"]);
    assert_eq!(of(0, &[0, 1]), ["warning response_code: an error with data has code 2"]);
    assert_eq!(of(1, &[9, 1]), ["warning value_type: 9 has no meaning in the specification"]);
    assert_eq!(of(1, &[3, 1]), ["error value: longer or shorter than its type says"]);
    assert_eq!(
        of(1, &[5, 0, 0, 0xE6, 0x66]),
        ["warning value: not reliable: firmware from 2014-10-07 to v0.32 sends garbage as FLOAT"]
    );
    let echo = DeviceMessage::other(0x03_00_04, &[]);
    let found = echo.lint(&Context::default());
    assert_eq!(found.as_slice().iter().map(|lint| lint.severity).collect::<Vec<_>>(), [Severity::Warning]);
}
