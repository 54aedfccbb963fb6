//! Device without its line: the machine, the motors, and their reports to each other.

use std::collections::{BTreeMap, VecDeque};

use dmc_proto::device::{self, Contents, DeviceMachine, Effect, Input, Scratch, State, Transmit};
use dmc_proto::frame::encode;
use dmc_proto::message::{AckCode, FrameNumber, Hi, Motor as Number, Motors, Steps, Triggers};
use dmc_proto::upload::Room;
use dmc_proto::{Frame, Header, Item};
use motion_core::time::Millis;
use tracing::{debug, info, warn};

use super::camera::Camera;
use super::carriages::Carriages;
use super::course::Course;
use super::setup::{Setup, Tuning};
use super::store::Store;
use super::{LINE, index, number, steps};
use crate::motor::{Happening, Motor};
use crate::{Outgoing, TICK};

/// Device without its line.
#[derive(Debug)]
pub(super) struct Core {
    pub(super) setup: Setup,
    pub(super) clock: Millis,
    pub(super) machine: DeviceMachine,
    /// Time when the machine wants to be woken.
    pub(super) wake: Option<Millis>,
    pub(super) motors: Vec<Motor>,
    pub(super) carriages: Carriages,
    /// Times at which jogs end by themselves.
    pub(super) jogs: BTreeMap<Number, Millis>,
    /// Number of bytes of a damaged frame that are still to be dropped.
    drops: usize,
    pub(super) tuning: Vec<Tuning>,
    pub(super) store: Store,
    pub(super) course: Course,
    /// Frame on which all motors stood before the last step of the machine.
    pub(super) stood_on: Option<FrameNumber>,
    /// Whether the machine waits for the report that all motors rest.
    pub(super) owes_rest: bool,
    pub(super) camera: Camera,
    pub(super) outputs: Triggers,
    pub(super) levels: Vec<u8>,
    pub(super) received: u64,
    pub(super) out: VecDeque<Outgoing>,
}

impl Core {
    pub(super) fn new(mut setup: Setup) -> Self {
        setup.motors.truncate(32);
        let count = u8::try_from(setup.motors.len()).unwrap_or(32);
        let hi = Hi { motor_count: count, ..setup.options.hi() };
        setup.options = setup.options.with_hi(hi);
        let room = Room { motors: count, channels: hi.dmx_count, frames: hi.upload_frame_count };
        Self {
            clock: Millis(0),
            machine: DeviceMachine::new(setup.options),
            wake: None,
            motors: setup.motors.clone(),
            carriages: Carriages::new(setup.facts.moves_disabled),
            jogs: BTreeMap::new(),
            drops: 0,
            tuning: setup.motors.iter().map(|motor| Tuning::of(motor, setup.facts.uses)).collect(),
            store: Store::new(room, setup.facts.fills_with_zeros),
            course: Course::Free,
            stood_on: None,
            owes_rest: false,
            camera: Camera::default(),
            outputs: Triggers::NONE,
            levels: vec![0; hi.dmx_count.into()],
            received: 0,
            out: VecDeque::new(),
            setup,
        }
    }

    /// Makes everything new, except the motors and the photos that were taken.
    pub(super) fn reset(&mut self) {
        self.machine = DeviceMachine::new(self.setup.options);
        self.wake = None;
        self.tuning = self.setup.motors.iter().map(|motor| Tuning::of(motor, self.setup.facts.uses)).collect();
        self.jogs.clear();
        self.drops = 0;
        self.store.clear();
        self.course = Course::Free;
        self.owes_rest = false;
        self.outputs = Triggers::NONE;
        self.levels.fill(0);
        self.out.clear();
        self.camera.close(self.clock);
        self.camera.is_filming = false;
        for motor in &mut self.motors {
            motor.halt(self.clock);
            motor.advance(self.clock);
            // A controller that counts steps does not know where its motors stand.
            motor.rebase(self.clock, 0.0);
        }
        self.carriages.follow(self.clock, &self.motors, &self.tuning);
    }

    /// Gives an input to the machine and carries out its effects.
    pub(super) fn step(&mut self, input: Input<'_>) {
        self.stood_on = self.machine.on_frame();
        let output = self.machine.advance(self.clock, input);
        self.wake = output.wake;
        for effect in output {
            match effect {
                Effect::Transmit(transmit) => self.transmit(transmit),
                Effect::Event(event) => self.obey(event),
            }
        }
        self.carriages.follow(self.clock, &self.motors, &self.tuning);
    }

    fn transmit(&mut self, transmit: Transmit) {
        let (mut scratch, mut bytes) = (Scratch::default(), [0; 256]);
        if let Contents::Ack { of, code, .. } = transmit.contents
            && code != AckCode::OK
        {
            info!(request = %of, why = ?code, "refuses");
        }
        let message = transmit.message(self, &mut scratch);
        debug!("sends {message}");
        match message.encode_into(transmit.id, &mut bytes) {
            Ok(len) => self.out.push_back(Outgoing::Bytes(LINE, bytes[..len].to_vec())),
            Err(error) => warn!(%error, "an answer that cannot be sent"),
        }
    }

    pub(super) fn received(&mut self, item: Item<'_, Frame<'_>, Header>) {
        if self.drops > 0 {
            self.drops = self.drops.saturating_sub(item.bytes().len());
            return;
        }
        match item {
            Item::Frame(frame) if self.setup.facts.compares_check && !is_canonical(&frame) => {
                warn!("a message has other check bytes than this device writes");
                self.step(Input::Corrupt(frame.id(), frame.kind()));
            }
            Item::Frame(frame) => {
                self.received += 1;
                let input = Input::received(&frame, |message| {
                    debug!("receives {message}");
                    self.verdict(message)
                });
                self.step(input);
            }
            Item::Corrupt { header, why, bytes } => {
                warn!(%why, "a message arrived damaged");
                if self.setup.facts.drops_damaged {
                    self.drops = header.frame_len().saturating_sub(bytes.len());
                }
                self.step(Input::Corrupt(header.id(), header.kind()));
            }
            Item::Noise { bytes, why } => warn!(%why, len = bytes.len(), "noise"),
            Item::Fatal(why) => warn!(%why, "the stream cannot go on"),
        }
    }

    /// Whether the motors have to be updated every millisecond.
    fn is_busy(&self) -> bool {
        self.owes_rest || self.course.is_busy() || self.motors.iter().any(|motor| !motor.is_idle())
    }

    /// Time when something is due.
    pub(super) fn next(&self) -> Option<Millis> {
        let tick = self.is_busy().then(|| self.clock.after(TICK));
        [tick, self.wake, self.camera.wake(), self.jogs.values().min().copied()].into_iter().flatten().min()
    }

    /// Does what is due up to a moment.
    pub(super) fn advance(&mut self, now: Millis) {
        while let Some(next) = self.next().filter(|next| *next <= now) {
            self.tick(next.max(self.clock));
        }
        self.clock = self.clock.max(now);
    }

    /// Does what is due at a moment.
    fn tick(&mut self, now: Millis) {
        self.clock = now;
        self.camera.advance(now);
        self.follow();
        for index in 0..self.motors.len() {
            if let Some(Happening::Tripped { upper }) = self.motors[index].advance(now) {
                let motor = number(index);
                warn!(%motor, upper, "ran into its limit switch");
                self.step(Input::Limit { motor, upper });
            }
        }
        self.end_jogs();
        if self.wake.is_some_and(|wake| wake <= now) {
            self.step(Input::Wake);
        }
        if self.owes_rest && !self.course.is_busy() && self.motors.iter().all(Motor::is_idle) {
            self.owes_rest = false;
            info!(after = self.machine.state().name(), "all motors rest");
            self.step(Input::AtRest);
        } else if self.machine.state() != State::Idle {
            // The machine knows only the motors of the upload, and others may move with them.
            let moving = (0..self.motors.len()).filter(|index| !self.motors[*index].is_idle()).map(number);
            let moving: Motors = moving.collect();
            if moving != self.machine.moving() && moving != Motors::NONE {
                self.step(Input::Moving(moving));
            }
        }
        self.carriages.follow(self.clock, &self.motors, &self.tuning);
    }

    /// Position of a motor.
    pub(super) fn place(&self, motor: Number) -> f64 {
        index(motor).and_then(|index| self.motors.get(index)).map_or(0.0, |motor| motor.at(self.clock).position)
    }
}

impl device::Rig for Core {
    fn position(&self, motor: Number) -> Steps {
        let place = self.place(motor);
        if self.setup.facts.truncates {
            return Steps(steps((place - 0.01_f64.copysign(place)).trunc()));
        }
        Steps(steps(place))
    }
}

/// Whether a frame has the check bytes that this crate writes. Modulo 255, the bytes 00 and FF are the same.
fn is_canonical(frame: &Frame<'_>) -> bool {
    let mut bytes = vec![0; frame.bytes().len()];
    let written = encode(frame.id(), frame.kind(), frame.payload(), &mut bytes);
    written.is_ok() && bytes == frame.bytes()
}
