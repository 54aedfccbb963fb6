//! Messages that a host sends, and all that follows from an input.

use motion_core::machine::{self, Token};

use motion_core::wire::EncodeError;

use super::event::{Event, StopTarget};
use super::options::{Options, PADDING, PADDING_PIECE};
use crate::frame::MessageId;
use crate::message::{FrameNumber, HiRequest, HostMessage, MotorStatusRequest, RtGo, RtPositionFrame, RtUploadMoveEnd};
use crate::upload::Section;

/// Message to send.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Transmit {
    /// Id of the message.
    pub id: MessageId,
    /// Contents of the message.
    pub contents: Contents,
}

/// Contents of a message that a host sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Contents {
    /// Question who the device is.
    Greeting,
    /// Question which motors move.
    Status,
    /// Stop of this target.
    Stop(StopTarget),
    /// Way to this frame, where a run begins.
    ToFrame(FrameNumber),
    /// Signal to start a run or shot.
    Go,
    /// End of an upload.
    UploadEnd,
    /// Message that the application holds.
    Application(Source),
    /// No message, but this number of zero bytes, at most 1024.
    ///
    /// A device that waits for the end of a frame that was cut off takes everything for a part of that frame. Zero bytes
    /// complete the frame, and no device takes them for a message (decision D-71).
    Padding(u16),
}

/// Place where the application finds a message that it holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// Message of the command with this token.
    Command(Token),
    /// Section of the move that is uploaded.
    Section(Section),
}

impl Transmit {
    /// Writes the bytes to send into `out`, and returns their number. They are the frame of a message, or padding. `find`
    /// makes the messages that the application holds, the same each time it is asked.
    ///
    /// No frame of this crate and no padding is longer than 1048 bytes.
    ///
    /// # Errors
    ///
    /// [`EncodeError`] as of [`HostMessage::encode_into`]. Then nothing is written.
    pub fn encode_into<'s>(
        &self,
        find: impl FnOnce(Source) -> HostMessage<'s>,
        out: &mut [u8],
    ) -> Result<usize, EncodeError> {
        if let Contents::Padding(len) = self.contents {
            let (needed, have) = (usize::from(len), out.len());
            let place = out.get_mut(..needed).ok_or(EncodeError::BufferTooSmall { needed, have })?;
            place.fill(0);
            return Ok(needed);
        }
        self.contents.message(find).encode_into(self.id, out)
    }

    /// Makes the message; `None` for padding. `find` makes the messages that the application holds, the same each time it
    /// is asked.
    pub fn message<'s>(&self, find: impl FnOnce(Source) -> HostMessage<'s>) -> Option<HostMessage<'s>> {
        let is_message = !matches!(self.contents, Contents::Padding(_));
        is_message.then(|| self.contents.message(find))
    }
}

impl Contents {
    /// The message with these contents. Padding counts as a greeting, which asks nothing of a device.
    pub(super) fn message<'s>(self, find: impl FnOnce(Source) -> HostMessage<'s>) -> HostMessage<'s> {
        match self {
            Self::Greeting | Self::Padding(_) => HiRequest::default().into(),
            Self::Status => MotorStatusRequest::default().into(),
            Self::Stop(target) => target.into(),
            Self::ToFrame(frame) => RtPositionFrame { frame, tail: &[] }.into(),
            Self::Go => RtGo::default().into(),
            Self::UploadEnd => RtUploadMoveEnd::default().into(),
            Self::Application(source) => find(source),
        }
    }
}

/// Greatest number of effects of one call:
///
/// - 4 stops, and 4 events that they are not confirmed;
/// - 12 requests of the application, which end or are sent: 4 under way and 8 that wait;
/// - 1 sequence that ends, with 1 signal to start;
/// - 1 greeting or question, after 2 pieces of padding;
/// - 1 event of the reason, or the end of the command itself.
pub const EFFECTS: usize = 26;

/// One thing that follows from an input.
pub type Effect<'a> = machine::Effect<Transmit, Event<'a>>;

/// All that follows from an input. A stop stands before all other effects.
pub type Output<'a> = machine::Output<Transmit, Event<'a>, EFFECTS>;

/// Adds a stop, before all effects that are not stops.
pub(super) fn transmit_stop(output: &mut Output<'_>, transmit: Transmit) {
    let is_stop =
        |effect: &Effect<'_>| matches!(effect, Effect::Transmit(Transmit { contents: Contents::Stop(_), .. }));
    let stops = output.effects.iter().take_while(|effect| is_stop(effect)).count();
    output.transmit(transmit);
    if let Some(rest) = output.effects.get_mut(stops..) {
        if rest.last().is_some_and(is_stop) {
            rest.rotate_right(1);
        }
    }
}

/// Adds zero bytes, as many as complete any frame that was cut off, and as the line carries in a time in milliseconds: the
/// next try does not have to wait for them.
pub(super) fn transmit_padding(output: &mut Output<'_>, options: &Options, millis: u32) {
    // A byte takes ten bits: one to start, eight of data, and one to stop.
    let fits = u64::from(options.line_speed()).saturating_mul(millis.into()) / 10_000;
    let mut left = u16::try_from(fits).unwrap_or(u16::MAX).min(PADDING);
    while left > 0 {
        let len = left.min(PADDING_PIECE);
        output.transmit(Transmit { id: MessageId::UNSOLICITED, contents: Contents::Padding(len) });
        left = left.saturating_sub(len);
    }
}
