//! What Dragonframe does with a DMC controller: asks, moves, uploads, runs, shoots, stops.
//!
//! It keeps what the crate's machine only names: the messages, and the data of a move. What it tells carries the answers,
//! so that an application needs to look at nothing else. A device is taken for configured as soon as it is known.

mod check;
mod core;
mod safety;
mod table;
mod types;

use std::mem;

use dmc_proto::EncodeError;
use dmc_proto::host::{Input, Options, State};
use dmc_proto::lint::Context;
use dmc_proto::message::{CameraFlags, GioCam, Hi, HostMessage, RtUploadMoveBegin};
use dmc_proto::upload;
use motion_core::time::Millis;

use crate::dmc_reader::Reader;
use crate::{Host, LineId, Outgoing, Party};

pub use dmc_proto::host::{Failure, Progress, Stop, Token};
pub use table::Table;
pub use types::{Answer, Command, Event, Positions, Shot};

use self::core::{Core, SHUTTER};

/// The only line.
const LINE: LineId = LineId(0);

/// A host of DMC controllers. It takes its line as it is, and does not ask for it.
#[derive(Debug)]
pub struct DmcHost {
    is_open: bool,
    reader: Reader,
    core: Core,
}

impl DmcHost {
    /// A host that waits for its line to be open.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self { is_open: false, reader: Reader::new(), core: Core::new(options) }
    }

    /// What the device said of itself.
    #[must_use]
    pub const fn device(&self) -> Option<Hi<'static>> {
        self.core.machine.device()
    }

    /// How far the connection is.
    #[must_use]
    pub const fn state(&self) -> State {
        self.core.machine.state()
    }

    /// How far the sequence is, if one runs.
    #[must_use]
    pub fn progress(&self) -> Option<Progress> {
        self.core.machine.progress()
    }

    /// Whether the device has a move that can be run; `None` if nobody knows.
    #[must_use]
    pub const fn is_loaded(&self) -> Option<bool> {
        self.core.machine.is_loaded()
    }

    /// Where the motors were when they were told last.
    #[must_use]
    pub const fn positions(&self) -> Option<&Positions> {
        self.core.positions.as_ref()
    }

    /// Whether something that was set in motion here is not known to rest, or may still begin. A shutter that is open
    /// counts as well.
    #[must_use]
    pub fn may_move(&self) -> bool {
        let machine = &self.core.machine;
        self.core.safety.may_move() || machine.is_armed() || machine.unconfirmed_stops().next().is_some()
    }

    /// Stops everything, and closes a shutter that was opened by hand.
    pub fn stop_all(&mut self, now: Millis) {
        let has_shutter_open = self.core.safety.has_shutter_open();
        self.command(now, Command::Stop(Stop::All));
        if has_shutter_open {
            let off = GioCam { flags: CameraFlags::empty(), tail: &[] };
            self.command(now, Command::Ask(SHUTTER, HostMessage::GioCam(off)));
        }
    }

    /// What speaks against the upload of a move to this device, before anything is sent.
    ///
    /// # Errors
    ///
    /// [`EncodeError`] says what does not fit.
    pub fn fits(&self, table: &Table) -> Result<RtUploadMoveBegin<'static>, EncodeError> {
        upload::begin(table, &self.device().map(Context::of).unwrap_or_default())
    }

    /// Bytes of input and output that it holds.
    #[must_use]
    pub fn held(&self) -> usize {
        self.reader.held() + crate::waiting(&self.core.out)
    }
}

impl Default for DmcHost {
    fn default() -> Self {
        Self::new(Options::default())
    }
}

impl Party for DmcHost {
    fn open(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        if line == LINE {
            self.is_open = true;
            self.reader.reset();
            self.core.step(Input::LinkUp);
        }
    }

    fn close(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        if line == LINE && mem::take(&mut self.is_open) {
            self.reader.reset();
            self.core.out.clear();
            self.core.step(Input::LinkDown);
        }
    }

    fn receive(&mut self, now: Millis, line: LineId, bytes: &[u8]) {
        self.advance(now);
        if line != LINE || !self.is_open {
            return;
        }
        self.reader.receive(now, bytes, |item| self.core.received(item));
    }

    fn advance(&mut self, now: Millis) {
        while let Some(next) = self.wake().filter(|next| *next <= now) {
            self.core.clock = self.core.clock.max(next);
            self.reader.give_up(next, |item| self.core.received(item));
            if self.core.wake.is_some_and(|wake| wake <= next) {
                self.core.step(Input::Wake);
            }
        }
        self.core.clock = self.core.clock.max(now);
    }

    fn wake(&self) -> Option<Millis> {
        [self.core.wake, self.reader.wake()].into_iter().flatten().min()
    }

    fn poll(&mut self) -> Option<Outgoing> {
        self.core.out.pop_front()
    }
}

impl Host for DmcHost {
    type Command = Command;
    type Event = Event;

    fn command(&mut self, now: Millis, command: Command) {
        self.advance(now);
        self.core.command(command);
    }

    fn next_event(&mut self) -> Option<Event> {
        self.core.events.pop_front()
    }
}
