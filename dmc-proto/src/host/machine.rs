//! The machine itself: the connection, what arrives over it, and what time it is. DMC D5.

use core::fmt;

use motion_core::machine::Machine;
use motion_core::time::Millis;

use super::connection::{Connection, State, kept};
use super::io::{Event, Failure, Input, Outcome, Output, Send, What};
use super::options::{GREETINGS, Options};
use super::requests::{Garbled, Ids, Owner, Request, Requests, Role};
use super::sequence::{Course, Progress, Reply, Sequence};
use super::stops::{Acknowledged, Line, Stop, Stops};
use crate::frame::{MessageId, MessageType};
use crate::message::{Ack, AckCode, DeviceMessage, HardStop, Hi, Motors};

/// A host: when it sends what, and what came of it.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct HostMachine {
    pub(super) options: Options,
    pub(super) state: Connection,
    pub(super) device: Option<Hi<'static>>,
    pub(super) ids: Ids,
    pub(super) requests: Requests,
    pub(super) stops: Stops,
    pub(super) sequence: Option<Sequence>,
    /// Whether the device may wait for the signal to start something, or do it.
    pub(super) is_armed: bool,
    /// The motors that are driven by hand during a move.
    pub(super) live: Motors,
    /// Whether the device has a move, as far as is known.
    pub(super) is_loaded: Option<bool>,
}

impl HostMachine {
    /// A host whose line is closed.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self {
            options,
            state: Connection::Closed,
            device: None,
            ids: Ids::default(),
            requests: Requests::default(),
            stops: Stops::default(),
            sequence: None,
            is_armed: false,
            live: Motors::NONE,
            is_loaded: None,
        }
    }

    /// How far the connection is.
    #[must_use]
    pub const fn state(&self) -> State {
        self.state.state()
    }

    /// What it was made with.
    #[must_use]
    pub const fn options(&self) -> &Options {
        &self.options
    }

    /// What the device said of itself in this connection.
    #[must_use]
    pub const fn device(&self) -> Option<Hi<'static>> {
        self.device
    }

    /// How far the sequence is, if one runs.
    #[must_use]
    pub fn progress(&self) -> Option<Progress> {
        self.sequence.as_ref().map(Sequence::progress)
    }

    /// Whether the device has a move that can be run; `None` if nobody knows.
    #[must_use]
    pub const fn is_loaded(&self) -> Option<bool> {
        self.is_loaded
    }

    /// Whether the device may still begin a run or a shot, or be in one. It stays so after a sequence that failed midway:
    /// only a stop of everything makes it safe to come near. Neither a hard stop nor a reset ends it, since the news of them
    /// may be older than what is on its way to the device (decision D-60).
    #[must_use]
    pub const fn is_armed(&self) -> bool {
        self.is_armed
    }

    /// The stops that are not confirmed.
    pub fn unconfirmed_stops(&self) -> impl Iterator<Item = Stop> {
        self.stops.iter()
    }

    /// The requests on their way: id and type.
    pub fn pending(&self) -> impl Iterator<Item = (MessageId, MessageType)> {
        self.requests.pending()
    }

    pub(super) fn line<'l>(&'l mut self, now: Millis, output: &'l mut Output) -> (&'l mut Stops, Line<'l>) {
        (&mut self.stops, Line { now, options: &self.options, ids: &mut self.ids, output })
    }

    /// Asks the device who it is, and forgets what it was.
    pub(super) fn greet(&mut self, now: Millis, tries: u8, output: &mut Output) {
        let id = self.ids.next(&self.options);
        output.send(Send { id, what: What::Greeting });
        self.state = Connection::Greeting(tries, now.after(self.options.times.greeting.into()));
        self.device = None;
        self.live = Motors::NONE;
    }

    fn link_up(&mut self, now: Millis, output: &mut Output) {
        self.link_down(output);
        let (stops, mut line) = self.line(now, output);
        stops.link_up(&mut line);
        self.is_loaded = None;
        self.greet(now, 1, output);
    }

    /// What was on its way is lost. If the line was closed already, nothing is.
    fn link_down(&mut self, output: &mut Output) {
        if self.state == Connection::Closed {
            return;
        }
        self.state = Connection::Closed;
        output.event(Event::Closed);
        self.stops.link_down(output);
        self.fail(|_| true, Failure::NotUp, output);
    }

    /// Fails requests, and the sequence if it moves motors or everything fails.
    pub(super) fn fail(&mut self, which: impl Fn(&Request) -> bool, failure: Failure, output: &mut Output) {
        for request in self.requests.cancel(which) {
            if let Owner::Application(token) = request.owner {
                output.event(Event::Failed(token, failure));
            }
        }
        let is_stopped = |sequence: &Sequence| match sequence.course {
            Course::Run(_) => true,
            Course::Upload(_) => matches!(failure, Failure::NotUp | Failure::DeviceReset),
        };
        if self.sequence.as_ref().is_some_and(is_stopped) {
            self.sequence_over(Err(failure), output);
        }
    }

    fn received(&mut self, now: Millis, id: MessageId, message: &DeviceMessage<'_>, output: &mut Output) {
        let stray = Event::Stray(id, message.kind());
        match message {
            _ if self.state == Connection::Closed => output.event(stray),
            DeviceMessage::Hi(hi) => self.greeted(now, id, hi, output),
            DeviceMessage::Ack(ack) => self.acknowledged(now, id, ack, output),
            DeviceMessage::MotorHardStop(stop) => self.hard_stop(stop, output),
            DeviceMessage::MotorStatus(status) => {
                let armed = self.is_armed;
                let (stops, mut line) = self.line(now, output);
                if !stops.status(id, status.motor_status, armed, &mut line) {
                    self.answered(now, id, message.kind(), Reply::Moving(status.motor_status), output);
                }
            }
            DeviceMessage::RtGo(_) | DeviceMessage::RtEnd(_) => self.told(now, message, output),
            DeviceMessage::MotorMove(_) => self.answered(now, id, message.kind(), Reply::Answered, output),
            DeviceMessage::GioIn(_)
            | DeviceMessage::MotorGetPosition(_)
            | DeviceMessage::VirtGetPosition(_)
            | DeviceMessage::VirtAimPoint(_) => self.asked_or_not(now, id, message, output),
            DeviceMessage::Other(_) => output.event(stray),
        }
    }

    /// What a device tells when it is asked, and also unasked.
    fn asked_or_not(&mut self, now: Millis, id: MessageId, message: &DeviceMessage<'_>, output: &mut Output) {
        if let Some(request) = self.requests.answered(id, message.kind()) {
            return self.settle(now, request, Reply::Answered, output);
        }
        let run = self.sequence.as_mut().and_then(Sequence::run);
        if let (DeviceMessage::MotorGetPosition(_), Some(run)) = (message, run) {
            run.heard(now);
        }
        output.event(Event::Unasked(message.kind()));
    }

    /// Decision D-46: with id 0, and not while it is waited for, the device was reset.
    fn greeted(&mut self, now: Millis, id: MessageId, hi: &Hi<'_>, output: &mut Output) {
        match self.state {
            Connection::Greeting(..) | Connection::Silent => {
                self.device = Some(kept(hi));
                if id == MessageId::UNSOLICITED {
                    self.is_loaded = Some(false);
                }
                self.state = Connection::Configuring(false);
                output.event(Event::Greeted);
            }
            _ if id == MessageId::UNSOLICITED => {
                output.event(Event::DeviceReset);
                self.fail(|_| true, Failure::DeviceReset, output);
                self.is_loaded = Some(false);
                self.greet(now, 1, output);
            }
            _ => self.answered(now, id, DeviceMessage::Hi(*hi).kind(), Reply::Answered, output),
        }
    }

    fn acknowledged(&mut self, now: Millis, id: MessageId, ack: &Ack<'_>, output: &mut Output) {
        let (stops, mut line) = self.line(now, output);
        match stops.acknowledged(id, ack, &mut line) {
            Acknowledged::Confirms(stop) => {
                self.is_armed &= !stop.is_all();
                return;
            }
            Acknowledged::Refuses => return,
            Acknowledged::Other => {}
        }
        let reply = match ack.response_code {
            Some(AckCode::OK) => Reply::Acknowledged,
            Some(AckCode::ERR_CHECKSUM) => return self.garbled(now, id, ack, output),
            Some(code) => Reply::Failed(Failure::Refused(code)),
            None => Reply::Failed(Failure::Unclear),
        };
        self.answered(now, id, ack.of, reply, output);
    }

    /// The request is known by its id alone: its type may be what arrived wrong (decision D-8).
    fn garbled(&mut self, now: Millis, id: MessageId, ack: &Ack<'_>, output: &mut Output) {
        match self.requests.garbled(now, id, &self.options) {
            Garbled::Over(request) => {
                self.settle(now, request, Reply::Failed(Failure::Refused(AckCode::ERR_CHECKSUM)), output);
            }
            Garbled::Again => {}
            Garbled::Unknown => output.event(Event::Stray(id, ack.of.ack())),
        }
    }

    fn answered(&mut self, now: Millis, id: MessageId, kind: MessageType, reply: Reply, output: &mut Output) {
        match self.requests.answered(id, kind) {
            Some(request) => self.settle(now, request, reply, output),
            None => output.event(Event::Stray(id, kind)),
        }
    }

    /// A request is over.
    fn settle(&mut self, now: Millis, request: Request, reply: Reply, output: &mut Output) {
        match (request.conduct.role, reply) {
            (Role::Configures, Reply::Failed(_)) => self.live = Motors::NONE,
            // If something moves, that may be what an earlier request began; and who knows what arrived wrong.
            (Role::Arms, Reply::Failed(Failure::Refused(code))) => {
                self.is_armed &= matches!(code, AckCode::ERR_MOVING | AckCode::ERR_CHECKSUM);
            }
            (Role::StopsLoop, Reply::Acknowledged) => {
                if let Some(run) = self.sequence.as_mut().and_then(Sequence::run) {
                    run.loop_ends(now);
                }
            }
            _ => {}
        }
        match (request.owner, reply) {
            (Owner::Sequence, _) => self.sequence_answered(now, reply, output),
            (Owner::Question, Reply::Moving(motors)) => output.event(Event::Moving(motors)),
            (Owner::Question, _) => {}
            (Owner::Application(token), Reply::Failed(failure)) => output.event(Event::Failed(token, failure)),
            (Owner::Application(token), Reply::Acknowledged) => {
                output.event(Event::Done(token, Outcome::Acknowledged));
            }
            (Owner::Application(token), _) => output.event(Event::Done(token, Outcome::Answered)),
        }
    }

    fn hard_stop(&mut self, stop: &HardStop<'_>, output: &mut Output) {
        output.event(Event::HardStop(stop.reason, stop.motor));
        self.fail(|request| request.conduct.starts_motion, Failure::HardStop, output);
    }

    /// Deals with the deadlines that have come, sends what has its turn, and says which deadline is next.
    fn watch(&mut self, now: Millis, output: &mut Output) {
        match self.state {
            Connection::Closed => return,
            Connection::Greeting(tries, until) if until <= now => {
                if tries < GREETINGS {
                    self.greet(now, tries.saturating_add(1), output);
                } else {
                    self.state = Connection::Silent;
                    output.event(Event::NoAnswer);
                }
            }
            _ => {}
        }
        let (stops, mut line) = self.line(now, output);
        stops.due(&mut line);
        self.sequence_due(now, output);
        for request in self.requests.due(now, &self.options, &mut self.ids, output) {
            self.settle(now, request, Reply::Failed(Failure::Timeout), output);
            if !request.conduct.is_repeatable && !self.requests.has(Owner::Question) {
                if let Some(question) = Request::own(Owner::Question, What::Status) {
                    self.requests.submit(question);
                }
            }
        }
        if self.state == Connection::Configuring(true) && self.requests.is_empty() {
            self.state = Connection::Up;
            output.event(Event::Up);
        }
        self.requests.send(now, &self.options, &mut self.ids, output);
        let greeting = match self.state {
            Connection::Greeting(_, until) => Some(until),
            _ => None,
        };
        let sequence = self.sequence.as_ref().and_then(Sequence::wake);
        let wakes = [greeting, self.requests.wake(), self.stops.wake(), sequence];
        // At the end of time nothing is later than now.
        output.wake = wakes.into_iter().flatten().filter(|&wake| wake > now).min();
    }
}

impl Machine for HostMachine {
    type Input<'a> = Input<'a>;
    type Output = Output;

    fn step(mut self, now: Millis, input: Input<'_>) -> (Self, Output) {
        let mut output = Output::default();
        match input {
            Input::LinkUp => self.link_up(now, &mut output),
            Input::LinkDown => self.link_down(&mut output),
            Input::Received(id, message) => self.received(now, id, &message, &mut output),
            Input::Malformed(..) | Input::Corrupt => output.event(Event::Unreadable),
            Input::Command(command) => self.command(now, &command, &mut output),
            Input::Section(section) => self.section(section, &mut output),
            Input::Wake => {}
        }
        self.watch(now, &mut output);
        (self, output)
    }
}

// What is derived for so many fields cannot be proven free of panics.
impl fmt::Debug for HostMachine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("HostMachine")
            .field("state", &self.state)
            .field("ids", &self.ids)
            .field("requests", &self.requests)
            .field("stops", &self.stops)
            .field("sequence", &self.sequence)
            .field("is_armed", &self.is_armed)
            .field("live", &self.live)
            .field("is_loaded", &self.is_loaded)
            .finish_non_exhaustive()
    }
}
