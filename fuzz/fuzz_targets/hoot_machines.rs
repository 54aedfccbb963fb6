//! hoot: any events for a master and a node, alone and with each other on a faulty line, in any order.
//!
//! Input: options, then steps; see `fuzz::machines`.

#![no_main]

use fuzz::fuzz_world;
use fuzz::machines::{Bytes, Line, Tokens, Watched};
use hoot_proto::device::{self, Command as AtNode, Contact, DeviceMachine, Port, Quirks};
use hoot_proto::frame::MAX_FRAME;
use hoot_proto::host::{self, Command, Event, HostMachine, Nodes, Request, Token};
use hoot_proto::message::{Amperes, Level, Motor, RingTip, Steps, StepsPerSecond, Volts};
use hoot_proto::query::Profile;
use hoot_proto::{Address, DeviceMessage, Frame, HostMessage};
use motion_core::fixed::Scaled;
use motion_core::time::Millis;
use motion_core::wire::Messages;

fuzz_world!(World);

const PORTS: [Port; 3] = [Port::Bus, Port::Usb, Port::Bluetooth];
const PROFILES: [Profile; 6] =
    [Profile::Unknown, Profile::Library20140925, Profile::Sheet, Profile::January2015, Profile::V035, Profile::V070];

/// Bodies of requests. A master keeps its requests, so their bodies must live as long as the program, and each body is
/// a part of this array. It holds 64 small numbers of four bytes, which also serve as two and one, or one and four.
/// Then it holds 64 speeds, half of them negative.
static BODIES: [u8; 512] = {
    let (mut all, mut number) = ([0; 512], 0);
    while number < 64_u8 {
        let speed = ((number as f32 - 32.0) * 50.0).to_be_bytes();
        let at = number as usize * 4;
        all[at + 3] = number;
        [all[256 + at], all[257 + at], all[258 + at], all[259 + at]] = speed;
        number += 1;
    }
    all
};

struct World {
    now: Millis,
    host: Watched<HostMachine>,
    device: Watched<DeviceMachine>,
    to_device: Line,
    to_host: Line,
    tokens: Tokens,
}

impl World {
    fn new(bytes: &mut Bytes<'_>) -> Self {
        let host = host::Options::default().with_bridge(bytes.flag());
        let quirks = if bytes.flag() { Quirks::FIRMWARE } else { Quirks::NONE };
        let device = device::Options::default().with_profile(bytes.one_of(&PROFILES)).with_quirks(quirks);
        Self {
            now: Millis(1000),
            host: Watched::new(HostMachine::new(host.with_nodes(nodes(bytes)))),
            device: Watched::new(DeviceMachine::new(device)),
            to_device: Line::default(),
            to_host: Line::default(),
            tokens: Tokens::default(),
        }
    }

    fn act(&mut self, bytes: &mut Bytes<'_>) {
        match bytes.byte() % 16 {
            0..4 => {
                if let Some(packet) = self.to_device.take(bytes) {
                    self.tell_device(match Frame::decode(&packet) {
                        Ok(frame) => {
                            let (to, message) = (frame.address(), HostMessage::decode(&frame));
                            device::Input::Received { port: Port::Bus, to, message }
                        }
                        Err(_) => device::Input::Noise,
                    });
                }
            }
            4..8 => {
                if let Some(packet) = self.to_host.take(bytes) {
                    self.tell_host(match Frame::decode(&packet) {
                        Ok(frame) => host::Input::Received(DeviceMessage::decode(&frame)),
                        Err(_) => host::Input::Noise,
                    });
                }
            }
            8 | 9 => {
                let (port, to) = (bytes.one_of(&PORTS), Address(bytes.byte() % 5));
                if let Ok(message) = bytes.message() {
                    self.tell_device(device::Input::Received { port, to, message });
                }
            }
            10 => {
                if let Ok(message) = bytes.message() {
                    self.tell_host(host::Input::Received(message));
                }
            }
            11 => self.tell_device(report(bytes)),
            12 => self.tell_device(device::Input::Wake),
            13 => {
                let all = [host::Input::Wake, host::Input::LinkUp, host::Input::LinkDown, host::Input::Noise];
                self.tell_host(bytes.one_of(&all));
            }
            _ => self.command(bytes),
        }
    }

    fn command(&mut self, bytes: &mut Bytes<'_>) {
        let to = Address(bytes.byte() % 6);
        let command = match bytes.byte() % 16 {
            0 => Command::EmergencyStop,
            1 => Command::EndEmergency,
            2 => Command::KeepAlive { to, on: bytes.flag() },
            3 => Command::Nodes(nodes(bytes)),
            4..7 => Command::Speed { to, motor: bytes.one_of(&Motor::ALL), speed: StepsPerSecond(bytes.float()) },
            what => {
                let message = long_lived(bytes);
                let request = Request { token: Token(self.tokens.begin()), to, message };
                if what == 7 { Command::Insist(request) } else { Command::Request(request) }
            }
        };
        self.tell_host(host::Input::Command(command));
    }

    fn tell_host(&mut self, input: host::Input<'_>) {
        let output = self.host.step(self.now, input, host::Input::Wake);
        for event in output.events {
            if let Event::Ended { token: Token(token), .. } = event {
                self.tokens.end(token);
            }
        }
        for send in output.send {
            let mut packet = [0; MAX_FRAME];
            let len = send.encode_into(&mut packet).expect("a request of the master can be encoded");
            let frame = Frame::decode(&packet[..len]).expect("a packet that was just encoded");
            assert_eq!((frame.address(), HostMessage::decode(&frame)), (send.to, send.message));
            self.to_device.put(&packet[..len]);
        }
    }

    fn tell_device(&mut self, input: device::Input<'_>) {
        let output = self.device.step(self.now, input, device::Input::Wake);
        if let device::Input::Command(AtNode::Stop | AtNode::Pause | AtNode::EmergencyStop) = input {
            let moves = Motor::ALL.map(|motor| self.device.machine.motor(motor).is_moving());
            assert_eq!(moves, [false; 3], "a stop is obeyed in its step: {output:?}");
        }
        for send in output.send {
            let mut scratch = [0; MAX_FRAME];
            let message = send.answer.message(&mut scratch).expect("room enough");
            let mut packet = [0; MAX_FRAME];
            let len = send.answer.encode_into(&mut packet).expect("an answer of the node can be encoded");
            let frame = Frame::decode(&packet[..len]).expect("a packet that was just encoded");
            assert_eq!(DeviceMessage::decode(&frame), message);
            self.to_host.put(&packet[..len]);
        }
    }
}

fn report(bytes: &mut Bytes<'_>) -> device::Input<'static> {
    let motor = bytes.one_of(&Motor::ALL);
    match bytes.byte() % 12 {
        0 => device::Input::Command(bytes.one_of(&[
            AtNode::Start,
            AtNode::Pause,
            AtNode::Stop,
            AtNode::EmergencyStop,
            AtNode::PowerUp,
        ])),
        1 => device::Input::Alt(bytes.one_of(&[Contact::Ring, Contact::Tip])),
        2 => device::Input::Fault(motor),
        3 => device::Input::CommonLine,
        4 => device::Input::Noise,
        5 => device::Input::LinkDown(bytes.one_of(&PORTS)),
        6 => device::Input::LinkUp(bytes.one_of(&PORTS)),
        7 => device::Input::Limits(RingTip { ring: Level(bytes.byte()), tip: Level(bytes.byte()) }),
        8 => device::Input::Supply { volts: Volts(hundredths(bytes)), amperes: Amperes(hundredths(bytes)) },
        9 => device::Input::Position { motor, position: Steps(i32::from_le_bytes(bytes.few())) },
        _ => device::Input::Arrived(motor),
    }
}

/// A number with any hundredths.
fn hundredths(bytes: &mut Bytes<'_>) -> Scaled<i32, 100> {
    Scaled(i32::from_le_bytes(bytes.few()))
}

/// A message of a master, known or unknown, as the decoder gives it. Command 1 with data has its number in the first
/// byte.
fn long_lived(bytes: &mut Bytes<'_>) -> HostMessage<'static> {
    let number = match bytes.byte() {
        known @ 0..250 => HostMessage::ALL[usize::from(known) % HostMessage::ALL.len()].number,
        _ => u32::from_le_bytes(bytes.few()) % 0x3_0000,
    };
    let (from, len) = (usize::from(u16::from_le_bytes(bytes.few())), usize::from(bytes.byte()) % 40);
    let from = from % BODIES.len();
    let body = &BODIES[from..(from + len).min(BODIES.len())];
    let (number, body) = match (number.to_be_bytes(), body) {
        ([0, 0, 1, part], [first, rest @ ..]) => (u32::from_be_bytes([0, 2, *first, part]), rest),
        _ => (number, body),
    };
    HostMessage::decode_body(number, body).unwrap_or_else(|_| HostMessage::other(number, body))
}

/// Some of the nodes from address 3 on.
fn nodes(bytes: &mut Bytes<'_>) -> Nodes {
    (0..bytes.byte() % 4).fold(Nodes::NONE, |nodes, number| nodes.with(Address(3 + number)).expect("room for eight"))
}
