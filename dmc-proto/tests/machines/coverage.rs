//! Agreement of documents, tests and code about rows, decisions and states.

use std::collections::{BTreeMap, BTreeSet};

use dmc_proto::{device, host};

const DOCUMENT: &str = include_str!("../../../docs/machines-dmc.md");
const DECISIONS: &str = include_str!("../../../docs/decisions-dmc.md");

/// Files whose tests carry ids, with their names.
const SOURCES: [(&str, &str); 8] = [
    ("connection", include_str!("connection.rs")),
    ("failed_runs", include_str!("failed_runs.rs")),
    ("host", include_str!("host.rs")),
    ("may_move", include_str!("may_move.rs")),
    ("random", include_str!("random.rs")),
    ("real_time", include_str!("real_time.rs")),
    ("sequences", include_str!("sequences.rs")),
    ("stops", include_str!("stops.rs")),
];

/// Ids in the comments of tests, with the tests that carry them, as `file::test`.
fn tests() -> BTreeMap<String, BTreeSet<String>> {
    let mut found: BTreeMap<_, BTreeSet<_>> = BTreeMap::new();
    for (file, source) in SOURCES {
        let mut ids = vec![];
        for line in source.lines() {
            if let Some(comment) = line.trim().strip_prefix("/// ") {
                let words = comment.split([',', ' ', ':', '.']).filter(|word| is_id(word));
                ids.extend(words.map(str::to_owned));
            } else if let Some(name) = line.trim().strip_prefix("fn ") {
                let name = name.split('(').next().unwrap();
                for id in ids.drain(..) {
                    found.entry(id).or_default().insert(format!("{file}::{name}"));
                }
            }
        }
    }
    found
}

/// Whether a word is an id such as `D2-7`, `S-1` or `D-53`.
fn is_id(word: &str) -> bool {
    let Some((table, row)) = word.split_once('-') else { return false };
    ["D2", "D3", "D4", "D5", "S", "D"].contains(&table) && !row.is_empty() && row.bytes().all(|b| b.is_ascii_digit())
}

/// Rows of all tables of a document, cell by cell.
fn rows(document: &str) -> impl Iterator<Item = Vec<&str>> {
    document.lines().filter(|line| line.starts_with("| ")).map(|line| line.split('|').map(str::trim).collect())
}

/// Texts between backquotes.
fn quoted(cell: &str) -> impl Iterator<Item = &str> {
    cell.split('`').skip(1).step_by(2)
}

#[test]
fn every_row_has_its_test() {
    let tests = tests();
    let mut documented = BTreeSet::new();
    for row in rows(DOCUMENT).filter(|row| is_id(row[1])) {
        let (id, name) = (row[1], quoted(row[row.len() - 2]).next().unwrap());
        assert!(documented.insert(id.to_owned()), "{id} is in the document twice");
        let carriers = tests.get(id).unwrap_or_else(|| panic!("no test carries {id}"));
        assert!(
            carriers.iter().any(|test| test.ends_with(&format!("::{name}"))),
            "{id}: {name} is not in {carriers:?}"
        );
    }
    let carried: BTreeSet<_> = tests.into_keys().filter(|id| !id.starts_with("D-")).collect();
    assert_eq!(carried, documented, "the ids of the tests are those of the rows");
    assert_eq!(documented.len(), 24 + 27 + 7 + 25 + 7);
}

/// The decisions from D-53 on are about the machines.
#[test]
fn every_decision_has_its_test() {
    let tests = tests();
    let known: BTreeSet<_> = tests.values().flatten().map(String::as_str).collect();
    let mut documented = BTreeSet::new();
    let section = DECISIONS.split("### Of the state machines").nth(1).unwrap();
    for row in rows(section).filter(|row| row[1] != "id") {
        let named: Vec<_> = quoted(row[4]).collect();
        assert!(!named.is_empty(), "{row:?}");
        for test in named {
            assert!(known.contains(test), "{}: {test} does not exist, or carries no id", row[1]);
        }
        documented.extend(row[1].split(", ").filter(|id| is_id(id)).map(str::to_owned));
    }
    let of_machines = |id: &&String| id.strip_prefix("D-").and_then(|n| n.parse().ok()).is_some_and(|n: u32| n >= 53);
    let carried: BTreeSet<_> = tests.keys().filter(of_machines).cloned().collect();
    assert_eq!(carried, documented.iter().filter(of_machines).cloned().collect());
}

/// States that a diagram names.
fn diagram(number: usize) -> BTreeSet<&'static str> {
    let text = DOCUMENT.split("```mermaid").nth(number).unwrap().split("```").next().unwrap();
    let arrows = text.lines().filter_map(|line| line.split_once(" --> "));
    let ends = arrows.flat_map(|(from, to)| [from.trim(), to.split(':').next().unwrap().trim()]);
    ends.filter(|&state| state != "[*]").collect()
}

#[test]
fn every_state_is_in_its_diagram() {
    assert_eq!(diagram(1), device::State::ALL.map(device::State::name).into());
    assert_eq!(diagram(2), host::State::ALL.map(host::State::name).into());
    assert_eq!(diagram(3), host::Progress::ALL.map(host::Progress::name).into());
}

/// `cargo test -p dmc-proto --test machines sizes -- --nocapture` prints the sizes in bytes. The bounds show growth.
#[test]
fn sizes_are_known() {
    let sizes = [
        ("device machine", size_of::<device::DeviceMachine>(), 256),
        ("device effect", size_of::<device::Effect<'_>>(), 160),
        ("device output", size_of::<device::Output<'_>>(), 1024),
        ("host machine", size_of::<host::HostMachine>(), 1536),
        ("host effect", size_of::<host::Effect<'_>>(), 128),
        ("host output", size_of::<host::Output<'_>>(), 2816),
    ];
    for (what, size, bound) in sizes {
        println!("{what}: {size} bytes");
        assert!(size <= bound, "{what}: {size} bytes");
    }
}
