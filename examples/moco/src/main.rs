//! Program for motion-control rigs: `moco inspect`, `moco plot`, `moco one-move`, `moco simulate` and `moco drive`.
//!
//! The library of this package describes the commands.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};
use clap_complete::Shell;
use examples::program::{Failure, STATUSES, run, written};
use moco::program::{interrupts, log};
use moco::{drive, one_move, plot, simulate};
use tokio::sync::mpsc::UnboundedReceiver;
use tracing::Level;
use tracing_appender::non_blocking::WorkerGuard;

const NAME: &str = "moco";

/// Inspect, plan, simulate and drive motion-control rigs
#[derive(Parser)]
#[command(name = NAME, version, propagate_version = true, after_help = STATUSES)]
struct Moco {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Inspect(examples::cli::Args),
    Plot(plot::Args),
    OneMove(one_move::Args),
    Simulate(simulate::Args),
    Drive(drive::program::Args),
    /// Print completions for a shell
    Completions {
        /// Shell that reads the completions
        shell: Shell,
    },
    /// Write the manual: a page for each command
    Man {
        /// Folder for the pages
        folder: PathBuf,
    },
}

fn main() -> ExitCode {
    run(NAME, |Moco { command }| match command {
        Command::Inspect(args) => examples::cli::end(examples::show::show(&args)),
        Command::Plot(args) => plot::plot(&args, &mut io::stdout().lock()),
        Command::OneMove(args) => one_move::one_move(&args, &mut io::stdout().lock()),
        Command::Simulate(args) => {
            let level = match args.verbose {
                0 => Level::INFO,
                1 => Level::DEBUG,
                _ => Level::TRACE,
            };
            in_real_time(log(level, args.json), false, async |interrupts| simulate::simulate(&args, interrupts).await)
        }
        Command::Drive(args) => {
            let level = match args.verbose {
                0 => Level::ERROR,
                1 => Level::INFO,
                2 => Level::DEBUG,
                _ => Level::TRACE,
            };
            in_real_time(log(level, args.json), true, async |interrupts| {
                Ok(drive::program::drive(&args, interrupts).await?)
            })
        }
        Command::Completions { shell } => completions(shell),
        Command::Man { folder } => man(&folder),
    })
}

/// Runs a command with its log, which is written to its end before the program prints a failure, and with Ctrl-C. With `terminal`, other keys of the terminal are handled as Ctrl-C.
#[tokio::main(flavor = "current_thread")]
async fn in_real_time(
    _log: WorkerGuard,
    terminal: bool,
    act: impl AsyncFnOnce(UnboundedReceiver<()>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let interrupts =
        interrupts(terminal).map_err(|error| Failure::not_done(format!("Ctrl-C cannot be handled: {error}")))?;
    Box::pin(act(interrupts)).await
}

fn completions(shell: Shell) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Moco::command(), NAME, &mut script);
    written(io::stdout().write_all(&script))
}

fn man(folder: &Path) -> Result<(), Failure> {
    let made = fs::create_dir_all(folder).and_then(|()| clap_mangen::generate_to(Moco::command(), folder));
    made.map_err(|error| Failure::not_done(format!("{}: {error}", folder.display())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Moco::command().debug_assert();
    }
}
