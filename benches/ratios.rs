//! Ratios between contenders that run in turn, in one process.
//!
//! The load and the clock rate of a machine change, so a time alone says little. Here every round runs
//! each contender once, one after the other. A ratio is calculated within one round, in which both had
//! the same conditions. The table shows the medians over all rounds.

use std::fmt::Write as _;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Contender: its name, and a closure that repeats its work a given number of times.
pub struct Contender<'a> {
    name: &'static str,
    repeat: Box<dyn FnMut(u32) + 'a>,
}

/// Makes a contender. Each call of `work` is one unit of work, and its result is not optimised
/// away. `work` must hide its input from the optimiser itself.
pub fn contender<'a, T>(name: &'static str, mut work: impl FnMut() -> T + 'a) -> Contender<'a> {
    let repeat = move |times| {
        for _ in 0..times {
            black_box(work());
        }
    };
    Contender { name, repeat: Box::new(repeat) }
}

/// Duration of a measurement.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    rounds: usize,
    /// Approximate time that a contender runs within a round.
    slice: Duration,
}

impl Effort {
    /// A few seconds for each row.
    const FULL: Self = Self { rounds: 301, slice: Duration::from_millis(1) };
    /// Some milliseconds for each row. It shows that everything runs, but measures nothing.
    const QUICK: Self = Self { rounds: 11, slice: Duration::from_micros(100) };

    /// Effort of some milliseconds for each row if `--test`, `--quick` or `BENCH_QUICK` is set, otherwise some seconds.
    #[must_use]
    pub fn from_env() -> Self {
        let asked = std::env::args().any(|arg| arg == "--test" || arg == "--quick");
        if asked || std::env::var_os("BENCH_QUICK").is_some() { Self::QUICK } else { Self::FULL }
    }
}

/// Table of ratios. Each row is printed after it is measured.
#[derive(Debug)]
pub struct Table {
    effort: Effort,
    columns: Vec<&'static str>,
}

/// Medians of one contender.
#[derive(Clone, Copy, Debug)]
struct Cell {
    nanos: f64,
    /// Time of the contender divided by the time of the first contender.
    ratio: f64,
}

impl Table {
    /// Starts a table and prints its title.
    #[must_use]
    pub fn new(title: &str) -> Self {
        println!("\n{title}: median time, and its ratio to the first column");
        Self { effort: Effort::from_env(), columns: Vec::new() }
    }

    /// Measures one row: all contenders with the same work. The first one is the reference of the ratios.
    pub fn row(&mut self, label: &str, mut contenders: Vec<Contender<'_>>) {
        let names: Vec<_> = contenders.iter().map(|c| c.name).collect();
        if names != self.columns {
            println!("{:>14} {}", "", names.iter().fold(String::new(), |line, name| line + &format!("{name:>22}")));
            self.columns = names;
        }
        let mut line = format!("{label:>14} ");
        for Cell { nanos, ratio } in measure(self.effort, &mut contenders) {
            write!(line, "{nanos:>11.2} ns {ratio:>6.2} x").expect("writing to a String does not fail");
        }
        println!("{line}");
    }
}

fn measure(effort: Effort, contenders: &mut [Contender<'_>]) -> Vec<Cell> {
    let times: Vec<u32> = contenders.iter_mut().map(|c| calibrate(c, effort.slice)).collect();
    // Nanoseconds for each unit of work: one list for each round, with one number for each contender.
    let rounds: Vec<Vec<f64>> = (0..effort.rounds)
        .map(|_| {
            contenders.iter_mut().zip(&times).map(|(c, &n)| time(c, n).as_secs_f64() * 1e9 / f64::from(n)).collect()
        })
        .collect();
    (0..contenders.len())
        .map(|i| Cell {
            nanos: median(rounds.iter().map(|round| round[i])),
            ratio: median(rounds.iter().map(|round| round[i] / round[0])),
        })
        .collect()
}

/// Number of repetitions of the work that fit into `slice`.
fn calibrate(contender: &mut Contender<'_>, slice: Duration) -> u32 {
    let mut times = 1;
    while time(contender, times) < slice {
        times *= 2;
    }
    times
}

fn time(contender: &mut Contender<'_>, times: u32) -> Duration {
    let start = Instant::now();
    (contender.repeat)(times);
    start.elapsed()
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<_> = values.collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
