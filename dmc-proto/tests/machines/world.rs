//! A host and a device, a line between them that is not always good, and a rig of few words.

use std::collections::{HashMap, HashSet, VecDeque};

use dmc_proto::device::{self, DeviceMachine, Quirks, State};
use dmc_proto::host::{self, Command, HostMachine, Outcome, Progress, Source, StopTarget};
use dmc_proto::message::{
    AckCode, FrameNumber, HostMessage, Motor, MotorConfigure, MotorFlags, MotorStatusRequest, Motors, RtStopLoop,
    RunFlags, Steps,
};
use dmc_proto::upload::{MoveSource, SCRATCH, Section, SectionSize};
use dmc_proto::{DeviceMessage, Effect, Frame, MessageId, Millis, Token};

use super::bench::{
    Tens, begin, frame, hi, jog, jog_all, move_to, position_frame, run, shot, stops_go_first, the_rig_acts_first,
};

/// What becomes of a frame on the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    None,
    Lost,
    Doubled,
    Corrupt,
    Late,
}

/// What somebody does.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Action {
    Move(u8),
    Jog(u8),
    Live(u8),
    Status,
    Upload,
    ToFrame(i32),
    JogAll(i32),
    Run(RunFlags),
    Shot,
    Go,
    StopLoop,
    Stop(StopTarget),
    OperatorGo,
    Limit(u8),
    Emergency,
    LineGone,
}

impl Action {
    /// Number of commands that it gives: each of them has to end.
    pub(crate) fn commands(self) -> usize {
        match self {
            Self::OperatorGo | Self::Limit(_) | Self::Emergency => 0,
            Self::LineGone => 2,
            _ => 1,
        }
    }
}

/// Frames on their way in one direction, in their order.
#[derive(Default)]
struct Line {
    frames: VecDeque<(Millis, Vec<u8>, bool)>,
}

impl Line {
    fn send(&mut self, now: Millis, bytes: &[u8], fault: Fault) {
        let arrival = now.after(if fault == Fault::Late { 700 } else { 2 });
        let arrival = self.frames.back().map_or(arrival, |last| last.0.max(arrival));
        let copies = match fault {
            Fault::Lost => 0,
            Fault::Doubled => 2,
            _ => 1,
        };
        for _ in 0..copies {
            self.frames.push_back((arrival, bytes.to_vec(), fault == Fault::Corrupt));
        }
    }

    fn next(&self) -> Option<Millis> {
        self.frames.front().map(|frame| frame.0)
    }
}

/// What the motors are at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Doing {
    Nothing,
    Moving,
    /// All together, but not by a run or shot.
    Together,
    Preparing,
    Prepared,
    Running,
    Stopping,
}

/// How a command ended, without the message that answered it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Ending {
    Answered,
    Other(Outcome<'static>),
}

impl Ending {
    fn of(outcome: Outcome<'_>) -> Self {
        match outcome {
            Outcome::Done(Some(_)) => Self::Answered,
            Outcome::Done(None) => Self::Other(Outcome::Done(None)),
            Outcome::Sent => Self::Other(Outcome::Sent),
            Outcome::Refused(refusal) => Self::Other(Outcome::Refused(refusal)),
            Outcome::Failed(failure) => Self::Other(Outcome::Failed(failure)),
            Outcome::NotConfirmed => Self::Other(Outcome::NotConfirmed),
            outcome => panic!("{outcome:?}"),
        }
    }
}

pub(crate) struct World {
    pub(crate) now: Millis,
    pub(crate) host: HostMachine,
    host_wake: Option<Millis>,
    pub(crate) device: DeviceMachine,
    device_wake: Option<Millis>,
    to_device: Line,
    to_host: Line,
    pub(crate) faults: VecDeque<Fault>,
    doing: Doing,
    /// When the rig has something to report.
    rig_due: Option<Millis>,
    frames_left: u32,
    messages: HashMap<Token, HostMessage<'static>>,
    /// Tokens that have not ended.
    pub(crate) open: HashSet<Token>,
    /// How the others did.
    pub(crate) ended: HashMap<Token, Ending>,
    /// Where both have been.
    pub(crate) seen: (HashSet<State>, HashSet<Progress>),
    /// How often each message was sent.
    sent: HashMap<Token, u32>,
    signals: u32,
    /// Tokens up to this one were called off.
    called_off: u32,
    last: u32,
}

struct Ramp;

impl MoveSource for Ramp {
    fn start_frame(&self) -> FrameNumber {
        frame(1)
    }
    fn frame_count(&self) -> u32 {
        10
    }
    fn motors(&self) -> Motors {
        Motors(3)
    }
    fn position(&self, motor: Motor, index: u32) -> Steps {
        Steps(i32::from(motor.0) * i32::try_from(index).unwrap())
    }
}

impl World {
    pub(crate) fn new(window: u8, quirks: Quirks, faults: Vec<Fault>) -> Self {
        let mut world = Self {
            now: Millis(0),
            host: HostMachine::new(host::Options::default().with_window(window)),
            host_wake: None,
            device: DeviceMachine::new(device::Options::of(hi()).with_quirks(quirks)),
            device_wake: None,
            to_device: Line::default(),
            to_host: Line::default(),
            faults: VecDeque::new(),
            doing: Doing::Nothing,
            rig_due: None,
            frames_left: 0,
            messages: HashMap::new(),
            open: HashSet::new(),
            ended: HashMap::new(),
            seen: (HashSet::new(), HashSet::new()),
            sent: HashMap::new(),
            signals: 0,
            called_off: 0,
            last: 0,
        };
        world.tell_host(host::Input::LinkUp);
        world.pass(1000);
        world.command(Command::Configured);
        assert_eq!(world.host.state(), host::State::Ready);
        world.ended.clear();
        world.faults = faults.into();
        world
    }

    fn fault(&mut self) -> Fault {
        self.faults.pop_front().unwrap_or(Fault::None)
    }

    /// A step of the host, and what follows from it.
    pub(crate) fn tell_host(&mut self, input: host::Input<'_>) {
        let (machine, output) = laws::machine::step(self.host.clone(), self.now, input);
        (self.host, self.host_wake) = (machine, output.wake);
        self.seen.1.extend(self.host.progress());
        stops_go_first(&output);
        let mut asked = None;
        for effect in output {
            match effect {
                Effect::Event(host::Event::Ended { token, outcome }) => {
                    assert!(self.open.remove(&token), "{token:?} ends once");
                    self.ended.insert(token, Ending::of(outcome));
                }
                Effect::Event(host::Event::NextSection { after, .. }) => asked = Some(after),
                Effect::Event(host::Event::DeviceReset) => panic!("nobody reset the device"),
                Effect::Event(_) => {}
                Effect::Transmit(transmit) => self.send(transmit),
            }
        }
        self.check_motion();
        if let Some(after) = asked {
            let size = SectionSize::of(29);
            let section = match after {
                None => Section::first(&Ramp, size),
                Some(section) => section.next(&Ramp, size),
            };
            self.tell_host(host::Input::Section(section));
        }
    }

    fn send(&mut self, transmit: host::Transmit) {
        let mut scratch = [0; SCRATCH];
        let message = transmit.message(|source| match source {
            Source::Command(token) => self.messages[&token],
            Source::Section(section) => section.message(&Ramp, &mut scratch),
        });
        self.check_sent(transmit.contents, &message);
        let mut bytes = [0; 2048];
        let len = message.encode_into(transmit.id, &mut bytes).unwrap();
        let fault = self.fault();
        self.to_device.send(self.now, &bytes[..len], fault);
    }

    /// A law of hosts: as long as anything moves because of the host, the host says so.
    fn check_motion(&self) {
        let moves = self.device.moving() != Motors::NONE || !matches!(self.doing, Doing::Nothing | Doing::Prepared);
        assert!(!moves || self.host.may_move(), "{:?}, {:?}: {:?}", self.doing, self.device, self.host);
    }

    /// Nothing is sent twice that must not be, nor after it was called off.
    fn check_sent(&mut self, contents: host::Contents, message: &HostMessage<'_>) {
        let mut stops = self.host.unconfirmed_stops();
        let is_alone = |stop: StopTarget| matches!(stop, StopTarget::Motor(_));
        assert!(!message.conduct().may_move() || stops.all(is_alone), "{message} against a stop");
        match contents {
            host::Contents::Application(Source::Command(token)) => {
                let times = self.sent.entry(token).or_default();
                *times += 1;
                assert!(*times <= if message.conduct().repeatable { 3 } else { 1 }, "{message} for the {times}. time");
                assert!(!message.conduct().may_move() || token.0 > self.called_off, "{message} after a stop");
            }
            host::Contents::Go => {
                self.signals += 1;
                assert!(self.signals <= 4);
            }
            host::Contents::ToFrame(_) => assert!(self.last > self.called_off),
            _ => {}
        }
    }

    /// A step of the device, and what follows from it.
    pub(crate) fn tell_device(&mut self, input: device::Input<'_>) {
        let before = self.device.state();
        let is_stop = matches!(input, device::Input::Received { message, .. } if message.conduct().is_stop());
        let (machine, output) = laws::machine::step(self.device.clone(), self.now, input);
        (self.device, self.device_wake) = (machine, output.wake);
        self.seen.0.insert(self.device.state());
        if is_stop {
            let first = output.effects.first();
            assert!(matches!(first, Some(Effect::Event(device::Event::Stop(_)))), "{first:?} in {before:?}");
        }
        let mut stored = None;
        the_rig_acts_first(&output);
        for effect in output {
            match effect {
                Effect::Event(event) => stored = stored.or(self.rig(event, before)),
                Effect::Transmit(transmit) => {
                    let mut scratch = device::Scratch::default();
                    let mut bytes = [0; 2048];
                    let len = transmit.message(&Tens, &mut scratch).encode_into(transmit.id, &mut bytes).unwrap();
                    let fault = self.fault();
                    self.to_host.send(self.now, &bytes[..len], fault);
                }
            }
        }
        self.check_motion();
        if let Some(store) = stored {
            self.tell_device(device::Input::Stored(store, AckCode::OK));
        }
    }

    /// The rig obeys; some of it takes time.
    fn rig(&mut self, event: device::Event<'_>, before: State) -> Option<device::Store> {
        let (doing, time) = match event {
            device::Event::Store { store, .. } => return Some(store),
            device::Event::Stop(stop) => {
                let is_all = !matches!(stop, device::StopKind::Motor(_) | device::StopKind::Virtual(_));
                if !is_all && self.doing != Doing::Moving {
                    return None;
                }
                match self.doing {
                    Doing::Nothing | Doing::Prepared => (Doing::Nothing, 0),
                    Doing::Stopping => return None,
                    _ => (Doing::Stopping, 150),
                }
            }
            // A motor that is driven by hand, while the others wait.
            device::Event::Move(..) | device::Event::Jog(..) if self.doing == Doing::Prepared => (Doing::Prepared, 300),
            device::Event::Move(..) | device::Event::Jog(..) if self.doing != Doing::Nothing => return None,
            device::Event::Move(..) => (Doing::Moving, 800),
            device::Event::Jog(..) => (Doing::Moving, 5000),
            device::Event::ToFrame(_) => {
                assert_ne!(self.doing, Doing::Running);
                (Doing::Together, 900)
            }
            device::Event::JogAll(..) => {
                assert!(matches!(before, State::Idle | State::JogAll));
                (Doing::Together, 900)
            }
            device::Event::Prepare(_) => {
                assert_eq!((before, self.doing), (State::Idle, Doing::Nothing), "one coordinated move at a time");
                (Doing::Preparing, 600)
            }
            device::Event::Go => {
                assert_eq!(self.doing, Doing::Prepared);
                self.frames_left = 10;
                (Doing::Running, 100)
            }
            device::Event::NextPass(..) => {
                self.frames_left = 10;
                (Doing::Running, 100)
            }
            device::Event::PostRoll => (Doing::Stopping, 300),
            _ => return None,
        };
        (self.doing, self.rig_due) = (doing, Some(self.now.after(time)));
        None
    }

    /// The rig reports what is due.
    fn report(&mut self) {
        self.rig_due = None;
        if self.doing != Doing::Running {
            let is_prepared = matches!(self.doing, Doing::Preparing | Doing::Prepared);
            self.doing = if is_prepared { Doing::Prepared } else { Doing::Nothing };
            return self.tell_device(device::Input::AtRest);
        }
        if self.frames_left == 0 {
            return self.tell_device(device::Input::PassEnd);
        }
        self.frames_left -= 1;
        self.rig_due = Some(self.now.after(100));
        self.tell_device(device::Input::AtFrame(frame(10 - i32::try_from(self.frames_left).unwrap())));
    }

    pub(crate) fn act(&mut self, action: Action) {
        match action {
            Action::Move(motor) => self.command(Command::Request(move_to(motor, 5))),
            Action::Jog(motor) => self.command(Command::Request(jog(motor))),
            Action::Live(motor) => {
                let configure = MotorConfigure { motor: Motor(motor), flags: MotorFlags::LIVE, tail: &[] };
                self.command(Command::Request(configure.into()));
            }
            Action::Status => self.command(Command::Request(MotorStatusRequest::default().into())),
            Action::StopLoop => self.command(Command::Request(RtStopLoop::default().into())),
            Action::Upload => self.command(Command::Sequence(begin(1, 10))),
            Action::ToFrame(number) => self.command(Command::Sequence(position_frame(number))),
            Action::JogAll(number) => self.command(Command::Sequence(jog_all(number))),
            Action::Run(flags) => self.command(Command::Sequence(run(1, 10, flags))),
            Action::Shot => self.command(Command::Sequence(shot(5))),
            Action::Go => {
                self.signals = 0;
                self.command(Command::Go);
            }
            Action::Stop(target) => self.stop(target),
            Action::OperatorGo => self.tell_device(device::Input::OperatorGo),
            Action::Limit(motor) => self.tell_device(device::Input::Limit { motor: Motor(motor), upper: true }),
            Action::Emergency => {
                self.tell_device(device::Input::EmergencyStop(true));
                self.pass(50);
                self.tell_device(device::Input::EmergencyStop(false));
            }
            Action::LineGone => {
                (self.to_device, self.to_host) = (Line::default(), Line::default());
                self.called_off = self.last;
                self.tell_device(device::Input::LinkDown);
                self.tell_host(host::Input::LinkDown);
                assert_eq!(self.open.len(), 0);
                self.tell_host(host::Input::LinkUp);
                self.pass(6000);
                self.command(Command::Greet);
                self.pass(6000);
                self.command(Command::Configured);
            }
        }
    }

    fn command(&mut self, command: Command<'static>) {
        self.last += 1;
        let token = Token(self.last);
        if let Command::Request(message) | Command::Sequence(message) = command {
            self.messages.insert(token, message);
        }
        self.open.insert(token);
        self.tell_host(host::Input::Command(token, command));
    }

    /// A stop leaves in the same step, and calls off what moves.
    fn stop(&mut self, target: StopTarget) {
        let before = self.to_device.frames.len();
        let fault = self.faults.front().copied().unwrap_or(Fault::None);
        let spared = self.host.progress().is_some();
        self.command(Command::Stop(target));
        if fault != Fault::Lost && self.host.state() != host::State::Offline {
            let bytes = &self.to_device.frames[before].1;
            let message = HostMessage::decode(&Frame::decode(bytes).unwrap()).unwrap();
            assert!(message.conduct().is_stop(), "{message}");
        }
        if !spared || self.host.progress().is_none() {
            self.called_off = self.last;
        }
    }

    /// Time passes, and everybody does what is due.
    pub(crate) fn pass(&mut self, millis: u64) {
        let end = self.now.after(millis);
        loop {
            let dues = [self.host_wake, self.device_wake, self.rig_due, self.to_device.next(), self.to_host.next()];
            let Some(due) = dues.into_iter().flatten().min().filter(|&due| due <= end) else { break };
            self.now = due.max(self.now);
            let is_due = |moment: Option<Millis>| moment.is_some_and(|moment| moment <= self.now);
            if is_due(self.to_device.next()) {
                let (_, bytes, is_corrupt) = self.to_device.frames.pop_front().unwrap();
                let frame = Frame::decode(&bytes).unwrap();
                self.tell_device(if is_corrupt {
                    device::Input::Corrupt(frame.id(), frame.kind())
                } else {
                    device::Input::received(&frame, |_| AckCode::OK)
                });
            } else if is_due(self.to_host.next()) {
                let (_, bytes, is_corrupt) = self.to_host.frames.pop_front().unwrap();
                let frame = Frame::decode(&bytes).unwrap();
                self.tell_host(if is_corrupt { host::Input::Corrupt } else { host::Input::received(&frame) });
            } else if is_due(self.rig_due) {
                self.report();
            } else if is_due(self.device_wake) {
                self.tell_device(device::Input::Wake);
            } else {
                self.tell_host(host::Input::Wake);
            }
        }
        self.now = end;
    }

    /// Everything is stopped over a good line: then all has ended, and both agree.
    pub(crate) fn settle(&mut self) {
        self.faults.clear();
        self.pass(10_000);
        if self.host.state() != host::State::Ready {
            self.command(Command::Greet);
            self.pass(10_000);
            self.command(Command::Configured);
        }
        self.pass(60_000);
        match self.host.progress() {
            None | Some(Progress::Armed) => {}
            Some(Progress::Runs) => assert_eq!(self.device.state(), State::Running, "a loop"),
            Some(progress) => panic!("{progress:?} for ever"),
        }
        self.stop(StopTarget::All);
        self.pass(10_000);
        assert_eq!(self.host.state(), host::State::Ready);
        assert_eq!(self.host.unconfirmed_stops().count(), 0);
        assert_eq!(self.host.progress(), None);
        assert_eq!(self.host.pending().count(), 0);
        assert!(self.open.is_empty(), "{:?}", self.open);
        assert_eq!(self.device.state(), State::Idle);
        assert!(!self.host.is_armed());
        self.act(Action::Status);
        self.pass(10_000);
        assert!(!self.host.may_move(), "all rests, and the host knows");
        if let Some(is_loaded) = self.host.is_loaded() {
            assert_eq!(is_loaded, self.device.is_loaded());
        }
        assert_eq!((self.host_wake, self.device_wake), (None, None), "and nobody waits for anything");
    }
}

/// Ids that an answer may carry: of what was asked, or none.
pub(crate) fn answer_id(machine: &HostMachine, choice: u32) -> MessageId {
    let pending: Vec<_> = machine.pending().map(|(id, _)| id).collect();
    match usize::try_from(choice).unwrap() {
        at if at < pending.len() => pending[at],
        _ => MessageId(choice % 40),
    }
}

/// A message of the device's, decoded.
pub(crate) fn device_message(number: u32, body: &[u8]) -> Option<DeviceMessage<'_>> {
    use motion_core::wire::Messages;
    DeviceMessage::decode_body(number, body).ok()
}
