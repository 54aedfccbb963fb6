//! What the tests share: a node and a master with a clock each, and short names for what is often said.

use hoot_proto::device::{self, Answer, Contents, DeviceMachine, Event, Ignored, Motion, Port};
use hoot_proto::host::{self, HostMachine, Nodes, Outcome, Request, Token};
use hoot_proto::message::{self, Bool, HostMessage, Value};
use hoot_proto::message::{DeviceMessage, Motor, Reply, ResponseCode, Steps, StepsPerSecond};
use hoot_proto::query::{AnyQuery, IntoReply, Profile};
use hoot_proto::{Address, Millis, Query};
use motion_core::machine::Output;

pub(crate) const NODE: Address = Address::DEFAULT;
pub(crate) const YES: Bool = Bool::TRUE;
pub(crate) const NO: Bool = Bool::FALSE;

/// Time by which clocks are set back, to see that nothing else changes. No test waits for a moment before that.
const EARLIER: u64 = 500;

/// The packets and the events of an output.
pub(crate) trait Look {
    type Packet;
    type Event;

    fn packets(&self) -> Vec<Self::Packet>;
    fn told(&self) -> Vec<Self::Event>;
    fn is_quiet(&self) -> bool;
}

impl<P: Copy, E: Copy, const N: usize> Look for Output<P, E, N> {
    type Packet = P;
    type Event = E;

    fn packets(&self) -> Vec<P> {
        self.transmits().copied().collect()
    }

    fn told(&self) -> Vec<E> {
        self.events().copied().collect()
    }

    fn is_quiet(&self) -> bool {
        self.effects.is_empty()
    }
}

/// A node, at a moment.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) machine: DeviceMachine,
    pub(crate) now: u64,
    pub(crate) wake: Option<u64>,
}

impl Node {
    pub(crate) fn new(options: device::Options) -> Self {
        Self { machine: DeviceMachine::new(options), now: 1000, wake: None }
    }

    /// With motors that are enabled and have a speed.
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
        let (machine, output) = laws::machine::step(self.machine.clone(), Millis(self.now), input);
        if self.now >= EARLIER {
            let (other, same) = self.machine.clone().set_back(EARLIER).step(Millis(self.now - EARLIER), input);
            assert_eq!(other, machine.clone().set_back(EARLIER), "the same on a clock that was set back");
            assert_eq!(same.effects, output.effects);
            assert_eq!(same.wake, output.wake.map(|wake| Millis(wake.0 - EARLIER)));
        }
        let first_packet = output.effects.iter().position(|effect| matches!(effect, device::Effect::Transmit(_)));
        let is_packet = |effect: &device::Effect<'_>| matches!(effect, device::Effect::Transmit(_));
        let rest = first_packet.map_or(&[][..], |at| &output.effects[at..]);
        assert!(rest.iter().all(is_packet), "the rig does first what an answer acknowledges: {output:?}");
        self.machine = machine;
        self.wake = output.wake.map(|wake| wake.0);
        output
    }

    /// The events of an input that is no packet.
    pub(crate) fn tell(&mut self, input: device::Input<'static>) -> Vec<Event<'static>> {
        let output = self.step(input);
        assert!(output.packets().is_empty(), "{output:?}");
        output.told()
    }

    /// Lets time pass, wake by wake, and gives all events with their moments.
    pub(crate) fn pass(&mut self, millis: u64) -> Vec<(u64, Event<'static>)> {
        let (start, end) = (self.now, self.now + millis);
        let mut all = Vec::new();
        while let Some(wake) = self.wake.filter(|wake| *wake <= end) {
            assert!(wake > self.now, "no busy loops");
            self.now = wake;
            all.extend(self.tell(device::Input::Wake).into_iter().map(|event| (self.now - start, event)));
        }
        self.now = end;
        all
    }

    pub(crate) fn send<'a>(&mut self, to: Address, message: HostMessage<'a>) -> device::Output<'a> {
        self.step(device::Input::Received { port: Port::Bus, to, message })
    }

    /// The answers to a request, and the events of it.
    pub(crate) fn request<'a>(&mut self, message: HostMessage<'a>) -> (Vec<Answer>, Vec<Event<'a>>) {
        let output = self.send(NODE, message);
        (answers(&output), output.told())
    }

    /// A request that is done. What happens?
    #[track_caller]
    pub(crate) fn ok<'a>(&mut self, message: HostMessage<'a>) -> Vec<Event<'a>> {
        let (answers, events) = self.request(message);
        assert_eq!(answers, [Answer::Ok], "{message:?}");
        events.into_iter().filter(|event| !matches!(event, Event::Set(_))).collect()
    }

    /// A request that is refused, and changes nothing.
    #[track_caller]
    pub(crate) fn refused(&mut self, message: HostMessage<'_>) {
        assert_eq!(self.request(message), (vec![Answer::Error], vec![]), "{message:?}");
    }

    /// The bytes of the answer to a query: type and value.
    #[track_caller]
    pub(crate) fn ask(&mut self, message: HostMessage<'_>) -> Vec<u8> {
        let (answers, _) = self.request(message);
        let mut scratch = [0; 32];
        let DeviceMessage::Reply(reply) = answers[0].message(&mut scratch).unwrap() else { panic!("a reply") };
        assert!(reply.is_ok(), "{message:?}");
        reply.data.to_vec()
    }

    pub(crate) fn running(&mut self, motor: Motor) -> bool {
        self.ask(HostMessage::from(message::MotorRunning { motor })) == [0, 1]
    }
}

/// What a node answers in an output.
pub(crate) fn answers(output: &device::Output<'_>) -> Vec<Answer> {
    let of = |packet: &device::Transmit<'_>| {
        if let Contents::Answer(answer) = packet.contents { Some(answer) } else { None }
    };
    output.transmits().filter_map(of).collect()
}

pub(crate) fn ignored(to: Address, message: HostMessage<'_>, why: Ignored) -> Event<'_> {
    Event::Ignored { port: Port::Bus, to, message, why }
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

/// Token of commands whose end no test looks at.
pub(crate) const UNNAMED: Token = Token(9999);

/// A master, at a moment.
#[derive(Clone, Debug)]
pub(crate) struct Master {
    pub(crate) machine: HostMachine,
    pub(crate) now: u64,
    pub(crate) wake: Option<u64>,
}

impl Master {
    /// With one node, and its line up.
    pub(crate) fn new(options: host::Options) -> Self {
        let mut master = Self::offline(options, &[NODE]);
        master.line_up();
        master
    }

    pub(crate) fn offline(options: host::Options, nodes: &[Address]) -> Self {
        let nodes = nodes.iter().fold(Nodes::NONE, |nodes, node| nodes.with(*node).unwrap());
        Self { machine: HostMachine::new(options.with_nodes(nodes)), now: 1000, wake: None }
    }

    /// The line comes up for the first time, and nothing else happens.
    #[track_caller]
    pub(crate) fn line_up(&mut self) {
        let output = self.step(host::Input::LinkUp);
        assert_eq!(output.effects[..], [host::Effect::Event(host::Event::Ready { reconnected: false })]);
    }

    pub(crate) fn step<'a>(&mut self, input: host::Input<'a>) -> host::Output<'a> {
        let (machine, output) = laws::machine::step(self.machine.clone(), Millis(self.now), input);
        if self.now >= EARLIER {
            let (other, same) = self.machine.clone().set_back(EARLIER).step(Millis(self.now - EARLIER), input);
            assert_eq!(other, machine.clone().set_back(EARLIER), "the same on a clock that was set back");
            assert_eq!(same.effects, output.effects);
            assert_eq!(same.wake, output.wake.map(|wake| Millis(wake.0 - EARLIER)));
        }
        let events = output.effects.iter().skip(1);
        let is_event = |effect: &host::Effect<'_>| matches!(effect, host::Effect::Event(_));
        assert!(events.clone().all(is_event), "a stop goes out before anybody is told of it: {output:?}");
        self.machine = machine;
        self.wake = output.wake.map(|wake| wake.0);
        output
    }

    pub(crate) fn command(&mut self, token: Token, command: host::Command) -> host::Output<'static> {
        self.step(host::Input::Command(token, command))
    }

    /// A command whose end no test looks at.
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

    /// The answer that a node with motors at rest would give.
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

    /// Goes to the next wake, which is at most so far away.
    #[track_caller]
    pub(crate) fn wait(&mut self, most: u64) -> host::Output<'static> {
        let wake = self.wake.expect("it waits for something");
        assert!(wake > self.now && wake <= self.now + most, "{wake} is not within {most} of {}", self.now);
        self.now = wake;
        self.step(host::Input::Wake)
    }

    /// Lets time pass, wake by wake, and gives all outputs with their moments.
    pub(crate) fn pass(&mut self, millis: u64) -> Vec<(u64, host::Output<'static>)> {
        let (start, end) = (self.now, self.now + millis);
        let mut all = Vec::new();
        while let Some(wake) = self.wake.filter(|wake| *wake <= end) {
            assert!(wake > self.now, "no busy loops");
            self.now = wake;
            let output = self.step(host::Input::Wake);
            if !output.is_quiet() {
                all.push((self.now - start, output));
            }
        }
        self.now = end;
        all
    }
}

/// What was sent, in order.
pub(crate) fn sent(outputs: &[(u64, host::Output<'_>)]) -> Vec<(u64, HostMessage<'static>)> {
    outputs.iter().flat_map(|(at, output)| output.transmits().map(|packet| (*at, packet.message))).collect()
}

/// How commands ended, in order, except those without a name.
pub(crate) fn ended<'a>(output: &host::Output<'a>) -> Vec<(u32, Outcome<'a>)> {
    let of = |event: &host::Event<'a>| match event {
        host::Event::Ended { token, outcome } if *token != UNNAMED => Some((token.0, *outcome)),
        _ => None,
    };
    output.events().filter_map(of).collect()
}

/// What else was told, in order.
pub(crate) fn others<'a>(output: &host::Output<'a>) -> Vec<host::Event<'a>> {
    output.events().filter(|event| !matches!(event, host::Event::Ended { .. })).copied().collect()
}

pub(crate) fn all_ended<'a>(outputs: &[(u64, host::Output<'a>)]) -> Vec<(u64, u32, Outcome<'a>)> {
    outputs
        .iter()
        .flat_map(|(at, output)| ended(output).into_iter().map(move |(token, outcome)| (*at, token, outcome)))
        .collect()
}

/// The value in an answer of a node.
pub(crate) fn value(answer: &Answer) -> Value<'_> {
    let Answer::Value(reply) = answer else { panic!("{answer:?}") };
    reply.value()
}
