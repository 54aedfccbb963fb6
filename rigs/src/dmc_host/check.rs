//! Check at the end of a way: are the motors where the move says?
//!
//! A device tells of a hard stop once, and that message can be lost. Then a run that ended by a hard stop looks like one
//! that is complete. So the host compares the positions with the uploaded move before it reports the way as done.

use dmc_proto::Token;
use dmc_proto::message::{Direction, FrameNumber, HostMessage, Motor, MotorPair, RunFlags};
use dmc_proto::upload::MoveSource;

use super::{Positions, Table};

/// Greatest difference between a motor and the move, in steps. Some devices cut off the fraction of a position.
pub const TOLERANCE: u32 = 1;

/// Way that has ended, until the positions of its motors are known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Check {
    pub(super) token: Token,
    /// Frames at which the way may end.
    ends: Vec<FrameNumber>,
    /// Motors that went a way of their own.
    others: Vec<Blur>,
}

/// Way of a motor in a shot, and the steps that it has gone on it at least and at most when it rests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Blur {
    pair: MotorPair,
    /// Whether the motor may have gone the way from its end to its begin.
    is_backward: bool,
    least: i64,
    most: i64,
}

impl Blur {
    /// Way of a motor while the shutter is open for a time in milliseconds, from the begin up to a part of it at least.
    /// After it, the motor comes to rest in a second or less.
    fn new(pair: MotorPair, is_backward: bool, part: (i64, i64), exposure: u32) -> Self {
        let whole = i64::from(pair.pos_a().0.abs_diff(pair.pos_b().0));
        let rolls = whole * 1000 / i64::from(exposure.max(1));
        Self { pair, is_backward, least: whole * part.0 / part.1, most: whole + rolls }
    }

    /// Whether the motor rests where the way can have led it.
    fn holds(self, here: i32) -> bool {
        let (a, b) = (i64::from(self.pair.pos_a().0), i64::from(self.pair.pos_b().0));
        let (here, tolerance) = (i64::from(here), i64::from(TOLERANCE));
        let fits = |gone: i64| (self.least - tolerance..=self.most + tolerance).contains(&gone);
        fits((here - a) * (b - a).signum()) || (self.is_backward && fits((here - b) * (a - b).signum()))
    }
}

impl Check {
    /// Check for the end of the way of this message; `None` if the message does not move motors along a move.
    pub(super) fn of(token: Token, message: &HostMessage<'_>) -> Option<Self> {
        let (ends, others) = match message {
            HostMessage::RtPositionFrame(message) => (vec![message.frame], Vec::new()),
            HostMessage::RtJogAll(message) => (vec![message.destination], Vec::new()),
            HostMessage::RtRunMove(message) => {
                let (start, end) = (message.start_frame, message.end_frame);
                let beyond = |frame: FrameNumber, by| FrameNumber(frame.0.saturating_add(by));
                // Some devices rest one frame after the last one, also after a run backwards.
                let mut ends = vec![end, beyond(end, 1)];
                if end < start {
                    ends.push(beyond(end, -1));
                }
                // A run back and forth ends at either of its frames.
                if message.flags.unwrap_or_default().contains(RunFlags::PING_PONG) {
                    ends.extend([start, beyond(start, 1)]);
                }
                (ends, Vec::new())
            }
            HostMessage::RtShootFrame(message) => {
                let part = if message.blur_x10.0.0 == 0 { 1000 } else { message.blur_x10.0.0.min(1000) };
                let is_backward = message.direction == Direction::BACKWARD;
                let blur = |pair: &MotorPair| Blur::new(*pair, is_backward, (part.into(), 1000), message.exposure_ms.0);
                (vec![message.frame], message.motors.iter().map(blur).collect())
            }
            HostMessage::RtShootFrame2(message) => {
                let part = (message.close_angle.0.into(), 360);
                let blur = |pair: &MotorPair| Blur::new(*pair, false, part, message.exposure_ms.0);
                (vec![message.frame], message.motors.iter().map(blur).collect())
            }
            _ => return None,
        };
        Some(Self { token, ends, others })
    }

    /// Whether the motors are where the move has them at its end. A motor that blurred may have returned to its frame.
    pub(super) fn holds(&self, positions: Option<&Positions>, table: &Table) -> bool {
        let places = positions.map(|positions| &positions.positions[..]).unwrap_or_default();
        let at = |motor: Motor| usize::from(motor.0).checked_sub(1).and_then(|index| places.get(index)).copied();
        let own = |motor: Motor| self.others.iter().find(|blur| blur.pair.motor() == motor);
        let has_blurred = |motor: Motor| own(motor).is_some_and(|blur| at(motor).is_some_and(|here| blur.holds(here)));
        let is_there = |frame: FrameNumber| {
            table.motors().iter().all(|motor| {
                let both = at(motor).zip(table.steps(motor, table.nearest(frame)));
                both.is_some_and(|(here, there)| here.abs_diff(there) <= TOLERANCE) || has_blurred(motor)
            })
        };
        let strangers =
            self.others.iter().map(|blur| blur.pair.motor()).filter(|motor| !table.motors().contains(*motor));
        self.ends.iter().any(|end| is_there(*end)) && strangers.into_iter().all(has_blurred)
    }
}
