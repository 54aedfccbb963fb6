//! Host and device of Dragonframe DMC v2, a faulty line between them, and a rig.
//!
//! Every run of the model ends. The application makes each request once, and the line has a bounded number of faults.
//! Time advances freely only when nothing is outstanding; every other advance is a delay and is counted. A request that
//! is open in a state without successors stays open for ever.

mod book;
mod properties;
mod rig;
mod wants;

use dmc_proto::device::{self, DeviceMachine, Quirks};
use dmc_proto::host::{self, Command, HostMachine, Outcome, Progress, Source, StopTarget};
use dmc_proto::message::{AckCode, HostMessage, Motor};
use dmc_proto::upload::{SCRATCH, Section, SectionSize};
use dmc_proto::{Effect, MessageId, Millis, Token};
use laws::world::{self, Fate, Faults, Line};
use stateright::{Model, Property};

use book::{Book, is_stop};
use rig::{ALLOWS, Rig};
use wants::{Ramp, hi};

pub use book::Fault;
pub use rig::Report;
pub use wants::Want;

/// Token of the signal to start. At most one signal is open.
const GO: Token = Token(14);
/// Token of commands that end at once and that the application may give again.
const AT_ONCE: Token = Token(15);

/// Time at which every message arrives. A message is late if other things happen first.
const ANY_TIME: Millis = Millis(0);

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
    /// Differences of the device from the specification.
    pub quirks: Quirks,
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
    /// Both machines, and the messages between them.
    both: world::World<HostMachine, DeviceMachine, host::Transmit, device::Transmit>,
    rig: Rig,
    mishaps: Mishaps,
    /// Requests that the application has made: bit n for place n of its list.
    wanted: u16,
    book: Book,
    /// Stops that the lazy host holds back.
    held: Vec<host::Transmit>,
}

impl World {
    fn new(window: u8, quirks: Quirks) -> Self {
        let host = HostMachine::new(host::Options::default().with_window(window).with_needs_enabled(false));
        // Reports of positions do not affect these machines, and each would be one more message to lose.
        let device = DeviceMachine::new(device::Options::of(hi()).with_report_every(5000).with_quirks(quirks));
        Self {
            both: world::World::new(Millis(0), host, device, Faults::default()),
            rig: Rig::NEW,
            mishaps: Mishaps::default(),
            wanted: 0,
            book: Book::default(),
            held: vec![],
        }
    }

    const fn host(&self) -> &HostMachine {
        &self.both.host.machine
    }

    const fn device(&self) -> &DeviceMachine {
        &self.both.device.machine
    }

    /// Whether no message is in flight.
    fn is_line_empty(&self) -> bool {
        self.both.up.is_empty() && self.both.down.is_empty()
    }

    /// Whether no message is in flight, and no motor moves.
    fn is_quiet(&self) -> bool {
        self.is_line_empty() && self.rig.reports().is_empty()
    }

    fn wake(&self) -> Option<Millis> {
        [self.both.host.wake, self.both.device.wake].into_iter().flatten().min()
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
        let output = world.both.step_host(input);
        let mut effects: Vec<_> = output.into_iter().collect();
        match self.spoilt {
            Some(Spoilt::LazyHost) => {
                let held = std::mem::take(&mut world.held);
                effects.retain(|effect| match effect {
                    Effect::Transmit(transmit) if is_stop(effect) => {
                        world.held.push(*transmit);
                        false
                    }
                    _ => true,
                });
                effects.splice(0..0, held.into_iter().map(Effect::Transmit));
            }
            Some(Spoilt::EagerHost) => {
                let again = effects.iter().find_map(|effect| match *effect {
                    Effect::Event(host::Event::Ended { token, outcome: Outcome::NotConfirmed }) => Some(token),
                    _ => None,
                });
                effects.extend(again.map(|token| {
                    let contents = host::Contents::Application(Source::Command(token));
                    Effect::Transmit(host::Transmit { id: MessageId(99), contents })
                }));
            }
            _ => {}
        }
        if let host::Input::Command(_, Command::Stop(_)) = input {
            world.book.stop_wanted(&world.both.host.machine, &effects);
        }
        let mut asked = None;
        for effect in effects {
            match effect {
                // Padding is no message.
                Effect::Transmit(host::Transmit { contents: host::Contents::Padding(_), .. }) => {}
                Effect::Transmit(transmit) => {
                    self.with_message(transmit, |message| {
                        world.book.sent(&world.both.host.machine, transmit.contents, message);
                    });
                    world.both.up.send(ANY_TIME, transmit);
                }
                Effect::Event(event) => {
                    world.book.event(event);
                    match event {
                        host::Event::NextSection { after, .. } => asked = Some(after),
                        host::Event::Stopped(StopTarget::Motor(motor)) => {
                            world.book.blame(Fault::NotStopped, world.rig.drives(motor));
                        }
                        host::Event::Stopped(_) => world.book.blame(Fault::NotStopped, world.rig.is_driven()),
                        _ => {}
                    }
                }
            }
        }
        world.book.step_ends();
        if let Some(after) = asked {
            let size = SectionSize::default();
            let section = after.map_or_else(|| Section::first(&Ramp, size), |section| section.next(&Ramp, size));
            self.tell_host(world, host::Input::Section(section));
        }
    }

    /// Gives the message of the host to `look`.
    fn with_message<T>(&self, transmit: host::Transmit, look: impl FnOnce(&HostMessage<'_>) -> T) -> T {
        let mut scratch = [0; SCRATCH];
        let message = transmit.message(|source| match source {
            Source::Section(section) => section.message(&Ramp, &mut scratch),
            Source::Command(token) => self.want(token).and_then(Want::message).expect("a token of the application"),
        });
        look(&message.expect("padding is not kept"))
    }

    /// Makes a step of the device, and everything that follows from it.
    fn tell_device(&self, world: &mut World, input: device::Input<'_>) {
        let stop = match input {
            device::Input::Received { message, .. } if message.conduct().is_stop() => Some(message.kind()),
            _ => None,
        };
        let before = world.both.device.clone();
        // A device that is locked after a stop refuses further stops.
        let may_refuse = self.quirks.contains(Quirks::STOP_LOCKS) && before.machine.state() == device::State::Locked;
        let mut output = world.both.step_device(input);
        if stop.is_some() && self.spoilt == Some(Spoilt::DeafDevice) {
            world.both.device = before;
            output.effects.retain(|effect| matches!(effect, Effect::Transmit(_)));
        }
        if let Some(kind) = stop {
            let is_obeyed = matches!(output.effects.first(), Some(Effect::Event(device::Event::Stop(_))));
            let is_ok =
                |contents| matches!(contents, device::Contents::Ack { of, code: AckCode::OK, .. } if of == kind);
            let is_told = output.transmits().any(|transmit| is_ok(transmit.contents));
            world.book.blame(Fault::StopIgnored, !(may_refuse || is_obeyed && is_told));
        }
        let mut stored = None;
        for effect in output {
            match effect {
                Effect::Transmit(transmit) => world.both.down.send(ANY_TIME, transmit),
                Effect::Event(device::Event::Store { store, .. }) => stored = Some(store),
                Effect::Event(event) => {
                    if let Some(fault) = world.rig.obey(event) {
                        world.book.blame(fault, true);
                    }
                }
            }
        }
        if let Some(store) = stored {
            self.tell_device(world, device::Input::Rig(device::Report::Stored(store, AckCode::OK)));
        }
    }

    fn to_device(&self, world: &mut World, fate: Fate) {
        let Some((transmit, is_sound)) = world.both.up.meet(fate) else { return };
        self.with_message(transmit, |message| {
            let input = if is_sound {
                device::Input::Received { id: transmit.id, message: *message, rig: ALLOWS }
            } else {
                device::Input::Corrupt(transmit.id, message.kind())
            };
            self.tell_device(world, input);
        });
    }

    fn to_host(&self, world: &mut World, fate: Fate) {
        let Some((transmit, is_sound)) = world.both.down.meet(fate) else { return };
        if !is_sound {
            return self.tell_host(world, host::Input::Corrupt);
        }
        let (rig, mut scratch) = (world.rig, device::Scratch::default());
        let message = transmit.message(&rig, &mut scratch);
        world.book.received(&world.both.host.machine, transmit.id, &message);
        self.tell_host(world, host::Input::Received(transmit.id, message));
    }

    fn make(&self, world: &mut World, token: Token, want: Want) {
        let command = match (want, want.message()) {
            (Want::Stop(target), _) => {
                world.book.wants_stop();
                Command::Stop(target)
            }
            (_, Some(message)) if want.is_sequence() => Command::Sequence(message),
            (_, Some(message)) => Command::Request(message),
            (_, None) => return,
        };
        world.book.wants(token, want.is_sequence() && world.host().progress().is_none());
        self.tell_host(world, host::Input::Command(token, command));
    }

    fn act(&self, world: &mut World, action: Action) {
        let at_once = |world: &mut World, command| {
            world.book.wants(AT_ONCE, false);
            self.tell_host(world, host::Input::Command(AT_ONCE, command));
        };
        match action {
            Action::Open => self.tell_host(world, host::Input::LinkUp),
            Action::Want(at) => {
                world.wanted |= 1 << at;
                let token = u32::try_from(at + self.before.unwrap_or_default().len()).map(Token);
                if let Some((token, want)) = token.ok().and_then(|token| Some((token, self.want(token)?))) {
                    self.make(world, token, want);
                }
            }
            Action::Configured => {
                world.book.configured = true;
                at_once(world, Command::Configured);
            }
            Action::Greet => at_once(world, Command::Greet),
            Action::Go => {
                world.book.signal();
                world.book.wants(GO, false);
                self.tell_host(world, host::Input::Command(GO, Command::Go));
            }
            Action::ToDevice(fate) => self.to_device(world, fate),
            Action::ToHost(fate) => self.to_host(world, fate),
            Action::Report(report) => {
                let input = world.rig.report(report);
                self.tell_device(world, input);
            }
            Action::Limit => {
                world.mishaps.limits -= 1;
                self.tell_device(world, device::Input::Rig(device::Report::Limit { motor: Motor(1), upper: true }));
            }
            Action::Emergency => {
                world.mishaps.emergencies -= 1;
                world.rig.pressed = true;
                self.tell_device(world, device::Input::Rig(device::Report::EmergencyStop(true)));
            }
            Action::Operator => {
                world.mishaps.operators -= 1;
                self.tell_device(world, device::Input::Rig(device::Report::OperatorGo));
            }
            Action::Cut => {
                world.mishaps.cuts -= 1;
                world.both.cut();
                self.tell_device(world, device::Input::LinkDown);
                self.tell_host(world, host::Input::LinkDown);
            }
            Action::Boot => {
                world.mishaps.boots -= 1;
                world.both.device.machine = DeviceMachine::new(*world.device().options());
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
        world.both.now = moment;
        if world.both.device.wake.is_some_and(|wake| wake <= moment) {
            self.tell_device(world, device::Input::Wake);
        }
        if world.both.host.wake.is_some_and(|wake| wake <= moment) {
            self.tell_host(world, host::Input::Wake);
        }
    }

    /// World in which all earlier requests are done.
    fn prepared(&self) -> World {
        let mut world = World::new(self.window, self.quirks);
        let Some(before) = self.before else { return world };
        self.act(&mut world, Action::Open);
        self.settle(&mut world);
        for (token, want) in (0..).map(Token).zip(before) {
            self.make(&mut world, token, *want);
            self.settle(&mut world);
        }
        assert_eq!((world.book.open, world.book.fault, world.host().state()), (0, None, host::State::Ready));
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
        let state = world.host().state();
        actions.extend(world.both.up.fates().map(Action::ToDevice));
        actions.extend(world.both.down.fates().map(Action::ToHost));
        actions.extend(world.rig.reports().into_iter().map(Action::Report));
        let mishaps = world.mishaps;
        let is_ready = world.device().state() == device::State::Ready;
        let is_configuring = state == host::State::Configuring && !world.book.configured;
        let others = [
            (state == host::State::Offline, Action::Open),
            (state == host::State::Silent, Action::Greet),
            (is_configuring, Action::Configured),
            (world.host().progress() == Some(Progress::Armed), Action::Go),
            (mishaps.limits > 0, Action::Limit),
            (mishaps.emergencies > 0, Action::Emergency),
            (mishaps.operators > 0 && is_ready, Action::Operator),
            (mishaps.cuts > 0 && state != host::State::Offline, Action::Cut),
            (mishaps.boots > 0 && state != host::State::Offline, Action::Boot),
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
        (world.both.up, world.both.down) = (Line::new(self.line), Line::new(self.line));
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
