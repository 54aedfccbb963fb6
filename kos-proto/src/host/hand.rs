//! Motion of one motor by hand: what was sent, what waits, and what was reported.

use motion_core::time::Millis;

use super::event::{Event, Failure, Outcome, Refusal, StopTarget};
use super::input::Go;
use super::stops::{Stops, transmit_stop};
use super::transmit::Transmit;
use super::{Options, Output, Token};
use crate::message::{Motor, MotorAddress, MotorSet, RotationsPerSecondSquared, SetPositionSpeedAcceleration};

/// Motor of the device, and its motion by hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Followed {
    pub(super) motor: Motor,
    pub(super) hand: Hand,
}

/// Motion of a motor by hand.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(super) struct Hand {
    pub(super) motion: Motion,
    /// Time at which the next command may be sent.
    pub(super) next: Option<Millis>,
    /// Motion that waits for that time.
    pub(super) wanted: Option<Go>,
    /// Command that ends when the motor rests.
    pub(super) token: Option<Token>,
    /// Whether the last message about the motor sent it a distance.
    pub(super) is_bump: bool,
    /// Whether the motor went off line. It is dropped when it is known to rest.
    pub(super) is_gone: bool,
    /// Greatest number of reports that may still come about the motions that were sent; 255 counts for more. From 2 on, the
    /// next report may be about an earlier motion than the last.
    pub(super) unreported: u8,
}

motion_core::debug! { Hand { motion next wanted token is_bump is_gone unreported } }

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(super) enum Motion {
    /// The motor rests, as far as is known.
    #[default]
    Resting,
    /// The motor goes where it was sent, and will say that it rests; the time at which that is late.
    Going(Option<Millis>),
    /// The motor runs until it is stopped.
    Jogging,
    /// The motor was told to stop; the time at which that is sent again, and what was reported since.
    Stopping(Millis, Report),
}

/// Report on a motor that was told to stop.
///
/// It counts when a question is answered that was asked after the stop. Then no earlier report can come any more, which would
/// be taken for the end of the next motion (decision K-S22).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Report {
    /// No report came.
    None,
    /// A report came that may be about an earlier motion.
    Unclear,
    /// The motor rests.
    Rests,
}

impl Hand {
    /// Notes that the motor rests, or that nothing follows its motion any more.
    pub(super) fn reset(&mut self) {
        *self = Self { is_gone: self.is_gone, ..Self::default() };
    }

    /// Whether a command may be followed in this motion.
    pub(super) fn allows(&self, motion: impl Fn(Motion) -> bool) -> Result<(), Refusal> {
        match self.motion {
            allowed if motion(allowed) => Ok(()),
            Motion::Stopping(..) => Err(Refusal::Stopping),
            _ => Err(Refusal::Moves),
        }
    }

    /// Notes that the motor is sent on. If it may still move because of something else, a report may be about that.
    pub(super) fn send_on(&mut self, stops: &mut Stops, motor: MotorAddress) {
        if stops.sent_on(MotorSet::of([motor])) {
            self.unreported = self.unreported.max(1);
        }
    }

    pub(super) fn command(&mut self, now: Millis, output: &mut Output<'_>, options: &Options, go: Go) {
        if self.next.is_some_and(|next| next > now) {
            self.wanted = Some(go);
        } else {
            self.is_bump = false;
            self.transmit(output, Transmit::MoveTo(go));
            // The motion that waited is older.
            self.wanted = None;
            self.next = Some(now.after(options.motor_interval()));
        }
    }

    pub(super) fn transmit(&mut self, output: &mut Output<'_>, motion: Transmit<'static>) {
        self.unreported = self.unreported.saturating_add(1);
        output.transmit(motion);
    }

    /// Ends the command that waits for the motor, if there is one.
    pub(super) fn end(&mut self, output: &mut Output<'_>, outcome: Outcome<'static>) {
        if let Some(token) = self.token.take() {
            output.event(Event::ended(token, outcome));
        }
    }

    /// Takes a report that the motor rests. If the motor was sent on before, nobody knows which motion the report is
    /// about, unless everything was stopped meanwhile.
    pub(super) fn rests(&mut self, output: &mut Output<'_>, stops: &mut Stops, motor: MotorAddress) {
        let is_sure = self.unreported < 2 || stops.confirms(motor);
        if self.unreported != u8::MAX {
            self.unreported = self.unreported.saturating_sub(1);
        }
        match &mut self.motion {
            Motion::Stopping(_, report) if is_sure => *report = Report::Rests,
            Motion::Stopping(_, report @ Report::None) => *report = Report::Unclear,
            Motion::Going(_) if self.wanted.is_none() => {
                if !is_sure {
                    stops.lose(MotorSet::of([motor]));
                }
                self.motion = Motion::Resting;
                self.end(output, if is_sure { Outcome::Done(None) } else { Outcome::NotConfirmed });
            }
            Motion::Stopping(..) | Motion::Going(_) | Motion::Resting | Motion::Jogging => {}
        }
    }

    pub(super) fn deadline(&self) -> Option<Millis> {
        let motion = match self.motion {
            Motion::Stopping(again, _) => Some(again),
            Motion::Going(late) => late,
            Motion::Resting | Motion::Jogging => None,
        };
        motion.into_iter().chain(self.next).min()
    }
}

impl Followed {
    pub(super) fn stop(&mut self, now: Millis, output: &mut Output<'_>, options: &Options) {
        self.hand.motion = Motion::Stopping(now.after(options.stop_timeout()), Report::None);
        transmit_stop(output, self.stop_message());
    }

    /// Message that stops the motor. What waits is forgotten.
    pub(super) fn stop_message(&mut self) -> Transmit<'static> {
        (self.hand.wanted, self.hand.next, self.hand.is_bump) = (None, None, false);
        Transmit::MoveTo(stop_of(self.motor.motor_address, Some(&self.motor)))
    }

    /// Nothing follows the motor any more.
    pub(super) fn lose(&mut self, output: &mut Output<'_>, stops: &mut Stops, why: Failure) {
        let motor = MotorAddress(self.motor.motor_address.number());
        if self.hand.motion != Motion::Resting {
            stops.lose(MotorSet::of([motor]));
        }
        if let Motion::Stopping(..) = self.hand.motion {
            output.event(Event::StopNotConfirmed(StopTarget::Motor(motor)));
        }
        self.hand.end(output, Outcome::Failed(why));
        self.hand.reset();
    }
}

/// Stop at the last known position, with the greatest acceleration (safety decision 3).
pub(super) fn stop_of(motor: MotorAddress, known: Option<&Motor>) -> Go {
    let unknown = || SetPositionSpeedAcceleration::stop(motor, None, RotationsPerSecondSquared(0.0));
    go_of(&known.map_or_else(unknown, Motor::stop))
}

pub(super) fn go_of(message: &SetPositionSpeedAcceleration<'_>) -> Go {
    let SetPositionSpeedAcceleration { motor_address, position, speed, acceleration, tail: _ } = *message;
    Go { motor: motor_address, position, speed, acceleration }
}

/// Motion that is worth sending: to a motor's plain number, with numbers that mean something (decision K-N1).
pub(super) fn checked(go: Go) -> Result<Go, Refusal> {
    let positive = |number: f32| number.is_finite() && number > 0.0;
    if go.position.0.is_finite() && positive(go.speed.0) && positive(go.acceleration.0) {
        Ok(Go { motor: MotorAddress(go.motor.number()), ..go })
    } else {
        Err(Refusal::Number)
    }
}
