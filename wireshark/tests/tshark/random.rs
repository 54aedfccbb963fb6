//! Bodies and frames that no vector has: random ones, the same in each run.

use motion_core::wire::{Kind, Messages};

use crate::capture::{Capture, IP, Sender, USB, USER, tcp, udp, usb};
use crate::compare::{Expected, bytes, compare, hoot_request, scratch, text, vectors};
use crate::pdml::dissect;

/// Numbers that look random, the same ones in each run.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        usize::try_from(self.0 >> 33).expect("31 bits") % limit
    }

    fn byte(&mut self) -> u8 {
        u8::try_from(self.below(256)).expect("a byte")
    }
}

/// Body for a message: first of each length with random bytes, of which many are small, because they may count something;
/// then of each length with ones, so that counts agree with lengths; then of random lengths.
fn body(random: &mut Random, round: usize) -> Vec<u8> {
    if (48..96).contains(&round) {
        return vec![1; round - 48];
    }
    let len = if round < 48 { round } else { random.below(140) };
    (0..len)
        .map(|_| if random.below(2) == 0 { random.byte() } else { u8::try_from(random.below(4)).expect("a byte") })
        .collect()
}

/// Makes the frame of a number and a body, and decodes it.
type Seal<'s> = dyn Fn(u32, &[u8]) -> Option<(Vec<u8>, Expected)> + 's;

/// Frames of a protocol for the bodies of all messages of a side, with what the crate decodes of them.
fn bodies(
    kinds: &[Kind],
    rounds: usize,
    capture: &mut Capture,
    link: u16,
    sender: Sender,
    frame: &Seal<'_>,
) -> Vec<(String, usize, Expected)> {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut wanted = Vec::new();
    for kind in kinds {
        for round in 0..rounds {
            let body = body(&mut random, round);
            let Some((bytes, expected)) = frame(kind.number, &body) else { continue };
            let record = capture.record(link, Some(sender), &bytes);
            wanted.push((format!("{} {body:02x?}", kind.name), record, expected));
        }
    }
    wanted
}

fn check(protocol: &str, capture: &Capture, wanted: &[(String, usize, Expected)], headers: &[&str]) {
    let file = scratch(&format!("{protocol}-bodies"));
    capture.write(&file).expect("a file can be written");
    let (found, _) = dissect(protocol, &file, &[]);
    assert_eq!(found.len(), wanted.len(), "frames");
    for ((what, record, expected), frame) in wanted.iter().zip(&found) {
        assert_eq!(*record, frame.record, "{what}");
        let header = headers.iter().find(|header| frame.get(header).is_some()).expect("a header");
        compare(what, expected, frame, header);
    }
    println!("{protocol}: {} bodies", wanted.len());
}

#[test]
#[ignore = "needs tshark"]
fn any_body_of_kos_is_printed_as_it_is_decoded() {
    use kos_proto::{DeviceMessage, Frame, HostMessage};

    let mut capture = Capture::new(&[USER[2]]);
    let mut wanted = Vec::new();
    let seal = |number: u32, body: &[u8]| {
        let [high, low, kind, sub] = number.to_be_bytes();
        let sub = [sub].into_iter().filter(|_| (high, low, kind) == (0, 0x80, 0) || (high, low, kind) == (0, 0x81, 2));
        let data: Vec<u8> = sub.chain(body.iter().copied()).collect();
        let [l0, l1] = u16::try_from(data.len() + 6).expect("a short message").to_be_bytes();
        [&[4, l0, l1, high, low, kind], &data[..]].concat()
    };
    for sender in [Sender::Host, Sender::Device] {
        let kinds = if sender == Sender::Host { HostMessage::ALL } else { DeviceMessage::ALL };
        wanted.extend(bodies(kinds, 112, &mut capture, USER[2], sender, &|number, body| {
            let bytes = seal(number, body);
            let frame = Frame::decode(&bytes).expect("a frame");
            let expected = match sender {
                Sender::Host => Expected::of(sender, HostMessage::decode(&frame)),
                Sender::Device => Expected::of(sender, DeviceMessage::decode(&frame)),
            };
            Some((bytes, expected))
        }));
    }
    check("kos", &capture, &wanted, &["note_id", "action_id", "message_type"]);
}

#[test]
#[ignore = "needs tshark"]
fn any_body_of_dmc_is_printed_as_it_is_decoded() {
    use dmc_proto::{DeviceMessage, Frame, HostMessage, MessageId, MessageType, frame};

    let mut capture = Capture::new(&[USER[0]]);
    let mut wanted = Vec::new();
    for sender in [Sender::Host, Sender::Device] {
        let kinds = if sender == Sender::Host { HostMessage::ALL } else { DeviceMessage::ALL };
        wanted.extend(bodies(kinds, 112, &mut capture, USER[0], sender, &|number, body| {
            let mut out = [0; 256];
            let kind = MessageType(u16::try_from(number).expect("a type"));
            let len = frame::encode(MessageId(1), kind, body, &mut out).expect("a short frame");
            let frame = Frame::decode(&out[..len]).expect("a frame");
            let expected = match sender {
                Sender::Host => Expected::of(sender, HostMessage::decode(&frame)),
                Sender::Device => Expected::of(sender, DeviceMessage::decode(&frame)),
            };
            Some((out[..len].to_vec(), expected))
        }));
    }
    check("dmc", &capture, &wanted, &["length"]);
}

#[test]
#[ignore = "needs tshark"]
fn any_data_of_a_command_of_hoot_is_printed_as_it_is_decoded() {
    use hoot_proto::{Frame, HostMessage, Selector, Table, frame};

    let mut capture = Capture::new(&[USER[1]]);
    let all = [HostMessage::ALL, hoot_proto::beyond::HostMessage::ALL].concat();
    let wanted = bodies(&all, 14, &mut capture, USER[1], Sender::Host, &|number, body| {
        let Selector { table, command, sub_address } = Selector::from_number(number);
        let mut out = [0; 64];
        let (address, command, data) = match table {
            Table::Node => (3, command, body.to_vec()),
            Table::Broadcast => (1, command, body.to_vec()),
            Table::Core => (3, 1, [&[command], body].concat()),
        };
        let len = frame::encode(hoot_proto::Address(address), sub_address, command, &data, &mut out).ok()?;
        let frame = Frame::decode(&out[..len]).expect("a packet");
        Some((out[..len].to_vec(), hoot_request(&frame)))
    });
    check("hoot", &capture, &wanted, &["core_command", "length"]);
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
