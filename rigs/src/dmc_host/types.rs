//! Commands to a host, and its events.

use dmc_proto::Token;
use dmc_proto::host::{self, Outcome, Refusal, StopTarget};
use dmc_proto::message::{
    BlurPercent, Degrees, DeviceMessage, Direction, FrameNumber, HostMessage, Milliseconds, MotorPair, Motors,
    MoveTime, RtShootFrame, RtShootFrame2, Scaled, Triggers,
};

use super::Table;

/// Command to the host.
///
/// A command with a token ends exactly once, by [`Event::Ended`]. The application chooses the token, and may use it again
/// after the end. The five greatest tokens are those of the host itself.
#[derive(Debug, Clone)]
pub enum Command {
    /// Greet the device again, after it was silent.
    Greet,
    /// Send a request.
    Ask(Token, HostMessage<'static>),
    /// Send the message that begins a sequence, and follow the sequence to its end: a way to a frame, a jog of all motors,
    /// a run.
    Begin(Token, HostMessage<'static>),
    /// Shoot a frame, and follow the shot to its end.
    Shoot(Token, Shot),
    /// Upload a move.
    Upload(Token, Table),
    /// Start the run or shot that is [armed](host::Event::Armed).
    Go,
    /// Stop, before everything else.
    Stop(StopTarget),
    /// Give up the stops that are not confirmed.
    EndStops,
}

/// Shot of a frame: motors move while the shutter is open.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shot {
    /// Frame to shoot.
    pub frame: FrameNumber,
    /// Time for which the shutter is open.
    pub exposure_ms: Milliseconds,
    /// Direction in which the motors move, for the first form.
    pub direction: Direction,
    /// Part of the way of a frame that the motors make, 0 for the whole way, for the first form.
    pub blur_x10: BlurPercent,
    /// Angle at which the shutter opens, for the second form.
    pub open_angle: Degrees,
    /// Angle at which the shutter closes, for the second form.
    pub close_angle: Degrees,
    /// Motors that move, with their positions at 0 and at 360 degrees. All other motors of an uploaded move rest on the
    /// frame.
    pub motors: Vec<MotorPair>,
    /// Whether the shot is sent as `MSG_RT_SHOOT_FRAME2`, for devices without the first form.
    pub is_second_form: bool,
}

impl Shot {
    /// Shot of a frame with motors at rest, in the first form.
    #[must_use]
    pub const fn of(frame: FrameNumber, exposure_ms: u32) -> Self {
        Self {
            frame,
            exposure_ms: Milliseconds(exposure_ms),
            direction: Direction::FORWARD,
            blur_x10: BlurPercent(Scaled(1000)),
            open_angle: Degrees(0),
            close_angle: Degrees(360),
            motors: Vec::new(),
            is_second_form: false,
        }
    }

    pub(super) fn message(&self) -> HostMessage<'_> {
        let Self { frame, direction, exposure_ms, blur_x10, open_angle, close_angle, ref motors, .. } = *self;
        if self.is_second_form {
            RtShootFrame2 { frame, exposure_ms, open_angle, close_angle, motors, tail: &[] }.into()
        } else {
            RtShootFrame { frame, direction, exposure_ms, blur_x10, motors, tail: &[] }.into()
        }
    }
}

/// Positions of the motors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Positions {
    /// Time in the move.
    pub moment: MoveTime,
    /// Steps of each motor, starting with motor 1.
    pub positions: Vec<i32>,
}

/// Answer of the device to a command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// The command is done.
    Done,
    /// Motors that move.
    Moving(Motors),
    /// Positions of the motors.
    Positions(Positions),
    /// Inputs that are on.
    Inputs(Triggers),
}

impl Answer {
    /// Answer that a message of the device gives.
    pub(super) fn of(message: &DeviceMessage<'_>) -> Self {
        match message {
            DeviceMessage::MotorStatus(status) => Self::Moving(status.motor_status),
            DeviceMessage::GioIn(inputs) => Self::Inputs(inputs.triggers),
            DeviceMessage::MotorGetPosition(told) => {
                let positions = told.positions.iter().map(|steps| steps.get()).collect();
                Self::Positions(Positions { moment: told.move_time, positions })
            }
            _ => Self::Done,
        }
    }
}

/// Event of the host.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Event {
    /// Event of the machine that lends no message, except the ends of commands.
    Machine(host::Event<'static>),
    /// The command with this token has ended: it is done, or has another outcome.
    ///
    /// After the end of a way along a move that this host uploaded, the host compares the positions of the motors with the
    /// end of the way. If they differ, the command ends as not confirmed.
    Ended(Token, Result<Answer, Outcome<'static>>),
    /// A command without a token was refused.
    Refused(Refusal),
    /// Positions that the device tells, asked or not.
    Positions(Positions),
    /// Inputs that are on. The device tells them by itself.
    Inputs(Triggers),
}
