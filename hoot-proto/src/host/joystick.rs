//! A joystick: speeds of which the last one counts, and keep-alives.

use arrayvec::ArrayVec;
use motion_core::machine::Token;
use motion_core::time::Millis;

use super::event::{Event, Failure, Outcome, Refusal};
use super::jobs::{Pending, Speed, keep_alive};
use super::{HostMachine, MAX_KEPT, Output, Transmit};
use crate::frame::{Address, Table};
use crate::message;

/// A node that is kept alive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct KeptNode {
    to: Address,
    due: Millis,
    /// Whether the node was asked although the answer may be that to something else.
    is_blind: bool,
}

impl KeptNode {
    pub(super) const fn set_back(&mut self, by: Millis) {
        self.due = Millis(self.due.since(by));
    }
}

pub(super) type KeptNodes = ArrayVec<KeptNode, MAX_KEPT>;

impl HostMachine {
    /// Takes the next speed of a motor, in the place of a speed that waits.
    pub(super) fn set_speed(&mut self, now: Millis, output: &mut Output<'_>, next: Speed) {
        let refused = self.refusal(&next.transmit());
        // A speed waits until its node hears, but a motor that is to come to rest must not. Of the stops only that of the
        // controller can be sent, and one is enough for all motors of the node.
        if refused.is_none() && next.is_rest() && self.deaf.is_deaf(next.to) {
            self.add_stop(now, output, Transmit { to: next.to, message: message::Stop {}.into() }, None);
        }
        let waits = self.speeds.iter_mut().find(|speed| (speed.to, speed.motor) == (next.to, next.motor));
        let (token, outcome) = if let Some(why) = refused {
            (next.token, Outcome::Refused(why))
        } else if let Some(waits) = waits {
            let before = core::mem::replace(waits, next);
            (before.token, Outcome::Failed(Failure::Superseded))
        } else if self.speeds.try_push(next).is_err() {
            (next.token, Outcome::Refused(Refusal::Busy))
        } else {
            return;
        };
        output.event(Event::Ended { token, outcome });
    }

    /// Acts on the end of a speed. A motor that was to come to rest is stopped, unless the node said OK or the motor is to
    /// move again (decision H-24).
    pub(super) fn speed_ended(&mut self, now: Millis, output: &mut Output<'_>, speed: Speed, is_done: bool) {
        let Speed { to, motor, .. } = speed;
        let is_replaced = self.speeds.iter().any(|next| (next.to, next.motor) == (to, motor) && !next.is_rest());
        if speed.is_rest() && !is_done && !is_replaced {
            self.add_motor_stop(now, output, to, motor);
        }
    }

    /// Keeps a node alive from now on, or no longer.
    pub(super) fn set_keep_alive(&mut self, now: Millis, output: &mut Output<'_>, token: Token, to: Address, on: bool) {
        self.kept.retain(|kept| kept.to != to);
        let mut refused = None;
        if on {
            let kept = KeptNode { to, due: now, is_blind: false };
            refused = self.refusal(&keep_alive(to));
            refused = refused.or_else(|| self.kept.try_push(kept).err().map(|_| Refusal::Busy));
        }
        output.event(Event::Ended { token, outcome: refused.map_or(Outcome::Applied, Outcome::Refused) });
    }

    /// The node that was sent nothing for too long. While an answer may be that to something else and a request waits for
    /// that to end, each node is asked once.
    pub(super) fn keep_alive_due(&mut self, now: Millis) -> Option<Address> {
        let question = |to| keep_alive(to).message;
        let is_clear = self.doubt.is_clear(&question(Address::DEFAULT));
        let waits = self.queue.first().is_some_and(|request| !self.doubt.is_clear(&request.transmit.message));
        let may = |kept: &&mut KeptNode| now >= kept.due && (is_clear || !waits || !kept.is_blind);
        let hears = |kept: &&mut KeptNode| !self.deaf.is_deaf(kept.to);
        let kept = self.kept.iter_mut().filter(may).filter(hears).min_by_key(|kept| kept.due)?;
        kept.is_blind = !is_clear;
        Some(kept.to)
    }

    /// The speed that is sent next. Stops go before it, and so do requests that wait until their answers can be told from that
    /// of a speed, but not before a speed of 0. A stop that the machine added, and of which something was heard, lets speeds
    /// go on.
    pub(super) fn speed_due(&mut self) -> Option<Speed> {
        let is_held = |speed: &Speed| {
            let is_doubtful = !self.is_clear(&speed.transmit());
            let waits = |request: &Pending| request.transmit.message.query().is_none();
            !speed.is_rest() && (self.stops.hold_speeds() || is_doubtful && self.queue.first().is_some_and(waits))
        };
        let at = self.speeds.iter().position(|speed| !self.deaf.is_deaf(speed.to) && !is_held(speed))?;
        self.speeds.pop_at(at)
    }

    /// Time at which the next node will have been sent nothing for too long.
    pub(super) fn next_keep_alive(&self) -> Option<Millis> {
        self.kept.iter().map(|kept| kept.due).min()
    }

    /// Notes that a node is sent a packet: a packet that refreshes its dead-man keeps it alive.
    pub(super) fn spoken_to(&mut self, now: Millis, transmit: &Transmit) {
        let selector = transmit.message.selector();
        if selector.table == Table::Node && selector.command >= 2 {
            let due = now.after(self.options.keep_alive().into());
            for kept in self.kept.iter_mut().filter(|kept| kept.to == transmit.to) {
                kept.due = due;
            }
        }
    }
}
