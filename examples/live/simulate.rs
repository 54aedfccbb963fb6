//! A simulated rig on a real transport.
//!
//! ```text
//! $ cargo run --example simulate -- kos --announce 127.0.0.1:5530
//! kOS rig at 127.0.0.1:5520
//! $ cargo run --example simulate -- dmc --quirks vendor --faults loss=0.01,delay=40
//! DMC rig at /dev/pts/0
//! $ cargo run --example simulate -- hoot --tcp --port 0 --record motors.csv
//! hoot rig at 127.0.0.1:37719
//! ```
//!
//! The line on standard output says where it is, once it can be reached. The log on standard error says what happens, in
//! seconds since it began; with `-v` each message. Ctrl-C ends it.

use std::process::ExitCode;

use live::program::{arguments, fail, interrupts, log};
use live::simulate::{Args, simulate};
use tracing::Level;

const NAME: &str = "simulate";

fn main() -> ExitCode {
    let args: Args = match arguments(NAME) {
        Ok(args) => args,
        Err(status) => return status,
    };
    let log = log(match args.verbose {
        0 => Level::INFO,
        1 => Level::DEBUG,
        _ => Level::TRACE,
    });
    let done = run(&args);
    drop(log);
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => fail(NAME, &why),
    }
}

#[tokio::main(flavor = "current_thread")]
async fn run(args: &Args) -> Result<(), String> {
    let interrupts = interrupts(false).map_err(|error| format!("Ctrl-C cannot be noticed: {error}"))?;
    Box::pin(simulate(args, interrupts)).await
}
