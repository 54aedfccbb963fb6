//! Output that never waits, for the time in which motors move.

use std::fmt;
use std::io::{self, IsTerminal, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;

use super::output::{About, Output};

/// Number of lines that may wait to be written. Further lines are dropped.
const WAITING: usize = 1000;
/// Time that the last lines may take to be written.
const LAST: Duration = Duration::from_secs(1);
/// Number of steps of a progress bar.
const STEPS: f64 = 1000.0;

/// Form in which lines are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Text.
    Text,
    /// Text, and a progress bar on standard error. Progress is written as text only if `is_written` is true.
    Bar {
        /// Whether progress is also written as text.
        is_written: bool,
    },
    /// JSON objects.
    Json,
}

impl Form {
    /// Form for the terminals of the program.
    #[must_use]
    pub fn of_terminal() -> Self {
        if io::stderr().is_terminal() { Self::Bar { is_written: !io::stdout().is_terminal() } } else { Self::Text }
    }
}

/// Output that never waits, because a thread of its own writes.
///
/// A terminal that is scrolled back may take no output, but it must not delay a stop. If the output is closed, writing
/// is an error.
#[derive(Debug)]
pub struct Printer {
    lines: Option<SyncSender<Line>>,
    is_broken: Arc<AtomicBool>,
    thread: Option<thread::JoinHandle<()>>,
}

#[derive(Debug)]
enum Line {
    Told(About, String),
    Done,
}

impl Printer {
    /// Makes a printer that writes to `out`.
    #[must_use]
    pub fn new(out: impl Write + Send + 'static, form: Form) -> Self {
        let (send, lines) = sync_channel::<Line>(WAITING);
        let is_broken = Arc::new(AtomicBool::new(false));
        let broke = Arc::clone(&is_broken);
        let thread = thread::spawn(move || {
            let mut writer = Writer { out, form, bar: None };
            for line in lines {
                if writer.write(line).is_err() {
                    broke.store(true, Ordering::Relaxed);
                    return;
                }
            }
        });
        Self { lines: Some(send), is_broken, thread: Some(thread) }
    }

    /// Tells programs that the command is done.
    pub fn done(mut self) {
        // If the output is closed, nobody wants to know.
        let _ = self.send(Line::Done);
    }

    fn send(&mut self, line: Line) -> io::Result<()> {
        let sent = self.lines.as_ref().map(|lines| lines.try_send(line));
        match sent {
            Some(Ok(()) | Err(TrySendError::Full(_))) if !self.is_broken.load(Ordering::Relaxed) => Ok(()),
            _ => Err(io::ErrorKind::BrokenPipe.into()),
        }
    }
}

impl Output for Printer {
    fn line(&mut self, about: About, text: fmt::Arguments<'_>) -> io::Result<()> {
        self.send(Line::Told(about, text.to_string()))
    }
}

/// Writer of lines in their form.
struct Writer<W> {
    out: W,
    form: Form,
    bar: Option<ProgressBar>,
}

impl<W: Write> Writer<W> {
    fn write(&mut self, line: Line) -> io::Result<()> {
        match (self.form, line) {
            (Form::Json, Line::Told(about, text)) => writeln!(self.out, "{}", about.json(&text))?,
            (Form::Json, Line::Done) => writeln!(self.out, "{}", json!({ "event": "done" }))?,
            (_, Line::Done) => {}
            (Form::Bar { is_written }, Line::Told(About::Progress { part: Some(part), .. }, text)) => {
                let bar = self.bar.get_or_insert_with(bar);
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 1000")]
                bar.set_position((part.clamp(0.0, 1.0) * STEPS) as u64);
                bar.set_message(text.clone());
                if is_written {
                    writeln!(self.out, "{text}")?;
                }
            }
            (_, Line::Told(_, text)) => match &self.bar {
                Some(bar) => bar.suspend(|| writeln!(self.out, "{text}").and_then(|()| self.out.flush()))?,
                None => writeln!(self.out, "{text}")?,
            },
        }
        self.out.flush()
    }
}

impl<W> Drop for Writer<W> {
    /// Removes the bar.
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1000")]
fn bar() -> ProgressBar {
    let bar = ProgressBar::new(STEPS as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {wide_msg}") {
        bar.set_style(style);
    }
    bar
}

impl Drop for Printer {
    /// Waits a short time for the lines that are not written yet.
    fn drop(&mut self) {
        self.lines = None;
        let Some(thread) = self.thread.take() else { return };
        let step = Duration::from_millis(5);
        for _ in 0..LAST.as_millis() / step.as_millis() {
            if thread.is_finished() {
                return;
            }
            thread::sleep(step);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;
    use std::time::Instant;

    use super::*;

    /// Writer that needs this time for each piece. With a time of zero, each write is an error.
    #[derive(Clone)]
    struct Slow(Duration, Arc<Mutex<Vec<u8>>>);

    impl Write for Slow {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if self.0.is_zero() {
                return Err(io::ErrorKind::BrokenPipe.into());
            }
            thread::sleep(self.0);
            self.1.lock().unwrap().extend(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_printer_never_waits_and_writes_everything() {
        let read = Arc::default();
        let mut printer = Printer::new(Slow(Duration::from_millis(20), Arc::clone(&read)), Form::Text);
        let start = Instant::now();
        for number in 0..10 {
            printer.line(About::Note, format_args!("{number}")).unwrap();
        }
        assert!(start.elapsed() < Duration::from_millis(20));
        drop(printer);
        assert_eq!(*read.lock().unwrap(), b"0\n1\n2\n3\n4\n5\n6\n7\n8\n9\n");
    }

    #[test]
    fn programs_read_objects_until_the_command_is_done() {
        let read = Arc::default();
        let mut printer = Printer::new(Slow(Duration::from_millis(1), Arc::clone(&read)), Form::Json);
        printer.line(About::position(1, 2), format_args!("motor 1 rests at 2 steps")).unwrap();
        printer.done();
        let expected = "{\"event\":\"position\",\"motor\":1,\"position\":2.0,\"text\":\"motor 1 rests at 2 steps\"}\n\
                        {\"event\":\"done\"}\n";
        assert_eq!(String::from_utf8(read.lock().unwrap().clone()).unwrap(), expected);
    }

    #[test]
    fn a_bar_replaces_lines_of_progress_at_a_terminal() {
        for (is_written, expected) in [(false, "begin\nend\n"), (true, "begin\nhalf\nend\n")] {
            let read = Arc::default();
            let mut printer = Printer::new(Slow(Duration::from_millis(1), Arc::clone(&read)), Form::Bar { is_written });
            let half = About::Progress { part: Some(0.5), positions: Vec::new() };
            for (about, text) in [(About::Note, "begin"), (half, "half"), (About::Note, "end")] {
                printer.line(about, format_args!("{text}")).unwrap();
            }
            printer.done();
            assert_eq!(String::from_utf8(read.lock().unwrap().clone()).unwrap(), expected);
        }
    }

    #[test]
    fn a_closed_output_is_an_error() {
        let mut printer = Printer::new(Slow(Duration::ZERO, Arc::default()), Form::Text);
        let start = Instant::now();
        while printer.line(About::Note, format_args!("hello")).is_ok() {
            assert!(start.elapsed() < Duration::from_secs(5));
        }
    }
}
