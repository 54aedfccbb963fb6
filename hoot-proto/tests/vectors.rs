//! Conformance vectors. Most are answers of the public firmware of the controller in a simulator.

use hoot_proto::frame::MAX_DATA;
use hoot_proto::message::{Reply, ResponseCode, Value as Wire, ValueType, Voltage};
use hoot_proto::query::{Answer, IntoReply, Profile};
use hoot_proto::{AnyReply, DeviceMessage, Frame, Frames, HostMessage, Item, Query, ReplyError, Strict, Table};
use motion_core::fixed::Centi;
use motion_core::wire::Messages;
use serde_json::{Map, Value, json};

fn vectors() -> Vec<Value> {
    serde_json::from_str(include_str!("../../vectors/hoot.json")).unwrap()
}

fn bytes(hex: &Value) -> Vec<u8> {
    let hex = hex.as_str().unwrap();
    (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect()
}

fn hex(bytes: &[u8]) -> String {
    bytes
        .iter()
        .flat_map(|byte| [byte >> 4, byte & 15])
        .map(|digit| char::from_digit(digit.into(), 16).unwrap())
        .collect()
}

fn of_direction(direction: &str) -> Vec<Value> {
    vectors().into_iter().filter(|vector| vector["direction"] == direction).collect()
}

/// Whether a request has a type of its own, after a second listing: the numbers of section 2, with the data length of
/// each.
#[expect(clippy::match_same_arms, reason = "the order of the tables")]
fn is_typed(packet: &Frame<'_>) -> bool {
    let len = packet.payload().len();
    let motor = (1..=3).contains(&packet.sub_address());
    match (packet.address().0, packet.sub_address(), packet.command()) {
        (1, _, 1..=3) => len == 0,
        (1, _, 4) => len == 1,
        (1, ..) => false,
        (_, _, 0) => len == 0,
        (_, _, 1) => matches!(packet.payload(), [1..=3] | [4, _]),
        (_, 0, 2..=5 | 10 | 100..=121) => len == 0,
        (_, 0, 6 | 8 | 9 | 12 | 14 | 19 | 22 | 23 | 24) => len == 1,
        (_, 0, 7) => (1..=10).contains(&len),
        (_, 0, 11 | 13 | 15..=18) => len == 2,
        (_, 0, 20 | 21) => len == 4,
        (_, _, 4 | 9..=12 | 23..=27 | 100..=117) if motor => len == 0,
        (_, _, 2 | 3 | 6 | 8 | 18) if motor => len == 1,
        (_, _, 5 | 7) if motor => len == 2,
        (_, _, 19) if motor => len == 2 || len == 4,
        (_, _, 13 | 14 | 16 | 17 | 20..=22) if motor => len == 4,
        (_, _, 15) if motor => len == 5,
        (_, 4, 3 | 100..=108) => len == 0,
        (_, 4, 2 | 8 | 9) => len == 1,
        (_, 4, 5..=7) => len == 2,
        (_, 4, 4 | 10) => len == 4,
        _ => false,
    }
}

/// Compares the keys of `fields` that belong to the packet, and returns the others.
fn check_frame(frame: &Frame<'_>, fields: &Value, name: &str) -> Map<String, Value> {
    let mut others = fields.as_object().unwrap().clone();
    let mut same = |key: &str, found: Value| {
        if let Some(wanted) = others.remove(key) {
            assert_eq!(wanted, found, "{key} of {name}");
        }
    };
    same("address", frame.address().0.into());
    same("sub_address", frame.sub_address().into());
    same("command", frame.command().into());
    same("length", frame.payload().len().into());
    same("data", hex(frame.payload()).into());
    same("broadcast", (frame.request().0.table == Table::Broadcast).into());
    others
}

#[test]
fn requests_of_the_vectors_survive_the_round_trip() {
    let (mut typed, mut other, mut malformed) = (0, 0, 0);
    for vector in of_direction("request") {
        let (name, sent) = (vector["name"].as_str().unwrap(), bytes(&vector["hex"]));
        let fields = &vector["fields"];
        if fields["malformed"] == true {
            malformed += 1;
            assert_eq!(
                strict_frames(&sent),
                fields.get("frames").map_or(0, |frames| frames.as_u64().unwrap()),
                "{name}"
            );
            continue;
        }
        assert_eq!(strict_frames(&sent), 1, "{name}");
        let frame = Frame::decode(&sent).unwrap();
        assert_eq!(check_frame(&frame, fields, name), Map::new(), "keys of {name} that were not checked");

        let message = HostMessage::decode(&frame);
        assert_eq!(message.selector(), frame.request().0, "{name}");
        if is_typed(&frame) {
            typed += 1;
            assert_ne!(message.name(), "Other", "{name}");
        } else {
            other += 1;
            assert_eq!(message.name(), "Other", "{name}");
            assert_eq!(serde_json::to_value(message).unwrap(), json!({ "data": hex(frame.request().1) }), "{name}");
        }

        let mut out = [0; 42];
        assert_eq!(message.encode_into(frame.address(), &mut out), Ok(sent.len()), "{name}");
        assert_eq!((&out[..sent.len()], message.encoded_len()), (&sent[..], sent.len()), "{name}");

        // Packets that the node sent and passed on.
        for key in ["node_reply_hex", "node_forwarded_hex"] {
            replies(&bytes(vector.get(key).unwrap_or(&json!(""))));
        }
    }
    assert_eq!((typed, other, malformed), (151, 13, 2));
}

/// Number of packets that a node finds if the line then falls silent.
fn strict_frames(sent: &[u8]) -> u64 {
    let mut frames = motion_core::stream::Frames::<Strict, 84>::new();
    assert_eq!(frames.push(sent), sent.len());
    frames.gap();
    let mut found = 0;
    while let Some(item) = frames.next() {
        found += u64::from(matches!(item, Item::Frame(_)));
    }
    found
}

/// Checks that consecutive packets survive the round trip.
fn replies(sent: &[u8]) {
    let mut frames = Frames::<84>::new();
    assert_eq!(frames.push(sent), sent.len());
    while let Some(item) = frames.next() {
        let Item::Frame(frame) = item else { panic!("{item:?}") };
        let mut out = [0; 42];
        let len = DeviceMessage::decode(&frame).encode_into(&mut out).unwrap();
        assert_eq!(out[..len], *frame.bytes());
    }
    assert_eq!(frames.held(), 0);
}

#[test]
fn responses_of_the_vectors_survive_the_round_trip() {
    let (mut answers, mut refused, mut others) = (0, 0, 0);
    for vector in of_direction("response") {
        let (name, sent) = (vector["name"].as_str().unwrap(), bytes(&vector["hex"]));
        let frame = Frame::decode(&sent).unwrap();
        let mut fields = check_frame(&frame, &vector["fields"], name);
        let message = DeviceMessage::decode(&frame);
        let DeviceMessage::Reply(reply) = message else { panic!("{name} is not a reply: {message}") };

        let mut out = [0; 42];
        assert_eq!(message.encode_into(&mut out), Ok(sent.len()), "{name}");
        assert_eq!((&out[..sent.len()], message.encoded_len()), (&sent[..], sent.len()), "{name}");

        let shown = serde_json::to_value(message).unwrap();
        for key in ["response_code", "value_type", "value"] {
            if let Some(wanted) = fields.remove(key) {
                assert_eq!(shown[key], wanted, "{key} of {name}");
            }
        }
        if let Some(wanted) = fields.remove("value_type_name") {
            let found = reply.value_type().unwrap().name().unwrap();
            assert_eq!(found, wanted.as_str().unwrap().to_uppercase(), "{name}");
        }

        let asked = vector.get("in_reply_to").map(bytes).unwrap_or_default();
        let request = Frame::decode(&asked).map(|frame| HostMessage::decode(&frame));
        match request.ok().and_then(|request| request.query()) {
            None => others += 1,
            Some(query) if !reply.is_ok() => {
                refused += 1;
                assert_eq!(query.decode_reply(reply), Err(ReplyError::Node { code: reply.code }), "{name}");
            }
            Some(query) => {
                answers += 1;
                let answer = query.decode_reply(reply).unwrap();
                assert_eq!(
                    u64::from(answer.value_type().0),
                    vector["fields"]["value_type"].as_u64().unwrap(),
                    "{name}"
                );
                check_answer(answer, &vector["fields"], name);
                let mut data = [0; MAX_DATA];
                assert_eq!(query.reply(answer, &mut data), Ok(reply), "{name}");
            }
        }
    }
    assert_eq!((answers, refused, others), (100, 4, 99));
}

/// Checks that the answer to the query has the values of the vector.
fn check_answer(answer: AnyReply<'_>, fields: &Value, name: &str) {
    let found = match answer.value() {
        Wire::Byte(number) => json!(number),
        Wire::UInt(number) => json!(number),
        Wire::Int(number) => json!(number),
        Wire::Long(number) => json!(number),
        Wire::ULong(number) => json!(number),
        Wire::Float(number) => json!(number.raw()),
        Wire::String(text) => json!(core::str::from_utf8(text.0).unwrap()),
        other => panic!("{name}: {other:?}"),
    };
    assert_eq!(found, *fields.get("raw_i32").unwrap_or(&fields["value"]), "{name}");

    let hundredths = match answer {
        AnyReply::Voltage(Answer { value, .. }) => Some(value.0),
        AnyReply::Current(Answer { value, .. }) => Some(value.0),
        AnyReply::MotorContinuousSpeed(Answer { value, .. }) => Some(value.0),
        AnyReply::MotorContinuousAcceleration(Answer { value, .. }) => Some(value.0),
        _ => None,
    };
    assert_eq!(json!(hundredths.map(Centi::to_f64)), fields["value_fixed_div100"], "{name}");
    let reliable = [Profile::LIBRARY_2014_09_25, Profile::UNKNOWN].map(|profile| answer.is_reliable(profile));
    assert_eq!(reliable, [true, hundredths.is_none()], "{name}");
}

#[test]
fn hundredths_of_newer_firmware_are_decoded() {
    let mut seen = 0;
    for vector in of_direction("response").iter().filter(|vector| vector["fields"].get("rule").is_some()) {
        seen += 1;
        let sent = bytes(&vector["hex"]);
        let DeviceMessage::Reply(reply) = DeviceMessage::decode(&Frame::decode(&sent).unwrap()) else { panic!() };
        let answer = Voltage {}.decode_reply(reply).unwrap();
        assert_eq!(json!(f64::from(answer.value.0.0) / 100.0), vector["fields"]["decoded"]);
        assert!(answer.is_reliable(Profile::UNKNOWN));
        let mut data = [0; MAX_DATA];
        assert_eq!(Voltage {}.reply(Voltage {}.answer(answer.value, Profile::V033), &mut data), Ok(reply));
    }
    assert_eq!(seen, 4);
}

#[test]
fn hundredths_may_be_long_as_the_sheet_says() {
    let reply = Reply { code: ResponseCode::OK, data: &[3, 0, 0, 4, 0xCD] };
    let answer = Voltage {}.decode_reply(reply).unwrap();
    assert_eq!((answer.value.0.raw(), answer.value_type()), (1229, ValueType::LONG));
    assert_eq!(Voltage {}.reply(answer, &mut [0; MAX_DATA]), Ok(reply));
}

#[test]
fn a_finite_move_and_a_run_are_two_commands() {
    let named = |wanted: &str| {
        let vector = of_direction("request").into_iter().find(|vector| vector["name"] == wanted).unwrap();
        bytes(&vector["hex"])
    };
    let (finite, run) = (named("motor1 set 15 move dir1 1000"), named("motor1 set 15 move dir0 0 (continuous)"));
    let decode = |sent: &[u8]| HostMessage::decode(&Frame::decode(sent).unwrap()).to_string();
    assert_eq!(decode(&finite), "MotorMove { motor: 1, direction: 1, steps: 1000 steps }");
    assert_eq!(decode(&run), "MotorRun { motor: 1, direction: 0, steps: 0 steps }");
}

#[test]
fn numbers_of_broadcasts_are_not_those_of_the_controller() {
    let of = |address: u8, command: u8| {
        let sent = [0, 0, 0, 0, 0, 0xFF, address, 0, command, 0];
        HostMessage::decode(&Frame::decode(&sent).unwrap()).name()
    };
    assert_eq!([2, 3, 4].map(|command| of(3, command)), ["Start", "Pause", "Stop"]);
    assert_eq!([1, 2, 3].map(|command| of(1, command)), ["BroadcastStart", "BroadcastStop", "BroadcastPause"]);
}

#[test]
fn two_replies_to_one_request_are_two_packets() {
    let vector =
        of_direction("request").into_iter().find(|vector| vector["name"] == "motor1 query 107 running").unwrap();
    let sent = bytes(&vector["node_reply_hex"]);
    let mut frames = Frames::<84>::new();
    assert_eq!(frames.push(&sent), sent.len());
    let mut lens = Vec::new();
    while let Some(Item::Frame(frame)) = frames.next() {
        lens.push(frame.payload().len());
    }
    assert_eq!(lens, [2, 5], "the motor runs, and the reply to the next query, which was not asked");
}
