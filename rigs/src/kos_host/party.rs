//! Line, clock and commands of a client.

use kos_proto::host::{self, Endpoint, Token};
use kos_proto::message::Ipv4;
use motion_core::time::Millis;
use tracing::warn;

use super::{Command, Event, KosHost, LINE, Tap, device_text};
use crate::{Host, LineId, Outgoing, Party};

impl Party for KosHost {
    fn open(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        if line == LINE {
            self.line = Some(Tap::new());
            self.session.link_up();
            self.work(now);
        }
    }

    fn close(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        if line == LINE {
            self.line = None;
            self.session.link_down();
            self.work(now);
        }
    }

    fn receive(&mut self, now: Millis, line: LineId, bytes: &[u8]) {
        self.advance(now);
        let mut rest = if line == LINE { bytes } else { &[] };
        if let Some(tap) = &mut self.line {
            tap.hear("<", rest, device_text);
        }
        while self.line.is_some() && !rest.is_empty() {
            let taken = self.session.receive(now, rest);
            rest = rest.get(taken..).unwrap_or_default();
            self.work(now);
            if taken == 0 {
                break;
            }
        }
    }

    fn advance(&mut self, now: Millis) {
        while let Some(due) = self.wake.filter(|due| *due <= now) {
            self.work(due);
        }
    }

    fn wake(&self) -> Option<Millis> {
        self.wake
    }

    fn poll(&mut self) -> Option<Outgoing> {
        self.outgoing.pop_front()
    }
}

impl Host for KosHost {
    type Command = (Token, Command);
    type Event = Event;

    fn command(&mut self, now: Millis, (token, command): (Token, Command)) {
        self.advance(now);
        let command = match command {
            // The address of the device is known to the owner of the line.
            Command::Connect => host::Command::Connect(Endpoint::Tcp(Ipv4::default())),
            Command::Unlock(password) => {
                self.password = password;
                host::Command::Unlock
            }
            Command::ChangePassword(password) => {
                self.new_password = Some((token, password));
                host::Command::ChangePassword
            }
            Command::Load { stored, delay_return } => {
                let summary = *self.stored.insert(stored).summary();
                host::Command::Load { summary, delay_return }
            }
            Command::PlayDirect { stored } => {
                host::Command::PlayDirect { summary: *self.stored.insert(stored).summary() }
            }
            Command::Machine(command) => command,
        };
        if let Err(why) = self.session.command(token, command) {
            warn!("{command:?}: {why}");
        }
        self.work(now);
        (self.stored, self.new_password) = (None, None);
    }

    fn next_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }
}
