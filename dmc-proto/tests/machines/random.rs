//! Random inputs of both machines, alone and together.

use std::collections::{HashMap, HashSet};

use dmc_proto::device::{self, DeviceMachine, Quirks, State};
use dmc_proto::host::{self, Command, Contents, Failure, HostMachine, Outcome, Progress, Refusal, StopTarget};
use dmc_proto::message::{
    AckCode, Hi, HiRequest, HostMessage, Motor, MotorConfigure, MotorFlags, MotorStatusRequest, Motors, RtGo,
    RtStopLoop, RtUploadMoveEnd, RunFlags, Triggers, VirtualMotor,
};
use dmc_proto::upload::{Section, SectionSize};
use dmc_proto::{Effect, MessageId, MessageType, Millis};
use laws::world::{Fate, Watched};
use motion_core::wire::Messages;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use proptest_state_machine::{ReferenceStateMachine, StateMachineTest, prop_state_machine};

use super::app::{App, Tens, hi, may_not_stop, the_rig_acts_first};
use super::bench::{
    SWING_PAN, axis, begin, frame, jog, jog_all, move_to, position_frame, run, shot, stop, stop_all, virtuals,
};
use super::world::{Action, BadLine, World, answer_id, device_message};

/// Messages that a device with every capability may accept.
pub(crate) fn sensible() -> Vec<HostMessage<'static>> {
    vec![
        HostMessage::from(HiRequest::default()),
        HostMessage::from(MotorStatusRequest::default()),
        move_to(1, 5),
        move_to(3, 5),
        jog(2),
        jog(3),
        stop(1),
        stop(3),
        stop_all(),
        begin(1, 10),
        axis(1),
        axis(2),
        HostMessage::from(RtUploadMoveEnd::default()),
        position_frame(1),
        position_frame(12),
        jog_all(5),
        run(1, 10, RunFlags(0)),
        run(10, 1, RunFlags::PING_PONG),
        run(1, 10, RunFlags::LOOP),
        shot(3),
        HostMessage::from(RtGo::default()),
        HostMessage::from(RtStopLoop::default()),
        virtuals(&SWING_PAN),
        virtuals(&[0]),
    ]
}

/// Input of a device. Bytes are decoded as a message of any type.
#[derive(Debug, Clone)]
enum DeviceStep {
    Sensible(Index, bool),
    Hostile(u32, Vec<u8>, u16),
    Report(u8, u8),
}

fn device_steps() -> impl Strategy<Value = Vec<(u64, DeviceStep)>> {
    let step = prop_oneof![
        6 => (any::<Index>(), prop::bool::weighted(0.9)).prop_map(|(at, ok)| DeviceStep::Sensible(at, ok)),
        1 => (0_u32..0x220, vec(any::<u8>(), 0..40), any::<u16>())
            .prop_map(|(kind, body, code)| DeviceStep::Hostile(kind, body, code)),
        6 => (0_u8..16, any::<u8>()).prop_map(|(what, which)| DeviceStep::Report(what, which)),
    ];
    let gap = prop_oneof![3 => Just(0), 3 => 1..200_u64, 1 => 900..3000_u64, 1 => Just(u64::MAX / 50)];
    vec((gap, step), 0..120)
}

pub(crate) fn report(what: u8, which: u8) -> device::Input<'static> {
    let motor = Motor(which % 10);
    match what {
        0 => device::Input::LinkUp,
        1 => device::Input::LinkDown,
        2 => device::Input::Rig(device::Report::Moving(Motors(which.into()))),
        3..=6 => device::Input::Rig(device::Report::AtRest),
        7 => device::Input::Rig(device::Report::AtFrame(frame(which.into()))),
        8 => device::Input::Rig(device::Report::PassEnd),
        9 => device::Input::Rig(device::Report::OperatorGo),
        10 => device::Input::Rig(device::Report::Limit { motor, upper: which > 100 }),
        11 => device::Input::Rig(device::Report::EmergencyStop(which > 100)),
        12 => device::Input::Rig(device::Report::Fault(Some(motor))),
        13 => device::Input::Rig(device::Report::Inputs(Triggers(which.into()))),
        14 => device::Input::Corrupt(MessageId(which.into()), MessageType(0x0030)),
        _ => device::Input::Wake,
    }
}

/// Takes a step of a device, which keeps its laws: each request is answered once, stops are obeyed, and only a message
/// that may move begins a motion.
fn device_step<'a>(device: &mut Watched<DeviceMachine>, now: Millis, input: device::Input<'a>) -> device::Output<'a> {
    let before = device.machine.state();
    let stops = match &input {
        device::Input::Received { message: message @ HostMessage::MotorStopAll(_), .. } => {
            !may_not_stop(&device.machine, message)
        }
        _ => false,
    };
    let output = device.step_whole(now, input, device::Input::Wake);
    the_rig_acts_first(&output);
    // Positions under the id of a request may follow its acknowledgement (decision D-83).
    let is_ack = |contents| matches!(contents, device::Contents::Ack { .. });
    let answers = || output.transmits().filter(|transmit| transmit.id == MessageId(7));
    let asked = if answers().any(|transmit| is_ack(transmit.contents)) {
        answers().filter(|transmit| is_ack(transmit.contents)).count()
    } else {
        answers().count()
    };
    let stores = output.events().any(|event| matches!(event, device::Event::Store { .. }));
    if let device::Input::Received { message, .. } = input {
        let answers = usize::from(!message.kind().is_ack() && !stores);
        assert_eq!(asked, answers, "{message} in {before:?}: {output:?}");
        if stops {
            assert!(matches!(output.effects[0], Effect::Event(device::Event::Stop(_))));
            assert!(matches!(device.machine.state(), State::Idle | State::Stopping | State::Locked));
        }
    }
    for event in output.events() {
        let may = match (event, input) {
            (
                device::Event::Move(..)
                | device::Event::Jog(..)
                | device::Event::MoveVirtual(_)
                | device::Event::ToFrame(_)
                | device::Event::JogAll(..),
                device::Input::Received { message, .. },
            ) => {
                message.conduct().may_move() && !matches!(before, State::Running | State::Stopping | State::Locked)
                    || before == State::Running && matches!(event, device::Event::Move(..) | device::Event::Jog(..))
            }
            (device::Event::Prepare(_), device::Input::Received { .. }) => before == State::Idle,
            (device::Event::Go, device::Input::Received { .. } | device::Input::Rig(device::Report::OperatorGo)) => {
                before == State::Ready
            }
            (device::Event::NextPass(..) | device::Event::PostRoll, device::Input::Rig(device::Report::PassEnd)) => {
                before == State::Running
            }
            (device::Event::Move(..) | device::Event::Prepare(_) | device::Event::Go, _) => false,
            _ => true,
        };
        assert!(may, "{event:?} in {before:?}");
    }
    output
}

/// Input of a host.
#[derive(Debug, Clone)]
enum HostStep {
    Request(Index),
    /// A motor gets these uses, one after the other.
    Configure(u8, Vec<MotorFlags>),
    Jog(u8),
    Sequence(Index),
    Stop(u8),
    Command(u8),
    Answer(u32, Option<AckCode>),
    Hostile(u32, u32, Vec<u8>),
    Line(u8),
    Section(bool),
}

fn host_steps() -> impl Strategy<Value = Vec<(u64, HostStep)>> {
    let code = prop_oneof![
        4 => Just(AckCode::OK),
        1 => Just(AckCode::ERR_CHECKSUM),
        1 => Just(AckCode::ERR_NOT_IN_POSITION),
        1 => any::<u16>().prop_map(AckCode),
    ];
    let step = prop_oneof![
        5 => any::<Index>().prop_map(HostStep::Request),
        4 => (1..4_u8, vec(uses(), 1..3)).prop_map(|(motor, uses)| HostStep::Configure(motor, uses)),
        4 => (1..4_u8).prop_map(HostStep::Jog),
        3 => any::<Index>().prop_map(HostStep::Sequence),
        2 => any::<u8>().prop_map(HostStep::Stop),
        2 => (0_u8..4).prop_map(HostStep::Command),
        8 => (0_u32..6, prop::option::of(code)).prop_map(|(id, code)| HostStep::Answer(id, code)),
        2 => (0_u32..50, 0_u32..0x220, vec(any::<u8>(), 0..60))
            .prop_map(|(id, kind, body)| HostStep::Hostile(id, kind, body)),
        1 => any::<u8>().prop_map(HostStep::Line),
        3 => any::<bool>().prop_map(HostStep::Section),
    ];
    let gap = prop_oneof![4 => Just(0), 3 => 1..200_u64, 1 => 200..2000_u64];
    vec((gap, step), 0..150)
}

/// Host alone, with its application.
struct Alone {
    host: Watched<HostMachine>,
    app: App<'static>,
    now: Millis,
}

impl Alone {
    fn step<'a>(&mut self, input: host::Input<'a>) -> host::Output<'a> {
        let output = self.host.step_whole(self.now, input, host::Input::Wake);
        self.app.takes(&output, &self.host.machine);
        output
    }

    fn tell(&mut self, input: host::Input<'_>) {
        let _ = self.step(input);
    }

    fn pass(&mut self, millis: u64) {
        let end = self.now.after(millis);
        while let Some(wake) = self.host.wake.filter(|&wake| wake <= end) {
            self.now = wake;
            self.tell(host::Input::Wake);
        }
        self.now = end;
    }

    fn command(&mut self, command: Command<'static>) -> host::Output<'static> {
        let input = self.app.command(command);
        self.step(input)
    }

    fn act(&mut self, step: &HostStep) {
        match *step {
            HostStep::Request(at) => drop(self.command(Command::Request(*at.get(&sensible())))),
            HostStep::Configure(motor, ref uses) => {
                for flags in uses {
                    let configure = MotorConfigure { motor: Motor(motor), flags: *flags, tail: &[] };
                    let _ = self.command(Command::Request(configure.into()));
                }
            }
            HostStep::Jog(motor) => drop(self.command(Command::Request(jog(motor)))),
            HostStep::Sequence(at) => drop(self.command(Command::Sequence(*at.get(&sensible())))),
            HostStep::Stop(which) => {
                let wanted = match which % 4 {
                    0 => StopTarget::Motor(Motor(which)),
                    1 => StopTarget::Virtual(VirtualMotor(which)),
                    2 => StopTarget::AllSilent,
                    _ => StopTarget::All,
                };
                let is_open = self.host.machine.state() != host::State::Offline;
                match (self.command(Command::Stop(wanted)).effects[0], is_open) {
                    (Effect::Transmit(host::Transmit { contents: Contents::Stop(_), .. }), true)
                    | (Effect::Event(host::Event::StopNotConfirmed(_)), false) => {}
                    (first, _) => panic!("{first:?}"),
                }
            }
            HostStep::Command(0) => drop(self.command(Command::Go)),
            HostStep::Command(1) => drop(self.command(Command::Configured)),
            HostStep::Command(2) => drop(self.command(Command::EndStops)),
            HostStep::Command(_) => drop(self.command(Command::Greet)),
            HostStep::Answer(choice, code) => {
                let id = answer_id(&self.host.machine, choice);
                let kind =
                    self.host.machine.pending().find(|pending| pending.0 == id).map_or(MessageType(0x33), |p| p.1);
                let body = code.map_or([0; 2], |code| code.0.to_le_bytes());
                let number = if code.is_some() { kind.ack().0 } else { kind.0 };
                if let Some(message) = device_message(number.into(), &[&body[..], &[0; 60]].concat()) {
                    self.tell(host::Input::Received(id, message));
                }
            }
            HostStep::Hostile(id, kind, ref body) => {
                let input = match device_message(kind, body) {
                    Some(message) => host::Input::Received(answer_id(&self.host.machine, id), message),
                    None => host::Input::Malformed(MessageId(id), MessageType(1)),
                };
                self.tell(input);
            }
            HostStep::Line(which) if which < 60 => self.tell(host::Input::LinkDown),
            HostStep::Line(_) => self.tell(host::Input::LinkUp),
            HostStep::Section(some) => {
                let section = if some { Section::first(&Tens, SectionSize::default()) } else { None };
                self.tell(host::Input::Section(section));
            }
        }
    }
}

fn bad_line() -> impl Strategy<Value = BadLine> {
    let fate = prop_oneof![8 => Just(Fate::Arrives), 1 => Just(Fate::Lost), 1 => Just(Fate::Doubled), 1 => Just(Fate::Corrupt)];
    let travel = prop_oneof![11 => Just(2), 1 => Just(700)];
    let cut = prop_oneof![2 => Just(0), 1 => 1..1048_usize];
    let line = |(travels, fates, cuts): (Vec<_>, Vec<_>, Vec<_>)| BadLine {
        travels: travels.into(),
        fates: fates.into(),
        cuts: cuts.into(),
    };
    (vec(travel, 0..200), vec(fate, 0..200), vec(cut, 0..100)).prop_map(line)
}

fn options() -> impl Strategy<Value = host::Options> {
    let options =
        |(window, needs_enabled)| host::Options::default().with_window(window).with_needs_enabled(needs_enabled);
    (1..5_u8, any::<bool>()).prop_map(options)
}

/// Uses of a motor.
fn uses() -> impl Strategy<Value = MotorFlags> {
    let (enabled, live) = (MotorFlags::ENABLED, MotorFlags::LIVE);
    select(vec![MotorFlags::empty(), live, enabled, enabled, enabled | live, enabled | MotorFlags::BLUR])
}

fn action() -> BoxedStrategy<(Action, u64)> {
    let stops =
        select(vec![StopTarget::All, StopTarget::AllSilent, StopTarget::Motor(Motor(1)), StopTarget::Motor(Motor(3))]);
    let (none, enabled) = (MotorFlags::empty(), MotorFlags::ENABLED);
    let all_uses = select(vec![(enabled, none), (enabled, none), (enabled, enabled | MotorFlags::LIVE), (none, none)]);
    let flags = select(vec![RunFlags(0), RunFlags(0), RunFlags::LOOP, RunFlags::PING_PONG]);
    let action = prop_oneof![
        2 => (1..4_u8).prop_map(Action::Move),
        2 => (1..4_u8).prop_map(Action::Jog),
        4 => (1..4_u8, uses()).prop_map(|(motor, flags)| Action::Configure(motor, flags)),
        6 => all_uses.prop_map(|(flags, other)| Action::ConfigureAll(flags, other)),
        1 => Just(Action::Status),
        4 => prop::bool::weighted(0.8).prop_map(Action::Upload),
        4 => (1..11).prop_map(Action::ToFrame),
        2 => (1..11).prop_map(Action::JogAll),
        4 => flags.prop_map(Action::Run),
        2 => Just(Action::Shot),
        6 => Just(Action::Go),
        2 => Just(Action::StopLoop),
        3 => stops.prop_map(Action::Stop),
        1 => Just(Action::OperatorGo),
        1 => (1..4_u8).prop_map(Action::Limit),
        1 => Just(Action::Emergency),
        1 => Just(Action::LinkDown),
    ];
    (action, prop_oneof![2 => 0..300_u64, 3 => 1000..5000_u64]).boxed()
}

proptest! {
    /// S-1, S-7
    #[test]
    fn a_device_keeps_its_laws_with_any_inputs(steps in device_steps(), quirks in any::<u32>()) {
        let options = device::Options::of(hi()).with_quirks(Quirks(quirks));
        let (mut device, mut now) = (Watched::new(DeviceMachine::new(options)), Millis(0));
        let mut stores = vec![];
        for (gap, step) in steps {
            now = now.after(gap);
            let all = sensible();
            let id = MessageId(7);
            let output = match &step {
                DeviceStep::Sensible(at, ok) => {
                    let rig = if *ok { AckCode::OK } else { AckCode::ERR_SOFT_UP };
                    device_step(&mut device, now, device::Input::Received { id, message: *at.get(&all), rig })
                }
                DeviceStep::Hostile(kind, body, code) => match HostMessage::decode_body(*kind, body) {
                    Ok(message) => {
                        device_step(&mut device, now, device::Input::Received { id, message, rig: AckCode(*code) })
                    }
                    Err(_) => device_step(&mut device, now, device::Input::Malformed(id, MessageType(0x31))),
                },
                DeviceStep::Report(what, which) => device_step(&mut device, now, report(*what, *which)),
            };
            for event in output.events() {
                if let device::Event::Store { store, .. } = event {
                    stores.push(*store);
                }
            }
            // Sometimes an answer of the buffer comes late.
            while stores.len() > usize::from(gap % 3 == 1) {
                let output = device_step(&mut device, now, device::Input::Rig(device::Report::Stored(stores.remove(0), AckCode::OK)));
                assert_eq!(output.transmits().filter(|transmit| transmit.id == id).count(), 1);
            }
        }
    }

    /// S-1, S-2
    #[test]
    fn a_host_keeps_its_laws_with_any_inputs(steps in host_steps(), options in options()) {
        let machine = HostMachine::new(options).with_last_id(100);
        let mut alone = Alone { host: Watched::new(machine), app: App::default(), now: Millis(0) };
        alone.tell(host::Input::LinkUp);
        alone.tell(host::Input::Received(MessageId(0), Hi { motor_count: 3, ..hi() }.into()));
        let _ = alone.command(Command::Configured);
        for (gap, step) in steps {
            alone.pass(gap);
            alone.act(&step);
        }
        // Each of twelve requests and of a sequence takes at most three tries of half a second.
        alone.pass(13 * 1500);
        // A sequence and its signal to start may go on.
        let followed = if alone.host.machine.progress().is_some() { 2 } else { 0 };
        assert!(alone.app.tokens.open().count() <= followed, "{:?}", alone.app.tokens);
        alone.tell(host::Input::LinkDown);
        assert_eq!(alone.app.tokens.open().count(), 0);
    }
}

/// Setup of a world, and the number of commands that were given so far.
#[derive(Debug, Clone)]
struct Script {
    options: host::Options,
    quirks: Quirks,
    line: BadLine,
    commands: usize,
}

/// Acts before all others, so that a host that wants motors to be enabled often has a move that it can follow.
fn prelude(options: &host::Options) -> impl Iterator<Item = Action> {
    let all = [Action::ConfigureAll(MotorFlags::ENABLED, MotorFlags::empty()), Action::Upload(true)];
    all.into_iter().filter(|_| options.needs_enabled())
}

/// Acts of the application and the operator, and the time after each of them, in milliseconds.
struct Actions;

impl ReferenceStateMachine for Actions {
    type State = Script;
    type Transition = (Action, u64);

    fn init_state() -> BoxedStrategy<Script> {
        (options(), any::<u32>().prop_map(Quirks), bad_line())
            .prop_map(|(options, quirks, line)| {
                let commands = prelude(&options).map(Action::commands).sum();
                Script { options, quirks, line, commands }
            })
            .boxed()
    }

    fn transitions(_: &Script) -> BoxedStrategy<(Action, u64)> {
        action()
    }

    fn apply(mut script: Script, (action, _): &(Action, u64)) -> Script {
        script.commands += action.commands();
        script
    }
}

struct Together;

impl StateMachineTest for Together {
    type SystemUnderTest = World;
    type Reference = Actions;

    fn init_test(script: &Script) -> World {
        let mut world = World::new(script.options, script.quirks, script.line.clone());
        for action in prelude(&script.options) {
            world.act(action);
            world.pass(1000);
        }
        world
    }

    fn apply(mut world: World, _: &Script, (action, gap): (Action, u64)) -> World {
        world.act(action);
        world.pass(gap);
        world
    }

    /// Each command is open or has ended, and not both.
    fn check_invariants(world: &World, script: &Script) {
        assert_eq!(world.open().len() + world.ended.len(), script.commands);
        assert!(world.open().iter().all(|token| !world.ended.contains_key(token)));
    }

    fn teardown(mut world: World, _: Script) {
        world.settle();
    }
}

prop_state_machine! {
    /// S-1, S-2, S-3, S-7, D-71, D-73, D-76, D-84, D-90
    #[test]
    fn a_host_and_a_device_keep_their_laws_over_a_bad_line(sequential 1..25 => Together);
}

/// The test above reaches every state, and most sequences still end well.
#[test]
fn over_a_bad_line_every_state_and_every_end_is_reached() {
    let mut runner = TestRunner::deterministic();
    let (mut states, mut progress) = (HashSet::new(), HashSet::new());
    let mut outcomes = HashMap::<_, u32>::new();
    for _ in 0..300 {
        let (actions, line) = (vec(action(), 0..25), bad_line()).new_tree(&mut runner).unwrap().current();
        let mut world = World::new(host::Options::default().with_needs_enabled(false), Quirks(0), line);
        for (action, gap) in actions {
            world.act(action);
            world.pass(gap);
        }
        world.settle();
        states.extend(world.seen.0);
        progress.extend(world.seen.1);
        for outcome in world.ended.into_values() {
            *outcomes.entry(outcome).or_default() += 1;
        }
    }
    assert_eq!(states, State::ALL.into());
    assert_eq!(progress, Progress::ALL.into());
    println!("{outcomes:?}");
    let others = [
        Outcome::Done(None),
        Outcome::Sent,
        Outcome::NotConfirmed,
        Outcome::Failed(Failure::Stopped),
        Outcome::Failed(Failure::HardStop),
        Outcome::Failed(Failure::LinkDown),
        Outcome::Refused(Refusal::Busy),
    ];
    for outcome in others.map(Some).into_iter().chain([None]) {
        assert!(outcomes.get(&outcome).is_some_and(|&times| times >= 10), "{outcome:?}: {outcomes:?}");
    }
}

/// The device follows the specification, or has every quirk.
#[test]
fn over_a_good_line_every_command_is_done() {
    for quirks in [Quirks(0), Quirks::VENDOR] {
        let mut world = World::new(host::Options::default(), quirks, BadLine::default());
        for (action, gap) in [
            (Action::ConfigureAll(MotorFlags::ENABLED, MotorFlags::ENABLED | MotorFlags::LIVE), 100),
            (Action::Upload(true), 500),
            (Action::ToFrame(1), 3000),
            (Action::Run(RunFlags(0)), 5000),
            (Action::Go, 5000),
            (Action::JogAll(3), 3000),
            (Action::Run(RunFlags::PING_PONG), 5000),
            (Action::OperatorGo, 5000),
            (Action::StopLoop, 20_000),
            (Action::Shot, 3000),
            (Action::Go, 10_000),
            (Action::Move(3), 1000),
        ] {
            world.act(action);
            world.pass(gap);
        }
        assert_eq!(world.ended.len(), 13);
        for (token, outcome) in &world.ended {
            assert!(matches!(outcome, None | Some(Outcome::Done(None))), "{token:?}: {outcome:?}");
        }
        assert_eq!((world.device().state(), world.host().is_loaded()), (State::Idle, Some(true)));
        world.settle();
    }
}
