//! Move that is played: where each motor is at any part of it.

use kos_proto::device::DeviceMachine;
use kos_proto::message::{Direction, MotorAddress};
use kos_proto::trajectory::{Trajectory, bezier};
use motion_core::time::Millis;

use crate::kos_host::StoredMove;
use crate::motor::Place;
use crate::seconds;

/// Move that is made ready or played.
#[derive(Debug, Clone)]
pub(super) struct Playing {
    ways: Vec<Way>,
    /// Duration of the move in seconds.
    seconds: f64,
    pub(super) stage: Stage,
}

/// Stage of a move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Stage {
    /// The motors go to this part of the move, or rest there.
    At(f64),
    /// The motors follow the curves.
    Runs { way: Direction, start: Millis, millis: u64 },
}

/// Way of a motor over its range, as the range was when the move was made ready.
#[derive(Debug, Clone)]
pub(super) struct Way {
    pub(super) motor: MotorAddress,
    /// Curves in parts of the move and of the range, one after the other.
    segments: Vec<bezier::Segment>,
    /// Begin of the range, as the rig counts.
    begin: f64,
    /// Length of the range.
    range: f64,
}

impl Playing {
    /// Stored move over the ranges that the machine knows. `told` gives the position of a motor that the machine was told
    /// last, as the rig counts.
    pub(super) fn new(
        stored: &StoredMove,
        machine: &DeviceMachine,
        told: impl Fn(MotorAddress) -> Option<f32>,
    ) -> Option<Self> {
        let data = stored.data();
        let trajectory = Trajectory::new(&data).ok()?;
        let ways = trajectory.tracks().filter_map(|track| {
            let motor = MotorAddress(track.motor().number());
            let drive = machine.motor(motor)?;
            let (begin, end) = drive.range();
            // Clients count from another place than the rig.
            let zero = f64::from(told(motor)?) - f64::from(drive.position().0);
            Some(Way {
                motor,
                segments: track.segments().collect(),
                begin: zero + f64::from(begin.0),
                range: f64::from(end.0) - f64::from(begin.0),
            })
        });
        Some(Self { ways: ways.collect(), seconds: trajectory.play().move_time(), stage: Stage::At(0.0) })
    }

    pub(super) fn ways(&self) -> &[Way] {
        &self.ways
    }

    /// Part of the move that is over at a time. It becomes less on the way back.
    pub(super) fn elapsed(&self, now: Millis) -> f64 {
        match self.stage {
            Stage::At(part) => part,
            Stage::Runs { way, start, millis } => {
                let part = (seconds(Millis(now.since(start))) / seconds(Millis(millis.max(1)))).min(1.0);
                if way == Direction::Forward { part } else { 1.0 - part }
            }
        }
    }

    /// Seconds of the move at a time.
    pub(super) fn moment(&self, now: Millis) -> f64 {
        self.elapsed(now) * self.seconds
    }

    /// Whether the motors follow the curves.
    pub(super) const fn runs(&self) -> bool {
        matches!(self.stage, Stage::Runs { .. })
    }

    /// Whether the curves are at their end.
    pub(super) fn is_over(&self, now: Millis) -> bool {
        matches!(self.stage, Stage::Runs { start, millis, .. } if now.since(start) >= millis)
    }

    /// Place of a motor at a time, as the rig counts.
    pub(super) fn place(&self, way: &Way, now: Millis) -> Option<Place> {
        let (direction, takes) = match self.stage {
            Stage::At(_) => (0.0, 1.0),
            Stage::Runs { way: Direction::Forward, millis, .. } => (1.0, seconds(Millis(millis.max(1)))),
            Stage::Runs { way: Direction::Reverse, millis, .. } => (-1.0, seconds(Millis(millis.max(1)))),
        };
        let motion = way.at(self.elapsed(now))?;
        Some(Place {
            position: way.begin + motion.position * way.range,
            velocity: direction * motion.velocity.unwrap_or(0.0) * way.range / takes,
        })
    }
}

impl Way {
    fn at(&self, elapsed: f64) -> Option<bezier::Motion> {
        let begun = self.segments.iter().rfind(|segment| segment.start() <= elapsed);
        begun.or(self.segments.first()).map(|segment| segment.at(elapsed))
    }

    /// Position of the motor at a part of the move.
    pub(super) fn position(&self, part: f64) -> Option<f64> {
        self.at(part).map(|motion| self.begin + motion.position * self.range)
    }
}
