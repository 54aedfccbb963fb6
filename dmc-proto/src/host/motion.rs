//! Knowledge of a host about what may still move because of it.

use super::event::StopTarget;
use super::requests::{Pending, Reply, Request, Role};
use crate::message::AckCode;

/// What may move because of the host, apart from the requests that are under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub(super) struct Motion {
    /// Whether something that may move was sent, and rest is not known since.
    pub(super) may_move: bool,
    /// Whether the device may wait for the signal to start a run or shot, be in one, or keep one that it refused.
    pub(super) is_armed: bool,
    /// Whether the shutter may be open by hand, or because a shot was broken off.
    pub(super) is_shutter_open: bool,
}

impl Motion {
    /// A request is over.
    pub(super) fn ended(&mut self, pending: &Pending, reply: &Reply<'_>) {
        // Of a request that was sent several times, one copy may have been done before another was refused.
        if !(reply.is_plain_refusal() && pending.tries.len() == 1) {
            self.may_be_done(&pending.request);
        }
        // A device may keep a run or shot that it refused (decision D-97).
        self.is_armed |= pending.request.arms();
        // A device that does not know the message has not opened the shutter by it.
        let is_closed = matches!(reply, Reply::Acknowledged | Reply::Refused(AckCode::ERR_UNSUPPORTED));
        if is_closed && pending.request.role == Role::Shutter(false) {
            self.is_shutter_open = false;
        }
    }

    /// The device says that it obeys a stop. Of everything, nothing begins after it; what ran comes to rest.
    pub(super) const fn confirmed(&mut self, target: StopTarget) {
        if target.is_all() {
            self.may_move |= self.is_armed;
            self.is_armed = false;
        }
    }

    /// Nobody knows whether the device does a request, or it does.
    pub(super) const fn may_be_done(&mut self, request: &Request) {
        self.may_move |= request.conduct.may_move();
        self.is_armed |= request.arms();
        self.is_shutter_open |= matches!(request.role, Role::Shutter(true));
    }
}
