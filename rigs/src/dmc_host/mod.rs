//! Host of DMC controllers, as Dragonframe is one: it asks, moves, uploads, runs, shoots and stops.
//!
//! The host keeps what the machine of the crate only names: the messages, and the data of a move. Its events carry the
//! answers, so that an application needs nothing else. The host counts a device as configured as soon as it is known. Before a
//! command moves a motor, the host enables the motor, and sets whether it blurs in a shot. Before motors move along a move, it
//! disables all others, and does not enable them until the run is over. It refuses moves, and ends jogs, at limits that it set on this link, because some devices do not look
//! at them.

mod check;
mod limits;
mod table;
mod types;
mod uses;
mod work;

use std::collections::{BTreeMap, VecDeque};
use std::mem;

use dmc_proto::host::{HostMachine, Options, Session, StopTarget};
use dmc_proto::lint::Context;
use dmc_proto::message::RtUploadMoveBegin;
use dmc_proto::upload;
use dmc_proto::{EncodeError, Owned};
use motion_core::time::Millis;

use crate::{Host, LineId, Outgoing, Party};

use self::check::Check;
use self::limits::Limits;
use self::uses::{Uses, Waiting};
pub use check::TOLERANCE;
pub use dmc_proto::Token;
pub use dmc_proto::host::{Failure, Outcome, Progress, Refusal};
pub use table::Table;

pub use types::{Answer, Command, Event, Positions, Shot};

/// Line of the host.
const LINE: LineId = LineId(0);
/// Room for the messages of commands: more than the machine takes at once.
const STORE: usize = 16 * 1024;

/// Host of a DMC controller. It uses its line when it is open, and does not request it.
#[derive(Debug)]
pub struct DmcHost {
    is_open: bool,
    clock: Millis,
    session: Box<Session<STORE>>,
    /// Time until which the session waits.
    until: Option<Millis>,
    /// Messages of the commands that have not ended.
    asked: BTreeMap<Token, Owned<dmc_proto::Host>>,
    /// Move of the last upload.
    table: Table,
    /// Whether the device has that move. Otherwise nobody knows the move of the device.
    is_uploaded: bool,
    /// Positions of the motors that the device told last.
    positions: Option<Positions>,
    /// Uses of the motors on this link.
    uses: Uses,
    limits: Limits,
    /// Commands that wait until their motors have their uses.
    waiting: VecDeque<Waiting>,
    /// Way that has ended, and is not yet known to be complete.
    check: Option<Check>,
    /// Time of the next question after a stop whether motors still move, and number of questions that are left.
    rest: Option<(Millis, u8)>,
    /// Whether the shutter is to be closed after a stop.
    closes: bool,
    out: VecDeque<Outgoing>,
    events: VecDeque<Event>,
}

impl DmcHost {
    /// Host that waits until its line is open.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self {
            is_open: false,
            clock: Millis(0),
            session: Box::new(Session::new(options)),
            until: None,
            asked: BTreeMap::new(),
            table: Table::default(),
            is_uploaded: false,
            positions: None,
            uses: Uses::new(),
            limits: Limits::default(),
            waiting: VecDeque::new(),
            check: None,
            rest: None,
            closes: false,
            out: VecDeque::new(),
            events: VecDeque::new(),
        }
    }

    /// Machine of the host, for reading its state.
    #[must_use]
    pub const fn machine(&self) -> &HostMachine {
        self.session.machine()
    }

    /// Positions of the motors that the device told last.
    #[must_use]
    pub const fn positions(&self) -> Option<&Positions> {
        self.positions.as_ref()
    }

    /// Whether anything may still move because of this host, or may begin to move. A shutter that may be open counts as
    /// well.
    ///
    /// After each stop that is confirmed, the host asks for some seconds whether motors still move, until the answer is
    /// no.
    #[must_use]
    pub fn may_move(&self) -> bool {
        self.session.may_move() || self.machine().may_have_shutter_open()
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
        upload::begin(table, &self.machine().device().map(Context::of).unwrap_or_default())
    }

    /// Number of bytes of input and output that the host holds.
    #[must_use]
    pub fn held(&self) -> usize {
        self.session.held() + crate::waiting(&self.out)
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
            self.session.link_up();
            self.work();
        }
    }

    fn close(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        if line == LINE && mem::take(&mut self.is_open) {
            self.out.clear();
            self.session.link_down();
            self.work();
        }
    }

    fn receive(&mut self, now: Millis, line: LineId, bytes: &[u8]) {
        if line == LINE && self.is_open {
            // Bytes can be read late: they come before all that is overdue.
            self.clock = self.clock.max(now);
            self.take(bytes);
        }
        self.advance(now);
    }

    fn advance(&mut self, now: Millis) {
        while let Some(next) = self.wake().filter(|next| *next <= now) {
            self.clock = self.clock.max(next);
            self.due();
        }
        self.clock = self.clock.max(now);
    }

    fn wake(&self) -> Option<Millis> {
        [self.until, self.rest.map(|(due, _)| due)].into_iter().flatten().min()
    }

    fn poll(&mut self) -> Option<Outgoing> {
        self.out.pop_front()
    }
}

impl Host for DmcHost {
    type Command = Command;
    type Event = Event;

    fn command(&mut self, now: Millis, command: Command) {
        self.advance(now);
        self.obey(command);
    }

    fn next_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }
}
