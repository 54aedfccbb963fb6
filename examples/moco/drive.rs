//! Host program for a rig, simulated or real.
//!
//! ```text
//! $ cargo run --example drive -- dmc /dev/pts/0 info
//! "Simulated DMC", firmware 1.0.0
//! 4 motors, 16 lights, 8 outputs, 8 inputs
//! room for 10000 frames; capabilities: REAL_TIME | SHOOT_FRAME | SHOOT_FRAME2 | LOOP | CAMERA_TRIGGER
//! motor 1 rests at 0 steps
//! motor 2 rests at 0 steps
//! motor 3 rests at 0 steps
//! motor 4 rests at 0 steps
//! $ cargo run --example drive -- dmc /dev/pts/0 run examples/moves/slide.json
//! uploaded: 193 frames of motors 1
//! frame 6 of 193
//! frame 30 of 193
//! frame 55 of 193
//! frame 79 of 193
//! ^Cdrive: interrupted: the rig confirmed the stop
//! $ cargo run --example drive -- hoot /dev/pts/0 run examples/moves/pan.json
//! motor 1: from 0 to 9000, deviation at most 1
//! 0.1 of 4.5 s: motor 1 at 0
//! 1.2 of 4.5 s: motor 1 at 893
//! 2.3 of 4.5 s: motor 1 at 4071
//! 3.4 of 4.5 s: motor 1 at 7514
//! the move is done, and all motors rest at its end
//! $ cargo run --example drive -- kos udp://127.0.0.1:5530 info
//! ```
//!
//! Real rigs are heavy. Use this program with one only if an emergency stop that needs no software is within reach. If
//! this program is killed, or its cable is cut, a kOS move and a hoot program go on, as their protocols require. A DMC
//! jog goes on until the rig notices or reaches a limit, because DMC has no keep-alive.

use std::process::ExitCode;

use moco::drive::Trouble;
use moco::drive::program::{Args, drive};
use moco::program::{arguments, fail, interrupts, log};
use tracing::Level;

const NAME: &str = "drive";

fn main() -> ExitCode {
    let args: Args = match arguments(NAME) {
        Ok(args) => args,
        Err(status) => return status,
    };
    let log = log(match args.verbose {
        0 => Level::ERROR,
        1 => Level::INFO,
        2 => Level::DEBUG,
        _ => Level::TRACE,
    });
    let done = run(&args);
    drop(log);
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(trouble) => fail(NAME, &trouble.to_string()),
    }
}

#[tokio::main(flavor = "current_thread")]
async fn run(args: &Args) -> Result<(), Trouble> {
    let interrupts = interrupts(true).map_err(|error| Trouble::Failed(format!("Ctrl-C cannot be handled: {error}")))?;
    Box::pin(drive(args, interrupts)).await
}
