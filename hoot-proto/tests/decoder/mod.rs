//! Second decoder of requests and replies, written with nom from the specification alone.
//!
//! The decimal numbers of the tables count. The data of a request is written as in the tables: `B` a Byte, `U` an
//! `UInt`, `L` a Long, `N` an `ULong`, `F` a float, `S` a string of 1 to 10. The answer to a query is given by the type
//! bytes that it may have, and by the way to read the number.

use hoot_proto::message::SpeedOrSleep;
use hoot_proto::{AnyReply, DeviceMessage, Frame, HostMessage, Query};
use motion_core::wire::{FieldView, Fields, Messages, Value};
use nom::Parser;
use nom::bytes::complete::tag;
use nom::combinator::{all_consuming, rest, verify};
use nom::multi::length_data;
use nom::number::complete::{be_f32, be_i16, be_i32, be_u8, be_u16, be_u32};

type Parsed<'a, T> = nom::IResult<&'a [u8], T>;

/// Way to read an answer, beyond its type byte.
#[derive(Clone, Copy, PartialEq)]
enum How {
    /// The type byte gives the type.
    Plain,
    /// 32 bits are signed, whatever the type byte.
    Signed,
    /// 16 bits are unsigned, whatever the type byte.
    Unsigned,
    /// A yes or no. A value that does not fit into a byte is a yes.
    YesNo,
    /// Two bytes, the ring and the tip.
    Pair,
}
use How::{Pair, Plain, Signed, Unsigned, YesNo};

/// Number, name and parameters, and for a query the types of the answer.
type Row = (u8, &'static str, &'static str, Option<(&'static [u8], How)>);

const BYTE: Option<(&[u8], How)> = Some((&[0], Plain));
const UINT: Option<(&[u8], How)> = Some((&[1], Plain));
const ULONG: Option<(&[u8], How)> = Some((&[4], Plain));
const LONG: Option<(&[u8], How)> = Some((&[3, 4], Signed));
const FIXED: Option<(&[u8], How)> = Some((&[3, 4, 5], Signed));
const BOOL: Option<(&[u8], How)> = Some((&[0, 2], YesNo));
const PAIR: Option<(&[u8], How)> = Some((&[2], Pair));
const TEXT: Option<(&[u8], How)> = Some((&[6], Plain));

/// Commands of the controller: sections 2.1 and 2.2.
const MAIN: &[Row] = &[
    (2, "Start", "", None),
    (3, "Pause", "", None),
    (4, "Stop", "", None),
    (5, "ToggleDebugLed", "", None),
    (6, "SetTimingMaster", "B", None),
    (7, "SetName", "S", None),
    (8, "SetAddress", "B", None),
    (9, "SetCommonLine", "B", None),
    (10, "ReturnHome", "", None),
    (11, "SetMaxStepRate", "U", None),
    (12, "SetInputEdge", "B", None),
    (13, "SetAltModes", "BB", None),
    (14, "SetManualMove", "B", None),
    (15, "SetOutBeforeDelay", "U", None),
    (16, "SetOutAfterDelay", "U", None),
    (17, "SetOutBeforeTime", "U", None),
    (18, "SetOutAfterTime", "U", None),
    (19, "SetOutLevel", "B", None),
    (20, "SetMaxRunTime", "N", None),
    (21, "SetStartDelay", "N", None),
    (22, "SetProgramMode", "B", None),
    (23, "SetJoystickMode", "B", None),
    (24, "SetPingPong", "B", None),
    (100, "FirmwareVersion", "", Some((&[0, 4], Plain))),
    (101, "RunStatus", "", BYTE),
    (102, "RunTime", "", ULONG),
    (103, "Exposing", "", BYTE),
    (104, "TimingMaster", "", BYTE),
    (105, "Name", "", TEXT),
    (106, "MaxStepRate", "", UINT),
    (107, "Voltage", "", FIXED),
    (108, "Current", "", FIXED),
    (109, "InputEdge", "", BYTE),
    (110, "AltModes", "", PAIR),
    (111, "LimitSwitches", "", PAIR),
    (112, "OutBeforeDelay", "", UINT),
    (113, "OutAfterDelay", "", UINT),
    (114, "OutBeforeTime", "", UINT),
    (115, "OutAfterTime", "", UINT),
    (116, "OutLevel", "", BYTE),
    (117, "StartDelay", "", ULONG),
    (118, "ProgramMode", "", BYTE),
    (119, "PowerCycled", "", BYTE),
    (120, "JoystickMode", "", BYTE),
    (121, "PingPong", "", BYTE),
];

/// Commands of a motor: section 2.3.
const MOTOR: &[Row] = &[
    (2, "MotorSetSleep", "B", None),
    (3, "MotorSetEnable", "B", None),
    (4, "MotorStop", "", None),
    (5, "MotorSetBacklash", "U", None),
    (6, "MotorSetMicrostep", "B", None),
    (7, "MotorSetMaxStepSpeed", "U", None),
    (8, "MotorSetDirection", "B", None),
    (9, "MotorSetHomeHere", "", None),
    (10, "MotorSetEndHere", "", None),
    (11, "MotorSendHome", "", None),
    (12, "MotorSendToEnd", "", None),
    (13, "MotorSetContinuousSpeed", "F", None),
    (14, "MotorSetContinuousAcceleration", "F", None),
    (15, "MotorMove", "BN", None),
    (16, "MotorSetProgramStart", "L", None),
    (17, "MotorSetProgramStop", "L", None),
    (18, "MotorSetEasing", "B", None),
    (19, "MotorSetLeadIn", "U", None),
    (19, "MotorSetLeadInLong", "N", None),
    (20, "MotorSetTravel", "N", None),
    (21, "MotorSetProgramAcceleration", "N", None),
    (22, "MotorSetProgramDeceleration", "N", None),
    (23, "MotorSendToStart", "", None),
    (24, "MotorSendToStop", "", None),
    (25, "MotorStepForward", "", None),
    (26, "MotorStepBack", "", None),
    (27, "MotorResetLimits", "", None),
    (100, "MotorEnable", "", BYTE),
    (101, "MotorBacklash", "", UINT),
    (102, "MotorMicrostep", "", BYTE),
    (103, "MotorDirection", "", BYTE),
    (104, "MotorMaxStepSpeed", "", Some((&[1, 2], Unsigned))),
    (105, "MotorEndLimit", "", LONG),
    (106, "MotorPosition", "", LONG),
    (107, "MotorRunning", "", BOOL),
    (108, "MotorContinuousSpeed", "", FIXED),
    (109, "MotorContinuousAcceleration", "", FIXED),
    (110, "MotorEasing", "", BYTE),
    (111, "MotorProgramStart", "", LONG),
    (112, "MotorProgramStop", "", LONG),
    (113, "MotorTravel", "", ULONG),
    (114, "MotorLeadIn", "", Some((&[1, 2, 4], Unsigned))),
    (115, "MotorProgramAcceleration", "", ULONG),
    (116, "MotorProgramDeceleration", "", ULONG),
    (117, "MotorMaxProgramSpeed", "", Some((&[0, 4, 5], Signed))),
];

/// Commands of the camera: section 2.4.
const CAMERA: &[Row] = &[
    (2, "CameraSetEnable", "B", None),
    (3, "CameraExpose", "", None),
    (4, "CameraSetExposureTime", "N", None),
    (5, "CameraSetFocusTime", "U", None),
    (6, "CameraSetMaxShots", "U", None),
    (7, "CameraSetExposureDelay", "U", None),
    (8, "CameraSetFocusWithShutter", "B", None),
    (9, "CameraSetMirrorUp", "B", None),
    (10, "CameraSetInterval", "N", None),
    (100, "CameraEnable", "", BYTE),
    (101, "CameraExposing", "", BYTE),
    (102, "CameraExposureTime", "", ULONG),
    (103, "CameraFocusTime", "", UINT),
    (104, "CameraMaxShots", "", Some((&[1, 4], Plain))),
    (105, "CameraExposureDelay", "", UINT),
    (106, "CameraFocusWithShutter", "", BYTE),
    (107, "CameraMirrorUp", "", BOOL),
    (108, "CameraInterval", "", ULONG),
];

/// Broadcasts: section 2.5.
const BROADCAST: &[Row] = &[
    (1, "BroadcastStart", "", None),
    (2, "BroadcastStop", "", None),
    (3, "BroadcastPause", "", None),
    (4, "BroadcastAssignAddress", "B", None),
];

/// Core protocol, section 1: commands by the first byte of the data of command 1.
const CORE: &[Row] = &[
    (1, "CoreProtocolVersion", "", UINT),
    (2, "CoreDeviceId", "", TEXT),
    (3, "CoreDeviceVersion", "", UINT),
    (4, "CoreAssignAddress", "B", None),
];

const NOOP: &[Row] = &[(0, "Noop", "", None)];

/// Value of a field or an answer: numbers as on the wire, floats by their bits.
#[derive(Clone, Debug, PartialEq)]
enum Said {
    Number(i64),
    Text(Vec<u8>),
}

/// Address, sub-address, name and parameters. A request without a type of its own is `Other` with all its data.
type Request = (u8, u8, &'static str, Vec<Said>);

/// `00 00 00 00 00 FF | addr | sub | cmd | len | data[len]`
fn packet(bytes: &[u8]) -> Parsed<'_, (u8, u8, u8, &[u8])> {
    let (bytes, _) = tag(&[0, 0, 0, 0, 0, 0xFF][..]).parse(bytes)?;
    all_consuming((be_u8, be_u8, be_u8, length_data(be_u8))).parse(bytes)
}

fn table(address: u8, sub: u8, command: u8) -> &'static [Row] {
    match (address, sub, command) {
        (1, ..) => BROADCAST,
        (_, _, 0) => NOOP,
        (_, 0, _) => MAIN,
        (_, 1..=3, _) => MOTOR,
        (_, 4, _) => CAMERA,
        _ => &[],
    }
}

fn number<T: Into<i64>>(number: T) -> Said {
    Said::Number(number.into())
}

/// One parameter, given by its letter in the tables.
fn parameter(letter: char, data: &[u8]) -> Parsed<'_, Said> {
    match letter {
        'B' => be_u8.map(number).parse(data),
        'U' => be_u16.map(number).parse(data),
        'L' => be_i32.map(number).parse(data),
        'N' => be_u32.map(number).parse(data),
        'F' => be_f32.map(|float| number(float.to_bits())).parse(data),
        _ => verify(rest, |name: &[u8]| (1..=10).contains(&name.len()))
            .map(|name: &[u8]| Said::Text(name.to_vec()))
            .parse(data),
    }
}

fn parameters(letters: &str, mut data: &[u8]) -> Option<Vec<Said>> {
    let mut found = Vec::new();
    for letter in letters.chars() {
        let (behind, said) = parameter(letter, data).ok()?;
        data = behind;
        found.push(said);
    }
    data.is_empty().then_some(found)
}

fn oracle(bytes: &[u8]) -> Option<(Request, Option<&'static Row>)> {
    let (_, (address, sub, command, data)) = packet(bytes).ok()?;
    let (rows, command, data) = match data.split_first() {
        Some((&core, data)) if command == 1 && address != 1 => (CORE, core, data),
        _ => (table(address, sub, command), command, data),
    };
    let known = rows
        .iter()
        .filter(|row| row.0 == command)
        .find_map(|row| parameters(row.2, data).map(|parameters| (row, parameters)));
    Some(match known {
        // Without steps the command is a run. The direction comes first.
        Some((row, parameters)) if row.1 == "MotorMove" && parameters[1] == Said::Number(0) => {
            ((address, sub, "MotorRun", parameters), Some(row))
        }
        Some((row, parameters)) => ((address, sub, row.1, parameters), Some(row)),
        None => ((address, sub, "Other", vec![Said::Text(data.to_vec())]), None),
    })
}

/// The same request as decoded by the crate.
fn ours(bytes: &[u8]) -> Option<Request> {
    let frame = Frame::decode(bytes).ok()?;
    let message = HostMessage::decode(&frame);
    let mut said = Vec::new();
    message.fields(&mut |field: &FieldView<'_>| match field.value {
        // The motor is the sub-address, and not a parameter.
        Value::Unsigned(motor) if field.name == "motor" => assert_eq!(motor, u64::from(frame.sub_address())),
        Value::Unsigned(number) => said.push(Said::Number(i64::try_from(number).unwrap())),
        Value::Signed(number) => said.push(Said::Number(number)),
        Value::Float(number) => said.push(Said::Number(number.to_bits().into())),
        Value::Text(bytes) | Value::Bytes(bytes) => said.push(Said::Text(bytes.to_vec())),
        _ => panic!("unknown field: {}", field.name),
    });
    Some((frame.address().0, frame.sub_address(), message.name(), said))
}

/// `00 (master) | 00 | code | len | [type | value]`, where code 1 is OK. The query decides how the value is read.
fn reply_oracle(types: &[u8], how: How, bytes: &[u8]) -> Option<Said> {
    let (_, (0, 0, 1, data)) = packet(bytes).ok()? else { return None };
    let (value, value_type) =
        verify(be_u8::<_, nom::error::Error<_>>, |found| types.contains(found)).parse(data).ok()?;
    answer(value_type, how, value).ok().map(|(_, said)| said)
}

fn answer(value_type: u8, how: How, value: &[u8]) -> Parsed<'_, Said> {
    match (value_type, how) {
        (0, _) => all_consuming(be_u8).map(number).parse(value),
        (1, _) | (2, Unsigned | Pair) => all_consuming(be_u16).map(number).parse(value),
        (2, _) => all_consuming(be_i16).map(|yes| number(if (0..256).contains(&yes) { yes } else { 1 })).parse(value),
        (3 | 5, _) | (4, Signed) => all_consuming(be_i32).map(number).parse(value),
        (4, _) => all_consuming(be_u32).map(number).parse(value),
        _ => rest.map(|text: &[u8]| Said::Text(text.to_vec())).parse(value),
    }
}

macro_rules! said {
    ($answer:ident; hundredths: $($hundredths:ident)*; numbers: $($number:ident)*) => {
        match $answer {
            $(AnyReply::$hundredths(answer) => number(answer.value.0.raw()),)*
            $(AnyReply::$number(answer) => number(answer.value.0),)*
            AnyReply::Name(answer) | AnyReply::CoreDeviceId(answer) => Said::Text(answer.value.0.to_vec()),
            AnyReply::AltModes(answer) => pair(answer.value.ring.0, answer.value.tip.0),
            AnyReply::LimitSwitches(answer) => pair(answer.value.ring.0, answer.value.tip.0),
            AnyReply::MotorMaxProgramSpeed(answer) => match answer.value {
                SpeedOrSleep::Speed(speed) => number(speed.0.raw()),
                SpeedOrSleep::Sleep(sleep) => number(sleep.0),
                other => panic!("unknown answer: {other}"),
            },
            other => panic!("unknown answer: {other}"),
        }
    };
}

fn pair(ring: u8, tip: u8) -> Said {
    number(u16::from_be_bytes([ring, tip]))
}

fn reply_ours(query: &HostMessage<'_>, bytes: &[u8]) -> Option<Said> {
    let frame = Frame::decode(bytes).ok()?;
    let DeviceMessage::Reply(reply) = DeviceMessage::decode(&frame) else { return None };
    let answer = query.query()?.decode_reply(reply).ok()?;
    Some(said! { answer;
        hundredths: Voltage Current MotorContinuousSpeed MotorContinuousAcceleration;
        numbers: FirmwareVersion RunStatus RunTime Exposing TimingMaster MaxStepRate InputEdge OutBeforeDelay
            OutAfterDelay OutBeforeTime OutAfterTime OutLevel StartDelay ProgramMode PowerCycled JoystickMode PingPong
            MotorEnable MotorBacklash MotorMicrostep MotorDirection MotorMaxStepSpeed MotorEndLimit MotorPosition
            MotorRunning MotorEasing MotorProgramStart MotorProgramStop MotorTravel MotorLeadIn MotorProgramAcceleration
            MotorProgramDeceleration CameraEnable CameraExposing CameraExposureTime CameraFocusTime CameraMaxShots
            CameraExposureDelay CameraFocusWithShutter CameraMirrorUp CameraInterval CoreProtocolVersion
            CoreDeviceVersion
    })
}

/// Checks that both read the packet as the same request, and returns whether the request has a type of its own.
pub(crate) fn agree_on_request(bytes: &[u8]) -> bool {
    let wanted = oracle(bytes).map(|(request, _)| request);
    assert_eq!(ours(bytes), wanted, "{bytes:02x?}");
    wanted.is_some_and(|(_, _, name, _)| name != "Other")
}

/// Checks that both read the packet as the same reply to each query, and returns the number of queries that it can
/// answer.
pub(crate) fn agree_on_reply(bytes: &[u8]) -> usize {
    let parts = [(0, MAIN), (2, MOTOR), (4, CAMERA)];
    let asked = parts.iter().flat_map(|&(sub, rows)| rows.iter().map(move |row| (sub, row.0, None, row)));
    let core = CORE.iter().map(|row| (0, 1, Some(row.0), row));
    let mut answered = 0;
    for (sub, command, data, row) in asked.chain(core) {
        let Some((types, how)) = row.3 else { continue };
        let header = [0, 0, 0, 0, 0, 0xFF, 3, sub, command, u8::from(data.is_some())];
        let query: Vec<u8> = header.into_iter().chain(data).collect();
        let query = HostMessage::decode(&Frame::decode(&query).unwrap());
        assert!(query.query().is_some(), "{query} is a query");
        let wanted = reply_oracle(types, how, bytes);
        assert_eq!(reply_ours(&query, bytes), wanted, "{query} {bytes:02x?}");
        answered += usize::from(wanted.is_some());
    }
    answered
}

/// Number of commands and queries in all tables.
pub(crate) fn rows() -> usize {
    [MAIN, MOTOR, CAMERA, BROADCAST, CORE, NOOP].iter().map(|rows| rows.len()).sum()
}
