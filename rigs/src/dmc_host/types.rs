//! What a host is told, and what it tells.

use dmc_proto::host::{Failure, Stop, Token};
use dmc_proto::message::{
    BlurPercent, Degrees, Direction, FrameNumber, Hi, HostMessage, Milliseconds, Motor, MotorPair, Motors, MoveTime,
    StopReason, Triggers,
};

use super::Table;

/// What the host is told to do. A token is the application's own name for what it asks, free again once that has ended;
/// the two greatest numbers are the host's.
#[derive(Debug, Clone)]
pub enum Command {
    /// Greet the device again, after it was silent.
    Greet,
    /// Ask for something: it is [done](Event::Done) or has [failed](Event::Failed).
    Ask(Token, HostMessage<'static>),
    /// Begin what takes a while and is followed to its end: a way to a frame, a jog of all motors, a run.
    Begin(Token, HostMessage<'static>),
    /// The same for a shot.
    Shoot(Token, Shot),
    /// Upload a move.
    Upload(Token, Table),
    /// Start the run or shot that is [ready](Event::Ready).
    Go,
    /// Stop, before all else.
    Stop(Stop),
    /// Give up stops that are not confirmed.
    EndStops,
}

/// A shot: motors move while the shutter is open.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shot {
    /// Which frame.
    pub frame: FrameNumber,
    /// How long the shutter is open.
    pub exposure_ms: Milliseconds,
    /// Which way the motors move; of the first form.
    pub direction: Direction,
    /// How much of the way of a frame the motors make, 0 for all of it; of the first form.
    pub blur_x10: BlurPercent,
    /// Where the shutter opens; of the second form.
    pub open_angle: Degrees,
    /// Where the shutter closes; of the second form.
    pub close_angle: Degrees,
    /// The motors that move, each with its ways at 0 and at 360 degrees. All others of an uploaded move rest on the frame.
    pub motors: Vec<MotorPair>,
    /// Whether it is sent as `MSG_RT_SHOOT_FRAME2`.
    pub is_second_form: bool,
}

impl Shot {
    /// A shot of a frame with motors at rest, in the first form.
    #[must_use]
    pub const fn of(frame: FrameNumber, exposure_ms: u32) -> Self {
        Self {
            frame,
            exposure_ms: Milliseconds(exposure_ms),
            direction: Direction::FORWARD,
            blur_x10: BlurPercent(motion_core::fixed::Scaled(1000)),
            open_angle: Degrees(0),
            close_angle: Degrees(360),
            motors: Vec::new(),
            is_second_form: false,
        }
    }
}

/// Where the motors are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Positions {
    /// Where in the move they are.
    pub moment: MoveTime,
    /// The steps of each motor, from motor 1.
    pub positions: Vec<i32>,
}

/// How something that was asked is answered.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// It is done.
    Done,
    /// These motors move.
    Moving(Motors),
    /// Here they are.
    Positions(Positions),
    /// These inputs are on.
    Inputs(Triggers),
}

/// What the host tells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Event {
    /// The device is known, and everything can be sent.
    Up(Hi<'static>),
    /// The device does not answer. [`Command::Greet`] tries again.
    NoAnswer,
    /// The line is gone, and all that was asked has failed.
    Closed,
    /// The device was reset: all that was asked has failed, uploads and what was set are forgotten.
    DeviceReset,
    /// What was asked is done. Of a way along a move that was uploaded here, the motors were asked whether they are where
    /// it ends; if they are not, it has failed as unclear.
    Done(Token, Answer),
    /// What was asked has failed.
    Failed(Token, Failure),
    /// The run or shot waits for [`Command::Go`], or for the operator.
    Ready(Token),
    /// The run or shot has begun.
    Started(Token),
    /// A pass of a loop is over.
    PassEnded(Token),
    /// The stop is obeyed.
    Stopped(Stop),
    /// A stop is not confirmed: whoever stands beside the rig has to press the emergency stop.
    StopNotConfirmed(Stop),
    /// The device stopped hard, and all that moves has failed.
    HardStop(StopReason, Option<Motor>),
    /// These motors move: asked by the host itself.
    Moving(Motors),
    /// The device tells where its motors are, asked or not.
    Positions(Positions),
    /// The device tells which inputs are on, unasked.
    Inputs(Triggers),
    /// What arrived cannot be read.
    Unreadable,
    /// What the host was told does not fit now.
    Ignored,
}
