//! Lines in memory, the events of drivers on them, and rigs at their ends.
#![allow(dead_code, reason = "each program of tests uses a part")]

use std::collections::VecDeque;
use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll};
use std::time::Duration;

use dmc_proto::device as dmc_device;
use dmc_proto::message as dmc;
use motion_core::session::{NotTaken, Session};
use motion_io::Error;
use motion_io::tokio::Driver;
use tokio::io::{DuplexStream, ReadBuf, duplex};
use tokio::time::Instant;

/// Lines that can be opened one after the other. Without one, opening fails.
#[derive(Clone, Default)]
pub(crate) struct Lines(Arc<Mutex<VecDeque<DuplexStream>>>);

impl Lines {
    /// Adds a line, and returns its other end.
    pub(crate) fn add(&self) -> DuplexStream {
        let (near, far) = duplex(4_096);
        self.0.lock().unwrap().push_back(near);
        far
    }

    pub(crate) fn open(&self) -> Result<DuplexStream, Error> {
        let none = || Error::NotOpened { what: "the test".into(), why: "no line".into() };
        self.0.lock().unwrap().pop_front().ok_or_else(none)
    }
}

/// Drives a session for some time, and returns its events.
pub(crate) async fn events<S: Session>(
    driver: &mut Driver<S, DuplexStream>,
    source: &S::Source<'_>,
    time: Duration,
    mut follow: impl FnMut(&S::Event<'_>) -> Option<fn(&mut S) -> Result<(), NotTaken>>,
) -> Vec<String>
where
    for<'e> S::Event<'e>: std::fmt::Debug,
{
    let (mut events, end) = (Vec::new(), Instant::now() + time);
    loop {
        let act = match tokio::time::timeout_at(end, driver.next(source)).await {
            Ok(event) => {
                let event = event.expect("no end");
                events.push(format!("{event:?}"));
                follow(&event)
            }
            Err(_) => return events,
        };
        if let Some(act) = act {
            act(driver.session_mut()).unwrap();
        }
    }
}

pub(crate) fn place(events: &[String], what: &str) -> usize {
    events.iter().position(|event| event.contains(what)).unwrap_or_else(|| panic!("no {what} in {events:#?}"))
}

pub(crate) const SECOND: Duration = Duration::from_secs(1);

/// Rig whose motors do not move.
pub(crate) struct Still;

impl dmc_device::Rig for Still {
    fn verdict(&self, _: &dmc::HostMessage<'_>) -> dmc::AckCode {
        dmc::AckCode::OK
    }
    fn position(&self, _: dmc::Motor) -> dmc::Steps {
        dmc::Steps(0)
    }
}

pub(crate) fn new_dmc_device() -> dmc_device::Session {
    let hi = dmc::Hi { motor_count: 4, ..dmc_device::Options::default().hi() };
    let machine = dmc_device::DeviceMachine::new(dmc_device::Options::of(hi));
    dmc_device::Session::new(machine, dmc_proto::Patience::default())
}

/// Stream that is never silent, and that never lets other tasks run.
pub(crate) struct Babble {
    /// Whether it takes bytes.
    pub(crate) takes: bool,
}

impl tokio::io::AsyncRead for Babble {
    fn poll_read(self: Pin<&mut Self>, _: &mut Context<'_>, buf: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        buf.put_slice(&[0xFF; 16]);
        Poll::Ready(Ok(()))
    }
}

impl tokio::io::AsyncWrite for Babble {
    fn poll_write(self: Pin<&mut Self>, _: &mut Context<'_>, buf: &[u8]) -> Poll<io::Result<usize>> {
        Poll::Ready(if self.takes { Ok(buf.len()) } else { Err(io::ErrorKind::BrokenPipe.into()) })
    }

    fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        unreachable!("the driver does not flush")
    }

    fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }
}
