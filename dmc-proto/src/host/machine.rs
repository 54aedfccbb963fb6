//! The machine itself: the connection, what arrives over it, and the deadlines. DMC D5.

use arrayvec::ArrayVec;
use motion_core::time::Millis;
use motion_core::{debug, machine};

use super::connection::{Connection, State, without_tail};
use super::event::{Event, Failure, Outcome, Refusal, StopTarget};
use super::input::Input;
use super::motion::Motion;
use super::options::{GREETINGS, Options};
use super::progress::Progress;
use super::requests::{ALL, Damaged, Ids, Owner, Pending, Reply, Request, Requests, Role};
use super::sequence::{Course, Sequence};
use super::stops::{Acknowledged, StatusMeaning, Stops};
use super::transmit::{Contents, Output, Transmit, transmit_padding};
use super::uses::Uses;
use crate::Purpose;
use crate::frame::{MessageId, MessageType};
use crate::message::{Ack, AckCode, DeviceMessage, HardStop, Hi};

/// State machine of a host: it knows when to send which message, and what comes of it.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct HostMachine {
    pub(super) options: Options,
    pub(super) connection: Connection,
    /// Whether everything could be sent before.
    was_ready: bool,
    pub(super) device: Option<Hi<'static>>,
    pub(super) ids: Ids,
    pub(super) requests: Requests,
    pub(super) stops: Stops,
    pub(super) sequence: Option<Sequence>,
    pub(super) motion: Motion,
    pub(super) uses: Uses,
    /// Whether the device has a move, as far as is known.
    pub(super) is_loaded: Option<bool>,
}

machine! { HostMachine }
debug! {
    HostMachine { options connection was_ready device ids requests stops sequence motion uses is_loaded }
}

impl HostMachine {
    /// Makes a host without a link.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self {
            options,
            connection: Connection::Offline,
            was_ready: false,
            device: None,
            ids: Ids::new(options.first_id(), u32::MAX),
            requests: Requests::default(),
            stops: Stops::default(),
            sequence: None,
            motion: Motion::default(),
            uses: Uses::default(),
            is_loaded: None,
        }
    }

    /// Counts ids from 1 to `last`, at least 64, then from 1 again. Few ids keep the number of states small where these
    /// are explored.
    #[doc(hidden)]
    #[must_use]
    pub fn with_last_id(mut self, last: u32) -> Self {
        // Four times as many ids as can be under way at once.
        self.ids = Ids::new(1, last.max(64));
        self
    }

    /// State of the connection.
    #[must_use]
    pub const fn state(&self) -> State {
        self.connection.state()
    }

    /// Options of the machine.
    #[must_use]
    pub const fn options(&self) -> &Options {
        &self.options
    }

    /// Greeting of the device in this connection.
    #[must_use]
    pub const fn device(&self) -> Option<Hi<'static>> {
        self.device
    }

    /// Progress of the sequence; `None` if none runs.
    #[must_use]
    pub fn progress(&self) -> Option<Progress> {
        self.sequence.as_ref().map(Sequence::progress)
    }

    /// Whether the device has a move that can be run; `None` if that is not known.
    #[must_use]
    pub const fn is_loaded(&self) -> Option<bool> {
        self.is_loaded
    }

    /// Whether anything may still move because of this host.
    ///
    /// The answer is no only if that is known: nothing that may move was sent, or the motors rest since. A status in which
    /// no motor moves tells so (answer to the request `MotorStatus`, which the machine also asks in sequences and after a
    /// silence), unless something that may move was sent after the question. The answer stays yes
    ///
    /// - while a request that may move is under way, a sequence runs that moves motors, or a run or shot [may still
    ///   begin](Self::is_armed);
    /// - while a stop is not confirmed;
    /// - after an acknowledged stop until a status tells that nothing moves, because motors take time to come to rest;
    /// - after the link went down, the device was reset or stopped hard.
    #[must_use]
    pub fn may_move(&self) -> bool {
        self.motion.may_move
            || self.is_armed()
            || self.requests.sent().any(|request| request.conduct.may_move())
            || matches!(self.sequence, Some(Sequence { course: Course::Run(_), .. }))
            || self.stops.iter().next().is_some()
    }

    /// Whether the device may still begin a run or a shot, be in one, or keep one that it refused.
    ///
    /// This stays so after a sequence that failed midway: only a stop of everything makes it safe to come near. Neither a
    /// hard stop nor a reset ends it, because the news of them may be older than what is on its way to the device
    /// (decision D-60). As long as it is so and no sequence runs, nothing is sent that moves all motors (decision D-97).
    #[must_use]
    pub fn is_armed(&self) -> bool {
        self.motion.is_armed || self.requests.any(Request::arms)
    }

    /// Whether the shutter of the camera may be open because a `GioCam` opened it, or because a shot or a run with photos was
    /// broken off. Only a `GioCam` that closes it ends this.
    ///
    /// Some devices leave the shutter open for ever if a stop ends a shot. After a stop or a hard stop, an application asks
    /// this and sends a `GioCam` that closes the shutter (decision D-86).
    #[must_use]
    pub fn may_have_shutter_open(&self) -> bool {
        self.motion.is_shutter_open || self.requests.any(|request| request.role == Role::Shutter(true))
    }

    /// Targets of the stops that are not confirmed.
    pub fn unconfirmed_stops(&self) -> impl Iterator<Item = StopTarget> {
        self.stops.iter()
    }

    /// Ids and types of the requests under way.
    pub fn pending(&self) -> impl Iterator<Item = (MessageId, MessageType)> {
        self.requests.pending()
    }

    /// Asks the device who it is, and forgets what it was.
    pub(super) fn greet(&mut self, now: Millis, output: &mut Output<'_>, tries: u8) {
        if tries > 1 || self.connection == Connection::Silent {
            // A stop that is sent meanwhile waits for the padding.
            let most = self.options.greeting_timeout().min(self.options.stop_timeout());
            transmit_padding(output, &self.options, most);
        }
        let id = self.ids.next();
        output.transmit(Transmit { id, contents: Contents::Greeting });
        self.connection = Connection::Greeting(tries, now.after(self.options.greeting_timeout().into()));
        self.device = None;
        self.uses.forget();
    }

    fn link_up(&mut self, now: Millis, output: &mut Output<'_>) {
        self.link_down(output);
        self.stops.link_up(now, output, &self.options, &mut self.ids);
        self.is_loaded = None;
        self.greet(now, output, 1);
    }

    /// What was on its way is lost. Without a link, nothing was.
    fn link_down(&mut self, output: &mut Output<'_>) {
        if self.connection == Connection::Offline {
            return;
        }
        self.connection = Connection::Offline;
        output.event(Event::LinkDown);
        self.stops.link_down(output);
        self.fail(output, Failure::LinkDown, |_| true);
    }

    /// Ends requests, and the sequence if it moves motors or everything ends.
    pub(super) fn fail(&mut self, output: &mut Output<'_>, failure: Failure, which: impl Fn(&Request) -> bool) {
        for (request, _) in self.cancel(which) {
            if let Owner::Application(token) = request.owner {
                output.event(Event::Ended { token, outcome: Outcome::Failed(failure) });
            }
        }
        let is_over = |sequence: &Sequence| match sequence.course {
            Course::Run(_) => true,
            Course::Upload(_) => matches!(failure, Failure::LinkDown | Failure::DeviceReset),
        };
        if self.sequence.as_ref().is_some_and(is_over) {
            self.sequence_over(output, Outcome::Failed(failure));
        }
    }

    /// Calls requests off. The device may do those that were sent.
    pub(super) fn cancel(&mut self, which: impl Fn(&Request) -> bool) -> ArrayVec<(Request, bool), ALL> {
        let gone = self.requests.cancel(which);
        for (request, _) in gone.iter().filter(|(_, was_sent)| *was_sent) {
            self.motion.may_be_done(request);
        }
        gone
    }

    fn received<'a>(&mut self, now: Millis, output: &mut Output<'a>, id: MessageId, message: DeviceMessage<'a>) {
        match message {
            _ if self.connection == Connection::Offline => output.event(Event::Unsolicited(id, message)),
            DeviceMessage::Hi(hi) => self.greeted(now, output, id, &hi, message),
            DeviceMessage::Ack(ack) => self.acknowledged(now, output, id, ack),
            DeviceMessage::MotorHardStop(stop) => self.hard_stop(output, &stop),
            DeviceMessage::MotorStatus(status) => {
                let told = (id, status.motor_status, self.is_armed());
                match self.stops.status(output, told) {
                    StatusMeaning::Other => self.answered(now, output, id, message),
                    StatusMeaning::Answer { all_rest } => self.motion.may_move &= !all_rest,
                }
            }
            DeviceMessage::RtGo(_) | DeviceMessage::RtEnd(_) => self.run_signal(now, output, id, message),
            DeviceMessage::GioIn(_)
            | DeviceMessage::MotorMove(_)
            | DeviceMessage::MotorGetPosition(_)
            | DeviceMessage::VirtGetPosition(_)
            | DeviceMessage::VirtAimPoint(_) => self.answered(now, output, id, message),
            DeviceMessage::Other(_) => output.event(Event::Unsolicited(id, message)),
        }
    }

    /// A greeting with id 0 that nobody waits for tells that the device was reset (decision D-46).
    fn greeted<'a>(
        &mut self,
        now: Millis,
        output: &mut Output<'a>,
        id: MessageId,
        hi: &Hi<'_>,
        message: DeviceMessage<'a>,
    ) {
        match self.connection {
            Connection::Greeting(..) | Connection::Silent => {
                let device = without_tail(hi);
                self.device = Some(device);
                if id == MessageId::UNSOLICITED {
                    self.has_no_move();
                }
                self.connection = Connection::Configuring(false);
                output.event(Event::Greeted(device));
            }
            _ if id == MessageId::UNSOLICITED => {
                output.event(Event::DeviceReset);
                self.fail(output, Failure::DeviceReset, |_| true);
                self.has_no_move();
                self.greet(now, output, 1);
            }
            _ => self.answered(now, output, id, message),
        }
    }

    /// The device has been switched on, and has no move.
    const fn has_no_move(&mut self) {
        self.is_loaded = Some(false);
        self.uses.without_move();
    }

    fn acknowledged<'a>(&mut self, now: Millis, output: &mut Output<'a>, id: MessageId, ack: Ack<'a>) {
        match self.stops.acknowledged(now, output, &self.options, &mut self.ids, (id, &ack)) {
            Acknowledged::Confirms(target) => return self.motion.confirmed(target),
            Acknowledged::Refuses => return,
            Acknowledged::Other => {}
        }
        let reply = match ack.response_code {
            Some(AckCode::OK) => Reply::Acknowledged,
            Some(AckCode::ERR_CHECKSUM) => return self.damaged(now, output, id, ack),
            Some(code) => Reply::Refused(code),
            None => Reply::Unclear,
        };
        match self.requests.answered(id, ack.of) {
            Some(pending) => self.settle(now, output, &pending, reply),
            None => output.event(Event::Unsolicited(id, ack.into())),
        }
    }

    /// The request is known by its id alone, because its type may be what arrived damaged (decision D-8).
    fn damaged<'a>(&mut self, now: Millis, output: &mut Output<'a>, id: MessageId, ack: Ack<'a>) {
        match self.requests.damaged(now, &self.options, id) {
            Damaged::Over(pending) => self.settle(now, output, &pending, Reply::Refused(AckCode::ERR_CHECKSUM)),
            Damaged::Again => {}
            Damaged::Unknown => output.event(Event::Unsolicited(id, ack.into())),
        }
    }

    /// A message arrived that answers a request, or is told unasked.
    fn answered<'a>(&mut self, now: Millis, output: &mut Output<'a>, id: MessageId, message: DeviceMessage<'a>) {
        if let Some(pending) = self.requests.answered(id, message.kind()) {
            return self.settle(now, output, &pending, Reply::Answered(message));
        }
        let run = self.sequence.as_mut().and_then(Sequence::run);
        if let (DeviceMessage::MotorGetPosition(_), Some(run)) = (message, run) {
            run.position_received(now);
        }
        output.event(Event::Unsolicited(id, message));
    }

    /// A request is over.
    fn settle<'a>(&mut self, now: Millis, output: &mut Output<'a>, pending: &Pending, reply: Reply<'a>) {
        let request = pending.request;
        self.motion.ended(pending, &reply);
        match (request.role, reply) {
            // A later request for the same motor changes its uses again: until it is answered, nobody knows them.
            (Role::Configures(..), _) if self.requests.any(|other| request.configures_as(other)) => {}
            (Role::Configures(motor, flags), Reply::Acknowledged) => self.uses.set(motor, flags),
            // A device that cannot configure its motors uses all of them.
            (Role::Configures(motor, _), Reply::Refused(AckCode::ERR_UNSUPPORTED)) => {
                self.uses.unsupported(motor);
            }
            (Role::MovesOne, Reply::Refused(_)) => {}
            (Role::MovesOne, _) => {
                if let Some(run) = self.sequence.as_mut().and_then(Sequence::run) {
                    run.motor_moves();
                }
            }
            (Role::StopsLoop, Reply::Acknowledged) => {
                if let Some(run) = self.sequence.as_mut().and_then(Sequence::run) {
                    run.loop_ends(now);
                }
            }
            _ => {}
        }
        if request.owner == Owner::Sequence {
            return self.sequence_answered(now, output, &reply, pending.is_outdated);
        }
        // A run may rest for a moment between two ways: it has to come to its end.
        if reply.rests() && !pending.is_outdated && self.sequence.as_mut().and_then(Sequence::run).is_none() {
            self.motion.may_move = false;
        }
        match (request.owner, reply) {
            (Owner::Question, Reply::Answered(DeviceMessage::MotorStatus(status))) => {
                output.event(Event::Moving(status.motor_status));
            }
            (Owner::Application(token), _) => {
                let outcome = match reply {
                    Reply::Acknowledged => Outcome::Done(None),
                    Reply::Answered(message) => Outcome::Done(Some(message)),
                    Reply::Refused(code) => Outcome::Refused(Refusal::Device(code)),
                    Reply::Unclear => Outcome::NotConfirmed,
                };
                output.event(Event::Ended { token, outcome });
            }
            (Owner::Question | Owner::Sequence, _) => {}
        }
    }

    fn hard_stop(&mut self, output: &mut Output<'_>, stop: &HardStop<'_>) {
        output.event(Event::HardStop(stop.reason, stop.motor));
        self.fail(output, Failure::HardStop, |request| request.conduct.may_move());
    }

    /// A request got no answer.
    fn unanswered(&mut self, now: Millis, output: &mut Output<'_>, pending: &Pending) {
        let Request { owner, conduct, .. } = pending.request;
        match owner {
            Owner::Application(token) if conduct.purpose == Purpose::Asks => {
                output.event(Event::Ended { token, outcome: Outcome::Failed(Failure::NoAnswer) });
            }
            _ => self.settle(now, output, pending, Reply::Unclear),
        }
        if !conduct.repeatable && !self.requests.any(|request| request.owner == Owner::Question) {
            self.requests.submit(Request::own(Owner::Question, Contents::Status));
        }
    }

    /// Deals with the deadlines that have come, sends what has its turn, and finds the next deadline.
    fn watch(&mut self, now: Millis, output: &mut Output<'_>) {
        match self.connection {
            Connection::Offline => return,
            Connection::Greeting(tries, until) if until <= now => {
                if tries < GREETINGS {
                    self.greet(now, output, tries.saturating_add(1));
                } else {
                    self.connection = Connection::Silent;
                    output.event(Event::Silent);
                }
            }
            _ => {}
        }
        self.stops.due(now, output, &self.options, &mut self.ids);
        self.sequence_due(now, output);
        for pending in self.requests.due(now, output, &self.options, &mut self.ids) {
            self.unanswered(now, output, &pending);
        }
        if self.connection == Connection::Configuring(true) && self.requests.is_empty() {
            self.connection = Connection::Ready;
            output.event(Event::Ready { reconnected: core::mem::replace(&mut self.was_ready, true) });
        }
        self.requests.send(now, output, &self.options, &mut self.ids);
        let greeting = match self.connection {
            Connection::Greeting(_, until) => Some(until),
            _ => None,
        };
        let sequence = self.sequence.as_ref().and_then(Sequence::wake);
        output.wake = [greeting, self.requests.wake(), self.stops.wake(), sequence].into_iter().flatten().min();
    }

    fn run<'a>(&mut self, now: Millis, output: &mut Output<'a>, input: Input<'a>) {
        match input {
            Input::LinkUp => self.link_up(now, output),
            Input::LinkDown => self.link_down(output),
            Input::Received(id, message) => self.received(now, output, id, message),
            Input::Malformed(id, kind) => output.event(Event::Malformed(id, kind)),
            Input::Corrupt => output.event(Event::Corrupt),
            Input::Command(token, command) => self.command(now, output, token, &command),
            Input::Section(section) => self.section(now, output, section),
            Input::Wake => {}
        }
        self.watch(now, output);
    }
}
