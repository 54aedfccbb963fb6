//! kOS: any events for a client and a device, alone and with each other on a faulty line, in any order.
//!
//! Input: options, then steps; see `fuzz::machines`.

#![no_main]

use fuzz::fuzz_world;
use fuzz::machines::{Bytes, Line, Tokens, Watched};
use kos_proto::device::{
    self, DeviceMachine, Event as Told, MotorProfile, Profile, Report, Scratch, SessionId, To, session,
};
use kos_proto::host::{self, Command, Endpoint, Event, Get, Go, HostMachine, Send, Source, Token};
use kos_proto::message::{
    AuxInputs, ErrorCode, Ipv4, LedMode, MotorAddress, MotorType, Rotations, RotationsPerSecond,
    RotationsPerSecondSquared, Seconds,
};
use kos_proto::summary::{Direction, MoveSummary, Transport};
use kos_proto::trajectory::TrajectoryData;
use kos_proto::{DeviceMessage, Frame, HostMessage, MessageId, MessageType};
use motion_core::time::Millis;
use motion_core::wire::{Message, Password};

fuzz_world!(World);

/// Connection of the client; all others belong to other clients.
const CLIENT: SessionId = SessionId(0);
const PASSWORDS: [Password<'static>; 2] = [Password(b""), Password(b"open")];
const WAYS: [Direction; 2] = [Direction::Forward, Direction::Reverse];
const ENDPOINTS: [Endpoint; 2] = [Endpoint::Usb, Endpoint::Tcp(Ipv4(0xC0A8_3201))];

struct World<'i> {
    now: Millis,
    host: Watched<HostMachine>,
    device: Watched<DeviceMachine>,
    to_device: Line,
    to_host: Line,
    tokens: Tokens,
    /// Stored password.
    password: Password<'static>,
    /// Whether the device speaks the older dialect.
    older_dialect: bool,
    /// Move of the application.
    trajectory: TrajectoryData<'i>,
}

impl<'i> World<'i> {
    fn new(bytes: &mut Bytes<'i>) -> Self {
        let (push, progress, clock, ask) = (bytes.flag(), bytes.flag(), bytes.flag(), bytes.flag());
        let device = device::Options::default()
            .with_require_empty_password(bytes.flag())
            .with_quirk_begin_nonzero(bytes.flag())
            .with_stop_when_alone(bytes.flag())
            .with_push_every(push.then_some(5_000))
            .with_progress_every(progress.then_some(700))
            .with_travel_limit(Some(60_000))
            .with_unix_millis_at_zero(clock.then_some(1_700_000_000_000));
        let host = host::Options::default().with_ask_every(ask.then_some(5_000)).with_reconnect(bytes.flag());
        Self {
            now: Millis(1000),
            host: Watched::new(HostMachine::new(host)),
            device: Watched::new(DeviceMachine::new(device)),
            to_device: Line::default(),
            to_host: Line::default(),
            tokens: Tokens::default(),
            password: bytes.one_of(&PASSWORDS),
            older_dialect: bytes.flag(),
            trajectory: TrajectoryData::default(),
        }
    }

    fn act(&mut self, bytes: &mut Bytes<'i>) {
        match bytes.byte() % 16 {
            0..4 => {
                if let Some(message) = self.to_device.take(bytes) {
                    self.bytes_to_device(&message);
                }
            }
            4..8 => {
                if let Some(message) = self.to_host.take(bytes) {
                    self.bytes_to_host(&message);
                }
            }
            8 | 9 => {
                let (session, password) = (session(bytes), self.password);
                let input = match bytes.message() {
                    Ok(message) if bytes.byte() == 1 => device::Input::Datagram(message),
                    Ok(message) => device::Input::Received { session, message, password },
                    Err((number, error)) => {
                        let (id, kind) = parts(number);
                        device::Input::Malformed { session, id, kind, error }
                    }
                };
                self.tell_device(input);
            }
            10 | 11 => {
                let input = match bytes.message() {
                    Ok(message) => host::Input::Received(message),
                    Err((number, error)) => {
                        let (id, kind) = parts(number);
                        host::Input::Malformed { id, kind, error }
                    }
                };
                self.tell_host(input);
            }
            12 => {
                let input = self.report(bytes);
                self.tell_device(input);
            }
            13 => self.line(bytes),
            14 => {
                self.tell_host(host::Input::Wake);
                self.tell_device(device::Input::Wake);
            }
            _ => {
                if let Some(command) = self.command(bytes) {
                    self.tell_host(host::Input::Command(command));
                }
            }
        }
    }

    /// Makes or loses the connection, on both sides or on one.
    fn line(&mut self, bytes: &mut Bytes<'_>) {
        let (transport, session, password) =
            (bytes.one_of(&[Transport::Tcp, Transport::Usb]), session(bytes), self.password);
        match bytes.byte() % 8 {
            0..3 => {
                self.tell_device(device::Input::Opened { session: CLIENT, transport, password });
                self.tell_host(host::Input::Opened);
            }
            3 => self.tell_device(device::Input::Opened { session, transport, password }),
            4 => self.tell_device(device::Input::Closed(session)),
            5 => self.tell_device(device::Input::Fatal(session)),
            6 => self.tell_host(host::Input::Fatal),
            _ => {
                self.to_device.cut();
                self.to_host.cut();
                self.tell_device(device::Input::Closed(CLIENT));
                self.tell_host(host::Input::Closed);
            }
        }
    }

    fn report(&self, bytes: &mut Bytes<'_>) -> device::Input<'static> {
        let motor = MotorAddress(bytes.byte() % 5);
        device::Input::Rig(match bytes.byte() % 8 {
            0 => Report::Started,
            1 => Report::At(motor, Rotations(bytes.float())),
            2 => Report::CannotHome(motor),
            3 => Report::Fault(motor, ErrorCode(bytes.byte())),
            4 => Report::Online(motor, bytes.flag()),
            5 => Report::Inputs(AuxInputs(bytes.byte())),
            _ => Report::Arrived(motor, Rotations(bytes.float())),
        })
    }

    fn command(&mut self, bytes: &mut Bytes<'i>) -> Option<Command> {
        let what = bytes.byte() % 24;
        let motor = MotorAddress(bytes.byte() % 5);
        let mut go = || Go {
            motor,
            position: Rotations(bytes.float()),
            speed: RotationsPerSecond(bytes.float()),
            acceleration: RotationsPerSecondSquared(20.0),
        };
        Some(match what {
            0 => Command::Stop,
            1 => Command::StopMotor(motor),
            2 => Command::Connect(bytes.one_of(&ENDPOINTS)),
            3 => Command::Disconnect,
            4 => Command::Unlock,
            5 => Command::ChangePassword,
            6 | 7 => Command::Get(bytes.one_of(&Get::ALL), Token(self.token())),
            8 => Command::SetLeds { master: LedMode(bytes.byte()), slave: LedMode(bytes.byte()) },
            9 => Command::SetPlatform(bytes.byte()),
            10 => Command::ResetDevice,
            11 => Command::ResetAxis(motor),
            12 => Command::MarkBegin(motor),
            13 => Command::MarkEnd(motor),
            14 => Command::MoveTo(go()),
            15 => {
                let Go { motor, speed, acceleration, .. } = go();
                Command::Jog { motor, speed, acceleration }
            }
            16 => Command::Bump(go()),
            17 => Command::Alive,
            18 => Command::TakePicture(Seconds(bytes.float())),
            19 => Command::Play,
            20 => Command::RapidToFirstKeyFrame,
            _ => {
                // Without bytes of its own, the command takes the last move.
                let body = bytes.some();
                if !body.is_empty() {
                    self.trajectory = TrajectoryData::decode(body).ok()?;
                }
                let (summary, way) = (MoveSummary::of(&self.trajectory).ok()?, bytes.one_of(&WAYS));
                if what == 21 {
                    Command::PlayDirect { summary, way }
                } else {
                    Command::Load { summary, way, delay_return: bytes.flag() }
                }
            }
        })
    }

    /// Token of a new question, which has 16 bits.
    fn token(&mut self) -> u16 {
        u16::try_from(self.tokens.begin()).expect("fewer steps than tokens")
    }

    fn bytes_to_device(&mut self, message: &[u8]) {
        let (session, password) = (CLIENT, self.password);
        self.tell_device(match Frame::decode(message) {
            Ok(frame) => match HostMessage::decode(&frame) {
                Ok(message) => device::Input::Received { session, message, password },
                Err(error) => device::Input::Malformed { session, id: frame.id(), kind: frame.kind(), error },
            },
            Err(_) => device::Input::Fatal(session),
        });
    }

    fn bytes_to_host(&mut self, message: &[u8]) {
        self.tell_host(match Frame::decode(message) {
            Ok(frame) => match DeviceMessage::decode(&frame) {
                Ok(message) => host::Input::Received(message),
                Err(error) => host::Input::Malformed { id: frame.id(), kind: frame.kind(), error },
            },
            Err(_) => host::Input::Fatal,
        });
    }

    fn tell_host(&mut self, input: host::Input<'_>) {
        let is_connected = self.host.machine.state().is_connected();
        let output = self.host.step(self.now, input, host::Input::Wake);
        if let host::Input::Command(Command::Stop) = input {
            let is_first = output.send.first() == Some(&Send::StopPlayback);
            assert_eq!(is_first, is_connected, "a stop is sent first in its step: {output:?}");
            assert!(output.send.iter().all(Send::is_repeatable), "a stop is not sent with a motion: {output:?}");
        }
        for event in output.events {
            if let Event::Answered(_, Token(token)) | Event::Failed(_, Token(token), _) = event {
                self.tokens.end(token.into());
            }
        }
        let [none, password] = PASSWORDS;
        let source = Source {
            device_password: none,
            user_password: password,
            new_password: password,
            trajectory: self.trajectory,
        };
        for send in output.send {
            let message = send.message(&source);
            let mut bytes = vec![0; message.encoded_len()];
            assert_eq!(message.encode_into(&mut bytes), Ok(bytes.len()), "{message}");
            let frame = Frame::decode(&bytes).expect("a message that was just encoded");
            assert_eq!(HostMessage::decode(&frame), Ok(message));
            if send != Send::Question {
                self.to_device.put(&bytes);
            }
        }
    }

    fn tell_device(&mut self, input: device::Input<'_>) {
        let stops = match input {
            device::Input::Received { session, message: HostMessage::StopPlayback(_), .. } => {
                self.device.machine.session(session) != session::State::Closed
            }
            _ => false,
        };
        let output = self.device.step(self.now, input, device::Input::Wake);
        assert!(!stops || output.events.contains(&Told::StopAll), "a stop is obeyed in its step: {output:?}");
        let motors = [MotorProfile { motor_type: MotorType::FIZ, ..MotorProfile::default() }; 3];
        let profile = Profile {
            older_dialect: self.older_dialect,
            motors: &motors,
            received: &[4, 0, 6, 0, 0],
            trajectory: self.trajectory,
            ..Profile::default()
        };
        for send in &output.send {
            let mut scratch = Scratch::default();
            let message = send.message(&profile, &mut scratch);
            let mut bytes = vec![0; message.encoded_len()];
            assert_eq!(message.encode_into(&mut bytes), Ok(bytes.len()), "{message}");
            let frame = Frame::decode(&bytes).expect("a message that was just encoded");
            assert_eq!(DeviceMessage::decode(&frame), Ok(message));
            if matches!(send.to, To::Sessions(sessions) if sessions.iter().any(|session| session == CLIENT)) {
                self.to_host.put(&bytes);
            }
        }
    }
}

fn session(bytes: &mut Bytes<'_>) -> SessionId {
    SessionId(bytes.byte() % 5)
}

/// Id and type of a message, from its number in the tables.
fn parts(number: u32) -> (MessageId, MessageType) {
    let [i0, i1, kind, _] = number.to_be_bytes();
    (MessageId(u16::from_be_bytes([i0, i1])), MessageType(kind))
}
