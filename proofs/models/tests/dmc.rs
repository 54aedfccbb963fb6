//! Exploration of host and device of Dragonframe DMC v2: docs/machines-dmc.md, «Explored».

use dmc_proto::device::Quirks;
use dmc_proto::host::StopTarget;
use dmc_proto::message::{Motor, RunFlags};
use laws::world::Faults;
use models::dmc::{Dmc, Mishaps, Spoilt, Want};
use stateright::{Checker, Expectation, Model, Path};
use std::time::Duration;

const LONGEST: Duration = Duration::from_secs(300);

const SMALL: Dmc = Dmc {
    before: Some(&[]),
    wants: &[Want::Move(1), Want::Stop(StopTarget::All)],
    line: Faults { lost: 1, corrupt: 0, doubled: 0 },
    mishaps: Mishaps { delays: 0, limits: 0, emergencies: 0, cuts: 0, boots: 0, operators: 0 },
    window: 1,
    quirks: Quirks::empty(),
    spoilt: None,
};

const FEW: Faults = Faults { lost: 1, corrupt: 1, doubled: 1 };
const CALM: Mishaps = SMALL.mishaps;
const LOADED: Option<&[Want]> = Some(&[Want::Upload]);
const ON_FRAME: Option<&[Want]> = Some(&[Want::Upload, Want::ToFrame]);
const ONE: StopTarget = StopTarget::Motor(Motor(1));
const STOP: Want = Want::Stop(StopTarget::All);
const UNCONFIRMED: &[&str] = &["a stop is not confirmed"];

/// Explores a setup completely, and prints the size. Every rule holds, and every state is reached except those in
/// `unreached`.
fn explore(name: &str, model: Dmc, least: usize, unreached: &[&str]) {
    let begin = std::time::Instant::now();
    let properties = model.properties();
    let checker = model.checker().threads(2).timeout(LONGEST).spawn_bfs().join();
    let (states, depth) = (checker.unique_state_count(), checker.max_depth());
    println!("{name}: {states} states, {depth} steps deep, {:.1} s", begin.elapsed().as_secs_f32());
    for property in properties {
        let found = checker.discovery(property.name);
        match property.expectation {
            Expectation::Sometimes => {
                assert_eq!(found.is_none(), unreached.contains(&property.name), "{name}: {}", property.name);
            }
            _ => assert!(found.is_none(), "{name}: {}: {:#?}", property.name, found.map(Path::into_actions)),
        }
    }
    assert!(checker.is_done(), "{name} takes too long");
    assert!(states >= least, "{name}: only {states} states");
}

/// Checks that the property finds a mistake in a machine.
fn finds(model: Dmc, property: &'static str) {
    let checker = model.checker().threads(2).timeout(LONGEST).spawn_bfs().join();
    assert!(checker.discovery(property).is_some(), "{property}");
}

#[test]
fn a_device_that_ignores_stops_is_found() {
    let spoilt = Some(Spoilt::DeafDevice);
    finds(Dmc { spoilt, ..SMALL }, "a stop is obeyed in the step of its arrival");
}

#[test]
fn a_host_that_repeats_a_jog_is_found() {
    let spoilt = Some(Spoilt::EagerHost);
    finds(Dmc { spoilt, wants: &[Want::Jog(1)], ..SMALL }, "a request that must not be repeated is sent once");
}

#[test]
fn a_host_that_holds_a_stop_back_is_found() {
    let spoilt = Some(Spoilt::LazyHost);
    finds(Dmc { spoilt, ..SMALL }, "a stop is sent first in the step of its request");
}

#[test]
fn small() {
    explore("small", SMALL, 100, UNCONFIRMED);
}

#[test]
fn stops() {
    let (line, mishaps) = (Faults { lost: 3, ..SMALL.line }, Mishaps { delays: 1, ..CALM });
    explore("stops", Dmc { wants: &[Want::Jog(1), STOP], line, mishaps, ..SMALL }, 5_000, &[]);
}

/// The device refuses stops while it is locked after a stop: the host learns from a status that the motors rest.
#[test]
fn refused_stops() {
    let (line, mishaps) = (Faults { lost: 1, ..SMALL.line }, Mishaps { delays: 2, ..CALM });
    let wants = &[Want::Jog(1), STOP, Want::Stop(StopTarget::AllSilent)];
    explore("refused stops", Dmc { wants, line, mishaps, quirks: Quirks::STOP_LOCKS, ..SMALL }, 1_000, &[]);
}

#[test]
fn motors() {
    let mishaps = Mishaps { delays: 1, limits: 1, ..CALM };
    let wants = &[Want::Move(1), Want::Jog(2), Want::Stop(ONE)];
    explore("motors", Dmc { wants, mishaps, window: 2, ..SMALL }, 300_000, UNCONFIRMED);
}

#[test]
fn connection() {
    let mishaps = Mishaps { delays: 1, cuts: 1, boots: 1, ..CALM };
    explore("connection", Dmc { before: None, wants: &[Want::Jog(1), STOP], mishaps, ..SMALL }, 300_000, &[]);
}

#[test]
fn upload() {
    let (line, mishaps) = (Faults { doubled: 0, ..FEW }, Mishaps { delays: 1, boots: 1, ..CALM });
    explore("upload", Dmc { wants: &[Want::Upload, STOP], line, mishaps, ..SMALL }, 500_000, &[]);
}

#[test]
fn run() {
    let mishaps = Mishaps { delays: 1, limits: 1, ..CALM };
    explore(
        "run",
        Dmc { before: LOADED, wants: &[Want::Run(RunFlags(0)), STOP], mishaps, ..SMALL },
        200_000,
        UNCONFIRMED,
    );
}

#[test]
fn shot() {
    let mishaps = Mishaps { delays: 1, emergencies: 1, operators: 1, ..CALM };
    explore("shot", Dmc { before: LOADED, wants: &[Want::Shoot, STOP], mishaps, ..SMALL }, 1_000_000, UNCONFIRMED);
}

#[test]
fn reset() {
    let mishaps = Mishaps { delays: 1, boots: 1, operators: 1, ..CALM };
    explore("reset", Dmc { wants: &[Want::Shoot, STOP], mishaps, ..SMALL }, 400_000, UNCONFIRMED);
}

#[test]
fn jog_all() {
    let mishaps = Mishaps { delays: 1, limits: 1, ..CALM };
    let wants = &[Want::JogAll, Want::Stop(ONE), Want::Move(2)];
    explore("jog_all", Dmc { before: ON_FRAME, wants, mishaps, ..SMALL }, 400_000, UNCONFIRMED);
}

#[test]
fn loops() {
    let mishaps = Mishaps { delays: 1, ..CALM };
    let wants = &[Want::Run(RunFlags::LOOP), Want::StopLoop, STOP];
    explore("loops", Dmc { before: LOADED, wants, mishaps, ..SMALL }, 150_000, UNCONFIRMED);
}

#[test]
fn damage() {
    let wants = &[Want::Move(1), Want::Jog(1), STOP];
    explore("damage", Dmc { wants, line: Faults { lost: 0, ..FEW }, ..SMALL }, 50_000, UNCONFIRMED);
}

#[test]
#[ignore = "minutes"]
fn deeper() {
    let mishaps = Mishaps { delays: 1, limits: 1, operators: 1, ..CALM };
    let wants = &[Want::Run(RunFlags(0)), STOP];
    explore("deeper run", Dmc { before: LOADED, wants, mishaps, ..SMALL }, 1_000_000, UNCONFIRMED);
    let mishaps = Mishaps { delays: 1, limits: 1, ..CALM };
    let wants = &[Want::Move(1), Want::Jog(2), Want::Stop(ONE), STOP];
    explore("deeper motors", Dmc { wants, mishaps, window: 2, ..SMALL }, 1_000_000, UNCONFIRMED);
}
