//! The master of a bus: commands go in, and events come out together with the answers that they are about.
//!
//! It is a [`Session`] that keeps the commands until they end, so that their answers can be read, and that learns the
//! firmware of the nodes.
//!
//! ```
//! use hoot_proto::Address;
//! use hoot_proto::host::{self, Command, Options, Request, Token};
//! use hoot_proto::message::{Motor, MotorPosition, Steps};
//! use motion_core::time::Millis;
//! use motion_rigs::Scene;
//! use motion_rigs::faults::{Carrier, Faults};
//! use motion_rigs::hoot_master::{Event, HootMaster};
//! use motion_rigs::hoot_node::{HootNode, Setup};
//!
//! let (master, node) = (HootMaster::new(Options::default()), HootNode::new(Setup::default()));
//! let mut scene = Scene::new(master, node, Carrier::Serial, Faults::NONE, 1);
//! let first = scene.run(Millis(10), |_, event| Some(event));
//! assert_eq!(first, Some(Event::Machine(host::Event::Ready { reconnected: false })));
//!
//! let query = MotorPosition { motor: Motor::One };
//! let request = Request { to: Address::DEFAULT, message: query.into() };
//! scene.command((Token(1), Command::Request(request)));
//! let position = scene.run(Millis(1000), |_, event| {
//!     if let Event::Ended(ended) = event { ended.read(&query) } else { None }
//! });
//! assert_eq!(position, Some(Steps(0)));
//! ```

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt;

use hoot_proto::frame::MAX_FRAME;
use hoot_proto::host::{self, Command, Failure, HostMachine, Next, Options, Outcome, Request, Session, Token};
use hoot_proto::message::{HostMessage, MotorSetContinuousSpeed, Reply};
use hoot_proto::query::{Answer, AnyReply, Profile};
use hoot_proto::{Address, Frame, Query};
use motion_core::time::Millis;
use tracing::{debug, warn};

use crate::{Host, LineId, Outgoing, Party};

/// Only line of a master.
const LINE: LineId = LineId(0);

/// Event of a master.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Event {
    /// A command ended. Each command ends once.
    Ended(Ended),
    /// The machine tells something else: of the line, of stops, of keep-alives.
    Machine(host::Event<'static>),
}

/// End of a command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ended {
    /// Token of the command.
    pub token: Token,
    /// The command.
    pub command: Command,
    /// How the command ended, without the data of a reply.
    outcome: Outcome<'static>,
    data: Vec<u8>,
}

impl Ended {
    fn new(token: Token, command: Command, outcome: Outcome<'_>) -> Option<Self> {
        let (outcome, data) = match outcome {
            Outcome::Done(Reply { code, data }) => (Outcome::Done(Reply { code, data: &[] }), data.to_vec()),
            outcome => (outcome.to_static()?, Vec::new()),
        };
        Some(Self { token, command, outcome, data })
    }

    /// How the command ended.
    #[must_use]
    pub fn outcome(&self) -> Outcome<'_> {
        match self.outcome {
            Outcome::Done(Reply { code, .. }) => Outcome::Done(Reply { code, data: &self.data }),
            outcome => outcome,
        }
    }

    /// Message that the command sends to a node, if it sends one.
    #[must_use]
    pub fn request(&self) -> Option<Request> {
        match self.command {
            Command::Request(request) | Command::Insist(request) => Some(request),
            Command::Speed { to, motor, speed } => {
                Some(Request { to, message: MotorSetContinuousSpeed { motor, speed }.into() })
            }
            _ => None,
        }
    }

    /// Whether the node did it.
    #[must_use]
    pub const fn is_done(&self) -> bool {
        matches!(self.outcome, Outcome::Done(_))
    }

    /// Whether no clear answer came. The command may have been done.
    #[must_use]
    pub const fn is_unanswered(&self) -> bool {
        matches!(self.outcome, Outcome::NotConfirmed | Outcome::Failed(Failure::NoAnswer))
    }

    /// Value that the node answered, if the message asks for one.
    #[must_use]
    pub fn answer(&self) -> Option<AnyReply<'_>> {
        let Outcome::Done(reply) = self.outcome() else { return None };
        self.request()?.message.query()?.decode_reply(reply).ok()
    }

    /// Value that the node answered to this query.
    #[must_use]
    pub fn read<'a, Q, T>(&'a self, query: &Q) -> Option<T>
    where
        Q: Query<Reply<'a> = Answer<T>>,
    {
        let Outcome::Done(reply) = self.outcome() else { return None };
        query.decode_reply(reply).ok().map(|answer| answer.value)
    }
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.request() {
            Some(Request { to, message }) => write!(f, "node {}: {message}: ", to.0)?,
            None => write!(f, "{:?}: ", self.command)?,
        }
        match self.answer() {
            Some(answer) => answer.fmt(f),
            None => self.outcome().fmt(f),
        }
    }
}

/// Master of a bus, with its line.
#[derive(Debug)]
pub struct HootMaster {
    session: Session,
    /// Time until which the session waits.
    until: Option<Millis>,
    outgoing: VecDeque<Outgoing>,
    book: Book,
}

/// Commands, and what their answers tell.
#[derive(Debug, Default)]
struct Book {
    /// Commands that have not ended. There are no more than the machine has room for.
    pending: BTreeMap<Token, Command>,
    profiles: BTreeMap<Address, Profile>,
    /// Nodes that are not in joystick mode, in which a refusal tells nothing of the firmware.
    calm: BTreeSet<Address>,
    strays: u64,
    events: VecDeque<Event>,
}

impl HootMaster {
    /// A master without a line.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self { session: Session::new(options), until: None, outgoing: VecDeque::new(), book: Book::default() }
    }

    /// Machine of the master, for reading its state.
    #[must_use]
    pub const fn machine(&self) -> &HostMachine {
        self.session.machine()
    }

    /// Firmware of a node, as far as its answers tell: to the query for its version, and to queries that firmware of some age
    /// refuses ([`Profile::that_answers`]).
    #[must_use]
    pub fn profile(&self, node: Address) -> Profile {
        self.book.profile(node)
    }

    /// Number of packets and noises that answered nothing that was asked: late answers, traffic of others, damaged bytes.
    #[must_use]
    pub const fn strays(&self) -> u64 {
        self.book.strays
    }

    /// Number of bytes that wait: for the rest of their packet, or to be taken by [`poll`](Party::poll).
    #[must_use]
    pub fn held(&self) -> usize {
        self.session.held() + crate::waiting(&self.outgoing)
    }

    /// Carries out what the session wants, until it waits.
    fn settle(&mut self, now: Millis) {
        let mut packet = [0; MAX_FRAME];
        loop {
            match self.session.poll(now, &mut packet) {
                Ok(Next::Transmit(packet)) => {
                    if let Ok(frame) = Frame::decode(packet) {
                        debug!("> {}: {}", frame.address().0, HostMessage::decode(&frame));
                    }
                    self.outgoing.push_back(Outgoing::Bytes(LINE, packet.to_vec()));
                }
                Ok(Next::Event(event)) => self.book.note(&event),
                Ok(Next::Wait(until)) => return self.until = until,
                Err(error) => return warn!("{error}"),
            }
        }
    }
}

impl Book {
    fn profile(&self, node: Address) -> Profile {
        self.profiles.get(&node).copied().unwrap_or_default()
    }

    fn note(&mut self, event: &host::Event<'_>) {
        match event {
            host::Event::Ended { token, outcome } => self.ended(*token, *outcome),
            host::Event::Unsolicited(_) | host::Event::Overheard { .. } | host::Event::Noise => {
                debug!("not an answer: {event:?}");
                self.strays += 1;
            }
            event => self.events.extend(event.to_static().map(Event::Machine)),
        }
    }

    fn ended(&mut self, token: Token, outcome: Outcome<'_>) {
        let command = self.pending.remove(&token);
        let Some(ended) = command.and_then(|command| Ended::new(token, command, outcome)) else { return };
        debug!("{ended}");
        if let Some(request) = ended.request() {
            self.learn(request.to, &request.message, &ended);
        }
        self.events.push_back(Event::Ended(ended));
    }

    /// Learns the firmware of a node by its answer to a message.
    fn learn(&mut self, node: Address, message: &HostMessage<'_>, ended: &Ended) {
        let was_calm = self.calm.contains(&node);
        let is_refused = matches!(ended.outcome, Outcome::Refused(host::Refusal::Device(_)));
        let answers = match (message, ended.answer()) {
            (_, Some(AnyReply::FirmwareVersion(version))) => {
                self.profiles.insert(node, Profile::of_version(&version).and(self.profile(node)));
                return;
            }
            (HostMessage::SetJoystickMode(_), _) => {
                self.calm.remove(&node);
                return;
            }
            (HostMessage::JoystickMode(_), _) if is_refused => false,
            (_, Some(_)) => true,
            _ if is_refused && was_calm => false,
            _ => return,
        };
        match (message, ended.answer()) {
            (_, Some(AnyReply::JoystickMode(mode))) if mode.value.get() => self.calm.remove(&node),
            (HostMessage::JoystickMode(_), _) => self.calm.insert(node),
            _ => false,
        };
        let profile = self.profile(node).that_answers(message, answers);
        self.profiles.insert(node, profile);
    }
}

impl Party for HootMaster {
    fn open(&mut self, now: Millis, line: LineId) {
        if line == LINE {
            self.session.link_up();
            self.settle(now);
        }
    }

    fn close(&mut self, now: Millis, line: LineId) {
        if line == LINE {
            self.outgoing.clear();
            self.session.link_down();
            self.settle(now);
        }
    }

    fn receive(&mut self, now: Millis, line: LineId, bytes: &[u8]) {
        let mut rest = if line == LINE { bytes } else { &[] };
        while !rest.is_empty() {
            let taken = self.session.receive(now, rest);
            rest = &rest[taken..];
            self.settle(now);
        }
    }

    fn advance(&mut self, now: Millis) {
        if self.until.is_some_and(|until| until <= now) {
            self.settle(now);
        }
    }

    fn wake(&self) -> Option<Millis> {
        self.until
    }

    fn poll(&mut self) -> Option<Outgoing> {
        self.outgoing.pop_front()
    }
}

impl Host for HootMaster {
    type Command = (Token, Command);
    type Event = Event;

    fn command(&mut self, now: Millis, (token, command): (Token, Command)) {
        if let Err(error) = self.session.command(token, command) {
            return warn!("{error}");
        }
        self.book.pending.insert(token, command);
        self.settle(now);
    }

    fn next_event(&mut self) -> Option<Event> {
        self.book.events.pop_front()
    }
}
