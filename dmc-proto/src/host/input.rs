//! Inputs of a host's machine: what happened on its link, and what the application wants.

use motion_core::machine::Token;

use super::event::StopTarget;
use crate::frame::{Frame, MessageId, MessageType};
use crate::message::{DeviceMessage, HostMessage};
use crate::upload::Section;

/// Something that happened to a host.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Input<'a> {
    /// The link is open. If it was open before, that link counts as gone.
    LinkUp,
    /// The link is gone.
    LinkDown,
    /// A message arrived.
    Received(MessageId, DeviceMessage<'a>),
    /// A sound frame arrived whose data ends before the fields of its message do.
    Malformed(MessageId, MessageType),
    /// A frame with a wrong checksum arrived. The request that it answered is left to its timeout.
    Corrupt,
    /// The application wants something. Each command ends exactly once, by an [`Event::Ended`](super::Event::Ended) with
    /// its token.
    Command(Token, Command<'a>),
    /// The section that [`Event::NextSection`](super::Event::NextSection) asked for; `None` after the last one.
    Section(Option<Section>),
    /// The time of the last wake has come.
    Wake,
}

impl<'a> Input<'a> {
    /// Makes the input for a frame that arrived from the device.
    #[must_use]
    pub fn received(frame: &Frame<'a>) -> Self {
        match DeviceMessage::decode(frame) {
            Ok(message) => Self::Received(frame.id(), message),
            Err(_) => Self::Malformed(frame.id(), frame.kind()),
        }
    }
}

/// Something that the application wants.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Command<'a> {
    /// Greet the device again, after it was silent. Ends with [`Outcome::Sent`](super::Outcome::Sent).
    Greet,
    /// The device is configured: everything may be sent as soon as all requests are answered. Ends at once.
    Configured,
    /// Send a request. A stop is taken as [`Command::Stop`], also in [`Command::Sequence`].
    Request(HostMessage<'a>),
    /// Send the message that begins a sequence, and follow the sequence to its end. One sequence runs at a time.
    ///
    /// | message | followed |
    /// |---|---|
    /// | `RtUploadMoveBegin` | to the end of the upload |
    /// | `RtPositionFrame`, `RtJogAll` | until all motors rest |
    /// | `RtRunMove` | from the way to its first frame until all motors rest |
    /// | `RtShootFrame`, `RtShootFrame2` | until all motors rest; with a move that this host uploaded, from the way to the frame on |
    Sequence(HostMessage<'a>),
    /// Start the run or shot that is [armed](super::Event::Armed). Ends when it has started, or with the run or shot.
    Go,
    /// Stop. The stop is sent at once, before all that waits. Ends with [`Outcome::Sent`](super::Outcome::Sent), without a
    /// link with [`Outcome::NotConfirmed`](super::Outcome::NotConfirmed).
    Stop(StopTarget),
    /// Give up the stops that are not confirmed. Ends at once.
    EndStops,
}
