//! Host and device, a line with faults between them, and a simple rig.

use std::collections::{HashMap, HashSet, VecDeque};

use dmc_proto::device::{self, DeviceMachine, Quirks, State};
use dmc_proto::host::{self, Command, HostMachine, Outcome, Progress, Source, StopTarget};
use dmc_proto::message::{
    AckCode, FrameNumber, Hi, HostMessage, Motor, MotorConfigure, MotorFlags, MotorStatusRequest, Motors, RtStopLoop,
    RunFlags,
};
use dmc_proto::{DeviceMessage, Effect, Frame, MessageId, Millis, Token};
use laws::world::{self, Fate, Faults, Next};

use super::app::{App, answer, hi, may_not_stop, the_rig_acts_first};
use super::bench::{begin, jog, jog_all, move_to, position_frame, run, shot};

/// Time that a frame takes, in milliseconds.
const TRAVEL: u64 = 2;

/// Act of the application, of the operator or of the rig.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Action {
    Move(u8),
    Jog(u8),
    Configure(u8, MotorFlags),
    /// Motors 1 and 2 get the first uses, and motor 3 the second ones.
    ConfigureAll(MotorFlags, MotorFlags),
    Status,
    /// Upload of a move of motors 1 and 2, or of none.
    Upload(bool),
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
    LinkDown,
}

impl Action {
    /// Number of commands that the action gives. Each of them has to end.
    pub(crate) fn commands(self) -> usize {
        match self {
            Self::OperatorGo | Self::Limit(_) | Self::Emergency => 0,
            Self::LinkDown => 2,
            Self::ConfigureAll(..) => 3,
            _ => 1,
        }
    }
}

/// Motion of the rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Motion {
    Rest,
    Single,
    /// All motors move together, but in no run and no shot.
    Together,
    Preparing,
    Prepared,
    Running,
    Stopping,
}

/// Faults of the line, in the order in which frames meet them. After the last one, the line is good.
#[derive(Debug, Clone, Default)]
pub(crate) struct BadLine {
    /// Times that the next frames take, in milliseconds.
    pub(crate) travels: VecDeque<u64>,
    /// Fates of the next frames that arrive.
    pub(crate) fates: VecDeque<Fate>,
    /// Of the next frames to the device that are lost: number of bytes that were cut off at the end. A device waits for
    /// them, and takes what follows for them. Of a frame that is lost whole, it is 0.
    pub(crate) cuts: VecDeque<usize>,
}

pub(crate) struct World {
    both: world::World<HostMachine, DeviceMachine, Vec<u8>, Vec<u8>>,
    line: BadLine,
    /// Number of bytes that the device waits for, because a frame was cut off.
    deaf: usize,
    motion: Motion,
    /// Time of the next report of the rig.
    rig_due: Option<Millis>,
    frames_left: i32,
    app: App<'static>,
    /// Ends of the commands that have ended; `None` if a message of the device answered the command.
    pub(crate) ended: HashMap<Token, Option<Outcome<'static>>>,
    /// States in which the device and the sequences were.
    pub(crate) seen: (HashSet<State>, HashSet<Progress>),
    /// Time of the last command to stop, and number of times that each stop was sent since.
    stops: (Millis, HashMap<StopTarget, u64>),
    /// Commands up to this token were called off.
    called_off: Token,
    last: Token,
}

impl World {
    /// World with a device of three motors, whose host is ready, before its line turns bad.
    pub(crate) fn new(options: host::Options, quirks: Quirks, line: BadLine) -> Self {
        let host = HostMachine::new(options);
        let hi = Hi { motor_count: 3, ..hi() };
        let device = DeviceMachine::new(device::Options::of(hi).with_quirks(quirks));
        let mut world = Self {
            both: world::World::new(Millis(0), host, device, Faults::ANY),
            line: BadLine::default(),
            deaf: 0,
            motion: Motion::Rest,
            rig_due: None,
            frames_left: 0,
            app: App::default(),
            ended: HashMap::new(),
            seen: (HashSet::new(), HashSet::new()),
            stops: (Millis(0), HashMap::new()),
            called_off: Token(0),
            last: Token(0),
        };
        world.tell_host(host::Input::LinkUp);
        world.pass(1000);
        world.command(Command::Configured);
        assert_eq!(world.host().state(), host::State::Ready);
        world.ended.clear();
        world.line = line;
        world
    }

    pub(crate) const fn host(&self) -> &HostMachine {
        &self.both.host.machine
    }

    pub(crate) const fn device(&self) -> &DeviceMachine {
        &self.both.device.machine
    }

    /// Commands that have not ended.
    pub(crate) fn open(&self) -> Vec<Token> {
        self.app.tokens.open().collect()
    }

    /// Time at which the next frame arrives.
    fn arrival(&mut self) -> Millis {
        self.both.now.after(self.line.travels.pop_front().unwrap_or(TRAVEL))
    }

    /// Takes a step of the host, and does what follows from it.
    pub(crate) fn tell_host(&mut self, input: host::Input<'_>) {
        let output = self.both.step_host(input);
        self.app.takes(&output, &self.both.host.machine);
        self.check_stops(input, &output);
        self.seen.1.extend(self.host().progress());
        for effect in &output.effects {
            match effect {
                Effect::Event(host::Event::Ended { token, outcome }) => {
                    self.ended.insert(*token, outcome.to_static());
                }
                Effect::Event(host::Event::DeviceReset) => panic!("nobody reset the device"),
                Effect::Event(_) => {}
                Effect::Transmit(transmit) => {
                    let (frame, arrival) = (self.app.frame(transmit), self.arrival());
                    self.check_sent(transmit.contents, &frame);
                    self.both.up.send(arrival, frame);
                }
            }
        }
        self.check_motion();
        if let Some(section) = self.app.section(&output) {
            self.tell_host(section);
        }
    }

    /// Law of hosts: whatever is answered, a stop is sent once in two timeouts. It may have arrived damaged twice before.
    fn check_stops(&mut self, input: host::Input<'_>, output: &host::Output<'_>) {
        if matches!(input, host::Input::LinkUp | host::Input::Command(_, Command::Stop(_))) {
            self.stops = (self.both.now, HashMap::new());
        }
        for transmit in output.transmits() {
            let host::Contents::Stop(target) = transmit.contents else { continue };
            let times = self.stops.1.entry(target).or_default();
            *times += 1;
            let most = 3 + self.both.now.since(self.stops.0) / 500;
            assert!(*times <= most, "{target:?} is sent {times} times, not {most}");
        }
    }

    /// Law of both sides: while anything moves because of the host, they say so.
    fn check_motion(&self) {
        let is_moving = !matches!(self.motion, Motion::Rest | Motion::Prepared);
        let moves = is_moving || self.device().moving() != Motors::NONE;
        let both = self.host().may_move() && self.device().may_move();
        assert!(!moves || both, "{:?}, {:?}: {:?}", self.motion, self.device(), self.host());
    }

    /// Law of hosts: nothing that may move is sent against a stop, or after it was called off.
    fn check_sent(&self, contents: host::Contents, frame: &[u8]) {
        if let host::Contents::Padding(_) = contents {
            return;
        }
        let message = HostMessage::decode(&Frame::decode(frame).unwrap()).unwrap();
        let may_move = message.conduct().may_move();
        let is_alone = |stop: StopTarget| matches!(stop, StopTarget::Motor(_));
        assert!(!may_move || self.host().unconfirmed_stops().all(is_alone), "{message} against a stop");
        let asked = match contents {
            host::Contents::Application(Source::Command(token)) => token,
            _ => self.last,
        };
        assert!(!may_move || asked > self.called_off, "{message} after a stop");
    }

    /// Takes a step of the device, and does what follows from it.
    pub(crate) fn tell_device(&mut self, input: device::Input<'_>) {
        let before = self.device().state();
        let is_obeyed = |message| !may_not_stop(self.device(), message);
        let is_stop = matches!(&input, device::Input::Received { message, .. } if message.conduct().is_stop() && is_obeyed(message));
        let output = self.both.step_device(input);
        self.seen.0.insert(self.device().state());
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
                    let arrival = self.arrival();
                    self.both.down.send(arrival, answer(&transmit));
                }
            }
        }
        self.check_motion();
        if let Some(store) = stored {
            self.tell_device(device::Input::Rig(device::Report::Stored(store, AckCode::OK)));
        }
    }

    /// Does what the rig is told. Some of it takes time.
    fn rig(&mut self, event: device::Event<'_>, before: State) -> Option<device::Store> {
        let (motion, time) = match event {
            device::Event::Store { store, .. } => return Some(store),
            device::Event::Stop(stop) => {
                let is_all = !matches!(stop, device::StopKind::Motor(_) | device::StopKind::Virtual(_));
                if !is_all && self.motion != Motion::Single {
                    return None;
                }
                match self.motion {
                    Motion::Rest | Motion::Prepared => (Motion::Rest, 0),
                    Motion::Stopping => return None,
                    _ => (Motion::Stopping, 150),
                }
            }
            // A motor that is driven by hand may end a run.
            device::Event::Move(..) if before == State::Running && self.device().state() == State::Moving => {
                (Motion::Single, 800)
            }
            // A motor that is driven by hand moves while the others wait.
            device::Event::Move(..) | device::Event::Jog(..) if self.motion == Motion::Prepared => {
                (Motion::Prepared, 300)
            }
            device::Event::Move(..) | device::Event::Jog(..) if self.motion != Motion::Rest => return None,
            device::Event::Move(..) => (Motion::Single, 800),
            device::Event::Jog(..) => (Motion::Single, 5000),
            device::Event::ToFrame(_) => {
                assert_ne!(self.motion, Motion::Running);
                (Motion::Together, 900)
            }
            device::Event::JogAll(..) => {
                assert!(matches!(before, State::Idle | State::JogAll));
                (Motion::Together, 900)
            }
            device::Event::Prepare(_) => {
                assert_eq!((before, self.motion), (State::Idle, Motion::Rest), "one coordinated move at a time");
                (Motion::Preparing, 600)
            }
            device::Event::Go => {
                assert_eq!(self.motion, Motion::Prepared);
                self.frames_left = 10;
                (Motion::Running, 100)
            }
            device::Event::NextPass(..) => {
                self.frames_left = 10;
                (Motion::Running, 100)
            }
            device::Event::PostRoll => (Motion::Stopping, 300),
            _ => return None,
        };
        // A move without motors takes no time, except that a run lasts as long as its frames.
        let is_still = motion != Motion::Running && self.device().moving() == Motors::NONE;
        let time = if is_still { 0 } else { time };
        (self.motion, self.rig_due) = (motion, Some(self.both.now.after(time)));
        None
    }

    /// Reports what is due at the rig.
    fn report(&mut self) {
        self.rig_due = None;
        if self.motion != Motion::Running {
            let is_prepared = matches!(self.motion, Motion::Preparing | Motion::Prepared);
            self.motion = if is_prepared { Motion::Prepared } else { Motion::Rest };
            return self.tell_device(device::Input::Rig(device::Report::AtRest));
        }
        if self.frames_left == 0 {
            return self.tell_device(device::Input::Rig(device::Report::PassEnd));
        }
        self.frames_left -= 1;
        self.rig_due = Some(self.both.now.after(100));
        self.tell_device(device::Input::Rig(device::Report::AtFrame(FrameNumber(10 - self.frames_left))));
    }

    pub(crate) fn act(&mut self, action: Action) {
        match action {
            Action::Move(motor) => self.command(Command::Request(move_to(motor, 5))),
            Action::Jog(motor) => self.command(Command::Request(jog(motor))),
            Action::Configure(motor, flags) => {
                let configure = MotorConfigure { motor: Motor(motor), flags, tail: &[] };
                self.command(Command::Request(configure.into()));
            }
            Action::ConfigureAll(flags, other) => {
                for (motor, flags) in [(1, flags), (2, flags), (3, other)] {
                    self.act(Action::Configure(motor, flags));
                }
            }
            Action::Status => self.command(Command::Request(MotorStatusRequest::default().into())),
            Action::StopLoop => self.command(Command::Request(RtStopLoop::default().into())),
            Action::Upload(has_motors) => {
                self.command(Command::Sequence(begin(1, if has_motors { 10 } else { 1 })));
            }
            Action::ToFrame(number) => self.command(Command::Sequence(position_frame(number))),
            Action::JogAll(number) => self.command(Command::Sequence(jog_all(number))),
            Action::Run(flags) => self.command(Command::Sequence(run(1, 10, flags))),
            Action::Shot => self.command(Command::Sequence(shot(5))),
            Action::Go => self.command(Command::Go),
            Action::Stop(target) => self.stop(target),
            Action::OperatorGo => self.tell_device(device::Input::Rig(device::Report::OperatorGo)),
            Action::Limit(motor) => {
                self.tell_device(device::Input::Rig(device::Report::Limit { motor: Motor(motor), upper: true }));
            }
            Action::Emergency => {
                self.tell_device(device::Input::Rig(device::Report::EmergencyStop(true)));
                self.pass(50);
                self.tell_device(device::Input::Rig(device::Report::EmergencyStop(false)));
            }
            Action::LinkDown => {
                self.both.cut();
                self.called_off = self.last;
                self.tell_device(device::Input::LinkDown);
                self.tell_host(host::Input::LinkDown);
                assert_eq!(self.open(), []);
                self.tell_host(host::Input::LinkUp);
                self.pass(6000);
                self.command(Command::Greet);
                self.pass(6000);
                self.command(Command::Configured);
            }
        }
    }

    fn command(&mut self, command: Command<'static>) {
        let input = self.app.command(command);
        if let host::Input::Command(token, _) = input {
            self.last = token;
        }
        self.tell_host(input);
    }

    /// Stops. The stop leaves in the same step, and calls off everything that may move.
    fn stop(&mut self, target: StopTarget) {
        let before = self.both.up.len();
        let is_spared = self.host().progress().is_some();
        self.command(Command::Stop(target));
        if self.host().state() != host::State::Offline {
            let frame = self.both.up.iter().nth(before).expect("a stop is sent");
            let message = HostMessage::decode(&Frame::decode(frame).unwrap()).unwrap();
            assert!(message.conduct().is_stop(), "{message}");
        }
        if !is_spared || self.host().progress().is_none() {
            self.called_off = self.last;
        }
    }

    /// Lets time pass. Everything is done that is due.
    pub(crate) fn pass(&mut self, millis: u64) {
        let end = self.both.now.after(millis);
        while let Some(next) = self.both.pass(end, self.rig_due) {
            match next {
                Next::Up => {
                    let fate = self.line.fates.pop_front().unwrap_or(Fate::Arrives);
                    let Some((bytes, is_sound)) = self.both.up.meet(fate) else {
                        self.deaf = self.deaf.max(self.line.cuts.pop_front().unwrap_or(0));
                        continue;
                    };
                    // A message in a frame that was cut off is lost too. Padding is no message.
                    let is_eaten = self.deaf > 0;
                    self.deaf = self.deaf.saturating_sub(bytes.len());
                    if is_eaten || bytes[0] == 0 {
                        continue;
                    }
                    let frame = Frame::decode(&bytes).unwrap();
                    self.tell_device(if is_sound {
                        device::Input::received(&frame, |_| AckCode::OK)
                    } else {
                        device::Input::Corrupt(frame.id(), frame.kind())
                    });
                }
                Next::Down => {
                    let fate = self.line.fates.pop_front().unwrap_or(Fate::Arrives);
                    let Some((bytes, is_sound)) = self.both.down.meet(fate) else { continue };
                    let frame = Frame::decode(&bytes).unwrap();
                    self.tell_host(if is_sound { host::Input::received(&frame) } else { host::Input::Corrupt });
                }
                Next::Own => self.report(),
                Next::WakeDevice => self.tell_device(device::Input::Wake),
                Next::WakeHost => self.tell_host(host::Input::Wake),
            }
        }
    }

    /// Stops everything over a good line. Then all commands have ended, and both sides agree.
    pub(crate) fn settle(&mut self) {
        self.line = BadLine::default();
        self.pass(10_000);
        if self.host().state() != host::State::Ready {
            self.command(Command::Greet);
            self.pass(10_000);
            self.command(Command::Configured);
        }
        self.pass(60_000);
        match self.host().progress() {
            None | Some(Progress::Armed) => {}
            Some(Progress::Runs) => assert_eq!(self.device().state(), State::Running, "a loop goes on"),
            Some(progress) => panic!("{progress:?} without end"),
        }
        self.stop(StopTarget::All);
        self.pass(10_000);
        assert_eq!(self.host().state(), host::State::Ready);
        assert_eq!(self.host().unconfirmed_stops().count(), 0);
        assert_eq!(self.host().progress(), None);
        assert_eq!(self.host().pending().count(), 0);
        assert_eq!(self.open(), []);
        assert_eq!(self.device().state(), State::Idle);
        assert!(!self.host().is_armed());
        self.act(Action::Status);
        self.pass(10_000);
        assert!(!self.host().may_move(), "the host knows that nothing moves");
        if let Some(is_loaded) = self.host().is_loaded() {
            assert_eq!(is_loaded, self.device().is_loaded());
        }
        assert_eq!((self.both.host.wake, self.both.device.wake), (None, None), "nothing is due");
    }
}

/// Id of an answer: of a request under way, or any small one.
pub(crate) fn answer_id(machine: &HostMachine, choice: u32) -> MessageId {
    let pending: Vec<_> = machine.pending().map(|(id, _)| id).collect();
    match usize::try_from(choice).unwrap() {
        at if at < pending.len() => pending[at],
        _ => MessageId(choice % 40),
    }
}

/// Message of a device, decoded.
pub(crate) fn device_message(number: u32, body: &[u8]) -> Option<DeviceMessage<'_>> {
    use motion_core::wire::Messages;
    DeviceMessage::decode_body(number, body).ok()
}
