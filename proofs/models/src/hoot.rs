//! Master, a node with three motors, and a line on which packets are lost, damaged, late or answered twice.
//!
//! Both clocks stand at [`NOW`] in every state, because the machines are set back after each advance. So states that
//! differ only in their age are one state.

use hoot_proto::device::{self, Answer, DeviceMachine, Event as Told, Motion, Port, ProgramState};
use hoot_proto::host::{self, Command, HostMachine, Request, StopState, Token};
use hoot_proto::message::{HostMessage, Motor, Steps, StepsPerSecond};
use hoot_proto::{Address, Table};
use laws::machine::step;
use motion_core::time::Millis;
use stateright::{Model, Property};

use crate::line::{Fate, Faults, Line};

mod rules;

pub use rules::Broken;

/// Time of both clocks in every state. Everything longer ago than this counts as this long ago.
const NOW: Millis = Millis(10_000);
/// Address of the node.
pub const NODE: Address = Address::DEFAULT;

/// Event that may happen once, at any time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wish {
    /// The application sends a request. Its token is the number of the wish.
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

/// Packet on a line.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Packet<Message> {
    message: Message,
    /// Latest time of its arrival.
    by: Millis,
    /// Whether the packet comes directly after the one before.
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
    host: HostMachine,
    node: DeviceMachine,
    host_wake: Option<Millis>,
    node_wake: Option<Millis>,
    to_node: Line<Packet<host::Send>>,
    to_host: Line<Packet<Answer>>,
    late: u8,
    rig: [Way; 3],
    /// Motors that are on their way home together.
    homing: [bool; 3],
    /// Wishes that have come true: bit n for wish n.
    used: u32,
    /// Requests that have not ended.
    open: u32,
    /// Requests that were sent.
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
        self.host.state() != host::State::Offline
    }

    fn is_quiet(&self) -> bool {
        self.to_node.is_empty() && self.to_host.is_empty()
    }

    /// Latest time at which the first packet arrives.
    fn latest(&self) -> Option<Millis> {
        self.to_node.iter().map(|packet| packet.by).chain(self.to_host.iter().map(|packet| packet.by)).min()
    }

    /// Next deadline.
    fn next(&self) -> Option<Millis> {
        [self.host_wake, self.node_wake, self.latest()].into_iter().flatten().min()
    }

    /// Sets all clocks back to [`NOW`].
    fn set_back(&mut self, by: u64) {
        let back = |moment: &mut Millis| moment.0 = moment.0.saturating_sub(by);
        self.host = self.host.clone().set_back(by);
        self.node = self.node.clone().set_back(by);
        self.host_wake.iter_mut().chain(&mut self.node_wake).chain(&mut self.stop_due).for_each(back);
        self.to_node.iter_mut().map(|packet| &mut packet.by).for_each(back);
        self.to_host.iter_mut().map(|packet| &mut packet.by).for_each(back);
    }

    fn break_rule(&mut self, broken: Broken) {
        self.broken.get_or_insert(broken);
    }
}

impl Hoot {
    fn host(&self, world: &mut World, now: Millis, input: host::Input<'_>) {
        let (host, output) = step(world.host.clone(), now, input);
        world.host = host;
        world.host_wake = output.wake;
        self.host_did(world, now, &output);
    }

    fn node(&self, world: &mut World, now: Millis, input: device::Input<'_>) {
        let (node, output) = step(world.node.clone(), now, input);
        world.node = node;
        world.node_wake = output.wake;
        for event in output.events {
            match event {
                Told::Motor { motor, motion } => {
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
                Told::Program(ProgramState::Stopped) => world.seen.program_ended = true,
                _ => {}
            }
        }
        let by = now.after(self.delay);
        // A bridge loses refusing replies.
        let answers = output.send.iter().map(|send| send.answer);
        let answers = answers.filter(|answer| !(self.options.bridge && *answer == Answer::Error));
        let packets = answers.enumerate().map(|(at, message)| Packet { message, by, follows: at > 0 });
        if world.is_up() {
            world.to_host.send(packets);
        }
        world.node_is_right();
    }

    fn to_node(&self, world: &mut World, fate: Fate) {
        let Some((packet, is_sound)) = world.to_node.meet(fate) else { return };
        let message = packet.message.message;
        if !is_sound {
            self.node(world, NOW, device::Input::Noise);
            return;
        }
        let heard = if self.flaw == Flaw::DeafToStops && message.is_stop() {
            HostMessage::RunStatus(hoot_proto::message::RunStatus {})
        } else {
            message
        };
        let to = if heard.selector().table == Table::Broadcast { Address::BROADCAST } else { packet.message.to };
        self.node(world, NOW, device::Input::Received { port: Port::Bus, to, message: heard });
        if let HostMessage::ReturnHome(_) = message {
            world.homing = world.rig.map(|way| way == Way::Going(Some(Steps(0))));
        }
        world.obeys(&message, self.node.quirks.refuses_stop);
        world.node_is_right();
    }

    fn to_host(&self, world: &mut World, fate: Fate) {
        let arrived = world.to_host.meet(fate);
        // A packet that follows comes before the settling time of the master is over.
        let soon = NOW.after(u64::from(self.options.settle) - 1);
        let next = world.to_host.iter_mut().next();
        if let Some(next) = next.filter(|next| next.follows || fate == Fate::Doubled) {
            next.by = next.by.min(soon);
        }
        match arrived {
            Some((packet, true)) => {
                let mut scratch = [0; 32];
                let Ok(message) = packet.message.message(&mut scratch) else { return };
                self.host(world, NOW, host::Input::Received(message));
            }
            Some((_, false)) => self.host(world, NOW, host::Input::Noise),
            None => {}
        }
    }

    fn wish(&self, world: &mut World, at: usize) {
        let is_waiting = world.host.state() == host::State::Waiting;
        if let (Flaw::Polite, Wish::Request(HostMessage::Stop(_)), true) = (self.flaw, self.wishes[at], is_waiting) {
            self.expect_stop(world);
            return;
        }
        world.used |= 1 << at;
        let command = match self.wishes[at] {
            Wish::Request(message) => {
                world.open |= 1 << at;
                let token = Token(u32::try_from(at).unwrap_or(u32::MAX));
                let to = if message.selector().table == Table::Broadcast { Address::BROADCAST } else { NODE };
                if message.is_stop() {
                    self.expect_stop(world);
                }
                Command::Request(Request { token, to, message })
            }
            Wish::Speed(motor, speed) => Command::Speed { to: NODE, motor, speed },
            Wish::EmergencyStop => {
                if world.host.stopping() == StopState::Calm {
                    self.expect_stop(world);
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
                world.to_node.cut();
                world.to_host.cut();
                world.stop_due = None;
                self.host(world, NOW, host::Input::LinkDown);
                return;
            }
            Wish::LinkUp => {
                self.host(world, NOW, host::Input::LinkUp);
                return;
            }
            Wish::Button => {
                self.node(world, NOW, device::Input::Command(device::Command::EmergencyStop));
                return;
            }
            Wish::Fault(motor) => {
                self.node(world, NOW, device::Input::Fault(motor));
                return;
            }
        };
        self.host(world, NOW, host::Input::Command(command));
    }

    fn expect_stop(&self, world: &mut World) {
        if world.is_up() {
            world.stop_due.get_or_insert(NOW.after(self.options.gap.into()));
        }
    }

    fn wait(&self, world: &mut World) {
        let Some(next) = world.next() else { return };
        if !world.is_quiet() {
            world.late -= 1;
        }
        if world.stop_due.is_some_and(|due| due < next) {
            world.break_rule(Broken::StopWaits);
        }
        self.host(world, next, host::Input::Wake);
        self.node(world, next, device::Input::Wake);
        world.set_back(next.since(NOW));
    }

    fn may(&self, world: &World, wish: Wish) -> bool {
        match wish {
            Wish::EndEmergency => world.host.stopping() != StopState::Calm,
            Wish::LinkDown => world.is_up(),
            Wish::LinkUp => !world.is_up(),
            Wish::Fault(motor) => world.rig[place(motor)] != Way::Resting,
            _ => true,
        }
    }
}

impl Model for Hoot {
    type State = World;
    type Action = Action;

    fn init_states(&self) -> Vec<World> {
        let (host, _) = step(HostMachine::new(self.options), NOW, host::Input::LinkUp);
        // The setup of the node is long ago.
        let mut node = DeviceMachine::new(self.node);
        for &message in &self.setup {
            (node, _) = step(node, Millis(0), device::Input::Received { port: Port::Bus, to: NODE, message });
        }
        (node, _) = step(node, NOW, device::Input::Wake);
        vec![World {
            host,
            node,
            host_wake: None,
            node_wake: None,
            to_node: Line::new(self.requests),
            to_host: Line::new(self.replies),
            late: self.late,
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
        actions.extend(world.to_node.fates().map(Action::ToNode));
        actions.extend(world.to_host.fates().map(Action::ToHost));
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
                    self.node(&mut world, NOW, device::Input::Position { motor, position });
                }
                world.rig[place(motor)] = Way::Resting;
                world.homing[place(motor)] = false;
                world.seen.arrived = true;
                self.node(&mut world, NOW, device::Input::Arrived(motor));
            }
            Action::Wait => self.wait(&mut world),
        }
        Some(world)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        rules::properties()
    }
}
