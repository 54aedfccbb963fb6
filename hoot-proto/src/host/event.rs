//! What comes out of a master: packets, and what became of requests.

use arrayvec::ArrayVec;
use motion_core::lint::Lint;
use motion_core::wire::EncodeError;

use super::Token;
use crate::frame::{Address, MAX_DATA};
use crate::message::{HostMessage, Motor, Reply, ResponseCode};

/// A packet to send.
///
/// Drop what has arrived and is not yet read before it is written, with `reset` of the stream: it cannot be an answer to
/// it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Send {
    /// Whom it is for.
    pub to: Address,
    /// What it says.
    pub message: HostMessage<'static>,
}

impl Send {
    /// Writes its whole packet to the front of `out`, and says how many bytes it took: at most 42.
    ///
    /// # Errors
    ///
    /// [`EncodeError::BufferTooSmall`]; the machine has looked at all else.
    pub fn encode_into(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        self.message.encode_into(self.to, out)
    }
}

/// A reply that is kept.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Received {
    code: ResponseCode,
    data: ArrayVec<u8, MAX_DATA>,
}

impl Received {
    /// Keeps a reply, of whose data no more than a packet of a node can hold.
    pub(super) fn new(reply: Reply<'_>) -> Self {
        Self { code: reply.code, data: reply.data.iter().copied().take(MAX_DATA).collect() }
    }

    /// The reply, for the query that asked for it.
    #[must_use]
    pub fn reply(&self) -> Reply<'_> {
        Reply { code: self.code, data: &self.data }
    }
}

/// What happened.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Event {
    /// A request has come to its end: each does, once.
    Ended {
        /// Which one.
        token: Token,
        /// How.
        outcome: Outcome,
    },
    /// A reply that nobody waits for: the second one to a request, or one that comes late, or has another type than
    /// what was asked for.
    Unsolicited(Received),
    /// A packet that is not for the master: its own echo, or traffic of others on the bus.
    Overheard {
        /// Whom it is for.
        to: Address,
    },
    /// Bytes arrived that are no packet.
    Noise,
    /// The speed of a motor was not set: the node refused it, or the machine did not take it.
    SpeedFailed {
        /// The node.
        to: Address,
        /// The motor.
        motor: Motor,
        /// Why.
        why: Failure,
    },
    /// A node did not answer a keep-alive. It is asked again; its motors may have been stopped by its dead-man.
    KeepAliveLost {
        /// The node.
        to: Address,
    },
    /// An emergency stop is under way. All requests have ended.
    Stopping,
    /// Each motor of each listed node says that it rests: the emergency stop is over.
    StopConfirmed,
    /// A stop is not confirmed. Something may still move: cut the power.
    ///
    /// An emergency stop goes on all the same, until it is confirmed or ended.
    StopNotConfirmed {
        /// The node; none in an emergency stop, which is for all.
        node: Option<Address>,
    },
    /// The application has ended an emergency stop that is not confirmed.
    EmergencyEnded,
    /// A command that the machine did not take: a list of nodes during an emergency stop, or one keep-alive too many.
    NotTaken(NotTaken),
}

/// How a request ended.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Outcome {
    /// The node did it, and perhaps said something, which the query reads.
    Done(Received),
    /// The node refused. It never says why.
    Refused(Received),
    /// It was sent, and nobody answers it: a broadcast, command 0, or a stop in the middle of an emergency stop.
    Sent,
    /// There is no answer, and will be none.
    Failed(Failure),
}

/// Why there is no answer to a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Failure {
    /// Nothing came in time. The node may have done it, may not know the command, or may have refused it: bridges lose
    /// that answer. Ask for the state; behind a change of address, ask at the new one (safety decision 1).
    Silence,
    /// It was dropped.
    Dropped {
        /// Why.
        why: Dropped,
        /// Whether it was sent, and may have been done.
        was_sent: bool,
    },
    /// It was never taken, and not sent.
    NotTaken(NotTaken),
    /// The node refused it with this code.
    Refused(ResponseCode),
}

/// Why a request was dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Dropped {
    /// A stop came.
    Stop,
    /// The same stop came again, and is sent in its place.
    Again,
    /// An emergency stop came.
    Emergency,
    /// The line has gone.
    Link,
}

/// Why something was not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum NotTaken {
    /// There is no room for more.
    Full,
    /// There is no line.
    Link,
    /// An emergency stop is under way.
    Emergency,
    /// A bridge does not pass it on (safety decision 4). In place of a stop, each listed node is stopped (decision H-20).
    Bridge,
    /// It is not for this address: broadcasts go to 1, all else to 2 to 255.
    Address,
    /// It has more data than a node has room for.
    TooLong,
    /// It cannot be written, as a message kept as it came that nodes take for another; `encode_into` says why.
    Encode,
    /// It is an error; lint says which.
    Lint(Lint),
}
