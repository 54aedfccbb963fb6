//! Stops: they overtake everything, and are repeated until they are answered (decision H-19).
//!
//! A stop that finds the line free is sent like any other request. A stop that does not is sent too, as soon as the gap
//! allows; but an answer that comes then may be the answer to the packet that it overtook. So it is sent once more when
//! the line is clear, and only the answer to that packet counts. The same stop is never sent again within the time to wait
//! for an answer. At a node that may be deaf, one stop of its controller takes the place of all others (decision H-41).

use arrayvec::ArrayVec;
use motion_core::machine::Token;
use motion_core::time::Millis;

use super::deaf::Deaf;
use super::event::{Event, Failure, Outcome, Refusal, StopTarget};
use super::jobs::{Job, Pending, Stop};
use super::line::{Line, Waiting, is_answered};
use super::{HostMachine, MAX_STOPS, Output, Transmit};
use crate::frame::Address;
use crate::message::{self, HostMessage, Motor, MotorStop, Pause};

/// Room for one stop more than may be added, because a speed that a stop overtakes may add a stop of its own.
const ROOM: usize = MAX_STOPS + 1;

/// Stops that wait.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub(super) struct Stops(ArrayVec<Stop, ROOM>);

impl Stops {
    /// Finds the first stop for which there is a packet to send now: its place, and the packet.
    fn find(&self, packet: impl Fn(&Stop) -> Option<Transmit>) -> Option<(usize, Transmit)> {
        let may = |stop: &Stop| stop.not_before.is_none();
        self.0.iter().enumerate().filter(|(_, stop)| may(stop)).find_map(|(at, stop)| Some((at, packet(stop)?)))
    }

    /// Finds the first stop that was not sent and may be sent now: its place, and the packet.
    pub(super) fn first(&self, deaf: &Deaf) -> Option<(usize, Transmit)> {
        self.find(|stop| if stop.sent == 0 { deaf.stop_for(&stop.transmit) } else { None })
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Lets a stop that has been sent wait again, and not be sent before a time. There is room, because it came out of here.
    pub(super) fn put_back(&mut self, stop: Stop, not_before: Option<Millis>) {
        let sent = stop.sent.saturating_add(1);
        let _ = self.0.try_push(Stop { sent, not_before, is_heard: false, ..stop });
    }

    /// Notes that an answer without a value came, which may be that to one of the stops.
    pub(super) fn heard(&mut self) {
        for stop in &mut self.0 {
            stop.is_heard |= stop.sent > 0;
        }
    }

    /// Whether a stop waits of the application, or one that nothing was heard of.
    pub(super) fn hold_speeds(&self) -> bool {
        self.0.iter().any(|stop| stop.token.is_some() || !stop.is_heard)
    }

    /// Finds the same stop for the same node, if it waits.
    fn same(&mut self, transmit: &Transmit) -> Option<&mut Stop> {
        self.0.iter_mut().find(|stop| stop.transmit == *transmit)
    }

    /// Notes that a packet goes out. Stops of what it may move do not wait for any time.
    pub(super) fn moves(&mut self, packet: &Transmit) {
        for stop in self.0.iter_mut().filter(|stop| concerns(&stop.transmit, packet)) {
            stop.not_before = None;
        }
    }

    /// Lets stops be sent whose time has come.
    pub(super) fn expire(&mut self, now: Millis) {
        for stop in &mut self.0 {
            stop.not_before = stop.not_before.filter(|before| now < *before);
        }
    }

    /// Time before which no stop is sent again.
    pub(super) fn next(&self) -> Option<Millis> {
        self.0.iter().filter_map(|stop| stop.not_before).min()
    }

    pub(super) fn set_back(&mut self, by: Millis) {
        for stop in &mut self.0 {
            stop.not_before = stop.not_before.map(|before| Millis(before.since(by)));
        }
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

    /// Takes a stop of the application. A broadcast that would be the second packet at a node that may be deaf waits, and each
    /// listed node is stopped meanwhile (decision H-41).
    pub(super) fn stop(&mut self, now: Millis, output: &mut Output<'_>, Pending { token, transmit }: Pending) {
        self.cancel_motion(output, &transmit);
        self.add_stop(now, output, transmit, Some(token));
        let nodes = self.options.nodes();
        if transmit.to == Address::BROADCAST && !nodes.as_slice().is_empty() && !self.deaf.allows(&transmit) {
            self.stop_each(now, output, &transmit);
        }
    }

    /// Stops each listed node, instead of a broadcast that a bridge would not pass on (decision H-20).
    pub(super) fn stop_each(&mut self, now: Millis, output: &mut Output<'_>, broadcast: &Transmit) {
        self.cancel_motion(output, broadcast);
        let message = match broadcast.message {
            HostMessage::BroadcastPause(_) => Pause {}.into(),
            _ => message::Stop {}.into(),
        };
        let nodes = self.options.nodes();
        if nodes.as_slice().is_empty() {
            self.emergency_stop(now, output);
        }
        for &to in nodes.as_slice() {
            self.add_stop(now, output, Transmit { to, message }, None);
        }
    }

    /// Adds the stop of a motor, without a command of the application.
    pub(super) fn add_motor_stop(&mut self, now: Millis, output: &mut Output<'_>, to: Address, motor: Motor) {
        self.add_stop(now, output, Transmit { to, message: MotorStop { motor }.into() }, None);
    }

    /// Adds a stop, which goes out before everything else. Too many stops that no node answers are an emergency (decision
    /// H-23).
    pub(super) fn add_stop(&mut self, now: Millis, output: &mut Output<'_>, transmit: Transmit, token: Option<Token>) {
        let out = match &mut self.line {
            Line::Waiting(Waiting { job: Job::Stop(stop), .. }) => Some(stop),
            _ => None,
        };
        let is_full = self.stops.len().saturating_add(out.is_some().into()) >= MAX_STOPS;
        // The answer that is awaited counts for the new command too: nothing that may move goes out after the stop.
        let out = out.filter(|stop| stop.transmit == transmit).map(|stop| (&mut stop.token, 1));
        let same = out.or_else(|| {
            let stop = self.stops.same(&transmit)?;
            // Speeds may have gone out since the stop was sent. So it counts as never sent.
            stop.is_own = false;
            Some((&mut stop.token, core::mem::take(&mut stop.sent)))
        });
        if let Some((old, sent)) = same {
            if let Some(before) = token.and_then(|token| old.replace(token)) {
                let outcome = Outcome::unanswered(&transmit.message, sent > 0, Failure::Superseded);
                output.event(Event::Ended { token: before, outcome });
            }
        } else if !is_full {
            let _ = self.stops.0.try_push(Stop {
                transmit,
                token,
                sent: 0,
                is_own: false,
                not_before: None,
                is_heard: false,
            });
        } else {
            if let Some(token) = token {
                output.event(Event::Ended { token, outcome: Outcome::Refused(Refusal::Busy) });
            }
            self.emergency_stop(now, output);
        }
    }

    /// Sends a stop that waits: one that was not sent yet past everything else, the others on a free line.
    pub(super) fn send_stop(&mut self, now: Millis, output: &mut Output<'_>) -> bool {
        let is_free = self.line == Line::Idle && self.emergency.is_none();
        let again = |stop: &Stop| {
            let is_lost = stop.sent <= self.options.retries() && !stop.is_heard;
            let may = self.believes(&stop.transmit, stop.is_own) || is_lost;
            (is_free && stop.sent > 0 && may && self.deaf.allows(&stop.transmit)).then_some(stop.transmit)
        };
        let found = self.stops.first(&self.deaf).or_else(|| self.stops.find(again));
        let Some((at, packet)) = found else { return false };
        let Some(stop) = self.stops.0.pop_at(at) else { return false };
        self.overtake(now, output);
        let message = &stop.transmit.message;
        let is_own = packet == stop.transmit;
        if self.believes(&stop.transmit, stop.is_own) && is_own && self.line == Line::Idle && self.emergency.is_none() {
            self.send(now, output, Job::Stop(stop));
            return true;
        }
        // An emergency stop asks the motors itself whether they rest.
        if is_answered(message) && self.emergency.is_none() {
            let not_before = is_own.then(|| now.after(self.options.timeout().into()));
            self.stops.put_back(Stop { is_own: is_own || stop.is_own, ..stop }, not_before);
        } else if let Some(token) = stop.token {
            output.event(Event::Ended { token, outcome: Outcome::Sent });
        }
        if is_answered(&packet.message) {
            self.owe(&packet.message, 1, now);
        }
        self.transmit(now, output, packet);
        true
    }

    /// Tells that a stop was refused or not answered.
    pub(super) fn not_stopped(&mut self, now: Millis, output: &mut Output<'_>, stop: &Stop) {
        let Transmit { to, message } = stop.transmit;
        self.tell_not_stopped(output, StopTarget::of(to, &message));
        // Firmware refuses the stop of the controller in joystick mode, but not those of its motors (safety decision 2).
        // Through a bridge a refusal looks like silence.
        if matches!(message, HostMessage::Stop(_)) {
            for motor in Motor::ALL {
                self.add_motor_stop(now, output, to, motor);
            }
        }
    }

    pub(super) fn tell_not_stopped(&mut self, output: &mut Output<'_>, target: StopTarget) {
        self.motion.not_stopped(&self.options.nodes(), target);
        output.event(Event::StopNotConfirmed(target));
    }

    /// Ends all stops that wait. An emergency stop takes their place; when the line goes down, they are not confirmed.
    pub(super) fn drop_stops(&mut self, output: &mut Output<'_>, why: Failure) {
        for Stop { transmit: Transmit { to, message }, token, sent, .. } in core::mem::take(&mut self.stops).0 {
            if let Some(token) = token {
                output.event(Event::Ended { token, outcome: Outcome::unanswered(&message, sent > 0, why) });
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
