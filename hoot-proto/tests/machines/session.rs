//! Sessions do what their machines do, with bytes in any pieces.

use std::slice::Chunks;

use hoot_proto::device::{self, Contact, DeviceMachine, Event, Motion, Port, Quirks};
use hoot_proto::frame::{Hoot, MAX_FRAME, Requests};
use hoot_proto::host::{self, Command, HostMachine, Request, Token};
use hoot_proto::message::{
    AltMode, Motor, MotorPosition, MotorSetEnable, MotorSetProgramStop, MotorSetTravel, Reply, ResponseCode,
    SetAltModes, Span, Steps,
};
use hoot_proto::{Address, DeviceMessage, Effect, EncodeError, HostMessage, Item, Messages, Millis};
use motion_core::stream::{Patience, TimedFrames};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

use super::random::{ToMaster, ToNode, decode, profiles, stop, to_master, to_node};
use super::world::*;

const PATIENCE: Patience = Patience::new().with_line_speed(9600).with_margin(101);
const PORTS: [Port; 3] = [Port::Bus, Port::Usb, Port::Bluetooth];

/// Master as its documentation says that a machine is called.
struct PlainMaster {
    machine: HostMachine,
    frames: TimedFrames<Hoot, { 2 * MAX_FRAME + 63 }>,
    wake: Option<Millis>,
    /// Whether a packet was sent.
    is_stale: bool,
}

/// Node as its documentation says that a machine is called.
struct PlainNode {
    machine: DeviceMachine,
    ports: [TimedFrames<Requests, { 2 * MAX_FRAME + 63 }>; 3],
    wake: Option<Millis>,
}

impl PlainMaster {
    fn give(&mut self, now: Millis, input: host::Input<'_>) -> Vec<String> {
        let output = self.machine.advance(now, input);
        self.wake = output.wake;
        self.is_stale |= output.transmits().next().is_some();
        let done = output.into_iter().map(|effect| match effect {
            Effect::Event(event) => format!("{event:?}"),
            Effect::Transmit(transmit) => {
                let mut bytes = [0; MAX_FRAME];
                let len = transmit.encode_into(&mut bytes).unwrap();
                format!("> {:02x?}", &bytes[..len])
            }
        });
        done.collect()
    }

    fn receive(&mut self, now: Millis, pieces: Chunks<'_, u8>) -> Vec<String> {
        let mut done = Vec::new();
        for piece in pieces {
            assert_eq!(self.frames.push(now, piece), piece.len());
        }
        loop {
            if std::mem::take(&mut self.is_stale) {
                self.frames.reset();
            }
            let item = self.frames.next().map(|item| match item {
                Item::Frame(frame) => Some(frame.bytes().to_vec()),
                _ => None,
            });
            let packet = match item {
                Some(packet) => packet,
                None if self.frames.deadline().is_some_and(|deadline| deadline <= now) => {
                    self.frames.give_up(now);
                    continue;
                }
                None if self.wake.is_some_and(|wake| wake <= now) => {
                    done.extend(self.give(now, host::Input::Wake));
                    continue;
                }
                None => return done,
            };
            let frame = packet.as_ref().map(|packet| hoot_proto::Frame::decode(packet).unwrap());
            let input = frame.map_or(host::Input::Noise, |frame| host::Input::received(&frame));
            done.extend(self.give(now, input));
        }
    }
}

fn node_step(
    (machine, wake): (&mut DeviceMachine, &mut Option<Millis>),
    now: Millis,
    input: device::Input<'_>,
) -> Vec<String> {
    let output = machine.advance(now, input);
    *wake = output.wake;
    let done = output.into_iter().map(|effect| match effect {
        Effect::Event(event) => format!("{event:?}"),
        Effect::Transmit(transmit) => {
            let mut bytes = [0; MAX_FRAME];
            let len = transmit.encode_into(&mut bytes).unwrap();
            format!("{:?} > {:02x?}", transmit.port, &bytes[..len])
        }
    });
    done.collect()
}

impl PlainNode {
    fn give(&mut self, now: Millis, input: device::Input<'_>) -> Vec<String> {
        node_step((&mut self.machine, &mut self.wake), now, input)
    }

    fn receive(&mut self, now: Millis, port: usize, pieces: Chunks<'_, u8>) -> Vec<String> {
        let mut done = Vec::new();
        for piece in pieces {
            assert_eq!(self.ports[port].push(now, piece), piece.len());
        }
        for (port, frames) in PORTS.into_iter().zip(&mut self.ports) {
            loop {
                while let Some(item) = frames.next() {
                    let input = match item {
                        Item::Frame(frame) => device::Input::received(port, &frame),
                        _ => device::Input::Noise,
                    };
                    done.extend(node_step((&mut self.machine, &mut self.wake), now, input));
                }
                if frames.deadline().is_none_or(|deadline| deadline > now) {
                    break;
                }
                frames.give_up(now);
            }
        }
        if self.wake.is_some_and(|wake| wake <= now) {
            done.extend(self.give(now, device::Input::Wake));
        }
        done
    }
}

fn poll(session: &mut host::Session, now: Millis, room: &mut Vec<u8>) -> Vec<String> {
    let mut done = Vec::new();
    loop {
        match session.poll(now, room) {
            Ok(host::Next::Transmit(bytes)) => done.push(format!("> {bytes:02x?}")),
            Ok(host::Next::Event(event)) => done.push(format!("{event:?}")),
            Ok(host::Next::Wait(_)) => return done,
            Err(EncodeError::BufferTooSmall { needed, .. }) => room.resize(needed, 0),
            Err(error) => panic!("{error}"),
        }
    }
}

/// Rig that does what a node tells it.
#[derive(Default)]
struct Rig {
    moves: [bool; 3],
    shutter: bool,
    /// Whether a person stopped everything, after which nothing that had arrived may set anything in motion.
    is_held: bool,
}

impl Rig {
    fn see(&mut self, event: &Event<'_>) {
        match *event {
            Event::Camera { shutter, .. } => self.shutter = shutter,
            Event::Motor { motor, motion: Motion::Stop } => self.moves[motor as usize - 1] = false,
            Event::Motor {
                motor,
                motion: Motion::By { .. } | Motion::To(_) | Motion::Run { .. } | Motion::Along { .. },
            } => {
                self.moves[motor as usize - 1] = true;
            }
            _ => {}
        }
        assert!(!self.is_held || !self.is_active(), "{event:?}");
    }

    fn is_active(&self) -> bool {
        self.shutter || self.moves.contains(&true)
    }
}

fn node_poll(session: &mut device::Session, now: Millis, room: &mut Vec<u8>, rig: &mut Rig) -> Vec<String> {
    let mut done = Vec::new();
    loop {
        assert!(!rig.is_active() || session.may_move(), "{session:?}");
        match session.poll(now, room) {
            Ok(device::Next::Transmit(port, bytes)) => done.push(format!("{port:?} > {bytes:02x?}")),
            Ok(device::Next::Event(event)) => {
                rig.see(&event);
                done.push(format!("{event:?}"));
            }
            Ok(device::Next::Wait(_)) => return done,
            Err(EncodeError::BufferTooSmall { needed, .. }) => room.resize(needed, 0),
            Err(error) => panic!("{error}"),
        }
    }
}

fn reply(code: u8, data: &[u8]) -> Vec<u8> {
    let message = DeviceMessage::from(Reply { code: ResponseCode(code), data });
    let mut bytes = vec![0; message.encoded_len()];
    message.encode_into(&mut bytes).unwrap();
    bytes
}

/// Packet of a master; `None` if it cannot be written.
fn packet(to: Address, number: u32, body: &[u8]) -> Option<Vec<u8>> {
    let message = decode(number, body);
    let mut bytes = vec![0; message.encoded_len()];
    message.encode_into(to, &mut bytes).ok().map(|_| bytes)
}

proptest! {
    #[test]
    fn a_session_of_a_master_does_what_its_machine_does(
        bridge in any::<bool>(), steps in vec((0_u64..200, to_master(), any::<Index>(), 1..20_usize), 1..100),
    ) {
        let options = host::Options::default().with_bridge(bridge);
        let machine = HostMachine::new(options);
        let mut plain = PlainMaster { machine, frames: TimedFrames::new(PATIENCE), wake: None, is_stale: false };
        let (mut session, mut room, mut now) = (host::Session::new(options), Vec::new(), Millis(0));
        session.link_up();
        prop_assert_eq!(poll(&mut session, now, &mut room), plain.give(now, host::Input::LinkUp));
        let asks = [START, STOP, PAUSE, MotorPosition { motor: Motor::One }.into()];
        for (token, (pause, step, at, piece)) in (0..).map(Token).zip(steps) {
            now = now.after(pause);
            let (mut arrived, mut expected) = (Vec::new(), Vec::new());
            let command = match step {
                ToMaster::Ask(to, ..) => {
                    Some(Command::Request(Request { to: Address(to), message: *at.get(&asks) }))
                }
                ToMaster::Move(motor) => {
                    Some(Command::Request(Request { to: NODE, message: move_by(motor, token.0 + 1) }))
                }
                ToMaster::Stop(to, which) => {
                    let (to, message) = stop(to.max(2), which);
                    Some(Command::Request(Request { to, message }))
                }
                ToMaster::Command(command) => Some(command),
                ToMaster::Reply(code, data) => {
                    // The value of a position, or anything else; some replies are cut off.
                    let value = [3, 0, 0, 0, 5];
                    let data = if pause % 2 == 0 { &value[..] } else { &data[..data.len().min(32)] };
                    arrived = reply(code, data);
                    arrived.truncate(arrived.len() - usize::from(pause % 7 == 0));
                    None
                }
                ToMaster::Stray(number) => {
                    let message = DeviceMessage::other(number, &[]);
                    arrived = vec![0; message.encoded_len()];
                    message.encode_into(&mut arrived).unwrap();
                    None
                }
                ToMaster::Other(host::Input::Noise) => {
                    arrived = vec![7; 3];
                    None
                }
                ToMaster::Other(host::Input::LinkUp) => {
                    plain.frames.reset();
                    session.link_up();
                    expected = plain.give(now, host::Input::LinkUp);
                    None
                }
                ToMaster::Other(host::Input::LinkDown) => {
                    session.link_down();
                    expected = plain.give(now, host::Input::LinkDown);
                    None
                }
                ToMaster::Other(_) => None,
            };
            if let Some(command) = command {
                session.command(token, command).unwrap();
                expected = plain.give(now, host::Input::Command(token, command));
            }
            for piece in arrived.chunks(piece) {
                prop_assert_eq!(session.receive(now, piece), piece.len());
            }
            expected.extend(plain.receive(now, arrived.chunks(piece)));
            prop_assert_eq!(poll(&mut session, now, &mut room), expected);
            prop_assert_eq!(session.may_move(), plain.machine.may_move());
        }
    }

    #[test]
    fn a_node_without_quirks_does_what_a_node_with_none_of_them_does(
        profile in profiles(),
        steps in vec((0_u64..200, to_node()), 1..100),
    ) {
        let options = device::Options::default().with_profile(profile);
        let mut plain = DeviceMachine::new(options);
        let mut without = DeviceMachine::without_quirks(options.with_quirks(Quirks::FIRMWARE));
        let mut now = Millis(0);
        for (pause, step) in steps {
            now = now.after(pause);
            let input = match step {
                ToNode::Packet(to, port, number, body) => {
                    device::Input::Received { port, to: Address(to), message: decode(number, body.leak()) }
                }
                ToNode::Position(motor, steps) => device::Input::Position { motor, position: Steps(steps) },
                ToNode::Other(input) => input,
            };
            prop_assert_eq!(plain.advance(now, input), without.advance(now, input));
            prop_assert_eq!(plain.may_move(), without.may_move());
        }
    }

    #[test]
    fn a_session_of_a_node_does_what_its_machine_does(
        profile in profiles(),
        firmware in any::<bool>(),
        steps in vec((0_u64..200, to_node(), 1..20_usize), 1..100),
    ) {
        let quirks = if firmware { Quirks::FIRMWARE } else { Quirks::NONE };
        let machine = DeviceMachine::new(device::Options::default().with_profile(profile).with_quirks(quirks));
        let mut session = device::Session::new(machine.clone());
        let ports = PORTS.map(|_| TimedFrames::new(PATIENCE));
        let mut plain = PlainNode { machine, ports, wake: None };
        let (mut room, mut now, mut rig) = (Vec::new(), Millis(0), Rig::default());
        for port in PORTS {
            session.link_up(port).unwrap();
            let expected = plain.give(now, device::Input::LinkUp(port));
            prop_assert_eq!(node_poll(&mut session, now, &mut room, &mut rig), expected);
        }
        for (pause, step, piece) in steps {
            now = now.after(pause);
            let (mut arrived, mut expected, mut index) = (Vec::new(), Vec::new(), 0);
            match step {
                ToNode::Packet(to, port, number, body) => {
                    index = PORTS.iter().position(|other| *other == port).unwrap();
                    arrived = packet(Address(to), number, &body[..body.len().min(32)]).unwrap_or_default();
                }
                ToNode::Position(motor, steps) => {
                    let position = Steps(steps);
                    session.position(motor, position).unwrap();
                    expected = plain.give(now, device::Input::Position { motor, position });
                }
                ToNode::Other(device::Input::Noise) => arrived = vec![7; 3],
                ToNode::Other(device::Input::Wake) => {}
                ToNode::Other(input) => {
                    if let device::Input::Arrived(motor) = input {
                        rig.moves[motor as usize - 1] = false;
                    }
                    let told = match input {
                        device::Input::Command(device::Command::EmergencyStop) => session.stop(),
                        device::Input::Command(command) => session.command(command),
                        device::Input::Alt(contact) => session.alt(contact),
                        device::Input::Arrived(motor) => session.arrived(motor),
                        device::Input::Fault(motor) => session.fault(motor),
                        device::Input::CommonLine => session.common_line(),
                        other => panic!("{other:?}"),
                    };
                    told.unwrap();
                    expected = plain.give(now, input);
                }
            }
            for piece in arrived.chunks(piece) {
                prop_assert_eq!(session.receive(now, PORTS[index], piece), piece.len());
            }
            expected.extend(plain.receive(now, index, arrived.chunks(piece)));
            prop_assert_eq!(node_poll(&mut session, now, &mut room, &mut rig), expected);
            prop_assert!(!rig.is_active() || session.may_move());
            prop_assert_eq!(session.may_move(), plain.machine.may_move());
        }
        session.stop().unwrap();
        prop_assert!(session.may_move(), "the stop waits");
        node_poll(&mut session, now, &mut room, &mut rig);
        prop_assert!(!rig.is_active() && !session.may_move());
    }
}

/// A contact, a packet and a person set something going, and then a person stops everything.
#[test]
fn what_arrived_before_a_stop_at_the_node_does_not_undo_it() {
    let now = Millis(5);
    let (mut room, mut rig) = (Vec::new(), Rig::default());
    let mut session = device::Session::new(DeviceMachine::new(device::Options::default()));
    let receive = |session: &mut device::Session, message: HostMessage<'_>| {
        let mut bytes = [0; MAX_FRAME];
        let len = message.encode_into(NODE, &mut bytes).unwrap();
        assert_eq!(session.receive(now, Port::Usb, &bytes[..len]), len);
    };
    let modes = SetAltModes { ring: AltMode::START, tip: AltMode::OFF };
    let enable = MotorSetEnable { motor: Motor::One, enable: YES };
    let travel = MotorSetTravel { motor: Motor::One, travel: Span(3) };
    let stop = MotorSetProgramStop { motor: Motor::One, position: Steps(300) };
    for setting in [modes.into(), enable.into(), travel.into(), stop.into()] {
        receive(&mut session, setting);
        node_poll(&mut session, now, &mut room, &mut rig);
    }
    for how in 0..3 {
        for is_stopped in [true, false] {
            match how {
                0 => session.alt(Contact::Ring).unwrap(),
                1 => receive(&mut session, run(Motor::One)),
                _ => session.command(device::Command::Start).unwrap(),
            }
            assert!(session.may_move(), "{how} waits");
            if is_stopped {
                session.stop().unwrap();
            }
            rig.is_held = is_stopped;
            node_poll(&mut session, now, &mut room, &mut rig);
            assert_eq!([rig.is_active(), session.may_move()], [!is_stopped; 2], "{how}");
        }
        session.stop().unwrap();
        node_poll(&mut session, now, &mut room, &mut rig);
        assert!(!rig.is_active());
    }
}
