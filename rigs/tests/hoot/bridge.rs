//! Two nodes on one bus: the one at the master's USB is the bridge to the other.

use hoot_proto::host::Nodes;
use hoot_proto::message::{self, AnySubAddress, Motor};
use hoot_proto::{Address, HostMessage, device, host};
use motion_core::time::Millis;
use rigs::faults::Faults;
use rigs::hoot_node::{HootNode, Setup};
use rigs::motor::Motor as RigMotor;
use rigs::{LineId, Outgoing, Party, Rig};

use crate::world::{NODE, ONE, STATUS, STOP, Stage, ready, run};

const FAR: Address = Address(4);
const BUS: LineId = LineId(2);

/// Two nodes whose bus lines are joined. The master is at the first one's USB.
struct Chain {
    near: HootNode,
    far: HootNode,
    ready: std::collections::VecDeque<Outgoing>,
}

impl Chain {
    fn new(near: device::Options) -> Self {
        let far = device::Options::default().with_address(FAR);
        let [mut near, mut far] = [near, far].map(|device| HootNode::new(Setup::default().with_options(device)));
        near.open(Millis(0), BUS);
        far.open(Millis(0), BUS);
        Self { near, far, ready: std::collections::VecDeque::new() }
    }

    /// Carries what is on the bus.
    fn carry(&mut self, now: Millis) {
        loop {
            if let Some(out) = self.near.poll() {
                match out {
                    Outgoing::Bytes(BUS, bytes) => self.far.receive(now, BUS, &bytes),
                    out => self.ready.push_back(out),
                }
            } else if let Some(out) = self.far.poll() {
                if let Outgoing::Bytes(BUS, bytes) = out {
                    self.near.receive(now, BUS, &bytes);
                }
            } else {
                return;
            }
        }
    }
}

impl Party for Chain {
    fn open(&mut self, now: Millis, line: LineId) {
        self.near.open(now, line);
    }
    fn close(&mut self, now: Millis, line: LineId) {
        self.near.close(now, line);
    }
    fn receive(&mut self, now: Millis, line: LineId, bytes: &[u8]) {
        self.near.receive(now, line, bytes);
        self.carry(now);
    }
    fn advance(&mut self, now: Millis) {
        self.near.advance(now);
        self.far.advance(now);
        self.carry(now);
    }
    fn wake(&self) -> Option<Millis> {
        [self.near.wake(), self.far.wake()].into_iter().flatten().min()
    }
    fn poll(&mut self) -> Option<Outgoing> {
        self.ready.pop_front()
    }
}

impl Rig for Chain {
    const LINES: u8 = 1;
    fn motors(&self) -> &[RigMotor] {
        self.far.motors()
    }
    fn moment(&self) -> Option<f64> {
        self.far.moment()
    }
    fn reset(&mut self, now: Millis) {
        self.near.reset(now);
        self.near.open(now, BUS);
    }
    fn stall(&mut self, now: Millis) {
        self.far.stall(now);
    }
}

fn chain(near: device::Options) -> Stage<Chain> {
    let mut stage = Stage::new(Chain::new(near), Faults::NONE, 1);
    let nodes = Nodes::NONE.with(NODE).and_then(|nodes| nodes.with(FAR)).unwrap();
    stage.scene.command(host::Command::Nodes(nodes));
    stage
}

fn rest(stage: &Stage<Chain>) -> [bool; 2] {
    [&stage.scene.rig.near, &stage.scene.rig.far].map(|node| node.motors().iter().all(RigMotor::rests))
}

#[test]
fn requests_and_answers_pass_the_bridge() {
    let mut stage = chain(device::Options::default());
    for message in ready(Motor::Two, 1000.0) {
        assert!(stage.ask_to(FAR, message).is_done());
    }
    assert!(stage.ask_to(FAR, run(Motor::Two)).is_done());
    stage.pass(500);
    assert_eq!(rest(&stage), [true, false]);
    assert!(stage.ask_to(FAR, STOP).is_done());
    assert_eq!(rest(&stage), [true, true]);
}

/// A refusal looks like command 0, and bridges do not pass that on: it looks like silence.
#[test]
fn a_refusal_behind_a_bridge_is_silence() {
    let mut stage = chain(device::Options::default());
    let on = HostMessage::SetJoystickMode(message::SetJoystickMode { joystick_mode: true.into() });
    for node in [NODE, FAR] {
        assert!(stage.ask_to(node, on).is_done());
    }
    assert!(matches!(stage.ask_to(NODE, STATUS).outcome, host::Outcome::Refused(_)));
    assert!(stage.ask_to(FAR, STATUS).is_silence());
}

/// A broadcast stop would not pass: the master stops each node.
#[test]
fn a_broadcast_stop_reaches_each_node_all_the_same() {
    let mut stage = chain(device::Options::default());
    for node in [NODE, FAR] {
        for message in ready(ONE, 1000.0) {
            assert!(stage.ask_to(node, message).is_done());
        }
        assert!(stage.ask_to(node, run(ONE)).is_done());
    }
    stage.pass(200);
    assert_eq!(rest(&stage), [false, false]);
    let stop = message::BroadcastStop { sub_address: AnySubAddress(0) };
    stage.send_to(Address::BROADCAST, HostMessage::BroadcastStop(stop));
    stage.pass(1000);
    assert_eq!(rest(&stage), [true, true]);
}

#[test]
fn an_emergency_stop_confirms_both() {
    let mut stage = chain(device::Options::default().with_quirks(device::Quirks::FIRMWARE));
    for node in [NODE, FAR] {
        for motor in Motor::ALL {
            for message in ready(motor, 3000.0) {
                assert!(stage.ask_to(node, message).is_done());
            }
            assert!(stage.ask_to(node, run(motor)).is_done());
        }
    }
    stage.emergency_stop();
    assert_eq!(rest(&stage), [true, true]);
    assert!(!stage.scene.host.may_move());
}

/// An address is given to the far node; it is found there.
#[test]
fn the_far_node_moves_away() {
    let mut stage = chain(device::Options::default());
    let set = HostMessage::SetAddress(message::SetAddress { new_address: Address(9) });
    assert!(stage.ask_to(FAR, set).is_done());
    assert!(stage.ask_to(FAR, STATUS).is_silence());
    assert!(stage.ask_to(Address(9), STATUS).is_done());
}
