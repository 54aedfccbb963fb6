//! Bytes that arrived before a line was lost reach the session before it is told of the loss.

mod lines;

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::Duration;

use motion_core::session::{NotTaken, Session, Turn};
use motion_core::time::Millis;
use motion_core::wire::EncodeError;
use motion_io::{Error, blocking};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};

/// Session that sends some bytes, each as a message, and notes what it is told.
#[derive(Default)]
struct Talker {
    unsaid: u8,
    told: Vec<String>,
}

impl Session for Talker {
    type Source<'s> = ();
    type Line = ();
    type Destination = ();
    type Event<'e> = ();
    type Held = ();

    const PIECE: usize = 64;

    fn reaches((): (), (): ()) -> bool {
        true
    }

    fn link_up(&mut self, (): ()) -> Result<(), NotTaken> {
        self.unsaid = 3;
        Ok(())
    }

    fn link_down(&mut self, (): ()) -> Result<(), NotTaken> {
        self.told.push("link down".into());
        Ok(())
    }

    fn receive(&mut self, _: Millis, (): (), bytes: &[u8]) -> usize {
        if !bytes.is_empty() {
            self.told.push(String::from_utf8_lossy(bytes).into());
        }
        bytes.len()
    }

    fn turn(&mut self, _: Millis, (): &(), out: &mut [u8]) -> Result<Turn<(), ()>, EncodeError> {
        let Some(left) = self.unsaid.checked_sub(1) else { return Ok(Turn::Wait(None)) };
        let Some(first) = out.first_mut() else { return Err(EncodeError::BufferTooSmall { needed: 1, have: 0 }) };
        (*first, self.unsaid) = (b'!', left);
        Ok(Turn::Transmit((), 1))
    }

    fn event(&self, (): ()) {}
}

/// Line that gives these pieces, and whose other end then closes it or is silent.
///
/// It takes no byte: the first `waits` writes wait, and the following ones fail.
struct Closing {
    pieces: VecDeque<&'static [u8]>,
    closes: bool,
    waits: u8,
}

impl Closing {
    fn give(&mut self, buf: &mut [u8]) -> io::Result<usize> {
        match self.pieces.pop_front() {
            Some(piece) => {
                buf[..piece.len()].copy_from_slice(piece);
                Ok(piece.len())
            }
            None if self.closes => Ok(0),
            None => Err(ErrorKind::WouldBlock.into()),
        }
    }

    fn refuse(&mut self) -> io::Result<usize> {
        let is_first = self.waits > 0;
        self.waits = self.waits.saturating_sub(1);
        Err(if is_first { ErrorKind::WouldBlock } else { ErrorKind::BrokenPipe }.into())
    }
}

/// Result of a poll, which waits where a blocking stream would.
fn polled<T>(result: io::Result<T>) -> Poll<io::Result<T>> {
    match result {
        Err(error) if error.kind() == ErrorKind::WouldBlock => Poll::Pending,
        result => Poll::Ready(result),
    }
}

impl AsyncRead for Closing {
    fn poll_read(mut self: Pin<&mut Self>, _: &mut Context<'_>, buf: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        let len = self.give(buf.initialize_unfilled());
        polled(len.map(|len| buf.advance(len)))
    }
}

impl AsyncWrite for Closing {
    fn poll_write(mut self: Pin<&mut Self>, cx: &mut Context<'_>, _: &[u8]) -> Poll<io::Result<usize>> {
        // It can be tried again at once.
        cx.waker().wake_by_ref();
        polled(self.refuse())
    }

    fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        unreachable!("the driver does not flush")
    }

    fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }
}

impl Read for Closing {
    fn read(&mut self, buf: &mut [u8]) -> io::Result<usize> {
        self.give(buf)
    }
}

impl Write for Closing {
    fn write(&mut self, _: &[u8]) -> io::Result<usize> {
        self.refuse()
    }

    fn flush(&mut self) -> io::Result<()> {
        unreachable!("the driver does not flush")
    }
}

impl blocking::Stream for Closing {
    fn set_read_timeout(&mut self, _: Duration) -> io::Result<()> {
        Ok(())
    }
}

/// Lines that end in different ways.
fn lines() -> impl Iterator<Item = Closing> {
    let ends = [(true, 0), (true, 1), (false, 0), (false, 1)];
    ends.into_iter().map(|(closes, waits)| Closing { pieces: [&b"I "[..], b"rest"].into(), closes, waits })
}

fn check(session: &Talker, error: &Error, case: &str) {
    assert_eq!(session.told.concat(), "I restlink down", "{case}");
    let text = error.to_string();
    assert!(text.starts_with("the line is gone: "), "{case}: {text}");
}

#[tokio::test(start_paused = true)]
async fn the_last_answer_reaches_the_session_with_the_driver_on_tokio() {
    for line in lines() {
        let case = format!("closes: {}, waits: {}", line.closes, line.waits);
        let mut driver = motion_io::tokio::Driver::new(Talker::default(), line);
        let error = driver.next(&()).await.unwrap_err();
        check(driver.session(), &error, &case);
    }
}

#[test]
fn the_last_answer_reaches_the_session_with_the_driver_of_blocking_streams() {
    for line in lines() {
        let case = format!("closes: {}, waits: {}", line.closes, line.waits);
        let mut driver = blocking::Driver::new(Talker::default(), line);
        let error = driver.next(&()).unwrap_err();
        check(driver.session(), &error, &case);
    }
}

#[tokio::test]
async fn a_broken_line_that_is_never_silent_is_lost_all_the_same() {
    let mut driver = motion_io::tokio::Driver::new(Talker::default(), lines::Babble { takes: false });
    let lost = tokio::time::timeout(Duration::from_secs(20), driver.next(&())).await;
    assert!(lost.expect("the line is lost").is_err());
}
