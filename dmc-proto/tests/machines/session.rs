//! Sessions do what their machines do, with bytes in any pieces.

use std::collections::HashMap;

use dmc_proto::device::{self, DeviceMachine, Quirks};
use dmc_proto::host::{self, Command, HostMachine, NotTaken, Source, StopTarget};
use dmc_proto::message::{AckCode, HostMessage, Motor, Motors, Steps};
use dmc_proto::upload::{SCRATCH, Section, SectionSize};
use dmc_proto::{
    DeviceMessage, DeviceReader, Effect, EncodeError, HostReader, Item, MessageId, MessageType, Millis, Patience, Token,
};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

use super::app::{Tens, hi};
use super::bench::stop_all;
use super::random::{report, sensible};
use super::world::{answer_id, device_message};

/// Everything that follows from one step, and the wake.
type Step = (Vec<String>, Option<Millis>);

/// Host as its documentation says that a machine is called.
struct Plain {
    machine: HostMachine,
    reader: HostReader,
    messages: HashMap<Token, HostMessage<'static>>,
    wake: Option<Millis>,
}

impl Plain {
    fn give(&mut self, now: Millis, input: host::Input<'_>) -> Vec<String> {
        step(&mut self.machine, &mut self.wake, &self.messages, now, input)
    }

    /// Takes bytes, the time, and frames that are overdue.
    fn receive(&mut self, now: Millis, pieces: std::slice::Chunks<'_, u8>) -> Vec<String> {
        let mut done = Vec::new();
        for piece in pieces {
            assert_eq!(self.reader.push(now, piece), piece.len());
        }
        loop {
            while let Some(item) = self.reader.next() {
                let input = match item {
                    Item::Frame(frame) => host::Input::received(&frame),
                    Item::Corrupt { .. } => host::Input::Corrupt,
                    _ => continue,
                };
                done.extend(step(&mut self.machine, &mut self.wake, &self.messages, now, input));
            }
            if self.reader.deadline().is_none_or(|deadline| deadline > now) {
                break;
            }
            self.reader.give_up(now);
        }
        if self.wake.is_some_and(|wake| wake <= now) {
            done.extend(self.give(now, host::Input::Wake));
        }
        done
    }
}

fn step(
    machine: &mut HostMachine,
    wake: &mut Option<Millis>,
    messages: &HashMap<Token, HostMessage<'static>>,
    now: Millis,
    input: host::Input<'_>,
) -> Vec<String> {
    let output = machine.advance(now, input);
    *wake = output.wake;
    let (mut done, mut next) = (Vec::new(), None);
    for effect in output {
        match effect {
            Effect::Event(host::Event::NextSection { after, .. }) => next = Some(after),
            Effect::Event(event) => done.push(format!("{event:?}")),
            Effect::Transmit(transmit) => {
                let (mut scratch, mut bytes) = ([0; SCRATCH], [0; 1048]);
                let written = transmit.encode_into(
                    |source| match source {
                        Source::Command(token) => messages[&token],
                        Source::Section(section) => section.message(&Tens, &mut scratch),
                    },
                    &mut bytes,
                );
                done.push(format!("> {:02x?}", &bytes[..written.unwrap()]));
            }
        }
    }
    if let Some(after) = next {
        let size = SectionSize::default();
        let section = after.map_or_else(|| Section::first(&Tens, size), |section| section.next(&Tens, size));
        done.extend(step(machine, wake, messages, now, host::Input::Section(section)));
    }
    done
}

fn poll<const N: usize>(session: &mut host::Session<N>, now: Millis, room: &mut Vec<u8>) -> Step {
    let mut done = Vec::new();
    loop {
        match session.poll(now, &Tens, room) {
            Ok(host::Next::Transmit(bytes)) => done.push(format!("> {bytes:02x?}")),
            Ok(host::Next::Event(event)) => done.push(format!("{event:?}")),
            Ok(host::Next::Wait(wake)) => return (done, wake),
            Err(EncodeError::BufferTooSmall { needed, .. }) => room.resize(needed, 0),
            Err(error) => panic!("{error}"),
        }
    }
}

#[derive(Debug, Clone)]
enum HostOp {
    Line(bool),
    Greets,
    Request(Index),
    Sequence(Index),
    Stop(u8),
    Command(u8),
    Answer(u32, Option<AckCode>),
    Hostile(u32, u32, Vec<u8>),
    Bytes(Vec<u8>),
    Pass(u64),
}

fn host_ops() -> impl Strategy<Value = Vec<(HostOp, usize)>> {
    let code = prop_oneof![6 => Just(AckCode::OK), 1 => any::<u16>().prop_map(AckCode)];
    let op = prop_oneof![
        1 => prop::bool::weighted(0.8).prop_map(HostOp::Line),
        1 => Just(HostOp::Greets),
        4 => any::<Index>().prop_map(HostOp::Request),
        3 => any::<Index>().prop_map(HostOp::Sequence),
        2 => any::<u8>().prop_map(HostOp::Stop),
        3 => (0_u8..4).prop_map(HostOp::Command),
        10 => (0_u32..6, prop::option::of(code)).prop_map(|(id, code)| HostOp::Answer(id, code)),
        2 => (0_u32..50, 0_u32..0x220, vec(any::<u8>(), 0..60))
            .prop_map(|(id, kind, body)| HostOp::Hostile(id, kind, body)),
        1 => vec(any::<u8>(), 0..30).prop_map(HostOp::Bytes),
        6 => prop_oneof![3 => 0..200_u64, 1 => 200..3000_u64].prop_map(HostOp::Pass),
    ];
    vec((op, 1..40_usize), 1..80)
}

/// Bytes that arrive in a step.
fn arrives(machine: &HostMachine, op: &HostOp) -> Vec<u8> {
    let (id, kind, body) = match op {
        HostOp::Answer(choice, code) => {
            let id = answer_id(machine, *choice);
            let kind = machine.pending().find(|pending| pending.0 == id).map_or(MessageType(0x33), |found| found.1);
            let body = code.map_or([0; 2], |code| code.0.to_le_bytes());
            let kind = if code.is_some() { kind.ack() } else { kind };
            (id, u32::from(kind.0), [&body[..], &[0; 60]].concat())
        }
        HostOp::Hostile(choice, kind, body) => (answer_id(machine, *choice), *kind, body.clone()),
        HostOp::Bytes(bytes) => return bytes.clone(),
        HostOp::Greets => return encoded(MessageId(1), &hi().into()),
        _ => return Vec::new(),
    };
    device_message(kind, &body).map(|message| encoded(id, &message)).unwrap_or_default()
}

fn encoded(id: MessageId, message: &DeviceMessage<'_>) -> Vec<u8> {
    let mut bytes = vec![0; message.encoded_len()];
    message.encode_into(id, &mut bytes).map(|_| bytes).unwrap_or_default()
}

/// Device as its documentation says that a machine is called.
struct PlainDevice {
    machine: DeviceMachine,
    reader: DeviceReader,
    wake: Option<Millis>,
    /// What was to be stored.
    stores: Vec<device::Store>,
}

impl PlainDevice {
    fn give(&mut self, now: Millis, input: device::Input<'_>) -> Vec<String> {
        device_step((&mut self.machine, &mut self.wake, &mut self.stores), now, input)
    }

    fn receive(&mut self, now: Millis, pieces: std::slice::Chunks<'_, u8>) -> Vec<String> {
        let mut done = Vec::new();
        for piece in pieces {
            assert_eq!(self.reader.push(now, piece), piece.len());
        }
        loop {
            while let Some(item) = self.reader.next() {
                let input = match item {
                    Item::Frame(frame) => device::Input::received(&frame, |message| verdict(message)),
                    Item::Corrupt { header, .. } => device::Input::Corrupt(header.id(), header.kind()),
                    _ => continue,
                };
                done.extend(device_step((&mut self.machine, &mut self.wake, &mut self.stores), now, input));
            }
            if self.reader.deadline().is_none_or(|deadline| deadline > now) {
                break;
            }
            self.reader.give_up(now);
        }
        if self.wake.is_some_and(|wake| wake <= now) {
            done.extend(self.give(now, device::Input::Wake));
        }
        done
    }
}

/// Rig that refuses to move motor 3.
struct Refuses;

impl device::Rig for Refuses {
    fn position(&self, motor: Motor) -> Steps {
        Steps(10 * i32::from(motor.0))
    }

    fn verdict(&self, message: &HostMessage<'_>) -> AckCode {
        verdict(message)
    }
}

fn verdict(message: &HostMessage<'_>) -> AckCode {
    match message {
        HostMessage::MotorMove(to) if to.motor == Motor(3) => AckCode::ERR_RANGE,
        _ => AckCode::OK,
    }
}

fn device_step(
    (machine, wake, stores): (&mut DeviceMachine, &mut Option<Millis>, &mut Vec<device::Store>),
    now: Millis,
    input: device::Input<'_>,
) -> Vec<String> {
    let output = machine.advance(now, input);
    *wake = output.wake;
    stores.extend(output.events().filter_map(|event| match event {
        device::Event::Store { store, .. } => Some(*store),
        _ => None,
    }));
    let done = output.into_iter().map(|effect| match effect {
        Effect::Event(event) => format!("{event:?}"),
        Effect::Transmit(transmit) => {
            let (mut scratch, mut bytes) = (device::Scratch::default(), [0; 256]);
            let message = transmit.message(&Refuses, &mut scratch);
            let len = message.encode_into(transmit.id, &mut bytes).unwrap();
            format!("> {:02x?}", &bytes[..len])
        }
    });
    done.collect()
}

fn device_poll(session: &mut device::Session, now: Millis, room: &mut Vec<u8>) -> Step {
    let mut done = Vec::new();
    loop {
        match session.poll(now, &Refuses, room) {
            Ok(device::Next::Transmit(bytes)) => done.push(format!("> {bytes:02x?}")),
            Ok(device::Next::Event(event)) => done.push(format!("{event:?}")),
            Ok(device::Next::Wait(wake)) => return (done, wake),
            Err(EncodeError::BufferTooSmall { needed, .. }) => room.resize(needed, 0),
            Err(error) => panic!("{error}"),
        }
    }
}

#[derive(Debug, Clone)]
enum DeviceOp {
    Request(Index, u32),
    Message(HostMessage<'static>),
    Bytes(Vec<u8>),
    Report(u8, u8),
    /// A report, which waits when a stop comes.
    Stop(u8, u8),
    Pass(u64),
}

fn device_ops() -> impl Strategy<Value = Vec<(DeviceOp, usize)>> {
    let op = prop_oneof![
        8 => (any::<Index>(), any::<u32>()).prop_map(|(at, id)| DeviceOp::Request(at, id)),
        1 => vec(any::<u8>(), 0..30).prop_map(DeviceOp::Bytes),
        5 => (0_u8..15, any::<u8>()).prop_map(|(what, which)| DeviceOp::Report(what, which)),
        1 => (2_u8..14, any::<u8>()).prop_map(|(what, which)| DeviceOp::Stop(what, which)),
        3 => prop_oneof![3 => 0..200_u64, 1 => 200..3000_u64].prop_map(DeviceOp::Pass),
    ];
    vec((op, 1..40_usize), 1..80)
}

fn request(id: u32, message: &HostMessage<'_>) -> Vec<u8> {
    let mut bytes = vec![0; message.encoded_len()];
    message.encode_into(MessageId(id), &mut bytes).unwrap();
    bytes
}

/// Gives a report of the rig to a session, as [`report`] makes it.
fn tell(session: &mut device::Session, report: device::Input<'_>) {
    let told = match report {
        device::Input::Rig(device::Report::Moving(motors)) => session.moving(motors),
        device::Input::Rig(device::Report::AtRest) => session.at_rest(),
        device::Input::Rig(device::Report::AtFrame(frame)) => session.at_frame(frame),
        device::Input::Rig(device::Report::PassEnd) => session.pass_end(),
        device::Input::Rig(device::Report::OperatorGo) => session.operator_go(),
        device::Input::Rig(device::Report::Limit { motor, upper }) => session.limit(motor, upper),
        device::Input::Rig(device::Report::EmergencyStop(pressed)) => session.emergency_stop(pressed),
        device::Input::Rig(device::Report::Fault(motor)) => session.fault(motor),
        device::Input::Rig(device::Report::Inputs(inputs)) => session.inputs(inputs),
        other => panic!("{other:?}"),
    };
    told.unwrap();
}

proptest! {
    #[test]
    fn a_session_of_a_host_does_what_its_machine_does(ops in host_ops()) {
        let options = host::Options::default().with_needs_enabled(false);
        let mut plain = Plain {
            machine: HostMachine::new(options),
            reader: HostReader::new(Patience::new().with_line_speed(options.line_speed())),
            messages: HashMap::new(),
            wake: None,
        };
        let (mut session, mut room) = (host::Session::<2048>::new(options), Vec::new());
        let (mut now, all) = (Millis(0), sensible());
        let begins = [HostOp::Line(true), HostOp::Greets, HostOp::Command(1)].map(|op| (op, 7));
        for (token, (op, piece)) in (0..).map(Token).zip(begins.into_iter().chain(ops)) {
            let arrived = arrives(&plain.machine, &op);
            let command = match &op {
                HostOp::Request(at) => Some(Command::Request(*at.get(&all))),
                HostOp::Sequence(at) => Some(Command::Sequence(*at.get(&all))),
                HostOp::Stop(0..30) => Some(Command::Stop(StopTarget::Motor(Motor(1)))),
                HostOp::Stop(_) => Some(Command::Stop(StopTarget::All)),
                HostOp::Command(0) => Some(Command::Go),
                HostOp::Command(1) => Some(Command::Configured),
                HostOp::Command(2) => Some(Command::EndStops),
                HostOp::Command(_) => Some(Command::Greet),
                _ => None,
            };
            match command {
                Some(Command::Request(message)) => session.request(token, message).unwrap(),
                Some(Command::Sequence(message)) => session.sequence(token, message).unwrap(),
                Some(Command::Go) => session.go(token).unwrap(),
                Some(Command::Configured) => session.configured(token).unwrap(),
                Some(Command::EndStops) => session.end_stops(token).unwrap(),
                Some(Command::Stop(StopTarget::All)) => session.stop(token).unwrap(),
                Some(Command::Stop(_)) => session.stop_motor(token, Motor(1)).unwrap(),
                Some(_) => session.greet(token).unwrap(),
                None => {}
            }
            let mut expected = Vec::new();
            if let Some(command) = command {
                if let Command::Request(message) | Command::Sequence(message) = command {
                    plain.messages.insert(token, message);
                }
                expected = plain.give(now, host::Input::Command(token, command));
            }
            match op {
                HostOp::Line(true) => {
                    plain.reader.reset();
                    session.link_up();
                    expected = plain.give(now, host::Input::LinkUp);
                }
                HostOp::Line(false) => {
                    session.link_down();
                    expected = plain.give(now, host::Input::LinkDown);
                }
                HostOp::Pass(millis) => now = now.after(millis),
                _ => {}
            }
            for piece in arrived.chunks(piece) {
                prop_assert_eq!(session.receive(now, piece), piece.len());
            }
            expected.extend(plain.receive(now, arrived.chunks(piece)));
            let (found, _) = poll(&mut session, now, &mut room);
            prop_assert_eq!(&found, &expected, "after {:?}", op);
            prop_assert_eq!(session.may_move(), plain.machine.may_move());
        }
    }

    #[test]
    fn a_session_of_a_device_does_what_its_machine_does(ops in device_ops(), quirks in any::<u32>()) {
        let options = device::Options::of(hi()).with_quirks(Quirks(quirks));
        let patience = Patience::default();
        let machine = DeviceMachine::new(options);
        let mut session = device::Session::new(machine.clone(), patience);
        let mut plain = PlainDevice { machine, reader: DeviceReader::new(patience), wake: None, stores: Vec::new() };
        let (mut now, mut room, all) = (Millis(0), Vec::new(), sensible());
        // A line that is open, and a move that can be run.
        let upload = [9, 10, 12].map(|at| DeviceOp::Message(all[at]));
        let begins = [DeviceOp::Report(0, 0)].into_iter().chain(upload).map(|op| (op, 9));
        for (op, piece) in begins.chain(ops) {
            let (mut expected, mut arrived) = (Vec::new(), Vec::new());
            match &op {
                DeviceOp::Message(message) => arrived = request(7, message),
                DeviceOp::Request(at, id) => arrived = request(*id, at.get(&all)),
                DeviceOp::Bytes(bytes) => arrived.clone_from(bytes),
                DeviceOp::Pass(millis) => now = now.after(*millis),
                DeviceOp::Stop(what, which) => {
                    let waits = report(*what, *which);
                    if !matches!(waits, device::Input::Rig(device::Report::EmergencyStop(_))) {
                        tell(&mut session, waits);
                    }
                    session.stop().unwrap();
                    expected = plain.give(now, device::Input::Rig(device::Report::EmergencyStop(true)));
                    if !matches!(waits, device::Input::Rig(device::Report::EmergencyStop(_))) {
                        expected.extend(plain.give(now, waits));
                    }
                }
                DeviceOp::Report(what, which) => match report(*what, *which) {
                    device::Input::LinkUp => {
                        plain.reader.reset();
                        session.link_up();
                        expected = plain.give(now, device::Input::LinkUp);
                    }
                    device::Input::LinkDown => {
                        session.link_down();
                        expected = plain.give(now, device::Input::LinkDown);
                    }
                    device::Input::Corrupt(..) => continue,
                    input => {
                        tell(&mut session, input);
                        expected = plain.give(now, input);
                    }
                },
            }
            for piece in arrived.chunks(piece) {
                prop_assert_eq!(session.receive(now, piece), piece.len());
            }
            expected.extend(plain.receive(now, arrived.chunks(piece)));
            let (found, _) = device_poll(&mut session, now, &mut room);
            prop_assert_eq!(&found, &expected, "after {:?}", op);
            prop_assert_eq!(session.may_move(), plain.machine.may_move());
            prop_assert!(session.may_move() || session.machine().moving() == Motors::NONE, "after {:?}", op);
            if let DeviceOp::Stop(..) = op {
                session.at_rest().unwrap();
                let expected = plain.give(now, device::Input::Rig(device::Report::AtRest));
                prop_assert_eq!(device_poll(&mut session, now, &mut room).0, expected);
                prop_assert!(!session.may_move(), "after {:?}", op);
            }
            for store in std::mem::take(&mut plain.stores) {
                session.stored(store, AckCode::OK).unwrap();
                let expected = plain.give(now, device::Input::Rig(device::Report::Stored(store, AckCode::OK)));
                prop_assert_eq!(device_poll(&mut session, now, &mut room).0, expected);
            }
        }
    }
}

#[test]
fn a_token_can_be_used_again_when_its_command_has_ended() {
    let (mut session, mut room) = (host::Session::<45>::new(host::Options::default()), vec![0; 1048]);
    assert_eq!(session.request(Token(1), stop_all()), Ok(()));
    let error = session.request(Token(1), stop_all()).unwrap_err();
    assert_eq!(error, NotTaken::TokenInUse(Token(1)));
    assert_eq!(error.to_string(), "the command with token 1 has not ended: choose another token");
    assert_eq!(session.request(Token(2), stop_all()), Ok(()));
    let error = session.request(Token(3), stop_all()).unwrap_err().to_string();
    assert!(error.starts_with("the message cannot be kept: need 1"), "{error}");
    poll(&mut session, Millis(0), &mut room);
    assert_eq!(session.request(Token(1), stop_all()), Ok(()), "without a line, the command ended at once");
}
