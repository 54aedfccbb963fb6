//! kOS: any events for a client and a device, alone and with each other on a faulty line, in any order.
//!
//! Input: options, then steps; see `fuzz::machines`.

#![no_main]

use fuzz::fuzz_world;
use fuzz::machines::{Bytes, arrival, send, step, world};
use kos_proto::device::{self, Destination, DeviceMachine, MotorSpecs, Quirks, Report, SessionId, clients};
use kos_proto::host::{self, Command, Endpoint, Get, Go, HostMachine, Transmit};
use kos_proto::message::{
    AuxInputs, ErrorCode, Ipv4, LedMode, MotorAddress, MotorType, Password, Rotations, RotationsPerSecond,
    RotationsPerSecondSquared, Seconds,
};
use kos_proto::trajectory::TrajectoryData;
use kos_proto::{Device, Effect, Host, HostMessage, MessageId, MessageType, MoveSummary, Transport};
use laws::world::Tokens;
use motion_core::wire::Message;

use self::world::{World, device_bytes, device_stops_first, host_bytes, host_stops_first, to_device, to_host};

#[path = "../../kos-proto/tests/machines/world.rs"]
mod world;

fuzz_world!(Kos);

/// Connection of the client; all others belong to other clients.
const CLIENT: SessionId = SessionId(0);
const PASSWORDS: [Password<'static>; 2] = [Password(b""), Password(b"open")];
/// Bytes of a message that the device may send back.
const ECHO: &[u8] = &[4, 0, 6, 0, 0];
const ENDPOINTS: [Endpoint; 2] = [Endpoint::Usb, Endpoint::Tcp(Ipv4(0xC0A8_3201))];

struct Kos<'i> {
    world: World,
    tokens: Tokens,
    /// Stored password.
    password: Password<'static>,
    /// Whether the device speaks the older dialect.
    older_dialect: bool,
    /// Move of the application.
    trajectory: TrajectoryData<'i>,
}

impl<'i> Kos<'i> {
    fn new(bytes: &mut Bytes<'i>) -> Self {
        let (push, progress, clock, ask) = (bytes.flag(), bytes.flag(), bytes.flag(), bytes.flag());
        let quirks = [Quirks::REQUIRE_EMPTY_PASSWORD, Quirks::BEGIN_NONZERO];
        let quirks = quirks.into_iter().filter(|_| bytes.flag()).fold(Quirks::empty(), |all, quirk| all | quirk);
        let device = device::Options::default()
            .with_quirks(quirks)
            .with_stop_when_alone(bytes.flag())
            .with_push_every(push.then_some(5_000))
            .with_progress_every(progress.then_some(700))
            .with_travel_limit(Some(60_000))
            .with_unix_millis_at_zero(clock.then_some(1_700_000_000_000));
        let host = host::Options::default().with_ask_every(ask.then_some(5_000)).with_reconnect(bytes.flag());
        Self {
            world: world(HostMachine::new(host), DeviceMachine::new(device)),
            tokens: Tokens::default(),
            password: bytes.one_of(&PASSWORDS),
            older_dialect: bytes.flag(),
            trajectory: TrajectoryData::default(),
        }
    }

    fn act(&mut self, bytes: &mut Bytes<'i>) {
        match bytes.byte() % 16 {
            0..4 => {
                if let Some(message) = arrival(&mut self.world.up, bytes) {
                    self.tell_device(to_device(CLIENT, &message, self.password));
                }
            }
            4..8 => {
                if let Some(message) = arrival(&mut self.world.down, bytes) {
                    self.tell_host(to_host(&message));
                }
            }
            8 | 9 => {
                let (session, password) = (session(bytes), self.password);
                let drawn = bytes.message::<Host>();
                let input = match drawn.read() {
                    Ok(message) if bytes.byte() == 1 => {
                        let from = device::Sender { address: Ipv4(0xC0A8_3202), port: 5520 };
                        device::Input::Datagram { from, message }
                    }
                    Ok(message) => device::Input::Received { session, message, bytes: ECHO, password },
                    Err((number, error)) => {
                        let (id, kind) = parts(number);
                        device::Input::Malformed { session, id, kind, error, bytes: ECHO }
                    }
                };
                self.tell_device(input);
            }
            10 | 11 => {
                let drawn = bytes.message::<Device>();
                let input = match drawn.read() {
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
                    let token = self.tokens.begin();
                    self.tell_host(host::Input::Command(token, command));
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
                self.tell_device(device::Input::LinkUp { session: CLIENT, transport, password });
                self.tell_host(host::Input::LinkUp);
            }
            3 => self.tell_device(device::Input::LinkUp { session, transport, password }),
            4 => self.tell_device(device::Input::LinkDown(session)),
            5 => self.tell_device(device::Input::Fatal(session)),
            6 => self.tell_host(host::Input::Fatal),
            _ => {
                self.world.cut();
                self.tell_device(device::Input::LinkDown(CLIENT));
                self.tell_host(host::Input::LinkDown);
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
            6 | 7 => Command::Get(bytes.one_of(&Get::ALL)),
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
                let summary = MoveSummary::of(&self.trajectory).ok()?;
                if what == 21 {
                    Command::PlayDirect { summary }
                } else {
                    Command::Load { summary, delay_return: bytes.flag() }
                }
            }
        })
    }

    fn tell_host(&mut self, input: host::Input<'_>) {
        let was_connected = self.world.host.machine.state().is_connected();
        let output = step(&mut self.world.host, self.world.now, input, host::Input::Wake);
        host_stops_first(&output);
        if let host::Input::Command(_, Command::Stop) = input {
            let is_first = output.effects.first() == Some(&Effect::Transmit(Transmit::StopPlayback));
            assert_eq!(is_first, was_connected, "a stop is sent first in its step: {output:?}");
            let mut transmits = output.transmits();
            assert!(transmits.all(|transmit| transmit.conduct().repeatable), "no motion is sent with it: {output:?}");
        }
        let [_, password] = PASSWORDS;
        let source = host::Source { user_password: password, new_password: password, trajectory: self.trajectory };
        for effect in output {
            match effect {
                Effect::Event(host::Event::Ended { token, .. }) => self.tokens.end(token),
                Effect::Event(_) => {}
                Effect::Transmit(transmit) => {
                    let bytes = host_bytes(&transmit, &source);
                    if transmit != Transmit::Discover {
                        send(&mut self.world.up, self.world.now, &bytes);
                    }
                }
            }
        }
        let host = &self.world.host.machine;
        assert!(host.state().is_connected() || self.tokens.open().count() == 0, "all commands end with the connection");
        let is_stopping = host.move_state() == host::MoveState::Stopping;
        assert!(host.may_move() || !is_stopping, "a stop that is not confirmed is not over");
    }

    fn tell_device(&mut self, input: device::Input<'_>) {
        let stops = match input {
            device::Input::Received { session, message: HostMessage::StopPlayback(_), .. } => {
                self.world.device.machine.session(session) != clients::State::Closed
            }
            _ => false,
        };
        let output = step(&mut self.world.device, self.world.now, input, device::Input::Wake);
        device_stops_first(&output);
        let stopped = output.events().any(|event| *event == device::Event::StopAll);
        assert!(!stops || stopped, "a stop is obeyed in its step: {output:?}");
        let motors = [MotorSpecs { motor_type: MotorType::FIZ, ..MotorSpecs::default() }; 3];
        let source = device::Source {
            older_dialect: self.older_dialect,
            motors: &motors,
            trajectory: self.trajectory,
            ..device::Source::default()
        };
        for effect in output {
            let Effect::Transmit(transmit) = effect else { continue };
            let bytes = device_bytes(&transmit, &source);
            if matches!(transmit.destination, Destination::Sessions(sessions) if sessions.contains(CLIENT)) {
                send(&mut self.world.down, self.world.now, &bytes);
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
