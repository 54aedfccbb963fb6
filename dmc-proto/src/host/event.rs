//! Events of a host's machine: what the application is told.

use motion_core::display;
use motion_core::machine::Token;

use crate::frame::{MessageId, MessageType};
use crate::message::{
    AckCode, DeviceMessage, Hi, HostMessage, Motor, MotorFlags, MotorStop, MotorStopAll, Motors, StopFlags, StopReason,
    VirtStop, VirtualMotor,
};
use crate::upload::Section;

/// Something that the application is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum Event<'a> {
    /// The device said who it is. It can be configured now; nothing that moves is sent yet.
    Greeted(Hi<'static>),
    /// The device does not answer greetings. [`Command::Greet`](super::Command::Greet) tries again. A greeting that the
    /// device sends at boot is taken as well.
    Silent,
    /// Everything can be sent.
    Ready {
        /// Whether everything could be sent before, and the link or the device was lost since. Then do not move anything
        /// without a person's consent: nobody knows who stands beside the rig.
        reconnected: bool,
    },
    /// The link is gone. All requests and the sequence have ended.
    LinkDown,
    /// The device was reset: all requests and the sequence have ended, and the device has forgotten what was uploaded and
    /// configured.
    DeviceReset,
    /// A command has ended. Each command ends exactly once.
    Ended {
        /// Token of the command.
        token: Token,
        /// How the command ended.
        outcome: Outcome<'a>,
    },
    /// An upload wants its next section, by [`Input::Section`](super::Input::Section).
    NextSection {
        /// Token of the upload.
        token: Token,
        /// Section after which the next one comes; `None` if the first one is wanted.
        after: Option<Section>,
    },
    /// A section was given that no upload asked for. Nothing was done.
    SectionNotWanted,
    /// The run or shot with this token waits for [`Command::Go`](super::Command::Go), or for the operator.
    Armed(Token),
    /// The run or shot with this token has started.
    Started(Token),
    /// A pass of the loop with this token is over.
    PassEnded(Token),
    /// A stop is confirmed: the device said so, or the motors rest. After an acknowledgement motors may still come to rest;
    /// [`may_move`](super::HostMachine::may_move) says so until a status tells that nothing moves.
    Stopped(StopTarget),
    /// A stop was not confirmed after three tries, or there is no link to send it over. The machine goes on trying until
    /// the stop is confirmed, or given up by [`Command::EndStops`](super::Command::EndStops). Tell a person beside the
    /// rig to press the emergency stop.
    StopNotConfirmed(StopTarget),
    /// The device stopped everything hard, for this reason, because of this motor. All requests that move and the run, if
    /// there is one, have ended.
    HardStop(StopReason, Option<Motor>),
    /// These motors move: the device was asked, because a request that must not be repeated was not answered.
    Moving(Motors),
    /// A message arrived that answers nothing that is asked: positions and inputs that the device tells by itself, the
    /// start by an operator, the end of a run, a late answer.
    Unsolicited(MessageId, DeviceMessage<'a>),
    /// A frame arrived whose data ends before the fields of its message do. The request that it answered is left to its
    /// timeout.
    Malformed(MessageId, MessageType),
    /// A frame with a wrong checksum arrived.
    Corrupt,
}

impl Event<'_> {
    /// Returns the same event if it can be kept; `None` if it lends a message of the device.
    #[must_use]
    pub const fn to_static(&self) -> Option<Event<'static>> {
        Some(match *self {
            Self::Greeted(hi) => Event::Greeted(hi),
            Self::Silent => Event::Silent,
            Self::Ready { reconnected } => Event::Ready { reconnected },
            Self::LinkDown => Event::LinkDown,
            Self::DeviceReset => Event::DeviceReset,
            Self::Ended { token, outcome } => match outcome.to_static() {
                Some(outcome) => Event::Ended { token, outcome },
                None => return None,
            },
            Self::NextSection { token, after } => Event::NextSection { token, after },
            Self::SectionNotWanted => Event::SectionNotWanted,
            Self::Armed(token) => Event::Armed(token),
            Self::Started(token) => Event::Started(token),
            Self::PassEnded(token) => Event::PassEnded(token),
            Self::Stopped(target) => Event::Stopped(target),
            Self::StopNotConfirmed(target) => Event::StopNotConfirmed(target),
            Self::HardStop(reason, motor) => Event::HardStop(reason, motor),
            Self::Moving(motors) => Event::Moving(motors),
            Self::Unsolicited(..) => return None,
            Self::Malformed(id, kind) => Event::Malformed(id, kind),
            Self::Corrupt => Event::Corrupt,
        })
    }
}

/// End of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum Outcome<'a> {
    /// The device did it, or the command only concerned the machine. The message is the answer of the device, where it
    /// answered with more than an acknowledgement.
    ///
    /// A sequence that is done has come to rest. A device that stops hard says so once, and that message can be lost: who
    /// has to know whether a run came to its end compares the positions.
    Done(Option<DeviceMessage<'a>>),
    /// Sent, and the protocol has no answer to it. Events tell what comes of it: of a stop
    /// [`Event::Stopped`] or [`Event::StopNotConfirmed`], of a greeting [`Event::Greeted`] or [`Event::Silent`].
    Sent,
    /// The machine or the device refused the command, and it was not done.
    ///
    /// Of a sequence, the device may have refused a later request. The earlier ones are done: motors may have moved, and a
    /// run or shot [may still begin](super::HostMachine::is_armed), or its [shutter be
    /// open](super::HostMachine::may_have_shutter_open). If the device refused a run or a shot itself, the machine sends a
    /// silent stop of everything, because some devices keep what they refused (decision D-97).
    Refused(Refusal),
    /// Something else ended the command. If it had been sent, the device may have done it.
    Failed(Failure),
    /// Nobody knows whether the device did it. It was sent, and no answer came, or none that is clear; or it is a stop
    /// that waits for a link.
    ///
    /// After a run or a shot that is not confirmed, the machine sends a silent stop of everything (decision D-97).
    NotConfirmed,
}

impl Outcome<'_> {
    /// Returns the same end if it can be kept; `None` if it lends an answer of the device.
    #[must_use]
    pub const fn to_static(&self) -> Option<Outcome<'static>> {
        Some(match *self {
            Self::Done(None) => Outcome::Done(None),
            Self::Done(Some(_)) => return None,
            Self::Sent => Outcome::Sent,
            Self::Refused(refusal) => Outcome::Refused(refusal),
            Self::Failed(failure) => Outcome::Failed(failure),
            Self::NotConfirmed => Outcome::NotConfirmed,
        })
    }
}

/// Reason why a command was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum Refusal {
    /// There is no link.
    #[error("there is no link")]
    NotConnected,
    /// The device is not known, or not configured yet.
    #[error("the device is not known, or not configured yet")]
    NotReady,
    /// Too many requests wait, or another sequence runs, or the request would change which motors take part in it.
    #[error("the device or the machine is busy with something else")]
    Busy,
    /// A stop is not confirmed yet, and the message would move what has to stop.
    ///
    /// The message may also move all motors while the device may still have a run or a shot that failed. Send a stop of
    /// everything then, and try again after [`Event::Stopped`] (decision D-97).
    #[error("a stop is not confirmed yet, or has to come first")]
    Stopping,
    /// The command does not fit the state of the machine: no run is armed, or the device is greeted or configured already.
    #[error("the command does not fit the state of the machine")]
    Unexpected,
    /// The message does not fit the command: it belongs to a sequence, it begins none, or it is an acknowledgement.
    #[error("the message does not fit the command")]
    Misplaced,
    /// The message would move this motor, and no `MotorConfigure` with these flags was acknowledged on this link. Devices
    /// acknowledge such a move, and do not move the motor (decision D-76).
    #[error("motor {0} was not configured with the flags {1}")]
    NotConfigured(Motor, MotorFlags),
    /// The message moves all motors of the uploaded move, this motor is none of them, and no `MotorConfigure` without the
    /// flag enabled was acknowledged for it on this link. Some devices give such a motor a path of zeros, and move it to 0
    /// (decision D-84).
    #[error("motor {0} is not in the uploaded move, and was not switched off")]
    NotInMove(Motor),
    /// The message moves motors along the uploaded move, and the last upload of this host did not come to its end: a device
    /// that refused or lost its begin still has the move before (decision D-90). Upload the move again.
    #[error("the last upload did not come to its end")]
    MoveUnknown,
    /// The device would answer with this code, going by its greeting. Nothing was sent.
    #[error("the device would answer {0}")]
    WouldBeRefused(AckCode),
    /// The device answered with this code.
    #[error("the device answered {0}")]
    Device(AckCode),
}

/// Something that ended a command other than its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum Failure {
    /// No answer came to a question, after three tries.
    #[error("no answer")]
    NoAnswer,
    /// A stop called the command off.
    #[error("a stop called the command off")]
    Stopped,
    /// The device stopped everything hard.
    #[error("the device stopped everything hard")]
    HardStop,
    /// The device was reset.
    #[error("the device was reset")]
    DeviceReset,
    /// The link is gone.
    #[error("the link is gone")]
    LinkDown,
}

/// What a stop is to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum StopTarget {
    /// One motor. While a run, a shot or any other coordinated move is followed, or may still begin, this is a stop of
    /// everything, unless the motor is driven by hand (`MotorFlags::LIVE`).
    Motor(Motor),
    /// One virtual motor. A coordinated move makes this a stop of everything too.
    Virtual(VirtualMotor),
    /// Everything.
    All,
    /// Everything, without warnings of the device.
    AllSilent,
}

display! {
    Event<'_> {
        Greeted(hi) => "the device answered the greeting: {}", hi.name;
        Silent => "the device does not answer the greeting";
        Ready { reconnected: false } => "everything can be sent";
        Ready { reconnected: true } => "everything can be sent again, after the link or the device was lost";
        LinkDown => "the link is gone";
        DeviceReset => "the device was reset";
        Ended { token, outcome } => "command {token}: {outcome}";
        NextSection { token, .. } => "command {token}: the upload wants its next section";
        SectionNotWanted => "no upload asked for the section";
        Armed(token) => "command {token}: waits for the signal to start";
        Started(token) => "command {token}: started";
        PassEnded(token) => "command {token}: a pass of the loop is over";
        Stopped(target) => "the stop of {target} is confirmed";
        StopNotConfirmed(target) => "the stop of {target} is not confirmed: press the emergency stop";
        HardStop(reason, Some(motor)) => "the device stopped everything hard because of motor {motor}: {reason}";
        HardStop(reason, None) => "the device stopped everything hard: {reason}";
        Moving(motors) => "these motors move: {motors}";
        Unsolicited(id, message) => "message {id} answers nothing: {message}";
        Malformed(id, kind) => "message {id} of type {kind} is cut short";
        Corrupt => "a frame with a wrong checksum arrived";
    }

    Outcome<'_> {
        Done(None) => "done";
        Done(Some(answer)) => "done: {answer}";
        Sent => "sent";
        Refused(refusal) => "refused: {refusal}";
        Failed(failure) => "failed: {failure}";
        NotConfirmed => "not confirmed";
    }

    StopTarget {
        Motor(motor) => "motor {motor}";
        Virtual(motor) => "virtual motor {motor}";
        All => "everything";
        AllSilent => "everything, without warnings";
    }
}

impl StopTarget {
    /// The target of a message that is a stop.
    pub(super) fn of(message: &HostMessage<'_>) -> Option<Self> {
        match message {
            HostMessage::MotorStop(stop) => Some(Self::Motor(stop.motor)),
            HostMessage::VirtStop(stop) => Some(Self::Virtual(stop.virtual_motor)),
            HostMessage::MotorStopAll(stop) => {
                let silent = stop.flags.unwrap_or_default().contains(StopFlags::SILENT);
                Some(if silent { Self::AllSilent } else { Self::All })
            }
            _ => None,
        }
    }

    /// Whether everything is to stop.
    pub(super) const fn is_all(self) -> bool {
        matches!(self, Self::All | Self::AllSilent)
    }
}

impl From<StopTarget> for HostMessage<'static> {
    /// The stop as a message.
    fn from(target: StopTarget) -> Self {
        match target {
            StopTarget::Motor(motor) => MotorStop { motor, tail: &[] }.into(),
            StopTarget::Virtual(virtual_motor) => VirtStop { virtual_motor, tail: &[] }.into(),
            StopTarget::All => MotorStopAll { flags: None, tail: &[] }.into(),
            StopTarget::AllSilent => MotorStopAll { flags: Some(StopFlags::SILENT), tail: &[] }.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn a_command_prints_how_it_ended_and_why() {
        let text = |outcome| Event::Ended { token: Token(7), outcome }.to_string();
        assert_eq!(text(Outcome::Failed(Failure::NoAnswer)), "command 7: failed: no answer");
        assert_eq!(
            text(Outcome::Refused(Refusal::Device(AckCode::ERR_RANGE))),
            "command 7: refused: the device answered ERR_RANGE"
        );
        let refusal = Refusal::NotConfigured(Motor(2), MotorFlags::ENABLED);
        assert_eq!(refusal.to_string(), "motor 2 was not configured with the flags ENABLED");
        let answer = DeviceMessage::from(crate::message::MotorStatus { motor_status: Motors(5), ..Default::default() });
        assert_eq!(
            text(Outcome::Done(Some(answer))),
            "command 7: done: MotorStatus { motor_status: 1+3, dmx_status: no }"
        );
    }

    #[test]
    fn a_stop_prints_what_stops() {
        let event = Event::StopNotConfirmed(StopTarget::All);
        assert_eq!(event.to_string(), "the stop of everything is not confirmed: press the emergency stop");
        let event = Event::HardStop(StopReason::UPPER_LIMIT, Some(Motor(3)));
        assert_eq!(event.to_string(), "the device stopped everything hard because of motor 3: UPPER_LIMIT");
    }
}
