//! Law 13: an independent decoder, written with nom from the specification alone, reads the same.

use hoot_proto::{AnyReply, DeviceMessage, Frame, HostMessage, Query};
use nom::Parser;
use nom::bytes::complete::tag;
use nom::combinator::{all_consuming, eof, rest, value, verify};
use nom::multi::length_data;
use nom::number::complete::{be_f32, be_i16, be_i32, be_u8, be_u32};
use proptest::prelude::*;
use serde_json::Value;

type Parsed<'a, T> = nom::IResult<&'a [u8], T>;

/// A request, in the oracle's own words.
#[derive(Clone, Debug, PartialEq)]
enum Request {
    Start,
    Pause,
    Stop,
    SetName(Vec<u8>),
    RunStatus,
    Name,
    Voltage,
    MotorStop(u8),
    Speed(u8, u32),
    Move(u8, u8, u32),
    Run(u8, u8),
    Position(u8),
    Running(u8),
    AllStart(u8),
    AllStop(u8),
    AllPause(u8),
    AllAddress(u8, u8),
    Unknown(u8, u8, u8, Vec<u8>),
}

/// `00 00 00 00 00 FF | addr | sub | cmd | len | data[len]`
fn packet(bytes: &[u8]) -> Parsed<'_, (u8, u8, u8, &[u8])> {
    let (bytes, _) = tag(&[0, 0, 0, 0, 0, 0xFF][..]).parse(bytes)?;
    all_consuming((be_u8, be_u8, be_u8, length_data(be_u8))).parse(bytes)
}

fn known(address: u8, sub: u8, command: u8, data: &[u8]) -> Parsed<'_, Request> {
    let nothing = |request: Request| move |data| value(request.clone(), eof).parse(data);
    let motor = (1..=3).contains(&sub);
    match (address, sub, command) {
        (1, _, 1) => nothing(Request::AllStart(sub))(data),
        (1, _, 2) => nothing(Request::AllStop(sub))(data),
        (1, _, 3) => nothing(Request::AllPause(sub))(data),
        (1, _, 4) => all_consuming(be_u8).map(|new| Request::AllAddress(sub, new)).parse(data),
        (1, ..) => unknown(data),
        (_, 0, 2) => nothing(Request::Start)(data),
        (_, 0, 3) => nothing(Request::Pause)(data),
        (_, 0, 4) => nothing(Request::Stop)(data),
        (_, 0, 7) => verify(rest, |name: &[u8]| matches!(name.len(), 1..=10))
            .map(|name: &[u8]| Request::SetName(name.to_vec()))
            .parse(data),
        (_, 0, 101) => nothing(Request::RunStatus)(data),
        (_, 0, 105) => nothing(Request::Name)(data),
        (_, 0, 107) => nothing(Request::Voltage)(data),
        (_, _, 4) if motor => nothing(Request::MotorStop(sub))(data),
        (_, _, 13) if motor => all_consuming(be_f32).map(|speed| Request::Speed(sub, speed.to_bits())).parse(data),
        (_, _, 15) if motor => all_consuming((be_u8, be_u32))
            .map(|(way, steps)| if steps == 0 { Request::Run(sub, way) } else { Request::Move(sub, way, steps) })
            .parse(data),
        (_, _, 106) if motor => nothing(Request::Position(sub))(data),
        (_, _, 107) if motor => nothing(Request::Running(sub))(data),
        _ => unknown(data),
    }
}

fn unknown<T>(data: &[u8]) -> Parsed<'_, T> {
    Err(nom::Err::Error(nom::error::Error::new(data, nom::error::ErrorKind::Alt)))
}

fn oracle(bytes: &[u8]) -> Option<Request> {
    let (_, (address, sub, command, data)) = packet(bytes).ok()?;
    Some(
        known(address, sub, command, data)
            .map_or(Request::Unknown(address, sub, command, data.to_vec()), |(_, request)| request),
    )
}

/// What the crate reads, in the oracle's words.
fn ours(bytes: &[u8]) -> Option<Request> {
    let frame = Frame::decode(bytes).ok()?;
    let message = HostMessage::decode(&frame);
    Some(match message {
        HostMessage::Start(_) => Request::Start,
        HostMessage::Pause(_) => Request::Pause,
        HostMessage::Stop(_) => Request::Stop,
        HostMessage::SetName(message) => Request::SetName(message.name.as_bytes().to_vec()),
        HostMessage::RunStatus(_) => Request::RunStatus,
        HostMessage::Name(_) => Request::Name,
        HostMessage::Voltage(_) => Request::Voltage,
        HostMessage::MotorStop(message) => Request::MotorStop(message.motor.get()),
        HostMessage::MotorSetContinuousSpeed(message) => Request::Speed(message.motor.get(), message.speed.0.to_bits()),
        HostMessage::MotorMove(message) => Request::Move(message.motor.get(), message.direction.0, message.steps.0),
        HostMessage::MotorRun(message) => Request::Run(message.motor.get(), message.direction.0),
        HostMessage::MotorPosition(message) => Request::Position(message.motor.get()),
        HostMessage::MotorRunning(message) => Request::Running(message.motor.get()),
        HostMessage::BroadcastStart(message) => Request::AllStart(message.sub_address.0),
        HostMessage::BroadcastStop(message) => Request::AllStop(message.sub_address.0),
        HostMessage::BroadcastPause(message) => Request::AllPause(message.sub_address.0),
        HostMessage::BroadcastAssignAddress(message) => Request::AllAddress(message.sub_address.0, message.address.0),
        HostMessage::Other(other) => {
            let selector = message.selector();
            assert_eq!(selector.broadcast, frame.address().0 == 1);
            Request::Unknown(frame.address().0, selector.sub_address, selector.command, other.payload().to_vec())
        }
        _ => panic!("a message that the oracle does not know: {message}"),
    })
}

/// What a reply says, in the oracle's own words: the number on the wire, or the text.
#[derive(Debug, PartialEq)]
enum Said<'a> {
    Number(i64),
    Text(&'a [u8]),
}

/// `00 (master) | 00 | code | len | [type | value]`, code 1 is OK; then by the query.
fn reply_oracle<'a>(query: &Request, bytes: &'a [u8]) -> Option<Said<'a>> {
    let (_, (0, 0, 1, data)) = packet(bytes).ok()? else { return None };
    answer(query, data).map(|(_, said)| said).ok()
}

fn answer<'a>(query: &Request, data: &'a [u8]) -> Parsed<'a, Said<'a>> {
    let (value, value_type) = be_u8(data)?;
    match (query, value_type) {
        (Request::RunStatus | Request::Running(_), 0) => {
            all_consuming(be_u8).map(|number| Said::Number(number.into())).parse(value)
        }
        // A promoted byte, in some builds; what does not fit a byte is a yes.
        (Request::Running(_), 2) => all_consuming(be_i16)
            .map(|yes| Said::Number(if (0..256).contains(&yes) { yes.into() } else { 1 }))
            .parse(value),
        (Request::Name, 6) => rest.map(Said::Text).parse(value),
        // Hundredths, with sign, whether they come as type 4 or 5; a position as Long or as ULong.
        (Request::Voltage, 4 | 5) | (Request::Position(_), 3 | 4) => {
            all_consuming(be_i32).map(|number| Said::Number(number.into())).parse(value)
        }
        _ => unknown(value),
    }
}

fn reply_ours<'a>(query: &HostMessage<'_>, bytes: &'a [u8]) -> Option<Said<'a>> {
    let frame = Frame::decode(bytes).ok()?;
    let DeviceMessage::Reply(reply) = DeviceMessage::decode(&frame) else { return None };
    Some(match query.query()?.decode_reply(reply).ok()? {
        AnyReply::RunStatus(answer) => Said::Number(answer.value.0.into()),
        AnyReply::Name(answer) => Said::Text(answer.value.0),
        AnyReply::Voltage(answer) => Said::Number(answer.value.0.0.into()),
        AnyReply::MotorRunning(answer) => Said::Number(answer.value.0.into()),
        AnyReply::MotorPosition(answer) => Said::Number(answer.value.0.into()),
        other => panic!("a reply that the oracle does not know: {other}"),
    })
}

fn queries() -> [Vec<u8>; 5] {
    [(0, 101), (0, 105), (0, 107), (2, 106), (3, 107)]
        .map(|(sub, command)| vec![0, 0, 0, 0, 0, 0xFF, 3, sub, command, 0])
}

/// Both read the packet as a request, and as the reply to each query.
fn agree(bytes: &[u8]) {
    assert_eq!(ours(bytes), oracle(bytes), "{bytes:02x?}");
    for query in queries() {
        let frame = Frame::decode(&query).unwrap();
        let wanted = reply_oracle(&oracle(&query).unwrap(), bytes);
        assert_eq!(reply_ours(&HostMessage::decode(&frame), bytes), wanted, "{query:02x?} {bytes:02x?}");
    }
}

#[test]
fn vectors() {
    let vectors: Vec<Value> = serde_json::from_str(include_str!("../../vectors/hoot.json")).unwrap();
    let (mut said, mut known) = (0, 0);
    for vector in &vectors {
        let hex = vector["hex"].as_str().unwrap();
        let bytes: Vec<u8> =
            (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect();
        agree(&bytes);
        known += usize::from(!matches!(oracle(&bytes), None | Some(Request::Unknown(..))));
        said += queries().iter().filter(|query| reply_oracle(&oracle(query).unwrap(), &bytes).is_some()).count();
    }
    assert_eq!((known, said), (29, 151));
}

proptest! {
    #[test]
    fn any_packet(
        header in (prop_oneof![Just(0_u8), Just(1), Just(3), any::<u8>()], prop_oneof![0_u8..5, any::<u8>()], prop_oneof![0_u8..16, 100_u8..109, any::<u8>()]),
        data in proptest::collection::vec(prop_oneof![Just(0_u8), 0_u8..8, any::<u8>()], 0..14),
        spoilt in 0..10_u8,
        at in any::<prop::sample::Index>(),
        byte in any::<u8>(),
    ) {
        let len = u8::try_from(data.len()).unwrap();
        let mut bytes = [&[0, 0, 0, 0, 0, 0xFF, header.0, header.1, header.2, len], &data[..]].concat();
        match spoilt {
            0 => *at.get_mut(&mut bytes) = byte,
            1 => bytes.truncate(at.index(bytes.len())),
            2 => bytes.push(byte),
            _ => {}
        }
        agree(&bytes);
    }

    #[test]
    fn any_reply(
        code in 0_u8..3,
        value_type in 0_u8..8,
        value in proptest::collection::vec(any::<u8>(), 0..12),
    ) {
        let len = u8::try_from(value.len() + 1).unwrap();
        agree(&[&[0, 0, 0, 0, 0, 0xFF, 0, 0, code, len, value_type], &value[..]].concat());
    }
}
