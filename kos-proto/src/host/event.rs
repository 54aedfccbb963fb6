//! Events of a client machine.

use motion_core::states;
use motion_core::wire::DecodeError;

use super::Token;
use super::input::Endpoint;
use crate::DeviceMessage;
use crate::frame::{MessageId, MessageType};
use crate::message::{
    ActionId, AuxInputs, Direction, ErrorCode, MotorAddress, Normalized, Photos, PlaybackState, Rotations,
};

/// Something that the application is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Event<'a> {
    /// Connect to this device, then give in `LinkUp` or `LinkDown`.
    Connect(Endpoint),
    /// The connection is over. Close it if it is not closed.
    LinkDown(LinkDownReason),
    /// The device wants a password. It may ignore stops until it gets the right one: if a stop is wanted,
    /// `StopNotConfirmed` follows at once.
    Locked {
        /// Whether the device said that the password is wrong. Otherwise it did not answer after the password.
        wrong_password: bool,
    },
    /// The motors are known, or known anew.
    Motors,
    /// The device can be used.
    Ready {
        /// Whether the device could be used before on an earlier connection. Do not move anything unasked then: nobody
        /// expects the rig to go on by itself after a power cut.
        reconnected: bool,
        /// Whether the device or its platform is another one than expected, so that ranges that the application stored
        /// mean nothing (safety decision 9).
        ranges_void: bool,
    },
    /// A command ended. Each command ends once.
    Ended {
        /// Token of the command.
        token: Token,
        /// How the command ended.
        outcome: Outcome<'a>,
    },
    /// A stop is confirmed: the device obeyed, and what was to stop rests.
    Stopped(StopTarget),
    /// A stop is not confirmed in time. Use the emergency stop of the rig.
    ///
    /// The stop is sent again until the device obeys it. If the connection went down, the next one begins with it. It may be
    /// confirmed later.
    StopNotConfirmed(StopTarget),
    /// Motors were stopped because the application gave no command while it jogged them.
    DeadMan,
    /// A motor rests at this position, as reported.
    MotorRests(MotorAddress, Rotations),
    /// A motor was sent somewhere and does not rest in time: it is slow, or the report was lost. Until it is stopped it
    /// is taken to move.
    MotorSlow(MotorAddress),
    /// A motor came or went.
    MotorOnline(MotorAddress, bool),
    /// The range of a motor changed, or is void.
    MotorChanged(MotorAddress),
    /// Progress of the move on the device.
    Move(Move),
    /// Inputs of the device, after one changed.
    Inputs(AuxInputs),
    /// The device reported an error, about this motor or about none.
    Error(ErrorCode, MotorAddress),
    /// The device does not know a message that was sent. Parts that the device did not send back are `None`.
    Unsupported {
        /// Id of the message.
        id: Option<MessageId>,
        /// Type of the message.
        kind: Option<MessageType>,
        /// Number of the action, if the message was one.
        action: Option<ActionId>,
    },
    /// The device sent a message that answers nothing that is asked.
    Unsolicited(DeviceMessage<'a>),
    /// The device sent a message that ends before its fields do.
    Malformed(MessageId, DecodeError),
    /// The input means nothing at present.
    Ignored,
}

impl<'a> Event<'a> {
    pub(super) const fn ended(token: Token, outcome: Outcome<'a>) -> Self {
        Self::Ended { token, outcome }
    }

    /// The same event without a borrow, to be stored; `None` if it lends a message.
    #[must_use]
    pub fn to_static(&self) -> Option<Event<'static>> {
        Some(match *self {
            Self::Connect(endpoint) => Event::Connect(endpoint),
            Self::LinkDown(reason) => Event::LinkDown(reason),
            Self::Locked { wrong_password } => Event::Locked { wrong_password },
            Self::Motors => Event::Motors,
            Self::Ready { reconnected, ranges_void } => Event::Ready { reconnected, ranges_void },
            Self::Ended { token, outcome } => Event::Ended { token, outcome: outcome.to_static()? },
            Self::Stopped(target) => Event::Stopped(target),
            Self::StopNotConfirmed(target) => Event::StopNotConfirmed(target),
            Self::DeadMan => Event::DeadMan,
            Self::MotorRests(motor, position) => Event::MotorRests(motor, position),
            Self::MotorSlow(motor) => Event::MotorSlow(motor),
            Self::MotorOnline(motor, online) => Event::MotorOnline(motor, online),
            Self::MotorChanged(motor) => Event::MotorChanged(motor),
            Self::Move(progress) => Event::Move(progress),
            Self::Inputs(inputs) => Event::Inputs(inputs),
            Self::Error(code, motor) => Event::Error(code, motor),
            Self::Unsupported { id, kind, action } => Event::Unsupported { id, kind, action },
            Self::Unsolicited(_) => return None,
            Self::Malformed(id, error) => Event::Malformed(id, error),
            Self::Ignored => Event::Ignored,
        })
    }
}

/// Target of a stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StopTarget {
    /// Everything that the device moves.
    All,
    /// One motor.
    Motor(MotorAddress),
}

/// End of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Outcome<'a> {
    /// The command is done; with the answer of the device if it was a question.
    ///
    /// The answer to [`Get::MotorInfo`](super::Get::MotorInfo) is the last message of a series; the motors of all are in
    /// [`HostMachine::motors`](super::HostMachine::motors).
    Done(Option<DeviceMessage<'a>>),
    /// The command was sent, and the protocol has no answer to it. Events tell what follows.
    Sent,
    /// The command is not done, because the machine or the device refused it.
    Refused(Refusal),
    /// The command was ended by something else.
    Failed(Failure),
    /// The command was sent, and no clear answer came: it may or may not have been done.
    NotConfirmed,
}

impl Outcome<'_> {
    /// The same outcome without a borrow, to be stored; `None` if it lends an answer.
    #[must_use]
    pub const fn to_static(&self) -> Option<Outcome<'static>> {
        Some(match *self {
            Self::Done(Some(_)) => return None,
            Self::Done(None) => Outcome::Done(None),
            Self::Sent => Outcome::Sent,
            Self::Refused(why) => Outcome::Refused(why),
            Self::Failed(why) => Outcome::Failed(why),
            Self::NotConfirmed => Outcome::NotConfirmed,
        })
    }
}

/// Reason why a command is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Refusal {
    /// There is no connection.
    NotConnected,
    /// There is a connection already, or it is being made.
    Connected,
    /// The device is not ready, or locked.
    NotReady,
    /// A question of this kind, or a calibration, is not answered yet.
    Busy,
    /// A stop is not confirmed yet.
    Stopping,
    /// A move is made ready or runs, or is ready where none may be.
    MoveRuns,
    /// Something moves.
    Moves,
    /// No move is ready.
    NoMove,
    /// The device has no such motor.
    NoMotor,
    /// The begin of the range is not marked.
    NotMarked,
    /// A number is NaN, infinite, or not positive where it has to be.
    Number,
    /// There is no password over USB.
    NoPassword,
    /// The position is outside the range that the device reported.
    Outside,
    /// The device does not know the message that the command needs, and has done nothing. Firmware of another version may
    /// know it.
    Unsupported {
        /// Id of the message.
        id: MessageId,
        /// Number of the action, if the message is one.
        action: Option<ActionId>,
    },
    /// The device refused the command with this error.
    Device(ErrorCode),
}

/// Reason why a command ended before it was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Failure {
    /// No answer came in time.
    NoAnswer,
    /// The device does not know the question.
    Unsupported,
    /// The answer is cut short.
    Malformed,
    /// The connection went down.
    LinkDown,
    /// A stop ended the motion, from here or from elsewhere.
    Stopped,
    /// A later command to the same motor took the place of this one.
    Superseded,
    /// The motor went off line.
    MotorOffline,
    /// The device says that the motor has no range.
    NoRange,
    /// The device began to play the move the other way, and is told to stop.
    OtherWay,
    /// The device reported this error meanwhile.
    Device(ErrorCode),
}

/// Reason why the connection is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum LinkDownReason {
    /// The device closed the connection, or it was never there.
    Ended,
    /// The bytes from the device are no stream of messages.
    Framing,
    /// The device did not answer what it is.
    NoAnswer,
    /// The device was silent for too long.
    Silence,
    /// The application asked for it.
    Asked,
}

states! {
    /// State of the move on the device, as far as the device told it.
    #[derive(Default)]
    pub enum MoveState {
        /// The device has no move of this client.
        #[default]
        NoMove,
        /// The move is being made ready.
        SettingUp,
        /// The move can be played.
        Armed,
        /// The move was told to begin.
        Starting,
        /// The move waits for its time.
        Delay,
        /// Photos before the move are taken.
        PreShoot,
        /// The move runs.
        Running,
        /// The move is at its end; a loop or photos may follow.
        Ended,
        /// The move was told to stop, and not all of that is confirmed.
        Stopping,
    }
}

impl MoveState {
    /// Whether the device may move something because of the move.
    #[must_use]
    pub const fn moves(self) -> bool {
        !matches!(self, Self::NoMove | Self::Armed)
    }

    /// Whether the device said that it plays the move, and not yet that all is over.
    #[must_use]
    pub const fn runs(self) -> bool {
        matches!(self, Self::Delay | Self::PreShoot | Self::Running | Self::Ended)
    }
}

/// Progress of a move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Move {
    /// The motors are where the move begins.
    Home,
    /// The move can be played.
    Ready,
    /// The move takes long to get ready, or to begin.
    Slow,
    /// The move waits for its time.
    Countdown,
    /// Photos before the move are taken.
    PreShoot,
    /// The move runs in this direction.
    Running(Direction),
    /// The device told how far the move is.
    Progress {
        /// State that the device told.
        state: PlaybackState,
        /// Part of the move that is over.
        elapsed: Normalized,
        /// Number of photos taken in the move, if the device told it.
        photos: Option<Photos>,
    },
    /// The move is at its end; a loop or photos may follow.
    EndReached,
    /// Photos after the move are taken.
    PostShot,
    /// The move is over, and the device forgot it.
    Finished {
        /// Whether this client stopped the move.
        requested: bool,
    },
    /// The move cannot be played because of this error, and is stopped.
    Failed(ErrorCode),
    /// The device plays the move from its end to its begin although it should play it forward. It is told to stop.
    OtherWay,
    /// The device refused something else because the move runs.
    Refused,
    /// The connection is lost, and nobody knows what the move does.
    Lost,
    /// The move was found again after a lost connection, in this state.
    Found(MoveState),
    /// The device told a state that does not fit.
    Unexpected(PlaybackState),
}
