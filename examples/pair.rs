//! Reader of a capture of a DMC line: it pairs each request of Dragonframe with the answer of the controller, and writes one line
//! of JSON for each pair.
//!
//! Run it with `cargo run --example pair`. It reads a capture of both directions, `captures/dmc-move.txt`. A program that listens
//! on two serial ports does the same with what they give.

use std::collections::HashMap;
use std::error::Error;
use std::io::{self, Write};

use dmc_proto::{Device, DeviceMessage, Frames, Host, HostMessage, Item, MessageId, Owned};
use serde::Serialize;

/// Line of the output.
#[derive(Serialize)]
struct Pair {
    id: MessageId,
    request: Owned<Host>,
    answer: Owned<Device>,
}

/// Writes the pairs of a capture. Each line of it is a direction, `>` or `<`, and bytes in hex.
pub(crate) fn pairs(capture: &str, out: &mut impl Write) -> Result<(), Box<dyn Error>> {
    // Each direction is a stream of its own.
    let (mut from_host, mut from_device): (Box<Frames>, Box<Frames>) = (Box::default(), Box::default());
    let mut requests = HashMap::new();
    for line in capture.lines() {
        let words = line.split("//").next().unwrap_or_default();
        let is_host = words.starts_with('>');
        let bytes = words.split_whitespace().filter(|word| !matches!(*word, ">" | "<"));
        let bytes = bytes.map(|word| u8::from_str_radix(word, 16)).collect::<Result<Vec<u8>, _>>()?;
        let frames = if is_host { &mut from_host } else { &mut from_device };
        let mut rest = &bytes[..];
        while let Some(item) = frames.next_from(&mut rest) {
            // Noise, damaged frames, and frames that are no message are left out.
            let Item::Frame(frame) = item else { continue };
            if is_host {
                let Ok(request) = HostMessage::decode(&frame) else { continue };
                requests.insert(frame.id(), Owned::<Host>::new(&request)?);
            } else if let (Some(request), Ok(answer)) = (requests.remove(&frame.id()), DeviceMessage::decode(&frame)) {
                let answer = Owned::<Device>::new(&answer)?;
                serde_json::to_writer(&mut *out, &Pair { id: frame.id(), request, answer })?;
                writeln!(out)?;
            }
        }
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    pairs(include_str!("captures/dmc-move.txt"), &mut io::stdout().lock())
}
