//! Exploration of hoot. `cargo test --test hoot -- --nocapture` prints the number of states.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::time::Instant;

use hoot_proto::HostMessage;
use hoot_proto::device::{self, Quirks};
use hoot_proto::host;
use hoot_proto::message::{
    Bool, BroadcastStart, BroadcastStop, Direction, Motor, MotorMove, MotorRun, MotorSetContinuousSpeed,
    MotorSetEnable, MotorSetProgramStop, MotorSetSleep, MotorSetTravel, MotorStop, Pause, PowerCycled, ReturnHome,
    RunStatus, SetJoystickMode, SetManualMove, Span, Start, StepCount, Steps, StepsPerSecond, Stop,
};
use laws::world::Faults;
use models::hoot::{Flaw, Hoot, Wish, World};
use stateright::{Checker, HasDiscoveries, Model};

const DONE: &str = "a request is done";
const SILENCE: &str = "a silence is reported";
const REFUSED: &str = "a refusal is reported";
const CONFIRMED: &str = "an emergency stop is confirmed";
const UNSURE: &str = "a stop is not confirmed";
const NOBODYS: &str = "a reply belongs to no request";
const ARRIVED: &str = "a motor arrives";
const ENDED: &str = "a program ends";

const GOOD: Faults = Faults { lost: 0, corrupt: 0, doubled: 0 };

fn request(message: impl Into<HostMessage<'static>>) -> Wish {
    Wish::Request(message.into())
}

fn move_by(motor: Motor, steps: u32) -> Wish {
    request(MotorMove { motor, direction: Direction(1), steps: StepCount(steps) })
}

fn run(motor: Motor) -> Wish {
    request(MotorRun { motor, direction: Direction(0) })
}

fn stop(motor: Motor) -> Wish {
    request(MotorStop { motor })
}

/// Setup of a node with two enabled motors, and with a program of one step for the second.
fn hoot(wishes: &[Wish]) -> Hoot {
    let on = |motor| -> [HostMessage<'static>; 3] {
        let speed = StepsPerSecond(500.0);
        [
            MotorSetEnable { motor, enable: Bool::TRUE }.into(),
            MotorSetContinuousSpeed { motor, speed }.into(),
            MotorSetSleep { motor, sleep: Bool::FALSE }.into(),
        ]
    };
    let motor = Motor::Two;
    let plan: [HostMessage<'static>; 2] =
        [MotorSetProgramStop { motor, position: Steps(10) }.into(), MotorSetTravel { motor, travel: Span(1) }.into()];
    Hoot {
        options: host::Options::new(),
        node: device::Options::new(),
        setup: [on(Motor::One), on(Motor::Two)].concat().into_iter().chain(plan).collect(),
        wishes: wishes.to_vec(),
        requests: GOOD,
        replies: GOOD,
        delay: 100,
        late: 0,
        flaw: Flaw::None,
    }
}

/// Explores a setup completely, and prints the number of states.
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

/// Checks that the property finds the mistake.
fn finds(hoot: Hoot, property: &'static str) {
    let checker = hoot.checker().threads(2).finish_when(HasDiscoveries::AnyFailures).spawn_bfs().join();
    let found = checker.discovery(property);
    assert!(found.is_some(), "{property}: not found, but {:?}", checker.discoveries().keys());
}

/// Follows every run to its end, without a checker. No state comes twice, so every run ends, and its end is settled.
fn ends(name: &str, hoot: &Hoot, least: usize) {
    let hash = |world: &World| {
        let mut hasher = DefaultHasher::new();
        world.hash(&mut hasher);
        hasher.finish()
    };
    // Whether a state is on the run that is being followed (`true`), or is finished (`false`).
    let mut on_the_way = HashMap::new();
    let mut stack: Vec<_> = hoot.init_states().into_iter().map(|world| (hash(&world), Some(world))).collect();
    while let Some((key, world)) = stack.pop() {
        let Some(world) = world else {
            on_the_way.insert(key, false);
            continue;
        };
        match on_the_way.get(&key) {
            Some(true) => panic!("{name}: a state comes again: {world:#?}"),
            Some(false) => {}
            None => {
                on_the_way.insert(key, true);
                stack.push((key, None));
                stack.extend(hoot.next_states(&world).into_iter().map(|next| (hash(&next), Some(next))));
            }
        }
    }
    println!("{name}: every run through {} states ends", on_the_way.len());
    assert!(on_the_way.len() >= least);
}

/// One packet is lost.
const BAD: Faults = Faults { lost: 1, corrupt: 0, doubled: 0 };
/// One packet is lost, one is damaged, and one comes twice. Only packets of the node come twice, because no fault
/// doubles a request.
const WORSE: Faults = Faults { lost: 1, corrupt: 1, doubled: 1 };

#[test]
fn every_run_comes_to_an_end() {
    let wishes = [run(Motor::One), Wish::EmergencyStop, request(Stop {})];
    ends("emergency", &Hoot { requests: BAD, replies: BAD, late: 2, ..hoot(&wishes) }, 60_000);
    let wishes = [request(Start {}), request(ReturnHome {}), stop(Motor::Two), Wish::LinkDown, Wish::LinkUp];
    ends("program", &Hoot { requests: BAD, replies: BAD, late: 1, ..hoot(&wishes) }, 65_000);
}

#[test]
fn mistakes_in_a_machine_are_found() {
    let one = || hoot(&[run(Motor::One), request(Stop {})]);
    finds(Hoot { flaw: Flaw::DeafToStops, ..one() }, "a stop that arrives is obeyed in the same step");
    finds(Hoot { flaw: Flaw::Polite, requests: BAD, ..one() }, "a stop waits for nothing but the gap");
    finds(Hoot { flaw: Flaw::Resends, requests: BAD, ..one() }, "a request that may not be repeated is sent once");
    finds(Hoot { flaw: Flaw::Forgets, ..one() }, "no command is forgotten");
    let hurried = Hoot { flaw: Flaw::Hurries, ..hoot(&[request(Start {}), request(Stop {})]) };
    finds(hurried, "two packets never wait at a deaf node");
    // If an answer to the run comes later than the master takes to be possible, it confirms the stop, which is lost.
    let late = |delay| Hoot { delay, late: 5, requests: BAD, ..hoot(&[run(Motor::One), stop(Motor::One)]) };
    finds(late(800), "motors that are confirmed to rest do not move");
    explore("late", late(650), 1000, &[NOBODYS]);
}

#[test]
fn one_move_one_emergency_one_loss() {
    let requests = Faults { lost: 1, corrupt: 1, doubled: 0 };
    let hoot = hoot(&[move_by(Motor::One, 1), Wish::EmergencyStop]);
    let hoot = Hoot { requests, replies: WORSE, late: 2, ..hoot };
    explore("one move", hoot, 200_000, &[DONE, CONFIRMED, UNSURE, ARRIVED, NOBODYS]);
}

#[test]
fn requests_and_stops() {
    let wishes = [run(Motor::One), move_by(Motor::One, 1), request(RunStatus {}), stop(Motor::One), request(Stop {})];
    let replies = Faults { doubled: 1, ..BAD };
    let mut hoot = hoot(&wishes);
    hoot.options = hoot.options.with_retries(1);
    explore("requests and stops", Hoot { requests: BAD, replies, late: 1, ..hoot }, 600_000, &[DONE, SILENCE, UNSURE]);
}

#[test]
fn programs_and_the_way_home() {
    let wishes = [request(Start {}), request(ReturnHome {}), request(Pause {}), request(Stop {})];
    let hoot = Hoot { requests: BAD, replies: BAD, late: 1, ..hoot(&wishes) };
    explore("programs", hoot, 400_000, &[DONE, ARRIVED, ENDED]);
}

#[test]
fn an_emergency_in_between() {
    let wishes = [run(Motor::One), request(PowerCycled {}), Wish::EmergencyStop, request(Stop {})];
    let hoot = Hoot { requests: BAD, replies: Faults { lost: 1, corrupt: 0, doubled: 1 }, late: 1, ..hoot(&wishes) };
    explore("emergency", hoot, 600_000, &[SILENCE, CONFIRMED]);
}
#[test]
fn firmware_in_joystick_mode() {
    let mut hoot =
        hoot(&[run(Motor::One), Wish::Speed(Motor::One, StepsPerSecond(0.0)), Wish::EmergencyStop, request(Stop {})]);
    hoot.node = hoot.node.with_quirks(Quirks::FIRMWARE);
    hoot.setup.push(SetJoystickMode { joystick_mode: Bool::TRUE }.into());
    for (bridge, told) in [(true, UNSURE), (false, REFUSED)] {
        let hoot =
            Hoot { options: hoot.options.with_bridge(bridge), requests: BAD, replies: BAD, late: 1, ..hoot.clone() };
        explore("firmware", hoot, 200_000, &[CONFIRMED, told]);
    }
}

#[test]
fn broadcasts_on_the_bus_itself() {
    let start = request(BroadcastStart::default());
    let stop = request(BroadcastStop::default());
    let mut hoot = hoot(&[start, stop, request(RunStatus {}), Wish::EmergencyStop]);
    hoot.options = hoot.options.with_bridge(false);
    explore("broadcasts", Hoot { requests: BAD, replies: BAD, late: 1, ..hoot }, 160_000, &[CONFIRMED, ENDED]);
}

/// Setup with the dead-man mode on.
fn manual(wishes: &[Wish]) -> Hoot {
    let mut hoot = hoot(wishes);
    hoot.setup.push(SetManualMove { manual_move: Bool::TRUE }.into());
    hoot
}

#[test]
fn dead_man_button_and_fault() {
    let hoot = manual(&[request(Start {}), run(Motor::One), stop(Motor::One), Wish::Button, Wish::Fault(Motor::Two)]);
    explore("dead-man", Hoot { requests: BAD, replies: BAD, late: 1, ..hoot }, 40_000, &[DONE, ENDED]);
}

/// This setup has no program, because its run time would grow for ever.
#[test]
fn a_node_that_is_kept_alive() {
    let speed = Wish::Speed(Motor::One, StepsPerSecond(0.0));
    let hoot = manual(&[Wish::KeepAlive, run(Motor::One), speed, Wish::EmergencyStop]);
    explore("keep-alive", Hoot { requests: BAD, late: 1, ..hoot }, 24_000, &[SILENCE, CONFIRMED]);
}

#[test]
fn the_line_goes_and_comes() {
    let wishes = [
        move_by(Motor::One, 1),
        Wish::LinkDown,
        Wish::LinkUp,
        Wish::EmergencyStop,
        Wish::EndEmergency,
        request(Stop {}),
    ];
    let hoot = Hoot { requests: BAD, late: 1, ..hoot(&wishes) };
    explore("link", hoot, 55_000, &[CONFIRMED, UNSURE, ARRIVED]);
}

/// The program is started while the line is down, and its answer comes when the line is up again.
#[test]
fn another_master_starts_the_program() {
    let wishes =
        [Wish::LinkDown, Wish::OtherStarts, Wish::LinkUp, request(RunStatus {}), request(Stop {}), stop(Motor::Two)];
    explore("another master", Hoot { requests: BAD, late: 1, ..hoot(&wishes) }, 150_000, &[DONE, UNSURE, NOBODYS]);
    let wishes = [Wish::LinkDown, Wish::OtherStarts, Wish::LinkUp, Wish::EmergencyStop];
    explore("another master", Hoot { late: 1, ..hoot(&wishes) }, 5000, &[CONFIRMED]);
    let hurried = [Wish::LinkDown, Wish::OtherStarts, Wish::LinkUp, request(Stop {})];
    finds(Hoot { flaw: Flaw::Hurries, ..hoot(&hurried) }, "two packets never wait at a deaf node");
}

/// Exploration that takes minutes: `cargo test --test hoot -- --ignored --nocapture`.
#[test]
#[ignore = "takes minutes"]
fn deeper() {
    let wishes = [
        run(Motor::One),
        request(Start {}),
        move_by(Motor::Two, 1),
        Wish::EmergencyStop,
        stop(Motor::One),
        request(Stop {}),
    ];
    let replies = Faults { doubled: 1, ..BAD };
    let hoot = Hoot { requests: BAD, replies, late: 1, ..hoot(&wishes) };
    explore("deeper", hoot, 14_000_000, &[DONE, CONFIRMED, ENDED]);
}
