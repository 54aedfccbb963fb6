//! Device without its line: the motors, and their reports.

use std::cell::{Cell, RefCell};

use dmc_proto::device::{self, DeviceMachine, Input, State};
use dmc_proto::message::{
    AckCode, FrameNumber, Hi, HostMessage, Motor as Number, Motors, MoveTime, Scaled, Steps, Triggers,
};
use dmc_proto::upload::Room;
use motion_core::time::Millis;
use tracing::debug;

use super::camera::Camera;
use super::carriages::Carriages;
use super::course::Course;
use super::job::Job;
use super::setup::{Setup, Tuning};
use super::store::Store;
use super::{index, steps};
use crate::motor::Motor;

/// Device without its line.
#[derive(Debug)]
pub(super) struct Core {
    pub(super) setup: Setup,
    pub(super) clock: Millis,
    /// State of the machine.
    pub(super) state: State,
    /// Frame on which all motors stood before the last step of the machine.
    pub(super) stood_on: Option<FrameNumber>,
    /// Report for the machine.
    pub(super) report: Option<Input<'static>>,
    /// Whether the motors are to be brought to their positions of this moment.
    pub(super) follows: bool,
    pub(super) motors: Vec<Motor>,
    pub(super) carriages: Carriages,
    pub(super) tuning: Vec<Tuning>,
    pub(super) store: Store,
    pub(super) course: Course,
    /// Run or shot that was prepared or refused, and was neither done nor stopped.
    pub(super) left: RefCell<Option<Job>>,
    /// Time in the move of the last run, shot or jog of all motors, in frames.
    pub(super) film: f64,
    /// Whether the machine waits for the report that all motors rest.
    pub(super) owes_rest: bool,
    pub(super) camera: Camera,
    pub(super) outputs: Triggers,
    pub(super) levels: Vec<u8>,
    /// Number of requests that were judged.
    pub(super) received: Cell<u64>,
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
            state: State::Idle,
            stood_on: None,
            report: None,
            follows: false,
            motors: setup.motors.clone(),
            carriages: Carriages::new(setup.facts.moves_disabled),
            tuning: setup.motors.iter().map(|motor| Tuning::of(motor, &setup.facts)).collect(),
            store: Store::new(room, setup.facts.fills_with_zeros),
            course: Course::Free,
            left: RefCell::new(None),
            film: 0.0,
            owes_rest: false,
            camera: Camera::default(),
            outputs: Triggers::NONE,
            levels: vec![0; hi.dmx_count.into()],
            received: Cell::new(0),
            setup,
        }
    }

    /// Makes everything new, except the motors and the photos that were taken.
    pub(super) fn reset(&mut self) {
        (self.state, self.stood_on, self.report) = (State::Idle, None, None);
        self.tuning = self.setup.motors.iter().map(|motor| Tuning::of(motor, &self.setup.facts)).collect();
        self.store.clear();
        self.course = Course::Free;
        self.left.take();
        self.film = 0.0;
        self.owes_rest = false;
        self.outputs = Triggers::NONE;
        self.levels.fill(0);
        self.camera.close(self.clock);
        self.camera.is_filming = false;
        for motor in &mut self.motors {
            motor.halt(self.clock);
            motor.advance(self.clock);
            // A controller that counts steps does not know where its motors stand.
            motor.rebase(self.clock, 0.0);
        }
        self.carry();
    }

    /// Brings the motors as they really stand to where they are.
    pub(super) fn carry(&mut self) {
        self.carriages.follow(self.clock, &self.motors, &self.tuning);
    }

    /// Takes note of what the machine knows, before its next step.
    pub(super) const fn look(&mut self, machine: &DeviceMachine) {
        (self.state, self.stood_on) = (machine.state(), machine.on_frame());
    }

    /// Whether the motors have to be updated every millisecond.
    pub(super) fn is_busy(&self) -> bool {
        self.owes_rest || self.course.is_busy() || self.motors.iter().any(|motor| !motor.is_idle())
    }

    /// Whether the report that all motors rest is due. Then it is not due again.
    pub(super) fn comes_to_rest(&mut self) -> bool {
        // After a run with photos, the last one has to be complete.
        let takes_photo = self.state == State::PostRoll && self.camera.wake().is_some();
        let rests = !self.course.is_busy() && !takes_photo && self.motors.iter().all(Motor::is_idle);
        let is_due = self.owes_rest && rests;
        self.owes_rest &= !is_due;
        is_due
    }

    /// Motors that move. In a run or a jog of all motors these are all that take part, except those that rest in a shot.
    pub(super) fn moving(&self) -> Motors {
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
        debug!("receives {message}");
        self.received.set(self.received.get() + 1);
        let code = self.judge(message);
        if matches!(code, AckCode::ERR_PREROLL | AckCode::ERR_POSTROLL) {
            self.left.replace(self.job(message));
        }
        code
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
