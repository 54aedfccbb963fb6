//! hoot: any inputs of a master and a node, alone and with each other on a faulty line, in any order.
//!
//! Input: options, then steps; see `fuzz::machines`.

#![no_main]

use fuzz::fuzz_world;
use fuzz::machines::{Bytes, World, arrival, send, step, world};
use hoot_proto::device::{self, Command as AtNode, Contact, Contents, DeviceMachine, Port, Quirks};
use hoot_proto::frame::MAX_FRAME;
use hoot_proto::host::{self, Command, Event, HostMachine, Nodes, Request, StopState};
use hoot_proto::message::{Amperes, Level, Motor, RingTip, Scaled, Steps, StepsPerSecond, Volts};
use hoot_proto::query::Profile;
use hoot_proto::{Address, Device, DeviceMessage, Effect, Frame, Host, HostMessage, Messages};
use laws::world::Tokens;

fuzz_world!(Hoot);

const PORTS: [Port; 3] = [Port::Bus, Port::Usb, Port::Bluetooth];

/// One build of the firmware, or firmware of which nothing is known.
fn profile(byte: u8) -> Profile {
    Profile::builds().nth(byte.into()).unwrap_or(Profile::UNKNOWN)
}

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

struct Hoot {
    world: World<HostMachine, DeviceMachine>,
    tokens: Tokens,
}

impl Hoot {
    fn new(bytes: &mut Bytes<'_>) -> Self {
        let host = host::Options::new().with_bridge(bytes.flag());
        let quirks = if bytes.flag() { Quirks::FIRMWARE } else { Quirks::NONE };
        let device = device::Options::new().with_profile(profile(bytes.byte())).with_quirks(quirks);
        let host = HostMachine::new(host.with_nodes(nodes(bytes)));
        Self { world: world(host, DeviceMachine::new(device)), tokens: Tokens::default() }
    }

    fn act(&mut self, bytes: &mut Bytes<'_>) {
        match bytes.byte() % 16 {
            0..4 => {
                if let Some(packet) = arrival(&mut self.world.up, bytes) {
                    self.tell_device(match Frame::decode(&packet) {
                        Ok(frame) => device::Input::received(Port::Bus, &frame),
                        Err(_) => device::Input::Noise,
                    });
                }
            }
            4..8 => {
                if let Some(packet) = arrival(&mut self.world.down, bytes) {
                    self.tell_host(match Frame::decode(&packet) {
                        Ok(frame) => host::Input::received(&frame),
                        Err(_) => host::Input::Noise,
                    });
                }
            }
            8 | 9 => {
                let (port, to) = (bytes.one_of(&PORTS), Address(bytes.byte() % 5));
                if let Ok(message) = bytes.message::<Host>().read() {
                    self.tell_device(device::Input::Received { port, to, message });
                }
            }
            10 => {
                if let Ok(message) = bytes.message::<Device>().read() {
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
                let request = Request { to, message: long_lived(bytes) };
                if what == 7 { Command::Insist(request) } else { Command::Request(request) }
            }
        };
        let token = self.tokens.begin();
        self.tell_host(host::Input::Command(token, command));
    }

    fn tell_host(&mut self, input: host::Input<'_>) {
        let output = step(&mut self.world.host, self.world.now, input, host::Input::Wake);
        for (place, effect) in output.into_iter().enumerate() {
            match effect {
                Effect::Event(Event::Ended { token, .. }) => self.tokens.end(token),
                Effect::Event(_) => {}
                Effect::Transmit(transmit) => {
                    assert_eq!(place, 0, "a stop goes out before anybody is told of it");
                    let mut packet = [0; MAX_FRAME];
                    let len = transmit.encode_into(&mut packet).expect("a request of the master can be encoded");
                    let frame = Frame::decode(&packet[..len]).expect("a packet that was just encoded");
                    assert_eq!((frame.address(), HostMessage::decode(&frame)), (transmit.to, transmit.message));
                    send(&mut self.world.up, self.world.now, &packet[..len]);
                }
            }
        }
        let host = &self.world.host.machine;
        assert!(self.tokens.open().count() <= host.pending(), "no command is forgotten");
        assert!(host.may_move() || host.stopping() == StopState::Calm, "a stop that goes on is not confirmed");
    }

    fn tell_device(&mut self, input: device::Input<'_>) {
        let output = step(&mut self.world.device, self.world.now, input, device::Input::Wake);
        if let device::Input::Command(AtNode::Stop | AtNode::Pause | AtNode::EmergencyStop) = input {
            let moves = Motor::ALL.map(|motor| self.world.device.machine.motor(motor).is_moving());
            assert_eq!(moves, [false; 3], "a stop is obeyed in its step: {output:?}");
        }
        let mut acknowledges = false;
        for effect in output {
            let Effect::Transmit(transmit) = effect else {
                assert!(!acknowledges, "the rig does first what an answer acknowledges");
                continue;
            };
            acknowledges = true;
            let mut packet = [0; MAX_FRAME];
            let written = transmit.encode_into(&mut packet);
            match transmit.contents {
                Contents::Answer(answer) => {
                    let packet = &packet[..written.expect("an answer of the node can be encoded")];
                    let frame = Frame::decode(packet).expect("a packet that was just encoded");
                    assert_eq!(answer.message(&mut [0; MAX_FRAME]), Ok(DeviceMessage::decode(&frame)));
                    send(&mut self.world.down, self.world.now, packet);
                }
                Contents::Forward { to, message } => {
                    // A message that no decoder made may have no packet.
                    let Ok(len) = written else { continue };
                    let frame = Frame::decode(&packet[..len]).expect("a packet that was just encoded");
                    assert_eq!((frame.address(), HostMessage::decode(&frame)), (to, message));
                }
                other => panic!("{other:?} is not known"),
            }
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

/// Any number of hundredths.
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
