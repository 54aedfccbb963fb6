//! A simulated rig on a real transport: `cargo run --example simulate -- kos`.

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
    log(match args.verbose {
        0 => Level::INFO,
        1 => Level::DEBUG,
        _ => Level::TRACE,
    });
    match run(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => fail(NAME, &why),
    }
}

#[tokio::main(flavor = "current_thread")]
async fn run(args: &Args) -> Result<(), String> {
    let interrupts = interrupts(false).map_err(|error| format!("Ctrl-C cannot be noticed: {error}"))?;
    Box::pin(simulate(args, interrupts)).await
}
