//! Motion of all motors together, moment by moment.

use dmc_proto::device::{Input, Quirks, Report, State};
use dmc_proto::message::{FrameNumber, Motor as Number, RunFlags, Triggers};
use motion_core::profile::Limits;
use tracing::{debug, info, warn};

use super::core::Core;
use super::job::{self, Job, Kind, Way};
use super::store::Store;
use super::{index, steps};
use crate::motor::{Motor, Place};
use crate::seconds;

/// Time in which a jog of all motors reaches its speed, in seconds.
const JOG_ROLL: f64 = 0.5;
/// Greatest deceleration of a jog of all motors of dmc-lite, which may be stopped more sharply than it begins.
const HARD_STOP: f64 = 1000.0;
/// Least speed and deceleration with which a jog of all motors of dmc-lite lands on a frame, in frames per second.
const SLOWEST: f64 = 1.0;
/// Acceleration of a jog of all motors of dmc-lite, in frames per second in a second.
const VENDOR_JOG: f64 = 4.0;

/// Motion of all motors together.
#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "a rig has one course")]
pub(super) enum Course {
    /// Each motor moves for itself, or rests.
    Free,
    /// All motors run along the uploaded move. The frame moves like a motor.
    JogAll { frame: Motor, told: i32 },
    /// All motors go to the start of a run or shot, or wait there.
    Ready(Job),
    /// A run or a shot runs.
    Runs(Run),
}

/// Run or shot that has begun.
#[derive(Debug, Clone)]
pub(super) struct Run {
    job: Job,
    phase: Phase,
    /// Time at which the phase began, in seconds.
    since: f64,
    /// Frame that was reported last.
    told: Option<i32>,
    /// First and last frame of the next pass, if another pass follows.
    next: Option<(i32, i32)>,
    /// Time at which the shutter opens, in seconds, if it does not open when the pass begins.
    opens: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// The motors reach their speed.
    Up,
    Pass,
    /// The motors come to rest.
    Down,
    /// The motors go to the start of the next pass.
    Back,
}

impl Course {
    /// Whether the motors have to be led at every moment.
    pub(super) const fn is_busy(&self) -> bool {
        matches!(self, Self::JogAll { .. } | Self::Runs(_))
    }
}

impl Core {
    /// Frame of the move, with its fraction, while the move is played.
    pub(super) fn moment(&self) -> Option<f64> {
        match &self.course {
            Course::JogAll { frame, .. } => Some(frame.at(self.clock).position),
            Course::Runs(Run { job, phase: Phase::Pass, since, .. }) => Some(job.moment(seconds(self.clock) - since)),
            _ => None,
        }
    }

    /// Starts the run or shot that is ready.
    pub(super) fn go(&mut self) {
        if let Course::Ready(job) = std::mem::replace(&mut self.course, Course::Free) {
            let since = seconds(self.clock);
            let opens = if let Kind::Shot { opens, .. } = job.kind { opens.map(|after| since + after) } else { None };
            self.course = Course::Runs(Run { job, phase: Phase::Up, since, told: None, next: None, opens });
            // Without a pre-roll, the pass begins at once.
            self.follows = true;
        }
    }

    /// Lets another pass follow this one.
    pub(super) fn next_pass(&mut self, from: FrameNumber, to: FrameNumber) {
        let passes_end = self.setup.options.quirks().contains(Quirks::RESTS_BEYOND);
        if let Course::Runs(run) = &mut self.course {
            run.next = Some((from.0, if passes_end { job::beyond(to.0, &self.store) } else { to.0 }));
        }
    }

    /// Runs all motors of the uploaded move along it.
    pub(super) fn jog_all(&mut self, rate: f64, to: FrameNumber) {
        let now = self.clock;
        let (acceleration, hardest) =
            if self.setup.facts.vendor_jog_all { (VENDOR_JOG, HARD_STOP) } else { (rate / JOG_ROLL, rate / JOG_ROLL) };
        let limits = Limits { velocity: rate, acceleration: hardest, jerk: None };
        let mut frame = Motor::new(limits);
        if let Course::JogAll { frame: before, .. } = &self.course {
            frame.lead(before.at(now));
        } else {
            frame.rebase(now, f64::from(self.stood_on.unwrap_or(to).0));
        }
        let told = steps(frame.at(now).position);
        frame.go_to(now, f64::from(to.0), rate, acceleration);
        self.course = Course::JogAll { frame, told };
    }

    /// Lets a jog of all motors come to rest on a frame. Returns whether there is such a jog.
    pub(super) fn land(&mut self) -> bool {
        let now = self.clock;
        let Course::JogAll { frame, .. } = &mut self.course else { return false };
        let Place { position, velocity } = frame.at(now);
        if velocity == 0.0 {
            frame.halt(now);
        } else {
            // dmc-lite slows down by half of the speed of the jog in a second, and by two frames per second at least.
            let slowing = (frame.limits().velocity / 2.0).max(2.0);
            let goal = position + velocity * velocity.abs() / (2.0 * slowing);
            let goal = if velocity > 0.0 { goal.ceil() } else { goal.floor() };
            let slowing = velocity * velocity / (2.0 * (goal - position).abs().max(f64::MIN_POSITIVE));
            frame.go_to(now, goal, velocity.abs().max(SLOWEST), slowing.max(SLOWEST));
        }
        true
    }

    /// Brings all motors to their positions of this moment. When a phase of a run has ended, the next phase is followed after
    /// the machine has taken the report.
    pub(super) fn follow(&mut self) {
        match &self.course {
            Course::JogAll { .. } => self.follow_jog(),
            Course::Runs(_) => self.follows = self.follow_run(),
            Course::Free | Course::Ready(_) => {}
        }
    }

    fn follow_jog(&mut self) {
        let now = self.clock;
        let Course::JogAll { frame, told } = &mut self.course else { return };
        frame.advance(now);
        let Place { position: at, velocity } = frame.at(now);
        let rests = frame.is_idle();
        let this = steps(if velocity < 0.0 { at.ceil() } else { at.floor() });
        let is_new = this != *told && !rests;
        *told = this;
        self.film = at;
        let axes: Vec<_> = self.axes().collect();
        for &motor in &axes {
            let Some(position) = self.store.between(motor, at) else { continue };
            let ahead = self.store.between(motor, at.floor() + 1.0).unwrap_or(position);
            let here = self.store.between(motor, at.floor()).unwrap_or(position);
            self.lead_one(motor, Place { position, velocity: (ahead - here) * velocity });
        }
        if !self.course.is_busy() {
            return;
        }
        if rests {
            for motor in axes.into_iter().filter_map(index) {
                self.motors[motor].halt(now);
            }
            self.course = Course::Free;
            self.owes_rest = true;
            let left = self.left.borrow().clone();
            if let Some(job) = left.filter(|_| self.setup.facts.jogs_to_run) {
                for way in &job.ways {
                    self.send_to(way.motor, way.before(job.up));
                }
                if self.state == State::PreRoll {
                    self.course = Course::Ready(job);
                }
            }
        } else if is_new && self.state == State::JogAll {
            self.report = Some(Input::Rig(Report::AtFrame(FrameNumber(this))));
        }
    }

    /// Brings all motors of a run to their positions. Returns whether a phase ended, so that the next one has to be followed.
    fn follow_run(&mut self) -> bool {
        let now = seconds(self.clock);
        let Course::Runs(run) = &mut self.course else { return false };
        if run.opens.is_some_and(|opens| opens <= now) {
            run.opens = None;
            if let Kind::Shot { exposure, .. } = run.job.kind {
                self.camera.open(self.clock, Some(exposure), Some(run.job.from));
            }
        }
        let time = now - run.since;
        let lasts = match run.phase {
            Phase::Up => run.job.up,
            Phase::Pass => run.job.seconds,
            Phase::Down => run.job.down,
            Phase::Back => f64::INFINITY,
        };
        let is_over = time >= lasts;
        if is_over {
            run.since += lasts;
        }
        match (run.phase, is_over) {
            (Phase::Up, true) => {
                run.phase = Phase::Pass;
                self.begin_pass();
            }
            (Phase::Up, false) => self.lead(|job, way, _| way.rolls_up(job.up, time)),
            (Phase::Pass, true) => {
                run.phase = Phase::Down;
                self.end_pass();
            }
            (Phase::Pass, false) => {
                self.lead(|job, way, store| job.along(way, time, store));
                self.tell_frame(time);
            }
            (Phase::Down, true) => self.rolled(),
            (Phase::Down, false) => self.lead(|job, way, _| way.rolls_down(job.down, time)),
            (Phase::Back, _) => {
                let motors = run.job.ways.iter().filter_map(|way| self.motors.get(index(way.motor)?));
                if !motors.into_iter().all(Motor::is_idle) {
                    return false;
                }
                (run.phase, run.since) = (Phase::Up, now);
                return true;
            }
        }
        is_over
    }

    /// Motors that take part in what all motors do together, except those that rest in a shot.
    pub(super) fn led(&self) -> Vec<Number> {
        match &self.course {
            Course::JogAll { .. } => self.axes().collect(),
            Course::Runs(run) => {
                let is_run = matches!(run.job.kind, Kind::Run { .. });
                run.job.ways.iter().filter(|way| is_run || way.is_own()).map(|way| way.motor).collect()
            }
            Course::Free | Course::Ready(_) => Vec::new(),
        }
    }

    /// Puts each motor of the run at its place.
    fn lead(&mut self, place: impl Fn(&Job, &Way, &Store) -> Place) {
        let Course::Runs(run) = &self.course else { return };
        let places: Vec<_> = run.job.ways.iter().map(|way| (way.motor, place(&run.job, way, &self.store))).collect();
        for (motor, place) in places {
            self.lead_one(motor, place);
        }
    }

    /// Puts a motor at a place. A motor that cannot be so fast gets stuck.
    fn lead_one(&mut self, number: Number, place: Place) {
        let now = self.clock;
        let Some(motor) = index(number).and_then(|index| self.motors.get_mut(index)) else { return };
        if !self.course.is_busy() {
            // Another motor got stuck at this moment, and all motors stop.
        } else if place.velocity.abs() <= motor.limits().velocity {
            motor.lead(place);
        } else {
            motor.halt(now);
            warn!(motor = %number, speed = place.velocity, "too fast for the motor, which is stuck");
            self.course = Course::Free;
            self.report = Some(Input::Rig(Report::Fault(Some(number))));
        }
    }

    /// Begins a pass: a shutter opens, or the camera starts to film.
    fn begin_pass(&mut self) {
        let Course::Runs(run) = &self.course else { return };
        let job = &run.job;
        info!(from = job.from, to = job.to, seconds = job.seconds, "a pass begins");
        match &job.kind {
            Kind::Shot { opens: Some(_), .. } => {}
            Kind::Shot { exposure, .. } => self.camera.open(self.clock, Some(*exposure), Some(job.from)),
            Kind::Run { flags, .. } if flags.contains(RunFlags::CAMERA_START_STOP) && !self.camera.is_filming => {
                self.camera.is_filming = true;
                info!("the camera films");
            }
            Kind::Run { .. } => {}
        }
        self.lead(|_, way, _| way.begin());
    }

    /// Reports the frame that a run has reached, if it is a new one.
    fn tell_frame(&mut self, time: f64) {
        let Course::Runs(run) = &mut self.course else { return };
        let Kind::Run { .. } = run.job.kind else { return };
        let moment = run.job.moment(time);
        self.film = moment;
        let frame = steps(if run.job.to < run.job.from { moment.ceil() } else { moment.floor() });
        if run.told == Some(frame) {
            return;
        }
        run.told = Some(frame);
        self.at_frame(frame);
        self.report = Some(Input::Rig(Report::AtFrame(FrameNumber(frame))));
    }

    /// Does everything that follows the motors at a frame: photos, outputs and lights.
    fn at_frame(&mut self, frame: i32) {
        let Course::Runs(Run { job: Job { kind: Kind::Run { sync, shutter, .. }, .. }, .. }) = &self.course else {
            return;
        };
        if let Some(open) = shutter {
            self.camera.open(self.clock, Some(*open), Some(frame));
        }
        if *sync {
            let (mask, on) = (self.store.mask(), self.store.triggers(FrameNumber(frame)));
            self.outputs = Triggers(self.outputs.0 & !mask.0 | on.0);
            for (channel, level) in (1..).zip(&mut self.levels) {
                let channel = dmc_proto::message::DmxChannel(channel);
                *level = self.store.level(channel, FrameNumber(frame)).unwrap_or(*level);
            }
        }
        debug!(frame, "a frame");
    }

    /// Ends a pass. The machine decides what follows.
    fn end_pass(&mut self) {
        self.lead(|job, way, store| job.along(way, job.seconds, store));
        let Course::Runs(run) = &self.course else { return };
        let to = run.job.to;
        self.film = run.job.film;
        info!(to, "a pass ends");
        self.at_frame(to);
        self.report = Some(Input::Rig(Report::PassEnd));
    }

    /// Continues when the motors rest after a pass: they return to its last frame, or go to the start of the next pass.
    fn rolled(&mut self) {
        self.lead(|job, way, _| way.rolls_down(job.down, job.down));
        let Course::Runs(run) = &mut self.course else { return };
        if let Some((from, to)) = run.next.take() {
            run.job.turn(from, to, &self.store);
            (run.phase, run.told) = (Phase::Back, None);
            let goals: Vec<_> = run.job.ways.iter().map(|way| (way.motor, way.before(run.job.up))).collect();
            for (motor, goal) in goals {
                self.send_to(motor, goal);
            }
            return;
        }
        let quirks = self.setup.options.quirks();
        let is_shot = matches!(run.job.kind, Kind::Shot { .. });
        let end = FrameNumber(run.job.to);
        let stays = is_shot && quirks.contains(Quirks::STAYS_AFTER_SHOT);
        let motors: Vec<_> = run.job.ways.iter().map(|way| way.motor).collect();
        self.course = Course::Free;
        self.left.take();
        if stays {
            for motor in motors.iter().filter_map(|motor| index(*motor)) {
                self.motors[motor].halt(self.clock);
            }
            self.owes_rest = true;
            return;
        }
        for motor in motors {
            // A motor that is no part of the move stays where it is.
            let goal = self.store.position(motor, end).map_or(self.place(motor), f64::from);
            self.send_to(motor, goal);
        }
        self.owes_rest = true;
    }
}
