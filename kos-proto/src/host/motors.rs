//! The motors that a client knows, and what it does with them by hand.
//!
//! Commands to one motor are not sent faster than the device bears: of those that come too fast, the last one counts. A
//! stop overtakes them all, and is sent again until the motor says that it rests.

use arrayvec::ArrayVec;
use motion_core::time::Millis;

use super::io::{Event, Go, Refusal};
use super::send::Send;
use super::{Options, Output};
use crate::message::{
    Motor, MotorAddress, MotorCalibrated, MotorPlace, Rotations, RotationsPerSecond, RotationsPerSecondSquared,
    SetPositionSpeedAcceleration,
};
use crate::summary::{MOTORS, MotorSet};

/// A motor, and what it was told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Known {
    motor: Motor,
    hand: Hand,
}

/// What a motor was told by hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
struct Hand {
    motion: Motion,
    /// When the next command may be sent.
    next: Option<Millis>,
    /// The command that waits for it.
    wanted: Option<Send>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
enum Motion {
    /// It rests, as far as anybody said.
    #[default]
    Resting,
    /// It goes where it was sent, and will say that it rests; when that would be late.
    Going(Option<Millis>),
    /// It runs until it is stopped, as long as the application says something.
    Jogging,
    /// It was told to stop; when that is sent again.
    Stopping(Millis),
}

/// All motors of the device.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub(super) struct Motors {
    list: ArrayVec<Known, MOTORS>,
    /// Those that the series told of that is under way.
    told: MotorSet,
    /// When the application has said nothing for too long, while a motor jogs.
    alive_until: Option<Millis>,
}

impl Motors {
    pub(super) fn iter(&self) -> impl Iterator<Item = &Motor> {
        self.list.iter().map(|known| &known.motor)
    }

    fn find(&mut self, motor: MotorAddress) -> Option<&mut Known> {
        self.list.iter_mut().find(|known| known.motor.motor_address.number() == motor.number())
    }

    pub(super) fn get(&self, motor: MotorAddress) -> Option<&Motor> {
        self.iter().find(|known| known.motor_address.number() == motor.number())
    }

    /// A series begins.
    pub(super) fn begin_series(&mut self) {
        self.told = MotorSet::NONE;
    }

    /// The series goes on; `false` if there is no room, or no motor can have the address.
    pub(super) fn learn(&mut self, motor: Motor) -> bool {
        if MotorSet::of([motor.motor_address]).is_empty() {
            return false;
        }
        self.told.insert(motor.motor_address);
        if let Some(known) = self.find(motor.motor_address) {
            known.motor = motor;
            return true;
        }
        self.list.try_push(Known { motor, hand: Hand::default() }).is_ok()
    }

    /// The series ends: who was not in it is not there.
    pub(super) fn end_series(&mut self) {
        let told = self.told;
        self.list.retain(|known| told.contains(known.motor.motor_address));
        self.told = MotorSet::NONE;
    }

    /// A motor is not there any more.
    pub(super) fn forget(&mut self, motor: MotorAddress) {
        self.list.retain(|known| known.motor.motor_address.number() != motor.number());
    }

    /// A motor is somewhere.
    pub(super) fn is_at(&mut self, place: MotorPlace) {
        if let Some(known) = self.find(place.motor_address()) {
            known.motor.position = place.position();
        }
    }

    /// A motor rests. One that jogs does not, unless it was told to stop: what is said of it is of before. Nor does one
    /// that is told to go on as soon as may be.
    pub(super) fn rests(&mut self, motor: MotorAddress, position: Rotations) {
        if let Some(known) = self.find(motor) {
            known.motor.position = position;
            if known.hand.motion != Motion::Jogging && known.hand.wanted.is_none() {
                known.hand.motion = Motion::Resting;
            }
        }
        self.watch();
    }

    pub(super) fn calibrated(&mut self, message: &MotorCalibrated<'_>) {
        if let Some(Known { motor, .. }) = self.find(message.motor_address) {
            motor.end_position = message.end_position;
            motor.begin_position = message.begin_position.or(motor.begin_position);
        }
    }

    /// A motor lost its range, and stands.
    pub(super) fn lost_range(&mut self, motor: MotorAddress) {
        if let Some(known) = self.find(motor) {
            known.motor.end_position = Rotations(0.0);
        }
    }

    /// Whether a motor does not rest, as far as anybody said.
    pub(super) fn moves(&self, motor: MotorAddress) -> bool {
        let is_it = |known: &&Known| known.motor.motor_address.number() == motor.number();
        self.list.iter().find(is_it).is_some_and(|known| known.hand.motion != Motion::Resting)
    }

    pub(super) fn any_moves(&self) -> bool {
        self.list.iter().any(|known| known.hand.motion != Motion::Resting)
    }

    /// Sends a motor to a position, or soon.
    pub(super) fn move_to(
        &mut self,
        now: Millis,
        output: &mut Output,
        options: &Options,
        go: Go,
    ) -> Result<(), Refusal> {
        let known = self.find(go.motor).ok_or(Refusal::NoMotor)?;
        if matches!(known.hand.motion, Motion::Jogging | Motion::Stopping(_)) {
            return Err(Refusal::Moves);
        }
        known.hand.motion = Motion::Going(Some(now.after(options.setup_timeout)));
        known.hand.command(now, output, options, Send::MoveTo(go));
        Ok(())
    }

    /// Sends a motor a distance, once: from where it does not rest, nobody knows where that would be.
    pub(super) fn bump(&mut self, now: Millis, output: &mut Output, options: &Options, go: Go) -> Result<(), Refusal> {
        let known = self.find(go.motor).ok_or(Refusal::NoMotor)?;
        if known.hand.motion != Motion::Resting {
            return Err(Refusal::Moves);
        }
        known.hand.motion = Motion::Going(Some(now.after(options.setup_timeout)));
        output.send(Send::Bump(go));
        Ok(())
    }

    /// Lets a motor run.
    pub(super) fn jog(
        &mut self,
        now: Millis,
        output: &mut Output,
        options: &Options,
        jog: &SetPositionSpeedAcceleration<'_>,
    ) -> Result<(), Refusal> {
        let known = self.find(jog.motor_address).ok_or(Refusal::NoMotor)?;
        if matches!(known.hand.motion, Motion::Going(_) | Motion::Stopping(_)) {
            return Err(Refusal::Moves);
        }
        known.hand.motion = Motion::Jogging;
        known.hand.command(now, output, options, Send::MoveTo(go_of(jog)));
        self.alive(now, options);
        Ok(())
    }

    /// The application is there.
    pub(super) fn alive(&mut self, now: Millis, options: &Options) {
        let jogs = self.list.iter().any(|known| known.hand.motion == Motion::Jogging);
        self.alive_until = jogs.then(|| now.after(options.dead_man));
    }

    /// Nobody has to be watched, if nothing jogs.
    fn watch(&mut self) {
        if !self.list.iter().any(|known| known.hand.motion == Motion::Jogging) {
            self.alive_until = None;
        }
    }

    /// Stops a motor, at once; what waits is forgotten.
    pub(super) fn stop(&mut self, now: Millis, output: &mut Output, options: &Options, motor: MotorAddress) {
        match self.find(motor) {
            Some(known) => {
                known.hand.motion = Motion::Stopping(now.after(options.stop_timeout));
                output.send(known.stop());
            }
            None => output.send(Send::MoveTo(stop_of(motor, None))),
        }
        self.watch();
    }

    /// Stops all motors, at once. Whether those rest that rested anyway need not be confirmed.
    pub(super) fn stop_all(&mut self, now: Millis, output: &mut Output, options: &Options) {
        for known in &mut self.list {
            if known.hand.motion != Motion::Resting {
                known.hand.motion = Motion::Stopping(now.after(options.stop_timeout));
            }
            output.send(known.stop());
        }
        self.alive_until = None;
    }

    /// The connection is lost: what moves now, nobody knows.
    pub(super) fn lost(&mut self, output: &mut Output) {
        for known in &mut self.list {
            if let Motion::Stopping(_) = known.hand.motion {
                output.event(Event::StopNotConfirmed(Some(known.motor.motor_address)));
            }
            known.hand = Hand::default();
        }
        (self.told, self.alive_until) = (MotorSet::NONE, None);
    }

    /// Deals with the deadlines that have come.
    pub(super) fn wake(&mut self, now: Millis, output: &mut Output, options: &Options) {
        if self.alive_until.is_some_and(|until| until <= now) {
            output.event(Event::DeadMan);
            for known in self.list.iter_mut().filter(|known| known.hand.motion == Motion::Jogging) {
                known.hand.motion = Motion::Stopping(now.after(options.stop_timeout));
                output.send(known.stop());
            }
            self.alive_until = None;
        }
        for known in &mut self.list {
            let motor = known.motor.motor_address;
            match known.hand.motion {
                Motion::Stopping(again) if again <= now => {
                    known.hand.motion = Motion::Stopping(now.after(options.stop_timeout));
                    output.event(Event::StopNotConfirmed(Some(motor)));
                    output.send(known.stop());
                }
                Motion::Going(Some(late)) if late <= now => {
                    known.hand.motion = Motion::Going(None);
                    output.event(Event::MotorSlow(motor));
                }
                _ => {}
            }
            if known.hand.next.is_some_and(|next| next <= now) {
                known.hand.next = None;
                if let Some(wanted) = known.hand.wanted.take() {
                    known.hand.command(now, output, options, wanted);
                }
            }
        }
    }

    pub(super) fn deadline(&self) -> Option<Millis> {
        let hands = self.list.iter().filter_map(|known| known.hand.deadline());
        hands.chain(self.alive_until).min()
    }
}

impl Hand {
    fn command(&mut self, now: Millis, output: &mut Output, options: &Options, send: Send) {
        if self.next.is_some_and(|next| next > now) {
            self.wanted = Some(send);
        } else {
            output.send(send);
            self.next = Some(now.after(options.motor_interval));
        }
    }

    fn deadline(&self) -> Option<Millis> {
        let motion = match self.motion {
            Motion::Stopping(again) => Some(again),
            Motion::Going(late) => late,
            Motion::Resting | Motion::Jogging => None,
        };
        motion.into_iter().chain(self.next).min()
    }
}

impl Known {
    fn stop(&mut self) -> Send {
        (self.hand.wanted, self.hand.next) = (None, None);
        Send::MoveTo(stop_of(self.motor.motor_address, Some(&self.motor)))
    }
}

/// A stop at the last known place, with the greatest acceleration (safety decision 3).
fn stop_of(motor: MotorAddress, known: Option<&Motor>) -> Go {
    let acceleration = known.map_or(RotationsPerSecondSquared(0.0), |known| known.max_max_acceleration);
    let motor = MotorAddress(motor.number());
    go_of(&SetPositionSpeedAcceleration::stop(motor, known.and_then(Motor::relative_position), acceleration))
}

fn go_of(message: &SetPositionSpeedAcceleration<'_>) -> Go {
    let SetPositionSpeedAcceleration { motor_address, position, speed, acceleration, tail: _ } = *message;
    Go { motor: motor_address, position, speed, acceleration }
}

/// A command that is worth sending: to a motor's plain number, with numbers that mean something (decision K-N1).
pub(super) fn checked(go: Go) -> Result<Go, Refusal> {
    let positive = |number: f32| number.is_finite() && number > 0.0;
    if go.position.0.is_finite() && positive(go.speed.0) && positive(go.acceleration.0) {
        Ok(Go { motor: MotorAddress(go.motor.number()), ..go })
    } else {
        Err(Refusal::Number)
    }
}

/// A jog that is worth sending.
pub(super) fn checked_jog(
    motor: MotorAddress,
    speed: RotationsPerSecond,
    acceleration: RotationsPerSecondSquared,
) -> Result<SetPositionSpeedAcceleration<'static>, Refusal> {
    let jog = SetPositionSpeedAcceleration::jog(MotorAddress(motor.number()), speed, acceleration);
    checked(go_of(&jog)).map(|_| jog)
}
