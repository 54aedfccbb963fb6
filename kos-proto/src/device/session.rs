//! Session of a device: the machine with the stream buffers of its clients.

use core::fmt;

use motion_core::session::{self, Agenda, LineRequest, News, NotTaken, Session as _, Turn, TurnOf};
use motion_core::session_device;
use motion_core::stream::Item;
use motion_core::time::Millis;
use motion_core::wire::EncodeError;

use super::clients::{SESSIONS, SessionId};
use super::event::Event;
use super::input::{self, Input, Report, Sender};
use super::machine::DeviceMachine;
use super::transmit::{Contents, Destination, Scratch, Source, Transmit};
use super::{EFFECTS, Effect};
use crate::HostMessage;
use crate::frame::{COMMAND_FRAME, Frame, Link, MAX_FRAME, PATIENCE};
use crate::transport::Transport;

/// Number of reports that a session can hold until the next poll.
const REPORTS: usize = 32;

/// Next thing to do for a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next<'a> {
    /// Do this, or take note of it.
    Event(Event<'a>),
    /// Send these bytes to these receivers.
    Transmit(Destination, &'a [u8]),
    /// Wait until something happens, at most until this time; without a time, as long as it takes.
    Wait(Option<Millis>),
}

#[derive(Debug, Clone, Copy)]
enum Told {
    LinkUp(SessionId, Transport),
    LinkDown(SessionId),
    Stop,
    Rig(Report),
}

/// Effect without what it borrows from the message that came last.
#[derive(Debug, Clone)]
pub enum Held {
    Transmit(Transmit<'static>),
    /// The message itself, which the device does not know, goes back.
    Unsupported(Destination),
    Event(Event<'static>),
    StorePassword,
    StoreTrajectory,
}

impl Held {
    fn of(effect: Effect<'_>) -> Self {
        match effect {
            Effect::Transmit(transmit) => {
                let destination = transmit.destination;
                transmit.to_static().map_or(Self::Unsupported(destination), Self::Transmit)
            }
            Effect::Event(Event::StorePassword(_)) => Self::StorePassword,
            Effect::Event(Event::StoreTrajectory(_)) => Self::StoreTrajectory,
            Effect::Event(event) => Self::Event(event.to_static().unwrap_or(Event::MoveOver)),
        }
    }
}

/// Device with a stream buffer of `N` bytes for each of its clients, for messages of up to `CAP` bytes. `N` is at least twice
/// `CAP`. A longer message is skipped.
///
/// By default it takes pieces of 4096 bytes. For a device without moves there is [`CommandSession`].
pub struct Session<const N: usize = { 2 * MAX_FRAME + 4095 }, const CAP: usize = MAX_FRAME, const MOVES: bool = true> {
    machine: DeviceMachine<MOVES>,
    clients: [Link<N, CAP>; SESSIONS],
    /// Client from which the last message came.
    last: usize,
    agenda: Agenda<Told, Held, EFFECTS, REPORTS>,
    /// Whether what is dealt with arrived before a stop. It sets nothing in motion, and everything is stopped once more after it.
    stops_again: bool,
}

/// Device [without moves](DeviceMachine::without_moves): it takes messages of up to [`COMMAND_FRAME`] bytes, in pieces of 64 bytes.
pub type CommandSession = Session<{ 2 * COMMAND_FRAME + 63 }, COMMAND_FRAME, false>;

impl<const N: usize, const CAP: usize, const MOVES: bool> Session<N, CAP, MOVES> {
    /// Number of bytes that [`receive`](Self::receive) always takes after [`poll`](Self::poll) said to wait.
    pub const PIECE: usize = Link::<N, CAP>::PIECE;

    /// Makes a session of this machine, without clients.
    #[must_use]
    pub const fn new(machine: DeviceMachine<MOVES>) -> Self {
        let clients = [Link::new(PATIENCE), Link::new(PATIENCE), Link::new(PATIENCE), Link::new(PATIENCE)];
        Self { machine, clients, last: 0, agenda: Agenda::new(), stops_again: false }
    }

    /// Machine of the session, for reading its state.
    #[must_use]
    pub const fn machine(&self) -> &DeviceMachine<MOVES> {
        &self.machine
    }

    /// Stops everything, as a person at the device wants it.
    ///
    /// The stop goes before all reports that wait, and messages that arrived before it do not undo it. Messages that arrive
    /// later are obeyed again.
    ///
    /// # Errors
    ///
    /// [`NotTaken::Full`] if too many stops wait for a poll.
    pub fn stop(&mut self) -> Result<(), NotTaken> {
        self.agenda.stop_all(Told::Stop)
    }

    /// Whether bytes arrived that are not dealt with.
    fn has_unseen(&self) -> bool {
        self.clients.iter().any(Link::has_unseen)
    }

    /// Number of bytes that arrived and are not dealt with.
    #[must_use]
    pub fn held(&self) -> usize {
        self.clients.iter().map(Link::held).fold(0, usize::saturating_add)
    }

    /// Tells that a client is connected, under a number that the caller chooses.
    ///
    /// # Errors
    ///
    /// [`NotTaken::Full`] if too many reports wait for a poll.
    pub fn link_up(&mut self, client: SessionId, transport: Transport) -> Result<(), NotTaken> {
        self.agenda.stop_one(Told::LinkUp(client, transport))?;
        if let Some(link) = self.clients.get_mut(usize::from(client.0)) {
            link.drop_later();
        }
        Ok(())
    }

    /// Tells that a client is gone.
    ///
    /// # Errors
    ///
    /// [`NotTaken::Full`] if too many reports wait for a poll.
    pub fn link_down(&mut self, client: SessionId) -> Result<(), NotTaken> {
        self.agenda.stop_one(Told::LinkDown(client))
    }

    /// Tells what happened to the rig.
    ///
    /// # Errors
    ///
    /// [`NotTaken::Full`] if too many reports wait for a poll.
    pub fn report(&mut self, report: Report) -> Result<(), NotTaken> {
        self.agenda.stop_one(Told::Rig(report))
    }

    /// Takes bytes that arrived from a client, and returns how many: at least [`PIECE`](Self::PIECE) if there are so many, and
    /// [`poll`](Self::poll) said to wait before. Give the others again after the next wait. Bytes from a client
    /// that there cannot be are dropped.
    #[must_use = "bytes that were not taken have to be given again"]
    pub fn receive(&mut self, now: Millis, client: SessionId, bytes: &[u8]) -> usize {
        match self.clients.get_mut(usize::from(client.0)) {
            Some(link) if self.agenda.is_idle() => link.receive(now, bytes),
            Some(_) => 0,
            None => bytes.len(),
        }
    }

    /// Takes a datagram. Returns false if [`poll`](Self::poll) did not say to wait before: give it again after the next
    /// wait. A datagram that is no message is dropped.
    #[must_use = "a datagram that was not taken has to be given again"]
    pub fn receive_datagram(&mut self, now: Millis, from: Sender, bytes: &[u8]) -> bool {
        let is_idle = self.agenda.is_idle();
        let message = Frame::decode(bytes).ok().and_then(|frame| input::message(&frame).ok());
        if let Some(message) = message.filter(|_| is_idle) {
            let output = self.machine.advance(now, Input::Datagram { from, message });
            self.agenda.fill(output, Held::of);
        }
        is_idle
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
            Turn::Transmit(to, len) => Next::Transmit(to, out.get(..len).unwrap_or_default()),
            Turn::Event(held) => Next::Event(self.event(held)),
            Turn::Wait(until) => Next::Wait(until),
        })
    }

    /// Message that came last.
    fn last(&self) -> &[u8] {
        self.clients.get(self.last).map(Link::last).unwrap_or_default()
    }

    /// Tells the machine the next thing that happened. Returns false if nothing did.
    fn advance(&mut self, now: Millis, source: &Source<'_>) -> bool {
        let password = source.password;
        if let Some(News::Wish(told)) = self.agenda.news() {
            let output = match told {
                Told::LinkUp(session, transport) => {
                    self.machine.advance(now, Input::LinkUp { session, transport, password })
                }
                Told::LinkDown(session) => self.machine.advance(now, Input::LinkDown(session)),
                Told::Stop => {
                    self.stops_again = self.held() > 0;
                    self.machine.advance(now, Input::Stop)
                }
                Told::Rig(report) => self.machine.advance(now, Input::Rig(report)),
            };
            self.agenda.fill(output, Held::of);
            return true;
        }
        for (index, (session, link)) in SessionId::ALL.into_iter().zip(&mut self.clients).enumerate() {
            let (output, is_over) = match link.next() {
                Some(Item::Frame(frame)) => {
                    self.last = index;
                    let input = Input::received(session, &frame, password);
                    if self.stops_again && sets_in_motion(&input) {
                        return true;
                    }
                    (self.machine.advance(now, input), false)
                }
                Some(Item::Fatal(_)) => (self.machine.advance(now, Input::Fatal(session)), true),
                Some(Item::Noise { .. } | Item::Corrupt { .. }) => return true,
                None => continue,
            };
            self.agenda.fill(output, Held::of);
            if is_over {
                link.drop_later();
            }
            return true;
        }
        let input = if core::mem::take(&mut self.stops_again) {
            Input::Stop
        } else if self.agenda.is_due(now) {
            Input::Wake
        } else {
            return false;
        };
        let output = self.machine.advance(now, input);
        self.agenda.fill(output, Held::of);
        true
    }
}

/// Whether something may move, or the shutter may open, because of an input. Nothing of the kind that arrived before a stop is
/// done after it.
fn sets_in_motion(input: &Input<'_>) -> bool {
    match input {
        Input::Received { message, .. } => {
            message.conduct().may_move() || matches!(message, HostMessage::TakePicture(_))
        }
        _ => false,
    }
}

impl<const N: usize, const CAP: usize, const MOVES: bool> session::Session for Session<N, CAP, MOVES> {
    type Source<'s> = Source<'s>;
    type Line = (SessionId, Transport);
    type Destination = Destination;
    type Event<'e> = Event<'e>;
    type Held = Held;

    const PIECE: usize = Self::PIECE;

    fn reaches(to: Destination, (client, _): Self::Line) -> bool {
        matches!(to, Destination::Sessions(clients) if clients.contains(client))
    }

    fn request(held: &Held, (client, _): Self::Line) -> Option<LineRequest> {
        let is_over = matches!(held, Held::Event(Event::Disconnect { session, .. }) if *session == client);
        is_over.then_some(LineRequest::Close)
    }

    fn link_up(&mut self, (client, transport): Self::Line) -> Result<(), NotTaken> {
        self.link_up(client, transport)
    }

    fn link_down(&mut self, (client, _): Self::Line) -> Result<(), NotTaken> {
        self.link_down(client)
    }

    fn receive(&mut self, now: Millis, (client, _): Self::Line, bytes: &[u8]) -> usize {
        self.receive(now, client, bytes)
    }

    fn turn(&mut self, now: Millis, source: &Source<'_>, out: &mut [u8]) -> Result<TurnOf<Self>, EncodeError> {
        let held = loop {
            if let Some(held) = self.agenda.pop() {
                break held;
            }
            if !self.advance(now, source) {
                return Ok(Turn::Wait(self.agenda.wake()));
            }
        };
        let transmit = match held {
            Held::Unsupported(destination) => {
                Transmit { destination, contents: Contents::UnsupportedMessage(self.last()) }
            }
            Held::Transmit(transmit) => transmit,
            held => return Ok(Turn::Event(held)),
        };
        let destination = transmit.destination;
        let written = transmit.message(source, &mut Scratch::default()).encode_into(out);
        if let Err(EncodeError::BufferTooSmall { .. }) = written {
            let held = transmit.to_static().map_or(Held::Unsupported(destination), Held::Transmit);
            self.agenda.put_back(held);
        }
        written.map(|len| Turn::Transmit(destination, len))
    }

    fn event(&self, held: Held) -> Event<'_> {
        let message = || Frame::decode(self.last()).ok().and_then(|frame| input::message(&frame).ok());
        let event = match held {
            Held::Event(event) => return event,
            Held::StorePassword | Held::StoreTrajectory => message(),
            Held::Transmit(_) | Held::Unsupported(_) => None,
        };
        match event {
            Some(HostMessage::SetDevicePassword(message)) => Event::StorePassword(message.password),
            Some(HostMessage::SetTrajectoryData(data)) => Event::StoreTrajectory(data),
            _ => Event::MoveOver,
        }
    }
}

session_device! { [impl<const N: usize, const CAP: usize, const MOVES: bool>] Session<N, CAP, MOVES> }

impl<const N: usize, const CAP: usize, const MOVES: bool> fmt::Debug for Session<N, CAP, MOVES> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (machine, held) = (&self.machine, self.held());
        f.debug_struct("Session").field("machine", machine).field("held", &held).finish_non_exhaustive()
    }
}
