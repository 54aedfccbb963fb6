//! DMC: any events for a host and a device, alone and with each other on a faulty line, in any order.
//!
//! Input: the window and the quirks, then steps; see `fuzz::machines`.

#![no_main]

use dmc_proto::device::{self, DeviceMachine, Event as Told, Quirks, Rig, Stop as Stopped, Store};
use dmc_proto::host::{self, Command, Event, HostMachine, Name, Stop, Token, What};
use dmc_proto::message::{
    AckCode, Capabilities, FrameNumber, Hi, Motor, Motors, Name as RigName, Steps, Triggers, VirtualMotor,
};
use dmc_proto::upload::{MoveSource, SCRATCH, Section, SectionSize};
use dmc_proto::{DecodeError, DeviceMessage, Frame, HostMessage, MessageId, MessageType};
use fuzz::fuzz_world;
use fuzz::machines::{Bytes, Line, Tokens, Watched, print};
use motion_core::time::Millis;

fuzz_world!(World);

/// A rig with every capability and eight motors.
fn hi() -> Hi<'static> {
    Hi {
        name: RigName::truncated("fuzz"),
        fw_major: 1,
        fw_minor: 2,
        fw_rev: 3,
        motor_count: 8,
        dmx_count: 100,
        gio_out_count: 4,
        gio_in_count: 4,
        hw_limit_count: 2,
        upload_frame_count: 1000,
        capabilities: Capabilities(0x07FF),
        protocol_version: Some(2),
        tail: &[],
    }
}

/// Rig whose motors stand at ten times their number. In the move each motor moves as many steps per frame as its
/// number.
struct Tens;

impl Rig for Tens {
    fn position(&self, motor: Motor) -> Steps {
        Steps(10 * i32::from(motor.0))
    }
}

impl MoveSource for Tens {
    fn start_frame(&self) -> FrameNumber {
        FrameNumber(1)
    }

    fn frame_count(&self) -> u32 {
        10
    }

    fn motors(&self) -> Motors {
        Motors(3)
    }

    fn position(&self, motor: Motor, index: u32) -> Steps {
        Steps(i32::from(motor.0) * index.cast_signed())
    }
}

struct World<'i> {
    now: Millis,
    host: Watched<HostMachine>,
    device: Watched<DeviceMachine>,
    to_device: Line,
    to_host: Line,
    tokens: Tokens,
    /// Message of each token from 1 on, and how often it was sent.
    messages: Vec<(HostMessage<'i>, u32)>,
    /// Last stored data.
    store: Option<Store>,
}

impl<'i> World<'i> {
    fn new(bytes: &mut Bytes<'i>) -> Self {
        let host = host::Options::default().with_window(bytes.byte());
        let device = device::Options::of(hi()).with_quirks(Quirks(u16::from_le_bytes(bytes.few())));
        Self {
            now: Millis(1000),
            host: Watched::new(HostMachine::new(host)),
            device: Watched::new(DeviceMachine::new(device)),
            to_device: Line::default(),
            to_host: Line::default(),
            tokens: Tokens::default(),
            messages: Vec::new(),
            store: None,
        }
    }

    fn act(&mut self, bytes: &mut Bytes<'i>) {
        match bytes.byte() % 16 {
            0..4 => {
                if let Some(frame) = self.to_device.take(bytes) {
                    let rig = if bytes.byte() == 1 { AckCode::ERR_SOFT_UP } else { AckCode::OK };
                    let header = [2, 6].map(|at| frame[at..].first_chunk().copied().unwrap_or_default());
                    let id = MessageId(u32::from_le_bytes(header[0]));
                    let kind = MessageType(u16::from_le_bytes([header[1][0], header[1][1]]));
                    self.tell_device(
                        Frame::decode(&frame)
                            .map_or(device::Input::Corrupt(id, kind), |frame| device::Input::frame(&frame, |_| rig)),
                    );
                }
            }
            4..8 => {
                if let Some(frame) = self.to_host.take(bytes) {
                    self.tell_host(
                        Frame::decode(&frame).map_or(host::Input::Corrupt, |frame| host::Input::frame(&frame)),
                    );
                }
            }
            8 => {
                let id = MessageId(bytes.byte().into());
                let input = match bytes.message::<HostMessage<'_>>() {
                    Ok(message) => device::Input::Received { id, message, rig: AckCode::OK },
                    Err((number, error)) => device::Input::Malformed(id, kind_of(number, error)),
                };
                self.tell_device(input);
            }
            9 => {
                let id = self.id(bytes);
                let input = match bytes.message::<DeviceMessage<'_>>() {
                    Ok(message) => host::Input::Received(id, message),
                    Err((number, error)) => host::Input::Malformed(id, kind_of(number, error)),
                };
                self.tell_host(input);
            }
            10 | 11 => {
                let input = self.report(bytes);
                self.tell_device(input);
            }
            12 => self.tell_device(device::Input::Wake),
            13 => {
                let input = match bytes.byte() % 8 {
                    0 => host::Input::LinkDown,
                    1 => host::Input::Section(Section::first(&Tens, SectionSize::default())),
                    2 => host::Input::Section(None),
                    3 => host::Input::LinkUp,
                    _ => host::Input::Wake,
                };
                self.tell_host(input);
            }
            _ => self.command(bytes),
        }
    }

    /// An id that is pending, or any small id.
    fn id(&self, bytes: &mut Bytes<'_>) -> MessageId {
        let choice = bytes.byte();
        let pending = self.host.machine.pending().nth(choice.into());
        pending.map_or(MessageId(choice.into()), |(id, _)| id)
    }

    fn report(&self, bytes: &mut Bytes<'_>) -> device::Input<'static> {
        let (what, which) = (bytes.byte(), bytes.byte());
        let motor = Motor(which % 10);
        match what % 16 {
            0 => device::Input::LinkUp,
            1 => device::Input::LinkDown,
            2 => device::Input::Moving(Motors(which.into())),
            3..7 => device::Input::AtRest,
            7 => device::Input::Frame(FrameNumber(which.into())),
            8 => device::Input::PassEnd,
            9 => device::Input::OperatorGo,
            10 => device::Input::Limit { motor, upper: which > 100 },
            11 => device::Input::EmergencyStop(which > 100),
            12 => device::Input::Fault(Some(motor)),
            13 => device::Input::Inputs(Triggers(which.into())),
            14 => device::Input::Aimed,
            // The last data is stored once more.
            _ => self.store.map_or(device::Input::Wake, |store| device::Input::Stored(store, AckCode(which.into()))),
        }
    }

    fn command(&mut self, bytes: &mut Bytes<'i>) {
        let what = bytes.byte() % 16;
        let command = match what {
            0 => Command::Greet,
            1 => Command::Configured,
            2 | 3 => Command::Go,
            4 => Command::EndStops,
            5 => Command::Stop(Stop::Motor(Motor(bytes.byte()))),
            6 => Command::Stop(Stop::Virtual(VirtualMotor(bytes.byte()))),
            7 => Command::Stop(if bytes.flag() { Stop::AllSilent } else { Stop::All }),
            _ => {
                let Ok(message) = bytes.message() else { return };
                self.messages.push((message, 0));
                let token = Token(self.tokens.begin());
                if what < 12 { Command::Request(token, message) } else { Command::Sequence(token, message) }
            }
        };
        self.tell_host(host::Input::Command(command));
    }

    fn tell_host(&mut self, input: host::Input<'_>) {
        let is_open = self.host.machine.state() != host::State::Closed;
        let output = self.host.step(self.now, input, host::Input::Wake);
        if let host::Input::Command(Command::Stop(_)) = input {
            let is_first = output.send.first().is_some_and(|send| matches!(send.what, What::Stop(_)));
            assert_eq!(is_first, is_open, "a stop is sent first in its step: {output:?}");
        }
        let mut section = None;
        for event in &output.events {
            match *event {
                Event::Done(Token(token), _) | Event::Failed(Token(token), _) => self.tokens.end(token),
                Event::NextSection(behind) => section = Some(behind),
                _ => {}
            }
        }
        for send in &output.send {
            let mut scratch = [0; SCRATCH];
            let message = send.message(|name| match name {
                Name::Message(Token(token)) => {
                    let (message, times) = &mut self.messages[token as usize - 1];
                    *times += 1;
                    assert!(*times <= if message.is_repeatable() { 3 } else { 1 }, "{message} is sent {times} times");
                    *message
                }
                Name::Section(section) => section.message(&Tens, &mut scratch),
            });
            let mut frame = vec![0; message.encoded_len()];
            assert_eq!(message.encode_into(send.id, &mut frame), Ok(frame.len()), "{message}");
            let decoded = Frame::decode(&frame).expect("a frame that was just encoded");
            assert_eq!((decoded.id(), HostMessage::decode(&decoded)), (send.id, Ok(message)));
            self.to_device.put(&frame);
        }
        if let Some(behind) = section {
            let size = SectionSize::of(29);
            let next = behind.map_or_else(|| Section::first(&Tens, size), |section| section.next(&Tens, size));
            self.tell_host(host::Input::Section(next));
        }
    }

    fn tell_device(&mut self, input: device::Input<'_>) {
        let output = self.device.step(self.now, input, device::Input::Wake);
        if let device::Input::Received { message: HostMessage::MotorStopAll(_), .. } = input {
            let first = output.events.first();
            assert!(
                matches!(first, Some(Told::Stop(Stopped::All { .. } | Stopped::Harder | Stopped::Hard))),
                "a stop is obeyed first in its step: {output:?}"
            );
        }
        for send in &output.send {
            let mut scratch = device::Scratch::default();
            let message = send.message(&Tens, &mut scratch);
            let mut frame = vec![0; message.encoded_len()];
            assert_eq!(message.encode_into(send.id, &mut frame), Ok(frame.len()), "{message}");
            let decoded = Frame::decode(&frame).expect("a frame that was just encoded");
            assert_eq!((decoded.id(), DeviceMessage::decode(&decoded)), (send.id, Ok(message)));
            self.to_host.put(&frame);
        }
        for event in output.events {
            if let Told::Store(store) = event {
                self.store = Some(store);
                self.tell_device(device::Input::Stored(store, AckCode::OK));
            }
        }
    }
}

/// Type of a message that is too short, from its number in the tables.
fn kind_of(number: u32, error: DecodeError) -> MessageType {
    print(&error);
    MessageType(u16::try_from(number).unwrap_or_default())
}
