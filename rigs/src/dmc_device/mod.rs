//! DMC controller with its motors and its camera.
//!
//! The machine of the crate follows the protocol; this module moves the motors. Between two frames of an uploaded move a
//! motor moves from one position to the next at a constant speed. So it stays between these two positions, and a check of
//! the limits at each frame holds between the frames too.
//!
//! At the start of a run a motor accelerates evenly, from rest to its speed, in the time of the pre-roll. So it starts at a
//! distance before its first position. It comes to rest after its last position in the same way. Shots do the same. After a
//! run or a shot, the motors return to the frame. In a loop, the motors come to rest after each pass, and go to the start
//! of the next pass.

mod camera;
mod carriages;
mod core;
mod course;
mod devices;
mod job;
mod obey;
mod reader;
mod setup;
mod store;
mod verdict;

use std::collections::VecDeque;
use std::mem;

use dmc_proto::device::{
    Contents, DeviceMachine, Event, Input, Next, NotTaken, Quirks, Scratch, Session, State, Transmit,
};
use dmc_proto::message::{AckCode, DeviceMessage, FrameNumber, Motor as Number, Motors, Steps, Triggers};
use dmc_proto::{Frame, Header};
use motion_core::time::Millis;
use tracing::{debug, info, warn};

use crate::motor::{Happening, Motor};
use crate::{LineId, Outgoing, Party, Rig, TICK, waiting};

pub use camera::Photo;
pub use setup::{Facts, Setup, Tuning};

use self::core::Core;
use self::reader::{Read, Reader};

/// First type of the requests that a device refuses while it is locked.
const FIRST_LOCKED: u16 = 0x0031;
/// Line of the device.
const LINE: LineId = LineId(0);

/// DMC controller with its motors and its camera. It has one line.
#[derive(Debug)]
pub struct DmcDevice {
    is_open: bool,
    /// Whether the device greets at the first byte that arrives.
    owes_greeting: bool,
    /// Reader of a device that does not read as its session does.
    reader: Option<Reader>,
    session: Box<Session>,
    /// Time until which the session waits.
    until: Option<Millis>,
    core: Core,
    out: VecDeque<Outgoing>,
}

impl DmcDevice {
    /// Device at rest, with all its motors at 0.
    #[must_use]
    pub fn new(setup: Setup) -> Self {
        let (reader, core) = (Reader::of(&setup), Core::new(setup));
        let (session, out) = (session(&core.setup), VecDeque::new());
        Self { is_open: false, owes_greeting: false, reader, session, until: None, core, out }
    }

    /// Name of the device in its greeting.
    #[must_use]
    pub fn name(&self) -> String {
        self.core.setup.options.hi().name.to_string()
    }

    /// State of the device.
    #[must_use]
    pub const fn state(&self) -> State {
        self.session.machine().state()
    }

    /// Frame of the uploaded move that all motors stand on.
    #[must_use]
    pub const fn on_frame(&self) -> Option<FrameNumber> {
        self.session.machine().on_frame()
    }

    /// Whether there is a move that can be run.
    #[must_use]
    pub fn is_loaded(&self) -> bool {
        self.session.machine().is_loaded()
    }

    /// Position of a motor at a frame of the uploaded move.
    #[must_use]
    pub fn uploaded(&self, motor: Number, frame: FrameNumber) -> Option<Steps> {
        self.core.store.position(motor, frame).map(Steps)
    }

    /// Photos that were taken, the oldest first, at most ten thousand.
    pub fn photos(&self) -> impl Iterator<Item = &Photo> {
        self.core.camera.photos()
    }

    /// Number of photos that were taken.
    #[must_use]
    pub const fn photo_count(&self) -> u64 {
        self.core.camera.count()
    }

    /// Settings of a motor.
    #[must_use]
    pub fn tuning(&self, motor: Number) -> Option<Tuning> {
        self.core.tuning.get(index(motor)?).copied()
    }

    /// Outputs that are on.
    #[must_use]
    pub const fn outputs(&self) -> Triggers {
        self.core.outputs
    }

    /// Level of each light.
    #[must_use]
    pub fn levels(&self) -> &[u8] {
        &self.core.levels
    }

    /// Number of requests that arrived undamaged.
    #[must_use]
    pub const fn received(&self) -> u64 {
        self.core.received.get()
    }

    /// Whether anything may move because of what the device was told.
    #[must_use]
    pub const fn may_move(&self) -> bool {
        self.session.may_move()
    }

    /// Number of bytes of input and output that the device holds.
    #[must_use]
    pub fn held(&self) -> usize {
        self.received_bytes() + waiting(&self.out)
    }

    /// Number of bytes of an incomplete frame.
    fn received_bytes(&self) -> usize {
        self.session.held() + self.reader.as_ref().map_or(0, Reader::held)
    }

    /// Presses or releases the emergency stop.
    pub fn emergency_stop(&mut self, now: Millis, pressed: bool) {
        warn!(pressed, "emergency stop");
        self.report(now, |session| session.emergency_stop(pressed));
    }

    /// Presses the switch of the operator, which starts a run or a shot that is ready.
    pub fn operator_go(&mut self, now: Millis) {
        info!("the operator says go");
        self.report(now, Session::operator_go);
    }

    /// Switches the inputs: these are on.
    pub fn set_inputs(&mut self, now: Millis, inputs: Triggers) {
        info!(%inputs, "inputs");
        self.report(now, |session| session.inputs(inputs));
    }

    /// Gives a report to the session at a moment.
    fn report(&mut self, now: Millis, report: impl FnOnce(&mut Session) -> Result<(), NotTaken>) {
        self.advance(now);
        self.tell(report);
        self.work();
    }

    /// Gives a report to the session. The session takes it, because it is polled after each report.
    fn tell(&mut self, report: impl FnOnce(&mut Session) -> Result<(), NotTaken>) {
        if let Err(error) = report(&mut self.session) {
            warn!(%error, "a report is lost");
        }
    }

    /// Does what the session says, until it waits.
    fn work(&mut self) {
        let (mut bytes, mut begins) = ([0; 256], false);
        loop {
            self.core.look(self.session.machine());
            match self.session.poll(self.core.clock, &self.core, &mut bytes) {
                Ok(Next::Transmit(frame)) if self.is_open => self.out.extend([sent(frame)]),
                // There is no line for these bytes.
                Ok(Next::Transmit(_)) => {}
                Ok(Next::Event(event)) => match event.to_static() {
                    Some(event) => {
                        self.core.state = self.session.machine().state();
                        self.core.obey(event);
                        begins |= event == Event::Go;
                    }
                    None => self.core.obey(event),
                },
                Ok(Next::Wait(until)) => {
                    self.until = until;
                    break;
                }
                Err(error) => warn!(%error, "an answer that cannot be sent"),
            }
            if let Some(report) = self.core.report.take() {
                self.tell(|session| tell(session, report));
            }
        }
        self.core.look(self.session.machine());
        // Without a pre-roll, the pass begins at once.
        if begins {
            self.follow();
        }
        self.core.carriages.follow(self.core.clock, &self.core.motors, &self.core.tuning);
    }

    /// Brings all motors to their positions of this moment.
    fn follow(&mut self) {
        loop {
            let ended = self.core.follow();
            if let Some(report) = self.core.report.take() {
                self.tell(|session| tell(session, report));
            }
            self.work();
            if !ended {
                return;
            }
        }
    }

    /// Does what is due at a moment.
    fn tick(&mut self, now: Millis) {
        self.core.clock = now;
        let overdue = self.reader.as_mut().map(|reader| reader.give_up(now));
        self.take(now, overdue.unwrap_or_default());
        self.core.camera.advance(now);
        self.follow();
        for index in 0..self.core.motors.len() {
            if let Some(Happening::Tripped { upper }) = self.core.motors[index].advance(now) {
                let motor = number(index);
                warn!(%motor, upper, "ran into its limit switch");
                self.tell(|session| session.limit(motor, upper));
                self.work();
            }
        }
        let state = self.core.state;
        if self.core.comes_to_rest() {
            info!(after = state.name(), "all motors rest");
            self.tell(Session::at_rest);
        } else if state != State::Idle {
            // The machine knows only the motors of the upload, and others may move with them.
            let moving = self.core.moving();
            let can_rest = self.core.setup.facts.tells_each_motor && state != State::Ready;
            if moving != self.session.machine().moving() && (can_rest || moving != Motors::NONE) {
                self.tell(|session| session.moving(moving));
            }
        }
        self.work();
    }

    /// Takes what was read.
    fn take(&mut self, now: Millis, read: Vec<Read>) {
        for read in read {
            match read {
                Read::Frame(bytes) => self.take_bytes(now, &bytes),
                Read::Refused(header, code) => self.refuse(header, code),
            }
        }
    }

    fn take_bytes(&mut self, now: Millis, mut bytes: &[u8]) {
        while !bytes.is_empty() {
            let taken = self.session.receive(now, bytes);
            bytes = &bytes[taken..];
            self.work();
        }
    }

    /// Refuses a message that the machine does not see.
    fn refuse(&mut self, header: Header, code: AckCode) {
        let wide = self.core.setup.options.quirks().contains(Quirks::WIDE_ACK);
        let kind = header.kind();
        let is_locked = self.state() == State::Locked && kind.0 >= FIRST_LOCKED && code == AckCode::ERR_UNSUPPORTED;
        let code = if is_locked { AckCode::ERR_HARD_LOW } else { code };
        let contents = Contents::Ack { of: kind, code, wide };
        let (mut scratch, mut bytes) = (Scratch::default(), [0; 256]);
        let message = Transmit { id: header.id(), contents }.message(&self.core, &mut scratch);
        if let Ok(len) = message.encode_into(header.id(), &mut bytes) {
            self.out.extend([sent(&bytes[..len])]);
        }
    }
}

/// Session of a device that was switched on.
fn session(setup: &Setup) -> Box<Session> {
    Box::new(Session::new(DeviceMachine::new(setup.options), setup.patience))
}

/// Gives a report of the motors or of the upload buffer to a session.
fn tell(session: &mut Session, report: Input<'_>) -> Result<(), NotTaken> {
    match report {
        Input::Stored(store, code) => session.stored(store, code),
        Input::AtFrame(frame) => session.at_frame(frame),
        Input::Fault(motor) => session.fault(motor),
        _ => session.pass_end(),
    }
}

/// Bytes of a message, which is noted in the log.
fn sent(bytes: &[u8]) -> Outgoing {
    if let Ok(Ok(message)) = Frame::decode(bytes).map(|frame| DeviceMessage::decode(&frame)) {
        if let DeviceMessage::Ack(ack) = message
            && ack.response_code != Some(AckCode::OK)
        {
            info!(request = %ack.of, why = ?ack.response_code, "refuses");
        }
        debug!("sends {message}");
    }
    Outgoing::Bytes(LINE, bytes.to_vec())
}

impl Party for DmcDevice {
    fn open(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        if line == LINE && !self.is_open {
            info!("line open");
            self.is_open = true;
            self.owes_greeting = self.core.setup.facts.is_silent_at_boot;
            if !self.owes_greeting {
                self.session.link_up();
                self.work();
            }
        }
    }

    fn close(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        if line == LINE && self.is_open {
            info!("line gone");
            self.is_open = false;
            self.out.clear();
            self.reader.as_mut().map(Reader::reset);
            self.session.link_down();
            self.work();
        }
    }

    fn receive(&mut self, now: Millis, line: LineId, bytes: &[u8]) {
        // Bytes can be read late: they come before the incomplete frame that they complete is given up.
        if self.received_bytes() == 0 {
            self.advance(now);
        }
        if line == LINE && self.is_open {
            if mem::take(&mut self.owes_greeting) {
                self.session.link_up();
                self.work();
            }
            if let Some(reader) = &mut self.reader {
                let read = reader.receive(now, bytes);
                self.take(now, read);
            } else {
                self.take_bytes(now, bytes);
            }
        }
        self.advance(now);
    }

    fn advance(&mut self, now: Millis) {
        while let Some(next) = self.wake().filter(|next| *next <= now) {
            self.tick(next.max(self.core.clock));
        }
        self.core.clock = self.core.clock.max(now);
    }

    fn wake(&self) -> Option<Millis> {
        let tick = self.core.is_busy().then(|| self.core.clock.after(TICK));
        let overdue = self.reader.as_ref().and_then(Reader::deadline);
        [tick, self.until, self.core.camera.wake(), overdue].into_iter().flatten().min()
    }

    fn poll(&mut self) -> Option<Outgoing> {
        self.out.pop_front()
    }
}

impl Rig for DmcDevice {
    const LINES: u8 = 1;

    fn motors(&self) -> &[Motor] {
        self.core.carriages.motors().unwrap_or(&self.core.motors)
    }

    fn moment(&self) -> Option<f64> {
        self.core.moment()
    }

    fn reset(&mut self, now: Millis) {
        self.advance(now);
        warn!("reset");
        self.is_open = false;
        self.out.clear();
        self.reader.as_mut().map(Reader::reset);
        (self.session, self.until) = (session(&self.core.setup), None);
        self.core.reset();
    }

    fn stall(&mut self, now: Millis) {
        self.advance(now);
        let core = &mut self.core;
        let stuck = core.motors.iter().position(|motor| motor.at(now).velocity != 0.0);
        if let Some(index) = stuck {
            let motor = number(index);
            warn!(%motor, "is stuck");
            core.motors[index].halt(now);
            self.tell(|session| session.fault(Some(motor)));
            self.work();
        }
    }
}

/// Index of a motor. The numbers of motors begin with 1.
fn index(motor: Number) -> Option<usize> {
    usize::from(motor.0).checked_sub(1)
}

/// Number of the motor with an index.
fn number(index: usize) -> Number {
    Number(u8::try_from(index + 1).unwrap_or(u8::MAX))
}

/// Step that is nearest to a position.
#[expect(clippy::cast_possible_truncation, reason = "a cast saturates")]
const fn steps(position: f64) -> i32 {
    position.round() as i32
}

/// Duration in seconds as whole milliseconds.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a cast saturates")]
const fn millis(seconds: f64) -> u64 {
    (seconds * 1000.0).round() as u64
}
