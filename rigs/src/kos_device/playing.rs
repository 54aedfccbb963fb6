//! The move as the motors play it: where each is at any part of it.

use kos_proto::device::DeviceMachine;
use kos_proto::message::MotorAddress;
use kos_proto::summary::Direction;
use kos_proto::trajectory::{Trajectory, bezier};
use motion_core::time::Millis;

use crate::kos_host::StoredMove;
use crate::motor::Place;
use crate::seconds;

/// The ways of the motors of a move, and how far it is.
#[derive(Debug, Clone)]
pub(super) struct Playing {
    ways: Vec<Way>,
    /// Seconds that the move takes once.
    seconds: f64,
    pub(super) stage: Stage,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Stage {
    /// The motors go to this part of the move, or rest there.
    At(f64),
    /// They follow the curves.
    Runs { way: Direction, start: Millis, millis: u64 },
}

/// The way of a motor, over its range as it was when the move was made ready.
#[derive(Debug, Clone)]
pub(super) struct Way {
    pub(super) motor: MotorAddress,
    /// Curves in parts of the move and of the range, one behind the other.
    segments: Vec<bezier::Segment>,
    /// Where the range begins, as the rig counts, and how long it is.
    begin: f64,
    range: f64,
}

impl Playing {
    /// The stored move over the ranges that the machine knows. `rig` says where the machine takes a motor to be, as the
    /// rig counts.
    pub(super) fn new(
        stored: &StoredMove,
        machine: &DeviceMachine,
        rig: impl Fn(MotorAddress) -> Option<f32>,
    ) -> Option<Self> {
        let data = stored.data();
        let trajectory = Trajectory::new(&data).ok()?;
        let ways = trajectory.tracks().filter_map(|track| {
            let motor = MotorAddress(track.motor().number());
            let drive = machine.motor(motor)?;
            let (begin, end) = drive.range();
            // What the machine told the clients begins elsewhere than what the rig counts.
            let zero = f64::from(rig(motor)?) - f64::from(drive.position().0);
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

    /// How much of the move is over at a moment; on the way back it becomes less.
    pub(super) fn elapsed(&self, now: Millis) -> f64 {
        match self.stage {
            Stage::At(part) => part,
            Stage::Runs { way, start, millis } => {
                let part = (seconds(Millis(now.since(start))) / seconds(Millis(millis.max(1)))).min(1.0);
                if way == Direction::Forward { part } else { 1.0 - part }
            }
        }
    }

    /// Seconds of the move at a moment.
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

    /// Where a motor of it is at a moment, as the rig counts.
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

    /// Where a motor is at a part of the move.
    pub(super) fn position(&self, part: f64) -> Option<f64> {
        self.at(part).map(|motion| self.begin + motion.position * self.range)
    }
}
