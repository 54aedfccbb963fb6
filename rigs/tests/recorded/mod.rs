//! Recorded answers of real firmware: the files of `vectors`, and the differences of a simulated device from them.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// Columns of each line of a table of `vectors`.
pub(crate) fn table<const COLUMNS: usize>(name: &str) -> Vec<[String; COLUMNS]> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../vectors/{name}.tsv"));
    let text = std::fs::read_to_string(path).unwrap();
    let row = |line: &str| {
        let columns: Vec<_> = line.split('\t').map(str::to_owned).collect();
        columns.try_into().unwrap_or_else(|columns| panic!("{name}: {columns:?}"))
    };
    text.lines().map(row).collect()
}

pub(crate) fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect()
}

pub(crate) fn hex(bytes: &[u8]) -> String {
    let mut hex = String::new();
    for byte in bytes {
        write!(hex, "{byte:02x}").unwrap();
    }
    hex
}

/// Reason, and the lines to which it applies.
pub(crate) type Known = (&'static str, &'static [usize]);

/// Checks that the lines whose answers differ are the known ones, and no more than one in a hundred.
pub(crate) fn check(device: &str, lines: usize, mut wrong: BTreeMap<usize, String>, known: &[Known]) {
    println!("{device}: {} of {lines} answers are equal", lines - wrong.len());
    assert!(wrong.len() * 100 <= lines, "{device}: {wrong:#?}");
    for (reason, numbers) in known {
        for number in *numbers {
            assert!(wrong.remove(number).is_some(), "{device}, line {number} is right now, not: {reason}");
        }
    }
    assert!(wrong.is_empty(), "{device}: {wrong:#?}");
}
