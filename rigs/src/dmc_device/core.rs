//! Device without its line: the machine, the motors, and their reports to each other.

use std::borrow::Cow;
use std::collections::VecDeque;

use dmc_proto::device::{self, Contents, DeviceMachine, Effect, Input, Quirks, Scratch, State, Transmit};
use dmc_proto::frame::encode;
use dmc_proto::message::{
    AckCode, FrameNumber, Hi, HostMessage, Motor as Number, Motors, MoveTime, Other, Scaled, Steps, Triggers,
};
use dmc_proto::upload::Room;
use dmc_proto::{Frame, Header, Item};
use motion_core::time::Millis;
use motion_core::wire::Messages;
use tracing::{debug, info, warn};

use super::camera::Camera;
use super::carriages::Carriages;
use super::course::Course;
use super::job::Job;
use super::setup::{Setup, Tuning};
use super::store::Store;
use super::{LINE, index, number, steps};
use crate::motor::{Happening, Motor};
use crate::{Outgoing, TICK};

/// Greatest type that the vendor's parser accepts, apart from the bit of acknowledgements.
const LAST_TYPE: u16 = 0x03FF;

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
    /// Number of bytes of a damaged frame that are still to be dropped.
    drops: usize,
    pub(super) tuning: Vec<Tuning>,
    pub(super) store: Store,
    pub(super) course: Course,
    /// Run or shot that was prepared or refused, and was neither done nor stopped.
    pub(super) left: Option<Job>,
    /// Time in the move of the last run, shot or jog of all motors, in frames.
    pub(super) film: f64,
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
            drops: 0,
            tuning: setup.motors.iter().map(|motor| Tuning::of(motor, &setup.facts)).collect(),
            store: Store::new(room, setup.facts.fills_with_zeros),
            course: Course::Free,
            left: None,
            film: 0.0,
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
        self.tuning = self.setup.motors.iter().map(|motor| Tuning::of(motor, &self.setup.facts)).collect();
        self.drops = 0;
        self.store.clear();
        self.course = Course::Free;
        (self.left, self.film) = (None, 0.0);
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
                self.request(&frame);
            }
            Item::Corrupt { header, why, bytes } => {
                warn!(%why, "a message arrived damaged");
                if self.setup.facts.drops_damaged {
                    self.drops = header.frame_len().saturating_sub(bytes.len());
                }
                if self.setup.facts.vendor_parser && header.kind().is_ack() {
                    return self.refuse(header, AckCode::ERR_CHECKSUM);
                }
                self.step(Input::Corrupt(header.id(), header.kind()));
            }
            Item::Noise { bytes, why } => warn!(%why, len = bytes.len(), "noise"),
            Item::Fatal(why) => warn!(%why, "the stream cannot go on"),
        }
    }

    /// Refuses an acknowledgement, which no device should receive.
    fn refuse(&mut self, header: Header, code: AckCode) {
        let wide = self.setup.options.quirks().contains(Quirks::WIDE_ACK);
        self.transmit(Transmit { id: header.id(), contents: Contents::Ack { of: header.kind(), code, wide } });
    }

    /// Takes a request.
    fn request(&mut self, frame: &Frame<'_>) {
        let (id, kind) = (frame.id(), frame.kind());
        let parser = self.setup.facts.vendor_parser;
        if parser && (kind.0 == 0 || kind.request().0 > LAST_TYPE) {
            return warn!(request = %kind, "drops a request of an unknown type");
        }
        if parser && kind.is_ack() {
            let is_locked = self.machine.state() == State::Locked;
            let code = if is_locked { AckCode::ERR_HARD_LOW } else { AckCode::ERR_UNSUPPORTED };
            return self.refuse(*frame.header(), code);
        }
        let data = if parser { completed(frame) } else { Some(frame.payload().into()) };
        let message = if self.setup.facts.unknown.contains(&kind.0) {
            Some(HostMessage::Other(Other::new(kind.0.into(), frame.payload())))
        } else {
            data.as_deref().and_then(|data| HostMessage::decode_body(kind.0.into(), data).ok())
        };
        let input = match message {
            Some(message) => {
                debug!("receives {message}");
                let rig = self.judge(&message);
                if matches!(rig, AckCode::ERR_PREROLL | AckCode::ERR_POSTROLL) {
                    self.left = self.job(&message);
                }
                Input::Received { id, rig, message }
            }
            None => Input::Malformed(id, kind),
        };
        self.step(input);
    }

    /// Whether the motors have to be updated every millisecond.
    fn is_busy(&self) -> bool {
        self.owes_rest || self.course.is_busy() || self.motors.iter().any(|motor| !motor.is_idle())
    }

    /// Time when something is due.
    pub(super) fn next(&self) -> Option<Millis> {
        let tick = self.is_busy().then(|| self.clock.after(TICK));
        [tick, self.wake, self.camera.wake()].into_iter().flatten().min()
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
        if self.wake.is_some_and(|wake| wake <= now) {
            self.step(Input::Wake);
        }
        if self.owes_rest && !self.course.is_busy() && self.motors.iter().all(Motor::is_idle) {
            self.owes_rest = false;
            info!(after = self.machine.state().name(), "all motors rest");
            self.step(Input::AtRest);
        } else if self.machine.state() != State::Idle {
            // The machine knows only the motors of the upload, and others may move with them.
            let moving = self.moving();
            let can_rest = self.setup.facts.tells_each_motor && self.machine.state() != State::Ready;
            if moving != self.machine.moving() && (can_rest || moving != Motors::NONE) {
                self.step(Input::Moving(moving));
            }
        }
        self.carriages.follow(self.clock, &self.motors, &self.tuning);
    }

    /// Motors that move. In a run or a jog of all motors these are all that take part, except those that rest in a shot.
    fn moving(&self) -> Motors {
        let moves = |motor: &Number| index(*motor).is_some_and(|index| !self.motors[index].is_idle());
        let led = self.led();
        (1..=self.count()).map(Number).filter(|motor| led.contains(motor) || moves(motor)).collect()
    }

    /// Position of a motor.
    pub(super) fn place(&self, motor: Number) -> f64 {
        index(motor).and_then(|index| self.motors.get(index)).map_or(0.0, |motor| motor.at(self.clock).position)
    }
}

impl device::Rig for Core {
    fn verdict(&self, message: &HostMessage<'_>) -> AckCode {
        self.judge(message)
    }

    fn position(&self, motor: Number) -> Steps {
        let place = self.place(motor);
        if self.setup.facts.truncates {
            #[expect(clippy::cast_possible_truncation, reason = "the device counts in such numbers")]
            let counted = f64::from(place as f32);
            return Steps(steps((counted - 0.01_f64.copysign(place)).trunc()));
        }
        Steps(steps(place))
    }

    fn move_time(&self) -> Option<MoveTime> {
        self.setup.facts.keeps_time.then(|| MoveTime(Scaled(steps((self.film * 1000.0).trunc()))))
    }
}

/// Data of a request, with zeros in the place of what is missing; `None` if the data cannot be read in this way.
fn completed<'a>(frame: &Frame<'a>) -> Option<Cow<'a, [u8]>> {
    let data = frame.payload();
    if matches!(frame.kind().0, 0x0031 | 0x0035) {
        return (data.len() == 5).then_some(data.into());
    }
    // The fields that a message cannot do without have fewer bytes than this.
    let longer = (data.len()..data.len() + 64).map(|len| {
        let mut longer = data.to_vec();
        longer.resize(len, 0);
        longer
    });
    let can = |data: &Vec<u8>| HostMessage::decode_body(frame.kind().0.into(), data).is_ok();
    longer.into_iter().find(can).map(Cow::Owned)
}

/// Whether a frame has the check bytes that this crate writes. Modulo 255, the bytes 00 and FF are the same.
fn is_canonical(frame: &Frame<'_>) -> bool {
    let mut bytes = vec![0; frame.bytes().len()];
    let written = encode(frame.id(), frame.kind(), frame.payload(), &mut bytes);
    written.is_ok() && bytes == frame.bytes()
}
