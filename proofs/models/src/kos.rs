//! Client and device of kOS, with a rig of one motor.
//!
//! Over TCP, messages come complete and in order. The connection may be cut at any point: then a first part of the
//! messages in flight still comes in each direction, and after it the end. Over USB, messages may be lost and damaged,
//! and replies doubled.

mod model;
mod rig;
mod state;

use kos_proto::device::{self, DeviceMachine, Profile, Report, Scratch, SessionId, To, What};
use kos_proto::host::{self, Command, Event, Get, HostMachine, Source, Token};
use kos_proto::message::{MarkBeginPosition, MarkEndPosition, Rotations};
use kos_proto::summary::{Direction, MotorSet, MoveSummary, Transport};
use kos_proto::trajectory::TrajectoryData;
use kos_proto::{DecodeError, DeviceMessage, HostMessage};
use laws::machine::step;
use motion_core::time::Millis;
use motion_core::wire::Password;

pub use self::rig::{MOTOR, RANGE, Rig};
pub use self::state::{Breach, Link, State, Told};
use crate::line::{Fate, Faults, Line};

const SESSION: SessionId = SessionId(0);
/// Error of a damaged report.
const CUT: DecodeError = DecodeError::Truncated { what: "report", needed: 1, have: 0 };

/// Setup of the model, and its bounds.
#[derive(Clone, Copy, Debug)]
pub struct Kos {
    /// Transport between client and device.
    pub transport: Transport,
    /// Password of the device. With a password, the client starts without a connection.
    pub password: &'static [u8],
    /// Password that the application has.
    pub known: &'static [u8],
    /// Move with its blocks.
    pub data: TrajectoryData<'static>,
    /// Requests of the application, and the number of times that each may come.
    pub script: &'static [(Wish, u8)],
    /// Number of times that time advances.
    pub jumps: u8,
    /// Whether time advances only when no message is in flight, so that no message is seconds late.
    pub prompt: bool,
    /// Number of times that the connection may be cut.
    pub cuts: u8,
    /// Faults of USB reports: lost and damaged in each direction, doubled from the device.
    pub faults: Faults,
    /// Number of times that the motor may fail.
    pub failures: u8,
    /// Mistake that the properties must find.
    pub wrong: Wrong,
}

/// Mistake in a machine, made on purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrong {
    /// No mistake.
    Nothing,
    /// The device ignores stops.
    DeafToStops,
    /// The client sends its start again if it is not confirmed in time.
    StartsAgain,
    /// The client does not send an unconfirmed stop first on another connection.
    ForgetsStops,
}

/// Request of the application.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// Stop everything.
    Stop,
    /// Stop the motor.
    StopMotor,
    /// Store the move, and make it ready.
    Load,
    /// Store the move, and make it ready with the motor where it is.
    LoadHere,
    /// Play the move.
    Play,
    /// Store the move, and play it.
    PlayDirect,
    /// Go to the start of the move.
    Rapid,
    /// Send the motor to a position.
    MoveTo,
    /// Send the motor a distance.
    Bump,
    /// Run the motor.
    Jog,
    /// Ask for the state of the LEDs.
    Ask,
    /// Send the password.
    Unlock,
    /// Close the connection.
    Disconnect,
}

/// Next event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Action {
    /// The application makes a request, given by its place in the script.
    Wish(u8),
    /// The first message to the device meets its fate.
    ToDevice(Fate),
    /// The first message to the client meets its fate.
    ToHost(Fate),
    /// The wake time of the client comes.
    HostWakes,
    /// The wake time of the device comes.
    DeviceWakes,
    /// The connection that the client wants is open.
    Opens,
    /// The connection that the client wants cannot be opened.
    OpensNot,
    /// The connection is cut.
    Cut,
    /// The client sees the cut.
    HostSees,
    /// The device sees the cut.
    DeviceSees,
    /// The motor rests.
    Arrives,
    /// The motor fails.
    Fails,
}

impl Kos {
    fn command(&self, wish: Wish) -> Command {
        let summary = || MoveSummary::of(&self.data).expect("a move that can be played");
        let way = Direction::Forward;
        match wish {
            Wish::Stop => Command::Stop,
            Wish::StopMotor => Command::StopMotor(MOTOR),
            Wish::Load => Command::Load { summary: summary(), way, delay_return: false },
            Wish::LoadHere => Command::Load { summary: summary(), way, delay_return: true },
            Wish::Play => Command::Play,
            Wish::PlayDirect => Command::PlayDirect { summary: summary(), way },
            Wish::Rapid => Command::RapidToFirstKeyFrame,
            Wish::MoveTo => Command::MoveTo(rig::go(3.0)),
            Wish::Bump => Command::Bump(rig::go(1.0)),
            Wish::Jog => Command::Jog { motor: MOTOR, speed: rig::SPEED, acceleration: rig::ACCELERATION },
            Wish::Ask => Command::Get(Get::LedStatus, Token(1)),
            Wish::Unlock => Command::Unlock,
            Wish::Disconnect => Command::Disconnect,
        }
    }

    /// A device with a calibrated motor, and a client; connected and ready, unless there is a password.
    fn begin(&self) -> State {
        let options = device::Options::default().with_motors(MotorSet::of([MOTOR])).with_progress_every(None);
        let mut state = State {
            now: Millis(1_000),
            host: HostMachine::new(host::Options::default().with_echo_password(false)),
            device: DeviceMachine::new(options),
            host_wake: None,
            device_wake: None,
            to_device: Line::new(Faults::default()),
            to_host: Line::new(Faults::default()),
            link: Link::Down,
            rig: Rig::new(),
            wishes: [0; 8],
            jumps: self.jumps,
            cuts: self.cuts,
            failures: self.failures,
            ledger: state::Ledger::default(),
            told: Told::default(),
        };
        for (left, (_, budget)) in state.wishes.iter_mut().zip(self.script) {
            *left = *budget;
        }
        let (motor_address, tail, password) = (MOTOR, &[][..], Password(b""));
        let from = |message| device::Input::Received { session: SESSION, message, password };
        self.device(&mut state, device::Input::Rig(Report::Started));
        self.device(&mut state, device::Input::Opened { session: SESSION, transport: Transport::Usb, password });
        self.device(&mut state, device::Input::Rig(Report::Arrived(MOTOR, Rotations(0.0))));
        self.device(&mut state, from(HostMessage::MarkBeginPosition(MarkBeginPosition { motor_address, tail })));
        self.device(&mut state, device::Input::Rig(Report::Arrived(MOTOR, RANGE)));
        self.device(&mut state, from(HostMessage::MarkEndPosition(MarkEndPosition { motor_address, tail })));
        self.device(&mut state, device::Input::Closed(SESSION));
        let endpoint = match self.transport {
            Transport::Tcp => host::Endpoint::Tcp(kos_proto::message::Ipv4(0xC0A8_3201)),
            Transport::Usb => host::Endpoint::Usb,
        };
        self.host(&mut state, host::Input::Command(Command::Connect(endpoint)));
        if self.password.is_empty() {
            self.open(&mut state);
            loop {
                if let Some((send, _)) = state.to_device.meet(Fate::Arrives) {
                    self.arrives_at_device(&mut state, send, true);
                } else if let Some((what, _)) = state.to_host.meet(Fate::Arrives) {
                    self.arrives_at_host(&mut state, &what, true);
                } else {
                    break;
                }
            }
            assert_eq!(state.host.state(), host::State::Ready);
        }
        state.to_device = Line::new(Faults { doubled: 0, ..self.faults });
        state.to_host = Line::new(self.faults);
        state.told = Told::default();
        state
    }

    /// Makes a step of the client, and everything that follows from it.
    fn host(&self, state: &mut State, input: host::Input<'_>) {
        let (host, mut output) = step(state.host.clone(), state.now, input);
        state.host = host;
        state.host_wake = output.wake;
        if self.wrong == Wrong::StartsAgain
            && input == host::Input::Wake
            && state.host.move_state() == host::MoveState::Starting
        {
            output.send(host::Send::Start(Direction::Forward));
        }
        if self.wrong == Wrong::ForgetsStops && input == host::Input::Opened {
            output.send.retain(|send| *send != host::Send::StopPlayback);
        }
        state.ledger_of_host(&input, &output);
        for event in &output.events {
            match event {
                Event::Open(_) => state.link = Link::Opening,
                Event::Closed(_) if state.link.is_open_for_device() => {
                    state.link = Link::Cut { host: true, device: false };
                }
                Event::Closed(_) => state.link = Link::Down,
                _ => {}
            }
        }
        if state.link == Link::Up {
            state.to_device.send(output.send);
        }
    }

    /// Makes a step of the device, and everything that follows from it.
    fn device(&self, state: &mut State, input: device::Input<'_>) {
        let heard = match input {
            device::Input::Received { session, message: HostMessage::StopPlayback(empty), password }
                if self.wrong == Wrong::DeafToStops =>
            {
                device::Input::Received { session, message: HostMessage::KeepAlive(empty), password }
            }
            input => input,
        };
        let (device, output) = step(state.device.clone(), state.now, heard);
        state.device = device;
        state.device_wake = output.wake;
        for event in &output.events {
            if !state.rig.follow(state.now, event) {
                state.ledger.breach(Breach::TwoMoves);
            }
            if let device::Event::Close(..) = event {
                state.link = Link::Cut { host: state.link == Link::Cut { host: true, device: false }, device: true };
                state.to_device.cut();
            }
        }
        state.ledger_of_device(&input, &output);
        if state.link == Link::Up {
            let ours = |to| matches!(to, To::Sessions(sessions) if sessions.contains(SESSION));
            state.to_host.send(output.send.into_iter().filter(|send| ours(send.to)).map(|send| send.what));
        }
        if state.link == (Link::Cut { host: true, device: true }) {
            state.link = Link::Down;
        }
    }

    fn open(&self, state: &mut State) {
        state.to_device.cut();
        state.to_host.cut();
        state.link = Link::Up;
        let (transport, password) = (self.transport, Password(self.password));
        self.device(state, device::Input::Opened { session: SESSION, transport, password });
        self.host(state, host::Input::Opened);
    }

    /// Delivers a message to the device. A damaged report is cut off after its header.
    fn arrives_at_device(&self, state: &mut State, send: host::Send, sound: bool) {
        let source = Source { user_password: Password(self.known), trajectory: self.data, ..Source::default() };
        let (message, password) = (send.message(&source), Password(self.password));
        let (id, kind, session) = (message.id(), message.kind(), SESSION);
        let input = match sound {
            true => device::Input::Received { session, message, password },
            false => device::Input::Malformed { session, id, kind, error: CUT },
        };
        self.device(state, input);
    }

    fn arrives_at_host(&self, state: &mut State, what: &What, sound: bool) {
        let profile =
            Profile { guid: &[7; 16], password: Password(self.password), trajectory: self.data, ..Profile::default() };
        let (send, mut scratch) = (device::Send { to: To::Asker, what: what.clone() }, Scratch::default());
        let message: DeviceMessage<'_> = send.message(&profile, &mut scratch);
        let (id, kind) = (message.id(), message.kind());
        let input = match sound {
            true => host::Input::Received(message),
            false => host::Input::Malformed { id, kind, error: CUT },
        };
        self.host(state, input);
    }
}
