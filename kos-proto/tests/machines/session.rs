//! Sessions do what their machines do, with bytes in any pieces.

use kos_proto::device::{self, DeviceMachine, Report, SessionId};
use kos_proto::host::{self, HostMachine, Token};
use kos_proto::message::{Ipv4, MotorAddress, MotorSet, Password, Rotations};
use kos_proto::{Effect, EncodeError, Frame, HostMessage, Millis, Transport};
use proptest::collection::vec;
use proptest::prelude::*;

use super::random::{DeviceOp, HostOp, Wire, command, device_message, device_op, device_options, host_op, time};
use super::world::{device_bytes, host_bytes};

const OPEN: Password<'static> = Password(b"open");
/// Bytes that are no stream of messages.
const BROKEN: [u8; 6] = [9, 0, 0, 6, 0, 0];

const SENDER: device::Sender = device::Sender { address: Ipv4(0xC000_0207), port: 5520 };

/// Bytes of a message.
fn bytes(wire: &Wire) -> Vec<u8> {
    let [id0, id1, kind, sub] = wire.number.to_be_bytes();
    let is_numbered = [0x8000, 0x8102].contains(&(wire.number >> 8));
    let sub = [sub];
    let body = [if is_numbered { &sub[..] } else { &[] }, &wire.body].concat();
    let len = u16::try_from(6 + body.len()).unwrap().to_be_bytes();
    [&[4, len[0], len[1], id0, id1, kind][..], &body].concat()
}

/// Everything that follows from one step, and the wake.
type Step = (Vec<String>, Option<Millis>);

fn host_step(machine: &mut HostMachine, now: Millis, input: host::Input<'_>) -> Step {
    let source = host::Source { user_password: OPEN, ..host::Source::default() };
    let output = machine.advance(now, input);
    let wake = output.wake;
    let done = output.into_iter().map(|effect| match effect {
        Effect::Transmit(transmit) => format!("> {:02x?}", host_bytes(&transmit, &source)),
        Effect::Event(event) => format!("{event:?}"),
    });
    (done.collect(), wake)
}

fn host_poll(session: &mut host::Session<40_000>, now: Millis, room: &mut Vec<u8>) -> Step {
    let source = host::Source { user_password: OPEN, ..host::Source::default() };
    let mut done = Vec::new();
    loop {
        match session.poll(now, &source, room) {
            Ok(host::Next::Transmit(bytes) | host::Next::Broadcast(bytes)) => done.push(format!("> {bytes:02x?}")),
            Ok(host::Next::Event(event)) => done.push(format!("{event:?}")),
            Ok(host::Next::Wait(wake)) => return (done, wake),
            Err(EncodeError::BufferTooSmall { needed, .. }) => room.resize(needed, 0),
            Err(error) => panic!("{error}"),
        }
    }
}

fn device_step(machine: &mut DeviceMachine, now: Millis, input: device::Input<'_>) -> Step {
    let source = device::Source { password: OPEN, ..device::Source::default() };
    let output = machine.advance(now, input);
    let wake = output.wake;
    let done = output.into_iter().map(|effect| match effect {
        Effect::Transmit(transmit) => {
            format!("{:?} > {:02x?}", transmit.destination, device_bytes(&transmit, &source))
        }
        Effect::Event(event) => format!("{event:?}"),
    });
    (done.collect(), wake)
}

fn device_poll(session: &mut device::Session<40_000>, now: Millis, room: &mut Vec<u8>) -> Step {
    let source = device::Source { password: OPEN, ..device::Source::default() };
    let mut done = Vec::new();
    loop {
        match session.poll(now, &source, room) {
            Ok(device::Next::Transmit(to, bytes)) => done.push(format!("{to:?} > {bytes:02x?}")),
            Ok(device::Next::Event(event)) => done.push(format!("{event:?}")),
            Ok(device::Next::Wait(wake)) => return (done, wake),
            Err(EncodeError::BufferTooSmall { needed, .. }) => room.resize(needed, 0),
            Err(error) => panic!("{error}"),
        }
    }
}

/// Client over USB, which connects again after each end of its connection.
const CLIENT: SessionId = SessionId(0);

/// What moves in a rig, as its events say.
#[derive(Default)]
struct Rig {
    /// Motors that were sent or stopped, and did not come to rest.
    moving: MotorSet,
    /// Motors that were sent, and not stopped after that.
    sent: MotorSet,
    /// Motors of the move.
    part: MotorSet,
    /// Whether the motors of the move follow their curves.
    plays: bool,
    /// Time at which the shutter closes.
    shutter: Millis,
    wake: Option<Millis>,
    is_connected: bool,
    /// Whether a person stopped everything, after which nothing that had arrived may set anything in motion.
    is_held: bool,
}

impl Rig {
    fn send(&mut self, motors: MotorSet) {
        (self.moving, self.sent) = (self.moving.with(motors), self.sent.with(motors));
    }

    fn report(&mut self, session: &mut device::Session, report: Report) {
        if let Report::Arrived(motor, _) = report {
            self.moving.remove(motor);
        }
        session.report(report).unwrap();
    }

    /// Does everything that follows, and checks that the session knows what moves.
    fn poll(&mut self, session: &mut device::Session, now: Millis) {
        use device::Event;
        let source = device::Source { password: OPEN, ..device::Source::default() };
        let mut room = [0; 1024];
        if !std::mem::replace(&mut self.is_connected, true) {
            session.link_up(CLIENT, Transport::Usb).unwrap();
        }
        loop {
            let event = match session.poll(now, &source, &mut room) {
                Ok(device::Next::Event(event)) => event,
                Ok(device::Next::Transmit(..)) => continue,
                Ok(device::Next::Wait(wake)) => break self.wake = wake,
                Err(error) => panic!("{error}"),
            };
            let sets_in_motion = matches!(
                event,
                Event::Move { .. }
                    | Event::Home { .. }
                    | Event::MoveToFrame { .. }
                    | Event::Play { .. }
                    | Event::OpenShutter { .. }
            );
            assert!(!(self.is_held && sets_in_motion), "{event}");
            match event {
                Event::Move { motor, .. } => self.send(MotorSet::of([motor])),
                Event::StopMotor { motor, .. } => self.sent.remove(motor),
                Event::Home { motors, .. } => {
                    self.part = motors;
                    self.send(motors);
                }
                Event::MoveToFrame { .. } => self.send(self.part),
                Event::Play { .. } => self.plays = true,
                Event::OpenShutter { millis } => self.shutter = self.shutter.max(now.after(millis)),
                Event::StopAll if std::mem::take(&mut self.plays) => self.moving = self.moving.with(self.part),
                Event::MoveOver => self.plays = false,
                Event::Disconnect { session: CLIENT, .. } => self.is_connected = false,
                _ => {}
            }
            if event == Event::StopAll {
                (self.shutter, self.sent) = (Millis(0), MotorSet::NONE);
            }
        }
        let moves = !self.moving.is_empty() || self.plays || self.shutter > now;
        assert!(!moves || session.may_move(), "{session:?}");
    }
}

proptest! {
    #[test]
    fn a_session_of_a_client_does_what_its_machine_does(ops in vec((time(), host_op(), 1..40_usize), 1..60)) {
        let options = host::Options::default().with_ask_every(Some(3_000));
        let (mut machine, mut session) = (HostMachine::new(options), Box::new(host::Session::<40_000>::new(options)));
        let (mut now, mut wake, mut room) = (Millis(0), None, Vec::new());
        for (number, (time, op, piece)) in (0..).zip(ops) {
            now = time.pass(now, wake);
            let token = Token(number);
            let arrived = match &op {
                HostOp::Message(wire) => bytes(wire),
                HostOp::Fatal => BROKEN.to_vec(),
                _ => Vec::new(),
            };
            let (expected, next) = host_step(&mut machine, now, match &op {
                HostOp::Opened => host::Input::LinkUp,
                HostOp::Closed => host::Input::LinkDown,
                HostOp::Fatal => host::Input::Fatal,
                HostOp::Command(command) => host::Input::Command(token, *command),
                HostOp::Wake => host::Input::Wake,
                HostOp::Message(_) => host::Input::received(&Frame::decode(&arrived).unwrap()),
            });
            match &op {
                HostOp::Opened => session.link_up(),
                HostOp::Closed => session.link_down(),
                HostOp::Command(command) => session.command(token, *command).unwrap(),
                HostOp::Fatal | HostOp::Message(_) | HostOp::Wake => {}
            }
            for piece in arrived.chunks(piece) {
                prop_assert_eq!(session.receive(now, piece), piece.len());
            }
            let (found, _) = host_poll(&mut session, now, &mut room);
            prop_assert_eq!(&found, &expected, "after {:?}", op);
            prop_assert_eq!(session.may_move(), machine.may_move());
            wake = next;
        }
    }

    #[test]
    fn a_session_of_a_device_does_what_its_machine_does(
        options in device_options(), ops in vec((time(), device_op(), 1..40_usize), 1..60),
    ) {
        let mut machine = DeviceMachine::new(options);
        let mut session = Box::new(device::Session::<40_000>::new(DeviceMachine::new(options)));
        let (mut now, mut wake, mut room) = (Millis(0), None, Vec::new());
        for (time, op, piece) in ops {
            now = time.pass(now, wake);
            let (client, arrived) = match &op {
                DeviceOp::Message(client, wire) if client.0 < 4 => (*client, bytes(wire)),
                DeviceOp::Fatal(client) if client.0 < 4 => (*client, BROKEN.to_vec()),
                DeviceOp::Datagram(wire) => (SessionId(4), bytes(wire)),
                // There are four clients.
                DeviceOp::Message(..) | DeviceOp::Fatal(_) => continue,
                _ => (SessionId(0), Vec::new()),
            };
            let frame = Frame::decode(&arrived);
            let input = match (&op, &frame) {
                (DeviceOp::Open(session, transport), _) => {
                    device::Input::LinkUp { session: *session, transport: *transport, password: OPEN }
                }
                (DeviceOp::Closed(session), _) => device::Input::LinkDown(*session),
                (DeviceOp::Fatal(session), _) => device::Input::Fatal(*session),
                (DeviceOp::Message(session, _), Ok(frame)) => device::Input::received(*session, frame, OPEN),
                (DeviceOp::Datagram(_), Ok(frame)) => match HostMessage::decode(frame) {
                    Ok(message) => device::Input::Datagram { from: SENDER, message },
                    Err(_) => continue,
                },
                (DeviceOp::Stop, _) => device::Input::Stop,
                (DeviceOp::Rig(report), _) => device::Input::Rig(*report),
                (DeviceOp::Wake, _) => device::Input::Wake,
                (op, Err(error)) => panic!("{op:?}: {error:?}"),
            };
            let (expected, next) = device_step(&mut machine, now, input);
            match &op {
                DeviceOp::Open(client, transport) => session.link_up(*client, *transport).unwrap(),
                DeviceOp::Closed(client) => session.link_down(*client).unwrap(),
                DeviceOp::Stop => session.stop().unwrap(),
                DeviceOp::Rig(report) => session.report(*report).unwrap(),
                DeviceOp::Datagram(_) => prop_assert!(session.receive_datagram(now, SENDER, &arrived)),
                DeviceOp::Fatal(_) | DeviceOp::Message(..) => {
                    for piece in arrived.chunks(piece) {
                        prop_assert_eq!(session.receive(now, client, piece), piece.len());
                    }
                }
                DeviceOp::Wake => {}
            }
            let (found, _) = device_poll(&mut session, now, &mut room);
            prop_assert_eq!(&found, &expected, "after {:?}", op);
            prop_assert_eq!(session.may_move(), machine.may_move());
            wake = next;
        }
    }

    #[test]
    fn a_device_may_move_while_a_motor_moves_and_not_after_a_stop_when_all_motors_rest(
        options in device_options(), ops in vec((time(), device_op(), prop::bool::weighted(0.2)), 1..60),
    ) {
        let (mut session, mut rig) = (Box::new(device::Session::new(DeviceMachine::new(options))), Rig::default());
        let mut now = Millis(0);
        session.report(Report::Started).unwrap();
        rig.poll(&mut session, now);
        for (time, op, is_stopped) in ops {
            now = time.pass(now, rig.wake);
            match op {
                DeviceOp::Open(client, transport) if client != CLIENT => session.link_up(client, transport).unwrap(),
                DeviceOp::Closed(client) if client != CLIENT => session.link_down(client).unwrap(),
                DeviceOp::Rig(report) => rig.report(&mut session, report),
                DeviceOp::Message(_, wire) => {
                    let arrived = bytes(&wire);
                    prop_assert_eq!(session.receive(now, CLIENT, &arrived), arrived.len());
                    prop_assert!(arrived.is_empty() || session.may_move(), "bytes wait");
                }
                _ => {}
            }
            if is_stopped {
                // What arrived before a stop does not undo it.
                session.stop().unwrap();
                prop_assert!(session.may_move(), "the stop waits");
                rig.is_held = true;
                rig.poll(&mut session, now);
                rig.is_held = false;
                prop_assert!(rig.sent.is_empty() && !rig.plays && rig.shutter == Millis(0));
                rig.report(&mut session, Report::Started);
                for motor in (1..=10).map(MotorAddress) {
                    rig.report(&mut session, Report::Arrived(motor, Rotations(0.0)));
                }
            }
            rig.poll(&mut session, now);
            prop_assert!(!is_stopped || !session.may_move(), "{:?}", session);
        }
    }

    #[test]
    fn commands_that_wait_keep_their_order_except_that_a_stop_goes_first(
        batches in vec((time(), device_message(), vec(command(), 0..5)), 1..40),
    ) {
        let options = host::Options::default();
        let (mut machine, mut session) = (HostMachine::new(options), Box::new(host::Session::<40_000>::new(options)));
        let (mut now, mut wake, mut room, mut number) = (Millis(0), None, Vec::new(), 0);
        for (time, message, commands) in batches {
            now = time.pass(now, wake);
            let mut inputs = Vec::new();
            let connects = machine.state() == host::State::Connecting;
            if connects {
                session.link_up();
            }
            for command in commands {
                let token = Token(number);
                number += 1;
                session.command(token, command).unwrap();
                inputs.push((command != host::Command::Stop, token, command));
            }
            inputs.sort_by_key(|(is_last, ..)| *is_last);
            let arrived = bytes(&message);
            prop_assert_eq!(session.receive(now, &arrived), arrived.len());

            let link = connects.then_some(host::Input::LinkUp).into_iter();
            let commands = inputs.into_iter().map(|(_, token, command)| host::Input::Command(token, command));
            let (mut expected, mut is_over) = (Vec::new(), false);
            let received = host::Input::received(&Frame::decode(&arrived).unwrap());
            for input in link.chain(commands).chain([received]) {
                // What arrived on a connection that is over is dropped.
                if is_over && matches!(input, host::Input::Received(_) | host::Input::Malformed { .. }) {
                    continue;
                }
                let was_connected = machine.state().is_connected();
                let (done, next) = host_step(&mut machine, now, input);
                expected.extend(done);
                wake = next;
                is_over |= was_connected && !machine.state().is_connected();
            }
            let (found, _) = host_poll(&mut session, now, &mut room);
            prop_assert_eq!(found, expected);
        }
    }
}
