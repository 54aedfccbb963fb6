//! hoot, explored: `cargo test --test hoot -- --nocapture` prints how many states there were.

use std::time::Instant;

use hoot_proto::HostMessage;
use hoot_proto::device::{self, Quirks};
use hoot_proto::host;
use hoot_proto::message::{
    self, Direction, Motor, MotorMove, MotorRun, MotorSetContinuousSpeed, MotorSetEnable, MotorSetProgramStop,
    MotorSetSleep, MotorSetTravel, MotorStop, Span, StepCount, Steps, StepsPerSecond,
};
use models::hoot::{Flaw, Hoot, Wish};
use models::line::Faults;
use motion_core::wire::Bool;
use stateright::{Checker, HasDiscoveries, Model};

const GOOD: Faults = Faults { lost: 0, corrupt: 0, doubled: 0 };
const START: Wish = Wish::Request(HostMessage::Start(message::Start {}));
const STOP: Wish = Wish::Request(HostMessage::Stop(message::Stop {}));
const PAUSE: Wish = Wish::Request(HostMessage::Pause(message::Pause {}));
const HOME: Wish = Wish::Request(HostMessage::ReturnHome(message::ReturnHome {}));
const STATUS: Wish = Wish::Request(HostMessage::RunStatus(message::RunStatus {}));
const POWER_CYCLED: Wish = Wish::Request(HostMessage::PowerCycled(message::PowerCycled {}));

fn move_by(motor: Motor, steps: u32) -> Wish {
    let (direction, steps) = (Direction(1), StepCount(steps));
    Wish::Request(HostMessage::MotorMove(MotorMove { motor, direction, steps }))
}

fn run(motor: Motor) -> Wish {
    Wish::Request(HostMessage::MotorRun(MotorRun { motor, direction: Direction(0) }))
}

fn stop(motor: Motor) -> Wish {
    Wish::Request(HostMessage::MotorStop(MotorStop { motor }))
}

/// A node with two motors that can move, and with a program of one step for the second.
fn hoot(wishes: &[Wish]) -> Hoot {
    let on = |motor| {
        let speed = StepsPerSecond(500.0);
        [
            HostMessage::MotorSetEnable(MotorSetEnable { motor, enable: Bool::TRUE }),
            HostMessage::MotorSetContinuousSpeed(MotorSetContinuousSpeed { motor, speed }),
            HostMessage::MotorSetSleep(MotorSetSleep { motor, sleep: Bool::FALSE }),
        ]
    };
    let motor = Motor::Two;
    let plan = [
        HostMessage::MotorSetProgramStop(MotorSetProgramStop { motor, position: Steps(10) }),
        HostMessage::MotorSetTravel(MotorSetTravel { motor, travel: Span(1) }),
    ];
    Hoot {
        options: host::Options::default(),
        node: device::Options::default(),
        setup: [on(Motor::One), on(Motor::Two)].concat().into_iter().chain(plan).collect(),
        wishes: wishes.to_vec(),
        requests: GOOD,
        replies: GOOD,
        delay: 100,
        late: 0,
        flaw: Flaw::None,
    }
}

/// Explores all of it, and says how many states there were.
fn explore(name: &str, hoot: Hoot, least: usize, reached: &[&'static str]) {
    let start = Instant::now();
    let checker = hoot.checker().threads(2).spawn_bfs().join();
    let count = checker.unique_state_count();
    println!("{name}: {count} states, depth {}, {:.1} s", checker.max_depth(), start.elapsed().as_secs_f64());
    for (property, path) in checker.discoveries() {
        let is_failure = checker.discovery_classification(property).to_string() != "example";
        assert!(!is_failure, "{name}: {property}: {:#?}", path.into_actions());
    }
    for witness in reached {
        assert!(checker.discovery(witness).is_some(), "{name} never reaches: {witness}");
    }
    assert!(count >= least, "{name}: {count} states");
}

/// The property that finds what is wrong on purpose.
fn finds(hoot: Hoot, property: &'static str) {
    let checker = hoot.checker().threads(2).finish_when(HasDiscoveries::AnyFailures).spawn_bfs().join();
    let found = checker.discovery(property);
    assert!(found.is_some(), "{property}: not found, but {:?}", checker.discoveries().keys());
}

#[test]
fn one_move_one_emergency_one_loss() {
    let one = Faults { lost: 1, ..GOOD };
    let hoot = Hoot { requests: one, replies: one, ..hoot(&[move_by(Motor::One, 1), Wish::EmergencyStop]) };
    explore("small", hoot, 100, &["a request is done", "an emergency stop is confirmed", "a motor arrives"]);
}
