//! Motors of a node: motions that the machine asks for, and reports to it.

use hoot_proto::device::{Motion, MotorSettings, MotorState, ProgramState, Quirks};
use hoot_proto::message::{self, Direction, Microstep};
use motion_core::profile::Limits;
use motion_core::trajectory::Range;
use tracing::{debug, info, warn};

use super::{HootNode, Lead};
use crate::motor::{Happening, Motor, Place};

impl HootNode {
    /// Whether a motor moves, or the machine waits for a motor that is not plugged in.
    pub(super) fn is_moving(&self) -> bool {
        let waits = |motor: &message::Motor| self.machine().motor(*motor).is_moving();
        self.motors.iter().any(|motor| !motor.is_idle()) || !self.is_hung() && self.missing().iter().any(waits)
    }

    /// Motors that are not plugged in.
    fn missing(&self) -> &'static [message::Motor] {
        const ALL: &[message::Motor] = &message::Motor::ALL;
        ALL.get(self.motors.len()..).unwrap_or_default()
    }

    fn has_firmware_directions(&self) -> bool {
        self.copies(Quirks::FIRMWARE_DIRECTIONS)
    }

    /// Sign of a direction. The setting of the direction inverts nothing in firmware.
    fn way(&self, motor: message::Motor, direction: Direction) -> f64 {
        let setting = if self.has_firmware_directions() { Direction(0) } else { self.settings(motor).direction };
        if (direction.0 != 0) == (setting.0 != 0) { -1.0 } else { 1.0 }
    }

    fn settings(&self, motor: message::Motor) -> &MotorSettings {
        self.machine().motor(motor).settings()
    }

    /// Starts the motion that the machine asks for.
    pub(super) fn set_in_motion(&mut self, which: message::Motor, motion: Motion) {
        let index = index(which);
        let now = self.now;
        let settings = *self.settings(which);
        let speed = self.speed_of_moves(which);
        let Some(motor) = self.motors.get(index) else { return };
        let here = motor.at(now);
        let acceleration = f64::from(settings.acceleration.0.abs());
        let acceleration = if acceleration > 0.0 { acceleration } else { motor.limits().acceleration };
        if !matches!(motion, Motion::Power(_) | Motion::Rebase { .. }) {
            self.leads[index] = None;
        }
        match motion {
            Motion::Stop => {
                info!("motor {which} stops at {:.0}", here.position);
                self.motors[index].halt(now);
            }
            Motion::By { direction, steps } => {
                let to = here.position.round() + self.way(which, direction) * f64::from(steps.0);
                info!("motor {which} moves from {:.0} to {to:.0}", here.position);
                self.motors[index].go_to(now, to, speed, acceleration);
            }
            Motion::To(to) => self.send(which, to.0.into(), speed, acceleration),
            Motion::Run { direction, speed } => {
                self.ways[index] = self.way(which, direction);
                // A negative speed inverts a run of firmware when it is set on the way, not when the run begins.
                if self.has_firmware_directions() && speed.0 < 0.0 {
                    self.ways[index] = -self.ways[index];
                }
                let velocity = self.ways[index] * f64::from(speed.0);
                info!("motor {which} runs at {velocity:.0} a second");
                self.motors[index].run(now, velocity, acceleration);
            }
            Motion::Speed(speed) => {
                let velocity = self.ways[index] * f64::from(speed.0);
                self.motors[index].run(now, velocity, acceleration);
            }
            Motion::Along { plan, elapsed } => {
                info!("motor {which} follows its plan from {} to {} in {} ms", plan.start, plan.stop, plan.travel);
                self.lead(which, Lead { plan, elapsed, since: now });
            }
            Motion::Microstep(microstep) => self.rescale(which, microstep),
            Motion::Rebase { by } => {
                self.motors[index].rebase(now, here.position - f64::from(by.0));
                self.told[index] = round(self.motors[index].at(now).position);
                self.leads[index] = self.leads[index].map(|lead| lead.rebased(by));
            }
            Motion::Power(on) => debug!("motor {which}: current {}", if on { "on" } else { "off" }),
            _ => warn!("motor {which}: unknown motion {motion:?}"),
        }
    }

    /// Sends a motor to a position.
    fn send(&mut self, which: message::Motor, to: f64, speed: f64, acceleration: f64) {
        let motor = &mut self.motors[index(which)];
        let from = motor.at(self.now).position;
        debug!("motor {which} goes from {from:.0} to {to:.0}");
        motor.go_to(self.now, to, speed, acceleration);
    }

    /// Speed of moves to a position: the setting, or in a program the greatest speed.
    fn speed_of_moves(&self, which: message::Motor) -> f64 {
        let settings = self.settings(which);
        let (set, most) = (f64::from(settings.speed.0.abs()), f64::from(settings.max_step_speed.0));
        // The greatest speed of a motor limits nothing in firmware, except what the machine has set.
        if self.copies(Quirks::SENDS_FAST) {
            return set;
        }
        let is_program = self.machine().program().state() == ProgramState::Running;
        if is_program || set == 0.0 { most } else { set.min(most) }
    }

    fn lead(&mut self, which: message::Motor, lead: Lead) {
        let motor = &mut self.motors[index(which)];
        let position = motor.at(self.now).position;
        motor.lead(Place { position, velocity: 0.0 });
        self.leads[index(which)] = Some(lead);
        self.led_at[index(which)] = self.now;
    }

    /// Counts in the microsteps with which the machine begins.
    pub(super) fn take_first_microsteps(&mut self) {
        for which in message::Motor::ALL.into_iter().take(self.motors.len()) {
            let microstep = self.settings(which).microstep;
            if microstep != Microstep::QUARTER {
                self.rescale(which, microstep);
            }
        }
    }

    /// Counts positions in other microsteps. Limits and travel stay the same on the rig.
    fn rescale(&mut self, which: message::Motor, microstep: Microstep) {
        let index = index(which);
        let old = std::mem::replace(&mut self.microsteps[index], microstep);
        let scale = f64::from(microstep.0) / f64::from(old.0.max(1));
        // The machine has its position after all motions of this step already, such as that of a backlash.
        let position = (self.motors[index].at(self.now).position.round() * scale).trunc();
        let (limits, travel) = (self.motors[index].limits(), self.motors[index].travel());
        let scaled = Limits {
            velocity: limits.velocity * scale,
            acceleration: limits.acceleration * scale,
            jerk: limits.jerk.map(|jerk| jerk * scale),
        };
        let mut motor = Motor::new(scaled);
        if let Some(travel) = travel {
            motor = motor.within(Range::new(travel.from * scale, travel.to * scale));
        }
        motor.lead(Place { position, velocity: 0.0 });
        motor.halt(self.now);
        self.motors[index] = motor;
        self.told[index] = round(position);
    }

    /// Moves the motors up to the present time, and reports it to the machine.
    pub(super) fn move_motors(&mut self) {
        for index in 0..self.motors.len() {
            let which = message::Motor::ALL[index];
            self.follow(index);
            let first = self.motors[index].advance(self.now);
            self.report(which);
            let mut next = first;
            while let Some(happening) = next {
                self.happened(which, happening);
                next = self.motors[index].advance(self.now);
            }
        }
        for motor in self.missing() {
            if self.machine().motor(*motor).is_moving() {
                warn!("motor {motor} is not plugged in");
                self.tell(|session| session.fault(*motor));
            }
        }
    }

    /// Lets a motor follow its path, as far as it can go in the time since the last call.
    #[expect(clippy::cast_precision_loss, reason = "a short time")]
    fn follow(&mut self, index: usize) {
        let Some(lead) = self.leads[index] else { return };
        let motor = &mut self.motors[index];
        let here = motor.at(self.now).position;
        let there = lead.at(self.now);
        let seconds = self.now.since(self.led_at[index]) as f64 / 1000.0;
        self.led_at[index] = self.now;
        if seconds > 0.0 {
            // A motor moves by at least a step.
            let reach = (motor.limits().velocity * seconds).max(1.0);
            let position = here + (there - here).clamp(-reach, reach);
            motor.lead(Place { position, velocity: (position - here) / seconds });
        }
        if lead.is_over(self.now) && (motor.at(self.now).position - there).abs() < 1e-9 {
            self.leads[index] = None;
            motor.halt(self.now);
        }
    }

    /// Reports the position of a motor to the machine, if it has changed.
    fn report(&mut self, which: message::Motor) {
        let position = round(self.motors[index(which)].at(self.now).position);
        if std::mem::replace(&mut self.told[index(which)], position) != position {
            self.tell(|session| session.position(which, position.into()));
        }
    }

    fn happened(&mut self, which: message::Motor, happening: Happening) {
        match happening {
            // A motor that runs at speed 0 still runs, except in firmware.
            Happening::Rests if self.has_firmware_directions() && self.settings(which).speed.0 == 0.0 => {
                self.tell(|session| session.arrived(which));
            }
            Happening::Rests if self.machine().motor(which).state() != MotorState::Moving => {}
            Happening::Rests => {
                info!("motor {which} rests at {}", self.told[index(which)]);
                self.tell(|session| session.arrived(which));
            }
            Happening::Tripped { upper } => {
                let end = if upper { "upper" } else { "lower" };
                warn!("motor {which} reached the {end} end of its travel, at {}", self.told[index(which)]);
                self.leads[index(which)] = None;
                self.tell(|session| session.fault(which));
            }
        }
    }

    /// Lets the first motor that moves get stuck.
    pub(super) fn get_stuck(&mut self) {
        let moves = |motor: &message::Motor| self.motors.get(index(*motor)).is_some_and(|motor| !motor.rests());
        let Some(which) = message::Motor::ALL.into_iter().find(moves) else { return };
        warn!("motor {which} is stuck");
        self.leads[index(which)] = None;
        self.motors[index(which)].halt(self.now);
        self.report(which);
        self.tell(|session| session.fault(which));
    }
}

const fn index(motor: message::Motor) -> usize {
    motor as usize - 1
}

/// Step that is nearest to a position.
#[expect(clippy::cast_possible_truncation, reason = "positions outside the range count as its ends")]
fn round(position: f64) -> i32 {
    position.round() as i32
}
