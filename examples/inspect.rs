//! Program that shows the frames of a motion-control rig as typed messages.
//!
//! Run it without arguments first, then with `--help`. It is also a part of the program `moco`.

use std::process::ExitCode;

use examples::cli::{Args, end};
use examples::program::run;
use examples::show::show;

fn main() -> ExitCode {
    run("inspect", |args: Args| end(show(&args)))
}
