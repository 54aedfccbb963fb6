//! Session of a device: the machine with the stream buffer of its line.
//!
//! This is the main loop of firmware, except its motors. Reading the line returns at once if there is no byte.
//!
//! ```
//! use dmc_proto::device::{DeviceMachine, Event, Next, Options, Rig, Session};
//! use dmc_proto::message::{Hi, Motor, Motors, Steps};
//! use dmc_proto::{Millis, Patience};
//!
//! trait Board: Rig {
//!     fn millis(&self) -> u64;
//!     fn read(&mut self, bytes: &mut [u8]) -> usize;
//!     fn write(&mut self, bytes: &[u8]);
//!     fn obey(&mut self, event: &Event<'_>);
//!     /// Whether all motors have come to rest since the last call.
//!     fn came_to_rest(&mut self) -> bool;
//! }
//!
//! fn run(board: &mut impl Board) -> ! {
//!     let machine = DeviceMachine::new(Options::of(Hi { motor_count: 4, ..Options::default().hi() }));
//!     let mut session = Session::new(machine, Patience::default());
//!     let mut bytes = [0; 256];
//!     session.link_up();
//!     loop {
//!         match session.poll(Millis(board.millis()), board, &mut bytes) {
//!             Ok(Next::Event(Event::Store { store, .. })) => {
//!                 // An upload buffer would take the message here.
//!                 let _ = session.stored(store, dmc_proto::message::AckCode::OK);
//!             }
//!             Ok(Next::Event(event)) => board.obey(&event),
//!             Ok(Next::Transmit(frame)) => board.write(frame),
//!             Ok(Next::Wait(_)) | Err(_) => {
//!                 if board.came_to_rest() {
//!                     let _ = session.at_rest();
//!                 }
//!                 let len = board.read(&mut bytes[..64]);
//!                 let taken = session.receive(Millis(board.millis()), &bytes[..len]);
//!                 debug_assert_eq!(taken, len);
//!             }
//!         }
//!     }
//! }
//! ```

use motion_core::session::{Agenda, News};
use motion_core::session_methods;
use motion_core::stream::{Item, Patience};
use motion_core::time::Millis;
use motion_core::wire::EncodeError;

use super::event::{Event, Store};
use super::input::Input;
use super::machine::DeviceMachine;
use super::transmit::{EFFECTS, Effect, Rig, Transmit};
use crate::DeviceReader;
use crate::frame::Frame;
use crate::message::{AckCode, FrameNumber, HostMessage, Motor, Motors, Triggers};

pub use motion_core::session::NotTaken;

/// Next thing to do for a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next<'a> {
    /// Do this, or take note of it.
    Event(Event<'a>),
    /// Write these bytes to the line.
    Transmit(&'a [u8]),
    /// Wait until something happens, at most until this time; without a time, as long as it takes.
    Wait(Option<Millis>),
}

/// Effect without what it borrows from the message that came last.
#[derive(Debug, Clone, Copy)]
enum Held {
    Transmit(Transmit),
    Event(Event<'static>),
    /// Event about the message that came last.
    Apply,
    Store(Store),
    MoveVirtual,
    Prepare,
}

impl Held {
    fn of(effect: Effect<'_>) -> Self {
        match effect {
            Effect::Transmit(transmit) => Self::Transmit(transmit),
            Effect::Event(Event::Apply(_)) => Self::Apply,
            Effect::Event(Event::Store { store, .. }) => Self::Store(store),
            Effect::Event(Event::MoveVirtual(_)) => Self::MoveVirtual,
            Effect::Event(Event::Prepare(_)) => Self::Prepare,
            Effect::Event(event) => Self::Event(event.to_static().unwrap_or(Event::UnexpectedReport)),
        }
    }
}

/// Device with its stream buffer.
pub struct Session {
    machine: DeviceMachine,
    reader: DeviceReader,
    /// Length of the frame that came last.
    last: usize,
    agenda: Agenda<Input<'static>, Held, EFFECTS>,
}

impl Session {
    /// Number of bytes that [`receive`](Self::receive) always takes after [`poll`](Self::poll) said to wait.
    pub const PIECE: usize = DeviceReader::PIECE;

    /// Makes a session without a line, of this machine. A frame has to be whole in time, as `patience` says.
    #[must_use]
    pub const fn new(machine: DeviceMachine, patience: Patience) -> Self {
        Self { machine, reader: DeviceReader::new(patience), last: 0, agenda: Agenda::new() }
    }

    /// Machine of the session, for reading its state.
    #[must_use]
    pub const fn machine(&self) -> &DeviceMachine {
        &self.machine
    }

    /// Number of bytes that arrived and are not dealt with.
    #[must_use]
    pub const fn held(&self) -> usize {
        self.reader.held()
    }

    /// Tells that the line is open, at boot: the device greets.
    pub fn link_up(&mut self) {
        self.reader.reset();
        self.agenda.link_up();
    }

    /// Tells that the line is gone: everything stops.
    pub fn link_down(&mut self) {
        self.agenda.link_down(|held| !matches!(held, Held::Transmit(_)));
    }

    /// Takes bytes that arrived, and returns how many: at least [`PIECE`](Self::PIECE) if there are so many, and
    /// [`poll`](Self::poll) said to wait before. Give the others again after the next wait.
    #[must_use = "bytes that were not taken have to be given again"]
    pub fn receive(&mut self, now: Millis, bytes: &[u8]) -> usize {
        if self.agenda.is_idle() { self.reader.push(now, bytes) } else { 0 }
    }

    /// Next thing to do. What only the rig knows comes from `rig`. Messages are written to the front of `out`, for which
    /// 256 bytes are enough.
    ///
    /// # Errors
    ///
    /// [`EncodeError`] if a message cannot be written. If `out` is too small, call again with as many bytes as the error
    /// needs; the message is not lost.
    pub fn poll<'p, R: Rig + ?Sized>(
        &'p mut self,
        now: Millis,
        rig: &R,
        out: &'p mut [u8],
    ) -> Result<Next<'p>, EncodeError> {
        let held = loop {
            if let Some(held) = self.agenda.pop() {
                break held;
            }
            if !self.advance(now, rig) {
                let wake = [self.agenda.wake(), self.reader.deadline()].into_iter().flatten().min();
                return Ok(Next::Wait(wake));
            }
        };
        let about = |event: fn(HostMessage<'p>) -> Event<'p>, bytes: &'p [u8]| {
            let message = Frame::decode(bytes).ok().and_then(|frame| HostMessage::decode(&frame).ok());
            Next::Event(message.map_or(Event::UnexpectedReport, event))
        };
        Ok(match held {
            Held::Event(event) => Next::Event(event),
            Held::Apply => about(Event::Apply, self.reader.taken(self.last)),
            Held::MoveVirtual => about(Event::MoveVirtual, self.reader.taken(self.last)),
            Held::Prepare => about(Event::Prepare, self.reader.taken(self.last)),
            Held::Store(store) => {
                let frame = Frame::decode(self.reader.taken(self.last)).ok();
                let message = frame.and_then(|frame| HostMessage::decode(&frame).ok());
                Next::Event(message.map_or(Event::UnexpectedReport, |message| Event::Store { store, message }))
            }
            Held::Transmit(transmit) => {
                let written = transmit.message(rig, &mut Default::default()).encode_into(transmit.id, out);
                if let Err(EncodeError::BufferTooSmall { .. }) = written {
                    self.agenda.put_back(held);
                }
                Next::Transmit(out.get(..written?).unwrap_or_default())
            }
        })
    }

    /// Tells the machine the next thing that happened. Returns false if nothing did.
    fn advance<R: Rig + ?Sized>(&mut self, now: Millis, rig: &R) -> bool {
        let is_overdue = self.reader.deadline().is_some_and(|deadline| deadline <= now);
        let output = match self.agenda.news() {
            Some(News::LinkDown) => self.machine.advance(now, Input::LinkDown),
            Some(News::LinkUp) => self.machine.advance(now, Input::LinkUp),
            Some(News::Wish(report)) => self.machine.advance(now, report),
            None => match self.reader.next() {
                Some(Item::Frame(frame)) => {
                    self.last = frame.bytes().len();
                    self.machine.advance(now, Input::received(&frame, |message| rig.verdict(message)))
                }
                Some(Item::Corrupt { header, .. }) => {
                    self.machine.advance(now, Input::Corrupt(header.id(), header.kind()))
                }
                Some(Item::Noise { .. } | Item::Fatal(_)) => return true,
                None if is_overdue => {
                    self.reader.give_up(now);
                    return true;
                }
                None if self.agenda.is_due(now) => self.machine.advance(now, Input::Wake),
                None => return false,
            },
        };
        self.agenda.fill(output, Held::of);
        true
    }
}

session_methods! {
    impl<> Session as Input, see Input;
    stop_all {
        /// The emergency stop was pressed (`true`) or released.
        EmergencyStop emergency_stop(pressed: bool) => (pressed);
    }
    stop_one {
        /// The upload buffer answered with this code to what it was told to store.
        Stored stored(store: Store, code: AckCode) => (store, code);
        /// These motors move now.
        Moving moving(motors: Motors) => (motors);
        /// All motors rest.
        AtRest at_rest();
        /// A run or a jog of all motors has come to this frame of the film.
        AtFrame at_frame(frame: FrameNumber) => (frame);
        /// A run has come to the end of a pass; or a shot is done, and the shutter is closed.
        PassEnd pass_end();
        /// The operator's own switch says "go".
        OperatorGo operator_go();
        /// A motor ran into its upper or lower limit switch.
        Limit limit(motor: Motor, upper: bool) => { motor, upper };
        /// The motion engine gave up, because of this motor or of itself.
        Fault fault(motor: Option<Motor>) => (motor);
        /// The general purpose inputs changed: these are on now.
        Inputs inputs(inputs: Triggers) => (inputs);
        /// The rig aims at another point by itself.
        Aimed aimed();
    }
}
