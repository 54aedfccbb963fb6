//! Session of a client: the machine with the stream buffer of its connection.
//!
//! This is a whole client over TCP. It connects, turns motor 1 by two rotations, and tells when the motor rests:
//!
//! ```no_run
//! use std::io::{ErrorKind, Read, Write};
//! use std::net::TcpStream;
//! use std::time::{Duration, Instant};
//!
//! use kos_proto::host::{Endpoint, Event, Go, Next, Options, Session, Source, Token};
//! use kos_proto::message::{Ipv4, MotorAddress, Rotations, RotationsPerSecond, RotationsPerSecondSquared};
//! use kos_proto::Millis;
//!
//! let mut stream = TcpStream::connect("192.168.50.1:5520")?;
//! let start = Instant::now();
//! let now = || Millis(start.elapsed().as_millis() as u64);
//! let (motor, position) = (MotorAddress(1), Rotations(2.0));
//! let go = Go { motor, position, speed: RotationsPerSecond(1.0), acceleration: RotationsPerSecondSquared(1.0) };
//!
//! let (mut session, mut bytes): (Session, _) = (Session::new(Options::default()), [0; 1024]);
//! session.connect(Token(1), Endpoint::Tcp(Ipv4::default()))?;
//! loop {
//!     match session.poll(now(), &Source::default(), &mut bytes)? {
//!         Next::Transmit(message) => stream.write_all(message)?,
//!         Next::Event(Event::Connect(_)) => session.link_up(),
//!         Next::Event(Event::Ready { .. }) => session.bump(Token(2), go)?,
//!         Next::Event(Event::Ended { token: Token(2), outcome }) => break println!("{outcome:?}"),
//!         Next::Event(event) => println!("{event:?}"),
//!         Next::Broadcast(_) => {}
//!         Next::Wait(until) => {
//!             let millis = until.map_or(1000, |until| until.since(now())).max(1);
//!             stream.set_read_timeout(Some(Duration::from_millis(millis)))?;
//!             match stream.read(&mut bytes) {
//!                 Ok(0) => session.link_down(),
//!                 Ok(len) => assert_eq!(session.receive(now(), &bytes[..len]), len),
//!                 Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
//!                 Err(error) => return Err(error.into()),
//!             }
//!         }
//!     }
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use motion_core::session::{self, Agenda, LineRequest, News, Session as _, Turn, TurnOf};
use motion_core::stream::Item;
use motion_core::time::Millis;
use motion_core::wire::EncodeError;
use motion_core::{session_line, session_link, session_methods};

use super::event::{Event, Outcome};
use super::input::{Command, Endpoint, Get, Go, Input};
use super::machine::HostMachine;
use super::options::Options;
use super::transmit::{PasswordOf, Source, Transmit};
use super::{EFFECTS, Effect, Token};
use crate::frame::{Frame, Link, MAX_FRAME, PATIENCE};
use crate::message::{LedMode, MotorAddress, RotationsPerSecond, RotationsPerSecondSquared, Seconds};
use crate::{DeviceMessage, MoveSummary};

pub use motion_core::session::NotTaken;

/// Next thing to do for a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next<'a> {
    /// Write these bytes to the connection.
    Transmit(&'a [u8]),
    /// Send these bytes as a datagram to 255.255.255.255, port 5520.
    Broadcast(&'a [u8]),
    /// Act on this event.
    Event(Event<'a>),
    /// Wait until something happens, at most until this time; without a time, as long as it takes.
    Wait(Option<Millis>),
}

/// Receiver of a message from a client.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Destination {
    /// The device, over the connection.
    Connection,
    /// Everybody in the network: a datagram to 255.255.255.255, port 5520.
    Broadcast,
}

/// Effect without what it borrows from the message that came last.
#[derive(Debug, Clone, Copy)]
pub enum Held {
    Transmit(Transmit<'static>),
    /// Password that the device told.
    DevicePassword,
    Event(Event<'static>),
    /// End of the command with this token, with the message as its answer.
    Answer(Token),
    Unsolicited,
}

impl Held {
    const fn is_event(&self) -> bool {
        !matches!(self, Self::Transmit(_) | Self::DevicePassword)
    }

    fn of(effect: Effect<'_>) -> Self {
        match effect {
            Effect::Transmit(transmit) => transmit.to_static().map_or(Self::DevicePassword, Self::Transmit),
            Effect::Event(event) => match (event.to_static(), event) {
                (Some(event), _) => Self::Event(event),
                (None, Event::Ended { token, .. }) => Self::Answer(token),
                (None, _) => Self::Unsolicited,
            },
        }
    }
}

/// Client of a device with its stream buffer of `N` bytes.
pub struct Session<const N: usize = { 2 * MAX_FRAME + 4095 }> {
    machine: HostMachine,
    link: Link<N>,
    agenda: Agenda<(Token, Command), Held, EFFECTS>,
}

impl<const N: usize> Session<N> {
    /// Makes a session without a connection.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self { machine: HostMachine::new(options), link: Link::new(PATIENCE), agenda: Agenda::new() }
    }

    /// Gives a command. There is a method for each of them, too.
    ///
    /// # Errors
    ///
    /// [`NotTaken::Full`] if too many commands wait for a poll.
    pub fn command(&mut self, token: Token, command: Command) -> Result<(), NotTaken> {
        match command {
            Command::Stop => self.agenda.stop_all((token, command)),
            Command::StopMotor(_) => self.agenda.stop_one((token, command)),
            _ => self.agenda.want((token, command)),
        }
    }

    /// Next thing to do, with what `source` has for the messages. Messages are written to the front of `out`.
    ///
    /// # Errors
    ///
    /// [`EncodeError`] if a message cannot be written. If `out` is too small, call again with as many bytes as the error
    /// needs; the message is not lost.
    pub fn poll<'p>(
        &'p mut self,
        now: Millis,
        source: &Source<'_>,
        out: &'p mut [u8],
    ) -> Result<Next<'p>, EncodeError> {
        Ok(match self.turn(now, source, out)? {
            Turn::Transmit(to, len) => {
                let bytes = out.get(..len).unwrap_or_default();
                if to == Destination::Broadcast { Next::Broadcast(bytes) } else { Next::Transmit(bytes) }
            }
            Turn::Event(held) => Next::Event(self.event(held)),
            Turn::Wait(until) => Next::Wait(until),
        })
    }

    /// Message that came last.
    fn message(&self) -> Option<DeviceMessage<'_>> {
        Frame::decode(self.link.last()).ok().and_then(|frame| DeviceMessage::decode(&frame).ok())
    }

    /// Tells the machine the next thing that happened. Returns false if nothing did.
    fn advance(&mut self, now: Millis) -> bool {
        let was_connected = self.machine.state().is_connected();
        let mut is_over = false;
        let output = match self.agenda.news() {
            Some(News::LinkDown) => self.machine.advance(now, Input::LinkDown),
            Some(News::LinkUp) => self.machine.advance(now, Input::LinkUp),
            Some(News::Wish((token, command))) => self.machine.advance(now, Input::Command(token, command)),
            None => match self.link.next() {
                Some(Item::Frame(frame)) => self.machine.advance(now, Input::received(&frame)),
                Some(Item::Fatal(_)) => {
                    is_over = true;
                    self.machine.advance(now, Input::Fatal)
                }
                Some(Item::Noise { .. } | Item::Corrupt { .. }) => return true,
                None => {
                    if self.link.give_up(now) {
                        return true;
                    }
                    if !self.agenda.is_due(now) {
                        return false;
                    }
                    self.machine.advance(now, Input::Wake)
                }
            },
        };
        self.agenda.fill(output, Held::of);
        // What arrived on a connection that is over does not count.
        if is_over || was_connected && !self.machine.state().is_connected() {
            self.link.drop_later();
        }
        true
    }
}

impl<const N: usize> session::Session for Session<N> {
    type Source<'s> = Source<'s>;
    type Destination = Destination;

    const ASKS: bool = true;

    session_line! {}

    fn reaches(to: Destination, (): ()) -> bool {
        to == Destination::Connection
    }

    fn request(held: &Held, (): ()) -> Option<LineRequest> {
        match held {
            Held::Event(Event::Connect(_)) => Some(LineRequest::Open),
            Held::Event(Event::LinkDown(_)) => Some(LineRequest::Close),
            _ => None,
        }
    }

    fn turn(&mut self, now: Millis, source: &Source<'_>, out: &mut [u8]) -> Result<TurnOf<Self>, EncodeError> {
        let held = loop {
            if let Some(held) = self.agenda.pop() {
                break held;
            }
            if !self.advance(now) {
                return Ok(Turn::Wait(self.until()));
            }
        };
        let transmit = match held {
            Held::Transmit(transmit) => transmit,
            Held::DevicePassword => match self.message() {
                Some(DeviceMessage::DeviceInfo(info)) => {
                    Transmit::UserPassword(PasswordOf::Device(info.device_password))
                }
                _ => Transmit::UserPassword(PasswordOf::User),
            },
            held => return Ok(Turn::Event(held)),
        };
        let to = if transmit == Transmit::Discover { Destination::Broadcast } else { Destination::Connection };
        let written = transmit.message(source).encode_into(out);
        if let Err(EncodeError::BufferTooSmall { .. }) = written {
            self.agenda.put_back(held);
        }
        written.map(|len| Turn::Transmit(to, len))
    }

    fn event(&self, held: Held) -> Event<'_> {
        match held {
            Held::Event(event) => event,
            Held::Answer(token) => Event::Ended { token, outcome: Outcome::Done(self.message()) },
            // The other effects are no events.
            _ => self.message().map_or(Event::Ignored, Event::Unsolicited),
        }
    }
}

session_link! { host impl<const N: usize> Session<N>: HostMachine, Link<N> }

session_methods! {
    impl<const N: usize> Session<N> as Command, see Command, with token;
    stop_all {
    /// Stops everything.
    Stop stop();
    }
    stop_one {
    /// Stops a motor.
    StopMotor stop_motor(motor: MotorAddress) => (motor);
    }
    want {
    /// Connects to a device, and keeps connected.
    Connect connect(endpoint: Endpoint) => (endpoint);
    /// Disconnects.
    Disconnect disconnect();
    /// Tells a locked device the password of the application.
    Unlock unlock();
    /// Gives the device the new password of the application.
    ChangePassword change_password();
    /// Asks the device something.
    Get get(get: Get) => (get);
    /// Switches the lamps.
    SetLeds set_leds(master: LedMode, slave: LedMode) => { master, slave };
    /// Tells the device which platform calibrates the motors.
    SetPlatform set_platform(platform: u8) => (platform);
    /// Starts the device anew.
    ResetDevice reset_device();
    /// Forgets the range of a motor, or of all motors.
    ResetAxis reset_axis(motor: MotorAddress) => (motor);
    /// Marks the begin of the range of a motor where it rests.
    MarkBegin mark_begin(motor: MotorAddress) => (motor);
    /// Marks the end of the range of a motor where it rests.
    MarkEnd mark_end(motor: MotorAddress) => (motor);
    /// Sends a motor to a position.
    MoveTo move_to(go: Go) => (go);
    /// Runs a motor until it is stopped.
    Jog jog(motor: MotorAddress, speed: RotationsPerSecond, acceleration: RotationsPerSecondSquared) => { motor, speed, acceleration };
    /// Sends a motor a distance from where it rests.
    Bump bump(go: Go) => (go);
    /// Tells the session that the application is there.
    Alive alive();
    /// Takes one photo with this exposure.
    TakePicture take_picture(exposure: Seconds) => (exposure);
    /// Stores the move of the [`Source`] and makes it ready.
    Load load(summary: MoveSummary, delay_return: bool) => { summary, delay_return };
    /// Plays the move that is ready.
    Play play();
    /// Stores the move of the [`Source`] and plays it.
    PlayDirect play_direct(summary: MoveSummary) => { summary };
    /// Sends the motors of the move that is ready to where it begins.
    RapidToFirstKeyFrame rapid_to_first_key_frame();
    }
}
