//! Ratios between contenders that run in turn, in one process.
//!
//! Machines are noisy and clocks wander, so a time alone says little. Here every round runs each
//! contender once, one after the other, and a ratio is taken within the round, where both sides met
//! the same weather. The table shows the medians over all rounds.

use std::fmt::Write as _;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// One contender: its name, and a closure that repeats its work so many times.
pub struct Contender<'a> {
    name: &'static str,
    repeat: Box<dyn FnMut(u32) + 'a>,
}

/// Names a contender. Each call of `work` is one unit of work; what it returns is kept from being
/// optimised away. Hiding its input from the optimiser is for `work` to do.
pub fn contender<'a, T>(name: &'static str, mut work: impl FnMut() -> T + 'a) -> Contender<'a> {
    let repeat = move |times| {
        for _ in 0..times {
            black_box(work());
        }
    };
    Contender { name, repeat: Box::new(repeat) }
}

/// How long a measurement may take.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    rounds: usize,
    /// How long a contender runs within a round, about.
    slice: Duration,
}

impl Effort {
    /// A few seconds a row.
    const FULL: Self = Self { rounds: 301, slice: Duration::from_millis(1) };
    /// Some milliseconds a row: shows that everything runs, proves nothing.
    const QUICK: Self = Self { rounds: 11, slice: Duration::from_micros(100) };

    /// Quick where criterion is told to be quick (`--test`, `--quick`) or `BENCH_QUICK` is set.
    #[must_use]
    pub fn from_env() -> Self {
        let asked = std::env::args().any(|arg| arg == "--test" || arg == "--quick");
        if asked || std::env::var_os("BENCH_QUICK").is_some() { Self::QUICK } else { Self::FULL }
    }
}

/// A table of ratios, printed row by row as it is measured.
#[derive(Debug)]
pub struct Table {
    effort: Effort,
    columns: Vec<&'static str>,
}

/// What one contender's medians are.
#[derive(Clone, Copy, Debug)]
struct Cell {
    nanos: f64,
    /// How much longer it took than the first contender.
    ratio: f64,
}

impl Table {
    /// Starts a table and prints its title.
    #[must_use]
    pub fn new(title: &str) -> Self {
        println!("\n{title}: median time, and how much longer than the first column");
        Self { effort: Effort::from_env(), columns: Vec::new() }
    }

    /// Measures one row: all contenders on the same work, the one of interest first.
    pub fn row(&mut self, label: &str, mut contenders: Vec<Contender<'_>>) {
        let names: Vec<_> = contenders.iter().map(|c| c.name).collect();
        if names != self.columns {
            println!("{:>14} {}", "", names.iter().fold(String::new(), |line, name| line + &format!("{name:>22}")));
            self.columns = names;
        }
        let mut line = format!("{label:>14} ");
        for Cell { nanos, ratio } in measure(self.effort, &mut contenders) {
            write!(line, "{nanos:>11.2} ns {ratio:>6.2} x").expect("a String takes any text");
        }
        println!("{line}");
    }
}

fn measure(effort: Effort, contenders: &mut [Contender<'_>]) -> Vec<Cell> {
    let times: Vec<u32> = contenders.iter_mut().map(|c| calibrate(c, effort.slice)).collect();
    // Nanoseconds a unit of work: a list a round, a number a contender.
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

/// How often the work fits into `slice`.
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
