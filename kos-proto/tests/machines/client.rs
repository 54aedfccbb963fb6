//! Test bench of a client: a machine, a clock, and the effects of the last steps.

use kos_proto::device::Positions;
use kos_proto::host::*;
use kos_proto::message::*;
use kos_proto::{DeviceMessage, Frame, Millis, MoveSummary};
use laws::machine::step;

use super::bench::{live, live_move};
use super::world::{host_bytes, host_stops_first};

pub(super) const AT: Endpoint = Endpoint::Tcp(Ipv4(0xc0a8_3201));
pub(super) const ONE: MotorAddress = MotorAddress(1);
pub(super) const TWO: MotorAddress = MotorAddress(2);
pub(super) const GUID: [u8; 16] = [7; 16];

#[derive(Clone)]
pub(super) struct Client {
    pub(super) machine: HostMachine,
    pub(super) now: u64,
    pub(super) sent: Vec<Transmit<'static>>,
    /// Events, except the ends of commands.
    pub(super) events: Vec<Event<'static>>,
    /// Outcomes of commands, by their tokens.
    pub(super) ended: Vec<(Token, Outcome<'static>)>,
    /// Number of the last command.
    pub(super) token: u32,
    pub(super) wake: Option<u64>,
}

impl Client {
    pub(super) fn new(options: Options) -> Self {
        Self {
            machine: HostMachine::new(options),
            now: 1000,
            sent: Vec::new(),
            events: Vec::new(),
            ended: Vec::new(),
            token: 0,
            wake: None,
        }
    }

    /// A client with a connection that has asked for `DeviceInfo`.
    pub(super) fn connected(options: Options, endpoint: Endpoint) -> Self {
        let mut client = Self::new(options);
        client.command(Command::Connect(endpoint));
        assert_eq!(client.events(), [Event::Connect(endpoint)]);
        client.step(Input::LinkUp);
        client
    }

    /// A client of a device with two motors: motor 1 has a range, motor 2 has none.
    pub(super) fn ready_at(options: Options, endpoint: Endpoint) -> Self {
        let mut client = Self::connected(options, endpoint);
        client.introduce(PlaybackState::NO_MOVE);
        assert_eq!(client.state(), "Ready");
        client.clear();
        client
    }

    pub(super) fn ready() -> Self {
        Self::ready_at(Options::default(), AT)
    }

    /// The device answers all queries.
    pub(super) fn introduce(&mut self, status: PlaybackState) {
        self.receive(device_info(status));
        self.motors();
        self.receive(guid(&GUID));
        self.receive(software(4));
    }

    /// The device reports its motors.
    pub(super) fn motors(&mut self) {
        self.motor(1, 3.0, 8.0, true);
        self.motor(2, 0.0, 0.0, false);
    }

    pub(super) fn motor(&mut self, motor: u8, position: f32, end: f32, more: bool) {
        let motors = [entry(motor, position, end)];
        self.receive(DeviceMessage::from(MotorInfo { more, motors: MotorInfos::New(&motors), tail: &[] }));
    }

    /// A client with a move that is being set up.
    pub(super) fn setting_up() -> Self {
        let mut client = Self::ready();
        client.command(load());
        client.clear();
        client
    }

    pub(super) fn armed() -> Self {
        let mut client = Self::setting_up();
        client.status(PlaybackState::MOTORS_HOME);
        client.status(PlaybackState::SETUP_COMPLETED);
        assert_eq!(client.move_state(), "Armed");
        client.clear();
        client
    }

    pub(super) fn starting() -> Self {
        let mut client = Self::armed();
        client.command(Command::Play);
        client.clear();
        client
    }

    pub(super) fn running() -> Self {
        let mut client = Self::starting();
        client.status(PlaybackState::START_FORWARD);
        client.clear();
        client
    }

    pub(super) fn step(&mut self, input: Input<'static>) {
        let (machine, output) = step(self.machine.clone(), Millis(self.now), input);
        self.machine = machine;
        self.wake = output.wake.map(|wake| wake.0);
        host_stops_first(&output);
        let (user_password, new_password) = (Password(b"user"), Password(b"new"));
        let source = Source { user_password, new_password, ..Source::default() };
        for effect in output {
            match effect {
                Effect::Transmit(transmit) => {
                    host_bytes(&transmit, &source);
                    self.sent.push(transmit);
                }
                Effect::Event(Event::Ended { token, outcome }) => self.ended.push((token, outcome)),
                Effect::Event(event) => self.events.push(event),
            }
        }
    }

    /// Gives a command, with the next token.
    pub(super) fn command(&mut self, command: Command) {
        self.token += 1;
        self.step(Input::Command(Token(self.token), command));
    }

    pub(super) fn receive<'a>(&mut self, message: impl Into<DeviceMessage<'a>>) {
        self.step(Input::received(&Frame::decode(leaked(message.into())).unwrap()));
    }

    /// Outcomes of the commands that ended since the last call.
    pub(super) fn ended(&mut self) -> Vec<Outcome<'static>> {
        std::mem::take(&mut self.ended).into_iter().map(|(_, outcome)| outcome).collect()
    }

    /// The device reports the progress of the move.
    pub(super) fn status(&mut self, state: PlaybackState) {
        let status = PlaybackStatus {
            playback_status: state,
            elapsed_time: Normalized(0.5),
            photo_count: Some(Photos(0.0)),
            motors: &Positions::new(),
            tail: &[],
        };
        self.receive(DeviceMessage::from(status));
    }

    pub(super) fn error(&mut self, code: u8, motor: u8) {
        let (error_code, motor_address) = (ErrorCode(code), MotorAddress(motor));
        self.receive(DeviceMessage::from(ErrorStatus { error_code, motor_address, tail: &[] }));
    }

    /// The device answers the question after a stop.
    pub(super) fn settle(&mut self, state: PlaybackState) {
        self.receive(device_info(state));
    }

    pub(super) fn rests(&mut self, motor: u8, position: f32) {
        let (motor_address, position) = (MotorAddress(motor), Rotations(position));
        self.receive(DeviceMessage::from(MotorPosition { motor_address, position, tail: &[] }));
    }

    /// Lets time pass, and wakes the machine at each of its wakes and at the end.
    pub(super) fn pass(&mut self, millis: u64) {
        let end = self.now + millis;
        while let Some(wake) = self.wake.filter(|&wake| wake <= end) {
            self.now = wake;
            self.step(Input::Wake);
        }
        self.now = end;
        self.step(Input::Wake);
    }

    pub(super) fn sent(&mut self) -> Vec<Transmit<'static>> {
        std::mem::take(&mut self.sent)
    }

    pub(super) fn events(&mut self) -> Vec<Event<'static>> {
        std::mem::take(&mut self.events)
    }

    pub(super) fn clear(&mut self) {
        self.sent.clear();
        self.events.clear();
        self.ended.clear();
    }

    /// Reason for which a command is refused. Checks that nothing is sent for it.
    pub(super) fn refused(&mut self, command: Command) -> Option<Refusal> {
        self.clear();
        self.command(command);
        match self.ended()[..] {
            [Outcome::Refused(why)] => {
                assert_eq!(self.sent(), [], "{command:?}");
                Some(why)
            }
            _ => None,
        }
    }

    pub(super) fn state(&self) -> &'static str {
        self.machine.state().name()
    }

    pub(super) fn move_state(&self) -> &'static str {
        self.machine.move_state().name()
    }
}

/// Bytes of a message, leaked so that they live as long as the test.
pub(super) fn leaked(message: DeviceMessage<'_>) -> &'static [u8] {
    let mut bytes = vec![0; message.encoded_len()];
    message.encode_into(&mut bytes).unwrap();
    bytes.leak()
}

fn entry(motor: u8, position: f32, end: f32) -> MotorEntry {
    let speed = RotationsPerSecond(100.0);
    let acceleration = RotationsPerSecondSquared(80.0);
    let (position, end) = (Rotations(position), Rotations(end));
    MotorEntry::new(MotorAddress(motor), position, Rotations(0.0), end, speed, speed, acceleration)
}

pub(super) fn device_info(playback_status: PlaybackState) -> DeviceMessage<'static> {
    DeviceMessage::from(DeviceInfo {
        device_type: DeviceType::SECOND_SHOOTER_PRO,
        device_addr: 0,
        playback_mode: PlaybackMode::LIVE_MOTION,
        playback_status,
        firmware_version: FirmwareVersion([1, 0, 1, 5]),
        network_id: 0,
        hardware_id: 0,
        device_password: Password(b"open"),
        aux_input_status: AuxInputs::default(),
        delay_time_remaining: Seconds(0.0),
        elapsed_time: Normalized(0.0),
        photo_count: Newer(Some(0)),
        tail: &[],
    })
}

pub(super) fn guid(guid: &[u8]) -> DeviceMessage<'_> {
    DeviceMessage::from(DeviceGUID { guid: Block16(guid), tail: &[] })
}

pub(super) fn software(platform: u8) -> DeviceMessage<'static> {
    DeviceMessage::from(SoftwareID { platform, tail: &[] })
}

pub(super) fn unsupported(message: &[u8]) -> DeviceMessage<'_> {
    DeviceMessage::from(UnsupportedMessage { message: Rest(message), tail: &[] })
}

pub(super) fn calibrated(motor: MotorAddress, end: f32) -> DeviceMessage<'static> {
    DeviceMessage::from(MotorCalibrated {
        motor_address: motor,
        begin_position: Some(Rotations(0.0)),
        end_position: Rotations(end),
        tail: &[],
    })
}

pub(super) fn presences(motors: &[MotorPresence]) -> DeviceMessage<'_> {
    DeviceMessage::from(MotorStatus { motors: Counted(motors), tail: &[] })
}

pub(super) fn summary() -> MoveSummary {
    MoveSummary::of(&live_move(live())).unwrap()
}

pub(super) fn load() -> Command {
    Command::Load { summary: summary(), delay_return: false }
}

pub(super) fn go(motor: MotorAddress, position: f32) -> Go {
    Go {
        motor,
        position: Rotations(position),
        speed: RotationsPerSecond(10.0),
        acceleration: RotationsPerSecondSquared(20.0),
    }
}

pub(super) fn jog(motor: MotorAddress, speed: f32) -> Command {
    Command::Jog { motor, speed: RotationsPerSecond(speed), acceleration: RotationsPerSecondSquared(20.0) }
}

/// Question after a stop.
pub(super) const QUESTION: Transmit<'static> = Transmit::Get(Get::DeviceInfo);

/// What stops a motor that the client does not know.
pub(super) fn unknown(motor: MotorAddress) -> Transmit<'static> {
    let (speed, acceleration) = (RotationsPerSecond(0.0), RotationsPerSecondSquared(50.0));
    Transmit::MoveTo(Go { motor, position: JOG_DISTANCE, speed, acceleration })
}

/// What stops motor 1, which is calibrated and was seen at 3, and motor 2, which is not.
pub(super) fn stop(motor: MotorAddress) -> Transmit<'static> {
    let position = if motor == ONE { Rotations(3.0) } else { JOG_DISTANCE };
    Transmit::MoveTo(Go {
        motor,
        position,
        speed: RotationsPerSecond(0.0),
        acceleration: RotationsPerSecondSquared(50.0),
    })
}
