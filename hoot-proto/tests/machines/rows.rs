//! The table of rows is the table of tests, and its pictures show the states that there are.

use std::collections::{BTreeMap, BTreeSet};

use hoot_proto::device::{CameraState, MotorState, Phase, ProgramState};
use hoot_proto::host::{State, StopState};

const ROWS: &str = include_str!("../../../docs/machines-hoot.md");
const DECISIONS: &str = include_str!("../../../docs/decisions-hoot.md");
const TESTS: [&str; 12] = [
    include_str!("camera.rs"),
    include_str!("deaf.rs"),
    include_str!("emergency.rs"),
    include_str!("host.rs"),
    include_str!("joystick.rs"),
    include_str!("link.rs"),
    include_str!("motor.rs"),
    include_str!("moving.rs"),
    include_str!("program.rs"),
    include_str!("real.rs"),
    include_str!("settings.rs"),
    include_str!("stops.rs"),
];

/// Whether it looks like `4.2-12`.
fn is_id(word: &str) -> bool {
    let is_number = |text: &str| !text.is_empty() && text.chars().all(|c| c.is_ascii_digit() || c == '.');
    word.split_once('-').is_some_and(|(section, row)| is_number(section) && is_number(row))
}

/// Ids in the tests, with the names of the functions that they stand at.
fn tested() -> BTreeMap<&'static str, &'static str> {
    let mut found = BTreeMap::new();
    for lines in TESTS.map(|source| source.lines().collect::<Vec<_>>()) {
        for (at, line) in lines.iter().enumerate() {
            let Some(ids) = line.strip_prefix("// ").map(str::split_whitespace) else { continue };
            let name = lines[at..].iter().find_map(|line| line.strip_prefix("fn ")?.strip_suffix("() {"));
            for id in ids.filter(|word| is_id(word)) {
                assert_eq!(lines[at + 1], "#[test]", "{id}");
                assert_eq!(found.insert(id, name.unwrap()), None, "{id} twice");
            }
        }
    }
    found
}

/// Ids in the document, with the names of the tests behind them, and what decided them.
fn documented() -> (BTreeMap<&'static str, &'static str>, BTreeSet<&'static str>) {
    let (mut found, mut decisions) = (BTreeMap::new(), BTreeSet::new());
    for line in ROWS.lines() {
        let cells: Vec<_> = line.trim_matches('|').split('|').map(str::trim).collect();
        if let [id, .., decided, test] = cells[..] {
            if is_id(id) {
                assert_eq!(found.insert(id, test.trim_matches('`')), None, "{id} twice");
                decisions.extend(decided.split(", ").filter(|id| !id.is_empty()));
            }
        }
    }
    (found, decisions)
}

#[test]
fn every_row_has_its_test() {
    let (documented, decisions) = documented();
    assert_eq!(documented, tested());
    assert!(documented.len() > 100);
    for decision in decisions {
        let row = decision.replace("S-", "safety decision ");
        assert!(DECISIONS.contains(&format!("| {row} |")), "{decision} is no decision");
    }
}

fn names<S: Copy>(all: &[S], name: impl Fn(S) -> &'static str) -> BTreeSet<&'static str> {
    all.iter().map(|state| name(*state)).collect()
}

#[test]
fn every_diagram_shows_the_states_that_there_are() {
    let pictures: BTreeMap<&str, BTreeSet<&str>> = ROWS
        .split("```mermaid")
        .zip(ROWS.split("```mermaid").skip(1))
        .map(|(before, picture)| {
            let title = before.trim_end().lines().last().unwrap().trim_matches('`');
            let arrows =
                picture.split("```").next().unwrap().lines().filter_map(|line| line.trim().split_once(" --> "));
            let states = arrows.flat_map(|(from, to)| [from, to.split(':').next().unwrap()]);
            (title, states.collect())
        })
        .collect();
    let wanted = BTreeMap::from([
        ("device::CameraState", names(&CameraState::ALL, CameraState::name)),
        ("device::MotorState", names(&MotorState::ALL, MotorState::name)),
        ("device::Phase", names(&Phase::ALL, Phase::name)),
        ("device::ProgramState", names(&ProgramState::ALL, ProgramState::name)),
        ("host::State", names(&State::ALL, State::name)),
        ("host::StopState", names(&StopState::ALL, StopState::name)),
    ]);
    assert_eq!(pictures, wanted);
}
