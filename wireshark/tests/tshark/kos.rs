//! kOS over TCP, UDP, USB and as a plain stream.

use kos_proto::{DeviceMessage, Frame, HostMessage};

use crate::capture::{Capture, IP, Sender, USB, USER, tcp, udp, usb};
use crate::compare::{Expected, bytes, compare, scratch, text, vectors};
use crate::pdml::dissect;

/// Frames in the bytes of one sender; `None` if a frame is damaged or cut off.
fn expected(sender: Sender, mut bytes: &[u8]) -> (Vec<Expected>, bool) {
    let mut all = Vec::new();
    loop {
        let len = bytes.get(1..3).map_or(0, |len| usize::from(u16::from_be_bytes([len[0], len[1]])));
        let Some(Ok(frame)) = bytes.get(..len).map(Frame::decode) else { return (all, bytes.is_empty()) };
        all.push(match sender {
            Sender::Host => Expected::of(sender, HostMessage::decode(&frame)),
            Sender::Device => Expected::of(sender, DeviceMessage::decode(&frame)),
        });
        bytes = &bytes[len..];
    }
}

#[test]
#[ignore = "needs tshark"]
fn kos_vectors_are_printed_as_they_are_decoded() {
    let mut capture = Capture::new(&[IP, USB, USER[2]]);
    let mut wanted = Vec::new();
    for (vector, port) in vectors("kos.json").iter().zip(10_000..) {
        let (name, bytes) = (text(vector, "name"), bytes(text(vector, "hex")));
        let sender = if text(vector, "direction") == "host" { Sender::Host } else { Sender::Device };
        let report = kos_proto::usb::decode(&bytes).ok().filter(|_| text(vector, "kind").starts_with("usb"));
        if let Some(frame) = report {
            for (link, data) in [(USB, usb(sender, &bytes)), (USER[2], bytes.clone())] {
                let record = capture.record(link, Some(sender).filter(|_| link != USB), &data);
                wanted.push((format!("{name}, link {link}"), record, expected(sender, frame.bytes()).0, true));
            }
            continue;
        }
        // Each message is cut in two, so that it has to be put together again.
        let half = bytes.len() / 2;
        capture.record(IP, None, &tcp(sender, port, 0, &bytes[..half]));
        let record = capture.record(IP, None, &tcp(sender, port, half, &bytes[half..]));
        let (frames, is_whole) = expected(sender, &bytes);
        if is_whole {
            wanted.push((format!("{name}, TCP"), record, frames, true));
        }
        let others = [(IP, None, udp(sender, port, &bytes)), (USER[2], Some(sender), bytes.clone())];
        for (link, told, data) in others {
            let record = capture.record(link, told, &data);
            let (frames, is_whole) = expected(sender, &bytes);
            wanted.push((format!("{name}, link {link}"), record, frames, is_whole));
        }
    }
    let file = scratch("kos");
    capture.write(&file).expect("a file can be written");
    let (found, _) = dissect("kos", &file, &[]);
    for (what, record, expected, is_whole) in &wanted {
        let first = if what.ends_with("TCP") { record - 1 } else { *record };
        let here: Vec<_> = found.iter().filter(|frame| (first..=*record).contains(&frame.record)).collect();
        let (frames, faults): (Vec<_>, Vec<_>) = here.into_iter().partition(|frame| frame.get("message").is_some());
        assert_eq!(frames.len(), expected.len(), "{what}: {frames:#?}");
        assert_eq!(faults.is_empty(), *is_whole, "{what}: {faults:#?}");
        assert!(faults.iter().all(|fault| fault.has_expert("noise") || fault.has_expert("cut")), "{what}");
        for (expected, found) in expected.iter().zip(frames) {
            let last = ["note_id", "action_id"].into_iter().find(|name| found.get(name).is_some());
            compare(what, expected, found, last.unwrap_or("message_type"));
        }
    }
    assert!(wanted.len() > 400, "{} records", wanted.len());
}
