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
    let checker = model.checker().threads(2).spawn_bfs().join();
    let (states, depth) = (checker.unique_state_count(), checker.max_depth());
    println!("{name}: {states} states, depth {depth}, {:.1} s", begin.elapsed().as_secs_f32());
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

#[test]
fn small() {
    explore("small", SMALL, 100, &["a stop is not confirmed"]);
}
