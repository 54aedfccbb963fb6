//! Session of a node: the machine with the stream buffers of its ports.

use motion_core::machine::Effect;
use motion_core::session::{self, Agenda, News, Session as _, Turn, TurnOf};
use motion_core::stream::Item;
use motion_core::time::Millis;
use motion_core::wire::EncodeError;
use motion_core::{session_device, session_methods};

use super::machine::Happened;
use super::request::{Reaction, Request};
use super::{Command, Contact, DeviceMachine, EFFECTS, Event, Input, LazyMessage, Port};
use crate::frame::{Frame, MAX_FRAME, PATIENCE, Requests};
use crate::message::{Amperes, Level, Motor, RingTip, Steps, Volts};

pub use motion_core::session::NotTaken;

/// Next thing to do for a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next<'a> {
    /// Do this, or take note of it.
    Event(Event<'a>),
    /// Write these bytes to this port.
    Transmit(Port, &'a [u8]),
    /// Wait until something happens, at most until this time; without a time, as long as it takes.
    Wait(Option<Millis>),
}

/// Effect without what it borrows from the packet that came last.
type Held = Effect<Reaction, Event<'static>>;

/// Stream of one port, which takes pieces of 64 bytes.
type Link = session::Link<Requests, { 2 * MAX_FRAME + 63 }>;

/// Node with the stream buffers of its three ports. A session of a [machine without quirks](DeviceMachine::without_quirks) is a
/// `Session<false>`.
pub struct Session<const QUIRKS: bool = true> {
    machine: DeviceMachine<QUIRKS>,
    links: [Link; 3],
    /// Port on which the last packet came.
    last: Port,
    agenda: Agenda<Input<'static>, Held, EFFECTS>,
    /// Whether what is dealt with arrived before a stop. It sets nothing in motion, and everything is stopped once more after it.
    stops_again: bool,
}

impl<const QUIRKS: bool> Session<QUIRKS> {
    /// Number of bytes that [`receive`](Self::receive) always takes after [`poll`](Self::poll) said to wait.
    pub const PIECE: usize = Link::PIECE;

    /// Makes a session of this machine.
    #[must_use]
    pub const fn new(machine: DeviceMachine<QUIRKS>) -> Self {
        let links = [Link::new(PATIENCE), Link::new(PATIENCE), Link::new(PATIENCE)];
        Self { machine, links, last: Port::Bus, agenda: Agenda::new(), stops_again: false }
    }

    /// Machine of the session, for reading its state.
    #[must_use]
    pub const fn machine(&self) -> &DeviceMachine<QUIRKS> {
        &self.machine
    }

    /// Whether bytes arrived that are not dealt with.
    fn has_unseen(&self) -> bool {
        self.links.iter().any(Link::has_unseen)
    }

    /// Number of bytes that arrived and are not dealt with.
    #[must_use]
    pub fn held(&self) -> usize {
        self.links.iter().map(Link::held).fold(0, usize::saturating_add)
    }

    /// Stops everything, as a person at the device wants it.
    ///
    /// It is [`Command::EmergencyStop`]. It goes before all reports that wait, and reports and packets that arrived before it do
    /// not undo it. Packets that arrive later are obeyed again.
    ///
    /// # Errors
    ///
    /// [`NotTaken::Full`] if too many stops wait for a poll.
    pub fn stop(&mut self) -> Result<(), NotTaken> {
        self.command(Command::EmergencyStop)
    }

    /// A person at the node wants something. An [emergency stop](Command::EmergencyStop) goes before all that waits.
    ///
    /// More is told at [`Input::Command`].
    ///
    /// # Errors
    ///
    /// [`NotTaken::Full`] if too many reports wait for a poll.
    pub fn command(&mut self, command: Command) -> Result<(), NotTaken> {
        match command {
            Command::EmergencyStop => self.agenda.stop_all(Input::Command(command)),
            _ => self.agenda.stop_one(Input::Command(command)),
        }
    }

    fn link(&mut self, port: Port) -> &mut Link {
        let [bus, usb, bluetooth] = &mut self.links;
        match port {
            Port::Bus => bus,
            Port::Usb => usb,
            Port::Bluetooth => bluetooth,
        }
    }

    /// Tells that a master connected to a port.
    ///
    /// # Errors
    ///
    /// [`NotTaken::Full`] if too many reports wait for a poll.
    pub fn link_up(&mut self, port: Port) -> Result<(), NotTaken> {
        self.agenda.stop_one(Input::LinkUp(port))?;
        self.link(port).drop_later();
        Ok(())
    }

    /// Takes bytes that arrived on a port, and returns how many: at least [`PIECE`](Self::PIECE) if there are so many, and
    /// [`poll`](Self::poll) said to wait before. Give the others again after the next wait.
    #[must_use = "bytes that were not taken have to be given again"]
    pub fn receive(&mut self, now: Millis, port: Port, bytes: &[u8]) -> usize {
        if self.agenda.is_idle() { self.link(port).receive(now, bytes) } else { 0 }
    }

    /// Next thing to do. Packets are written to the front of `out`, for which 42 bytes are enough.
    ///
    /// # Errors
    ///
    /// [`EncodeError::BufferTooSmall`]. Call again with as many bytes as the error needs; the packet is not lost.
    pub fn poll<'p>(&'p mut self, now: Millis, out: &'p mut [u8]) -> Result<Next<'p>, EncodeError> {
        Ok(match self.turn(now, &(), out)? {
            Turn::Transmit(port, len) => Next::Transmit(port, out.get(..len).unwrap_or_default()),
            Turn::Event(held) => Next::Event(self.event(held)),
            Turn::Wait(until) => Next::Wait(until),
        })
    }

    /// Packet that came last.
    fn packet(&self) -> &[u8] {
        let [bus, usb, bluetooth] = &self.links;
        match self.last {
            Port::Bus => bus.last(),
            Port::Usb => usb.last(),
            Port::Bluetooth => bluetooth.last(),
        }
    }

    /// Tells the machine the next thing that happened. Returns false if nothing did.
    fn advance(&mut self, now: Millis) -> bool {
        let happened = if let Some(News::Wish(report)) = self.agenda.news() {
            if matches!(report, Input::Command(Command::EmergencyStop)) {
                self.stops_again = !self.agenda.is_settled() || self.held() > 0;
            }
            Happened::Report(report)
        } else if let Some(arrived) = self.next_arrival(now) {
            arrived
        } else if core::mem::take(&mut self.stops_again) {
            Happened::Report(Input::Command(Command::EmergencyStop))
        } else if self.agenda.is_due(now) {
            Happened::Report(Input::Wake)
        } else {
            return false;
        };
        // Nothing that arrived before a stop sets anything in motion after it.
        if !self.stops_again || !happened.sets_in_motion() {
            self.agenda.fill(self.machine.act(now, happened), |effect| effect);
        }
        true
    }

    /// Next packet or noise of any port.
    fn next_arrival(&mut self, now: Millis) -> Option<Happened<'static>> {
        for (port, link) in [Port::Bus, Port::Usb, Port::Bluetooth].into_iter().zip(&mut self.links) {
            loop {
                let Some(item) = link.next() else {
                    if link.give_up(now) {
                        continue;
                    }
                    break;
                };
                let Item::Frame(frame) = item else { return Some(Happened::Report(Input::Noise)) };
                self.last = port;
                let (selector, data) = frame.request();
                return Some(Happened::Request(port, frame.address(), Request::new(selector, data)));
            }
        }
        None
    }
}

impl<const QUIRKS: bool> session::Session for Session<QUIRKS> {
    type Source<'s> = ();
    type Line = Port;
    type Destination = Port;
    type Event<'e> = Event<'e>;
    type Held = Held;

    const PIECE: usize = Self::PIECE;

    fn reaches(to: Port, line: Port) -> bool {
        to == line
    }

    fn link_up(&mut self, port: Port) -> Result<(), NotTaken> {
        self.link_up(port)
    }

    fn link_down(&mut self, port: Port) -> Result<(), NotTaken> {
        self.link_down(port)
    }

    fn receive(&mut self, now: Millis, port: Port, bytes: &[u8]) -> usize {
        self.receive(now, port, bytes)
    }

    fn turn(&mut self, now: Millis, (): &(), out: &mut [u8]) -> Result<TurnOf<Self>, EncodeError> {
        let held = loop {
            if let Some(held) = self.agenda.pop() {
                break held;
            }
            if !self.advance(now) {
                let cut = self.links.iter().filter_map(Link::deadline);
                return Ok(Turn::Wait(cut.chain(self.agenda.wake()).min()));
            }
        };
        let (port, written) = match held {
            Effect::Transmit(Reaction::Answer(port, response)) => (port, response.encode_into(out)),
            Effect::Transmit(Reaction::Forward(port)) => (port, copied(self.packet(), out)),
            held => return Ok(Turn::Event(held)),
        };
        if written.is_err() {
            self.agenda.put_back(held);
        }
        written.map(|len| Turn::Transmit(port, len))
    }

    fn event(&self, held: Held) -> Event<'_> {
        match (held, Frame::decode(self.packet())) {
            (Effect::Event(event), _) => event,
            (Effect::Transmit(Reaction::Ignore(port, to, why)), Ok(frame)) => {
                Event::Ignored { port, to, message: LazyMessage::of(&frame), why }
            }
            _ => Event::Noise,
        }
    }
}

session_device! { [impl<const QUIRKS: bool>] Session<QUIRKS> }

/// Copies a packet to the front of `out`.
fn copied(packet: &[u8], out: &mut [u8]) -> Result<usize, EncodeError> {
    let have = out.len();
    let place = out.get_mut(..packet.len()).ok_or(EncodeError::BufferTooSmall { needed: packet.len(), have })?;
    for (to, from) in place.iter_mut().zip(packet) {
        *to = *from;
    }
    Ok(packet.len())
}

session_methods! {
    impl<const QUIRKS: bool> Session<QUIRKS> as Input, see Input;
    stop_one {
        /// The master of a port disconnected.
        LinkDown link_down(port: Port) => (port);
        /// A motor has a new position.
        Position position(motor: Motor, position: Steps) => { motor, position };
        /// A motor reached the end of its move.
        Arrived arrived(motor: Motor) => (motor);
        /// A motor cannot go on. It is stopped, and a program pauses.
        Fault fault(motor: Motor) => (motor);
        /// The edge that counts came at a contact of the auxiliary connector.
        Alt alt(contact: Contact) => (contact);
        /// The common line asks for the next picture.
        CommonLine common_line();
        /// Levels of the limit switches.
        Limits limits(levels: RingTip<Level>) => (levels);
        /// Supply of the node.
        Supply supply(volts: Volts, amperes: Amperes) => { volts, amperes };
    }
}
