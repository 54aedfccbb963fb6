//! Client and device of kOS, with a rig of one motor.
//!
//! Over TCP, messages come complete and in order. The connection may be cut at any point: then a first part of the
//! messages in flight still comes in each direction, and after it the end. Over USB, messages may be lost and damaged,
//! and replies doubled.

mod model;
mod rig;
mod state;
#[path = "../../../kos-proto/tests/machines/world.rs"]
mod world;

use kos_proto::device::{self, Actions, Destination, DeviceMachine, Quirks, Report, SessionId};
use kos_proto::host::{self, Command, Event, Get, HostMachine, Token, Transmit};
use kos_proto::message::{
    ActionId, KeepAlive, MarkBeginPosition, MarkEndPosition, MotorSet, Password, PlaybackDirection, PlaybackState,
    Rotations, StartPlayback,
};
use kos_proto::trajectory::TrajectoryData;
use kos_proto::{DecodeError, DeviceMessage, Effect, Frame, HostMessage, Millis, MoveSummary, Transport};
use laws::world::{Fate, Faults, Line};

pub use self::rig::{MOTOR, RANGE, Rig};
pub use self::state::{Breach, Link, State, Told};
use self::world::{World, device_bytes, device_stops_first, frame, host_bytes, host_stops_first, to_device, to_host};

const SESSION: SessionId = SessionId(0);
/// Time at which every message arrives. A message is late if other things happen first.
const ANY_TIME: Millis = Millis(0);
/// Token of the command to connect. Each wish has tokens of its own, which are smaller.
const CONNECT: Token = Token(31);
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
    /// Way in which the device differs from the document as we read it.
    pub conduct: Conduct,
    /// Mistake that the properties must find.
    pub wrong: Wrong,
}

/// Conduct of the device that the client has to be right with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Conduct {
    /// The device does what the document says.
    Mild,
    /// The device ignores stops while it is locked.
    DeafWhileLocked,
    /// The device plays moves from their end to their begin.
    OtherWay,
    /// The device does not know an action.
    Lacks(ActionId),
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
    /// The client does not send a stop again directly after the password.
    StopsBeforeThePassword,
    /// The client does not see which way a move is played.
    BlindToWays,
    /// The client does not hear that the device does not know a message.
    DeafToRefusals,
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
        match wish {
            Wish::Stop => Command::Stop,
            Wish::StopMotor => Command::StopMotor(MOTOR),
            Wish::Load => Command::Load { summary: summary(), delay_return: false },
            Wish::LoadHere => Command::Load { summary: summary(), delay_return: true },
            Wish::Play => Command::Play,
            Wish::PlayDirect => Command::PlayDirect { summary: summary() },
            Wish::Rapid => Command::RapidToFirstKeyFrame,
            Wish::MoveTo => Command::MoveTo(rig::go(3.0)),
            Wish::Bump => Command::Bump(rig::go(1.0)),
            Wish::Jog => Command::Jog { motor: MOTOR, speed: rig::SPEED, acceleration: rig::ACCELERATION },
            Wish::Ask => Command::Get(Get::LedStatus),
            Wish::Unlock => Command::Unlock,
            Wish::Disconnect => Command::Disconnect,
        }
    }

    /// Token of a wish that may still come so many times.
    fn token(place: u8, left: u8) -> Token {
        let token = Token(u32::from(place) * 4 + u32::from(left));
        assert!(left < 4 && token < CONNECT, "a script is short");
        token
    }

    /// A device with a calibrated motor, and a client; connected and ready, unless there is a password.
    fn begin(&self) -> State {
        let device = device::Options::default().with_motors(MotorSet::of([MOTOR])).with_progress_every(None);
        let device = match self.conduct {
            Conduct::Mild | Conduct::OtherWay => device,
            Conduct::DeafWhileLocked => device.with_quirks(Quirks::LOCKED_IGNORES_STOPS),
            Conduct::Lacks(action) => device.with_unsupported(Actions::NONE.with(action)),
        };
        let host = host::Options::default().with_echo_password(false);
        let (host, device) = (HostMachine::new(host), DeviceMachine::new(device));
        let mut state = State {
            both: World::new(Millis(1_000), host, device, Faults::default()),
            link: Link::Down,
            rig: Rig::new(),
            wishes: [0; 8],
            open: 0,
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
        let from = |message| device::Input::Received { session: SESSION, message, bytes: &[], password };
        self.device(&mut state, device::Input::Rig(Report::Started));
        self.device(&mut state, device::Input::LinkUp { session: SESSION, transport: Transport::Usb, password });
        self.device(&mut state, device::Input::Rig(Report::Arrived(MOTOR, Rotations(0.0))));
        self.device(&mut state, from(MarkBeginPosition { motor_address, tail }.into()));
        self.device(&mut state, device::Input::Rig(Report::Arrived(MOTOR, RANGE)));
        self.device(&mut state, from(MarkEndPosition { motor_address, tail }.into()));
        self.device(&mut state, device::Input::Rig(Report::Arrived(MOTOR, Rotations(0.0))));
        self.device(&mut state, device::Input::LinkDown(SESSION));
        let endpoint = match self.transport {
            Transport::Tcp => host::Endpoint::Tcp(kos_proto::message::Ipv4(0xC0A8_3201)),
            Transport::Usb => host::Endpoint::Usb,
        };
        self.host(&mut state, host::Input::Command(CONNECT, Command::Connect(endpoint)));
        if self.password.is_empty() {
            self.open(&mut state);
            loop {
                if let Some((message, _)) = state.both.up.meet(Fate::Arrives) {
                    self.arrives_at_device(&mut state, &message, true);
                } else if let Some((message, _)) = state.both.down.meet(Fate::Arrives) {
                    self.arrives_at_host(&mut state, &message, true);
                } else {
                    break;
                }
            }
            assert_eq!(state.both.host.machine.state(), host::State::Ready);
        }
        state.both.up = Line::new(Faults { doubled: 0, ..self.faults });
        state.both.down = Line::new(self.faults);
        state.told = Told::default();
        state
    }

    /// Makes a step of the client, and everything that follows from it.
    fn host(&self, state: &mut State, input: host::Input<'_>) {
        let mut output = state.both.step_host(input);
        host_stops_first(&output);
        if self.wrong == Wrong::StartsAgain
            && input == host::Input::Wake
            && state.both.host.machine.move_state() == host::MoveState::Starting
        {
            output.transmit(Transmit::Start);
        }
        if self.wrong == Wrong::StopsBeforeThePassword {
            let mut is_after = false;
            output.effects.retain(|effect| {
                let keeps = !is_after || *effect != Effect::Transmit(Transmit::StopPlayback);
                is_after |= matches!(effect, Effect::Transmit(Transmit::UserPassword(_)));
                keeps
            });
        }
        if self.wrong == Wrong::ForgetsStops && input == host::Input::LinkUp {
            output.effects.retain(|effect| *effect != Effect::Transmit(Transmit::StopPlayback));
        }
        state.ledger_of_host(&input, &output, self.faults.doubled == 0);
        let (user_password, new_password) = (Password(self.known), Password(b""));
        let source = host::Source { user_password, new_password, trajectory: self.data };
        let mut sent = Vec::new();
        for effect in output {
            match effect {
                Effect::Transmit(transmit) => sent.push(host_bytes(&transmit, &source)),
                Effect::Event(Event::Connect(_)) => state.link = Link::Opening,
                Effect::Event(Event::LinkDown(_)) if state.link.is_open_for_device() => {
                    state.link = Link::Cut { host: true, device: false };
                }
                Effect::Event(Event::LinkDown(_)) => state.link = Link::Down,
                Effect::Event(_) => {}
            }
        }
        if state.link == Link::Up {
            sent.into_iter().for_each(|message| state.both.up.send(ANY_TIME, message));
        }
    }

    /// Makes a step of the device, and everything that follows from it.
    fn device(&self, state: &mut State, input: device::Input<'_>) {
        let heard = match input {
            device::Input::Received { session, message: HostMessage::StopPlayback(_), bytes, password }
                if self.wrong == Wrong::DeafToStops =>
            {
                device::Input::Received { session, message: KeepAlive::default().into(), bytes, password }
            }
            device::Input::Received { session, message: HostMessage::StartPlayback(start), bytes, password }
                if self.conduct == Conduct::OtherWay =>
            {
                let start = StartPlayback { direction: PlaybackDirection::REVERSE, ..start };
                device::Input::Received { session, message: start.into(), bytes, password }
            }
            input => input,
        };
        let output = state.both.step_device(heard);
        device_stops_first(&output);
        for event in output.events() {
            if !state.rig.follow(state.both.now, event) {
                state.ledger.breach(Breach::TwoMoves);
            }
            if let device::Event::Disconnect { .. } = event {
                state.link = Link::Cut { host: state.link == Link::Cut { host: true, device: false }, device: true };
                state.both.up.cut();
            }
        }
        state.ledger_of_device(&input, &output, self.conduct);
        if state.link == Link::Up {
            let password = Password(self.password);
            let source =
                device::Source { guid: &[7; 16], password, trajectory: self.data, ..device::Source::default() };
            for transmit in output.transmits() {
                if matches!(transmit.destination, Destination::Sessions(sessions) if sessions.contains(SESSION)) {
                    state.both.down.send(ANY_TIME, device_bytes(transmit, &source));
                }
            }
        }
        if state.link == (Link::Cut { host: true, device: true }) {
            state.link = Link::Down;
        }
    }

    fn open(&self, state: &mut State) {
        state.both.cut();
        state.link = Link::Up;
        let (transport, password) = (self.transport, Password(self.password));
        self.device(state, device::Input::LinkUp { session: SESSION, transport, password });
        self.host(state, host::Input::LinkUp);
    }

    /// Delivers a message to the device. A damaged report is cut off after its header.
    fn arrives_at_device(&self, state: &mut State, message: &[u8], is_undamaged: bool) {
        self.device(
            state,
            match Frame::decode(message) {
                Ok(frame) if !is_undamaged => {
                    let (id, kind) = (frame.id(), frame.kind());
                    device::Input::Malformed { session: SESSION, id, kind, error: CUT, bytes: frame.bytes() }
                }
                _ => to_device(SESSION, message, Password(self.password)),
            },
        );
    }

    /// Message as the client hears it: another one if it is deaf or blind by mistake.
    fn heard<'m>(&self, message: &'m [u8]) -> &'m [u8] {
        /// Report on an input, which means nothing to anybody here.
        const NOTHING: &[u8] = &[4, 0, 8, 0, 0x81, 2, 0x15, 0];
        let is_lost = match (self.wrong, DeviceMessage::decode(&frame(message))) {
            (Wrong::DeafToRefusals, Ok(DeviceMessage::UnsupportedMessage(_))) => true,
            (Wrong::BlindToWays, Ok(DeviceMessage::PlaybackStatus(status))) => {
                status.playback_status == PlaybackState::START_REVERSE
            }
            _ => false,
        };
        if is_lost { NOTHING } else { message }
    }

    fn arrives_at_host(&self, state: &mut State, message: &[u8], is_undamaged: bool) {
        let message = self.heard(message);
        self.host(
            state,
            match Frame::decode(message) {
                Ok(frame) if !is_undamaged => host::Input::Malformed { id: frame.id(), kind: frame.kind(), error: CUT },
                _ => to_host(message),
            },
        );
    }
}
