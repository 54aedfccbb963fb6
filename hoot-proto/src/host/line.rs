//! The line: which answer is awaited, and until when nothing may be sent. The table of hoot, section 5.

use motion_core::states;
use motion_core::time::Millis;
use motion_core::wire::Purpose;

use super::deaf::blocks;
use super::event::{Event, Failure, Outcome, Refusal, StopTarget};
use super::jobs::Job;
use super::{HostMachine, Output, Transmit};
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
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Waiting {
    pub(super) job: Job,
    pub(super) until: Millis,
    /// Time at which the packet was sent last.
    sent_at: Millis,
    /// Number of times that the packet may still be repeated.
    left: u8,
    /// Number of times that the packet was sent: so many answers may come.
    sent: u8,
    /// Whether an answer that comes can only be the answer to this packet.
    is_clear: bool,
}

motion_core::debug! { Waiting { job until sent_at left sent is_clear } }

impl Line {
    pub(super) const fn set_back(self, by: Millis) -> Self {
        match self {
            Self::Offline | Self::Idle => self,
            Self::Waiting(waiting) => Self::Waiting(Waiting {
                until: Millis(waiting.until.since(by)),
                sent_at: Millis(waiting.sent_at.since(by)),
                ..waiting
            }),
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
    /// State of the line.
    #[must_use]
    pub const fn state(&self) -> State {
        match self.line {
            Line::Offline => State::Offline,
            Line::Idle if self.doubt.is_over() => State::Idle,
            Line::Waiting(_) => State::Waiting,
            Line::Idle | Line::Settling(_) => State::Settling,
            Line::Quiet(_) => State::Quiet,
        }
    }

    /// Time at which late answers do not come any more (decisions H-18 and H-40).
    pub(super) fn drained(&self, from: Millis) -> Millis {
        let least = self.options.timeout().saturating_add(self.options.gap());
        from.after(self.options.drain().max(least).into())
    }

    /// Whether the answer to a packet cannot be the answer to something else.
    pub(super) fn is_clear(&self, transmit: &Transmit) -> bool {
        self.believes(transmit, false)
    }

    /// Whether the answer to a packet cannot be the answer to something else. If the packet was sent before (`is_again`), it is
    /// enough that as many answers have come as are owed.
    pub(super) fn believes(&self, Transmit { to, message }: &Transmit, is_again: bool) -> bool {
        let is_foreign = message.query().is_none() && self.deaf.may_answer_others(&self.options.nodes(), *to);
        !is_foreign && (self.doubt.is_clear(message) || is_again && self.doubt.is_counted(message))
    }

    /// Whether a refusal that comes from a node cannot be the answer to something else.
    fn may_refuse(&self, to: Address) -> bool {
        self.doubt.is_over() && !self.deaf.may_answer_others(&self.options.nodes(), to)
    }

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
            // A refusal tells nothing of what is refused.
            Line::Waiting(Waiting { job, sent, is_clear: true, .. })
                if answers(&job.transmit().message, reply) && (reply.is_ok() || self.may_refuse(job.transmit().to)) =>
            {
                self.line = Line::Settling(now.after(self.options.settle().into()));
                let Transmit { to, message } = job.transmit();
                if sent > 1 {
                    let more = self.packets(&message, sent).saturating_sub(1);
                    self.doubt.owe(&message, more, self.drained(now));
                }
                self.deaf.hears(to);
                self.job_ended(now, output, job, Some(reply));
            }
            _ => {
                output.event(Event::Unsolicited(reply));
                self.not_an_answer(now, output, reply);
            }
        }
    }

    /// Counts an answer that may be that to something else.
    fn not_an_answer(&mut self, now: Millis, output: &mut Output<'_>, reply: Reply<'_>) {
        let settled = now.after(self.options.settle().into());
        self.doubt.arrived(reply, self.drained(now), settled);
        if reply.data.is_empty() {
            self.stops.heard();
        }
        match self.line {
            // A stop waits for the gap only.
            Line::Idle if !self.is_stopping() => self.line = Line::Settling(settled),
            // The next stop need not wait for longer.
            Line::Waiting(Waiting { job: Job::Emergency(packet), is_clear: false, .. }) => {
                self.line = Line::Settling(settled);
                self.emergency_answered(output, &packet, None);
            }
            _ => {}
        }
    }

    /// Greatest number of answers to a message that was sent a number of times.
    fn packets(&self, message: &HostMessage<'_>, sent: u8) -> u8 {
        self.options.profile().packets(message).saturating_mul(sent)
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
            let (left, sent) = (waiting.left.saturating_sub(1), waiting.sent.saturating_add(1));
            // A stop overtakes the packet.
            if self.stops.first(&self.deaf).is_some() {
                return;
            }
            // At a node that may be deaf, the packet may still wait.
            if let Some(until) = self.deaf.until().filter(|_| !self.deaf.allows(&waiting.job.transmit())) {
                self.line = Line::Waiting(Waiting { until, ..waiting });
                return;
            }
            self.line = Line::Waiting(Waiting { left, sent, ..waiting });
            self.write(now, output, waiting.job.transmit(), self.time_to_wait(&waiting.job));
        } else if let Some(Waiting { job, is_clear, .. }) = self.abandon(now) {
            match job {
                // The question was asked although nobody could have believed the answer.
                Job::KeepAlive(_) if !is_clear => {}
                job => self.job_ended(now, output, job, None),
            }
        }
    }

    /// Sends a packet and waits for its answer, if nodes answer it.
    pub(super) fn send(&mut self, now: Millis, output: &mut Output<'_>, job: Job) {
        let transmit = job.transmit();
        let message = transmit.message;
        let is_answered = is_answered(&message);
        let time = self.time_to_wait(&job);
        if is_answered {
            let left = match job {
                Job::Request(_) => self.options.retries(),
                Job::Stop(stop) => self.options.retries().saturating_sub(stop.sent),
                Job::Speed(_) | Job::KeepAlive(_) | Job::Emergency(_) => 0,
            };
            let is_clear = match job {
                Job::Stop(_) => true,
                Job::Emergency(_) if message.conduct().is_stop() => self.believes_stops(&transmit),
                _ => self.is_clear(&transmit),
            };
            self.line = Line::Waiting(Waiting { job, until: now, sent_at: now, left, sent: 1, is_clear });
            if !is_clear {
                self.owe(&message, 1, now);
            }
        } else {
            let quiet = if resets(&message) { blocks(&message).into() } else { self.options.gap() };
            self.line = Line::Quiet(now.after(quiet.into()));
        }
        self.write(now, output, transmit, time);
        if let Some(token) = job.token().filter(|_| !is_answered) {
            output.event(Event::Ended { token, outcome: Outcome::Sent });
        }
    }

    /// Transmits a packet and sets the time until which its answer is awaited.
    fn write(&mut self, now: Millis, output: &mut Output<'_>, transmit: Transmit, time: u32) {
        if let Line::Waiting(waiting) = &mut self.line {
            // Not before the gap is over, because the packet may be repeated then.
            waiting.until = now.after(time.max(self.options.gap()).into());
            waiting.sent_at = now;
        }
        self.transmit(now, output, transmit);
    }

    /// Transmits a packet.
    pub(super) fn transmit(&mut self, now: Millis, output: &mut Output<'_>, transmit: Transmit) {
        self.free_at = Some(now.after(self.options.gap().into()));
        self.spoken_to(now, &transmit);
        self.motion.sent(&self.options.nodes(), &transmit);
        if transmit.message.conduct().may_move() {
            self.stops.moves(&transmit);
        }
        self.deaf.sent(now, transmit.to);
        if blocks(&transmit.message) > 0 {
            self.deaf.begins(now, &transmit);
        }
        // The packet stands before the events of the same step: a stop goes out before anybody is told of it.
        if output.effects.try_insert(0, super::Effect::Transmit(transmit)).is_err() {
            output.transmit(transmit);
        }
    }

    fn time_to_wait(&self, job: &Job) -> u32 {
        match job {
            Job::Request(request) => self.options.timeout().max(blocks(&request.transmit.message).into()),
            Job::Speed(_) | Job::KeepAlive(_) => self.options.short_timeout(),
            Job::Emergency(transmit) if transmit.message.query().is_none() => self.options.short_timeout(),
            Job::Stop(_) | Job::Emergency(_) => self.options.timeout(),
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
                    self.line = Line::Quiet(now.after(blocks(&transmit.message).into()));
                    self.deaf.begins(now, &transmit);
                }
            }
            Job::Stop(_) if done.is_some() => {
                output.event(Event::Stopped(StopTarget::of(transmit.to, &transmit.message)));
            }
            Job::Stop(stop) => self.not_stopped(now, output, &stop),
            Job::Speed(speed) => self.speed_ended(now, output, speed, done.is_some()),
            Job::KeepAlive(to) if answer.is_none() => output.event(Event::KeepAliveLost { to }),
            Job::KeepAlive(_) => {}
            Job::Emergency(transmit) => self.emergency_answered(output, &transmit, answer),
        }
        if let (Some(reply), Job::Request(_) | Job::Stop(_)) = (done, job) {
            self.motion.answered(self.options.profile(), &transmit, reply);
        }
    }

    /// Ends the wait for an answer, which may still come. The line is free after the gap.
    pub(super) fn abandon(&mut self, now: Millis) -> Option<Waiting> {
        let Line::Waiting(waiting) = self.line else { return None };
        self.line = Line::Idle;
        if waiting.is_clear {
            self.owe(&waiting.job.transmit().message, waiting.sent, waiting.sent_at.min(now));
            // In a step that comes late, that time may be over already.
            self.doubt.expire(now);
        }
        Some(waiting)
    }

    /// The answers to a message that was sent a number of times, for the last time at `sent_at`, may come late.
    pub(super) fn owe(&mut self, message: &HostMessage<'_>, sent: u8, sent_at: Millis) {
        let packets = self.packets(message, sent);
        let time = self.options.timeout().max(blocks(message).into());
        self.doubt.owe(message, packets, self.drained(sent_at.after(time.into())));
    }

    /// Ends the wait for an answer, because a stop goes first.
    pub(super) fn overtake(&mut self, now: Millis, output: &mut Output<'_>) {
        let Some(waiting) = self.abandon(now) else { return };
        self.give_up(output, &waiting, Failure::Stopped);
        match waiting.job {
            // A motor that was to come to rest must come to rest.
            Job::Speed(speed) => self.speed_ended(now, output, speed, false),
            Job::Emergency(packet) if packet.message.query().is_none() => {
                self.emergency_answered(output, &packet, None);
            }
            _ => {}
        }
    }

    /// Gives up the answer to a job; a stop waits to be sent again.
    pub(super) fn give_up(&mut self, output: &mut Output<'_>, waiting: &Waiting, why: Failure) {
        if let Job::Stop(stop) = waiting.job {
            self.stops.put_back(super::jobs::Stop { is_own: true, ..stop }, Some(waiting.until));
        } else if let Some(token) = waiting.job.token() {
            let outcome = Outcome::unanswered(&waiting.job.transmit().message, true, why);
            output.event(Event::Ended { token, outcome });
        }
    }
}
