//! Output that never waits, for the time in which motors move.

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::thread;
use std::time::Duration;

/// Number of pieces that may wait to be written. Further pieces are dropped.
const WAITING: usize = 1000;
/// Time that the last pieces may take to be written.
const LAST: Duration = Duration::from_secs(1);

/// Writer that never waits, because a thread of its own writes.
///
/// A terminal that is scrolled back may take no output, but it must not delay a stop. If the output is closed, writing
/// is an error.
#[derive(Debug)]
pub struct Printer {
    pieces: Option<SyncSender<Vec<u8>>>,
    is_broken: Arc<AtomicBool>,
    thread: Option<thread::JoinHandle<()>>,
}

impl Printer {
    /// Makes a printer that writes to `out`.
    #[must_use]
    pub fn new(mut out: impl Write + Send + 'static) -> Self {
        let (send, pieces) = sync_channel::<Vec<u8>>(WAITING);
        let is_broken = Arc::new(AtomicBool::new(false));
        let broke = Arc::clone(&is_broken);
        let thread = thread::spawn(move || {
            for piece in pieces {
                if out.write_all(&piece).and_then(|()| out.flush()).is_err() {
                    broke.store(true, Ordering::Relaxed);
                    return;
                }
            }
        });
        Self { pieces: Some(send), is_broken, thread: Some(thread) }
    }
}

impl Write for Printer {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let sent = self.pieces.as_ref().map(|pieces| pieces.try_send(bytes.to_vec()));
        match sent {
            Some(Ok(()) | Err(TrySendError::Full(_))) if !self.is_broken.load(Ordering::Relaxed) => Ok(bytes.len()),
            _ => Err(io::ErrorKind::BrokenPipe.into()),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Drop for Printer {
    /// Waits a short time for the pieces that are not written yet.
    fn drop(&mut self) {
        self.pieces = None;
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
        let mut printer = Printer::new(Slow(Duration::from_millis(20), Arc::clone(&read)));
        let start = Instant::now();
        for number in 0..10 {
            printer.write_all(format!("{number}\n").as_bytes()).unwrap();
        }
        assert!(start.elapsed() < Duration::from_millis(20));
        drop(printer);
        assert_eq!(*read.lock().unwrap(), b"0\n1\n2\n3\n4\n5\n6\n7\n8\n9\n");
    }

    #[test]
    fn a_closed_output_is_an_error() {
        let mut printer = Printer::new(Slow(Duration::ZERO, Arc::default()));
        let start = Instant::now();
        while printer.write_all(b"hello\n").is_ok() {
            assert!(start.elapsed() < Duration::from_secs(5));
        }
    }
}
