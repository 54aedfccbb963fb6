//! A host for a rig, simulated or real: `cargo run --example drive -- kos 127.0.0.1 info`.

use std::process::ExitCode;

use live::drive::Trouble;
use live::drive::program::{Args, drive};
use live::program::{arguments, fail, interrupts, log};
use tracing::Level;

const NAME: &str = "drive";

fn main() -> ExitCode {
    let args: Args = match arguments(NAME) {
        Ok(args) => args,
        Err(status) => return status,
    };
    log(match args.verbose {
        0 => Level::ERROR,
        1 => Level::INFO,
        2 => Level::DEBUG,
        _ => Level::TRACE,
    });
    match run(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(trouble) => fail(NAME, &trouble.to_string()),
    }
}

#[tokio::main(flavor = "current_thread")]
async fn run(args: &Args) -> Result<(), Trouble> {
    let interrupts = interrupts(true).map_err(|error| Trouble::Failed(format!("Ctrl-C cannot be noticed: {error}")))?;
    Box::pin(drive(args, interrupts)).await
}
