//! Driver of blocking streams, for threads.
//!
//! A host of kOS, which turns motor 1 by two rotations:
//!
//! ```no_run
//! use kos_proto::host::{Endpoint, Event, Go, Options, Session, Source, Token};
//! use kos_proto::message::{Ipv4, MotorAddress, Rotations, RotationsPerSecond, RotationsPerSecondSquared};
//! use motion_io::blocking::{Driver, tcp};
//!
//! let session: Session = Session::new(Options::default());
//! let mut driver = Driver::new(session, tcp("192.168.50.1:5520")?);
//! driver.session_mut().connect(Token(1), Endpoint::Tcp(Ipv4::default()))?;
//!
//! let (motor, position) = (MotorAddress(1), Rotations(2.0));
//! let go = Go { motor, position, speed: RotationsPerSecond(1.0), acceleration: RotationsPerSecondSquared(1.0) };
//! loop {
//!     match driver.next(&Source::default())? {
//!         Event::Ready { .. } => driver.session_mut().bump(Token(2), go)?,
//!         Event::Ended { token: Token(2), outcome } => break println!("{outcome:?}"),
//!         event => println!("{event:?}"),
//!     }
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A host of DMC, which enables motor 1, moves it, and tells when it rests:
//!
//! ```no_run
//! use dmc_proto::host::{Event, Options, Session, Token};
//! use dmc_proto::message::{Motor, MotorConfigure, MotorFlags, MotorMove, Steps};
//! use dmc_proto::upload::NoMove;
//! use motion_io::blocking::{Driver, tcp};
//!
//! let motor = Motor(1);
//! let session: Session = Session::new(Options::default());
//! let mut driver = Driver::new(session, tcp("192.168.50.2:5510")?);
//! loop {
//!     match driver.next(&NoMove)? {
//!         Event::Greeted(_) => driver.session_mut().configured(Token(1))?,
//!         Event::Ready { .. } => {
//!             let configure = MotorConfigure { motor, flags: MotorFlags::ENABLED, tail: &[] };
//!             driver.session_mut().request(Token(2), configure)?;
//!         }
//!         Event::Ended { token: Token(2), .. } => {
//!             driver.session_mut().request(Token(3), MotorMove { motor, position: Steps(2000), tail: &[] })?;
//!         }
//!         Event::Ended { token: Token(3), outcome } => break println!("{outcome:?}"),
//!         event => println!("{event:?}"),
//!     }
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A master of hoot on a serial port, which asks a node where its first motor is:
//!
//! ```no_run
//! # #[cfg(feature = "serialport")] {
//! use hoot_proto::host::{Event, Options, Outcome, Session, Token};
//! use hoot_proto::message::{Motor, MotorPosition};
//! use hoot_proto::{Address, Query};
//! use motion_io::blocking::{Driver, serial};
//!
//! let question = MotorPosition { motor: Motor::One };
//! let mut driver = Driver::new(Session::new(Options::default()), serial("/dev/ttyUSB0", 57_600)?);
//! loop {
//!     match driver.next(&())? {
//!         Event::Ready { .. } => driver.session_mut().request(Token(1), Address::DEFAULT, question.into())?,
//!         Event::Ended { token: Token(1), outcome: Outcome::Done(reply) } => {
//!             break println!("{}", question.decode_reply(reply)?);
//!         }
//!         event => println!("{event:?}"),
//!     }
//! }
//! # }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::boxed::Box;
use std::fmt;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::string::{String, ToString};
use std::thread::sleep;
use std::time::{Duration, Instant};

use motion_core::session::{DeviceSession, HostSession, Session};
use motion_core::time::Millis;

use crate::error::Error;
use crate::flow::Next;
use crate::line::{Line, Reopen, driver_methods};
use crate::reconnect::{Attempts, Reconnect};
use crate::{CONNECT, STALLED};

/// Longest time of one read.
const LONGEST: Duration = Duration::from_secs(3_600);

/// Stream whose reading and writing end after some time.
pub trait Stream: Read + Write {
    /// Sets the time after which a read without bytes ends, with [`WouldBlock`](ErrorKind::WouldBlock) or
    /// [`TimedOut`](ErrorKind::TimedOut). It is not zero.
    ///
    /// # Errors
    ///
    /// The errors of the stream.
    fn set_read_timeout(&mut self, time: Duration) -> io::Result<()>;

    /// Sets the time after which a write that takes no bytes ends in the same way. It is not zero. By default, a write waits
    /// as long as the stream wants.
    ///
    /// # Errors
    ///
    /// The errors of the stream.
    fn set_write_timeout(&mut self, time: Duration) -> io::Result<()> {
        let _ = time;
        Ok(())
    }
}

impl Stream for TcpStream {
    fn set_read_timeout(&mut self, time: Duration) -> io::Result<()> {
        Self::set_read_timeout(self, Some(time))
    }

    fn set_write_timeout(&mut self, time: Duration) -> io::Result<()> {
        Self::set_write_timeout(self, Some(time))
    }
}

#[cfg(feature = "serialport")]
impl Stream for Box<dyn serialport::SerialPort> {
    fn set_read_timeout(&mut self, time: Duration) -> io::Result<()> {
        Ok(self.set_timeout(time)?)
    }

    fn set_write_timeout(&mut self, time: Duration) -> io::Result<()> {
        Ok(self.set_timeout(time)?)
    }
}

/// Session on a stream.
pub struct Driver<S: Session, T> {
    line: Line<S, T, Result<T, Error>>,
    start: Instant,
}

impl<S: Session, T: Stream> Driver<S, T> {
    /// Opens the line of a host that was lost again, by these rules. The session waits while `open` works.
    #[must_use]
    pub fn reconnecting(self, rules: Reconnect, open: impl FnMut() -> Result<T, Error> + Send + 'static) -> Self
    where
        S: HostSession,
    {
        self.with_attempts(Attempts::new(rules), open)
    }

    /// Opens the line of a device that was lost again, by these rules: a serial port, or the next connection of a listener.
    ///
    /// The driver does not stop anything: see [`Reconnect`].
    ///
    /// The session waits while `open` works, so that `open` must not wait for long: a listener must not block.
    #[must_use]
    pub fn reopening(self, rules: Reconnect, open: impl FnMut() -> Result<T, Error> + Send + 'static) -> Self
    where
        S: DeviceSession,
    {
        self.with_attempts(Attempts::of_device(rules), open)
    }

    fn with_attempts(mut self, attempts: Attempts<S>, open: impl FnMut() -> Result<T, Error> + Send + 'static) -> Self {
        self.line.reopen = Some(Reopen::new(attempts, open));
        self
    }

    /// Next event of the session, with what `source` has for its messages. Reads, writes and waits until there is one.
    ///
    /// # Errors
    ///
    /// [`Error::Lost`] if the line is lost and is not opened again, after all events are told; [`Error::NotOpened`] if the last
    /// attempt to open it failed;
    /// [`Error::Message`] if a message cannot be written.
    pub fn next(&mut self, source: &S::Source<'_>) -> Result<S::Event<'_>, Error> {
        let held = loop {
            if let Some(held) = self.run(source, None)? {
                break held;
            }
        };
        Ok(self.line.flow.session.event(held))
    }

    /// Next event of the session, if there is one within this time.
    ///
    /// # Errors
    ///
    /// The errors of [`next`](Self::next).
    pub fn next_within(&mut self, time: Duration, source: &S::Source<'_>) -> Result<Option<S::Event<'_>>, Error> {
        let end = self.now().after(u64::try_from(time.as_millis()).unwrap_or(u64::MAX));
        let held = self.run(source, Some(end))?;
        Ok(held.map(|held| self.line.flow.session.event(held)))
    }

    /// Drives the session until there is an event, or this time has come.
    fn run(&mut self, source: &S::Source<'_>, end: Option<Millis>) -> Result<Option<S::Held>, Error> {
        let mut is_at_end = false;
        loop {
            let now = self.now();
            self.line.care(now);
            if let Some(opened) = self.line.opening.take() {
                self.line.opened(self.now(), opened);
                continue;
            }
            match self.line.next(now, source)? {
                Next::Event(held) => return Ok(Some(held)),
                Next::Write => self.write(),
                Next::Wait(_) if is_at_end => return Ok(None),
                Next::Wait(until) => {
                    self.read([until, end].into_iter().flatten().min());
                    is_at_end = end.is_some_and(|end| end <= self.now());
                }
            }
        }
    }

    /// Writes once.
    fn write(&mut self) {
        let Some(stream) = &mut self.line.stream else { return };
        let time = Duration::from_millis(STALLED);
        let written = stream.set_write_timeout(time).and_then(|()| stream.write(self.line.flow.unsent()));
        let now = self.now();
        match written {
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) if is_timeout(&error) => self.line.cannot_write(now, "it takes no bytes"),
            written => self.line.has_written(now, written),
        }
    }

    /// Reads once, and waits for bytes at most until this time.
    fn read(&mut self, until: Option<Millis>) {
        let now = self.now();
        let time = until.map_or(LONGEST, |until| Duration::from_millis(until.since(now).max(1)).min(LONGEST));
        let line = &mut self.line;
        let Some(stream) = line.stream.as_mut().filter(|_| line.flow.is_up()) else { return sleep(time) };
        let read = stream.set_read_timeout(time).and_then(|()| stream.read(&mut line.piece));
        let now = self.now();
        match read {
            Err(error) if is_timeout(&error) || error.kind() == ErrorKind::Interrupted => {}
            read => self.line.has_read(now, read),
        }
    }
}

fn is_timeout(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut)
}

driver_methods! {}

/// Opens a TCP connection, within 5 s for each address of a name. Messages are sent at once, so that a stop waits for nothing.
///
/// # Errors
///
/// [`Error::NotOpened`].
pub fn tcp(address: impl ToSocketAddrs + fmt::Display) -> Result<TcpStream, Error> {
    let name = address.to_string();
    let failed = |error: io::Error| Error::tcp(&name, &error);
    let mut last = io::Error::from(ErrorKind::AddrNotAvailable);
    for address in address.to_socket_addrs().map_err(failed)? {
        match TcpStream::connect_timeout(&address, CONNECT) {
            Ok(stream) => {
                stream.set_nodelay(true).map_err(failed)?;
                return Ok(stream);
            }
            Err(error) => last = error,
        }
    }
    Err(failed(last))
}

/// Opens a serial port at this speed, in bits per second. Bytes that wait since an earlier session are dropped.
///
/// # Errors
///
/// [`Error::NotOpened`].
#[cfg(feature = "serialport")]
pub fn serial(path: &str, baud: u32) -> Result<Box<dyn serialport::SerialPort>, Error> {
    let port = serialport::new(path, baud).open().map_err(|error| Error::serial(path, &error))?;
    // A port that cannot drop them gives bytes that answer nothing, which sessions can bear.
    let _ = port.clear(serialport::ClearBuffer::Input);
    Ok(port)
}
