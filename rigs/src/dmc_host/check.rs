//! Check at the end of a way: are the motors where the move says?
//!
//! A device tells of a hard stop once, and that message can be lost. Then a run that ended by a hard stop looks like one
//! that is complete. So the host compares the positions with the uploaded move before it reports the way as done.

use dmc_proto::Token;
use dmc_proto::message::{FrameNumber, HostMessage, Motor, MotorPair, RunFlags};
use dmc_proto::upload::MoveSource;

use super::{Positions, Table};

/// Greatest difference between a motor and the move, in steps.
const TOLERANCE: u32 = 1;

/// Way that has ended, until the positions of its motors are known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Check {
    pub(super) token: Token,
    /// Frames at which the way may end. A run back and forth ends at either of its frames.
    ends: [FrameNumber; 2],
    /// Motors that went a way of their own.
    others: Vec<Motor>,
}

impl Check {
    /// Check for the end of the way of this message; `None` if the message does not move motors along a move.
    pub(super) fn of(token: Token, message: &HostMessage<'_>) -> Option<Self> {
        let others = |pairs: &[MotorPair]| pairs.iter().map(MotorPair::motor).collect();
        let (ends, others) = match message {
            HostMessage::RtPositionFrame(message) => ([message.frame; 2], Vec::new()),
            HostMessage::RtJogAll(message) => ([message.destination; 2], Vec::new()),
            HostMessage::RtRunMove(message) => {
                let is_ping_pong = message.flags.unwrap_or_default().contains(RunFlags::PING_PONG);
                let other_end = if is_ping_pong { message.start_frame } else { message.end_frame };
                ([message.end_frame, other_end], Vec::new())
            }
            HostMessage::RtShootFrame(message) => ([message.frame; 2], others(message.motors)),
            HostMessage::RtShootFrame2(message) => ([message.frame; 2], others(message.motors)),
            _ => return None,
        };
        Some(Self { token, ends, others })
    }

    /// Whether the motors are where the move has them at its end.
    pub(super) fn holds(&self, positions: Option<&Positions>, table: &Table) -> bool {
        let places = positions.map(|positions| &positions.positions[..]).unwrap_or_default();
        let at = |motor: Motor| usize::from(motor.0).checked_sub(1).and_then(|index| places.get(index));
        let is_there = |frame: FrameNumber| {
            table.motors().iter().filter(|motor| !self.others.contains(motor)).all(|motor| {
                let both = at(motor).zip(table.steps(motor, frame));
                both.is_some_and(|(here, there)| here.abs_diff(there) <= TOLERANCE)
            })
        };
        self.ends.into_iter().any(is_there)
    }
}
