//! Law 14: lint is silent on what the constructors make; and what it says of the rest.

use hoot_proto::frame::MAX_DATA;
use hoot_proto::lint::Context;
use hoot_proto::message::{
    AnySubAddress, BroadcastAssignAddress, BroadcastPause, BroadcastStart, BroadcastStop, Direction, Motor, MotorMove,
    MotorPosition, MotorRun, MotorRunning, MotorSetContinuousSpeed, MotorStop, Name, NameQuery, Pause, Reply,
    ResponseCode, RunState, RunStatus, SetName, Start, StepCount, Steps, StepsPerSecond, Stop, Text, Voltage, Volts,
};
use hoot_proto::query::{Answer, Profile};
use hoot_proto::{Address, DeviceMessage, EncodeError, Frame, HostMessage, Query};
use motion_core::fixed::Scaled;
use motion_core::lint::Severity;
use motion_core::wire::{Bool, Messages};

/// One of each message, as its constructor makes it.
fn requests() -> Vec<HostMessage<'static>> {
    let motor = Motor::Three;
    let (direction, max) = (Direction(1), StepCount::MAX);
    vec![
        HostMessage::Start(Start {}),
        HostMessage::Pause(Pause {}),
        HostMessage::Stop(Stop {}),
        HostMessage::SetName(SetName { name: Name::new("Dolly").unwrap() }),
        HostMessage::RunStatus(RunStatus {}),
        HostMessage::Name(NameQuery {}),
        HostMessage::Voltage(Voltage {}),
        HostMessage::MotorStop(MotorStop { motor }),
        HostMessage::MotorSetContinuousSpeed(MotorSetContinuousSpeed { motor, speed: StepsPerSecond(-10_000.0) }),
        HostMessage::MotorMove(MotorMove::new(motor, direction, max).unwrap()),
        HostMessage::MotorRun(MotorRun { motor, direction }),
        HostMessage::MotorPosition(MotorPosition { motor }),
        HostMessage::MotorRunning(MotorRunning { motor }),
        HostMessage::BroadcastStart(BroadcastStart::default()),
        HostMessage::BroadcastStop(BroadcastStop::default()),
        HostMessage::BroadcastPause(BroadcastPause::default()),
        HostMessage::BroadcastAssignAddress(BroadcastAssignAddress::new(Address(2)).unwrap()),
    ]
}

fn to(message: &HostMessage<'_>) -> Address {
    if message.selector().broadcast { Address::BROADCAST } else { Address::DEFAULT }
}

fn says(message: HostMessage<'_>, context: &Context) -> Vec<String> {
    message.lint(context).into_iter().map(|lint| format!("{} {lint}", lint.severity)).collect()
}

#[test]
fn silent_on_what_constructors_make() {
    let requests = requests();
    assert_eq!(
        requests.iter().map(Messages::name).collect::<Vec<_>>(),
        HostMessage::ALL.iter().map(|kind| kind.name).collect::<Vec<_>>()
    );
    for message in requests {
        assert!(message.lint(&Context::default()).as_slice().is_empty(), "{message}");
        let mut out = [0; 42];
        let len = message.encode_checked(to(&message), &Context::default(), &mut out).unwrap();
        assert_eq!(HostMessage::decode(&Frame::decode(&out[..len]).unwrap()), message);
    }
}

#[test]
fn silent_on_the_replies_that_queries_make() {
    for profile in [Profile::Unknown, Profile::Library20140925, Profile::V033] {
        let mut context = Context::default();
        context.profile = profile;
        let mut data = [[0; MAX_DATA]; 5];
        let [state, name, voltage, position, running] = &mut data;
        let volts = Volts(Scaled(1229));
        let replies = [
            RunStatus {}.reply(Answer::new(RunState::RUNNING, profile), state),
            NameQuery {}.reply(Answer::new(Text(b"NMX\0\0\0\0\0\0\0"), profile), name),
            Voltage {}.reply(Answer::new(volts, profile), voltage),
            MotorPosition::default().reply(Answer::new(Steps(-1), profile), position),
            MotorRunning::default().reply(Answer::new(Bool::TRUE, profile), running),
            Ok(Reply::OK),
            Ok(Reply::ERROR),
        ];
        for reply in replies {
            let message = DeviceMessage::Reply(reply.unwrap());
            assert_eq!(message.lint(&context).as_slice(), [], "{message}");
            assert!(message.encode_checked(&context, &mut [0; 42]).is_ok());
        }
    }
}

#[test]
fn more_steps_than_arrive_are_refused() {
    let motor = Motor::One;
    let of = |steps| HostMessage::MotorMove(MotorMove { motor, direction: Direction(0), steps: StepCount(steps) });
    for steps in [0, 0x0100_0000, u32::MAX] {
        assert_eq!(says(of(steps), &Context::default()), [format!("error steps: {steps} is not in 1 to 16777215")]);
        assert_eq!(MotorMove::new(motor, Direction(0), StepCount(steps)), None);
    }
    let mut out = [0; 42];
    assert!(of(u32::MAX).encode_into(Address(3), &mut out).is_ok(), "what was decoded is written back");
    assert_eq!(
        of(0).encode_into(Address(3), &mut out),
        Err(EncodeError::OutOfRange { what: "MotorMove.steps", value: 0, min: 1, max: u32::MAX.into() }),
        "it would be a run"
    );
}

#[test]
fn broadcasts_and_bridges() {
    let context = Context::through_bridge();
    for message in requests() {
        let refused = message.encode_checked(to(&message), &context, &mut [0; 42]).is_err();
        assert_eq!(refused, message.selector().broadcast, "{message}");
    }
    let sub_address = AnySubAddress(9);
    let message = HostMessage::BroadcastStart(BroadcastStart { sub_address });
    assert_eq!(says(message, &Context::default()), ["warning sub_address: nodes ignore it in broadcasts"]);
    for address in [0, 1] {
        let message = HostMessage::BroadcastAssignAddress(BroadcastAssignAddress {
            address: Address(address),
            ..Default::default()
        });
        assert_eq!(says(message, &Context::default()), [format!("error address: {address} is not in 2 to 255")]);
        assert_eq!(BroadcastAssignAddress::new(Address(address)), None);
    }
}

#[test]
fn an_address_that_means_another_command_is_refused() {
    let mut out = [0xA5; 42];
    let wrong = |value, min, max| Err(EncodeError::OutOfRange { what: "address", value, min, max });
    // To all nodes, command 4 gives an address; to a node, it stops the motor or the controller.
    assert_eq!(HostMessage::Stop(Stop {}).encode_into(Address::BROADCAST, &mut out), wrong(1, 2, 255));
    let all_stop = HostMessage::BroadcastStop(BroadcastStop::default());
    assert_eq!(all_stop.encode_into(Address(3), &mut out), wrong(3, 1, 1));
    assert_eq!(out, [0xA5; 42]);
    assert!(HostMessage::Stop(Stop {}).encode_into(Address::MASTER, &mut out).is_ok(), "as it came");
    let refused = HostMessage::Stop(Stop {}).encode_checked(Address::MASTER, &Context::default(), &mut out);
    assert!(matches!(refused, Err(EncodeError::Refused(lint)) if lint.what == "address"));
}

#[test]
fn speeds() {
    let of = |speed| {
        let message = MotorSetContinuousSpeed { motor: Motor::One, speed: StepsPerSecond(speed) };
        says(HostMessage::MotorSetContinuousSpeed(message), &Context::default())
    };
    assert_eq!(of(f32::NAN), ["error speed: 0x7fc00000 is no finite number"]);
    assert_eq!(of(f32::NEG_INFINITY), ["error speed: 0xff800000 is no finite number"]);
    assert_eq!(
        of(-10_001.0),
        ["warning speed: beyond the step rate of any firmware, which acknowledges and ignores it"]
    );
    assert_eq!((of(0.0), of(-5000.0)), (vec![], vec![]));
}

#[test]
fn a_motor_of_speed_0_does_not_move() {
    let mut context = Context::default();
    context.speeds = [None, Some(StepsPerSecond(0.0)), Some(StepsPerSecond(100.0))];
    let found =
        Motor::ALL.map(|motor| says(HostMessage::MotorRun(MotorRun { motor, direction: Direction(0) }), &context));
    assert_eq!(found, [vec![], vec!["warning motor: nothing moves: its continuous speed is 0".to_string()], vec![]]);
    let run = HostMessage::MotorRun(MotorRun { motor: Motor::One, direction: Direction(2) });
    assert_eq!(says(run, &context), ["warning direction: 2 is not in 0 to 1"]);
}

#[test]
fn names_of_others() {
    let of = |name| says(HostMessage::SetName(SetName { name: Name::from_bytes(name).unwrap() }), &Context::default());
    assert_eq!(of(b"ABC\0\0\0\0\0\0\0"), [""; 0]);
    assert_eq!(of(b"A\0B"), ["warning name: the node skips NULs inside"]);
    let found = of(b"\0\0\0\0\0\xFF\x03\0d\0");
    assert_eq!(found[0], "error name: holds a break, the start of a packet");
}

#[test]
fn raw_packets() {
    let of = |number, data| says(HostMessage::other(number, data), &Context::default());
    assert_eq!(
        of(0x0F_01, &[1, 0, 3]),
        ["error data: too short: the node reads missing bytes as zero"],
        "and runs for ever"
    );
    assert_eq!(of(0x02_00, &[1]), ["warning data: longer than the command's: the node leaves out the rest"]);
    assert_eq!(of(0x00_02, &[]), ["warning command: nodes are silent at command 0, and bridges do not pass it on"]);
    assert_eq!(of(0x63_00, &[0; 33]), ["error data: 33 is not in 0 to 32"]);
    assert_eq!(of(0x63_00, &[1, 0, 0, 0, 0, 0, 0xFF]), ["error data: holds a break, the start of a packet"]);
    assert_eq!(of(0x0F_01, &[0, 1, 0, 0, 0]), ["error steps: 16777216 is not in 1 to 16777215"], "known after all");
    let refused =
        HostMessage::other(0x1_4D_00, &[]).encode_checked(Address(1), &Context::through_bridge(), &mut [0; 42]);
    assert!(refused.is_err());
}

#[test]
fn replies_of_others() {
    let of = |code, data| -> Vec<String> {
        let message = DeviceMessage::Reply(Reply { code: ResponseCode(code), data });
        message.lint(&Context::default()).into_iter().map(|lint| format!("{} {lint}", lint.severity)).collect()
    };
    assert_eq!(of(7, &[]), ["warning response_code: 7 has no meaning in the specification"]);
    assert_eq!(of(0, &[0, 1]), ["warning response_code: an error with data has code 2"]);
    assert_eq!(of(1, &[9, 1]), ["warning value_type: 9 has no meaning in the specification"]);
    assert_eq!(of(1, &[3, 1]), ["error value: longer or shorter than its type"]);
    assert_eq!(
        of(1, &[5, 0, 0, 0xE6, 0x66]),
        ["warning value: not reliable: firmware from 2014-10-07 to v0.32 sends garbage as FLOAT"]
    );
    let echo = DeviceMessage::other(0x03_00_04, &[]);
    let found = echo.lint(&Context::default());
    assert_eq!(found.as_slice().iter().map(|lint| lint.severity).collect::<Vec<_>>(), [Severity::Warning]);
}
