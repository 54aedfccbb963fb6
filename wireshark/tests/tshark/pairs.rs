//! Requests and their answers, senders that nothing tells, passwords, and bytes of any kind.

use dmc_proto::message::{Ack, AckCode, MotorMove, MotorStop};
use dmc_proto::{MessageId, MessageType};
use kos_proto::message::{GetMotorInfo, MotorInfo, MotorInfos, NetworkInfo, Password, UserPassword};

use crate::capture::{Capture, IP, Sender, USB, USER, tcp, udp, usb};
use crate::compare::{bytes, scratch, text, vectors};
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

/// Numbers that look random, the same ones in each run.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        usize::try_from(self.0 >> 33).expect("31 bits") % limit
    }
}

/// Bytes of a vector with some changes, after a random begin.
fn changed(random: &mut Random, vector: &[u8]) -> Vec<u8> {
    let mut bytes: Vec<u8> = (0..random.below(4) * random.below(4)).map(|_| random.byte()).collect();
    bytes.extend(vector);
    for _ in 0..random.below(5) {
        let at = random.below(bytes.len());
        match random.below(4) {
            0 => bytes[at] = random.byte(),
            1 => bytes[at] ^= 1 << random.below(8),
            2 => bytes.truncate(at + 1),
            _ => bytes.insert(at, random.byte()),
        }
    }
    bytes
}

impl Random {
    fn byte(&mut self) -> u8 {
        u8::try_from(self.below(256)).expect("a byte")
    }
}

#[test]
#[ignore = "needs tshark"]
fn no_bytes_lead_to_an_error_in_lua() {
    for (protocol, link) in ["dmc", "hoot", "kos"].into_iter().zip(USER) {
        let mut random = Random(0x2545_f491_4f6c_dd1d);
        let mut capture = Capture::new(&[link, IP, USB]);
        let seeds: Vec<_> =
            vectors(&format!("{protocol}.json")).iter().map(|vector| bytes(text(vector, "hex"))).collect();
        for port in 0..1500_u16 {
            let seed = &seeds[random.below(seeds.len())];
            let data = if random.below(10) == 0 {
                (0..=random.below(80)).map(|_| random.byte()).collect()
            } else {
                changed(&mut random, seed)
            };
            let sender = [Sender::Host, Sender::Device][random.below(2)];
            match random.below(if protocol == "kos" { 4 } else { 1 }) {
                0 => capture.record(link, Some(sender).filter(|_| random.below(3) > 0), &data),
                1 => capture.record(IP, None, &udp(sender, 20_000 + port, &data)),
                2 => capture.record(IP, None, &tcp(sender, 20_000 + port, 0, &data)),
                _ => {
                    let mut report = [&[1], &data[..]].concat();
                    report.resize(64, 0);
                    capture.record(USB, None, &usb(sender, &report))
                }
            };
        }
        let file = scratch(&format!("{protocol}-random"));
        capture.write(&file).expect("a file can be written");
        // It fails if the dissector does.
        let (found, _) = dissect(protocol, &file, &[]);
        let faults = found
            .iter()
            .filter(|frame| frame.has_expert("noise") || frame.has_expert("short") || frame.has_expert("unknown"));
        assert!(found.len() > 1000 && faults.count() > 100, "{protocol}: {} frames", found.len());
    }
}
