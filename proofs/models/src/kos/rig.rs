//! Rig of one motor, as simple as possible: the motor rests, moves to a target, runs, or comes to rest.

use kos_proto::Millis;
use kos_proto::device::{Event, Report};
use kos_proto::host::Go;
use kos_proto::message::{MotorAddress, Rotations, RotationsPerSecond, RotationsPerSecondSquared};

/// The motor of the rig.
pub const MOTOR: MotorAddress = MotorAddress(1);
/// End of the motor's range. At first the motor rests at the begin of its range.
pub const RANGE: Rotations = Rotations(8.0);

pub(super) const SPEED: RotationsPerSecond = RotationsPerSecond(10.0);
pub(super) const ACCELERATION: RotationsPerSecondSquared = RotationsPerSecondSquared(20.0);

pub(super) const fn go(position: f32) -> Go {
    Go { motor: MOTOR, position: Rotations(position), speed: SPEED, acceleration: ACCELERATION }
}

/// Motion of the motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Motor {
    Rests,
    /// The motor moves to a target.
    Goes(Rotations),
    /// The motor comes to rest where it is.
    Stops,
}

/// State of the rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Rig {
    motor: Motor,
    at: Rotations,
    /// Time until which the rig plays a move without a stop.
    plays: Option<Millis>,
}

impl Rig {
    pub(super) const fn new() -> Self {
        Self { motor: Motor::Rests, at: Rotations(0.0), plays: None }
    }

    /// Whether the motor moves and has no command to stop.
    #[must_use]
    pub fn is_driven(&self, now: Millis) -> bool {
        self.is_playing(now) || matches!(self.motor, Motor::Goes(_))
    }

    /// Whether nothing moves.
    #[must_use]
    pub fn rests(&self, now: Millis) -> bool {
        !self.is_playing(now) && self.motor == Motor::Rests
    }

    fn is_playing(&self, now: Millis) -> bool {
        self.plays.is_some_and(|until| until > now)
    }

    /// Follows an event of the device; `false` if that would start a second motion.
    pub(super) fn follow(&mut self, now: Millis, event: &Event<'_>) -> bool {
        let (rests, plays) = (self.motor == Motor::Rests, self.is_playing(now));
        match *event {
            Event::Move { to, .. } => {
                self.motor = Motor::Goes(to);
                !plays
            }
            Event::StopMotor { .. } => {
                self.motor = Motor::Stops;
                !plays
            }
            Event::StopAll => {
                if self.is_driven(now) {
                    self.motor = Motor::Stops;
                }
                self.plays = None;
                true
            }
            Event::Home { .. } => {
                self.motor = Motor::Goes(Rotations(0.0));
                rests && !plays
            }
            Event::MoveToFrame { .. } => {
                self.motor = Motor::Goes(Rotations(1.0));
                rests && !plays
            }
            Event::Play { millis, .. } => {
                self.plays = Some(now.after(millis));
                rests && !plays
            }
            Event::MoveOver => {
                self.plays = None;
                true
            }
            _ => true,
        }
    }

    /// Lets the motor come to rest, if it moves to a target.
    pub(super) fn arrive(&mut self) -> Option<Report> {
        match self.motor {
            Motor::Rests => return None,
            Motor::Goes(to) => self.at = to,
            Motor::Stops => {}
        }
        self.motor = Motor::Rests;
        Some(Report::Arrived(MOTOR, self.at))
    }

    pub(super) fn can_arrive(&self) -> bool {
        self.motor != Motor::Rests
    }
}
