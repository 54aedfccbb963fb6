//! Conduct of every message of a host, stated a second time from the safety decisions, and the behaviour of the machine in
//! every state.

use std::collections::{BTreeSet, HashMap};

use dmc_proto::host::{
    Command, Contents, Event, HostMachine, Input, MAX_QUEUE, Options, Progress, Source, State, StopTarget,
};
use dmc_proto::message::{
    Ack, AckCode, Capabilities, GioIn, Hi, Motor, MotorConfigure, MotorFlags, MotorJog, MotorMove, MotorPositions,
    MotorStatus, MotorStatusRequest, Motors, RtPositionFrame, RtRunMove, RtUploadMoveBegin, VirtPositions,
    VirtualMotor,
};
use dmc_proto::{Conduct, DeviceMessage, Effect, HostMessage, MessageId, Millis, Purpose, Token};
use motion_core::wire::Messages;

/// Safety decision 1: stops do not wait, and are repeated until they are obeyed.
const STOPS: [u32; 3] = [
    0x0032, // MOTOR_STOP
    0x0033, // MOTOR_STOP_ALL
    0x0202, // VIRT_STOP
];

/// Safety decision 1: a stop calls these off. A motor may move because of each of them.
const MOVES: [u32; 9] = [
    0x0031, // MOTOR_MOVE
    0x0036, // MOTOR_JOG
    0x0110, // RT_POSITION_FRAME
    0x0113, // RT_GO
    0x0120, // RT_JOG_ALL
    0x0201, // VIRT_MOVE
    0x0203, // VIRT_JOG
    0x0206, // VIRT_JOG_ON_LINE
    0x0207, // VIRT_AIM_POINT
];

/// DMC D3: after these the device goes to the pre-roll point, and waits for GO or its operator.
const ARMS: [u32; 3] = [
    0x0111, // RT_RUN_MOVE
    0x0112, // RT_SHOOT_FRAME
    0x0115, // RT_SHOOT_FRAME2
];

/// DMC A1: requests whose answer is data, and which change nothing.
const ASKS: [u32; 5] = [
    0x0001, // HI
    0x0022, // GIO_IN
    0x0030, // MOTOR_STATUS
    0x0034, // MOTOR_GET_POSITION
    0x0205, // VIRT_GET_POSITION
];

/// DMC A1: settings, outputs and uploads. No motor moves because of them.
const SETS: [u32; 14] = [
    0x0020, // DMX
    0x0021, // GIO_OUT
    0x0023, // GIO_CAM
    0x0035, // MOTOR_RESET_POSITION
    0x0037, // MOTOR_CONFIGURE
    0x0038, // MOTOR_SET_SPEED
    0x0039, // MOTOR_SET_LIMITS
    0x0100, // RT_UPLOAD_MOVE_BEGIN
    0x0101, // RT_UPLOAD_MOVE_AXIS
    0x0102, // RT_UPLOAD_MOVE_DMX
    0x0103, // RT_UPLOAD_MOVE_END
    0x0104, // RT_UPLOAD_MOVE_TRIGGERS
    0x0116, // RT_STOP_LOOP
    0x0200, // VIRT_CONFIG
];

/// Safety decision 2: a host never sends these again by itself.
const ONCE: [u32; 9] = [
    0x0035, // MOTOR_RESET_POSITION
    0x0036, // MOTOR_JOG
    0x0111, // RT_RUN_MOVE
    0x0112, // RT_SHOOT_FRAME
    0x0113, // RT_GO
    0x0115, // RT_SHOOT_FRAME2
    0x0120, // RT_JOG_ALL
    0x0203, // VIRT_JOG
    0x0206, // VIRT_JOG_ON_LINE
];

/// DMC D5, decision D-63: these begin a sequence, or belong to one.
const IN_SEQUENCE: [u32; 11] = [
    0x0100, // RT_UPLOAD_MOVE_BEGIN
    0x0101, // RT_UPLOAD_MOVE_AXIS
    0x0102, // RT_UPLOAD_MOVE_DMX
    0x0103, // RT_UPLOAD_MOVE_END
    0x0104, // RT_UPLOAD_MOVE_TRIGGERS
    0x0110, // RT_POSITION_FRAME
    0x0111, // RT_RUN_MOVE
    0x0112, // RT_SHOOT_FRAME
    0x0113, // RT_GO
    0x0115, // RT_SHOOT_FRAME2
    0x0120, // RT_JOG_ALL
];

/// Conduct of the message with a number, by the groups above.
fn stated(number: u32) -> Conduct {
    let groups = [
        (&STOPS[..], Purpose::Stops),
        (&MOVES, Purpose::Moves),
        (&ARMS, Purpose::Arms),
        (&ASKS, Purpose::Asks),
        (&SETS, Purpose::Sets),
    ];
    let purposes: Vec<_> = groups.into_iter().filter(|(group, _)| group.contains(&number)).collect();
    let [(_, purpose)] = purposes[..] else { panic!("{number:#06x} is in {} groups", purposes.len()) };
    Conduct { purpose, repeatable: !ONCE.contains(&number), in_sequence: IN_SEQUENCE.contains(&number), blocks: 0 }
}

/// Bodies of a message, made from a few patterns as in the laws of messages: the shortest one and a longer one.
fn bodies(number: u32) -> Vec<HostMessage<'static>> {
    let mut messages: Vec<HostMessage<'static>> = Vec::new();
    for pattern in 0..4_u8 {
        let body: Vec<u8> = (0..80_u8)
            .map(|at| match pattern {
                0 => 0,
                1 => 0xff,
                2 => at,
                _ => at.wrapping_mul(37) ^ 0xd4,
            })
            .collect();
        let body: &'static [u8] = body.leak();
        let decoded = |len: usize| HostMessage::decode_body(number, &body[..len]).ok();
        let shortest = (0..80).find_map(&decoded);
        messages.extend(shortest.into_iter().chain(decoded(79)));
    }
    messages.dedup();
    messages
}

#[test]
fn the_table_states_the_conduct_of_the_safety_decisions() {
    let mut rows = BTreeSet::new();
    for kind in HostMessage::ALL {
        let conduct = stated(kind.number);
        assert_eq!(kind.conduct, Some(conduct), "{}", kind.name);
        for message in bodies(kind.number) {
            assert_eq!(message.conduct(), conduct, "{message}");
        }
        rows.insert(kind.number);
    }
    let groups = [&STOPS[..], &MOVES, &ARMS, &ASKS, &SETS].concat();
    assert_eq!(rows, groups.into_iter().collect(), "every message of the groups is in the table");
    let unknown = HostMessage::other(0x0300, &[]);
    assert_eq!(unknown.conduct(), Conduct::UNKNOWN);
    assert!(unknown.conduct().may_move() && !unknown.conduct().repeatable, "it may do anything");
    assert!(DeviceMessage::ALL.iter().all(|kind| kind.conduct.is_none()), "a device gives no orders");
}

/// Behaviour of the device on the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Device {
    /// The device does not answer.
    Silent,
    /// The device does everything, and all its motors rest.
    Obedient,
    /// The device does everything, and motor 1 always moves.
    Moving,
    /// The device receives all frames damaged.
    Deaf,
    /// The device refuses everything.
    Refusing,
}

/// Host with its line, and the messages that it sent.
#[derive(Clone)]
struct Line {
    host: HostMachine,
    now: Millis,
    wake: Option<Millis>,
    messages: HashMap<Token, HostMessage<'static>>,
    /// Contents and messages that were sent since the last check.
    sent: Vec<(Contents, HostMessage<'static>)>,
    /// Messages that the device has not answered.
    unanswered: Vec<(MessageId, HostMessage<'static>)>,
}

const LIVE: Motor = Motor(3);

fn hi() -> Hi<'static> {
    let capabilities = Capabilities(0x07ff);
    Hi { motor_count: 8, upload_frame_count: 1000, capabilities, protocol_version: Some(2), ..Hi::default() }
}

impl Line {
    fn offline(window: u8) -> Self {
        let options = Options::new().with_gates(false).with_needs_enabled(false).with_window(window);
        let (messages, sent, unanswered) = (HashMap::new(), Vec::new(), Vec::new());
        Self { host: HostMachine::new(options), now: Millis(1000), wake: None, messages, sent, unanswered }
    }

    fn step(&mut self, input: Input<'_>) {
        let output = self.host.advance(self.now, input);
        self.wake = output.wake;
        let mut wants_section = false;
        for effect in output {
            match effect {
                Effect::Transmit(transmit) => {
                    let message = transmit.message(|source| match source {
                        Source::Command(token) => self.messages[&token],
                        Source::Section(section) => panic!("{section:?}: there are none"),
                    });
                    let Some(message) = message else { continue };
                    self.sent.push((transmit.contents, message));
                    self.unanswered.push((transmit.id, message));
                }
                Effect::Event(event) => wants_section |= matches!(event, Event::NextSection { .. }),
            }
        }
        if wants_section {
            self.step(Input::Section(None));
        }
    }

    fn command(&mut self, command: Command<'static>) -> Token {
        let token = Token(u32::try_from(self.messages.len()).unwrap());
        self.messages.insert(token, MotorStatusRequest::default().into());
        if let Command::Request(message) | Command::Sequence(message) = command {
            self.messages.insert(token, message);
        }
        self.step(Input::Command(token, command));
        token
    }

    /// Lets the device answer every message that it has not answered.
    fn answer(&mut self, device: Device) {
        for (id, message) in std::mem::take(&mut self.unanswered) {
            let ack = |code| DeviceMessage::from(Ack::new(message.kind(), code));
            let moving = Motors(u32::from(device == Device::Moving));
            let answer = match (device, message) {
                (Device::Silent, _) => continue,
                (Device::Deaf, _) => ack(AckCode::ERR_CHECKSUM),
                (Device::Refusing, _) => ack(AckCode::ERR_NOT_IN_POSITION),
                (_, HostMessage::Hi(_)) => hi().into(),
                (_, HostMessage::MotorStatus(_)) => MotorStatus { motor_status: moving, ..Default::default() }.into(),
                (_, HostMessage::MotorGetPosition(_)) => MotorPositions::default().into(),
                (_, HostMessage::GioIn(_)) => GioIn::default().into(),
                (_, HostMessage::VirtGetPosition(_)) => VirtPositions::default().into(),
                (_, HostMessage::Other(_)) => ack(AckCode::ERR_UNSUPPORTED),
                _ => ack(AckCode::OK),
            };
            self.step(Input::Received(id, answer));
        }
    }

    /// Lets time pass. The host is woken when it wants to be, and the device answers.
    fn pass(&mut self, millis: u64, device: Device) {
        let end = self.now.after(millis);
        loop {
            self.answer(device);
            let is_answered = self.unanswered.is_empty() || device == Device::Silent;
            let Some(wake) = self.wake.filter(|&wake| wake <= end && is_answered) else {
                if is_answered {
                    break;
                }
                continue;
            };
            self.now = wake;
            self.step(Input::Wake);
        }
        self.now = end;
    }

    fn ready(window: u8) -> Self {
        let mut line = Self::offline(window);
        line.step(Input::LinkUp);
        line.answer(Device::Obedient);
        let configure = MotorConfigure { motor: LIVE, flags: MotorFlags::LIVE, tail: &[] };
        line.command(Command::Request(configure.into()));
        line.command(Command::Configured);
        line.pass(1, Device::Obedient);
        assert_eq!(line.host.state(), State::Ready);
        line
    }

    /// Host whose run has this progress.
    fn run(window: u8, progress: Progress) -> Self {
        let mut line = Self::ready(window);
        line.command(Command::Sequence(RtRunMove::default().into()));
        for _ in 0..1000 {
            if line.host.progress() == Some(progress) {
                return line;
            }
            if line.host.progress() == Some(Progress::Armed) {
                line.command(Command::Go);
            } else if line.unanswered.is_empty() {
                line.now = line.wake.unwrap();
                line.step(Input::Wake);
            } else {
                line.answer(Device::Obedient);
            }
        }
        panic!("no way to {progress:?}");
    }
}

/// Hosts in every state, each with a script that leads there.
fn states() -> Vec<(String, Line)> {
    let mut states = vec![];
    let mut add = |name: &str, line: Line| states.push((name.to_owned(), line));
    for window in [1, 4] {
        add("offline", Line::offline(window));
        let mut line = Line::offline(window);
        line.command(Command::Stop(StopTarget::All));
        add("offline, with a stop that waits", line);
        let mut line = Line::offline(window);
        line.step(Input::LinkUp);
        add("greeting", line.clone());
        line.pass(6000, Device::Silent);
        assert_eq!(line.host.state(), State::Silent);
        add("silent", line);
        let mut line = Line::offline(window);
        line.step(Input::LinkUp);
        line.answer(Device::Obedient);
        assert_eq!(line.host.state(), State::Configuring);
        add("configuring", line);

        let ready = Line::ready(window);
        add("ready", ready.clone());
        let with = |commands: &[Command<'static>]| {
            let mut line = ready.clone();
            for command in commands {
                line.command(*command);
            }
            line
        };
        let question = Command::Request(MotorStatusRequest::default().into());
        let jog = Command::Request(MotorJog { motor: Motor(2), ..Default::default() }.into());
        add("a question under way", with(&[question]));
        add(
            "a motion under way",
            with(&[Command::Request(MotorMove { motor: Motor(2), ..Default::default() }.into())]),
        );
        add("a motion that waits", with(&[jog, jog]));
        add("full", with(&[question; 4 + MAX_QUEUE]));
        for target in [StopTarget::All, StopTarget::Motor(Motor(2)), StopTarget::Virtual(VirtualMotor::PAN)] {
            let mut line = with(&[Command::Stop(target)]);
            add("a stop under way", line.clone());
            line.pass(2000, Device::Silent);
            add("a stop that is not confirmed", line);
        }
        add("an upload", with(&[Command::Sequence(RtUploadMoveBegin::default().into())]));
        add("a way to a frame", with(&[Command::Sequence(RtPositionFrame::default().into())]));
        for progress in Progress::ALL.into_iter().filter(|&progress| progress != Progress::Uploads) {
            add(&format!("a run: {progress}"), Line::run(window, progress));
        }
        let mut line = Line::run(window, Progress::Goes);
        line.unanswered.clear();
        line.pass(600, Device::Silent);
        assert!(line.host.is_armed() && line.host.progress().is_none());
        add("armed, without a run", line);
        let mut line = ready.clone();
        line.step(Input::Received(MessageId::UNSOLICITED, hi().into()));
        add("the device was reset", line);
        let mut line = ready;
        line.step(Input::LinkDown);
        add("the link went down", line);
    }
    states
}

/// Every message of the table, with two bodies each, and a message without a type of its own.
fn messages() -> Vec<HostMessage<'static>> {
    let known = HostMessage::ALL.iter().flat_map(|kind| {
        let bodies = bodies(kind.number);
        [bodies[0], bodies[bodies.len() - 1]]
    });
    known.chain([HostMessage::other(0x0300, &[1, 2])]).collect()
}

/// Each message is given as a request and as a sequence.
fn commands(message: HostMessage<'static>) -> [Command<'static>; 2] {
    [Command::Request(message), Command::Sequence(message)]
}

/// S-1, S-2
#[test]
fn after_a_stop_nothing_that_moves_leaves_in_any_state() {
    let targets = [StopTarget::All, StopTarget::Motor(Motor(2)), StopTarget::Motor(LIVE)];
    for (name, before) in states() {
        for message in messages() {
            for command in commands(message) {
                for target in targets {
                    let mut line = before.clone();
                    line.command(command);
                    line.sent.clear();
                    line.command(Command::Stop(target));
                    for device in [Device::Silent, Device::Obedient, Device::Moving, Device::Deaf, Device::Refusing] {
                        let mut line = line.clone();
                        line.pass(2500, device);
                        let moves = line.sent.iter().find(|(_, sent)| sent.conduct().may_move());
                        assert_eq!(moves, None, "{name}: {command:?}, stop of {target:?}, {device:?}");
                    }
                }
            }
        }
    }
}

/// S-2, S-3
#[test]
fn in_no_state_anything_is_sent_more_often_than_it_may_be() {
    for (name, before) in states() {
        for message in messages().into_iter().filter(|message| !message.conduct().is_stop()) {
            for command in commands(message) {
                for device in [Device::Silent, Device::Deaf] {
                    let mut line = before.clone();
                    line.sent.clear();
                    let token = line.command(command);
                    line.pass(10_000, device);
                    let own = Contents::Application(Source::Command(token));
                    let times = line.sent.iter().filter(|(contents, _)| *contents == own).count();
                    let most = if message.conduct().repeatable { 3 } else { 1 };
                    assert!(times <= most, "{name}: {command:?} was sent {times} times, {device:?}");
                }
            }
        }
    }
}

/// The scripts above lead into every state of the connection and of a sequence. A host that is ready sends every message
/// that is a request.
#[test]
fn the_scripts_reach_every_state_and_every_request_is_sent() {
    let states = states();
    let connections: Vec<_> = states.iter().map(|(_, line)| line.host.state()).collect();
    assert!(State::ALL.iter().all(|state| connections.contains(state)));
    let sequences: Vec<_> = states.iter().filter_map(|(_, line)| line.host.progress()).collect();
    assert!(Progress::ALL.iter().all(|progress| sequences.contains(progress)));
    for message in messages() {
        let mut line = Line::ready(1);
        line.sent.clear();
        line.command(if begins(&message) { Command::Sequence(message) } else { Command::Request(message) });
        // Before a run, the device is sent to its first frame.
        let is_sent = match message {
            HostMessage::RtRunMove(_) => line.sent.iter().any(|(contents, _)| matches!(contents, Contents::ToFrame(_))),
            _ => line.sent.iter().any(|(_, sent)| sent.kind() == message.kind()),
        };
        assert_eq!(is_sent, !message.conduct().in_sequence || begins(&message), "{message}");
    }
}

fn begins(message: &HostMessage<'_>) -> bool {
    matches!(
        message,
        HostMessage::RtUploadMoveBegin(_)
            | HostMessage::RtPositionFrame(_)
            | HostMessage::RtRunMove(_)
            | HostMessage::RtShootFrame(_)
            | HostMessage::RtShootFrame2(_)
            | HostMessage::RtJogAll(_)
    )
}
