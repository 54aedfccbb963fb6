//! Client and device together on a line with the faults of its transport, before a simple rig.
//!
//! TCP delivers all messages in order, or is cut off. USB loses and doubles messages. Neither reorders them.

use kos_proto::Transport;
use kos_proto::device::{self, Actions, Destination, Quirks, Report, SessionId};
use kos_proto::host::{self, Command, HostMachine, StopTarget};
use kos_proto::message::*;
use kos_proto::trajectory::*;
use kos_proto::{Effect, HostMessage, Millis, Purpose};
use laws::world::{Fate, Faults, Next, Tokens};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest_state_machine::{ReferenceStateMachine, StateMachineTest, prop_state_machine};

use super::bench::*;
use super::client::{AT, go, jog};
use super::world::{World, device_bytes, frame, host_bytes, to_device, to_host};

const SESSION: SessionId = SessionId(0);
const MOTORS: [u8; 3] = [1, 2, 3];

/// Rig of three motors, which need some time for each way.
#[derive(Default)]
struct Rig {
    at: [f32; 3],
    /// Motors on their way: the time of arrival, the motor, and the position.
    ways: Vec<(Millis, u8, f32)>,
    /// Time until which a move is played.
    playing: Option<Millis>,
    /// Motors that the move sent to a place, and that are not there yet.
    sent: MotorSet,
}

impl Rig {
    fn go(&mut self, due: Millis, motor: u8, to: f32) {
        self.ways.retain(|&(_, other, _)| other != motor);
        self.ways.push((due, motor, to));
    }

    fn stop(&mut self, now: Millis, motor: u8) {
        self.go(now.after(150), motor, self.at[usize::from(motor) - 1]);
    }

    /// Carries out an event, and checks that it fits to what the motors do.
    fn follow(&mut self, now: Millis, event: &device::Event<'_>) {
        use device::Event;
        match *event {
            Event::Move { motor, to, .. } => {
                assert!(self.playing.is_none() && self.sent.is_empty(), "by hand, while a move runs");
                let from = self.at[usize::from(motor.0) - 1];
                let jogs = (to.0 - from).abs() > 1_000.0;
                self.go(if jogs { Millis(u64::MAX) } else { now.after(700) }, motor.0, to.0);
            }
            Event::StopMotor { motor, .. } => self.stop(now, motor.0),
            Event::StopAll => {
                // A live move has motors 1 and 2. A motor at rest has nothing to report.
                let played = self.is_playing(now);
                let moves = |motor| self.ways.iter().any(|&(_, other, _)| other == motor) || (played && motor < 3);
                let moving: Vec<u8> = MOTORS.into_iter().filter(|&motor| moves(motor)).collect();
                (self.playing, self.sent) = (None, MotorSet::NONE);
                for motor in moving {
                    self.stop(now, motor);
                }
            }
            Event::Home { motors, .. } => {
                assert!(self.playing.is_none() && self.sent.is_empty(), "two moves");
                assert!(self.ways.is_empty(), "a move begins while motors move");
                motors.iter().for_each(|motor| self.go(now.after(400 * u64::from(motor.0)), motor.0, 0.0));
                self.sent = motors;
            }
            Event::Play { millis, .. } => {
                assert!(self.sent.is_empty() && self.ways.is_empty(), "played before the motors are where it begins");
                assert!(!self.is_playing(now), "two moves");
                self.playing = Some(now.after(millis));
            }
            Event::MoveToFrame { .. } => {
                let motors = [MotorAddress(1), MotorAddress(2)];
                for motor in &motors {
                    self.go(now.after(300), motor.0, 1.0);
                }
                self.sent = MotorSet::of(motors);
            }
            Event::MoveOver => self.playing = None,
            _ => {}
        }
    }

    /// Whether motors move because a move is played. Photos may follow its end.
    fn is_playing(&self, now: Millis) -> bool {
        self.playing.is_some_and(|until| until > now)
    }

    /// Report of a motor that has arrived.
    fn arrived(&mut self, now: Millis) -> Option<Report> {
        let place = self.ways.iter().position(|&(due, ..)| due <= now)?;
        let (_, motor, to) = self.ways.remove(place);
        self.at[usize::from(motor) - 1] = to;
        self.sent.remove(MotorAddress(motor));
        Some(Report::Arrived(MotorAddress(motor), Rotations(to)))
    }
}

/// Conduct of the device, in which it differs from the document as we read it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Conduct {
    Mild,
    /// The device has a password, and ignores stops while it is locked.
    DeafWhileLocked,
    /// The device plays moves from their end to their begin.
    OtherWay,
    /// The device does not know an action.
    Lacks(ActionId),
}

impl Conduct {
    fn options(self) -> device::Options {
        let options = device::Options::default();
        match self {
            Self::Mild | Self::OtherWay => options,
            Self::DeafWhileLocked => options.with_quirks(Quirks::LOCKED_IGNORES_STOPS),
            Self::Lacks(action) => options.with_unsupported(Actions::NONE.with(action)),
        }
    }

    fn password(self) -> &'static [u8] {
        if self == Self::DeafWhileLocked { b"secret" } else { b"" }
    }

    fn any() -> impl Strategy<Value = Self> {
        let lacks = [
            ActionId::BUMP_POSITION_SPEED_ACCELERATION,
            ActionId::SETUP_PLAYBACK,
            ActionId::START_PLAYBACK,
            ActionId::RAPID_TO_FIRST_KEY_FRAME,
        ];
        prop_oneof![
            3 => Just(Self::Mild),
            2 => Just(Self::DeafWhileLocked),
            1 => Just(Self::OtherWay),
            2 => prop::sample::select(lacks.to_vec()).prop_map(Self::Lacks),
        ]
    }
}

/// Client and device on a line, before a rig.
struct Together {
    world: World,
    transport: Transport,
    conduct: Conduct,
    /// Whether the line still has faults.
    faults: bool,
    /// Delays and faults that come.
    luck: Box<dyn Iterator<Item = u8>>,
    /// Time at which the connection that is asked for is there.
    opening: Option<Millis>,
    rig: Rig,
    data: TrajectoryData<'static>,
    password: &'static [u8],
    other_password: &'static [u8],
    /// Events of the client about stops and the move.
    events: Vec<host::Event<'static>>,
    tokens: Tokens,
    /// Number of starts that were sent, and that the device obeyed.
    starts: (u32, u32),
}

impl Together {
    fn new(script: &Script) -> Self {
        let Script { transport, conduct, data, ref luck, .. } = *script;
        let mut bench = Bench::new(conduct.options());
        bench.calibrate(1);
        bench.calibrate(2);
        bench.step(device::Input::LinkDown(ZERO));
        let host = HostMachine::new(host::Options::default());
        let mut world = World::new(Millis(bench.now), host, bench.machine, Faults::default());
        world.device.wake = bench.wake.map(Millis);
        let mut together = Self {
            world,
            transport,
            conduct,
            faults: transport == Transport::Usb,
            luck: Box::new(luck.clone().into_iter().cycle()),
            opening: None,
            rig: Rig { at: [RANGE, RANGE, 0.0], ..Rig::default() },
            data,
            password: conduct.password(),
            other_password: b"new",
            events: Vec::new(),
            tokens: Tokens::default(),
            starts: (0, 0),
        };
        let endpoint = if transport == Transport::Tcp { AT } else { host::Endpoint::Usb };
        together.command(Command::Connect(endpoint));
        together
    }

    /// Times at which a message arrives that is sent now: once, twice, or never.
    fn arrivals(&mut self) -> impl Iterator<Item = Millis> + use<> {
        let luck = self.luck.next().unwrap_or(0);
        let due = self.world.now.after(u64::from(luck % 32) * 3);
        let times = match luck / 32 {
            0 if self.faults => 0,
            1 if self.faults => 2,
            _ => 1,
        };
        std::iter::repeat_n(due, times)
    }

    fn command(&mut self, command: Command) {
        let token = self.tokens.begin();
        self.host(host::Input::Command(token, command));
    }

    fn host(&mut self, input: host::Input<'_>) {
        let mut is_down = false;
        for effect in self.world.step_host(input) {
            let event = match effect {
                Effect::Transmit(transmit) => {
                    let (user_password, new_password) = (Password(self.password), Password(self.other_password));
                    let source = host::Source { user_password, new_password, trajectory: self.data };
                    self.starts.0 += u32::from(matches!(transmit, host::Transmit::Start));
                    let bytes = host_bytes(&transmit, &source);
                    self.arrivals().for_each(|due| self.world.up.send(due, bytes.clone()));
                    continue;
                }
                Effect::Event(event) => event,
            };
            match event {
                host::Event::Connect(_) => self.opening = Some(self.world.now.after(20)),
                host::Event::LinkDown(_) => is_down = true,
                host::Event::Ended { token, .. } => self.tokens.end(token),
                host::Event::StopNotConfirmed(_) | host::Event::Stopped(_) | host::Event::Move(_) => {
                    self.events.extend(event.to_static());
                }
                _ => {}
            }
        }
        if is_down {
            assert_eq!(self.tokens.open().count(), 0, "all commands end with the connection");
            self.opening = None;
            self.world.cut();
            self.device(device::Input::LinkDown(SESSION));
        }
    }

    fn device(&mut self, input: device::Input<'_>) {
        let ran = self.world.device.machine.playback().runs();
        let is_deaf = self.conduct == Conduct::DeafWhileLocked
            && self.world.device.machine.session(SESSION) == device::clients::State::Locked;
        let mut input = input;
        if let (Conduct::OtherWay, device::Input::Received { message: HostMessage::StartPlayback(start), .. }) =
            (self.conduct, &mut input)
        {
            start.direction = PlaybackDirection::REVERSE;
        }
        let output = self.world.step_device(input);
        if let device::Input::Received { message: HostMessage::StopPlayback(_), .. } = input {
            let stops = |event: &device::Event<'_>| *event == device::Event::StopAll;
            assert!(is_deaf || output.events().any(stops), "a stop is obeyed when it comes");
        }
        if let device::Input::Received { message: HostMessage::StartPlayback(_), .. } = input {
            self.starts.1 += u32::from(!ran && self.world.device.machine.playback().runs());
        }
        let mut close = false;
        for effect in output {
            match effect {
                Effect::Event(event) => {
                    self.rig.follow(self.world.now, &event);
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
                    let bytes = device_bytes(&transmit, &source);
                    self.arrivals().for_each(|due| self.world.down.send(due, bytes.clone()));
                }
                Effect::Transmit(_) => {}
            }
        }
        if close {
            self.world.cut();
            self.host(host::Input::LinkDown);
        }
    }

    /// Whether something moves because of the client, or will move when a message on its way arrives.
    fn moves(&self) -> bool {
        let moves = |bytes: &Vec<u8>| {
            HostMessage::decode(&frame(bytes)).is_ok_and(|message| message.conduct().purpose == Purpose::Moves)
        };
        !self.rig.ways.is_empty() || self.rig.is_playing(self.world.now) || self.world.up.iter().any(moves)
    }

    /// Cuts the connection, so that both sides see it.
    fn cut(&mut self) {
        self.world.cut();
        self.device(device::Input::LinkDown(SESSION));
        self.host(host::Input::LinkDown);
    }

    /// Lets time pass, and everything happen that is due.
    fn pass(&mut self, millis: u64) {
        let end = self.world.now.after(millis);
        loop {
            let arrival = self.rig.ways.iter().map(|&(due, ..)| due).min();
            let own = self.opening.into_iter().chain(arrival).min();
            let Some(next) = self.world.pass(end, own) else { return };
            self.happen(next);
            // Over USB a report that comes twice may be taken for the next one.
            let host = &self.world.host.machine;
            assert!(
                host.may_move() || self.transport == Transport::Usb || !self.moves(),
                "the client does not know that something moves: {:?} {:?} {:?} {host:?}",
                self.world.now,
                self.rig.ways,
                self.world.up
            );
        }
    }

    fn happen(&mut self, next: Next) {
        let now = self.world.now;
        match next {
            Next::Up => {
                if let Some((bytes, _)) = self.world.up.meet(Fate::Arrives) {
                    let password = Password(self.password);
                    self.device(to_device(SESSION, &bytes, password));
                }
            }
            Next::Down => {
                if let Some((bytes, _)) = self.world.down.meet(Fate::Arrives) {
                    self.host(to_host(&bytes));
                }
            }
            Next::Own if self.opening.is_some_and(|due| due <= now) => {
                self.opening = None;
                let password = Password(self.password);
                self.device(device::Input::LinkUp { session: SESSION, transport: self.transport, password });
                self.host(host::Input::LinkUp);
            }
            Next::Own => {
                let report = self.rig.arrived(now).expect("a motor that has arrived");
                self.device(device::Input::Rig(report));
            }
            Next::WakeDevice => self.device(device::Input::Wake),
            Next::WakeHost => self.host(host::Input::Wake),
        }
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
        Command::Load { summary: summary(), delay_return: false },
        Command::Load { summary: summary(), delay_return: true },
        Command::PlayDirect { summary: summary() },
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

/// Time in milliseconds that is longer than any move here, any answer, and any way to where a move begins. Jogs are stopped
/// before.
const SETTLE: u64 = 150_000;

/// Setup of a run, and the number of starts that the application asked for.
#[derive(Debug, Clone)]
struct Script {
    transport: Transport,
    conduct: Conduct,
    data: TrajectoryData<'static>,
    luck: Vec<u8>,
    starts: u32,
}

/// Pause, and what comes after it. Some pauses are so short that nothing is answered yet.
type Transition = (u64, Op);

/// Scripts over TCP or USB or either, with or without cuts of the connection.
struct Scripts<const TCP: bool, const USB: bool, const CUTS: bool>;

impl<const TCP: bool, const USB: bool, const CUTS: bool> ReferenceStateMachine for Scripts<TCP, USB, CUTS> {
    type State = Script;
    type Transition = Transition;

    fn init_state() -> BoxedStrategy<Script> {
        let transports: Vec<_> =
            [TCP.then_some(Transport::Tcp), USB.then_some(Transport::Usb)].into_iter().flatten().collect();
        (prop::sample::select(transports), Conduct::any(), any_move(), vec(any::<u8>(), 1..40))
            .prop_map(|(transport, conduct, data, luck)| Script { transport, conduct, data, luck, starts: 0 })
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

impl Together {
    fn of(script: &Script) -> Self {
        let mut together = Self::new(script);
        together.pass(1_000);
        together
    }

    fn follow(mut self, (wait, op): Transition) -> Self {
        self.pass(wait);
        match op {
            Op::Command(command) => self.command(command),
            Op::Cut => self.cut(),
            Op::Rig(report) => self.device(device::Input::Rig(report)),
        }
        self
    }

    /// Checks that each start was asked for, and that none is obeyed twice over TCP, which doubles nothing.
    fn check(&self, script: &Script) {
        assert!(self.starts.0 <= script.starts, "{:?} of {script:?}", self.starts);
        assert!(self.starts.1 <= self.starts.0 || self.transport == Transport::Usb, "{:?} of {script:?}", self.starts);
    }

    /// Lets everything that is under way end, without further faults.
    fn settle(&mut self) {
        self.faults = false;
        self.pass(SETTLE);
    }
}

/// Tests whose system is a [`Together`], and what holds at the end of each.
macro_rules! together {
    ($($(#[$about:meta])* $test:ident, $scripts:ty, $end:expr;)*) => { $(
        $(#[$about])*
        struct $test;

        impl StateMachineTest for $test {
            type SystemUnderTest = Together;
            type Reference = $scripts;

            fn init_test(script: &Script) -> Together {
                Together::of(script)
            }

            fn apply(together: Together, _: &Script, transition: Transition) -> Together {
                together.follow(transition)
            }

            fn check_invariants(together: &Together, script: &Script) {
                together.check(script);
            }

            fn teardown(mut together: Together, _: Script) {
                let end: fn(&mut Together) = $end;
                end(&mut together);
            }
        }
    )* };
}

together! {
    /// Over TCP without cuts, both agree whether a move is ready, after everything has ended.
    BothAgree, Scripts<true, false, false>, |together| {
        together.settle();
        let agreed = match together.world.host.machine.move_state() {
            host::MoveState::NoMove => device::playback::State::Empty,
            host::MoveState::Armed => device::playback::State::Ready,
            state => panic!("{state:?} does not end"),
        };
        assert_eq!(together.world.device.machine.playback(), agreed);
    };

    /// Over USB, which loses messages, the client does not take a move to run for ever, and the device does not play it so.
    NothingRunsForEver, Scripts<false, true, true>, |together| {
        together.settle();
        let (host, device) = (&together.world.host.machine, &together.world.device.machine);
        assert!(!host.move_state().runs() && !device.playback().runs(), "{host:?} {device:?}");
    };

    /// A stop stops everything and is confirmed when the line has no more faults, also if the stop itself was lost.
    StopGetsThere, Scripts<true, true, true>, |together| {
        together.events.clear();
        together.command(Command::Stop);
        together.settle();
        let (host, device) = (&together.world.host.machine, &together.world.device.machine);
        let stopped = host::Event::Stopped(StopTarget::All);
        assert!(together.transport == Transport::Usb || (together.events.contains(&stopped) && !host.may_move()), "{host:?}");
        assert_eq!((host.move_state(), device.playback()), (host::MoveState::NoMove, device::playback::State::Empty));
        let rests = |&motor: &u8| {
            device.motor(MotorAddress(motor)).is_none_or(|drive| drive.motion() == device::motor::Motion::Resting)
        };
        assert!(MOTORS.iter().all(rests));
        together.events.clear();
        together.pass(60_000);
        assert_eq!(together.events, []);
    };
}

prop_state_machine! {
    #[test]
    fn both_agree_on_the_move_over_tcp(sequential 1..25 => BothAgree);

    #[test]
    fn no_move_is_taken_to_run_for_ever(sequential 1..25 => NothingRunsForEver);

    #[test]
    fn a_stop_always_stops_everything(sequential 1..25 => StopGetsThere);
}
