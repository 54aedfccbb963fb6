//! Commands of the application, and the steps of its sequence.

use motion_core::machine::Token;
use motion_core::time::Millis;

use super::connection::Connection;
use super::event::{Event, Failure, Outcome, Refusal, StopTarget};
use super::input::Command;
use super::machine::HostMachine;
use super::progress::Next;
use super::requests::{Owner, Reply, Request, Role};
use super::run::Run;
use super::sequence::{Course, Sequence};
use super::transmit::{Output, Source};
use super::upload::Upload;
use crate::frame::MessageId;
use crate::lint::Context;
use crate::message::{DeviceMessage, HostMessage};
use crate::upload::Section;

/// The end of a command at once, or `None` if it ends later.
type Taken = Result<Option<Outcome<'static>>, Refusal>;

impl HostMachine {
    pub(super) fn command(&mut self, now: Millis, output: &mut Output<'_>, token: Token, command: &Command<'_>) {
        let end = match command {
            Command::Stop(target) => Ok(Some(self.stop(now, output, *target))),
            // A stop is a stop, however it is given.
            Command::Request(message) | Command::Sequence(message) if message.conduct().is_stop() => {
                let target = StopTarget::of(message).unwrap_or(StopTarget::All);
                Ok(Some(self.stop(now, output, target)))
            }
            Command::Request(message) => self.request(token, message),
            Command::Sequence(message) => self.begin(output, token, message),
            Command::Go => self.go(output, token),
            Command::Greet => self.greet_again(now, output),
            Command::Configured => self.configured(),
            Command::EndStops => {
                self.stops.clear();
                Ok(Some(Outcome::Done(None)))
            }
        };
        if let Some(outcome) = end.unwrap_or_else(|refusal| Some(Outcome::Refused(refusal))) {
            output.event(Event::Ended { token, outcome });
        }
    }

    /// Stops: the stop is sent, and all that could move anything is called off (safety decision 1).
    fn stop(&mut self, now: Millis, output: &mut Output<'_>, target: StopTarget) -> Outcome<'static> {
        let is_armed = self.is_armed();
        let run = self.sequence.as_mut().and_then(Sequence::run);
        // A motor that is driven by hand is no part of a run, once nothing more has to be asked for the run.
        let spares = match (target, &run) {
            (StopTarget::Motor(motor), Some(run)) => self.uses.live.contains(motor) && run.is_under_way(),
            _ => false,
        };
        let is_coordinated = run.is_some() || is_armed;
        let target = if is_coordinated && !spares && !target.is_all() { StopTarget::All } else { target };
        let outcome = if self.connection == Connection::Offline {
            self.stops.keep(output, target);
            Outcome::NotConfirmed
        } else {
            self.stops.submit(now, output, &self.options, &mut self.ids, target);
            Outcome::Sent
        };
        let kept = if spares { self.sequence.take() } else { None };
        self.fail(output, Failure::Stopped, |request| request.conduct.may_move());
        if kept.is_some() {
            self.sequence = kept;
        }
        outcome
    }

    /// Whether a message may be sent at all.
    fn check(&self, message: &HostMessage<'_>) -> Result<(), Refusal> {
        let conduct = message.conduct();
        // The device may still have a run or shot, and go to its start with the next motion of all motors.
        let follows_run = conduct.in_sequence && conduct.may_move() && self.is_armed();
        if follows_run || self.stops.forbid(message) {
            return Err(Refusal::Stopping);
        }
        if let (true, Some(device)) = (self.options.gates(), self.device) {
            if let Some(code) = message.refusal(&Context::of(device)) {
                return Err(Refusal::WouldBeRefused(code));
            }
        }
        if let (true, Some((motor, flags))) = (self.options.needs_enabled(), self.uses.lacking(message)) {
            return Err(Refusal::NotConfigured(motor, flags));
        }
        let count = self.device.map_or(0, |device| device.motor_count);
        if let (true, Some(refusal)) = (self.options.needs_enabled(), self.uses.outside(message, count)) {
            return Err(refusal);
        }
        // Nobody answers an acknowledgement (decision D-5).
        if message.kind().is_ack() { Err(Refusal::Misplaced) } else { Ok(()) }
    }

    /// Whether the connection is so far that this can be sent.
    fn is_open_to(&self, may_move: bool) -> Result<(), Refusal> {
        match self.connection {
            Connection::Offline => Err(Refusal::NotConnected),
            Connection::Configuring(_) if !may_move => Ok(()),
            Connection::Greeting(..) | Connection::Silent | Connection::Configuring(_) => Err(Refusal::NotReady),
            Connection::Ready => Ok(()),
        }
    }

    fn request(&mut self, token: Token, message: &HostMessage<'_>) -> Taken {
        self.is_open_to(message.conduct().may_move())?;
        if message.conduct().in_sequence {
            return Err(Refusal::Misplaced);
        }
        self.check(message)?;
        // The messages of a run were checked when it began, and the last ones are sent much later.
        let runs = matches!(self.sequence, Some(Sequence { course: Course::Run(_), .. })) || self.is_armed();
        if self.options.needs_enabled() && runs && self.uses.changes_move(message) {
            return Err(Refusal::Busy);
        }
        let request = Request::of_application(Owner::Application(token), Source::Command(token), message);
        if !self.requests.submit(request) {
            return Err(Refusal::Busy);
        }
        if let Role::Configures(motor, _) = request.role {
            // Until the device has said so, nobody knows.
            self.uses.unset(motor);
        }
        Ok(None)
    }

    fn begin(&mut self, output: &mut Output<'_>, token: Token, message: &HostMessage<'_>) -> Taken {
        self.is_open_to(true)?;
        if self.sequence.is_some() {
            return Err(Refusal::Busy);
        }
        self.check(message)?;
        let begin = Request::of_application(Owner::Sequence, Source::Command(token), message);
        let (course, first) = if let HostMessage::RtUploadMoveBegin(_) = message {
            self.is_loaded = None;
            self.uses.upload();
            (Course::Upload(Upload::Begins), begin)
        } else {
            let (run, first) = Run::new(begin, message, self.is_loaded == Some(true)).ok_or(Refusal::Misplaced)?;
            (Course::Run(run), first)
        };
        self.sequence = Some(Sequence { token, course });
        self.ask(output, first);
        Ok(None)
    }

    fn go(&mut self, output: &mut Output<'_>, token: Token) -> Taken {
        self.is_open_to(true)?;
        let run = self.sequence.as_mut().and_then(Sequence::run);
        let request = run.and_then(|run| run.go(token)).ok_or(Refusal::Unexpected)?;
        self.ask(output, request);
        Ok(None)
    }

    fn greet_again(&mut self, now: Millis, output: &mut Output<'_>) -> Taken {
        match self.connection {
            Connection::Offline => Err(Refusal::NotConnected),
            Connection::Silent => {
                self.greet(now, output, 1);
                Ok(Some(Outcome::Sent))
            }
            Connection::Greeting(..) | Connection::Configuring(_) | Connection::Ready => Err(Refusal::Unexpected),
        }
    }

    fn configured(&mut self) -> Taken {
        match self.connection {
            Connection::Offline => Err(Refusal::NotConnected),
            Connection::Greeting(..) | Connection::Silent => Err(Refusal::NotReady),
            Connection::Configuring(false) => {
                self.connection = Connection::Configuring(true);
                Ok(Some(Outcome::Done(None)))
            }
            Connection::Configuring(true) | Connection::Ready => Err(Refusal::Unexpected),
        }
    }

    /// Asks for the sequence. There is always room for one request of it.
    fn ask(&mut self, output: &mut Output<'_>, request: Request) {
        if !self.requests.submit(request) {
            self.sequence_over(output, Outcome::Refused(Refusal::Busy));
        }
    }

    fn follow(&mut self, now: Millis, output: &mut Output<'_>, next: Next) {
        match next {
            Next::Wait => {}
            Next::Ask(request) => self.ask(output, request),
            Next::Tell(event) => output.event(event),
            Next::End(outcome) => {
                let is_run = self.sequence.as_mut().and_then(Sequence::run).is_some();
                self.sequence_over(output, outcome);
                if is_run && self.motion.is_armed {
                    // The device may keep the run or shot: it forgets it with a stop (decision D-97).
                    self.stop(now, output, StopTarget::AllSilent);
                }
            }
        }
        if let Some(token) = self.sequence.as_mut().and_then(Sequence::run).and_then(Run::signal_done) {
            output.event(Event::Ended { token, outcome: Outcome::Done(None) });
        }
    }

    /// The sequence is over. What it still asks is called off.
    pub(super) fn sequence_over(&mut self, output: &mut Output<'_>, outcome: Outcome<'static>) {
        self.cancel(|request| request.owner == Owner::Sequence);
        let Some(Sequence { token, course }) = self.sequence.take() else { return };
        let signal = match &course {
            Course::Upload(_) => None,
            Course::Run(run) => run.signal(),
        };
        if let Course::Run(run) = &course {
            self.motion.is_shutter_open |= run.may_leave_shutter_open(&outcome);
        }
        if let Outcome::Done(_) = outcome {
            match course {
                Course::Upload(_) => {
                    self.is_loaded = Some(true);
                    self.uses.uploaded();
                }
                Course::Run(_) => self.motion.is_armed = false,
            }
        }
        for token in [Some(token), signal].into_iter().flatten() {
            output.event(Event::Ended { token, outcome });
        }
    }

    pub(super) fn sequence_answered(
        &mut self,
        now: Millis,
        output: &mut Output<'_>,
        reply: &Reply<'_>,
        is_outdated: bool,
    ) {
        let Some(sequence) = &mut self.sequence else { return };
        let next = sequence.answered(now, &self.options, reply);
        if reply.rests() && !is_outdated && !matches!(next, Next::Wait) {
            self.motion.may_move = false;
        }
        self.follow(now, output, next);
    }

    pub(super) fn sequence_due(&mut self, now: Millis, output: &mut Output<'_>) {
        if let Some(run) = self.sequence.as_mut().and_then(Sequence::run) {
            let next = run.due(now, &self.options);
            self.follow(now, output, next);
        }
    }

    pub(super) fn section(&mut self, now: Millis, output: &mut Output<'_>, section: Option<Section>) {
        let next = match &mut self.sequence {
            Some(Sequence { course: Course::Upload(upload), .. }) => {
                if let Some(section) = section {
                    self.uses.section(section.track());
                }
                upload.section(section)
            }
            _ => Next::Tell(Event::SectionNotWanted),
        };
        self.follow(now, output, next);
    }

    /// The device tells by itself that something begins or ends.
    pub(super) fn run_signal<'a>(
        &mut self,
        now: Millis,
        output: &mut Output<'a>,
        id: MessageId,
        message: DeviceMessage<'a>,
    ) {
        let next = match &mut self.sequence {
            Some(Sequence { token, course: Course::Run(run) }) => run.unsolicited(now, &self.options, *token, &message),
            _ => None,
        };
        match next {
            Some(next) => {
                // This answers what the sequence still asks.
                self.cancel(|request| request.owner == Owner::Sequence);
                self.follow(now, output, next);
            }
            None => output.event(Event::Unsolicited(id, message)),
        }
    }
}
