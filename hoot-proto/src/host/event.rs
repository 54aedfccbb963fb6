//! Events of a master: how commands ended, and what else happened.

use motion_core::display;
use motion_core::machine::Token;
use motion_core::wire::{EncodeError, Purpose};

use crate::frame::Address;
use crate::message::{DeviceMessage, HostMessage, Motor, Reply, ResponseCode};

/// Something that a master tells the application.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum Event<'a> {
    /// Everything can be sent from now on.
    Ready {
        /// Whether the line was up before. After a reconnect, move nothing without a new command of the operator: the
        /// state of the rig may have changed.
        reconnected: bool,
    },
    /// The line is down. Motors go on with what they do.
    LinkDown,
    /// A command ended. Each command ends once.
    Ended {
        /// Token of the command.
        token: Token,
        /// How the command ended.
        outcome: Outcome<'a>,
    },
    /// A reply that answers nothing that is asked: the second one to a request, one that comes late, or one whose value
    /// has another type than the query asks for.
    Unsolicited(Reply<'a>),
    /// A packet for another address: the echo of a request, or traffic of others on the bus.
    Overheard {
        /// Address of the receiver.
        to: Address,
        /// The message.
        message: DeviceMessage<'a>,
    },
    /// Bytes arrived that are no packet.
    Noise,
    /// A node did not answer a keep-alive. It is asked again; its dead-man may have stopped its motors.
    KeepAliveLost {
        /// Address of the node.
        to: Address,
    },
    /// An emergency stop began or was repeated. All other commands have ended.
    Stopping,
    /// A stop is confirmed: the node said OK to it, or, for [`StopTarget::All`], each motor of each listed node said that
    /// it rests and no program of these nodes may run that this master started.
    Stopped(StopTarget),
    /// A stop is not confirmed. Something may still move: cut the power.
    ///
    /// An emergency stop goes on until it is confirmed or ended.
    StopNotConfirmed(StopTarget),
}

impl Event<'_> {
    /// The event without its borrow, to be stored; `None` if it lends the bytes of a message.
    #[must_use]
    pub fn to_static(&self) -> Option<Event<'static>> {
        Some(match *self {
            Self::Ready { reconnected } => Event::Ready { reconnected },
            Self::LinkDown => Event::LinkDown,
            Self::Ended { token, outcome } => Event::Ended { token, outcome: outcome.to_static()? },
            Self::Unsolicited(_) | Self::Overheard { .. } => return None,
            Self::Noise => Event::Noise,
            Self::KeepAliveLost { to } => Event::KeepAliveLost { to },
            Self::Stopping => Event::Stopping,
            Self::Stopped(target) => Event::Stopped(target),
            Self::StopNotConfirmed(target) => Event::StopNotConfirmed(target),
        })
    }
}

/// Target of a stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum StopTarget {
    /// All nodes.
    All,
    /// One node, with its motors and its program.
    Node(Address),
    /// One motor of a node.
    Motor(Address, Motor),
}

display! {
    Event<'_> {
        Ready { reconnected: false } => "everything can be sent";
        Ready { reconnected: true } => "everything can be sent again, after the line was down";
        LinkDown => "the line is down";
        Ended { token, outcome } => "command {token}: {outcome}";
        Unsolicited(reply) => "a reply that answers nothing: {reply}";
        Overheard { to, message } => "a packet for address {to}: {message}";
        Noise => "bytes arrived that are no packet";
        KeepAliveLost { to } => "node {to} did not answer a keep-alive";
        Stopping => "an emergency stop began or was repeated";
        Stopped(target) => "the stop of {target} is confirmed";
        StopNotConfirmed(target) => "the stop of {target} is not confirmed: cut the power";
    }

    StopTarget {
        All => "all nodes";
        Node(to) => "node {to}";
        Motor(to, motor) => "motor {motor} of node {to}";
    }

    Outcome<'_> {
        Done(Reply { data: [], .. }) => "done";
        Done(reply) => "done: {reply}";
        Sent => "sent";
        Applied => "applied";
        Refused(refusal) => "refused: {refusal}";
        Failed(failure) => "failed: {failure}";
        NotConfirmed => "not confirmed";
    }
}

impl StopTarget {
    /// Target of a stop that is sent to this address.
    pub(super) fn of(to: Address, stop: &HostMessage<'_>) -> Self {
        match stop {
            HostMessage::MotorStop(stop) => Self::Motor(to, stop.motor),
            _ if to == Address::BROADCAST => Self::All,
            _ => Self::Node(to),
        }
    }
}

/// How a command ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum Outcome<'a> {
    /// The node did it. The query that was asked reads the value of the reply.
    Done(Reply<'a>),
    /// The message was sent, and no node answers it: a broadcast, command 0, or a stop while an emergency stop goes on.
    /// Events tell what follows.
    Sent,
    /// The command changed the machine itself, and nothing had to be sent for it.
    Applied,
    /// The command was not done, because the machine or the node refused it.
    Refused(Refusal),
    /// The command ended for another reason, and was not done.
    Failed(Failure),
    /// The message was sent, and no clear answer came: it may or may not have been done. Ask for the state; after a
    /// change of the address, ask at the new address (safety decision 1).
    ///
    /// Bridges drop replies that refuse, and later firmware is silent at commands that it does not know.
    NotConfirmed,
}

impl Outcome<'_> {
    /// The outcome without its borrow, to be stored; `None` if it lends the data of a reply.
    #[must_use]
    pub const fn to_static(&self) -> Option<Outcome<'static>> {
        Some(match *self {
            Self::Done(Reply { code, data: [] }) => Outcome::Done(Reply { code, data: &[] }),
            Self::Done(_) => return None,
            Self::Sent => Outcome::Sent,
            Self::Applied => Outcome::Applied,
            Self::Refused(why) => Outcome::Refused(why),
            Self::Failed(why) => Outcome::Failed(why),
            Self::NotConfirmed => Outcome::NotConfirmed,
        })
    }

    /// End of a message that no answer is awaited for any more: it may have been done, if it was sent and does more than
    /// ask.
    pub(super) fn unanswered(message: &HostMessage<'_>, was_sent: bool, why: Failure) -> Self {
        let asks = message.conduct().purpose == Purpose::Asks;
        if was_sent && !asks { Self::NotConfirmed } else { Self::Failed(why) }
    }
}

/// Why a command was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum Refusal {
    /// The line is down.
    #[error("the line is down")]
    NotConnected,
    /// There is no room for more: as many commands wait as the machine can hold.
    #[error("too many commands wait")]
    Busy,
    /// An emergency stop is under way.
    #[error("an emergency stop is under way")]
    Stopping,
    /// A bridge does not pass the message on (safety decision 4). Instead of a broadcast stop, each listed node is stopped
    /// (decision H-20).
    #[error("a bridge does not pass the message on")]
    Bridge,
    /// The message cannot go to this address: broadcasts go to 1, everything else to 2 to 255.
    #[error("the message cannot go to this address")]
    Address,
    /// The message cannot be written, or [`lint`](crate::lint) finds an error in it.
    #[error("the message is not valid: {0}")]
    Invalid(EncodeError),
    /// The node refused with this response code. It does not say why.
    #[error("the node refused with response code {0}")]
    Device(ResponseCode),
}

/// Why a command failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(motion_core::defmt::Format), defmt(crate = motion_core::defmt))]
#[non_exhaustive]
pub enum Failure {
    /// No answer came in time to a message that only asks.
    #[error("no answer")]
    NoAnswer,
    /// A stop removed the command before it was sent, or ended the wait for the answer of a query.
    #[error("a stop called the command off")]
    Stopped,
    /// A newer command took its place before it was sent: another speed of the same motor, or the same stop.
    #[error("a newer command took its place")]
    Superseded,
    /// The line went down before the command was sent, or before the answer of a query came.
    #[error("the line went down")]
    LinkDown,
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn a_command_prints_how_it_ended_and_why() {
        let text = |outcome| Event::Ended { token: Token(7), outcome }.to_string();
        assert_eq!(text(Outcome::Done(Reply::OK)), "command 7: done");
        assert_eq!(
            text(Outcome::Refused(Refusal::Device(ResponseCode::ERROR))),
            "command 7: refused: the node refused with response code ERROR"
        );
        let done = Outcome::Done(Reply { code: ResponseCode::OK, data: &[0, 4] });
        assert_eq!(text(done), "command 7: done: Reply { response_code: OK, value_type: BYTE, value: 4 }");
    }

    #[test]
    fn a_stop_prints_what_stops() {
        let event = Event::Stopped(StopTarget::Motor(Address(3), Motor::Two));
        assert_eq!(event.to_string(), "the stop of motor 2 of node 3 is confirmed");
    }
}
