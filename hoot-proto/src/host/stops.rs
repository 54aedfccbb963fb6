//! Stops: they overtake everything, and are sent until they are answered (decision H-19).
//!
//! A stop that finds the line free is a request like others. One that does not is sent all the same, as soon as the gap
//! allows; but an answer that comes then may be the answer to what it overtook. So it is sent once more when the line is
//! clear, and only that time counts.

use arrayvec::ArrayVec;
use motion_core::time::Millis;

use super::line::{Job, Line, is_answered};
use super::{Dropped, Event, Failure, HostMachine, MAX_STOPS, NotTaken, Outcome, Output, Request, Token};
use crate::frame::Address;
use crate::message::{HostMessage, Motor, MotorStop, Pause, Stop as StopMessage};

/// A stop that is not answered yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Stop {
    pub(super) to: Address,
    pub(super) message: HostMessage<'static>,
    /// The application's, or none for those that the machine adds.
    pub(super) token: Option<Token>,
    /// Whether it has been sent at all.
    is_sent: bool,
}

/// One more than may be added: a speed that a stop overtakes may leave a stop of its own behind.
const ROOM: usize = MAX_STOPS + 1;

/// Stops that wait, those first that have not been sent yet.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub(super) struct Stops(ArrayVec<Stop, ROOM>);

impl Stops {
    /// The next one to be sent at once, whatever the line does.
    fn take_new(&mut self) -> Option<Stop> {
        self.0.iter().position(|stop| !stop.is_sent).and_then(|at| self.0.pop_at(at))
    }

    pub(super) fn has_new(&self) -> bool {
        self.0.iter().any(|stop| !stop.is_sent)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// The next one to be sent on a free line.
    pub(super) fn take(&mut self) -> Option<Stop> {
        self.take_new().or_else(|| self.0.pop_at(0))
    }

    /// One that has been sent waits again. There is room, for it came out of here.
    pub(super) fn put_back(&mut self, stop: Stop) {
        let _ = self.0.try_push(Stop { is_sent: true, ..stop });
    }

    /// The same stop for the same node, if it waits.
    fn same(&mut self, to: Address, message: &HostMessage<'_>) -> Option<&mut Stop> {
        self.0.iter_mut().find(|stop| stop.to == to && stop.message == *message)
    }

    /// Ends all of them.
    pub(super) fn drop_all(&mut self, output: &mut Output, why: Dropped) {
        for stop in core::mem::take(self).0 {
            if let Some(token) = stop.token {
                output.event(Event::dropped(token, why, stop.is_sent));
            }
        }
    }
}

impl HostMachine {
    /// Takes a stop of the application.
    pub(super) fn stop(&mut self, output: &mut Output, Request { token, to, message }: Request) {
        self.cancel_motion(output, to, &message);
        self.add_stop(output, to, message, Some(token));
    }

    /// Has each node do what a broadcast would not tell it through a bridge (decision H-20).
    pub(super) fn stop_each(&mut self, output: &mut Output, broadcast: &HostMessage<'_>) {
        self.cancel_motion(output, Address::BROADCAST, broadcast);
        let message = match broadcast {
            HostMessage::BroadcastPause(_) => HostMessage::Pause(Pause {}),
            _ => HostMessage::Stop(StopMessage {}),
        };
        let nodes = self.options.nodes;
        if nodes.as_slice().is_empty() {
            self.emergency_stop(output);
        }
        for &node in nodes.as_slice() {
            self.add_stop(output, node, message, None);
        }
    }

    /// Puts a stop where it will be sent next. Too many stops that nobody answers are an emergency (decision H-23).
    pub(super) fn add_stop(
        &mut self,
        output: &mut Output,
        to: Address,
        message: HostMessage<'static>,
        token: Option<Token>,
    ) {
        let out = matches!(self.line, Line::Waiting(waiting) if matches!(waiting.job, Job::Stop(_)));
        if let Some(same) = self.stops.same(to, &message) {
            let was_sent = core::mem::replace(&mut same.is_sent, false);
            if let Some(before) = token.and_then(|token| same.token.replace(token)) {
                output.event(Event::dropped(before, Dropped::Again, was_sent));
            }
        } else if self.stops.len().saturating_add(out.into()) < MAX_STOPS {
            let _ = self.stops.0.try_push(Stop { to, message, token, is_sent: false });
        } else {
            if let Some(token) = token {
                let outcome = Outcome::Failed(Failure::NotTaken(NotTaken::Full));
                output.event(Event::Ended { token, outcome });
            }
            self.emergency_stop(output);
        }
    }

    /// Sends a stop that waits: on a free line as a request, past everything else as a first shot.
    pub(super) fn send_stop(&mut self, now: Millis, output: &mut Output) -> bool {
        let is_free = self.line == Line::Idle && self.emergency.is_none();
        let next = if is_free { self.stops.take() } else { self.stops.take_new() };
        let Some(stop) = next else { return false };
        if is_free {
            self.send(now, output, Job::Stop(stop));
            return true;
        }
        let doubt = now.after(self.options.drain.into());
        self.overtake(now, output);
        self.line = match self.line {
            Line::Quiet(until) => Line::Quiet(until.max(doubt)),
            _ => Line::Settling(doubt),
        };
        self.write(now, output, Job::Stop(stop));
        // An emergency stop asks for itself whether all is at rest.
        if is_answered(&stop.message) && self.emergency.is_none() {
            self.stops.put_back(stop);
        } else if let Some(token) = stop.token {
            output.event(Event::Ended { token, outcome: Outcome::Sent });
        }
        true
    }

    /// A stop was refused, or nobody answered it.
    pub(super) fn not_stopped(&mut self, output: &mut Output, stop: &Stop) {
        output.event(Event::StopNotConfirmed { node: Some(stop.to) });
        // Firmware refuses the controller's stop in joystick mode, but not those of its motors (safety decision 2); and
        // through a bridge that looks like silence.
        if stop.message == HostMessage::Stop(StopMessage {}) {
            for motor in Motor::ALL {
                self.add_stop(output, stop.to, HostMessage::MotorStop(MotorStop { motor }), None);
            }
        }
    }

    /// Takes out of the queue what would move what a stop stops.
    fn cancel_motion(&mut self, output: &mut Output, to: Address, stop: &HostMessage<'_>) {
        self.speeds.retain(|speed| {
            let send = speed.send();
            !stop.stops(to, &send.message, send.to)
        });
        self.queue.retain(|request| {
            let is_dropped = request.message.may_start_motion() && stop.stops(to, &request.message, request.to);
            if is_dropped {
                output.event(Event::dropped(request.token, Dropped::Stop, false));
            }
            !is_dropped
        });
    }
}

impl Event {
    pub(super) const fn dropped(token: Token, why: Dropped, was_sent: bool) -> Self {
        Self::Ended { token, outcome: Outcome::Failed(Failure::Dropped { why, was_sent }) }
    }
}
