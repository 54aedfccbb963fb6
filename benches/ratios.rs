//! Ratios between contenders that run in turn, in one process.
//!
//! The load and the clock rate of a machine change, so a time alone says little. Here every round runs
//! each contender once, one after the other. A ratio is calculated within one round, in which both had
//! the same conditions. The tables show the medians over all rounds.

use std::fmt::Write as _;
use std::hint::black_box;
use std::time::{Duration, Instant};

use crate::report::{Report, Row, versioned};

/// Contender: its name, and a closure that repeats its work a given number of times and returns the time.
pub struct Contender<'a> {
    pub(crate) name: &'static str,
    pub(crate) repeat: Box<dyn FnMut(u32) -> Duration + 'a>,
    /// Number of units, as messages or bytes, in one call of the work.
    units: u32,
}

/// Makes a contender. Each call of `work` is one unit of work, and its result is not optimised
/// away. `work` must hide its input from the optimiser itself.
pub fn contender<'a, T>(name: &'static str, mut work: impl FnMut() -> T + 'a) -> Contender<'a> {
    timed(name, move |times| {
        let start = Instant::now();
        for _ in 0..times {
            black_box(work());
        }
        start.elapsed()
    })
}

/// Makes a contender that measures its own time.
pub fn timed<'a>(name: &'static str, repeat: impl FnMut(u32) -> Duration + 'a) -> Contender<'a> {
    Contender { name, repeat: Box::new(repeat), units: 1 }
}

impl Contender<'_> {
    /// The contender with times for each of the `units` in one call of its work.
    ///
    /// # Panics
    ///
    /// If there are more units than 32 bits hold.
    #[must_use]
    pub fn per(self, units: usize) -> Self {
        Self { units: units.try_into().expect("32 bits are enough"), ..self }
    }
}

/// Duration of a measurement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    rounds: usize,
    /// Approximate time that a contender runs within a round.
    slice: Duration,
}

impl Effort {
    /// A few seconds for each row.
    pub(crate) const FULL: Self = Self { rounds: 301, slice: Duration::from_millis(1) };
    /// Some milliseconds for each row. It shows that everything runs, but measures nothing.
    pub(crate) const QUICK: Self = Self { rounds: 5, slice: Duration::from_micros(10) };
}

/// Table of ratios. Each row is printed after it is measured, and becomes part of the report.
#[derive(Debug)]
pub struct Table<'a> {
    report: &'a mut Report,
    title: &'static str,
    columns: Vec<&'static str>,
}

/// Results of one contender in one row: its name, and its time in each round, in nanoseconds.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    pub(crate) name: &'static str,
    pub(crate) rounds: Vec<f64>,
}

impl Cell {
    /// Median of the rounds.
    pub(crate) fn value(&self) -> f64 {
        median(self.rounds.iter().copied())
    }

    /// Median, over the rounds, of the time of `self` divided by that of `other`.
    pub(crate) fn over(&self, other: &Self) -> f64 {
        median(self.rounds.iter().zip(&other.rounds).map(|(ours, other)| ours / other))
    }
}

impl<'a> Table<'a> {
    /// Starts a table and prints its title.
    pub(crate) fn new(report: &'a mut Report, title: &'static str) -> Self {
        println!("\n{title}: median, and its ratio to the first column");
        Self { report, title, columns: Vec::new() }
    }

    /// Measures one row: all contenders with the same work. The first one is the reference of the printed ratios.
    pub fn row(&mut self, label: &str, mut contenders: Vec<Contender<'_>>) {
        if self.report.repeat(self.title, label, &mut contenders) {
            return;
        }
        let cells = measure(self.report.effort(), &mut contenders);
        self.add(label, " ns", cells);
    }

    /// Adds a row of numbers that are known without a clock.
    pub fn numbers(&mut self, label: &str, numbers: &[(&'static str, f64)]) {
        let cells: Vec<_> = numbers.iter().map(|&(name, number)| Cell { name, rounds: vec![number] }).collect();
        self.add(label, "", cells);
    }

    /// Prints a row and adds it to the report.
    fn add(&mut self, label: &str, unit: &'static str, cells: Vec<Cell>) {
        let names: Vec<_> = cells.iter().map(|cell| cell.name).collect();
        if names != self.columns {
            let head: Vec<_> = names.iter().map(|name| format!("{:>23}", versioned(name))).collect();
            println!("{:>18}  {}", "", head.join(" "));
            self.columns = names;
        }
        let mut line = format!("{label:>18} ");
        for cell in &cells {
            let (value, ratio) = (format!("{:.2}{unit}", cell.value()), cell.over(&cells[0]));
            write!(line, "{value:>14} {ratio:>7.2} x").expect("writing to a String does not fail");
        }
        println!("{line}");
        self.report.add(Row { table: self.title, label: label.into(), unit, cells });
    }
}

fn measure(effort: Effort, contenders: &mut [Contender<'_>]) -> Vec<Cell> {
    let times: Vec<u32> = contenders.iter_mut().map(|c| calibrate(c, effort.slice)).collect();
    let mut cells: Vec<_> = contenders.iter().map(|c| Cell { name: c.name, rounds: Vec::new() }).collect();
    for _ in 0..effort.rounds {
        for ((contender, &times), cell) in contenders.iter_mut().zip(&times).zip(&mut cells) {
            let units = f64::from(times) * f64::from(contender.units);
            cell.rounds.push((contender.repeat)(times).as_secs_f64() * 1e9 / units);
        }
    }
    cells
}

/// Number of repetitions of the work that fit into `slice`.
fn calibrate(contender: &mut Contender<'_>, slice: Duration) -> u32 {
    let mut times = 1;
    while (contender.repeat)(times) < slice {
        times *= 2;
    }
    times
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<_> = values.collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
