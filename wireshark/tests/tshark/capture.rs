//! A capture in a pcapng file.

use std::path::Path;
use std::{fs, io};

/// Link of raw IP packets.
pub(crate) const IP: u16 = 101;
/// Links that the dissectors take: DMC, hoot, and kOS.
pub(crate) const USER: [u16; 3] = [147, 148, 149];
/// Link of USB packets, as Linux captures them.
pub(crate) const USB: u16 = 220;

/// Sender of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sender {
    Host,
    Device,
}

impl Sender {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Host => "host",
            Self::Device => "device",
        }
    }
}

/// Records of one interface for each link.
pub(crate) struct Capture {
    links: Vec<u16>,
    bytes: Vec<u8>,
    records: usize,
}

impl Capture {
    pub(crate) fn new(links: &[u16]) -> Self {
        let mut capture = Self { links: links.to_vec(), bytes: Vec::new(), records: 0 };
        capture.block(0x0a0d_0d0a, &[&0x1a2b_3c4d_u32.to_le_bytes()[..], &[1, 0, 0, 0], &[0xff; 8]].concat());
        for link in links {
            capture.block(1, &[&link.to_le_bytes()[..], &[0; 6]].concat());
        }
        capture
    }

    fn block(&mut self, kind: u32, body: &[u8]) {
        let len = u32::try_from(body.len() + 12).expect("a short block").to_le_bytes();
        self.bytes.extend([&kind.to_le_bytes()[..], &len, body, &len].concat());
    }

    /// Adds a record, a millisecond after the one before. Returns its number, from 1.
    pub(crate) fn record(&mut self, link: u16, sender: Option<Sender>, data: &[u8]) -> usize {
        let interface = self.links.iter().position(|&found| found == link).expect("the link is one of the capture");
        self.records += 1;
        let word = |number: usize| u32::try_from(number).expect("a small number").to_le_bytes();
        let mut body =
            [word(interface), word(0), word(self.records * 1000), word(data.len()), word(data.len())].concat();
        body.extend(data);
        body.resize(body.len().next_multiple_of(4), 0);
        if let Some(sender) = sender {
            // Option 2 has the flags of a packet: 1 is inbound, 2 is outbound.
            body.extend([2, 0, 4, 0, if sender == Sender::Host { 2 } else { 1 }, 0, 0, 0, 0, 0, 0, 0]);
        }
        self.block(6, &body);
        self.records
    }

    pub(crate) fn write(&self, path: &Path) -> io::Result<()> {
        fs::write(path, &self.bytes)
    }
}

/// Packet of UDP between a client at `port` and a device at the port of kOS.
pub(crate) fn udp(sender: Sender, port: u16, data: &[u8]) -> Vec<u8> {
    let length = u16::try_from(data.len() + 8).expect("a short packet").to_be_bytes();
    ip(17, sender, &[&ports(sender, port)[..], &length, &[0; 2], data].concat())
}

/// Segment of TCP between a client at `port` and a device at the port of kOS, with data from `offset` on.
pub(crate) fn tcp(sender: Sender, port: u16, offset: usize, data: &[u8]) -> Vec<u8> {
    let sequence = u32::try_from(offset + 1).expect("a short stream").to_be_bytes();
    let rest = [&[0, 0, 0, 1, 0x50, 0x18, 0xff, 0xff, 0, 0, 0, 0], data].concat();
    ip(6, sender, &[&ports(sender, port)[..], &sequence, &rest].concat())
}

fn ports(sender: Sender, port: u16) -> [u8; 4] {
    let ([a, b], [c, d]) = (port.to_be_bytes(), 5520_u16.to_be_bytes());
    if sender == Sender::Host { [a, b, c, d] } else { [c, d, a, b] }
}

fn ip(protocol: u8, sender: Sender, data: &[u8]) -> Vec<u8> {
    let [high, low] = u16::try_from(data.len() + 20).expect("a short packet").to_be_bytes();
    let (from, to) = if sender == Sender::Host { (1, 2) } else { (2, 1) };
    let header = [0x45, 0, high, low, 0, 0, 0, 0, 64, protocol, 0, 0, 10, 0, 0, from, 10, 0, 0, to];
    [&header[..], data].concat()
}

/// Report of a USB HID device, as Linux captures it.
pub(crate) fn usb(sender: Sender, report: &[u8]) -> Vec<u8> {
    let (event, endpoint) = if sender == Sender::Host { (b'S', 0x01) } else { (b'C', 0x81) };
    let len = u32::try_from(report.len()).expect("a short report").to_le_bytes();
    let mut header = [&[0; 8][..], &[event, 1, endpoint, 5, 1, 0, b'-', 0], &[0; 16], &len, &len].concat();
    header.resize(64, 0);
    header.extend(report);
    header
}
