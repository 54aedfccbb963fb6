//! Host and device of Dragonframe DMC v2, a faulty line between them, and a rig.
//!
//! Every run of the model ends. The application makes each request once, and the line has a bounded number of faults.
//! Time advances freely only when nothing is outstanding; every other advance is a delay and is counted. A request that
//! is open in a state without successors stays open for ever.

mod book;
mod properties;
mod rig;
mod wants;

use dmc_proto::MessageId;
use dmc_proto::device::{self, DeviceMachine};
use dmc_proto::host::{self, Command, HostMachine, Name, Progress, Token};
use dmc_proto::message::{AckCode, Motor};
use dmc_proto::upload::{SCRATCH, Section, SectionSize};
use motion_core::time::Millis;
use stateright::{Model, Property};

use crate::line::{Fate, Faults, Line};
use book::Book;
use rig::{ALLOWS, Rig};
use wants::{Ramp, hi};

pub use book::Fault;
pub use rig::Report;
pub use wants::Want;

/// Setup of the model, and its bounds.
#[derive(Clone, Debug)]
pub struct Dmc {
    /// Requests that were done before over a good line. With `None` there was nothing before, not even a greeting.
    pub before: Option<&'static [Want]>,
    /// Requests of the application. Each comes once, at any moment and in any order.
    pub wants: &'static [Want],
    /// Faults of messages in each direction.
    pub line: Faults,
    /// Other events that may happen.
    pub mishaps: Mishaps,
    /// Number of requests in flight at once.
    pub window: u8,
    /// Mistake in a machine that the properties must find.
    pub spoilt: Option<Spoilt>,
}

/// Number of times that each event may happen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Mishaps {
    /// Time advances to the next deadline while messages are in flight, or motors move.
    pub delays: u8,
    /// A limit switch is pressed.
    pub limits: u8,
    /// The emergency stop is pressed.
    pub emergencies: u8,
    /// The link is cut.
    pub cuts: u8,
    /// The device is reset.
    pub boots: u8,
    /// The operator starts a move that is ready.
    pub operators: u8,
}

/// Mistake in a machine, made on purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Spoilt {
    /// The device acknowledges stops, and does not obey them.
    DeafDevice,
    /// The host sends everything without an answer once more, even a jog.
    EagerHost,
    /// The host holds a stop back until it sends another message.
    LazyHost,
}

/// Next event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Action {
    /// The link is open, or open again.
    Open,
    /// The application makes the request with this place in its list.
    Want(usize),
    /// The application has configured the device.
    Configured,
    /// The application greets a silent device.
    Greet,
    /// The application gives the signal to start.
    Go,
    /// The first message to the device meets its fate.
    ToDevice(Fate),
    /// The first message to the host meets its fate.
    ToHost(Fate),
    /// The rig reports.
    Report(Report),
    /// A limit switch is pressed.
    Limit,
    /// The emergency stop is pressed.
    Emergency,
    /// The operator presses the switch.
    Operator,
    /// The link is cut.
    Cut,
    /// The device is reset.
    Boot,
    /// Time advances to the next deadline.
    Wait,
}

/// State of the world.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct World {
    now: Millis,
    /// The host.
    pub host: HostMachine,
    host_wake: Option<Millis>,
    /// The device.
    pub device: DeviceMachine,
    device_wake: Option<Millis>,
    to_device: Line<host::Send>,
    to_host: Line<device::Send>,
    rig: Rig,
    mishaps: Mishaps,
    /// Requests that the application has made: bit n for place n of its list.
    wanted: u16,
    book: Book,
    /// Messages that the lazy host holds back.
    kept: Vec<host::Send>,
}

impl World {
    fn new(window: u8) -> Self {
        // Reports of positions do not affect these machines, and each would be one more message to lose.
        let options = device::Options::of(hi()).with_report_every(5000);
        Self {
            now: Millis(0),
            host: HostMachine::new(host::Options::default().with_window(window)),
            host_wake: None,
            device: DeviceMachine::new(options),
            device_wake: None,
            to_device: Line::new(Faults::default()),
            to_host: Line::new(Faults::default()),
            rig: Rig::NEW,
            mishaps: Mishaps::default(),
            wanted: 0,
            book: Book::default(),
            kept: vec![],
        }
    }

    /// Whether no message is in flight, and no motor moves.
    fn is_quiet(&self) -> bool {
        self.to_device.is_empty() && self.to_host.is_empty() && self.rig.reports().is_empty()
    }

    fn wake(&self) -> Option<Millis> {
        [self.host_wake, self.device_wake].into_iter().flatten().min()
    }
}

impl Dmc {
    /// Request of the application with this token.
    fn want(&self, token: Token) -> Option<Want> {
        let before = self.before.unwrap_or_default();
        before.iter().chain(self.wants).nth(token.0 as usize).copied()
    }

    /// Makes a step of the host, and everything that follows from it.
    fn tell_host(&self, world: &mut World, input: host::Input<'_>) {
        let is_stop = matches!(input, host::Input::Command(Command::Stop(_)));
        let (host, mut output) = laws::machine::step(world.host.clone(), world.now, input);
        (world.host, world.host_wake) = (host, output.wake);
        if self.spoilt == Some(Spoilt::LazyHost) {
            let (stops, others) = output.send.iter().partition(|send| matches!(send.what, host::What::Stop(_)));
            let mut sends: Vec<_> = std::mem::replace(&mut world.kept, stops);
            sends.extend::<Vec<_>>(others);
            output.send = sends.into_iter().collect();
        }
        if self.spoilt == Some(Spoilt::EagerHost) {
            for event in &output.events {
                if let host::Event::Failed(token, host::Failure::Timeout) = *event {
                    let what = host::What::Named(Name::Message(token));
                    output.send.extend([host::Send { id: MessageId(99), what }]);
                }
            }
        }
        if is_stop {
            world.book.stop_wanted(&world.host, &output.send, &output.events);
        }
        let mut asked = None;
        for event in &output.events {
            world.book.told(*event);
            match event {
                host::Event::NextSection(behind) => asked = Some(*behind),
                host::Event::Stopped(host::Stop::Motor(motor)) => {
                    world.book.blame(Fault::NotStopped, world.rig.drives(*motor));
                }
                host::Event::Stopped(_) => world.book.blame(Fault::NotStopped, world.rig.is_driven()),
                _ => {}
            }
        }
        for send in &output.send {
            let token = match send.what {
                host::What::Named(Name::Message(token)) => Some(token.0),
                _ => None,
            };
            self.with_message(send, |message| world.book.sent(&world.host, token, send.what, message));
        }
        world.to_device.send(output.send);
        if let Some(behind) = asked {
            let size = SectionSize::default();
            let section = behind.map_or_else(|| Section::first(&Ramp, size), |section| section.next(&Ramp, size));
            self.tell_host(world, host::Input::Section(section));
        }
    }

    /// Gives the message of the host to `look`.
    fn with_message<T>(&self, send: &host::Send, look: impl FnOnce(&dmc_proto::message::HostMessage<'_>) -> T) -> T {
        let mut scratch = [0; SCRATCH];
        let message = send.message(|name| match name {
            Name::Section(section) => section.message(&Ramp, &mut scratch),
            Name::Message(token) => self.want(token).and_then(Want::message).expect("a token of the application"),
        });
        look(&message)
    }

    /// Makes a step of the device, and everything that follows from it.
    fn tell_device(&self, world: &mut World, input: device::Input<'_>) {
        let stop = match input {
            device::Input::Received { message, .. } if message.is_stop() => Some(message.kind()),
            _ => None,
        };
        let (device, mut output) = laws::machine::step(world.device.clone(), world.now, input);
        if stop.is_some() && self.spoilt == Some(Spoilt::DeafDevice) {
            output.events.clear();
        } else {
            (world.device, world.device_wake) = (device, output.wake);
        }
        if let Some(kind) = stop {
            let is_obeyed = matches!(output.events.first(), Some(device::Event::Stop(_)));
            let is_ok = |what| matches!(what, device::What::Ack { of, code: AckCode::OK, .. } if of == kind);
            let is_told = output.send.iter().any(|send| is_ok(send.what));
            world.book.blame(Fault::StopIgnored, !(is_obeyed && is_told));
        }
        let mut stored = None;
        for event in &output.events {
            if let device::Event::Store(store) = event {
                stored = Some(*store);
            }
            if let Some(fault) = world.rig.obey(*event) {
                world.book.blame(fault, true);
            }
        }
        world.to_host.send(output.send);
        if let Some(store) = stored {
            self.tell_device(world, device::Input::Stored(store, AckCode::OK));
        }
    }

    fn to_device(&self, world: &mut World, fate: Fate) {
        let Some((send, is_sound)) = world.to_device.meet(fate) else { return };
        self.with_message(&send, |message| {
            let input = if is_sound {
                device::Input::Received { id: send.id, message: *message, rig: ALLOWS }
            } else {
                device::Input::Corrupt(send.id, message.kind())
            };
            self.tell_device(world, input);
        });
    }

    fn to_host(&self, world: &mut World, fate: Fate) {
        let Some((send, is_sound)) = world.to_host.meet(fate) else { return };
        if !is_sound {
            return self.tell_host(world, host::Input::Corrupt);
        }
        let (rig, mut scratch) = (world.rig, device::Scratch::default());
        let message = send.message(&rig, &mut scratch);
        world.book.heard(&world.host, send.id, &message);
        self.tell_host(world, host::Input::Received(send.id, message));
    }

    fn do_want(&self, world: &mut World, at: usize, want: Want) {
        let command = match want {
            Want::Stop(stop) => {
                world.book.wants_stop();
                return self.tell_host(world, host::Input::Command(Command::Stop(stop)));
            }
            _ => want.message(),
        };
        let (Some(message), Ok(token)) = (command, u32::try_from(at)) else { return };
        let is_free = world.host.progress().is_none();
        world.book.wants(token, want.is_sequence() && is_free);
        let command = if want.is_sequence() {
            Command::Sequence(Token(token), message)
        } else {
            Command::Request(Token(token), message)
        };
        self.tell_host(world, host::Input::Command(command));
    }

    fn act(&self, world: &mut World, action: Action) {
        let command = |world: &mut World, command| self.tell_host(world, host::Input::Command(command));
        match action {
            Action::Open => self.tell_host(world, host::Input::LinkUp),
            Action::Want(at) => {
                world.wanted |= 1 << at;
                let at = at + self.before.unwrap_or_default().len();
                if let Some(want) = u32::try_from(at).ok().and_then(|at| self.want(Token(at))) {
                    self.do_want(world, at, want);
                }
            }
            Action::Configured => {
                world.book.configured = true;
                command(world, Command::Configured);
            }
            Action::Greet => command(world, Command::Greet),
            Action::Go => {
                world.book.signal();
                command(world, Command::Go);
            }
            Action::ToDevice(fate) => self.to_device(world, fate),
            Action::ToHost(fate) => self.to_host(world, fate),
            Action::Report(report) => {
                let input = world.rig.report(report);
                self.tell_device(world, input);
            }
            Action::Limit => {
                world.mishaps.limits -= 1;
                self.tell_device(world, device::Input::Limit { motor: Motor(1), upper: true });
            }
            Action::Emergency => {
                world.mishaps.emergencies -= 1;
                world.rig.pressed = true;
                self.tell_device(world, device::Input::EmergencyStop(true));
            }
            Action::Operator => {
                world.mishaps.operators -= 1;
                self.tell_device(world, device::Input::OperatorGo);
            }
            Action::Cut => {
                world.mishaps.cuts -= 1;
                world.to_device.cut();
                world.to_host.cut();
                self.tell_device(world, device::Input::LinkDown);
                self.tell_host(world, host::Input::LinkDown);
            }
            Action::Boot => {
                world.mishaps.boots -= 1;
                world.device = DeviceMachine::new(*world.device.options());
                world.rig = Rig::NEW;
                world.book.unheard_boot = true;
                self.tell_device(world, device::Input::LinkUp);
            }
            Action::Wait => self.wait(world),
        }
    }

    fn wait(&self, world: &mut World) {
        if !world.is_quiet() {
            world.mishaps.delays -= 1;
        }
        let Some(moment) = world.wake() else { return };
        world.now = moment;
        if world.device_wake.is_some_and(|wake| wake <= moment) {
            self.tell_device(world, device::Input::Wake);
        }
        if world.host_wake.is_some_and(|wake| wake <= moment) {
            self.tell_host(world, host::Input::Wake);
        }
    }

    /// World in which all earlier requests are done.
    fn prepared(&self) -> World {
        let mut world = World::new(self.window);
        let Some(before) = self.before else { return world };
        self.act(&mut world, Action::Open);
        self.settle(&mut world);
        for (at, want) in before.iter().enumerate() {
            self.do_want(&mut world, at, *want);
            self.settle(&mut world);
        }
        assert_eq!((world.book.open, world.book.fault, world.host.state()), (0, None, host::State::Up));
        world.book = Book::default();
        world.book.configured = true;
        world
    }

    /// Lets everything that is outstanding happen, over a good line.
    fn settle(&self, world: &mut World) {
        let mut actions = vec![];
        loop {
            self.enabled(world, &mut actions);
            let next = actions.iter().find(|action| !matches!(action, Action::Want(_)));
            let Some(&next) = next else { return };
            self.act(world, next);
            actions.clear();
        }
    }

    /// Possible events.
    fn enabled(&self, world: &World, actions: &mut Vec<Action>) {
        let state = world.host.state();
        actions.extend(world.to_device.fates().map(Action::ToDevice));
        actions.extend(world.to_host.fates().map(Action::ToHost));
        actions.extend(world.rig.reports().into_iter().map(Action::Report));
        let mishaps = world.mishaps;
        let is_ready = world.device.state() == device::State::Ready;
        let is_configuring = state == host::State::Configuring && !world.book.configured;
        let others = [
            (state == host::State::Closed, Action::Open),
            (state == host::State::Silent, Action::Greet),
            (is_configuring, Action::Configured),
            (world.host.progress() == Some(Progress::Ready), Action::Go),
            (mishaps.limits > 0, Action::Limit),
            (mishaps.emergencies > 0, Action::Emergency),
            (mishaps.operators > 0 && is_ready, Action::Operator),
            (mishaps.cuts > 0 && state != host::State::Closed, Action::Cut),
            (mishaps.boots > 0 && state != host::State::Closed, Action::Boot),
            (world.wake().is_some() && (world.is_quiet() || mishaps.delays > 0), Action::Wait),
        ];
        actions.extend(others.into_iter().filter(|(can, _)| *can).map(|(_, action)| action));
        let open = (0..self.wants.len()).filter(|at| world.wanted & (1 << at) == 0);
        actions.extend(open.map(Action::Want));
    }
}

impl Model for Dmc {
    type State = World;
    type Action = Action;

    fn init_states(&self) -> Vec<World> {
        let mut world = self.prepared();
        world.to_device = Line::new(self.line);
        world.to_host = Line::new(self.line);
        (world.mishaps, world.wanted) = (self.mishaps, 0);
        vec![world]
    }

    fn actions(&self, world: &World, actions: &mut Vec<Action>) {
        // A state with a fault is found, and its successors are not explored.
        if world.book.fault.is_none() {
            self.enabled(world, actions);
        }
    }

    fn next_state(&self, world: &World, action: Action) -> Option<World> {
        let mut world = world.clone();
        self.act(&mut world, action);
        Some(world)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        properties::all()
    }
}
