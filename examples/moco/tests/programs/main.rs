//! Tests of the program: `moco simulate` and `moco drive` over loopback TCP, loopback UDP and pseudo-terminals.
#![cfg(unix)]

mod bad;
mod cable;
mod dmc;
mod foreign;
mod hoot;
mod kos;
mod others;
mod output;
mod process;
mod record;
mod serving;
mod terminal;

/// Runs all scenarios. Those with devices of another protocol and those with faults take longest, so they come first.
#[test]
fn scenarios() {
    let all = [kos::SCENARIOS, hoot::SCENARIOS, dmc::SCENARIOS].concat();
    let (faulty, clean): (Vec<_>, Vec<_>) = all.into_iter().partition(|(name, _)| name.contains("_faults_"));
    process::together(&[foreign::SCENARIOS, &faulty, &clean].concat());
}
