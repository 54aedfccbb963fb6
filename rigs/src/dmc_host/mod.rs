//! Host of DMC controllers, as Dragonframe is one: it asks, moves, uploads, runs, shoots and stops.
//!
//! The host keeps what the machine of the crate only names: the messages, and the data of a move. Its events carry the
//! answers, so that an application needs nothing else. The host counts a device as configured as soon as it is known. Before a
//! command moves a motor, the host enables the motor, and sets whether it blurs in a shot. Before motors move along a move, it
//! disables all others, and does not enable them until the run is over. It refuses moves, and ends jogs, at limits that it set on this link, because some devices do not look
//! at them.

mod check;
mod core;
mod limits;
mod table;
mod types;
mod uses;

use std::mem;

use dmc_proto::EncodeError;
use dmc_proto::host::{Options, State, StopTarget};
use dmc_proto::message::{Hi, RtUploadMoveBegin};
use motion_core::time::Millis;

use crate::{Host, LineId, Outgoing, Party};

pub use check::TOLERANCE;
pub use dmc_proto::Token;
pub use dmc_proto::host::{Failure, Outcome, Progress, Refusal};
pub use table::Table;
pub use types::{Answer, Command, Event, Positions, Shot};

use self::core::Core;

/// Line of the host.
const LINE: LineId = LineId(0);

/// Host of a DMC controller. It uses its line when it is open, and does not request it.
#[derive(Debug)]
pub struct DmcHost {
    is_open: bool,
    core: Core,
}

impl DmcHost {
    /// Host that waits until its line is open.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self { is_open: false, core: Core::new(options) }
    }

    /// Greeting of the device.
    #[must_use]
    pub const fn device(&self) -> Option<Hi<'static>> {
        self.core.session.machine().device()
    }

    /// State of the connection.
    #[must_use]
    pub const fn state(&self) -> State {
        self.core.session.machine().state()
    }

    /// Progress of the sequence, if one runs.
    #[must_use]
    pub fn progress(&self) -> Option<Progress> {
        self.core.session.machine().progress()
    }

    /// Whether the device has a move that can be run; `None` if that is not known.
    #[must_use]
    pub const fn is_loaded(&self) -> Option<bool> {
        self.core.session.machine().is_loaded()
    }

    /// Positions of the motors that the device told last.
    #[must_use]
    pub const fn positions(&self) -> Option<&Positions> {
        self.core.positions.as_ref()
    }

    /// Whether anything may still move because of this host, or may begin to move. A shutter that may be open counts as
    /// well.
    ///
    /// After each stop that is confirmed, the host asks for some seconds whether motors still move, until the answer is
    /// no.
    #[must_use]
    pub fn may_move(&self) -> bool {
        self.core.session.may_move() || self.core.session.machine().may_have_shutter_open()
    }

    /// Stops everything, and closes the shutter if it may be open.
    pub fn stop_all(&mut self, now: Millis) {
        self.command(now, Command::Stop(StopTarget::All));
    }

    /// Checks whether this device can take a move, before anything is sent. Returns the message that begins the upload.
    ///
    /// # Errors
    ///
    /// [`EncodeError`] says what does not fit.
    pub fn fits(&self, table: &Table) -> Result<RtUploadMoveBegin<'static>, EncodeError> {
        self.core.fits(table)
    }

    /// Number of bytes of input and output that the host holds.
    #[must_use]
    pub fn held(&self) -> usize {
        self.core.session.held() + crate::waiting(&self.core.out)
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
            self.core.session.link_up();
            self.core.work();
        }
    }

    fn close(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        if line == LINE && mem::take(&mut self.is_open) {
            self.core.out.clear();
            self.core.session.link_down();
            self.core.work();
        }
    }

    fn receive(&mut self, now: Millis, line: LineId, bytes: &[u8]) {
        if line == LINE && self.is_open {
            // Bytes can be read late: they come before all that is overdue.
            self.core.clock = self.core.clock.max(now);
            self.core.receive(bytes);
        }
        self.advance(now);
    }

    fn advance(&mut self, now: Millis) {
        while let Some(next) = self.wake().filter(|next| *next <= now) {
            self.core.clock = self.core.clock.max(next);
            self.core.due();
        }
        self.core.clock = self.core.clock.max(now);
    }

    fn wake(&self) -> Option<Millis> {
        self.core.wake()
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
