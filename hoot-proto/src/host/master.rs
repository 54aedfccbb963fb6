//! The master as a whole: what goes next.

use arrayvec::ArrayVec;
use motion_core::machine::Machine;
use motion_core::time::Millis;

use super::emergency::Emergency;
use super::line::{Job, Line};
use super::stops::Stops;
use super::stream::{KeptNodes, Speed};
use super::{Dropped, Event, Input, MAX_QUEUE, MAX_SPEEDS, Nodes, Options, Output, Request, State};
use crate::state::debug;

/// Whose turn it was: nobody waits for ever, however much the others want.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
enum Turn {
    #[default]
    KeepAlive,
    Speed,
    Request,
}

impl Turn {
    /// The three, beginning with the next one.
    const fn next(self) -> [Self; 3] {
        match self {
            Self::KeepAlive => [Self::Speed, Self::Request, Self::KeepAlive],
            Self::Speed => [Self::Request, Self::KeepAlive, Self::Speed],
            Self::Request => [Self::KeepAlive, Self::Speed, Self::Request],
        }
    }
}

/// The master of a bus. [`Options`] say how it behaves; [`Machine::step`] takes what happened.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct HostMachine {
    pub(super) options: Options,
    pub(super) line: Line,
    /// When the gap behind the last packet is over.
    pub(super) free_at: Option<Millis>,
    pub(super) stops: Stops,
    pub(super) queue: ArrayVec<Request, MAX_QUEUE>,
    pub(super) speeds: ArrayVec<Speed, MAX_SPEEDS>,
    turn: Turn,
    pub(super) kept: KeptNodes,
    pub(super) emergency: Option<Emergency>,
}

debug! { HostMachine { options line free_at stops queue speeds turn kept emergency } }

impl HostMachine {
    /// A master without a line.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self {
            options,
            line: Line::Offline,
            free_at: None,
            stops: Stops::default(),
            queue: ArrayVec::new(),
            speeds: ArrayVec::new(),
            turn: Turn::default(),
            kept: KeptNodes::new(),
            emergency: None,
        }
    }

    /// What it does with the line.
    #[must_use]
    pub const fn state(&self) -> State {
        self.line.state()
    }

    /// The nodes that an emergency stop addresses.
    #[must_use]
    pub const fn nodes(&self) -> &Nodes {
        &self.options.nodes
    }

    /// Requests that have not come to their end, those of the machine itself left out.
    #[must_use]
    pub fn pending(&self) -> usize {
        let out = matches!(self.line, Line::Waiting(waiting) if matches!(waiting.job, Job::Request(_) | Job::Stop(_)));
        self.queue.len().saturating_add(self.stops.len()).saturating_add(out.into())
    }

    /// Sends what goes next, if anything may: new stops past everything, then an emergency, then on a free line the
    /// other stops, and then keep-alives, speeds and requests in turn.
    fn advance(&mut self, now: Millis, output: &mut Output) {
        self.line_is_due(now, output);
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
        // An emergency stop that goes on has sent something.
        if self.line != Line::Idle {
            return;
        }
        let next = self.turn.next().into_iter().find_map(|turn| self.take(now, turn).map(|job| (turn, job)));
        if let Some((turn, job)) = next {
            self.turn = turn;
            self.send(now, output, job);
        }
    }

    /// What goes next of one kind.
    fn take(&mut self, now: Millis, turn: Turn) -> Option<Job> {
        match turn {
            Turn::KeepAlive => self.keep_alive_due(now).map(Job::KeepAlive),
            Turn::Speed => self.speeds.pop_at(0).map(Job::Speed),
            Turn::Request => self.queue.pop_at(0).map(Job::Request),
        }
    }

    /// Whether something is to be sent as soon as the line allows.
    fn has_work(&self) -> bool {
        let is_stopping = self.emergency.is_some() || !self.stops.is_empty();
        is_stopping || !self.queue.is_empty() || !self.speeds.is_empty()
    }

    fn wakes(&self, output: &mut Output) {
        if self.line == Line::Offline {
            return;
        }
        if let Some(until) = self.line.until() {
            output.wake_by(until);
        }
        let is_idle = self.line == Line::Idle;
        let wants = is_idle && self.has_work() || self.stops.has_new();
        if let Some(free) = self.free_at.filter(|_| wants) {
            output.wake_by(free);
        }
        if let Some(due) = self.next_keep_alive().filter(|_| is_idle) {
            output.wake_by(self.free_at.map_or(due, |free| free.max(due)));
        }
    }
}

impl Machine for HostMachine {
    type Input<'a> = Input<'a>;
    type Output = Output;

    fn step(mut self, now: Millis, input: Input<'_>) -> (Self, Output) {
        let mut output = Output::default();
        let out = &mut output;
        match input {
            Input::LinkUp if self.line == Line::Offline => self.line = Line::Idle,
            Input::LinkDown => {
                self.drop_all(out, Dropped::Link);
                (self.line, self.free_at) = (Line::Offline, None);
                self.emergency_without_line(out);
            }
            Input::Received(message) => self.received(now, out, &message),
            Input::Noise => out.event(Event::Noise),
            Input::Command(command) => self.command(now, out, command),
            Input::LinkUp | Input::Wake => {}
        }
        self.advance(now, out);
        self.wakes(out);
        (self, output)
    }
}
