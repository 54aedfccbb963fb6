//! The machines at random depth: each alone with hostile inputs, and both on a line that loses, corrupts, delays and
//! doubles. None of the faults reorders.

use std::collections::{BTreeMap, VecDeque};

use super::world::*;
use hoot_proto::device::{
    self, Command as AtNode, Contact, DeviceMachine, Event as Told, Motion, Options as NodeOptions, Port, ProgramState,
    Quirks,
};
use hoot_proto::frame::Selector;
use hoot_proto::host::{Command, Event, Input, Options, Outcome, Output, Request, StopState, StopTarget, Token};
use hoot_proto::message::{self, AltMode, HostMessage, Motor, Reply, ResponseCode, RingTip, Steps, StepsPerSecond};
use hoot_proto::query::Profile;
use hoot_proto::{Address, DeviceMessage, Millis, Table};
use motion_core::wire::Messages;
use proptest::prelude::*;
use proptest_state_machine::{ReferenceStateMachine, StateMachineTest, prop_state_machine};

/// Numbers of messages, those that exist more often than others.
fn any_number() -> impl Strategy<Value = u32> {
    prop_oneof![
        8 => any::<prop::sample::Index>().prop_map(|at| at.get(HostMessage::ALL).number),
        1 => 0_u32..0x2_FFFF,
    ]
}

/// Bodies, those that make sense more often than others.
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

fn decode(number: u32, body: &[u8]) -> HostMessage<'_> {
    HostMessage::decode_body(number, body).unwrap_or_else(|_| HostMessage::other(number, body))
}

fn any_motor() -> impl Strategy<Value = Motor> {
    prop::sample::select(&Motor::ALL[..])
}

/// What happens to a node.
#[derive(Debug, Clone)]
enum ToNode {
    Packet(u8, Port, u32, Vec<u8>),
    Position(Motor, i32),
    Other(device::Input<'static>),
}

fn to_node() -> impl Strategy<Value = ToNode> {
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
            // What a decoder gives: broadcasts have a table of their own.
            let number = if to == 1 { number & 0xFFFF | 0x1_00_00 } else if number >> 16 == 1 { number & 0xFFFF } else { number };
            ToNode::Packet(to, port, number, body)
        }),
        1 => (any_motor(), any::<i32>()).prop_map(|(motor, steps)| ToNode::Position(motor, steps)),
        1 => (any_motor(), -300..300).prop_map(|(motor, steps)| ToNode::Position(motor, steps)),
        3 => other.prop_map(ToNode::Other),
    ]
}

/// A program of any kind, with what is needed to run it.
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

fn profiles() -> impl Strategy<Value = Profile> {
    prop::sample::select(
        &[
            Profile::Unknown,
            Profile::Library20140925,
            Profile::Sheet,
            Profile::January2015,
            Profile::V035,
            Profile::V070,
        ][..],
    )
}

fn moving(machine: &DeviceMachine) -> Vec<Motor> {
    Motor::ALL.into_iter().filter(|motor| machine.motor(*motor).is_moving()).collect()
}

/// Which motors a message stops.
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
            // Woken when it asks for it, mostly.
            if pause % 7 != 0 {
                let wakes = node.pass(pause);
                prop_assert!(wakes.len() <= 3000, "no busy loops: {wakes:?}");
            } else {
                node.now += pause;
            }
            let before = node.machine.clone();
            let is_deaf = node.clone().step(device::Input::Received {
                port: Port::Bus,
                to: node.machine.address(Port::Bus),
                message: HostMessage::other(0x01_00, &[]),
            }).packets().is_empty();
            let output = match &input {
                ToNode::Packet(to, port, number, body) => {
                    let message = decode(*number, body);
                    let Selector { table, command, .. } = message.selector();
                    let is_own = *to == before.address(*port).0 && !is_deaf;
                    if is_own && table == Table::Node && command >= 2 {
                        heard = node.now;
                    }
                    let was = moving(&before);
                    let joystick = before.controller().joystick_mode;
                    let output = node.step(device::Input::Received { port: *port, to: Address(*to), message });
                    let is_stop = (is_own && table != Table::Broadcast || *to == 1 && !is_deaf)
                        && matches!(message, HostMessage::MotorStop(_) | HostMessage::Stop(_))
                        || *to == 1 && !is_deaf && message.conduct().is_stop();
                    let is_refused = joystick && firmware && matches!(message, HostMessage::Stop(_));
                    if is_stop && !is_refused && (table == Table::Broadcast) == (*to == 1) {
                        for motor in stopped_by(&message) {
                            prop_assert!(!node.machine.motor(*motor).is_moving(), "{message:?}: {output:?}");
                            let stop = Told::Motor { motor: *motor, motion: Motion::Stop };
                            prop_assert_eq!(output.told().contains(&stop), was.contains(motor), "{:?}", output);
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
            // A master that is silent keeps nothing in motion.
            if node.machine.controller().manual_move && node.now - heard > 1000 {
                prop_assert_eq!(moving(&node.machine), [], "{:?}", output);
            }
            // What the machine says of a motor is what the rig was told last.
            for motor in Motor::ALL {
                let last = output.told().iter().rev().find_map(|event| match event {
                    Told::Motor { motor: of, motion } if *of == motor => match motion {
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
            // A program that runs waits for something: a moment, a motor, or a pulse.
            let controller = node.machine.controller();
            let RingTip { ring, tip } = controller.alt_modes;
            let by_pulse = [ring, tip].contains(&AltMode::EXTERNAL_INTERVALOMETER) || !controller.timing_master;
            let waits = node.wake.is_some() || by_pulse || !moving(&node.machine).is_empty();
            let runs = node.machine.program().state() == ProgramState::Running;
            prop_assert!(waits || !runs, "{:?} after {:?}", node.machine, output);
            // A wake that comes too early, or twice, changes nothing.
            let mut early = node.clone();
            prop_assert!(early.step(device::Input::Wake).is_quiet());
            let (machine, wake) = (early.machine.clone(), early.wake);
            prop_assert!(early.step(device::Input::Wake).is_quiet());
            prop_assert_eq!((early.machine, early.wake), (machine, wake));
        }
    }
}

/// What happens to a master.
#[derive(Debug, Clone)]
enum ToMaster {
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

fn to_master() -> impl Strategy<Value = ToMaster> {
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

/// A stop of each kind, with whom it is for.
fn stop(to: u8, which: u8) -> (Address, HostMessage<'static>) {
    let sub_address = message::AnySubAddress(0);
    match which {
        0 => (Address(to), STOP),
        1 => (Address(to), PAUSE),
        2 => (Address::BROADCAST, HostMessage::from(message::BroadcastStop { sub_address })),
        motor => (Address(to), motor_stop(Motor::new(motor - 2).unwrap())),
    }
}

/// What a master promises, whatever happens, watched from outside.
#[derive(Debug, Default)]
struct Watch {
    asked: BTreeMap<u32, Option<Outcome<'static>>>,
    /// How often what may not be repeated was asked for, less how often it was sent.
    budget: BTreeMap<String, i64>,
    last: Option<u64>,
    /// By when a stop has to be out, and nothing before it.
    stop_due: Option<u64>,
}

impl Watch {
    fn token(&mut self) -> Token {
        let token = u32::try_from(self.asked.len()).unwrap();
        self.asked.insert(token, None);
        Token(token)
    }

    fn asked(&mut self, message: &HostMessage<'_>) {
        *self.budget.entry(message.to_string()).or_default() += 1;
    }

    fn see(&mut self, master: &Master, output: &Output<'static>, options: &Options) {
        for (token, outcome) in ended(output) {
            let before = self.asked.get_mut(&token).unwrap().replace(outcome);
            assert_eq!(before, None, "{token} ends once");
        }
        for send in output.transmits() {
            assert!(self.last.is_none_or(|last| master.now >= last + u64::from(options.gap())), "the gap");
            self.last = Some(master.now);
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
            while let Some(wake) = master.wake.filter(|wake| *wake <= end) {
                master.now = wake;
                let output = master.step(Input::Wake);
                watch.see(&master, &output, &options);
            }
            master.now = end;
            let is_up = master.machine.state().name() != "Offline";
            let mut is_stop = false;
            let output = match input {
                ToMaster::Ask(to, number, body) => {
                    let body: &'static [u8] = body.leak();
                    let message = decode(number, body);
                    is_stop = message.conduct().is_stop() && (number >> 16 == 1) == (to == 1) && to > 0;
                    watch.asked(&message);
                    master.request_to(watch.token().0, Address(to), message)
                }
                ToMaster::Move(motor) => {
                    // Each move is another one, so that a second sending of it would show.
                    let Token(token) = watch.token();
                    let message = move_by(motor, token + 1);
                    watch.asked(&message);
                    master.request(token, message)
                }
                ToMaster::Stop(to, which) => {
                    let (to, message) = stop(to.max(2), which);
                    is_stop = true;
                    master.request_to(watch.token().0, to, message)
                }
                ToMaster::Reply(code, data) => master.reply(code, data.leak()),
                ToMaster::Stray(number) => master.step(Input::Received(DeviceMessage::other(number, &[]))),
                ToMaster::Command(command) => {
                    if let Command::Speed { motor, speed, .. } = command {
                        let set = message::MotorSetContinuousSpeed { motor, speed };
                        watch.asked(&set.into());
                    }
                    let is_calm = master.machine.stopping() == StopState::Calm;
                    is_stop = command == Command::EmergencyStop && is_calm;
                    if command == Command::EndEmergency && !is_calm {
                        // Ended before its first packet: as the application wants.
                        watch.stop_due = None;
                    }
                    master.command(watch.token(), command)
                }
                ToMaster::Other(input) => {
                    if input == Input::LinkDown {
                        (watch.stop_due, watch.last) = (None, None);
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
        // All requests end, answered or not, within a time that the queue sets.
        let last = [master.command(watch.token(), Command::EndEmergency), master.step(Input::LinkUp)];
        for output in last.into_iter().chain(master.pass(60_000).into_iter().map(|(_, output)| output)) {
            for (token, outcome) in ended(&output) {
                prop_assert_eq!(watch.asked.get_mut(&token).unwrap().replace(outcome), None);
            }
        }
        prop_assert!(watch.asked.values().all(Option::is_some), "{watch:?}");
        prop_assert_eq!(master.machine.pending(), 0);
    }
}

/// What the line does with a packet.
#[derive(Debug, Clone, Copy)]
enum Fault {
    None,
    Lost,
    Corrupt,
    Doubled,
}

/// Code and data of a reply that is under way; none if it was corrupted.
type Answered = Option<(u8, Vec<u8>)>;

/// A master, a node with a rig, and a line between them.
struct World {
    master: Master,
    node: Node,
    now: u64,
    /// Whether a bridge loses replies that refuse.
    bridge: bool,
    is_up: bool,
    /// Packets under way, with the moment at which they arrive.
    to_node: VecDeque<(u64, HostMessage<'static>)>,
    to_master: VecDeque<(u64, Answered)>,
    faults: Vec<(Fault, u64)>,
    at: usize,
    /// When the motors come to where they go.
    arrivals: [Option<u64>; 3],
    turning: [bool; 3],
    /// Every packet that the node got, in order.
    heard: Vec<HostMessage<'static>>,
    told: Vec<Event<'static>>,
}

impl World {
    fn new(faults: Vec<(Fault, u64)>, firmware: bool, bridge: bool) -> Self {
        // Settled for longer than a packet is under way both ways.
        let master = Master::new(Options::default().with_settle(100));
        let quirks = if firmware { Quirks::FIRMWARE } else { Quirks::NONE };
        let mut node = Node::ready_with(NodeOptions::default().with_quirks(quirks));
        node.now = 1000;
        Self {
            bridge,
            is_up: true,
            master,
            node,
            now: 1000,
            to_node: VecDeque::new(),
            to_master: VecDeque::new(),
            faults,
            at: 0,
            arrivals: [None; 3],
            turning: [false; 3],
            heard: Vec::new(),
            told: Vec::new(),
        }
    }

    fn fault(&mut self) -> (Fault, u64) {
        self.at += 1;
        self.faults[self.at % self.faults.len()]
    }

    fn master_did(&mut self, output: &Output<'static>) {
        for send in output.transmits() {
            let (fault, delay) = self.fault();
            let arrives = self.to_node.back().map_or(0, |(at, _)| *at).max(self.now + delay);
            // A node hears nothing of a packet that is corrupt, and no packet twice.
            if let Fault::None | Fault::Doubled = fault {
                self.to_node.push_back((arrives, send.message));
            }
        }
        // What was confirmed is so, at that very moment.
        if output.told().contains(&Event::Stopped(StopTarget::All)) {
            assert_eq!(self.turning, [false; 3], "the emergency stop was confirmed while something moved");
        }
        self.told.extend(output.told());
    }

    fn node_did(&mut self, output: &device::Output<'_>) {
        for event in output.told() {
            let Told::Motor { motor, motion } = event else { continue };
            let place = usize::from(motor.get()) - 1;
            let (turns, arrival) = match motion {
                Motion::Stop => (false, None),
                Motion::By { .. } | Motion::To(_) | Motion::Along { .. } => (true, Some(self.now + 300)),
                Motion::Run { .. } => (true, None),
                _ => continue,
            };
            (self.turning[place], self.arrivals[place]) = (turns, arrival);
        }
        for answer in answers(output) {
            let (fault, delay) = self.fault();
            let mut scratch = [0; 32];
            let DeviceMessage::Reply(Reply { code, data }) = answer.message(&mut scratch).unwrap() else { panic!() };
            let arrives = self.to_master.back().map_or(0, |(at, _)| *at).max(self.now + delay);
            let packet = Some((code.0, data.to_vec()));
            match fault {
                _ if !self.is_up || self.bridge && code == ResponseCode::ERROR => {}
                Fault::None => self.to_master.push_back((arrives, packet)),
                Fault::Lost => {}
                Fault::Corrupt => self.to_master.push_back((arrives, None)),
                Fault::Doubled => self.to_master.extend([(arrives, packet.clone()), (arrives + 5, packet)]),
            }
        }
    }

    /// Lets time pass, and does all that is due in it, one after another.
    fn pass(&mut self, millis: u64) {
        let end = self.now + millis;
        loop {
            let wakes = [self.master.wake, self.node.wake, self.to_node.front().map(|(at, _)| *at)];
            let others = self.arrivals.into_iter().chain([self.to_master.front().map(|(at, _)| *at)]);
            let next = wakes.into_iter().chain(others).flatten().min();
            let Some(next) = next.filter(|next| *next <= end) else { break };
            self.now = self.now.max(next);
            (self.master.now, self.node.now) = (self.now, self.now);
            if self.to_node.front().is_some_and(|(at, _)| *at <= self.now) {
                let (_, message) = self.to_node.pop_front().unwrap();
                self.heard.push(message);
                let to = if message.selector().table == Table::Broadcast { Address::BROADCAST } else { NODE };
                let output = self.node.send(to, message);
                self.node_did(&output);
            } else if self.to_master.front().is_some_and(|(at, _)| *at <= self.now) {
                let output = match self.to_master.pop_front().unwrap().1 {
                    Some((code, data)) => self.master.reply(code, data.leak()),
                    None => self.master.step(Input::Noise),
                };
                self.master_did(&output);
            } else if let Some(place) = self.arrivals.iter().position(|at| at.is_some_and(|at| at <= self.now)) {
                (self.arrivals[place], self.turning[place]) = (None, false);
                let output = self.node.step(device::Input::Arrived(Motor::ALL[place]));
                self.node_did(&output);
            } else if self.node.wake.is_some_and(|wake| wake <= self.now) {
                let output = self.node.step(device::Input::Wake);
                self.node_did(&output);
            } else {
                let output = self.master.step(Input::Wake);
                self.master_did(&output);
            }
        }
        self.now = end;
        (self.master.now, self.node.now) = (end, end);
    }

    /// The line comes up or goes down, with all that is under way.
    fn line(&mut self, is_up: bool) {
        if !is_up {
            self.to_node.clear();
            self.to_master.clear();
        }
        self.is_up = is_up;
        let output = self.master.step(if is_up { Input::LinkUp } else { Input::LinkDown });
        self.master_did(&output);
    }

    fn command(&mut self, token: Token, command: Command) {
        let output = self.master.command(token, command);
        self.master_did(&output);
    }
}

/// What an application does with a rig.
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

/// A master, a node, the line between them, and what the application asked for so far.
#[derive(Debug, Clone)]
struct Script {
    firmware: bool,
    bridge: bool,
    faults: Vec<(Fault, u64)>,
    /// Messages by their tokens, or how many times a command without a message ends.
    asked: Vec<Result<HostMessage<'static>, usize>>,
}

/// What an application does with a rig, and how long it waits before.
struct Wishes;

impl ReferenceStateMachine for Wishes {
    type State = Script;
    type Transition = (u64, Wish);

    fn init_state() -> BoxedStrategy<Script> {
        let fault = prop_oneof![5 => Just(Fault::None), 1 => Just(Fault::Lost), 1 => Just(Fault::Corrupt), 1 => Just(Fault::Doubled)];
        (any::<bool>(), any::<bool>(), proptest::collection::vec((fault, 1_u64..40), 3..80))
            .prop_map(|(firmware, bridge, faults)| Script { firmware, bridge, faults, asked: Vec::new() })
            .boxed()
    }

    fn transitions(_: &Script) -> BoxedStrategy<(u64, Wish)> {
        (0_u64..900, any_wish()).boxed()
    }

    fn apply(mut script: Script, (_, wish): &(u64, Wish)) -> Script {
        // A move has other steps than any other.
        let steps = u32::try_from(script.asked.len()).unwrap() + 1;
        script.asked.push(match *wish {
            Wish::Request(message) => Ok(message),
            Wish::Move(motor) => Ok(move_by(motor, steps)),
            Wish::Speed(..) | Wish::KeepAlive(_) | Wish::Emergency => Err(1),
            Wish::Button | Wish::Line(_) => Err(0),
        });
        script
    }
}

struct BadLine;

impl StateMachineTest for BadLine {
    /// With how much the node had heard when each wish came.
    type SystemUnderTest = (World, Vec<usize>);
    type Reference = Wishes;

    fn init_test(script: &Script) -> Self::SystemUnderTest {
        (World::new(script.faults.clone(), script.firmware, script.bridge), Vec::new())
    }

    fn apply(
        (mut world, mut heard): Self::SystemUnderTest,
        script: &Script,
        (pause, wish): (u64, Wish),
    ) -> Self::SystemUnderTest {
        world.pass(pause);
        let token = Token(u32::try_from(heard.len()).unwrap());
        heard.push(world.heard.len());
        if let Some(&Ok(message)) = script.asked.last() {
            world.command(token, Command::Request(Request { to: NODE, message }));
        }
        match wish {
            Wish::Request(_) | Wish::Move(_) => {}
            Wish::Speed(motor, speed) => {
                world.command(token, Command::Speed { to: NODE, motor, speed: StepsPerSecond(speed) });
            }
            Wish::KeepAlive(on) => world.command(token, Command::KeepAlive { to: NODE, on }),
            Wish::Emergency => world.command(token, Command::EmergencyStop),
            Wish::Button => {
                let output = world.node.step(device::Input::Command(AtNode::EmergencyStop));
                world.node_did(&output);
                assert_eq!(world.turning, [false; 3]);
            }
            Wish::Line(is_up) => world.line(is_up),
        }
        (world, heard)
    }

    fn check_invariants((world, _): &Self::SystemUnderTest, _: &Script) {
        // The machine and the rig agree on what moves.
        let turning = Motor::ALL.map(|motor| world.node.machine.motor(motor).is_moving());
        assert_eq!(turning, world.turning);
        // Never two movements of several motors: a program and the way home.
        let going = matches!(world.node.machine.program().state(), ProgramState::Delay | ProgramState::Running);
        assert!(!going || !world.heard.last().is_some_and(|last| matches!(last, HostMessage::ReturnHome(_))));
        // Only the master sets anything in motion here, so it never says that nothing can move while something does.
        let moves = going || turning.contains(&true);
        assert!(!moves || world.master.machine.may_move(), "{:?}", world.master.machine);
    }

    fn teardown((mut world, heard): Self::SystemUnderTest, script: Script) {
        // With a good line all comes to an end.
        world.faults = vec![(Fault::None, 5)];
        world.line(true);
        world.pass(60_000);
        assert_eq!(world.master.machine.stopping(), StopState::Calm, "{:?}", world.told);
        assert_eq!(world.master.machine.pending(), 0);
        for ((token, message), heard) in (0..).zip(&script.asked).zip(heard) {
            let ends: Vec<_> = world
                .told
                .iter()
                .filter_map(|event| match event {
                    Event::Ended { token: Token(of), outcome } if *of == token => Some(*outcome),
                    _ => None,
                })
                .collect();
            assert_eq!(ends.len(), message.err().unwrap_or(1), "{message:?}");
            let Ok(message) = message else { continue };
            let times = world.heard[heard..].iter().filter(|packet| *packet == message).count();
            // A stop that is confirmed has arrived.
            if message.conduct().is_stop() && matches!(ends[0], Outcome::Done(_)) {
                assert!(times > 0, "{message:?} was confirmed and never arrived");
            }
            // A move has other steps than any other, so this is all of it.
            if matches!(message, HostMessage::MotorMove(_)) {
                assert!(times <= 1, "{message:?} arrived {times} times");
            }
        }
        let starts = world.heard.iter().filter(|message| **message == START).count();
        assert!(starts <= script.asked.iter().filter(|message| **message == Ok(START)).count());
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
    assert!(master.request(2, STOP).is_quiet(), "what waits for a moment waits longer: the gap");
    assert_eq!(sent(&master.pass(1060)), [(1060, STOP)]);
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
