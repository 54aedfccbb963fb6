//! What was explored of a host and a device of Dragonframe DMC v2: docs/machines-dmc.md, «Explored».

use dmc_proto::host::Stop;
use dmc_proto::message::{Motor, RunFlags};
use models::dmc::{Dmc, Mishaps, Spoilt, Want};
use models::line::Faults;
use stateright::{Checker, Model};

const SMALL: Dmc = Dmc {
    before: Some(&[]),
    wants: &[Want::Move(1), Want::Stop(Stop::All)],
    line: Faults { lost: 1, corrupt: 0, doubled: 0 },
    mishaps: Mishaps { delays: 0, limits: 0, emergencies: 0, cuts: 0, boots: 0, operators: 0 },
    window: 1,
    spoilt: None,
};

/// Explores all of it, and says how much that was.
fn explore(name: &str, model: Dmc, least: usize, unreached: &[&str]) {
    let begin = std::time::Instant::now();
    let properties = model.properties();
    let checker = model.checker().threads(2).timeout(std::time::Duration::from_secs(40)).spawn_bfs().join();
    let (states, depth) = (checker.unique_state_count(), checker.max_depth());
    println!("{name}: done {} {states} states, depth {depth}, {:.1} s", checker.is_done(),begin.elapsed().as_secs_f32());
    for property in properties {
        match property.expectation {
            stateright::Expectation::Sometimes if unreached.contains(&property.name) => {
                checker.assert_no_discovery(property.name);
            }
            stateright::Expectation::Sometimes => drop(checker.assert_any_discovery(property.name)),
            _ => {
                if let Some(path) = checker.discovery(property.name) {
                    let last = path.last_state().clone();
                    panic!("{name}: {}: {:#?}\n{last:?}", property.name, path.into_actions());
                }
            }
        }
    }
    assert!(states >= least, "{states}");
}

const FEW: Faults = Faults { lost: 1, corrupt: 1, doubled: 1 };
const CALM: Mishaps = SMALL.mishaps;
const LOADED: Option<&[Want]> = Some(&[Want::Upload]);
const ON_FRAME: Option<&[Want]> = Some(&[Want::Upload, Want::ToFrame]);
const ONE: Stop = Stop::Motor(Motor(1));
const STOP: Want = Want::Stop(Stop::All);

#[test]
fn small() {
    explore("small", SMALL, 100, &["a stop is not confirmed"]);
}

#[test]
fn motors() {
    let mishaps = Mishaps { delays: 1, limits: 1, ..CALM };
    let wants = &[Want::Move(1), Want::Jog(2), Want::Stop(ONE), STOP];
    explore("motors", Dmc { wants, line: SMALL.line, mishaps, window: 2, ..SMALL }, 100, &[]);
}

#[test]
fn connection() {
    let mishaps = Mishaps { delays: 1, cuts: 1, boots: 1, ..CALM };
    explore("connection", Dmc { before: None, wants: &[Want::Jog(1), STOP], mishaps, line: SMALL.line, ..SMALL }, 100, &[]);
}

#[test]
fn upload() {
    let mishaps = Mishaps { delays: 1, cuts: 0, boots: 1, ..CALM };
    explore("upload", Dmc { wants: &[Want::Upload, STOP], line: FEW, mishaps, ..SMALL }, 100, &[]);
}

#[test]
fn run() {
    let mishaps = Mishaps { delays: 1, limits: 1, operators: 1, ..CALM };
    let wants = &[Want::Run(RunFlags(0)), STOP];
    explore("run", Dmc { before: LOADED, wants, line: SMALL.line, mishaps, ..SMALL }, 100, &[]);
}

#[test]
fn shot() {
    let mishaps = Mishaps { delays: 1, emergencies: 1, operators: 1, ..CALM };
    let wants = &[Want::Shoot, STOP, Want::ToFrame];
    explore("shot", Dmc { before: LOADED, wants, line: SMALL.line, mishaps, ..SMALL }, 100, &[]);
}

#[test]
fn jog_all() {
    let mishaps = Mishaps { delays: 1, limits: 1, ..CALM };
    let wants = &[Want::JogAll, Want::Stop(ONE), Want::Move(2)];
    explore("jog_all", Dmc { before: ON_FRAME, wants, line: SMALL.line, mishaps, ..SMALL }, 100, &[]);
}

#[test]
fn loops() {
    let mishaps = Mishaps { delays: 1, ..CALM };
    let wants = &[Want::Run(RunFlags::LOOP), Want::StopLoop, STOP];
    explore("loops", Dmc { before: LOADED, wants, line: SMALL.line, mishaps, ..SMALL }, 100, &[]);
}
