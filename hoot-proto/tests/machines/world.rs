//! Harness of the tests: a node and a master, each with a clock, and short names for frequent messages.

use std::fmt::Debug;
use std::hash::Hash;
use std::ops::Deref;

use hoot_proto::device::{self, Answer, Contents, DeviceMachine, Event, Ignored, Motion, Port};
use hoot_proto::host::{self, HostMachine, Nodes, Outcome, Request, Token};
use hoot_proto::message::{self, Bool, HostMessage, Value};
use hoot_proto::message::{DeviceMessage, Motor, Reply, ResponseCode, Steps, StepsPerSecond};
use hoot_proto::query::{AnyQuery, IntoReply, Profile};
use hoot_proto::{Address, Machine, Millis, Query};
use laws::world::Watched;
use motion_core::machine::Output;

pub(crate) const NODE: Address = Address::DEFAULT;
pub(crate) const YES: Bool = Bool::TRUE;
pub(crate) const NO: Bool = Bool::FALSE;

/// Time by which clocks are set back, to see that nothing else changes. No test waits for a moment before that.
const EARLIER: u64 = 500;

/// Takes a step of a machine, if the laws hold. On a clock that was set back, the same happens.
fn step<'a, M, T, E, const N: usize>(
    watched: &mut Watched<M>,
    now: Millis,
    set_back: fn(M, u64) -> M,
    input: M::Input<'a>,
) -> Output<T, E, N>
where
    M: Machine<Output<'a> = Output<T, E, N>> + Clone + Eq + Hash + Debug,
    M::Input<'a>: Copy,
    T: Eq + Hash + Debug,
    E: Eq + Hash + Debug,
{
    let earlier = |moment: Millis| Millis(moment.0 - EARLIER);
    let before = watched.machine.clone();
    let output = watched.step(now, input);
    if now.0 >= EARLIER {
        let (other, same) = set_back(before, EARLIER).step(earlier(now), input);
        assert_eq!(other, set_back(watched.machine.clone(), EARLIER), "the same on a clock that was set back");
        assert_eq!((&same.effects, same.wake), (&output.effects, output.wake.map(earlier)));
    }
    output
}

pub(crate) fn step_node<'a>(
    node: &mut Watched<DeviceMachine>,
    now: Millis,
    input: device::Input<'a>,
) -> device::Output<'a> {
    let output = step(node, now, DeviceMachine::set_back, input);
    let is_packet = |effect: &device::Effect<'_>| matches!(effect, device::Effect::Transmit(_));
    let mut rest = output.effects.iter().skip_while(|effect| !is_packet(effect));
    assert!(rest.all(is_packet), "the rig does first what an answer acknowledges: {output:?}");
    output
}

pub(crate) fn step_master<'a>(
    master: &mut Watched<HostMachine>,
    now: Millis,
    input: host::Input<'a>,
) -> host::Output<'a> {
    let output = step(master, now, HostMachine::set_back, input);
    let is_event = |effect: &host::Effect<'_>| matches!(effect, host::Effect::Event(_));
    assert!(output.effects.iter().skip(1).all(is_event), "a stop goes out before anybody is told of it: {output:?}");
    output
}

/// A machine, and the time of its last step.
#[derive(Clone, Debug)]
pub(crate) struct Clocked<M> {
    watched: Watched<M>,
    pub(crate) now: u64,
}

pub(crate) type Node = Clocked<DeviceMachine>;
pub(crate) type Master = Clocked<HostMachine>;

impl<M> Deref for Clocked<M> {
    type Target = Watched<M>;

    fn deref(&self) -> &Watched<M> {
        &self.watched
    }
}

impl<M> Clocked<M> {
    fn at_start(machine: M) -> Self {
        Self { watched: Watched { machine, wake: None }, now: 1000 }
    }

    /// Moves the clock to the next wake, if it is not after `end`.
    pub(crate) fn reach_wake(&mut self, end: u64) -> bool {
        let wake = self.wake.map(|wake| wake.0).filter(|wake| *wake <= end);
        self.now = wake.unwrap_or(end);
        wake.is_some()
    }
}

/// Packets and events of an output.
pub(crate) trait Look {
    type Packet;
    type Event;

    fn packets(&self) -> Vec<Self::Packet>;
    fn event_list(&self) -> Vec<Self::Event>;
    fn is_quiet(&self) -> bool;
}

impl<P: Copy, E: Copy, const N: usize> Look for Output<P, E, N> {
    type Packet = P;
    type Event = E;

    fn packets(&self) -> Vec<P> {
        self.transmits().copied().collect()
    }

    fn event_list(&self) -> Vec<E> {
        self.events().copied().collect()
    }

    fn is_quiet(&self) -> bool {
        self.effects.is_empty()
    }
}

impl Node {
    pub(crate) fn new(options: device::Options) -> Self {
        Self::at_start(DeviceMachine::new(options))
    }

    /// A node whose motors are enabled and have a speed.
    pub(crate) fn ready() -> Self {
        Self::ready_with(device::Options::default())
    }

    pub(crate) fn ready_with(options: device::Options) -> Self {
        let mut node = Self::new(options);
        for motor in Motor::ALL {
            node.ok(HostMessage::from(message::MotorSetEnable { motor, enable: YES }));
            node.ok(speed(motor, 500.0));
            node.ok(HostMessage::from(message::MotorSetSleep { motor, sleep: NO }));
        }
        node
    }

    pub(crate) fn step<'a>(&mut self, input: device::Input<'a>) -> device::Output<'a> {
        step_node(&mut self.watched, Millis(self.now), input)
    }

    /// Events of an input that is no packet.
    pub(crate) fn tell(&mut self, input: device::Input<'static>) -> Vec<Event<'static>> {
        let output = self.step(input);
        assert!(output.packets().is_empty(), "{output:?}");
        output.event_list()
    }

    /// Lets time pass, from wake to wake, and returns all events with their times.
    pub(crate) fn pass(&mut self, millis: u64) -> Vec<(u64, Event<'static>)> {
        let (start, end) = (self.now, self.now + millis);
        let mut all = Vec::new();
        while self.reach_wake(end) {
            let events = self.tell(device::Input::Wake).into_iter();
            all.extend(events.map(|event| (self.now - start, event)));
        }
        all
    }

    pub(crate) fn send<'a>(&mut self, to: Address, message: HostMessage<'a>) -> device::Output<'a> {
        self.step(device::Input::Received { port: Port::Bus, to, message })
    }

    /// Answers to a request, and its events.
    pub(crate) fn request<'a>(&mut self, message: HostMessage<'a>) -> (Vec<Answer>, Vec<Event<'a>>) {
        let output = self.send(NODE, message);
        (answers(&output), output.event_list())
    }

    /// Sends a request that must be done, and returns its events.
    #[track_caller]
    pub(crate) fn ok<'a>(&mut self, message: HostMessage<'a>) -> Vec<Event<'a>> {
        let (answers, events) = self.request(message);
        assert_eq!(answers, [Answer::Ok], "{message:?}");
        events.into_iter().filter(|event| !matches!(event, Event::Set(_))).collect()
    }

    /// Sends a request that must be refused and change nothing.
    #[track_caller]
    pub(crate) fn refused(&mut self, message: HostMessage<'_>) {
        assert_eq!(self.request(message), (vec![Answer::Error], vec![]), "{message:?}");
    }

    /// Bytes of the answer to a query: type and value.
    #[track_caller]
    pub(crate) fn ask(&mut self, message: HostMessage<'_>) -> Vec<u8> {
        let (answers, _) = self.request(message);
        let mut scratch = [0; 32];
        let DeviceMessage::Reply(reply) = answers[0].message(&mut scratch).unwrap() else { panic!("a reply") };
        assert!(reply.is_ok(), "{message:?}");
        reply.data.to_vec()
    }

    pub(crate) fn running(&mut self, motor: Motor) -> bool {
        self.ask(HostMessage::from(message::MotorRunning { motor })).last() == Some(&1)
    }
}

/// Answers of a node in an output.
pub(crate) fn answers(output: &device::Output<'_>) -> Vec<Answer> {
    let of = |packet: &device::Transmit<'_>| {
        if let Contents::Answer(answer) = packet.contents { Some(answer) } else { None }
    };
    output.transmits().filter_map(of).collect()
}

pub(crate) fn ignored(to: Address, message: HostMessage<'_>, why: Ignored) -> Event<'_> {
    Event::Ignored { port: Port::Bus, to, message: message.into(), why }
}

pub(crate) fn speed(motor: Motor, speed: f32) -> HostMessage<'static> {
    message::MotorSetContinuousSpeed { motor, speed: StepsPerSecond(speed) }.into()
}

pub(crate) fn move_by(motor: Motor, steps: u32) -> HostMessage<'static> {
    let (direction, steps) = (message::Direction(1), message::StepCount(steps));
    message::MotorMove { motor, direction, steps }.into()
}

pub(crate) fn run(motor: Motor) -> HostMessage<'static> {
    message::MotorRun { motor, direction: message::Direction(0) }.into()
}

pub(crate) fn joystick(on: Bool) -> HostMessage<'static> {
    message::SetJoystickMode { joystick_mode: on }.into()
}

pub(crate) const START: HostMessage<'static> = HostMessage::Start(message::Start {});
pub(crate) const PAUSE: HostMessage<'static> = HostMessage::Pause(message::Pause {});
pub(crate) const STOP: HostMessage<'static> = HostMessage::Stop(message::Stop {});

pub(crate) fn motor_stop(motor: Motor) -> HostMessage<'static> {
    message::MotorStop { motor }.into()
}

pub(crate) fn motion(motor: Motor, motion: Motion) -> Event<'static> {
    Event::Motor { motor, motion }
}

pub(crate) fn to(motor: Motor, steps: i32) -> Event<'static> {
    motion(motor, Motion::To(Steps(steps)))
}

pub(crate) fn camera(focus: bool, shutter: bool) -> Event<'static> {
    Event::Camera { focus, shutter }
}

/// Token of commands whose end is not tested.
pub(crate) const UNNAMED: Token = Token(9999);

impl Master {
    /// A master with one node, whose line has been up for a while.
    pub(crate) fn new(options: host::Options) -> Self {
        let mut master = Self::offline(options, &[NODE]);
        master.line_up();
        master
    }

    pub(crate) fn offline(options: host::Options, nodes: &[Address]) -> Self {
        let nodes = nodes.iter().fold(Nodes::NONE, |nodes, node| nodes.with(*node).unwrap());
        Self::at_start(HostMachine::new(options.with_nodes(nodes)))
    }

    /// Brings the line up for the first time, and waits until nothing is owed from before. Nothing else happens.
    #[track_caller]
    pub(crate) fn line_up(&mut self) {
        self.line_comes_up();
        assert_eq!(self.pass(3000), []);
    }

    /// Brings the line up for the first time.
    #[track_caller]
    pub(crate) fn line_comes_up(&mut self) {
        let output = self.step(host::Input::LinkUp);
        assert_eq!(output.effects[..], [host::Effect::Event(host::Event::Ready { reconnected: false })]);
    }

    pub(crate) fn step<'a>(&mut self, input: host::Input<'a>) -> host::Output<'a> {
        step_master(&mut self.watched, Millis(self.now), input)
    }

    pub(crate) fn command(&mut self, token: Token, command: host::Command) -> host::Output<'static> {
        self.step(host::Input::Command(token, command))
    }

    /// Gives a command whose end is not tested.
    pub(crate) fn order(&mut self, command: host::Command) -> host::Output<'static> {
        self.command(UNNAMED, command)
    }

    pub(crate) fn request(&mut self, token: u32, message: HostMessage<'static>) -> host::Output<'static> {
        self.request_to(token, NODE, message)
    }

    pub(crate) fn request_to(
        &mut self,
        token: u32,
        to: Address,
        message: HostMessage<'static>,
    ) -> host::Output<'static> {
        self.command(Token(token), host::Command::Request(Request { to, message }))
    }

    pub(crate) fn reply<'a>(&mut self, code: u8, data: &'a [u8]) -> host::Output<'a> {
        self.step(host::Input::Received(Reply { code: ResponseCode(code), data }.into()))
    }

    /// Gives the answer that a node would give, with its motors at rest or not.
    pub(crate) fn answer(&mut self, sent: &host::Transmit, at_rest: bool) -> host::Output<'static> {
        let Some(query) = sent.message.query() else { return self.reply(1, &[]) };
        let data = vec![0; 32].leak();
        let reply = match query {
            AnyQuery::MotorRunning(query) => query.reply(query.answer((!at_rest).into(), Profile::default()), data),
            AnyQuery::JoystickMode(query) => query.reply(query.answer(YES, Profile::default()), data),
            AnyQuery::RunStatus(query) => query.reply(query.answer(message::RunState(0), Profile::default()), data),
            query => panic!("{query:?}"),
        };
        self.reply(1, reply.unwrap().data)
    }

    /// Goes to the next wake, which must come within so many milliseconds.
    #[track_caller]
    pub(crate) fn wait(&mut self, most: u64) -> host::Output<'static> {
        let now = self.now;
        assert!(self.reach_wake(now + most), "{:?} is not within {most} of {now}", self.wake);
        self.step(host::Input::Wake)
    }

    /// Lets time pass, from wake to wake, and returns all outputs with their times, except empty ones.
    pub(crate) fn pass(&mut self, millis: u64) -> Vec<(u64, host::Output<'static>)> {
        let (start, end) = (self.now, self.now + millis);
        let mut all = Vec::new();
        while self.reach_wake(end) {
            let output = self.step(host::Input::Wake);
            if !output.is_quiet() {
                all.push((self.now - start, output));
            }
        }
        all
    }
}

/// Messages that were sent, in order, with their times.
pub(crate) fn sent(outputs: &[(u64, host::Output<'_>)]) -> Vec<(u64, HostMessage<'static>)> {
    outputs.iter().flat_map(|(at, output)| output.transmits().map(|packet| (*at, packet.message))).collect()
}

/// Ends of commands, in order, except those of [`UNNAMED`] ones.
pub(crate) fn ended<'a>(output: &host::Output<'a>) -> Vec<(u32, Outcome<'a>)> {
    let of = |event: &host::Event<'a>| match event {
        host::Event::Ended { token, outcome } if *token != UNNAMED => Some((token.0, *outcome)),
        _ => None,
    };
    output.events().filter_map(of).collect()
}

/// Other events, in order.
pub(crate) fn others<'a>(output: &host::Output<'a>) -> Vec<host::Event<'a>> {
    output.events().filter(|event| !matches!(event, host::Event::Ended { .. })).copied().collect()
}

pub(crate) fn all_ended<'a>(outputs: &[(u64, host::Output<'a>)]) -> Vec<(u64, u32, Outcome<'a>)> {
    outputs
        .iter()
        .flat_map(|(at, output)| ended(output).into_iter().map(move |(token, outcome)| (*at, token, outcome)))
        .collect()
}

/// Value in an answer of a node.
pub(crate) fn value(answer: &Answer) -> Value<'_> {
    let Answer::Value(reply) = answer else { panic!("{answer:?}") };
    reply.value()
}
