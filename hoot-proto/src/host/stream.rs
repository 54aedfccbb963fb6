//! What a joystick needs: speeds of which the last counts, and keep-alives.

use arrayvec::ArrayVec;
use motion_core::time::Millis;

use super::{Event, Failure, HostMachine, MAX_KEPT, NotTaken, Output, Send};
use crate::frame::{Address, Table};
use crate::message::{
    HostMessage, JoystickMode, Motor, MotorSetContinuousSpeed, MotorStop, ResponseCode, StepsPerSecond,
};
use crate::state::set_back;

/// The next speed of a motor.
#[expect(clippy::struct_field_names, reason = "the field of the command is called so")]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Speed {
    pub(super) to: Address,
    pub(super) motor: Motor,
    pub(super) speed: StepsPerSecond,
}

impl Speed {
    pub(super) const fn send(self) -> Send {
        let Self { to, motor, speed } = self;
        Send { to, message: HostMessage::MotorSetContinuousSpeed(MotorSetContinuousSpeed { motor, speed }) }
    }

    /// Whether the motor is to come to rest.
    pub(super) fn is_rest(self) -> bool {
        self.speed.0 == 0.0
    }
}

/// What a node is asked to keep its dead-man content: joystick mode leaves it, and it changes nothing (decision H-25).
pub(super) const fn keep_alive(to: Address) -> Send {
    Send { to, message: HostMessage::JoystickMode(JoystickMode {}) }
}

/// A node that is kept alive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Kept {
    to: Address,
    due: Millis,
}

impl Kept {
    pub(super) const fn set_back(&mut self, by: u64) {
        self.due = set_back(self.due, by);
    }
}

pub(super) type KeptNodes = ArrayVec<Kept, MAX_KEPT>;

impl HostMachine {
    /// Takes the next speed of a motor, in the place of the one that waits.
    pub(super) fn set_speed(&mut self, output: &mut Output, next: Speed) {
        let why = self.refusal(&next.send());
        let waits = self.speeds.iter_mut().find(|speed| (speed.to, speed.motor) == (next.to, next.motor));
        let full = match (why, waits) {
            (Some(_), _) => None,
            (None, Some(waits)) => {
                *waits = next;
                None
            }
            (None, None) => self.speeds.try_push(next).err().map(|_| NotTaken::Full),
        };
        if let Some(why) = why.or(full) {
            output.event(Event::SpeedFailed { to: next.to, motor: next.motor, why: Failure::NotTaken(why) });
        }
    }

    /// A speed has an answer with this code, or none. Of those that were to stop a motor nothing less than an OK is
    /// enough: a stop goes behind them (decision H-24).
    pub(super) fn speed_ended(&mut self, output: &mut Output, speed: Speed, code: Option<ResponseCode>) {
        let Speed { to, motor, .. } = speed;
        if let Some(code) = code.filter(|code| *code != ResponseCode::OK) {
            output.event(Event::SpeedFailed { to, motor, why: Failure::Refused(code) });
        }
        let is_replaced = self.speeds.iter().any(|next| (next.to, next.motor) == (to, motor) && !next.is_rest());
        if speed.is_rest() && code != Some(ResponseCode::OK) && !is_replaced {
            self.add_stop(output, to, HostMessage::MotorStop(MotorStop { motor }), None);
        }
    }

    /// Keeps a node alive from now on, or no longer.
    pub(super) fn set_keep_alive(&mut self, now: Millis, output: &mut Output, to: Address, on: bool) {
        self.kept.retain(|kept| kept.to != to);
        if !on {
            return;
        }
        let refused = self.refusal(&keep_alive(to));
        let kept = Kept { to, due: now };
        let push = || self.kept.try_push(kept).err().map(|_| NotTaken::Full);
        if let Some(why) = refused.or_else(push) {
            output.event(Event::NotTaken(why));
        }
    }

    /// The node that has been left alone for too long.
    pub(super) fn keep_alive_due(&self, now: Millis) -> Option<Address> {
        self.kept.iter().filter(|kept| now >= kept.due).min_by_key(|kept| kept.due).map(|kept| kept.to)
    }

    /// When the next node will have been left alone for too long.
    pub(super) fn next_keep_alive(&self) -> Option<Millis> {
        self.kept.iter().map(|kept| kept.due).min()
    }

    /// A node has been sent something: if it is what refreshes its dead-man, it is kept alive by it.
    pub(super) fn spoken_to(&mut self, now: Millis, send: &Send) {
        let selector = send.message.selector();
        if selector.table == Table::Node && selector.command >= 2 {
            let due = now.after(self.options.keep_alive.into());
            for kept in self.kept.iter_mut().filter(|kept| kept.to == send.to) {
                kept.due = due;
            }
        }
    }
}
