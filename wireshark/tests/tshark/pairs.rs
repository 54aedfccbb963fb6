//! Requests and their answers, senders that nothing tells, and passwords.

use dmc_proto::message::{Ack, AckCode, MotorMove, MotorStop};
use dmc_proto::{MessageId, MessageType};
use kos_proto::message::{GetMotorInfo, MotorInfo, MotorInfos, NetworkInfo, Password, UserPassword};

use crate::capture::{Capture, Sender, USER};
use crate::compare::{bytes, scratch};
use crate::pdml::{Frame, dissect};

/// Frames in the records of one link.
fn frames(protocol: &str, link: u16, records: &[(Option<Sender>, Vec<u8>)], options: &[&str]) -> (Vec<Frame>, String) {
    let mut capture = Capture::new(&[link]);
    for (sender, data) in records {
        capture.record(link, *sender, data);
    }
    let file = scratch(&format!("{protocol}-{}-{}", records.len(), options.len()));
    capture.write(&file).expect("a file can be written");
    dissect(protocol, &file, options)
}

/// Frame of DMC.
fn dmc<'m>(message: impl Into<dmc_proto::HostMessage<'m>>, id: u32) -> Vec<u8> {
    let mut out = [0; 64];
    let len = message.into().encode_into(MessageId(id), &mut out).expect("a short message");
    out[..len].to_vec()
}

/// Frame of DMC from a device.
fn ack(of: u16, code: AckCode, id: u32) -> Vec<u8> {
    let mut out = [0; 64];
    let ack = dmc_proto::DeviceMessage::from(Ack::new(MessageType(of), code));
    let len = ack.encode_into(MessageId(id), &mut out).expect("a short message");
    out[..len].to_vec()
}

/// Message of kOS.
fn kos<'m>(message: impl Into<kos_proto::HostMessage<'m>>) -> Vec<u8> {
    let mut out = [0; 64];
    let len = message.into().encode_into(&mut out).expect("a short message");
    out[..len].to_vec()
}

/// Message of kOS from a device.
fn kos_device<'m>(message: impl Into<kos_proto::DeviceMessage<'m>>) -> Vec<u8> {
    let mut out = [0; 64];
    let len = message.into().encode_into(&mut out).expect("a short message");
    out[..len].to_vec()
}

#[test]
#[ignore = "needs tshark"]
fn dmc_answers_belong_to_the_request_with_their_id() {
    let stop = || dmc(MotorStop::default(), 2);
    // The first record has two frames. Nothing tells the sender, except that only devices acknowledge.
    let records = [
        (None, [dmc(MotorMove::default(), 1), stop()].concat()),
        (None, ack(0x0032, AckCode::OK, 2)),
        (None, ack(0x0031, AckCode::ERR_RANGE, 1)),
        (None, ack(0x0031, AckCode::OK, 9)),
        (Some(Sender::Device), [&dmc_proto_positions()[..], &[0xff]].concat()),
    ];
    let (found, _) = frames("dmc", USER[0], &records, &[]);
    let senders: Vec<_> = found.iter().filter_map(|frame| frame.get("sender")).collect();
    assert_eq!(senders, ["host", "host", "device", "device", "device", "device"]);
    let link = |frame: usize, name| found[frame].get(name);
    assert_eq!((link(0, "response_in"), link(1, "response_in")), (Some("3"), Some("2")));
    assert_eq!((link(2, "request_in"), link(3, "request_in")), (Some("1"), Some("1")));
    assert_eq!(link(2, "time"), Some("0.001000000"));
    let faults: Vec<_> = found.iter().map(|frame| (frame.has_expert("refused"), frame.has_expert("unasked"))).collect();
    let (refused, unasked) = ((true, false), (false, true));
    assert_eq!(
        faults,
        [(false, false), (false, false), (false, false), refused, unasked, (false, false), (false, false)]
    );
    assert!(found[6].has_expert("noise"));
}

/// Positions that nobody asked for.
fn dmc_proto_positions() -> Vec<u8> {
    bytes("444600000000340008 00d0070000ffffffff6ff1".replace(' ', "").as_str())
}

#[test]
#[ignore = "needs tshark"]
fn a_question_of_kos_has_all_messages_of_its_answer() {
    let info = |more| kos_device(MotorInfo { more, motors: MotorInfos::New(&[]), tail: &[] });
    let records = [
        (None, info(false)),
        (None, kos(GetMotorInfo::default())),
        (None, info(true)),
        (None, info(false)),
        (None, info(false)),
        (None, kos_device(NetworkInfo::default())),
    ];
    let (found, _) = frames("kos", USER[2], &records, &[]);
    let requests: Vec<_> = found.iter().map(|frame| frame.get("request_in")).collect();
    assert_eq!(requests, [None, None, Some("2"), Some("2"), Some("2"), None]);
    assert_eq!(found[1].get("response_in"), Some("3"));
    let unasked: Vec<_> = found.iter().map(|frame| (frame.has_expert("unasked"), frame.has_expert("again"))).collect();
    let (none, again) = ((false, false), (false, true));
    assert_eq!(unasked, [(true, false), none, none, none, again, none]);
}

#[test]
#[ignore = "needs tshark"]
fn passwords_are_shown_only_if_they_are_asked_for() {
    let record = [(Some(Sender::Host), kos(UserPassword { password: Password(b"opensesame"), tail: &[] }))];
    let (_, hidden) = frames("kos", USER[2], &record, &[]);
    assert!(hidden.contains("hidden, 10 bytes"));
    let hex = b"opensesame".map(|byte| format!("{byte:02x}")).concat();
    assert!(!hidden.contains("opensesame") && !hidden.contains(&hex));
    let (found, _) = frames("kos", USER[2], &record, &["-o", "kos.secrets:TRUE"]);
    assert_eq!(found[0].get("password"), Some("opensesame"));
}

#[test]
#[ignore = "needs tshark"]
fn a_preference_tells_the_sender_that_nothing_else_tells() {
    let records = [(None, dmc(MotorStop::default(), 1)), (Some(Sender::Host), dmc(MotorStop::default(), 1))];
    let (found, _) = frames("dmc", USER[0], &records, &["-o", "dmc.side:device"]);
    assert_eq!(found.iter().map(|frame| frame.get("sender")).collect::<Vec<_>>(), [Some("device"), Some("host")]);
}
