//! Settings and answers of a node: hoot, sections 2.1 to 2.4.

use super::world::*;
use hoot_proto::device::{Event, Input, Options, Part, StoredName};
use hoot_proto::message::*;
use hoot_proto::query::Profile;
use hoot_proto::{HostMessage, Query};
use motion_core::fixed::Scaled;

/// Setting, its query, and the bytes of the answer.
type Asked = (HostMessage<'static>, HostMessage<'static>, &'static [u8]);

// 2-1
#[test]
fn queries_read_settings_back() {
    let motor = Motor::Three;
    let (ring, tip) = (AltMode(200), AltMode(255));
    let millis = ShortMilliseconds;
    let name = Name::new("Dolly").unwrap();
    let table: &[Asked] = &[
        (SetTimingMaster { timing_master: NO }.into(), TimingMaster {}.into(), &[0, 0]),
        (SetName { name }.into(), NameQuery {}.into(), b"\x06Dolly\0\0\0\0\0"),
        (SetMaxStepRate { max_step_rate: StepRate(4000) }.into(), MaxStepRate {}.into(), &[1, 15, 160]),
        (SetInputEdge { edge: Edge::RISING }.into(), InputEdge {}.into(), &[0, 3]),
        (SetInputEdge { edge: Edge::CHANGE }.into(), InputEdge {}.into(), &[0, 1]),
        (SetAltModes { ring, tip }.into(), AltModes {}.into(), &[2, 200, 255]),
        (SetOutBeforeDelay { delay: millis(40_000) }.into(), OutBeforeDelay {}.into(), &[1, 156, 64]),
        (SetOutAfterDelay { delay: millis(1) }.into(), OutAfterDelay {}.into(), &[1, 0, 1]),
        (SetOutBeforeTime { time: millis(2) }.into(), OutBeforeTime {}.into(), &[1, 0, 2]),
        (SetOutAfterTime { time: millis(3) }.into(), OutAfterTime {}.into(), &[1, 0, 3]),
        (SetOutLevel { level: Level::HIGH }.into(), OutLevel {}.into(), &[0, 1]),
        (SetStartDelay { start_delay: StartDelay(9) }.into(), StartDelayQuery {}.into(), &[4, 0, 0, 0, 9]),
        (SetProgramMode { program_mode: ProgramMode(9) }.into(), ProgramModeQuery {}.into(), &[0, 9]),
        (MotorSetEnable { motor, enable: YES }.into(), MotorEnable { motor }.into(), &[0, 1]),
        (MotorSetBacklash { motor, backlash: Backlash(300) }.into(), MotorBacklash { motor }.into(), &[1, 1, 44]),
        (MotorSetMicrostep { motor, microstep: Microstep(8) }.into(), MotorMicrostep { motor }.into(), &[0, 8]),
        (MotorSetDirection { motor, direction: Direction(1) }.into(), MotorDirection { motor }.into(), &[0, 1]),
        (
            MotorSetMaxStepSpeed { motor, max_step_speed: StepRate(3000) }.into(),
            MotorMaxStepSpeed { motor }.into(),
            &[1, 11, 184],
        ),
        (speed(motor, -123.45), MotorContinuousSpeed { motor }.into(), &[5, 255, 255, 207, 199]),
        (
            MotorSetContinuousAcceleration { motor, acceleration: StepsPerSecondSquared(0.29) }.into(),
            MotorContinuousAcceleration { motor }.into(),
            &[5, 0, 0, 0, 29],
        ),
        (MotorSetEasing { motor, easing: Easing(3) }.into(), MotorEasing { motor }.into(), &[0, 6]),
        (
            MotorSetProgramStart { motor, position: Steps(-2) }.into(),
            MotorProgramStart { motor }.into(),
            &[3, 255, 255, 255, 254],
        ),
        (MotorSetProgramStop { motor, position: Steps(5) }.into(), MotorProgramStop { motor }.into(), &[3, 0, 0, 0, 5]),
        (MotorSetTravel { motor, travel: Span(6) }.into(), MotorTravel { motor }.into(), &[4, 0, 0, 0, 6]),
        (MotorSetLeadIn { motor, lead_in: ShortSpan(7) }.into(), MotorLeadIn { motor }.into(), &[1, 0, 7]),
        (
            MotorSetProgramAcceleration { motor, acceleration: Span(8) }.into(),
            MotorProgramAcceleration { motor }.into(),
            &[4, 0, 0, 0, 8],
        ),
        (
            MotorSetProgramDeceleration { motor, deceleration: Span(9) }.into(),
            MotorProgramDeceleration { motor }.into(),
            &[4, 0, 0, 0, 9],
        ),
        (CameraSetEnable { enable: YES }.into(), CameraEnable {}.into(), &[0, 1]),
        (
            CameraSetExposureTime { exposure_time: Milliseconds(1) }.into(),
            CameraExposureTime {}.into(),
            &[4, 0, 0, 0, 1],
        ),
        (CameraSetFocusTime { focus_time: millis(2) }.into(), CameraFocusTime {}.into(), &[1, 0, 2]),
        (CameraSetMaxShots { max_shots: ShortShots(3) }.into(), CameraMaxShots {}.into(), &[4, 0, 0, 0, 3]),
        (CameraSetExposureDelay { exposure_delay: millis(4) }.into(), CameraExposureDelay {}.into(), &[1, 0, 4]),
        (CameraSetFocusWithShutter { focus_with_shutter: YES }.into(), CameraFocusWithShutter {}.into(), &[0, 1]),
        (CameraSetMirrorUp { mirror_up: YES }.into(), CameraMirrorUp {}.into(), &[2, 0, 1]),
        (CameraSetInterval { interval: Milliseconds(5) }.into(), CameraInterval {}.into(), &[4, 0, 0, 0, 5]),
        (SetJoystickMode { joystick_mode: YES }.into(), JoystickMode {}.into(), &[0, 1]),
    ];
    let mut node = Node::new(Options::default());
    for (set, asked, bytes) in table {
        node.ok(*set);
        assert_eq!(node.ask(*asked), *bytes, "{set:?}");
    }
    let part = |message| Node::new(Options::default()).request(message).1;
    assert_eq!(part(table[0].0), [Event::Set(Part::Controller)]);
    assert_eq!(part(table[14].0), [Event::Set(Part::Motor(motor))]);
    assert_eq!(part(table[27].0), [Event::Set(Part::Camera)]);
}

// 2-2
#[test]
fn some_values_are_acknowledged_and_ignored() {
    let motor = Motor::One;
    let mut node = Node::new(Options::default());
    let before = node.machine.clone();
    let max = |speed| HostMessage::from(MotorSetMaxStepSpeed { motor, max_step_speed: StepRate(speed) });
    let ignored: [HostMessage<'static>; 6] = [
        SetMaxStepRate { max_step_rate: StepRate(4001) }.into(),
        SetInputEdge { edge: Edge(3) }.into(),
        MotorSetMicrostep { motor, microstep: Microstep(5) }.into(),
        max(0),
        max(5001),
        MotorSetContinuousAcceleration { motor, acceleration: StepsPerSecondSquared(f32::NAN) }.into(),
    ];
    for message in ignored {
        node.ok(message);
        assert_eq!(node.machine.controller(), before.controller(), "{message:?}");
        assert_eq!(node.machine.motor(motor), before.motor(motor), "{message:?}");
    }
}

// 2-3
#[test]
fn some_values_are_refused() {
    let motor = Motor::One;
    let mut node = Node::new(Options::default());
    let before = node.machine.clone();
    for message in [
        SetCommonLine { common_line: CommonLine(3) }.into(),
        SetOutLevel { level: Level(2) }.into(),
        MotorSetEasing { motor, easing: Easing(0) }.into(),
        MotorMaxProgramSpeed { motor }.into(),
        PingPong {}.into(),
    ] {
        node.refused(message);
    }
    assert_eq!((node.machine.controller(), node.machine.motor(motor)), (before.controller(), before.motor(motor)));
}

// 2-4
#[test]
fn answers_depend_on_the_profile() {
    let of = |profile| Node::new(Options::default().with_profile(profile));
    let motor = Motor::Two;
    let version = HostMessage::from(FirmwareVersion {});
    assert_eq!(of(Profile::LIBRARY_2014_09_25).ask(version), [0, 6]);
    assert_eq!(of(Profile::JANUARY_2015).ask(version), [4, 0, 0, 0, 20]);
    assert_eq!(of(Profile::V033).ask(version), [4, 0, 0, 0, 33]);
    assert_eq!(of(Profile::V035).ask(version), [4, 0, 0, 0, 35]);
    assert_eq!(of(Profile::V070).ask(version), [4, 0, 0, 0, 70]);
    assert_eq!(of(Profile::LIBRARY_2014_09_25).ask(MotorRunning { motor }.into()), [2, 0, 0]);
    assert_eq!(of(Profile::V033).ask(MotorContinuousSpeed { motor }.into()), [4, 0, 0, 0, 0]);
    assert_eq!(
        of(Profile::V033).ask(MotorMaxProgramSpeed { motor }.into()),
        [0, 1],
        "whether the motor has no current while it rests"
    );
    assert_eq!(of(Profile::V033).ask(PingPong {}.into()), [0, 0]);
    let rate = HostMessage::from(SetMaxStepRate { max_step_rate: StepRate(1000) });
    for message in [rate, MaxStepRate {}.into()] {
        assert!(of(Profile::V070).request(message).0.is_empty(), "gone: {message:?}");
    }
    // The lead-in has two lengths. Each firmware reads one of them.
    let short = HostMessage::from(MotorSetLeadIn { motor, lead_in: ShortSpan(3) });
    let long = HostMessage::from(MotorSetLeadInLong { motor, lead_in: Span(0x0004_0005) });
    for (profile, message, lead_in) in [
        (Profile::SHEET, short, 3),
        (Profile::SHEET, long, 4),
        (Profile::V035, short, 0x0003_0000),
        (Profile::V035, long, 0x0004_0005),
    ] {
        let mut node = of(profile);
        node.ok(message);
        assert_eq!(node.machine.motor(motor).settings().lead_in, Span(lead_in), "{profile:?}");
    }
}

// 2-5
#[test]
fn queries_answer_the_reports_of_the_rig() {
    let mut node = Node::new(Options::default());
    let motor = Motor::Two;
    node.tell(Input::Position { motor, position: Steps(-7) });
    node.tell(Input::Supply { volts: Volts(Scaled(1234)), amperes: Amperes(Scaled(-5)) });
    node.tell(Input::Limits(RingTip { ring: Level::HIGH, tip: Level::LOW }));
    assert_eq!(node.ask(MotorPosition { motor }.into()), [3, 255, 255, 255, 249]);
    assert_eq!(node.ask(Voltage {}.into()), [5, 0, 0, 4, 210]);
    assert_eq!(node.ask(Current {}.into()), [5, 255, 255, 255, 251]);
    assert_eq!(node.ask(LimitSwitches {}.into()), [2, 1, 0]);
    assert_eq!(node.ask(MotorEndLimit { motor }.into()), [3, 0, 0, 0, 0]);
    node.ok(MotorSetEndHere { motor }.into());
    assert_eq!(node.ask(MotorEndLimit { motor }.into()), [3, 255, 255, 255, 249]);
}

// 2-6
#[test]
fn every_query_is_answered_in_the_type_of_the_profile() {
    use motion_core::wire::Messages;
    let mut asked = 0;
    for profile in [Profile::SHEET, Profile::LIBRARY_2014_09_25, Profile::V033, Profile::V070, Profile::UNKNOWN] {
        let mut node = Node::new(Options::default().with_profile(profile));
        for kind in HostMessage::ALL {
            let Ok(message) = HostMessage::decode_body(kind.number, &[]) else { continue };
            let Some(query) = message.query() else { continue };
            let (answers, _) = node.request(message);
            let mut scratch = [0; 32];
            let Some(answer) = answers.first() else { continue };
            let DeviceMessage::Reply(reply) = answer.message(&mut scratch).unwrap() else { panic!() };
            if reply.is_ok() {
                asked += 1;
                assert_eq!(reply.value_type(), Some(query.value_type(profile)), "{message:?} of {profile:?}");
                assert!(query.decode_reply(reply).is_ok(), "{message:?}");
            }
        }
    }
    assert!(asked > 5 * 45, "{asked}");
}

// 2-7
#[test]
fn a_name_has_ten_bytes() {
    let name = HostMessage::from(NameQuery {});
    assert_eq!(Node::new(Options::default()).ask(name), b"\x06DEFAULT   ");
    let given = Options::default().with_name(StoredName::from(&Name::from_bytes(b"a\0b\0\0c").unwrap()));
    let mut node = Node::new(given);
    assert_eq!(node.ask(name), b"\x06a\0b\0\0c\0\0\0\0", "NULs inside are kept");
    assert_eq!(node.machine.name().0, *b"a\0b\0\0c\0\0\0\0");
    let mut scratch = [0; 10];
    let (answers, _) = node.request(name);
    assert!(answers[0].message(&mut scratch).is_err(), "eleven bytes with the type");
}

// 2-8
#[test]
fn the_lamp_is_switched() {
    assert_eq!(Node::ready().ok(ToggleDebugLed {}.into()), [Event::DebugLed]);
}
