//! Stops: they overtake everything, and are repeated until they are answered (decision H-19).
//!
//! A stop that finds the line free is sent like any other request. A stop that does not is sent too, as soon as the gap
//! allows; but an answer that comes then may be the answer to the packet that it overtook. So it is sent once more when
//! the line is clear, and only the answer to that packet counts.

use arrayvec::ArrayVec;
use motion_core::machine::Token;
use motion_core::time::Millis;

use super::event::{Event, Failure, Outcome, Refusal, StopTarget};
use super::jobs::{Job, Pending, Stop};
use super::line::{Line, is_answered};
use super::{HostMachine, MAX_STOPS, Output, Transmit};
use crate::frame::Address;
use crate::message::{self, HostMessage, Motor, MotorStop, Pause};

/// Room for one stop more than may be added, because a speed that a stop overtakes may add a stop of its own.
const ROOM: usize = MAX_STOPS + 1;

/// Stops that wait.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub(super) struct Stops(ArrayVec<Stop, ROOM>);

impl Stops {
    /// Takes the next stop that has not been sent yet, which goes out whatever the line does.
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

    /// Takes the next stop to send on a free line.
    fn take(&mut self) -> Option<Stop> {
        self.take_new().or_else(|| self.0.pop_at(0))
    }

    /// Lets a stop that has been sent wait again. There is room, because it came out of here.
    pub(super) fn put_back(&mut self, stop: Stop) {
        let _ = self.0.try_push(Stop { is_sent: true, ..stop });
    }

    /// Finds the same stop for the same node, if it waits.
    fn same(&mut self, transmit: &Transmit) -> Option<&mut Stop> {
        self.0.iter_mut().find(|stop| stop.transmit == *transmit)
    }
}

/// Whether a stop concerns what another message would set in motion: the stop of a motor concerns that motor and what moves
/// all motors, the stop of a node everything in it, a broadcast everything.
fn concerns(stop: &Transmit, other: &Transmit) -> bool {
    let part = |transmit: &Transmit| transmit.message.selector().sub_address;
    let same_part = part(stop) == 0 || part(other) == 0 || part(stop) == part(other);
    let to_all = stop.to == Address::BROADCAST || other.to == Address::BROADCAST;
    to_all || stop.to == other.to && same_part
}

impl HostMachine {
    /// Whether a stop is not confirmed yet.
    pub(super) fn is_stopping(&self) -> bool {
        let out = matches!(self.line, Line::Waiting(waiting) if matches!(waiting.job, Job::Stop(_)));
        out || !self.stops.is_empty() || self.emergency.is_some()
    }

    /// Takes a stop of the application.
    pub(super) fn stop(&mut self, output: &mut Output<'_>, Pending { token, transmit }: Pending) {
        self.cancel_motion(output, &transmit);
        self.add_stop(output, transmit, Some(token));
    }

    /// Stops each listed node, instead of a broadcast that a bridge would not pass on (decision H-20).
    pub(super) fn stop_each(&mut self, output: &mut Output<'_>, broadcast: &Transmit) {
        self.cancel_motion(output, broadcast);
        let message = match broadcast.message {
            HostMessage::BroadcastPause(_) => Pause {}.into(),
            _ => message::Stop {}.into(),
        };
        let nodes = self.options.nodes();
        if nodes.as_slice().is_empty() {
            self.emergency_stop(output);
        }
        for &to in nodes.as_slice() {
            self.add_stop(output, Transmit { to, message }, None);
        }
    }

    /// Adds the stop of a motor, without a command of the application.
    pub(super) fn add_motor_stop(&mut self, output: &mut Output<'_>, to: Address, motor: Motor) {
        self.add_stop(output, Transmit { to, message: MotorStop { motor }.into() }, None);
    }

    /// Adds a stop, which goes out before everything else. Too many stops that no node answers are an emergency (decision
    /// H-23).
    fn add_stop(&mut self, output: &mut Output<'_>, transmit: Transmit, token: Option<Token>) {
        let out = matches!(self.line, Line::Waiting(waiting) if matches!(waiting.job, Job::Stop(_)));
        if let Some(same) = self.stops.same(&transmit) {
            let was_sent = core::mem::replace(&mut same.is_sent, false);
            if let Some(before) = token.and_then(|token| same.token.replace(token)) {
                let outcome = Outcome::unanswered(&transmit.message, was_sent, Failure::Superseded);
                output.event(Event::Ended { token: before, outcome });
            }
        } else if self.stops.len().saturating_add(out.into()) < MAX_STOPS {
            let _ = self.stops.0.try_push(Stop { transmit, token, is_sent: false });
        } else {
            if let Some(token) = token {
                output.event(Event::Ended { token, outcome: Outcome::Refused(Refusal::Busy) });
            }
            self.emergency_stop(output);
        }
    }

    /// Sends a stop that waits: on a free line like any request, otherwise past everything else.
    pub(super) fn send_stop(&mut self, now: Millis, output: &mut Output<'_>) -> bool {
        let is_free = self.line == Line::Idle && self.emergency.is_none();
        let next = if is_free { self.stops.take() } else { self.stops.take_new() };
        let Some(stop) = next else { return false };
        if is_free {
            self.send(now, output, Job::Stop(stop));
            return true;
        }
        let doubt = now.after(self.options.drain().into());
        self.overtake(now, output);
        self.line = match self.line {
            Line::Quiet(until) => Line::Quiet(until.max(doubt)),
            _ => Line::Settling(doubt),
        };
        self.write(now, output, Job::Stop(stop));
        // An emergency stop asks the motors itself whether they rest.
        if is_answered(&stop.transmit.message) && self.emergency.is_none() {
            self.stops.put_back(stop);
        } else if let Some(token) = stop.token {
            output.event(Event::Ended { token, outcome: Outcome::Sent });
        }
        true
    }

    /// Tells that a stop was refused or not answered.
    pub(super) fn not_stopped(&mut self, output: &mut Output<'_>, stop: &Stop) {
        let Transmit { to, message } = stop.transmit;
        self.tell_not_stopped(output, StopTarget::of(to, &message));
        // Firmware refuses the stop of the controller in joystick mode, but not those of its motors (safety decision 2).
        // Through a bridge a refusal looks like silence.
        if matches!(message, HostMessage::Stop(_)) {
            for motor in Motor::ALL {
                self.add_motor_stop(output, to, motor);
            }
        }
    }

    pub(super) fn tell_not_stopped(&mut self, output: &mut Output<'_>, target: StopTarget) {
        self.motion.not_stopped(&self.options.nodes(), target);
        output.event(Event::StopNotConfirmed(target));
    }

    /// Ends all stops that wait. An emergency stop takes their place; when the line goes down, they are not confirmed.
    pub(super) fn drop_stops(&mut self, output: &mut Output<'_>, why: Failure) {
        for Stop { transmit: Transmit { to, message }, token, is_sent } in core::mem::take(&mut self.stops).0 {
            if let Some(token) = token {
                output.event(Event::Ended { token, outcome: Outcome::unanswered(&message, is_sent, why) });
            }
            if why == Failure::LinkDown {
                self.tell_not_stopped(output, StopTarget::of(to, &message));
            }
        }
    }

    /// Removes what waits and would move what a stop stops.
    fn cancel_motion(&mut self, output: &mut Output<'_>, stop: &Transmit) {
        self.speeds.retain(|speed| {
            let stays = !concerns(stop, &speed.transmit());
            if !stays {
                output.event(Event::Ended { token: speed.token, outcome: Outcome::Failed(Failure::Stopped) });
            }
            stays
        });
        self.queue.retain(|Pending { token, transmit }| {
            let stays = !transmit.message.conduct().may_move() || !concerns(stop, transmit);
            if !stays {
                output.event(Event::Ended { token: *token, outcome: Outcome::Failed(Failure::Stopped) });
            }
            stays
        });
    }
}
