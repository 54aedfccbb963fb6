//! What the tests share: a node and a master with a clock each, and short names for what is often said.

use hoot_proto::device::{self, Answer, DeviceMachine, Event, Motion, Port};
use hoot_proto::host::{self, HostMachine, Nodes, Outcome, Request, Token};
use hoot_proto::message::{self, HostMessage, Value};
use hoot_proto::message::{DeviceMessage, Motor, Reply, ResponseCode, Steps, StepsPerSecond};
use hoot_proto::query::{AnyQuery, IntoReply, Profile};
use hoot_proto::{Address, Query};
use motion_core::time::Millis;
use motion_core::wire::Bool;

pub(crate) const NODE: Address = Address::DEFAULT;
pub(crate) const YES: Bool = Bool::TRUE;
pub(crate) const NO: Bool = Bool::FALSE;

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
            node.ok(HostMessage::MotorSetEnable(message::MotorSetEnable { motor, enable: YES }));
            node.ok(speed(motor, 500.0));
            node.ok(HostMessage::MotorSetSleep(message::MotorSetSleep { motor, sleep: NO }));
        }
        node
    }

    pub(crate) fn step(&mut self, input: device::Input<'_>) -> device::Output {
        let (machine, output) = laws::machine::step(self.machine.clone(), Millis(self.now), input);
        self.machine = machine;
        self.wake = output.wake.map(|wake| wake.0);
        output
    }

    /// The events of an input that is no packet.
    pub(crate) fn tell(&mut self, input: device::Input<'_>) -> Vec<Event> {
        let output = self.step(input);
        assert!(output.send.is_empty(), "{output:?}");
        output.events.to_vec()
    }

    /// Lets time pass, wake by wake, and gives all events with their moments.
    pub(crate) fn pass(&mut self, millis: u64) -> Vec<(u64, Event)> {
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

    pub(crate) fn send(&mut self, to: Address, message: HostMessage<'_>) -> device::Output {
        self.step(device::Input::Received { port: Port::Bus, to, message })
    }

    /// What it answers, and what happens.
    pub(crate) fn request(&mut self, message: HostMessage<'_>) -> (Vec<Answer>, Vec<Event>) {
        let output = self.send(NODE, message);
        (output.send.iter().map(|send| send.answer).collect(), output.events.to_vec())
    }

    /// A request that is done. What happens?
    #[track_caller]
    pub(crate) fn ok(&mut self, message: HostMessage<'_>) -> Vec<Event> {
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
        self.ask(HostMessage::MotorRunning(message::MotorRunning { motor })) == [0, 1]
    }
}

pub(crate) fn speed(motor: Motor, speed: f32) -> HostMessage<'static> {
    let speed = StepsPerSecond(speed);
    HostMessage::MotorSetContinuousSpeed(message::MotorSetContinuousSpeed { motor, speed })
}

pub(crate) fn move_by(motor: Motor, steps: u32) -> HostMessage<'static> {
    let (direction, steps) = (message::Direction(1), message::StepCount(steps));
    HostMessage::MotorMove(message::MotorMove { motor, direction, steps })
}

pub(crate) fn run(motor: Motor) -> HostMessage<'static> {
    HostMessage::MotorRun(message::MotorRun { motor, direction: message::Direction(0) })
}

pub(crate) fn joystick(on: Bool) -> HostMessage<'static> {
    HostMessage::SetJoystickMode(message::SetJoystickMode { joystick_mode: on })
}

pub(crate) const START: HostMessage<'static> = HostMessage::Start(message::Start {});
pub(crate) const PAUSE: HostMessage<'static> = HostMessage::Pause(message::Pause {});
pub(crate) const STOP: HostMessage<'static> = HostMessage::Stop(message::Stop {});

pub(crate) fn motor_stop(motor: Motor) -> HostMessage<'static> {
    HostMessage::MotorStop(message::MotorStop { motor })
}

pub(crate) fn motion(motor: Motor, motion: Motion) -> Event {
    Event::Motor { motor, motion }
}

pub(crate) fn to(motor: Motor, steps: i32) -> Event {
    motion(motor, Motion::To(Steps(steps)))
}

pub(crate) fn camera(focus: bool, shutter: bool) -> Event {
    Event::Camera { focus, shutter }
}

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
        assert!(master.step(host::Input::LinkUp).is_quiet());
        master
    }

    pub(crate) fn offline(options: host::Options, nodes: &[Address]) -> Self {
        let nodes = nodes.iter().fold(Nodes::NONE, |nodes, node| nodes.with(*node).unwrap());
        Self { machine: HostMachine::new(options.with_nodes(nodes)), now: 1000, wake: None }
    }

    pub(crate) fn step(&mut self, input: host::Input<'_>) -> host::Output {
        let (machine, output) = laws::machine::step(self.machine.clone(), Millis(self.now), input);
        self.machine = machine;
        self.wake = output.wake.map(|wake| wake.0);
        output
    }

    pub(crate) fn command(&mut self, command: host::Command) -> host::Output {
        self.step(host::Input::Command(command))
    }

    pub(crate) fn request(&mut self, token: u32, message: HostMessage<'static>) -> host::Output {
        self.request_to(token, NODE, message)
    }

    pub(crate) fn request_to(&mut self, token: u32, to: Address, message: HostMessage<'static>) -> host::Output {
        self.command(host::Command::Request(Request { token: Token(token), to, message }))
    }

    pub(crate) fn reply(&mut self, code: u8, data: &[u8]) -> host::Output {
        self.step(host::Input::Received(DeviceMessage::Reply(Reply { code: ResponseCode(code), data })))
    }

    /// The answer that a node with motors at rest would give.
    pub(crate) fn answer(&mut self, sent: &host::Send, at_rest: bool) -> host::Output {
        let Some(query) = sent.message.query() else { return self.reply(1, &[]) };
        let mut data = [0; 32];
        let reply = match query {
            AnyQuery::MotorRunning(query) => {
                query.reply(query.answer((!at_rest).into(), Profile::default()), &mut data)
            }
            AnyQuery::JoystickMode(query) => query.reply(query.answer(YES, Profile::default()), &mut data),
            AnyQuery::RunStatus(query) => {
                query.reply(query.answer(message::RunState(0), Profile::default()), &mut data)
            }
            query => panic!("{query:?}"),
        };
        let data = reply.unwrap().data.to_vec();
        self.reply(1, &data)
    }

    /// Goes to the next wake, which is at most so far away.
    #[track_caller]
    pub(crate) fn wait(&mut self, most: u64) -> host::Output {
        let wake = self.wake.expect("it waits for something");
        assert!(wake > self.now && wake <= self.now + most, "{wake} is not within {most} of {}", self.now);
        self.now = wake;
        self.step(host::Input::Wake)
    }

    /// Lets time pass, wake by wake, and gives all outputs with their moments.
    pub(crate) fn pass(&mut self, millis: u64) -> Vec<(u64, host::Output)> {
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
pub(crate) fn sent(outputs: &[(u64, host::Output)]) -> Vec<(u64, HostMessage<'static>)> {
    outputs.iter().flat_map(|(at, output)| output.send.iter().map(|send| (*at, send.message))).collect()
}

/// How requests ended, in order.
pub(crate) fn ended(output: &host::Output) -> Vec<(u32, Outcome)> {
    let of = |event: &host::Event| match event {
        host::Event::Ended { token, outcome } => Some((token.0, outcome.clone())),
        _ => None,
    };
    output.events.iter().filter_map(of).collect()
}

pub(crate) fn all_ended(outputs: &[(u64, host::Output)]) -> Vec<(u64, u32, Outcome)> {
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
