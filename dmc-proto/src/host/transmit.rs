//! Messages that a host sends, and all that follows from an input.

use motion_core::machine::{self, Token};

use super::event::{Event, StopTarget};
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
    /// Makes the message. `find` makes those that the application holds, the same each time it is asked.
    pub fn message<'s>(&self, find: impl FnOnce(Source) -> HostMessage<'s>) -> HostMessage<'s> {
        self.contents.message(find)
    }
}

impl Contents {
    /// The message with these contents.
    pub(super) fn message<'s>(self, find: impl FnOnce(Source) -> HostMessage<'s>) -> HostMessage<'s> {
        match self {
            Self::Greeting => HiRequest::default().into(),
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
/// - 1 greeting or question;
/// - 1 event of the reason, or the end of the command itself.
pub const EFFECTS: usize = 24;

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
