//! Functions that several commands use: the log, and Ctrl-C.

use std::fmt;
use std::io::{self, IsTerminal};
use std::time::Instant;

use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};
use tracing::Level;
use tracing_appender::non_blocking::{NonBlockingBuilder, WorkerGuard};
use tracing_subscriber::fmt::format::Writer;
use tracing_subscriber::fmt::time::FormatTime;

/// Number of lines of the log that may wait to be written. Further lines are lost.
const LINES: usize = 4096;

/// Writes the log to standard error, from a level on: seconds since this call, level, text. A terminal gets colours. With
/// `is_json`, each line is an object.
///
/// A separate thread writes until the returned guard is dropped. So a standard error that is blocked delays neither a
/// stop nor a rig.
pub fn log(level: Level, is_json: bool) -> WorkerGuard {
    let (writer, guard) = NonBlockingBuilder::default().buffered_lines_limit(LINES).finish(io::stderr());
    let log = tracing_subscriber::fmt()
        .with_writer(writer)
        .with_ansi(io::stderr().is_terminal())
        .with_timer(Seconds(Instant::now()))
        .with_target(false)
        .with_max_level(level)
        .log_internal_errors(false);
    if is_json {
        log.json().flatten_event(true).init();
    } else {
        log.init();
    }
    guard
}

/// Clock of the log.
struct Seconds(Instant);

impl FormatTime for Seconds {
    fn format_time(&self, out: &mut Writer<'_>) -> fmt::Result {
        write!(out, "{:.6}", self.0.elapsed().as_secs_f64())
    }
}

/// Receiver of a message for each Ctrl-C and, on Unix, for each SIGTERM.
///
/// With `terminal` there is also a message for each SIGHUP, Ctrl-\ and Ctrl-Z, because motors go on if their program is
/// suspended. After this call, none of these signals ends or suspends the program.
///
/// # Errors
///
/// Error of the operating system.
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
