//! Whether a way is done, or only over.
//!
//! A device tells of a hard stop once, and that may be lost; then a run that ended by it looks like one that went well. So
//! the end of each way along an uploaded move is held against that move before it is told as done.

use dmc_proto::host::{Failure, Token};
use dmc_proto::message::{FrameNumber, HostMessage, Motor, MotorPair, RunFlags};
use dmc_proto::upload::MoveSource;

use super::{Positions, Table};

/// Steps that a motor may be off.
const OFF: i64 = 1;

/// A way that is over, until it is known where its motors are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Check {
    pub(super) token: Token,
    /// Where it ends; a run there and back ends at either.
    ends: [FrameNumber; 2],
    /// Motors that went another way.
    others: Vec<Motor>,
}

impl Check {
    /// What has to hold at the end of this; `None` if it is no way along a move.
    pub(super) fn of(token: Token, message: &HostMessage<'_>) -> Option<Self> {
        let mut others = Vec::new();
        let ends = match message {
            HostMessage::RtPositionFrame(message) => [message.frame; 2],
            HostMessage::RtJogAll(message) => [message.destination; 2],
            HostMessage::RtRunMove(message) if message.flags.unwrap_or_default().contains(RunFlags::PING_PONG) => {
                [message.start_frame, message.end_frame]
            }
            HostMessage::RtRunMove(message) => [message.end_frame; 2],
            HostMessage::RtShootFrame(message) => {
                others.extend(message.motors.iter().map(MotorPair::motor));
                [message.frame; 2]
            }
            HostMessage::RtShootFrame2(message) => {
                others.extend(message.motors.iter().map(MotorPair::motor));
                [message.frame; 2]
            }
            _ => return None,
        };
        Some(Self { token, ends, others })
    }

    /// Whether the motors are where the move has them at its end.
    pub(super) fn holds(&self, positions: Option<&Positions>, table: &Table) -> Result<(), Failure> {
        let places = positions.map(|positions| &positions.positions[..]).unwrap_or_default();
        let at = |motor: Motor| usize::from(motor.0).checked_sub(1).and_then(|index| places.get(index));
        let is_near = |here: i32, there: i32| (i64::from(here) - i64::from(there)).abs() <= OFF;
        let is_there = |frame: FrameNumber| {
            table.motors().iter().filter(|motor| !self.others.contains(motor)).all(|motor| {
                at(motor).zip(table.steps(motor, frame)).is_some_and(|(here, there)| is_near(*here, there))
            })
        };
        if self.ends.into_iter().any(is_there) { Ok(()) } else { Err(Failure::Unclear) }
    }
}
