//! Draws a move file: position, velocity and acceleration of each axis over time. Try it with `--help`.

use std::io;
use std::process::ExitCode;

use plot::cli;

fn main() -> ExitCode {
    cli::exit(cli::run(std::env::args_os(), &mut io::stdout().lock()))
}
