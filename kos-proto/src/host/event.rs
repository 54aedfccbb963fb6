//! Events of a client machine.

use core::fmt;

use motion_core::wire::DecodeError;
use motion_core::{display, states};

use super::Token;
use super::input::Endpoint;
use crate::DeviceMessage;
use crate::frame::{MessageId, MessageType};
use crate::message::{
    ActionId, AuxInputs, Direction, ErrorCode, MotorAddress, Normalized, Photos, PlaybackState, Rotations,
};

/// Something that the application is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
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
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
pub enum StopTarget {
    /// Everything that the device moves.
    All,
    /// One motor.
    Motor(MotorAddress),
}

/// End of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum Refusal {
    /// There is no connection.
    #[error("there is no connection")]
    NotConnected,
    /// There is a connection already, or it is being made.
    #[error("there is a connection already")]
    Connected,
    /// The device is not ready, or locked.
    #[error("the device is not ready, or locked")]
    NotReady,
    /// A question of this kind, or a calibration, is not answered yet.
    #[error("a question of this kind, or a calibration, is not answered yet")]
    Busy,
    /// A stop is not confirmed yet.
    #[error("a stop is not confirmed yet")]
    Stopping,
    /// A move is made ready or runs, or is ready where none may be.
    #[error("a move is made ready or runs")]
    MoveRuns,
    /// Something moves.
    #[error("something moves")]
    Moves,
    /// No move is ready.
    #[error("no move is ready")]
    NoMove,
    /// The device has no such motor.
    #[error("the device has no such motor")]
    NoMotor,
    /// The begin of the range is not marked.
    #[error("the begin of the range is not marked")]
    NotMarked,
    /// A number is NaN, infinite, or not positive where it has to be.
    #[error("a number is NaN, infinite, or not positive where it has to be")]
    Number,
    /// There is no password over USB.
    #[error("there is no password over USB")]
    NoPassword,
    /// The position is outside the range that the device reported.
    #[error("the position is outside the range of the motor")]
    Outside,
    /// The device does not know the message that the command needs, and has done nothing. Firmware of another version may
    /// know it.
    #[error("the device does not know {}", Unknown(Some(*.id), *.action))]
    Unsupported {
        /// Id of the message.
        id: MessageId,
        /// Number of the action, if the message is one.
        action: Option<ActionId>,
    },
    /// The device refused the command with this error.
    #[error("the device refused: {0}")]
    Device(ErrorCode),
}

/// Reason why a command ended before it was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum Failure {
    /// No answer came in time.
    #[error("no answer")]
    NoAnswer,
    /// The device does not know the question.
    #[error("the device does not know the question")]
    Unsupported,
    /// The answer is cut short.
    #[error("the answer is cut short")]
    Malformed,
    /// The connection went down.
    #[error("the connection went down")]
    LinkDown,
    /// A stop ended the motion, from here or from elsewhere.
    #[error("a stop ended the motion")]
    Stopped,
    /// A later command to the same motor took the place of this one.
    #[error("a later command to the same motor took its place")]
    Superseded,
    /// The motor went off line.
    #[error("the motor went off line")]
    MotorOffline,
    /// The device says that the motor has no range.
    #[error("the device says that the motor has no range")]
    NoRange,
    /// The device began to play the move the other way, and is told to stop.
    #[error("the device began to play the move the other way")]
    OtherWay,
    /// The device reported this error meanwhile.
    #[error("the device reported an error: {0}")]
    Device(ErrorCode),
}

/// Reason why the connection is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
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

display! {
    Event<'_> {
        Connect(endpoint) => "connect to {endpoint}";
        LinkDown(reason) => "the connection is over: {reason}";
        Locked { wrong_password: false } => "the device wants a password";
        Locked { wrong_password: true } => "the password is wrong";
        Motors => "the motors are known";
        Ready { reconnected: false, ranges_void: false } => "the device can be used";
        Ready { reconnected: true, ranges_void: false } => "the device can be used again";
        Ready { ranges_void: true, .. } => "the device can be used, and is another one than expected";
        Ended { token, outcome } => "command {token}: {outcome}";
        Stopped(target) => "the stop of {target} is confirmed";
        StopNotConfirmed(target) => "the stop of {target} is not confirmed: use the emergency stop";
        DeadMan => "motors were stopped, because no command came while they were jogged";
        MotorRests(motor, position) => "motor {motor} rests at {position} rotations";
        MotorSlow(motor) => "motor {motor} does not rest in time";
        MotorOnline(motor, true) => "motor {motor} came";
        MotorOnline(motor, false) => "motor {motor} went";
        MotorChanged(motor) => "the range of motor {motor} changed";
        Move(progress) => "{progress}";
        Inputs(inputs) => "the inputs of the device are {inputs}";
        Error(code, MotorAddress::ALL) => "the device reported an error: {code}";
        Error(code, motor) => "the device reported an error of motor {motor}: {code}";
        Unsupported { id, action, .. } => "the device does not know {}", Unknown(*id, *action);
        Unsolicited(message) => "a message that answers nothing: {message}";
        Malformed(id, error) => "message {id}: {error}";
        Ignored => "the input means nothing at present";
    }

    StopTarget {
        All => "everything";
        Motor(motor) => "motor {motor}";
    }

    Outcome<'_> {
        Done(None) => "done";
        Done(Some(answer)) => "done: {answer}";
        Sent => "sent";
        Refused(refusal) => "refused: {refusal}";
        Failed(failure) => "failed: {failure}";
        NotConfirmed => "not confirmed";
    }

    LinkDownReason {
        Ended => "the device closed the connection, or was never there";
        Framing => "the bytes from the device are no stream of messages";
        NoAnswer => "the device did not answer what it is";
        Silence => "the device was silent for too long";
        Asked => "the application asked for it";
    }

    Move {
        Home => "the motors are where the move begins";
        Ready => "the move can be played";
        Slow => "the move takes long to get ready, or to begin";
        Countdown => "the move waits for its time";
        PreShoot => "photos before the move are taken";
        Running(direction) => "the move runs {direction}";
        Progress { state, elapsed, photos: None } => "the move is at {elapsed}: {state}";
        Progress { state, elapsed, photos: Some(photos) } => "the move is at {elapsed}, with {photos} photos: {state}";
        EndReached => "the move is at its end";
        PostShot => "photos after the move are taken";
        Finished { requested: false } => "the move is over";
        Finished { requested: true } => "the move was stopped";
        Failed(code) => "the move cannot be played, and is stopped: {code}";
        OtherWay => "the device plays the move the other way, and is told to stop";
        Refused => "the device refused something else because the move runs";
        Lost => "the connection is lost, and nobody knows what the move does";
        Found(state) => "the move was found again in the state {state}";
        Unexpected(state) => "the device told a state that does not fit: {state}";
    }
}

/// Message that the device does not know, as far as it sent it back.
struct Unknown(Option<MessageId>, Option<ActionId>);

impl fmt::Display for Unknown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self(_, Some(action)) => write!(f, "action {action}"),
            Self(Some(id), None) => write!(f, "message {id}"),
            Self(None, None) => f.write_str("a message"),
        }
    }
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
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
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

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn a_command_prints_how_it_ended_and_why() {
        let text = |outcome| Event::Ended { token: Token(7), outcome }.to_string();
        let unknown = |action| Outcome::Refused(Refusal::Unsupported { id: MessageId::ACTION, action });
        assert_eq!(text(unknown(None)), "command 7: refused: the device does not know message ACTION");
        let action = Some(ActionId::TAKE_PICTURE);
        assert_eq!(text(unknown(action)), "command 7: refused: the device does not know action TAKE_PICTURE");
        let failed = Outcome::Failed(Failure::Device(ErrorCode::FAULT));
        assert_eq!(text(failed), "command 7: failed: the device reported an error: FAULT");
    }

    #[test]
    fn an_error_names_its_motor_if_it_has_one() {
        let text = |motor| Event::Error(ErrorCode::RUNAWAY, motor).to_string();
        assert_eq!(text(MotorAddress(2)), "the device reported an error of motor 2: RUNAWAY");
        assert_eq!(text(MotorAddress::ALL), "the device reported an error: RUNAWAY");
    }

    #[test]
    fn a_move_prints_its_progress() {
        let at = |photos| Move::Progress { state: PlaybackState::START_FRAME, elapsed: Normalized(0.5), photos };
        assert_eq!(Event::Move(at(None)).to_string(), "the move is at 0.5: START_FRAME");
        assert_eq!(at(Some(Photos(3.0))).to_string(), "the move is at 0.5, with 3.0 photos: START_FRAME");
        assert_eq!(Move::Running(Direction::Reverse).to_string(), "the move runs in reverse");
    }
}
