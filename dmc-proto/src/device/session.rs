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
//!     let mut session: Session = Session::new(machine, Patience::default());
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

use motion_core::session::{self, Agenda, News, Session as _, Turn, TurnOf};
use motion_core::stream::{Framing as _, Item, Patience};
use motion_core::time::Millis;
use motion_core::wire::EncodeError;
use motion_core::{session_line, session_link, session_methods};

use super::event::{Event, Store};
use super::input::{self, Input, Report};
use super::machine::DeviceMachine;
use super::transmit::{EFFECTS, Effect, Rig, Transmit};
use crate::frame::{Dmc, MAX_FRAME, SMALL_FRAME};
use crate::message::{AckCode, FrameNumber, Motor, Motors, Triggers};

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
pub enum Held {
    Transmit(Transmit),
    Event(Event<'static>),
    /// Event about the message that came last.
    Apply,
    Store(Store),
    MoveVirtual,
    Prepare,
}

impl Held {
    const fn is_event(&self) -> bool {
        !matches!(self, Self::Transmit(_))
    }

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

/// Stream of the frames of a host.
type Link<const N: usize, const CAP: usize> = session::Link<Dmc<CAP>, N>;

/// Device with a stream buffer of `N` bytes, for frames of up to `CAP` bytes. `N` is at least twice `CAP`. The checksums take
/// twice the memory of the buffer.
///
/// By default it takes pieces of 512 bytes. For small memory there is [`SmallSession`].
pub struct Session<const N: usize = { 2 * MAX_FRAME + 511 }, const CAP: usize = MAX_FRAME> {
    machine: DeviceMachine,
    link: Link<N, CAP>,
    agenda: Agenda<Report, Held, EFFECTS>,
}

/// Device for small memory: it takes frames of up to [`SMALL_FRAME`] bytes, which every device has to take, in pieces of 64
/// bytes.
pub type SmallSession = Session<{ 2 * SMALL_FRAME + 63 }, SMALL_FRAME>;

impl<const N: usize, const CAP: usize> Session<N, CAP> {
    /// Makes a session without a line, of this machine. A frame has to be whole in time, as `patience` says.
    #[must_use]
    pub const fn new(machine: DeviceMachine, patience: Patience) -> Self {
        Self { machine, link: Link::new(patience), agenda: Agenda::new() }
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
        Ok(match self.take_turn(now, rig, out)? {
            Turn::Transmit((), len) => Next::Transmit(out.get(..len).unwrap_or_default()),
            Turn::Event(held) => Next::Event(self.event(held)),
            Turn::Wait(until) => Next::Wait(until),
        })
    }

    // In firmware the parts of a turn are functions of their own. So their code is shorter, and it has to be stored.
    #[cfg_attr(target_os = "none", inline(never))]
    fn take_turn<R: Rig + ?Sized>(
        &mut self,
        now: Millis,
        rig: &R,
        out: &mut [u8],
    ) -> Result<TurnOf<Self>, EncodeError> {
        let held = loop {
            if let Some(held) = self.agenda.pop() {
                break held;
            }
            if !self.advance(now, rig) {
                return Ok(Turn::Wait(self.until()));
            }
        };
        let Held::Transmit(transmit) = held else { return Ok(Turn::Event(held)) };
        let written = transmit.encode_into(rig, out);
        if let Err(EncodeError::BufferTooSmall { .. }) = written {
            self.agenda.put_back(held);
        }
        written.map(|len| Turn::Transmit((), len))
    }

    /// Whether nothing waits for a poll, so that the state of the machine tells everything.
    pub(super) fn is_settled(&self) -> bool {
        self.agenda.is_settled()
    }

    /// Tells the machine the next thing that happened. Returns false if nothing did.
    #[cfg_attr(target_os = "none", inline(never))]
    fn advance<R: Rig + ?Sized>(&mut self, now: Millis, rig: &R) -> bool {
        let output = match self.agenda.news() {
            Some(News::LinkDown) => self.machine.advance(now, Input::LinkDown),
            Some(News::LinkUp) => self.machine.advance(now, Input::LinkUp),
            Some(News::Wish(report)) => self.machine.advance(now, report.into()),
            None => match self.link.next() {
                Some(Item::Frame(frame)) => {
                    self.machine.advance(now, Input::received(&frame, |message| rig.verdict(message)))
                }
                Some(Item::Corrupt { header, .. }) => {
                    self.machine.advance(now, Input::Corrupt(header.id(), header.kind()))
                }
                Some(Item::Noise { .. } | Item::Fatal(_)) => return true,
                None => {
                    if self.link.give_up(now) {
                        return true;
                    }
                    if !self.agenda.is_due(now) {
                        return false;
                    }
                    self.machine.advance(now, Input::Wake)
                }
            },
        };
        self.agenda.fill(output, Held::of);
        true
    }
}

impl<const N: usize, const CAP: usize> session::Session for Session<N, CAP> {
    type Source<'s> = dyn Rig + Sync + 's;

    session_line! { to all }

    fn turn(&mut self, now: Millis, rig: &Self::Source<'_>, out: &mut [u8]) -> Result<TurnOf<Self>, EncodeError> {
        self.take_turn(now, rig, out)
    }

    fn event(&self, held: Held) -> Event<'_> {
        if let Held::Event(event) = held {
            return event;
        }
        // The stream has verified the frame.
        let message = Dmc::<CAP>::frame(self.link.last()).and_then(|frame| input::message(&frame).ok());
        match (held, message) {
            (Held::Apply, Some(message)) => Event::Apply(message),
            (Held::MoveVirtual, Some(message)) => Event::MoveVirtual(message),
            (Held::Prepare, Some(message)) => Event::Prepare(message),
            (Held::Store(store), Some(message)) => Event::Store { store, message },
            _ => Event::UnexpectedReport,
        }
    }
}

session_link! { device impl<const N: usize, const CAP: usize> Session<N, CAP>: DeviceMachine, Link<N, CAP> }

session_methods! {
    impl<const N: usize, const CAP: usize> Session<N, CAP> as Report, see Report;
    stop_all {
        /// Stops everything, as a person at the device wants it. This presses the emergency stop: the device stays locked until
        /// [`emergency_stop`](Self::emergency_stop) tells that it is released.
        EmergencyStop stop() => (true);
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
