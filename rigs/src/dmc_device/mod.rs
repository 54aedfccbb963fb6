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
mod work;

use std::collections::VecDeque;
use std::mem;

use dmc_proto::device::{DeviceMachine, Session};
use dmc_proto::message::{FrameNumber, Motor as Number, Steps, Triggers};
use motion_core::time::Millis;
use tracing::{info, warn};

use crate::motor::Motor;
use crate::{LineId, Outgoing, Party, Rig, TICK, waiting};

pub use camera::Photo;
pub use setup::{Facts, Setup, Tuning};

use self::core::Core;
use self::reader::Reader;
use self::work::note;

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

    /// Machine of the device, for reading its state.
    #[must_use]
    pub const fn machine(&self) -> &DeviceMachine {
        self.session.machine()
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
        self.advance(now);
        warn!(pressed, "emergency stop");
        note(self.session.emergency_stop(pressed));
        self.work();
    }

    /// Presses the switch of the operator, which starts a run or a shot that is ready.
    pub fn operator_go(&mut self, now: Millis) {
        self.advance(now);
        info!("the operator says go");
        note(self.session.operator_go());
        self.work();
    }

    /// Switches the inputs: these are on.
    pub fn set_inputs(&mut self, now: Millis, inputs: Triggers) {
        self.advance(now);
        info!(%inputs, "inputs");
        note(self.session.inputs(inputs));
        self.work();
    }
}

/// Session of a device that was switched on.
fn session(setup: &Setup) -> Box<Session> {
    Box::new(Session::new(DeviceMachine::new(setup.options), setup.patience))
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
            self.read(now, bytes);
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
            note(self.session.fault(Some(motor)));
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
