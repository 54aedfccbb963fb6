//! Random inputs: each machine alone with hostile inputs, and both machines on a line that loses, damages, delays and
//! doubles messages, but does not reorder them.

use std::collections::{BTreeMap, BTreeSet};

use super::world::*;
use hoot_proto::device::{
    self, Command as AtNode, Contact, DeviceMachine, Event as NodeEvent, Motion, Options as NodeOptions, Port,
    ProgramState, Quirks,
};
use hoot_proto::frame::Selector;
use hoot_proto::host::{
    Command, Event, HostMachine, Input, Options, Outcome, Output, Refusal, Request, StopState, StopTarget, Token,
};
use hoot_proto::message::{self, AltMode, HostMessage, Motor, Reply, ResponseCode, RingTip, Steps, StepsPerSecond};
use hoot_proto::query::Profile;
use hoot_proto::{Address, DeviceMessage, Messages, Millis, Query, Table};
use laws::world::{Fate, Faults, Line, Next, Tokens};
use proptest::prelude::*;
use proptest_state_machine::{ReferenceStateMachine, StateMachineTest, prop_state_machine};

/// Numbers of messages. Numbers that exist come up more often than others.
fn any_number() -> impl Strategy<Value = u32> {
    prop_oneof![
        8 => any::<prop::sample::Index>().prop_map(|at| at.get(HostMessage::ALL).number),
        1 => 0_u32..0x2_FFFF,
    ]
}

/// Bodies. Plausible bodies come up more often than others.
fn any_body() -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![
        2 => Just(vec![]),
        3 => (0_u8..12).prop_map(|byte| vec![byte]),
        2 => (0_u8..2, 0_u8..200).prop_map(|(high, low)| vec![high, low]),
        2 => (0_u8..4, any::<u8>()).prop_map(|(high, low)| vec![0, 0, high, low]),
        1 => any::<f32>().prop_map(|speed| speed.to_be_bytes().to_vec()),
        1 => (-4000.0_f32..4000.0).prop_map(|speed| speed.to_be_bytes().to_vec()),
        2 => (0_u8..2, 0_u8..3).prop_map(|(way, steps)| vec![way, 0, 0, 0, steps]),
        1 => proptest::collection::vec(any::<u8>(), 0..34),
    ]
}

pub(crate) fn decode(number: u32, body: &[u8]) -> HostMessage<'_> {
    HostMessage::decode_body(number, body).unwrap_or_else(|_| HostMessage::other(number, body))
}

fn any_motor() -> impl Strategy<Value = Motor> {
    prop::sample::select(&Motor::ALL[..])
}

/// Input of a node.
#[derive(Debug, Clone)]
pub(crate) enum ToNode {
    Packet(u8, Port, u32, Vec<u8>),
    Position(Motor, i32),
    Other(device::Input<'static>),
}

pub(crate) fn to_node() -> impl Strategy<Value = ToNode> {
    let port = prop::sample::select(&[Port::Bus, Port::Usb, Port::Bluetooth][..]);
    let to = prop_oneof![6 => Just(3), 1 => Just(1), 1 => 0_u8..5];
    let command =
        prop::sample::select(&[AtNode::Start, AtNode::Pause, AtNode::Stop, AtNode::EmergencyStop, AtNode::PowerUp][..]);
    let contact = prop::sample::select(&[Contact::Ring, Contact::Tip][..]);
    let other = prop_oneof![
        command.prop_map(device::Input::Command),
        contact.prop_map(device::Input::Alt),
        any_motor().prop_map(device::Input::Arrived),
        any_motor().prop_map(device::Input::Fault),
        Just(device::Input::CommonLine),
        Just(device::Input::Noise),
        Just(device::Input::Wake),
    ];
    prop_oneof![
        6 => (to, port, any_number(), any_body()).prop_map(|(to, port, number, body)| {
            // A decoder gives broadcasts, and only them, numbers of their own table.
            let number = if to == 1 { number & 0xFFFF | 0x1_00_00 } else if number >> 16 == 1 { number & 0xFFFF } else { number };
            ToNode::Packet(to, port, number, body)
        }),
        1 => (any_motor(), any::<i32>()).prop_map(|(motor, steps)| ToNode::Position(motor, steps)),
        1 => (any_motor(), -300..300).prop_map(|(motor, steps)| ToNode::Position(motor, steps)),
        3 => other.prop_map(ToNode::Other),
    ]
}

/// Settings of a program of any kind, and of the motors that it needs.
fn any_setup() -> impl Strategy<Value = Vec<(u32, Vec<u8>)>> {
    let part = |number: u32, value: std::ops::Range<u8>, bytes: usize| {
        value.prop_map(move |value| (number, [vec![0; bytes - 1], vec![value]].concat())).boxed()
    };
    vec![
        part(0x16_00, 0..4, 1),
        part(0x18_00, 0..2, 1),
        part(0x15_00, 0..2, 4),
        part(0x14_00, 0..2, 4),
        part(0x11_01, 0..3, 4),
        part(0x14_01, 0..4, 4),
        part(0x11_02, 0..200, 4),
        part(0x14_02, 0..40, 4),
        part(0x02_04, 0..2, 1),
        part(0x06_04, 0..4, 2),
        part(0x0A_04, 0..200, 4),
        part(0x0D_00, 0..11, 2),
        part(0x0E_00, 0..2, 1),
        part(0x02_00, 0..1, 1),
    ]
}

pub(crate) fn profiles() -> impl Strategy<Value = Profile> {
    prop_oneof![
        1 => Just(Profile::UNKNOWN),
        1 => Just(Profile::JANUARY_2015),
        9 => prop::sample::select(Profile::builds().collect::<Vec<_>>()),
    ]
}

fn moving(machine: &DeviceMachine) -> Vec<Motor> {
    Motor::ALL.into_iter().filter(|motor| machine.motor(*motor).is_moving()).collect()
}

/// Motors that a message stops.
fn stopped_by(message: &HostMessage<'_>) -> &'static [Motor] {
    match message {
        HostMessage::Stop(_)
        | HostMessage::Pause(_)
        | HostMessage::BroadcastStop(_)
        | HostMessage::BroadcastPause(_) => &Motor::ALL,
        HostMessage::MotorStop(stop) => match stop.motor {
            Motor::One => &[Motor::One],
            Motor::Two => &[Motor::Two],
            Motor::Three => &[Motor::Three],
        },
        _ => &[],
    }
}

proptest! {
    #[test]
    fn a_node_obeys_stops_and_its_dead_man(
        profile in profiles(),
        firmware in any::<bool>(),
        setup in any_setup(),
        steps in proptest::collection::vec((0_u64..700, to_node()), 1..120),
    ) {
        let quirks = if firmware { Quirks::FIRMWARE } else { Quirks::NONE };
        let mut node = Node::ready_with(NodeOptions::default().with_profile(profile).with_quirks(quirks));
        for (number, body) in setup {
            let _ = node.send(NODE, decode(number, &body));
        }
        let mut heard = node.now;
        for (pause, input) in steps {
            // Mostly the node is woken when it asks for it.
            if pause % 7 != 0 {
                let wakes = node.pass(pause);
                prop_assert!(wakes.len() <= 3000, "no busy loops: {wakes:?}");
            } else {
                node.now += pause;
            }
            let before = node.machine.clone();
            let output = match &input {
                ToNode::Packet(to, port, number, body) => {
                    let message = decode(*number, body);
                    let Selector { table, command, .. } = message.selector();
                    let is_own = *to == before.address(*port).0;
                    if is_own && table == Table::Node && command >= 2 {
                        heard = node.now;
                    }
                    let was = moving(&before);
                    let joystick = before.controller().joystick_mode;
                    let output = node.step(device::Input::Received { port: *port, to: Address(*to), message });
                    let is_stop = (is_own && table != Table::Broadcast || *to == 1)
                        && matches!(message, HostMessage::MotorStop(_) | HostMessage::Stop(_))
                        || *to == 1 && message.conduct().is_stop();
                    let is_refused = joystick && firmware && matches!(message, HostMessage::Stop(_));
                    if is_stop && !is_refused && (table == Table::Broadcast) == (*to == 1) {
                        for motor in stopped_by(&message) {
                            prop_assert!(!node.machine.motor(*motor).is_moving(), "{message:?}: {output:?}");
                            let stop = NodeEvent::Motor { motor: *motor, motion: Motion::Stop };
                            prop_assert_eq!(output.event_list().contains(&stop), was.contains(motor), "{:?}", output);
                        }
                    }
                    output
                }
                ToNode::Position(motor, steps) => {
                    node.step(device::Input::Position { motor: *motor, position: Steps(*steps) })
                }
                ToNode::Other(input) => node.step(*input),
            };
            if let ToNode::Other(device::Input::Command(AtNode::Stop | AtNode::Pause | AtNode::EmergencyStop)) = input {
                prop_assert_eq!(moving(&node.machine), []);
            }
            // The dead-man stops motors when the master is silent.
            if node.machine.controller().manual_move && node.now - heard > 1000 {
                prop_assert_eq!(moving(&node.machine), [], "{:?}", output);
            }
            // The state of a motor is that of the last event about it.
            for motor in Motor::ALL {
                let last = output.event_list().iter().rev().find_map(|event| match event {
                    NodeEvent::Motor { motor: of, motion } if *of == motor => match motion {
                        Motion::Stop => Some(false),
                        Motion::By { .. } | Motion::To(_) | Motion::Run { .. } | Motion::Along { .. } => Some(true),
                        _ => None,
                    },
                    _ => None,
                });
                if let Some(moves) = last {
                    prop_assert_eq!(node.machine.motor(motor).is_moving(), moves, "{:?}", output);
                }
            }
            // A program that runs waits for a time, a motor, or a pulse.
            let controller = node.machine.controller();
            let RingTip { ring, tip } = controller.alt_modes;
            let by_pulse = [ring, tip].contains(&AltMode::EXTERNAL_INTERVALOMETER) || !controller.timing_master;
            // Some firmware never goes on after a pause.
            let is_stuck = firmware && profile.resumes_moves() != Some(true);
            let waits = node.wake.is_some() || by_pulse || is_stuck || !moving(&node.machine).is_empty();
            let runs = node.machine.program().state() == ProgramState::Running;
            prop_assert!(waits || !runs, "{:?} after {:?}", node.machine, output);
            // A wake that comes too early, or twice, changes nothing.
            let mut early = node.clone();
            prop_assert!(early.step(device::Input::Wake).is_quiet());
            let (machine, wake) = (early.machine.clone(), early.wake);
            prop_assert!(early.step(device::Input::Wake).is_quiet());
            prop_assert_eq!((&early.machine, early.wake), (&machine, wake));
        }
    }
}

/// Input of a master.
#[derive(Debug, Clone)]
pub(crate) enum ToMaster {
    Ask(u8, u32, Vec<u8>),
    Move(Motor),
    Stop(u8, u8),
    Reply(u8, Vec<u8>),
    Stray(u32),
    Command(Command),
    Other(Input<'static>),
}

fn any_command() -> impl Strategy<Value = Command> {
    let to = (0_u8..6).prop_map(Address);
    prop_oneof![
        6 => (to.clone(), any_motor(), -9.0_f32..9.0).prop_map(|(to, motor, speed)| {
            Command::Speed { to, motor, speed: StepsPerSecond(speed.trunc()) }
        }),
        2 => (to, any::<bool>()).prop_map(|(to, on)| Command::KeepAlive { to, on }),
        1 => Just(Command::EmergencyStop),
        2 => Just(Command::EndEmergency),
    ]
}

pub(crate) fn to_master() -> impl Strategy<Value = ToMaster> {
    let to = prop_oneof![6 => 2_u8..5, 1 => 0_u8..3];
    let data = prop_oneof![
        Just(vec![]),
        (0_u8..2).prop_map(|byte| vec![0, byte]),
        proptest::collection::vec(any::<u8>(), 0..40),
    ];
    prop_oneof![
        4 => (to.clone(), any_number(), any_body()).prop_map(|(to, number, body)| ToMaster::Ask(to, number, body)),
        3 => any_motor().prop_map(ToMaster::Move),
        2 => (to, 0_u8..6).prop_map(|(to, which)| ToMaster::Stop(to, which)),
        8 => (prop_oneof![6 => Just(1_u8), 1 => any::<u8>()], data).prop_map(|(code, data)| ToMaster::Reply(code, data)),
        1 => (0x1_00_00_u32..0xFF_FF_FF).prop_map(ToMaster::Stray),
        3 => any_command().prop_map(ToMaster::Command),
        1 => prop::sample::select(&[Input::LinkUp, Input::LinkDown, Input::LinkUp, Input::Noise, Input::Wake][..])
            .prop_map(ToMaster::Other),
    ]
}

/// Stop of a kind, and its receiver.
pub(crate) fn stop(to: u8, which: u8) -> (Address, HostMessage<'static>) {
    match which {
        0 => (Address(to), STOP),
        1 => (Address(to), PAUSE),
        2 => (Address::BROADCAST, message::BroadcastStop::default().into()),
        motor => (Address(to), motor_stop(Motor::new(motor - 2).unwrap())),
    }
}

/// Time in which nodes may be deaf, because of a packet or because the line came up.
#[derive(Debug)]
struct Block {
    /// Address of the node; [`Address::BROADCAST`] for all nodes.
    to: Address,
    until: u64,
    /// Whether it is only not known what the nodes did before the line came up.
    is_unknown: bool,
    /// New address of the node.
    new_address: Option<Address>,
    /// Receivers of the packets since then that are not answered, and times of these packets.
    sent: Vec<(Address, u64)>,
    /// Nodes that have answered since then.
    heard: Vec<Address>,
}

fn reaches(packet: Address, node: Address) -> bool {
    packet == node || packet == Address::BROADCAST || node == Address::BROADCAST
}

/// Whether a stop stops what a message moves, at the same node.
fn concerns(stop: &HostMessage<'_>, message: &HostMessage<'_>) -> bool {
    let [stops, moves] = [stop, message].map(|message| message.selector().sub_address);
    stops == 0 || moves == 0 || stops == moves
}

impl Block {
    /// Number of packets that may wait at a node.
    fn waiting(&self, now: u64, node: Address) -> usize {
        let is_one = self.new_address.is_some();
        self.sent.iter().filter(|(to, at)| now < at + 3000 && (is_one || reaches(*to, node))).count()
    }

    fn concerns(&self, to: Address) -> bool {
        let is_its = reaches(self.to, to) || self.new_address.is_some_and(|address| reaches(address, to));
        is_its && !self.heard.contains(&to)
    }

    /// A node has answered.
    fn hears(&mut self, node: Address) {
        let is_one = [Some(self.to), self.new_address].contains(&Some(node)) && self.to != Address::BROADCAST;
        self.heard.extend(
            [Some(node), self.new_address.filter(|_| is_one), Some(self.to).filter(|_| is_one)].into_iter().flatten(),
        );
        self.sent.retain(|(to, _)| !self.heard.contains(to));
    }

    /// Block that begins with a packet.
    fn of(to: Address, message: &HostMessage<'_>, now: u64) -> Option<Self> {
        let Selector { table, command, .. } = message.selector();
        let new_address = match message {
            HostMessage::SetAddress(set) => Some(set.new_address),
            HostMessage::CoreAssignAddress(assign) => Some(assign.new_address),
            HostMessage::BroadcastAssignAddress(assign) => Some(assign.new_address),
            _ => None,
        };
        let starts = matches!(message, HostMessage::Start(_) | HostMessage::BroadcastStart(_));
        let may_be_any = matches!(message, HostMessage::Other(_))
            && (table == Table::Broadcast || table == Table::Node && command < 100);
        (new_address.is_some() || starts || may_be_any).then(|| Self {
            to,
            until: now + 3000,
            is_unknown: false,
            new_address,
            sent: Vec::new(),
            heard: Vec::new(),
        })
    }
}

/// Promises of a master, watched from outside.
#[derive(Debug, Default)]
struct Watch {
    blocks: Vec<Block>,
    /// Time at which the last block ends, also if its node has answered: the master keeps one time for all nodes.
    until: u64,
    /// Times at which stops were sent last, except those after which something went out that moves what they stop.
    stops: Vec<(Address, HostMessage<'static>, u64)>,
    tokens: Tokens,
    /// For each message that may not be repeated: how often it was asked for, minus how often it was sent.
    budget: BTreeMap<String, i64>,
    last: Option<u64>,
    /// Packet that was sent last.
    out: Option<(Address, HostMessage<'static>)>,
    /// Latest time for a stop to be sent. Nothing may be sent before it.
    stop_due: Option<u64>,
}

impl Watch {
    fn asked(&mut self, message: &HostMessage<'_>) {
        *self.budget.entry(message.to_string()).or_default() += 1;
    }

    /// Forgets all blocks when the last one is over, or when no node may be deaf.
    fn expire(&mut self, now: u64) {
        if self.blocks.is_empty() || now >= self.until {
            (self.blocks, self.until) = (Vec::new(), 0);
        }
    }

    fn begins(&mut self, block: Option<Block>) {
        self.until = block.as_ref().map_or(0, |block| block.until).max(self.until);
        self.blocks.extend(block);
    }

    /// The line came up.
    fn link_up(&mut self, now: u64) {
        self.expire(now);
        // What waits since before the line went down may still wait.
        let (sent, heard) = (self.blocks.iter().flat_map(|block| block.sent.clone()).collect(), Vec::new());
        let to = Address::BROADCAST;
        self.begins(Some(Block { to, until: now + 3000, is_unknown: true, new_address: None, sent, heard }));
    }

    /// The packet that was sent last is answered, and the answer can only be that to this packet.
    fn answered(&mut self, now: u64) {
        let Some((node, message)) = self.out else { return };
        self.blocks.iter_mut().for_each(|block| block.hears(node));
        self.blocks.retain(|block| block.to == Address::BROADCAST || !block.heard.contains(&block.to));
        // A node may take its new address after the answer.
        self.expire(now);
        self.begins(Block::of(node, &message, now).filter(|block| block.new_address.is_some()));
    }

    /// Whether an answer without a value may be that to a start of somebody else from before the line came up: the listed node,
    /// or the receiver of the last packet, has not answered since.
    fn may_be_foreign(&self, now: u64) -> bool {
        let receiver = self.out.map_or(NODE, |(to, _)| to);
        let is_silent = |block: &Block| [NODE, receiver].iter().any(|node| !block.heard.contains(node));
        self.blocks.iter().any(|block| block.is_unknown && now < block.until && is_silent(block))
    }

    /// Whether a stop to a node, or to all, has to be sent when the gap is over.
    fn is_due(&self, bridge: bool, to: Address, stop: Option<&HostMessage<'_>>, now: u64) -> bool {
        // Through a bridge, the node is stopped instead of all nodes.
        let (to, stop) = match stop {
            Some(HostMessage::BroadcastPause(_)) if bridge => (NODE, Some(&PAUSE)),
            Some(HostMessage::BroadcastStop(_)) if bridge => (NODE, Some(&STOP)),
            stop => (to, stop),
        };
        let is_over = self.blocks.is_empty() || now > self.until;
        let is_pause = matches!(stop, Some(HostMessage::BroadcastPause(_)));
        // The next packet goes out when it is known that the one before does not wait any more, a moment after.
        let waits = self.blocks.iter().any(|block| block.concerns(to) && (is_pause || block.waiting(now - 1, to) > 0));
        let is_recent = |stop: &HostMessage<'_>| {
            self.stops.iter().any(|(of, sent, at)| *of == to && sent == stop && now < at + 500)
        };
        (is_over || !waits) && !stop.is_some_and(is_recent)
    }

    /// At most one packet waits at a node that may be deaf: a stop, or after the line came up a query.
    fn sent(&mut self, now: u64, to: Address, message: &HostMessage<'static>) {
        self.expire(now);
        let conduct = message.conduct();
        let begins = Block::of(to, message, now);
        let is_stop = matches!(message, HostMessage::Stop(_) | HostMessage::BroadcastStop(_));
        let is_query = message.query().is_some();
        for block in self.blocks.iter_mut().filter(|block| block.concerns(to)) {
            let hears = now >= block.until;
            let may_wait = is_stop || is_query && block.is_unknown;
            assert!(may_wait || hears, "{message} to {to} at a node that may be deaf: {block:?}");
            assert!(block.waiting(now, to) == 0 || hears, "{message} to {to} is a second packet: {block:?}");
            block.sent.push((to, now));
        }
        self.begins(begins);
        self.out = Some((to, *message));
        if conduct.is_stop() {
            self.stops.retain(|(of, stop, _)| (of, stop) != (&to, message));
            self.stops.push((to, *message, now));
        }
        if conduct.may_move() {
            self.stops.retain(|(of, stop, _)| !reaches(*of, to) || !concerns(stop, message));
        }
    }

    fn see(&mut self, master: &Master, output: &Output<'static>, options: &Options) {
        for (token, _) in ended(output) {
            self.tokens.end(Token(token));
        }
        for send in output.transmits() {
            assert!(self.last.is_none_or(|last| master.now >= last + u64::from(options.gap())), "the gap");
            self.last = Some(master.now);
            self.sent(master.now, send.to, &send.message);
            let mut out = [0; 42];
            assert!(send.encode_into(&mut out).is_ok(), "{send:?}");
            if self.stop_due.take().is_some() {
                assert!(send.message.conduct().is_stop(), "nothing goes before a stop: {send:?}");
            }
            let is_stop = send.message.conduct().is_stop();
            if master.machine.stopping() != StopState::Calm {
                let leaves = send.message == joystick(NO);
                assert!(is_stop || send.message.query().is_some() || leaves, "{send:?} in an emergency");
            } else if !is_stop && send.message.query().is_none_or(|_| !send.message.conduct().repeatable) {
                let left = self.budget.entry(send.message.to_string()).or_default();
                *left -= 1;
                assert!(*left >= 0, "{} was sent more often than it was asked for", send.message);
            }
        }
        assert!(self.stop_due.is_none_or(|due| master.now <= due), "a stop waits");
    }
}

proptest! {
    #[test]
    fn a_master_keeps_its_promises(
        bridge in any::<bool>(),
        steps in proptest::collection::vec((0_u64..200, to_master()), 1..150),
    ) {
        let options = Options::default().with_bridge(bridge);
        let mut master = Master::new(options);
        let mut watch = Watch::default();
        for (pause, input) in steps {
            let end = master.now + pause;
            while master.reach_wake(end) {
                let output = master.step(Input::Wake);
                watch.see(&master, &output, &options);
            }
            let is_up = master.machine.state().name() != "Offline";
            let now = master.now;
            let mut is_stop = false;
            let output = match input {
                ToMaster::Ask(to, number, body) => {
                    let body: &'static [u8] = body.leak();
                    let message = decode(number, body);
                    is_stop = message.conduct().is_stop() && (number >> 16 == 1) == (to == 1) && to > 0;
                    is_stop = is_stop && watch.is_due(bridge, Address(to), Some(&message), now);
                    watch.asked(&message);
                    master.request_to(watch.tokens.begin().0, Address(to), message)
                }
                ToMaster::Move(motor) => {
                    // Each move has other steps, so that a repeated one would show.
                    let Token(token) = watch.tokens.begin();
                    let message = move_by(motor, token + 1);
                    watch.asked(&message);
                    master.request(token, message)
                }
                ToMaster::Stop(to, which) => {
                    let (to, message) = stop(to.max(2), which);
                    is_stop = watch.is_due(bridge, to, Some(&message), now);
                    master.request_to(watch.tokens.begin().0, to, message)
                }
                ToMaster::Reply(code, data) => {
                    let is_foreign = data.is_empty() && watch.may_be_foreign(now);
                    let output = master.reply(code, data.leak());
                    let is_done = |outcome: &Outcome<'_>| {
                        matches!(outcome, Outcome::Done(_) | Outcome::Refused(Refusal::Device(_)))
                    };
                    let is_believed = ended(&output).iter().any(|(_, outcome)| is_done(outcome));
                    prop_assert!(!is_foreign || !is_believed, "it may be that to a start of somebody else: {:?}", output);
                    if !output.events().any(|event| matches!(event, Event::Unsolicited(_))) {
                        watch.answered(now);
                    }
                    output
                }
                ToMaster::Stray(number) => master.step(Input::Received(DeviceMessage::other(number, &[]))),
                ToMaster::Command(command) => {
                    if let Command::Speed { motor, speed, .. } = command {
                        let set = message::MotorSetContinuousSpeed { motor, speed };
                        watch.asked(&set.into());
                    }
                    let is_calm = master.machine.stopping() == StopState::Calm;
                    is_stop = command == Command::EmergencyStop && is_calm && watch.is_due(bridge, NODE, None, now);
                    is_stop = is_stop && (bridge || watch.is_due(bridge, Address::BROADCAST, None, now));
                    if command == Command::EndEmergency && !is_calm {
                        // The application may end the emergency before its first packet.
                        watch.stop_due = None;
                    }
                    master.command(watch.tokens.begin(), command)
                }
                ToMaster::Other(input) => {
                    if input == Input::LinkDown {
                        (watch.stop_due, watch.last) = (None, None);
                    }
                    if input == Input::LinkUp && !is_up {
                        watch.link_up(now);
                    }
                    master.step(input)
                }
            };
            if is_up && is_stop {
                watch.stop_due = Some(master.now + u64::from(options.gap()));
            }
            watch.see(&master, &output, &options);
            let mut early = master.clone();
            prop_assert!(early.step(Input::Wake).is_quiet());
            prop_assert_eq!(&early.machine, &master.machine);
        }
        // All commands end, answered or not.
        let last = [master.command(watch.tokens.begin(), Command::EndEmergency), master.step(Input::LinkUp)];
        for output in last.into_iter().chain(master.pass(60_000).into_iter().map(|(_, output)| output)) {
            for (token, _) in ended(&output) {
                watch.tokens.end(Token(token));
            }
        }
        prop_assert_eq!(watch.tokens.open().count(), 0, "{:?}", watch);
        prop_assert_eq!(master.machine.pending(), 0);
    }
}

/// A master, a node with a simple rig, and the line between them.
struct World {
    /// Replies are their code and their data.
    both: laws::world::World<HostMachine, DeviceMachine, HostMessage<'static>, (u8, Vec<u8>)>,
    /// Whether a bridge loses replies that refuse.
    bridge: bool,
    is_up: bool,
    /// Fates of packets and times until they arrive, one after another and then again from the first.
    faults: Vec<(Fate, u64)>,
    at: usize,
    /// Times at which motors arrive.
    arrivals: [Option<Millis>; 3],
    turning: [bool; 3],
    /// Messages that the node received, in order.
    heard: Vec<HostMessage<'static>>,
    /// Message that the master sent last, and the number of messages that the node had received when the master began to
    /// send it.
    sent: Option<(HostMessage<'static>, usize)>,
    /// Time until which the node hears nothing, because a start blocks it.
    blocked_until: Millis,
    /// Packet that waits at the node. If there were two, it would hang.
    waiting: Option<HostMessage<'static>>,
    tokens: Tokens,
    /// Questions that are asked for the place of a motor.
    places: BTreeMap<Token, Motor>,
    /// Commands that are done.
    done: BTreeSet<Token>,
}

/// Time for which a start blocks the node of the world, in milliseconds.
const START_BLOCKS: u64 = 1500;

/// Place of a motor, which tells the motor.
fn place_of(motor: Motor) -> Steps {
    Steps(100 * i32::from(motor.get()))
}

impl World {
    fn new(faults: Vec<(Fate, u64)>, firmware: bool, bridge: bool) -> Self {
        // The master settles for longer than a packet and its answer are in flight.
        let master = Master::new(Options::new().with_settle(100)).machine.clone();
        // A backlash would change the places, which tell the motors.
        let all = Quirks(Quirks::FIRMWARE.0 & !Quirks::TAKES_UP_BACKLASH.0);
        let quirks = if firmware { all } else { Quirks::NONE };
        let mut node = Node::ready_with(NodeOptions::new().with_quirks(quirks));
        for motor in Motor::ALL {
            let _ = node.step(device::Input::Position { motor, position: place_of(motor) });
        }
        let node = node.machine.clone();
        let mut both = laws::world::World::new(Millis(1000), master, node, Faults::ANY);
        both.up = Line::new(Faults { doubled: 0, ..Faults::ANY });
        Self {
            both,
            bridge,
            is_up: true,
            faults,
            at: 0,
            arrivals: [None; 3],
            turning: [false; 3],
            heard: Vec::new(),
            sent: None,
            blocked_until: Millis(0),
            waiting: None,
            places: BTreeMap::new(),
            tokens: Tokens::default(),
            done: BTreeSet::new(),
        }
    }

    fn fault(&mut self) -> (Fate, u64) {
        self.at += 1;
        self.faults[self.at % self.faults.len()]
    }

    fn master(&mut self, input: Input<'_>) {
        let output = step_master(&mut self.both.host, self.both.now, input);
        for transmit in output.transmits() {
            let (_, delay) = self.fault();
            self.both.up.send(self.both.now.after(delay % 40), transmit.message);
            if self.sent.is_none_or(|(message, _)| message != transmit.message) {
                self.sent = Some((transmit.message, self.heard.len()));
            }
        }
        for event in output.events() {
            match event {
                Event::Ended { token, outcome } => {
                    self.tokens.end(*token);
                    if let (Some(&motor), Outcome::Done(reply)) = (self.places.get(token), outcome) {
                        let place = message::MotorPosition { motor }.decode_reply(*reply).unwrap().value;
                        assert_eq!(place, place_of(motor), "the place of another motor");
                    }
                    self.done.extend(Some(*token).filter(|_| matches!(outcome, Outcome::Done(_))));
                }
                Event::Stopped(StopTarget::All) => {
                    assert_eq!(self.turning, [false; 3], "all motors rest when an emergency stop is confirmed");
                }
                _ => {}
            }
        }
    }

    fn node(&mut self, input: device::Input<'_>) {
        let output = step_node(&mut self.both.device, self.both.now, input);
        for event in output.events() {
            let NodeEvent::Motor { motor, motion } = event else { continue };
            let place = usize::from(motor.get()) - 1;
            let (turns, arrival) = match motion {
                Motion::Stop => (false, None),
                Motion::By { .. } | Motion::To(_) | Motion::Along { .. } => (true, Some(self.both.now.after(300))),
                Motion::Run { .. } => (true, None),
                _ => continue,
            };
            (self.turning[place], self.arrivals[place]) = (turns, arrival);
        }
        for answer in answers(&output) {
            let (_, delay) = self.fault();
            let mut scratch = [0; 32];
            let DeviceMessage::Reply(Reply { code, data }) = answer.message(&mut scratch).unwrap() else { panic!() };
            if self.is_up && !(self.bridge && code == ResponseCode::ERROR) {
                // A start is answered when its block is over.
                let from = self.both.now.max(self.blocked_until);
                self.both.down.send(from.after(delay), (code.0, data.to_vec()));
            }
        }
    }

    /// The node receives a message.
    fn packet(&mut self, message: HostMessage<'static>) {
        self.heard.push(message);
        if message == START {
            self.blocked_until = self.both.now.after(START_BLOCKS);
        }
        let to = if message.selector().table == Table::Broadcast { Address::BROADCAST } else { NODE };
        self.node(device::Input::Received { port: Port::Bus, to, message });
    }

    /// Lets time pass. All that is due happens, one after another.
    fn pass(&mut self, millis: u64) {
        let end = self.both.now.after(millis);
        loop {
            let hears = self.waiting.map(|_| self.blocked_until);
            let own = self.arrivals.into_iter().chain([hears]).flatten().min();
            let Some(next) = self.both.pass(end, own) else { break };
            match next {
                Next::Up => {
                    let (fate, _) = self.fault();
                    match self.both.up.meet(fate) {
                        Some((message, true)) if self.both.now < self.blocked_until => {
                            let before = self.waiting.replace(message);
                            assert_eq!(before, None, "the node hangs, because {message} waits too");
                        }
                        Some((message, true)) => self.packet(message),
                        Some((_, false)) => self.node(device::Input::Noise),
                        None => {}
                    }
                }
                Next::Down => {
                    let (fate, _) = self.fault();
                    match self.both.down.meet(fate) {
                        Some(((code, data), true)) => {
                            self.master(Input::Received(Reply { code: ResponseCode(code), data: &data }.into()));
                        }
                        Some((_, false)) => self.master(Input::Noise),
                        None => {}
                    }
                }
                Next::Own if hears.is_some_and(|hears| hears <= self.both.now) => {
                    if let Some(message) = self.waiting.take() {
                        self.packet(message);
                    }
                }
                Next::Own => {
                    let is_due = |at: &Option<Millis>| at.is_some_and(|at| at <= self.both.now);
                    let place = self.arrivals.iter().position(is_due).unwrap();
                    (self.arrivals[place], self.turning[place]) = (None, false);
                    self.node(device::Input::Arrived(Motor::ALL[place]));
                }
                Next::WakeDevice => self.node(device::Input::Wake),
                Next::WakeHost => self.master(Input::Wake),
            }
        }
    }

    /// Brings the line up or down. A line that goes down loses all packets in flight.
    fn line(&mut self, is_up: bool) {
        if !is_up {
            self.both.cut();
        }
        self.is_up = is_up;
        self.master(if is_up { Input::LinkUp } else { Input::LinkDown });
    }

    fn command(&mut self, command: Command) -> Token {
        let token = self.tokens.begin();
        if let Command::Request(Request { message: HostMessage::MotorPosition(query), .. }) = command {
            self.places.insert(token, query.motor);
        }
        self.master(Input::Command(token, command));
        token
    }
}

/// Wish of an application, or of a person at the node.
#[derive(Debug, Clone, Copy)]
enum Wish {
    Request(HostMessage<'static>),
    Move(Motor),
    Speed(Motor, f32),
    KeepAlive(bool),
    Emergency,
    Button,
    Line(bool),
}

fn any_wish() -> impl Strategy<Value = Wish> {
    let motor = any_motor;
    let common = prop_oneof![
        Just(START),
        Just(STOP),
        Just(PAUSE),
        motor().prop_map(motor_stop),
        motor().prop_map(run),
        motor().prop_map(|motor| HostMessage::from(message::MotorRunning { motor })),
        motor().prop_map(|motor| HostMessage::from(message::MotorPosition { motor })),
        motor().prop_map(|motor| HostMessage::from(message::MotorPosition { motor })),
        Just(HostMessage::from(message::ReturnHome {})),
        Just(HostMessage::from(message::RunStatus {})),
        Just(HostMessage::from(message::SetManualMove { manual_move: YES })),
        Just(joystick(YES)),
        Just(joystick(NO)),
    ];
    prop_oneof![
        8 => common.prop_map(Wish::Request),
        2 => motor().prop_map(Wish::Move),
        3 => (motor(), -3.0_f32..3.0).prop_map(|(motor, speed)| Wish::Speed(motor, speed.trunc() * 100.0)),
        1 => any::<bool>().prop_map(Wish::KeepAlive),
        2 => Just(Wish::Emergency),
        1 => Just(Wish::Button),
        1 => any::<bool>().prop_map(Wish::Line),
    ]
}

/// Script of a test.
#[derive(Debug, Clone)]
struct Script {
    firmware: bool,
    bridge: bool,
    faults: Vec<(Fate, u64)>,
    /// Number of wishes so far.
    wishes: u32,
}

/// Wishes of an application, and the time that passes before each of them.
struct Wishes;

impl ReferenceStateMachine for Wishes {
    type State = Script;
    type Transition = (u64, Wish);

    fn init_state() -> BoxedStrategy<Script> {
        let fate = prop_oneof![
            5 => Just(Fate::Arrives),
            1 => Just(Fate::Lost),
            1 => Just(Fate::Corrupt),
            1 => Just(Fate::Doubled),
        ];
        // An answer may be very late, but it does not overtake another one.
        let delay = prop_oneof![9 => 1_u64..40, 1 => 40_u64..1300];
        (any::<bool>(), any::<bool>(), proptest::collection::vec((fate, delay), 3..80))
            .prop_map(|(firmware, bridge, faults)| Script { firmware, bridge, faults, wishes: 0 })
            .boxed()
    }

    fn transitions(_: &Script) -> BoxedStrategy<(u64, Wish)> {
        (0_u64..900, any_wish()).boxed()
    }

    fn apply(mut script: Script, _: &(u64, Wish)) -> Script {
        script.wishes += 1;
        script
    }
}

/// A request, and the number of messages that the node had received before it.
struct Asked {
    token: Token,
    message: HostMessage<'static>,
    heard: usize,
}

struct BadLine;

impl StateMachineTest for BadLine {
    type SystemUnderTest = (World, Vec<Asked>);
    type Reference = Wishes;

    fn init_test(script: &Script) -> Self::SystemUnderTest {
        (World::new(script.faults.clone(), script.firmware, script.bridge), Vec::new())
    }

    fn apply(
        (mut world, mut asked): Self::SystemUnderTest,
        script: &Script,
        (pause, wish): (u64, Wish),
    ) -> Self::SystemUnderTest {
        world.pass(pause);
        let mut request = |world: &mut World, message| {
            // A stop that waits already is not another one, nor is one whose answer is awaited. The machine may have sent that
            // one by itself; after it nothing has gone out that moves.
            let open: Vec<_> = world.tokens.open().collect();
            let before = asked.iter().find(|asked| asked.message == message && open.contains(&asked.token));
            let before = before.filter(|_| message.conduct().is_stop());
            let out = world.sent.filter(|(sent, _)| *sent == message && message.conduct().is_stop());
            let heard = before.map(|before| before.heard).or(out.map(|(_, heard)| heard)).unwrap_or(world.heard.len());
            let token = world.command(Command::Request(Request { to: NODE, message }));
            asked.push(Asked { token, message, heard });
        };
        match wish {
            Wish::Request(message) => request(&mut world, message),
            // Each move has other steps, so that a repeated one would show.
            Wish::Move(motor) => request(&mut world, move_by(motor, script.wishes)),
            Wish::Speed(motor, speed) => {
                world.command(Command::Speed { to: NODE, motor, speed: StepsPerSecond(speed) });
            }
            Wish::KeepAlive(on) => {
                world.command(Command::KeepAlive { to: NODE, on });
            }
            Wish::Emergency => {
                world.command(Command::EmergencyStop);
            }
            Wish::Button => {
                world.node(device::Input::Command(AtNode::EmergencyStop));
                assert_eq!(world.turning, [false; 3]);
            }
            Wish::Line(is_up) => world.line(is_up),
        }
        (world, asked)
    }

    fn check_invariants((world, _): &Self::SystemUnderTest, _: &Script) {
        // Machine and rig agree on which motors move.
        let node = &world.both.device.machine;
        let turning = Motor::ALL.map(|motor| node.motor(motor).is_moving());
        assert_eq!(turning, world.turning);
        // A program and the way home never move motors at the same time.
        let going = matches!(node.program().state(), ProgramState::Delay | ProgramState::Running);
        assert!(!going || !world.heard.last().is_some_and(|last| matches!(last, HostMessage::ReturnHome(_))));
        // Only the master sets anything in motion here, so it knows that something may move.
        let moves = going || turning.contains(&true);
        let master = &world.both.host.machine;
        assert!(!moves || master.may_move(), "{master:?}");
    }

    fn teardown((mut world, asked): Self::SystemUnderTest, _: Script) {
        // On a good line everything ends.
        world.faults = vec![(Fate::Arrives, 5)];
        world.line(true);
        world.pass(60_000);
        let master = &world.both.host.machine;
        assert_eq!((master.stopping(), master.pending()), (StopState::Calm, 0));
        assert_eq!(world.tokens.open().count(), 0, "each command ends");
        for Asked { token, message, heard } in &asked {
            let times = world.heard[*heard..].iter().filter(|packet| *packet == message).count();
            if message.conduct().is_stop() && world.done.contains(token) {
                assert!(times > 0, "{message:?} was confirmed and never arrived");
            }
            if matches!(message, HostMessage::MotorMove(_)) {
                assert!(times <= 1, "{message:?} arrived {times} times");
            }
        }
        let starts = world.heard.iter().filter(|message| **message == START).count();
        assert!(starts <= asked.iter().filter(|asked| asked.message == START).count());
    }
}

prop_state_machine! {
    #[test]
    fn master_and_node_on_a_bad_line(sequential 1..60 => BadLine);
}

#[test]
fn time_may_stand_still_or_go_backwards() {
    let mut node = Node::ready();
    node.ok(run(Motor::One));
    node.now = 0;
    node.ok(STOP);
    let mut master = Master::new(Options::default());
    let _ = master.request(1, START);
    master.now = 0;
    assert!(master.step(Input::Wake).is_quiet());
    assert!(master.request(2, STOP).is_quiet(), "the gap lasts longer");
    assert_eq!(sent(&master.pass(4060)), [(4060, STOP)]);
    assert_eq!(Millis(0).since(Millis(5)), 0);
}

#[test]
fn a_program_keeps_its_run_time_on_a_clock_that_was_set_back() {
    let mut node = Node::ready();
    let start_delay = message::StartDelay(5000);
    node.ok(HostMessage::from(message::SetStartDelay { start_delay }));
    node.ok(START);
    node.pass(500);
    let young = node.machine.clone().set_back(1300);
    assert_eq!((node.machine.program().run_time(Millis(1500)), young.program().run_time(Millis(200))), (500, 500));
}
