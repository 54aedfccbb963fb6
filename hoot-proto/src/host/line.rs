//! The line: which answer is awaited, and until when nothing may be sent. The table of hoot, section 5.

use motion_core::states;
use motion_core::time::Millis;
use motion_core::wire::Purpose;

use super::event::{Event, Failure, Outcome, Refusal, StopTarget};
use super::jobs::Job;
use super::{HostMachine, Output};
use crate::frame::{Address, Selector, Table};
use crate::message::{DeviceMessage, HostMessage, Reply};
use crate::query::Query;

states! {
    /// State of the line of a master. Source: hoot, section 5.
    #[derive(Default)]
    pub enum State {
        /// The line is down.
        #[default]
        Offline,
        /// The next packet may be sent.
        Idle,
        /// An answer is awaited.
        Waiting,
        /// Late and second answers are awaited, and dropped.
        Settling,
        /// Nothing is sent for a while, because nobody answers what was sent, or because addresses have changed.
        Quiet,
    }
}

/// The line, with the data of its state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Line {
    Offline,
    Idle,
    Waiting(Waiting),
    Settling(Millis),
    Quiet(Millis),
}

/// A packet whose answer is awaited.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Waiting {
    pub(super) job: Job,
    until: Millis,
    /// Number of times that the packet may still be repeated.
    left: u8,
    /// Whether the packet was repeated: then more than one answer may come.
    is_repeated: bool,
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

    pub(super) const fn set_back(self, by: Millis) -> Self {
        match self {
            Self::Offline | Self::Idle => self,
            Self::Waiting(waiting) => Self::Waiting(Waiting { until: Millis(waiting.until.since(by)), ..waiting }),
            Self::Settling(until) => Self::Settling(Millis(until.since(by))),
            Self::Quiet(until) => Self::Quiet(Millis(until.since(by))),
        }
    }

    /// Time at which the state ends by itself.
    pub(super) const fn until(&self) -> Option<Millis> {
        match self {
            Self::Offline | Self::Idle => None,
            Self::Waiting(Waiting { until, .. }) | Self::Settling(until) | Self::Quiet(until) => Some(*until),
        }
    }
}

/// Whether a reply can answer a message, as far as can be told: a refusal always can; an OK can, if its value has the type
/// that the query asks for, or if it has no value and the message asks for nothing.
fn answers(message: &HostMessage<'_>, reply: Reply<'_>) -> bool {
    match (message.query(), message) {
        _ if !reply.is_ok() => true,
        (Some(query), _) => query.decode_reply(reply).is_ok(),
        (None, HostMessage::Other(_)) => true,
        (None, _) => reply.data.is_empty(),
    }
}

/// Whether nodes answer a message: they answer neither broadcasts nor command 0.
pub(super) fn is_answered(message: &HostMessage<'_>) -> bool {
    let Selector { table, command, .. } = message.selector();
    table != Table::Broadcast && (table == Table::Core || command != 0)
}

/// Whether a node has another address after a message, and hears nothing for a while.
fn resets(message: &HostMessage<'_>) -> bool {
    message.conduct().purpose == Purpose::Resets
}

impl HostMachine {
    pub(super) fn received<'a>(&mut self, now: Millis, output: &mut Output<'a>, message: DeviceMessage<'a>) {
        let reply = match message {
            DeviceMessage::Reply(reply) => reply,
            DeviceMessage::Other(other) => {
                let [_, to, ..] = other.id().to_be_bytes();
                output.event(Event::Overheard { to: Address(to), message });
                return;
            }
        };
        match self.line {
            Line::Waiting(waiting) if answers(&waiting.job.transmit().message, reply) => {
                let settle = if waiting.is_repeated { self.options.drain() } else { self.options.settle() };
                self.line = Line::Settling(now.after(settle.into()));
                self.job_ended(now, output, waiting.job, Some(reply));
            }
            _ => output.event(Event::Unsolicited(reply)),
        }
    }

    /// Acts when the time of the line's state is over.
    pub(super) fn line_is_due(&mut self, now: Millis, output: &mut Output<'_>) {
        if self.line.until().is_none_or(|until| now < until) {
            return;
        }
        let Line::Waiting(waiting) = self.line else {
            self.line = Line::Idle;
            return;
        };
        if waiting.left > 0 && waiting.job.transmit().message.conduct().repeatable {
            let left = waiting.left.saturating_sub(1);
            self.line = Line::Waiting(Waiting { left, is_repeated: true, ..waiting });
            self.write(now, output, waiting.job);
        } else {
            self.line = Line::Settling(now.after(self.options.drain().into()));
            self.job_ended(now, output, waiting.job, None);
        }
    }

    /// Sends a packet and waits for its answer, if nodes answer it.
    pub(super) fn send(&mut self, now: Millis, output: &mut Output<'_>, job: Job) {
        let message = job.transmit().message;
        let is_answered = is_answered(&message);
        self.line = if is_answered {
            let left = match job {
                Job::Request(_) | Job::Stop(_) => self.options.retries(),
                Job::Speed(_) | Job::KeepAlive(_) | Job::Emergency(_) => 0,
            };
            Line::Waiting(Waiting { job, until: now, left, is_repeated: false })
        } else {
            let quiet = if resets(&message) { self.options.deaf() } else { self.options.gap() };
            Line::Quiet(now.after(quiet.into()))
        };
        self.write(now, output, job);
        if let Some(token) = job.token().filter(|_| !is_answered) {
            output.event(Event::Ended { token, outcome: Outcome::Sent });
        }
    }

    /// Transmits a packet and sets the time until which its answer is awaited.
    pub(super) fn write(&mut self, now: Millis, output: &mut Output<'_>, job: Job) {
        let transmit = job.transmit();
        let time = self.time_to_wait(&job);
        if let Line::Waiting(waiting) = &mut self.line {
            // Not before the gap is over, because the packet may be repeated then.
            waiting.until = now.after(time.max(self.options.gap()).into());
        }
        self.free_at = Some(now.after(self.options.gap().into()));
        self.spoken_to(now, &transmit);
        self.motion.sent(&self.options.nodes(), &transmit);
        // The packet stands before the events of the same step: a stop goes out before anybody is told of it.
        if output.effects.try_insert(0, super::Effect::Transmit(transmit)).is_err() {
            output.transmit(transmit);
        }
    }

    fn time_to_wait(&self, job: &Job) -> u32 {
        match job {
            Job::Request(request) if matches!(request.transmit.message, HostMessage::Start(_)) => {
                self.options.start_timeout()
            }
            Job::Speed(_) | Job::KeepAlive(_) => self.options.short_timeout(),
            Job::Emergency(transmit) if transmit.message.query().is_none() => self.options.short_timeout(),
            Job::Request(_) | Job::Stop(_) | Job::Emergency(_) => self.options.timeout(),
        }
    }

    /// Ends a job by its answer, or by the silence in its place.
    fn job_ended<'a>(&mut self, now: Millis, output: &mut Output<'a>, job: Job, answer: Option<Reply<'a>>) {
        let transmit = job.transmit();
        let outcome = match answer {
            Some(reply) if reply.is_ok() => Outcome::Done(reply),
            Some(reply) => Outcome::Refused(Refusal::Device(reply.code)),
            None => Outcome::unanswered(&transmit.message, true, Failure::NoAnswer),
        };
        if let Some(token) = job.token() {
            output.event(Event::Ended { token, outcome });
        }
        let done = answer.filter(Reply::is_ok);
        match job {
            Job::Request(_) => {
                // Whatever the node said, it may have another address and hear nothing for a while.
                if resets(&transmit.message) {
                    self.line = Line::Quiet(now.after(self.options.deaf().into()));
                }
            }
            Job::Stop(_) if done.is_some() => {
                output.event(Event::Stopped(StopTarget::of(transmit.to, &transmit.message)));
            }
            Job::Stop(stop) => self.not_stopped(output, &stop),
            Job::Speed(speed) => self.speed_ended(output, speed, done.is_some()),
            Job::KeepAlive(to) if answer.is_none() => output.event(Event::KeepAliveLost { to }),
            Job::KeepAlive(_) => {}
            Job::Emergency(transmit) => self.emergency_answered(now, output, &transmit, answer),
        }
        if let (Some(reply), Job::Request(_) | Job::Stop(_)) = (done, job) {
            self.motion.answered(self.options.profile(), &transmit, reply);
        }
    }

    /// Ends the wait for an answer, because a stop goes first.
    pub(super) fn overtake(&mut self, now: Millis, output: &mut Output<'_>) {
        let Line::Waiting(waiting) = self.line else { return };
        self.line = Line::Settling(now.after(self.options.drain().into()));
        self.give_up(output, waiting.job, Failure::Stopped);
        // A motor that was to come to rest must come to rest.
        if let Job::Speed(speed) = waiting.job {
            self.speed_ended(output, speed, false);
        }
    }

    /// Ends the wait of a job for its answer; a stop waits to be sent again.
    pub(super) fn give_up(&mut self, output: &mut Output<'_>, job: Job, why: Failure) {
        if let Job::Stop(stop) = job {
            self.stops.put_back(stop);
        } else if let Some(token) = job.token() {
            let outcome = Outcome::unanswered(&job.transmit().message, true, why);
            output.event(Event::Ended { token, outcome });
        }
    }
}
