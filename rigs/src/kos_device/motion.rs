//! Motors of a device: they follow curves, go to places, and come to rest.

use kos_proto::device::Report;
use kos_proto::message::{ErrorCode, MotorAddress, MotorSet, Normalized};
use motion_core::time::Millis;
use tracing::{info, warn};

use super::playing::Stage;
use super::{KosDevice, rotations};
use crate::TICK;
use crate::motor::Happening;

/// Distance of a motor from its place that is not an error but rounding, in rotations.
///
/// A motor leaves its move if the next place is further away than the motor can go in a tick.
const SLACK: f64 = 1e-3;

impl KosDevice {
    /// Does what is due at a moment, and nothing that is due later.
    pub(super) fn tick(&mut self, now: Millis) {
        self.now = now;
        if self.starts.is_some_and(|starts| starts <= now) {
            self.starts = None;
            info!("the device runs");
            self.told(Report::Started);
            self.work(now);
        }
        let lost = self.follow(now);
        let happened: Vec<_> =
            self.addresses().zip(&mut self.motors).map(|(address, motor)| (address, motor.advance(now))).collect();
        for motor in lost {
            warn!("motor {motor} cannot follow its curve");
            self.report(now, Report::Fault(motor, ErrorCode::PVT_INTEGRITY));
        }
        for (motor, happened) in happened.into_iter().filter_map(|(motor, happened)| Some((motor, happened?))) {
            match happened {
                Happening::Rests => self.rests(now, motor),
                Happening::Tripped { upper } => {
                    warn!("motor {motor} ran into the {} end of its travel", if upper { "upper" } else { "lower" });
                    self.report(now, Report::Fault(motor, ErrorCode::FAULT));
                }
            }
        }
        if self.wake.is_some_and(|wake| wake <= now) {
            self.sync();
            self.work(now);
        }
        if self.playing.as_ref().is_some_and(|playing| playing.is_over(now)) {
            self.release(now);
        }
    }

    /// Leads the motors along their curves while a move is played. Returns the motors that cannot follow.
    fn follow(&mut self, now: Millis) -> Vec<MotorAddress> {
        let Some(playing) = self.playing.as_ref().filter(|playing| playing.runs()) else { return Vec::new() };
        let mut lost = Vec::new();
        for way in playing.ways() {
            let index = usize::from(way.motor.number()).wrapping_sub(1);
            let (Some(motor), Some(mut place)) = (self.motors.get_mut(index), playing.place(way, now)) else {
                continue;
            };
            let most = motor.limits().velocity;
            #[expect(clippy::cast_precision_loss, reason = "a tick is a millisecond")]
            let reach = most * TICK as f64 / 1000.0 * (1.0 + SLACK) + SLACK;
            if (place.position - motor.at(now).position).abs() > reach {
                motor.halt(now);
                lost.push(way.motor);
            } else {
                place.velocity = place.velocity.clamp(-most, most);
                motor.lead(place);
            }
        }
        lost
    }

    /// Lets the motors rest where they are on their curves, because the move is over.
    pub(super) fn release(&mut self, now: Millis) {
        let Some(playing) = self.playing.as_mut().filter(|playing| playing.runs()) else { return };
        playing.stage = Stage::At(playing.elapsed(now));
        for way in playing.ways() {
            if let Some(motor) = self.motors.get_mut(usize::from(way.motor.number()).wrapping_sub(1)) {
                motor.halt(now);
            }
        }
    }

    /// Reports that a motor rests, or that it did not get to where the move wants it.
    fn rests(&mut self, now: Millis, motor: MotorAddress) {
        let Some((this, drive)) = self.motor(motor) else { return };
        let position = this.at(now).position;
        let missed = drive.goal.take().is_some_and(|goal| (goal - position).abs() > SLACK);
        info!("motor {motor} rests at {position:.3}");
        if missed {
            warn!("motor {motor} did not get to where the move wants it");
            self.report(now, Report::CannotHome(motor));
        } else {
            self.report(now, Report::Arrived(motor, rotations(position)));
        }
    }

    /// Sends motors to where they are at a part of the move: as fast as they can, or at a part of their setup speed.
    pub(super) fn go_to_part(&mut self, now: Millis, part: f64, motors: MotorSet, speed: Option<Normalized>) {
        let Some(playing) = &mut self.playing else { return };
        playing.stage = Stage::At(part);
        for way in playing.ways().iter().filter(|way| motors.contains(way.motor)) {
            let index = usize::from(way.motor.number()).wrapping_sub(1);
            let (Some(motor), Some(drive)) = (self.motors.get_mut(index), self.drives.get_mut(index)) else { continue };
            let (Some(specs), Some(to)) = (self.specs.get(index), way.position(part)) else { continue };
            let speed = match speed {
                Some(part) => f64::from(part.0) * f64::from(specs.max_max_setup_speed.0),
                None => specs.max_max_move_speed.0.into(),
            };
            drive.goal = Some(to);
            motor.go_to(now, to, speed, specs.max_max_acceleration.0.into());
        }
    }

    /// Stops all motors as fast as they can, ends the move, and closes the shutter.
    pub(super) fn stop_all(&mut self, now: Millis) {
        self.playing = None;
        self.camera.close(now);
        for (motor, drive) in self.motors.iter_mut().zip(&mut self.drives) {
            drive.goal = None;
            motor.stop(now, None);
        }
    }
}
