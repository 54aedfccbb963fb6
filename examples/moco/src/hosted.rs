//! Host of a rig as a session that a driver moves.

use std::collections::VecDeque;
use std::mem;

use motion_core::machine::Token;
use motion_core::session::{HostSession, LineRequest, NotTaken, Session, Turn, TurnOf};
use motion_core::time::Millis;
use motion_core::wire::EncodeError;
use motion_rigs::{LineId, Outgoing};
use tracing::trace;

use crate::drive::Driven;
use crate::drive::foreign::ENOUGH;

const LINE: LineId = LineId(0);

/// Host of a rig as a session. Each of its events says only that `event` is there, or that the line came or went.
pub(crate) struct Hosted<H: Driven> {
    pub(crate) host: H,
    /// Commands for the next turn.
    pub(crate) commands: VecDeque<H::Command>,
    /// Next event of the host. There is no other one before it is taken.
    pub(crate) event: Option<H::Event>,
    /// First bytes that the rig sent, at most [`ENOUGH`].
    pub(crate) heard: Vec<u8>,
    /// Number of bytes that were given to the driver for the rig.
    pub(crate) written: u64,
    /// Whether the line went down, and whether it came up after that.
    link: (bool, bool),
    stops: bool,
    /// Request of the host for which there was no room.
    outgoing: Option<Outgoing>,
}

impl<H: Driven> Hosted<H> {
    pub(crate) fn new(host: H) -> Self {
        let (commands, heard, link) = (VecDeque::new(), Vec::new(), (false, false));
        Self { host, commands, event: None, heard, written: 0, link, stops: false, outgoing: None }
    }
}

impl<H: Driven> Session for Hosted<H> {
    type Source<'s> = ();
    type Line = ();
    type Destination = ();
    type Event<'e>
        = ()
    where
        Self: 'e;
    type Held = Option<LineRequest>;

    const PIECE: usize = 4_096;
    const ASKS: bool = H::ASKS;

    fn reaches((): (), (): ()) -> bool {
        true
    }

    fn request(held: &Option<LineRequest>, (): ()) -> Option<LineRequest> {
        *held
    }

    fn link_up(&mut self, (): ()) -> Result<(), NotTaken> {
        self.link.1 = true;
        Ok(())
    }

    fn link_down(&mut self, (): ()) -> Result<(), NotTaken> {
        (self.link, self.outgoing) = ((true, false), None);
        Ok(())
    }

    fn receive(&mut self, now: Millis, (): (), bytes: &[u8]) -> usize {
        if !bytes.is_empty() {
            trace!(len = bytes.len(), "read");
            self.heard.extend(bytes.iter().take(ENOUGH.saturating_sub(self.heard.len())));
            self.host.receive(now, LINE, bytes);
        }
        bytes.len()
    }

    fn turn(&mut self, now: Millis, (): &(), out: &mut [u8]) -> Result<TurnOf<Self>, EncodeError> {
        if mem::take(&mut self.link.0) {
            self.host.close(now, LINE);
            return Ok(Turn::Event(None));
        }
        if mem::take(&mut self.link.1) {
            self.host.open(now, LINE);
            return Ok(Turn::Event(None));
        }
        if mem::take(&mut self.stops) {
            self.host.stop_all(now);
        }
        for command in self.commands.drain(..) {
            self.host.command(now, command);
        }
        self.host.advance(now);
        while let Some(outgoing) = self.outgoing.take().or_else(|| self.host.poll()) {
            match outgoing {
                Outgoing::Bytes(LINE, ref bytes) => {
                    let (needed, have) = (bytes.len(), out.len());
                    let Some(front) = out.get_mut(..needed) else {
                        self.outgoing = Some(outgoing);
                        return Err(EncodeError::BufferTooSmall { needed, have });
                    };
                    front.copy_from_slice(bytes);
                    self.written += u64::try_from(needed).unwrap_or(0);
                    trace!(len = needed, "written");
                    return Ok(Turn::Transmit((), needed));
                }
                Outgoing::Open(LINE) => return Ok(Turn::Event(Some(LineRequest::Open))),
                Outgoing::HangUp(LINE) => {
                    self.host.close(now, LINE);
                    return Ok(Turn::Event(Some(LineRequest::Close)));
                }
                // A host has one line and no datagrams.
                _ => {}
            }
        }
        self.event = self.event.take().or_else(|| self.host.next_event());
        Ok(if self.event.is_some() { Turn::Event(None) } else { Turn::Wait(self.host.wake()) })
    }

    fn event(&self, _: Option<LineRequest>) {}
}

impl<H: Driven> HostSession for Hosted<H> {
    fn may_move(&self) -> bool {
        self.host.may_move()
    }

    /// Stops everything. Commands that wait are dropped, so that nothing moves after the stop.
    fn stop(&mut self, _: Token) -> Result<(), NotTaken> {
        self.stops = true;
        self.commands.clear();
        // What the host told before cannot confirm this stop.
        self.event = None;
        while self.host.next_event().is_some() {}
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use motion_rigs::dmc_host::{Command, DmcHost};

    use super::*;

    #[test]
    fn a_stop_drops_the_commands_that_wait() {
        let mut hosted = Hosted::new(DmcHost::default());
        hosted.commands.push_back(Command::Go);
        assert_eq!(hosted.stop(Token(1)), Ok(()));
        assert!(hosted.commands.is_empty() && hosted.stops);
    }
}
