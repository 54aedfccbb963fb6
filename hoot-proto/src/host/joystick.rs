//! A joystick: speeds of which the last one counts, and keep-alives.

use arrayvec::ArrayVec;
use motion_core::machine::Token;
use motion_core::time::Millis;

use super::event::{Event, Failure, Outcome, Refusal};
use super::jobs::{Speed, keep_alive};
use super::{HostMachine, MAX_KEPT, Output, Transmit};
use crate::frame::{Address, Table};

/// A node that is kept alive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct KeptNode {
    to: Address,
    due: Millis,
}

impl KeptNode {
    pub(super) const fn set_back(&mut self, by: Millis) {
        self.due = Millis(self.due.since(by));
    }
}

pub(super) type KeptNodes = ArrayVec<KeptNode, MAX_KEPT>;

impl HostMachine {
    /// Takes the next speed of a motor, in the place of a speed that waits.
    pub(super) fn set_speed(&mut self, output: &mut Output<'_>, next: Speed) {
        let refused = self.refusal(&next.transmit());
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
    pub(super) fn speed_ended(&mut self, output: &mut Output<'_>, speed: Speed, is_done: bool) {
        let Speed { to, motor, .. } = speed;
        let is_replaced = self.speeds.iter().any(|next| (next.to, next.motor) == (to, motor) && !next.is_rest());
        if speed.is_rest() && !is_done && !is_replaced {
            self.add_motor_stop(output, to, motor);
        }
    }

    /// Keeps a node alive from now on, or no longer.
    pub(super) fn set_keep_alive(&mut self, now: Millis, output: &mut Output<'_>, token: Token, to: Address, on: bool) {
        self.kept.retain(|kept| kept.to != to);
        let mut refused = None;
        if on {
            let kept = KeptNode { to, due: now };
            refused = self.refusal(&keep_alive(to));
            refused = refused.or_else(|| self.kept.try_push(kept).err().map(|_| Refusal::Busy));
        }
        output.event(Event::Ended { token, outcome: refused.map_or(Outcome::Applied, Outcome::Refused) });
    }

    /// The node that was sent nothing for too long.
    pub(super) fn keep_alive_due(&self, now: Millis) -> Option<Address> {
        self.kept.iter().filter(|kept| now >= kept.due).min_by_key(|kept| kept.due).map(|kept| kept.to)
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
