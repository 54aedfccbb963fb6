//! Commands of the application: which are accepted, which are refused, and what overtakes what.

use motion_core::machine::Token;
use motion_core::time::Millis;
use motion_core::wire::{EncodeError, Purpose};

use super::event::{Event, Outcome, Refusal, StopTarget};
use super::jobs::{Pending, Speed};
use super::line::Line;
use super::{Command, HostMachine, Output, Request, Transmit};
use crate::frame::{Address, MAX_FRAME, Table};
use crate::lint::Context;
use crate::message::HostMessage;

impl HostMachine {
    pub(super) fn command(&mut self, now: Millis, output: &mut Output<'_>, token: Token, command: Command) {
        let outcome = match command {
            Command::Request(request) => return self.submit(now, output, token, request, false),
            Command::Insist(request) => return self.submit(now, output, token, request, true),
            Command::Speed { to, motor, speed } => {
                return self.set_speed(now, output, Speed { token, to, motor, speed });
            }
            Command::KeepAlive { to, on } => return self.set_keep_alive(now, output, token, to, on),
            Command::Nodes(_) if self.emergency.is_some() => Outcome::Refused(Refusal::Stopping),
            Command::Nodes(nodes) => {
                self.options = self.options.with_nodes(nodes);
                Outcome::Applied
            }
            Command::EmergencyStop => {
                self.emergency_stop(now, output);
                Outcome::Sent
            }
            Command::EndEmergency => {
                self.end_emergency(now, output);
                Outcome::Applied
            }
        };
        output.event(Event::Ended { token, outcome });
    }

    fn submit(
        &mut self,
        now: Millis,
        output: &mut Output<'_>,
        token: Token,
        Request { to, message }: Request,
        insist: bool,
    ) {
        let transmit = Transmit { to, message };
        let pending = Pending { token, transmit };
        let is_stop = message.conduct().is_stop();
        let stays_behind = self.options.bridge() && !insist && is_bridged(&message);
        let refused = self.refusal(&transmit).or_else(|| stays_behind.then_some(Refusal::Bridge));
        if is_stop && refused.is_none() {
            self.stop(now, output, pending);
            return;
        }
        let Some(why) = refused.or_else(|| self.queue.try_push(pending).err().map(|_| Refusal::Busy)) else { return };
        output.event(Event::Ended { token, outcome: Outcome::Refused(why) });
        // A stop that would not arrive is carried out in a way that arrives (decision H-20).
        match why {
            Refusal::Bridge if is_stop => self.stop_each(now, output, &transmit),
            Refusal::NotConnected if is_stop => self.tell_not_stopped(output, StopTarget::of(to, &message)),
            _ => {}
        }
    }

    /// Reason to refuse a packet, except that there is no room. Lint is not asked about stops.
    pub(super) fn refusal(&self, Transmit { to, message }: &Transmit) -> Option<Refusal> {
        let is_broadcast = message.selector().table == Table::Broadcast;
        let is_addressed = if is_broadcast { *to == Address::BROADCAST } else { to.is_node() };
        let context = Context { profile: self.options.profile(), ..Context::default() };
        if !is_addressed {
            Some(Refusal::Address)
        } else if self.line == Line::Offline {
            Some(Refusal::NotConnected)
        } else if message.conduct().is_stop() {
            None
        } else if self.emergency.is_some() {
            Some(Refusal::Stopping)
        } else {
            let written: Result<usize, EncodeError> = message.encode_checked(*to, &context, &mut [0; MAX_FRAME]);
            written.err().map(Refusal::Invalid)
        }
    }
}

/// Whether a bridge keeps a message from the bus, where it is meant to arrive. An address is assigned to one node only,
/// which may be the attached one.
fn is_bridged(message: &HostMessage<'_>) -> bool {
    message.selector().table == Table::Broadcast && message.conduct().purpose != Purpose::Resets
}
