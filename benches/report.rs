//! All rows of a run, the targets that are set for some of them, and the one table that says which are met.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Value, json};

use crate::ratios::{Cell, Contender, Effort, Table};
use crate::targets::TARGETS;

/// Manifest of the benches, which pins the version of each peer.
const MANIFEST: &str = include_str!("Cargo.toml");

/// Columns of the table of the targets.
const HEAD: [&str; 7] = ["row", "what", "ours", "peer", "ratio", "target", "met"];

/// Line of the table of the targets.
type Line = [String; 7];

/// Last run of a program: whether it was quick, its targets, and all its rows.
type Program = (bool, Vec<Line>, Vec<Value>);

/// Chapter of a program: its name, and the function that measures its rows.
pub type Chapter<'a> = (&'a str, fn(&mut Report));

/// Runs the chapters of a program that the arguments name, or all of them, and prints the table of the targets.
///
/// `--quick` and `--test` show that everything runs, and measure nothing. `count TABLE ROW CONTENDER TIMES` repeats the
/// work of one contender that many times, and measures nothing. The difference of two such runs under
/// `valgrind --tool=callgrind` is the number of instructions. `tmp` is the directory `CARGO_TARGET_TMPDIR`.
///
/// # Panics
///
/// If contenders find different values, or if the report cannot be written.
pub fn run(program: &str, tmp: &str, chapters: &[Chapter<'_>]) {
    let (options, args): (Vec<_>, Vec<_>) = std::env::args().skip(1).partition(|arg| arg.starts_with("--"));
    let quick = options.iter().any(|option| option == "--quick" || option == "--test");
    let (wanted, count) = match args.iter().position(|arg| arg == "count") {
        Some(at) => (&args[..at], args[at + 1..].first_chunk().cloned()),
        None => (&args[..], None),
    };
    let mut report = Report { quick, count, rows: Vec::new() };
    for (name, chapter) in chapters {
        if wanted.is_empty() || wanted.iter().any(|wanted| name.contains(wanted)) {
            chapter(&mut report);
        }
    }
    if report.count.is_none() {
        report.finish(program, &Path::new(tmp).with_file_name("ratios.json"));
    }
}

/// All rows that were measured.
#[derive(Debug)]
pub struct Report {
    /// Whether everything runs and nothing is measured.
    quick: bool,
    /// The only contender that runs, if instructions are counted: its table, row, name and number of repetitions.
    count: Option<[String; 4]>,
    rows: Vec<Row>,
}

/// Results of all contenders with the same work.
#[derive(Debug)]
pub(crate) struct Row {
    pub(crate) table: &'static str,
    pub(crate) label: String,
    pub(crate) unit: &'static str,
    pub(crate) cells: Vec<Cell>,
}

/// Targets of one contender in some rows of one table.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Name of the targets, as F1.
    pub id: &'static str,
    /// Title of the table.
    pub table: &'static str,
    /// Labels of the rows. If a label begins with a star, the target holds for the worst row whose label ends with the
    /// rest.
    pub rows: &'static [&'static str],
    /// Name of our contender.
    pub ours: &'static str,
    /// Bounds, each beside the contender with this name. Without a name, the bound is for our number itself.
    pub bounds: &'static [(&'static str, Bound)],
}

/// Bound of a ratio.
#[derive(Clone, Copy, Debug)]
pub enum Bound {
    /// Least speed: time of the other contender divided by our time.
    Speed(f64),
    /// Greatest cost: our number divided by that of the other contender, or our number itself.
    Cost(f64),
    /// No bound: the speed is reported.
    Shown,
}

/// One target, and the worst row that it is for.
struct Verdict<'a> {
    row: &'a Row,
    ours: &'a Cell,
    peer: Option<&'a Cell>,
    ratio: f64,
    bound: Bound,
}

impl Report {
    /// Starts a table. Its rows become part of the report.
    pub fn table(&mut self, title: &'static str) -> Table<'_> {
        Table::new(self, title)
    }

    pub(crate) fn effort(&self) -> Effort {
        if self.quick { Effort::QUICK } else { Effort::FULL }
    }

    /// Repeats the wanted contender, if the report counts instructions. Returns whether it does.
    pub(crate) fn repeat(&self, table: &str, label: &str, contenders: &mut [Contender<'_>]) -> bool {
        let Some([wanted @ .., times]) = &self.count else { return false };
        for contender in contenders.iter_mut().filter(|contender| *wanted == [table, label, contender.name]) {
            (contender.repeat)(times.parse().expect("a number of repetitions"));
        }
        true
    }

    pub(crate) fn add(&mut self, row: Row) {
        self.rows.push(row);
    }

    /// Adds rows and targets to the JSON file of all programs, and prints one table of their targets.
    fn finish(&self, program: &str, file: &Path) {
        let mut verdicts = Vec::new();
        for target in TARGETS.iter().filter(|target| self.rows.iter().any(|row| row.table == target.table)) {
            for label in target.rows {
                for &(peer, bound) in target.bounds {
                    match self.verdict(target, label, peer, bound) {
                        Some(verdict) => verdicts.push(verdict.line(target.id)),
                        None => println!("not measured: {}, {label}, {}, {peer}", target.id, target.ours),
                    }
                }
            }
        }
        let rows: Vec<_> = self.rows.iter().map(Row::json).collect();
        let mut all: BTreeMap<String, Program> =
            std::fs::read(file).ok().and_then(|text| serde_json::from_slice(&text).ok()).unwrap_or_default();
        all.retain(|_, (quick, ..)| *quick == self.quick);
        all.insert(program.into(), (self.quick, verdicts, rows));
        let text = serde_json::to_string_pretty(&all).expect("strings and numbers are JSON");
        std::fs::write(file, text + "\n").expect("the report can be written");
        let mut lines: Vec<_> = all.into_values().flat_map(|(_, lines, _)| lines).collect();
        lines.sort_by(|a, b| a[0].cmp(&b[0]));
        print(lines);
        println!("\nAll rows and targets as JSON: {}", file.display());
        if self.quick {
            println!("This was a quick run: everything runs, but the numbers say nothing.");
        }
    }

    /// Worst of the rows that a target is for.
    fn verdict(&self, target: &Target, label: &str, peer: &str, bound: Bound) -> Option<Verdict<'_>> {
        let is_meant = |row: &&Row| match label.strip_prefix('*') {
            Some(end) => row.label.ends_with(end),
            None => row.label == label,
        };
        let rows = self.rows.iter().filter(|row| row.table == target.table).filter(is_meant);
        let verdicts = rows.filter_map(|row| {
            let ours = row.cell(target.ours)?;
            let peer = if peer.is_empty() { None } else { Some(row.cell(peer)?) };
            let ratio = match (peer, bound) {
                (None, _) => ours.value(),
                (Some(peer), Bound::Cost(_)) => ours.over(peer),
                (Some(peer), _) => peer.over(ours),
            };
            Some(Verdict { row, ours, peer, ratio, bound })
        });
        verdicts.max_by(|a, b| a.badness().total_cmp(&b.badness()))
    }
}

impl Row {
    fn cell(&self, name: &str) -> Option<&Cell> {
        self.cells.iter().find(|cell| cell.name == name)
    }

    fn json(&self) -> Value {
        let cells = self.cells.iter().map(|cell| json!({ "name": versioned(cell.name), "median": cell.value() }));
        json!({ "table": self.table, "row": self.label, "contenders": cells.collect::<Vec<_>>() })
    }
}

impl Verdict<'_> {
    /// Part by which the target is missed. It is negative if the target is met.
    fn badness(&self) -> f64 {
        match self.bound {
            Bound::Speed(least) => least / self.ratio - 1.0,
            Bound::Cost(most) => self.ratio / most - 1.0,
            Bound::Shown => -self.ratio,
        }
    }

    fn target(&self) -> String {
        match self.bound {
            Bound::Speed(least) => format!(">= {least}"),
            Bound::Cost(most) => format!("<= {most}"),
            Bound::Shown => String::new(),
        }
    }

    fn met(&self) -> String {
        match self.bound {
            Bound::Shown => "reported".into(),
            _ if self.badness() <= 0.0 => "met".into(),
            _ => format!("missed by {:.0} %", (self.badness() * 100.0).ceil()),
        }
    }

    fn line(&self, id: &str) -> Line {
        let number = |cell: &Cell| format!("{}: {:.2}{}", versioned(cell.name), cell.value(), self.row.unit);
        [
            id.into(),
            format!("{}, {}", self.row.table, self.row.label),
            number(self.ours),
            self.peer.map(number).unwrap_or_default(),
            format!("{:.2}", self.ratio),
            self.target(),
            self.met(),
        ]
    }
}

fn print(mut lines: Vec<Line>) {
    lines.insert(0, HEAD.map(String::from));
    let widths: [usize; 7] = std::array::from_fn(|at| lines.iter().map(|line| line[at].len()).max().unwrap_or(0));
    println!();
    for (number, line) in lines.iter().enumerate() {
        let cells: Vec<_> = line.iter().zip(widths).map(|(cell, width)| format!("{cell:width$}")).collect();
        println!("| {} |", cells.join(" | "));
        if number == 0 {
            println!("|{}|", widths.map(|width| "-".repeat(width + 2)).join("|"));
        }
    }
}

/// Name of a contender. If its first word is a package that the manifest pins, its version follows.
pub(crate) fn versioned(name: &str) -> String {
    let (package, rest) = name.split_at(name.find([' ', ',']).unwrap_or(name.len()));
    let pin = MANIFEST.lines().find_map(|line| line.strip_prefix(package)?.strip_prefix(" = ")?.split_once("\"="));
    match pin.and_then(|(_, pin)| pin.split('"').next()) {
        Some(version) => format!("{package} {version}{rest}"),
        None => name.into(),
    }
}
