//! A client and a device together, over a line with the faults of its transport, before a simple rig.
//!
//! TCP delivers everything in order and whole, or is cut off; USB loses messages and doubles them. Neither reorders.

use std::collections::VecDeque;

use kos_proto::Transport;
use kos_proto::device::{self, Destination, DeviceMachine, Report, Scratch, SessionId};
use kos_proto::host::{self, Command, HostMachine, StopTarget, Token};
use kos_proto::message::*;
use kos_proto::trajectory::*;
use kos_proto::{Effect, Frame, HostMessage, Millis};
use laws::machine::step;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest_state_machine::{ReferenceStateMachine, StateMachineTest, prop_state_machine};

use super::bench::*;
use super::client::{AT, go, jog};

const SESSION: SessionId = SessionId(0);
const MOTORS: [u8; 3] = [1, 2, 3];

/// One direction of a line.
#[derive(Default)]
struct Wire {
    queue: VecDeque<(u64, Vec<u8>)>,
}

impl Wire {
    /// A message is on its way, behind all that is.
    fn put(&mut self, now: u64, delay: u64, message: Vec<u8>) {
        let due = self.queue.back().map_or(0, |(due, _)| *due).max(now + delay);
        self.queue.push_back((due, message));
    }

    fn due(&self) -> Option<u64> {
        self.queue.front().map(|(due, _)| *due)
    }
}

/// Three motors that take their time.
#[derive(Default)]
struct Rig {
    at: [f32; 3],
    /// Motors on their way: when they are there, and where.
    ways: Vec<(u64, u8, f32)>,
    /// Until when a move is played, and which motors it moves to a place of its own.
    playing: Option<u64>,
    sent: MotorSet,
}

impl Rig {
    fn go(&mut self, due: u64, motor: u8, to: f32) {
        self.ways.retain(|&(_, other, _)| other != motor);
        self.ways.push((due, motor, to));
    }

    /// Does what it is told, and checks that it makes sense.
    fn follow(&mut self, now: u64, event: &device::Event<'_>) {
        use device::Event;
        match *event {
            Event::Move { motor, to, .. } => {
                assert!(self.playing.is_none() && self.sent.is_empty(), "by hand, while a move runs");
                let from = self.at[usize::from(motor.0) - 1];
                let jogs = (to.0 - from).abs() > 1_000.0;
                self.go(if jogs { u64::MAX } else { now + 700 }, motor.0, to.0);
            }
            Event::StopMotor { motor, .. } => self.go(now + 150, motor.0, self.at[usize::from(motor.0) - 1]),
            Event::StopAll => {
                // A live move has motors 1 and 2; what rests anyway has nothing to say.
                let played = self.is_playing(now);
                let moves = |motor| self.ways.iter().any(|&(_, other, _)| other == motor) || (played && motor < 3);
                let moving: Vec<u8> = MOTORS.into_iter().filter(|&motor| moves(motor)).collect();
                (self.playing, self.sent) = (None, MotorSet::NONE);
                for motor in moving {
                    self.go(now + 150, motor, self.at[usize::from(motor) - 1]);
                }
            }
            Event::Home { motors, .. } => {
                assert!(self.playing.is_none() && self.sent.is_empty(), "two moves");
                assert!(self.ways.is_empty(), "a move begins while motors move");
                motors.iter().for_each(|motor| self.go(now + 400 * u64::from(motor.0), motor.0, 0.0));
                self.sent = motors;
            }
            Event::Play { millis, .. } => {
                assert!(self.sent.is_empty() && self.ways.is_empty(), "played before it is home");
                assert!(self.playing.is_none_or(|until| until <= now), "two moves");
                self.playing = Some(now + millis);
            }
            Event::MoveToFrame { .. } => {
                let motors = [MotorAddress(1), MotorAddress(2)];
                for motor in motors {
                    self.go(now + 300, motor.0, 1.0);
                }
                self.sent = MotorSet::of(motors);
            }
            Event::MoveOver => self.playing = None,
            _ => {}
        }
    }

    /// Whether motors move because a move is played. Photos may follow its end.
    fn is_playing(&self, now: u64) -> bool {
        self.playing.is_some_and(|until| until > now)
    }

    /// A motor that is there.
    fn arrived(&mut self, now: u64) -> Option<Report> {
        let place = self.ways.iter().position(|&(due, ..)| due <= now)?;
        let (_, motor, to) = self.ways.remove(place);
        self.at[usize::from(motor) - 1] = to;
        self.sent.remove(MotorAddress(motor));
        Some(Report::Arrived(MotorAddress(motor), Rotations(to)))
    }
}

/// Event of a client, as far as the tests ask for it.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Told {
    NotConfirmed,
    Stopped(StopTarget),
    Move,
}

struct World {
    now: u64,
    transport: Transport,
    /// Whether the line still has faults, and which ones come.
    faults: bool,
    luck: Box<dyn Iterator<Item = u8>>,
    host: HostMachine,
    device: DeviceMachine,
    host_wake: Option<u64>,
    device_wake: Option<u64>,
    /// When the connection that is asked for is there.
    opening: Option<u64>,
    to_device: Wire,
    to_host: Wire,
    rig: Rig,
    data: TrajectoryData<'static>,
    password: &'static [u8],
    other_password: &'static [u8],
    /// Events of the client, without what they borrow.
    told: Vec<Told>,
    /// Commands that did not end, and the number of the last one.
    open: Vec<Token>,
    token: u32,
    /// What only a command may send, how often it was sent, and how often the device did it.
    starts: (u32, u32),
}

impl World {
    fn new(transport: Transport, data: TrajectoryData<'static>, luck: Vec<u8>) -> Self {
        let mut bench = Bench::new(device::Options::default());
        bench.calibrate(1);
        bench.calibrate(2);
        bench.step(device::Input::LinkDown(ZERO));
        let mut world = Self {
            now: bench.now,
            transport,
            faults: true,
            luck: Box::new(luck.into_iter().cycle()),
            host: HostMachine::new(host::Options::default()),
            device: bench.machine,
            host_wake: None,
            device_wake: bench.wake,
            opening: None,
            to_device: Wire::default(),
            to_host: Wire::default(),
            rig: Rig { at: [RANGE, RANGE, 0.0], ..Rig::default() },
            data,
            password: b"",
            other_password: b"new",
            told: Vec::new(),
            open: Vec::new(),
            token: 0,
            starts: (0, 0),
        };
        let endpoint = if transport == Transport::Tcp { AT } else { host::Endpoint::Usb };
        world.command(Command::Connect(endpoint));
        world
    }

    fn roll(&mut self) -> u8 {
        self.luck.next().unwrap_or(0)
    }

    /// Puts a message on a line: later, twice, or never.
    fn transmit(&mut self, to_device: bool, message: &[u8]) {
        let fate = self.roll();
        let delay = u64::from(fate % 32) * 3;
        let copies = match (self.faults && self.transport == Transport::Usb, fate / 32) {
            (true, 0) => 0,
            (true, 1) => 2,
            _ => 1,
        };
        let wire = if to_device { &mut self.to_device } else { &mut self.to_host };
        for _ in 0..copies {
            wire.put(self.now, delay, message.to_vec());
        }
    }

    fn command(&mut self, command: Command) {
        self.token += 1;
        self.open.push(Token(self.token));
        self.host(host::Input::Command(Token(self.token), command));
    }

    fn host(&mut self, input: host::Input<'_>) {
        let (host, output) = step(self.host.clone(), Millis(self.now), input);
        self.host = host;
        self.host_wake = output.wake.map(|wake| wake.0);
        let mut is_down = false;
        for effect in output {
            let event = match effect {
                Effect::Transmit(transmit) => {
                    let (user_password, new_password) = (Password(self.password), Password(self.other_password));
                    let source = host::Source { user_password, new_password, trajectory: self.data };
                    let message = transmit.message(&source);
                    let mut bytes = vec![0; message.encoded_len()];
                    message.encode_into(&mut bytes).unwrap();
                    self.starts.0 += u32::from(matches!(transmit, host::Transmit::Start(_)));
                    self.transmit(true, &bytes);
                    continue;
                }
                Effect::Event(event) => event,
            };
            match event {
                host::Event::Connect(_) => self.opening = Some(self.now + 20),
                host::Event::LinkDown(_) => is_down = true,
                host::Event::Ended { token, .. } => {
                    let place = self.open.iter().position(|&open| open == token);
                    self.open.remove(place.expect("a command ends once"));
                }
                host::Event::StopNotConfirmed(_) => self.told.push(Told::NotConfirmed),
                host::Event::Stopped(target) => self.told.push(Told::Stopped(target)),
                host::Event::Move(_) => self.told.push(Told::Move),
                _ => {}
            }
        }
        if is_down {
            assert_eq!(self.open, [], "with the connection, all commands end");
            self.opening = None;
            self.cut();
            self.device(device::Input::LinkDown(SESSION));
        }
    }

    fn device(&mut self, input: device::Input<'_>) {
        let ran = self.device.playback().runs();
        let (device, output) = step(self.device.clone(), Millis(self.now), input);
        self.device = device;
        self.device_wake = output.wake.map(|wake| wake.0);
        if let device::Input::Received { message: HostMessage::StopPlayback(_), .. } = input {
            let stops = |event: &device::Event<'_>| *event == device::Event::StopAll;
            assert!(output.events().any(stops), "a stop is obeyed when it comes");
        }
        if let device::Input::Received { message: HostMessage::StartPlayback(_), .. } = input {
            self.starts.1 += u32::from(!ran && self.device.playback().runs());
        }
        let mut close = false;
        for effect in output {
            match effect {
                Effect::Event(event) => {
                    self.rig.follow(self.now, &event);
                    match event {
                        device::Event::Disconnect { .. } => close = true,
                        device::Event::StorePassword(given) if given != Password(self.password) => {
                            std::mem::swap(&mut self.password, &mut self.other_password);
                        }
                        _ => {}
                    }
                }
                Effect::Transmit(transmit) if transmit.destination != Destination::Broadcast => {
                    let password = Password(self.password);
                    let source =
                        device::Source { password, trajectory: self.data, guid: &[7; 16], ..Default::default() };
                    let mut scratch = Scratch::default();
                    let message = transmit.message(&source, &mut scratch);
                    let mut bytes = vec![0; message.encoded_len()];
                    message.encode_into(&mut bytes).unwrap();
                    self.transmit(false, &bytes);
                }
                Effect::Transmit(_) => {}
            }
        }
        if close {
            self.cut();
            self.host(host::Input::LinkDown);
        }
    }

    /// Whether something moves, or will when what is under way arrives, because of the client.
    fn moves(&self) -> bool {
        let moving = |wire: &Wire| {
            wire.queue.iter().any(|(_, bytes)| {
                HostMessage::decode(&Frame::decode(bytes).unwrap()).unwrap().conduct().purpose
                    == kos_proto::Purpose::Moves
            })
        };
        !self.rig.ways.is_empty() || self.rig.is_playing(self.now) || moving(&self.to_device)
    }

    /// What is on its way is lost.
    fn cut(&mut self) {
        (self.to_device, self.to_host) = (Wire::default(), Wire::default());
    }

    /// Deals with the next thing that happens until a moment; `false` if nothing does.
    fn happen(&mut self, end: u64) -> bool {
        let rig = self.rig.ways.iter().map(|&(due, ..)| due).min();
        let wires = [self.to_device.due(), self.to_host.due()];
        let all = [self.host_wake, self.device_wake, self.opening, rig, wires[0], wires[1]];
        let Some(due) = all.into_iter().flatten().min().filter(|&due| due <= end) else { return false };
        self.now = self.now.max(due);
        let is_due = |due: Option<u64>| due.is_some_and(|due| due <= self.now);
        if is_due(wires[0]) {
            let (_, bytes) = self.to_device.queue.pop_front().unwrap();
            let password = Password(self.password);
            self.device(device::Input::received(SESSION, &Frame::decode(&bytes).unwrap(), password));
        } else if is_due(wires[1]) {
            let (_, bytes) = self.to_host.queue.pop_front().unwrap();
            self.host(host::Input::received(&Frame::decode(&bytes).unwrap()));
        } else if is_due(self.opening) {
            self.opening = None;
            let password = Password(self.password);
            self.device(device::Input::LinkUp { session: SESSION, transport: self.transport, password });
            self.host(host::Input::LinkUp);
        } else if let Some(report) = self.rig.arrived(self.now) {
            self.device(device::Input::Rig(report));
        } else if is_due(self.device_wake) {
            self.device(device::Input::Wake);
        } else {
            self.host(host::Input::Wake);
        }
        // Over USB a report that comes twice may be taken for the next one.
        let may_move = self.host.may_move() || self.transport == Transport::Usb || !self.moves();
        assert!(may_move, "the client does not know that something moves: {:?}", self.host);
        true
    }

    fn pass(&mut self, millis: u64) {
        let end = self.now + millis;
        while self.happen(end) {}
        self.now = end;
    }
}

#[derive(Debug, Clone, Copy)]
enum Op {
    Command(Command),
    /// The connection is lost.
    Cut,
    Rig(Report),
}

fn op() -> impl Strategy<Value = Op> {
    use super::client::summary;
    let motor = || (1..4_u8).prop_map(MotorAddress);
    let simple = vec![
        Command::Stop,
        Command::Load { summary: summary(), way: Direction::Forward, delay_return: false },
        Command::Load { summary: summary(), way: Direction::Forward, delay_return: true },
        Command::PlayDirect { summary: summary(), way: Direction::Forward },
        Command::Play,
        Command::RapidToFirstKeyFrame,
        Command::ChangePassword,
        Command::Unlock,
        Command::Alive,
    ];
    let command = prop_oneof![
        10 => prop::sample::select(simple),
        1 => motor().prop_map(Command::StopMotor),
        1 => motor().prop_map(Command::MarkBegin),
        1 => motor().prop_map(Command::MarkEnd),
        2 => (motor(), 0..8_u8).prop_map(|(motor, position)| Command::MoveTo(go(motor, position.into()))),
        1 => (motor(), prop::sample::select(vec![5.0, -5.0])).prop_map(|(motor, speed)| jog(motor, speed)),
        1 => motor().prop_map(|motor| Command::Bump(go(motor, 1.0))),
    ];
    let fault = (motor(), prop::sample::select(vec![10, 11, 16]))
        .prop_map(|(motor, code)| Report::Fault(motor, ErrorCode(code)));
    prop_oneof![20 => command.prop_map(Op::Command), 1 => Just(Op::Cut), 1 => fault.prop_map(Op::Rig)]
}

fn any_move() -> impl Strategy<Value = TrajectoryData<'static>> {
    let live_moves = (0..3_u8, 0..2_u8).prop_map(|(loops, delay)| {
        let delay_interval_bits = DelayInterval::from_seconds(Seconds(2.0));
        let (delay_mode, loop_after_reverse) = (DelayMode(delay), LoopCount(loops));
        let duration = Seconds(4.0);
        let rapid_reverse_duration = duration;
        live_move(Playback {
            duration,
            rapid_reverse_duration,
            loop_after_reverse,
            delay_mode,
            delay_interval_bits,
            ..live()
        })
    });
    let lapses = (1..3_u8, 0..2_u32, 1..4_u32, 0..2_u32).prop_map(|(mode, before, moving, after)| {
        trajectory(Playback { playback_mode: PlaybackMode(mode), ..live() }, photos(0.5, 0.2, before, moving, after))
    });
    prop_oneof![live_moves, lapses]
}

/// Longer than any move here takes, any answer, and any way home; jogs are stopped before.
const SETTLE: u64 = 150_000;

/// What a run is about, and what the application did in it.
#[derive(Debug, Clone)]
struct Script {
    transport: Transport,
    data: TrajectoryData<'static>,
    luck: Vec<u8>,
    /// How often it asked for something that may play a move.
    starts: u32,
}

/// A pause, and what comes behind it: short ones, in which nothing is answered yet, and long ones.
type Transition = (u64, Op);

/// Scripts over TCP or USB or either, whose line is cut off now and then or never.
struct Scripts<const TCP: bool, const USB: bool, const CUTS: bool>;

impl<const TCP: bool, const USB: bool, const CUTS: bool> ReferenceStateMachine for Scripts<TCP, USB, CUTS> {
    type State = Script;
    type Transition = Transition;

    fn init_state() -> BoxedStrategy<Script> {
        let transports: Vec<_> =
            [TCP.then_some(Transport::Tcp), USB.then_some(Transport::Usb)].into_iter().flatten().collect();
        (prop::sample::select(transports), any_move(), vec(any::<u8>(), 1..40))
            .prop_map(|(transport, data, luck)| Script { transport, data, luck, starts: 0 })
            .boxed()
    }

    fn transitions(_: &Script) -> BoxedStrategy<Transition> {
        let wait = prop_oneof![1 => 0..100_u64, 1 => 0..3_000_u64, 1 => 0..8_000_u64];
        (wait, op()).boxed()
    }

    fn preconditions(_: &Script, (_, op): &Transition) -> bool {
        CUTS || !matches!(op, Op::Cut)
    }

    fn apply(mut script: Script, (_, op): &Transition) -> Script {
        script.starts += u32::from(matches!(op, Op::Command(Command::Play | Command::PlayDirect { .. })));
        script
    }
}

impl World {
    fn of(script: &Script) -> Self {
        let mut world = Self::new(script.transport, script.data, script.luck.clone());
        world.pass(1_000);
        world
    }

    fn follow(mut self, (wait, op): Transition) -> Self {
        self.pass(wait);
        match op {
            Op::Command(command) => self.command(command),
            Op::Cut => {
                self.cut();
                self.device(device::Input::LinkDown(SESSION));
                self.host(host::Input::LinkDown);
            }
            Op::Rig(report) => self.device(device::Input::Rig(report)),
        }
        self
    }

    /// No start is sent that was not asked for, and over TCP, which doubles nothing, none is done twice.
    fn check(&self, script: &Script) {
        assert!(self.starts.0 <= script.starts, "{:?} of {script:?}", self.starts);
        assert!(self.starts.1 <= self.starts.0 || self.transport == Transport::Usb, "{:?} of {script:?}", self.starts);
    }

    /// The line is good from now on, and all that is under way settles.
    fn settle(&mut self) {
        self.faults = false;
        self.pass(SETTLE);
    }
}

/// Tests whose system is a [`World`], and what holds at the end of each.
macro_rules! together {
    ($($(#[$about:meta])* $test:ident, $scripts:ty, $end:expr;)*) => { $(
        $(#[$about])*
        struct $test;

        impl StateMachineTest for $test {
            type SystemUnderTest = World;
            type Reference = $scripts;

            fn init_test(script: &Script) -> World {
                World::of(script)
            }

            fn apply(world: World, _: &Script, transition: Transition) -> World {
                world.follow(transition)
            }

            fn check_invariants(world: &World, script: &Script) {
                world.check(script);
            }

            fn teardown(mut world: World, _: Script) {
                let end: fn(&mut World) = $end;
                end(&mut world);
            }
        }
    )* };
}

together! {
    /// Over TCP that is not cut off, both agree whether a move is loaded, once all that is under way is settled.
    BothAgree, Scripts<true, false, false>, |world| {
        world.settle();
        let agreed = match world.host.move_state() {
            host::MoveState::NoMove => device::playback::State::Empty,
            host::MoveState::Armed => device::playback::State::Ready,
            state => panic!("{state:?} does not end"),
        };
        assert_eq!(world.device.playback(), agreed);
    };

    /// Over USB, where words are lost, no move is believed to run that is over, nor one to be over that runs.
    NothingRunsForEver, Scripts<false, true, true>, |world| {
        world.settle();
        assert!(!world.host.move_state().runs(), "{:?}", world.host.move_state());
        assert!(!world.device.playback().runs(), "{:?}", world.device.playback());
    };

    /// Whatever happened, a stop stops everything once the line is good, also if it was lost itself; it is confirmed, and
    /// said to be.
    StopGetsThere, Scripts<true, true, true>, |world| {
        world.told.clear();
        world.command(Command::Stop);
        world.settle();
        assert!(world.transport == Transport::Usb || world.told.contains(&Told::Stopped(StopTarget::All)));
        assert_eq!(world.device.playback(), device::playback::State::Empty);
        let resting = |&motor: &u8| {
            world.device.motor(MotorAddress(motor)).is_none_or(|drive| drive.motion() == device::motor::Motion::Resting)
        };
        assert!(MOTORS.iter().all(resting));
        assert_eq!(world.host.move_state(), host::MoveState::NoMove);
        assert!(world.transport == Transport::Usb || !world.host.may_move(), "{:?}", world.host);
        world.told.clear();
        world.pass(60_000);
        assert_eq!(world.told, []);
    };
}

prop_state_machine! {
    #[test]
    fn both_agree_over_tcp(sequential 1..25 => BothAgree);

    #[test]
    fn no_move_is_believed_to_run_for_ever(sequential 1..25 => NothingRunsForEver);

    #[test]
    fn a_stop_always_gets_there(sequential 1..25 => StopGetsThere);
}
