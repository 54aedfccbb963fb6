//! The master of a bus: what the application wants goes in, and what became of it comes out with its content.
//!
//! It is a [`HostMachine`] with a line. It keeps what was asked, so that answers can be read, and knows whether something
//! may still move because of it.
//!
//! ```
//! use hoot_proto::host::{Command, Options, Request, Token};
//! use hoot_proto::message::{Motor, MotorPosition, Steps};
//! use hoot_proto::{Address, HostMessage};
//! use motion_core::time::Millis;
//! use rigs::Scene;
//! use rigs::faults::{Carrier, Faults};
//! use rigs::hoot_master::{Event, HootMaster};
//! use rigs::hoot_node::{HootNode, Setup};
//!
//! let (master, node) = (HootMaster::new(Options::default()), HootNode::new(Setup::default()));
//! let mut scene = Scene::new(master, node, Carrier::Serial, Faults::NONE, 1);
//! scene.run(Millis(10), |_, event| matches!(event, Event::Line(true)).then_some(()));
//!
//! let query = MotorPosition { motor: Motor::One };
//! let message = HostMessage::MotorPosition(query);
//! scene.command(Command::Request(Request { token: Token(1), to: Address::DEFAULT, message }));
//! let position = scene.run(Millis(1000), |_, event| {
//!     if let Event::Ended(ended) = event { ended.read(&query) } else { None }
//! });
//! assert_eq!(position, Some(Steps(0)));
//! ```

mod moving;

use std::collections::{BTreeMap, VecDeque};
use std::fmt;

use hoot_proto::frame::MAX_FRAME;
use hoot_proto::host::{self, Command, Failure, HostMachine, Input, Options, Outcome, Request, Token};
use hoot_proto::query::{Answer, AnyReply, Profile};
use hoot_proto::{Address, DeviceMessage, Frames, HostMessage, Item, Query};
use motion_core::machine::Machine;
use motion_core::time::Millis;
use tracing::{debug, warn};

use crate::{Host, LineId, Outgoing, Party};
use moving::Moving;

/// After how many milliseconds of silence the rest of a packet is not awaited any more.
const GAP: u64 = 101;
/// The one line.
const LINE: LineId = LineId(0);

/// What a master tells.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Event {
    /// The line is there, or has gone.
    Line(bool),
    /// A request has come to its end: each does, once.
    Ended(Ended),
    /// What the machine tells beside that: of stops, of speeds and of keep-alives.
    Told(host::Event),
}

/// A request that has come to its end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ended {
    /// The application's number of it.
    pub token: Token,
    /// Whom it was for.
    pub to: Address,
    /// What it said.
    pub message: HostMessage<'static>,
    /// How it ended.
    pub outcome: Outcome,
}

impl Ended {
    /// Whether the node did it.
    #[must_use]
    pub const fn is_done(&self) -> bool {
        matches!(self.outcome, Outcome::Done(_))
    }

    /// Whether nobody answered: it may have been done all the same.
    #[must_use]
    pub const fn is_silence(&self) -> bool {
        matches!(self.outcome, Outcome::Failed(Failure::Silence))
    }

    /// What the node said, if it was asked for something.
    #[must_use]
    pub fn answer(&self) -> Option<AnyReply<'_>> {
        let Outcome::Done(received) = &self.outcome else { return None };
        self.message.query()?.decode_reply(received.reply()).ok()
    }

    /// What the node said to this query.
    #[must_use]
    pub fn read<'a, Q, T>(&'a self, query: &Q) -> Option<T>
    where
        Q: Query<Reply<'a> = Answer<T>>,
    {
        let Outcome::Done(received) = &self.outcome else { return None };
        query.decode_reply(received.reply()).ok().map(|answer| answer.value)
    }
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { to: Address(to), message, outcome, .. } = self;
        match outcome {
            Outcome::Done(_) => match self.answer() {
                Some(answer) => write!(f, "node {to}: {message}: {answer}"),
                None => write!(f, "node {to}: {message}: done"),
            },
            Outcome::Refused(_) => write!(f, "node {to} refuses {message}"),
            Outcome::Sent => write!(f, "node {to}: {message}: sent"),
            Outcome::Failed(Failure::Silence) => write!(f, "node {to} does not answer {message}"),
            Outcome::Failed(Failure::NotTaken(why)) => write!(f, "{message} was not sent: {why:?}"),
            Outcome::Failed(why) => write!(f, "node {to}: {message}: {why:?}"),
            other => write!(f, "node {to}: {message}: {other:?}"),
        }
    }
}

/// A request that is under way.
#[derive(Debug, Clone)]
struct Pending {
    request: Request,
    /// What may move because of it, and did not before.
    added: Vec<(Address, u8)>,
}

/// The master of a bus, with a line.
#[derive(Debug)]
pub struct HootMaster {
    machine: HostMachine,
    wake: Option<Millis>,
    now: Millis,
    frames: Frames,
    heard: Millis,
    /// No more than the machine has room for.
    pending: Vec<Pending>,
    moving: Moving,
    profiles: BTreeMap<Address, Profile>,
    strays: u64,
    outgoing: VecDeque<Outgoing>,
    events: VecDeque<Event>,
}

impl HootMaster {
    /// A master without a line.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self {
            machine: HostMachine::new(options),
            wake: None,
            now: Millis(0),
            frames: Frames::new(),
            heard: Millis(0),
            pending: Vec::new(),
            moving: Moving::default(),
            profiles: BTreeMap::new(),
            strays: 0,
            outgoing: VecDeque::new(),
            events: VecDeque::new(),
        }
    }

    /// The machine, to look at.
    #[must_use]
    pub const fn machine(&self) -> &HostMachine {
        &self.machine
    }

    /// The firmware of a node, if it was asked for its version.
    #[must_use]
    pub fn profile(&self, node: Address) -> Profile {
        self.profiles.get(&node).copied().unwrap_or_default()
    }

    /// Whether something may move that was set in motion from here.
    ///
    /// It is over when each motor said that it rests, and the program that it does not run; when the node took a stop; or
    /// when an emergency stop was confirmed.
    #[must_use]
    pub fn may_move(&self) -> bool {
        !self.moving.is_empty()
    }

    /// Packets and bytes that were nobody's: noise, late answers, traffic of others.
    #[must_use]
    pub const fn strays(&self) -> u64 {
        self.strays
    }

    /// Bytes that wait: for the rest of their packet, or to be taken by [`poll`](Party::poll).
    #[must_use]
    pub fn held(&self) -> usize {
        self.frames.held() + crate::waiting(&self.outgoing)
    }

    fn step(&mut self, input: Input<'_>) {
        let (machine, output) = self.machine.clone().step(self.now, input);
        self.machine = machine;
        self.wake = output.wake;
        for event in output.events {
            self.told(event);
        }
        for send in output.send {
            let mut packet = [0; MAX_FRAME];
            match send.encode_into(&mut packet) {
                Ok(len) => {
                    debug!("> {}: {}", send.to.0, send.message);
                    // What has arrived cannot be an answer to it.
                    self.frames.reset();
                    self.outgoing.push_back(Outgoing::Bytes(LINE, packet[..len].to_vec()));
                }
                Err(error) => warn!("{}: {error}", send.message),
            }
        }
    }

    fn told(&mut self, event: host::Event) {
        match event {
            host::Event::Ended { token, outcome } => self.ended(token, outcome),
            host::Event::Unsolicited(_) | host::Event::Overheard { .. } | host::Event::Noise => {
                debug!("nobody's: {event:?}");
                self.strays += 1;
            }
            host::Event::StopConfirmed => {
                self.moving.clear();
                self.events.push_back(Event::Told(event));
            }
            event => self.events.push_back(Event::Told(event)),
        }
    }

    fn ended(&mut self, token: Token, outcome: Outcome) {
        let Some(at) = self.pending.iter().position(|pending| pending.request.token == token) else { return };
        let Pending { request: Request { to, message, .. }, added } = self.pending.remove(at);
        let ended = Ended { token, to, message, outcome };
        debug!("{ended}");
        match &ended.outcome {
            Outcome::Done(_) => {
                if let Some(AnyReply::FirmwareVersion(version)) = ended.answer() {
                    self.profiles.insert(to, Profile::of_version(&version));
                }
                // An answer from before something was set in motion says nothing of it.
                let waits = self.pending.iter().any(|other| other.request.to == to && !other.added.is_empty());
                if !waits {
                    self.moving.done(self.profile(to), to, &message, ended.answer());
                }
            }
            // A refusal might be one of something else: only what did not go out set nothing in motion.
            Outcome::Failed(Failure::NotTaken(_) | Failure::Dropped { was_sent: false, .. }) => {
                self.moving.not_done(&added);
            }
            _ => {}
        }
        self.events.push_back(Event::Ended(ended));
    }

    /// Drops what a silence has cut off.
    fn drop_cut_off(&mut self) {
        if self.frames.held() > 0 && self.now >= self.heard.after(GAP) {
            self.frames.gap();
            self.take_packets();
        }
    }

    fn take_packets(&mut self) {
        loop {
            let packet = match self.frames.next() {
                Some(Item::Frame(frame)) => Some(frame.bytes().to_vec()),
                Some(_) => None,
                None => return,
            };
            let frame = packet.as_deref().and_then(|packet| hoot_proto::Frame::decode(packet).ok());
            match frame {
                Some(frame) => {
                    let message = DeviceMessage::decode(&frame);
                    debug!("< {message}");
                    self.step(Input::Received(message));
                }
                None => self.step(Input::Noise),
            }
        }
    }
}

impl Party for HootMaster {
    fn open(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        if line == LINE {
            self.frames.reset();
            self.events.push_back(Event::Line(true));
            self.step(Input::LinkUp);
        }
    }

    fn close(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        if line == LINE {
            self.frames.reset();
            self.outgoing.clear();
            self.events.push_back(Event::Line(false));
            self.step(Input::LinkDown);
        }
    }

    fn receive(&mut self, now: Millis, line: LineId, bytes: &[u8]) {
        self.advance(now);
        if line != LINE {
            return;
        }
        self.heard = self.now;
        let mut rest = bytes;
        while !rest.is_empty() {
            let taken = self.frames.push(rest);
            rest = &rest[taken..];
            self.take_packets();
        }
    }

    fn advance(&mut self, now: Millis) {
        self.now = self.now.max(now);
        self.drop_cut_off();
        if self.wake.is_some_and(|wake| wake <= self.now) {
            self.step(Input::Wake);
        }
    }

    fn wake(&self) -> Option<Millis> {
        let cut_off = (self.frames.held() > 0).then(|| self.heard.after(GAP));
        [cut_off, self.wake].into_iter().flatten().min()
    }

    fn poll(&mut self) -> Option<Outgoing> {
        self.outgoing.pop_front()
    }
}

impl Host for HootMaster {
    type Command = Command;
    type Event = Event;

    fn command(&mut self, now: Millis, command: Command) {
        self.advance(now);
        match command {
            Command::Request(request) | Command::Insist(request) => {
                let nodes = *self.machine.nodes();
                let added = self.moving.asked(nodes.as_slice(), request.to, &request.message);
                self.pending.push(Pending { request, added });
            }
            Command::Speed { to, motor, speed } => {
                let message = hoot_proto::message::MotorSetContinuousSpeed { motor, speed };
                let message = HostMessage::MotorSetContinuousSpeed(message);
                self.moving.asked(&[], to, &message);
            }
            _ => {}
        }
        self.step(Input::Command(command));
    }

    fn next_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }
}
