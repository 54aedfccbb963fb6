//! Session of a host: the machine with the stream buffer of its line, and the messages of its commands.
//!
//! This is a whole host. It enables motor 1, moves it, and tells when it rests. Reading the line has to end after some
//! milliseconds without a byte, as serial ports can do.
//!
//! ```
//! use std::io::{Read, Write};
//!
//! use dmc_proto::host::{Event, Next, Options, Session, Token};
//! use dmc_proto::message::{Motor, MotorConfigure, MotorFlags, MotorMove, Steps};
//! use dmc_proto::upload::NoMove;
//! use dmc_proto::Millis;
//!
//! fn control(line: &mut (impl Read + Write), now: impl Fn() -> Millis) -> Result<(), Box<dyn std::error::Error>> {
//!     let motor = Motor(1);
//!     let mut session: Session = Session::new(Options::default());
//!     let mut bytes = [0; 1048];
//!     session.link_up();
//!     loop {
//!         match session.poll(now(), &NoMove, &mut bytes)? {
//!             Next::Transmit(frame) => line.write_all(frame)?,
//!             Next::Event(Event::Greeted(_)) => session.configured(Token(1))?,
//!             Next::Event(Event::Ready { .. }) => {
//!                 session.request(Token(2), MotorConfigure { motor, flags: MotorFlags::ENABLED, tail: &[] })?;
//!             }
//!             Next::Event(Event::Ended { token: Token(2), .. }) => {
//!                 session.request(Token(3), MotorMove { motor, position: Steps(2000), tail: &[] })?;
//!             }
//!             Next::Event(Event::Ended { token: Token(3), outcome }) => return Ok(println!("{outcome:?}")),
//!             Next::Event(event) => println!("{event:?}"),
//!             Next::Wait(_) => {
//!                 let len = line.read(&mut bytes[..64])?;
//!                 assert_eq!(session.receive(now(), &bytes[..len]), len);
//!             }
//!         }
//!     }
//! }
//! ```

use core::mem;

use motion_core::session::{self, Agenda, News, Session as _, Turn, TurnOf};
use motion_core::stream::{Item, Patience};
use motion_core::time::Millis;
use motion_core::wire::EncodeError;
use motion_core::{session_line, session_link, session_methods};

use super::Token;
use super::event::{Event, Outcome, StopTarget};
use super::input::{Command, Input};
use super::machine::HostMachine;
use super::options::Options;
use super::store::Store;
use super::transmit::{EFFECTS, Effect, Source, Transmit};
use crate::frame::{Dmc, Frame, MAX_DEVICE_FRAME, MessageId};
use crate::message::{DeviceMessage, HostMessage, Motor, MotorStatusRequest, VirtualMotor};
use crate::upload::{MoveSource, SCRATCH, Section, SectionSize};

pub use motion_core::session::NotTaken;

/// Next thing to do for a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next<'a> {
    /// Write these bytes to the line.
    Transmit(&'a [u8]),
    /// Act on this event.
    Event(Event<'a>),
    /// Wait until something happens, at most until this time; without a time, as long as it takes.
    Wait(Option<Millis>),
}

/// Command whose message, if it has one, is in the store.
#[derive(Debug, Clone, Copy)]
enum Wish {
    Greet,
    Configured,
    Request,
    Sequence,
    Go,
    Stop(StopTarget),
    EndStops,
}

/// Effect without what it borrows from the message that came last.
#[derive(Debug, Clone, Copy)]
pub enum Held {
    Transmit(Transmit),
    Event(Event<'static>),
    /// End of the command with this token, with the message as its answer.
    Answer(Token),
    Unsolicited(MessageId),
}

impl Held {
    const fn is_event(&self) -> bool {
        !matches!(self, Self::Transmit(_))
    }

    fn of(effect: Effect<'_>) -> Self {
        match effect {
            Effect::Transmit(transmit) => Self::Transmit(transmit),
            Effect::Event(event) => match (event.to_static(), event) {
                (Some(event), _) => Self::Event(event),
                (None, Event::Ended { token, .. }) => Self::Answer(token),
                (None, Event::Unsolicited(id, _)) => Self::Unsolicited(id),
                (None, _) => Self::Event(Event::Corrupt),
            },
        }
    }
}

/// Section of an upload that the machine wants.
#[derive(Debug, Clone, Copy)]
enum Wanted {
    Nothing,
    First,
    After(Section),
}

/// Stream of the frames of a device, which takes pieces of 512 bytes.
type Link = session::Link<Dmc<MAX_DEVICE_FRAME>, { 2 * MAX_DEVICE_FRAME + 511 }>;

/// Host of a device with its stream buffer, and `STORE` bytes for the messages of commands that have not ended. A message
/// takes 18 bytes more than its data.
pub struct Session<const STORE: usize = 2048> {
    machine: HostMachine,
    link: Link,
    store: Store<STORE>,
    wanted: Wanted,
    agenda: Agenda<(Token, Wish), Held, EFFECTS>,
}

impl<const STORE: usize> Session<STORE> {
    /// Makes a session without a line.
    #[must_use]
    pub fn new(options: Options) -> Self {
        let link = Link::new(Patience::new().with_line_speed(options.line_speed()));
        let machine = HostMachine::new(options);
        Self { machine, link, store: Store::new(), wanted: Wanted::Nothing, agenda: Agenda::new() }
    }

    /// Sends a request, such as [`MotorMove`](crate::message::MotorMove).
    ///
    /// Its end is that of [`Command::Request`].
    ///
    /// # Errors
    ///
    /// [`NotTaken`].
    pub fn request<'m>(&mut self, token: Token, message: impl Into<HostMessage<'m>>) -> Result<(), NotTaken> {
        self.keep(token, &message.into(), Wish::Request)
    }

    /// Sends the message that begins an upload, a run, a shot or a way to a frame, and follows it to its end.
    ///
    /// Its end is that of [`Command::Sequence`].
    ///
    /// # Errors
    ///
    /// [`NotTaken`].
    pub fn sequence<'m>(&mut self, token: Token, message: impl Into<HostMessage<'m>>) -> Result<(), NotTaken> {
        self.keep(token, &message.into(), Wish::Sequence)
    }

    fn keep(&mut self, token: Token, message: &HostMessage<'_>, wish: Wish) -> Result<(), NotTaken> {
        if self.store.contains(token) {
            return Err(NotTaken::TokenInUse(token));
        }
        self.store.insert(token, message).map_err(NotTaken::Message)?;
        let wanted = self.agenda.want((token, wish));
        if wanted.is_err() {
            self.store.remove(token);
        }
        wanted
    }

    /// Next thing to do. The sections of a move come from `source`, and messages are written to the front of `out`, for which
    /// 1048 bytes are enough.
    ///
    /// # Errors
    ///
    /// [`EncodeError`] if a message cannot be written. If `out` is too small, call again with as many bytes as the error
    /// needs; the message is not lost.
    pub fn poll<'p, S: MoveSource + ?Sized>(
        &'p mut self,
        now: Millis,
        source: &S,
        out: &'p mut [u8],
    ) -> Result<Next<'p>, EncodeError> {
        Ok(match self.take_turn(now, source, out)? {
            Turn::Transmit((), len) => Next::Transmit(out.get(..len).unwrap_or_default()),
            Turn::Event(held) => Next::Event(self.event(held)),
            Turn::Wait(until) => Next::Wait(until),
        })
    }

    fn take_turn<S: MoveSource + ?Sized>(
        &mut self,
        now: Millis,
        source: &S,
        out: &mut [u8],
    ) -> Result<TurnOf<Self>, EncodeError> {
        let held = loop {
            match self.agenda.pop() {
                Some(Held::Event(Event::NextSection { after, .. })) => {
                    self.wanted = after.map_or(Wanted::First, Wanted::After);
                }
                // A stop came before the section that was wanted.
                Some(Held::Event(Event::SectionNotWanted)) => {}
                Some(held) => break held,
                None if self.advance(now, source) => {}
                None => return Ok(Turn::Wait(self.until())),
            }
        };
        if let Held::Event(Event::Ended { token, .. }) | Held::Answer(token) = held {
            self.store.remove(token);
        }
        let Held::Transmit(transmit) = held else { return Ok(Turn::Event(held)) };
        let (store, mut scratch) = (&self.store, [0; SCRATCH]);
        let written = transmit.encode_into(
            |wanted| match wanted {
                Source::Command(token) => message_of(store, token),
                Source::Section(section) => section.message(source, &mut scratch),
            },
            out,
        );
        if let Err(EncodeError::BufferTooSmall { .. }) = written {
            self.agenda.put_back(held);
        }
        written.map(|len| Turn::Transmit((), len))
    }

    /// Tells the machine the next thing that happened. Returns false if nothing did.
    fn advance<S: MoveSource + ?Sized>(&mut self, now: Millis, source: &S) -> bool {
        let size = SectionSize::default();
        let output = match (self.agenda.news(), mem::replace(&mut self.wanted, Wanted::Nothing)) {
            (Some(News::LinkDown), _) => self.machine.advance(now, Input::LinkDown),
            (Some(News::LinkUp), _) => self.machine.advance(now, Input::LinkUp),
            (Some(News::Wish((token, wish))), wanted) => {
                self.wanted = wanted;
                let message = || message_of(&self.store, token);
                let command = match wish {
                    Wish::Greet => Command::Greet,
                    Wish::Configured => Command::Configured,
                    Wish::Request => Command::Request(message()),
                    Wish::Sequence => Command::Sequence(message()),
                    Wish::Go => Command::Go,
                    Wish::Stop(target) => Command::Stop(target),
                    Wish::EndStops => Command::EndStops,
                };
                self.machine.advance(now, Input::Command(token, command))
            }
            (None, Wanted::First) => self.machine.advance(now, Input::Section(Section::first(source, size))),
            (None, Wanted::After(section)) => self.machine.advance(now, Input::Section(section.next(source, size))),
            (None, Wanted::Nothing) => match self.link.next() {
                Some(Item::Frame(frame)) => self.machine.advance(now, Input::received(&frame)),
                Some(Item::Corrupt { .. }) => self.machine.advance(now, Input::Corrupt),
                Some(Item::Noise { .. } | Item::Fatal(_)) => return true,
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
        true
    }
}

/// Message of a command. The machine asks only for those of commands that have not ended. A question would do no harm.
fn message_of<const N: usize>(store: &Store<N>, token: Token) -> HostMessage<'_> {
    store.get(token).unwrap_or_else(|| MotorStatusRequest::default().into())
}

impl<const STORE: usize> session::Session for Session<STORE> {
    type Source<'s> = dyn MoveSource + Sync + 's;

    session_line! { to all }

    fn turn(&mut self, now: Millis, source: &Self::Source<'_>, out: &mut [u8]) -> Result<TurnOf<Self>, EncodeError> {
        self.take_turn(now, source, out)
    }

    fn event(&self, held: Held) -> Event<'_> {
        let message = || Frame::decode(self.link.last()).ok().and_then(|frame| DeviceMessage::decode(&frame).ok());
        match held {
            Held::Event(event) => event,
            Held::Answer(token) => Event::Ended { token, outcome: Outcome::Done(message()) },
            Held::Unsolicited(id) => message().map_or(Event::Corrupt, |message| Event::Unsolicited(id, message)),
            Held::Transmit(_) => Event::Corrupt,
        }
    }
}

session_link! { host impl<const STORE: usize> Session<STORE>: HostMachine, Link }

session_methods! {
    impl<const STORE: usize> Session<STORE> as Wish, see Command, with token;
    stop_all {
    /// Stops everything.
    Stop stop() => (StopTarget::All);
    }
    stop_one {
    /// Stops a motor.
    Stop stop_motor(motor: Motor) => (StopTarget::Motor(motor));
    /// Stops a virtual motor.
    Stop stop_virtual(motor: VirtualMotor) => (StopTarget::Virtual(motor));
    }
    want {
    /// Greets the device again, after it was silent.
    Greet greet();
    /// Tells that the device is configured: everything may be sent as soon as all requests are answered.
    Configured configured();
    /// Starts the run or shot that is [armed](Event::Armed).
    Go go();
    /// Gives up the stops that are not confirmed.
    EndStops end_stops();
    }
}
