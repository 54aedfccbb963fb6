//! The master as a whole: what is sent next.

use arrayvec::ArrayVec;
use motion_core::machine;
use motion_core::time::Millis;

use super::deaf::{Deaf, blocks};
use super::doubt::Doubt;
use super::emergency::Emergency;
use super::event::{Event, Failure};
use super::jobs::{Job, Pending, Speed};
use super::joystick::KeptNodes;
use super::line::Line;
use super::motion::Motion;
use super::stops::Stops;
use super::{Input, MAX_QUEUE, MAX_SPEEDS, Nodes, Options, Output, Transmit};

/// Kind of work that was sent last. The kinds take turns, so that none of them waits for ever.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
enum Turn {
    #[default]
    KeepAlive,
    Speed,
    Request,
}

impl Turn {
    /// All kinds, in the order in which they are asked for the next packet.
    const fn next(self) -> [Self; 3] {
        match self {
            Self::KeepAlive => [Self::Speed, Self::Request, Self::KeepAlive],
            Self::Speed => [Self::Request, Self::KeepAlive, Self::Speed],
            Self::Request => [Self::KeepAlive, Self::Speed, Self::Request],
        }
    }
}

/// The master of a bus.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct HostMachine {
    pub(super) options: Options,
    pub(super) line: Line,
    /// Time at which the gap after the last packet is over.
    pub(super) free_at: Option<Millis>,
    pub(super) doubt: Doubt,
    pub(super) deaf: Deaf,
    pub(super) stops: Stops,
    pub(super) queue: ArrayVec<Pending, MAX_QUEUE>,
    pub(super) speeds: ArrayVec<Speed, MAX_SPEEDS>,
    turn: Turn,
    pub(super) kept: KeptNodes,
    pub(super) emergency: Option<Emergency>,
    pub(super) motion: Motion,
    was_up: bool,
}

motion_core::debug! { HostMachine { options line free_at doubt deaf stops queue speeds turn kept emergency motion was_up } }

machine! { HostMachine }

impl HostMachine {
    /// A master whose line is down.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self {
            options,
            line: Line::Offline,
            free_at: None,
            doubt: Doubt::default(),
            deaf: Deaf::default(),
            stops: Stops::default(),
            queue: ArrayVec::new(),
            speeds: ArrayVec::new(),
            turn: Turn::default(),
            kept: KeptNodes::new(),
            emergency: None,
            motion: Motion::NOTHING,
            was_up: false,
        }
    }

    /// The same master on a clock that was set back by so many milliseconds, to compare machines that differ only by their age.
    #[doc(hidden)]
    #[must_use]
    pub fn set_back(mut self, by: u64) -> Self {
        let by = Millis(by);
        self.line = self.line.set_back(by);
        self.free_at = self.free_at.map(|free| Millis(free.since(by)));
        for kept in &mut self.kept {
            kept.set_back(by);
        }
        self.doubt.set_back(by);
        self.deaf.set_back(by);
        self.stops.set_back(by);
        self.emergency = self.emergency.map(|emergency| emergency.set_back(by));
        self
    }

    /// Nodes that an emergency stop addresses.
    #[must_use]
    pub const fn nodes(&self) -> Nodes {
        self.options.nodes()
    }

    /// Number of commands and stops that have not ended.
    #[must_use]
    pub fn pending(&self) -> usize {
        let out = matches!(self.line, Line::Waiting(waiting) if waiting.job.token().is_some() || matches!(waiting.job, Job::Stop(_)));
        let waiting = self.queue.len().saturating_add(self.speeds.len());
        waiting.saturating_add(self.stops.len()).saturating_add(out.into())
    }

    fn run<'a>(&mut self, now: Millis, output: &mut Output<'a>, input: Input<'a>) {
        self.expire(now);
        match input {
            Input::LinkUp if self.line == Line::Offline => {
                self.line = Line::Idle;
                self.doubt.link_up(self.drained(now));
                self.deaf.link_up(now);
                output.event(Event::Ready { reconnected: core::mem::replace(&mut self.was_up, true) });
            }
            Input::LinkDown if self.line != Line::Offline => {
                output.event(Event::LinkDown);
                self.drop_all(now, output, Failure::LinkDown);
                (self.line, self.free_at) = (Line::Offline, None);
                self.emergency_without_line(output);
            }
            Input::Received(message) => self.received(now, output, message),
            Input::Noise => output.event(Event::Noise),
            Input::Command(token, command) => self.command(now, output, token, command),
            Input::LinkUp | Input::LinkDown | Input::Wake => {}
        }
        self.send_next(now, output);
        self.wakes(now, output);
    }

    /// Ends the waits whose time is over.
    fn expire(&mut self, now: Millis) {
        self.doubt.expire(now);
        self.deaf.expire(now);
        self.stops.expire(now);
    }

    /// Sends the next packet, if one may be sent: first new stops, whatever the line does; then, on a free line, the other
    /// stops and the emergency stop; then keep-alives, speeds and requests in turn. A request waits until its answer cannot
    /// be the answer to something else.
    fn send_next(&mut self, now: Millis, output: &mut Output<'_>) {
        self.line_is_due(now, output);
        // A step that comes late may have begun waits that are over.
        self.expire(now);
        if self.free_at.is_some_and(|free| now >= free) {
            self.free_at = None;
        }
        let may_write = self.line != Line::Offline && self.free_at.is_none();
        if !may_write || self.send_stop(now, output) || self.line != Line::Idle {
            return;
        }
        if self.emergency.is_some() {
            self.send_emergency(now, output);
        }
        // While an emergency stop goes on, nothing else waits.
        if self.line != Line::Idle {
            return;
        }
        let next = self.turn.next().into_iter().find_map(|turn| self.take(now, turn).map(|job| (turn, job)));
        if let Some((turn, job)) = next {
            self.turn = turn;
            self.send(now, output, job);
        }
    }

    /// Takes the next work of one kind.
    fn take(&mut self, now: Millis, turn: Turn) -> Option<Job> {
        match turn {
            Turn::KeepAlive => self.keep_alive_due(now).map(Job::KeepAlive),
            Turn::Speed => self.speed_due().map(Job::Speed),
            Turn::Request => {
                let request = self.queue.first()?;
                let Transmit { message, .. } = request.transmit;
                // What may move, or makes a node deaf, waits until the stops before it are confirmed.
                let is_held = (message.conduct().may_move() || blocks(&message) > 0) && !self.stops.is_empty();
                let may = !is_held && self.is_clear(&request.transmit) && self.deaf.allows(&request.transmit);
                if may { self.queue.pop_at(0).map(Job::Request) } else { None }
            }
        }
    }

    /// Whether a packet is to be sent as soon as the line allows.
    fn has_work(&self) -> bool {
        let is_stopping = self.emergency.is_some() || !self.stops.is_empty();
        is_stopping || !self.queue.is_empty() || !self.speeds.is_empty()
    }

    fn wakes(&self, now: Millis, output: &mut Output<'_>) {
        if self.line == Line::Offline {
            return;
        }
        if let Some(until) = self.line.until() {
            output.wake_by(until);
        }
        let is_idle = self.line == Line::Idle;
        let wants = is_idle && self.has_work() || self.stops.first(&self.deaf).is_some();
        let kept = self.next_keep_alive().filter(|_| is_idle);
        let held = [self.doubt.until(), self.deaf.until(), self.stops.next(), self.emergency_not_before()];
        let is_held = self.has_work() || !self.kept.is_empty() || is_idle && !self.doubt.is_over();
        let held = held.into_iter().flatten().filter(|_| is_held);
        for due in held.chain(self.free_at.filter(|_| wants)).chain(kept) {
            let due = self.free_at.map_or(due, |free| free.max(due));
            if due > now {
                output.wake_by(due);
            }
        }
    }
}
