//! Inputs of a device machine.

use core::fmt;
use core::net::SocketAddrV4;

use motion_core::wire::{DecodeError, Password};

use super::clients::SessionId;
use crate::HostMessage;
use crate::frame::{Frame, MessageId, MessageType};
use crate::message::{AuxInputs, ErrorCode, Ipv4, MotorAddress, Rotations};
use crate::transport::Transport;

/// Something that happened to a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Input<'a> {
    /// A client is connected, under a number that the caller chooses. An earlier connection of that number is gone.
    LinkUp {
        /// Number of the connection.
        session: SessionId,
        /// Transport of the connection.
        transport: Transport,
        /// Password that is stored at present.
        password: Password<'a>,
    },
    /// A client is gone.
    LinkDown(SessionId),
    /// A client sent a message.
    Received {
        /// Number of the connection.
        session: SessionId,
        /// The message.
        message: HostMessage<'a>,
        /// Bytes of the message from its version byte on. The device sends them back if it does not know the message.
        bytes: &'a [u8],
        /// Password that is stored at present.
        password: Password<'a>,
    },
    /// A client sent a message that ends before its fields do.
    Malformed {
        /// Number of the connection.
        session: SessionId,
        /// Id of the message.
        id: MessageId,
        /// Type of the message.
        kind: MessageType,
        /// Error of the decoder.
        error: DecodeError,
        /// Bytes of the message from its version byte on. The device sends them back.
        bytes: &'a [u8],
    },
    /// The bytes from a client are no stream of messages: a `Fatal` item (safety decision 6).
    Fatal(SessionId),
    /// A datagram came.
    Datagram {
        /// Address of the sender.
        from: Sender,
        /// The message.
        message: HostMessage<'a>,
    },
    /// A person at the device wants everything to stop.
    Stop,
    /// The rig reports what happened to it.
    Rig(Report),
    /// The time of the last wake has come.
    Wake,
}

/// Message of a frame. It is decoded in one place, because the code for all messages is long.
#[inline(never)]
pub(super) fn message<'a>(frame: &Frame<'a>) -> Result<HostMessage<'a>, DecodeError> {
    HostMessage::decode(frame)
}

impl<'a> Input<'a> {
    /// Input for a frame from a client: [`Received`](Self::Received), or [`Malformed`](Self::Malformed).
    #[must_use]
    pub fn received(session: SessionId, frame: &Frame<'a>, password: Password<'a>) -> Self {
        let bytes = frame.bytes();
        match message(frame) {
            Ok(message) => Self::Received { session, message, bytes, password },
            Err(error) => Self::Malformed { session, id: frame.id(), kind: frame.kind(), error, bytes },
        }
    }
}

/// Sender of a datagram: its address in the network, and its port.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Sender {
    /// Address in the network.
    pub address: Ipv4,
    /// Port.
    pub port: u16,
}

impl fmt::Display for Sender {
    /// Writes address and port, such as `192.168.50.7:5520`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.address, self.port)
    }
}

impl fmt::Debug for Sender {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Sender({self})")
    }
}

impl From<SocketAddrV4> for Sender {
    fn from(sender: SocketAddrV4) -> Self {
        Self { address: (*sender.ip()).into(), port: sender.port() }
    }
}

impl From<Sender> for SocketAddrV4 {
    fn from(Sender { address, port }: Sender) -> Self {
        Self::new(address.into(), port)
    }
}

/// Report of the rig. Positions are counted as the rig counts, from anywhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Report {
    /// The device runs and can be connected to.
    Started,
    /// A motor on its way is at this position.
    At(MotorAddress, Rotations),
    /// A motor rests at this position: where it was sent, or where it was stopped.
    ///
    /// The rig reports it of every motor that was told to move, stop or go home, or to the next place of a move, also if
    /// the motor did not have to move. It may also report it of a motor that is off line, and while the device starts anew.
    Arrived(MotorAddress, Rotations),
    /// A motor cannot get to where the move begins.
    CannotHome(MotorAddress),
    /// A motor has a fault: `RUNAWAY`, `FAULT` and the like.
    Fault(MotorAddress, ErrorCode),
    /// A motor is there, or not any more.
    Online(MotorAddress, bool),
    /// An input changed; these are all inputs.
    Inputs(AuxInputs),
}
