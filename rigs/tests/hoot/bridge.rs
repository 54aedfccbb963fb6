//! Two nodes on one bus. The node at the USB port of the master is the bridge to the other node.

use hoot_proto::host::Nodes;
use hoot_proto::message::{self, Motor};
use hoot_proto::{Address, device, host};
use motion_core::time::Millis;
use motion_rigs::faults::Faults;
use motion_rigs::hoot_node::{HootNode, Setup};
use motion_rigs::motor::Motor as RigMotor;
use motion_rigs::{LineId, Outgoing, Party, Rig};

use crate::world::{NODE, ONE, STATUS, STOP, Stage, joystick, ready, run};

const FAR: Address = Address(4);
const BUS: LineId = LineId(2);

/// Two nodes whose bus lines are joined. The master is at the USB port of the first node.
struct Chain {
    near: HootNode,
    far: HootNode,
    ready: std::collections::VecDeque<Outgoing>,
}

impl Chain {
    fn new(near: device::Options) -> Self {
        let far = device::Options::new().with_address(FAR);
        let [mut near, mut far] = [near, far].map(|device| HootNode::new(Setup::default().with_options(device)));
        near.open(Millis(0), BUS);
        far.open(Millis(0), BUS);
        Self { near, far, ready: std::collections::VecDeque::new() }
    }

    /// Carries the bytes on the bus.
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
    stage.command(host::Command::Nodes(nodes));
    stage
}

fn rest(stage: &Stage<Chain>) -> [bool; 2] {
    [&stage.scene.rig.near, &stage.scene.rig.far].map(|node| node.motors().iter().all(RigMotor::rests))
}

#[test]
fn a_bridge_forwards_requests_and_answers() {
    let mut stage = chain(device::Options::new());
    for message in ready(Motor::Two, 1000.0) {
        assert!(stage.ask_to(FAR, message).is_done());
    }
    assert!(stage.ask_to(FAR, run(Motor::Two)).is_done());
    stage.pass(500);
    assert_eq!(rest(&stage), [true, false]);
    assert!(stage.ask_to(FAR, STOP).is_done());
    assert_eq!(rest(&stage), [true, true]);
}

/// A refusal looks like command 0, which bridges do not forward.
#[test]
fn a_refusal_behind_a_bridge_looks_like_silence() {
    let mut stage = chain(device::Options::new());
    for node in [NODE, FAR] {
        assert!(stage.ask_to(node, joystick(true)).is_done());
    }
    let refused = stage.ask_to(NODE, STATUS);
    assert!(matches!(refused.outcome(), host::Outcome::Refused(host::Refusal::Device(_))), "{refused}");
    assert!(stage.ask_to(FAR, STATUS).is_unanswered());
}

/// A bridge would not forward a broadcast, so the master stops each node.
#[test]
fn a_broadcast_stop_reaches_each_node_through_a_bridge() {
    let mut stage = chain(device::Options::new());
    for node in [NODE, FAR] {
        for message in ready(ONE, 1000.0) {
            assert!(stage.ask_to(node, message).is_done());
        }
        assert!(stage.ask_to(node, run(ONE)).is_done());
    }
    stage.pass(200);
    assert_eq!(rest(&stage), [false, false]);
    stage.send_to(Address::BROADCAST, message::BroadcastStop::default());
    stage.pass(1000);
    assert_eq!(rest(&stage), [true, true]);
}

#[test]
fn an_emergency_stop_is_confirmed_when_both_nodes_rest() {
    let mut stage = chain(device::Options::new().with_quirks(device::Quirks::FIRMWARE));
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
    assert!(!stage.may_move());
}

#[test]
fn the_far_node_is_found_at_its_new_address() {
    let mut stage = chain(device::Options::new());
    assert!(stage.ask_to(FAR, message::SetAddress { new_address: Address(9) }).is_done());
    assert!(stage.ask_to(FAR, STATUS).is_unanswered());
    assert!(stage.ask_to(Address(9), STATUS).is_done());
}
