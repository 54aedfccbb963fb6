//! What all motors do together, moment by moment.

use dmc_proto::device::Input;
use dmc_proto::message::{FrameNumber, Motor as Number, RunFlags, Triggers};
use motion_core::profile::Limits;
use tracing::{debug, info, warn};

use super::core::Core;
use super::job::{Job, Kind, Way};
use super::store::Store;
use super::{index, steps};
use crate::motor::{Motor, Place};
use crate::seconds;

/// Seconds in which a jog of all motors gets up to speed.
const JOG_ROLL: f64 = 0.5;

/// What all motors do together.
#[derive(Debug, Clone)]
pub(super) enum Course {
    /// Nothing: each of them goes where it was sent.
    Free,
    /// They run along the uploaded move. The frame moves as a motor does.
    JogAll { frame: Motor, told: i32 },
    /// They go to where this begins, or wait there.
    Ready(Job),
    /// This runs.
    Runs(Run),
}

/// A run or a shot that has begun.
#[derive(Debug, Clone)]
pub(super) struct Run {
    job: Job,
    phase: Phase,
    /// When the phase began, in seconds.
    since: f64,
    /// The frame that was told last.
    told: Option<i32>,
    /// Where the next pass begins and ends, if another one follows.
    next: Option<(i32, i32)>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// The motors get up to speed.
    Up,
    Pass,
    /// They come to rest.
    Down,
    /// They go to where the next pass begins.
    Back,
}

impl Course {
    /// Whether time alone changes something.
    pub(super) const fn is_busy(&self) -> bool {
        matches!(self, Self::JogAll { .. } | Self::Runs(_))
    }
}

impl Core {
    /// How far the move is.
    pub(super) fn moment(&self) -> Option<f64> {
        match &self.course {
            Course::JogAll { frame, .. } => Some(frame.at(self.clock).position),
            Course::Runs(Run { job, phase: Phase::Pass, since, .. }) => Some(job.moment(seconds(self.clock) - since)),
            _ => None,
        }
    }

    /// Starts what is ready.
    pub(super) fn go(&mut self) {
        if let Course::Ready(job) = std::mem::replace(&mut self.course, Course::Free) {
            let since = seconds(self.clock);
            self.course = Course::Runs(Run { job, phase: Phase::Up, since, told: None, next: None });
            // With no time to get up to speed, it begins at once.
            self.follow();
        }
    }

    /// The next pass of the run, behind this one.
    pub(super) fn next_pass(&mut self, from: FrameNumber, to: FrameNumber) {
        if let Course::Runs(run) = &mut self.course {
            run.next = Some((from.0, to.0));
        }
    }

    /// Runs all motors of the uploaded move along it.
    pub(super) fn jog_all(&mut self, rate: f64, to: FrameNumber) {
        let now = self.clock;
        let limits = Limits { velocity: rate, acceleration: rate / JOG_ROLL, jerk: None };
        let mut frame = Motor::new(limits);
        if let Course::JogAll { frame: before, .. } = &self.course {
            frame.lead(before.at(now));
        } else {
            frame.rebase(now, f64::from(self.stood_on.unwrap_or(to).0));
        }
        let told = steps(frame.at(now).position);
        frame.go_to(now, f64::from(to.0), rate, rate / JOG_ROLL);
        self.course = Course::JogAll { frame, told };
    }

    /// Brings all motors to where they have to be just now.
    pub(super) fn follow(&mut self) {
        match &self.course {
            Course::JogAll { .. } => self.follow_jog(),
            Course::Runs(_) => while self.follow_run() {},
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
        for motor in (1..=self.count()).map(Number) {
            let Some(position) = self.store.between(motor, at) else { continue };
            let ahead = self.store.between(motor, at.floor() + 1.0).unwrap_or(position);
            let behind = self.store.between(motor, at.floor()).unwrap_or(position);
            self.lead_one(motor, Place { position, velocity: (ahead - behind) * velocity });
        }
        if !self.course.is_busy() {
            return;
        }
        if rests {
            for (number, motor) in (1..).map(Number).zip(&mut self.motors) {
                if self.store.has(number) {
                    motor.halt(now);
                }
            }
            self.course = Course::Free;
            self.owes_rest = true;
        } else if is_new {
            self.step(Input::AtFrame(FrameNumber(this)));
        }
    }

    /// Whether something ended, so that there is more to follow.
    fn follow_run(&mut self) -> bool {
        let now = seconds(self.clock);
        let Course::Runs(run) = &mut self.course else { return false };
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

    /// Puts each motor of the run where it has to be.
    fn lead(&mut self, place: impl Fn(&Job, &Way, &Store) -> Place) {
        let Course::Runs(run) = &self.course else { return };
        let places: Vec<_> = run.job.ways.iter().map(|way| (way.motor, place(&run.job, way, &self.store))).collect();
        for (motor, place) in places {
            self.lead_one(motor, place);
        }
    }

    /// Puts a motor where it has to be. One that cannot be so fast gets stuck.
    fn lead_one(&mut self, number: Number, place: Place) {
        let now = self.clock;
        let Some(motor) = index(number).and_then(|index| self.motors.get_mut(index)) else { return };
        if !self.course.is_busy() {
            // Another one got stuck just now, and all stop.
        } else if place.velocity.abs() <= motor.limits().velocity {
            motor.lead(place);
        } else {
            motor.halt(now);
            warn!(motor = %number, speed = place.velocity, "cannot follow, and is stuck");
            self.step(Input::Fault(Some(number)));
        }
    }

    fn begin_pass(&mut self) {
        let Course::Runs(run) = &self.course else { return };
        let job = &run.job;
        info!(from = job.from, to = job.to, seconds = job.seconds, "a pass begins");
        match &job.kind {
            Kind::Shot { exposure } => self.camera.open(self.clock, Some(*exposure), Some(job.from)),
            Kind::Run { flags, .. } if flags.contains(RunFlags::CAMERA_START_STOP) && !self.camera.is_filming => {
                self.camera.is_filming = true;
                info!("the camera films");
            }
            Kind::Run { .. } => {}
        }
        self.lead(|_, way, _| way.begin());
    }

    /// Tells the frame that a run has come to, if it is a new one.
    fn tell_frame(&mut self, time: f64) {
        let Course::Runs(run) = &mut self.course else { return };
        let Kind::Run { .. } = run.job.kind else { return };
        let moment = run.job.moment(time);
        let frame = steps(if run.job.to < run.job.from { moment.ceil() } else { moment.floor() });
        if run.told == Some(frame) {
            return;
        }
        run.told = Some(frame);
        self.at_frame(frame);
        self.step(Input::AtFrame(FrameNumber(frame)));
    }

    /// What runs along with the motors.
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

    /// The pass is over; what the machine makes of it, is obeyed in the same moment.
    fn end_pass(&mut self) {
        self.lead(|job, way, store| job.along(way, job.seconds, store));
        let Course::Runs(run) = &self.course else { return };
        let to = run.job.to;
        info!(to, "a pass ends");
        self.at_frame(to);
        self.step(Input::PassEnd);
    }

    /// The motors rest behind a pass: they return to its last frame, or go to where the next pass begins.
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
        let end = FrameNumber(run.job.to);
        let motors: Vec<_> = run.job.ways.iter().map(|way| way.motor).collect();
        self.course = Course::Free;
        for motor in motors {
            // One that followed no move stays where it is.
            let goal = self.store.position(motor, end).map_or(self.place(motor), f64::from);
            self.send_to(motor, goal);
        }
        self.owes_rest = true;
    }
}
