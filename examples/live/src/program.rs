//! What both programs do alike: one line for what is wrong, a log, and Ctrl-C.

use std::io::{self, IsTerminal};
use std::process::ExitCode;

use clap::Parser;
use examples::program::reason;
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};
use tracing::Level;
use tracing_appender::non_blocking::{NonBlockingBuilder, WorkerGuard};
use tracing_subscriber::fmt::time::uptime;

pub use examples::program::fail;

/// Understands the command line; or says in one line what is wrong with it, with status 1. Help is no failure.
///
/// # Errors
///
/// The status with which the program ends.
pub fn arguments<T: Parser>(program: &str) -> Result<T, ExitCode> {
    T::try_parse().map_err(|error| {
        if error.use_stderr() {
            fail(program, &reason(&error))
        } else {
            // Nobody is left to tell when standard output is closed.
            let _ = error.print();
            ExitCode::SUCCESS
        }
    })
}

/// Lines of the log that may wait for somebody to read them; more of them are lost.
const LINES: usize = 4096;

/// Writes the log to standard error, from a level on: seconds since now, level, text. Colours are for terminals.
///
/// A thread of its own does so, until what is returned is dropped: a standard error that takes nothing holds up neither a
/// stop nor a rig.
pub fn log(level: Level) -> WorkerGuard {
    let (writer, guard) = NonBlockingBuilder::default().buffered_lines_limit(LINES).finish(io::stderr());
    tracing_subscriber::fmt()
        .with_writer(writer)
        .with_ansi(io::stderr().is_terminal())
        .with_timer(uptime())
        .with_target(false)
        .with_max_level(level)
        .log_internal_errors(false)
        .init();
    guard
}

/// A message for each Ctrl-C, and where there are such things, for each SIGTERM; and if its `terminal` is to be missed,
/// for each SIGHUP, Ctrl-\ and Ctrl-Z: motors go on while their program sleeps. From now on none of them ends the program,
/// nor sends it to sleep.
///
/// # Errors
///
/// What the operating system says.
pub fn interrupts(terminal: bool) -> io::Result<UnboundedReceiver<()>> {
    let (send, interrupts) = unbounded_channel();
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        let sleep = SignalKind::from_raw(rustix::process::Signal::TSTP.as_raw());
        let others = [SignalKind::hangup(), SignalKind::quit(), sleep].into_iter().filter(|_| terminal);
        for kind in [SignalKind::interrupt(), SignalKind::terminate()].into_iter().chain(others) {
            let (mut signals, send) = (signal(kind)?, send.clone());
            tokio::spawn(async move { while signals.recv().await.is_some() && send.send(()).is_ok() {} });
        }
    }
    #[cfg(windows)]
    {
        let _ = terminal;
        let mut signals = tokio::signal::windows::ctrl_c()?;
        tokio::spawn(async move { while signals.recv().await.is_some() && send.send(()).is_ok() {} });
    }
    Ok(interrupts)
}
