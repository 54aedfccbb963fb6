//! Any sequence of inputs, also hostile ones, to each machine alone.

use std::collections::{BTreeMap, BTreeSet};

use kos_proto::device::motor::Motion;
use kos_proto::device::{self, DeviceMachine, Quirks, Report, SessionId};
use kos_proto::host::{self, Command, Get, HostMachine, Outcome, PasswordOf, Refusal, StopTarget, Token, Transmit};
use kos_proto::message::*;
use kos_proto::trajectory::*;
use kos_proto::{DecodeError, DeviceMessage, HostMessage, MessageId, MessageType, Millis, MoveSummary, Transport};
use laws::machine::Follows as _;
use laws::world::Watched;
use motion_core::wire::Messages;
use proptest::collection::vec;
use proptest::prelude::*;

use super::bench::*;
use super::client::{AT, Client, go, jog, summary};
use super::world::{device_stops_first, host_stops_first};

/// Motion of the clock before a step.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Time {
    Stands,
    Goes(u64),
    /// The clock goes to the time of the wake, and so many milliseconds further.
    Wakes(u64),
}

pub(crate) fn time() -> impl Strategy<Value = Time> {
    prop_oneof![
        3 => Just(Time::Stands),
        2 => (0..40_000_u64).prop_map(Time::Goes),
        1 => (0..100_u64).prop_map(Time::Goes),
        4 => Just(Time::Wakes(0)),
        1 => (0..5_000_u64).prop_map(Time::Wakes),
    ]
}

impl Time {
    pub(crate) fn pass(self, now: Millis, wake: Option<Millis>) -> Millis {
        match self {
            Self::Stands => now,
            Self::Goes(millis) => now.after(millis),
            Self::Wakes(late) => wake.unwrap_or(now).after(late),
        }
    }
}

/// Message as it stands on the wire, of a known number or any other.
#[derive(Debug, Clone)]
pub(crate) struct Wire {
    pub(crate) number: u32,
    pub(crate) body: Vec<u8>,
}

impl Wire {
    /// Message, or the error of the decoder.
    fn decode<'a, M: Messages<'a>>(&'a self) -> Result<M, (MessageId, MessageType, DecodeError)> {
        let [i0, i1, kind, _] = self.number.to_be_bytes();
        let id = MessageId(u16::from_be_bytes([i0, i1]));
        M::decode_body(self.number, &self.body).map_err(|error| (id, MessageType(kind), error))
    }
}

fn wire(known: Vec<u32>) -> impl Strategy<Value = Wire> {
    let number = prop_oneof![8 => prop::sample::select(known), 1 => any::<u32>()];
    // Small bytes are plausible motors, counts and flags.
    let byte = prop_oneof![2 => 0..5_u8, 1 => any::<u8>()];
    (number, vec(byte, 0..60)).prop_map(|(number, body)| Wire { number, body })
}

fn encoded<'a, M: Messages<'a>>(message: &M) -> Wire {
    let mut body = vec![0; message.body_len()];
    message.encode_body(&mut body).unwrap();
    Wire { number: message.number(), body }
}

fn number() -> impl Strategy<Value = f32> {
    prop_oneof![4 => prop::sample::select(vec![0.0, 1.0, -1.0, 8.0, 25_000.0]), 1 => any::<f32>()]
}

fn moves() -> impl Strategy<Value = TrajectoryData<'static>> {
    let live_moves = (0..3_u8, 0..3_u8, 0..3_u8).prop_map(|(back, rapid, delay)| {
        let (loop_after_reverse, loop_after_rapid_reverse) = (LoopCount(back), LoopCount(rapid / 2));
        let delay_interval_bits = DelayInterval::from_seconds(Seconds(3.0));
        let delay_mode = DelayMode(delay);
        live_move(Playback { loop_after_reverse, loop_after_rapid_reverse, delay_mode, delay_interval_bits, ..live() })
    });
    let lapses = (1..3_u8, 0..3_u32, 0..4_u32, 0..3_u32, number()).prop_map(|(mode, before, moving, after, delay)| {
        let playback = Playback { playback_mode: PlaybackMode(mode), ..live() };
        trajectory(playback, photos(delay, 0.5, before, moving, after))
    });
    prop_oneof![live_moves, lapses]
}

/// Message of a client, plausible more often than not.
fn host_message() -> impl Strategy<Value = Wire> {
    let known = HostMessage::ALL.iter().map(|kind| kind.number).collect();
    let moved = (any::<bool>(), 0..5_u8, number(), number()).prop_map(|(is_bump, motor, position, speed)| {
        encoded(&if is_bump { bump(motor, position, speed) } else { set_psa(motor, position, speed) })
    });
    let simple = vec![
        STOP,
        start(),
        start_to(PlaybackDirection::REVERSE),
        setup(false),
        setup(true),
        mark_begin(1),
        mark_end(1),
        mark_begin(2),
        mark_end(2),
        reset_axis(0),
        RapidToFirstKeyFrame::default().into(),
        user_password(b""),
        user_password(b"open"),
        device_password(b"open"),
        KeepAlive::default().into(),
        ResetDevice::default().into(),
        TakePicture { motor_address: MotorAddress::ALL, exposure: Seconds(3.0), tail: &[] }.into(),
    ];
    prop_oneof![
        2 => wire(known),
        3 => moved,
        4 => prop::sample::select(simple).prop_map(|message| encoded(&message)),
        2 => moves().prop_map(|data| encoded(&HostMessage::from(data))),
    ]
}

#[derive(Debug, Clone)]
pub(crate) enum DeviceOp {
    Open(SessionId, Transport),
    Closed(SessionId),
    Fatal(SessionId),
    Message(SessionId, Wire),
    Datagram(Wire),
    Stop,
    Rig(Report),
    Wake,
}

impl DeviceOp {
    /// Input of a device whose password is `open`.
    pub(crate) fn input(&self) -> device::Input<'_> {
        let password = Password(b"open");
        match *self {
            Self::Open(session, transport) => device::Input::LinkUp { session, transport, password },
            Self::Closed(session) => device::Input::LinkDown(session),
            Self::Fatal(session) => device::Input::Fatal(session),
            Self::Message(session, ref wire) => match wire.decode() {
                Ok(message) => device::Input::Received { session, message, bytes: &wire.body, password },
                Err((id, kind, error)) => device::Input::Malformed { session, id, kind, error, bytes: &wire.body },
            },
            Self::Datagram(ref wire) => wire.decode().map_or(device::Input::Wake, |message| device::Input::Datagram {
                from: device::Sender { address: Ipv4(1), port: 1 },
                message,
            }),
            Self::Stop => device::Input::Stop,
            Self::Rig(report) => device::Input::Rig(report),
            Self::Wake => device::Input::Wake,
        }
    }
}

pub(crate) fn device_op() -> impl Strategy<Value = DeviceOp> {
    let session = || (0..5_u8).prop_map(SessionId);
    let transport = prop::sample::select(vec![Transport::Tcp, Transport::Usb]);
    let motor = || (0..5_u8).prop_map(MotorAddress);
    let position = || number().prop_map(Rotations);
    let report = prop_oneof![
        1 => Just(Report::Started),
        2 => (motor(), position()).prop_map(|(motor, position)| Report::At(motor, position)),
        8 => (1..4_u8, position()).prop_map(|(motor, position)| Report::Arrived(MotorAddress(motor), position)),
        1 => motor().prop_map(Report::CannotHome),
        1 => (motor(), 0..21_u8).prop_map(|(motor, code)| Report::Fault(motor, ErrorCode(code))),
        1 => (motor(), any::<bool>()).prop_map(|(motor, online)| Report::Online(motor, online)),
        1 => any::<u8>().prop_map(|inputs| Report::Inputs(AuxInputs(inputs))),
    ];
    prop_oneof![
        2 => (session(), transport).prop_map(|(session, transport)| DeviceOp::Open(session, transport)),
        1 => session().prop_map(DeviceOp::Closed),
        1 => session().prop_map(DeviceOp::Fatal),
        16 => (session(), host_message()).prop_map(|(session, message)| DeviceOp::Message(session, message)),
        1 => host_message().prop_map(DeviceOp::Datagram),
        1 => Just(DeviceOp::Stop),
        8 => report.prop_map(DeviceOp::Rig),
        4 => Just(DeviceOp::Wake),
    ]
}

pub(crate) fn device_options() -> impl Strategy<Value = device::Options> {
    (any::<[bool; 5]>(), any::<bool>()).prop_map(|([empty, nonzero, alone, push, progress], clock)| {
        let empty = if empty { Quirks::REQUIRE_EMPTY_PASSWORD } else { Quirks::empty() };
        let forward = if clock { Quirks::IGNORES_DIRECTION | Quirks::NOT_CLAMPED } else { Quirks::empty() };
        let nonzero = if nonzero { Quirks::BEGIN_NONZERO } else { Quirks::empty() };
        device::Options::default()
            .with_quirks(empty | nonzero | forward)
            .with_stop_when_alone(alone)
            .with_push_every(push.then_some(5_000))
            .with_progress_every(progress.then_some(700))
            .with_travel_limit(Some(60_000))
            .with_unix_millis_at_zero(clock.then_some(1_700_000_000_000))
    })
}

/// Checks what holds for every step of a device.
fn device_holds(before: &DeviceMachine, after: &DeviceMachine, input: &device::Input<'_>, output: &device::Output<'_>) {
    use device::Event;
    device_stops_first(output);
    let ran = before.playback().runs();
    for event in output.events() {
        match event {
            Event::Move { .. } => assert!(!ran && !after.playback().runs(), "by hand and in a move"),
            Event::Home { .. } => assert!(!ran, "two moves"),
            _ => {}
        }
    }
    for transmit in output.transmits() {
        if let device::Contents::MotorCalibrated { motor, .. } = transmit.contents {
            let goes_on = after.motor(motor).is_some_and(|drive| matches!(drive.motion(), Motion::Moving(_)));
            assert!(!goes_on, "a motor goes on although its range ends here");
        }
    }
    let plays = output.events().filter(|event| matches!(event, Event::Play { .. } | Event::MoveToFrame { .. }));
    assert!(plays.count() <= 1, "two moves");
    let stops_all = output.events().any(|event| *event == Event::StopAll);
    assert!(!stops_all || !after.playback().runs(), "nothing goes on after a stop");
    if matches!(input, device::Input::Stop) {
        assert!(stops_all, "a person at the device stops everything");
    }
    let device::Input::Received { session, message, .. } = input else { return };
    if message.conduct().is_stop() && before.session(*session) != device::clients::State::Closed {
        let by_hand = match message {
            HostMessage::SetPositionSpeedAcceleration(message) => Some(message.motor_address),
            HostMessage::BumpPositionSpeedAcceleration(message) => Some(message.motor_address),
            _ => None,
        };
        match by_hand {
            Some(motor) if !ran => {
                let moved = before.motor(motor).is_some_and(|drive| drive.motion() != Motion::Resting);
                let stops = |event: &Event| match event {
                    Event::StopMotor { motor: this, .. } => this.number() == motor.number(),
                    _ => false,
                };
                assert_eq!(output.events().any(stops), moved);
            }
            _ => assert!(stops_all, "a stop is obeyed in the step in which it comes"),
        }
        assert!(
            after
                .motor(MotorAddress(1))
                .is_none_or(|drive| by_hand.is_some() || !matches!(drive.motion(), Motion::Moving(_)))
        );
        let rests_later = output.events().any(|event| matches!(event, Event::StopMotor { .. }));
        assert!(
            rests_later || output.transmits().next().is_some(),
            "a stop is answered, at once or when the motor rests"
        );
    }
}

#[derive(Debug, Clone)]
pub(crate) enum HostOp {
    Opened,
    Closed,
    Fatal,
    Message(Wire),
    Command(Command),
    Wake,
}

pub(crate) fn command() -> impl Strategy<Value = Command> {
    let motor = || (0..5_u8).prop_map(MotorAddress);
    let get = prop::sample::select(Get::ALL.to_vec());
    let simple = vec![
        Command::Stop,
        Command::Connect(AT),
        Command::Connect(host::Endpoint::Usb),
        Command::Disconnect,
        Command::Unlock,
        Command::ChangePassword,
        Command::ResetDevice,
        Command::Alive,
        Command::Play,
        Command::RapidToFirstKeyFrame,
        Command::Load { summary: summary(), delay_return: false },
        Command::PlayDirect { summary: summary() },
    ];
    prop_oneof![
        6 => prop::sample::select(simple),
        2 => get.prop_map(Command::Get),
        1 => motor().prop_map(Command::StopMotor),
        1 => motor().prop_map(Command::ResetAxis),
        1 => motor().prop_map(Command::MarkBegin),
        1 => motor().prop_map(Command::MarkEnd),
        4 => (motor(), number()).prop_map(|(motor, position)| Command::MoveTo(go(motor, position))),
        4 => (motor(), number()).prop_map(|(motor, speed)| jog(motor, speed)),
        2 => (motor(), number()).prop_map(|(motor, delta)| Command::Bump(go(motor, delta))),
        1 => number().prop_map(|exposure| Command::TakePicture(Seconds(exposure))),
    ]
}

/// Message of a device, plausible more often than not.
pub(crate) fn device_message() -> impl Strategy<Value = Wire> {
    use super::client::{calibrated, device_info, guid, presences, software, unsupported};
    let known = DeviceMessage::ALL.iter().map(|kind| kind.number).chain([0x000B_8200]).collect();
    let status =
        (0..15_u8).prop_map(|state| Wire { number: 0x0081_0202, body: vec![state, 0, 0, 0, 0, 0, 0, 0, 0, 0] });
    let error = (0..21_u8, 0..4_u8).prop_map(|(code, motor)| Wire { number: 0x0081_0203, body: vec![code, motor] });
    let rests = (1..4_u8).prop_map(|motor| Wire { number: 0x0081_0207, body: vec![motor, 0, 0, 0, 0] });
    let motor = (0..12_u8, any::<bool>()).prop_map(|(motor, more)| {
        let number = if more { 0x000B_8200 } else { 0x000B_0200 };
        Wire { number, body: [&[1, motor][..], &[64; 24]].concat() }
    });
    let info = (0..15_u8).prop_map(|state| encoded(&device_info(PlaybackState(state))));
    let simple = vec![
        encoded(&guid(&[7; 16])),
        encoded(&software(4)),
        encoded(&calibrated(MotorAddress(1), 3.0)),
        encoded(&unsupported(&[4, 0, 6, 0, 0x0F, 1])),
    ];
    let unknown = (prop::sample::select(vec![0x03, 0x04, 0x05, 0x06, 0x07, 0x0F, 0x1C, 0x28]), 0..4_u8)
        .prop_map(|(action, motor)| encoded(&unsupported(&[4, 0, 20, 0, 0x80, 0, action, motor])));
    let presence = (1..4_u8, any::<bool>()).prop_map(|(motor, online)| {
        let (speed, acceleration) = (RotationsPerSecond(9.0), RotationsPerSecondSquared(9.0));
        let online = online.into();
        let presence = MotorPresence::new(MotorAddress(motor), online, MotorType::AXIS, speed, speed, acceleration);
        encoded(&presences(&[presence]))
    });
    prop_oneof![
        2 => wire(known),
        4 => status,
        4 => presence,
        1 => error,
        2 => rests,
        3 => motor,
        3 => info,
        2 => unknown,
        3 => prop::sample::select(simple),
    ]
}

pub(crate) fn host_op() -> impl Strategy<Value = HostOp> {
    prop_oneof![
        3 => Just(HostOp::Opened),
        1 => Just(HostOp::Closed),
        1 => Just(HostOp::Fatal),
        12 => device_message().prop_map(HostOp::Message),
        12 => command().prop_map(HostOp::Command),
        4 => Just(HostOp::Wake),
    ]
}

/// Commands of an application, to compare with what the client sends.
#[derive(Default)]
struct Ledger {
    /// Motors, and the motions that may be sent once each.
    due: Vec<(u8, Command)>,
    /// Commands that have not ended.
    open: BTreeMap<Token, Command>,
    /// Motors that jog, and the time at which they have to be stopped if the application gives no command.
    jogs: BTreeSet<u8>,
    alive_until: Millis,
    /// Motors that were told to stop and did not report that they rest.
    stopped: BTreeSet<u8>,
    /// Whether the device reported its motors on this connection.
    is_reported: bool,
}

impl Ledger {
    /// Checks that a motor that jogs is followed, whatever the device says, until it is stopped or the connection is lost.
    fn watch(&mut self, now: Millis, wake: Option<Millis>, input: &host::Input<'_>, output: &host::Output<'_>) {
        use host::Event;
        if let host::Input::Command(token, command) = *input {
            self.alive_until = now.after(host::Options::default().dead_man());
            let sent = Event::Ended { token, outcome: Outcome::Sent };
            let is_sent = output.events().any(|event| *event == sent);
            match command {
                Command::Stop => self.jogs.clear(),
                Command::StopMotor(motor) => drop(self.jogs.remove(&motor.number())),
                Command::Jog { motor, speed, .. } if speed.0 == 0.0 => drop(self.jogs.remove(&motor.number())),
                Command::MoveTo(host::Go { motor, speed, .. }) | Command::Bump(host::Go { motor, speed, .. })
                    if speed.0 == 0.0 =>
                {
                    self.jogs.remove(&motor.number());
                }
                Command::Jog { motor, .. } if is_sent => drop(self.jogs.insert(motor.number())),
                _ => {}
            }
        }
        let ends = |event: &Event<'_>| {
            matches!(event, Event::DeadMan | Event::LinkDown(_) | Event::Unsupported { action: Some(_), .. })
        };
        if output.events().any(ends) {
            self.jogs.clear();
        }
        let due = self.alive_until.max(now.after(1));
        assert!(self.jogs.is_empty() || wake.is_some_and(|wake| wake <= due), "nobody watches {:?}", self.jogs);
    }

    /// Checks that the stop of a motor goes out again after a password and when the motor becomes known, and that a stop of
    /// everything is not confirmed before the device reported its motors.
    fn stops(&mut self, known: &[&HostMachine; 2], input: &host::Input<'_>, output: &host::Output<'_>) {
        use host::Event;
        match *input {
            host::Input::Command(_, Command::StopMotor(motor @ MotorAddress(1..))) => {
                self.stopped.insert(motor.number());
            }
            host::Input::Command(_, Command::Disconnect) => self.stopped.clear(),
            host::Input::Received(DeviceMessage::MotorInfo(MotorInfo { more: false, .. })) => self.is_reported = true,
            host::Input::LinkUp => self.is_reported = false,
            _ => {}
        }
        for event in output.events() {
            match *event {
                Event::MotorRests(motor, _) => drop(self.stopped.remove(&motor.number())),
                Event::Stopped(StopTarget::All) => {
                    assert!(self.is_reported, "nobody knows which motors have to rest");
                    self.stopped.clear();
                }
                _ => {}
            }
        }
        let transmits = || output.transmits();
        let unlocks =
            transmits().any(|transmit| matches!(transmit, Transmit::UserPassword(of) if *of != PasswordOf::New));
        let [before, after] =
            known.map(|host| host.motors().map(|motor| motor.motor_address.number()).collect::<BTreeSet<_>>());
        for &motor in self.stopped.iter().filter(|motor| unlocks || (!before.contains(motor) && after.contains(motor)))
        {
            let stops = |transmit: &&Transmit<'_>| match transmit {
                Transmit::MoveTo(go) => go.motor.number() == motor && go.speed.0 == 0.0,
                _ => false,
            };
            let is_sent = transmits().skip_while(|transmit| unlocks && !matches!(transmit, Transmit::UserPassword(_)));
            assert!(is_sent.filter(stops).count() > 0, "the stop of motor {motor} is lost: {output:?}");
        }
    }

    fn check(&mut self, input: &host::Input<'_>, output: &host::Output<'_>) {
        use host::Event;
        let mut refused = false;
        if let host::Input::Command(token, command) = *input {
            self.open.insert(token, command);
        }
        for event in output.events() {
            if let Event::Ended { token, outcome } = event {
                let command = self.open.remove(token).expect("a command ends once");
                let now = matches!(input, host::Input::Command(this, _) if this == token);
                refused |= now && matches!(outcome, Outcome::Refused(_));
                assert!(*outcome != Outcome::Failed(host::Failure::NoAnswer) || matches!(command, Command::Get(_)));
                if let (Outcome::Refused(Refusal::Device(_)), Command::MoveTo(_) | Command::Bump(_)) =
                    (outcome, command)
                {
                    let names_motor = output.events().any(|event| matches!(event, Event::Error(_, MotorAddress(1..))));
                    assert!(names_motor || self.jogs.is_empty(), "the refusal may be about a jog");
                }
                if let Outcome::Refused(Refusal::Unsupported { action: Some(action), .. }) = *outcome {
                    let of_others = match command {
                        Command::Bump(_) => ActionId::SET_POSITION_SPEED_ACCELERATION,
                        _ => ActionId::BUMP_POSITION_SPEED_ACCELERATION,
                    };
                    assert_ne!(action, of_others, "the refusal of one message ends {command:?}");
                }
            }
            if let Event::LinkDown(_) = event {
                let is_new = |token: &Token| matches!(input, host::Input::Command(this, _) if this == token);
                assert!(self.open.keys().all(is_new), "all commands end with the connection");
            }
        }
        match *input {
            host::Input::Command(_, Command::Stop) => self.due.clear(),
            host::Input::Command(_, Command::StopMotor(motor)) => {
                self.due.retain(|&(other, _)| other != motor.number());
            }
            host::Input::Command(
                _,
                command @ (Command::MoveTo(host::Go { motor, .. }) | Command::Jog { motor, .. }),
            ) if !refused => {
                self.due.push((motor.number(), command));
            }
            _ => {}
        }
        for transmit in output.transmits().filter(|transmit| !transmit.conduct().repeatable) {
            let commanded = matches!(input, host::Input::Command(..));
            match transmit {
                // A motion may have waited. Those that it overtook are never sent.
                Transmit::MoveTo(sent) => {
                    let motor = sent.motor.number();
                    let wanted = |command: &Command| match command {
                        Command::MoveTo(go) => go.position == sent.position,
                        _ => true,
                    };
                    let place = self.due.iter().rposition(|(other, command)| *other == motor && wanted(command));
                    let place = place.unwrap_or_else(|| panic!("{sent:?} is sent twice"));
                    let mut index = 0;
                    self.due.retain(|&(other, _)| {
                        index += 1;
                        other != motor || index > place + 1
                    });
                }
                transmit => assert!(commanded && !refused, "{transmit:?} without a command"),
            }
        }
    }
}

/// Checks what holds for every step of a client.
fn host_holds(before: &HostMachine, after: &HostMachine, input: &host::Input<'_>, output: &host::Output<'_>) {
    use host::Event;
    host_stops_first(output);
    for event in output.events() {
        let lends = matches!(event, Event::Unsolicited(_) | Event::Ended { outcome: Outcome::Done(Some(_)), .. });
        assert_eq!(event.to_static(), Some(*event).filter(|_| !lends), "what lends nothing can be stored");
    }
    if output.transmits().any(|transmit| transmit.conduct().may_move() && *transmit != Transmit::Trajectory) {
        assert!(after.may_move(), "something that may move was sent: {output:?}");
    }
    let rested = |event: &Event<'_>| match event {
        Event::Stopped(_) | Event::MotorRests(..) => true,
        // The device has not done what it does not know.
        Event::Unsupported { action, .. } => action.is_some(),
        Event::Move(happened) => matches!(happened, host::Move::Finished { .. } | host::Move::Ready | host::Move::Home),
        _ => false,
    };
    assert!(
        !before.may_move() || after.may_move() || output.events().any(rested),
        "motors move until something tells that they rest: {output:?}"
    );
    let host::Input::Command(_, command) = input else { return };
    let connected = before.state().is_connected();
    let mut transmits = output.transmits();
    match command {
        Command::Stop if connected => {
            assert_eq!(transmits.next(), Some(&Transmit::StopPlayback), "a stop is sent in the call in which it comes");
            assert!(transmits.all(|transmit| transmit.conduct().repeatable), "and nothing that moves with it");
            assert_eq!(after.move_state(), host::MoveState::Stopping);
        }
        Command::Stop => {
            let unconfirmed = Event::StopNotConfirmed(StopTarget::All);
            assert!(output.events().any(|event| *event == unconfirmed));
        }
        Command::Jog { motor, speed, .. }
            if output.events().any(|event| matches!(event, Event::Ended { outcome: Outcome::Sent, .. })) =>
        {
            let of = |number: u8| move |known: &&Motor| known.motor_address.number() == number;
            let at = before.motors().find(of(motor.number())).and_then(Motor::relative_position);
            for transmit in transmits {
                let Transmit::MoveTo(go) = transmit else { continue };
                let goes_back =
                    go.motor.number() == motor.number() && at.is_some_and(|at| (go.position.0 - at.0) * speed.0 < 0.0);
                assert!(!goes_back || go.speed.0 == 0.0, "{command:?} goes the other way: {output:?}");
            }
        }
        Command::ChangePassword if before.may_move() => {
            assert!(!transmits.any(|transmit| *transmit == Transmit::DevicePassword), "something may move");
        }
        _ => {}
    }
    assert!(after.may_move() || !matches!(command, Command::Stop | Command::StopMotor(MotorAddress(1..=10))));
}

proptest! {
    #[test]
    fn the_laws_of_a_device_hold_for_any_inputs(options in device_options(), ops in vec((time(), device_op()), 0..80)) {
        let (mut device, mut now) = (Watched::new(DeviceMachine::new(options)), Millis(0));
        let _ = device.step(now, device::Input::Rig(Report::Started));
        for motor in [1, 2] {
            let session = SessionId(3);
            let open = device::Input::LinkUp { session, transport: Transport::Usb, password: Password(b"") };
            let _ = device.step(now, open);
            for (position, message) in [(0.0, mark_begin(motor)), (8.0, mark_end(motor))] {
                let arrived = Report::Arrived(MotorAddress(motor), Rotations(position));
                let _ = device.step(now, device::Input::Rig(arrived));
                let input = device::Input::Received { session, message, bytes: &[], password: Password(b"") };
                let _ = device.step(now, input);
            }
        }
        for (time, op) in &ops {
            now = time.pass(now, device.wake);
            let input = op.input();
            let (early, before) = (device.wake.is_some_and(|wake| wake > now), device.machine.clone());
            let output = device.step_whole(now, input, device::Input::Wake);
            device_holds(&before, &device.machine, &input, &output);
            if matches!(input, device::Input::Wake) && early {
                prop_assert!(output.is_quiet() && device.machine == before, "an early wake changes nothing");
            }
        }
    }

    #[test]
    fn the_laws_of_a_client_hold_for_any_inputs(
        ops in vec((time(), host_op()), 0..80),
        [ask, again, usb, ready] in any::<[bool; 4]>(),
    ) {
        let options = host::Options::default().with_ask_every(ask.then_some(5_000)).with_reconnect(again);
        let endpoint = if usb { host::Endpoint::Usb } else { AT };
        let client = if ready { Client::ready_at(options, endpoint) } else { Client::new(options) };
        let (mut host, mut now) = (Watched::new(client.machine), Millis(client.now));
        host.wake = client.wake.map(Millis);
        let (mut ledger, mut token) = (Ledger::default(), 0);
        for (time, op) in &ops {
            now = time.pass(now, host.wake);
            let decoded;
            let input = match op {
                HostOp::Opened => host::Input::LinkUp,
                HostOp::Closed => host::Input::LinkDown,
                HostOp::Fatal => host::Input::Fatal,
                HostOp::Message(wire) => {
                    decoded = wire.decode::<DeviceMessage<'_>>();
                    match decoded {
                        Ok(message) => host::Input::Received(message),
                        Err((id, kind, error)) => host::Input::Malformed { id, kind, error },
                    }
                }
                HostOp::Command(command) => {
                    token += 1;
                    host::Input::Command(Token(token), *command)
                }
                HostOp::Wake => host::Input::Wake,
            };
            let (early, before) = (host.wake.is_some_and(|wake| wake > now), host.machine.clone());
            let output = host.step_whole(now, input, host::Input::Wake);
            host_holds(&before, &host.machine, &input, &output);
            ledger.check(&input, &output);
            ledger.stops(&[&before, &host.machine], &input, &output);
            ledger.watch(now, host.wake, &input, &output);
            if matches!(input, host::Input::Wake) && early {
                prop_assert!(output.is_quiet() && host.machine == before, "an early wake changes nothing");
            }
        }
        // All questions end.
        let end = now.after(options.request_timeout());
        while let Some(due) = host.wake.filter(|&wake| wake <= end) {
            ledger.check(&host::Input::Wake, &host.step(due, host::Input::Wake));
        }
        // A motion ends when the device reports it, or when it is stopped. All other commands have ended.
        let motions = |command: &Command| {
            matches!(
                command,
                Command::MoveTo(_) | Command::Bump(_) | Command::Load { .. } | Command::Play | Command::PlayDirect { .. }
            )
        };
        prop_assert!(ledger.open.values().all(motions), "{:?}", ledger.open);
    }

    /// Any blocks give a valid summary, or an error.
    #[test]
    fn any_blocks_give_a_valid_summary_or_an_error(body in vec(any::<u8>(), 0..300), data in moves()) {
        let wire = Wire { number: 0x0012_0000, body };
        if let Ok(HostMessage::SetTrajectoryData(data)) = wire.decode() {
            let _ = MoveSummary::of(&data);
        }
        if let Ok(plan) = MoveSummary::of(&data) {
            let valid = match plan.kind {
                kos_proto::move_summary::Kind::Live { duration, loops } => {
                    duration > 0 && loops.is_none_or(|loops| loops.duration > 0)
                }
                _ => plan.shots().is_some_and(|shots| shots.moving > 0 && shots.interval() > 0),
            };
            prop_assert!(valid && !plan.motors.is_empty());
        }
    }
}
