//! The line: who is waited for, and until when nothing may be sent. The table of hoot, section 5.

use motion_core::time::Millis;

use super::stops::Stop;
use super::stream::Speed;
use super::{Dropped, Event, Failure, HostMachine, Outcome, Output, Received, Request, Send, Token};
use crate::frame::{Address, Selector, Table};
use crate::message::{DeviceMessage, HostMessage, Reply};
use crate::query::Query;
use crate::state::states;

states! {
    /// What the master does with the line. Source: hoot, section 5.
    pub enum State {
        /// There is none.
        #[default]
        Offline,
        /// It may send.
        Idle,
        /// It waits for an answer.
        Waiting,
        /// It listens for what comes late, or twice.
        Settling,
        /// It leaves the nodes alone, for nobody answers, or their addresses have changed.
        Quiet,
    }
}

/// The line, with what its state needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Line {
    Offline,
    Idle,
    Waiting(Waiting),
    Settling(Millis),
    Quiet(Millis),
}

/// A packet that is out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Waiting {
    pub(super) job: Job,
    until: Millis,
    /// How often it may still be sent again.
    left: u8,
    /// Whether it was: then more than one answer may come.
    is_repeated: bool,
}

/// What for a packet is out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Job {
    Request(Request),
    Stop(Stop),
    Speed(Speed),
    KeepAlive(Address),
    Emergency(Send),
}

impl Job {
    /// Its packet.
    pub(super) fn send(&self) -> Send {
        match *self {
            Self::Request(Request { to, message, .. }) | Self::Stop(Stop { to, message, .. }) => Send { to, message },
            Self::Speed(speed) => speed.send(),
            Self::KeepAlive(to) => super::stream::keep_alive(to),
            Self::Emergency(send) => send,
        }
    }

    /// What the application calls it, if it is the application's.
    const fn token(&self) -> Option<Token> {
        match self {
            Self::Request(request) => Some(request.token),
            Self::Stop(stop) => stop.token,
            Self::Speed(_) | Self::KeepAlive(_) | Self::Emergency(_) => None,
        }
    }
}

impl Line {
    pub(super) const fn state(&self) -> State {
        match self {
            Self::Offline => State::Offline,
            Self::Idle => State::Idle,
            Self::Waiting(_) => State::Waiting,
            Self::Settling(_) => State::Settling,
            Self::Quiet(_) => State::Quiet,
        }
    }

    /// When something is due.
    pub(super) const fn until(&self) -> Option<Millis> {
        match self {
            Self::Offline | Self::Idle => None,
            Self::Waiting(Waiting { until, .. }) | Self::Settling(until) | Self::Quiet(until) => Some(*until),
        }
    }
}

/// Whether a reply can answer what was asked, as far as can be told: a refusal always; an OK if its value is of the
/// type that the query asks for, or if it has none and nothing was asked for.
fn answers(message: &HostMessage<'_>, reply: Reply<'_>) -> bool {
    match (message.query(), message) {
        _ if !reply.is_ok() => true,
        (Some(query), _) => query.decode_reply(reply).is_ok(),
        (None, HostMessage::Other(_)) => true,
        (None, _) => reply.data.is_empty(),
    }
}

/// Whether anybody answers it: not a broadcast, and not command 0.
pub(super) fn is_answered(message: &HostMessage<'_>) -> bool {
    let Selector { table, command, .. } = message.selector();
    table != Table::Broadcast && (table == Table::Core || command != 0)
}

impl HostMachine {
    pub(super) fn received(&mut self, now: Millis, output: &mut Output, message: &DeviceMessage<'_>) {
        let reply = match message {
            DeviceMessage::Reply(reply) => *reply,
            DeviceMessage::Other(other) => {
                let [_, to, ..] = other.id().to_be_bytes();
                output.event(Event::Overheard { to: Address(to) });
                return;
            }
        };
        match self.line {
            Line::Waiting(waiting) if answers(&waiting.job.send().message, reply) => {
                let settle = if waiting.is_repeated { self.options.drain } else { self.options.settle };
                self.line = Line::Settling(now.after(settle.into()));
                self.ended(now, output, waiting.job, Ok(reply));
            }
            _ => output.event(Event::Unsolicited(Received::new(reply))),
        }
    }

    /// Deals with a moment that the line waited for.
    pub(super) fn line_is_due(&mut self, now: Millis, output: &mut Output) {
        if self.line.until().is_none_or(|until| now < until) {
            return;
        }
        let Line::Waiting(waiting) = self.line else {
            self.line = Line::Idle;
            return;
        };
        let send = waiting.job.send();
        if waiting.left > 0 && send.message.is_repeatable() {
            let left = waiting.left.saturating_sub(1);
            self.line = Line::Waiting(Waiting { left, is_repeated: true, ..waiting });
            self.write(now, output, waiting.job);
        } else {
            self.line = Line::Settling(now.after(self.options.drain.into()));
            self.ended(now, output, waiting.job, Err(()));
        }
    }

    /// Sends a packet and waits for its answer, if there will be one.
    pub(super) fn send(&mut self, now: Millis, output: &mut Output, job: Job) {
        let message = job.send().message;
        let is_answered = is_answered(&message);
        self.line = if is_answered {
            let left = match job {
                Job::Request(_) | Job::Stop(_) => self.options.retries,
                Job::Speed(_) | Job::KeepAlive(_) | Job::Emergency(_) => 0,
            };
            Line::Waiting(Waiting { job, until: now, left, is_repeated: false })
        } else {
            let quiet = if message.changes_address() { self.options.deaf } else { self.options.gap };
            Line::Quiet(now.after(quiet.into()))
        };
        self.write(now, output, job);
        if !is_answered {
            if let Some(token) = job.token() {
                output.event(Event::Ended { token, outcome: Outcome::Sent });
            }
        }
    }

    /// Puts a packet out, and moves what waits for its answer.
    pub(super) fn write(&mut self, now: Millis, output: &mut Output, job: Job) {
        let send = job.send();
        let time = self.time_of(&job);
        if let Line::Waiting(waiting) = &mut self.line {
            // Not before the gap is over, since it may be sent again then.
            waiting.until = now.after(time.max(self.options.gap).into());
        }
        self.free_at = Some(now.after(self.options.gap.into()));
        self.spoken_to(now, &send);
        output.send(send);
    }

    fn time_of(&self, job: &Job) -> u32 {
        let short = self.options.short_timeout;
        match job {
            Job::Request(Request { message: HostMessage::Start(_), .. }) => self.options.start_timeout,
            Job::Speed(_) | Job::KeepAlive(_) => short,
            Job::Emergency(send) if send.message.query().is_none() => short,
            Job::Request(_) | Job::Stop(_) | Job::Emergency(_) => self.options.timeout,
        }
    }

    /// A packet has its answer, or none came in time.
    fn ended(&mut self, now: Millis, output: &mut Output, job: Job, answer: Result<Reply<'_>, ()>) {
        let outcome = || match answer {
            Ok(reply) if reply.is_ok() => Outcome::Done(Received::new(reply)),
            Ok(reply) => Outcome::Refused(Received::new(reply)),
            Err(()) => Outcome::Failed(Failure::Silence),
        };
        let is_done = answer.is_ok_and(|reply| reply.is_ok());
        match job {
            Job::Request(Request { token, message, .. }) => {
                // It may have another address, whatever it said, and is deaf then.
                if message.changes_address() {
                    self.line = Line::Quiet(now.after(self.options.deaf.into()));
                }
                output.event(Event::Ended { token, outcome: outcome() });
            }
            Job::Stop(stop) => {
                if let Some(token) = stop.token {
                    output.event(Event::Ended { token, outcome: outcome() });
                }
                if !is_done {
                    self.not_stopped(output, &stop);
                }
            }
            Job::Speed(speed) => self.speed_ended(output, speed, answer.map(|reply| reply.code).ok()),
            Job::KeepAlive(to) if answer.is_err() => output.event(Event::KeepAliveLost { to }),
            Job::KeepAlive(_) => {}
            Job::Emergency(send) => self.emergency_ended(now, output, &send, answer.ok()),
        }
    }

    /// What was out is not waited for any more, for a stop goes first.
    pub(super) fn overtake(&mut self, now: Millis, output: &mut Output) {
        let Line::Waiting(waiting) = self.line else { return };
        self.line = Line::Settling(now.after(self.options.drain.into()));
        match waiting.job {
            Job::Request(Request { token, .. }) => {
                output.event(Event::dropped(token, Dropped::Stop, true));
            }
            Job::Stop(stop) => self.stops.put_back(stop),
            // A motor that was to come to rest must.
            Job::Speed(speed) => self.speed_ended(output, speed, None),
            Job::KeepAlive(_) | Job::Emergency(_) => {}
        }
    }
}
