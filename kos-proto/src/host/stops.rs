//! Stops of everything, and the motors that are not known to rest although nothing follows them any more.

use core::mem;

use motion_core::machine::Effect;
use motion_core::time::Millis;

use super::event::{Event, StopTarget};
use super::transmit::Transmit;
use super::{Options, Output};
use crate::message::{MotorAddress, MotorSet};

/// Puts a stop before everything else that is to be done, except a password, because a locked device may ignore stops; and
/// after the stops that are there already.
pub(super) fn transmit_stop<'a>(output: &mut Output<'a>, stop: Transmit<'a>) {
    let mut carried = Effect::Transmit(stop);
    let is_password = |effect: &Effect<_, _>| matches!(effect, Effect::Transmit(Transmit::UserPassword(_)));
    let unlocked = output.effects.iter().rposition(is_password).map_or(0, |password| password.saturating_add(1));
    let mut is_front = true;
    for effect in output.effects.iter_mut().skip(unlocked) {
        is_front &= matches!(effect, Effect::Transmit(transmit) if transmit.conduct().is_stop());
        if !is_front {
            mem::swap(effect, &mut carried);
        }
    }
    match carried {
        Effect::Transmit(transmit) => output.transmit(transmit),
        Effect::Event(event) => output.event(event),
    }
}

/// State of the stops of everything.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(super) struct Stops {
    /// Motors that may move because of this client although nothing follows them any more: the connection went down, the
    /// motor was forgotten, or a move was ended. Only a confirmed stop tells that they rest, or a move that includes them.
    astray: MotorSet,
    pending: Option<Pending>,
    /// Motors whose stops are wanted and that nothing follows: the stop was not confirmed on the last connection, or the
    /// device did not report the motor yet.
    deferred: MotorSet,
    /// Whether the device reported its motors on this connection. Before, nobody knows which motors have to rest.
    is_reported: bool,
}

/// Stop of everything that is not confirmed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Pending {
    /// Whether the device said that it obeys. A motor that said before that it rests may have meant something else.
    is_obeyed: bool,
    /// Motors that did not say yet that they rest.
    waiting: MotorSet,
    /// Time at which the motors should have said it.
    until: Option<Millis>,
}

impl Stops {
    /// Whether something of this client is not known to rest.
    pub(super) const fn may_move(&self) -> bool {
        self.pending.is_some() || !self.astray.is_empty()
    }

    /// Whether a stop is not confirmed because the device did not report its motors yet.
    pub(super) const fn is_blind(&self) -> bool {
        self.pending.is_some() && !self.is_reported
    }

    /// Notes that the device reported its motors. Returns whether a stop has to be sent again because of them.
    pub(super) const fn reported(&mut self) -> bool {
        let is_blind = self.is_blind();
        self.is_reported = true;
        is_blind
    }

    /// Motors that nothing follows any more.
    pub(super) const fn astray(&self) -> MotorSet {
        self.astray
    }

    /// Whether a report that the motor rests confirms a stop that is obeyed.
    pub(super) fn confirms(&self, motor: MotorAddress) -> bool {
        self.pending.is_some_and(|pending| pending.is_obeyed && pending.waiting.contains(motor))
    }

    /// Whether the device obeyed a stop, and motors have time left to come to rest.
    pub(super) const fn is_waiting(&self) -> bool {
        matches!(self.pending, Some(Pending { until: Some(_), .. }))
    }

    /// Notes that motors are sent on; whether any of them may still move because of something else. If a stop waits for
    /// them, it is not confirmed any more: no report tells whether the stop or the new motion is meant.
    pub(super) fn sent_on(&mut self, motors: MotorSet) -> bool {
        let may_move = motors.iter().any(|motor| self.astray.contains(motor));
        match &mut self.pending {
            Some(pending) if motors.iter().any(|motor| pending.waiting.contains(motor)) => {
                pending.is_obeyed = false;
                true
            }
            _ => may_move,
        }
    }

    /// Notes a stop of everything, which is over when all these motors rest.
    pub(super) fn begin(&mut self, motors: MotorSet) {
        let waiting = self.pending.map_or(motors, |pending| pending.waiting.with(motors));
        self.pending = Some(Pending { is_obeyed: false, waiting, until: None });
    }

    /// Notes that the device obeys a stop.
    pub(super) fn obeyed(&mut self, now: Millis, options: &Options) {
        if let Some(pending) = &mut self.pending {
            (pending.is_obeyed, pending.until) = (true, Some(now.after(options.stop_timeout())));
        }
    }

    /// Notes motors that may move and are not followed any more.
    pub(super) const fn lose(&mut self, motors: MotorSet) {
        self.astray = self.astray.with(motors);
    }

    /// Motors whose stops are wanted and that nothing follows.
    pub(super) const fn deferred(&self) -> MotorSet {
        self.deferred
    }

    /// Notes motors whose stops are wanted and that nothing follows.
    pub(super) const fn defer(&mut self, motors: MotorSet) {
        self.deferred = self.deferred.with(motors);
    }

    /// Notes that the stops of motors are followed, or not wanted any more.
    pub(super) const fn resume(&mut self, motors: MotorSet) {
        self.deferred = self.deferred.without(motors);
    }

    /// Notes motors that rest: the stop of one is confirmed, or a move has come to where it begins, or ends.
    pub(super) const fn at_rest(&mut self, motors: MotorSet) {
        self.astray = self.astray.without(motors);
    }

    /// Notes that a motor said that it rests.
    pub(super) fn rests(&mut self, motor: MotorAddress) {
        if self.confirms(motor) {
            self.astray.remove(motor);
            self.deferred.remove(motor);
            if let Some(pending) = &mut self.pending {
                pending.waiting.remove(motor);
            }
        }
    }

    /// Notes that a motor is gone. It is waited for all the same if it may move.
    pub(super) fn gone(&mut self, motor: MotorAddress) {
        if let Some(pending) = self.pending.as_mut().filter(|_| !self.astray.contains(motor)) {
            pending.waiting.remove(motor);
        }
    }

    /// Notes that the connection went down. A stop that waits stays: only another one tells whether all rest. Returns
    /// whether the device obeyed and motors had time left to come to rest.
    pub(super) fn lost(&mut self, output: &mut Output<'_>) -> bool {
        self.is_reported = false;
        let Some(pending) = &mut self.pending else { return false };
        let was_waiting = pending.until.is_some();
        if was_waiting {
            output.event(Event::StopNotConfirmed(StopTarget::All));
        }
        (pending.is_obeyed, pending.until) = (false, None);
        was_waiting
    }

    /// Tells that motors do not rest in time after a stop that is obeyed.
    pub(super) fn wake(&mut self, now: Millis, output: &mut Output<'_>) {
        let is_blind = self.is_blind();
        if let Some(pending) = self.pending.as_mut().filter(|pending| pending.until.is_some_and(|until| until <= now)) {
            pending.until = None;
            if is_blind || !pending.waiting.is_empty() {
                output.event(Event::StopNotConfirmed(StopTarget::All));
            }
        }
    }

    /// Ends the stop if it is obeyed and all motors rest; whether it does.
    pub(super) fn settle(&mut self, output: &mut Output<'_>) -> bool {
        let rests = |pending: Pending| pending.is_obeyed && pending.waiting.is_empty();
        let is_over = !self.is_blind() && self.pending.is_some_and(rests);
        if is_over {
            self.pending = None;
            output.event(Event::Stopped(StopTarget::All));
        }
        is_over
    }

    pub(super) fn deadline(&self) -> Option<Millis> {
        self.pending.and_then(|pending| pending.until)
    }
}
