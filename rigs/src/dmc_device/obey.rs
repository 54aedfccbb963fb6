//! Events of the machine, carried out by the motors.

use dmc_proto::device::{Event, Input, Report, State, StopKind};
use dmc_proto::message::{
    Acceleration, CameraFlags, FrameNumber, HostMessage, JogSpeed, Motor as Number, MotorSetSpeed, Speed, Steps,
};
use motion_core::time::Millis;
use tracing::{debug, info, warn};

use super::core::Core;
use super::course::Course;
use super::index;
use super::job::Kind;
use super::setup::Tuning;
use crate::motor::{Motor, Place};
use crate::seconds;

/// Least speed and acceleration of a jog that lasts a while, in steps per second.
const SLOWEST: f64 = 4.0;

/// Deceleration of a stop. A motor stops within a second, even if it was set to a lower acceleration.
fn soft(now: Millis, motor: &Motor, tuning: &Tuning) -> f64 {
    f64::from(tuning.acceleration.0).max(motor.at(now).velocity.abs())
}

impl Core {
    pub(super) fn obey(&mut self, event: Event<'_>) {
        match event {
            Event::Stop(stop) => self.stop(stop),
            Event::TriggersOff => self.outputs.0 &= !self.store.mask().0,
            Event::Apply(message) => self.apply(&message),
            Event::Store { store, message } => {
                let code = self.store.receive(&message);
                self.report = Some(Input::Rig(Report::Stored(store, code)));
            }
            Event::Move(motor, to) => {
                info!(%motor, %to, "goes");
                self.cut_in();
                self.send_to(motor, to.0.into());
            }
            Event::Jog(motor, speed, to) => self.jog(motor, speed, to),
            Event::ToFrame(frame) => self.go_to_frame(frame),
            Event::JogAll(rate, to) => {
                info!(%rate, %to, "all motors jog");
                self.jog_all(f64::from(rate.0.0) / 1000.0, to);
            }
            Event::Prepare(message) => self.prepare(&message),
            Event::Go => {
                info!("go");
                self.go();
            }
            Event::NextPass(from, to) => self.next_pass(from, to),
            Event::PostRoll => {
                if self.camera.is_filming {
                    info!("the camera stops");
                    self.camera.is_filming = false;
                }
            }
            Event::LastPass => info!("this is the last pass"),
            Event::Unlocked => info!("takes requests again"),
            Event::Acknowledgement(..) | Event::UnexpectedReport => debug!(?event, "ignored"),
            // This rig has no virtual motors. The machine refuses what would move them.
            _ => warn!(?event, "unknown"),
        }
    }

    fn stop(&mut self, stop: StopKind) {
        info!(?stop, "stops");
        let now = self.clock;
        if let StopKind::Motor(number) = stop {
            self.stop_one(number);
        } else if !matches!(stop, StopKind::Hard) && self.setup.facts.vendor_jog_all && self.land() {
            let led = self.led();
            for motor in (1..=self.count()).map(Number).filter(|motor| !led.contains(motor)) {
                self.stop_one(motor);
            }
            self.camera.is_filming = false;
        } else {
            // A motor without a given deceleration stops as hard as it can.
            let is_soft = matches!(stop, StopKind::All { .. });
            for (motor, tuning) in self.motors.iter_mut().zip(&self.tuning) {
                motor.stop(now, is_soft.then(|| soft(now, motor, tuning)));
            }
            self.course = Course::Free;
            self.left.take();
            if self.setup.facts.leaves_shutter_open {
                self.camera.stay_open();
            } else {
                self.camera.close(now);
            }
            self.camera.is_filming = false;
        }
        self.owes_rest = true;
    }

    fn stop_one(&mut self, number: Number) {
        let now = self.clock;
        let place = index(number).and_then(|index| self.motors.get_mut(index).zip(self.tuning.get(index)));
        if let Some((motor, tuning)) = place {
            motor.stop(now, Some(soft(now, motor, tuning)));
        }
        self.owes_rest = true;
    }

    fn tuned(&self, motor: Number) -> Option<Tuning> {
        self.tuning.get(index(motor)?).copied()
    }

    /// Sends a motor to a position, with the speed that was set.
    pub(super) fn send_to(&mut self, motor: Number, to: f64) {
        self.send_at(motor, to, 1.0);
    }

    /// Sends a motor to a position, with a part of its speed and acceleration. To slow down or to turn round, the motor
    /// uses its whole acceleration, and more if a limit that was set is too near for that.
    fn send_at(&mut self, motor: Number, to: f64, part: f64) {
        let (now, tuning) = (self.clock, self.tuned(motor));
        let motor = index(motor).and_then(|index| self.motors.get_mut(index));
        if let (Some(motor), Some(tuning)) = (motor, tuning) {
            let Place { position, velocity } = motor.at(now);
            let (speed, acceleration) = (part * f64::from(tuning.speed.0), f64::from(tuning.acceleration.0));
            let slows_down = velocity.abs() > speed || velocity * (to - position) < 0.0;
            let acceleration = if slows_down { acceleration } else { part * acceleration };
            let limit = if velocity > 0.0 { tuning.upper } else { tuning.lower };
            let room = limit.map(|limit| ((f64::from(limit.0) - position) * velocity.signum()).max(0.0));
            let needed = room.filter(|_| velocity != 0.0).map_or(0.0, |room| velocity * velocity / (2.0 * room));
            motor.go_to(now, to, speed, acceleration.max(needed));
            self.owes_rest = true;
        }
    }

    /// Jogs a motor. A jog ends at a limit that was set. A motor beyond that limit stays where it is.
    fn jog(&mut self, motor: Number, speed: JogSpeed, to: Steps) {
        info!(%motor, %speed, %to, "jogs");
        self.cut_in();
        let Some(tuning) = self.tuned(motor) else { return };
        let (here, wanted) = (self.place(motor), f64::from(to.0));
        let (lower, upper) = if self.setup.facts.ignores_limits { (None, None) } else { (tuning.lower, tuning.upper) };
        let goal = if wanted > here {
            upper.map_or(wanted, |upper| wanted.min(f64::from(upper.0)).max(here))
        } else {
            lower.map_or(wanted, |lower| wanted.max(f64::from(lower.0)).min(here))
        };
        let part = f64::from(speed.0.0) / f64::from(JogSpeed::FULL.0.0);
        match self.setup.facts.jog_lasts {
            Some(lasts) => self.jog_a_while(motor, goal, part, seconds(Millis(lasts))),
            None => self.send_at(motor, goal, part),
        }
    }

    /// Jogs a motor for a time in seconds, after which it slows down, but no further than to a goal.
    fn jog_a_while(&mut self, motor: Number, goal: f64, part: f64, lasts: f64) {
        let now = self.clock;
        let Some((tuning, moved)) = self.tuned(motor).zip(index(motor).and_then(|index| self.motors.get_mut(index)))
        else {
            return;
        };
        let Place { position, velocity } = moved.at(now);
        let way = (goal - position).signum();
        if velocity * way < 0.0 {
            return self.stop_one(motor);
        }
        let (full, hardest) = (f64::from(tuning.speed.0), f64::from(tuning.acceleration.0));
        let (from, to) = (velocity.abs(), (full * part).max(SLOWEST));
        let acceleration = (hardest * part).max(SLOWEST).max(from * hardest / full);
        let rising = ((to - from) / acceleration).clamp(0.0, lasts);
        let reached = from + acceleration * rising;
        let room = f64::midpoint(from, reached) * rising
            + reached * (lasts - rising)
            + reached * reached / (2.0 * acceleration);
        let room = room.round().min((goal - position).abs());
        moved.go_to(now, position + way * room, to, acceleration);
        self.owes_rest = true;
    }

    /// Ends the run or shot that waits or runs, if the machine ended it.
    fn cut_in(&mut self) {
        if self.state != State::Moving || !matches!(self.course, Course::Ready(_) | Course::Runs(_)) {
            return;
        }
        for motor in self.led() {
            self.stop_one(motor);
        }
        self.course = Course::Free;
    }

    fn go_to_frame(&mut self, frame: FrameNumber) {
        info!(%frame, "all motors go to a frame");
        self.course = Course::Free;
        let axes: Vec<_> = self.axes().collect();
        for motor in axes {
            if let Some(to) = self.store.position(motor, frame) {
                self.send_to(motor, to.into());
            }
        }
        self.owes_rest = true;
    }

    fn prepare(&mut self, message: &HostMessage<'_>) {
        self.owes_rest = true;
        let Some(job) = self.job(message) else { return };
        info!(from = job.from, to = job.to, "gets ready");
        self.left.replace(Some(job.clone()));
        if matches!(job.kind, Kind::Run { .. }) && self.setup.facts.jogs_to_run {
            // The rest of the way follows when all motors have come to the first frame.
            return self.jog_all(job.rate, FrameNumber(job.from));
        }
        for way in &job.ways {
            self.send_to(way.motor, way.before(job.up));
        }
        self.course = Course::Ready(job);
    }

    /// Sets the values of a message.
    fn apply(&mut self, message: &HostMessage<'_>) {
        info!("sets {message}");
        let now = self.clock;
        match message {
            HostMessage::MotorResetPosition(it) => {
                if let Some(motor) = index(it.motor).and_then(|index| self.motors.get_mut(index)) {
                    motor.rebase(now, it.position.0.into());
                }
            }
            HostMessage::MotorConfigure(it) => self.tune(it.motor, |tuning| tuning.flags = it.flags),
            HostMessage::MotorSetSpeed(MotorSetSpeed { motor, max_velocity, max_accel, .. }) => {
                // The vendor's firmware replaces zeros in this way.
                let speed = max_velocity.0.max(10);
                let acceleration = if max_accel.0 == 0 { speed / 2 } else { max_accel.0 };
                self.tune(*motor, |tuning| {
                    (tuning.speed, tuning.acceleration) = (Speed(speed), Acceleration(acceleration));
                });
            }
            HostMessage::MotorSetLimits(it) => self.tune(it.motor, |tuning| {
                tuning.lower = it.lower_enable.get().then_some(it.lower);
                tuning.upper = it.upper_enable.get().then_some(it.upper);
            }),
            HostMessage::GioOut(it) => self.outputs = it.triggers,
            HostMessage::GioCam(it) if it.flags.contains(CameraFlags::SHUTTER) => self.camera.open(now, None, None),
            HostMessage::GioCam(_) => self.camera.close(now),
            HostMessage::Dmx(it) => {
                let first = usize::from(it.start_channel.0).saturating_sub(1);
                for (place, level) in self.levels.iter_mut().skip(first).zip(it.values) {
                    *place = *level;
                }
            }
            _ => {}
        }
    }

    fn tune(&mut self, motor: Number, how: impl FnOnce(&mut Tuning)) {
        if let Some(tuning) = index(motor).and_then(|index| self.tuning.get_mut(index)) {
            how(tuning);
        }
    }
}
