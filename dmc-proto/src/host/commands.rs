//! What the application wants, and what its sequences want in turn.

use motion_core::time::Millis;

use super::connection::Connection;
use super::io::{Command, Event, Failure, Name, Outcome, Output, Token};
use super::machine::HostMachine;
use super::requests::{Owner, Request, Role};
use super::run::Run;
use super::sequence::{Course, Next, Reply, Sequence};
use super::stops::Stop;
use super::upload::Upload;
use crate::lint::Context;
use crate::message::{DeviceMessage, HostMessage, MotorFlags, Motors};
use crate::upload::Section;

impl HostMachine {
    pub(super) fn command(&mut self, now: Millis, command: &Command<'_>, output: &mut Output) {
        match command {
            Command::Stop(stop) => self.stop(now, *stop, output),
            Command::EndStops => self.stops.clear(),
            Command::Request(token, message) => {
                if let Some(stop) = Stop::of(message) {
                    self.stop(now, stop, output);
                    output.event(Event::Done(*token, Outcome::TakenAsStop));
                } else if let Err(failure) = self.request(*token, message) {
                    output.event(Event::Failed(*token, failure));
                }
            }
            Command::Sequence(token, message) => {
                if let Err(failure) = self.begin(*token, message, output) {
                    output.event(Event::Failed(*token, failure));
                }
            }
            Command::Go => match self.sequence.as_mut().and_then(Sequence::run).and_then(Run::go) {
                Some(request) => self.ask(request, output),
                None => output.event(Event::Ignored),
            },
            Command::Greet if self.state == Connection::Silent => self.greet(now, 1, output),
            Command::Configured if self.state == Connection::Configuring(false) => {
                self.state = Connection::Configuring(true);
            }
            Command::Greet | Command::Configured => output.event(Event::Ignored),
        }
    }

    /// Safety decision 1: it is sent first, and then all that could move anything is called off.
    fn stop(&mut self, now: Millis, stop: Stop, output: &mut Output) {
        let run = self.sequence.as_mut().and_then(Sequence::run);
        // A motor that is driven by hand is no part of a run, once nothing more has to be asked for it.
        let spares = match (stop, &run) {
            (Stop::Motor(motor), Some(run)) => self.live.contains(motor) && run.is_under_way(),
            _ => false,
        };
        let is_coordinated = run.is_some() || self.is_armed;
        let stop = if is_coordinated && !spares && !stop.is_all() { Stop::All } else { stop };
        if self.state == Connection::Closed {
            self.stops.keep(stop, output);
        } else {
            let (stops, mut line) = self.line(now, output);
            stops.submit(stop, &mut line);
        }
        let kept = if spares { self.sequence.take() } else { None };
        self.fail(|request| request.conduct.starts_motion, Failure::Stopped, output);
        if kept.is_some() {
            self.sequence = kept;
        }
    }

    /// Whether a message may be sent at all.
    fn check(&self, message: &HostMessage<'_>) -> Result<(), Failure> {
        if self.stops.forbid(message) {
            return Err(Failure::Stopped);
        }
        if let (true, Some(device)) = (self.options.is_gated, self.device) {
            if let Some(code) = message.refusal(&Context::of(device)) {
                return Err(Failure::WouldBeRefused(code));
            }
        }
        // Nobody answers an acknowledgement (decision D-5).
        if message.kind().is_ack() { Err(Failure::Sequence) } else { Ok(()) }
    }

    fn request(&mut self, token: Token, message: &HostMessage<'_>) -> Result<(), Failure> {
        let is_ready = match self.state {
            Connection::Configuring(_) => !message.starts_motion(),
            Connection::Up => true,
            Connection::Closed | Connection::Greeting(..) | Connection::Silent => false,
        };
        if !is_ready {
            return Err(Failure::NotUp);
        }
        if is_part_of_sequence(message) {
            return Err(Failure::Sequence);
        }
        self.check(message)?;
        let request = Request::named(Owner::Application(token), Name::Message(token), message);
        if !self.requests.submit(request) {
            return Err(Failure::Busy);
        }
        if let HostMessage::MotorConfigure(configure) = message {
            let motor = Motors::from_iter([configure.motor]).0;
            let live = configure.flags.contains(MotorFlags::LIVE);
            self.live.0 = if live { self.live.0 | motor } else { self.live.0 & !motor };
        }
        Ok(())
    }

    fn begin(&mut self, token: Token, message: &HostMessage<'_>, output: &mut Output) -> Result<(), Failure> {
        if self.state != Connection::Up {
            return Err(Failure::NotUp);
        }
        if self.sequence.is_some() {
            return Err(Failure::Busy);
        }
        self.check(message)?;
        let begin = Request::named(Owner::Sequence, Name::Message(token), message);
        let (course, first) = if let HostMessage::RtUploadMoveBegin(_) = message {
            self.is_loaded = None;
            (Course::Upload(Upload::Begins), begin)
        } else {
            let (run, first) = Run::new(begin, message).ok_or(Failure::Sequence)?;
            (Course::Run(run), first)
        };
        self.sequence = Some(Sequence { token, course });
        self.ask(first, output);
        Ok(())
    }

    /// Sends what a sequence asks for: there is always room for one request of it.
    fn ask(&mut self, request: Request, output: &mut Output) {
        self.is_armed |= request.conduct.role == Role::Arms;
        if !self.requests.submit(request) {
            self.sequence_over(Err(Failure::Busy), output);
        }
    }

    fn follow(&mut self, next: Next, output: &mut Output) {
        match next {
            Next::Wait => {}
            Next::Ask(request) => self.ask(request, output),
            Next::Tell(event) => output.event(event),
            Next::Done => self.sequence_over(Ok(()), output),
            Next::Failed(failure) => self.sequence_over(Err(failure), output),
        }
    }

    /// The sequence is over, well or not, and what it still asks is called off.
    pub(super) fn sequence_over(&mut self, end: Result<(), Failure>, output: &mut Output) {
        self.requests.cancel(|request| request.owner == Owner::Sequence);
        let Some(Sequence { token, course }) = self.sequence.take() else { return };
        match (end, course) {
            (Ok(()), Course::Upload(_)) => self.is_loaded = Some(true),
            (Ok(()), Course::Run(_)) => self.is_armed = false,
            (Err(_), _) => {}
        }
        output.event(match end {
            Ok(()) => Event::Done(token, Outcome::Finished),
            Err(failure) => Event::Failed(token, failure),
        });
    }

    pub(super) fn sequence_answered(&mut self, now: Millis, reply: Reply, output: &mut Output) {
        if let Some(sequence) = &mut self.sequence {
            let next = sequence.answered(now, reply, &self.options);
            self.follow(next, output);
        }
    }

    pub(super) fn sequence_due(&mut self, now: Millis, output: &mut Output) {
        if let Some(run) = self.sequence.as_mut().and_then(Sequence::run) {
            let next = run.due(now, &self.options);
            self.follow(next, output);
        }
    }

    pub(super) fn section(&mut self, section: Option<Section>, output: &mut Output) {
        let next = match &mut self.sequence {
            Some(Sequence { course: Course::Upload(upload), .. }) => upload.section(section),
            _ => Next::Tell(Event::Ignored),
        };
        self.follow(next, output);
    }

    /// The device says unasked that something begins or ends.
    pub(super) fn told(&mut self, now: Millis, message: &DeviceMessage<'_>, output: &mut Output) {
        let next = match &mut self.sequence {
            Some(Sequence { token, course: Course::Run(run) }) => run.told(now, *token, message, &self.options),
            _ => None,
        };
        match next {
            Some(next) => {
                // What is still asked is answered by this.
                self.requests.cancel(|request| request.owner == Owner::Sequence);
                self.follow(next, output);
            }
            None => output.event(Event::Unasked(message.kind())),
        }
    }
}

/// What only makes sense as part of a sequence: it begins one, or goes on with it.
fn is_part_of_sequence(message: &HostMessage<'_>) -> bool {
    matches!(
        message,
        HostMessage::RtUploadMoveBegin(_)
            | HostMessage::RtUploadMoveAxis(_)
            | HostMessage::RtUploadMoveDmx(_)
            | HostMessage::RtUploadMoveTriggers(_)
            | HostMessage::RtUploadMoveEnd(_)
            | HostMessage::RtPositionFrame(_)
            | HostMessage::RtRunMove(_)
            | HostMessage::RtShootFrame(_)
            | HostMessage::RtShootFrame2(_)
            | HostMessage::RtGo(_)
            | HostMessage::RtJogAll(_)
    )
}
