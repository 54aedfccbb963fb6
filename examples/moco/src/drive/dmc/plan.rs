//! Move files for DMC motors.

use dmc_proto::message::{FrameNumber, FramesPerSecond, Motor, MotorPair, Motors, Steps};
use dmc_proto::upload::MoveSource;
use motion_move::{Excess, ExcessKind, Move, dmc};
use motion_rigs::dmc_host::{Shot, Table};

use super::ROLL;
use crate::drive::Trouble;

/// Move as it is uploaded. The first frame of its file is frame 1.
#[derive(Debug)]
pub(super) struct Plan {
    pub(super) table: Table,
    pub(super) first: FrameNumber,
    pub(super) last: FrameNumber,
    pub(super) rate: FramesPerSecond,
    /// Number of steps that an upload sends. Rests at the end of the move are not sent.
    pub(super) sent: u32,
}

impl Plan {
    pub(super) fn new(file: &str, read: &Move) -> Result<Self, Trouble> {
        let refused = |why: String| Trouble::Refused(format!("{file}: {why}"));
        let mut excesses = read.excesses().filter(|excess| !is_rolled(read, excess));
        if let Some(excess) = excesses.next() {
            let more = excesses.count();
            let more = if more == 0 { String::new() } else { format!(", and {more} more") };
            return Err(refused(format!("{excess}{more}: make the move slower, or its \"limits\" wider")));
        }
        let converted = dmc::convert(read).map_err(|why| refused(why.to_string()))?;
        let (first, count) = (converted.start_frame(), converted.frame_count());
        let mut table = Table::new(first, count);
        let mut sent = 0_u32;
        for motor in converted.motors().iter() {
            let steps: Vec<i32> = (0..count).map(|index| converted.position(motor, index).0).collect();
            let rest = steps.iter().rev().take_while(|at| Some(*at) == steps.last()).skip(1).count();
            sent = u32::try_from(steps.len() - rest).map_or(u32::MAX, |steps| steps.saturating_add(sent));
            table = table.with(motor, steps);
        }
        let last = table.last_frame();
        Ok(Self { table, first, last, rate: converted.rate(), sent })
    }

    /// Motors of the move.
    pub(super) fn motors(&self) -> Motors {
        self.table.motors()
    }

    /// Photo `number` of `of` photos along the move. While the shutter is open, the motors rest, or with `moves` they
    /// move as they do around this frame (decision D-88).
    pub(super) fn shot(&self, number: u32, of: u32, exposure: u32, moves: bool) -> Shot {
        let frames = i64::from(self.last.0) - i64::from(self.first.0);
        let index = if of > 1 { frames * i64::from(number) / i64::from(of - 1) } else { 0 };
        let at = |index: i64| i32::try_from(i64::from(self.first.0) + index).map_or(self.last, FrameNumber);
        let frame = at(index);
        let mut shot = Shot::of(frame, exposure);
        if moves {
            // The shutter is open from half a frame before the frame to half a frame after it, within the move.
            let way = |motor: Motor| {
                let steps = |index: i64| self.table.steps(motor, at(index.clamp(0, frames))).unwrap_or_default();
                let between = |index: i64| Steps(steps(index).midpoint(steps(index + 1)));
                MotorPair::new(motor, between(index - 1), between(index))
            };
            shot.motors = self.motors().iter().map(way).collect();
        }
        shot
    }
}

/// Tolerance of a velocity, as a part of it.
const ROUNDING: f64 = 1e-6;

/// Whether a run reaches the velocity at an end of the move in its pre-roll, or comes to rest in its post-roll, within
/// the limits of the axis. It does so only at the first and at the last frame.
fn is_rolled(read: &Move, excess: &Excess<'_>) -> bool {
    let (axis, last) = (excess.axis, read.frames().count.saturating_sub(1));
    let (jump, is_outer) = match excess.kind {
        ExcessKind::Start(jump) => (jump, axis.curve().start() <= read.frames().time(0)),
        ExcessKind::End(jump) => (jump, axis.curve().end() >= read.frames().time(last)),
        _ => return false,
    };
    let most = axis.limits().map(|limits| limits.acceleration * f64::from(ROLL) / 1000.0 * (1.0 + ROUNDING));
    axis.dmc().is_some() && is_outer && jump.zip(most).is_some_and(|(jump, most)| jump.abs() <= most)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Verdict about a straight move of 2 s and 60 mm.
    fn verdict(keys: &str, duration: &str, acceleration: f64) -> Result<(), String> {
        let text = format!(
            r#"{{
                "move": 1, "name": "Straight", "rate": 24, {duration}
                "axes": [{{
                    "name": "Slide", "unit": "mm",
                    "limits": {{ "velocity": 40, "acceleration": {acceleration} }},
                    "keys": [{keys}],
                    "dmc": {{ "motor": 1, "steps_per_unit": 80 }}
                }}]
            }}"#
        );
        Plan::new("straight.json", &Move::parse("", &text).unwrap()).map(|_| ()).map_err(|trouble| trouble.to_string())
    }

    fn linear(time: f64, position: f64) -> String {
        format!(r#"{{ "time": {time}, "position": {position}, "ease": "linear" }}"#)
    }

    /// D-88
    #[test]
    fn a_motor_blurs_from_half_a_frame_before_to_half_a_frame_after() {
        let first = FrameNumber(1);
        let table = Table::new(first, 5).with(Motor(1), vec![0, 100, 200, 400, 600]);
        let (last, rate) = (table.last_frame(), FramesPerSecond::default());
        let plan = Plan { table, first, last, rate, sent: 0 };
        let ways = [(0, 50), (50, 150), (150, 300), (300, 500), (500, 600)];
        for ((number, frame), (from, to)) in (0..).zip(1..).zip(ways) {
            let shot = plan.shot(number, 5, 100, true);
            assert_eq!(shot.frame, FrameNumber(frame));
            assert_eq!(shot.motors, [MotorPair::new(Motor(1), Steps(from), Steps(to))]);
        }
    }

    #[test]
    fn only_the_rolls_of_a_run_replace_rests() {
        let straight = |from: f64| [linear(from, 0.0), linear(from + 2.0, 60.0)].join(",");
        // In half a second, the motor reaches 30 mm/s with 60 mm/s².
        assert_eq!(verdict(&straight(0.0), "", 60.0), Ok(()));
        let hard = verdict(&straight(0.0), "", 59.0).unwrap_err();
        assert!(hard.contains("a corner at 0 s, velocity jumps by 30 mm/s, from the rest before it"), "{hard}");
        // The rest is a part of the move, so the jump is in its frames.
        let late = verdict(&straight(1.0), "", 60.0).unwrap_err();
        assert!(late.contains("a corner at 1 s"), "{late}");
        let early = verdict(&straight(0.0), "\"duration\": 3,", 60.0).unwrap_err();
        assert!(early.contains("a corner at 2 s") && early.contains("to the rest after it"), "{early}");
        let written = [linear(0.0, 0.0), linear(1.0, 0.0), linear(3.0, 60.0), linear(4.0, 60.0)].join(",");
        assert!(verdict(&written, "", 60.0).unwrap_err().contains("a corner at 1 s"));
    }
}
