//! DMC and hoot over serial lines.

use hoot_proto::Query;
use wireshark::view::views;

use crate::capture::{Capture, Sender, USER};
use crate::compare::{Expected, bytes, compare, hoot_request, scratch, text, vectors};
use crate::pdml::dissect;

#[test]
#[ignore = "needs tshark"]
fn dmc_vectors_are_printed_as_they_are_decoded() {
    use dmc_proto::{DeviceMessage, Frame, HostMessage};

    let link = USER[0];
    let mut capture = Capture::new(&[link]);
    let mut wanted = Vec::new();
    for vector in &vectors("dmc.json") {
        let (name, bytes) = (text(vector, "name"), bytes(text(vector, "hex")));
        let sender = if text(vector, "direction") == "request" { Sender::Host } else { Sender::Device };
        // Alone, after noise, and in two pieces.
        let whole = capture.record(link, Some(sender), &bytes);
        let noisy = capture.record(link, Some(sender), &[b"DF\x00\xff", &bytes[..]].concat());
        capture.record(link, Some(sender), &bytes[..bytes.len() - 3]);
        let joined = capture.record(link, Some(sender), &bytes[bytes.len() - 3..]);
        for record in [whole, noisy, joined] {
            let expected = Frame::decode(&bytes).map(|frame| match sender {
                Sender::Host => Expected::of(sender, HostMessage::decode(&frame)),
                Sender::Device => Expected::of(sender, DeviceMessage::decode(&frame)),
            });
            if record == noisy && expected.is_err() {
                continue;
            }
            let expected = expected.unwrap_or(Expected { sender, name: "", views: None, experts: vec!["checksum"] });
            wanted.push((format!("{name}, record {record}"), record, expected, record == noisy));
        }
    }
    let file = scratch("dmc");
    capture.write(&file).expect("a file can be written");
    let (found, _) = dissect("dmc", &file, &[]);
    for (what, record, expected, is_noisy) in &wanted {
        let mut here: Vec<_> = found.iter().filter(|frame| frame.record == *record).collect();
        if *is_noisy {
            assert!(here.remove(0).has_expert("noise"), "{what}");
        }
        let [frame] = here[..] else { panic!("{what}: {here:#?}") };
        compare(what, expected, frame, "length");
    }
    assert!(wanted.len() > 300, "{} records", wanted.len());
}

#[test]
#[ignore = "needs tshark"]
fn hoot_vectors_are_printed_as_they_are_decoded() {
    use hoot_proto::{DeviceMessage, Frame, HostMessage};

    let link = USER[1];
    let mut capture = Capture::new(&[link]);
    let mut wanted = Vec::new();
    for vector in &vectors("hoot.json") {
        let (name, data) = (text(vector, "name"), bytes(text(vector, "hex")));
        let Ok(frame) = Frame::decode(&data) else {
            let record = capture.record(link, None, &data);
            wanted.push((name.to_owned(), record, None, None));
            continue;
        };
        if text(vector, "direction") == "request" {
            // The address 0 is that of the master, so that only the flags of the record tell the sender.
            let told = (frame.address() == hoot_proto::Address::MASTER).then_some(Sender::Host);
            let record = capture.record(link, told, &data);
            wanted.push((name.to_owned(), record, Some(hoot_request(&frame)), None));
            // A record that begins with a break begins a packet, so no record may begin with a break in the data.
            let half = data.len() / 2 + usize::from(data[data.len() / 2..].starts_with(&hoot_proto::frame::BREAK));
            capture.record(link, told, &data[..half]);
            let joined = capture.record(link, told, &data[half..]);
            wanted.push((format!("{name}, joined"), joined, Some(hoot_request(&frame)), None));
            continue;
        }
        // The query gives the answer its meaning.
        let asked = bytes(text(vector, "in_reply_to"));
        let query = Frame::decode(&asked).ok().and_then(|frame| HostMessage::decode(&frame).query());
        if !asked.is_empty() {
            capture.record(link, Some(Sender::Host), &asked);
        }
        let record = capture.record(link, Some(Sender::Device), &data);
        let message = DeviceMessage::decode(&frame);
        let mut expected = Expected::of(Sender::Device, Ok(message));
        if let DeviceMessage::Reply(reply) = message {
            // The response code is a part of the header.
            expected.views = Some(views(&reply).split_off(1));
            expected.experts = if reply.is_ok() { vec![] } else { vec!["refused"] };
            let answer = query.and_then(|query| query.decode_reply(reply).ok());
            wanted.push((name.to_owned(), record, Some(expected), answer.map(|answer| views(&answer).remove(1))));
        } else {
            wanted.push((name.to_owned(), record, Some(expected), None));
        }
    }
    let file = scratch("hoot");
    capture.write(&file).expect("a file can be written");
    let (found, _) = dissect("hoot", &file, &[]);
    let mut answers = 0;
    for (what, record, expected, answer) in &wanted {
        let here: Vec<_> = found.iter().filter(|frame| frame.record == *record).collect();
        let Some(expected) = expected else { continue };
        let [frame] = here[..] else { panic!("{what}: {here:#?}") };
        let is_core = frame.get("core_command").is_some();
        compare(what, expected, frame, if is_core { "core_command" } else { "length" });
        if let Some(answer) = answer {
            let value = frame.items.iter().find(|item| item.name == "value").expect("a value");
            let plain = answer.text.trim_matches('"');
            let is_shown = value.text.contains(plain) && value.text.contains(answer.unit);
            assert!(is_shown, "{what}: {answer:?} is printed as {value:?}");
            assert!(frame.get("request_in").is_some() && frame.get("time").is_some(), "{what}");
            answers += 1;
        }
    }
    assert!(wanted.len() > 150 && answers > 50, "{} records, {answers} answers", wanted.len());
}
