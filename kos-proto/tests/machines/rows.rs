//! The document of the machines, the tests and the code agree.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use kos_proto::device::{Link, clients, motor, playback};
use kos_proto::host;

type Rows = BTreeMap<String, BTreeSet<String>>;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn document() -> String {
    fs::read_to_string(root().join("../docs/machines-kos.md")).unwrap()
}

/// Ids of rows, `7.4-12`, in a text.
fn ids(text: &str) -> impl Iterator<Item = String> {
    text.split(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-')).filter_map(|word| {
        let (table, row) = word.trim_end_matches(['.', '-']).split_once('-')?;
        let is_row = table.len() == 3 && table.starts_with("7.") && !row.is_empty() && !row.contains(['.', '-']);
        is_row.then(|| format!("{table}-{row}"))
    })
}

/// Tests by the ids in their comments.
fn tests() -> Rows {
    let mut rows = Rows::new();
    for entry in fs::read_dir(root().join("tests/machines")).unwrap() {
        let path = entry.unwrap().path();
        let Some(file) = path.file_stem().filter(|_| path.extension().is_some_and(|ext| ext == "rs")) else { continue };
        let (mut comment, mut is_test) = (String::new(), false);
        for line in fs::read_to_string(&path).unwrap().lines().map(str::trim) {
            if let Some(text) = line.strip_prefix("///") {
                comment.push_str(text);
            } else if line.starts_with("#[") {
                is_test |= line == "#[test]";
            } else {
                if let Some(name) = line.strip_prefix("fn ").and_then(|rest| rest.split('(').next()).filter(|_| is_test)
                {
                    let test = format!("{}::{name}", file.to_str().unwrap());
                    for id in ids(&comment) {
                        rows.entry(id).or_default().insert(test.clone());
                    }
                }
                comment.clear();
                is_test = false;
            }
        }
    }
    rows
}

#[test]
fn every_row_has_its_test() {
    let mut rows = Rows::new();
    for line in document().lines().filter(|line| line.starts_with("| 7.")) {
        let cells: Vec<_> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [id, _, _, _, _, tests] = cells[..] else { panic!("{line}") };
        let tests = tests.split(", ").map(|test| test.trim_matches('`').to_owned()).collect();
        assert!(rows.insert(id.to_owned(), tests).is_none(), "{id} is there twice");
    }
    assert_eq!(rows.len(), 128);
    let tests = tests();
    assert_eq!(rows.keys().collect::<Vec<_>>(), tests.keys().collect::<Vec<_>>());
    for (id, of_row) in &rows {
        assert_eq!(of_row, &tests[id], "{id}: the tests in the document, and those with this row");
    }
}

/// States of a diagram: both ends of its arrows.
fn drawn(document: &str, title: &str) -> BTreeSet<String> {
    let from = document.find(&format!("### {title}\n")).unwrap_or_else(|| panic!("{title} is not drawn"));
    let diagram = document[from..].split("```").nth(1).unwrap();
    let arrows = diagram.lines().filter_map(|line| line.split_once(" --> "));
    let ends = arrows.flat_map(|(from, to)| [from.trim(), to.split(':').next().unwrap().trim()]);
    ends.filter(|&state| state != "[*]").map(str::to_owned).collect()
}

#[test]
fn the_diagrams_show_exactly_the_states_of_the_code() {
    let document = document();
    let diagrams: [(&str, Vec<&str>); 8] = [
        ("Device: link", Link::ALL.map(Link::name).to_vec()),
        ("Device: session", clients::State::ALL.map(clients::State::name).to_vec()),
        ("Device: range of a motor", motor::State::ALL.map(motor::State::name).to_vec()),
        ("Device: motion by hand", motor::Motion::NAMES.to_vec()),
        ("Device: move", playback::State::ALL.map(playback::State::name).to_vec()),
        ("Client: connection", host::State::ALL.map(host::State::name).to_vec()),
        ("Client: a range", host::CalibrationState::ALL.map(host::CalibrationState::name).to_vec()),
        ("Client: move", host::MoveState::ALL.map(host::MoveState::name).to_vec()),
    ];
    assert_eq!(document.matches("stateDiagram-v2").count(), diagrams.len());
    for (title, states) in diagrams {
        let states = states.into_iter().map(str::to_owned).collect();
        assert_eq!(drawn(&document, title), states, "{title}");
    }
}

/// The sizes are printed. If one doubles, the test fails.
#[test]
fn the_machines_are_small() {
    let sizes = [
        ("DeviceMachine", size_of::<kos_proto::device::DeviceMachine>(), 768),
        ("device::Output", size_of::<kos_proto::device::Output<'_>>(), 4096),
        ("HostMachine", size_of::<host::HostMachine>(), 1536),
        ("host::Output", size_of::<host::Output<'_>>(), 5120),
    ];
    for (name, size, most) in sizes {
        println!("{name}: {size} bytes");
        assert!(size <= most, "{name} has {size} bytes");
    }
}
