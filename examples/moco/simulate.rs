//! Program that runs a simulated rig on a real transport.
//!
//! ```text
//! $ cargo run --example simulate -- kos --announce 127.0.0.1:5530
//! kOS rig at 127.0.0.1:5520
//! $ cargo run --example simulate -- dmc --device servo --faults loss=0.01,delay=40
//! DMC rig at /dev/pts/0
//! $ cargo run --example simulate -- hoot --tcp --port 0 --record motors.csv
//! hoot rig at 127.0.0.1:37719
//! ```
//!
//! The line on standard output gives the address of the rig, as soon as clients can connect. The log on standard error
//! reports what happens, with the seconds since the start. With `-v` it contains each message. Ctrl-C ends the program.

use std::process::ExitCode;

use moco::program::{arguments, fail, interrupts, log};
use moco::simulate::{Args, simulate};
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
    let interrupts = interrupts(false).map_err(|error| format!("Ctrl-C cannot be handled: {error}"))?;
    Box::pin(simulate(args, interrupts)).await
}
