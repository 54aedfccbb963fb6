//! Motors as they really stand. A motor that is not enabled gets no pulses, although the device counts its ways.

use dmc_proto::message::MotorFlags;
use motion_core::time::Millis;

use super::setup::Tuning;
use crate::motor::Motor;

/// Motors as they really stand. They are empty while every motor was always enabled: then they are the ones that the device
/// counts.
#[derive(Debug)]
pub(super) struct Carriages {
    /// Whether motors that are not enabled move as well.
    moves_disabled: bool,
    motors: Vec<Motor>,
    /// Positions that the device counts too far, for each motor.
    offsets: Vec<f64>,
}

impl Carriages {
    pub(super) const fn new(moves_disabled: bool) -> Self {
        Self { moves_disabled, motors: Vec::new(), offsets: Vec::new() }
    }

    /// The motors as they stand, if these are not the ones that the device counts.
    pub(super) fn motors(&self) -> Option<&[Motor]> {
        (!self.motors.is_empty()).then_some(&self.motors)
    }

    /// Lets the motors that are enabled move as the device counts, and the others rest.
    pub(super) fn follow(&mut self, now: Millis, counted: &[Motor], tuning: &[Tuning]) {
        let is_enabled = |tuning: &Tuning| tuning.flags.contains(MotorFlags::ENABLED);
        if self.motors.is_empty() {
            if self.moves_disabled || tuning.iter().all(is_enabled) {
                return;
            }
            self.motors = counted.to_vec();
            self.offsets = vec![0.0; counted.len()];
        }
        let places = self.motors.iter_mut().zip(&mut self.offsets);
        for ((motor, offset), (counted, tuning)) in places.zip(counted.iter().zip(tuning)) {
            let here = counted.at(now).position;
            if is_enabled(tuning) {
                motor.clone_from(counted);
                if *offset != 0.0 {
                    motor.rebase(now, here - *offset);
                }
            } else {
                motor.halt(now);
                motor.advance(now);
                *offset = here - motor.at(now).position;
            }
        }
    }
}
