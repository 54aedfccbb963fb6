//! Move files for DMC motors.

use dmc_proto::message::{FrameNumber, FramesPerSecond, Motor, MotorPair, Motors, Steps};
use dmc_proto::upload::MoveSource;
use examples::moves::Move;
use rigs::dmc_host::{Shot, Table};

use crate::drive::Trouble;

/// Move as it is uploaded. The first frame of its file is frame 1.
#[derive(Debug)]
pub(super) struct Plan {
    pub(super) table: Table,
    pub(super) first: FrameNumber,
    pub(super) last: FrameNumber,
    pub(super) rate: FramesPerSecond,
}

impl Plan {
    pub(super) fn new(file: &str, read: &Move) -> Result<Self, Trouble> {
        let refused = |why: String| Trouble::Refused(format!("{file}: {why}"));
        let mut excesses = read.excesses();
        if let Some(excess) = excesses.next() {
            let more = excesses.count();
            let more = if more == 0 { String::new() } else { format!(", and {more} more") };
            return Err(refused(format!("{excess}{more}: make the move slower, or its \"limits\" wider")));
        }
        let first = FrameNumber(1);
        let mut table = Table::new(first, read.frames.count);
        for axis in &read.axes {
            let Some(dmc) = axis.dmc else { continue };
            let steps = axis.curve().steps(read.frames, dmc.scale).collect::<Result<Vec<_>, _>>();
            let steps = steps.map_err(|error| refused(format!("axis {:?}: {error}", axis.name)))?;
            table = table.with(Motor(dmc.motor), steps);
        }
        if table.motors() == Motors::NONE {
            return Err(refused(
                "no axis has a DMC motor: give one \"dmc\": { \"motor\": 1, \"steps_per_unit\": ... }".to_owned(),
            ));
        }
        let rate = read.frames.rate.to_milli().map_err(|error| refused(format!("\"rate\": {error}")))?;
        let last = table.last_frame();
        Ok(Self { table, first, last, rate: FramesPerSecond(rate) })
    }

    /// Motors of the move.
    pub(super) fn motors(&self) -> Motors {
        self.table.motors()
    }

    /// Photo `number` of `of` photos along the move. While the shutter is open, the motors rest, or with `moves` they
    /// move as from this frame to the next one. At the last frame they move as from the frame before.
    pub(super) fn shot(&self, number: u32, of: u32, exposure: u32, moves: bool) -> Shot {
        let frames = i64::from(self.last.0) - i64::from(self.first.0);
        let index = if of > 1 { frames * i64::from(number) / i64::from(of - 1) } else { 0 };
        let at = |index: i64| i32::try_from(i64::from(self.first.0) + index).map_or(self.last, FrameNumber);
        let frame = at(index);
        let mut shot = Shot::of(frame, exposure);
        if moves {
            let way = |motor: Motor| {
                let steps = |index: i64| self.table.steps(motor, at(index)).unwrap_or_default();
                let here = steps(index);
                let next = if index < frames {
                    steps(index + 1)
                } else {
                    here.saturating_mul(2).saturating_sub(steps((index - 1).max(0)))
                };
                MotorPair::new(motor, Steps(here), Steps(next))
            };
            shot.motors = self.motors().iter().map(way).collect();
        }
        shot
    }
}
