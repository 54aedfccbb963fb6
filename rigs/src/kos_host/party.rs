//! Line, clock and commands of a client.

use kos_proto::host::{self, Endpoint, Input, Token};
use kos_proto::message::Ipv4;
use kos_proto::{Frame, Frames, Header, Item};
use motion_core::time::Millis;
use tracing::{debug, warn};

use super::{Command, Content, Event, KosHost, LINE};
use crate::{Host, LineId, Outgoing, Party};

impl Party for KosHost {
    fn open(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        if line == LINE {
            self.is_open = true;
            self.frames = Some(Box::new(Frames::new()));
            self.step(now, Input::LinkUp, &Content::default());
        }
    }

    fn close(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        if line == LINE {
            self.is_open = false;
            self.step(now, Input::LinkDown, &Content::default());
        }
    }

    fn receive(&mut self, now: Millis, line: LineId, bytes: &[u8]) {
        self.advance(now);
        let mut rest = if line == LINE { bytes } else { &[] };
        // The frames are lent by the buffer, which a step must not touch.
        let Some(mut frames) = self.frames.take() else { return };
        while self.is_open && !rest.is_empty() {
            let taken = frames.push(rest);
            rest = rest.get(taken..).unwrap_or_default();
            while let Some(item) = frames.next() {
                self.item(now, &item);
                if !self.is_open {
                    break;
                }
            }
            if taken == 0 {
                break;
            }
        }
        self.frames = Some(frames);
    }

    fn advance(&mut self, now: Millis) {
        while let Some(due) = self.wake.filter(|due| *due <= now) {
            self.step(due, Input::Wake, &Content::default());
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
        let mut content = Content::default();
        let command = match &command {
            // The address of the device is known to the owner of the line.
            Command::Connect => host::Command::Connect(Endpoint::Tcp(Ipv4::default())),
            Command::Unlock(password) => {
                self.password.clone_from(password);
                host::Command::Unlock
            }
            Command::ChangePassword(password) => {
                content.new_password = password;
                host::Command::ChangePassword
            }
            Command::Load { stored, delay_return } => {
                content.stored = Some(stored);
                host::Command::Load { summary: *stored.summary(), delay_return: *delay_return }
            }
            Command::PlayDirect { stored } => {
                content.stored = Some(stored);
                host::Command::PlayDirect { summary: *stored.summary() }
            }
            Command::Machine(command) => *command,
        };
        self.step(now, Input::Command(token, command), &content);
    }

    fn next_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }
}

impl KosHost {
    fn item(&mut self, now: Millis, item: &Item<'_, Frame<'_>, Header>) {
        let input = match item {
            Item::Frame(frame) => Input::received(frame),
            Item::Fatal(why) => {
                warn!("the bytes of the device are no stream of messages: {why}");
                Input::Fatal
            }
            Item::Noise { bytes, why } => return warn!("{} bytes are left out: {why}", bytes.len()),
            Item::Corrupt { why, .. } => return warn!("{why}"),
        };
        if let Input::Received(message) = input {
            debug!("< {message}");
        }
        self.step(now, input, &Content::default());
    }
}
