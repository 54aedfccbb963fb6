//! Master, a node with three motors, and a line on which packets are lost, damaged, late or answered twice. A start blocks
//! the node: it hears nothing for a while, and hangs if two packets wait then (decision H-41).
//!
//! Both clocks stand at [`NOW`] in every state, because the machines are set back after each advance. So states that
//! differ only in their age are one state.

use hoot_proto::device::{self, Answer, Contents, DeviceMachine, Event as NodeEvent, Motion, Port, ProgramState};
use hoot_proto::host::{self, Command, HostMachine, Request, StopState, Token, Transmit};
use hoot_proto::message::{HostMessage, Motor, RunStatus, Start, Steps, StepsPerSecond};
use hoot_proto::{Address, Effect, Millis, Table};
use laws::world::{Fate, Faults, Line};
use stateright::{Model, Property};

mod rules;

pub use rules::Broken;

/// Time of both clocks in every state. Everything longer ago than this counts as this long ago.
const NOW: Millis = Millis(10_000);
/// Time for which a start blocks the node, in milliseconds.
const START_BLOCKS: u64 = 1500;
/// Longest time for which the master takes the node to be deaf.
const DEAF: u64 = 3000;
/// Time within which the same stop is not repeated.
const AGAIN: u64 = 500;
/// Address of the node.
pub const NODE: Address = Address::DEFAULT;

/// Event that may happen once, at any time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wish {
    /// The application sends a request. The token of each command is the number of its wish.
    Request(HostMessage<'static>),
    /// The application sets the speed of a run.
    Speed(Motor, StepsPerSecond),
    /// The application stops everything.
    EmergencyStop,
    /// The application ends an emergency stop.
    EndEmergency,
    /// The application keeps the node alive from then on.
    KeepAlive,
    /// The line of the master goes down, with all packets on it.
    LinkDown,
    /// The line of the master comes up again.
    LinkUp,
    /// Another master starts the program of the node, while the line of the master is down.
    OtherStarts,
    /// A person presses the emergency button of the node.
    Button,
    /// A moving motor cannot go on.
    Fault(Motor),
}

/// Mistake in a machine that the properties must find.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Flaw {
    /// No mistake.
    #[default]
    None,
    /// The node acknowledges stops, and goes on.
    DeafToStops,
    /// The master sends every request without an answer again.
    Resends,
    /// The master sends no stop while it waits for an answer.
    Polite,
    /// The master does not report the end of a request.
    Forgets,
    /// The master sends every stop of the controller twice.
    Hurries,
}

/// Setup of the model, and its bounds.
#[derive(Clone, Debug)]
pub struct Hoot {
    /// Options of the master.
    pub options: host::Options,
    /// Options of the node. First of all, [`setup`](Self::setup) is sent to it.
    pub node: device::Options,
    /// Messages that set up the node.
    pub setup: Vec<HostMessage<'static>>,
    /// Events that may happen, each once and in any order.
    pub wishes: Vec<Wish>,
    /// Faults of the packets of the master.
    pub requests: Faults,
    /// Faults of the packets of the node.
    pub replies: Faults,
    /// Longest time of a packet in flight, in milliseconds.
    pub delay: u64,
    /// Number of times that time may advance while a packet is in flight.
    pub late: u8,
    /// Mistake in a machine.
    pub flaw: Flaw,
}

/// Reply in flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Reply {
    answer: Answer,
    /// Whether the reply comes directly after the one before.
    follows: bool,
}

/// Motion of a motor of the rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Way {
    Resting,
    /// The motor moves to a known position, or by a number of steps.
    Going(Option<Steps>),
    Running,
}

/// Reports of the last step, to check that each of them is reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Seen {
    done: bool,
    silence: bool,
    confirmed: bool,
    not_confirmed: bool,
    unsolicited: bool,
    refused: bool,
    arrived: bool,
    program_ended: bool,
}

/// State of the world.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct World {
    /// Master, node and line. A packet arrives at its moment at the latest.
    both: laws::world::World<HostMachine, DeviceMachine, Transmit, Reply>,
    late: u8,
    /// Time until which a start blocks the node.
    blocked_until: Option<Millis>,
    /// Packet that waits at the node meanwhile.
    waiting: Option<Transmit>,
    /// Answer to the start, which the node gives at the end of the block.
    held: Option<Reply>,
    /// Time until which the master takes the node to be deaf, unless it hears of it.
    deaf_until: Option<Millis>,
    /// Time until which a packet may wait at the node, unless the master hears of it.
    waits_until: Option<Millis>,
    /// Stops for which the application may still wish, after which nothing went out that may move, and their last times.
    stops: Vec<(HostMessage<'static>, Millis)>,
    /// Whether somebody else set something in motion.
    is_foreign: bool,
    rig: [Way; 3],
    /// Motors that are on their way home together.
    homing: [bool; 3],
    /// Wishes that have come true: bit n for wish n.
    used: u32,
    /// Commands that have not ended: bit n for wish n.
    open: u32,
    /// Requests that were sent: bit n for wish n.
    sent: u32,
    /// Latest time to send a stop. Nothing may be sent before it.
    stop_due: Option<Millis>,
    /// Whether the application knows that the emergency stop is not confirmed.
    is_told: bool,
    seen: Seen,
    /// First rule that was broken.
    broken: Option<Broken>,
}

/// Next event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// A wish comes true.
    Wish(usize),
    /// The first packet to the node meets its fate.
    ToNode(Fate),
    /// The first packet to the master meets its fate.
    ToHost(Fate),
    /// A motor arrives.
    Arrives(Motor),
    /// Time advances to the next deadline.
    Wait,
}

fn place(motor: Motor) -> usize {
    usize::from(motor.get()) - 1
}

impl World {
    fn is_up(&self) -> bool {
        self.both.host.machine.state() != host::State::Offline
    }

    fn stopping(&self) -> StopState {
        self.both.host.machine.stopping()
    }

    fn is_quiet(&self) -> bool {
        self.both.up.is_empty() && self.both.down.is_empty()
    }

    /// Next deadline.
    fn next(&self) -> Option<Millis> {
        self.both.next(self.blocked_until).map(|(due, _)| due)
    }

    /// Whether a stop may have to wait: a packet may wait at the node, or the same stop was sent just before.
    fn may_hold(&self, stop: Option<HostMessage<'_>>) -> bool {
        let is_recent = |(sent, at): &(HostMessage<'_>, Millis)| Some(*sent) == stop && NOW < at.after(AGAIN);
        self.waits_until.is_some() || self.stops.iter().any(is_recent)
    }

    /// Sets all clocks back to [`NOW`].
    fn set_back(&mut self) {
        let both = &mut self.both;
        let by = both.now.since(NOW);
        let back = |moment: &mut Millis| moment.0 = moment.0.saturating_sub(by);
        both.now = NOW;
        both.host.machine = both.host.machine.clone().set_back(by);
        both.device.machine = both.device.machine.clone().set_back(by);
        both.up.set_back(by);
        both.down.set_back(by);
        self.deaf_until = self.deaf_until.filter(|until| by < until.since(NOW));
        self.waits_until = self.waits_until.filter(|until| by < until.since(NOW) && self.deaf_until.is_some());
        self.stops.retain(|(_, at)| at.after(AGAIN).since(NOW) > by);
        let stops = self.stops.iter_mut().map(|(_, at)| at);
        let own = self.blocked_until.iter_mut().chain(&mut self.deaf_until).chain(&mut self.waits_until).chain(stops);
        both.host.wake.iter_mut().chain(&mut both.device.wake).chain(&mut self.stop_due).chain(own).for_each(back);
    }

    fn break_rule(&mut self, broken: Broken) {
        self.broken.get_or_insert(broken);
    }
}

impl Hoot {
    fn host(&self, world: &mut World, input: host::Input<'_>) {
        let output = world.both.step_host(input);
        self.host_did(world, &output);
    }

    fn node(&self, world: &mut World, input: device::Input<'_>) {
        let output = world.both.step_device(input);
        let mut replies = 0;
        for effect in output {
            match effect {
                Effect::Event(NodeEvent::Motor { motor, motion }) => {
                    let way = match motion {
                        Motion::Stop => Way::Resting,
                        Motion::By { .. } | Motion::Along { .. } => Way::Going(None),
                        Motion::To(place) => Way::Going(Some(place)),
                        Motion::Run { .. } => Way::Running,
                        _ => continue,
                    };
                    world.rig[place(motor)] = way;
                    world.homing[place(motor)] = false;
                }
                Effect::Event(NodeEvent::Program(ProgramState::Stopped)) => world.seen.program_ended = true,
                // A bridge loses replies that refuse.
                Effect::Transmit(device::Transmit { contents: Contents::Answer(answer), .. })
                    if (world.is_up() || world.blocked_until.is_some())
                        && !(self.options.bridge() && answer == Answer::Error) =>
                {
                    let due = world.both.now.after(self.delay);
                    let reply = Reply { answer, follows: replies > 0 };
                    match world.blocked_until {
                        Some(_) => world.held = Some(reply),
                        None => world.both.down.send(due, reply),
                    }
                    replies += 1;
                }
                _ => {}
            }
        }
        world.node_is_right();
    }

    fn to_node(&self, world: &mut World, fate: Fate) {
        let Some((Transmit { to, message }, is_undamaged)) = world.both.up.meet(fate) else { return };
        if !is_undamaged {
            self.node(world, device::Input::Noise);
            return;
        }
        if world.blocked_until.is_some() {
            if world.waiting.replace(Transmit { to, message }).is_some() {
                world.break_rule(Broken::TwoWait);
            }
            return;
        }
        self.receive(world, Transmit { to, message });
    }

    /// The block of the node is over: it answers the start and hears what waits.
    fn block_is_over(&self, world: &mut World) {
        world.blocked_until = None;
        if let Some(reply) = world.held.take().filter(|_| world.is_up()) {
            let due = world.both.now.after(self.delay);
            world.both.down.send(due, reply);
        }
        if let Some(transmit) = world.waiting.take() {
            self.receive(world, transmit);
        }
    }

    fn receive(&self, world: &mut World, Transmit { to, message }: Transmit) {
        if let HostMessage::Start(_) = message {
            world.blocked_until = Some(world.both.now.after(START_BLOCKS));
        }
        let is_deaf = self.flaw == Flaw::DeafToStops && rules::is_stop(&message);
        let heard = if is_deaf { RunStatus {}.into() } else { message };
        let to = if heard.selector().table == Table::Broadcast { Address::BROADCAST } else { to };
        self.node(world, device::Input::Received { port: Port::Bus, to, message: heard });
        if let HostMessage::ReturnHome(_) = message {
            world.homing = world.rig.map(|way| way == Way::Going(Some(Steps(0))));
        }
        world.obeys(&message, self.node.quirks().contains(device::Quirks::REFUSES_STOP));
        world.node_is_right();
    }

    fn to_host(&self, world: &mut World, fate: Fate) {
        let arrived = world.both.down.meet(fate);
        // A reply that follows comes before the settling time of the master is over.
        if world.both.down.iter().next().is_some_and(|next| next.follows || fate == Fate::Doubled) {
            world.both.down.hasten(NOW.after(u64::from(self.options.settle()) - 1));
        }
        match arrived {
            Some((reply, true)) => {
                let mut scratch = [0; 32];
                let Ok(message) = reply.answer.message(&mut scratch) else { return };
                self.host(world, host::Input::Received(message));
                if !world.seen.unsolicited {
                    (world.deaf_until, world.waits_until) = (None, None);
                }
            }
            Some((_, false)) => self.host(world, host::Input::Noise),
            None => {}
        }
    }

    fn wish(&self, world: &mut World, at: usize) {
        let is_waiting = world.both.host.machine.state() == host::State::Waiting;
        if let (Flaw::Polite, Wish::Request(message @ HostMessage::Stop(_)), true) =
            (self.flaw, self.wishes[at], is_waiting)
        {
            self.expect_stop(world, Some(message));
            return;
        }
        world.used |= 1 << at;
        let command = match self.wishes[at] {
            Wish::Request(message) => {
                let to = if message.selector().table == Table::Broadcast { Address::BROADCAST } else { NODE };
                if rules::is_stop(&message) {
                    self.expect_stop(world, Some(message));
                }
                Command::Request(Request { to, message })
            }
            Wish::Speed(motor, speed) => Command::Speed { to: NODE, motor, speed },
            Wish::EmergencyStop => {
                if world.stopping() == StopState::Calm {
                    self.expect_stop(world, None);
                }
                Command::EmergencyStop
            }
            Wish::EndEmergency => {
                // The application may end the emergency before its first packet is sent.
                world.stop_due = None;
                Command::EndEmergency
            }
            Wish::KeepAlive => Command::KeepAlive { to: NODE, on: true },
            Wish::LinkDown => {
                world.both.cut();
                world.stop_due = None;
                return self.host(world, host::Input::LinkDown);
            }
            Wish::LinkUp => {
                world.deaf_until = Some(NOW.after(DEAF));
                return self.host(world, host::Input::LinkUp);
            }
            Wish::OtherStarts => {
                world.is_foreign = true;
                return self.receive(world, Transmit { to: NODE, message: Start {}.into() });
            }
            Wish::Button => {
                return self.node(world, device::Input::Command(device::Command::EmergencyStop));
            }
            Wish::Fault(motor) => return self.node(world, device::Input::Fault(motor)),
        };
        world.open |= 1 << at;
        self.host(world, host::Input::Command(Token(at as u32), command));
    }

    fn expect_stop(&self, world: &mut World, stop: Option<HostMessage<'_>>) {
        if world.is_up() && !world.may_hold(stop) {
            world.stop_due.get_or_insert(NOW.after(self.options.gap().into()));
        }
        world.stops.retain(|(sent, _)| Some(*sent) != stop);
    }

    fn wait(&self, world: &mut World) {
        let Some(next) = world.next() else { return };
        if !world.is_quiet() {
            world.late -= 1;
        }
        if world.stop_due.is_some_and(|due| due < next) {
            world.break_rule(Broken::StopWaits);
        }
        world.both.now = next;
        if world.blocked_until.is_some_and(|until| until <= next) {
            self.block_is_over(world);
        }
        self.host(world, host::Input::Wake);
        self.node(world, device::Input::Wake);
        world.set_back();
    }

    fn may(&self, world: &World, wish: Wish) -> bool {
        match wish {
            Wish::EndEmergency => world.stopping() != StopState::Calm,
            Wish::LinkDown => world.is_up(),
            Wish::LinkUp => !world.is_up(),
            Wish::OtherStarts => !world.is_up() && world.blocked_until.is_none(),
            Wish::Fault(motor) => world.rig[place(motor)] != Way::Resting,
            _ => true,
        }
    }
}

impl Model for Hoot {
    type State = World;
    type Action = Action;

    fn init_states(&self) -> Vec<World> {
        // The line came up, and the node was set up, long ago.
        let mut host = HostMachine::new(self.options);
        let _ = host.advance(Millis(0), host::Input::LinkUp);
        let _ = host.advance(NOW, host::Input::Wake);
        let mut node = DeviceMachine::new(self.node);
        for &message in &self.setup {
            let _ = node.advance(Millis(0), device::Input::Received { port: Port::Bus, to: NODE, message });
        }
        let _ = node.advance(NOW, device::Input::Wake);
        let mut both = laws::world::World::new(NOW, host, node, Faults::default());
        (both.up, both.down) = (Line::new(self.requests), Line::new(self.replies));
        vec![World {
            both,
            late: self.late,
            blocked_until: None,
            waiting: None,
            held: None,
            deaf_until: None,
            waits_until: None,
            stops: Vec::new(),
            is_foreign: false,
            rig: [Way::Resting; 3],
            homing: [false; 3],
            used: 0,
            open: 0,
            sent: 0,
            stop_due: None,
            is_told: false,
            seen: Seen::default(),
            broken: None,
        }]
    }

    fn actions(&self, world: &World, actions: &mut Vec<Action>) {
        if world.broken.is_some() {
            return;
        }
        let wishes = self.wishes.iter().enumerate();
        actions.extend(
            wishes
                .filter(|(at, wish)| world.used & 1 << at == 0 && self.may(world, **wish))
                .map(|(at, _)| Action::Wish(at)),
        );
        actions.extend(world.both.up.fates().map(Action::ToNode));
        actions.extend(world.both.down.fates().map(Action::ToHost));
        let going = Motor::ALL.into_iter().filter(|motor| matches!(world.rig[place(*motor)], Way::Going(_)));
        actions.extend(going.map(Action::Arrives));
        let may_wait = world.is_quiet() || world.late > 0;
        if may_wait && world.next().is_some_and(|next| next > NOW) {
            actions.push(Action::Wait);
        }
    }

    fn next_state(&self, last: &World, action: Action) -> Option<World> {
        let mut world = World { seen: Seen::default(), ..last.clone() };
        match action {
            Action::Wish(at) => self.wish(&mut world, at),
            Action::ToNode(fate) => self.to_node(&mut world, fate),
            Action::ToHost(fate) => self.to_host(&mut world, fate),
            Action::Arrives(motor) => {
                if let Way::Going(Some(position)) = world.rig[place(motor)] {
                    self.node(&mut world, device::Input::Position { motor, position });
                }
                world.rig[place(motor)] = Way::Resting;
                world.homing[place(motor)] = false;
                world.seen.arrived = true;
                self.node(&mut world, device::Input::Arrived(motor));
            }
            Action::Wait => self.wait(&mut world),
        }
        Some(world)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        rules::properties()
    }
}
