//! What the application wants: what is taken, what is refused, and what overtakes what.

use motion_core::time::Millis;

use super::line::Line;
use super::stream::Speed;
use super::{Command, Event, Failure, HostMachine, NotTaken, Outcome, Output, Request, Send};
use crate::frame::{Address, MAX_FRAME, Table};
use crate::lint::Context;
use crate::message::HostMessage;

impl HostMachine {
    pub(super) fn command(&mut self, now: Millis, output: &mut Output, command: Command) {
        match command {
            Command::Request(request) => self.submit(output, request, false),
            Command::Insist(request) => self.submit(output, request, true),
            Command::Speed { to, motor, speed } => self.set_speed(output, Speed { to, motor, speed }),
            Command::KeepAlive { to, on } => self.set_keep_alive(now, output, to, on),
            Command::Nodes(nodes) if self.emergency.is_none() => self.options.nodes = nodes,
            Command::Nodes(_) => output.event(Event::NotTaken(NotTaken::Emergency)),
            Command::EmergencyStop => self.emergency_stop(output),
            Command::EndEmergency => self.end_emergency(now, output),
        }
    }

    fn submit(&mut self, output: &mut Output, request: Request, insist: bool) {
        let Request { token, to, message } = request;
        let is_stop = message.is_stop();
        let stays_behind = self.options.bridge && !insist && is_bridged(&message);
        let bridge = stays_behind.then_some(NotTaken::Bridge);
        let why = self.refusal(&Send { to, message }).or(bridge);
        if is_stop && why.is_none() {
            self.stop(output, request);
            return;
        }
        let Some(why) = why.or_else(|| self.queue.try_push(request).err().map(|_| NotTaken::Full)) else { return };
        output.event(Event::Ended { token, outcome: Outcome::Failed(Failure::NotTaken(why)) });
        // A stop that would not arrive is carried out in the way that does (decision H-20).
        match why {
            NotTaken::Bridge if is_stop => self.stop_each(output, &message),
            NotTaken::Link if is_stop => output.event(Event::StopNotConfirmed { node: Some(to) }),
            _ => {}
        }
    }

    /// Why a packet is not taken, wherever it comes from; room apart. No stop is measured by lint.
    pub(super) fn refusal(&self, Send { to, message }: &Send) -> Option<NotTaken> {
        let is_broadcast = message.selector().table == Table::Broadcast;
        let is_addressed = if is_broadcast { *to == Address::BROADCAST } else { to.is_node() };
        let context = Context { profile: self.options.profile, ..Context::default() };
        if !is_addressed {
            Some(NotTaken::Address)
        } else if message.encoded_len() > MAX_FRAME {
            Some(NotTaken::TooLong)
        } else if self.line == Line::Offline {
            Some(NotTaken::Link)
        } else if message.is_stop() {
            None
        } else if self.emergency.is_some() {
            Some(NotTaken::Emergency)
        } else {
            let unwritten = || message.encode_into(*to, &mut [0; MAX_FRAME]).is_err().then_some(NotTaken::Encode);
            message.lint(&context).first_error().map(NotTaken::Lint).or_else(unwritten)
        }
    }
}

/// Whether a bridge keeps it from the bus, where it is meant to arrive: an address is assigned to one node only, and the
/// attached one may be meant.
fn is_bridged(message: &HostMessage<'_>) -> bool {
    message.selector().table == Table::Broadcast && !message.changes_address()
}
